//! Ends of any shape, on a machine of one cutter and of two: with `simplify` every one has a program, no cut goes into the
//! ply, and an end that needs no change gets none. So have pieces that are shorter than their ends are slanted.

use std::cell::Cell;

use bladeplan::planning::budget::Budget;
use bladeplan::planning::document;
use bladeplan::planning::document::files::Files;
use bladeplan::planning::finding::Code;
use bladeplan::planning::outcome::{Outcome, Verdict};
use bladeplan::planning::tape::machine::Catalogue;
use proptest::prelude::*;
use serde_json::{Value, json};

use crate::linuxcnc::plan;
use crate::rounds::runner;

const WIDTH: f64 = 75.0;
/// The middle of the ends' zigzag, in mm.
const END: f64 = 400.0;

/// The heights of an end over its v, from edge to edge.
fn end(heights: &[f64]) -> Vec<[f64; 2]> {
    let last = (heights.len() - 1) as f64;
    let at = |(i, height): (usize, &f64)| [END + height, WIDTH * (i as f64 / last - 0.5)];
    heights.iter().enumerate().map(at).collect()
}

fn job(heights: &[f64], on_excess: &str, cutters: usize) -> Value {
    let mut boundary = vec![[0.0, WIDTH / 2.0, 0.0], [0.0, -WIDTH / 2.0, 0.0]];
    boundary.extend(end(heights).iter().map(|[u, v]| [*u, *v, 0.0]));
    let mut machine = serde_json::to_value(Catalogue::built_in().get("two-cutter-lab").unwrap()).unwrap();
    machine["cutters"].as_array_mut().unwrap().truncate(cutters);
    let track = |u: f64| json!({"position": [u, 0.0, 0.0], "normal": [0.0, 0.0, 1.0]});
    json!({"kind": "tape-cut", "input": {
        "tape": {"width_mm": WIDTH, "thickness_mm": 0.125},
        "boundary": {"points": boundary},
        "tracks": [{"number": 1, "points": [track(0.0), track(600.0)]}],
        "machine": machine, "options": {"on_excess": on_excess}}})
}

fn planned(heights: &[f64], on_excess: &str, cutters: usize) -> Outcome {
    plan_of(&job(heights, on_excess, cutters))
}

fn plan_of(job: &Value) -> Outcome {
    let job = document::read(job.to_string().as_bytes()).unwrap();
    plan(&job, &Files::default(), &Catalogue::built_in(), &Budget::unwatched()).unwrap()
}

/// The largest u that the planned chains reach at a v: beyond it there is scrap.
fn reach(outcome: &Outcome, v: f64) -> f64 {
    heights_at(outcome, v).1
}

/// The smallest and the largest u of the planned chains at a v.
fn heights_at(outcome: &Outcome, v: f64) -> (f64, f64) {
    let cuts = outcome.report["courses"][0]["pieces"][0]["cuts"].as_array().unwrap();
    let points = |cut: &Value| -> Vec<[f64; 2]> { serde_json::from_value(cut["points_uv"].clone()).unwrap() };
    let across =
        cuts.iter().flat_map(|cut| points(cut).windows(2).map(|pair| [pair[0], pair[1]]).collect::<Vec<_>>());
    let at = |[a, b]: [[f64; 2]; 2]| {
        let holds = (a[1].min(b[1])..=a[1].max(b[1])).contains(&v);
        let one = if a[1] == b[1] { b[0] } else { a[0] + (v - a[1]) / (b[1] - a[1]) * (b[0] - a[0]) };
        let other = if a[1] == b[1] { a[0] } else { one };
        holds.then(|| (one.min(other), one.max(other)))
    };
    let none = (f64::INFINITY, f64::NEG_INFINITY);
    across.filter_map(at).fold(none, |all, here| (all.0.min(here.0), all.1.max(here.1)))
}

/// How far into the ply a cut may go: domain.md A5 takes a step back of less than 0.01 mm for none, and it is levelled from
/// both sides. So is one that comes about where a gap between two heights is filled.
fn levelled(heights: &[f64]) -> f64 {
    let pairs =
        heights.iter().enumerate().flat_map(|(at, one)| heights[..at].iter().map(move |other| (one, other)));
    pairs.map(|(one, other)| (one - other).abs()).filter(|step| *step < 0.01).fold(0.0, f64::max) / 2.0
}

#[test]
fn a_step_that_is_no_change_is_levelled_by_half_of_it() {
    let heights = [22.1104, 22.12, 0.0];
    let outcome = planned(&heights, "simplify", 1);
    assert_eq!((outcome.verdict, &outcome.report["simplified"]), (Verdict::Usable, &json!([])));
    let into = [422.1104, 422.12].map(|u| u - reach(&outcome, if u < 422.115 { -37.5 } else { 0.0 }));
    assert!((into[0] + 0.0048).abs() < 1e-6 && (into[1] - 0.0048).abs() < 1e-6, "{into:?}");
}

#[test]
fn every_end_has_a_program_and_no_cut_goes_into_the_ply() {
    let ends = (prop::collection::vec(-30.0..30.0_f64, 2..9), 1..=2_usize);
    let counts = [Cell::new(0), Cell::new(0)];
    let test = |(heights, cutters): (Vec<f64>, usize)| {
        let simplified = planned(&heights, "simplify", cutters);
        prop_assert_eq!(simplified.verdict, Verdict::Usable, "{:?}", simplified.findings);
        for [u, v] in end(&heights) {
            prop_assert!(reach(&simplified, v) >= u - levelled(&heights) - 1e-6, "{u} {v}: {heights:?}");
        }
        let rejected = planned(&heights, "reject", cutters);
        let said = &simplified.report["simplified"];
        if rejected.verdict == Verdict::Usable {
            prop_assert_eq!(said, &json!([]));
            prop_assert_eq!(&simplified.report["courses"], &rejected.report["courses"]);
        } else {
            prop_assert!(rejected.findings.iter().any(|finding| finding.code == Code::TooManyKnives));
            prop_assert!(simplified.findings.iter().any(|finding| finding.code == Code::OutlineSimplified));
            let deviation = said[0]["max_deviation_mm"].as_f64().unwrap();
            prop_assert!(deviation > 0.0 && said[0]["extra_area_mm2"].as_f64().unwrap() > 0.0);
            let farthest = end(&heights).iter().map(|[u, v]| reach(&simplified, *v) - u).fold(0.0, f64::max);
            prop_assert!((farthest - deviation).abs() < 0.02, "{farthest} is not {deviation}: {heights:?}");
        }
        Ok(rejected.verdict)
    };
    runner(100)
        .run(&ends, |input| {
            let count = &counts[usize::from(test(input)? == Verdict::Usable)];
            count.set(count.get() + 1);
            Ok(())
        })
        .unwrap();
    // Of use only if both happen.
    assert!(counts.iter().all(|count| count.get() > 5), "changed and not: {counts:?}");
}

#[test]
fn pieces_whose_ends_overlap_have_a_program_too() {
    let pieces = prop::collection::vec((0.0..150.0_f64, 5.0..150.0_f64), 2..6);
    let counts = [Cell::new(0), Cell::new(0)];
    let test = |(ends, cutters): (Vec<(f64, f64)>, usize)| {
        let (lower, heights): (Vec<f64>, Vec<f64>) =
            ends.iter().map(|(low, length)| (END + low, low + length)).unzip();
        let mut job = job(&heights, "simplify", cutters);
        let across = end(&heights).into_iter().zip(&lower).rev().map(|([_, v], low)| json!([low, v, 0.0]));
        let upper = end(&heights).into_iter().map(|[u, v]| json!([u, v, 0.0]));
        job["input"]["boundary"]["points"] = across.chain(upper).collect();
        let outcome = plan_of(&job);
        prop_assert_eq!(outcome.verdict, Verdict::Usable, "{:?}", outcome.findings);
        let all: Vec<f64> = lower.iter().copied().chain(end(&heights).iter().map(|[u, _]| *u)).collect();
        for ([u, v], low) in end(&heights).into_iter().zip(&lower) {
            let (least, most) = heights_at(&outcome, v);
            let into = levelled(&all) + 1e-6;
            prop_assert!(least <= low + into && most >= u - into, "{v}: {least} {low} {u} {most}");
        }
        let changed = outcome.report["simplified"].as_array().is_some_and(|said| !said.is_empty());
        let count = &counts[usize::from(changed)];
        count.set(count.get() + 1);
        Ok(())
    };
    runner(60).run(&(pieces, 1..=2_usize), test).unwrap();
    assert!(counts.iter().all(|count| count.get() > 5), "changed and not: {counts:?}");
}

/// A cut-out reaches as high as 410 mm, the end down to 405 mm beside it: the end is raised by 5 mm, to above the cut-out.
#[test]
fn an_end_keeps_clear_of_a_cut_out_that_needs_both_knives() {
    let heights = [60.0, 60.0, 5.0];
    let hole = json!([{"points": [[350, -10, 0], [410, -15, 0], [350, -20, 0]]}]);
    let planned = |on_excess: &str| {
        let mut job = job(&heights, on_excess, 2);
        job["input"]["holes"] = hole.clone();
        plan_of(&job)
    };
    let refused = planned("reject");
    assert!(
        refused.findings.iter().any(|finding| finding.code == Code::TooManyKnives),
        "{:?}",
        refused.findings
    );
    let changed = planned("simplify");
    assert_eq!(changed.verdict, Verdict::Usable, "{:?}", changed.findings);
    let said = changed.report["simplified"].as_array().unwrap();
    assert_eq!(said.len(), 1);
    let deviation = said[0]["max_deviation_mm"].as_f64().unwrap();
    assert!((deviation - 5.0).abs() < 1e-3, "{deviation}");
    assert!((reach(&changed, WIDTH / 2.0) - 410.0).abs() < 0.01);
}

#[test]
fn a_cut_out_that_needs_too_many_knives_is_refused_with_its_place() {
    let mut job = job(&[0.0, 0.0], "simplify", 1);
    job["input"]["holes"] = json!([{"points": [[100, 10, 0], [150, 0, 0], [100, -10, 0]]}]);
    let job = document::read(job.to_string().as_bytes()).unwrap();
    let outcome = plan(&job, &Files::default(), &Catalogue::built_in(), &Budget::unwatched()).unwrap();
    assert_eq!(outcome.verdict, Verdict::NotUsable);
    let finding = outcome.findings.iter().find(|finding| finding.code == Code::TooManyKnives).unwrap();
    assert!(
        finding.message.contains("100.000") && finding.message.contains("150.000"),
        "{}",
        finding.message
    );
}
