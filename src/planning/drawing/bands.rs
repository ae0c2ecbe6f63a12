//! Time over layer spacing and swing angle as areas: bands of time with their borders, and what each limit excludes.
//!
//! The grid is cut into rows of one swing angle each; in a row the borders between bands are found by linear
//! interpolation. Rows in which the same bands follow one another are joined into one block, so that borders run
//! on from row to row.

use super::axis::is_shown;
use super::optimum::{Cell, Limit, Row};
use super::sheet::round_step;
use crate::planning::geometry::Point2;

/// The most levels between bands.
const MOST_LEVELS: usize = 9;

/// What a part of the map shows: times between two levels, or what is excluded by a limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Class {
    /// Times that have so many levels below them: 0 is the fastest.
    Band(usize),
    /// Nothing here is within that limit.
    Excluded(Limit),
}

/// Rows in which the same classes follow one another.
#[derive(Debug, Clone, PartialEq)]
pub struct Block {
    /// The classes in rising layer spacing.
    pub classes: Vec<Class>,
    /// Lowest and highest swing angle in degrees.
    pub range: (f64, f64),
    /// For each row its swing angle and its borders: one more than classes, in mm.
    rows: Vec<(f64, Vec<f64>)>,
    /// The borders at the lowest swing angle, and at the highest.
    ends: [Vec<f64>; 2],
}

/// The round times between bands, at most nine, rising. `compared_s` is a time that should lie among them.
#[must_use]
pub fn levels(rows: &[Row], compared_s: Option<f64>) -> Vec<f64> {
    let times = || rows.iter().flat_map(|row| &row.cells).filter_map(|(_, cell)| cell.time());
    let Some((least, most)) = times().map(|t| (t, t)).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))) else {
        return Vec::new();
    };
    // Toward small h times grow without bound: what takes far longer than the compared set is of one band.
    let interesting = 1.2 * compared_s.filter(|time| is_shown(*time)).unwrap_or(0.0).max(2.0 * least);
    let step = round_step((most.min(interesting) - least) / MOST_LEVELS as f64);
    let first = (least / step).floor() + 1.0;
    let levels = (0..MOST_LEVELS).map(|index| (first + index as f64) * step);
    levels.filter(|level| *level < most).collect()
}

/// The blocks of a grid, in rising swing angle. Rows without two places that can be shown are left out.
#[must_use]
pub fn blocks(rows: &[Row], levels: &[f64]) -> Vec<Block> {
    let rows = usable(rows);
    let mut blocks: Vec<Block> = Vec::new();
    for (index, row) in rows.iter().enumerate() {
        let (low, high) = strip(&rows, index);
        let (classes, borders) = runs(row, levels);
        match blocks.last_mut() {
            Some(block) if block.classes == classes => {
                block.range.1 = high;
                block.ends[1].clone_from(&borders);
                block.rows.push((row.swing_angle_deg, borders));
            }
            _ => blocks.push(Block {
                classes,
                range: (low, high),
                ends: [borders.clone(), borders.clone()],
                rows: vec![(row.swing_angle_deg, borders)],
            }),
        }
    }
    for index in 1..blocks.len() {
        let (below, above) = blocks.split_at_mut(index);
        join(&mut below[index - 1], &mut above[0]);
    }
    blocks
}

/// A border between the same two classes in both blocks runs on from one to the other: half way between its last
/// place below and its first above.
fn join(below: &mut Block, above: &mut Block) {
    for (index, pair) in below.classes.windows(2).enumerate() {
        let Some(other) = above.classes.windows(2).position(|candidate| candidate == pair) else { continue };
        let middle = f64::midpoint(below.ends[1][index + 1], above.ends[0][other + 1]);
        (below.ends[1][index + 1], above.ends[0][other + 1]) = (middle, middle);
    }
    for borders in [&mut below.ends[1], &mut above.ends[0]] {
        // A border that ends here must not be overtaken by one that runs on.
        let last = borders[borders.len() - 1];
        let mut least = borders[0];
        for border in borders.iter_mut() {
            least = border.clamp(least, last.max(least));
            *border = least;
        }
    }
}

/// The rows that can be drawn, in rising swing angle, with their places in rising layer spacing.
fn usable(rows: &[Row]) -> Vec<Row> {
    let shown = rows.iter().filter(|row| is_shown(row.swing_angle_deg)).map(|row| {
        let place = |(h, cell): &&(f64, Cell)| is_shown(*h) && cell.is_known();
        let mut cells: Vec<(f64, Cell)> = row.cells.iter().filter(place).copied().collect();
        cells.sort_by(|one, other| one.0.total_cmp(&other.0));
        Row { swing_angle_deg: row.swing_angle_deg, cells }
    });
    let mut rows: Vec<Row> = shown.filter(|row| row.cells.len() > 1).collect();
    rows.sort_by(|one, other| one.swing_angle_deg.total_cmp(&other.swing_angle_deg));
    rows.dedup_by(|one, other| one.swing_angle_deg == other.swing_angle_deg);
    rows
}

/// From where to where a row reaches: half way to its neighbours, and as far on the other side of the first and last.
fn strip(rows: &[Row], index: usize) -> (f64, f64) {
    let alpha = |index: usize| rows[index].swing_angle_deg;
    let half = |from: usize, to: usize| (alpha(to) - alpha(from)) / 2.0;
    let before = if index > 0 { half(index - 1, index) } else { 0.0 };
    let after = if index + 1 < rows.len() { half(index, index + 1) } else { 0.0 };
    let here = alpha(index);
    let low = if index > 0 { before } else { after };
    let high = if index + 1 < rows.len() { after } else { before };
    (here - low, here + high)
}

/// The classes of a row in rising layer spacing, and their borders.
fn runs(row: &Row, levels: &[f64]) -> (Vec<Class>, Vec<f64>) {
    let class = |cell: Cell| match cell {
        Cell::Time(time) => Class::Band(band(time, levels)),
        Cell::Excluded(limit) => Class::Excluded(limit),
    };
    let mut classes = vec![class(row.cells[0].1)];
    let mut borders = vec![row.cells[0].0];
    for pair in row.cells.windows(2) {
        let ((from, one), (to, other)) = (pair[0], pair[1]);
        for (next, share) in crossings(one, other, levels) {
            classes.push(next);
            borders.push(from + share * (to - from));
        }
        let last = class(other);
        if classes.last() != Some(&last) {
            classes.push(last);
            borders.push(f64::midpoint(from, to));
        }
    }
    borders.push(row.cells[row.cells.len() - 1].0);
    (classes, borders)
}

/// The bands that are entered between two places with times, and where, as shares of the way.
fn crossings(one: Cell, other: Cell, levels: &[f64]) -> Vec<(Class, f64)> {
    let (Some(from), Some(to)) = (one.time(), other.time()) else { return Vec::new() };
    let (first, last) = (band(from, levels), band(to, levels));
    let share = |level: usize| share_at(levels[level], from, to);
    if first <= last {
        (first..last).map(|level| (Class::Band(level + 1), share(level))).collect()
    } else {
        (last..first).rev().map(|level| (Class::Band(level), share(level))).collect()
    }
}

/// At which share of the way from one time to another a level between them is passed. Times fall about as a power
/// of layer spacing (Eqs. 8 and 9), so their logarithms are straighter than they.
fn share_at(level: f64, from: f64, to: f64) -> f64 {
    if from > 0.0 && to > 0.0 { (level / from).ln() / (to / from).ln() } else { (level - from) / (to - from) }
}

fn band(time: f64, levels: &[f64]) -> usize {
    levels.partition_point(|level| *level <= time)
}

impl Block {
    /// The outline of one of its classes, (h, alpha) in mm and degrees.
    #[must_use]
    pub fn outline(&self, index: usize) -> Vec<Point2> {
        let mut outline = self.border(index);
        outline.extend(self.border(index + 1).into_iter().rev());
        outline
    }

    /// A border from the lowest swing angle to the highest.
    #[must_use]
    pub fn border(&self, index: usize) -> Vec<Point2> {
        let at = |h: f64, alpha: f64| Point2::new(h, alpha);
        let mut border = vec![at(self.ends[0][index], self.range.0)];
        border.extend(self.rows.iter().map(|(alpha, borders)| at(borders[index], *alpha)));
        border.push(at(self.ends[1][index], self.range.1));
        border
    }

    /// The middle of one of its classes and how wide it is there.
    #[must_use]
    pub fn middle(&self, index: usize) -> (Point2, f64) {
        let (alpha, borders) = &self.rows[self.rows.len() / 2];
        let (low, high) = (borders[index], borders[index + 1]);
        (Point2::new(f64::midpoint(low, high), *alpha), high - low)
    }

    /// From which h to which h different classes meet at the edge between this block and the next, and which.
    #[must_use]
    pub fn edges(&self, above: &Self) -> Vec<((f64, f64), [Class; 2])> {
        let (lower, upper) = (&self.ends[1], &above.ends[0]);
        let mut edges = Vec::new();
        for (index, class) in self.classes.iter().enumerate() {
            for (other, other_class) in above.classes.iter().enumerate() {
                let stretch = (lower[index].max(upper[other]), lower[index + 1].min(upper[other + 1]));
                if class != other_class && stretch.0 < stretch.1 {
                    edges.push((stretch, [*class, *other_class]));
                }
            }
        }
        edges
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(swing_angle_deg: f64, cells: &[(f64, Cell)]) -> Row {
        Row { swing_angle_deg, cells: cells.to_vec() }
    }

    #[test]
    fn borders_lie_where_the_levels_are() {
        use Cell::{Excluded, Time};
        let over = Excluded(Limit::Scallop);
        let rows = [
            row(10.0, &[(1.0, Time(100.0)), (2.0, Time(400.0)), (3.0, over)]),
            row(12.0, &[(1.0, over), (3.0, over)]),
        ];
        let found = blocks(&rows, &[150.0, 250.0]);
        let wanted = [Class::Band(0), Class::Band(1), Class::Band(2), Class::Excluded(Limit::Scallop)];
        assert_eq!(found[0].classes, wanted);
        let h = |index: usize| found[0].border(index)[1].x;
        assert!((h(1) - (1.0 + 1.5_f64.ln() / 4.0_f64.ln())).abs() < 1e-12 && h(2) > h(1) && h(2) < 2.0);
        assert_eq!((h(0), h(3), h(4)), (1.0, 2.5, 3.0));
        assert_eq!((found[0].range, found[1].range), ((9.0, 11.0), (11.0, 13.0)));
        assert_eq!(found[0].edges(&found[1]).len(), 3, "each band ends below what is excluded");
    }

    #[test]
    fn a_border_runs_on_where_another_ends() {
        use Cell::{Excluded, Time};
        let limit = Excluded(Limit::CuttingLength);
        let rows = [
            row(1.0, &[(0.0, Time(100.0)), (4.0, Time(300.0)), (4.2, limit), (5.0, limit)]),
            row(2.0, &[(0.0, Time(100.0)), (3.0, Time(180.0)), (3.2, limit), (5.0, limit)]),
        ];
        let found = blocks(&rows, &[200.0]);
        assert_eq!(found.len(), 2, "the band above 200 s is gone");
        let (below, above) = (found[0].border(2), found[1].border(1));
        assert_eq!((below[0].x, above[2].x), (4.1, 3.1));
        assert_eq!(below[2], Point2::new(4.1, 1.5), "no limit between the same two bands above");
        let rows = [
            rows[0].clone(),
            row(2.0, &[(0.0, Time(300.0)), (3.0, Time(300.0)), (3.2, limit), (5.0, limit)]),
        ];
        let found = blocks(&rows, &[200.0]);
        let (below, above) = (found[0].border(2), found[1].border(1));
        assert!((below[2] - Point2::new(3.6, 1.5)).norm() < 1e-12 && below[2] == above[0]);
    }

    #[test]
    fn falling_times_cross_the_levels_backward() {
        let rows = [row(1.0, &[(0.0, Cell::Time(300.0)), (10.0, Cell::Time(100.0))])];
        let found = blocks(&rows, &[150.0, 250.0]);
        assert_eq!(found[0].classes, [Class::Band(2), Class::Band(1), Class::Band(0)]);
        let place = |level: f64| 10.0 * (300.0 / level).ln() / 3.0_f64.ln();
        let borders = [1, 2].map(|index| found[0].border(index)[0].x);
        assert!((borders[0] - place(250.0)).abs() < 1e-9 && (borders[1] - place(150.0)).abs() < 1e-9);
    }

    #[test]
    fn levels_are_round_few_and_between_the_times() {
        let rows = [row(1.0, &[(0.5, Cell::Time(9000.0)), (4.0, Cell::Time(307.6))])];
        let found = levels(&rows, Some(515.3));
        assert_eq!(found, [350.0, 400.0, 450.0, 500.0, 550.0, 600.0, 650.0, 700.0, 750.0]);
        assert!(levels(&[], None).is_empty());
        let level = [row(1.0, &[(0.5, Cell::Time(5.0)), (4.0, Cell::Time(5.0))])];
        assert!(levels(&level, Some(f64::NAN)).is_empty());
    }

    #[test]
    fn what_is_no_number_is_left_out() {
        let rows = [
            row(f64::NAN, &[(1.0, Cell::Time(1.0)), (2.0, Cell::Time(2.0))]),
            row(1.0, &[(f64::INFINITY, Cell::Time(1.0)), (1.0, Cell::Time(f64::NAN))]),
        ];
        assert!(blocks(&rows, &[]).is_empty());
    }
}
