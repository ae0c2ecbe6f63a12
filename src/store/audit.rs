//! The audit trail: one row for each change of state, in the transaction that makes the change.
//!
//! The rows form a chain. The hash of a row is the SHA-256 over one line of JSON,
//! `["seq","at","actor","action","subject","detail","previous"]` with these values as texts, where `previous` is
//! the hash of the row before (64 zeros for the first). A row that was changed or taken away breaks the chain.

use serde_json::Value;
use sqlx::Row;

use super::{Result, Store, Writing};
use crate::job::moment::Moment;
use crate::planning::outcome::sha256_hex;

/// What stands before the first row.
const NO_HASH: &str = "0000000000000000000000000000000000000000000000000000000000000000";

/// What somebody did to something.
#[derive(Debug, Clone)]
pub struct Deed<'a> {
    /// When.
    pub at: Moment,
    /// Who: a key's name, a worker, or the service itself.
    pub actor: &'a str,
    /// What: `job.queued`, `program.approved`.
    pub action: &'a str,
    /// To what: an id.
    pub subject: &'a str,
    /// What else should be known.
    pub detail: Value,
}

/// A row of the trail.
#[derive(Debug, Clone, PartialEq, Eq, sqlx::FromRow)]
pub struct AuditRow {
    /// Its place, from 1.
    pub seq: i64,
    /// When, in milliseconds since 1970.
    pub at: i64,
    /// Who.
    pub actor: String,
    /// What.
    pub action: String,
    /// To what.
    pub subject: String,
    /// What else should be known, in JSON.
    pub detail: String,
    /// The hash of the row before.
    pub previous: String,
    /// Its own hash.
    pub hash: String,
}

impl AuditRow {
    /// The hash that this row must carry.
    #[must_use]
    pub fn expected_hash(&self) -> String {
        let Self { seq, at, actor, action, subject, detail, previous, .. } = self;
        let line =
            serde_json::json!([seq.to_string(), at.to_string(), actor, action, subject, detail, previous]);
        sha256_hex(line.to_string().as_bytes())
    }
}

/// Writes a row.
pub(super) async fn record(tx: &mut Writing, deed: &Deed<'_>) -> Result<()> {
    let last = sqlx::query("SELECT seq, hash FROM audit ORDER BY seq DESC LIMIT 1")
        .fetch_optional(&mut **tx)
        .await?;
    let (last_seq, previous) =
        last.map_or((0, NO_HASH.to_owned()), |row| (row.get::<i64, _>("seq"), row.get::<String, _>("hash")));
    let mut row = AuditRow {
        seq: last_seq + 1,
        at: deed.at.unix_ms(),
        actor: deed.actor.to_owned(),
        action: deed.action.to_owned(),
        subject: deed.subject.to_owned(),
        detail: deed.detail.to_string(),
        previous,
        hash: String::new(),
    };
    row.hash = row.expected_hash();
    insert(tx, &row).await
}

async fn insert(tx: &mut Writing, row: &AuditRow) -> Result<()> {
    sqlx::query(
        "INSERT INTO audit (seq, at, actor, action, subject, detail, previous, hash)
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8)",
    )
    .bind(row.seq)
    .bind(row.at)
    .bind(&row.actor)
    .bind(&row.action)
    .bind(&row.subject)
    .bind(&row.detail)
    .bind(&row.previous)
    .bind(&row.hash)
    .execute(&mut **tx)
    .await?;
    Ok(())
}

impl Store {
    /// The rows after `seq`, at most `limit`, in order.
    ///
    /// # Errors
    /// `Database`.
    pub async fn audit(&self, after: i64, limit: i64) -> Result<Vec<AuditRow>> {
        Ok(sqlx::query_as(
            "SELECT seq, at, actor, action, subject, detail, previous, hash FROM audit
             WHERE seq > $1 ORDER BY seq LIMIT $2",
        )
        .bind(after)
        .bind(limit)
        .fetch_all(&self.readers)
        .await?)
    }
}
