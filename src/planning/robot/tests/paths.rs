//! Paths followed on one branch: nothing between two instants is missed, and nothing bad passes.

use nalgebra::{Translation3, UnitQuaternion, Vector3};
use rstest::rstest;

use super::{Numbers, arm, steps};
use crate::planning::budget::Budget;
use crate::planning::finding::Code;
use crate::planning::geometry::frame::{Frame, Pose};
use crate::planning::program::robot_moves::Joints;
use crate::planning::robot::base_search::propose;
use crate::planning::robot::branch::{
    Follower, Instant, Lost, Singularity, SingularityMargins, change, limit_margins, unwound,
};
use crate::planning::robot::check::{Motion, PathStep, Robot, RobotCheck, check};
use crate::planning::robot::fault::{Fault, Place};
use crate::planning::robot::kinematics::Unreachable;
use crate::planning::robot::travel::{Travel, duration_s};
use crate::planning::tolerance::JOINT_STEP_DEG;

const HOME: Joints = [0.0, -90.0, 90.0, 0.0, 0.0, 0.0];
/// Well within everything.
const EASY: Joints = [10.0, -90.0, 110.0, 20.0, 60.0, -30.0];

fn robot(name: &str) -> Robot {
    let tool = Frame { x_mm: 20.0, z_mm: 300.0, b_deg: 30.0, ..Frame::default() };
    let base = Frame { x_mm: 1500.0, y_mm: -40.0, z_mm: 800.0, a_deg: 90.0, b_deg: 5.0, c_deg: 0.0 };
    Robot::new(arm(name), tool.pose(), base.pose(), HOME).unwrap()
}

fn checked(robot: &Robot, start: Option<Joints>, path: &[PathStep]) -> RobotCheck {
    check(robot, start, path, &Budget::unwatched()).unwrap()
}

fn step(motion: Motion) -> PathStep {
    PathStep { place: Place { file: 2, line: 34 }, motion }
}

fn line(from: Pose, to: Pose) -> PathStep {
    step(Motion::Straight { from, to, duration_s: duration_s(&from, &to, 200.0, 90.0) })
}

/// A pose moved by mm in the part's frame and turned by degrees about its own axes.
fn moved(pose: &Pose, mm: [f64; 3], turn_deg: [f64; 3]) -> Pose {
    let turn = UnitQuaternion::from_scaled_axis(Vector3::from(turn_deg.map(f64::to_radians)));
    Translation3::from(Vector3::from(mm)) * pose * turn
}

fn random_travel(numbers: &mut Numbers, robot: &Robot, joints: &Joints) -> (Pose, Pose, f64) {
    let from = robot.tip(joints);
    let mut three = |most: f64| std::array::from_fn(|_| numbers.between(-most, most));
    let to = moved(&from, three(400.0), three(90.0));
    (from, to, duration_s(&from, &to, 200.0, 90.0))
}

fn travel(robot: &Robot, (from, to, seconds): &(Pose, Pose, f64)) -> Travel {
    Travel::new(robot.kinematics(), robot.tool(), robot.base(), (from, to), *seconds)
}

fn instants(robot: &Robot, joints: Joints, travel: &Travel) -> Result<Vec<Instant>, Lost> {
    let mut seen = Vec::new();
    Follower::new(robot.arm(), robot.kinematics(), joints).follow::<Lost>(travel, |instant| {
        seen.push(*instant);
        Ok(())
    })?;
    Ok(seen)
}

#[test]
fn instants_follow_each_other_closely_and_each_has_the_pose_of_its_time() {
    let mut numbers = Numbers(11);
    let robot = robot("kr210-r3100-2");
    let mut followed = 0;
    for _ in 0..60 {
        let joints = numbers.joints(robot.arm());
        let ends = random_travel(&mut numbers, &robot, &joints);
        let Ok(seen) = instants(&robot, joints, &travel(&robot, &ends)) else { continue };
        followed += 1;
        assert!(change(&seen[0].joints, &joints) < 1e-6, "it begins where it is");
        assert!((seen[seen.len() - 1].seconds - ends.2).abs() < 1e-12);
        for pair in seen.windows(2) {
            assert!(change(&pair[0].joints, &pair[1].joints) <= JOINT_STEP_DEG);
        }
        for instant in &seen {
            let share = instant.seconds / ends.2;
            let rotation = ends.0.rotation.slerp(&ends.1.rotation, share);
            let place = ends.0.translation.vector.lerp(&ends.1.translation.vector, share);
            let wanted = Pose::from_parts(place.into(), rotation);
            let tip = robot.tip(&instant.joints);
            assert!((tip.to_homogeneous() - wanted.to_homogeneous()).amax() < 1e-9, "{instant:?}");
        }
    }
    assert!(followed > 25, "{followed} of 60 could be followed");
}

/// The step rule: a look twenty times as close finds nothing that it has missed.
#[test]
fn a_far_closer_look_finds_nothing_that_was_missed() {
    let mut numbers = Numbers(12);
    let robot = robot("kr210-r2700-2");
    let (mut followed, mut near) = (0, 0);
    for _ in 0..60 {
        // Near a straight wrist, where axes 4 and 6 peak.
        let mut joints = numbers.joints(robot.arm());
        joints[4] = numbers.between(0.5, 40.0);
        let ends = random_travel(&mut numbers, &robot, &joints);
        let travel = travel(&robot, &ends);
        let Ok(seen) = instants(&robot, joints, &travel) else { continue };
        followed += 1;
        let closer = closely(&robot, joints, &travel, seen.len() * 20);
        near += usize::from(closer.wrist_deg < 5.0);
        let seen = seen.iter().map(|instant| Extremes::of(&robot, instant)).reduce(Extremes::and).unwrap();
        assert!(
            seen.ratio > 0.99 * closer.ratio,
            "{} for {} at {} deg",
            seen.ratio,
            closer.ratio,
            closer.wrist_deg
        );
        let limit_missed = seen.margin_deg - closer.margin_deg;
        // Far from limits nothing is at stake; near them the steps are finer.
        assert!(limit_missed < if closer.margin_deg < 0.5 && closer.margin_deg > 0.0 { 0.1 } else { 2.5 });
        assert!(seen.wrist_deg - closer.wrist_deg < 0.05 * closer.wrist_deg, "{}", closer.wrist_deg);
    }
    assert!(followed > 20 && near > 5, "{followed} followed, {near} of them near a straight wrist");
}

#[derive(Debug, Clone, Copy)]
struct Extremes {
    ratio: f64,
    margin_deg: f64,
    wrist_deg: f64,
}

impl Extremes {
    fn of(robot: &Robot, instant: &Instant) -> Self {
        let ratio = |i: usize| instant.rates[i] / robot.arm().joints[i].max_speed_deg_s;
        Self {
            ratio: (0..6).map(ratio).fold(0.0, f64::max),
            margin_deg: limit_margins(robot.arm(), &instant.joints).into_iter().fold(f64::INFINITY, f64::min),
            wrist_deg: instant.singularities.wrist_deg,
        }
    }

    fn and(self, other: Self) -> Self {
        Self {
            ratio: self.ratio.max(other.ratio),
            margin_deg: self.margin_deg.min(other.margin_deg),
            wrist_deg: self.wrist_deg.min(other.wrist_deg),
        }
    }
}

/// The same travel in even steps, its speeds by differences.
fn closely(robot: &Robot, joints: Joints, travel: &Travel, count: usize) -> Extremes {
    let kinematics = robot.kinematics();
    let branch = kinematics.stance(&joints).branch();
    let step = travel.duration_s() / count as f64;
    let mut before = joints;
    let mut all: Option<Extremes> = None;
    for index in 0..=count {
        let (target, _) = travel.at(step * index as f64);
        let stance = kinematics.solve(&target, branch, 0.0).unwrap();
        let joints = unwound(&kinematics.joints(&stance), &before);
        let rates =
            std::array::from_fn(|i| if index == 0 { 0.0 } else { (joints[i] - before[i]).abs() / step });
        let singularities = SingularityMargins::of(kinematics, &stance);
        let now = Extremes::of(robot, &Instant { seconds: 0.0, joints, rates, singularities });
        all = Some(all.map_or(now, |all| all.and(now)));
        before = joints;
    }
    all.unwrap()
}

#[test]
fn a_path_that_turns_more_than_once_is_wound_on_and_begins_where_it_fits() {
    let robot = robot("kr210-r3100-2");
    let pose = robot.tip(&EASY);
    // Six turns by 100 degrees about the flange's own axis: A6 goes through 600 of its 700 degrees.
    let flange_turn = |deg: f64| {
        let turn = Frame { a_deg: deg, ..Frame::default() }.pose();
        pose * robot.tool().inverse() * turn * robot.tool()
    };
    let poses: Vec<_> = (0..=6).map(|i| flange_turn(100.0 * f64::from(i))).collect();
    let found = checked(&robot, None, &steps(&poses));
    assert!(found.passes(), "{:?}", found.first_fault);
    let (first, last) = (found.curve[0].joints, found.curve[found.curve.len() - 1].joints);
    assert!(((first[5] - last[5]).abs() - 600.0).abs() < 1e-6, "{first:?} to {last:?}");
    // From where A6 is at -30 it has not so far to go.
    let found = checked(&robot, Some(EASY), &steps(&poses));
    let first = found.first_fault.unwrap();
    assert!(matches!(first.fault, Fault::JointLimit { joint: 6, .. }), "{first:?}");
    assert_eq!((first.step, found.reachable), (3, false));
    // Seven such turns do not fit at all.
    let poses: Vec<_> = (0..=8).map(|i| flange_turn(100.0 * f64::from(i))).collect();
    assert!(!checked(&robot, None, &steps(&poses)).reachable);
}

#[test]
fn a_program_is_checked_from_its_first_joints_on() {
    let robot = robot("kr210-l150");
    let (from, mut near) = (robot.tip(&EASY), EASY);
    near[0] += 5.0;
    let to = robot.tip(&near);
    let path = [
        step(Motion::Axes(HOME)),
        step(Motion::Axes(EASY)),
        line(from, to),
        step(Motion::AxesToPose(from)),
        line(from, to),
        step(Motion::Axes(HOME)),
    ];
    let found = checked(&robot, None, &path);
    assert!(found.passes(), "{:?}", found.first_fault);
    assert_eq!(found.start, Some(EASY));
    // A straight wrist at home is no fault: no straight move goes there.
    assert!(found.min_singularity_margin.unwrap() > 20.0);
    assert_eq!(found.curve[found.curve.len() - 1].joints, HOME);
    assert!(found.curve.windows(2).all(|pair| pair[0].time_s <= pair[1].time_s));
}

#[test]
fn joints_beyond_a_limit_are_a_fault_with_the_amount() {
    let robot = robot("kr210-r3100-2");
    let mut joints = HOME;
    joints[1] = -2.0;
    let path = [step(Motion::Axes(HOME)), step(Motion::Axes(joints))];
    let found = checked(&robot, None, &path);
    let first = found.first_fault.unwrap();
    assert_eq!(first.fault, Fault::JointLimit { joint: 2, at_deg: -2.0, limit_deg: -5.0 });
    assert_eq!((first.step, first.place), (1, Place { file: 2, line: 34 }));
    assert_eq!((found.reachable, found.min_joint_margin_deg), (false, Some(-3.0)));
}

#[test]
fn a_limit_crossed_only_in_the_middle_of_a_move_is_seen() {
    let mut arm = arm("kr210-r3100-2");
    let robot = robot("kr210-r3100-2");
    // Sideways past the foot: the elbow is most bent halfway.
    let pose = robot.tip(&[0.0, -90.0, 120.0, 10.0, 60.0, 0.0]);
    let (from, to) = (moved(&pose, [-300.0, 0.0, 0.0], [0.0; 3]), moved(&pose, [300.0, 0.0, 0.0], [0.0; 3]));
    let a3 = |found: &RobotCheck| found.curve.iter().map(|sample| sample.joints[2]).collect::<Vec<_>>();
    let free = checked(&robot, None, &[line(from, to)]);
    let highest = a3(&free).into_iter().fold(f64::MIN, f64::max);
    let ends = a3(&free)[0].max(*a3(&free).last().unwrap());
    assert!(highest > ends + 0.5, "{highest} {ends}");
    arm.joints[2].max_deg = highest - 0.15;
    let tight = Robot::new(arm, *robot.tool(), *robot.base(), HOME).unwrap();
    let found = checked(&tight, free.start, &[line(from, to)]);
    assert!(matches!(found.first_fault.unwrap().fault, Fault::JointLimit { joint: 3, .. }));
}

#[test]
fn a_path_through_a_straight_wrist_ends_there_and_says_so() {
    let robot = robot("kr210-r3100-2");
    let mut after = EASY;
    let mut before = EASY;
    (before[3], before[4]) = (0.0, 10.0);
    (after[3], after[4]) = (0.0, -10.0);
    let path = [step(Motion::Axes(before)), line(robot.tip(&before), robot.tip(&after))];
    let found = checked(&robot, None, &path);
    let first = found.first_fault.unwrap();
    assert!(matches!(first.fault, Fault::Singular { singularity: Singularity::Wrist, .. }), "{first:?}");
    assert!(found.min_singularity_margin.unwrap() < 0.1 && !found.reachable);
    assert!(first.fault.to_string().contains("wrist"), "{}", first.fault);
    // Beside it the path can be followed, and axis 4 is far too fast.
    before[3] = 0.2;
    let beside = moved(&robot.tip(&after), [0.0; 3], [0.0, 0.0, 0.0]);
    let aside = moved(&beside, [3.0, 3.0, 3.0], [0.5, 0.5, 0.0]);
    let found = checked(&robot, Some(before), &[line(robot.tip(&before), aside)]);
    assert!(found.max_joint_speed_ratio > 5.0, "{found:?}");
}

#[test]
fn a_path_that_leaves_the_reach_says_by_how_much() {
    let robot = robot("kr210-r2700-2");
    let from = robot.tip(&EASY);
    let to = moved(&from, [0.0, -3_000.0, 0.0], [0.0; 3]);
    let found = checked(&robot, None, &[line(from, to)]);
    let first = found.first_fault.unwrap();
    assert!(
        matches!(first.fault, Fault::OutOfReach(Unreachable::TooFar { by_mm }) if by_mm > 500.0),
        "{first:?}"
    );
    assert!(!found.reachable && found.start.is_some());
    // From a place out of reach there is no beginning either.
    let found = checked(&robot, None, &[line(to, from)]);
    assert!(matches!(found.first_fault.unwrap().fault, Fault::OutOfReach(_)), "{found:?}");
    assert_eq!((found.start, found.min_joint_margin_deg, found.min_singularity_margin), (None, None, None));
    let found = checked(&robot, None, &[step(Motion::AxesToPose(to))]);
    assert!(matches!(found.first_fault.unwrap().fault, Fault::OutOfReach(_)), "{found:?}");
}

#[rstest]
#[case::nan_place([f64::NAN, 0.0, 0.0], 1.0)]
#[case::endless_place([f64::INFINITY, 0.0, 0.0], 1.0)]
#[case::nan_duration([1.0, 0.0, 0.0], f64::NAN)]
#[case::endless_duration([1.0, 0.0, 0.0], f64::INFINITY)]
fn what_is_not_finite_never_passes(#[case] mm: [f64; 3], #[case] duration_s: f64) {
    let robot = robot("kr210-r3100-2");
    let from = robot.tip(&EASY);
    let to = Pose::from_parts((from.translation.vector + Vector3::from(mm)).into(), from.rotation);
    let good = line(from, moved(&from, [5.0, 0.0, 0.0], [0.0; 3]));
    let bad = step(Motion::Straight { from, to, duration_s });
    for (start, path) in [(None, vec![bad]), (Some(EASY), vec![bad]), (None, vec![good, bad])] {
        let found = checked(&robot, start, &path);
        assert!(!found.reachable && found.first_fault.unwrap().fault == Fault::NotFinite, "{found:?}");
        assert_eq!(propose(&robot, &path, &Budget::unwatched()).unwrap(), None);
    }
}

#[test]
fn joints_and_frames_that_are_not_finite_never_pass() {
    let robot = robot("kr210-r3100-2");
    let mut joints = HOME;
    joints[3] = f64::NAN;
    let found = checked(&robot, None, &[step(Motion::Axes(joints))]);
    assert_eq!(found.first_fault.unwrap().fault, Fault::NotFinite);
    let from = robot.tip(&EASY);
    let good = line(from, moved(&from, [5.0, 0.0, 0.0], [0.0; 3]));
    assert!(!checked(&robot, Some(joints), &[good]).reachable);
    let nowhere = robot.moved_to(Frame { z_mm: f64::NAN, ..Frame::default() }.pose());
    assert!(!checked(&nowhere, None, &[good]).reachable);
    assert_eq!(propose(&nowhere, &[good], &Budget::unwatched()).unwrap(), None);
    let far = robot.moved_to(Frame { z_mm: 1e300, ..Frame::default() }.pose());
    assert!(!checked(&far, None, &[good]).reachable);
    assert_eq!(propose(&far, &[good], &Budget::unwatched()).unwrap(), None);
}

#[test]
fn a_move_in_no_time_a_gap_and_half_a_turn_are_refused() {
    let robot = robot("kr210-r3100-2");
    let from = robot.tip(&EASY);
    let to = moved(&from, [5.0, 0.0, 0.0], [0.0; 3]);
    let fault = |path: &[PathStep]| checked(&robot, Some(EASY), path).first_fault.map(|first| first.fault);
    let in_no_time = |duration_s| [step(Motion::Straight { from, to, duration_s })];
    assert_eq!(fault(&in_no_time(0.0)), Some(Fault::NoDuration));
    assert_eq!(fault(&in_no_time(-1.0)), Some(Fault::NoDuration));
    assert!(matches!(fault(&[line(to, from)]), Some(Fault::Gap { mm, .. }) if (mm - 5.0).abs() < 1e-6));
    let half = moved(&from, [0.0; 3], [0.0, 0.0, 180.0]);
    assert!(matches!(fault(&[line(from, half)]), Some(Fault::HalfTurn { .. })));
    // Nothing that moves needs no time.
    assert_eq!(fault(&[step(Motion::Straight { from, to: from, duration_s: 0.0 })]), None);
    assert_eq!(fault(&[]), None);
    assert_eq!(propose(&robot, &[], &Budget::unwatched()).unwrap(), None);
}

#[test]
fn a_budget_ends_the_check() {
    let robot = robot("kr210-r3100-2");
    let from = robot.tip(&EASY);
    let path = [line(from, moved(&from, [5.0, 0.0, 0.0], [0.0; 3]))];
    let cancelled = std::sync::atomic::AtomicBool::new(false);
    let budget = Budget::new(1_000, &cancelled, &|_| {});
    assert_eq!(check(&robot, None, &path, &budget).unwrap_err().code, Code::BudgetSpent);
    let budget = Budget::new(1_000, &cancelled, &|_| {});
    assert_eq!(propose(&robot, &path, &budget).unwrap_err().code, Code::BudgetSpent);
}
