//! The fronts of a piece: where it begins and where it ends along U, as functions of v.

use super::piece::{Piece, Side};
use crate::planning::geometry::Point2;

/// A front: u as a piecewise linear function of v over the width of the tape, with jumps where the outline has them.
#[derive(Debug, Clone, PartialEq)]
pub struct Front {
    /// Spans in increasing v without gaps.
    spans: Vec<Span>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Span {
    v: (f64, f64),
    u: (f64, f64),
    /// Whether the piece is there, or the span lies beside it.
    there: bool,
}

/// Which front of a piece.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// Smallest u.
    Start,
    /// Largest u.
    Finish,
}

/// The front of a piece on a tape of half width `half_mm`.
///
/// Beside a piece that is narrower than the tape the front is the piece's smallest or largest u, so that no other piece
/// comes to lie side by side with it.
#[must_use]
pub fn front(piece: &Piece, end: End, half_mm: f64) -> Front {
    let (low, high) = piece.u_range();
    let beside = if end == End::Start { low } else { high };
    let mut edges = edges(piece);
    edges.sort_by(|a, b| a.0.y.total_cmp(&b.0.y));
    let mut levels: Vec<f64> =
        edges.iter().flat_map(|(a, b)| [a.y, b.y]).chain([-half_mm, half_mm]).collect();
    levels.sort_by(f64::total_cmp);
    levels.dedup();
    let mut active: Vec<(Point2, Point2)> = Vec::new();
    let mut waiting = edges.into_iter().peekable();
    let spans = levels.windows(2).map(|pair| {
        let v = (pair[0], pair[1]);
        active.retain(|(_, b)| b.y > v.0);
        while let Some(edge) = waiting.next_if(|(a, _)| a.y <= v.0) {
            active.push(edge);
        }
        outermost(&active, end, v).unwrap_or(Span { v, u: (beside, beside), there: false })
    });
    Front { spans: spans.collect() }
}

/// The cut segments of the outline that are not lengthwise, lower v first.
fn edges(piece: &Piece) -> Vec<(Point2, Point2)> {
    let cuts = piece.sides.iter().filter_map(|side| match side {
        Side::Cut(points) => Some(points),
        Side::TapeEdge(..) => None,
    });
    cuts.flat_map(|points| points.windows(2))
        .filter(|pair| pair[0].y != pair[1].y)
        .map(|pair| if pair[0].y < pair[1].y { (pair[0], pair[1]) } else { (pair[1], pair[0]) })
        .collect()
}

fn outermost(active: &[(Point2, Point2)], end: End, v: (f64, f64)) -> Option<Span> {
    let at = |(a, b): &(Point2, Point2), v: f64| a.x + (v - a.y) / (b.y - a.y) * (b.x - a.x);
    let middle = f64::midpoint(v.0, v.1);
    let compare =
        |one: &&(Point2, Point2), other: &&(Point2, Point2)| at(one, middle).total_cmp(&at(other, middle));
    let edge = match end {
        End::Start => active.iter().min_by(compare),
        End::Finish => active.iter().max_by(compare),
    }?;
    Some(Span { v, u: (at(edge, v.0), at(edge, v.1)), there: true })
}

impl Front {
    /// The largest u of the front in mm.
    #[must_use]
    pub fn largest_u(&self) -> f64 {
        self.spans.iter().flat_map(|span| [span.u.0, span.u.1]).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Whether the piece is there over the whole width of the tape.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.spans.iter().all(|span| span.there)
    }
}

/// What lies between the finish of one piece and the start of the next, both in one coordinate along U.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Between {
    /// Area in mm^2, where both pieces are: what lies beside a narrow one is not between them.
    pub area_mm2: f64,
    /// The width in mm over which both pieces are.
    pub width_mm: f64,
    /// The smallest distance along U in mm: how far the next piece could move up.
    pub clearance_mm: f64,
    /// The largest distance along U in mm.
    pub largest_mm: f64,
}

/// Measures between two fronts; `finish_offset` and `start_offset` are added to their u.
#[must_use]
pub fn between(finish: &Front, finish_offset: f64, start: &Front, start_offset: f64) -> Between {
    let mut measured =
        Between { area_mm2: 0.0, width_mm: 0.0, clearance_mm: f64::INFINITY, largest_mm: f64::NEG_INFINITY };
    let (mut one, mut other) = (finish.spans.iter().peekable(), start.spans.iter().peekable());
    while let (Some(a), Some(b)) = (one.peek(), other.peek()) {
        let v = (a.v.0.max(b.v.0), a.v.1.min(b.v.1));
        let gap = |v: f64| (b.at(v) + start_offset) - (a.at(v) + finish_offset);
        if v.1 > v.0 {
            measured.add(v.1 - v.0, gap(v.0), gap(v.1), a.there && b.there);
        }
        if a.v.1 <= b.v.1 {
            one.next();
        } else {
            other.next();
        }
    }
    measured
}

impl Between {
    fn add(&mut self, width: f64, low: f64, high: f64, both: bool) {
        if both {
            self.area_mm2 += f64::midpoint(low, high) * width;
            self.width_mm += width;
        }
        self.clearance_mm = self.clearance_mm.min(low).min(high);
        self.largest_mm = self.largest_mm.max(low).max(high);
    }
}

impl Span {
    fn at(&self, v: f64) -> f64 {
        self.u.0 + (v - self.v.0) / (self.v.1 - self.v.0) * (self.u.1 - self.u.0)
    }
}

#[cfg(test)]
mod tests {
    use super::super::develop::DevelopedPly;
    use super::super::piece::within_strip;
    use super::*;

    fn piece(list: &[(f64, f64)]) -> Piece {
        let boundary: Vec<_> = list.iter().map(|&(u, v)| Some(Point2::new(u, v))).collect();
        within_strip(&DevelopedPly { boundary: boundary.into(), holes: vec![] }, 75.0).unwrap().remove(0)
    }

    #[test]
    fn a_greater_end_before_a_less_start_fits_without_scrap() {
        let finish = piece(&[(0.0, -37.5), (100.0, -37.5), (137.5, 0.0), (100.0, 37.5), (0.0, 37.5)]);
        let start = piece(&[(0.0, -37.5), (200.0, -37.5), (200.0, 37.5), (0.0, 37.5), (37.5, 0.0)]);
        let finish = front(&finish, End::Finish, 37.5);
        let start = front(&start, End::Start, 37.5);
        let apart = between(&finish, 0.0, &start, 137.5);
        assert_eq!(apart.clearance_mm, 37.5);
        assert_eq!(apart.area_mm2, 75.0 * 37.5);
        assert_eq!(between(&finish, 0.0, &start, 100.0).area_mm2, 0.0);
    }

    #[test]
    fn scrap_beside_a_narrow_piece_is_not_between_neighbours() {
        let narrow = piece(&[(0.0, -10.0), (100.0, -10.0), (100.0, 10.0), (0.0, 10.0)]);
        let measured =
            between(&front(&narrow, End::Finish, 37.5), 0.0, &front(&narrow, End::Start, 37.5), 104.0);
        assert_eq!((measured.clearance_mm, measured.area_mm2, measured.width_mm), (4.0, 80.0, 20.0));
    }
}
