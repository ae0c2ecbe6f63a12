//! Steps 1 to 5 of the conversion: the points of a milling program, and which ways to them are cuts.

use super::MillingPoint;
use super::findings::{Findings, Kind};
use crate::planning::finding::Code;
use crate::planning::geometry::Point3;
use crate::planning::honeycomb::milling::Blank;
use crate::planning::program::krl::read::statement::{
    Aggregate, Fault, Line, Motion, Origin, Statement, Target,
};
use crate::planning::tolerance::SAME_POINT_MM;

/// A point, and how the milling program goes there.
#[derive(Debug, Clone, Copy)]
pub(super) struct Point {
    pub(super) milling: MillingPoint,
    pub(super) motion: Option<MotionOf>,
}

/// How a milling program goes to a point that is no cut.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct MotionOf {
    /// By a straight line, or by joints.
    pub(super) straight: bool,
    /// Whether its end may be rounded off.
    pub(super) blend: bool,
}

/// All points of a program, in the order of its lines.
pub(super) fn points(lines: &[Line<'_>], blank: &Blank, findings: &mut Findings<'_>) -> Vec<Point> {
    let mut walk = Walk { blank, findings, last: [None; 3], previous: None, points: Vec::new() };
    for line in lines.iter().filter(|line| line.is_motion()) {
        let done = match &line.statement {
            Ok(Statement::Move(motion)) => walk.motion(line, motion),
            Ok(_) => Ok(()),
            Err(fault) => Err(fault.clone()),
        };
        if let Err(Fault { column, message }) = done {
            walk.findings.error(
                Kind::Unreadable,
                Code::UnreadableProgram,
                line.number,
                Some(column),
                message,
            );
        }
    }
    walk.points
}

/// A walk along the milling path.
struct Walk<'a, 'b> {
    blank: &'a Blank,
    findings: &'a mut Findings<'b>,
    /// X, Y and Z as they were last given.
    last: [Option<f64>; 3],
    /// The point before, unless something else came between.
    previous: Option<Point3>,
    points: Vec<Point>,
}

/// What the components of a point say here. How the cutter was turned does not matter: it is round.
enum Components {
    Place([Option<f64>; 3]),
    Joints,
}

impl Walk<'_, '_> {
    fn motion(&mut self, line: &Line<'_>, motion: &Motion) -> Result<(), Fault> {
        let column = motion.target.column;
        let at_target = |message: &str| Err(Fault { column, message: message.to_owned() });
        let given = match &motion.target.value {
            Target::Here => return Ok(()),
            Target::Named(_) => {
                return at_target("a point is written out here; its data list is not at hand");
            }
            Target::Written(aggregate) => match components(aggregate)? {
                Components::Place(given) => given,
                Components::Joints => {
                    self.joints(line);
                    return Ok(());
                }
            },
        };
        for (index, last) in self.last.iter_mut().enumerate() {
            *last = match (motion.from, given[index]) {
                (Origin::HereAlongTool, _) => return at_target("how the cutter was turned is not followed"),
                (Origin::Base, given) => given.or(*last),
                (Origin::HereAlongBase, shift) => last.map(|last| last + shift.unwrap_or(0.0)),
            };
        }
        let [Some(x), Some(y), Some(z)] = self.last else {
            return at_target("X, Y or Z is not given, and nothing before says what it is");
        };
        self.point(line, Point3::new(x, y, z), motion);
        Ok(())
    }

    fn joints(&mut self, line: &Line<'_>) {
        if self.previous.take().is_some() {
            let message = "a motion to joint angles stands as it was; look whether the blade is clear there";
            self.findings.warning(Kind::Joints, Code::StrangePath, line.number, message.to_owned());
        }
    }

    fn point(&mut self, line: &Line<'_>, position: Point3, motion: &Motion) {
        let cut = self
            .previous
            .is_some_and(|previous| position.y != previous.y && position.z < self.blank.height_mm);
        self.judge_place(line.number, &position, cut);
        if let Some(previous) = self.previous.filter(|_| cut) {
            self.judge_cut(line.number, &previous, &position);
        }
        let straight = motion.way == crate::planning::program::krl::read::statement::Way::Line;
        let motion = (!cut).then_some(MotionOf { straight, blend: motion.blend });
        self.points.push(Point { milling: MillingPoint { line: line.number, position, cut }, motion });
        self.previous = Some(position);
    }

    fn judge_place(&mut self, line: usize, position: &Point3, cut: bool) {
        let (x, z, width) = (position.x, position.z, self.blank.width_mm);
        if z < 0.0 {
            let message = format!("z is {z}; below 0 lies what the blank stands on");
            self.findings.error(Kind::Below, Code::OutOfRange, line, None, message);
        }
        if cut && !(0.0..=width).contains(&x) {
            let message = format!("a cut at x = {x} beside the blank, which goes from 0 to {width}");
            self.findings.warning(Kind::Beside, Code::StrangePath, line, message);
        }
    }

    fn judge_cut(&mut self, line: usize, from: &Point3, to: &Point3) {
        if (from.x - to.x).abs() > SAME_POINT_MM || (from.z - to.z).abs() > SAME_POINT_MM {
            let message = format!(
                "a path from x = {}, z = {} to x = {}, z = {} that is not parallel to y; it is cut where it ends",
                from.x, from.z, to.x, to.z
            );
            self.findings.warning(Kind::Diagonal, Code::StrangePath, line, message);
        }
        let middle = self.blank.length_mm / 2.0;
        if (from.y > middle) == (to.y > middle) {
            let message = format!(
                "a path from y = {} to {} within one half of the blank; it becomes a cut through the whole of it",
                from.y, to.y
            );
            self.findings.warning(Kind::OneSided, Code::StrangePath, line, message);
        }
    }
}

fn components(aggregate: &Aggregate) -> Result<Components, Fault> {
    let mut place = [None; 3];
    let mut joints = false;
    for (name, value) in &aggregate.components {
        let fault =
            |message: &str| Fault { column: value.column, message: format!("{} {message}", name.value) };
        let number = value.value.number().ok_or_else(|| fault("needs a number"))?;
        match name.value.as_str() {
            "X" => place[0] = Some(number),
            "Y" => place[1] = Some(number),
            "Z" => place[2] = Some(number),
            "A" | "B" | "C" | "S" | "T" => {}
            "A1" | "A2" | "A3" | "A4" | "A5" | "A6" => joints = true,
            "E1" | "E2" | "E3" | "E4" | "E5" | "E6" if number == 0.0 => {}
            "E1" | "E2" | "E3" | "E4" | "E5" | "E6" => {
                return Err(fault("moves; the cells here have none such"));
            }
            _ => {
                return Err(Fault { column: name.column, message: format!("a point has no {}", name.value) });
            }
        }
    }
    let has_place = place != [None; 3];
    match (has_place, joints) {
        (true, true) => {
            let column = aggregate.components.first().map_or(1, |(name, _)| name.column);
            Err(Fault { column, message: "a point is a place or joint angles, not both".to_owned() })
        }
        (false, true) => Ok(Components::Joints),
        (_, false) => Ok(Components::Place(place)),
    }
}
