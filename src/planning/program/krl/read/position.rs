//! Where a motion goes.

use nalgebra::Vector3;

use super::machine::{Machine, Setting, Spot};
use super::memory::Memory;
use super::statement::{Aggregate, Fault, Motion, Origin, Target, Value, Way};
use crate::planning::geometry::frame::Frame;
use crate::planning::program::robot_events::RobotEvent;

/// Components of a place.
const PLACE: [&str; 6] = ["X", "Y", "Z", "A", "B", "C"];

/// Components of joint angles.
const JOINTS: [&str; 6] = ["A1", "A2", "A3", "A4", "A5", "A6"];

/// Components of external axes. The cells planned here have none.
const EXTERNAL: [&str; 6] = ["E1", "E2", "E3", "E4", "E5", "E6"];

/// Components that say by which of its branches the arm reaches a place.
const BRANCH: [&str; 2] = ["S", "T"];

/// Lengths in mm and angles in degrees beyond this are no robot's.
const LARGEST: f64 = 1e6;

/// What the components of a point say.
enum Point {
    /// X Y Z A B C.
    Place([Option<f64>; 6]),
    /// A1 to A6.
    Joints([Option<f64>; 6]),
}

impl Machine {
    /// Carries a motion out. `column` is that of its first word.
    ///
    /// # Errors
    /// What it depends on and does not stand in the text.
    pub(super) fn go(
        &mut self,
        motion: &Motion,
        spot: Spot,
        column: usize,
        memory: &Memory,
        module: &str,
    ) -> Result<(), Fault> {
        let at_target = |message: String| Fault::new(motion.target.column, message);
        let point = match &motion.target.value {
            Target::Here => return Ok(()),
            Target::Written(aggregate) => point(aggregate)?,
            Target::Named(place) => match memory.get(module, place).map_err(at_target)? {
                Value::Aggregate(aggregate) => point(aggregate).map_err(|fault| at_target(fault.message))?,
                _ => return Err(at_target("this is no point".to_owned())),
            },
        };
        match (point, motion.way) {
            (Point::Joints(_), Way::Line) => {
                Err(at_target("a straight motion goes to a place, not to joint angles".to_owned()))
            }
            (Point::Joints(_), Way::Joint) if motion.blend => Err(at_target(
                "a motion to joint angles ends there; rounded off, its end is not known".to_owned(),
            )),
            (Point::Joints(joints), Way::Joint) => self.turn_joints(motion, spot, joints),
            (Point::Place(place), way) => {
                self.check_frames(column)?;
                let frame = self.arrive(motion, place)?;
                let blend = motion.blend;
                self.motion(
                    spot,
                    match way {
                        Way::Line => RobotEvent::Line { frame, blend },
                        Way::Joint => RobotEvent::PoseTo { frame, blend },
                    },
                );
                Ok(())
            }
        }
    }

    fn turn_joints(&mut self, motion: &Motion, spot: Spot, given: [Option<f64>; 6]) -> Result<(), Fault> {
        let relative = motion.from != Origin::Base;
        let mut joints = [0.0; 6];
        for (index, joint) in joints.iter_mut().enumerate() {
            let before = self.joints[index];
            let after = match (relative, given[index], before) {
                (false, Some(angle), _) => Some(angle),
                (false, None, before) => before,
                (true, given, before) => before.map(|before| before + given.unwrap_or(0.0)),
            };
            *joint = known(after, JOINTS[index], motion)?;
        }
        self.joints = joints.map(Some);
        self.place = [None; 6];
        self.motion(spot, RobotEvent::JointsTo { joints });
        Ok(())
    }

    /// A place counts in the base frame, and is that of the tool's tip: both must be known.
    fn check_frames(&self, column: usize) -> Result<(), Fault> {
        for setting in [&self.base, &self.tool] {
            if let Setting::Unknown(why) = setting {
                return Err(Fault::new(column, format!("where this goes is not known: {why}")));
            }
        }
        Ok(())
    }

    /// The tool comes to a place.
    fn arrive(&mut self, motion: &Motion, given: [Option<f64>; 6]) -> Result<Frame, Fault> {
        let mut place = [0.0; 6];
        for (index, component) in place.iter_mut().enumerate() {
            let stays = if motion.from == Origin::Base {
                given[index].or(self.place[index])
            } else {
                self.place[index]
            };
            *component = known(stays, PLACE[index], motion)?;
        }
        if motion.from != Origin::Base {
            shift(&mut place, motion, given)?;
        }
        self.place = place.map(Some);
        self.joints = [None; 6];
        Ok(frame(place))
    }
}

fn known(value: Option<f64>, name: &str, motion: &Motion) -> Result<f64, Fault> {
    match value {
        Some(value) if value.abs() <= LARGEST => Ok(value),
        Some(value) => {
            Err(Fault::new(motion.target.column, format!("{name} {value} is no place for a robot")))
        }
        None => {
            let message = format!("{name} is not given, and nothing before says what it is");
            Err(Fault::new(motion.target.column, message))
        }
    }
}

fn frame([x_mm, y_mm, z_mm, a_deg, b_deg, c_deg]: [f64; 6]) -> Frame {
    Frame { x_mm, y_mm, z_mm, a_deg, b_deg, c_deg }
}

/// A relative motion shifts the tool. How one turns it differs between controls, so none is read that does.
fn shift(place: &mut [f64; 6], motion: &Motion, given: [Option<f64>; 6]) -> Result<(), Fault> {
    let [x, y, z, turns @ ..] = given.map(|component| component.unwrap_or(0.0));
    if turns != [0.0; 3] {
        return Err(Fault::new(motion.target.column, "a relative motion that turns the tool is refused"));
    }
    let mut way = Vector3::new(x, y, z);
    if motion.from == Origin::HereAlongTool {
        way = frame(*place).pose().rotation * way;
    }
    for (component, shift) in place.iter_mut().zip(way.iter()) {
        *component += shift;
    }
    Ok(())
}

/// What a structure says as a point.
fn point(aggregate: &Aggregate) -> Result<Point, Fault> {
    let (mut place, mut joints) = ([None; 6], [None; 6]);
    for (name, value) in &aggregate.components {
        let number = value.value.number().filter(|number| number.abs() <= LARGEST);
        let Some(number) = number else {
            return Err(Fault::new(
                value.column,
                format!("{} needs a number that a robot can have", name.value),
            ));
        };
        let index = |names: &[&str; 6]| names.iter().position(|known| *known == name.value);
        if let Some(index) = index(&PLACE) {
            place[index] = Some(number);
        } else if let Some(index) = index(&JOINTS) {
            joints[index] = Some(number);
        } else if index(&EXTERNAL).is_some() {
            if number != 0.0 {
                return Err(Fault::new(value.column, "an external axis moves; the cells here have none"));
            }
        } else if !BRANCH.contains(&name.value.as_str()) {
            return Err(Fault::new(name.column, format!("a point has no {}", name.value)));
        }
    }
    sort(aggregate, place, joints)
}

fn sort(aggregate: &Aggregate, place: [Option<f64>; 6], joints: [Option<f64>; 6]) -> Result<Point, Fault> {
    let has = |values: &[Option<f64>; 6]| values.iter().any(Option::is_some);
    let column = aggregate.components.first().map_or(1, |(name, _)| name.column);
    let kind = aggregate.kind.as_deref();
    match (has(&place), has(&joints), kind) {
        (true, false, None | Some("FRAME" | "POS" | "E6POS")) => Ok(Point::Place(place)),
        (false, true, None | Some("AXIS" | "E6AXIS")) => Ok(Point::Joints(joints)),
        (_, _, Some(kind)) => Err(Fault::new(column, format!("these are not the components of a {kind}"))),
        (true, true, None) => Err(Fault::new(column, "a point is a place or joint angles, not both")),
        (false, false, None) => Err(Fault::new(column, "a point has neither place nor joint angles")),
    }
}

/// A frame of which every component must be given, or stand in `before`.
pub(super) fn whole_frame(aggregate: &Aggregate, before: Option<Frame>) -> Result<Frame, Fault> {
    let column = aggregate.components.first().map_or(1, |(name, _)| name.column);
    let Point::Place(given) = point(aggregate)? else {
        return Err(Fault::new(column, "joint angles are no frame"));
    };
    let before =
        before.map(|Frame { x_mm, y_mm, z_mm, a_deg, b_deg, c_deg }| [x_mm, y_mm, z_mm, a_deg, b_deg, c_deg]);
    let mut whole = [0.0; 6];
    for (index, component) in whole.iter_mut().enumerate() {
        let value = given[index].or_else(|| before.map(|before| before[index]));
        let missing = || {
            Fault::new(column, format!("{} is not given, and nothing before says what it is", PLACE[index]))
        };
        *component = value.ok_or_else(missing)?;
    }
    Ok(frame(whole))
}
