//! The planted trace, the set-up sheet and the timeline that go with a plan.

use std::collections::BTreeMap;

use bladeplan::planning::outcome::{Outcome, Verdict, sha256_hex};
use bladeplan::planning::program::events::{AXIS_LETTERS, Event};
use bladeplan::planning::program::nc::read::read;
use bladeplan::planning::tape::trace::{PlantedTrace, text};
use proptest::prelude::*;
use serde_json::{Value, json};

use crate::craft::overcutting;
use crate::profiles::{job, lab_with, plan_job};
use crate::random_plies::{Ply, plies};
use crate::rounds::runner;

fn attachment<'a>(outcome: &'a Outcome, name: &str) -> &'a str {
    &outcome.attachments.iter().find(|attachment| attachment.name == name).unwrap().text
}

/// What a knife does from down to up: (u, v) of the course in 1e-4 mm.
type Way = Vec<[i64; 2]>;

fn way(points: impl IntoIterator<Item = [f64; 2]>) -> Way {
    points.into_iter().map(|point| point.map(|value| (value * 1e4).round() as i64)).collect()
}

/// The strokes of a program as it reads, by cutter, in roll coordinates.
fn cut(outcome: &Outcome) -> BTreeMap<u32, Vec<Way>> {
    let lead = outcome.report["roll"]["lead_mm"].as_f64().unwrap();
    let axis = |letter: char| AXIS_LETTERS.iter().position(|other| *other == letter).unwrap();
    let mut cut = BTreeMap::new();
    for (cutter, carriage, station) in [(1, 'V', 0.0), (2, 'W', 300.0)] {
        let (mut at, mut open, mut ways) = ([0.0, 0.0], None::<Vec<[f64; 2]>>, Vec::new());
        for executed in read("roll.ngc", &outcome.programs[0].text).unwrap() {
            match executed.event {
                Event::Move { to, .. } => {
                    let next = [lead - to[axis('U')] + station, to[axis(carriage)]];
                    if let Some(points) = open.as_mut().filter(|_| next != at) {
                        points.push(next);
                    }
                    at = next;
                }
                Event::Output { number, on } if number + 1 == cutter => {
                    ways.extend(open.take().map(way));
                    open = on.then(|| vec![at]);
                }
                _ => {}
            }
        }
        cut.insert(cutter, ways);
    }
    cut
}

/// The same, planted.
fn planted(trace: &PlantedTrace, report: &Value) -> BTreeMap<u32, Vec<Way>> {
    let mut planted: BTreeMap<u32, Vec<Way>> = BTreeMap::from([(1, Vec::new()), (2, Vec::new())]);
    let reported = report["courses"].as_array().unwrap();
    for (course, reported) in trace.courses.iter().zip(reported) {
        assert_eq!(reported["number"], course.number);
        for stroke in &course.strokes {
            let offset = reported["pieces"][stroke.piece - 1]["roll_offset_mm"].as_f64().unwrap();
            let points = std::iter::once(stroke.down).chain(stroke.cuts.iter().map(|cut| cut.to));
            planted.get_mut(&stroke.cutter).unwrap().push(way(points.map(|[u, v]| [u + offset, v])));
        }
    }
    planted
}

/// Both knives' break points split a stroke of a program; its ends are those of the planted one, and every planted
/// point is among the program's.
fn same(made: &BTreeMap<u32, Vec<Way>>, planted: &BTreeMap<u32, Vec<Way>>) -> Result<(), TestCaseError> {
    let near = |a: &[i64; 2], b: &[i64; 2]| (a[0] - b[0]).abs() <= 2 && (a[1] - b[1]).abs() <= 2;
    for (cutter, planted) in planted {
        let mut left: Vec<&Way> = made[cutter].iter().collect();
        prop_assert_eq!(left.len(), planted.len());
        for stroke in planted {
            let found = left.iter().position(|way| {
                near(&way[0], &stroke[0])
                    && near(&way[way.len() - 1], &stroke[stroke.len() - 1])
                    && stroke.iter().all(|point| way.iter().any(|other| near(point, other)))
            });
            prop_assert!(found.is_some(), "cutter {} makes no {:?}", cutter, stroke);
            left.remove(found.unwrap());
        }
    }
    Ok(())
}

#[test]
fn the_planted_trace_parses_back_to_the_strokes_of_the_program() {
    let parses = |ply: Ply| {
        let outcome = ply.plan();
        if outcome.programs.is_empty() {
            return Ok(());
        }
        let trace = text::read(attachment(&outcome, "trace-planted.txt")).unwrap();
        let as_json: PlantedTrace = serde_json::from_str(attachment(&outcome, "trace-planted.json")).unwrap();
        prop_assert_eq!(&trace, &as_json);
        same(&cut(&outcome), &planted(&trace, &outcome.report))
    };
    runner(40).run(&plies(), parses).unwrap();
}

/// A slot across a course, as wide as pieces lie apart: both pieces of the course lie at one offset on the roll.
#[test]
fn strokes_of_two_pieces_at_one_offset_are_told_apart() {
    let slotted = json!({"kind": "tape-cut", "input": {
        "tape": {"width_mm": 75, "thickness_mm": 0.125},
        "boundary": {"points": [[0, -60, 0], [0, 60, 0], [400, 60, 0], [400, -60, 0]]},
        "holes": [{"points": [[150, -50, 0], [150, 50, 0], [200, 50, 0], [200, -50, 0]]}],
        "tracks": [{"number": 1, "points": [
            {"position": [0, 0, 0], "normal": [0, 0, 1]}, {"position": [400, 0, 0], "normal": [0, 0, 1]}]}]}});
    for mm in [0.0, 1.0] {
        let outcome = plan_job(&slotted, &overcutting(mm), &json!({"scrap_gap_mm": 50})).unwrap();
        assert_eq!(outcome.verdict, Verdict::Usable, "{:?}", outcome.findings);
        let pieces = outcome.report["courses"][0]["pieces"].as_array().unwrap();
        assert_eq!(pieces[0]["roll_offset_mm"], pieces[1]["roll_offset_mm"], "else this test shows nothing");
        let trace = text::read(attachment(&outcome, "trace-planted.txt")).unwrap();
        let strokes = trace.courses[0].strokes.iter();
        let mut found: Vec<_> = strokes.map(|stroke| (stroke.piece, stroke.down[0])).collect();
        found.sort_by(|one, other| one.1.total_cmp(&other.1));
        assert_eq!(found, [(1, 0.0), (1, 150.0), (2, 200.0), (2, 400.0)]);
    }
}

#[test]
fn a_planted_tip_is_what_was_worked_out_by_hand() {
    let outcome = plan_job(&job("examples/first.job.json"), &lab_with(&[]), &json!(null)).unwrap();
    let text = attachment(&outcome, "trace-planted.txt");
    // `\` by cutter 1 and `/` by cutter 2, both from the tip; 45 degrees at 10 mm/s across are 14.1421 mm/s.
    for line in [
        "BLADEPLAN-TRACE 1\nCOURSE 1\nP 0.0 0.0 0.0 0.0 0.0 1.0\n",
        "DOWN 1 1 400.0 0.0\nCUT 362.5 37.5 -45.0 14.1421\nUP\n",
        "DOWN 1 2 400.0 0.0\nCUT 362.5 -37.5 45.0 14.1421\nUP\n",
    ] {
        assert!(text.contains(line), "{line}\n{text}");
    }
}

#[test]
fn the_set_up_sheet_says_what_stands_in_program_and_report() {
    let outcome = plan_job(&job("examples/first.job.json"), &lab_with(&[]), &json!(null)).unwrap();
    let sheet = attachment(&outcome, "setup.md");
    let report = &outcome.report;
    assert_eq!(report["attachments"], json!(["trace-planted.txt", "trace-planted.json", "setup.md"]));
    for said in [
        sha256_hex(outcome.programs[0].text.as_bytes()),
        report["input_sha256"].as_str().unwrap().to_owned(),
        report["machine"]["profile_sha256"].as_str().unwrap().to_owned(),
        format!("({:.1} s)", report["time_s"].as_f64().unwrap()),
        "75.0 mm wide, 0.125 mm thick".to_owned(),
        "| first piece cut | course 1, piece 1 |".to_owned(),
        "| U (mm) | 0 with the leading end".to_owned(),
        "| 1 | 1 | 1 | 400.0 | 28593.8 |".to_owned(),
    ] {
        assert!(sheet.contains(&said), "{said}\n{sheet}");
    }
    let drawing = outcome.drawings.iter().find(|drawing| drawing.name == "timeline.svg").unwrap();
    for bar in ["knife 1", "knife 2", "ultrasonic"] {
        assert!(drawing.svg.contains(&format!("<title>{bar}</title>")), "{bar}");
    }
}
