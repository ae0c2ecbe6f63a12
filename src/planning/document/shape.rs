//! Shapes: what a JSON value must look like, as data.
//!
//! A shape is walked over a parsed value and every fault is reported at once with its JSON pointer; the same
//! shape is printed as a JSON Schema into the `OpenAPI` document. The typed reading that follows cannot fail on
//! a value that fits its shape.

use serde_json::{Map, Value, json};

use super::files::{LONGEST_NAME, NamedFile, PLAIN_NAME, plain};
use crate::planning::finding::{Code, Finding};

/// What a JSON value must look like.
pub enum Shape {
    /// An object with these fields and no others.
    Object(&'static [Field]),
    /// An object in which one field decides which fields the others are.
    Tagged {
        /// The deciding field.
        tag: &'static str,
        /// Its values, each with the fields of the whole object.
        variants: &'static [(&'static str, &'static [Field])],
    },
    /// An array.
    Array {
        /// The shape of each item.
        item: &'static Shape,
        /// The fewest items.
        min: usize,
        /// The most items.
        max: usize,
    },
    /// A finite number within closed limits.
    Number {
        /// The smallest value.
        min: f64,
        /// The largest value.
        max: f64,
    },
    /// A finite number above zero and up to a limit.
    Positive {
        /// The largest value.
        max: f64,
    },
    /// A whole number within closed limits.
    Integer {
        /// The smallest value.
        min: i64,
        /// The largest value.
        max: i64,
    },
    /// Text of at most so many characters.
    Text {
        /// The most characters.
        max_chars: usize,
    },
    /// Text of at most so many characters, none of which is a control character.
    Name {
        /// The most characters.
        max_chars: usize,
    },
    /// true or false.
    Boolean,
    /// One of these words.
    Word(&'static [&'static str]),
    /// An object whose fields are free names, each with a text of at most so many characters.
    Texts {
        /// The most fields.
        max: usize,
        /// The most characters of a name or a text.
        max_chars: usize,
    },
    /// Three finite numbers, each at most so large: a point or a direction.
    Triple {
        /// The largest absolute value.
        limit: f64,
    },
    /// Two finite numbers, each at most so large: a point of a section.
    Pair {
        /// The largest absolute value.
        limit: f64,
    },
    /// A text, or an object of this shape.
    TextOr {
        /// The most characters of the text.
        max_chars: usize,
        /// The shape otherwise.
        shape: &'static Shape,
    },
    /// The plain name of a file that came with the job.
    FileName,
    /// An array of this shape, or an object naming a file.
    ArrayOrFile(&'static Shape),
    /// An object of this shape, which has no field `file`, or an object naming a file.
    ObjectOrFile(&'static Shape),
}

/// The shape of an object that names a file: `{"file": "milling.src"}`.
pub const FILE: Shape = Shape::Object(FILE_FIELDS);

const FILE_FIELDS: &[Field] = &[required("file", Shape::FileName)];

/// A field of an object.
pub struct Field {
    /// Its name.
    pub name: &'static str,
    /// Whether it must be there.
    pub required: bool,
    /// What its value must look like.
    pub shape: Shape,
}

/// A field that must be there.
pub const fn required(name: &'static str, shape: Shape) -> Field {
    Field { name, required: true, shape }
}

/// A field that may be left out.
pub const fn optional(name: &'static str, shape: Shape) -> Field {
    Field { name, required: false, shape }
}

/// At most so many faults are listed; a document with more is not worth reading further.
pub const MOST_FAULTS: usize = 100;

/// A fault message quotes at most so many characters of what it found.
const MOST_QUOTED: usize = 40;

impl Shape {
    /// Every fault of `value` against this shape, each with its JSON pointer below `at`.
    #[must_use]
    pub fn faults(&self, value: &Value, at: &str) -> Vec<Finding> {
        let mut faults = Vec::new();
        self.visit(value, at, &mut faults);
        faults.truncate(MOST_FAULTS);
        faults
    }

    fn visit(&self, value: &Value, at: &str, faults: &mut Vec<Finding>) {
        if faults.len() >= MOST_FAULTS {
            return;
        }
        match self {
            Self::Object(fields) => visit_object(fields, value, at, faults),
            Self::Tagged { tag, variants } => visit_tagged(tag, variants, value, at, faults),
            Self::Array { item, min, max } => visit_array(item, *min, *max, value, at, faults),
            Self::Number { min, max } => visit_number(
                value,
                at,
                faults,
                |x| (*min..=*max).contains(&x),
                || format!("must lie between {min} and {max}"),
            ),
            Self::Positive { max } => visit_number(
                value,
                at,
                faults,
                |x| x > 0.0 && x <= *max,
                || format!("must be above 0 and at most {max}"),
            ),
            Self::Integer { min, max } => visit_integer(*min, *max, value, at, faults),
            Self::Text { max_chars } => visit_text(*max_chars, value, at, faults),
            Self::Name { max_chars } => visit_name(*max_chars, value, at, faults),
            Self::Boolean => expect(value.is_boolean(), "true or false", value, at, faults),
            Self::Word(words) => visit_word(words, value, at, faults),
            Self::Texts { max, max_chars } => visit_texts(*max, *max_chars, value, at, faults),
            Self::Triple { limit } => visit_numbers(&["x", "y", "z"], *limit, value, at, faults),
            Self::Pair { limit } => visit_numbers(&["x", "z"], *limit, value, at, faults),
            Self::TextOr { max_chars, shape } => match value {
                Value::String(_) => visit_text(*max_chars, value, at, faults),
                _ => shape.visit(value, at, faults),
            },
            Self::FileName => visit_file_name(value, at, faults),
            Self::ArrayOrFile(shape) => match value {
                Value::Object(_) => visit_object(FILE_FIELDS, value, at, faults),
                _ => shape.visit(value, at, faults),
            },
            Self::ObjectOrFile(_) if names_a_file(value) => FILE.visit(value, at, faults),
            Self::ObjectOrFile(shape) => shape.visit(value, at, faults),
        }
    }

    /// The files that a value of this shape names, each with its JSON pointer below `at`.
    #[must_use]
    pub fn named_files(&self, value: &Value, at: &str) -> Vec<NamedFile> {
        let mut named = Vec::new();
        self.collect(value, at, &mut named);
        named
    }

    fn collect(&self, value: &Value, at: &str, named: &mut Vec<NamedFile>) {
        match (self, value) {
            (Self::FileName, Value::String(name)) => {
                named.push(NamedFile { at: at.to_owned(), name: name.clone() });
            }
            (Self::Object(fields), Value::Object(map)) => collect_fields(fields, map, at, named),
            (Self::Tagged { tag, variants }, Value::Object(map)) => {
                let found = map.get(*tag).and_then(Value::as_str);
                let variant = variants.iter().find(|(word, _)| Some(*word) == found);
                collect_fields(variant.map_or(&[], |(_, fields)| fields), map, at, named);
            }
            (Self::Array { item, .. }, Value::Array(items)) if item.can_name_files() => {
                for (index, inner) in items.iter().enumerate() {
                    item.collect(inner, &format!("{at}/{index}"), named);
                }
            }
            (Self::TextOr { shape, .. }, Value::Object(_)) => shape.collect(value, at, named),
            (Self::ArrayOrFile(_), Value::Object(map)) => collect_fields(FILE_FIELDS, map, at, named),
            (Self::ArrayOrFile(shape), Value::Array(_)) => shape.collect(value, at, named),
            (Self::ObjectOrFile(_), Value::Object(_)) if names_a_file(value) => {
                FILE.collect(value, at, named);
            }
            (Self::ObjectOrFile(shape), Value::Object(_)) => shape.collect(value, at, named),
            _ => {}
        }
    }

    /// Whether any value of this shape names a file. Where none does, the values are not looked at: outlines have a
    /// million points.
    fn can_name_files(&self) -> bool {
        let any = |fields: &[Field]| fields.iter().any(|field| field.shape.can_name_files());
        match self {
            Self::FileName | Self::ArrayOrFile(_) | Self::ObjectOrFile(_) => true,
            Self::Object(fields) => any(fields),
            Self::Tagged { variants, .. } => variants.iter().any(|(_, fields)| any(fields)),
            Self::Array { item: shape, .. } | Self::TextOr { shape, .. } => shape.can_name_files(),
            _ => false,
        }
    }
}

fn names_a_file(value: &Value) -> bool {
    value.get("file").is_some()
}

fn collect_fields(fields: &[Field], map: &Map<String, Value>, at: &str, named: &mut Vec<NamedFile>) {
    for field in fields.iter().filter(|field| field.shape.can_name_files()) {
        if let Some(inner) = map.get(field.name) {
            field.shape.collect(inner, &pointer(at, field.name), named);
        }
    }
}

fn visit_file_name(value: &Value, at: &str, faults: &mut Vec<Finding>) {
    let Value::String(name) = value else {
        return expect(false, "the name of a file", value, at, faults);
    };
    if let Err(why) = plain(name) {
        let message = format!("{} is no name of a file: it {why}", quoted(name));
        faults.push(Finding::error(Code::UnknownFile, at, message));
    }
}

fn visit_object(fields: &[Field], value: &Value, at: &str, faults: &mut Vec<Finding>) {
    let Value::Object(map) = value else {
        return expect(false, "an object", value, at, faults);
    };
    for field in fields {
        match map.get(field.name) {
            Some(inner) => field.shape.visit(inner, &pointer(at, field.name), faults),
            None if field.required => faults.push(Finding::error(
                Code::MissingField,
                pointer(at, field.name),
                format!("the field {} must be there", field.name),
            )),
            None => {}
        }
    }
    report_unknown(fields, map, at, faults);
}

fn report_unknown(fields: &[Field], map: &Map<String, Value>, at: &str, faults: &mut Vec<Finding>) {
    for name in map.keys().filter(|name| fields.iter().all(|f| f.name != *name)) {
        let known: Vec<_> = fields.iter().map(|f| f.name).collect();
        faults.push(Finding::error(
            Code::UnknownField,
            pointer(at, name),
            format!("there is no field {}; known here: {}", quoted(name), known.join(", ")),
        ));
    }
}

fn visit_tagged(
    tag: &'static str,
    variants: &[(&'static str, &'static [Field])],
    value: &Value,
    at: &str,
    faults: &mut Vec<Finding>,
) {
    let Value::Object(map) = value else {
        return expect(false, "an object", value, at, faults);
    };
    let words: Vec<_> = variants.iter().map(|(word, _)| *word).collect();
    match map.get(tag) {
        None => faults.push(Finding::error(
            Code::MissingField,
            pointer(at, tag),
            format!("the field {tag} must be there, one of: {}", words.join(", ")),
        )),
        Some(Value::String(found)) => match variants.iter().find(|(word, _)| word == found) {
            Some((_, fields)) => visit_object(fields, value, at, faults),
            None => faults.push(unknown_word(&words, found, &pointer(at, tag))),
        },
        Some(other) => expect(false, "a text", other, &pointer(at, tag), faults),
    }
}

fn visit_array(item: &Shape, min: usize, max: usize, value: &Value, at: &str, faults: &mut Vec<Finding>) {
    let Value::Array(items) = value else {
        return expect(false, "an array", value, at, faults);
    };
    if !(min..=max).contains(&items.len()) {
        let message = format!("has {} items; {min} to {max} are allowed", items.len());
        faults.push(Finding::error(Code::WrongCount, at, message));
        return;
    }
    for (index, inner) in items.iter().enumerate() {
        // A pointer is only written out for an item with a fault: outlines have a million points.
        let before = faults.len();
        item.visit(inner, "", faults);
        for fault in &mut faults[before..] {
            fault.at = format!("{at}/{index}{}", fault.at);
        }
    }
}

fn visit_number(
    value: &Value,
    at: &str,
    faults: &mut Vec<Finding>,
    fits: impl Fn(f64) -> bool,
    limit: impl Fn() -> String,
) {
    match value.as_f64() {
        Some(number) if fits(number) => {}
        Some(number) => {
            faults.push(Finding::error(Code::OutOfRange, at, format!("is {number}; it {}", limit())))
        }
        None => expect(false, "a number", value, at, faults),
    }
}

fn visit_integer(min: i64, max: i64, value: &Value, at: &str, faults: &mut Vec<Finding>) {
    match value.as_i64() {
        Some(number) if (min..=max).contains(&number) => {}
        Some(number) => {
            let message = format!("is {number}; it must lie between {min} and {max}");
            faults.push(Finding::error(Code::OutOfRange, at, message));
        }
        None => expect(false, "a whole number", value, at, faults),
    }
}

fn visit_text(max_chars: usize, value: &Value, at: &str, faults: &mut Vec<Finding>) {
    let Value::String(text) = value else {
        return expect(false, "a text", value, at, faults);
    };
    let length = text.chars().count();
    if length > max_chars {
        let message = format!("has {length} characters; at most {max_chars} are allowed");
        faults.push(Finding::error(Code::WrongCount, at, message));
    }
}

fn visit_name(max_chars: usize, value: &Value, at: &str, faults: &mut Vec<Finding>) {
    visit_text(max_chars, value, at, faults);
    if value.as_str().is_some_and(|name| name.chars().any(char::is_control)) {
        faults.push(Finding::error(
            Code::UnknownValue,
            at,
            "has control characters; a name is plain text in a line",
        ));
    }
}

fn visit_word(words: &[&str], value: &Value, at: &str, faults: &mut Vec<Finding>) {
    match value {
        Value::String(found) if words.contains(&found.as_str()) => {}
        Value::String(found) => faults.push(unknown_word(words, found, at)),
        _ => expect(false, "a text", value, at, faults),
    }
}

fn visit_texts(max: usize, max_chars: usize, value: &Value, at: &str, faults: &mut Vec<Finding>) {
    let Value::Object(map) = value else {
        return expect(false, "an object", value, at, faults);
    };
    if map.len() > max {
        let message = format!("has {} fields; at most {max} are allowed", map.len());
        faults.push(Finding::error(Code::WrongCount, at, message));
    }
    for (name, text) in map {
        visit_text(max_chars, &Value::String(name.clone()), &pointer(at, name), faults);
        visit_text(max_chars, text, &pointer(at, name), faults);
    }
}

/// A point: as many numbers as it has coordinates.
fn visit_numbers(names: &[&str], limit: f64, value: &Value, at: &str, faults: &mut Vec<Finding>) {
    let count = names.len();
    let Value::Array(items) = value else {
        return expect(false, &format!("an array of {count} numbers"), value, at, faults);
    };
    if items.len() != count {
        let message = format!("has {} numbers; a point has {count} here: {}", items.len(), names.join(", "));
        return faults.push(Finding::error(Code::WrongCount, at, message));
    }
    for (index, item) in items.iter().enumerate() {
        if !item.as_f64().is_some_and(|x| x.abs() <= limit) {
            Shape::Number { min: -limit, max: limit }.visit(item, &format!("{at}/{index}"), faults);
        }
    }
}

fn expect(fits: bool, wanted: &str, value: &Value, at: &str, faults: &mut Vec<Finding>) {
    if fits {
        return;
    }
    let found = match value {
        Value::Null => "null".to_owned(),
        Value::Bool(flag) => flag.to_string(),
        Value::Number(number) => format!("the number {number}"),
        Value::String(text) => format!("the text {}", quoted(text)),
        Value::Array(_) => "an array".to_owned(),
        Value::Object(_) => "an object".to_owned(),
    };
    faults.push(Finding::error(Code::WrongType, at, format!("must be {wanted}, not {found}")));
}

fn unknown_word(words: &[&str], found: &str, at: &str) -> Finding {
    Finding::error(
        Code::UnknownValue,
        at,
        format!("{} is not known; one of: {}", quoted(found), words.join(", ")),
    )
}

/// A text from outside, made safe and short enough to be quoted in a message.
pub fn quoted(text: &str) -> String {
    let mut short: String = text.chars().take(MOST_QUOTED).collect();
    if short.len() < text.len() {
        short.push_str("...");
    }
    format!("{short:?}")
}

/// The JSON pointer (RFC 6901) of a field below `at`.
#[must_use]
pub fn pointer(at: &str, name: &str) -> String {
    format!("{at}/{}", name.replace('~', "~0").replace('/', "~1"))
}

impl Shape {
    /// This shape as a JSON Schema (draft 2020-12, as `OpenAPI` 3.1 has it).
    #[must_use]
    pub fn schema(&self) -> Value {
        match self {
            Self::Object(fields) => object_schema(fields),
            Self::Tagged { tag, variants } => json!({"oneOf": variants.iter().map(|(word, fields)| {
                let mut schema = object_schema(fields);
                schema["properties"][*tag] = json!({"const": word});
                schema["title"] = json!(word);
                schema
            }).collect::<Vec<_>>()}),
            Self::Array { item, min, max } => {
                json!({"type": "array", "items": item.schema(), "minItems": min, "maxItems": max})
            }
            Self::Number { min, max } => json!({"type": "number", "minimum": min, "maximum": max}),
            Self::Positive { max } => json!({"type": "number", "exclusiveMinimum": 0, "maximum": max}),
            Self::Integer { min, max } => json!({"type": "integer", "minimum": min, "maximum": max}),
            Self::Text { max_chars } => json!({"type": "string", "maxLength": max_chars}),
            Self::Name { max_chars } => {
                json!({"type": "string", "maxLength": max_chars, "pattern": "^\\P{Cc}*$"})
            }
            Self::Boolean => json!({"type": "boolean"}),
            Self::Word(words) => json!({"type": "string", "enum": words}),
            Self::Texts { max, max_chars } => json!({"type": "object", "maxProperties": max,
                "additionalProperties": {"type": "string", "maxLength": max_chars}}),
            Self::Triple { limit } => numbers_schema(3, *limit),
            Self::Pair { limit } => numbers_schema(2, *limit),
            Self::TextOr { max_chars, shape } => {
                json!({"oneOf": [{"type": "string", "maxLength": max_chars}, shape.schema()]})
            }
            Self::FileName => json!({"type": "string", "minLength": 1, "maxLength": LONGEST_NAME,
                "pattern": PLAIN_NAME}),
            Self::ArrayOrFile(shape) | Self::ObjectOrFile(shape) => {
                json!({"oneOf": [shape.schema(), FILE.schema()]})
            }
        }
    }
}

fn numbers_schema(count: usize, limit: f64) -> Value {
    json!({"type": "array", "minItems": count, "maxItems": count,
        "items": {"type": "number", "minimum": -limit, "maximum": limit}})
}

fn object_schema(fields: &[Field]) -> Value {
    let properties: Map<_, _> = fields.iter().map(|f| (f.name.to_owned(), f.shape.schema())).collect();
    let required: Vec<_> = fields.iter().filter(|f| f.required).map(|f| f.name).collect();
    json!({"type": "object", "additionalProperties": false, "properties": properties, "required": required})
}

#[cfg(test)]
mod tests {
    use super::*;

    const POINT: Shape = Shape::Triple { limit: 1.0 };
    const LOOP: Shape = Shape::Object(&[
        optional("points", Shape::Array { item: &POINT, min: 0, max: 9 }),
        optional("file", Shape::FileName),
    ]);
    const ARM_OR_FILE: Shape =
        Shape::ObjectOrFile(&Shape::Object(&[required("reach", Shape::Positive { max: 9.0 })]));
    const FIELDS: &[Field] = &[
        required("kind", Shape::Word(&["a"])),
        optional("loops/all", Shape::Array { item: &LOOP, min: 0, max: 9 }),
        optional("tracks", Shape::ArrayOrFile(&Shape::Array { item: &LOOP, min: 0, max: 9 })),
        optional("krl", FILE),
        optional("profile", Shape::TextOr { max_chars: 9, shape: &FILE }),
        optional("robot", Shape::TextOr { max_chars: 9, shape: &ARM_OR_FILE }),
        optional("label", Shape::Text { max_chars: 9 }),
        optional("notes", Shape::Texts { max: 9, max_chars: 9 }),
    ];
    const DOCUMENT: Shape = Shape::Tagged { tag: "kind", variants: &[("a", FIELDS)] };

    fn named(value: &Value) -> Vec<(String, String)> {
        assert_eq!(DOCUMENT.faults(value, "").len(), 0, "{value}");
        DOCUMENT.named_files(value, "").into_iter().map(|file| (file.at, file.name)).collect()
    }

    #[test]
    fn every_place_that_names_a_file_is_found_and_no_other() {
        let found = named(&json!({
            "kind": "a",
            "loops/all": [{"points": [[0, 0, 0]]}, {"file": "one"}, {"file": "two"}],
            "tracks": {"file": "three"}, "krl": {"file": "four"}, "profile": {"file": "five"},
            "label": "six", "notes": {"file": "seven"}
        }));
        let expected = [
            ("/loops~1all/1/file", "one"),
            ("/loops~1all/2/file", "two"),
            ("/tracks/file", "three"),
            ("/krl/file", "four"),
            ("/profile/file", "five"),
        ];
        assert_eq!(found, expected.map(|(at, name)| (at.to_owned(), name.to_owned())));
        let listed = json!({"kind": "a", "tracks": [{"file": "in a list"}], "profile": "built-in"});
        assert_eq!(named(&listed), [("/tracks/0/file".to_owned(), "in a list".to_owned())]);
        assert_eq!(named(&json!({"kind": "a"})), []);
    }

    #[test]
    fn an_object_that_may_stand_in_a_file_is_one_of_the_two() {
        let at = |robot: Value| -> Vec<(Code, String)> {
            let faults = DOCUMENT.faults(&json!({"kind": "a", "robot": robot}), "");
            faults.into_iter().map(|fault| (fault.code, fault.at)).collect()
        };
        assert_eq!(named(&json!({"kind": "a", "robot": {"reach": 3}})), []);
        let file = json!({"kind": "a", "robot": {"file": "arm.json"}});
        assert_eq!(named(&file), [("/robot/file".to_owned(), "arm.json".to_owned())]);
        assert_eq!(at(json!({"reach": 0})), [(Code::OutOfRange, "/robot/reach".to_owned())]);
        assert_eq!(at(json!({})), [(Code::MissingField, "/robot/reach".to_owned())]);
        let both = json!({"reach": 3, "file": "arm.json"});
        assert_eq!(at(both), [(Code::UnknownField, "/robot/reach".to_owned())]);
        assert_eq!(at(json!({"file": "../arm.json"})), [(Code::UnknownFile, "/robot/file".to_owned())]);
        assert_eq!(at(json!({"file": null})), [(Code::WrongType, "/robot/file".to_owned())]);
        assert_eq!(at(json!([])), [(Code::WrongType, "/robot".to_owned())]);
    }

    #[test]
    fn a_name_that_is_not_plain_is_a_fault_at_its_place() {
        let faults = |name: Value| DOCUMENT.faults(&json!({"kind": "a", "krl": {"file": name}}), "");
        for name in ["../x", "", "a/b", ".x"] {
            let found = faults(json!(name));
            assert_eq!(
                (found.len(), found[0].code, &*found[0].at),
                (1, Code::UnknownFile, "/krl/file"),
                "{name}"
            );
        }
        assert_eq!(faults(json!(5))[0].code, Code::WrongType);
        assert_eq!(faults(json!("milling.src")), []);
    }
}
