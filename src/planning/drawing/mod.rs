//! Drawings of plans, as SVG.
//!
//! `svg` writes, `sheet` is the paper with its heading, legend and scale, `label` keeps texts apart. A plan is thinned out to what can be
//! seen (`sketch`), looked at through windows (`window`) and laid out as pieces (`piece`) and as a roll
//! (`roll`).
//!
//! Each drawing comes twice, as two files: seen from below, as the papers draw it, and in the operator's view.
//! One file with a switch inside would need a fragment in its address, which a sheet that is printed, mailed,
//! converted or shown by many viewers of SVG does not have; then both views or the wrong one would show. Two
//! files are right wherever they are shown, as an `<img>` too, and each says on itself which view it is.

pub mod axis;
pub mod bands;
pub mod chart;
pub mod comparison;
pub mod contour;
pub mod joints;
pub mod label;
pub mod mark;
pub mod milling;
pub mod optimum;
pub mod page;
pub mod piece;
pub mod roll;
pub mod section;
pub mod sheet;
pub mod sketch;
pub mod stamp;
pub mod svg;
pub mod thin;
pub mod timeline;
pub mod tips;
pub mod window;

#[cfg(test)]
mod craft_tests;
#[cfg(test)]
mod honeycomb_tests;
#[cfg(test)]
mod table1;
#[cfg(test)]
mod tests;

use super::outcome::Drawing;
use super::tape::input::TapeInput;
use super::tape::plan::TapePlan;

/// The side from which a drawing shows the tape. U is to the right in both; texts are upright in both.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum View {
    /// V up. W, the knives' way down, points at the reader (domain.md A3).
    FromBelow,
    /// V down: as the tape lies before the operator.
    Operator,
}

impl View {
    /// Both views.
    pub const ALL: [Self; 2] = [Self::FromBelow, Self::Operator];

    /// The name of a drawing's file.
    #[must_use]
    pub fn file_name(self, drawing: &str) -> String {
        match self {
            Self::FromBelow => format!("{drawing}.svg"),
            Self::Operator => format!("{drawing}-operator.svg"),
        }
    }

    /// +1 where +V is down the sheet, -1 where it is up.
    #[must_use]
    pub fn v_down(self) -> f64 {
        match self {
            Self::FromBelow => -1.0,
            Self::Operator => 1.0,
        }
    }
}

/// The drawings of a tape-cut plan: `pieces` and `roll`, each in both views, and `tips` where errors are given.
#[must_use]
pub fn drawings(plan: &TapePlan, input: &TapeInput) -> Vec<Drawing> {
    let pieces = piece::Pieces::new(plan, input);
    let roll = roll::RollSheet::new(plan, input);
    View::ALL
        .into_iter()
        .flat_map(|view| {
            [
                Drawing { name: view.file_name("pieces"), svg: pieces.draw(view) },
                Drawing { name: view.file_name("roll"), svg: roll.draw(view) },
            ]
        })
        .chain(tips::tips(&crate::planning::tape::tips::tips(plan, &input.machine)))
        .collect()
}
