//! The trace with cutting information planted at the end of each course (the companion paper's section 2.4): where each
//! knife goes down, how its blade lies, how fast it cuts, where it comes up. As text (`text`) and as JSON.

pub mod text;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::input::TapeInput;
use super::label::CourseLabel;
use super::machine::{Cutter, Machine};
use super::plan::{PlannedCourse, TapePlan};
use super::stroke::{DECIMALS, Knot, Stroke};
use crate::planning::json::written;
use crate::planning::outcome::Attachment;
use crate::planning::program::number::rounded;

/// Decimals of places and normals of the trace: as inputs are printed at best.
const PLACE_DECIMALS: usize = 6;

/// A trace with its cuts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlantedTrace {
    /// The courses that touch the ply, in laying order.
    pub courses: Vec<TraceCourse>,
}

/// A course with its cuts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TraceCourse {
    /// The ply that it is of, from 1, where there are several.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ply: Option<u32>,
    /// Its number.
    pub number: u32,
    /// Its points: x, y, z in mm and the mould's outward unit normal.
    pub points: Vec<[f64; 6]>,
    /// What its pieces need cut, each cutter's strokes in the order in which it makes them.
    pub strokes: Vec<TraceStroke>,
}

/// What a knife does from going down to coming up.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TraceStroke {
    /// Piece of the course, from 1.
    pub piece: usize,
    /// Number of the cutter.
    pub cutter: u32,
    /// Where it goes down, u and v of the course in mm.
    pub down: [f64; 2],
    /// Where it then cuts to, one straight line after the other; it comes up at the last.
    pub cuts: Vec<TraceCut>,
}

/// A straight cut.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TraceCut {
    /// Where it ends, u and v of the course in mm.
    pub to: [f64; 2],
    /// The blade along it, in degrees from V: `atan2(dU, dV)`.
    pub blade_deg: f64,
    /// The speed of the knife along it if the other knife is up, in mm/s.
    pub feed_mm_s: f64,
}

/// Plants the cuts of a plan into its trace.
#[must_use]
pub fn planted(plan: &TapePlan, strokes: &[Vec<Stroke>], input: &TapeInput) -> PlantedTrace {
    let mut of_courses: BTreeMap<CourseLabel, Vec<(&Cutter, &Stroke)>> = BTreeMap::new();
    for (cutter, strokes) in input.machine.cutters.iter().zip(strokes) {
        for stroke in strokes {
            of_courses.entry(stroke.course).or_default().push((cutter, stroke));
        }
    }
    let courses = plan.courses.iter().map(|course| {
        let strokes = of_courses.remove(&course.label).unwrap_or_default();
        let planted =
            strokes.into_iter().map(|(cutter, stroke)| trace_stroke(stroke, cutter, &input.machine));
        let CourseLabel { ply, number } = course.label;
        TraceCourse { ply, number, points: points(course, input), strokes: planted.collect() }
    });
    PlantedTrace { courses: courses.collect() }
}

fn points(course: &PlannedCourse, input: &TapeInput) -> Vec<[f64; 6]> {
    let traced = input.ply(course.place.ply).and_then(|ply| ply.courses.get(course.place.index));
    let pairs = traced.into_iter().flat_map(|traced| traced.points.iter().zip(&traced.normals));
    let place = |value: f64| rounded(value, PLACE_DECIMALS);
    pairs.map(|(at, n)| [at.x, at.y, at.z, n.x, n.y, n.z].map(place)).collect()
}

fn trace_stroke(stroke: &Stroke, cutter: &Cutter, machine: &Machine) -> TraceStroke {
    let place = |knot: &Knot| [rounded(stroke.x_of_u0 - knot.x, DECIMALS), rounded(knot.v, DECIMALS)];
    let cuts = stroke.knots.windows(2).map(|ends| TraceCut {
        to: place(&ends[1]),
        blade_deg: rounded(ends[0].blade_deg, DECIMALS),
        feed_mm_s: rounded(feed_mm_s(&ends[0], &ends[1], cutter, machine), DECIMALS),
    });
    let (piece, down) = (stroke.piece + 1, place(&stroke.knots[0]));
    TraceStroke { piece, cutter: cutter.number, down, cuts: cuts.collect() }
}

/// The speed of a knife along a straight cut: as fast as the tape, the carriage and the way in the tape allow.
fn feed_mm_s(from: &Knot, to: &Knot, cutter: &Cutter, machine: &Machine) -> f64 {
    let (du, dv) = ((to.x - from.x).abs(), (to.v - from.v).abs());
    let length = du.hypot(dv);
    let seconds = [
        du / machine.feed.max_speed.mm_s(),
        dv / cutter.cutting_speed.mm_s(),
        length / machine.max_cutting_path_speed.mm_s(),
    ];
    length / seconds.into_iter().fold(0.0, f64::max)
}

impl PlantedTrace {
    /// The trace as `trace-planted.txt` and `trace-planted.json`. Of a large ply it takes as much room as its texts.
    #[must_use]
    pub fn into_attachments(self) -> [Attachment; 2] {
        let json = written(&self) + "\n";
        [
            Attachment { name: "trace-planted.txt".to_owned(), text: text::write(&self) },
            Attachment { name: "trace-planted.json".to_owned(), text: json },
        ]
    }
}
