//! Entities as curves of points: what is round is flattened to [`CURVE_CHORD_MM`].

use super::content::value;
use super::fields::Fields;
use super::insert::{Placed, Placing};
use super::pair::Record;
use super::spline;
use crate::planning::finding::Code;
use crate::planning::geometry::{Point2, Point3, Vector3};
use crate::planning::tape::file::faults::Fault;
use crate::planning::tape::wire::{LARGEST_MM, MOST_POINTS};
use crate::planning::tolerance::CURVE_CHORD_MM;

/// A curve in mm.
#[derive(Debug, Clone)]
pub struct Curve {
    /// Type and handle of its entity.
    pub what: String,
    /// The line at which its entity begins.
    pub line: u32,
    /// At least two points; the first is not repeated at the end of a closed curve.
    pub points: Vec<Point3>,
    /// The line that each point comes from.
    pub lines: Vec<u32>,
    /// Whether it closes itself.
    pub closed: bool,
}

/// The entities that are understood.
pub const UNDERSTOOD: &str = "LINE, ARC, CIRCLE, ELLIPSE, SPLINE, LWPOLYLINE, POLYLINE";

/// How many points all curves of a file may still have: a few bytes of text can ask for any number.
pub struct Room {
    left: usize,
}

impl Default for Room {
    fn default() -> Self {
        Self { left: MOST_POINTS }
    }
}

/// A curve as it grows.
pub(super) struct Pen<'a> {
    room: &'a mut Room,
    placing: &'a Placing,
    points: Vec<Point3>,
    lines: Vec<u32>,
}

impl Pen<'_> {
    /// Goes on to a point.
    ///
    /// # Errors
    /// `OutOfRange` for a point farther away than any mould, or one more than a file may have.
    pub(super) fn to(&mut self, point: Point3, line: u32) -> Result<(), Fault> {
        let point = self.placing.place(&point);
        // A coordinate that is no number is not within the limits either.
        if !point.iter().all(|x| x.abs() <= LARGEST_MM) {
            let message = format!(
                "the curve reaches x {:e} y {:e} z {:e} mm; each must lie between -{LARGEST_MM} and {LARGEST_MM}",
                point.x, point.y, point.z
            );
            return Err(Fault::new(Code::OutOfRange, line, message));
        }
        let Some(left) = self.room.left.checked_sub(1) else {
            let message = format!("the curves of the file need more than {MOST_POINTS} points");
            return Err(Fault::new(Code::OutOfRange, line, message));
        };
        self.room.left = left;
        self.points.push(point);
        self.lines.push(line);
        Ok(())
    }
}

/// The curve of an entity in its place; `None` where the kind of entity is not understood.
///
/// # Errors
/// The first thing that is wrong with it.
pub fn curve_of(placed: &Placed<'_>, room: &mut Room) -> Option<Result<Curve, Fault>> {
    let (entity, placing) = (placed.entity, &placed.placing);
    let fields = Fields::of(&entity.record, placing.scale);
    let mut pen = Pen { room, placing, points: Vec::new(), lines: Vec::new() };
    let drawn = match entity.record.kind {
        "LINE" => line(&fields, &mut pen),
        "ARC" => arc(&fields, &mut pen),
        "CIRCLE" => circle(&fields, &mut pen),
        "ELLIPSE" => ellipse(&fields, &mut pen),
        "SPLINE" => spline::draw(&fields, &mut pen).map(|()| false),
        "LWPOLYLINE" => light_polyline(&fields, &mut pen),
        "POLYLINE" => polyline(&fields, &entity.parts, &mut pen),
        _ => return None,
    };
    let (points, lines) = (pen.points, pen.lines);
    let (what, line) = (described(&entity.record), entity.record.line);
    Some(drawn.map(|closed| Curve { what, line, points, lines, closed }))
}

/// Type and handle of an entity.
#[must_use]
pub fn described(record: &Record<'_>) -> String {
    let short = |text: &str| text.chars().filter(|c| c.is_ascii_graphic()).take(40).collect::<String>();
    match value(record, 5) {
        Some(handle) => format!("{} (handle {})", short(record.kind), short(handle)),
        None => short(record.kind),
    }
}

fn line(fields: &Fields<'_>, pen: &mut Pen<'_>) -> Result<bool, Fault> {
    pen.to(fields.point([10, 20, 30])?, fields.line())?;
    pen.to(fields.point([11, 21, 31])?, fields.line())?;
    Ok(false)
}

/// Center plus cos t of one half axis and sin t of the other.
struct Ellipse {
    center: Point3,
    major: Vector3,
    minor: Vector3,
}

impl Ellipse {
    fn at(&self, t: f64) -> Point3 {
        let (sin, cos) = t.sin_cos();
        self.center + self.major * cos + self.minor * sin
    }

    /// Draws from one parameter over a span. The whole of it is closed, and does not repeat its first point.
    ///
    /// A chord over a parameter step h leaves the curve by at most h^2 / 8 times the largest second derivative, which is
    /// the longer half axis.
    fn draw(&self, from: f64, span: f64, line: u32, pen: &mut Pen<'_>) -> Result<bool, Fault> {
        const FEWEST_OF_WHOLE: f64 = 8.0;
        let whole = span >= std::f64::consts::TAU - WHOLE_TURN;
        let longer = self.major.norm().max(self.minor.norm());
        let fewest = if whole { FEWEST_OF_WHOLE } else { 1.0 };
        let steps = (span * (longer / (8.0 * CURVE_CHORD_MM)).sqrt()).ceil().max(fewest) as u32;
        for step in 0..if whole { steps } else { steps + 1 } {
            pen.to(self.at(from + span * f64::from(step) / f64::from(steps)), line)?;
        }
        Ok(whole)
    }
}

/// A span that is short of a whole turn by less than this, in rad, is the whole turn: a hundred-thousandth of the last
/// digit that a drawing prints of an angle.
const WHOLE_TURN: f64 = 1e-9;

fn circle(fields: &Fields<'_>, pen: &mut Pen<'_>) -> Result<bool, Fault> {
    round(fields)?.draw(0.0, std::f64::consts::TAU, fields.line(), pen)
}

/// From the start angle counter-clockwise to the end angle; equal angles are the whole circle.
fn arc(fields: &Fields<'_>, pen: &mut Pen<'_>) -> Result<bool, Fault> {
    let (start, end) = (fields.required(50)?, fields.required(51)?);
    let span = span(start.to_radians(), end.to_radians());
    round(fields)?.draw(start.to_radians(), span, fields.line(), pen)
}

/// How far it is counter-clockwise from one angle to another, above 0 and up to a whole turn.
fn span(start: f64, end: f64) -> f64 {
    let span = (end - start).rem_euclid(std::f64::consts::TAU);
    if span < WHOLE_TURN { std::f64::consts::TAU } else { span }
}

fn round(fields: &Fields<'_>) -> Result<Ellipse, Fault> {
    let radius = fields.length(40)?;
    if radius <= 0.0 {
        return Err(fields.fault(Code::OutOfRange, format!("its radius is {radius} mm; it must be above 0")));
    }
    let side = fields.side()?;
    let center = fields.point([10, 20, 30])?;
    // Seen from below, x runs the other way.
    Ok(Ellipse {
        center: Point3::new(center.x * side, center.y, center.z * side),
        major: Vector3::x() * radius * side,
        minor: Vector3::y() * radius,
    })
}

fn ellipse(fields: &Fields<'_>, pen: &mut Pen<'_>) -> Result<bool, Fault> {
    let (center, major) = (fields.point([10, 20, 30])?, fields.point([11, 21, 31])?.coords);
    let ratio = fields.required(40)?;
    if !(ratio > 0.0 && ratio <= 1.0) || major.norm() <= 0.0 {
        let message = format!(
            "its half axis is {} mm long and the other one {ratio} times that; it needs a length, and a ratio \
             above 0 and up to 1",
            major.norm()
        );
        return Err(fields.fault(Code::OutOfRange, message));
    }
    let minor = (Vector3::z() * fields.side()?).cross(&major) * ratio;
    let (start, end) =
        (fields.number(41)?.unwrap_or(0.0), fields.number(42)?.unwrap_or(std::f64::consts::TAU));
    Ellipse { center, major, minor }.draw(start, span(start, end), fields.line(), pen)
}

/// A vertex of a polyline, before its plane is turned.
struct Vertex {
    place: Point3,
    /// tan of a quarter of the angle of the arc to the next vertex, positive counter-clockwise; 0 for a line.
    bulge: f64,
    line: u32,
}

/// Flag of a closed polyline.
const CLOSED: i64 = 1;

fn light_polyline(fields: &Fields<'_>, pen: &mut Pen<'_>) -> Result<bool, Fault> {
    let flags = fields.flags(70)?;
    if flags & !(CLOSED | LINETYPE) != 0 {
        return Err(fields.fault(Code::NotSupported, format!("its flags {flags} are not understood")));
    }
    let (elevation, side) = (fields.optional_length(38)?, fields.side()?);
    let mut vertices: Vec<Vertex> = Vec::new();
    for pair in &fields.record.pairs {
        match (pair.code, vertices.last_mut()) {
            (10, _) => {
                let place = Point3::new(fields.length_of(pair)?, f64::NAN, elevation);
                vertices.push(Vertex { place, bulge: 0.0, line: pair.line });
            }
            (20, Some(last)) => last.place.y = fields.length_of(pair)?,
            (42, Some(last)) => last.bulge = fields.number_of(pair)?,
            _ => {}
        }
    }
    let half = vertices.iter().find(|vertex| vertex.place.y.is_nan());
    if let Some(vertex) = half {
        return Err(Fault::new(Code::MissingField, vertex.line, "a vertex has x (group 10) and no y (20)"));
    }
    let count = fields.flags(90)?;
    if fields.has(90) && usize::try_from(count) != Ok(vertices.len()) {
        let message = format!("it has {} vertices and says that they are {count}", vertices.len());
        return Err(fields.fault(Code::WrongCount, message));
    }
    draw_vertices(&vertices, flags & CLOSED != 0, side, fields, pen)
}

/// Flag of a polyline in space, whose vertices have a height of their own.
const IN_SPACE: i64 = 8;
/// Flag that only says how a pattern of dashes runs on.
const LINETYPE: i64 = 128;

fn polyline(fields: &Fields<'_>, parts: &[Record<'_>], pen: &mut Pen<'_>) -> Result<bool, Fault> {
    let flags = fields.flags(70)?;
    if flags & !(CLOSED | IN_SPACE | LINETYPE) != 0 {
        let message = format!("its flags {flags} are not understood: a fitted curve, a mesh or a polyface");
        return Err(fields.fault(Code::NotSupported, message));
    }
    let in_space = flags & IN_SPACE != 0;
    let (elevation, side) = (fields.optional_length(30)?, if in_space { 1.0 } else { fields.side()? });
    let mut vertices = Vec::new();
    for part in parts {
        let of = Fields::of(part, fields.scale);
        let mut place = of.point([10, 20, 30])?;
        if !in_space {
            place.z = elevation;
        }
        vertices.push(Vertex { place, bulge: of.number(42)?.unwrap_or(0.0), line: part.line });
    }
    draw_vertices(&vertices, flags & CLOSED != 0, side, fields, pen)
}

fn draw_vertices(
    vertices: &[Vertex],
    closed: bool,
    side: f64,
    fields: &Fields<'_>,
    pen: &mut Pen<'_>,
) -> Result<bool, Fault> {
    if vertices.len() < 2 {
        let message = format!("it has {} vertices; a curve has two at least", vertices.len());
        return Err(fields.fault(Code::TooFewPoints, message));
    }
    let turned = |p: Point3| Point3::new(p.x * side, p.y, p.z * side);
    for (index, from) in vertices.iter().enumerate() {
        pen.to(turned(from.place), from.line)?;
        let to = match vertices.get(index + 1) {
            Some(to) => to,
            None if closed => &vertices[0],
            None => break,
        };
        let flat = |p: &Point3| Point2::new(p.x, p.y);
        for point in bulged(&flat(&from.place), &flat(&to.place), from.bulge, from.line, pen.room.left)? {
            pen.to(turned(Point3::new(point.x, point.y, from.place.z)), from.line)?;
        }
    }
    Ok(closed)
}

/// The points between the ends of an arc, at most `most`.
///
/// An arc over the chord d is halved at its middle, which lies b/2 |d| to the right of the chord's middle; each half
/// has the bulge tan(theta/8) = b / (1 + sqrt(1 + b^2)). This needs no centre, which for a nearly straight arc is
/// too far away to have digits left.
fn bulged(from: &Point2, to: &Point2, bulge: f64, line: u32, most: usize) -> Result<Vec<Point2>, Fault> {
    let (mut points, mut bulge) = (vec![*from, *to], bulge);
    while points.windows(2).any(|ends| bulge.abs() * (ends[1] - ends[0]).norm() / 2.0 > CURVE_CHORD_MM) {
        if points.len() > most {
            let message = format!("the curves of the file need more than {MOST_POINTS} points");
            return Err(Fault::new(Code::OutOfRange, line, message));
        }
        let mut finer = Vec::with_capacity(2 * points.len());
        for ends in points.windows(2) {
            let chord = ends[1] - ends[0];
            let right = nalgebra::Vector2::new(chord.y, -chord.x);
            finer.push(ends[0]);
            finer.push(nalgebra::center(&ends[0], &ends[1]) + right * (bulge / 2.0));
        }
        finer.push(*to);
        points = finer;
        bulge /= 1.0 + (1.0 + bulge * bulge).sqrt();
        // A coordinate that is no number is not within the limits either.
        if !points[1].iter().all(|x| x.abs() <= LARGEST_MM) {
            let message = format!("the arc reaches farther than {LARGEST_MM} mm");
            return Err(Fault::new(Code::OutOfRange, line, message));
        }
    }
    points.pop();
    Ok(points.into_iter().skip(1).collect())
}
