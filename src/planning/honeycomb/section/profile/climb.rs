//! The largest distance of a straight line from the contour, by branch and bound.
//!
//! Along a line the distance to each single segment of the contour is convex, so on an interval it is at most the
//! larger of its values at both ends; and the distance to the contour is the least of them. So with i the segment
//! nearest to one end, max(d_i at this end, d_i at the other) bounds the distance to the contour on the interval.
//! This bound is exact as soon as one segment is nearest throughout, also where the line runs parallel to it, where
//! the bound by the slope of distance (never above 1) alone would cut the line into pieces of the tolerance. Both
//! are used; the second makes the search end whatever the contour is.

use super::Profile;
use crate::planning::geometry::Point2;
use crate::planning::tolerance::FARTHEST_MM;

/// The point of something that lies farthest from the contour.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Farthest {
    /// How far, in mm: at most [`FARTHEST_MM`] less than the largest distance.
    pub distance: f64,
    /// Where it was found.
    pub at: Point2,
}

/// What distances are taken to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum To {
    /// The contour.
    Contour,
    /// The contour, the base and both sides: everything where the part ends.
    Boundary,
}

/// A straight piece of boundary that a point may be nearest to.
#[derive(Debug, Clone, Copy)]
enum Nearest {
    Segment(usize),
    Left,
    Right,
    Base,
}

/// A point of the line with its distance and what it was found to.
#[derive(Debug, Clone, Copy)]
struct Sample {
    point: Point2,
    distance: f64,
    nearest: Nearest,
}

impl Profile {
    /// Raises `best` to the point of the line from `a` to `b` above the contour that lies farthest from it.
    pub fn farthest_above(&self, a: &Point2, b: &Point2, best: &mut Option<Farthest>) {
        for [from, to] in self.above(a, b) {
            self.climb(To::Contour, along(a, b, from), along(a, b, to), best, f64::INFINITY);
        }
    }

    /// How deep the line from `a` to `b` enters the part: the largest distance in mm of a point of it in the part
    /// to where the part ends. 0 if it does not.
    #[must_use]
    pub fn depth(&self, a: &Point2, b: &Point2) -> f64 {
        self.deepest(a, b, f64::INFINITY)
    }

    /// How deep a point lies in the part, in mm. 0 if it does not.
    #[must_use]
    pub fn depth_of(&self, point: &Point2) -> f64 {
        let [left, right] = self.limits(point.x);
        if !(0.0..=self.width()).contains(&point.x) || point.y >= left.min(right) {
            return 0.0;
        }
        self.sample(To::Boundary, *point).distance
    }

    /// Whether the line from `a` to `b` enters the part deeper than `limit` mm.
    pub(super) fn enters(&self, a: &Point2, b: &Point2, limit: f64) -> bool {
        self.deepest(a, b, limit) > limit
    }

    /// As `depth`, but any depth above `enough` will do.
    fn deepest(&self, a: &Point2, b: &Point2, enough: f64) -> f64 {
        let mut best = None;
        for [from, to] in self.under(a, b) {
            self.climb(To::Boundary, along(a, b, from), along(a, b, to), &mut best, enough);
        }
        best.map_or(0.0, |farthest| farthest.distance)
    }

    /// Searches the line from `a` to `b`, all of it on one side of the contour, for a distance above `best`.
    fn climb(&self, to: To, a: Point2, b: Point2, best: &mut Option<Farthest>, enough: f64) {
        let ends = [a, b].map(|point| self.sample(to, point));
        ends.iter().for_each(|end| raise(best, end));
        let mut open = vec![ends];
        while let Some([from, to_end]) = open.pop() {
            let found = best.map_or(0.0, |farthest| farthest.distance);
            if found > enough || self.at_most(&from, &to_end) <= found + FARTHEST_MM {
                continue;
            }
            let middle = self.sample(to, nalgebra::center(&from.point, &to_end.point));
            raise(best, &middle);
            // The end that lies farther off is looked at first: what is found there closes the other half.
            let halves = [[from, middle], [middle, to_end]];
            open.extend(if from.distance > to_end.distance { [halves[1], halves[0]] } else { halves });
        }
    }

    /// No point between two samples lies farther off than this.
    fn at_most(&self, from: &Sample, to: &Sample) -> f64 {
        let slope = (from.distance + to.distance + (to.point - from.point).norm()) / 2.0;
        let ahead = from.distance.max(self.distance_from(&to.point, from.nearest));
        let back = to.distance.max(self.distance_from(&from.point, to.nearest));
        slope.min(ahead).min(back)
    }

    fn sample(&self, to: To, point: Point2) -> Sample {
        let (distance, segment) = self.nearest(&point);
        let mut sample = Sample { point, distance, nearest: Nearest::Segment(segment) };
        if to == To::Boundary {
            for nearest in [Nearest::Left, Nearest::Right, Nearest::Base] {
                let distance = self.distance_from(&point, nearest);
                if distance < sample.distance {
                    sample = Sample { point, distance, nearest };
                }
            }
        }
        sample
    }

    /// The distance of a point to a piece of boundary; 0 beyond a side or below the base, where no part is.
    fn distance_from(&self, point: &Point2, nearest: Nearest) -> f64 {
        match nearest {
            Nearest::Segment(index) => self.distance_to(point, index),
            Nearest::Left => point.x.max(0.0),
            Nearest::Right => (self.width() - point.x).max(0.0),
            Nearest::Base => point.y.max(0.0),
        }
    }
}

fn raise(best: &mut Option<Farthest>, sample: &Sample) {
    if best.is_none_or(|farthest| farthest.distance < sample.distance) {
        *best = Some(Farthest { distance: sample.distance, at: sample.point });
    }
}

/// The point at a share of the way; exact at both ends.
fn along(a: &Point2, b: &Point2, share: f64) -> Point2 {
    if share == 1.0 { *b } else { a + (b - a) * share }
}
