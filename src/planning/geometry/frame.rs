//! Frames as KUKA controls write them: a place, and three angles `A`, `B`, `C` with
//! `R = Rz(A) Ry(B) Rx(C)` (domain.md B1).

use nalgebra::{Isometry3, Rotation3, Translation3, UnitQuaternion};
use serde::{Deserialize, Serialize};

/// A rigid motion: mm and radians inside, from a frame into the one it is given in.
pub type Pose = Isometry3<f64>;

/// A frame in mm and degrees, as it stands in job documents and programs.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Frame {
    /// mm.
    pub x_mm: f64,
    /// mm.
    pub y_mm: f64,
    /// mm.
    pub z_mm: f64,
    /// Turn about Z, in degrees; the last of the three.
    pub a_deg: f64,
    /// Turn about Y, in degrees.
    pub b_deg: f64,
    /// Turn about X, in degrees; the first of the three.
    pub c_deg: f64,
}

impl Frame {
    /// The frame as a rigid motion.
    #[must_use]
    pub fn pose(&self) -> Pose {
        let (a, b, c) = (self.a_deg.to_radians(), self.b_deg.to_radians(), self.c_deg.to_radians());
        // nalgebra's Euler angles are (roll, pitch, yaw) of Rz(yaw) Ry(pitch) Rx(roll).
        let rotation = Rotation3::from_euler_angles(c, b, a);
        let place = Translation3::new(self.x_mm, self.y_mm, self.z_mm);
        Pose::from_parts(place, UnitQuaternion::from_rotation_matrix(&rotation))
    }

    /// The frame of a rigid motion: B within +-90 degrees, A and C within +-180.
    ///
    /// Where B is +-90 degrees only A - C or A + C is defined; C is then 0. Compare poses, never these angles.
    #[must_use]
    pub fn of(pose: &Pose) -> Self {
        /// cos(B) below this cannot tell A from C: a hundredth of the last printed digit of an angle.
        const GIMBAL_COSINE: f64 = 1e-8;
        let m = pose.rotation.to_rotation_matrix();
        let m = m.matrix();
        let cosine = m[(0, 0)].hypot(m[(1, 0)]);
        let b = (-m[(2, 0)]).atan2(cosine);
        let (a, c) = if cosine > GIMBAL_COSINE {
            (m[(1, 0)].atan2(m[(0, 0)]), m[(2, 1)].atan2(m[(2, 2)]))
        } else {
            ((-m[(0, 1)]).atan2(m[(1, 1)]), 0.0)
        };
        let place = pose.translation.vector;
        Self {
            x_mm: place.x,
            y_mm: place.y,
            z_mm: place.z,
            a_deg: a.to_degrees(),
            b_deg: b.to_degrees(),
            c_deg: c.to_degrees(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;
    use proptest::prelude::*;

    fn frame(angles: [f64; 3]) -> Frame {
        let [a_deg, b_deg, c_deg] = angles;
        Frame { x_mm: 1.0, y_mm: -2.0, z_mm: 3.0, a_deg, b_deg, c_deg }
    }

    proptest! {
        #[test]
        fn a_frame_comes_back_as_the_same_motion(a in -180.0..180.0, b in -180.0..180.0, c in -180.0..180.0) {
            let pose = frame([a, b, c]).pose();
            let again = Frame::of(&pose).pose();
            prop_assert!((pose.to_homogeneous() - again.to_homogeneous()).norm() < 1e-12);
        }
    }

    #[test]
    fn the_turns_are_about_x_then_y_then_z() {
        let pose = frame([90.0, 0.0, 90.0]).pose();
        // C first takes Y to Z; A then leaves Z alone and takes X to Y.
        assert!((pose * Vector3::y() - Vector3::z()).norm() < 1e-12);
        assert!((pose * Vector3::x() - Vector3::y()).norm() < 1e-12);
    }

    #[test]
    fn a_vertical_x_axis_is_no_trouble() {
        for b in [90.0, -90.0, 90.0 - 1e-9, -90.0 + 1e-9] {
            let pose = frame([30.0, b, 50.0]).pose();
            let again = Frame::of(&pose);
            assert!((pose.to_homogeneous() - again.pose().to_homogeneous()).norm() < 1e-7, "{again:?}");
        }
    }
}
