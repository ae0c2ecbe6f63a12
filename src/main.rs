//! The `bladeplan` program.

use std::process::ExitCode;

fn main() -> ExitCode {
    bladeplan::cli::run()
}
