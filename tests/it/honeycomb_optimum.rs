//! No other solver, from any of several starts, finds a set of parameters that is better than our optimum.

use bladeplan::planning::honeycomb::lattice_kind::Lattice;
use bladeplan::planning::honeycomb::model::Model;
use bladeplan::planning::honeycomb::model::given::Given;
use bladeplan::planning::honeycomb::optimum::optimum;
use proptest::prelude::*;

use crate::oracles::{Point, Problem, ripopt, within};
use crate::rounds::runner;

fn log(from: f64, to: f64) -> impl Strategy<Value = f64> {
    (from.ln()..to.ln()).prop_map(f64::exp)
}

/// Tiny and huge parts, slow and fast machines, limits of scallop and swing that hold and that do not.
fn any_given() -> impl Strategy<Value = Given> {
    let sizes = (log(1.0, 5000.0), log(1.0, 5000.0), log(0.02, 5.0), log(0.5, 500.0));
    let speeds = (log(5.0, 1000.0), log(5.0, 2000.0), log(0.1, 7.0));
    let blade = (20.0..90.0_f64, 0.02..0.8_f64, log(1.0, 200.0), 3.0..89.0_f64, log(0.05, 3.0), 0..3_usize);
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

#[test]
fn neither_ripopt_nor_cobyla_finds_a_better_one() {
    let (mut answers, mut near) = (0, 0);
    let test = |given: Given| {
        let model = Model::new(given).unwrap();
        let found = optimum(&model);
        let ours = found.estimate.time_s;
        let best = found.estimate.parameters;
        let shares: [Point; 3] = [[0.6, 0.3, 0.8], [0.9, 0.9, 0.9], [0.2, 0.1, 0.4]];
        for share in shares {
            let start =
                [best.layer_spacing_mm * share[0], best.step_mm * share[1], best.swing_rad * share[2]];
            for [h, s, alpha] in [ripopt(&model, start), from_cobyla(&model, start)].into_iter().flatten() {
                let theirs = model.time_s(h, s, &model.swing(alpha));
                prop_assert!(theirs >= ours * (1.0 - 1e-6), "{theirs} s is less than {ours} s: {given:?}");
            }
        }
        Ok(())
    };
    runner(100).run(&any_given(), test).unwrap();
    // The oracles are of use only if they come to the same optimum now and then.
    for seed in [1.0, 2.0, 3.0, 4.0] {
        let given = Given { blank_length_mm: 50.0 * seed, ..table_1() };
        let model = Model::new(given).unwrap();
        let ours = optimum(&model).estimate.time_s;
        for [h, s, alpha] in
            [ripopt(&model, [3.0, 4.0, 0.6]), from_cobyla(&model, [3.0, 4.0, 0.6])].into_iter().flatten()
        {
            answers += 1;
            near += u32::from(model.time_s(h, s, &model.swing(alpha)) < ours * (1.0 + 1e-4));
        }
    }
    assert!(answers >= 4 && near * 2 >= answers, "{near} of {answers} answers come near");
}

/// What COBYLA finds from a start.
fn from_cobyla(model: &Model, start: Point) -> Option<Point> {
    let problem = Problem { model, start };
    // In shares of the start, so that all unknowns are of one size.
    let at = |y: &[f64]| -> Point { std::array::from_fn(|i| start[i] * y[i].abs().max(1e-9)) };
    let time = |y: &[f64], _: &mut ()| problem.time(at(y));
    let limits = |i: usize| {
        let problem = &problem;
        move |y: &[f64], _: &mut ()| -problem.limits(at(y))[i] / model.given().max_cutting_length_mm
    };
    let constraints = [limits(0), limits(1), limits(2)];
    let bounds = [model.max_layer_spacing_mm, model.max_step_mm, model.given().max_swing_rad];
    let bounds: Vec<(f64, f64)> =
        bounds.iter().zip(start).map(|(high, start)| (1e-9, high / start)).collect();
    let found =
        cobyla::minimize(time, &[1.0; 3], &bounds, &constraints, (), 5_000, cobyla::RhoBeg::All(0.2), None);
    let y = found.map_or_else(|(_, y, _)| y, |(_, y, _)| y);
    within(model, at(&y))
}

fn table_1() -> Given {
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
        lattice: Lattice::Orthogonal,
    }
}
