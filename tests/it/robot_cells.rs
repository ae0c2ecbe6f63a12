//! Robot cells as machines over a real socket: registered, named by jobs, given their programs and no others; and arms
//! that come in files.

use std::fs;
use std::io::{Cursor, Read};
use std::path::Path;
use std::process::Command;

use rstest::rstest;
use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use tempfile::TempDir;

use crate::http_honeycomb::small;
use crate::served::{Served, form, id_of, small_job};
use crate::shop_floor::profile;

/// What registers the cell of the example job.
fn registration() -> Value {
    serde_json::from_str(include_str!("../../examples/kr210-lab.machine.json")).unwrap()
}

/// A small core for a cell that it names.
fn core_for(cell: &str) -> Value {
    let mut job = small();
    job["input"]["cell"] = json!(cell);
    job
}

fn an_arm() -> Value {
    serde_json::from_str(include_str!("../../src/planning/robot/arms/kr210-r3100-2.json")).unwrap()
}

/// Files by name.
type Sent<'a> = &'a [(&'a str, &'a [u8])];

struct Floor(Served);

impl Floor {
    /// A service with the cell of the example.
    fn new() -> Self {
        let floor = Self(Served::start(&[]));
        floor.register(&registration());
        floor
    }

    fn register(&self, registration: &Value) {
        let (status, answer) = self.call("POST", "/v1/machines", registration);
        assert_eq!(status, 201, "{answer}");
    }

    fn call(&self, method: &str, path: &str, body: &Value) -> (u16, Value) {
        self.0.call(method, path, Some(body), None)
    }

    /// A program that was planned and approved.
    fn approved(&self, job: &Value) -> String {
        let program = self.0.program_of(job);
        let path = format!("/v1/programs/{program}");
        let body = json!({"sha256": self.0.json(&path)["sha256"]});
        assert_eq!(self.call("PUT", &format!("{path}/approval"), &body).0, 200);
        program
    }

    fn enqueue(&self, queue: &str, program: &str) -> (u16, Value) {
        let body = json!({"program": program, "quantity": 1});
        self.call("POST", &format!("/v1/queues/{queue}/entries"), &body)
    }

    fn claim(&self, machine: &str, request_id: &str) -> (u16, Value) {
        self.call("POST", &format!("/v1/machines/{machine}/runs"), &json!({"request_id": request_id}))
    }

    fn report_of(&self, program: &str) -> Value {
        let job = self.0.json(&format!("/v1/programs/{program}"))["job"].clone();
        self.0.json(&format!("/v1/jobs/{}/report", job.as_str().unwrap()))
    }
}

fn put(floor: &Floor, run: &Value, what: &str, body: Value) -> (u16, Value) {
    floor.call("PUT", &format!("{}/{what}", run["links"]["self"].as_str().unwrap()), &body)
}

#[test]
fn a_core_goes_from_its_cell_s_queue_to_done() {
    let floor = Floor::new();
    let program = floor.approved(&core_for("kr210-lab"));
    assert_eq!(floor.report_of(&program)["machine"]["name"], "kr210-lab");
    let (status, entry) = floor.enqueue("kr210-lab", &program);
    assert_eq!(status, 201, "{entry}");
    let (status, run) = floor.claim("kr210-lab", "r1");
    assert_eq!(status, 201, "{run}");

    let content = floor.0.get(run["links"]["content"].as_str().unwrap()).send().unwrap();
    assert_eq!(content.headers()["content-type"], "application/zip");
    let bytes = content.bytes().unwrap().to_vec();
    let sha256: String = Sha256::digest(&bytes).iter().map(|byte| format!("{byte:02x}")).collect();
    assert_eq!((&run["sha256"], &run["size"]), (&json!(sha256), &json!(bytes.len())));
    let mut archive = zip::ZipArchive::new(Cursor::new(bytes)).unwrap();
    let names: Vec<String> = archive.file_names().map(|name| name.unwrap().into_owned()).collect();
    assert!(names.iter().any(|name| name.ends_with(".src")), "{names:?}");
    assert!(names.iter().any(|name| name.ends_with(".dat")), "{names:?}");
    let main = names.iter().find(|name| name.ends_with(".src")).unwrap();
    let mut text = String::new();
    archive.by_name(main).unwrap().read_to_string(&mut text).unwrap();
    assert!(!text.contains("kr210-lab"), "no name of a machine stands in a program");

    let early = put(&floor, &run, "start", json!({"fence": run["fence"]}));
    assert_eq!(early.0, 409, "nothing starts without its receipt: {}", early.1);
    let receipt = json!({"fence": run["fence"], "sha256": sha256, "size": run["size"]});
    assert_eq!(put(&floor, &run, "receipt", receipt).0, 200);
    let (status, started) = put(&floor, &run, "start", json!({"fence": run["fence"]}));
    assert_eq!((status, &started["state"]), (200, &json!("running")), "{started}");
    let (status, done) = put(&floor, &run, "result", json!({"fence": run["fence"], "outcome": "done"}));
    assert_eq!((status, &done["state"]), (200, &json!("done")), "{done}");
    assert_eq!(floor.0.json(entry["links"]["self"].as_str().unwrap())["state"], "finished");
    let trail = floor.0.get("/v1/audit?limit=1000").send().unwrap().text().unwrap();
    let registered = trail.lines().find(|line| line.contains("machine.registered")).unwrap();
    assert!(registered.contains(r#""kind":"robot-cell""#), "{registered}");
}

#[test]
fn the_same_cell_in_full_in_a_file_or_by_name_is_the_same_machine() {
    let floor = Floor::new();
    let inline = floor.approved(&small());
    assert_eq!(floor.enqueue("kr210-lab", &inline).0, 201, "the job of the example has this very cell");
    let mut job = small();
    job["input"]["cell"]["robot"] = json!({"file": "my-arm.json"});
    let arm = serde_json::to_vec_pretty(&an_arm()).unwrap();
    let posted =
        floor.0.post_form(form(job.to_string().as_bytes(), &[("my-arm.json", &arm)])).send().unwrap();
    assert_eq!(posted.status(), 202);
    let ended = floor.0.ended(&id_of(posted));
    assert_eq!(ended["verdict"], "usable", "{ended}");
    let from_file = ended["program"].as_str().unwrap();
    let hash = |program: &str| floor.report_of(program)["machine"]["profile_sha256"].clone();
    assert_eq!(hash(from_file), hash(&inline));
    assert_eq!(floor.enqueue("kr210-lab", from_file).0, 201);

    // An arm that is slower in one joint is another machine, by whatever name it goes.
    let mut slower = an_arm();
    slower["joints"][0]["max_speed_deg_s"] = json!(104);
    job["input"]["cell"]["robot"] = slower;
    let other = floor.0.program_of(&job);
    let (status, problem) = floor.enqueue("kr210-lab", &other);
    assert_eq!((status, &problem["code"]), (409, &json!("profile_mismatch")), "{problem}");
}

#[test]
fn a_cell_that_has_changed_gets_nothing_that_was_planned_before() {
    let floor = Floor::new();
    let before = floor.approved(&core_for("kr210-lab"));
    assert_eq!(floor.enqueue("kr210-lab", &before).0, 201);
    let (status, run) = floor.claim("kr210-lab", "r1");
    assert_eq!(status, 201, "{run}");

    let mut moved = registration();
    moved["profile"]["base_frame"]["z_mm"] = json!(805);
    let (status, machine) = floor.call("PATCH", "/v1/machines/kr210-lab", &moved);
    assert_eq!((status, &machine["profile"]["base_frame"]["z_mm"]), (200, &json!(805.0)), "{machine}");
    let receipt = json!({"fence": run["fence"], "sha256": run["sha256"], "size": run["size"]});
    assert_eq!(put(&floor, &run, "receipt", receipt).0, 200);
    let (status, problem) = put(&floor, &run, "start", json!({"fence": run["fence"]}));
    assert_eq!((status, &problem["code"]), (409, &json!("profile_mismatch")), "{problem}");
    let aborted = put(&floor, &run, "result", json!({"fence": run["fence"], "outcome": "aborted"}));
    assert_eq!(aborted.0, 200, "{}", aborted.1);
    assert_eq!(floor.claim("kr210-lab", "r2").0, 204, "its entry waits for a machine that is no more");
    assert_eq!(floor.enqueue("kr210-lab", &before).1["code"], "profile_mismatch");

    let after = floor.approved(&core_for("kr210-lab"));
    let (old, new) = (floor.report_of(&before), floor.report_of(&after));
    assert_ne!(old["input_sha256"], new["input_sha256"], "what a name stands for is a part of the input");
    assert_ne!(old["programs"][0]["name"], new["programs"][0]["name"], "so both can lie on one control");
    assert_eq!(floor.enqueue("kr210-lab", &after).0, 201);
    assert_eq!(floor.claim("kr210-lab", "r3").1["program"], json!(after));
}

#[test]
fn plies_and_cores_share_a_pool_and_each_machine_gets_its_own() {
    let floor = Floor(Served::start(&[]));
    let pool = |mut registration: Value| {
        registration["pool"] = json!("hall-2");
        floor.register(&registration);
    };
    pool(registration());
    pool(json!({"profile": profile("cutter-1")}));
    let (core, ply) = (floor.approved(&core_for("kr210-lab")), floor.approved(&small_job("x")));
    for (queue, program) in [("cutter-1", &core), ("kr210-lab", &ply)] {
        let (status, problem) = floor.enqueue(queue, program);
        assert_eq!((status, &problem["code"]), (409, &json!("profile_mismatch")), "{queue}");
    }
    for program in [&core, &ply] {
        assert_eq!(floor.enqueue("hall-2", program).0, 201);
    }
    assert_eq!(floor.claim("cutter-1", "r1").1["program"], json!(ply), "though the core waits before it");
    assert_eq!(floor.claim("kr210-lab", "r1").1["program"], json!(core));
}

#[test]
fn a_job_for_a_machine_of_the_other_kind_or_of_none_is_refused_in_words() {
    let floor = Floor::new();
    let mut ply = small_job("x");
    ply["input"]["machine"] = json!("kr210-lab");
    let milling = json!({"kind": "honeycomb-convert", "input": {"krl": {"file": "wave.src"},
        "blank": {"width_mm": 20, "length_mm": 30, "height_mm": 30}, "tool": small()["input"]["tool"],
        "process": small()["input"]["process"], "parameters": {"swing_angle_deg": 30},
        "cell": "two-cutter-lab"}});
    let wave: &[u8] = include_bytes!("../fixtures/krl/wave.src");
    let cases: [(&Value, Sent, &str, &str, &str); 4] = [
        (&ply, &[], "wrong_machine", "/input/machine", "is a robot cell; this job needs a tape cutter"),
        (&core_for("two-cutter-lab"), &[], "wrong_machine", "/input/cell", "is a tape cutter"),
        (&milling, &[("wave.src", wave)], "wrong_machine", "/input/cell", "needs a robot cell"),
        (&core_for("kr210-hall"), &[], "unknown_machine", "/input/cell", "known: kr210-lab"),
    ];
    for (job, files, code, pointer, words) in cases {
        let sent = floor.0.post_form(form(job.to_string().as_bytes(), files)).send().unwrap();
        assert_eq!(sent.status(), 422, "{job}");
        let problem: Value = sent.json().unwrap();
        let faults = problem["faults"].as_array().unwrap();
        assert_eq!(faults.len(), 1, "{problem}");
        assert_eq!((&faults[0]["code"], &faults[0]["pointer"]), (&json!(code), &json!(pointer)));
        assert!(faults[0]["detail"].as_str().unwrap().contains(words), "{problem}");
    }
}

#[rstest]
#[case::arm_in_a_file("/robot", json!({"file": "my-arm.json"}), "unknown_file", "/profile/robot/file")]
#[case::unknown_arm("/robot", json!("kr6"), "unknown_machine", "/profile/robot")]
#[case::no_arm("/robot", json!(null), "wrong_type", "/profile/robot")]
#[case::home("/home_deg/1", json!(10), "out_of_range", "/profile/home_deg/1")]
#[case::frame("/base_frame/x_mm", json!(1e9), "out_of_range", "/profile/base_frame/x_mm")]
#[case::lines("/max_program_lines", json!(99), "out_of_range", "/profile/max_program_lines")]
#[case::direction("/tool_direction", json!("y"), "unknown_value", "/profile/tool_direction")]
#[case::kind("/kind", json!("robot"), "unknown_value", "/profile/kind")]
#[case::name("/name", json!(7), "wrong_type", "/profile/name")]
fn a_faulty_cell_is_refused_with_its_place(
    #[case] field: &str,
    #[case] value: Value,
    #[case] code: &str,
    #[case] pointer: &str,
) {
    let floor = Floor(Served::start(&["--workers", "0"]));
    let mut faulty = registration();
    *faulty["profile"].pointer_mut(field).unwrap() = value;
    let (status, problem) = floor.call("POST", "/v1/machines", &faulty);
    assert_eq!((status, &problem["code"]), (422, &json!("invalid_request")), "{problem}");
    let faults = problem["faults"].as_array().unwrap();
    let found: Vec<_> = faults.iter().map(|fault| (&fault["code"], &fault["pointer"])).collect();
    assert_eq!(found, [(&json!(code), &json!(pointer))], "{problem}");
    floor.register(&registration());
    assert_eq!(floor.call("PATCH", "/v1/machines/kr210-lab", &faulty).0, 422);
    assert_eq!(floor.0.json("/v1/machines")["machines"].as_array().unwrap().len(), 1);
}

#[test]
fn a_cell_needs_a_name_that_is_plain_and_free() {
    let floor = Floor::new();
    let again = floor.call("POST", "/v1/machines", &registration());
    assert_eq!((again.0, &again.1["code"]), (409, &json!("machine_exists")));
    for (name, status, code) in [
        ("../x", 422, "invalid_request"),
        ("", 422, "invalid_request"),
        ("two-cutter-lab", 409, "machine_exists"),
    ] {
        let mut named = registration();
        named["profile"]["name"] = json!(name);
        let (found, problem) = floor.call("POST", "/v1/machines", &named);
        assert_eq!((found, &problem["code"]), (status, &json!(code)), "{name:?}: {problem}");
    }
    let mut renamed = registration();
    renamed["profile"]["name"] = json!("kr210-hall");
    assert_eq!(floor.call("PATCH", "/v1/machines/kr210-lab", &renamed).0, 422);
}

#[test]
fn an_arm_in_a_file_comes_with_its_job_and_its_faults_are_named_within_it() {
    let served = Served::start(&[]);
    let mut job = small();
    job["input"]["cell"]["robot"] = json!({"file": "my-arm.json"});
    let alone = served.post(&job).send().unwrap();
    assert_eq!(alone.status(), 422);
    let problem: Value = alone.json().unwrap();
    assert_eq!(problem["faults"][0]["code"], "unknown_file");
    assert_eq!(problem["faults"][0]["pointer"], "/input/cell/robot/file");

    let mut arm = an_arm();
    arm["joints"][4]["max_speed_deg_s"] = json!(0);
    arm["geometry"].as_object_mut().unwrap().remove("c4_mm");
    let sent = form(job.to_string().as_bytes(), &[("my-arm.json", arm.to_string().as_bytes())]);
    let ended = served.ended(&id_of(served.post_form(sent).send().unwrap()));
    assert_eq!((&ended["state"], &ended["failure"]["code"]), (&json!("failed"), &json!("invalid_input")));
    let findings = ended["failure"]["findings"].as_array().unwrap();
    let found: Vec<_> = findings.iter().map(|finding| (&finding["code"], &finding["at"])).collect();
    let expected = [
        (&json!("missing_field"), &json!("my-arm.json#/geometry/c4_mm")),
        (&json!("out_of_range"), &json!("my-arm.json#/joints/4/max_speed_deg_s")),
    ];
    assert_eq!(found, expected, "{ended}");
}

/// What `bladeplan plan` says of a job in a folder: its exit code and its standard error.
fn planned_in(folder: &Path, job: &Value) -> (i32, String) {
    fs::write(folder.join("core.json"), job.to_string()).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_bladeplan"));
    command.arg("plan").arg(folder.join("core.json")).arg("--out").arg(folder.join("out"));
    let output = command.output().unwrap();
    (output.status.code().unwrap(), String::from_utf8(output.stderr).unwrap())
}

#[test]
fn on_the_command_line_an_arm_lies_beside_its_job() {
    let folder = TempDir::new().unwrap();
    let mut job = small();
    job["input"]["cell"]["robot"] = json!({"file": "my-arm.json"});
    let (code, said) = planned_in(folder.path(), &job);
    assert_eq!(code, 2, "{said}");
    assert!(said.contains("/input/cell/robot/file") && said.contains("beside the job"), "{said}");

    let mut faulty = an_arm();
    faulty["joints"][0]["min_deg"] = json!(190);
    fs::write(folder.path().join("my-arm.json"), faulty.to_string()).unwrap();
    let (code, said) = planned_in(folder.path(), &job);
    assert_eq!(code, 2, "{said}");
    assert!(said.contains("my-arm.json#/joints/0/min_deg"), "{said}");
    assert!(!folder.path().join("out").exists());

    fs::write(folder.path().join("my-arm.json"), an_arm().to_string()).unwrap();
    let (code, said) = planned_in(folder.path(), &job);
    assert_eq!(code, 0, "{said}");
    let report: Value =
        serde_json::from_slice(&fs::read(folder.path().join("out/report.json")).unwrap()).unwrap();
    assert_eq!(report["robot"]["reachable"], true, "{report}");

    job["input"]["cell"] = json!("kr210-lab");
    let (code, said) = planned_in(folder.path(), &job);
    assert_eq!(code, 2, "the command line knows no registered machines: {said}");
    assert!(said.contains("/input/cell") && said.contains("registered first"), "{said}");
}
