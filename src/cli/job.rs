//! What the subcommands that take a job share: reading it, and the meaning of an exit code.

use std::path::Path;
use std::process::ExitCode;

use crate::planning::document::{self, JobDocument};
use crate::planning::finding::Finding;

/// Exit code of an invalid input; nothing was written.
pub const INVALID: u8 = 2;
/// Exit code of a valid job without a usable program.
pub const NOT_USABLE: u8 = 3;

/// Explains the exit codes under `--help`.
pub const EXIT_CODES: &str = "Exit codes: 0 usable; 2 invalid input, every fault on standard error; \
    3 valid, but no usable program: see the findings";

/// Reads a job document from a file.
///
/// # Errors
/// The exit code, once every fault has been printed.
pub fn read(path: &Path) -> Result<JobDocument, ExitCode> {
    let text = std::fs::read(path).map_err(|error| {
        eprintln!("cannot read the job {}: {error}", path.display());
        ExitCode::from(INVALID)
    })?;
    document::read(&text).map_err(|faults| refuse(&faults))
}

/// Prints every fault of an invalid input.
#[must_use]
pub fn refuse(faults: &[Finding]) -> ExitCode {
    for fault in faults {
        eprintln!("{fault}");
    }
    let count = faults.len();
    eprintln!("the job is invalid: {count} fault{}", if count == 1 { "" } else { "s" });
    ExitCode::from(INVALID)
}
