//! The faults of one file: all of them counted, and the first so many listed.

use crate::planning::document::shape::MOST_FAULTS;
use crate::planning::finding::{Code, Finding};

/// A fault and the line at which it stands.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault {
    /// What it is.
    pub code: Code,
    /// The line, from 1.
    pub line: u32,
    /// What is wrong, in words.
    pub message: String,
}

impl Fault {
    /// A fault at a line.
    pub fn new(code: Code, line: u32, message: impl Into<String>) -> Self {
        Self { code, line, message: message.into() }
    }
}

/// The faults of one file.
#[derive(Debug)]
pub struct Faults<'a> {
    name: &'a str,
    listed: Vec<Finding>,
    more: usize,
    first_more: u32,
}

impl<'a> Faults<'a> {
    /// None yet, of the file of that name.
    #[must_use]
    pub fn of(name: &'a str) -> Self {
        Self { name, listed: Vec::new(), more: 0, first_more: 0 }
    }

    /// Adds one. From the hundred and first on they are only counted.
    pub fn push(&mut self, fault: Fault) {
        if self.listed.len() < MOST_FAULTS {
            let at = format!("{}:{}", self.name, fault.line);
            return self.listed.push(Finding::error(fault.code, at, fault.message));
        }
        if self.more == 0 {
            self.first_more = fault.line;
        }
        self.more += 1;
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.listed.is_empty()
    }

    /// The faults as findings at `NAME:LINE`; the last says how many more there are.
    #[must_use]
    pub fn into_findings(mut self) -> Vec<Finding> {
        if self.more > 0 {
            let message =
                format!("{} further faults are not listed, the first of them on this line", self.more);
            let at = format!("{}:{}", self.name, self.first_more);
            self.listed.push(Finding::error(Code::WrongCount, at, message));
        }
        self.listed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hundred_are_listed_and_the_others_counted() {
        let listed = |count: u32| {
            let mut faults = Faults::of("b.txt");
            (1..=count).for_each(|line| faults.push(Fault::new(Code::WrongType, line, "x")));
            faults.into_findings()
        };
        assert!(Faults::of("b.txt").is_empty() && listed(0).is_empty());
        assert_eq!((listed(100).len(), listed(100)[99].at.as_str()), (100, "b.txt:100"));
        let last = listed(107).pop().unwrap();
        assert_eq!((last.code, last.at.as_str()), (Code::WrongCount, "b.txt:101"));
        assert!(last.message.starts_with("7 further faults"), "{last}");
    }
}
