//! Attempts in their child processes: what ends one ends nothing else.

use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};

use rustix::process::Signal;
use serde_json::json;

use crate::served::{PAUSED, Served, large_job, lives, plans_for, rough_job, signal, small_job, until};

#[test]
fn an_attempt_that_is_killed_is_made_again() {
    let served = Served::start(&["--workers", "1", PAUSED]);
    let id = served.posted(&small_job("x"));
    let first = served.paused_attempt(&[]);
    signal(first, Signal::KILL);
    signal(served.paused_attempt(&[first]), Signal::CONT);
    let job = served.ended(&id);
    assert_eq!((&job["state"], &job["attempts"]), (&json!("succeeded"), &json!(2)), "{job}");
    assert_eq!(served.json("/v1/programs")["programs"].as_array().unwrap().len(), 1);
}

#[test]
fn after_three_killed_attempts_the_job_fails_and_says_why() {
    let served = Served::start(&["--workers", "1", PAUSED]);
    let id = served.posted(&small_job("x"));
    let mut known = Vec::new();
    for _ in 0..3 {
        known.push(served.paused_attempt(&known));
        signal(known[known.len() - 1], Signal::KILL);
    }
    let job = served.ended(&id);
    assert_eq!((&job["state"], &job["attempts"]), (&json!("failed"), &json!(3)), "{job}");
    assert_eq!(job["failure"]["code"], "attempts_used_up");
    assert!(job["failure"]["detail"].as_str().unwrap().contains("signal 9"), "{job}");
    let next = served.posted(&small_job("next"));
    signal(served.paused_attempt(&known), Signal::CONT);
    assert_eq!(served.ended(&next)["state"], "succeeded");
}

#[test]
fn an_attempt_that_eats_memory_ends_alone() {
    let served = Served::start(&["--workers", "1", "--attempt-memory-mib", "64"]);
    let poison = served.posted(&large_job(400_000));
    let job = served.ended(&poison);
    assert_eq!((&job["state"], &job["failure"]["code"]), (&json!("failed"), &json!("memory_limit")), "{job}");
    assert_eq!(job["attempts"], 1, "it would end the same way again");
    assert_eq!(served.ended(&served.posted(&small_job("next")))["state"], "succeeded");
}

#[test]
fn an_attempt_that_eats_processor_time_ends_alone() {
    let served = Served::start(&["--workers", "1", "--attempt-cpu-s", "1"]);
    let poison = served.posted(&rough_job(100_000));
    let job = served.ended(&poison);
    assert_eq!((&job["state"], &job["failure"]["code"]), (&json!("failed"), &json!("cpu_limit")), "{job}");
    assert_eq!(served.ended(&served.posted(&small_job("next")))["state"], "succeeded");
}

#[test]
fn attempts_that_stand_still_are_ended_by_the_clock() {
    let served = Served::start(&["--workers", "1", "--attempt-wall-s", "1", PAUSED]);
    let job = served.ended(&served.posted(&small_job("x")));
    assert_eq!(
        (&job["state"], &job["failure"]["code"]),
        (&json!("failed"), &json!("attempts_used_up")),
        "{job}"
    );
    assert!(job["failure"]["detail"].as_str().unwrap().contains("1 s by the clock"), "{job}");
    assert!(served.attempts().is_empty(), "none of them is left behind");
}

#[test]
fn an_attempt_ends_with_the_process_that_started_it() {
    // The attempt waits for its document for as long as this test holds the other end.
    let script = "exec 3<&0; \"$0\" attempt --memory-mib 4096 --cpu-s 60 --parent $$ <&3 & echo $!; wait";
    let mut parent = Command::new("sh")
        .args(["-c", script, env!("CARGO_BIN_EXE_bladeplan")])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut first = String::new();
    BufReader::new(parent.stdout.take().unwrap()).read_line(&mut first).unwrap();
    let attempt: i32 = first.trim().parse().unwrap();
    until(|| plans_for(attempt, parent.id()));
    parent.kill().unwrap();
    until(|| (!lives(attempt)).then_some(()));
    drop(parent.stdin.take());
    parent.wait().unwrap();
}
