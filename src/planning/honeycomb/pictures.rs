//! What the drawings of the honeycomb jobs are made of.

use super::cell::Cell;
use super::contour::{Likeness, compare, foot};
use super::convert::Converted;
use super::input::{Blank, CutInput};
use super::lattice_kind::Lattice;
use super::model::Model;
use super::model::estimate::Estimate;
use super::model::limit::Limit;
use super::optimum::{Optimum, best_step};
use super::plan::{Plan, Way};
use crate::planning::drawing::comparison::{Comparison, SetFigures, TimeSplit, comparison};
use crate::planning::drawing::contour::{Origin, contours, correlation};
use crate::planning::drawing::joints::{JointCurves, JointFault, JointSample, joints};
use crate::planning::drawing::milling::{Paths, milling};
use crate::planning::drawing::optimum::{
    Cell as MapCell, Limit as MapLimit, OptimumMap, ParameterSet, map, sampled,
};
use crate::planning::drawing::section::{Scallop, Section, section};
use crate::planning::geometry::Point3;
use crate::planning::outcome::Drawing;
use crate::planning::robot::check::{Robot, RobotCheck};

/// The drawings of a plan: its section, the paper's beside it, what the model says, the contour, the joints.
#[must_use]
pub fn of_plan(plan: &Plan, input: &CutInput, cell: &Cell) -> Vec<Drawing> {
    let mut drawings = vec![section(&section_of(&plan.best, "as planned", input), "section")];
    if let Some(published) = &plan.published {
        drawings.push(section(&section_of(published, "the published way", input), "section-published"));
    }
    if let Some(initial) = &plan.initial {
        drawings.push(section(&section_of(initial, "the set to compare with", input), "section-initial"));
        drawings.push(compared(&initial.estimate, &plan.best.estimate, plan.best.attempt.lattice, input));
    }
    if let Some(likeness) = &plan.best.likeness {
        drawings.extend(likenesses(likeness, Origin::Simulated));
    }
    let measured = input.measured.as_ref();
    if let Some(likeness) = measured.and_then(|found| compare(&input.profile, std::slice::from_ref(found))) {
        drawings.extend(likenesses(&likeness, Origin::Measured));
    }
    if let (Some(check), Some(robot)) = (&plan.robot, &cell.robot) {
        let names: Vec<&str> = plan.final_attempt().files.iter().map(|file| file.name.as_str()).collect();
        drawings.push(joints(&curves(check, robot, &names)));
    }
    drawings
}

fn likenesses(likeness: &Likeness, origin: Origin) -> [Drawing; 2] {
    [contours(likeness, origin), correlation(likeness, origin)]
}

fn section_of(way: &Way, name: &'static str, input: &CutInput) -> Section {
    let (attempt, blank) = (&way.attempt, &input.setting.blank);
    let remains = attempt.replay.swept.remains.as_ref();
    let blade = &input.setting.blade;
    let scallop = remains.and_then(|remains| remains.scallop.as_ref());
    Section {
        plan: name,
        blank: (blank.width_mm, blank.height_mm),
        contour: input.profile.clone(),
        surface: remains.map_or_else(Vec::new, |remains| remains.surface.clone()),
        tips: attempt.tips.iter().flatten().copied().collect(),
        swing_angle_deg: attempt.spacing.swing.to_degrees(),
        reach_mm: blade.reach_mm(blade.max_cutting_length.mm()),
        stuck: remains.map_or_else(Vec::new, |r| r.stuck.iter().map(|tip| vec![*tip]).collect()),
        gouges: Vec::new(),
        scallop: scallop.map(|far| Scallop { ridge: far.at, foot: foot(&far.at, &input.profile) }),
        max_scallop_mm: Some(input.setting.process.max_scallop_mm),
    }
}

fn compared(initial: &Estimate, optimised: &Estimate, lattice: Lattice, input: &CutInput) -> Drawing {
    let max_scallop_mm = input.setting.process.max_scallop_mm;
    let initial = Some(figures(initial, Lattice::Orthogonal));
    comparison(&Comparison { initial, optimised: figures(optimised, lattice), max_scallop_mm })
}

fn figures(estimate: &Estimate, lattice: Lattice) -> SetFigures {
    let parameters = estimate.parameters;
    SetFigures {
        layer_spacing_mm: parameters.layer_spacing_mm,
        step_mm: parameters.step_mm,
        swing_angle_deg: parameters.swing_rad.to_degrees(),
        shift_mm: if lattice == Lattice::Interlaced { parameters.step_mm / 2.0 } else { 0.0 },
        scallop_mm: estimate.scallop_mm,
        split: TimeSplit {
            cutting_s: estimate.cutting_s,
            turning_s: estimate.turning_s,
            moving_s: estimate.moving_s,
        },
    }
}

/// The drawings of an optimum: time over (h, alpha), and both sets side by side.
#[must_use]
pub fn of_optimum(model: &Model, optimum: &Optimum, initial: Option<&Estimate>) -> Vec<Drawing> {
    let found = &optimum.estimate;
    let place = |estimate: &Estimate| ParameterSet {
        layer_spacing_mm: estimate.parameters.layer_spacing_mm,
        step_mm: estimate.parameters.step_mm,
        swing_angle_deg: estimate.parameters.swing_rad.to_degrees(),
        time_s: estimate.time_s,
    };
    let largest = |of: fn(&Estimate) -> f64| initial.map_or(0.0, of).max(of(found));
    // Half as much again as the larger of both shows what lies beyond the limits.
    let h = 1.5 * largest(|estimate| estimate.parameters.layer_spacing_mm);
    let alpha = (1.1 * model.given().max_swing_rad.to_degrees())
        .max(1.1 * largest(|estimate| estimate.parameters.swing_rad.to_degrees()))
        .min(89.0);
    let rows = sampled((h / 50.0, h), (alpha / 50.0, alpha), |h, alpha| map_cell(model, h, alpha));
    let map = map(&OptimumMap { rows, optimum: Some(place(found)), initial: initial.map(place) });
    let lattice = model.given().lattice;
    let comparison = comparison(&Comparison {
        initial: initial.map(|initial| figures(initial, lattice)),
        optimised: figures(found, lattice),
        max_scallop_mm: model.given().max_scallop_mm,
    });
    vec![map, comparison]
}

fn map_cell(model: &Model, h: f64, alpha_deg: f64) -> MapCell {
    match best_step(model, h, alpha_deg.to_radians()) {
        Ok(time_s) => MapCell::Time(time_s),
        Err(limit) => MapCell::Excluded(match limit {
            Limit::CuttingLength => MapLimit::CuttingLength,
            Limit::Scallop | Limit::Step => MapLimit::Scallop,
            Limit::SwingAngle => MapLimit::SwingAngle,
            Limit::Layers => MapLimit::Layers,
            Limit::Points => MapLimit::Points,
        }),
    }
}

/// The drawing of a conversion.
#[must_use]
pub fn of_conversion(converted: &Converted, blank: &Blank) -> Drawing {
    milling(&Paths {
        blank: (blank.width_mm, blank.length_mm, blank.height_mm),
        milling: converted.milling.iter().map(|point| point.position).collect(),
        converted: converted.moves.iter().map(|step| Point3::from(step.to.translation.vector)).collect(),
    })
}

/// The arms whose names may stand in a drawing; names that others gave stay out of it.
const BUILT_IN: [&str; 4] = ["kr210-r3100-2", "kr210-r2700-2", "kr210-r3100-ultra", "kr210-l150"];

/// The joints over time, with their speed over its limit.
#[must_use]
pub fn curves(check: &RobotCheck, robot: &Robot, names: &[&str]) -> JointCurves {
    let axes = &robot.arm().joints;
    let ratio = |index: usize| {
        let (Some(here), Some(before)) =
            (check.curve.get(index), index.checked_sub(1).map(|i| &check.curve[i]))
        else {
            return 0.0;
        };
        let seconds = here.time_s - before.time_s;
        let share = |joint: usize| {
            let way = (here.joints[joint] - before.joints[joint]).abs();
            if seconds > 0.0 { way / seconds / axes[joint].max_speed_deg_s } else { 0.0 }
        };
        (0..6).map(share).fold(0.0, f64::max)
    };
    let sample = |(index, sample): (usize, &crate::planning::robot::curve::JointSample)| JointSample {
        time_s: sample.time_s,
        joints_deg: sample.joints,
        speed_ratio: ratio(index),
    };
    JointCurves {
        arm: BUILT_IN.into_iter().find(|name| *name == robot.arm().name).unwrap_or_default(),
        samples: check.curve.iter().enumerate().map(sample).collect(),
        limits_deg: std::array::from_fn(|joint| (axes[joint].min_deg, axes[joint].max_deg)),
        fault: check.first_fault.as_ref().map(|first| JointFault {
            time_s: first.time_s,
            joint: None,
            what: if first.fault.is_of_place() { "cannot be reached" } else { "too fast" },
            file: names.get(first.place.file).map_or_else(String::new, |name| (*name).to_owned()),
            line: first.place.line,
        }),
    }
}
