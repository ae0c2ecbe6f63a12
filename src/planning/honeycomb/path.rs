//! From tips to the way of the tool: the published sequence, each tip cut left out and right back.
//!
//! The tool turns and goes from tip to tip beside the blank, at y = -b, and from layer to layer over the safety
//! plane. Each layer begins and ends there, so that a program can be started at any.

use nalgebra::{Point3, UnitQuaternion, Vector3};

use super::blade::{Blade, Edges, Feed, Side};
use super::input::Setting;
use crate::planning::geometry::Point2;
use crate::planning::geometry::frame::Pose;
use crate::planning::program::robot_moves::{Layer, Purpose, RobotStep};

/// The way of the tool over layers of tips, (x, z) in mm, each cut twice with the blade swung by `swing` rad.
#[must_use]
pub fn paired(layers: &[Vec<Point2>], swing: f64, setting: &Setting) -> Vec<Layer> {
    let way = Way::new(setting, swing);
    layers.iter().filter(|tips| !tips.is_empty()).map(|tips| way.layer(tips)).collect()
}

/// Half of the turn of a single-edged blade, in rad.
const QUARTER: f64 = std::f64::consts::FRAC_PI_2;

/// Where the tool stands beside the blank, and how it lies there.
struct Way<'a> {
    blade: &'a Blade,
    swing: f64,
    /// y before and behind the blank.
    ends: [f64; 2],
    /// z of the plane on which the tool travels.
    safety_z: f64,
}

impl<'a> Way<'a> {
    fn new(setting: &'a Setting, swing: f64) -> Self {
        let Setting { blank, blade, process } = setting;
        let extension = blade.extension_mm(swing);
        Self {
            blade,
            swing,
            ends: [-extension, blank.length_mm + extension],
            safety_z: blank.height_mm + process.safety_distance_mm,
        }
    }

    fn layer(&self, tips: &[Point2]) -> Layer {
        let (first, last) = (tips[0], tips[tips.len() - 1]);
        let mut steps = vec![
            self.move_to(first.x, self.safety_z, Purpose::Free),
            self.move_to(first.x, first.y, Purpose::Approach),
            RobotStep::Ultrasonic { on: true },
        ];
        let before = std::iter::once(&first).chain(tips);
        steps.extend(before.zip(tips).flat_map(|(from, tip)| self.cuts(from, tip)));
        steps.push(RobotStep::Ultrasonic { on: false });
        // Joints may move next, or another layer begins: the tool stands still on the safety plane.
        steps.push(self.move_to(last.x, self.safety_z, Purpose::Approach));
        Layer { steps }
    }

    /// Left tilt, cut, right tilt, cut back (the paper's section III.A, step 6). `from` is where the tool was.
    fn cuts(&self, from: &Point2, tip: &Point2) -> Vec<RobotStep> {
        let [near, far] = self.ends;
        let place = |tip: &Point2, y| Point3::new(tip.x, y, tip.y);
        let left = |y| self.blade.pose(place(tip, y), Side::Left, self.swing, Feed::Out);
        let right = |tip, y| self.blade.pose(place(tip, y), Side::Right, self.swing, Feed::Back);
        let step = |to, purpose| RobotStep::Move { to, purpose };
        let mut steps = self.turn(&right(from, near), left(near), QUARTER);
        steps.push(step(left(far), Purpose::Cut));
        steps.extend(self.turn(&left(far), right(tip, far), -QUARTER));
        steps.push(step(right(tip, near), Purpose::Cut));
        steps
    }

    /// A turn from one posture to the other. A single-edged blade turns right round, where the shortest way is not
    /// one but two; so it is led through the middle, turned by `about_z` rad about the vertical: one way round
    /// behind the blank and the other way round before it, which leaves no twist in the robot's wrist.
    fn turn(&self, from: &Pose, to: Pose, about_z: f64) -> Vec<RobotStep> {
        let step = |to| RobotStep::Move { to, purpose: Purpose::Turn };
        match self.blade.edges {
            Edges::Double => vec![step(to)],
            Edges::Single => {
                let place = nalgebra::center(&from.translation.vector.into(), &to.translation.vector.into());
                let posture = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), about_z) * from.rotation;
                vec![step(Pose::from_parts(place.into(), posture)), step(to)]
            }
        }
    }

    /// Between layers the tool keeps the posture in which it has cut last.
    fn move_to(&self, x: f64, z: f64, purpose: Purpose) -> RobotStep {
        let place = Point3::new(x, self.ends[0], z);
        RobotStep::Move { to: self.blade.pose(place, Side::Right, self.swing, Feed::Back), purpose }
    }
}
