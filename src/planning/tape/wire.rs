//! The `input` of a tape-cut job and a machine profile, as they stand in JSON.
//!
//! These types know names and types, not meaning: [`super::input`] and [`super::machine`] turn them once into
//! what the planner works on. The shapes beside them name every limit of a single number.

use serde::{Deserialize, Serialize};

use crate::planning::document::shape::{Field, Shape, optional, required};

mod plies;
mod points;
mod spool;
mod words;

pub use self::plies::{MOST_PLIES, Ply, PlyFields};
pub use self::points::Points;
pub use self::spool::Spool;
pub use self::words::{KnifeWords, UltrasonicWords, Words};

/// The largest coordinate in mm: a mould of 100 m.
pub const LARGEST_MM: f64 = 100_000.0;
/// The most points of one outline or course.
pub const MOST_POINTS: usize = 5_000_000;
/// The most holes or courses of a ply.
pub const MOST_LOOPS: usize = 10_000;
/// The largest number of a course.
pub const LARGEST_NUMBER: u32 = 1_000_000;
/// The longest tape in mm: 10 km.
const LONGEST_TAPE_MM: f64 = 1e7;
/// The most defects and splices of one tape.
const MOST_ZONES: usize = 1_000;
/// Far above the speed or acceleration of any machine, in mm/s, mm/s^2, deg/s or deg/s^2.
const LARGEST_RATE: f64 = 1e6;
/// Narrower than any tape that is slit, in mm; what is meant in metres or inches is found so.
const NARROWEST_MM: f64 = 1.0;
/// The longest dwell in s.
const LONGEST_DWELL_S: f64 = 10.0;
/// A control whose lines are shorter, in characters, takes no program: the header alone is longer, and a block that
/// moves every axis nearly so.
const SHORTEST_LINE: i64 = 80;
/// The largest digital output of a controller.
const LARGEST_OUTPUT: i64 = 63;

/// The `input` of a tape-cut job.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TapeCut {
    /// The tape.
    pub tape: Tape,
    /// The outline of its one ply.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub boundary: Option<Outline>,
    /// Its cut-outs.
    #[serde(default)]
    pub holes: Vec<Outline>,
    /// Its courses in laying order.
    #[serde(default)]
    pub tracks: Option<Tracks>,
    /// A rule that generates the courses of a flat ply.
    #[serde(default)]
    pub courses: Option<Courses>,
    /// In place of these four: the plies of the roll in laying order.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub plies: Option<Vec<Ply>>,
    /// The machine: a name, or a whole profile.
    pub machine: MachineReference,
    /// What may be chosen.
    #[serde(default)]
    pub options: Options,
}

/// The tape.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tape {
    /// Width in mm.
    pub width_mm: f64,
    /// Thickness in mm.
    pub thickness_mm: f64,
    /// How much tape is left on the spool, in mm, where that is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub length_mm: Option<f64>,
    /// Defects and splices: from, to in mm of tape from its leading end as it comes off the spool.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub zones_mm: Vec<[f64; 2]>,
}

/// Closed loops of points in mm: one listed, or those of a file.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Outline {
    /// X, Y, Z in mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub points: Option<Vec<[f64; 3]>>,
    /// The name of an uploaded file or of one beside the job.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// The layers of a DXF drawing that hold the outlines.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub layers: Option<Layers>,
}

/// The layers of a DXF drawing, where they are not those of ASTM D6673.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Layers {
    /// The layer of the ply's outline; 1 if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub boundary: Option<String>,
    /// The layer of its cut-outs, which may be the same; 11 if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cut_outs: Option<String>,
}

/// Courses: listed, or in a file.
#[derive(Debug, Clone, Serialize)]
#[serde(untagged)]
pub enum Tracks {
    /// Listed in laying order.
    Listed(Vec<Track>),
    /// In a file.
    File {
        /// The name of an uploaded file or of one beside the job.
        file: String,
    },
}

/// A rule that generates the courses of a flat ply.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Courses {
    /// Fibre angle.
    pub angle_deg: f64,
    /// Gap between neighbouring tapes.
    #[serde(default)]
    pub gap_mm: f64,
    /// Offset of the first course.
    #[serde(default)]
    pub offset_mm: f64,
}

/// A course.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Track {
    /// Its number, one of its kind in the ply.
    pub number: u32,
    /// Points on the centre line of the tape.
    pub points: Vec<TrackPoint>,
}

/// A point of a course.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrackPoint {
    /// X, Y, Z in mm.
    pub position: [f64; 3],
    /// The mould's outward normal there.
    pub normal: [f64; 3],
}

/// A machine by name, or a whole profile.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(untagged)]
pub enum MachineReference {
    /// A built-in or registered profile.
    Named(String),
    /// A profile of the job's own.
    Inline(Box<MachineProfile>),
}

/// What may be chosen for a job.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Options {
    /// What to do with a shape that needs more knives than there are.
    pub on_excess: OnExcess,
    /// How cuts are given to knives.
    pub allocation: Allocation,
    /// How the pieces are wound on the cassette.
    pub roll_order: RollOrder,
    /// Scrap between pieces along U, in mm.
    pub scrap_gap_mm: f64,
    /// Whether two congruent outlines may share one cut.
    pub share_cuts: bool,
    /// Chord tolerance in mm.
    pub tolerance_mm: f64,
    /// The laying head's shortest length in mm, if it has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shortest_piece_mm: Option<f64>,
    /// The course from which on the program goes, if not from the start.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub from_course: Option<u32>,
    /// The ply that this course is of, from 1, where there are several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub from_ply: Option<u32>,
    /// The same moves with knives up and the generator off.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub dry_run: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            on_excess: OnExcess::Reject,
            allocation: Allocation::BySlope,
            roll_order: RollOrder::Reverse,
            scrap_gap_mm: 0.0,
            share_cuts: false,
            tolerance_mm: crate::planning::tolerance::CHORD_MM,
            shortest_piece_mm: None,
            from_course: None,
            from_ply: None,
            dry_run: false,
        }
    }
}

/// What to do with a shape that needs more knives than there are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OnExcess {
    /// Refuse it.
    Reject,
    /// Cut a simpler outline on the scrap side.
    Simplify,
}

/// How cuts are given to knives.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Allocation {
    /// As published: `\` to cutter 1, `/` to cutter 2.
    BySlope,
    /// Any valid way.
    Free,
}

/// How the pieces are wound on the cassette.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RollOrder {
    /// The last course is cut first, so that the cassette gives out the first.
    Reverse,
    /// The first course is cut first.
    Laying,
}

/// A machine profile of kind `tape-cutter` (jobs.md).
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MachineProfile {
    /// Its name.
    pub name: String,
    /// Always `tape-cutter`.
    pub kind: String,
    /// The language of its control.
    pub dialect: Dialect,
    /// The side of the tape on which the knives work.
    pub cut_side: CutSide,
    /// The tape.
    pub feed: Feed,
    /// Speed of a knife along its cut in the tape, whatever the axes could do, in mm/s.
    pub max_cutting_path_speed_mm_s: f64,
    /// One or two cutters.
    pub cutters: Vec<Cutter>,
    /// The generator of the knives.
    pub ultrasonic: Output,
    /// Distance that the carriages keep where they share a beam, in mm.
    pub carriage_clearance_mm: f64,
    /// How programs are written.
    pub program: Program,
}

/// The language of a control.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Dialect {
    /// RS-274 as LinuxCNC reads it.
    Linuxcnc,
    /// Sinumerik.
    Sinumerik,
}

/// The side of the tape on which the knives work.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CutSide {
    /// The side that later touches the mould.
    Film,
    /// The other one.
    Paper,
}

/// The tape axis.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Feed {
    /// Axis letter.
    pub axis: String,
    /// By length or by the angle of a spool.
    pub drive: Drive,
    /// mm/s.
    pub max_speed_mm_s: f64,
    /// mm/s^2.
    pub max_acceleration_mm_s2: f64,
    /// The longest tape in one program, in mm.
    pub max_length_mm: f64,
    /// The spool whose angle is driven.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spool: Option<Spool>,
    /// How far off the tape may stand, in mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error_mm: Option<f64>,
}

/// What drives the tape.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Drive {
    /// A measuring encoder: the axis reads mm.
    Length,
    /// An unwinding spool: the axis reads degrees.
    UnwindAngle,
    /// A take-up spool: the axis reads degrees.
    TakeupAngle,
}

/// A cutter.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cutter {
    /// 1 is nearer the spool.
    pub number: u32,
    /// Distance downstream of cutter 1, in mm.
    pub station_mm: f64,
    /// Across the tape.
    pub lateral: Lateral,
    /// The blade's direction.
    pub blade: Blade,
    /// The press.
    pub knife: Knife,
}

/// The axis across the tape.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Lateral {
    /// Axis letter.
    pub axis: String,
    /// mm.
    pub min_mm: f64,
    /// mm.
    pub max_mm: f64,
    /// mm/s with the knife down.
    pub cutting_speed_mm_s: f64,
    /// mm/s with the knife up.
    pub travel_speed_mm_s: f64,
    /// mm/s^2.
    pub max_acceleration_mm_s2: f64,
    /// How far off the carriage may stand, in mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error_mm: Option<f64>,
    /// Where the carriage stands at the start and at the end, and goes when it is in the way, in mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub park_mm: Option<f64>,
}

/// The axis that turns the blade.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Blade {
    /// Axis letter.
    pub axis: String,
    /// Whether it cuts both ways.
    pub edges: Edges,
    /// deg/s.
    pub max_speed_deg_s: f64,
    /// deg/s^2.
    pub max_acceleration_deg_s2: f64,
    /// degrees.
    pub min_deg: f64,
    /// degrees.
    pub max_deg: f64,
    /// A sharper corner is turned with the knife up, in degrees.
    pub lift_angle_deg: f64,
    /// Distance of the edge from the turning axis, in mm.
    pub offset_mm: f64,
    /// How far a cut goes on past its ends, in mm.
    pub overcut_mm: f64,
}

/// Whether a blade cuts both ways.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Edges {
    /// One direction only.
    Single,
    /// Both.
    Double,
}

/// The press of a knife.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Knife {
    /// Number of the digital output.
    pub output: u32,
    /// s.
    pub down_dwell_s: f64,
    /// s.
    pub up_dwell_s: f64,
}

/// A digital output.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Output {
    /// Its number.
    pub output: u32,
}

/// How programs are written.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Program {
    /// Whether the operator may stop before each course.
    pub optional_stop_per_course: bool,
    /// The longest line.
    pub max_line_characters: u32,
    /// How a control without outputs of its own switches knives and generator.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub words: Option<Words>,
}

const POINT: Shape = Shape::Triple { limit: LARGEST_MM };
const OUTLINE: Shape = Shape::Object(&[
    optional("points", Shape::Array { item: &POINT, min: 0, max: MOST_POINTS }),
    optional("file", Shape::FileName),
    optional("layers", Shape::Object(&[optional("boundary", LAYER), optional("cut_outs", LAYER)])),
]);
/// The longest name of a layer that CAD systems take.
const LAYER: Shape = Shape::Text { max_chars: 255 };
const TRACK_POINT: Shape = Shape::Object(&[required("position", POINT), required("normal", POINT)]);
const TRACK: Shape = Shape::Object(&[
    required("number", Shape::Integer { min: 1, max: LARGEST_NUMBER as i64 }),
    required("points", Shape::Array { item: &TRACK_POINT, min: 0, max: MOST_POINTS }),
]);
const HOLES: Shape = Shape::Array { item: &OUTLINE, min: 0, max: MOST_LOOPS };
const TRACKS: Shape = Shape::ArrayOrFile(&Shape::Array { item: &TRACK, min: 1, max: MOST_LOOPS });
const COURSES: Shape = Shape::Object(&[
    required("angle_deg", Shape::Number { min: -360.0, max: 360.0 }),
    optional("gap_mm", Shape::Number { min: -100.0, max: 10_000.0 }),
    optional("offset_mm", COORDINATE),
]);
const RATE: Shape = Shape::Positive { max: LARGEST_RATE };
const COORDINATE: Shape = Shape::Number { min: -LARGEST_MM, max: LARGEST_MM };
const DWELL: Shape = Shape::Number { min: 0.0, max: LONGEST_DWELL_S };
/// An axis that is off by more cuts no pieces.
const ERROR: Shape = Shape::Number { min: 0.0, max: 10.0 };
const OUTPUT: Shape = Shape::Integer { min: 0, max: LARGEST_OUTPUT };
const AXIS: Shape = Shape::Word(&["U", "V", "W", "A", "B", "C", "X", "Y", "Z"]);
const CUTTER: Shape = Shape::Object(&[
    required("number", Shape::Integer { min: 1, max: 2 }),
    required("station_mm", Shape::Number { min: 0.0, max: LARGEST_MM }),
    required(
        "lateral",
        Shape::Object(&[
            required("axis", AXIS),
            required("min_mm", COORDINATE),
            required("max_mm", COORDINATE),
            required("cutting_speed_mm_s", RATE),
            required("travel_speed_mm_s", RATE),
            required("max_acceleration_mm_s2", RATE),
            optional("error_mm", ERROR),
            optional("park_mm", COORDINATE),
        ]),
    ),
    required(
        "blade",
        Shape::Object(&[
            required("axis", AXIS),
            required("edges", Shape::Word(&["single", "double"])),
            required("max_speed_deg_s", RATE),
            required("max_acceleration_deg_s2", RATE),
            required("min_deg", Shape::Number { min: -36_000.0, max: -180.0 }),
            required("max_deg", Shape::Number { min: 180.0, max: 36_000.0 }),
            required("lift_angle_deg", Shape::Number { min: 0.0, max: 180.0 }),
            required("offset_mm", Shape::Number { min: -100.0, max: 100.0 }),
            required("overcut_mm", Shape::Number { min: 0.0, max: 100.0 }),
        ]),
    ),
    required(
        "knife",
        Shape::Object(&[
            required("output", OUTPUT),
            required("down_dwell_s", DWELL),
            required("up_dwell_s", DWELL),
        ]),
    ),
]);

/// The fields of a tape cutter's profile.
pub const TAPE_CUTTER: &[Field] = &[
    required("name", Shape::Name { max_chars: 64 }),
    required("kind", Shape::Word(&["tape-cutter"])),
    required("dialect", Shape::Word(&["linuxcnc", "sinumerik"])),
    required("cut_side", Shape::Word(&["film", "paper"])),
    required(
        "feed",
        Shape::Object(&[
            required("axis", AXIS),
            required("drive", Shape::Word(&["length", "unwind_angle", "takeup_angle"])),
            required("max_speed_mm_s", RATE),
            required("max_acceleration_mm_s2", RATE),
            required("max_length_mm", Shape::Positive { max: LONGEST_TAPE_MM }),
            optional("spool", spool::SPOOL),
            optional("error_mm", ERROR),
        ]),
    ),
    required("max_cutting_path_speed_mm_s", RATE),
    required("cutters", Shape::Array { item: &CUTTER, min: 1, max: 2 }),
    required("ultrasonic", Shape::Object(&[required("output", OUTPUT)])),
    required("carriage_clearance_mm", Shape::Number { min: 0.0, max: 10_000.0 }),
    required(
        "program",
        Shape::Object(&[
            required("optional_stop_per_course", Shape::Boolean),
            required("max_line_characters", Shape::Integer { min: SHORTEST_LINE, max: 250 }),
            optional("words", words::WORDS),
        ]),
    ),
];

const MACHINE_PROFILE: Shape = Shape::Object(TAPE_CUTTER);

/// The fields of a tape-cut job's `input`.
pub const TAPE_CUT: &[Field] = &[
    required(
        "tape",
        Shape::Object(&[
            required("width_mm", Shape::Number { min: NARROWEST_MM, max: 2_000.0 }),
            required("thickness_mm", Shape::Positive { max: 10.0 }),
            optional("length_mm", Shape::Positive { max: LONGEST_TAPE_MM }),
            optional(
                "zones_mm",
                Shape::Array { item: &Shape::Pair { limit: LONGEST_TAPE_MM }, min: 0, max: MOST_ZONES },
            ),
        ]),
    ),
    optional("boundary", OUTLINE),
    optional("holes", HOLES),
    optional("tracks", TRACKS),
    optional("courses", COURSES),
    optional("plies", plies::PLIES),
    required("machine", Shape::TextOr { max_chars: 64, shape: &MACHINE_PROFILE }),
    optional(
        "options",
        Shape::Object(&[
            optional("on_excess", Shape::Word(&["reject", "simplify"])),
            optional("allocation", Shape::Word(&["by_slope", "free"])),
            optional("roll_order", Shape::Word(&["reverse", "laying"])),
            optional("scrap_gap_mm", Shape::Number { min: 0.0, max: 10_000.0 }),
            optional("share_cuts", Shape::Boolean),
            optional("tolerance_mm", Shape::Number { min: 0.001, max: 1.0 }),
            optional("shortest_piece_mm", Shape::Positive { max: LARGEST_MM }),
            optional("from_course", Shape::Integer { min: 1, max: 1_000_000 }),
            optional("from_ply", Shape::Integer { min: 1, max: MOST_PLIES as i64 }),
            optional("dry_run", Shape::Boolean),
        ]),
    ),
];
