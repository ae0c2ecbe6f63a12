//! Closed loops of points: area, sense, containment. A loop does not repeat its first point.

use super::Point2;

/// Signed area of a loop in mm^2 by the shoelace formula: positive if it turns counter-clockwise.
///
/// Coordinates are taken relative to the first point, so that a loop far from the origin loses no digits.
#[must_use]
pub fn signed_area(points: &[Point2]) -> f64 {
    let Some(origin) = points.first() else { return 0.0 };
    edges(points).map(|(a, b)| (a - origin).perp(&(b - origin))).sum::<f64>() / 2.0
}

/// The edges of a loop, the closing one last.
pub fn edges(points: &[Point2]) -> impl Iterator<Item = (&Point2, &Point2)> {
    points.iter().zip(points.iter().cycle().skip(1)).take(if points.len() < 2 { 0 } else { points.len() })
}

/// The first loop that lies inside another, and that other, of loops that do not cross.
#[must_use]
pub fn nested(loops: &[&[Point2]]) -> Option<(usize, usize)> {
    let extents: Vec<(Point2, Point2)> = loops.iter().map(|points| extent(points)).collect();
    (0..loops.len()).find_map(|inner| {
        let place = loops[inner].first()?;
        let around = |outer: &usize| {
            let (low, high) = &extents[*outer];
            let near = low.x <= place.x && place.x <= high.x && low.y <= place.y && place.y <= high.y;
            *outer != inner && near && contains(loops[*outer], place)
        };
        Some((inner, (0..loops.len()).find(around)?))
    })
}

/// The smallest and the largest coordinates of some points.
fn extent(points: &[Point2]) -> (Point2, Point2) {
    let least = Point2::new(f64::INFINITY, f64::INFINITY);
    points.iter().fold((least, -least), |(low, high), point| (low.inf(point), high.sup(point)))
}

/// Whether a point lies inside a loop (even-odd rule). On the outline either answer may come.
#[must_use]
pub fn contains(points: &[Point2], point: &Point2) -> bool {
    edges(points).filter(|(a, b)| crosses_ray(a, b, point)).count() % 2 == 1
}

/// Whether an edge crosses the ray from `point` toward +x. Half-open in y, so that a vertex counts once.
fn crosses_ray(a: &Point2, b: &Point2, point: &Point2) -> bool {
    (a.y > point.y) != (b.y > point.y) && point.x < a.x + (point.y - a.y) / (b.y - a.y) * (b.x - a.x)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square() -> Vec<Point2> {
        [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)].map(|(x, y)| Point2::new(x, y)).to_vec()
    }

    #[test]
    fn area_carries_the_sense() {
        let mut points = square();
        assert_eq!(signed_area(&points), 4.0);
        points.reverse();
        assert_eq!(signed_area(&points), -4.0);
    }

    #[test]
    fn a_ray_through_a_vertex_counts_once() {
        let diamond = [(0.0, -1.0), (1.0, 0.0), (0.0, 1.0), (-1.0, 0.0)].map(|(x, y)| Point2::new(x, y));
        assert!(contains(&diamond, &Point2::new(0.0, 0.0)));
        assert!(!contains(&diamond, &Point2::new(-2.0, 0.0)));
        assert!(!contains(&square(), &Point2::new(3.0, 2.0)));
    }
}
