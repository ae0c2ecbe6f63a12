//! The job document: text from outside, read once into typed input, every fault with its JSON pointer.

pub mod files;
pub mod shape;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use self::files::NamedFile;
use self::shape::{Field, Shape, optional, required};
use super::finding::{Code, Finding};
use super::tape::wire::{TAPE_CUT, TapeCut};

/// A job as MES, curl and the command line send it (jobs.md).
#[derive(Debug, Clone, Serialize)]
pub struct JobDocument {
    /// A label for people; it never reaches a machine program.
    pub name: String,
    /// Free, searchable strings.
    pub references: BTreeMap<String, String>,
    /// What is to be planned.
    #[serde(flatten)]
    pub input: JobInput,
    /// The files that it names, in the order of its fields.
    #[serde(skip)]
    pub named_files: Vec<NamedFile>,
}

/// What is to be planned, by kind.
#[derive(Debug, Clone, Serialize)]
#[serde(tag = "kind", content = "input", rename_all = "kebab-case")]
pub enum JobInput {
    /// The courses of a ply, cut from tape by one or two knives.
    TapeCut(Box<TapeCut>),
}

impl JobInput {
    /// The word that stands in `kind`.
    #[must_use]
    pub fn kind(&self) -> &'static str {
        match self {
            Self::TapeCut(_) => "tape-cut",
        }
    }
}

const NAME: Shape = Shape::Text { max_chars: 200 };
const REFERENCES: Shape = Shape::Texts { max: 50, max_chars: 200 };

const TAPE_CUT_JOB: &[Field] = &[
    required("kind", Shape::Text { max_chars: 40 }),
    optional("name", NAME),
    optional("references", REFERENCES),
    required("input", Shape::Object(TAPE_CUT)),
];

/// The shape of a job document.
pub const JOB: Shape = Shape::Tagged { tag: "kind", variants: &[("tape-cut", TAPE_CUT_JOB)] };

/// Reads a job document.
///
/// # Errors
/// Every fault of structure, type and number at once, each with its JSON pointer.
pub fn read(text: &[u8]) -> Result<JobDocument, Vec<Finding>> {
    let value = parse(text).map_err(|fault| vec![fault])?;
    from_value(value)
}

/// Reads a job document that was parsed already.
///
/// # Errors
/// Every fault of structure, type and number at once, each with its JSON pointer.
pub fn from_value(mut value: Value) -> Result<JobDocument, Vec<Finding>> {
    let faults = JOB.faults(&value, "");
    if !faults.is_empty() {
        return Err(faults);
    }
    let named_files = JOB.named_files(&value, "");
    let kind = value["kind"].as_str().unwrap_or_default().to_owned();
    let name = typed(value["name"].take(), "/name").map(Option::unwrap_or_default)?;
    let references = typed(value["references"].take(), "/references").map(Option::unwrap_or_default)?;
    let input = match kind.as_str() {
        "tape-cut" => JobInput::TapeCut(typed(value["input"].take(), "/input")?),
        _ => return Err(vec![Finding::error(Code::UnknownValue, "/kind", "this kind of job is not known")]),
    };
    Ok(JobDocument { name, references, input, named_files })
}

/// Reads a value that has passed its shape. A fault here means that the shape and the type disagree.
fn typed<T: for<'a> Deserialize<'a>>(value: Value, at: &str) -> Result<T, Vec<Finding>> {
    serde_path_to_error::deserialize(value).map_err(|error| {
        let at = format!("{at}{}", pointer_of(error.path()));
        vec![Finding::error(Code::WrongType, at, error.inner().to_string())]
    })
}

/// Parses JSON text.
///
/// # Errors
/// `InvalidJson`, `TooDeep` or `InvalidNumber` with the JSON pointer where reading stopped.
pub fn parse(text: &[u8]) -> Result<Value, Finding> {
    let mut reader = serde_json::Deserializer::from_slice(text);
    let value = serde_path_to_error::deserialize(&mut reader).map_err(|error| {
        let at = pointer_of(error.path());
        unreadable(error.inner(), at)
    })?;
    reader.end().map_err(|error| unreadable(&error, String::new()))?;
    Ok(value)
}

fn unreadable(error: &serde_json::Error, at: String) -> Finding {
    let text = error.to_string();
    let code = if text.contains("recursion limit") {
        Code::TooDeep
    } else if text.contains("number out of range") {
        Code::InvalidNumber
    } else {
        Code::InvalidJson
    };
    // A very deep pointer would be as long as the document itself.
    let at = if code == Code::TooDeep { String::new() } else { at };
    Finding::error(code, at, format!("not a JSON document: {text}"))
}

fn pointer_of(path: &serde_path_to_error::Path) -> String {
    use serde_path_to_error::Segment;
    path.iter().fold(String::new(), |at, segment| match segment {
        Segment::Seq { index } => format!("{at}/{index}"),
        Segment::Map { key } => shape::pointer(&at, key),
        Segment::Enum { variant } => shape::pointer(&at, variant),
        Segment::Unknown => at,
    })
}
