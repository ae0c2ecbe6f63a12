use super::*;

const HEADER: &str = "G21 G90 G17 G40 G49 G61 G93\n";

fn events(text: &str) -> Vec<(usize, Event)> {
    let read = read("p.ngc", text).unwrap_or_else(|faults| panic!("{faults:?}"));
    read.into_iter().map(|executed| (executed.line, executed.event)).collect()
}

fn at(named: &[(char, f64)]) -> Positions {
    let mut positions = [0.0; 9];
    for (letter, value) in named {
        let axis = crate::planning::program::events::AXIS_LETTERS.iter().position(|axis| axis == letter);
        positions[axis.unwrap()] = *value;
    }
    positions
}

fn refused(body: &str) -> Vec<(Code, String, String)> {
    let faults = read("p.ngc", body).expect_err(&format!("refused: {body}"));
    faults.into_iter().map(|fault| (fault.code, fault.at, fault.message)).collect()
}

#[test]
fn does_what_the_control_would_do() {
    let text = "%\n(A)\nG21 G90 G17\nG40 G49 G61 G93 ; set\n\nM64 P2\nG1 U10.5 V-3.25 F12.5\nM64 P0\nG4 P0.05\n\
                V3.25 A-12.5 F2 (COURSE 12)\nM65 P0\nG0 U11\nM1\nM2\n%\n";
    let first = at(&[('U', 10.5), ('V', -3.25)]);
    let second = at(&[('U', 10.5), ('V', 3.25), ('A', -12.5)]);
    let third = at(&[('U', 11.0), ('V', 3.25), ('A', -12.5)]);
    let expected = vec![
        (6, Event::Output { number: 2, on: true }),
        (7, Event::Move { from: [0.0; 9], to: first, cruise_s: Some(4.8) }),
        (8, Event::Output { number: 0, on: true }),
        (9, Event::Dwell { seconds: 0.05 }),
        (10, Event::Move { from: first, to: second, cruise_s: Some(30.0) }),
        (11, Event::Output { number: 0, on: false }),
        (12, Event::Move { from: second, to: third, cruise_s: None }),
        (13, Event::OptionalStop),
        (14, Event::End),
    ];
    assert_eq!(events(text), expected);
}

#[test]
fn case_blanks_line_ends_and_leading_zeros_change_nothing() {
    let plain = "G21 G90 G17 G40 G49 G61 G93\nG1 U10.5 W-0.5 B+3 F60\nM64 P1\nM2\n";
    let varied = "n1 g21g90 g17\tg40 g49 g61 g93\r\nN2 g 01 u010.50w -.5 B +3. f60.\r\nM 064 p01\r\n m02";
    assert_eq!(events(plain), events(varied));
}

#[test]
fn a_block_may_set_and_move_at_once() {
    let moved = events("G21 G90 G17 G40 G49 G61.1 G93 G1 C5 F60\nM2");
    let to = at(&[('C', 5.0)]);
    assert_eq!(moved[0], (1, Event::Move { from: [0.0; 9], to, cruise_s: Some(1.0) }));
}

/// Lines that a control refuses, or that could mean something other than it seems, and what is said of them.
const REFUSED: &[(&str, &str)] = &[
    ("G1 U1 F60 %", "% stands alone"),
    ("G1 U1 F60 (open", "not closed"),
    ("G1 U1 F60 (a (b) c)", "in a comment"),
    ("(MSG, hello)", "more than a comment"),
    ("( debug, #1)", "more than a comment"),
    ("(PRINT,1)", "more than a comment"),
    ("(LOGOPEN,x)", "more than a comment"),
    ("(PROBEOPEN x.txt)", "more than a comment"),
    (";py,boom()", "more than a comment"),
    ("/G1 U1 F60", "a switch at the machine"),
    ("#1=5", "a parameter"),
    ("G1 U#1 F60", "U has no number"),
    ("G1 U[1+1] F60", "U has no number"),
    ("O100", "has no place"),
    ("G1 U1e3 F60", "E3 has no place"),
    ("G1 U1,5 F60", "','"),
    ("G1 U1 0 F60", "plain decimal"),
    ("G1 U1.0.0 F60", "plain decimal"),
    ("G1 U- F60", "U has no number"),
    ("G1 U-. F60", "U has no number"),
    ("G1 U1 U2 F60", "U stands twice"),
    ("G1 U1 F60 F61", "F stands twice"),
    ("G1 G0 U1", "meets another word"),
    ("G21 G21", "meets another word"),
    ("G61 G61.1", "meets another word"),
    ("M64 P1 P2", "P stands twice"),
    ("M64 P0 M64 P1", "M stands twice"),
    ("M64 M65 P1", "M stands twice"),
    ("M64", "needs P"),
    ("M64 P1.5", "whole number"),
    ("M64 P-1", "whole number"),
    ("M64 P123456789", "whole number"),
    ("M62 P0", "waits for the next motion"),
    ("M63 P0", "waits for the next motion"),
    ("M3", "has no place"),
    ("M0", "has no place"),
    ("M30", "exchanges pallets"),
    ("M1 P1", "P belongs"),
    ("M64 P0 G1 U1 F60", "block of its own"),
    ("M2 F60", "block of its own"),
    ("G4", "needs P"),
    ("G4 P-0.1", "not negative"),
    ("G4 F1", "block of its own"),
    ("G4 P1 U1", "block of its own"),
    ("G1 U1 F60 P1", "P belongs"),
    ("G2 U1 F60", "straight moves"),
    ("G20", "in mm"),
    ("G91", "absolute"),
    ("G64 P0.01", "blending"),
    ("G95", "inverse time"),
    ("G94 G1 U1 V1 F60", "by itself"),
    ("G94 G1 U1", "needs its F"),
    ("G94 G1 U1 F0", "no speed"),
    ("G94 G93 G1 U1 F60", "its group"),
    ("G92 U0", "machine's zero"),
    ("G54", "machine's zero"),
    ("G1.0 U1 F60", "G1.0 is refused"),
    ("G-1 U1 F60", "G-1 is refused"),
    ("G99", "has no place"),
    ("G1", "need an axis"),
    ("G1 F60", "need an axis"),
    ("F60", "has no effect"),
    ("G1 U1", "needs its F"),
    ("G1 U1 F0", "gives no time"),
    ("G1 U1 F-1", "gives no time"),
    ("G0 U1 F60", "takes no F"),
    ("U1 F60", "neither G0 nor G1"),
    ("G1 U1 N5 F60", "N stands first"),
    ("(a) N5 G1 U1 F60", "N stands first"),
    ("N1.5 G1 U1 F60", "N takes a whole number"),
    ("G1 U1 F60 H12", "H12 has no place"),
    ("G1 U1 F60 (\u{e4})", "printable"),
    ("G1 U1\rF60", "printable"),
    ("G1 U1 \u{0}F60", "printable"),
];

#[test]
fn a_feed_below_the_least_one_is_faster_than_it_says() {
    let cruise_s = |body: &str| match &events(&format!("{HEADER}{body}\nM2\n"))[0].1 {
        Event::Move { cruise_s, .. } => cruise_s.unwrap(),
        other => panic!("{other:?}"),
    };
    // 0.03 mm at 0.1 mm/min take 18 s; without a linear axis, degrees count.
    let cases = [
        ("G1 U0.03 A90 F2", 18.0),
        ("G1 U0.03 A90 F4", 15.0),
        ("G1 A90 F2", 30.0),
        ("G1 A0.03 F2", 18.0),
        ("G1 X3 U0.03 F2", 30.0),
        ("G1 X0.03 U3 F2", 18.0),
        ("G1 U0.0 F2", 30.0),
    ];
    for (body, expected) in cases {
        assert!((cruise_s(body) - expected).abs() < 1e-9, "{body}: {}", cruise_s(body));
    }
}

#[test]
fn refuses_each_line_that_means_something_else() {
    for (line, message) in REFUSED {
        let found = refused(&format!("{HEADER}{line}\nM2\n"));
        assert_eq!(found.len(), 1, "{line}: {found:?}");
        assert_eq!((found[0].0, found[0].1.as_str()), (Code::UnreadableProgram, "p.ngc:2"), "{line}");
        assert!(found[0].2.contains(message), "{line}: {}", found[0].2);
    }
}

#[test]
fn refuses_to_move_before_each_setting() {
    let settings = ["G21", "G90", "G17", "G40", "G49", "G61", "G93"];
    for missing in settings {
        let header: Vec<_> = settings.iter().filter(|word| **word != missing).copied().collect();
        let found = refused(&format!("{}\nG1 U1 F60\nU2 F60\nM2\n", header.join(" ")));
        assert_eq!(found.len(), 1, "said once");
        assert_eq!(found[0].1, "p.ngc:2");
        assert!(found[0].2.contains(&format!("({missing})")), "{}", found[0].2);
    }
}

#[test]
fn takes_lines_as_long_as_a_control_does() {
    let line = |bytes: usize| format!("{HEADER}({})\nM2\n", "x".repeat(bytes - 2));
    assert_eq!(events(&line(252)).len(), 1);
    assert_eq!(refused(&line(253))[0].1, "p.ngc:2");
}

#[test]
fn a_program_ends_with_m2_and_nothing_after_it() {
    let cases = [
        ("", Code::NoProgramEnd, 1),
        ("G21\nG90\n", Code::NoProgramEnd, 3),
        ("%\nG21\n%\nM2\n%\n", Code::UnreadableProgram, 3),
        ("G21\n%\nM2\n", Code::UnreadableProgram, 2),
        ("M2\n\nG21\n", Code::UnreadableProgram, 3),
        ("M2\n(said)\n", Code::UnreadableProgram, 2),
        ("M2\n%\n", Code::UnreadableProgram, 2),
        ("%\nM2\n", Code::UnreadableProgram, 3),
        ("%\nM2\n%\n%\n", Code::UnreadableProgram, 4),
        ("%\n%\nM2\n", Code::UnreadableProgram, 2),
    ];
    for (text, code, line) in cases {
        let found = refused(text);
        assert_eq!((found[0].0, found[0].1.clone()), (code, format!("p.ngc:{line}")), "{text:?}");
    }
    assert_eq!(events("\n%\nM2\n\n%\n\n").len(), 1);
}

#[test]
fn every_refused_line_is_named_up_to_a_bound() {
    let found = refused(&format!("{HEADER}G2 U1\nG1 U1 F60\nM3\nM2\n"));
    assert_eq!(found.iter().map(|fault| fault.1.as_str()).collect::<Vec<_>>(), ["p.ngc:2", "p.ngc:4"]);
    let hopeless = refused(&"hello\n".repeat(100_000));
    assert_eq!(hopeless.len(), MOST_FAULTS + 1);
    assert!(hopeless[MOST_FAULTS].2.contains("not read"));
}

proptest::proptest! {
    #[test]
    fn any_text_is_read_or_refused(text in "[ -~\n\r\t%]{0,200}") {
        let _ = read("p.ngc", &text);
    }

    #[test]
    fn any_mix_of_words_is_read_or_refused(text in "(([GMNFPUVWAB] ?[-+]?[0-9]{0,3}\\.?[0-9]{0,2} ?){1,4}\n){0,9}") {
        let _ = read("p.ngc", &text);
    }
}
