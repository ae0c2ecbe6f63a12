//! A line of KRL as tokens.

use super::fault::Fault;

/// A control takes no longer names.
const LONGEST_NAME: usize = 24;

/// A token.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Token<'a> {
    /// A name or a word of the language, as written. May begin with `$`.
    Name(&'a str),
    /// A number without a point.
    Whole(i64),
    /// A number with a point or an exponent.
    Real(f64),
    /// `"..."`.
    Text,
    /// An operator or a bracket.
    Sign(&'static str),
}

/// A token and its column, from 1.
pub(super) type Placed<'a> = super::fault::At<Token<'a>>;

/// Longer ones first.
const SIGNS: [&str; 21] = [
    "==", "<>", "<=", ">=", "{", "}", "(", ")", "[", "]", ",", ":", ".", "=", "<", ">", "+", "-", "*", "/",
    "#",
];

/// The length in bytes of what stands before the comment of a line.
pub(super) fn code_length(line: &str) -> usize {
    let mut in_text = false;
    for (index, letter) in line.char_indices() {
        match letter {
            '"' => in_text = !in_text,
            ';' if !in_text => return index,
            _ => {}
        }
    }
    line.len()
}

/// The column, from 1, of a byte of a line.
pub(super) fn column(line: &str, index: usize) -> usize {
    line.char_indices().take_while(|(at, _)| *at < index).count() + 1
}

/// The tokens of the first `length` bytes of a line.
///
/// # Errors
/// The first character that begins no token.
pub(super) fn tokens(line: &str, length: usize) -> Result<Vec<Placed<'_>>, Fault> {
    let mut tokens = Vec::new();
    let (mut at, mut column) = (0, 1);
    while let Some(first) = line[at..length].chars().next() {
        if first == ' ' || first == '\t' {
            at += 1;
            column += 1;
            continue;
        }
        let (value, size) = token(&line[at..length], first).map_err(|message| Fault::new(column, message))?;
        tokens.push(Placed { column, value });
        column += line[at..at + size].chars().count();
        at += size;
    }
    Ok(tokens)
}

/// The token at the beginning of a text, and its length in bytes.
fn token(text: &str, first: char) -> Result<(Token<'_>, usize), String> {
    match first {
        '"' => quoted(text),
        '\'' => bits(text),
        '0'..='9' => number(text),
        '.' if text[1..].starts_with(|next: char| next.is_ascii_digit()) => number(text),
        'a'..='z' | 'A'..='Z' | '_' | '$' => name(text),
        _ => match SIGNS.iter().find(|sign| text.starts_with(**sign)) {
            Some(sign) => Ok((Token::Sign(sign), sign.len())),
            None => Err(format!("{first:?} has no meaning here")),
        },
    }
}

fn name(text: &str) -> Result<(Token<'_>, usize), String> {
    let part = |letter: char| letter.is_ascii_alphanumeric() || letter == '_' || letter == '$';
    let size = text.find(|letter| !part(letter)).unwrap_or(text.len());
    if size > LONGEST_NAME {
        return Err(format!("a name of {size} characters; a control takes {LONGEST_NAME}"));
    }
    Ok((Token::Name(&text[..size]), size))
}

/// `[0-9]*(.[0-9]*)?(E[+-]?[0-9]+)?`, nothing that belongs to a name or another number behind it.
fn number(text: &str) -> Result<(Token<'_>, usize), String> {
    let bytes = text.as_bytes();
    let digits = |from: usize| bytes[from..].iter().take_while(|byte| byte.is_ascii_digit()).count();
    let mut size = digits(0);
    let mut whole = true;
    if bytes.get(size) == Some(&b'.') {
        whole = false;
        size += 1 + digits(size + 1);
    }
    if let Some(exponent) = exponent_size(bytes, size) {
        whole = false;
        size += exponent;
    }
    let (digits, rest) = text.split_at(size);
    if rest.starts_with(|next: char| next.is_ascii_alphanumeric() || matches!(next, '_' | '$' | '.')) {
        return Err(format!("the number {digits} runs into what follows"));
    }
    let token = if whole { digits.parse().ok().map(Token::Whole) } else { real(digits) };
    token.map(|token| (token, size)).ok_or_else(|| format!("{digits} is too large a number"))
}

fn exponent_size(bytes: &[u8], at: usize) -> Option<usize> {
    if !matches!(bytes.get(at), Some(b'e' | b'E')) {
        return None;
    }
    let sign = usize::from(matches!(bytes.get(at + 1), Some(b'+' | b'-')));
    let digits = bytes[at + 1 + sign..].iter().take_while(|byte| byte.is_ascii_digit()).count();
    (digits > 0).then_some(1 + sign + digits)
}

fn real(digits: &str) -> Option<Token<'static>> {
    digits.parse().ok().filter(|value: &f64| value.is_finite()).map(Token::Real)
}

/// `'B010'`, `'H1F'`.
fn bits(text: &str) -> Result<(Token<'_>, usize), String> {
    let inner = text[1..].split('\'').next().unwrap_or_default();
    let size = inner.len() + 2;
    let radix = match inner.chars().next() {
        Some('b' | 'B') => 2,
        Some('h' | 'H') => 16,
        _ => 0,
    };
    let digits = inner.get(1..).unwrap_or_default();
    let plain = digits.chars().all(|digit| digit.is_ascii_hexdigit());
    if text.len() < size || radix == 0 || !plain {
        return Err("' begins a number such as 'B010' or 'H1F'".to_owned());
    }
    i64::from_str_radix(digits, radix)
        .map(|value| (Token::Whole(value), size))
        .map_err(|_| format!("'{inner}' is no number"))
}

fn quoted(text: &str) -> Result<(Token<'_>, usize), String> {
    match text[1..].find('"') {
        Some(length) => Ok((Token::Text, length + 2)),
        None => Err("a text is not closed".to_owned()),
    }
}
