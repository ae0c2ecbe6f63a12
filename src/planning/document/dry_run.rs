//! The document of a dry run: the text of another job with one option set, and not a byte of it changed otherwise.
//!
//! A document may have a million points. It is not made into values and written again: the text is walked once a level,
//! without recursion, up to the place of the option.

use std::ops::Range;

/// The document of the dry run of a job. `text` is a document that was read before, of a kind that knows the option.
///
/// `None` if it is no object with an object `input`.
#[must_use]
pub fn as_dry_run(text: &[u8]) -> Option<Vec<u8>> {
    let input = member(text, 0..text.len(), "input")?;
    let Some(options) = member(text, input.clone(), "options") else {
        return with_first(text, input, r#""options": {"dry_run": true}"#);
    };
    match member(text, options.clone(), "dry_run") {
        Some(value) => Some(replaced(text, value, "true")),
        None => with_first(text, options, r#""dry_run": true"#),
    }
}

fn replaced(text: &[u8], place: Range<usize>, by: &str) -> Vec<u8> {
    [&text[..place.start], by.as_bytes(), &text[place.end..]].concat()
}

/// The text with a further field, as the first of an object.
fn with_first(text: &[u8], object: Range<usize>, field: &str) -> Option<Vec<u8>> {
    let mut scanner = Scanner::inside(text, object)?;
    let place = scanner.at;
    scanner.pass_blanks();
    let comma = if scanner.here()? == b'}' { "" } else { ", " };
    Some(replaced(text, place..place, &format!("{field}{comma}")))
}

/// Where the value of a field stands in an object; of the last one of that name.
fn member(text: &[u8], object: Range<usize>, name: &str) -> Option<Range<usize>> {
    let mut scanner = Scanner::inside(text, object)?;
    let mut found = None;
    loop {
        scanner.pass_blanks();
        match scanner.here()? {
            b'}' => return found,
            b',' => scanner.at += 1,
            _ => {
                let key = scanner.value()?;
                scanner.pass_blanks();
                scanner.pass(b':')?;
                scanner.pass_blanks();
                let value = scanner.value()?;
                // A name may be written with escapes.
                if serde_json::from_slice::<String>(&text[key]).ok()? == name {
                    found = Some(value);
                }
            }
        }
    }
}

/// A place in a JSON text.
struct Scanner<'a> {
    text: &'a [u8],
    at: usize,
}

impl<'a> Scanner<'a> {
    /// Behind the brace with which the object in this part of a text begins.
    fn inside(text: &'a [u8], object: Range<usize>) -> Option<Self> {
        let mut scanner = Self { text: text.get(..object.end)?, at: object.start };
        scanner.pass_blanks();
        scanner.pass(b'{')?;
        Some(scanner)
    }

    fn here(&self) -> Option<u8> {
        self.text.get(self.at).copied()
    }

    fn pass(&mut self, byte: u8) -> Option<()> {
        (self.here()? == byte).then(|| self.at += 1)
    }

    fn pass_blanks(&mut self) {
        while self.here().is_some_and(|byte| byte.is_ascii_whitespace()) {
            self.at += 1;
        }
    }

    /// Passes a value.
    fn value(&mut self) -> Option<Range<usize>> {
        let start = self.at;
        let mut depth = 0_usize;
        loop {
            match self.here()? {
                b'"' => self.pass_text()?,
                b'{' | b'[' => {
                    depth += 1;
                    self.at += 1;
                }
                b'}' | b']' => {
                    depth = depth.checked_sub(1)?;
                    self.at += 1;
                }
                _ if depth > 0 => self.at += 1,
                _ => self.pass_word()?,
            }
            if depth == 0 {
                return Some(start..self.at);
            }
        }
    }

    fn pass_text(&mut self) -> Option<()> {
        self.at += 1;
        loop {
            match self.here()? {
                b'"' => {
                    self.at += 1;
                    return Some(());
                }
                b'\\' => self.at += 2,
                _ => self.at += 1,
            }
        }
    }

    /// Passes a number, `true`, `false` or `null`.
    fn pass_word(&mut self) -> Option<()> {
        let start = self.at;
        while self.here().is_some_and(|byte| byte.is_ascii_alphanumeric() || b"+-.".contains(&byte)) {
            self.at += 1;
        }
        (self.at > start).then_some(())
    }
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
