//! The stages of a planning attempt on the example ply, apart and together.

use bladeplan::planning::attempt::plan;
use bladeplan::planning::budget::Budget;
use bladeplan::planning::document::files::Files;
use bladeplan::planning::document::{self, JobDocument};
use bladeplan::planning::program::nc::read::read;
use bladeplan::planning::tape::machine::Catalogue;
use divan::Bencher;

const JOB: &[u8] = include_bytes!("../examples/wing-skin-trapezoid-45.job.json");

fn main() {
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

/// Everything but reading the job: develop, clip, chains, roll, timeline, write, read back, replay, report.
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
