//! The store: everything that must survive the process, in an embedded `SQLite` database.
//!
//! There is one writer. Each change of state is one short transaction that also writes the audit row and the
//! event for followers; no transaction is open while a job is planned. `SQLite` runs in WAL with
//! `synchronous=FULL`: an acknowledged change survives a power loss.

pub mod approvals;
pub mod attempts;
pub mod audit;
pub mod changes;
pub mod claims;
pub mod counters;
pub mod entries;
pub mod events;
pub mod files;
pub mod jobs;
pub mod keys;
pub mod lock;
pub mod machines;
mod open;
pub mod programs;
pub mod results;
pub mod runs;
pub mod waiting;

use sqlx::{Sqlite, SqlitePool, Transaction};

use self::changes::Changes;
use crate::job::life::Illegal;
use crate::job::program::NotFrom;
use crate::job::{entry, run};

/// The store of one process.
#[derive(Clone)]
pub struct Store {
    writer: SqlitePool,
    readers: SqlitePool,
    changes: Changes,
}

/// Why the store did not do something.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// There is nothing of that id.
    #[error("there is nothing of that id")]
    NotFound,
    /// There is one of that name already.
    #[error("there is one of that name already")]
    Exists,
    /// The program was planned for another profile than the machine has.
    #[error("the program was planned for another profile than the machine has")]
    OtherProfile,
    /// The hash that was named is not that of the program.
    #[error("the hash that was named is not that of the program")]
    OtherHash,
    /// The program was planned for no machine, so nothing was held against a machine's limits.
    #[error("the program was planned for no machine")]
    ForNoMachine,
    /// The life cycle does not admit it.
    #[error(transparent)]
    Illegal(#[from] Illegal),
    /// The life cycle of an entry does not admit it.
    #[error(transparent)]
    Entry(#[from] entry::Illegal),
    /// The life cycle of a run does not admit it.
    #[error(transparent)]
    Run(#[from] run::Illegal),
    /// No machine has this name; nor, where a queue was named, has a pool.
    #[error("there is no machine of that name")]
    NoMachine,
    /// There is no such program.
    #[error("there is no such program")]
    NoProgram,
    /// The machine is on hold.
    #[error("the machine is on hold by {by}: {reason}")]
    Held {
        /// Who holds it.
        by: String,
        /// Why.
        reason: String,
    },
    /// The program is not approved, or not with these bytes.
    #[error("the program is {state}")]
    NotApproved {
        /// What it is instead.
        state: String,
    },
    /// The life cycle of a program does not admit it.
    #[error(transparent)]
    Standing(#[from] NotFrom),
    /// The idempotency key was used with another body.
    #[error("this idempotency key was used with another body")]
    KeyReused,
    /// The queue is as long as it may be.
    #[error("{waiting} jobs wait already")]
    QueueFull {
        /// How many.
        waiting: i64,
    },
    /// The stored bytes do not have the hash any more that they were stored with.
    #[error("the stored bytes of {subject} do not fit their hash any more")]
    Damaged {
        /// What is damaged.
        subject: String,
    },
    /// A stored document cannot be read, or one to be stored cannot be written.
    #[error("a stored document cannot be read: {0}")]
    Document(#[from] serde_json::Error),
    /// A stored id cannot be read.
    #[error("a stored id cannot be read: {0}")]
    Id(#[from] crate::job::id::NotAnId),
    /// No connection was free in time.
    #[error("no connection to the database was free in time")]
    Busy,
    /// The database.
    #[error("database: {0}")]
    Database(sqlx::Error),
    /// The store cannot be opened.
    #[error("{0}")]
    Unusable(String),
}

impl From<sqlx::Error> for Error {
    fn from(error: sqlx::Error) -> Self {
        match error {
            sqlx::Error::PoolTimedOut => Self::Busy,
            other => Self::Database(other),
        }
    }
}

/// What the store gives back.
pub type Result<T> = std::result::Result<T, Error>;

/// The write transaction. Only one is open at a time.
pub(crate) type Writing = Transaction<'static, Sqlite>;

impl Store {
    /// Opens a write transaction. It takes the write lock at once: a transaction that read first and wrote later
    /// could be refused in the middle.
    pub(crate) async fn write(&self) -> Result<Writing> {
        Ok(self.writer.begin_with("BEGIN IMMEDIATE").await?)
    }

    /// Where changes of jobs are announced.
    #[must_use]
    pub fn changes(&self) -> &Changes {
        &self.changes
    }

    /// Whether the store answers.
    ///
    /// # Errors
    /// `Database`.
    pub async fn ping(&self) -> Result<()> {
        sqlx::query("SELECT 1").execute(&self.readers).await?;
        Ok(())
    }

    /// Closes all connections; what is committed is in the database file then.
    pub async fn close(&self) {
        self.readers.close().await;
        self.writer.close().await;
    }
}
