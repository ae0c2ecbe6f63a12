//! The `input` of the honeycomb jobs, as they stand in JSON (jobs.md).
//!
//! These types know names and types, not meaning: [`super::input`] turns them once into what the planner works on.
//! The shapes beside them name every limit of a single number.

use serde::{Deserialize, Serialize};

use super::blade::Edges;
use crate::planning::document::files::FileReference;
use crate::planning::document::shape::{FILE, Field, Shape, optional, required};
use crate::planning::geometry::frame::Frame;
use crate::planning::robot::arm::{ARM, ArmReference};

/// The largest side of a blank, or coordinate of a frame, in mm.
const LARGEST_MM: f64 = 20_000.0;
/// The most points of a profile or a measured contour.
const MOST_POINTS: usize = 200_000;

/// The `input` of a honeycomb-cut job.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HoneycombCut {
    /// The blank.
    pub blank: Blank,
    /// The finished contour.
    pub profile: Profile,
    /// The blade.
    pub tool: Tool,
    /// Speeds and limits.
    pub process: Process,
    /// How it is cut.
    #[serde(default)]
    pub plan: Plan,
    /// The core (the paper's Table 2); it does not change the plan.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<Material>,
    /// The robot cell.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cell: Option<CellReference>,
    /// A contour that was measured on a cut part, to be compared with the profile.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub measured: Option<Profile>,
}

/// The `input` of a honeycomb-optimum job.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HoneycombOptimum {
    /// The blank.
    pub blank: Blank,
    /// A_C: the part of the blank's section that is cut away.
    pub machined_area_mm2: f64,
    /// The lattice.
    #[serde(default = "orthogonal")]
    pub lattice: LatticeChoice,
    /// The blade.
    pub tool: Tool,
    /// Speeds and limits.
    pub process: Process,
    /// The set to compare with.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub initial_parameters: Option<Parameters>,
}

/// The `input` of a honeycomb-convert job.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HoneycombConvert {
    /// The milling program.
    pub krl: FileReference,
    /// The blank.
    pub blank: Blank,
    /// The finished contour, against which the converted program is replayed, if it is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub profile: Option<Profile>,
    /// The blade.
    pub tool: Tool,
    /// Speeds and limits.
    pub process: Process,
    /// The swing angle, and the extension if it is not the blade's own.
    pub parameters: ConvertParameters,
    /// The robot cell.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cell: Option<CellReference>,
}

/// A blank: a box with one corner in the part's origin.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Blank {
    /// W, along x.
    pub width_mm: f64,
    /// D, along y.
    pub length_mm: f64,
    /// H, along z.
    pub height_mm: f64,
}

/// A contour: listed, or in a file.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Profile {
    /// x and z in mm, x never falling.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub points: Option<Vec<[f64; 2]>>,
    /// The name of a file with x and z a line.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
}

/// The blade.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tool {
    /// theta.
    pub rake_angle_deg: f64,
    /// beta.
    pub half_apex_angle_deg: f64,
    /// The longest part of the edge that may cut.
    pub max_cutting_length_mm: f64,
    /// The largest alpha.
    pub max_swing_angle_deg: f64,
    /// The whole edge; as long as the cutting length if it is left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub blade_length_mm: Option<f64>,
    /// Whether it cuts both ways.
    #[serde(default = "double")]
    pub edges: Edges,
}

/// Speeds and limits.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Process {
    /// v1.
    pub cutting_speed_mm_s: f64,
    /// v2.
    pub travel_speed_mm_s: f64,
    /// omega.
    pub angular_speed_deg_s: f64,
    /// h0: from the blank's top to the plane on which the tool travels.
    pub safety_distance_mm: f64,
    /// The largest distance of the cut surface from the contour.
    pub max_scallop_mm: f64,
    /// Material that stays above the contour everywhere.
    #[serde(default)]
    pub allowance_mm: f64,
}

/// How a part is cut.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Plan {
    /// The lattice.
    pub lattice: LatticeChoice,
    /// The order of the cuts.
    pub sequence: Sequence,
    /// Chosen by the sender, or the best.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub parameters: Option<Parameters>,
    /// The set to compare with.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub initial_parameters: Option<Parameters>,
}

impl Default for Plan {
    fn default() -> Self {
        let (lattice, sequence) = (LatticeChoice::Best, Sequence::Best);
        Self { lattice, sequence, parameters: None, initial_parameters: None }
    }
}

/// The lattice of the tips.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LatticeChoice {
    /// Columns below one another.
    Orthogonal,
    /// Every second layer shifted by half a step.
    Interlaced,
    /// Each layer for itself.
    Free,
    /// Interlaced in the bulk, on the contour last.
    Hybrid,
    /// The one with the shortest cycle.
    Best,
}

/// The order of the cuts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Sequence {
    /// Left out and right back at each tip, as published.
    Paired,
    /// All left cuts of a layer, then all right ones.
    Sweep,
    /// One posture, back over the stock.
    Oneway,
    /// The one with the shortest cycle.
    Best,
}

/// The parameters of a lattice: all three, or the swing angle and the overlap ratio.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Parameters {
    /// h.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub layer_spacing_mm: Option<f64>,
    /// s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub step_mm: Option<f64>,
    /// alpha.
    pub swing_angle_deg: f64,
    /// epsilon.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub overlap_ratio: Option<f64>,
}

/// The parameters of a conversion.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ConvertParameters {
    /// alpha.
    pub swing_angle_deg: f64,
    /// b; if it is left out, what the whole blade needs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub extension_mm: Option<f64>,
}

/// The core.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Material {
    /// Size of a cell.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cell_mm: Option<f64>,
    /// x, y or z.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ribbon_direction: Option<String>,
    /// kg/m^3.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub density_kg_m3: Option<f64>,
}

/// A robot cell by name, or a whole one.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(untagged)]
pub enum CellReference {
    /// A registered cell.
    Named(String),
    /// A cell of the job's own.
    Inline(Box<Cell>),
}

/// A robot cell: in a job, or the profile of a machine of kind `robot-cell`, which has a name then.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cell {
    /// Its name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Says that it is a robot cell.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub kind: Option<CellKind>,
    /// The arm: a built-in one by name, one in a file, or one described in full.
    pub robot: ArmReference,
    /// The tip in the flange.
    pub tool_frame: Frame,
    /// The part in the robot's frame.
    pub base_frame: Frame,
    /// Where programs begin and end.
    pub home_deg: [f64; 6],
    /// Along which axis of its frame the tool points.
    #[serde(default)]
    pub tool_direction: ToolDirection,
    /// The longest sub-program, in lines.
    #[serde(default = "most_lines")]
    pub max_program_lines: u32,
    /// The digital output of the ultrasonic generator.
    #[serde(default = "first_output")]
    pub ultrasonic_output: u32,
    /// How far the end of a free move may be rounded off.
    #[serde(default = "blend")]
    pub blend_mm: f64,
}

/// The only kind of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum CellKind {
    /// A robot cell.
    RobotCell,
}

/// Along which axis of its frame a tool points.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ToolDirection {
    /// Z.
    #[default]
    Z,
    /// X, as KUKA's own tools have it.
    X,
}

fn orthogonal() -> LatticeChoice {
    LatticeChoice::Orthogonal
}

fn double() -> Edges {
    Edges::Double
}

/// The longest sub-program in lines, if a cell does not say: controls load longer ones slowly.
pub const MOST_LINES: u32 = 2_500;
/// The output of the ultrasonic generator, if a cell does not say.
pub const FIRST_OUTPUT: u32 = 1;
/// How far the end of a free move may be rounded off, in mm, if a cell does not say.
pub const BLEND_MM: f64 = 2.0;

fn most_lines() -> u32 {
    MOST_LINES
}

fn first_output() -> u32 {
    FIRST_OUTPUT
}

fn blend() -> f64 {
    BLEND_MM
}

const LENGTH: Shape = Shape::Positive { max: LARGEST_MM };
const ANGLE: Shape = Shape::Number { min: -360.0, max: 360.0 };
const COORDINATE: Shape = Shape::Number { min: -LARGEST_MM, max: LARGEST_MM };
/// Speeds in a program have six decimals of m/s.
const SLOWEST_MM_S: f64 = 0.01;
const SPEED: Shape = Shape::Number { min: SLOWEST_MM_S, max: 10_000.0 };

const BLANK: Shape = Shape::Object(&[
    required("width_mm", LENGTH),
    required("length_mm", LENGTH),
    required("height_mm", LENGTH),
]);
const SECTION_POINT: Shape = Shape::Pair { limit: LARGEST_MM };
const PROFILE: Shape = Shape::Object(&[
    optional("points", Shape::Array { item: &SECTION_POINT, min: 0, max: MOST_POINTS }),
    optional("file", Shape::FileName),
]);
const TOOL: Shape = Shape::Object(&[
    required("rake_angle_deg", Shape::Number { min: 1.0, max: 90.0 }),
    required("half_apex_angle_deg", Shape::Number { min: 0.1, max: 45.0 }),
    required("max_cutting_length_mm", Shape::Positive { max: 1_000.0 }),
    required("max_swing_angle_deg", Shape::Number { min: 0.1, max: 89.0 }),
    optional("blade_length_mm", Shape::Positive { max: 1_000.0 }),
    optional("edges", Shape::Word(&["single", "double"])),
]);
const PROCESS: Shape = Shape::Object(&[
    required("cutting_speed_mm_s", SPEED),
    required("travel_speed_mm_s", SPEED),
    required("angular_speed_deg_s", Shape::Number { min: 0.01, max: 10_000.0 }),
    required("safety_distance_mm", LENGTH),
    required("max_scallop_mm", LENGTH),
    optional("allowance_mm", Shape::Number { min: 0.0, max: 1_000.0 }),
]);
const PARAMETERS: Shape = Shape::Object(&[
    optional("layer_spacing_mm", LENGTH),
    optional("step_mm", LENGTH),
    required("swing_angle_deg", Shape::Number { min: 0.1, max: 89.0 }),
    optional("overlap_ratio", Shape::Number { min: 0.0, max: 0.99 }),
]);
const LATTICES: &[&str] = &["orthogonal", "interlaced", "free", "hybrid", "best"];
const PLAN: Shape = Shape::Object(&[
    optional("lattice", Shape::Word(LATTICES)),
    optional("sequence", Shape::Word(&["paired", "sweep", "oneway", "best"])),
    optional("parameters", PARAMETERS),
    optional("initial_parameters", PARAMETERS),
]);
const MATERIAL: Shape = Shape::Object(&[
    optional("cell_mm", Shape::Positive { max: 1_000.0 }),
    optional("ribbon_direction", Shape::Word(&["x", "y", "z"])),
    optional("density_kg_m3", Shape::Positive { max: 10_000.0 }),
]);
const FRAME: Shape = Shape::Object(&[
    required("x_mm", COORDINATE),
    required("y_mm", COORDINATE),
    required("z_mm", COORDINATE),
    required("a_deg", ANGLE),
    required("b_deg", ANGLE),
    required("c_deg", ANGLE),
]);
const HOME: Shape = Shape::Array { item: &ANGLE, min: 6, max: 6 };
const ROBOT: Shape = Shape::TextOr { max_chars: 64, shape: &Shape::ObjectOrFile(&ARM) };
const CELL_NAME: Shape = Shape::Name { max_chars: 64 };
const CELL_KIND: Shape = Shape::Word(&["robot-cell"]);

/// A cell's fields: a machine has a name and says its kind, a cell in a job may.
const fn cell_fields(named: bool) -> [Field; 10] {
    [
        Field { name: "name", required: named, shape: CELL_NAME },
        Field { name: "kind", required: named, shape: CELL_KIND },
        required("robot", ROBOT),
        required("tool_frame", FRAME),
        required("base_frame", FRAME),
        required("home_deg", HOME),
        optional("tool_direction", Shape::Word(&["z", "x"])),
        optional("max_program_lines", Shape::Integer { min: 100, max: 100_000 }),
        optional("ultrasonic_output", Shape::Integer { min: 1, max: 4_096 }),
        optional("blend_mm", Shape::Number { min: 0.0, max: 100.0 }),
    ]
}

const CELL_IN_A_JOB: [Field; 10] = cell_fields(false);
const MACHINE: [Field; 10] = cell_fields(true);
const CELL: Shape = Shape::TextOr { max_chars: 64, shape: &Shape::Object(&CELL_IN_A_JOB) };

/// The fields of a robot cell's profile.
pub const ROBOT_CELL: &[Field] = &MACHINE;

/// The fields of a honeycomb-cut job's `input`.
pub const HONEYCOMB_CUT: &[Field] = &[
    required("blank", BLANK),
    required("profile", PROFILE),
    required("tool", TOOL),
    required("process", PROCESS),
    optional("plan", PLAN),
    optional("material", MATERIAL),
    optional("cell", CELL),
    optional("measured", PROFILE),
];

/// The fields of a honeycomb-optimum job's `input`.
pub const HONEYCOMB_OPTIMUM: &[Field] = &[
    required("blank", BLANK),
    required("machined_area_mm2", Shape::Positive { max: LARGEST_MM * LARGEST_MM }),
    optional("lattice", Shape::Word(LATTICES)),
    required("tool", TOOL),
    required("process", PROCESS),
    optional("initial_parameters", PARAMETERS),
];

/// The fields of a honeycomb-convert job's `input`.
pub const HONEYCOMB_CONVERT: &[Field] = &[
    required("krl", FILE),
    required("blank", BLANK),
    optional("profile", PROFILE),
    required("tool", TOOL),
    required("process", PROCESS),
    required(
        "parameters",
        Shape::Object(&[
            required("swing_angle_deg", Shape::Number { min: 0.1, max: 89.0 }),
            optional("extension_mm", LENGTH),
        ]),
    ),
    optional("cell", CELL),
];
