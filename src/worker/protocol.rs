//! What the service and the child that plans say to each other.
//!
//! To the child, on its standard input: one line with a JSON array of machine profiles, one line with the lengths of
//! what follows ([`Lengths`]), then the document byte for byte, then the files one after the other. From the child, on its standard output: one JSON message a line; the last one is `Answer`,
//! `Sound` or `Faults`. After an `Answer` follow the bytes of its parts, one after the other.

use serde::{Deserialize, Serialize};

use super::checking::Label;
use crate::planning::finding::Finding;

/// What the service sends to the child, and how long each is.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Lengths {
    /// The bytes of the document.
    pub document: u64,
    /// The files, in order.
    pub files: Vec<FileLength>,
}

/// A file that is sent.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct FileLength {
    /// Its name.
    pub name: String,
    /// Its bytes.
    pub bytes: u64,
}

/// A message of the child.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Message {
    /// A stage of the work begins.
    Stage {
        /// The stage.
        name: String,
        /// Seconds since the child began.
        at_s: f64,
    },
    /// The document is invalid.
    Faults(Vec<Finding>),
    /// The document was checked and has no faults.
    Sound(Label),
    /// The work is done; the parts follow.
    Answer {
        /// Seconds since the child began.
        at_s: f64,
        /// What follows, in order.
        parts: Vec<Part>,
    },
}

/// A part of an answer.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Part {
    /// What it is.
    pub role: Role,
    /// Its name.
    pub name: String,
    /// The language of a program file; empty for the others.
    pub dialect: String,
    /// Its length.
    pub bytes: u64,
}

/// What a part of an answer is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// `report.json`.
    Report,
    /// A drawing.
    Drawing,
    /// A file of the program.
    Program,
}

/// A part with its bytes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Delivered {
    /// The part.
    pub part: Part,
    /// Its bytes.
    pub body: Vec<u8>,
}
