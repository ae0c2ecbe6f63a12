//! The way back from NC text: a strict reader of the `sinumerik` dialect.
//!
//! It shares nothing with the writer, nor with the reader of `linuxcnc`. Refused is whatever could mean another motion
//! than the one that is proved: names, assignments, variables, blocks that a switch skips, words that no table of
//! the profile names.

mod block;
mod word;

use super::super::events::{Event, Executed, Positions};
use crate::planning::finding::{Code, Finding};
use crate::planning::tape::machine::Machine;
use block::{Action, Settings};

/// The longest line in characters; the profile's own limit is checked elsewhere.
const LONGEST_LINE: usize = 512;

/// Nobody reads more faults of a text than this.
const MOST_FAULTS: usize = 50;

/// Reads a program: what the control of a machine would do, in order, from where it stands at the start.
///
/// # Errors
/// Every refused line, as `NAME:LINE`: `UnreadableProgram`, or `NoProgramEnd` if no M30 ends the program. After
/// 50 of them the reader gives up.
pub fn read(name: &str, text: &str, machine: &Machine) -> Result<Vec<Executed>, Vec<Finding>> {
    let mut control = Control {
        machine,
        settings: Settings::default(),
        positions: super::home(machine),
        events: Vec::new(),
        ended: false,
    };
    let mut faults = Vec::new();
    let mut last = 1;
    for (index, line) in text.split('\n').enumerate() {
        last = index + 1;
        if let Err(message) = control.take(line, last) {
            faults.push(Finding::error(Code::UnreadableProgram, format!("{name}:{last}"), message));
        }
        if faults.len() >= MOST_FAULTS {
            let message = format!("{MOST_FAULTS} lines refused; what follows was not read");
            faults.push(Finding::error(Code::UnreadableProgram, format!("{name}:{last}"), message));
            return Err(faults);
        }
    }
    if !control.ended {
        let message = "the text stops without M30: the file may be cut short";
        faults.push(Finding::error(Code::NoProgramEnd, format!("{name}:{last}"), message));
    }
    if faults.is_empty() { Ok(control.events) } else { Err(faults) }
}

struct Control<'a> {
    machine: &'a Machine,
    settings: Settings,
    positions: Positions,
    events: Vec<Executed>,
    ended: bool,
}

impl Control<'_> {
    fn take(&mut self, line: &str, number: usize) -> Result<(), String> {
        let line = line.strip_suffix('\r').unwrap_or(line);
        if line.len() > LONGEST_LINE {
            return Err(format!("the line has {} characters, a control takes {LONGEST_LINE}", line.len()));
        }
        if let Some(letter) = line.chars().find(|letter| !matches!(letter, ' '..='~' | '\t')) {
            return Err(format!("{letter:?} is not a printable 7-bit character"));
        }
        let code = line.split_once(';').map_or(line, |(code, _)| code).trim_matches([' ', '\t']);
        if code.is_empty() {
            return Ok(());
        }
        if self.ended {
            return Err("no control reads what stands after the end of the program".to_owned());
        }
        let words = word::split(code)?;
        let Some(action) = block::interpret(&words, self.machine, &mut self.settings)? else { return Ok(()) };
        let event = self.act(action);
        self.events.push(Executed { line: number, event });
        Ok(())
    }

    fn act(&mut self, action: Action) -> Event {
        match action {
            Action::Move { targets, cruise_s } => {
                let from = self.positions;
                self.positions = std::array::from_fn(|axis| targets[axis].unwrap_or(from[axis]));
                Event::Move { from, to: self.positions, cruise_s }
            }
            Action::Alone { axis, target, speed } => {
                let from = self.positions;
                self.positions[axis] = target;
                let seconds = (target - from[axis]).abs() * 60.0 / speed;
                Event::Move { from, to: self.positions, cruise_s: Some(seconds) }
            }
            Action::Output { number, on } => Event::Output { number, on },
            Action::Dwell { seconds } => Event::Dwell { seconds },
            Action::OptionalStop => Event::OptionalStop,
            Action::End => {
                self.ended = true;
                Event::End
            }
        }
    }
}

#[cfg(test)]
mod tests;
