//! How like a cut contour is to the wanted one: both curves with their deviation (the paper's Fig. 14), and their
//! normalised cross-correlation (its Fig. 15).

use super::axis::{Axis, Direction, range, with_room};
use super::chart::{ABOVE_MM, BELOW_MM, Chart, LEFT_MM};
use super::label::baseline;
use super::mark::Mark;
use super::page::Page;
use super::sheet::{INNER_MM, MARGIN_MM, SMALL_MM, Sample, figure, text_width};
use super::svg::{Anchor, Svg, spot};
use crate::planning::geometry::Point2;
use crate::planning::honeycomb::contour::{Likeness, Samples, distance};
use crate::planning::outcome::Drawing;

/// Where the cut contour comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Origin {
    /// From the section of a program.
    Simulated,
    /// Measured on a part.
    Measured,
}

/// Height of the chart of both contours in mm of the sheet.
const CURVES_MM: f64 = 72.0;
/// Height of the chart of deviations.
const DEVIATION_MM: f64 = 36.0;
/// Height of the chart of the correlation.
const CORRELATION_MM: f64 = 118.0;

impl Origin {
    fn words(self) -> &'static str {
        match self {
            Self::Simulated => "simulated",
            Self::Measured => "measured",
        }
    }

    fn file_name(self, drawing: &str) -> String {
        match self {
            Self::Simulated => drawing.to_owned(),
            Self::Measured => format!("{drawing}-measured"),
        }
    }
}

/// Wanted and cut contour, and the deviation: `contour.svg`, or `contour-measured.svg`.
#[must_use]
pub fn contours(likeness: &Likeness, origin: Origin) -> Drawing {
    let samples = &likeness.samples;
    let (wanted, cut) = (curve(samples, &samples.wanted), curve(samples, &samples.cut));
    let deviation = deviations(&wanted, &cut);
    let lines = [
        format!(
            "Finished contour as wanted and as {}, each at {} places from x {} to {} mm, seen along +y.",
            origin.words(),
            wanted.len(),
            figure(samples.range.0, 2),
            figure(samples.range.1, 2)
        ),
        format!(
            "Largest deviation {} mm, at x {} mm. Deviation: distance to the nearest point of the wanted contour; below 0 where too much is cut.",
            figure(likeness.max_deviation_mm, 3),
            figure(likeness.max_deviation_x_mm, 2)
        ),
    ];
    let mut page = Page::new(&format!("Wanted and {} contour", origin.words()), "", &lines);
    page.legend(&[
        (Sample::Line("finished"), "wanted".to_owned()),
        (Sample::Line("curve stroke-2"), origin.words().to_owned()),
        (Sample::Mark(Mark::Ring, "ink-4"), "largest deviation".to_owned()),
    ]);
    let x = || Axis::between("x in mm", samples.range, INNER_MM - LEFT_MM, Direction::Along);
    let off = deviation.iter().map(|point| point.y).chain([0.0]);
    let heights = wanted.iter().chain(&cut).map(|point| point.y);
    let both = Chart {
        corner: spot(MARGIN_MM + LEFT_MM, page.y + ABOVE_MM),
        x: x(),
        y: Axis::between("z in mm", with_room(range(heights)), CURVES_MM, Direction::Up),
    };
    let below = Chart {
        corner: spot(MARGIN_MM + LEFT_MM, both.bottom() + BELOW_MM + ABOVE_MM + 2.0),
        x: x(),
        y: Axis::between("deviation in mm", with_room(range(off)), DEVIATION_MM, Direction::Up),
    };
    draw_curves(&mut page.svg, &both, &wanted, &cut, likeness);
    draw_deviation(&mut page.svg, &below, &deviation, likeness);
    page.finish(&origin.file_name("contour"), below.bottom() + BELOW_MM)
}

/// The points of one of two curves; one without a partner is left out.
fn curve(samples: &Samples, heights: &[f64]) -> Vec<Point2> {
    let count = samples.wanted.len().min(samples.cut.len());
    heights.iter().take(count).enumerate().map(|(index, &z)| Point2::new(samples.x(index), z)).collect()
}

/// The distance of each place of the cut contour from the wanted one: above 0 where it lies above.
fn deviations(wanted: &[Point2], cut: &[Point2]) -> Vec<Point2> {
    // The wanted contour as its samples: between two of them its walls lean by a thousandth of the width.
    if wanted.len() < 2 {
        return Vec::new();
    }
    let signed = |(wanted_here, point): (&Point2, &Point2)| {
        let distance = distance(point, wanted);
        Point2::new(point.x, if point.y < wanted_here.y { -distance } else { distance })
    };
    wanted.iter().zip(cut).map(signed).collect()
}

fn draw_curves(svg: &mut Svg, chart: &Chart, wanted: &[Point2], cut: &[Point2], likeness: &Likeness) {
    svg.group("contours", "", |svg| {
        chart.draw_axes(svg);
        chart.draw_curve(svg, "finished", wanted, "wanted");
        chart.draw_curve(svg, "curve stroke-2", cut, "cut");
        if let Some(place) = nearest(cut, likeness.max_deviation_x_mm) {
            chart.draw_mark(svg, Mark::Ring, "ink-4", &place);
        }
    });
}

fn draw_deviation(svg: &mut Svg, chart: &Chart, deviation: &[Point2], likeness: &Likeness) {
    svg.group("deviation", "", |svg| {
        chart.draw_axes(svg);
        chart.draw_level(svg, "finished", 0.0);
        chart.draw_curve(svg, "curve stroke-2", deviation, "deviation");
        let Some(place) = nearest(deviation, likeness.max_deviation_x_mm) else { return };
        let words = format!("{} mm", figure(likeness.max_deviation_mm, 3));
        draw_peak(svg, chart, &place, &words, Words { ink: "ink-4", side: 1.0, lower_mm: 0.0 });
    });
}

fn nearest(points: &[Point2], x: f64) -> Option<Point2> {
    points.iter().copied().min_by(|one, other| (one.x - x).abs().total_cmp(&(other.x - x).abs()))
}

/// Where the words of a marked point stand, and their colour.
#[derive(Clone, Copy)]
struct Words {
    ink: &'static str,
    /// +1 to the right, -1 to the left; to the other side where there is no room.
    side: f64,
    /// How much lower than the point, in mm of the sheet.
    lower_mm: f64,
}

/// Marks a point, with words beside it.
fn draw_peak(svg: &mut Svg, chart: &Chart, point: &Point2, words: &str, place: Words) {
    let Some(at) = chart.draw_mark(svg, Mark::Ring, place.ink, point) else { return };
    let aside = text_width(words, SMALL_MM) / 2.0 + 2.5;
    let to_right = at.x + 2.0 * aside < chart.right();
    let to_left = at.x - 2.0 * aside > chart.corner.x;
    let fits = if place.side > 0.0 { to_right || !to_left } else { to_left || !to_right };
    let side = if fits { place.side } else { -place.side };
    let class = format!("small head halo {}", place.ink);
    let middle = spot(at.x + side * aside, at.y + place.lower_mm);
    svg.text(&class, baseline(middle, SMALL_MM), Anchor::Middle, words);
}

/// The normalised cross-correlation over the lag: `correlation.svg`, or `correlation-measured.svg`.
#[must_use]
pub fn correlation(likeness: &Likeness, origin: Origin) -> Drawing {
    let printed = lagged(&likeness.samples);
    let removed = lagged(&mean_removed(&likeness.samples));
    let value = |value: Option<f64>| value.map_or_else(|| "none".to_owned(), |value| figure(value, 6));
    let lines = [
        format!(
            "Wanted and {} contour shifted against one another along x (Eq. 15): 1 at the peak means alike but for a factor.",
            origin.words()
        ),
        format!(
            "Peak as printed {}; with the means removed {}. As printed, a constant error of height hardly shows.",
            value(likeness.correlation),
            value(likeness.correlation_mean_removed)
        ),
    ];
    let title = format!("Normalised cross-correlation, wanted and {} contour", origin.words());
    let mut page = Page::new(&title, "", &lines);
    page.legend(&[
        (Sample::Line("curve stroke-1"), "as printed in Eq. 15".to_owned()),
        (Sample::Line("curve stroke-2 dashed"), "with the means removed".to_owned()),
        (Sample::Mark(Mark::Ring, "ink-1"), "peak".to_owned()),
    ]);
    let heights = printed.iter().chain(&removed).map(|point| point.y).chain([0.0, 1.0]);
    let furthest = printed.iter().chain(&removed).map(|point| point.x.abs()).fold(1.0, f64::max);
    let chart = Chart {
        corner: spot(MARGIN_MM + LEFT_MM, page.y + ABOVE_MM),
        x: Axis::between(
            &lag_words(&likeness.samples),
            (-furthest, furthest),
            INNER_MM - LEFT_MM,
            Direction::Along,
        ),
        y: Axis::between("cross-correlation", with_room(range(heights)), CORRELATION_MM, Direction::Up),
    };
    draw_correlation(&mut page.svg, &chart, likeness, &printed, &removed);
    page.finish(&origin.file_name("correlation"), chart.bottom() + BELOW_MM)
}

fn lag_words(samples: &Samples) -> String {
    let step = (samples.range.1 - samples.range.0) / samples.wanted.len().saturating_sub(1).max(1) as f64;
    format!("lag in samples of {} mm; above 0 the cut contour lies farther to the right", figure(step, 4))
}

fn draw_correlation(
    svg: &mut Svg,
    chart: &Chart,
    likeness: &Likeness,
    printed: &[Point2],
    removed: &[Point2],
) {
    chart.draw_axes(svg);
    chart.draw_level(svg, "finished", 0.0);
    // Both peaks are near 1: their words stand above the curves on either side.
    let left = Words { ink: "ink-2", side: -1.0, lower_mm: -6.0 };
    let right = Words { ink: "ink-1", side: 1.0, lower_mm: -2.0 };
    let kinds = [
        (removed, likeness.correlation_mean_removed, "curve stroke-2 dashed", left, "means removed:"),
        (printed, likeness.correlation, "curve stroke-1", right, "as printed:"),
    ];
    for (points, value, class, place, name) in kinds {
        chart.draw_curve(svg, class, points, name);
        let peak = points.iter().filter(|point| chart.shows(point)).max_by(|a, b| a.y.total_cmp(&b.y));
        let (Some(peak), Some(value)) = (peak, value) else { continue };
        let words = format!("{name} {} at lag {}", figure(value, 6), figure(peak.x, 0));
        draw_peak(svg, chart, peak, &words, place);
    }
}

/// The correlation at each lag, in samples.
fn lagged(samples: &Samples) -> Vec<Point2> {
    let count = samples.wanted.len();
    if count == 0 || count != samples.cut.len() {
        return Vec::new();
    }
    let lag = |index: usize| index as f64 - (count - 1) as f64;
    let values = samples.correlation_function();
    values.into_iter().enumerate().map(|(index, value)| Point2::new(lag(index), value)).collect()
}

fn mean_removed(samples: &Samples) -> Samples {
    let level = |heights: &[f64]| {
        let mean = heights.iter().sum::<f64>() / heights.len().max(1) as f64;
        heights.iter().map(|height| height - mean).collect()
    };
    Samples { range: samples.range, wanted: level(&samples.wanted), cut: level(&samples.cut) }
}
