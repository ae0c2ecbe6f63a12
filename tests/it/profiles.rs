//! Machine profiles and jobs for tests: the built-in profile, changed.

use std::path::Path;

use bladeplan::planning::attempt::plan;
use bladeplan::planning::budget::Budget;
use bladeplan::planning::document;
use bladeplan::planning::document::files::Files;
use bladeplan::planning::finding::{Code, Finding};
use bladeplan::planning::outcome::Outcome;
use bladeplan::planning::tape::machine::Catalogue;
use serde_json::{Value, json};

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

/// Codes and places of the faults for which a job on a machine is refused.
pub fn refused(machine: &Value) -> Vec<(Code, String)> {
    let faults = plan_job(&job("examples/first.job.json"), machine, &json!(null)).unwrap_err();
    faults.into_iter().map(|fault| (fault.code, fault.at)).collect()
}
