//! The stock as pieces within tiles, and what a slit does to it.

use super::flood::Marks;
use super::grid::{Border, Frame, Grid, GridPoint, units};
use super::knife::Knife;
use super::piece::{Piece, cross, edges_of};
use crate::planning::tolerance::KERF_MM;

/// All that is left of the blank, all of it connected to the base.
#[derive(Debug, Clone)]
pub(super) struct Stock {
    pub grid: Grid,
    /// By tile, its pieces.
    tiles: Vec<Vec<usize>>,
    /// Pieces by number; numbers are used again.
    pieces: Vec<Option<Piece>>,
    free: Vec<usize>,
    /// How many pieces reach the base.
    pub(super) on_base: usize,
    pub(super) marks: Marks,
    knife: Knife,
}

/// What a slit has done.
#[derive(Debug)]
pub(super) struct Parted {
    /// The pieces that it cut, as they were.
    pub before: Vec<Piece>,
    /// What has become of them.
    pub after: Vec<usize>,
    /// The pieces that lay beside them, which may have lost their hold.
    pub beside: Vec<usize>,
}

impl Stock {
    /// The whole blank.
    pub(super) fn new(grid: Grid) -> Self {
        let count = grid.tiles();
        let mut stock = Self {
            grid,
            tiles: vec![Vec::new(); count],
            pieces: Vec::with_capacity(count),
            free: Vec::new(),
            on_base: 0,
            marks: Marks::default(),
            knife: Knife::new(),
        };
        for tile in 0..count {
            stock.add(Piece::whole(tile, stock.grid.frame(tile)));
        }
        stock
    }

    /// Takes a slit out of the stock, and whatever is too small for the grid with it.
    pub(super) fn part(&mut self, slit: &[GridPoint; 4]) -> Parted {
        let cuts = self.cuts(slit);
        let cut: Vec<usize> = cuts.iter().map(|(number, _)| *number).collect();
        // Found before anything changes: afterwards the pieces that were cut have no neighbours any more.
        let mut beside: Vec<usize> = cut.iter().flat_map(|&number| self.neighbours(number)).collect();
        beside.sort_unstable();
        beside.dedup();
        beside.retain(|number| !cut.contains(number));
        let mut parted = Parted { before: Vec::new(), after: Vec::new(), beside };
        for (number, left) in cuts {
            parted.before.push(self.remove(number));
            parted.after.extend(left.into_iter().map(|piece| self.add(piece)));
        }
        parted
    }

    /// The pieces that a slit cuts, each with what is left of it.
    fn cuts(&mut self, slit: &[GridPoint; 4]) -> Vec<(usize, Vec<Piece>)> {
        let [tip, end] = [middle(slit[0], slit[3]), middle(slit[1], slit[2])];
        let mut cuts = Vec::new();
        for tile in self.grid.tiles_along(tip, end, units(KERF_MM)) {
            for &number in &self.tiles[tile] {
                let Some(piece) = &self.pieces[number] else { continue };
                if may_meet(slit, &piece.frame)
                    && let Some(left) = left_of(piece, slit, self.grid.frame(tile), &mut self.knife)
                {
                    cuts.push((number, left));
                }
            }
        }
        cuts
    }

    pub(super) fn piece(&self, number: usize) -> &Piece {
        self.pieces[number].as_ref().expect("numbers in use name pieces")
    }

    /// The pieces that touch a piece across the borders of its tile.
    pub(super) fn neighbours(&self, number: usize) -> Vec<usize> {
        let piece = self.piece(number);
        let mut found = Vec::new();
        for border in Border::ALL {
            if let Some(tile) = self.grid.beyond(piece.tile, border) {
                let others = self.tiles[tile].iter().copied();
                found.extend(others.filter(|&other| piece.touches(border, self.piece(other))));
            }
        }
        found
    }

    pub(super) fn is_on_base(&self, number: usize) -> bool {
        stands(&self.grid, self.piece(number))
    }

    fn add(&mut self, piece: Piece) -> usize {
        self.on_base += usize::from(stands(&self.grid, &piece));
        let number = self.free.pop().unwrap_or_else(|| {
            self.pieces.push(None);
            self.pieces.len() - 1
        });
        self.tiles[piece.tile].push(number);
        self.pieces[number] = Some(piece);
        number
    }

    pub(super) fn remove(&mut self, number: usize) -> Piece {
        let piece = self.pieces[number].take().expect("numbers in use name pieces");
        self.on_base -= usize::from(stands(&self.grid, &piece));
        self.tiles[piece.tile].retain(|&other| other != number);
        self.free.push(number);
        piece
    }

    /// How many numbers pieces have at most.
    pub(super) fn numbers(&self) -> usize {
        self.pieces.len()
    }

    pub(super) fn pieces(&self) -> impl Iterator<Item = &Piece> {
        self.pieces.iter().flatten()
    }

    pub(super) fn pieces_in(&self, tile: usize) -> impl Iterator<Item = &Piece> {
        self.tiles[tile].iter().map(|&number| self.piece(number))
    }

    /// Whether a point of the grid lies in the stock; on its boundary this is not decided.
    pub(super) fn holds(&self, point: GridPoint) -> bool {
        self.grid.tile_at(point).is_some_and(|tile| self.pieces_in(tile).any(|piece| piece.holds(point)))
    }

    /// The stock as connected polygons with holes.
    pub(super) fn joined(&self) -> Vec<Vec<Vec<GridPoint>>> {
        Knife::new().joined(self.pieces().flat_map(|piece| &piece.contours))
    }
}

/// Whether a piece rests on the base: it reaches z = 0 with more than a sliver.
fn stands(grid: &Grid, piece: &Piece) -> bool {
    grid.beyond(piece.tile, Border::Bottom).is_none() && piece.reaches(Border::Bottom)
}

fn middle(a: GridPoint, b: GridPoint) -> GridPoint {
    GridPoint::new(i64::midpoint(a.x, b.x), i64::midpoint(a.y, b.y))
}

/// What a slit leaves of a piece; `None` if it leaves it as it is.
fn left_of(piece: &Piece, slit: &[GridPoint; 4], frame: Frame, knife: &mut Knife) -> Option<Vec<Piece>> {
    let shapes = knife.minus(&piece.contours, slit);
    let left: Vec<Piece> =
        shapes.into_iter().filter_map(|contours| Piece::new(piece.tile, frame, contours)).collect();
    let same = left.len() == 1 && left[0].area == piece.area;
    (!same).then_some(left)
}

/// Whether a slit and a rectangle can have anything in common: no side of the slit parts them.
fn may_meet(slit: &[GridPoint; 4], frame: &Frame) -> bool {
    let Frame { low, high } = *frame;
    let corners = [low, GridPoint::new(high.x, low.y), high, GridPoint::new(low.x, high.y)];
    let beside = slit.iter().all(|p| p.x <= low.x)
        || slit.iter().all(|p| p.x >= high.x)
        || slit.iter().all(|p| p.y <= low.y)
        || slit.iter().all(|p| p.y >= high.y);
    let parts = |[a, b]: [GridPoint; 2]| corners.iter().all(|&corner| cross(a, b, corner) <= 0);
    !beside && !edges_of(slit).any(parts)
}
