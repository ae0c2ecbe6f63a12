//! A program that goes on from a course: what is cut before it in the whole program counts as cut.

use std::collections::BTreeMap;

use super::label::CourseLabel;
use super::machine::Machine;
use super::offset::edge;
use super::stroke::Stroke;
use super::timeline::Pace;
use crate::planning::finding::{Code, Finding};
use crate::planning::program::moves::{Pose, Step, TapeProgram};
use crate::planning::program::nc::emit::{restore_feed, restore_s};

/// Where the option stands.
const AT: &str = "/input/options/from_course";

/// A program from a course on.
#[derive(Debug, Clone)]
pub struct Restart {
    /// The rest of the whole program, from the course on.
    pub program: TapeProgram,
    /// What the whole program cuts before it, in roll coordinates.
    pub before: Vec<Vec<[f64; 2]>>,
}

/// How many strokes of each piece a program makes, and how many there are: by course and piece, which counts from 0.
pub type Made = BTreeMap<(CourseLabel, usize), (usize, usize)>;

/// What of the strokes of a whole program a program makes that begins with the tape so far, in mm.
#[must_use]
pub fn made(strokes: &[Vec<Stroke>], start_feed_mm: f64) -> Made {
    let mut made = Made::new();
    for stroke in strokes.iter().flatten() {
        let (here, all) = made.entry((stroke.course, stroke.piece)).or_default();
        *here += usize::from(is_later(stroke, start_feed_mm));
        *all += 1;
    }
    made
}

/// Whether a stroke begins with the tape so far or later, in mm.
#[must_use]
pub fn is_later(stroke: &Stroke, start_feed_mm: f64) -> bool {
    stroke.knots[0].x >= start_feed_mm
}

/// The part of a program that begins where a course does.
///
/// # Errors
/// `NoCourseOnPly` if no such course is cut, `KnifeState` if a knife is down where it begins.
pub fn from_course(
    whole: &TapeProgram,
    course: CourseLabel,
    machine: &Machine,
    lead_mm: f64,
) -> Result<Restart, Finding> {
    let begins = |step: &Step| matches!(step, Step::Course { label, .. } if *label == course);
    let Some(index) = whole.steps.iter().position(begins) else {
        let message = format!("no cut of this roll belongs to a course {course}");
        return Err(Finding::error(Code::NoCourseOnPly, AT, message));
    };
    if matches!(whole.steps[index], Step::Course { restartable: false, .. }) {
        return Err(not_here(whole, course));
    }
    let (start, before) = done(&whole.steps[..index], whole.start, machine, lead_mm);
    if before.is_empty() {
        // What is left is all of it, from where every program begins.
        return Ok(Restart { program: whole.clone(), before });
    }
    let approach_s = tape_into_place_s(machine, &start);
    let into_place_s = machine.settled().s() + approach_s + carriages_into_place_s(machine, &start);
    let later = |end: &f64| end - whole.ends_s[index] + into_place_s;
    let program = TapeProgram {
        steps: whole.steps[index..].to_vec(),
        time_s: later(&whole.time_s),
        approach_s,
        ends_s: whole.ends_s[index..].iter().map(later).collect(),
        start,
        dry: whole.dry,
    };
    Ok(Restart { program, before })
}

fn not_here(whole: &TapeProgram, course: CourseLabel) -> Finding {
    let others = whole.steps.iter().filter_map(|step| match step {
        Step::Course { label, restartable: true } => Some(label.to_string()),
        _ => None,
    });
    let others: Vec<String> = others.collect();
    let message = format!(
        "where course {course} begins a knife is down for its neighbour; a program can go on from {}",
        others.join(", ")
    );
    Finding::error(Code::KnifeState, AT, message)
}

/// Where the axes stand after some steps, and what the knives have cut.
fn done(steps: &[Step], start: Pose, machine: &Machine, lead_mm: f64) -> (Pose, Vec<Vec<[f64; 2]>>) {
    let mut pose = start;
    let mut open: Vec<Option<Vec<Place>>> = vec![None; machine.cutters.len()];
    let mut cut = Vec::new();
    let place = |cutter: usize, pose: &Pose| {
        let station_mm = machine.cutters[cutter].station.mm();
        ([lead_mm - pose.feed_mm + station_mm, pose.lateral_mm[cutter]], pose.blade_deg[cutter])
    };
    for step in steps {
        match *step {
            Step::Move { to, .. } => {
                for (cutter, places) in open.iter_mut().enumerate() {
                    let (from, next) = (place(cutter, &pose), place(cutter, &to));
                    places.iter_mut().filter(|_| from != next).for_each(|places| places.push(next));
                }
                pose = to;
            }
            Step::Knife { cutter, down: true } => open[cutter] = Some(vec![place(cutter, &pose)]),
            Step::Knife { cutter, down: false } => {
                cut.extend(open[cutter].take().map(|places| edge(&places, &machine.cutters[cutter])));
            }
            _ => {}
        }
    }
    (pose, cut)
}

/// Where the axis of a cutter stands over the roll, (r, v) in mm, and its blade in degrees.
type Place = ([f64; 2], f64);

/// How long the tape runs from 0 into its place, from rest to rest.
fn tape_into_place_s(machine: &Machine, to: &Pose) -> f64 {
    let feed = &machine.feed;
    let way = feed.spool.as_ref().map_or(to.feed_mm, |spool| spool.angle_deg(to.feed_mm));
    let cruise_s = 60.0 * way / restore_feed(machine);
    paced(cruise_s, [(feed.way_mm(0.0, to.feed_mm), feed.max_acceleration.mm_s2())])
}

/// How long carriages and blades go into their places from where every program begins.
fn carriages_into_place_s(machine: &Machine, to: &Pose) -> f64 {
    let ways = machine.cutters.iter().enumerate().flat_map(|(k, cutter)| {
        [
            ((to.lateral_mm[k] - cutter.park_mm()).abs(), cutter.lateral_acceleration.mm_s2()),
            (to.blade_deg[k].abs(), cutter.blade_acceleration.deg_s2()),
        ]
    });
    if machine.home() == (Pose { feed_mm: 0.0, ..*to }) { 0.0 } else { paced(restore_s(machine), ways) }
}

/// A move of a given time at cruising speed, its slowest axis coming up to speed and down again.
fn paced(cruise_s: f64, ways: impl IntoIterator<Item = (f64, f64)>) -> f64 {
    let mut pace = Pace { cruise_s, ..Pace::default() };
    ways.into_iter().for_each(|(way, acceleration)| pace.hold(way, f64::INFINITY, acceleration));
    pace.rest_to_rest_s()
}
