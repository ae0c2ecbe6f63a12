//! A tape axis that turns a spool: the program commands degrees, and every cut comes out where it is wanted.

use std::cell::Cell;

use bladeplan::planning::finding::Code;
use bladeplan::planning::outcome::{Outcome, Verdict};
use bladeplan::planning::program::events::Event;
use bladeplan::planning::program::nc::read::read;
use proptest::prelude::*;
use serde_json::{Value, json};

use crate::profiles::{job, lab_with, plan_job, refused};
use crate::random_plies::{Ply, plies};
use crate::rounds::runner;

fn spooled(drive: &str, roll: f64, layer: f64) -> Value {
    let spool = json!({"core_radius_mm": 50, "roll_radius_mm": roll, "layer_thickness_mm": layer});
    lab_with(&[("/feed/drive", json!(drive)), ("/feed/spool", spool)])
}

fn first(machine: &Value) -> Outcome {
    plan_job(&job("examples/first.job.json"), machine, &json!(null)).unwrap()
}

/// The largest reading of U in a program.
fn last_u(outcome: &Outcome) -> f64 {
    let events = read("roll.ngc", &outcome.programs[0].text).unwrap();
    let readings = events.iter().filter_map(|executed| match executed.event {
        Event::Move { to, .. } => Some(to[6]),
        _ => None,
    });
    readings.fold(0.0, f64::max)
}

#[test]
fn the_axis_reads_the_degrees_of_the_radius() {
    let measured = last_u(&first(&lab_with(&[])));
    for (drive, sign) in [("unwind_angle", -1.0), ("takeup_angle", 1.0)] {
        let outcome = first(&spooled(drive, 100.0, 0.3));
        assert_eq!(outcome.verdict, Verdict::Usable, "{:?}", outcome.findings);
        // Numerically: many short steps, each at the radius in its middle.
        let (steps, mut angle) = (100_000, 0.0);
        for step in 0..steps {
            let x = (f64::from(step) + 0.5) / f64::from(steps) * measured;
            let radius = (100.0_f64.powi(2) + sign * 0.3 * x / std::f64::consts::PI).sqrt();
            angle += measured / f64::from(steps) / radius;
        }
        assert!((last_u(&outcome) - angle.to_degrees()).abs() < 2e-5, "{drive}");
    }
}

/// Thick layers on a small roll bend every cut; the moves are split so that all stays within the tolerance.
#[test]
fn every_ply_passes_its_replay_on_a_driven_spool() {
    let strategy = (plies(), 60.0..200.0_f64, 0.1..2.0_f64, any::<bool>());
    let split = Cell::new(0);
    let passes = |(ply, roll, layer, unwinds): (Ply, f64, f64, bool)| {
        let machine = spooled(if unwinds { "unwind_angle" } else { "takeup_angle" }, roll, layer);
        let outcome = ply.plan_on(&machine);
        let errors: Vec<_> = outcome.findings.iter().filter(|finding| finding.is_error()).collect();
        let said = |code: Code| matches!(code, Code::TooManyKnives | Code::AxisLimit);
        prop_assert!(errors.iter().all(|finding| said(finding.code)), "{:?}", errors);
        if let (Some(program), true) = (outcome.programs.first(), layer > 1.0) {
            let lab = ply.plan().programs.remove(0);
            split.set(split.get() + usize::from(program.text.lines().count() > lab.text.lines().count()));
        }
        Ok(())
    };
    runner(60).run(&strategy, passes).unwrap();
    assert!(split.get() > 0, "no move was split");
}

#[test]
fn a_spool_that_would_be_empty_is_refused_with_the_course() {
    let outcome = first(&spooled("unwind_angle", 51.0, 2.0));
    assert_eq!(outcome.verdict, Verdict::NotUsable);
    // Once, however many cuts there are.
    let limits: Vec<_> = outcome.findings.iter().filter(|finding| finding.code == Code::AxisLimit).collect();
    let [found] = limits[..] else { panic!("{limits:?}") };
    assert!(found.message.ends_with("that does not fit is 1"), "{found}");
    // pi (51^2 - 50^2) / 2
    assert!(found.message.contains("core of 50 mm, after 158.7 mm of tape"), "{found}");
    assert_eq!(first(&spooled("takeup_angle", 51.0, 2.0)).verdict, Verdict::Usable);
}

#[test]
fn a_program_for_another_roll_does_not_pass() {
    let text = first(&spooled("unwind_angle", 100.0, 0.3)).programs.remove(0).text;
    let mut other = job("examples/first.job.json");
    other["input"]["machine"] = spooled("unwind_angle", 100.5, 0.3);
    let document = bladeplan::planning::document::from_value(other).unwrap();
    let file =
        bladeplan::planning::outcome::ProgramFile { name: "roll.ngc".into(), dialect: "linuxcnc", text };
    let (_, findings) = bladeplan::planning::attempt::check(
        &document,
        &bladeplan::planning::document::files::Files::default(),
        &bladeplan::planning::tape::machine::Catalogue::built_in(),
        &[file],
        &bladeplan::planning::budget::Budget::unwatched(),
    )
    .unwrap();
    // The tape stands 2 mm off and more: the same cuts, in the wrong place.
    assert!(findings.iter().any(|finding| finding.code == Code::Unwanted), "{findings:?}");
}

#[test]
fn profiles_that_contradict_themselves_are_refused() {
    let at = |pointer: &str| format!("/input/machine{pointer}");
    assert_eq!(
        refused(&lab_with(&[("/feed/drive", json!("unwind_angle"))])),
        [(Code::MissingField, at("/feed/spool"))]
    );
    let mut measured = spooled("unwind_angle", 100.0, 0.3);
    measured["feed"]["drive"] = json!("length");
    assert_eq!(refused(&measured), [(Code::OutOfRange, at("/feed/spool"))]);
    assert_eq!(
        refused(&spooled("takeup_angle", 49.0, 0.3)),
        [(Code::OutOfRange, at("/feed/spool/roll_radius_mm"))]
    );
    let mut rotary = spooled("takeup_angle", 100.0, 0.3);
    rotary["feed"]["axis"] = json!("C");
    assert_eq!(refused(&rotary), [(Code::OutOfRange, at("/feed/axis"))]);
}

/// The tip of the example has legs of 45 degrees and is cut 300 mm apart by two knives.
#[test]
fn the_misses_at_a_tip_are_those_of_the_given_errors() {
    let spool = json!({"core_radius_mm": 50, "roll_radius_mm": 100, "layer_thickness_mm": 0.3, "radius_error_mm": 0.05});
    let machine = lab_with(&[
        ("/feed/drive", json!("unwind_angle")),
        ("/feed/spool", spool),
        ("/feed/error_mm", json!(0.02)),
        ("/cutters/0/lateral/error_mm", json!(0.01)),
        ("/cutters/1/lateral/error_mm", json!(0.03)),
    ]);
    let outcome = first(&machine);
    assert_eq!(outcome.report["tips"].as_array().unwrap().len(), 1);
    let tip = &outcome.report["tips"][0];
    assert_eq!((tip["kind"].as_str(), tip["at_uv"].clone()), (Some(">"), json!([400.0, 0.0])));
    let is = |name: &str, value: f64| {
        let found = tip[name].as_f64().unwrap();
        assert!((found - value).abs() < 1e-6, "{name} {found} {value}");
    };
    // The tip passes cutter 1 at 0.0 mm of tape, since the lead is what stands before it.
    let x = outcome.report["roll"]["lead_mm"].as_f64().unwrap() - 400.0;
    let squared = 1e4 - 0.3 * x / std::f64::consts::PI;
    let feed = 2.0 * 0.02 + 300.0 * 0.05 * 100.0 / squared;
    is("feed_mismatch_mm", feed);
    is("lateral_mismatch_mm", 0.04);
    is("mismatch_mm", feed.hypot(0.04));
    is("severing_overcut_mm", (feed + 0.04) * 0.5_f64.sqrt());
    is("uncorrected_feed_mismatch_mm", 300.0 * (1.0 - squared.sqrt() / 100.0));
    assert!(outcome.drawings.iter().any(|drawing| drawing.name == "tips.svg"));
    // Without errors nothing misses and nothing is drawn.
    let exact = first(&lab_with(&[]));
    assert_eq!(exact.report["tips"][0]["mismatch_mm"], 0.0);
    assert!(exact.drawings.iter().all(|drawing| drawing.name != "tips.svg"));
}

/// A round cut-out is a ring of two chains: both knives begin at its largest u and end at its smallest.
#[test]
fn a_cut_out_has_a_tip_at_either_end() {
    let round: Vec<[f64; 3]> = (0..60)
        .map(|i| f64::from(i * 6).to_radians())
        .map(|angle| [200.0 + 20.0 * angle.cos(), 20.0 * angle.sin(), 0.0])
        .collect();
    let mut holed = job("examples/first.job.json");
    holed["input"]["holes"] = json!([{"points": round}]);
    let outcome = plan_job(&holed, &lab_with(&[]), &json!(null)).unwrap();
    let tips = outcome.report["tips"].as_array().unwrap();
    let found: Vec<_> =
        tips.iter().map(|tip| (tip["kind"].clone(), tip["at_uv"][0].as_f64().unwrap())).collect();
    assert_eq!(found, [(json!(">"), 400.0), (json!(">"), 220.0), (json!("<"), 180.0)]);
}
