//! Against the stock as one polygon, cut by floating-point slits of this file's own: no tiles, no searches.

use i_overlay::core::fill_rule::FillRule;
use i_overlay::core::overlay_rule::OverlayRule;
use i_overlay::float::single::SingleFloatOverlay;
use proptest::prelude::*;

use super::super::*;
use super::{check_areas, cut, flat};
use crate::planning::tolerance::{KERF_MM, SLIT_OVERRUN_MM};

type Shape = Vec<Vec<[f64; 2]>>;

/// The slit of a cut as a rectangle of its own making.
fn slit(cut: &Cut) -> Vec<[f64; 2]> {
    let (sine, cosine) = (cut.side.sign() * cut.swing.sin(), cut.swing.cos());
    let place = |along: f64, aside: f64| {
        [cut.tip.x + along * sine + aside * cosine, cut.tip.y + along * cosine - aside * sine]
    };
    let (length, half) = (cut.reach.cutting + SLIT_OVERRUN_MM, KERF_MM / 2.0);
    vec![place(0.0, -half), place(0.0, half), place(length, half), place(length, -half)]
}

fn area(shape: &Shape) -> f64 {
    let loops = shape.iter().map(|points| {
        let next = points.iter().cycle().skip(1);
        points.iter().zip(next).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum::<f64>() / 2.0
    });
    loops.sum()
}

fn is_on_base(shape: &Shape) -> bool {
    let low = |point: &[f64; 2]| point[1].abs() < 1e-7;
    shape[0]
        .iter()
        .zip(shape[0].iter().cycle().skip(1))
        .any(|(a, b)| low(a) && low(b) && (a[0] - b[0]).abs() > 1e-4)
}

fn minus(shapes: &Vec<Shape>, slits: &Vec<Vec<[f64; 2]>>) -> Vec<Shape> {
    // Nearly parallel slits cross in slivers; only pieces of some size can be compared.
    shapes
        .overlay_as::<i64>(slits, OverlayRule::Difference, FillRule::NonZero)
        .into_iter()
        .filter(|shape| area(shape) > 1e-6)
        .collect()
}

fn blank(width: f64, height: f64) -> Vec<Shape> {
    vec![vec![vec![[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]]]]
}

/// Tips with both of their cuts, most of them near the top; as printed, with four decimals.
fn tips(most: usize) -> impl Strategy<Value = Vec<Cut>> {
    let tip = (-3.0..43.0_f64, 0.5..24.5_f64, 0.0..75.0_f64, 2.0..14.0_f64, any::<bool>());
    prop::collection::vec(tip, 1..most).prop_map(|tips| {
        let printed = |value: f64| (value * 1e4).round() / 1e4;
        let both = |(x, z, swing, reach, back)| {
            let sides = if back { [Side::Right, Side::Left] } else { [Side::Left, Side::Right] };
            sides.map(|side| cut(printed(x), printed(z), side, printed(swing), reach))
        };
        tips.into_iter().flat_map(both).collect()
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn each_cut_frees_what_falls_off_one_polygon(cuts in tips(24), tile in 1.0..30.0_f64) {
        let mut section = Section::new(40.0, 25.0, &flat(40.0, 5.0), 0.0, tile).unwrap();
        let mut stock = blank(40.0, 25.0);
        let mut outcomes = Vec::new();
        for cut in cuts {
            let outcome = section.cut(&cut).unwrap();
            let (left, fallen) = minus(&stock, &vec![slit(&cut)]).into_iter().partition(is_on_base);
            stock = left;
            let mut wanted: Vec<f64> = fallen.iter().map(area).collect();
            let mut found: Vec<f64> = outcome.chips.iter().map(|chip| chip.area).collect();
            found.retain(|&area| area > 2e-6);
            wanted.retain(|&area| area > 2e-6);
            wanted.sort_by(f64::total_cmp);
            found.sort_by(f64::total_cmp);
            prop_assert_eq!(found.len(), wanted.len(), "{:?} {:?} {:?}", found, wanted, cut);
            for (found, wanted) in found.iter().zip(&wanted) {
                prop_assert!((found - wanted).abs() < 1e-5, "{} {}", found, wanted);
            }
            outcomes.push(outcome);
        }
        check_areas(&section, &outcomes);
    }

    /// Whatever the order, what stays is what hangs together with the base when all slits are taken out at once.
    #[test]
    fn the_order_of_cuts_does_not_matter_in_the_end(
        (cuts, order) in tips(60).prop_flat_map(|cuts| {
            let order = Just((0..cuts.len()).collect::<Vec<_>>()).prop_shuffle();
            (Just(cuts), order)
        }),
        tile in 1.0..12.0_f64,
    ) {
        let all = minus(&blank(40.0, 25.0), &cuts.iter().map(slit).collect());
        let wanted: f64 = all.iter().filter(|shape| is_on_base(shape)).map(area).sum();
        for order in [(0..cuts.len()).collect(), order] {
            let mut section = Section::new(40.0, 25.0, &flat(40.0, 5.0), 0.0, tile).unwrap();
            for &index in &order {
                section.cut(&cuts[index]).unwrap();
            }
            let found = section.stock_area();
            prop_assert!((found - wanted).abs() < 1e-4, "{} {}", found, wanted);
        }
    }
}
