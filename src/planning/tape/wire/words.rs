//! The words of a profile for a control that switches knives by words of its builder's own.

use serde::{Deserialize, Serialize};

use crate::planning::document::shape::{Shape, optional, required};

/// The words by which a control switches what the machine has.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Words {
    /// Of each cutter's knife, in the order of the cutters.
    pub knives: Vec<KnifeWords>,
    /// Of the knives' generator.
    pub ultrasonic: UltrasonicWords,
    /// The stop that the operator can switch on; M1 if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub optional_stop: Option<String>,
}

/// The words of a knife.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KnifeWords {
    /// It goes down.
    pub down: String,
    /// It comes up.
    pub up: String,
}

/// The words of the generator.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct UltrasonicWords {
    /// It goes on.
    pub on: String,
    /// It goes off.
    pub off: String,
}

const WORD: Shape = Shape::Text { max_chars: 5 };

/// The shape of the words.
pub(super) const WORDS: Shape = Shape::Object(&[
    required(
        "knives",
        Shape::Array {
            item: &Shape::Object(&[required("down", WORD), required("up", WORD)]),
            min: 1,
            max: 2,
        },
    ),
    required("ultrasonic", Shape::Object(&[required("on", WORD), required("off", WORD)])),
    optional("optional_stop", WORD),
]);
