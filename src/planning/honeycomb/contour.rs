//! How like a cut contour is to the wanted one: the paper's Eq. 15, and the largest deviation (domain.md B5).
//!
//! Cui et al. 2020, section IV.B: both curves are resampled to 1000 points by linear interpolation; their likeness
//! is the peak of the normalised cross-correlation. Taken as printed it hides a constant error of height, for no
//! mean is removed; so the value with the means removed stands beside it.

use crate::planning::geometry::Point2;

/// The paper's number of points.
pub const SAMPLES: usize = 1000;

/// What a comparison gives.
#[derive(Debug, Clone, PartialEq)]
pub struct Likeness {
    /// The peak of Eq. 15 as printed, at most 1. None if a curve lies at height 0 throughout.
    pub correlation: Option<f64>,
    /// The same with the means removed. None if a curve is level.
    pub correlation_mean_removed: Option<f64>,
    /// The largest distance of a sample of the cut contour from the wanted one, in mm.
    pub max_deviation_mm: f64,
    /// x of that sample.
    pub max_deviation_x_mm: f64,
    /// Both curves, as they were compared.
    pub samples: Samples,
}

/// Two curves at the same x.
#[derive(Debug, Clone, PartialEq)]
pub struct Samples {
    /// Smallest and largest x in mm.
    pub range: (f64, f64),
    /// z of the wanted contour.
    pub wanted: Vec<f64>,
    /// z of the cut contour.
    pub cut: Vec<f64>,
}

/// Compares a cut contour, as polylines of (x, z) in mm, with the wanted one.
///
/// Where a contour has several heights at one x the highest counts: it is what a camera or a probe from above
/// would see. Only the x that both have are compared; `None` if there are none.
#[must_use]
pub fn compare(wanted: &[Point2], cut: &[Vec<Point2>]) -> Option<Likeness> {
    let all: Vec<Point2> = cut.iter().flatten().copied().collect();
    let (own, other) = (range_of(wanted)?, range_of(&all)?);
    let range = (own.0.max(other.0), own.1.min(other.1));
    if range.0 >= range.1 {
        return None;
    }
    let samples = Samples {
        range,
        wanted: resampled(std::slice::from_ref(&wanted.to_vec()), range),
        cut: resampled(cut, range),
    };
    let (max_deviation_mm, max_deviation_x_mm) = samples.largest_deviation(wanted);
    let correlation = peak(&samples.wanted, &samples.cut);
    let correlation_mean_removed = peak(&level(&samples.wanted), &level(&samples.cut));
    Some(Likeness { correlation, correlation_mean_removed, max_deviation_mm, max_deviation_x_mm, samples })
}

impl Samples {
    /// x of a sample in mm.
    #[must_use]
    pub fn x(&self, index: usize) -> f64 {
        sample_x(self.range, index)
    }

    /// The largest distance of a sample from the wanted contour, and its x.
    fn largest_deviation(&self, wanted: &[Point2]) -> (f64, f64) {
        let places = self.cut.iter().enumerate().map(|(index, &z)| Point2::new(self.x(index), z));
        places
            .map(|place| (distance(&place, wanted), place.x))
            .fold((0.0, self.range.0), |most, next| if next.0 > most.0 { next } else { most })
    }

    /// The normalised cross-correlation at each lag from -(n-1) to n-1 (the paper's Fig. 15).
    #[must_use]
    pub fn correlation_function(&self) -> Vec<f64> {
        correlation(&self.wanted, &self.cut).unwrap_or_default()
    }
}

fn sample_x(range: (f64, f64), index: usize) -> f64 {
    let share = index as f64 / (SAMPLES - 1) as f64;
    range.0 + share * (range.1 - range.0)
}

fn range_of(points: &[Point2]) -> Option<(f64, f64)> {
    let low = points.iter().map(|point| point.x).reduce(f64::min)?;
    let high = points.iter().map(|point| point.x).reduce(f64::max)?;
    Some((low, high))
}

/// The highest z of some polylines at each sample. Every segment is looked at once.
fn resampled(lines: &[Vec<Point2>], range: (f64, f64)) -> Vec<f64> {
    let mut heights = vec![f64::NEG_INFINITY; SAMPLES];
    let step = (range.1 - range.0) / (SAMPLES - 1) as f64;
    for pair in lines.iter().flat_map(|line| line.windows(2)) {
        let (left, right) = if pair[0].x <= pair[1].x { (pair[0], pair[1]) } else { (pair[1], pair[0]) };
        let first = ((left.x - range.0) / step).ceil().max(0.0) as usize;
        let last = ((right.x - range.0) / step).floor().min((SAMPLES - 1) as f64);
        if last < 0.0 {
            continue;
        }
        for (index, height) in heights.iter_mut().enumerate().take(last as usize + 1).skip(first) {
            *height = height.max(height_at(left, right, sample_x(range, index)));
        }
    }
    fill_gaps(&mut heights);
    heights
}

/// z of a segment at x; the higher end of a wall.
fn height_at(left: Point2, right: Point2, x: f64) -> f64 {
    let width = right.x - left.x;
    if width <= 0.0 {
        return left.y.max(right.y);
    }
    let share = ((x - left.x) / width).clamp(0.0, 1.0);
    left.y + share * (right.y - left.y)
}

/// A sample that no segment covers, by rounding at an end or between two lines, has the height of its neighbour.
fn fill_gaps(heights: &mut [f64]) {
    let mut last = heights.iter().copied().find(|height| height.is_finite()).unwrap_or(0.0);
    for height in heights {
        if height.is_finite() {
            last = *height;
        } else {
            *height = last;
        }
    }
}

fn level(heights: &[f64]) -> Vec<f64> {
    let mean = heights.iter().sum::<f64>() / heights.len() as f64;
    heights.iter().map(|height| height - mean).collect()
}

/// The peak of Eq. 15.
fn peak(one: &[f64], other: &[f64]) -> Option<f64> {
    correlation(one, other).map(|values| values.into_iter().fold(f64::NEG_INFINITY, f64::max))
}

/// Eq. 15 at each lag. None if a curve has no energy, for then it says nothing.
fn correlation(one: &[f64], other: &[f64]) -> Option<Vec<f64>> {
    let energy = |curve: &[f64]| curve.iter().map(|value| value * value).sum::<f64>();
    // A level curve whose mean was removed has nothing left but rounding.
    let least = |curve: &[f64]| curve.len() as f64 * LEAST_HEIGHT_MM * LEAST_HEIGHT_MM;
    let (first, second) = (energy(one), energy(other));
    if first <= least(one) || second <= least(other) {
        return None;
    }
    let scale = (first * second).sqrt();
    let count = one.len();
    let at = |lag: usize| {
        let later = |a: &[f64], b: &[f64]| a[lag..].iter().zip(b).map(|(x, y)| x * y).sum::<f64>() / scale;
        (later(other, one), later(one, other))
    };
    let (forward, backward): (Vec<f64>, Vec<f64>) = (0..count).map(at).unzip();
    Some(backward.into_iter().skip(1).rev().chain(forward).collect())
}

/// Heights below this, in mm, are the rounding of a mean: a millionth of the positioning of any robot.
const LEAST_HEIGHT_MM: f64 = 1e-7;

/// z of a polyline whose x never falls, at an x within it; the higher end of a wall.
#[must_use]
pub fn height(line: &[Point2], x: f64) -> f64 {
    let here = line.partition_point(|vertex| vertex.x < x).clamp(1, line.len() - 1);
    let walls = line[here - 1..].windows(2).take_while(|pair| pair[0].x <= x);
    walls.map(|pair| height_at(pair[0], pair[1], x)).fold(f64::NEG_INFINITY, f64::max)
}

/// Distance of a point from a polyline whose x never falls, in mm.
#[must_use]
pub fn distance(point: &Point2, line: &[Point2]) -> f64 {
    (foot(point, line) - point).norm()
}

/// The nearest point of a polyline whose x never falls. The search goes outward from the point's own x and ends
/// where x alone is farther than the best found.
#[must_use]
pub fn foot(point: &Point2, line: &[Point2]) -> Point2 {
    let here = line.partition_point(|vertex| vertex.x < point.x).clamp(1, line.len() - 1);
    let (mut best, mut nearest) = (f64::INFINITY, line[0]);
    let mut look = |pair: &[Point2]| {
        let foot = foot_on_segment(point, pair[0], pair[1]);
        let away = (foot - point).norm();
        if away < best {
            (best, nearest) = (away, foot);
        }
        best
    };
    let mut nearest_yet = f64::INFINITY;
    for pair in line[here - 1..].windows(2) {
        if pair[0].x - point.x > nearest_yet {
            break;
        }
        nearest_yet = look(pair);
    }
    for pair in line[..here].windows(2).rev() {
        if point.x - pair[1].x > nearest_yet {
            break;
        }
        nearest_yet = look(pair);
    }
    nearest
}

fn foot_on_segment(point: &Point2, from: Point2, to: Point2) -> Point2 {
    let (along, away) = (to - from, point - from);
    let length = along.norm_squared();
    let share = if length > 0.0 { (away.dot(&along) / length).clamp(0.0, 1.0) } else { 0.0 };
    from + along * share
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn line(points: &[(f64, f64)]) -> Vec<Point2> {
        points.iter().map(|&(x, z)| Point2::new(x, z)).collect()
    }

    fn hill(shift: f64, lift: f64) -> Vec<Point2> {
        (0..=200)
            .map(|i| f64::from(i) * 0.425)
            .map(|x| Point2::new(x, 20.0 + lift + 5.0 * ((x - shift) / 20.0).sin()))
            .collect()
    }

    #[test]
    fn a_curve_is_like_itself() {
        let found = compare(&hill(0.0, 0.0), &[hill(0.0, 0.0)]).unwrap();
        assert!((found.correlation.unwrap() - 1.0).abs() < 1e-12);
        assert!((found.correlation_mean_removed.unwrap() - 1.0).abs() < 1e-12);
        assert!(found.max_deviation_mm < 1e-9);
        let function = found.samples.correlation_function();
        assert_eq!(function.len(), 2 * SAMPLES - 1);
        assert!((function[SAMPLES - 1] - 1.0).abs() < 1e-12, "lag 0 stands in the middle");
    }

    #[test]
    fn an_error_of_height_shows_in_the_deviation_and_hardly_in_the_printed_formula() {
        let found = compare(&hill(0.0, 0.0), &[hill(0.0, 3.0)]).unwrap();
        assert!(found.correlation.unwrap() > 0.999, "{found:?}");
        assert!((found.correlation_mean_removed.unwrap() - 1.0).abs() < 1e-9);
        assert!(found.max_deviation_mm > 2.8 && found.max_deviation_mm <= 3.0);
    }

    #[test]
    fn eq_15_by_hand() {
        // R_xy at lags -1, 0, 1 of (1, 2) and (3, 1): 1*1, 1*3 + 2*1, 2*3; the energies are 5 and 10.
        let found = correlation(&[1.0, 2.0], &[3.0, 1.0]).unwrap();
        let wanted = [6.0, 5.0, 1.0].map(|value| value / 50.0_f64.sqrt());
        assert!(found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?}");
    }

    #[test]
    fn level_or_absent_curves_say_nothing() {
        let flat = line(&[(0.0, 0.0), (10.0, 0.0)]);
        let found = compare(&flat, std::slice::from_ref(&flat)).unwrap();
        assert_eq!((found.correlation, found.correlation_mean_removed), (None, None));
        assert!(compare(&flat, &[line(&[(20.0, 0.0), (30.0, 0.0)])]).is_none());
        assert!(compare(&flat, &[]).is_none());
    }

    #[test]
    fn the_highest_line_counts_and_walls_have_their_upper_end() {
        let low = line(&[(0.0, 1.0), (10.0, 1.0)]);
        let step = line(&[(2.0, 0.0), (2.0, 4.0), (6.0, 4.0), (6.0, 0.0)]);
        let heights = resampled(&[low, step], (0.0, 10.0));
        let at = |x: f64| heights[(x / 10.0 * (SAMPLES - 1) as f64).round() as usize];
        assert_eq!((at(1.0), at(4.0), at(9.0)), (1.0, 4.0, 1.0));
    }

    proptest! {
        #[test]
        fn the_short_search_finds_the_nearest(
            steps in prop::collection::vec((0.0..3.0, 0.0..9.0), 2..30),
            x in -5.0..60.0, z in -5.0..15.0
        ) {
            let mut at = 0.0;
            let line: Vec<Point2> = steps.iter().map(|&(step, z)| { at += step; Point2::new(at, z) }).collect();
            let point = Point2::new(x, z);
            let slow = line.windows(2).map(|p| (foot_on_segment(&point, p[0], p[1]) - point).norm()).fold(f64::INFINITY, f64::min);
            prop_assert_eq!(distance(&point, &line), slow);
        }
    }
}
