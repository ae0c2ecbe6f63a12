//! The job that makes a milling program into one for V-shaped cutting: checked, converted, read back, replayed.

use super::attempt::{read_and_replay, stem};
use super::blade::Side;
use super::cell::{self, Cell};
use super::contour::compare;
use super::convert::{Conversion, Converted, convert};
use super::follow;
use super::input::{Setting, check_profile, check_setting};
use super::pictures;
use super::replay::Replay;
use super::replay::cuts::WantedCut;
use super::report::{ConversionFigures, HoneycombReport, MachineFigures, RobotFigures};
use super::{differences, wire};
use crate::planning::budget::Budget;
use crate::planning::catalogue::Catalogue;
use crate::planning::document::files::Files;
use crate::planning::finding::{Code, Finding, any_error};
use crate::planning::geometry::Point2;
use crate::planning::outcome::{Outcome, ProgramFile};
use crate::planning::program::robot_moves::Speeds;
use crate::planning::robot::check::RobotCheck;

/// A conversion's input, checked.
struct Input {
    setting: Setting,
    profile: Option<Vec<Point2>>,
    swing: f64,
    extension_mm: f64,
    cell: Cell,
}

/// Checks what can be checked without the milling program.
///
/// # Errors
/// Every fault with its JSON pointer.
pub fn validate(input: &wire::HoneycombConvert, catalogue: &Catalogue) -> Result<(), Vec<Finding>> {
    taken_over(input, None, catalogue).map(|_| ())
}

fn taken_over(
    input: &wire::HoneycombConvert,
    files: Option<&Files>,
    catalogue: &Catalogue,
) -> Result<Input, Vec<Finding>> {
    let mut faults = Vec::new();
    let cell = cell::check(input.cell.as_ref(), catalogue, files, &mut faults);
    let setting = check_setting(input.blank, &input.tool, input.process, &mut faults);
    let profile =
        input.profile.as_ref().map(|profile| check_profile(profile, &input.blank, files, &mut faults));
    let given = &input.parameters;
    if given.swing_angle_deg > input.tool.max_swing_angle_deg {
        let message = format!(
            "is {} degrees; the tool may be swung by {} at most",
            given.swing_angle_deg, input.tool.max_swing_angle_deg
        );
        faults.push(Finding::error(Code::OutOfRange, "/input/parameters/swing_angle_deg", message));
    }
    let swing = given.swing_angle_deg.to_radians();
    let needed = setting.blade.extension_mm(swing);
    let extension_mm = given.extension_mm.unwrap_or(needed);
    if extension_mm < needed - SHORTER_MM {
        let message = format!(
            "is {extension_mm} mm; the whole blade is outside the blank only from {needed:.4} mm on, and it turns there"
        );
        faults.push(Finding::error(Code::OutOfRange, "/input/parameters/extension_mm", message));
    }
    if faults.is_empty() { Ok(Input { setting, profile, swing, extension_mm, cell }) } else { Err(faults) }
}

/// An extension may be shorter than the blade needs by what a paper prints of it, in mm.
const SHORTER_MM: f64 = 0.000_1;

/// A milling program that was converted and replayed.
struct Done {
    converted: Converted,
    replay: Replay,
    findings: Vec<Finding>,
    robot: Option<RobotCheck>,
}

/// Converts a milling program. It stands in the outcome only if it was read back, its replay has passed, and the robot
/// can follow.
///
/// # Errors
/// Every fault of the input, and of the milling program with its lines.
pub fn plan(
    input: &wire::HoneycombConvert,
    files: &Files,
    catalogue: &Catalogue,
    input_sha256: &str,
    budget: &Budget<'_>,
) -> Result<Outcome, Vec<Finding>> {
    budget.stage("check");
    let checked = taken_over(input, Some(files), catalogue)?;
    let Done { converted, replay, findings, robot } =
        carry_out(input, &checked, files, input_sha256, budget)?;
    budget.stage("draw");
    let drawings = vec![pictures::of_conversion(&converted, &checked.setting.blank)];
    let report = report(&checked, &converted, &replay, robot.as_ref());
    let summary = vec![format!(
        "{} of {} milling points were cuts; {} tips, {:.3} s counted",
        converted.milling.iter().filter(|point| point.cut).count(),
        converted.milling.len(),
        replay.tips(),
        replay.times.total_s()
    )];
    let program = vec![converted.program];
    Ok(Outcome::new("honeycomb-convert", input_sha256, findings, program, drawings, Some(report))
        .with_summary(summary))
}

fn carry_out(
    input: &wire::HoneycombConvert,
    checked: &Input,
    files: &Files,
    input_sha256: &str,
    budget: &Budget<'_>,
) -> Result<Done, Vec<Finding>> {
    budget.stage("convert");
    let wanted = checked.setting.speeds();
    let mut done = at_speeds(wanted, input, checked, files, input_sha256)?;
    let Some(robot) = &checked.cell.robot else {
        done.findings.push(follow::not_checked());
        return Ok(done);
    };
    if any_error(&done.findings) {
        return Ok(done);
    }
    budget.stage("robot");
    let one = |finding| vec![finding];
    let mut check =
        follow::follow(robot, &follow::path(&done.replay.happenings, &checked.cell), budget).map_err(one)?;
    if let Some(speeds) = follow::slowed(&check, &wanted) {
        let before = done.replay.times.total_s();
        let (fastest, ratio) = (check.fastest_joint, check.max_joint_speed_ratio);
        done = at_speeds(speeds, input, checked, files, input_sha256)?;
        done.findings.push(follow::said_slower(
            (fastest, ratio),
            &wanted,
            &speeds,
            [before, done.replay.times.total_s()],
        ));
        check = follow::follow(robot, &follow::path(&done.replay.happenings, &checked.cell), budget)
            .map_err(one)?;
    }
    let names = [done.converted.program.name.clone()];
    let way = follow::path(&done.replay.happenings, &checked.cell);
    done.findings.extend(follow::findings(&check, robot, &way, &names, budget).map_err(one)?);
    done.robot = Some(check);
    Ok(done)
}

/// Converts at some speeds, and replays what was written.
fn at_speeds(
    speeds: Speeds,
    input: &wire::HoneycombConvert,
    checked: &Input,
    files: &Files,
    input_sha256: &str,
) -> Result<Done, Vec<Finding>> {
    let converted = converted(speeds, input, checked, files, input_sha256)?;
    let (replay, mut findings) = replayed(std::slice::from_ref(&converted.program), &converted, checked);
    findings.extend(converted.findings.iter().cloned());
    Ok(Done { converted, replay, findings, robot: None })
}

fn converted(
    speeds: Speeds,
    input: &wire::HoneycombConvert,
    checked: &Input,
    files: &Files,
    input_sha256: &str,
) -> Result<Converted, Vec<Finding>> {
    let name = &input.krl.file;
    let bytes = files.get(name).ok_or_else(|| {
        vec![Finding::error(
            Code::UnknownFile,
            "/input/krl/file",
            format!("{name} was not sent with the job"),
        )]
    })?;
    // Comments of older controls are not UTF-8; what is not a comment is checked by the reader.
    let text = String::from_utf8_lossy(bytes);
    let setup = checked.cell.setup(&checked.setting.process, speeds, None);
    let conversion = Conversion {
        blank: checked.setting.blank,
        blade: &checked.setting.blade,
        swing: checked.swing,
        extension_mm: checked.extension_mm,
        setup: &setup,
    };
    convert(name, &text, &conversion, &stem(input_sha256), input_sha256)
}

/// Replays a program against what the milling program says: each of its cuts, once to each side.
fn replayed(program: &[ProgramFile], converted: &Converted, checked: &Input) -> (Replay, Vec<Finding>) {
    let cuts = converted.milling.iter().filter(|point| point.cut);
    let wanted: Vec<WantedCut> = cuts
        .flat_map(|point| {
            let tip = Point2::new(point.position.x, point.position.z);
            [Side::Left, Side::Right].map(|side| WantedCut { tip, side, swing: checked.swing })
        })
        .collect();
    read_and_replay(program, &checked.setting, checked.profile.as_deref(), &wanted, &checked.cell)
}

fn followed(
    replay: &Replay,
    program: &[ProgramFile],
    checked: &Input,
    findings: &mut Vec<Finding>,
    budget: &Budget<'_>,
) -> Result<Option<RobotCheck>, Finding> {
    let Some(robot) = &checked.cell.robot else {
        findings.push(follow::not_checked());
        return Ok(None);
    };
    if any_error(findings) {
        return Ok(None);
    }
    budget.stage("robot");
    let names: Vec<String> = program.iter().map(|file| file.name.clone()).collect();
    let way = follow::path(&replay.happenings, &checked.cell);
    let check = follow::follow(robot, &way, budget)?;
    findings.extend(follow::findings(&check, robot, &way, &names, budget)?);
    Ok(Some(check))
}

fn report(
    checked: &Input,
    converted: &Converted,
    replay: &Replay,
    robot: Option<&RobotCheck>,
) -> HoneycombReport {
    let names = vec![converted.program.name.clone()];
    let remains = replay.swept.remains.as_ref();
    let likeness = match (&checked.profile, remains) {
        (Some(profile), Some(remains)) => compare(profile, &remains.surface),
        _ => None,
    };
    HoneycombReport {
        machine: checked.cell.identity.as_ref().map(MachineFigures::from),
        conversion: Some(ConversionFigures::new(
            (checked.swing, checked.extension_mm),
            converted.milling.iter().filter(|point| point.cut).count(),
            replay,
            likeness.as_ref(),
        )),
        robot: Some(robot.map_or_else(RobotFigures::default, |check| {
            RobotFigures::new(check, &names).with_time(replay.times.total_s())
        })),
        ..HoneycombReport::default()
    }
}

/// Reads a converted program back and replays it against its job.
///
/// # Errors
/// Every fault of the input.
pub fn check(
    input: &wire::HoneycombConvert,
    files: &Files,
    catalogue: &Catalogue,
    input_sha256: &str,
    program: &[ProgramFile],
    budget: &Budget<'_>,
) -> Result<(String, Vec<Finding>), Vec<Finding>> {
    let checked = taken_over(input, Some(files), catalogue)?;
    let Done { converted, .. } = carry_out(input, &checked, files, input_sha256, budget)?;
    let (replay, mut findings) = replayed(program, &converted, &checked);
    followed(&replay, program, &checked, &mut findings, budget).map_err(|finding| vec![finding])?;
    findings.extend(differences(program, std::slice::from_ref(&converted.program)));
    Ok((replay.words(), findings))
}
