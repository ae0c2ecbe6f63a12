//! How much of a flat ply its courses leave bare, and how much they lay double.

use i_overlay::core::fill_rule::FillRule;
use i_overlay::core::overlay_rule::OverlayRule;
use i_overlay::float::single::SingleFloatOverlay;

use super::input::{Course, Ply};
use super::outline::Plane;
use crate::planning::budget::Budget;
use crate::planning::finding::{Code, Finding};
use crate::planning::geometry::polygon::signed_area;
use crate::planning::geometry::{Point2, Vector2};
use crate::planning::tolerance::{COVERED_SHARE, STRAIGHT_MM};

/// Says how much of a flat ply lies under none of its courses, and how much under several; `laid_mm2` is the area of all its
/// pieces, and nobody is told of an overlap that a rule for generated courses asks for. Of a ply on a curved mould, or
/// of courses that are steered, the areas of the pieces alone tell: then courses that overlap hide a part of what is bare.
///
/// # Errors
/// What the budget says.
pub fn findings(
    laid_mm2: f64,
    ply: &Ply,
    generated: bool,
    width_mm: f64,
    budget: &Budget<'_>,
) -> Result<Vec<Finding>, Vec<Finding>> {
    let Some(plane) = Plane::of(&ply.boundary).filter(|plane| plane.holds(&ply.boundary)) else {
        return Ok(Vec::new());
    };
    let outlines: Vec<Vec<Point2>> =
        std::iter::once(&ply.boundary).chain(&ply.holes).map(|outline| plane.flatten(outline)).collect();
    let areas = outlines.iter().map(|outline| signed_area(outline).abs());
    let area_mm2 = areas.enumerate().map(|(index, area)| if index == 0 { area } else { -area }).sum::<f64>();
    let strips: Option<Vec<Strip>> = ply.courses.iter().map(|course| Strip::of(course, &plane)).collect();
    let covered_mm2 = match &strips {
        Some(strips) if !apart(strips, width_mm) => {
            let points = outlines.iter().map(Vec::len).sum::<usize>() + strips.len();
            budget.spend(STEPS_A_POINT * points as u64).map_err(|finding| vec![finding])?;
            area_mm2 - bare_mm2(&outlines, strips, width_mm)
        }
        _ => laid_mm2,
    };
    // Of steered courses it is known that what is more than the ply lies double.
    let double_mm2 = laid_mm2 - covered_mm2.min(area_mm2);
    let exact = strips.is_some();
    let at = || format!("{}/tracks", ply.place);
    let share = |of_mm2: f64| of_mm2 / area_mm2 * 100.0;
    let bare = (covered_mm2 < COVERED_SHARE * area_mm2).then(|| {
        let at_most = if exact { "" } else { " at most" };
        let message = format!(
            "the courses cover {:.1} % of {ply}{at_most}; see whether a course is missing, or the tape's width is in mm",
            share(covered_mm2)
        );
        Finding::warning(Code::PlyNotCovered, at(), message)
    });
    let double = (!generated && double_mm2 > (1.0 - COVERED_SHARE) * area_mm2).then(|| {
        let at_least = if exact { "" } else { " at least" };
        let message = format!(
            "the courses lay {:.1} % of {ply} double{at_least}; see whether they are a tape's width apart",
            share(double_mm2)
        );
        Finding::warning(Code::CoursesOverlap, at(), message)
    });
    Ok(bare.into_iter().chain(double).collect())
}

/// The middle of a straight course in the plane of its ply.
struct Strip {
    from: Point2,
    along: Vector2,
}

impl Strip {
    /// `None` if the course is not straight.
    fn of(course: &Course, plane: &Plane) -> Option<Self> {
        let points = plane.flatten(&course.points);
        let (from, to) = (points[0], points[points.len() - 1]);
        let along = (to - from).normalize();
        let straight = points.iter().all(|point| (point - from).perp(&along).abs() <= STRAIGHT_MM);
        straight.then_some(Self { from, along })
    }

    /// How far its middle lies across from a place.
    fn across_mm(&self, place: &Point2) -> f64 {
        (place - self.from).perp(&self.along)
    }
}

/// Whether tapes of that width lie side by side, so that no place has two of them.
fn apart(strips: &[Strip], width_mm: f64) -> bool {
    let Some(first) = strips.first() else { return true };
    let mut across: Vec<f64> = strips.iter().map(|strip| first.across_mm(&strip.from)).collect();
    across.sort_by(f64::total_cmp);
    let parallel = strips.iter().all(|strip| strip.along.perp(&first.along).abs() < PARALLEL_SINE);
    parallel && across.windows(2).all(|pair| pair[1] - pair[0] >= width_mm - STRAIGHT_MM)
}

/// Over a ply of ten metres this is a tenth of a millimetre.
const PARALLEL_SINE: f64 = 1e-5;

/// What cutting tapes off an outline takes, in steps a point: it is sorted.
const STEPS_A_POINT: u64 = 64;

/// What none of the tapes covers.
fn bare_mm2(outlines: &[Vec<Point2>], strips: &[Strip], width_mm: f64) -> f64 {
    let plain = |outline: &Vec<Point2>| outline.iter().map(|p| [p.x, p.y]).collect::<Vec<[f64; 2]>>();
    let ply: Vec<Vec<[f64; 2]>> = outlines.iter().map(plain).collect();
    let start = outlines[0][0];
    let extent_mm = outlines[0].iter().map(|point| (point - start).norm()).fold(width_mm, f64::max);
    let tapes: Vec<Vec<[f64; 2]>> = strips
        .iter()
        .map(|strip| {
            let far = (start - strip.from).norm() + extent_mm;
            let (ahead, aside) =
                (strip.along * far, Vector2::new(-strip.along.y, strip.along.x) * width_mm / 2.0);
            let corners = [-ahead - aside, ahead - aside, ahead + aside, aside - ahead];
            corners.map(|corner| (strip.from + corner).into()).to_vec()
        })
        .collect();
    // Outlines may turn either way: what lies in an odd number of them is ply. Tapes all turn the same way.
    let ply = ply.overlay(&Vec::<Vec<[f64; 2]>>::new(), OverlayRule::Subject, FillRule::EvenOdd);
    let bare = ply.overlay(&tapes, OverlayRule::Difference, FillRule::NonZero);
    let area = |contour: &Vec<[f64; 2]>| {
        signed_area(&contour.iter().map(|point| Point2::new(point[0], point[1])).collect::<Vec<_>>())
    };
    // Holes of a shape turn the other way round.
    bare.iter().map(|shape| shape.iter().map(area).sum::<f64>().abs()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn square(half: f64) -> Vec<Point2> {
        [[-half, -half], [half, -half], [half, half], [-half, half]].map(Point2::from).to_vec()
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, ..ProptestConfig::default() })]
        /// Points of a grid, looked at one by one.
        #[test]
        fn what_is_bare_agrees_with_sampled_points(
            courses in prop::collection::vec((-180.0..180.0_f64, 0.0..std::f64::consts::TAU), 0..7), width in 20.0..90.0_f64
        ) {
            let strips: Vec<Strip> = courses.iter().map(|(aside, angle)| {
                let along = Vector2::new(angle.cos(), angle.sin());
                Strip { from: Point2::from(Vector2::new(-along.y, along.x) * *aside), along }
            }).collect();
            let mut hole = square(50.0);
            hole.reverse();
            let found = bare_mm2(&[square(150.0), hole], &strips, width);
            let at = |step: i32| f64::from(step) * 2.0 - 149.0;
            let bare = |point: Point2| {
                point.x.abs().max(point.y.abs()) > 50.0
                    && strips.iter().all(|strip| strip.across_mm(&point).abs() > width / 2.0)
            };
            let sampled = (0..150 * 150).filter(|i| bare(Point2::new(at(i % 150), at(i / 150)))).count();
            prop_assert!((found - 4.0 * sampled as f64).abs() < 900.0, "{found} {}", 4 * sampled);
        }
    }
}
