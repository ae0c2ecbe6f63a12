//! A motion in a line.

use super::cursor::Cursor;
use super::fault::{At, Fault};
use super::lexer::Token;
use super::statement::{Motion, Origin, Statement, Target, Way};
use super::value;

/// System variables that hold where the arm stands. A motion to them is none.
const HERE: [&str; 4] = ["$POS_ACT", "$AXIS_ACT", "$POS_INT", "$AXIS_INT"];

/// A motion whose first word has been taken: `word` in upper case, at `column`.
///
/// # Errors
/// What is not understood whole: another kind of motion, a suffix that is none.
pub(super) fn motion(word: &str, column: usize, cursor: &mut Cursor<'_>) -> Result<Statement, Fault> {
    let (way, relative) = match word {
        "LIN" | "SLIN" => (Way::Line, false),
        "PTP" | "SPTP" => (Way::Joint, false),
        "LIN_REL" | "SLIN_REL" => (Way::Line, true),
        "PTP_REL" | "SPTP_REL" => (Way::Joint, true),
        _ => return Err(Fault::new(column, format!("{word} is refused: {}", why_not(word)))),
    };
    let target = target(cursor)?;
    if relative && !matches!(target.value, Target::Written(_)) {
        return Err(Fault::new(target.column, "a relative motion is read with its way written out only"));
    }
    let blend = blend(word, cursor)?;
    let from = match (relative, cursor.take_sign("#")) {
        (false, false) => Origin::Base,
        (true, false) => Origin::HereAlongBase,
        (true, true) => reference(cursor)?,
        (false, true) => return cursor.fault("# belongs to relative motions"),
    };
    if cursor.is_word(0, "WITH") {
        return cursor.fault("settings for one motion (WITH) are refused; they stand in lines before it");
    }
    cursor.end()?;
    Ok(Statement::Move(Box::new(Motion { way, from, target, blend })))
}

fn why_not(word: &str) -> &'static str {
    match word {
        "CIRC" | "CIRC_REL" | "SCIRC" | "SCIRC_REL" => "an arc is no straight motion",
        "SPL" | "SPL_REL" | "SPLINE" | "PTP_SPLINE" | "ENDSPLINE" => "a spline is no straight motion",
        _ => "it has no place in such a program",
    }
}

fn target(cursor: &mut Cursor<'_>) -> Result<At<Target>, Fault> {
    let column = cursor.column();
    let value = match cursor.peek(0) {
        Some(Token::Sign("{")) => Target::Written(value::aggregate(cursor)?),
        Some(Token::Name(_)) => {
            let place = value::place(cursor)?.value;
            let here = place.index.is_none() && place.field.is_none() && HERE.contains(&place.name.as_str());
            if here { Target::Here } else { Target::Named(place) }
        }
        _ => return cursor.fault("a point belongs here"),
    };
    if cursor.is_sign(0, ":") {
        return cursor.fault("frames put together (:) are refused; a point is written out or named");
    }
    Ok(At { column, value })
}

/// The words behind a target that round its end off.
fn blend(word: &str, cursor: &mut Cursor<'_>) -> Result<bool, Fault> {
    let spline = word.starts_with('S');
    let joint = word.contains("PTP");
    let allowed: &[&str] = match (spline, joint) {
        (true, _) => &["C_SPL", "C_DIS", "C_PTP"],
        (false, true) => &["C_PTP", "C_DIS", "C_ORI", "C_VEL"],
        (false, false) => &["C_DIS", "C_ORI", "C_VEL"],
    };
    let mut count = 0;
    while let Some(Token::Name(suffix)) = cursor.peek(0) {
        if suffix.eq_ignore_ascii_case("WITH") {
            break;
        }
        if !allowed.iter().any(|known| known.eq_ignore_ascii_case(suffix)) {
            return cursor.fault(format!("{suffix} is no suffix of {word} that is read"));
        }
        // The forms of the teach pendant write one for each neighbour.
        if count == 2 {
            return cursor.fault("at most two words say how an end is rounded off");
        }
        cursor.take();
        count += 1;
    }
    Ok(count > 0)
}

fn reference(cursor: &mut Cursor<'_>) -> Result<Origin, Fault> {
    let column = cursor.column();
    match cursor.name()?.value.as_str() {
        "BASE" => Ok(Origin::HereAlongBase),
        "TOOL" => Ok(Origin::HereAlongTool),
        other => Err(Fault::new(column, format!("#{other} is neither #BASE nor #TOOL"))),
    }
}
