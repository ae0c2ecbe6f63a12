//! File locks beside the database. They end with the process, however it ends.

use std::fs::{File, OpenOptions};
use std::path::{Path, PathBuf};

use rustix::fs::{FlockOperation, flock};

use super::{Error, Result};

/// A lock that is held until it is dropped.
#[derive(Debug)]
pub struct FileLock {
    _file: File,
}

impl FileLock {
    /// Waits for the lock under which the database is brought up to date: `SQLite`'s migrator takes none itself.
    pub(super) fn migrating(database: &Path) -> Result<Self> {
        Self::take(database, "-migrate.lock", FlockOperation::LockExclusive)
    }

    /// Takes the lock of the one process that serves this database.
    ///
    /// # Errors
    /// `Unusable`, in words, if another process serves it.
    pub fn serving(database: &Path) -> Result<Self> {
        Self::take(database, "-serve.lock", FlockOperation::NonBlockingLockExclusive)
    }

    fn take(database: &Path, suffix: &str, operation: FlockOperation) -> Result<Self> {
        let path = beside(database, suffix);
        let file =
            OpenOptions::new().create(true).truncate(false).write(true).open(&path).map_err(|error| {
                Error::Unusable(format!("cannot open the lock file {}: {error}", path.display()))
            })?;
        flock(&file, operation).map_err(|_| {
            let name = database.display();
            Error::Unusable(format!(
                "another bladeplan serves {name}; end it first, or name another --database"
            ))
        })?;
        Ok(Self { _file: file })
    }
}

fn beside(database: &Path, suffix: &str) -> PathBuf {
    let mut name = database.as_os_str().to_owned();
    name.push(suffix);
    PathBuf::from(name)
}
