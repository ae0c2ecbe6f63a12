//! Honeycomb jobs over a real socket: programs of several files, approval only with a cell, files of a conversion.

use std::io::{Cursor, Read};

use serde_json::{Value, json};
use sha2::{Digest, Sha256};

use crate::honeycomb::arc;
use crate::served::{Served, form};

/// The example with three layers to cut.
pub fn small() -> Value {
    let mut job = arc();
    job["input"]["profile"]["points"] = json!([[0, 36], [85, 36]]);
    job["input"]["plan"] = json!({"lattice": "orthogonal"});
    job
}

#[test]
fn a_program_of_several_files_is_one_archive_that_can_be_approved() {
    let served = Served::start(&[]);
    let id = served.program_of(&small());
    let program = served.json(&format!("/v1/programs/{id}"));
    let files = program["files"].as_array().unwrap();
    assert!(files.len() >= 3, "{program}");
    let content = served.get(&format!("/v1/programs/{id}/content")).send().unwrap().bytes().unwrap();
    let hash: String = Sha256::digest(&content).iter().map(|byte| format!("{byte:02x}")).collect();
    assert_eq!(program["sha256"], hash.as_str());
    let mut archive = zip::ZipArchive::new(Cursor::new(content.to_vec())).unwrap();
    for file in files {
        let mut packed = String::new();
        archive.by_name(file["name"].as_str().unwrap()).unwrap().read_to_string(&mut packed).unwrap();
        assert_eq!(served.get(file["href"].as_str().unwrap()).send().unwrap().text().unwrap(), packed);
    }
    let approval = format!("/v1/programs/{id}/approval");
    assert_eq!(served.call("PUT", &approval, Some(&json!({"sha256": hash})), None).0, 200);

    let job = served.json(&format!("/v1/jobs/{}", program["job"].as_str().unwrap()));
    for name in job["drawings"].as_array().unwrap() {
        let name = name.as_str().unwrap();
        let response =
            served.get(&format!("/v1/jobs/{}/drawings/{name}", job["id"].as_str().unwrap())).send();
        let media = response.unwrap().headers()["content-type"].to_str().unwrap().to_owned();
        let wanted = match name.rsplit('.').next().unwrap() {
            "svg" => "image/svg+xml",
            "csv" => "text/csv; charset=utf-8",
            _ => "text/plain; charset=utf-8",
        };
        assert_eq!(media, wanted, "{name}");
    }
}

#[test]
fn without_a_cell_a_program_cannot_be_approved() {
    let served = Served::start(&[]);
    let mut job = small();
    job["input"].as_object_mut().unwrap().remove("cell");
    let id = served.program_of(&job);
    let sha256 = served.json(&format!("/v1/programs/{id}"))["sha256"].clone();
    let approval = format!("/v1/programs/{id}/approval");
    let (status, problem) = served.call("PUT", &approval, Some(&json!({"sha256": sha256})), None);
    assert_eq!((status, &problem["code"]), (409, &json!("no_machine_checked")), "{problem}");
}

#[test]
fn figures_alone_are_a_usable_answer_without_a_program() {
    let served = Served::start(&[]);
    let job: Value = serde_json::from_str(include_str!("../../examples/honeycomb-optimum.job.json")).unwrap();
    let job = served.ended(&served.posted(&job));
    assert_eq!((&job["state"], &job["verdict"]), (&json!("succeeded"), &json!("usable")), "{job}");
    assert!(job.get("program").is_none_or(Value::is_null));
}

#[test]
fn a_milling_program_comes_in_with_its_job() {
    let served = Served::start(&[]);
    let input = &arc()["input"];
    let job = json!({"kind": "honeycomb-convert", "input": {"krl": {"file": "wave.src"},
        "blank": {"width_mm": 20, "length_mm": 30, "height_mm": 30}, "tool": input["tool"],
        "process": input["process"], "parameters": {"swing_angle_deg": 30}}});
    let wave = include_bytes!("../fixtures/krl/wave.src");
    let posted = served.post_form(form(job.to_string().as_bytes(), &[("wave.src", wave)])).send().unwrap();
    assert_eq!(posted.status(), 202);
    let job = served.ended(&crate::served::id_of(posted));
    assert_eq!(job["state"], "succeeded", "{job}");
    let report = served.json(&format!("/v1/jobs/{}/report", job["id"].as_str().unwrap()));
    assert_eq!(report["kind"], "honeycomb-convert");
    assert!(report["exact"]["tips"].as_u64().unwrap() >= 4, "{report}");
    let alone = served.post(&json!({"kind": "honeycomb-convert", "input": report})).send().unwrap();
    assert_eq!(alone.status(), 422);
}
