//! Thinning of polylines to a chord tolerance.

use super::Point2;

/// The indices of the points that a polyline keeps so that no dropped point lies farther than `tolerance_mm`
/// from the segment that replaces it (Douglas and Peucker 1973). First and last point always stay.
///
/// The distance is to the segment, not to the line through it: a polyline that turns back keeps its turn.
#[must_use]
pub fn kept(points: &[Point2], tolerance_mm: f64) -> Vec<usize> {
    if points.len() < 3 {
        return (0..points.len()).collect();
    }
    let mut keep = vec![false; points.len()];
    keep[0] = true;
    keep[points.len() - 1] = true;
    let mut spans = vec![(0, points.len() - 1)];
    while let Some((first, last)) = spans.pop() {
        if let Some((index, distance)) = farthest(points, first, last)
            && distance > tolerance_mm
        {
            keep[index] = true;
            spans.push((first, index));
            spans.push((index, last));
        }
    }
    keep.iter().enumerate().filter_map(|(index, kept)| kept.then_some(index)).collect()
}

fn farthest(points: &[Point2], first: usize, last: usize) -> Option<(usize, f64)> {
    (first + 1..last)
        .map(|index| (index, distance_to_segment(&points[index], &points[first], &points[last])))
        .max_by(|a, b| a.1.total_cmp(&b.1))
}

/// Distance in mm from a point to a segment.
#[must_use]
pub fn distance_to_segment(point: &Point2, a: &Point2, b: &Point2) -> f64 {
    let along = b - a;
    let squared = along.norm_squared();
    if squared == 0.0 {
        return (point - a).norm();
    }
    let t = ((point - a).dot(&along) / squared).clamp(0.0, 1.0);
    (point - (a + along * t)).norm()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_straight_line_keeps_its_ends() {
        let points: Vec<_> = (0..100).map(|i| Point2::new(f64::from(i), f64::from(i) * 0.5)).collect();
        assert_eq!(kept(&points, 1e-9), vec![0, 99]);
    }

    #[test]
    fn no_dropped_point_leaves_the_tolerance_on_a_circle() {
        let points: Vec<_> = (0..=3000)
            .map(|i| {
                let angle = f64::from(i) * 1e-3;
                Point2::new(60.0 * angle.cos(), 60.0 * angle.sin())
            })
            .collect();
        let kept = kept(&points, 0.01);
        for pair in kept.windows(2) {
            for point in &points[pair[0]..=pair[1]] {
                assert!(distance_to_segment(point, &points[pair[0]], &points[pair[1]]) <= 0.01);
            }
        }
        // A chord of sagitta 0.01 on R 60 is 2.19 mm long: 82 chords on 3 rad would be the fewest.
        assert!(kept.len() < 180, "{} points kept", kept.len());
    }

    #[test]
    fn a_turn_back_on_the_line_itself_is_kept() {
        let points = [(0.0, 0.0), (10.0, 0.0), (5.0, 0.0)].map(|(x, y)| Point2::new(x, y));
        assert_eq!(kept(&points, 0.01), vec![0, 1, 2]);
    }
}
