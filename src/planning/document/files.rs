//! The files of a job: what was sent with its document, or lies beside it.
//!
//! A document names a file as `{"file": "boundary.txt"}`. The name is plain: it leads nowhere, and a name from
//! outside is compared with the names of [`Files`], never made into a path. Which fields name files the shape of
//! the document knows ([`super::shape::Shape::named_files`]).

use std::collections::BTreeMap;
use std::fmt::Write;

use serde::{Deserialize, Serialize};

use super::shape::{MOST_FAULTS, quoted};
use crate::planning::finding::{Code, Finding};
use crate::planning::outcome::sha256_hex;

/// The most files of one job: far more than the trace, the outline and the cut-outs of a ply, or than the
/// sub-programs of a core, and few enough to be listed.
pub const MOST_FILES: usize = 256;

/// The most bytes of all files of a job together: the largest body that the service can be set to take (1 GiB).
pub const MOST_BYTES: usize = 1024 * 1024 * 1024;

/// The longest name, in characters: what file systems hold.
pub const LONGEST_NAME: usize = 255;

/// The rule of [`plain`] as a regular expression, for the `OpenAPI` document.
pub const PLAIN_NAME: &str = "^[A-Za-z0-9_-]([A-Za-z0-9._ -]*[A-Za-z0-9._-])?$";

/// A field that names a file, as it stands in JSON.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FileReference {
    /// The name of an uploaded file or of one beside the job.
    pub file: String,
}

/// A file that a document names, and where.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NamedFile {
    /// JSON pointer of the name.
    pub at: String,
    /// The name.
    pub name: String,
}

/// The files of a job by their names. They are bounded, and none is there twice.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Files {
    by_name: BTreeMap<String, Vec<u8>>,
    bytes: usize,
}

/// Why a file does not join the others.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Refusal {
    /// Its name is not plain.
    #[error("{0} is no name of a file: it {1}")]
    Name(String, &'static str),
    /// Another one has its name.
    #[error("two files are named {0}")]
    Twice(String),
    /// There are as many as there may be.
    #[error("there are more than {MOST_FILES} files")]
    TooMany,
    /// All together would be too large.
    #[error("all files together have more than {MOST_BYTES} bytes")]
    TooLarge,
}

impl Refusal {
    /// The refusal as a fault of what was sent as a whole: the document has no place for it.
    #[must_use]
    pub fn finding(&self) -> Finding {
        let code = match self {
            Self::Name(..) | Self::Twice(_) => Code::UnknownFile,
            Self::TooMany => Code::WrongCount,
            Self::TooLarge => Code::OutOfRange,
        };
        Finding::error(code, "", self.to_string())
    }
}

impl Files {
    /// Adds a file.
    ///
    /// # Errors
    /// The name is not plain or there already, or a limit is reached; the files are as they were then.
    pub fn insert(&mut self, name: String, body: Vec<u8>) -> Result<(), Refusal> {
        plain(&name).map_err(|why| Refusal::Name(quoted(&name), why))?;
        if self.by_name.contains_key(&name) {
            return Err(Refusal::Twice(quoted(&name)));
        }
        if self.by_name.len() >= MOST_FILES {
            return Err(Refusal::TooMany);
        }
        if body.len() > MOST_BYTES - self.bytes {
            return Err(Refusal::TooLarge);
        }
        self.bytes += body.len();
        self.by_name.insert(name, body);
        Ok(())
    }

    /// The bytes of the file of that name.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<&[u8]> {
        self.by_name.get(name).map(Vec::as_slice)
    }

    /// Names and bytes, in the order of the names.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = (&str, &[u8])> {
        self.by_name.iter().map(|(name, body)| (name.as_str(), body.as_slice()))
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.by_name.is_empty()
    }

    /// How many bytes all of them have together.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.bytes
    }

    /// One line for each file, its SHA-256 and its name, in the order of the names: two sets of files have the same
    /// listing only if they have the same names and contents.
    #[must_use]
    pub fn listing(&self) -> String {
        self.iter().fold(String::new(), |mut lines, (name, body)| {
            // Writing to a String cannot fail.
            let _ = writeln!(lines, "{}  {name}", sha256_hex(body));
            lines
        })
    }

    /// Whether these are the files that a document names: every fault, each at its place, at most 100 of a kind.
    #[must_use]
    pub fn faults(&self, named: &[NamedFile]) -> Vec<Finding> {
        let missing = named.iter().filter(|file| self.get(&file.name).is_none()).map(not_sent);
        let unused =
            self.iter().map(|(name, _)| name).filter(|name| named.iter().all(|file| file.name != *name));
        missing.take(MOST_FAULTS).chain(unused.map(not_named).take(MOST_FAULTS)).collect()
    }
}

fn not_sent(file: &NamedFile) -> Finding {
    let name = quoted(&file.name);
    let message = format!("no file {name} came with the job; post it as a part of multipart/form-data");
    Finding::error(Code::UnknownFile, file.at.as_str(), message)
}

fn not_named(name: &str) -> Finding {
    let message =
        format!("the file {} came with the job, and no field of the document names it", quoted(name));
    Finding::error(Code::UnusedFile, "", message)
}

/// Refuses a name that is not plain: 1 to 255 of the characters `A-Z`, `a-z`, `0-9`, `.`, `_` and `-`, with spaces
/// inside, and no dot in front.
///
/// # Errors
/// What is wrong with it, to be read after "it".
pub fn plain(name: &str) -> Result<(), &'static str> {
    let fits = |byte: u8| byte.is_ascii_alphanumeric() || b"._- ".contains(&byte);
    if name.is_empty() {
        return Err("is empty");
    }
    if !name.bytes().all(fits) {
        return Err("has characters other than letters a to z, digits, '.', '_', '-' and spaces; \
                    it is a plain name without a path");
    }
    if name.len() > LONGEST_NAME {
        return Err("has more than 255 characters");
    }
    if name.starts_with('.') {
        return Err("begins with a dot");
    }
    if name.starts_with(' ') || name.ends_with(' ') {
        return Err("begins or ends with a space");
    }
    Ok(())
}

/// What is said of a line that is no point and in which a comma stands between two digits; nothing of others.
#[must_use]
pub fn comma_hint(content: &str) -> &'static str {
    let digits = |three: &[u8]| matches!(three, [a, b',', b] if a.is_ascii_digit() && b.is_ascii_digit());
    if content.as_bytes().windows(3).any(digits) {
        " (a comma separates numbers; decimals are written with a point, 1.5)"
    } else {
        ""
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn files(pairs: &[(&str, &str)]) -> Files {
        let mut files = Files::default();
        for (name, body) in pairs {
            files.insert((*name).to_owned(), body.as_bytes().to_vec()).unwrap();
        }
        files
    }

    fn named(at: &str, name: &str) -> NamedFile {
        NamedFile { at: at.to_owned(), name: name.to_owned() }
    }

    #[test]
    fn plain_names_are_taken_and_others_never() {
        let longest = "n".repeat(LONGEST_NAME);
        for name in ["boundary.txt", "Ply 12_rev-C.DXF", "a", "-", "_x", "a..b", "x.", &longest] {
            assert_eq!(plain(name), Ok(()), "{name:?}");
        }
        let too_long = "n".repeat(LONGEST_NAME + 1);
        let hostile = [
            "",
            ".",
            "..",
            ".hidden",
            "../x",
            "a/b",
            "/etc/passwd",
            "a\\b",
            "C:\\x",
            "C:x",
            "a\0b",
            "a\nb",
            "a\u{7f}",
            " a",
            "a ",
            " ",
            "\t",
            "b\u{e4}r.txt",
            "\u{202e}txt.exe",
            "a%2Fb",
            "a\"b",
            "a;b",
            "a'b",
            "~",
            "a*",
            &too_long,
        ];
        for name in hostile {
            assert!(plain(name).is_err(), "{name:?}");
            let refusal = Files::default().insert(name.to_owned(), vec![]).unwrap_err();
            assert!(matches!(refusal, Refusal::Name(..)), "{name:?}");
            assert!(!refusal.to_string().contains(|c: char| c.is_control() || c == '\u{202e}'), "{refusal}");
        }
    }

    #[test]
    fn the_pattern_of_the_document_says_what_may_stand_first_and_last() {
        // First: no dot, no space. Last: no space. The one character of a short name is both.
        let first = |c: char| c.is_ascii_alphanumeric() || "_-".contains(c);
        let last = |c: char| first(c) || c == '.';
        for name in
            (0_u8..128).map(char::from).flat_map(|c| [format!("{c}"), format!("{c}b"), format!("b{c}")])
        {
            let fits = name.starts_with(first) && name.ends_with(last);
            assert_eq!(plain(&name).is_ok(), fits, "{name:?}");
        }
    }

    #[test]
    fn no_name_twice_and_no_more_than_the_limits() {
        let mut files = files(&[("a", "1")]);
        assert_eq!(files.insert("a".into(), b"2".to_vec()), Err(Refusal::Twice("\"a\"".into())));
        assert_eq!(files.get("a"), Some(b"1".as_slice()));
        for number in 1..MOST_FILES {
            files.insert(format!("f{number}"), vec![]).unwrap();
        }
        assert_eq!(files.insert("one-more".into(), vec![]), Err(Refusal::TooMany));
        let mut full = Files { bytes: MOST_BYTES - 1, ..Files::default() };
        assert_eq!(full.insert("a".into(), vec![0, 0]), Err(Refusal::TooLarge));
        assert_eq!(full.insert("a".into(), vec![0]), Ok(()));
        assert_eq!(full.bytes(), MOST_BYTES);
    }

    #[test]
    fn a_listing_tells_sets_of_files_apart() {
        let listing = |pairs: &[(&str, &str)]| files(pairs).listing();
        assert_eq!(listing(&[]), "");
        assert_eq!(listing(&[("a", "1"), ("b", "2")]), listing(&[("b", "2"), ("a", "1")]));
        for other in [
            &[("a", "2"), ("b", "1")][..],
            &[("a", "1")],
            &[("a", "1"), ("c", "2")],
            &[("a", "1"), ("b", "2"), ("c", "")],
        ] {
            assert_ne!(listing(&[("a", "1"), ("b", "2")]), listing(other), "{other:?}");
        }
    }

    #[test]
    fn what_is_named_and_not_there_and_what_is_there_and_not_named_are_faults() {
        let sent = files(&[("a", ""), ("b", "")]);
        let found = |named: &[NamedFile]| -> Vec<(Code, String)> {
            sent.faults(named).into_iter().map(|fault| (fault.code, fault.at)).collect()
        };
        assert_eq!(found(&[named("/x", "a"), named("/y", "b"), named("/z", "a")]), []);
        let twice = found(&[named("/x", "c"), named("/y", "c")]);
        let expected = [
            (Code::UnknownFile, "/x"),
            (Code::UnknownFile, "/y"),
            (Code::UnusedFile, ""),
            (Code::UnusedFile, ""),
        ];
        assert_eq!(twice, expected.map(|(code, at)| (code, at.to_owned())));
        let many: Vec<_> = (0..1000).map(|number| named("/x", &format!("f{number}"))).collect();
        assert_eq!(found(&many).len(), MOST_FAULTS + 2, "a document may name many files");
    }
}
