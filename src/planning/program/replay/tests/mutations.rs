//! Each word of a good program changed, each line left out: all of it is seen.

use super::*;

/// A line of [`TIP`] (from 1), replaced or left out, and what must be said at least.
fn mutated(line: usize, replacement: &str) -> Vec<(Code, String)> {
    let mut lines: Vec<&str> = TIP.lines().collect();
    assert_ne!(lines[line - 1], replacement);
    lines[line - 1] = replacement;
    let text = lines.join("\n");
    summary(&replay_text(&lab(), &text, &tip()).1)
}

fn expect(line: usize, replacement: &str, expected: &[(Code, usize)]) {
    let found = mutated(line, replacement);
    for (code, at) in expected {
        let at = if *at == 0 { "tip.ngc".to_owned() } else { format!("tip.ngc:{at}") };
        assert!(found.contains(&(*code, at.clone())), "{replacement}: {code:?} at {at} in {found:?}");
    }
}

#[test]
fn coordinates() {
    use Code::{BladeAngle, Deviation, SpeedExceeded, TapeReversal, TravelExceeded, Uncut, Unwanted};
    expect(4, "G1 U70.02 A-38.6598 F120.0", &[(Uncut, 0), (Deviation, 0)]);
    expect(4, "G1 U69.98 A-38.6598 F120.0", &[(Deviation, 8)]);
    expect(8, "G1 U100.0 V37.48 F16.0", &[(Uncut, 0), (Deviation, 0)]);
    expect(8, "G1 U100.0 V37.6 F16.0", &[(SpeedExceeded, 8), (Unwanted, 8), (Deviation, 8)]);
    expect(8, "G1 U100.05 V37.5 F16.0", &[(Uncut, 0), (Unwanted, 8), (Deviation, 8)]);
    expect(8, "G1 U100.0 V-37.5 F16.0", &[(BladeAngle, 8), (Uncut, 0), (Unwanted, 8)]);
    expect(8, "G1 U100.0 F16.0", &[(BladeAngle, 8), (Uncut, 0), (Unwanted, 8)]);
    expect(8, "G1 V37.5 F16.0", &[(BladeAngle, 8), (Uncut, 0), (Unwanted, 8)]);
    expect(8, "G1 U69.9999 V37.5 F16.0", &[(TapeReversal, 8)]);
    expect(8, "G1 U100.0 V171.0 F3.0", &[(TravelExceeded, 8), (Unwanted, 8)]);
    expect(11, "G1 U99.9999 B38.6598 F100.0", &[(TapeReversal, 11)]);
    expect(11, "G1 U370.02 B38.6598 F100.0", &[(Deviation, 0)]);
    expect(14, "G1 U400.0 W-37.45 F16.0", &[(Deviation, 0)]);
    expect(14, "G1 U400.0 X-37.5 F16.0", &[(TravelExceeded, 14), (Uncut, 0)]);
    expect(14, "G1 U400.0 V-37.5 F16.0", &[(BladeAngle, 14), (Uncut, 0), (Unwanted, 14)]);
    expect(14, "G1 U200001.0 W-37.5 F0.1", &[(TravelExceeded, 14)]);
}

#[test]
fn angles() {
    use Code::{BladeAngle, TravelExceeded};
    expect(4, "G1 U70.0 A38.6598 F120.0", &[(BladeAngle, 8)]);
    expect(4, "G1 U70.0 A-37.6 F120.0", &[(BladeAngle, 8)]);
    expect(4, "G1 U70.0 F120.0", &[(BladeAngle, 8)]);
    expect(4, "G1 U70.0 A-398.6598 F12.0", &[(TravelExceeded, 4)]);
    expect(8, "G1 U100.0 V37.5 A-40.0 F16.0", &[(BladeAngle, 8)]);
    expect(8, "G1 U100.0 V37.5 A141.3402 F16.0", &[(BladeAngle, 8)]);
    expect(11, "G1 U370.0 B-38.6598 F100.0", &[(BladeAngle, 14)]);
    // A double edge may be turned by half a turn while it is up, and follow a cut by less than a degree.
    assert_eq!(mutated(4, "G1 U70.0 A141.3402 F120.0"), []);
    assert_eq!(mutated(8, "G1 U100.0 V37.5 A-39.1 F16.0"), []);
}

#[test]
fn speeds() {
    use Code::{KnifeState, SpeedExceeded};
    expect(4, "G1 U70.0 A-38.6598 F429.0", &[(SpeedExceeded, 4)]);
    expect(4, "G1 U1.0 A-38.6598 F560.0", &[(SpeedExceeded, 4)]);
    expect(8, "G1 U100.0 V37.5 F16.001", &[(SpeedExceeded, 8)]);
    expect(14, "G1 U400.0 W-37.5 F16.001", &[(SpeedExceeded, 14)]);
    expect(4, "G0 U70.0 A-38.6598", &[(SpeedExceeded, 4)]);
    expect(8, "G0 U100.0 V37.5", &[(KnifeState, 8)]);
    expect(11, "G1 U370.0 V-40.0 B38.6598 F160.0", &[(SpeedExceeded, 11)]);
    assert_eq!(mutated(4, "G1 U70.0 A-38.6598 F428.0"), []);
    assert_eq!(mutated(8, "G1 U100.0 V37.5 F15.9"), []);
    // As fast as the limits allow, with what four decimals may add to F.
    assert_eq!(mutated(8, "G1 U100.0 V37.5 F16.00005"), []);
}

#[test]
fn the_way_in_the_tape_has_a_limit_of_its_own() {
    let mut machine = lab();
    let limit = |mm_s| crate::planning::units::Speed::from_mm_s(mm_s);
    // 48.0234 mm in 3.75 s.
    machine.max_cutting_path_speed = limit(12.807);
    assert_eq!(replay_text(&machine, TIP, &tip()).1, []);
    machine.max_cutting_path_speed = limit(12.805);
    let found = summary(&replay_text(&machine, TIP, &tip()).1);
    assert_eq!(
        found,
        [(Code::SpeedExceeded, "tip.ngc:14".to_owned()), (Code::SpeedExceeded, "tip.ngc:8".to_owned())]
    );
}

#[test]
fn outputs() {
    use Code::{BladeAngle, KnifeState, NoProgramEnd, Uncut, UnreadableProgram, Unwanted};
    expect(5, "", &[(KnifeState, 6), (KnifeState, 12)]);
    expect(5, "M64 P3", &[(KnifeState, 5), (KnifeState, 6)]);
    expect(6, "", &[(Uncut, 0)]);
    expect(6, "M64 P1", &[(Unwanted, 8), (Uncut, 0)]);
    expect(6, "M65 P0", &[(Uncut, 0)]);
    expect(6, "M62 P0", &[(UnreadableProgram, 6)]);
    expect(9, "", &[(Unwanted, 11), (KnifeState, 17), (BladeAngle, 11)]);
    expect(9, "M65 P1", &[(Unwanted, 11), (KnifeState, 17)]);
    expect(9, "M65 P2", &[(KnifeState, 9)]);
    expect(12, "", &[(Uncut, 0)]);
    expect(15, "", &[(KnifeState, 16), (KnifeState, 17)]);
    expect(16, "", &[(KnifeState, 17)]);
    expect(17, "", &[(UnreadableProgram, 18)]);
    expect(18, "", &[(UnreadableProgram, 18)]);
    expect(4, "M2", &[(UnreadableProgram, 5)]);
    let cut_short = TIP.split_once("M65 P1").unwrap().0.replace("%\n", "");
    assert_eq!(
        summary(&replay_text(&lab(), &cut_short, &tip()).1),
        [(NoProgramEnd, "tip.ngc:14".to_owned())]
    );
}

#[test]
fn dwells() {
    use Code::KnifeState;
    expect(7, "", &[(KnifeState, 8)]);
    expect(7, "G4 P0.0499", &[(KnifeState, 8)]);
    expect(10, "", &[(KnifeState, 11)]);
    expect(10, "G4 P0.04", &[(KnifeState, 11)]);
    expect(13, "G4 P0.0", &[(KnifeState, 14)]);
    assert_eq!(mutated(7, "G4 P0.06"), []);
}
