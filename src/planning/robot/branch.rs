//! The eight ways in which an arm can stand for one pose of its flange, and a path followed on one of them.

use super::arm::Arm;
use super::kinematics::{Kinematics, Stance, Unreachable};
use super::travel::Travel;
use crate::planning::geometry::frame::Pose;
use crate::planning::program::robot_moves::Joints;
use crate::planning::tolerance::{JOINT_STEP_DEG, LIMIT_STEP_DEG, SINGULAR_DEG};

/// One of the eight ways: on a path it changes only through a singularity.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Branch {
    /// The arm reaches over its own head: the wrist lies behind axis 1.
    pub behind: bool,
    /// The elbow is bent the other way.
    pub bent_back: bool,
    /// The model angle of axis 5 is negative.
    pub flipped: bool,
}

impl Branch {
    /// All eight.
    pub const ALL: [Self; 8] = {
        let mut all = [Self { behind: false, bent_back: false, flipped: false }; 8];
        let mut index = 0;
        while index < 8 {
            all[index] = Self { behind: index & 4 != 0, bent_back: index & 2 != 0, flipped: index & 1 != 0 };
            index += 1;
        }
        all
    };
}

/// The same joints in degrees, each turned by whole turns until it is as close to `near` as it can be.
#[must_use]
pub fn unwound(joints: &Joints, near: &Joints) -> Joints {
    std::array::from_fn(|i| joints[i] + 360.0 * ((near[i] - joints[i]) / 360.0).round())
}

/// Every way to stand for a pose of the flange in the robot's frame: joints in degrees, by whole turns as close to
/// `near` as they can be, nearest first; limits are not asked.
///
/// Near means the largest change of a joint. The list is empty where the pose is out of reach.
#[must_use]
pub fn ways(kinematics: &Kinematics, flange: &Pose, near: &Joints) -> Vec<(Branch, Joints)> {
    let solve = |branch| kinematics.inverse(flange, branch, near).ok().map(|joints| (branch, joints));
    let mut ways: Vec<_> =
        Branch::ALL.into_iter().filter_map(solve).map(|(b, joints)| (b, unwound(&joints, near))).collect();
    ways.sort_by(|a, b| change(&a.1, near).total_cmp(&change(&b.1, near)));
    ways
}

/// The largest change of a joint, in degrees.
#[must_use]
pub fn change(a: &Joints, b: &Joints) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// How far each joint is from its nearer limit, in degrees; negative beyond it.
#[must_use]
pub fn limit_margins(arm: &Arm, joints: &Joints) -> [f64; 6] {
    std::array::from_fn(|i| {
        let joint = &arm.joints[i];
        (joints[i] - joint.min_deg).min(joint.max_deg - joints[i])
    })
}

/// Which of the three singularities of an arm with a spherical wrist.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Singularity {
    /// Axes 4 and 6 are one line: axis 5 is at 0.
    Wrist,
    /// The elbow is stretched or folded: the wrist is at the edge of what the arm reaches.
    Elbow,
    /// The wrist lies over axis 1.
    Shoulder,
}

/// How far a stance is from the three singularities.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SingularityMargins {
    /// Axis 5 from the nearest angle at which axes 4 and 6 are one line, in degrees.
    pub wrist_deg: f64,
    /// The elbow from stretched or folded (axis 2, axis 3 and wrist in one line), in degrees.
    pub elbow_deg: f64,
    /// The wrist from axis 1 within the arm's plane, in mm.
    pub shoulder_mm: f64,
    /// The same as an angle: arcsin of its ratio to the stretched arm. So a margin m of any of the three lets an axis
    /// turn up to about 1 / sin(m) times as fast as far from it.
    pub shoulder_deg: f64,
}

impl SingularityMargins {
    /// The margins of a stance.
    #[must_use]
    pub fn of(kinematics: &Kinematics, stance: &Stance) -> Self {
        let shoulder_mm = stance.across.abs();
        Self {
            wrist_deg: stance.wrist_margin().to_degrees(),
            elbow_deg: stance.elbow_margin().to_degrees(),
            shoulder_mm,
            shoulder_deg: (shoulder_mm / kinematics.stretched_mm()).min(1.0).asin().to_degrees(),
        }
    }

    /// The smallest of the three in degrees, and whose it is.
    #[must_use]
    pub fn smallest(&self) -> (Singularity, f64) {
        let wrist = (Singularity::Wrist, self.wrist_deg);
        let others = [(Singularity::Elbow, self.elbow_deg), (Singularity::Shoulder, self.shoulder_deg)];
        others.into_iter().fold(wrist, |least, other| if other.1 < least.1 { other } else { least })
    }
}

/// The arm at a moment of a straight travel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Instant {
    /// s since the travel began.
    pub seconds: f64,
    /// Degrees, wound on continuously.
    pub joints: Joints,
    /// How fast each joint turns, in deg/s, without sign.
    pub rates: [f64; 6],
    /// How far it is from singularities.
    pub singularities: SingularityMargins,
}

/// Why a travel cannot be followed any further.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Lost {
    /// A pose is out of reach.
    Unreachable(Unreachable),
    /// The branch ends: it runs into a singularity.
    Singular(Singularity, f64),
}

/// Follows straight travels on one branch.
#[derive(Debug, Clone)]
pub struct Follower<'a> {
    arm: &'a Arm,
    kinematics: &'a Kinematics,
    branch: Branch,
    joints: Joints,
}

impl<'a> Follower<'a> {
    /// Begins at joints in degrees; the branch is theirs.
    #[must_use]
    pub fn new(arm: &'a Arm, kinematics: &'a Kinematics, joints: Joints) -> Self {
        Self { arm, kinematics, branch: kinematics.stance(&joints).branch(), joints }
    }

    /// Where it is, in degrees.
    #[must_use]
    pub fn joints(&self) -> &Joints {
        &self.joints
    }

    /// The branch on which it is.
    #[must_use]
    pub fn branch(&self) -> Branch {
        self.branch
    }

    /// Follows a travel from its beginning to its end and shows every instant on the way to `see`, both ends too.
    ///
    /// The step rule: the next instant is so near that, by [`Kinematics::furthest`], no joint can have moved in
    /// between by more than `JOINT_STEP_DEG`, nor by more than it is away from its limits (but for a step of
    /// `LIMIT_STEP_DEG`). So no limit is crossed and no singularity met unseen, the branch is the same throughout,
    /// and turns can be told apart. Toward a singularity the steps shrink with the distance to it.
    ///
    /// # Errors
    /// Where and why the branch ends, or what `see` returns.
    pub fn follow<E: From<Lost>>(
        &mut self,
        travel: &Travel,
        mut see: impl FnMut(&Instant) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut seconds = 0.0;
        loop {
            let (stance, instant) = self.stand(travel, seconds)?;
            let (which, margin) = instant.singularities.smallest();
            // Whatever compares with nothing is no margin.
            if margin.is_nan() || margin <= SINGULAR_DEG {
                return Err(Lost::Singular(which, margin).into());
            }
            see(&instant)?;
            let left = travel.duration_s() - seconds;
            if left <= 0.0 {
                return Ok(());
            }
            let step = self.step(&stance, travel, left).ok_or(Lost::Singular(which, margin))?;
            let next = if step < left { seconds + step } else { travel.duration_s() };
            if next <= seconds {
                // A step too short for the clock is none.
                return Err(Lost::Singular(which, margin).into());
            }
            seconds = next;
        }
    }

    fn stand(&mut self, travel: &Travel, seconds: f64) -> Result<(Stance, Instant), Lost> {
        let near = self.kinematics.angles(&self.joints)[3];
        let (target, twist) = travel.at(seconds);
        let stance = self.kinematics.solve(&target, self.branch, near).map_err(Lost::Unreachable)?;
        self.joints = unwound(&self.kinematics.joints(&stance), &self.joints);
        let rates = self.kinematics.rates(&stance, &twist).map(|rate| rate.abs().to_degrees());
        if rates.iter().any(|rate| rate.is_nan()) {
            return Err(Lost::Unreachable(Unreachable::NotFinite));
        }
        let singularities = SingularityMargins::of(self.kinematics, &stance);
        Ok((stance, Instant { seconds, joints: self.joints, rates, singularities }))
    }

    /// The longest certified step, up to `most` seconds.
    fn step(&self, stance: &Stance, travel: &Travel, most: f64) -> Option<f64> {
        /// A step that is still too long after so many shortenings (to 1e-11 of the first one) cannot be made.
        const MOST_SHORTENINGS: usize = 40;
        /// Each shortening; the bound is nearly proportional to the step.
        const SHORTENED: f64 = 0.53;
        let margins = limit_margins(self.arm, &self.joints);
        let allowed = margins.map(|margin| {
            // Beyond a limit nothing more can be missed there.
            let margin = if margin < 0.0 { JOINT_STEP_DEG } else { margin };
            margin.clamp(LIMIT_STEP_DEG, JOINT_STEP_DEG).to_radians()
        });
        let mut step = most;
        for _ in 0..MOST_SHORTENINGS {
            let changes = self.kinematics.furthest(stance, travel.wrist_speed(), travel.turn_speed(), step);
            if changes.iter().zip(&allowed).all(|(change, allowed)| change <= allowed) {
                return Some(step);
            }
            let excess = changes.iter().zip(&allowed).map(|(c, a)| c / a).fold(0.0, f64::max);
            // A bound that is finite says itself how far it is too large.
            step *= if excess.is_finite() { (0.95 / excess).max(0.1) } else { SHORTENED };
        }
        None
    }
}
