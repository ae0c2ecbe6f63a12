//! The roll: every piece at its place on one long tape (domain.md A6).
//!
//! A piece's roll coordinate is r = u + offset. The largest r passes the knives first. Wound on a cassette, the
//! tape comes off last in, first out, so with the `reverse` order r grows in laying order and the cassette
//! gives the courses out in laying order, start first.
//!
//! Pieces lie one after the other without sharing any r; neighbours are not nested into each other yet. The
//! figures say how much tape nesting could save.

use serde::Serialize;

use super::front::{Between, End, between, front};
use super::input::RollOrder;
use super::piece::Piece;
use crate::planning::units::Length;

/// Where the pieces lie.
#[derive(Debug, Clone, PartialEq)]
pub struct Roll {
    /// Offset r - u in mm of each piece, in the order given.
    pub offsets_mm: Vec<f64>,
    /// The pieces in increasing r, as indices of the order given.
    pub order: Vec<usize>,
    /// Length of tape between the first and the last cut, in mm.
    pub length_mm: f64,
}

/// The figures of a roll, as they stand in the report.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct RollFigures {
    /// The U axis reads `lead_mm - r + station_mm` of cutter k when that cutter stands over r.
    pub lead_mm: f64,
    /// Length of tape from the first cut to the last.
    pub tape_used_mm: f64,
    /// Area of all pieces.
    pub piece_area_mm2: f64,
    /// Area of the tape used that is in no piece.
    pub scrap_area_mm2: f64,
    /// Scrap between neighbouring pieces: without cut-outs, what lies beside narrow pieces, and the two ends.
    pub neighbour_scrap_area_mm2: f64,
    /// The same if neighbours were moved together until their outlines touch, whatever the knives could do.
    pub bound_scrap_area_mm2: f64,
    /// Piece area over area of tape used.
    pub utilisation: f64,
}

/// Offsets are whole multiples of this, in mm: a program's last printed digit.
const OFFSET_STEP_MM: f64 = 1e-4;

/// Places pieces, given in laying order.
#[must_use]
pub fn place(pieces: &[&Piece], roll_order: RollOrder, gap: Length) -> Roll {
    let mut order: Vec<usize> = (0..pieces.len()).collect();
    if roll_order == RollOrder::Laying {
        order.reverse();
    }
    let mut offsets_mm = vec![0.0; pieces.len()];
    let mut end = 0.0;
    for (place, &index) in order.iter().enumerate() {
        let (low, high) = pieces[index].u_range();
        let from = if place == 0 { 0.0 } else { end + gap.mm() };
        let offset = ((from - low) / OFFSET_STEP_MM).ceil() * OFFSET_STEP_MM;
        offsets_mm[index] = offset;
        end = high + offset;
    }
    let start = order.first().map_or(0.0, |&index| pieces[index].u_range().0 + offsets_mm[index]);
    Roll { offsets_mm, order, length_mm: end - start }
}

impl Roll {
    /// The largest roll coordinate in mm: the leading end of the tape.
    #[must_use]
    pub fn leading_end(&self, pieces: &[&Piece]) -> f64 {
        self.order.last().map_or(0.0, |&index| pieces[index].u_range().1 + self.offsets_mm[index])
    }

    /// The figures of the roll.
    #[must_use]
    pub fn figures(&self, pieces: &[&Piece], width: Length, lead_mm: f64) -> RollFigures {
        let piece_area_mm2: f64 = pieces.iter().map(|piece| piece.area_mm2).sum();
        let tape_area = self.length_mm * width.mm();
        let neighbours = self.neighbours(pieces, width);
        RollFigures {
            lead_mm,
            tape_used_mm: self.length_mm,
            piece_area_mm2,
            scrap_area_mm2: tape_area - piece_area_mm2,
            // An empty sum is -0.0; a report says 0.0.
            neighbour_scrap_area_mm2: 0.0 + neighbours.iter().map(|n| n.area_mm2).sum::<f64>(),
            bound_scrap_area_mm2: 0.0
                + neighbours.iter().map(|n| n.area_mm2 - n.clearance_mm * width.mm()).sum::<f64>(),
            utilisation: if tape_area > 0.0 { piece_area_mm2 / tape_area } else { 0.0 },
        }
    }

    fn neighbours(&self, pieces: &[&Piece], width: Length) -> Vec<Between> {
        let half = width.mm() / 2.0;
        let pairs = self.order.windows(2);
        pairs
            .map(|pair| {
                let finish = front(pieces[pair[0]], End::Finish, half);
                let start = front(pieces[pair[1]], End::Start, half);
                between(&finish, self.offsets_mm[pair[0]], &start, self.offsets_mm[pair[1]])
            })
            .collect()
    }
}
