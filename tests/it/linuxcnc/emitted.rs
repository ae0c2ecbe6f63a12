//! What we write is accepted by LinuxCNC's interpreter, and means there what our own reader finds in it: of random programs
//! through the writer, and of everything that any test plans.

use bladeplan::planning::attempt;
use bladeplan::planning::budget::Budget;
use bladeplan::planning::document::JobDocument;
use bladeplan::planning::document::files::Files;
use bladeplan::planning::finding::Finding;
use bladeplan::planning::outcome::{Outcome, ProgramFile};
use bladeplan::planning::program::events::{Event, Positions};
use bladeplan::planning::program::moves::{Pose, Step, TapeProgram};
use bladeplan::planning::program::nc::emit::emit;
use bladeplan::planning::program::nc::read::read;
use bladeplan::planning::program::number::rounded;
use bladeplan::planning::tape::label::CourseLabel;
use bladeplan::planning::tape::machine::{Catalogue, Machine, check, two_cutter_lab};
use proptest::prelude::*;

use super::agreement::compare;
use super::{fixture, interpret};
use crate::rounds::runner;

fn lab() -> Machine {
    check(&two_cutter_lab(), "").expect("it is without fault")
}

/// Plans as [`attempt::plan`] does. Every test that plans in this process plans so: what is planned for LinuxCNC means there
/// what our reader finds in it, whatever else the test looks at.
///
/// # Errors
/// The faults of the input.
///
/// # Panics
/// If LinuxCNC refuses a program or makes something else of it.
pub fn plan(
    document: &JobDocument,
    files: &Files,
    catalogue: &Catalogue,
    budget: &Budget<'_>,
) -> Result<Outcome, Vec<Finding>> {
    let outcome = attempt::plan(document, files, catalogue, budget)?;
    all_agree(&outcome.programs).unwrap_or_else(|why| panic!("{why}"));
    Ok(outcome)
}

fn all_agree(programs: &[ProgramFile]) -> Result<(), TestCaseError> {
    programs
        .iter()
        .filter(|program| program.dialect == "linuxcnc")
        .try_for_each(|program| agrees(&program.text))
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
fn a_program_written_by_hand_agrees_with_our_reader() {
    agrees(&fixture("course")).unwrap();
}

#[test]
fn a_planned_program_on_which_both_do_not_agree_fails_its_test() {
    let program =
        |dialect, text: &str| [ProgramFile { name: "p".to_owned(), dialect, text: text.to_owned() }];
    let (whole, foreign) = (fixture("course"), fixture("foreign"));
    assert!(all_agree(&program("linuxcnc", &whole)).is_ok());
    assert!(all_agree(&program("linuxcnc", &foreign)).is_err());
    assert!(all_agree(&program("sinumerik", &foreign)).is_ok(), "that is another language");
}
