//! Polygons minus a slit, and pieces joined again: the overlay of polygons on the grid.

use i_overlay::core::fill_rule::FillRule;
use i_overlay::core::overlay::{ContourDirection, IntOverlayOptions, Overlay, ShapeType};
use i_overlay::core::overlay_rule::OverlayRule;
use i_overlay::core::solver::{Precision, Solver, Strategy};
use i_overlay::i_shape::int::shape::IntShapes;

use super::grid::GridPoint;
use crate::planning::tolerance::SLIVER_UNITS;

/// The overlay with the storage that it keeps from call to call.
pub(super) struct Knife(Overlay<i64>);

impl Knife {
    pub(super) fn new() -> Self {
        let options = IntOverlayOptions {
            preserve_input_collinear: false,
            output_direction: ContourDirection::CounterClockwise,
            preserve_output_collinear: false,
            min_output_area: (SLIVER_UNITS * SLIVER_UNITS).unsigned_abs().into(),
            // Without this, polygons that meet in a single point may come out as one.
            ogc: true,
        };
        let solver = Solver { strategy: Strategy::Auto, precision: Precision::HIGH, multithreading: None };
        Self(Overlay::new_custom(ROOM, options, solver))
    }

    /// What of a polygon with holes is left beside a slit: connected polygons with holes.
    pub(super) fn minus(&mut self, polygon: &[Vec<GridPoint>], slit: &[GridPoint]) -> IntShapes<i64> {
        self.0.clear();
        polygon.iter().for_each(|points| self.0.add_contour(points, ShapeType::Subject));
        self.0.add_contour(slit, ShapeType::Clip);
        self.0.overlay(OverlayRule::Difference, FillRule::NonZero)
    }

    /// The union of polygons with holes.
    pub(super) fn joined<'a>(
        &mut self,
        contours: impl Iterator<Item = &'a Vec<GridPoint>>,
    ) -> IntShapes<i64> {
        self.0.clear();
        contours.for_each(|points| self.0.add_contour(points, ShapeType::Subject));
        self.0.overlay(OverlayRule::Subject, FillRule::NonZero)
    }
}

/// Room for the edges of a usual piece.
const ROOM: usize = 64;

impl Clone for Knife {
    /// It holds nothing but storage.
    fn clone(&self) -> Self {
        Self::new()
    }
}

impl std::fmt::Debug for Knife {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Knife")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polygons_that_meet_in_points_alone_are_several() {
        let scaled = |points: &[(i64, i64)]| {
            points.iter().map(|&(x, y)| GridPoint::new(x << 20, y << 20)).collect::<Vec<_>>()
        };
        // Two halves of a ring that meet in two points: the hole of the square, and what is taken out besides.
        let square = scaled(&[(0, 0), (20, 0), (20, 20), (0, 20)]);
        let left = scaled(&[(3, 10), (10, 17), (5, 10), (10, 3)]);
        let right = scaled(&[(17, 10), (10, 17), (15, 10), (10, 3)]);
        let shapes = Knife::new().minus(&[square, left], &right);
        assert_eq!(shapes.len(), 2, "the middle of the ring is an island: {shapes:?}");
    }
}
