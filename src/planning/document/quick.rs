//! The straight way to read a large document: right into its types, without a tree of values in between.
//!
//! A ply of a million points is ten times as large as a tree as it is as text. What the tree is for, every fault
//! with its place, is wanted only where there is a fault. So a document is read into its types first; if that succeeds
//! and all its points are within their limits, the rest of it, without its points, is small, and is checked against its
//! shape. Whatever is not plainly right is left to the long way, which then says why.

use serde::Deserialize;
use serde_json::{Value, json};

use super::once::Texts;
use super::{JOB, JobDocument, JobInput};
use crate::planning::tape::wire::TapeCut;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TapeCutJob {
    kind: Kind,
    #[serde(default)]
    name: String,
    #[serde(default)]
    references: Texts,
    input: Box<TapeCut>,
}

/// The one kind of job that has documents of any size.
#[derive(Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Kind {
    TapeCut,
}

/// The document, if it is a tape-cut job without any fault of structure, type or number.
pub(super) fn read(text: &[u8]) -> Option<JobDocument> {
    // An optional field that is null is none to the types, and a fault to the shape.
    if text.windows(4).any(|word| word == b"null") {
        return None;
    }
    let TapeCutJob { kind: Kind::TapeCut, name, references: Texts(references), mut input } =
        serde_json::from_slice(text).ok()?;
    if !input.points_fit() {
        return None;
    }
    let points = input.take_points();
    let rest = json!({"kind": "tape-cut", "name": name, "references": references, "input": written(&input)?});
    input.put_points(points);
    if !JOB.faults(&rest, "").is_empty() {
        return None;
    }
    let named_files = JOB.named_files(&rest, "");
    Some(JobDocument { name, references, input: JobInput::TapeCut(input), named_files })
}

/// The input as a tree of values, without the fields that it does not have.
fn written(input: &TapeCut) -> Option<Value> {
    let mut value = serde_json::to_value(input).ok()?;
    leave_out_nulls(&mut value);
    Some(value)
}

fn leave_out_nulls(value: &mut Value) {
    match value {
        Value::Object(fields) => {
            fields.retain(|_, field| !field.is_null());
            fields.values_mut().for_each(leave_out_nulls);
        }
        Value::Array(items) => items.iter_mut().for_each(leave_out_nulls),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::super::{from_value, parse, read as read_document};
    use super::*;
    use crate::planning::finding::Code;

    fn document() -> Value {
        json!({"kind": "tape-cut", "name": "n", "references": {"part": "P"}, "input": {
            "tape": {"width_mm": 75, "thickness_mm": 0.125},
            "boundary": {"points": [[0, 0, 0], [100.5, 0, 0], [100, 50, 0]]}, "holes": [{"file": "hole.txt"}],
            "tracks": [{"number": 3, "points": [{"position": [0, 1, 0], "normal": [0, 0, 1]}]}, {"number": 4, "points": []}],
            "machine": "two-cutter-lab", "options": {"tolerance_mm": 0.02}}})
    }

    /// The ply of that document twice in a list.
    fn of_two_plies() -> Value {
        let mut value = document();
        let input = value["input"].as_object_mut().unwrap();
        let fields =
            ["boundary", "holes", "tracks"].map(|name| (name.to_owned(), input.remove(name).unwrap()));
        let ply = Value::Object(fields.into_iter().collect());
        input.insert("plies".to_owned(), json!([ply, ply]));
        value["input"]["plies"][1]["name"] = json!("second");
        value
    }

    #[test]
    fn a_document_without_fault_is_read_as_the_long_way_reads_it() {
        for value in [document(), of_two_plies()] {
            let quick = read(value.to_string().as_bytes()).unwrap();
            let long = from_value(value).unwrap();
            assert_eq!(serde_json::to_value(&quick).unwrap(), serde_json::to_value(&long).unwrap());
            assert_eq!(quick.named_files, long.named_files);
        }
    }

    #[test]
    fn whatever_has_a_fault_takes_the_long_way() {
        let changes: [(&str, Value); 15] = [
            ("/kind", json!("honeycomb-cut")),
            ("/name", json!("n".repeat(300))),
            ("/references/part", json!(7)),
            ("/input/tape/width_mm", json!(0)),
            ("/input/boundary/points/1/0", json!(1e9)),
            ("/input/boundary/points/1", json!([1, 2])),
            ("/input/holes/0/file", json!("../x")),
            ("/input/tracks", json!([])),
            ("/input/tracks", Value::Null),
            ("/input/tracks/0/number", json!(0)),
            ("/input/tracks/0/points/0/normal/2", json!(2e5)),
            ("/input/machine", json!(7)),
            ("/input/options", json!({"colour": 1})),
            ("/input/options/tolerance_mm", json!(0.0)),
            ("/input/options", json!({"from_ply": 0})),
        ];
        let of_plies: [(&str, Value); 6] = [
            ("/input/plies", json!([])),
            ("/input/plies/1/name", json!("n".repeat(65))),
            ("/input/plies/1/boundary/points/1/0", json!(1e9)),
            ("/input/plies/1/holes/0/file", json!("../x")),
            ("/input/plies/0/tracks", json!([])),
            ("/input/plies/1/tracks/0/points/0/position/2", json!(-2e5)),
        ];
        let changes = changes.into_iter().map(|change| (document(), change));
        let of_plies = of_plies.into_iter().map(|change| (of_two_plies(), change));
        for (mut value, (at, change)) in changes.chain(of_plies) {
            *value.pointer_mut(at).unwrap() = change;
            let text = value.to_string();
            assert!(read(text.as_bytes()).is_none(), "{at}");
            let fault = read_document(text.as_bytes()).unwrap_err().remove(0);
            assert!(
                at.starts_with(&fault.at) || fault.at.starts_with(at) || at == "/kind",
                "{at}: {fault:?}"
            );
        }
        let whole = document().to_string();
        for field in [
            "part",
            "kind",
            "width_mm",
            "points",
            "number",
            "position",
            "machine",
            "file",
            "tolerance_mm",
            "options",
        ] {
            let twice =
                whole.replacen(&format!("\"{field}\":"), &format!("\"{field}\":null,\"{field}\":"), 1);
            let again = whole.replacen(&format!("\"{field}\":"), &format!("\"{field}\":0,\"{field}\":"), 1);
            assert!(read(twice.as_bytes()).is_none() && read(again.as_bytes()).is_none(), "{field}");
            let fault = read_document(again.as_bytes()).unwrap_err().remove(0);
            assert_eq!(fault.code, Code::DuplicateField, "{field}: {fault:?}");
            assert!(fault.at.ends_with(&format!("/{field}")), "{fault:?}");
        }
        assert!(read(br#"{"kind": "tape-cut""#).is_none() && parse(b"{").is_err());
    }
}
