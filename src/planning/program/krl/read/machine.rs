//! The state of the control while a program runs, and what it does.

use super::statement::Fault;
use crate::planning::geometry::frame::Frame;
use crate::planning::program::robot_events::{RobotEvent, RobotExecuted};

/// A frame of the control.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Setting {
    /// It stands in the text.
    Known(Frame),
    /// It does not, because of this.
    Unknown(String),
}

/// A line of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Spot {
    /// Index of the file.
    pub(super) file: usize,
    /// Line number, from 1.
    pub(super) line: usize,
}

/// An output that waits for the next motion.
#[derive(Debug, Clone, Copy)]
pub(super) struct Waiting {
    pub(super) spot: Spot,
    pub(super) column: usize,
    number: u32,
    on: bool,
}

/// The control.
pub(super) struct Machine {
    pub(super) tool: Setting,
    pub(super) base: Setting,
    /// X Y Z A B C of the tool in the base frame, as far as the text says.
    pub(super) place: [Option<f64>; 6],
    /// The joint angles, as far as the text says.
    pub(super) joints: [Option<f64>; 6],
    /// ORI1 and ORI2 in deg/s.
    pub(super) turn: [Option<f64>; 2],
    pub(super) waiting: Vec<Waiting>,
    pub(super) events: Vec<RobotExecuted>,
}

impl Machine {
    pub(super) fn new() -> Self {
        let unset = |name: &str| Setting::Unknown(format!("{name} is not set before this"));
        Self {
            tool: unset("$TOOL"),
            base: unset("$BASE"),
            place: [None; 6],
            joints: [None; 6],
            turn: [None; 2],
            waiting: Vec::new(),
            events: Vec::new(),
        }
    }

    pub(super) fn event(&mut self, spot: Spot, event: RobotEvent) {
        self.events.push(RobotExecuted { file: spot.file, line: spot.line, event });
    }

    /// A motion, with the outputs that change as it begins.
    pub(super) fn motion(&mut self, spot: Spot, event: RobotEvent) {
        for waiting in std::mem::take(&mut self.waiting) {
            self.event(waiting.spot, RobotEvent::Output { number: waiting.number, on: waiting.on });
        }
        self.event(spot, event);
    }

    /// An output changes as the next motion begins.
    pub(super) fn wait_for_motion(
        &mut self,
        spot: Spot,
        column: usize,
        number: u32,
        on: bool,
    ) -> Result<(), Fault> {
        if self.waiting.len() == MOST_WAITING {
            let message = format!("more than {MOST_WAITING} triggers wait for one motion");
            return Err(Fault::new(column, message));
        }
        self.waiting.push(Waiting { spot, column, number, on });
        Ok(())
    }

    /// The tool frame changes. Where the tool stands is then not known, unless it is the same frame.
    pub(super) fn set_tool(&mut self, spot: Spot, tool: Setting) {
        if self.tool != tool {
            self.place = [None; 6];
        }
        if let Setting::Known(frame) = tool {
            self.event(spot, RobotEvent::Tool { frame });
        }
        self.tool = tool;
    }

    /// The base frame changes.
    pub(super) fn set_base(&mut self, spot: Spot, base: Setting) {
        if self.base != base {
            self.place = [None; 6];
        }
        if let Setting::Known(frame) = base {
            self.event(spot, RobotEvent::Base { frame });
        }
        self.base = base;
    }
}

/// A control takes no more triggers for one motion.
const MOST_WAITING: usize = 8;
