//! Questions to the contour against answers found point by point.

use i_overlay::core::fill_rule::FillRule;
use i_overlay::core::overlay_rule::OverlayRule;
use i_overlay::float::single::SingleFloatOverlay;
use proptest::prelude::*;

use super::super::*;
use super::{close, flat, short};
use crate::planning::geometry::simplify::distance_to_segment;

const WIDTH: f64 = 40.0;
const HEIGHT: f64 = 25.0;

/// Contours with walls, level stretches, peaks, and places at 0 and at the top.
fn contours() -> impl Strategy<Value = Vec<Point2>> {
    let z = prop_oneof![1 => Just(0.0), 1 => Just(HEIGHT), 8 => 0.0..HEIGHT];
    let run = prop_oneof![2 => Just(0.0), 1 => 0.0..0.05_f64, 6 => 0.5..8.0_f64];
    (z.clone(), prop::collection::vec((run, z), 1..30)).prop_map(|(first, steps)| {
        let total: f64 = steps.iter().map(|step| step.0).sum::<f64>() + 1.0;
        let mut x = 0.0;
        let mut points = vec![Point2::new(0.0, first)];
        for (run, z) in &steps {
            x += run * WIDTH / total;
            points.push(Point2::new(x, *z));
        }
        points.push(Point2::new(WIDTH, first));
        points
    })
}

fn places() -> impl Strategy<Value = Point2> {
    (-5.0..WIDTH + 5.0, -2.0..HEIGHT + 5.0).prop_map(|(x, z)| Point2::new(x, z))
}

fn lines() -> impl Strategy<Value = [Point2; 2]> {
    prop_oneof![
        4 => (places(), places()).prop_map(|(a, b)| [a, b]),
        1 => (places(), -2.0..HEIGHT + 5.0).prop_map(|(a, z)| [a, Point2::new(a.x, z)]),
        1 => (places(), -5.0..WIDTH + 5.0).prop_map(|(a, x)| [a, Point2::new(x, a.y)]),
    ]
}

/// The distance to a contour, segment by segment.
fn distance(points: &[Point2], place: &Point2) -> f64 {
    let each = points.windows(2).map(|pair| distance_to_segment(place, &pair[0], &pair[1]));
    each.fold(f64::INFINITY, f64::min)
}

/// How deep a place lies in the part: its distance to where that ends; negative outside, but for the sides' sake
/// not below minus the distance to the contour.
fn depth(points: &[Point2], place: &Point2) -> f64 {
    let to_contour = distance(points, place);
    let inside = (0.0..=WIDTH).contains(&place.x)
        && points.windows(2).any(|pair| {
            let (a, b) = (pair[0], pair[1]);
            a.x < b.x
                && (a.x..=b.x).contains(&place.x)
                && place.y < a.y + (b.y - a.y) * (place.x - a.x) / (b.x - a.x)
        });
    let ends = [place.x, WIDTH - place.x, place.y, to_contour];
    if inside { ends.into_iter().fold(f64::INFINITY, f64::min).max(0.0) } else { -to_contour }
}

const SAMPLES: u32 = 600;

fn sampled([a, b]: [Point2; 2]) -> impl Iterator<Item = (f64, Point2)> {
    (0..=SAMPLES).map(move |i| f64::from(i) / f64::from(SAMPLES)).map(move |t| (t, a + (b - a) * t))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn the_nearest_segment_is_found(points in contours(), place in places()) {
        let profile = Profile::new(&points, WIDTH, HEIGHT).unwrap();
        let (found, wanted) = (profile.distance(&place), distance(profile.points(), &place));
        prop_assert!((found - wanted).abs() < 1e-12, "{} {}", found, wanted);
    }

    #[test]
    fn portions_of_a_line_below_the_contour_are_found(points in contours(), line in lines()) {
        let profile = Profile::new(&points, WIDTH, HEIGHT).unwrap();
        let [a, b] = line;
        let (under, above) = (profile.under(&a, &b), profile.above(&a, &b));
        for (share, place) in sampled(line) {
            // On a border of a portion either answer is right.
            if distance(profile.points(), &place) < 1e-9 || place.x.min(WIDTH - place.x).abs() < 1e-9 {
                continue;
            }
            let below = (0.0..=WIDTH).contains(&place.x) && place.y < profile.height(place.x);
            let is_in = |portions: &[[f64; 2]]| portions.iter().any(|&[from, to]| (from..=to).contains(&share));
            prop_assert_eq!(is_in(&under), below, "{:?} {:?}", share, under);
            prop_assert!(is_in(&above) || below, "{:?} {:?}", share, above);
        }
        let total: f64 = under.iter().chain(&above).map(|[from, to]| to - from).sum();
        prop_assert!((total - 1.0).abs() < 1e-9);
    }

    #[test]
    fn the_deepest_and_the_farthest_point_of_a_line_are_found(points in contours(), line in lines()) {
        let profile = Profile::new(&points, WIDTH, HEIGHT).unwrap();
        let spacing = (line[1] - line[0]).norm() / f64::from(SAMPLES);
        let depths = sampled(line).map(|(_, place)| depth(profile.points(), &place));
        let wanted = depths.fold(0.0_f64, f64::max);
        let found = profile.depth(&line[0], &line[1]);
        prop_assert!(wanted - 1e-6 <= found && found <= wanted + spacing, "{} {}", found, wanted);

        let above = sampled(line).filter(|(_, place)| {
            !(0.0..=WIDTH).contains(&place.x) || place.y > profile.height(place.x)
        });
        let wanted = above.map(|(_, place)| distance(profile.points(), &place)).fold(0.0_f64, f64::max);
        let mut best = None;
        profile.farthest_above(&line[0], &line[1], &mut best);
        let found = best.map_or(0.0, |farthest| farthest.distance);
        prop_assert!(wanted - 1e-6 <= found && found <= wanted + spacing, "{} {}", found, wanted);
        if let Some(farthest) = best {
            prop_assert!((distance(profile.points(), &farthest.at) - farthest.distance).abs() < 1e-9);
        }
    }

    #[test]
    fn the_area_of_a_polygon_below_the_contour_is_that_of_the_overlay(
        points in contours(),
        corners in prop::collection::vec((0.0..WIDTH, 0.0..HEIGHT), 3..4),
    ) {
        let profile = Profile::new(&points, WIDTH, HEIGHT).unwrap();
        let polygon: Vec<[f64; 2]> = corners.iter().map(|&(x, z)| [x, z]).collect();
        let mut part: Vec<[f64; 2]> = profile.points().iter().map(|p| [p.x, p.y]).collect();
        part.extend([[WIDTH, 0.0], [0.0, 0.0]]);
        let both = polygon.overlay_as::<i64>(&part, OverlayRule::Intersect, FillRule::NonZero);
        let loops = both.iter().flatten().map(|points| {
            let next = points.iter().cycle().skip(1);
            points.iter().zip(next).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum::<f64>() / 2.0
        });
        let wanted: f64 = loops.sum();
        let at = |i: usize| Point2::new(polygon[i % 3][0], polygon[i % 3][1]);
        let found = (0..3).map(|i| profile.strip_under(&at(i), &at(i + 1))).sum::<f64>().abs();
        prop_assert!((found - wanted).abs() < 1e-6, "{} {}", found, wanted);
    }

    #[test]
    fn a_tip_is_allowed_from_its_lowest_place_on(
        points in contours(), x in -4.0..WIDTH + 4.0, swing_deg in 0.5..75.0_f64, reach in 2.0..15.0_f64,
    ) {
        let profile = Profile::new(&points, WIDTH, HEIGHT).unwrap();
        let swing = swing_deg.to_radians();
        let lowest = profile.lowest_tip(x, swing, reach);
        let allowed = |z: f64| profile.tip_allowed(&Point2::new(x, z), swing, reach, 0.0);
        prop_assert!(allowed(lowest + 1e-9) && allowed(lowest + 1.0) && allowed(lowest + 30.0), "{}", lowest);
        if lowest > 0.0 {
            // A little deeper an arm is in the part. How much of it, and how deep, depends on how it meets the contour: it
            // may cross a needle's point, where it is nowhere far from the needle's sides.
            let enters = |z: f64| {
                [Side::Left, Side::Right].iter().any(|&side| {
                    let cut = Cut { tip: Point2::new(x, z), side, swing, reach: short(reach) };
                    !profile.under(&cut.tip, &cut.at(reach)).is_empty()
                })
            };
            prop_assert!(enters(lowest - 1e-3) || lowest < 1e-3, "{}", lowest);
        } else {
            prop_assert!(!allowed(-1e-3));
        }
    }

    #[test]
    fn an_allowance_keeps_its_distance(
        points in contours(), tip in places(), swing_deg in 0.0..75.0_f64, reach in 2.0..15.0_f64, allowance in 0.0..3.0_f64,
    ) {
        let section = Section::new(WIDTH, HEIGHT, &points, allowance, 8.0).unwrap();
        let profile = section.profile();
        let swing = swing_deg.to_radians();
        let found = section.tip_allowed(&tip, swing, &short(reach));
        let arms = [Side::Left, Side::Right].map(|side| {
            let cut = Cut { tip, side, swing, reach: short(reach) };
            let arm = sampled([tip, cut.at(reach)]);
            arm.map(|(_, place)| depth(profile.points(), &place)).fold(f64::NEG_INFINITY, f64::max)
        });
        let nearest = arms[0].max(arms[1]);
        let spacing = reach / f64::from(SAMPLES);
        if tip.y < -1e-6 || nearest > 1e-6 || nearest > 1e-6 - allowance {
            prop_assert!(!found, "{}", nearest);
        } else if nearest < -allowance - spacing {
            prop_assert!(found, "{}", nearest);
        }
    }
}

#[test]
fn exactly_on_the_contour_is_allowed_and_a_hair_below_is_not() {
    let section = Section::new(80.0, 50.0, &super::arc_of(80.0), 0.0, 8.0).unwrap();
    for i in 0..=800_u32 {
        let x = f64::from(i) * 0.1;
        let z = section.profile().height(x);
        let allowed = |z: f64| section.tip_allowed(&Point2::new(x, z), 0.6, &short(8.0));
        assert!(allowed(z) && allowed(z + 1e-12) && !allowed(z - 1e-6), "{x} {z}");
    }
}

#[test]
fn walls_are_met_from_both_sides_and_may_be_touched() {
    let step = [(0.0, 10.0), (40.0, 10.0), (40.0, 30.0), (80.0, 30.0)].map(|(x, z)| Point2::new(x, z));
    let section = Section::new(80.0, 50.0, &step, 0.0, 8.0).unwrap();
    let allowed = |x: f64, z: f64, swing: f64| section.tip_allowed(&Point2::new(x, z), swing, &short(8.0));
    // Upright along the wall; leaning into it; from so far off that the arm ends at it.
    assert!(allowed(40.0, 10.0, 0.0) && allowed(40.0, 20.0, 0.0) && !allowed(40.000001, 20.0, 0.0));
    assert!(!allowed(39.0, 12.0, 0.5) && allowed(40.0 - 8.0 * 0.5_f64.sin(), 12.0, 0.5));
    assert!(!allowed(40.0 - 8.0 * 0.5_f64.sin() + 1e-6, 12.0, 0.5));
    assert!(allowed(40.0, 30.0, 0.5) && allowed(41.0, 30.0, 0.5) && !allowed(41.0, 29.999, 0.5));
    close(section.profile().lowest_tip(38.0, 0.5, 20.0), 30.0 - 2.0 / 0.5_f64.tan(), 1e-9);
    close(section.profile().lowest_tip(38.0, 0.5, 1.0), 10.0, 0.0);
    // The lower edge of the step has the wall's height too.
    assert_eq!((section.profile().height(40.0), section.profile().highest(0.0, 39.9)), (30.0, 10.0));
}

#[test]
fn an_allowance_is_a_distance_not_a_height() {
    let slope = [(0.0, 0.0), (40.0, 40.0), (80.0, 40.0)].map(|(x, z)| Point2::new(x, z));
    let section = Section::new(80.0, 50.0, &slope, 1.0, 8.0).unwrap();
    let allowed = |x: f64, z: f64| section.tip_allowed(&Point2::new(x, z), 0.3, &short(8.0));
    // On a slope of 45 degrees a millimetre off is 1.414 up.
    assert!(allowed(20.0, 20.0 + 1.4143) && !allowed(20.0, 20.0 + 1.414));
    assert!(allowed(60.0, 41.0) && !allowed(60.0, 41.0 - 1e-6));
    let none = Section::new(80.0, 50.0, &flat(80.0, 40.0), 0.0, 8.0).unwrap();
    assert!(none.tip_allowed(&Point2::new(60.0, 40.0), 0.3, &short(8.0)));
}
