//! The paper of a drawing: its heading, which names the view, its legend, its scale.

use super::View;
use super::axis::is_shown;
use super::mark::Mark;
use super::svg::{Anchor, Path, Spot, Svg, spot};
use crate::planning::program::number::fixed;
use crate::planning::tape::input::TapeInput;
use crate::planning::tape::machine::CutSide;

/// Width of every sheet in mm: A4 across. Its height is what the drawing needs.
pub const WIDTH_MM: f64 = 297.0;
/// Left free all around, in mm.
pub const MARGIN_MM: f64 = 10.0;
/// Width of what is drawn, in mm.
pub const INNER_MM: f64 = WIDTH_MM - 2.0 * MARGIN_MM;
/// What is smaller than this on the sheet, in mm, cannot be seen: a thirteenth of a pixel at 96 dpi.
pub const DOT_MM: f64 = 0.02;

/// Size of `title` texts in mm, as the style sheet has it.
pub const TITLE_MM: f64 = 5.0;
/// Size of texts without a class of their own.
pub const TEXT_MM: f64 = 3.2;
/// Size of `small` and `quiet` texts.
pub const SMALL_MM: f64 = 2.5;
/// Size of `number` texts.
pub const NUMBER_MM: f64 = 2.2;

/// Width of a letter over its height; a little more than that of any sans serif on average.
const LETTER_ASPECT: f64 = 0.56;

/// About how wide a text is, in mm: fonts differ from one reader to the next.
#[must_use]
pub fn text_width(text: &str, size_mm: f64) -> f64 {
    text.chars().count() as f64 * size_mm * LETTER_ASPECT
}

/// The smallest customary scale denominator that is not below `at_least`: 5 for 1:5, 0.5 for 2:1.
#[must_use]
pub fn scale_denominator(at_least: f64) -> f64 {
    let series: &[f64] = if at_least > 1.0 {
        &[1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0]
    } else {
        &[1.0, 2.0, 2.5, 5.0, 10.0]
    };
    round_up(at_least, series)
}

/// The smallest of 1, 2 and 5 times a power of ten that is not below `at_least`.
#[must_use]
pub fn round_step(at_least: f64) -> f64 {
    round_up(at_least, &[1.0, 2.0, 5.0, 10.0])
}

fn round_up(at_least: f64, series: &[f64]) -> f64 {
    /// Ply and tape lengths over sheet lengths stay within this, whatever a job says.
    const RANGE: (f64, f64) = (1e-3, 1e9);
    /// What the division by a power of ten may leave above a round number.
    const ROUNDING: f64 = 1e-9;
    let at_least = at_least.clamp(RANGE.0, RANGE.1);
    let power = 10.0_f64.powi(at_least.log10().floor() as i32);
    let mantissa = at_least / power - ROUNDING;
    let round = series.iter().copied().find(|&candidate| candidate >= mantissa);
    round.unwrap_or(10.0) * power
}

/// `1:5`, or `2:1`.
#[must_use]
pub fn scale_text(denominator: f64) -> String {
    if denominator < 1.0 {
        format!("{}:1", plain(1.0 / denominator))
    } else {
        format!("1:{}", plain(denominator))
    }
}

/// How courses are named on the sheet of a roll that holds several plies.
pub fn plies_words(input: &TapeInput) -> Option<String> {
    let plies = input.plies.len();
    (plies > 1).then(|| format!("{plies} plies on one roll: 2/5 is course 5 of ply 2."))
}

/// A number for people: at most three decimals, no zeros after them.
#[must_use]
pub fn plain(value: f64) -> String {
    figure(value, 3)
}

/// A number that may be anything, for people: so many decimals, no zeros after them; a dash for what is none or is
/// larger than anything that is drawn.
#[must_use]
pub fn figure(value: f64, decimals: usize) -> String {
    if !is_shown(value) {
        return "\u{2013}".to_owned();
    }
    let text = fixed(value, decimals);
    text.strip_suffix(".0").map(str::to_owned).unwrap_or(text)
}

/// A text in lines that are no wider than a sheet; a word that is wider has a line of its own.
#[must_use]
pub fn wrapped(text: &str, size_mm: f64, width_mm: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split(' ') {
        match lines.last_mut() {
            Some(line) if text_width(line, size_mm) + text_width(word, size_mm) + size_mm <= width_mm => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

/// What stands at the top of a sheet.
#[derive(Debug, Clone, PartialEq)]
pub struct Heading {
    /// What is drawn.
    pub title: String,
    /// What should be known of it, a line each.
    pub lines: Vec<String>,
}

/// The words that say from where a drawing is seen.
#[must_use]
pub fn view_words(view: View, input: &TapeInput) -> String {
    let (knife_side, back) = match input.machine.cut_side {
        CutSide::Film => ("film", "backing paper"),
        CutSide::Paper => ("backing paper", "film"),
    };
    match view {
        View::FromBelow => format!(
            "SEEN FROM BELOW: U to the right, V up. You look at the {back}; the knives go down toward you from the far side ({knife_side})."
        ),
        View::Operator => format!(
            "OPERATOR'S VIEW, from above: U to the right, V down. You look at the side on which the knives work ({knife_side})."
        ),
    }
}

/// Draws the heading of a sheet that shows tape and gives the y below it.
pub fn draw_heading(svg: &mut Svg, heading: &Heading, view: View, input: &TapeInput) -> f64 {
    let y = draw_title(svg, &heading.title, &[view_words(view, input)], &heading.lines);
    draw_axes(svg, view);
    y
}

/// Draws a title, lines that say from where something is seen, further lines, and gives the y below.
pub fn draw_title(svg: &mut Svg, title: &str, seen: &[String], lines: &[String]) -> f64 {
    const LINE_MM: f64 = 4.5;
    let mut y = MARGIN_MM + 4.0;
    svg.text("title", spot(MARGIN_MM, y), Anchor::Start, title);
    y += 1.5;
    let seen = seen.iter().map(|line| ("view head", line));
    for (class, line) in seen.chain(lines.iter().map(|line| ("", line))) {
        y += LINE_MM;
        svg.text(class, spot(MARGIN_MM, y), Anchor::Start, line);
    }
    y + 4.0
}

/// The directions of U and V, in the upper right corner.
fn draw_axes(svg: &mut Svg, view: View) {
    const LENGTH_MM: f64 = 9.0;
    let down = view.v_down();
    let origin = spot(WIDTH_MM - MARGIN_MM - LENGTH_MM - 4.0, MARGIN_MM + LENGTH_MM * (1.0 - down) / 2.0);
    let tip = spot(origin.x, origin.y + down * LENGTH_MM);
    svg.group("axes", "", |svg| {
        draw_arrow(svg, origin, spot(origin.x + LENGTH_MM, origin.y));
        draw_arrow(svg, origin, tip);
        svg.text("head", spot(origin.x + LENGTH_MM + 1.0, origin.y + 1.1), Anchor::Start, "U");
        svg.text("head", spot(tip.x - 1.5, tip.y - down * 1.5 + 1.1), Anchor::End, "V");
    });
}

/// Draws an arrow.
pub fn draw_arrow(svg: &mut Svg, from: Spot, to: Spot) {
    const HEAD_MM: f64 = 1.8;
    const HALF_HEAD_MM: f64 = 0.6;
    let (dx, dy) = (to.x - from.x, to.y - from.y);
    let length = dx.hypot(dy).max(DOT_MM);
    let (dx, dy) = (dx / length, dy / length);
    let neck = spot(to.x - HEAD_MM * dx, to.y - HEAD_MM * dy);
    let side = |sign: f64| spot(neck.x - sign * HALF_HEAD_MM * dy, neck.y + sign * HALF_HEAD_MM * dx);
    svg.line("line", from, neck);
    let mut head = Path::default();
    head.closed([side(1.0), to, side(-1.0)]);
    svg.path("solid", &head, "");
}

/// A sample in a legend.
#[derive(Debug, Clone, PartialEq)]
pub enum Sample {
    /// A cut of that cutter, from 0.
    Cut(usize),
    /// A line of that class.
    Line(&'static str),
    /// Something hatched with the hatching of that id.
    Hatched(String),
    /// A place where that cutter goes down or comes up.
    Knife(usize, bool),
    /// A disc of that class.
    Disc(&'static str),
    /// An area of that class.
    Area(&'static str),
    /// A mark in that colour.
    Mark(Mark, &'static str),
}

/// Draws a legend in lines as long as the sheet and gives the y below it.
pub fn draw_legend(svg: &mut Svg, y: f64, entries: &[(Sample, String)]) -> f64 {
    const SAMPLE_MM: f64 = 8.0;
    const LINE_MM: f64 = 4.5;
    let mut at = spot(MARGIN_MM, y);
    svg.group("legend", "", |svg| {
        for (sample, words) in entries {
            let width = SAMPLE_MM + 1.5 + text_width(words, SMALL_MM) + 4.0;
            if at.x + width > WIDTH_MM && at.x > MARGIN_MM {
                at = spot(MARGIN_MM, at.y + LINE_MM);
            }
            draw_sample(svg, sample, at, SAMPLE_MM);
            svg.text("small", spot(at.x + SAMPLE_MM + 1.5, at.y + 0.9), Anchor::Start, words);
            at.x += width;
        }
    });
    at.y + LINE_MM
}

fn draw_sample(svg: &mut Svg, sample: &Sample, at: Spot, width: f64) {
    let middle = spot(at.x + width / 2.0, at.y);
    match sample {
        Sample::Cut(cutter) => svg.line(&cut_class(*cutter), at, spot(at.x + width, at.y)),
        Sample::Line(class) => svg.line(class, at, spot(at.x + width, at.y)),
        Sample::Hatched(id) => svg.hatched_rect(id, spot(at.x, at.y - 1.5), width, 3.0),
        Sample::Knife(cutter, down) => draw_knife(svg, *cutter, *down, middle),
        Sample::Disc(class) => svg.disc(class, middle, EDGE_POINT_MM),
        Sample::Area(class) => svg.rect(class, spot(at.x, at.y - 1.5), width, 3.0),
        Sample::Mark(mark, ink) => mark.draw(svg, ink, middle),
    }
}

/// Radius of the disc that marks an Edge0 or Edge1.
pub const EDGE_POINT_MM: f64 = 0.7;

/// Classes of a cut of a cutter, from 0: its colour and its line style.
#[must_use]
pub fn cut_class(cutter: usize) -> String {
    format!("cut cutter-{}", cutter + 1)
}

/// Draws the place where a knife goes down (full) or comes up (hollow): a disc for cutter 1, a square for cutter 2.
/// The square is the larger one, so that both can be seen at one place.
pub fn draw_knife(svg: &mut Svg, cutter: usize, down: bool, at: Spot) {
    const RADIUS_MM: f64 = 0.75;
    const HALF_SQUARE_MM: f64 = 1.05;
    let class = format!("{} cutter-{}", if down { "down" } else { "up" }, cutter + 1);
    if cutter == 0 {
        svg.disc(&class, at, RADIUS_MM);
    } else {
        let corner = spot(at.x - HALF_SQUARE_MM, at.y - HALF_SQUARE_MM);
        svg.rect(&class, corner, 2.0 * HALF_SQUARE_MM, 2.0 * HALF_SQUARE_MM);
    }
}

/// Draws a bar of a round length with its scale and gives the x behind it.
pub fn draw_scale_bar(svg: &mut Svg, at: Spot, denominator: f64, words: &str) -> f64 {
    const SHORTEST_MM: f64 = 15.0;
    let length = round_step(SHORTEST_MM * denominator);
    let end = spot(at.x + length / denominator, at.y);
    svg.group("scale-bar", "", |svg| {
        svg.line("line", at, end);
        for tick in [at, end] {
            svg.line("line", spot(tick.x, tick.y - 1.0), spot(tick.x, tick.y + 1.0));
        }
        let words = format!("{} mm, {words} {}", plain(length), scale_text(denominator));
        svg.text("small", spot(end.x + 1.5, at.y + 0.9), Anchor::Start, &words);
        end.x + 1.5 + text_width(&words, SMALL_MM)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_number_can_be_written() {
        assert_eq!(
            [12.5, 12.0, -0.0001, f64::NAN].map(|value| figure(value, 3)),
            ["12.5", "12", "0", "\u{2013}"]
        );
    }

    #[test]
    fn a_long_text_is_wrapped_between_words() {
        let text = "the quick brown fox jumps over the lazy dog ".repeat(9);
        let lines = wrapped(text.trim(), TEXT_MM, 100.0);
        assert!(lines.len() > 5 && lines.iter().all(|line| text_width(line, TEXT_MM) <= 100.0), "{lines:?}");
        assert_eq!(lines.join(" "), text.trim());
        assert_eq!(wrapped("unbreakable", TEXT_MM, 1.0), ["unbreakable"]);
    }

    #[test]
    fn scales_are_customary_and_never_too_large() {
        for (at_least, text) in [
            (5.0, "1:5"),
            (5.1, "1:6"),
            (0.9, "1:1"),
            (0.26, "2:1"),
            (0.21, "4:1"),
            (9.0, "1:10"),
            (81.0, "1:100"),
        ] {
            assert_eq!(scale_text(scale_denominator(at_least)), text);
        }
        for hostile in [0.0, -1.0, 1e300, 1e-300] {
            assert!(scale_denominator(hostile) > 0.0 && scale_denominator(hostile) <= 1e9);
        }
    }
}
