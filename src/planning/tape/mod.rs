//! Two-cutter cutting of prepreg tape (domain: two-step automated tape laying).
//!
//! In the order in which a job passes through: `wire` (as it stands in JSON) -> `file` (what stands in files) ->
//! `input`, `outline` and `machine` (checked), `courses` (generated) -> `develop` -> `piece` -> `chain` -> `roll` (with
//! `front`) -> `assign` -> `stroke` -> `timeline`. `plan` puts the geometric steps together, `report` writes the figures.

pub mod assign;
pub mod chain;
pub mod courses;
pub mod curve;
pub mod develop;
pub mod excess;
pub mod file;
pub mod front;
pub mod input;
pub mod machine;
pub mod outline;
pub mod piece;
pub mod plan;
pub mod report;
pub mod roll;
pub mod setup;
pub mod spool;
pub mod stroke;
pub mod timeline;
pub mod tips;
pub mod trace;
pub mod wire;
pub mod words;

use self::input::TapeInput;
use self::plan::TapePlan;
use self::report::TapeReport;
use self::trace::PlantedTrace;
use super::budget::Budget;
use super::document::files::Files;
use super::drawing::drawings;
use super::drawing::timeline::timeline as timeline_drawing;
use super::finding::{Code, Finding, any_error};
use super::outcome::{Outcome, ProgramFile};
use super::program::moves::TapeProgram;
use super::program::nc;
use super::program::nc::dialect::language;
use super::program::replay::{ReplayFigures, ReplaySetup, replay};

/// Name of the one program of a tape-cut job, with the ending of its dialect.
#[must_use]
pub fn program_name(machine: &machine::Machine) -> String {
    format!("roll.{}", language(machine.dialect).ending)
}

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
            input.origins.relocate(&mut findings);
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
    let mut listed = file::listed(input, files);
    let checked = input::check(&listed.input, catalogue);
    let mut findings = std::mem::take(&mut listed.findings);
    let mut input = match checked {
        Ok(input) => input,
        Err(mut faults) => {
            listed.origins.relocate(&mut faults);
            findings.extend(faults);
            findings.retain(Finding::is_error);
            return Err(findings);
        }
    };
    if any_error(&findings) {
        findings.retain(Finding::is_error);
        return Err(findings);
    }
    input.origins = listed.origins.with(&input.origins);
    input.origins.relocate(&mut input.findings);
    findings.append(&mut input.findings);
    input.findings = findings;
    Ok(input)
}

/// A program as it was written, not yet replayed.
struct Written {
    text: String,
    program: TapeProgram,
    bound_time_s: f64,
    trace: PlantedTrace,
}

fn write(
    plan: &TapePlan,
    input: &TapeInput,
    input_sha256: &str,
    budget: &Budget<'_>,
) -> Result<Written, Vec<Finding>> {
    budget.stage("timeline");
    let strokes = plan.strokes(input);
    let trace = trace::planted(plan, &strokes, input);
    let bound_time_s = timeline::bound_s(&strokes, &input.machine);
    let program = timeline::merge(strokes, &input.machine, input.tolerance.mm())?;
    budget.stage("write");
    let text = nc::emit::emit(&program, &input.machine, input_sha256);
    Ok(Written { text, program, bound_time_s, trace })
}

fn finish(
    plan: &TapePlan,
    written: Written,
    input: &TapeInput,
    mut findings: Vec<Finding>,
    input_sha256: &str,
    budget: &Budget<'_>,
) -> Outcome {
    budget.stage("replay");
    let name = program_name(&input.machine);
    let (figures, faults) = replay_text(&name, &written.text, plan, input);
    findings.extend(faults);
    input.origins.relocate(&mut findings);
    budget.stage("draw");
    // A plan whose program failed its replay is drawn too: a person then looks for the reason.
    let mut drawings = drawings(plan, input);
    drawings.push(timeline_drawing(&written.program, &input.machine));
    budget.stage("report");
    let Written { text, program, bound_time_s, trace } = written;
    let report = TapeReport::new(plan, &input.machine, program.time_s, bound_time_s, figures);
    let file = ProgramFile { name, dialect: language(input.machine.dialect).name, text };
    let sheet = (!any_error(&findings)).then(|| setup::sheet(plan, &program, &file, input, input_sha256));
    let attachments = trace.attachments().into_iter().chain(sheet).collect();
    Outcome::new("tape-cut", input_sha256, findings, vec![file], drawings, Some(report))
        .with_attachments(attachments)
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
    let (figures, mut findings) = match nc::read_back(name, text, &input.machine) {
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
        Err(mut faults) => {
            input.origins.relocate(&mut faults);
            return Ok(("the job has no plan".to_owned(), faults));
        }
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
