//! From a three-axis reciprocating milling program to V-shaped cutting: the papers' own route.
//!
//! Cui et al. 2020, section III.A, and domain.md B4, step by step for each LIN or PTP: recognise it; read X, Y and Z,
//! a missing one keeping its last value; set y to the near or the far end, an extension outside the blank; take dy
//! from the y that was read, and bring the path to the near side; a cut has dy and runs below the blank's top; a cut
//! becomes four statements, left tilt, cut, right tilt, cut back, and everything else keeps its place, in the posture
//! that the blade is in. All other lines stand as they were; what sets the control up, and speeds, is written anew.

mod findings;
mod path;
mod rewrite;

use super::blade::Blade;
use super::milling::Blank;
use crate::planning::finding::{Code, Finding};
use crate::planning::geometry::Point3;
use crate::planning::geometry::frame::Pose;
use crate::planning::outcome::ProgramFile;
use crate::planning::program::krl::emit;
use crate::planning::program::krl::read::statements;
use crate::planning::program::krl::stem::Stem;
use crate::planning::program::robot_moves::{Purpose, RobotSetup};

/// What a conversion needs to know beside the program.
#[derive(Debug, Clone, Copy)]
pub struct Conversion<'a> {
    /// The blank. Its corner is the origin of the program's base.
    pub blank: Blank,
    /// The blade that takes the place of the cutter.
    pub blade: &'a Blade,
    /// alpha in rad.
    pub swing: f64,
    /// b in mm: how far outside the blank cuts begin and end.
    pub extension_mm: f64,
    /// What the control must know. Its speeds and frames take the place of the program's.
    pub setup: &'a RobotSetup,
}

/// A converted program, and what became of what.
#[derive(Debug, Clone)]
pub struct Converted {
    /// The program: one file, which needs no data list.
    pub program: ProgramFile,
    /// The points of the milling program, in order.
    pub milling: Vec<MillingPoint>,
    /// The motions that they became, in order.
    pub moves: Vec<ConvertedMove>,
    /// What a person should look at. None of it is an error.
    pub findings: Vec<Finding>,
}

/// A point of a milling program.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MillingPoint {
    /// The line of its statement, from 1.
    pub line: usize,
    /// Where it is, in mm.
    pub position: Point3,
    /// Whether the way to it is a cut.
    pub cut: bool,
}

/// A motion of a converted program.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConvertedMove {
    /// The line of the milling statement that it comes from, from 1.
    pub line: usize,
    /// Where the blade goes, in the frame of the part, with the tool axis along Z.
    pub to: Pose,
    /// What for.
    pub purpose: Purpose,
}

/// Converts a milling program. `name` stands in the findings; `input_sha256` is in lower-case hex.
///
/// # Errors
/// All that rules a conversion out: motions that are not read whole and what decides which lines are run
/// (`UnreadableProgram`, `NAME:LINE:COLUMN`), a path below the blank (`OutOfRange`, `NAME:LINE`), a program without
/// an end (`NoProgramEnd`), numbers that no control takes (`OutOfRange`).
pub fn convert(
    name: &str,
    text: &str,
    conversion: &Conversion<'_>,
    stem: &Stem,
    input_sha256: &str,
) -> Result<Converted, Vec<Finding>> {
    check(conversion).map_err(|finding| vec![finding])?;
    let lines = statements(text);
    let mut findings = findings::Findings::new(name);
    let points = path::points(&lines, &conversion.blank, &mut findings);
    let mut written = rewrite::Rewriter::new(conversion, stem, &points, &mut findings);
    written.rewrite(&lines, input_sha256);
    let (text, moves) = written.finish();
    let findings = findings.finish()?;
    let program = emit::file(stem.as_str(), "src", &text);
    let milling = points.iter().map(|point| point.milling).collect();
    Ok(Converted { program, milling, moves, findings })
}

fn check(conversion: &Conversion<'_>) -> Result<(), Finding> {
    let refuse = |message: String| Err(Finding::error(Code::OutOfRange, "", message));
    emit::check_setup(conversion.setup)?;
    let Blank { width_mm, length_mm, height_mm } = conversion.blank;
    if [width_mm, length_mm, height_mm].into_iter().any(|size| !(size > 0.0 && size.is_finite())) {
        return refuse(format!("a blank of {width_mm} x {length_mm} x {height_mm} mm is none"));
    }
    if !(conversion.swing > 0.0 && conversion.swing < std::f64::consts::FRAC_PI_2) {
        return refuse(format!("a swing of {} degrees is none", conversion.swing.to_degrees()));
    }
    if !(conversion.extension_mm >= 0.0 && conversion.extension_mm.is_finite()) {
        return refuse(format!("an extension of {} mm is none", conversion.extension_mm));
    }
    Ok(())
}

#[cfg(test)]
pub(super) mod tests;
