//! Vim's own syntax and indentation of KRL as an independent reader of our robot programs.
//!
//! `make test` puts it under `target/vim` (`tests/vim/prepare`). It is kept by integrators of such robots and knows
//! nothing of this crate: it tells motions, statements, system variables, types and structures apart, and marks what
//! a control would refuse, such as names of more than 24 characters or `=` for `==`. Its indentation follows how
//! DEF, IF and their ends are nested. What it makes of a line is then a sentence of which there are only so many.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::Command;

use bladeplan::planning::geometry::Point2;
use bladeplan::planning::honeycomb::milling::{Blank, milling_program};
use bladeplan::planning::outcome::ProgramFile;
use bladeplan::planning::program::krl::emit::emit;
use bladeplan::planning::program::robot_moves::ToolDirection;
use proptest::strategy::{Strategy, ValueTree};

use crate::krl_convert::{setup, wave};
use crate::krl_emitted::{INPUT, programs, sample, stem};
use crate::rounds::runner;

/// Characters of a line that Vim takes for one thing.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Run {
    file: usize,
    line: usize,
    column: usize,
    group: String,
    text: String,
}

/// The sentences that our programs are made of, as Vim tells their words apart: names of groups without their `krl`,
/// `0` for numbers, `{}` for structures, `name` for what Vim has no group for.
const SENTENCES: [&str; 22] = [
    "",
    "Header name",
    "Header 0",
    "Typedef Function ( )",
    "Typedef name DatStorageClass",
    "Typedef",
    "Type Function ( Enum Paramdef , Type Paramdef )",
    "StorageClass StorageClass Type name = 0",
    "StorageClass Statement StorageClass 0 Statement Sysvars == Boolean Statement Function ( )",
    "Statement Statement 0",
    "Function ( EnumVal , 0 )",
    "Function ( )",
    "Sysvars [ 0 ] = Boolean",
    "name = 0",
    "Sysvars = {}",
    "Sysvars = 0",
    "Sysvars = EnumVal",
    "Movement {}",
    "Movement {} MoveMod",
    "Statement Statement Statement = 0 Statement = 0 Statement Sysvars [ 0 ] = Boolean",
    "Conditional name <= 0 Conditional",
    "Conditional",
];

/// How Vim takes files.
fn read(files: &[ProgramFile]) -> Vec<Run> {
    let folder = tempfile::tempdir().unwrap();
    for file in files {
        fs::write(folder.path().join(&file.name), &file.text).unwrap();
    }
    let vim = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/vim/read");
    let said = folder.path().join("said");
    let names = files.iter().map(|file| &file.name);
    let status = Command::new(&vim).current_dir(folder.path()).arg(&said).args(names).status();
    let status = status.unwrap_or_else(|error| panic!("{}: {error}; run tests/vim/prepare", vim.display()));
    assert!(status.success(), "{status}");
    let said = fs::read_to_string(said).unwrap();
    said.lines().map(run).collect()
}

fn run(line: &str) -> Run {
    let fields: Vec<&str> = line.splitn(5, '\t').collect();
    let [file, line, column, group, text] = fields[..] else { panic!("{line:?}") };
    let number = |text: &str| text.parse().unwrap();
    Run {
        file: number(file),
        line: number(line),
        column: number(column),
        group: group.to_owned(),
        text: text.to_owned(),
    }
}

/// Everything that Vim would not have in a program of ours, as `FILE:LINE:COLUMN: what`.
fn complaints(files: &[ProgramFile]) -> BTreeSet<String> {
    let runs = read(files);
    let mut complaints = BTreeSet::new();
    let say = |run: &Run, what: &str| format!("{}:{}:{}: {what}", files[run.file].name, run.line, run.column);
    for one in &runs {
        if one.group.starts_with("krlError") || one.group == "INDENT" {
            complaints.insert(say(one, &one.group));
        }
    }
    for line in runs.chunk_by(|one, other| (one.file, one.line) == (other.file, other.line)) {
        let sentence = sentence(line);
        if !SENTENCES.contains(&sentence.as_str()) {
            complaints.insert(say(&line[0], &format!("{sentence:?} is no sentence")));
        }
    }
    complaints
}

/// A line as the words of its groups.
fn sentence(line: &[Run]) -> String {
    let mut words: Vec<&str> = Vec::new();
    for run in line {
        let text = run.text.trim();
        match run.group.as_str() {
            _ if text.is_empty() => {}
            "krlComment" | "krlFoldComment" | "INDENT" => {}
            "krlDelimiter" if line.iter().any(|run| run.group == "krlFoldComment") => {}
            "krlStructVal" | "krlNames" => words.push("{}"),
            "krlInteger" | "krlFloat" | "krlArithOperator" => words.push("0"),
            "krlDelimiter" | "krlCompOperator" => words.push(text),
            "" => words.push("name"),
            group => words.push(&group[3..]),
        }
    }
    fold(&words)
}

/// Numbers are told in parts, and stand in structures: each is one word.
fn fold(words: &[&str]) -> String {
    let mut folded: Vec<&str> = Vec::new();
    for word in words {
        match (folded.last(), *word) {
            (Some(&"0"), "0") | (Some(&"{}"), "0" | "{}") => {}
            (_, word) => folded.push(word),
        }
    }
    folded.join(" ")
}

fn none(files: &[ProgramFile]) {
    assert_eq!(complaints(files), BTreeSet::new());
}

#[test]
fn vim_has_nothing_against_our_programs() {
    for direction in [ToolDirection::Z, ToolDirection::X] {
        none(&emit(&sample(direction), &stem(), INPUT).unwrap());
    }
    let layers = [vec![Point2::new(5.0, 25.0), Point2::new(10.0, 25.0)], vec![Point2::new(7.5, 20.5)]];
    let blank = Blank { width_mm: 20.0, length_mm: 50.0, height_mm: 30.0 };
    none(&[milling_program(&layers, &blank, 10.0, &setup(ToolDirection::Z), &stem(), INPUT).unwrap()]);
}

#[test]
fn vim_has_nothing_against_random_programs() {
    let mut runner = runner(1);
    // One Vim reads them all: each file under a name of its own.
    let programs = (0..3).flat_map(|number| {
        let program = programs().new_tree(&mut runner).unwrap().current();
        let files = emit(&program, &stem(), INPUT).unwrap();
        files.into_iter().map(move |file| ProgramFile { name: format!("{number}_{}", file.name), ..file })
    });
    none(&programs.collect::<Vec<_>>());
}

#[test]
fn vim_marks_nothing_in_a_converted_program() {
    // Its other lines are another's: they have their own way to stand.
    let runs = read(&[wave(ToolDirection::Z).program]);
    let errors: Vec<_> = runs.iter().filter(|run| run.group.starts_with("krlError")).collect();
    assert_eq!(errors, Vec::<&Run>::new());
    let moves = runs.iter().filter(|run| run.group == "krlMovement").count();
    assert_eq!(moves, wave(ToolDirection::Z).moves.len() + 3);
}

/// What is changed in a program, and what Vim says then, among other things.
const PLANTED: [(&str, &str, &str); 12] = [
    ("vcut_0123456789ab_first=1", "vcut_0123456789ab_first__=1", "krlError0"),
    ("  LIN {", "  LINE {", "\"name {}\" is no sentence"),
    (" C_DIS", " C_FAST", "\"Movement {} name\" is no sentence"),
    ("_first<=1 THEN", "_first=1 THEN", "krlError4"),
    ("_first<=1 THEN", "_first<=1", "\"Conditional name <= 0\" is no sentence"),
    ("  ENDIF", "", "INDENT"),
    ("  IF ", "  WHEN ", "INDENT"),
    ("$VEL.CP=0.2\r", "$VEL.CP:=0.2\r", "is no sentence"),
    ("$VEL.CP=0.2\r", "VEL.CP=0.2\r", "is no sentence"),
    ("DISTANCE=0", "DISTANCE==0", "krlError9"),
    ("DO $OUT[1]", "DO OUT[1]", "is no sentence"),
    ("\nEND\r", "\nENDE\r", "is no sentence"),
];

#[test]
fn vim_sees_what_is_planted() {
    let files = emit(&sample(ToolDirection::Z), &stem(), INPUT).unwrap();
    let planted = PLANTED.iter().enumerate().map(|(number, (before, after, _))| {
        let file = files.iter().rev().find(|file| file.text.contains(before)).expect(before);
        let text = file.text.replacen(before, after, 1);
        ProgramFile { name: format!("{number}.src"), text, ..file.clone() }
    });
    let complaints = complaints(&planted.collect::<Vec<_>>());
    for (number, (before, after, what)) in PLANTED.iter().enumerate() {
        let of_it = |said: &&String| said.starts_with(&format!("{number}.src:"));
        let said: Vec<_> = complaints.iter().filter(of_it).collect();
        assert!(said.iter().any(|said| said.contains(what)), "{before} -> {after}: {said:?}");
    }
}
