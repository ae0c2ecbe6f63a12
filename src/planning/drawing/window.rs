//! A window: a stretch of the tape, in its place on the sheet.

use super::View;
use super::sheet::cut_class;
use super::sketch::PieceSketch;
use super::svg::{Path, Spot, Svg, spot};
use crate::planning::geometry::Point2;

/// A stretch of the tape, with equal scale along and across.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Window {
    /// What it shows along the tape: smallest and largest u (or r) in mm.
    pub along: (f64, f64),
    /// Where the smallest u is on the sheet, on the centre line.
    pub left: Spot,
    /// That many mm of tape are one mm of the sheet.
    pub denominator: f64,
    /// The side from which it is seen.
    pub view: View,
}

impl Window {
    /// The place of (u, v) on the sheet.
    #[must_use]
    pub fn spot(&self, point: &Point2) -> Spot {
        let down = self.view.v_down() * point.y;
        spot(self.x(point.x), self.left.y + down / self.denominator)
    }

    /// The x of u on the sheet.
    #[must_use]
    pub fn x(&self, u: f64) -> f64 {
        self.left.x + (u - self.along.0) / self.denominator
    }

    /// Width on the sheet in mm.
    #[must_use]
    pub fn width(&self) -> f64 {
        (self.along.1 - self.along.0) / self.denominator
    }

    /// Whether any of that stretch of the tape can be seen.
    #[must_use]
    pub fn shows(&self, (low, high): (f64, f64)) -> bool {
        low <= self.along.1 && high >= self.along.0
    }

    /// Draws the area of a piece. `shift` is added to its u, here and below.
    pub fn draw_area(&self, svg: &mut Svg, piece: &PieceSketch, shift: f64, class: &str, title: &str) {
        let mut path = Path::default();
        for points in &piece.loops {
            let shifted: Vec<Point2> = points.iter().map(|p| Point2::new(p.x + shift, p.y)).collect();
            path.closed(clipped_loop(&shifted, self.along).iter().map(|point| self.spot(point)));
        }
        svg.area(class, &path, title);
    }

    /// Draws what of a changed outline is left to be trimmed, and the outline as the ply has it.
    pub fn draw_trims(&self, svg: &mut Svg, piece: &PieceSketch) {
        let (mut areas, mut lines) = (Path::default(), Path::default());
        for trim in &piece.trims {
            areas.closed(clipped_loop(trim, self.along).iter().map(|point| self.spot(point)));
        }
        for given in &piece.given {
            self.add(&mut lines, given, 0.0);
        }
        svg.area("trim", &areas, "left to be trimmed");
        svg.path("given", &lines, "outline of the ply");
    }

    /// Draws where the tape's own edge bounds a piece.
    pub fn draw_tape_edges(&self, svg: &mut Svg, piece: &PieceSketch, shift: f64) {
        let mut path = Path::default();
        for (from, to) in &piece.tape_edges {
            self.add(&mut path, &[*from, *to], shift);
        }
        svg.path("tape-edge", &path, "");
    }

    /// Draws the cuts of a piece, a path each. `axis` is the letter of the coordinate that the titles name.
    pub fn draw_cuts(&self, svg: &mut Svg, piece: &PieceSketch, shift: f64, axis: char) {
        for cut in &piece.cuts {
            let mut path = Path::default();
            self.add(&mut path, &cut.points, shift);
            svg.path(&cut_class(cut.cutter), &path, &cut.title(axis, shift));
        }
    }

    fn add(&self, path: &mut Path, points: &[Point2], shift: f64) {
        let shifted: Vec<Point2> = points.iter().map(|p| Point2::new(p.x + shift, p.y)).collect();
        for run in clipped(&shifted, self.along) {
            path.open(run.iter().map(|point| self.spot(point)));
        }
    }
}

/// The parts of a polyline with x between `low` and `high`.
fn clipped(points: &[Point2], along: (f64, f64)) -> Vec<Vec<Point2>> {
    let mut runs: Vec<Vec<Point2>> = Vec::new();
    for pair in points.windows(2) {
        let Some((from, to)) = clipped_segment(pair[0], pair[1], along) else { continue };
        match runs.last_mut() {
            Some(run) if run.last() == Some(&from) => run.push(to),
            _ => runs.push(vec![from, to]),
        }
    }
    runs
}

/// A segment that only touches the stretch at one point is no part of it.
fn clipped_segment(from: Point2, to: Point2, (low, high): (f64, f64)) -> Option<(Point2, Point2)> {
    let outside = |x: f64| x < low || x > high;
    if from.x.max(to.x) < low || from.x.min(to.x) > high {
        return None;
    }
    let bring = |point: Point2, other: Point2| {
        if outside(point.x) { at_x(point, other, point.x.clamp(low, high)) } else { point }
    };
    let (from, to) = (bring(from, to), bring(to, from));
    (from != to).then_some((from, to))
}

/// Where the line through two points of different x has that x.
fn at_x(a: Point2, b: Point2, x: f64) -> Point2 {
    Point2::new(x, a.y + (x - a.x) / (b.x - a.x) * (b.y - a.y))
}

/// The part of a loop with x between `low` and `high` (Sutherland and Hodgman 1974). Where the loop has several
/// parts there, they hang together by lines along the border, which do not show in an area.
fn clipped_loop(points: &[Point2], (low, high): (f64, f64)) -> Vec<Point2> {
    let right = half_clipped(points, low, |x| x >= low);
    half_clipped(&right, high, |x| x <= high)
}

fn half_clipped(points: &[Point2], border: f64, inside: impl Fn(f64) -> bool) -> Vec<Point2> {
    let mut kept = Vec::with_capacity(points.len());
    for (index, &point) in points.iter().enumerate() {
        let next = points[(index + 1) % points.len()];
        if inside(point.x) {
            kept.push(point);
        }
        if inside(point.x) != inside(next.x) {
            kept.push(at_x(point, next, border));
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planning::geometry::polygon::signed_area;

    fn points(list: &[(f64, f64)]) -> Vec<Point2> {
        list.iter().map(|&(x, y)| Point2::new(x, y)).collect()
    }

    #[test]
    fn a_line_that_leaves_and_comes_back_is_two_parts() {
        let line = points(&[(0.0, 0.0), (10.0, 10.0), (0.0, 20.0)]);
        let runs = clipped(&line, (0.0, 5.0));
        assert_eq!(runs, [points(&[(0.0, 0.0), (5.0, 5.0)]), points(&[(5.0, 15.0), (0.0, 20.0)])]);
        assert_eq!(clipped(&line, (2.0, 20.0)), [points(&[(2.0, 2.0), (10.0, 10.0), (2.0, 18.0)])]);
        assert!(clipped(&line, (10.0, 20.0)).is_empty(), "a touch is no part");
        assert!(clipped(&line, (30.0, 40.0)).is_empty());
    }

    #[test]
    fn stretches_side_by_side_hold_the_whole_area() {
        let outline =
            points(&[(0.0, 0.0), (30.0, -5.0), (20.0, 5.0), (35.0, 20.0), (0.0, 10.0), (12.0, 5.0)]);
        let parts = [(-5.0, 9.0), (9.0, 21.0), (21.0, 50.0)];
        let areas = parts.map(|along| signed_area(&clipped_loop(&outline, along)));
        assert!(areas.iter().all(|&area| area > 0.0));
        assert!((areas.iter().sum::<f64>() - signed_area(&outline)).abs() < 1e-9);
    }
}
