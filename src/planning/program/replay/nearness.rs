//! Where along a straight piece some other pieces are near: exact, segment against segment.
//!
//! The points within a radius of a segment form a convex set (a capsule), so the part of a straight line in
//! it is one span, and it follows from two circles and a slab in closed form. What is near to many segments is
//! the union of such spans; no point is sampled. The smallest radius at which the union leaves no gap is the
//! one-sided Hausdorff distance; it is found by halving an interval. Distance changes along a line at most as
//! fast as the line advances, so ignoring gaps up to [`GAP_MM`] errs by half of that, and the error of the
//! whole is below 1e-9 mm.

/// A gap between spans that is no longer than this, in mm, comes from the rounding of f64, which is below
/// 1e-10 mm for the coordinates of a roll.
pub(super) const GAP_MM: f64 = 5e-10;

/// The radius of a Hausdorff distance is found to this, in mm.
const RADIUS_MM: f64 = 1e-11;

/// A part of a probe: from and to, in mm from its beginning.
pub(super) type Span = (f64, f64);

/// A straight piece from a to b.
pub(super) type Segment = [[f64; 2]; 2];

/// A straight piece along which something is looked for.
#[derive(Debug, Clone, Copy)]
pub(super) struct Probe {
    origin: [f64; 2],
    direction: [f64; 2],
    /// Its length in mm.
    pub(super) length: f64,
}

impl Probe {
    /// The probe along a segment that has a length.
    pub(super) fn along([a, b]: Segment) -> Self {
        let way = [b[0] - a[0], b[1] - a[1]];
        let length = way[0].hypot(way[1]);
        Self { origin: a, direction: [way[0] / length, way[1] / length], length }
    }

    /// The point at a distance from its beginning.
    pub(super) fn point(&self, along: f64) -> [f64; 2] {
        [self.origin[0] + along * self.direction[0], self.origin[1] + along * self.direction[1]]
    }

    /// The part of it within a radius of a point.
    pub(super) fn near_point(&self, point: [f64; 2], radius: f64) -> Option<Span> {
        self.clip(self.line_near_point(point, radius)?)
    }

    /// The part of it within a radius of a segment.
    pub(super) fn near_segment(&self, segment: Segment, radius: f64) -> Option<Span> {
        let parts = [
            self.line_near_point(segment[0], radius),
            self.line_near_point(segment[1], radius),
            self.line_beside(segment, radius),
        ];
        let whole = parts.into_iter().flatten().reduce(|one, other| (one.0.min(other.0), one.1.max(other.1)));
        self.clip(whole?)
    }

    fn clip(&self, (from, to): Span) -> Option<Span> {
        let clipped = (from.max(0.0), to.min(self.length));
        (clipped.0 <= clipped.1).then_some(clipped)
    }

    /// The probe's whole line in a circle.
    fn line_near_point(&self, point: [f64; 2], radius: f64) -> Option<Span> {
        let [x, y] = self.way_to(point);
        let along = x * self.direction[0] + y * self.direction[1];
        let off = (self.direction[0] * y - self.direction[1] * x).abs();
        if off > radius {
            return None;
        }
        // The product keeps the digits that a difference of squares loses where the line only touches.
        let half = ((radius - off) * (radius + off)).sqrt();
        Some((along - half, along + half))
    }

    /// The probe's whole line in the slab on both sides of a segment.
    fn line_beside(&self, segment: Segment, radius: f64) -> Option<Span> {
        let other = Self::along(segment);
        let [x, y] = other.way_to(self.origin);
        let [ex, ey] = other.direction;
        let [dx, dy] = self.direction;
        let along = between(x * ex + y * ey, dx * ex + dy * ey, (0.0, other.length))?;
        let off = between(ex * y - ey * x, ex * dy - ey * dx, (-radius, radius))?;
        Some((along.0.max(off.0), along.1.min(off.1))).filter(|(from, to)| from <= to)
    }

    /// The way from the probe's beginning to a point.
    fn way_to(&self, point: [f64; 2]) -> [f64; 2] {
        [point[0] - self.origin[0], point[1] - self.origin[1]]
    }
}

/// Where `start + slope s` lies between two values.
fn between(start: f64, slope: f64, (low, high): Span) -> Option<Span> {
    if slope == 0.0 {
        return (low..=high).contains(&start).then_some((f64::NEG_INFINITY, f64::INFINITY));
    }
    let (one, other) = ((low - start) / slope, (high - start) / slope);
    Some((one.min(other), one.max(other)))
}

/// The distance in mm of a point from a segment that has a length.
pub(super) fn to_segment(point: [f64; 2], [a, b]: Segment) -> f64 {
    let (way, to) = ([b[0] - a[0], b[1] - a[1]], [point[0] - a[0], point[1] - a[1]]);
    let share = (to[0] * way[0] + to[1] * way[1]) / (way[0] * way[0] + way[1] * way[1]);
    let share = share.clamp(0.0, 1.0);
    let off = [to[0] - share * way[0], to[1] - share * way[1]];
    (off[0] * off[0] + off[1] * off[1]).sqrt()
}

/// The parts of a probe's `part` that lie farther than a radius from all of some segments.
pub(super) fn far_parts(probe: &Probe, part: Span, others: &[Segment], radius: f64) -> Vec<Span> {
    gaps(others.iter().filter_map(|other| probe.near_segment(*other, radius)).collect(), part)
}

/// What some spans leave of a part, but for gaps up to [`GAP_MM`].
pub(super) fn gaps(mut spans: Vec<Span>, part: Span) -> Vec<Span> {
    spans.sort_by(|one, other| one.0.total_cmp(&other.0));
    let mut gaps = Vec::new();
    let mut reached = part.0;
    for (from, to) in spans {
        if from.min(part.1) - reached > GAP_MM {
            gaps.push((reached, from.min(part.1)));
        }
        reached = reached.max(to);
    }
    if part.1 - reached > GAP_MM {
        gaps.push((reached, part.1));
    }
    gaps
}

/// Whether all of a probe's `part` lies within a radius of some segments.
pub(super) fn is_near(probe: &Probe, part: Span, others: &[Segment], radius: f64) -> bool {
    far_parts(probe, part, others, radius).is_empty()
}

/// The largest distance in mm from a point of a probe's `part` to the nearest of some segments, which is known
/// to be no more than `most`. If it is no more than `least`, that is the answer.
pub(super) fn distance(probe: &Probe, part: Span, others: &[Segment], least: f64, most: f64) -> f64 {
    if is_near(probe, part, others, least) {
        return least;
    }
    // Along the probe the distance from one segment is greatest at an end, and that from all is no less than at an end.
    let ends = [probe.point(part.0), probe.point(part.1)];
    let off_one = |other: &Segment| to_segment(ends[0], *other).max(to_segment(ends[1], *other));
    let off_all = |end: [f64; 2]| others.iter().map(|other| to_segment(end, *other)).fold(most, f64::min);
    let mut below = least.max(off_all(ends[0]).max(off_all(ends[1])));
    let mut above = others.iter().map(off_one).fold(most, f64::min);
    while above - below > RADIUS_MM {
        let middle = f64::midpoint(below, above);
        if is_near(probe, part, others, middle) {
            above = middle;
        } else {
            below = middle;
        }
    }
    above
}

#[cfg(test)]
mod tests {
    use super::*;

    const UP: Segment = [[0.0, 0.0], [0.0, 10.0]];

    #[test]
    fn a_capsule_is_two_half_circles_and_a_slab() {
        let across = Probe::along([[-5.0, 4.0], [5.0, 4.0]]);
        assert_eq!(across.near_segment(UP, 2.0), Some((3.0, 7.0)));
        let above = Probe::along([[-5.0, 13.0], [5.0, 13.0]]);
        assert_eq!(above.near_segment(UP, 5.0), Some((1.0, 9.0)));
        assert_eq!(above.near_segment(UP, 2.9), None);
        let beside = Probe::along([[2.0, -8.0], [2.0, 18.0]]);
        let (from, to) = beside.near_segment(UP, 2.5).unwrap();
        assert!((from - 6.5).abs() < 1e-12 && (to - 19.5).abs() < 1e-12);
    }

    #[test]
    fn the_distance_to_two_points_apart_is_in_their_middle() {
        let probe = Probe::along([[0.0, 0.0], [8.0, 0.0]]);
        let others = [[[1.0, 3.0], [1.0, 9.0]], [[7.0, 4.0], [7.0, 5.0]]];
        // (x-1)^2 + 9 = (x-7)^2 + 16
        let x: f64 = 55.0 / 12.0;
        let expected = (x - 1.0).hypot(3.0);
        let found = distance(&probe, (0.0, 8.0), &others, 0.0, 100.0);
        assert!((found - expected).abs() < 1e-9, "{found} {expected}");
    }

    proptest::proptest! {
        /// Brute force: the nearest segment of each of many points. Between two of them the distance grows by half of what
        /// they are apart at most.
        #[test]
        fn the_distance_agrees_with_sampled_points(
            a in [-9.0..9.0f64, -9.0..9.0f64], b in [-9.0..9.0f64, -9.0..9.0f64],
            others in proptest::collection::vec(([-9.0..9.0f64, -9.0..9.0f64], [-9.0..9.0f64, -9.0..9.0f64]), 1..5),
        ) {
            const STEPS: u32 = 400;
            let others: Vec<Segment> = others.into_iter().map(|(c, d)| [c, d]).collect();
            proptest::prop_assume!(a != b && others.iter().all(|[c, d]| c != d));
            let probe = Probe::along([a, b]);
            let nearest = |along: f64| {
                others.iter().map(|other| to_segment(probe.point(along), *other)).fold(f64::INFINITY, f64::min)
            };
            let sampled = (0..=STEPS).map(|step| nearest(probe.length * f64::from(step) / f64::from(STEPS)));
            let sampled = sampled.fold(0.0, f64::max);
            let found = distance(&probe, (0.0, probe.length), &others, 0.0, 100.0);
            let between = probe.length / f64::from(STEPS) / 2.0;
            proptest::prop_assert!((sampled - 1e-9..=sampled + between + 1e-9).contains(&found), "{found} {sampled}");
        }

        /// Brute force knows nothing of capsules: points, and the distance of each to a segment.
        #[test]
        fn near_parts_agree_with_sampled_points(
            a in [-9.0..9.0f64, -9.0..9.0f64], b in [-9.0..9.0f64, -9.0..9.0f64],
            c in [-9.0..9.0f64, -9.0..9.0f64], d in [-9.0..9.0f64, -9.0..9.0f64], radius in 0.1..6.0f64,
        ) {
            proptest::prop_assume!(a != b && c != d);
            let probe = Probe::along([a, b]);
            let near = probe.near_segment([c, d], radius);
            for step in 0..=100 {
                let along = (probe.length * f64::from(step) / 100.0).min(probe.length);
                let off = to_segment(probe.point(along), [c, d]) - radius;
                let inside = near.is_some_and(|(from, to)| (from..=to).contains(&along));
                proptest::prop_assert!(off.abs() < 1e-9 || inside == (off < 0.0), "{off} at {along}: {near:?}");
            }
        }
    }
}
