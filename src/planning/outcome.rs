//! What a planning attempt gives back: a report, programs and drawings.

use serde::Serialize;
use sha2::{Digest, Sha256};

use super::finding::{Finding, any_error};

/// The version that stands in every report; a change of it may change bytes.
pub const PLANNER_VERSION: &str = env!("CARGO_PKG_VERSION");

/// Whether a job gave a program that may be approved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// It did.
    Usable,
    /// It did not; the findings say why.
    NotUsable,
}

/// A file for a machine.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ProgramFile {
    /// File name, made from content only.
    pub name: String,
    /// `linuxcnc`, `sinumerik` or `krl`.
    pub dialect: &'static str,
    /// 7-bit ASCII.
    pub text: String,
}

/// A drawing.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Drawing {
    /// File name ending in `.svg`.
    pub name: String,
    /// SVG text.
    pub svg: String,
}

/// Everything that a planning attempt gives back. The report is complete; a program stands here only if its
/// replay has passed and the verdict is `usable`.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// Whether there is a program that may be approved.
    pub verdict: Verdict,
    /// The programs, none if the verdict is `not_usable`.
    pub programs: Vec<ProgramFile>,
    /// The drawings.
    pub drawings: Vec<Drawing>,
    /// All findings.
    pub findings: Vec<Finding>,
    /// `report.json` (jobs.md). The shell may add `stages`; nothing else changes after this.
    pub report: serde_json::Value,
}

/// A program as a report names it.
#[derive(Serialize)]
struct ProgramEntry<'a> {
    name: &'a str,
    dialect: &'a str,
    sha256: String,
    bytes: usize,
}

/// The fields that every report holds.
#[derive(Serialize)]
struct Report<'a, B> {
    kind: &'a str,
    planner_version: &'a str,
    input_sha256: &'a str,
    verdict: Verdict,
    findings: &'a [Finding],
    programs: Vec<ProgramEntry<'a>>,
    drawings: Vec<&'a str>,
    #[serde(flatten)]
    body: B,
}

impl Outcome {
    /// Puts an outcome together. Any finding of severity error takes the programs away.
    ///
    /// `body` holds the fields of the kind's own; `None` where planning stopped before it.
    ///
    /// # Panics
    /// If `body` cannot be written as a JSON object, which a test of its kind would show.
    #[must_use]
    pub fn new<B: Serialize>(
        kind: &str,
        input_sha256: &str,
        findings: Vec<Finding>,
        programs: Vec<ProgramFile>,
        drawings: Vec<Drawing>,
        body: Option<B>,
    ) -> Self {
        let usable = !any_error(&findings) && !programs.is_empty();
        let programs = if usable { programs } else { Vec::new() };
        let verdict = if usable { Verdict::Usable } else { Verdict::NotUsable };
        let report = serde_json::to_value(Report {
            kind,
            planner_version: PLANNER_VERSION,
            input_sha256,
            verdict,
            findings: &findings,
            programs: programs.iter().map(ProgramFile::entry).collect(),
            drawings: drawings.iter().map(|d| d.name.as_str()).collect(),
            body,
        })
        .expect("a report holds nothing but numbers, texts and lists of them");
        Self { verdict, programs, drawings, findings, report }
    }
}

impl ProgramFile {
    fn entry(&self) -> ProgramEntry<'_> {
        ProgramEntry {
            name: &self.name,
            dialect: self.dialect,
            sha256: sha256_hex(self.text.as_bytes()),
            bytes: self.text.len(),
        }
    }
}

/// The SHA-256 of some bytes in lower-case hex.
#[must_use]
pub fn sha256_hex(bytes: &[u8]) -> String {
    use std::fmt::Write;
    Sha256::digest(bytes).iter().fold(String::with_capacity(64), |mut hex, byte| {
        // Writing to a String cannot fail.
        let _ = write!(hex, "{byte:02x}");
        hex
    })
}
