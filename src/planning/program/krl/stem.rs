//! The common beginning of the names of a program's files and of its variable.

/// The longest name that KRL takes, in characters.
const LONGEST_NAME: usize = 24;

/// The longest of the endings that a name gets: `_first`, as long as `_99999`.
const LONGEST_ENDING: usize = 6;

/// So many digits of a hash tell programs apart, and make a name that is no word of KRL.
const LEAST_DIGITS: usize = 8;

/// A name that begins all names of a program, made from its content: a word in lower case, an underscore, and the
/// first digits of a hash; short enough for every ending.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Stem(String);

impl Stem {
    /// The longest stem, in characters.
    pub const LONGEST: usize = LONGEST_NAME - LONGEST_ENDING;

    /// Takes a text as a stem: a letter, then lower-case letters, digits and underscores, at last an underscore and
    /// at least 8 hex digits in lower case; 18 characters at most. `None` if it is something else.
    #[must_use]
    pub fn new(text: &str) -> Option<Self> {
        let plain = |letter: char| letter.is_ascii_lowercase() || letter.is_ascii_digit() || letter == '_';
        let (word, digits) = text.rsplit_once('_')?;
        let fits = text.len() <= Self::LONGEST
            && word.starts_with(|first: char| first.is_ascii_lowercase())
            && text.chars().all(plain)
            && digits.len() >= LEAST_DIGITS
            && digits.chars().all(|digit| digit.is_ascii_hexdigit());
        fits.then(|| Self(text.to_owned()))
    }

    /// The stem itself, which is the name of the main program.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// The name of a sub-program, from 1.
    #[must_use]
    pub(super) fn sub_program(&self, number: usize) -> String {
        format!("{}_{number:03}", self.0)
    }

    /// The variable that holds the first layer to be cut.
    #[must_use]
    pub(super) fn first_layer(&self) -> String {
        format!("{}_first", self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_made_of_the_longest_stem_is_short_enough() {
        let stem = Stem::new("abcdefghi_01234567").unwrap();
        for name in [stem.sub_program(1), stem.sub_program(99_999), stem.first_layer()] {
            assert!(name.len() <= LONGEST_NAME, "{name}");
        }
        assert_eq!(stem.sub_program(7), "abcdefghi_01234567_007");
    }

    #[test]
    fn what_is_no_name_is_no_stem() {
        let texts = [
            "",
            "vcut",
            "_01234567",
            "1cut_01234567",
            "Vcut_01234567",
            "vcut-01234567",
            "vcut_0123456",
            "vcut_0123456g",
            "vcut_0123456A",
            "v cut_01234567",
            "\u{e4}cut_01234567",
            "abcdefghij_01234567",
        ];
        for text in texts {
            assert_eq!(Stem::new(text), None, "{text}");
        }
        assert!(Stem::new("vcut_0123456789ab").is_some());
        assert!(Stem::new("vcut_abcdefabcdef").is_some());
    }
}
