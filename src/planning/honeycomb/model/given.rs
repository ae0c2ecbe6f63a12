//! What the published model is told, and why it may refuse it.

use std::f64::consts::FRAC_PI_2;

use thiserror::Error;

use super::limit::Limit;
use crate::planning::honeycomb::lattice_kind::Lattice;
use crate::planning::tolerance::SAME_POINT_MM;

/// What is known before the path parameters are (Cui et al. 2020, Table 1), in mm, rad and s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Given {
    /// W, across the cuts, in mm.
    pub blank_width_mm: f64,
    /// D, along the cuts, in mm.
    pub blank_length_mm: f64,
    /// A_C: the area of the section that is to be removed, in mm2.
    pub machined_area_mm2: f64,
    /// h0, from the blank's top to the plane of free travel, in mm.
    pub safety_distance_mm: f64,
    /// theta, between the tool axis and the feed, in rad.
    pub rake_rad: f64,
    /// beta, half of the angle at the blade's tip, in rad.
    pub half_apex_rad: f64,
    /// v1, while cutting, in mm/s.
    pub cutting_speed_mm_s: f64,
    /// v2, elsewhere, in mm/s.
    pub travel_speed_mm_s: f64,
    /// omega, of turning, in rad/s.
    pub angular_speed_rad_s: f64,
    /// delta_max in mm.
    pub max_scallop_mm: f64,
    /// L_max in mm.
    pub max_cutting_length_mm: f64,
    /// alpha_max in rad.
    pub max_swing_rad: f64,
    /// How layers lie to one another: k and the form of the scallop.
    pub lattice: Lattice,
}

/// Why there is no optimum.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum Refusal {
    /// Numbers that no machine and no part have, each of them.
    #[error("{}", listed(.0))]
    OutOfRange(Vec<OutOfRange>),
    /// Limits that leave no parameters at all, each of them.
    #[error("{}", listed(.0))]
    Excluded(Vec<Exclusion>),
}

/// A number outside its range.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error("{field} is {value}, which is not within {least} to {most}")]
pub struct OutOfRange {
    /// The name of the number, with its unit.
    pub field: &'static str,
    /// The number; it may be NaN.
    pub value: f64,
    /// The least that is taken.
    pub least: f64,
    /// The most that is taken.
    pub most: f64,
}

/// What a limit by itself leaves nothing of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Excluded {
    /// h.
    LayerSpacing,
    /// s.
    Step,
}

/// A limit that excludes all parameters.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error("{limit} excludes every {}: {}; it allows {largest_mm} mm, and {SAME_POINT_MM} mm is the least", .excluded.as_str(), .limit.reason())]
pub struct Exclusion {
    /// The limit.
    pub limit: Limit,
    /// What it leaves nothing of.
    pub excluded: Excluded,
    /// The largest that it allows, in mm; below `SAME_POINT_MM`.
    pub largest_mm: f64,
}

/// Sizes in mm, from a thousandth to a kilometre: all parts and blades, and room for the squares of both.
const SIZE_MM: [f64; 2] = [1e-3, 1e6];

/// Speeds in mm/s, from a millimetre in a quarter of an hour to a kilometre a second.
const SPEED_MM_S: [f64; 2] = [1e-3, 1e6];

/// Speeds of turning in rad/s, from a turn in a week to 1,500 turns a second.
const SPEED_RAD_S: [f64; 2] = [1e-5, 1e4];

impl Given {
    /// Whether the model can be asked at all, and whether any parameters are within its limits.
    ///
    /// Every limit is one from above on h or s, or becomes one at a given alpha, so small enough parameters are
    /// within all of them: nothing is excluded unless a limit alone excludes everything.
    ///
    /// # Errors
    /// Every number outside its range; if there are none, every limit that excludes all parameters.
    pub fn check(&self) -> Result<(), Refusal> {
        let faults: Vec<_> = self.ranges().into_iter().filter_map(fault).collect();
        if !faults.is_empty() {
            return Err(Refusal::OutOfRange(faults));
        }
        let exclusions = self.exclusions();
        if exclusions.is_empty() { Ok(()) } else { Err(Refusal::Excluded(exclusions)) }
    }

    fn ranges(&self) -> [(&'static str, f64, [f64; 2]); 12] {
        let from_zero = [0.0, SIZE_MM[1]];
        [
            ("blank_width_mm", self.blank_width_mm, SIZE_MM),
            ("blank_length_mm", self.blank_length_mm, SIZE_MM),
            ("machined_area_mm2", self.machined_area_mm2, [0.0, SIZE_MM[1] * SIZE_MM[1]]),
            ("safety_distance_mm", self.safety_distance_mm, from_zero),
            ("rake_rad", self.rake_rad, [0.0, FRAC_PI_2]),
            ("half_apex_rad", self.half_apex_rad, [0.0, FRAC_PI_2]),
            ("cutting_speed_mm_s", self.cutting_speed_mm_s, SPEED_MM_S),
            ("travel_speed_mm_s", self.travel_speed_mm_s, SPEED_MM_S),
            ("angular_speed_rad_s", self.angular_speed_rad_s, SPEED_RAD_S),
            ("max_scallop_mm", self.max_scallop_mm, from_zero),
            ("max_cutting_length_mm", self.max_cutting_length_mm, from_zero),
            ("max_swing_rad", self.max_swing_rad, [0.0, FRAC_PI_2]),
        ]
    }

    fn exclusions(&self) -> Vec<Exclusion> {
        let edge_angle = self.rake_rad - self.half_apex_rad;
        let depth = self.lattice.depth_factor() * self.max_cutting_length_mm * edge_angle.sin();
        let layers = self.machined_area_mm2 / self.blank_width_mm / 1.5;
        let spacing = depth.min(self.max_scallop_mm).min(layers);
        // What the swing angle allows is asked of it only where the others leave a layer spacing.
        let step =
            if spacing < SAME_POINT_MM { f64::INFINITY } else { 2.0 * spacing * self.max_swing_rad.tan() };
        let largest = [
            (Limit::CuttingLength, Excluded::LayerSpacing, depth),
            (Limit::Scallop, Excluded::LayerSpacing, self.max_scallop_mm),
            (Limit::SwingAngle, Excluded::Step, step),
            (Limit::Layers, Excluded::LayerSpacing, layers),
        ];
        largest
            .into_iter()
            .filter(|&(.., largest_mm)| largest_mm < SAME_POINT_MM)
            .map(|(limit, excluded, largest_mm)| Exclusion { limit, excluded, largest_mm })
            .collect()
    }
}

impl Excluded {
    /// The words for it.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::LayerSpacing => "layer spacing",
            Self::Step => "step",
        }
    }
}

impl Limit {
    /// Why it can exclude everything.
    fn reason(self) -> &'static str {
        match self {
            Self::CuttingLength => "k L_max sin(theta - beta) is how high the edge stands in the section",
            Self::Step => "without overlap a step is 2 h tan(alpha)",
            Self::Scallop => "no scallop is lower than the layer spacing",
            Self::SwingAngle => "a step is at most 2 h tan(alpha_max)",
            Self::Layers => "n >= 1 wants A_C / W of at least one and a half layer spacings",
            Self::Points => "m >= 1 wants a step of at most twice the width",
        }
    }
}

/// What is wrong with a number, if anything is; NaN is outside every range.
pub(super) fn fault((field, value, [least, most]): (&'static str, f64, [f64; 2])) -> Option<OutOfRange> {
    let within = (least..=most).contains(&value);
    (!within).then_some(OutOfRange { field, value, least, most })
}

/// One after the other.
fn listed(reasons: &[impl std::fmt::Display]) -> String {
    reasons.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")
}
