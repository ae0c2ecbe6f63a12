//! Whether loops cross or touch themselves or one another.

use std::collections::HashMap;

use super::Point2;
use super::simplify::distance_to_segment;

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
    first_crossing_where(loops, touch_mm, |_| true)
}

/// The first crossing or touch of those at places that count.
#[must_use]
pub fn first_crossing_where(
    loops: &[Vec<Point2>],
    touch_mm: f64,
    counts: impl Fn(&Point2) -> bool,
) -> Option<Crossing> {
    let segments: Vec<Segment> =
        loops.iter().enumerate().flat_map(|(i, points)| segments_of(i, points)).collect();
    let grid = Grid::over(&segments, touch_mm)?;
    let mut cells: HashMap<(i64, i64), Vec<usize>> = HashMap::new();
    let mut found: Option<(usize, usize)> = None;
    for (number, segment) in segments.iter().enumerate() {
        for cell in grid.cells_of(segment) {
            let others = cells.entry(cell).or_default();
            for &earlier in others.iter() {
                let one = &segments[earlier];
                if meets(one, segment, loops, touch_mm) && counts(&meeting(one, segment)) {
                    // A hash map has no order; the smallest pair is the answer whatever the order was.
                    found = Some(found.map_or((earlier, number), |best| best.min((earlier, number))));
                }
            }
            others.push(number);
        }
    }
    found.map(|(one, other)| crossing_of(&segments[one], &segments[other]))
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

fn meets(one: &Segment, other: &Segment, loops: &[Vec<Point2>], touch_mm: f64) -> bool {
    if one.loop_index == other.loop_index {
        let count = loops[one.loop_index].len();
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
                .find(|&(i, j)| meets(&all[i], &all[j], &loops, 1e-6));
            let found = first_crossing(&loops, 1e-6).map(|c| (c.one.1, c.other.1));
            assert_eq!(found, brute);
        }
    }
}
