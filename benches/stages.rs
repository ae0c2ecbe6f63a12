//! The stages of a planning attempt: a table of each, then the example ply by divan.

use std::cell::RefCell;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use bladeplan::planning::attempt::plan;
use bladeplan::planning::budget::{Budget, DEFAULT_STEPS};
use bladeplan::planning::document::files::Files;
use bladeplan::planning::document::{self, JobDocument};
use bladeplan::planning::program::nc::read::read;
use bladeplan::planning::tape::machine::Catalogue;
use divan::Bencher;

const JOB: &[u8] = include_bytes!("../examples/wing-skin-trapezoid-45.job.json");
/// The wing skin of 27 courses whose clipping and chains alone take 38 ms with NumPy and Shapely (yardstick/wing_skin.py).
const WING_SKIN: &[u8] = include_bytes!("../tests/fixtures/roll/wing-skin-45.job.json");
const ROUNDS: usize = 30;

fn main() {
    table("the wing skin of 27 courses", WING_SKIN);
    table("the example ply of 29 courses", JOB);
    divan::main();
}

/// Prints the median time of each stage, in the order in which they come, and of all together.
fn table(what: &str, text: &[u8]) {
    let rounds: Vec<Vec<(&str, f64)>> = (0..ROUNDS).map(|_| stages(text)).collect();
    println!("{what}, medians of {ROUNDS} rounds");
    for (index, (name, _)) in rounds[0].iter().enumerate() {
        println!("  {name:<12} {:8.3} ms", median(rounds.iter().map(|round| round[index].1)));
    }
    let totals = rounds.iter().map(|round| round.iter().map(|stage| stage.1).sum());
    println!("  {:<12} {:8.3} ms\n", "all", median(totals));
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// The stages of one attempt with the time of each in ms.
fn stages(text: &[u8]) -> Vec<(&'static str, f64)> {
    let begun = RefCell::new(vec![("parse", Instant::now())]);
    let job = document::read(text).expect("it is valid");
    let on_stage = |name: &'static str| begun.borrow_mut().push((name, Instant::now()));
    on_stage("fingerprint");
    let never = AtomicBool::new(false);
    let budget = Budget::new(DEFAULT_STEPS, &never, &on_stage);
    let outcome = plan(&job, &Files::default(), &Catalogue::built_in(), &budget).expect("it is valid");
    assert!(!outcome.programs.is_empty(), "it can be cut");
    let end = Instant::now();
    let begun = begun.borrow();
    let ends = begun[1..].iter().map(|stage| stage.1).chain([end]);
    begun.iter().zip(ends).map(|((name, from), to)| (*name, 1e3 * (to - *from).as_secs_f64())).collect()
}

fn job() -> JobDocument {
    document::read(JOB).expect("the example is valid")
}

fn program() -> String {
    let mut outcome = plan(&job(), &Files::default(), &Catalogue::built_in(), &Budget::unwatched())
        .expect("the example is valid");
    outcome.programs.pop().expect("the example can be cut").text
}

/// What parsing the job costs anybody: the measure for the rest.
#[divan::bench]
fn parse_as_plain_json() -> serde_json::Value {
    serde_json::from_slice(JOB).expect("the example is JSON")
}

#[divan::bench]
fn read_job() -> JobDocument {
    job()
}

/// Everything but reading the job.
#[divan::bench]
fn plan_job(bencher: Bencher) {
    let (job, catalogue) = (job(), Catalogue::built_in());
    let files = Files::default();
    bencher.bench_local(|| plan(&job, &files, &catalogue, &Budget::unwatched()));
}

#[divan::bench]
fn read_program_back(bencher: Bencher) {
    let text = program();
    bencher.bench_local(|| read("roll.ngc", &text));
}
