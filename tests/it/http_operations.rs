//! What those who run the service look at, and what protects it.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::Command;

use serde_json::{Value, json};

use crate::served::{PATIENCE, Served, command, id_of, small_job};

#[test]
fn the_checked_in_document_is_the_one_that_is_served() {
    let printed = Command::new(env!("CARGO_BIN_EXE_bladeplan")).arg("openapi").output().unwrap().stdout;
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("openapi/v1.json");
    let checked_in = std::fs::read(&path).unwrap();
    assert!(printed == checked_in, "openapi/v1.json is not what the code says: write it with `make openapi`");
    let served = Served::start(&["--workers", "0"]);
    assert_eq!(served.get("/openapi.json").send().unwrap().bytes().unwrap(), checked_in);
    let document: Value = serde_json::from_slice(&checked_in).unwrap();
    assert_eq!(document["openapi"], "3.1.0");
    assert_eq!(references_to_nothing(&document, &document), Vec::<String>::new());
}

#[test]
fn the_documentation_is_browsable_offline() {
    let served = Served::start(&["--workers", "0"]);
    let page = served.get("/docs").send().unwrap();
    assert_eq!(page.status(), 200);
    let page = page.text().unwrap();
    assert!(!page.contains("//unpkg") && !page.contains("https://"), "{page}");
    for file in ["swagger-ui.css", "swagger-ui-bundle.js", "swagger-initializer.js"] {
        assert_eq!(served.get(&format!("/docs/{file}")).send().unwrap().status(), 200, "{file}");
    }
    assert!(
        served.get("/docs/swagger-initializer.js").send().unwrap().text().unwrap().contains("/openapi.json")
    );
}

#[test]
fn it_says_that_it_lives_and_what_it_is() {
    let served = Served::start(&["--workers", "0"]);
    assert_eq!(served.get("/livez").send().unwrap().status(), 200);
    assert_eq!(served.get("/readyz").send().unwrap().status(), 200);
    let version = served.json("/version");
    assert_eq!(
        (&version["name"], &version["version"]),
        (&json!("bladeplan"), &json!(env!("CARGO_PKG_VERSION")))
    );
    let metrics = served.get("/metrics").send().unwrap().text().unwrap();
    assert!(metrics.contains("bladeplan_jobs{state=\"queued\"} 0"), "{metrics}");
    assert!(
        metrics.contains("bladeplan_http_requests_total{route=\"/livez\",method=\"GET\",status=\"200\"} 1")
    );
}

#[test]
fn with_keys_the_page_says_what_to_do_and_shows_nothing() {
    let served = Served::start(&["--workers", "0"]);
    served.posted(&small_job("a secret name"));
    served.key("engineer", "erika", None);
    let page = served.get("/").send().unwrap().text().unwrap();
    for words in ["<b>Authorize</b>", "Authorization: Bearer KEY", "bladeplan key create --role engineer"] {
        assert!(page.contains(words), "{words}: {page}");
    }
    let shown = ["a secret name", "job_", "queued", "/v1/jobs\"", "<form", "<script"];
    assert!(shown.iter().all(|words| !page.contains(words)), "{page}");
}

#[test]
fn the_page_shows_the_jobs_and_no_text_of_theirs_becomes_markup() {
    let served = Served::start(&["--workers", "0"]);
    assert!(served.get("/").send().unwrap().text().unwrap().contains("No job yet"));
    let id = served.posted(&small_job("<script>alert(1)</script>"));
    let response = served.get("/").send().unwrap();
    assert!(response.headers()["content-security-policy"].to_str().unwrap().contains("default-src 'none'"));
    let page = response.text().unwrap();
    assert!(page.contains(&format!("href=\"/v1/jobs/{id}\"")), "{page}");
    assert!(!page.contains("<script"), "{page}");
    served.key("engineer", "erika", None);
    let page = served.get("/").send().unwrap().text().unwrap();
    assert!(
        !page.contains(&id) && !page.contains("alert"),
        "once there are keys, a browser without one sees no job: {page}"
    );
}

#[test]
fn an_address_or_method_that_is_not_there_is_a_problem_too() {
    let served = Served::start(&["--workers", "0"]);
    for path in ["/nothing", "/v1", "/v1/jobs/", "/docs/nothing"] {
        let response = served.get(path).send().unwrap();
        assert_eq!(response.status(), 404, "{path}");
    }
    assert_eq!(served.get("/nothing").send().unwrap().json::<Value>().unwrap()["code"], "not_found");
    // An address that is no text names nothing.
    for path in ["/v1/jobs/%FF", "/v1/runs/%FF", "/v1/machines/%FF/next", "/v1/queues/%FF/entries"] {
        let response = served.get(path).send().unwrap();
        assert_eq!(response.headers()["content-type"], "application/problem+json", "{path}");
        assert_eq!(response.json::<Value>().unwrap()["code"], "not_found", "{path}");
    }
    let response = served.put("/v1/jobs").send().unwrap();
    let mut allowed: Vec<&str> = response.headers()["allow"].to_str().unwrap().split(',').collect();
    allowed.sort_unstable();
    assert_eq!((response.status().as_u16(), allowed), (405, vec!["GET", "HEAD", "POST"]));
    assert_eq!(response.json::<Value>().unwrap()["code"], "method_not_allowed");
}

#[test]
fn a_page_with_a_name_of_its_own_does_not_reach_the_service() {
    let served = Served::start(&["--workers", "0"]);
    let status = |served: &Served, host: &str| {
        served.get("/v1/jobs").header("host", host).send().unwrap().status().as_u16()
    };
    assert_eq!(status(&served, "rebound.example:8080"), 421);
    assert_eq!(status(&served, "localhost:8080"), 200);
    // A proxy in front has a name of its own, and then there are keys.
    let key = served.key("engineer", "erika", None);
    let proxied = Served::start_in(served.kill(), &["--workers", "0", "--behind-tls"]);
    assert_eq!(status(&proxied, "plans.example"), 401);
    let request = proxied.get("/v1/jobs").header("host", "plans.example").bearer_auth(key);
    assert_eq!(request.send().unwrap().status(), 200);
}

#[test]
fn a_connection_whose_header_does_not_come_is_dropped() {
    let served = Served::start(&["--workers", "0"]);
    let mut stream = TcpStream::connect(served.host()).unwrap();
    stream.write_all(b"GET /livez HTTP/1.1\r\nHost: localhost\r\nX-Slow: ").unwrap();
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    let mut answer = Vec::new();
    // The end comes as an end or as a reset, before the patience is over.
    if let Err(error) = stream.read_to_end(&mut answer) {
        assert_eq!(error.kind(), std::io::ErrorKind::ConnectionReset);
    }
    assert!(!answer.starts_with(b"HTTP/1.1 200"));
}

#[test]
fn a_client_that_does_not_take_its_answer_is_dropped() {
    let served = Served::start(&["--workers", "0", "--max-connections", "1"]);
    // More than the buffers of both ends hold.
    let mut document = small_job("x").to_string().into_bytes();
    document.resize(32 * 1024 * 1024, b' ');
    let id = id_of(served.post_bytes(document).send().unwrap());
    let mut stream = TcpStream::connect(served.host()).unwrap();
    write!(stream, "GET /v1/jobs/{id}/input HTTP/1.1\r\nHost: localhost\r\n\r\n").unwrap();
    // The answer has begun, so the connection holds the only place.
    stream.read_exact(&mut [0; 12]).unwrap();
    assert_eq!(served.get("/livez").send().unwrap().status(), 200, "the next one has it at last");
}

#[test]
fn two_services_on_one_store_are_refused_in_words() {
    let served = Served::start(&["--workers", "0"]);
    let second = command(served.folder().path(), &[]).output().unwrap();
    assert!(!second.status.success());
    let words = String::from_utf8(second.stderr).unwrap();
    assert!(words.contains("another bladeplan serves"), "{words}");
}

#[test]
fn beyond_loopback_is_refused_in_words() {
    let folder = tempfile::TempDir::new().unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_bladeplan"))
        .args(["serve", "--listen", "0.0.0.0:0", "--database"])
        .arg(folder.path().join("x.db"))
        .output()
        .unwrap();
    assert!(!output.status.success());
    let words = String::from_utf8(output.stderr).unwrap();
    assert!(words.contains("refusing to listen on 0.0.0.0:0"), "{words}");
}

/// Every `$ref` that leads nowhere.
fn references_to_nothing(value: &Value, document: &Value) -> Vec<String> {
    match value {
        Value::Object(map) => {
            let broken = map
                .get("$ref")
                .and_then(Value::as_str)
                .filter(|at| document.pointer(at.trim_start_matches('#')).is_none());
            let here = broken.map(str::to_owned);
            here.into_iter().chain(map.values().flat_map(|v| references_to_nothing(v, document))).collect()
        }
        Value::Array(items) => items.iter().flat_map(|v| references_to_nothing(v, document)).collect(),
        _ => Vec::new(),
    }
}
