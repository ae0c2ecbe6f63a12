//! What an arm cannot do on a path, where, and by how much.

use super::branch::{Lost, Singularity};
use super::kinematics::Unreachable;

/// A line of a program, or whatever else counts files and lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Place {
    /// Index of the file.
    pub file: usize,
    /// Line number in it, from 1.
    pub line: usize,
}

/// What is wrong.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum Fault {
    /// A number that is not finite.
    #[error("a pose, a joint or a duration is not a finite number")]
    NotFinite,
    /// A straight move begins somewhere else than where the arm is.
    #[error("the move begins {mm:.3} mm and {deg:.3} deg away from where the arm is")]
    Gap {
        /// Distance of the tool tip.
        mm: f64,
        /// Turn between the orientations.
        deg: f64,
    },
    /// A straight move that has no time.
    #[error("the move would have to be made in no time: its speed is not above 0 or not known")]
    NoDuration,
    /// A turn by half a turn, which may go either way round.
    #[error("a turn by {deg:.3} deg may go either way round; a pose between its ends must say which")]
    HalfTurn {
        /// How far it turns.
        deg: f64,
    },
    /// A pose out of reach.
    #[error("the wrist {0}")]
    OutOfReach(Unreachable),
    /// The path runs into a singularity: the branch ends.
    #[error("the path meets the singularity of the {}: {margin_deg:.4} deg from it", part(*singularity))]
    Singular {
        /// Which one.
        singularity: Singularity,
        /// How near, in degrees.
        margin_deg: f64,
    },
    /// A joint beyond its limit.
    #[error("A{joint} would have to be at {at_deg:.3} deg, {:.3} deg beyond its limit of {limit_deg} deg",
            (at_deg - limit_deg).abs())]
    JointLimit {
        /// 1 to 6.
        joint: usize,
        /// Where it would have to be.
        at_deg: f64,
        /// How far it may go.
        limit_deg: f64,
    },
    /// A joint faster than it may turn.
    #[error("A{joint} would have to turn at {needed_deg_s:.1} deg/s, {:.2} times its limit of {allowed_deg_s} deg/s",
            needed_deg_s / allowed_deg_s)]
    JointSpeed {
        /// 1 to 6.
        joint: usize,
        /// deg/s.
        needed_deg_s: f64,
        /// deg/s.
        allowed_deg_s: f64,
    },
}

/// The first fault of a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FirstFault {
    /// Where in the program.
    pub place: Place,
    /// Index of the step in the path.
    pub step: usize,
    /// When, in s since the path began.
    pub time_s: f64,
    /// What and by how much: the worst of its kind within this step.
    pub fault: Fault,
}

fn part(singularity: Singularity) -> &'static str {
    match singularity {
        Singularity::Wrist => "wrist (A5 at 0)",
        Singularity::Elbow => "elbow (arm stretched or folded)",
        Singularity::Shoulder => "shoulder (wrist over A1)",
    }
}

impl Fault {
    /// Whether the arm cannot even go there slowly.
    #[must_use]
    pub fn is_of_place(&self) -> bool {
        !matches!(self, Self::JointSpeed { .. })
    }
}

impl FirstFault {
    /// Where it is, as findings have it: `NAME:LINE`, with the names of the program's files; empty for no known file.
    #[must_use]
    pub fn at(&self, files: &[&str]) -> String {
        files.get(self.place.file).map_or_else(String::new, |name| format!("{name}:{}", self.place.line))
    }
}

impl From<Lost> for Fault {
    fn from(lost: Lost) -> Self {
        match lost {
            Lost::Unreachable(Unreachable::NotFinite) => Self::NotFinite,
            Lost::Unreachable(unreachable) => Self::OutOfReach(unreachable),
            Lost::Singular(singularity, margin_deg) => Self::Singular { singularity, margin_deg },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fault_says_what_and_by_how_much_and_where() {
        let fault = Fault::JointSpeed { joint: 4, needed_deg_s: 408.0, allowed_deg_s: 136.0 };
        let first = FirstFault { place: Place { file: 1, line: 12 }, step: 7, time_s: 3.5, fault };
        assert_eq!(first.at(&["main.src", "layer_1.src"]), "layer_1.src:12");
        assert_eq!(first.at(&[]), "");
        let message = "A4 would have to turn at 408.0 deg/s, 3.00 times its limit of 136 deg/s";
        assert_eq!(first.fault.to_string(), message);
        let limit = Fault::JointLimit { joint: 5, at_deg: -130.0, limit_deg: -122.5 };
        assert!(limit.to_string().contains("7.500 deg beyond its limit of -122.5 deg"), "{limit}");
        let reach = Fault::OutOfReach(Unreachable::TooFar { by_mm: 12.5 });
        assert_eq!(reach.to_string(), "the wrist lies 12.500 mm beyond the stretched arm");
    }
}
