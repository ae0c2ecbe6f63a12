//! The straight blade: its angles, its reach, and its pose in a cut (domain.md B1).
//!
//! x across the part, y along its generatrix and along every cut, z up. Seen along y the blade is a line from
//! its tip, up and outward at the swing angle from the vertical.

use nalgebra::{Matrix3, Point3, Rotation3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

use crate::planning::geometry::frame::Pose;
use crate::planning::units::{Angle, Length};

/// The two cuts of a tip point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// The blade leans to -x.
    Left,
    /// The blade leans to +x.
    Right,
}

/// Which way a cut is fed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Feed {
    /// Toward +y.
    Out,
    /// Toward -y.
    Back,
}

/// Whether the blade cuts both ways.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Edges {
    /// Only with its leading edge: it is turned round for the way back.
    Single,
    /// With both: its tool X axis keeps pointing toward +y.
    Double,
}

/// A straight blade on its flange.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Blade {
    /// theta: between the tool axis and the feed.
    pub rake: Angle,
    /// beta: half of the angle at the tip.
    pub half_apex: Angle,
    /// The longest part of the edge that may cut, from the tip along the edge.
    pub max_cutting_length: Length,
    /// The whole edge, at least as long.
    pub length: Length,
    /// The largest alpha.
    pub max_swing: Angle,
    /// Whether it cuts both ways.
    pub edges: Edges,
}

impl Side {
    /// -1 for left, +1 for right: the sign of x in which the blade leans.
    #[must_use]
    pub fn sign(self) -> f64 {
        match self {
            Self::Left => -1.0,
            Self::Right => 1.0,
        }
    }

    /// The unit vector (x, z) of the section along the blade, from the tip up and outward; `swing` in rad.
    #[must_use]
    pub fn direction(self, swing: f64) -> [f64; 2] {
        [self.sign() * swing.sin(), swing.cos()]
    }
}

impl Feed {
    /// +1 toward +y, -1 toward -y.
    #[must_use]
    pub fn sign(self) -> f64 {
        match self {
            Self::Out => 1.0,
            Self::Back => -1.0,
        }
    }
}

impl Blade {
    /// theta - beta in rad: between the cutting edge and the feed.
    #[must_use]
    pub fn edge_angle(&self) -> f64 {
        self.rake.radians() - self.half_apex.radians()
    }

    /// d in mm: how far a part of the edge of `cutting_length_mm` reaches in the section (Eq. 2).
    #[must_use]
    pub fn reach_mm(&self, cutting_length_mm: f64) -> f64 {
        cutting_length_mm * self.edge_angle().sin()
    }

    /// How far the body of the blade reaches in the section, in mm: its trailing edge, at theta + beta.
    #[must_use]
    pub fn body_reach_mm(&self) -> f64 {
        self.length.mm() * (self.rake.radians() + self.half_apex.radians()).sin()
    }

    /// b in mm: how far a cut goes on beyond both ends of the blank, so that the whole blade is outside while it
    /// turns (Eq. 5, with the whole blade in place of the cutting length: domain.md B1). `swing` in rad.
    ///
    /// A single-edged blade is turned right round about the vertical, and at one end of the blank its edge then
    /// points at the blank with all of its horizontal part; turning the other way there would wind up the robot's
    /// wrist. Its b is longer by that.
    #[must_use]
    pub fn extension_mm(&self, swing: f64) -> f64 {
        let (across, along) = self.edge_angle().sin_cos();
        match self.edges {
            Edges::Double => self.length.mm() * along,
            Edges::Single => self.length.mm() * along.hypot(across * swing.sin()),
        }
    }

    /// The pose of the tool in a cut, in the frame of the part. `tip` in mm, `swing` in rad.
    ///
    /// Tool Z points out through the tip. The axis from tip to flange leans ahead, at theta from the feed, so that
    /// the edge in front lies at theta - beta. Tool X points toward +y on both ways with a double-edged blade,
    /// whose other edge is then in front on the way back, and along the feed with a single-edged one.
    #[must_use]
    pub fn pose(&self, tip: Point3<f64>, side: Side, swing: f64, feed: Feed) -> Pose {
        let [across, up] = side.direction(swing);
        let e = Vector3::new(across, 0.0, up);
        let f = Vector3::new(0.0, feed.sign(), 0.0);
        let (sine, cosine) = self.rake.radians().sin_cos();
        let z = -(e * sine + f * cosine);
        let x = (f * sine - e * cosine) * self.front_sign(feed);
        let rotation = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[x, z.cross(&x), z]));
        Pose::from_parts(tip.into(), UnitQuaternion::from_rotation_matrix(&rotation))
    }

    /// The unit vector along the edge in front, from the tip, in the tool's own frame.
    #[must_use]
    pub fn front_in_tool(&self, feed: Feed) -> Vector3<f64> {
        let (sine, cosine) = self.half_apex.radians().sin_cos();
        Vector3::new(sine * self.front_sign(feed), 0.0, -cosine)
    }

    /// On which side of the tool's X the edge in front lies.
    fn front_sign(&self, feed: Feed) -> f64 {
        match self.edges {
            Edges::Double => feed.sign(),
            Edges::Single => 1.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table1(edges: Edges) -> Blade {
        Blade {
            rake: Angle::from_degrees(60.0),
            half_apex: Angle::from_degrees(7.13),
            max_cutting_length: Length::from_mm(10.0),
            length: Length::from_mm(10.0),
            max_swing: Angle::from_degrees(50.0),
            edges,
        }
    }

    fn turn_deg(blade: &Blade, swing: f64) -> f64 {
        let tip = Point3::new(0.0, 0.0, 0.0);
        let left = blade.pose(tip, Side::Left, swing, Feed::Out);
        let right = blade.pose(tip, Side::Right, swing, Feed::Back);
        left.rotation.angle_to(&right.rotation).to_degrees()
    }

    #[test]
    fn a_double_edged_blade_turns_as_the_paper_says_and_a_single_edged_one_right_round() {
        let swing = 34.155_f64.to_radians();
        // Cui et al. 2020, Eq. 9; 88.4 degrees at Table 1's optimum.
        let published = 2.0 * (swing.cos() * 60.0_f64.to_radians().sin()).acos().to_degrees();
        assert!((turn_deg(&table1(Edges::Double), swing) - published).abs() < 1e-9);
        assert!((published - 88.44).abs() < 0.005);
        assert!((turn_deg(&table1(Edges::Single), swing) - 180.0).abs() < 1e-9);
    }

    #[test]
    fn the_front_edge_lies_in_the_blade_plane_at_theta_less_beta_from_the_feed() {
        let (swing, tip) = (0.6, Point3::new(5.0, 1.0, 2.0));
        for edges in [Edges::Double, Edges::Single] {
            let blade = table1(edges);
            for (side, feed) in [(Side::Left, Feed::Out), (Side::Right, Feed::Back)] {
                let pose = blade.pose(tip, side, swing, feed);
                let edge = pose * blade.front_in_tool(feed);
                assert!((edge.y * feed.sign() - blade.edge_angle().cos()).abs() < 1e-12, "{edge}");
                let [across, up] = side.direction(swing);
                assert!((edge.x * up - edge.z * across).abs() < 1e-12 && edge.z > 0.0, "{edge}");
                let behind = -(pose * Vector3::z()) * 2.0 * blade.half_apex.radians().cos() - edge;
                let angle = (behind.y * feed.sign()).acos();
                assert!((angle - blade.rake.radians() - blade.half_apex.radians()).abs() < 1e-12);
                assert!((pose * Point3::origin() - tip).norm() < 1e-12);
            }
        }
    }

    #[test]
    fn the_extension_of_table_1_is_the_paper_s() {
        assert!((table1(Edges::Double).extension_mm(0.6) - 6.0363).abs() < 5e-5);
    }
}
