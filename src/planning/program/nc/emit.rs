//! Tape programs as text, in the language of a machine's control.
//!
//! Inverse-time feed (G93), because F on mixed axes is neither knife's speed.
//! Nothing in the text comes from a person: only numbers, and the hash of the input.

use super::dialect::{Language, Switched, language};
use crate::planning::outcome::PLANNER_VERSION;
use crate::planning::program::moves::{Pose, Step, TapeProgram};
use crate::planning::program::number::{fixed, rounded};
use crate::planning::tape::label::CourseLabel;
use crate::planning::tape::machine::{Feed, Machine};
use crate::planning::tape::stroke::DECIMALS;

/// Decimals of the feed word.
const FEED_DECIMALS: usize = 4;

/// Decimals of the degrees of a spool: at a radius of 500 mm the last one is a tenth of a micron, as of [`DECIMALS`].
const SPOOL_DECIMALS: usize = 5;

/// At a restart every axis is brought into place at this share of its speed at most: a person stands beside it.
pub const RESTORE_SHARE: f64 = 0.2;

/// Writes a program.
///
/// `input_sha256` is in lower-case hex. Lines end with LF.
#[must_use]
pub fn emit(program: &TapeProgram, machine: &Machine, input_sha256: &str) -> String {
    let mut writer = Writer {
        machine,
        language: language(machine.dialect),
        text: String::new(),
        pose: program.start,
        dry: program.dry,
        number: 0,
    };
    writer.header(input_sha256);
    for step in &program.steps {
        writer.step(step);
    }
    writer.block(writer.language.end);
    writer.text
}

struct Writer<'a> {
    machine: &'a Machine,
    language: &'static Language,
    text: String,
    pose: Pose,
    /// Whether nothing is switched on.
    dry: bool,
    number: u32,
}

impl Writer<'_> {
    fn header(&mut self, input_sha256: &str) {
        self.comment(&format!("BLADEPLAN {PLANNER_VERSION} TAPE CUT"));
        self.comment(&format!("INPUT {}", input_sha256.to_ascii_uppercase()));
        let home = self.machine.home();
        if self.pose == home {
            let axes = if home == Pose::default() {
                "ALL AXES AT ZERO"
            } else {
                "CARRIAGES PARKED, OTHER AXES AT ZERO"
            };
            self.comment(&format!("{axes}, LEADING END OF THE TAPE UNDER CUTTER 1, KNIVES UP"));
        } else {
            self.comment("GOES ON WITHIN A ROLL, AXES READ AS IN THE WHOLE PROGRAM, KNIVES UP");
        }
        if self.dry {
            self.comment("DRY RUN, KNIVES STAY UP, ULTRASONIC STAYS OFF");
        }
        self.modes();
        if self.pose == home && home != Pose::default() {
            // Carriages that are parked there already do not move; a reader knows by it where they stand.
            self.carriages_into_place();
        }
    }

    /// What every place needs from which the program may be started.
    fn modes(&mut self) {
        for block in (self.language.modes)(self.machine) {
            self.block(&block);
        }
    }

    fn step(&mut self, step: &Step) {
        match *step {
            Step::Move { to, cruise_s } => self.move_to(&to, cruise_s),
            Step::Knife { cutter, down } => self.switch(Switched::Knife(cutter), down),
            Step::Ultrasonic { on } => self.switch(Switched::Ultrasonic, on),
            Step::Dwell { seconds } => self.dwell(seconds),
            Step::Course { label, restartable } => self.course(label, restartable),
            Step::OptionalStop => self.block(&(self.language.optional_stop)(self.machine)),
        }
    }

    fn course(&mut self, label: CourseLabel, restartable: bool) {
        let course = format!("COURSE {label}").to_ascii_uppercase();
        if !restartable {
            return self.comment(&format!("{course}, A KNIFE IS DOWN, NO RESTART HERE"));
        }
        self.comment(&format!("{course}, RESTART HERE"));
        self.modes();
        self.restore();
    }

    /// Brings the machine from wherever it stands to where the program is: knives up, ultrasonic on, every axis in
    /// its place. In a run from the start nothing of this moves or switches anything.
    fn restore(&mut self) {
        let machine = self.machine;
        for cutter in 0..machine.cutters.len() {
            self.switch(Switched::Knife(cutter), false);
        }
        self.dwell(machine.settled().s());
        self.feed_into_place();
        self.switch(Switched::Ultrasonic, true);
        self.carriages_into_place();
    }

    /// The tape runs by itself at a speed of its own (G94): nobody knows how far it has to come, and where it stands
    /// in its place already that takes no time.
    fn feed_into_place(&mut self) {
        self.block("G94");
        let (word, speed) =
            (feed_axis_word(&self.machine.feed, self.pose.feed_mm), restore_feed(self.machine));
        self.block(&format!("G1 {word} F{}", fixed(speed, FEED_DECIMALS)));
        self.block("G93");
    }

    /// Carriages and blades go together, in the time that each of them needs for its whole travel at most.
    fn carriages_into_place(&mut self) {
        let cutters = self.machine.cutters.iter();
        let lateral = cutters.clone().zip(self.pose.lateral_mm).map(|(cutter, v)| (cutter.lateral_axis, v));
        let blades = cutters.zip(self.pose.blade_deg).map(|(cutter, angle)| (cutter.blade_axis, angle));
        let words =
            lateral.chain(blades).map(|(letter, value)| format!(" {letter}{}", fixed(value, DECIMALS)));
        let words: String = words.collect();
        self.block(&format!("G1{words} F{}", feed_word(restore_s(self.machine))));
    }

    fn switch(&mut self, switched: Switched, on: bool) {
        if !(on && self.dry) {
            self.block(&(self.language.switch)(self.machine, switched, on));
        }
    }

    fn dwell(&mut self, seconds: f64) {
        self.block(&(self.language.dwell)(&fixed(seconds, DECIMALS)));
    }

    fn move_to(&mut self, to: &Pose, cruise_s: f64) {
        let mut words = String::from("G1");
        if to.feed_mm != self.pose.feed_mm {
            words.push_str(&format!(" {}", feed_axis_word(&self.machine.feed, to.feed_mm)));
        }
        let mut word = |letter: char, value: f64, before: f64| {
            if value != before {
                words.push_str(&format!(" {letter}{}", fixed(value, DECIMALS)));
            }
        };
        for (k, cutter) in self.machine.cutters.iter().enumerate() {
            word(cutter.lateral_axis, to.lateral_mm[k], self.pose.lateral_mm[k]);
        }
        for (k, cutter) in self.machine.cutters.iter().enumerate() {
            word(cutter.blade_axis, to.blade_deg[k], self.pose.blade_deg[k]);
        }
        words.push_str(&format!(" F{}", feed_word(cruise_s)));
        self.block(&words);
        self.pose = *to;
    }

    fn block(&mut self, words: &str) {
        self.number += 10;
        self.text.push_str(&format!("N{} {words}\n", self.number));
    }

    fn comment(&mut self, text: &str) {
        self.text.push_str(&(self.language.comment)(text));
        self.text.push('\n');
    }
}

/// How long carriages and blades take into place at a restart, in s, wherever they stand.
#[must_use]
pub fn restore_s(machine: &Machine) -> f64 {
    let ways = machine.cutters.iter().flat_map(|cutter| {
        let (low, high) = (cutter.lateral_range.0.mm(), cutter.lateral_range.1.mm());
        let (min, max) = (cutter.blade_range.0.degrees(), cutter.blade_range.1.degrees());
        [(high - low) / cutter.travel_speed.mm_s(), (max - min) / cutter.blade_speed.deg_s()]
    });
    ways.fold(0.0, f64::max) / RESTORE_SHARE
}

/// The speed of the tape axis into place at a restart, in mm or degrees a minute, in printed digits: that of a spool is
/// reckoned at the largest radius that it has anywhere in a program.
#[must_use]
pub fn restore_feed(machine: &Machine) -> f64 {
    let feed = &machine.feed;
    let speed = RESTORE_SHARE * feed.max_speed.mm_s() * 60.0;
    let least = 10_f64.powi(-(FEED_DECIMALS as i32));
    let printed = |speed: f64| rounded(speed, FEED_DECIMALS).max(least);
    match &feed.spool {
        None => printed(speed),
        Some(spool) => printed((speed / spool.largest_radius_mm(0.0, feed.max_length.mm())).to_degrees()),
    }
}

/// The tape axis at a reading in mm: in mm, or in degrees of the spool that it turns.
fn feed_axis_word(feed: &Feed, x: f64) -> String {
    let number = match &feed.spool {
        None => fixed(x, DECIMALS),
        Some(spool) => fixed(spool.angle_deg(x), SPOOL_DECIMALS),
    };
    format!("{}{number}", feed.axis)
}

/// F = 60 / cruising time, rounded down: a limit of speed holds for the printed digits too.
fn feed_word(cruise_s: f64) -> String {
    let scale = 10_f64.powi(FEED_DECIMALS as i32);
    fixed((60.0 / cruise_s * scale).floor() / scale, FEED_DECIMALS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_feed_word_never_asks_for_more_speed() {
        for cruise_s in [1e-4, 0.006, 0.123_456_7, 1.0, 33.3, 4000.0] {
            let feed: f64 = feed_word(cruise_s).parse().unwrap();
            assert!(60.0 / feed >= cruise_s && 60.0 / feed < cruise_s * 1.01, "{cruise_s} gives {feed}");
        }
    }
}
