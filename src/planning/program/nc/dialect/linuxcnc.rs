//! RS-274 as LinuxCNC reads it.
//!
//! Exact path (G61), because every move starts and ends at rest; outputs that act at once (M64/M65), because
//! everything stands when they do.

use super::{Language, Switched};

pub(super) const LINUXCNC: Language = Language {
    name: "linuxcnc",
    ending: "ngc",
    modes: |_| vec!["G21 G90 G17 G40 G49 G61 G93".to_owned()],
    comment: |text| format!("({text})"),
    dwell: |seconds| format!("G4 P{seconds}"),
    switch: |machine, switched, on| {
        let output = match switched {
            Switched::Knife(cutter) => machine.cutters[cutter].knife_output,
            Switched::Ultrasonic => machine.ultrasonic_output,
        };
        format!("{} P{output}", if on { "M64" } else { "M65" })
    },
    optional_stop: |_| "M1".to_owned(),
    end: "M2",
};
