//! Many polylines as straight pieces under a tree of boxes, so that what is near is found without looking at all of them.
//!
//! Pieces that follow each other lie near each other, so the boxes are those of consecutive pieces: no sorting.

use std::ops::Range;

use super::nearness::Segment;

/// So many consecutive pieces share a box, and so many boxes the next larger one.
const BLOCK: usize = 8;

/// Nothing that lies farther out than this, in mm, is on any machine; it gets no place in the grid.
pub(super) const FARTHEST_MM: f64 = 1e7;

/// A box is larger than what it holds by this, in mm, so that rounding cannot leave a point outside; far below the radius of
/// any question.
const MARGIN_MM: f64 = 1e-6;

/// A straight piece of a curve.
#[derive(Debug, Clone, Copy)]
pub(super) struct Piece {
    /// The curve of which it is a piece.
    curve: u32,
    /// Which step of that curve it is, from 0.
    step: u32,
    /// Whether it begins where another piece of the same curve ends (the last one for a closed curve's first).
    pub(super) joined: bool,
}

impl Piece {
    /// The curve of which it is a piece.
    pub(super) fn curve(&self) -> usize {
        self.curve as usize
    }

    /// Which step of that curve it is, from 0.
    pub(super) fn step(&self) -> usize {
        self.step as usize
    }
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
pub(super) struct Curves<'a> {
    polylines: Vec<&'a [[f64; 2]]>,
    /// All pieces, curve by curve in order.
    pub(super) pieces: Vec<Piece>,
    /// What is too far out, or not finite.
    pub(super) misplaced: Vec<Misplaced>,
    /// Boxes around each [`BLOCK`] of pieces, then around each `BLOCK` of those, up to one or none.
    levels: Vec<Vec<Around>>,
}

/// A box along the axes: its lowest and its highest corner.
#[derive(Debug, Clone, Copy)]
struct Around {
    low: [f64; 2],
    high: [f64; 2],
}

impl<'a> Curves<'a> {
    /// Of polylines of points (r, v) in mm. Points repeated in a row count once.
    pub(super) fn of(polylines: impl Iterator<Item = &'a [[f64; 2]]>) -> Self {
        let polylines: Vec<&[[f64; 2]]> = polylines.collect();
        let mut curves = Self { polylines, pieces: Vec::new(), misplaced: Vec::new(), levels: Vec::new() };
        for curve in 0..curves.polylines.len() {
            curves.add(curve);
        }
        curves.put_boxes_around();
        curves
    }

    /// The ends of a piece; they differ.
    pub(super) fn ends(&self, piece: usize) -> Segment {
        let Piece { curve, step, .. } = self.pieces[piece];
        let points = self.polylines[curve as usize];
        [points[step as usize], points[step as usize + 1]]
    }

    fn add(&mut self, curve: usize) {
        let points = self.polylines[curve];
        let number = |index: usize| u32::try_from(index).expect("no plan has four thousand million points");
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
                self.pieces.push(Piece { curve: number(curve), step: number(step), joined });
                joined = true;
            }
        }
    }

    fn put_boxes_around(&mut self) {
        let around = |piece: usize| Around::segment(self.ends(piece));
        let blocks =
            (0..self.pieces.len()).step_by(BLOCK).map(|first| first..(first + BLOCK).min(self.pieces.len()));
        let mut level: Vec<Around> =
            blocks.filter_map(|block| block.map(around).reduce(Around::with)).collect();
        while level.len() > 1 {
            let above =
                level.chunks(BLOCK).filter_map(|block| block.iter().copied().reduce(Around::with)).collect();
            self.levels.push(std::mem::replace(&mut level, above));
        }
        self.levels.push(level);
    }

    /// Writes the places in `pieces` of everything that may lie within a radius of a segment, and maybe more,
    /// in order into `found`.
    pub(super) fn near(&self, segment: Segment, radius: f64, found: &mut Vec<usize>) {
        found.clear();
        let reach = Reach::of(segment, radius);
        if let Some(top) = self.levels.len().checked_sub(1) {
            self.visit(top, 0..self.levels[top].len(), &reach, found);
        }
    }

    fn visit(&self, level: usize, boxes: Range<usize>, reach: &Reach, found: &mut Vec<usize>) {
        for index in boxes {
            if !reach.meets(&self.levels[level][index]) {
                continue;
            }
            let below = |count: usize| index * BLOCK..count.min((index + 1) * BLOCK);
            match level.checked_sub(1) {
                Some(lower) => self.visit(lower, below(self.levels[lower].len()), reach, found),
                None => found.extend(
                    below(self.pieces.len()).filter(|piece| reach.meets(&Around::segment(self.ends(*piece)))),
                ),
            }
        }
    }
}

impl Around {
    fn segment([a, b]: Segment) -> Self {
        Self { low: [a[0].min(b[0]), a[1].min(b[1])], high: [a[0].max(b[0]), a[1].max(b[1])] }
    }

    fn with(self, other: Self) -> Self {
        let (a, b) = (self, other);
        Self {
            low: [a.low[0].min(b.low[0]), a.low[1].min(b.low[1])],
            high: [a.high[0].max(b.high[0]), a.high[1].max(b.high[1])],
        }
    }
}

/// What lies within a radius of a segment.
struct Reach {
    /// The box around it.
    around: Around,
    /// The middle of the segment, its unit normal, and the radius.
    middle: [f64; 2],
    normal: [f64; 2],
    radius: f64,
}

impl Reach {
    fn of(segment: Segment, radius: f64) -> Self {
        let [a, b] = segment;
        let radius = radius + MARGIN_MM;
        let Around { low, high } = Around::segment(segment);
        let around = Around { low: low.map(|x| x - radius), high: high.map(|x| x + radius) };
        let length = (b[0] - a[0]).hypot(b[1] - a[1]);
        let normal = if length > 0.0 { [(a[1] - b[1]) / length, (b[0] - a[0]) / length] } else { [0.0, 0.0] };
        Self { around, middle: [f64::midpoint(a[0], b[0]), f64::midpoint(a[1], b[1])], normal, radius }
    }

    /// Whether a box may hold something of it: neither the axes nor the segment's own normal tell them apart.
    fn meets(&self, other: &Around) -> bool {
        let apart = |axis: usize| {
            other.high[axis] < self.around.low[axis] || self.around.high[axis] < other.low[axis]
        };
        if apart(0) || apart(1) {
            return false;
        }
        let off = |axis: usize| {
            let (low, high) = (other.low[axis], other.high[axis]);
            let (middle, half) = (f64::midpoint(low, high) - self.middle[axis], (high - low) / 2.0);
            [middle * self.normal[axis], half * self.normal[axis].abs()]
        };
        let [[one, half], [other, other_half]] = [off(0), off(1)];
        (one + other).abs() <= self.radius + half + other_half
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planning::program::replay::nearness::Probe;

    proptest::proptest! {
        #[test]
        fn nothing_near_is_missed(
            points in proptest::collection::vec([-9.0..9.0f64, -9.0..9.0f64], 2..300),
            a in [-9.0..9.0f64, -9.0..9.0f64], b in [-9.0..9.0f64, -9.0..9.0f64], radius in 0.001..3.0f64,
        ) {
            let curves = Curves::of(std::iter::once(points.as_slice()));
            let mut found = Vec::new();
            curves.near([a, b], radius, &mut found);
            proptest::prop_assert!(found.windows(2).all(|pair| pair[0] < pair[1]));
            for index in 0..curves.pieces.len() {
                let near = Probe::along([a, b]).near_segment(curves.ends(index), radius).is_some();
                proptest::prop_assert!(!near || found.contains(&index));
            }
        }
    }

    #[test]
    fn pieces_know_what_they_join() {
        let closed = [[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 0.0]];
        let broken = [[0.0, 0.0], [1.0, 0.0], [f64::NAN, 0.0], [2.0, 0.0], [3.0, 0.0]];
        let curves = Curves::of([closed.as_slice(), &broken].into_iter());
        let joined: Vec<_> = curves.pieces.iter().map(|piece| (piece.step(), piece.joined)).collect();
        assert_eq!(joined, [(0, true), (2, true), (3, true), (0, false), (3, false)]);
        assert_eq!(curves.misplaced.iter().map(|piece| piece.step).collect::<Vec<_>>(), [1, 2]);
        assert!(curves.misplaced.iter().all(|piece| piece.length_mm == FARTHEST_MM));
    }
}
