//! Cuts whose outcome is known beforehand.

use rstest::rstest;

use super::super::*;
use super::{check_areas, close, cut, flat, vee};
use crate::planning::tolerance::{KERF_MM, SLIT_OVERRUN_MM};

/// How much higher than the tip the slits of its arms part: what lies below is kerf.
fn lift(swing_deg: f64) -> f64 {
    KERF_MM / 2.0 / swing_deg.to_radians().sin()
}

/// The area of the wedge between two arms up to a height above the tip, without the kerf.
fn wedge(height: f64, swing_deg: f64) -> f64 {
    (height - lift(swing_deg)).powi(2) * swing_deg.to_radians().tan()
}

#[rstest]
#[case(45.0, 6.0, 40.0)]
#[case(34.155, 7.973, 40.0)]
#[case(5.0, 12.0, 8.0)]
#[case(80.0, 9.0, 3.0)]
fn a_v_at_the_surface_frees_its_triangle(#[case] swing: f64, #[case] reach: f64, #[case] tile: f64) {
    let up = reach * swing.to_radians().cos();
    let mut section = Section::new(80.0, 50.0, &flat(80.0, 10.0), 0.0, tile).unwrap();
    let [left, right] = vee(&mut section, 40.0, 50.0 - up, swing, reach);
    assert!(left.chips.is_empty(), "one arm alone frees nothing");
    assert_eq!(right.chips.len(), 1);
    // d^2 sin(alpha) cos(alpha), less what the kerf takes of it.
    close(right.chips[0].area, wedge(up, swing), 1e-6);
    let triangle = reach.powi(2) * swing.to_radians().sin() * swing.to_radians().cos();
    close(right.chips[0].area, triangle, reach * KERF_MM);
    assert_eq!((right.chips[0].freed_by, right.index), (1, 1));
    close(
        right.chips[0].high.x - right.chips[0].low.x,
        2.0 * (up - lift(swing)) * swing.to_radians().tan(),
        1e-6,
    );
    check_areas(&section, &[left, right]);
    assert!(section.remains().stuck.is_empty());
}

#[test]
fn an_arm_that_falls_short_of_the_surface_leaves_its_chip() {
    let mut section = Section::new(80.0, 50.0, &flat(80.0, 10.0), 0.0, 8.0).unwrap();
    let short_by = 2.0 * SLIT_OVERRUN_MM;
    let [left, right] = vee(&mut section, 40.0, 42.0 - short_by, 45.0, 8.0 * 2.0_f64.sqrt());
    assert!(left.chips.is_empty() && right.chips.is_empty());
    assert_eq!(section.remains().stuck, [Point2::new(40.0, 42.0 - short_by)]);
    let longer = [Side::Left, Side::Right]
        .map(|side| section.cut(&cut(40.0, 42.0 - short_by, side, 45.0, 8.1 * 2.0_f64.sqrt())).unwrap());
    assert_eq!((longer[0].chips.len(), longer[1].chips.len()), (0, 1));
    assert!(section.remains().stuck.is_empty());
    close(longer[1].chips[0].area, wedge(8.0 + short_by, 45.0), 1e-6);
    check_areas(&section, &[&[left, right], &longer[..]].concat());
}

#[test]
fn a_chip_that_stayed_leaves_with_the_cut_that_frees_it() {
    let mut section = Section::new(80.0, 50.0, &flat(80.0, 10.0), 0.0, 7.0).unwrap();
    // The first arms end within the stock; those of a tip below take all of it along, first chip and all.
    let mut outcomes = vee(&mut section, 40.0, 44.0, 45.0, 5.0).to_vec();
    assert_eq!(section.remains().stuck.len(), 1);
    outcomes.extend(vee(&mut section, 40.0, 40.0, 45.0, 10.0 * 2.0_f64.sqrt()));
    let chips: Vec<_> = outcomes.iter().flat_map(|outcome| &outcome.chips).collect();
    assert_eq!((chips.len(), chips[0].freed_by), (1, 3));
    close(chips[0].area, wedge(10.0, 45.0), 2.0 * 5.1 * KERF_MM);
    assert!(section.remains().stuck.is_empty());
    check_areas(&section, &outcomes);
}

#[test]
fn overlapping_cuts_free_their_union_once() {
    let mut section = Section::new(80.0, 50.0, &flat(80.0, 10.0), 0.0, 9.0).unwrap();
    let reach = 6.0 * 2.0_f64.sqrt();
    let mut outcomes = vee(&mut section, 40.0, 44.0, 45.0, reach).to_vec();
    outcomes.extend(vee(&mut section, 44.0, 44.0, 45.0, reach));
    let chips: f64 = outcomes.iter().flat_map(|outcome| &outcome.chips).map(|chip| chip.area).sum();
    // Two triangles of 36 that share one of height 4.
    close(chips, 72.0 - 16.0, 3.0 * reach * KERF_MM);
    assert!(chips < 56.0);
    check_areas(&section, &outcomes);
    let again = vee(&mut section, 44.0, 44.0, 45.0, reach);
    assert!(again.iter().all(|outcome| outcome.chips.is_empty()), "{again:?}");
    close(again[0].slit_area + again[1].slit_area, 0.0, 1e-6);
}

#[test]
fn a_cut_in_air_does_nothing() {
    let mut section = Section::new(80.0, 50.0, &flat(80.0, 10.0), 0.0, 9.0).unwrap();
    for (x, z) in [(40.0, 50.01), (-30.0, 20.0), (40.0, 500.0), (110.0, 20.0), (40.0, -30.0)] {
        let outcome = section.cut(&cut(x, z, Side::Right, 30.0, 8.0)).unwrap();
        assert_eq!((outcome.chips.len(), outcome.slit_area), (0, 0.0), "({x}, {z})");
        assert_eq!(outcome.gouge, Gouge::default());
    }
    assert_eq!(section.stock_area(), 80.0 * 50.0);
}

#[test]
fn a_tip_below_the_contour_gouges_by_its_wedge() {
    let (z, deep) = (40.0, 3.0);
    let mut section = Section::new(80.0, 50.0, &flat(80.0, z), 0.0, 9.0).unwrap();
    let outcomes = vee(&mut section, 40.0, z - deep, 40.0, 20.0);
    let remains = section.remains();
    close(remains.gouge_area, wedge(deep, 40.0), 1e-6);
    close(outcomes[1].chips[0].area_of_part, wedge(deep, 40.0), 1e-6);
    close(remains.deepest_gouge, deep, 1e-6);
    assert_eq!(outcomes[0].gouge.tip, deep);
    assert_eq!(outcomes[0].gouge.body, 0.0);
    assert!(outcomes.iter().all(CutOutcome::is_gouge));
    // The slits in the part: each half a kerf inside and outside the arms, less what both share at the tip.
    let both = 2.0 * KERF_MM * deep / 40.0_f64.to_radians().cos();
    close(remains.slit_area_of_part, both, 4.0 * KERF_MM.powi(2));
    close(
        section.profile().part_area() - remains.gouge_area - remains.slit_area_of_part
            + remains.residual_area,
        section.stock_area(),
        1e-6,
    );
}

#[test]
fn a_slit_into_the_part_gouges_by_depth_although_nothing_comes_free() {
    let mut section = Section::new(80.0, 50.0, &flat(80.0, 20.0), 0.0, 9.0).unwrap();
    let outcome = section.cut(&cut(40.0, 15.0, Side::Left, 60.0, 4.0)).unwrap();
    assert_eq!(outcome.gouge.tip, 5.0);
    assert_eq!(outcome.gouge.arm, 5.0);
    assert_eq!(section.remains().gouge_area, 0.0);
    close(outcome.slit_area_of_part, KERF_MM * (4.0 + SLIT_OVERRUN_MM), 1e-6);
}

#[test]
fn arm_and_body_gouge_beside_a_tip_that_does_not() {
    // A tower of 10 by 30 to the right of the tip; the arm enters it, and the body beyond the arm deeper.
    let tower = [(0.0, 10.0), (45.0, 10.0), (45.0, 40.0), (55.0, 40.0), (55.0, 10.0), (80.0, 10.0)];
    let tower = tower.map(|(x, z)| Point2::new(x, z));
    let mut section = Section::new(80.0, 50.0, &tower, 0.0, 9.0).unwrap();
    let reach =
        Reach { cutting: 5.5 * 2.0_f64.sqrt(), edge: 6.0 * 2.0_f64.sqrt(), body: 7.0 * 2.0_f64.sqrt() };
    let cut = Cut { tip: Point2::new(40.0, 20.0), side: Side::Right, swing: 45.0_f64.to_radians(), reach };
    let gouge = section.cut(&cut).unwrap().gouge;
    assert_eq!(gouge.tip, 0.0);
    close(gouge.arm, 0.5, 1e-6);
    close(gouge.body, 2.0, 1e-6);
    assert!(!section.tip_allowed(&cut.tip, cut.swing, &reach));
    assert!(section.tip_allowed(&Point2::new(37.9, 20.0), cut.swing, &reach));
}

#[test]
fn a_tip_or_an_arm_on_the_contour_is_no_gouge() {
    let slope = [(0.0, 5.0), (20.0, 5.0), (40.0, 25.0), (80.0, 25.0)].map(|(x, z)| Point2::new(x, z));
    let mut section = Section::new(80.0, 50.0, &slope, 0.0, 9.0).unwrap();
    // The right arm lies on the slope of 45 degrees, all its length.
    for (x, z) in [(22.0, 7.0), (60.0, 25.0), (20.0, 5.0)] {
        assert!(section.tip_allowed(&Point2::new(x, z), 45.0_f64.to_radians(), &super::short(8.0)));
        let outcomes = vee(&mut section, x, z, 45.0, 8.0);
        assert!(outcomes.iter().all(|outcome| !outcome.is_gouge()), "{outcomes:?}");
    }
    let remains = section.remains();
    assert!(remains.deepest_gouge <= 1e-9 && remains.gouge_area == 0.0, "{remains:?}");
    assert!(remains.slit_area_of_part > KERF_MM / 2.0 * 7.0);
}

#[test]
fn blade_beyond_its_cutting_length_runs_in_stock_by_so_much() {
    let mut section = Section::new(80.0, 50.0, &flat(80.0, 10.0), 0.0, 9.0).unwrap();
    let reach = Reach { cutting: 5.0, edge: 8.0, body: 9.0 };
    let mut cut = Cut { tip: Point2::new(40.0, 20.0), side: Side::Left, swing: 0.5, reach };
    let outcome = section.cut(&cut).unwrap();
    close(outcome.beyond.edge, 3.0 - SLIT_OVERRUN_MM, 1e-6);
    close(outcome.beyond.body, 1.0, 1e-6);
    assert!(outcome.runs_in_stock());
    // With the slit at the surface all that is beyond d is out.
    cut.tip.y = 50.0 - 5.0 * 0.5_f64.cos();
    let outcome = section.cut(&cut).unwrap();
    assert!(!outcome.runs_in_stock(), "{outcome:?}");
    // A trailing edge that reaches less far than the edge adds nothing.
    cut.reach.body = 7.0;
    cut.tip.y = 20.0;
    let outcome = section.cut(&cut).unwrap();
    assert_eq!(outcome.beyond.body, 0.0);
}

#[test]
fn a_valley_to_the_base_parts_the_blank_and_both_halves_stay() {
    let valley = [(0.0, 20.0), (40.0, 0.0), (80.0, 20.0)].map(|(x, z)| Point2::new(x, z));
    let mut section = Section::new(80.0, 30.0, &valley, 0.0, 10.0).unwrap();
    let swing = 50.0;
    assert!(section.tip_allowed(&Point2::new(40.0, 0.0), f64::to_radians(swing), &super::short(70.0)));
    let outcomes = vee(&mut section, 40.0, 0.0, swing, 70.0);
    assert_eq!(outcomes[1].chips.len(), 1);
    close(outcomes[1].chips[0].area, wedge(30.0, swing), 1e-5);
    assert!(outcomes.iter().all(|outcome| !outcome.is_gouge()));
    check_areas(&section, &outcomes);
    let remains = section.remains();
    assert_eq!(remains.surface.len(), 2);
    // Going on below the base is said.
    let below = section.cut(&cut(10.0, -0.5, Side::Left, 10.0, 3.0)).unwrap();
    assert_eq!(below.below_base, 0.5);
}

#[test]
fn whatever_is_cut_off_its_base_leaves_whole() {
    // Two long arms undercut a block across dozens of tiles; it leaves with the second.
    let mut section = Section::new(200.0, 100.0, &flat(200.0, 5.0), 0.0, 4.0).unwrap();
    let first = section.cut(&cut(100.0, 10.0, Side::Left, 70.0, 150.0)).unwrap();
    let second = section.cut(&cut(100.0, 10.0, Side::Right, 70.0, 150.0)).unwrap();
    assert!(first.chips.is_empty());
    assert_eq!(second.chips.len(), 1);
    // Down to the arms, which leave the blank at its sides.
    let rise = 100.0 / 70.0_f64.to_radians().tan();
    close(second.chips[0].area, 200.0 * 90.0 - 100.0 * rise, 2.0 * 110.0 * KERF_MM);
    check_areas(&section, &[first, second]);
    // One so narrow that the kerf covers all of its base leaves nothing at all.
    let mut section = Section::new(1.0, 10.0, &flat(1.0, 0.0), 0.0, 3.0).unwrap();
    let outcome = section.cut(&cut(-0.01, -0.002, Side::Right, 89.8, 3.0)).unwrap();
    assert_eq!((outcome.chips.len(), section.stock_area()), (1, 0.0));
    let remains = section.remains();
    assert_eq!((remains.surface.len(), remains.scallop, remains.residual_area), (0, None, 0.0));
    // A cut that begins at the corner of the base takes off all above it; the sliver below stays.
    let mut section = Section::new(20.0, 10.0, &flat(20.0, 0.0), 0.0, 3.0).unwrap();
    let outcome = section.cut(&cut(-1.0, 0.0, Side::Right, 89.5, 30.0)).unwrap();
    assert_eq!(outcome.chips.len(), 1);
    let (rise, half) = (0.5_f64.to_radians().tan(), KERF_MM / 2.0 / 0.5_f64.to_radians().cos());
    close(section.stock_area(), 20.0 * 11.0 * rise - 20.0 * half, 1e-6);
}

#[test]
fn a_chip_leaves_although_the_cut_that_frees_it_touches_only_its_neighbour() {
    // Tiles of 10 by 10. The second slit covers 9.99 to 10 across: it runs along the border of the chip's tile.
    let mut section = Section::new(20.0, 20.0, &flat(20.0, 1.0), 0.0, 10.0).unwrap();
    let under = section.cut(&cut(9.99, 12.0, Side::Right, 80.0, 11.0)).unwrap();
    let beside = section.cut(&cut(9.995, 11.9, Side::Left, 0.0, 9.0)).unwrap();
    assert_eq!((under.chips.len(), beside.chips.len()), (0, 1));
    let rise = 1.0 / 80.0_f64.to_radians().tan();
    close(beside.chips[0].area, 10.0 * 8.0 - 10.0 * (10.0 / 2.0 + 0.01) * rise, 10.0 * KERF_MM);
    close(beside.chips[0].low.x, 10.0, 1e-6);
    check_areas(&section, &[under, beside]);
}
