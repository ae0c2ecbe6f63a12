//! The findings of a replay, bounded in number.

use std::collections::BTreeMap;

use crate::planning::finding::{Code, Finding};

/// A program that is wrong throughout is wrong in each of a million lines; nobody reads more than this of a kind.
const MOST_OF_A_CODE: usize = 10;

/// Collects findings of severity error.
pub(super) struct Faults<'a> {
    program: &'a str,
    found: Vec<Finding>,
    counts: BTreeMap<Code, usize>,
}

impl<'a> Faults<'a> {
    /// None yet. `program` is its name.
    pub(super) fn new(program: &'a str) -> Self {
        Self { program, found: Vec::new(), counts: BTreeMap::new() }
    }

    /// A fault that a line of the program makes.
    pub(super) fn at_line(&mut self, code: Code, line: usize, message: impl FnOnce() -> String) {
        let at = format!("{}:{line}", self.program);
        self.add(code, at, message);
    }

    /// A fault of the program that no line of it makes.
    pub(super) fn at_program(&mut self, code: Code, message: impl FnOnce() -> String) {
        self.add(code, self.program.to_owned(), message);
    }

    fn add(&mut self, code: Code, at: String, message: impl FnOnce() -> String) {
        let count = self.counts.entry(code).or_default();
        *count += 1;
        if *count <= MOST_OF_A_CODE {
            self.found.push(Finding::error(code, at, message()));
        }
    }

    /// All findings; what was left out is counted.
    pub(super) fn finish(mut self) -> Vec<Finding> {
        for (code, count) in &self.counts {
            if let Some(more @ 1..) = count.checked_sub(MOST_OF_A_CODE) {
                let message = format!("{more} more of this kind are not listed");
                self.found.push(Finding::error(*code, self.program, message));
            }
        }
        self.found
    }
}
