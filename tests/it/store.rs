//! The store by itself: fences, recovery, the audit trail.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::Path;

use bladeplan::job::id::{JobId, ProgramId, WorkerId};
use bladeplan::job::life::{Illegal, NewJob, State};
use bladeplan::job::moment::Moment;
use bladeplan::job::purpose::Purpose;
use bladeplan::planning::document::files::Files;
use bladeplan::planning::tape::label::CourseLabel;
use bladeplan::store::attempts::Lost;
use bladeplan::store::jobs::Post;
use bladeplan::store::programs::{NewFile, NewProgram};
use bladeplan::store::results::Answer;
use bladeplan::store::{Error, Store};
use sqlx::Connection;
use sqlx::migrate::Migrator;
use sqlx::sqlite::SqliteConnection;
use tempfile::TempDir;

const fn at(ms: i64) -> Moment {
    Moment::from_unix_ms(1_700_000_000_000 + ms)
}

fn worker(number: u8) -> WorkerId {
    WorkerId::new(at(0), &[number; 10])
}

async fn posted(store: &Store, number: u8) -> JobId {
    keyed(store, number, "mes", None).await.unwrap()
}

async fn keyed(store: &Store, number: u8, actor: &str, key: Option<&str>) -> Result<JobId, Error> {
    let id = JobId::new(at(i64::from(number)), &[number; 10]);
    let (kind, name, references) = ("tape-cut".into(), "x".into(), BTreeMap::new());
    let job = NewJob { id, kind, name, references, dry_run_of: None };
    let now = at(i64::from(number));
    let files = &Files::default();
    let post = Post { job, body: b"{}", files, machines: "[]", key, most_queued: 100, actor, now };
    Ok(store.post(post).await?.job.id)
}

fn answer(text: &str) -> Answer {
    let file = NewFile { name: "roll.ngc".into(), dialect: "linuxcnc".into(), body: text.into() };
    let id = ProgramId::new(at(0), &text.as_bytes()[..10].try_into().unwrap());
    let program = Some(NewProgram { id, files: vec![file], archive: None });
    let report = serde_json::json!({"text": text}).to_string().into_bytes();
    Answer { report, usable: true, warnings: 0, drawings: vec![], program, stages: vec![] }
}

async fn open(folder: &TempDir) -> Store {
    Store::open(&folder.path().join("x.db")).await.unwrap()
}

#[tokio::test]
async fn a_late_worker_with_an_old_fence_cannot_commit() {
    let folder = TempDir::new().unwrap();
    let store = open(&folder).await;
    let id = posted(&store, 1).await;
    let late = store.claim(&worker(1), at(10)).await.unwrap().unwrap();
    assert!(store.heartbeat(&id, late.fence, at(20)).await.unwrap());
    assert_eq!(store.recover(Lost::SilentSince(at(20)), at(30)).await.unwrap(), [], "it was heard at 20");
    assert_eq!(store.recover(Lost::SilentSince(at(21)), at(30)).await.unwrap(), std::slice::from_ref(&id));
    let second = store.claim(&worker(2), at(40)).await.unwrap().unwrap();
    assert_eq!((second.id.clone(), second.fence), (id.clone(), late.fence + 1));

    let lost = |result: Result<_, Error>| matches!(result, Err(Error::Illegal(Illegal::FenceLost)));
    assert!(!store.heartbeat(&id, late.fence, at(50)).await.unwrap());
    assert!(lost(store.succeed(&id, late.fence, &answer("the late one"), &[], at(50)).await));
    assert!(lost(store.retry(&id, late.fence, "late", at(50)).await));
    assert!(lost(store.release(&id, late.fence, at(50)).await));
    assert!(store.reach(&id, late.fence, &[("late".into(), at(50))]).await.is_err());
    assert!(matches!(store.report(&id).await, Err(Error::NotFound)), "nothing of the late one is kept");

    store.succeed(&id, second.fence, &answer("the second one"), &[], at(60)).await.unwrap();
    assert_eq!(store.report(&id).await.unwrap(), br#"{"text":"the second one"}"#);
    assert!(lost(store.succeed(&id, second.fence, &answer("once more, twice"), &[], at(70)).await));
    let State::Succeeded { usable: true, .. } = store.job(&id).await.unwrap().state else { panic!() };
}

#[tokio::test]
async fn a_cancelled_job_takes_no_answer() {
    let folder = TempDir::new().unwrap();
    let store = open(&folder).await;
    let id = posted(&store, 1).await;
    let job = store.claim(&worker(1), at(10)).await.unwrap().unwrap();
    store.cancel(&id, "mes", None, at(20)).await.unwrap();
    let result = store.succeed(&id, job.fence, &answer("too late, all"), &[], at(30)).await;
    assert!(matches!(result, Err(Error::Illegal(Illegal::FenceLost))));
    assert!(matches!(store.report(&id).await, Err(Error::NotFound)));
}

#[tokio::test]
async fn workers_at_the_same_time_get_different_jobs_in_the_order_of_posting() {
    let folder = TempDir::new().unwrap();
    let store = open(&folder).await;
    let mut ids = Vec::new();
    for number in 1..=20 {
        ids.push(posted(&store, number).await);
    }
    let mut claims = tokio::task::JoinSet::new();
    for number in 1..=30 {
        let store = store.clone();
        claims.spawn(async move { store.claim(&worker(number), at(100)).await.unwrap().map(|job| job.id) });
    }
    let mut claimed: Vec<JobId> = claims.join_all().await.into_iter().flatten().collect();
    claimed.sort();
    assert_eq!(claimed, ids);
}

#[tokio::test]
async fn a_job_that_comes_back_keeps_its_place() {
    let folder = TempDir::new().unwrap();
    let store = open(&folder).await;
    let first = posted(&store, 1).await;
    posted(&store, 2).await;
    let job = store.claim(&worker(1), at(10)).await.unwrap().unwrap();
    assert_eq!(job.id, first);
    store.retry(&first, job.fence, "killed", at(20)).await.unwrap();
    assert_eq!(store.claim(&worker(1), at(30)).await.unwrap().unwrap().id, first);
}

#[tokio::test]
async fn every_change_of_state_has_its_row_and_the_rows_form_a_chain() {
    let folder = TempDir::new().unwrap();
    let store = open(&folder).await;
    let id = posted(&store, 1).await;
    let job = store.claim(&worker(1), at(10)).await.unwrap().unwrap();
    store.retry(&id, job.fence, "killed", at(20)).await.unwrap();
    let job = store.claim(&worker(2), at(30)).await.unwrap().unwrap();
    store.succeed(&id, job.fence, &answer("the program"), &[], at(40)).await.unwrap();
    let rows = store.audit(0, 100).await.unwrap();
    let actions: Vec<&str> = rows.iter().map(|row| row.action.as_str()).collect();
    let expected =
        ["job.queued", "job.running", "job.queued", "job.running", "job.succeeded", "program.drafted"];
    assert_eq!(actions, expected);
    assert_eq!((rows[0].actor.as_str(), rows[1].actor.as_str()), ("mes", worker(1).as_str()));
    for (index, row) in rows.iter().enumerate() {
        assert_eq!(row.hash, row.expected_hash(), "{row:?}");
        assert_eq!(row.seq, index as i64 + 1);
        if index > 0 {
            assert_eq!(row.previous, rows[index - 1].hash);
        }
    }
    let mut changed = rows[4].clone();
    changed.actor = "somebody".into();
    assert_ne!(changed.hash, changed.expected_hash(), "a changed row shows");
}

#[tokio::test]
async fn what_is_committed_is_there_after_opening_again() {
    let folder = TempDir::new().unwrap();
    let store = open(&folder).await;
    let id = posted(&store, 1).await;
    store.claim(&worker(1), at(10)).await.unwrap().unwrap();
    drop(store);
    let store = open(&folder).await;
    assert_eq!(store.recover(Lost::All, at(20)).await.unwrap(), std::slice::from_ref(&id));
    assert_eq!(store.job(&id).await.unwrap().attempts, 1, "the attempt had been counted");
    assert_eq!(store.claim(&worker(2), at(30)).await.unwrap().unwrap().fence, 2);
}

#[tokio::test]
async fn an_idempotency_key_belongs_to_its_sender() {
    let folder = TempDir::new().unwrap();
    let store = open(&folder).await;
    let first = keyed(&store, 1, "mes", Some("k")).await.unwrap();
    assert_eq!(keyed(&store, 2, "mes", Some("k")).await.unwrap(), first);
    assert_ne!(keyed(&store, 3, "engineer", Some("k")).await.unwrap(), first);
    assert!(matches!(
        store.posted_before("mes", "k", b"other", &Files::default()).await,
        Err(Error::KeyReused)
    ));
    assert_eq!(store.posted_before("auditor", "k", b"{}", &Files::default()).await.unwrap(), None);
}

#[tokio::test]
async fn posts_at_the_same_time_with_one_key_give_one_job() {
    let folder = TempDir::new().unwrap();
    let store = open(&folder).await;
    let mut posts = tokio::task::JoinSet::new();
    for number in 1..=20 {
        let store = store.clone();
        posts.spawn(async move { keyed(&store, number, "mes", Some("k")).await.unwrap() });
    }
    let mut ids = posts.join_all().await;
    ids.dedup();
    assert_eq!(ids.len(), 1);
}

/// A database as the migrations up to one have left it.
async fn at_version(folder: &TempDir, version: i64) -> SqliteConnection {
    let url = format!("sqlite:{}?mode=rwc", folder.path().join("x.db").display());
    let all = concat!(env!("CARGO_MANIFEST_DIR"), "/migrations/sqlite");
    let migrations = Migrator::new(Path::new(all)).await.unwrap();
    let before = migrations.iter().filter(|migration| migration.version <= version).cloned().collect();
    let mut connection = SqliteConnection::connect(&url).await.unwrap();
    Migrator { migrations: Cow::Owned(before), ..Migrator::DEFAULT }.run(&mut connection).await.unwrap();
    connection
}

/// A store from before a restart named its ply: the name of its program says it.
#[tokio::test]
async fn restarts_from_before_plies_were_named_get_theirs_from_their_names() {
    let folder = TempDir::new().unwrap();
    let mut connection = at_version(&folder, 8).await;
    let (job, program) = (JobId::new(at(0), &[1; 10]), ProgramId::new(at(0), &[1; 10]));
    for statement in [
        format!("INSERT INTO jobs (id, kind, name, labels, created_at, attempts, fence, version, state, life)
                 VALUES ('{job}', 'tape-cut', '', '{{}}', 0, 1, 1, 1, 'failed', '{{}}')"),
        format!("INSERT INTO programs (id, job_id, kind, state, content_position, content_name, media_type, sha256,
                                       bytes, created_at, version, purpose, from_course)
                 VALUES ('{program}', '{job}', 'tape-cut', 'draft', 1, 'roll-from-ply-2-course-7.ngc', 'text/plain',
                         'aa', 1, 0, 1, 'restart', 7)"),
    ] {
        sqlx::query(sqlx::AssertSqlSafe(statement)).execute(&mut connection).await.unwrap();
    }
    connection.close().await.unwrap();
    let program = open(&folder).await.program(&program).await.unwrap();
    let from_course = CourseLabel { ply: Some(2), number: 7 };
    assert_eq!(program.purpose, Purpose::Restart { from_course });
}

/// A store from before programs had a purpose: the names of its programs say it.
#[tokio::test]
async fn programs_from_before_purposes_get_theirs_from_their_names() {
    let folder = TempDir::new().unwrap();
    let mut connection = at_version(&folder, 7).await;
    let cases = [
        ("tape-cut", "roll.ngc", Purpose::Production),
        ("tape-cut", "roll-dry-run.mpf", Purpose::DryRun { from_course: None }),
        ("tape-cut", "roll-from-course-12.ngc", Purpose::Restart { from_course: 12.into() }),
        ("tape-cut", "roll-from-course-7-dry-run.ngc", Purpose::DryRun { from_course: Some(7.into()) }),
        ("honeycomb-cut", "core.zip", Purpose::Production),
    ];
    for (number, (kind, name, _)) in (1_u8..).zip(cases) {
        let (job, program) = (JobId::new(at(0), &[number; 10]), ProgramId::new(at(0), &[number; 10]));
        sqlx::query(
            "INSERT INTO jobs (id, kind, name, labels, created_at, attempts, fence, version, state, life)
                     VALUES ($1, $2, '', '{}', 0, 1, 1, 1, 'failed', '{}')",
        )
        .bind(job.as_str())
        .bind(kind)
        .execute(&mut connection)
        .await
        .unwrap();
        sqlx::query("INSERT INTO programs (id, job_id, kind, state, content_position, content_name, media_type, sha256,
                                           bytes, created_at, version)
                     VALUES ($1, $2, $3, 'draft', 1, $4, 'text/plain', 'aa', 1, 0, 1)")
            .bind(program.as_str())
            .bind(job.as_str())
            .bind(kind)
            .bind(name)
            .execute(&mut connection)
            .await
            .unwrap();
    }
    connection.close().await.unwrap();
    let store = open(&folder).await;
    for (number, (_, name, purpose)) in (1_u8..).zip(cases) {
        let program = store.program(&ProgramId::new(at(0), &[number; 10])).await.unwrap();
        assert_eq!((program.content_name.as_str(), program.purpose), (name, purpose));
    }
}
