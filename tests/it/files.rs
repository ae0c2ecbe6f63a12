//! Plies whose outlines and tracks stand in files: drawings with known areas, files that must be refused, and the same
//! plan from files as from listed points.

use std::fs;
use std::path::{Path, PathBuf};

use bladeplan::planning::budget::Budget;
use bladeplan::planning::document;
use bladeplan::planning::document::files::Files;
use bladeplan::planning::finding::{Code, Finding};
use bladeplan::planning::outcome::{Drawing, Outcome, Verdict};
use bladeplan::planning::tape::file::dxf::{self, Wanted};
use bladeplan::planning::tape::file::text;
use bladeplan::planning::tape::machine::Catalogue;
use bladeplan::planning::tolerance::CURVE_CHORD_MM;
use proptest::prelude::*;
use serde_json::{Value, json};

use crate::linuxcnc::plan;
use crate::rounds::runner;
use crate::shared_tape;

fn folder(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures").join(name)
}

/// The files of a folder of fixtures, each with what is expected of it, by name.
fn fixtures(name: &str) -> Vec<(String, Vec<u8>, Value)> {
    let mut names: Vec<String> = fs::read_dir(folder(name))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .filter(|file| !file.ends_with(".expected.json"))
        .collect();
    names.sort();
    let expected = |file: &str| {
        let beside = folder(name).join(format!("{file}.expected.json"));
        let instead = folder(name).join(file).with_extension("expected.json");
        let text = fs::read(beside).or_else(|_| fs::read(instead)).unwrap();
        serde_json::from_slice(&text).unwrap()
    };
    names
        .into_iter()
        .map(|file| (file.clone(), fs::read(folder(name).join(&file)).unwrap(), expected(&file)))
        .collect()
}

fn places(findings: &[Finding]) -> Value {
    findings.iter().map(|finding| json!([finding.code.as_str(), finding.at])).collect()
}

fn area(points: &[[f64; 3]]) -> f64 {
    let ends = points.iter().zip(points.iter().cycle().skip(1));
    ends.map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum::<f64>().abs() / 2.0
}

#[test]
fn every_drawing_has_the_outlines_that_were_drawn() {
    let drawings = fixtures("dxf");
    assert!(drawings.len() >= 12, "only {} drawings found", drawings.len());
    for (name, bytes, expected) in drawings {
        let layers = serde_json::from_value(expected["layers"].clone()).ok();
        let (loops, findings) = dxf::read(&name, &bytes, layers.as_ref(), Wanted::Ply).unwrap();
        let areas = expected["areas"].as_array().unwrap();
        assert_eq!(loops.len(), areas.len(), "{name}");
        for (read, wanted) in loops.iter().zip(areas) {
            let perimeter: f64 = read
                .points
                .iter()
                .zip(read.points.iter().cycle().skip(1))
                .map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1]))
                .sum();
            let off = (area(&read.points) - wanted.as_f64().unwrap()).abs();
            assert!(off <= CURVE_CHORD_MM * perimeter, "{name}: area {} is not {wanted}", area(&read.points));
            assert!(
                read.points.iter().all(|point| point[2] == expected["z"].as_f64().unwrap_or(0.0)),
                "{name}"
            );
        }
        for (index, wanted) in expected["box"].as_array().unwrap().iter().enumerate() {
            let all = loops[0].points.iter().map(|point| point[index % 2]);
            let found = if index < 2 {
                all.fold(f64::INFINITY, f64::min)
            } else {
                all.fold(-f64::INFINITY, f64::max)
            };
            assert!(
                (found - wanted.as_f64().unwrap()).abs() <= CURVE_CHORD_MM,
                "{name}: {found} is not {wanted}"
            );
        }
        for (read, wanted) in loops.iter().zip(expected["points"].as_array().into_iter().flatten()) {
            assert_eq!(read.points.len() as u64, wanted.as_u64().unwrap(), "{name}");
        }
        assert_eq!(places(&findings), expected["findings"], "{name}: {findings:?}");
    }
}

/// A job whose outline, or whose trace, is in a file of that name.
fn job_of(name: &str) -> Value {
    let mut job = json!({"kind": "tape-cut", "input": {
        "tape": {"width_mm": 75, "thickness_mm": 0.125},
        "boundary": {"points": [[0, 0, 0], [0, 150, 0], [400, 150, 0], [400, 0, 0]]},
        "tracks": [{"number": 1, "points": [
            {"position": [0, 75, 0], "normal": [0, 0, 1]}, {"position": [400, 75, 0], "normal": [0, 0, 1]}]}],
        "machine": "two-cutter-lab"}});
    let place = if name.starts_with("trace") { "tracks" } else { "boundary" };
    job["input"][place] = json!({"file": name});
    job
}

fn attempt(job: Value, files: &[(&str, &[u8])]) -> Result<Outcome, Vec<Finding>> {
    let mut sent = Files::default();
    for (name, bytes) in files {
        sent.insert((*name).to_owned(), bytes.to_vec()).unwrap();
    }
    plan(&document::from_value(job).unwrap(), &sent, &Catalogue::built_in(), &Budget::unwatched())
}

#[test]
fn every_damaged_file_is_refused_for_exactly_its_faults_at_their_lines() {
    let damaged = fixtures("refused-files");
    assert!(damaged.len() >= 40, "only {} damaged files found", damaged.len());
    for (name, bytes, expected) in damaged {
        let faults = attempt(job_of(&name), &[(&name, &bytes)]).expect_err(&name);
        let mut found: Vec<_> = faults.iter().map(|fault| (fault.code.as_str(), fault.at.clone())).collect();
        let expected = expected.as_array().unwrap().iter();
        let text = |value: &Value| value.as_str().unwrap().to_owned();
        let mut expected: Vec<_> = expected.map(|fault| (text(&fault["code"]), text(&fault["at"]))).collect();
        found.sort();
        expected.sort();
        assert_eq!(found, expected, "{name}: {faults:?}");
    }
}

#[test]
fn the_faults_of_all_files_and_of_the_document_are_said_together() {
    let mut job = job_of("b.txt");
    job["input"]["tracks"] = json!({"file": "t.txt"});
    job["input"]["holes"] = json!([{"file": "h.dxf"}, {"points": [[1, 1, 0]]}]);
    job["input"]["machine"] = json!("nowhere");
    let faults =
        attempt(job, &[("b.txt", b"0 0\n1 1\n"), ("t.txt", b"track 1\nx\n"), ("h.dxf", b"")]).unwrap_err();
    let expected = json!([
        ["wrong_count", "b.txt:1"],
        ["wrong_count", "b.txt:2"],
        ["unreadable_file", "h.dxf:1"],
        ["wrong_type", "t.txt:2"],
        ["unknown_machine", "/input/machine"],
        ["too_few_points", "/input/holes/1/points"]
    ]);
    assert_eq!(places(&faults), expected, "{faults:?}");
}

#[test]
fn what_is_found_while_planning_is_said_at_its_line_too() {
    let boundary = b"# counter-clockwise, and closed\n0 0 0\n400 0 0\n400 150 0\n0 150 0\n0 0 0\n";
    let trace = b"track 4\n0 37.5 0 0 0 1\n400 37.5 0 0 0 1\n\ntrack 5\n0 900 0 0 0 1\n400 900 0 0 0 1\n";
    let mut job = job_of("b.txt");
    job["input"]["tracks"] = json!({"file": "t.txt"});
    let outcome = attempt(job, &[("b.txt", boundary), ("t.txt", trace)]).unwrap();
    let expected = json!([
        ["closed_outline", "b.txt:6"],
        ["outline_sense", "b.txt:2"],
        ["course_off_ply", "t.txt:5"],
        ["ply_not_covered", "/input/tracks"]
    ]);
    assert_eq!(places(&outcome.findings), expected);
    assert_eq!(outcome.report["findings"][2]["at"], "t.txt:5");
    assert_eq!(outcome.verdict, Verdict::Usable);
}

/// A report and its program without what names the bytes of the input.
fn meaning(outcome: &Outcome) -> (Value, Vec<String>) {
    let mut report = Value::clone(&outcome.report);
    for field in ["input_sha256", "programs", "findings"] {
        report.as_object_mut().unwrap().remove(field);
    }
    let lines = outcome.programs.iter().flat_map(|program| program.text.lines());
    (report, lines.filter(|line| !line.contains("(INPUT ")).map(str::to_owned).collect())
}

/// The example ply with its outline and its tracks as text.
fn as_text(job: &Value) -> (String, String) {
    let list = |values: &Value| {
        values.as_array().unwrap().iter().map(ToString::to_string).collect::<Vec<_>>().join(" ")
    };
    let points = job["input"]["boundary"]["points"].as_array().unwrap().iter();
    let boundary = points.fold(String::new(), |text, point| text + &list(point) + "\n");
    let mut trace = String::new();
    for track in job["input"]["tracks"].as_array().unwrap() {
        trace += &format!("track {}\r\n", track["number"]);
        for point in track["points"].as_array().unwrap() {
            trace += &format!("{} {}\r\n", list(&point["position"]), list(&point["normal"]));
        }
    }
    (boundary, trace)
}

#[test]
fn a_ply_from_files_is_planned_as_the_same_ply_listed() {
    let job: Value =
        serde_json::from_str(include_str!("../../examples/wing-skin-trapezoid-45.job.json")).unwrap();
    let (boundary, trace) = as_text(&job);
    let mut from_files = job.clone();
    from_files["input"]["boundary"] = json!({"file": "b.txt"});
    from_files["input"]["tracks"] = json!({"file": "t.txt"});
    let files: [(&str, &[u8]); 2] = [("b.txt", boundary.as_bytes()), ("t.txt", trace.as_bytes())];
    let (listed, read) = (attempt(job, &[]).unwrap(), attempt(from_files.clone(), &files).unwrap());
    assert_eq!(listed.verdict, Verdict::Usable);
    assert_eq!(meaning(&read), meaning(&listed));
    assert_eq!(unmarked(&read), unmarked(&listed));
    let again = attempt(from_files, &files).unwrap();
    assert_eq!((again.report, again.programs), (read.report, read.programs), "the same bytes each time");
}

/// The drawings without the hash of the input that each names.
fn unmarked(outcome: &Outcome) -> Vec<(&str, String)> {
    let hash = outcome.report["input_sha256"].as_str().unwrap();
    let drawing = |drawing: &Drawing| drawing.svg.replace(hash, "").replace(&hash[..12], "");
    outcome.drawings.iter().map(|found| (found.name.as_str(), drawing(found))).collect()
}

/// The cases that come with the task, where they are at hand.
fn shared(name: &str) -> Option<(Value, PathBuf)> {
    let folder = shared_tape::folder()?;
    let text = fs::read(folder.join(format!("{name}.job.json"))).unwrap();
    Some((serde_json::from_slice(&text).unwrap(), folder))
}

#[test]
fn the_texts_that_lie_beside_shared_jobs_give_the_plans_of_those_jobs() {
    let Some(folder) = shared_tape::folder() else { return };
    let names = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let names: Vec<String> =
        names.filter_map(|file| file.strip_suffix(".boundary.txt").map(str::to_owned)).collect();
    assert!(names.len() >= 6, "only {names:?} found");
    for name in names {
        let (job, folder) = shared(&name).unwrap();
        let mut from_files = job.clone();
        let input = &mut from_files["input"];
        input["boundary"] = json!({"file": format!("{name}.boundary.txt")});
        input["tracks"] = json!({"file": format!("{name}.trace.txt")});
        let holes =
            (1..=job["input"]["holes"].as_array().unwrap().len()).map(|i| format!("{name}.hole{i}.txt"));
        input["holes"] = holes.clone().map(|file| json!({"file": file})).collect();
        let names = [format!("{name}.boundary.txt"), format!("{name}.trace.txt")].into_iter().chain(holes);
        let files: Vec<_> = names.map(|file| (file.clone(), fs::read(folder.join(&file)).unwrap())).collect();
        let files: Vec<(&str, &[u8])> =
            files.iter().map(|(name, body)| (name.as_str(), body.as_slice())).collect();
        let (listed, read) = (attempt(job, &[]).unwrap(), attempt(from_files, &files).unwrap());
        assert_eq!(meaning(&read), meaning(&listed), "{name}");
    }
}

/// Whether two values are the same but for numbers that differ by less than 1e-5.
fn near(one: &Value, other: &Value) -> bool {
    match (one, other) {
        (Value::Number(a), Value::Number(b)) => (a.as_f64().unwrap() - b.as_f64().unwrap()).abs() < 1e-5,
        (Value::Array(a), Value::Array(b)) => a.len() == b.len() && a.iter().zip(b).all(|(a, b)| near(a, b)),
        (Value::Object(a), Value::Object(b)) => {
            a.len() == b.len() && a.iter().all(|(name, a)| b.get(name).is_some_and(|b| near(a, b)))
        }
        _ => one == other,
    }
}

/// What is cut of each course. Where on the roll is not compared: that is rounded to printed digits, and these shared
/// tracks lie 0.0000004 mm off the edge of their ply.
fn cuts(outcome: &Outcome) -> Value {
    let courses = outcome.report["courses"].as_array().unwrap().iter();
    let cuts = |piece: &Value| piece["cuts"].clone();
    courses
        .map(|course| {
            let pieces = course["pieces"].as_array().unwrap().iter().map(cuts).collect::<Vec<_>>();
            json!({"number": course["number"], "pieces": pieces})
        })
        .collect()
}

#[test]
fn generated_courses_cut_the_pieces_that_the_shared_tracks_cut() {
    for (name, angle) in [("a_flat_rect_0", 0), ("b_flat_trapezoid_45", 45), ("e_flat_cutouts", 0)] {
        let Some((job, _)) = shared(name) else { continue };
        let mut generated = job.clone();
        generated["input"].as_object_mut().unwrap().remove("tracks");
        generated["input"]["courses"] = json!({"angle_deg": angle});
        let (listed, generated) = (attempt(job, &[]).unwrap(), attempt(generated, &[]).unwrap());
        assert_eq!(generated.verdict, Verdict::Usable, "{name}: {:?}", generated.findings);
        assert!(near(&cuts(&generated), &cuts(&listed)), "{name}");
    }
}

#[test]
fn a_drawing_with_a_cut_out_is_cut_in_generated_courses() {
    let bytes = fs::read(folder("dxf").join("bulges.dxf")).unwrap();
    let mut job = job_of("bulges.dxf");
    job["input"].as_object_mut().unwrap().remove("tracks");
    job["input"]["courses"] = json!({"angle_deg": 0, "gap_mm": 0.5});
    job["input"]["tape"]["width_mm"] = json!(50);
    let outcome = attempt(job, &[("bulges.dxf", &bytes)]).unwrap();
    assert_eq!(outcome.verdict, Verdict::Usable, "{:?}", outcome.findings);
    let courses = outcome.report["courses"].as_array().unwrap();
    assert_eq!(courses.len(), 2);
    let pieces = courses.iter().flat_map(|course| course["pieces"].as_array().unwrap());
    let area: f64 = pieces.map(|piece| piece["area_mm2"].as_f64().unwrap()).sum();
    // The ply less its cut-out, less a gap of half a millimetre along its middle of 400 less the cut-out's 40.
    let ply = 30_000.0 + std::f64::consts::PI * (2500.0 - 400.0);
    assert!((area - (ply - 0.5 * 360.0)).abs() < 1.0, "{area}");
    assert!(outcome.report["replay"]["uncut_mm"].as_f64().unwrap() <= 0.02);
}

#[test]
fn courses_that_are_generated_are_named_by_their_rule() {
    let mut job = job_of("boundary.txt");
    job["input"]["boundary"] = json!({"points": [[0, 0, 0], [0, 150, 0], [400, 150, 0], [400, 0, 0]]});
    job["input"].as_object_mut().unwrap().remove("tracks");
    job["input"]["courses"] = json!({"angle_deg": 30, "gap_mm": 20});
    let outcome = attempt(job.clone(), &[]).unwrap();
    assert_eq!(places(&outcome.findings), json!([["ply_not_covered", "/input/courses"]]));
    job["input"]["courses"] = json!({"angle_deg": 0, "gap_mm": 1000, "offset_mm": 500});
    let outcome = attempt(job, &[]).unwrap();
    assert_eq!(
        (outcome.verdict, places(&outcome.findings)),
        (Verdict::NotUsable, json!([["no_course_on_ply", "/input/courses"]]))
    );
}

/// Drawings and texts with a few lines changed, doubled or gone.
fn changed() -> impl Strategy<Value = (String, Vec<u8>)> {
    let sources: Vec<(String, Vec<u8>)> =
        fixtures("dxf").into_iter().map(|(name, bytes, _)| (name, bytes)).collect();
    let values = prop::sample::select(vec![
        "0", "1", "-1", "8", "10", "1e300", "nan", "", "ENDSEC", "SPLINE", "\u{0}",
    ]);
    let change = (any::<prop::sample::Index>(), 0..3_u8, values);
    (prop::sample::select(sources), prop::collection::vec(change, 1..5)).prop_map(
        |((name, bytes), changes)| {
            let text = String::from_utf8(bytes).unwrap();
            let mut lines: Vec<&str> = text.split('\n').collect();
            for (index, kind, value) in changes {
                let index = index.index(lines.len());
                match kind {
                    0 => lines[index] = value,
                    1 => lines.insert(index, value),
                    _ => drop(lines.remove(index)),
                }
                if lines.is_empty() {
                    lines.push("");
                }
            }
            (name, lines.join("\n").into_bytes())
        },
    )
}

#[test]
fn a_drawing_that_was_changed_anywhere_is_read_or_refused() {
    runner(400)
        .run(&changed(), |(name, bytes)| {
            let lines = bytes.split(|byte| *byte == b'\n').count();
            let findings = match dxf::read(&name, &bytes, None, Wanted::Ply) {
                Ok((loops, findings)) => {
                    prop_assert!(!loops.is_empty());
                    findings
                }
                Err(faults) => faults,
            };
            for finding in findings {
                let line: usize = finding.at.rsplit_once(':').unwrap().1.parse().unwrap();
                prop_assert!((1..=lines).contains(&line), "{}", finding);
            }
            Ok(())
        })
        .unwrap();
}

#[test]
fn a_million_lines_are_read_line_by_line() {
    // As many steps as lines: a reader that looks back at each line would not end in this test's time.
    let outline: String = (0..1_000_000).map(|i| format!("{}.5 {}.25 0\n", i / 1000, i % 1000)).collect();
    let loops = text::read_loops("b.txt", outline.as_bytes()).unwrap();
    assert_eq!((loops.len(), loops[0].points.len(), loops[0].lines[999_999]), (1, 1_000_000, 1_000_000));
    let faults = text::read_loops("b.txt", outline.replace(" 0\n", "\n").as_bytes()).unwrap_err();
    assert_eq!((faults.len(), faults[100].code), (101, Code::WrongCount));
    assert!(faults[100].message.starts_with("999900 further faults"), "{}", faults[100]);
}
