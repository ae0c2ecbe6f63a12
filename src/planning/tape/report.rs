//! The fields of a tape-cut report (jobs.md).

use serde::{Serialize, Serializer};

use super::chain::Slope;
use super::input::TapeInput;
use super::plan::{PlannedCourse, PlannedPiece, TapePlan};
use super::roll::RollFigures;
use super::sliver::Marks;
use super::tips::Tip;
use crate::planning::geometry::Point2;
use crate::planning::program::moves::TapeProgram;
use crate::planning::program::replay::ReplayFigures;

/// The fields of a report that are the kind's own.
#[derive(Debug, Clone, Serialize)]
pub struct TapeReport<'a> {
    machine: MachineReport,
    courses: Vec<CourseReport<'a>>,
    roll: RollFigures,
    manifest: Vec<ManifestEntry<'a>>,
    /// Cycle time in s, each move from rest to rest with the profile's accelerations.
    time_s: f64,
    /// A lower bound of it: each axis alone at its limit of speed, with the dwells of its knife.
    bound_time_s: f64,
    replay: ReplayFigures,
    /// Where two knives meet, and how far they miss one another for the errors in the profile.
    tips: Vec<Tip>,
    /// Outlines changed on the scrap side to suit the knives.
    simplified: Vec<SimplifiedReport>,
    /// The course from which on the program goes.
    #[serde(skip_serializing_if = "Option::is_none")]
    from_course: Option<u32>,
    /// The ply of that course, where there are several.
    #[serde(skip_serializing_if = "Option::is_none")]
    from_ply: Option<u32>,
    /// How much of `time_s` is the tape's way from 0 to where that course begins: nothing if it stands there already.
    #[serde(skip_serializing_if = "Option::is_none")]
    approach_s: Option<f64>,
    /// The program is a dry run; the figures of the replay are those of the program that cuts.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    dry_run: bool,
}

/// How far a course's outlines were changed.
#[derive(Debug, Clone, Serialize)]
struct SimplifiedReport {
    /// Here and below: the ply, from 1, and its name, where there are several.
    #[serde(skip_serializing_if = "Option::is_none")]
    ply: Option<u32>,
    course: u32,
    /// Along the tape, in mm.
    max_deviation_mm: f64,
    /// Left to be trimmed.
    extra_area_mm2: f64,
}

/// The machine that was planned for. The program runs on machines of exactly this profile.
#[derive(Debug, Clone, Serialize)]
struct MachineReport {
    name: String,
    /// Of the profile without its name.
    profile_sha256: String,
}

#[derive(Debug, Clone, Serialize)]
struct CourseReport<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    ply: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    ply_name: Option<&'a str>,
    number: u32,
    pieces: Vec<PieceReport<'a>>,
}

#[derive(Debug, Clone, Serialize)]
struct PieceReport<'a> {
    area_mm2: f64,
    roll_offset_mm: f64,
    cuts: Vec<CutReport<'a>>,
}

/// A chain of a cut: what one knife makes.
#[derive(Debug, Clone, Serialize)]
struct CutReport<'a> {
    /// Which cut of the piece it belongs to, from 0.
    cut: usize,
    cutter: usize,
    slope: Slope,
    turns: usize,
    /// Whether it is made as the start of the next course in r, whose outline is the same there.
    shared: bool,
    #[serde(serialize_with = "pairs")]
    points_uv: &'a [Point2],
}

/// Of a large ply these are too many for a copy.
fn pairs<S: Serializer>(points: &[Point2], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(points.iter().map(|point| [point.x, point.y]))
}

/// A piece as the cassette gives it out.
#[derive(Debug, Clone, Serialize)]
struct ManifestEntry<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    ply: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    ply_name: Option<&'a str>,
    course: u32,
    /// Piece of the course, from 1, in laying direction.
    piece: usize,
    length_mm: f64,
    area_mm2: f64,
    /// Roll coordinates of its start and its end.
    roll_mm: [f64; 2],
    #[serde(flatten)]
    marks: Marks,
}

impl<'a> TapeReport<'a> {
    /// Puts a report together.
    #[must_use]
    pub fn new(
        plan: &'a TapePlan,
        input: &'a TapeInput,
        program: &TapeProgram,
        bound_time_s: f64,
        replay: ReplayFigures,
        tips: Vec<Tip>,
    ) -> Self {
        let courses = plan.courses.iter().map(|course| CourseReport {
            ply: course.label.ply,
            ply_name: ply_name(course, input),
            number: course.label.number,
            pieces: course.pieces.iter().map(piece_report).collect(),
        });
        let machine = &input.machine;
        let (name, profile_sha256) = (machine.name.clone(), machine.profile_sha256.clone());
        Self {
            machine: MachineReport { name, profile_sha256 },
            courses: courses.collect(),
            roll: plan.figures,
            manifest: manifest(plan, input),
            time_s: program.time_s,
            bound_time_s,
            replay,
            simplified: plan.courses.iter().filter_map(simplified_report).collect(),
            tips,
            from_course: input.from_course.map(|course| course.number),
            from_ply: input.from_course.and_then(|course| course.ply),
            approach_s: input.from_course.map(|_| program.approach_s),
            dry_run: input.dry_run,
        }
    }
}

/// The name of a course's ply, where there are several and it has one.
fn ply_name<'a>(course: &PlannedCourse, input: &'a TapeInput) -> Option<&'a str> {
    let ply = input.ply(course.place.ply).filter(|ply| ply.place.number.is_some())?;
    (!ply.name.is_empty()).then_some(ply.name.as_str())
}

fn simplified_report(course: &PlannedCourse) -> Option<SimplifiedReport> {
    let changes: Vec<(f64, f64)> = course.pieces.iter().filter_map(|piece| piece.simplified).collect();
    (!changes.is_empty()).then(|| SimplifiedReport {
        ply: course.label.ply,
        course: course.label.number,
        max_deviation_mm: changes.iter().map(|change| change.0).fold(0.0, f64::max),
        extra_area_mm2: changes.iter().map(|change| change.1).sum(),
    })
}

fn piece_report(piece: &PlannedPiece) -> PieceReport<'_> {
    let cuts = piece.chains.iter().map(|(chain, cutter)| CutReport {
        cut: chain.cut,
        cutter: cutter + 1,
        slope: chain.slope,
        turns: chain.turns,
        shared: piece.shares(chain),
        points_uv: &chain.points,
    });
    PieceReport { area_mm2: piece.piece.area_mm2, roll_offset_mm: piece.offset_mm, cuts: cuts.collect() }
}

/// The last piece wound comes off the cassette first: the smallest roll coordinate.
fn manifest<'a>(plan: &TapePlan, input: &'a TapeInput) -> Vec<ManifestEntry<'a>> {
    plan.order
        .iter()
        .zip(plan.pieces())
        .map(|(&(_, index), (course, piece))| {
            let (low, high) = piece.piece.u_range();
            ManifestEntry {
                ply: course.label.ply,
                ply_name: ply_name(course, input),
                course: course.label.number,
                piece: index + 1,
                length_mm: high - low,
                area_mm2: piece.piece.area_mm2,
                roll_mm: [low + piece.offset_mm, high + piece.offset_mm],
                marks: piece.marks,
            }
        })
        .collect()
}
