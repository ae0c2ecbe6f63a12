//! The Table 1 part of Cui et al. 2020 cut by a KR 210: what each arm can follow, and where the part lies.

use nalgebra::{Point3, Translation3};
use rs_opw_kinematics::kinematic_traits::Kinematics as _;
use rstest::rstest;

use super::{arm, oracle, steps, their_pose};
use crate::planning::budget::Budget;
use crate::planning::geometry::frame::{Frame, Pose};
use crate::planning::honeycomb::blade::{Blade, Edges, Feed, Side};
use crate::planning::robot::base_search::propose;
use crate::planning::robot::check::{Motion, PathStep, Robot, RobotCheck, check};
use crate::planning::robot::fault::Fault;
use crate::planning::units::{Angle, Length};

const WIDTH_MM: f64 = 85.0;
const LENGTH_MM: f64 = 50.0;
const HEIGHT_MM: f64 = 50.0;
const SAFE_Z_MM: f64 = HEIGHT_MM + 10.0;

fn blade() -> Blade {
    Blade {
        rake: Angle::from_degrees(60.0),
        half_apex: Angle::from_degrees(7.13),
        max_cutting_length: Length::from_mm(10.0),
        length: Length::from_mm(10.0),
        max_swing: Angle::from_degrees(50.0),
        edges: Edges::Double,
    }
}

/// The tips (x, z) of the orthogonal lattice above the arc of radius 85, layer by layer.
fn layers(spacing: f64, step: f64) -> Vec<Vec<(f64, f64)>> {
    let contour = |x: f64| 16.782_213 - 85.0 + (85.0_f64.powi(2) - (x - 42.5).powi(2)).sqrt();
    let columns = (WIDTH_MM / step).floor() as i32;
    let column = |j: i32| 0.5 * WIDTH_MM + (f64::from(j) - 0.5 * f64::from(columns)) * step;
    let layer = |k: i32| {
        let z = HEIGHT_MM - f64::from(k) * spacing;
        (0..=columns).map(column).filter(|&x| z >= contour(x)).map(|x| (x, z)).collect::<Vec<_>>()
    };
    (1..).map(layer).take_while(|tips| !tips.is_empty()).collect()
}

/// The order of the cuts of a layer.
#[derive(Clone, Copy)]
enum Sequence {
    /// Each tip left out and right back, as published: the blade turns by 88 degrees.
    Paired,
    /// All left cuts to and fro, then all right ones: it turns by 60 degrees about the blade's plane.
    Sweep,
}

fn path(sequence: Sequence, swing_deg: f64, layers: &[Vec<(f64, f64)>]) -> Vec<PathStep> {
    let blade = blade();
    let (near, far) =
        (-blade.extension_mm(swing_deg.to_radians()), LENGTH_MM + blade.extension_mm(swing_deg.to_radians()));
    let pose = |x, y, z, side, feed| blade.pose(Point3::new(x, y, z), side, swing_deg.to_radians(), feed);
    let out = |tip: (f64, f64), side| [near, far].map(|y| pose(tip.0, y, tip.1, side, Feed::Out));
    let back = |tip: (f64, f64), side| [far, near].map(|y| pose(tip.0, y, tip.1, side, Feed::Back));
    let mut poses: Vec<Pose> = Vec::new();
    for tips in layers {
        let (first, last) = (tips[0], tips[tips.len() - 1]);
        poses.push(pose(first.0, near, SAFE_Z_MM, Side::Right, Feed::Back));
        match sequence {
            Sequence::Paired => {
                poses.push(pose(first.0, near, first.1, Side::Right, Feed::Back));
                poses.extend(
                    tips.iter().flat_map(|&tip| [out(tip, Side::Left), back(tip, Side::Right)]).flatten(),
                );
            }
            Sequence::Sweep => {
                for side in [Side::Left, Side::Right] {
                    let cuts = tips.iter().enumerate();
                    poses.extend(
                        cuts.flat_map(|(i, &tip)| if i % 2 == 0 { out(tip, side) } else { back(tip, side) }),
                    );
                }
            }
        }
        poses.push(pose(last.0, near, SAFE_Z_MM, Side::Right, Feed::Back));
    }
    steps(&poses)
}

/// The cell of `table1_arc.job.json` with the part turned about its middle. The part's y, along which all cuts run, then
/// points back along the robot's X.
fn robot(name: &str, turned_deg: f64) -> Robot {
    let tool = Frame { z_mm: 300.0, ..Frame::default() };
    let base = Frame { x_mm: 1525.0, y_mm: -42.5, z_mm: 800.0, a_deg: 90.0, ..Frame::default() }.pose();
    let middle = (base * Point3::new(0.5 * WIDTH_MM, 0.5 * LENGTH_MM, 0.0)).coords;
    let turn = Frame { a_deg: turned_deg, ..Frame::default() }.pose();
    let turned = Translation3::from(middle) * turn * Translation3::from(-middle) * base;
    Robot::new(arm(name), tool.pose(), turned, [0.0, -90.0, 90.0, 0.0, 0.0, 0.0]).unwrap()
}

fn checked(robot: &Robot, path: &[PathStep]) -> RobotCheck {
    check(robot, None, path, &Budget::unwatched()).unwrap()
}

#[test]
fn the_lattices_have_the_tips_of_table_1() {
    let tips = |spacing, step| layers(spacing, step).iter().map(Vec::len).sum::<usize>();
    assert_eq!((tips(4.398, 5.968), tips(3.0, 6.0)), (119, 179));
}

/// The published sequence at Table 1's optimum. Every arm reaches all of it on one branch. In the turns by 88 degrees at
/// 90 deg/s, with the tool 540 mm from the wrist, axis 4 of the two slower arms would have to be a fifth too fast: that
/// is so wherever the cuts point, as both half angles of the turn are nearly alike (sin(34.155) sin(60) = 0.486 across
/// the cuts, cos(60) = 0.5 along them).
#[rstest]
#[case("kr210-r3100-2", 1.208)]
#[case("kr210-r2700-2", 0.920)]
#[case("kr210-r3100-ultra", 1.179)]
#[case("kr210-l150", 0.821)]
fn the_published_sequence_in_the_cell_of_the_job(#[case] name: &str, #[case] ratio: f64) {
    let path = path(Sequence::Paired, 34.155, &layers(4.398, 5.968));
    let found = checked(&robot(name, 0.0), &path);
    assert!(found.reachable && found.min_joint_margin_deg.unwrap() > 15.0, "{found:?}");
    assert!(found.min_singularity_margin.unwrap() > 25.0);
    assert_eq!(found.fastest_joint, 4);
    assert!((found.max_joint_speed_ratio - ratio).abs() < 2e-3, "{}", found.max_joint_speed_ratio);
    assert_eq!(found.passes(), ratio < 1.0);
    if let Some(first) = found.first_fault {
        assert!(matches!(first.fault, Fault::JointSpeed { joint: 4, .. }), "{first:?}");
        // The first turn: the moves before it go down to the first tip.
        assert_eq!((first.step, first.place.line), (1, 2));
    }
}

/// The speed of axis 4 in that turn, by another solver and by differences of a thousandth of the turn.
#[test]
fn an_independent_solver_finds_axis_4_as_fast() {
    let path = path(Sequence::Paired, 34.155, &layers(4.398, 5.968)[..1]);
    let robot = robot("kr210-r3100-2", 0.0);
    let found = checked(&robot, &path);
    // To the safety plane's first tip, down, turn: the third pose to the fourth is a cut.
    let Motion::Straight { from, to, duration_s } = path[1].motion else { panic!() };
    let (oracle, mut joints) = (oracle(robot.arm()), found.start.unwrap().map(f64::to_radians));
    let mut fastest = 0.0_f64;
    for index in 0..=1000 {
        let share = f64::from(index) / 1000.0;
        let place = from.translation.vector.lerp(&to.translation.vector, share);
        let tip = Pose::from_parts(place.into(), from.rotation.slerp(&to.rotation, share));
        let next = oracle.inverse_continuing(&their_pose(&robot.flange(&tip)), &joints)[0];
        if index > 0 {
            fastest = fastest.max((next[3] - joints[3]).abs().to_degrees() / (duration_s / 1000.0));
        }
        joints = next;
    }
    let Fault::JointSpeed { joint: 4, needed_deg_s, .. } = found.first_fault.unwrap().fault else { panic!() };
    assert!((needed_deg_s / fastest - 1.0).abs() < 2e-3, "{needed_deg_s} deg/s, by differences {fastest}");
}

/// Domain.md B5: with the cuts across the robot's reach axis 4 would have to run 2 to 7 times too fast. That is so where
/// the blade swings over with one side (sweep) at the swing angles that sweeps use.
#[rstest]
#[case("kr210-r3100-2", 45.0)]
#[case("kr210-r2700-2", 45.0)]
#[case("kr210-r3100-ultra", 45.0)]
#[case("kr210-l150", 50.0)]
fn sweeps_across_the_reach_are_far_too_fast_for_axis_4(#[case] name: &str, #[case] swing_deg: f64) {
    let path = path(Sequence::Sweep, swing_deg, &layers(10.0, 12.0));
    let along = checked(&robot(name, 0.0), &path);
    assert!(along.reachable && along.max_joint_speed_ratio < 1.08, "{along:?}");
    let across = checked(&robot(name, 90.0), &path);
    assert!((2.0..7.0).contains(&across.max_joint_speed_ratio), "{}", across.max_joint_speed_ratio);
    assert_eq!(across.fastest_joint, 4);
    assert!(matches!(across.first_fault.unwrap().fault, Fault::JointSpeed { joint: 4, .. }));
}

#[test]
fn a_place_is_proposed_where_the_arm_can_follow() {
    let path = path(Sequence::Sweep, 45.0, &layers(30.0, 50.0));
    let robot = robot("kr210-r2700-2", 90.0);
    let here = checked(&robot, &path);
    assert!(!here.passes());
    let there = propose(&robot, &path, &Budget::unwatched()).unwrap().unwrap();
    let again = checked(&robot.moved_to(there.base.pose()), &path);
    assert_eq!(again, there.check);
    assert!(again.passes() && again.freedom > here.freedom.max(0.1), "{there:?}");
    assert_eq!(
        propose(&robot, &path, &Budget::unwatched()).unwrap().unwrap(),
        there,
        "it is the same each time"
    );
}
