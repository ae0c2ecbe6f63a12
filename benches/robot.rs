//! An arm over the Table 1 part (119 tips, 490 straight moves), and the search for a better place.

use bladeplan::planning::budget::Budget;
use bladeplan::planning::geometry::frame::{Frame, Pose};
use bladeplan::planning::honeycomb::blade::{Blade, Edges, Feed, Side};
use bladeplan::planning::robot::arm::Catalogue;
use bladeplan::planning::robot::base_search::propose;
use bladeplan::planning::robot::branch::{Branch, ways};
use bladeplan::planning::robot::check::{Motion, PathStep, Robot, check};
use bladeplan::planning::robot::fault::Place;
use bladeplan::planning::robot::travel::duration_s;
use bladeplan::planning::units::{Angle, Length};
use divan::Bencher;
use nalgebra::Point3;

const HOME: [f64; 6] = [0.0, -90.0, 90.0, 0.0, 0.0, 0.0];

fn main() {
    divan::main();
}

fn robot(name: &str, turned_deg: f64) -> Robot {
    let arm = Catalogue::built_in().get(name).expect("a built-in arm").clone();
    let tool = Frame { z_mm: 300.0, ..Frame::default() };
    let a_deg = 90.0 + turned_deg;
    let base = Frame { x_mm: 1525.0, y_mm: -42.5, z_mm: 800.0, a_deg, ..Frame::default() };
    Robot::new(arm, tool.pose(), base.pose(), HOME).expect("a built-in arm is valid")
}

/// The published sequence at Table 1's optimum: each tip left out and right back, layer by layer.
fn path() -> Vec<PathStep> {
    let (length, angle) = (Length::from_mm(10.0), Angle::from_degrees);
    let blade = Blade {
        rake: angle(60.0),
        half_apex: angle(7.13),
        max_cutting_length: length,
        length,
        max_swing: angle(50.0),
        edges: Edges::Double,
    };
    let contour = |x: f64| 16.782_213 - 85.0 + (85.0_f64.powi(2) - (x - 42.5).powi(2)).sqrt();
    let pose = |x, y, z, side, feed| blade.pose(Point3::new(x, y, z), side, 34.155_f64.to_radians(), feed);
    let mut poses: Vec<Pose> = Vec::new();
    for layer in 1..12 {
        let z = 50.0 - f64::from(layer) * 4.398;
        let columns = (0..15).map(|j| 42.5 + f64::from(j - 7) * 5.968);
        let tips: Vec<_> = columns.filter(|&x| z >= contour(x)).collect();
        for (index, &x) in tips.iter().enumerate() {
            if index == 0 {
                poses.push(pose(x, -6.04, 60.0, Side::Right, Feed::Back));
                poses.push(pose(x, -6.04, z, Side::Right, Feed::Back));
            }
            poses.extend([-6.04, 56.04].map(|y| pose(x, y, z, Side::Left, Feed::Out)));
            poses.extend([56.04, -6.04].map(|y| pose(x, y, z, Side::Right, Feed::Back)));
        }
        poses.extend(tips.last().map(|&x| pose(x, -6.04, 60.0, Side::Right, Feed::Back)));
    }
    let straight = |(index, pair): (usize, &[Pose])| {
        let (from, to) = (pair[0], pair[1]);
        let motion = Motion::Straight { from, to, duration_s: duration_s(&from, &to, 200.0, 90.0) };
        PathStep { place: Place { file: 0, line: index + 1 }, motion }
    };
    poses.windows(2).enumerate().map(straight).collect()
}

#[divan::bench(args = ["kr210-r3100-2", "kr210-r2700-2"])]
fn check_table_1(bencher: Bencher, name: &str) {
    let (robot, path) = (robot(name, 0.0), path());
    bencher.bench_local(|| check(&robot, None, &path, &Budget::unwatched()));
}

#[divan::bench(args = [0.0, 90.0])]
fn propose_a_place(bencher: Bencher, turned_deg: f64) {
    let (robot, path) = (robot("kr210-r3100-2", turned_deg), path());
    bencher.bench_local(|| propose(&robot, &path, &Budget::unwatched()));
}

#[divan::bench]
fn one_inverse(bencher: Bencher) {
    let robot = robot("kr210-r3100-2", 0.0);
    let flange = robot.kinematics().forward(&[10.0, -80.0, 95.0, 20.0, 40.0, -30.0]);
    let branch = Branch { behind: false, bent_back: false, flipped: false };
    bencher.bench_local(|| robot.kinematics().inverse(divan::black_box(&flange), branch, &HOME));
}

#[divan::bench]
fn all_ways(bencher: Bencher) {
    let robot = robot("kr210-r3100-2", 0.0);
    let flange = robot.kinematics().forward(&[10.0, -80.0, 95.0, 20.0, 40.0, -30.0]);
    bencher.bench_local(|| ways(robot.kinematics(), divan::black_box(&flange), &HOME));
}
