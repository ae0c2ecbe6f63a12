//! How much of a polygon is part.

use super::{Node, Profile, on_line};
use crate::planning::geometry::Point2;

impl Profile {
    /// The integral of min(z, f(x)) over x along the line from `a` to `b`, in mm^2; negative from right to left.
    ///
    /// By Green's theorem the area of a polygon below the contour is minus the sum over its edges
    /// counter-clockwise; it is exact, since both are straight between breaks. Between the sides of the blank only.
    #[must_use]
    pub fn strip_under(&self, a: &Point2, b: &Point2) -> f64 {
        if a.x < b.x {
            self.strip(self.root(), a, b)
        } else if b.x < a.x {
            -self.strip(self.root(), b, a)
        } else {
            0.0
        }
    }

    fn strip(&self, node: Node, a: &Point2, b: &Point2) -> f64 {
        let [left, right] = self.span(node);
        let (x0, x1) = (left.max(a.x), right.min(b.x));
        if x0 >= x1 {
            return 0.0;
        }
        let [z0, z1] = [x0, x1].map(|x| on_line(a, b, x));
        let [low, high] = self.bounds(node);
        if z0.max(z1) <= low {
            return trapezoid(x1 - x0, z0, z1);
        }
        if z0.min(z1) >= high {
            return self.area_until(x1, node) - self.area_until(x0, node);
        }
        match self.children(node) {
            Some(children) => children.map(|child| self.strip(child, a, b)).sum(),
            None => {
                let [c, d] = self.segment(node.index);
                lower_of(x1 - x0, [z0, z1], [on_line(&c, &d, x0), on_line(&c, &d, x1)])
            }
        }
    }

    /// The area under the contour from 0 to `x`, which lies in the span of the node.
    fn area_until(&self, x: f64, node: Node) -> f64 {
        let first = node.index << node.level;
        let end = ((node.index + 1) << node.level).min(self.segments());
        let index = first + self.points[first + 1..end].partition_point(|point| point.x < x);
        let [a, b] = self.segment(index);
        self.areas[index] + trapezoid(x - a.x, a.y, on_line(&a, &b, x))
    }
}

fn trapezoid(width: f64, z0: f64, z1: f64) -> f64 {
    width * (z0 + z1) / 2.0
}

/// The integral of the lower of two straight lines, given at both ends of an interval.
fn lower_of(width: f64, one: [f64; 2], other: [f64; 2]) -> f64 {
    let [before, after] = [one[0] - other[0], one[1] - other[1]];
    if before * after >= 0.0 {
        let lower = if before + after <= 0.0 { one } else { other };
        return trapezoid(width, lower[0], lower[1]);
    }
    let share = before / (before - after);
    let crossing = one[0] + share * (one[1] - one[0]);
    let (first, second) = if before < 0.0 { (one[0], other[1]) } else { (other[0], one[1]) };
    trapezoid(width * share, first, crossing) + trapezoid(width * (1.0 - share), crossing, second)
}
