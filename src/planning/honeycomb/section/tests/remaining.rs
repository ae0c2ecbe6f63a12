//! The surface that is left, its scallop and its area.

use proptest::prelude::*;

use super::super::*;
use super::{check_areas, close, cut, flat, short, vee};
use crate::planning::geometry::simplify::distance_to_segment;
use crate::planning::tolerance::KERF_MM;

/// The largest distance of a densely sampled surface above a contour from it, and the spacing of the samples.
fn sampled_scallop(surface: &[Vec<Point2>], profile: &[Point2]) -> f64 {
    let height = |x: f64| {
        let spans = profile.windows(2).filter(|pair| pair[0].x <= x && x <= pair[1].x);
        let at = |pair: &[Point2]| match pair[1].x - pair[0].x {
            0.0 => pair[0].y.max(pair[1].y),
            run => pair[0].y + (pair[1].y - pair[0].y) * (x - pair[0].x) / run,
        };
        spans.map(at).fold(f64::NEG_INFINITY, f64::max)
    };
    let distance = |point: &Point2| {
        profile
            .windows(2)
            .map(|pair| distance_to_segment(point, &pair[0], &pair[1]))
            .fold(f64::INFINITY, f64::min)
    };
    let mut largest = 0.0_f64;
    for pair in surface.iter().flat_map(|line| line.windows(2)) {
        let steps = ((pair[1] - pair[0]).norm() / SPACING).ceil() as u32;
        for step in 0..=steps {
            let point = pair[0] + (pair[1] - pair[0]) * (f64::from(step) / f64::from(steps));
            if point.y > height(point.x) {
                largest = largest.max(distance(&point));
            }
        }
    }
    largest
}

const SPACING: f64 = 0.02;

#[test]
fn an_uncut_blank_stands_its_full_height_above_the_contour() {
    let section = Section::new(80.0, 50.0, &flat(80.0, 10.0), 0.0, 9.0).unwrap();
    let remains = section.remains();
    close(remains.scallop.unwrap().distance, 40.0, 1e-6);
    close(remains.residual_area, 80.0 * 40.0, 1e-6);
    // Up the left side from the contour, over the top, down the right side to the contour.
    let wanted = [(0.0, 10.0), (0.0, 50.0), (80.0, 50.0), (80.0, 10.0)].map(|(x, z)| Point2::new(x, z));
    assert_eq!(remains.surface, [wanted]);
    // Nothing to cut, no scallop.
    let done = Section::new(80.0, 50.0, &flat(80.0, 50.0), 0.0, 9.0).unwrap().remains();
    assert!(done.scallop.is_none_or(|scallop| scallop.distance == 0.0), "{done:?}");
    assert_eq!(done.residual_area, 0.0);
}

#[test]
fn a_ridge_is_the_scallop_to_a_millionth() {
    let mut section = Section::new(12.0, 20.0, &flat(12.0, 10.0), 0.0, 9.0).unwrap();
    let swing = 34.155_f64;
    // Tips at the sides and one step between them: the only ridge is half way, and the arms reach the top.
    for x in [0.0, 12.0] {
        vee(&mut section, x, 11.0, swing, 11.0);
    }
    let scallop = section.remains().scallop.unwrap();
    let (sine, tangent) = (swing.to_radians().sin(), swing.to_radians().tan());
    close(scallop.distance, 1.0 + 6.0 / tangent - KERF_MM / 2.0 / sine, 1e-6);
    close(scallop.at.x, 6.0, 1e-6);
}

#[test]
fn a_slit_that_frees_nothing_is_part_of_the_surface_or_a_loop_of_its_own() {
    let mut section = Section::new(80.0, 50.0, &flat(80.0, 10.0), 0.0, 9.0).unwrap();
    section.cut(&cut(40.0, 20.0, Side::Left, 30.0, 8.0)).unwrap();
    let inner = section.remains();
    assert_eq!(inner.surface.len(), 2);
    let ring = inner.surface.iter().find(|line| line.first() == line.last()).unwrap();
    assert_eq!(ring.len(), 5);
    section.cut(&cut(20.0, 45.0, Side::Right, 30.0, 8.0)).unwrap();
    let open = section.remains();
    assert_eq!(open.surface.len(), 2);
    assert_eq!(open.surface.iter().map(Vec::len).max(), Some(8));
    // Stuck are tips with both arms; these have one each.
    assert!(open.stuck.is_empty());
}

#[test]
fn surfaces_run_from_left_to_right_in_one_line() {
    let mut section = Section::new(85.0, 50.0, &super::arc(), 0.0, 3.0).unwrap();
    for x in [10.0, 20.0, 30.0, 40.0, 61.0] {
        vee(&mut section, x, 44.0, 45.0, 9.0);
    }
    let surface = section.remains().surface;
    assert_eq!(surface.len(), 1);
    let (first, last) = (surface[0][0], surface[0][surface[0].len() - 1]);
    close(first.x, 0.0, 0.0);
    close(last.x, 85.0, 1e-7);
    close(first.y, super::arc()[0].y, 1e-7);
    // A tooth is five corners: down, twice the overlap of its slits at the tip, up.
    assert!(surface[0].len() < 60, "{}", surface[0].len());
}

fn profiles() -> impl Strategy<Value = Vec<Point2>> {
    let step = (prop_oneof![1 => Just(0.0), 3 => 0.5..8.0_f64], 0.0..18.0_f64);
    prop::collection::vec(step, 2..14).prop_map(|steps| {
        let total: f64 = steps.iter().map(|step| step.0).sum::<f64>() + 5.0;
        let mut x = 0.0;
        let mut points = vec![Point2::new(0.0, steps[0].1)];
        for (run, z) in &steps {
            x += run * 40.0 / total;
            points.push(Point2::new(x, *z));
        }
        points.push(Point2::new(40.0, 6.0));
        points
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn scallop_and_residual_are_what_sampling_finds(
        profile in profiles(),
        tips in prop::collection::vec((-2.0..42.0_f64, 0.0..24.0_f64, 5.0..60.0_f64, 3.0..12.0_f64), 0..14),
    ) {
        let mut section = Section::new(40.0, 25.0, &profile, 0.0, 7.0).unwrap();
        let mut outcomes = Vec::new();
        for (x, z, swing, reach) in tips {
            if section.tip_allowed(&Point2::new(x, z), swing.to_radians(), &short(reach)) {
                outcomes.extend(vee(&mut section, x, z, swing, reach));
            }
        }
        check_areas(&section, &outcomes);
        prop_assert!(outcomes.iter().all(|outcome| !outcome.is_gouge()));
        let remains = section.remains();
        prop_assert!(remains.gouge_area == 0.0 && remains.deepest_gouge <= 1e-9, "{:?}", remains);
        let (found, sampled) = (remains.scallop.unwrap().distance, sampled_scallop(&remains.surface, section.profile().points()));
        prop_assert!(sampled - 1e-6 <= found && found <= sampled + SPACING, "{} {}", found, sampled);
        let stock = section.stock_area() + remains.slit_area_of_part - section.profile().part_area();
        prop_assert!((stock - remains.residual_area).abs() < 1e-6, "{} {}", stock, remains.residual_area);
    }
}
