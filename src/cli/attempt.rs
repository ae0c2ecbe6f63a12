//! `bladeplan attempt`: the child that plans one job for the service.

use std::process::ExitCode;

pub use crate::worker::child::Limits;

/// Plans the job on standard input; says on standard error why it could not.
#[must_use]
pub fn run(limits: &Limits) -> ExitCode {
    match crate::worker::child::run(limits) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}
