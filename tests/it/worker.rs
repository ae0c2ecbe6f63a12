//! Attempts in their child processes: what ends one ends nothing else.

use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};

use rustix::process::{Pid, Signal, kill_process};
use serde_json::json;

use crate::served::{Served, large_job, lives, plans_for, small_job, until};

fn signal(pid: i32, signal: Signal) {
    kill_process(Pid::from_raw(pid).unwrap(), signal).unwrap();
}

#[test]
fn an_attempt_that_is_killed_is_made_again() {
    let served = Served::start(&["--workers", "1"]);
    let id = served.posted(&large_job(5_000));
    let attempt = served.frozen_attempt();
    signal(attempt, Signal::KILL);
    let job = served.ended(&id);
    assert_eq!((&job["state"], &job["attempts"]), (&json!("succeeded"), &json!(2)), "{job}");
    assert_eq!(served.json("/v1/programs")["programs"].as_array().unwrap().len(), 1);
}

#[test]
fn after_three_killed_attempts_the_job_fails_and_says_why() {
    let served = Served::start(&["--workers", "1"]);
    let id = served.posted(&large_job(5_000));
    let mut last = 0;
    for _ in 0..3 {
        let attempt = until(|| served.attempts().into_iter().find(|pid| *pid != last));
        signal(attempt, Signal::KILL);
        last = attempt;
    }
    let job = served.ended(&id);
    assert_eq!((&job["state"], &job["attempts"]), (&json!("failed"), &json!(3)), "{job}");
    assert_eq!(job["failure"]["code"], "attempts_used_up");
    assert!(job["failure"]["detail"].as_str().unwrap().contains("signal 9"), "{job}");
    assert_eq!(served.ended(&served.posted(&small_job("next")))["state"], "succeeded");
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
    let poison = served.posted(&large_job(60_000));
    let job = served.ended(&poison);
    assert_eq!((&job["state"], &job["failure"]["code"]), (&json!("failed"), &json!("cpu_limit")), "{job}");
    assert_eq!(served.ended(&served.posted(&small_job("next")))["state"], "succeeded");
}

#[test]
fn attempts_that_stand_still_are_ended_by_the_clock() {
    let served = Served::start(&["--workers", "1", "--attempt-wall-s", "2"]);
    let id = served.posted(&large_job(5_000));
    let mut last = 0;
    for _ in 0..3 {
        last = until(|| served.attempts().into_iter().find(|pid| *pid != last));
        signal(last, Signal::STOP);
    }
    let job = served.ended(&id);
    assert_eq!(
        (&job["state"], &job["failure"]["code"]),
        (&json!("failed"), &json!("attempts_used_up")),
        "{job}"
    );
    assert!(job["failure"]["detail"].as_str().unwrap().contains("2 s by the clock"), "{job}");
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
