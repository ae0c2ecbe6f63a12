//! What a job gave: its report, its drawings, its program.

use super::programs::{NewProgram, Planned, insert_program};
use super::{Error, Result, Store, Writing};
use crate::job::id::JobId;
use crate::job::life::{Job, StageTime};
use crate::job::moment::Moment;
use crate::job::purpose::Purpose;
use crate::planning::outcome::sha256_hex;
use crate::planning::tape::label::CourseLabel;

/// What an attempt gives back to be kept.
#[derive(Debug, Clone)]
pub struct Answer {
    /// The bytes of `report.json`.
    pub report: Vec<u8>,
    /// Its verdict.
    pub usable: bool,
    /// How many warnings it holds.
    pub warnings: u32,
    /// The drawings.
    pub drawings: Vec<NewDrawing>,
    /// The program, if the verdict is usable.
    pub program: Option<NewProgram>,
    /// How long each stage took.
    pub stages: Vec<StageTime>,
}

/// A drawing to be kept.
#[derive(Debug, Clone)]
pub struct NewDrawing {
    /// Its name, ending in `.svg`.
    pub name: String,
    /// Its text.
    pub body: Vec<u8>,
}

impl Store {
    /// The report of a job, byte for byte.
    ///
    /// # Errors
    /// `NotFound`, `Damaged`, `Database`.
    pub async fn report(&self, job: &JobId) -> Result<Vec<u8>> {
        let row: Option<(Vec<u8>, String)> =
            sqlx::query_as("SELECT body, sha256 FROM reports WHERE job_id = $1")
                .bind(job.as_str())
                .fetch_optional(&self.readers)
                .await?;
        let (body, sha256) = row.ok_or(Error::NotFound)?;
        if sha256_hex(&body) == sha256 {
            Ok(body)
        } else {
            Err(Error::Damaged { subject: format!("the report of {job}") })
        }
    }

    /// The names of a job's drawings, in the order of the report.
    ///
    /// # Errors
    /// `Database`.
    pub async fn drawing_names(&self, job: &JobId) -> Result<Vec<String>> {
        let rows: Vec<(String,)> =
            sqlx::query_as("SELECT name FROM drawings WHERE job_id = $1 ORDER BY position")
                .bind(job.as_str())
                .fetch_all(&self.readers)
                .await?;
        Ok(rows.into_iter().map(|(name,)| name).collect())
    }

    /// A drawing of a job.
    ///
    /// # Errors
    /// `NotFound`, `Database`.
    pub async fn drawing(&self, job: &JobId, name: &str) -> Result<Vec<u8>> {
        let row: Option<(Vec<u8>,)> =
            sqlx::query_as("SELECT body FROM drawings WHERE job_id = $1 AND name = $2")
                .bind(job.as_str())
                .bind(name)
                .fetch_optional(&self.readers)
                .await?;
        Ok(row.ok_or(Error::NotFound)?.0)
    }
}

/// Writes report, drawings and program, and gives back what the program is for.
pub(super) async fn insert_answer(
    tx: &mut Writing,
    job: &Job,
    answer: &Answer,
    now: Moment,
) -> Result<Purpose> {
    sqlx::query("INSERT INTO reports (job_id, sha256, body) VALUES ($1, $2, $3)")
        .bind(job.id.as_str())
        .bind(sha256_hex(&answer.report))
        .bind(&answer.report)
        .execute(&mut **tx)
        .await?;
    for (position, drawing) in (1_i64..).zip(&answer.drawings) {
        sqlx::query("INSERT INTO drawings (job_id, position, name, body) VALUES ($1, $2, $3, $4)")
            .bind(job.id.as_str())
            .bind(position)
            .bind(&drawing.name)
            .bind(&drawing.body)
            .execute(&mut **tx)
            .await?;
    }
    let planned = planned(&answer.report)?;
    let purpose = planned.purpose;
    if let Some(program) = &answer.program {
        insert_program(tx, job, program, planned, now).await?;
    }
    Ok(purpose)
}

/// What a report says of its program: for which profile it was planned, and for what.
fn planned(report: &[u8]) -> Result<Planned> {
    #[derive(serde::Deserialize)]
    struct Report {
        machine: Option<Machine>,
        from_course: Option<u32>,
        from_ply: Option<u32>,
        #[serde(default)]
        dry_run: bool,
    }
    #[derive(serde::Deserialize)]
    struct Machine {
        profile_sha256: String,
    }
    let report: Report = serde_json::from_slice(report)?;
    let from_course = report.from_course.map(|number| CourseLabel { ply: report.from_ply, number });
    let purpose = Purpose::of(report.dry_run, from_course);
    Ok(Planned { profile_sha256: report.machine.map(|machine| machine.profile_sha256), purpose })
}
