//! Strokes: what a knife does between going down and coming up.
//!
//! A chain becomes one stroke, or several where it turns more sharply than the blade may turn in the material.
//! Its points are thinned to the chord tolerance and written in machine coordinates: x is the reading of the
//! tape axis at which the knife stands over the point.

use super::chain::Chain;
use super::label::CourseLabel;
use super::machine::{Cutter, Edges};
use crate::planning::geometry::Point2;
use crate::planning::geometry::simplify::kept;
use crate::planning::program::number::rounded;
use crate::planning::tolerance::{BLADE_BLEND_DEG, CORNER_MM};

/// Decimals of mm and degrees in a program: a tenth of a micron, far below what any axis resolves.
pub const DECIMALS: usize = 4;

/// A point of a stroke.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Knot {
    /// Reading of the tape axis in mm, rounded to [`DECIMALS`].
    pub x: f64,
    /// Carriage in mm, rounded to [`DECIMALS`].
    pub v: f64,
    /// Blade in degrees on the segment that begins here; the last knot repeats that of the last segment.
    /// Continuous along the stroke; the whole stroke may be turned by a period of the blade. Of an axis beside its edge
    /// it is the blade at the knot, and turns evenly from one to the next.
    pub blade_deg: f64,
}

/// Corners no farther apart than this, in mm, are one: so that no rounding makes them one only where they are judged.
const SAME_CORNER_MM: f64 = CORNER_MM + 0.001;

/// What a knife does between going down and coming up.
#[derive(Debug, Clone, PartialEq)]
pub struct Stroke {
    /// What its course is called.
    pub course: CourseLabel,
    /// Which piece of the course it is of, from 0. Where that lies would not tell: two may lie at one offset on the roll.
    pub piece: usize,
    /// Reading of the tape axis in mm at which the knife stands over u = 0 of its piece.
    pub x_of_u0: f64,
    /// At least two knots, x never decreasing.
    pub knots: Vec<Knot>,
}

/// After this turn a blade is as before: a double-edged one cuts both ways.
#[must_use]
pub fn period_deg(edges: Edges) -> f64 {
    match edges {
        Edges::Single => 360.0,
        Edges::Double => 180.0,
    }
}

/// The strokes of a chain of a piece, the index of which in its course is given, in the order in which its knife makes
/// them.
///
/// `x_of_u0` is the reading of the tape axis at which the knife stands over u = 0 of the piece.
#[must_use]
pub fn strokes(
    chain: &Chain,
    (course, piece): (CourseLabel, usize),
    cutter: &Cutter,
    x_of_u0: f64,
    tolerance_mm: f64,
) -> Vec<Stroke> {
    // An axis beside its edge leads in the direction of the cut, which half a turn changes.
    let period = if cutter.swivels() { 360.0 } else { period_deg(cutter.edges) };
    let segments = segments(&thinned(chain, tolerance_mm), period);
    let mut strokes: Vec<Stroke> = Vec::new();
    // How far the blade has turned in its corner, in degrees, and how far it has cut since it last turned, in mm.
    let (mut turned_deg, mut since_mm) = (0.0, 0.0);
    let mut last_blade: Option<f64> = None;
    for segment in segments {
        let place = |point: &Point2| (rounded(x_of_u0 - point.x, DECIMALS), rounded(point.y, DECIMALS));
        let ((x0, v0), (x1, v1)) = (place(&segment.from), place(&segment.to));
        if (x0, v0) == (x1, v1) {
            continue;
        }
        let blade_deg = rounded(segment.blade_deg, DECIMALS);
        let turn_deg = last_blade.map_or(f64::INFINITY, |last: f64| (blade_deg - last).abs());
        turned_deg = if since_mm > SAME_CORNER_MM { turn_deg } else { turned_deg + turn_deg };
        if turn_deg > BLADE_BLEND_DEG {
            since_mm = 0.0;
        }
        since_mm += (x1 - x0).hypot(v1 - v0);
        if turned_deg > cutter.lift_angle.degrees() {
            (turned_deg, since_mm) = (0.0, f64::INFINITY);
            strokes.push(Stroke { course, piece, x_of_u0, knots: vec![Knot { x: x0, v: v0, blade_deg }] });
        }
        if let Some(stroke) = strokes.last_mut() {
            if let Some(last) = stroke.knots.last_mut() {
                last.blade_deg = blade_deg;
            }
            stroke.knots.push(Knot { x: x1, v: v1, blade_deg });
        }
        last_blade = Some(blade_deg);
    }
    strokes
}

/// The points of a chain, thinned. What making it monotone has used of the tolerance is not there for that.
#[must_use]
pub fn thinned(chain: &Chain, tolerance_mm: f64) -> Vec<Point2> {
    let kept = kept(&chain.points, tolerance_mm - chain.shift_mm);
    kept.into_iter().map(|index| chain.points[index]).collect()
}

struct Segment {
    from: Point2,
    to: Point2,
    blade_deg: f64,
}

/// The segments with their blade angles gamma = atan2(dU, dV) from the V direction (domain.md A5), each turned
/// the shortest way from the one before; the first within half a period of 0.
fn segments(points: &[Point2], period: f64) -> Vec<Segment> {
    let mut last = 0.0;
    let pairs = points.windows(2).filter(|pair| pair[0] != pair[1]);
    pairs
        .map(|pair| {
            let run = pair[1] - pair[0];
            let blade_deg = nearest(run.x.atan2(run.y).to_degrees(), period, last);
            last = blade_deg;
            Segment { from: pair[0], to: pair[1], blade_deg }
        })
        .collect()
}

/// The angle that differs from `angle` by whole periods and lies nearest to `goal`, in degrees. Half a period
/// away on either side, the larger one is taken, so that a lengthwise cut from 0 is made at +90.
#[must_use]
pub fn nearest(angle: f64, period: f64, goal: f64) -> f64 {
    let turns = ((goal - angle) / period + 0.5).floor();
    angle + turns * period
}

impl Stroke {
    /// The turn in whole periods that brings the blade nearest to `from_deg` at the start and keeps it within
    /// its range all along; `None` if no turn does.
    #[must_use]
    pub fn turn_from(&self, from_deg: f64, cutter: &Cutter) -> Option<f64> {
        let period = period_deg(cutter.edges);
        let angles = self.knots.iter().map(|knot| knot.blade_deg);
        let (low, high) = angles.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
        let (min, max) = (cutter.blade_range.0.degrees(), cutter.blade_range.1.degrees());
        let fewest = ((min - low) / period).ceil();
        let most = ((max - high) / period).floor();
        if fewest > most {
            return None;
        }
        let wanted = ((from_deg - self.knots[0].blade_deg) / period).round();
        Some(wanted.clamp(fewest, most) * period)
    }
}

#[cfg(test)]
mod tests {
    use super::super::chain::split;
    use super::super::machine::{check, two_cutter_lab};
    use super::*;

    fn cutter() -> Cutter {
        check(&two_cutter_lab(), "").unwrap().cutters.remove(0)
    }

    fn first_blade(list: &[(f64, f64)]) -> f64 {
        let points: Vec<_> = list.iter().map(|&(u, v)| Point2::new(u, v)).collect();
        let chain = &split(0, &points, 37.5)[0];
        strokes(chain, (1.into(), 0), &cutter(), 0.0, 0.01)[0].knots[0].blade_deg
    }

    #[test]
    fn blade_angles_are_measured_from_v_and_lie_in_half_a_turn() {
        assert_eq!(first_blade(&[(0.0, -10.0), (0.0, 10.0)]), 0.0);
        assert_eq!(first_blade(&[(0.0, -10.0), (20.0, 10.0)]), 45.0);
        assert_eq!(first_blade(&[(20.0, -10.0), (0.0, 10.0)]), -45.0);
        assert_eq!(first_blade(&[(20.0, 10.0), (0.0, 10.0)]), 90.0);
        assert_eq!(first_blade(&[(0.0, 10.0), (20.0, 10.0)]), 90.0);
    }

    #[test]
    fn a_sharp_corner_starts_a_new_stroke_and_a_blunt_one_does_not() {
        let points: Vec<_> =
            [(30.0, -10.0), (20.0, 0.0), (19.0, 10.0), (17.0, 20.0)].map(|(u, v)| Point2::new(u, v)).to_vec();
        let made = strokes(&split(0, &points, 37.5)[0], (1.into(), 0), &cutter(), 100.0, 0.01);
        assert_eq!(made.iter().map(|stroke| stroke.knots.len()).collect::<Vec<_>>(), [2, 3]);
        assert_eq!(made[0].knots[0].x, 70.0);
        assert_eq!(made[1].knots[0].x, made[0].knots[1].x);
    }

    #[test]
    fn the_blade_turns_the_shortest_way_and_stays_in_its_range() {
        let stroke = |from: f64, to: f64| Stroke {
            course: 1.into(),
            piece: 0,
            x_of_u0: 0.0,
            knots: vec![Knot { x: 0.0, v: 0.0, blade_deg: from }, Knot { x: 1.0, v: 0.0, blade_deg: to }],
        };
        assert_eq!(stroke(-80.0, -80.0).turn_from(80.0, &cutter()), Some(180.0));
        assert_eq!(stroke(-80.0, -80.0).turn_from(350.0, &cutter()), Some(360.0));
        assert_eq!(stroke(0.0, 900.0).turn_from(0.0, &cutter()), None);
    }
}
