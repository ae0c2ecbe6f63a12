//! Whether a disc fits into a region of the plane.
//!
//! Squares that cover the region are split until one has a middle that is far enough inside, or none is left that could
//! have one. The signed distance to the outline is that to its nearest edge; beside a corner the sum of the normals of
//! both edges tells the side. A square keeps the edges that can be nearest to any of its points, so that the
//! work is that of the outline's length in radii and not of all pairs.

use super::{Point2, Vector2};

/// A square is split no further once half its diagonal is less than this share of the radius: a disc that fits by less
/// than that may be taken for one that does not.
const RESOLUTION: f64 = 1.0 / 64.0;

/// Whether a disc of that radius in mm lies somewhere in the region on the left of these loops, which do not repeat
/// their first points and cross neither themselves nor each other.
#[must_use]
pub fn fits(loops: &[Vec<Point2>], radius_mm: f64) -> bool {
    let edges: Vec<Edge> = loops.iter().flat_map(|points| edges_of(points)).collect();
    let Some(root) = Square::around(&edges) else { return false };
    let mut squares = vec![root];
    while let Some(square) = squares.pop() {
        if square.inside_mm >= radius_mm {
            return true;
        }
        if square.half_diagonal() < RESOLUTION * radius_mm {
            continue;
        }
        let mut parts = square.parts(&edges);
        parts.retain(|part| part.inside_mm + part.half_diagonal() >= radius_mm);
        parts.sort_by(|a, b| a.inside_mm.total_cmp(&b.inside_mm));
        squares.extend(parts);
    }
    false
}

/// An edge of a region, which lies on its left.
struct Edge {
    from: Point2,
    to: Point2,
    /// Its left normal of length 1, and the sums with those of the edges before and after it.
    normal: Vector2,
    corners: [Vector2; 2],
}

fn edges_of(points: &[Point2]) -> Vec<Edge> {
    let mut points = points.to_vec();
    points.dedup();
    let count = points.len();
    let left = |index: usize| {
        let along = points[(index + 1) % count] - points[index % count];
        Vector2::new(-along.y, along.x).try_normalize(0.0).unwrap_or_default()
    };
    (0..count)
        .map(|index| {
            let normal = left(index);
            let corners = [left(index + count - 1) + normal, normal + left(index + 1)];
            Edge { from: points[index], to: points[(index + 1) % count], normal, corners }
        })
        .collect()
}

impl Edge {
    /// The distance of a point, and whether it is on the left.
    fn distance(&self, point: &Point2) -> (f64, bool) {
        let (along, away) = (self.to - self.from, point - self.from);
        let share = away.dot(&along) / along.norm_squared().max(f64::MIN_POSITIVE);
        let (nearest, normal) = if share <= 0.0 {
            (self.from, &self.corners[0])
        } else if share >= 1.0 {
            (self.to, &self.corners[1])
        } else {
            (self.from + along * share, &self.normal)
        };
        let away = point - nearest;
        (away.norm(), away.dot(normal) > 0.0)
    }
}

/// A square with the edges that can be nearest to one of its points.
struct Square {
    middle: Point2,
    half: f64,
    /// How far its middle is inside the region, in mm; negative outside.
    inside_mm: f64,
    near: Vec<u32>,
}

impl Square {
    fn around(edges: &[Edge]) -> Option<Self> {
        let first = edges.first()?.from;
        let (low, high) = edges
            .iter()
            .fold((first, first), |(low, high), edge| (low.inf(&edge.from), high.sup(&edge.from)));
        let size = high - low;
        let every: Vec<u32> = (0..edges.len() as u32).collect();
        Some(Self::new(low + size / 2.0, size.max() / 2.0, &every, edges))
    }

    fn new(middle: Point2, half: f64, candidates: &[u32], edges: &[Edge]) -> Self {
        let distances: Vec<(f64, bool)> =
            candidates.iter().map(|&edge| edges[edge as usize].distance(&middle)).collect();
        let nearest = distances.iter().min_by(|a, b| a.0.total_cmp(&b.0)).copied();
        let (distance, inside) = nearest.unwrap_or((f64::INFINITY, false));
        // From a point of the square the nearest edge is no farther than the middle's and half a diagonal.
        let reach = distance + 2.0 * half * std::f64::consts::SQRT_2;
        let near = candidates.iter().zip(&distances).filter(|(_, (distance, _))| *distance <= reach);
        let near = near.map(|(edge, _)| *edge).collect();
        Self { middle, half, inside_mm: if inside { distance } else { -distance }, near }
    }

    fn half_diagonal(&self) -> f64 {
        self.half * std::f64::consts::SQRT_2
    }

    fn parts(&self, edges: &[Edge]) -> Vec<Self> {
        let quarter = self.half / 2.0;
        let shifts = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)];
        let middles = shifts.map(|(x, y)| self.middle + Vector2::new(x, y) * quarter);
        middles.into_iter().map(|middle| Self::new(middle, quarter, &self.near, edges)).collect()
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::polygon::{contains, edges};
    use super::*;

    fn points(list: &[(f64, f64)]) -> Vec<Point2> {
        list.iter().map(|&(x, y)| Point2::new(x, y)).collect()
    }

    #[test]
    fn a_strip_holds_a_disc_as_wide_as_itself_and_none_wider() {
        let strip = points(&[(0.0, 0.0), (4000.0, 30.0), (4000.0, 33.0), (0.0, 3.0)]);
        let width = 3.0 * 4000.0 / 4000_f64.hypot(30.0);
        assert!(fits(std::slice::from_ref(&strip), width / 2.0 * 0.98));
        assert!(!fits(std::slice::from_ref(&strip), width / 2.0 * 1.001));
    }

    /// A triangle holds a disc of twice its area over its perimeter.
    #[test]
    fn a_needle_of_three_corners_holds_its_inscribed_circle() {
        let needle = points(&[(0.0, 0.0), (200.0, 0.0), (0.0, 6.0)]);
        let radius = 2.0 * 600.0 / (200.0 + 6.0 + 200_f64.hypot(6.0));
        assert!(fits(std::slice::from_ref(&needle), radius * 0.98));
        assert!(!fits(std::slice::from_ref(&needle), radius * 1.001));
    }

    #[test]
    fn what_a_hole_leaves_is_looked_at_and_outside_nothing_fits() {
        let plate = points(&[(0.0, 0.0), (100.0, 0.0), (100.0, 100.0), (0.0, 100.0)]);
        let hole = points(&[(4.0, 4.0), (4.0, 96.0), (96.0, 96.0), (96.0, 4.0)]);
        let ring = [plate.clone(), hole];
        // In a corner: a circle of radius r through (4, 4) touches both sides if (4 - r) sqrt 2 = r.
        let corner = 4.0 * std::f64::consts::SQRT_2 / (1.0 + std::f64::consts::SQRT_2);
        assert!(fits(&ring, corner * 0.98) && !fits(&ring, corner * 1.001));
        assert!(!fits(&[], 1.0) && !fits(&[points(&[(0.0, 0.0)])], 1.0));
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 40, failure_persistence: None, ..ProptestConfig::default() })]
        /// Against every point of a grid: nowhere is one farther inside than a disc that does not fit.
        #[test]
        fn no_point_of_a_grid_is_farther_inside(radii in prop::collection::vec(2.0..20.0_f64, 3..12), radius in 0.5..8.0_f64) {
            let corner = |(i, radius): (usize, &f64)| {
                let angle = std::f64::consts::TAU * i as f64 / radii.len() as f64;
                Point2::new(radius * angle.cos(), radius * angle.sin())
            };
            let star: Vec<Point2> = radii.iter().enumerate().map(corner).collect();
            let distance = |point: &Point2| edges(&star).map(|(a, b)| {
                let share = ((point - a).dot(&(b - a)) / (b - a).norm_squared()).clamp(0.0, 1.0);
                (point - (a + (b - a) * share)).norm()
            }).fold(f64::INFINITY, f64::min);
            let grid = (-80..=80).flat_map(|x| (-80..=80).map(move |y| Point2::new(f64::from(x) / 4.0, f64::from(y) / 4.0)));
            let most = grid.filter(|point| contains(&star, point)).map(|point| distance(&point)).fold(0.0, f64::max);
            if fits(std::slice::from_ref(&star), radius) {
                // The grid misses the best place by half its diagonal.
                prop_assert!(most + 0.18 >= radius, "{} {}", most, radius);
            } else {
                prop_assert!(most <= radius * (1.0 + RESOLUTION), "{} {}", most, radius);
            }
        }
    }
}
