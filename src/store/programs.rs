//! Programs: immutable bytes with the hash they were stored with. Bytes that do not fit their hash any more are
//! never given out; the program is quarantined instead.

use serde_json::{Value, json};

use super::audit::{self, Deed};
use super::{Error, Result, Store, Writing};
use crate::job::id::{JobId, ProgramId};
use crate::job::life::Job;
use crate::job::moment::Moment;
use crate::job::program::Standing;
use crate::job::purpose::Purpose;
use crate::planning::outcome::sha256_hex;

/// A program to be kept.
#[derive(Debug, Clone)]
pub struct NewProgram {
    /// Its id.
    pub id: ProgramId,
    /// Its files.
    pub files: Vec<NewFile>,
    /// The archive of all files, where there are several.
    pub archive: Option<NewFile>,
}

/// A file to be kept.
#[derive(Debug, Clone)]
pub struct NewFile {
    /// Its name.
    pub name: String,
    /// `linuxcnc`, `sinumerik`, `krl`, or `zip` for the archive.
    pub dialect: String,
    /// Its bytes.
    pub body: Vec<u8>,
}

/// A program, without its bytes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Program {
    /// Its id.
    pub id: ProgramId,
    /// The job that gave it.
    pub job: JobId,
    /// The job's kind.
    pub kind: String,
    /// What it is for.
    pub purpose: Purpose,
    /// `draft`, `approved`, `superseded`, `revoked` or `quarantined`.
    pub state: String,
    /// The name of its content.
    pub content_name: String,
    /// The media type of its content.
    pub media_type: String,
    /// The SHA-256 of its content.
    pub sha256: String,
    /// The length of its content.
    pub bytes: i64,
    /// When it was made.
    pub created_at: Moment,
    /// Rises with every change of its state.
    pub version: i64,
    /// Its files.
    pub files: Vec<FileEntry>,
}

impl Program {
    /// Whether it may be approved or given out, now or later.
    #[must_use]
    pub fn is_in_use(&self) -> bool {
        matches!(Standing::of(&self.state), Some(Standing::Draft | Standing::Approved))
    }

    /// Whether a dry run of it can be planned: of what cuts tape, and is none itself.
    #[must_use]
    pub fn has_dry_run(&self) -> bool {
        self.kind == WITH_DRY_RUN && !matches!(self.purpose, Purpose::DryRun { .. })
    }
}

/// The kind of job whose programs have dry runs.
const WITH_DRY_RUN: &str = "tape-cut";

/// A file of a program, without its bytes.
#[derive(Debug, Clone, PartialEq, Eq, sqlx::FromRow)]
pub struct FileEntry {
    /// Its name.
    pub name: String,
    /// `linuxcnc`, `sinumerik` or `krl`.
    pub dialect: String,
    /// The SHA-256 of its bytes.
    pub sha256: String,
    /// Its length.
    pub bytes: i64,
}

/// Which programs are asked for.
#[derive(Debug, Clone, Default)]
pub struct ProgramFilter {
    /// In this state.
    pub state: Option<String>,
    /// Given by this job.
    pub job: Option<JobId>,
    /// With this content.
    pub sha256: Option<String>,
    /// Older than this one.
    pub before: Option<ProgramId>,
    /// At most so many.
    pub limit: i64,
}

#[derive(sqlx::FromRow)]
struct ProgramRow {
    id: String,
    job_id: String,
    kind: String,
    purpose: String,
    from_ply: Option<i64>,
    from_course: Option<i64>,
    state: String,
    content_name: String,
    media_type: String,
    sha256: String,
    bytes: i64,
    created_at: i64,
    version: i64,
}

impl ProgramRow {
    fn with_files(self, files: Vec<FileEntry>) -> Result<Program> {
        Ok(Program {
            id: self.id.parse()?,
            job: self.job_id.parse()?,
            kind: self.kind,
            purpose: Purpose::stored(&self.purpose, [self.from_ply, self.from_course]),
            state: self.state,
            content_name: self.content_name,
            media_type: self.media_type,
            sha256: self.sha256,
            bytes: self.bytes,
            created_at: Moment::from_unix_ms(self.created_at),
            version: self.version,
            files,
        })
    }
}

impl Store {
    /// A program.
    ///
    /// # Errors
    /// `NotFound`, `Database`.
    pub async fn program(&self, id: &ProgramId) -> Result<Program> {
        let row: Option<ProgramRow> = sqlx::query_as(
            "SELECT id, job_id, kind, purpose, from_ply, from_course, state, content_name, media_type, sha256, bytes,
                    created_at, version
             FROM programs WHERE id = $1",
        )
        .bind(id.as_str())
        .fetch_optional(&self.readers)
        .await?;
        self.completed(row.ok_or(Error::NotFound)?).await
    }

    /// Programs, the newest first.
    ///
    /// # Errors
    /// `Database`.
    pub async fn programs(&self, filter: &ProgramFilter) -> Result<Vec<Program>> {
        let rows: Vec<ProgramRow> = sqlx::query_as(
            "SELECT id, job_id, kind, purpose, from_ply, from_course, state, content_name, media_type, sha256, bytes,
                    created_at, version
             FROM programs
             WHERE ($1 IS NULL OR state = $1) AND ($2 IS NULL OR job_id = $2) AND ($3 IS NULL OR sha256 = $3)
               AND ($4 IS NULL OR id < $4)
             ORDER BY id DESC LIMIT $5",
        )
        .bind(&filter.state)
        .bind(filter.job.as_ref().map(JobId::as_str))
        .bind(&filter.sha256)
        .bind(filter.before.as_ref().map(ProgramId::as_str))
        .bind(filter.limit)
        .fetch_all(&self.readers)
        .await?;
        let mut programs = Vec::with_capacity(rows.len());
        for row in rows {
            programs.push(self.completed(row).await?);
        }
        Ok(programs)
    }

    /// The content of a program, verified. If its bytes do not fit their hash any more, the program is
    /// quarantined and nothing is given out.
    ///
    /// # Errors
    /// `NotFound`, `Damaged`, `Database`.
    pub async fn program_content(&self, program: &Program, now: Moment) -> Result<Vec<u8>> {
        self.verified(&program.id, &program.content_name, &program.sha256, now).await
    }

    /// A file of a program, verified like its content.
    ///
    /// # Errors
    /// `NotFound`, `Damaged`, `Database`.
    pub async fn program_file(&self, program: &Program, name: &str, now: Moment) -> Result<Vec<u8>> {
        let file = program.files.iter().find(|file| file.name == name).ok_or(Error::NotFound)?;
        self.verified(&program.id, &file.name, &file.sha256, now).await
    }

    async fn completed(&self, row: ProgramRow) -> Result<Program> {
        let files = sqlx::query_as(
            "SELECT name, dialect, sha256, bytes FROM program_files
             WHERE program_id = $1 AND position > 0 ORDER BY position",
        )
        .bind(&row.id)
        .fetch_all(&self.readers)
        .await?;
        row.with_files(files)
    }

    async fn verified(&self, id: &ProgramId, name: &str, sha256: &str, now: Moment) -> Result<Vec<u8>> {
        let row: Option<(Vec<u8>,)> =
            sqlx::query_as("SELECT body FROM program_files WHERE program_id = $1 AND name = $2")
                .bind(id.as_str())
                .bind(name)
                .fetch_optional(&self.readers)
                .await?;
        let (body,) = row.ok_or(Error::NotFound)?;
        let found = sha256_hex(&body);
        if found == sha256 {
            return Ok(body);
        }
        self.quarantine(id, name, &found, now).await?;
        Err(Error::Damaged { subject: format!("{name} of {id}") })
    }

    async fn quarantine(&self, id: &ProgramId, name: &str, found: &str, now: Moment) -> Result<()> {
        let mut tx = self.write().await?;
        quarantine(&mut tx, id, name, found, now).await?;
        Ok(tx.commit().await?)
    }
}

/// Whether a machine may have a program.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Soundness {
    /// It is approved, and its bytes are those that were approved.
    Sound,
    /// It is not approved, but in this state.
    NotApproved(String),
    /// Its bytes do not fit their hash any more. It is quarantined now.
    Damaged,
}

/// Looks whether a machine may have a program, down to its bytes.
pub(super) async fn soundness(tx: &mut Writing, id: &ProgramId, now: Moment) -> Result<Soundness> {
    let row: Option<(String, String, String, Option<String>)> = sqlx::query_as(
        "SELECT p.state, p.content_name, p.sha256, a.sha256 FROM programs p
         LEFT JOIN approvals a ON a.program_id = p.id WHERE p.id = $1",
    )
    .bind(id.as_str())
    .fetch_optional(&mut **tx)
    .await?;
    let (state, name, sha256, approved) = row.ok_or(Error::NoProgram)?;
    if state != "approved" {
        return Ok(Soundness::NotApproved(state));
    }
    if approved.as_deref() != Some(&sha256) {
        return Ok(Soundness::NotApproved("approved with other bytes".to_owned()));
    }
    let (body,): (Vec<u8>,) =
        sqlx::query_as("SELECT body FROM program_files WHERE program_id = $1 AND name = $2")
            .bind(id.as_str())
            .bind(&name)
            .fetch_one(&mut **tx)
            .await?;
    let found = sha256_hex(&body);
    if found == sha256 {
        return Ok(Soundness::Sound);
    }
    quarantine(tx, id, &name, &found, now).await?;
    Ok(Soundness::Damaged)
}

async fn quarantine(tx: &mut Writing, id: &ProgramId, name: &str, found: &str, now: Moment) -> Result<()> {
    let changed = sqlx::query(
        "UPDATE programs SET state = 'quarantined', version = version + 1
         WHERE id = $1 AND state <> 'quarantined'",
    )
    .bind(id.as_str())
    .execute(&mut **tx)
    .await?;
    if changed.rows_affected() == 0 {
        return Ok(());
    }
    let detail = json!({"file": name, "found_sha256": found});
    let deed =
        Deed { at: now, actor: "service", action: "program.quarantined", subject: id.as_str(), detail };
    audit::record(tx, &deed).await
}

/// The word for where a program stands, and what it is for; none if there is no such program.
pub(super) async fn state_and_purpose(tx: &mut Writing, id: &ProgramId) -> Result<Option<(String, Purpose)>> {
    let row: Option<(String, String, Option<i64>, Option<i64>)> =
        sqlx::query_as("SELECT state, purpose, from_ply, from_course FROM programs WHERE id = $1")
            .bind(id.as_str())
            .fetch_optional(&mut **tx)
            .await?;
    Ok(row.map(|(state, purpose, ply, course)| (state, Purpose::stored(&purpose, [ply, course]))))
}

/// What an audit row says about a program, with what the program is for.
pub(super) fn with_purpose(mut detail: Value, purpose: Purpose) -> Value {
    detail["purpose"] = json!(purpose);
    for (field, from) in [("from_course", purpose.from_course()), ("from_ply", purpose.from_ply())] {
        if let Some(number) = from {
            detail[field] = json!(number);
        }
    }
    detail
}

/// What a report says of the program that came with it.
#[derive(Debug, Clone)]
pub(super) struct Planned {
    /// The profile that it was planned for.
    pub profile_sha256: Option<String>,
    /// What it is for.
    pub purpose: Purpose,
}

/// Writes a program and its files.
pub(super) async fn insert_program(
    tx: &mut Writing,
    job: &Job,
    program: &NewProgram,
    planned: Planned,
    now: Moment,
) -> Result<()> {
    let first = program.files.first().ok_or(Error::NotFound)?;
    let content = program.archive.as_ref().unwrap_or(first);
    let (position, media_type) = if program.archive.is_some() {
        (0_i64, "application/zip")
    } else {
        (1, "text/plain; charset=us-ascii")
    };
    sqlx::query(
        "INSERT INTO programs
         (id, job_id, kind, state, content_position, content_name, media_type, sha256, bytes, created_at, version,
          profile_sha256, purpose, from_ply, from_course)
         VALUES ($1, $2, $3, 'draft', $4, $5, $6, $7, $8, $9, 1, $10, $11, $12, $13)",
    )
    .bind(program.id.as_str())
    .bind(job.id.as_str())
    .bind(&job.kind)
    .bind(position)
    .bind(&content.name)
    .bind(media_type)
    .bind(sha256_hex(&content.body))
    .bind(i64::try_from(content.body.len()).unwrap_or(i64::MAX))
    .bind(now.unix_ms())
    .bind(planned.profile_sha256)
    .bind(planned.purpose.word())
    .bind(planned.purpose.from_ply())
    .bind(planned.purpose.from_course())
    .execute(&mut **tx)
    .await?;
    let archive = program.archive.iter().map(|file| (0, file));
    for (position, file) in archive.chain((1_i64..).zip(&program.files)) {
        insert_file(tx, &program.id, position, file).await?;
    }
    Ok(())
}

async fn insert_file(tx: &mut Writing, id: &ProgramId, position: i64, file: &NewFile) -> Result<()> {
    sqlx::query(
        "INSERT INTO program_files (program_id, position, name, dialect, sha256, bytes, body)
         VALUES ($1, $2, $3, $4, $5, $6, $7)",
    )
    .bind(id.as_str())
    .bind(position)
    .bind(&file.name)
    .bind(&file.dialect)
    .bind(sha256_hex(&file.body))
    .bind(i64::try_from(file.body.len()).unwrap_or(i64::MAX))
    .bind(&file.body)
    .execute(&mut **tx)
    .await?;
    Ok(())
}
