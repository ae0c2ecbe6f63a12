//! Outlines that more knives would be needed for than there are, changed on their scrap side (domain.md A5).
//!
//! A cut from edge to edge of the tape is, seen from the ply, a height u over v: toward the scrap is up. A knife
//! passes each u once, so k knives make it if no height is crossed more than k times. Two knives make what only rises
//! or falls, what changes once, and what changes twice if the outer two of its three runs share no height; one knife makes
//! what only rises or falls. `simplified` finds the outline that covers the given one, is of such a shape, and whose
//! largest deviation, measured along u, is least; of several the one with the least extra area.
//!
//! An outline that doubles back in v is covered by its silhouette first, which fills its pockets.
//!
//! Both ends of a short piece may need too many knives only together (`changes`). Then they are brought apart: the one end
//! to above some height, the other to below it, at the height for which the larger of both deviations is least; or, with two
//! knives, each end is made such that one knife does it. For one knife no other change is less; for two, ends that share
//! heights in part are not looked at.

use super::block::{Stretch, levels};
use super::chain::split;
use crate::planning::geometry::Point2;
use crate::planning::tolerance::SAME_POINT_MM;

/// A cut changed on its scrap side.
#[derive(Debug, Clone, PartialEq)]
pub struct Simplified {
    /// The cut, from the same end to the same end, in mm.
    pub points: Vec<Point2>,
    /// How far it lies from the ply at the most, along u, in mm.
    pub max_deviation_mm: f64,
    /// What it leaves beyond the ply, to be trimmed later, in mm^2.
    pub extra_area_mm2: f64,
}

/// How many chains of some cuts run side by side at the most. Cuts square across are places, and beside nothing.
#[must_use]
pub fn side_by_side<'a>(cuts: impl Iterator<Item = &'a [Point2]>, half_width_mm: f64) -> usize {
    let chains = cuts.flat_map(|cut| split(0, cut, half_width_mm)).filter(|chain| !chain.is_square());
    let spans: Vec<Stretch> = chains.map(|chain| chain.u_range()).collect();
    levels(&spans, spans.len()).iter().take_while(|level| !level.is_empty()).count()
}

/// What changes of the cuts of a piece, so that `knives` knives can make them.
#[must_use]
pub fn changes(cuts: &[&[Point2]], half_width_mm: f64, knives: usize) -> Vec<Option<Simplified>> {
    let alone = |cut: &&[Point2]| {
        let excess = side_by_side(std::iter::once(*cut), half_width_mm) > knives;
        excess.then(|| simplified(cut, half_width_mm, knives)).flatten()
    };
    let changes: Vec<Option<Simplified>> = cuts.iter().map(alone).collect();
    let changed = cuts.iter().zip(&changes).map(|(cut, change)| change.as_ref().map_or(*cut, |c| &c.points));
    match cuts {
        [one, other] if side_by_side(changed, half_width_mm) > knives => {
            brought_apart([one, other], half_width_mm, knives).map_or(changes, |both| both.map(Some).to_vec())
        }
        _ => changes,
    }
}

/// The least change of the two ends of a piece that leaves no more than `knives` chains side by side; `None` if there is
/// none or the cuts are not its two ends.
fn brought_apart(ends: [&[Point2]; 2], half_width_mm: f64, knives: usize) -> Option<[Simplified; 2]> {
    let [one, other] = ends.map(|cut| End::of(cut, half_width_mm));
    let pictures = [one?, other?];
    if pictures[0].turned == pictures[1].turned {
        return None;
    }
    let upper = usize::from(pictures[0].turned);
    let both = |knives: usize, level: Option<f64>| {
        let [one, other] = pictures.each_ref().map(|end| end.covered(knives, level));
        Some([one?, other?])
    };
    // Each end is looked at again at every step.
    let many_turns = ends.iter().any(|end| work(end, turns(end).len()) > MOST_WORK / 1000);
    let apart = if many_turns { 1 } else { knives };
    let us = || ends.into_iter().flatten().map(|point| point.x);
    let (mut low, mut high) = (us().fold(f64::INFINITY, f64::min), us().fold(f64::NEG_INFINITY, f64::max));
    // The higher the level, the more the upper end is raised and the less the lower one is brought down.
    while high - low > LEVEL_MM {
        let middle = f64::midpoint(low, high);
        let [one, other] = both(apart, Some(middle))?.map(|end| end.max_deviation_mm);
        let (of_upper, of_lower) = if upper == 0 { (one, other) } else { (other, one) };
        if of_upper > of_lower {
            high = middle;
        } else {
            low = middle;
        }
    }
    let ways =
        [both(apart, Some(low)), both(apart, Some(high)), (knives > 1).then(|| both(1, None)).flatten()];
    let works = |ends: &[Simplified; 2]| {
        side_by_side(ends.iter().map(|end| end.points.as_slice()), half_width_mm) <= knives
    };
    let most = |ends: &[Simplified; 2]| ends[0].max_deviation_mm.max(ends[1].max_deviation_mm);
    ways.into_iter().flatten().filter(works).min_by(|a, b| most(a).total_cmp(&most(b)))
}

/// The level at which two ends are brought apart is found to this, in mm: far below any step that is levelled out later.
const LEVEL_MM: f64 = 1e-9;

/// The least change of a cut that `knives` knives can make, or `None` if the cut does not run from one edge of the tape
/// to the other. The cut is a side of a piece: the ply lies on its left.
#[must_use]
pub fn simplified(cut: &[Point2], half_width_mm: f64, knives: usize) -> Option<Simplified> {
    End::of(cut, half_width_mm)?.covered(knives, None)
}

/// A cut from edge to edge of the tape as it is looked at here: v rises along it, and the ply lies at the smaller u.
struct End {
    /// A cut with v falling is the same picture turned by half a turn.
    turned: bool,
    given: Vec<Point2>,
    /// Its silhouette.
    ply: Vec<Point2>,
}

impl End {
    /// `None` if the cut does not run from one edge of the tape to the other.
    fn of(cut: &[Point2], half_width_mm: f64) -> Option<Self> {
        let (first, last) = (cut.first()?, cut.last()?);
        let crosses = first.y == -last.y && first.y.abs() == half_width_mm;
        let turned = first.y > last.y;
        let given: Vec<Point2> = if turned { cut.iter().map(|p| -*p).collect() } else { cut.to_vec() };
        crosses.then(|| Self { turned, ply: silhouette(&given), given })
    }

    /// Its least change that `knives` knives can make; with a level, of all that stay on the scrap side of that u.
    fn covered(&self, knives: usize, level: Option<f64>) -> Option<Simplified> {
        let Self { turned, given, ply } = self;
        let kept = level.map(|level| raised(ply, if *turned { -level } else { level }));
        let shapes = shapes(kept.as_ref().unwrap_or(ply), knives);
        let best = shapes.map(|shape| judged(ply, given, shape)).min_by(|a, b| {
            let equal = (a.max_deviation_mm - b.max_deviation_mm).abs() <= SAME_POINT_MM;
            let by_area = a.extra_area_mm2.total_cmp(&b.extra_area_mm2);
            if equal { by_area } else { a.max_deviation_mm.total_cmp(&b.max_deviation_mm) }
        })?;
        let points = if *turned { best.points.iter().map(|p| -*p).collect() } else { best.points };
        Some(Simplified { points, ..best })
    }
}

/// All shapes that `knives` knives make, each as low as it can be over the ply. Where there are very many turns, those that
/// turn twice are left out: each pair of turns would give two of them.
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
    let simple = [rising(ply), falling(ply)].into_iter().chain((knives > 1).then(peak));
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

/// The points at which the outline begins to fall or to rise, without its ends.
fn turns(ply: &[Point2]) -> Vec<usize> {
    let mut turns = Vec::new();
    let mut direction = 0.0;
    for index in 1..ply.len() {
        let step = ply[index].x - ply[index - 1].x;
        if step != 0.0 && step * direction < 0.0 {
            turns.push(index - 1);
        }
        if step != 0.0 {
            direction = step;
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
fn height_over(shape: &[Point2], v: f64) -> f64 {
    let after = shape.partition_point(|point| point.y < v);
    let Some(to) = shape.get(after) else { return shape[shape.len() - 1].x };
    if to.y == v || after == 0 {
        let here = shape[after..].iter().take_while(|point| point.y == v).map(|point| point.x);
        return here.fold(f64::INFINITY, f64::min).min(if to.y == v { f64::INFINITY } else { to.x });
    }
    let from = shape[after - 1];
    from.x + (v - from.y) / (to.y - from.y) * (to.x - from.x)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn cut(heights: &[f64]) -> Vec<Point2> {
        let half = 0.5 * (heights.len() - 1) as f64;
        heights.iter().enumerate().map(|(i, &u)| Point2::new(u, i as f64 - half)).collect()
    }

    fn half(cut: &[Point2]) -> f64 {
        cut[0].y.abs()
    }

    fn count(cut: &[Point2]) -> usize {
        side_by_side(std::iter::once(cut), half(cut))
    }

    /// The least largest deviation of all outlines whose points lie at heights of the given ones.
    fn brute_force(heights: &[f64], knives: usize) -> f64 {
        let mut best = f64::INFINITY;
        let choices = heights.len();
        for number in 0..choices.pow(heights.len() as u32) {
            let tried: Vec<f64> =
                (0..heights.len()).map(|i| heights[number / choices.pow(i as u32) % choices]).collect();
            let raised: Vec<f64> = tried.iter().zip(heights).map(|(new, old)| new - old).collect();
            let most = raised.iter().copied().fold(0.0, f64::max);
            if raised.iter().all(|by| *by >= 0.0) && most < best && count(&cut(&tried)) <= knives {
                best = most;
            }
        }
        best
    }

    #[test]
    fn what_two_knives_can_cut_stays_and_a_third_chain_is_filled() {
        let cuttable = cut(&[360.0, 400.0, 300.0, 340.0]);
        assert_eq!(count(&cuttable), 2);
        assert_eq!(simplified(&cuttable, half(&cuttable), 2).unwrap().max_deviation_mm, 0.0);
        // The start is raised from 340 to the end's 380 rather than the valley from 320 to 400.
        let excess = cut(&[340.0, 400.0, 320.0, 380.0]);
        assert_eq!(side_by_side(std::iter::once(excess.as_slice()), 1.5), 3);
        let changed = simplified(&excess, 1.5, 2).unwrap();
        assert_eq!((changed.max_deviation_mm, count(&changed.points)), (40.0, 2));
    }

    #[test]
    fn the_scrap_lies_on_the_other_side_of_a_cut_that_runs_down() {
        let mut start = cut(&[60.0, 0.0, 80.0, 20.0]);
        start.reverse();
        let changed = simplified(&start, 1.5, 2).unwrap();
        assert!(count(&changed.points) <= 2);
        assert!(changed.points.iter().all(|p| start.iter().all(|q| q.y != p.y || p.x <= q.x + 1e-12)));
        assert_eq!((changed.points[0].y, changed.points[changed.points.len() - 1].y), (1.5, -1.5));
    }

    #[test]
    fn an_outline_that_doubles_back_is_covered_by_its_silhouette() {
        let hook = [(0.0, -2.0), (10.0, 1.0), (4.0, -1.0), (0.0, 2.0)].map(|(u, v)| Point2::new(u, v));
        let changed = simplified(&hook, 2.0, 2).unwrap();
        assert!(changed.points.windows(2).all(|pair| pair[1].y >= pair[0].y), "{changed:?}");
        assert!(count(&changed.points) <= 2 && changed.extra_area_mm2 > 0.0);
    }

    /// The start of a piece, whose ply lies at the larger u.
    fn start(heights: &[f64]) -> Vec<Point2> {
        cut(heights).into_iter().rev().collect()
    }

    /// The least largest deviation of all pairs of ends of two points whose heights are given ones or halfway between two.
    fn brute_force_of_both(lower: &[f64], upper: &[f64]) -> f64 {
        let heights: Vec<f64> = lower.iter().chain(upper).copied().collect();
        let levels: Vec<f64> = heights
            .iter()
            .flat_map(|one| heights.iter().map(move |other| f64::midpoint(*one, *other)))
            .collect();
        let pairs = |allowed: &dyn Fn(f64, usize) -> bool| -> Vec<[f64; 2]> {
            let at = |place: usize| levels.iter().copied().filter(|u| allowed(*u, place)).collect::<Vec<_>>();
            let (first, second) = (at(0), at(1));
            first.iter().flat_map(|one| second.iter().map(move |other| [*one, *other])).collect()
        };
        let uppers = pairs(&|u, place| u >= upper[place]);
        let mut best = f64::INFINITY;
        for low in pairs(&|u, place| u <= lower[place]) {
            for high in &uppers {
                let off =
                    (0..2).map(|at| (lower[at] - low[at]).max(high[at] - upper[at])).fold(0.0, f64::max);
                let ends = [start(&low), cut(high)];
                if off < best && side_by_side(ends.iter().map(Vec::as_slice), 0.5) <= 1 {
                    best = off;
                }
            }
        }
        best
    }

    #[test]
    fn both_ends_of_a_short_piece_meet_halfway() {
        let ends = [start(&[0.0, 75.0]), cut(&[40.0, 115.0])];
        let found = changes(&[&ends[0], &ends[1]], 0.5, 1);
        let both: Vec<&Simplified> = found.iter().flatten().collect();
        assert!(
            both.len() == 2 && both.iter().all(|end| (end.max_deviation_mm - 17.5).abs() < 1e-3),
            "{both:?}"
        );
        // Two knives make both ends side by side as they are.
        assert_eq!(changes(&[&ends[0], &ends[1]], 0.5, 2), [None, None]);
    }

    #[test]
    fn two_knives_make_one_end_after_the_other_where_that_is_less() {
        // Side by side, each end made by one knife: 15 mm. One above 52.5 and the other below it: 2.5 mm.
        let ends = [start(&[40.0, 55.0, 40.0]), cut(&[50.0, 57.0, 50.0])];
        let found = changes(&[&ends[0], &ends[1]], 1.0, 2);
        let both: Vec<f64> = found.iter().flatten().map(|end| end.max_deviation_mm).collect();
        assert!(both.len() == 2 && both.iter().all(|most| (most - 2.5).abs() < 1e-6), "{both:?}");
    }

    #[test]
    fn very_many_turns_take_no_longer_than_they_may() {
        let teeth: Vec<f64> = (0..1200).map(|i| if i % 2 == 0 { f64::from(i % 7) } else { 30.0 }).collect();
        let upper: Vec<f64> = teeth.iter().map(|u| u + 5.0).collect();
        let ends = [start(&teeth), cut(&upper)];
        let half = half(&ends[1]);
        let found = changes(&[&ends[0], &ends[1]], half, 2);
        let changed: Vec<&[Point2]> = found.iter().flatten().map(|end| end.points.as_slice()).collect();
        assert!(changed.len() == 2 && side_by_side(changed.into_iter(), half) <= 2);
    }

    #[test]
    fn a_cut_that_does_not_cross_the_tape_is_left_alone() {
        let notch = [(0.0, 2.0), (10.0, 0.0), (20.0, 2.0)].map(|(u, v)| Point2::new(u, v));
        assert_eq!(simplified(&notch, 2.0, 2), None);
        assert_eq!(simplified(&[], 2.0, 2), None);
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, ..ProptestConfig::default() })]
        #[test]
        fn no_two_ends_of_a_brute_force_deviate_less_for_one_knife(
            lower in prop::array::uniform2(0..9_u8), widths in prop::array::uniform2(1..9_u8)
        ) {
            let lower = lower.map(f64::from);
            let upper = [0, 1].map(|at| lower[at] + f64::from(widths[at]));
            let given = [start(&lower), cut(&upper)];
            let found = changes(&[&given[0], &given[1]], 0.5, 1);
            let most = found.iter().flatten().map(|end| end.max_deviation_mm).fold(0.0, f64::max);
            let least = brute_force_of_both(&lower, &upper);
            prop_assert!((most - least).abs() < 10.0 * LEVEL_MM, "{most} {least} {lower:?} {upper:?}");
        }

        #[test]
        fn both_ends_keep_to_their_scrap_and_to_the_knives(
            lower in prop::collection::vec(0.0..90.0_f64, 2..7), widths in prop::collection::vec(1.0..60.0_f64, 6), knives in 1..=2_usize
        ) {
            let upper: Vec<f64> = lower.iter().zip(&widths).map(|(low, width)| low + width).collect();
            let given = [start(&lower), cut(&upper)];
            let half = half(&given[1]);
            let found = changes(&[&given[0], &given[1]], half, knives);
            let ends: Vec<&[Point2]> =
                given.iter().zip(&found).map(|(end, change)| change.as_ref().map_or(end.as_slice(), |c| &c.points)).collect();
            prop_assert!(side_by_side(ends.iter().copied(), half) <= knives, "{ends:?}");
            let turned: Vec<Point2> = ends[0].iter().map(|p| -*p).collect();
            for (at, (low, high)) in lower.iter().zip(&upper).enumerate() {
                let v = given[1][at].y;
                prop_assert!(height_over(&turned, -v) >= -low - 1e-9 && height_over(ends[1], v) >= high - 1e-9);
            }
        }

        #[test]
        fn no_outline_of_a_brute_force_deviates_less(
            heights in prop::collection::vec(0..7_u8, 2..7), knives in 1..=2_usize
        ) {
            let heights: Vec<f64> = heights.into_iter().map(f64::from).collect();
            let given = cut(&heights);
            let changed = simplified(&given, half(&given), knives).unwrap();
            prop_assert!(count(&changed.points) <= knives, "{heights:?} {changed:?}");
            prop_assert_eq!(changed.max_deviation_mm, brute_force(&heights, knives), "{:?} {:?}", heights, changed);
            // It never goes into the ply, and its ends stay on the edges of the tape.
            for point in &given {
                prop_assert!(height_over(&changed.points, point.y) >= point.x - 1e-9);
            }
            prop_assert_eq!(changed.points[0].y, given[0].y);
            prop_assert_eq!(changed.points[changed.points.len() - 1].y, given[given.len() - 1].y);
        }
    }
}
