//! A folder of robot programs that must be refused: each with the code, file, line and column of every fault.

use std::fs;
use std::path::{Path, PathBuf};

use bladeplan::planning::outcome::ProgramFile;
use bladeplan::planning::program::krl::read::execute;

use crate::refused::Fault;

#[test]
fn each_is_refused_for_exactly_its_places() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/krl-refused");
    let mut folders: Vec<PathBuf> = fs::read_dir(root).unwrap().map(|entry| entry.unwrap().path()).collect();
    folders.sort();
    assert!(folders.len() >= 70, "only {} refused programs found", folders.len());
    for folder in folders {
        let name = folder.file_name().unwrap().to_str().unwrap();
        let expected = fs::read(folder.join("expected.json")).unwrap();
        let expected: Vec<Fault> = serde_json::from_slice(&expected).unwrap();
        let found: Vec<Fault> = execute(&files(&folder), &format!("{name}.src"))
            .expect_err(name)
            .into_iter()
            .map(|finding| Fault { code: finding.code.as_str(), at: finding.at })
            .collect();
        assert_eq!(found, expected, "{name}");
    }
}

/// The programs and data lists of a folder, by name.
pub fn files(folder: &Path) -> Vec<ProgramFile> {
    let mut paths: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    let is_program = |path: &&PathBuf| path.extension().is_some_and(|extension| extension != "json");
    let read = |path: &PathBuf| ProgramFile {
        name: path.file_name().unwrap().to_str().unwrap().to_owned(),
        dialect: "krl",
        text: fs::read_to_string(path).unwrap(),
    };
    paths.iter().filter(is_program).map(read).collect()
}
