//! What a planning attempt gives back: a report, programs and drawings.

use std::io;
use std::ops::Deref;
use std::sync::OnceLock;

use serde::{Deserialize, Serialize};
use serde_json::Value;
use sha2::{Digest, Sha256};

use super::drawing::stamp::stamped;
use super::finding::{Finding, any_error};
use super::json::written;

/// The version that stands in every report; a change of it may change bytes.
pub const PLANNER_VERSION: &str = env!("CARGO_PKG_VERSION");

/// Whether a job gave a program that may be approved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
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

/// A text that goes with a report: curves as CSV, a path for a CAM system.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Attachment {
    /// File name, made from content only.
    pub name: String,
    /// 7-bit ASCII.
    pub text: String,
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
    /// Texts that go with the report. None of them is for a machine.
    pub attachments: Vec<Attachment>,
    /// All findings.
    pub findings: Vec<Finding>,
    /// What was found, figure by figure.
    pub report: Report,
    /// The figures that a person wants first, a line each; none where the report says all.
    pub summary: Vec<String>,
}

/// A program as a report names it.
#[derive(Serialize)]
struct ProgramEntry<'a> {
    name: &'a str,
    dialect: &'a str,
    sha256: String,
    bytes: usize,
}

/// `report.json` (jobs.md), as text: that of a large ply is as large as the ply. Whoever asks for a field of it has it
/// read, once.
#[derive(Debug, Clone)]
pub struct Report {
    text: String,
    read: OnceLock<Value>,
}

impl Report {
    fn of(fields: &impl Serialize) -> Self {
        let mut text = written(fields);
        text.push('\n');
        Self { text, read: OnceLock::new() }
    }

    /// The text of the file; it ends with a line break.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Adds a field at the end.
    fn add(&mut self, name: &str, value: &impl Serialize) {
        const END: &str = "\n}\n";
        let value = written(value).replace('\n', "\n  ");
        self.text.truncate(self.text.len() - END.len());
        self.text.push_str(&format!(",\n  \"{name}\": {value}{END}"));
        self.read = OnceLock::new();
    }
}

impl Deref for Report {
    type Target = Value;

    fn deref(&self) -> &Value {
        self.read.get_or_init(|| serde_json::from_str(&self.text).expect("it was written as JSON"))
    }
}

impl PartialEq for Report {
    fn eq(&self, other: &Self) -> bool {
        self.text == other.text
    }
}

/// The fields that every report holds.
#[derive(Serialize)]
struct Fields<'a, B> {
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
        Self::with_verdict(usable, kind, input_sha256, findings, programs, drawings, body)
    }

    /// The outcome of a job that asks for figures and no program: usable unless a finding is an error.
    ///
    /// # Panics
    /// As [`Outcome::new`].
    #[must_use]
    pub fn of_figures<B: Serialize>(
        kind: &str,
        input_sha256: &str,
        findings: Vec<Finding>,
        drawings: Vec<Drawing>,
        body: B,
    ) -> Self {
        let usable = !any_error(&findings);
        Self::with_verdict(usable, kind, input_sha256, findings, Vec::new(), drawings, Some(body))
    }

    /// The same with texts that go with the report, which names them.
    #[must_use]
    pub fn with_attachments(mut self, attachments: Vec<Attachment>) -> Self {
        let names: Vec<&str> = attachments.iter().map(|attachment| attachment.name.as_str()).collect();
        self.report.add("attachments", &names);
        Self { attachments, ..self }
    }

    /// The same with the figures that a person wants first.
    #[must_use]
    pub fn with_summary(self, summary: Vec<String>) -> Self {
        Self { summary, ..self }
    }

    fn with_verdict<B: Serialize>(
        usable: bool,
        kind: &str,
        input_sha256: &str,
        findings: Vec<Finding>,
        programs: Vec<ProgramFile>,
        drawings: Vec<Drawing>,
        body: Option<B>,
    ) -> Self {
        let programs = if usable { programs } else { Vec::new() };
        let verdict = if usable { Verdict::Usable } else { Verdict::NotUsable };
        let drawings: Vec<_> = drawings.into_iter().map(|drawing| stamped(drawing, input_sha256)).collect();
        let report = Report::of(&Fields {
            kind,
            planner_version: PLANNER_VERSION,
            input_sha256,
            verdict,
            findings: &findings,
            programs: programs.iter().map(ProgramFile::entry).collect(),
            drawings: drawings.iter().map(|d| d.name.as_str()).collect(),
            body,
        });
        let (attachments, summary) = (Vec::new(), Vec::new());
        Self { verdict, programs, drawings, attachments, findings, report, summary }
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
    hex(&Sha256::digest(bytes))
}

/// The SHA-256 of a text that nobody holds as a whole.
#[derive(Debug, Default)]
pub struct Sha256Text {
    hasher: Sha256,
}

impl Sha256Text {
    /// The text goes on with this.
    pub fn add(&mut self, part: &str) {
        self.hasher.update(part);
    }

    /// The sum of all of it in lower-case hex.
    #[must_use]
    pub fn hex(self) -> String {
        hex(&self.hasher.finalize())
    }
}

impl io::Write for Sha256Text {
    fn write(&mut self, part: &[u8]) -> io::Result<usize> {
        self.hasher.update(part);
        Ok(part.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

fn hex(bytes: &[u8]) -> String {
    use std::fmt::Write;
    bytes.iter().fold(String::with_capacity(2 * bytes.len()), |mut hex, byte| {
        // Writing to a String cannot fail.
        let _ = write!(hex, "{byte:02x}");
        hex
    })
}
