//! The job document: text from outside, read once into typed input, every fault with its JSON pointer.

pub mod dry_run;
pub mod files;
mod limit;
mod once;
mod quick;
pub mod shape;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use self::files::NamedFile;
use self::once::{Once, TWICE};
use self::shape::{Field, Shape, optional, required};
use super::finding::{Code, Finding};
use super::honeycomb::wire::{
    CellReference, HONEYCOMB_CONVERT, HONEYCOMB_CUT, HONEYCOMB_OPTIMUM, HoneycombConvert, HoneycombCut,
    HoneycombOptimum,
};
use super::tape::wire::{MachineReference, TAPE_CUT, TapeCut};

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
    /// A honeycomb core, cut by a robot with a straight blade.
    HoneycombCut(Box<HoneycombCut>),
    /// The published model of such cutting alone.
    HoneycombOptimum(Box<HoneycombOptimum>),
    /// A milling program, made into one for such cutting.
    HoneycombConvert(Box<HoneycombConvert>),
}

impl JobInput {
    /// The word that stands in `kind`.
    #[must_use]
    pub fn kind(&self) -> &'static str {
        match self {
            Self::TapeCut(_) => "tape-cut",
            Self::HoneycombCut(_) => "honeycomb-cut",
            Self::HoneycombOptimum(_) => "honeycomb-optimum",
            Self::HoneycombConvert(_) => "honeycomb-convert",
        }
    }

    /// The name of its machine, if that does not stand in the job in full.
    #[must_use]
    pub fn named_machine(&self) -> Option<&str> {
        let cell = match self {
            Self::TapeCut(input) => {
                return match &input.machine {
                    MachineReference::Named(name) => Some(name),
                    MachineReference::Inline(_) => None,
                };
            }
            Self::HoneycombCut(input) => &input.cell,
            Self::HoneycombConvert(input) => &input.cell,
            Self::HoneycombOptimum(_) => return None,
        };
        match cell {
            Some(CellReference::Named(name)) => Some(name),
            Some(CellReference::Inline(_)) | None => None,
        }
    }
}

const NAME: Shape = Shape::Name { max_chars: 200 };
const REFERENCES: Shape = Shape::Texts { max: 50, max_chars: 200 };

const KIND: Shape = Shape::Text { max_chars: 40 };

/// The fields of a job, of which only the input differs from kind to kind.
const fn job(input: &'static [Field]) -> [Field; 4] {
    [
        required("kind", KIND),
        optional("name", NAME),
        optional("references", REFERENCES),
        required("input", Shape::Object(input)),
    ]
}

const TAPE_CUT_JOB: [Field; 4] = job(TAPE_CUT);
const HONEYCOMB_CUT_JOB: [Field; 4] = job(HONEYCOMB_CUT);
const HONEYCOMB_OPTIMUM_JOB: [Field; 4] = job(HONEYCOMB_OPTIMUM);
const HONEYCOMB_CONVERT_JOB: [Field; 4] = job(HONEYCOMB_CONVERT);

/// The shape of a job document.
pub const JOB: Shape = Shape::Tagged {
    tag: "kind",
    variants: &[
        ("tape-cut", &TAPE_CUT_JOB),
        ("honeycomb-cut", &HONEYCOMB_CUT_JOB),
        ("honeycomb-optimum", &HONEYCOMB_OPTIMUM_JOB),
        ("honeycomb-convert", &HONEYCOMB_CONVERT_JOB),
    ],
};

/// Reads a job document.
///
/// # Errors
/// Every fault of structure, type and number at once, each with its JSON pointer.
pub fn read(text: &[u8]) -> Result<JobDocument, Vec<Finding>> {
    if let Some(document) = quick::read(text) {
        return Ok(document);
    }
    let value = parse(text).map_err(|fault| vec![with_limit(fault)])?;
    from_value(value)
}

/// A number that cannot be held cannot be compared with its limit either; the fault names it all the same.
fn with_limit(fault: Finding) -> Finding {
    match JOB.limit_at(&fault.at) {
        Some(limit) if fault.code == Code::InvalidNumber => {
            Finding { message: format!("{}; it {limit}", fault.message), ..fault }
        }
        _ => fault,
    }
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
        "honeycomb-cut" => JobInput::HoneycombCut(typed(value["input"].take(), "/input")?),
        "honeycomb-optimum" => JobInput::HoneycombOptimum(typed(value["input"].take(), "/input")?),
        "honeycomb-convert" => JobInput::HoneycombConvert(typed(value["input"].take(), "/input")?),
        _ => return Err(vec![Finding::error(Code::UnknownValue, "/kind", "this kind of job is not known")]),
    };
    Ok(JobDocument { name, references, input, named_files })
}

/// Reads a value into its type. One that has passed its shape has no fault, unless the shape and the type disagree.
///
/// # Errors
/// The first fault: where it is below `at`, and what.
pub fn typed<T: for<'a> Deserialize<'a>>(value: Value, at: &str) -> Result<T, Vec<Finding>> {
    serde_path_to_error::deserialize(value).map_err(|error| {
        let at = format!("{at}{}", pointer_of(error.path()));
        let words = error.inner().to_string();
        vec![Finding::error(misfit(&words), at, words)]
    })
}

/// The code of a value that does not fit its type, which `serde` tells in words only.
fn misfit(words: &str) -> Code {
    let kinds = [
        ("missing field", Code::MissingField),
        ("unknown field", Code::UnknownField),
        ("unknown variant", Code::UnknownValue),
    ];
    kinds.into_iter().find(|(start, _)| words.starts_with(start)).map_or(Code::WrongType, |(_, code)| code)
}

/// Parses JSON text.
///
/// # Errors
/// `InvalidJson`, `TooDeep`, `InvalidNumber` or `DuplicateField` with the JSON pointer where reading stopped.
pub fn parse(text: &[u8]) -> Result<Value, Finding> {
    if text.starts_with("\u{feff}".as_bytes()) {
        let message = "begins with a byte order mark, which JSON has none of; save it as UTF-8 without one";
        return Err(Finding::error(Code::InvalidJson, "", message));
    }
    let mut reader = serde_json::Deserializer::from_slice(text);
    let Once(value) = serde_path_to_error::deserialize(&mut reader).map_err(|error| {
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
    } else if text.starts_with(TWICE) {
        Code::DuplicateField
    } else {
        Code::InvalidJson
    };
    // A very deep pointer would be as long as the document itself.
    let at = if code == Code::TooDeep { String::new() } else { at };
    let message = match code {
        Code::DuplicateField => TWICE.to_owned(),
        Code::InvalidNumber => format!("{text}: a number is at most {:e} in size", f64::MAX),
        _ => format!("not a JSON document: {text}"),
    };
    Finding::error(code, at, message)
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
