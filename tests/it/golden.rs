//! Golden cases: folders with a job, what must come of it written by hand, and the program's text.
//!
//! `expected.json` is the meaning: where each knife goes down and up. `roll.ngc` is the text; after a wanted
//! change of it, run with `BLADEPLAN_GOLDEN=write` and look at the difference.

use std::fs;
use std::path::{Path, PathBuf};

use bladeplan::planning::budget::Budget;
use bladeplan::planning::document;
use bladeplan::planning::document::files::Files;
use bladeplan::planning::outcome::{Outcome, Verdict};
use bladeplan::planning::program::events::{AXIS_LETTERS, Event, Executed, Positions};
use bladeplan::planning::program::nc::read::read;
use bladeplan::planning::tape::machine::Catalogue;
use rstest::rstest;
use serde_json::{Value, json};

use crate::linuxcnc::plan;

/// Every folder of golden cases, sorted.
pub fn cases() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden");
    let mut folders: Vec<_> = fs::read_dir(root).unwrap().map(|entry| entry.unwrap().path()).collect();
    folders.sort();
    folders
}

/// Plans the job of a golden case.
pub fn outcome(case: &Path) -> Outcome {
    let job = fs::read(case.join("job.json")).unwrap();
    plan(&document::read(&job).unwrap(), &Files::default(), &Catalogue::built_in(), &Budget::unwatched())
        .unwrap()
}

/// What a knife does between going down and coming up, in (u, v) of its course, or (r, v).
#[derive(Debug, PartialEq)]
struct Stroke {
    down: [f64; 2],
    up: [f64; 2],
}

#[test]
fn every_knife_goes_down_and_up_where_the_papers_say() {
    let cases = cases();
    assert!(cases.len() >= 7, "only {} golden cases found", cases.len());
    for case in cases {
        let expected: Value = serde_json::from_slice(&fs::read(case.join("expected.json")).unwrap()).unwrap();
        let outcome = outcome(&case);
        match expected["verdict"].as_str().unwrap() {
            "usable" => check_usable(&case, &expected, &outcome),
            _ => check_refused(&case, &expected, &outcome),
        }
    }
}

fn check_usable(case: &Path, expected: &Value, outcome: &Outcome) {
    assert_eq!(outcome.verdict, Verdict::Usable, "{}: {:?}", case.display(), outcome.findings);
    let events = read("roll.ngc", &outcome.programs[0].text).unwrap();
    for cutter in [1, 2] {
        let wanted: Vec<Stroke> = expected["strokes"]
            .as_array()
            .unwrap()
            .iter()
            .filter(|stroke| stroke["cutter"] == cutter)
            .map(|stroke| Stroke { down: pair(&stroke["down"]), up: pair(&stroke["up"]) })
            .collect();
        // Of several pieces the strokes are given on the roll.
        let first = &outcome.report["courses"][0]["pieces"][0]["roll_offset_mm"];
        let offset = if expected["on_roll"] == true { 0.0 } else { first.as_f64().unwrap() };
        let made = strokes(&events, cutter, &outcome.report, offset);
        assert_eq!(made, wanted, "{} cutter {cutter}", case.display());
    }
    compare_text(&case.join("roll.ngc"), &outcome.programs[0].text);
}

fn check_refused(case: &Path, expected: &Value, outcome: &Outcome) {
    assert_eq!(outcome.verdict, Verdict::NotUsable, "{}", case.display());
    assert!(outcome.programs.is_empty());
    let finding = outcome.findings.iter().find(|finding| finding.is_error()).unwrap();
    assert_eq!(finding.code.as_str(), expected["code"], "{}", case.display());
    assert!(finding.message.starts_with(expected["message"].as_str().unwrap()), "{finding}");
}

fn pair(value: &Value) -> [f64; 2] {
    [value[0].as_f64().unwrap(), value[1].as_f64().unwrap()]
}

/// Compares a text with the file that holds it, or writes the file if that is wished.
pub fn compare_text(path: &Path, text: &str) {
    if std::env::var("BLADEPLAN_GOLDEN").is_ok_and(|wish| wish == "write") {
        fs::write(path, text).unwrap();
    }
    let golden = fs::read_to_string(path).unwrap_or_default();
    let line = golden.lines().zip(text.lines()).take_while(|(one, other)| one == other).count() + 1;
    assert!(golden == text, "{}:{line} differs; BLADEPLAN_GOLDEN=write takes it over", path.display());
}

/// The strokes of a cutter of the built-in machine, less the offset of a piece.
fn strokes(events: &[Executed], cutter: u32, report: &Value, offset: f64) -> Vec<Stroke> {
    let lead = report["roll"]["lead_mm"].as_f64().unwrap();
    let (carriage, station) = if cutter == 1 { ('V', 0.0) } else { ('W', 300.0) };
    let axis = |letter: char| AXIS_LETTERS.iter().position(|other| *other == letter).unwrap();
    let place = |at: &Positions| [lead - at[axis('U')] + station - offset, at[axis(carriage)]];
    let (mut at, mut down, mut strokes) = ([0.0; 9], None, Vec::new());
    for executed in events {
        match executed.event {
            Event::Move { to, .. } => at = to,
            Event::Output { number, on: true } if number == cutter - 1 => down = Some(place(&at)),
            Event::Output { number, on: false } if number == cutter - 1 => {
                // A knife that is up already is told so again where a program can be restarted.
                strokes.extend(down.take().map(|down| Stroke { down, up: place(&at) }));
            }
            _ => {}
        }
    }
    strokes
}

#[test]
fn no_piece_of_an_unsymmetric_ply_is_mirrored() {
    // Seen from the normal's side, with the fibres up, the ply has its notch on the left at the far end. The
    // knife sees the tape from below with U to the right: the left of the course is +V, so the notch is at +V.
    let job = r#"{"kind": "tape-cut", "input": {"tape": {"width_mm": 75, "thickness_mm": 0.125},
        "boundary": {"points": [[-37.5,0,0], [-37.5,200,0], [0,200,0], [0,300,0], [37.5,300,0], [37.5,0,0]]},
        "tracks": [{"number": 1, "points": [{"position": [0,0,0], "normal": [0,0,1]}, {"position": [0,300,0], "normal": [0,0,1]}]}],
        "machine": "two-cutter-lab"}}"#;
    let plan = |job: &str| {
        let document = document::read(job.as_bytes()).unwrap();
        plan(&document, &Files::default(), &Catalogue::built_in(), &Budget::unwatched()).unwrap().report
    };
    let lengthwise_v = |report: &Value| -> f64 {
        let cuts = report["courses"][0]["pieces"][0]["cuts"].as_array().unwrap().clone();
        let points = cuts.iter().flat_map(|cut| cut["points_uv"].as_array().unwrap().clone());
        // The piece is 300 long where the notch is not; the notch reaches back to 200.
        let notch: Vec<_> =
            points.map(|point| pair(&point)).filter(|point| (point[0] - 200.0).abs() < 1e-9).collect();
        assert!(!notch.is_empty());
        notch.iter().map(|point| point[1]).fold(0.0, |far: f64, v| if v.abs() > far.abs() { v } else { far })
    };
    assert_eq!(lengthwise_v(&plan(job)), 37.5);
    // Laid the other way round, the notch is at the start and on the right.
    let from_above = job.replace("[0,0,1]", "[0,0,-1]");
    assert_eq!(lengthwise_v(&plan(&from_above)), -37.5);
}

/// An end with two changes of direction that two knives can just cut: its first and its last point lie at one u, so
/// that one chain ends where another of the same knife begins. On a ply turned in its plane, rounding the corners to
/// six decimals moved one of them past the other, and the job had no plan or a program that ran the tape back.
#[rstest]
#[case(167.171_271_278_744_48, 345.918_15, [186.316_514_893_757_78, 374.681_904_361_602_6])]
#[case(151.629_061_277_781_55, 335.439_596, [48.865_939_189_811_14, 415.513_406_819_815_43])]
#[case(7.435_989_788_269_173, 332.095_357, [312.814_047_850_533_7, 332.271_704_896_413_67])]
#[case(287.492_325_617_559_4, 331.298_55, [464.003_117_941_637_47, 114.905_530_384_403_04])]
fn ends_that_meet_at_one_place_are_cut_on_a_turned_ply(
    #[case] angle: f64,
    #[case] meeting_u: f64,
    #[case] origin: [f64; 2],
) {
    let (sin, cos) = angle.to_radians().sin_cos();
    let decimals = |x: f64| (x * 1e6).round() / 1e6;
    let place = |u: f64, v: f64| {
        [decimals(origin[0] + u * cos - v * sin), decimals(origin[1] + u * sin + v * cos), 0.0]
    };
    let corners =
        [(0.0, -37.5), (meeting_u, -37.5), (400.0, -12.5), (300.0, 12.5), (meeting_u, 37.5), (0.0, 37.5)];
    let track = |u: f64| json!({"position": place(u, 0.0), "normal": [0, 0, 1]});
    let job = json!({"kind": "tape-cut", "input": {
        "tape": {"width_mm": 75, "thickness_mm": 0.125},
        "boundary": {"points": corners.map(|(u, v)| place(u, v))},
        "tracks": [{"number": 1, "points": [track(0.0), track(500.0)]}],
        "machine": "two-cutter-lab"}});
    let document = document::from_value(job).unwrap();
    let outcome = plan(&document, &Files::default(), &Catalogue::built_in(), &Budget::unwatched()).unwrap();
    assert_eq!(outcome.verdict, Verdict::Usable, "{:?}", outcome.findings);
}
