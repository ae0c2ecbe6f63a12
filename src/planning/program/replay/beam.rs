//! Whether two carriages on one beam keep their distance.

use super::faults::Faults;
use super::travel::{Axes, Moved, PRINTED_MM};
use crate::planning::finding::Code;
use crate::planning::tape::machine::Machine;

/// Checks the end of a move. Carriages move straight and together, so that a distance kept at both ends of every move
/// is kept all along; which of the two lies farther toward +V does not change from where they are parked.
pub(super) fn check(machine: &Machine, axes: &Axes<'_>, moved: &Moved, faults: &mut Faults<'_>) {
    let (Some(clearance), [one, other]) = (machine.beam_clearance, machine.cutters.as_slice()) else {
        return;
    };
    let kept_mm = axes.lateral_at(0, &moved.to) - axes.lateral_at(1, &moved.to);
    let kept_mm = if one.park_mm() > other.park_mm() { kept_mm } else { -kept_mm };
    let stands = (0..2).all(|cutter| axes.lateral_delta(cutter, moved) == 0.0);
    // Both positions are rounded. What is no number keeps no distance.
    if stands || kept_mm >= clearance.mm() - 2.0 * PRINTED_MM {
        return;
    }
    faults.at_line(Code::CarriagesTooClose, moved.line, || {
        let clearance = clearance.mm();
        if kept_mm < 0.0 {
            return format!("the carriages pass one another by {:.4} mm on one beam, where they keep {clearance} mm", -kept_mm);
        }
        format!("the carriages come within {kept_mm:.4} mm of one another on one beam, where they keep {clearance} mm")
    });
}
