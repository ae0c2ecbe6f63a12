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
    let mut spans: Vec<Span> = Vec::new();
    let mut from = -half_mm;
    for span in envelope(&runs(piece), end) {
        if span.v.0 > from {
            spans.push(Span { v: (from, span.v.0), u: (beside, beside), there: false });
        }
        from = span.v.1;
        spans.push(span);
    }
    if from < half_mm {
        spans.push(Span { v: (from, half_mm), u: (beside, beside), there: false });
    }
    Front { spans }
}

/// The cut segments of the outline that are not lengthwise, lower v first, in runs: in each v only grows.
fn runs(piece: &Piece) -> Vec<Vec<Span>> {
    let cuts = piece.sides.iter().filter_map(|side| match side {
        Side::Cut(points) => Some(points),
        Side::TapeEdge(..) => None,
    });
    cuts.flat_map(|points| {
        let sides: Vec<_> = points.windows(2).filter(|pair| pair[0].y != pair[1].y).collect();
        let up = |pair: &[Point2]| pair[0].y < pair[1].y;
        let runs = sides.chunk_by(|one, other| up(one) == up(other));
        runs.map(|run| {
            let mut spans: Vec<Span> = run.iter().map(|pair| span(&pair[0], &pair[1])).collect();
            if !up(run[0]) {
                spans.reverse();
            }
            spans
        })
        .collect::<Vec<_>>()
    })
    .collect()
}

fn span(a: &Point2, b: &Point2) -> Span {
    let (a, b) = if a.y < b.y { (a, b) } else { (b, a) };
    Span { v: (a.y, b.y), u: (a.x, b.x), there: true }
}

/// The outermost of some runs at each v, in increasing v: of either half of them, and of both together. One run is its
/// own envelope: its spans do not overlap.
///
/// The time is that of sorting, also where a lengthwise cut with noise in its coordinates has thousands of runs one
/// beside the other.
fn envelope(runs: &[Vec<Span>], end: End) -> Vec<Span> {
    match runs {
        [] => Vec::new(),
        [one] => one.clone(),
        _ => {
            let (first, last) = runs.split_at(runs.len() / 2);
            together(&envelope(first, end), &envelope(last, end), end)
        }
    }
}

/// The outermost of two envelopes. Their spans do not cross, so one that is outermost in the middle of a stretch is so
/// throughout.
fn together(one: &[Span], other: &[Span], end: End) -> Vec<Span> {
    let mut outermost: Vec<Span> = Vec::with_capacity(one.len() + other.len());
    let mut last: Option<Span> = None;
    let (mut i, mut j) = (0, 0);
    let mut from = f64::NEG_INFINITY;
    while let Some(to) = one
        .get(i)
        .map(|span| span.next(from))
        .into_iter()
        .chain(other.get(j).map(|span| span.next(from)))
        .reduce(f64::min)
    {
        let here = |span: Option<&Span>| span.filter(|span| span.v.0 <= from).copied();
        let middle = f64::midpoint(from, to);
        let chosen = match (here(one.get(i)), here(other.get(j))) {
            (Some(a), Some(b)) => {
                Some(if (a.at(middle) < b.at(middle)) == (end == End::Start) { a } else { b })
            }
            (a, b) => a.or(b),
        };
        match (chosen, outermost.last_mut()) {
            // The same span goes on.
            (Some(span), Some(before)) if last == Some(span) => (before.v.1, before.u.1) = (to, span.at(to)),
            (Some(span), _) => {
                outermost.push(Span { v: (from, to), u: (span.at(from), span.at(to)), there: true })
            }
            (None, _) => {}
        }
        last = chosen;
        i += usize::from(one.get(i).is_some_and(|span| span.v.1 <= to));
        j += usize::from(other.get(j).is_some_and(|span| span.v.1 <= to));
        from = to;
    }
    outermost
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
    /// Where it begins or ends next after `v`, if it does not end before.
    fn next(&self, v: f64) -> f64 {
        if self.v.0 > v { self.v.0 } else { self.v.1 }
    }

    fn at(&self, v: f64) -> f64 {
        self.u.0 + (v - self.v.0) / (self.v.1 - self.v.0) * (self.u.1 - self.u.0)
    }
}

#[cfg(test)]
mod tests {
    use super::super::developed::DevelopedPly;
    use super::super::piece::within_strip;
    use super::*;
    use proptest::prelude::*;

    fn piece(list: &[(f64, f64)]) -> Piece {
        let boundary: Vec<_> = list.iter().map(|&(u, v)| Some(Point2::new(u, v))).collect();
        within_strip(&DevelopedPly { boundary: boundary.into(), holes: vec![], on_mould: None }, 75.0)
            .unwrap()
            .remove(0)
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

    proptest! {
        #![proptest_config(ProptestConfig { cases: 100, failure_persistence: None, ..ProptestConfig::default() })]
        /// Star-shaped outlines, which do not cross themselves, with noise along lengthwise sides.
        #[test]
        fn a_front_is_the_outermost_of_all_sides_at_every_v(
            radii in prop::collection::vec(10.0..60.0_f64, 3..60), squash in 1e-9..1.0_f64
        ) {
            let count = radii.len() as f64;
            let outline: Vec<(f64, f64)> = radii.iter().enumerate().map(|(i, radius)| {
                let (sin, cos) = (std::f64::consts::TAU * i as f64 / count).sin_cos();
                (radius * cos, squash * radius * sin)
            }).collect();
            let boundary: Vec<_> = outline.iter().map(|&(u, v)| Some(Point2::new(u, v))).collect();
            let ply = DevelopedPly { boundary: boundary.into(), holes: vec![], on_mould: None };
            let Some(piece) = within_strip(&ply, 75.0).unwrap().into_iter().next() else { return Ok(()) };
            let sides: Vec<Span> = runs(&piece).concat();
            for end in [End::Start, End::Finish] {
                let front = front(&piece, end, 37.5);
                prop_assert!(front.spans.windows(2).all(|pair| pair[0].v.1 == pair[1].v.0));
                prop_assert_eq!((front.spans[0].v.0, front.spans[front.spans.len() - 1].v.1), (-37.5, 37.5));
                for span in front.spans.iter().filter(|span| span.there) {
                    let v = f64::midpoint(span.v.0, span.v.1);
                    let over = sides.iter().filter(|side| side.v.0 <= v && v <= side.v.1).map(|side| side.at(v));
                    let most = match end {
                        End::Start => over.fold(f64::INFINITY, f64::min),
                        End::Finish => over.fold(f64::NEG_INFINITY, f64::max),
                    };
                    prop_assert!((span.at(v) - most).abs() <= 1e-6 * (1.0 + most.abs()), "{v}: {} {most}", span.at(v));
                }
            }
        }
    }
}
