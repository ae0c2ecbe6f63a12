//! Each rule of the reader, by a good program with one line changed.

use super::*;
use crate::planning::tape::machine::{check, two_cutter_lab};

const GOOD: &str = "\
; a cut
N10 G710 G90 G17 G40 G500 D0 G60
N20 FGROUP(U,V,W,A,B)
N30 G93
N40 M84
N50 G1 U10.5 V-37.5 F60.0
N60 M80
N70 G4 F0.05
N80 U20.0 V37.5 F8.0
N90 H7 ; up
N100 M1
N110 M85
N120 M30
";

fn machine() -> Machine {
    let mut profile = two_cutter_lab();
    profile.dialect = crate::planning::tape::machine::Dialect::Sinumerik;
    profile.program.words = serde_json::from_str(
        r#"{"knives": [{"down": "M80", "up": "H7"}, {"down": "M82", "up": "M83"}], "ultrasonic": {"on": "M84", "off": "M85"}}"#,
    )
    .unwrap();
    check(&profile, "").unwrap()
}

fn changed(line: usize, to: &str) -> Result<Vec<Executed>, Vec<Finding>> {
    let mut lines: Vec<&str> = GOOD.lines().collect();
    lines[line - 1] = to;
    read("p.mpf", &lines.join("\n"), &machine())
}

#[test]
fn a_good_program_is_what_it_was_worked_out_to_be() {
    let events = read("p.mpf", GOOD, &machine()).unwrap();
    let mut at = [0.0; 9];
    (at[6], at[7]) = (10.5, -37.5);
    let mut end = at;
    (end[6], end[7]) = (20.0, 37.5);
    let output = |number, on| Event::Output { number, on };
    let expected = [
        (5, output(2, true)),
        (6, Event::Move { from: [0.0; 9], to: at, cruise_s: Some(1.0) }),
        (7, output(0, true)),
        (8, Event::Dwell { seconds: 0.05 }),
        (9, Event::Move { from: at, to: end, cruise_s: Some(7.5) }),
        (10, output(0, false)),
        (11, Event::OptionalStop),
        (12, output(2, false)),
        (13, Event::End),
    ];
    assert_eq!(events, expected.map(|(line, event)| Executed { line, event }));
    assert!(read("p.mpf", &GOOD.replace('\n', "\r\n"), &machine()).is_ok());
}

#[test]
fn what_could_mean_something_else_is_refused_in_its_line() {
    for (line, to, why) in [
        (1, "%_N_ROLL_MPF", "archive"),
        (1, "(a cut)", "comments begin with ;"),
        (2, "G71 G90 G17 G40 G500 D0 G60", "metric (G710)"),
        (2, "G710 G90 G17 G40 G500 D0 G642", "blending"),
        (2, "G710 G90 G17 G40 G54 D0 G60", "machine's zero"),
        (3, "FGROUP(U,V,W,A)", "leaves out axis B"),
        (3, "FGROUP U,V", "in brackets"),
        (5, "M99", "no word of this machine's profile"),
        (5, "M84 G1 U1 F1", "blocks of their own"),
        (5, "M84 M80", "twice"),
        (6, "G1 U=10.5 V-37.5 F60.0", "no number"),
        (6, "G1 U10,5 V-37.5 F60.0", "begins no word"),
        (6, "G1 U1.5.5 F60.0", "not a plain decimal"),
        (6, "G1 U1e3 F60.0", "no place"),
        (6, "G1 U10.5 U11 F60.0", "twice"),
        (6, "G1 U10.5", "needs its F"),
        (6, "G1 U10.5 F0", "gives no time"),
        (6, "G2 U10.5 F60", "straight moves"),
        (6, "/G1 U10.5 F60", "switch at the machine"),
        (6, "G1 U$P_EP F60", "no number"),
        (6, "STOPRE", "no place"),
        (6, "G1 U10.5 F60 N50", "stand first"),
        (6, "G94\nG1 U10.5 V1 F60", "by itself"),
        (6, "G94\nG1 U10.5 F0", "no speed"),
        (6, "G94\nG1 U10.5", "needs its F"),
        (6, "G93 G94", "blocks of their own"),
        (6, "G95", "inverse time"),
        (8, "G4 P0.05", "no place"),
        (8, "G4 F-1", "needs F"),
        (8, "F3", "no effect"),
        (12, "M2", "no word of this machine's profile"),
        (13, "M30\nM84", "after the end"),
    ] {
        let faults = changed(line, to).expect_err(to);
        let found = faults.iter().find(|fault| fault.message.contains(why));
        assert!(found.is_some(), "{to}: {faults:?}");
    }
    assert_eq!(changed(13, "").unwrap_err()[0].code, Code::NoProgramEnd);
}

#[test]
fn each_setting_must_stand_before_a_motion_and_is_missed_once() {
    for word in ["G710", "G90", "G17", "G40", "G500", "D0", "G60"] {
        let faults = changed(2, &"G710 G90 G17 G40 G500 D0 G60".replace(word, ""));
        let faults = faults.expect_err(word);
        assert!(faults.len() == 1 && faults[0].message.contains(word), "{word}: {faults:?}");
    }
    assert!(changed(3, "").unwrap_err()[0].message.contains("FGROUP"));
    assert!(changed(4, "").unwrap_err()[0].message.contains("G93"));
}

#[test]
fn a_text_that_is_no_program_gets_a_bounded_answer() {
    let text = "hello world\n".repeat(1000);
    assert_eq!(read("p", &text, &machine()).unwrap_err().len(), MOST_FAULTS + 1);
    assert!(read("p", &format!("N1 G1 U{}\n", "1".repeat(600)), &machine()).is_err());
    assert!(read("p", "\u{e4}\n", &machine()).is_err());
}
