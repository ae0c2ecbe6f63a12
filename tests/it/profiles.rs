//! Machine profiles and jobs for tests: the built-in profile, changed.

use std::path::Path;

use bladeplan::planning::attempt::check;
use bladeplan::planning::budget::Budget;
use bladeplan::planning::catalogue::Profile;
use bladeplan::planning::document;
use bladeplan::planning::document::files::Files;
use bladeplan::planning::finding::{Code, Finding};
use bladeplan::planning::outcome::{Outcome, ProgramFile};
use bladeplan::planning::tape::machine::Catalogue;
use serde_json::{Value, json};

use crate::linuxcnc::plan;

/// `two-cutter-lab` as JSON.
pub fn lab() -> Value {
    serde_json::to_value(Catalogue::built_in().get("two-cutter-lab").unwrap()).unwrap()
}

/// The lab with some values set, each by its JSON pointer; the last part may be a new field.
pub fn lab_with(changes: &[(&str, Value)]) -> Value {
    let mut profile = lab();
    for (pointer, value) in changes {
        let (parent, field) = pointer.rsplit_once('/').unwrap();
        profile.pointer_mut(parent).unwrap()[field] = value.clone();
    }
    profile
}

/// A job of the repository, by its path.
pub fn job(path: &str) -> Value {
    let text = std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join(path)).unwrap();
    serde_json::from_slice(&text).unwrap()
}

/// Plans a job on a machine with some options.
pub fn plan_job(job: &Value, machine: &Value, options: &Value) -> Result<Outcome, Vec<Finding>> {
    let mut job = job.clone();
    job["input"]["machine"] = machine.clone();
    if !options.is_null() {
        job["input"]["options"] = options.clone();
    }
    let document = document::from_value(job)?;
    plan(&document, &Files::default(), &Catalogue::built_in(), &Budget::unwatched())
}

/// What is found where a program is checked against a job on a machine.
pub fn check_program(job: &Value, machine: &Value, text: &str) -> Vec<Finding> {
    let mut job = job.clone();
    job["input"]["machine"] = machine.clone();
    let document = document::from_value(job).unwrap();
    let file = ProgramFile { name: "roll.ngc".to_owned(), dialect: "linuxcnc", text: text.to_owned() };
    check(&document, &Files::default(), &Catalogue::built_in(), &[file], &Budget::unwatched()).unwrap().1
}

/// Codes and places of the faults for which a job on a machine is refused.
pub fn refused(machine: &Value) -> Vec<(Code, String)> {
    let faults = plan_job(&job("examples/first.job.json"), machine, &json!(null)).unwrap_err();
    faults.into_iter().map(|fault| (fault.code, fault.at)).collect()
}

/// The profile of docs/jobs.md, with what stands there in short ("as cutter 1") written out.
fn documented() -> Value {
    let text = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/jobs.md")).unwrap();
    let (_, rest) = text.split_once("`two-cutter-lab` is exactly this\n```jsonc\n").unwrap();
    let (block, _) = rest.split_once("```").unwrap();
    let plain: Vec<&str> = block.lines().map(|line| line.split(" //").next().unwrap()).collect();
    let mut profile: Value = serde_json::from_str(&plain.join("\n")).unwrap();
    let first = profile["cutters"][0].clone();
    for part in ["lateral", "blade", "knife"] {
        let second = profile["cutters"][1][part].as_object_mut().unwrap();
        assert_eq!(second.remove("\u{2026}"), Some(json!("as cutter 1")));
        for (name, value) in first[part].as_object().unwrap() {
            second.entry(name).or_insert_with(|| value.clone());
        }
    }
    profile
}

#[test]
fn the_example_profile_is_the_built_in_one_and_that_of_the_documents() {
    let example = job("examples/two-cutter-lab.machine.json")["profile"].clone();
    assert_eq!(example, documented());
    // As both are read: 500 and 500.0 are the same there.
    let read = |profile: &Value| document::typed::<Profile>(profile.clone(), "").unwrap();
    let (example, built_in) = (read(&example), read(&lab()));
    assert_eq!(serde_json::to_value(&example).unwrap(), serde_json::to_value(&built_in).unwrap());
    assert_eq!(example.fingerprint(), built_in.fingerprint());
}
