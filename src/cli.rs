//! The command line. Each subcommand is one file under `cli/`.

pub mod attempt;
pub mod check;
pub mod folder;
pub mod job;
pub mod key;
pub mod openapi;
pub mod plan;
pub mod serve;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Plans, checks and serves programs for machines that cut with ultrasonic knives
#[derive(Debug, Parser)]
#[command(name = "bladeplan", version, max_term_width = 100)]
struct Line {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Plan a job without a service: report, programs and drawings go into a folder
    Plan(plan::Arguments),
    /// Read a program back and replay it against its job
    Check(check::Arguments),
    /// Run the service
    Serve(Box<crate::config::Config>),
    /// Make, list and revoke keys
    Key(key::Arguments),
    /// Print the OpenAPI document
    Openapi,
    /// Plan one job for the service: job in, answer out
    #[command(hide = true)]
    Attempt(attempt::Limits),
}

/// Runs the command line of this process.
#[must_use]
pub fn run() -> ExitCode {
    match Line::parse().command {
        Command::Plan(arguments) => plan::run(&arguments),
        Command::Check(arguments) => check::run(&arguments),
        Command::Serve(config) => serve::run(*config),
        Command::Key(arguments) => key::run(arguments),
        Command::Openapi => openapi::run(),
        Command::Attempt(limits) => attempt::run(&limits),
    }
}
