//! What a person should look at before a ply is cut: each with its code, its words and its marks.

use bladeplan::planning::attempt::check;
use bladeplan::planning::budget::Budget;
use bladeplan::planning::document;
use bladeplan::planning::document::files::Files;
use bladeplan::planning::finding::{Finding, Severity};
use bladeplan::planning::outcome::{Outcome, ProgramFile, Verdict};
use bladeplan::planning::tape::machine::Catalogue;
use serde_json::{Value, json};

use crate::linuxcnc::plan;

fn planned(job: &Value) -> Outcome {
    let document = document::from_value(job.clone()).unwrap();
    plan(&document, &Files::default(), &Catalogue::built_in(), &Budget::unwatched()).unwrap()
}

/// A flat ply of tapes 75 mm wide that run along x at these y.
fn ply(boundary: &[[f64; 2]], tracks: &[f64]) -> Value {
    let points: Vec<_> = boundary.iter().map(|[x, y]| json!([x, y, 0])).collect();
    let track = |(index, y): (usize, &f64)| {
        let point = |x: f64| json!({"position": [x, y, 0], "normal": [0, 0, 1]});
        json!({"number": index + 1, "points": [point(0.0), point(400.0)]})
    };
    json!({"kind": "tape-cut", "input": {
        "tape": {"width_mm": 75, "thickness_mm": 0.125}, "boundary": {"points": points},
        "tracks": tracks.iter().enumerate().map(track).collect::<Vec<_>>(), "machine": "two-cutter-lab"}})
}

fn of_code<'a>(outcome: &'a Outcome, code: &str) -> Vec<&'a Finding> {
    outcome.findings.iter().filter(|finding| finding.code.as_str() == code).collect()
}

fn attachment<'a>(outcome: &'a Outcome, name: &str) -> &'a str {
    &outcome.attachments.iter().find(|attachment| attachment.name == name).unwrap().text
}

#[test]
fn courses_that_overlap_hide_nothing_of_what_they_leave_bare() {
    let square = [[0.0, 0.0], [400.0, 0.0], [400.0, 150.0], [0.0, 150.0]];
    let said = |courses: &[f64]| {
        let outcome = planned(&ply(&square, courses));
        assert_eq!(outcome.verdict, Verdict::Usable, "{:?}", outcome.findings);
        let found = ["ply_not_covered", "courses_overlap"].map(|code| of_code(&outcome, code));
        found.into_iter().flatten().map(|finding| finding.message.clone()).collect::<Vec<_>>()
    };
    let found = said(&[37.5, 90.0]);
    assert_eq!(found.len(), 2, "{found:?}");
    // 22.5 of 150 mm lie bare, and 22.5 mm lie double.
    assert!(found[0].starts_with("the courses cover 85.0 % of the ply;"), "{found:?}");
    assert!(found[1].starts_with("the courses lay 15.0 % of the ply double;"), "{found:?}");
    assert_eq!(said(&[37.5, 112.5]), Vec::<String>::new());
    // Whoever asks for an overlap is not told of it.
    let mut job = ply(&square, &[]);
    job["input"].as_object_mut().unwrap().remove("tracks");
    job["input"]["courses"] = json!({"angle_deg": 0, "gap_mm": -5});
    assert!(of_code(&planned(&job), "courses_overlap").is_empty());
    assert!(said(&[30.0, 100.0])[0].starts_with("the courses cover 91.7 %"), "{:?}", said(&[30.0, 100.0]));
}

/// Two courses: the first is 400 mm long, of the second the ply has 2 mm over all its length and a stub of 30 mm.
fn ledge() -> Value {
    let boundary = [[0.0, -37.5], [0.0, 39.5], [370.0, 39.5], [370.0, 112.5], [400.0, 112.5], [400.0, -37.5]];
    ply(&boundary, &[0.0, 75.0])
}

#[test]
fn a_sliver_is_said_with_its_course_and_piece_and_marked_in_the_manifest() {
    let mut job = ledge();
    job["input"]["boundary"]["points"] =
        json!([[0, -37.5, 0], [0, 39.5, 0], [400, 39.5, 0], [400, -37.5, 0]]);
    let outcome = planned(&job);
    assert_eq!(outcome.verdict, Verdict::Usable, "{:?}", outcome.findings);
    let [sliver] = of_code(&outcome, "sliver")[..] else { panic!("{:?}", outcome.findings) };
    assert_eq!((sliver.severity, sliver.at.as_str()), (Severity::Warning, "/input/tracks/1"));
    let said = "course 2: nowhere 3.175 mm wide: piece 1 (400.0 mm long, 800.0 mm2)";
    assert!(sliver.message.starts_with(said), "{}", sliver.message);
    let manifest = outcome.report["manifest"].as_array().unwrap();
    let marked: Vec<_> =
        manifest.iter().map(|entry| (entry["course"].as_u64(), entry.get("sliver"))).collect();
    assert_eq!(marked, [(Some(1), None), (Some(2), Some(&json!(true)))]);
    assert!(attachment(&outcome, "setup.md").contains("| sliver |"));
    // The same edge 3.3 mm into the second tape is no sliver.
    for point in [1, 2] {
        job["input"]["boundary"]["points"][point][1] = json!(40.8);
    }
    assert_eq!(of_code(&planned(&job), "sliver"), [] as [&Finding; 0]);
}

#[test]
fn a_piece_shorter_than_the_laying_head_lays_is_said_where_the_head_has_such_a_length() {
    let mut job = ply(
        &[[0.0, -37.5], [0.0, 37.5], [370.0, 37.5], [370.0, 112.5], [400.0, 112.5], [400.0, -37.5]],
        &[0.0, 75.0],
    );
    assert_eq!(
        of_code(&planned(&job), "piece_too_short"),
        [] as [&Finding; 0],
        "no limit without the option"
    );
    job["input"]["options"] = json!({"shortest_piece_mm": 30});
    assert_eq!(of_code(&planned(&job), "piece_too_short"), [] as [&Finding; 0], "as long as the limit");
    job["input"]["options"] = json!({"shortest_piece_mm": 100});
    let outcome = planned(&job);
    assert_eq!(outcome.verdict, Verdict::Usable, "{:?}", outcome.findings);
    let [short] = of_code(&outcome, "piece_too_short")[..] else { panic!("{:?}", outcome.findings) };
    assert_eq!((short.severity, short.at.as_str()), (Severity::Warning, "/input/tracks/1"));
    let said =
        "course 2: shorter than the 100 mm that the laying head lays: piece 1 (30.0 mm long, 2250.0 mm2)";
    assert!(short.message.starts_with(said), "{}", short.message);
    let manifest = outcome.report["manifest"].as_array().unwrap();
    assert_eq!((manifest[0].get("too_short"), &manifest[1]["too_short"]), (None, &json!(true)));
    assert!(attachment(&outcome, "setup.md").contains("| too short |"));
    // With a ledge 2 mm wide along the rest of the course the piece is long, and neither.
    let mut job = ledge();
    job["input"]["options"] = json!({"shortest_piece_mm": 100});
    let outcome = planned(&job);
    assert!(of_code(&outcome, "piece_too_short").is_empty() && of_code(&outcome, "sliver").is_empty());
}

#[test]
fn of_many_slivers_of_a_course_the_first_are_named_and_the_others_counted() {
    // A comb: nine teeth of 2 mm in the tape.
    let mut boundary = vec![[0.0, -37.5], [0.0, -30.0]];
    for tooth in 1..=9 {
        let x = 40.0 * f64::from(tooth);
        boundary.extend([[x, -30.0], [x, 30.0], [x + 2.0, 30.0], [x + 2.0, -30.0]]);
    }
    boundary.extend([[400.0, -30.0], [400.0, -37.5]]);
    let outcome = planned(&ply(&boundary, &[10.0]));
    let slivers = of_code(&outcome, "sliver");
    assert_eq!(slivers.len(), 1, "{:?}", outcome.findings);
    assert!(slivers[0].message.contains("piece 5 (2.0 mm long") && slivers[0].message.contains("and 4 more"));
    assert!(!slivers[0].message.contains("piece 6"));
}

/// A ply 400 mm long over four courses, clockwise seen from above, as its normals point.
fn four_courses() -> Value {
    ply(&[[0.0, -37.5], [0.0, 262.5], [400.0, 262.5], [400.0, -37.5]], &[0.0, 75.0, 150.0, 225.0])
}

fn turn_normals(job: &mut Value, tracks: &[usize]) {
    for &track in tracks {
        for point in job["input"]["tracks"][track]["points"].as_array_mut().unwrap() {
            point["normal"] = json!([0, 0, -1]);
        }
    }
}

fn scale_outline(job: &mut Value, factor: f64) {
    let points = job["input"]["boundary"]["points"].as_array_mut().unwrap();
    for x in points.iter_mut().flat_map(|point| point.as_array_mut().unwrap()) {
        *x = json!(x.as_f64().unwrap() * factor);
    }
}

#[test]
fn an_outline_in_another_unit_than_its_courses_is_said_and_so_is_a_ply_smaller_than_its_tape_is_wide() {
    assert_eq!(planned(&four_courses()).findings, [], "all in mm");
    // In metres, and in inches.
    for factor in [0.001, 1.0 / 25.4] {
        let mut job = four_courses();
        scale_outline(&mut job, factor);
        let outcome = planned(&job);
        let [sizes] = of_code(&outcome, "unlike_sizes")[..] else { panic!("{:?}", outcome.findings) };
        assert_eq!((sizes.severity, sizes.at.as_str()), (Severity::Warning, "/input/boundary/points"));
        assert!(sizes.message.contains("mm across and its courses 4"), "{}", sizes.message);
        // Generated courses have the size of the ply: what is left to compare with is the tape.
        let input = job["input"].as_object_mut().unwrap();
        input.remove("tracks");
        input.insert("courses".to_owned(), json!({"angle_deg": 0}));
        let outcome = planned(&job);
        let small = of_code(&outcome, "unlike_sizes");
        assert_eq!(small.len(), 1, "{:?}", outcome.findings);
        assert!(small.iter().all(|small| small.message.contains("the tape is 75 mm wide")));
    }
    let mut job = four_courses();
    scale_outline(&mut job, 10.0);
    assert!(of_code(&planned(&job), "unlike_sizes").is_empty(), "a few courses of a large ply");
}

#[test]
fn one_course_with_normals_against_its_neighbours_is_an_error_and_at_the_rim_a_warning() {
    let mut job = four_courses();
    turn_normals(&mut job, &[1]);
    let document = document::from_value(job).unwrap();
    let faults =
        plan(&document, &Files::default(), &Catalogue::built_in(), &Budget::unwatched()).unwrap_err();
    let found: Vec<_> = faults.iter().map(|fault| (fault.code.as_str(), fault.at.as_str())).collect();
    assert_eq!(found, [("normals_opposed".to_owned(), "/input/tracks/1/points")]);
    assert!(
        faults[0].message.contains("course 2") && faults[0].message.contains("(1, 3)"),
        "{}",
        faults[0].message
    );

    let mut job = four_courses();
    job["input"]["tracks"][2]["points"][1]["normal"] = json!([0, 0, -1]);
    let document = document::from_value(job).unwrap();
    let faults =
        plan(&document, &Files::default(), &Catalogue::built_in(), &Budget::unwatched()).unwrap_err();
    assert_eq!(faults[0].at, "/input/tracks/2/points");
    assert!(faults[0].message.contains("point 1 of course 3"), "{}", faults[0].message);

    for (turned, at) in [(vec![3], 3), (vec![0], 0), (vec![2, 3], 1)] {
        let mut job = four_courses();
        turn_normals(&mut job, &turned);
        let outcome = planned(&job);
        let [opposed] = of_code(&outcome, "normals_opposed")[..] else { panic!("{:?}", outcome.findings) };
        let place = format!("/input/tracks/{at}/points");
        assert_eq!((opposed.severity, opposed.at.as_str()), (Severity::Warning, place.as_str()));
    }
}

#[test]
fn normals_against_the_outline_are_a_warning_and_say_that_pieces_may_be_mirrored() {
    let mut job = four_courses();
    turn_normals(&mut job, &[0, 1, 2, 3]);
    let outcome = planned(&job);
    assert_eq!(outcome.verdict, Verdict::Usable, "{:?}", outcome.findings);
    let [sense] = &outcome.findings[..] else { panic!("{:?}", outcome.findings) };
    assert_eq!((sense.code.as_str().as_str(), sense.severity), ("outline_sense", Severity::Warning));
    assert!(
        sense.message.contains("mirrored") && sense.message.contains("(0.00, 0.00, -1.00)"),
        "{}",
        sense.message
    );
    // The normals of generated courses are right, so there is nothing to be told.
    let mut job = four_courses();
    job["input"]["boundary"]["points"].as_array_mut().unwrap().reverse();
    let input = job["input"].as_object_mut().unwrap();
    input.remove("tracks");
    input.insert("courses".to_owned(), json!({"angle_deg": 0}));
    let outcome = planned(&job);
    let [sense] = &outcome.findings[..] else { panic!("{:?}", outcome.findings) };
    assert_eq!((sense.code.as_str().as_str(), sense.severity), ("outline_sense", Severity::Info));
}

/// A male and a female mould of 800 mm radius, half around: normals diverge, converge, and turn by 180 degrees in all.
#[test]
fn normals_of_a_round_mould_are_opposed_to_none() {
    for side in [1.0, -1.0] {
        let at = |angle: f64, x: f64| {
            let (sin, cos) = angle.sin_cos();
            (json!([x, 800.0 * sin, 800.0 * cos]), json!([0.0, side * sin, side * cos]))
        };
        let steps: Vec<f64> = (0..=40).map(|i| 3.0 * f64::from(i) / 40.0 - 1.5).collect();
        let mut boundary: Vec<Value> = steps.iter().map(|angle| at(*angle, 0.0).0).collect();
        boundary.extend(steps.iter().rev().map(|angle| at(*angle, 400.0).0));
        if side < 0.0 {
            boundary.reverse();
        }
        let pitch = 75.0 / 800.0;
        let track = |(index, x): (usize, f64)| {
            let point = |x: f64| {
                let (position, normal) = at(-1.46 + pitch * index as f64, x);
                json!({"position": position, "normal": normal})
            };
            json!({"number": index + 1, "points": [point(x), point(x + 200.0), point(x + 400.0)]})
        };
        let tracks: Vec<_> = std::iter::repeat_n(0.0, 32).enumerate().map(track).collect();
        let mut job = four_courses();
        job["input"]["boundary"]["points"] = json!(boundary);
        job["input"]["tracks"] = json!(tracks);
        let outcome = planned(&job);
        assert_eq!(of_code(&outcome, "normals_opposed"), [] as [&Finding; 0]);
        // One of them turned over is found here too.
        for point in job["input"]["tracks"][5]["points"].as_array_mut().unwrap() {
            for x in point["normal"].as_array_mut().unwrap() {
                *x = json!(-x.as_f64().unwrap());
            }
        }
        let document = document::from_value(job).unwrap();
        let faults =
            plan(&document, &Files::default(), &Catalogue::built_in(), &Budget::unwatched()).unwrap_err();
        assert_eq!(faults[0].at, "/input/tracks/5/points");
    }
}

#[test]
fn a_zone_behind_the_roll_or_off_the_tape_is_said_and_the_sheet_lists_all() {
    let mut job = four_courses();
    let used = planned(&job).report["roll"]["tape_used_mm"].as_f64().unwrap();
    assert_eq!(used, 1600.0);
    job["input"]["tape"]["zones_mm"] = json!([[5000, 5020], [100, 120]]);
    let outcome = planned(&job);
    let [behind] = &outcome.findings[..] else { panic!("{:?}", outcome.findings) };
    assert_eq!((behind.code.as_str().as_str(), behind.severity), ("zone_unused", Severity::Info));
    assert_eq!(behind.at, "/input/tape/zones_mm");
    assert!(behind.message.contains("5000 to 5020 mm") && !behind.message.contains("100 to 120"), "{behind}");
    assert!(attachment(&outcome, "setup.md").contains("| 100.0 to 120.0 mm, 5000.0 to 5020.0 mm |"));
    job["input"]["tape"]["length_mm"] = json!(4000);
    let outcome = planned(&job);
    let [off] = &outcome.findings[..] else { panic!("{:?}", outcome.findings) };
    assert_eq!((off.code.as_str().as_str(), off.severity), ("zone_unused", Severity::Warning));
    assert!(off.message.contains("4000 mm long") && off.message.contains("5000 to 5020 mm"), "{off}");
}

/// An end that needs more than two knives.
const ZIGZAG: [[f64; 2]; 7] =
    [[0.0, -37.5], [0.0, 37.5], [400.0, 37.5], [300.0, 20.0], [390.0, 0.0], [310.0, -20.0], [380.0, -37.5]];

/// Whatever comes of a program that is checked, no place is named at which there is nothing.
#[test]
fn what_is_found_while_a_program_is_checked_is_said_at_its_place_in_the_document() {
    let mut job = ply(&ZIGZAG, &[]);
    let input = job["input"].as_object_mut().unwrap();
    input.remove("tracks");
    input.insert("courses".to_owned(), json!({"angle_deg": 0}));
    let document = document::from_value(job).unwrap();
    let program = ProgramFile { name: "roll.ngc".to_owned(), dialect: "linuxcnc", text: "M2\n".to_owned() };
    let (words, findings) =
        check(&document, &Files::default(), &Catalogue::built_in(), &[program], &Budget::unwatched())
            .unwrap();
    assert_eq!(words, "the job has no plan");
    let found: Vec<_> = findings.iter().map(|finding| (finding.code.as_str(), finding.at.as_str())).collect();
    assert_eq!(found, [("too_many_knives".to_owned(), "/input/courses")]);
}

#[test]
fn what_is_left_to_be_trimmed_stands_on_the_set_up_sheet() {
    let mut job = ply(&ZIGZAG, &[0.0]);
    job["input"]["options"] = json!({"on_excess": "simplify"});
    let outcome = planned(&job);
    let simplified = &outcome.report["simplified"][0];
    let (deviation, area) =
        (simplified["max_deviation_mm"].as_f64().unwrap(), simplified["extra_area_mm2"].as_f64().unwrap());
    assert!(deviation > 1.0, "{simplified}");
    let sheet = attachment(&outcome, "setup.md");
    assert!(sheet.contains("## Warnings") && sheet.contains("it was changed on the scrap side"), "{sheet}");
    let row = sheet.split("To be trimmed by hand").nth(1).unwrap().lines().last().unwrap();
    let cells: Vec<&str> = row.split('|').map(str::trim).collect();
    assert_eq!(cells[1..3], ["1", "1"]);
    assert!((cells[3].parse::<f64>().unwrap() - deviation).abs() < 1e-3, "{row}");
    assert!((cells[4].parse::<f64>().unwrap() - area).abs() < 0.1, "{row}");
    assert!(!attachment(&planned(&four_courses()), "setup.md").contains("trimmed"));
}

/// A ">" of 90 degrees; the tape may stand off by 0.05 mm at both moments, so both cuts must go on by 0.1 / sqrt 2.
#[test]
fn an_overcut_too_short_for_the_errors_of_the_profile_is_said() {
    let mut job = ply(&[[0.0, -37.5], [0.0, 37.5], [362.5, 37.5], [400.0, 0.0], [362.5, -37.5]], &[0.0]);
    let with = |error: f64, overcut: [f64; 2]| {
        let mut machine = serde_json::to_value(Catalogue::built_in().get("two-cutter-lab").unwrap()).unwrap();
        machine["feed"]["error_mm"] = json!(error);
        for cutter in [0, 1] {
            machine["cutters"][cutter]["blade"]["overcut_mm"] = json!(overcut[cutter]);
        }
        machine
    };
    let mut said = |error: f64, overcut: [f64; 2]| {
        job["input"]["machine"] = with(error, overcut);
        let outcome = planned(&job);
        assert_eq!(outcome.verdict, Verdict::Usable, "{:?}", outcome.findings);
        of_code(&outcome, "overcut_too_short").into_iter().cloned().collect::<Vec<_>>()
    };
    assert_eq!(said(0.0, [0.0, 0.0]), [], "no error is given");
    assert_eq!(said(0.05, [0.08, 0.08]), []);
    let [short] = &said(0.05, [0.08, 0.05])[..] else { panic!("the shorter one of both decides") };
    assert_eq!((short.severity, short.at.as_str()), (Severity::Warning, "/input/machine"));
    assert!(
        short.message.contains("at 1 tips") && short.message.contains("by 0.071 mm, and overcut_mm is 0.05"),
        "{short}"
    );
}
