use proptest::prelude::*;

use super::both::LEVEL_MM;
use super::end::height_over;
use super::*;

fn cut(heights: &[f64]) -> Vec<Point2> {
    let half = 0.5 * (heights.len() - 1) as f64;
    heights.iter().enumerate().map(|(i, &u)| Point2::new(u, i as f64 - half)).collect()
}

fn simplified(cut: &[Point2], knives: usize) -> Simplified {
    End::of(cut, half(cut)).unwrap().covered(knives)
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
    assert_eq!(simplified(&cuttable, 2).max_deviation_mm, 0.0);
    // The start is raised from 340 to the end's 380 rather than the valley from 320 to 400.
    let excess = cut(&[340.0, 400.0, 320.0, 380.0]);
    assert_eq!(side_by_side(std::iter::once(excess.as_slice()), 1.5), 3);
    let changed = simplified(&excess, 2);
    assert_eq!((changed.max_deviation_mm, count(&changed.points)), (40.0, 2));
}

#[test]
fn the_scrap_lies_on_the_other_side_of_a_cut_that_runs_down() {
    let mut start = cut(&[60.0, 0.0, 80.0, 20.0]);
    start.reverse();
    let changed = simplified(&start, 2);
    assert!(count(&changed.points) <= 2);
    assert!(changed.points.iter().all(|p| start.iter().all(|q| q.y != p.y || p.x <= q.x + 1e-12)));
    assert_eq!((changed.points[0].y, changed.points[changed.points.len() - 1].y), (1.5, -1.5));
}

#[test]
fn an_outline_that_doubles_back_is_covered_by_its_silhouette() {
    let hook = [(0.0, -2.0), (10.0, 1.0), (4.0, -1.0), (0.0, 2.0)].map(|(u, v)| Point2::new(u, v));
    let changed = simplified(&hook, 2);
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
    let levels: Vec<f64> =
        heights.iter().flat_map(|one| heights.iter().map(move |other| f64::midpoint(*one, *other))).collect();
    let pairs = |allowed: &dyn Fn(f64, usize) -> bool| -> Vec<[f64; 2]> {
        let at = |place: usize| levels.iter().copied().filter(|u| allowed(*u, place)).collect::<Vec<_>>();
        let (first, second) = (at(0), at(1));
        first.iter().flat_map(|one| second.iter().map(move |other| [*one, *other])).collect()
    };
    let uppers = pairs(&|u, place| u >= upper[place]);
    let mut best = f64::INFINITY;
    for low in pairs(&|u, place| u <= lower[place]) {
        for high in &uppers {
            let off = (0..2).map(|at| (lower[at] - low[at]).max(high[at] - upper[at])).fold(0.0, f64::max);
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
    let found = changes(&[&ends[0], &ends[1]], &[], 0.5, 1);
    let both: Vec<&Simplified> = found.iter().flatten().collect();
    assert!(both.len() == 2 && both.iter().all(|end| (end.max_deviation_mm - 17.5).abs() < 1e-3), "{both:?}");
    // Two knives make both ends side by side as they are.
    assert_eq!(changes(&[&ends[0], &ends[1]], &[], 0.5, 2), [None, None]);
}

#[test]
fn two_knives_make_one_end_after_the_other_where_that_is_less() {
    // Side by side, each end made by one knife: 15 mm. One above 52.5 and the other below it: 2.5 mm.
    let ends = [start(&[40.0, 55.0, 40.0]), cut(&[50.0, 57.0, 50.0])];
    let found = changes(&[&ends[0], &ends[1]], &[], 1.0, 2);
    let both: Vec<f64> = found.iter().flatten().map(|end| end.max_deviation_mm).collect();
    assert!(both.len() == 2 && both.iter().all(|most| (most - 2.5).abs() < 1e-6), "{both:?}");
}

/// Outlines of points at halves of whole heights, each less than `most` on the scrap side of the given one.
fn outlines(given: &[f64], scrap: f64, most: f64) -> Vec<Vec<f64>> {
    let steps: Vec<f64> = (0..40).map(|step| 0.5 * f64::from(step)).filter(|by| *by < most).collect();
    given.iter().fold(vec![Vec::new()], |outlines, height| {
        let longer = |outline: &Vec<f64>| {
            let all = steps.iter().map(|by| [outline.as_slice(), &[height + scrap * by]].concat());
            all.collect::<Vec<_>>()
        };
        outlines.iter().flat_map(longer).collect()
    })
}

/// Two ends of a brute force that deviate less than `most` and that two knives make beside the other cuts.
fn less_of_both(lower: &[f64], upper: &[f64], others: &[Vec<Point2>], most: f64) -> Option<[Vec<f64>; 2]> {
    let half = 0.5 * (lower.len() - 1) as f64;
    let works = |cuts: &[&[Point2]]| {
        side_by_side(cuts.iter().copied().chain(others.iter().map(Vec::as_slice)), half) <= 2
    };
    let lowers = outlines(lower, -1.0, most).into_iter().map(|low| (start(&low), low));
    let lowers: Vec<_> = lowers.filter(|(cut, _)| works(&[cut])).collect();
    let uppers = outlines(upper, 1.0, most).into_iter().map(|high| (cut(&high), high));
    uppers.filter(|(cut, _)| works(&[cut])).find_map(|(cut, high)| {
        let (_, low) = lowers.iter().find(|(start, _)| works(&[start, &cut]))?;
        Some([low.clone(), high])
    })
}

#[test]
fn two_knives_make_ends_that_share_heights_in_part() {
    // Above the lower end's 20 the upper one turns, below the upper one's 14 the lower one does.
    let ends = [start(&[20.0, 0.0, 3.0, 5.0]), cut(&[22.0, 40.0, 30.0, 14.0])];
    assert_eq!(changes(&[&ends[0], &ends[1]], &[], 1.5, 2), [None, None]);
    // Now it comes up once more below 16, beside the lower one. Apart both would be changed by 3.
    let ends = [start(&[20.0, 0.0, 3.0, 5.0]), cut(&[22.0, 40.0, 14.0, 16.0])];
    let found = changes(&[&ends[0], &ends[1]], &[], 1.5, 2);
    let both: Vec<f64> = found.iter().flatten().map(|end| end.max_deviation_mm).collect();
    assert!(both.len() == 2 && both[0].abs() < 1e-8 && (both[1] - 2.0).abs() < 1e-8, "{both:?}");
}

#[test]
fn ends_keep_clear_of_a_cut_out_that_needs_both_knives() {
    let hole = [(20.0, 0.5), (30.0, 0.0), (20.0, -0.5), (20.0, 0.5)].map(|(u, v)| Point2::new(u, v)).to_vec();
    let ends = [start(&[0.0, 0.0, 24.0]), cut(&[60.0, 60.0, 26.0])];
    let found = changes(&[&ends[0], &ends[1]], std::slice::from_ref(&hole), 1.0, 2);
    let both: Vec<f64> = found.iter().flatten().map(|end| end.max_deviation_mm).collect();
    assert_eq!(both, [4.0, 4.0]);
    let changed = found.iter().flatten().map(|end| end.points.as_slice());
    assert_eq!(side_by_side(changed.chain([hole.as_slice()]), 1.0), 2);
}

/// Printed noise makes no turns: what is found is what is found without it.
#[test]
fn noise_below_a_reversal_costs_nothing() {
    let profile = |corners: &[(f64, f64)], noise: f64| -> Vec<f64> {
        let at = |share: f64| {
            let pair = corners.windows(2).find(|pair| share <= pair[1].0).unwrap();
            pair[0].1 + (pair[1].1 - pair[0].1) * (share - pair[0].0) / (pair[1].0 - pair[0].0)
        };
        (0..300).map(|i| at(f64::from(i) / 299.0) + noise * f64::from((i * 7919) % 11 - 5) / 5.0).collect()
    };
    let most = |noise: f64| {
        let lower = profile(&[(0.0, 100.0), (0.5, 100.0), (0.75, 130.0), (1.0, 90.0)], noise);
        let upper = profile(&[(0.0, 125.0), (0.25, 110.0), (0.5, 145.0), (1.0, 145.0)], noise);
        let ends = [start(&lower), cut(&upper)];
        let half = half(&ends[1]);
        let found = changes(&[&ends[0], &ends[1]], &[], half, 2);
        let changed: Vec<&[Point2]> = found.iter().flatten().map(|end| end.points.as_slice()).collect();
        assert!(changed.len() == 2 && side_by_side(changed.into_iter(), half) <= 2);
        found.iter().flatten().map(|end| end.max_deviation_mm).fold(0.0, f64::max)
    };
    assert!((most(0.0005) - most(0.0)).abs() < 0.01, "{} {}", most(0.0005), most(0.0));
}

/// An end that doubles back in v and is one chain stays as it is where the other can keep clear of it.
#[test]
fn an_end_that_doubles_back_need_not_be_filled() {
    let points = |list: &[(f64, f64)]| list.iter().map(|&(u, v)| Point2::new(u, v)).collect::<Vec<_>>();
    let upper = points(&[(200.0, -37.5), (210.0, 20.0), (220.0, -20.0), (230.0, 37.5)]);
    let lower = points(&[(196.0, 37.5), (204.0, 28.0), (100.0, -37.5)]);
    let found = changes(&[&lower, &upper], &[], 37.5, 1);
    let most = found.iter().flatten().map(|end| end.max_deviation_mm).fold(0.0, f64::max);
    assert!(most <= 8.0 + 1e-6, "{most}");
}

#[test]
fn very_many_turns_take_no_longer_than_they_may() {
    let teeth: Vec<f64> = (0..1200).map(|i| if i % 2 == 0 { f64::from(i % 7) } else { 30.0 }).collect();
    let upper: Vec<f64> = teeth.iter().map(|u| u + 5.0).collect();
    let ends = [start(&teeth), cut(&upper)];
    let half = half(&ends[1]);
    let found = changes(&[&ends[0], &ends[1]], &[], half, 2);
    let changed: Vec<&[Point2]> = found.iter().flatten().map(|end| end.points.as_slice()).collect();
    assert!(changed.len() == 2 && side_by_side(changed.into_iter(), half) <= 2);
}

#[test]
fn a_cut_that_does_not_cross_the_tape_is_left_alone() {
    let notch = [(0.0, 2.0), (10.0, 0.0), (20.0, 2.0)].map(|(u, v)| Point2::new(u, v));
    assert!(End::of(&notch, 2.0).is_none() && End::of(&[], 2.0).is_none());
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
        let found = changes(&[&given[0], &given[1]], &[], 0.5, 1);
        let most = found.iter().flatten().map(|end| end.max_deviation_mm).fold(0.0, f64::max);
        let least = brute_force_of_both(&lower, &upper);
        prop_assert!((most - least).abs() < 10.0 * LEVEL_MM, "{most} {least} {lower:?} {upper:?}");
    }

    #[test]
    fn no_two_ends_of_a_brute_force_deviate_less_for_two_knives(
        lower in prop::collection::vec(0..7_u8, 3..5), widths in prop::array::uniform4(1..4_u8), hole in any::<bool>()
    ) {
        let lower: Vec<f64> = lower.into_iter().map(f64::from).collect();
        let upper: Vec<f64> = lower.iter().zip(widths).map(|(low, width)| low + f64::from(width)).collect();
        let given = [start(&lower), cut(&upper)];
        // A cut-out beside the edge, between the ends.
        let v = given[1][1].y;
        let corners = [(lower[1] + 0.25, v), (upper[1] - 0.25, v), (lower[1] + 0.25, v + 0.01), (lower[1] + 0.25, v)];
        let holes: Vec<Vec<Point2>> =
            if hole { vec![corners.map(|(u, v)| Point2::new(u, v)).to_vec()] } else { Vec::new() };
        let found = changes(&[&given[0], &given[1]], &holes, half(&given[1]), 2);
        let most = found.iter().flatten().map(|end| end.max_deviation_mm).fold(0.0, f64::max);
        let less = less_of_both(&lower, &upper, &holes, most - 10.0 * LEVEL_MM);
        prop_assert!(less.is_none(), "{most} {less:?} {lower:?} {upper:?} {found:?}");
        let ends = given.iter().zip(&found).map(|(end, change)| change.as_ref().map_or(end.as_slice(), |c| &c.points));
        prop_assert!(side_by_side(ends.chain(holes.iter().map(Vec::as_slice)), half(&given[1])) <= 2, "{found:?}");
    }

    #[test]
    fn both_ends_keep_to_their_scrap_and_to_the_knives(
        lower in prop::collection::vec(0.0..90.0_f64, 2..7), widths in prop::collection::vec(1.0..60.0_f64, 6), knives in 1..=2_usize
    ) {
        let upper: Vec<f64> = lower.iter().zip(&widths).map(|(low, width)| low + width).collect();
        let given = [start(&lower), cut(&upper)];
        let half = half(&given[1]);
        let found = changes(&[&given[0], &given[1]], &[], half, knives);
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
        let changed = simplified(&given, knives);
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
