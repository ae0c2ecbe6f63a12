//! What entries wait for, beside their turn.

use sqlx::sqlite::SqliteConnection;

use super::{Error, Result, Store, entries};
use crate::job::entry::{Entry, EntryState};
use crate::job::id::ProgramId;
use crate::job::program::Standing;
use crate::job::waiting::{Taker, WaitingFor, waiting_for};

/// So many entries that wait for more than their turn are shown to a machine.
const MOST_SHOWN: i64 = 10;

/// A statement over machines, with whether each has the profile `$2`.
macro_rules! takers_where {
    ($condition:literal) => {
        concat!(
            "SELECT m.name, m.profile_sha256 IS NOT DISTINCT FROM $2 AS fits, m.held_by, m.held_reason,
                    (SELECT r.id FROM runs r WHERE r.machine = m.name AND r.state = 'suspect') AS suspect
             FROM machines m WHERE ",
            $condition,
            " ORDER BY m.name"
        )
    };
}

#[derive(sqlx::FromRow)]
struct TakerRow {
    name: String,
    fits: bool,
    held_by: Option<String>,
    held_reason: Option<String>,
    suspect: Option<String>,
}

impl From<TakerRow> for Taker {
    fn from(row: TakerRow) -> Self {
        let hold = row.held_by.map(|by| (by, row.held_reason.unwrap_or_default()));
        Self { name: row.name, fits: row.fits, hold, suspect: row.suspect }
    }
}

impl Store {
    /// What an entry waits for, if that is more than its turn: with all machines that take from its queue.
    ///
    /// # Errors
    /// `NoProgram`, `Database`.
    pub async fn waiting_for(&self, entry: &Entry) -> Result<Option<WaitingFor>> {
        if entry.state != EntryState::Queued {
            return Ok(None);
        }
        let mut reader = self.readers.acquire().await?;
        let (standing, profile) = program(&mut reader, &entry.program).await?;
        let takers: Vec<TakerRow> = sqlx::query_as(takers_where!("(m.name = $1 OR m.pool = $1)"))
            .bind(&entry.queue)
            .bind(profile)
            .fetch_all(&mut *reader)
            .await?;
        let takers: Vec<Taker> = takers.into_iter().map(Taker::from).collect();
        Ok(waiting_for(&entry.program, standing, &takers))
    }

    /// The entries in the queues of a machine that it is not given, in their order, with what each waits for: at most
    /// ten. A hold of the machine itself, or a suspect run, is no reason here: both are said of the machine.
    ///
    /// # Errors
    /// `NoMachine`, `Database`.
    pub async fn waiting_at(&self, machine: &str) -> Result<Vec<(Entry, WaitingFor)>> {
        let mut reader = self.readers.acquire().await?;
        let rows: Vec<(String,)> = sqlx::query_as(
            "SELECT e.id FROM entries e
             JOIN machines m ON m.name = $1 AND (e.queue = m.name OR e.queue = m.pool)
             JOIN programs p ON p.id = e.program_id
             LEFT JOIN approvals a ON a.program_id = p.id
             WHERE e.state = 'queued' AND (p.state <> 'approved' OR a.sha256 IS DISTINCT FROM p.sha256
                 OR p.profile_sha256 IS DISTINCT FROM m.profile_sha256)
             ORDER BY e.position, e.id LIMIT $2",
        )
        .bind(machine)
        .bind(MOST_SHOWN)
        .fetch_all(&mut *reader)
        .await?;
        let mut waiting = Vec::with_capacity(rows.len());
        for (id,) in rows {
            let entry = entries::find(&mut reader, &id.parse()?).await?;
            if let Some(found) = for_machine(&mut reader, &entry, machine).await? {
                waiting.push((entry, found));
            }
        }
        Ok(waiting)
    }

    /// What an entry waits for, as a machine sees it that takes from its queue.
    ///
    /// # Errors
    /// `NoProgram`, `Database`.
    pub async fn waiting_for_machine(&self, entry: &Entry, machine: &str) -> Result<Option<WaitingFor>> {
        let mut reader = self.readers.acquire().await?;
        for_machine(&mut reader, entry, machine).await
    }
}

async fn for_machine(
    connection: &mut SqliteConnection,
    entry: &Entry,
    machine: &str,
) -> Result<Option<WaitingFor>> {
    let (standing, profile) = program(connection, &entry.program).await?;
    let takers: Vec<TakerRow> = sqlx::query_as(takers_where!("m.name = $1"))
        .bind(machine)
        .bind(profile)
        .fetch_all(connection)
        .await?;
    let takers: Vec<Taker> = takers.into_iter().map(Taker::from).collect();
    Ok(waiting_for(&entry.program, standing, &takers))
}

/// Where a program stands, and the profile that it was planned for. One that was approved with other bytes is none
/// that is approved.
async fn program(connection: &mut SqliteConnection, id: &ProgramId) -> Result<(Standing, Option<String>)> {
    let row: Option<(String, Option<String>)> = sqlx::query_as(
        "SELECT CASE WHEN p.state = 'approved' AND a.sha256 IS DISTINCT FROM p.sha256 THEN 'draft' ELSE p.state END,
                p.profile_sha256
         FROM programs p LEFT JOIN approvals a ON a.program_id = p.id WHERE p.id = $1",
    )
    .bind(id.as_str())
    .fetch_optional(connection)
    .await?;
    let (word, profile) = row.ok_or(Error::NoProgram)?;
    Ok((Standing::of(&word).ok_or(Error::NoProgram)?, profile))
}
