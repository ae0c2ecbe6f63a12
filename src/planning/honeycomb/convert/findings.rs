//! What is found on the way, each kind named so often and counted from there on.

use std::collections::BTreeMap;

use crate::planning::finding::{Code, Finding, any_error};

/// So many findings of one kind are named. A program has as many lines as it likes.
const MOST_NAMED: usize = 20;

/// A kind of finding.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Kind {
    /// A motion, or something that decides over lines, that is not read.
    Unreadable,
    /// A line that is not read, and stands as it was.
    Untouched,
    /// A path below the blank.
    Below,
    /// A cut beside the blank.
    Beside,
    /// A cut that is not parallel to y.
    Diagonal,
    /// A cut that does not go from one side of the blank to the other.
    OneSided,
    /// A motion to joint angles, which stands as it was.
    Joints,
    /// A call of something else.
    Call,
    /// The ultrasonic's own output.
    Output,
}

/// The findings of a conversion.
pub(super) struct Findings<'a> {
    name: &'a str,
    list: Vec<Finding>,
    counts: BTreeMap<Kind, usize>,
}

impl<'a> Findings<'a> {
    pub(super) fn new(name: &'a str) -> Self {
        Self { name, list: Vec::new(), counts: BTreeMap::new() }
    }

    /// Something at a line that rules the conversion out.
    pub(super) fn error(
        &mut self,
        kind: Kind,
        code: Code,
        line: usize,
        column: Option<usize>,
        message: String,
    ) {
        let at = self.place(line, column);
        self.push(kind, Finding::error(code, at, message));
    }

    /// Something at a line at which a person should look.
    pub(super) fn warning(&mut self, kind: Kind, code: Code, line: usize, message: String) {
        let at = self.place(line, None);
        self.push(kind, Finding::warning(code, at, message));
    }

    /// Something about the program as a whole.
    pub(super) fn whole(&mut self, finding: impl FnOnce(&str) -> Finding) {
        let finding = finding(self.name);
        self.list.push(finding);
    }

    fn place(&self, line: usize, column: Option<usize>) -> String {
        column.map_or_else(
            || format!("{}:{line}", self.name),
            |column| format!("{}:{line}:{column}", self.name),
        )
    }

    /// Errors of a kind are all errors: leaving some out does not make a program usable.
    fn push(&mut self, kind: Kind, finding: Finding) {
        let count = self.counts.entry(kind).or_default();
        *count += 1;
        if *count <= MOST_NAMED {
            self.list.push(finding);
        } else if *count == MOST_NAMED + 1 {
            let message = format!("and more of the kind: {}", finding.message);
            self.list.push(Finding { message, ..finding });
        }
    }

    /// All findings, if none of them is an error.
    ///
    /// # Errors
    /// All findings, if one of them is.
    pub(super) fn finish(self) -> Result<Vec<Finding>, Vec<Finding>> {
        if any_error(&self.list) { Err(self.list) } else { Ok(self.list) }
    }
}
