//! The time along a line of the plane of (alpha, kappa): at one kappa, or at one alpha.
//!
//! Along a line the curvature is cheap to bound, and a function that is convex there lies above its tangents. A
//! tangent at an optimum is level, so that a stretch around it is proved in one go, however long; bounds by slopes
//! alone need it cut into hundreds of pieces.

use super::jet::Jet;
use super::patch::{Edge, Leg, Piece};
use super::span::Span;
use crate::planning::honeycomb::lattice_kind::Lattice;
use crate::planning::honeycomb::model::Model;

/// A stretch of a line: what the model wants to know there, as functions of the place along it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Line {
    tan: Jet,
    cos: Jet,
    /// 1 / cos(alpha).
    sec: Jet,
    turn_s: Jet,
    /// tan(kappa alpha) = s / 2h.
    ratio: Jet,
}

impl Line {
    /// From one alpha to another at one kappa; the place along it is alpha in rad.
    pub fn along_angle(low: &Edge, high: &Edge, share: f64) -> Self {
        let tan = Span::new(low.swing.tan, high.swing.tan);
        let cos = Span::new(high.swing.cos, low.swing.cos);
        let sec = cos.recip();
        let ratio = Span::new(low.ratio(share), high.ratio(share));
        let tan = tangent(tan, 1.0);
        let sin = tan.value * cos;
        Self {
            tan,
            cos: Jet::new(cos, -sin, -cos),
            sec: Jet::new(sec, sec * tan.value, sec * (tan.value.square() * 2.0 + 1.0)),
            turn_s: Jet::new(
                Span::new(low.swing.turn_s, high.swing.turn_s),
                Span::new(low.turn_slope, high.turn_slope),
                Span::new(high.turn_curvature, low.turn_curvature),
            ),
            ratio: if share == 1.0 { tan } else { tangent(ratio, share) },
        }
    }

    /// From one kappa to another at one alpha; the place along it is kappa.
    pub fn along_share(edge: &Edge, share: Span) -> Self {
        Self {
            tan: Jet::at(edge.swing.tan),
            cos: Jet::at(edge.swing.cos),
            sec: Jet::at(edge.swing.cos.recip()),
            turn_s: Jet::at(edge.swing.turn_s),
            ratio: tangent(Span::new(edge.ratio(share.low), edge.ratio(share.high)), edge.swing.angle),
        }
    }

    /// T(piece, leg) in s. `None` where the piece leaves the domain in which T falls with h: less than no layers.
    pub fn time_s(&self, model: &Model, (piece, leg): (Piece, Leg)) -> Option<Jet> {
        let given = model.given();
        let (spacing, half_step) = self.sizes(model, piece);
        let layers = spacing.recip() * model.cut_height_mm + -0.5;
        let points = half_step.recip() * (0.5 * given.blank_width_mm) + 0.5;
        let per_mm = given.travel_speed_mm_s.recip();
        // With the cutting length used in full its extension is the same at every alpha.
        let edge_mm =
            if piece == Piece::CuttingLength { Jet::at(model.depth_mm) } else { spacing * self.sec };
        let feeds_s = edge_mm * (model.extension_factor * 4.0 / given.cutting_speed_mm_s)
            + 2.0 * given.blank_length_mm / given.cutting_speed_mm_s;
        let turned = match leg {
            Leg::Turn => self.turn_s * 2.0,
            Leg::Travel => self.turn_s + half_step * (2.0 * per_mm),
        };
        let most = model.next_layer_s(0.0, 0.0);
        let sizes = spacing + half_step;
        let next_layer = Jet::new(
            Span::at(most) - sizes.value * per_mm,
            -(sizes.slope * per_mm),
            -(sizes.curvature * per_mm),
        );
        let layer = points * (feeds_s + turned) + next_layer;
        (layers.value.low >= 0.0 && layer.value.low >= 0.0).then(|| layers * layer)
    }

    /// The layer spacing and half of the step, in mm.
    fn sizes(&self, model: &Model, piece: Piece) -> (Jet, Jet) {
        match piece {
            Piece::CuttingLength => {
                let spacing = self.cos * model.depth_mm;
                (spacing, spacing * self.ratio)
            }
            Piece::Layers => (Jet::at(model.max_layer_spacing_mm), self.ratio * model.max_layer_spacing_mm),
            Piece::Points => {
                let half_step = 0.5 * model.max_step_mm;
                (self.ratio.recip() * half_step, Jet::at(half_step))
            }
            Piece::Scallop => self.scallop(model),
        }
    }

    /// Eq. 12 solved for h, where s = 2 h tan(kappa alpha).
    fn scallop(&self, model: &Model) -> (Jet, Jet) {
        let down = self.ratio * self.tan.recip() + 1.0;
        let height = match model.given().lattice {
            Lattice::Interlaced => down,
            Lattice::Orthogonal | Lattice::Free => (self.ratio.square() + down.square()).sqrt(),
        };
        let spacing = height.recip() * model.given().max_scallop_mm;
        (spacing, spacing * self.ratio)
    }
}

/// tan(factor x) where its values are known: slope factor (1 + tan^2), curvature 2 factor^2 tan (1 + tan^2).
fn tangent(value: Span, factor: f64) -> Jet {
    let slope = value.square() + 1.0;
    Jet::new(value, slope * factor, value * slope * (2.0 * factor * factor))
}

#[cfg(test)]
mod tests {
    use num_dual::{Dual2_64, DualNum};
    use proptest::prelude::*;

    use super::*;
    use crate::planning::honeycomb::model::Swing;
    use crate::planning::honeycomb::model::given::Given;

    fn model(lattice: Lattice) -> Model {
        let given = Given {
            blank_width_mm: 85.0,
            blank_length_mm: 50.0,
            machined_area_mm2: 3137.0,
            safety_distance_mm: 10.0,
            rake_rad: 1.1,
            half_apex_rad: 0.13,
            cutting_speed_mm_s: 200.0,
            travel_speed_mm_s: 150.0,
            angular_speed_rad_s: 1.6,
            max_scallop_mm: 9.0,
            max_cutting_length_mm: 10.0,
            max_swing_rad: 1.2,
            lattice,
        };
        Model::new(given).unwrap()
    }

    /// T(piece, leg) with its exact derivatives: the model's own text on dual numbers.
    fn time_s(
        model: &Model,
        (piece, leg): (Piece, Leg),
        swing: &Swing<Dual2_64>,
        ratio: Dual2_64,
    ) -> Dual2_64 {
        let down = ratio / swing.tan + 1.0;
        let height = match model.given().lattice {
            Lattice::Interlaced => down,
            Lattice::Orthogonal | Lattice::Free => (ratio * ratio + down * down).sqrt(),
        };
        let spacing = match piece {
            Piece::CuttingLength => swing.cos * model.depth_mm,
            Piece::Layers => Dual2_64::from_re(model.max_layer_spacing_mm),
            Piece::Points => ratio.recip() * (0.5 * model.max_step_mm),
            Piece::Scallop => height.recip() * model.given().max_scallop_mm,
        };
        let step = spacing * ratio * 2.0;
        let next_point_s = match leg {
            Leg::Turn => swing.turn_s,
            Leg::Travel => model.step_travel_s(step),
        };
        model.time_with_next_point_s(spacing, step, swing, next_point_s)
    }

    fn holds(span: Span, value: f64) -> bool {
        let slack = 1e-10 * (1.0 + value.abs() + span.magnitude());
        span.low <= value + slack && value <= span.high + slack
    }

    fn has(jet: Option<Jet>, number: Dual2_64) -> bool {
        jet.is_none_or(|jet| {
            holds(jet.value, number.re) && holds(jet.slope, number.v1) && holds(jet.curvature, number.v2)
        })
    }

    proptest! {
        #[test]
        fn every_exact_derivative_lies_within(
            lattice in 0..3_usize, low in 0.05..1.1_f64, width in 0.0..0.1_f64, share in 0.2..0.9_f64,
            at in 0.0..=1.0_f64, edge in any::<bool>()
        ) {
            let model = model([Lattice::Orthogonal, Lattice::Interlaced, Lattice::Free][lattice]);
            let share = if edge { 1.0 } else { share };
            let ends = [low, low + width].map(|angle| Edge::at(&model, angle));
            let angle = Dual2_64::from_re(low + at * width);
            let along = Line::along_angle(&ends[0], &ends[1], share);
            let kappas = Span::new(share - width, share);
            let across = Line::along_share(&ends[0], kappas);
            for piece in Piece::ALL {
                for which in [Leg::Turn, Leg::Travel].map(|leg| (piece, leg)) {
                    let alpha = angle.derivative();
                    let exact = time_s(&model, which, &model.swing(alpha), (alpha * share).tan());
                    prop_assert!(has(along.time_s(&model, which), exact), "{which:?} along alpha: {exact:?}");
                    let kappa = Dual2_64::from_re(kappas.low + at * width).derivative();
                    let swing = model.swing(Dual2_64::from_re(low));
                    let exact = time_s(&model, which, &swing, (kappa * low).tan());
                    prop_assert!(has(across.time_s(&model, which), exact), "{which:?} along kappa: {exact:?}");
                }
            }
        }
    }

    #[test]
    fn around_the_optimum_of_table_1_the_time_is_seen_to_be_convex() {
        let model = model(Lattice::Orthogonal);
        let ends = [0.57, 0.62].map(|angle| Edge::at(&model, angle));
        let jet =
            Line::along_angle(&ends[0], &ends[1], 1.0).time_s(&model, (Piece::CuttingLength, Leg::Turn));
        assert!(jet.unwrap().curvature.low > 0.0, "{jet:?}");
    }
}
