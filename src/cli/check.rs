//! `bladeplan check PROGRAM --job JOB.json`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;

use super::job::{EXIT_CODES, INVALID, NOT_USABLE, read, refuse, say};
use crate::planning::attempt::check;
use crate::planning::budget::Budget;
use crate::planning::finding::any_error;
use crate::planning::outcome::ProgramFile;
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
    let program = match program(&arguments.program) {
        Ok(program) => program,
        Err(error) => {
            eprintln!("cannot read the program {}: {error}", arguments.program.display());
            return ExitCode::from(INVALID);
        }
    };
    let (replay, findings) =
        match check(&document, &files, &Catalogue::built_in(), &program, &Budget::unwatched()) {
            Ok(checked) => checked,
            Err(faults) => return refuse(&faults),
        };
    for finding in &findings {
        eprintln!("{finding}");
    }
    say(replay);
    if any_error(&findings) {
        say("must not run");
        return ExitCode::from(NOT_USABLE);
    }
    say("usable");
    ExitCode::SUCCESS
}

/// The endings of a KUKA robot's programs and data lists, which call one another by name.
const KRL_ENDINGS: [&str; 2] = ["src", "dat"];

/// A program and, where it may call others, what lies beside it.
fn program(path: &Path) -> std::io::Result<Vec<ProgramFile>> {
    let mut files = vec![file(path)?];
    if !is_krl(path) {
        return Ok(files);
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut beside: Vec<PathBuf> = std::fs::read_dir(folder)?
        .filter_map(|entry| entry.ok().map(|entry| entry.path()))
        .filter(|other| is_krl(other) && other.is_file() && belongs_to(other, path))
        .collect();
    beside.sort();
    for other in beside {
        files.push(file(&other)?);
    }
    Ok(files)
}

/// Sub-programs and data lists have names that begin with the main program's.
fn belongs_to(other: &Path, main: &Path) -> bool {
    let stem = |path: &Path| path.file_stem().map(|stem| stem.to_string_lossy().to_lowercase());
    let begins = |other: String, main: String| other.starts_with(&main);
    other.file_name() != main.file_name()
        && stem(other).zip(stem(main)).is_some_and(|(other, main)| begins(other, main))
}

fn is_krl(path: &Path) -> bool {
    path.extension().is_some_and(|ending| KRL_ENDINGS.iter().any(|krl| ending.eq_ignore_ascii_case(krl)))
}

fn file(path: &Path) -> std::io::Result<ProgramFile> {
    let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let text = String::from_utf8_lossy(&std::fs::read(path)?).into_owned();
    Ok(ProgramFile { name, dialect: if is_krl(path) { "krl" } else { "nc" }, text })
}
