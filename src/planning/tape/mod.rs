//! Two-cutter cutting of prepreg tape (domain: two-step automated tape laying).
//!
//! In the order in which a job passes through: `wire` (as it stands in JSON) -> `file` (what stands in files) ->
//! `input`, `outline` and `machine` (checked) -> `develop` -> `piece` -> `chain` -> `assign` (the knives of a piece by
//! itself) -> `roll` (`block` and `front`: what matters there of a piece; `place`: where it goes; `pace`: which knives are
//! quickest) -> `stroke` -> `timeline`. `plan` puts the geometric steps together, `report` writes the figures.

pub mod assign;
pub mod block;
pub mod chain;
pub mod curve;
pub mod develop;
pub mod file;
pub mod front;
pub mod input;
pub mod machine;
pub mod outline;
pub mod pace;
pub mod piece;
pub mod place;
pub mod plan;
pub mod report;
pub mod roll;
pub mod stroke;
pub mod timeline;
pub mod wire;

use self::input::TapeInput;
use self::plan::TapePlan;
use self::report::TapeReport;
use super::budget::Budget;
use super::document::files::Files;
use super::drawing::drawings;
use super::finding::{Code, Finding};
use super::outcome::{Outcome, ProgramFile};
use super::program::nc;
use super::program::replay::{ReplayFigures, ReplaySetup, replay};

/// Name of the one program of a tape-cut job.
pub const PROGRAM_NAME: &str = "roll.ngc";

/// Plans a tape-cut job: a program stands in the outcome only if it was read back from its own text and its
/// replay has passed.
///
/// # Errors
/// Every fault of the input and of the files that it names.
pub fn plan(
    input: &wire::TapeCut,
    files: &Files,
    catalogue: &machine::Catalogue,
    input_sha256: &str,
    budget: &Budget<'_>,
) -> Result<Outcome, Vec<Finding>> {
    budget.stage("check");
    let input = take_over(input, files, catalogue)?;
    let mut findings = input.findings.clone();
    let planned = plan::plan(&input, budget, &mut findings).and_then(|plan| {
        let program = write(&plan, &input, input_sha256, budget)?;
        Ok((plan, program))
    });
    Ok(match planned {
        Ok((plan, program)) => finish(&plan, program, &input, findings, input_sha256, budget),
        Err(faults) => {
            findings.extend(faults);
            Outcome::new("tape-cut", input_sha256, findings, vec![], vec![], None::<TapeReport>)
        }
    })
}

/// Reads what is in files and checks all of it; a file that cannot be read hides no other fault.
fn take_over(
    input: &wire::TapeCut,
    files: &Files,
    catalogue: &machine::Catalogue,
) -> Result<TapeInput, Vec<Finding>> {
    let listed = file::listed(input, files).map_err(|mut faults| {
        faults.extend(input::check(input, catalogue).err().unwrap_or_default());
        faults
    })?;
    input::check(listed, catalogue)
}

/// A program as it was written, not yet replayed.
struct Written {
    text: String,
    time_s: f64,
    bound_time_s: f64,
}

fn write(
    plan: &TapePlan,
    input: &TapeInput,
    input_sha256: &str,
    budget: &Budget<'_>,
) -> Result<Written, Vec<Finding>> {
    budget.stage("timeline");
    let lacking = plan.lacking_tape(input);
    if !lacking.is_empty() {
        return Err(lacking);
    }
    let strokes = plan.strokes(input);
    let bound_time_s = timeline::bound_s(&strokes, &input.machine);
    let program = timeline::merge(strokes, &input.machine)?;
    budget.stage("write");
    let text = nc::emit::emit(&program, &input.machine, input_sha256);
    Ok(Written { text, time_s: program.time_s, bound_time_s })
}

fn finish(
    plan: &TapePlan,
    program: Written,
    input: &TapeInput,
    mut findings: Vec<Finding>,
    input_sha256: &str,
    budget: &Budget<'_>,
) -> Outcome {
    budget.stage("replay");
    let (figures, faults) = replay_text(PROGRAM_NAME, &program.text, plan, input);
    findings.extend(faults);
    budget.stage("draw");
    // A plan whose program failed its replay is drawn too: a person then looks for the reason.
    let drawings = drawings(plan, input);
    budget.stage("report");
    let report = TapeReport::new(plan, &input.machine, program.time_s, program.bound_time_s, figures);
    let file = ProgramFile { name: PROGRAM_NAME.to_owned(), dialect: "linuxcnc", text: program.text };
    Outcome::new("tape-cut", input_sha256, findings, vec![file], drawings, Some(report))
}

/// Reads a program back from its text and replays it against a plan. The findings are errors where the program
/// must not run.
#[must_use]
pub fn replay_text(
    name: &str,
    text: &str,
    plan: &TapePlan,
    input: &TapeInput,
) -> (ReplayFigures, Vec<Finding>) {
    let wanted = plan.wanted();
    let setup = ReplaySetup {
        program: name,
        machine: &input.machine,
        lead_mm: plan.figures.lead_mm,
        tolerance_mm: input.tolerance.mm(),
        tape_width_mm: input.width.mm(),
        wanted: &wanted,
    };
    let (figures, mut findings) = match nc::read::read(name, text) {
        Ok(events) => replay(&setup, &events),
        Err(faults) => (ReplayFigures::nothing_made(&wanted), faults),
    };
    findings.extend(too_long(name, text, input.machine.max_line_characters));
    (figures, findings)
}

/// The first line that is longer than the machine's control takes.
fn too_long(name: &str, text: &str, most: usize) -> Option<Finding> {
    let lengths = text.lines().map(|line| line.chars().count());
    let (index, length) = lengths.enumerate().find(|(_, length)| *length > most)?;
    let message = format!("the line has {length} characters, the machine's control takes {most}");
    Some(Finding::error(Code::UnreadableProgram, format!("{name}:{}", index + 1), message))
}

/// Replays a program against a job: the figures in words, and every finding. A text that differs from the one
/// that this job gives is said to, even if its cuts are right.
///
/// # Errors
/// Every fault of the input and of the files that it names.
pub fn check(
    input: &wire::TapeCut,
    files: &Files,
    catalogue: &machine::Catalogue,
    input_sha256: &str,
    name: &str,
    text: &str,
    budget: &Budget<'_>,
) -> Result<(String, Vec<Finding>), Vec<Finding>> {
    let input = take_over(input, files, catalogue)?;
    let mut findings = Vec::new();
    let plan = match plan::plan(&input, budget, &mut findings) {
        Ok(plan) => plan,
        Err(faults) => return Ok(("the job has no plan".to_owned(), faults)),
    };
    let (figures, mut findings) = replay_text(name, text, &plan, &input);
    match write(&plan, &input, input_sha256, budget) {
        Ok(written) => findings.extend(difference(name, text, &written.text)),
        Err(faults) => findings.extend(faults),
    }
    Ok((figures.to_string(), findings))
}

fn difference(name: &str, text: &str, planned: &str) -> Option<Finding> {
    if text == planned {
        return None;
    }
    let same = text.split('\n').zip(planned.split('\n')).take_while(|(one, other)| one == other).count();
    let message =
        "here the text begins to differ from the program that this job gives; only that one may be approved";
    Some(Finding::warning(Code::DiffersFromPlan, format!("{name}:{}", same + 1), message))
}
