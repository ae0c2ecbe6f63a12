//! The neutral form of a tape-cutting program: what the axes, knives and clocks do, one after the other.

use crate::planning::tape::label::CourseLabel;

/// Where every axis of a tape cutter stands. Entries of a cutter that the machine does not have stay 0.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Pose {
    /// Tape advance in mm; never decreases.
    pub feed_mm: f64,
    /// Carriage of each cutter in mm across the tape, +V as in domain.md A3.
    pub lateral_mm: [f64; 2],
    /// Blade of each cutter in degrees from the V direction: `atan2(dU, dV)`.
    pub blade_deg: [f64; 2],
}

/// One step of a program.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Step {
    /// All axes go straight and together to a pose and stop there.
    Move {
        /// Where they go.
        to: Pose,
        /// How long it would take at cruising speed, in s; acceleration comes on top.
        cruise_s: f64,
    },
    /// The press of a cutter (0 is cutter 1) goes down or up.
    Knife {
        /// Index of the cutter.
        cutter: usize,
        /// Down or up.
        down: bool,
    },
    /// The knives' generator goes on or off.
    Ultrasonic {
        /// On or off.
        on: bool,
    },
    /// Nothing moves for a while.
    Dwell {
        /// How long, in s.
        seconds: f64,
    },
    /// The cuts of a course begin here. A program can be restarted here if no knife is down.
    Course {
        /// What it is called.
        label: CourseLabel,
        /// Whether no knife is down.
        restartable: bool,
    },
    /// The operator may stop here.
    OptionalStop,
}

/// A program for a tape cutter. It starts with all outputs off.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TapeProgram {
    /// What is done, in order.
    pub steps: Vec<Step>,
    /// Cycle time in s with accelerations, each move from rest to rest.
    pub time_s: f64,
    /// How much of `time_s` is the way of the tape from 0 into its place, for a program that goes on within a roll: it
    /// takes nothing where the tape stands there already.
    pub approach_s: f64,
    /// When each step is done, in s from the start.
    pub ends_s: Vec<f64>,
    /// Where the axes are when the first step begins. A program that does not start at its machine's home begins with
    /// a restartable course, which brings them there from wherever they are.
    pub start: Pose,
    /// Whether knives stay up and the generator off: the moves alone.
    pub dry: bool,
}
