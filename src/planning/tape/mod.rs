//! Two-cutter cutting of prepreg tape (domain: two-step automated tape laying).
//!
//! In the order in which a job passes through: `wire` (as it stands in JSON) -> `file` (what stands in files) ->
//! `input`, `outline` and `machine` (checked), `courses` (generated) -> `develop` (`curve`, `foot`) -> `piece` -> `chain` -> `assign` (the
//! knives of a piece by itself) -> `roll` (`block` and `front`: what matters there of a piece; `place`: where it goes;
//! `pace`: which knives are quickest) -> `stroke` -> `overcut` -> `offset` -> `timeline`. `plan` puts the geometric steps together, `report` writes
//! the figures.

pub mod assign;
pub mod beam;
pub mod block;
pub mod chain;
pub mod courses;
mod coverage;
pub mod curve;
pub mod develop;
pub mod developed;
mod difference;
pub mod excess;
pub mod file;
pub mod foot;
pub mod front;
pub mod input;
pub mod label;
pub mod likeness;
pub mod machine;
pub mod mould;
pub mod offset;
pub mod outline;
pub mod overcut;
pub mod pace;
pub mod piece;
pub mod place;
pub mod plan;
pub mod report;
pub mod restart;
pub mod roll;
pub mod setup;
pub mod sides;
pub mod sliver;
pub mod spool;
pub mod stroke;
pub mod timeline;
pub mod tips;
pub mod trace;
pub mod wire;
pub mod words;
pub mod zone;

use self::difference::difference;
use self::input::TapeInput;
use self::label::CourseLabel;
use self::plan::{PlannedPiece, TapePlan};
use self::report::TapeReport;
use self::restart::Made;
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
use super::program::replay::layout::{Laid, Layout, check_layout};
use super::program::replay::{ReplayFigures, ReplaySetup, dry, replay};
use super::tolerance::REPLAY_SLACK_MM;

/// Name of the one program of a tape-cut job: what it is, with the ending of its dialect.
#[must_use]
pub fn program_name(input: &TapeInput) -> String {
    let from = input.from_course.map_or(String::new(), |CourseLabel { ply, number }| {
        let ply = ply.map_or(String::new(), |ply| format!("-ply-{ply}"));
        format!("-from{ply}-course-{number}")
    });
    let dry = if input.dry_run { "-dry-run" } else { "" };
    format!("roll{from}{dry}.{}", language(input.machine.dialect).ending)
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
            Outcome::new("tape-cut", input_sha256, findings, vec![], vec![], None::<TapeReport<'_>>)
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
    let checked = input::check(input, &listed.plies, catalogue);
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
    /// The text of the program that really cuts, where `text` is that of a dry run.
    cutting: Option<String>,
    program: TapeProgram,
    bound_time_s: f64,
    trace: PlantedTrace,
    /// What an earlier run has cut, in roll coordinates, where the program goes on from a course.
    before: Vec<Vec<[f64; 2]>>,
    /// What it makes of each piece, where it goes on from a course.
    made: Option<Made>,
    finding: Option<Finding>,
}

/// The strokes of the edges of each cutter with their overcuts, and what should be known of these.
fn edge_strokes(plan: &TapePlan, input: &TapeInput) -> (Vec<Vec<stroke::Stroke>>, Option<Finding>) {
    let mut strokes = plan.strokes(input);
    let finding = overcut::extend(&mut strokes, plan, &input.machine);
    (strokes, finding)
}

/// The strokes of the axes of each cutter.
fn axis_strokes(plan: &TapePlan, input: &TapeInput) -> Result<Vec<Vec<stroke::Stroke>>, Vec<Finding>> {
    offset::follow(edge_strokes(plan, input).0, &input.machine, input.tolerance.mm())
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
    let machine = &input.machine;
    let (strokes, finding) = edge_strokes(plan, input);
    let trace = trace::planted(plan, &strokes, input);
    let strokes = offset::follow(strokes, machine, input.tolerance.mm())?;
    let kept = input.from_course.map(|_| strokes.clone());
    let mut bound_time_s = timeline::bound_s(&strokes, machine);
    let whole = timeline::merge(strokes, machine, input.tolerance.mm())?;
    let (mut program, mut before, mut made) = (whole, Vec::new(), None);
    if let Some((course, mut strokes)) = input.from_course.zip(kept) {
        let restart = restart::from_course(&program, course, machine, plan.figures.lead_mm);
        restart::Restart { program, before } = restart.map_err(|fault| vec![fault])?;
        made = Some(restart::made(&strokes, program.start.feed_mm));
        let later = |stroke: &stroke::Stroke| restart::is_later(stroke, program.start.feed_mm);
        strokes.iter_mut().for_each(|strokes| strokes.retain(later));
        bound_time_s = timeline::bound_s(&strokes, machine);
    }
    budget.stage("write");
    let cutting = input.dry_run.then(|| nc::emit::emit(&program, machine, input_sha256));
    program.dry = input.dry_run;
    let text = nc::emit::emit(&program, machine, input_sha256);
    Ok(Written { text, cutting, program, bound_time_s, trace, before, made, finding })
}

fn finish(
    plan: &TapePlan,
    mut written: Written,
    input: &TapeInput,
    mut findings: Vec<Finding>,
    input_sha256: &str,
    budget: &Budget<'_>,
) -> Outcome {
    let name = program_name(input);
    let tips = tips::tips(plan, &input.machine);
    findings.extend(written.finding.take());
    findings.extend(tips::lacking_overcut(&tips, &input.machine));
    let (figures, faults) = judge(&name, &written.text, &written, plan, input, budget);
    findings.extend(faults);
    input.origins.relocate(&mut findings);
    budget.stage("draw");
    // A plan whose program failed its replay is drawn too: a person then looks for the reason.
    let mut drawings = drawings(plan, input);
    drawings.push(timeline_drawing(&written.program, &input.machine));
    budget.stage("report");
    let Written { text, program, bound_time_s, trace, made, .. } = written;
    let report = TapeReport::new(plan, input, &program, bound_time_s, figures, tips);
    let file = ProgramFile { name, dialect: language(input.machine.dialect).name, text };
    let sheet = (!any_error(&findings)).then(|| {
        setup::Sheet { plan, program: &program, input, made: made.as_ref() }.write(
            &file,
            input_sha256,
            &findings,
        )
    });
    let attachments = trace.into_attachments().into_iter().chain(sheet).collect();
    Outcome::new("tape-cut", input_sha256, findings, vec![file], drawings, Some(report))
        .with_attachments(attachments)
}

/// Reads a program back from its text and replays it against a plan; a dry run against the program that it is the dry
/// run of, which is replayed itself. The findings are errors where the program must not run.
fn judge(
    name: &str,
    text: &str,
    written: &Written,
    plan: &TapePlan,
    input: &TapeInput,
    budget: &Budget<'_>,
) -> (ReplayFigures, Vec<Finding>) {
    let wanted = plan.wanted();
    let overcut_mm = input.machine.overcut().mm();
    let setup = ReplaySetup {
        program: name,
        machine: &input.machine,
        lead_mm: plan.figures.lead_mm,
        tolerance_mm: input.tolerance.mm(),
        tape_width_mm: input.width.mm(),
        wanted: &wanted,
        overcut_mm,
        pieces: &if overcut_mm > 0.0 { overcut::outlines(plan) } else { Vec::new() },
        before: &written.before,
    };
    budget.stage("read back");
    let read = |text: &str| nc::read_back(name, text, &input.machine);
    let events = read(text);
    budget.stage("replay");
    let judged = match &written.cutting {
        None => events.map(|events| replay(&setup, &events)),
        Some(cutting) => events.and_then(|dry| {
            let cutting = read(cutting)?;
            let (figures, mut findings) = replay(&setup, &cutting);
            findings.extend(dry::compare(name, &dry, &cutting));
            Ok((figures, findings))
        }),
    };
    let (figures, mut findings) =
        judged.unwrap_or_else(|faults| (ReplayFigures::nothing_made(&wanted), faults));
    findings.extend(misplaced(name, plan, input));
    findings.extend(too_long(name, text, input.machine.max_line_characters));
    (figures, findings)
}

/// Pieces that lie where they must not.
fn misplaced(name: &str, plan: &TapePlan, input: &TapeInput) -> Vec<Finding> {
    let pieces: Vec<(Laid, &PlannedPiece)> = plan
        .pieces()
        .map(|(course, piece)| {
            let range = (piece.u.0 + piece.offset_mm, piece.u.1 + piece.offset_mm);
            (Laid { course: course.label, range }, piece)
        })
        .collect();
    let laid: Vec<Laid> = pieces.iter().map(|(laid, _)| *laid).collect();
    let layout = Layout {
        // The U axis reads 0 with the leading end under cutter 1.
        leading_end_mm: plan.figures.lead_mm + input.machine.cutters[0].station.mm(),
        zones_mm: &input.zones_mm,
        gap_mm: input.scrap_gap.mm(),
        width_mm: input.width.mm(),
        within_mm: input.tolerance.mm() + REPLAY_SLACK_MM,
    };
    check_layout(name, &laid, |index| pieces[index].1.outline_on_roll(), &layout)
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
    let (words, mut findings) = compared(&input, input_sha256, name, text, budget);
    input.origins.relocate(&mut findings);
    Ok((words, findings))
}

/// The figures of a program in words and all that is to be said of it, at places of the job document.
fn compared(
    input: &TapeInput,
    input_sha256: &str,
    name: &str,
    text: &str,
    budget: &Budget<'_>,
) -> (String, Vec<Finding>) {
    let plan = match plan::plan(input, budget, &mut Vec::new()) {
        Ok(plan) => plan,
        Err(faults) => return ("the job has no plan".to_owned(), faults),
    };
    let written = match write(&plan, input, input_sha256, budget) {
        Ok(written) => written,
        Err(faults) => return ("the job has no program".to_owned(), faults),
    };
    let (figures, mut findings) = judge(name, text, &written, &plan, input, budget);
    findings.extend(difference(name, text, &written.text));
    (figures.to_string(), findings)
}
