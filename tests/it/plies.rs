//! Several plies on one roll: each is planned for itself, all are cut as one, and nothing of two courses with one number
//! is ever taken for the other.

use bladeplan::planning::attempt::check;
use bladeplan::planning::budget::Budget;
use bladeplan::planning::document;
use bladeplan::planning::document::files::Files;
use bladeplan::planning::finding::{Code, Finding};
use bladeplan::planning::outcome::{Outcome, Verdict};
use bladeplan::planning::tape::machine::Catalogue;
use bladeplan::planning::tape::trace::{PlantedTrace, text};
use proptest::prelude::*;
use serde_json::{Value, json};

use crate::linuxcnc::plan;
use crate::profiles::job;
use crate::random_plies::plies;
use crate::rounds::runner;

const EXAMPLE: &str = "examples/two-plies.job.json";

/// Printed positions are rounded up to this, in mm.
const PLACE_MM: f64 = 1e-4;

fn attempt(job: &Value, sent: &[(&str, &[u8])]) -> Result<Outcome, Vec<Finding>> {
    let document = document::read(job.to_string().as_bytes())?;
    plan(&document, &files(sent), &Catalogue::built_in(), &Budget::unwatched())
}

fn files(sent: &[(&str, &[u8])]) -> Files {
    let mut files = Files::default();
    for (name, body) in sent {
        files.insert((*name).to_owned(), body.to_vec()).unwrap();
    }
    files
}

fn planned(job: &Value) -> Outcome {
    attempt(job, &[]).unwrap()
}

fn with_options(mut job: Value, options: Value) -> Value {
    job["input"]["options"] = options;
    job
}

/// A job of one ply with that ply in a list.
fn in_a_list(flat: &Value) -> Value {
    let mut job = flat.clone();
    let input = job["input"].as_object_mut().unwrap();
    let mut ply = serde_json::Map::new();
    for name in ["boundary", "holes", "tracks", "courses"] {
        ply.extend(input.remove(name).map(|field| (name.to_owned(), field)));
    }
    ply.insert("name".to_owned(), json!("P12"));
    input.insert("plies".to_owned(), json!([ply]));
    job
}

/// A job of two plies of two jobs of one ply each, with the tape, machine and options of the first.
fn on_one_roll(one: &Value, other: &Value) -> Value {
    let (mut job, mut other) = (in_a_list(one), in_a_list(other));
    other["input"]["plies"][0]["name"] = json!("P13");
    job["input"]["plies"].as_array_mut().unwrap().push(other["input"]["plies"][0].take());
    job
}

fn attachment<'a>(outcome: &'a Outcome, name: &str) -> &'a str {
    &outcome.attachments.iter().find(|attachment| attachment.name == name).unwrap().text
}

/// Ply and number of each entry of a list of the report.
fn labels(list: &Value, number: &str) -> Vec<(u64, u64)> {
    let whole = |value: &Value| value.as_u64().unwrap();
    list.as_array().unwrap().iter().map(|entry| (whole(&entry["ply"]), whole(&entry[number]))).collect()
}

fn tape_mm(outcome: &Outcome) -> f64 {
    outcome.report["roll"]["tape_used_mm"].as_f64().unwrap()
}

#[test]
fn a_list_of_one_ply_is_that_ply() {
    for path in ["examples/wing-skin-trapezoid-45.job.json", "tests/golden/greater-and-less/job.json"] {
        let flat = with_options(job(path), json!({"from_course": 1}));
        let (one, other) = (planned(&flat), planned(&in_a_list(&flat)));
        assert_eq!(one.verdict, Verdict::Usable, "{:?}", one.findings);
        let lines = |outcome: &Outcome| -> Vec<String> {
            let lines = outcome.programs[0].text.lines().filter(|line| !line.starts_with("(INPUT "));
            lines.map(str::to_owned).collect()
        };
        assert_eq!(lines(&one), lines(&other));
        assert_eq!(one.programs[0].name, other.programs[0].name);
        // A drawing names its input, by the beginning of the hash too.
        let drawn = |outcome: &Outcome| -> Vec<(String, String)> {
            let input = outcome.report["input_sha256"].as_str().unwrap();
            let drawings = outcome.drawings.iter();
            drawings
                .map(|drawing| {
                    (drawing.name.clone(), drawing.svg.replace(input, "").replace(&input[..12], ""))
                })
                .collect()
        };
        assert!(drawn(&one) == drawn(&other), "the drawings differ");
        assert_eq!(one.attachments[..2], other.attachments[..2], "both forms of the trace");
        let meaning = |outcome: &Outcome| {
            let mut report = Value::clone(&outcome.report);
            let fields = report.as_object_mut().unwrap();
            fields.retain(|name, _| !["input_sha256", "programs", "findings"].contains(&name.as_str()));
            report
        };
        assert_eq!(meaning(&one), meaning(&other));
        // Only where something stands in the document differs.
        let said = |outcome: &Outcome| -> Vec<(Code, String, String)> {
            let at = |finding: &Finding| finding.at.replace("/plies/0", "");
            let said = outcome.findings.iter();
            said.map(|finding| (finding.code, at(finding), finding.message.clone())).collect()
        };
        assert_eq!(said(&one), said(&other));
    }
}

#[test]
fn the_cassette_gives_the_first_ply_out_first() {
    let job = job(EXAMPLE);
    let outcome = planned(&job);
    assert_eq!(outcome.verdict, Verdict::Usable, "{:?}", outcome.findings);
    let laid: Vec<(u64, u64)> = (1..=3).map(|n| (1, n)).chain((1..=7).map(|n| (2, n))).collect();
    assert_eq!(labels(&outcome.report["courses"], "number"), laid);
    assert_eq!(labels(&outcome.report["manifest"], "course"), laid);
    let names: Vec<&Value> =
        outcome.report["manifest"].as_array().unwrap().iter().map(|entry| &entry["ply_name"]).collect();
    assert_eq!((names[0], names[9]), (&json!("P1, along"), &json!("P2, at 45 degrees")));
    let cut: Vec<&str> =
        outcome.programs[0].text.lines().filter(|line| line.starts_with("(COURSE")).collect();
    assert!(cut[0].starts_with("(COURSE 7 OF PLY 2, ") && cut[9].starts_with("(COURSE 1 OF PLY 1, "));
    // Nothing that people call a ply reaches the machine.
    assert!(!outcome.programs[0].text.contains("along") && !outcome.programs[0].text.contains("degrees"));

    let laying = planned(&with_options(job, json!({"roll_order": "laying"})));
    let reversed: Vec<_> = laid.into_iter().rev().collect();
    assert_eq!(labels(&laying.report["manifest"], "course"), reversed);
}

#[test]
fn trace_sheet_and_drawings_name_the_ply_of_each_course() {
    let mut job = job(EXAMPLE);
    job["input"]["plies"][1]["name"] = json!("<b>P2</b> | `x` # \u{202e}");
    let outcome = planned(&job);
    let trace = text::read(attachment(&outcome, "trace-planted.txt")).unwrap();
    let from_json: PlantedTrace = serde_json::from_str(attachment(&outcome, "trace-planted.json")).unwrap();
    assert_eq!(trace, from_json);
    let named: Vec<_> = trace
        .courses
        .iter()
        .map(|course| (u64::from(course.ply.unwrap()), u64::from(course.number)))
        .collect();
    assert_eq!(named, labels(&outcome.report["courses"], "number"));
    // Each of them has its own points and its own strokes.
    assert!(trace.courses.iter().all(|course| course.points.len() == 2 && !course.strokes.is_empty()));
    assert_ne!(trace.courses[0].points, trace.courses[3].points);

    let sheet = attachment(&outcome, "setup.md");
    assert!(sheet.contains("| 1 | P1, along | 3 |"), "{sheet}");
    assert!(sheet.contains("| 2 | \\<b\\>P2\\<\\/b\\> \\| \\`x\\` \\#   | 7 |"), "{sheet}");
    assert!(sheet.contains("| first piece cut | course 7 of ply 2, piece 1 |"), "{sheet}");
    assert!(sheet.contains("| 4 | 2 | 1 | 1 |"), "{sheet}");
    for name in ["pieces.svg", "roll-operator.svg"] {
        let svg = &outcome.drawings.iter().find(|drawing| drawing.name == name).unwrap().svg;
        assert!(svg.contains("2 plies on one roll") && svg.contains("course 1 of ply 2"), "{name}");
    }
    let roll = &outcome.drawings.iter().find(|drawing| drawing.name == "roll.svg").unwrap().svg;
    assert!(roll.contains(">2/4<") && roll.contains(">1/2<"));
}

#[test]
fn a_program_goes_on_from_the_course_of_the_ply_that_was_meant() {
    let whole = planned(&job(EXAMPLE));
    let from = |ply: u32, course: u32| {
        planned(&with_options(
            job(EXAMPLE),
            json!({"allocation": "free", "from_ply": ply, "from_course": course}),
        ))
    };
    let (second, first) = (from(2, 3), from(1, 3));
    for (outcome, ply, left) in [(&second, 2, 6), (&first, 1, 3)] {
        assert_eq!(outcome.verdict, Verdict::Usable, "{:?}", outcome.findings);
        let program = &outcome.programs[0];
        assert_eq!(program.name, format!("roll-from-ply-{ply}-course-3.ngc"));
        let labels = program.text.lines().filter(|line| line.starts_with("(COURSE"));
        let labels: Vec<&str> = labels.collect();
        assert_eq!(labels[0], format!("(COURSE 3 OF PLY {ply}, RESTART HERE)"));
        assert_eq!(labels.len(), left);
        assert_eq!((&outcome.report["from_ply"], &outcome.report["from_course"]), (&json!(ply), &json!(3)));
        let sheet = attachment(outcome, "setup.md");
        assert!(sheet.contains(&format!("from course 3 of ply {ply}.**")), "{sheet}");
        let cut = format!("| pieces cut by this program | {left}");
        assert!(
            [" |", ", and the rest of 1 begun before |"]
                .iter()
                .any(|rest| sheet.contains(&format!("{cut}{rest}"))),
            "{sheet}"
        );
        // What is left of the whole program, word for word.
        let rest = |text: &str| -> Vec<String> {
            let lines = text.lines().rev().take_while(|line| *line != labels[0]);
            lines.map(|line| line.split_once(' ').unwrap().1.to_owned()).collect()
        };
        let (made, all) = (rest(&program.text), rest(&whole.programs[0].text));
        let same = made.iter().zip(&all).take_while(|(one, other)| one == other).count();
        // But for how long the way into place takes.
        assert!(made.len() == all.len() && same + 6 >= made.len(), "{same} of {}", made.len());
    }
    let nowhere = from(1, 7);
    assert_eq!(
        (nowhere.findings[0].code, &*nowhere.findings[0].at),
        (Code::NoCourseOnPly, "/input/options/from_course")
    );
    assert!(nowhere.findings[0].message.ends_with("a course 7 of ply 1"), "{}", nowhere.findings[0]);
}

/// Of two plies with the same numbers the second one has an end with three changes of sense.
#[test]
fn what_only_the_second_ply_cannot_have_is_said_of_it() {
    let (good, bad) =
        (job("tests/golden/square/job.json"), job("tests/golden/three-changes-excess/job.json"));
    let outcome = planned(&on_one_roll(&good, &bad));
    assert_eq!(outcome.verdict, Verdict::NotUsable);
    let alone = planned(&bad);
    let (of_two, of_one) = (&outcome.findings, &alone.findings);
    assert_eq!((of_two.len(), of_two[0].code), (of_one.len(), Code::TooManyKnives));
    for (two, one) in of_two.iter().zip(of_one) {
        assert_eq!(two.at, one.at.replace("/input/", "/input/plies/1/"));
        assert_eq!(two.message, one.message.replace("course 1:", "course 1 of ply 2:"));
    }
    assert_ne!(of_two[0].message, of_one[0].message);

    // The same job with what is said of simplified outlines.
    let simplified = planned(&with_options(on_one_roll(&good, &bad), json!({"on_excess": "simplify"})));
    assert_eq!(simplified.verdict, Verdict::Usable, "{:?}", simplified.findings);
    assert_eq!(labels(&simplified.report["simplified"], "course"), [(2, 1)]);
    let said = simplified.findings.iter().find(|finding| finding.code == Code::OutlineSimplified).unwrap();
    assert_eq!(said.at, "/input/plies/1/tracks/0");
    assert!(said.message.starts_with("course 1 of ply 2:"), "{said}");
}

#[test]
fn each_ply_is_judged_by_its_own_courses() {
    let square = job("tests/golden/square/job.json");
    let mut job = on_one_roll(&square, &square);
    // Ply 1 lies half bare and turns the other way; a course of ply 2 misses it, and would lie on ply 1.
    job["input"]["plies"][0]["boundary"]["points"] =
        json!([[300, -37.5, 0], [300, 100, 0], [0, 100, 0], [0, -37.5, 0]]);
    let mut beside = square["input"]["tracks"][0].clone();
    beside["number"] = json!(2);
    for point in beside["points"].as_array_mut().unwrap() {
        point["position"][1] = json!(75);
    }
    job["input"]["plies"][1]["tracks"].as_array_mut().unwrap().push(beside);
    let outcome = planned(&job);
    assert_eq!(outcome.verdict, Verdict::Usable, "{:?}", outcome.findings);
    let found: Vec<(Code, &str)> =
        outcome.findings.iter().map(|finding| (finding.code, finding.at.as_str())).collect();
    let expected = [
        (Code::OutlineSense, "/input/plies/0/boundary/points"),
        (Code::PlyNotCovered, "/input/plies/0/tracks"),
        (Code::CourseOffPly, "/input/plies/1/tracks/1"),
    ];
    assert_eq!(found, expected);
    assert!(outcome.findings[1].message.contains("of ply 1 (\"P12\");"), "{}", outcome.findings[1]);
    assert!(outcome.findings[2].message.starts_with("course 2 of ply 2 "), "{}", outcome.findings[2]);
    // A ply without any piece is no ply of the roll, whatever the other one has.
    job["input"]["plies"][1]["tracks"].as_array_mut().unwrap().remove(0);
    let outcome = planned(&job);
    let errors: Vec<&Finding> = outcome.findings.iter().filter(|finding| finding.is_error()).collect();
    assert_eq!(
        (errors.len(), errors[0].code, &*errors[0].at),
        (1, Code::NoCourseOnPly, "/input/plies/1/tracks")
    );
    assert!(errors[0].message.starts_with("no course touches ply 2 (\"P13\"):"), "{}", errors[0]);
}

/// A ply of a cylinder about the y axis, radius 1000, outside, one course along the hoop.
fn on_a_cylinder() -> Value {
    let place = |arc: f64, y: f64| {
        let (sin, cos) = (arc / 1000.0).sin_cos();
        [1000.0 * sin, y, 1000.0 * cos]
    };
    let side = |from: [f64; 2], to: [f64; 2]| {
        (0..60).map(move |i| {
            let t = f64::from(i) / 60.0;
            place(from[0] + t * (to[0] - from[0]), from[1] + t * (to[1] - from[1]))
        })
    };
    let corners = [[0.0, -37.5], [50.0, 37.5], [400.0, 37.5], [430.0, -37.5]];
    let boundary: Vec<_> = (0..4).flat_map(|i| side(corners[i], corners[(i + 1) % 4])).collect();
    let track: Vec<Value> = (0..=90)
        .map(|i| {
            let arc = f64::from(i) * 5.0;
            let (sin, cos) = (arc / 1000.0).sin_cos();
            json!({"position": place(arc, 0.0), "normal": [sin, 0.0, cos]})
        })
        .collect();
    json!({"boundary": {"points": boundary}, "tracks": [{"number": 1, "points": track}]})
}

#[test]
fn plies_of_two_moulds_lie_on_one_roll() {
    let mut job = in_a_list(&job("tests/golden/rising/job.json"));
    job["input"]["plies"].as_array_mut().unwrap().push(on_a_cylinder());
    let outcome = planned(&job);
    assert_eq!(outcome.verdict, Verdict::Usable, "{:?}", outcome.findings);
    let length = |place: usize| outcome.report["manifest"][place]["length_mm"].as_f64().unwrap();
    assert!((length(0) - 375.0).abs() < 1e-6);
    // The arc, not its projection, which is 13 mm shorter.
    assert!((length(1) - 430.0).abs() < 0.01, "{}", length(1));
    assert_eq!(outcome.report["manifest"][1]["ply_name"], Value::Null);
}

#[test]
fn faults_and_findings_of_files_are_named_by_their_ply() {
    let mut job = in_a_list(&job("examples/first.job.json"));
    let first = job["input"]["plies"][0].clone();
    job["input"]["plies"] = json!([
        first,
        {"boundary": {"file": "b.txt"}, "tracks": {"file": "t.txt"}},
        {"boundary": {"file": "b.txt"}, "courses": {"angle_deg": 0, "gap_mm": 10}},
        {"boundary": {"points": first["boundary"]["points"]}, "holes": [{"file": "h.txt"}], "tracks": first["tracks"]}
    ]);
    let document = document::read(job.to_string().as_bytes()).unwrap();
    let named: Vec<(&str, &str)> =
        document.named_files.iter().map(|file| (file.at.as_str(), file.name.as_str())).collect();
    let expected = [
        ("/input/plies/1/boundary/file", "b.txt"),
        ("/input/plies/1/tracks/file", "t.txt"),
        ("/input/plies/2/boundary/file", "b.txt"),
        ("/input/plies/3/holes/0/file", "h.txt"),
    ];
    assert_eq!(named, expected);
    let boundary = b"# closed, with two cut-outs\n0 0 0\n0 150 0\n400 150 0\n400 0 0\n0 0 0\nloop\n100 20 0\n120 40 0\n100 60 0\nloop\n300 20 0\n320 40 0\n300 60 0\n";
    let tracks = b"track 1\n0 37.5 0 0 0 1\n400 37.5 0 0 0 1\ntrack 2\n0 112.5 0 0 0 2\n400 112.5 0 0 0 1\n";
    let hole = b"140 -10 0\n120 10 0\n100 -10 0\n";
    let sent: [(&str, &[u8]); 3] = [("b.txt", boundary), ("t.txt", tracks), ("h.txt", hole)];
    let outcome = attempt(&job, &sent).unwrap();
    assert_eq!(outcome.verdict, Verdict::Usable, "{:?}", outcome.findings);
    let found: Vec<(Code, &str)> =
        outcome.findings.iter().map(|finding| (finding.code, finding.at.as_str())).collect();
    let expected = [
        (Code::NormalScaled, "t.txt:4"),
        (Code::ClosedOutline, "b.txt:6"),
        (Code::ClosedOutline, "b.txt:6"),
        (Code::PlyNotCovered, "/input/plies/2/courses"),
    ];
    assert_eq!(found, expected);
    let pieces = |ply: u64| {
        labels(&outcome.report["manifest"], "course").into_iter().filter(|label| label.0 == ply).count()
    };
    assert_eq!([1, 2, 3, 4].map(pieces), [1, 2, 2, 1]);

    let broken: [(&str, &[u8]); 3] =
        [("b.txt", boundary), ("t.txt", b"track 1\nx\n"), ("h.txt", b"500 0 0\n510 9 0\n520 0 0\n")];
    let faults = attempt(&job, &broken).unwrap_err();
    let found: Vec<(Code, &str)> = faults.iter().map(|fault| (fault.code, fault.at.as_str())).collect();
    assert_eq!(found, [(Code::WrongType, "t.txt:2"), (Code::HoleOutside, "h.txt:1")]);
}

#[test]
fn every_two_random_plies_on_one_roll_pass_their_replay() {
    let mut runner = runner(40);
    let words =
        (prop::sample::select(vec!["by_slope", "free"]), prop::sample::select(vec!["reject", "simplify"]));
    let rolls = (plies(), plies(), words, any::<bool>());
    let usable = std::cell::Cell::new(0);
    let result = runner.run(&rolls, |(one, other, (allocation, on_excess), share_cuts)| {
        let options = json!({"allocation": allocation, "on_excess": on_excess, "share_cuts": share_cuts});
        let outcome = planned(&with_options(one.job_with(&other), options.clone()));
        let errors: Vec<&Finding> = outcome.findings.iter().filter(|finding| finding.is_error()).collect();
        prop_assert!(errors.iter().all(|finding| finding.code == Code::TooManyKnives), "{:?}", errors);
        prop_assert!(errors.iter().all(|finding| finding.at.starts_with("/input/plies/")), "{:?}", errors);
        prop_assert_eq!(errors.is_empty(), outcome.verdict == Verdict::Usable);
        if outcome.verdict == Verdict::NotUsable {
            return Ok(());
        }
        usable.set(usable.get() + 1);
        let replay = &outcome.report["replay"];
        prop_assert!(replay["max_deviation_mm"].as_f64().unwrap() <= 0.011, "{}", replay);
        prop_assert!(replay["uncut_mm"].as_f64().unwrap() <= 0.02, "{}", replay);
        prop_assert!(replay["unwanted_mm"].as_f64().unwrap() <= 0.02, "{}", replay);
        if allocation == "free" {
            // Nothing is lost where one ply ends and the next begins.
            let job = one.job_with(&other);
            let alone = |ply: usize| {
                let mut job = job.clone();
                let list = job["input"]["plies"].as_array_mut().unwrap();
                *list = vec![list[ply].clone()];
                tape_mm(&planned(&with_options(job, options.clone())))
            };
            // Every step up to a printed digit may add as much.
            let steps = PLACE_MM * outcome.report["manifest"].as_array().unwrap().len() as f64;
            prop_assert!(tape_mm(&outcome) <= alone(0) + alone(1) + steps);
        }
        Ok(())
    });
    result.unwrap();
    assert!(usable.get() >= 5, "only {} of the rolls can be cut", usable.get());
}

#[test]
fn a_program_of_two_plies_is_checked_against_its_job() {
    let (job, outcome) = (job(EXAMPLE), planned(&job(EXAMPLE)));
    let against = |job: &Value| {
        let document = document::from_value(job.clone()).unwrap();
        let files = Files::default();
        check(&document, &files, &Catalogue::built_in(), &outcome.programs, &Budget::unwatched()).unwrap().1
    };
    assert_eq!(against(&job), []);
    // The same plies laid the other way round are another roll.
    let mut swapped = job;
    swapped["input"]["plies"].as_array_mut().unwrap().reverse();
    let found = against(&swapped);
    assert!(found.iter().any(|finding| finding.code == Code::Uncut), "{found:?}");
    for cut in ["course 1 of ply 1: r", "course 3 of ply 2: a cut"] {
        assert!(found.iter().any(|finding| finding.message.starts_with(cut)), "{cut}: {found:?}");
    }
}
