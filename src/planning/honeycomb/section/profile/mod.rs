//! The finished contour: a polyline z = f(x) from side to side of the blank, x never falling (equal x = a wall).
//!
//! The part is everything below it. All questions to it go through one tree of boxes over its segments, so that
//! their cost grows with the logarithm of the number of points:
//!
//! - `under`: which portions of a line lie in the part; exact, because both are straight between breaks;
//! - `near`: the nearest place of the contour, and whether a line comes closer than a distance;
//! - `climb`: the largest distance of a line from the contour, by branch and bound;
//! - `area`: how much of a polygon is part;
//! - `lowest`: how deep a tip may go with both arms outside the part.
//!
//! Points are (x, z) in mm; the second coordinate of a [`Point2`] is z.

mod area;
mod climb;
mod lowest;
mod near;
mod under;

pub use climb::Farthest;
use nalgebra::clamp;

use super::fault::{SectionFault, within};
use crate::planning::geometry::Point2;
use crate::planning::tolerance::SAME_POINT_MM;

/// The smallest and the largest blank, in mm across or high: a hundred kerfs, and more than any machine has.
const BLANK_MM: (f64, f64) = (1.0, 100_000.0);

/// The finished contour of a blank.
///
/// A fin or a slot of no width (three points at one x) has no material and no room: only its first and last
/// point count. A wall on a side of the blank is that side.
#[derive(Debug, Clone)]
pub struct Profile {
    points: Vec<Point2>,
    /// Lowest and highest z of 2^level segments from index * 2^level on, level by level from single segments up.
    boxes: Vec<Vec<[f64; 2]>>,
    /// The area under the contour from x = 0 to each point, in mm^2.
    areas: Vec<f64>,
    height: f64,
}

/// A run of segments: those of one box of the tree.
#[derive(Debug, Clone, Copy)]
struct Node {
    level: usize,
    index: usize,
}

impl Profile {
    /// Takes over the points of a contour for a blank of `width` by `height` mm.
    ///
    /// # Errors
    /// A blank smaller than 1 mm or larger than 100 m; fewer than two points; a point that is not finite or lies
    /// below 0 or above the blank; x that falls; ends that do not lie on the sides of the blank.
    pub fn new(points: &[Point2], width: f64, height: f64) -> Result<Self, SectionFault> {
        within("the width of the blank in mm", width, BLANK_MM.0, BLANK_MM.1)?;
        within("the height of the blank in mm", height, BLANK_MM.0, BLANK_MM.1)?;
        check(points, width, height)?;
        let points = regular(points, width, height);
        let (boxes, areas) = (boxes(&points), areas(&points));
        Ok(Self { points, boxes, areas, height })
    }

    /// Its points without repetitions, fins and slots.
    #[must_use]
    pub fn points(&self) -> &[Point2] {
        &self.points
    }

    /// The width of the blank, in mm.
    #[must_use]
    pub fn width(&self) -> f64 {
        self.points[self.points.len() - 1].x
    }

    /// The height of the blank, in mm.
    #[must_use]
    pub fn blank_height(&self) -> f64 {
        self.height
    }

    /// The area of the part, in mm^2.
    #[must_use]
    pub fn part_area(&self) -> f64 {
        self.areas[self.areas.len() - 1]
    }

    /// f(x), at a wall its upper end; beside the blank its end there.
    #[must_use]
    pub fn height(&self, x: f64) -> f64 {
        let [left, right] = self.limits(x);
        left.max(right)
    }

    /// The highest z of the contour.
    #[must_use]
    pub fn top(&self) -> f64 {
        self.bounds(self.root())[1]
    }

    /// The highest z of the contour from `x0` to `x1`; minus infinity beside the blank.
    #[must_use]
    pub fn highest(&self, x0: f64, x1: f64) -> f64 {
        let mut highest = f64::NEG_INFINITY;
        self.raise(self.root(), x0, x1, &mut highest);
        highest
    }

    fn raise(&self, node: Node, x0: f64, x1: f64, highest: &mut f64) {
        let [left, right] = self.span(node);
        if right < x0 || left > x1 || self.bounds(node)[1] <= *highest {
            return;
        }
        if left >= x0 && right <= x1 {
            *highest = self.bounds(node)[1];
        } else if let Some(children) = self.children(node) {
            children.for_each(|child| self.raise(child, x0, x1, highest));
        } else {
            let [a, b] = self.segment(node.index);
            let ends = [left.max(x0), right.min(x1)].map(|x| on_line(&a, &b, x));
            *highest = highest.max(ends[0]).max(ends[1]);
        }
    }

    /// f just left and just right of x: they differ only at a wall.
    fn limits(&self, x: f64) -> [f64; 2] {
        let x = clamp(x, 0.0, self.width());
        let reached = self.points.partition_point(|point| point.x < x);
        let passed = self.points.partition_point(|point| point.x <= x);
        if reached == passed {
            let z = on_line(&self.points[reached - 1], &self.points[reached], x);
            return [z, z];
        }
        [self.points[reached].y, self.points[passed - 1].y]
    }

    fn segments(&self) -> usize {
        self.points.len() - 1
    }

    fn segment(&self, index: usize) -> [Point2; 2] {
        [self.points[index], self.points[index + 1]]
    }

    /// The segment whose closed range of x holds `x` or, beside the blank, the one at that end.
    fn segment_at(&self, x: f64) -> usize {
        self.points.partition_point(|point| point.x < x).clamp(1, self.segments()) - 1
    }

    fn root(&self) -> Node {
        Node { level: self.boxes.len() - 1, index: 0 }
    }

    /// Lowest and highest z of a node.
    fn bounds(&self, node: Node) -> [f64; 2] {
        self.boxes[node.level][node.index]
    }

    /// First and last x of a node.
    fn span(&self, node: Node) -> [f64; 2] {
        let end = ((node.index + 1) << node.level).min(self.segments());
        [self.points[node.index << node.level].x, self.points[end].x]
    }

    /// The halves of a node from left to right; `None` for a single segment.
    fn children(&self, node: Node) -> Option<impl DoubleEndedIterator<Item = Node> + use<>> {
        let level = node.level.checked_sub(1)?;
        let end = (2 * node.index + 2).min(self.boxes[level].len());
        Some((2 * node.index..end).map(move |index| Node { level, index }))
    }
}

/// z at `x` of the line through two points of different x; exact at both.
fn on_line(a: &Point2, b: &Point2, x: f64) -> f64 {
    if x == b.x {
        return b.y;
    }
    if a.x == b.x {
        return a.y;
    }
    a.y + (x - a.x) / (b.x - a.x) * (b.y - a.y)
}

fn check(points: &[Point2], width: f64, height: f64) -> Result<(), SectionFault> {
    let [first, .., last] = points else {
        return Err(SectionFault::TooFewPoints { count: points.len() });
    };
    for (index, point) in points.iter().enumerate() {
        if !point.x.is_finite() || !(0.0..=height).contains(&point.y) {
            return Err(SectionFault::OutsideBlank { index, x: point.x, z: point.y, height });
        }
        let before = points[index.saturating_sub(1)].x;
        if point.x < before {
            return Err(SectionFault::Falls { index, before, x: point.x });
        }
    }
    if first.x.abs() > SAME_POINT_MM || (last.x - width).abs() > SAME_POINT_MM {
        return Err(SectionFault::Span { first: first.x, last: last.x, width });
    }
    Ok(())
}

/// The contour from exactly 0 to exactly the width, with at most two points at one x, and one on each side.
fn regular(points: &[Point2], width: f64, height: f64) -> Vec<Point2> {
    let mut kept: Vec<Point2> = Vec::with_capacity(points.len());
    for point in points {
        let point = Point2::new(clamp(point.x, 0.0, width), clamp(point.y, 0.0, height));
        if kept.iter().rev().take(2).filter(|other| other.x == point.x).count() == 2 {
            kept.pop();
        }
        if kept.last() != Some(&point) {
            kept.push(point);
        }
    }
    let (first, last) = (kept[0], kept[kept.len() - 1]);
    (kept[0].x, kept.last_mut().expect("a contour has points").x) = (0.0, width);
    if kept.len() > 2 && kept[1].x == first.x {
        kept.remove(0);
    }
    if kept.len() > 2 && kept[kept.len() - 2].x == last.x {
        kept.pop();
    }
    kept
}

fn boxes(points: &[Point2]) -> Vec<Vec<[f64; 2]>> {
    let single = points.windows(2).map(|pair| [pair[0].y.min(pair[1].y), pair[0].y.max(pair[1].y)]);
    let mut levels: Vec<Vec<[f64; 2]>> = vec![single.collect()];
    while let Some(below) = levels.last().filter(|level| level.len() > 1) {
        let joined = below.chunks(2).map(|pair| {
            pair.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], bounds| {
                [low.min(bounds[0]), high.max(bounds[1])]
            })
        });
        let joined = joined.collect();
        levels.push(joined);
    }
    levels
}

fn areas(points: &[Point2]) -> Vec<f64> {
    let mut total = 0.0;
    let steps = points.windows(2).map(|pair| (pair[1].x - pair[0].x) * (pair[0].y + pair[1].y) / 2.0);
    let mut areas = vec![0.0];
    areas.extend(steps.map(|step| {
        total += step;
        total
    }));
    areas
}
