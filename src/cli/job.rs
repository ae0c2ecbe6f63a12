//! What the subcommands that take a job share: reading it and its files, and the meaning of an exit code.

use std::io::Write;
use std::path::Path;
use std::process::ExitCode;

use super::folder::named_files;
use crate::planning::attempt::validate;
use crate::planning::document::files::Files;
use crate::planning::document::{self, JobDocument};
use crate::planning::finding::{Code, Finding};
use crate::planning::tape::machine::Catalogue;

/// Exit code of an invalid input; nothing was written.
pub const INVALID: u8 = 2;
/// Exit code of a valid job without a usable program.
pub const NOT_USABLE: u8 = 3;

/// Explains the exit codes under `--help`.
pub const EXIT_CODES: &str = "Exit codes: 0 usable; 2 invalid input, every fault on standard error; \
    3 valid, but no usable program: see the findings";

/// Reads a job document from a file, and from its folder the files that it names.
///
/// # Errors
/// The exit code, once every fault has been printed.
pub fn read(path: &Path) -> Result<(JobDocument, Files), ExitCode> {
    let text = std::fs::read(path).map_err(|error| {
        eprintln!("cannot read the job {}: {error}", path.display());
        ExitCode::from(INVALID)
    })?;
    let document = document::read(&text).map_err(|faults| refuse(&faults))?;
    let (files, faults) = named_files(path, &document.named_files);
    if faults.is_empty() { Ok((document, files)) } else { Err(refuse_with(faults, &document, &files)) }
}

/// Refuses a job for its files, and says every other fault beside.
fn refuse_with(mut faults: Vec<Finding>, document: &JobDocument, files: &Files) -> ExitCode {
    let others = validate(document, files, &Catalogue::built_in()).err().unwrap_or_default();
    // Why a file is not there was said better already.
    faults.extend(others.into_iter().filter(|fault| fault.code != Code::UnknownFile));
    refuse(&faults)
}

/// Prints a line for whoever reads on; a reader that has seen enough, such as `head`, is no fault of ours.
pub fn say(line: impl std::fmt::Display) {
    let _ = writeln!(std::io::stdout(), "{line}");
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
