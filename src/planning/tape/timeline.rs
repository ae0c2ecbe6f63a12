//! The timeline: strokes of both knives, merged along the one master coordinate, the tape advance x >= 0 that
//! never decreases (domain.md A7).
//!
//! The break points of both knives give moves in which tape and carriages are all linear. Every move starts
//! and ends at rest (exact stop), so the path is exact whatever the control does between. Where a knife goes
//! down or up, where a blade turns in place and where a cut runs square across, the tape stands still.

use std::collections::{BTreeSet, VecDeque};

use super::beam::{Beam, Conflict, Task};
use super::label::CourseLabel;
use super::machine::{Cutter, Machine};
use super::stroke::{DECIMALS, Knot, Stroke, nearest, period_deg};
use crate::planning::finding::{Code, Finding};
use crate::planning::program::moves::{Pose, Step, TapeProgram};
use crate::planning::program::number::rounded;
use crate::planning::tolerance::{BLADE_BLEND_DEG, SPOOL_SHARE};

/// The strokes of each cutter in the order in which they pass it, merged into a program.
///
/// `tolerance_mm` is the chord tolerance, of which a driven spool takes its share.
///
/// # Errors
/// `AxisLimit` for every stroke that a carriage, a blade or the tape cannot reach, `CarriagesTooClose` for every place at
/// which two carriages on one beam cannot keep their distance.
pub fn merge(
    strokes: Vec<Vec<Stroke>>,
    machine: &Machine,
    tolerance_mm: f64,
) -> Result<TapeProgram, Vec<Finding>> {
    let unreachable = unreachable(&strokes, machine);
    if !unreachable.is_empty() {
        return Err(unreachable);
    }
    let mut merge = Merge::new(strokes, machine, SPOOL_SHARE * tolerance_mm);
    merge.run();
    let too_close = merge.beam.as_ref().map(|beam| beam.findings(machine)).unwrap_or_default();
    if too_close.is_empty() { Ok(merge.program) } else { Err(too_close) }
}

/// Where two carriages on one beam would come too close to one another.
#[must_use]
pub fn conflicts(strokes: Vec<Vec<Stroke>>, machine: &Machine) -> Vec<Conflict> {
    if Beam::of(machine).is_none() {
        return Vec::new();
    }
    // How a spool bends cuts within the tolerance says nothing here.
    let mut merge = Merge::new(strokes, machine, f64::INFINITY);
    merge.run();
    merge.beam.map(|beam| beam.conflicts).unwrap_or_default()
}

fn unreachable(strokes: &[Vec<Stroke>], machine: &Machine) -> Vec<Finding> {
    let mut findings: Vec<Finding> = emptied(strokes, machine).into_iter().collect();
    let longest = machine.feed.max_length.mm();
    for (cutter, strokes) in machine.cutters.iter().zip(strokes) {
        let (min, max) = (cutter.lateral_range.0.mm(), cutter.lateral_range.1.mm());
        for stroke in strokes {
            let here = |what: String| {
                let message = format!("course {}, cutter {}: {what}", stroke.course, cutter.number);
                Finding::error(Code::AxisLimit, "/input/machine", message)
            };
            if let Some(knot) = stroke.knots.iter().find(|knot| !(min..=max).contains(&knot.v)) {
                findings.push(here(format!(
                    "the carriage travels from {min} to {max} mm and would have to be at {}",
                    knot.v
                )));
            }
            if let Some(knot) = stroke.knots.iter().find(|knot| knot.x > longest || knot.x < 0.0) {
                findings.push(here(format!(
                    "the tape axis reads 0 to {longest} mm and would have to read {}",
                    knot.x
                )));
            }
            if stroke.turn_from(0.0, cutter).is_none() {
                findings.push(here("the blade's range is too small to follow the cut".to_owned()));
            }
        }
    }
    findings
}

/// Says that the strokes need more tape than is on the spool, and which course is the first to find it empty.
fn emptied(strokes: &[Vec<Stroke>], machine: &Machine) -> Option<Finding> {
    let spool = machine.feed.spool?;
    let holds = spool.holds_mm();
    let needs = |stroke: &Stroke| stroke.knots[stroke.knots.len() - 1].x;
    let lacking = strokes.iter().flatten().filter(|stroke| needs(stroke) > holds);
    let most = lacking.clone().map(needs).reduce(f64::max)?;
    let first = lacking.min_by(|a, b| needs(a).total_cmp(&needs(b)))?;
    let message = format!(
        "the spool is empty, down to its core of {} mm, after {holds:.1} mm of tape; {most:.1} mm are needed. The first \
         course, in the order of cutting, that does not fit is {}",
        spool.core_radius_mm, first.course
    );
    Some(Finding::error(Code::AxisLimit, "/input/machine", message))
}

/// A carriage and what it does next.
struct Carriage<'a> {
    cutter: &'a Cutter,
    strokes: VecDeque<Stroke>,
    /// With the knife down: the knot at which the current segment of the first stroke begins.
    cutting: Option<usize>,
}

impl Carriage<'_> {
    /// The next knot to be reached: the start of the next stroke, or the end of the current segment.
    fn next(&self) -> Option<&Knot> {
        let stroke = self.strokes.front()?;
        match self.cutting {
            None => stroke.knots.first(),
            Some(at) => stroke.knots.get(at + 1),
        }
    }

    /// The sine of the angle between the tape and the cut that the knife makes; 0 with the knife up.
    fn sine(&self) -> f64 {
        let Some((at, stroke)) = self.cutting.zip(self.strokes.front()) else { return 0.0 };
        let Some(next) = stroke.knots.get(at + 1) else { return 0.0 };
        let (du, dv) = (next.x - stroke.knots[at].x, next.v - stroke.knots[at].v);
        if dv == 0.0 { 0.0 } else { dv.abs() / du.hypot(dv) }
    }

    fn at_stroke_end(&self) -> bool {
        let last = self.strokes.front().map(|stroke| stroke.knots.len() - 1);
        self.cutting.is_some() && self.cutting == last
    }
}

struct Merge<'a> {
    machine: &'a Machine,
    /// How far a driven spool may bend a cut, in mm.
    spool_off_mm: f64,
    carriages: Vec<Carriage<'a>>,
    beam: Option<Beam>,
    pose: Pose,
    begun: BTreeSet<CourseLabel>,
    program: TapeProgram,
}

impl<'a> Merge<'a> {
    fn new(strokes: Vec<Vec<Stroke>>, machine: &'a Machine, spool_off_mm: f64) -> Self {
        let carriages = machine
            .cutters
            .iter()
            .zip(strokes)
            .map(|(cutter, strokes)| Carriage { cutter, strokes: strokes.into(), cutting: None })
            .collect();
        Self {
            machine,
            spool_off_mm,
            carriages,
            beam: Beam::of(machine),
            pose: machine.home(),
            begun: BTreeSet::new(),
            program: TapeProgram { start: machine.home(), ..TapeProgram::default() },
        }
    }

    fn run(&mut self) {
        self.push(Step::Ultrasonic { on: true });
        loop {
            self.act_here();
            match self.next_x() {
                Some(x) => self.advance(self.step_toward(x)),
                None => break,
            }
        }
        self.push(Step::Ultrasonic { on: false });
        if self.machine.cutters.iter().any(|cutter| cutter.park.is_some()) {
            self.move_to(Pose { lateral_mm: self.machine.home().lateral_mm, ..self.pose });
        }
    }

    /// Carriages on one beam keep apart; those of `due` are on their way to where their knives go down.
    fn keep_apart(&mut self, to: &mut Pose, due: &[usize]) {
        let Some(beam) = &mut self.beam else { return };
        let task = |k: usize| {
            let carriage = &self.carriages[k];
            let bound = carriage.cutting.is_some() || due.contains(&k);
            Task { stroke: carriage.strokes.front(), bound }
        };
        beam.keep(&mut to.lateral_mm, [task(0), task(1)], (self.pose.feed_mm, to.feed_mm));
    }

    fn push(&mut self, step: Step) {
        self.program.time_s += match step {
            Step::Dwell { seconds } => seconds,
            // Where a program can be restarted it waits for knives to come up.
            Step::Course { restartable: true, .. } => self.machine.settled().s(),
            _ => 0.0,
        };
        self.program.steps.push(step);
        self.program.ends_s.push(self.program.time_s);
    }

    /// The smallest reading of the tape axis at which something is due.
    fn next_x(&self) -> Option<f64> {
        self.carriages.iter().filter_map(|carriage| carriage.next().map(|knot| knot.x)).min_by(f64::total_cmp)
    }

    /// How far to go at once on the way to x. A spool that turns evenly bends a cut, so the way of a cut is split
    /// into even parts, each short enough for that (domain.md A8).
    fn step_toward(&self, x: f64) -> f64 {
        let Some(spool) = &self.machine.feed.spool else { return x };
        let from = self.pose.feed_mm;
        // The radius at the smaller end decides; both ends are looked at.
        let sine = self.carriages.iter().map(Carriage::sine).fold(0.0, f64::max);
        let longest = [from, x].map(|x| spool.longest_step_mm(x, sine, self.spool_off_mm));
        let parts = ((x - from) / longest[0].min(longest[1])).ceil();
        if parts <= 1.0 { x } else { rounded(from + (x - from) / parts, DECIMALS) }
    }

    /// Does all that is due with the tape standing where it is.
    fn act_here(&mut self) {
        while self.lift() | self.press() | self.turn_in_place() | self.cut_across() {}
    }

    fn cutters_where(&self, due: impl Fn(&Carriage<'_>) -> bool) -> Vec<usize> {
        (0..self.carriages.len()).filter(|&k| due(&self.carriages[k])).collect()
    }

    /// Knives at the end of their strokes come up.
    fn lift(&mut self) -> bool {
        let due = self.cutters_where(|carriage| carriage.at_stroke_end());
        for &k in &due {
            self.push(Step::Knife { cutter: k, down: false });
            self.carriages[k].strokes.pop_front();
            self.carriages[k].cutting = None;
        }
        self.dwell(&due, |cutter| cutter.up_dwell.s())
    }

    /// Knives over the start of their next strokes go down, their blades turned.
    fn press(&mut self) -> bool {
        let x = self.pose.feed_mm;
        let due = self.cutters_where(|c| c.cutting.is_none() && c.next().is_some_and(|knot| knot.x == x));
        let mut to = self.pose;
        for &k in &due {
            self.begin_course(k);
            self.turn_stroke(k);
            if let Some(knot) = self.carriages[k].next() {
                (to.lateral_mm[k], to.blade_deg[k]) = (knot.v, knot.blade_deg);
            }
        }
        self.keep_apart(&mut to, &due);
        self.move_to(to);
        for &k in &due {
            self.push(Step::Knife { cutter: k, down: true });
            self.carriages[k].cutting = Some(0);
        }
        self.dwell(&due, |cutter| cutter.down_dwell.s())
    }

    fn dwell(&mut self, due: &[usize], time: impl Fn(&Cutter) -> f64) -> bool {
        let seconds = due.iter().map(|&k| time(self.carriages[k].cutter)).fold(0.0, f64::max);
        if seconds > 0.0 {
            self.push(Step::Dwell { seconds });
        }
        !due.is_empty()
    }

    /// A label where the first knife goes down for a course.
    fn begin_course(&mut self, k: usize) {
        let Some(label) = self.carriages[k].strokes.front().map(|stroke| stroke.course) else { return };
        if !self.begun.insert(label) {
            return;
        }
        let restartable = self.carriages.iter().all(|carriage| carriage.cutting.is_none());
        if restartable && self.machine.optional_stop_per_course {
            self.push(Step::OptionalStop);
        }
        self.push(Step::Course { label, restartable });
    }

    /// Turns the blade angles of the next stroke by whole periods so that the blade has the shortest way there.
    fn turn_stroke(&mut self, k: usize) {
        let carriage = &mut self.carriages[k];
        let Some(stroke) = carriage.strokes.front_mut() else { return };
        let turn = stroke.turn_from(self.pose.blade_deg[k], carriage.cutter).unwrap_or(0.0);
        for knot in &mut stroke.knots {
            knot.blade_deg = rounded(knot.blade_deg + turn, DECIMALS);
        }
    }

    /// Blades turn in the material at corners that are blunt enough; tiny turns are left to the next segment.
    fn turn_in_place(&mut self) -> bool {
        let mut to = self.pose;
        for (k, carriage) in self.carriages.iter().enumerate() {
            let Some((at, stroke)) = carriage.cutting.zip(carriage.strokes.front()) else { continue };
            if carriage.cutter.swivels() {
                // It turns on its way from knot to knot.
                continue;
            }
            let wanted = stroke.knots[at].blade_deg;
            if (wanted - self.pose.blade_deg[k]).abs() > BLADE_BLEND_DEG {
                to.blade_deg[k] = wanted;
            }
        }
        self.move_to(to)
    }

    /// Segments square across the tape are cut with the tape standing still.
    fn cut_across(&mut self) -> bool {
        let x = self.pose.feed_mm;
        let due = self.cutters_where(|c| c.cutting.is_some() && c.next().is_some_and(|knot| knot.x == x));
        let mut to = self.pose;
        for &k in &due {
            self.reach_next(k, &mut to);
        }
        self.keep_apart(&mut to, &[]);
        self.move_to(to);
        !due.is_empty()
    }

    /// Puts the carriage of a cutting knife at the end of its segment.
    fn reach_next(&mut self, k: usize, to: &mut Pose) {
        let carriage = &mut self.carriages[k];
        let Some((at, stroke)) = carriage.cutting.zip(carriage.strokes.front()) else { return };
        let blade_at = if carriage.cutter.swivels() { at + 1 } else { at };
        to.blade_deg[k] = stroke.knots[blade_at].blade_deg;
        to.lateral_mm[k] = stroke.knots[at + 1].v;
        carriage.cutting = Some(at + 1);
    }

    /// Advances the tape to x, where something is due; knives that are down follow their cuts, carriages with
    /// the knife up use the time to travel to their next stroke.
    fn advance(&mut self, x: f64) {
        let mut to = Pose { feed_mm: x, ..self.pose };
        for k in 0..self.carriages.len() {
            self.follow_cut(k, x, &mut to);
        }
        for k in 0..self.carriages.len() {
            if self.carriages[k].cutting.is_none() {
                self.travel(k, &mut to);
            }
        }
        self.keep_apart(&mut to, &[]);
        self.move_to(to);
    }

    fn follow_cut(&mut self, k: usize, x: f64, to: &mut Pose) {
        let carriage = &self.carriages[k];
        let Some((at, stroke)) = carriage.cutting.zip(carriage.strokes.front()) else { return };
        let (from, next) = (stroke.knots[at], stroke.knots[at + 1]);
        if next.x == x {
            return self.reach_next(k, to);
        }
        // Between its own knots the carriage lies on the segment itself, so that errors do not add up.
        let share = (x - from.x) / (next.x - from.x);
        let v = from.v + share * (next.v - from.v);
        to.lateral_mm[k] = rounded(v, DECIMALS);
        let turn = if carriage.cutter.swivels() { next.blade_deg - from.blade_deg } else { 0.0 };
        to.blade_deg[k] = from.blade_deg + share * turn;
    }

    /// Travels toward the next stroke as far as a move allows without lasting longer for it.
    fn travel(&self, k: usize, to: &mut Pose) {
        let carriage = &self.carriages[k];
        let pace = self.pace(&self.pose, to);
        let cutter = carriage.cutter;
        let lateral = pace.room(cutter.travel_speed.mm_s(), cutter.lateral_acceleration.mm_s2());
        if let Some(wish) = self.lateral_wish(k, to) {
            to.lateral_mm[k] = toward(self.pose.lateral_mm[k], wish, lateral);
        }
        let Some(knot) = carriage.next() else { return };
        let blade = nearest(knot.blade_deg, period_deg(cutter.edges), self.pose.blade_deg[k]);
        let (min, max) = (cutter.blade_range.0.degrees(), cutter.blade_range.1.degrees());
        let turn = pace.room(cutter.blade_speed.deg_s(), cutter.blade_acceleration.deg_s2());
        to.blade_deg[k] = toward(self.pose.blade_deg[k], blade.clamp(min, max), turn);
    }

    /// Where a carriage with its knife up goes meanwhile: to its next stroke, unless on a beam the other one is in the
    /// way there, or wants to go there first.
    fn lateral_wish(&self, k: usize, to: &Pose) -> Option<f64> {
        let next = self.carriages[k].next();
        let Some(beam) = &self.beam else { return next.map(|knot| knot.v) };
        let wish = next.map_or(beam.park_mm(k), |knot| knot.v);
        let other = &self.carriages[1 - k];
        let first = |carriage: &Carriage<'_>| carriage.next().map_or(f64::INFINITY, |knot| knot.x);
        let there = match other.next() {
            Some(knot) if other.cutting.is_none() && first(other) < first(&self.carriages[k]) => knot.v,
            _ => to.lateral_mm[1 - k],
        };
        Some(beam.wish(k, wish, there))
    }

    /// Moves all axes to a pose; says whether that was a move at all.
    fn move_to(&mut self, to: Pose) -> bool {
        // What differs beyond the printed digits only is no move.
        let to = printed(to);
        if to == self.pose {
            return false;
        }
        let mut pace = self.pace(&self.pose, &to);
        pace.cruise_s = pace.cruise_s.max(SHORTEST_MOVE_S);
        self.program.time_s += pace.rest_to_rest_s();
        self.program.steps.push(Step::Move { to, cruise_s: pace.cruise_s });
        self.program.ends_s.push(self.program.time_s);
        self.pose = to;
        true
    }

    /// The pace of a move: as fast as its slowest axis.
    fn pace(&self, from: &Pose, to: &Pose) -> Pace {
        let mut pace = Pace::default();
        let feed = &self.machine.feed;
        let du = feed.way_mm(from.feed_mm, to.feed_mm);
        pace.hold(du, feed.max_speed.mm_s(), feed.max_acceleration.mm_s2());
        for (k, carriage) in self.carriages.iter().enumerate() {
            let cutter = carriage.cutter;
            let down = carriage.cutting.is_some();
            let speed = if down { cutter.cutting_speed } else { cutter.travel_speed };
            let dv = (to.lateral_mm[k] - from.lateral_mm[k]).abs();
            pace.hold(dv, speed.mm_s(), cutter.lateral_acceleration.mm_s2());
            if down {
                pace.hold(du.hypot(dv), self.machine.max_cutting_path_speed.mm_s(), f64::INFINITY);
            }
            let turn = (to.blade_deg[k] - from.blade_deg[k]).abs();
            pace.hold(turn, cutter.blade_speed.deg_s(), cutter.blade_acceleration.deg_s2());
        }
        pace
    }
}

/// No move is shorter than this, in s: a control takes about a millisecond for a block, and the feed word of a shorter one
/// (60 / s) would be longer than other controls read.
const SHORTEST_MOVE_S: f64 = 0.001;

/// A pose as a program prints it.
fn printed(pose: Pose) -> Pose {
    Pose {
        feed_mm: rounded(pose.feed_mm, DECIMALS),
        lateral_mm: pose.lateral_mm.map(|value| rounded(value, DECIMALS)),
        blade_deg: pose.blade_deg.map(|value| rounded(value, DECIMALS)),
    }
}

/// How fast a straight move of several axes can be, all of them starting and stopping together.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Pace {
    /// Time at constant speed, in s: the slowest axis at its limit of speed.
    pub(super) cruise_s: f64,
    /// The largest distance over acceleration, in s^2: the slowest axis to start.
    pub(super) start_s2: f64,
}

impl Pace {
    /// Takes in the way of an axis with its limits of speed and acceleration.
    pub(super) fn hold(&mut self, distance: f64, speed: f64, acceleration: f64) {
        self.cruise_s = self.cruise_s.max(distance / speed);
        self.start_s2 = self.start_s2.max(distance / acceleration);
    }

    /// Duration from rest to rest in s: a trapezoid of speed, or a triangle where the move is too short for it.
    pub(super) fn rest_to_rest_s(&self) -> f64 {
        if self.cruise_s <= 0.0 {
            return 0.0;
        }
        let ramp = self.start_s2 / self.cruise_s;
        if ramp <= self.cruise_s { self.cruise_s + ramp } else { 2.0 * self.start_s2.sqrt() }
    }

    /// How far another axis can go in such a move without making it longer.
    fn room(&self, speed: f64, acceleration: f64) -> f64 {
        (self.cruise_s * speed).min(self.start_s2 * acceleration)
    }
}

fn toward(from: f64, goal: f64, room: f64) -> f64 {
    if (goal - from).abs() <= room { goal } else { rounded(from + room.copysign(goal - from), DECIMALS) }
}

/// A lower bound of the cycle in s: each axis alone at its limit of speed, with the dwells of its own knife.
#[must_use]
pub fn bound_s(strokes: &[Vec<Stroke>], machine: &Machine) -> f64 {
    let last = strokes.iter().flatten().filter_map(|stroke| stroke.knots.last()).map(|knot| knot.x);
    let feed_s = last.fold(0.0, f64::max) / machine.feed.max_speed.mm_s();
    let cutters = machine.cutters.iter().zip(strokes);
    let bounds = cutters.map(|(cutter, strokes)| {
        let dwells = strokes.len() as f64 * (cutter.down_dwell.s() + cutter.up_dwell.s());
        dwells + feed_s.max(lateral_s(strokes, cutter, machine))
    });
    bounds.fold(feed_s, f64::max)
}

/// The time that a carriage needs for its own cuts and for the travel between them.
fn lateral_s(strokes: &[Stroke], cutter: &Cutter, machine: &Machine) -> f64 {
    let path_speed = machine.max_cutting_path_speed.mm_s();
    let cuts = strokes.iter().flat_map(|stroke| stroke.knots.windows(2)).map(|pair| {
        let (du, dv) = (pair[1].x - pair[0].x, (pair[1].v - pair[0].v).abs());
        (dv / cutter.cutting_speed.mm_s()).max(du.hypot(dv) / path_speed)
    });
    let starts = strokes.iter().filter_map(|stroke| stroke.knots.first()).map(|knot| knot.v);
    let ends = strokes.iter().filter_map(|stroke| stroke.knots.last()).map(|knot| knot.v);
    let travels =
        starts.zip(std::iter::once(cutter.park_mm()).chain(ends)).map(|(start, end)| (start - end).abs());
    cuts.sum::<f64>() + travels.sum::<f64>() / cutter.travel_speed.mm_s()
}
