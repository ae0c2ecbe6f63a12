//! A program that goes on from a course: what is cut before it in the whole program counts as cut.

use super::machine::Machine;
use crate::planning::finding::{Code, Finding};
use crate::planning::program::moves::{Pose, Step, TapeProgram};
use crate::planning::program::nc::emit::restore_s;

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

/// The part of a program that begins where a course does.
///
/// # Errors
/// `NoCourseOnPly` if no such course is cut, `KnifeState` if a knife is down where it begins.
pub fn from_course(
    whole: &TapeProgram,
    number: u32,
    machine: &Machine,
    lead_mm: f64,
) -> Result<Restart, Finding> {
    let begins = |step: &Step| matches!(step, Step::Course { number: found, .. } if *found == number);
    let Some(index) = whole.steps.iter().position(begins) else {
        let message = format!("no cut of this roll belongs to a course {number}");
        return Err(Finding::error(Code::NoCourseOnPly, AT, message));
    };
    if matches!(whole.steps[index], Step::Course { restartable: false, .. }) {
        return Err(not_here(whole, number));
    }
    let (start, before) = done(&whole.steps[..index], machine, lead_mm);
    if before.is_empty() {
        // What is left is all of it, from the all-zero pose on.
        return Ok(Restart { program: whole.clone(), before });
    }
    let into_place_s = machine.settled().s() + rest_to_rest_s(machine, &start);
    let later = |end: &f64| end - whole.ends_s[index] + into_place_s;
    let program = TapeProgram {
        steps: whole.steps[index..].to_vec(),
        time_s: later(&whole.time_s),
        ends_s: whole.ends_s[index..].iter().map(later).collect(),
        start,
        dry: whole.dry,
    };
    Ok(Restart { program, before })
}

fn not_here(whole: &TapeProgram, number: u32) -> Finding {
    let others = whole.steps.iter().filter_map(|step| match step {
        Step::Course { number, restartable: true } => Some(number.to_string()),
        _ => None,
    });
    let others: Vec<String> = others.collect();
    let message = format!(
        "where course {number} begins a knife is down for its neighbour; a program can go on from {}",
        others.join(", ")
    );
    Finding::error(Code::KnifeState, AT, message)
}

/// Where the axes stand after some steps, and what the knives have cut.
fn done(steps: &[Step], machine: &Machine, lead_mm: f64) -> (Pose, Vec<Vec<[f64; 2]>>) {
    let mut pose = Pose::default();
    let mut open: Vec<Option<Vec<[f64; 2]>>> = vec![None; machine.cutters.len()];
    let mut cut = Vec::new();
    let place = |cutter: usize, pose: &Pose| {
        let station_mm = machine.cutters[cutter].station.mm();
        [lead_mm - pose.feed_mm + station_mm, pose.lateral_mm[cutter]]
    };
    for step in steps {
        match *step {
            Step::Move { to, .. } => {
                for (cutter, points) in open.iter_mut().enumerate() {
                    let (from, next) = (place(cutter, &pose), place(cutter, &to));
                    points.iter_mut().filter(|_| from != next).for_each(|points| points.push(next));
                }
                pose = to;
            }
            Step::Knife { cutter, down: true } => open[cutter] = Some(vec![place(cutter, &pose)]),
            Step::Knife { cutter, down: false } => cut.extend(open[cutter].take()),
            _ => {}
        }
    }
    (pose, cut)
}

/// The move into place from the all-zero pose, with its slowest axis coming up to speed and down again.
fn rest_to_rest_s(machine: &Machine, to: &Pose) -> f64 {
    if *to == Pose::default() {
        return 0.0;
    }
    let cruise_s = restore_s(machine, to);
    let feed = machine.feed.way_mm(0.0, to.feed_mm) / machine.feed.max_acceleration.mm_s2();
    let axes = machine.cutters.iter().enumerate().flat_map(|(k, cutter)| {
        [
            to.lateral_mm[k].abs() / cutter.lateral_acceleration.mm_s2(),
            to.blade_deg[k].abs() / cutter.blade_acceleration.deg_s2(),
        ]
    });
    cruise_s + axes.fold(feed, f64::max) / cruise_s
}
