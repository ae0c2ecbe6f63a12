//! Whether an arm can follow a path: reach, limits, speeds, and the distance from singularities.

use super::arm::{self, Arm};
use super::branch::{Branch, Follower, Instant, Lost, SingularityMargins, limit_margins, ways};
use super::curve::{Curve, JointSample};
use super::fault::{Fault, FirstFault, Place};
use super::kinematics::{Kinematics, Unreachable};
use super::survey;
use super::travel::{self, Travel};
use crate::planning::budget::Budget;
use crate::planning::finding::Finding;
use crate::planning::geometry::frame::Pose;
use crate::planning::program::robot_moves::Joints;
use crate::planning::tolerance::{HALF_TURN_DEG, JOINT_SLACK, PATH_GAP_DEG, PATH_GAP_MM, SINGULAR_DEG};

/// An arm in its cell: with a tool, before a part.
#[derive(Debug, Clone, PartialEq)]
pub struct Robot {
    arm: Arm,
    kinematics: Kinematics,
    tool: Pose,
    base: Pose,
    home: Joints,
}

/// A step of a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathStep {
    /// Where it stands in the program.
    pub place: Place,
    /// What is done.
    pub motion: Motion,
}

/// What is done in a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Motion {
    /// All joints go together to these angles, in degrees; looked at only at its end, and there only for limits.
    Axes(Joints),
    /// All joints go together to where the tool has this pose in the part's frame; looked at as [`Motion::Axes`].
    ///
    /// The branch stays, as without a status in a program; from a singularity, or from nowhere, the nearest is taken.
    AxesToPose(Pose),
    /// The tool goes straight from a pose to another one in the part's frame.
    Straight {
        /// Where it begins: where the step before has ended.
        from: Pose,
        /// Where it ends.
        to: Pose,
        /// How long it takes at the programmed feed, in s; see [`travel::duration_s`].
        duration_s: f64,
    },
}

/// What came of a check. Where a number is missing, nothing was looked at.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RobotCheck {
    /// Whether every pose is reached within the joint limits, on one branch, however slowly.
    pub reachable: bool,
    /// How near a joint comes to its limit, in degrees; negative beyond it.
    pub min_joint_margin_deg: Option<f64>,
    /// How near a straight move comes to a singularity, in degrees: the smallest of the three below, the shoulder's as
    /// an angle.
    pub min_singularity_margin: Option<f64>,
    /// The smallest of each of the three margins.
    pub singularities: Option<SingularityMargins>,
    /// The largest joint speed of straight moves over that joint's limit.
    pub max_joint_speed_ratio: f64,
    /// The joint with that speed, 1 to 6; 0 if none has moved.
    pub fastest_joint: usize,
    /// The smallest share of freedom left, 1 to 0 and below: of half of a joint's range, of its speed, and as the sine
    /// of the distance from singularities. By it placements are compared.
    pub freedom: f64,
    /// Where the first straight move begins, in degrees: for the approach from home.
    pub start: Option<Joints>,
    /// The first thing that is wrong.
    pub first_fault: Option<FirstFault>,
    /// The joints over time, thinned out. A step of all joints takes as long as its slowest joint at full speed.
    pub curve: Vec<JointSample>,
    /// How many instants were looked at.
    pub instants: usize,
}

impl RobotCheck {
    /// Whether the arm can follow the path as programmed.
    #[must_use]
    pub fn passes(&self) -> bool {
        self.first_fault.is_none()
    }
}

impl Robot {
    /// Puts an arm into its cell: `tool` is the tool tip in the flange, `base` the part's frame in the robot's, `home`
    /// in degrees.
    ///
    /// # Errors
    /// Every fault of the arm.
    pub fn new(arm: Arm, tool: Pose, base: Pose, home: Joints) -> Result<Self, Vec<Finding>> {
        arm::checked(&arm, "")?;
        Ok(Self { kinematics: Kinematics::new(&arm), arm, tool, base, home })
    }

    /// The arm.
    #[must_use]
    pub fn arm(&self) -> &Arm {
        &self.arm
    }

    /// Its kinematics.
    #[must_use]
    pub fn kinematics(&self) -> &Kinematics {
        &self.kinematics
    }

    /// The tool tip in the flange.
    #[must_use]
    pub fn tool(&self) -> &Pose {
        &self.tool
    }

    /// The part's frame in the robot's.
    #[must_use]
    pub fn base(&self) -> &Pose {
        &self.base
    }

    /// Where programs begin and end, in degrees.
    #[must_use]
    pub fn home(&self) -> &Joints {
        &self.home
    }

    /// The same robot with the part somewhere else.
    #[must_use]
    pub fn moved_to(&self, base: Pose) -> Self {
        Self { base, ..self.clone() }
    }

    /// The pose of the tool in the part's frame, for joints in degrees.
    #[must_use]
    pub fn tip(&self, joints: &Joints) -> Pose {
        self.base.inverse() * self.kinematics.forward(joints) * self.tool
    }

    /// The pose of the flange in the robot's frame, for a pose of the tool in the part's.
    #[must_use]
    pub fn flange(&self, tip: &Pose) -> Pose {
        self.base * tip * self.tool.inverse()
    }

    /// How long the joints take together from one place to another one at full speed, in s.
    #[must_use]
    pub fn axes_duration_s(&self, from: &Joints, to: &Joints) -> f64 {
        let seconds = |i: usize| (to[i] - from[i]).abs() / self.arm.joints[i].max_speed_deg_s;
        (0..6).map(seconds).fold(0.0, f64::max)
    }
}

/// Follows a path and says what is wrong with it first, and how much freedom it leaves.
///
/// `start` is where the joints are before the first step, in degrees, if that is known. If it is not and the path begins
/// with a straight move, the ways to stand there are tried, the nearest to home first, until one can be followed
/// throughout; [`RobotCheck::start`] says which. After a fault that is not one of limits or speeds the check ends.
///
/// # Errors
/// `BudgetSpent`, `Cancelled`.
pub fn check(
    robot: &Robot,
    start: Option<Joints>,
    path: &[PathStep],
    budget: &Budget,
) -> Result<RobotCheck, Finding> {
    let begins_straight = matches!(path.first(), Some(PathStep { motion: Motion::Straight { .. }, .. }));
    if start.is_some() || !begins_straight {
        return Checker::new(robot, start, budget).run(path);
    }
    let mut best: Option<RobotCheck> = None;
    for start in survey::starts(robot, path, budget)? {
        let found = Checker::new(robot, Some(start), budget).run(path)?;
        if found.passes() {
            return Ok(found);
        }
        if best.as_ref().is_none_or(|best| gets_further(&found, best)) {
            best = Some(found);
        }
    }
    best.map_or_else(|| Checker::new(robot, None, budget).run(path), Ok)
}

/// Whether a failed check has failed less, or at least later, than another one.
fn gets_further(a: &RobotCheck, b: &RobotCheck) -> bool {
    let key =
        |check: &RobotCheck| (check.reachable, check.freedom, check.first_fault.map(|first| first.step));
    key(a) > key(b)
}

/// What one instant costs of a budget, in steps: it takes about a third of a microsecond.
const INSTANT_STEPS: u64 = 100;

/// Why a step does not go on.
enum Halt {
    Fault(Fault),
    Finding(Finding),
}

impl From<Lost> for Halt {
    fn from(lost: Lost) -> Self {
        Self::Fault(lost.into())
    }
}

impl From<Fault> for Halt {
    fn from(fault: Fault) -> Self {
        Self::Fault(fault)
    }
}

impl From<Finding> for Halt {
    fn from(finding: Finding) -> Self {
        Self::Finding(finding)
    }
}

/// The worst excess of a kind within a step: how much, when, and what.
type Worst = Option<(f64, f64, Fault)>;

struct Checker<'a> {
    robot: &'a Robot,
    budget: &'a Budget<'a>,
    /// Where the arm is, if that is known.
    now: Option<Joints>,
    time_s: f64,
    beyond: Worst,
    too_fast: Worst,
    curve: Curve,
    result: RobotCheck,
}

impl<'a> Checker<'a> {
    fn new(robot: &'a Robot, now: Option<Joints>, budget: &'a Budget<'a>) -> Self {
        let result = RobotCheck { reachable: true, freedom: 1.0, ..RobotCheck::default() };
        let curve = Curve::default();
        Self { robot, budget, now, time_s: 0.0, beyond: None, too_fast: None, curve, result }
    }

    fn run(mut self, path: &[PathStep]) -> Result<RobotCheck, Finding> {
        for (index, step) in path.iter().enumerate() {
            (self.beyond, self.too_fast) = (None, None);
            let halt = match self.take(&step.motion) {
                Ok(()) => None,
                Err(Halt::Fault(fault)) => Some(fault),
                Err(Halt::Finding(finding)) => return Err(finding),
            };
            self.note(index, step.place, halt);
            if halt.is_some() {
                break;
            }
        }
        self.result.curve = self.curve.finish();
        Ok(self.result)
    }

    /// Keeps the first fault of all: of a step's, what ends the check first, then limits, then speeds.
    fn note(&mut self, step: usize, place: Place, halt: Option<Fault>) {
        let ended = halt.map(|fault| (0.0, self.time_s, fault));
        let Some((_, time_s, fault)) = ended.or(self.beyond).or(self.too_fast) else { return };
        self.result.reachable &= !fault.is_of_place();
        if self.result.first_fault.is_none() {
            self.result.first_fault = Some(FirstFault { place, step, time_s, fault });
        }
        if ended.is_some() {
            self.result.freedom = f64::NEG_INFINITY;
        }
        if let Fault::Singular { margin_deg, .. } = fault {
            lower(&mut self.result.min_singularity_margin, margin_deg);
        }
    }

    fn take(&mut self, motion: &Motion) -> Result<(), Halt> {
        match motion {
            Motion::Axes(joints) => self.axes(*joints),
            Motion::AxesToPose(pose) => {
                let joints = self.way_to(pose)?;
                self.axes(joints)
            }
            Motion::Straight { from, to, duration_s } => self.straight(from, to, *duration_s),
        }
    }

    fn axes(&mut self, joints: Joints) -> Result<(), Halt> {
        if !joints.iter().all(|joint| joint.is_finite()) {
            return Err(Fault::NotFinite.into());
        }
        self.budget.spend(INSTANT_STEPS)?;
        self.time_s += self.now.map_or(0.0, |now| self.robot.axes_duration_s(&now, &joints));
        self.now = Some(joints);
        self.see_joints(&joints, self.time_s);
        Ok(())
    }

    fn way_to(&mut self, pose: &Pose) -> Result<Joints, Fault> {
        if !is_finite(pose) {
            return Err(Fault::NotFinite);
        }
        let kinematics = &self.robot.kinematics;
        let flange = self.robot.flange(pose);
        let near = self.now.unwrap_or(self.robot.home);
        let stance = kinematics.stance(&near);
        let clear = SingularityMargins::of(kinematics, &stance).smallest().1 > SINGULAR_DEG;
        let ways = ways(kinematics, &flange, &near);
        let same = ways.iter().find(|(branch, _)| clear && self.now.is_some() && *branch == stance.branch());
        let way = same.or(ways.first()).map(|(_, joints)| *joints);
        way.ok_or_else(|| unreachable(kinematics, &flange, &near))
    }

    fn straight(&mut self, from: &Pose, to: &Pose, duration_s: f64) -> Result<(), Halt> {
        if !(is_finite(from) && is_finite(to) && duration_s.is_finite()) {
            return Err(Fault::NotFinite.into());
        }
        let now = self
            .now
            .ok_or_else(|| unreachable(&self.robot.kinematics, &self.robot.flange(from), &self.robot.home))?;
        self.result.start.get_or_insert(now);
        self.refuse_gap(&now, from)?;
        let Some(travel) = self.travel(from, to, duration_s)? else { return Ok(()) };
        let robot = self.robot;
        let mut follower = Follower::new(&robot.arm, &robot.kinematics, now);
        // The end first: a pose out of reach is said to be that, and not a singularity on the way to it.
        let (end, _) = travel.at(travel.duration_s());
        robot.kinematics.solve(&end, follower.branch(), 0.0).map_err(Lost::Unreachable)?;
        let began_s = self.time_s;
        follower.follow::<Halt>(&travel, |instant| {
            self.budget.spend(INSTANT_STEPS)?;
            self.see(instant, began_s + instant.seconds);
            Ok(())
        })?;
        self.now = Some(*follower.joints());
        Ok(())
    }

    /// Nothing where nothing moves.
    fn travel(&self, from: &Pose, to: &Pose, duration_s: f64) -> Result<Option<Travel>, Fault> {
        if from == to {
            return Ok(None);
        }
        if duration_s <= 0.0 {
            return Err(Fault::NoDuration);
        }
        let deg = travel::turn(&from.rotation, &to.rotation).1.to_degrees();
        if deg > 180.0 - HALF_TURN_DEG {
            return Err(Fault::HalfTurn { deg });
        }
        let Robot { kinematics, tool, base, .. } = self.robot;
        Ok(Some(Travel::new(kinematics, tool, base, (from, to), duration_s)))
    }

    fn refuse_gap(&self, now: &Joints, from: &Pose) -> Result<(), Fault> {
        let tip = self.robot.tip(now);
        let mm = (tip.translation.vector - from.translation.vector).norm();
        let deg = travel::turn(&tip.rotation, &from.rotation).1.to_degrees();
        // Whatever compares with nothing is a gap.
        if mm <= PATH_GAP_MM && deg <= PATH_GAP_DEG { Ok(()) } else { Err(Fault::Gap { mm, deg }) }
    }

    fn see(&mut self, instant: &Instant, time_s: f64) {
        self.time_s = time_s;
        self.see_joints(&instant.joints, time_s);
        self.see_rates(&instant.rates, time_s);
        self.see_singularities(&instant.singularities);
    }

    fn see_joints(&mut self, joints: &Joints, time_s: f64) {
        self.curve.push(JointSample { time_s, joints: *joints });
        self.result.instants += 1;
        for (i, margin) in limit_margins(&self.robot.arm, joints).into_iter().enumerate() {
            let joint = &self.robot.arm.joints[i];
            lower(&mut self.result.min_joint_margin_deg, margin);
            let half = 0.5 * (joint.max_deg - joint.min_deg);
            self.result.freedom = self.result.freedom.min(margin / half);
            if margin < -JOINT_SLACK && self.beyond.is_none_or(|(worst, ..)| -margin > worst) {
                let limit_deg = if joints[i] < joint.min_deg { joint.min_deg } else { joint.max_deg };
                let fault = Fault::JointLimit { joint: i + 1, at_deg: joints[i], limit_deg };
                self.beyond = Some((-margin, time_s, fault));
            }
        }
    }

    fn see_rates(&mut self, rates: &[f64; 6], time_s: f64) {
        for (i, &needed_deg_s) in rates.iter().enumerate() {
            let allowed_deg_s = self.robot.arm.joints[i].max_speed_deg_s;
            let ratio = needed_deg_s / allowed_deg_s;
            if ratio > self.result.max_joint_speed_ratio {
                (self.result.max_joint_speed_ratio, self.result.fastest_joint) = (ratio, i + 1);
                self.result.freedom = self.result.freedom.min(1.0 - ratio);
            }
            if ratio > 1.0 + JOINT_SLACK && self.too_fast.is_none_or(|(worst, ..)| ratio > worst) {
                let fault = Fault::JointSpeed { joint: i + 1, needed_deg_s, allowed_deg_s };
                self.too_fast = Some((ratio, time_s, fault));
            }
        }
    }

    fn see_singularities(&mut self, margins: &SingularityMargins) {
        let (_, smallest) = margins.smallest();
        lower(&mut self.result.min_singularity_margin, smallest);
        self.result.freedom = self.result.freedom.min(smallest.to_radians().sin());
        let so_far = self.result.singularities.get_or_insert(*margins);
        so_far.wrist_deg = so_far.wrist_deg.min(margins.wrist_deg);
        so_far.elbow_deg = so_far.elbow_deg.min(margins.elbow_deg);
        so_far.shoulder_mm = so_far.shoulder_mm.min(margins.shoulder_mm);
        so_far.shoulder_deg = so_far.shoulder_deg.min(margins.shoulder_deg);
    }
}

fn lower(least: &mut Option<f64>, value: f64) {
    *least = Some(least.map_or(value, |least| least.min(value)));
}

fn is_finite(pose: &Pose) -> bool {
    let place = pose.translation.vector.iter();
    place.chain(pose.rotation.coords.iter()).all(|number| number.is_finite())
}

/// By how little a pose of the flange is out of reach that no branch reaches.
fn unreachable(kinematics: &Kinematics, flange: &Pose, near: &Joints) -> Fault {
    let misses = Branch::ALL.into_iter().filter_map(|branch| kinematics.inverse(flange, branch, near).err());
    let least = misses.min_by(|a, b| a.by_mm().total_cmp(&b.by_mm()));
    Lost::Unreachable(least.unwrap_or(Unreachable::NotFinite)).into()
}
