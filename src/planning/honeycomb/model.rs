//! The published model of V-shaped cutting: Cui et al. 2020, Eqs. 1 to 14, as domain.md B2 reads them.
//!
//! Plain numbers in mm, rad, s, mm/s and rad/s. The equations are generic over the scalars of `num_dual`, so
//! that one text gives values and exact derivatives.
//!
//! k is 2/3, 1 or 1/2 by lattice. The paper contradicts itself about n and m: here n are the layers and m the
//! points in a layer, and T = N t1 + n t2, which alone gives its Table 1 (domain.md B2).

use num_dual::DualNum;

use self::given::{Given, Refusal};
use self::limit::Limit;
use super::lattice_kind::Lattice;

pub mod estimate;
pub mod given;
pub mod limit;

/// A set of path parameters: what the paper calls h, s and alpha.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameters<D = f64> {
    /// h, from layer to layer, in mm.
    pub layer_spacing_mm: D,
    /// s, from tip to tip within a layer, in mm.
    pub step_mm: D,
    /// alpha, of the blade from the vertical, in rad.
    pub swing_rad: D,
}

/// A swing angle with all that the equations want of it, so that it is worked out once.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Swing<D = f64> {
    /// alpha in rad.
    pub angle: D,
    /// tan(alpha).
    pub tan: D,
    /// cos(alpha).
    pub cos: D,
    /// How long the change between the two postures takes, in s: 2 acos(cos(alpha) sin(theta)) / omega.
    pub turn_s: D,
}

/// The model of one job: what is given, checked, and the constants that follow from it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Model {
    given: Given,
    /// k L_max sin(theta - beta) in mm: the layer spacing that the cutting length allows at alpha = 0 (Eq. 4).
    pub depth_mm: f64,
    /// H_C = A_C / W in mm: how much is taken off on average.
    pub cut_height_mm: f64,
    /// The largest layer spacing that leaves one layer, in mm: n >= 1.
    pub max_layer_spacing_mm: f64,
    /// The largest step that leaves one point in a layer, in mm: m >= 1.
    pub max_step_mm: f64,
    /// cot(theta - beta) / k: b cos(alpha) / h.
    pub extension_factor: f64,
}

/// Averages count half a layer less and half a point more than whole ones (Cui et al. 2020, before Eq. 8).
const HALF: f64 = 0.5;

impl Model {
    /// Checks what is given.
    ///
    /// # Errors
    /// Every number outside its range, or every limit that excludes all parameters.
    pub fn new(given: Given) -> Result<Self, Refusal> {
        given.check()?;
        let edge_angle = given.rake_rad - given.half_apex_rad;
        let factor = given.lattice.depth_factor();
        let cut_height_mm = given.machined_area_mm2 / given.blank_width_mm;
        Ok(Self {
            given,
            depth_mm: factor * given.max_cutting_length_mm * edge_angle.sin(),
            cut_height_mm,
            max_layer_spacing_mm: cut_height_mm / (1.0 + HALF),
            max_step_mm: given.blank_width_mm / (1.0 - HALF),
            extension_factor: edge_angle.tan().recip() / factor,
        })
    }

    /// What it was made of.
    #[must_use]
    pub fn given(&self) -> &Given {
        &self.given
    }

    /// All that the equations want of a swing angle in (0, pi/2).
    ///
    /// The angle of the posture change, acos(cos(alpha) sin(theta)), is taken from both its cosine and its sine:
    /// where it is small, a cosine alone has lost half of its digits.
    #[must_use]
    pub fn swing<D: DualNum<Primitive = f64> + Copy>(&self, angle: D) -> Swing<D> {
        let (sin, cos) = angle.sin_cos();
        let (rake_sin, rake_cos) = self.given.rake_rad.sin_cos();
        let across = (sin * sin + cos * cos * (rake_cos * rake_cos)).sqrt();
        let turn = across.atan2(cos * rake_sin);
        Swing { angle, tan: sin / cos, cos, turn_s: turn * (2.0 / self.given.angular_speed_rad_s) }
    }

    /// d in mm: what a part of the edge of `length_mm` reaches in the section (Eq. 2).
    #[must_use]
    pub fn reach_mm(&self, length_mm: f64) -> f64 {
        length_mm * (self.given.rake_rad - self.given.half_apex_rad).sin()
    }

    /// Q in mm2: the section of one chip, k^2 d^2 sin(2 alpha) (Eqs. 1 and 3, where k is 2/3). It is the largest
    /// layer spacing times the step without overlap.
    #[must_use]
    pub fn chip_area_mm2(&self, length_mm: f64, swing_rad: f64) -> f64 {
        let depth = self.given.lattice.depth_factor() * self.reach_mm(length_mm);
        depth * depth * (2.0 * swing_rad).sin()
    }

    /// L in mm: the cutting length that a layer spacing uses (Eq. 4 the other way round).
    #[must_use]
    pub fn cutting_length_mm<D: DualNum<Primitive = f64> + Copy>(&self, spacing: D, swing: &Swing<D>) -> D {
        spacing / swing.cos * (self.given.max_cutting_length_mm / self.depth_mm)
    }

    /// b in mm, with the L in use: h cot(theta - beta) / (k cos(alpha)) (Eqs. 4, 5 and 9).
    #[must_use]
    pub fn extension_mm<D: DualNum<Primitive = f64> + Copy>(&self, spacing: D, swing: &Swing<D>) -> D {
        spacing / swing.cos * self.extension_factor
    }

    /// The step without overlap, in mm: 2 h tan(alpha) (Eq. 6).
    #[must_use]
    pub fn full_step_mm<D: DualNum<Primitive = f64> + Copy>(&self, spacing: D, swing: &Swing<D>) -> D {
        spacing * swing.tan * 2.0
    }

    /// n, the mean number of layers: A_C / (W h) - 0.5 (Eq. 8).
    #[must_use]
    pub fn layers<D: DualNum<Primitive = f64> + Copy>(&self, spacing: D) -> D {
        spacing.recip() * self.cut_height_mm - HALF
    }

    /// m, the mean number of points in a layer: W / s + 0.5 (Eq. 8).
    #[must_use]
    pub fn points_per_layer<D: DualNum<Primitive = f64> + Copy>(&self, step: D) -> D {
        step.recip() * self.given.blank_width_mm + HALF
    }

    /// How long the two feeds of a point take, in s: (2 D + 4 b) / v1, the first part of t1 (Eq. 9).
    #[must_use]
    pub fn feeds_s<D: DualNum<Primitive = f64> + Copy>(&self, spacing: D, swing: &Swing<D>) -> D {
        (self.extension_mm(spacing, swing) * 4.0 + 2.0 * self.given.blank_length_mm)
            / self.given.cutting_speed_mm_s
    }

    /// How long the travel of one step takes, in s: s / v2 (Eq. 9).
    #[must_use]
    pub fn step_travel_s<D: DualNum<Primitive = f64> + Copy>(&self, step: D) -> D {
        step / self.given.travel_speed_mm_s
    }

    /// How long the way to the next point takes, in s: the longer of turning back and travelling, the last part
    /// of t1 (Eq. 9).
    #[must_use]
    pub fn next_point_s<D: DualNum<Primitive = f64> + Copy>(&self, step: D, swing: &Swing<D>) -> D {
        let travel = self.step_travel_s(step);
        if travel.re() > swing.turn_s.re() { travel } else { swing.turn_s }
    }

    /// t2 in s: the move between layers, up, across and down (Eq. 10).
    #[must_use]
    pub fn next_layer_s<D: DualNum<Primitive = f64> + Copy>(&self, spacing: D, step: D) -> D {
        let given = &self.given;
        let fixed = 2.0 * given.safety_distance_mm + 2.0 * self.cut_height_mm + given.blank_width_mm;
        (-spacing - step * HALF + fixed) / given.travel_speed_mm_s
    }

    /// T in s (Eq. 11, n the layers), where the way to the next point takes `next_point_s`.
    #[must_use]
    pub fn time_with_next_point_s<D: DualNum<Primitive = f64> + Copy>(
        &self,
        spacing: D,
        step: D,
        swing: &Swing<D>,
        next_point_s: D,
    ) -> D {
        let point = self.feeds_s(spacing, swing) + swing.turn_s + next_point_s;
        let layer = self.points_per_layer(step) * point + self.next_layer_s(spacing, step);
        self.layers(spacing) * layer
    }

    /// T in s (Eq. 11, n the layers): N t1 + n t2.
    #[must_use]
    pub fn time_s<D: DualNum<Primitive = f64> + Copy>(&self, spacing: D, step: D, swing: &Swing<D>) -> D {
        self.time_with_next_point_s(spacing, step, swing, self.next_point_s(step, swing))
    }

    /// delta in mm: the scallop height of the worst case (Eq. 12).
    ///
    /// With (2 - eps) h = h + s / (2 tan(alpha)) it is the distance from the ridge between two tips to the nearest
    /// tip of the next layer: half a step to the side and (2 - eps) h down; interlaced, straight down.
    #[must_use]
    pub fn scallop_mm<D: DualNum<Primitive = f64> + Copy>(&self, spacing: D, step: D, swing: &Swing<D>) -> D {
        let aside = step * 0.5;
        let down = spacing + aside / swing.tan;
        match self.given.lattice {
            Lattice::Interlaced => down,
            Lattice::Orthogonal | Lattice::Free => (aside * aside + down * down).sqrt(),
        }
    }

    /// How much of each limit is used, in the order of [`Limit::ALL`]: up to 1 is within (Eqs. 13 and 14; n >= 1
    /// and m >= 1 as the spacing and the step that they allow).
    #[must_use]
    pub fn loads<D: DualNum<Primitive = f64> + Copy>(
        &self,
        spacing: D,
        step: D,
        swing: &Swing<D>,
    ) -> [D; Limit::COUNT] {
        [
            spacing / swing.cos / self.depth_mm,
            step / self.full_step_mm(spacing, swing),
            self.scallop_mm(spacing, step, swing) / self.given.max_scallop_mm,
            swing.angle / self.given.max_swing_rad,
            spacing / self.max_layer_spacing_mm,
            step / self.max_step_mm,
        ]
    }
}
