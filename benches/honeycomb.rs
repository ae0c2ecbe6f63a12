//! Planning a core: the published optimum beside another solver, and Table 1 from parameters to replayed program.

use bladeplan::planning::attempt::plan;
use bladeplan::planning::budget::Budget;
use bladeplan::planning::document::files::Files;
use bladeplan::planning::document::{self, JobDocument};
use bladeplan::planning::honeycomb::attempt::carry_through;
use bladeplan::planning::honeycomb::input::check_cut;
use bladeplan::planning::honeycomb::lattice::Spacing;
use bladeplan::planning::honeycomb::lattice_kind::Lattice;
use bladeplan::planning::honeycomb::model::Model;
use bladeplan::planning::honeycomb::optimum::optimum;
use bladeplan::planning::honeycomb::plan::{machined_area, model};
use bladeplan::planning::honeycomb::wire::HoneycombCut;
use bladeplan::planning::honeycomb::{cell, input};
use bladeplan::planning::tape::machine::Catalogue;
use divan::Bencher;

#[path = "../tests/it/oracles.rs"]
mod oracles;

const JOB: &[u8] = include_bytes!("../examples/honeycomb-arc.job.json");

fn main() {
    divan::main();
}

fn job() -> JobDocument {
    document::read(JOB).expect("the example is valid")
}

fn table_1() -> (HoneycombCut, input::CutInput) {
    let value: serde_json::Value = serde_json::from_slice(JOB).expect("the example is JSON");
    let wire: HoneycombCut = serde_json::from_value(value["input"].clone()).expect("the example is a job");
    let input = check_cut(&wire, None).expect("the example is valid");
    (wire, input)
}

fn published() -> Model {
    let (_, input) = table_1();
    let area = machined_area(&input.profile, &input.setting);
    model(&input.setting, area, Lattice::Orthogonal).expect("Table 1 has an optimum")
}

/// The global optimum of Table 1, proved.
#[divan::bench]
fn optimum_ours(bencher: Bencher) {
    let model = published();
    bencher.bench_local(|| optimum(&model));
}

/// One local solution of the same problem, from one start near it.
#[divan::bench]
fn optimum_ripopt(bencher: Bencher) {
    let model = published();
    bencher.bench_local(|| oracles::ripopt(&model, [3.0, 6.0, 40_f64.to_radians()]));
}

/// 119 tips: lattice, path, text, read back, replayed on the section; no robot.
#[divan::bench]
fn table_1_planned_and_replayed(bencher: Bencher) {
    let (_, input) = table_1();
    let cell = cell::check(None, &Catalogue::built_in(), None, &mut Vec::new());
    let spacing = Spacing { layer: 4.398, step: 5.968, swing: 34.155_f64.to_radians() };
    let sha256 = "00ff".repeat(16);
    bencher.bench_local(|| {
        let way = (Lattice::Orthogonal, spacing);
        carry_through(way, input.setting.speeds(), &input, &cell, &sha256, &Budget::unwatched())
    });
}

/// The whole example: three optima, four lattices carried through, the robot along the best, all drawings.
#[divan::bench]
fn the_whole_example(bencher: Bencher) {
    let job = job();
    bencher.bench_local(|| plan(&job, &Files::default(), &Catalogue::built_in(), &Budget::unwatched()));
}
