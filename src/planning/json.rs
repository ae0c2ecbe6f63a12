//! JSON that people can read too: objects a field a line, lists of numbers on one.

use std::io::{self, Write};

use serde::Serialize;
use serde_json::ser::{Formatter, Serializer};

/// Writes a value; the text ends without a line break.
///
/// # Panics
/// If the value cannot be written as JSON: a map with keys that are no texts.
#[must_use]
pub fn written(value: &impl Serialize) -> String {
    let mut text = Vec::new();
    let mut serializer = Serializer::with_formatter(&mut text, Lines { open: Vec::new() });
    value.serialize(&mut serializer).expect("it holds nothing but numbers, texts, lists and fields of them");
    String::from_utf8(text).expect("JSON is text")
}

/// What is open where something is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Open {
    /// An object; whether it has a field so far.
    Object { any: bool },
    /// A list; whether an object in it has made it go over lines.
    List { over_lines: bool },
}

/// Breaks a list into lines as soon as an object comes.
struct Lines {
    open: Vec<Open>,
}

impl Lines {
    fn new_line<W: ?Sized + Write>(&self, writer: &mut W) -> io::Result<()> {
        writer.write_all(b"\n")?;
        (0..self.open.len()).try_for_each(|_| writer.write_all(b"  "))
    }

    fn close<W: ?Sized + Write>(&mut self, writer: &mut W, bracket: &[u8]) -> io::Result<()> {
        if let Some(Open::Object { any: true } | Open::List { over_lines: true }) = self.open.pop() {
            self.new_line(writer)?;
        }
        writer.write_all(bracket)
    }
}

impl Formatter for Lines {
    fn begin_array<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.open.push(Open::List { over_lines: false });
        writer.write_all(b"[")
    }

    fn end_array<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.close(writer, b"]")
    }

    fn begin_array_value<W: ?Sized + Write>(&mut self, writer: &mut W, first: bool) -> io::Result<()> {
        writer.write_all(if first { b"" } else { b"," })
    }

    fn begin_object<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        if let Some(Open::List { over_lines }) = self.open.last_mut() {
            *over_lines = true;
            self.new_line(writer)?;
        }
        self.open.push(Open::Object { any: false });
        writer.write_all(b"{")
    }

    fn end_object<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.close(writer, b"}")
    }

    fn begin_object_key<W: ?Sized + Write>(&mut self, writer: &mut W, first: bool) -> io::Result<()> {
        if let Some(Open::Object { any }) = self.open.last_mut() {
            *any = true;
        }
        writer.write_all(if first { b"" } else { b"," })?;
        self.new_line(writer)
    }

    fn begin_object_value<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        writer.write_all(b": ")
    }
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use super::*;

    #[test]
    fn lists_of_numbers_stand_on_one_line_and_objects_do_not() {
        let value = json!({"a": [], "b": {}, "c": [[1, 2.5], [3, -4e-9]], "d": [{"e": "x\n", "f": [{}]}, {"g": null}]});
        let text = "{\n  \"a\": [],\n  \"b\": {},\n  \"c\": [[1,2.5],[3,-4e-9]],\n  \"d\": [\n    {\n      \"e\": \"x\\n\",\n      \
                    \"f\": [\n        {}\n      ]\n    },\n    {\n      \"g\": null\n    }\n  ]\n}";
        assert_eq!(written(&value), text);
        assert_eq!(serde_json::from_str::<Value>(text).unwrap(), value);
    }
}
