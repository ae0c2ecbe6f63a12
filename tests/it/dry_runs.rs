//! What is no unit of production: dry runs and the rest of a roll, over a real socket. And what waits for more than its
//! turn.

use bladeplan::planning::attempt::check;
use bladeplan::planning::budget::Budget;
use bladeplan::planning::document;
use bladeplan::planning::document::files::Files;
use bladeplan::planning::finding::Code;
use bladeplan::planning::outcome::{ProgramFile, sha256_hex};
use bladeplan::planning::tape::machine::Catalogue;
use serde_json::{Value, json};

use crate::linuxcnc::plan;
use crate::served::{Served, form, id_of, job_with_a_file, small_job, until};
use crate::shop_floor::{execute, profile};

/// The machine of these tests.
const MACHINE: &str = "cutter-3";

/// A ply of two courses whose ends are square: a program can begin with either.
fn two_courses(options: &Value) -> Value {
    let mut job = small_job("two courses");
    job["input"]["boundary"] = json!({"points": [[0, 0, 0], [400, 0, 0], [400, 180, 0], [0, 180, 0]]});
    let track = |number: u32, y: f64| {
        let point = |x: f64| json!({"position": [x, y, 0], "normal": [0, 0, 1]});
        json!({"number": number, "points": [point(-100.0), point(500.0)]})
    };
    job["input"]["tracks"] = json!([track(1, 50.0), track(2, 150.0)]);
    job["input"]["options"] = options.clone();
    job["input"]["machine"] = json!(MACHINE);
    job
}

fn floor() -> Served {
    floor_with(&[])
}

fn floor_with(flags: &[&str]) -> Served {
    let served = Served::start(flags);
    register(&served, MACHINE, "hall-2");
    served
}

fn register(served: &Served, name: &str, pool: &str) {
    let registration = json!({"profile": profile(name), "pool": pool});
    assert_eq!(served.call("POST", "/v1/machines", Some(&registration), None).0, 201);
}

fn approve(served: &Served, program: &str) {
    let path = format!("/v1/programs/{program}");
    let body = json!({"sha256": served.json(&path)["sha256"]});
    assert_eq!(served.call("PUT", &format!("{path}/approval"), Some(&body), None).0, 200);
}

fn enqueue(served: &Served, queue: &str, program: &str) -> Value {
    let body = json!({"program": program, "quantity": 1});
    let (status, entry) = served.call("POST", &format!("/v1/queues/{queue}/entries"), Some(&body), None);
    assert_eq!(status, 201, "{entry}");
    entry
}

fn at(value: &Value) -> &str {
    value["links"]["self"].as_str().unwrap()
}

fn next_in_words(served: &Served) -> String {
    next_of(served, MACHINE)
}

fn next_of(served: &Served, machine: &str) -> String {
    let request = served.get(&format!("/v1/machines/{machine}/next")).header("accept", "text/plain");
    request.send().unwrap().text().unwrap()
}

/// Does the one unit that waits, from claim to end.
fn run_to_its_end(served: &Served, request_id: &str) -> Value {
    let claims = format!("/v1/machines/{MACHINE}/runs");
    let (status, run) = served.call("POST", &claims, Some(&json!({"request_id": request_id})), None);
    assert_eq!(status, 201, "{run}");
    let put = |what: &str, body: Value| {
        let (status, run) = served.call("PUT", &format!("{}/{what}", at(&run)), Some(&body), None);
        assert_eq!(status, 200, "{run}");
        run
    };
    put("receipt", json!({"fence": 1, "sha256": run["sha256"], "size": run["size"]}));
    put("start", json!({"fence": 1}));
    put("result", json!({"fence": 1, "outcome": "done"}))
}

fn trail(served: &Served) -> Vec<Value> {
    let text = served.get("/v1/audit?limit=1000").send().unwrap().text().unwrap();
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

#[test]
fn what_cuts_no_whole_roll_says_so_everywhere_and_makes_no_unit() {
    let served = floor();
    let cases = [
        (json!({}), "production", Value::Null, "", 1),
        (json!({"dry_run": true}), "dry_run", Value::Null, "DRY RUN: nothing is cut", 0),
        (json!({"from_course": 1}), "restart", json!(1), "GOES ON WITHIN A ROLL, from course 1", 0),
        (json!({"from_course": 1, "dry_run": true}), "dry_run", json!(1), "DRY RUN from course 1", 0),
    ];
    for (index, (options, purpose, course, words, produced)) in cases.into_iter().enumerate() {
        let said = |value: &Value| {
            assert_eq!((&value["purpose"], &value["from_course"]), (&json!(purpose), &course), "{value}");
        };
        let program = served.program_of(&two_courses(&options));
        said(&served.json(&format!("/v1/programs/{program}")));
        approve(&served, &program);
        let entry = enqueue(&served, MACHINE, &program);
        said(&entry);
        let next = served.json(&format!("/v1/machines/{MACHINE}/next"));
        said(&next["entry"]);
        let text = next_in_words(&served);
        assert!(text.contains(&format!("purpose  {purpose}\n")) && text.contains(words), "{text}");
        assert_eq!(text.contains("no unit of production"), produced == 0, "{text}");
        let run = run_to_its_end(&served, &format!("r{index}"));
        said(&run);
        let entry = served.json(at(&entry));
        said(&entry);
        assert_eq!(entry["state"], "finished");
        let units = (entry["units"]["done"].as_i64(), entry["units"]["produced"].as_i64());
        assert_eq!(units, (Some(1), Some(produced)), "{purpose}");
        let page = served.get("/").send().unwrap().text().unwrap();
        assert!(page.contains(words), "{page}");
        for row in trail(&served) {
            let about = [&json!(program), &entry["id"], &run["id"]].contains(&&row["subject"]);
            if about {
                said(&row["detail"]);
            }
        }
        let actions: Vec<_> = trail(&served).iter().map(|row| row["action"].clone()).collect();
        for action in ["program.drafted", "program.approved", "entry.finished", "run.done"] {
            assert!(actions.contains(&json!(action)), "{action}");
        }
    }
}

#[test]
fn a_restart_within_several_plies_names_the_ply_everywhere() {
    let served = floor();
    let mut job: Value = serde_json::from_str(include_str!("../../examples/two-plies.job.json")).unwrap();
    job["input"]["machine"] = json!(MACHINE);
    job["input"]["options"] = json!({"allocation": "free", "from_ply": 2, "from_course": 3});
    let said = |value: &Value| {
        assert_eq!((&value["from_ply"], &value["from_course"]), (&json!(2), &json!(3)), "{value}");
    };
    let program = served.program_of(&job);
    said(&served.json(&format!("/v1/programs/{program}")));
    approve(&served, &program);
    said(&enqueue(&served, MACHINE, &program));
    assert!(next_in_words(&served).contains("from course 3 of ply 2:"), "{}", next_in_words(&served));
    said(&run_to_its_end(&served, "r"));
    assert!(served.get("/").send().unwrap().text().unwrap().contains("from course 3 of ply 2:"));
    let trail = trail(&served);
    let about: Vec<&Value> = trail.iter().filter(|row| row["subject"] == json!(program)).collect();
    assert!(about.len() >= 2, "{trail:?}");
    about.into_iter().for_each(|row| said(&row["detail"]));
}

#[test]
fn a_program_is_asked_for_as_a_dry_run_and_asked_again_it_is_the_same_job() {
    let served = floor();
    let original = served.program_of(&two_courses(&json!({"allocation": "free"})));
    let by_hand = served.program_of(&two_courses(&json!({"allocation": "free", "dry_run": true})));
    // What the dry run is planned for is the machine as it was, not as it is now.
    let mut slower = profile(MACHINE);
    slower["feed"]["max_speed_mm_s"] = json!(100);
    let amendment = json!({"profile": slower});
    assert_eq!(served.call("PATCH", &format!("/v1/machines/{MACHINE}"), Some(&amendment), None).0, 200);

    let program = served.json(&format!("/v1/programs/{original}"));
    let address = program["links"]["dry_run"].as_str().unwrap().to_owned();
    let first = served.put(&address).send().unwrap();
    assert_eq!(first.status(), 202);
    assert!(!first.headers().contains_key("idempotency-replayed"));
    let location = first.headers()["location"].to_str().unwrap().to_owned();
    let id = id_of(first);
    assert_eq!(location, format!("/v1/jobs/{id}"));
    let job = served.ended(&id);
    assert_eq!((&job["dry_run_of"], &job["verdict"]), (&json!(original), &json!("usable")), "{job}");
    assert_eq!(job["references"], json!({"work_order": "4711", "part": "two courses"}));
    let again = served.put(&address).send().unwrap();
    assert_eq!(
        (again.status().as_u16(), &again.headers()["idempotency-replayed"]),
        (202, &"true".parse().unwrap())
    );
    assert_eq!(id_of(again), id);

    let path = format!("/v1/programs/{}", job["program"].as_str().unwrap());
    let twin = served.json(&path);
    assert_eq!(
        (&twin["purpose"], &twin["state"]),
        (&json!("dry_run"), &json!("draft")),
        "it has an approval of its own"
    );
    assert_eq!(twin["sha256"], served.json(&format!("/v1/programs/{by_hand}"))["sha256"]);
    assert_ne!(twin["sha256"], program["sha256"]);
    let text = served.get(&format!("{path}/content")).send().unwrap().text().unwrap();
    assert!(text.contains("DRY RUN") && !text.contains("M64"), "{text}");
    let mut document = two_courses(&json!({"allocation": "free", "dry_run": true}));
    assert_eq!(served.json(&format!("{location}/input")), document);
    document["input"]["options"]["dry_run"] = json!(false);
    let queued =
        trail(&served).into_iter().find(|row| row["action"] == "job.queued" && row["subject"] == json!(id));
    assert_eq!(queued.unwrap()["detail"]["dry_run_of"], json!(original));

    // A dry run of a dry run is none; one whose program is out of use is planned anew.
    assert!(twin["links"].get("dry_run").is_none());
    let (status, problem) = served.call("PUT", &format!("{path}/dry-run"), None, None);
    assert_eq!((status, &problem["code"]), (409, &json!("no_dry_run")));
    let revocation = json!({"reason": "looked wrong"});
    assert_eq!(served.call("PUT", &format!("{path}/revocation"), Some(&revocation), None).0, 200);
    assert_ne!(id_of(served.put(&address).send().unwrap()), id);
}

#[test]
fn the_files_of_a_job_come_with_its_dry_run() {
    let served = Served::start(&[]);
    let files: &[(&str, &[u8])] = &[("ply.txt", b"0 0 0\n400 0 0\n400 80 0\n0 80 0\n")];
    let document = job_with_a_file("ply.txt").to_string().into_bytes();
    let id = id_of(served.post_form(form(&document, files)).send().unwrap());
    let program = served.ended(&id)["program"].as_str().unwrap().to_owned();
    let dry = id_of(served.put(&format!("/v1/programs/{program}/dry-run")).send().unwrap());
    let job = served.ended(&dry);
    assert_eq!((&job["verdict"], &job["files"][0]["name"]), (&json!("usable"), &json!("ply.txt")), "{job}");
}

#[test]
fn not_every_program_and_not_everybody_has_a_dry_run() {
    let served = Served::start(&[]);
    let program = served.program_of(&small_job("x"));
    let address = format!("/v1/programs/{program}/dry-run");
    let refused = |key: Option<&str>| {
        let (status, problem) = served.call("PUT", &address, None, key);
        (status, problem["code"].as_str().unwrap_or_default().to_owned())
    };
    let none = "/v1/programs/prg_00000000000070008000000000000000/dry-run";
    assert_eq!(served.call("PUT", none, None, None).0, 404);
    execute(&served, "UPDATE programs SET kind = 'honeycomb-cut'");
    assert_eq!(refused(None), (409, "no_dry_run".to_owned()), "a robot's");
    execute(&served, "UPDATE programs SET kind = 'tape-cut', state = 'revoked'");
    assert_eq!(refused(None), (409, "program_not_approved".to_owned()));
    execute(&served, "UPDATE programs SET state = 'draft'");
    // As if another version had planned it.
    let job = served.json(&format!("/v1/programs/{program}"))["job"].as_str().unwrap().to_owned();
    let mut report = served.json(&format!("/v1/jobs/{job}/report"));
    report["planner_version"] = json!("0.0.9");
    let (text, hash) = (report.to_string(), sha256_hex(report.to_string().as_bytes()));
    let text = text.replace('\'', "''");
    let statement = format!("UPDATE reports SET sha256 = '{hash}', body = CAST('{text}' AS BLOB)");
    execute(&served, statement.leak());
    assert_eq!(refused(None), (409, "no_dry_run".to_owned()), "its moves may be others");
    let operator = served.key("operator", "olga", None);
    assert_eq!(refused(Some(&operator)), (403, "forbidden".to_owned()));
}

#[test]
fn an_entry_that_waits_for_more_than_its_turn_says_for_what() {
    let served = floor();
    let program = served.program_of(&two_courses(&json!({})));
    let entry = enqueue(&served, MACHINE, &program);
    let path = format!("/v1/programs/{program}/approval");
    let waits = |entry: &Value, code: &str, words: &str| {
        let found = &entry["waiting_for"];
        assert_eq!(found["code"], json!(code), "{entry}");
        assert!(found["detail"].as_str().unwrap().contains(words), "{found}");
    };
    let now = || served.json(at(&entry));
    let next = || served.json(&format!("/v1/machines/{MACHINE}/next"));
    waits(&entry, "approval", &path);
    waits(&now(), "approval", &path);
    let listed = served.json(&format!("/v1/queues/{MACHINE}/entries"));
    waits(&listed["entries"][0], "approval", &path);
    let seen = next();
    assert!(seen.get("entry").is_none());
    waits(&seen["waiting"][0], "approval", &path);
    let text = next_in_words(&served);
    assert!(
        text.contains("for approval\n") && text.contains(&path) && !text.contains("nothing waits"),
        "{text}"
    );

    approve(&served, &program);
    assert!(
        now().get("waiting_for").is_none() && next().get("waiting").is_none(),
        "it waits for its turn alone"
    );

    let hold = format!("/v1/machines/{MACHINE}/hold");
    assert_eq!(served.call("PUT", &hold, Some(&json!({"reason": "blade change"})), None).0, 200);
    waits(&now(), "release", "blade change");
    waits(&next()["entry"], "release", &hold);
    assert!(next_in_words(&served).contains(&format!("DELETE {hold}")));
    assert_eq!(served.call("DELETE", &hold, None, None).0, 200);

    let mut slower = profile(MACHINE);
    slower["feed"]["max_speed_mm_s"] = json!(100);
    let address = format!("/v1/machines/{MACHINE}");
    assert_eq!(served.call("PATCH", &address, Some(&json!({"profile": slower})), None).0, 200);
    waits(&now(), "machine", "another profile");
    assert!(next_in_words(&served).contains("for machine\n"));
    assert_eq!(served.call("PATCH", &address, Some(&json!({"profile": profile(MACHINE)})), None).0, 200);
    assert!(now().get("waiting_for").is_none());

    let revocation = format!("/v1/programs/{program}/revocation");
    assert_eq!(served.call("PUT", &revocation, Some(&json!({"reason": "wrong lot"})), None).0, 200);
    waits(&now(), "replacement", "revoked");
    assert_eq!(served.call("DELETE", at(&entry), None, None).1.get("waiting_for"), None, "it waits no more");
}

#[test]
fn in_a_pool_an_entry_waits_for_nothing_while_one_machine_can_have_it() {
    let served = floor_with(&["--lease-s", "1"]);
    let mut other = profile("cutter-4");
    other["feed"]["max_speed_mm_s"] = json!(100);
    let registration = json!({"profile": other, "pool": "hall-2"});
    assert_eq!(served.call("POST", "/v1/machines", Some(&registration), None).0, 201);
    let program = served.program_of(&two_courses(&json!({})));
    approve(&served, &program);
    let body = json!({"program": program, "quantity": 2});
    let (_, entry) = served.call("POST", "/v1/queues/hall-2/entries", Some(&body), None);
    assert!(entry.get("waiting_for").is_none(), "{entry}");
    let text = next_of(&served, "cutter-4");
    assert!(text.contains("for machine\n"), "{text}");
    let claims = format!("/v1/machines/{MACHINE}/runs");
    let (_, run) = served.call("POST", &claims, Some(&json!({"request_id": "r"})), None);
    until(|| (served.json(at(&run))["state"] == "suspect").then_some(()));
    let entry = served.json(at(&entry));
    assert_eq!(entry["waiting_for"]["code"], "resolution", "{entry}");
    let words = entry["waiting_for"]["detail"].as_str().unwrap();
    assert!(words.contains(run["id"].as_str().unwrap()), "{words}");
    let amendment = json!({"pool": null});
    for machine in [MACHINE, "cutter-4"] {
        assert_eq!(served.call("PATCH", &format!("/v1/machines/{machine}"), Some(&amendment), None).0, 200);
    }
    let entry = served.json(at(&entry));
    assert!(entry["waiting_for"]["detail"].as_str().unwrap().contains("No machine"), "{entry}");
}

#[test]
fn a_check_against_the_job_without_the_option_says_which_option_is_meant() {
    let job = |options: Value| {
        let mut job = two_courses(&options);
        job["input"]["machine"] = json!("two-cutter-lab");
        document::from_value(job).unwrap()
    };
    let (files, catalogue, budget) = (Files::default(), Catalogue::built_in(), Budget::unwatched());
    let program = |options: Value| plan(&job(options), &files, &catalogue, &budget).unwrap().programs;
    let against = |options: Value, program: &[ProgramFile]| -> Vec<String> {
        let (_, findings) = check(&job(options), &files, &catalogue, program, &budget).unwrap();
        let differs = findings.into_iter().filter(|finding| finding.code == Code::DiffersFromPlan);
        differs.map(|finding| finding.message).collect()
    };
    let whole = program(json!({}));
    let (dry, late) = (program(json!({"dry_run": true})), program(json!({"from_course": 1})));
    for (options, program, hint) in [
        (json!({}), &dry, "with options.dry_run"),
        (json!({}), &late, "with options.from_course 1"),
        (json!({"dry_run": true}), &whole, "without options.dry_run"),
        (json!({"from_course": 1}), &whole, "without options.from_course"),
    ] {
        let said = against(options, program);
        assert!(said.len() == 1 && said[0].contains(hint), "{said:?}");
    }
    assert_eq!(against(json!({}), &whole), Vec::<String>::new());
}
