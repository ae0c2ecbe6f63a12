//! A line of KRL as a statement.

use super::cursor::Cursor;
use super::fault::{At, Fault};
use super::lexer::{self, Placed, Token};
use super::statement::{Assignment, Declaration, Expression, Line, Place, Statement, Value};
use super::{motion, value, words};

/// A longer line, in bytes, is no line of a program.
const LONGEST_LINE: usize = 4096;

/// A text with more lines is read so far and no further. A control holds no such program.
const MOST_LINES: usize = 1_000_000;

/// Types of variables that can be written without DECL before them.
const TYPES: [&str; 12] =
    ["INT", "REAL", "BOOL", "CHAR", "FRAME", "POS", "E6POS", "AXIS", "E6AXIS", "FDAT", "LDAT", "PDAT"];

/// The statements of a text, a line each. Lines end with LF or CR LF; the last one need not.
///
/// A text of more than a million lines is read so far; the line behind says so.
#[must_use]
pub fn statements(text: &str) -> Vec<Line<'_>> {
    // Editors put a mark before the first line that says how the text is coded.
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let text = text.strip_suffix('\n').unwrap_or(text);
    if text.is_empty() {
        return Vec::new();
    }
    let lines = text.split('\n').take(MOST_LINES + 1).enumerate();
    lines.map(|(index, text)| line(index + 1, text.strip_suffix('\r').unwrap_or(text))).collect()
}

fn line(number: usize, text: &str) -> Line<'_> {
    let length = lexer::code_length(text);
    let code = text[..length].trim_end_matches([' ', '\t']);
    let start = code.len() - code.trim_start_matches([' ', '\t']).len();
    let span = start..code.len();
    let statement = plain(number, text).and_then(|()| match &code[start..] {
        "" => Ok(Statement::Nothing),
        code if code.starts_with('&') => Ok(Statement::Header),
        _ => lexer::tokens(text, span.end).and_then(|tokens| statement(text, span.end, &tokens)),
    });
    Line { number, text, span, statement }
}

/// A line of bounded length, without characters that a control might take for the end of one.
fn plain(number: usize, text: &str) -> Result<(), Fault> {
    if number > MOST_LINES {
        let message = format!("the text has more than {MOST_LINES} lines; what follows is not read");
        return Err(Fault::new(1, message));
    }
    if text.len() > LONGEST_LINE {
        let message = format!("the line has {} bytes; a line has at most {LONGEST_LINE}", text.len());
        return Err(Fault::new(1, message));
    }
    let hidden =
        |letter: char| letter != '\t' && (letter.is_control() || matches!(letter, '\u{2028}' | '\u{2029}'));
    match text.chars().position(hidden) {
        Some(index) => Err(Fault::new(index + 1, "a character that is not printed stands here")),
        None => Ok(()),
    }
}

fn statement(text: &str, end: usize, tokens: &[Placed<'_>]) -> Result<Statement, Fault> {
    let mut cursor = Cursor::new(tokens, lexer::column(text, end));
    let first = cursor.name()?;
    let statement = match first.value.as_str() {
        word if words::is_motion(word) => return motion::motion(word, first.column, &mut cursor),
        word if words::is_branch(word) => {
            let message = format!("{word} is refused: which lines come next must not depend on more than IF");
            return Err(Fault::new(first.column, message));
        }
        "DEF" => definition(&mut cursor, false)?,
        "DEFDAT" => {
            let name = cursor.name()?.value;
            cursor.take_word("PUBLIC");
            Statement::DefDat { name }
        }
        "END" => Statement::End,
        "ENDDAT" => Statement::EndDat,
        "EXT" | "EXTFCT" | "EXTP" | "EXTFCTP" => return Ok(Statement::External),
        "GLOBAL" if cursor.take_word("DEF") => definition(&mut cursor, true)?,
        "INTERRUPT" => interrupt(&mut cursor)?,
        "GLOBAL" if cursor.take_word("INTERRUPT") => interrupt(&mut cursor)?,
        "DECL" | "GLOBAL" | "CONST" => return declaration(&first.value, &mut cursor),
        word if TYPES.contains(&word) && matches!(cursor.peek(0), Some(Token::Name(_))) => {
            return declaration(word, &mut cursor);
        }
        "SIGNAL" | "CHANNEL" | "STRUC" | "ENUM" | "IMPORT" => {
            let message = format!("{} gives names a meaning that this reader does not follow", first.value);
            return Err(Fault::new(first.column, message));
        }
        "TRIGGER" => trigger(&mut cursor)?,
        "WAIT" => wait(&mut cursor)?,
        "HALT" => Statement::Halt,
        "IF" => {
            let condition = value::condition(&mut cursor)?;
            cursor.expect_word("THEN")?;
            Statement::If(Box::new(condition))
        }
        "ELSE" => Statement::Else,
        "ENDIF" => Statement::EndIf,
        "RETURN" => Statement::Return,
        "CONTINUE" => Statement::Idle,
        "BAS" if cursor.is_sign(0, "(") => bas(&mut cursor)?,
        _ if cursor.is_sign(0, "(") => call(first, &mut cursor)?,
        _ => Statement::Assignment(Box::new(assignment(&mut Cursor::new(tokens, lexer::column(text, end)))?)),
    };
    if !matches!(statement, Statement::Assignment(_)) {
        cursor.end()?;
    }
    Ok(statement)
}

fn definition(cursor: &mut Cursor<'_>, global: bool) -> Result<Statement, Fault> {
    let name = cursor.name()?.value;
    cursor.expect_sign("(")?;
    let mut parameters = false;
    while !cursor.is_sign(0, ")") && cursor.take().is_some() {
        parameters = true;
    }
    cursor.expect_sign(")")?;
    Ok(Statement::Def { name, global, parameters })
}

/// `[DECL] [GLOBAL] [CONST] TYPE NAME [=VALUE], ...`, of which the first word has been taken.
fn declaration(first: &str, cursor: &mut Cursor<'_>) -> Result<Statement, Fault> {
    let mut global = false;
    let mut word = first.to_owned();
    while matches!(word.as_str(), "DECL" | "GLOBAL" | "CONST") {
        global |= word == "GLOBAL";
        word = cursor.name()?.value;
    }
    if !TYPES.contains(&word.as_str()) || word == "CHAR" {
        return other_declaration(global, cursor);
    }
    let mut variables = Vec::new();
    loop {
        let place = plain_place(cursor)?;
        let value = if cursor.take_sign("=") { Some(value::value(cursor)?) } else { None };
        variables.push((place, value));
        if !cursor.take_sign(",") {
            break;
        }
    }
    cursor.end()?;
    Ok(Statement::Declaration(Declaration { global, variables }))
}

/// A variable of a type of which nothing here makes use: only its name is read.
fn other_declaration(global: bool, cursor: &mut Cursor<'_>) -> Result<Statement, Fault> {
    let column = cursor.column();
    let name = cursor.name()?.value;
    let place = Place { name, index: None, field: None };
    let variables = vec![(place, Some(At { column, value: Value::Other }))];
    Ok(Statement::Declaration(Declaration { global, variables }))
}

fn plain_place(cursor: &mut Cursor<'_>) -> Result<Place, Fault> {
    let place = value::place(cursor)?;
    match place.value.field {
        None => Ok(place.value),
        Some(_) => Err(Fault::new(place.column, "a component cannot be declared")),
    }
}

fn assignment(cursor: &mut Cursor<'_>) -> Result<Assignment, Fault> {
    let place = value::place(cursor)?;
    if !cursor.is_sign(0, "=") {
        return Err(Fault::new(
            place.column,
            format!("{} begins no statement that is read", place.value.name),
        ));
    }
    cursor.take();
    let value = value::expression(cursor)?;
    if cursor.peek(0).is_some() {
        return cursor.fault("a value is written out or named, not computed");
    }
    Ok(Assignment { place, value })
}

/// Only what the INI fold of every program says: a stop of the control is handled by the control's own program.
fn interrupt(cursor: &mut Cursor<'_>) -> Result<Statement, Fault> {
    let whole = |cursor: &mut Cursor<'_>| match cursor.take() {
        Some(Token::Whole(_)) => Ok(()),
        _ => cursor.fault("the number of an interrupt belongs here"),
    };
    if cursor.take_word("ON") || cursor.take_word("OFF") {
        whole(cursor)?;
        return Ok(Statement::Idle);
    }
    let column = cursor.column();
    cursor.expect_word("DECL")?;
    whole(cursor)?;
    let usual = cursor.take_word("WHEN")
        && cursor.take_word("$STOPMESS")
        && cursor.take_sign("==")
        && cursor.take_word("TRUE")
        && cursor.take_word("DO")
        && cursor.take_word("IR_STOPM")
        && cursor.take_sign("(")
        && cursor.take_sign(")");
    if usual { Ok(Statement::Idle) } else { Err(Fault::new(column, "what this interrupt does is not known")) }
}

/// `TRIGGER WHEN DISTANCE=0 DELAY=0 DO $OUT[1]=TRUE`.
fn trigger(cursor: &mut Cursor<'_>) -> Result<Statement, Fault> {
    cursor.expect_word("WHEN")?;
    zero("DISTANCE", cursor)?;
    zero("DELAY", cursor)?;
    cursor.expect_word("DO")?;
    let column = cursor.column();
    let output = assignment(cursor)?;
    if output.place.value.name != "$OUT" {
        return Err(Fault::new(column, "a trigger that does more than set an output is refused"));
    }
    Ok(Statement::Trigger { output: Box::new(output) })
}

fn zero(word: &str, cursor: &mut Cursor<'_>) -> Result<(), Fault> {
    cursor.expect_word(word)?;
    cursor.expect_sign("=")?;
    let at = value::value(cursor)?;
    if at.value.number() == Some(0.0) {
        return Ok(());
    }
    Err(Fault::new(
        at.column,
        format!("{word} is 0 in a trigger that is read: it acts as the next motion begins"),
    ))
}

fn wait(cursor: &mut Cursor<'_>) -> Result<Statement, Fault> {
    if cursor.is_word(0, "FOR") {
        return cursor.fault("what a program waits for does not stand in its text");
    }
    cursor.expect_word("SEC")?;
    Ok(Statement::Wait { seconds: value::expression(cursor)? })
}

fn bas(cursor: &mut Cursor<'_>) -> Result<Statement, Fault> {
    cursor.expect_sign("(")?;
    let column = cursor.column();
    cursor.expect_sign("#")?;
    let command = At { column, value: cursor.name()?.value };
    cursor.expect_sign(",")?;
    let value: At<Expression> = value::expression(cursor)?;
    cursor.expect_sign(")")?;
    Ok(Statement::Bas { command, value })
}

fn call(name: At<String>, cursor: &mut Cursor<'_>) -> Result<Statement, Fault> {
    cursor.expect_sign("(")?;
    let arguments = !cursor.take_sign(")");
    let mut closed = !arguments;
    while let Some(token) = cursor.take() {
        closed = matches!(token, Token::Sign(")"));
    }
    if !closed {
        return cursor.fault("a bracket is not closed");
    }
    Ok(Statement::Call { name, arguments })
}
