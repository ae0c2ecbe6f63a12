//! Whether loops cross or touch themselves or one another.

use std::collections::HashMap;

use super::simplify::distance_to_segment;
use super::{Point2, Vector2};

/// Where two segments meet that should not.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Crossing {
    /// Loop and index of the first point of one segment.
    pub one: (usize, usize),
    /// Loop and index of the first point of the other.
    pub other: (usize, usize),
    /// Where.
    pub place: Point2,
}

/// A segment with its loop and the index of its first point.
#[derive(Clone, Copy)]
struct Segment {
    loop_index: usize,
    index: usize,
    a: Point2,
    b: Point2,
}

/// The first crossing or touch (closer than `touch_mm`) among the segments of some loops, in order of loop and index.
///
/// Neighbouring segments of one loop share a point; they are at fault only where they fold back on one another.
/// A uniform grid makes the work proportional to the number of segments for outlines of even spacing.
#[must_use]
pub fn first_crossing(loops: &[Vec<Point2>], touch_mm: f64) -> Option<Crossing> {
    let segments: Vec<Segment> =
        loops.iter().enumerate().flat_map(|(i, points)| segments_of(i, points)).collect();
    let grid = Grid::over(&segments, touch_mm)?;
    let mut cells: HashMap<(i64, i64), Vec<usize>> = HashMap::new();
    let mut found: Option<(usize, usize)> = None;
    for (number, segment) in segments.iter().enumerate() {
        for cell in grid.cells_of(segment) {
            let others = cells.entry(cell).or_default();
            for &earlier in others.iter() {
                if meets(&segments[earlier], segment, |i| loops[i].len(), touch_mm) {
                    // A hash map has no order; the smallest pair is the answer whatever the order was.
                    found = Some(found.map_or((earlier, number), |best| best.min((earlier, number))));
                }
            }
            others.push(number);
        }
    }
    found.map(|(one, other)| crossing_of(&segments[one], &segments[other]))
}

/// A crossing or touch of those at places that count, where most outlines have none: what runs one way for a while is seen at
/// once to meet nothing of itself.
#[must_use]
pub fn any_crossing(paths: &[Path<'_>], touch_mm: f64, counts: impl Fn(&Point2) -> bool) -> Option<Crossing> {
    let segments: Vec<Segment> = paths.iter().enumerate().flat_map(|(i, path)| path.segments(i)).collect();
    // The last segment of an open path has none behind it.
    let count = |path: usize| if paths[path].closed { paths[path].points.len() } else { usize::MAX };
    let found =
        |one: &Segment, other: &Segment| meets(one, other, count, touch_mm) && counts(&meeting(one, other));
    let mut runs = runs(&segments, touch_mm);
    for run in &runs {
        let own = &segments[run.first..run.end];
        let pairs =
            own.iter().enumerate().flat_map(|(at, one)| own[at + 1..].iter().map(move |other| (one, other)));
        if let Some((one, other)) = pairs.filter(|_| !run.one_way).find(|(one, other)| found(one, other)) {
            return Some(crossing_of(one, other));
        }
    }
    runs.sort_by(|a, b| a.low.x.total_cmp(&b.low.x));
    for (at, run) in runs.iter().enumerate() {
        let near = runs[at + 1..].iter().take_while(|other| other.low.x <= run.high.x);
        for other in near.filter(|other| run.low.y <= other.high.y && other.low.y <= run.high.y) {
            if run.goes_on_in(other, &segments) || other.goes_on_in(run, &segments) {
                continue;
            }
            let ours = segments[run.first..run.end].iter().filter(|segment| other.is_near(segment, touch_mm));
            for one in ours {
                let theirs = &segments[other.first..other.end];
                if let Some(other) = theirs.iter().find(|segment| found(one, segment)) {
                    return Some(crossing_of(one, other));
                }
            }
        }
    }
    None
}

/// A line of points; a closed one does not repeat its first point.
#[derive(Debug, Clone, Copy)]
pub struct Path<'a> {
    /// Its points.
    pub points: &'a [Point2],
    /// Whether it goes on from the last to the first.
    pub closed: bool,
}

impl<'a> Path<'a> {
    fn segments(self, index: usize) -> impl Iterator<Item = Segment> + 'a {
        let all = segments_of(index, self.points);
        let open = usize::from(!self.closed);
        all.take(self.points.len().saturating_sub(open))
    }
}

/// Some segments of a loop, one after the other.
struct Run {
    loop_index: usize,
    first: usize,
    end: usize,
    /// The smallest and the largest coordinates, with a margin.
    low: Point2,
    high: Point2,
    /// Whether each segment goes forward along the straight way from the first point to the last.
    one_way: bool,
}

/// So many segments are looked at together.
const RUN: usize = 24;

fn runs(segments: &[Segment], margin: f64) -> Vec<Run> {
    let of_loops = segments.chunk_by(|one, other| one.loop_index == other.loop_index);
    let mut first = 0;
    let mut runs = Vec::with_capacity(segments.len() / RUN + 1);
    for part in of_loops.flat_map(|segments| segments.chunks(RUN)) {
        let margin = Vector2::new(margin, margin);
        let (low, high) = part
            .iter()
            .fold((part[0].a, part[0].a), |(low, high), segment| (low.inf(&segment.b), high.sup(&segment.b)));
        runs.push(Run {
            loop_index: part[0].loop_index,
            first,
            end: first + part.len(),
            low: low - margin,
            high: high + margin,
            one_way: is_one_way(part),
        });
        first += part.len();
    }
    runs
}

fn is_one_way(segments: &[Segment]) -> bool {
    let way = segments[segments.len() - 1].b - segments[0].a;
    segments.iter().all(|segment| (segment.b - segment.a).dot(&way) > 0.0)
}

impl Run {
    /// Whether another run is the next of the same loop, and both together go one way.
    fn goes_on_in(&self, next: &Self, segments: &[Segment]) -> bool {
        self.end == next.first
            && self.loop_index == next.loop_index
            && is_one_way(&segments[self.first..next.end])
    }

    fn is_near(&self, segment: &Segment, margin: f64) -> bool {
        let (low, high) = (segment.a.inf(&segment.b), segment.a.sup(&segment.b));
        low.x - margin <= self.high.x
            && self.low.x <= high.x + margin
            && low.y - margin <= self.high.y
            && self.low.y <= high.y + margin
    }
}

fn segments_of(loop_index: usize, points: &[Point2]) -> impl Iterator<Item = Segment> + '_ {
    (0..points.len()).map(move |index| Segment {
        loop_index,
        index,
        a: points[index],
        b: points[(index + 1) % points.len()],
    })
}

fn crossing_of(one: &Segment, other: &Segment) -> Crossing {
    Crossing {
        one: (one.loop_index, one.index),
        other: (other.loop_index, other.index),
        place: meeting(one, other),
    }
}

/// Where two segments that meet do: where they cross, or the end that lies on the other.
fn meeting(one: &Segment, other: &Segment) -> Point2 {
    let (way, other_way, between) = (one.b - one.a, other.b - other.a, other.a - one.a);
    let turn = way.perp(&other_way);
    let (along, other_along) = (between.perp(&other_way) / turn, between.perp(&way) / turn);
    // Parallel segments give no number, which is in no range.
    if (0.0..=1.0).contains(&along) && (0.0..=1.0).contains(&other_along) {
        return one.a + way * along;
    }
    let ends = [(one.a, other), (one.b, other), (other.a, one), (other.b, one)];
    let off = |(end, segment): &(Point2, &Segment)| distance_to_segment(end, &segment.a, &segment.b);
    ends.into_iter().min_by(|a, b| off(a).total_cmp(&off(b))).map_or(one.a, |(end, _)| end)
}

struct Grid {
    origin: Point2,
    cell: f64,
    margin: f64,
}

impl Grid {
    /// A grid whose cells are as wide as the segments are long on average: together they pass through about twice
    /// as many cells as there are segments, and few share one, on round and on long narrow outlines alike.
    fn over(segments: &[Segment], margin: f64) -> Option<Self> {
        let first = segments.first()?;
        let low = segments.iter().fold(first.a, |low, segment| low.inf(&segment.a));
        let length: f64 = segments.iter().map(|segment| (segment.b - segment.a).norm()).sum();
        Some(Self { origin: low, cell: (length / segments.len() as f64).max(margin), margin })
    }

    /// The cells that a segment with its margin passes through: column by column, the rows that it spans there.
    fn cells_of(&self, segment: &Segment) -> Vec<(i64, i64)> {
        let (a, b) = if segment.a.x <= segment.b.x { (segment.a, segment.b) } else { (segment.b, segment.a) };
        let (first, last) = (self.column(a.x - self.margin), self.column(b.x + self.margin));
        let slope = if b.x > a.x { (b.y - a.y) / (b.x - a.x) } else { 0.0 };
        let mut cells = Vec::new();
        for column in first..=last {
            let left = (self.origin.x + column as f64 * self.cell - self.margin).clamp(a.x, b.x);
            let right = (self.origin.x + (column + 1) as f64 * self.cell + self.margin).clamp(a.x, b.x);
            let (mut y0, mut y1) = (a.y + slope * (left - a.x), a.y + slope * (right - a.x));
            if b.x <= a.x {
                (y0, y1) = (a.y, b.y);
            }
            let (low, high) = (y0.min(y1) - self.margin, y0.max(y1) + self.margin);
            cells.extend((self.row(low)..=self.row(high)).map(|row| (column, row)));
        }
        cells
    }

    fn column(&self, x: f64) -> i64 {
        ((x - self.origin.x) / self.cell).floor() as i64
    }

    fn row(&self, y: f64) -> i64 {
        ((y - self.origin.y) / self.cell).floor() as i64
    }
}

/// Whether two segments meet that should not; a loop has so many segments.
fn meets(one: &Segment, other: &Segment, count: impl Fn(usize) -> usize, touch_mm: f64) -> bool {
    if one.loop_index == other.loop_index {
        let count = count(one.loop_index);
        if (one.index + 1) % count == other.index {
            return folds_back(&one.a, &one.b, &other.b, touch_mm);
        }
        if (other.index + 1) % count == one.index {
            return folds_back(&other.a, &other.b, &one.b, touch_mm);
        }
    }
    segments_cross(one, other) || segments_touch(one, other, touch_mm)
}

/// Whether the path a, b, c turns back onto itself at b.
fn folds_back(a: &Point2, b: &Point2, c: &Point2, touch_mm: f64) -> bool {
    (a - b).dot(&(c - b)) > 0.0
        && (distance_to_segment(c, a, b) < touch_mm || distance_to_segment(a, b, c) < touch_mm)
}

fn segments_cross(one: &Segment, other: &Segment) -> bool {
    let side = |a: &Point2, b: &Point2, p: &Point2| (b - a).perp(&(p - a));
    side(&one.a, &one.b, &other.a) * side(&one.a, &one.b, &other.b) < 0.0
        && side(&other.a, &other.b, &one.a) * side(&other.a, &other.b, &one.b) < 0.0
}

fn segments_touch(one: &Segment, other: &Segment, touch_mm: f64) -> bool {
    distance_to_segment(&one.a, &other.a, &other.b) < touch_mm
        || distance_to_segment(&one.b, &other.a, &other.b) < touch_mm
        || distance_to_segment(&other.a, &one.a, &one.b) < touch_mm
        || distance_to_segment(&other.b, &one.a, &one.b) < touch_mm
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn points(list: &[(f64, f64)]) -> Vec<Point2> {
        list.iter().map(|&(x, y)| Point2::new(x, y)).collect()
    }

    fn circle(count: u32, radius: f64) -> Vec<Point2> {
        (0..count)
            .map(|i| {
                let angle = f64::from(i) / f64::from(count) * std::f64::consts::TAU;
                Point2::new(radius * angle.cos(), radius * angle.sin())
            })
            .collect()
    }

    #[test]
    fn simple_outlines_pass() {
        assert_eq!(first_crossing(&[points(&[(0.0, 0.0), (4.0, 0.0), (0.0, 3.0)])], 1e-6), None);
        assert_eq!(first_crossing(&[circle(1000, 50.0), circle(100, 20.0)], 1e-6), None);
    }

    #[test]
    fn a_bow_tie_is_found_with_its_indices() {
        let bow_tie = points(&[(0.0, 0.0), (4.0, 3.0), (4.0, 0.0), (0.0, 3.0)]);
        let crossing = first_crossing(&[bow_tie], 1e-6).expect("it crosses");
        assert_eq!((crossing.one, crossing.other), ((0, 0), (0, 2)));
        assert!((crossing.place - Point2::new(2.0, 1.5)).norm() < 1e-12);
    }

    #[test]
    fn touches_folds_and_crossing_loops_are_found() {
        let touching = points(&[(0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (2.0, 0.0), (0.0, 3.0)]);
        let touch = first_crossing(&[touching], 1e-6).expect("it touches");
        assert!((touch.place - Point2::new(2.0, 0.0)).norm() < 1e-12);
        let spike = points(&[(0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (4.0, 1.0), (0.0, 1.0)]);
        assert!(first_crossing(&[spike], 1e-6).is_some());
        let moved = circle(100, 20.0).iter().map(|p| p + nalgebra::Vector2::new(40.0, 0.0)).collect();
        assert!(first_crossing(&[circle(1000, 50.0), moved], 1e-6).is_some());
    }

    #[test]
    fn every_pair_that_brute_force_finds_is_found() {
        // A deterministic scatter of loops: each answer is compared with the test of all pairs.
        let mut state = 7_u64;
        let mut random = move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as f64 / f64::from(u32::MAX >> 1)
        };
        for _ in 0..300 {
            let outline: Vec<_> = (0..6).map(|_| Point2::new(random() * 10.0, random() * 10.0)).collect();
            let loops = [outline];
            let all: Vec<_> = segments_of(0, &loops[0]).collect();
            let brute = (0..all.len())
                .flat_map(|i| (i + 1..all.len()).map(move |j| (i, j)))
                .find(|&(i, j)| meets(&all[i], &all[j], |i| loops[i].len(), 1e-6));
            let found = first_crossing(&loops, 1e-6).map(|c| (c.one.1, c.other.1));
            assert_eq!(found, brute);
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]
        /// Rings with noise and bays, and others beside or across them: both ways find a crossing or both find none.
        #[test]
        fn any_crossing_is_found_where_the_first_one_is(
            rings in prop::collection::vec((-60.0..60.0_f64, 3..400_u32, 5.0..50.0_f64, 0.0..0.4_f64, 1..30_u32, any::<bool>()), 1..4),
            noise in prop::collection::vec(-0.2..0.2_f64, 16)
        ) {
            let ring = |&(x, count, radius, depth, waves, reversed): &(f64, u32, f64, f64, u32, bool)| {
                let mut points: Vec<Point2> = (0..count)
                    .map(|i| {
                        let turn = f64::from(i) / f64::from(count) * std::f64::consts::TAU;
                        let out = radius * (1.0 + depth * (turn * f64::from(waves)).sin());
                        Point2::new(x + out * turn.cos() + noise[(i % 16) as usize], out * turn.sin())
                    })
                    .collect();
                if reversed {
                    points.reverse();
                }
                points
            };
            let loops: Vec<Vec<Point2>> = rings.iter().map(ring).collect();
            let first = first_crossing(&loops, 1e-6);
            let paths: Vec<Path<'_>> = loops.iter().map(|points| Path { points, closed: true }).collect();
            let any = any_crossing(&paths, 1e-6, |_| true);
            prop_assert_eq!(first.is_some(), any.is_some(), "{:?} {:?}", first, any);
        }
    }
}
