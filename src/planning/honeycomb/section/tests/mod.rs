//! Sections against planted answers and against slow references that share no code with them.

mod air;
mod contour;
mod lattices;
mod planted;
mod polygons;
mod raster;
mod refused;
mod remaining;

use super::*;

/// Table 1's contour: an arc of radius 85 over a blank of 85 by 50, as the job document prints it.
pub(super) fn arc() -> Vec<Point2> {
    arc_of(85.0)
}

/// The same arc over a blank of another width.
pub(super) fn arc_of(width: f64) -> Vec<Point2> {
    let z = |x: f64| 16.782213 - 85.0 + (85.0_f64.powi(2) - (x - width / 2.0).powi(2)).sqrt();
    (0..=340).map(|i| f64::from(i) * width / 340.0).map(|x| Point2::new(x, z(x))).collect()
}

pub(super) fn flat(width: f64, z: f64) -> Vec<Point2> {
    vec![Point2::new(0.0, z), Point2::new(width, z)]
}

/// A blade that ends where its cutting length does.
pub(super) fn short(cutting: f64) -> Reach {
    Reach { cutting, edge: cutting, body: cutting }
}

pub(super) fn cut(x: f64, z: f64, side: Side, swing_deg: f64, cutting: f64) -> Cut {
    Cut { tip: Point2::new(x, z), side, swing: swing_deg.to_radians(), reach: short(cutting) }
}

/// Both cuts of a tip.
pub(super) fn vee(section: &mut Section, x: f64, z: f64, swing_deg: f64, cutting: f64) -> [CutOutcome; 2] {
    [Side::Left, Side::Right].map(|side| section.cut(&cut(x, z, side, swing_deg, cutting)).unwrap())
}

#[track_caller]
pub(super) fn close(found: f64, wanted: f64, tolerance: f64) {
    assert!((found - wanted).abs() <= tolerance, "found {found}, wanted {wanted}, off by {}", found - wanted);
}

/// The areas of a section add up to the blank.
#[track_caller]
pub(super) fn check_areas(section: &Section, outcomes: &[CutOutcome]) {
    let chips: f64 = outcomes.iter().flat_map(|outcome| &outcome.chips).map(|chip| chip.area).sum();
    let slits: f64 = outcomes.iter().map(|outcome| outcome.slit_area).sum();
    let blank = section.profile().width() * section.profile().blank_height();
    close(section.stock_area() + chips + slits, blank, 1e-6 + blank * 1e-9);
}
