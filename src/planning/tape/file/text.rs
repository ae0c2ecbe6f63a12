//! Traces and outlines as plain text (docs/files.md has the grammar).
//!
//! A line holds one point, its numbers separated by blanks or by commas; `#` begins a comment. In an outline a line
//! `loop` begins a further loop; in a trace a line `track N` begins a course. Nothing is guessed: a line that is
//! neither is a fault.

use std::borrow::Cow;

use super::faults::{Fault, Faults};
use crate::planning::document::files::comma_hint;
use crate::planning::document::shape::quoted;
use crate::planning::finding::{Code, Finding};
use crate::planning::tape::wire::{LARGEST_MM, LARGEST_NUMBER, MOST_LOOPS, MOST_POINTS, Track, TrackPoint};

/// A closed loop as it was read.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ReadLoop {
    /// The line at which it begins.
    pub line: u32,
    /// X, Y, Z in mm.
    pub points: Vec<[f64; 3]>,
    /// The line of each point.
    pub lines: Vec<u32>,
}

/// A course as it was read.
#[derive(Debug, Clone)]
pub struct ReadTrack {
    /// Its number and points.
    pub track: Track,
    /// The line of its `track`.
    pub line: u32,
    /// The line of each point.
    pub lines: Vec<u32>,
}

/// The mark with which some editors begin a text in UTF-8.
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// Reads the loops of an outline. There is at least one, which may be empty.
///
/// # Errors
/// Every line that is no point and no `loop`, at `NAME:LINE`: the first 100, and how many more there are.
pub fn read_loops(name: &str, bytes: &[u8]) -> Result<Vec<ReadLoop>, Vec<Finding>> {
    let mut faults = Faults::of(name);
    let mut loops: Vec<ReadLoop> = Vec::new();
    for (line, content) in text_lines(bytes, &mut faults) {
        if content.eq_ignore_ascii_case("loop") {
            loops.push(ReadLoop { line, ..ReadLoop::default() });
            continue;
        }
        match numbers::<3>(&content, &["x", "y", "z"]) {
            Ok(point) => add_point(&mut loops, line, point),
            Err((code, words)) => faults.push(Fault::new(code, line, words)),
        }
    }
    if loops.is_empty() {
        loops.push(ReadLoop { line: 1, ..ReadLoop::default() });
    }
    let sizes: Vec<_> = loops.iter().map(|read| (read.line, read.points.len())).collect();
    refuse_too_many("loop", &sizes, &mut faults);
    if faults.is_empty() { Ok(loops) } else { Err(faults.into_findings()) }
}

/// Adds a point to the last loop. The first one needs no word to begin.
fn add_point(loops: &mut Vec<ReadLoop>, line: u32, point: [f64; 3]) {
    if loops.is_empty() {
        loops.push(ReadLoop { line, ..ReadLoop::default() });
    }
    if let Some(last) = loops.last_mut() {
        last.points.push(point);
        last.lines.push(line);
    }
}

/// Refuses more loops or courses than are allowed, and too many points of one. `sizes` has the line of each at which it
/// begins and how many points it has.
fn refuse_too_many(what: &str, sizes: &[(u32, usize)], faults: &mut Faults<'_>) {
    if let Some((line, _)) = sizes.get(MOST_LOOPS) {
        let message = format!("the file has {} {what}s; {MOST_LOOPS} are allowed", sizes.len());
        faults.push(Fault::new(Code::WrongCount, *line, message));
    }
    for (line, points) in sizes.iter().filter(|(_, points)| *points > MOST_POINTS) {
        let message = format!("the {what} has {points} points; {MOST_POINTS} are allowed");
        faults.push(Fault::new(Code::WrongCount, *line, message));
    }
}

/// Reads the courses of a trace in laying order.
///
/// # Errors
/// Every line that is no point and no `track N`, and every point before the first of those, at `NAME:LINE`: the first
/// 100, and how many more there are; a file without a course.
pub fn read_tracks(name: &str, bytes: &[u8]) -> Result<Vec<ReadTrack>, Vec<Finding>> {
    let mut faults = Faults::of(name);
    let mut tracks: Vec<ReadTrack> = Vec::new();
    // After a course whose number is at fault, its points are not at fault too.
    let mut begun = false;
    for (line, content) in text_lines(bytes, &mut faults) {
        let course = track_line(&content);
        begun |= course.is_some();
        match course {
            Some(Ok(number)) => {
                let track = Track { number, points: Vec::new() };
                tracks.push(ReadTrack { track, line, lines: Vec::new() });
            }
            Some(Err((code, words))) => faults.push(Fault::new(code, line, words)),
            None => match track_point(&content, begun) {
                Ok(point) => add_track_point(&mut tracks, line, point),
                Err((code, words)) => faults.push(Fault::new(code, line, words)),
            },
        }
    }
    if !begun && faults.is_empty() {
        let message = "the file has no course; each begins with a line such as \"track 1\"";
        faults.push(Fault::new(Code::WrongCount, 1, message));
    }
    let sizes: Vec<_> = tracks.iter().map(|read| (read.line, read.lines.len())).collect();
    refuse_too_many("course", &sizes, &mut faults);
    if faults.is_empty() { Ok(tracks) } else { Err(faults.into_findings()) }
}

fn track_point(content: &str, begun: bool) -> Result<TrackPoint, (Code, String)> {
    let [x, y, z, nx, ny, nz] = numbers::<6>(content, &["x", "y", "z", "nx", "ny", "nz"])?;
    if !begun {
        let message = "a point before the first course; each begins with a line such as \"track 1\"";
        return Err((Code::MissingField, message.to_owned()));
    }
    Ok(TrackPoint { position: [x, y, z], normal: [nx, ny, nz] })
}

fn add_track_point(tracks: &mut [ReadTrack], line: u32, point: TrackPoint) {
    if let Some(last) = tracks.last_mut() {
        last.track.points.push(point);
        last.lines.push(line);
    }
}

/// The number of a line that begins a course; `None` for any other line.
fn track_line(content: &str) -> Option<Result<u32, (Code, String)>> {
    let mut words = content.split_whitespace();
    if !words.next()?.eq_ignore_ascii_case("track") {
        return None;
    }
    let (number, more) = (words.next().unwrap_or_default(), words.next());
    let value = number.parse::<u32>().ok().filter(|_| number.bytes().all(|byte| byte.is_ascii_digit()));
    Some(match value {
        Some(value) if more.is_none() && (1..=LARGEST_NUMBER).contains(&value) => Ok(value),
        Some(value) if more.is_none() => Err((
            Code::OutOfRange,
            format!("the number is {value}; it must lie between 1 and {LARGEST_NUMBER}"),
        )),
        _ => Err((Code::WrongType, format!("{} is no \"track\" and its number", quoted(content)))),
    })
}

/// The lines that hold something, without their comments, each with its number from 1.
fn text_lines<'a>(
    bytes: &'a [u8],
    faults: &mut Faults<'_>,
) -> impl Iterator<Item = (u32, Cow<'a, str>)> + use<'a> {
    let bytes = bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes);
    let other = other_form(bytes);
    if let Some(words) = other {
        faults.push(Fault::new(Code::UnreadableFile, 1, words));
    }
    let lines = if other.is_some() { &[] } else { bytes }.split(|byte| *byte == b'\n');
    lines.zip(1_u32..).filter_map(|(line, number)| {
        let end = line.iter().position(|byte| *byte == b'#').unwrap_or(line.len());
        // A comment may be in any encoding. What else is not UTF-8 is no number, and is quoted as such.
        let content = line[..end].trim_ascii();
        (!content.is_empty()).then(|| (number, String::from_utf8_lossy(content)))
    })
}

/// What a file is that is no text of points, in words: so that not each of its lines is called a fault.
fn other_form(bytes: &[u8]) -> Option<&'static str> {
    let mut lines = bytes.split(|byte| *byte == b'\n').map(<[u8]>::trim_ascii);
    if bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff") {
        Some("the file is a text in UTF-16; save it as plain text (ASCII or UTF-8)")
    } else if bytes.starts_with(super::dxf::BINARY_SENTINEL) {
        Some("the file is a binary DXF drawing; save it as ASCII DXF, under a name that ends in .dxf")
    } else if lines.next() == Some(b"0") && lines.next() == Some(b"SECTION") {
        Some("the file is a DXF drawing; give it a name that ends in .dxf")
    } else {
        None
    }
}

/// As many numbers as a point has. They are separated by commas if there is one in the line, else by blanks.
fn numbers<const N: usize>(content: &str, names: &[&str; N]) -> Result<[f64; N], (Code, String)> {
    if content.contains(',') {
        let read = exactly(content.split(',').map(str::trim), names);
        read.map_err(|(code, words)| (code, format!("{words}{}", comma_hint(content))))
    } else {
        exactly(content.split_ascii_whitespace(), names)
    }
}

fn exactly<'a, const N: usize>(
    words: impl Iterator<Item = &'a str>,
    names: &[&str; N],
) -> Result<[f64; N], (Code, String)> {
    let (mut values, mut count, mut fault) = ([0.0; N], 0, None);
    for word in words {
        match number(word) {
            Ok(value) if count < N => values[count] = value,
            Ok(_) => {}
            Err(words) => fault = fault.or(Some(words)),
        }
        count += 1;
    }
    if count != N && fault.as_ref().is_none_or(|(code, _)| *code != Code::WrongType) {
        let numbers = if count == 1 { "number" } else { "numbers" };
        let message = format!("has {count} {numbers}; a point has {N} here: {}", names.join(" "));
        return Err((Code::WrongCount, message));
    }
    fault.map_or(Ok(values), Err)
}

fn number(word: &str) -> Result<f64, (Code, String)> {
    match word.parse::<f64>() {
        Ok(value) if value.abs() <= LARGEST_MM => Ok(value),
        // Rust reads the words inf and NaN too; a number that is merely too large has digits.
        Ok(_) if word.contains(|c: char| c.is_ascii_digit()) => Err((
            Code::OutOfRange,
            format!("{} does not lie between -{LARGEST_MM} and {LARGEST_MM}", quoted(word)),
        )),
        _ if word.contains(';') => {
            let message =
                format!("{} is no number; blanks, tabs or a comma stand between numbers", quoted(word));
            Err((Code::WrongType, message))
        }
        _ => Err((Code::WrongType, format!("{} is no number", quoted(word)))),
    }
}

#[cfg(test)]
mod tests;
