//! Where there is air: for free moves through the section, and for the blade beyond its cutting length.

use super::Section;
use super::grid::{GridPoint, UNITS, snapped};
use super::outcome::Beyond;
use super::slit::Cut;
use crate::planning::geometry::Point2;
use crate::planning::tolerance::{SAME_POINT_MM, SLIT_OVERRUN_MM};

impl Section {
    /// Whether a point, in mm, lies in air or on a surface. A point that is not finite does not.
    #[must_use]
    pub fn is_air(&self, point: &Point2) -> bool {
        let corners = [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)];
        let about =
            corners.map(|(x, z)| Point2::new(point.x + x * SAME_POINT_MM, point.y + z * SAME_POINT_MM));
        is_finite(point) && !about.iter().all(|corner| self.stock.holds(snapped(corner)))
    }

    /// Whether a straight line, in mm, runs in air all the way. Along a surface is in air.
    #[must_use]
    pub fn segment_in_air(&self, a: &Point2, b: &Point2) -> bool {
        self.length_in_stock(a, b) <= SAME_POINT_MM
    }

    /// Whether the whole blade of a cut stands in air or in slits already cut, tip and body.
    ///
    /// Up to [`SLIT_OVERRUN_MM`] of it may be covered: that is what rounding does at the ends of a slit.
    #[must_use]
    pub fn blade_fits(&self, cut: &Cut) -> bool {
        self.length_in_stock(&cut.tip, &cut.at(cut.reach.whole())) <= SLIT_OVERRUN_MM
    }

    /// How much of a straight line runs in stock, in mm; infinite if one of its ends is not finite.
    #[must_use]
    pub fn length_in_stock(&self, a: &Point2, b: &Point2) -> f64 {
        if !is_finite(a) || !is_finite(b) {
            return f64::INFINITY;
        }
        let Some((a, b)) = self.clipped(a, b) else { return 0.0 };
        let way = b - a;
        let length = way.norm();
        if length <= SAME_POINT_MM {
            return 0.0;
        }
        // Between crossings the line lies in stock or not; just along a surface it has air on one side.
        let aside = nalgebra::Vector2::new(-way.y, way.x) * (SAME_POINT_MM / length);
        let is_stock = |share: f64| {
            let middle = a + way * share;
            [aside, -aside].iter().all(|aside| self.stock.holds(snapped(&(middle + aside))))
        };
        let mut shares = self.crossings(&a, &b);
        shares.extend([0.0, 1.0]);
        shares.sort_unstable_by(f64::total_cmp);
        let inside =
            shares.windows(2).filter(|pair| pair[1] > pair[0] && is_stock((pair[0] + pair[1]) / 2.0));
        inside.map(|pair| pair[1] - pair[0]).sum::<f64>() * length
    }

    /// How much of the blade of a cut beyond d would run in stock now.
    pub(super) fn beyond(&self, cut: &Cut) -> Beyond {
        let from = cut.reach.cutting + SLIT_OVERRUN_MM;
        let covered = |from: f64, to: f64| {
            if to > from { self.length_in_stock(&cut.at(from), &cut.at(to)) } else { 0.0 }
        };
        let edge = covered(from, cut.reach.edge);
        Beyond { edge, body: covered(from.max(cut.reach.edge), cut.reach.body) }
    }

    /// What of a line lies within the blank: there is no stock anywhere else.
    fn clipped(&self, a: &Point2, b: &Point2) -> Option<(Point2, Point2)> {
        let way = b - a;
        let (mut from, mut to) = (0.0_f64, 1.0_f64);
        let limits = [(a.x, way.x, self.profile.width()), (a.y, way.y, self.profile.blank_height())];
        for (start, step, limit) in limits {
            if step == 0.0 {
                if !(0.0..=limit).contains(&start) {
                    return None;
                }
                continue;
            }
            let (one, other) = (-start / step, (limit - start) / step);
            from = from.max(one.min(other));
            to = to.min(one.max(other));
        }
        (from < to).then(|| (a + way * from, a + way * to))
    }

    /// Where a line in the blank crosses edges of stock, as shares of its length, in no order.
    fn crossings(&self, a: &Point2, b: &Point2) -> Vec<f64> {
        let (from, to) = ([a.x * UNITS, a.y * UNITS], [b.x * UNITS, b.y * UNITS]);
        let mut shares = Vec::new();
        for tile in self.stock.grid.tiles_along(snapped(a), snapped(b), 1) {
            for piece in self.stock.pieces_in(tile) {
                shares.extend(piece.edges().filter_map(|edge| crossing(from, to, edge)));
            }
        }
        shares
    }
}

fn is_finite(point: &Point2) -> bool {
    point.x.is_finite() && point.y.is_finite()
}

/// Where the line between two places in units crosses an edge, as a share of its length.
fn crossing(from: [f64; 2], to: [f64; 2], [a, b]: [GridPoint; 2]) -> Option<f64> {
    let way = [to[0] - from[0], to[1] - from[1]];
    // The ends of edges are put on one side or the other; alike for both edges that meet in a point.
    let side = |p: GridPoint| way[0] * (p.y as f64 - from[1]) - way[1] * (p.x as f64 - from[0]);
    let (one, other) = (side(a), side(b));
    if (one >= 0.0) == (other >= 0.0) {
        return None;
    }
    let share = one / (one - other);
    let meet = [a.x as f64 + share * (b.x - a.x) as f64, a.y as f64 + share * (b.y - a.y) as f64];
    let axis = usize::from(way[1].abs() > way[0].abs());
    let along = (meet[axis] - from[axis]) / way[axis];
    (0.0..=1.0).contains(&along).then_some(along)
}
