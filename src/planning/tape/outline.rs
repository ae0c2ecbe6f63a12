//! The outlines of a ply: what is accepted and said, and what is refused.

use super::file::is_drawing;
use super::label::PlyPlace;
use super::wire;
use crate::planning::finding::{Code, Finding};
use crate::planning::geometry::crossing::{Crossing, first_crossing};
use crate::planning::geometry::polygon::{contains, nested, signed_area};
use crate::planning::geometry::{Point2, Point3, Vector3};
use crate::planning::tolerance::{FLAT_MM, LONG_CLOSING_STEP, SAME_POINT_MM};

/// A closed loop in mm; its first point is not repeated.
pub type Loop = Vec<Point3>;

/// A loop as it is being checked.
struct Draft {
    /// JSON pointer of its points.
    at: String,
    points: Loop,
    /// The place of each point in the job document.
    indices: Vec<usize>,
}

/// Checks the outlines of a ply and takes them over.
pub fn check(
    ply: PlyPlace,
    boundary: &wire::Outline,
    holes: &[wire::Outline],
    findings: &mut Vec<Finding>,
) -> (Loop, Vec<Loop>) {
    let mut drafts = vec![take_over(boundary, &format!("{ply}/boundary"), findings)];
    for (index, hole) in holes.iter().enumerate() {
        drafts.push(take_over(hole, &format!("{ply}/holes/{index}"), findings));
    }
    if drafts.iter().all(|draft| draft.points.len() >= 3) {
        check_in_plane(&drafts, findings);
    }
    let mut loops = drafts.into_iter().map(|draft| draft.points);
    (loops.next().unwrap_or_default(), loops.collect())
}

fn take_over(outline: &wire::Outline, at: &str, findings: &mut Vec<Finding>) -> Draft {
    let at_points = format!("{at}/points");
    refuse_odd_fields(outline, at, findings);
    let Some(points) = &outline.points else {
        if outline.file.is_none() {
            findings.push(Finding::error(
                Code::MissingField,
                at_points.as_str(),
                "an outline needs its points",
            ));
        }
        return Draft { at: at_points, points: Vec::new(), indices: Vec::new() };
    };
    let mut draft = Draft { at: at_points, points: Vec::new(), indices: Vec::new() };
    let mut repeated = Vec::new();
    for (index, &point) in points.iter().enumerate() {
        let point = Point3::from(point);
        if draft.points.last().is_some_and(|last| (point - last).norm() < SAME_POINT_MM) {
            repeated.push(index);
            continue;
        }
        draft.points.push(point);
        draft.indices.push(index);
    }
    report_repeated(&repeated, &draft.at, findings);
    open(&mut draft, findings);
    if draft.points.len() < 3 {
        let message = format!("an outline needs three different points; this one has {}", draft.points.len());
        findings.push(Finding::error(Code::TooFewPoints, draft.at.as_str(), message));
    }
    report_closing_step(&draft, findings);
    draft
}

/// Points and a file are not both given, and only a drawing has layers.
fn refuse_odd_fields(outline: &wire::Outline, at: &str, findings: &mut Vec<Finding>) {
    if outline.points.is_some() && outline.file.is_some() {
        let message = "an outline has either points or a file";
        findings.push(Finding::error(Code::ConflictingFields, format!("{at}/file"), message));
    }
    let Some(layers) = &outline.layers else { return };
    if !outline.file.as_deref().is_some_and(is_drawing) {
        let message = "only a file whose name ends in .dxf has layers";
        findings.push(Finding::error(Code::ConflictingFields, format!("{at}/layers"), message));
    } else if layers.boundary.is_some() && !at.ends_with("/boundary") {
        let message = "a cut-out has no boundary; name the layer of the cut-outs";
        findings.push(Finding::error(Code::ConflictingFields, format!("{at}/layers/boundary"), message));
    }
}

/// Says which points were dropped because they repeat the one before.
pub fn report_repeated(repeated: &[usize], at: &str, findings: &mut Vec<Finding>) {
    if let Some(first) = repeated.first() {
        let message = format!(
            "{} points repeat the one before (the first at {first}); they were dropped",
            repeated.len()
        );
        findings.push(Finding::info(Code::RepeatedPoint, format!("{at}/{first}"), message));
    }
}

/// Drops the repeated first point at the end of a loop.
fn open(draft: &mut Draft, findings: &mut Vec<Finding>) {
    let closed = |points: &Loop| match (points.first(), points.last()) {
        (Some(first), Some(last)) => points.len() > 1 && (last - first).norm() < SAME_POINT_MM,
        _ => false,
    };
    if closed(&draft.points) {
        let index = draft.indices.last().copied().unwrap_or_default();
        let message = "the outline repeats its first point at its end; that is accepted";
        findings.push(Finding::info(Code::ClosedOutline, format!("{}/{index}", draft.at), message));
    }
    while closed(&draft.points) {
        draft.points.pop();
        draft.indices.pop();
    }
}

/// A file that was cut short closes with one long step. Corners alone are no sign of that.
fn report_closing_step(draft: &Draft, findings: &mut Vec<Finding>) {
    const FEWEST_STEPS: usize = 8;
    let mut steps: Vec<f64> = draft.points.windows(2).map(|pair| (pair[1] - pair[0]).norm()).collect();
    if steps.len() < FEWEST_STEPS {
        return;
    }
    let longest = steps.iter().copied().fold(0.0, f64::max);
    let middle = steps.len() / 2;
    let median = *steps.select_nth_unstable_by(middle, f64::total_cmp).1;
    let closing = (draft.points[0] - draft.points[draft.points.len() - 1]).norm();
    if closing > LONG_CLOSING_STEP * median && closing > 2.0 * longest {
        let message = format!(
            "the closing step is {closing:.3} mm long, the others {median:.3} mm: see whether the outline is complete"
        );
        findings.push(Finding::warning(Code::LongClosingStep, draft.at.as_str(), message));
    }
}

/// Crossing, sense and containment are looked at in the plane of the boundary. On a curved mould they are
/// looked at course by course after development.
fn check_in_plane(drafts: &[Draft], findings: &mut Vec<Finding>) {
    let Some(plane) = Plane::of(&drafts[0].points) else {
        let message = "the outline encloses no area";
        return findings.push(Finding::error(Code::OutlineCrosses, drafts[0].at.as_str(), message));
    };
    if !drafts.iter().all(|draft| plane.holds(&draft.points)) {
        return;
    }
    let loops: Vec<Vec<Point2>> = drafts.iter().map(|draft| plane.flatten(&draft.points)).collect();
    if let Some(crossing) = first_crossing(&loops, SAME_POINT_MM) {
        return findings.push(crossing_finding(drafts, &crossing, &plane));
    }
    check_holes(drafts, &loops, findings);
}

fn crossing_finding(drafts: &[Draft], crossing: &Crossing, plane: &Plane) -> Finding {
    let (one, other) = (&drafts[crossing.one.0], &drafts[crossing.other.0]);
    let (from, to) = (one.indices[crossing.one.1], other.indices[crossing.other.1]);
    let near = plane.raised(&crossing.place);
    let message = format!(
        "the segment that begins here crosses or touches the one that begins at {}/{to}, near x {:.3} y {:.3} z {:.3} mm",
        other.at, near.x, near.y, near.z
    );
    Finding::error(Code::OutlineCrosses, format!("{}/{from}", one.at), message)
}

fn check_holes(drafts: &[Draft], loops: &[Vec<Point2>], findings: &mut Vec<Finding>) {
    let holes: Vec<&[Point2]> = loops.iter().skip(1).map(Vec::as_slice).collect();
    if let Some((inner, outer)) = nested(&holes) {
        let message = format!("the cut-out lies inside the cut-out {}", drafts[outer + 1].at);
        findings.push(Finding::error(Code::HoleOutside, drafts[inner + 1].at.as_str(), message));
    }
    for (number, hole) in loops.iter().enumerate().skip(1) {
        let at = drafts[number].at.as_str();
        if !contains(&loops[0], &hole[0]) {
            findings.push(Finding::error(Code::HoleOutside, at, "the cut-out lies outside the ply"));
        }
        if signed_area(hole) > 0.0 {
            let message = "the cut-out turns the same way as the boundary; that is accepted";
            findings.push(Finding::info(Code::OutlineSense, at, message));
        }
    }
}

/// The plane through a loop; seen against its normal the loop turns counter-clockwise.
pub struct Plane {
    /// A point of it: the first of the loop.
    pub origin: Point3,
    /// Its unit normal.
    pub normal: Vector3,
    x: Vector3,
    y: Vector3,
}

impl Plane {
    /// The plane by Newell's method: its normal is that of the largest projected area. An outline whose parts
    /// cancel out, such as a bow tie, lies in the plane of its widest triangle. `None` if all points are on a line.
    #[must_use]
    pub fn of(points: &Loop) -> Option<Self> {
        let origin = *points.first()?;
        let spans = points.windows(2).map(|pair| (pair[0] - origin).cross(&(pair[1] - origin)));
        let doubled: Vector3 = spans.sum();
        let length: f64 = points.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum();
        let flat = doubled.norm() <= SAME_POINT_MM * length;
        let normal = if flat { widest_normal(points, length)? } else { doubled.normalize() };
        let axis = [Vector3::x(), Vector3::y(), Vector3::z()]
            .into_iter()
            .min_by(|a, b| a.dot(&normal).abs().total_cmp(&b.dot(&normal).abs()))?;
        let x = (axis - normal * axis.dot(&normal)).normalize();
        Some(Self { origin, normal, x, y: normal.cross(&x) })
    }

    /// Whether all points lie in it, within [`FLAT_MM`].
    #[must_use]
    pub fn holds(&self, points: &Loop) -> bool {
        points.iter().all(|point| (point - self.origin).dot(&self.normal).abs() <= FLAT_MM)
    }

    /// The point of the plane that [`Plane::flatten`] puts here.
    fn raised(&self, point: &Point2) -> Point3 {
        self.origin + self.x * point.x + self.y * point.y
    }

    /// Points in the axes of the plane, as if they lay in it.
    #[must_use]
    pub fn flatten(&self, points: &[Point3]) -> Vec<Point2> {
        points
            .iter()
            .map(|point| {
                let from_origin = point - self.origin;
                Point2::new(from_origin.dot(&self.x), from_origin.dot(&self.y))
            })
            .collect()
    }
}

/// The normal of the widest triangle of the first point, the one farthest from it and a third.
fn widest_normal(points: &Loop, length: f64) -> Option<Vector3> {
    let origin = *points.first()?;
    let far = points.iter().map(|point| point - origin).max_by(|a, b| a.norm().total_cmp(&b.norm()))?;
    let spans = points.iter().map(|point| far.cross(&(point - origin)));
    let widest = spans.max_by(|a, b| a.norm().total_cmp(&b.norm()))?;
    (widest.norm() > SAME_POINT_MM * length).then(|| widest.normalize())
}
