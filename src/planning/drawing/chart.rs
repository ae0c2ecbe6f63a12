//! A chart: two axes with round ticks, and curves, areas, bands and marks between them. What lies outside the axes
//! is cut off; what is no number leaves a gap.

use super::axis::{Axis, is_shown};
use super::mark::Mark;
use super::sheet::{NUMBER_MM, SMALL_MM};
use super::svg::{Anchor, Path, Spot, Svg, spot};
use super::thin::{clipped_area, clipped_line, line};
use crate::planning::geometry::Point2;

/// Room above a chart for the words of its upright axis, in mm of the sheet.
pub const ABOVE_MM: f64 = 5.0;
/// Room below a chart for its numbers and the words of the axis along the sheet.
pub const BELOW_MM: f64 = 10.0;
/// Room left of a chart for numbers of the usual size.
pub const LEFT_MM: f64 = 11.0;

/// A chart. The lengths of its axes are its size.
#[derive(Debug, Clone, PartialEq)]
pub struct Chart {
    /// Its upper left corner, without the room for numbers and words.
    pub corner: Spot,
    /// What goes to the right.
    pub x: Axis,
    /// What goes up.
    pub y: Axis,
}

impl Chart {
    /// The place of (x, y) on the sheet.
    #[must_use]
    pub fn spot(&self, x: f64, y: f64) -> Spot {
        spot(self.corner.x + self.x.place(x), self.bottom() - self.y.place(y))
    }

    /// y of the lower edge, in mm of the sheet.
    #[must_use]
    pub fn bottom(&self) -> f64 {
        self.corner.y + self.y.length_mm
    }

    /// x of the right edge, in mm of the sheet.
    #[must_use]
    pub fn right(&self) -> f64 {
        self.corner.x + self.x.length_mm
    }

    /// Whether (x, y) lies between the axes.
    #[must_use]
    pub fn shows(&self, point: &Point2) -> bool {
        let within = |value: f64, axis: &Axis| value >= axis.low && value <= axis.high;
        within(point.x, &self.x) && within(point.y, &self.y)
    }

    /// Draws grid, frame, numbers and words.
    pub fn draw_axes(&self, svg: &mut Svg) {
        svg.group("axes", "", |svg| {
            self.draw_along(svg);
            self.draw_up(svg);
            svg.rect("frame", self.corner, self.x.length_mm, self.y.length_mm);
        });
    }

    fn draw_along(&self, svg: &mut Svg) {
        let bottom = self.bottom();
        for (value, digits) in self.x.ticks() {
            let x = self.spot(value, self.y.low).x;
            svg.line("grid", spot(x, self.corner.y), spot(x, bottom));
            svg.text("number", spot(x, bottom + 1.0 + NUMBER_MM), Anchor::Middle, &digits);
        }
        let middle = spot(self.corner.x + self.x.length_mm / 2.0, bottom + 2.4 + NUMBER_MM + SMALL_MM);
        svg.text("small", middle, Anchor::Middle, &self.x.words);
    }

    /// Draws the upright axis alone, with its grid.
    pub fn draw_up(&self, svg: &mut Svg) {
        for (value, digits) in self.y.ticks() {
            let y = self.spot(self.x.low, value).y;
            svg.line("grid", spot(self.corner.x, y), spot(self.right(), y));
            svg.text("number", spot(self.corner.x - 1.2, y + 0.8), Anchor::End, &digits);
        }
        let above = spot(self.corner.x, self.corner.y - 1.6);
        svg.text("small", above, Anchor::Start, &self.y.words);
    }

    /// Draws a curve through points. `title` is what a browser shows when the pointer rests on it.
    pub fn draw_curve(&self, svg: &mut Svg, class: &str, points: &[Point2], title: &str) {
        let mut path = Path::default();
        self.add_curve(&mut path, points);
        svg.path(class, &path, title);
    }

    /// Adds a curve to a path.
    pub fn add_curve(&self, path: &mut Path, points: &[Point2]) {
        for part in self.parts(points) {
            path.open(part);
        }
    }

    /// The parts of a curve between the axes, on the sheet, as few points as show its look.
    #[must_use]
    pub fn parts(&self, points: &[Point2]) -> Vec<Vec<Spot>> {
        let mut parts = Vec::new();
        for run in points.split(|point| !is_place(point)) {
            let spots: Vec<Spot> = run.iter().map(|point| self.spot(point.x, point.y)).collect();
            parts.extend(clipped_line(&spots, self.corner, self.far_corner()).iter().map(|part| line(part)));
        }
        parts
    }

    /// Adds an area to a path. Corners that are no numbers are left out.
    pub fn add_area(&self, path: &mut Path, points: &[Point2]) {
        let places = points.iter().filter(|point| is_place(point));
        let spots: Vec<Spot> = places.map(|point| self.spot(point.x, point.y)).collect();
        path.closed(line(&clipped_area(&spots, self.corner, self.far_corner())));
    }

    /// Draws the area between two heights from one side to the other.
    pub fn draw_band(&self, svg: &mut Svg, class: &str, (low, high): (f64, f64)) {
        let (low, high) = (low.max(self.y.low), high.min(self.y.high));
        if low < high {
            let corner = self.spot(self.x.low, high);
            svg.rect(class, corner, self.x.length_mm, self.spot(self.x.low, low).y - corner.y);
        }
    }

    /// Draws a line at one height from one side to the other.
    pub fn draw_level(&self, svg: &mut Svg, class: &str, height: f64) {
        if is_shown(height) && height >= self.y.low && height <= self.y.high {
            svg.line(class, self.spot(self.x.low, height), self.spot(self.x.high, height));
        }
    }

    /// Draws an upright line from top to bottom.
    pub fn draw_upright(&self, svg: &mut Svg, class: &str, x: f64) {
        if is_shown(x) && x >= self.x.low && x <= self.x.high {
            svg.line(class, self.spot(x, self.y.low), self.spot(x, self.y.high));
        }
    }

    /// Marks a point and gives its place on the sheet; none if it lies outside.
    pub fn draw_mark(&self, svg: &mut Svg, mark: Mark, ink: &str, point: &Point2) -> Option<Spot> {
        let at = self.shows(point).then(|| self.spot(point.x, point.y))?;
        mark.draw(svg, ink, at);
        Some(at)
    }

    /// The lower right corner.
    #[must_use]
    pub fn far_corner(&self) -> Spot {
        spot(self.right(), self.bottom())
    }
}

/// Whether both numbers of a point can be shown.
#[must_use]
pub fn is_place(point: &Point2) -> bool {
    is_shown(point.x) && is_shown(point.y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planning::drawing::axis::Direction;
    use crate::planning::drawing::sheet::WIDTH_MM;

    fn chart() -> Chart {
        let x = Axis::fitted("x in mm", [0.0, 100.0], 200.0, Direction::Along);
        let y = Axis::fitted("z in mm", [0.0, 10.0], 50.0, Direction::Up);
        Chart { corner: spot(20.0, 30.0), x, y }
    }

    #[test]
    fn y_goes_up_the_sheet() {
        let chart = chart();
        assert_eq!((chart.spot(0.0, 10.0), chart.spot(100.0, 0.0)), (spot(20.0, 30.0), spot(220.0, 80.0)));
    }

    #[test]
    fn what_is_no_number_is_a_gap_and_what_is_outside_is_cut_off() {
        let points = [(0.0, 1.0), (50.0, 1.0), (f64::NAN, 1.0), (60.0, 1.0), (400.0, 1.0)];
        let mut svg = Svg::default();
        chart().draw_curve(&mut svg, "curve", &points.map(|(x, y)| Point2::new(x, y)), "");
        let text = svg.finish(WIDTH_MM, 100.0, "", "");
        assert!(text.contains("d=\"M20 75L120 75M140 75L220 75\""), "{text}");
    }

    #[test]
    fn marks_levels_and_bands_outside_are_left_out() {
        let mut svg = Svg::default();
        let chart = chart();
        assert_eq!(chart.draw_mark(&mut svg, Mark::Disc, "ink-1", &Point2::new(101.0, 1.0)), None);
        assert_eq!(chart.draw_mark(&mut svg, Mark::Disc, "ink-1", &Point2::new(f64::NAN, 1.0)), None);
        chart.draw_level(&mut svg, "limit", f64::INFINITY);
        chart.draw_upright(&mut svg, "limit", -1.0);
        chart.draw_band(&mut svg, "band", (20.0, 30.0));
        assert_eq!(svg.finish(1.0, 1.0, "", ""), Svg::default().finish(1.0, 1.0, "", ""));
        let mut svg = Svg::default();
        chart.draw_band(&mut svg, "band", (5.0, 30.0));
        assert!(svg.finish(1.0, 1.0, "", "").contains("y=\"30\" width=\"200\" height=\"25\""));
    }
}
