//! Where the points of an input stand that were read from files: findings then name a line, not a place in the job
//! document at which there is nothing.

use std::collections::{BTreeMap, BTreeSet};

use crate::planning::finding::Finding;
use crate::planning::tape::label::PlyPlace;

/// Where everything stands that is not in the job document itself.
#[derive(Debug, Clone, Default)]
pub struct Origins {
    /// By the JSON pointer of the outline.
    outlines: BTreeMap<String, Origin>,
    /// By the JSON pointer of the ply and the index of the course.
    tracks: BTreeMap<String, Vec<Origin>>,
    /// The JSON pointers of the plies whose courses were generated.
    generated: BTreeSet<String>,
}

/// Where an outline or a course stands in a file.
#[derive(Debug, Clone, Default)]
pub struct Origin {
    /// Name of the file.
    pub file: String,
    /// The line at which it begins.
    pub line: u32,
    /// The line of each of its points.
    pub lines: Vec<u32>,
}

impl Origins {
    /// Says that the courses of a ply come from a rule, whose place stands for theirs.
    pub fn generated(&mut self, ply: PlyPlace) {
        self.generated.insert(ply.to_string());
    }

    /// Whether the courses of a ply come from a rule.
    #[must_use]
    pub fn are_generated(&self, ply: PlyPlace) -> bool {
        self.generated.contains(&ply.to_string())
    }

    /// Says that an outline, by its JSON pointer, stands in a file.
    pub fn outline(&mut self, at: String, origin: Origin) {
        self.outlines.insert(at, origin);
    }

    /// Says that the courses of a ply stand in a file, in this order.
    pub fn tracks(&mut self, ply: PlyPlace, origins: Vec<Origin>) {
        self.tracks.insert(ply.to_string(), origins);
    }

    /// These and what is known of generated courses in `other`.
    #[must_use]
    pub fn with(mut self, other: &Self) -> Self {
        self.generated.extend(other.generated.iter().cloned());
        self
    }

    /// Puts the place in a file for each place that was read from one, in `at` and in the words.
    pub fn relocate(&self, findings: &mut [Finding]) {
        if self.outlines.is_empty() && self.tracks.is_empty() && self.generated.is_empty() {
            return;
        }
        for finding in findings {
            if let Some(place) = self.place(&finding.at) {
                finding.at = place;
            }
            finding.message = self.in_words(&finding.message);
        }
    }

    fn in_words(&self, message: &str) -> String {
        let (mut words, mut rest) = (String::with_capacity(message.len()), message);
        while let Some(start) = rest.find("/input/") {
            let (before, from) = rest.split_at(start);
            let ends = |c: char| !(c.is_ascii_alphanumeric() || c == '/' || c == '_');
            let (pointer, after) = from.split_at(from.find(ends).unwrap_or(from.len()));
            words.push_str(before);
            words.push_str(self.place(pointer).as_deref().unwrap_or(pointer));
            rest = after;
        }
        words + rest
    }

    fn place(&self, pointer: &str) -> Option<String> {
        let mut parts = pointer.strip_prefix("/input/")?.split('/');
        let (mut ply, mut field) = ("/input".to_owned(), parts.next()?);
        if field == "plies" {
            (ply, field) = (format!("/input/plies/{}", parts.next()?), parts.next()?);
        }
        match field {
            "boundary" => self.outlines.get(&format!("{ply}/boundary"))?.place(parts),
            "holes" => self.outlines.get(&format!("{ply}/holes/{}", parts.next()?))?.place(parts),
            "tracks" if self.generated.contains(&ply) => Some(format!("{ply}/courses")),
            "tracks" => self.tracks.get(&ply)?.get(parts.next()?.parse::<usize>().ok()?)?.place(parts),
            _ => None,
        }
    }
}

impl Origin {
    /// The place of what stands below an outline or a course in a job document.
    fn place<'a>(&self, mut parts: impl Iterator<Item = &'a str>) -> Option<String> {
        let line = match parts.next() {
            None | Some("number") => self.line,
            Some("points") => {
                let index = parts.next().and_then(|index| index.parse::<usize>().ok());
                index.and_then(|index| self.lines.get(index).copied()).unwrap_or(self.line)
            }
            Some(_) => return None,
        };
        Some(format!("{}:{line}", self.file))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planning::finding::Code;

    fn origin(file: &str, line: u32, lines: &[u32]) -> Origin {
        Origin { file: file.to_owned(), line, lines: lines.to_vec() }
    }

    #[test]
    fn places_in_files_take_the_place_of_pointers_and_others_stay() {
        let mut origins = Origins::default();
        origins.outline("/input/boundary".into(), origin("b.txt", 1, &[3, 4]));
        origins.outline("/input/holes/1".into(), origin("h.txt", 7, &[8]));
        origins.tracks(PlyPlace::default(), vec![origin("t.txt", 2, &[3, 5])]);
        origins.outline("/input/plies/1/boundary".into(), origin("p.txt", 1, &[30, 40]));
        origins.outline("/input/plies/1/holes/0".into(), origin("p.txt", 50, &[51]));
        origins.tracks(PlyPlace::listed(1, true), vec![origin("u.txt", 6, &[7])]);
        for (pointer, place) in [
            ("/input/boundary/points/1", "b.txt:4"),
            ("/input/boundary/points", "b.txt:1"),
            ("/input/boundary/points/99", "b.txt:1"),
            ("/input/holes/1/points/0", "h.txt:8"),
            ("/input/holes/0/points/0", "/input/holes/0/points/0"),
            ("/input/tracks/0/points/1/normal", "t.txt:5"),
            ("/input/tracks/0/number", "t.txt:2"),
            ("/input/tracks/0", "t.txt:2"),
            ("/input/tracks/4", "/input/tracks/4"),
            ("/input/tracks", "/input/tracks"),
            ("/input/boundary/layers", "/input/boundary/layers"),
            ("/input/plies/1/boundary/points/1", "p.txt:40"),
            ("/input/plies/1/holes/0/points", "p.txt:50"),
            ("/input/plies/1/tracks/0/points/0", "u.txt:7"),
            ("/input/plies/0/boundary/points/1", "/input/plies/0/boundary/points/1"),
            ("/input/plies/1", "/input/plies/1"),
            ("/input/plies", "/input/plies"),
            ("", ""),
        ] {
            let message = format!("see {pointer}, near");
            let mut findings = [Finding::info(Code::LeftOut, pointer, message)];
            origins.relocate(&mut findings);
            assert_eq!(findings[0].at, place);
            assert_eq!(findings[0].message, format!("see {place}, near"));
        }
    }

    #[test]
    fn a_generated_course_stands_at_its_rule() {
        let generated = |ply: PlyPlace| {
            let mut origins = Origins::default();
            origins.generated(ply);
            Origins::default().with(&origins)
        };
        let pointers = ["/input/tracks/3/points/1", "/input/plies/0/tracks/1", "/input/plies/1/tracks/1"];
        let mut findings = pointers.map(|at| Finding::info(Code::CourseOffPly, at, "x"));
        for ply in [PlyPlace::default(), PlyPlace::listed(1, true)] {
            generated(ply).relocate(&mut findings);
        }
        Origins::default().relocate(&mut findings);
        let places = findings.map(|finding| finding.at);
        assert_eq!(places, ["/input/courses", "/input/plies/0/tracks/1", "/input/plies/1/courses"]);
    }
}
