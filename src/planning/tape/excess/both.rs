//! Both ends of a short piece, where they need too many knives only together or beside other cuts.
//!
//! The upper end lies above the lower one everywhere, so the heights that they share run from the lowest of the upper to
//! the highest of the lower, and each end is crossed there at least once. They are made by k knives if
//! - they share none: the upper stays above some height and the lower below it; or
//! - two knives make one each: where they share heights both are crossed once, and beyond each is any shape of two knives.
//!
//! In either case what one end gains by a height the other loses, and the height is found at which the larger of both
//! deviations is least. For a piece without other cuts there is no third case, so no other change is less if no end doubles
//! back in v. One that does is covered by its silhouette, or left as it is.
//!
//! A cut that needs all knives for itself leaves none for the ends: they lie above and below it as a whole. So they do, if
//! need be, with cuts that would leave a knife for one of them; that it could go beside is not looked at.

use super::end::{Edge, End, Room};
use super::{Simplified, side_by_side};
use crate::planning::geometry::Point2;

/// The two ends of a piece beside its other cuts.
pub(super) struct Both<'a> {
    pub(super) upper: &'a End,
    pub(super) lower: &'a End,
    /// Cut-outs, and cuts that come back to the edge that they came from.
    pub(super) others: Vec<&'a [Point2]>,
    pub(super) half_width_mm: f64,
    pub(super) knives: usize,
}

/// A height that separates the ends is found to this, in mm: far below any step that is levelled out later.
pub(super) const LEVEL_MM: f64 = 1e-9;

/// The u that the upper end stays above, and the u that the lower end stays below.
type Clear = (f64, f64);

impl Both<'_> {
    /// The least change of both ends, the upper first, that leaves no more chains side by side than there are knives;
    /// `None` if there is none.
    pub(super) fn changed(&self) -> Option<[Simplified; 2]> {
        let ways = self.clearances().into_iter().flat_map(|clear| self.ways(clear));
        let most = |ends: &[Simplified; 2]| ends[0].max_deviation_mm.max(ends[1].max_deviation_mm);
        ways.filter(|ends| self.works(ends)).min_by(|a, b| most(a).total_cmp(&most(b)))
    }

    fn works(&self, ends: &[Simplified; 2]) -> bool {
        let ends = ends.iter().map(|end| end.points.as_slice());
        side_by_side(ends.chain(self.others.iter().copied()), self.half_width_mm) <= self.knives
    }

    /// Clear of the other cuts that need all knives, and clear of all.
    fn clearances(&self) -> Vec<Clear> {
        let alone = |cut: &[Point2]| side_by_side(std::iter::once(cut), self.half_width_mm);
        let needed: Vec<usize> = self.others.iter().map(|cut| alone(cut)).collect();
        let clear = |least: usize| {
            let cuts = self.others.iter().zip(&needed).filter(|(_, needed)| **needed >= least);
            let us = cuts.flat_map(|(cut, _)| cut.iter().map(|point| point.x));
            us.fold((f64::NEG_INFINITY, f64::INFINITY), |(high, low), u| (high.max(u), low.min(u)))
        };
        let mut clearances = vec![clear(self.knives), clear(0)];
        clearances.dedup();
        clearances
    }

    /// Ways of changing both ends, of which the least is among those that work.
    fn ways(&self, clear: Clear) -> Vec<[Simplified; 2]> {
        // Each end is looked at again at every step of a search.
        if self.upper.has_many_turns() || self.lower.has_many_turns() {
            let beside = [self.upper, self.lower].map(|end| end.covered(1));
            return vec![self.apart(clear, 1), beside];
        }
        let mut ways = vec![self.apart(clear, self.knives)];
        if self.knives > 1 {
            ways.push(self.beside(clear));
        }
        // An end that doubles back is changed as a whole where it is changed at all.
        let kept = [self.upper, self.lower].map(|end| -end.heights().0);
        ways.push([
            self.upper.unchanged(),
            self.lower.covered_within(above(kept[0].max(-clear.1)), self.knives),
        ]);
        ways.push([
            self.upper.covered_within(above(kept[1].max(clear.0)), self.knives),
            self.lower.unchanged(),
        ]);
        ways
    }

    /// The one end above some height, the other below it.
    fn apart(&self, clear: Clear, knives: usize) -> [Simplified; 2] {
        let upper = |level: f64| self.upper.covered_within(above(clear.0.max(level)), knives);
        let lower = |level: f64| self.lower.covered_within(above(-clear.1.min(level)), knives);
        let level = self.least(|level| upper(level).max_deviation_mm, |level| lower(level).max_deviation_mm);
        [upper(level), lower(level)]
    }

    /// Each end crossed once where the other is.
    fn beside(&self, clear: Clear) -> [Simplified; 2] {
        // An end that is crossed once below some height, from the edge at which that changes less.
        let once = |end: &End, height: f64, floor: f64| {
            let [first, last] = [Edge::First, Edge::Last].map(|edge| {
                end.covered_within(Room { floor, once_below: Some((height, edge)) }, self.knives)
            });
            if last.max_deviation_mm < first.max_deviation_mm { last } else { first }
        };
        let none = f64::NEG_INFINITY;
        // How far the upper end comes down, and how far the lower comes up: neither changes what the other costs.
        let (low, high) = (self.upper.heights().0, -self.lower.heights().0);
        let bottom = self.least(|u| (u - low).max(0.0), |u| once(self.lower, -u, none).max_deviation_mm);
        let top = self.least(|u| once(self.upper, u, none).max_deviation_mm, |u| (high - u).max(0.0));
        [once(self.upper, top, clear.0.max(bottom)), once(self.lower, -bottom, -clear.1.min(top))]
    }

    /// The u at which the larger of a cost that rises with it and of one that falls is least, and of several such u one
    /// at which the smaller is least.
    fn least(&self, rising: impl Fn(f64) -> f64, falling: impl Fn(f64) -> f64) -> f64 {
        let [upper, lower] = [self.upper.heights(), self.lower.heights()];
        let (bottom, top) = (upper.0.min(-lower.1), upper.1.max(-lower.0));
        let middle = last(bottom, top, |u| rising(u) <= falling(u));
        let most = rising(middle).max(falling(middle)) + LEVEL_MM;
        let highest = last(middle, top, |u| rising(u) <= most);
        let lowest = -last(-middle, -bottom, |u| falling(-u) <= most);
        if falling(highest) < rising(lowest) { highest } else { lowest }
    }
}

/// The largest number up to `high` for which something holds that holds below it and not above; `low` if for none.
fn last(mut low: f64, mut high: f64, holds: impl Fn(f64) -> bool) -> f64 {
    if holds(high) {
        return high;
    }
    while high - low > LEVEL_MM {
        let middle = f64::midpoint(low, high);
        if middle <= low || middle >= high {
            break;
        }
        if holds(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

/// Above a height.
fn above(floor: f64) -> Room {
    Room { floor, once_below: None }
}
