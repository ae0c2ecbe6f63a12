//! Many polylines as straight pieces in a grid, so that what is near is found without looking at all of them.

use super::nearness::Segment;

/// No cell of the grid is smaller than this, in mm: it is far more than the radii of most questions, so that
/// these touch a few cells only.
const SMALLEST_CELL_MM: f64 = 0.25;

/// Nothing that lies farther out than this, in mm, is on any machine; it gets no place in the grid.
pub(super) const FARTHEST_MM: f64 = 1e7;

/// A cell takes in what passes it at this part of its size, so that rounding cannot put a point into no cell.
const CELL_MARGIN: f64 = 1e-6;

/// A straight piece of a curve.
#[derive(Debug, Clone, Copy)]
pub(super) struct Piece {
    /// Its ends; they differ.
    pub(super) ends: Segment,
    /// The curve of which it is a piece.
    pub(super) curve: usize,
    /// Which step of that curve it is, from 0.
    pub(super) step: usize,
    /// Whether it begins where another piece of the same curve ends (the last one for a closed curve's first).
    pub(super) joined: bool,
}

/// A piece that cannot be placed.
#[derive(Debug, Clone, Copy)]
pub(super) struct Misplaced {
    /// The curve of which it is a piece.
    pub(super) curve: usize,
    /// Which step of that curve it is, from 0.
    pub(super) step: usize,
    /// Its length in mm, bounded.
    pub(super) length_mm: f64,
}

/// Polylines.
pub(super) struct Curves {
    /// All pieces, curve by curve in order.
    pub(super) pieces: Vec<Piece>,
    /// What is too far out, or not finite.
    pub(super) misplaced: Vec<Misplaced>,
    cell_mm: f64,
    /// Cell and piece, sorted.
    cells: Vec<(Cell, u32)>,
}

/// Column (by r) and row (by v) of a cell.
type Cell = (i32, i32);

impl Curves {
    /// Takes over polylines of points (r, v) in mm. Points repeated in a row count once.
    pub(super) fn of<'a>(polylines: impl Iterator<Item = &'a [[f64; 2]]>) -> Self {
        let mut curves =
            Self { pieces: Vec::new(), misplaced: Vec::new(), cell_mm: SMALLEST_CELL_MM, cells: Vec::new() };
        for (curve, points) in polylines.enumerate() {
            curves.add(curve, points);
        }
        curves.fill_cells();
        curves
    }

    fn add(&mut self, curve: usize, points: &[[f64; 2]]) {
        // A closed curve's first piece joins its last.
        let mut joined = points.len() > 2 && points.first() == points.last();
        for (step, ends) in points.windows(2).enumerate() {
            let (a, b) = (ends[0], ends[1]);
            if ![a, b].iter().flatten().all(|coordinate| coordinate.abs() <= FARTHEST_MM) {
                // `min` takes the bound if the length is not a number.
                let length_mm = (b[0] - a[0]).hypot(b[1] - a[1]).min(FARTHEST_MM);
                self.misplaced.push(Misplaced { curve, step, length_mm });
                joined = false;
            } else if a != b {
                self.pieces.push(Piece { ends: [a, b], curve, step, joined });
                joined = true;
            }
        }
    }

    /// Cells as large as the pieces are on average hold a few of them each.
    fn fill_cells(&mut self) {
        let length = |[a, b]: Segment| (b[0] - a[0]).hypot(b[1] - a[1]);
        let total_mm: f64 = self.pieces.iter().map(|piece| length(piece.ends)).sum();
        self.cell_mm = (total_mm / self.pieces.len().max(1) as f64).max(SMALLEST_CELL_MM);
        for (index, piece) in self.pieces.iter().enumerate() {
            let index = u32::try_from(index).expect("no plan has four thousand million pieces");
            let cells = &mut self.cells;
            cells_within(piece.ends, CELL_MARGIN * self.cell_mm, self.cell_mm, |column, low, high| {
                cells.extend((low..=high).map(|row| ((column, row), index)));
            });
        }
        self.cells.sort_unstable();
    }

    /// Writes the places in `pieces` of everything that may lie within a radius of a segment, and maybe more,
    /// in order into `found`.
    pub(super) fn near(&self, segment: Segment, radius: f64, found: &mut Vec<u32>) {
        found.clear();
        cells_within(segment, radius + CELL_MARGIN * self.cell_mm, self.cell_mm, |column, low, high| {
            let start = self.cells.partition_point(|(cell, _)| *cell < (column, low));
            let column = self.cells[start..].iter().take_while(|(cell, _)| *cell <= (column, high));
            found.extend(column.map(|(_, piece)| *piece));
        });
        found.sort_unstable();
        found.dedup();
    }
}

/// Calls `take` with each column and its lowest and highest row that a segment comes within a radius of.
fn cells_within([a, b]: Segment, radius: f64, cell_mm: f64, mut take: impl FnMut(i32, i32, i32)) {
    let (a, b) = if a[0] <= b[0] { (a, b) } else { (b, a) };
    // Coordinates are bounded by FARTHEST_MM and cells by SMALLEST_CELL_MM, so that a cell's number fits.
    let number = |coordinate: f64| (coordinate / cell_mm).floor() as i32;
    let slope = if b[0] > a[0] { (b[1] - a[1]) / (b[0] - a[0]) } else { 0.0 };
    let v_at = |r: f64| (a[1] + slope * (r - a[0])).clamp(a[1].min(b[1]), a[1].max(b[1]));
    for column in number(a[0] - radius)..=number(b[0] + radius) {
        let left = (f64::from(column) * cell_mm - radius).clamp(a[0], b[0]);
        let right = (f64::from(column + 1) * cell_mm + radius).clamp(a[0], b[0]);
        let (one, other) = if slope == 0.0 { (a[1], b[1]) } else { (v_at(left), v_at(right)) };
        take(column, number(one.min(other) - radius), number(one.max(other) + radius));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planning::program::replay::nearness::Probe;

    proptest::proptest! {
        #[test]
        fn nothing_near_is_missed(
            points in proptest::collection::vec([-9.0..9.0f64, -9.0..9.0f64], 2..40),
            a in [-9.0..9.0f64, -9.0..9.0f64], b in [-9.0..9.0f64, -9.0..9.0f64], radius in 0.001..3.0f64,
        ) {
            let curves = Curves::of(std::iter::once(points.as_slice()));
            let mut found = Vec::new();
            curves.near([a, b], radius, &mut found);
            for (index, piece) in curves.pieces.iter().enumerate() {
                let near = Probe::along([a, b]).near_segment(piece.ends, radius).is_some();
                proptest::prop_assert!(!near || found.contains(&(index as u32)));
            }
        }
    }

    #[test]
    fn pieces_know_what_they_join() {
        let closed = [[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 0.0]];
        let broken = [[0.0, 0.0], [1.0, 0.0], [f64::NAN, 0.0], [2.0, 0.0], [3.0, 0.0]];
        let curves = Curves::of([closed.as_slice(), &broken].into_iter());
        let joined: Vec<_> = curves.pieces.iter().map(|piece| (piece.step, piece.joined)).collect();
        assert_eq!(joined, [(0, true), (2, true), (3, true), (0, false), (3, false)]);
        assert_eq!(curves.misplaced.iter().map(|piece| piece.step).collect::<Vec<_>>(), [1, 2]);
        assert!(curves.misplaced.iter().all(|piece| piece.length_mm == FARTHEST_MM));
    }

    #[test]
    fn a_grid_stays_as_large_as_its_curves() {
        let across: Vec<_> = (0..20_000).map(|i| [0.0, f64::from(i) * 0.01]).collect();
        let along = [[-50_000.0, 3.0], [50_000.0, 3.0]];
        let curves = Curves::of([across.as_slice(), &along].into_iter());
        assert!(curves.cells.len() < 4 * curves.pieces.len(), "{}", curves.cells.len());
    }
}
