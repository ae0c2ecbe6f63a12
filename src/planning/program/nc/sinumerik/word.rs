//! A block as its words: letters with plain decimals, and FGROUP with its letters.

/// A word of a block.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Word<'a> {
    /// A letter and a number as it is written.
    Number {
        /// In capitals, as a control takes it.
        letter: char,
        /// Sign, digits, point.
        digits: &'a str,
        /// Its value.
        value: f64,
    },
    /// FGROUP, with what stands in its brackets.
    Group(&'a str),
}

/// Splits a block, which holds no comment, into its words.
///
/// # Errors
/// What is neither a letter with a number nor FGROUP.
pub(super) fn split(code: &str) -> Result<Vec<Word<'_>>, String> {
    let mut words = Vec::new();
    let mut rest = code;
    while !rest.is_empty() {
        let (word, after) = first(rest)?;
        words.push(word);
        rest = after.trim_start_matches([' ', '\t']);
    }
    Ok(words)
}

fn first(rest: &str) -> Result<(Word<'_>, &str), String> {
    let name = rest.len() - rest.trim_start_matches(|letter: char| letter.is_ascii_alphabetic()).len();
    let (letters, after) = rest.split_at(name);
    match (letters.len(), letters.eq_ignore_ascii_case("FGROUP")) {
        (_, true) => group(after),
        (1, _) => number(letters, after),
        (0, _) => Err(why_none(rest)),
        _ => Err(format!("{letters} has no place in such a program")),
    }
}

fn group(after: &str) -> Result<(Word<'_>, &str), String> {
    let inside = after.strip_prefix('(').and_then(|inside| inside.split_once(')'));
    let (letters, after) = inside.ok_or("FGROUP names its axes in brackets")?;
    Ok((Word::Group(letters), after))
}

fn number<'a>(letter: &str, after: &'a str) -> Result<(Word<'a>, &'a str), String> {
    let end =
        after.find(|letter: char| !matches!(letter, '0'..='9' | '.' | '+' | '-')).unwrap_or(after.len());
    let (digits, rest) = after.split_at(end);
    if rest.starts_with('=') || digits.is_empty() {
        return Err(format!("{letter} is followed by no number; assignments and variables are not computed"));
    }
    let unsigned = digits.strip_prefix(['+', '-']).unwrap_or(digits);
    let plain = unsigned.starts_with(|digit: char| digit.is_ascii_digit())
        && unsigned.ends_with(|digit: char| digit.is_ascii_digit())
        && unsigned.matches('.').count() <= 1
        && !unsigned.contains(['+', '-']);
    let value: f64 = match digits.parse() {
        Ok(value) if plain => value,
        _ => return Err(format!("{digits} after {letter} is not a plain decimal")),
    };
    let letter = letter.chars().next().map_or(' ', |letter| letter.to_ascii_uppercase());
    Ok((Word::Number { letter, digits, value }, rest))
}

fn why_none(rest: &str) -> String {
    match rest.chars().next() {
        Some('/') => "a switch at the machine decides whether a block after / is read".to_owned(),
        Some('%') => "% begins the header of an archive, not a program".to_owned(),
        Some('$') => "a variable has no value that stands in the text".to_owned(),
        Some('(') => "comments begin with ;".to_owned(),
        other => format!("{:?} begins no word", other.unwrap_or(' ')),
    }
}
