//! The nearest place of the contour.

use super::{Node, Profile, on_line};
use crate::planning::geometry::Point2;
use crate::planning::geometry::simplify::distance_to_segment;

impl Profile {
    /// The distance in mm from a point to the nearest point of the contour.
    #[must_use]
    pub fn distance(&self, point: &Point2) -> f64 {
        self.nearest(point).0
    }

    /// That distance, and the segment that it was found on.
    pub(super) fn nearest(&self, point: &Point2) -> (f64, usize) {
        let guess = self.segment_at(point.x);
        let mut best = (self.distance_to(point, guess), guess);
        self.approach(self.root(), point, &mut best);
        best
    }

    /// The distance in mm from a point to one segment.
    pub(super) fn distance_to(&self, point: &Point2, segment: usize) -> f64 {
        let [a, b] = self.segment(segment);
        distance_to_segment(point, &a, &b)
    }

    fn approach(&self, node: Node, point: &Point2, best: &mut (f64, usize)) {
        if self.at_least(node, point) >= best.0 {
            return;
        }
        let Some(children) = self.children(node) else {
            let distance = self.distance_to(point, node.index);
            if distance < best.0 {
                *best = (distance, node.index);
            }
            return;
        };
        // The half on the point's own side first: it narrows the search for the other.
        let [left, right] = self.span(node);
        if point.x <= (left + right) / 2.0 {
            children.for_each(|child| self.approach(child, point, best));
        } else {
            children.rev().for_each(|child| self.approach(child, point, best));
        }
    }

    /// The distance from a point to the box of a node.
    fn at_least(&self, node: Node, point: &Point2) -> f64 {
        let ([left, right], [low, high]) = (self.span(node), self.bounds(node));
        let across = (left - point.x).max(point.x - right).max(0.0);
        let up = (low - point.y).max(point.y - high).max(0.0);
        across.hypot(up)
    }

    /// Whether the line from `a` to `b` comes closer to the contour than `limit` mm.
    #[must_use]
    pub fn passes_within(&self, a: &Point2, b: &Point2, limit: f64) -> bool {
        let (a, b) = if a.x <= b.x { (a, b) } else { (b, a) };
        self.any_within(self.root(), a, b, limit)
    }

    fn any_within(&self, node: Node, a: &Point2, b: &Point2, limit: f64) -> bool {
        let ([left, right], [low, high]) = (self.span(node), self.bounds(node));
        // Only what of the line lies beside the box can come close to it.
        let (x0, x1) = ((left - limit).max(a.x), (right + limit).min(b.x));
        if x0 > x1 {
            return false;
        }
        let (z0, z1) = if a.x < b.x { (on_line(a, b, x0), on_line(a, b, x1)) } else { (a.y, b.y) };
        if z0.min(z1) - high >= limit || low - z0.max(z1) >= limit {
            return false;
        }
        match self.children(node) {
            Some(mut children) => children.any(|child| self.any_within(child, a, b, limit)),
            None => {
                let [c, d] = self.segment(node.index);
                gap(a, b, &c, &d) < limit
            }
        }
    }
}

/// The distance between two segments.
fn gap(a: &Point2, b: &Point2, c: &Point2, d: &Point2) -> f64 {
    let side = |a: &Point2, b: &Point2, p: &Point2| (b - a).perp(&(p - a));
    if side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0 {
        return 0.0;
    }
    let ends = [(a, c, d), (b, c, d), (c, a, b), (d, a, b)];
    ends.into_iter().map(|(p, a, b)| distance_to_segment(p, a, b)).fold(f64::INFINITY, f64::min)
}
