use super::*;
use crate::planning::geometry::Point2;
use crate::planning::geometry::frame::Frame;
use crate::planning::honeycomb::blade::{Edges, Feed, Side};
use crate::planning::honeycomb::milling::milling_program;
use crate::planning::program::krl::read::execute;
use crate::planning::program::robot_events::RobotEvent;
use crate::planning::program::robot_moves::{Speeds, ToolDirection};
use crate::planning::units::{Angle, Length};

/// alpha in rad.
const SWING: f64 = 0.5;

/// b in mm.
const EXTENSION: f64 = 6.0;

pub(in super::super) fn blade() -> Blade {
    Blade {
        rake: Angle::from_degrees(60.0),
        half_apex: Angle::from_degrees(7.13),
        max_cutting_length: Length::from_mm(10.0),
        length: Length::from_mm(10.0),
        max_swing: Angle::from_degrees(50.0),
        edges: Edges::Double,
    }
}

pub(in super::super) fn setup() -> RobotSetup {
    RobotSetup {
        tool: Frame { z_mm: 300.0, ..Frame::default() },
        base: Frame { x_mm: 1500.0, a_deg: 90.0, ..Frame::default() },
        tool_direction: ToolDirection::Z,
        home: [0.0, -90.0, 90.0, 0.0, 0.0, 0.0],
        approach: None,
        speeds: Speeds { cutting_mm_s: 150.0, travel_mm_s: 200.0, angular_deg_s: 90.0 },
        blend_mm: 1.0,
        ultrasonic_output: 9,
        max_lines: 2500,
    }
}

fn blank() -> Blank {
    Blank { width_mm: 85.0, length_mm: 50.0, height_mm: 50.0 }
}

fn stem() -> Stem {
    Stem::new("conv_0123456789ab").unwrap()
}

fn converted(text: &str) -> Result<Converted, Vec<Finding>> {
    let (blade, setup) = (blade(), setup());
    let conversion =
        Conversion { blank: blank(), blade: &blade, swing: SWING, extension_mm: EXTENSION, setup: &setup };
    convert("mill.src", text, &conversion, &stem(), "00ff")
}

/// The body of a program: its first line is line 2.
fn program(body: &str) -> String {
    format!("DEF mill()\n{body}\nEND\n")
}

fn moves(body: &str) -> Vec<ConvertedMove> {
    converted(&program(body)).unwrap().moves
}

/// Code, place and severity of every finding.
fn found(text: &str) -> Vec<(String, String)> {
    let findings = converted(text).map_or_else(|findings| findings, |converted| converted.findings);
    findings.into_iter().map(|finding| (finding.code.as_str(), finding.at)).collect()
}

const DOWN: &str = "PTP {X 10,Y 0,Z 60,A 180,B 0,C 180}\nLIN {Z 45}\n";

#[test]
fn a_cut_becomes_four_statements_and_all_else_keeps_its_place() {
    let body =
        format!("{DOWN}LIN {{Y 50}} C_DIS\nLIN {{X 16}} C_DIS\nLIN {{Y 0}}\nLIN {{Z 60}} C_DIS\nLIN {{X 3}}");
    let blade = blade();
    let at = |x: f64, y: f64, z: f64, side, feed, purpose, line| ConvertedMove {
        line,
        to: blade.pose(Point3::new(x, y, z), side, SWING, feed),
        purpose,
    };
    let (near, far) = (-EXTENSION, 50.0 + EXTENSION);
    let left = |x, y, z, purpose, line| at(x, y, z, Side::Left, Feed::Out, purpose, line);
    let right = |x, y, z, purpose, line| at(x, y, z, Side::Right, Feed::Back, purpose, line);
    let expected = [
        left(10.0, near, 60.0, Purpose::Approach, 2),
        left(10.0, near, 45.0, Purpose::Approach, 3),
        left(10.0, near, 45.0, Purpose::Turn, 4),
        left(10.0, far, 45.0, Purpose::Cut, 4),
        right(10.0, far, 45.0, Purpose::Turn, 4),
        right(10.0, near, 45.0, Purpose::Cut, 4),
        // Its C_DIS is gone, for the blade turns next.
        right(16.0, near, 45.0, Purpose::Approach, 5),
        left(16.0, near, 45.0, Purpose::Turn, 6),
        left(16.0, far, 45.0, Purpose::Cut, 6),
        right(16.0, far, 45.0, Purpose::Turn, 6),
        right(16.0, near, 45.0, Purpose::Cut, 6),
        right(16.0, near, 60.0, Purpose::Free, 7),
        right(3.0, near, 60.0, Purpose::Approach, 8),
    ];
    assert_eq!(moves(&body), expected);
}

#[test]
fn a_path_at_the_height_of_the_blank_is_no_cut() {
    for (z, motions) in [("49.9999", 4), ("50", 1), ("50.0001", 1)] {
        let body = format!("LIN {{X 10,Y 0,Z {z},A 0,B 0,C 0}}\nLIN {{Y 50}}");
        assert_eq!(moves(&body).len(), 1 + motions, "{z}");
    }
}

#[test]
fn dy_is_taken_before_the_path_is_brought_to_one_side() {
    // Both ends of the step lie at y = -b afterwards; before, the second one lies at 50.
    let converted =
        converted(&program(&format!("{DOWN}LIN {{Y 50}}\nLIN {{Y 50,X 11}}\nLIN {{Y 0}}"))).unwrap();
    let cuts: Vec<_> = converted.milling.iter().map(|point| point.cut).collect();
    assert_eq!(cuts, [false, false, true, false, true]);
    let lines: Vec<_> = converted.milling.iter().map(|point| point.line).collect();
    assert_eq!(lines, [2, 3, 4, 5, 6]);
    assert_eq!(converted.milling[4].position, Point3::new(11.0, 0.0, 45.0));
}

#[test]
fn other_lines_stand_as_they_were_and_the_setup_is_new() {
    let text = "&ACCESS RVP\r\n&COMMENT by hand\r\nDEF mill( )\r\nEXT BAS (BAS_COMMAND :IN,REAL :IN )\r\nDECL INT i\r\n;FOLD INI\r\n\
                ;FOLD BASISTECH INI\r\nBAS (#INITMOV,0 )\r\n;ENDFOLD\r\n$OUT[7]=TRUE\r\n;ENDFOLD (INI)\r\n;FOLD SETUP\r\n\
                $TOOL=TOOL_DATA[1]\r\n$BASE={X 1,Y 2,Z 3,A 0,B 0,C 0}\r\n$VEL.CP=0.05\r\n;ENDFOLD (SETUP)\r\n\
                $OUT[4]=TRUE ;coolant\r\n  LIN {X 10,Y 0,Z 45,A 0,B 0,C 0} C_DIS ;N10\r\n$VEL.CP=1\r\n\
                \x20 LIN {X 10,Y 50,Z 45}\r\nWAIT SEC 0.5\r\nEND\r\n";
    let converted = converted(text).unwrap();
    assert_eq!(converted.findings, []);
    assert_eq!(converted.program.name, "conv_0123456789ab.src");
    let lines: Vec<_> = converted.program.text.split_terminator("\r\n").collect();
    assert_eq!(lines[..3], ["&ACCESS RVP", "&COMMENT by hand", "DEF conv_0123456789ab ( )"]);
    assert_eq!(lines[5], "DECL INT i");
    let count = |said: &str| lines.iter().filter(|line| line.trim().starts_with(said)).count();
    for (said, times) in [
        ("EXT", 0),
        ("BAS (#INITMOV,0 )", 1),
        ("$TOOL=", 1),
        ("$BASE=", 1),
        ("$OUT[7]", 0),
        ("$VEL.CP=0.15", 2),
        ("$VEL.CP=0.2", 2),
        ("$VEL", 6),
        (";FOLD SETUP", 2),
        ("TRIGGER WHEN DISTANCE=0 DELAY=0 DO $OUT[9]=TRUE", 1),
        ("TRIGGER WHEN DISTANCE=0 DELAY=0 DO $OUT[9]=FALSE", 1),
        ("PTP {A1 0.0,A2 -90.0", 2),
        ("LIN {X 10.0,", 5),
    ] {
        assert_eq!(count(said), times, "{said}");
    }
    let place = |said: &str| lines.iter().position(|line| *line == said).unwrap();
    assert!(
        place("$OUT[4]=TRUE ;coolant") < lines.iter().position(|line| line.starts_with("  LIN")).unwrap()
    );
    assert!(place("WAIT SEC 0.5") + 1 < lines.len() - 3);
    assert_eq!(*lines.last().unwrap(), "END");
}

#[test]
fn the_converted_program_does_what_the_list_of_moves_says() {
    let body = format!(
        "$OUT[3]=TRUE\n{DOWN}LIN {{Y 50}}\nLIN {{X 16}} C_DIS\nLIN {{Y 0}}\nLIN {{Z 60}} C_DIS\nLIN {{X 3}}"
    );
    let converted = converted(&program(&body)).unwrap();
    let events = execute(&[converted.program], "conv_0123456789ab.src").unwrap();
    let frames: Vec<_> = events
        .iter()
        .filter_map(|executed| match &executed.event {
            RobotEvent::Line { frame, blend } => Some((*frame, *blend)),
            RobotEvent::PoseTo { frame, .. } => Some((*frame, false)),
            _ => None,
        })
        .collect();
    assert_eq!(frames.len(), converted.moves.len());
    for ((frame, blend), wanted) in frames.iter().zip(&converted.moves) {
        assert!((frame.pose().to_homogeneous() - wanted.to.to_homogeneous()).norm() < 1e-3);
        assert_eq!(*blend, wanted.purpose == Purpose::Free);
    }
}

#[test]
fn a_milling_program_of_ours_comes_back_as_the_tips_it_was_made_of() {
    let layers: Vec<Vec<Point2>> = (1..6)
        .map(|k| {
            (0..(9 + k % 3))
                .map(|j| Point2::new(5.0 + 7.0 * f64::from(j), 50.0 - 4.4 * f64::from(k)))
                .collect()
        })
        .collect();
    let milling = milling_program(&layers, &blank(), 10.0, &setup(), &stem(), "00ff").unwrap();
    let converted = converted(&milling.text).unwrap();
    let cut = converted.milling.iter().filter(|point| point.cut);
    let tips: Vec<_> = cut.map(|point| Point2::new(point.position.x, point.position.z)).collect();
    let wanted: Vec<_> = layers.concat();
    assert_eq!(tips.len(), wanted.len());
    assert!(tips.iter().zip(&wanted).all(|(tip, wanted)| (tip - wanted).norm() < 1e-4));
    assert_eq!(
        converted.moves.iter().filter(|motion| motion.purpose == Purpose::Cut).count(),
        2 * wanted.len()
    );
}

#[test]
fn what_is_strange_is_said_with_its_line() {
    let strange = |at: &str| ("strange_path".to_owned(), at.to_owned());
    let cases = [
        ("LIN {X 90}\nLIN {Y 50}", vec![strange("mill.src:5")]),
        ("LIN {X 11,Y 50}", vec![strange("mill.src:4")]),
        ("LIN {Z 44,Y 50}", vec![strange("mill.src:4")]),
        ("LIN {Y 10}", vec![strange("mill.src:4")]),
        ("PTP {A1 0,A2 0,A3 0,A4 0,A5 0,A6 0}", vec![strange("mill.src:4")]),
        ("SPINDLE_ON()", vec![strange("mill.src:4")]),
        ("$OUT[9]=FALSE", vec![strange("mill.src:4")]),
        ("ANOUT ON s=1", vec![strange("mill.src:4")]),
        (";\u{e4}", vec![strange("mill.src")]),
    ];
    for (body, expected) in cases {
        let text = program(&format!("{DOWN}{body}"));
        assert_eq!(found(&text), expected, "{body}");
        assert!(converted(&text).is_ok(), "{body}");
    }
    assert!(converted(&program(";\u{e4}")).unwrap().program.text.is_ascii());
}

#[test]
fn what_rules_a_conversion_out_is_refused_with_its_place() {
    let fault = |code: &str, at: &str| (code.to_owned(), at.to_owned());
    let unreadable = |at: &str| vec![fault("unreadable_program", at)];
    let cases = [
        ("CIRC {X 1},{X 2}", unreadable("mill.src:4:1")),
        ("LIN {Y 50} C_FOO", unreadable("mill.src:4:12")),
        ("  LIN XP1", unreadable("mill.src:4:7")),
        ("LIN {Y 1+1}", unreadable("mill.src:4:9")),
        ("LIN {Y 1,E1 5}", unreadable("mill.src:4:13")),
        ("LIN_REL {Y 1} #TOOL", unreadable("mill.src:4:9")),
        ("FOR i=1 TO 3", unreadable("mill.src:4:1")),
        (" IF 1==1 THEN\nENDIF", [unreadable("mill.src:4:2"), unreadable("mill.src:5:1")].concat()),
        ("RETURN", unreadable("mill.src:4:1")),
        ("DEF other()", unreadable("mill.src:4:1")),
        (";FOLD INI", unreadable("mill.src:5:1")),
        ("LIN {Z -1}", vec![fault("out_of_range", "mill.src:4")]),
        ("LIN {X 2e6}", vec![fault("out_of_range", "mill.src:4")]),
    ];
    for (body, expected) in cases {
        let text = program(&format!("{DOWN}{body}"));
        assert_eq!(found(&text), expected, "{body}");
        assert!(converted(&text).is_err(), "{body}");
    }
    assert_eq!(found(&program("LIN {X 1,Y 2}")), unreadable("mill.src:2:5"));
    assert_eq!(found("DEF mill()\nHALT\n"), [fault("no_program_end", "mill.src:2:1")]);
    assert_eq!(found(""), [fault("no_program_end", "mill.src:1:1")]);
    assert_eq!(found("DEFDAT d\nENDDAT")[0], fault("unreadable_program", "mill.src:1:1"));
}

#[test]
fn a_kind_of_finding_is_named_so_often_and_no_more() {
    let text = program(&format!("{DOWN}{}", "SPINDLE_ON()\n".repeat(1000)));
    assert_eq!(found(&text).len(), 21);
    let text = program(&format!("{DOWN}{}", "CIRC\n".repeat(1000)));
    assert_eq!(found(&text).len(), 21);
}

#[test]
fn a_program_longer_than_the_cell_likes_is_said_to_be() {
    let text = program(&format!("{DOWN}{}", "HALT\n".repeat(2500)));
    assert_eq!(found(&text), [("out_of_range".to_owned(), "mill.src".to_owned())]);
}

#[test]
fn numbers_that_mean_nothing_are_refused() {
    let (blade, setup) = (blade(), setup());
    let good =
        Conversion { blank: blank(), blade: &blade, swing: SWING, extension_mm: EXTENSION, setup: &setup };
    let cases = [
        Conversion { blank: Blank { width_mm: f64::NAN, ..blank() }, ..good },
        Conversion { blank: Blank { height_mm: 0.0, ..blank() }, ..good },
        Conversion { swing: 0.0, ..good },
        Conversion { swing: 1.6, ..good },
        Conversion { swing: f64::NAN, ..good },
        Conversion { extension_mm: -1.0, ..good },
        Conversion { extension_mm: f64::INFINITY, ..good },
    ];
    for conversion in cases {
        let findings = convert("mill.src", &program(DOWN), &conversion, &stem(), "00ff").unwrap_err();
        assert_eq!(findings[0].code, Code::OutOfRange, "{conversion:?}");
    }
}

proptest::proptest! {
    #[test]
    fn any_text_is_converted_or_refused(text in "((DEF p\\(\\)|END|;FOLD INI|;ENDFOLD|LIN|PTP|CIRC|\\{X 1|,Y 50|,Z 4|\\}|C_DIS|\\$VEL.CP=1|IF|HALT|\u{e4}|\n| )){0,60}") {
        let _ = converted(&text);
        let _ = converted(&program(&text));
    }
}
