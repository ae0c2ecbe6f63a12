//! What a cut costs in a section that has been cut 1,000 and 20,000 times: it must not grow.

use bladeplan::planning::geometry::Point2;
use bladeplan::planning::honeycomb::blade::Side;
use bladeplan::planning::honeycomb::lattice::{Spacing, tips};
use bladeplan::planning::honeycomb::lattice_kind::Lattice;
use bladeplan::planning::honeycomb::section::{Cut, Reach, Section};
use divan::Bencher;
use divan::counter::ItemsCount;

fn main() {
    divan::main();
}

/// Cuts in a measured run.
const RUN: usize = 200;

/// A blank of 2400 by 90 mm, 400 columns, and all cuts of an orthogonal lattice down to a wavy contour.
fn big() -> (Section, Vec<Cut>) {
    let wave = (0..=2400).map(f64::from).map(|x| Point2::new(x, 4.0 + 2.0 * (x / 40.0).sin()));
    let profile: Vec<Point2> = wave.collect();
    let (layer, step, swing) = (3.0_f64, 6.0_f64, 45.0_f64.to_radians());
    let cutting = layer / (Lattice::Orthogonal.depth_factor() * swing.cos());
    let reach = Reach { cutting, edge: cutting * 1.25, body: cutting * 1.4 };
    let section = Section::new(2400.0, 90.0, &profile, 0.0, cutting).expect("the blank is valid");
    let layers = tips(Lattice::Orthogonal, &Spacing { layer, step, swing }, &section, &reach)
        .expect("the lattice is valid");
    let both = [Side::Left, Side::Right];
    let cuts = layers.into_iter().flatten().flat_map(|tip| both.map(|side| Cut { tip, side, swing, reach }));
    (section, cuts.collect())
}

#[divan::bench(args = [1_000, 20_000])]
fn cuts_after(bencher: Bencher, before: usize) {
    let (mut section, cuts) = big();
    for cut in &cuts[..before] {
        section.cut(cut).expect("the cut is valid");
    }
    let next = &cuts[before..before + RUN];
    bencher.counter(ItemsCount::new(RUN)).with_inputs(|| section.clone()).bench_values(|mut section| {
        for cut in next {
            divan::black_box(section.cut(cut).expect("the cut is valid"));
        }
        section
    });
}

/// The whole of Table 1 at its optimum: 119 tips, 238 cuts, the surface and the scallop.
#[divan::bench]
fn table_1(bencher: Bencher) {
    let arc = |x: f64| 16.782213 - 85.0 + (85.0_f64.powi(2) - (x - 42.5).powi(2)).sqrt();
    let profile: Vec<Point2> =
        (0..=340).map(|i| f64::from(i) * 0.25).map(|x| Point2::new(x, arc(x))).collect();
    let (layer, step, swing) = (4.398_f64, 5.968_f64, 34.155_f64.to_radians());
    let cutting = layer / (Lattice::Orthogonal.depth_factor() * swing.cos());
    let reach = Reach { cutting, edge: 7.973, body: 9.214 };
    bencher.bench(|| {
        let mut section = Section::new(85.0, 50.0, &profile, 0.0, cutting).expect("the blank is valid");
        let layers = tips(Lattice::Orthogonal, &Spacing { layer, step, swing }, &section, &reach)
            .expect("the lattice is valid");
        for &tip in layers.iter().flatten() {
            for side in [Side::Left, Side::Right] {
                section.cut(&Cut { tip, side, swing, reach }).expect("the cut is valid");
            }
        }
        section.remains()
    });
}
