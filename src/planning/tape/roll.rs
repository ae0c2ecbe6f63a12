//! The roll: every piece at its place on one long tape (domain.md A6).
//!
//! A piece's roll coordinate is r = u + offset. The largest r passes the knives first. Wound on a cassette, the
//! tape comes off last in, first out, so with the `reverse` order r grows in laying order and the cassette
//! gives the courses out in laying order, start first.
//!
//! `place` finds the places: neighbours are nested into each other as far as outlines and knives allow.

use serde::Serialize;

use super::block::Block;
use super::front::{Between, between};
use super::input::RollOrder;
use super::place::{Place, STEP_MM, Tape, least_tape, place, touching_tape};
use crate::planning::budget::Budget;
use crate::planning::finding::Finding;

/// Where the pieces lie.
#[derive(Debug, Clone, PartialEq)]
pub struct Roll {
    /// Offset r - u in mm of each piece, in the order given.
    pub offsets_mm: Vec<f64>,
    /// The pieces in increasing r, as indices of the order given.
    pub order: Vec<usize>,
    /// What placing them has made of each, in the order given.
    pub places: Vec<Place>,
    /// Roll coordinate of the leading end of the tape in mm.
    pub leading_end_mm: f64,
    /// Length of tape from its leading end to the last cut, in mm.
    pub length_mm: f64,
}

/// The figures of a roll, as they stand in the report.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct RollFigures {
    /// The U axis reads `lead_mm - r + station_mm` of cutter k when that cutter stands over r.
    pub lead_mm: f64,
    /// Length of tape from its leading end to the last cut. Unless a zone lies there, the first cut begins at the end: an
    /// overcut and an axis that trails behind its edge before the piece.
    pub tape_used_mm: f64,
    /// Below this no roll of these pieces in this order can stay, however its knives are given: each two neighbours
    /// for themselves, zones left out. A roll that is no longer is proved to be the shortest.
    pub least_tape_mm: f64,
    /// The same by outlines alone: neighbours moved together until they touch, whatever the knives could do.
    pub bound_tape_mm: f64,
    /// Area of all pieces.
    pub piece_area_mm2: f64,
    /// Area of the tape used that is in no piece.
    pub scrap_area_mm2: f64,
    /// Scrap between the pieces of neighbouring courses, where both are: without cut-outs (also those that part a
    /// course), what lies beside narrow pieces, and the two ends.
    pub neighbour_scrap_area_mm2: f64,
    /// The same if neighbours were moved together until their outlines touch, whatever the knives could do.
    pub bound_scrap_area_mm2: f64,
    /// Piece area over area of tape used.
    pub utilisation: f64,
    /// Piece area over the area of `bound_tape_mm`.
    pub bound_utilisation: f64,
}

/// Places pieces, given in laying order.
///
/// # Errors
/// `BudgetSpent` or `Cancelled`.
pub fn lay(
    blocks: &[Block],
    roll_order: RollOrder,
    tape: &Tape<'_>,
    budget: &Budget<'_>,
) -> Result<Roll, Finding> {
    let mut order: Vec<usize> = (0..blocks.len()).collect();
    if roll_order == RollOrder::Laying {
        order.reverse();
    }
    // The largest r passes the knives first.
    let passing: Vec<&Block> = order.iter().rev().map(|&index| &blocks[index]).collect();
    let placed = place(&passing, tape, budget)?;
    let (Some(last), Some(block)) = (placed.last(), passing.last()) else {
        return Ok(Roll { offsets_mm: vec![], order, places: vec![], leading_end_mm: 0.0, length_mm: 0.0 });
    };
    // The piece that is cut last begins at r = 0, or less than a step beyond.
    let leading_end_mm = ((last.at_mm - block.u.0) / STEP_MM).ceil() * STEP_MM;
    let length_mm = last.at_mm - block.u.0;
    let mut places = placed;
    places.reverse();
    let mut by_piece: Vec<(usize, Place)> = order.iter().copied().zip(places).collect();
    by_piece.sort_by_key(|(index, _)| *index);
    let places: Vec<Place> = by_piece.into_iter().map(|(_, place)| place).collect();
    let offset = |place: &Place| ((leading_end_mm - place.at_mm) / STEP_MM).round() * STEP_MM;
    let offsets_mm = places.iter().map(offset).collect();
    Ok(Roll { offsets_mm, order, places, leading_end_mm, length_mm })
}

impl Roll {
    /// The figures of the roll. `courses` says of each piece which course it is of.
    #[must_use]
    pub fn figures(
        &self,
        blocks: &[Block],
        courses: &[usize],
        piece_area_mm2: f64,
        width_mm: f64,
        lead_mm: f64,
        tape: &Tape<'_>,
    ) -> RollFigures {
        let passing: Vec<&Block> = self.order.iter().rev().map(|&index| &blocks[index]).collect();
        let tape_area = self.length_mm * width_mm;
        let neighbours = self.neighbours(blocks, courses);
        let bound_tape_mm = touching_tape(&passing, tape);
        let share = |area: f64| if area > 0.0 { piece_area_mm2 / area } else { 0.0 };
        RollFigures {
            lead_mm,
            tape_used_mm: self.length_mm,
            least_tape_mm: least_tape(&passing, tape),
            bound_tape_mm,
            piece_area_mm2,
            scrap_area_mm2: tape_area - piece_area_mm2,
            // An empty sum is -0.0; a report says 0.0.
            neighbour_scrap_area_mm2: 0.0 + neighbours.iter().map(|n| n.area_mm2).sum::<f64>(),
            bound_scrap_area_mm2: 0.0
                + neighbours.iter().map(|n| n.area_mm2 - n.clearance_mm * n.width_mm).sum::<f64>(),
            utilisation: share(tape_area),
            bound_utilisation: share(bound_tape_mm * width_mm),
        }
    }

    fn neighbours(&self, blocks: &[Block], courses: &[usize]) -> Vec<Between> {
        let pairs = self.order.windows(2).filter(|pair| courses[pair[0]] != courses[pair[1]]);
        pairs
            .map(|pair| {
                let [one, other] = [pair[0], pair[1]];
                between(&blocks[one].lead, self.offsets_mm[one], &blocks[other].trail, self.offsets_mm[other])
            })
            .collect()
    }
}
