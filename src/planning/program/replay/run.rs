//! The machine as the events of a program drive it: axes, knives, generator, dwells.

use super::beam;
use super::blade::{self, Corner, Cut};
use super::faults::Faults;
use super::strokes::Stroke;
use super::trail::{self, Trail};
use super::travel::{self, Axes, Moved};
use super::{Executed, ReplaySetup};
use crate::planning::finding::Code;
use crate::planning::program::events::{Event, Positions};
use crate::planning::tape::machine::Cutter;
use crate::planning::tolerance::REPLAY_SLACK_MM;

/// What a dwell may lack, in s, because it is printed with four decimals.
const DWELL_ROUNDING_S: f64 = 0.000_05;

/// What a run leaves behind.
pub(super) struct Run {
    /// All cuts, in the order in which they begin.
    pub(super) strokes: Vec<Stroke>,
    /// How often the tape ran backwards.
    pub(super) tape_reversals: u32,
    /// How long it took, in s.
    pub(super) time_s: f64,
}

/// Runs all events up to the end of the program.
pub(super) fn run(setup: &ReplaySetup<'_>, events: &[Executed], faults: &mut Faults<'_>) -> Run {
    let mut platform = Platform::new(setup, faults);
    for executed in events {
        platform.execute(executed);
        if platform.ended {
            break;
        }
    }
    platform.finish(events.last().map_or(1, |last| last.line))
}

/// A knife and what is known about it.
struct Knife {
    down: bool,
    /// Time in s that everything has stood since it was last switched; infinite once that no longer matters.
    settled_s: f64,
    /// The cut that it makes, while it is down.
    stroke: Option<Stroke>,
    /// The way of its axis while it is down, if its edge lies beside that.
    trail: Option<Trail>,
    /// Where the blade is in its corner.
    corner: Corner,
    /// Whether this stroke was said to leave the tape.
    said_beside: bool,
}

struct Platform<'a, 'b> {
    setup: &'a ReplaySetup<'a>,
    faults: &'a mut Faults<'b>,
    axes: Axes<'a>,
    knives: Vec<Knife>,
    positions: Positions,
    ultrasonic: bool,
    ended: bool,
    strokes: Vec<Stroke>,
    tape_reversals: u32,
    time_s: f64,
}

impl<'a, 'b> Platform<'a, 'b> {
    fn new(setup: &'a ReplaySetup<'a>, faults: &'a mut Faults<'b>) -> Self {
        let knife = |_: &Cutter| Knife {
            down: false,
            settled_s: f64::INFINITY,
            stroke: None,
            trail: None,
            corner: Corner::default(),
            said_beside: false,
        };
        let axes = Axes::of(setup.machine);
        Self {
            setup,
            faults,
            positions: axes.home(),
            axes,
            knives: setup.machine.cutters.iter().map(knife).collect(),
            ultrasonic: false,
            ended: false,
            strokes: Vec::new(),
            tape_reversals: 0,
            time_s: 0.0,
        }
    }

    fn execute(&mut self, executed: &Executed) {
        let line = executed.line;
        match executed.event {
            Event::Move { from, to, cruise_s } => self.go(Moved { from, to, cruise_s, line }),
            Event::Output { number, on } => self.switch(number, on, line),
            Event::Dwell { seconds } => {
                self.time_s += seconds.max(0.0);
                self.knives.iter_mut().for_each(|knife| knife.settled_s += seconds.max(0.0));
            }
            Event::OptionalStop => self.stop(line),
            Event::End => {
                self.ended = true;
                self.check_end(line);
            }
        }
    }

    fn go(&mut self, moved: Moved) {
        if moved.from == moved.to {
            return;
        }
        self.positions = moved.to;
        self.time_s += travel::rest_to_rest_s(&self.axes, &moved);
        self.check_settled(moved.line);
        let down: Vec<bool> = self.knives.iter().map(|knife| knife.down).collect();
        if self.axes.feed_delta(&moved) < 0.0 {
            self.tape_reversals += 1;
        }
        travel::check(&self.axes, &moved, &down, self.faults);
        beam::check(self.setup.machine, &self.axes, &moved, self.faults);
        for (index, _) in down.iter().enumerate().filter(|(_, down)| **down) {
            self.cut(index, &moved);
        }
    }

    /// A press needs its time before anything moves (jobs.md: `down_dwell_s`, `up_dwell_s`).
    fn check_settled(&mut self, line: usize) {
        for (knife, cutter) in self.knives.iter_mut().zip(&self.setup.machine.cutters) {
            let (needed, way) =
                if knife.down { (cutter.down_dwell.s(), "down") } else { (cutter.up_dwell.s(), "up") };
            let settled_s = std::mem::replace(&mut knife.settled_s, f64::INFINITY);
            if settled_s + DWELL_ROUNDING_S < needed {
                self.faults.at_line(Code::KnifeState, line, || {
                    let number = cutter.number;
                    format!("moves {settled_s} s after knife {number} went {way}, which takes {needed} s")
                });
            }
        }
    }

    /// The axis of a knife that is down goes on; where its edge went is seen when it comes up.
    fn follow(&mut self, index: usize, moved: &Moved) {
        let cutter = &self.setup.machine.cutters[index];
        let [from, to] = self.axes.blade(index, moved);
        let parts = self.axes.parts(moved).max(trail::parts(cutter, to - from));
        let Some(trail) = &mut self.knives[index].trail else { return };
        for part in 1..=parts {
            let share = part as f64 / parts as f64;
            let positions = if part == parts { moved.to } else { moved.at(share) };
            let at = self.axes.knife_at(index, &positions, self.setup.lead_mm);
            trail.go(at, from + share * (to - from), moved.line, part == parts);
        }
    }

    /// The cut of an edge beside its axis, when its knife comes up.
    fn end_trail(&mut self, index: usize) {
        let Some(trail) = self.knives[index].trail.take() else { return };
        let cutter = &self.setup.machine.cutters[index];
        let stroke = trail.finish(cutter, self.faults);
        let beside = stroke.points.iter().skip(1).zip(&stroke.lines).find(|(at, _)| self.is_beside(at[1]));
        if let Some((at, line)) = beside {
            self.faults.at_line(Code::Unwanted, *line, || beside_the_tape(cutter, at[1]));
        }
        self.knives[index].stroke = Some(stroke);
    }

    fn is_beside(&self, v: f64) -> bool {
        let setup = self.setup;
        v.abs() > setup.tape_width_mm / 2.0 + setup.overcut_mm + setup.tolerance_mm + REPLAY_SLACK_MM
    }

    fn cut(&mut self, index: usize, moved: &Moved) {
        let cutter = &self.setup.machine.cutters[index];
        if cutter.swivels() {
            return self.follow(index, moved);
        }
        let to = self.axes.knife_at(index, &moved.to, self.setup.lead_mm);
        let cut = Cut::of(&self.axes, index, moved);
        let knife = &mut self.knives[index];
        blade::check(cutter, &cut, &mut knife.corner, self.faults);
        if !cut.advances() {
            return;
        }
        if let Some(stroke) = &mut knife.stroke {
            let parts = self.axes.parts(moved);
            for part in 1..parts {
                let between = moved.at(part as f64 / parts as f64);
                stroke.cut_to(self.axes.knife_at(index, &between, self.setup.lead_mm), moved.line);
            }
            stroke.cut_to(to, moved.line);
        }
        if !knife.said_beside && self.is_beside(to[1]) {
            self.knives[index].said_beside = true;
            self.faults.at_line(Code::Unwanted, moved.line, || beside_the_tape(cutter, to[1]));
        }
    }

    fn switch(&mut self, number: u32, on: bool, line: usize) {
        let machine = self.setup.machine;
        if number == machine.ultrasonic_output {
            return self.switch_ultrasonic(on, line);
        }
        match machine.cutters.iter().position(|cutter| cutter.knife_output == number) {
            Some(index) if self.knives[index].down == on => {}
            Some(index) if on => self.lower(index, line),
            Some(index) => self.raise(index, line),
            None => self
                .faults
                .at_line(Code::KnifeState, line, || format!("{} has no output {number}", machine.name)),
        }
    }

    fn switch_ultrasonic(&mut self, on: bool, line: usize) {
        self.ultrasonic = on;
        if !on && self.knives.iter().any(|knife| knife.down) {
            self.faults.at_line(Code::KnifeState, line, || {
                "the generator goes off while a knife is down".to_owned()
            });
        }
    }

    fn lower(&mut self, index: usize, line: usize) {
        if !self.ultrasonic {
            let number = self.setup.machine.cutters[index].number;
            self.faults.at_line(Code::KnifeState, line, || {
                format!("knife {number} goes down while the generator is off")
            });
        }
        let at = self.axes.knife_at(index, &self.positions, self.setup.lead_mm);
        let cutter = &self.setup.machine.cutters[index];
        let trail = || Trail::at(at, self.axes.blade_at(index, &self.positions));
        self.knives[index] = Knife {
            down: true,
            settled_s: 0.0,
            stroke: Some(Stroke::at(at)),
            trail: cutter.swivels().then(trail),
            corner: Corner::default(),
            said_beside: false,
        };
    }

    fn raise(&mut self, index: usize, line: usize) {
        self.end_trail(index);
        let knife = &mut self.knives[index];
        knife.down = false;
        knife.settled_s = 0.0;
        let Some(stroke) = knife.stroke.take() else { return };
        if stroke.is_empty() {
            let number = self.setup.machine.cutters[index].number;
            self.faults.at_line(Code::KnifeState, line, || {
                format!("knife {number} goes up without having cut since it went down")
            });
            return;
        }
        self.strokes.push(stroke);
    }

    /// An operator may stop here for long, and a knife at rest in the tape would burn through the backing.
    fn stop(&mut self, line: usize) {
        if self.knives.iter().any(|knife| knife.down) {
            self.faults
                .at_line(Code::KnifeState, line, || "the program may stop here with a knife down".to_owned());
        }
    }

    fn check_end(&mut self, line: usize) {
        for (knife, cutter) in self.knives.iter().zip(&self.setup.machine.cutters) {
            if knife.down {
                let number = cutter.number;
                self.faults.at_line(Code::KnifeState, line, || format!("knife {number} is left down"));
            }
        }
        if self.ultrasonic {
            self.faults.at_line(Code::KnifeState, line, || "the generator is left on".to_owned());
        }
    }

    fn finish(mut self, line: usize) -> Run {
        if !self.ended {
            self.faults.at_line(Code::NoProgramEnd, line, || "the program does not end".to_owned());
            self.check_end(line);
        }
        (0..self.knives.len()).for_each(|index| self.end_trail(index));
        let open = self.knives.iter_mut().filter_map(|knife| knife.stroke.take());
        self.strokes.extend(open.filter(|stroke| !stroke.is_empty()));
        Run { strokes: self.strokes, tape_reversals: self.tape_reversals, time_s: self.time_s }
    }
}

fn beside_the_tape(cutter: &Cutter, v: f64) -> String {
    format!("knife {} is down at v = {v} mm, beside the tape", cutter.number)
}
