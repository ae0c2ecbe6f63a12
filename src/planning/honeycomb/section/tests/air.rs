//! Where there is air.

use super::super::*;
use super::{close, cut, flat, short, vee};

fn notched() -> Section {
    let mut section = Section::new(80.0, 50.0, &flat(80.0, 10.0), 0.0, 5.0).unwrap();
    // A notch from 30 to 50 at the top, its tip at (40, 40).
    vee(&mut section, 40.0, 40.0, 45.0, 15.0);
    section
}

fn at(x: f64, z: f64) -> Point2 {
    Point2::new(x, z)
}

#[test]
fn points_are_in_air_outside_on_surfaces_and_in_notches() {
    let section = notched();
    for (x, z) in [
        (40.0, 45.0),
        (-1.0, 20.0),
        (40.0, 50.1),
        (81.0, 3.0),
        (40.0, -1.0),
        (10.0, 50.0),
        (0.0, 25.0),
        (80.0, 25.0),
        (40.0, 40.005),
    ] {
        assert!(section.is_air(&at(x, z)), "({x}, {z})");
    }
    for (x, z) in [(40.0, 39.9), (30.0, 49.0), (5.0, 5.0), (10.0, 20.0), (0.001, 25.0), (40.0, 20.0)] {
        assert!(!section.is_air(&at(x, z)), "({x}, {z})");
    }
    assert!(!section.is_air(&at(f64::NAN, 0.0)) && !section.is_air(&at(0.0, f64::INFINITY)));
}

#[test]
fn points_on_borders_of_tiles_are_no_air() {
    let section = Section::new(80.0, 50.0, &flat(80.0, 10.0), 0.0, 10.0).unwrap();
    for x in 1..8 {
        for z in 1..5 {
            assert!(!section.is_air(&at(f64::from(x) * 10.0, f64::from(z) * 10.0)));
        }
    }
    close(section.length_in_stock(&at(10.0, -5.0), &at(10.0, 60.0)), 50.0, 1e-6);
    close(section.length_in_stock(&at(-5.0, 20.0), &at(100.0, 20.0)), 80.0, 1e-6);
    close(section.length_in_stock(&at(20.0, 20.0), &at(60.0, 40.0)), 2000.0_f64.sqrt(), 1e-6);
}

#[test]
fn lines_run_in_stock_by_so_much() {
    let section = notched();
    let kerf = crate::planning::tolerance::KERF_MM / 2.0 * 2.0_f64.sqrt();
    close(section.length_in_stock(&at(-10.0, 45.0), &at(90.0, 45.0)), 70.0 - 2.0 * kerf, 1e-6);
    close(section.length_in_stock(&at(40.0, 60.0), &at(40.0, 30.0)), 10.0, 0.01);
    close(section.length_in_stock(&at(30.0, 60.0), &at(30.0, 41.0)), 9.0 - kerf, 1e-6);
    assert_eq!(section.length_in_stock(&at(-10.0, 51.0), &at(90.0, 51.0)), 0.0);
    assert_eq!(section.length_in_stock(&at(5.0, 5.0), &at(5.0, 5.0)), 0.0);
    assert!(section.length_in_stock(&at(f64::NAN, 5.0), &at(5.0, 5.0)).is_infinite());
    // Along a surface is air: the top, the sides, and a hair off them.
    for (a, b) in [
        ((0.0, 50.0), (29.0, 50.0)),
        ((0.0, 0.0), (0.0, 50.0)),
        ((80.0, 0.0), (80.0, 50.0)),
        ((0.0, 0.0), (80.0, 0.0)),
    ] {
        assert!(section.segment_in_air(&at(a.0, a.1), &at(b.0, b.1)), "{a:?} {b:?}");
    }
    assert!(section.segment_in_air(&at(40.0, 60.0), &at(40.0, 40.0)));
    assert!(!section.segment_in_air(&at(40.0, 60.0), &at(40.0, 39.0)));
    assert!(!section.segment_in_air(&at(0.001, 0.0), &at(0.001, 50.0)));
}

#[test]
fn a_blade_fits_into_its_own_slit_and_nowhere_else() {
    let mut section = notched();
    let deep = cut(20.0, 30.0, Side::Left, 20.0, 12.0);
    assert!(!section.blade_fits(&deep));
    section.cut(&deep).unwrap();
    assert!(section.blade_fits(&deep));
    // As printed with four decimals, still; a tenth of a mm aside, or with more blade than slit, no more.
    let moved = |x: f64, z: f64| Cut { tip: at(20.0 + x, 30.0 + z), ..deep };
    assert!(section.blade_fits(&moved(0.00005, -0.00005)));
    assert!(!section.blade_fits(&moved(0.1, 0.0)));
    assert!(!section.blade_fits(&Cut { reach: Reach { body: 12.5, ..short(12.0) }, ..deep }));
    assert!(!section.blade_fits(&Cut { side: Side::Right, ..deep }));
    assert!(section.blade_fits(&cut(40.0, 41.0, Side::Right, 30.0, 30.0)));
}
