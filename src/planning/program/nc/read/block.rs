//! The meaning of one block: at most one action, under the settings made so far.

use super::super::super::events::AXIS_LETTERS;
use super::words::Word;

/// What a block does.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Action {
    /// Axes go to targets (in the order of `AXIS_LETTERS`); as a rapid if there is no time.
    Move { targets: [Option<f64>; 9], cruise_s: Option<f64> },
    /// One axis, by its place in `AXIS_LETTERS`, goes to a target at a feed in mm or degrees a minute (G94).
    Travel { axis: usize, target: f64, per_minute: f64 },
    /// M64 and M65.
    Output { number: u32, on: bool },
    /// G4.
    Dwell { seconds: f64 },
    /// M1.
    OptionalStop,
    /// M2.
    End,
}

/// What the blocks so far have set.
#[derive(Debug, Clone, Default)]
pub(super) struct Modal {
    settings: [bool; SETTINGS.len()],
    motion: Option<Motion>,
    /// Whether F is a speed (G94) and no inverse time.
    per_minute: bool,
    said_missing: bool,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Motion {
    Rapid,
    Straight,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Code {
    Motion(Motion),
    Dwell,
    /// Index in [`SETTINGS`].
    Setting(usize),
    /// G94, until the next G93.
    PerMinute,
}

/// The place of G93 in [`SETTINGS`].
const INVERSE_TIME: usize = 6;

/// The settings that must stand in the text before anything moves, each with the G numbers that make it.
/// Without one of them the same words could mean another motion.
const SETTINGS: [(&str, &[&str]); 7] = [
    ("millimetres (G21)", &["21"]),
    ("absolute positions (G90)", &["90"]),
    ("plane XY (G17)", &["17"]),
    ("no cutter compensation (G40)", &["40"]),
    ("no tool length (G49)", &["49"]),
    ("exact path (G61)", &["61", "61.1"]),
    ("inverse time (G93)", &["93"]),
];

/// The words of a block, sorted.
#[derive(Default)]
struct Block<'a> {
    codes: Vec<Code>,
    m: Option<Word<'a>>,
    axes: [Option<f64>; 9],
    feed: Option<Word<'a>>,
    p: Option<Word<'a>>,
}

/// What the words of a block do; nothing if they only set something.
///
/// # Errors
/// Words that do not belong together, or do not mean one thing only.
pub(super) fn interpret(words: &[Word<'_>], modal: &mut Modal) -> Result<Option<Action>, String> {
    let block = sort(words)?;
    let moves = block.axes.iter().any(Option::is_some);
    if let Some(m) = block.m {
        if !block.codes.is_empty() || moves || block.feed.is_some() {
            return Err(format!("M{} stands in a block of its own", m.digits));
        }
        return machine_function(m, block.p).map(Some);
    }
    if block.codes.contains(&Code::Dwell) {
        if block.codes.len() > 1 || moves || block.feed.is_some() {
            return Err("G4 stands in a block of its own".to_owned());
        }
        return dwell(block.p).map(Some);
    }
    if block.p.is_some() {
        return Err("P belongs to G4, M64 or M65".to_owned());
    }
    set(&block, modal);
    if moves { motion(&block, modal).map(Some) } else { no_motion(&block).map(|()| None) }
}

fn sort<'a>(words: &[Word<'a>]) -> Result<Block<'a>, String> {
    let mut block = Block::default();
    for &word in words {
        match word.letter {
            'N' => whole(word).map(|_| ())?,
            'G' => add_code(&mut block.codes, code(word)?, word)?,
            'M' => once(&mut block.m, word)?,
            'F' => once(&mut block.feed, word)?,
            'P' => once(&mut block.p, word)?,
            letter => match AXIS_LETTERS.iter().position(|&axis| axis == letter) {
                Some(axis) if block.axes[axis].is_none() => block.axes[axis] = Some(word.value),
                Some(_) => return Err(format!("{letter} stands twice in one block")),
                None => return Err(format!("{letter}{} has no place in such a program", word.digits)),
            },
        }
    }
    Ok(block)
}

fn once<'a>(place: &mut Option<Word<'a>>, word: Word<'a>) -> Result<(), String> {
    if place.is_some() {
        return Err(format!("{} stands twice in one block", word.letter));
    }
    *place = Some(word);
    Ok(())
}

/// A whole number of up to eight digits without a sign.
fn whole(word: Word<'_>) -> Result<u32, String> {
    let digits = word.digits;
    if digits.len() > 8 || digits.contains(|digit: char| !digit.is_ascii_digit()) {
        return Err(format!("{} takes a whole number, not {digits}", word.letter));
    }
    digits.parse().map_err(|_| format!("{} takes a whole number, not {digits}", word.letter))
}

/// A code without its leading zeros: `01` is `1`. `1.0` and `+1` stay what they are and are refused.
fn bare<'a>(word: Word<'a>) -> &'a str {
    let bare = word.digits.trim_start_matches('0');
    if bare.is_empty() { "0" } else { bare }
}

fn code(word: Word<'_>) -> Result<Code, String> {
    let bare = bare(word);
    if let Some(setting) = SETTINGS.iter().position(|(_, numbers)| numbers.contains(&bare)) {
        return Ok(Code::Setting(setting));
    }
    match bare {
        "0" => Ok(Code::Motion(Motion::Rapid)),
        "1" => Ok(Code::Motion(Motion::Straight)),
        "4" => Ok(Code::Dwell),
        "94" => Ok(Code::PerMinute),
        _ => Err(format!("G{} is refused: {}", word.digits, why_no_code(bare))),
    }
}

fn why_no_code(bare: &str) -> &'static str {
    match bare {
        "2" | "3" => "all cuts are straight moves",
        "20" => "lengths are in mm",
        "91" => "positions are absolute",
        "64" => "blending leaves the path that is proved",
        "95" => "times are proved, so the feed is inverse time (G93)",
        "10" | "52" | "53" | "54" | "55" | "56" | "57" | "58" | "59" | "92" => {
            "positions count from the machine's zero as it stands"
        }
        _ => "it has no place in such a program",
    }
}

fn add_code(codes: &mut Vec<Code>, code: Code, word: Word<'_>) -> Result<(), String> {
    let same_group = |other: &Code| match (code, *other) {
        (Code::Motion(_), Code::Motion(_)) | (Code::Dwell, Code::Dwell) => true,
        (Code::Setting(this), Code::Setting(other)) => this == other,
        (Code::PerMinute, Code::PerMinute | Code::Setting(INVERSE_TIME))
        | (Code::Setting(INVERSE_TIME), Code::PerMinute) => true,
        _ => false,
    };
    if codes.iter().any(same_group) {
        return Err(format!("G{} meets another word of its group in one block", word.digits));
    }
    codes.push(code);
    Ok(())
}

fn machine_function(m: Word<'_>, p: Option<Word<'_>>) -> Result<Action, String> {
    let bare = bare(m);
    match (bare, p) {
        ("64" | "65", Some(p)) => Ok(Action::Output { number: whole(p)?, on: bare == "64" }),
        ("64" | "65", None) => Err(format!("M{} needs P, the number of the output", m.digits)),
        ("1", None) => Ok(Action::OptionalStop),
        ("2", None) => Ok(Action::End),
        ("1" | "2", Some(_)) => Err("P belongs to G4, M64 or M65".to_owned()),
        _ => Err(format!("M{} is refused: {}", m.digits, why_no_function(bare))),
    }
}

fn why_no_function(bare: &str) -> &'static str {
    match bare {
        "62" | "63" => "it waits for the next motion, so that a knife would move while the tape does",
        "30" => "it exchanges pallets as well; a program ends with M2",
        _ => "it has no place in such a program",
    }
}

fn dwell(p: Option<Word<'_>>) -> Result<Action, String> {
    let p = p.ok_or("G4 needs P, the seconds")?;
    if p.value < 0.0 || p.digits.starts_with('-') {
        return Err("a dwell is not negative".to_owned());
    }
    Ok(Action::Dwell { seconds: p.value })
}

fn set(block: &Block<'_>, modal: &mut Modal) {
    for code in &block.codes {
        match *code {
            Code::Setting(setting) => {
                modal.settings[setting] = true;
                modal.per_minute &= setting != INVERSE_TIME;
            }
            Code::PerMinute => modal.per_minute = true,
            Code::Motion(motion) => modal.motion = Some(motion),
            Code::Dwell => {}
        }
    }
}

fn no_motion(block: &Block<'_>) -> Result<(), String> {
    if block.codes.iter().any(|code| matches!(code, Code::Motion(_))) {
        return Err("G0 and G1 need an axis in their block".to_owned());
    }
    if block.feed.is_some() {
        return Err("in inverse time (G93) an F without a motion has no effect".to_owned());
    }
    Ok(())
}

/// G94: F is the speed of the one axis that moves. Of several axes it would be that of a group of them only.
fn travel(axes: &[Option<f64>; 9], feed: Word<'_>) -> Result<Action, String> {
    let mut named = axes.iter().enumerate().filter_map(|(axis, target)| target.map(|target| (axis, target)));
    let (Some((axis, target)), None) = (named.next(), named.next()) else {
        return Err(
            "with a feed a minute (G94) an axis moves by itself; all others in inverse time".to_owned()
        );
    };
    if feed.value > 0.0 && feed.value.is_finite() {
        return Ok(Action::Travel { axis, target, per_minute: feed.value });
    }
    Err(format!("F{} is no speed", feed.digits))
}

fn motion(block: &Block<'_>, modal: &mut Modal) -> Result<Action, String> {
    check_settings(modal)?;
    let targets = block.axes;
    match (modal.motion, block.feed) {
        (None, _) => Err("axes stand here, but neither G0 nor G1 before them".to_owned()),
        (Some(Motion::Rapid), None) => Ok(Action::Move { targets, cruise_s: None }),
        (Some(Motion::Rapid), Some(_)) => Err("a rapid takes no F".to_owned()),
        (Some(Motion::Straight), None) => Err("in inverse time (G93) each G1 block needs its F".to_owned()),
        (Some(Motion::Straight), Some(feed)) if modal.per_minute => travel(&targets, feed),
        (Some(Motion::Straight), Some(feed)) => {
            Ok(Action::Move { targets, cruise_s: Some(cruise_time_s(feed)?) })
        }
    }
}

/// What is not set is said once, not at each of a million motions.
fn check_settings(modal: &mut Modal) -> Result<(), String> {
    let missing: Vec<_> =
        SETTINGS.iter().zip(modal.settings).filter(|(_, set)| !set).map(|((name, _), _)| *name).collect();
    if missing.is_empty() || modal.said_missing {
        return Ok(());
    }
    modal.said_missing = true;
    Err(format!("something moves before the text has set {}", missing.join(", ")))
}

/// G93: F is the inverse of the time in minutes.
fn cruise_time_s(feed: Word<'_>) -> Result<f64, String> {
    let seconds = 60.0 / feed.value;
    if feed.value > 0.0 && seconds.is_finite() {
        return Ok(seconds);
    }
    Err(format!("F{} gives no time", feed.digits))
}
