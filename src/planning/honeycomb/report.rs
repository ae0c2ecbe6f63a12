//! The figures of the honeycomb jobs, as `report.json` has them (jobs.md).

use serde::Serialize;

use super::attempt::Attempt;
use super::cell::Identity;
use super::contour::Likeness;
use super::milling::ConeTool;
use super::model::estimate::Estimate;
use super::optimum::Optimum;
use super::replay::{Replay, Times};
use crate::planning::robot::check::RobotCheck;

/// What a honeycomb report holds beside what every report holds.
#[derive(Debug, Default, Serialize)]
pub struct HoneycombReport {
    /// The cell that the program is for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub machine: Option<MachineFigures>,
    /// The lattice that was taken.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lattice: Option<&'static str>,
    /// The order of the cuts.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sequence: Option<&'static str>,
    /// Its parameters.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub parameters: Option<ParameterFigures>,
    /// What the published model says of them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub estimate: Option<EstimateFigures>,
    /// What the program does, counted on its own text.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub exact: Option<ExactFigures>,
    /// The same for the paper's way on this section.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub published: Option<ExactFigures>,
    /// The same for the set to compare with.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub initial: Option<ExactFigures>,
    /// The tool for the milling path that is attached.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cone_tool: Option<ConeFigures>,
    /// What a conversion gave.
    #[serde(flatten)]
    pub conversion: Option<ConversionFigures>,
    /// What the robot does.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub robot: Option<RobotFigures>,
    /// How like a measured contour is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub measured: Option<LikenessFigures>,
}

/// The cell that a program is for.
#[derive(Debug, Serialize)]
pub struct MachineFigures {
    name: String,
    profile_sha256: String,
}

/// h, s, alpha and what follows from them.
#[derive(Debug, Serialize)]
pub struct ParameterFigures {
    layer_spacing_mm: f64,
    step_mm: f64,
    swing_angle_deg: f64,
    cutting_length_mm: f64,
    extension_mm: f64,
    overlap_ratio: f64,
}

/// What the published model says.
#[derive(Debug, Serialize)]
pub struct EstimateFigures {
    time_s: f64,
    #[serde(flatten)]
    split: Split,
    points: f64,
    layers: f64,
    scallop_mm: f64,
    /// What it says of the set to compare with.
    #[serde(skip_serializing_if = "Option::is_none")]
    initial_time_s: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    initial_scallop_mm: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    initial_split: Option<Split>,
    /// How much less time, in percent of the set to compare with.
    #[serde(skip_serializing_if = "Option::is_none")]
    saved_percent: Option<f64>,
    /// The limits that the optimum lies on.
    active: Vec<&'static str>,
    /// How much the time would fall if a limit gave way, scaled: one for each active limit.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    multipliers: Vec<f64>,
    /// How far the optimum is from Karush's, Kuhn's and Tucker's conditions; none where parameters were chosen.
    #[serde(skip_serializing_if = "Option::is_none")]
    kkt_residual: Option<f64>,
}

/// Where time goes, in s.
#[derive(Debug, Serialize)]
pub struct Split {
    cutting_s: f64,
    turning_s: f64,
    moving_s: f64,
}

/// What a program does.
#[derive(Debug, Serialize)]
pub struct ExactFigures {
    lattice: &'static str,
    layer_spacing_mm: f64,
    step_mm: f64,
    swing_angle_deg: f64,
    tips: usize,
    layers: usize,
    time_s: f64,
    #[serde(flatten)]
    split: Split,
    max_scallop_mm: f64,
    residual_area_mm2: f64,
    gouge_area_mm2: f64,
    max_gouge_mm: f64,
    stuck_chips: usize,
    chips: usize,
    cut_deviation_mm: f64,
    correlation: Option<f64>,
    correlation_mean_removed: Option<f64>,
    max_deviation_mm: Option<f64>,
    bound_tips: u32,
    usable: bool,
}

/// A cone that stands for the blade in a CAM system.
#[derive(Debug, Serialize)]
pub struct ConeFigures {
    full_angle_deg: f64,
    flank_mm: f64,
}

impl From<ConeTool> for ConeFigures {
    fn from(cone: ConeTool) -> Self {
        Self { full_angle_deg: cone.full_angle_deg, flank_mm: cone.flank_mm }
    }
}

/// What a conversion gave, with the names that `honeycomb-cut` reports have.
#[derive(Debug, Serialize)]
pub struct ConversionFigures {
    parameters: ConvertedParameters,
    exact: ConvertedFigures,
}

/// What a conversion was made with.
#[derive(Debug, Serialize)]
struct ConvertedParameters {
    swing_angle_deg: f64,
    extension_mm: f64,
}

/// What a converted program does.
#[derive(Debug, Serialize)]
struct ConvertedFigures {
    milling_cuts: usize,
    tips: usize,
    time_s: f64,
    #[serde(flatten)]
    split: Split,
    max_scallop_mm: Option<f64>,
    residual_area_mm2: f64,
    gouge_area_mm2: f64,
    stuck_chips: usize,
    chips: usize,
    cut_deviation_mm: f64,
    correlation: Option<f64>,
    correlation_mean_removed: Option<f64>,
    max_deviation_mm: Option<f64>,
}

/// What the robot does.
#[derive(Debug, Default, Serialize)]
pub struct RobotFigures {
    /// Whether there is a robot to check.
    pub checked: bool,
    reachable: Option<bool>,
    min_joint_margin_deg: Option<f64>,
    min_singularity_margin: Option<f64>,
    max_joint_speed_ratio: Option<f64>,
    first_fault: Option<FaultFigures>,
    /// What the program that the robot follows takes; longer than `exact.time_s` where it had to be slowed.
    time_s: Option<f64>,
}

/// The first fault of a robot.
#[derive(Debug, Serialize)]
struct FaultFigures {
    at: String,
    message: String,
}

/// How like a contour is to the wanted one.
#[derive(Debug, Serialize)]
pub struct LikenessFigures {
    correlation: Option<f64>,
    correlation_mean_removed: Option<f64>,
    max_deviation_mm: f64,
    max_deviation_x_mm: f64,
}

impl From<&Identity> for MachineFigures {
    fn from(identity: &Identity) -> Self {
        Self { name: identity.name.clone(), profile_sha256: identity.sha256.clone() }
    }
}

impl ParameterFigures {
    /// `extension_mm` is what the program goes on by, not the model's.
    #[must_use]
    pub fn new(estimate: &Estimate, extension_mm: f64) -> Self {
        Self {
            layer_spacing_mm: estimate.parameters.layer_spacing_mm,
            step_mm: estimate.parameters.step_mm,
            swing_angle_deg: estimate.parameters.swing_rad.to_degrees(),
            cutting_length_mm: estimate.cutting_length_mm,
            extension_mm,
            overlap_ratio: estimate.overlap_ratio,
        }
    }
}

impl EstimateFigures {
    /// Of a set of parameters, the optimum that it is, and the set to compare with.
    #[must_use]
    pub fn new(estimate: &Estimate, optimum: Option<&Optimum>, initial: Option<&Estimate>) -> Self {
        Self {
            time_s: estimate.time_s,
            split: Split::of_model(estimate),
            points: estimate.points,
            layers: estimate.layers,
            scallop_mm: estimate.scallop_mm,
            initial_time_s: initial.map(|initial| initial.time_s),
            initial_scallop_mm: initial.map(|initial| initial.scallop_mm),
            initial_split: initial.map(Split::of_model),
            saved_percent: initial.map(|initial| (1.0 - estimate.time_s / initial.time_s) * 100.0),
            active: optimum
                .map_or_else(Vec::new, |optimum| optimum.active.iter().map(|a| a.limit.as_str()).collect()),
            multipliers: optimum
                .map_or_else(Vec::new, |optimum| optimum.active.iter().map(|a| a.multiplier).collect()),
            kkt_residual: optimum.map(|optimum| optimum.kkt_residual),
        }
    }
}

impl Split {
    fn of_model(estimate: &Estimate) -> Self {
        Self { cutting_s: estimate.cutting_s, turning_s: estimate.turning_s, moving_s: estimate.moving_s }
    }
}

impl Split {
    fn of_replay(times: &Times) -> Self {
        Self { cutting_s: times.cutting_s, turning_s: times.turning_s, moving_s: times.moving_s }
    }
}

impl ExactFigures {
    /// Of a program that was read back and replayed.
    #[must_use]
    pub fn new(attempt: &Attempt, likeness: Option<&Likeness>, bound_tips: u32) -> Self {
        let (replay, remains) = (&attempt.replay, attempt.replay.swept.remains.as_ref());
        let times = replay.times;
        Self {
            lattice: attempt.lattice.as_str(),
            layer_spacing_mm: attempt.spacing.layer,
            step_mm: attempt.spacing.step,
            swing_angle_deg: attempt.spacing.swing.to_degrees(),
            tips: replay.tips(),
            layers: attempt.tips.len(),
            time_s: times.total_s(),
            split: Split::of_replay(&times),
            max_scallop_mm: remains.and_then(|r| r.scallop.as_ref()).map_or(0.0, |scallop| scallop.distance),
            residual_area_mm2: remains.map_or(0.0, |r| r.residual_area),
            gouge_area_mm2: remains.map_or(0.0, |r| r.gouge_area),
            max_gouge_mm: remains.map_or(0.0, |r| r.deepest_gouge),
            stuck_chips: remains.map_or(0, |r| r.stuck.len()),
            chips: replay.swept.chips,
            cut_deviation_mm: replay.cut_deviation_mm,
            correlation: likeness.and_then(|l| l.correlation),
            correlation_mean_removed: likeness.and_then(|l| l.correlation_mean_removed),
            max_deviation_mm: likeness.map(|l| l.max_deviation_mm),
            bound_tips,
            usable: attempt.is_sound(),
        }
    }
}

impl ConversionFigures {
    /// Of swing (rad) and extension (mm), the number of milling cuts, and the replay. Without a likeness nobody has said
    /// what the part is.
    #[must_use]
    pub fn new(
        (swing, extension_mm): (f64, f64),
        milling_cuts: usize,
        replay: &Replay,
        likeness: Option<&Likeness>,
    ) -> Self {
        let (times, remains) = (replay.times, replay.swept.remains.as_ref());
        let scallop = remains.and_then(|remains| remains.scallop.as_ref()).map(|scallop| scallop.distance);
        Self {
            parameters: ConvertedParameters { swing_angle_deg: swing.to_degrees(), extension_mm },
            exact: ConvertedFigures {
                milling_cuts,
                tips: replay.tips(),
                time_s: times.total_s(),
                split: Split::of_replay(&times),
                max_scallop_mm: scallop.filter(|_| likeness.is_some()),
                residual_area_mm2: remains.map_or(0.0, |r| r.residual_area),
                gouge_area_mm2: remains.map_or(0.0, |r| r.gouge_area),
                stuck_chips: remains.map_or(0, |r| r.stuck.len()),
                chips: replay.swept.chips,
                cut_deviation_mm: replay.cut_deviation_mm,
                correlation: likeness.and_then(|l| l.correlation),
                correlation_mean_removed: likeness.and_then(|l| l.correlation_mean_removed),
                max_deviation_mm: likeness.map(|l| l.max_deviation_mm),
            },
        }
    }
}

impl RobotFigures {
    /// Of a check along a program with files of these names.
    #[must_use]
    pub fn new(check: &RobotCheck, names: &[String]) -> Self {
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        Self {
            checked: true,
            reachable: Some(check.reachable),
            min_joint_margin_deg: check.min_joint_margin_deg,
            min_singularity_margin: check.min_singularity_margin,
            max_joint_speed_ratio: Some(check.max_joint_speed_ratio),
            first_fault: check
                .first_fault
                .as_ref()
                .map(|first| FaultFigures { at: first.at(&names), message: first.fault.to_string() }),
            time_s: None,
        }
    }

    /// With the time that its program takes.
    #[must_use]
    pub fn with_time(self, time_s: f64) -> Self {
        Self { time_s: Some(time_s), ..self }
    }
}

impl From<&Likeness> for LikenessFigures {
    fn from(likeness: &Likeness) -> Self {
        Self {
            correlation: likeness.correlation,
            correlation_mean_removed: likeness.correlation_mean_removed,
            max_deviation_mm: likeness.max_deviation_mm,
            max_deviation_x_mm: likeness.max_deviation_x_mm,
        }
    }
}
