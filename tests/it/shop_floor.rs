//! Keys, machines, approval and the audit trail, over a real socket.

use serde_json::{Value, json};
use sqlx::{Connection, SqliteConnection};

use crate::served::{Served, small_job};

/// A profile of one's own: the built-in one under another name.
pub fn profile(name: &str) -> Value {
    let text = include_str!("../../src/planning/tape/two-cutter-lab.json");
    let mut profile: Value = serde_json::from_str(text).unwrap();
    profile["name"] = json!(name);
    profile
}

/// Changes the store behind the service's back.
pub fn execute(served: &Served, statement: &'static str) {
    let url = format!("sqlite:{}", served.database().display());
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    runtime.block_on(async {
        let mut connection = SqliteConnection::connect(&url).await.unwrap();
        sqlx::query(statement).execute(&mut connection).await.unwrap();
        connection.close().await.unwrap();
    });
}

#[test]
fn from_the_first_key_on_every_request_needs_one() {
    let served = Served::start(&[]);
    assert_eq!(served.call("GET", "/v1/jobs", None, None).0, 200, "without keys this machine's people may");
    let engineer = served.key("engineer", "erika", None);
    let (status, problem) = served.call("GET", "/v1/jobs", None, None);
    assert_eq!((status, &problem["code"]), (401, &json!("unauthorized")));
    assert_eq!(served.call("GET", "/v1/jobs", None, Some(&engineer)).0, 200);
    for open in ["/livez", "/readyz", "/version", "/openapi.json"] {
        assert_eq!(served.call("GET", open, None, None).0, 200, "{open}");
    }
    let mut other = engineer.clone();
    let last = if other.pop() == Some('0') { '1' } else { '0' };
    other.push(last);
    let id = engineer.split('.').next().unwrap();
    for wrong in [other.as_str(), id, "", "nonsense", "key_00000000000000000000000000000000.00"] {
        assert_eq!(served.call("GET", "/v1/jobs", None, Some(wrong)).0, 401, "{wrong}");
    }
}

#[test]
fn a_role_does_its_own_work_only() {
    let served = Served::start(&[]);
    let program = served.program_of(&small_job("x"));
    let sha256 = served.json(&format!("/v1/programs/{program}"))["sha256"].clone();
    let path = format!("/v1/programs/{program}/approval");
    let body = json!({"sha256": sha256});
    for (role, expected) in
        [("mes", 403), ("engineer", 403), ("operator", 403), ("auditor", 403), ("approver", 200)]
    {
        let key = served.key(role, role, None);
        let (status, answer) = served.call("PUT", &path, Some(&body), Some(&key));
        assert_eq!(status, expected, "{role}: {answer}");
    }
    let auditor = served.key("auditor", "rosa", None);
    let (status, problem) = served.call("POST", "/v1/jobs", Some(&small_job("y")), Some(&auditor));
    assert_eq!((status, &problem["code"]), (403, &json!("forbidden")));
}

#[test]
fn a_secret_is_nowhere_in_the_store_and_a_revoked_key_opens_nothing() {
    let served = Served::start(&[]);
    let key = served.key("engineer", "erika", None);
    let admin = served.key("admin", "anna", None);
    let secret = key.split('.').nth(1).unwrap();
    for file in std::fs::read_dir(served.folder().path()).unwrap() {
        let bytes = std::fs::read(file.unwrap().path()).unwrap();
        assert!(!bytes.windows(secret.len()).any(|part| part == secret.as_bytes()));
    }
    let mut revoke = std::process::Command::new(env!("CARGO_BIN_EXE_bladeplan"));
    revoke.args(["key", "revoke", "erika", "--database"]).arg(served.database());
    assert!(revoke.status().unwrap().success());
    assert_eq!(served.call("GET", "/v1/jobs", None, Some(&key)).0, 401);
    assert_eq!(served.call("GET", "/v1/jobs", None, Some(&admin)).0, 200);
}

#[test]
fn beyond_loopback_nothing_starts_without_keys() {
    let folder = tempfile::TempDir::new().unwrap();
    let mut serve = std::process::Command::new(env!("CARGO_BIN_EXE_bladeplan"));
    serve.args(["serve", "--listen", "0.0.0.0:0", "--database"]).arg(folder.path().join("bladeplan.db"));
    let words = String::from_utf8(serve.output().unwrap().stderr).unwrap();
    assert!(words.contains("key create"), "{words}");
}

#[test]
fn a_registered_machine_can_be_named_and_a_job_freezes_it() {
    let served = Served::start(&[]);
    let mut job = small_job("x");
    job["input"]["machine"] = json!("cutter-3");
    assert_eq!(served.call("POST", "/v1/jobs", Some(&job), None).0, 422, "it is not registered yet");
    let registration = json!({"profile": profile("cutter-3"), "pool": "hall-2"});
    assert_eq!(served.call("POST", "/v1/machines", Some(&registration), None).0, 201);
    let (status, problem) = served.call("POST", "/v1/machines", Some(&registration), None);
    assert_eq!((status, &problem["code"]), (409, &json!("machine_exists")));
    served.program_of(&job);
    let content = |program: &str| {
        served.get(&format!("/v1/programs/{program}/content")).send().unwrap().text().unwrap()
    };
    let first = content(&served.program_of(&job));
    let mut slower = registration.clone();
    slower["profile"]["feed"]["max_speed_mm_s"] = json!(100);
    assert_eq!(served.call("PATCH", "/v1/machines/cutter-3", Some(&slower), None).0, 200);
    assert_ne!(content(&served.program_of(&job)), first, "a new job is planned for the machine as it is now");
}

#[test]
fn a_change_of_a_machine_leaves_what_it_does_not_name() {
    let served = Served::start(&["--workers", "0"]);
    let registration = json!({"profile": profile("cutter-3"), "pool": "hall-2"});
    assert_eq!(served.call("POST", "/v1/machines", Some(&registration), None).0, 201);
    let change = |body: Value| served.call("PATCH", "/v1/machines/cutter-3", Some(&body), None);
    let mut slower = profile("cutter-3");
    slower["feed"]["max_speed_mm_s"] = json!(100);
    let changes = [
        (json!({"profile": slower}), Some(json!("hall-2"))),
        (json!({"pool": "hall-3"}), Some(json!("hall-3"))),
        (json!({"pool": null}), None),
    ];
    for (body, pool) in changes {
        let (status, machine) = change(body.clone());
        assert_eq!((status, machine.get("pool")), (200, pool.as_ref()), "{body}");
        assert_eq!(machine["profile"]["feed"]["max_speed_mm_s"], 100.0, "{body}");
    }
    for faulty in [json!({"profile": profile("cutter-4")}), json!({"pool": "hall 2"}), json!({"name": "x"})] {
        assert_eq!(change(faulty.clone()).0, 422, "{faulty}");
    }
    let trail = served.get("/v1/audit").send().unwrap().text().unwrap();
    assert!(trail.lines().last().unwrap().contains(r#""detail":{"pool":null}"#), "{trail}");
}

#[test]
fn a_faulty_profile_is_refused_with_every_pointer() {
    let served = Served::start(&[]);
    let mut faulty = profile("cutter-3");
    faulty["feed"]["max_speed_mm_s"] = json!(0);
    faulty["cutters"][0]["blade"]["speed"] = json!(1);
    let (status, problem) = served.call("POST", "/v1/machines", Some(&json!({"profile": faulty})), None);
    assert_eq!((status, &problem["code"]), (422, &json!("invalid_request")));
    let mut pointers: Vec<_> =
        problem["faults"].as_array().unwrap().iter().map(|f| f["pointer"].clone()).collect();
    pointers.sort_by_key(ToString::to_string);
    assert_eq!(pointers, ["/profile/cutters/0/blade/speed", "/profile/feed/max_speed_mm_s"]);
    let (status, _) = served.call("POST", "/v1/machines", Some(&json!({"profile": profile("../x")})), None);
    assert_eq!(status, 422, "a name never becomes a path");
}

#[test]
fn an_approval_names_the_hash_and_a_revocation_is_for_good() {
    let served = Served::start(&[]);
    let program = served.program_of(&small_job("x"));
    let path = format!("/v1/programs/{program}");
    let sha256 = served.json(&path)["sha256"].clone();
    let approval = format!("{path}/approval");
    let wrong = json!({"sha256": "0".repeat(64)});
    let (status, problem) = served.call("PUT", &approval, Some(&wrong), None);
    assert_eq!((status, &problem["code"]), (409, &json!("hash_mismatch")));
    assert_eq!(served.json(&path)["state"], "draft");
    for _ in 0..2 {
        let (status, approved) = served.call("PUT", &approval, Some(&json!({"sha256": sha256})), None);
        assert_eq!((status, &approved["state"]), (200, &json!("approved")));
    }
    let revocation = format!("{path}/revocation");
    assert_eq!(served.call("PUT", &revocation, Some(&json!({"reason": " "})), None).0, 422);
    let (status, revoked) = served.call("PUT", &revocation, Some(&json!({"reason": "wrong lot"})), None);
    assert_eq!((status, &revoked["state"]), (200, &json!("revoked")));
    let (status, problem) = served.call("PUT", &approval, Some(&json!({"sha256": sha256})), None);
    assert_eq!((status, &problem["code"]), (409, &json!("illegal_state")));
}

#[test]
fn a_hold_is_set_with_a_reason_and_taken_back() {
    let served = Served::start(&[]);
    served.call("POST", "/v1/machines", Some(&json!({"profile": profile("cutter-3")})), None);
    let hold = "/v1/machines/cutter-3/hold";
    assert_eq!(served.call("PUT", hold, Some(&json!({})), None).0, 422);
    let (status, machine) = served.call("PUT", hold, Some(&json!({"reason": "blade change"})), None);
    assert_eq!((status, &machine["hold"]["reason"]), (200, &json!("blade change")));
    let (status, machine) = served.call("DELETE", hold, None, None);
    assert_eq!((status, machine.get("hold")), (200, None));
    assert_eq!(served.call("PUT", "/v1/machines/none/hold", Some(&json!({"reason": "x"})), None).0, 404);
}

#[test]
fn every_change_is_in_the_trail_and_a_changed_row_breaks_it() {
    let served = Served::start(&[]);
    let program = served.program_of(&small_job("x"));
    let sha256 = served.json(&format!("/v1/programs/{program}"))["sha256"].clone();
    let approval = format!("/v1/programs/{program}/approval");
    served.call("PUT", &approval, Some(&json!({"sha256": sha256})), None);
    let trail_after = |seq: i64| -> Vec<Value> {
        let text = served.get(&format!("/v1/audit?after={seq}")).send().unwrap().text().unwrap();
        text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
    };
    let trail = || trail_after(0);
    let rows = trail();
    assert!(
        (1..rows.len()).all(|seq| trail_after(seq as i64) == rows[seq..]),
        "a page is a part of the trail"
    );
    let page = served.get("/v1/audit?limit=2").send().unwrap().text().unwrap();
    assert_eq!(page.lines().count(), 2);
    assert!(rows.iter().any(|row| row["action"] == "program.approved" && row["detail"]["sha256"] == sha256));
    assert!(rows.iter().all(|row| row.get("broken").is_none()), "{rows:?}");
    execute(&served, "UPDATE audit SET actor = 'somebody else' WHERE action = 'program.approved'");
    let broken: Vec<_> = trail().into_iter().filter(|row| row["broken"] == true).collect();
    assert_eq!((broken.len(), &broken[0]["action"]), (1, &json!("program.approved")));
    execute(&served, "DELETE FROM audit WHERE seq = 2");
    for after in [0, 1, 2] {
        let noticed = trail_after(after).iter().any(|row| row["seq"] == 3 && row["broken"] == true);
        assert!(noticed, "a missing row is noticed, also by whoever reads on behind it: {after}");
    }
}
