//! A folder of inputs that must be refused: each with the exact codes and JSON pointers of all its faults.

use std::fs;
use std::path::{Path, PathBuf};

use bladeplan::planning::attempt::validate;
use bladeplan::planning::document;
use bladeplan::planning::document::files::Files;
use bladeplan::planning::finding::Finding;
use bladeplan::planning::tape::machine::Catalogue;
use serde::Deserialize;

/// A fault that a refused input must be refused for.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
pub struct Fault {
    /// The finding's code.
    pub code: String,
    /// The JSON pointer.
    pub at: String,
}

/// Every refused input: its path, its bytes and its faults, sorted.
pub fn cases() -> Vec<(PathBuf, Vec<u8>, Vec<Fault>)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/refused");
    let files = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut inputs: Vec<PathBuf> =
        files.filter(|path| !path.to_string_lossy().ends_with(".expected.json")).collect();
    inputs.sort();
    inputs
        .into_iter()
        .map(|path| {
            let expected = fs::read(path.with_extension("expected.json")).unwrap();
            let mut faults: Vec<Fault> = serde_json::from_slice(&expected).unwrap();
            faults.sort();
            let bytes = fs::read(&path).unwrap();
            (path, bytes, faults)
        })
        .collect()
}

fn refusal(bytes: &[u8]) -> Vec<Finding> {
    match document::read(bytes) {
        Ok(document) => {
            validate(&document, &Files::default(), &Catalogue::built_in()).expect_err("it must be refused")
        }
        Err(faults) => faults,
    }
}

#[test]
fn a_number_that_cannot_be_held_is_told_its_limit() {
    let (_, bytes, _) = cases().into_iter().find(|(path, ..)| path.ends_with("number-1e400.json")).unwrap();
    let faults = refusal(&bytes);
    assert!(faults[0].message.ends_with("it must lie between 1 and 2000"), "{}", faults[0].message);
    assert!(faults[0].message.contains("at most 1.797"), "{}", faults[0].message);
}

#[test]
fn each_is_refused_for_exactly_its_faults() {
    let cases = cases();
    assert!(cases.len() >= 40, "only {} refused inputs found", cases.len());
    for (path, bytes, expected) in cases {
        let mut found: Vec<Fault> = refusal(&bytes)
            .into_iter()
            .map(|finding| Fault { code: finding.code.as_str(), at: finding.at })
            .collect();
        found.sort();
        assert_eq!(found, expected, "{}", path.display());
    }
}
