//! Runs: what machines and people say about them. Giving them out is in [`super::claims`].

use serde_json::{Value, json};
use sqlx::sqlite::SqliteConnection;

use super::audit::{self, Deed};
use super::claims::{refuse_held, refuse_other_profile};
use super::programs::{Program, Soundness, soundness, with_purpose};
use super::{Error, Result, Store, Writing, entries};
use crate::job::id::{EntryId, ProgramId, RunId};
use crate::job::moment::Moment;
use crate::job::purpose::Purpose;
use crate::job::run::{Course, Ending, Illegal, Resolution, Run, Sign};

/// Which runs are asked for.
#[derive(Debug, Clone, Default)]
pub struct RunFilter {
    /// Of this machine.
    pub machine: Option<String>,
    /// Of this entry.
    pub entry: Option<EntryId>,
    /// Of this program.
    pub program: Option<ProgramId>,
    /// In this state.
    pub state: Option<String>,
    /// Older than this one.
    pub before: Option<RunId>,
    /// At most so many.
    pub limit: i64,
}

#[derive(sqlx::FromRow)]
pub(super) struct RunRow {
    id: String,
    entry_id: String,
    unit: i64,
    program_id: String,
    purpose: String,
    from_ply: Option<i64>,
    from_course: Option<i64>,
    sha256: String,
    bytes: i64,
    machine: String,
    request_id: String,
    fence: i64,
    state: String,
    returned: i64,
    lease_until: i64,
    created_at: i64,
    version: i64,
    life: String,
}

impl TryFrom<RunRow> for Run {
    type Error = Error;

    fn try_from(row: RunRow) -> Result<Self> {
        Ok(Self {
            id: row.id.parse()?,
            entry: row.entry_id.parse()?,
            unit: row.unit,
            program: row.program_id.parse()?,
            purpose: Purpose::stored(&row.purpose, [row.from_ply, row.from_course]),
            sha256: row.sha256,
            bytes: row.bytes,
            machine: row.machine,
            request_id: row.request_id,
            fence: row.fence,
            lease_until: Moment::from_unix_ms(row.lease_until),
            returned: row.returned != 0,
            created_at: Moment::from_unix_ms(row.created_at),
            version: row.version,
            state: serde_json::from_value(row.state.into())?,
            course: serde_json::from_str::<Course>(&row.life)?,
        })
    }
}

/// A statement over runs.
macro_rules! runs_where {
    ($condition:literal) => {
        concat!(
            "SELECT id, entry_id, unit, program_id, sha256, bytes, machine, request_id, fence, state, returned,
                    lease_until, created_at, version, life,
                    (SELECT p.purpose FROM programs p WHERE p.id = runs.program_id) AS purpose,
                    (SELECT p.from_ply FROM programs p WHERE p.id = runs.program_id) AS from_ply,
                    (SELECT p.from_course FROM programs p WHERE p.id = runs.program_id) AS from_course
             FROM runs WHERE ",
            $condition
        )
    };
}
pub(super) use runs_where;

impl Store {
    /// A run.
    ///
    /// # Errors
    /// `NotFound`, `Database`.
    pub async fn run(&self, id: &RunId) -> Result<Run> {
        let mut reader = self.readers.acquire().await?;
        find(&mut reader, id).await
    }

    /// Runs, the newest first.
    ///
    /// # Errors
    /// `Database`.
    pub async fn runs(&self, filter: &RunFilter) -> Result<Vec<Run>> {
        let rows: Vec<RunRow> = sqlx::query_as(runs_where!(
            "($1 IS NULL OR machine = $1) AND ($2 IS NULL OR entry_id = $2)
               AND ($3 IS NULL OR program_id = $3) AND ($4 IS NULL OR state = $4) AND ($5 IS NULL OR id < $5)
             ORDER BY id DESC LIMIT $6"
        ))
        .bind(&filter.machine)
        .bind(filter.entry.as_ref().map(EntryId::as_str))
        .bind(filter.program.as_ref().map(ProgramId::as_str))
        .bind(&filter.state)
        .bind(filter.before.as_ref().map(RunId::as_str))
        .bind(filter.limit)
        .fetch_all(&self.readers)
        .await?;
        rows.into_iter().map(Run::try_from).collect()
    }

    /// A run's program with its bytes, verified, for the machine that holds the fence.
    ///
    /// # Errors
    /// `NotFound`; `Run` if the fence is lost or the run has ended; `NotApproved`; `Damaged`, and the program is
    /// quarantined then; `Database`.
    pub async fn run_content(&self, id: &RunId, fence: i64, now: Moment) -> Result<(Program, Vec<u8>)> {
        let run = self.run(id).await?;
        run.own(fence)?;
        if !run.state.is_live() {
            return Err(Illegal::Ended.into());
        }
        let program = self.program(&run.program).await?;
        if program.state != "approved" {
            return Err(Error::NotApproved { state: program.state });
        }
        let bytes = self.program_content(&program, now).await?;
        // The run was given out for these bytes and no others.
        if program.sha256 == run.sha256 { Ok((program, bytes)) } else { Err(Illegal::OtherBytes.into()) }
    }

    /// The machine has these bytes.
    ///
    /// # Errors
    /// `NotFound`, `Run`, `Database`.
    pub async fn receive(
        &self,
        id: &RunId,
        sign: Sign,
        sha256: &str,
        bytes: i64,
        actor: &str,
    ) -> Result<Run> {
        let mut tx = self.write().await?;
        let before = find(&mut tx, id).await?;
        let run = before.clone().receive(sign, sha256, bytes)?;
        change(tx, &before, run, actor, sign.now).await
    }

    /// The machine begins to cut: the last moment at which the service can say no.
    ///
    /// # Errors
    /// `NotFound`; `Run`; `Held`; `OtherProfile`; `NotApproved`; `Damaged`, and the program is quarantined then; `Database`.
    pub async fn start_run(&self, id: &RunId, sign: Sign, actor: &str) -> Result<Run> {
        let mut tx = self.write().await?;
        let before = find(&mut tx, id).await?;
        let run = before.clone().start(sign)?;
        refuse_held(&mut tx, &run.machine).await?;
        refuse_other_profile(&mut tx, &run.machine, &run.program).await?;
        match soundness(&mut tx, &run.program, sign.now).await? {
            Soundness::Sound => change(tx, &before, run, actor, sign.now).await,
            Soundness::NotApproved(state) => Err(Error::NotApproved { state }),
            Soundness::Damaged => {
                // The quarantine stays.
                tx.commit().await?;
                Err(Error::Damaged { subject: format!("the content of {}", run.program) })
            }
        }
    }

    /// The machine lives.
    ///
    /// # Errors
    /// `NotFound`, `Run`, `Database`.
    pub async fn beat_run(&self, id: &RunId, sign: Sign, actor: &str) -> Result<Run> {
        let mut tx = self.write().await?;
        let before = find(&mut tx, id).await?;
        let run = before.clone().heard(sign)?;
        change(tx, &before, run, actor, sign.now).await
    }

    /// The machine says how the run has ended.
    ///
    /// # Errors
    /// `NotFound`, `Run`, `Database`.
    pub async fn end_run(&self, id: &RunId, sign: Sign, ending: Ending, actor: &str) -> Result<Run> {
        let mut tx = self.write().await?;
        let before = find(&mut tx, id).await?;
        let run = before.clone().end(sign, ending)?;
        change(tx, &before, run, actor, sign.now).await
    }

    /// A person says what becomes of the unit.
    ///
    /// # Errors
    /// `NotFound`, `Run`, `Database`.
    pub async fn resolve_run(&self, id: &RunId, resolution: Resolution) -> Result<Run> {
        let mut tx = self.write().await?;
        let before = find(&mut tx, id).await?;
        let (actor, now) = (resolution.by.clone(), resolution.at);
        let run = before.clone().resolve(resolution)?;
        change(tx, &before, run, &actor, now).await
    }

    /// Makes every run suspect whose lease is over. Their units stay with them.
    ///
    /// # Errors
    /// `Database`.
    pub async fn mark_silent(&self, now: Moment) -> Result<Vec<RunId>> {
        let mut marked = Vec::new();
        for id in self.silent_runs(now).await? {
            let mut tx = self.write().await?;
            let before = find(&mut tx, &id).await?;
            match before.clone().fall_silent(now) {
                Ok(run) => {
                    change(tx, &before, run, "service", now).await?;
                    marked.push(id);
                }
                // It was heard of, or has ended, in the meantime.
                Err(Illegal::HeardOf | Illegal::Ended) => {}
                Err(other) => return Err(other.into()),
            }
        }
        Ok(marked)
    }

    /// Looks before it takes the write lock.
    async fn silent_runs(&self, now: Moment) -> Result<Vec<RunId>> {
        let rows: Vec<(String,)> = sqlx::query_as(
            "SELECT id FROM runs
             WHERE state IN ('offered', 'received', 'running') AND lease_until < $1 ORDER BY id",
        )
        .bind(now.unix_ms())
        .fetch_all(&self.readers)
        .await?;
        rows.into_iter().map(|(id,)| Ok(id.parse()?)).collect()
    }
}

/// A run, within a transaction or outside.
pub(super) async fn find(connection: &mut SqliteConnection, id: &RunId) -> Result<Run> {
    let row: Option<RunRow> =
        sqlx::query_as(runs_where!("id = $1")).bind(id.as_str()).fetch_optional(connection).await?;
    row.ok_or(Error::NotFound)?.try_into()
}

/// Writes a new run.
pub(super) async fn insert(tx: &mut Writing, run: &Run, actor: &str, now: Moment) -> Result<()> {
    sqlx::query(
        "INSERT INTO runs (id, entry_id, unit, program_id, sha256, bytes, machine, request_id, fence, state,
                           lease_until, created_at, version, life)
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13, $14)",
    )
    .bind(run.id.as_str())
    .bind(run.entry.as_str())
    .bind(run.unit)
    .bind(run.program.as_str())
    .bind(&run.sha256)
    .bind(run.bytes)
    .bind(&run.machine)
    .bind(&run.request_id)
    .bind(run.fence)
    .bind(run.state.word())
    .bind(run.lease_until.unix_ms())
    .bind(run.created_at.unix_ms())
    .bind(run.version)
    .bind(serde_json::to_string(&run.course)?)
    .execute(&mut **tx)
    .await?;
    record(tx, run, actor, now).await
}

/// Writes what a transition has changed, with what it means for the entry. A change of the lease alone leaves no
/// audit row.
async fn change(mut tx: Writing, before: &Run, run: Run, actor: &str, now: Moment) -> Result<Run> {
    if run.version == before.version {
        return Ok(run);
    }
    save(&mut tx, &run).await?;
    if run.state != before.state || run.fence != before.fence {
        record(&mut tx, &run, actor, now).await?;
        entries::settle(&mut tx, &run.entry, actor, now).await?;
    }
    tx.commit().await?;
    Ok(run)
}

async fn save(tx: &mut Writing, run: &Run) -> Result<()> {
    let changed = sqlx::query(
        "UPDATE runs SET fence = $2, state = $3, returned = $4, scrapped = $5, lease_until = $6, version = $7,
                         life = $8
         WHERE id = $1 AND version < $7",
    )
    .bind(run.id.as_str())
    .bind(run.fence)
    .bind(run.state.word())
    .bind(i64::from(run.returned))
    .bind(i64::from(run.is_scrapped()))
    .bind(run.lease_until.unix_ms())
    .bind(run.version)
    .bind(serde_json::to_string(&run.course)?)
    .execute(&mut **tx)
    .await?;
    if changed.rows_affected() == 1 { Ok(()) } else { Err(Error::NotFound) }
}

async fn record(tx: &mut Writing, run: &Run, actor: &str, now: Moment) -> Result<()> {
    let action = format!("run.{}", run.state.word());
    let deed = Deed { at: now, actor, action: &action, subject: run.id.as_str(), detail: describe(run) };
    audit::record(tx, &deed).await
}

/// What an auditor asks of a run: which bytes, where, for what, with what, and who decided.
fn describe(run: &Run) -> Value {
    let detail = json!({
        "entry": run.entry, "unit": run.unit, "program": run.program, "sha256": run.sha256,
        "machine": run.machine, "fence": run.fence
    });
    let mut detail = with_purpose(detail, run.purpose);
    if !run.state.is_live() {
        detail["returned"] = json!(run.returned);
        detail["reason"] = json!(run.course.reason);
        detail["material"] = json!(run.course.material);
    }
    if let Some(resolution) = &run.course.resolution {
        detail["resolution"] = json!({"how": resolution.how, "reason": resolution.reason});
    }
    detail
}
