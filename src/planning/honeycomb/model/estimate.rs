//! A set of parameters judged by the published model: its time, where that goes, and which limits it breaks.

use std::f64::consts::FRAC_PI_2;

use super::given::{OutOfRange, fault};
use super::limit::Limit;
use super::{Model, Parameters};
use crate::planning::tolerance::{MODEL_LIMIT, SAME_POINT_MM};

/// What the published model says of a set of parameters (Cui et al. 2020, Figs. 5 and 7).
///
/// A set that breaks `layers` or `points` has no meaningful time: the averages may be negative there.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// The set.
    pub parameters: Parameters,
    /// T in s (Eq. 11); the sum of the three below.
    pub time_s: f64,
    /// The two feeds of all points, extensions included, in s.
    pub cutting_s: f64,
    /// All motions that last as long as the blade turns, in s.
    pub turning_s: f64,
    /// All motions that last as long as the tool travels, in s: from layer to layer, and from point to point where
    /// that takes longer than the turn made on the way.
    pub moving_s: f64,
    /// N = m n: points, each cut twice (Eq. 8).
    pub points: f64,
    /// n (Eq. 8).
    pub layers: f64,
    /// m (Eq. 8).
    pub points_per_layer: f64,
    /// delta in mm (Eq. 12).
    pub scallop_mm: f64,
    /// L in use, in mm (Eq. 4).
    pub cutting_length_mm: f64,
    /// b with that L, in mm (Eq. 5).
    pub extension_mm: f64,
    /// eps; negative where the step leaves ridges as high as a layer uncut (Eq. 7).
    pub overlap_ratio: f64,
    /// Every limit that the set breaks, in the order of [`Limit::ALL`].
    pub breaches: Vec<Breach>,
}

/// A limit broken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Breach {
    /// Which.
    pub limit: Limit,
    /// What the set has: mm, rad for the swing angle, a number for layers and points.
    pub value: f64,
    /// What it may have at most, or for layers and points at least, in the same unit.
    pub bound: f64,
}

impl Model {
    /// The set that the paper's Fig. 6 arrives at from a swing angle and an overlap ratio: the cutting length is used
    /// in full, which gives the layer spacing at that angle (Eq. 4), and the overlap ratio gives the step (Eq. 7).
    /// The extension follows from the estimate (Eq. 5). Whether the other limits hold, the estimate says too.
    ///
    /// # Errors
    /// A swing angle outside (0, pi/2) or an overlap ratio outside [0, 1).
    pub fn parameters_by_overlap(&self, swing_rad: f64, overlap: f64) -> Result<Parameters, Vec<OutOfRange>> {
        let faults: Vec<_> = [
            ("swing_rad", swing_rad, [f64::MIN_POSITIVE, FRAC_PI_2.next_down()]),
            ("overlap_ratio", overlap, [0.0, 1.0_f64.next_down()]),
        ]
        .into_iter()
        .filter_map(fault)
        .collect();
        if !faults.is_empty() {
            return Err(faults);
        }
        let swing = self.swing(swing_rad);
        let layer_spacing_mm = self.depth_mm * swing.cos;
        let step_mm = (1.0 - overlap) * self.full_step_mm(layer_spacing_mm, &swing);
        Ok(Parameters { layer_spacing_mm, step_mm, swing_rad })
    }

    /// What the model says of a set of parameters, within its limits or not.
    ///
    /// # Errors
    /// Every parameter that is no spacing, step or angle at all.
    pub fn estimate(&self, parameters: &Parameters) -> Result<Estimate, Vec<OutOfRange>> {
        let Parameters { layer_spacing_mm, step_mm, swing_rad } = *parameters;
        let sizes = [SAME_POINT_MM, 1.0 / SAME_POINT_MM];
        let faults: Vec<_> = [
            ("layer_spacing_mm", layer_spacing_mm, sizes),
            ("step_mm", step_mm, sizes),
            ("swing_rad", swing_rad, [f64::MIN_POSITIVE, FRAC_PI_2.next_down()]),
        ]
        .into_iter()
        .filter_map(fault)
        .collect();
        if faults.is_empty() { Ok(self.judged(parameters)) } else { Err(faults) }
    }

    /// [`Model::estimate`] of parameters known to be positive.
    pub(in crate::planning::honeycomb) fn judged(&self, parameters: &Parameters) -> Estimate {
        let Parameters { layer_spacing_mm: spacing, step_mm: step, swing_rad } = *parameters;
        let swing = self.swing(swing_rad);
        let (layers, points_per_layer) = (self.layers(spacing), self.points_per_layer(step));
        let points = layers * points_per_layer;
        let (on_the_way, between) =
            (self.next_point_s(step, &swing), layers * self.next_layer_s(spacing, step));
        let (turning, moving) = if on_the_way > swing.turn_s { (0.0, on_the_way) } else { (on_the_way, 0.0) };
        Estimate {
            parameters: *parameters,
            time_s: self.time_s(spacing, step, &swing),
            cutting_s: points * self.feeds_s(spacing, &swing),
            turning_s: points * (swing.turn_s + turning),
            moving_s: points * moving + between,
            points,
            layers,
            points_per_layer,
            scallop_mm: self.scallop_mm(spacing, step, &swing),
            cutting_length_mm: self.cutting_length_mm(spacing, &swing),
            extension_mm: self.extension_mm(spacing, &swing),
            overlap_ratio: 1.0 - step / self.full_step_mm(spacing, &swing),
            breaches: self.breaches(parameters),
        }
    }

    fn breaches(&self, parameters: &Parameters) -> Vec<Breach> {
        let Parameters { layer_spacing_mm: spacing, step_mm: step, swing_rad } = *parameters;
        let swing = self.swing(swing_rad);
        let given = self.given();
        let measured = [
            (self.cutting_length_mm(spacing, &swing), given.max_cutting_length_mm),
            (step, self.full_step_mm(spacing, &swing)),
            (self.scallop_mm(spacing, step, &swing), given.max_scallop_mm),
            (swing_rad, given.max_swing_rad),
            (self.layers(spacing), 1.0),
            (self.points_per_layer(step), 1.0),
        ];
        let loads = self.loads(spacing, step, &swing);
        let judged = Limit::ALL.into_iter().zip(measured).zip(loads);
        judged
            .filter(|&(_, load)| load > 1.0 + MODEL_LIMIT)
            .map(|((limit, (value, bound)), _)| Breach { limit, value, bound })
            .collect()
    }
}

impl Estimate {
    /// How much less time this takes than `other`, as a share of the other's (Fig. 7: 0.403 for Table 1).
    #[must_use]
    pub fn saving_over(&self, other: &Self) -> f64 {
        1.0 - self.time_s / other.time_s
    }
}

impl std::fmt::Display for Breach {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { limit, value, bound } = *self;
        match limit {
            Limit::CuttingLength | Limit::Step | Limit::Scallop => {
                write!(f, "{limit}: {value:.4} mm of at most {bound:.4} mm")
            }
            Limit::SwingAngle => {
                write!(f, "{limit}: {:.3} deg of at most {:.3} deg", value.to_degrees(), bound.to_degrees())
            }
            Limit::Layers | Limit::Points => write!(f, "{limit}: {value:.4}, and {bound} is the least"),
        }
    }
}
