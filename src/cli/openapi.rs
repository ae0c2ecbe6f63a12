//! `bladeplan openapi`: prints the OpenAPI document.

use std::io::Write;
use std::process::ExitCode;

/// Prints it.
#[must_use]
pub fn run() -> ExitCode {
    // A reader that has seen enough, such as `head`, is no fault of ours.
    let _ = std::io::stdout().write_all(crate::http::openapi::text().as_bytes());
    ExitCode::SUCCESS
}
