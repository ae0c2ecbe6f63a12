//! Claims: giving the next unit to a machine, at most once.

use super::programs::{Soundness, soundness};
use super::runs::{RunRow, insert, runs_where};
use super::{Error, Result, Store, Writing, entries};
use crate::job::entry::Entry;
use crate::job::id::{EntryId, ProgramId, RunId};
use crate::job::moment::Moment;
use crate::job::run::{NewRun, Run};

/// A machine asks for its next unit.
#[derive(Debug, Clone)]
pub struct Claim<'a> {
    /// The machine.
    pub machine: &'a str,
    /// The machine's own name for this claim; a repeated one gives the same run.
    pub request_id: &'a str,
    /// The id of the run, if there is one to give.
    pub id: RunId,
    /// How long the machine may be silent.
    pub lease_until: Moment,
    /// Who asks.
    pub actor: &'a str,
    /// When.
    pub now: Moment,
}

/// What a claim gave.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Claimed {
    /// A new run.
    New(Run),
    /// The run that the machine has already.
    Known(Run),
    /// Nothing waits for this machine.
    Nothing,
}

/// What a machine would be given.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Peek {
    /// Who holds the machine, and why.
    pub hold: Option<(String, String)>,
    /// The run that occupies it.
    pub run: Option<Run>,
    /// The entry that comes next, and which unit of it.
    pub next: Option<(Entry, i64)>,
}

#[derive(sqlx::FromRow)]
struct MachineRow {
    pool: Option<String>,
    profile_sha256: String,
    held_by: Option<String>,
    held_reason: Option<String>,
}

/// The first entry of a machine's two queues whose program is approved and was planned for exactly the profile
/// that the machine has, as far as its bytes are what they were.
const NEXT_ENTRY: &str = "SELECT e.id FROM entries e
    JOIN programs p ON p.id = e.program_id AND p.state = 'approved'
        AND p.profile_sha256 = $3
    JOIN approvals a ON a.program_id = p.id AND a.sha256 = p.sha256
    WHERE e.state = 'queued' AND (e.queue = $1 OR e.queue = $2)
    ORDER BY e.position, e.id LIMIT 1";

impl Store {
    /// Gives a machine its next unit, in one transaction: the same run for the same request, the run that occupies
    /// the machine for another one, else the lowest free unit of the first entry that is sound.
    ///
    /// # Errors
    /// `NoMachine`, `Held`, `Database`; the indexes of the table make a unit that is given out twice an error.
    pub async fn claim_run(&self, claim: &Claim<'_>) -> Result<Claimed> {
        let mut tx = self.write().await?;
        let machine = machine(&mut tx, claim.machine).await?;
        if let Some(run) = known(&mut tx, claim).await? {
            return Ok(Claimed::Known(run));
        }
        machine.refuse_held()?;
        let claimed = match next_sound(&mut tx, claim, &machine).await? {
            Some(entry) => Claimed::New(give(&mut tx, claim, &entry).await?),
            None => Claimed::Nothing,
        };
        // With nothing to give, a quarantine may still have to be kept.
        tx.commit().await?;
        Ok(claimed)
    }

    /// What a machine would be given; nothing is claimed, and no bytes are looked at.
    ///
    /// # Errors
    /// `NoMachine`, `Database`.
    pub async fn peek(&self, name: &str) -> Result<Peek> {
        let mut reader = self.readers.acquire().await?;
        let machine = machine(&mut reader, name).await?;
        let run = live(&mut reader, name).await?;
        let next: Option<(String,)> = next_entry(name, &machine).fetch_optional(&mut *reader).await?;
        let next = match next {
            Some((id,)) => {
                let entry = entries::find(&mut reader, &id.parse()?).await?;
                let unit = free_unit(&mut reader, &entry.id).await?;
                Some((entry, unit))
            }
            None => None,
        };
        Ok(Peek { hold: machine.held_by.zip(machine.held_reason), run, next })
    }
}

impl MachineRow {
    fn refuse_held(&self) -> Result<()> {
        match (&self.held_by, &self.held_reason) {
            (Some(by), reason) => {
                Err(Error::Held { by: by.clone(), reason: reason.clone().unwrap_or_default() })
            }
            _ => Ok(()),
        }
    }
}

type IdQuery<'q> = sqlx::query::QueryAs<'q, sqlx::Sqlite, (String,), sqlx::sqlite::SqliteArguments>;

fn next_entry<'q>(name: &'q str, machine: &'q MachineRow) -> IdQuery<'q> {
    sqlx::query_as(NEXT_ENTRY).bind(name).bind(&machine.pool).bind(&machine.profile_sha256)
}

/// Refuses a program that was planned for another profile than the machine has. A name that is a pool's passes:
/// each machine of the pool is looked at when it claims.
pub(super) async fn refuse_other_profile(tx: &mut Writing, machine: &str, program: &ProgramId) -> Result<()> {
    let (other,): (bool,) = sqlx::query_as(
        "SELECT EXISTS (SELECT 1 FROM machines m JOIN programs p ON p.id = $2
         WHERE m.name = $1 AND m.profile_sha256 IS DISTINCT FROM p.profile_sha256)",
    )
    .bind(machine)
    .bind(program.as_str())
    .fetch_one(&mut **tx)
    .await?;
    if other { Err(Error::OtherProfile) } else { Ok(()) }
}

/// Refuses a machine that is on hold.
pub(super) async fn refuse_held(tx: &mut Writing, name: &str) -> Result<()> {
    machine(tx, name).await?.refuse_held()
}

async fn machine(connection: &mut sqlx::SqliteConnection, name: &str) -> Result<MachineRow> {
    let row =
        sqlx::query_as("SELECT pool, profile_sha256, held_by, held_reason FROM machines WHERE name = $1")
            .bind(name)
            .fetch_optional(connection)
            .await?;
    row.ok_or(Error::NoMachine)
}

/// The run that the same request has given before, else the one that occupies the machine.
async fn known(tx: &mut Writing, claim: &Claim<'_>) -> Result<Option<Run>> {
    let same: Option<RunRow> = sqlx::query_as(runs_where!("machine = $1 AND request_id = $2"))
        .bind(claim.machine)
        .bind(claim.request_id)
        .fetch_optional(&mut **tx)
        .await?;
    match same {
        Some(row) => Ok(Some(row.try_into()?)),
        None => live(tx, claim.machine).await,
    }
}

async fn live(connection: &mut sqlx::SqliteConnection, machine: &str) -> Result<Option<Run>> {
    let row: Option<RunRow> = sqlx::query_as(runs_where!(
        "machine = $1 AND state IN ('offered', 'received', 'running', 'suspect')"
    ))
    .bind(machine)
    .fetch_optional(connection)
    .await?;
    row.map(Run::try_from).transpose()
}

/// The first entry whose program may go to a machine. One that is damaged is quarantined, and the next is looked at.
async fn next_sound(tx: &mut Writing, claim: &Claim<'_>, machine: &MachineRow) -> Result<Option<Entry>> {
    loop {
        let next: Option<(String,)> = next_entry(claim.machine, machine).fetch_optional(&mut **tx).await?;
        let Some((id,)) = next else { return Ok(None) };
        let entry = entries::find(tx, &id.parse()?).await?;
        match soundness(tx, &entry.program, claim.now).await? {
            Soundness::Sound => return Ok(Some(entry)),
            Soundness::Damaged => {
                tracing::error!(program = %entry.program, "quarantined: its stored bytes do not fit their hash");
            }
            Soundness::NotApproved(state) => {
                return Err(Error::Unusable(format!("{} was approved and is {state}", entry.program)));
            }
        }
    }
}

async fn give(tx: &mut Writing, claim: &Claim<'_>, entry: &Entry) -> Result<Run> {
    let unit = free_unit(tx, &entry.id).await?;
    if unit > entry.quantity {
        return Err(Error::Unusable(format!("{} waits, but has no free unit", entry.id)));
    }
    let (sha256, bytes): (String, i64) = sqlx::query_as("SELECT sha256, bytes FROM programs WHERE id = $1")
        .bind(entry.program.as_str())
        .fetch_one(&mut **tx)
        .await?;
    let new = NewRun {
        id: claim.id.clone(),
        entry: entry.id.clone(),
        unit,
        program: entry.program.clone(),
        purpose: entry.purpose,
        sha256,
        bytes,
        machine: claim.machine.to_owned(),
        request_id: claim.request_id.to_owned(),
    };
    let run = Run::offer(new, claim.now, claim.lease_until);
    insert(tx, &run, claim.actor, claim.now).await?;
    entries::settle(tx, &entry.id, claim.actor, claim.now).await?;
    Ok(run)
}

/// The lowest number from 1 that no run holds.
async fn free_unit(connection: &mut sqlx::SqliteConnection, entry: &EntryId) -> Result<i64> {
    let held: Vec<(i64,)> =
        sqlx::query_as("SELECT unit FROM runs WHERE entry_id = $1 AND returned = 0 ORDER BY unit")
            .bind(entry.as_str())
            .fetch_all(connection)
            .await?;
    let gap = (1_i64..).zip(&held).find(|(expected, (unit,))| expected != unit);
    Ok(gap.map_or_else(|| i64::try_from(held.len()).unwrap_or(i64::MAX).saturating_add(1), |(free, _)| free))
}
