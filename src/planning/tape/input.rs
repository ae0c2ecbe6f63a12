//! A tape-cut job's input, checked and taken over once: what the planner works on.

use super::courses::generate;
use super::file::origin::Origins;
use super::label::{CourseLabel, CoursePlace};
use super::likeness;
use super::machine::{Catalogue, Machine, resolve};
use super::outline::{self, Loop};
use super::wire;
use super::zone;
use crate::planning::finding::{Code, Finding, any_error};
use crate::planning::geometry::{Point3, Vector3};
use crate::planning::tolerance::{SAME_POINT_MM, UNIT_NORMAL, ZERO_NORMAL};
use crate::planning::units::Length;

pub use super::wire::{Allocation, OnExcess, RollOrder};

/// What the planner works on.
#[derive(Debug, Clone)]
pub struct TapeInput {
    /// Width of the tape.
    pub width: Length,
    /// Its thickness.
    pub thickness: Length,
    /// The ply's outline in mm, first point not repeated.
    pub boundary: Loop,
    /// Its cut-outs.
    pub holes: Vec<Loop>,
    /// Its courses in laying order.
    pub courses: Vec<Course>,
    /// The machine.
    pub machine: Machine,
    /// What is done with a shape that too many knives would be needed for.
    pub on_excess: OnExcess,
    /// How the pieces are wound on the cassette.
    pub roll_order: RollOrder,
    /// How cuts are given to knives.
    pub allocation: Allocation,
    /// Scrap between pieces along U.
    pub scrap_gap: Length,
    /// Whether congruent neighbours may share one cut.
    pub share_cuts: bool,
    /// Stretches of the tape that are kept free of pieces, from its leading end in mm: sorted, none touches another.
    pub zones_mm: Vec<(f64, f64)>,
    /// How much tape there is, where that is known.
    pub tape_length: Option<Length>,
    /// Chord tolerance.
    pub tolerance: Length,
    /// The laying head's shortest length, if it has one.
    pub shortest_piece: Option<Length>,
    /// The course from which on the program goes, if not from the start.
    pub from_course: Option<CourseLabel>,
    /// Whether knives stay up and the generator off.
    pub dry_run: bool,
    /// What was accepted and should be known.
    pub findings: Vec<Finding>,
    /// Where stands what is not in the job document itself; the places of findings go through this.
    pub origins: Origins,
}

impl TapeInput {
    /// What is left of the chord tolerance for thinning, in mm, where a spool may bend cuts.
    #[must_use]
    pub fn thinning_mm(&self) -> f64 {
        self.machine.feed.thinning_mm(self.tolerance.mm())
    }
}

/// A course: the centre line of a tape on the mould.
#[derive(Debug, Clone)]
pub struct Course {
    /// What it is called.
    pub label: CourseLabel,
    /// Its place in the job document, for findings.
    pub place: CoursePlace,
    /// Points in mm in laying direction, none repeated.
    pub points: Vec<Point3>,
    /// The mould's outward unit normal at each.
    pub normals: Vec<Vector3>,
}

/// Checks an input and takes it over. What it names in a file is not there for this: [`super::file::listed`] puts
/// it there first.
///
/// # Errors
/// Every fault with its JSON pointer.
pub fn check(input: &wire::TapeCut, catalogue: &Catalogue) -> Result<TapeInput, Vec<Finding>> {
    let mut findings = Vec::new();
    let machine =
        resolve(&input.machine, catalogue, "/input/machine").map_err(|faults| findings.extend(faults)).ok();
    let mut courses = check_courses(input, &mut findings);
    let zones_mm = zone::check(&input.tape.zones_mm, &mut findings);
    let (boundary, holes) = outline::check(&input.boundary, &input.holes, &mut findings);
    let mut origins = Origins::default();
    if let (None, Some(rule)) = (&input.tracks, &input.courses) {
        origins = Origins::of_generated_courses();
        courses = generated(input, rule, &boundary, &holes, &mut findings);
    }
    if !any_error(&findings) {
        findings.extend(likeness::findings(&boundary, &courses, input));
    }
    let Some(machine) = machine.filter(|_| !any_error(&findings)) else {
        findings.retain(Finding::is_error);
        return Err(findings);
    };
    Ok(TapeInput {
        width: Length::from_mm(input.tape.width_mm),
        thickness: Length::from_mm(input.tape.thickness_mm),
        boundary,
        holes,
        courses,
        machine,
        on_excess: input.options.on_excess,
        roll_order: input.options.roll_order,
        allocation: input.options.allocation,
        share_cuts: input.options.share_cuts,
        zones_mm,
        tape_length: input.tape.length_mm.map(Length::from_mm),
        scrap_gap: Length::from_mm(input.options.scrap_gap_mm),
        tolerance: Length::from_mm(input.options.tolerance_mm),
        shortest_piece: input.options.shortest_piece_mm.map(Length::from_mm),
        from_course: input.options.from_course.map(CourseLabel::from),
        dry_run: input.options.dry_run,
        findings,
        origins,
    })
}

/// The courses of a rule. An outline that is at fault, or in a file that is not read yet, has none.
fn generated(
    input: &wire::TapeCut,
    rule: &wire::Courses,
    boundary: &Loop,
    holes: &[Loop],
    findings: &mut Vec<Finding>,
) -> Vec<Course> {
    if outline::Plane::of(boundary).is_none() {
        return Vec::new();
    }
    let courses = generate(rule, Length::from_mm(input.tape.width_mm), boundary, holes);
    courses.map_err(|fault| findings.push(fault)).unwrap_or_default()
}

fn check_courses(input: &wire::TapeCut, findings: &mut Vec<Finding>) -> Vec<Course> {
    if input.tracks.is_some() && input.courses.is_some() {
        let message = "a ply has either tracks or courses to be generated";
        findings.push(Finding::error(Code::ConflictingFields, "/input/courses", message));
    }
    let tracks = match &input.tracks {
        Some(wire::Tracks::Listed(tracks)) => tracks,
        Some(wire::Tracks::File { .. }) => return Vec::new(),
        None if input.courses.is_some() => return Vec::new(),
        None => {
            let message = "a ply needs its tracks, or courses to be generated";
            findings.push(Finding::error(Code::MissingField, "/input/tracks", message));
            return Vec::new();
        }
    };
    refuse_repeated_numbers(tracks, findings);
    tracks.iter().enumerate().map(|(index, track)| check_course(index, track, findings)).collect()
}

fn refuse_repeated_numbers(tracks: &[wire::Track], findings: &mut Vec<Finding>) {
    let mut seen = std::collections::BTreeMap::new();
    for (index, track) in tracks.iter().enumerate() {
        if let Some(first) = seen.insert(track.number, index) {
            let message = format!("track number {} is that of track {first} too", track.number);
            findings.push(Finding::error(
                Code::DuplicateCourse,
                format!("/input/tracks/{index}/number"),
                message,
            ));
        }
    }
}

fn check_course(index: usize, track: &wire::Track, findings: &mut Vec<Finding>) -> Course {
    let place = CoursePlace { ply: None, index };
    let at = format!("{place}/points");
    let label = CourseLabel::from(track.number);
    let mut course = Course { label, place, points: Vec::new(), normals: Vec::new() };
    let mut repeated = Vec::new();
    for (number, point) in track.points.iter().enumerate() {
        let position = Point3::from(point.position);
        if course.points.last().is_some_and(|last| (position - last).norm() < SAME_POINT_MM) {
            repeated.push(number);
            continue;
        }
        course.points.push(position);
        course.normals.push(Vector3::from(point.normal));
    }
    outline::report_repeated(&repeated, &at, findings);
    if course.points.len() < 2 {
        let message = format!("a course needs two different points; track {} has fewer", track.number);
        findings.push(Finding::error(Code::CourseTooShort, at.clone(), message));
    }
    scale_normals(track, &mut course.normals, &at, findings);
    course
}

fn scale_normals(track: &wire::Track, normals: &mut [Vector3], at: &str, findings: &mut Vec<Finding>) {
    for (number, point) in track.points.iter().enumerate() {
        if Vector3::from(point.normal).norm() < ZERO_NORMAL {
            let message = "the normal has no length; give the mould's outward unit normal";
            findings.push(Finding::error(Code::ZeroNormal, format!("{at}/{number}/normal"), message));
        }
    }
    let scaled = normals.iter().filter(|normal| (normal.norm() - 1.0).abs() > UNIT_NORMAL).count();
    if scaled > 0 {
        let message = format!("{scaled} normals are not of length 1; they were scaled");
        findings.push(Finding::info(Code::NormalScaled, at, message));
    }
    for normal in normals {
        *normal = normal.try_normalize(ZERO_NORMAL).unwrap_or_else(Vector3::z);
    }
}
