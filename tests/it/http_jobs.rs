//! Jobs over a real socket: posting, idempotency, waiting, following, cancelling, back-pressure.

use rustix::process::Signal;
use serde_json::{Value, json};
use sqlx::{Connection, SqliteConnection};

use crate::served::{PAUSED, Served, id_of, signal, small_job, until, unusable_job};

#[test]
fn a_job_is_taken_in_planned_and_gives_its_program() {
    let served = Served::start(&[]);
    let response = served.post(&small_job("one")).send().unwrap();
    assert_eq!(response.status(), 202);
    assert_eq!(response.headers()["retry-after"], "1");
    let location = response.headers()["location"].to_str().unwrap().to_owned();
    let id = id_of(response);
    assert_eq!(location, format!("/v1/jobs/{id}"));

    let job = served.ended(&id);
    assert_eq!((&job["state"], &job["verdict"]), (&json!("succeeded"), &json!("usable")), "{job}");
    assert_eq!((&job["attempts"], &job["references"]["work_order"]), (&json!(1), &json!("4711")));
    assert!(job["stages"].as_array().unwrap().iter().all(|stage| stage["seconds"].as_f64().unwrap() >= 0.0));
    let report = served.json(job["links"]["report"].as_str().unwrap());
    assert_eq!(report["verdict"], "usable");
    // A strip of the ply lies under no course.
    assert_eq!(
        report["findings"].as_array().unwrap().iter().filter(|f| f["severity"] == "warning").count(),
        1
    );
    assert_eq!(job["warnings"], 1);
    assert!(report.get("stages").is_none(), "wall-clock times stand in no stored bytes");
    for name in job["drawings"].as_array().into_iter().flatten() {
        let name = name.as_str().unwrap();
        let drawing = served.get(&format!("{location}/drawings/{name}")).send().unwrap();
        let (status, kind) =
            (drawing.status().as_u16(), drawing.headers()["content-type"].to_str().unwrap().to_owned());
        // Beside the drawings stand the planted trace and the set-up sheet, which are texts.
        let svg = name.ends_with(".svg");
        assert_eq!(
            (status, kind == "image/svg+xml", kind.starts_with("text/plain")),
            (200, svg, !svg),
            "{name}"
        );
    }
    let program = served.json(job["links"]["program"].as_str().unwrap());
    assert_eq!((&program["state"], &program["job"]), (&json!("draft"), &json!(id)));
}

#[test]
fn a_valid_job_without_a_usable_program_has_succeeded_and_gives_none() {
    let served = Served::start(&[]);
    let job = served.ended(&served.posted(&unusable_job()));
    assert_eq!((&job["state"], &job["verdict"]), (&json!("succeeded"), &json!("not_usable")), "{job}");
    assert!(job.get("program").is_none() && job["links"].get("program").is_none());
    let report = served.json(job["links"]["report"].as_str().unwrap());
    let codes: Vec<_> =
        report["findings"].as_array().unwrap().iter().map(|finding| &finding["code"]).collect();
    assert!(codes.contains(&&json!("too_many_knives")), "{codes:?}");
    assert_eq!(served.json("/v1/programs")["programs"], json!([]));
}

#[test]
fn the_same_key_and_body_give_one_job_and_another_body_none() {
    let served = Served::start(&[]);
    let body = small_job("keyed").to_string().into_bytes();
    let post =
        |body: &[u8]| served.post_bytes(body.to_vec()).header("idempotency-key", "mes-1").send().unwrap();
    let first = post(&body);
    assert!(!first.headers().contains_key("idempotency-replayed"));
    let id = id_of(first);
    let again = post(&body);
    assert_eq!(
        (again.status().as_u16(), &again.headers()["idempotency-replayed"]),
        (202, &"true".parse().unwrap())
    );
    assert_eq!(id_of(again), id);
    served.ended(&id);
    assert_eq!(id_of(post(&body)), id, "a job that has ended is still the same job");

    let mut other = body.clone();
    other.push(b' ');
    let refused = post(&other);
    assert_eq!(refused.status(), 422);
    assert_eq!(refused.json::<Value>().unwrap()["code"], "idempotency_key_reused");
    assert_eq!(served.json("/v1/jobs")["jobs"].as_array().unwrap().len(), 1);
    assert_ne!(served.posted(&small_job("keyed")), id, "without a key a post is a new job");
}

#[test]
fn a_key_that_cannot_be_one_is_refused() {
    let served = Served::start(&["--workers", "0"]);
    let longest = "k".repeat(255);
    let too_long = "k".repeat(256);
    for (key, status) in [("", 400), ("a b", 400), (&*too_long, 400), (&*longest, 202)] {
        let response = served.post(&small_job("x")).header("idempotency-key", key).send().unwrap();
        assert_eq!(response.status(), status, "{key:?}");
    }
}

#[test]
fn validate_only_takes_nothing_in() {
    let served = Served::start(&[]);
    let ask = |document: &Value| {
        let body = document.to_string();
        let url = format!("http://{}/v1/jobs?validate_only=true", served.host());
        let client = reqwest::blocking::Client::builder().no_proxy().build().unwrap();
        client.post(url).header("content-type", "application/json").body(body).send().unwrap()
    };
    let sound = ask(&small_job("x"));
    assert_eq!(sound.status(), 200);
    assert_eq!(sound.json::<Value>().unwrap(), json!({"valid": true, "kind": "tape-cut"}));
    let mut faulty = small_job("x");
    faulty["input"]["tape"]["width_mm"] = json!(0);
    assert_eq!(ask(&faulty).status(), 422);
    assert_eq!(served.json("/v1/jobs")["jobs"], json!([]));
}

#[test]
fn jobs_are_listed_by_page_and_found_by_what_they_are() {
    let served = Served::start(&["--workers", "0"]);
    let ids: Vec<String> = (0..5).map(|n| served.posted(&small_job(&format!("p{n}")))).collect();
    let listed = |query: &str| -> Vec<String> {
        let page = served.json(&format!("/v1/jobs{query}"));
        page["jobs"].as_array().unwrap().iter().map(|job| job["id"].as_str().unwrap().to_owned()).collect()
    };
    let newest_first: Vec<String> = ids.iter().rev().cloned().collect();
    assert_eq!(listed(""), newest_first);
    let first = served.json("/v1/jobs?limit=2");
    let second = served.json(&format!("/v1/jobs?limit=2&cursor={}", first["next_cursor"].as_str().unwrap()));
    let third = served.json(&format!("/v1/jobs?limit=2&cursor={}", second["next_cursor"].as_str().unwrap()));
    let pages = [&first, &second, &third];
    let seen: Vec<_> = pages
        .iter()
        .flat_map(|page| page["jobs"].as_array().unwrap())
        .map(|job| job["id"].as_str().unwrap())
        .collect();
    assert_eq!(seen, newest_first);
    assert!(third.get("next_cursor").is_none());
    assert_eq!(listed("?reference=part:p3"), [ids[3].clone()]);
    assert_eq!(listed("?reference=part:p"), Vec::<String>::new());
    assert_eq!(listed("?state=queued&kind=tape-cut").len(), 5);
    assert_eq!(listed("?state=running").len(), 0);
    for query in
        ["?state=idle", "?limit=0", "?limit=201", "?reference=p3", "?cursor=x", "?colour=red", "?limit=x"]
    {
        let response = served.get(&format!("/v1/jobs{query}")).send().unwrap();
        assert_eq!(response.status(), 400, "{query}");
        assert_eq!(response.json::<Value>().unwrap()["code"], "invalid_query", "{query}");
    }
}

#[test]
fn a_known_version_is_not_sent_again_and_waiting_ends_with_a_change() {
    let served = Served::start(&["--workers", "0"]);
    let id = served.posted(&small_job("x"));
    let path = format!("/v1/jobs/{id}");
    let first = served.get(&path).send().unwrap();
    let etag = first.headers()["etag"].clone();
    let known = served.get(&path).header("if-none-match", &etag).send().unwrap();
    assert_eq!((known.status().as_u16(), &known.headers()["etag"]), (304, &etag));

    let waiter = served.get(&format!("{path}?wait=30")).header("if-none-match", &etag);
    let waiting = std::thread::spawn(move || waiter.send().unwrap());
    served.put(&format!("{path}/cancellation")).body("{\"reason\": \"wrong ply\"}").send().unwrap();
    let changed = waiting.join().unwrap();
    assert_eq!(changed.status(), 200);
    assert_ne!(changed.headers()["etag"], etag);
    let job: Value = changed.json().unwrap();
    assert_eq!((&job["state"], &job["cancellation"]["reason"]), (&json!("cancelled"), &json!("wrong ply")));
    assert_eq!(served.get(&format!("{path}?wait=51")).send().unwrap().status(), 400);
}

#[test]
fn a_follower_can_resume_where_it_was() {
    let served = Served::start(&[]);
    let id = served.posted(&small_job("followed"));
    let live = served.events(&id, None);
    let numbers: Vec<i64> = live.iter().map(|(number, _, _)| *number).collect();
    assert_eq!(numbers, (1..=numbers.len() as i64).collect::<Vec<_>>());
    let states: Vec<&str> = live
        .iter()
        .filter(|(_, kind, _)| kind == "state")
        .map(|(_, _, data)| data["state"].as_str().unwrap())
        .collect();
    assert_eq!(states, ["queued", "running", "succeeded"]);
    assert!(live.iter().any(|(_, kind, data)| kind == "stage" && data["stage"] == "replay"), "{live:?}");
    for after in [0, 1, 3, numbers.len() as i64] {
        let rest: Vec<_> = live.iter().filter(|(number, _, _)| *number > after).cloned().collect();
        assert_eq!(served.events(&id, Some(after)), rest);
    }
    let bad = served.get(&format!("/v1/jobs/{id}/events")).header("last-event-id", "x").send().unwrap();
    assert_eq!(bad.status(), 400);
}

#[test]
fn a_running_job_is_cancelled_at_once_and_its_attempt_ends() {
    let served = Served::start(&["--workers", "1", PAUSED]);
    let id = served.posted(&small_job("stands still"));
    // An attempt that stands still would never end by itself.
    let attempt = served.paused_attempt(&[]);
    let path = format!("/v1/jobs/{id}/cancellation");
    let cancelled: Value = served.put(&path).send().unwrap().json().unwrap();
    assert_eq!(cancelled["state"], "cancelled", "{cancelled}");
    // It is told, and does not only notice when its heartbeat is refused: none is written while another has the lock.
    while_locked(&served, || until(|| (!served.attempts().contains(&attempt)).then_some(())));
    let next = served.posted(&small_job("next"));
    signal(served.paused_attempt(&[attempt]), Signal::CONT);
    let next = served.ended(&next);
    assert_eq!(next["state"], "succeeded", "the worker is free again");
    assert_eq!(served.put(&path).send().unwrap().status(), 200, "cancelling again changes nothing");
    let done = format!("/v1/jobs/{}/cancellation", next["id"].as_str().unwrap());
    let refused = served.put(&done).send().unwrap();
    assert_eq!(refused.status(), 409);
    assert_eq!(refused.json::<Value>().unwrap()["code"], "job_finished");
}

/// Does something while the service can read its store and not write it.
fn while_locked(served: &Served, act: impl FnOnce()) {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    let url = format!("sqlite://{}", served.database().display());
    let mut connection = runtime.block_on(SqliteConnection::connect(&url)).unwrap();
    let mut execute = |statement: &'static str| {
        runtime.block_on(sqlx::query(statement).execute(&mut connection)).unwrap();
    };
    execute("BEGIN IMMEDIATE");
    act();
    execute("ROLLBACK");
}

#[test]
fn what_is_not_there_yet_or_never_will_be_is_said() {
    let served = Served::start(&["--workers", "0"]);
    let id = served.posted(&small_job("x"));
    let code = |path: &str| {
        let response = served.get(path).send().unwrap();
        (response.status().as_u16(), response.json::<Value>().unwrap()["code"].as_str().unwrap().to_owned())
    };
    assert_eq!(code(&format!("/v1/jobs/{id}/report")), (409, "not_ready".into()));
    assert_eq!(code(&format!("/v1/jobs/{id}/drawings/x.svg")), (409, "not_ready".into()));
    served.put(&format!("/v1/jobs/{id}/cancellation")).send().unwrap();
    assert_eq!(code(&format!("/v1/jobs/{id}/report")), (409, "no_report".into()));
    assert_eq!(code(&format!("/v1/jobs/{id}/drawings/x.svg")), (404, "drawing_not_found".into()));
    let nobody = "job_00000000000070008000000000000000";
    for path in ["", "/report", "/input", "/events", "/drawings/x.svg"] {
        assert_eq!(code(&format!("/v1/jobs/{nobody}{path}")), (404, "job_not_found".into()), "{path}");
    }
    assert_eq!(code("/v1/jobs/..%2F..%2Fetc%2Fpasswd"), (404, "job_not_found".into()));
    let input = served.get(&format!("/v1/jobs/{id}/input")).send().unwrap();
    assert_eq!(input.bytes().unwrap(), small_job("x").to_string().as_bytes());
}

#[test]
fn a_full_queue_says_when_to_come_back() {
    let served = Served::start(&["--workers", "0", "--max-queued", "2"]);
    served.posted(&small_job("1"));
    let second = served.posted(&small_job("2"));
    let full = served.post(&small_job("3")).send().unwrap();
    assert_eq!((full.status().as_u16(), &full.headers()["retry-after"]), (429, &"5".parse().unwrap()));
    let problem: Value = full.json().unwrap();
    assert_eq!((&problem["code"], &problem["retryable"]), (&json!("queue_full"), &json!(true)));
    served.put(&format!("/v1/jobs/{second}/cancellation")).send().unwrap();
    served.posted(&small_job("3"));
}
