//! Opening the database: version, pragmas, migrations.

use std::path::Path;
use std::time::Duration;

use sqlx::migrate::Migrator;
use sqlx::sqlite::{SqliteConnectOptions, SqliteJournalMode, SqlitePoolOptions, SqliteSynchronous};
use sqlx::{Row, SqlitePool};

use super::changes::Changes;
use super::lock::FileLock;
use super::{Error, Result, Store};

/// Older ones can corrupt a WAL database when a checkpoint meets a write ("WAL-reset bug", fixed in 3.51.3).
const OLDEST_SQLITE: (u32, u32, u32) = (3, 51, 3);

/// Readers beside the one writer. A read takes well under a millisecond.
const READERS: u32 = 4;

/// Another process holds the write lock for one short transaction at most.
const BUSY: Duration = Duration::from_secs(10);

/// How long a request waits for a connection before it is told to come back.
const ACQUIRE: Duration = Duration::from_secs(10);

static MIGRATIONS: Migrator = sqlx::migrate!("migrations/sqlite");

impl Store {
    /// Opens the database file, makes it if it is not there, and brings its tables up to date.
    ///
    /// # Errors
    /// `Unusable`, in words, if the `SQLite` that is linked is too old or the file cannot be used.
    pub async fn open(database: &Path) -> Result<Self> {
        let writer = writer(database).await.map_err(|error| unusable(database, &error))?;
        refuse_old_sqlite(&writer).await?;
        bring_up_to_date(&writer, database).await?;
        let readers = readers(database).await.map_err(|error| unusable(database, &error))?;
        Ok(Self { writer, readers, changes: Changes::default() })
    }
}

fn unusable(database: &Path, error: &sqlx::Error) -> Error {
    Error::Unusable(format!("cannot open the database {}: {error}", database.display()))
}

fn options(database: &Path) -> SqliteConnectOptions {
    SqliteConnectOptions::new()
        .filename(database)
        .create_if_missing(true)
        .journal_mode(SqliteJournalMode::Wal)
        // NORMAL loses acknowledged commits at a power loss.
        .synchronous(SqliteSynchronous::Full)
        .foreign_keys(true)
        .busy_timeout(BUSY)
}

async fn writer(database: &Path) -> sqlx::Result<SqlitePool> {
    let pool = SqlitePoolOptions::new().min_connections(1).max_connections(1).acquire_timeout(ACQUIRE);
    pool.connect_with(options(database)).await
}

async fn readers(database: &Path) -> sqlx::Result<SqlitePool> {
    let pool = SqlitePoolOptions::new().min_connections(1).max_connections(READERS).acquire_timeout(ACQUIRE);
    pool.connect_with(options(database).pragma("query_only", "ON")).await
}

async fn refuse_old_sqlite(pool: &SqlitePool) -> Result<()> {
    let version: String = sqlx::query("SELECT sqlite_version()").fetch_one(pool).await?.get(0);
    if is_new_enough(&version) {
        return Ok(());
    }
    let (major, minor, patch) = OLDEST_SQLITE;
    Err(Error::Unusable(format!(
        "SQLite {version} is linked, {major}.{minor}.{patch} is needed: older ones can corrupt the database. \
         Build bladeplan with the SQLite that it brings along"
    )))
}

fn is_new_enough(version: &str) -> bool {
    let mut parts = version.split('.').map(|part| part.parse().unwrap_or(0));
    let mut next = || parts.next().unwrap_or(0);
    (next(), next(), next()) >= OLDEST_SQLITE
}

async fn bring_up_to_date(pool: &SqlitePool, database: &Path) -> Result<()> {
    let _lock = FileLock::migrating(database)?;
    MIGRATIONS.run(pool).await.map_err(|error| {
        let name = database.display();
        Error::Unusable(format!("cannot bring the tables of {name} up to date: {error}"))
    })
}

#[cfg(test)]
mod tests {
    use super::{is_new_enough, writer};

    #[tokio::test]
    async fn the_writer_keeps_what_it_has_acknowledged_through_a_power_loss() {
        let folder = tempfile::TempDir::new().unwrap();
        let pool = writer(&folder.path().join("x.db")).await.unwrap();
        let (mode,): (String,) = sqlx::query_as("PRAGMA journal_mode").fetch_one(&pool).await.unwrap();
        let (synchronous,): (i64,) = sqlx::query_as("PRAGMA synchronous").fetch_one(&pool).await.unwrap();
        const FULL: i64 = 2;
        assert_eq!((mode.as_str(), synchronous), ("wal", FULL));
    }

    #[test]
    fn sqlite_below_3_51_3_is_refused() {
        assert!(!is_new_enough("3.51.2"));
        assert!(!is_new_enough("3.9.99"));
        assert!(!is_new_enough("nonsense"));
        assert!(is_new_enough("3.51.3"));
        assert!(is_new_enough("3.52.0"));
        assert!(is_new_enough("4.0"));
    }
}
