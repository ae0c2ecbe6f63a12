//! The neutral form of a robot program: where the tool goes, layer by layer, in the frame of the part.

use crate::planning::geometry::frame::{Frame, Pose};

/// The six joint angles of a robot in degrees.
pub type Joints = [f64; 6];

/// What a straight move of the tool is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// Through air, at travel speed; the control may round its end off.
    Free,
    /// Through air, at travel speed, with an exact stop: to where a turn, a cut or another layer begins.
    Approach,
    /// The blade turns, and may go to its next tip meanwhile; exact stop.
    Turn,
    /// A cut at cutting speed; exact stop.
    Cut,
}

/// One step of a robot program.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RobotStep {
    /// The tool goes straight to a pose, turning on the way as much as the pose says.
    Move {
        /// Where it goes.
        to: Pose,
        /// What for.
        purpose: Purpose,
    },
    /// The generator of the blade goes on or off, as the next move begins.
    Ultrasonic {
        /// On or off.
        on: bool,
    },
}

/// Along which axis of the tool frame a cell has its tools point. Poses here have it along Z.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ToolDirection {
    /// Z, as in robotics at large.
    Z,
    /// X, as KUKA's own tools have it.
    X,
}

/// The speeds of a robot program.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Speeds {
    /// mm/s in a cut.
    pub cutting_mm_s: f64,
    /// mm/s elsewhere.
    pub travel_mm_s: f64,
    /// deg/s of the tool's orientation.
    pub angular_deg_s: f64,
}

/// What the control must know before the first move.
#[derive(Debug, Clone, PartialEq)]
pub struct RobotSetup {
    /// Tool tip in the flange, as calibrated; its axes as `tool_direction` says.
    pub tool: Frame,
    /// The part's frame in the robot's.
    pub base: Frame,
    /// Along which axis the tool points.
    pub tool_direction: ToolDirection,
    /// Where the program begins and ends.
    pub home: Joints,
    /// Where the first straight move begins, if an arm is known that can say so: above the part.
    pub approach: Option<Joints>,
    /// The speeds.
    pub speeds: Speeds,
    /// How far the end of a free move may be rounded off, in mm.
    pub blend_mm: f64,
    /// The digital output of the ultrasonic generator.
    pub ultrasonic_output: u32,
    /// The longest sub-program, in lines.
    pub max_lines: usize,
}

/// The steps of a layer. It begins and ends on the safety plane, so that a program can be started at each.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Layer {
    /// What is done, in order.
    pub steps: Vec<RobotStep>,
}

/// A program for a robot.
#[derive(Debug, Clone, PartialEq)]
pub struct RobotProgram {
    /// What holds throughout.
    pub setup: RobotSetup,
    /// The layers in order, from the top.
    pub layers: Vec<Layer>,
}
