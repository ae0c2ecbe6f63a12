//! Forward and inverse kinematics against a second formulation, against each other, and against another solver.

use nalgebra::{Isometry3, Point3, Translation3, Unit, UnitQuaternion, Vector3};
use rs_opw_kinematics::kinematic_traits::Kinematics as _;
use rstest::rstest;

use super::{Numbers, arm, oracle, their_pose};
use crate::planning::geometry::frame::{Frame, Pose};
use crate::planning::robot::arm::{Arm, Catalogue};
use crate::planning::robot::branch::{Branch, SingularityMargins, change, unwound, ways};
use crate::planning::robot::kinematics::{Kinematics, Target, Twist, Unreachable};

const TEST_POSE: [f64; 6] = [10.0, -80.0, 95.0, 20.0, 40.0, -30.0];

/// The flange by a product of exponentials (Brockett 1984): each joint turns all that is beyond it about its own line,
/// given where the arm stands straight up.
fn by_screws(arm: &Arm, joints: &[f64; 6]) -> Pose {
    let g = &arm.geometry;
    let before = g.a1_mm + g.a2_mm;
    let lines = [
        (Vector3::z_axis(), Point3::origin()),
        (Vector3::y_axis(), Point3::new(g.a1_mm, 0.0, g.c1_mm)),
        (Vector3::y_axis(), Point3::new(g.a1_mm, 0.0, g.c1_mm + g.c2_mm)),
        (Vector3::z_axis(), Point3::new(before, g.b_mm, 0.0)),
        (Vector3::y_axis(), Point3::new(before, 0.0, g.c1_mm + g.c2_mm + g.c3_mm)),
        (Vector3::z_axis(), Point3::new(before, g.b_mm, 0.0)),
    ];
    let upright = Translation3::new(before, g.b_mm, g.c1_mm + g.c2_mm + g.c3_mm + g.c4_mm);
    let screw = |i: usize| -> Pose {
        let joint = &arm.joints[i];
        let (axis, point): (Unit<Vector3<f64>>, Point3<f64>) = lines[i];
        let angle = (f64::from(joint.sign) * joints[i] - joint.offset_deg).to_radians();
        let turn = UnitQuaternion::from_axis_angle(&axis, angle);
        Translation3::from(point) * turn * Translation3::from(-point.coords)
    };
    (0..6).map(screw).fold(Isometry3::identity(), |all, one| all * one) * upright
}

/// Largest difference of two poses: mm, and rad of their axes.
fn difference(a: &Pose, b: &Pose) -> f64 {
    (a.to_homogeneous() - b.to_homogeneous()).amax()
}

/// An arm of random lengths, signs and offsets, its plane beside axis 1.
fn odd_arm(numbers: &mut Numbers) -> Arm {
    let mut arm = arm("kr210-r3100-2");
    arm.geometry.a1_mm = numbers.between(-100.0, 500.0);
    arm.geometry.a2_mm = numbers.between(-200.0, 200.0);
    arm.geometry.b_mm = numbers.between(-150.0, 150.0);
    arm.geometry.c2_mm = numbers.between(500.0, 1500.0);
    arm.geometry.c3_mm = numbers.between(500.0, 1500.0);
    arm.geometry.c4_mm = numbers.between(0.0, 300.0);
    for joint in &mut arm.joints {
        joint.sign = if numbers.next() < 0.5 { 1 } else { -1 };
        joint.offset_deg = numbers.between(-180.0, 180.0);
        (joint.min_deg, joint.max_deg) = (-350.0, 350.0);
    }
    arm
}

fn arms(numbers: &mut Numbers) -> Vec<Arm> {
    let catalogue = Catalogue::built_in();
    let built_in: Vec<_> = catalogue.names().map(|name| catalogue.get(name).unwrap().clone()).collect();
    built_in.into_iter().chain((0..8).map(|_| odd_arm(numbers))).collect()
}

fn smallest_margin(kinematics: &Kinematics, joints: &[f64; 6]) -> f64 {
    SingularityMargins::of(kinematics, &kinematics.stance(joints)).smallest().1
}

#[rstest]
#[case::r3100("kr210-r3100-2", [2064.715, -417.642, 1530.439])]
#[case::r2700("kr210-r2700-2", [1826.849, -370.119, 1404.784])]
fn the_test_poses_of_the_sources(#[case] name: &str, #[case] place: [f64; 3]) {
    let frame = Frame::of(&Kinematics::new(&arm(name)).forward(&TEST_POSE));
    for (found, wanted) in [frame.x_mm, frame.y_mm, frame.z_mm].into_iter().zip(place) {
        assert!((found - wanted).abs() < 1e-3, "{frame:?}");
    }
    for (found, wanted) in
        [frame.a_deg, frame.b_deg, frame.c_deg].into_iter().zip([151.9005, 38.5553, -178.4151])
    {
        assert!((found - wanted).abs() < 1e-3, "{frame:?}");
    }
}

#[test]
fn the_home_of_a_kr_210_is_a_level_forearm() {
    let pose = Kinematics::new(&arm("kr210-r3100-2")).forward(&[0.0, -90.0, 90.0, 0.0, 0.0, 0.0]);
    // a1 + c3 + c4 before axis 1; c1 + c2 - a2 high; the flange looks along X.
    assert!((pose.translation.vector - Vector3::new(1990.0, 0.0, 2110.0)).norm() < 1e-9, "{pose}");
    assert!((pose * Vector3::z() - Vector3::x()).norm() < 1e-12);
}

#[test]
fn forward_is_the_product_of_exponentials() {
    let mut numbers = Numbers(1);
    for arm in arms(&mut numbers) {
        let kinematics = Kinematics::new(&arm);
        for _ in 0..500 {
            let joints = numbers.joints(&arm);
            let worst = difference(&kinematics.forward(&joints), &by_screws(&arm, &joints));
            assert!(worst < 1e-9, "{}: {joints:?} differ by {worst:e}", arm.name);
        }
    }
}

#[test]
fn every_way_to_stand_gives_the_pose_again_and_one_of_them_is_the_one_it_came_from() {
    let mut numbers = Numbers(2);
    for arm in arms(&mut numbers) {
        let kinematics = Kinematics::new(&arm);
        for _ in 0..500 {
            let joints = numbers.joints(&arm);
            let flange = kinematics.forward(&joints);
            let ways = ways(&kinematics, &flange, &joints);
            for (branch, way) in &ways {
                let worst = difference(&kinematics.forward(way), &flange);
                assert!(worst < 1e-9, "{}: {joints:?} on {branch:?}: {worst:e}", arm.name);
            }
            let own = ways.iter().find(|(branch, _)| *branch == kinematics.stance(&joints).branch()).unwrap();
            // A joint's last digits are lost in proportion to the nearness of a singularity.
            let lost = 1e-9 / smallest_margin(&kinematics, &joints).to_radians().sin().min(0.01) * 0.01;
            assert!(change(&own.1, &joints) < lost, "{}: {joints:?} came back as {:?}", arm.name, own.1);
            assert_eq!(own.1, ways[0].1, "the nearest way is the way itself");
        }
    }
}

#[test]
fn the_eight_ways_stand_on_eight_branches() {
    let kinematics = Kinematics::new(&arm("kr210-r3100-2"));
    let joints = [10.0, -110.0, 120.0, 20.0, 40.0, -30.0];
    let ways = ways(&kinematics, &kinematics.forward(&joints), &joints);
    let mut branches: Vec<_> = ways.iter().map(|(branch, _)| *branch).collect();
    for (branch, way) in &ways {
        assert_eq!(kinematics.stance(way).branch(), *branch);
    }
    branches.sort();
    assert_eq!(branches, Branch::ALL);
}

/// Another solver, written by others: the same solutions, no more and no fewer.
#[test]
fn an_independent_solver_finds_the_same_ways() {
    let mut numbers = Numbers(3);
    for arm in arms(&mut numbers) {
        let (kinematics, oracle) = (Kinematics::new(&arm), oracle(&arm));
        for _ in 0..200 {
            let joints = numbers.joints(&arm);
            if smallest_margin(&kinematics, &joints) < 0.1 {
                continue;
            }
            let flange = kinematics.forward(&joints);
            let theirs = oracle.inverse(&their_pose(&flange));
            let ours = ways(&kinematics, &flange, &joints);
            assert_eq!(ours.len(), theirs.len(), "{}: {joints:?}", arm.name);
            for their in theirs {
                let their = unwound(&their.map(f64::to_degrees), &joints);
                let nearest = ours.iter().map(|(_, way)| change(&unwound(way, &their), &their));
                let nearest = nearest.fold(f64::INFINITY, f64::min);
                assert!(nearest < 1e-5, "{}: {their:?} is {nearest:e} from any of ours", arm.name);
            }
        }
    }
}

/// Central differences of a motion with given joint rates: what its twist gives back.
#[test]
fn rates_are_the_derivative_of_the_path() {
    let mut numbers = Numbers(4);
    for arm in arms(&mut numbers) {
        let kinematics = Kinematics::new(&arm);
        for _ in 0..200 {
            let joints = numbers.joints(&arm);
            if smallest_margin(&kinematics, &joints) < 2.0 {
                continue;
            }
            let rates: [f64; 6] = std::array::from_fn(|_| numbers.between(-1.0, 1.0));
            let (before, after) =
                (moved(&kinematics, &joints, &rates, -1e-5), moved(&kinematics, &joints, &rates, 1e-5));
            let stance = kinematics.stance(&joints);
            let turn = (after.rotation * before.rotation.transpose()
                - before.rotation * after.rotation.transpose())
                * 0.5;
            let twist = Twist {
                wrist: (after.wrist - before.wrist) / 2e-5,
                turn: Vector3::new(turn[(2, 1)], turn[(0, 2)], turn[(1, 0)]) / 2e-5,
            };
            let found = kinematics.rates(&stance, &twist);
            for (i, rate) in found.into_iter().enumerate() {
                assert!((rate - rates[i]).abs() < 1e-5, "{}: {joints:?}: {found:?} for {rates:?}", arm.name);
            }
        }
    }
}

/// The target after `seconds` at model rates in rad/s.
fn moved(kinematics: &Kinematics, joints: &[f64; 6], rates: &[f64; 6], seconds: f64) -> Target {
    let mut stance = kinematics.stance(joints);
    for (angle, rate) in stance.angles.iter_mut().zip(rates) {
        *angle += rate * seconds;
    }
    kinematics.target(&kinematics.forward(&kinematics.joints(&stance)))
}

/// The bound that the step rule stands on: whatever the wrist does at those speeds, no joint goes farther.
#[test]
fn no_joint_goes_farther_than_the_bound() {
    let mut numbers = Numbers(5);
    let (mut tightest, mut bounded) = (0.0_f64, 0);
    for arm in arms(&mut numbers) {
        let kinematics = Kinematics::new(&arm);
        for _ in 0..2000 {
            let joints = numbers.joints(&arm);
            let stance = kinematics.stance(&joints);
            let target = kinematics.target(&kinematics.forward(&joints));
            let (speed, turn) = (numbers.between(0.0, 500.0), numbers.between(0.0, 2.0));
            let seconds = 10.0_f64.powf(numbers.between(-4.0, 0.0));
            let most = kinematics.furthest(&stance, speed, turn, seconds);
            if !most.iter().all(|change| change.is_finite()) {
                continue;
            }
            let direction = |numbers: &mut Numbers| {
                Unit::new_normalize(Vector3::from_fn(|_, _| numbers.between(-1.0, 1.0)))
            };
            let wrist = target.wrist + direction(&mut numbers).into_inner() * speed * seconds;
            let turned = UnitQuaternion::from_axis_angle(&direction(&mut numbers), turn * seconds);
            let there = Target { rotation: turned.to_rotation_matrix().matrix() * target.rotation, wrist };
            let reached = kinematics.solve(&there, stance.branch(), stance.angles[3]).unwrap();
            let now = unwound(&kinematics.joints(&reached), &joints);
            bounded += 1;
            for i in 0..6 {
                let share = (now[i] - joints[i]).abs().to_radians() / most[i];
                assert!(share < 1.0 + 1e-6, "{}: A{} from {joints:?} to {now:?}: {most:?}", arm.name, i + 1);
                tightest = tightest.max(share);
            }
        }
    }
    assert!(bounded > 5_000 && tightest > 0.8, "{bounded} looked at, the tightest at {tightest}");
}

#[test]
fn a_straight_wrist_keeps_its_axis_4_and_gives_the_pose_again() {
    let kinematics = Kinematics::new(&arm("kr210-r3100-2"));
    for a5 in [0.0, 1e-13, 1e-9, -1e-9, 1e-5] {
        let joints = [10.0, -80.0, 95.0, 200.0, a5, -30.0];
        let flange = kinematics.forward(&joints);
        let (_, way) = ways(&kinematics, &flange, &joints)[0];
        assert!(difference(&kinematics.forward(&way), &flange) < 1e-9, "{way:?}");
        if a5.abs() < 1e-12 {
            assert!(change(&way, &joints) < 1e-9, "{way:?}");
        }
    }
}

#[test]
fn joints_of_more_than_one_turn_stay_on_theirs() {
    let near = [0.0, -90.0, 90.0, 340.0, 0.0, -345.0];
    let joints = [5.0, -85.0, 95.0, -15.0, 0.0, 10.0];
    assert_eq!(unwound(&joints, &near), [5.0, -85.0, 95.0, 345.0, 0.0, -350.0]);
}

#[test]
fn a_pose_out_of_reach_says_by_how_much() {
    let kinematics = Kinematics::new(&arm("kr210-r3100-2"));
    let any = Branch::ALL[0];
    let at = |x: f64, z: f64| Frame { x_mm: x, z_mm: z, b_deg: 90.0, ..Frame::default() }.pose();
    // The wrist is c4 behind the flange; the arm reaches c2 + hypot(a2, c3) from (a1, c1).
    let stretched = 1350.0 + 115.0_f64.hypot(1420.0);
    let miss = kinematics.inverse(&at(330.0 + stretched + 240.0 + 12.5, 645.0), any, &[0.0; 6]).unwrap_err();
    assert!(matches!(miss, Unreachable::TooFar { by_mm } if (by_mm - 12.5).abs() < 1e-9), "{miss}");
    let miss = kinematics.inverse(&at(330.0 + 240.0 + 10.0, 645.0), any, &[0.0; 6]).unwrap_err();
    let folded = 115.0_f64.hypot(1420.0) - 1350.0;
    assert!(
        matches!(miss, Unreachable::TooNear { by_mm } if (by_mm - (folded - 10.0)).abs() < 1e-9),
        "{miss}"
    );
    let mut beside = arm("kr210-r3100-2");
    beside.geometry.b_mm = -80.0;
    let miss = Kinematics::new(&beside).inverse(&at(240.0 + 50.0, 1500.0), any, &[0.0; 6]).unwrap_err();
    assert!(matches!(miss, Unreachable::BesideAxis1 { by_mm } if (by_mm - 30.0).abs() < 1e-9), "{miss}");
    for x in [f64::NAN, f64::INFINITY, -f64::INFINITY] {
        let miss = kinematics.inverse(&at(x, 0.0), any, &[0.0; 6]).unwrap_err();
        assert_eq!(miss, Unreachable::NotFinite);
    }
    assert!(kinematics.inverse(&at(1e200, 0.0), any, &[0.0; 6]).is_err());
}
