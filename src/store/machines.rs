//! Machines: their profiles, and whether they are on hold.

use super::audit::{self, Deed};
use super::{Error, Result, Store, Writing};
use crate::job::moment::Moment;
use crate::planning::catalogue::Profile;

/// A registered machine.
#[derive(Debug, Clone)]
pub struct Machine {
    /// Its name; jobs and queues name it so.
    pub name: String,
    /// The pool whose queue it shares with others.
    pub pool: Option<String>,
    /// Its profile.
    pub profile: Profile,
    /// Why it is given nothing, if so.
    pub hold: Option<Hold>,
    /// When it was registered.
    pub created_at: Moment,
    /// Rises with every change.
    pub version: i64,
}

/// What is changed of a machine; what is left out stays.
#[derive(Debug, Clone, Default, serde::Serialize)]
pub struct MachineChange {
    /// Its new profile, which has the machine's name.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub profile: Option<Profile>,
    /// Its new pool, or that it has none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pool: Option<Option<String>>,
}

/// Why a machine is given nothing.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Hold {
    /// Who holds it.
    pub by: String,
    /// Why.
    pub reason: String,
    /// Since when.
    pub at: Moment,
}

#[derive(sqlx::FromRow)]
struct MachineRow {
    name: String,
    pool: Option<String>,
    profile: String,
    held_by: Option<String>,
    held_reason: Option<String>,
    held_at: Option<i64>,
    created_at: i64,
    version: i64,
}

const COLUMNS: &str = "name, pool, profile, held_by, held_reason, held_at, created_at, version";

impl TryFrom<MachineRow> for Machine {
    type Error = Error;

    fn try_from(row: MachineRow) -> Result<Self> {
        let hold = row.held_by.zip(row.held_at).map(|(by, at)| Hold {
            by,
            reason: row.held_reason.unwrap_or_default(),
            at: Moment::from_unix_ms(at),
        });
        Ok(Self {
            name: row.name,
            pool: row.pool,
            profile: serde_json::from_str(&row.profile)?,
            hold,
            created_at: Moment::from_unix_ms(row.created_at),
            version: row.version,
        })
    }
}

impl Store {
    /// All machines by name.
    ///
    /// # Errors
    /// `Database`.
    pub async fn machines(&self) -> Result<Vec<Machine>> {
        let statement = sqlx::AssertSqlSafe(format!("SELECT {COLUMNS} FROM machines ORDER BY name"));
        let rows: Vec<MachineRow> = sqlx::query_as(statement).fetch_all(&self.readers).await?;
        rows.into_iter().map(Machine::try_from).collect()
    }

    /// A machine.
    ///
    /// # Errors
    /// `NotFound`, `Database`.
    pub async fn machine(&self, name: &str) -> Result<Machine> {
        let statement = sqlx::AssertSqlSafe(format!("SELECT {COLUMNS} FROM machines WHERE name = $1"));
        let row: Option<MachineRow> =
            sqlx::query_as(statement).bind(name).fetch_optional(&self.readers).await?;
        row.ok_or(Error::NotFound)?.try_into()
    }

    /// Registers a machine under the name of its profile.
    ///
    /// # Errors
    /// `Exists`, `Database`.
    pub async fn add_machine(
        &self,
        profile: &Profile,
        pool: Option<&str>,
        actor: &str,
        now: Moment,
    ) -> Result<Machine> {
        let mut tx = self.write().await?;
        let text = serde_json::to_string(profile)?;
        let added = sqlx::query(
            "INSERT INTO machines (name, pool, profile, created_at, version, profile_sha256)
             VALUES ($1, $2, $3, $4, 1, $5)
             ON CONFLICT (name) DO NOTHING",
        )
        .bind(profile.name())
        .bind(pool)
        .bind(&text)
        .bind(now.unix_ms())
        .bind(profile.fingerprint())
        .execute(&mut *tx)
        .await?;
        if added.rows_affected() == 0 {
            return Err(Error::Exists);
        }
        let detail = serde_json::json!({"pool": pool, "profile": profile});
        note(&mut tx, actor, "machine.registered", profile.name(), detail, now).await?;
        tx.commit().await?;
        self.machine(profile.name()).await
    }

    /// Changes profile, pool or both of a machine. Jobs that were posted before keep the profile that they froze.
    ///
    /// # Errors
    /// `NotFound`, `Database`.
    pub async fn change_machine(
        &self,
        name: &str,
        change: &MachineChange,
        actor: &str,
        now: Moment,
    ) -> Result<Machine> {
        let mut tx = self.write().await?;
        let changed = sqlx::query(
            "UPDATE machines SET profile = COALESCE($2, profile), profile_sha256 = COALESCE($3, profile_sha256),
                                 pool = CASE WHEN $4 THEN $5 ELSE pool END, version = version + 1
             WHERE name = $1",
        )
        .bind(name)
        .bind(change.profile.as_ref().map(serde_json::to_string).transpose()?)
        .bind(change.profile.as_ref().map(Profile::fingerprint))
        .bind(change.pool.is_some())
        .bind(change.pool.as_ref().and_then(Option::as_ref))
        .execute(&mut *tx)
        .await?;
        if changed.rows_affected() == 0 {
            return Err(Error::NotFound);
        }
        note(&mut tx, actor, "machine.changed", name, serde_json::to_value(change)?, now).await?;
        tx.commit().await?;
        self.machine(name).await
    }

    /// Holds a machine, or takes the hold back: a machine on hold is given nothing new. What it runs goes on.
    ///
    /// # Errors
    /// `NotFound`, `Database`.
    pub async fn hold(&self, name: &str, reason: Option<&str>, actor: &str, now: Moment) -> Result<Machine> {
        let mut tx = self.write().await?;
        let by = reason.map(|_| actor);
        let changed = sqlx::query(
            "UPDATE machines SET held_by = $2, held_reason = $3, held_at = $4, version = version + 1
             WHERE name = $1",
        )
        .bind(name)
        .bind(by)
        .bind(reason)
        .bind(by.map(|_| now.unix_ms()))
        .execute(&mut *tx)
        .await?;
        if changed.rows_affected() == 0 {
            return Err(Error::NotFound);
        }
        let action = if reason.is_some() { "machine.held" } else { "machine.released" };
        note(&mut tx, actor, action, name, serde_json::json!({"reason": reason}), now).await?;
        tx.commit().await?;
        self.machine(name).await
    }
}

async fn note(
    tx: &mut Writing,
    actor: &str,
    action: &str,
    machine: &str,
    detail: serde_json::Value,
    at: Moment,
) -> Result<()> {
    audit::record(tx, &Deed { at, actor, action, subject: machine, detail }).await
}
