//! One axis of a chart: from where to where it goes, where its ticks are, and how they are numbered.

use super::sheet::{NUMBER_MM, figure, round_step, text_width};

/// The largest number that a drawing shows. No length, time, angle or ratio of a job comes near it; what is larger,
/// or no number, is left out.
pub const LARGEST: f64 = 1e9;

/// The shortest stretch that an axis shows, over the largest number on it: below this the digits of the ticks
/// would be those of rounding.
const SHORTEST_SHARE: f64 = 1e-6;

/// The shortest stretch that an axis shows at all.
const SHORTEST: f64 = 1e-6;

/// Whether a number can be shown.
#[must_use]
pub fn is_shown(value: f64) -> bool {
    value.is_finite() && value.abs() <= LARGEST
}

/// An axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// What is measured, with its unit.
    pub words: String,
    /// Where it begins.
    pub low: f64,
    /// Where it ends, above `low`.
    pub high: f64,
    /// Its length in mm of the sheet.
    pub length_mm: f64,
    /// From one tick to the next: 1, 2 or 5 times a power of ten.
    step: f64,
}

impl Axis {
    /// An axis that begins and ends with a tick and holds all values that can be shown.
    #[must_use]
    pub fn fitted(
        words: &str,
        values: impl IntoIterator<Item = f64>,
        length_mm: f64,
        direction: Direction,
    ) -> Self {
        let mut axis = Self::between(words, range(values), length_mm, direction);
        let (low, high) = (axis.low, axis.high);
        loop {
            axis.low = (low / axis.step + ROUNDING).floor() * axis.step;
            axis.high = (high / axis.step - ROUNDING).ceil() * axis.step;
            // Ends that have moved out leave less room for each number; at last there are two ticks alone.
            if axis.place(axis.low + axis.step) >= apart_mm(&axis.ticks(), direction)
                || axis.ticks().len() < 3
            {
                return axis;
            }
            axis.step = tick_step(NEXT * axis.step);
        }
    }

    /// An axis from one number to another, which need not be round.
    #[must_use]
    pub fn between(words: &str, range: (f64, f64), length_mm: f64, direction: Direction) -> Self {
        let (low, high) = widened(range);
        let step = step_of((low, high), length_mm, direction);
        Self { words: words.to_owned(), low, high, length_mm, step }
    }

    /// How far along the axis a value stands, in mm of the sheet.
    #[must_use]
    pub fn place(&self, value: f64) -> f64 {
        (value - self.low) / (self.high - self.low) * self.length_mm
    }

    /// The numbers at which ticks stand, with their digits.
    #[must_use]
    pub fn ticks(&self) -> Vec<(f64, String)> {
        ticks((self.low, self.high), self.step)
    }

    /// How wide the widest number of a tick is, in mm of the sheet.
    #[must_use]
    pub fn widest(&self) -> f64 {
        widest(&self.ticks())
    }
}

/// Which way an axis goes on the sheet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    /// To the right: the width of its numbers decides how close ticks stand.
    Along,
    /// Upward: their height does.
    Up,
}

/// What divisions by a step may leave beside a whole number.
const ROUNDING: f64 = 1e-9;

/// The smallest and largest of the values that can be shown; 0 to 1 if there are none.
#[must_use]
pub fn range(values: impl IntoIterator<Item = f64>) -> (f64, f64) {
    let shown = values.into_iter().filter(|value| is_shown(*value));
    let both = shown.map(|value| (value, value));
    both.reduce(|one, other| (one.0.min(other.0), one.1.max(other.1))).unwrap_or((0.0, 1.0))
}

/// A range with some room at both ends, so that what reaches its ends does not touch the frame.
#[must_use]
pub fn with_room((low, high): (f64, f64)) -> (f64, f64) {
    const SHARE: f64 = 0.06;
    let room = SHARE * (high - low);
    (low - room, high + room)
}

/// A range with room between its ends.
fn widened((low, high): (f64, f64)) -> (f64, f64) {
    let bound = |value: f64| if is_shown(value) { value } else { 0.0 };
    let (low, high) = (bound(low).min(bound(high)), bound(low).max(bound(high)));
    let least = SHORTEST.max(SHORTEST_SHARE * low.abs().max(high.abs()));
    if high - low >= least {
        return (low, high);
    }
    // A level curve stands in the middle of a stretch in which its number can be read.
    let half = (0.05 * low.abs().max(high.abs())).max(0.5);
    (low - half, high + half)
}

/// The least step for which the numbers do not touch.
fn step_of(range: (f64, f64), length_mm: f64, direction: Direction) -> f64 {
    let closest = |apart_mm: f64| tick_step((range.1 - range.0) * (apart_mm / length_mm).min(1.0));
    let step = closest(apart_mm(&[], direction));
    closest(apart_mm(&ticks(range, step), direction))
}

/// How far ticks must be apart, in mm of the sheet.
fn apart_mm(ticks: &[(f64, String)], direction: Direction) -> f64 {
    const ALONG_MM: f64 = 14.0;
    const UP_MM: f64 = 6.0;
    const BETWEEN_NUMBERS_MM: f64 = 3.0;
    match direction {
        Direction::Up => UP_MM,
        Direction::Along => ALONG_MM.max(widest(ticks) + BETWEEN_NUMBERS_MM),
    }
}

/// Just above 1: from a round step to the next.
const NEXT: f64 = 1.01;

/// [`round_step`] for a number of any size.
fn tick_step(at_least: f64) -> f64 {
    let power = 10.0_f64.powi(at_least.log10().floor() as i32);
    power * round_step(at_least / power)
}

fn ticks((low, high): (f64, f64), step: f64) -> Vec<(f64, String)> {
    let decimals = (-(step.log10() + ROUNDING).floor()).max(0.0) as usize;
    let first = (low / step - ROUNDING).ceil() as i64;
    let last = (high / step + ROUNDING).floor() as i64;
    let tick = |index: i64| index as f64 * step;
    (first..=last).map(|index| (tick(index), figure(tick(index), decimals))).collect()
}

fn widest(ticks: &[(f64, String)]) -> f64 {
    ticks.iter().map(|(_, digits)| text_width(digits, NUMBER_MM)).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn digits(axis: &Axis) -> Vec<String> {
        axis.ticks().into_iter().map(|(_, digits)| digits).collect()
    }

    #[test]
    fn ticks_are_round_and_hold_the_values() {
        let axis = Axis::fitted("x in mm", [0.3, 84.9], 100.0, Direction::Along);
        assert_eq!(digits(&axis), ["0", "20", "40", "60", "80", "100"]);
        assert_eq!((axis.place(0.0), axis.place(100.0)), (0.0, 100.0));
        let axis = Axis::fitted("ratio", [-0.02, 0.031], 30.0, Direction::Up);
        assert_eq!(digits(&axis), ["-0.02", "0", "0.02", "0.04"]);
        let axis = Axis::between("x", (3.0, 88.0), 100.0, Direction::Along);
        assert_eq!((digits(&axis)[0].as_str(), axis.low), ("20", 3.0));
    }

    #[test]
    fn any_numbers_give_an_axis_whose_numbers_do_not_touch() {
        let cases: [&[f64]; 8] = [
            &[],
            &[f64::NAN, f64::INFINITY],
            &[5.0, 5.0],
            &[0.0],
            &[1e-9, 2e-9],
            &[-1e9, 1e9],
            &[1e8, 1e8 + 1.0],
            &[1e300, -1e300, 3.0],
        ];
        for values in cases {
            for length_mm in [40.0, 250.0] {
                let axis = Axis::fitted("x", values.iter().copied(), length_mm, Direction::Along);
                let ticks = axis.ticks();
                assert!(axis.low < axis.high && ticks.len() >= 2, "{values:?}: {ticks:?}");
                assert!(values.iter().filter(|v| is_shown(**v)).all(|v| *v >= axis.low && *v <= axis.high));
                let apart = axis.place(ticks[1].0) - axis.place(ticks[0].0);
                assert!(apart > axis.widest() || ticks.len() == 2, "{values:?}: {ticks:?}");
                assert!(ticks.windows(2).all(|pair| pair[0].1 != pair[1].1), "{ticks:?}");
            }
        }
    }
}
