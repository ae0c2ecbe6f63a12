//! The interior point method: from a set of parameters to the best one around it.
//!
//! Unknown are the logarithms of h, s, alpha and p, the way to the next point in s; f = ln T is least where T is,
//! and no unit matters. With p as an unknown the model is smooth: p >= the turn and p >= the travel of a step take
//! the place of the larger of both (Eq. 9). All loads r(i) are to stay below 1:
//!
//! ```text
//! least f - mu * sum of ln(1 - r(i)), mu -> 0
//! ```
//!
//! by Newton steps on the primal and dual variables (Nocedal and Wright, Numerical Optimization, chapter 19), with
//! first and second derivatives by dual numbers.

use nalgebra::{Matrix4, Vector4};
use num_dual::{Dual2_64, DualNum, HyperDual64};

use crate::planning::honeycomb::model::limit::Limit;
use crate::planning::honeycomb::model::{Model, Parameters, Swing};

/// The limits of the parameters, then p >= turn and p >= travel.
pub(super) const LOADS: usize = Limit::COUNT + 2;

/// h, s, alpha and p: mm, mm, rad and s.
pub(super) type Point = [f64; 4];

/// Where the method ended.
#[derive(Debug, Clone, Copy)]
pub(super) struct Polished {
    pub at: Point,
    /// Of `ln T` by the loads: what share of the time a limit that is wider by its whole would save.
    pub multipliers: [f64; LOADS],
}

/// First and second derivatives by the logarithms of the unknowns.
#[derive(Debug, Clone, Copy)]
pub(super) struct Derivatives {
    /// Of `ln T`.
    pub gradient: Vector4<f64>,
    /// 1 - r(i).
    pub slacks: [f64; LOADS],
    /// Of r(i).
    pub load_gradients: [Vector4<f64>; LOADS],
    /// Of `ln T` plus multipliers times loads.
    pub hessian: Matrix4<f64>,
}

/// The place of alpha among the unknowns.
const ANGLE: usize = 2;

/// How far inside its limits a start is put, as a share of them.
const PULL: f64 = 0.05;

/// So many tenfold shifts make any matrix positive that holds numbers.
const MOST_SHIFTS: u32 = 40;

/// mu at the start, in the unit of ln T: the time may still differ by some hundredths.
const FIRST_BARRIER: f64 = 1e-2;

/// mu at the end: eight limits then cost 1e-10 of the time at most.
const LAST_BARRIER: f64 = 1e-11;

/// How far a step goes of the way to the nearest limit.
const TO_THE_LIMIT: f64 = 0.99;

/// More Newton steps than any problem has needed, by a factor of three.
const MOST_STEPS: usize = 100;

/// No unknown changes by more than a factor of e in a step.
const LONGEST_STEP: f64 = 1.0;

/// The best parameters around `start`, which is within the limits.
pub(super) fn polish(model: &Model, start: &Parameters) -> Polished {
    let mut at = pulled_inside(model, start);
    let mut barrier = FIRST_BARRIER;
    let mut multipliers = slacks(model, &at).map(|slack| barrier / slack);
    for _ in 0..MOST_STEPS {
        let here = derivatives(model, &at, &multipliers);
        let error = here.error(&multipliers, barrier);
        if error < 10.0 * barrier {
            if barrier <= LAST_BARRIER {
                return Polished { at, multipliers };
            }
            barrier = (0.2 * barrier).min(barrier.powf(1.5)).max(LAST_BARRIER);
        }
        let step = here.newton_step(&multipliers, barrier);
        let change: [f64; LOADS] = std::array::from_fn(|i| {
            let (slack, gradient) = (here.slacks[i], &here.load_gradients[i]);
            barrier / slack - multipliers[i] + multipliers[i] / slack * gradient.dot(&step)
        });
        let length =
            multipliers.iter().zip(&change).map(|(m, d)| if *d < 0.0 { -TO_THE_LIMIT * m / d } else { 1.0 });
        let dual = length.fold(1.0, f64::min);
        let Some(next) = line_search(model, &at, &here, &step, barrier) else {
            return Polished { at, multipliers };
        };
        at = next;
        multipliers = std::array::from_fn(|i| multipliers[i] + dual * change[i]);
    }
    Polished { at, multipliers }
}

fn pulled_inside(model: &Model, start: &Parameters) -> Point {
    let swing = model.swing(start.swing_rad.min((1.0 - PULL) * model.given().max_swing_rad));
    let used = start.step_mm / model.full_step_mm(start.layer_spacing_mm, &model.swing(start.swing_rad));
    let spacing = (1.0 - PULL) * start.layer_spacing_mm;
    let step = (1.0 - PULL) * used.min(1.0) * model.full_step_mm(spacing, &swing);
    [spacing, step, swing.angle, (1.0 + PULL) * model.next_point_s(step, &swing)]
}

fn slacks(model: &Model, at: &Point) -> [f64; LOADS] {
    let [spacing, step, angle, next_point_s] = *at;
    loads(model, spacing, step, &model.swing(angle), next_point_s).map(|load| 1.0 - load)
}

fn loads<D: DualNum<Primitive = f64> + Copy>(
    model: &Model,
    spacing: D,
    step: D,
    swing: &Swing<D>,
    next_point_s: D,
) -> [D; LOADS] {
    let [a, b, c, d, e, f] = model.loads(spacing, step, swing);
    [a, b, c, d, e, f, swing.turn_s / next_point_s, model.step_travel_s(step) / next_point_s]
}

/// The first point along `step` that lies within the limits and lowers the barrier function.
fn line_search(
    model: &Model,
    at: &Point,
    here: &Derivatives,
    step: &Vector4<f64>,
    barrier: f64,
) -> Option<Point> {
    let value = |point: &Point, slacks: &[f64; LOADS]| {
        let [spacing, step, angle, next_point_s] = *point;
        let time_s = model.time_with_next_point_s(spacing, step, &model.swing(angle), next_point_s);
        time_s.ln() - barrier * slacks.iter().map(|slack| slack.ln()).sum::<f64>()
    };
    let start = value(at, &here.slacks);
    let slope = here.barrier_gradient(barrier).dot(step);
    let longest = step.amax();
    let mut length = (LONGEST_STEP / longest).min(1.0);
    for (slack, gradient) in here.slacks.iter().zip(&here.load_gradients) {
        let loss = gradient.dot(step);
        if loss > 0.0 {
            length = length.min(TO_THE_LIMIT * slack / loss);
        }
    }
    for _ in 0..40 {
        let point: Point = std::array::from_fn(|i| at[i] * (length * step[i]).exp());
        let next = slacks(model, &point);
        let inside =
            next.iter().zip(&here.slacks).all(|(next, slack)| *next > (1.0 - TO_THE_LIMIT) * 0.1 * slack);
        if inside && value(&point, &next) <= start + 1e-4 * length * slope + 1e-13 * (1.0 + start.abs()) {
            return Some(point);
        }
        length *= 0.5;
    }
    None
}

impl Derivatives {
    fn barrier_gradient(&self, barrier: f64) -> Vector4<f64> {
        let pairs = self.slacks.iter().zip(&self.load_gradients);
        pairs.fold(self.gradient, |sum, (slack, gradient)| sum + gradient * (barrier / slack))
    }

    fn newton_step(&self, multipliers: &[f64; LOADS], barrier: f64) -> Vector4<f64> {
        let mut matrix = self.hessian;
        for ((gradient, multiplier), slack) in self.load_gradients.iter().zip(multipliers).zip(&self.slacks) {
            matrix += gradient * gradient.transpose() * (multiplier / slack);
        }
        let right = -self.barrier_gradient(barrier);
        let mut shift = 0.0;
        for _ in 0..MOST_SHIFTS {
            if let Some(factors) = (matrix + Matrix4::identity() * shift).cholesky() {
                return factors.solve(&right);
            }
            shift = (10.0_f64 * shift).max(1e-4 * matrix.amax());
        }
        // A matrix that no shift makes positive is none: the line search then ends where it is.
        Vector4::zeros()
    }

    /// How far the conditions of a point on the central path are from being met.
    pub fn error(&self, multipliers: &[f64; LOADS], barrier: f64) -> f64 {
        let mut sum = self.gradient;
        let mut error = 0.0_f64;
        for ((gradient, multiplier), slack) in self.load_gradients.iter().zip(multipliers).zip(&self.slacks) {
            sum += gradient * *multiplier;
            error = error.max((multiplier * slack - barrier).abs());
        }
        error.max(sum.amax())
    }
}

/// All first and second derivatives, by one pass of hyper-dual numbers for each pair of unknowns.
pub(super) fn derivatives(model: &Model, at: &Point, multipliers: &[f64; LOADS]) -> Derivatives {
    // The swing angle's functions are worked out once, and lifted into every pass.
    let angle = at[ANGLE];
    let swing = model.swing(Dual2_64::new(angle, angle, angle));
    let mut result = Derivatives {
        gradient: Vector4::zeros(),
        slacks: [0.0; LOADS],
        load_gradients: [Vector4::zeros(); LOADS],
        hessian: Matrix4::zeros(),
    };
    for i in 0..4 {
        for j in i..4 {
            let unknown = |k: usize| lifted(Dual2_64::new(at[k], at[k], at[k]), i == k, j == k);
            let lift = |x: Dual2_64| lifted(x, i == ANGLE, j == ANGLE);
            let swing = Swing {
                angle: lift(swing.angle),
                tan: lift(swing.tan),
                cos: lift(swing.cos),
                turn_s: lift(swing.turn_s),
            };
            let [spacing, step, next_point_s] = [unknown(0), unknown(1), unknown(3)];
            let time = model.time_with_next_point_s(spacing, step, &swing, next_point_s).ln();
            let loads = loads(model, spacing, step, &swing, next_point_s);
            let second = loads.iter().zip(multipliers).map(|(load, multiplier)| load.eps1eps2 * multiplier);
            let entry = time.eps1eps2 + second.sum::<f64>();
            result.hessian[(i, j)] = entry;
            result.hessian[(j, i)] = entry;
            if i == j {
                result.gradient[i] = time.eps1;
                for (gradient, load) in result.load_gradients.iter_mut().zip(&loads) {
                    gradient[i] = load.eps1;
                }
                result.slacks = loads.map(|load| 1.0 - load.re);
            }
        }
    }
    result
}

/// A function of one unknown as a function of two directions.
fn lifted(x: Dual2_64, first: bool, second: bool) -> HyperDual64 {
    let when = |is: bool, value: f64| if is { value } else { 0.0 };
    HyperDual64::new(x.re, when(first, x.v1), when(second, x.v1), when(first && second, x.v2))
}
