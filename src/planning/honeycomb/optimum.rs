//! The global optimum of the published model (Cui et al. 2020, Eq. 14), proved to be global.
//!
//! The problem is not convex: a local solver misses the best of several optima in one case of four (domain.md B2). So
//! three parts work together. `seed` looks at a few places for a good start. `interior` takes a set of parameters to
//! the best one around it. `cover` proves that nothing anywhere is shorter by more than [`OPTIMUM_GAP`], or finds
//! a set that is; that one is then polished in turn.
//!
//! [`OPTIMUM_GAP`]: crate::planning::tolerance::OPTIMUM_GAP

mod cover;
mod interior;
mod jet;
mod line;
mod patch;
mod span;

use self::cover::{Cover, Incumbent, Outcome, Weights};
use self::interior::{Polished, derivatives, polish};
use self::patch::{Leg, Piece, largest_spacing_mm};
use super::lattice_kind::Lattice;
use super::model::estimate::Estimate;
use super::model::limit::Limit;
use super::model::{Model, Parameters};
use crate::planning::tolerance::ACTIVE_MULTIPLIER;

/// The best set of parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Optimum {
    /// What the model says of it.
    pub estimate: Estimate,
    /// The limits that hold it, in the order of [`Limit::ALL`].
    pub active: Vec<Active>,
    /// How far it is from Karush's, Kuhn's and Tucker's conditions, in the logarithms of time, h, s and alpha, so that
    /// no unit matters: the largest of the slopes of the Lagrangian, of multiplier times slack, and of any excess.
    pub kkt_residual: f64,
    /// No set is shorter than this, in s.
    pub bound_s: f64,
}

/// A limit that holds the optimum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Active {
    /// Which.
    pub limit: Limit,
    /// What share of the time would be saved by a limit wider by its whole: d ln T / d ln limit, positive.
    pub multiplier: f64,
}

/// A shorter set is found so many times at the most; no problem has needed more than a handful.
const MOST_POLISHES: usize = 20;

/// The global optimum.
#[must_use]
pub fn optimum(model: &Model) -> Optimum {
    let mut polished = polish(model, &seed(model));
    let mut cover = Cover::new(model);
    for _ in 0..MOST_POLISHES {
        match cover.search(&incumbent(model, &polished)) {
            Outcome::Proved(bound_s) => return found(model, &polished, bound_s),
            Outcome::Shorter(start) => {
                let other = polish(model, &start);
                if time_s(model, &other) < time_s(model, &polished) {
                    polished = other;
                }
            }
        }
    }
    // Nothing is proved then, and the bound says so.
    found(model, &polished, 0.0)
}

fn time_s(model: &Model, polished: &Polished) -> f64 {
    let [spacing, step, angle, _] = polished.at;
    model.time_s(spacing, step, &model.swing(angle))
}

/// The best of a few places, where steps use all or some of the swing.
fn seed(model: &Model) -> Parameters {
    const SHARES: [f64; 3] = [1.0, 0.7, 0.4];
    let mut best = (f64::INFINITY, Parameters { layer_spacing_mm: 0.0, step_mm: 0.0, swing_rad: 0.0 });
    for angle in angles(model) {
        let swing = model.swing(angle);
        for ratio in SHARES.map(|share| if share == 1.0 { swing.tan } else { (share * angle).tan() }) {
            let layer_spacing_mm = largest_spacing_mm(model, &swing, ratio);
            let step_mm = 2.0 * layer_spacing_mm * ratio;
            let time_s = model.time_s(layer_spacing_mm, step_mm, &swing);
            if time_s < best.0 {
                best = (time_s, Parameters { layer_spacing_mm, step_mm, swing_rad: angle });
            }
        }
    }
    best.1
}

/// Eight steps up to the largest swing, and below the least of them six halvings.
fn angles(model: &Model) -> impl Iterator<Item = f64> {
    const STEPS: u32 = 8;
    const HALVINGS: i32 = 6;
    let largest = model.given().max_swing_rad;
    let least = largest / f64::from(STEPS);
    let steps = (1..=STEPS).map(move |step| least * f64::from(step));
    steps.chain((1..=HALVINGS).map(move |halving| least * 0.5_f64.powi(halving)))
}

/// What is to be beaten, with the weights of its pieces and legs: their multipliers.
fn incumbent(model: &Model, polished: &Polished) -> Incumbent {
    let of = |limit: Limit| polished.multipliers[Limit::ALL.iter().position(|l| *l == limit).unwrap_or(0)];
    let limits = Piece::ALL.map(|piece| match piece {
        Piece::CuttingLength => of(Limit::CuttingLength),
        Piece::Layers => of(Limit::Layers),
        Piece::Scallop => of(Limit::Scallop),
        Piece::Points => of(Limit::Points),
    });
    let [pieces, legs] = [shares(&limits), shares(&polished.multipliers[Limit::COUNT..])];
    let weights: Weights = std::array::from_fn(|index| {
        let leg = [Leg::Turn, Leg::Travel][index % 2];
        ((Piece::ALL[index / 2], leg), pieces[index / 2] * legs[index % 2])
    });
    let [spacing, step, angle, _] = polished.at;
    let kappa = (step / (2.0 * spacing)).atan() / angle;
    Incumbent { time_s: time_s(model, polished), place: [angle, kappa], weights }
}

/// Multipliers as shares of 1, those of limits that do not hold left out.
fn shares(multipliers: &[f64]) -> Vec<f64> {
    /// Below this share of all, a multiplier is what the barrier has left.
    const LEFT_BY_BARRIER: f64 = 1e-7;
    let all: f64 = multipliers.iter().sum();
    let kept: Vec<f64> =
        multipliers.iter().map(|&one| if one > LEFT_BY_BARRIER * all { one } else { 0.0 }).collect();
    let sum: f64 = kept.iter().sum();
    kept.iter().map(|one| if sum > 0.0 { one / sum } else { 0.0 }).collect()
}

fn found(model: &Model, polished: &Polished, bound_s: f64) -> Optimum {
    let [layer_spacing_mm, step_mm, swing_rad, _] = polished.at;
    let active = Limit::ALL.into_iter().zip(polished.multipliers);
    let active = active.filter(|(_, multiplier)| *multiplier > ACTIVE_MULTIPLIER);
    Optimum {
        estimate: model.judged(&Parameters { layer_spacing_mm, step_mm, swing_rad }),
        active: active.map(|(limit, multiplier)| Active { limit, multiplier }).collect(),
        kkt_residual: residual(model, polished),
        bound_s,
    }
}

fn residual(model: &Model, polished: &Polished) -> f64 {
    let at = derivatives(model, &polished.at, &polished.multipliers);
    let (mut slope, mut largest) = (at.gradient, 0.0_f64);
    for ((gradient, multiplier), load) in at.load_gradients.iter().zip(&polished.multipliers).zip(&at.loads) {
        let slack = 1.0 - load;
        slope += gradient * *multiplier;
        largest = largest.max(multiplier * slack.abs()).max(-slack);
    }
    largest.max(slope.amax())
}

/// The time in s at a layer spacing (mm) and a swing (rad), with the step that takes least there: the largest that all
/// limits allow, for the time falls while the step grows.
///
/// # Errors
/// The limit that excludes the place.
pub fn best_step(model: &Model, layer_spacing_mm: f64, swing_rad: f64) -> Result<f64, Limit> {
    let given = model.given();
    if swing_rad > given.max_swing_rad {
        return Err(Limit::SwingAngle);
    }
    let swing = model.swing(swing_rad);
    if layer_spacing_mm > model.depth_mm * swing.cos {
        return Err(Limit::CuttingLength);
    }
    if layer_spacing_mm > model.max_layer_spacing_mm {
        return Err(Limit::Layers);
    }
    if layer_spacing_mm >= given.max_scallop_mm {
        return Err(Limit::Scallop);
    }
    let by_scallop = step_by_scallop(given.lattice, layer_spacing_mm, swing.tan, given.max_scallop_mm);
    let step = model.full_step_mm(layer_spacing_mm, &swing).min(model.max_step_mm).min(by_scallop);
    Ok(model.time_s(layer_spacing_mm, step, &swing))
}

/// The step at which the scallop of Eq. 12 is at its limit, in mm: its positive root.
fn step_by_scallop(lattice: Lattice, spacing: f64, tan: f64, limit: f64) -> f64 {
    match lattice {
        Lattice::Interlaced => 2.0 * (limit - spacing) * tan,
        Lattice::Orthogonal | Lattice::Free => {
            let (a, b) = (1.0 + 1.0 / (tan * tan), spacing / tan);
            2.0 * ((b * b + a * (limit * limit - spacing * spacing)).sqrt() - b) / a
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planning::honeycomb::model::given::Given;
    use crate::planning::tolerance::OPTIMUM_GAP;
    use proptest::prelude::*;

    fn table1(lattice: Lattice) -> Given {
        Given {
            blank_width_mm: 85.0,
            blank_length_mm: 50.0,
            machined_area_mm2: 3137.0,
            safety_distance_mm: 10.0,
            rake_rad: 60.0_f64.to_radians(),
            half_apex_rad: 7.13_f64.to_radians(),
            cutting_speed_mm_s: 200.0,
            travel_speed_mm_s: 200.0,
            angular_speed_rad_s: 90.0_f64.to_radians(),
            max_scallop_mm: 10.0,
            max_cutting_length_mm: 10.0,
            max_swing_rad: 50.0_f64.to_radians(),
            lattice,
        }
    }

    #[test]
    fn table_1_to_its_printed_digits() {
        let found = optimum(&Model::new(table1(Lattice::Orthogonal)).unwrap());
        let Parameters { layer_spacing_mm, step_mm, swing_rad } = found.estimate.parameters;
        for (value, printed, half_digit) in [
            (layer_spacing_mm, 4.398, 5e-4),
            (step_mm, 5.968, 5e-4),
            (swing_rad.to_degrees(), 34.155, 5e-4),
            (found.estimate.time_s, 307.599, 5e-4),
            (found.estimate.scallop_mm, 9.289, 5e-4),
        ] {
            assert!((value - printed).abs() <= half_digit, "{value} is not {printed}");
        }
        let active: Vec<_> = found.active.iter().map(|active| active.limit).collect();
        assert_eq!(active, [Limit::CuttingLength, Limit::Step]);
        assert!(found.kkt_residual < 1e-8, "{found:?}");
        assert!(found.bound_s > found.estimate.time_s * (1.0 - 2.0 * OPTIMUM_GAP));
    }

    #[test]
    fn other_limits_hold_other_optima() {
        let holds = |change: &dyn Fn(&mut Given)| {
            let mut given = table1(Lattice::Orthogonal);
            change(&mut given);
            let found = optimum(&Model::new(given).unwrap());
            found.active.iter().map(|active| active.limit).collect::<Vec<_>>()
        };
        assert!(holds(&|given| given.max_scallop_mm = 4.0).contains(&Limit::Scallop));
        assert!(holds(&|given| given.max_swing_rad = 20.0_f64.to_radians()).contains(&Limit::SwingAngle));
        assert!(holds(&|given| given.machined_area_mm2 = 300.0).contains(&Limit::Layers));
    }

    /// At this optimum a limit (no overlap) touches without holding, so that its slack and its multiplier vanish
    /// together; the method once came to a stand there, a millionth above the optimum, and nothing was proved.
    #[test]
    fn a_limit_that_only_touches_does_not_hold_the_method_up() {
        let given = Given {
            blank_width_mm: 2772.7215178982406,
            blank_length_mm: 4018.9108461756523,
            machined_area_mm2: 7687984.615815924,
            safety_distance_mm: 1.0,
            rake_rad: 0.3490658503988659,
            half_apex_rad: 0.006981317007977318,
            cutting_speed_mm_s: 5.0,
            travel_speed_mm_s: 5.0,
            angular_speed_rad_s: 1.0,
            max_scallop_mm: 0.15316542788817308,
            max_cutting_length_mm: 1.0,
            max_swing_rad: 0.05235987755982989,
            lattice: Lattice::Interlaced,
        };
        let found = optimum(&Model::new(given).unwrap());
        assert!(found.kkt_residual < 1e-8, "{found:?}");
        assert!(found.bound_s > found.estimate.time_s * (1.0 - 2.0 * OPTIMUM_GAP));
    }

    fn log(from: f64, to: f64) -> impl Strategy<Value = f64> {
        (from.ln()..to.ln()).prop_map(f64::exp)
    }

    fn any_given() -> impl Strategy<Value = Given> {
        let sizes = (log(1.0, 5000.0), log(1.0, 5000.0), log(0.02, 5.0), log(0.5, 500.0));
        let speeds = (log(5.0, 1000.0), log(5.0, 2000.0), log(0.1, 7.0));
        let blade =
            (20.0..90.0_f64, 0.02..0.8_f64, log(1.0, 200.0), 3.0..89.0_f64, log(0.05, 3.0), 0..3_usize);
        (sizes, speeds, blade).prop_map(
            |((w, d, height, h0), (v1, v2, omega), (theta, beta, l, alpha, scallop, lattice))| Given {
                blank_width_mm: w,
                blank_length_mm: d,
                machined_area_mm2: w * w * height,
                safety_distance_mm: h0,
                rake_rad: theta.to_radians(),
                half_apex_rad: (theta * beta).min(25.0).to_radians(),
                cutting_speed_mm_s: v1,
                travel_speed_mm_s: v2,
                angular_speed_rad_s: omega,
                max_scallop_mm: l * scallop,
                max_cutting_length_mm: l,
                max_swing_rad: alpha.to_radians(),
                lattice: [Lattice::Orthogonal, Lattice::Interlaced, Lattice::Free][lattice],
            },
        )
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 40, failure_persistence: None, ..ProptestConfig::default() })]
        #[test]
        fn no_place_of_a_grid_is_better_and_nothing_is_left_unproved(given in any_given()) {
            let model = Model::new(given).unwrap();
            let found = optimum(&model);
            prop_assert!(found.estimate.breaches.is_empty(), "{found:?}");
            prop_assert!(found.kkt_residual < 1e-6, "{found:?}");
            prop_assert!(found.bound_s >= found.estimate.time_s * (1.0 - 2.0 * OPTIMUM_GAP));
            let highest = model.depth_mm.min(model.max_layer_spacing_mm).min(given.max_scallop_mm);
            for (i, j) in (1..=60).flat_map(|i| (1..=60).map(move |j| (f64::from(i) / 60.0, f64::from(j) / 60.0))) {
                if let Ok(time_s) = best_step(&model, highest * i, given.max_swing_rad * j) {
                    prop_assert!(time_s >= found.estimate.time_s * (1.0 - 1e-7), "{time_s} at {i} {j}: {found:?}");
                }
            }
        }
    }
}
