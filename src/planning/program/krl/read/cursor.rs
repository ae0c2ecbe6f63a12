//! A walk over the tokens of a line.

use super::fault::{At, Fault};
use super::lexer::{Placed, Token};

/// The tokens of a line that are still to be read.
pub(super) struct Cursor<'a> {
    tokens: &'a [Placed<'a>],
    next: usize,
    /// The column behind the last token.
    end: usize,
}

impl<'a> Cursor<'a> {
    pub(super) fn new(tokens: &'a [Placed<'a>], end: usize) -> Self {
        Self { tokens, next: 0, end }
    }

    /// The token `ahead` of the next one.
    pub(super) fn peek(&self, ahead: usize) -> Option<&'a Token<'a>> {
        self.tokens.get(self.next + ahead).map(|token| &token.value)
    }

    /// The column of the next token, or behind the last.
    pub(super) fn column(&self) -> usize {
        self.tokens.get(self.next).map_or(self.end, |token| token.column)
    }

    pub(super) fn take(&mut self) -> Option<&'a Token<'a>> {
        let token = self.peek(0);
        self.next += usize::from(token.is_some());
        token
    }

    pub(super) fn fault<T>(&self, message: impl Into<String>) -> Result<T, Fault> {
        Err(Fault::new(self.column(), message))
    }

    pub(super) fn is_sign(&self, ahead: usize, sign: &str) -> bool {
        matches!(self.peek(ahead), Some(Token::Sign(found)) if *found == sign)
    }

    /// Takes a sign if it is the next token.
    pub(super) fn take_sign(&mut self, sign: &str) -> bool {
        let is_next = self.is_sign(0, sign);
        self.next += usize::from(is_next);
        is_next
    }

    pub(super) fn expect_sign(&mut self, sign: &str) -> Result<(), Fault> {
        if self.take_sign(sign) { Ok(()) } else { self.fault(format!("{sign:?} belongs here")) }
    }

    pub(super) fn is_word(&self, ahead: usize, word: &str) -> bool {
        matches!(self.peek(ahead), Some(Token::Name(name)) if name.eq_ignore_ascii_case(word))
    }

    /// Takes a word, in any case, if it is the next token.
    pub(super) fn take_word(&mut self, word: &str) -> bool {
        let is_next = self.is_word(0, word);
        self.next += usize::from(is_next);
        is_next
    }

    pub(super) fn expect_word(&mut self, word: &str) -> Result<(), Fault> {
        if self.take_word(word) { Ok(()) } else { self.fault(format!("{word} belongs here")) }
    }

    /// The next token as a name, in upper case.
    pub(super) fn name(&mut self) -> Result<At<String>, Fault> {
        let column = self.column();
        let Some(Token::Name(name)) = self.peek(0) else { return self.fault("a name belongs here") };
        self.next += 1;
        Ok(At { column, value: name.to_ascii_uppercase() })
    }

    /// Nothing may follow.
    pub(super) fn end(&self) -> Result<(), Fault> {
        match self.peek(0) {
            None => Ok(()),
            Some(_) => self.fault("the statement should end before this"),
        }
    }
}
