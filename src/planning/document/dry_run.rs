//! The document of a dry run: the text of another job with one option set, and not a byte of it changed otherwise.
//!
//! A document may have a million points. It is not made into values and written again: the reader says where in the text
//! the option stands, or belongs.

use std::collections::BTreeMap;

use serde_json::value::RawValue;

/// The document of the dry run of a job. `text` is a document that was read before, of a kind that knows the option.
///
/// `None` if it is no object with an object `input`.
#[must_use]
pub fn as_dry_run(text: &[u8]) -> Option<Vec<u8>> {
    let input = *fields(text)?.get("input")?;
    let inner = fields(input.get().as_bytes())?;
    let Some(options) = inner.get("options") else {
        return Some(with_first(text, input, &inner, r#""options": {"dry_run": true}"#));
    };
    let known = fields(options.get().as_bytes())?;
    Some(match known.get("dry_run") {
        Some(value) => replaced(text, place(text, value), value.get().len(), "true"),
        None => with_first(text, options, &known, r#""dry_run": true"#),
    })
}

/// The fields of an object, each as it is written; of those of one name the last.
fn fields(object: &[u8]) -> Option<BTreeMap<String, &RawValue>> {
    serde_json::from_slice(object).ok()
}

/// Where in a text a part of it begins.
fn place(text: &[u8], part: &RawValue) -> usize {
    part.get().as_ptr().addr() - text.as_ptr().addr()
}

/// The text with other words at a place, instead of so many bytes.
fn replaced(text: &[u8], at: usize, bytes: usize, by: &str) -> Vec<u8> {
    [&text[..at], by.as_bytes(), &text[at + bytes..]].concat()
}

/// The text with a further field, as the first of an object that has these.
fn with_first(text: &[u8], object: &RawValue, has: &BTreeMap<String, &RawValue>, field: &str) -> Vec<u8> {
    let comma = if has.is_empty() { "" } else { ", " };
    // Behind its brace.
    replaced(text, place(text, object) + 1, 0, &format!("{field}{comma}"))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use serde_json::{Value, json};

    use super::*;

    fn dry(text: &str) -> Option<String> {
        as_dry_run(text.as_bytes()).map(|text| String::from_utf8(text).unwrap())
    }

    #[test]
    fn the_option_is_set_and_all_else_is_as_it_was() {
        let cases = [
            (r#"{"input": {"a": 1}}"#, r#"{"input": {"options": {"dry_run": true}, "a": 1}}"#),
            (r#"{"input":{"options":{},"a":1}}"#, r#"{"input":{"options":{"dry_run": true},"a":1}}"#),
            (
                r#"{"input": {"options": { "from_course" : 7 }}}"#,
                r#"{"input": {"options": {"dry_run": true,  "from_course" : 7 }}}"#,
            ),
            (
                "{\"name\": \"\\\"input\\\": {\", \"input\" :\n{\"options\":{\"dry_run\" : false }, \"x\": [{\"options\": 1}]} }",
                "{\"name\": \"\\\"input\\\": {\", \"input\" :\n{\"options\":{\"dry_run\" : true }, \"x\": [{\"options\": 1}]} }",
            ),
            (
                r#"{"\u0069nput": {"\u006fptions": {"dry\u005frun": true}}}"#,
                r#"{"\u0069nput": {"\u006fptions": {"dry\u005frun": true}}}"#,
            ),
            (
                r#"{"options": {"dry_run": false}, "input": {}}"#,
                r#"{"options": {"dry_run": false}, "input": {"options": {"dry_run": true}}}"#,
            ),
        ];
        for (text, expected) in cases {
            assert_eq!(dry(text).as_deref(), Some(expected));
        }
    }

    #[test]
    fn what_is_no_document_has_no_dry_run_and_does_no_harm() {
        let whole = r#"{"name": "a\\", "input": {"tape": [1, {"a": "}"}], "options": {"dry_run": false}}}"#;
        for end in 0..whole.len() {
            // A text cut off anywhere is passed over or given up, whatever comes of it.
            let _ = dry(&whole[..end]);
        }
        for text in
            ["", "[]", "7", "{}", r#"{"input": 7}"#, r#"{"input": {"options": 7}}"#, "{\"input\"}", "{]"]
        {
            assert_eq!(dry(text), None, "{text}");
        }
    }

    fn values() -> impl Strategy<Value = Value> {
        let leaf = prop_oneof![
            Just(Value::Null),
            any::<bool>().prop_map(Value::from),
            any::<i32>().prop_map(Value::from),
            (-1e9..1e9).prop_map(Value::from),
            "[\\PC\"\\\\{}\\[\\]:, ]{0,8}".prop_map(Value::from),
        ];
        leaf.prop_recursive(4, 40, 5, |inner| {
            let names = prop_oneof![
                Just("input".to_owned()),
                Just("options".to_owned()),
                Just("dry_run".to_owned()),
                "[\\PC\"\\\\]{0,4}"
            ];
            prop_oneof![
                prop::collection::vec(inner.clone(), 0..5).prop_map(Value::from),
                prop::collection::btree_map(names, inner, 0..5)
                    .prop_map(|fields| Value::Object(fields.into_iter().collect())),
            ]
        })
    }

    proptest! {
        #[test]
        fn any_document_is_read_as_before_but_for_the_option(
            outer in values(), inner in values(), options in prop::option::of(values()), pretty in any::<bool>()
        ) {
            let object = |value: Value| if value.is_object() { value } else { json!({"other": value}) };
            let (mut document, mut input) = (object(outer), object(inner));
            match options.map(object) {
                Some(options) => input["options"] = options,
                None => { input.as_object_mut().unwrap().remove("options"); }
            }
            document["input"] = input;
            let text =
                if pretty { serde_json::to_string_pretty(&document) } else { serde_json::to_string(&document) };
            let changed = as_dry_run(text.unwrap().as_bytes()).unwrap();
            document["input"]["options"]["dry_run"] = json!(true);
            prop_assert_eq!(serde_json::from_slice::<Value>(&changed).unwrap(), document);
        }
    }
}
