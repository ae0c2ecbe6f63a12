//! Rules of the machine that the tip does not touch.

use super::*;
use crate::planning::program::events::{Event, Positions};
use crate::planning::tape::machine::Edges;

/// A cut square across at r 0, by cutter 1 at U 100, after `between` has been done with the knife down.
fn square(before: &str, between: &str, after: &str) -> String {
    format!(
        "G21 G90 G17 G40 G49 G61 G93\nG1 U100.0 V-37.5 F60.0\n{before}M64 P2\nM64 P0\nG4 P0.05\n{between}\
         G1 V37.5 F8.0\n{after}M65 P0\nG4 P0.05\nM65 P2\nM2\n"
    )
}

fn across() -> Vec<WantedCut> {
    vec![WantedCut { course: 3.into(), points: vec![[0.0, -37.5], [0.0, 37.5]] }]
}

fn found(machine: &Machine, text: &str) -> Vec<(Code, String)> {
    summary(&replay_text(machine, text, &across()).1)
}

fn blade_fault(line: usize) -> Vec<(Code, String)> {
    vec![(Code::BladeAngle, format!("tip.ngc:{line}"))]
}

fn knife_fault(line: usize) -> Vec<(Code, String)> {
    vec![(Code::KnifeState, format!("tip.ngc:{line}"))]
}

#[test]
fn a_blade_turns_in_the_tape_up_to_the_lift_angle_only() {
    let machine = lab();
    assert_eq!(found(&machine, &square("", "", "")), []);
    assert_eq!(found(&machine, &square("G1 A15.0 F60.0\n", "G1 A0.0 F60.0\n", "")), []);
    assert_eq!(found(&machine, &square("G1 A15.1 F60.0\n", "G1 A0.0 F60.0\n", "")), blade_fault(7));
    // In two steps it is the same corner.
    let steps = "G1 A8.0 F60.0\nG1 A0.0 F60.0\n";
    assert_eq!(found(&machine, &square("G1 A16.0 F60.0\n", steps, "")), blade_fault(8));
    // To and fro is no less.
    assert_eq!(found(&machine, &square("", steps, "")), blade_fault(7));
}

#[test]
fn corners_with_a_cut_between_them_are_corners_each() {
    let turning = |between: &str| {
        square("G1 A-10.0 F60.0\n", "", "").replace(
            "G1 V37.5 F8.0\n",
            &format!("G1 A0.0 F60.0\n{between}A10.0 F60.0\nG1 A0.0 F60.0\nV37.5 F8.0\n"),
        )
    };
    assert_eq!(found(&lab(), &turning("")), blade_fault(8));
    // Two turns of 10 degrees are fine at two places, and two more at the second are not.
    assert_eq!(found(&lab(), &turning("V0.0 F16.0\n")), blade_fault(10));
}

#[test]
fn from_some_hundredths_on_a_cut_has_its_blade_along_it() {
    // A side step of 0.1 mm per 0.4 mm is 14 degrees off: less than the lift angle.
    let step = |length: f64| {
        let (u, v) = (100.0 + length / 4.0, -37.5 + length);
        let step = format!("G1 U{u:.4} V{v:.4} F999.0\nV37.5 F8.0\n");
        found(&lab(), &square("", "", "").replace("G1 V37.5 F8.0\n", &step))
    };
    assert_eq!(step(0.028), []);
    assert_eq!(step(0.032), blade_fault(6));
}

/// Many short steps are a cut and no corner: 14 degrees off, and no step as long as one that is looked at by itself.
#[test]
fn short_steps_in_a_row_have_the_blade_along_them() {
    let steps = |count: u32| {
        let step = |i: u32| {
            format!("U{:.4} V{:.4} F999.0\n", 100.0 + 0.004 * f64::from(i), -37.5 + 0.016 * f64::from(i))
        };
        let steps: String = (1..=count).map(step).collect();
        found(&lab(), &square("", "", "").replace("G1 V37.5 F8.0\n", &format!("G1 {steps}V37.5 F8.0\n")))
    };
    assert_eq!(steps(1), []);
    assert_eq!(steps(2), blade_fault(7));
}

/// Turns with next to no way between them are one corner.
#[test]
fn a_corner_is_no_less_for_a_step_of_nothing_within_it() {
    let between = |mm: f64| {
        let turns =
            format!("G1 A10.0 F60.0\nV{:.4} F999.0\nA20.0 F60.0\nA10.0 F60.0\nA0.0 F60.0\n", -37.5 + mm);
        found(&lab(), &square("", "", "").replace("G1 V37.5 F8.0\n", &format!("{turns}V37.5 F8.0\n")))
    };
    assert!(between(0.001).contains(&blade_fault(8)[0]), "{:?}", between(0.001));
}

#[test]
fn a_single_edge_cuts_in_its_direction_only() {
    let mut machine = lab();
    machine.cutters[0].edges = Edges::Single;
    // Across toward +V is gamma 0.
    assert_eq!(found(&machine, &square("", "", "")), []);
    assert_eq!(found(&machine, &square("G1 A180.0 F60.0\n", "", "")), blade_fault(7));
    assert_eq!(found(&machine, &square("G1 A360.0 F60.0\n", "", "")), []);
    assert_eq!(found(&lab(), &square("G1 A180.0 F60.0\n", "", "")), []);
}

#[test]
fn a_knife_does_not_go_down_for_nothing() {
    let idle = square("M64 P2\nM64 P1\nG4 P0.05\nM65 P1\nG4 P0.05\n", "", "");
    assert_eq!(found(&lab(), &idle), knife_fault(6));
    // Saying once more what is so already does nothing.
    assert_eq!(found(&lab(), &square("M65 P0\nM65 P1\n", "M64 P0\n", "")), []);
}

#[test]
fn going_down_and_going_up_take_their_own_times() {
    let duration = crate::planning::units::Duration::from_s;
    let mut machine = lab();
    let text = square("", "", "").replace("M65 P2\n", "G1 V0.0 F60.0\nM65 P2\n");
    assert_eq!(found(&machine, &text), []);
    machine.cutters[0].down_dwell = duration(0.1);
    assert_eq!(found(&machine, &text), knife_fault(6));
    machine.cutters[0].down_dwell = duration(0.01);
    machine.cutters[0].up_dwell = duration(0.1);
    assert_eq!(found(&machine, &text), knife_fault(9));
}

#[test]
fn nobody_stops_with_a_knife_down() {
    assert_eq!(found(&lab(), &square("M1\n", "", "")), []);
    assert_eq!(found(&lab(), &square("", "M1\n", "")), knife_fault(6));
}

#[test]
fn moving_nothing_is_no_move() {
    // The dwell is still owed after it.
    let text = square("", "", "").replace("G4 P0.05\nG1 V37.5", "G1 V-37.5 F1.0\nG1 V37.5");
    assert_eq!(found(&lab(), &text), knife_fault(6));
}

#[test]
fn a_cut_over_the_edge_of_the_tape_is_unwanted() {
    let text = square("", "", "").replace("V37.5 F8.0", "V39.5 F7.0");
    let (figures, findings) = replay_text(&lab(), &text, &across());
    assert!((figures.unwanted_mm - (2.0 - 0.011)).abs() < 1e-9, "{figures:?}");
    assert!(findings.iter().any(|finding| finding.message.contains("beside the tape")));
    assert!(findings.iter().all(|finding| finding.code == Code::Unwanted && finding.at == "tip.ngc:6"));
}

#[test]
fn one_cutter_has_no_second_one() {
    let mut machine = lab();
    machine.cutters.truncate(1);
    assert_eq!(found(&machine, &square("", "", "")), []);
    assert_eq!(found(&machine, &square("M65 P1\n", "", "")), knife_fault(3));
    let travel = vec![(Code::TravelExceeded, "tip.ngc:3".to_owned())];
    assert_eq!(found(&machine, &square("G1 W1.0 F60.0\n", "", "")), travel);
}

#[test]
fn cuts_shorter_than_their_printed_digits_have_no_direction() {
    // 0.0001 mm of tape within a cut square across: no blade could follow it.
    let text =
        square("", "", "").replace("G1 V37.5 F8.0\n", "G1 V0.0 F16.0\nU100.0001 F999.0\nV37.5 F16.0\n");
    assert_eq!(found(&lab(), &text), []);
    // 0.02 mm are a corner: a blade within the lift angle passes, one across the cut does not.
    let corner = |way: &str| {
        square("", "", "")
            .replace("G1 V37.5 F8.0\n", &format!("G1 V0.0 F16.0\n{way} F999.0\nU100.005 V37.5 F15.9\n"))
    };
    assert_eq!(found(&lab(), &corner("U100.005 V0.02")), []);
    let found = found(&lab(), &corner("U100.02"));
    assert!(found.contains(&blade_fault(7)[0]), "{found:?}");
}

#[test]
fn events_without_an_end_and_places_off_the_world_are_answered() {
    let machine = lab();
    let mut far: Positions = [0.0; 9];
    far[7] = f64::MAX;
    let events = [
        Event::Output { number: 2, on: true },
        Event::Output { number: 0, on: true },
        Event::Dwell { seconds: 1.0 },
        Event::Move { from: [0.0; 9], to: far, cruise_s: Some(1.0) },
    ]
    .map(|event| Executed { line: 1, event });
    let wanted = [WantedCut { course: 1.into(), points: vec![[0.0, 0.0], [f64::NAN, 0.0]] }];
    let setup = ReplaySetup {
        program: "p",
        machine: &machine,
        lead_mm: 0.0,
        tolerance_mm: 0.01,
        tape_width_mm: 75.0,
        wanted: &wanted,
        overcut_mm: 0.0,
        pieces: &[],
        before: &[],
    };
    let (figures, findings) = replay(&setup, &events);
    assert!(figures.uncut_mm > 1.0 && figures.unwanted_mm > 1.0);
    let codes: Vec<_> = summary(&findings).into_iter().map(|(code, _)| code).collect();
    use Code::{KnifeState, NoProgramEnd, SpeedExceeded, TravelExceeded, Uncut, Unwanted};
    assert_eq!(codes, [TravelExceeded, SpeedExceeded, Uncut, Unwanted, KnifeState, NoProgramEnd]);
}
