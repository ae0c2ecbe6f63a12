//! How deep a tip may go with both arms of the blade outside the part.

use super::{Node, Profile, on_line};
use crate::planning::geometry::Point2;
use crate::planning::honeycomb::blade::Side;
use crate::planning::tolerance::CONTOUR_TOUCH_MM;

/// The two arms of a tip, seen from it.
struct Arms {
    x: f64,
    /// How far they reach across, in mm.
    across: f64,
    /// How much they rise on a mm across; infinite if they stand upright.
    rise: f64,
}

impl Profile {
    /// Whether neither arm of a tip, `reach` mm long and swung by `swing` rad, enters the part or comes closer to
    /// its contour than `allowance` mm, nor the tip below the base. Exactly on the contour is allowed.
    #[must_use]
    pub fn tip_allowed(&self, tip: &Point2, swing: f64, reach: f64, allowance: f64) -> bool {
        [tip.x, swing, reach].iter().all(|number| number.is_finite())
            && tip.y >= -CONTOUR_TOUCH_MM
            && [Side::Left, Side::Right].into_iter().all(|side| {
                let [across, up] = side.direction(swing);
                let end = Point2::new(tip.x + across * reach, tip.y + up * reach);
                self.line_allowed(tip, &end, allowance)
            })
    }

    fn line_allowed(&self, a: &Point2, b: &Point2, allowance: f64) -> bool {
        !self.enters(a, b, CONTOUR_TOUCH_MM)
            && (allowance <= 0.0 || !self.passes_within(a, b, allowance - CONTOUR_TOUCH_MM))
    }

    /// The lowest z, at least 0, at which `tip_allowed` holds at `x`, and holds anywhere above, for no allowance.
    ///
    /// It is the largest of f(x + u) - |u| / tan(swing) over |u| <= reach sin(swing). At a wall its upper end
    /// counts, also for an upright blade, which could stand along it.
    #[must_use]
    pub fn lowest_tip(&self, x: f64, swing: f64, reach: f64) -> f64 {
        let (sine, cosine) = swing.sin_cos();
        let mut lowest = 0.0;
        self.lift(self.root(), &Arms { x, across: reach * sine, rise: cosine / sine }, &mut lowest);
        lowest
    }

    fn lift(&self, node: Node, arms: &Arms, lowest: &mut f64) {
        let [left, right] = self.span(node);
        let off = (left - arms.x).max(arms.x - right).max(0.0);
        if off > arms.across || arms.under(self.bounds(node)[1], off) <= *lowest {
            return;
        }
        if let Some(children) = self.children(node) {
            children.for_each(|child| self.lift(child, arms, lowest));
            return;
        }
        let [a, b] = self.segment(node.index);
        let x0 = left.max(arms.x - arms.across);
        // Where an arm only just reaches the segment, rounding may turn the two about.
        let x1 = right.min(arms.x + arms.across).max(x0);
        for x in [x0, arms.x.clamp(x0, x1), x1] {
            let z = if a.x == b.x { a.y.max(b.y) } else { on_line(&a, &b, x) };
            *lowest = lowest.max(arms.under(z, (x - arms.x).abs()));
        }
    }
}

impl Arms {
    /// Where the tip is if an arm passes through height `z` at `off` mm across.
    fn under(&self, z: f64, off: f64) -> f64 {
        // Upright arms have no way across, and 0 times infinity is no number.
        if off == 0.0 { z } else { z - off * self.rise }
    }
}
