//! One planning attempt: a job document in, an outcome out. The same document gives the same bytes.

use super::budget::Budget;
use super::document::{JobDocument, JobInput};
use super::finding::Finding;
use super::outcome::{Outcome, sha256_hex};
use super::tape;
use super::tape::machine::Catalogue;

/// Checks what can be checked without planning: what makes a POST a 422 and the command line exit 2.
///
/// # Errors
/// Every fault with its JSON pointer.
pub fn validate(document: &JobDocument, catalogue: &Catalogue) -> Result<(), Vec<Finding>> {
    match &document.input {
        JobInput::TapeCut(input) => tape::input::check(input, catalogue).map(|_| ()),
    }
}

/// Plans a job.
///
/// # Errors
/// The faults of [`validate`]: the document is invalid and nothing was planned. A valid document that has no
/// usable program is an outcome with the verdict `not_usable`.
pub fn plan(
    document: &JobDocument,
    catalogue: &Catalogue,
    budget: &Budget<'_>,
) -> Result<Outcome, Vec<Finding>> {
    let input_sha256 = fingerprint(document);
    match &document.input {
        JobInput::TapeCut(input) => tape::plan(input, catalogue, &input_sha256, budget),
    }
}

/// Reads a program back and replays it against its job: the figures in words, and every finding.
///
/// # Errors
/// The faults of [`validate`]: the document is invalid and nothing was checked.
pub fn check(
    document: &JobDocument,
    catalogue: &Catalogue,
    name: &str,
    text: &str,
    budget: &Budget<'_>,
) -> Result<(String, Vec<Finding>), Vec<Finding>> {
    let input_sha256 = fingerprint(document);
    match &document.input {
        JobInput::TapeCut(input) => tape::check(input, catalogue, &input_sha256, name, text, budget),
    }
}

/// The SHA-256 of what decides the plan: the kind and the input, not the name and the references.
fn fingerprint(document: &JobDocument) -> String {
    let text = serde_json::to_vec(&document.input).unwrap_or_default();
    sha256_hex(&text)
}
