//! Jobs with files over a real socket: forms, names, idempotency, what is kept and what becomes of a damaged file.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::sync::Arc;

use reqwest::blocking::Response;
use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use sqlx::{Connection, SqliteConnection};

use crate::served::{PATIENCE, Served, form, id_of, job_with_a_file, small_job};

const OUTLINE: &[u8] = b"0 0 0\r\n0 80 0\r\n400 80 0\n\xff\x00\n400 0 0";

/// Files by name, in the order in which they are sent.
type Sent<'a> = &'a [(&'a str, &'a [u8])];

fn hex(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Status and code of a problem, and code, pointer and words of each of its faults.
fn problem(response: Response) -> (u16, String, Vec<(String, String, String)>) {
    let status = response.status().as_u16();
    assert_eq!(response.headers()["content-type"], "application/problem+json");
    let body: Value = response.json().unwrap();
    let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
    let fault = |fault: &Value| (text(&fault["code"]), text(&fault["pointer"]), text(&fault["detail"]));
    let faults = body["faults"].as_array().into_iter().flatten().map(fault).collect();
    (status, text(&body["code"]), faults)
}

fn bytes(document: &Value) -> Vec<u8> {
    document.to_string().into_bytes()
}

#[test]
fn a_file_comes_in_with_its_job_reaches_the_planner_and_is_given_out_as_it_came() {
    let served = Served::start(&[]);
    let name = "Ply 12_rev-C.txt";
    let document = serde_json::to_vec_pretty(&job_with_a_file(name)).unwrap();
    let response = served.post_form(form(&document, &[(name, OUTLINE)])).send().unwrap();
    assert_eq!(response.status(), 202);
    let posted: Value = response.json().unwrap();
    let id = posted["id"].as_str().unwrap();
    let href = format!("/v1/jobs/{id}/files/Ply%2012_rev-C.txt");
    let files = json!([{"name": name, "sha256": hex(OUTLINE), "bytes": OUTLINE.len(), "href": href}]);
    assert_eq!(posted["files"], files);
    let job = served.ended(id);
    assert_eq!((&job["files"], &served.json("/v1/jobs")["jobs"][0]["files"]), (&files, &files));

    // That the planner has read it is seen by the line that it names.
    assert_eq!(
        (&job["state"], &job["failure"]["code"]),
        (&json!("failed"), &json!("invalid_input")),
        "{job}"
    );
    let finding = &job["failure"]["findings"][0];
    assert_eq!((&finding["code"], &finding["at"]), (&json!("wrong_type"), &json!(format!("{name}:4"))));

    let input = served.get(&format!("/v1/jobs/{id}/input")).send().unwrap();
    assert_eq!(input.bytes().unwrap(), document, "the document is what it was without its files");
    let file = served.get(&href).send().unwrap();
    let header = |name: &str| file.headers()[name].to_str().unwrap().to_owned();
    assert_eq!(header("etag"), format!("\"{}\"", hex(OUTLINE)));
    assert_eq!(header("content-disposition"), format!("attachment; filename=\"{name}\""));
    assert_eq!(header("content-type"), "application/octet-stream");
    assert_eq!(header("x-content-type-options"), "nosniff");
    let etag = header("etag");
    assert_eq!(file.bytes().unwrap(), OUTLINE);
    assert_eq!(served.get(&href).header("if-none-match", &etag).send().unwrap().status(), 304);
    let range = served.get(&href).header("range", "bytes=2-4").send().unwrap();
    assert_eq!((range.status().as_u16(), range.bytes().unwrap().as_ref()), (206, &OUTLINE[2..=4]));
}

/// A rectangle of lines with a round cut-out, in mm, on the layers of ASTM D6673.
const DRAWING: &str = "0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n4\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n\
    0\nLWPOLYLINE\n8\n1\n90\n4\n70\n1\n10\n0\n20\n0\n10\n0\n20\n150\n10\n400\n20\n150\n10\n400\n20\n0\n\
    0\nCIRCLE\n8\n11\n10\n200\n20\n40\n40\n20\n0\nENDSEC\n0\nEOF\n";

#[test]
fn plies_that_come_as_texts_or_as_a_drawing_are_planned() {
    let served = Served::start(&[]);
    let mut job = job_with_a_file("b.txt");
    job["input"]["tape"]["width_mm"] = json!(75);
    job["input"]["tracks"] = json!({"file": "t.txt"});
    job["input"]["holes"] = json!([{"file": "h.txt"}]);
    let texts: Sent = &[
        ("b.txt", b"0 0 0\r\n0 150 0\r\n400 150 0\r\n400 0 0"),
        ("h.txt", b"# a cut-out\n200 20 0\n220 40 0\n200 60 0\n180 40 0\n"),
        (
            "t.txt",
            b"track 1\n0,37.5,0,0,0,1\n400,37.5,0,0,0,1\ntrack 2\n0 112.5 0 0 0 1\n400 112.5 0 0 0 1\n",
        ),
    ];
    let from_texts = id_of(served.post_form(form(&bytes(&job), texts)).send().unwrap());
    job["input"]["boundary"] = json!({"file": "ply.dxf"});
    job["input"].as_object_mut().unwrap().retain(|name, _| name != "tracks" && name != "holes");
    job["input"]["courses"] = json!({"angle_deg": 0});
    let drawing: Sent = &[("ply.dxf", DRAWING.as_bytes())];
    let from_drawing = id_of(served.post_form(form(&bytes(&job), drawing)).send().unwrap());
    for id in [from_texts, from_drawing] {
        let job = served.ended(&id);
        assert_eq!((&job["state"], &job["verdict"]), (&json!("succeeded"), &json!("usable")), "{job}");
    }
}

#[test]
fn each_ply_of_a_roll_may_come_in_files_of_its_own() {
    let served = Served::start(&[]);
    let mut job = job_with_a_file("one.txt");
    let boundary = job["input"].as_object_mut().unwrap().remove("boundary");
    job["input"].as_object_mut().unwrap().retain(|name, _| name != "tracks" && name != "holes");
    job["input"]["tape"]["width_mm"] = json!(75);
    job["input"]["plies"] = json!([
        {"name": "P1", "boundary": boundary, "courses": {"angle_deg": 0}},
        {"name": "P2", "boundary": {"file": "two.dxf"}, "courses": {"angle_deg": 45}}]);
    let one: (&str, &[u8]) = ("one.txt", b"0 0 0\r\n0 150 0\r\n400 150 0\r\n400 0 0");
    let lacking = problem(served.post_form(form(&bytes(&job), &[one])).send().unwrap());
    assert_eq!((lacking.0, lacking.2[0].1.as_str()), (422, "/input/plies/1/boundary/file"));
    let both: Sent = &[one, ("two.dxf", DRAWING.as_bytes())];
    let job = served.ended(&id_of(served.post_form(form(&bytes(&job), both)).send().unwrap()));
    assert_eq!((&job["state"], &job["verdict"]), (&json!("succeeded"), &json!("usable")), "{job}");
}

#[test]
fn what_is_not_there_is_said() {
    let served = Served::start(&["--workers", "0"]);
    let form = form(&bytes(&job_with_a_file("b.txt")), &[("b.txt", OUTLINE)]);
    let id = id_of(served.post_form(form).send().unwrap());
    let plain = served.posted(&small_job("plain"));
    let code = |path: String| problem(served.get(&path).send().unwrap()).1;
    for name in ["c.txt", "B.txt", "..%2Fb.txt", "b.txt%00"] {
        assert_eq!(code(format!("/v1/jobs/{id}/files/{name}")), "file_not_found", "{name}");
    }
    assert_eq!(code(format!("/v1/jobs/{plain}/files/b.txt")), "file_not_found");
    assert_eq!(code("/v1/jobs/job_00000000000070008000000000000000/files/b.txt".into()), "job_not_found");
    assert!(served.json(&format!("/v1/jobs/{plain}")).get("files").is_none());
}

#[test]
fn a_form_without_files_is_the_job_alone() {
    let served = Served::start(&[]);
    let document = bytes(&small_job("alone"));
    let id = id_of(served.post_form(form(&document, &[])).send().unwrap());
    assert_eq!(served.ended(&id)["verdict"], "usable");
    let input = served.get(&format!("/v1/jobs/{id}/input")).send().unwrap();
    assert_eq!(input.bytes().unwrap(), document);
}

#[test]
fn a_file_that_is_named_and_not_sent_or_sent_and_not_named_is_refused_beside_every_other_fault() {
    let served = Served::start(&["--workers", "0"]);
    let mut document = job_with_a_file("boundary.txt");
    document["input"]["machine"] = json!("nowhere");
    let (status, code, faults) =
        problem(served.post_form(form(&bytes(&document), &[("Boundary.txt", OUTLINE)])).send().unwrap());
    let faults: Vec<_> = faults.iter().map(|(code, at, _)| (code.as_str(), at.as_str())).collect();
    assert_eq!((status, code.as_str()), (422, "invalid_job"));
    let expected = [
        ("unknown_file", "/input/boundary/file"),
        ("unused_file", ""),
        ("unknown_machine", "/input/machine"),
    ];
    assert_eq!(faults, expected);
    let (status, _, faults) = problem(served.post(&job_with_a_file("boundary.txt")).send().unwrap());
    assert_eq!((status, faults[0].0.as_str()), (422, "unknown_file"), "JSON alone brings no file");
    assert!(faults[0].2.contains("multipart/form-data"), "{faults:?}");
    assert_eq!(served.json("/v1/jobs")["jobs"], json!([]));
}

#[test]
fn validate_only_looks_at_files_too_and_takes_nothing_in() {
    let served = Served::start(&["--workers", "0"]);
    let document = bytes(&job_with_a_file("b.txt"));
    let ask = |files: &[(&str, &[u8])]| {
        served.post_form_to("/v1/jobs?validate_only=true", form(&document, files)).send().unwrap()
    };
    let sound = ask(&[("b.txt", OUTLINE)]);
    assert_eq!(sound.status(), 200);
    assert_eq!(sound.json::<Value>().unwrap(), json!({"valid": true, "kind": "tape-cut"}));
    assert_eq!(problem(ask(&[])).0, 422);
    assert_eq!(served.json("/v1/jobs")["jobs"], json!([]));
}

#[test]
fn names_that_are_not_plain_are_refused_whatever_they_try() {
    let served = Served::start(&["--workers", "0"]);
    let long = "n".repeat(256);
    let names =
        ["../x", "a/b", "C:\\x", "", "..", ".x", "b\u{e4}r.txt", "\u{202e}txt", "a\tb", "/etc/passwd", &long];
    for name in names {
        let sent =
            served.post_form(form(&bytes(&job_with_a_file("b.txt")), &[(name, OUTLINE)])).send().unwrap();
        let (status, code, faults) = problem(sent);
        assert_eq!((status, code.as_str()), (400, "invalid_multipart"), "{name:?}");
        assert_eq!((faults.len(), faults[0].0.as_str()), (1, "unknown_file"), "{name:?}");
        assert!(faults[0].2.starts_with("part 2: ") && faults[0].2.len() < 300, "{faults:?}");
        // The document may not name it either.
        let (status, code, faults) = problem(served.post(&job_with_a_file(name)).send().unwrap());
        assert_eq!(
            (status, code.as_str(), faults[0].0.as_str()),
            (422, "invalid_job", "unknown_file"),
            "{name:?}"
        );
    }
    let longest = "n".repeat(255);
    let form = form(&bytes(&job_with_a_file(&longest)), &[(&longest, OUTLINE)]);
    let id = id_of(served.post_form(form).send().unwrap());
    let href = served.json(&format!("/v1/jobs/{id}"))["files"][0]["href"].as_str().unwrap().to_owned();
    assert_eq!(served.get(&href).send().unwrap().bytes().unwrap(), OUTLINE);
}

#[test]
fn two_files_of_one_name_no_document_and_two_are_refused() {
    let served = Served::start(&["--workers", "0"]);
    let document = bytes(&job_with_a_file("b.txt"));
    let twice = form(&document, &[("b.txt", OUTLINE), ("b.txt", OUTLINE)]);
    let (status, code, faults) = problem(served.post_form(twice).send().unwrap());
    assert_eq!((status, code.as_str()), (400, "invalid_multipart"));
    assert!(faults[0].2.starts_with("part 3: two files are named"), "{faults:?}");

    let json = |body: &[u8]| {
        let part = reqwest::blocking::multipart::Part::bytes(body.to_vec());
        part.mime_str("application/json").unwrap()
    };
    let none = reqwest::blocking::multipart::Form::new().part("document", json(&document));
    let two = form(&document, &[("b.txt", OUTLINE)]).part("job", json(&document));
    let text = reqwest::blocking::multipart::Form::new().text("job", String::from_utf8(document).unwrap());
    for (form, said) in
        [(none, "no part is named job"), (two, "two parts are named job"), (text, "type=application/json")]
    {
        let response = served.post_form(form).send().unwrap();
        assert_eq!(response.status(), 400);
        let detail = response.json::<Value>().unwrap()["detail"].as_str().unwrap().to_owned();
        assert!(detail.contains(said), "{detail}");
    }
    assert_eq!(served.json("/v1/jobs")["jobs"], json!([]));
    let metrics = served.get("/metrics").send().unwrap().text().unwrap();
    assert!(metrics.contains("bladeplan_posts_refused_total{code=\"invalid_multipart\"} 4"), "{metrics}");
}

#[test]
fn the_same_key_document_and_files_give_one_job_however_the_form_wraps_them() {
    let served = Served::start(&["--workers", "0"]);
    let mut job = job_with_a_file("a.txt");
    job["input"]["holes"] = json!([{"file": "b.txt"}]);
    let document = bytes(&job);
    let post = |document: &[u8], files: &[(&str, &[u8])]| {
        served.post_form(form(document, files)).header("idempotency-key", "mes-1").send().unwrap()
    };
    let first = post(&document, &[("a.txt", b"1"), ("b.txt", b"2")]);
    assert!(!first.headers().contains_key("idempotency-replayed"));
    let id = id_of(first);
    // Another boundary, and another order of the parts.
    let again = post(&document, &[("b.txt", b"2"), ("a.txt", b"1")]);
    assert_eq!(again.headers()["idempotency-replayed"], "true");
    let again: Value = again.json().unwrap();
    assert_eq!((again["id"].as_str(), again["files"].as_array().unwrap().len()), (Some(id.as_str()), 2));

    let spaced = [document.as_slice(), b" "].concat();
    let others: [(&[u8], Sent); 5] = [
        (&document, &[("a.txt", b"1"), ("b.txt", b"3")]),
        (&document, &[("a.txt", b"2"), ("b.txt", b"1")]),
        (&document, &[("a.txt", b"1"), ("c.txt", b"2")]),
        (&document, &[("a.txt", b"1")]),
        (&spaced, &[("a.txt", b"1"), ("b.txt", b"2")]),
    ];
    for (document, files) in others {
        let (status, code, _) = problem(post(document, files));
        assert_eq!((status, code.as_str()), (422, "idempotency_key_reused"), "{files:?}");
    }
    let alone = served.post_bytes(document).header("idempotency-key", "mes-1").send().unwrap();
    assert_eq!(problem(alone).1, "idempotency_key_reused");
    // Without files, a form and the document alone are the same.
    let plain = bytes(&small_job("plain"));
    let posted = served.post_bytes(plain.clone()).header("idempotency-key", "mes-2").send().unwrap();
    let as_form = served.post_form(form(&plain, &[])).header("idempotency-key", "mes-2").send().unwrap();
    assert_eq!(id_of(as_form), id_of(posted));
    assert_eq!(served.json("/v1/jobs")["jobs"].as_array().unwrap().len(), 2);
}

/// A form as bytes, so that a test can cut it off.
fn raw_form(document: &Value, name: &str, file: &[u8]) -> Vec<u8> {
    let job =
        "--XX\r\nContent-Disposition: form-data; name=\"job\"\r\nContent-Type: application/json\r\n\r\n";
    let part = format!("\r\n--XX\r\nContent-Disposition: form-data; name=\"f\"; filename=\"{name}\"\r\n\r\n");
    [job.as_bytes(), &bytes(document), part.as_bytes(), file, b"\r\n--XX--\r\n"].concat()
}

fn post_raw(served: &Served, form: &[u8]) -> Response {
    let client = reqwest::blocking::Client::builder().no_proxy().build().unwrap();
    let request = client.post(format!("http://{}/v1/jobs", served.host()));
    request.header("content-type", "multipart/form-data; boundary=XX").body(form.to_vec()).send().unwrap()
}

#[test]
fn document_and_files_are_bounded_together() {
    const MOST: usize = 1024 * 1024;
    let served = Served::start(&["--max-body-mib", "1", "--workers", "0"]);
    let document = job_with_a_file("b.txt");
    let around = raw_form(&document, "b.txt", b"").len();
    assert_eq!(post_raw(&served, &raw_form(&document, "b.txt", &vec![b'x'; MOST - around])).status(), 202);
    let larger = raw_form(&document, "b.txt", &vec![b'x'; MOST - around + 1]);
    assert_eq!(problem(post_raw(&served, &larger)).1, "body_too_large", "each part alone would do");
}

#[test]
fn a_form_that_ends_too_early_is_refused_and_leaves_nothing() {
    let served = Served::start(&["--workers", "0"]);
    let form = raw_form(&job_with_a_file("b.txt"), "b.txt", OUTLINE);
    // The body is as long as was announced, but the form in it has no end.
    for end in [0, 10, 200, form.len() - "--XX--\r\n".len(), form.len() - "--\r\n".len()] {
        let (status, code, _) = problem(post_raw(&served, &form[..end]));
        assert_eq!((status, code.as_str()), (400, "invalid_multipart"), "{end}");
    }
    // The body is shorter than was announced. A client that has gone away is told nothing.
    let mut stream = TcpStream::connect(served.host()).unwrap();
    let head =
        "POST /v1/jobs HTTP/1.1\r\nHost: localhost\r\nContent-Type: multipart/form-data; boundary=XX\r\n";
    stream.write_all(format!("{head}Content-Length: {}\r\n\r\n", form.len()).as_bytes()).unwrap();
    stream.write_all(&form[..form.len() - 1]).unwrap();
    stream.shutdown(std::net::Shutdown::Write).unwrap();
    let mut answer = String::new();
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    let _ = stream.read_to_string(&mut answer);
    assert!(answer.is_empty() || answer.starts_with("HTTP/1.1 400"), "{answer}");
    assert_eq!(served.json("/v1/jobs")["jobs"], json!([]));
    assert_eq!(post_raw(&served, &form).status(), 202, "the whole one is taken");
}

#[test]
fn a_page_of_another_site_cannot_have_a_browser_post_a_form() {
    let served = Served::start(&["--workers", "0"]);
    let post = || served.post_form(form(&bytes(&small_job("x")), &[]));
    let foreign = post().header("origin", "https://evil.example").send().unwrap();
    assert_eq!(problem(foreign).1, "foreign_page");
    assert_eq!(served.json("/v1/jobs")["jobs"], json!([]));
    let own = format!("http://{}", served.host());
    assert_eq!(post().header("origin", own).send().unwrap().status(), 202);
}

#[test]
fn files_survive_a_kill_and_their_job_is_attempted_with_them() {
    let served = Served::start(&["--workers", "0"]);
    // Its last line is at fault: who says so has read all of it.
    let large = ("7 7 7\n".repeat(499_999) + "seven\n").into_bytes();
    let form = form(&bytes(&job_with_a_file("b.txt")), &[("b.txt", &large)]);
    let id = id_of(served.post_form(form).send().unwrap());
    let served = Served::start_in(served.kill(), &["--workers", "1"]);
    let job = served.ended(&id);
    assert_eq!(job["failure"]["findings"][0]["at"], "b.txt:500000", "{job}");
    let file = served.get(&format!("/v1/jobs/{id}/files/b.txt")).send().unwrap();
    assert_eq!(hex(&file.bytes().unwrap()), hex(&large));
}

#[test]
fn a_file_that_was_damaged_in_the_store_is_neither_planned_nor_given_out() {
    for damage in [
        "UPDATE job_files SET body = X'303030' WHERE name = 'b.txt'",
        "UPDATE job_files SET name = 'c.txt' WHERE name = 'b.txt'",
        "DELETE FROM job_files WHERE name = 'b.txt'",
    ] {
        let served = Served::start(&["--workers", "0"]);
        let form = form(&bytes(&job_with_a_file("b.txt")), &[("b.txt", OUTLINE)]);
        let id = id_of(served.post_form(form).send().unwrap());
        let folder = served.kill();
        execute(&folder.path().join("bladeplan.db"), &[damage]);
        let served = Served::start_in(folder, &["--workers", "1"]);
        let job = served.ended(&id);
        assert_eq!(job["failure"]["code"], "input_damaged", "{damage}: {job}");
        let file = served.get(&format!("/v1/jobs/{id}/files/b.txt")).send().unwrap();
        let code = if damage.contains("body") { "store_damaged" } else { "file_not_found" };
        assert_eq!(problem(file).1, code, "{damage}");
    }
}

#[test]
fn a_store_from_before_there_were_files_is_brought_up_to_date_and_its_jobs_are_planned() {
    let served = Served::start(&["--workers", "0"]);
    let document = bytes(&small_job("old"));
    let post = |served: &Served| {
        id_of(served.post_bytes(document.clone()).header("idempotency-key", "old").send().unwrap())
    };
    let id = post(&served);
    let folder = served.kill();
    let older = [
        "DROP INDEX jobs_dry_run_of",
        "ALTER TABLE jobs DROP COLUMN dry_run_of",
        "ALTER TABLE programs DROP COLUMN purpose",
        "ALTER TABLE programs DROP COLUMN from_course",
        "ALTER TABLE programs DROP COLUMN from_ply",
        "DROP TABLE job_files",
        "ALTER TABLE job_inputs DROP COLUMN files_sha256",
        "DELETE FROM _sqlx_migrations WHERE version >= 7",
    ];
    execute(&folder.path().join("bladeplan.db"), &older);
    let served = Served::start_in(Arc::clone(&folder), &["--workers", "1"]);
    assert_eq!(served.ended(&id)["verdict"], "usable");
    assert_eq!(post(&served), id, "its key is what it was");
    let form = form(&bytes(&job_with_a_file("b.txt")), &[("b.txt", OUTLINE)]);
    assert_eq!(served.post_form(form).send().unwrap().status(), 202);
}

/// What somebody does to a database that nobody serves.
fn execute(database: &Path, statements: &[&'static str]) {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    runtime.block_on(async {
        let url = format!("sqlite://{}", database.display());
        let mut connection = SqliteConnection::connect(&url).await.unwrap();
        for statement in statements {
            sqlx::query(*statement).execute(&mut connection).await.unwrap();
        }
    });
}
