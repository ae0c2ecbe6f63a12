//! The stages of a planning attempt: a table of each, then the example ply by divan.

mod table;

use bladeplan::planning::attempt::plan;
use bladeplan::planning::budget::Budget;
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
    table::print("the wing skin of 27 courses", WING_SKIN, ROUNDS);
    table::print("the example ply of 29 courses", JOB, ROUNDS);
    divan::main();
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
