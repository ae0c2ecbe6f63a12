//! `bladeplan plan JOB.json --out DIR`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::AtomicBool;

use clap::Args;
use serde::Deserialize;

use super::job::{EXIT_CODES, INVALID, NOT_USABLE, read, refuse, say};
use crate::planning::attempt::plan;
use crate::planning::budget::{Budget, DEFAULT_STEPS};
use crate::planning::outcome::{Outcome, Verdict};
use crate::planning::tape::machine::Catalogue;

/// Name of the report.
const REPORT: &str = "report.json";

/// The arguments of `bladeplan plan`.
#[derive(Debug, Args)]
#[command(after_help = EXIT_CODES)]
pub struct Arguments {
    /// The job document; the files that it names lie in its folder
    job: PathBuf,
    /// The folder for report.json, the programs and the drawings; it is made if need be
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

/// Plans a job and writes what came of it.
#[must_use]
pub fn run(arguments: &Arguments) -> ExitCode {
    // A report may be as large as its ply: it is read before there is anything else to keep.
    let left = Left::read(&arguments.out);
    let (document, files) = match read(&arguments.job) {
        Ok(read) => read,
        Err(code) => {
            eprintln!("nothing was written{}", older_files(&arguments.out));
            return code;
        }
    };
    let cancelled = AtomicBool::new(false);
    let on_stage = |stage: &'static str| eprintln!("{stage} ...");
    let budget = Budget::new(DEFAULT_STEPS, &cancelled, &on_stage);
    let outcome = match plan(&document, &files, &Catalogue::built_in(), &budget) {
        Ok(outcome) => outcome,
        Err(faults) => {
            let code = refuse(&faults);
            eprintln!("nothing was written{}", older_files(&arguments.out));
            return code;
        }
    };
    if let Err(error) = write(&outcome, &arguments.out, left) {
        eprintln!("cannot write into {}: {error}", arguments.out.display());
        return ExitCode::from(INVALID);
    }
    for finding in &outcome.findings {
        eprintln!("{finding}");
    }
    for line in &outcome.summary {
        say(line);
    }
    match outcome.verdict {
        Verdict::Usable => ExitCode::SUCCESS,
        Verdict::NotUsable => {
            eprintln!("no usable program: see the findings above and in report.json");
            ExitCode::from(NOT_USABLE)
        }
    }
}

/// What to say of files that an earlier plan has left.
fn older_files(folder: &Path) -> String {
    if folder.join(REPORT).exists() {
        format!("; what lies in {} is of an earlier plan", folder.display())
    } else {
        String::new()
    }
}

/// What an earlier plan has left, as its report names it.
#[derive(Deserialize, Default)]
#[serde(default)]
struct Left {
    programs: Vec<LeftProgram>,
    drawings: Vec<String>,
    attachments: Vec<String>,
}

#[derive(Deserialize)]
struct LeftProgram {
    name: String,
}

impl Left {
    fn read(folder: &Path) -> Self {
        let report = std::fs::read(folder.join(REPORT)).unwrap_or_default();
        serde_json::from_slice(&report).unwrap_or_default()
    }
}

/// Takes away what an earlier plan has left: a program of another job must not lie beside this one's report.
fn clear(folder: &Path, Left { programs, drawings, attachments }: Left) -> std::io::Result<()> {
    let programs = programs.into_iter().map(|program| program.name);
    for name in programs.chain(drawings).chain(attachments).chain([REPORT.to_owned()]) {
        let name = name.as_str();
        // A name with a path in it is not one that was written here.
        let path = folder.join(name);
        if Path::new(name).file_name().is_some_and(|plain| plain == name) && path.is_file() {
            std::fs::remove_file(path)?;
        }
    }
    Ok(())
}

fn write(outcome: &Outcome, folder: &Path, left: Left) -> std::io::Result<()> {
    std::fs::create_dir_all(folder)?;
    clear(folder, left)?;
    let report = outcome.report.text();
    let files = std::iter::once((REPORT, report))
        .chain(outcome.programs.iter().map(|program| (program.name.as_str(), program.text.as_str())))
        .chain(outcome.drawings.iter().map(|drawing| (drawing.name.as_str(), drawing.svg.as_str())))
        .chain(outcome.attachments.iter().map(|text| (text.name.as_str(), text.text.as_str())));
    for (name, text) in files {
        let path = folder.join(name);
        std::fs::write(&path, text)?;
        say(format_args!("{} {} bytes", path.display(), text.len()));
    }
    Ok(())
}
