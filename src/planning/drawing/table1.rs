//! The paper's Table 1 as data for drawings: its blank, an arc of R 85, and the published lattice in it.

use super::comparison::{Comparison, SetFigures, TimeSplit};
use super::joints::{JointCurves, JointSample};
use super::milling::Paths;
use super::optimum::{Cell, Limit, OptimumMap, ParameterSet, sampled};
use super::section::{Scallop, Section};
use crate::planning::geometry::{Point2, Point3};
use crate::planning::honeycomb::contour::{Likeness, compare};

pub const WIDTH: f64 = 85.0;
pub const HEIGHT: f64 = 50.0;
const LENGTH: f64 = 50.0;
const H: f64 = 4.398;
const S: f64 = 5.968;
const ALPHA_DEG: f64 = 34.155;

/// z of the arc at x.
pub fn arc(x: f64) -> f64 {
    (85.0_f64.powi(2) - (x - 42.5).powi(2)).sqrt() - 68.218
}

/// Eqs. 8 to 13 with the step that takes least time: domain.md B2.
pub fn model(h: f64, alpha_deg: f64) -> Cell {
    let (sine, cosine) = alpha_deg.to_radians().sin_cos();
    let edge = (60.0_f64 - 7.13).to_radians();
    if alpha_deg > 50.0 {
        return Cell::Excluded(Limit::SwingAngle);
    }
    if h > 2.0 / 3.0 * 10.0 * cosine * edge.sin() {
        return Cell::Excluded(Limit::CuttingLength);
    }
    let widest = 2.0 * h * sine / cosine;
    let scallop = |s: f64| (s * s / 4.0 + (s / widest + 1.0).powi(2) * h * h).sqrt();
    let steps = (1..=200).map(|i| widest * f64::from(i) / 200.0).filter(|s| scallop(*s) <= 10.0);
    let times = steps.map(|s| time(h, s, sine, cosine));
    times.reduce(f64::min).map_or(Cell::Excluded(Limit::Scallop), Cell::Time)
}

fn time(h: f64, s: f64, sine: f64, cosine: f64) -> f64 {
    let _ = sine;
    let edge = (60.0_f64 - 7.13).to_radians();
    let (area, layers) = (3137.0, 3137.0 / (WIDTH * h) - 0.5);
    let b = 1.5 * h / (edge.tan() * cosine);
    let turn = 2.0 * (cosine * 60.0_f64.to_radians().sin()).acos().to_degrees() / 90.0;
    let t1 = (2.0 * LENGTH + 4.0 * b) / 200.0 + turn + turn.max(s / 200.0);
    let t2 = (20.0 + 2.0 * area / WIDTH + WIDTH - h - 0.5 * s) / 200.0;
    (WIDTH / s + 0.5) * layers * t1 + layers * t2
}

pub fn optimum_map() -> OptimumMap {
    let set = |layer_spacing_mm, step_mm, swing_angle_deg, time_s| ParameterSet {
        layer_spacing_mm,
        step_mm,
        swing_angle_deg,
        time_s,
    };
    OptimumMap {
        rows: sampled((0.5, 6.0), (5.0, 55.0), model),
        optimum: Some(set(H, S, ALPHA_DEG, 307.599)),
        initial: Some(set(3.0, 6.0, 45.0, 515.305)),
    }
}

pub fn comparison() -> Comparison {
    Comparison {
        initial: Some(SetFigures {
            layer_spacing_mm: 3.0,
            step_mm: 6.0,
            swing_angle_deg: 45.0,
            shift_mm: 0.0,
            scallop_mm: 6.708,
            split: TimeSplit { cutting_s: 109.3, turning_s: 398.2, moving_s: 7.805 },
        }),
        optimised: SetFigures {
            layer_spacing_mm: H,
            step_mm: S,
            swing_angle_deg: ALPHA_DEG,
            shift_mm: 0.0,
            scallop_mm: 9.289,
            split: TimeSplit { cutting_s: 71.4, turning_s: 231.0, moving_s: 5.199 },
        },
        max_scallop_mm: 10.0,
    }
}

/// The tips of the orthogonal lattice above the arc.
pub fn tips(h: f64, s: f64) -> Vec<Point2> {
    let columns = (WIDTH / s).floor();
    let layer = |k: i32| {
        let column = move |j: i32| WIDTH / 2.0 + (f64::from(j) - columns / 2.0) * s;
        (0..=columns as i32).map(move |j| Point2::new(column(j), HEIGHT - f64::from(k) * h))
    };
    (1..(HEIGHT / h) as i32).flat_map(layer).filter(|tip| tip.y >= arc(tip.x)).collect()
}

pub fn contour() -> Vec<Point2> {
    (0..=340).map(|i| f64::from(i) * 0.25).map(|x| Point2::new(x, arc(x))).collect()
}

/// What remains if all chips come free: the lower envelope of the grooves.
fn surface(tips: &[Point2], alpha_deg: f64) -> Vec<Point2> {
    let slope = alpha_deg.to_radians().tan();
    let height = |x: f64| {
        let grooves = tips.iter().map(|tip| tip.y + (x - tip.x).abs() / slope);
        grooves.fold(HEIGHT, f64::min).max(arc(x))
    };
    (0..=1700).map(|i| f64::from(i) * 0.05).map(|x| Point2::new(x, height(x))).collect()
}

pub fn section(h: f64, s: f64) -> Section {
    let tips = tips(h, s);
    let (contour, surface) = (contour(), surface(&tips, ALPHA_DEG));
    let foot = |at: &Point2| {
        let nearer = |a: &&Point2, b: &&Point2| (*a - at).norm().total_cmp(&(*b - at).norm());
        *contour.iter().min_by(nearer).unwrap()
    };
    let scallops = surface.iter().step_by(4).map(|ridge| Scallop { ridge: *ridge, foot: foot(ridge) });
    let scallop = scallops.max_by(|a, b| a.height_mm().total_cmp(&b.height_mm()));
    Section {
        plan: "published, orthogonal lattice",
        blank: (WIDTH, HEIGHT),
        surface: vec![surface],
        tips,
        contour,
        swing_angle_deg: ALPHA_DEG,
        reach_mm: 7.973,
        stuck: Vec::new(),
        gouges: Vec::new(),
        scallop,
        max_scallop_mm: Some(10.0),
    }
}

/// The tips as a reciprocating milling path and as the path that it is converted into.
pub fn paths(tips: &[Point2]) -> Paths {
    let (mut milling, mut converted) =
        (vec![Point3::new(0.0, 0.0, 60.0)], vec![Point3::new(0.0, -6.0, 60.0)]);
    for (index, tip) in tips.iter().enumerate() {
        let ends = if index % 2 == 0 { [0.0, LENGTH] } else { [LENGTH, 0.0] };
        milling.extend(ends.map(|y| Point3::new(tip.x, y, tip.y)));
        converted.extend([-6.036, LENGTH + 6.036, -6.036].map(|y| Point3::new(tip.x, y, tip.y)));
    }
    Paths { blank: (WIDTH, LENGTH, HEIGHT), milling, converted }
}

/// Joints that swing in a plausible way through the program of 119 tips.
pub fn joints(samples: usize) -> JointCurves {
    let sample = |index: usize| {
        let time_s = 315.0 * index as f64 / samples.max(2) as f64;
        let (cut, layer) = ((time_s * 2.4).sin(), time_s / 315.0);
        JointSample {
            time_s,
            joints_deg: [
                2.0 * cut,
                -75.0 + 6.0 * layer + cut,
                105.0 - 4.0 * cut,
                25.0 * cut,
                40.0 + 20.0 * layer * cut,
                170.0 * layer - 20.0 * cut,
            ],
            speed_ratio: 0.42 + 0.3 * (time_s * 4.8).cos().powi(3) + 0.1 * layer,
        }
    };
    JointCurves {
        arm: "KR 210 R3100-2",
        samples: (0..samples).map(sample).collect(),
        limits_deg: [
            (-185.0, 185.0),
            (-140.0, -5.0),
            (-120.0, 168.0),
            (-350.0, 350.0),
            (-122.5, 122.5),
            (-350.0, 350.0),
        ],
        fault: None,
    }
}

/// The arc and the section of the published plan.
pub fn likeness() -> Likeness {
    compare(&contour(), &section(H, S).surface).unwrap()
}

/// The published plan.
pub fn published() -> Section {
    section(H, S)
}
