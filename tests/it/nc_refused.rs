//! A folder of NC programs that must be refused: each with the code and the line of every fault.

use std::fs;
use std::path::{Path, PathBuf};

use bladeplan::planning::program::nc::read::read;

use crate::refused::Fault;

#[test]
fn each_is_refused_for_exactly_its_lines() {
    let programs = programs();
    assert!(programs.len() >= 40, "only {} refused programs found", programs.len());
    for path in programs {
        let name = path.file_name().unwrap().to_str().unwrap();
        let expected = fs::read(path.with_extension("expected.json")).unwrap();
        let expected: Vec<Fault> = serde_json::from_slice(&expected).unwrap();
        let text = fs::read_to_string(&path).unwrap();
        let found: Vec<Fault> = read(name, &text)
            .expect_err(name)
            .into_iter()
            .map(|finding| Fault { code: finding.code.as_str(), at: finding.at })
            .collect();
        assert_eq!(found, expected, "{name}");
    }
}

fn programs() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/nc-refused");
    let files = fs::read_dir(folder).expect("the folder is there").flatten().map(|entry| entry.path());
    let mut programs: Vec<PathBuf> =
        files.filter(|path| path.extension().is_some_and(|extension| extension == "ngc")).collect();
    programs.sort();
    programs
}
