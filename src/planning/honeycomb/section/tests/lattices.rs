//! The published lattices on the paper's own part and on others.

use rstest::rstest;

use super::super::*;
use super::{arc, check_areas, close, flat};
use crate::planning::honeycomb::lattice::{Spacing, tips};
use crate::planning::honeycomb::lattice_kind::Lattice;

/// A section after all cuts of a lattice, how many tips that had, and the cuts.
struct Done {
    section: Section,
    tips: usize,
    outcomes: Vec<CutOutcome>,
}

/// The reaches of Table 1's blade of 10 mm, of which what a lattice needs cuts.
fn reach(kind: Lattice, layer: f64, swing_deg: f64) -> Reach {
    let cutting = layer / (kind.depth_factor() * swing_deg.to_radians().cos());
    let sine = |angle: f64| angle.to_radians().sin();
    Reach { cutting, edge: cutting.max(10.0 * sine(60.0 - 7.13)), body: 10.0 * sine(60.0 + 7.13) }
}

fn cut_all(kind: Lattice, layer: f64, step: f64, swing_deg: f64, profile: &[Point2]) -> Done {
    let reach = reach(kind, layer, swing_deg);
    let width = profile[profile.len() - 1].x;
    let mut section = Section::new(width, 50.0, profile, 0.0, reach.cutting).unwrap();
    let swing = swing_deg.to_radians();
    let layers = tips(kind, &Spacing { layer, step, swing }, &section, &reach).unwrap();
    let printed = |value: f64| (value * 1e4).round() / 1e4;
    let mut outcomes = Vec::new();
    for tip in layers.iter().flatten().map(|tip| Point2::new(printed(tip.x), printed(tip.y))) {
        for side in [Side::Left, Side::Right] {
            outcomes.push(section.cut(&Cut { tip, side, swing, reach }).unwrap());
        }
    }
    Done { section, tips: layers.iter().map(Vec::len).sum(), outcomes }
}

impl Done {
    fn chips(&self) -> usize {
        self.outcomes.iter().map(|outcome| outcome.chips.len()).sum()
    }

    /// No gouge, no blade in stock, no chip that stays, and the areas add up.
    #[track_caller]
    fn check(&self) -> Remains {
        check_areas(&self.section, &self.outcomes);
        assert!(self.outcomes.iter().all(|outcome| !outcome.is_gouge()));
        assert!(self.outcomes.iter().all(|outcome| !outcome.runs_in_stock()));
        let remains = self.section.remains();
        assert_eq!(remains.stuck, []);
        assert_eq!(remains.gouge_area, 0.0);
        remains
    }
}

/// domain.md B3, "published, counted exactly".
#[rstest]
#[case::initial(3.0, 6.0, 45.0, 179, 4.477)]
#[case::optimum(4.398, 5.968, 34.155, 119, 8.03)]
fn table_1_has_its_tips_and_its_scallop(
    #[case] layer: f64,
    #[case] step: f64,
    #[case] swing_deg: f64,
    #[case] count: usize,
    #[case] scallop: f64,
) {
    let done = cut_all(Lattice::Orthogonal, layer, step, swing_deg, &arc());
    assert_eq!((done.tips, done.chips()), (count, count));
    close(done.check().scallop.unwrap().distance, scallop, 0.005);
}

#[test]
fn beside_a_wall_chips_stay_and_are_said() {
    // The tips next to the wall are left out, for an arm would enter it; theirs are the slits that would have taken
    // over their neighbours' arms.
    let step = [(0.0, 30.0), (40.0, 30.0), (40.0, 8.0), (85.0, 8.0)].map(|(x, z)| Point2::new(x, z));
    let done = cut_all(Lattice::Orthogonal, 4.398, 5.968, 34.155, &step);
    check_areas(&done.section, &done.outcomes);
    assert!(done.outcomes.iter().all(|outcome| !outcome.is_gouge()));
    let remains = done.section.remains();
    assert!((2..8).contains(&remains.stuck.len()), "{:?}", remains.stuck);
    for tip in &remains.stuck {
        assert!(!done.section.is_air(&Point2::new(tip.x, tip.y + 0.5)));
        assert!((40.0..52.0).contains(&tip.x) && tip.y < 30.0, "{tip}");
    }
}

#[rstest]
#[case(Lattice::Orthogonal)]
#[case(Lattice::Interlaced)]
#[case(Lattice::Free)]
fn every_lattice_frees_every_chip_above_a_plane(#[case] kind: Lattice) {
    for (layer, swing_deg) in [(4.0, 34.0_f64), (5.0, 20.0), (2.5, 45.0)] {
        let step = 2.0 * layer * swing_deg.to_radians().tan();
        let done = cut_all(kind, layer, step, swing_deg, &flat(61.0, 8.0));
        let remains = done.check();
        assert!(done.tips > 20, "{kind:?} {}", done.tips);
        // All stock above the lowest layer's ridges is gone.
        let lowest = 50.0 - ((50.0 - 8.0) / layer).floor() * layer;
        let highest = lowest + 2.0 * layer - 8.0;
        assert!(remains.scallop.unwrap().distance <= highest, "{kind:?} {:?} {highest}", remains.scallop);
    }
}

#[test]
fn a_chip_of_an_interlaced_lattice_is_a_rhombus() {
    let (layer, swing_deg) = (5.0, 30.0_f64);
    let step = 2.0 * layer * swing_deg.to_radians().tan();
    let done = cut_all(Lattice::Interlaced, layer, step, swing_deg, &flat(8.0 * step, 8.0));
    let kerf = crate::planning::tolerance::KERF_MM;
    // Less half a kerf along each of its four sides.
    let side = layer / swing_deg.to_radians().cos();
    let wanted = step * layer - 2.0 * side * kerf;
    let rhombi = done
        .outcomes
        .iter()
        .flat_map(|outcome| &outcome.chips)
        .filter(|chip| (chip.area - wanted).abs() < 0.01);
    assert!(rhombi.count() > 30);
}

#[test]
fn what_a_cut_takes_to_find_out_does_not_grow() {
    let (layer, swing_deg) = (3.0, 45.0);
    let done = cut_all(Lattice::Orthogonal, layer, 6.0, swing_deg, &flat(600.0, 5.0));
    let steps: Vec<u64> = done.outcomes.iter().map(|outcome| outcome.steps).collect();
    let mean = |steps: &[u64]| steps.iter().sum::<u64>() as f64 / steps.len() as f64;
    let (early, late) = (mean(&steps[400..800]), mean(&steps[steps.len() - 800..steps.len() - 400]));
    assert!(steps.len() > 2_800 && late < 1.2 * early, "{} {early} {late}", steps.len());
}

#[test]
fn the_same_cuts_give_the_same_bytes() {
    let all = |_: u32| format!("{:?}", cut_all(Lattice::Free, 3.3, 4.4, 34.0, &arc()).section.remains());
    assert_eq!(all(0), all(1));
}
