//! One planning attempt: a job document and its files in, an outcome out. The same input gives the same bytes.

use super::budget::Budget;
use super::catalogue::Catalogue;
use super::document::files::Files;
use super::document::{JobDocument, JobInput};
use super::finding::Finding;
use super::honeycomb;
use super::outcome::{Outcome, ProgramFile, Sha256Text};
use super::tape;

/// Checks what can be checked without planning: what makes a POST a 422 and the command line exit 2.
///
/// `files` must be exactly those that the document names. What is in them is judged by [`plan`] (jobs.md).
///
/// # Errors
/// Every fault with its JSON pointer.
pub fn validate(document: &JobDocument, files: &Files, catalogue: &Catalogue) -> Result<(), Vec<Finding>> {
    let mut faults = files.faults(&document.named_files);
    let checked = match &document.input {
        JobInput::TapeCut(input) => tape::input::check(input, &input.all_plies(), catalogue).map(|_| ()),
        JobInput::HoneycombCut(input) => honeycomb::validate_cut(input, catalogue),
        JobInput::HoneycombOptimum(input) => honeycomb::input::check_optimum(input).map(|_| ()),
        JobInput::HoneycombConvert(input) => honeycomb::conversion::validate(input, catalogue),
    };
    faults.extend(checked.err().unwrap_or_default());
    if faults.is_empty() { Ok(()) } else { Err(faults) }
}

/// Plans a job.
///
/// # Errors
/// The faults of [`validate`] and those of the files' contents: the input is invalid and nothing was planned. A
/// valid input that has no usable program is an outcome with the verdict `not_usable`.
pub fn plan(
    document: &JobDocument,
    files: &Files,
    catalogue: &Catalogue,
    budget: &Budget<'_>,
) -> Result<Outcome, Vec<Finding>> {
    refuse_other_files(document, files, catalogue)?;
    let input_sha256 = fingerprint(document, files, catalogue);
    match &document.input {
        JobInput::TapeCut(input) => tape::plan(input, files, catalogue, &input_sha256, budget),
        JobInput::HoneycombCut(input) => honeycomb::plan_cut(input, files, catalogue, &input_sha256, budget),
        JobInput::HoneycombOptimum(input) => honeycomb::plan_optimum(input, &input_sha256, budget),
        JobInput::HoneycombConvert(input) => {
            honeycomb::conversion::plan(input, files, catalogue, &input_sha256, budget)
        }
    }
}

/// Reads a program back and replays it against its job: the figures in words, and every finding. `program` is its
/// files, the main one first.
///
/// # Errors
/// The faults of [`plan`]: the input is invalid and nothing was checked.
pub fn check(
    document: &JobDocument,
    files: &Files,
    catalogue: &Catalogue,
    program: &[ProgramFile],
    budget: &Budget<'_>,
) -> Result<(String, Vec<Finding>), Vec<Finding>> {
    refuse_other_files(document, files, catalogue)?;
    let input_sha256 = fingerprint(document, files, catalogue);
    match &document.input {
        JobInput::TapeCut(input) => {
            let (name, text) = program.first().map_or(("", ""), |main| (&main.name, &main.text));
            tape::check(input, files, catalogue, &input_sha256, name, text, budget)
        }
        JobInput::HoneycombCut(input) => {
            honeycomb::check_cut(input, files, catalogue, &input_sha256, program, budget)
        }
        JobInput::HoneycombOptimum(_) => Ok(("this kind of job has no program".to_owned(), Vec::new())),
        JobInput::HoneycombConvert(input) => {
            honeycomb::conversion::check(input, files, catalogue, &input_sha256, program, budget)
        }
    }
}

/// A document whose files are not all there, or not alone, is refused with all its faults.
fn refuse_other_files(
    document: &JobDocument,
    files: &Files,
    catalogue: &Catalogue,
) -> Result<(), Vec<Finding>> {
    if files.faults(&document.named_files).is_empty() {
        return Ok(());
    }
    validate(document, files, catalogue)
}

/// The SHA-256 of what decides the plan: the kind, the input, the files that it names, by name and content, and the
/// profile of a registered machine that it names, for that may change; not the name and the references of the job.
/// The input is one line of JSON and a listing begins with a hash, so that no two of these texts mean the same.
fn fingerprint(document: &JobDocument, files: &Files, catalogue: &Catalogue) -> String {
    let mut text = Sha256Text::default();
    serde_json::to_writer(&mut text, &document.input)
        .expect("a document holds numbers, texts, lists and fields");
    if let Some(profile) = document.input.named_machine().and_then(|name| catalogue.registered(name)) {
        text.add(&format!("\nmachine {}", profile.fingerprint()));
    }
    if !files.is_empty() {
        text.add("\n");
        text.add(&files.listing());
    }
    text.hex()
}

#[cfg(test)]
mod tests {
    use super::super::catalogue::Profile;
    use super::super::document::from_value;
    use super::super::finding::Code;
    use super::super::outcome::sha256_hex;
    use super::*;

    /// A ply whose outline is in a file, for a machine that is not there.
    fn document(name: &str) -> JobDocument {
        from_value(serde_json::json!({"kind": "tape-cut", "name": name, "input": {
            "tape": {"width_mm": 75, "thickness_mm": 0.125}, "boundary": {"file": "boundary.txt"},
            "tracks": {"file": "trace.txt"}, "machine": "nowhere"}}))
        .unwrap()
    }

    fn files(pairs: &[(&str, &str)]) -> Files {
        let mut files = Files::default();
        for (name, body) in pairs {
            files.insert((*name).to_owned(), body.as_bytes().to_vec()).unwrap();
        }
        files
    }

    fn found(faults: Vec<Finding>) -> Vec<(Code, String)> {
        faults.into_iter().map(|fault| (fault.code, fault.at)).collect()
    }

    #[test]
    fn the_fingerprint_covers_names_and_contents_and_nothing_for_people() {
        let both = files(&[("boundary.txt", "0 0 0"), ("trace.txt", "1")]);
        let first = fingerprint(&document("x"), &both, &Catalogue::built_in());
        assert_eq!(fingerprint(&document("y"), &both, &Catalogue::built_in()), first);
        let content = files(&[("boundary.txt", "0 0 1"), ("trace.txt", "1")]);
        let swapped = files(&[("boundary.txt", "1"), ("trace.txt", "0 0 0")]);
        let fewer = files(&[("boundary.txt", "0 0 0")]);
        for other in [content, swapped, fewer, Files::default()] {
            assert_ne!(fingerprint(&document("x"), &other, &Catalogue::built_in()), first, "{other:?}");
        }
    }

    #[test]
    fn a_document_without_files_keeps_the_fingerprint_that_it_always_had() {
        let document = document("x");
        let text = serde_json::to_vec(&document.input).unwrap();
        assert_eq!(fingerprint(&document, &Files::default(), &Catalogue::built_in()), sha256_hex(&text));
    }

    #[test]
    fn what_a_registered_name_stands_for_is_a_part_of_the_fingerprint_and_what_is_built_in_is_not() {
        let document = document("x");
        let print = |catalogue: &Catalogue| fingerprint(&document, &Files::default(), catalogue);
        let mut catalogue = Catalogue::built_in();
        let mut lab = tape::machine::two_cutter_lab();
        let mut registered = |lab: &tape::wire::MachineProfile| {
            catalogue.insert(Profile::TapeCutter(Box::new(lab.clone())));
            print(&catalogue)
        };
        let nothing = registered(&lab);
        assert_eq!(nothing, print(&Catalogue::built_in()), "the job names another machine");
        lab.name = "nowhere".to_owned();
        let first = registered(&lab);
        lab.feed.max_speed_mm_s = 100.0;
        let second = registered(&lab);
        assert!(nothing != first && first != second && second != nothing);
    }

    #[test]
    fn files_that_are_not_there_are_said_beside_every_other_fault() {
        let expected = [
            (Code::UnknownFile, "/input/tracks/file".to_owned()),
            (Code::UnusedFile, String::new()),
            (Code::UnknownMachine, "/input/machine".to_owned()),
        ];
        let (document, sent) = (document("x"), files(&[("boundary.txt", ""), ("notes.txt", "")]));
        let catalogue = Catalogue::built_in();
        assert_eq!(found(validate(&document, &sent, &catalogue).unwrap_err()), expected);
        let budget = Budget::unwatched();
        assert_eq!(found(plan(&document, &sent, &catalogue, &budget).unwrap_err()), expected);
        assert_eq!(found(check(&document, &sent, &catalogue, &[], &budget).unwrap_err()), expected);
    }
}
