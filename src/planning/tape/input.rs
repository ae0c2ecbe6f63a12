//! A tape-cut job's input, checked and taken over once: what the planner works on.

use std::fmt;

use super::courses::generate;
use super::file::origin::Origins;
use super::label::{CourseLabel, CoursePlace, PlyPlace};
use super::likeness;
use super::machine::{Catalogue, Machine, resolve};
use super::outline::{self, Loop};
use super::wire::{self, PlyFields};
use super::zone;
use crate::planning::document::shape::quoted;
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
    /// The plies of the roll in laying order; at least one.
    pub plies: Vec<Ply>,
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

/// A ply, which is developed for itself.
#[derive(Debug, Clone)]
pub struct Ply {
    /// Which ply of the job it is.
    pub place: PlyPlace,
    /// Its name for people, which may be empty.
    pub name: String,
    /// Its outline in mm, first point not repeated.
    pub boundary: Loop,
    /// Its cut-outs.
    pub holes: Vec<Loop>,
    /// Its courses in laying order.
    pub courses: Vec<Course>,
}

/// `the ply`, or `ply 2 ("P13")` where there are several.
impl fmt::Display for Ply {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.place.number {
            None => f.write_str("the ply"),
            Some(number) if self.name.is_empty() => write!(f, "ply {number}"),
            Some(number) => write!(f, "ply {number} ({})", quoted(&self.name)),
        }
    }
}

impl TapeInput {
    /// The ply of that place.
    #[must_use]
    pub fn ply(&self, place: PlyPlace) -> Option<&Ply> {
        self.plies.get(place.index.unwrap_or(0))
    }

    /// Whether the roll holds several plies.
    #[must_use]
    pub fn several_plies(&self) -> bool {
        self.plies.len() > 1
    }

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

/// Checks an input and takes it over. `plies` are its plies; what they name in files [`super::file::listed`] has put in
/// its place, or it is not there for this.
///
/// # Errors
/// Every fault with its JSON pointer.
pub fn check(
    input: &wire::TapeCut,
    plies: &[PlyFields<'_>],
    catalogue: &Catalogue,
) -> Result<TapeInput, Vec<Finding>> {
    let mut findings = Vec::new();
    input.refuse_mixed(&mut findings);
    let machine =
        resolve(&input.machine, catalogue, "/input/machine").map_err(|faults| findings.extend(faults)).ok();
    let zones_mm = zone::check(&input.tape.zones_mm, &mut findings);
    let from_course = check_start(&input.options, plies.len(), &mut findings);
    let width = Length::from_mm(input.tape.width_mm);
    let mut origins = Origins::default();
    let checked: Vec<Ply> =
        plies.iter().map(|ply| check_ply(ply, width, &mut origins, &mut findings)).collect();
    if !any_error(&findings) {
        let alike =
            |(ply, fields): (_, &PlyFields<'_>)| likeness::findings(ply, fields.tracks.is_none(), width);
        findings.extend(checked.iter().zip(plies).flat_map(alike));
    }
    let Some(machine) = machine.filter(|_| !any_error(&findings)) else {
        findings.retain(Finding::is_error);
        return Err(findings);
    };
    Ok(TapeInput {
        width,
        thickness: Length::from_mm(input.tape.thickness_mm),
        plies: checked,
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
        from_course,
        dry_run: input.options.dry_run,
        findings,
        origins,
    })
}

fn check_ply(
    fields: &PlyFields<'_>,
    width: Length,
    origins: &mut Origins,
    findings: &mut Vec<Finding>,
) -> Ply {
    let place = fields.place;
    let courses = check_courses(fields, findings);
    let (boundary, holes) = outline::check(place, &fields.boundary, &fields.holes, findings);
    let mut ply = Ply { place, name: fields.name.to_owned(), boundary, holes, courses };
    if let (None, Some(rule)) = (&fields.tracks, fields.courses) {
        origins.generated(place);
        ply.courses = generated(rule, width, &ply, findings);
    }
    ply
}

/// The courses of a rule. An outline that is at fault, or in a file that is not read yet, has none.
fn generated(rule: &wire::Courses, width: Length, ply: &Ply, findings: &mut Vec<Finding>) -> Vec<Course> {
    if outline::Plane::of(&ply.boundary).is_none() {
        return Vec::new();
    }
    let courses = generate(rule, width, ply.place, &ply.boundary, &ply.holes);
    courses.map_err(|fault| findings.push(fault)).unwrap_or_default()
}

/// The course from which on the program goes. Numbers of courses are one of their kind in a ply only.
fn check_start(options: &wire::Options, plies: usize, findings: &mut Vec<Finding>) -> Option<CourseLabel> {
    let mut refuse = |code: Code, name: &str, message: String| {
        findings.push(Finding::error(code, format!("/input/options/{name}"), message));
        None
    };
    match (options.from_course, options.from_ply) {
        // What has no ply is refused for that.
        _ if plies == 0 => None,
        (None, None) => None,
        (None, Some(_)) => {
            let message = "from_ply says of which ply from_course is, which must be there too";
            refuse(Code::MissingField, "from_course", message.to_owned())
        }
        (Some(_), Some(_)) if plies == 1 => {
            let message = "a roll of one ply has no from_ply; leave it out";
            refuse(Code::ConflictingFields, "from_ply", message.to_owned())
        }
        (Some(_), None) if plies > 1 => {
            let message =
                format!("each of the {plies} plies numbers its courses for itself; say which ply's");
            refuse(Code::MissingField, "from_ply", message)
        }
        (Some(_), Some(ply)) if ply as usize > plies => {
            refuse(Code::OutOfRange, "from_ply", format!("is {ply}; there are {plies} plies"))
        }
        (Some(number), ply) => Some(CourseLabel { ply, number }),
    }
}

fn check_courses(ply: &PlyFields<'_>, findings: &mut Vec<Finding>) -> Vec<Course> {
    let place = ply.place;
    if ply.tracks.is_some() && ply.courses.is_some() {
        let message = "a ply has either tracks or courses to be generated";
        findings.push(Finding::error(Code::ConflictingFields, format!("{place}/courses"), message));
    }
    let tracks = match ply.tracks.as_deref() {
        Some(wire::Tracks::Listed(tracks)) => tracks,
        Some(wire::Tracks::File { .. }) => return Vec::new(),
        None if ply.courses.is_some() => return Vec::new(),
        None => {
            let message = "a ply needs its tracks, or courses to be generated";
            findings.push(Finding::error(Code::MissingField, format!("{place}/tracks"), message));
            return Vec::new();
        }
    };
    refuse_repeated_numbers(tracks, place, findings);
    let course = |(index, track)| check_course(place, index, track, findings);
    tracks.iter().enumerate().map(course).collect()
}

fn refuse_repeated_numbers(tracks: &[wire::Track], ply: PlyPlace, findings: &mut Vec<Finding>) {
    let mut seen = std::collections::BTreeMap::new();
    for (index, track) in tracks.iter().enumerate() {
        if let Some(first) = seen.insert(track.number, index) {
            let message = format!("track number {} is that of track {first} too", track.number);
            findings.push(Finding::error(
                Code::DuplicateCourse,
                format!("{}/number", ply.course(index)),
                message,
            ));
        }
    }
}

fn check_course(ply: PlyPlace, index: usize, track: &wire::Track, findings: &mut Vec<Finding>) -> Course {
    let place = ply.course(index);
    let at = format!("{place}/points");
    let label = ply.label(track.number);
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
