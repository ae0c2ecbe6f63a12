//! A blade whose edge lies beside the axis that turns it.

use std::cell::Cell;

use bladeplan::planning::attempt::check;
use bladeplan::planning::budget::Budget;
use bladeplan::planning::document;
use bladeplan::planning::document::files::Files;
use bladeplan::planning::finding::{Code, Finding};
use bladeplan::planning::outcome::{ProgramFile, Verdict};
use bladeplan::planning::program::events::Event;
use bladeplan::planning::program::nc::read::read;
use bladeplan::planning::tape::machine::Catalogue;
use proptest::prelude::*;
use serde_json::{Value, json};

use crate::profiles::{job, lab, lab_with, plan_job, refused};
use crate::random_plies::{Ply, plies};
use crate::rounds::runner;

/// The lab with blades of one edge, this far from the axis.
pub fn offset(mm: f64) -> Value {
    lab_with(&[
        ("/cutters/0/blade/offset_mm", json!(mm)),
        ("/cutters/0/blade/edges", json!("single")),
        ("/cutters/1/blade/offset_mm", json!(mm)),
        ("/cutters/1/blade/edges", json!("single")),
    ])
}

/// A tape of 75 mm whose ply ends in a slant of 45 degrees, cut by cutter 1 from (400, -37.5) to (325, 37.5).
fn slanted() -> Value {
    json!({"kind": "tape-cut", "name": "n", "input": {
        "tape": {"width_mm": 75, "thickness_mm": 0.125},
        "boundary": {"points": [[0,-37.5,0],[0,37.5,0],[325,37.5,0],[400,-37.5,0]]},
        "tracks": [{"number": 1, "points": [{"position":[0,0,0],"normal":[0,0,1]},{"position":[400,0,0],"normal":[0,0,1]}]}]}})
}

fn checked(job: &Value, text: &str) -> Vec<Finding> {
    let document = document::from_value(job.clone()).unwrap();
    let file = ProgramFile { name: "roll.ngc".to_owned(), dialect: "linuxcnc", text: text.to_owned() };
    check(&document, &Files::default(), &Catalogue::built_in(), &[file], &Budget::unwatched()).unwrap().1
}

/// U and V where knife 1 goes down and where it comes up, for the first time.
fn first_cut(text: &str) -> [[f64; 2]; 2] {
    let mut at = [0.0; 2];
    let mut ends = Vec::new();
    for executed in read("p", text).unwrap() {
        match executed.event {
            Event::Move { to, .. } => at = [to[6], to[7]],
            Event::Output { number: 0, on } if on || !ends.is_empty() => ends.push(at),
            _ => {}
        }
    }
    [ends[0], ends[1]]
}

#[test]
fn a_straight_slanted_cut_is_made_where_the_closed_form_has_the_axis() {
    for mm in [4.0, -4.0] {
        let outcome = plan_job(&slanted(), &offset(mm), &json!(null)).unwrap();
        assert_eq!(outcome.verdict, Verdict::Usable, "{:?}", outcome.findings);
        let sheet = &outcome.attachments.iter().find(|text| text.name == "setup.md").unwrap().text;
        let way = if mm > 0.0 { "behind" } else { "ahead of" };
        assert!(
            sheet.contains(&format!("| edge of knife 1 | 4.0 mm {way} the axis that turns the blade")),
            "{sheet}"
        );
        let lead = outcome.report["roll"]["lead_mm"].as_f64().unwrap();
        // An edge that leads is over the cut before its axis, which the tape's leading end makes room for.
        assert!((lead - 400.0 - f64::max(-mm, 0.0)).abs() < 1e-3, "{lead}");
        let by = mm * 0.5_f64.sqrt();
        let ends = [[lead - 400.0 + by, -37.5 + by], [lead - 325.0 + by, 37.5 + by]];
        for (found, is) in first_cut(&outcome.programs[0].text).as_flattened().iter().zip(ends.as_flattened())
        {
            assert!((found - is).abs() < 2e-4, "{found} {is}");
        }
    }
}

/// What a planner that passes over the offset gives out is found by the replay, and the other way round.
#[test]
fn a_program_without_its_offset_does_not_pass() {
    let with = |machine: Value| {
        let mut job = slanted();
        job["input"]["machine"] = machine;
        job
    };
    let text =
        |job: &Value| plan_job(job, &job["input"]["machine"], &json!(null)).unwrap().programs.remove(0).text;
    let (plain, beside) = (with(lab()), with(offset(0.05)));
    assert!(checked(&beside, &text(&beside)).is_empty() && checked(&plain, &text(&plain)).is_empty());
    for (job, text) in
        [(&beside, text(&plain)), (&plain, text(&beside)), (&with(offset(-0.05)), text(&beside))]
    {
        let found = checked(job, &text);
        assert!(found.iter().any(|finding| finding.code == Code::Deviation), "{found:?}");
    }
}

/// The edge is on one side of the axis: turned about, the blade cuts elsewhere.
#[test]
fn an_edge_is_never_turned_about() {
    let mut job = slanted();
    job["input"]["machine"] = offset(3.0);
    let text = plan_job(&job, &offset(3.0), &json!(null)).unwrap().programs.remove(0).text;
    assert!(checked(&job, &text).is_empty());
    let blade = text.split_whitespace().find(|word| word.starts_with("A-45")).unwrap();
    let turned = checked(&job, &text.replace(blade, "A135.0"));
    assert!(turned.iter().any(|finding| finding.is_error()), "{turned:?}");
}

/// A second edge would cut in front of the axis, into the good piece at a corner.
#[test]
fn a_blade_of_two_edges_has_them_on_its_axis() {
    let mut two = offset(3.0);
    two["cutters"][1]["blade"]["edges"] = json!("double");
    let faults = refused(&two);
    assert_eq!(faults, [(Code::ConflictingFields, "/input/machine/cutters/1/blade/edges".to_owned())]);
}

#[test]
fn a_corner_that_needs_the_tape_back_is_refused_with_course_place_and_amount() {
    let mut ply = slanted();
    // From a slant of 45 degrees to square across: 4 (sin 45 - 0) mm back.
    ply["input"]["boundary"]["points"] =
        json!([[0, -37.5, 0], [0, 37.5, 0], [362.5, 37.5, 0], [362.5, 0, 0], [400, -37.5, 0]]);
    let mut one = offset(4.0);
    one["cutters"].as_array_mut().unwrap().pop();
    let outcome = plan_job(&ply, &one, &json!(null)).unwrap();
    assert_eq!(outcome.verdict, Verdict::NotUsable);
    let fault = outcome.findings.iter().find(|finding| finding.is_error()).unwrap();
    assert_eq!(fault.code, Code::TapeReversal);
    assert!(
        fault.message.starts_with("course 1, cutter 1: at u 362.500 mm")
            && fault.message.contains("by 2.828"),
        "{fault}"
    );
    // A second knife takes over there.
    let outcome = plan_job(&ply, &offset(4.0), &json!(null)).unwrap();
    assert_eq!(outcome.verdict, Verdict::Usable, "{:?}", outcome.findings);
    let cuts = &outcome.report["courses"][0]["pieces"][0]["cuts"];
    let slanted =
        cuts.as_array().unwrap().iter().filter(|cut| cut["points_uv"][0][0].as_f64().unwrap() > 0.0);
    assert_eq!(
        slanted.map(|cut| cut["cutter"].as_u64().unwrap()).collect::<std::collections::BTreeSet<_>>().len(),
        2,
        "{cuts}"
    );
    // The edge leads, and the same corner takes the tape forward: with the knife up, for it is sharp.
    let outcome = plan_job(&ply, &offset(-4.0), &json!(null)).unwrap();
    assert_eq!(outcome.verdict, Verdict::Usable, "{:?}", outcome.findings);
}

#[test]
fn the_carriage_must_reach_beside_the_tape_with_its_axis() {
    let mut machine = offset(4.0);
    machine["cutters"][0]["lateral"]["max_mm"] = json!(39);
    let outcome = plan_job(&slanted(), &machine, &json!(null)).unwrap();
    let fault = outcome.findings.iter().find(|finding| finding.is_error()).unwrap();
    // 37.5 + 4 / sqrt 2
    assert!(fault.code == Code::AxisLimit && fault.message.contains("would have to be at 40.328"), "{fault}");
    for mm in [101.0, -0.009] {
        let fault = refused(&lab_with(&[("/cutters/0/blade/offset_mm", json!(mm))])).remove(0);
        assert_eq!(fault, (Code::OutOfRange, "/input/machine/cutters/0/blade/offset_mm".to_owned()));
    }
}

#[test]
fn every_ply_passes_its_replay_with_an_offset_or_says_where_the_tape_would_run_back() {
    let (usable, turned) = (Cell::new(0), Cell::new(0));
    let sizes = prop_oneof![-5.0..5.0_f64, -0.3..0.3_f64].prop_map(|mm| mm.abs().max(0.01).copysign(mm));
    let strategy = (plies(), sizes, prop_oneof![Just(0.0), 0.5..3.0_f64], any::<bool>(), any::<bool>());
    let passes = |(ply, mm, overcut, free, spooled): (Ply, f64, f64, bool, bool)| {
        let mut machine = offset(mm);
        if spooled {
            machine["feed"]["drive"] = json!("takeup_angle");
            machine["feed"]["spool"] =
                json!({"core_radius_mm": 50, "roll_radius_mm": 100, "layer_thickness_mm": 1.0});
        }
        (0..2).for_each(|k| machine["cutters"][k]["blade"]["overcut_mm"] = json!(overcut));
        let mut job = ply.job();
        job["input"]["options"] = json!({"allocation": if free { "free" } else { "by_slope" }});
        let outcome = plan_job(&job, &machine, &json!(null)).unwrap();
        let errors: Vec<_> = outcome.findings.iter().filter(|finding| finding.is_error()).collect();
        let honest = |finding: &&Finding| match finding.code {
            Code::TooManyKnives => true,
            Code::TapeReversal => finding.at == "/input/machine" && finding.message.contains("at u "),
            _ => false,
        };
        prop_assert!(errors.iter().all(honest), "{:?}", errors);
        turned
            .set(turned.get() + usize::from(errors.iter().any(|finding| finding.code == Code::TapeReversal)));
        if errors.is_empty() {
            usable.set(usable.get() + 1);
            let replay = &outcome.report["replay"];
            prop_assert!(replay["max_deviation_mm"].as_f64().unwrap() <= 0.011, "{}", replay);
            prop_assert!(replay["uncut_mm"].as_f64().unwrap() <= 0.02, "{}", replay);
            let (time, bound) = (&outcome.report["time_s"], &outcome.report["bound_time_s"]);
            prop_assert!(time.as_f64() >= bound.as_f64(), "{} {}", time, bound);
        }
        Ok(())
    };
    runner(80).run(&strategy, passes).unwrap();
    // Of 80 plies about 40 are cut and 20 refused for it.
    assert!(usable.get() >= 3 && turned.get() >= 3, "{} {}", usable.get(), turned.get());
}

#[test]
fn a_program_from_a_course_on_counts_what_edges_have_cut() {
    let example = job("examples/wing-skin-trapezoid-45.job.json");
    let whole = plan_job(&example, &offset(1.0), &json!(null)).unwrap();
    assert_eq!(whole.verdict, Verdict::Usable, "{:?}", whole.findings);
    let usable = (1..=9).filter(|from| {
        let outcome = plan_job(&example, &offset(1.0), &json!({"from_course": from})).unwrap();
        let found: Vec<_> = outcome.findings.iter().filter(|finding| finding.is_error()).collect();
        assert!(found.iter().all(|finding| finding.code == Code::KnifeState), "{found:?}");
        found.is_empty() && outcome.report["approach_s"] != 0.0
    });
    assert!(usable.count() >= 2);
}
