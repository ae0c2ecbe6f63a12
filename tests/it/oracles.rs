//! The published model for ripopt, an interior-point solver that shares nothing with ours but the equations.

use bladeplan::planning::honeycomb::model::{Model, Swing};
use num_dual::{Dual64, DualNum, HyperDual64};
use ripopt::{NlpProblem, SolveResult, SolverOptions};

/// h, s and alpha in mm and rad.
pub type Point = [f64; 3];

/// The published model as ripopt wants it: least time within three constraints and the bounds of the unknowns.
pub struct Problem<'a> {
    pub model: &'a Model,
    pub start: Point,
}

impl Problem<'_> {
    pub fn time<D: DualNum<Primitive = f64> + Copy>(&self, [h, s, alpha]: [D; 3]) -> D {
        self.model.time_s(h, s, &self.model.swing(alpha))
    }

    /// Each at most 0: cutting length, step, scallop.
    pub fn limits<D: DualNum<Primitive = f64> + Copy>(&self, [h, s, alpha]: [D; 3]) -> [D; 3] {
        let swing: Swing<D> = self.model.swing(alpha);
        [
            h - swing.cos * self.model.depth_mm,
            s - self.model.full_step_mm(h, &swing),
            self.model.scallop_mm(h, s, &swing) - self.model.given().max_scallop_mm,
        ]
    }

    fn lagrangian<D: DualNum<Primitive = f64> + Copy>(&self, x: [D; 3], factor: f64, lambda: &[f64]) -> D {
        let constraints = self.limits(x);
        (0..3).fold(self.time(x) * factor, |sum, i| sum + constraints[i] * lambda[i])
    }
}

fn first(x: &[f64], by: usize) -> [Dual64; 3] {
    std::array::from_fn(|i| Dual64::new(x[i], if i == by { 1.0 } else { 0.0 }))
}

fn second(x: &[f64], by: (usize, usize)) -> [HyperDual64; 3] {
    let when = |is: bool| if is { 1.0 } else { 0.0 };
    std::array::from_fn(|i| HyperDual64::new(x[i], when(i == by.0), when(i == by.1), 0.0))
}

impl NlpProblem for Problem<'_> {
    fn num_variables(&self) -> usize {
        3
    }

    fn num_constraints(&self) -> usize {
        3
    }

    fn bounds(&self, low: &mut [f64], high: &mut [f64]) {
        low.fill(1e-6);
        high.copy_from_slice(&[
            self.model.max_layer_spacing_mm,
            self.model.max_step_mm,
            self.model.given().max_swing_rad,
        ]);
    }

    fn constraint_bounds(&self, low: &mut [f64], high: &mut [f64]) {
        low.fill(f64::NEG_INFINITY);
        high.fill(0.0);
    }

    fn initial_point(&self, x: &mut [f64]) {
        x.copy_from_slice(&self.start);
    }

    fn objective(&self, x: &[f64], _: bool, value: &mut f64) -> bool {
        *value = self.time([x[0], x[1], x[2]]);
        value.is_finite()
    }

    fn gradient(&self, x: &[f64], _: bool, gradient: &mut [f64]) -> bool {
        (0..3).for_each(|i| gradient[i] = self.time(first(x, i)).eps);
        true
    }

    fn constraints(&self, x: &[f64], _: bool, values: &mut [f64]) -> bool {
        values.copy_from_slice(&self.limits([x[0], x[1], x[2]]));
        true
    }

    fn jacobian_structure(&self) -> (Vec<usize>, Vec<usize>) {
        (vec![0, 0, 0, 1, 1, 1, 2, 2, 2], vec![0, 1, 2, 0, 1, 2, 0, 1, 2])
    }

    fn jacobian_values(&self, x: &[f64], _: bool, values: &mut [f64]) -> bool {
        for by in 0..3 {
            let constraints = self.limits(first(x, by));
            (0..3).for_each(|i| values[3 * i + by] = constraints[i].eps);
        }
        true
    }

    fn hessian_structure(&self) -> (Vec<usize>, Vec<usize>) {
        (vec![0, 1, 1, 2, 2, 2], vec![0, 0, 1, 0, 1, 2])
    }

    fn hessian_values(&self, x: &[f64], _: bool, factor: f64, lambda: &[f64], values: &mut [f64]) -> bool {
        let pairs = [(0, 0), (1, 0), (1, 1), (2, 0), (2, 1), (2, 2)];
        for (value, by) in values.iter_mut().zip(pairs) {
            *value = self.lagrangian(second(x, by), factor, lambda).eps1eps2;
        }
        true
    }
}

/// What ripopt finds from a start; `None` where it does not come to an end within the limits.
pub fn ripopt(model: &Model, start: Point) -> Option<Point> {
    let options = SolverOptions { print_level: 0, ..SolverOptions::default() };
    let SolveResult { x, .. } = ripopt::solve(&Problem { model, start }, &options);
    within(model, [x[0], x[1], x[2]])
}

/// A point if it keeps all limits.
pub fn within(model: &Model, point: Point) -> Option<Point> {
    let [layer_spacing_mm, step_mm, swing_rad] = point;
    let parameters =
        bladeplan::planning::honeycomb::model::Parameters { layer_spacing_mm, step_mm, swing_rad };
    let kept = model.estimate(&parameters).is_ok_and(|estimate| estimate.breaches.is_empty());
    kept.then_some(point)
}
