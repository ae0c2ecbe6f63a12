//! An end of a piece, alone.
//!
//! Seen from the ply, an end is a height u over v: toward the scrap is up. A knife passes each u once, so k knives make it
//! if no height is crossed more than k times. Two knives make what only rises or falls, what changes once, and what changes
//! twice if the outer two of its three runs share no height; one knife makes what only rises or falls. `End::covered`
//! finds the outline that covers the given one, is of such a shape, and whose largest deviation, measured along u, is
//! least; of several the one with the least extra area.
//!
//! An outline that doubles back in v is covered by its silhouette first, which fills its pockets.

use super::Simplified;
use crate::planning::geometry::Point2;
use crate::planning::tolerance::{SAME_POINT_MM, U_REVERSAL_MM};

/// A cut from edge to edge of the tape as it is looked at here: v rises along it, and the ply lies at the smaller u.
pub(super) struct End {
    /// A cut with v falling is the same picture turned by half a turn.
    turned: bool,
    given: Vec<Point2>,
    /// Its silhouette.
    ply: Vec<Point2>,
}

/// What an end leaves to the cuts beside it, in its own picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Room {
    /// The end lies nowhere below this height.
    pub(super) floor: f64,
    /// Below this height the end is crossed once only: it comes up from one edge of the tape and does not come back.
    pub(super) once_below: Option<(f64, Edge)>,
}

impl Room {
    /// Nothing lies beside the end.
    pub(super) const ALL: Self = Self { floor: f64::NEG_INFINITY, once_below: None };
}

/// The edge of the tape at which an end is lowest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Edge {
    First,
    Last,
}

impl End {
    /// `None` if the cut does not run from one edge of the tape to the other.
    pub(super) fn of(cut: &[Point2], half_width_mm: f64) -> Option<Self> {
        let (first, last) = (cut.first()?, cut.last()?);
        let crosses = first.y == -last.y && first.y.abs() == half_width_mm;
        let turned = first.y > last.y;
        let given: Vec<Point2> = if turned { cut.iter().map(|p| -*p).collect() } else { cut.to_vec() };
        crosses.then(|| Self { turned, ply: silhouette(&given), given })
    }

    /// Whether the end is the lower one of its piece, so that its heights are its u with the sign changed.
    pub(super) fn is_turned(&self) -> bool {
        self.turned
    }

    /// The lowest and the highest that the end is given.
    pub(super) fn heights(&self) -> (f64, f64) {
        let heights = self.ply.iter().map(|point| point.x);
        heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), u| (low.min(u), high.max(u)))
    }

    /// Whether so many outlines have to be looked at that it takes longer than a thousandth of the most that is done.
    pub(super) fn has_many_turns(&self) -> bool {
        work(&self.ply, turns(&self.ply).len()) > MOST_WORK / 1000
    }

    /// As it is.
    pub(super) fn unchanged(&self) -> Simplified {
        let points = if self.turned { self.given.iter().map(|p| -*p).collect() } else { self.given.clone() };
        Simplified { points, max_deviation_mm: 0.0, extra_area_mm2: 0.0 }
    }

    /// Its least change that `knives` knives can make.
    pub(super) fn covered(&self, knives: usize) -> Simplified {
        self.covered_within(Room::ALL, knives)
    }

    /// Of all changes that `knives` knives can make and that keep to this room, the least.
    pub(super) fn covered_within(&self, room: Room, knives: usize) -> Simplified {
        let crossed = room.once_below.map(|(height, edge)| crossed_once(&self.ply, height, edge));
        let kept = raised(crossed.as_ref().unwrap_or(&self.ply), room.floor);
        let judged = |shape| judged(&self.ply, &self.given, shape);
        let least = judged(rising(&kept));
        let best = shapes(&kept, knives).map(judged).fold(least, |best, other| {
            let equal = (other.max_deviation_mm - best.max_deviation_mm).abs() <= SAME_POINT_MM;
            let less = if equal {
                other.extra_area_mm2 < best.extra_area_mm2
            } else {
                other.max_deviation_mm < best.max_deviation_mm
            };
            if less { other } else { best }
        });
        let points = if self.turned { best.points.iter().map(|p| -*p).collect() } else { best.points };
        Simplified { points, ..best }
    }
}

/// The shapes that `knives` knives make besides one that only rises, each as low as it can be over the ply. Where there are
/// very many turns, those that turn twice are left out: each pair of turns would give two of them.
fn shapes(ply: &[Point2], knives: usize) -> impl Iterator<Item = Vec<Point2>> {
    let turns = if knives < 2 { Vec::new() } else { turns(ply) };
    let top = (0..ply.len()).max_by(|&a, &b| ply[a].x.total_cmp(&ply[b].x)).unwrap_or(0);
    let peak = move || joined(&[rising(&ply[..=top]), falling(&ply[top..])]);
    let valley = move |valley: usize| joined(&[falling(&ply[..=valley]), rising(&ply[valley..])]);
    let twice = if work(ply, turns.len()) > MOST_WORK { &[] } else { turns.as_slice() };
    let from = |(index, &one): (usize, &usize)| twice[index + 1..].iter().map(move |&other| (one, other));
    let pairs: Vec<(usize, usize)> = twice.iter().enumerate().flat_map(from).collect();
    let twice_turned = pairs.into_iter().flat_map(move |(one, other)| {
        let last = ply.len() - 1;
        let mirrored = twice_turned(&mirrored(ply), last - other, last - one);
        twice_turned(ply, one, other).into_iter().chain(mirrored.map(|shape| self::mirrored(&shape)))
    });
    let simple = std::iter::once(falling(ply)).chain((knives > 1).then(peak));
    simple.chain(turns.into_iter().map(valley)).chain(twice_turned)
}

/// How many points the shapes that turn twice have together, about.
fn work(ply: &[Point2], turns: usize) -> usize {
    turns.saturating_mul(turns).saturating_mul(ply.len())
}

/// The most points of shapes that are looked at for one end: some seconds.
const MOST_WORK: usize = 1_000_000_000;

/// Up to `peak`, down to `valley`, up to the end, with the start raised to the height of the end, so that the
/// first run and the last share no height. `None` where the end is above the peak.
fn twice_turned(ply: &[Point2], peak: usize, valley: usize) -> Option<Vec<Point2>> {
    let last = rising(&ply[valley..]);
    let end = last.last()?.x;
    if end > ply[peak].x {
        return None;
    }
    let mut first = rising(&raised(&ply[..=peak], end));
    // The first run ends as high as the middle one begins.
    let middle = falling(&ply[peak..=valley]);
    let height = first.last()?.x.max(middle.first()?.x);
    first.last_mut()?.x = height;
    let middle =
        std::iter::once(Point2::new(height, ply[peak].y)).chain(middle.into_iter().skip(1)).collect();
    Some(joined(&[first, middle, last]))
}

/// The lowest outline above this one that never falls with v.
fn rising(points: &[Point2]) -> Vec<Point2> {
    let mut top = points[0];
    let mut covered = vec![top];
    for pair in points.windows(2) {
        let (from, to) = (pair[0], pair[1]);
        if to.x > top.x {
            let left = at_height(&from, &to, top.x);
            if left != top {
                covered.push(left);
            }
            covered.push(to);
            top = to;
        } else if pair[1] == points[points.len() - 1] {
            covered.push(Point2::new(top.x, to.y));
        }
    }
    covered
}

/// The lowest outline above this one that never rises with v.
fn falling(points: &[Point2]) -> Vec<Point2> {
    mirrored(&rising(&mirrored(points)))
}

fn mirrored(points: &[Point2]) -> Vec<Point2> {
    points.iter().rev().map(|point| Point2::new(point.x, -point.y)).collect()
}

/// The outline with all that is below `floor` raised to it.
fn raised(points: &[Point2], floor: f64) -> Vec<Point2> {
    let mut covered = vec![Point2::new(points[0].x.max(floor), points[0].y)];
    for pair in points.windows(2) {
        let (from, to) = (pair[0], pair[1]);
        if (from.x < floor) != (to.x < floor) {
            covered.push(at_height(&from, &to, floor));
        }
        covered.push(Point2::new(to.x.max(floor), to.y));
    }
    covered
}

/// The lowest outline above this one that comes up to `height` from an edge of the tape and does not come below it again.
fn crossed_once(points: &[Point2], height: f64, edge: Edge) -> Vec<Point2> {
    if edge == Edge::Last {
        return mirrored(&crossed_once(&mirrored(points), height, Edge::First));
    }
    match points.iter().position(|point| point.x >= height) {
        None => rising(points),
        Some(0) => raised(points, height),
        Some(above) => {
            let there = at_height(&points[above - 1], &points[above], height);
            let up: Vec<Point2> = points[..above].iter().copied().chain([there]).collect();
            joined(&[rising(&up), raised(&points[above..], height)])
        }
    }
}

/// Where a segment that passes a height is at it.
fn at_height(from: &Point2, to: &Point2, height: f64) -> Point2 {
    let share = ((height - from.x) / (to.x - from.x)).clamp(0.0, 1.0);
    Point2::new(height, from.y + share * (to.y - from.y))
}

/// One outline of several that meet, points in line left out.
fn joined(parts: &[Vec<Point2>]) -> Vec<Point2> {
    let mut points: Vec<Point2> = Vec::new();
    for point in parts.iter().flatten() {
        if points.last() != Some(point) {
            points.push(*point);
        }
    }
    points
}

/// The points at which the outline begins to fall or to rise, without its ends. Steps that are no change of direction to a
/// knife are none here either.
fn turns(ply: &[Point2]) -> Vec<usize> {
    let (mut turns, mut direction, mut farthest) = (Vec::new(), 0.0, 0);
    for (index, point) in ply.iter().enumerate() {
        let step = point.x - ply[farthest].x;
        if step * direction > 0.0 {
            farthest = index;
        } else if step.abs() >= U_REVERSAL_MM {
            if direction != 0.0 {
                turns.push(farthest);
            }
            (direction, farthest) = (step.signum(), index);
        }
    }
    turns
}

/// What lies toward the scrap of an outline at each v: the outline itself where it does not double back.
fn silhouette(points: &[Point2]) -> Vec<Point2> {
    if points.windows(2).all(|pair| pair[1].y >= pair[0].y) {
        return points.to_vec();
    }
    let (start, end) = (points[0].y, points[points.len() - 1].y);
    let mut places: Vec<f64> = points.iter().map(|point| point.y.clamp(start, end)).collect();
    places.sort_by(f64::total_cmp);
    places.dedup();
    let mut top: Vec<Point2> = Vec::new();
    for strip in places.windows(2) {
        // Outlines do not cross, so the segment that is on top in the middle of a strip is on top throughout.
        let [low, high] = [strip[0], strip[1]];
        let middle = f64::midpoint(low, high);
        let over = points.windows(2).filter(|pair| {
            pair[0].y.min(pair[1].y) <= middle && middle <= pair[0].y.max(pair[1].y) && pair[0].y != pair[1].y
        });
        let height = |pair: &[Point2], v: f64| {
            pair[0].x + (v - pair[0].y) / (pair[1].y - pair[0].y) * (pair[1].x - pair[0].x)
        };
        if let Some(pair) = over.max_by(|a, b| height(a, middle).total_cmp(&height(b, middle))) {
            for v in [low, high] {
                let point = Point2::new(height(pair, v), v);
                if top.last() != Some(&point) {
                    top.push(point);
                }
            }
        }
    }
    top
}

/// What a shape costs: how far it lies above the given outline, and the area between them.
fn judged(ply: &[Point2], given: &[Point2], shape: Vec<Point2>) -> Simplified {
    let deviation = given.iter().chain(ply).map(|point| height_over(&shape, point.y) - point.x);
    let max_deviation_mm = deviation.fold(0.0, f64::max);
    let area = |points: &[Point2]| -> f64 {
        points.windows(2).map(|pair| 0.5 * (pair[0].x + pair[1].x) * (pair[1].y - pair[0].y)).sum()
    };
    let extra_area_mm2 = (area(&shape) - area(given)).max(0.0);
    Simplified { points: shape, max_deviation_mm, extra_area_mm2 }
}

/// The height of an outline whose v never falls, at a v; where it stands upright, its lowest there.
pub(super) fn height_over(shape: &[Point2], v: f64) -> f64 {
    let after = shape.partition_point(|point| point.y < v);
    let Some(to) = shape.get(after) else { return shape[shape.len() - 1].x };
    if to.y == v || after == 0 {
        let here = shape[after..].iter().take_while(|point| point.y == v).map(|point| point.x);
        return here.fold(f64::INFINITY, f64::min).min(if to.y == v { f64::INFINITY } else { to.x });
    }
    let from = shape[after - 1];
    from.x + (v - from.y) / (to.y - from.y) * (to.x - from.x)
}
