//! DXF as text: pairs of lines, a group code and its value, and the records that begin at each group 0.

use super::super::faults::Fault;
use crate::planning::document::shape::quoted;
use crate::planning::finding::Code;

/// A group code and its value.
#[derive(Debug, Clone, Copy)]
pub struct Pair<'a> {
    /// The group code.
    pub code: i32,
    /// The value, without blanks around it.
    pub value: &'a str,
    /// The line of the value.
    pub line: u32,
}

/// What begins at a group 0: its word, and the pairs up to the next.
#[derive(Debug, Clone)]
pub struct Record<'a> {
    /// `SECTION`, `ENDSEC`, `LINE`, ...
    pub kind: &'a str,
    /// The line of that word.
    pub line: u32,
    /// What follows.
    pub pairs: Vec<Pair<'a>>,
}

/// The records of a text, one after the other. After a fault there are no more: where pairs begin is then unknown.
pub struct Records<'a> {
    lines: std::str::Split<'a, char>,
    line: u32,
    /// The group 0 at which the next record begins.
    next: Option<Pair<'a>>,
    ended: bool,
}

/// Group of a comment.
const COMMENT: i32 = 999;

impl<'a> Records<'a> {
    /// The records of a text.
    #[must_use]
    pub fn of(text: &'a str) -> Self {
        Self { lines: text.split('\n'), line: 0, next: None, ended: false }
    }

    fn read(&mut self) -> Result<Option<Record<'a>>, Fault> {
        let Some(head) = self.next.take().map_or_else(|| self.pair(), |pair| Ok(Some(pair)))? else {
            return Ok(None);
        };
        if head.code != 0 {
            let message = format!("the file begins with group {}, not with a section", head.code);
            return Err(Fault::new(Code::UnreadableFile, head.line, message));
        }
        let mut record = Record { kind: head.value, line: head.line, pairs: Vec::new() };
        // What follows the end of the file is not looked at as pairs; it must be blank.
        while record.kind != "EOF"
            && let Some(pair) = self.pair()?
        {
            if pair.code == 0 {
                self.next = Some(pair);
                break;
            }
            record.pairs.push(pair);
        }
        Ok(Some(record))
    }

    /// The next pair that is no comment; `None` where only blank lines are left.
    fn pair(&mut self) -> Result<Option<Pair<'a>>, Fault> {
        loop {
            let Some(code) = self.code()? else { return Ok(None) };
            let Some(value) = self.lines.next() else {
                let message = format!("the file ends after group code {code}, before its value");
                return Err(Fault::new(Code::UnreadableFile, self.line, message));
            };
            self.line += 1;
            if code != COMMENT {
                return Ok(Some(Pair { code, value: value.trim(), line: self.line }));
            }
        }
    }

    fn code(&mut self) -> Result<Option<i32>, Fault> {
        let Some(line) = self.lines.next() else { return Ok(None) };
        self.line += 1;
        let word = line.trim();
        if word.is_empty() && self.lines.clone().all(|line| line.trim().is_empty()) {
            return Ok(None);
        }
        word.parse().map(Some).map_err(|_| {
            let message = format!("{} is no group code; the lines of a DXF file come in pairs", quoted(word));
            Fault::new(Code::UnreadableFile, self.line, message)
        })
    }

    /// The line of the first text that is left, if there is any.
    pub fn left_over(&mut self) -> Option<u32> {
        let first = self.lines.by_ref().position(|line| !line.trim().is_empty())?;
        Some(self.line + 1 + u32::try_from(first).unwrap_or(u32::MAX - self.line - 1))
    }
}

impl<'a> Iterator for Records<'a> {
    type Item = Result<Record<'a>, Fault>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.ended {
            return None;
        }
        let read = self.read().transpose();
        self.ended = !matches!(read, Some(Ok(_)));
        read
    }
}
