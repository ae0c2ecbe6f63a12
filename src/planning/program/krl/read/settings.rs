//! System variables, and the commands of BAS that set them.

use super::machine::{Machine, Setting, Spot};
use super::memory::{Memory, component, said};
use super::position::whole_frame;
use super::statement::{Aggregate, Assignment, At, Expression, Fault, Place, Value};
use crate::planning::geometry::frame::Frame;
use crate::planning::program::robot_events::RobotEvent;

/// System variables that change neither the way of the tool nor its speed along it: how far the control looks ahead,
/// accelerations, joint speeds, load, how arcs are meant, how ends are rounded off by other measures than distance,
/// stops in backward running, which numbers the teach pendant shows.
const IDLE: [&str; 15] = [
    "$ADVANCE",
    "$ACC",
    "$VEL_AXIS",
    "$ACC_AXIS",
    "$VEL_EXTAX",
    "$ACC_EXTAX",
    "$JERK",
    "$GEAR_JERK",
    "$LOAD",
    "$CIRC_TYPE",
    "$BWDSTART",
    "$ACT_TOOL",
    "$ACT_BASE",
    "$TARGET_STATUS",
    "$TORQMON_DEF",
];

/// The frame that changes nothing, under the names that the control has for it.
const NULL_FRAMES: [&str; 2] = ["$NULLFRAME", "$WORLD"];

/// The highest number of an output of the control.
const MOST_OUTPUTS: i64 = 8192;

/// What surrounds a statement that sets something.
pub(super) struct Context<'a> {
    pub(super) spot: Spot,
    pub(super) module: &'a str,
    pub(super) memory: &'a mut Memory,
}

impl Context<'_> {
    /// What an expression is.
    ///
    /// # Errors
    /// That it does not stand in the text.
    pub(super) fn value(&self, expression: &At<Expression>) -> Result<Value, Fault> {
        match &expression.value {
            Expression::Value(value) => Ok(value.clone()),
            Expression::Place(place) => self
                .memory
                .get(self.module, place)
                .cloned()
                .map_err(|message| Fault::new(expression.column, message)),
        }
    }

    /// An expression as a number.
    ///
    /// # Errors
    /// That it is none, or does not stand in the text.
    pub(super) fn number(&self, expression: &At<Expression>) -> Result<f64, Fault> {
        let value = self.value(expression)?;
        value.number().ok_or_else(|| Fault::new(expression.column, "a number belongs here"))
    }
}

impl Machine {
    /// Carries an assignment out.
    ///
    /// # Errors
    /// What is not known, or changes something in a way that is not.
    pub(super) fn assign(&mut self, assignment: &Assignment, context: &mut Context<'_>) -> Result<(), Fault> {
        let Assignment { place: At { column, value: place }, value } = assignment;
        let spot = context.spot;
        match (place.name.as_str(), place.field.as_deref()) {
            (name, _) if IDLE.contains(&name) => Ok(()),
            ("$TOOL", None) => {
                let tool = self.frame_setting(value, self.tool.clone(), context)?;
                self.set_tool(spot, tool);
                Ok(())
            }
            ("$BASE", None) => {
                let base = self.frame_setting(value, self.base.clone(), context)?;
                self.set_base(spot, base);
                Ok(())
            }
            ("$VEL", Some(part @ ("CP" | "ORI1" | "ORI2"))) => {
                self.set_speed(spot, part, context.number(value)?, value.column)
            }
            ("$VEL", None) => self.set_parts(value, context, &["CP", "ORI1", "ORI2"], Self::set_speed),
            ("$APO", Some(part @ ("CDIS" | "CPTP" | "CVEL" | "CORI"))) => {
                self.set_blend(spot, part, context.number(value)?, value.column)
            }
            ("$APO", None) => {
                self.set_parts(value, context, &["CDIS", "CPTP", "CVEL", "CORI"], Self::set_blend)
            }
            ("$IPO_MODE", None) => expect_word(value, "BASE", context),
            ("$ORI_TYPE", None) => expect_word(value, "VAR", context),
            ("$OUT", None) => {
                let (number, on) = output(assignment, context)?;
                self.event(spot, RobotEvent::Output { number, on });
                Ok(())
            }
            (name, _) if context.memory.knows(context.module, name) => {
                let new = context.value(value)?;
                context.memory.set(context.module, place, new).map_err(|message| Fault::new(*column, message))
            }
            _ => Err(Fault::new(*column, format!("what setting {} changes is not known", said(place)))),
        }
    }

    /// An output that changes as the next motion begins.
    pub(super) fn trigger(&mut self, output_of: &Assignment, context: &Context<'_>) -> Result<(), Fault> {
        let (number, on) = output(output_of, context)?;
        self.wait_for_motion(context.spot, output_of.place.column, number, on)
    }

    /// Each part of a structure by itself.
    fn set_parts(
        &mut self,
        value: &At<Expression>,
        context: &Context<'_>,
        parts: &[&str],
        set: fn(&mut Self, Spot, &str, f64, usize) -> Result<(), Fault>,
    ) -> Result<(), Fault> {
        let Value::Aggregate(aggregate) = context.value(value)? else {
            return Err(Fault::new(value.column, "the parts of this are named"));
        };
        for (name, part) in &aggregate.components {
            let number = part.value.number().filter(|_| parts.contains(&name.value.as_str()));
            let Some(number) = number else {
                return Err(Fault::new(value.column, format!("what {} changes is not known", name.value)));
            };
            set(self, context.spot, &name.value, number, value.column)?;
        }
        Ok(())
    }

    fn set_speed(&mut self, spot: Spot, part: &str, value: f64, column: usize) -> Result<(), Fault> {
        if value <= 0.0 {
            return Err(Fault::new(column, format!("{value} is no speed")));
        }
        match part {
            "CP" => self.event(spot, RobotEvent::PathSpeed { mm_s: value * 1000.0 }),
            _ => {
                self.turn[usize::from(part == "ORI2")] = Some(value);
                let slowest = self.turn.iter().flatten().copied().fold(f64::INFINITY, f64::min);
                self.event(spot, RobotEvent::TurnSpeed { deg_s: slowest });
            }
        }
        Ok(())
    }

    fn set_blend(&mut self, spot: Spot, part: &str, value: f64, column: usize) -> Result<(), Fault> {
        if value < 0.0 {
            return Err(Fault::new(column, format!("{value} is no distance")));
        }
        if part == "CDIS" {
            self.event(spot, RobotEvent::BlendDistance { mm: value });
        }
        Ok(())
    }

    /// A tool or base frame. One that stands in the control only is taken as unknown, and refused where it matters.
    fn frame_setting(
        &self,
        value: &At<Expression>,
        before: Setting,
        context: &Context<'_>,
    ) -> Result<Setting, Fault> {
        match &value.value {
            Expression::Place(place) if NULL_FRAMES.contains(&place.name.as_str()) => {
                Ok(Setting::Known(Frame::default()))
            }
            Expression::Place(place) => match context.memory.get(context.module, place) {
                Ok(Value::Aggregate(frame)) => {
                    known_frame(frame, None).map_err(|fault| Fault::new(value.column, fault.message))
                }
                Ok(_) => Err(Fault::new(value.column, "a frame belongs here")),
                Err(why) => Ok(Setting::Unknown(why)),
            },
            Expression::Value(Value::Aggregate(frame)) => {
                let before = if let Setting::Known(frame) = before { Some(frame) } else { None };
                known_frame(frame, before)
            }
            Expression::Value(_) => Err(Fault::new(value.column, "a frame belongs here")),
        }
    }

    /// Carries a command of BAS out, the control's own program that sets motions up.
    ///
    /// # Errors
    /// A command that is not known here.
    pub(super) fn bas(
        &mut self,
        command: &At<String>,
        value: &At<Expression>,
        context: &Context<'_>,
    ) -> Result<(), Fault> {
        let spot = context.spot;
        match command.value.as_str() {
            "INITMOV" => {
                let left = |name| Setting::Unknown(format!("{name} is as BAS (#INITMOV,0 ) leaves it"));
                self.set_tool(spot, left("$TOOL"));
                self.set_base(spot, left("$BASE"));
                self.turn = [None; 2];
                Ok(())
            }
            "ACC_CP" | "ACC_PTP" | "VEL_PTP" | "PTP_DAT" => Ok(()),
            "VEL_CP" => self.set_speed(spot, "CP", context.number(value)?, value.column),
            "TOOL" => {
                let tool = numbered("TOOL_DATA", context.number(value)?, context);
                self.set_tool(spot, tool);
                Ok(())
            }
            "BASE" => {
                let base = numbered("BASE_DATA", context.number(value)?, context);
                self.set_base(spot, base);
                Ok(())
            }
            "FRAMES" | "PTP_PARAMS" => self.frames_of_form(command, context),
            "CP_PARAMS" => {
                self.frames_of_form(command, context)?;
                self.set_speed(spot, "CP", context.number(value)?, value.column)?;
                self.blend_of_form(command, context)
            }
            other => Err(Fault::new(command.column, format!("what BAS does for #{other} is not known here"))),
        }
    }

    /// Tool and base as the last form of the teach pendant has them.
    fn frames_of_form(&mut self, command: &At<String>, context: &Context<'_>) -> Result<(), Fault> {
        let form = form("FDAT_ACT", command, context)?;
        let number = |name: &str| {
            let value = component(&form, name).and_then(Value::number);
            value.ok_or_else(|| Fault::new(command.column, format!("FDAT_ACT has no {name}")))
        };
        let (tool, base) = (number("TOOL_NO")?, number("BASE_NO")?);
        if component(&form, "IPO_FRAME") != Some(&Value::Word("BASE".to_owned())) {
            return Err(Fault::new(command.column, "the tool does not stand still here; only #BASE is read"));
        }
        self.set_tool(context.spot, numbered("TOOL_DATA", tool, context));
        self.set_base(context.spot, numbered("BASE_DATA", base, context));
        Ok(())
    }

    fn blend_of_form(&mut self, command: &At<String>, context: &Context<'_>) -> Result<(), Fault> {
        let form = form("LDAT_ACT", command, context)?;
        if component(&form, "ORI_TYP").is_some_and(|kind| *kind != Value::Word("VAR".to_owned())) {
            return Err(Fault::new(command.column, "only orientations of the kind #VAR are read"));
        }
        match component(&form, "APO_DIST").and_then(Value::number) {
            Some(distance) => self.set_blend(context.spot, "CDIS", distance, command.column),
            None => Err(Fault::new(command.column, "LDAT_ACT has no APO_DIST")),
        }
    }
}

fn form(name: &str, command: &At<String>, context: &Context<'_>) -> Result<Aggregate, Fault> {
    let place = Place { name: name.to_owned(), index: None, field: None };
    match context.memory.get(context.module, &place) {
        Ok(Value::Aggregate(form)) => Ok(form.clone()),
        _ => Err(Fault::new(command.column, format!("{name} has not been set before this"))),
    }
}

/// A frame of the control by its number; 0 is none.
fn numbered(array: &str, number: f64, context: &Context<'_>) -> Setting {
    if number == 0.0 {
        return Setting::Known(Frame::default());
    }
    if number.fract() != 0.0 {
        return Setting::Unknown(format!("{number} is the number of no frame"));
    }
    let place = Place { name: array.to_owned(), index: Some(number as i64), field: None };
    match context.memory.get(context.module, &place) {
        Ok(Value::Aggregate(frame)) => {
            known_frame(frame, None).unwrap_or_else(|fault| Setting::Unknown(fault.message))
        }
        Ok(_) => Setting::Unknown(format!("{} is no frame", said(&place))),
        Err(why) => Setting::Unknown(why),
    }
}

fn known_frame(frame: &Aggregate, before: Option<Frame>) -> Result<Setting, Fault> {
    whole_frame(frame, before).map(Setting::Known)
}

fn expect_word(value: &At<Expression>, word: &str, context: &Context<'_>) -> Result<(), Fault> {
    match context.value(value)? {
        Value::Word(found) if found == word => Ok(()),
        _ => Err(Fault::new(
            value.column,
            format!("only #{word} is read: it decides along which way tools go"),
        )),
    }
}

/// Which output an assignment sets, and to what.
fn output(assignment: &Assignment, context: &Context<'_>) -> Result<(u32, bool), Fault> {
    let Assignment { place, value } = assignment;
    let number = place.value.index.filter(|number| (1..=MOST_OUTPUTS).contains(number));
    let number = number.and_then(|number| u32::try_from(number).ok());
    match (number, context.value(value)?) {
        (Some(number), Value::Truth(on)) => Ok((number, on)),
        (None, _) => Err(Fault::new(place.column, format!("outputs are numbered from 1 to {MOST_OUTPUTS}"))),
        _ => Err(Fault::new(value.column, "an output becomes TRUE or FALSE")),
    }
}
