//! Attempts: claiming, heartbeats, progress, and the way an attempt ends. Every write is fenced.

use std::sync::Arc;

use sqlx::Row;

use super::audit::{self, Deed};
use super::events::note_stage;
use super::files::files;
use super::jobs::{close_attempt, find, input, record, save};
use super::programs::with_purpose;
use super::results::{Answer, insert_answer};
use super::{Result, Store, Writing};
use crate::job::id::{JobId, ProgramId, WorkerId};
use crate::job::life::{Failure, Illegal, Job};
use crate::job::moment::Moment;
use crate::job::purpose::Purpose;
use crate::planning::document::files::Files;

/// What an attempt plans, frozen when the job was posted.
#[derive(Debug, Clone)]
pub struct AttemptInput {
    /// The document, byte for byte.
    pub body: Arc<Vec<u8>>,
    /// The files that came with it.
    pub files: Arc<Files>,
    /// The registered profiles that the document names: a JSON array.
    pub machines: String,
}

/// Whose heartbeat counts as lost.
#[derive(Debug, Clone, Copy)]
pub enum Lost {
    /// Everybody's: no other process serves this store.
    All,
    /// Whoever was silent since this moment.
    SilentSince(Moment),
}

impl Store {
    /// Gives the job that waits longest to a worker, and counts the attempt.
    ///
    /// # Errors
    /// `Database`.
    pub async fn claim(&self, worker: &WorkerId, now: Moment) -> Result<Option<Job>> {
        let mut tx = self.write().await?;
        let waiting =
            sqlx::query("SELECT id FROM jobs WHERE state = 'queued' ORDER BY queued_since, id LIMIT 1")
                .fetch_optional(&mut *tx)
                .await?;
        let Some(row) = waiting else { return Ok(None) };
        let id: JobId = row.get::<String, _>("id").parse()?;
        let job = find(&mut tx, &id).await?.start(worker.clone(), now)?;
        save(&mut tx, &job).await?;
        insert_attempt(&mut tx, &job, worker, now).await?;
        record(&mut tx, &job, worker.as_str(), now).await?;
        tx.commit().await?;
        self.changes.announce(&id);
        Ok(Some(job))
    }

    /// Whether any job waits.
    ///
    /// # Errors
    /// `Database`.
    pub async fn any_queued(&self) -> Result<bool> {
        let first = sqlx::query("SELECT 1 FROM jobs WHERE state = 'queued' LIMIT 1");
        Ok(first.fetch_optional(&self.readers).await?.is_some())
    }

    /// What an attempt of this job plans.
    ///
    /// # Errors
    /// `Damaged` if the stored document or its files do not fit their hash any more, `Database`.
    pub async fn attempt_input(&self, id: &JobId) -> Result<AttemptInput> {
        let mut reader = self.readers.acquire().await?;
        let (body, machines) = input(&mut reader, id).await?;
        let files = files(&mut reader, id).await?;
        Ok(AttemptInput { body: Arc::new(body), files: Arc::new(files), machines })
    }

    /// Says that an attempt goes on. False: it is not the job's current one any more.
    ///
    /// # Errors
    /// `Database`.
    pub async fn heartbeat(&self, job: &JobId, fence: i64, now: Moment) -> Result<bool> {
        let mut tx = self.write().await?;
        let beaten = sqlx::query(
            "UPDATE attempts SET heartbeat_at = $3
             WHERE job_id = $1 AND fence = $2 AND ended_at IS NULL
               AND EXISTS (SELECT 1 FROM jobs WHERE id = $1 AND fence = $2 AND state = 'running')",
        )
        .bind(job.as_str())
        .bind(fence)
        .bind(now.unix_ms())
        .execute(&mut *tx)
        .await?;
        tx.commit().await?;
        Ok(beaten.rows_affected() == 1)
    }

    /// Notes the stages that an attempt has reached since it last said so.
    ///
    /// # Errors
    /// `Illegal` if the fence is lost, `Database`.
    pub async fn reach(&self, id: &JobId, fence: i64, stages: &[(String, Moment)]) -> Result<()> {
        let mut tx = self.write().await?;
        let mut job = find(&mut tx, id).await?;
        for (stage, at) in stages {
            job = job.reach(fence, stage)?;
            note_stage(&mut tx, &job, stage, *at).await?;
        }
        save(&mut tx, &job).await?;
        tx.commit().await?;
        self.changes.announce(id);
        Ok(())
    }

    /// Commits an answer: report, drawings, program and the end of the job, together.
    ///
    /// # Errors
    /// `Illegal` if the fence is lost: nothing is written then. `Database`.
    pub async fn succeed(
        &self,
        id: &JobId,
        fence: i64,
        answer: &Answer,
        reached: &[(String, Moment)],
        now: Moment,
    ) -> Result<Job> {
        let mut tx = self.write().await?;
        let before = find(&mut tx, id).await?;
        let program = answer.program.as_ref().map(|program| program.id.clone());
        let job = before.clone().succeed(
            fence,
            (answer.usable, answer.warnings),
            program.clone(),
            answer.stages.clone(),
            now,
        )?;
        let purpose = insert_answer(&mut tx, &job, answer, now).await?;
        for (stage, at) in reached {
            note_stage(&mut tx, &job, stage, *at).await?;
        }
        self.end(tx, before, job, "succeeded", now, program.zip(Some(purpose))).await
    }

    /// Ends a job without an answer.
    ///
    /// # Errors
    /// `Illegal` if the fence is lost, `Database`.
    pub async fn fail(&self, id: &JobId, fence: i64, failure: Failure, now: Moment) -> Result<Job> {
        let mut tx = self.write().await?;
        let before = find(&mut tx, id).await?;
        let ending = failure.code.as_str();
        let job = before.clone().fail(fence, failure, now)?;
        self.end(tx, before, job, ending, now, None).await
    }

    /// Ends an attempt that was lost, killed or too slow; the job waits again, or fails after the last one.
    ///
    /// # Errors
    /// `Illegal` if the fence is lost, `Database`.
    pub async fn retry(&self, id: &JobId, fence: i64, why: &str, now: Moment) -> Result<Job> {
        let mut tx = self.write().await?;
        let before = find(&mut tx, id).await?;
        let job = before.clone().retry(fence, why, now)?;
        self.end(tx, before, job, why, now, None).await
    }

    /// Gives an attempt back that was stopped in order; it does not count.
    ///
    /// # Errors
    /// `Illegal` if the fence is lost, `Database`.
    pub async fn release(&self, id: &JobId, fence: i64, now: Moment) -> Result<Job> {
        let mut tx = self.write().await?;
        let before = find(&mut tx, id).await?;
        let job = before.clone().release(fence)?;
        self.end(tx, before, job, "released", now, None).await
    }

    /// Ends the attempts of lost workers; their jobs wait again, or fail after the last one.
    ///
    /// # Errors
    /// `Database`.
    pub async fn recover(&self, lost: Lost, now: Moment) -> Result<Vec<JobId>> {
        let mut recovered = Vec::new();
        for (id, fence) in self.silent(lost).await? {
            match self.retry(&id, fence, "its worker was lost", now).await {
                Ok(_) => recovered.push(id),
                // It ended by itself in the meantime.
                Err(super::Error::Illegal(Illegal::FenceLost)) => {}
                Err(error) => return Err(error),
            }
        }
        Ok(recovered)
    }

    async fn silent(&self, lost: Lost) -> Result<Vec<(JobId, i64)>> {
        let since = match lost {
            Lost::All => i64::MAX,
            Lost::SilentSince(moment) => moment.unix_ms(),
        };
        let rows: Vec<(String, i64)> = sqlx::query_as(
            "SELECT j.id, j.fence FROM jobs j
             JOIN attempts a ON a.job_id = j.id AND a.fence = j.fence
             WHERE j.state = 'running' AND a.heartbeat_at < $1 ORDER BY j.id",
        )
        .bind(since)
        .fetch_all(&self.readers)
        .await?;
        rows.into_iter().map(|(id, fence)| Ok((id.parse()?, fence))).collect()
    }

    /// Writes the end of an attempt and what became of its job.
    async fn end(
        &self,
        mut tx: Writing,
        before: Job,
        job: Job,
        ending: &str,
        now: Moment,
        program: Option<(ProgramId, Purpose)>,
    ) -> Result<Job> {
        let actor = actor_of(&before);
        save(&mut tx, &job).await?;
        close_attempt(&mut tx, &before, ending, now).await?;
        record(&mut tx, &job, &actor, now).await?;
        if let Some((program, purpose)) = program {
            let detail = with_purpose(serde_json::json!({"job": job.id}), purpose);
            let action = "program.drafted";
            let deed = Deed { at: now, actor: &actor, action, subject: program.as_str(), detail };
            audit::record(&mut tx, &deed).await?;
        }
        tx.commit().await?;
        self.changes.announce(&job.id);
        Ok(job)
    }
}

/// Whoever ran the attempt that ends here.
fn actor_of(before: &Job) -> String {
    match &before.state {
        crate::job::life::State::Running { worker, .. } => worker.to_string(),
        _ => "service".to_owned(),
    }
}

async fn insert_attempt(tx: &mut Writing, job: &Job, worker: &WorkerId, now: Moment) -> Result<()> {
    sqlx::query(
        "INSERT INTO attempts (job_id, fence, worker, started_at, heartbeat_at) VALUES ($1, $2, $3, $4, $4)",
    )
    .bind(job.id.as_str())
    .bind(job.fence)
    .bind(worker.as_str())
    .bind(now.unix_ms())
    .execute(&mut **tx)
    .await?;
    Ok(())
}
