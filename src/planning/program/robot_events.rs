//! What a reader makes of a robot program's text: what the control would do, statement by statement.

use super::robot_moves::Joints;
use crate::planning::geometry::frame::Frame;

/// Something that the control does.
#[derive(Debug, Clone, PartialEq)]
pub enum RobotEvent {
    /// All joints go together to these angles.
    JointsTo {
        /// Degrees.
        joints: Joints,
    },
    /// All joints go together to where the tool has this pose; the way between is the control's own.
    PoseTo {
        /// In the base frame in force.
        frame: Frame,
        /// Whether the end may be rounded off.
        blend: bool,
    },
    /// The tool goes straight to this pose.
    Line {
        /// In the base frame in force.
        frame: Frame,
        /// Whether the end may be rounded off.
        blend: bool,
    },
    /// The tool frame changes.
    Tool {
        /// In the flange.
        frame: Frame,
    },
    /// The base frame changes.
    Base {
        /// In the robot's frame.
        frame: Frame,
    },
    /// The speed of the tool tip changes.
    PathSpeed {
        /// mm/s.
        mm_s: f64,
    },
    /// The speed of the tool's orientation changes.
    TurnSpeed {
        /// deg/s, the smaller of the control's two limits.
        deg_s: f64,
    },
    /// How far ends may be rounded off changes.
    BlendDistance {
        /// mm.
        mm: f64,
    },
    /// A digital output is set or cleared, at once or as the next motion begins.
    Output {
        /// Its number.
        number: u32,
        /// Set or cleared.
        on: bool,
    },
    /// Nothing moves for a while.
    Dwell {
        /// How long, in s.
        seconds: f64,
    },
    /// The program stops until the operator goes on.
    Halt,
    /// The end of the program.
    End,
}

/// An event and where in which file of the program it was caused.
#[derive(Debug, Clone, PartialEq)]
pub struct RobotExecuted {
    /// Index of the file.
    pub file: usize,
    /// Line number in it, from 1.
    pub line: usize,
    /// What is done.
    pub event: RobotEvent,
}
