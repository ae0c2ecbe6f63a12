//! The section of the blank, cut by what a program makes: chips, gouges, what is left.

use super::ReplaySetup;
use super::class::MadeCut;
use crate::planning::finding::{Code, Finding};
use crate::planning::geometry::Point2;
use crate::planning::honeycomb::section::{Cut, CutOutcome, Reach, Remains, Section, SectionFault};
use crate::planning::tolerance::PRINTED_MM;

/// What the cuts of a program leave.
#[derive(Debug)]
pub struct Swept {
    /// The section as it is left; none where it could not be cut at all.
    pub remains: Option<Remains>,
    /// How many chips came free.
    pub chips: usize,
}

/// At most so many cuts of one kind of fault are named.
const MOST_NAMED: usize = 20;

/// Cuts the section. The findings are errors.
#[must_use]
pub fn sweep(setup: &ReplaySetup<'_>, made: &[MadeCut]) -> (Swept, Vec<Finding>) {
    let reach = Reach::of(&setup.setting.blade, setup.setting.blade.max_cutting_length.mm());
    let mut section = match section(setup, &reach) {
        Ok(section) => section,
        Err(fault) => {
            let finding = Finding::error(Code::OutOfRange, "/input/profile", fault.to_string());
            return (Swept { remains: None, chips: 0 }, vec![finding]);
        }
    };
    let (mut chips, mut findings) = (0, Vec::new());
    for cut in made {
        let slit = Cut { tip: cut.tip, side: cut.side, swing: cut.swing, reach };
        match section.cut(&slit) {
            Ok(outcome) => {
                chips += outcome.chips.len();
                findings.extend(faults(setup, cut, &outcome));
            }
            Err(fault) => {
                findings.push(Finding::error(Code::ThroughStock, setup.at(cut.place), fault.to_string()))
            }
        }
    }
    let remains = section.remains();
    findings.truncate(MOST_NAMED);
    findings.extend(left_over(setup, &remains));
    (Swept { remains: Some(remains), chips }, findings)
}

/// Where nobody has said what the part is, all of the blank may go.
fn section(setup: &ReplaySetup<'_>, reach: &Reach) -> Result<Section, SectionFault> {
    let blank = &setup.setting.blank;
    let base = [Point2::new(0.0, 0.0), Point2::new(blank.width_mm, 0.0)];
    let profile = setup.profile.unwrap_or(&base);
    let allowance = if setup.profile.is_some() { setup.setting.process.allowance_mm } else { 0.0 };
    Section::new(blank.width_mm, blank.height_mm, profile, allowance, reach.cutting)
}

/// What is wrong with a cut.
fn faults(setup: &ReplaySetup<'_>, cut: &MadeCut, outcome: &CutOutcome) -> Vec<Finding> {
    let fault = |code, words: String| Finding::error(code, setup.at(cut.place), words);
    let mut findings = Vec::new();
    if outcome.is_gouge() {
        let gouge = &outcome.gouge;
        let words = format!(
            "enters the part by {:.3} mm at the tip, {:.3} along the edge, {:.3} by the body of the blade",
            gouge.tip, gouge.arm, gouge.body
        );
        findings.push(fault(Code::Gouge, words));
    }
    if outcome.runs_in_stock() {
        let words = format!(
            "{:.3} mm of the edge and {:.3} mm of the body beyond the cutting length run in material",
            outcome.beyond.edge, outcome.beyond.body
        );
        findings.push(fault(Code::EdgeInStock, words));
    }
    if outcome.below_base > PRINTED_MM {
        findings.push(fault(
            Code::Gouge,
            format!("cuts {:.3} mm below the blank, into the table", outcome.below_base),
        ));
    }
    findings
}

/// What is wrong with what is left.
fn left_over(setup: &ReplaySetup<'_>, remains: &Remains) -> Vec<Finding> {
    let mut findings = Vec::new();
    if !remains.stuck.is_empty() {
        let places: Vec<_> = remains
            .stuck
            .iter()
            .take(MOST_NAMED)
            .map(|tip| format!("x {:.3} z {:.3}", tip.x, tip.y))
            .collect();
        let words = format!(
            "{} chips stay in the part, above the tips at {}: the blade does not reach from there to open air",
            remains.stuck.len(),
            places.join("; ")
        );
        findings.push(Finding::error(Code::StuckChip, "", words));
    }
    let limit = setup.setting.process.max_scallop_mm;
    if let (Some(_), Some(scallop)) = (setup.profile, &remains.scallop)
        && scallop.distance > limit
    {
        let words = format!(
            "at x {:.3} z {:.3} the cut surface is {:.3} mm from the contour; {limit} may stay",
            scallop.at.x, scallop.at.y, scallop.distance
        );
        findings.push(Finding::error(Code::ScallopExceeded, "/input/process/max_scallop_mm", words));
    }
    findings
}
