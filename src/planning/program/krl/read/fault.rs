//! A place in a line that cannot be read.

/// What is wrong with a line, and where in it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault {
    /// The column of its first character, from 1.
    pub column: usize,
    /// What is wrong, in words.
    pub message: String,
}

impl Fault {
    pub(super) fn new(column: usize, message: impl Into<String>) -> Self {
        Self { column, message: message.into() }
    }
}

/// Something of a line together with its column, from 1.
#[derive(Debug, Clone, PartialEq)]
pub struct At<T> {
    /// The column of its first character, from 1.
    pub column: usize,
    /// What stands there.
    pub value: T,
}
