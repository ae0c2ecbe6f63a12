//! The spool of a profile whose tape axis turns it.

use serde::{Deserialize, Serialize};

use crate::planning::document::shape::{Shape, optional, required};

/// The largest radius in mm: no such roll goes through a door.
const LARGEST_RADIUS_MM: f64 = 5_000.0;
/// The thickest layer in mm: tape, backing paper and film.
const THICKEST_MM: f64 = 10.0;

/// A spool whose angle is driven.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Spool {
    /// Radius of the bare core, in mm.
    pub core_radius_mm: f64,
    /// Radius to the outermost layer where the program begins, in mm.
    pub roll_radius_mm: f64,
    /// Thickness of a layer as it is wound, with its paper and film, in mm.
    pub layer_thickness_mm: f64,
    /// How far off the roll's radius may have been measured, in mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub radius_error_mm: Option<f64>,
}

/// The shape of a spool.
pub(super) const SPOOL: Shape = Shape::Object(&[
    required("core_radius_mm", Shape::Number { min: 1.0, max: LARGEST_RADIUS_MM }),
    required("roll_radius_mm", Shape::Number { min: 1.0, max: LARGEST_RADIUS_MM }),
    required("layer_thickness_mm", Shape::Positive { max: THICKEST_MM }),
    optional("radius_error_mm", Shape::Number { min: 0.0, max: 10.0 }),
]);
