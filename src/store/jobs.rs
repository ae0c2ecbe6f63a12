//! Jobs: posting, looking up, cancelling.

use std::collections::BTreeMap;

use sqlx::sqlite::SqliteConnection;

use super::audit::{self, Deed};
use super::events::{describe, note_state};
use super::files::{files_sha256, insert_files};
use super::{Error, Result, Store, Writing};
use crate::job::id::{JobId, ProgramId};
use crate::job::life::{Job, NewJob, State};
use crate::job::moment::Moment;
use crate::planning::document::files::Files;
use crate::planning::outcome::sha256_hex;

/// What is posted.
#[derive(Debug, Clone)]
pub struct Post<'a> {
    /// The job.
    pub job: NewJob,
    /// The document, byte for byte.
    pub body: &'a [u8],
    /// The files that came with it.
    pub files: &'a Files,
    /// The registered machine profiles that the document names, as they stand now: a JSON array.
    pub machines: &'a str,
    /// The sender's idempotency key.
    pub key: Option<&'a str>,
    /// The most jobs that may wait.
    pub most_queued: i64,
    /// Who posts.
    pub actor: &'a str,
    /// When.
    pub now: Moment,
}

/// What became of a post.
#[derive(Debug, Clone, PartialEq)]
pub struct Posted {
    /// The job.
    pub job: Job,
    /// Whether the same post had made it before.
    pub replayed: bool,
}

/// Which jobs are asked for.
#[derive(Debug, Clone, Default)]
pub struct JobFilter {
    /// In this state.
    pub state: Option<String>,
    /// Of this kind.
    pub kind: Option<String>,
    /// With this reference, name and value.
    pub reference: Option<(String, String)>,
    /// Older than this one.
    pub before: Option<JobId>,
    /// At most so many.
    pub limit: i64,
}

/// A row of the table.
#[derive(sqlx::FromRow)]
struct JobRow {
    id: String,
    kind: String,
    name: String,
    labels: String,
    dry_run_of: Option<String>,
    created_at: i64,
    attempts: i64,
    fence: i64,
    version: i64,
    life: String,
}

impl TryFrom<JobRow> for Job {
    type Error = Error;

    fn try_from(row: JobRow) -> Result<Self> {
        Ok(Self {
            id: row.id.parse()?,
            kind: row.kind,
            name: row.name,
            references: serde_json::from_str(&row.labels)?,
            dry_run_of: row.dry_run_of.map(|id| id.parse()).transpose()?,
            created_at: Moment::from_unix_ms(row.created_at),
            attempts: u32::try_from(row.attempts).unwrap_or(u32::MAX),
            fence: row.fence,
            version: row.version,
            state: serde_json::from_str(&row.life)?,
        })
    }
}

impl Store {
    /// Takes a job in, once for each idempotency key, and once as the dry run of a program. When this returns, the job survives a power loss.
    ///
    /// # Errors
    /// `KeyReused`, `QueueFull`, `Database`.
    pub async fn post(&self, post: Post<'_>) -> Result<Posted> {
        let set_sha256 = set_sha256(post.body, post.files);
        let mut tx = self.write().await?;
        if let Some(key) = post.key
            && let Some(job) = keyed(&mut tx, post.actor, key, &set_sha256).await?
        {
            return Ok(Posted { job, replayed: true });
        }
        if let Some(program) = &post.job.dry_run_of
            && let Some(job) = dry_run_of(&mut tx, program).await?
        {
            return Ok(Posted { job, replayed: true });
        }
        refuse_when_full(&mut tx, post.most_queued).await?;
        let job = Job::queue(post.job.clone(), post.now);
        insert(&mut tx, &job).await?;
        insert_references(&mut tx, &job).await?;
        insert_input(&mut tx, &job.id, &post).await?;
        insert_files(&mut tx, &job.id, post.files).await?;
        if let Some(key) = post.key {
            insert_key(&mut tx, &post, key, &set_sha256).await?;
        }
        record(&mut tx, &job, post.actor, post.now).await?;
        tx.commit().await?;
        self.changes.announce(&job.id);
        Ok(Posted { job, replayed: false })
    }

    /// The job that this sender has posted with this key, body and files, if there is one.
    ///
    /// # Errors
    /// `KeyReused`, `Database`.
    pub async fn posted_before(
        &self,
        actor: &str,
        key: &str,
        body: &[u8],
        files: &Files,
    ) -> Result<Option<Job>> {
        let mut reader = self.readers.acquire().await?;
        keyed(&mut reader, actor, key, &set_sha256(body, files)).await
    }

    /// The job that plans, or has planned, the dry run of a program: not one that has failed or was cancelled, nor one
    /// whose program is out of use.
    ///
    /// # Errors
    /// `Database`.
    pub async fn dry_run_of(&self, program: &ProgramId) -> Result<Option<Job>> {
        let mut reader = self.readers.acquire().await?;
        dry_run_of(&mut reader, program).await
    }

    /// A job.
    ///
    /// # Errors
    /// `NotFound`, `Database`.
    pub async fn job(&self, id: &JobId) -> Result<Job> {
        let mut reader = self.readers.acquire().await?;
        find(&mut reader, id).await
    }

    /// Jobs, the newest first.
    ///
    /// # Errors
    /// `Database`.
    pub async fn jobs(&self, filter: &JobFilter) -> Result<Vec<Job>> {
        let (name, value) = filter.reference.clone().unzip();
        let rows: Vec<JobRow> = sqlx::query_as(
            "SELECT id, kind, name, labels, dry_run_of, created_at, attempts, fence, version, life FROM jobs
             WHERE ($1 IS NULL OR state = $1)
               AND ($2 IS NULL OR kind = $2)
               AND ($3 IS NULL OR id IN (SELECT job_id FROM job_references WHERE name = $3 AND value = $4))
               AND ($5 IS NULL OR id < $5)
             ORDER BY id DESC LIMIT $6",
        )
        .bind(&filter.state)
        .bind(&filter.kind)
        .bind(name)
        .bind(value)
        .bind(filter.before.as_ref().map(JobId::as_str))
        .bind(filter.limit)
        .fetch_all(&self.readers)
        .await?;
        rows.into_iter().map(Job::try_from).collect()
    }

    /// The document of a job, byte for byte as it was posted.
    ///
    /// # Errors
    /// `NotFound`, `Damaged`, `Database`.
    pub async fn job_input(&self, id: &JobId) -> Result<Vec<u8>> {
        let mut reader = self.readers.acquire().await?;
        Ok(input(&mut reader, id).await?.0)
    }

    /// Cancels a job, whether it waits or runs. Its worker hears of it and ends the attempt.
    ///
    /// # Errors
    /// `NotFound`, `Illegal` if it has succeeded or failed, `Database`.
    pub async fn cancel(&self, id: &JobId, actor: &str, reason: Option<String>, now: Moment) -> Result<Job> {
        let mut tx = self.write().await?;
        let before = find(&mut tx, id).await?;
        let job = before.clone().cancel(actor, reason, now)?;
        if job.version != before.version {
            save(&mut tx, &job).await?;
            close_attempt(&mut tx, &before, "cancelled", now).await?;
            record(&mut tx, &job, actor, now).await?;
        }
        tx.commit().await?;
        self.changes.announce(id);
        Ok(job)
    }

    /// How many jobs are in each state.
    ///
    /// # Errors
    /// `Database`.
    pub async fn jobs_by_state(&self) -> Result<BTreeMap<String, i64>> {
        let rows: Vec<(String, i64)> = sqlx::query_as("SELECT state, COUNT(*) FROM jobs GROUP BY state")
            .fetch_all(&self.readers)
            .await?;
        Ok(rows.into_iter().collect())
    }
}

/// A job, within a transaction or outside.
pub(super) async fn find(connection: &mut SqliteConnection, id: &JobId) -> Result<Job> {
    let row: Option<JobRow> = sqlx::query_as(
        "SELECT id, kind, name, labels, dry_run_of, created_at, attempts, fence, version, life FROM jobs WHERE id = $1",
    )
    .bind(id.as_str())
    .fetch_optional(connection)
    .await?;
    row.ok_or(Error::NotFound)?.try_into()
}

/// The document of a job and the profiles that were frozen with it.
pub(super) async fn input(connection: &mut SqliteConnection, id: &JobId) -> Result<(Vec<u8>, String)> {
    let row: Option<(Vec<u8>, String, String)> =
        sqlx::query_as("SELECT body, machines, sha256 FROM job_inputs WHERE job_id = $1")
            .bind(id.as_str())
            .fetch_optional(connection)
            .await?;
    let (body, machines, sha256) = row.ok_or(Error::NotFound)?;
    if sha256_hex(&body) != sha256 {
        return Err(Error::Damaged { subject: format!("the input of {id}") });
    }
    Ok((body, machines))
}

/// Writes what a transition has changed.
pub(super) async fn save(tx: &mut Writing, job: &Job) -> Result<()> {
    let changed = sqlx::query(
        "UPDATE jobs SET attempts = $2, fence = $3, version = $4, state = $5, queued_since = $6, life = $7
         WHERE id = $1 AND version < $4",
    )
    .bind(job.id.as_str())
    .bind(i64::from(job.attempts))
    .bind(job.fence)
    .bind(job.version)
    .bind(job.state.word())
    .bind(queued_since(job))
    .bind(serde_json::to_string(&job.state)?)
    .execute(&mut **tx)
    .await?;
    if changed.rows_affected() == 1 { Ok(()) } else { Err(Error::NotFound) }
}

/// Writes the audit row and the event of a change of state.
pub(super) async fn record(tx: &mut Writing, job: &Job, actor: &str, now: Moment) -> Result<()> {
    let action = format!("job.{}", job.state.word());
    let deed = Deed { at: now, actor, action: &action, subject: job.id.as_str(), detail: describe(job) };
    audit::record(tx, &deed).await?;
    note_state(tx, job, now).await
}

/// Closes the attempt that a job was in.
pub(super) async fn close_attempt(tx: &mut Writing, before: &Job, ending: &str, now: Moment) -> Result<()> {
    sqlx::query(
        "UPDATE attempts SET ended_at = $3, ending = $4 WHERE job_id = $1 AND fence = $2 AND ended_at IS NULL",
    )
    .bind(before.id.as_str())
    .bind(before.fence)
    .bind(now.unix_ms())
    .bind(ending)
    .execute(&mut **tx)
    .await?;
    Ok(())
}

/// What a repeated post must have in common with the first: the document byte for byte, and the names and bytes of
/// all files, in whatever order or wrapping they came. Without files it is the hash of the document.
fn set_sha256(body: &[u8], files: &Files) -> String {
    let body_sha256 = sha256_hex(body);
    if files.is_empty() {
        return body_sha256;
    }
    sha256_hex(format!("{body_sha256}\n{}", files.listing()).as_bytes())
}

async fn keyed(
    connection: &mut SqliteConnection,
    actor: &str,
    key: &str,
    set_sha256: &str,
) -> Result<Option<Job>> {
    let row: Option<(String, String)> =
        sqlx::query_as("SELECT body_sha256, job_id FROM idempotency_keys WHERE actor = $1 AND name = $2")
            .bind(actor)
            .bind(key)
            .fetch_optional(&mut *connection)
            .await?;
    match row {
        None => Ok(None),
        Some((stored, _)) if stored != set_sha256 => Err(Error::KeyReused),
        Some((_, job)) => Ok(Some(find(connection, &job.parse()?).await?)),
    }
}

async fn dry_run_of(connection: &mut SqliteConnection, program: &ProgramId) -> Result<Option<Job>> {
    let row: Option<(String,)> = sqlx::query_as(
        "SELECT j.id FROM jobs j LEFT JOIN programs p ON p.job_id = j.id
         WHERE j.dry_run_of = $1 AND j.state NOT IN ('failed', 'cancelled')
           AND (p.id IS NULL OR p.state IN ('draft', 'approved'))
         ORDER BY j.id DESC LIMIT 1",
    )
    .bind(program.as_str())
    .fetch_optional(&mut *connection)
    .await?;
    match row {
        Some((id,)) => Ok(Some(find(connection, &id.parse()?).await?)),
        None => Ok(None),
    }
}

async fn refuse_when_full(tx: &mut Writing, most: i64) -> Result<()> {
    let (waiting,): (i64,) =
        sqlx::query_as("SELECT COUNT(*) FROM jobs WHERE state = 'queued'").fetch_one(&mut **tx).await?;
    if waiting >= most { Err(Error::QueueFull { waiting }) } else { Ok(()) }
}

fn queued_since(job: &Job) -> Option<i64> {
    match job.state {
        State::Queued { since } => Some(since.unix_ms()),
        _ => None,
    }
}

async fn insert(tx: &mut Writing, job: &Job) -> Result<()> {
    sqlx::query(
        "INSERT INTO jobs (id, kind, name, labels, created_at, attempts, fence, version, state, queued_since, life,
                           dry_run_of)
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12)",
    )
    .bind(job.id.as_str())
    .bind(&job.kind)
    .bind(&job.name)
    .bind(serde_json::to_string(&job.references)?)
    .bind(job.created_at.unix_ms())
    .bind(i64::from(job.attempts))
    .bind(job.fence)
    .bind(job.version)
    .bind(job.state.word())
    .bind(queued_since(job))
    .bind(serde_json::to_string(&job.state)?)
    .bind(job.dry_run_of.as_ref().map(ProgramId::as_str))
    .execute(&mut **tx)
    .await?;
    Ok(())
}

async fn insert_references(tx: &mut Writing, job: &Job) -> Result<()> {
    for (name, value) in &job.references {
        sqlx::query("INSERT INTO job_references (job_id, name, value) VALUES ($1, $2, $3)")
            .bind(job.id.as_str())
            .bind(name)
            .bind(value)
            .execute(&mut **tx)
            .await?;
    }
    Ok(())
}

async fn insert_input(tx: &mut Writing, id: &JobId, post: &Post<'_>) -> Result<()> {
    sqlx::query(
        "INSERT INTO job_inputs (job_id, sha256, bytes, machines, body, files_sha256)
         VALUES ($1, $2, $3, $4, $5, $6)",
    )
    .bind(id.as_str())
    .bind(sha256_hex(post.body))
    .bind(i64::try_from(post.body.len()).unwrap_or(i64::MAX))
    .bind(post.machines)
    .bind(post.body)
    .bind(files_sha256(post.files))
    .execute(&mut **tx)
    .await?;
    Ok(())
}

async fn insert_key(tx: &mut Writing, post: &Post<'_>, key: &str, sha256: &str) -> Result<()> {
    sqlx::query(
        "INSERT INTO idempotency_keys (actor, name, body_sha256, job_id, created_at)
         VALUES ($1, $2, $3, $4, $5)",
    )
    .bind(post.actor)
    .bind(key)
    .bind(sha256)
    .bind(post.job.id.as_str())
    .bind(post.now.unix_ms())
    .execute(&mut **tx)
    .await?;
    Ok(())
}
