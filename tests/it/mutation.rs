//! Change any one word of an emitted program: the check says so, and where the cut changes it forbids the run.
//!
//! Whether the cut changes is decided here by a simulation of its own, a few lines long, which knows nothing
//! but the words of the text.

use std::collections::HashMap;

use bladeplan::planning::attempt::check;
use bladeplan::planning::budget::Budget;
use bladeplan::planning::document::files::Files;
use bladeplan::planning::document::{self, JobDocument};
use bladeplan::planning::finding::{Code, any_error};
use bladeplan::planning::outcome::ProgramFile;
use bladeplan::planning::tape::machine::Catalogue;
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;

use crate::golden::{cases, outcome};
use crate::rounds::rounds;

/// A point of a cut as the text alone says: tape axis, carriage, blade.
pub type Point = [f64; 3];

/// A cut that differs by no more than this, in mm, is within what a replay must accept (0.011) for sure.
const SAME_MM: f64 = 0.009;
/// A cut that differs by more than this must be refused: the tolerance of both sides together.
const OTHER_MM: f64 = 0.025;
/// Degrees by which a blade must be off to be refused for sure: 1 allowed, 0.5 for turns along a segment.
const OTHER_DEG: f64 = 1.6;

/// What is done while a knife is down, stroke by stroke, and how the outputs follow each other.
#[derive(Debug, Default, PartialEq)]
pub struct Meaning {
    pub strokes: Vec<Vec<Point>>,
    /// Outputs as they really change; `hasty` where something moves before a knife has settled.
    switching: Vec<String>,
}

pub fn meaning(text: &str) -> Option<Meaning> {
    let mut axes: HashMap<char, f64> = "UVWAB".chars().map(|axis| (axis, 0.0)).collect();
    let mut down: [Option<Vec<Point>>; 2] = [None, None];
    let mut meaning = Meaning::default();
    let mut on: HashMap<&str, bool> = HashMap::new();
    let mut settled = f64::INFINITY;
    for line in text.lines().filter(|line| !line.starts_with('(')) {
        let words: Vec<&str> = line.split_whitespace().skip(1).collect();
        for word in &words {
            if let Some(axis) = axes.get_mut(&word.chars().next()?) {
                *axis = word[1..].parse().ok()?;
            }
        }
        let point = |k: usize| [axes[&'U'], axes[&['V', 'W'][k]], axes[&['A', 'B'][k]]];
        match words.as_slice() {
            [code @ ("M64" | "M65"), output] => {
                let set = *code == "M64";
                if on.insert(output, set).unwrap_or(false) == set {
                    continue;
                }
                let cutting = down.iter().any(Option::is_some);
                let Some(k) = ["P0", "P1"].iter().position(|knife| knife == output) else {
                    // Whether the generator is on matters where a knife is down.
                    if cutting {
                        meaning.switching.push(words.join(" "));
                    }
                    continue;
                };
                let generator = on.get("P2").copied().unwrap_or(false);
                meaning.switching.push(format!("{} generator {generator}", words.join(" ")));
                settled = 0.0;
                match set {
                    true => down[k] = Some(vec![point(k)]),
                    false => meaning.strokes.extend(down[k].take()),
                }
            }
            ["G4", time] => settled += time[1..].parse::<f64>().ok()?,
            ["G1", ..] => {
                if settled < 0.05 {
                    meaning.switching.push("hasty".to_owned());
                }
                settled = f64::INFINITY;
                for (k, stroke) in down.iter_mut().enumerate() {
                    // A move that goes nowhere cuts nothing.
                    stroke.iter_mut().filter(|s| s.last() != Some(&point(k))).for_each(|s| s.push(point(k)));
                }
            }
            _ => {}
        }
    }
    Some(meaning)
}

/// Whether a changed text certainly cuts something else, or switches otherwise.
fn cuts_otherwise(before: &Meaning, after: &Meaning) -> bool {
    let far = |one: &Point, other: &Point| (one[0] - other[0]).hypot(one[1] - other[1]) > OTHER_MM;
    before.switching != after.switching
        || before.strokes.len() != after.strokes.len()
        || before.strokes.iter().zip(&after.strokes).any(|(one, other)| {
            one.len() != other.len()
                || one.iter().zip(other).any(|(a, b)| far(a, b))
                || one.windows(2).zip(other.windows(2)).any(|(a, b)| blade_is_off(a, b))
        })
}

/// Whether a blade stands askew at the end of a segment that is cut.
fn blade_is_off(before: &[Point], after: &[Point]) -> bool {
    let run = (before[1][0] - before[0][0]).hypot(before[1][1] - before[0][1]);
    run > 0.1 && ((before[1][2] - after[1][2] + 90.0).rem_euclid(180.0) - 90.0).abs() > OTHER_DEG
}

/// Changes one word of a program, chosen by three numbers.
fn mutated(text: &str, place: usize, kind: u8, amount: f64) -> String {
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let blocks: Vec<usize> = (0..lines.len()).filter(|&i| lines[i].starts_with('N')).collect();
    let index = blocks[place % blocks.len()];
    let words: Vec<String> = lines[index].split_whitespace().map(str::to_owned).collect();
    let chosen = 1 + (place / blocks.len()) % (words.len() - 1);
    let mut words = words;
    let (letter, value) = words[chosen].split_at(1);
    let value: f64 = value.parse().unwrap();
    words[chosen] = match (letter, kind) {
        ("M", _) => if value == 64.0 { "M65" } else { "M64" }.to_owned(),
        ("P" | "G", _) => format!("{letter}{}", value + 1.0),
        ("F", _) => format!("F{:.4}", value * (1.0 + amount.abs())),
        (axis, _) => format!("{axis}{:.4}", value + amount),
    };
    if kind == 0 {
        lines.remove(index);
    } else {
        lines[index] = words.join(" ");
    }
    lines.join("\n") + "\n"
}

#[test]
fn every_change_is_said_and_every_other_cut_is_forbidden() {
    let programs: Vec<(JobDocument, String)> = cases()
        .iter()
        .filter_map(|case| {
            let text = outcome(case).programs.first()?.text.clone();
            Some((document::read(&std::fs::read(case.join("job.json")).unwrap()).unwrap(), text))
        })
        .collect();
    let changes = (0..programs.len(), any::<u16>(), 0..12_u8, prop_oneof![-30.0..30.0_f64, -0.2..0.2_f64]);
    let mut runner = TestRunner::deterministic();
    let (mut tried, mut forbidden) = (0, 0);
    for _ in 0..rounds(400) {
        let (which, place, kind, amount) = changes.new_tree(&mut runner).unwrap().current();
        let (job, text) = &programs[which];
        let changed = mutated(text, place as usize, kind, amount);
        if changed == *text {
            continue;
        }
        tried += 1;
        forbidden += usize::from(verify(job, text, &changed));
    }
    assert!(tried >= 200, "only {tried} changes tried");
    assert!(forbidden >= 100, "only {forbidden} changes change the cut");
}

/// Checks one change; says whether it changes the cut.
fn verify(job: &JobDocument, text: &str, changed: &str) -> bool {
    let changed_file = ProgramFile { name: "roll.ngc".into(), dialect: "linuxcnc", text: changed.to_owned() };
    let (figures, findings) =
        check(job, &Files::default(), &Catalogue::built_in(), &[changed_file], &Budget::unwatched()).unwrap();
    let said = findings.iter().any(|finding| finding.code == Code::DiffersFromPlan);
    assert!(said || any_error(&findings), "a change was passed over");
    let before = meaning(text).unwrap();
    let otherwise = meaning(changed).is_none_or(|after| cuts_otherwise(&before, &after));
    if otherwise {
        let line = text.lines().zip(changed.lines()).find(|(one, other)| one != other);
        assert!(any_error(&findings), "{line:?} changes the cut and passed: {figures} {findings:?}");
    }
    otherwise
}

#[test]
fn a_program_as_planned_passes_without_a_word() {
    for case in cases() {
        let Some(program) = outcome(&case).programs.into_iter().next() else { continue };
        let job = document::read(&std::fs::read(case.join("job.json")).unwrap()).unwrap();
        let (_, findings) =
            check(&job, &Files::default(), &Catalogue::built_in(), &[program], &Budget::unwatched()).unwrap();
        assert!(findings.is_empty(), "{}: {findings:?}", case.display());
    }
}

#[test]
fn rounding_alone_is_no_other_cut() {
    // The control of this test's own judgement: a change within the tolerance is no other cut.
    let text = "N10 G1 U0.0 V-37.5 A0.0 F1.0\nN20 M64 P0\nN30 G1 V37.5 F1.0\nN40 M65 P0\nN50 M2\n";
    let near = text.replace("V37.5", &format!("V{}", 37.5 + SAME_MM));
    let far = text.replace("V37.5", &format!("V{}", 37.5 + 2.0 * OTHER_MM));
    let before = meaning(text).unwrap();
    assert!(!cuts_otherwise(&before, &meaning(&near).unwrap()));
    assert!(cuts_otherwise(&before, &meaning(&far).unwrap()));
}

#[test]
fn a_line_longer_than_the_machine_takes_is_refused() {
    let case = cases().into_iter().find(|case| case.ends_with("greater-and-less")).unwrap();
    let job = document::read(&std::fs::read(case.join("job.json")).unwrap()).unwrap();
    let text = outcome(&case).programs.remove(0).text;
    // The profile says 200; LinuxCNC itself would take more.
    let errors = |length: usize| {
        let comment = format!("({})\n", "X".repeat(length - 2));
        let changed = text.replacen("N10 ", &format!("{comment}N10 "), 1);
        let changed = ProgramFile { name: "roll.ngc".into(), dialect: "linuxcnc", text: changed };
        let (_, findings) =
            check(&job, &Files::default(), &Catalogue::built_in(), &[changed], &Budget::unwatched()).unwrap();
        let errors = findings.into_iter().filter(|finding| finding.is_error());
        errors.map(|finding| (finding.code, finding.at)).collect::<Vec<_>>()
    };
    assert_eq!(errors(200), []);
    assert_eq!(errors(201), [(Code::UnreadableProgram, "roll.ngc:4".to_owned())]);
}
