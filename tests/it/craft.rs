//! Knife craft: overcut, a program from a course on, dry run, the cycle time by what was read.

use bladeplan::planning::attempt::check;
use bladeplan::planning::budget::Budget;
use bladeplan::planning::document;
use bladeplan::planning::document::files::Files;
use bladeplan::planning::finding::{Code, Finding};
use bladeplan::planning::outcome::{Outcome, ProgramFile, Verdict};
use bladeplan::planning::program::events::{Event, Executed};
use bladeplan::planning::program::nc::read::read;
use bladeplan::planning::tape::machine::Catalogue;
use bladeplan::planning::tape::trace::text;
use proptest::prelude::*;
use serde_json::{Value, json};

use crate::profiles::{job, lab, lab_with, plan_job};
use crate::random_plies::{Ply, plies};
use crate::rounds::runner;

const EXAMPLE: &str = "examples/wing-skin-trapezoid-45.job.json";

/// The lab, both of whose knives overcut.
pub fn overcutting(mm: f64) -> Value {
    lab_with(&[("/cutters/0/blade/overcut_mm", json!(mm)), ("/cutters/1/blade/overcut_mm", json!(mm))])
}

fn planned(path: &str, machine: &Value, options: Value) -> Outcome {
    plan_job(&job(path), machine, &options).unwrap()
}

fn errors(findings: &[Finding]) -> Vec<&Finding> {
    findings.iter().filter(|finding| finding.is_error()).collect()
}

/// Checks a text against a job.
fn checked(job: &Value, name: &str, text: String) -> Vec<Finding> {
    let document = document::from_value(job.clone()).unwrap();
    let file = ProgramFile { name: name.to_owned(), dialect: "linuxcnc", text };
    check(&document, &Files::default(), &Catalogue::built_in(), &[file], &Budget::unwatched()).unwrap().1
}

#[test]
fn a_tip_is_overcut_to_where_it_was_worked_out() {
    let outcome = planned("examples/first.job.json", &overcutting(2.0), json!(null));
    assert_eq!(outcome.verdict, Verdict::Usable, "{:?}", outcome.findings);
    let trace = &outcome.attachments[0].text;
    // 2 mm at 45 degrees are 1.4142 mm along either axis: beyond the tip, and beyond the tape's edge.
    for line in [
        "DOWN 1 1 401.4142 -1.4142\nCUT 361.0858 38.9142 ",
        "DOWN 1 2 401.4142 1.4142\nCUT 361.0858 -38.9142 ",
    ] {
        assert!(trace.contains(line), "{line}\n{trace}");
    }
    // The square start of the piece goes on beyond both edges of the tape.
    let trace = text::read(trace).unwrap();
    let square = trace.courses[0].strokes.iter().find(|stroke| stroke.down[0] == 0.0).unwrap();
    assert_eq!(square.down[1].abs().max(square.cuts[0].to[1].abs()), 39.5);
    let figures = &outcome.report["replay"];
    assert!((figures["overcut_mm"].as_f64().unwrap() - 12.0).abs() < 0.2, "{figures}");
    assert_eq!((figures["uncut_mm"].as_f64(), figures["unwanted_mm"].as_f64()), (Some(0.0), Some(0.0)));
    assert!(outcome.findings.iter().all(|finding| finding.code != Code::OvercutShortened));
    // The same program on a machine whose knives do not overcut is one that cuts what nobody wants.
    let mut plain = job("examples/first.job.json");
    plain["input"]["machine"] = lab();
    let found = checked(&plain, "roll.ngc", outcome.programs[0].text.clone());
    assert!(found.iter().any(|finding| finding.code == Code::Unwanted), "{found:?}");
}

/// A notch whose legs would go on into the piece, and a round cut-out whose every tangent does: said, and not cut.
#[test]
fn no_overcut_enters_a_piece() {
    let notched = json!({"kind": "tape-cut", "name": "n", "input": {
        "tape": {"width_mm": 75, "thickness_mm": 0.125},
        "boundary": {"points": [[0,-37.5,0],[30,0,0],[0,37.5,0],[400,37.5,0],[400,-37.5,0]]},
        "tracks": [{"number": 1, "points": [{"position":[0,0,0],"normal":[0,0,1]},{"position":[400,0,0],"normal":[0,0,1]}]}]}});
    let outcome = plan_job(&notched, &overcutting(3.0), &json!(null)).unwrap();
    assert_eq!(outcome.verdict, Verdict::Usable, "{:?}", outcome.findings);
    let said = outcome.findings.iter().find(|finding| finding.code == Code::OvercutShortened).unwrap();
    assert!(said.message.starts_with("2 of 6 ends") && said.message.contains("by 3.000 mm"), "{said}");
}

#[test]
fn every_ply_passes_its_replay_with_an_overcut() {
    let passes = |(ply, mm): (Ply, f64)| {
        let outcome = ply.plan_on(&overcutting(mm));
        let errors = errors(&outcome.findings);
        prop_assert!(errors.iter().all(|finding| finding.code == Code::TooManyKnives), "{:?}", errors);
        if errors.is_empty() {
            let replay = &outcome.report["replay"];
            prop_assert!(replay["overcut_mm"].as_f64().unwrap() > 0.0, "{}", replay);
            prop_assert!(replay["uncut_mm"].as_f64().unwrap() <= 0.02, "{}", replay);
        }
        Ok(())
    };
    runner(60).run(&(plies(), 0.5..5.0_f64), passes).unwrap();
}

#[test]
fn the_cycle_time_is_that_of_the_text() {
    let same = |ply: Ply| {
        let outcome = ply.plan();
        if let (Some(time), Some(read)) =
            (outcome.report["time_s"].as_f64(), outcome.report["replay"]["time_s"].as_f64())
        {
            // F is rounded down to four decimals, and a move of a second has an F of 60.
            prop_assert!(read >= time - 1e-6 && read < time * 1.001, "{} {}", read, time);
        }
        Ok(())
    };
    runner(40).run(&plies(), same).unwrap();
    let fast = planned(EXAMPLE, &lab(), json!(null)).report["time_s"].as_f64().unwrap();
    let slow = lab_with(&[("/feed/max_acceleration_mm_s2", json!(50))]);
    assert!(planned(EXAMPLE, &slow, json!(null)).report["time_s"].as_f64().unwrap() > fast + 1.0);
}

/// The square start of the piece, 79 mm with its overcuts, of which 1 mm in the middle is cut again.
#[test]
fn a_cut_made_twice_is_found_beside_overcuts_too() {
    let mut with = job("examples/first.job.json");
    for (overcut, again) in [(0.0, 1.0), (2.0, 1.0), (5.0, 1.0)] {
        with["input"]["machine"] = overcutting(overcut);
        let text =
            planned("examples/first.job.json", &overcutting(overcut), json!(null)).programs.remove(0).text;
        assert!(checked(&with, "roll.ngc", text.clone()).is_empty());
        let lines: Vec<&str> = text.lines().collect();
        // Cutter 1 makes the square cut last, at one reading of U: a move of V alone with its knife down.
        let across = lines.iter().rposition(|line| line.contains("G1 V") && !line.contains('A')).unwrap();
        assert!(lines[across + 1].ends_with("M65 P0") && lines[across + 2].contains("G4"));
        let more = format!(
            "N1 G1 V0.0 F60.0\nN2 M64 P0\nN3 G4 P0.05\nN4 G1 V{again} F300.0\nN5 M65 P0\nN6 G4 P0.05"
        );
        let mut lines = lines;
        lines.insert(across + 3, &more);
        let found = checked(&with, "roll.ngc", lines.join("\n") + "\n");
        let twice: Vec<_> =
            found.iter().filter(|finding| finding.message.contains("more often than it is wanted")).collect();
        assert!(!twice.is_empty() && twice[0].code == Code::Unwanted, "{overcut}: {found:?}");
    }
}

fn events(outcome: &Outcome) -> Vec<Executed> {
    read("p", &outcome.programs[0].text).unwrap()
}

#[test]
fn a_program_from_a_course_on_makes_what_is_left_and_nothing_twice() {
    let whole = planned(EXAMPLE, &lab(), json!(null));
    let trace = text::read(&whole.attachments[0].text).unwrap();
    let (mut usable, mut refused) = (0, 0);
    for course in trace.courses.iter().step_by(4) {
        let outcome = planned(EXAMPLE, &lab(), json!({"from_course": course.number}));
        if outcome.verdict == Verdict::NotUsable {
            refused += 1;
            let found = errors(&outcome.findings);
            assert!(found.len() == 1 && found[0].code == Code::KnifeState, "{found:?}");
            assert!(
                found[0].at == "/input/options/from_course" && found[0].message.contains("can go on from")
            );
            continue;
        }
        usable += 1;
        let program = &outcome.programs[0];
        assert_eq!(program.name, format!("roll-from-course-{}.ngc", course.number));
        assert_eq!(outcome.report["from_course"], course.number);
        assert_ne!(outcome.report["input_sha256"], whole.report["input_sha256"]);
        // The rest is that of the whole program, word for word.
        let lines = |text: &str| -> Vec<String> {
            text.lines().rev().map(|line| line.split_once(' ').unwrap().1.to_owned()).collect()
        };
        let (rest, all) = (lines(&program.text), lines(&whole.programs[0].text));
        let same = rest.iter().zip(&all).take_while(|(one, other)| one == other).count();
        assert!(same + 8 >= rest.len(), "course {}: {same} of {}", course.number, rest.len());
        let (time, read) = (&outcome.report["time_s"], outcome.report["replay"]["time_s"].as_f64().unwrap());
        assert!((time.as_f64().unwrap() - read).abs() < 1e-3 * read, "{time} {read}");
        // From the first course on it is the whole program.
        if outcome.report["approach_s"] != 0.0 {
            into_place(&outcome);
        }
    }
    assert!(usable >= 2, "{usable} usable, {refused} refused");
    let nowhere = planned(EXAMPLE, &lab(), json!({"from_course": 999}));
    assert_eq!(errors(&nowhere.findings)[0].code, Code::NoCourseOnPly);
}

/// Whoever stands at the machine with the tape in its place waits for seconds, not for the way from 0.
fn into_place(outcome: &Outcome) {
    let events = events(outcome);
    let first = |what: &dyn Fn(&Event) -> bool| events.iter().position(|found| what(&found.event)).unwrap();
    let down = first(&|event| matches!(event, Event::Output { on: true, number: 0 | 1 }));
    let mut moves = events[..down].iter().filter_map(|executed| match executed.event {
        Event::Move { from, to, cruise_s } => Some((from, to, cruise_s.unwrap())),
        _ => None,
    });
    let (from, to, tape_s) = moves.next().unwrap();
    // The tape by itself, at a fifth of its speed, whatever the way.
    assert!((0..9).all(|axis| axis == 6 || from[axis] == to[axis]) && to[6] > 0.0, "{to:?}");
    assert!((tape_s - to[6] / 100.0).abs() < 1e-6, "{tape_s}");
    let approach_s = outcome.report["approach_s"].as_f64().unwrap();
    assert!((approach_s - (to[6] / 100.0 + 100.0 / 1000.0)).abs() < 1e-6, "{approach_s}");
    let rest_s: f64 = moves.map(|(_, _, cruise_s)| cruise_s).sum();
    assert!((10.0..20.0).contains(&rest_s), "{rest_s}");
    let sheet = &outcome.attachments.iter().find(|text| text.name == "setup.md").unwrap().text;
    assert!(sheet.contains("with the tape in its place already; from 0 the tape runs"));
}

#[test]
fn a_program_that_goes_on_elsewhere_does_not_pass() {
    let whole = planned(EXAMPLE, &lab(), json!(null));
    let mut options = job(EXAMPLE);
    let numbers: Vec<u32> =
        text::read(&whole.attachments[0].text).unwrap().courses.iter().map(|c| c.number).collect();
    options["input"]["options"] = json!({"from_course": numbers[0]});
    // The last course of the roll alone is left in the program, and its text is the whole roll's.
    let found = checked(&options, "roll.ngc", whole.programs[0].text.clone());
    assert!(
        found.iter().any(|finding| finding.code == Code::Unwanted || finding.code == Code::DiffersFromPlan)
    );
}

#[test]
fn a_dry_run_moves_alike_and_switches_nothing_on() {
    let wet = planned(EXAMPLE, &lab(), json!(null));
    let dry = planned(EXAMPLE, &lab(), json!({"dry_run": true}));
    assert_eq!(dry.verdict, Verdict::Usable, "{:?}", dry.findings);
    assert_eq!((dry.programs[0].name.as_str(), &dry.report["dry_run"]), ("roll-dry-run.ngc", &json!(true)));
    assert!(wet.report.get("dry_run").is_none());
    assert_ne!(dry.report["programs"][0]["sha256"], wet.report["programs"][0]["sha256"]);
    assert_ne!(dry.report["input_sha256"], wet.report["input_sha256"]);
    assert!(!dry.programs[0].text.contains("M64") && dry.programs[0].text.contains("(DRY RUN"));
    let moves = |outcome| -> Vec<Event> {
        let others = |event: &Event| !matches!(event, Event::Output { .. });
        events(outcome).into_iter().map(|executed| executed.event).filter(others).collect()
    };
    assert_eq!(moves(&dry), moves(&wet));
    // A knife in it, a move left out, and the program that cuts: none of them is its dry run.
    let mut dry_job = job(EXAMPLE);
    dry_job["input"]["options"] = json!({"dry_run": true});
    let text = &dry.programs[0].text;
    let knife = text.replacen("G4 P0.05", "M64 P0", 1);
    let middle = text.lines().position(|line| line.contains("G1 U")).unwrap();
    let left_out: Vec<&str> =
        text.lines().enumerate().filter(|(at, _)| *at != middle).map(|(_, line)| line).collect();
    for (changed, code) in [
        (knife, Code::KnifeState),
        (left_out.join("\n") + "\n", Code::Deviation),
        (wet.programs[0].text.clone(), Code::KnifeState),
    ] {
        let found = checked(&dry_job, "roll-dry-run.ngc", changed);
        assert!(found.iter().any(|finding| finding.is_error() && finding.code == code), "{code:?} {found:?}");
    }
    // And the dry run is no program that cuts.
    let found = checked(&job(EXAMPLE), "roll.ngc", text.clone());
    assert!(found.iter().any(|finding| finding.code == Code::Uncut), "{found:?}");
}

#[test]
fn both_options_together_and_the_same_bytes_again() {
    let options = || json!({"dry_run": true, "from_course": 1});
    let (one, other) = (planned(EXAMPLE, &lab(), options()), planned(EXAMPLE, &lab(), options()));
    assert_eq!(one.programs[0].name, "roll-from-course-1-dry-run.ngc");
    assert_eq!(one.report, other.report);
    assert_eq!((one.programs, one.drawings), (other.programs, other.drawings));
    assert_eq!(one.attachments, other.attachments);
}

#[test]
fn stations_keep_carriages_apart() {
    let apart = lab_with(&[("/carriage_clearance_mm", json!(300))]);
    assert_eq!(planned("examples/first.job.json", &apart, json!(null)).verdict, Verdict::Usable);
}

/// An operator who zeroes the axes as for a whole roll would feed metres of a roll that is half cut.
#[test]
fn the_sheet_of_a_part_of_a_roll_and_of_a_dry_run_says_so_first() {
    let sheet = |options| {
        let outcome = planned(EXAMPLE, &lab(), options);
        outcome.attachments.iter().find(|text| text.name == "setup.md").unwrap().text.clone()
    };
    let whole = sheet(json!(null));
    assert!(!whole.contains("**") && whole.contains("## Zero positions at the start"));
    let part = sheet(json!({"from_course": 5}));
    assert!(
        part.contains("**GOES ON WITHIN A ROLL, from course 5.**") && part.contains("Do not zero the axes")
    );
    assert!(
        part.contains("| pieces cut by this program | 5 |") && part.contains("| first piece cut | course 5")
    );
    assert!(!part.contains("## Zero positions at the start"));
    // The cassette is listed as a whole; 5 of its pieces are cut here.
    let numbered =
        |line: &&str| line.split('|').nth(1).is_some_and(|cell| cell.trim().parse::<u32>().is_ok());
    let rows = || part.split("## Cassette").nth(1).unwrap().lines().filter(numbered);
    let before = rows().filter(|row| row.contains("cut before, not by this program")).count();
    assert_eq!(rows().count() - before, 5, "{part}");
    assert!(before > 0 && !whole.contains("cut before"));
    // Where the tape stands by the sheet the program does not run it back.
    for number in [5, 7, 20, 28] {
        let outcome = planned(EXAMPLE, &lab(), json!({"from_course": number}));
        let sheet = &outcome.attachments.iter().find(|text| text.name == "setup.md").unwrap().text;
        let said = sheet.split("U must read ").nth(1).unwrap().split(' ').next().unwrap();
        let said: f64 = said.parse().unwrap();
        let mut words = outcome.programs[0].text.split_whitespace();
        let first: f64 = words.find_map(|word| word.strip_prefix('U')?.parse().ok()).unwrap();
        assert!(said <= first && first - said < 0.0011, "{said} {first}");
    }
    // With knives given freely a piece that the other knife was to finish is finished here.
    let free = planned(EXAMPLE, &lab(), json!({"allocation": "free", "from_course": 15}));
    let freely = &free.attachments.iter().find(|text| text.name == "setup.md").unwrap().text;
    let of_16 = freely.lines().find(|line| line.contains("| 16 | 1 |")).unwrap();
    assert!(of_16.ends_with("| begun before, finished by this program |"), "{of_16}");
    let fed = |sheet: &str| -> f64 {
        let row = sheet.lines().find(|line| line.starts_with("| tape fed by this program")).unwrap();
        row.split('|').nth(2).unwrap().trim().trim_end_matches(" mm").parse().unwrap()
    };
    assert!(fed(&part) < 0.3 * fed(&whole), "{} {}", fed(&part), fed(&whole));
    assert!(sheet(json!({"dry_run": true})).contains("**DRY RUN: nothing is cut.**"));
}
