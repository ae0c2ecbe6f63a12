//! V-shaped cutting of honeycomb with a straight ultrasonic blade on a robot (domain.md Part B).
//!
//! In the order in which a job passes through: `wire` (as it stands in JSON) -> `input`, `cell` and `blade`
//! (checked) -> `model` and `optimum` (the published equations) -> `lattice` (tips on the `section`) -> `path` ->
//! the program's text -> `replay` of what was read back -> `follow` (the robot). `attempt` carries one lattice
//! through, `plan` takes the best, `report`, `table` and `pictures` say what came of it. `convert` and `milling`
//! are the paper's own way by a milling program.

pub mod attempt;
pub mod blade;
pub mod bound;
pub mod cell;
pub mod contour;
pub mod contour_text;
pub mod conversion;
pub mod convert;
pub mod follow;
pub mod input;
pub mod lattice;
pub mod lattice_kind;
pub mod milling;
pub mod model;
pub mod optimum;
pub mod path;
pub mod pictures;
pub mod plan;
pub mod replay;
pub mod report;
pub mod section;
pub mod table;
pub mod wire;

use self::attempt::{read_and_replay, wanted};
use self::cell::Cell;
use self::contour::compare;
use self::input::{CutInput, LatticeChoice, OptimumInput, Setting};
use self::lattice_kind::Lattice;
use self::model::Model;
use self::optimum::Optimum;
use self::report::{
    EstimateFigures, ExactFigures, HoneycombReport, LikenessFigures, MachineFigures, ParameterFigures,
    RobotFigures,
};
use super::budget::Budget;
use super::catalogue::Catalogue;
use super::document::files::Files;
use super::finding::{Code, Finding};
use super::outcome::{Attachment, Outcome, ProgramFile};

/// Plans a honeycomb-cut job: a program stands in the outcome only if it was read back from its own text, its replay
/// has passed, and the robot can follow.
///
/// # Errors
/// Every fault of the input.
pub fn plan_cut(
    input: &wire::HoneycombCut,
    files: &Files,
    catalogue: &Catalogue,
    input_sha256: &str,
    budget: &Budget<'_>,
) -> Result<Outcome, Vec<Finding>> {
    const KIND: &str = "honeycomb-cut";
    budget.stage("check");
    let (input, cell) = taken_over(input, Some(files), catalogue)?;
    let mut findings = Vec::new();
    let plan = match plan::plan(&input, &cell, input_sha256, budget, &mut findings) {
        Ok(plan) => plan,
        Err(faults) => {
            findings.extend(faults);
            return Ok(Outcome::new(KIND, input_sha256, findings, vec![], vec![], None::<HoneycombReport>));
        }
    };
    budget.stage("draw");
    let drawings = pictures::of_plan(&plan, &input, &cell);
    budget.stage("report");
    let report = cut_report(&plan, &input, &cell);
    let summary = table::lines(&plan);
    let attachments = attachments(&plan, &input, &cell, input_sha256);
    let files = plan.final_attempt().files.clone();
    let outcome = Outcome::new(KIND, input_sha256, findings, files, drawings, Some(report));
    Ok(outcome.with_attachments(attachments).with_summary(summary))
}

/// The plain milling path of the tips, for those who simulate in a CAM system first, and the joints over time.
fn attachments(plan: &plan::Plan, input: &CutInput, cell: &Cell, input_sha256: &str) -> Vec<Attachment> {
    let Setting { blank, process, .. } = &input.setting;
    let setup = cell.setup(process, input.setting.speeds(), None);
    let (tips, safety_mm) = (&plan.best.attempt.tips, process.safety_distance_mm);
    let milling = milling::milling_program(
        tips,
        blank,
        safety_mm,
        &setup,
        &attempt::milling_stem(input_sha256),
        input_sha256,
    );
    // A path that cannot be written is only missing; the program itself has been judged already.
    let milling = milling.ok().map(|file| Attachment { name: file.name, text: file.text });
    let curves = plan.robot.as_ref().map(|check| Attachment {
        name: "joints.csv".to_owned(),
        text: super::robot::curve::csv(&check.curve),
    });
    milling.into_iter().chain(curves).collect()
}

fn taken_over(
    input: &wire::HoneycombCut,
    files: Option<&Files>,
    catalogue: &Catalogue,
) -> Result<(CutInput, Cell), Vec<Finding>> {
    let mut faults = Vec::new();
    let cell = cell::check(input.cell.as_ref(), catalogue, files, &mut faults);
    let input = input::check_cut(input, files).map_err(|found| faults.extend(found));
    match input {
        Ok(input) if faults.is_empty() => Ok((input, cell)),
        _ => Err(faults),
    }
}

/// Checks what can be checked of a honeycomb-cut input without planning. What stands in files is not looked at.
///
/// # Errors
/// Every fault with its JSON pointer.
pub fn validate_cut(input: &wire::HoneycombCut, catalogue: &Catalogue) -> Result<(), Vec<Finding>> {
    taken_over(input, None, catalogue).map(|_| ())
}

fn cut_report(plan: &plan::Plan, input: &CutInput, cell: &Cell) -> HoneycombReport {
    let best = &plan.best;
    let figures = |way: &plan::Way| ExactFigures::new(&way.attempt, way.likeness.as_ref(), plan.bound_tips);
    let names: Vec<String> = plan.final_attempt().files.iter().map(|file| file.name.clone()).collect();
    let measured = input.measured.as_ref();
    HoneycombReport {
        machine: cell.identity.as_ref().map(MachineFigures::from),
        lattice: Some(best.attempt.lattice.as_str()),
        sequence: Some("paired"),
        parameters: Some(ParameterFigures::new(
            &best.estimate,
            input.setting.blade.extension_mm(best.attempt.spacing.swing),
        )),
        estimate: Some(EstimateFigures::new(
            &best.estimate,
            best.optimum.as_ref(),
            plan.initial.as_ref().map(|initial| &initial.estimate),
        )),
        exact: Some(figures(best)),
        published: Some(figures(plan.published.as_ref().unwrap_or(best))),
        initial: plan.initial.as_ref().map(figures),
        cone_tool: Some(milling::ConeTool::of(&input.setting.blade, best.attempt.spacing.swing).into()),
        conversion: None,
        robot: Some(plan.robot.as_ref().map_or_else(RobotFigures::default, |check| {
            RobotFigures::new(check, &names).with_time(plan.final_attempt().replay.times.total_s())
        })),
        measured: measured
            .and_then(|measured| compare(&input.profile, std::slice::from_ref(measured)))
            .as_ref()
            .map(LikenessFigures::from),
    }
}

/// Reads a program back and replays it against its job: the figures in words, and every finding.
///
/// # Errors
/// Every fault of the input.
pub fn check_cut(
    input: &wire::HoneycombCut,
    files: &Files,
    catalogue: &Catalogue,
    input_sha256: &str,
    program: &[ProgramFile],
    budget: &Budget<'_>,
) -> Result<(String, Vec<Finding>), Vec<Finding>> {
    let (input, cell) = taken_over(input, Some(files), catalogue)?;
    let mut findings = Vec::new();
    let plan = match plan::plan(&input, &cell, input_sha256, budget, &mut findings) {
        Ok(plan) => plan,
        Err(faults) => return Ok(("the job has no plan".to_owned(), faults)),
    };
    let best = plan.final_attempt();
    let cuts = wanted(&best.tips, best.spacing.swing);
    let (replayed, mut findings) =
        read_and_replay(program, &input.setting, Some(&input.profile), &cuts, &cell);
    if let (Some(robot), false) = (&cell.robot, super::finding::any_error(&findings)) {
        let names: Vec<String> = program.iter().map(|file| file.name.clone()).collect();
        let way = follow::path(&replayed.happenings, &cell);
        let found = follow::follow(robot, &way, budget)
            .and_then(|check| follow::findings(&check, robot, &way, &names, budget))
            .map_err(|finding| vec![finding])?;
        findings.extend(found);
    }
    findings.extend(differences(program, &best.files));
    Ok((replayed.words(), findings))
}

fn differences(found: &[ProgramFile], planned: &[ProgramFile]) -> Vec<Finding> {
    let message = "the text differs from the program that this job gives; only that one may be approved";
    let differs = |file: &&ProgramFile| {
        planned
            .iter()
            .find(|planned| planned.name == file.name)
            .is_none_or(|planned| planned.text != file.text)
    };
    let changed =
        found.iter().filter(differs).map(|file| Finding::warning(Code::DiffersFromPlan, &file.name, message));
    let missing =
        planned.iter().filter(|planned| found.iter().all(|file| file.name != planned.name)).map(|planned| {
            Finding::warning(
                Code::DiffersFromPlan,
                &planned.name,
                "this file of the planned program is not there",
            )
        });
    changed.chain(missing).collect()
}

/// Answers a honeycomb-optimum job.
///
/// # Errors
/// Every fault of the input.
pub fn plan_optimum(
    input: &wire::HoneycombOptimum,
    input_sha256: &str,
    budget: &Budget<'_>,
) -> Result<Outcome, Vec<Finding>> {
    const KIND: &str = "honeycomb-optimum";
    budget.stage("check");
    let input = input::check_optimum(input)?;
    budget.stage("optimum");
    let (model, optimum) = match best_optimum(&input) {
        Ok(found) => found,
        Err(faults) => {
            return Ok(Outcome::new(KIND, input_sha256, faults, vec![], vec![], None::<HoneycombReport>));
        }
    };
    let initial = match input.initial.map(|chosen| plan::parameters(&model, Some(chosen))) {
        None => None,
        Some(Ok((parameters, _))) => model.estimate(&parameters).ok(),
        Some(Err(fault)) => {
            return Ok(Outcome::new(
                KIND,
                input_sha256,
                vec![fault],
                vec![],
                vec![],
                None::<HoneycombReport>,
            ));
        }
    };
    budget.stage("draw");
    let drawings = pictures::of_optimum(&model, &optimum, initial.as_ref());
    let report = HoneycombReport {
        lattice: Some(model.given().lattice.as_str()),
        parameters: Some(ParameterFigures::new(&optimum.estimate, optimum.estimate.extension_mm)),
        estimate: Some(EstimateFigures::new(&optimum.estimate, Some(&optimum), initial.as_ref())),
        ..HoneycombReport::default()
    };
    let summary = table::optimum_lines(&optimum, initial.as_ref());
    Ok(Outcome::of_figures(KIND, input_sha256, vec![], drawings, report).with_summary(summary))
}

/// The optimum of the lattice that was asked for, or of the one with the shortest.
fn best_optimum(input: &OptimumInput) -> Result<(Model, Optimum), Vec<Finding>> {
    let kinds: &[Lattice] = match input.lattice {
        LatticeChoice::Orthogonal => &[Lattice::Orthogonal],
        LatticeChoice::Interlaced => &[Lattice::Interlaced],
        LatticeChoice::Free => &[Lattice::Free],
        LatticeChoice::Best | LatticeChoice::Hybrid => {
            &[Lattice::Orthogonal, Lattice::Interlaced, Lattice::Free]
        }
    };
    let (mut best, mut faults) = (None::<(Model, Optimum)>, Vec::new());
    for &kind in kinds {
        match plan::model(&input.setting, input.machined_area_mm2, kind) {
            Ok(model) => {
                let found = optimum::optimum(&model);
                if best.as_ref().is_none_or(|(_, best)| found.estimate.time_s < best.estimate.time_s) {
                    best = Some((model, found));
                }
            }
            Err(fault) => faults.push(fault),
        }
    }
    best.ok_or(faults)
}
