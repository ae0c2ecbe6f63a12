//! Honeycomb jobs from document to replayed program: the paper's figures, and changes that must be noticed.

use std::collections::BTreeSet;
use std::path::Path;

use bladeplan::planning::attempt::{check, validate};
use bladeplan::planning::budget::Budget;
use bladeplan::planning::document::{self, JobDocument, files::Files};
use bladeplan::planning::finding::{Code, Finding, any_error};
use bladeplan::planning::honeycomb::attempt::{lattice_tips, read_and_replay, wanted};
use bladeplan::planning::honeycomb::input::check_cut;
use bladeplan::planning::honeycomb::lattice::Spacing;
use bladeplan::planning::honeycomb::lattice_kind::Lattice;
use bladeplan::planning::honeycomb::wire::HoneycombCut;
use bladeplan::planning::outcome::{Outcome, ProgramFile, Verdict};
use bladeplan::planning::tape::machine::Catalogue;
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;
use rstest::rstest;
use serde_json::{Value, json};

use crate::linuxcnc::plan;
use crate::rounds::rounds;

/// The example, which is Table 1 of Cui et al. 2020 with an arc of radius 85 on top.
pub fn arc() -> Value {
    serde_json::from_str(include_str!("../../examples/honeycomb-arc.job.json")).unwrap()
}

fn read(job: &Value) -> JobDocument {
    document::from_value(job.clone()).unwrap()
}

pub fn planned(job: &Value) -> Outcome {
    plan(&read(job), &Files::default(), &Catalogue::built_in(), &Budget::unwatched()).unwrap()
}

fn with_parameters(h: f64, s: f64, alpha: f64) -> Value {
    let mut job = arc();
    job["input"]["plan"] = json!({"lattice": "orthogonal", "parameters":
        {"layer_spacing_mm": h, "step_mm": s, "swing_angle_deg": alpha}});
    job
}

fn near(value: &Value, wanted: f64, within: f64) {
    let found = value.as_f64().unwrap();
    assert!((found - wanted).abs() <= within, "{found} is not {wanted} within {within}");
}

/// Domain.md B3, "published, counted exactly".
#[rstest]
#[case::initial(3.0, 6.0, 45.0, 179, 537.0)]
#[case::optimum(4.398, 5.968, 34.155, 119, 315.0)]
fn the_arc_of_table_1_counted_exactly(
    #[case] h: f64,
    #[case] s: f64,
    #[case] alpha: f64,
    #[case] tips: u64,
    #[case] seconds: f64,
) {
    let outcome = planned(&with_parameters(h, s, alpha));
    let exact = &outcome.report["exact"];
    assert_eq!(exact["tips"], tips);
    near(&exact["time_s"], seconds, 0.5);
    let split: f64 =
        ["cutting_s", "turning_s", "moving_s"].iter().map(|part| exact[part].as_f64().unwrap()).sum();
    near(&exact["time_s"], split, 1e-9);
    near(&exact["gouge_area_mm2"], 0.0, 0.0);
    assert_eq!((&exact["stuck_chips"], &exact["chips"]), (&json!(0), &json!(tips)));
    assert_eq!(outcome.verdict, Verdict::Usable, "{:?}", outcome.findings);
}

#[test]
fn the_optimum_of_table_1_has_its_printed_digits() {
    let job: Value = serde_json::from_str(include_str!("../../examples/honeycomb-optimum.job.json")).unwrap();
    let outcome = planned(&job);
    assert_eq!((outcome.verdict, outcome.programs.len()), (Verdict::Usable, 0));
    let (parameters, estimate) = (&outcome.report["parameters"], &outcome.report["estimate"]);
    near(&parameters["swing_angle_deg"], 34.155, 5e-4);
    near(&parameters["layer_spacing_mm"], 4.398, 5e-4);
    near(&parameters["step_mm"], 5.968, 5e-4);
    near(&estimate["time_s"], 307.599, 5e-4);
    near(&estimate["initial_time_s"], 515.305, 6e-4);
    near(&estimate["scallop_mm"], 9.289, 5e-4);
    near(&estimate["saved_percent"], 40.31, 5e-3);
    assert_eq!(estimate["active"], json!(["cutting_length", "step"]));
    assert!(estimate["kkt_residual"].as_f64().unwrap() < 1e-6, "{estimate}");
    let drawings: Vec<_> = outcome.drawings.iter().map(|drawing| drawing.name.as_str()).collect();
    assert_eq!(drawings, ["optimum.svg", "comparison.svg"]);
}

#[test]
fn the_example_is_usable_and_says_both_ways() {
    let outcome = planned(&arc());
    assert_eq!(outcome.verdict, Verdict::Usable, "{:?}", outcome.findings);
    let report = &outcome.report;
    near(&report["exact"]["max_scallop_mm"], 8.01, 0.02);
    assert_eq!(report["published"]["tips"], 119);
    assert_eq!(report["initial"]["tips"], 179);
    assert_eq!((&report["robot"]["checked"], &report["robot"]["reachable"]), (&json!(true), &json!(true)));
    assert!(report["robot"]["max_joint_speed_ratio"].as_f64().unwrap() <= 1.0);
    assert!(
        outcome.summary.iter().any(|line| line.starts_with("published (orthogonal)") && line.contains("119"))
    );
    let names: Vec<_> = outcome.programs.iter().map(|file| file.name.as_str()).collect();
    assert!(names[0].ends_with(".src") && names.iter().any(|name| name.ends_with(".dat")), "{names:?}");
    for file in &outcome.programs {
        assert!(
            file.text.is_ascii() && !file.text.contains("-0.0,") && !file.text.contains("-0,"),
            "{}",
            file.name
        );
        assert!(file.text.lines().count() <= 2500 && file.text.lines().all(|line| line.len() < 200));
        assert!(file.text.ends_with("\r\n") && file.name.split('.').next().unwrap().len() <= 24);
    }
    assert_eq!(planned(&arc()).programs, outcome.programs, "the same bytes each time");
    let attached: Vec<_> = outcome.attachments.iter().map(|text| text.name.as_str()).collect();
    assert!(attached[0].starts_with("mill_") && attached[1] == "joints.csv", "{attached:?}");
    assert_eq!(report["attachments"], json!(attached));
}

#[test]
fn without_a_cell_it_is_planned_and_said_that_no_robot_was_checked() {
    let mut job = arc();
    job["input"].as_object_mut().unwrap().remove("cell");
    let outcome = planned(&job);
    assert_eq!(outcome.verdict, Verdict::Usable);
    assert!(outcome.findings.iter().any(|finding| finding.code == Code::RobotNotChecked));
    assert_eq!(outcome.report["robot"]["checked"], false);
    assert!(outcome.report.get("machine").is_none(), "without a machine nobody can approve it");
}

#[test]
fn a_part_that_lies_wrong_is_refused_with_a_place_that_works() {
    let mut job = with_parameters(4.398, 5.968, 34.155);
    job["input"]["cell"]["base_frame"]["x_mm"] = json!(4000);
    let outcome = planned(&job);
    assert_eq!((outcome.verdict, outcome.programs.len()), (Verdict::NotUsable, 0), "{:?}", outcome.findings);
    let fault = outcome.findings.iter().find(|finding| finding.code == Code::RobotFault).unwrap();
    assert!(fault.is_error() && fault.at.contains(".src:"), "{fault}");
    assert_eq!(outcome.report["robot"]["first_fault"]["at"], fault.at.as_str());
}

#[test]
fn all_three_lattices_are_planned_and_a_bad_one_says_why() {
    for lattice in ["orthogonal", "interlaced", "free"] {
        let mut job = arc();
        job["input"]["plan"] = json!({"lattice": lattice});
        let outcome = planned(&job);
        assert_eq!(outcome.report["lattice"], lattice);
        let usable = outcome.verdict == Verdict::Usable;
        assert_eq!(usable, !any_error(&outcome.findings), "{lattice}: {:?}", outcome.findings);
        near(&outcome.report["exact"]["gouge_area_mm2"], 0.0, 1e-9);
    }
}

#[test]
fn limits_that_exclude_everything_are_explained() {
    let mut job = arc();
    job["input"]["profile"]["points"] = json!([[0, 50], [85, 50]]);
    let outcome = planned(&job);
    assert_eq!(outcome.verdict, Verdict::NotUsable);
    let finding = outcome.findings.iter().find(|finding| finding.code == Code::NoParameters).unwrap();
    assert!(finding.message.contains("layers"), "{finding}");
}

#[test]
fn a_measured_contour_is_compared() {
    let mut job = arc();
    let points: Vec<Value> = job["input"]["profile"]["points"]
        .as_array()
        .unwrap()
        .iter()
        .map(|point| json!([point[0], point[1].as_f64().unwrap() + 1.5]))
        .collect();
    job["input"]["measured"] = json!({"points": points});
    let outcome = planned(&job);
    let measured = &outcome.report["measured"];
    assert!(measured["correlation"].as_f64().unwrap() > 0.999);
    near(&measured["max_deviation_mm"], 1.5, 1e-3);
    assert!(outcome.drawings.iter().any(|drawing| drawing.name == "contour-measured.svg"));

    job["input"]["measured"] = json!({"file": "scan.csv"});
    let mut files = Files::default();
    files.insert("scan.csv".into(), b"x,z\n0,5\n85,5\n".to_vec()).unwrap();
    let outcome = plan(&read(&job), &files, &Catalogue::built_in(), &Budget::unwatched()).unwrap();
    assert!(outcome.report["measured"]["max_deviation_mm"].as_f64().unwrap() > 5.0);
    files = Files::default();
    files.insert("scan.csv".into(), b"0 1\nwrong\n".to_vec()).unwrap();
    let faults = plan(&read(&job), &files, &Catalogue::built_in(), &Budget::unwatched()).unwrap_err();
    assert_eq!((faults[0].code, faults[0].at.as_str()), (Code::WrongType, "scan.csv:2"));
}

/// A number of a straight motion.
#[derive(Clone)]
struct Number {
    range: std::ops::Range<usize>,
    letter: char,
    /// Whether the motion begins or ends a cut. What goes over the safety plane, and down from it, does not.
    cuts: bool,
    /// Whether the blade leans out over +y there: on its way out.
    out: bool,
}

fn numbers(text: &str) -> Vec<Number> {
    let (mut found, mut was_high) = (Vec::new(), true);
    for (start, line) in text.match_indices("LIN {").map(|(at, _)| (at, text[at..].lines().next().unwrap())) {
        let high = line.contains("Z 60.0,");
        for letter in ['X', 'Y', 'Z', 'A', 'B', 'C'] {
            let from = start + line.find(&format!("{letter} ")).unwrap() + 2;
            let length = text[from..].find([',', '}']).unwrap();
            let out = !line.contains("B -");
            found.push(Number { range: from..from + length, letter, cuts: !high && !was_high, out });
        }
        was_high = high;
    }
    found
}

/// A change of an emitted program, and whether it changes what is cut beyond doubt: a place off its line by more than
/// what is printed, a posture by a tenth of a degree, an end of a cut where the blade is in the blank.
fn changed(text: &str, pick: usize, by: f64) -> (String, bool) {
    let numbers = numbers(text);
    let Number { range, letter, cuts, out } = numbers[pick % numbers.len()].clone();
    let value: f64 = text[range.clone()].parse().unwrap();
    let mut changed = text.to_owned();
    changed.replace_range(range, &format!("{:.4}", value + by));
    // Where the blade leans away from the blank, the tip alone has to leave it.
    let (near, to) = (value < 25.0, value + by);
    let other = match letter {
        'X' | 'Z' => by.abs() >= 0.01,
        'Y' if near => to > if out { value + 0.01 } else { 0.01 },
        'Y' => to < if out { 49.99 } else { value - 0.01 },
        _ => by.abs() >= 0.1,
    };
    (changed, cuts && other)
}

/// The replay alone, without planning the job anew for each program.
fn replaying(job: &Value) -> impl Fn(&[ProgramFile]) -> Vec<Finding> {
    let wire: HoneycombCut = serde_json::from_value(job["input"].clone()).unwrap();
    let input = check_cut(&wire, None).unwrap();
    let mut faults = Vec::new();
    let cell = bladeplan::planning::honeycomb::cell::check(
        wire.cell.as_ref(),
        &Catalogue::built_in(),
        None,
        &mut faults,
    );
    let spacing = Spacing { layer: 4.398, step: 5.968, swing: 34.155_f64.to_radians() };
    let tips = lattice_tips(Lattice::Orthogonal, &spacing, &input).unwrap();
    let cuts = wanted(&tips, spacing.swing);
    move |program| read_and_replay(program, &input.setting, Some(&input.profile), &cuts, &cell).1
}

#[test]
fn every_change_of_a_cut_is_forbidden() {
    // Three layers are enough of the lattice, and quicker.
    let mut job = with_parameters(4.398, 5.968, 34.155);
    job["input"]["profile"]["points"] = json!([[0, 36], [85, 36]]);
    let program = planned(&job).programs;
    let said = check(&read(&job), &Files::default(), &Catalogue::built_in(), &program, &Budget::unwatched());
    assert!(said.as_ref().unwrap().1.is_empty(), "{said:?}");
    let verdict = replaying(&job);
    assert!(verdict(&program).is_empty());
    let cuts = program.iter().position(|file| file.name.ends_with("_001.src")).unwrap();
    let mut runner = TestRunner::deterministic();
    let by = prop_oneof![-30.0..-0.2, 0.2..30.0];
    let (mut cuts_changed, mut tried) = (0, 0);
    while tried < rounds(300) {
        let pick = (0..100_000_usize).new_tree(&mut runner).unwrap().current();
        let by = by.new_tree(&mut runner).unwrap().current();
        let mut other = program.clone();
        let (text, is_other_cut) = changed(&other[cuts].text, pick, by);
        other[cuts].text = text;
        let findings = verdict(&other);
        tried += 1;
        cuts_changed += u32::from(is_other_cut);
        assert!(any_error(&findings) || !is_other_cut, "pick {pick} by {by}: {findings:?}");
    }
    assert!(cuts_changed >= 200, "only {cuts_changed} of {tried} change the cut");
}

/// What must never be run, each by one edit of the text, with a finding that says what it is.
#[rstest]
#[case::no_ultrasonic("TRIGGER WHEN DISTANCE=0 DELAY=0 DO $OUT[1]=TRUE", "", &[Code::KnifeState])]
#[case::too_fast("$VEL.CP=0.2", "$VEL.CP=0.3", &[Code::SpeedExceeded])]
#[case::rounded_cut("LIN {X 0.724,Y 56.0363,Z 45.602,A", "LIN {X 0.724,Y 56.0363,Z 45.602,C_DIS A", &[Code::UnreadableProgram])]
#[case::other_tool("$TOOL={X 0.0,Y 0.0,Z 300.0", "$TOOL={X 0.0,Y 0.0,Z 301.0", &[Code::WrongFrame])]
#[case::no_end("END", "", &[Code::NoProgramEnd, Code::UnreadableProgram])]
fn a_dangerous_edit_is_named(#[case] what: &str, #[case] with: &str, #[case] codes: &[Code]) {
    let job = read(&with_parameters(4.398, 5.968, 34.155));
    let mut program =
        plan(&job, &Files::default(), &Catalogue::built_in(), &Budget::unwatched()).unwrap().programs;
    let mut edited = 0;
    for file in &mut program {
        edited += usize::from(file.text.contains(what));
        file.text = file.text.replacen(what, with, if what == "END" { 1 } else { usize::MAX });
    }
    assert!(
        edited > 0,
        "{what} is not in the program: {}",
        program[1].text.lines().take(12).collect::<String>()
    );
    let (_, findings) =
        check(&job, &Files::default(), &Catalogue::built_in(), &program, &Budget::unwatched()).unwrap();
    let found: BTreeSet<Code> = findings.iter().filter(|f| f.is_error()).map(|f| f.code).collect();
    assert!(codes.iter().any(|code| found.contains(code)), "{found:?}");
}

#[test]
fn the_shared_inputs_are_planned() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/honeycomb");
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    let mut planned = 0;
    for path in entries
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.to_string_lossy().ends_with(".job.json"))
    {
        let job = document::read(&std::fs::read(&path).unwrap()).unwrap();
        validate(&job, &Files::default(), &Catalogue::built_in()).unwrap();
        let outcome = plan(&job, &Files::default(), &Catalogue::built_in(), &Budget::unwatched()).unwrap();
        let here = format!("{}: {:?}", path.display(), outcome.findings);
        assert_eq!(outcome.report["exact"]["gouge_area_mm2"], 0.0, "{here}");
        // The spoiler lies so that its robot runs out of its joints' range; a place that works is proposed.
        let refused = path.to_string_lossy().contains("spoiler");
        assert_eq!(outcome.verdict == Verdict::Usable, !refused, "{here}");
        let proposed = |finding: &Finding| finding.message.contains("this arm can follow with base_frame");
        assert_eq!(outcome.findings.iter().any(proposed), refused, "{here}");
        planned += 1;
    }
    assert!(planned > 0);
}

/// A milling program of ours for the example, and the job that converts it.
fn conversion(profile: bool) -> (Value, Files) {
    let outcome = planned(&with_parameters(4.398, 5.968, 34.155));
    let milling = outcome.attachments.iter().find(|text| text.name.starts_with("mill_")).unwrap();
    let input = &arc()["input"];
    let mut job = json!({"kind": "honeycomb-convert", "input": {"krl": {"file": "milling.src"},
        "blank": input["blank"], "tool": input["tool"], "process": input["process"], "cell": input["cell"],
        "parameters": {"swing_angle_deg": 34.155}}});
    if profile {
        job["input"]["profile"] = input["profile"].clone();
    }
    let mut files = Files::default();
    files.insert("milling.src".into(), milling.text.clone().into_bytes()).unwrap();
    (job, files)
}

#[test]
fn a_milling_program_is_converted_and_replayed() {
    for profile in [false, true] {
        let (job, files) = conversion(profile);
        let job = read(&job);
        let outcome = plan(&job, &files, &Catalogue::built_in(), &Budget::unwatched()).unwrap();
        assert_eq!(outcome.verdict, Verdict::Usable, "{:?}", outcome.findings);
        let exact = &outcome.report["exact"];
        assert_eq!((&exact["tips"], &exact["milling_cuts"]), (&json!(119), &json!(119)));
        assert_eq!((&exact["stuck_chips"], exact["max_scallop_mm"].is_null()), (&json!(0), !profile));
        assert_eq!(outcome.drawings[0].name, "milling.svg");
        let program = &outcome.programs;
        let (_, said) = check(&job, &files, &Catalogue::built_in(), program, &Budget::unwatched()).unwrap();
        assert!(said.iter().all(|finding| !finding.is_error()), "{said:?}");
        let mut other = program.clone();
        other[0].text = other[0].text.replacen("Z 45.602", "Z 45.702", 2);
        let (_, said) = check(&job, &files, &Catalogue::built_in(), &other, &Budget::unwatched()).unwrap();
        assert!(any_error(&said));
    }
}

#[test]
fn the_shared_milling_program_converts_and_replays() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/honeycomb/milling_arc.src");
    let Ok(text) = std::fs::read(path) else { return };
    let (job, _) = conversion(false);
    let mut files = Files::default();
    files.insert("milling.src".into(), text).unwrap();
    let outcome = plan(&read(&job), &files, &Catalogue::built_in(), &Budget::unwatched()).unwrap();
    assert_eq!(outcome.verdict, Verdict::Usable, "{:?}", outcome.findings);
    assert_eq!(outcome.report["exact"]["milling_cuts"], 121);
    near(&outcome.report["parameters"]["extension_mm"], 6.0363, 5e-5);
}

#[test]
fn a_milling_program_that_is_none_is_refused_at_its_line() {
    let (job, _) = conversion(false);
    let mut files = Files::default();
    files
        .insert("milling.src".into(), b"DEF x( )\nCIRC {X 1,Y 2,Z 3},{X 4,Y 5,Z 6}\nEND\n".to_vec())
        .unwrap();
    let faults = plan(&read(&job), &files, &Catalogue::built_in(), &Budget::unwatched()).unwrap_err();
    assert!(faults.iter().all(|fault| fault.at.starts_with("milling.src:")), "{faults:?}");
}
