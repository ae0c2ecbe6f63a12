//! NC programs: out in the `dialect` of a machine's control, and back by a reader of that dialect.

pub mod dialect;
pub mod emit;
pub mod read;
pub mod sinumerik;

use super::events::{AXIS_LETTERS, Executed, Positions};
use crate::planning::finding::Finding;
use crate::planning::tape::machine::{Dialect, Machine};

/// Reads a program back as the control of a machine would. `name` stands in the findings.
///
/// # Errors
/// Every refused line; see the readers.
pub fn read_back(name: &str, text: &str, machine: &Machine) -> Result<Vec<Executed>, Vec<Finding>> {
    match machine.dialect {
        Dialect::Linuxcnc => read::read_from(name, text, home(machine)),
        Dialect::Sinumerik => sinumerik::read(name, text, machine),
    }
}

/// Where a machine stands when a program begins: all axes at 0, its carriages where they are parked.
fn home(machine: &Machine) -> Positions {
    let mut home = [0.0; 9];
    for cutter in &machine.cutters {
        let place = AXIS_LETTERS.iter().position(|axis| *axis == cutter.lateral_axis);
        place.into_iter().for_each(|axis| home[axis] = cutter.park_mm());
    }
    home
}
