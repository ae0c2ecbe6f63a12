//! Joints to flange and back, in closed form (Brandstötter, Angerer and Hofbaur 2014).
//!
//! Written out here rather than taken from a crate: a path is followed on one named branch, and what a crate at
//! hand returns is an unnamed, thinned-out list, to some 1e-9 mm and at ten times the cost; it is the oracle of the
//! tests. Lengths are mm; model angles are rad, joints are degrees.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};

use super::arm::Arm;
use super::branch::Branch;
use crate::planning::geometry::frame::Pose;
use crate::planning::program::robot_moves::Joints;
use crate::planning::tolerance::WRIST_POLE_SINE;

/// An arm made ready for computing.
#[derive(Debug, Clone, PartialEq)]
pub struct Kinematics {
    a1: f64,
    b: f64,
    c1: f64,
    c2: f64,
    c4: f64,
    /// k: from axis 3 to the centre of the wrist.
    fore: f64,
    /// psi: of the line from axis 3 to the centre of the wrist, ahead of axis 4.
    lead: Turn,
    signs: [f64; 6],
    offsets_deg: [f64; 6],
}

/// Why no joints put the flange where it is wanted.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum Unreachable {
    /// The wrist would have to lie farther out than the stretched arm reaches.
    #[error("lies {by_mm:.3} mm beyond the stretched arm")]
    TooFar {
        /// How much farther, in mm.
        by_mm: f64,
    },
    /// The wrist would have to lie nearer to axis 2 than the folded arm can bring it.
    #[error("lies {by_mm:.3} mm too near to axis 2 for the folded arm")]
    TooNear {
        /// How much nearer, in mm.
        by_mm: f64,
    },
    /// The wrist would have to lie nearer to axis 1 than the arm's plane does.
    #[error("lies {by_mm:.3} mm too near to axis 1 for an arm whose plane passes beside it")]
    BesideAxis1 {
        /// How much nearer, in mm.
        by_mm: f64,
    },
    /// A number of the pose is not finite.
    #[error("is no place: a number is not finite")]
    NotFinite,
}

impl Unreachable {
    /// How far the pose is out of reach, in mm; infinite for what is no pose.
    #[must_use]
    pub fn by_mm(&self) -> f64 {
        match *self {
            Self::TooFar { by_mm } | Self::TooNear { by_mm } | Self::BesideAxis1 { by_mm } => by_mm,
            Self::NotFinite => f64::INFINITY,
        }
    }
}

/// Where the flange is wanted: its axes, and the centre of the wrist behind it, in the robot's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Target {
    /// The flange's axes as columns.
    pub rotation: Matrix3<f64>,
    /// The centre of the wrist in mm.
    pub wrist: Vector3<f64>,
}

/// How fast a target moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Twist {
    /// Of the centre of the wrist, in mm/s.
    pub wrist: Vector3<f64>,
    /// Of the flange's axes, in rad/s, in the robot's frame.
    pub turn: Vector3<f64>,
}

/// A sine and its cosine.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Turn {
    sine: f64,
    cosine: f64,
}

/// How the arm stands: its angles and what was found on the way to them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stance {
    /// The model angles, rad, each within a turn.
    pub angles: [f64; 6],
    /// From axis 1 to the centre of the wrist within the arm's plane, in mm; negative behind the axis.
    pub across: f64,
    /// From axis 2 to the centre of the wrist, in mm.
    pub reach: f64,
    /// The bend of the elbow, in rad: 0 where upper arm and the line from elbow to wrist are one.
    pub elbow: f64,
    base: Turn,
    upper: Turn,
    /// Of the line from axis 3 to the centre of the wrist.
    fore_line: Turn,
    /// Of axis 4.
    fore_axis: Turn,
    fourth: Turn,
    fifth: Turn,
}

impl Turn {
    fn of(angle: f64) -> Self {
        let (sine, cosine) = angle.sin_cos();
        Self { sine, cosine }
    }

    /// This turn and another one after it.
    fn plus(self, other: Self) -> Self {
        Self {
            sine: self.sine * other.cosine + self.cosine * other.sine,
            cosine: self.cosine * other.cosine - self.sine * other.sine,
        }
    }

    fn minus(self, other: Self) -> Self {
        self.plus(Self { sine: -other.sine, cosine: other.cosine })
    }

    fn angle(self) -> f64 {
        self.sine.atan2(self.cosine)
    }

    fn about_y(self) -> Matrix3<f64> {
        let Self { sine, cosine } = self;
        Matrix3::new(cosine, 0.0, sine, 0.0, 1.0, 0.0, -sine, 0.0, cosine)
    }

    fn about_z(self) -> Matrix3<f64> {
        let Self { sine, cosine } = self;
        Matrix3::new(cosine, -sine, 0.0, sine, cosine, 0.0, 0.0, 0.0, 1.0)
    }

    /// This direction of a plane whose length is not 1.
    fn toward(sine: f64, cosine: f64) -> Self {
        let length = sine.hypot(cosine);
        Self { sine: sine / length, cosine: cosine / length }
    }
}

impl Kinematics {
    /// Makes an arm ready. It must have passed [`super::arm::checked`].
    #[must_use]
    pub fn new(arm: &Arm) -> Self {
        let g = &arm.geometry;
        Self {
            a1: g.a1_mm,
            b: g.b_mm,
            c1: g.c1_mm,
            c2: g.c2_mm,
            c4: g.c4_mm,
            fore: g.a2_mm.hypot(g.c3_mm),
            lead: Turn::toward(g.a2_mm, g.c3_mm),
            signs: arm.joints.map(|joint| f64::from(joint.sign)),
            offsets_deg: arm.joints.map(|joint| joint.offset_deg),
        }
    }

    /// The pose of the flange in the robot's frame, for joints in degrees.
    #[must_use]
    pub fn forward(&self, joints: &Joints) -> Pose {
        let stance = self.stance(joints);
        let rotation = stance.fore_rotation()
            * stance.fourth.about_z()
            * stance.fifth.about_y()
            * Turn::of(stance.angles[5]).about_z();
        let centre = stance.base.about_z() * Vector3::new(stance.across, self.b, self.wrist_height(&stance));
        let place = centre + rotation.column(2) * self.c4;
        let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(rotation));
        Pose::from_parts(place.into(), rotation)
    }

    /// The joints, in degrees and each within a turn, that put the flange at a pose of the robot's frame on one
    /// branch. Axis 4 has no angle of its own where the wrist is straight; it then stays as in `near`.
    ///
    /// # Errors
    /// How far the pose is out of reach.
    pub fn inverse(&self, flange: &Pose, branch: Branch, near: &Joints) -> Result<Joints, Unreachable> {
        let near = self.angles(near)[3];
        self.solve(&self.target(flange), branch, near).map(|stance| self.joints(&stance))
    }

    /// What has to be reached so that the flange has a pose of the robot's frame.
    #[must_use]
    pub fn target(&self, flange: &Pose) -> Target {
        let rotation = *flange.rotation.to_rotation_matrix().matrix();
        let wrist = flange.translation.vector - rotation.column(2) * self.c4;
        Target { rotation, wrist }
    }

    /// How the arm stands at joints in degrees.
    #[must_use]
    pub fn stance(&self, joints: &Joints) -> Stance {
        let angles = self.angles(joints);
        let upper = Turn::of(angles[1]);
        let bend = Turn::of(angles[2]).plus(self.lead);
        let fore_line = upper.plus(bend);
        let out = self.c2 * upper.sine + self.fore * fore_line.sine;
        let up = self.c2 * upper.cosine + self.fore * fore_line.cosine;
        Stance {
            angles,
            across: self.a1 + out,
            reach: out.hypot(up),
            elbow: bend.angle(),
            base: Turn::of(angles[0]),
            upper,
            fore_line,
            fore_axis: fore_line.minus(self.lead),
            fourth: Turn::of(angles[3]),
            fifth: Turn::of(angles[4]),
        }
    }

    /// How the arm stands when it reaches a target on one branch; `near` is the model angle that axis 4 keeps where
    /// the wrist is straight.
    ///
    /// # Errors
    /// How far the target is out of reach.
    pub fn solve(&self, target: &Target, branch: Branch, near: f64) -> Result<Stance, Unreachable> {
        let (base, across) = self.turn_base(&target.wrist, branch.behind)?;
        let (out, up) = (across - self.a1, target.wrist.z - self.c1);
        let reach = out.hypot(up);
        let bend = self.bend(reach, branch.bent_back)?;
        // The wrist as seen from axis 2 lies ahead of the upper arm by what the bent forearm adds.
        let ahead = Turn::toward(self.fore * bend.sine, self.c2 + self.fore * bend.cosine);
        let upper = Turn { sine: out / reach, cosine: up / reach }.minus(ahead);
        let fore_line = upper.plus(bend);
        let fore_axis = fore_line.minus(self.lead);
        let local = (base.about_z() * fore_axis.about_y()).tr_mul(&target.rotation);
        let (fourth, fifth, sixth) = wrist(&local, branch.flipped, near);
        let angles = [
            base.angle(),
            upper.angle(),
            bend.minus(self.lead).angle(),
            fourth.angle(),
            fifth.angle(),
            sixth.angle(),
        ];
        if !angles.iter().all(|angle| angle.is_finite()) {
            return Err(Unreachable::NotFinite);
        }
        let elbow = bend.angle();
        Ok(Stance { angles, across, reach, elbow, base, upper, fore_line, fore_axis, fourth, fifth })
    }

    /// Axis 1, and how far before it the wrist lies in the arm's plane.
    fn turn_base(&self, wrist: &Vector3<f64>, behind: bool) -> Result<(Turn, f64), Unreachable> {
        let radius = wrist.x.hypot(wrist.y);
        if !(radius.is_finite() && wrist.z.is_finite()) {
            return Err(Unreachable::NotFinite);
        }
        let squared = (radius - self.b) * (radius + self.b);
        if squared < 0.0 {
            return Err(Unreachable::BesideAxis1 { by_mm: self.b.abs() - radius });
        }
        let across = if behind { -squared.sqrt() } else { squared.sqrt() };
        if radius == 0.0 {
            return Ok((Turn { sine: 0.0, cosine: 1.0 }, across));
        }
        let place = Turn { sine: wrist.y / radius, cosine: wrist.x / radius };
        Ok((place.minus(Turn { sine: self.b / radius, cosine: across / radius }), across))
    }

    /// The bend of the elbow at which the wrist is `reach` away from axis 2 (law of cosines).
    fn bend(&self, reach: f64, back: bool) -> Result<Turn, Unreachable> {
        let (c2, k) = (self.c2, self.fore);
        if reach > c2 + k {
            return Err(Unreachable::TooFar { by_mm: reach - (c2 + k) });
        }
        if reach < (c2 - k).abs() || reach == 0.0 {
            return Err(Unreachable::TooNear { by_mm: (c2 - k).abs() - reach });
        }
        let sine = 2.0 * self.triangle(reach) / (c2 * k);
        let cosine = (reach * reach - c2 * c2 - k * k) / (2.0 * c2 * k);
        Ok(Turn::toward(if back { -sine } else { sine }, cosine))
    }

    /// The area in mm^2 of the triangle of axis 2, axis 3 and wrist (Heron, with factors that do not cancel); 0
    /// outside of the arm's reach.
    fn triangle(&self, reach: f64) -> f64 {
        let (c2, k) = (self.c2, self.fore);
        let longer = (c2 + k - reach).max(0.0) * (c2 + k + reach);
        let shorter = (reach - (c2 - k)).max(0.0) * (reach + (c2 - k)).max(0.0);
        0.25 * (longer * shorter).sqrt()
    }

    fn wrist_height(&self, stance: &Stance) -> f64 {
        self.c1 + self.c2 * stance.upper.cosine + self.fore * stance.fore_line.cosine
    }

    /// How fast the model angles change, in rad/s, while the target moves with `twist`.
    ///
    /// Exact, and without limit at a singularity: nothing there is finite.
    #[must_use]
    pub fn rates(&self, stance: &Stance, twist: &Twist) -> [f64; 6] {
        let within = stance.base.about_z().tr_mul(&twist.wrist);
        let first = within.y / stance.across;
        let (out, up) = (within.x + first * self.b, within.z);
        let bend_sine = stance.elbow.sin();
        // Only the upper arm moves the wrist along the forearm, and only the forearm along the upper arm.
        let second = (out * stance.fore_line.sine + up * stance.fore_line.cosine) / (self.c2 * bend_sine);
        let both = -(out * stance.upper.sine + up * stance.upper.cosine) / (self.fore * bend_sine);
        let left = stance.base.about_z() * Vector3::new(0.0, both, first);
        let turn = stance.fore_rotation().tr_mul(&(twist.turn - left));
        let fifth = stance.fourth.cosine * turn.y - stance.fourth.sine * turn.x;
        let sixth = (stance.fourth.cosine * turn.x + stance.fourth.sine * turn.y) / stance.fifth.sine;
        let fourth = turn.z - stance.fifth.cosine * sixth;
        [first, second, both - second, fourth, fifth, sixth]
    }

    /// How far each model angle, in rad, can change at most within `seconds` from a stance on, while the wrist moves
    /// with at most `speed` mm/s and the flange turns with at most `turn` rad/s. Infinite where a singularity may be
    /// met on the way.
    ///
    /// Each joint's rate is at most what the exact rates give when every direction is the worst one and every
    /// divisor has shrunk as far as it can on the way: with D the way of the wrist, axis 1 sees it at
    /// sqrt((radius - D)^2 - b^2), and the triangle of axis 2, axis 3 and wrist is smallest at reach - D or reach + D,
    /// as its area rises to one maximum and falls again while the arm is stretched.
    #[must_use]
    pub fn furthest(&self, stance: &Stance, speed: f64, turn: f64, seconds: f64) -> [f64; 6] {
        let way = speed * seconds;
        let radius = stance.across.hypot(self.b) - way;
        let nearest = (radius - self.b) * (radius + self.b);
        if radius <= 0.0 || nearest <= 0.0 {
            return [f64::INFINITY; 6];
        }
        let nearest = nearest.sqrt();
        // Within the arm's turning plane the wrist is faster when that plane passes beside axis 1.
        let planar = way * radius / nearest;
        let area = self.triangle(stance.reach - planar).min(self.triangle(stance.reach + planar));
        let folded = stance.reach - planar <= 0.0;
        if area <= 0.0 || folded {
            return [f64::INFINITY; 6];
        }
        let first = way / nearest;
        let [second, third, both] =
            [self.fore, stance.reach + planar, self.c2].map(|l| planar * l / (2.0 * area));
        let wrist = turn * seconds + first.hypot(both);
        let straight = stance.wrist_margin() - wrist;
        if straight <= 0.0 {
            return [f64::INFINITY; 6];
        }
        let rolled = wrist / straight.sin();
        [first, second, third, rolled, wrist, rolled]
    }

    /// Joints in degrees, each within a turn, at which the arm stands so.
    #[must_use]
    pub fn joints(&self, stance: &Stance) -> Joints {
        std::array::from_fn(|i| self.signs[i] * (stance.angles[i].to_degrees() + self.offsets_deg[i]))
    }

    /// Model angles in rad for joints in degrees.
    #[must_use]
    pub fn angles(&self, joints: &Joints) -> [f64; 6] {
        std::array::from_fn(|i| (self.signs[i] * joints[i] - self.offsets_deg[i]).to_radians())
    }

    /// From axis 2 to the centre of the wrist when the arm is stretched, in mm.
    #[must_use]
    pub fn stretched_mm(&self) -> f64 {
        self.c2 + self.fore
    }

    /// From the centre of the wrist to the flange, in mm.
    #[must_use]
    pub fn flange_mm(&self) -> f64 {
        self.c4
    }
}

impl Stance {
    /// The branch on which the arm stands.
    #[must_use]
    pub fn branch(&self) -> Branch {
        Branch { behind: self.across < 0.0, bent_back: self.elbow < 0.0, flipped: self.fifth.sine < 0.0 }
    }

    /// How far axis 5 is from the nearest angle at which axes 4 and 6 are one, in rad.
    #[must_use]
    pub fn wrist_margin(&self) -> f64 {
        from_straight(self.angles[4])
    }

    /// How far the elbow is from stretched or folded, in rad.
    #[must_use]
    pub fn elbow_margin(&self) -> f64 {
        from_straight(self.elbow)
    }

    fn fore_rotation(&self) -> Matrix3<f64> {
        self.base.about_z() * self.fore_axis.about_y()
    }
}

/// How far an angle is from the nearest multiple of half a turn, in rad.
fn from_straight(angle: f64) -> f64 {
    let within = angle.rem_euclid(std::f64::consts::PI);
    within.min(std::f64::consts::PI - within)
}

/// Axes 4, 5 and 6 from `Rz(4) Ry(5) Rz(6)`.
///
/// Axis 6 is taken from the matrix turned back by axis 4, so that the three together give the matrix again to the
/// last digit even where the wrist is straight and axis 4 is little more than noise.
fn wrist(local: &Matrix3<f64>, flipped: bool, near: f64) -> (Turn, Turn, Turn) {
    let away = local[(0, 2)].hypot(local[(1, 2)]);
    let fourth = if away < WRIST_POLE_SINE {
        Turn::of(near)
    } else {
        let sign = if flipped { -away } else { away };
        Turn { sine: local[(1, 2)] / sign, cosine: local[(0, 2)] / sign }
    };
    let fifth =
        Turn { sine: fourth.cosine * local[(0, 2)] + fourth.sine * local[(1, 2)], cosine: local[(2, 2)] };
    let sixth = Turn {
        sine: fourth.cosine * local[(1, 0)] - fourth.sine * local[(0, 0)],
        cosine: fourth.cosine * local[(1, 1)] - fourth.sine * local[(0, 1)],
    };
    (fourth, fifth, sixth)
}
