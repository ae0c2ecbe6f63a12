//! JSON into values, with no field twice. Of two fields of one name `serde_json` keeps the last and says nothing; a
//! person who reads the document may mean the first.

use std::collections::BTreeMap;
use std::fmt;

use serde::Deserialize;
use serde::de::{DeserializeSeed, Deserializer, Error, MapAccess, SeqAccess, Visitor};
use serde_json::{Map, Value};

/// What is said of a field that is there twice. The place is told by its path.
pub(super) const TWICE: &str = "this field is there twice; which of the two is meant is not known";

/// A value in which no field is there twice.
pub(super) struct Once(pub Value);

impl<'de> Deserialize<'de> for Once {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(AnyValue).map(Self)
    }
}

struct AnyValue;

impl<'de> Visitor<'de> for AnyValue {
    type Value = Value;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a JSON value")
    }

    fn visit_unit<E>(self) -> Result<Value, E> {
        Ok(Value::Null)
    }

    fn visit_bool<E>(self, flag: bool) -> Result<Value, E> {
        Ok(flag.into())
    }

    fn visit_i64<E>(self, number: i64) -> Result<Value, E> {
        Ok(number.into())
    }

    fn visit_u64<E>(self, number: u64) -> Result<Value, E> {
        Ok(number.into())
    }

    fn visit_f64<E>(self, number: f64) -> Result<Value, E> {
        Ok(number.into())
    }

    fn visit_str<E>(self, text: &str) -> Result<Value, E> {
        Ok(text.into())
    }

    fn visit_string<E>(self, text: String) -> Result<Value, E> {
        Ok(text.into())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Value, A::Error> {
        let mut list = Vec::new();
        while let Some(Once(item)) = items.next_element()? {
            list.push(item);
        }
        Ok(Value::Array(list))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut fields: A) -> Result<Value, A::Error> {
        let mut map = Map::new();
        while let Some(name) = fields.next_key::<String>()? {
            if map.contains_key(&name) {
                return fields.next_value_seed(Refusal);
            }
            let Once(value) = fields.next_value()?;
            map.insert(name, value);
        }
        Ok(Value::Object(map))
    }
}

/// A value that is refused unread, so that the error has the path of its field.
struct Refusal;

impl<'de> DeserializeSeed<'de> for Refusal {
    type Value = Value;

    fn deserialize<D: Deserializer<'de>>(self, _: D) -> Result<Value, D::Error> {
        Err(D::Error::custom(TWICE))
    }
}

/// Free names with a text each, none of them there twice.
#[derive(Default)]
pub(super) struct Texts(pub BTreeMap<String, String>);

impl<'de> Deserialize<'de> for Texts {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Pairs;

        impl<'de> Visitor<'de> for Pairs {
            type Value = Texts;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an object of texts")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut pairs: A) -> Result<Texts, A::Error> {
                let mut texts = BTreeMap::new();
                while let Some((name, text)) = pairs.next_entry()? {
                    if texts.insert(name, text).is_some() {
                        return Err(A::Error::custom(TWICE));
                    }
                }
                Ok(Texts(texts))
            }
        }

        deserializer.deserialize_map(Pairs)
    }
}

#[cfg(test)]
mod tests {
    use super::super::parse;
    use super::*;
    use crate::planning::finding::Code;

    #[test]
    fn what_has_no_field_twice_is_read_as_serde_json_reads_it() {
        let text = r#"{"a": [1, -2, 18446744073709551615, 0.1, 1e300, true, null, "x\u00e9\n"], "b": {"a": {}}, "": [[]]}"#;
        let value: Value = serde_json::from_str(text).unwrap();
        assert_eq!(parse(text.as_bytes()).unwrap(), value);
    }

    #[test]
    fn a_field_that_is_there_twice_is_refused_at_its_place() {
        let cases = [
            (r#"{"a": 1, "a": 1}"#, "/a"),
            (r#"{"a": [{"b": 1}, {"b": {"c/d": 1, "x": 2, "c\u002fd": {"y": 1, "y": 2}}}]}"#, "/a/1/b/c~1d"),
            (r#"{"": {"": 1, "": 2}}"#, "//"),
        ];
        for (text, at) in cases {
            let fault = parse(text.as_bytes()).unwrap_err();
            assert_eq!((fault.code, &*fault.at), (Code::DuplicateField, at), "{text}");
            assert!(fault.message.starts_with(TWICE), "{}", fault.message);
        }
    }
}
