//! Pieces that a laying head can do little with: shorter than it can lay, or so narrow that nothing holds them.
//!
//! They are planned and cut all the same, for the ply asks for them; a person decides whether it does.

use serde::Serialize;

use super::input::{Course, TapeInput};
use super::piece::{Piece, Side};
use super::plan::PlannedPiece;
use crate::planning::finding::{Code, Finding};
use crate::planning::geometry::disc::fits;
use crate::planning::program::number::fixed;
use crate::planning::tolerance::{SAME_POINT_MM, SLIVER_MM};
use crate::planning::units::Length;

/// The most pieces of a course that a finding names.
const MOST_NAMED: usize = 5;

/// What is odd about a piece, as it stands in a manifest.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Marks {
    /// It is shorter along the tape than the laying head can lay.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub too_short: bool,
    /// It is nowhere as wide as [`SLIVER_MM`].
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub sliver: bool,
}

impl Marks {
    /// The marks of a piece.
    #[must_use]
    pub fn of(piece: &Piece, (low, high): (f64, f64), input: &TapeInput) -> Self {
        let shortest = input.shortest_piece.map_or(0.0, Length::mm);
        Self {
            too_short: high - low < shortest - SAME_POINT_MM,
            sliver: is_sliver(piece, sliver_mm(input.width.mm())),
        }
    }

    /// The marks in words, for a table; empty if there are none.
    #[must_use]
    pub fn words(self) -> &'static str {
        match (self.too_short, self.sliver) {
            (false, false) => "",
            (true, false) => "too short",
            (false, true) => "sliver",
            (true, true) => "too short, sliver",
        }
    }
}

/// Narrower than this, in mm, a piece is a sliver: half of the tape where that is narrow itself.
fn sliver_mm(width_mm: f64) -> f64 {
    SLIVER_MM.min(width_mm / 2.0)
}

/// Whether no disc of that diameter in mm lies in a piece.
fn is_sliver(piece: &Piece, diameter_mm: f64) -> bool {
    let radius = diameter_mm / 2.0;
    // Where all discs in a region are smaller than r, it lies within r of its outline: its area is at most r times its
    // length, and pi r^2 more for each cut-out. That spares the search for nearly every piece.
    let disc = std::f64::consts::PI * radius * radius;
    if piece.area_mm2 > radius * length(piece) + disc * piece.holes.len() as f64 {
        return false;
    }
    let open = |hole: &Vec<_>| hole[..hole.len() - 1].to_vec();
    let loops: Vec<_> = std::iter::once(piece.outline()).chain(piece.holes.iter().map(open)).collect();
    piece.area_mm2 < disc || !fits(&loops, radius)
}

/// The length of a piece's outlines in mm.
fn length(piece: &Piece) -> f64 {
    let cuts = piece.cuts().flat_map(|cut| cut.windows(2)).map(|pair| (pair[1] - pair[0]).norm());
    let edges = piece.sides.iter().map(|side| match side {
        Side::TapeEdge(from, to) => (to - from).norm(),
        Side::Cut(_) => 0.0,
    });
    cuts.chain(edges).sum()
}

/// What should be known of the pieces of a course.
#[must_use]
pub fn findings(course: &Course, pieces: &[PlannedPiece], input: &TapeInput) -> Vec<Finding> {
    let (label, at) = (course.label, course.place.to_string());
    let too_short = named(pieces, |marks| marks.too_short).map(|which| {
        let shortest = input.shortest_piece.map_or(0.0, Length::mm);
        let message = format!(
            "course {label}: shorter than the {shortest} mm that the laying head lays: {which}. Lengthen the ply \
             there, or lay it by hand"
        );
        Finding::warning(Code::PieceTooShort, at.as_str(), message)
    });
    let slivers = named(pieces, |marks| marks.sliver).map(|which| {
        let message = format!(
            "course {label}: nowhere {} mm wide: {which}. Nothing holds such a sliver; move the courses or the ply's edge",
            sliver_mm(input.width.mm())
        );
        Finding::warning(Code::Sliver, at.as_str(), message)
    });
    too_short.into_iter().chain(slivers).collect()
}

/// The pieces with a mark, numbered from 1, with their lengths.
fn named(pieces: &[PlannedPiece], marked: impl Fn(Marks) -> bool) -> Option<String> {
    let found: Vec<_> = pieces.iter().enumerate().filter(|(_, piece)| marked(piece.marks)).collect();
    let words = found.iter().take(MOST_NAMED).map(|(index, piece)| {
        let length = fixed(piece.u.1 - piece.u.0, 3);
        format!("piece {} ({length} mm long, {} mm2)", index + 1, fixed(piece.piece.area_mm2, 1))
    });
    let words = words.collect::<Vec<_>>().join(", ");
    let more = found.len().saturating_sub(MOST_NAMED);
    match found.len() {
        0 => None,
        _ if more > 0 => Some(format!("{words} and {more} more")),
        _ => Some(words),
    }
}

#[cfg(test)]
mod tests {
    use super::super::developed::DevelopedPly;
    use super::super::piece::within_strip;
    use super::*;
    use crate::planning::geometry::Point2;

    fn piece(list: &[(f64, f64)], hole: &[(f64, f64)]) -> Piece {
        let points =
            |list: &[(f64, f64)]| -> Vec<_> { list.iter().map(|&(u, v)| Some(Point2::new(u, v))).collect() };
        let holes = if hole.is_empty() { vec![] } else { vec![points(hole).into()] };
        within_strip(&DevelopedPly { boundary: points(list).into(), holes, on_mould: None }, 75.0)
            .unwrap()
            .remove(0)
    }

    #[test]
    fn a_needle_is_a_sliver_however_long_and_a_short_stub_is_none() {
        let needle = piece(&[(0.0, 34.5), (4000.0, 34.5), (4000.0, 90.0), (0.0, 90.0)], &[]);
        assert_eq!(needle.area_mm2, 12_000.0);
        assert!(is_sliver(&needle, SLIVER_MM));
        assert!(!is_sliver(&needle, 2.9));
        let stub = piece(&[(0.0, -90.0), (5.0, -90.0), (5.0, 90.0), (0.0, 90.0)], &[]);
        assert!(!is_sliver(&stub, SLIVER_MM));
        let wedge = piece(&[(0.0, 30.0), (400.0, 37.5), (0.0, 90.0)], &[]);
        assert!(!is_sliver(&wedge, SLIVER_MM) && is_sliver(&wedge, 7.5), "wide at one end");
    }

    #[test]
    fn a_frame_that_a_cut_out_leaves_is_a_sliver() {
        let ply = [(0.0, -30.0), (300.0, -30.0), (300.0, 30.0), (0.0, 30.0)];
        let frame = piece(&ply, &[(2.0, -28.0), (298.0, -28.0), (298.0, 28.0), (2.0, 28.0)]);
        assert!(is_sliver(&frame, SLIVER_MM));
        let thicker = piece(&ply, &[(4.0, -26.0), (296.0, -26.0), (296.0, 26.0), (4.0, 26.0)]);
        assert!(!is_sliver(&thicker, SLIVER_MM));
    }

    #[test]
    fn no_piece_of_a_narrow_tape_is_a_sliver_for_that() {
        assert_eq!((sliver_mm(75.0), sliver_mm(3.175)), (SLIVER_MM, 1.5875));
    }
}
