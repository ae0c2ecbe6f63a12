//! What is refused, and what must be survived.

use rstest::rstest;

use super::super::*;
use super::{check_areas, cut, flat, short, vee};

#[rstest]
#[case::nothing(&[], "0 points")]
#[case::one_point(&[(0.0, 5.0)], "1 points")]
#[case::falling(&[(0.0, 5.0), (50.0, 5.0), (40.0, 5.0), (80.0, 5.0)], "point 2 of the profile: x falls from 50 to 40")]
#[case::below(&[(0.0, 5.0), (80.0, -1.0)], "point 1 of the profile: (80, -1)")]
#[case::above(&[(0.0, 5.0), (80.0, 50.001)], "from 0 to 50")]
#[case::no_number(&[(0.0, 5.0), (f64::NAN, 5.0), (80.0, 5.0)], "point 1")]
#[case::infinite(&[(0.0, 5.0), (80.0, f64::INFINITY)], "point 1")]
#[case::short(&[(0.0, 5.0), (79.0, 5.0)], "from x = 0 to 79")]
#[case::late(&[(1.0, 5.0), (80.0, 5.0)], "from x = 1 to 80")]
fn profiles_are_refused_with_place_and_limit(#[case] points: &[(f64, f64)], #[case] said: &str) {
    let points: Vec<Point2> = points.iter().map(|&(x, z)| Point2::new(x, z)).collect();
    let fault = Section::new(80.0, 50.0, &points, 0.0, 8.0).unwrap_err().to_string();
    assert!(fault.contains(said), "{fault}");
}

#[rstest]
#[case(f64::NAN, 50.0, 0.0, 8.0, "the width of the blank in mm is NaN")]
#[case(0.0, 50.0, 0.0, 8.0, "width")]
#[case(1e9, 50.0, 0.0, 8.0, "from 1 to 100000")]
#[case(80.0, f64::INFINITY, 0.0, 8.0, "height")]
#[case(80.0, 50.0, -0.1, 8.0, "the allowance in mm is -0.1")]
#[case(80.0, 50.0, f64::NAN, 8.0, "allowance")]
#[case(80.0, 50.0, 0.0, 0.0, "reach")]
fn blanks_are_refused_with_their_limit(
    #[case] width: f64,
    #[case] height: f64,
    #[case] allowance: f64,
    #[case] reach: f64,
    #[case] said: &str,
) {
    let fault = Section::new(width, height, &flat(80.0, 5.0), allowance, reach).unwrap_err().to_string();
    assert!(fault.contains(said), "{fault}");
}

#[test]
fn cuts_that_no_blade_makes_are_refused_and_change_nothing() {
    let mut section = Section::new(80.0, 50.0, &flat(80.0, 10.0), 0.0, 8.0).unwrap();
    let good = cut(40.0, 45.0, Side::Left, 30.0, 8.0);
    let bad = [
        Cut { tip: Point2::new(f64::NAN, 45.0), ..good },
        Cut { tip: Point2::new(40.0, 1e7), ..good },
        Cut { swing: -0.1, ..good },
        Cut { swing: 1.57, ..good },
        Cut { swing: f64::NAN, ..good },
        Cut { reach: short(0.0), ..good },
        Cut { reach: Reach { body: f64::INFINITY, ..short(8.0) }, ..good },
    ];
    for cut in bad {
        assert!(matches!(section.cut(&cut), Err(SectionFault::OutOfRange { .. })), "{cut:?}");
    }
    assert_eq!(section.stock_area(), 4000.0);
    assert_eq!(section.cut(&good).unwrap().index, 0);
}

#[test]
fn tips_that_are_no_numbers_are_not_allowed() {
    let section = Section::new(80.0, 50.0, &flat(80.0, 10.0), 0.0, 8.0).unwrap();
    for tip in [Point2::new(f64::NAN, 20.0), Point2::new(20.0, f64::NAN), Point2::new(f64::INFINITY, 20.0)] {
        assert!(!section.tip_allowed(&tip, 0.5, &short(8.0)), "{tip}");
    }
    assert!(!section.tip_allowed(&Point2::new(20.0, 20.0), f64::NAN, &short(8.0)));
    assert!(!section.tip_allowed(&Point2::new(20.0, 20.0), 0.5, &short(f64::NAN)));
}

/// A needle a thousandth wide, walls, a dip to the base, contour at the top of the blank, repeated points, a fin.
fn harsh() -> Vec<Point2> {
    let points = [
        (0.0, 0.0),
        (0.0, 50.0),
        (4.0, 50.0),
        (4.0, 12.0),
        (9.9995, 12.0),
        (10.0, 45.0),
        (10.0005, 12.0),
        (20.0, 12.0),
        (20.0, 12.0),
        (25.0, 0.0),
        (25.0, 0.0),
        (30.0, 0.0),
        (30.0, 30.0),
        (30.0, 5.0),
        (50.0, 5.0),
        (50.0, 40.0),
        (50.0, 20.0),
        (79.0, 20.0),
        (79.0, 0.0),
        (80.0, 0.0),
        (80.0, 50.0),
    ];
    points.map(|(x, z)| Point2::new(x, z)).to_vec()
}

#[test]
fn a_harsh_profile_is_borne() {
    let mut section = Section::new(80.0, 50.0, &harsh(), 0.0, 6.0).unwrap();
    assert_eq!(section.profile().height(10.0), 45.0);
    // Fins and slots of no width are no material and no room.
    assert_eq!(section.profile().height(30.0), 5.0);
    let mut outcomes = Vec::new();
    for layer in 1..25_u32 {
        for column in 0..=20_u32 {
            let (x, z) = (f64::from(column) * 4.0, 50.0 - f64::from(layer) * 2.0);
            if section.tip_allowed(&Point2::new(x, z), 45.0_f64.to_radians(), &short(6.0)) {
                outcomes.extend(vee(&mut section, x, z, 45.0, 6.0));
            }
        }
    }
    assert!(outcomes.len() > 300, "{}", outcomes.len());
    assert!(outcomes.iter().all(|outcome| !outcome.is_gouge()));
    check_areas(&section, &outcomes);
    let remains = section.remains();
    assert_eq!(remains.gouge_area, 0.0);
    assert!(remains.scallop.is_some());
}

#[test]
fn a_hundred_thousand_points_are_borne() {
    let wave = |i: u32| {
        let x = f64::from(i) * 80.0 / 100_000.0;
        Point2::new(x, 10.0 + (x * 0.3).sin() * 4.0 + (x * 900.0).sin() * 0.001)
    };
    let profile: Vec<Point2> = (0..=100_000).map(wave).collect();
    let mut section = Section::new(80.0, 50.0, &profile, 0.0, 12.0).unwrap();
    let mut outcomes = Vec::new();
    for column in 1..16_u32 {
        for z in [42.0, 34.0] {
            outcomes.extend(vee(&mut section, f64::from(column) * 5.0, z, 30.0, 12.0));
        }
    }
    check_areas(&section, &outcomes);
    let remains = section.remains();
    // The top beside the cuts stands off the contour by most.
    assert!((30.0..50.0).contains(&remains.scallop.unwrap().distance), "{:?}", remains.scallop);
    assert!((section.stock_area() - section.profile().part_area() - remains.residual_area).abs() < 1e-6);
}
