//! What is refused at POST: with its exact codes and pointers, and without a trace in the store but a count.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::Path;

use serde_json::Value;
use sqlx::{Connection, Row, SqliteConnection};

use crate::refused::cases;
use crate::served::{PATIENCE, Served, small_job};

#[test]
fn each_refused_input_is_a_problem_with_all_its_faults_and_leaves_no_trace() {
    let served = Served::start(&[]);
    let mut refused = 0;
    for (path, bytes, expected) in cases() {
        let response =
            served.post_bytes(bytes).header("idempotency-key", format!("k{refused}")).send().unwrap();
        refused += 1;
        let status = response.status().as_u16();
        assert_eq!(response.headers()["content-type"], "application/problem+json", "{}", path.display());
        let problem: Value = response.json().unwrap();
        let mut found: Vec<(&str, &str)> = problem["faults"]
            .as_array()
            .unwrap()
            .iter()
            .map(|f| (text(f, "code"), text(f, "pointer")))
            .collect();
        found.sort_unstable();
        let expected: Vec<_> =
            expected.iter().map(|fault| (fault.code.as_str(), fault.at.as_str())).collect();
        assert_eq!(found, expected, "{}", path.display());
        let unreadable = expected.iter().any(|(code, _)| ["invalid_json", "too_deep"].contains(code));
        assert_eq!(status, if unreadable { 400 } else { 422 }, "{}", path.display());
        assert_eq!(problem["retryable"], false);
        assert!(problem["next_step"].as_str().is_some_and(|step| !step.is_empty()));
    }
    assert!(refused >= 40, "only {refused} refused inputs found");
    assert_eq!(rows_by_table(&served.database()), [("counters".to_owned(), 2)]);
    let metrics = served.get("/metrics").send().unwrap().text().unwrap();
    let counted: i64 = metrics
        .lines()
        .filter(|line| line.starts_with("bladeplan_posts_refused_total{"))
        .map(|line| line.rsplit(' ').next().unwrap().parse::<i64>().unwrap())
        .sum();
    assert_eq!(counted, refused);
}

#[test]
fn a_body_over_the_limit_is_refused_announced_or_not() {
    let served = Served::start(&["--max-body-mib", "1", "--workers", "0"]);
    let mut document = small_job("x").to_string().into_bytes();
    document.resize(1024 * 1024, b' ');
    assert_eq!(
        served.post_bytes(document.clone()).send().unwrap().status(),
        202,
        "exactly the limit is taken"
    );
    document.push(b' ');
    let announced = served.post_bytes(document.clone()).send().unwrap();
    assert_eq!(announced.status(), 413);
    assert_eq!(announced.json::<Value>().unwrap()["code"], "body_too_large");
    let chunked = reqwest::blocking::Body::new(std::io::Cursor::new(document));
    let chunked = served.post_bytes(Vec::new()).body(chunked).send().unwrap();
    assert_eq!(chunked.status(), 413);
}

#[test]
fn a_truncated_body_is_refused() {
    let served = Served::start(&[]);
    let mut stream = TcpStream::connect(served.host()).unwrap();
    let head = "POST /v1/jobs HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nContent-Length: 1000\r\n\r\n";
    stream.write_all(head.as_bytes()).unwrap();
    stream.write_all(b"{\"kind\": \"tape-cut\"").unwrap();
    stream.shutdown(std::net::Shutdown::Write).unwrap();
    let mut answer = String::new();
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    let _ = stream.read_to_string(&mut answer);
    // A client that has gone away is told nothing; one that still listens is told that the body is incomplete.
    assert!(answer.is_empty() || answer.starts_with("HTTP/1.1 400"), "{answer}");
    assert_eq!(served.json("/v1/jobs")["jobs"], serde_json::json!([]));
}

#[test]
fn other_media_types_are_refused() {
    let served = Served::start(&["--workers", "0"]);
    let client = reqwest::blocking::Client::builder().no_proxy().build().unwrap();
    let url = format!("http://{}/v1/jobs", served.host());
    for (kind, status) in [
        ("text/plain", 415),
        ("application/x-www-form-urlencoded", 415),
        ("application/jsonp", 415),
        ("Application/JSON; charset=utf-8", 202),
    ] {
        let request = client.post(&url).header("content-type", kind).body(small_job("x").to_string());
        assert_eq!(request.send().unwrap().status(), status, "{kind}");
    }
}

/// A body that begins and does not go on: the connection must not be held for it.
#[test]
fn a_body_that_does_not_come_is_given_up() {
    let served = Served::start(&["--workers", "0"]);
    let id = served.posted(&small_job("x"));
    let begun = |path: &str| {
        let mut stream = TcpStream::connect(served.host()).unwrap();
        let head = format!(
            "PUT {path} HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nContent-Length: 20\r\n\r\n{{"
        );
        stream.write_all(head.as_bytes()).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        stream
    };
    let streams =
        [format!("/v1/jobs/{id}/cancellation"), "/v1/machines/x/hold".to_owned()].map(|p| begun(&p));
    for mut stream in streams {
        let mut answer = [0; 12];
        stream.read_exact(&mut answer).unwrap();
        assert_eq!(&answer, b"HTTP/1.1 408");
    }
    assert_eq!(served.json(&format!("/v1/jobs/{id}"))["state"], "queued");
}

/// The small bodies: every fault with its pointer, whichever address it is.
#[test]
fn a_small_body_with_a_fault_is_a_problem_that_says_where() {
    let served = Served::start(&["--workers", "0"]);
    let id = served.posted(&small_job("x"));
    let cancellation = format!("/v1/jobs/{id}/cancellation");
    let hold = "/v1/machines/x/hold";
    let amendment = "/v1/runs/run_00000000000070008000000000000000/receipt";
    let endless = format!("{{\"reason\": \"{}\"}}", "x".repeat(70_000));
    let cases = [
        (&*cancellation, "{\"reason\"", 400, "invalid_json", Some(("invalid_json", ""))),
        (&*cancellation, "{\"reason\": 1}", 422, "invalid_request", Some(("wrong_type", "/reason"))),
        (&*cancellation, "{\"why\": \"x\"}", 422, "invalid_request", Some(("unknown_field", "/why"))),
        (&*cancellation, &endless, 413, "body_too_large", None),
        (hold, "nonsense", 400, "invalid_json", Some(("invalid_json", ""))),
        (hold, "{}", 422, "invalid_request", Some(("missing_field", ""))),
        (hold, "{\"reason\": 1e400}", 422, "invalid_request", Some(("invalid_number", "/reason"))),
        (amendment, "{\"fence\": \"1\"}", 422, "invalid_request", Some(("wrong_type", "/fence"))),
    ];
    for (path, body, status, code, fault) in cases {
        let body = body.to_owned();
        let request = served.put(path).header("content-type", "application/json").body(body.clone());
        let response = request.send().unwrap();
        assert_eq!(response.headers()["content-type"], "application/problem+json", "{path} {body:.40}");
        assert_eq!(response.status(), status, "{path} {body:.40}");
        let problem: Value = response.json().unwrap();
        assert_eq!(problem["code"], code, "{problem}");
        let found = problem["faults"].get(0).map(|found| (text(found, "code"), text(found, "pointer")));
        assert_eq!(found, fault, "{problem}");
    }
    assert_eq!(served.json(&format!("/v1/jobs/{id}"))["state"], "queued");
}

fn text<'a>(value: &'a Value, field: &str) -> &'a str {
    value[field].as_str().unwrap()
}

/// The tables that have rows, with their number.
fn rows_by_table(database: &Path) -> Vec<(String, i64)> {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    runtime.block_on(async {
        let url = format!("sqlite://{}", database.display());
        let mut connection = SqliteConnection::connect(&url).await.unwrap();
        let tables = "SELECT name FROM sqlite_master WHERE type = 'table' AND name NOT LIKE '\\_sqlx%' ESCAPE '\\' ORDER BY name";
        let mut counts = Vec::new();
        for row in sqlx::query(tables).fetch_all(&mut connection).await.unwrap() {
            let table: String = row.get(0);
            let count = sqlx::AssertSqlSafe(format!("SELECT COUNT(*) FROM {table}"));
            let count: i64 = sqlx::query(count).fetch_one(&mut connection).await.unwrap().get(0);
            counts.push((table, count));
        }
        assert!(counts.len() >= 10, "{counts:?}");
        counts.into_iter().filter(|(_, count)| *count > 0).collect()
    })
}
