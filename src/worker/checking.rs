//! Checking a document and its files before they are taken in, in a child like any attempt: the service itself never
//! takes a document of a sender's apart.

use std::collections::BTreeMap;
use std::time::Duration;

use serde::{Deserialize, Serialize};
use tokio::time::{Instant, timeout_at};

use super::planner::{Heard, Last, Planner, Task};
use crate::config::Config;
use crate::planning::finding::{Code, Finding};
use crate::store::attempts::AttemptInput;

/// What a check does not know by then is left to the attempt.
const TIME: Duration = Duration::from_secs(20);

/// What the store keeps of a document beside its bytes.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Label {
    /// The kind of work.
    pub kind: String,
    /// A label for people.
    #[serde(default)]
    pub name: String,
    /// Free, searchable strings.
    #[serde(default)]
    pub references: BTreeMap<String, String>,
}

/// What a check has found.
#[derive(Debug)]
pub enum Checked {
    /// The document has no faults.
    Sound(Label),
    /// It has these.
    Faulty(Vec<Finding>),
    /// The check met a limit or was killed.
    Undecided,
}

/// Checks a document and whether its files are those that it names.
///
/// # Errors
/// If the system starts no process.
pub async fn check(config: &Config, input: AttemptInput) -> std::io::Result<Checked> {
    let until = Instant::now() + TIME;
    let mut planner = Planner::start(config, Task::Check, input)?;
    loop {
        match timeout_at(until, planner.hear()).await {
            Ok(Heard::Stage(..)) => {}
            Ok(Heard::Last(Last::Sound(label))) => return Ok(Checked::Sound(label)),
            Ok(Heard::Last(Last::Faults(faults))) => return Ok(Checked::Faulty(faults)),
            Ok(Heard::Last(_)) => {
                // The cause goes to the log.
                planner.cause().await;
                return Ok(Checked::Undecided);
            }
            Err(_) => {
                planner.kill().await;
                return Ok(Checked::Undecided);
            }
        }
    }
}

/// Reads nothing but the label of a document, for one whose check was not decided.
///
/// # Errors
/// The document is not an object with these fields, or they are longer than any job's.
pub fn label(body: &[u8]) -> Result<Label, Vec<Finding>> {
    let refuse = |code, words: String| vec![Finding::error(code, "", words)];
    let label: Label = serde_json::from_slice(body)
        .map_err(|error| refuse(Code::InvalidJson, format!("no job document: {error}")))?;
    let pairs = label.references.iter().map(|(name, value)| name.len() + value.len());
    let length = label.kind.len() + label.name.len() + pairs.sum::<usize>();
    if length <= LONGEST_LABEL {
        Ok(label)
    } else {
        Err(refuse(Code::OutOfRange, format!("kind, name and references take {length} bytes")))
    }
}

/// 50 references of 200 characters, name and value, each of at most 4 bytes, fit.
const LONGEST_LABEL: usize = 100_000;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_label_is_read_without_the_rest() {
        let found = label(br#"{"kind": "tape-cut", "input": [[[1e5, {"x": "y"}]]], "name": "ply"}"#).unwrap();
        assert_eq!((found.kind.as_str(), found.name.as_str()), ("tape-cut", "ply"));
        assert!(label(b"{}").is_err());
        let endless = format!(r#"{{"kind": "tape-cut", "name": "{}"}}"#, "x".repeat(LONGEST_LABEL));
        assert_eq!(label(endless.as_bytes()).unwrap_err()[0].code, Code::OutOfRange);
    }
}
