//! The files that came with a job: kept beside its document, byte for byte, as long as the job.

use sqlx::sqlite::SqliteConnection;

use super::{Error, Result, Store, Writing};
use crate::job::id::JobId;
use crate::planning::document::files::Files;
use crate::planning::outcome::sha256_hex;

/// A file of a job, without its bytes.
#[derive(Debug, Clone, PartialEq, Eq, sqlx::FromRow)]
pub struct JobFile {
    /// Its name.
    pub name: String,
    /// The SHA-256 of its bytes.
    pub sha256: String,
    /// Its length.
    pub bytes: i64,
}

impl Store {
    /// The files that came with a job, in the order of their names.
    ///
    /// # Errors
    /// `Database`.
    pub async fn job_files(&self, id: &JobId) -> Result<Vec<JobFile>> {
        let rows =
            sqlx::query_as("SELECT name, sha256, bytes FROM job_files WHERE job_id = $1 ORDER BY name");
        Ok(rows.bind(id.as_str()).fetch_all(&self.readers).await?)
    }

    /// A file that came with a job, byte for byte.
    ///
    /// # Errors
    /// `NotFound`, `Damaged`, `Database`.
    pub async fn job_file(&self, id: &JobId, name: &str) -> Result<Vec<u8>> {
        let row: Option<(Vec<u8>, String)> =
            sqlx::query_as("SELECT body, sha256 FROM job_files WHERE job_id = $1 AND name = $2")
                .bind(id.as_str())
                .bind(name)
                .fetch_optional(&self.readers)
                .await?;
        let (body, sha256) = row.ok_or(Error::NotFound)?;
        if sha256_hex(&body) == sha256 {
            Ok(body)
        } else {
            Err(Error::Damaged { subject: format!("the file {name} of {id}") })
        }
    }
}

/// All files of a job, if they are those that were stored: none lost, renamed or changed.
pub(super) async fn files(connection: &mut SqliteConnection, id: &JobId) -> Result<Files> {
    let damaged = || Error::Damaged { subject: format!("the files of {id}") };
    let rows: Vec<(String, Vec<u8>)> =
        sqlx::query_as("SELECT name, body FROM job_files WHERE job_id = $1 ORDER BY name")
            .bind(id.as_str())
            .fetch_all(&mut *connection)
            .await?;
    let stored: Option<(String,)> = sqlx::query_as("SELECT files_sha256 FROM job_inputs WHERE job_id = $1")
        .bind(id.as_str())
        .fetch_optional(connection)
        .await?;
    let mut files = Files::default();
    for (name, body) in rows {
        files.insert(name, body).map_err(|_| damaged())?;
    }
    if stored == Some((files_sha256(&files),)) { Ok(files) } else { Err(damaged()) }
}

/// The hash of all files together; an empty text if there are none, as for jobs from before there were files.
pub(super) fn files_sha256(files: &Files) -> String {
    if files.is_empty() { String::new() } else { sha256_hex(files.listing().as_bytes()) }
}

pub(super) async fn insert_files(tx: &mut Writing, id: &JobId, files: &Files) -> Result<()> {
    for (name, body) in files.iter() {
        sqlx::query("INSERT INTO job_files (job_id, name, sha256, bytes, body) VALUES ($1, $2, $3, $4, $5)")
            .bind(id.as_str())
            .bind(name)
            .bind(sha256_hex(body))
            .bind(i64::try_from(body.len()).unwrap_or(i64::MAX))
            .bind(body)
            .execute(&mut **tx)
            .await?;
    }
    Ok(())
}
