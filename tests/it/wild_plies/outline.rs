//! Plane figures that cross themselves nowhere by the way they are made: stars, with folds and noise.

use bladeplan::planning::geometry::Point2;
use bladeplan::planning::geometry::crossing::first_crossing;
use proptest::prelude::*;

/// A figure around (0, 0).
#[derive(Debug, Clone)]
pub struct Figure {
    /// Radii of corners at even angles, in mm.
    radii: Vec<f64>,
    /// How far apart points are at the most, in mm.
    step_mm: f64,
    /// By how much the radius of each point is off, in mm, and the seed of that.
    noise: Option<(f64, u64)>,
    /// The figure is turned by so many rad at a radius of 300 mm, less within.
    swirl: f64,
    /// It is as narrow as this across.
    narrow: f64,
    /// Angle and size, in shares of the room that there is, of each cut-out, and its corners.
    holes: Vec<(f64, f64, usize)>,
}

/// Figures of about 300 mm radius.
pub fn figures() -> impl Strategy<Value = Figure> {
    // Few corners, or many with deep lobes between them.
    let radii = prop_oneof![
        prop::collection::vec(120.0..300.0_f64, 3..9),
        prop::collection::vec(60.0..300.0_f64, 8..24),
        // All but straight ends and sides.
        (150.0..300.0_f64, 0.0..5.0_f64, 4..9_usize).prop_map(|(size, off, count)| {
            (0..count).map(|i| size + if i % 2 == 0 { off } else { 0.0 }).collect()
        }),
    ];
    let noise = prop_oneof![2 => Just(None), 1 => (0.02..0.5_f64, any::<u64>()).prop_map(Some)];
    let narrow = prop_oneof![3 => Just(1.0), 1 => 0.02..0.5_f64];
    let swirl = prop_oneof![1 => Just(0.0), 1 => -1.5..1.5_f64];
    let holes = prop::collection::vec((0.0..1.0_f64, 0.1..1.0_f64, 3..40_usize), 0..5);
    (radii, 1.5..40.0_f64, noise, swirl, narrow, holes).prop_map(
        |(radii, step_mm, noise, swirl, narrow, holes)| Figure {
            radii,
            step_mm: if noise.is_some() { step_mm.min(3.0) } else { step_mm },
            noise,
            swirl,
            narrow,
            holes,
        },
    )
}

/// Points that are the same for the same seed: SplitMix64 (Steele, Lea and Flood 2014), in -1..1.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (mixed ^ (mixed >> 31)) as f64 / u64::MAX as f64 * 2.0 - 1.0
    }
}

impl Figure {
    /// The outline and the cut-outs, counter-clockwise. Where its folds would touch one another it has none.
    pub fn loops(&self) -> Vec<Vec<(f64, f64)>> {
        let folded = self.drawn(self.swirl);
        let points = |points: &Vec<(f64, f64)>| points.iter().map(|&(x, y)| Point2::new(x, y)).collect();
        let loops: Vec<Vec<Point2>> = folded.iter().map(points).collect();
        if self.swirl == 0.0 || first_crossing(&loops, 0.05).is_none() { folded } else { self.drawn(0.0) }
    }

    fn drawn(&self, swirl: f64) -> Vec<Vec<(f64, f64)>> {
        let count = self.radii.len();
        let corner = |i: usize| polar(self.radii[i % count], std::f64::consts::TAU * i as f64 / count as f64);
        let corners: Vec<_> = (0..count).map(corner).collect();
        let mut loops = vec![self.noisy(&subdivided(&corners, self.step_mm))];
        loops.extend(self.cut_outs());
        let place = |&(x, y): &(f64, f64)| {
            let turned = swirl * x.hypot(y) / 300.0;
            let (sin, cos) = turned.sin_cos();
            (x * cos - y * sin, (x * sin + y * cos) * self.narrow)
        };
        loops.iter().map(|points| points.iter().map(place).collect()).collect()
    }

    /// Each point is moved along its radius, which keeps a star a star.
    fn noisy(&self, points: &[(f64, f64)]) -> Vec<(f64, f64)> {
        let Some((most, seed)) = self.noise else { return points.to_vec() };
        let mut noise = Noise(seed);
        let moved = points.iter().map(|&(x, y)| {
            let share = 1.0 + most * noise.next() / x.hypot(y);
            (x * share, y * share)
        });
        moved.collect()
    }

    /// Cut-outs, each in its own quarter of the disc that is in every star.
    fn cut_outs(&self) -> Vec<Vec<(f64, f64)>> {
        let least = self.radii.iter().copied().fold(f64::INFINITY, f64::min);
        let room = least * (std::f64::consts::PI / self.radii.len() as f64).cos() - 1.0;
        let cut_out = |(quarter, &(angle, size, corners)): (usize, &(f64, f64, usize))| {
            let (x, y) = polar(0.55 * room, std::f64::consts::FRAC_PI_2 * quarter as f64);
            let around = |i: usize| {
                let turn = std::f64::consts::TAU * (i as f64 + angle) / corners as f64;
                let (dx, dy) = polar(0.35 * room * size, turn);
                (x + dx, y + dy)
            };
            subdivided(&(0..corners).map(around).collect::<Vec<_>>(), self.step_mm)
        };
        self.holes.iter().enumerate().map(cut_out).collect()
    }

    /// A point in the middle of the figure and beyond: the courses are laid across these y, before it is turned.
    pub fn radius(&self) -> f64 {
        self.radii.iter().copied().fold(0.0, f64::max) + 1.0
    }
}

fn polar(radius: f64, angle: f64) -> (f64, f64) {
    (radius * angle.cos(), radius * angle.sin())
}

/// The sides of a loop in even steps.
fn subdivided(corners: &[(f64, f64)], step_mm: f64) -> Vec<(f64, f64)> {
    let mut points = Vec::new();
    for (index, from) in corners.iter().enumerate() {
        let to = corners[(index + 1) % corners.len()];
        let parts = ((to.0 - from.0).hypot(to.1 - from.1) / step_mm).ceil().max(1.0);
        points.extend((0..parts as usize).map(|part| {
            let share = part as f64 / parts;
            (from.0 + share * (to.0 - from.0), from.1 + share * (to.1 - from.1))
        }));
    }
    points
}
