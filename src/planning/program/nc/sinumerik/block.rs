//! The meaning of one block under the settings made so far, and under the words of the profile.

use super::super::super::events::AXIS_LETTERS;
use super::word::Word;
use crate::planning::tape::machine::Machine;

/// What a block does.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Action {
    /// Axes go to targets, in the order of `AXIS_LETTERS`; as a rapid if there is no time.
    Move { targets: [Option<f64>; 9], cruise_s: Option<f64> },
    /// One axis alone goes to a target at a speed, in mm or degrees a minute (G94).
    Alone { axis: usize, target: f64, speed: f64 },
    /// A word of the profile's table, as the output that it stands for.
    Output { number: u32, on: bool },
    /// G4.
    Dwell { seconds: f64 },
    /// The stop that the operator can switch on.
    OptionalStop,
    /// M30.
    End,
}

/// What must be set before anything moves: the words that set it, and what it is.
const NEEDED: [(&str, &str); 8] = [
    ("G710", "mm, for feeds too"),
    ("G90", "absolute positions"),
    ("G17", "plane XY"),
    ("G40", "no cutter compensation"),
    ("G500", "no work offset"),
    ("D0", "no tool offset"),
    ("G60", "exact stop"),
    ("G93", "inverse time"),
];

/// The place of G93 in [`NEEDED`].
const INVERSE_TIME: usize = 7;

/// What the blocks so far have set.
#[derive(Debug, Clone, Default)]
pub(super) struct Settings {
    made: [bool; NEEDED.len()],
    grouped: bool,
    /// Whether G1, not G0, was the last; none before either.
    straight: Option<bool>,
    /// Whether F is a speed (G94), until the next G93.
    speeds: bool,
    said: bool,
}

/// The words of a block, sorted.
#[derive(Default)]
struct Sorted<'a> {
    axes: [Option<f64>; 9],
    feed: Option<f64>,
    motion: Option<bool>,
    dwell: bool,
    set: Vec<usize>,
    speeds: bool,
    group: Option<&'a str>,
    auxiliary: Option<String>,
}

/// What a block does; nothing if it only sets something.
///
/// # Errors
/// Words that do not belong together or mean nothing here.
pub(super) fn interpret(
    words: &[Word<'_>],
    machine: &Machine,
    settings: &mut Settings,
) -> Result<Option<Action>, String> {
    let block = sort(words)?;
    let moves = block.axes.iter().any(Option::is_some);
    let alone = usize::from(moves || block.motion.is_some())
        + usize::from(block.dwell)
        + usize::from(!block.set.is_empty())
        + usize::from(block.speeds)
        + usize::from(block.group.is_some())
        + usize::from(block.auxiliary.is_some());
    if alone > 1 {
        return Err(
            "motions, dwells, settings, FGROUP and M or H words stand in blocks of their own".to_owned()
        );
    }
    if let Some(word) = &block.auxiliary {
        return auxiliary(word, machine, block.feed).map(Some);
    }
    if block.dwell {
        let seconds = block.feed.filter(|seconds| *seconds >= 0.0).ok_or("G4 needs F, the seconds")?;
        return Ok(Some(Action::Dwell { seconds }));
    }
    if moves || block.motion.is_some() {
        return motion(&block, moves, settings).map(Some);
    }
    if block.feed.is_some() {
        return Err("in inverse time (G93) an F without a motion has no effect".to_owned());
    }
    if let Some(letters) = block.group {
        check_group(letters, machine)?;
        settings.grouped = true;
    }
    block.set.iter().for_each(|&index| settings.made[index] = true);
    settings.speeds = block.speeds || (settings.speeds && !block.set.contains(&INVERSE_TIME));
    Ok(None)
}

fn sort<'a>(words: &[Word<'a>]) -> Result<Sorted<'a>, String> {
    let mut block = Sorted::default();
    for (index, word) in words.iter().enumerate() {
        let (letter, digits, value) = match *word {
            Word::Group(letters) if block.group.is_none() => {
                block.group = Some(letters);
                continue;
            }
            Word::Group(_) => return Err("FGROUP stands twice in one block".to_owned()),
            Word::Number { letter, digits, value } => (letter, digits, value),
        };
        let twice = || Err(format!("{letter} stands twice in one block"));
        match letter {
            'N' if index == 0 && whole(digits) => {}
            'N' => return Err("N and a whole number stand first in their block, or not at all".to_owned()),
            'G' | 'D' => take_setting(&mut block, letter, digits)?,
            'M' | 'H' if !whole(digits) => {
                return Err(format!("{letter} takes a whole number, not {digits}"));
            }
            'M' | 'H' if block.auxiliary.is_some() => return twice(),
            'M' | 'H' => block.auxiliary = Some(format!("{letter}{digits}")),
            'F' if block.feed.is_some() => return twice(),
            'F' => block.feed = Some(value),
            _ => match AXIS_LETTERS.iter().position(|&axis| axis == letter) {
                Some(axis) if block.axes[axis].is_some() => return twice(),
                Some(axis) => block.axes[axis] = Some(value),
                None => return Err(format!("{letter}{digits} has no place in such a program")),
            },
        }
    }
    Ok(block)
}

fn whole(digits: &str) -> bool {
    digits.len() <= 8 && digits.bytes().all(|digit| digit.is_ascii_digit())
}

fn take_setting(block: &mut Sorted<'_>, letter: char, digits: &str) -> Result<(), String> {
    let word = format!("{letter}{digits}");
    match word.as_str() {
        "G0" | "G1" if block.motion.is_some() => Err("G0 and G1 stand once in a block".to_owned()),
        "G0" | "G1" => {
            block.motion = Some(word == "G1");
            Ok(())
        }
        "G4" => {
            block.dwell = true;
            Ok(())
        }
        "G94" if block.speeds => Err("G94 stands twice in one block".to_owned()),
        "G94" => {
            block.speeds = true;
            Ok(())
        }
        _ => {
            let index = NEEDED.iter().position(|(needed, _)| *needed == word);
            block.set.push(index.ok_or_else(|| format!("{word} is refused: {}", why_not(&word)))?);
            Ok(())
        }
    }
}

fn why_not(word: &str) -> &'static str {
    match word {
        "G2" | "G3" => "all cuts are straight moves",
        "G70" | "G71" | "G700" => "lengths and feeds are metric (G710)",
        "G91" => "positions are absolute",
        "G64" | "G641" | "G642" | "G643" | "G644" | "G645" => "blending leaves the path that is proved",
        "G95" => "times are proved, so the feed is inverse time (G93)",
        "G54" | "G55" | "G56" | "G57" | "G53" | "G153" => {
            "positions count from the machine's zero as it stands"
        }
        _ => "it has no place in such a program",
    }
}

fn auxiliary(word: &str, machine: &Machine, feed: Option<f64>) -> Result<Action, String> {
    if feed.is_some() {
        return Err(format!("F does not belong to {word}"));
    }
    if word == "M30" {
        return Ok(Action::End);
    }
    let words = machine.words.as_ref().ok_or("the profile names no words")?;
    if word == words.optional_stop {
        return Ok(Action::OptionalStop);
    }
    let knives =
        words.knives.iter().zip(&machine.cutters).map(|(words, cutter)| (words, cutter.knife_output));
    let mut table = knives.chain([(&words.ultrasonic, machine.ultrasonic_output)]);
    let found = table.find_map(|(words, number)| {
        let place = words.iter().position(|other| other == word)?;
        Some(Action::Output { number, on: place == 0 })
    });
    found.ok_or_else(|| format!("{word} is no word of this machine's profile"))
}

/// Every axis of the machine must be in the group: a block without one of its axes would take its time from elsewhere.
fn check_group(letters: &str, machine: &Machine) -> Result<(), String> {
    let named: Vec<&str> = letters.split(',').map(str::trim).collect();
    let lateral = machine.cutters.iter().map(|cutter| cutter.lateral_axis);
    let blades = machine.cutters.iter().map(|cutter| cutter.blade_axis);
    for axis in std::iter::once(machine.feed.axis).chain(lateral).chain(blades) {
        if !named.contains(&axis.to_string().as_str()) {
            return Err(format!("FGROUP leaves out axis {axis}"));
        }
    }
    Ok(())
}

fn motion(block: &Sorted<'_>, moves: bool, settings: &mut Settings) -> Result<Action, String> {
    if !moves {
        return Err("G0 and G1 need an axis in their block".to_owned());
    }
    settings.straight = block.motion.or(settings.straight);
    check_settings(settings)?;
    let targets = block.axes;
    match (settings.straight, block.feed) {
        (None, _) => Err("axes stand here, but neither G0 nor G1 before them".to_owned()),
        (Some(false), None) => Ok(Action::Move { targets, cruise_s: None }),
        (Some(false), Some(_)) => Err("a rapid takes no F".to_owned()),
        (Some(true), None) => Err("in inverse time (G93) each G1 block needs its F".to_owned()),
        (Some(true), Some(feed)) if settings.speeds => alone(&targets, feed),
        (Some(true), Some(feed)) => {
            let seconds = 60.0 / feed;
            if feed > 0.0 && seconds.is_finite() {
                return Ok(Action::Move { targets, cruise_s: Some(seconds) });
            }
            Err(format!("F{feed} gives no time"))
        }
    }
}

/// Of several axes F would be the speed of their common path, and what a degree counts there is a setting.
fn alone(targets: &[Option<f64>; 9], speed: f64) -> Result<Action, String> {
    let named: Vec<usize> = (0..targets.len()).filter(|&axis| targets[axis].is_some()).collect();
    match (named.as_slice(), targets.iter().flatten().next()) {
        (&[axis], Some(&target)) if speed > 0.0 && speed.is_finite() => {
            Ok(Action::Alone { axis, target, speed })
        }
        ([_], _) => Err(format!("F{speed} is no speed")),
        _ => Err("under G94 an axis moves by itself; several move in inverse time (G93)".to_owned()),
    }
}

/// What is not set is said once, not at each of a million motions.
fn check_settings(settings: &mut Settings) -> Result<(), String> {
    let made = NEEDED.iter().zip(settings.made);
    let mut missing: Vec<String> =
        made.filter(|(_, made)| !made).map(|((word, what), _)| format!("{what} ({word})")).collect();
    if !settings.grouped {
        missing.push("the axes of the path (FGROUP)".to_owned());
    }
    if missing.is_empty() || std::mem::replace(&mut settings.said, true) {
        return Ok(());
    }
    Err(format!("something moves before the text has set {}", missing.join(", ")))
}
