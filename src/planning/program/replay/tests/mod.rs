//! Programs written by hand, their mutations, and cuts with planted errors.

mod machine;
mod mutations;
mod planted;

use super::*;
use crate::planning::finding::Code;
use crate::planning::program::nc::read::read;
use crate::planning::tape::machine::{check, two_cutter_lab};

/// A ">" on tape 75 mm wide: its tip at r 30, its ends at r 0. `\` by cutter 1, then `/` by cutter 2, which sits
/// 300 mm downstream; cutter 1 stands over r 0 when U reads 100. gamma = atan(30 / 37.5) = 38.6598 degrees.
/// The knives run at 10 mm/s across the tape: 37.5 mm take 3.75 s, so F is 16 (domain.md A5, jobs.md).
const TIP: &str = "\
%
(a tip, by two knives)
G21 G90 G17 G40 G49 G61 G93
G1 U70.0 A-38.6598 F120.0
M64 P2
M64 P0
G4 P0.05
G1 U100.0 V37.5 F16.0
M65 P0
G4 P0.05
G1 U370.0 B38.6598 F100.0
M64 P1
G4 P0.05
G1 U400.0 W-37.5 F16.0
M65 P1
M65 P2
M2
%
";

fn lab() -> Machine {
    check(&two_cutter_lab(), "").unwrap()
}

fn tip() -> Vec<WantedCut> {
    vec![WantedCut { course: 7.into(), points: vec![[0.0, 37.5], [30.0, 0.0], [0.0, -37.5]] }]
}

/// Reads and replays; a reader's faults count as findings.
fn replay_text(machine: &Machine, text: &str, wanted: &[WantedCut]) -> (ReplayFigures, Vec<Finding>) {
    let setup = ReplaySetup {
        program: "tip.ngc",
        machine,
        lead_mm: 100.0,
        tolerance_mm: 0.01,
        tape_width_mm: 75.0,
        wanted,
        overcut_mm: 0.0,
        pieces: &[],
        before: &[],
    };
    match read("tip.ngc", text) {
        Ok(events) => replay(&setup, &events),
        Err(faults) => (ReplayFigures::nothing_made(&[]), faults),
    }
}

/// The codes and places of the findings, without repeats.
fn summary(findings: &[Finding]) -> Vec<(Code, String)> {
    let mut summary: Vec<_> = findings.iter().map(|finding| (finding.code, finding.at.clone())).collect();
    summary.sort();
    summary.dedup();
    summary
}

#[test]
fn a_tip_written_by_hand_passes() {
    let (figures, findings) = replay_text(&lab(), TIP, &tip());
    assert_eq!(findings, []);
    assert!(figures.max_deviation_mm < 1e-9, "{figures:?}");
    assert_eq!((figures.uncut_mm, figures.unwanted_mm, figures.tape_reversals), (0.0, 0.0, 0));
}

#[test]
fn a_mirrored_tip_does_not() {
    let mirrored =
        vec![WantedCut { course: 7.into(), points: vec![[30.0, 37.5], [0.0, 0.0], [30.0, -37.5]] }];
    let (figures, findings) = replay_text(&lab(), TIP, &mirrored);
    // The two legs of each cross one of the other's.
    assert!(figures.uncut_mm > 90.0 && figures.unwanted_mm > 90.0, "{figures:?}");
    assert_eq!(findings.iter().filter(|finding| finding.code == Code::Uncut).count(), 3);
    assert!(findings.iter().any(|finding| finding.message.contains("course 7: r 30.0000 to 15.")));
}

#[test]
fn a_program_that_is_wrong_throughout_gets_a_bounded_answer() {
    let mut text = TIP.replace("M2\n%\n", "G4 P0.05\n");
    for step in 0..1000 {
        text += &format!("G1 U{}.0 F60.0\n", 399 - step % 300);
    }
    text += "M2\n%\n";
    let (figures, findings) = replay_text(&lab(), &text, &tip());
    assert_eq!(figures.tape_reversals, 997);
    assert_eq!(findings.len(), 11);
    assert!(findings[10].message.contains("987 more"));
}
