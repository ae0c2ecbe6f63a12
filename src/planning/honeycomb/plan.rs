//! The plan of a part: the published lattices carried through, the best of them, and the paper's own way beside it.

use super::attempt::{Attempt, carry_through};
use super::bound::fewest_tips;
use super::cell::Cell;
use super::contour::{Likeness, compare};
use super::follow;
use super::input::{Chosen, CutInput, LatticeChoice, Setting};
use super::lattice::Spacing;
use super::lattice_kind::Lattice;
use super::model::estimate::Estimate;
use super::model::given::Given;
use super::model::{Model, Parameters};
use super::optimum::{Optimum, optimum};
use crate::planning::budget::Budget;
use crate::planning::finding::{Code, Finding};
use crate::planning::geometry::Point2;
use crate::planning::program::number::rounded;
use crate::planning::program::robot_moves::Speeds;
use crate::planning::robot::check::RobotCheck;

/// The plan of a part.
#[derive(Debug)]
pub struct Plan {
    /// The way that was taken.
    pub best: Way,
    /// The paper's way: the orthogonal lattice at the published model's optimum; none where that is `best` itself, or
    /// where the model has none.
    pub published: Option<Way>,
    /// The set to compare with, carried through; none if none was given.
    pub initial: Option<Way>,
    /// The program of `best` with lower speeds, where the robot cannot follow at those of the process.
    pub slowed: Option<Slowed>,
    /// How the robot follows the program that is given out; none without a robot, or where the program fails already.
    pub robot: Option<RobotCheck>,
    /// The fewest tips that any plan needs.
    pub bound_tips: u32,
}

/// A program that runs slower than the process asks for, so that the robot can follow.
#[derive(Debug)]
pub struct Slowed {
    /// Tips, program and replay.
    pub attempt: Attempt,
    /// Its speeds.
    pub speeds: Speeds,
}

impl Plan {
    /// What is given out: the program and what its replay says.
    #[must_use]
    pub fn final_attempt(&self) -> &Attempt {
        self.slowed.as_ref().map_or(&self.best.attempt, |slowed| &slowed.attempt)
    }
}

/// A way to cut a part, with what the published model says of it.
#[derive(Debug)]
pub struct Way {
    /// Tips, program and replay.
    pub attempt: Attempt,
    /// What the published model says.
    pub estimate: Estimate,
    /// The optimum that it is; none where the parameters were chosen.
    pub optimum: Option<Optimum>,
    /// How like the cut contour is to the wanted one.
    pub likeness: Option<Likeness>,
}

/// Decimals of h, s (mm) and alpha (degrees) that a plan is made with: what a person can read and repeat.
const PARAMETER_DECIMALS: usize = 4;

/// The paper's lattices.
const PUBLISHED: [Lattice; 3] = [Lattice::Orthogonal, Lattice::Interlaced, Lattice::Free];

/// Plans a part.
///
/// # Errors
/// Every finding that leaves the part without a plan.
pub fn plan(
    input: &CutInput,
    cell: &Cell,
    input_sha256: &str,
    budget: &Budget<'_>,
    findings: &mut Vec<Finding>,
) -> Result<Plan, Vec<Finding>> {
    let planner = Planner { input, cell, input_sha256, budget };
    let mut ways = planner.ways()?;
    let best = take_best(&mut ways);
    findings.extend(ways.iter().map(|way| passed_over(way, &best)));
    let published = planner.published(&mut ways, &best).map_err(|finding| vec![finding])?;
    let initial = planner.initial().map_err(|finding| vec![finding])?;
    let out_of_reach = cell.robot.is_some() && best.attempt.approach.is_none();
    if !out_of_reach {
        // Otherwise the program begins where no robot can, and what is said of that would hide the reason.
        findings.extend(best.attempt.findings.iter().cloned());
    }
    let (robot, slowed) = planner.follow(&best, findings).map_err(|finding| vec![finding])?;
    let bound_tips = fewest_tips(&input.profile, &input.setting);
    Ok(Plan { best, published, initial, slowed, robot, bound_tips })
}

struct Planner<'a> {
    input: &'a CutInput,
    cell: &'a Cell,
    input_sha256: &'a str,
    budget: &'a Budget<'a>,
}

impl Planner<'_> {
    /// Every lattice that comes into question, carried through.
    fn ways(&self) -> Result<Vec<Way>, Vec<Finding>> {
        let kinds = match self.input.lattice {
            LatticeChoice::Orthogonal => vec![Lattice::Orthogonal],
            LatticeChoice::Interlaced => vec![Lattice::Interlaced],
            LatticeChoice::Free => vec![Lattice::Free],
            LatticeChoice::Best | LatticeChoice::Hybrid => PUBLISHED.to_vec(),
        };
        let (mut ways, mut faults) = (Vec::new(), Vec::new());
        for kind in kinds {
            match self.way(kind, self.input.chosen) {
                Ok(way) => ways.push(way),
                Err(finding) if finding.code == Code::NoParameters => faults.push(finding),
                Err(finding) => return Err(vec![finding]),
            }
        }
        if ways.is_empty() { Err(faults) } else { Ok(ways) }
    }

    /// A lattice at its optimum, or with parameters that were chosen.
    fn way(&self, kind: Lattice, chosen: Option<Chosen>) -> Result<Way, Finding> {
        self.budget.stage("optimum");
        let (parameters, optimum) = parameters(&self.model(kind)?, chosen)?;
        self.carried(kind, &parameters, optimum)
    }

    fn carried(
        &self,
        kind: Lattice,
        parameters: &Parameters,
        optimum: Option<Optimum>,
    ) -> Result<Way, Finding> {
        let spacing = printed(parameters);
        let estimate = self.model(kind)?.estimate(parameters).map_err(|faults| no_parameters(&faults))?;
        self.budget.stage("plan and replay");
        let attempt = self.carry(kind, spacing, self.input.setting.speeds())?;
        let remains = attempt.replay.swept.remains.as_ref();
        let likeness = remains.and_then(|remains| compare(&self.input.profile, &remains.surface));
        Ok(Way { attempt, estimate, optimum, likeness })
    }

    fn carry(&self, kind: Lattice, spacing: Spacing, speeds: Speeds) -> Result<Attempt, Finding> {
        carry_through((kind, spacing), speeds, self.input, self.cell, self.input_sha256, self.budget)
    }

    fn model(&self, kind: Lattice) -> Result<Model, Finding> {
        let area = machined_area(&self.input.profile, &self.input.setting);
        model(&self.input.setting, area, kind)
    }

    /// The paper's own way, if it is not the best one.
    fn published(&self, ways: &mut Vec<Way>, best: &Way) -> Result<Option<Way>, Finding> {
        let papers = |way: &Way| way.attempt.lattice == Lattice::Orthogonal && way.optimum.is_some();
        if papers(best) {
            return Ok(None);
        }
        if let Some(index) = ways.iter().position(papers) {
            return Ok(Some(ways.swap_remove(index)));
        }
        optional(self.way(Lattice::Orthogonal, None))
    }

    fn initial(&self) -> Result<Option<Way>, Finding> {
        match self.input.initial {
            Some(initial) => optional(self.way(Lattice::Orthogonal, Some(initial))),
            None => Ok(None),
        }
    }

    /// Runs the robot along the best way; where it is only too slow for it, along the same way with lower speeds.
    fn follow(
        &self,
        best: &Way,
        findings: &mut Vec<Finding>,
    ) -> Result<(Option<RobotCheck>, Option<Slowed>), Finding> {
        let Some(robot) = &self.cell.robot else {
            findings.push(follow::not_checked());
            return Ok((None, None));
        };
        if best.attempt.approach.is_some() && !best.attempt.is_sound() {
            return Ok((None, None));
        }
        self.budget.stage("robot");
        let wanted = self.input.setting.speeds();
        let mut attempt = &best.attempt;
        let mut way = follow::path(&attempt.replay.happenings, self.cell);
        let mut check = follow::follow(robot, &way, self.budget)?;
        let mut slowed = None;
        if let Some(speeds) = follow::slowed(&check, &wanted) {
            let slower = self.carry(attempt.lattice, attempt.spacing, speeds)?;
            let times = [attempt, &slower].map(|attempt| attempt.replay.times.total_s());
            let reason = (check.fastest_joint, check.max_joint_speed_ratio);
            findings.push(follow::said_slower(reason, &wanted, &speeds, times));
            findings.extend(slower.findings.iter().cloned());
            attempt = &slowed.insert(Slowed { attempt: slower, speeds }).attempt;
            way = follow::path(&attempt.replay.happenings, self.cell);
            check = follow::follow(robot, &way, self.budget)?;
        }
        let names: Vec<String> = attempt.files.iter().map(|file| file.name.clone()).collect();
        findings.extend(follow::findings(&check, robot, &way, &names, self.budget)?);
        Ok((Some(check), slowed))
    }
}

/// A way that is only there to compare with may be missing.
fn optional(way: Result<Way, Finding>) -> Result<Option<Way>, Finding> {
    match way {
        Ok(way) => Ok(Some(way)),
        Err(finding) if finding.code == Code::NoParameters => Ok(None),
        Err(finding) => Err(finding),
    }
}

/// The model of a part: what is given, and how much of the section goes.
///
/// # Errors
/// `NoParameters`: which limit excludes what.
pub fn model(setting: &Setting, machined_area_mm2: f64, lattice: Lattice) -> Result<Model, Finding> {
    let Setting { blank, blade, process } = setting;
    let given = Given {
        blank_width_mm: blank.width_mm,
        blank_length_mm: blank.length_mm,
        machined_area_mm2,
        safety_distance_mm: process.safety_distance_mm,
        rake_rad: blade.rake.radians(),
        half_apex_rad: blade.half_apex.radians(),
        cutting_speed_mm_s: process.cutting_speed_mm_s,
        travel_speed_mm_s: process.travel_speed_mm_s,
        angular_speed_rad_s: process.angular_speed_deg_s.to_radians(),
        max_scallop_mm: process.max_scallop_mm,
        max_cutting_length_mm: blade.max_cutting_length.mm(),
        max_swing_rad: blade.max_swing.radians(),
        lattice,
    };
    Model::new(given).map_err(|refusal| {
        let message =
            format!("the {} lattice has no layer spacing, step and swing angle: {refusal}", lattice.as_str());
        Finding::error(Code::NoParameters, "/input", message)
    })
}

/// The chosen parameters, or the optimum.
///
/// # Errors
/// `NoParameters`.
pub fn parameters(model: &Model, chosen: Option<Chosen>) -> Result<(Parameters, Option<Optimum>), Finding> {
    match chosen {
        Some(Chosen::All { layer_spacing_mm, step_mm, swing }) => {
            Ok((Parameters { layer_spacing_mm, step_mm, swing_rad: swing }, None))
        }
        Some(Chosen::BySwing { swing, overlap_ratio }) => {
            let found =
                model.parameters_by_overlap(swing, overlap_ratio).map_err(|faults| no_parameters(&faults))?;
            Ok((found, None))
        }
        None => {
            let found = optimum(model);
            Ok((found.estimate.parameters, Some(found)))
        }
    }
}

fn no_parameters(faults: &[super::model::given::OutOfRange]) -> Finding {
    let words: Vec<String> = faults.iter().map(ToString::to_string).collect();
    Finding::error(Code::NoParameters, "/input/plan/parameters", words.join("; "))
}

/// Parameters as they are planned with: few digits, h and s rounded down so that no limit is passed.
fn printed(parameters: &Parameters) -> Spacing {
    let down = |value: f64| {
        let scale = 10_f64.powi(PARAMETER_DECIMALS as i32);
        // What is on a digit already stays there.
        let near = rounded(value, PARAMETER_DECIMALS);
        if near <= value { near } else { rounded((value * scale).floor() / scale, PARAMETER_DECIMALS) }
    };
    Spacing {
        layer: down(parameters.layer_spacing_mm),
        step: down(parameters.step_mm),
        swing: rounded(parameters.swing_rad.to_degrees(), PARAMETER_DECIMALS).to_radians(),
    }
}

/// A_C: how much of the blank's section lies above the contour, in mm^2.
#[must_use]
pub fn machined_area(profile: &[Point2], setting: &Setting) -> f64 {
    let below: f64 = profile.windows(2).map(|p| 0.5 * (p[0].y + p[1].y) * (p[1].x - p[0].x)).sum();
    setting.blank.width_mm * setting.blank.height_mm - below
}

/// Takes the shortest of the sound ways; where none is sound, the one with the fewest faults.
fn take_best(ways: &mut Vec<Way>) -> Way {
    let rank = |way: &Way| {
        let faults = way.attempt.findings.iter().filter(|finding| finding.is_error()).count();
        (faults, way.attempt.replay.times.total_s())
    };
    let mut best = 0;
    for index in 1..ways.len() {
        let (one, other) = (rank(&ways[index]), rank(&ways[best]));
        if one.0.cmp(&other.0).then(one.1.total_cmp(&other.1)).is_lt() {
            best = index;
        }
    }
    ways.swap_remove(best)
}

/// Says why a published lattice was not taken.
fn passed_over(way: &Way, best: &Way) -> Finding {
    let name = way.attempt.lattice.as_str();
    let message = match way.attempt.findings.iter().find(|finding| finding.is_error()) {
        Some(fault) => format!("the {name} lattice is not valid on this part: {}", fault.message),
        None => format!(
            "the {name} lattice takes {:.1} s; the {} one takes {:.1} s",
            way.attempt.replay.times.total_s(),
            best.attempt.lattice.as_str(),
            best.attempt.replay.times.total_s()
        ),
    };
    Finding::info(Code::LatticePassedOver, "/input/plan/lattice", message)
}
