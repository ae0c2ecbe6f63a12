//! LinuxCNC's own interpreter as an independent reader of NC programs.
//!
//! `make test` puts it under `target/linuxcnc` (`tests/linuxcnc/prepare`). It knows nothing of this crate, so where
//! it and our reader agree on a program, the text means what we think it means.

pub mod agreement;
mod emitted;
mod interpreter;
mod planted;

use std::fs;
use std::path::PathBuf;

use bladeplan::planning::program::events::Positions;
use rstest::rstest;
use serde::Deserialize;

pub use emitted::plan;
pub use interpreter::interpret;

/// A call that the interpreter makes to the control, and the line (from 1) that it stands for.
#[derive(Debug, Clone, PartialEq)]
pub struct CanonEvent {
    /// Line number, from 1.
    pub line: usize,
    /// What is asked of the control.
    pub call: Call,
}

/// What the interpreter asks of the control.
#[derive(Debug, Clone, PartialEq)]
pub enum Call {
    /// A move of all axes as fast as they can.
    Rapid { to: Positions },
    /// A move at a feed of `rate` mm/min, or degrees/min where only A, B or C move.
    Feed { to: Positions, rate: f64, mode: FeedMode },
    /// A digital output changes: at once, or with the start of the next move.
    Output { number: u32, on: bool, with_motion: bool },
    /// Nothing moves for a while.
    Dwell { seconds: f64 },
    /// A stop that the operator can switch on.
    OptionalStop,
    /// The end of the program.
    End,
    /// Something that no knife program does, by name.
    Foreign(String),
}

/// How the program gives its feeds. The rate of [`Call::Feed`] is worked out by the interpreter in any case.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FeedMode {
    /// G93.
    InverseTime,
    /// G94.
    PerMinute,
    /// G95.
    PerRevolution,
}

/// Why the interpreter refuses a program. Line 0: none in particular.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
pub struct InterpreterError {
    /// Line number, from 1.
    pub line: usize,
    /// The interpreter's own words.
    pub message: String,
}

/// The text of `tests/fixtures/nc/NAME.ngc`.
pub fn fixture(name: &str) -> String {
    let path =
        PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/nc").join(name).with_extension("ngc");
    fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn at(line: usize, call: Call) -> CanonEvent {
    CanonEvent { line, call }
}

/// Positions with only U V W A B given.
fn knives(u: f64, v: f64, w: f64, a: f64, b: f64) -> Positions {
    [0.0, 0.0, 0.0, a, b, 0.0, u, v, w]
}

fn rounded(mut events: Vec<CanonEvent>) -> Vec<CanonEvent> {
    // The interpreter's module goes through inches and back.
    let nano = |x: &mut f64| *x = (*x * 1e9).round() / 1e9;
    for event in &mut events {
        match &mut event.call {
            Call::Rapid { to } => to.iter_mut().for_each(nano),
            Call::Feed { to, rate, .. } => {
                to.iter_mut().for_each(nano);
                nano(rate);
            }
            _ => {}
        }
    }
    events
}

#[test]
fn every_kind_of_event_comes_with_its_line() {
    let output = |number, on, with_motion| Call::Output { number, on, with_motion };
    let feed = |to, rate, mode| Call::Feed { to, rate, mode };
    let expected = vec![
        at(4, Call::Rapid { to: knives(5.0, -10.5, 0.0, 0.0, 0.0) }),
        at(5, output(2, true, false)),
        at(6, Call::Dwell { seconds: 0.25 }),
        // U, V and W count for F: 30, 40 and nothing are 50 mm.
        at(7, feed(knives(35.0, 29.5, 0.0, 45.0, 0.0), 3000.0, FeedMode::PerMinute)),
        at(8, output(0, true, true)),
        // 12 a minute: the 50 mm back again at 600 mm/min.
        at(9, feed(knives(5.0, -10.5, 0.0, 45.0, 0.0), 600.0, FeedMode::InverseTime)),
        // Only blades: 30 and 40 degrees at once are 50 degrees, 6 a minute.
        at(10, feed(knives(5.0, -10.5, 0.0, 75.0, 40.0), 300.0, FeedMode::InverseTime)),
        at(11, output(0, false, true)),
        at(12, Call::OptionalStop),
        at(13, feed(knives(5.0, -10.5, 7.125, 75.0, 40.0), 100.0, FeedMode::PerMinute)),
        at(14, output(2, false, false)),
        at(15, Call::End),
    ];
    assert_eq!(rounded(interpret(&fixture("every_event")).unwrap()), expected);
}

#[test]
fn nothing_of_a_program_is_left_for_the_next() {
    let second = "G0 U1\nM2\n";
    let alone = interpret(&format!("G21\n{second}")).unwrap();
    interpret("G21 G91 G93 G10 L2 P1 U3\nG92 V4\nG1 U1 F1\nM62 P0\nM2\n").unwrap();
    assert_eq!(interpret(&format!("G21\n{second}")).unwrap(), alone);
}

#[test]
fn what_no_knife_program_does_is_named() {
    let calls: Vec<(usize, String)> = interpret(&fixture("foreign"))
        .unwrap()
        .into_iter()
        .filter_map(|event| match event.call {
            Call::Foreign(name) => Some((event.line, name)),
            _ => None,
        })
        .collect();
    let expected = [
        (2, "arc"),
        (3, "spindle_clockwise"),
        (4, "analog_output"),
        (5, "message"),
        (6, "log_open"),
        (7, "python"),
        (8, "stop"),
        (9, "user_m_code"),
        (10, "origin_shift"),
    ];
    let found: Vec<(usize, &str)> = calls.iter().map(|(line, name)| (*line, name.as_str())).collect();
    // The end takes the shifted origin back, which is reported once more.
    assert_eq!(found[..expected.len()], expected);
}

#[rstest]
#[case::no_end("G21\nG0 U1\n", "File ended with no percent sign or program end")]
#[case::no_feed("G21\nG1 U1\nM2\n", "Cannot do g1 with zero feed rate")]
#[case::inverse_time_without_feed("G21 G93 F2\nG1 U1\nM2\n", "F word missing with inverse time g1 move")]
#[case::two_words("G21\nG0 U1 U2\nM2\n", "Multiple U words on one line")]
#[case::decimal_comma("G21\nG0 U1,5\nM2\n", "Bad character ',' used")]
#[case::equals("G21\nG0 U=15\nM2\n", "bad number format (conversion failed) parsing ''")]
#[case::unknown_code("G21\nG642\nM2\n", "G-code out of range")]
fn a_refusal_names_line_and_reason(#[case] program: &str, #[case] message: &str) {
    let error = interpret(program).unwrap_err();
    assert_eq!((error.line, error.message.as_str()), (2, message));
}

#[test]
fn a_program_without_end_is_given_up() {
    let error = interpret("o1 while [1]\nG4 P0\no1 endwhile\nM2\n").unwrap_err();
    assert_eq!(error.message, "it has no end");
}
