//! Against a raster of small cells, flooded anew after each cut: a slow reference that is right within its bounds.
//!
//! Two rasters close the stock in. The lower one drops every cell that a slit touches and walks over sides of cells:
//! what it keeps is stock. The upper one drops only cells that lie in a slit entirely and walks over corners too:
//! what is stock lies in it. With cells of a quarter of a kerf both find the same chips, unless slits miss each
//! other by less than a cell.

use proptest::prelude::*;

use super::super::*;
use super::{check_areas, flat, short};
use crate::planning::tolerance::{KERF_MM, SLIT_OVERRUN_MM};

const CELL: f64 = KERF_MM / 4.0;
/// A blank of 1 by 1 mm, the smallest that is taken.
const COLUMNS: usize = 400;
const ROWS: usize = 400;

/// Cells in a row of memory: a column on either side and a row above and below are never kept.
const STRIDE: usize = COLUMNS + 2;

struct Raster {
    kept: Vec<bool>,
    /// How much more than the slit of a cut is dropped on every side, in mm.
    grown: f64,
    /// From a cell to those that it is walked to.
    steps: &'static [isize],
}

const SIDES: &[isize] = &[-1, 1, -(STRIDE as isize), STRIDE as isize];
const CORNERS_TOO: &[isize] = &[
    -1,
    1,
    -(STRIDE as isize),
    STRIDE as isize,
    -(STRIDE as isize) - 1,
    1 - (STRIDE as isize),
    STRIDE as isize - 1,
    STRIDE as isize + 1,
];

impl Raster {
    fn new(grown: f64, steps: &'static [isize]) -> Self {
        let inside = |index: usize, most: usize| (1..=most).contains(&index);
        let cells = 0..STRIDE * (ROWS + 2);
        let kept = cells.map(|cell| inside(cell % STRIDE, COLUMNS) && inside(cell / STRIDE, ROWS));
        Self { kept: kept.collect(), grown, steps }
    }

    fn cut(&mut self, cut: &Cut) {
        let (sine, cosine) = (cut.side.sign() * cut.swing.sin(), cut.swing.cos());
        let length = cut.reach.cutting + SLIT_OVERRUN_MM;
        for (cell, kept) in self.kept.iter_mut().enumerate() {
            let x = ((cell % STRIDE) as f64 - 0.5) * CELL - cut.tip.x;
            let z = ((cell / STRIDE) as f64 - 0.5) * CELL - cut.tip.y;
            let (along, aside) = (x * sine + z * cosine, x * cosine - z * sine);
            let inside = (-self.grown..=length + self.grown).contains(&along);
            *kept &= !inside || aside.abs() > KERF_MM / 2.0 + self.grown;
        }
        self.flood();
    }

    fn flood(&mut self) {
        let mut reached = vec![false; self.kept.len()];
        let mut open: Vec<usize> = (STRIDE..2 * STRIDE).filter(|&cell| self.kept[cell]).collect();
        open.iter().for_each(|&cell| reached[cell] = true);
        while let Some(cell) = open.pop() {
            for &step in self.steps {
                let next = cell.wrapping_add_signed(step);
                if self.kept[next] && !reached[next] {
                    reached[next] = true;
                    open.push(next);
                }
            }
        }
        self.kept = reached;
    }

    fn area(&self) -> f64 {
        self.kept.iter().filter(|&&kept| kept).count() as f64 * CELL * CELL
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 8, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn the_stock_lies_between_both_rasters_after_every_cut(
        tile in 0.06..0.6_f64,
        cuts in prop::collection::vec(
            (-0.1..1.1_f64, 0.3..1.0_f64, any::<bool>(), 0.0..80.0_f64, 0.1..0.7_f64), 1..12
        ),
    ) {
        let mut section = Section::new(1.0, 1.0, &flat(1.0, 0.0), 0.0, tile).unwrap();
        let mut outcomes = Vec::new();
        let (mut lower, mut upper) = (Raster::new(0.75 * CELL, SIDES), Raster::new(-0.75 * CELL, CORNERS_TOO));
        for (x, z, right, swing, reach) in cuts {
            let side = if right { Side::Right } else { Side::Left };
            let cut = Cut { tip: Point2::new(x, z), side, swing: swing.to_radians(), reach: short(reach) };
            // Both arms of a tip, so that something comes free.
            for side in [side, if right { Side::Left } else { Side::Right }] {
                let cut = Cut { side, ..cut };
                outcomes.push(section.cut(&cut).unwrap());
                lower.cut(&cut);
                upper.cut(&cut);
                let area = section.stock_area();
                let bounds = [lower.area(), upper.area()];
                prop_assert!(bounds[0] - 1e-9 <= area && area <= bounds[1] + 1e-9, "{:?} {}", bounds, area);
            }
        }
        check_areas(&section, &outcomes);
    }
}
