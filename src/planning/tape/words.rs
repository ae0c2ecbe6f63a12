//! The words by which a control switches knives and generator, where its builder has chosen them: M or H with a
//! number.

use super::machine::Dialect;
use super::wire;
use crate::planning::finding::{Code, Finding};

/// The words of a machine.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Words {
    /// Down and up of each cutter's knife.
    pub knives: Vec<[String; 2]>,
    /// On and off of the generator.
    pub ultrasonic: [String; 2],
    /// The stop that the operator can switch on.
    pub optional_stop: String,
}

/// The optional stop of every control that has one (DIN 66025).
const OPTIONAL_STOP: &str = "M1";

/// M words with a meaning of their own: stops, ends, spindles, tools, gears.
const TAKEN: [u32; 17] = [0, 1, 2, 3, 4, 5, 6, 17, 19, 30, 40, 41, 42, 43, 44, 45, 70];

/// The words of a profile, which only a dialect without outputs of its own has.
///
/// # Errors
/// `MissingField` or `OutOfRange` for every fault, with pointers below `at`.
pub fn check(profile: &wire::MachineProfile, at: &str) -> Result<Option<Words>, Vec<Finding>> {
    let at = format!("{at}/program/words");
    let fault = |code, at: String, message: &str| Err(vec![Finding::error(code, at, message)]);
    let words = match (&profile.program.words, profile.dialect) {
        (None, Dialect::Linuxcnc) => return Ok(None),
        (Some(_), Dialect::Linuxcnc) => {
            return fault(
                Code::OutOfRange,
                at,
                "linuxcnc switches the outputs themselves; leave the words out",
            );
        }
        (None, Dialect::Sinumerik) => {
            let message = "this control switches knives by words that its builder has chosen; name them";
            return fault(Code::MissingField, at, message);
        }
        (Some(words), Dialect::Sinumerik) => words,
    };
    if words.knives.len() != profile.cutters.len() {
        return fault(
            Code::OutOfRange,
            format!("{at}/knives"),
            "as many pairs of words as there are cutters",
        );
    }
    let faults = faults(words, &at);
    if faults.is_empty() { Ok(Some(take_over(words))) } else { Err(faults) }
}

fn faults(words: &wire::Words, at: &str) -> Vec<Finding> {
    let mut named: Vec<(String, &str)> = Vec::new();
    for (index, knife) in words.knives.iter().enumerate() {
        named.push((format!("{at}/knives/{index}/down"), &knife.down));
        named.push((format!("{at}/knives/{index}/up"), &knife.up));
    }
    named.push((format!("{at}/ultrasonic/on"), &words.ultrasonic.on));
    named.push((format!("{at}/ultrasonic/off"), &words.ultrasonic.off));
    let mut faults = Vec::new();
    for (index, (at, word)) in named.iter().enumerate() {
        if !is_free(word) {
            let message =
                "a word is M or H and a number of up to four digits that has no other meaning: M80, H12";
            faults.push(Finding::error(Code::OutOfRange, at.clone(), message));
        } else if let Some((other, _)) = named[..index].iter().find(|(_, earlier)| earlier == word) {
            let message = format!("{word} is taken already by {other}");
            faults.push(Finding::error(Code::OutOfRange, at.clone(), message));
        }
    }
    let stop = words.optional_stop.as_deref().unwrap_or(OPTIONAL_STOP);
    let taken = named.iter().any(|(_, word)| *word == stop);
    if stop != OPTIONAL_STOP && (taken || !is_free(stop)) {
        let message = "the optional stop is M1, or a free word of its own";
        faults.push(Finding::error(Code::OutOfRange, format!("{at}/optional_stop"), message));
    }
    faults
}

/// M or H and up to four digits without a leading zero, and not one of those with a meaning.
fn is_free(word: &str) -> bool {
    let Some(digits) = word.strip_prefix(['M', 'H']) else { return false };
    let plain = (1..=4).contains(&digits.len()) && digits.bytes().all(|digit| digit.is_ascii_digit());
    let number: Option<u32> =
        digits.parse().ok().filter(|_| plain && (digits == "0" || !digits.starts_with('0')));
    number.is_some_and(|number| word.starts_with('H') || !TAKEN.contains(&number))
}

fn take_over(words: &wire::Words) -> Words {
    Words {
        knives: words.knives.iter().map(|knife| [knife.down.clone(), knife.up.clone()]).collect(),
        ultrasonic: [words.ultrasonic.on.clone(), words.ultrasonic.off.clone()],
        optional_stop: words.optional_stop.clone().unwrap_or_else(|| OPTIONAL_STOP.to_owned()),
    }
}
