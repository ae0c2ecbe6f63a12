//! Which portions of a straight line lie in the part.

use super::{Node, Profile, on_line};
use crate::planning::geometry::Point2;

/// A straight line from left to right, and where along it its portions begin and end.
struct Rising {
    a: Point2,
    b: Point2,
}

impl Rising {
    fn share(&self, x: f64) -> f64 {
        if x == self.b.x { 1.0 } else { (x - self.a.x) / (self.b.x - self.a.x) }
    }
}

impl Profile {
    /// The portions of the line from `a` to `b` strictly below the contour, between the sides of the blank: pairs
    /// of shares of the way, rising, that do not touch.
    ///
    /// A line that lies on the contour has none; nor has one along a wall. What is below the base counts too.
    #[must_use]
    pub fn under(&self, a: &Point2, b: &Point2) -> Vec<[f64; 2]> {
        if a.x == b.x {
            return self.under_upright(a, b).into_iter().collect();
        }
        if a.x < b.x {
            return self.under_rising(Rising { a: *a, b: *b });
        }
        let mut portions = self.under_rising(Rising { a: *b, b: *a });
        portions.reverse();
        portions.iter_mut().for_each(|[from, to]| (*from, *to) = (1.0 - *to, 1.0 - *from));
        portions
    }

    /// The portions above it: what `under` leaves of the way. Beside the blank everything is above.
    #[must_use]
    pub fn above(&self, a: &Point2, b: &Point2) -> Vec<[f64; 2]> {
        let mut portions = Vec::new();
        let mut from = 0.0;
        for [begin, end] in self.under(a, b) {
            if begin > from {
                portions.push([from, begin]);
            }
            from = end;
        }
        if from < 1.0 {
            portions.push([from, 1.0]);
        }
        portions
    }

    fn under_upright(&self, a: &Point2, b: &Point2) -> Option<[f64; 2]> {
        if !(0.0..=self.width()).contains(&a.x) {
            return None;
        }
        let [left, right] = self.limits(a.x);
        let top = left.min(right);
        let share = ((top - a.y) / (b.y - a.y)).clamp(0.0, 1.0);
        match (a.y < top, b.y < top) {
            (true, true) => Some([0.0, 1.0]),
            (true, false) => Some([0.0, share]),
            (false, true) => Some([share, 1.0]),
            (false, false) => None,
        }
    }

    fn under_rising(&self, line: Rising) -> Vec<[f64; 2]> {
        let mut portions = Vec::new();
        self.collect_under(self.root(), &line, &mut portions);
        portions
    }

    fn collect_under(&self, node: Node, line: &Rising, portions: &mut Vec<[f64; 2]>) {
        let [left, right] = self.span(node);
        let (x0, x1) = (left.max(line.a.x), right.min(line.b.x));
        if x0 >= x1 {
            return;
        }
        let [z0, z1] = [x0, x1].map(|x| on_line(&line.a, &line.b, x));
        let [low, high] = self.bounds(node);
        if z0.min(z1) >= high {
            return;
        }
        if z0.max(z1) < low {
            append(portions, line.share(x0), line.share(x1));
        } else if let Some(children) = self.children(node) {
            children.for_each(|child| self.collect_under(child, line, portions));
        } else {
            let [a, b] = self.segment(node.index);
            let [before, after] = [on_line(&a, &b, x0) - z0, on_line(&a, &b, x1) - z1];
            let crossing = x0 + (before / (before - after)).clamp(0.0, 1.0) * (x1 - x0);
            match (before > 0.0, after > 0.0) {
                (true, true) => append(portions, line.share(x0), line.share(x1)),
                (true, false) => append(portions, line.share(x0), line.share(crossing)),
                (false, true) => append(portions, line.share(crossing), line.share(x1)),
                (false, false) => {}
            }
        }
    }
}

/// Adds a portion, joined to the last one where that ends where it begins.
fn append(portions: &mut Vec<[f64; 2]>, from: f64, to: f64) {
    match portions.last_mut() {
        Some(last) if last[1] >= from => last[1] = to,
        _ => portions.push([from, to]),
    }
}
