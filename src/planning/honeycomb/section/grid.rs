//! The grid of whole numbers on which the stock is kept, and its tiles.
//!
//! One unit is 2^-26 mm everywhere, whatever the blank: every tile rounds a crossing alike, and no scale is
//! derived from data. Coordinates of the largest blank (100 m) take 43 of the 61 bits that the overlay allows.

use i_overlay::i_float::int::point::IntPoint;

use crate::planning::geometry::Point2;

/// A point of the grid.
pub(super) type GridPoint = IntPoint<i64>;

/// Units a mm.
pub(super) const UNITS: f64 = (1_i64 << 26) as f64;

/// The grid's point nearest to a place in mm.
pub(super) fn snapped(point: &Point2) -> GridPoint {
    GridPoint::new(units(point.x), units(point.y))
}

/// A length in whole units.
pub(super) fn units(mm: f64) -> i64 {
    (mm * UNITS).round() as i64
}

/// A point of the grid in mm.
pub(super) fn placed(point: GridPoint) -> Point2 {
    Point2::new(point.x as f64 / UNITS, point.y as f64 / UNITS)
}

/// The tiles of a blank: columns and rows of equal rectangles, to a unit.
#[derive(Debug, Clone)]
pub(super) struct Grid {
    /// x of the borders between columns, from 0 to the width, in units.
    columns: Vec<i64>,
    /// z of the borders between rows, from 0 to the height, in units.
    rows: Vec<i64>,
}

/// The corners of a rectangle on the grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Frame {
    pub low: GridPoint,
    pub high: GridPoint,
}

/// No more tiles than this on a side: with short blades on huge blanks tiles grow rather than fill the memory.
const MOST_TILES: f64 = 256.0;

impl Grid {
    /// Tiles of about `size` mm on a blank of `width` by `height` mm.
    pub(super) fn new(width: f64, height: f64, size: f64) -> Self {
        let borders = |length: f64| {
            let count = (length / size).round().clamp(1.0, MOST_TILES);
            (0..=count as i64).map(|index| units(length * (index as f64 / count))).collect()
        };
        Self { columns: borders(width), rows: borders(height) }
    }

    pub(super) fn tiles(&self) -> usize {
        self.columns() * (self.rows.len() - 1)
    }

    fn columns(&self) -> usize {
        self.columns.len() - 1
    }

    /// The whole blank.
    pub(super) fn blank(&self) -> Frame {
        let last = |borders: &[i64]| borders[borders.len() - 1];
        Frame { low: GridPoint::new(0, 0), high: GridPoint::new(last(&self.columns), last(&self.rows)) }
    }

    pub(super) fn frame(&self, tile: usize) -> Frame {
        let (column, row) = (tile % self.columns(), tile / self.columns());
        Frame {
            low: GridPoint::new(self.columns[column], self.rows[row]),
            high: GridPoint::new(self.columns[column + 1], self.rows[row + 1]),
        }
    }

    /// The tile beyond a border of a tile.
    pub(super) fn beyond(&self, tile: usize, border: Border) -> Option<usize> {
        let columns = self.columns();
        let column = tile % columns;
        match border {
            Border::Left => (column > 0).then(|| tile - 1),
            Border::Right => (column + 1 < columns).then_some(tile + 1),
            Border::Bottom => tile.checked_sub(columns),
            Border::Top => Some(tile + columns).filter(|&above| above < self.tiles()),
        }
    }

    /// The tile that holds a point of the grid; on a border the one to its right or above it.
    pub(super) fn tile_at(&self, point: GridPoint) -> Option<usize> {
        let Frame { low, high } = self.blank();
        if point.x < low.x || point.y < low.y || point.x >= high.x || point.y >= high.y {
            return None;
        }
        Some(index_at(&self.rows, point.y) * self.columns() + index_at(&self.columns, point.x))
    }

    /// Whether a point lies where two tiles meet.
    pub(super) fn is_on_border(&self, point: GridPoint) -> bool {
        let is_inner = |borders: &[i64], coordinate: i64| {
            borders[1..borders.len() - 1].binary_search(&coordinate).is_ok()
        };
        is_inner(&self.columns, point.x) || is_inner(&self.rows, point.y)
    }

    /// The tiles that a line from `a` to `b` comes closer to than `margin` units, in a fixed order.
    pub(super) fn tiles_along(&self, a: GridPoint, b: GridPoint, margin: i64) -> Vec<usize> {
        let (a, b) = if a.x <= b.x { (a, b) } else { (b, a) };
        let mut tiles = Vec::new();
        for column in range(&self.columns, a.x - margin, b.x + margin) {
            let (left, right) = (self.columns[column] - margin, self.columns[column + 1] + margin);
            let (low, high) = heights(a, b, left, right);
            let rows = range(&self.rows, low - margin, high + margin);
            tiles.extend(rows.map(|row| row * self.columns() + column));
        }
        tiles
    }
}

/// A border of a tile.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Border {
    Left,
    Right,
    Bottom,
    Top,
}

impl Border {
    pub(super) const ALL: [Self; 4] = [Self::Left, Self::Right, Self::Bottom, Self::Top];

    /// The same border seen from beyond it.
    pub(super) fn opposite(self) -> Self {
        match self {
            Self::Left => Self::Right,
            Self::Right => Self::Left,
            Self::Bottom => Self::Top,
            Self::Top => Self::Bottom,
        }
    }
}

/// Which interval between borders holds a coordinate.
fn index_at(borders: &[i64], coordinate: i64) -> usize {
    borders.partition_point(|&border| border <= coordinate).clamp(1, borders.len() - 1) - 1
}

/// The intervals between borders that meet a closed range.
fn range(borders: &[i64], from: i64, to: i64) -> std::ops::Range<usize> {
    let (first, last) = (borders[0], borders[borders.len() - 1]);
    if to < first || from > last {
        return 0..0;
    }
    index_at(borders, from)..index_at(borders, to) + 1
}

/// Lowest and highest z of a line from left to right between two x, to a unit.
fn heights(a: GridPoint, b: GridPoint, left: i64, right: i64) -> (i64, i64) {
    let at = |x: i64| {
        let x = x.clamp(a.x, b.x);
        if a.x == b.x {
            return a.y;
        }
        a.y + ((b.y - a.y) as f64 * ((x - a.x) as f64 / (b.x - a.x) as f64)).round() as i64
    };
    if a.x == b.x {
        return (a.y.min(b.y), a.y.max(b.y));
    }
    let (one, other) = (at(left), at(right));
    (one.min(other) - 1, one.max(other) + 1)
}
