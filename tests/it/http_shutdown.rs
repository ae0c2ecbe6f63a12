//! How a service ends: in order, or not at all in order.

use std::collections::BTreeSet;
use std::io::Read;
use std::time::{Duration, Instant};

use rustix::process::Signal;
use serde_json::{Value, json};

use crate::served::{PAUSED, Served, id_of, signal, small_job, until};

/// The promise (issue: ends within 30 s even with an SSE client connected).
const PROMISED: Duration = Duration::from_secs(30);

#[test]
fn sigterm_ends_it_with_a_follower_connected_and_gives_the_running_job_back() {
    let served = Served::start(&["--workers", "1", PAUSED]);
    let id = served.posted(&small_job("running"));
    let waiting = served.posted(&small_job("waiting"));
    served.paused_attempt(&[]);
    let mut stream = served.get(&format!("/v1/jobs/{id}/events")).send().unwrap();
    let mut first = [0; 16];
    stream.read_exact(&mut first).unwrap();
    let long_poll = served.get(&format!("/v1/jobs/{waiting}?wait=50"));
    let long_poll = std::thread::spawn(move || long_poll.send());

    let told = Instant::now();
    served.terminate();
    let mut rest = String::new();
    stream.read_to_string(&mut rest).expect("the stream ends properly");
    let (status, folder) = served.exit();
    assert!(told.elapsed() < PROMISED, "{:?}", told.elapsed());
    assert!(status.success(), "{status}");
    // It was answered, or it had not been sent yet when the door closed.
    if let Ok(answer) = long_poll.join().unwrap() {
        assert_eq!(answer.json::<Value>().unwrap()["state"], "queued");
    }

    let served = Served::start_in(folder, &["--workers", "2"]);
    let job = served.ended(&id);
    assert_eq!(
        (&job["state"], &job["attempts"]),
        (&json!("succeeded"), &json!(1)),
        "an orderly end costs no attempt"
    );
    assert_eq!(served.ended(&waiting)["state"], "succeeded");
}

#[test]
fn after_a_kill_in_the_middle_every_acknowledged_job_is_done_once() {
    const JOBS: usize = 100;
    let served = Served::start(&["--workers", "2", PAUSED]);
    // One attempt stands still until the kill interrupts it; the others are let go on.
    let mut acknowledged = vec![keyed(&served, 0).unwrap()];
    let first = served.paused_attempt(&[]);
    acknowledged.extend((1..60).map(|number| keyed(&served, number).unwrap()));
    until(|| {
        let others = served.attempts().into_iter().filter(|pid| *pid != first);
        others.for_each(|pid| signal(pid, Signal::CONT));
        let job = served.json(&format!("/v1/jobs/{}", acknowledged[5]));
        job["finished_at"].is_string().then_some(())
    });
    // Some have ended by now, one or two run, some wait, and the rest has not been posted.
    let folder = served.kill();

    let served = Served::start_in(folder, &["--workers", "2"]);
    for (number, id) in acknowledged.iter().enumerate() {
        assert_eq!(&keyed(&served, number).unwrap(), id, "a repeated post finds its job");
    }
    acknowledged.extend((acknowledged.len()..JOBS).map(|number| keyed(&served, number).unwrap()));
    let different: BTreeSet<&String> = acknowledged.iter().collect();
    assert_eq!(different.len(), JOBS);
    let mut attempts = 0;
    for id in &acknowledged {
        let job = served.ended(id);
        assert_eq!((&job["state"], &job["verdict"]), (&json!("succeeded"), &json!("usable")), "{job}");
        attempts += job["attempts"].as_u64().unwrap();
        let ends =
            served.events(id, None).into_iter().filter(|(_, _, data)| data["state"] == "succeeded").count();
        assert_eq!(ends, 1, "{id}");
    }
    assert!(attempts > JOBS as u64, "no attempt was interrupted");
    let (jobs, programs) = (all(&served, "jobs"), all(&served, "programs"));
    assert_eq!((jobs.len(), programs.len()), (JOBS, JOBS));
    let planned: BTreeSet<&str> = programs.iter().map(|program| program["job"].as_str().unwrap()).collect();
    assert_eq!(planned.len(), JOBS, "each job has one program");
}

fn keyed(served: &Served, number: usize) -> reqwest::Result<String> {
    let post =
        served.post(&small_job(&format!("job {number}"))).header("idempotency-key", format!("mes-{number}"));
    let response = post.send()?;
    assert_eq!(response.status(), 202);
    Ok(id_of(response))
}

fn all(served: &Served, kind: &str) -> Vec<Value> {
    served.json(&format!("/v1/{kind}?limit=200"))[kind].as_array().unwrap().clone()
}
