//! Travel and speed of each axis over a move.

use std::fmt::Display;

use super::faults::Faults;
use super::reel::Reel;
use crate::planning::finding::Code;
use crate::planning::program::events::{AXIS_LETTERS, Positions};
use crate::planning::tape::machine::{Cutter, Machine};

/// What a printed length may be off, in mm: half of the fourth decimal.
pub(super) const PRINTED_MM: f64 = 0.000_05;

/// What a printed angle may be off, in degrees: half of the third decimal.
pub(super) const PRINTED_DEG: f64 = 0.000_5;

/// What a printed F may be off, in 1/min: half of the fourth decimal.
const PRINTED_FEED: f64 = 0.000_05;

/// The rounding of F may lengthen a move by no more than this part of it, however slow the move is.
const MOST_FEED_ROUNDING: f64 = 0.001;

/// A move of a program.
pub(super) struct Moved {
    /// Where all axes were.
    pub(super) from: Positions,
    /// Where they go.
    pub(super) to: Positions,
    /// How long it takes at cruising speed in s; none for a rapid.
    pub(super) cruise_s: Option<f64>,
    /// Line of the program.
    pub(super) line: usize,
}

impl Moved {
    /// Where all axes are after a share of the move.
    pub(super) fn at(&self, share: f64) -> Positions {
        std::array::from_fn(|axis| self.from[axis] + share * self.delta(axis))
    }

    fn delta(&self, axis: usize) -> f64 {
        self.to[axis] - self.from[axis]
    }
}

/// The axes of a machine as places in [`Positions`].
pub(super) struct Axes<'a> {
    machine: &'a Machine,
    feed: usize,
    /// What the tape axis turns, if it does not read the tape itself.
    reel: Option<Reel>,
    lateral: Vec<usize>,
    blade: Vec<usize>,
}

impl<'a> Axes<'a> {
    /// The axes of a machine.
    pub(super) fn of(machine: &'a Machine) -> Self {
        let places = |letter: fn(&Cutter) -> char| machine.cutters.iter().map(letter).map(place).collect();
        Self {
            machine,
            feed: place(machine.feed.axis),
            reel: machine.feed.spool.as_ref().map(Reel::of),
            lateral: places(|cutter| cutter.lateral_axis),
            blade: places(|cutter| cutter.blade_axis),
        }
    }

    /// Where the tape stands, in mm.
    pub(super) fn feed_mm(&self, positions: &Positions) -> f64 {
        self.reel.map_or(positions[self.feed], |reel| reel.tape_mm(positions[self.feed]))
    }

    /// How far the tape is fed, in mm.
    pub(super) fn feed_delta(&self, moved: &Moved) -> f64 {
        self.feed_mm(&moved.to) - self.feed_mm(&moved.from)
    }

    /// The way in mm that the tape would go at the largest speed that it has in a move: what its limits are held to.
    fn feed_way(&self, moved: &Moved) -> f64 {
        let (from, to) = (moved.from[self.feed], moved.to[self.feed]);
        self.reel.map_or((to - from).abs(), |reel| reel.fastest_mm(from, to))
    }

    /// In how many parts a move is looked at: a spool that turns evenly bends the cut of a knife.
    pub(super) fn parts(&self, moved: &Moved) -> usize {
        let (from, to) = (moved.from[self.feed], moved.to[self.feed]);
        self.reel.map_or(1, |reel| reel.parts(from, to))
    }

    /// How far a carriage moves, in mm.
    pub(super) fn lateral_delta(&self, cutter: usize, moved: &Moved) -> f64 {
        moved.delta(self.lateral[cutter])
    }

    /// Where a carriage stands, in mm.
    pub(super) fn lateral_at(&self, cutter: usize, positions: &Positions) -> f64 {
        positions[self.lateral[cutter]]
    }

    /// Where all axes are when a program begins: at 0, the carriages where they are parked.
    pub(super) fn home(&self) -> Positions {
        let mut home = [0.0; 9];
        for (axis, cutter) in self.lateral.iter().zip(&self.machine.cutters) {
            home[*axis] = cutter.park_mm();
        }
        home
    }

    /// Where a blade points before and after a move, in degrees.
    pub(super) fn blade(&self, cutter: usize, moved: &Moved) -> [f64; 2] {
        let axis = self.blade[cutter];
        [moved.from[axis], moved.to[axis]]
    }

    /// Where a blade points, in degrees.
    pub(super) fn blade_at(&self, cutter: usize, positions: &Positions) -> f64 {
        positions[self.blade[cutter]]
    }

    /// The point (r, v) of the roll over which a cutter stands: r = lead - U + station (jobs.md, `roll`).
    pub(super) fn knife_at(&self, cutter: usize, positions: &Positions, lead_mm: f64) -> [f64; 2] {
        let station_mm = self.machine.cutters[cutter].station.mm();
        [lead_mm - self.feed_mm(positions) + station_mm, positions[self.lateral[cutter]]]
    }
}

/// A machine's letters are checked when its profile is read.
fn place(letter: char) -> usize {
    AXIS_LETTERS.iter().position(|axis| *axis == letter).expect("a profile names axes by one of nine letters")
}

/// Checks a move against everything that does not depend on blades: direction of the tape, travel, speed.
/// `down` says of each knife whether it is down.
pub(super) fn check(axes: &Axes<'_>, moved: &Moved, down: &[bool], faults: &mut Faults<'_>) {
    let back_mm = -axes.feed_delta(moved);
    if back_mm > 0.0 {
        faults.at_line(Code::TapeReversal, moved.line, || format!("the tape runs back by {back_mm:.6} mm"));
    }
    check_travel(axes, moved, faults);
    match moved.cruise_s {
        Some(cruise_s) => check_speeds(axes, moved, longest_s(cruise_s), down, faults),
        None if down.contains(&true) => {
            faults.at_line(Code::KnifeState, moved.line, || "a rapid while a knife is down".to_owned());
        }
        None => faults.at_line(Code::SpeedExceeded, moved.line, || {
            "a rapid runs as fast as the control's own settings say, which a replay cannot prove".to_owned()
        }),
    }
}

fn check_travel(axes: &Axes<'_>, moved: &Moved, faults: &mut Faults<'_>) {
    let machine = axes.machine;
    let mut known = vec![axes.feed];
    check_feed(axes, moved, faults);
    for (index, cutter) in machine.cutters.iter().enumerate() {
        let (low, high) = cutter.lateral_range;
        check_range(moved, axes.lateral[index], (low.mm(), high.mm()), PRINTED_MM, faults);
        let (low, high) = cutter.blade_range;
        check_range(moved, axes.blade[index], (low.degrees(), high.degrees()), PRINTED_DEG, faults);
        known.extend([axes.lateral[index], axes.blade[index]]);
    }
    for axis in (0..AXIS_LETTERS.len()).filter(|axis| !known.contains(axis) && moved.delta(*axis) != 0.0) {
        faults.at_line(Code::TravelExceeded, moved.line, || {
            format!("{} has no axis {}", machine.name, AXIS_LETTERS[axis])
        });
    }
}

/// The tape runs within its length, and a spool is not turned beyond its core.
fn check_feed(axes: &Axes<'_>, moved: &Moved, faults: &mut Faults<'_>) {
    let feed = &axes.machine.feed;
    let to = axes.feed_mm(&moved.to);
    let longest = feed.max_length.mm();
    let moves = moved.delta(axes.feed) != 0.0;
    if moves && !(-PRINTED_MM..=longest + PRINTED_MM).contains(&to) {
        faults.at_line(Code::TravelExceeded, moved.line, || {
            format!("{} goes to {to} mm of tape, outside 0 to {longest}", feed.axis)
        });
    }
    if let Some(reel) = axes.reel.filter(|reel| moves && !reel.has_tape(moved.to[axes.feed])) {
        faults.at_line(Code::TravelExceeded, moved.line, || {
            format!("{} turns the spool beyond its core of {} mm", feed.axis, reel.core_mm)
        });
    }
}

/// Moves are straight: an axis that is within its range at both ends is within it all along.
fn check_range(moved: &Moved, axis: usize, (low, high): (f64, f64), slack: f64, faults: &mut Faults<'_>) {
    let to = moved.to[axis];
    if moved.delta(axis) != 0.0 && !(low - slack..=high + slack).contains(&to) {
        faults.at_line(Code::TravelExceeded, moved.line, || {
            format!("{} goes to {to}, outside {low} to {high}", AXIS_LETTERS[axis])
        });
    }
}

/// How long a move lasts in s from rest to rest: it cruises as programmed, and its slowest axis needs the time to
/// come up to that and down again. A move too short for it has no cruise: half of it speeds up, half slows down.
pub(super) fn rest_to_rest_s(axes: &Axes<'_>, moved: &Moved) -> f64 {
    let Some(cruise_s) = moved.cruise_s else { return 0.0 };
    let machine = axes.machine;
    let ratios = machine.cutters.iter().enumerate().flat_map(|(index, cutter)| {
        let [from, to] = axes.blade(index, moved);
        [
            axes.lateral_delta(index, moved).abs() / cutter.lateral_acceleration.mm_s2(),
            (to - from).abs() / cutter.blade_acceleration.deg_s2(),
        ]
    });
    let feed = axes.feed_way(moved) / machine.feed.max_acceleration.mm_s2();
    let squared = ratios.fold(feed, f64::max);
    if squared > cruise_s * cruise_s { 2.0 * squared.sqrt() } else { cruise_s + squared / cruise_s }
}

/// The longest time in s that prints as the F of this one.
fn longest_s(cruise_s: f64) -> f64 {
    let per_minute = 60.0 / cruise_s;
    let rounding = (PRINTED_FEED / per_minute).min(MOST_FEED_ROUNDING);
    cruise_s / (1.0 - rounding)
}

fn check_speeds(axes: &Axes<'_>, moved: &Moved, seconds: f64, down: &[bool], faults: &mut Faults<'_>) {
    let machine = axes.machine;
    let mut check = |what: &dyn Display, distance: f64, limit: f64, rounding: f64| {
        // Both ends of a move are rounded. A time that is not a number keeps no limit.
        if distance <= limit * seconds + 2.0 * rounding {
            return;
        }
        let speed = distance / seconds;
        let message = || format!("{what} runs at {speed:.4}/s, its limit is {limit}/s (mm or degrees)");
        faults.at_line(Code::SpeedExceeded, moved.line, message);
    };
    let feed_mm = axes.feed_way(moved);
    check(&machine.feed.axis, feed_mm, machine.feed.max_speed.mm_s(), PRINTED_MM);
    for (index, cutter) in machine.cutters.iter().enumerate() {
        let lateral_mm = axes.lateral_delta(index, moved).abs();
        let limit = if down[index] { cutter.cutting_speed } else { cutter.travel_speed };
        check(&cutter.lateral_axis, lateral_mm, limit.mm_s(), PRINTED_MM);
        let [from, to] = axes.blade(index, moved);
        check(&cutter.blade_axis, (to - from).abs(), cutter.blade_speed.deg_s(), PRINTED_DEG);
        if down[index] {
            let path_mm = feed_mm.hypot(lateral_mm);
            let limit = machine.max_cutting_path_speed.mm_s();
            let rounding = PRINTED_MM * std::f64::consts::SQRT_2;
            check(&format_args!("knife {} in the tape", cutter.number), path_mm, limit, rounding);
        }
    }
}
