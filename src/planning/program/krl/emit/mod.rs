//! Robot programs as KRL text for KSS 8.
//!
//! A main program (`.src`) sets everything up, goes home and calls the sub-programs that hold the layers; its data
//! list (`.dat`) holds the first layer to be cut, so that a program can be started at any. Outputs are switched by
//! TRIGGER, because an assignment of `$OUT` would stop the advance run, and with it the rounding of free moves.
//! Nothing in the text comes from a person: only numbers, and the hash of the input. Lines end with CR LF.

mod files;
mod layer;
mod words;

use crate::planning::finding::{Code, Finding};
use crate::planning::geometry::frame::{Frame, Pose};
use crate::planning::outcome::{PLANNER_VERSION, ProgramFile};
use crate::planning::program::krl::stem::Stem;
use crate::planning::program::robot_moves::{RobotProgram, RobotSetup, RobotStep, ToolDirection};
use layer::Section;

pub(crate) use files::{file, head};
pub(crate) use words::{closing_lines, initial_lines, opening_moves, trigger};
pub use words::{path_speed, pose_words, setup_lines};

/// The dialect of the files made here.
pub const DIALECT: &str = "krl";

/// A sub-program of fewer lines than this holds next to nothing beside its head, its IF and its end.
pub const LEAST_LINES: usize = 20;

/// So many sub-programs have names of at most 24 characters.
const MOST_FILES: usize = 99_999;

/// Lengths in mm and angles in degrees beyond this are no robot's.
const LARGEST: f64 = 1e6;

/// Writes a program: its main file `STEM.src`, its data list `STEM.dat`, and its sub-programs `STEM_001.src` and so
/// on, of at most `max_lines` lines each. A layer longer than that is split behind a cut over several of them.
///
/// `input_sha256` is in lower-case hex.
///
/// # Errors
/// `OutOfRange` where no program can be written: `max_lines` below [`LEAST_LINES`], a number that is not finite or
/// no robot's, speeds that are not positive.
pub fn emit(program: &RobotProgram, stem: &Stem, input_sha256: &str) -> Result<Vec<ProgramFile>, Finding> {
    check(program)?;
    let setup = &program.setup;
    let room = setup.max_lines - files::OVERHEAD;
    let sections = layer::sections(program, stem, room);
    let subs = files::sub_programs(stem, &sections, room);
    if subs.len() > MOST_FILES {
        return Err(out_of_range(format!("the program needs {} files; allow longer ones", subs.len())));
    }
    let mut files = vec![main_file(program, stem, input_sha256, subs.len()), data_list(stem)];
    files.extend(subs);
    Ok(files)
}

/// What stands at the head of every file, besides `&` lines: where it comes from.
pub(crate) fn origin(what: &str, input_sha256: &str) -> [String; 2] {
    [format!(";BLADEPLAN {PLANNER_VERSION} {what}"), format!(";INPUT {}", input_sha256.to_ascii_uppercase())]
}

/// Lines as text.
pub(crate) fn text_of(lines: &[String]) -> String {
    lines.iter().fold(String::new(), |mut text, line| {
        text.push_str(line);
        text.push_str("\r\n");
        text
    })
}

fn main_file(program: &RobotProgram, stem: &Stem, input_sha256: &str, subs: usize) -> ProgramFile {
    let setup = &program.setup;
    let mut lines = files::head(stem.as_str());
    lines.extend(origin("V-SHAPED CUTTING", input_sha256));
    lines.push(format!(
        ";START AT A LAYER: SET {} IN THE DATA LIST TO ITS NUMBER, 1 TO {}",
        stem.first_layer(),
        program.layers.len()
    ));
    lines.extend(initial_lines());
    lines.extend(setup_lines(setup));
    lines.extend(opening_moves(setup));
    lines.extend((1..=subs).map(|number| format!("  {} ( )", stem.sub_program(number))));
    lines.extend(closing_lines(setup));
    lines.push(format!("  {}=1", stem.first_layer()));
    lines.push("END".to_owned());
    files::file(stem.as_str(), "src", &lines)
}

fn data_list(stem: &Stem) -> ProgramFile {
    let lines = [
        "&ACCESS RVP".to_owned(),
        "&REL 1".to_owned(),
        format!("DEFDAT {} PUBLIC", stem.as_str()),
        "  ;FOLD EXTERNAL DECLARATIONS".to_owned(),
        "  EXT BAS (BAS_COMMAND :IN,REAL :IN )".to_owned(),
        "  ;ENDFOLD (EXTERNAL DECLARATIONS)".to_owned(),
        format!("  DECL GLOBAL INT {}=1", stem.first_layer()),
        "ENDDAT".to_owned(),
    ];
    files::file(stem.as_str(), "dat", &lines)
}

fn check(program: &RobotProgram) -> Result<(), Finding> {
    let setup = &program.setup;
    if setup.max_lines < LEAST_LINES {
        let message =
            format!("a file of {} lines holds no program; allow at least {LEAST_LINES}", setup.max_lines);
        return Err(out_of_range(message));
    }
    check_setup(setup)?;
    for (index, layer) in program.layers.iter().enumerate() {
        for step in &layer.steps {
            let RobotStep::Move { to, .. } = step else { continue };
            check_pose(to).map_err(|finding| {
                let message = format!("layer {}: {}", index + 1, finding.message);
                Finding { message, ..finding }
            })?;
        }
    }
    Ok(())
}

/// Checks that every number of a setup can be written.
///
/// # Errors
/// `OutOfRange` naming the first that cannot.
pub(crate) fn check_setup(setup: &RobotSetup) -> Result<(), Finding> {
    let strange =
        |what: &str, value: f64| Err(out_of_range(format!("{what} is {value}, which no control takes")));
    for (what, frame) in [("the tool frame", &setup.tool), ("the base frame", &setup.base)] {
        check_frame(frame).or_else(|value| strange(what, value))?;
    }
    for joint in setup.home.iter().chain(setup.approach.iter().flatten()) {
        check_number(*joint).or_else(|value| strange("a joint angle", value))?;
    }
    let speeds = [
        ("the cutting speed", words::least_path_speed(setup.speeds.cutting_mm_s)),
        ("the travel speed", words::least_path_speed(setup.speeds.travel_mm_s)),
        ("the angular speed", words::least_turn_speed(setup.speeds.angular_deg_s)),
    ];
    for (what, speed) in speeds {
        speed.or_else(|value| strange(what, value))?;
    }
    if !(0.0..=LARGEST).contains(&setup.blend_mm) {
        return strange("the blend distance", setup.blend_mm);
    }
    if setup.ultrasonic_output == 0 {
        return Err(out_of_range("outputs are counted from 1".to_owned()));
    }
    Ok(())
}

/// Checks that a pose can be written.
///
/// # Errors
/// `OutOfRange` naming the first number that cannot.
pub(crate) fn check_pose(pose: &Pose) -> Result<(), Finding> {
    check_frame(&Frame::of(pose))
        .map_err(|value| out_of_range(format!("{value} mm or degrees is no place for a robot")))
}

fn check_frame(frame: &Frame) -> Result<(), f64> {
    let Frame { x_mm, y_mm, z_mm, a_deg, b_deg, c_deg } = *frame;
    [x_mm, y_mm, z_mm, a_deg, b_deg, c_deg].into_iter().try_for_each(check_number)
}

fn check_number(value: f64) -> Result<(), f64> {
    if value.abs() <= LARGEST { Ok(()) } else { Err(value) }
}

fn out_of_range(message: String) -> Finding {
    Finding::error(Code::OutOfRange, "", message)
}

#[cfg(test)]
mod tests;
