//! A planted trace as text, and back (docs/tape-machine.md has the grammar).
//!
//! ```text
//! trace  = "BLADEPLAN-TRACE 1" course*
//! course = "COURSE" number ["PLY" ply]  ("P" x y z nx ny nz)+  stroke*  "END"
//! stroke = "DOWN" piece cutter u v  ("CUT" u v blade feed)+  "UP"
//! ```
//!
//! A line each. Blank lines and what follows `#` count nothing.

use super::{DECIMALS, PLACE_DECIMALS, PlantedTrace, TraceCourse, TraceCut, TraceStroke};
use crate::planning::program::number::write_fixed;

/// The first line.
const HEADER: &str = "BLADEPLAN-TRACE 1";

/// Writes a trace. Lines end with LF.
#[must_use]
pub fn write(trace: &PlantedTrace) -> String {
    let mut text = format!("{HEADER}\n");
    for course in &trace.courses {
        let ply = course.ply.map_or(String::new(), |ply| format!(" PLY {ply}"));
        text.push_str(&format!("COURSE {}{ply}\n", course.number));
        for point in &course.points {
            write_line("P", point, PLACE_DECIMALS, &mut text);
        }
        for stroke in &course.strokes {
            write_stroke(stroke, &mut text);
        }
        text.push_str("END\n");
    }
    text
}

fn write_stroke(stroke: &TraceStroke, text: &mut String) {
    let down = format!("DOWN {} {}", stroke.piece, stroke.cutter);
    write_line(&down, &stroke.down, DECIMALS, text);
    for cut in &stroke.cuts {
        write_line("CUT", &[cut.to[0], cut.to[1], cut.blade_deg, cut.feed_mm_s], DECIMALS, text);
    }
    text.push_str("UP\n");
}

fn write_line(word: &str, values: &[f64], decimals: usize, text: &mut String) {
    text.push_str(word);
    for value in values {
        text.push(' ');
        write_fixed(*value, decimals, text);
    }
    text.push('\n');
}

/// Reads a trace back.
///
/// # Errors
/// The first line that does not fit, with its number.
pub fn read(text: &str) -> Result<PlantedTrace, String> {
    let mut reader = Reader { trace: PlantedTrace { courses: Vec::new() }, part: Part::Front };
    for (index, line) in text.lines().enumerate() {
        let line = line.split_once('#').map_or(line, |(line, _)| line).trim();
        if !line.is_empty() {
            reader.take(line).map_err(|why| format!("line {}: {why}", index + 1))?;
        }
    }
    match reader.part {
        Part::Between => Ok(reader.trace),
        _ => Err("the text stops in the middle: it may be cut short".to_owned()),
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Part {
    Front,
    Between,
    Course,
    Stroke,
}

struct Reader {
    trace: PlantedTrace,
    part: Part,
}

impl Reader {
    fn take(&mut self, line: &str) -> Result<(), String> {
        let (word, rest) = line.split_once(' ').unwrap_or((line, ""));
        match (self.part, word) {
            (Part::Front, _) if line == HEADER => self.part = Part::Between,
            (Part::Front, _) => return Err(format!("a planted trace begins with {HEADER}")),
            (Part::Between, "COURSE") => {
                let (number, ply) = match rest.split_once(" PLY ") {
                    Some((number, ply)) => (number, Some(whole(ply)?)),
                    None => (rest, None),
                };
                let number = whole(number)?;
                self.trace.courses.push(TraceCourse { ply, number, points: Vec::new(), strokes: Vec::new() });
                self.part = Part::Course;
            }
            (Part::Course, "P") if self.course().strokes.is_empty() => {
                let point = values(rest)?;
                self.course().points.push(point);
            }
            (Part::Course, "DOWN") => self.down(rest)?,
            (Part::Course, "END") if rest.is_empty() => self.part = Part::Between,
            (Part::Stroke, "CUT") => self.cut(rest)?,
            (Part::Stroke, "UP") if rest.is_empty() => {
                if self.stroke().is_none_or(|stroke| stroke.cuts.is_empty()) {
                    return Err("a knife comes up without having cut".to_owned());
                }
                self.part = Part::Course;
            }
            _ => return Err(format!("{word} has no place here")),
        }
        Ok(())
    }

    fn course(&mut self) -> &mut TraceCourse {
        self.trace.courses.last_mut().expect("this part is reached by COURSE alone")
    }

    fn stroke(&mut self) -> Option<&mut TraceStroke> {
        self.course().strokes.last_mut()
    }

    fn down(&mut self, rest: &str) -> Result<(), String> {
        let words: Vec<&str> = rest.splitn(3, ' ').collect();
        let [piece, cutter, place] = words[..] else {
            return Err("DOWN takes piece, cutter, u and v".to_owned());
        };
        let stroke = TraceStroke {
            piece: whole(piece)? as usize,
            cutter: whole(cutter)?,
            down: values(place)?,
            cuts: Vec::new(),
        };
        self.course().strokes.push(stroke);
        self.part = Part::Stroke;
        Ok(())
    }

    fn cut(&mut self, rest: &str) -> Result<(), String> {
        let [u, v, blade_deg, feed_mm_s] = values(rest)?;
        if let Some(stroke) = self.stroke() {
            stroke.cuts.push(TraceCut { to: [u, v], blade_deg, feed_mm_s });
        }
        Ok(())
    }
}

fn whole(word: &str) -> Result<u32, String> {
    word.trim().parse().map_err(|_| format!("{word:?} is no whole number"))
}

fn values<const N: usize>(rest: &str) -> Result<[f64; N], String> {
    let read = |word: &str| word.parse().ok().filter(|value: &f64| value.is_finite());
    let words: Option<Vec<f64>> = rest.split_whitespace().map(read).collect();
    let words = words.ok_or_else(|| format!("{rest:?} holds something that is no number"))?;
    words.try_into().map_err(|words: Vec<f64>| format!("{N} numbers are needed, {} stand here", words.len()))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "BLADEPLAN-TRACE 1\nCOURSE 7\nP 0.0 1.5 -2.25 0.0 0.0 1.0\nDOWN 1 2 400.0 0.0\n\
                        CUT 362.5 37.5 45.0 14.1421\nUP\nEND\n";

    #[test]
    fn what_is_written_is_read_back() {
        let trace = read(TEXT).unwrap();
        assert_eq!(trace.courses[0].points, [[0.0, 1.5, -2.25, 0.0, 0.0, 1.0]]);
        let stroke = &trace.courses[0].strokes[0];
        assert_eq!((stroke.piece, stroke.cutter, stroke.down), (1, 2, [400.0, 0.0]));
        let cut = TraceCut { to: [362.5, 37.5], blade_deg: 45.0, feed_mm_s: 14.1421 };
        assert_eq!(stroke.cuts, [cut]);
        assert_eq!(write(&trace), TEXT);
        let of_ply = TEXT.replace("COURSE 7", "COURSE 7 PLY 2");
        let trace_of_ply = read(&of_ply).unwrap();
        assert_eq!((trace_of_ply.courses[0].ply, trace_of_ply.courses[0].number), (Some(2), 7));
        assert_eq!(write(&trace_of_ply), of_ply);
        assert_eq!(read(&TEXT.replace('\n', " # said\r\n\n")).unwrap(), trace);
    }

    #[test]
    fn each_fault_is_told_with_its_line() {
        for (from, to, told) in [
            ("BLADEPLAN-TRACE 1", "COURSE 1", "line 1: a planted trace begins"),
            ("COURSE 7", "COURSE x", "line 2: \"x\" is no whole number"),
            ("COURSE 7", "COURSE 7 PLY two", "line 2: \"two\" is no whole number"),
            ("COURSE 7", "COURSE 7 2", "line 2: \"7 2\" is no whole number"),
            ("P 0.0 1.5 -2.25 0.0 0.0 1.0", "P 0 1 2", "line 3: 6 numbers are needed, 3 stand here"),
            ("P 0.0", "P inf", "line 3: \"inf"),
            ("DOWN 1 2 400.0 0.0", "DOWN 1 2", "line 4: DOWN takes"),
            ("CUT 362.5 37.5 45.0 14.1421\n", "", "line 5: a knife comes up"),
            ("UP\n", "", "line 6: END has no place here"),
            ("END\n", "", "the text stops in the middle"),
            ("UP\n", "UP\nP 0 0 0 0 0 1\n", "line 7: P has no place here"),
        ] {
            let fault = read(&TEXT.replacen(from, to, 1)).unwrap_err();
            assert!(fault.starts_with(told), "{fault}");
        }
    }
}
