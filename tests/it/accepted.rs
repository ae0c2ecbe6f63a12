//! What is accepted and said: each oddity of an input with the exact code and place of its finding (docs/jobs.md).

use bladeplan::planning::budget::Budget;
use bladeplan::planning::document;
use bladeplan::planning::document::files::Files;
use bladeplan::planning::outcome::{Outcome, Verdict};
use bladeplan::planning::tape::machine::Catalogue;
use rstest::rstest;
use serde_json::{Value, json};

use crate::linuxcnc::plan;

/// A ply of one course, clockwise seen from its normals, without any oddity.
fn ply() -> Value {
    json!({"kind": "tape-cut", "input": {
        "tape": {"width_mm": 75, "thickness_mm": 0.125},
        "boundary": {"points": [[0, -37.5, 0], [0, 37.5, 0], [300, 37.5, 0], [300, -37.5, 0]]},
        "holes": [],
        "tracks": [{"number": 1, "points": [
            {"position": [0, 0, 0], "normal": [0, 0, 1]}, {"position": [300, 0, 0], "normal": [0, 0, 1]}]}],
        "machine": "two-cutter-lab"}})
}

fn planned(job: Value) -> Outcome {
    plan(&document::from_value(job).unwrap(), &Files::default(), &Catalogue::built_in(), &Budget::unwatched())
        .unwrap()
}

fn found(outcome: &Outcome) -> Vec<(String, String)> {
    outcome.findings.iter().map(|finding| (finding.code.as_str(), finding.at.clone())).collect()
}

#[test]
fn a_ply_without_oddities_gives_no_finding() {
    assert_eq!(found(&planned(ply())), []);
}

#[rstest]
#[case::closed("closed_outline", "/input/boundary/points/4",
    "/input/boundary/points", json!([[0,-37.5,0],[0,37.5,0],[300,37.5,0],[300,-37.5,0],[0,-37.5,0]]))]
#[case::repeated("repeated_point", "/input/boundary/points/2",
    "/input/boundary/points", json!([[0,-37.5,0],[0,37.5,0],[0,37.5,0],[300,37.5,0],[300,-37.5,0]]))]
#[case::counter_clockwise("outline_sense", "/input/boundary/points",
    "/input/boundary/points", json!([[300,-37.5,0],[300,37.5,0],[0,37.5,0],[0,-37.5,0]]))]
#[case::hole_like_the_boundary("outline_sense", "/input/holes/0/points",
    "/input/holes", json!([{"points": [[100,-5,0],[100,5,0],[120,5,0]]}]))]
#[case::scaled_normal("normal_scaled", "/input/tracks/0/points", "/input/tracks/0/points/0/normal", json!([0, 0, 2]))]
#[case::bare("ply_not_covered", "/input/tracks",
    "/input/boundary/points", json!([[0,-37.5,0],[0,60,0],[300,60,0],[300,-37.5,0]]))]
fn an_oddity_is_accepted_and_said(
    #[case] code: &str,
    #[case] at: &str,
    #[case] place: &str,
    #[case] value: Value,
) {
    let mut job = ply();
    *job.pointer_mut(place).unwrap() = value;
    let outcome = planned(job);
    assert_eq!(outcome.verdict, Verdict::Usable, "{:?}", outcome.findings);
    assert_eq!(found(&outcome), [(code.to_owned(), at.to_owned())]);
}

#[test]
fn a_closing_step_far_longer_than_the_others_is_said() {
    let mut job = ply();
    let side = |from: [f64; 2], to: [f64; 2]| {
        (0..40).map(move |i| {
            let t = f64::from(i) / 40.0;
            json!([from[0] + t * (to[0] - from[0]), from[1] + t * (to[1] - from[1]), 0])
        })
    };
    // The side along y = -37.5 was cut off: it closes with one step of 300 mm.
    let points: Vec<Value> = side([0.0, -37.5], [0.0, 37.5])
        .chain(side([0.0, 37.5], [300.0, 37.5]))
        .chain(side([300.0, 37.5], [300.0, -37.5]))
        .chain([json!([300, -37.5, 0])])
        .collect();
    job["input"]["boundary"]["points"] = json!(points);
    let outcome = planned(job);
    assert_eq!(found(&outcome), [("long_closing_step".to_owned(), "/input/boundary/points".to_owned())]);
}

#[test]
fn a_course_off_the_ply_is_left_out_and_a_ply_under_none_has_no_program() {
    let mut job = ply();
    let mut off = job["input"]["tracks"][0].clone();
    off["number"] = json!(2);
    for point in 0..2 {
        off["points"][point]["position"][1] = json!(500);
    }
    job["input"]["tracks"].as_array_mut().unwrap().push(off.clone());
    let outcome = planned(job.clone());
    assert_eq!(outcome.verdict, Verdict::Usable);
    assert_eq!(found(&outcome), [("course_off_ply".to_owned(), "/input/tracks/1".to_owned())]);
    job["input"]["tracks"] = json!([off]);
    let outcome = planned(job);
    assert_eq!(outcome.verdict, Verdict::NotUsable);
    assert!(found(&outcome).contains(&("no_course_on_ply".to_owned(), "/input/tracks".to_owned())));
}
