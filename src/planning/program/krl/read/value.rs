//! Values, variables and comparisons in a line.

use super::cursor::Cursor;
use super::fault::{At, Fault};
use super::lexer::Token;
use super::statement::{Aggregate, Condition, Expression, Place, Relation, Value};

/// A load has frames within; nothing is nested deeper.
const DEEPEST: usize = 4;

/// A value or a variable.
pub(super) fn expression(cursor: &mut Cursor<'_>) -> Result<At<Expression>, Fault> {
    let column = cursor.column();
    let value = match cursor.peek(0) {
        Some(Token::Name(name)) if truth(name).is_none() => Expression::Place(place(cursor)?.value),
        _ => Expression::Value(value(cursor)?.value),
    };
    Ok(At { column, value })
}

/// A value that stands in the text.
pub(super) fn value(cursor: &mut Cursor<'_>) -> Result<At<Value>, Fault> {
    nested_value(cursor, 0)
}

fn nested_value(cursor: &mut Cursor<'_>, depth: usize) -> Result<At<Value>, Fault> {
    let column = cursor.column();
    let value = match cursor.peek(0) {
        Some(Token::Sign("{")) => Value::Aggregate(nested_aggregate(cursor, depth)?),
        Some(Token::Sign("#")) => {
            cursor.take();
            Value::Word(cursor.name()?.value)
        }
        Some(Token::Text) => {
            cursor.take();
            Value::Other
        }
        Some(Token::Name(name)) => match truth(name) {
            Some(value) => {
                cursor.take();
                Value::Truth(value)
            }
            None => return cursor.fault("a value is written out here, not named"),
        },
        _ => signed(cursor)?,
    };
    Ok(At { column, value })
}

fn truth(name: &str) -> Option<bool> {
    match name {
        _ if name.eq_ignore_ascii_case("TRUE") => Some(true),
        _ if name.eq_ignore_ascii_case("FALSE") => Some(false),
        _ => None,
    }
}

fn signed(cursor: &mut Cursor<'_>) -> Result<Value, Fault> {
    let negative = cursor.take_sign("-");
    if !negative {
        cursor.take_sign("+");
    }
    let value = match cursor.peek(0) {
        Some(Token::Whole(value)) => Value::Whole(if negative { -value } else { *value }),
        Some(Token::Real(value)) => Value::Real(if negative { -value } else { *value }),
        _ => return cursor.fault("a value belongs here"),
    };
    cursor.take();
    Ok(value)
}

/// `{TYPE: NAME VALUE, ...}`.
pub(super) fn aggregate(cursor: &mut Cursor<'_>) -> Result<Aggregate, Fault> {
    nested_aggregate(cursor, 0)
}

fn nested_aggregate(cursor: &mut Cursor<'_>, depth: usize) -> Result<Aggregate, Fault> {
    if depth >= DEEPEST {
        return cursor.fault(format!("values are nested more than {DEEPEST} deep"));
    }
    cursor.expect_sign("{")?;
    let kind = if cursor.is_sign(1, ":") { Some(kind(cursor)?) } else { None };
    let mut components: Vec<(At<String>, At<Value>)> = Vec::new();
    loop {
        let name = cursor.name()?;
        if components.iter().any(|(other, _)| other.value == name.value) {
            return Err(Fault::new(name.column, format!("{} stands twice", name.value)));
        }
        if cursor.take_sign("[") {
            cursor.expect_sign("]")?;
        }
        components.push((name, nested_value(cursor, depth + 1)?));
        if components.len() > MOST_COMPONENTS {
            return cursor.fault(format!("more than {MOST_COMPONENTS} components"));
        }
        if !cursor.take_sign(",") {
            break;
        }
    }
    cursor.expect_sign("}")?;
    Ok(Aggregate { kind, components })
}

/// No structure of the control has as many components; each is compared with those before it.
const MOST_COMPONENTS: usize = 64;

fn kind(cursor: &mut Cursor<'_>) -> Result<String, Fault> {
    let kind = cursor.name()?.value;
    cursor.expect_sign(":")?;
    Ok(kind)
}

/// `NAME[1].FIELD`.
pub(super) fn place(cursor: &mut Cursor<'_>) -> Result<At<Place>, Fault> {
    let name = cursor.name()?;
    let index = if cursor.take_sign("[") { Some(index(cursor)?) } else { None };
    let field = if cursor.take_sign(".") { Some(cursor.name()?.value) } else { None };
    if cursor.is_sign(0, ".") {
        return cursor.fault("a component of a component is not read");
    }
    Ok(At { column: name.column, value: Place { name: name.value, index, field } })
}

/// What stands between `[` and `]`. Texts have nothing there.
fn index(cursor: &mut Cursor<'_>) -> Result<i64, Fault> {
    if cursor.take_sign("]") {
        return Ok(0);
    }
    let Some(Token::Whole(index)) = cursor.peek(0) else {
        return cursor.fault("an index is written out, and there is one only");
    };
    cursor.take();
    cursor.expect_sign("]")?;
    Ok(*index)
}

/// `LEFT < RIGHT`, with or without brackets around it.
pub(super) fn condition(cursor: &mut Cursor<'_>) -> Result<Condition, Fault> {
    let bracket = cursor.take_sign("(");
    let left = expression(cursor)?;
    let column = cursor.column();
    let relation = match cursor.take() {
        Some(Token::Sign("==")) => Relation::Equal,
        Some(Token::Sign("<>")) => Relation::Different,
        Some(Token::Sign("<")) => Relation::Less,
        Some(Token::Sign("<=")) => Relation::LessOrEqual,
        Some(Token::Sign(">")) => Relation::Greater,
        Some(Token::Sign(">=")) => Relation::GreaterOrEqual,
        _ => return Err(Fault::new(column, "only a comparison of two values is read here")),
    };
    let right = expression(cursor)?;
    if bracket {
        cursor.expect_sign(")")?;
    }
    Ok(Condition { left, relation, right })
}
