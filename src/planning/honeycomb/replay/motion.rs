//! From the events of a program to the straight motions of the tool, each with its time: what the control does.

use nalgebra::Vector3;

use super::ReplaySetup;
use crate::planning::finding::{Code, Finding};
use crate::planning::geometry::frame::{Frame, Pose};
use crate::planning::program::robot_events::{RobotEvent, RobotExecuted};
use crate::planning::program::robot_moves::Joints;
use crate::planning::tolerance::{PRINTED_DEG, PRINTED_MM};

/// Where in a program something stands: index of the file, and line from 1.
pub type Place = (usize, usize);

/// A straight motion of the tool, in the frame of the part.
#[derive(Debug, Clone, PartialEq)]
pub struct Motion {
    /// Where it begins; tool Z points out through the tip.
    pub from: Pose,
    /// Where it ends.
    pub to: Pose,
    /// Way of the tip in mm.
    pub distance_mm: f64,
    /// True turn of the tool, in degrees.
    pub turn_deg: f64,
    /// The longer of both, in s.
    pub seconds: f64,
    /// Speed of the tip in mm/s as programmed.
    pub path_speed_mm_s: f64,
    /// Whether the blade sounds.
    pub ultrasonic: bool,
    /// How far its end may be rounded off, in mm.
    pub blend_mm: f64,
    /// Where it stands.
    pub place: Place,
}

/// What happens in a program, in order.
#[derive(Debug, Clone, PartialEq)]
pub enum Happening {
    /// A straight motion.
    Straight(Motion),
    /// The joints bring the tool somewhere on a way of their own.
    Joints {
        /// Where the tool was, if that is known.
        from: Option<Pose>,
        /// Where it is then, if that is known.
        to: Option<Pose>,
        /// The joint angles in degrees, if the program names them.
        joints: Option<Joints>,
        /// Where it stands.
        place: Place,
    },
}

impl Motion {
    /// Whether the tool turns at all.
    #[must_use]
    pub fn turns(&self) -> bool {
        self.turn_deg > PRINTED_DEG
    }

    /// Whether it goes along the cuts: only y changes.
    #[must_use]
    pub fn along_y(&self) -> bool {
        let way = self.way();
        way.x.abs() <= PRINTED_MM && way.z.abs() <= PRINTED_MM && way.y.abs() > PRINTED_MM
    }

    /// The way of the tip in mm.
    #[must_use]
    pub fn way(&self) -> Vector3<f64> {
        self.to.translation.vector - self.from.translation.vector
    }
}

/// Runs the events of a program.
///
/// The findings are errors: other frames than the cell's, a motion without a speed, an end that is not one.
#[must_use]
pub fn run(setup: &ReplaySetup<'_>, events: &[RobotExecuted]) -> (Vec<Happening>, Vec<Finding>) {
    let mut control = Control::new(setup);
    for executed in events {
        control.execute(executed);
    }
    control.finish(events);
    (control.happenings, control.findings)
}

struct Control<'a> {
    setup: &'a ReplaySetup<'a>,
    here: Option<Pose>,
    path_speed: Option<f64>,
    turn_speed: Option<f64>,
    blend_mm: f64,
    tool_given: bool,
    base_given: bool,
    ultrasonic: bool,
    ended: bool,
    happenings: Vec<Happening>,
    findings: Vec<Finding>,
}

impl<'a> Control<'a> {
    fn new(setup: &'a ReplaySetup<'a>) -> Self {
        Self {
            setup,
            here: None,
            path_speed: None,
            turn_speed: None,
            blend_mm: 0.0,
            tool_given: false,
            base_given: false,
            ultrasonic: false,
            ended: false,
            happenings: Vec::new(),
            findings: Vec::new(),
        }
    }

    fn execute(&mut self, executed: &RobotExecuted) {
        let place = (executed.file, executed.line);
        match &executed.event {
            RobotEvent::JointsTo { joints } => self.joints_to(joints, place),
            RobotEvent::PoseTo { frame, .. } => self.pose_to(frame, place),
            RobotEvent::Line { frame, blend } => self.line(frame, *blend, place),
            RobotEvent::Tool { frame } => {
                self.tool_given = true;
                self.same_frame("$TOOL", frame, &self.setup.cell.tool, place);
            }
            RobotEvent::Base { frame } => {
                self.base_given = true;
                self.same_frame("$BASE", frame, &self.setup.cell.base, place);
            }
            RobotEvent::PathSpeed { mm_s } => self.path_speed = Some(*mm_s),
            RobotEvent::TurnSpeed { deg_s } => self.turn_speed = Some(*deg_s),
            RobotEvent::BlendDistance { mm } => self.blend_mm = *mm,
            RobotEvent::Output { number, on } => self.output(*number, *on, place),
            RobotEvent::Dwell { .. } | RobotEvent::Halt => {}
            RobotEvent::End => self.ended = true,
        }
    }

    fn joints_to(&mut self, joints: &Joints, place: Place) {
        let cell = self.setup.cell;
        let to = cell.robot.as_ref().map(|robot| cell.as_neutral(&robot.tip(joints)));
        self.happenings.push(Happening::Joints { from: self.here, to, joints: Some(*joints), place });
        self.here = to;
    }

    fn pose_to(&mut self, frame: &Frame, place: Place) {
        let to = Some(self.neutral(frame));
        self.happenings.push(Happening::Joints { from: self.here, to, joints: None, place });
        self.here = to;
    }

    fn line(&mut self, frame: &Frame, blend: bool, place: Place) {
        let to = self.neutral(frame);
        match (self.here, self.path_speed, self.turn_speed) {
            (Some(from), Some(path), Some(turn)) => {
                let blend_mm = if blend { self.blend_mm } else { 0.0 };
                self.happenings.push(Happening::Straight(self.motion(
                    from,
                    to,
                    (path, turn),
                    blend_mm,
                    place,
                )));
            }
            (None, ..) => {
                // Without an arm nobody knows where joint angles have brought the tool.
                self.happenings.push(Happening::Joints { from: None, to: Some(to), joints: None, place });
            }
            _ => self.fault(Code::SpeedExceeded, place, "a straight motion before $VEL says how fast"),
        }
        self.here = Some(to);
    }

    fn motion(&self, from: Pose, to: Pose, speeds: (f64, f64), blend_mm: f64, place: Place) -> Motion {
        let distance_mm = (to.translation.vector - from.translation.vector).norm();
        let turn_deg = from.rotation.angle_to(&to.rotation).to_degrees();
        let (path_speed_mm_s, turn_speed) = speeds;
        // Printed digits are no turn.
        let turning_s = if turn_deg > PRINTED_DEG { turn_deg / turn_speed } else { 0.0 };
        let seconds = (distance_mm / path_speed_mm_s).max(turning_s);
        let ultrasonic = self.ultrasonic;
        Motion { from, to, distance_mm, turn_deg, seconds, path_speed_mm_s, ultrasonic, blend_mm, place }
    }

    /// A frame of the text with tool Z out through the tip.
    fn neutral(&self, frame: &Frame) -> Pose {
        self.setup.cell.as_neutral(&frame.pose())
    }

    fn same_frame(&mut self, name: &str, found: &Frame, wanted: &Frame, place: Place) {
        let (found, wanted) = (found.pose(), wanted.pose());
        let apart = (found.translation.vector - wanted.translation.vector).norm();
        let turned = found.rotation.angle_to(&wanted.rotation).to_degrees();
        if apart > PRINTED_MM || turned > PRINTED_DEG {
            let words = format!("{name} differs from the cell's by {apart:.3} mm and {turned:.3} degrees");
            self.fault(Code::WrongFrame, place, &words);
        }
    }

    fn output(&mut self, number: u32, on: bool, place: Place) {
        if number == self.setup.cell.ultrasonic_output {
            self.ultrasonic = on;
        } else {
            let words = format!(
                "output {number} is not the ultrasonic generator's, {}; look what it does in this cell",
                self.setup.cell.ultrasonic_output
            );
            self.findings.push(Finding::warning(Code::KnifeState, self.setup.at(place), words));
        }
    }

    fn finish(&mut self, events: &[RobotExecuted]) {
        let place = events.last().map_or((0, 1), |last| (last.file, last.line));
        if !self.ended {
            self.fault(Code::NoProgramEnd, place, "the program does not come to its end");
        }
        if self.ultrasonic {
            self.fault(Code::KnifeState, place, "the ultrasonic generator is on at the end");
        }
        if !(self.tool_given && self.base_given) {
            self.fault(Code::WrongFrame, place, "the program does not set both $TOOL and $BASE");
        }
    }

    fn fault(&mut self, code: Code, place: Place, words: &str) {
        self.findings.push(Finding::error(code, self.setup.at(place), words));
    }
}
