//! The way back from KRL text: a reader of the files of a program.
//!
//! It has two layers. [`statements`] says what each line means by itself, and is all that a conversion needs.
//! [`execute`] runs the files as a control would, from the first line of the main program.
//!
//! It is tolerant in how a program is written: any case, types before components, components left out or in
//! another order, points in data lists, sub-programs. It is strict in what moves the robot, or changes how it moves:
//! what it does not understand whole, it refuses, with file, line and column.

mod cursor;
mod fault;
mod lexer;
mod machine;
mod memory;
mod motion;
mod parse;
mod position;
mod program;
mod run;
mod settings;
pub mod statement;
mod value;
mod words;

use super::super::robot_events::RobotExecuted;
use crate::planning::finding::{Code, Finding};
use crate::planning::outcome::ProgramFile;
use program::Program;

pub use parse::statements;

/// A text that is no program at all gives a fault a line; nobody reads more of them than this.
const MOST_FAULTS: usize = 50;

/// A run of more statements has no end that anyone waits for. The largest parts take some hundred thousand.
const MOST_STATEMENTS: usize = 2_000_000;

/// Runs the program whose main file has the name `main`: what the control would do, in order. The `file` of what is
/// done is an index into `files`.
///
/// # Errors
/// Refused lines as `NAME:LINE:COLUMN`: `UnreadableProgram`, or `NoProgramEnd` where END or ENDDAT is missing. First
/// all that can be told from the lines themselves, up to 50 of them; if there are none, the first one at which the
/// run stops.
pub fn execute(files: &[ProgramFile], main: &str) -> Result<Vec<RobotExecuted>, Vec<Finding>> {
    let program = Program::of(files)?;
    run::run(&program, main, MOST_STATEMENTS).map_err(|fault| vec![fault])
}

fn unreadable(name: &str, line: usize, column: usize, message: impl Into<String>) -> Finding {
    Finding::error(Code::UnreadableProgram, format!("{name}:{line}:{column}"), message)
}

#[cfg(test)]
mod tests;
