//! Entries: programs that wait in the queues of machines and pools.

use serde_json::json;
use sqlx::sqlite::SqliteConnection;

use super::audit::{self, Deed};
use super::claims::refuse_other_profile;
use super::programs::{state_and_purpose, with_purpose};
use super::{Error, Result, Store, Writing};
use crate::job::entry::{Entry, NewEntry, Units};
use crate::job::id::{EntryId, ProgramId};
use crate::job::moment::Moment;
use crate::job::purpose::Purpose;

/// What is put into a queue.
#[derive(Debug, Clone)]
pub struct Enqueue<'a> {
    /// Its id.
    pub id: EntryId,
    /// The queue: the name of a machine or of a pool.
    pub queue: &'a str,
    /// The program.
    pub program: ProgramId,
    /// Its place; the last if left out.
    pub position: Option<i64>,
    /// How many units are wanted.
    pub quantity: i64,
    /// Who asks for it.
    pub actor: &'a str,
    /// When.
    pub now: Moment,
}

/// Which entries of a queue are asked for.
#[derive(Debug, Clone, Default)]
pub struct EntryFilter {
    /// The queue.
    pub queue: String,
    /// In this state.
    pub state: Option<String>,
    /// Behind this one.
    pub after: Option<EntryId>,
    /// At most so many.
    pub limit: i64,
}

#[derive(sqlx::FromRow)]
struct EntryRow {
    id: String,
    queue: String,
    program_id: String,
    purpose: String,
    from_ply: Option<i64>,
    from_course: Option<i64>,
    position: i64,
    quantity: i64,
    state: String,
    created_at: i64,
    version: i64,
    given: i64,
    done: i64,
    scrapped: i64,
    highest: i64,
}

impl TryFrom<EntryRow> for Entry {
    type Error = Error;

    fn try_from(row: EntryRow) -> Result<Self> {
        let EntryRow { given, done, scrapped, highest, .. } = row;
        Ok(Self {
            id: row.id.parse()?,
            queue: row.queue,
            program: row.program_id.parse()?,
            purpose: Purpose::stored(&row.purpose, [row.from_ply, row.from_course]),
            position: row.position,
            quantity: row.quantity,
            units: Units { given, done, scrapped, highest },
            created_at: Moment::from_unix_ms(row.created_at),
            version: row.version,
            state: serde_json::from_value(row.state.into())?,
        })
    }
}

/// A statement over entries with what became of their units: over all runs whose unit was not returned.
macro_rules! entries_where {
    ($condition:literal) => {
        concat!(
            "SELECT e.id, e.queue, e.program_id, p.purpose, p.from_ply, p.from_course, e.position, e.quantity, e.state,
                    e.created_at, e.version,
                    COUNT(r.id) AS given,
                    COALESCE(SUM(CASE WHEN r.state = 'done' THEN 1 ELSE 0 END), 0) AS done,
                    COALESCE(SUM(r.scrapped), 0) AS scrapped,
                    COALESCE(MAX(r.unit), 0) AS highest
             FROM entries e JOIN programs p ON p.id = e.program_id LEFT JOIN runs r ON r.entry_id = e.id AND r.returned = 0
             WHERE ",
            $condition
        )
    };
}

impl Store {
    /// Puts a program into a queue.
    ///
    /// # Errors
    /// `NoMachine` if neither a machine nor a pool has the queue's name; `NoProgram`; `NotApproved` for a program
    /// that will not be approved any more; `Entry` for the quantity; `Database`.
    pub async fn enqueue(&self, new: Enqueue<'_>) -> Result<Entry> {
        let mut tx = self.write().await?;
        refuse_unknown_queue(&mut tx, new.queue).await?;
        let purpose = refuse_dead_program(&mut tx, &new.program).await?;
        refuse_other_profile(&mut tx, new.queue, &new.program).await?;
        let position = match new.position {
            Some(position) => position,
            None => behind_all(&mut tx, new.queue).await?,
        };
        let Enqueue { id, program, quantity, actor, now, .. } = new;
        let queue = new.queue.to_owned();
        let entry = Entry::queue(NewEntry { id, queue, program, purpose, position, quantity }, now)?;
        insert(&mut tx, &entry).await?;
        record(&mut tx, &entry, "entry.queued", actor, now).await?;
        tx.commit().await?;
        Ok(entry)
    }

    /// An entry.
    ///
    /// # Errors
    /// `NotFound`, `Database`.
    pub async fn entry(&self, id: &EntryId) -> Result<Entry> {
        let mut reader = self.readers.acquire().await?;
        find(&mut reader, id).await
    }

    /// The entries of a queue, in its order.
    ///
    /// # Errors
    /// `Database`.
    pub async fn entries(&self, filter: &EntryFilter) -> Result<Vec<Entry>> {
        let rows: Vec<EntryRow> = sqlx::query_as(entries_where!(
            "e.queue = $1 AND ($2 IS NULL OR e.state = $2)
               AND ($3 IS NULL OR (e.position, e.id) > (SELECT position, id FROM entries WHERE id = $3))
             GROUP BY e.id, p.id ORDER BY e.position, e.id LIMIT $4"
        ))
        .bind(&filter.queue)
        .bind(&filter.state)
        .bind(filter.after.as_ref().map(EntryId::as_str))
        .bind(filter.limit)
        .fetch_all(&self.readers)
        .await?;
        rows.into_iter().map(Entry::try_from).collect()
    }

    /// Changes the place or the quantity of an entry.
    ///
    /// # Errors
    /// `NotFound`, `Entry`, `Database`.
    pub async fn amend_entry(
        &self,
        id: &EntryId,
        position: Option<i64>,
        quantity: Option<i64>,
        actor: &str,
        now: Moment,
    ) -> Result<Entry> {
        let mut tx = self.write().await?;
        let entry = find(&mut tx, id).await?.amend(position, quantity)?;
        save(&mut tx, &entry).await?;
        record(&mut tx, &entry, "entry.amended", actor, now).await?;
        tx.commit().await?;
        Ok(entry)
    }

    /// Cancels an entry: it gives nothing out any more. What it had given out goes on.
    ///
    /// # Errors
    /// `NotFound`, `Entry` if it is finished, `Database`.
    pub async fn cancel_entry(&self, id: &EntryId, actor: &str, now: Moment) -> Result<Entry> {
        let mut tx = self.write().await?;
        let before = find(&mut tx, id).await?;
        let entry = before.clone().cancel()?;
        if entry.version != before.version {
            save(&mut tx, &entry).await?;
            record(&mut tx, &entry, "entry.cancelled", actor, now).await?;
        }
        tx.commit().await?;
        Ok(entry)
    }
}

/// An entry, within a transaction or outside.
pub(super) async fn find(connection: &mut SqliteConnection, id: &EntryId) -> Result<Entry> {
    let row: Option<EntryRow> = sqlx::query_as(entries_where!("e.id = $1 GROUP BY e.id, p.id"))
        .bind(id.as_str())
        .fetch_optional(connection)
        .await?;
    row.ok_or(Error::NotFound)?.try_into()
}

/// Takes note of what became of the units of an entry, after a run of it has changed.
pub(super) async fn settle(tx: &mut Writing, id: &EntryId, actor: &str, now: Moment) -> Result<()> {
    let before = find(tx, id).await?;
    let (was, units) = (before.state, before.units);
    let entry = before.settle(units);
    if entry.state == was {
        return Ok(());
    }
    save(tx, &entry).await?;
    record(tx, &entry, &format!("entry.{}", entry.state.word()), actor, now).await
}

async fn insert(tx: &mut Writing, entry: &Entry) -> Result<()> {
    sqlx::query(
        "INSERT INTO entries (id, queue, program_id, position, quantity, state, created_at, version)
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8)",
    )
    .bind(entry.id.as_str())
    .bind(&entry.queue)
    .bind(entry.program.as_str())
    .bind(entry.position)
    .bind(entry.quantity)
    .bind(entry.state.word())
    .bind(entry.created_at.unix_ms())
    .bind(entry.version)
    .execute(&mut **tx)
    .await?;
    Ok(())
}

async fn save(tx: &mut Writing, entry: &Entry) -> Result<()> {
    let changed = sqlx::query(
        "UPDATE entries SET position = $2, quantity = $3, state = $4, version = $5
         WHERE id = $1 AND version < $5",
    )
    .bind(entry.id.as_str())
    .bind(entry.position)
    .bind(entry.quantity)
    .bind(entry.state.word())
    .bind(entry.version)
    .execute(&mut **tx)
    .await?;
    if changed.rows_affected() == 1 { Ok(()) } else { Err(Error::NotFound) }
}

async fn record(tx: &mut Writing, entry: &Entry, action: &str, actor: &str, now: Moment) -> Result<()> {
    let detail = json!({
        "queue": entry.queue, "program": entry.program, "position": entry.position,
        "quantity": entry.quantity, "state": entry.state.word()
    });
    let detail = with_purpose(detail, entry.purpose);
    audit::record(tx, &Deed { at: now, actor, action, subject: entry.id.as_str(), detail }).await
}

/// An entry in a queue that nobody asks would wait for ever.
async fn refuse_unknown_queue(tx: &mut Writing, queue: &str) -> Result<()> {
    let known = sqlx::query("SELECT 1 FROM machines WHERE name = $1 OR pool = $1 LIMIT 1")
        .bind(queue)
        .fetch_optional(&mut **tx)
        .await?;
    if known.is_some() { Ok(()) } else { Err(Error::NoMachine) }
}

/// A draft may wait for its approval in the queue; what was taken back or is damaged will not be approved.
/// Gives back what it is for.
async fn refuse_dead_program(tx: &mut Writing, program: &ProgramId) -> Result<Purpose> {
    let (state, purpose) = state_and_purpose(tx, program).await?.ok_or(Error::NoProgram)?;
    if ["draft", "approved"].contains(&state.as_str()) {
        Ok(purpose)
    } else {
        Err(Error::NotApproved { state })
    }
}

async fn behind_all(tx: &mut Writing, queue: &str) -> Result<i64> {
    let (last,): (i64,) = sqlx::query_as("SELECT COALESCE(MAX(position), 0) FROM entries WHERE queue = $1")
        .bind(queue)
        .fetch_one(&mut **tx)
        .await?;
    Ok(last.saturating_add(1))
}
