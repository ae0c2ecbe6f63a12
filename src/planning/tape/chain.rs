//! Chains: the parts of a cut that one knife can make while the tape only advances (domain.md A5).
//!
//! The tape moves toward +U, so larger U passes a knife first, and a knife visits each u once. Every cut is
//! therefore split where dU changes its sign; the parts are the cut's U-monotone chains.

use serde::Serialize;

use crate::planning::geometry::Point2;
use crate::planning::tolerance::U_REVERSAL_MM;

/// A U-monotone part of a cut.
#[derive(Debug, Clone, PartialEq)]
pub struct Chain {
    /// Which cut of its piece it belongs to.
    pub cut: usize,
    /// Changes of direction of the whole cut, as the papers' Table 1 counts them.
    pub turns: usize,
    /// Whether the cut runs from tape edge to tape edge, so that the published rule covers it.
    pub edge_to_edge: bool,
    /// The sign of dV/dU.
    pub slope: Slope,
    /// (u, v) in mm in the order in which a knife makes them: u never increases.
    pub points: Vec<Point2>,
    /// How far, in mm, points were moved along u to make small steps back monotone.
    pub shift_mm: f64,
    /// Smallest and largest u at which the axis of a knife stands that makes it: those of the points, unless the edge of a
    /// blade lies beside its axis.
    pub busy_mm: (f64, f64),
}

/// The sign of dV/dU of a chain, U to the right and V up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Slope {
    /// `\`: dV/dU below 0.
    Falling,
    /// Square across the tape or lengthwise.
    Flat,
    /// `/`: dV/dU above 0.
    Rising,
}

impl Serialize for Slope {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_i8(match self {
            Self::Falling => -1,
            Self::Flat => 0,
            Self::Rising => 1,
        })
    }
}

impl Chain {
    /// Smallest and largest u.
    #[must_use]
    pub fn u_range(&self) -> (f64, f64) {
        (self.points[self.points.len() - 1].x, self.points[0].x)
    }

    /// Whether the chain is cut with the tape standing still.
    #[must_use]
    pub fn is_square(&self) -> bool {
        let (low, high) = self.u_range();
        high - low < U_REVERSAL_MM
    }
}

/// Splits a cut into its chains, in the order in which they lie along it.
///
/// A cut whose last point repeats its first is a closed one; it is opened at its largest u.
#[must_use]
pub fn split(cut: usize, points: &[Point2], half_width_mm: f64) -> Vec<Chain> {
    let closed = points.len() > 2 && points.first() == points.last();
    let points = if closed { opened_at_largest_u(points) } else { points.to_vec() };
    let turns = turning_points(&points);
    let ends = |point: &Point2| point.y.abs() == half_width_mm;
    let edge_to_edge = !closed && points[0].y == -points[points.len() - 1].y && ends(&points[0]);
    let bounds: Vec<usize> =
        std::iter::once(0).chain(turns.iter().copied()).chain(std::iter::once(points.len() - 1)).collect();
    bounds.windows(2).map(|pair| chain(cut, turns.len(), edge_to_edge, &points[pair[0]..=pair[1]])).collect()
}

fn opened_at_largest_u(points: &[Point2]) -> Vec<Point2> {
    let open = &points[..points.len() - 1];
    let largest = (0..open.len()).max_by(|&a, &b| open[a].x.total_cmp(&open[b].x)).unwrap_or(0);
    let mut turned: Vec<_> = open[largest..].iter().chain(&open[..largest]).copied().collect();
    turned.push(open[largest]);
    turned
}

/// The points at which the direction of U changes. A step back counts once it adds up to [`U_REVERSAL_MM`],
/// however many points it is spread over; a stretch of constant u belongs to the chain after it.
fn turning_points(points: &[Point2]) -> Vec<usize> {
    let mut turns = Vec::new();
    let (mut lowest, mut highest) = (0, 0);
    let mut direction = 0.0;
    for index in 1..points.len() {
        let u = points[index].x;
        if direction >= 0.0 && u > points[highest].x {
            highest = index;
        }
        if direction <= 0.0 && u < points[lowest].x {
            lowest = index;
        }
        let fell = points[highest].x - u >= U_REVERSAL_MM;
        let rose = u - points[lowest].x >= U_REVERSAL_MM;
        if fell && direction >= 0.0 {
            if direction > 0.0 {
                turns.push(highest);
            }
            (direction, lowest) = (-1.0, index);
        } else if rose && direction <= 0.0 {
            if direction < 0.0 {
                turns.push(lowest);
            }
            (direction, highest) = (1.0, index);
        }
    }
    turns
}

fn chain(cut: usize, turns: usize, edge_to_edge: bool, points: &[Point2]) -> Chain {
    let mut points = points.to_vec();
    if points[0].x < points[points.len() - 1].x {
        points.reverse();
    }
    let shift_mm = make_monotone(&mut points);
    let run = points[points.len() - 1] - points[0];
    let slope = if run.x.abs() < U_REVERSAL_MM || run.y == 0.0 {
        Slope::Flat
    } else if run.y / run.x > 0.0 {
        Slope::Rising
    } else {
        Slope::Falling
    };
    let busy_mm = (points[points.len() - 1].x, points[0].x);
    Chain { cut, turns, edge_to_edge, slope, points, shift_mm, busy_mm }
}

/// Moves points along u so that u never increases, by the least largest shift: each goes to the middle between
/// the smallest u before it and the largest u after it (isotonic regression in the maximum norm). Steps back
/// are below [`U_REVERSAL_MM`] here, so no point moves by more than half of that.
fn make_monotone(points: &mut [Point2]) -> f64 {
    let mut largest_after = vec![f64::NEG_INFINITY; points.len() + 1];
    for index in (0..points.len()).rev() {
        largest_after[index] = largest_after[index + 1].max(points[index].x);
    }
    let mut smallest_before = f64::INFINITY;
    let mut shift = 0.0_f64;
    for (point, largest_after) in points.iter_mut().zip(largest_after) {
        smallest_before = smallest_before.min(point.x);
        let middle = f64::midpoint(smallest_before, largest_after);
        shift = shift.max((middle - point.x).abs());
        point.x = middle;
    }
    shift
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn points(list: &[(f64, f64)]) -> Vec<Point2> {
        list.iter().map(|&(u, v)| Point2::new(u, v)).collect()
    }

    fn slopes(list: &[(f64, f64)]) -> Vec<(Slope, usize)> {
        split(0, &points(list), 37.5).iter().map(|chain| (chain.slope, chain.turns)).collect()
    }

    #[test]
    fn each_row_of_the_published_table_1() {
        assert_eq!(slopes(&[(0.0, 37.5), (75.0, -37.5)]), [(Slope::Falling, 0)]);
        assert_eq!(slopes(&[(0.0, -37.5), (75.0, 37.5)]), [(Slope::Rising, 0)]);
        assert_eq!(slopes(&[(0.0, -37.5), (0.0, 37.5)]), [(Slope::Flat, 0)]);
        let greater = [(362.5, -37.5), (400.0, 0.0), (362.5, 37.5)];
        assert_eq!(slopes(&greater), [(Slope::Rising, 1), (Slope::Falling, 1)]);
        let less = [(37.5, -37.5), (0.0, 0.0), (37.5, 37.5)];
        assert_eq!(slopes(&less), [(Slope::Falling, 1), (Slope::Rising, 1)]);
        assert_eq!(slopes(&[(360.0, -37.5), (400.0, -12.5), (300.0, 12.5), (340.0, 37.5)]).len(), 3);
    }

    #[test]
    fn a_knife_makes_larger_u_first() {
        let chains = split(0, &points(&[(362.5, -37.5), (400.0, 0.0), (362.5, 37.5)]), 37.5);
        assert!(chains.iter().all(|chain| chain.points[0].x == 400.0));
        let chains = split(0, &points(&[(37.5, -37.5), (0.0, 0.0), (37.5, 37.5)]), 37.5);
        assert!(chains.iter().all(|chain| chain.points[0].x == 37.5));
    }

    #[test]
    fn plus_zero_minus_is_one_change() {
        assert_eq!(slopes(&[(0.0, -37.5), (20.0, -10.0), (20.0, 10.0), (0.0, 37.5)]).len(), 2);
        assert_eq!(slopes(&[(0.0, -37.5), (20.0, -10.0), (20.0, 10.0), (40.0, 37.5)]).len(), 1);
    }

    #[test]
    fn small_steps_back_are_no_change_until_they_add_up() {
        let wiggle = [(0.0, -37.5), (10.0, -10.0), (9.995, 0.0), (20.0, 37.5)];
        let chains = split(0, &points(&wiggle), 37.5);
        assert_eq!(chains.len(), 1);
        assert!((chains[0].shift_mm - 0.0025).abs() < 1e-12);
        let creeping: Vec<_> = (0..=100).map(|i| (10.0 - 0.005 * f64::from(i), f64::from(i) * 0.1)).collect();
        let there_and_back: Vec<_> =
            [(0.0, -37.5), (10.0, -10.0)].into_iter().chain(creeping).chain([(30.0, 37.5)]).collect();
        assert_eq!(split(0, &points(&there_and_back), 37.5).len(), 3);
    }

    #[test]
    fn a_hole_is_two_chains_from_its_largest_u() {
        let circle: Vec<_> = (0..=360)
            .map(|i| f64::from(i % 360).to_radians())
            .map(|angle| Point2::new(100.0 + 30.0 * angle.sin(), 30.0 * angle.cos()))
            .collect();
        let chains = split(0, &circle, 75.0);
        assert_eq!(chains.len(), 2);
        assert!(chains.iter().all(|chain| chain.points[0].x == 130.0 && !chain.edge_to_edge));
    }

    proptest! {
        #[test]
        fn chains_are_monotone_complete_and_barely_moved(steps in prop::collection::vec(-3.0..3.0_f64, 2..60)) {
            let mut u = 0.0;
            let cut: Vec<_> = steps.iter().enumerate().map(|(i, step)| {
                u += step * step * step * 0.01;
                Point2::new(u, i as f64)
            }).collect();
            let chains = split(0, &cut, 1e9);
            for chain in &chains {
                prop_assert!(chain.points.windows(2).all(|pair| pair[1].x <= pair[0].x));
                prop_assert!(chain.shift_mm <= U_REVERSAL_MM / 2.0 + 1e-12);
            }
            // Every point of the cut is in a chain, the turning points in two.
            let total: usize = chains.iter().map(|chain| chain.points.len()).sum();
            prop_assert_eq!(total, cut.len() + chains.len() - 1);
        }
    }
}
