//! Programs over a real socket: bytes, hashes, ranges, and what happens when a bit flips.

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use reqwest::blocking::Response;
use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use sqlx::{Connection, SqliteConnection};

use crate::served::{Served, small_job};

fn hex(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

fn header<'a>(response: &'a Response, name: &str) -> &'a str {
    response.headers()[name].to_str().unwrap()
}

#[test]
fn the_content_is_what_its_hash_says() {
    let served = Served::start(&[]);
    let id = served.program_of(&small_job("x"));
    let program = served.json(&format!("/v1/programs/{id}"));
    let response = served.get(&format!("/v1/programs/{id}/content")).send().unwrap();
    assert_eq!(response.status(), 200);
    let sha256 = program["sha256"].as_str().unwrap();
    assert_eq!(header(&response, "etag"), format!("\"{sha256}\""));
    assert_eq!(header(&response, "accept-ranges"), "bytes");
    let name = program["name"].as_str().unwrap();
    assert_eq!(header(&response, "content-disposition"), format!("attachment; filename=\"{name}\""));
    assert_eq!(header(&response, "content-length"), program["bytes"].to_string());
    let digest = header(&response, "repr-digest").to_owned();
    let bytes = response.bytes().unwrap();
    assert_eq!(hex(&bytes), sha256);
    assert_eq!(digest, format!("sha-256=:{}:", BASE64_STANDARD.encode(Sha256::digest(&bytes))));
    let file = served.get(program["files"][0]["href"].as_str().unwrap()).send().unwrap();
    assert_eq!(file.bytes().unwrap(), bytes);
    let other = served.get(&format!("/v1/programs/{id}/files/other.ngc")).send().unwrap();
    assert_eq!(
        (other.status().as_u16(), &other.json::<Value>().unwrap()["code"]),
        (404, &json!("file_not_found"))
    );
    let report = served.json(program["links"]["report"].as_str().unwrap());
    assert_eq!(report["programs"][0]["sha256"], sha256, "the report names the same bytes");
}

#[test]
fn the_same_job_gives_the_same_bytes_in_every_attempt_and_service() {
    let (one, other) = (Served::start(&[]), Served::start(&["--workers", "2"]));
    let content = |served: &Served, name: &str| {
        let id = served.program_of(&small_job(name));
        let job = served.json(&format!("/v1/programs/{id}"))["job"].as_str().unwrap().to_owned();
        let program = served.get(&format!("/v1/programs/{id}/content")).send().unwrap().bytes().unwrap();
        let report = served.get(&format!("/v1/jobs/{job}/report")).send().unwrap().bytes().unwrap();
        (program, report)
    };
    let first = content(&one, "x");
    assert_eq!(content(&one, "x"), first);
    assert_eq!(content(&other, "x"), first);
    assert_eq!(content(&other, "(MSG, hot)"), first, "no text of a sender's reaches a program");
}

#[test]
fn a_transfer_can_be_resumed() {
    let served = Served::start(&[]);
    let id = served.program_of(&small_job("x"));
    let path = format!("/v1/programs/{id}/content");
    let whole = served.get(&path).send().unwrap();
    let etag = header(&whole, "etag").to_owned();
    let whole = whole.bytes().unwrap();
    let length = whole.len();
    let range = |range: &str, if_range: &str| {
        let mut request = served.get(&path).header("range", range);
        if !if_range.is_empty() {
            request = request.header("if-range", if_range);
        }
        request.send().unwrap()
    };
    let rest = range("bytes=100-", &etag);
    assert_eq!(rest.status(), 206);
    assert_eq!(header(&rest, "content-range"), format!("bytes 100-{}/{length}", length - 1));
    assert_eq!(header(&rest, "etag"), etag);
    assert_eq!(rest.bytes().unwrap(), whole[100..]);
    assert_eq!(range("bytes=-7", "").bytes().unwrap(), whole[length - 7..]);
    assert_eq!(range("bytes=0-9", "").bytes().unwrap(), whole[..10]);

    let changed = range("bytes=100-", "\"another\"");
    assert_eq!((changed.status().as_u16(), changed.bytes().unwrap()), (200, whole.clone()));
    let outside = range(&format!("bytes={length}-"), "");
    assert_eq!(outside.status(), 416);
    assert_eq!(header(&outside, "content-range"), format!("bytes */{length}"));
    assert_eq!(outside.json::<Value>().unwrap()["code"], "range_not_satisfiable");
    let known = served.get(&path).header("if-none-match", &etag).send().unwrap();
    assert_eq!(known.status(), 304);
    assert!(known.bytes().unwrap().is_empty());
}

#[test]
fn a_flipped_bit_gives_quarantine_and_never_a_200() {
    let served = Served::start(&[]);
    let id = served.program_of(&small_job("x"));
    let sound = served.program_of(&small_job("y"));
    let path = format!("/v1/programs/{id}/content");
    let etag = header(&served.get(&path).send().unwrap(), "etag").to_owned();
    flip_one_bit(&served.database(), &id);
    // Not even to somebody who has the right bytes already, or who wants a part that is still sound.
    let requests = [
        served.get(&path).header("range", "bytes=0-0"),
        served.get(&path),
        served.get(&path).header("if-none-match", &etag),
        served.get(&format!("/v1/programs/{id}/files/roll.ngc")),
    ];
    for request in requests {
        let response = request.send().unwrap();
        assert_eq!(response.status(), 409);
        assert_eq!(response.json::<Value>().unwrap()["code"], "program_quarantined");
    }
    assert_eq!(served.json(&format!("/v1/programs/{id}"))["state"], "quarantined");
    assert_eq!(served.json("/v1/programs?state=quarantined")["programs"][0]["id"], json!(id));
    assert_eq!(served.get(&format!("/v1/programs/{sound}/content")).send().unwrap().status(), 200);
}

/// What a failing disk does.
pub fn flip_one_bit(database: &std::path::Path, program: &str) {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    runtime.block_on(async {
        let url = format!("sqlite://{}", database.display());
        let mut connection = SqliteConnection::connect(&url).await.unwrap();
        let (mut body,): (Vec<u8>,) = sqlx::query_as("SELECT body FROM program_files WHERE program_id = $1")
            .bind(program)
            .fetch_one(&mut connection)
            .await
            .unwrap();
        let last = body.len() - 1;
        body[last] ^= 1;
        let update =
            sqlx::query("UPDATE program_files SET body = $2 WHERE program_id = $1").bind(program).bind(body);
        assert_eq!(update.execute(&mut connection).await.unwrap().rows_affected(), 1);
    });
}
