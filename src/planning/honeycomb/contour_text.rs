//! Contours as text: x and z of a point a line, blanks, commas or semicolons between them.

use crate::planning::document::files::comma_hint;
use crate::planning::finding::{Code, Finding};

/// The most points of a contour.
const MOST_POINTS: usize = 200_000;
/// So many faults of a file are named.
const MOST_FAULTS: usize = 20;
/// The largest coordinate in mm.
const LARGEST_MM: f64 = 100_000.0;

/// Reads a contour, x and z in mm.
///
/// Empty lines and what follows a `#` are passed over, and a first line without any digits: it names the columns. Lines
/// end with LF or CRLF.
///
/// # Errors
/// Every line that is no point (`WrongType`, at `NAME:LINE`), at most 20 of them; a text that is not UTF-8, or has too
/// many points.
pub fn read(name: &str, bytes: &[u8]) -> Result<Vec<[f64; 2]>, Vec<Finding>> {
    let refuse = |code, line: usize, words: String| Finding::error(code, format!("{name}:{line}"), words);
    let Ok(text) = std::str::from_utf8(bytes) else {
        return Err(vec![refuse(Code::WrongType, 1, "the file is not UTF-8 text".to_owned())]);
    };
    let (mut points, mut faults) = (Vec::new(), Vec::new());
    for (index, line) in text.trim_start_matches('\u{feff}').lines().enumerate() {
        let content = line.split('#').next().unwrap_or_default().trim();
        let names_columns = index == 0 && !content.contains(|c: char| c.is_ascii_digit());
        if content.is_empty() || names_columns {
            continue;
        }
        match point(content) {
            Ok(point) => points.push(point),
            Err(words) => {
                let words = format!("{words}{}", comma_hint(content));
                faults.push(refuse(Code::WrongType, index + 1, words));
            }
        }
        if points.len() > MOST_POINTS || faults.len() >= MOST_FAULTS {
            break;
        }
    }
    if points.len() > MOST_POINTS {
        faults.push(refuse(Code::WrongCount, 1, format!("has more than {MOST_POINTS} points")));
    }
    if faults.is_empty() { Ok(points) } else { Err(faults) }
}

fn point(content: &str) -> Result<[f64; 2], String> {
    let words: Vec<&str> = content
        .split(|c: char| c == ',' || c == ';' || c.is_whitespace())
        .filter(|word| !word.is_empty())
        .collect();
    let [x, z] = words.as_slice() else {
        return Err(format!("has {} numbers; a point has two, x and z in mm", words.len()));
    };
    let number = |word: &str| match word.parse::<f64>() {
        Ok(value) if value.abs() <= LARGEST_MM => Ok(value),
        _ => {
            let short: String = word.chars().take(20).collect();
            Err(format!("{short:?} is no number from -{LARGEST_MM} to {LARGEST_MM}"))
        }
    };
    Ok([number(x)?, number(z)?])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_usual_way_of_writing_points_is_read() {
        let text = "x,z\r\n0, 1.5\r\n# a comment\r\n1;2\r\n\r\n  2.0\t3e0 # the last one";
        assert_eq!(read("c.csv", text.as_bytes()).unwrap(), [[0.0, 1.5], [1.0, 2.0], [2.0, 3.0]]);
        assert_eq!(read("c.csv", b"").unwrap(), Vec::<[f64; 2]>::new());
    }

    #[test]
    fn every_line_that_is_no_point_is_named() {
        let faults = read("c.csv", b"0 0\n1\nnan 1\n1e9 2\n1 2 3\n").unwrap_err();
        let places: Vec<_> = faults.iter().map(|fault| fault.at.as_str()).collect();
        assert_eq!(places, ["c.csv:2", "c.csv:3", "c.csv:4", "c.csv:5"]);
        assert!(read("c.csv", &[0xff, 0xfe]).is_err());
        let comma = read("c.csv", b"1,5 2,5\n").unwrap_err();
        assert!(comma[0].message.contains("decimals are written with a point"), "{}", comma[0].message);
        assert!(!faults[3].message.contains("decimals"), "{}", faults[3].message);
    }
}
