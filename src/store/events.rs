//! What a follower of a job is told: numbered from 1 within the job, kept, so that a follower can resume.

use serde_json::{Value, json};

use super::{Result, Store, Writing};
use crate::job::id::JobId;
use crate::job::life::{Job, State};
use crate::job::moment::Moment;

/// Something that happened to a job.
#[derive(Debug, Clone, PartialEq, Eq, sqlx::FromRow)]
pub struct JobEvent {
    /// Its number within the job.
    pub seq: i64,
    /// When, in milliseconds since 1970.
    pub at: i64,
    /// `state` or `stage`.
    pub kind: String,
    /// What, in JSON.
    pub data: String,
}

/// Notes the state that a job is in now.
pub(super) async fn note_state(tx: &mut Writing, job: &Job, now: Moment) -> Result<()> {
    note(tx, &job.id, now, "state", &describe(job)).await
}

/// Notes a stage that an attempt has reached.
pub(super) async fn note_stage(tx: &mut Writing, job: &Job, stage: &str, at: Moment) -> Result<()> {
    note(tx, &job.id, at, "stage", &json!({"stage": stage, "attempt": job.fence})).await
}

async fn note(tx: &mut Writing, job: &JobId, at: Moment, kind: &str, data: &Value) -> Result<()> {
    sqlx::query(
        "INSERT INTO job_events (job_id, seq, at, kind, data)
         SELECT $1, COALESCE(MAX(seq), 0) + 1, $2, $3, $4 FROM job_events WHERE job_id = $1",
    )
    .bind(job.as_str())
    .bind(at.unix_ms())
    .bind(kind)
    .bind(data.to_string())
    .execute(&mut **tx)
    .await?;
    Ok(())
}

/// What is said about a state to followers and in the audit trail.
pub(super) fn describe(job: &Job) -> Value {
    let mut data = json!({"state": job.state.word(), "attempt": job.fence});
    match &job.state {
        State::Queued { .. } => {
            if let Some(program) = &job.dry_run_of {
                data["dry_run_of"] = json!(program);
            }
        }
        State::Running { .. } => {}
        State::Succeeded { usable, warnings, program, .. } => {
            data["verdict"] = json!(verdict_word(*usable));
            data["warnings"] = json!(warnings);
            data["program"] = json!(program);
        }
        State::Failed { failure, .. } => {
            data["code"] = json!(failure.code);
            data["detail"] = json!(failure.detail);
        }
        State::Cancelled { reason, .. } => data["reason"] = json!(reason),
    }
    data
}

/// The verdict as reports write it.
#[must_use]
pub fn verdict_word(usable: bool) -> &'static str {
    if usable { "usable" } else { "not_usable" }
}

impl Store {
    /// The events of a job after `seq`, in order.
    ///
    /// # Errors
    /// `Database`.
    pub async fn events(&self, job: &JobId, after: i64) -> Result<Vec<JobEvent>> {
        Ok(sqlx::query_as(
            "SELECT seq, at, kind, data FROM job_events WHERE job_id = $1 AND seq > $2 ORDER BY seq",
        )
        .bind(job.as_str())
        .bind(after)
        .fetch_all(&self.readers)
        .await?)
    }
}
