//! NC programs: out in the `dialect` of a machine's control, and back by a reader of that dialect.

pub mod dialect;
pub mod emit;
pub mod read;
pub mod sinumerik;

use super::events::Executed;
use crate::planning::finding::Finding;
use crate::planning::tape::machine::{Dialect, Machine};

/// Reads a program back as the control of a machine would. `name` stands in the findings.
///
/// # Errors
/// Every refused line; see the readers.
pub fn read_back(name: &str, text: &str, machine: &Machine) -> Result<Vec<Executed>, Vec<Finding>> {
    match machine.dialect {
        Dialect::Linuxcnc => read::read(name, text),
        Dialect::Sinumerik => sinumerik::read(name, text, machine),
    }
}
