//! The second dialect: the same plan in both, read back by two readers to the same moves.

use bladeplan::planning::finding::{Code, Finding};
use bladeplan::planning::outcome::{Outcome, Verdict};
use bladeplan::planning::program::events::{Event, Executed};
use bladeplan::planning::program::nc::{read, sinumerik};
use bladeplan::planning::tape::machine::{Machine, check};
use proptest::prelude::*;
use rstest::rstest;
use serde_json::{Value, json};

use crate::golden;
use crate::profiles::{job, lab_with, plan_job, refused};
use crate::random_plies::{Ply, plies};
use crate::rounds::runner;

fn words() -> Value {
    json!({"knives": [{"down": "M80", "up": "M81"}, {"down": "H12", "up": "H13"}],
        "ultrasonic": {"on": "M84", "off": "M85"}})
}

/// The lab with another control.
pub fn siemens() -> Value {
    lab_with(&[("/dialect", json!("sinumerik")), ("/program/words", words())])
}

fn machine(profile: &Value) -> Machine {
    check(&serde_json::from_value(profile.clone()).unwrap(), "").unwrap()
}

fn events(executed: Vec<Executed>) -> Vec<Event> {
    executed.into_iter().map(|executed| executed.event).collect()
}

/// What both programs do, if both can be made.
fn both(lab: &Outcome, other: &Outcome) -> Option<[Vec<Event>; 2]> {
    let (lab, other) = (lab.programs.first()?, other.programs.first()?);
    assert_eq!((lab.dialect, other.dialect), ("linuxcnc", "sinumerik"));
    assert_eq!((lab.name.as_str(), other.name.as_str()), ("roll.ngc", "roll.mpf"));
    let ours = read::read("roll.ngc", &lab.text).unwrap();
    let theirs = sinumerik::read("roll.mpf", &other.text, &machine(&siemens())).unwrap();
    Some([events(ours), events(theirs)])
}

#[test]
fn every_golden_job_does_the_same_in_both_dialects() {
    let mut compared = 0;
    for case in golden::cases() {
        let job = job(case.join("job.json").to_str().unwrap());
        let other = plan_job(&job, &siemens(), &json!(null)).unwrap();
        let lab = golden::outcome(&case);
        assert_eq!(lab.verdict, other.verdict);
        if let Some([lab, other]) = both(&lab, &other) {
            assert_eq!(lab, other, "{}", case.display());
            compared += 1;
        }
    }
    assert!(compared >= 5, "only {compared}");
}

#[test]
fn every_ply_does_the_same_in_both_dialects() {
    let same = |ply: Ply| {
        let (lab, other) = (ply.plan(), ply.plan_on(&siemens()));
        prop_assert_eq!(lab.verdict, other.verdict);
        if let Some([lab, other]) = both(&lab, &other) {
            prop_assert_eq!(lab, other);
        }
        Ok(())
    };
    runner(30).run(&plies(), same).unwrap();
}

#[test]
fn the_report_names_the_dialect_and_the_text_is_of_it() {
    let options = json!({"on_excess": "reject"});
    let mut profile = siemens();
    profile["program"]["optional_stop_per_course"] = json!(true);
    let outcome = plan_job(&job("examples/first.job.json"), &profile, &options).unwrap();
    assert_eq!(outcome.verdict, Verdict::Usable, "{:?}", outcome.findings);
    assert_eq!(outcome.report["programs"][0]["dialect"], "sinumerik");
    assert_eq!(outcome.report["programs"][0]["name"], "roll.mpf");
    let text = &outcome.programs[0].text;
    for needed in
        [" G710 ", " FGROUP(U,V,W,A,B)\n", " G93\n", " G4 F0.05\n", " M80\n", " H13\n", " M1\n", " M84\n"]
    {
        assert!(text.contains(needed), "{needed:?} in\n{text}");
    }
    assert!(text.ends_with(" M30\n") && text.starts_with("; BLADEPLAN"), "{text}");
    assert!(!text.contains(['%', '(', '=']) || text.matches('(').count() == text.matches("FGROUP(").count());
    assert!(!text.contains("M64") && !text.contains("M65"), "{text}");
}

#[test]
fn a_program_of_the_other_dialect_does_not_pass() {
    let lab = plan_job(&job("examples/first.job.json"), &lab_with(&[]), &json!(null)).unwrap();
    let found = sinumerik::read("p", &lab.programs[0].text, &machine(&siemens())).unwrap_err();
    assert!(found.iter().all(|finding: &Finding| finding.code != Code::Deviation) && !found.is_empty());
    let other = plan_job(&job("examples/first.job.json"), &siemens(), &json!(null)).unwrap();
    assert!(read::read("p", &other.programs[0].text).is_err());
}

#[rstest]
#[case("/knives/0/down", json!("M30"), "/knives/0/down")]
#[case("/knives/0/down", json!("M080"), "/knives/0/down")]
#[case("/knives/0/up", json!("M80"), "/knives/0/up")]
#[case("/ultrasonic/on", json!("G4"), "/ultrasonic/on")]
#[case("/ultrasonic/off", json!("M-1"), "/ultrasonic/off")]
#[case("/optional_stop", json!("M30"), "/optional_stop")]
#[case("/knives", json!([{"down": "M80", "up": "M81"}]), "/knives")]
fn words_that_mean_something_else_are_refused(#[case] at: &str, #[case] value: Value, #[case] said: &str) {
    let profile = siemens();
    let mut changed = profile.clone();
    let (parent, field) = at.rsplit_once('/').unwrap();
    let parent = changed.pointer_mut(&format!("/program/words{parent}")).unwrap();
    match field.parse::<usize>() {
        Ok(index) => parent[index] = value,
        Err(_) => parent[field] = value,
    }
    assert_eq!(refused(&changed), [(Code::OutOfRange, format!("/input/machine/program/words{said}"))]);
}

#[test]
fn words_belong_to_the_dialect_that_needs_them() {
    let at = "/input/machine/program/words".to_owned();
    assert_eq!(refused(&lab_with(&[("/program/words", words())])), [(Code::OutOfRange, at.clone())]);
    assert_eq!(refused(&lab_with(&[("/dialect", json!("sinumerik"))])), [(Code::MissingField, at)]);
}
