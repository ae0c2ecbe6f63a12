//! Sinumerik in its own language (G290). What of it is known at second hand only stands in docs/tape-machine.md.
//!
//! G710 makes feeds metric as well as lengths; G500 and D0 let positions count from the machine's zero; G60 stops
//! exactly after each block. FGROUP holds every axis, so that no block is without a path for G93 to time. Knives are
//! switched by words of the machine's builder, each in a block of its own, after which the program dwells.

use super::{Language, Switched};
use crate::planning::tape::machine::Machine;
use crate::planning::tape::words::Words;

pub(super) const SINUMERIK: Language = Language {
    name: "sinumerik",
    ending: "mpf",
    modes: |machine| vec!["G710 G90 G17 G40 G500 D0 G60".to_owned(), group(machine), "G93".to_owned()],
    comment: |text| format!("; {text}"),
    dwell: |seconds| format!("G4 F{seconds}"),
    switch: |machine, switched, on| {
        let words = words(machine);
        let [first, second] = match switched {
            Switched::Knife(cutter) => &words.knives[cutter],
            Switched::Ultrasonic => &words.ultrasonic,
        };
        if on { first.clone() } else { second.clone() }
    },
    optional_stop: |machine| words(machine).optional_stop.clone(),
    end: "M30",
};

fn words(machine: &Machine) -> &Words {
    machine.words.as_ref().expect("a profile of this dialect is refused without its words")
}

fn group(machine: &Machine) -> String {
    let lateral = machine.cutters.iter().map(|cutter| cutter.lateral_axis);
    let blades = machine.cutters.iter().map(|cutter| cutter.blade_axis);
    let letters: Vec<String> =
        std::iter::once(machine.feed.axis).chain(lateral).chain(blades).map(String::from).collect();
    format!("FGROUP({})", letters.join(","))
}
