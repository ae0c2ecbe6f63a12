//! Step 6 of the conversion, and what becomes of the lines between.

use super::findings::{Findings, Kind};
use super::path::Point;
use super::{Conversion, ConvertedMove};
use crate::planning::finding::{Code, Finding};
use crate::planning::geometry::Point3;
use crate::planning::geometry::frame::Pose;
use crate::planning::honeycomb::blade::{Feed, Side};
use crate::planning::program::krl::emit;
use crate::planning::program::krl::read::statement::{Assignment, Line, Statement};
use crate::planning::program::krl::stem::Stem;
use crate::planning::program::robot_moves::Purpose;

/// System variables that the new setup has values for, or that only mattered for the milling.
const WRITTEN_ANEW: [&str; 14] = [
    "$TOOL",
    "$BASE",
    "$LOAD",
    "$VEL",
    "$ACC",
    "$APO",
    "$ORI_TYPE",
    "$IPO_MODE",
    "$ADVANCE",
    "$VEL_AXIS",
    "$ACC_AXIS",
    "FDAT_ACT",
    "LDAT_ACT",
    "PDAT_ACT",
];

/// Where the walk over the lines is.
#[derive(Clone, Copy, PartialEq)]
enum Part {
    /// Before DEF.
    Head,
    /// Behind DEF, before the new setup.
    Declarations,
    /// Behind the new setup.
    Body,
    /// Behind END.
    Ended,
}

/// Writes the new program.
pub(super) struct Rewriter<'a, 'b, 'c> {
    conversion: &'a Conversion<'a>,
    stem: &'a Stem,
    points: &'a [Point],
    findings: &'b mut Findings<'c>,
    part: Part,
    /// How many folds are open since `;FOLD INI`; nothing of it stays.
    initial_folds: usize,
    /// The next point.
    next: usize,
    /// In mm/s, as the control has it.
    speed: f64,
    ultrasonic: bool,
    /// The side and the feed of the posture that the blade is in.
    posture: (Side, Feed),
    lines: Vec<String>,
    moves: Vec<ConvertedMove>,
    non_ascii: bool,
}

impl<'a, 'b, 'c> Rewriter<'a, 'b, 'c> {
    pub(super) fn new(
        conversion: &'a Conversion<'a>,
        stem: &'a Stem,
        points: &'a [Point],
        findings: &'b mut Findings<'c>,
    ) -> Self {
        Self {
            conversion,
            stem,
            points,
            findings,
            part: Part::Head,
            initial_folds: 0,
            next: 0,
            speed: conversion.setup.speeds.travel_mm_s,
            ultrasonic: false,
            posture: (Side::Left, Feed::Out),
            lines: Vec::new(),
            moves: Vec::new(),
            non_ascii: false,
        }
    }

    pub(super) fn rewrite(&mut self, lines: &[Line<'_>], input_sha256: &str) {
        for line in lines {
            self.line(line, input_sha256);
        }
        if self.part != Part::Ended {
            let last = lines.len().max(1);
            let message = "the text stops without DEF and END: the file may be cut short".to_owned();
            self.findings.error(Kind::Unreadable, Code::NoProgramEnd, last, Some(1), message);
        }
        if self.initial_folds > 0 {
            let message =
                "the fold INI is not closed by ENDFOLD, so that nobody knows where it ends".to_owned();
            self.findings.error(
                Kind::Unreadable,
                Code::UnreadableProgram,
                lines.len().max(1),
                Some(1),
                message,
            );
        }
        let (count, most) = (self.lines.len(), self.conversion.setup.max_lines);
        if count > most {
            let message =
                format!("the converted program has {count} lines; the cell wants files of at most {most}");
            self.findings.whole(|name| Finding::warning(Code::OutOfRange, name, message));
        }
        if self.non_ascii {
            let message =
                "characters beyond 7-bit ASCII, which the control does not show, became question marks";
            self.findings.whole(|name| Finding::info(Code::StrangePath, name, message));
        }
    }

    /// The lines and the motions.
    pub(super) fn finish(self) -> (Vec<String>, Vec<ConvertedMove>) {
        (self.lines, self.moves)
    }

    fn line(&mut self, line: &Line<'_>, input_sha256: &str) {
        if line.is_motion() {
            return self.motion(line);
        }
        if line.is_branch() {
            let message =
                "which lines are run depends on this; a conversion follows a program from top to bottom";
            return self.unreadable(line, message.to_owned());
        }
        match &line.statement {
            Ok(Statement::Nothing) => self.comment(line),
            Ok(Statement::Def { .. }) => self.define(line, input_sha256),
            Ok(Statement::End) => self.end(line),
            Ok(Statement::DefDat { .. } | Statement::EndDat) => {
                self.unreadable(line, "a data list holds no motions to convert".to_owned());
            }
            // The new setup calls BAS, and handles stops, by itself.
            Ok(Statement::Bas { .. }) => self.drop_line(),
            Ok(Statement::External) if is_of_bas(line) => {}
            Ok(Statement::Idle) if !line.first_word().eq_ignore_ascii_case("CONTINUE") => self.drop_line(),
            Ok(Statement::Header | Statement::Declaration(_) | Statement::External) => self.keep(line),
            Ok(Statement::Assignment(assignment)) => self.assignment(line, assignment),
            Ok(Statement::Trigger { output }) => {
                self.judge_output(line, output);
                self.instruction(line);
            }
            Ok(Statement::Call { name, .. }) => {
                let message = format!("{} stands as it was; what it does is not known here", name.value);
                self.findings.warning(Kind::Call, Code::StrangePath, line.number, message);
                self.instruction(line);
            }
            Ok(_) => self.instruction(line),
            Err(fault) => {
                let message = format!("this line stands as it was, but is not understood: {}", fault.message);
                self.findings.warning(Kind::Untouched, Code::StrangePath, line.number, message);
                self.instruction(line);
            }
        }
    }

    fn unreadable(&mut self, line: &Line<'_>, message: String) {
        let column = line.span.start + 1;
        self.findings.error(Kind::Unreadable, Code::UnreadableProgram, line.number, Some(column), message);
    }

    fn define(&mut self, line: &Line<'_>, input_sha256: &str) {
        if self.part != Part::Head {
            return self
                .unreadable(line, "a second program in a file: its motions belong elsewhere".to_owned());
        }
        self.part = Part::Declarations;
        self.lines.push(format!("DEF {} ( )", self.stem.as_str()));
        self.lines.extend(emit::origin("V-SHAPED CUTTING, CONVERTED", input_sha256));
    }

    fn end(&mut self, line: &Line<'_>) {
        self.set_up();
        if self.part != Part::Body {
            return self.unreadable(line, "END ends nothing here".to_owned());
        }
        self.part = Part::Ended;
        self.lines.extend(emit::closing_lines(self.conversion.setup));
        self.lines.push("END".to_owned());
    }

    /// Writes the new setup, where there is none yet and everything has been declared.
    fn set_up(&mut self) {
        if self.part != Part::Declarations {
            return;
        }
        self.part = Part::Body;
        let setup = self.conversion.setup;
        self.lines.extend(emit::initial_lines());
        self.lines.extend(emit::setup_lines(setup));
        self.lines.extend(emit::opening_moves(setup));
    }

    /// A comment stays, but for the fold with which the control has been set up.
    fn comment(&mut self, line: &Line<'_>) {
        let text = line.text.trim().to_ascii_uppercase();
        let mut words = text
            .strip_prefix(';')
            .unwrap_or_default()
            .split([' ', '\t', ';'])
            .filter(|word| !word.is_empty());
        match (words.next(), words.next()) {
            (Some("FOLD"), Some("INI")) if self.initial_folds == 0 && self.part != Part::Head => {
                self.initial_folds = 1;
                self.set_up();
            }
            (Some("FOLD"), _) if self.initial_folds > 0 => self.initial_folds += 1,
            (Some("ENDFOLD"), _) if self.initial_folds > 0 => self.initial_folds -= 1,
            _ => self.keep(line),
        }
    }

    fn assignment(&mut self, line: &Line<'_>, assignment: &Assignment) {
        self.judge_output(line, assignment);
        if WRITTEN_ANEW.contains(&assignment.place.value.name.as_str()) {
            return self.drop_line();
        }
        self.instruction(line);
    }

    /// The ultrasonic belongs to the new program alone.
    fn judge_output(&mut self, line: &Line<'_>, assignment: &Assignment) {
        let place = &assignment.place.value;
        let own = i64::from(self.conversion.setup.ultrasonic_output);
        if place.name == "$OUT" && place.index == Some(own) {
            let message = format!("output {own} is that of the ultrasonic here; the line stands as it was");
            self.findings.warning(Kind::Output, Code::StrangePath, line.number, message);
        }
    }

    /// What stood here has been said by the new setup, or is said by it now.
    fn drop_line(&mut self) {
        self.set_up();
    }

    fn instruction(&mut self, line: &Line<'_>) {
        if self.initial_folds == 0 {
            self.set_up();
            self.keep(line);
        }
    }

    fn keep(&mut self, line: &Line<'_>) {
        if self.initial_folds > 0 {
            return;
        }
        let plain = |letter: char| matches!(letter, ' '..='~' | '\t');
        self.non_ascii |= !line.text.chars().all(plain);
        self.lines.push(line.text.chars().map(|letter| if plain(letter) { letter } else { '?' }).collect());
    }

    fn motion(&mut self, line: &Line<'_>) {
        self.set_up();
        if self.part != Part::Body {
            return self.unreadable(line, "a motion stands in no program".to_owned());
        }
        let Some(point) = self.points.get(self.next).filter(|point| point.milling.line == line.number) else {
            // A motion to joint angles, or one that has been refused.
            return self.lines.push(line.text.to_owned());
        };
        self.next += 1;
        let blank = &line.text[..line.span.start];
        match point.motion {
            None => self.cut(blank, point),
            Some(motion) => {
                let cuts_next = self.points.get(self.next).is_some_and(|next| next.milling.cut);
                // The blade turns where a cut begins: it stops there.
                let blend = motion.blend && motion.straight && !cuts_next;
                let word = if motion.straight { "LIN" } else { "PTP" };
                let to = self.pose(point, self.near(), self.posture);
                let purpose = if blend { Purpose::Free } else { Purpose::Approach };
                self.write(blank, word, point, to, purpose);
            }
        }
    }

    fn cut(&mut self, blank: &str, point: &Point) {
        if !self.ultrasonic {
            self.ultrasonic = true;
            self.lines
                .push(format!("{blank}{}", emit::trigger(self.conversion.setup.ultrasonic_output, true)));
        }
        let (left, right) = ((Side::Left, Feed::Out), (Side::Right, Feed::Back));
        for (y, posture, purpose) in [
            (self.near(), left, Purpose::Turn),
            (self.far(), left, Purpose::Cut),
            (self.far(), right, Purpose::Turn),
            (self.near(), right, Purpose::Cut),
        ] {
            let to = self.pose(point, y, posture);
            self.write(blank, "LIN", point, to, purpose);
        }
        self.posture = right;
    }

    fn write(&mut self, blank: &str, word: &str, point: &Point, to: Pose, purpose: Purpose) {
        let speeds = &self.conversion.setup.speeds;
        let speed = if purpose == Purpose::Cut { speeds.cutting_mm_s } else { speeds.travel_mm_s };
        if speed != self.speed {
            self.speed = speed;
            self.lines.push(format!("{blank}{}", emit::path_speed(speed)));
        }
        if emit::check_pose(&to).is_err() {
            let message = format!(
                "x = {}, z = {} is no place for a robot",
                point.milling.position.x, point.milling.position.z
            );
            self.findings.error(Kind::Below, Code::OutOfRange, point.milling.line, None, message);
            return;
        }
        let words = emit::pose_words(&to, self.conversion.setup.tool_direction);
        let suffix = if purpose == Purpose::Free { " C_DIS" } else { "" };
        self.lines.push(format!("{blank}{word} {words}{suffix}"));
        self.moves.push(ConvertedMove { line: point.milling.line, to, purpose });
    }

    fn pose(&self, point: &Point, y: f64, (side, feed): (Side, Feed)) -> Pose {
        let Point3 { coords } = point.milling.position;
        self.conversion.blade.pose(Point3::new(coords.x, y, coords.z), side, self.conversion.swing, feed)
    }

    /// y before the blank.
    fn near(&self) -> f64 {
        -self.conversion.extension_mm
    }

    /// y behind the blank.
    fn far(&self) -> f64 {
        self.conversion.blank.length_mm + self.conversion.extension_mm
    }
}

/// Whether an EXT tells of BAS, which needs none in KSS 8.
fn is_of_bas(line: &Line<'_>) -> bool {
    let mut words = line.text[line.span.clone()].split([' ', '\t', '(']).filter(|word| !word.is_empty());
    words.nth(1).is_some_and(|name| name.eq_ignore_ascii_case("BAS"))
}
