//! The interior point method: from a set of parameters to the best one around it.
//!
//! Unknown are the logarithms of h, s, alpha and p, the way to the next point in s; f = ln T is least where T is,
//! and no unit matters. With p as an unknown the model is smooth: p >= the turn and p >= the travel of a step take
//! the place of the larger of both (Eq. 9). All loads r(i) are to stay below 1; each has a slack q(i) of its own, which
//! keeps its digits where 1 - r(i) would lose them:
//!
//! ```text
//! least f - mu * sum of ln q(i) with r(i) + q(i) = 1, mu -> 0
//! ```
//!
//! by Newton steps on the primal and dual variables with a line search on the penalty function (Nocedal and Wright,
//! Numerical Optimization, chapter 19), with first and second derivatives by dual numbers.

use nalgebra::{Matrix4, Vector4};
use num_dual::{Dual2_64, DualNum, HyperDual64};

use crate::planning::honeycomb::model::limit::Limit;
use crate::planning::honeycomb::model::{Model, Parameters, Swing};
use crate::planning::tolerance::OPTIMUM_GAP;

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
    /// Whether the method has come to its end there.
    settled: bool,
}

/// First and second derivatives by the logarithms of the unknowns.
#[derive(Debug, Clone, Copy)]
pub(super) struct Derivatives {
    /// T in s.
    pub time_s: f64,
    /// Of `ln T`.
    pub gradient: Vector4<f64>,
    /// r(i).
    pub loads: [f64; LOADS],
    /// Of r(i).
    pub load_gradients: [Vector4<f64>; LOADS],
    /// Of `ln T` plus multipliers times loads.
    pub hessian: Matrix4<f64>,
}

/// The place of alpha among the unknowns.
const ANGLE: usize = 2;

/// How far inside its limits a start is put, as a share of them: at first, and where that has not served.
const PULLS: [f64; 3] = [0.05, 1e-3, 1e-5];

/// mu at the start, in the unit of ln T, over the pull: the time may still differ by some hundredths of it.
const BARRIER_OF_PULL: f64 = 0.2;

/// So many tenfold shifts make any matrix positive that holds numbers.
const MOST_SHIFTS: u32 = 40;

/// mu at the end: eight limits then cost 1e-10 of the time at most.
const LAST_BARRIER: f64 = 1e-11;

/// How far a step goes of the way to the nearest limit.
const TO_THE_LIMIT: f64 = 0.99;

/// More Newton steps than any problem has needed, by a factor of three.
const MOST_STEPS: usize = 100;

/// A multiplier is kept within this factor of the central path's, mu / q: far off it the method no longer converges.
const OFF_CENTRE: f64 = 1e5;

/// A step is halved so many times at the most.
const MOST_HALVINGS: usize = 40;

/// What the penalty function loses to rounding, as a share of it.
const ROUNDING: f64 = 1e-13;

/// No unknown changes by more than a factor of e in a step.
const LONGEST_STEP: f64 = 1.0;

/// The best parameters around `start`, which is within the limits, and not longer than it.
pub(super) fn polish(model: &Model, start: &Parameters) -> Polished {
    let Parameters { layer_spacing_mm, step_mm, swing_rad } = *start;
    let start_s = model.time_s(layer_spacing_mm, step_mm, &model.swing(swing_rad));
    let mut best = polish_from(model, start, PULLS[0]);
    for pull in &PULLS[1..] {
        // A start pulled far inside can end at another optimum, which is a worse one then.
        if best.settled && time_at(model, &best.at) <= start_s * (1.0 + OPTIMUM_GAP) {
            return best;
        }
        best = polish_from(model, start, *pull);
    }
    best
}

fn polish_from(model: &Model, start: &Parameters, pull: f64) -> Polished {
    let mut barrier = BARRIER_OF_PULL * pull;
    let mut here = Iterate::begin(model, pulled_inside(model, start, pull), barrier);
    for _ in 0..MOST_STEPS {
        let derivatives = derivatives(model, &here.at, &here.multipliers);
        let missing = here.missing(&derivatives.loads);
        while derivatives.error(&here, &missing, barrier) < 10.0 * barrier {
            if barrier <= LAST_BARRIER {
                return Polished { settled: true, ..here.polished() };
            }
            barrier = (0.2 * barrier).min(barrier.powf(1.5)).max(LAST_BARRIER);
        }
        let step = Step::newton(&derivatives, &here, &missing, barrier);
        match here.after(model, &derivatives, &step, barrier) {
            Some(next) => here = next,
            None => break,
        }
    }
    here.polished()
}

/// Where the method stands.
struct Iterate {
    at: Point,
    /// q(i), above 0.
    slacks: [f64; LOADS],
    /// Above 0.
    multipliers: [f64; LOADS],
}

/// A step of all unknowns.
struct Step {
    /// Of the logarithms of h, s, alpha and p.
    at: Vector4<f64>,
    slacks: [f64; LOADS],
    multipliers: [f64; LOADS],
    /// r(i) + q(i) - 1 before it, which a full step mends to first order.
    missing: [f64; LOADS],
}

impl Iterate {
    fn begin(model: &Model, at: Point, barrier: f64) -> Self {
        let slacks = loads_at(model, &at).map(|load| 1.0 - load);
        Self { at, slacks, multipliers: slacks.map(|slack| barrier / slack) }
    }

    fn polished(&self) -> Polished {
        Polished { at: self.at, multipliers: self.multipliers, settled: false }
    }

    fn missing(&self, loads: &[f64; LOADS]) -> [f64; LOADS] {
        std::array::from_fn(|i| loads[i] + self.slacks[i] - 1.0)
    }

    /// The first point along a step that lowers the penalty function, if any does.
    fn after(&self, model: &Model, here: &Derivatives, step: &Step, barrier: f64) -> Option<Self> {
        let merit = Merit { barrier, penalty: step.penalty(&self.multipliers) };
        let start = merit.value(here.time_s, &self.slacks, &step.missing);
        let slope = merit.slope(here, self, step);
        let enough = |length: f64| start + 1e-4 * length * slope + ROUNDING * (1.0 + start.abs());
        let mut length = step.longest(&self.slacks);
        for halving in 0..MOST_HALVINGS {
            let (value, next) = self.tried(model, step, length, &merit);
            if value <= enough(length) {
                return Some(next);
            }
            if halving == 0 {
                // A limit that is curved holds a full step back however near the optimum is (Maratos); a step that
                // counts in what the first one missed does not leave the limit.
                let missing = next.missing(&loads_at(model, &next.at));
                let missing = std::array::from_fn(|i| length * step.missing[i] + missing[i]);
                let corrected = Step::newton(here, self, &missing, barrier);
                let (value, next) = self.tried(model, &corrected, corrected.longest(&self.slacks), &merit);
                if value <= enough(length) {
                    return Some(next);
                }
            }
            length *= 0.5;
        }
        None
    }

    /// The point at `length` of a step, and its penalty function.
    fn tried(&self, model: &Model, step: &Step, length: f64, merit: &Merit) -> (f64, Self) {
        let at: Point = std::array::from_fn(|i| self.at[i] * (length * step.at[i]).exp());
        let loads = loads_at(model, &at);
        // A slack below what the load leaves is raised to it: both terms of the penalty function fall.
        let slacks: [f64; LOADS] =
            std::array::from_fn(|i| (self.slacks[i] + length * step.slacks[i]).max(1.0 - loads[i]));
        let missing = std::array::from_fn(|i| loads[i] + slacks[i] - 1.0);
        let dual = share_to_zero(&self.multipliers, &step.multipliers);
        let multipliers = std::array::from_fn(|i| {
            let central = merit.barrier / slacks[i];
            (self.multipliers[i] + dual * step.multipliers[i])
                .clamp(central / OFF_CENTRE, central * OFF_CENTRE)
        });
        // Beyond the largest swing, and so perhaps beyond 90 degrees, there is no model.
        let inside = at[ANGLE] < model.given().max_swing_rad;
        let value = if inside { merit.value(time_at(model, &at), &slacks, &missing) } else { f64::INFINITY };
        (value, Self { at, slacks, multipliers })
    }
}

/// The penalty function: the barrier function, and what it costs that loads and slacks miss 1.
struct Merit {
    barrier: f64,
    penalty: f64,
}

impl Merit {
    fn value(&self, time_s: f64, slacks: &[f64; LOADS], missing: &[f64; LOADS]) -> f64 {
        // One logarithm of a product is cheaper than a sum of logarithms.
        let product: f64 = slacks.iter().product();
        let missing: f64 = missing.iter().map(|m| m.abs()).sum();
        time_s.ln() - self.barrier * product.ln() + self.penalty * missing
    }

    /// How fast it changes along a step at its start.
    fn slope(&self, here: &Derivatives, from: &Iterate, step: &Step) -> f64 {
        let logarithms: f64 =
            step.slacks.iter().zip(&from.slacks).map(|(change, slack)| change / slack).sum();
        let missing: f64 = step.missing.iter().map(|m| m.abs()).sum();
        here.gradient.dot(&step.at) - self.barrier * logarithms - self.penalty * missing
    }
}

/// What share of a step leaves all that are positive so: all of it at the most, [`TO_THE_LIMIT`] of what makes one 0.
fn share_to_zero(values: &[f64; LOADS], changes: &[f64; LOADS]) -> f64 {
    let shares = values.iter().zip(changes).filter(|(_, change)| **change < 0.0);
    shares.map(|(value, change)| -TO_THE_LIMIT * value / change).fold(1.0, f64::min)
}

impl Step {
    /// Newton's, toward the point of the central path at `barrier`.
    fn newton(here: &Derivatives, from: &Iterate, missing: &[f64; LOADS], barrier: f64) -> Self {
        let (slacks, multipliers) = (&from.slacks, &from.multipliers);
        let stiffness: [f64; LOADS] = std::array::from_fn(|i| multipliers[i] / slacks[i]);
        let mut matrix = here.hessian;
        let mut right = -here.gradient;
        for i in 0..LOADS {
            let gradient = &here.load_gradients[i];
            matrix += gradient * gradient.transpose() * stiffness[i];
            right -= gradient * (barrier / slacks[i] + stiffness[i] * missing[i]);
        }
        let at = solved(&matrix, &right, here.hessian.amax());
        let moved: [f64; LOADS] = std::array::from_fn(|i| missing[i] + here.load_gradients[i].dot(&at));
        Self {
            at,
            slacks: moved.map(|moved| -moved),
            multipliers: std::array::from_fn(|i| {
                barrier / slacks[i] - multipliers[i] + stiffness[i] * moved[i]
            }),
            missing: *missing,
        }
    }

    /// What a missing unit costs in the penalty function: more than any multiplier, before the step and after.
    fn penalty(&self, multipliers: &[f64; LOADS]) -> f64 {
        let after = multipliers.iter().zip(&self.multipliers).map(|(m, change)| m.max((m + change).abs()));
        1.0 + 2.0 * after.fold(0.0, f64::max)
    }

    /// How much of it can be gone at the most: all of it, unless a slack ends or an unknown changes too much.
    fn longest(&self, slacks: &[f64; LOADS]) -> f64 {
        (LONGEST_STEP / self.at.amax()).min(share_to_zero(slacks, &self.slacks))
    }
}

/// The solution of `matrix` x = `right`, with as much added to the diagonal as makes the matrix positive: a share of
/// `size` first, which is that of the part that can be negative.
fn solved(matrix: &Matrix4<f64>, right: &Vector4<f64>, size: f64) -> Vector4<f64> {
    let mut shift = 0.0;
    for _ in 0..MOST_SHIFTS {
        if let Some(factors) = (matrix + Matrix4::identity() * shift).cholesky() {
            return factors.solve(right);
        }
        shift = (10.0_f64 * shift).max(1e-3 * size);
    }
    // A matrix that no shift makes positive holds no numbers: the line search then ends where it is.
    Vector4::zeros()
}

fn pulled_inside(model: &Model, start: &Parameters, pull: f64) -> Point {
    let swing = model.swing(start.swing_rad.min((1.0 - pull) * model.given().max_swing_rad));
    let used = start.step_mm / model.full_step_mm(start.layer_spacing_mm, &model.swing(start.swing_rad));
    let spacing = (1.0 - pull) * start.layer_spacing_mm;
    let step = (1.0 - pull) * used.min(1.0) * model.full_step_mm(spacing, &swing);
    [spacing, step, swing.angle, (1.0 + pull) * model.next_point_s(step, &swing)]
}

fn loads_at(model: &Model, at: &Point) -> [f64; LOADS] {
    let [spacing, step, angle, next_point_s] = *at;
    loads(model, spacing, step, &model.swing(angle), next_point_s)
}

fn time_at(model: &Model, at: &Point) -> f64 {
    let [spacing, step, angle, next_point_s] = *at;
    model.time_with_next_point_s(spacing, step, &model.swing(angle), next_point_s)
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

impl Derivatives {
    /// How far the conditions of a point on the central path are from being met.
    fn error(&self, at: &Iterate, missing: &[f64; LOADS], barrier: f64) -> f64 {
        let mut sum = self.gradient;
        let mut error = 0.0_f64;
        for (i, missing) in missing.iter().enumerate() {
            sum += self.load_gradients[i] * at.multipliers[i];
            error = error.max((at.multipliers[i] * at.slacks[i] - barrier).abs()).max(missing.abs());
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
        time_s: 0.0,
        gradient: Vector4::zeros(),
        loads: [0.0; LOADS],
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
            let time_s = model.time_with_next_point_s(spacing, step, &swing, next_point_s);
            let time = time_s.ln();
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
                (result.time_s, result.loads) = (time_s.re, loads.map(|load| load.re));
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
