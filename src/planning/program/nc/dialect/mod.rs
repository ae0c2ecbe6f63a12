//! Dialects: how one control writes what all of them do. A dialect is one small file here, and a reader beside it.

mod linuxcnc;
mod sinumerik;

use crate::planning::tape::machine::{Dialect, Machine};

/// Something that goes on and off.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Switched {
    /// The knife of a cutter, from 0; on is down.
    Knife(usize),
    /// The knives' generator.
    Ultrasonic,
}

/// How a control writes what all of them do. Every text is one block or comment, without its number and line end;
/// numbers come as text.
#[derive(Debug, Clone, Copy)]
pub struct Language {
    /// As a report names it.
    pub name: &'static str,
    /// The ending of its files' names.
    pub ending: &'static str,
    /// The blocks that make every setting on which a motion depends: mm, absolute positions, inverse time, exact stop.
    pub modes: fn(&Machine) -> Vec<String>,
    /// A comment, of capitals, digits, blanks, commas and points.
    pub comment: fn(&str) -> String,
    /// A dwell of so many seconds.
    pub dwell: fn(&str) -> String,
    /// Switches something at once, with everything at rest.
    pub switch: fn(&Machine, Switched, bool) -> String,
    /// A stop that the operator can switch on.
    pub optional_stop: fn(&Machine) -> String,
    /// The end of a program.
    pub end: &'static str,
}

/// The language of a dialect.
#[must_use]
pub fn language(dialect: Dialect) -> &'static Language {
    match dialect {
        Dialect::Linuxcnc => &linuxcnc::LINUXCNC,
        Dialect::Sinumerik => &sinumerik::SINUMERIK,
    }
}
