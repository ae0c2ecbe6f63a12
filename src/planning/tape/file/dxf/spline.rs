//! Splines (NURBS) as points. Each span between two knots is made into a Bézier curve, whose points are means of its
//! control points; it is halved until these are near enough to its chord. So the bound is kept by construction, not by
//! sampling.

use nalgebra::Vector4;

use super::curve::Pen;
use super::fields::Fields;
use crate::planning::finding::Code;
use crate::planning::geometry::{Point3, Vector3};
use crate::planning::tape::file::faults::Fault;
use crate::planning::tolerance::CURVE_CHORD_MM;

/// The highest degree. CAD systems write 2 to 5, and up to 25 at the most.
const HIGHEST_DEGREE: usize = 25;
/// Weights may differ by so much; beyond that no digits are left of the curve.
const SMALLEST_WEIGHT: f64 = 1e-6;
/// As [`SMALLEST_WEIGHT`].
const LARGEST_WEIGHT: f64 = 1e6;
/// So often a span is halved at most: then it is shorter than rounding.
const MOST_HALVINGS: u32 = 40;

/// A control point times its weight, and the weight.
type Weighted = Vector4<f64>;

struct Spline {
    degree: usize,
    knots: Vec<f64>,
    control: Vec<Weighted>,
}

/// Draws the spline of an entity from its first to its last point.
pub(super) fn draw(fields: &Fields<'_>, pen: &mut Pen<'_>) -> Result<(), Fault> {
    let spline = read(fields)?;
    let spans =
        (spline.degree..spline.control.len()).filter(|&span| spline.knots[span] < spline.knots[span + 1]);
    let mut begun = false;
    for span in spans {
        let bezier = spline.bezier(span);
        if !begun {
            pen.to(place(&bezier[0]), fields.line())?;
            begun = true;
        }
        flatten(&bezier, MOST_HALVINGS, fields.line(), pen)?;
    }
    if begun { Ok(()) } else { Err(fields.fault(Code::OutOfRange, "its knots span nothing".to_owned())) }
}

fn read(fields: &Fields<'_>) -> Result<Spline, Fault> {
    let degree = usize::try_from(fields.flags(71)?).unwrap_or(0);
    let (mut knots, mut weights, mut control) = (Vec::new(), Vec::new(), Vec::<Point3>::new());
    for pair in &fields.record.pairs {
        match (pair.code, control.last_mut()) {
            (40, _) => knots.push(fields.number_of(pair)?),
            (41, _) => weights.push(fields.number_of(pair)?),
            (10, _) => control.push(Point3::new(fields.length_of(pair)?, f64::NAN, 0.0)),
            (20, Some(last)) => last.y = fields.length_of(pair)?,
            (30, Some(last)) => last.z = fields.length_of(pair)?,
            _ => {}
        }
    }
    if weights.is_empty() {
        weights = vec![1.0; control.len()];
    }
    check(fields, degree, &knots, &weights, &control)?;
    let weighted = |(point, weight): (&Point3, &f64)| (point.coords * *weight).push(*weight);
    Ok(Spline { degree, knots, control: control.iter().zip(&weights).map(weighted).collect() })
}

fn check(
    fields: &Fields<'_>,
    degree: usize,
    knots: &[f64],
    weights: &[f64],
    control: &[Point3],
) -> Result<(), Fault> {
    let refuse = |code, words: String| Err(fields.fault(code, words));
    if control.is_empty() && fields.has(11) {
        return refuse(
            Code::NotSupported,
            "a spline given by its fit points alone is not understood".to_owned(),
        );
    }
    if !(1..=HIGHEST_DEGREE).contains(&degree) {
        return refuse(
            Code::OutOfRange,
            format!("its degree is {degree}; 1 to {HIGHEST_DEGREE} are allowed"),
        );
    }
    let (points, needed) = (control.len(), control.len() + degree + 1);
    if points <= degree || knots.len() != needed || weights.len() != points {
        let message = format!(
            "it has {points} control points, {} knots and {} weights; degree {degree} needs {} control points at \
             least, {needed} knots, and a weight for each control point or none",
            knots.len(),
            weights.len(),
            degree + 1
        );
        return refuse(Code::WrongCount, message);
    }
    if control.iter().any(|point| point.y.is_nan()) {
        return refuse(Code::MissingField, "a control point has x (group 10) and no y (20)".to_owned());
    }
    if knots.windows(2).any(|pair| pair[0] > pair[1]) {
        return refuse(Code::OutOfRange, "its knots fall".to_owned());
    }
    if !weights.iter().all(|weight| (SMALLEST_WEIGHT..=LARGEST_WEIGHT).contains(weight)) {
        let message = format!("a weight does not lie between {SMALLEST_WEIGHT} and {LARGEST_WEIGHT}");
        return refuse(Code::OutOfRange, message);
    }
    Ok(())
}

impl Spline {
    /// The Bézier points of the span between two knots: the values of its polar form at the two knots, each
    /// repeated (Ramshaw 1989).
    fn bezier(&self, span: usize) -> Vec<Weighted> {
        let (from, to) = (self.knots[span], self.knots[span + 1]);
        (0..=self.degree).map(|ends| self.polar(span, |round| if round < ends { to } else { from })).collect()
    }

    /// De Boor's recursion with an argument of its own in each round.
    fn polar(&self, span: usize, argument: impl Fn(usize) -> f64) -> Weighted {
        let mut points: Vec<Weighted> = self.control[span - self.degree..=span].to_vec();
        for round in 0..self.degree {
            let u = argument(round);
            for i in (round + 1..=self.degree).rev() {
                let low = self.knots[span - self.degree + i];
                let high = self.knots[span + i - round];
                let part = (u - low) / (high - low);
                points[i] = points[i - 1] * (1.0 - part) + points[i] * part;
            }
        }
        points[self.degree]
    }
}

/// Draws a Bézier curve from behind its first point to its last.
fn flatten(bezier: &[Weighted], halvings: u32, line: u32, pen: &mut Pen<'_>) -> Result<(), Fault> {
    let places: Vec<Point3> = bezier.iter().map(place).collect();
    let last = places[places.len() - 1];
    let farthest = places.iter().map(|point| distance(point, &places[0], &last)).fold(0.0, f64::max);
    if halvings == 0 || farthest * inner_share(bezier) <= CURVE_CHORD_MM {
        return pen.to(last, line);
    }
    let (first, second) = halves(bezier);
    flatten(&first, halvings - 1, line, pen)?;
    flatten(&second, halvings - 1, line, pen)
}

/// The largest share that the control points between the ends have in a point of the curve: 1 - 2^(1 - degree) of the
/// Bernstein polynomials, weighted. The ends lie on the chord, so that the curve leaves it by no more than this share
/// of what the farthest control point does.
fn inner_share(bezier: &[Weighted]) -> f64 {
    let last = bezier.len() - 1;
    let polynomials = 1.0 - 0.5_f64.powi(last as i32 - 1);
    let inner = bezier[1..last].iter().map(|point| point.w).fold(0.0, f64::max) * polynomials;
    inner / (inner + bezier[0].w.min(bezier[last].w) * (1.0 - polynomials))
}

/// De Casteljau's halving.
fn halves(bezier: &[Weighted]) -> (Vec<Weighted>, Vec<Weighted>) {
    let (mut points, mut first, mut second) = (bezier.to_vec(), Vec::new(), Vec::new());
    while let (Some(&low), Some(&high)) = (points.first(), points.last()) {
        first.push(low);
        second.push(high);
        points = points.windows(2).map(|pair| (pair[0] + pair[1]) / 2.0).collect();
    }
    second.reverse();
    (first, second)
}

fn place(weighted: &Weighted) -> Point3 {
    Point3::from(weighted.xyz() / weighted.w)
}

fn distance(point: &Point3, from: &Point3, to: &Point3) -> f64 {
    let chord: Vector3 = to - from;
    let squared = chord.norm_squared();
    let t = if squared > 0.0 { ((point - from).dot(&chord) / squared).clamp(0.0, 1.0) } else { 0.0 };
    (point - (from + chord * t)).norm()
}
