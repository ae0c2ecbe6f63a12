//! Tests of arms as a whole; what one file can say alone is tested there.

mod kinematics;
mod paths;
mod table1;

use rs_opw_kinematics::glam::{DQuat, DVec3};
use rs_opw_kinematics::kinematic_traits;
use rs_opw_kinematics::kinematics_impl::OPWKinematics;
use rs_opw_kinematics::parameters::opw_kinematics::Parameters;

use super::arm::{Arm, Catalogue};
use super::check::{Motion, PathStep};
use super::fault::Place;
use super::travel::duration_s;
use crate::planning::geometry::frame::Pose;

fn arm(name: &str) -> Arm {
    Catalogue::built_in().get(name).unwrap().clone()
}

/// A solver written by others.
fn oracle(arm: &Arm) -> OPWKinematics {
    let g = &arm.geometry;
    OPWKinematics::new(Parameters {
        a1: g.a1_mm,
        a2: g.a2_mm,
        b: g.b_mm,
        c1: g.c1_mm,
        c2: g.c2_mm,
        c3: g.c3_mm,
        c4: g.c4_mm,
        offsets: arm.joints.map(|joint| joint.offset_deg.to_radians()),
        sign_corrections: arm.joints.map(|joint| joint.sign),
        dof: 6,
    })
}

fn their_pose(pose: &Pose) -> kinematic_traits::Pose {
    let (place, q) = (pose.translation.vector, pose.rotation.coords);
    let rotation = DQuat::from_xyzw(q.x, q.y, q.z, q.w);
    kinematic_traits::Pose::from_parts(DVec3::new(place.x, place.y, place.z), rotation)
}

/// Straight moves from pose to pose at 200 mm/s and 90 deg/s, a line each.
fn steps(poses: &[Pose]) -> Vec<PathStep> {
    let step = |(index, pair): (usize, &[Pose])| {
        let (from, to) = (pair[0], pair[1]);
        let motion = Motion::Straight { from, to, duration_s: duration_s(&from, &to, 200.0, 90.0) };
        PathStep { place: Place { file: 0, line: index + 1 }, motion }
    };
    poses.windows(2).enumerate().map(step).collect()
}

/// A fixed sequence of numbers within 0..1 (a linear congruential generator): the same in every run.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }

    /// Joints within the limits of an arm.
    fn joints(&mut self, arm: &Arm) -> [f64; 6] {
        std::array::from_fn(|i| self.between(arm.joints[i].min_deg, arm.joints[i].max_deg))
    }
}
