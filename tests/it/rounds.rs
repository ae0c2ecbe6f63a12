//! How many rounds the property tests go: `make prove` asks for more than `make test`.

use std::env;

use proptest::test_runner::{Config, TestRunner};

/// A runner of property tests that goes `usual` rounds, times `BLADEPLAN_ROUNDS` where that is set.
pub fn runner(usual: u32) -> TestRunner {
    // What fails is printed whole; a file of seeds beside the tests would only be left behind.
    TestRunner::new(Config { cases: rounds(usual), failure_persistence: None, ..Config::default() })
}

/// `usual` rounds, times `BLADEPLAN_ROUNDS` where that is set.
pub fn rounds(usual: u32) -> u32 {
    usual * factor(env::var("BLADEPLAN_ROUNDS").ok().as_deref())
}

fn factor(wish: Option<&str>) -> u32 {
    let Some(wish) = wish else { return 1 };
    let factor = wish.parse().unwrap_or(0);
    assert!(factor > 0, "BLADEPLAN_ROUNDS is a whole number from 1, not {wish:?}");
    factor
}

#[test]
fn rounds_are_multiplied_where_that_is_asked_for() {
    assert_eq!(factor(None), 1);
    assert_eq!(factor(Some("20")), 20);
}

#[test]
#[should_panic(expected = "whole number from 1")]
fn rounds_that_prove_nothing_are_refused() {
    factor(Some("0"));
}
