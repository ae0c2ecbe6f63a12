//! What we write is accepted by LinuxCNC's interpreter, and means there what our own reader finds in it.

use std::fs;
use std::path::Path;

use bladeplan::planning::attempt::plan;
use bladeplan::planning::budget::Budget;
use bladeplan::planning::document;
use bladeplan::planning::document::files::Files;
use bladeplan::planning::program::events::{Event, Positions};
use bladeplan::planning::program::moves::{Pose, Step, TapeProgram};
use bladeplan::planning::program::nc::emit::emit;
use bladeplan::planning::program::nc::read::read;
use bladeplan::planning::program::number::rounded;
use bladeplan::planning::tape::label::CourseLabel;
use bladeplan::planning::tape::machine::{Catalogue, Machine, check, two_cutter_lab};
use proptest::prelude::*;
use serde_json::json;

use super::agreement::compare;
use super::{fixture, interpret};
use crate::blade_offset::offset;
use crate::craft::overcutting;
use crate::golden::{cases, outcome};
use crate::profiles::{job, lab_with, plan_job};
use crate::random_plies::{Ply, plies};
use crate::rounds::runner;

fn lab() -> Machine {
    check(&two_cutter_lab(), "").expect("it is without fault")
}

/// Fails with the first difference and the text.
fn agrees(text: &str) -> Result<(), TestCaseError> {
    let refused = |why: String| TestCaseError::fail(format!("{why}\n{text}"));
    let canon = interpret(text).map_err(|error| refused(format!("LinuxCNC refuses it: {error:?}")))?;
    let ours = read("p.ngc", text).map_err(|faults| refused(format!("we refuse it: {faults:?}")))?;
    compare(&canon, &ours).map_err(refused)
}

/// A number as a planner gives it to a program: rounded to the printed digits.
fn digits(range: std::ops::Range<f64>) -> impl Strategy<Value = f64> {
    range.prop_map(|value| rounded(value, 4))
}

fn label() -> impl Strategy<Value = CourseLabel> {
    (prop::option::of(1_u32..9), 1_u32..100).prop_map(|(ply, number)| CourseLabel { ply, number })
}

fn step() -> impl Strategy<Value = Step> {
    let lateral = proptest::array::uniform2(digits(-170.0..170.0));
    let blade = proptest::array::uniform2(digits(-360.0..360.0));
    let advance = prop_oneof![Just(0.0), digits(0.001..500.0)];
    let pose = (advance, lateral, blade).prop_map(|(feed_mm, lateral_mm, blade_deg)| Pose {
        feed_mm,
        lateral_mm,
        blade_deg,
    });
    prop_oneof![
        8 => (pose, 0.01_f64..20.0).prop_map(|(to, cruise_s)| Step::Move { to, cruise_s }),
        3 => (0_usize..2, any::<bool>()).prop_map(|(cutter, down)| Step::Knife { cutter, down }),
        1 => any::<bool>().prop_map(|on| Step::Ultrasonic { on }),
        2 => digits(0.001..10.0).prop_map(|seconds| Step::Dwell { seconds }),
        1 => (label(), any::<bool>()).prop_map(|(label, restartable)| Step::Course { label, restartable }),
        1 => Just(Step::OptionalStop),
    ]
}

/// Steps with advances as a program: the tape never runs back.
fn program(mut steps: Vec<Step>) -> TapeProgram {
    let mut reached = 0.0;
    for step in &mut steps {
        if let Step::Move { to, .. } = step {
            reached = rounded(reached + to.feed_mm, 4);
            to.feed_mm = reached;
        }
    }
    TapeProgram { steps, ..TapeProgram::default() }
}

/// What the machine has to do for a step, without the line: what its axes and outputs are called is in the profile.
fn meant(step: &Step, from: Positions) -> Vec<Event> {
    vec![match *step {
        Step::Move { to: Pose { feed_mm, lateral_mm, blade_deg }, cruise_s } => {
            let to = [0.0, 0.0, 0.0, blade_deg[0], blade_deg[1], 0.0, feed_mm, lateral_mm[0], lateral_mm[1]];
            Event::Move { from, to, cruise_s: Some(cruise_s) }
        }
        Step::Knife { cutter: 0, down } => Event::Output { number: 0, on: down },
        Step::Knife { down, .. } => Event::Output { number: 1, on: down },
        Step::Ultrasonic { on } => Event::Output { number: 2, on },
        Step::Dwell { seconds } => Event::Dwell { seconds },
        Step::OptionalStop => Event::OptionalStop,
        Step::Course { restartable: false, .. } => return Vec::new(),
        // Knives up, generator on, every axis where it is already.
        Step::Course { restartable: true, .. } => {
            return vec![
                Event::Output { number: 0, on: false },
                Event::Output { number: 1, on: false },
                Event::Dwell { seconds: 0.05 },
                Event::Move { from, to: from, cruise_s: Some(0.0) },
                Event::Output { number: 2, on: true },
                Event::Move { from, to: from, cruise_s: Some(10.0) },
            ];
        }
    }]
}

/// Whether the text does the program's steps one by one. Printed feeds are a little slower than what is meant.
fn does(text: &str, program: &TapeProgram) -> Result<(), TestCaseError> {
    let mut done =
        read("p.ngc", text).expect("agreement came first").into_iter().map(|executed| executed.event);
    let mut position = [0.0; 9];
    let mut position_of = |step: &Step| {
        let events = meant(step, position);
        if let Some(Event::Move { to, .. }) = events.last() {
            position = *to;
        }
        events
    };
    let meant: Vec<Event> = program.steps.iter().flat_map(&mut position_of).collect();
    for mut meant in meant {
        let done = done.next();
        if let (Event::Move { cruise_s: Some(wish), .. }, Some(Event::Move { cruise_s: Some(is), .. })) =
            (&mut meant, &done)
        {
            prop_assert!((*wish..=*wish * 1.001).contains(is), "{is} s instead of {wish} s");
            *wish = *is;
        }
        prop_assert_eq!(done, Some(meant));
    }
    prop_assert_eq!(done.collect::<Vec<_>>(), [Event::End]);
    Ok(())
}

#[test]
fn every_emitted_program_agrees_with_our_reader() {
    let machine = lab();
    let mut runner = runner(200);
    let agree = |steps| {
        let program = program(steps);
        let text = emit(&program, &machine, &"0f".repeat(32));
        agrees(&text)?;
        does(&text, &program)
    };
    runner.run(&proptest::collection::vec(step(), 1..60), agree).unwrap();
}

#[test]
fn every_golden_program_agrees_with_our_reader() {
    let programs: Vec<_> = cases().iter().flat_map(|case| outcome(case).programs).collect();
    assert!(programs.len() >= 5, "only {} golden programs found", programs.len());
    for program in programs {
        agrees(&program.text).unwrap();
    }
}

#[test]
fn every_planned_ply_agrees_with_our_reader() {
    let agree = |ply: Ply| ply.plan().programs.iter().try_for_each(|program| agrees(&program.text));
    runner(50).run(&plies(), agree).unwrap();
}

/// Overcuts, blade offsets, a spool's degrees, a program from a course on and a dry run.
#[test]
fn every_way_to_cut_the_example_agrees_with_our_reader() {
    let example = job("examples/wing-skin-trapezoid-45.job.json");
    let spool = json!({"core_radius_mm": 50, "roll_radius_mm": 150, "layer_thickness_mm": 0.4});
    let spooled = lab_with(&[("/feed/drive", json!("unwind_angle")), ("/feed/spool", spool)]);
    let parked =
        lab_with(&[("/cutters/0/lateral/park_mm", json!(60)), ("/cutters/1/lateral/park_mm", json!(-60))]);
    for (machine, options) in [
        (overcutting(1.5), json!(null)),
        (spooled, json!(null)),
        (lab_with(&[]), json!({"dry_run": true})),
        (overcutting(1.5), json!({"from_course": 1})),
        (offset(1.0), json!(null)),
        (offset(-2.0), json!({"allocation": "free"})),
        (parked, json!(null)),
    ] {
        let planned = plan_job(&example, &machine, &options).unwrap();
        agrees(&planned.programs[0].text).unwrap();
    }
}

#[test]
fn the_example_agrees_with_our_reader() {
    let home = Path::new(env!("CARGO_MANIFEST_DIR"));
    let job = fs::read(home.join("examples/wing-skin-trapezoid-45.job.json")).unwrap();
    let planned =
        plan(&document::read(&job).unwrap(), &Files::default(), &Catalogue::built_in(), &Budget::unwatched())
            .unwrap();
    agrees(&planned.programs[0].text).unwrap();
}

#[test]
fn every_roll_of_two_plies_agrees_with_our_reader() {
    let agree = |(one, other): (Ply, Ply)| {
        let planned =
            plan_job(&one.job_with(&other), &json!("two-cutter-lab"), &json!({"allocation": "free"}));
        planned.unwrap().programs.iter().try_for_each(|program| agrees(&program.text))
    };
    runner(10).run(&(plies(), plies()), agree).unwrap();
    let example = job("examples/two-plies.job.json");
    for options in [json!(null), json!({"allocation": "free", "from_ply": 2, "from_course": 3})] {
        let planned = plan_job(&example, &json!("two-cutter-lab"), &options).unwrap();
        agrees(&planned.programs[0].text).unwrap();
    }
}

#[test]
fn a_program_written_by_hand_agrees_with_our_reader() {
    agrees(&fixture("course")).unwrap();
}
