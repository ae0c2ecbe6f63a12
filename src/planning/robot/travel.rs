//! A straight travel of the tool as the wrist sees it: position linear, orientation along the shortest turn.

use nalgebra::{Matrix3, Rotation3, Unit, UnitQuaternion, Vector3};

use super::kinematics::{Kinematics, Target, Twist};
use crate::planning::geometry::frame::Pose;

/// A straight travel at even speed, in the robot's frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Travel {
    duration_s: f64,
    /// Where the tool tip begins, in mm.
    tip: Vector3<f64>,
    /// mm/s of the tip.
    velocity: Vector3<f64>,
    axis: Unit<Vector3<f64>>,
    /// rad/s about the axis.
    turn_speed: f64,
    /// The flange's axes at the beginning.
    flange: Matrix3<f64>,
    /// From the centre of the wrist to the tool tip, in the flange's axes, in mm.
    tool: Vector3<f64>,
    /// mm/s that the wrist has at most.
    wrist_speed: f64,
}

/// The turn from one orientation to another one: its axis, and its angle in rad within 0..=pi.
///
/// At half a turn both ways round are equally short, and which one comes out hangs on the last digit.
#[must_use]
pub fn turn(from: &UnitQuaternion<f64>, to: &UnitQuaternion<f64>) -> (Unit<Vector3<f64>>, f64) {
    let between = to * from.inverse();
    // A quaternion and its negative are one orientation; the shorter turn has w >= 0.
    let vector = if between.w < 0.0 { -between.imag() } else { between.imag() };
    let sine = vector.norm();
    let axis = if sine > 0.0 { Unit::new_unchecked(vector / sine) } else { Vector3::z_axis() };
    (axis, 2.0 * sine.atan2(between.w.abs()))
}

/// How long a straight travel takes, in s: the slower of its way at `speed_mm_s` and its turn at `turn_deg_s`
/// (domain.md B3).
#[must_use]
pub fn duration_s(from: &Pose, to: &Pose, speed_mm_s: f64, turn_deg_s: f64) -> f64 {
    let way = (to.translation.vector - from.translation.vector).norm();
    let (_, angle) = turn(&from.rotation, &to.rotation);
    (way / speed_mm_s).max(angle.to_degrees() / turn_deg_s)
}

impl Travel {
    /// The travel of a tool (`tool`: its tip in the flange) between two poses of a base frame (`base`, in the robot's)
    /// within `duration_s`, which must be above 0.
    #[must_use]
    pub fn new(
        kinematics: &Kinematics,
        tool: &Pose,
        base: &Pose,
        (from, to): (&Pose, &Pose),
        duration_s: f64,
    ) -> Self {
        let start = base * from;
        let end = base * to;
        let (axis, angle) = turn(&start.rotation, &end.rotation);
        let flange = *(start.rotation * tool.rotation.inverse()).to_rotation_matrix().matrix();
        let behind = tool.translation.vector + Vector3::z() * kinematics.flange_mm();
        let velocity = (end.translation.vector - start.translation.vector) / duration_s;
        let turn_speed = angle / duration_s;
        // The axis stands still, so the wrist's distance from it does, too: its speed is never more than this.
        let swing = (axis.into_inner() * turn_speed).cross(&(flange * behind)).norm();
        let wrist_speed = velocity.norm() + swing;
        let tip = start.translation.vector;
        Self { duration_s, tip, velocity, axis, turn_speed, flange, tool: behind, wrist_speed }
    }

    /// How long it takes, in s.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.duration_s
    }

    /// The largest speed of the wrist, in mm/s.
    #[must_use]
    pub fn wrist_speed(&self) -> f64 {
        self.wrist_speed
    }

    /// The speed of turning, in rad/s.
    #[must_use]
    pub fn turn_speed(&self) -> f64 {
        self.turn_speed
    }

    /// Where flange and wrist are, so many seconds after the beginning, and how fast they move.
    #[must_use]
    pub fn at(&self, seconds: f64) -> (Target, Twist) {
        let rotation = self.rotation(seconds);
        let tool = rotation * self.tool;
        let turn = self.axis.into_inner() * self.turn_speed;
        let target = Target { rotation, wrist: self.tip + self.velocity * seconds - tool };
        (target, Twist { wrist: self.velocity - turn.cross(&tool), turn })
    }

    fn rotation(&self, seconds: f64) -> Matrix3<f64> {
        if self.turn_speed == 0.0 {
            return self.flange;
        }
        Rotation3::from_axis_angle(&self.axis, self.turn_speed * seconds).matrix() * self.flange
    }
}
