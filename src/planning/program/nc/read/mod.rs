//! The way back from NC text: a strict reader of the `linuxcnc` dialect.
//!
//! It accepts less than LinuxCNC does. Refused is what LinuxCNC would refuse, what depends on settings that
//! do not stand in the text (inches, offsets, blending, a block-delete switch), and what acts at another
//! moment than it seems to (M62 and M63 wait for a motion; text after M2 is never read).

mod block;
mod words;

use std::ops::Range;

use super::super::events::{Event, Executed, Positions};
use crate::planning::finding::{Code, Finding};
use block::{Action, Modal};

/// The longest line in bytes without its line feed. LinuxCNC reads into 256 bytes and refuses what fills them.
const LONGEST_LINE: usize = 252;

/// A text that is no NC program at all gives a fault a line; nobody reads more of them than this.
const MOST_FAULTS: usize = 50;

/// LinuxCNC 2.9 and earlier feed no slower than this, in mm/min along X, Y, Z, else along U, V, W, or in
/// degrees/min, even in inverse time (`inverse_time_rate_straight`). So a blade that turns over next to no tape
/// turns faster than its F says, and that is the time given here: no version is faster.
const LEAST_FEED: f64 = 0.1;

/// LinuxCNC takes an axis that moves less than this, in mm or degrees, for standing when it chooses the group
/// of axes to which a feed belongs (`find_straight_length`).
const STANDSTILL: f64 = 1e-7;

const X_Y_Z: Range<usize> = 0..3;
const A_B_C: Range<usize> = 3..6;
const U_V_W: Range<usize> = 6..9;

/// Reads a program: what the control would do, in order, from all axes at 0. `name` stands in the findings.
///
/// # Errors
/// Every refused line, as `NAME:LINE`: `UnreadableProgram`, or `NoProgramEnd` if no M2 ends the program. After
/// 50 of them the reader gives up and says so.
pub fn read(name: &str, text: &str) -> Result<Vec<Executed>, Vec<Finding>> {
    read_from(name, text, [0.0; 9])
}

/// As [`read`], from where the axes stand.
///
/// # Errors
/// As those of [`read`].
pub fn read_from(name: &str, text: &str, home: Positions) -> Result<Vec<Executed>, Vec<Finding>> {
    let mut reader = Reader { positions: home, ..Reader::new(name) };
    for (index, line) in text.split('\n').enumerate() {
        if reader.gave_up {
            break;
        }
        reader.line = index + 1;
        reader.take(line);
    }
    reader.finish()
}

/// How far the reader is in a file that may be wrapped in `%` lines.
#[derive(Clone, Copy, PartialEq)]
enum Part {
    /// Nothing but blank lines so far.
    Front,
    /// In the program.
    Body,
    /// After M2.
    Ended,
    /// After the `%` that follows M2.
    Closed,
}

struct Reader<'a> {
    name: &'a str,
    line: usize,
    part: Part,
    wrapped: bool,
    modal: Modal,
    positions: Positions,
    events: Vec<Executed>,
    faults: Vec<Finding>,
    gave_up: bool,
}

impl<'a> Reader<'a> {
    fn new(name: &'a str) -> Self {
        Self {
            name,
            line: 0,
            part: Part::Front,
            wrapped: false,
            modal: Modal::default(),
            positions: [0.0; 9],
            events: Vec::new(),
            faults: Vec::new(),
            gave_up: false,
        }
    }

    fn take(&mut self, line: &str) {
        if let Err(message) = self.try_take(line) {
            self.refuse(Code::UnreadableProgram, message);
        }
    }

    fn try_take(&mut self, line: &str) -> Result<(), String> {
        let text = plain(line)?;
        if text.is_empty() {
            return Ok(());
        }
        match (self.part, text == "%") {
            (Part::Front, true) => self.wrapped = true,
            (Part::Front | Part::Body, false) => {
                // The part moves on even if the block is refused: a later `%` is no opening one.
                self.part = Part::Body;
                return self.execute(text);
            }
            (Part::Body, true) => return Err("a control stops reading at this %, before any M2".to_owned()),
            (Part::Ended, true) if self.wrapped => {
                self.part = Part::Closed;
                return Ok(());
            }
            (Part::Ended | Part::Closed, _) => {
                return Err("no control reads what stands after the end of the program".to_owned());
            }
        }
        self.part = Part::Body;
        Ok(())
    }

    fn execute(&mut self, text: &str) -> Result<(), String> {
        let words = words::split(text)?;
        let Some(action) = block::interpret(&words, &mut self.modal)? else { return Ok(()) };
        let event = match action {
            Action::Move { targets, cruise_s } => self.go(targets, cruise_s),
            Action::Travel { axis, target, per_minute } => self.travel(axis, target, per_minute),
            Action::Output { number, on } => Event::Output { number, on },
            Action::Dwell { seconds } => Event::Dwell { seconds },
            Action::OptionalStop => Event::OptionalStop,
            Action::End => {
                self.part = Part::Ended;
                Event::End
            }
        };
        self.events.push(Executed { line: self.line, event });
        Ok(())
    }

    /// Axes without a word stay where they are.
    fn go(&mut self, targets: [Option<f64>; 9], cruise_s: Option<f64>) -> Event {
        let from = self.positions;
        for (position, target) in self.positions.iter_mut().zip(targets) {
            *position = target.unwrap_or(*position);
        }
        let to = self.positions;
        Event::Move { from, to, cruise_s: cruise_s.map(|seconds| seconds.min(longest_s(&from, &to))) }
    }

    /// The least feed is one of inverse time alone.
    fn travel(&mut self, axis: usize, target: f64, per_minute: f64) -> Event {
        let from = self.positions;
        self.positions[axis] = target;
        let cruise_s = Some(60.0 * (target - from[axis]).abs() / per_minute);
        Event::Move { from, to: self.positions, cruise_s }
    }

    fn refuse(&mut self, code: Code, message: impl Into<String>) {
        self.faults.push(Finding::error(code, format!("{}:{}", self.name, self.line), message));
        if self.faults.len() >= MOST_FAULTS {
            self.gave_up = true;
            let message = format!("{MOST_FAULTS} lines refused; what follows was not read");
            let at = format!("{}:{}", self.name, self.line);
            self.faults.push(Finding::error(Code::UnreadableProgram, at, message));
        }
    }

    fn finish(mut self) -> Result<Vec<Executed>, Vec<Finding>> {
        if !self.gave_up {
            self.check_end();
        }
        if self.faults.is_empty() { Ok(self.events) } else { Err(self.faults) }
    }

    fn check_end(&mut self) {
        match self.part {
            Part::Front | Part::Body => {
                self.refuse(Code::NoProgramEnd, "the text stops without M2: the file may be cut short");
            }
            Part::Ended if self.wrapped => {
                let message = "the file opens with % and does not close with it: it may be cut short";
                self.refuse(Code::UnreadableProgram, message);
            }
            Part::Ended | Part::Closed => {}
        }
    }
}

/// The longest time in s that a move takes whatever its F says, see [`LEAST_FEED`]; no limit if nothing moves.
fn longest_s(from: &Positions, to: &Positions) -> f64 {
    let way = |axis: usize| to[axis] - from[axis];
    for group in [X_Y_Z, U_V_W, A_B_C] {
        if group.clone().any(|axis| way(axis).abs() > STANDSTILL) {
            return 60.0 * group.map(|axis| way(axis).powi(2)).sum::<f64>().sqrt() / LEAST_FEED;
        }
    }
    f64::INFINITY
}

/// A line as LinuxCNC takes it: 7-bit ASCII of bounded length, a carriage return only at its end.
fn plain(line: &str) -> Result<&str, String> {
    if line.len() > LONGEST_LINE {
        return Err(format!("the line has {} bytes, a control takes {LONGEST_LINE}", line.len()));
    }
    let line = line.strip_suffix('\r').unwrap_or(line);
    match line.chars().find(|letter| !matches!(letter, ' '..='~' | '\t')) {
        Some(letter) => Err(format!("{letter:?} is not a printable 7-bit character")),
        None => Ok(line.trim_matches([' ', '\t'])),
    }
}

#[cfg(test)]
mod tests;
