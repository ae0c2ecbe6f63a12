//! `bladeplan check PROGRAM --job JOB.json`.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;

use super::job::{EXIT_CODES, INVALID, NOT_USABLE, read, refuse};
use crate::planning::attempt::check;
use crate::planning::budget::Budget;
use crate::planning::finding::any_error;
use crate::planning::tape::machine::Catalogue;

/// The arguments of `bladeplan check`.
#[derive(Debug, Args)]
#[command(after_help = EXIT_CODES)]
pub struct Arguments {
    /// The program
    program: PathBuf,
    /// The job that it should carry out; the files that it names lie in its folder
    #[arg(long, value_name = "JOB.json")]
    job: PathBuf,
}

/// Replays a program against its job and says what it found.
#[must_use]
pub fn run(arguments: &Arguments) -> ExitCode {
    let (document, files) = match read(&arguments.job) {
        Ok(read) => read,
        Err(code) => return code,
    };
    let text = match std::fs::read(&arguments.program) {
        Ok(bytes) => String::from_utf8_lossy(&bytes).into_owned(),
        Err(error) => {
            eprintln!("cannot read the program {}: {error}", arguments.program.display());
            return ExitCode::from(INVALID);
        }
    };
    let name =
        arguments.program.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let (replay, findings) =
        match check(&document, &files, &Catalogue::built_in(), &name, &text, &Budget::unwatched()) {
            Ok(checked) => checked,
            Err(faults) => return refuse(&faults),
        };
    for finding in &findings {
        eprintln!("{finding}");
    }
    println!("{replay}");
    if any_error(&findings) {
        println!("must not run");
        return ExitCode::from(NOT_USABLE);
    }
    println!("usable");
    ExitCode::SUCCESS
}
