//! Replay of a tape-cutting program that was read back from its own text (domain.md A9).
//!
//! `run` goes through the events as the machine would, with `travel` and `blade` looking at each move, and
//! keeps the way of each knife that is down as `strokes`, found by its `trail` where the edge lies beside its axis. `compare` lays these against the wanted cuts, with
//! `curves` to find what is near, `nearness` for the exact distances and `passes` for what is cut twice. `layout` looks at where
//! the pieces lie.

mod beam;
mod blade;
mod breaks;
mod compare;
mod curves;
pub mod dry;
mod faults;
pub mod layout;
mod nearness;
mod overcut;
mod passes;
mod reel;
mod run;
mod strokes;
mod trail;
mod travel;

use serde::{Deserialize, Serialize};

use super::events::Executed;
use crate::planning::finding::Finding;
use crate::planning::tape::label::CourseLabel;
use crate::planning::tape::machine::Machine;
use faults::Faults;
use strokes::Stroke;

/// A closed line in roll coordinates (r, v), in mm, its first point not repeated.
pub type Ring = Vec<[f64; 2]>;

/// A cut that the plan wants, in roll coordinates, as it was developed: not thinned, not ordered.
#[derive(Debug, Clone, PartialEq)]
pub struct WantedCut {
    /// What its course is called.
    pub course: CourseLabel,
    /// Points (r, v) in mm: r = u + the piece's roll offset. Cutter k stands over r when the U axis reads
    /// `lead_mm - r + station_mm` of k.
    pub points: Vec<[f64; 2]>,
}

/// The figures of a replay.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ReplayFigures {
    /// Largest distance in mm between a cut made and the cut wanted, in both directions, where they belong together.
    pub max_deviation_mm: f64,
    /// Length in mm of wanted cuts that no knife makes.
    pub uncut_mm: f64,
    /// Length in mm of cuts that nobody wants, or that are made twice.
    pub unwanted_mm: f64,
    /// How often the tape runs backwards.
    pub tape_reversals: u32,
    /// Length in mm of cuts that go on beyond their ends, as the machine's overcut allows.
    #[serde(default)]
    pub overcut_mm: f64,
    /// Cycle time in s by what was read: each move from rest to rest with the accelerations of the machine.
    #[serde(default)]
    pub time_s: f64,
}

impl ReplayFigures {
    /// The figures of a program that makes nothing of what is wanted.
    #[must_use]
    pub fn nothing_made(wanted: &[WantedCut]) -> Self {
        let length = |cut: &WantedCut| {
            cut.points
                .windows(2)
                .map(|pair| (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]))
                .sum::<f64>()
        };
        Self {
            max_deviation_mm: 0.0,
            uncut_mm: wanted.iter().map(length).sum(),
            unwanted_mm: 0.0,
            tape_reversals: 0,
            overcut_mm: 0.0,
            time_s: 0.0,
        }
    }
}

impl std::fmt::Display for ReplayFigures {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "largest deviation {:.4} mm, uncut {:.3} mm, unwanted {:.3} mm, tape reversals {}",
            self.max_deviation_mm, self.uncut_mm, self.unwanted_mm, self.tape_reversals
        )
    }
}

/// What a program is replayed on and against.
#[derive(Debug, Clone, Copy)]
pub struct ReplaySetup<'a> {
    /// Name of the program, for the findings.
    pub program: &'a str,
    /// The machine. It starts with all axes at 0, all knives up and the generator off.
    pub machine: &'a Machine,
    /// The reading of U in mm at which a cutter with station 0 stands over r = 0.
    pub lead_mm: f64,
    /// How far, in mm, a cut may lie from its place; printed digits come on top
    /// ([`REPLAY_SLACK_MM`](crate::planning::tolerance::REPLAY_SLACK_MM)).
    pub tolerance_mm: f64,
    /// Width of the tape in mm; beside it a knife would cut the machine.
    pub tape_width_mm: f64,
    /// Every cut of the roll. Coincident ones, of two neighbours that touch, may be made once or once each.
    pub wanted: &'a [WantedCut],
    /// How far cuts may go on beyond their ends, in mm, where no piece lies.
    pub overcut_mm: f64,
    /// Outline and cut-outs of each piece, in roll coordinates: what no overcut may enter.
    pub pieces: &'a [Vec<Vec<[f64; 2]>>],
    /// What was cut before the program begins, in roll coordinates: of a program that goes on from a course.
    pub before: &'a [Vec<[f64; 2]>],
}

/// Replays a program: the figures, and a finding with its line for everything that is not safe or not wanted.
///
/// With no finding the tape never runs backwards, all axes keep their travel and speed, knives move only with
/// the generator on and after their dwells, blades lie along their cuts, and what is cut is what is wanted,
/// each within `tolerance_mm` and the slack of printed digits. A text commands no accelerations, the control keeps its own;
/// `time_s` is with those of the machine. The
/// distances are exact but for 1e-9 mm (see `nearness`).
#[must_use]
pub fn replay(setup: &ReplaySetup<'_>, events: &[Executed]) -> (ReplayFigures, Vec<Finding>) {
    let mut faults = Faults::new(setup.program);
    let run = run::run(setup, events, &mut faults);
    let before = setup.before.iter().map(|points| Stroke::made_before(points));
    let strokes: Vec<_> = before.chain(run.strokes).collect();
    let compared = compare::compare(setup, &strokes, &mut faults);
    let figures = ReplayFigures {
        max_deviation_mm: compared.max_deviation_mm,
        uncut_mm: compared.uncut_mm,
        unwanted_mm: compared.unwanted_mm,
        tape_reversals: run.tape_reversals,
        overcut_mm: compared.overcut_mm,
        time_s: run.time_s,
    };
    (figures, faults.finish())
}

#[cfg(test)]
mod tests;
