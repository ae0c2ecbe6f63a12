//! A coarse look at a path on each of the eight branches: which of them are worth following closely.
//!
//! Of all moves that turn the tool alike only those at the outer corners of the path are looked at, each at its ends and
//! its middle. What is found ranks; it proves nothing.

use nalgebra::{UnitQuaternion, Vector3};

use super::arm::Joint;
use super::branch::{Branch, SingularityMargins, limit_margins, unwound};
use super::check::{Motion, PathStep, Robot};
use super::travel::Travel;
use crate::planning::budget::Budget;
use crate::planning::finding::Finding;
use crate::planning::geometry::frame::Pose;
use crate::planning::program::robot_moves::Joints;

/// One way to stand at the beginning of a path, and what it promises.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prospect {
    /// The joints at the beginning, in degrees, by whole turns as the path needs them.
    pub start: Joints,
    /// Whether all that was looked at is reached within the joint limits, however slowly.
    pub reachable: bool,
    /// The smallest share of freedom seen; see [`super::check::RobotCheck::freedom`].
    pub freedom: f64,
}

/// The few moves of a path that stand for all of it.
#[derive(Debug, Clone)]
pub struct Sketch<'a> {
    moves: Vec<Straight<'a>>,
}

/// A straight move: from, to, and its duration in s.
type Straight<'a> = (&'a Pose, &'a Pose, f64);

/// Moves are told apart by their turns into at most so many kinds; others count as of the kind most like them.
const MOST_KINDS: usize = 16;
/// Two orientations are alike when the dot product of their quaternions is at least this: within 0.05 degrees.
const ALIKE: f64 = 1.0 - 1e-7;
/// What one look costs of a budget, in steps.
const LOOK_STEPS: u64 = 100;
/// A way with this share of freedom need not give way to a freer one that lies farther from home.
const COMFORTABLE: f64 = 0.1;
/// A joint that keeps this far from its limits, in degrees, need not turn by a whole turn more.
const COMFORTABLE_DEG: f64 = 10.0;
/// Joints are tried with up to so many whole turns more or less.
const MOST_TURNS: i32 = 2;

/// The ways to stand at the beginning of a path that are worth following, the best first: comfortable ones nearest to
/// home, then the others that seem to work; if none does, the one that fails least.
///
/// # Errors
/// `BudgetSpent`, `Cancelled`.
pub fn starts(robot: &Robot, path: &[PathStep], budget: &Budget) -> Result<Vec<Joints>, Finding> {
    let sketch = Sketch::of(path);
    let mut prospects = prospects(robot, &sketch, f64::NEG_INFINITY, budget)?;
    if prospects.iter().any(|prospect| prospect.freedom > 0.0) {
        prospects.retain(|prospect| prospect.freedom > 0.0);
        let rank = |p: &Prospect| (p.freedom < COMFORTABLE, robot.axes_duration_s(robot.home(), &p.start));
        prospects.sort_by(|a, b| {
            let ((tight_a, far_a), (tight_b, far_b)) = (rank(a), rank(b));
            tight_a.cmp(&tight_b).then(far_a.total_cmp(&far_b))
        });
    } else {
        prospects.sort_by(|a, b| b.reachable.cmp(&a.reachable).then(b.freedom.total_cmp(&a.freedom)));
        prospects.truncate(1);
    }
    Ok(prospects.into_iter().map(|prospect| prospect.start).collect())
}

/// What each branch promises that reaches the first straight move of a path at all. Where freedom has fallen to `floor`
/// or below nobody looks any further.
///
/// # Errors
/// `BudgetSpent`, `Cancelled`.
pub fn prospects(
    robot: &Robot,
    sketch: &Sketch,
    floor: f64,
    budget: &Budget,
) -> Result<Vec<Prospect>, Finding> {
    let travel = |(from, to, seconds): &Straight| {
        Travel::new(robot.kinematics(), robot.tool(), robot.base(), (from, to), *seconds)
    };
    let travels: Vec<_> = sketch.moves.iter().map(travel).collect();
    let Some((first, ..)) = sketch.moves.first() else { return Ok(Vec::new()) };
    let flange = robot.flange(first);
    let mut prospects = Vec::new();
    for branch in Branch::ALL {
        budget.spend(LOOK_STEPS)?;
        if let Ok(start) = robot.kinematics().inverse(&flange, branch, robot.home()) {
            let mut span = Span::new(unwound(&start, robot.home()), floor);
            let looks = span.pass(robot, &travels, branch);
            budget.spend(LOOK_STEPS * looks)?;
            prospects.push(span.prospect(robot));
        }
    }
    Ok(prospects)
}

impl<'a> Sketch<'a> {
    /// Picks them. The first move that can be travelled is always one of them.
    #[must_use]
    pub fn of(path: &'a [PathStep]) -> Self {
        let moves: Vec<_> = path.iter().filter_map(straight).collect();
        let mut kinds: Vec<Kind> = Vec::new();
        for (index, moved) in moves.iter().enumerate() {
            match likest(&kinds, moved) {
                Some((kind, likeness)) if likeness >= ALIKE || kinds.len() == MOST_KINDS => {
                    kinds[kind].take(index, moved);
                }
                _ => kinds.push(Kind::new(index, moved)),
            }
        }
        let mut picked: Vec<_> = kinds.iter().flat_map(|kind| kind.corners.map(|(index, _)| index)).collect();
        picked.sort_unstable();
        picked.dedup();
        Self { moves: picked.into_iter().map(|index| moves[index]).collect() }
    }
}

/// A straight move that can be travelled at all.
fn straight(step: &PathStep) -> Option<Straight<'_>> {
    match &step.motion {
        Motion::Straight { from, to, duration_s } if *duration_s > 0.0 && duration_s.is_finite() => {
            Some((from, to, *duration_s))
        }
        _ => None,
    }
}

/// Moves with the same orientations at both ends.
struct Kind {
    from: UnitQuaternion<f64>,
    to: UnitQuaternion<f64>,
    /// The move farthest out toward each corner of a box, and how far out.
    corners: [(usize, f64); 8],
}

impl Kind {
    fn new(index: usize, moved: &Straight) -> Self {
        let (from, to, _) = moved;
        let mut kind =
            Self { from: from.rotation, to: to.rotation, corners: [(index, f64::NEG_INFINITY); 8] };
        kind.take(index, moved);
        kind
    }

    fn take(&mut self, index: usize, (from, to, _): &Straight) {
        let place = from.translation.vector + to.translation.vector;
        for (corner, (outermost, out)) in self.corners.iter_mut().enumerate() {
            let sign = |bit: usize| if corner & bit == 0 { -1.0 } else { 1.0 };
            let here = place.dot(&Vector3::new(sign(1), sign(2), sign(4)));
            if here > *out {
                (*outermost, *out) = (index, here);
            }
        }
    }
}

/// The kind most like a move, and how like it is: 1 for equal orientations.
fn likest(kinds: &[Kind], (from, to, _): &Straight) -> Option<(usize, f64)> {
    let dot = |a: &UnitQuaternion<f64>, b: &UnitQuaternion<f64>| a.coords.dot(&b.coords).abs();
    let likeness = |kind: &Kind| dot(&kind.from, &from.rotation).min(dot(&kind.to, &to.rotation));
    kinds.iter().map(likeness).enumerate().max_by(|a, b| a.1.total_cmp(&b.1))
}

/// What joints pass through on a path.
struct Span {
    start: Joints,
    now: Joints,
    low: Joints,
    high: Joints,
    reachable: bool,
    /// The smallest share of freedom of speeds and singularities.
    freedom: f64,
    floor: f64,
}

impl Span {
    fn new(start: Joints, floor: f64) -> Self {
        Self { start, now: start, low: start, high: start, reachable: true, freedom: 1.0, floor }
    }

    /// Passes over the travels as far as it goes, and says how often it has looked.
    fn pass(&mut self, robot: &Robot, travels: &[Travel], branch: Branch) -> u64 {
        let mut looks = 0;
        for travel in travels {
            for share in [0.0, 0.5, 1.0] {
                looks += 1;
                self.look(robot, travel, share * travel.duration_s(), branch);
                if !self.reachable || self.freedom <= self.floor {
                    return looks;
                }
            }
        }
        looks
    }

    fn look(&mut self, robot: &Robot, travel: &Travel, at_s: f64, branch: Branch) {
        /// A metre out of reach counts as a whole freedom missed.
        const MM_PER_FREEDOM: f64 = 1_000.0;
        let kinematics = robot.kinematics();
        let (target, twist) = travel.at(at_s);
        let stance = match kinematics.solve(&target, branch, kinematics.angles(&self.now)[3]) {
            Ok(stance) => stance,
            Err(miss) => {
                self.reachable = false;
                self.freedom = -1.0 - miss.by_mm() / MM_PER_FREEDOM;
                return;
            }
        };
        self.now = unwound(&kinematics.joints(&stance), &self.now);
        for (i, joint) in self.now.iter().enumerate() {
            self.low[i] = self.low[i].min(*joint);
            self.high[i] = self.high[i].max(*joint);
        }
        let singular = SingularityMargins::of(kinematics, &stance).smallest().1.to_radians().sin();
        let rates = kinematics.rates(&stance, &twist);
        let ratio = |i: usize| rates[i].abs().to_degrees() / robot.arm().joints[i].max_speed_deg_s;
        // At a singularity a rate may be no number at all; then there is no freedom either.
        let faster = |most: f64, ratio: f64| if ratio.is_nan() { f64::INFINITY } else { most.max(ratio) };
        let fastest = (0..6).map(ratio).fold(0.0, faster);
        self.freedom = self.freedom.min(singular).min(1.0 - fastest);
    }

    /// Turns the whole path by whole turns of its joints to where it fits best.
    fn prospect(&self, robot: &Robot) -> Prospect {
        let joints = &robot.arm().joints;
        let turn: Joints = std::array::from_fn(|i| {
            whole_turns(&joints[i], self.low[i], self.high[i], robot.home()[i] - self.start[i])
        });
        let turned = |joints: &Joints| -> Joints { std::array::from_fn(|i| joints[i] + turn[i]) };
        let margins = [&self.low, &self.high].map(|joints| limit_margins(robot.arm(), &turned(joints)));
        let share =
            |i: usize| margins[0][i].min(margins[1][i]) / (0.5 * (joints[i].max_deg - joints[i].min_deg));
        let tightest = (0..6).map(share).fold(f64::INFINITY, f64::min);
        Prospect {
            start: turned(&self.start),
            reachable: self.reachable && tightest >= 0.0,
            freedom: self.freedom.min(tightest),
        }
    }
}

/// By how many degrees of whole turns a joint that goes from `low` to `high` is turned so that it keeps comfortably
/// within its limits, as near to `wanted` as it can; or else to where it keeps farthest within them.
fn whole_turns(joint: &Joint, low: f64, high: f64, wanted: f64) -> f64 {
    let margin =
        |turn: f64| (low + turn - joint.min_deg).min(joint.max_deg - high - turn).min(COMFORTABLE_DEG);
    let turns = (-MOST_TURNS..=MOST_TURNS).map(|turns| 360.0 * f64::from(turns));
    let better = |a: &f64, b: &f64| {
        let (near_a, near_b) = ((a - wanted).abs(), (b - wanted).abs());
        margin(*a).total_cmp(&margin(*b)).then(near_b.total_cmp(&near_a))
    };
    turns.max_by(better).unwrap_or(0.0)
}
