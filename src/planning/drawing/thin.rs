//! Thinning of lines and places to what can be seen on a sheet, in mm of the sheet. However many there are and
//! however they run, the time grows with their number only and what is drawn is bounded.

use std::collections::BTreeSet;

use super::sheet::DOT_MM;
use super::svg::{Spot, spot};
use crate::planning::geometry::Point2;
use crate::planning::geometry::simplify::kept;

/// Width of the columns to which a line of very many points is reduced: a pixel at 96 dpi.
const COLUMN_MM: f64 = 0.25;

/// A line of more points than this is reduced to columns first. Thinning to a chord takes in the worst case the
/// square of their number.
const MANY: usize = 2000;

/// The finest raster on which places count as one.
const FINEST_MM: f64 = 0.05;

/// The finest raster on which segments count as one: closer than this they would run into one another.
const FINEST_LINES_MM: f64 = 0.3;

/// A line whose look is that of the given one.
#[must_use]
pub fn line(spots: &[Spot]) -> Vec<Spot> {
    let reduced = if spots.len() > MANY { columns(spots) } else { spots.to_vec() };
    if reduced.len() > 2 * MANY {
        return reduced;
    }
    let points: Vec<Point2> = reduced.iter().map(|at| Point2::new(at.x, at.y)).collect();
    kept(&points, DOT_MM).into_iter().map(|index| reduced[index]).collect()
}

/// Of each run of points within one column the first, the highest, the lowest and the last, in their order.
fn columns(spots: &[Spot]) -> Vec<Spot> {
    let column = |at: &Spot| (at.x / COLUMN_MM).floor();
    let mut reduced = Vec::new();
    for run in spots.chunk_by(|one, other| column(one) == column(other)) {
        let by_height = |one: &usize, other: &usize| run[*one].y.total_cmp(&run[*other].y);
        let extremes = [(0..run.len()).min_by(by_height), (0..run.len()).max_by(by_height)];
        let ends = [Some(0), Some(run.len() - 1)];
        let chosen: BTreeSet<usize> = extremes.into_iter().chain(ends).flatten().collect();
        reduced.extend(chosen.into_iter().map(|index| run[index]));
    }
    reduced
}

/// Lines of which no two segments look the same.
#[derive(Debug, Clone, PartialEq)]
pub struct Thinned {
    /// The lines.
    pub lines: Vec<Vec<Spot>>,
    /// On how coarse a raster segments count as one.
    pub raster_mm: f64,
}

/// Thins lines out until they have at most so many segments: of those whose ends fall on the same dots of a raster
/// only the first is drawn. The raster is the finest for which that is enough.
#[must_use]
pub fn lines(lines: &[Vec<Spot>], most: usize) -> Thinned {
    let mut raster_mm = FINEST_LINES_MM;
    loop {
        let thinned = rastered(lines, raster_mm);
        // On a raster as large as the sheet all segments are one, if any is left.
        if segments(&thinned) <= most.max(1) {
            return Thinned { lines: thinned, raster_mm };
        }
        raster_mm *= 2.0;
    }
}

/// The number of segments of some lines.
#[must_use]
pub fn segments(lines: &[Vec<Spot>]) -> usize {
    lines.iter().map(|line| line.len().saturating_sub(1)).sum()
}

type Dot = (i64, i64);

fn dot(at: Spot, raster_mm: f64) -> Dot {
    ((at.x / raster_mm).round() as i64, (at.y / raster_mm).round() as i64)
}

fn rastered(lines: &[Vec<Spot>], raster_mm: f64) -> Vec<Vec<Spot>> {
    let mut drawn: BTreeSet<(Dot, Dot)> = BTreeSet::new();
    let mut thinned: Vec<Vec<Spot>> = Vec::new();
    for line in lines {
        let mut last: Option<(Spot, Dot)> = None;
        let mut goes_on = false;
        for &at in line {
            let here = (at, dot(at, raster_mm));
            let Some(from) = last.replace(here) else { continue };
            if from.1 == here.1 {
                last = Some(from);
                continue;
            }
            let is_new = drawn.insert((from.1.min(here.1), from.1.max(here.1)));
            match thinned.last_mut() {
                Some(run) if is_new && goes_on => run.push(at),
                _ if is_new => thinned.push(vec![from.0, at]),
                _ => {}
            }
            goes_on = is_new;
        }
    }
    thinned
}

/// The indices of at most so many places, of which no two look the same, and the raster that this took.
#[must_use]
pub fn places(spots: &[Spot], most: usize) -> (Vec<usize>, f64) {
    let mut raster_mm = FINEST_MM;
    loop {
        let mut drawn = BTreeSet::new();
        let is_new = |index: &usize| drawn.insert(dot(spots[*index], raster_mm));
        let chosen: Vec<usize> = (0..spots.len()).filter(is_new).collect();
        if chosen.len() <= most.max(1) {
            return (chosen, raster_mm);
        }
        raster_mm *= 2.0;
    }
}

/// The part of a segment within a rectangle from `low` to `high` (Liang and Barsky 1984).
#[must_use]
pub fn clipped((from, to): (Spot, Spot), low: Spot, high: Spot) -> Option<(Spot, Spot)> {
    let (dx, dy) = (to.x - from.x, to.y - from.y);
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    let borders =
        [(-dx, from.x - low.x), (dx, high.x - from.x), (-dy, from.y - low.y), (dy, high.y - from.y)];
    for (toward, room) in borders {
        if toward == 0.0 && room < 0.0 {
            return None;
        }
        if toward < 0.0 {
            enter = enter.max(room / toward);
        } else if toward > 0.0 {
            leave = leave.min(room / toward);
        }
    }
    let at = |share: f64| spot(from.x + share * dx, from.y + share * dy);
    let start = if enter > 0.0 { at(enter) } else { from };
    let end = if leave < 1.0 { at(leave) } else { to };
    (enter <= leave).then_some((start, end))
}

/// The parts of a line within a rectangle.
#[must_use]
pub fn clipped_line(spots: &[Spot], low: Spot, high: Spot) -> Vec<Vec<Spot>> {
    let mut parts: Vec<Vec<Spot>> = Vec::new();
    for pair in spots.windows(2) {
        let Some((from, to)) = clipped((pair[0], pair[1]), low, high) else { continue };
        match parts.last_mut() {
            Some(part) if part.last() == Some(&from) => part.push(to),
            _ => parts.push(vec![from, to]),
        }
    }
    parts
}

/// The part of a polygon within a rectangle (Sutherland and Hodgman 1974).
#[must_use]
pub fn clipped_area(spots: &[Spot], low: Spot, high: Spot) -> Vec<Spot> {
    let x = |at: &Spot| at.x;
    let y = |at: &Spot| at.y;
    let left = half(spots, x, low.x, 1.0);
    let right = half(&left, x, high.x, -1.0);
    let upper = half(&right, y, low.y, 1.0);
    half(&upper, y, high.y, -1.0)
}

/// The part of a polygon where `sign * (coordinate - border)` is not negative.
fn half(spots: &[Spot], coordinate: impl Fn(&Spot) -> f64, border: f64, sign: f64) -> Vec<Spot> {
    let room = |at: &Spot| sign * (coordinate(at) - border);
    let mut inside = Vec::with_capacity(spots.len());
    for (index, &here) in spots.iter().enumerate() {
        let next = spots[(index + 1) % spots.len()];
        let (from, to) = (room(&here), room(&next));
        if from >= 0.0 {
            inside.push(here);
        }
        if (from >= 0.0) != (to >= 0.0) {
            let share = from / (from - to);
            inside.push(spot(here.x + share * (next.x - here.x), here.y + share * (next.y - here.y)));
        }
    }
    inside
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planning::geometry::polygon::signed_area;

    fn zigzag(count: usize) -> Vec<Spot> {
        (0..count)
            .map(|i| spot(100.0 * i as f64 / count as f64, if i % 4 < 2 { 10.0 } else { 60.0 }))
            .collect()
    }

    #[test]
    fn a_hundred_thousand_strokes_are_few_and_cover_the_same_place() {
        let all = zigzag(100_000);
        let thinned = lines(std::slice::from_ref(&all), 3000);
        assert!(segments(&thinned.lines) <= 3000 && segments(&thinned.lines) > 300);
        let x: Vec<f64> = thinned.lines.iter().flatten().map(|at| at.x).collect();
        for wanted in 0..100 {
            let near = x.iter().any(|x| (x - f64::from(wanted)).abs() <= thinned.raster_mm);
            assert!(near, "nothing is drawn at {wanted}");
        }
        assert!(line(&all).len() < 4 * 401, "columns of a quarter of a mm");
    }

    #[test]
    fn few_strokes_are_left_as_they_are() {
        let all = zigzag(40);
        assert_eq!(lines(std::slice::from_ref(&all), 3000), Thinned { lines: vec![all], raster_mm: 0.3 });
        let twice = vec![spot(0.0, 0.0), spot(9.0, 0.0), spot(0.0, 0.0)];
        assert_eq!(lines(&[twice], 3000).lines, [[spot(0.0, 0.0), spot(9.0, 0.0)]]);
        assert!(lines(&[vec![spot(1.0, 1.0)], Vec::new()], 0).lines.is_empty());
    }

    #[test]
    fn columns_keep_what_stands_out() {
        let mut noisy: Vec<Spot> = (0..50_000).map(|i| spot(f64::from(i) * 0.002, 0.0)).collect();
        noisy[30_001].y = 7.0;
        let thinned = line(&noisy);
        assert!(thinned.len() < 20 && thinned.contains(&noisy[30_001]));
        assert_eq!((thinned[0], thinned[thinned.len() - 1]), (noisy[0], noisy[49_999]));
    }

    #[test]
    fn places_that_look_the_same_are_one() {
        let places_of = |count: usize| -> Vec<Spot> { (0..count).map(|i| spot(i as f64, 0.0)).collect() };
        assert_eq!(places(&places_of(5), 10).0, [0, 1, 2, 3, 4]);
        let (chosen, raster_mm) = places(&places_of(1000), 300);
        assert!(chosen.len() <= 300 && chosen.len() > 100 && raster_mm > 1.0);
        assert!(places(&[], 0).0.is_empty());
    }

    #[test]
    fn what_is_outside_is_cut_off() {
        let (low, high) = (spot(0.0, 0.0), spot(10.0, 10.0));
        let across = [spot(-10.0, 5.0), spot(20.0, 5.0), spot(5.0, 20.0), spot(5.0, 5.0)];
        let parts = clipped_line(&across, low, high);
        assert_eq!(parts, [vec![spot(0.0, 5.0), spot(10.0, 5.0)], vec![spot(5.0, 10.0), spot(5.0, 5.0)]]);
        let triangle = [spot(-5.0, 0.0), spot(15.0, 0.0), spot(5.0, 20.0)];
        let area = clipped_area(&triangle, low, high);
        assert!(area.iter().all(|at| at.x >= 0.0 && at.x <= 10.0 && at.y >= 0.0 && at.y <= 10.0));
        let points: Vec<Point2> = area.iter().map(|at| Point2::new(at.x, at.y)).collect();
        assert!((signed_area(&points).abs() - 100.0).abs() < 1e-12, "{area:?}");
        assert!(clipped_area(&[spot(20.0, 0.0), spot(30.0, 0.0), spot(30.0, 9.0)], low, high).is_empty());
    }
}
