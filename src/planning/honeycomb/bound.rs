//! A lower bound of the number of tips (domain.md B3): what no plan with one swing angle can do without.
//!
//! A chip lies above the two arms of its tip, which reach air within d. What it can hold at the most is the rhombus
//! of both arms, d^2 sin(2 alpha). Beside a side face an arm may end in that face; the chip then holds up to half
//! as much again, but only within 2 d sin(alpha) of the face. What may stay is what lies within the scallop limit.

use super::contour::{distance, height};
use super::input::Setting;
use crate::planning::geometry::Point2;

/// The section is measured in so many columns.
const COLUMNS: usize = 400;
/// A height is found to this share of the blank's.
const HALVINGS: u32 = 20;
/// How much more a chip beside a side face may hold.
const BESIDE_A_FACE: f64 = 1.5;

/// The fewest tips that can bring a blank within the scallop limit of its contour.
#[must_use]
pub fn fewest_tips(profile: &[Point2], setting: &Setting) -> u32 {
    let blade = &setting.blade;
    let reach = blade.reach_mm(blade.max_cutting_length.mm());
    // sin(2 alpha) is largest at 45 degrees, or at the limit below that.
    let swing = blade.max_swing.radians();
    let chip = reach * reach * (2.0 * swing.min(std::f64::consts::FRAC_PI_4)).sin();
    let beside = 2.0 * reach * swing.sin();
    let (width, step) = (setting.blank.width_mm, setting.blank.width_mm / COLUMNS as f64);
    let needed: f64 = (0..COLUMNS)
        .map(|column| {
            // Taken where less has to go, so that the bound stays one.
            let edges = [column, column + 1].map(|edge| edge as f64 * step);
            let area =
                edges.map(|x| must_go(x, profile, setting)).into_iter().fold(f64::INFINITY, f64::min) * step;
            let by_a_face = edges[0] < beside || edges[1] > width - beside;
            area / if by_a_face { BESIDE_A_FACE * chip } else { chip }
        })
        .sum();
    needed.ceil() as u32
}

/// How much of the column at x lies farther from the contour than may stay, in mm.
fn must_go(x: f64, profile: &[Point2], setting: &Setting) -> f64 {
    let (top, limit) = (setting.blank.height_mm, setting.process.max_scallop_mm);
    let far = |z: f64| distance(&Point2::new(x, z), profile) > limit;
    if !far(top) {
        return 0.0;
    }
    // Above its contour a column gets farther from it with its height, but for steep walls beside it; the highest
    // place that may stay is then what counts, and it is found from above.
    let (mut low, mut high) = (height(profile, x), top);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if far(middle) { high = middle } else { low = middle }
    }
    top - high
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planning::honeycomb::blade::{Blade, Edges};
    use crate::planning::honeycomb::wire::{Blank, Process};
    use crate::planning::units::{Angle, Length};

    fn table1(max_scallop_mm: f64) -> Setting {
        Setting {
            blank: Blank { width_mm: 85.0, length_mm: 50.0, height_mm: 50.0 },
            blade: Blade {
                rake: Angle::from_degrees(60.0),
                half_apex: Angle::from_degrees(7.13),
                max_cutting_length: Length::from_mm(10.0),
                length: Length::from_mm(10.0),
                max_swing: Angle::from_degrees(50.0),
                edges: Edges::Double,
            },
            process: Process {
                cutting_speed_mm_s: 200.0,
                travel_speed_mm_s: 200.0,
                angular_speed_deg_s: 90.0,
                safety_distance_mm: 10.0,
                max_scallop_mm,
                allowance_mm: 0.0,
            },
        }
    }

    #[test]
    fn a_level_contour_needs_what_its_area_says() {
        let level = [Point2::new(0.0, 10.0), Point2::new(85.0, 10.0)];
        // 85 mm by 30 mm must go; d = 7.972 mm, a chip holds 63.56 mm^2, beside the faces (12.21 mm each) half as
        // much again: 30 (60.58 / 63.56 + 24.42 / 95.34) = 36.3.
        assert_eq!(fewest_tips(&level, &table1(10.0)), 37);
        assert_eq!(fewest_tips(&level, &table1(40.0)), 0);
        // Deep within the part it is as far from the contour as high above it, and none of that has to go.
        let high = [Point2::new(0.0, 39.0), Point2::new(85.0, 39.0)];
        assert_eq!(fewest_tips(&high, &table1(10.0)), 2);
    }

    #[test]
    fn a_tighter_limit_needs_no_fewer_tips() {
        let wavy: Vec<Point2> =
            (0..=85).map(|x| Point2::new(f64::from(x), 15.0 + 4.0 * (f64::from(x) / 7.0).sin())).collect();
        let found: Vec<u32> =
            [12.0, 8.0, 4.0, 1.0].iter().map(|&limit| fewest_tips(&wavy, &table1(limit))).collect();
        assert!(found.windows(2).all(|pair| pair[0] <= pair[1]), "{found:?}");
    }
}
