//! A line of NC text as words: letters with numbers, comments taken away.

/// Comments that begin with one of these names make LinuxCNC, or a program around it, do something.
const ACTIVE: [&str; 16] = [
    "msg",
    "debug",
    "print",
    "log",
    "logopen",
    "logappend",
    "logclose",
    "probeopen",
    "probeclose",
    "py",
    "pyrun",
    "pyreload",
    "abort",
    "axis",
    "preview",
    "system",
];

/// A letter with its number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Word<'a> {
    /// In upper case.
    pub(super) letter: char,
    /// Its number as written, without leading blanks.
    pub(super) digits: &'a str,
    /// Its number as a value.
    pub(super) value: f64,
}

/// The words of a line of printable ASCII.
///
/// # Errors
/// What is no word and no plain comment.
pub(super) fn split(line: &str) -> Result<Vec<Word<'_>>, String> {
    let mut words = Vec::new();
    let line = blanks_off(line);
    let mut rest = line;
    while let Some(first) = rest.chars().next() {
        rest = match first {
            '(' => after_comment(&rest[1..])?,
            ';' => {
                refuse_active(&rest[1..])?;
                ""
            }
            'a'..='z' | 'A'..='Z' => {
                let (word, after) = word(first, &rest[1..])?;
                if word.letter == 'N' && rest.len() < line.len() {
                    return Err("N stands first in its line, before any comment, or not at all".to_owned());
                }
                words.push(word);
                after
            }
            other => return Err(unexpected(other, words.is_empty())),
        };
        rest = blanks_off(rest);
    }
    Ok(words)
}

fn blanks_off(text: &str) -> &str {
    text.trim_start_matches([' ', '\t'])
}

/// What follows the comment whose text begins here.
fn after_comment(text: &str) -> Result<&str, String> {
    let Some((comment, after)) = text.split_once(')') else {
        return Err("a comment is not closed".to_owned());
    };
    if comment.contains('(') {
        return Err("a comment stands in a comment".to_owned());
    }
    refuse_active(comment)?;
    Ok(after)
}

fn refuse_active(comment: &str) -> Result<(), String> {
    let comment = blanks_off(comment);
    let end = comment.find(|letter: char| !letter.is_ascii_alphabetic()).unwrap_or(comment.len());
    let name = comment[..end].to_ascii_lowercase();
    if ACTIVE.contains(&name.as_str()) {
        return Err(format!("a comment that begins with \"{name}\" is more than a comment to a control"));
    }
    Ok(())
}

fn word(letter: char, rest: &str) -> Result<(Word<'_>, &str), String> {
    let letter = letter.to_ascii_uppercase();
    let rest = blanks_off(rest);
    let (digits, after) = rest.split_at(number_length(rest));
    // A number such as "1 0" is 10 to LinuxCNC, and something else to whoever reads it.
    if blanks_off(after).starts_with(|next: char| next.is_ascii_digit() || next == '.') {
        return Err(format!("the number after {letter} is not a plain decimal"));
    }
    if !digits.contains(|digit: char| digit.is_ascii_digit()) {
        return Err(format!("{letter} has no number"));
    }
    let value = digits.parse().map_err(|_| format!("{digits} after {letter} is not a number"))?;
    Ok((Word { letter, digits, value }, after))
}

/// The length of `[+-]?[0-9]*(.[0-9]*)?` at the beginning of a text.
fn number_length(text: &str) -> usize {
    let bytes = text.as_bytes();
    let digits_from = |start: usize| bytes[start..].iter().take_while(|byte| byte.is_ascii_digit()).count();
    let mut length = usize::from(matches!(bytes.first(), Some(b'+' | b'-')));
    length += digits_from(length);
    if bytes.get(length) == Some(&b'.') {
        length += 1;
        length += digits_from(length);
    }
    length
}

fn unexpected(letter: char, at_start: bool) -> String {
    match letter {
        '/' if at_start => "a switch at the machine decides whether a line after / is read".to_owned(),
        '#' => "a parameter has no value that stands in the text".to_owned(),
        '[' => "a number is written out, not computed".to_owned(),
        '%' => "% stands alone in its line".to_owned(),
        other => format!("{other:?} begins neither a word nor a comment"),
    }
}
