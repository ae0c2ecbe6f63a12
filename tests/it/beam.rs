//! Two carriages on one beam: they cannot pass one another, and keep their distance all the time.

use std::cell::Cell;

use bladeplan::planning::finding::{Code, Finding};
use bladeplan::planning::outcome::{Outcome, Verdict};
use bladeplan::planning::program::events::Event;
use bladeplan::planning::program::nc::read::read;
use proptest::prelude::*;
use serde_json::{Value, json};

use crate::profiles::{check_program, job, lab_with, plan_job, refused};
use crate::random_plies::{Ply, plies};
use crate::rounds::runner;

/// The lab with its stations this far apart and carriages that keep a distance; cutter 1 is parked above.
pub fn beam(station_mm: f64, clearance_mm: f64) -> Value {
    lab_with(&[
        ("/cutters/1/station_mm", json!(station_mm)),
        ("/carriage_clearance_mm", json!(clearance_mm)),
        ("/cutters/0/lateral/park_mm", json!(100)),
        ("/cutters/1/lateral/park_mm", json!(-100)),
    ])
}

/// A tape of 75 mm whose ply begins and ends like this, from the lower edge of the tape to the upper one.
fn ply(start: &[[f64; 2]], end: &[[f64; 2]]) -> Value {
    let outline = end.iter().chain(start.iter().rev()).map(|[u, v]| json!([u, v, 0.0]));
    json!({"kind": "tape-cut", "name": "n", "input": {
        "tape": {"width_mm": 75, "thickness_mm": 0.125},
        "boundary": {"points": outline.rev().collect::<Vec<_>>()},
        "tracks": [{"number": 1, "points": [{"position":[0,0,0],"normal":[0,0,1]},{"position":[300,0,0],"normal":[0,0,1]}]}]}})
}

const SQUARE_START: [[f64; 2]; 2] = [[0.0, -37.5], [0.0, 37.5]];
const SQUARE_END: [[f64; 2]; 2] = [[300.0, -37.5], [300.0, 37.5]];
/// Depth 23.4 on a half width of 37.5: 20 mm of tape are 32 mm across, more than the clearance of 30.
const GREATER: [[f64; 2]; 3] = [[300.0, -37.5], [323.4, 0.0], [300.0, 37.5]];
const LESS: [[f64; 2]; 3] = [[23.4, -37.5], [0.0, 0.0], [23.4, 37.5]];

fn free() -> Value {
    json!({"allocation": "free"})
}

/// The smallest distance of the carriages at the ends of all moves, by the text alone, and where they end.
fn distance(outcome: &Outcome) -> (f64, [f64; 2]) {
    let mut at = [100.0, -100.0];
    let mut least = f64::INFINITY;
    for executed in read("p", &outcome.programs[0].text).unwrap() {
        if let Event::Move { to, .. } = executed.event {
            at = [to[7], to[8]];
            least = least.min(at[0] - at[1]);
        }
    }
    (least, at)
}

fn cutters(outcome: &Outcome) -> Vec<u64> {
    let cuts = outcome.report["courses"][0]["pieces"][0]["cuts"].as_array().unwrap();
    cuts.iter().map(|cut| cut["cutter"].as_u64().unwrap()).collect()
}

fn usable(ply: &Value, machine: &Value, options: &Value) -> Outcome {
    let outcome = plan_job(ply, machine, options).unwrap();
    assert_eq!(outcome.verdict, Verdict::Usable, "{:?}", outcome.findings);
    let (least, last) = distance(&outcome);
    let clearance = machine["carriage_clearance_mm"].as_f64().unwrap();
    assert!(least >= clearance - 1e-4, "{least}");
    assert_eq!(last, [100.0, -100.0]);
    outcome
}

#[test]
fn a_greater_end_is_cut_with_a_cutter_on_each_side() {
    let outcome = usable(&ply(&SQUARE_START, &GREATER), &beam(20.0, 30.0), &json!(null));
    assert!(distance(&outcome).0 < 33.0, "they work side by side");
    // The upper leg falls toward +U and goes to cutter 1, which is above.
    let strokes =
        &bladeplan::planning::tape::trace::text::read(&outcome.attachments[0].text).unwrap().courses[0]
            .strokes;
    let cut = |cutter: u32, v: f64| {
        strokes.iter().any(|stroke| stroke.cutter == cutter && stroke.cuts[0].to[1] == v)
    };
    assert!(cut(1, 37.5) && cut(2, -37.5), "{strokes:?}");
    assert!(outcome.programs[0].text.contains("(CARRIAGES PARKED, OTHER AXES AT ZERO"));
    assert!(outcome.programs[0].text.contains("N20 G1 V100.0 W-100.0 A0.0 B0.0 F6.0\n"));
    let sheet = &outcome.attachments.iter().find(|text| text.name == "setup.md").unwrap().text;
    assert!(sheet.contains("## Zero positions at the start") && sheet.contains("parked at -100.0 mm"));
}

#[test]
fn a_less_end_is_refused_by_slope_and_cut_by_any_allocation() {
    let less = ply(&LESS, &SQUARE_END);
    let outcome = plan_job(&less, &beam(20.0, 30.0), &json!(null)).unwrap();
    let found: Vec<_> = outcome.findings.iter().filter(|finding| finding.is_error()).collect();
    assert!(found.iter().all(|finding| finding.code == Code::CarriagesTooClose), "{found:?}");
    // Cutter 2 goes down at v = 37.5 while cutter 1, above, is at -37.5 + 20 * 37.5 / 23.4 = -5.449.
    let message = &found[0].message;
    assert!(
        message.starts_with("course 1: between u ")
            && message.contains("cutter 1 comes too close to cutter 2"),
        "{message}"
    );
    assert!(
        message.contains("72.949 mm are lacking to the 30 mm") && message.contains("allocation: free"),
        "{message}"
    );
    let outcome = usable(&less, &beam(20.0, 30.0), &free());
    assert_eq!(cutters(&outcome).len(), 3);
    // Parked the other way round, the published rule suits a "<" and not a ">".
    let mut turned = beam(20.0, 30.0);
    turned["cutters"][0]["lateral"]["park_mm"] = json!(-100);
    turned["cutters"][1]["lateral"]["park_mm"] = json!(100);
    assert_eq!(plan_job(&less, &turned, &json!(null)).unwrap().verdict, Verdict::Usable);
    let greater = ply(&SQUARE_START, &GREATER);
    assert_eq!(plan_job(&greater, &turned, &json!(null)).unwrap().verdict, Verdict::NotUsable);
}

/// Both legs lie closer than the carriages may: whichever way they are given, it cannot be done.
#[test]
fn what_no_allocation_can_cut_is_refused() {
    for options in [json!(null), free()] {
        let outcome = plan_job(&ply(&SQUARE_START, &GREATER), &beam(15.0, 30.0), &options).unwrap();
        assert_eq!(outcome.verdict, Verdict::NotUsable);
        let fault = outcome.findings.iter().find(|finding| finding.is_error()).unwrap();
        assert!(fault.code == Code::CarriagesTooClose && fault.at == "/input/machine/carriage_clearance_mm");
        // 15 * 37.5 / 23.4 = 24.038 are there where cutter 2 goes down.
        assert!(fault.message.contains("5.962 mm are lacking"), "{fault}");
    }
}

#[test]
fn a_carriage_without_room_to_get_out_of_the_way_is_said() {
    let mut narrow = beam(20.0, 30.0);
    narrow["cutters"][1]["lateral"]["min_mm"] = json!(-60);
    narrow["cutters"][1]["lateral"]["park_mm"] = json!(-55);
    let outcome = plan_job(&ply(&SQUARE_START, &SQUARE_END), &narrow, &json!(null)).unwrap();
    let fault = outcome.findings.iter().find(|finding| finding.is_error()).unwrap();
    // Cutter 1 is at -37.5 and cutter 2 ends at -60.
    assert!(
        fault.message.contains("needs cutter 2 farther out of the way") && fault.message.contains("7.500 mm"),
        "{fault}"
    );
}

#[test]
fn the_replay_finds_carriages_that_close_in() {
    let (ply, machine) = (ply(&SQUARE_START, &GREATER), beam(20.0, 30.0));
    let text = usable(&ply, &machine, &json!(null)).programs[0].text.clone();
    assert!(check_program(&ply, &machine, &text).is_empty());
    let found = |from: &str, to: &str| -> Vec<String> {
        assert!(text.contains(from), "{from}\n{text}");
        let found = check_program(&ply, &machine, &text.replacen(from, to, 1));
        let close = found.into_iter().filter(|finding| finding.code == Code::CarriagesTooClose);
        close.map(|finding| finding.message).collect()
    };
    let parked = |w: &str| found("W-100.0", &format!("W{w}"));
    assert_eq!(parked("70.0").len(), 0);
    assert!(parked("70.1")[0].contains("come within 29.9000 mm"));
    assert!(parked("100.5")[0].contains("pass one another by 0.5000 mm"));
    // On a machine with a larger distance the same program does not pass.
    let found = check_program(&ply, &beam(20.0, 35.0), &text);
    assert!(found.iter().any(|finding| finding.code == Code::CarriagesTooClose), "{found:?}");
}

#[test]
fn every_ply_on_a_beam_passes_or_says_where_carriages_meet() {
    let (cut, refusals) = (Cell::new(0), Cell::new(0));
    let strategy = (
        plies(),
        5.0..250.0_f64,
        0.1..40.0_f64,
        any::<bool>(),
        prop_oneof![Just(0.0), 0.01..2.0_f64, -2.0..-0.01_f64],
    );
    let passes = |(ply, station, more, free, offset): (Ply, f64, f64, bool, f64)| {
        let mut machine = beam(station, station + more);
        (0..2).for_each(|k| {
            machine["cutters"][k]["lateral"]["min_mm"] = json!(-450);
            machine["cutters"][k]["lateral"]["max_mm"] = json!(450);
            machine["cutters"][k]["lateral"]["park_mm"] = json!([200, -200][k]);
            machine["cutters"][k]["blade"]["offset_mm"] = json!(offset);
            machine["cutters"][k]["blade"]["edges"] = json!(if offset == 0.0 { "double" } else { "single" });
        });
        let mut job = ply.job();
        job["input"]["options"] = json!({"allocation": if free { "free" } else { "by_slope" }});
        let outcome = plan_job(&job, &machine, &json!(null)).unwrap();
        let errors: Vec<_> = outcome.findings.iter().filter(|finding| finding.is_error()).collect();
        let honest = |finding: &&Finding| match finding.code {
            Code::TooManyKnives => true,
            Code::TapeReversal => offset != 0.0 && finding.at == "/input/machine",
            Code::CarriagesTooClose => finding.at.starts_with("/input/machine"),
            _ => false,
        };
        prop_assert!(errors.iter().all(honest), "{:?}", errors);
        let close = errors.iter().any(|finding| finding.code == Code::CarriagesTooClose);
        refusals.set(refusals.get() + usize::from(close));
        if free && !errors.is_empty() && errors.iter().all(|finding| finding.code != Code::TooManyKnives) {
            let published = plan_job(&job, &machine, &json!({"allocation": "by_slope"})).unwrap();
            prop_assert_eq!(published.verdict, Verdict::NotUsable, "any valid way is free's too");
        }
        if errors.is_empty() {
            cut.set(cut.get() + 1);
            prop_assert!(distance(&outcome).0 >= station + more - 2e-4, "{}", distance(&outcome).0);
            prop_assert_eq!(distance(&outcome).1, [200.0, -200.0]);
            let (time, bound) = (&outcome.report["time_s"], &outcome.report["bound_time_s"]);
            prop_assert!(time.as_f64() >= bound.as_f64(), "{} {}", time, bound);
            let read = outcome.report["replay"]["time_s"].as_f64().unwrap();
            prop_assert!((time.as_f64().unwrap() - read).abs() < 2e-3 * read, "{} {}", time, read);
        }
        Ok(())
    };
    runner(60).run(&strategy, passes).unwrap();
    // Of 60 plies about 15 are cut and 30 refused.
    assert!(cut.get() >= 3 && refusals.get() >= 3, "{} {}", cut.get(), refusals.get());
}

#[test]
fn a_program_from_a_course_on_begins_with_carriages_parked() {
    let example = job("examples/wing-skin-trapezoid-45.job.json");
    let machine = lab_with(&[
        ("/carriage_clearance_mm", json!(301)),
        ("/cutters/0/lateral/park_mm", json!(170)),
        ("/cutters/1/lateral/park_mm", json!(-170)),
    ]);
    let whole = plan_job(&example, &machine, &free()).unwrap();
    assert_eq!(whole.verdict, Verdict::NotUsable);
    let near =
        lab_with(&[("/cutters/0/lateral/park_mm", json!(60)), ("/cutters/1/lateral/park_mm", json!(-60))]);
    let mut usable = 0;
    for course in 1..=9 {
        let outcome = plan_job(&example, &near, &json!({"from_course": course})).unwrap();
        let found: Vec<_> = outcome.findings.iter().filter(|finding| finding.is_error()).collect();
        assert!(found.iter().all(|finding| finding.code == Code::KnifeState), "{found:?}");
        let (time, read) = (outcome.report["time_s"].as_f64(), outcome.report["replay"]["time_s"].as_f64());
        if let (Some(time), Some(read)) = (time, read) {
            usable += 1;
            assert!((time - read).abs() < 1e-3 * read, "{time} {read}");
        }
    }
    assert!(usable >= 3);
}

#[test]
fn profiles_that_park_carriages_too_close_are_refused() {
    let at = |pointer: &str| format!("/input/machine{pointer}");
    assert_eq!(
        refused(&lab_with(&[("/carriage_clearance_mm", json!(301))])),
        [(Code::OutOfRange, at("/carriage_clearance_mm"))]
    );
    assert_eq!(
        refused(&lab_with(&[("/cutters/1/lateral/park_mm", json!(171))])),
        [(Code::OutOfRange, at("/cutters/1/lateral/park_mm"))]
    );
    assert_eq!(
        refused(&lab_with(&[("/cutters/1/lateral/park_mm", json!(1e9))])),
        [(Code::OutOfRange, at("/cutters/1/lateral/park_mm"))]
    );
}
