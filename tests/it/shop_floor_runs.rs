//! Queues, claims and runs over a real socket: one unit of one entry goes to one machine, and silence gives nothing
//! out again.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::thread;

use bladeplan::http::auth::RULES;
use bladeplan::job::role::Role;
use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use sqlx::{Connection, SqliteConnection};
use tempfile::TempDir;

use crate::http_programs::flip_one_bit;
use crate::served::{Served, small_job, until};
use crate::shop_floor::profile;

/// All machines of these tests share this queue.
const POOL: &str = "hall-2";

/// A service with machines and one approved program.
struct Floor {
    served: Served,
    program: String,
}

impl Floor {
    fn new(flags: &[&str], machines: &[&str]) -> Self {
        let served = Served::start(flags);
        for name in machines {
            let registration = json!({"profile": profile(name), "pool": POOL});
            assert_eq!(served.call("POST", "/v1/machines", Some(&registration), None).0, 201);
        }
        let program = approved(&served, "x");
        Self { served, program }
    }

    fn again(self) -> Self {
        let folder: Arc<TempDir> = self.served.kill();
        Self { served: Served::start_in(folder, &[]), program: self.program }
    }

    fn call(&self, method: &str, path: &str, body: &Value) -> (u16, Value) {
        let body = Some(body).filter(|body| !body.is_null());
        self.served.call(method, path, body, None)
    }

    /// Puts the program into a queue and gives back the entry's address.
    fn enqueue(&self, queue: &str, quantity: i64) -> String {
        let body = json!({"program": self.program, "quantity": quantity});
        let (status, entry) = self.call("POST", &format!("/v1/queues/{queue}/entries"), &body);
        assert_eq!((status, &entry["state"]), (201, &json!("queued")), "{entry}");
        entry["links"]["self"].as_str().unwrap().to_owned()
    }

    fn claim(&self, machine: &str, request_id: &str) -> (u16, Value) {
        self.call("POST", &format!("/v1/machines/{machine}/runs"), &json!({"request_id": request_id}))
    }

    /// A new run.
    fn run(&self, machine: &str, request_id: &str) -> Value {
        let (status, run) = self.claim(machine, request_id);
        assert_eq!((status, &run["state"]), (201, &json!("offered")), "{run}");
        run
    }

    /// A new run that has begun to cut.
    fn running(&self, machine: &str, request_id: &str) -> Value {
        let run = self.run(machine, request_id);
        let receipt = json!({"fence": run["fence"], "sha256": run["sha256"], "size": run["size"]});
        assert_eq!(self.put(&run, "receipt", &receipt).0, 200);
        let (status, run) = self.put(&run, "start", &json!({"fence": run["fence"]}));
        assert_eq!((status, &run["state"]), (200, &json!("running")), "{run}");
        run
    }

    fn put(&self, run: &Value, what: &str, body: &Value) -> (u16, Value) {
        self.call("PUT", &format!("{}/{what}", run["links"]["self"].as_str().unwrap()), body)
    }

    /// A put that must be refused, with its code.
    fn refused(&self, run: &Value, what: &str, body: &Value) -> (u16, String) {
        let (status, problem) = self.put(run, what, body);
        (status, problem["code"].as_str().unwrap_or_default().to_owned())
    }

    fn now(&self, run: &Value) -> Value {
        self.served.json(run["links"]["self"].as_str().unwrap())
    }

    /// Waits until the lease of a run is over and was looked at.
    fn suspect(&self, run: &Value) {
        until(|| (self.now(run)["state"] == "suspect").then_some(()));
    }

    fn actions_of(&self, subject: &Value) -> Vec<String> {
        let text = self.served.get("/v1/audit?limit=1000").send().unwrap().text().unwrap();
        let rows = text.lines().map(|line| serde_json::from_str::<Value>(line).unwrap());
        let own = rows.filter(|row| row["subject"] == *subject);
        own.map(|row| row["action"].as_str().unwrap().to_owned()).collect()
    }
}

fn approved(served: &Served, name: &str) -> String {
    let program = served.program_of(&small_job(name));
    let path = format!("/v1/programs/{program}");
    let body = json!({"sha256": served.json(&path)["sha256"]});
    assert_eq!(served.call("PUT", &format!("{path}/approval"), Some(&body), None).0, 200);
    program
}

fn conflict(code: &str) -> (u16, String) {
    (409, code.to_owned())
}

fn outcome(run: &Value, outcome: &str) -> Value {
    json!({"fence": run["fence"], "outcome": outcome})
}

#[test]
fn from_the_queue_to_done_with_every_step_in_the_trail() {
    let floor = Floor::new(&[], &["cutter-1"]);
    let entry = floor.enqueue("cutter-1", 1);
    let run = floor.run("cutter-1", "r1");
    assert_eq!(floor.served.json(&entry)["state"], "assigned");

    // Half of the program, then the rest of it, as over a line that broke.
    let content = run["links"]["content"].as_str().unwrap();
    let etag = format!("\"{}\"", run["sha256"].as_str().unwrap());
    let half = run["size"].as_i64().unwrap() / 2;
    let part = |range: String| {
        let request = floor.served.get(content).header("range", range).header("if-range", &etag);
        let response = request.send().unwrap();
        assert_eq!(response.status(), 206);
        assert_eq!(response.headers()["etag"], etag);
        response.bytes().unwrap().to_vec()
    };
    let hash = |bytes: &[u8]| format!("{:x}", Sha256::digest(bytes));
    let mut bytes = part(format!("bytes=0-{}", half - 1));
    let receipt = |bytes: &[u8]| json!({"fence": 1, "sha256": hash(bytes), "size": bytes.len()});
    assert_eq!(floor.refused(&run, "receipt", &receipt(&bytes)), conflict("hash_mismatch"));
    bytes.extend(part(format!("bytes={half}-")));
    let (status, received) = floor.put(&run, "receipt", &receipt(&bytes));
    assert_eq!((status, &received["state"]), (200, &json!("received")), "{received}");

    assert_eq!(floor.put(&run, "start", &json!({"fence": 1})).1["state"], "running");
    assert_eq!(floor.put(&run, "heartbeat", &json!({"fence": 1})).0, 200);
    let result =
        json!({"fence": 1, "outcome": "done", "prepreg_lot": "L-77", "spool": "S3", "cassette": "C1"});
    for _ in 0..2 {
        let (status, done) = floor.put(&run, "result", &result);
        assert_eq!((status, &done["state"], &done["prepreg_lot"]), (200, &json!("done"), &json!("L-77")));
    }
    assert_eq!(floor.refused(&run, "result", &outcome(&run, "failed")), conflict("illegal_state"));
    let finished = floor.served.json(&entry);
    assert_eq!((&finished["state"], &finished["units"]["done"]), (&json!("finished"), &json!(1)));
    assert_eq!(floor.actions_of(&run["id"]), ["run.offered", "run.received", "run.running", "run.done"]);
    assert_eq!(floor.actions_of(&finished["id"]), ["entry.queued", "entry.assigned", "entry.finished"]);
    assert_eq!(floor.served.get(content).send().unwrap().status(), 409, "what has ended is not given out");
}

#[test]
fn many_claims_at_once_never_give_a_unit_twice() {
    const UNITS: i64 = 8;
    let names: Vec<String> = (1..=12).map(|number| format!("cutter-{number}")).collect();
    let floor = Floor::new(&[], &names.iter().map(String::as_str).collect::<Vec<_>>());
    floor.enqueue(POOL, UNITS);
    // Each machine asks twice at the same time, as two couriers beside it would.
    let answers: Vec<(u16, Value)> = thread::scope(|scope| {
        let claim = |name, request| {
            scope.spawn({
                let floor = &floor;
                move || floor.claim(name, request)
            })
        };
        let asked: Vec<_> = names.iter().flat_map(|name| [claim(name, "a"), claim(name, "b")]).collect();
        asked.into_iter().map(|claim| claim.join().unwrap()).collect()
    });
    assert!(answers.iter().all(|(status, _)| [200, 201, 204].contains(status)), "{answers:?}");
    let new: Vec<&Value> = answers.iter().filter(|(status, _)| *status == 201).map(|(_, run)| run).collect();
    let units: BTreeSet<i64> = new.iter().map(|run| run["unit"].as_i64().unwrap()).collect();
    let machines: BTreeSet<&str> = new.iter().map(|run| run["machine"].as_str().unwrap()).collect();
    assert_eq!((new.len(), units, machines.len()), (8, (1..=UNITS).collect(), 8));
    assert_eq!(floor.served.json("/v1/runs?limit=200")["runs"].as_array().unwrap().len(), 8);
    for (_, known) in answers.iter().filter(|(status, _)| *status == 200) {
        assert!(new.iter().any(|run| run["id"] == known["id"] && run["machine"] == known["machine"]));
    }
    // The tables themselves refuse what a defect in the claim would write.
    let twice =
        "INSERT INTO runs (id, entry_id, unit, program_id, sha256, bytes, machine, request_id, fence, state,
            lease_until, created_at, version, life)
        SELECT 'run_twice', entry_id, unit, program_id, sha256, bytes, (SELECT m.name FROM machines m
            WHERE m.name NOT IN (SELECT machine FROM runs) LIMIT 1), 'x', 1, 'offered', 0, 0, 1, '{}'
        FROM runs LIMIT 1";
    let words = execute(&floor.served, twice).unwrap_err().to_string();
    assert!(words.contains("UNIQUE constraint failed: runs.entry_id, runs.unit"), "{words}");
}

fn execute(served: &Served, statement: &'static str) -> sqlx::Result<()> {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    runtime.block_on(async {
        let url = format!("sqlite://{}", served.database().display());
        let mut connection = SqliteConnection::connect(&url).await?;
        sqlx::query(statement).execute(&mut connection).await?;
        connection.close().await
    })
}

#[test]
fn a_lost_answer_to_a_claim_is_had_again() {
    let floor = Floor::new(&[], &["cutter-1"]);
    floor.enqueue("cutter-1", 2);
    let run = floor.run("cutter-1", "monday-1");
    for request in ["monday-1", "monday-2"] {
        let (status, again) = floor.claim("cutter-1", request);
        assert_eq!((status, &again["id"], &again["fence"]), (200, &run["id"], &json!(1)), "{request}");
    }
    let running =
        floor.put(&run, "receipt", &json!({"fence": 1, "sha256": run["sha256"], "size": run["size"]}));
    assert_eq!(running.0, 200);
    for _ in 0..2 {
        assert_eq!(floor.put(&run, "start", &json!({"fence": 1})).1["state"], "running", "a lost start, too");
    }
    assert_eq!(floor.put(&run, "result", &outcome(&run, "done")).0, 200);
    let (status, again) = floor.claim("cutter-1", "monday-1");
    assert_eq!((status, &again["id"], &again["state"]), (200, &run["id"], &json!("done")));
    assert_eq!(floor.run("cutter-1", "monday-2")["unit"], 2);
    assert_eq!(floor.claim("none", "x").1["code"], "machine_not_found");
    for request in ["", "two words", "ä"] {
        assert_eq!(floor.claim("cutter-1", request).0, 422, "{request}");
    }
}

#[test]
fn a_claimed_run_survives_a_kill_and_goes_to_nobody_else() {
    let floor = Floor::new(&[], &["cutter-1", "cutter-2"]);
    let entry = floor.enqueue(POOL, 1);
    let run = floor.running("cutter-1", "r1");
    let floor = floor.again();
    let after = floor.now(&run);
    assert_eq!((&after["state"], &after["fence"]), (&json!("running"), &run["fence"]));
    assert_eq!(floor.claim("cutter-2", "r2").0, 204);
    assert_eq!(floor.claim("cutter-1", "r1").1["id"], run["id"]);
    assert_eq!(floor.put(&run, "result", &outcome(&run, "done")).0, 200);
    assert_eq!(floor.served.json(&entry)["state"], "finished");
    assert_eq!(floor.claim("cutter-2", "r3").0, 204);
}

#[test]
fn nothing_starts_without_its_receipt_its_approval_and_a_free_machine() {
    let floor = Floor::new(&[], &["cutter-1"]);
    floor.enqueue("cutter-1", 1);
    let run = floor.run("cutter-1", "r1");
    let fence = json!({"fence": 1});
    assert_eq!(floor.refused(&run, "start", &fence), conflict("illegal_state"));
    let receipt = |sha256: &Value, size: i64| json!({"fence": 1, "sha256": sha256, "size": size});
    let size = run["size"].as_i64().unwrap();
    for wrong in [receipt(&json!("0".repeat(64)), size), receipt(&run["sha256"], size - 1)] {
        assert_eq!(floor.refused(&run, "receipt", &wrong), conflict("hash_mismatch"));
        assert_eq!(floor.refused(&run, "start", &fence), conflict("illegal_state"));
    }
    assert_eq!(floor.refused(&run, "receipt", &json!({"fence": 1, "sha256": ""})).0, 422, "no size");
    assert_eq!(floor.put(&run, "receipt", &receipt(&run["sha256"], size)).0, 200);
    for stale in [0, 2] {
        assert_eq!(floor.refused(&run, "start", &json!({"fence": stale})), conflict("fence_lost"));
    }
    assert_eq!(floor.refused(&run, "result", &outcome(&run, "done")), conflict("illegal_state"));

    let hold = "/v1/machines/cutter-1/hold";
    assert_eq!(floor.call("PUT", hold, &json!({"reason": "blade"})).0, 200);
    assert_eq!(floor.refused(&run, "start", &fence), conflict("machine_held"));
    assert_eq!(floor.call("DELETE", hold, &Value::Null).0, 200);

    let revocation = format!("/v1/programs/{}/revocation", floor.program);
    assert_eq!(floor.call("PUT", &revocation, &json!({"reason": "wrong revision"})).0, 200);
    assert_eq!(floor.refused(&run, "start", &fence), conflict("program_not_approved"));
    let content = floor.served.get(run["links"]["content"].as_str().unwrap()).send().unwrap();
    assert_eq!(content.json::<Value>().unwrap()["code"], "program_not_approved");
    assert_eq!(floor.now(&run)["state"], "received");
    assert_eq!(floor.put(&run, "result", &outcome(&run, "aborted")).1["returned"], true);
    assert_eq!(floor.claim("cutter-1", "r2").0, 204, "a revoked program is given to nobody");
    let body = json!({"program": floor.program, "quantity": 1});
    let (status, problem) = floor.call("POST", "/v1/queues/cutter-1/entries", &body);
    assert_eq!((status, &problem["code"]), (409, &json!("program_not_approved")));
}

#[test]
fn a_flipped_bit_reaches_no_machine() {
    let floor = Floor::new(&[], &["cutter-1", "cutter-2"]);
    let sound = approved(&floor.served, "sound");
    floor.enqueue(POOL, 1);
    let body = json!({"program": sound, "quantity": 2});
    assert_eq!(floor.call("POST", &format!("/v1/queues/{POOL}/entries"), &body).0, 201);
    flip_one_bit(&floor.served.database(), &floor.program);
    let run = floor.run("cutter-1", "r1");
    assert_eq!(run["program"], json!(sound), "the damaged one is passed over");
    assert_eq!(floor.served.json(&format!("/v1/programs/{}", floor.program))["state"], "quarantined");

    let receipt = json!({"fence": 1, "sha256": run["sha256"], "size": run["size"]});
    assert_eq!(floor.put(&run, "receipt", &receipt).0, 200);
    flip_one_bit(&floor.served.database(), &sound);
    for _ in 0..2 {
        assert_eq!(floor.refused(&run, "start", &json!({"fence": 1})), conflict("program_quarantined"));
    }
    let content = floor.served.get(run["links"]["content"].as_str().unwrap()).send().unwrap();
    assert_eq!(content.json::<Value>().unwrap()["code"], "program_quarantined");
    assert_eq!(floor.claim("cutter-2", "r1").0, 204);
    assert_eq!(floor.actions_of(&json!(sound)).last().unwrap(), "program.quarantined");
}

#[test]
fn silence_makes_suspect_gives_nothing_out_and_ends_with_the_machine() {
    let floor = Floor::new(&["--lease-s", "1"], &["cutter-1", "cutter-2"]);
    let entry = floor.enqueue(POOL, 1);
    let run = floor.running("cutter-1", "r1");
    floor.suspect(&run);
    assert_eq!(floor.claim("cutter-2", "r1").0, 204, "silence never gives a unit out again");
    let listed =
        |query: &str| floor.served.json(&format!("/v1/runs?{query}"))["runs"].as_array().unwrap().len();
    let (own, entry_id) = (run["program"].as_str().unwrap(), run["entry"].as_str().unwrap());
    assert_eq!(listed(&format!("state=suspect&machine=cutter-1&program={own}&entry={entry_id}")), 1);
    assert_eq!((listed("state=running"), listed("machine=cutter-2")), (0, 0));
    assert_eq!(floor.call("GET", "/v1/runs?state=lost", &Value::Null).1["code"], "invalid_query");
    assert_eq!(floor.served.json(&entry)["state"], "assigned");
    let (status, own) = floor.claim("cutter-1", "another");
    assert_eq!((status, &own["id"], &own["state"]), (200, &run["id"], &json!("suspect")));
    assert_eq!(floor.refused(&run, "heartbeat", &json!({"fence": 2})), conflict("fence_lost"));
    assert_eq!(floor.now(&run)["state"], "suspect");
    let (status, back) = floor.put(&run, "heartbeat", &json!({"fence": 1}));
    assert_eq!((status, &back["state"]), (200, &json!("running")), "it is where it was");
    assert_eq!(floor.put(&run, "result", &outcome(&run, "done")).1["state"], "done");
    // On a slow machine it falls silent between any two steps, so that there may be more rows between these.
    let actions = floor.actions_of(&run["id"]);
    let mut rows = actions.iter();
    for wanted in ["run.offered", "run.received", "run.running", "run.suspect", "run.running", "run.done"] {
        assert!(rows.any(|action| action == wanted), "no {wanted} in its place: {actions:?}");
    }
}

#[test]
fn a_person_resolves_a_suspect_run_and_the_late_machine_is_refused() {
    let floor = Floor::new(&["--lease-s", "1"], &["cutter-1", "cutter-2"]);
    let cases =
        [("was_done", "done", "finished"), ("scrap", "failed", "finished"), ("requeue", "aborted", "queued")];
    for (how, state, of_entry) in cases {
        let entry = floor.enqueue(POOL, 1);
        let run = floor.running("cutter-1", how);
        floor.suspect(&run);
        assert_eq!(floor.put(&run, "resolution", &json!({"how": how})).0, 422, "a reason is needed");
        let resolution = json!({"how": how, "reason": "went and looked"});
        for _ in 0..2 {
            let (status, resolved) = floor.put(&run, "resolution", &resolution);
            assert_eq!((status, &resolved["state"], &resolved["fence"]), (200, &json!(state), &json!(2)));
            assert_eq!(resolved["resolution"]["by"], "local");
        }
        assert_eq!(floor.served.json(&entry)["state"], of_entry, "{how}");
        for late in ["start", "heartbeat"] {
            assert_eq!(floor.refused(&run, late, &json!({"fence": 1})), conflict("fence_lost"));
        }
        assert_eq!(floor.refused(&run, "result", &outcome(&run, "done")), conflict("fence_lost"));
        assert_eq!(floor.now(&run)["state"], json!(state), "the late one has changed nothing");
    }
    assert_eq!(floor.run("cutter-2", "r1")["unit"], 1, "the unit that was put back");
    assert_eq!(floor.claim("cutter-1", "r9").0, 204);
}

#[test]
fn only_what_was_not_started_comes_back_without_a_person() {
    let floor = Floor::new(&[], &["cutter-1"]);
    let entry = floor.enqueue("cutter-1", 1);
    let run = floor.run("cutter-1", "r1");
    assert_eq!(floor.put(&run, "result", &outcome(&run, "aborted")).1["returned"], true);
    assert_eq!(floor.served.json(&entry)["state"], "queued");
    let resolution = |how: &str| json!({"how": how, "reason": "looked"});
    assert_eq!(floor.refused(&run, "resolution", &resolution("requeue")), conflict("illegal_state"));

    let aborted = floor.running("cutter-1", "r2");
    assert_eq!(floor.refused(&aborted, "resolution", &resolution("scrap")), conflict("illegal_state"));
    let (_, ended) = floor.put(&aborted, "result", &outcome(&aborted, "aborted"));
    assert_eq!((&ended["returned"], &ended["needs_resolution"]), (&json!(false), &json!(true)));
    assert_eq!(floor.claim("cutter-1", "r3").0, 204, "it may have been cut");
    assert_eq!(floor.refused(&aborted, "resolution", &resolution("was_done")), conflict("illegal_state"));
    assert_eq!(floor.put(&aborted, "resolution", &resolution("requeue")).0, 200);

    let failed = floor.running("cutter-1", "r4");
    assert_eq!(failed["unit"], 1);
    assert_eq!(floor.put(&failed, "result", &outcome(&failed, "failed")).0, 200);
    assert_eq!(floor.put(&failed, "resolution", &resolution("scrap")).0, 200);
    let units = floor.served.json(&entry)["units"].clone();
    assert_eq!(units, json!({"waiting": 0, "out": 0, "done": 0, "produced": 0, "scrapped": 1}));
}

#[test]
fn a_queue_keeps_its_order_and_refuses_what_it_cannot_do() {
    let floor = Floor::new(&[], &["cutter-1"]);
    let post = |queue: &str, body: &Value| {
        let (status, problem) = floor.call("POST", &format!("/v1/queues/{queue}/entries"), body);
        (status, problem["code"].as_str().unwrap_or_default().to_owned())
    };
    let body = json!({"program": floor.program, "quantity": 1});
    assert_eq!(post("nowhere", &body), (404, "machine_not_found".into()));
    let nothing = json!({"program": format!("prg_{}", "0".repeat(32)), "quantity": 1});
    assert_eq!(post(POOL, &nothing), (404, "program_not_found".into()));
    for quantity in [json!(0), json!(10_001), json!(1.5), json!("1"), Value::Null] {
        let body = json!({"program": floor.program, "quantity": quantity});
        assert_eq!(post(POOL, &body), (422, "invalid_request".into()), "{body}");
    }
    let strange = json!({"program": floor.program, "quantity": 1, "priority": 9});
    assert_eq!(post(POOL, &strange), (422, "invalid_request".into()));

    let (first, second, third) =
        (floor.enqueue(POOL, 1), floor.enqueue("cutter-1", 3), floor.enqueue(POOL, 1));
    assert_eq!(floor.call("PATCH", &second, &json!({"position": -1})).1["position"], -1);
    let run = floor.run("cutter-1", "r1");
    assert_eq!(run["entry"], floor.served.json(&second)["id"]);
    assert_eq!(floor.call("PATCH", &second, &json!({"quantity": 1})).1["state"], "assigned");
    assert_eq!(floor.call("PATCH", &second, &json!({"quantity": 2})).1["state"], "queued");
    assert_eq!(floor.call("PATCH", &second, &json!({"quantity": 0})).0, 422);
    for _ in 0..2 {
        assert_eq!(floor.call("DELETE", &second, &Value::Null).1["state"], "cancelled");
    }
    assert_eq!(floor.call("PATCH", &second, &json!({"quantity": 5})).1["code"], "illegal_state");
    assert_eq!(floor.put(&run, "result", &outcome(&run, "aborted")).0, 200, "what was given out goes on");
    assert_eq!(floor.call("PATCH", &third, &json!({"position": -5})).0, 200);
    let page = floor.served.json(&format!("/v1/queues/{POOL}/entries?limit=1"));
    assert_eq!(page["entries"][0]["links"]["self"], json!(third));
    let next = format!("/v1/queues/{POOL}/entries?cursor={}", page["next_cursor"].as_str().unwrap());
    let rest = floor.served.json(&next);
    assert_eq!(rest["entries"][0]["links"]["self"], json!(first));
    assert_eq!(rest["entries"].as_array().unwrap().len(), 1);
    let elsewhere = first.replace(POOL, "cutter-1");
    assert_eq!(floor.call("GET", &elsewhere, &Value::Null).1["code"], "entry_not_found");
    assert_eq!(floor.run("cutter-1", "r2")["entry"], floor.served.json(&third)["id"]);
}

#[test]
fn a_held_machine_gets_nothing_and_a_waiting_one_what_comes() {
    let floor = Floor::new(&[], &["cutter-1"]);
    let peek = || {
        let request = floor.served.get("/v1/machines/cutter-1/next").header("accept", "text/plain");
        request.send().unwrap().text().unwrap()
    };
    assert_eq!(peek(), "machine  cutter-1\nnext     nothing waits\n");
    let run = thread::scope(|scope| {
        let body = json!({"request_id": "w", "wait_s": 50});
        let waits = scope.spawn({
            let floor = &floor;
            move || floor.call("POST", "/v1/machines/cutter-1/runs", &body)
        });
        floor.enqueue(POOL, 2);
        let (status, run) = waits.join().unwrap();
        assert_eq!(status, 201, "{run}");
        run
    });
    let hold = "/v1/machines/cutter-1/hold";
    assert_eq!(floor.call("PUT", hold, &json!({"reason": "new blade"})).0, 200);
    assert_eq!(floor.claim("cutter-1", "w").1["id"], run["id"], "what it has it keeps");
    let text = peek();
    assert!(
        text.contains("held     by local: new blade\n") && text.contains("\nthen     unit 2 of 2 of ent_"),
        "{text}"
    );
    let next = floor.served.json("/v1/machines/cutter-1/next");
    assert_eq!(
        (&next["run"]["id"], &next["unit"], &next["held"]["by"]),
        (&run["id"], &json!(2), &json!("local"))
    );
    assert_eq!(floor.put(&run, "result", &outcome(&run, "aborted")).0, 200);
    let (status, problem) = floor.claim("cutter-1", "v");
    assert_eq!((status, &problem["code"]), (409, &json!("machine_held")));
    assert_eq!(floor.call("DELETE", hold, &Value::Null).0, 200);
    assert_eq!(floor.run("cutter-1", "v")["unit"], 1);
}

#[test]
fn a_machine_touches_its_own_runs_only() {
    let floor = Floor::new(&[], &["cutter-1", "cutter-2"]);
    floor.enqueue(POOL, 3);
    let run = floor.run("cutter-1", "r1");
    let own = floor.served.key("machine", "one", Some("cutter-1"));
    let other = floor.served.key("machine", "two", Some("cutter-2"));
    let operator = floor.served.key("operator", "olga", None);
    let path = |what: &str| format!("{}{what}", run["links"]["self"].as_str().unwrap());
    let receipt = json!({"fence": 1, "sha256": run["sha256"], "size": run["size"]});
    let (fence, claim) = (json!({"fence": 1}), json!({"request_id": "r2"}));
    let result = outcome(&run, "aborted");
    let requests = [
        ("GET", path(""), None),
        ("GET", path("/content?fence=1"), None),
        ("PUT", path("/receipt"), Some(&receipt)),
        ("PUT", path("/start"), Some(&fence)),
        ("PUT", path("/heartbeat"), Some(&fence)),
        ("PUT", path("/result"), Some(&result)),
        ("GET", "/v1/machines/cutter-1/next".to_owned(), None),
        ("POST", "/v1/machines/cutter-1/runs".to_owned(), Some(&claim)),
    ];
    for (method, path, body) in requests {
        assert_eq!(floor.served.call(method, &path, body, Some(&other)).0, 403, "{method} {path}");
        assert_eq!(floor.served.call(method, &path, body, None).0, 401, "{method} {path}");
        let status = floor.served.call(method, &path, body, Some(&own)).0;
        assert!([200, 201].contains(&status), "{method} {path}: {status}");
    }
    let resolution = json!({"how": "scrap", "reason": "x"});
    assert_eq!(floor.served.call("PUT", &path("/resolution"), Some(&resolution), Some(&own)).0, 403);
    let claims = "/v1/machines/cutter-2/runs";
    assert_eq!(floor.served.call("POST", claims, Some(&claim), Some(&operator)).0, 403);
    assert_eq!(floor.served.call("POST", claims, Some(&claim), Some(&other)).0, 201);
}

#[test]
fn the_table_of_who_may_do_what_is_the_one_that_is_kept() {
    let text = include_str!("../../docs/shop-floor.md");
    let (_, table) = text.split_once("| address | roles |\n|---|---|\n").unwrap();
    let rule = |(verb, path, roles): &(&str, &str, &[Role])| {
        let roles: Vec<&str> = roles.iter().map(|role| role.word()).collect();
        format!("| `{verb} {path}` | {} |", roles.join(", "))
    };
    assert_eq!(table.lines().collect::<Vec<_>>(), RULES.iter().map(rule).collect::<Vec<_>>());
}

#[test]
fn a_program_goes_only_to_machines_of_the_profile_that_it_was_planned_for() {
    let floor = Floor::new(&[], &["cutter-1"]);
    let mut other = json!({"profile": profile("cutter-2"), "pool": POOL});
    other["profile"]["cutters"][1]["station_mm"] = json!(310);
    assert_eq!(floor.call("POST", "/v1/machines", &other).0, 201);
    let body = json!({"program": floor.program, "quantity": 1});
    let (status, problem) = floor.call("POST", "/v1/queues/cutter-2/entries", &body);
    assert_eq!((status, &problem["code"]), (409, &json!("profile_mismatch")));
    floor.enqueue(POOL, 1);
    assert_eq!(floor.claim("cutter-2", "a").0, 204, "in a pool, each machine is looked at");
    let (status, run) = floor.claim("cutter-1", "a");
    assert_eq!(status, 201);
    // The profile is changed between claim and start.
    let mut changed = json!({"profile": profile("cutter-1"), "pool": POOL});
    changed["profile"]["feed"]["max_speed_mm_s"] = json!(100);
    assert_eq!(floor.call("PATCH", "/v1/machines/cutter-1", &changed).0, 200);
    let receipt = json!({"fence": run["fence"], "sha256": run["sha256"], "size": run["size"]});
    assert_eq!(floor.put(&run, "receipt", &receipt).0, 200);
    let (status, problem) = floor.put(&run, "start", &json!({"fence": run["fence"]}));
    assert_eq!((status, &problem["code"]), (409, &json!("profile_mismatch")));
}
