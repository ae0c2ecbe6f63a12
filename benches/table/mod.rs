//! A table of how long each stage of a planning attempt takes.

use std::cell::RefCell;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use bladeplan::planning::attempt::plan;
use bladeplan::planning::budget::{Budget, DEFAULT_STEPS};
use bladeplan::planning::document;
use bladeplan::planning::document::files::Files;
use bladeplan::planning::tape::machine::Catalogue;

/// What is done around the planning and the proof of a program.
const AROUND: [&str; 3] = ["fingerprint", "draw", "report"];

/// Prints the median time of each stage, in the order in which they come, and of all together.
pub fn print(what: &str, text: &[u8], rounds: usize) {
    let rounds: Vec<Vec<(&str, f64)>> = (0..rounds).map(|_| stages(text)).collect();
    println!("{what}, medians of {} rounds", rounds.len());
    for (index, (name, _)) in rounds[0].iter().enumerate() {
        println!("  {name:<16} {:8.3} ms", median(rounds.iter().map(|round| round[index].1)));
    }
    let sums = |counts: fn(&str) -> bool| {
        let of_round = |round: &Vec<(&str, f64)>| {
            round.iter().filter(|stage| counts(stage.0)).map(|stage| stage.1).sum()
        };
        median(rounds.iter().map(of_round))
    };
    println!("  {:<16} {:8.3} ms", "parse to replay", sums(|name| !AROUND.contains(&name)));
    println!("  {:<16} {:8.3} ms\n", "all", sums(|_| true));
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
