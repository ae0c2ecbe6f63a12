//! Approval and revocation of programs.

use super::audit::{self, Deed};
use super::programs::{state_and_purpose, with_purpose};
use super::{Error, Result, Store, Writing};
use crate::job::id::ProgramId;
use crate::job::moment::Moment;
use crate::job::program::Standing;
use crate::job::purpose::Purpose;

impl Store {
    /// Approves a program, by naming the hash of the bytes that were looked at. Approving it again with the same
    /// hash changes nothing.
    ///
    /// # Errors
    /// `NotFound`, `OtherHash`, `ForNoMachine` if it was planned for none, `Standing` if its state does not admit it, `Damaged` if its bytes do not fit
    /// their hash any more (it is quarantined then), `Database`.
    pub async fn approve(&self, id: &ProgramId, sha256: &str, actor: &str, now: Moment) -> Result<()> {
        let program = self.program(id).await?;
        if program.sha256 != sha256 {
            return Err(Error::OtherHash);
        }
        self.program_content(&program, now).await?;
        let mut tx = self.write().await?;
        let (before, purpose) = standing(&mut tx, id).await?;
        refuse_without_machine(&mut tx, id).await?;
        let after = before.approve()?;
        if after != before {
            set(&mut tx, id, after).await?;
            sqlx::query("INSERT INTO approvals (program_id, sha256, actor, at) VALUES ($1, $2, $3, $4)")
                .bind(id.as_str())
                .bind(sha256)
                .bind(actor)
                .bind(now.unix_ms())
                .execute(&mut *tx)
                .await?;
            let detail = with_purpose(serde_json::json!({"sha256": sha256}), purpose);
            let deed = Deed { at: now, actor, action: "program.approved", subject: id.as_str(), detail };
            audit::record(&mut tx, &deed).await?;
        }
        Ok(tx.commit().await?)
    }

    /// Takes a program out of use for good.
    ///
    /// # Errors
    /// `NotFound`, `Standing` if its state does not admit it, `Database`.
    pub async fn revoke(&self, id: &ProgramId, reason: &str, actor: &str, now: Moment) -> Result<()> {
        let mut tx = self.write().await?;
        let (before, purpose) = standing(&mut tx, id).await?;
        let after = before.revoke()?;
        if after != before {
            set(&mut tx, id, after).await?;
            sqlx::query("INSERT INTO revocations (program_id, reason, actor, at) VALUES ($1, $2, $3, $4)")
                .bind(id.as_str())
                .bind(reason)
                .bind(actor)
                .bind(now.unix_ms())
                .execute(&mut *tx)
                .await?;
            let detail = with_purpose(serde_json::json!({"reason": reason}), purpose);
            let deed = Deed { at: now, actor, action: "program.revoked", subject: id.as_str(), detail };
            audit::record(&mut tx, &deed).await?;
        }
        Ok(tx.commit().await?)
    }
}

async fn standing(tx: &mut Writing, id: &ProgramId) -> Result<(Standing, Purpose)> {
    let (word, purpose) = state_and_purpose(tx, id).await?.ok_or(Error::NotFound)?;
    Ok((Standing::of(&word).ok_or(Error::NotFound)?, purpose))
}

/// A program that was planned for no machine has not been held against its limits either.
async fn refuse_without_machine(tx: &mut Writing, id: &ProgramId) -> Result<()> {
    let (profile,): (Option<String>,) = sqlx::query_as("SELECT profile_sha256 FROM programs WHERE id = $1")
        .bind(id.as_str())
        .fetch_one(&mut **tx)
        .await?;
    if profile.is_some() { Ok(()) } else { Err(Error::ForNoMachine) }
}

async fn set(tx: &mut Writing, id: &ProgramId, standing: Standing) -> Result<()> {
    sqlx::query("UPDATE programs SET state = $2, version = version + 1 WHERE id = $1")
        .bind(id.as_str())
        .bind(standing.word())
        .execute(&mut **tx)
        .await?;
    Ok(())
}
