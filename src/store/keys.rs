//! Keys: who may call the service. Of a secret only its hash is kept.

use super::audit::{self, Deed};
use super::{Error, Result, Store};
use crate::job::id::KeyId;
use crate::job::moment::Moment;
use crate::job::role::Role;

/// A key, without its secret.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Key {
    /// Its id.
    pub id: KeyId,
    /// The name that audit rows carry.
    pub name: String,
    /// What it may be used for.
    pub role: Role,
    /// The machine whose key it is.
    pub machine: Option<String>,
    /// The hash of its secret, in hex.
    pub hash: String,
    /// When it was made.
    pub created_at: Moment,
    /// Since when it is not taken any more.
    pub revoked_at: Option<Moment>,
}

#[derive(sqlx::FromRow)]
struct KeyRow {
    id: String,
    name: String,
    role: String,
    machine: Option<String>,
    hash: String,
    created_at: i64,
    revoked_at: Option<i64>,
}

impl TryFrom<KeyRow> for Key {
    type Error = Error;

    fn try_from(row: KeyRow) -> Result<Self> {
        Ok(Self {
            id: row.id.parse()?,
            name: row.name,
            role: Role::of(&row.role).ok_or(Error::NotFound)?,
            machine: row.machine,
            hash: row.hash,
            created_at: Moment::from_unix_ms(row.created_at),
            revoked_at: row.revoked_at.map(Moment::from_unix_ms),
        })
    }
}

impl Store {
    /// Whether there are keys at all, revoked ones among them: from the first key on, every request needs one.
    ///
    /// # Errors
    /// `Database`.
    pub async fn has_keys(&self) -> Result<bool> {
        let (found,): (bool,) =
            sqlx::query_as("SELECT EXISTS (SELECT 1 FROM keys)").fetch_one(&self.readers).await?;
        Ok(found)
    }

    /// A key.
    ///
    /// # Errors
    /// `NotFound`, `Database`.
    pub async fn key(&self, id: &KeyId) -> Result<Key> {
        let row: Option<KeyRow> = sqlx::query_as(
            "SELECT id, name, role, machine, hash, created_at, revoked_at FROM keys WHERE id = $1",
        )
        .bind(id.as_str())
        .fetch_optional(&self.readers)
        .await?;
        row.ok_or(Error::NotFound)?.try_into()
    }

    /// All keys, the oldest first.
    ///
    /// # Errors
    /// `Database`.
    pub async fn keys(&self) -> Result<Vec<Key>> {
        let rows: Vec<KeyRow> = sqlx::query_as(
            "SELECT id, name, role, machine, hash, created_at, revoked_at FROM keys ORDER BY id",
        )
        .fetch_all(&self.readers)
        .await?;
        rows.into_iter().map(Key::try_from).collect()
    }

    /// Keeps a new key.
    ///
    /// # Errors
    /// `Exists` if there is one of that name, `Database`.
    pub async fn add_key(&self, key: &Key, actor: &str) -> Result<()> {
        let mut tx = self.write().await?;
        let added = sqlx::query(
            "INSERT INTO keys (id, name, role, machine, hash, created_at) VALUES ($1, $2, $3, $4, $5, $6)
             ON CONFLICT (name) DO NOTHING",
        )
        .bind(key.id.as_str())
        .bind(&key.name)
        .bind(key.role.word())
        .bind(&key.machine)
        .bind(&key.hash)
        .bind(key.created_at.unix_ms())
        .execute(&mut *tx)
        .await?;
        if added.rows_affected() == 0 {
            return Err(Error::Exists);
        }
        let detail = serde_json::json!({"name": key.name, "role": key.role, "machine": key.machine});
        let deed =
            Deed { at: key.created_at, actor, action: "key.created", subject: key.id.as_str(), detail };
        audit::record(&mut tx, &deed).await?;
        Ok(tx.commit().await?)
    }

    /// Takes a key back for good, by its name.
    ///
    /// # Errors
    /// `NotFound` if there is none of that name that still holds, `Database`.
    pub async fn revoke_key(&self, name: &str, actor: &str, now: Moment) -> Result<()> {
        let mut tx = self.write().await?;
        let row: Option<(String,)> = sqlx::query_as(
            "UPDATE keys SET revoked_at = $2 WHERE name = $1 AND revoked_at IS NULL RETURNING id",
        )
        .bind(name)
        .bind(now.unix_ms())
        .fetch_optional(&mut *tx)
        .await?;
        let (id,) = row.ok_or(Error::NotFound)?;
        let detail = serde_json::json!({"name": name});
        let deed = Deed { at: now, actor, action: "key.revoked", subject: &id, detail };
        audit::record(&mut tx, &deed).await?;
        Ok(tx.commit().await?)
    }
}
