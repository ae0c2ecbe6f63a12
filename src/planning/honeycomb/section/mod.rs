//! The exact section of a blank while V-shaped cuts are made in it (domain.md B3).
//!
//! x across, z up, y left out: every cut runs all along the blank, so the section says all. The stock begins as the
//! rectangle of the blank. A cut takes a thin slit out of it, from the tip along the blade; what then no longer
//! hangs together with the base is a chip and leaves at once.
//!
//! # How it is kept
//!
//! - **Tiles.** The stock is kept as polygons with holes within tiles of about the reach of the blade (`grid`,
//!   `piece`, `stock`). A slit touches a few of them, each with a few dozen edges at most, so a cut costs the same
//!   however many there were before. One polygon for the whole stock would make every cut cost its whole boundary.
//! - **Whole numbers.** Coordinates are integers of 2^-26 mm, fixed for every job. Areas are exact; a crossing is
//!   rounded alike in both tiles that it lies between; polygons minus slits are left to an overlay that works on
//!   integers throughout (`knife`).
//! - **Lockstep.** Which pieces still hang together with the base is found by searches from all pieces about the
//!   slit, in turn (`flood`), so that a chip is found at the cost of the chip and "nothing came free" at the cost
//!   of walking round the slit. Two tiles hang together where their pieces share more than a sliver of border.
//!
//! # The kerf
//!
//! A slit is [`KERF_MM`] wide, half of it on either side of the blade's plane, and ends [`SLIT_OVERRUN_MM`] beyond d.
//! Without width, chips would hang on slivers once tips are rounded to printed digits; without overrun, arms that
//! end exactly at their neighbour's slit would not always meet it.
//!
//! So a tip exactly on the contour takes half a kerf from the part. The rule: **the line of the blade gouges, its
//! kerf does not.** How deep a cut enters the part is measured on the line; the part's area that leaves with chips
//! is the gouge's area; what slits take from the part is counted apart (`slit_area_of_part`).
//!
//! Points are (x, z) in mm; the second coordinate of a [`Point2`] is z.
//!
//! [`KERF_MM`]: crate::planning::tolerance::KERF_MM
//! [`SLIT_OVERRUN_MM`]: crate::planning::tolerance::SLIT_OVERRUN_MM

mod air;
mod fault;
mod flood;
mod grid;
mod knife;
mod outcome;
mod piece;
mod profile;
mod remains;
mod slit;
mod stock;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

pub use fault::SectionFault;
pub use outcome::{Beyond, Chip, CutOutcome, Gouge};
pub use profile::{Farthest, Profile};
pub use remains::Remains;
pub use slit::{Cut, Reach};

pub(super) use self::fault::within;
use self::grid::{Grid, placed, snapped};
use self::piece::Piece;
use self::remains::{CutTip, square_mm};
use self::slit::check_reach;
use self::stock::{Parted, Stock};
use super::blade::Side;
use crate::planning::geometry::Point2;
use crate::planning::tolerance::SLIVER_MM2;

/// The section of a blank that is being cut.
#[derive(Debug, Clone)]
pub struct Section {
    profile: Profile,
    allowance: f64,
    stock: Stock,
    cuts: usize,
    /// By place on the grid.
    tips: BTreeMap<(i64, i64), CutTip>,
    gouge_area: f64,
    slit_area_of_part: f64,
    deepest_gouge: f64,
}

/// The largest allowance, in mm: that of the largest blank.
const LARGEST_ALLOWANCE_MM: f64 = 100_000.0;

impl Section {
    /// The uncut blank of `width` by `height` mm about a finished contour, with `allowance` mm to leave above it.
    /// `reach` in mm is about how far the cuts will reach (their d): the tiles are made for it, and longer or
    /// shorter ones only cost more.
    ///
    /// # Errors
    /// As [`Profile::new`]; an allowance below 0 or a reach that no blade has.
    pub fn new(
        width: f64,
        height: f64,
        profile: &[Point2],
        allowance: f64,
        reach: f64,
    ) -> Result<Self, SectionFault> {
        Self::about(Profile::new(profile, width, height)?, allowance, reach)
    }

    /// As `new`, about a contour that was taken over before.
    ///
    /// # Errors
    /// An allowance below 0 or a reach that no blade has.
    pub fn about(profile: Profile, allowance: f64, reach: f64) -> Result<Self, SectionFault> {
        within("the allowance in mm", allowance, 0.0, LARGEST_ALLOWANCE_MM)?;
        check_reach("the reach of the cuts in mm", reach)?;
        let grid = Grid::new(profile.width(), profile.blank_height(), reach);
        Ok(Self {
            profile,
            allowance,
            stock: Stock::new(grid),
            cuts: 0,
            tips: BTreeMap::new(),
            gouge_area: 0.0,
            slit_area_of_part: 0.0,
            deepest_gouge: 0.0,
        })
    }

    /// The finished contour.
    #[must_use]
    pub fn profile(&self) -> &Profile {
        &self.profile
    }

    /// Whether a tip may be cut both ways: neither arm nor the body of the blade enters the part plus its
    /// allowance. Exactly on the contour is allowed. What is left of the stock does not matter.
    #[must_use]
    pub fn tip_allowed(&self, tip: &Point2, swing: f64, reach: &Reach) -> bool {
        self.profile.tip_allowed(tip, swing, reach.whole(), self.allowance)
    }

    /// Makes a cut.
    ///
    /// # Errors
    /// A cut with a number that is not finite, a swing outside 0 to 89.9 degrees, or a blade with no reach; the
    /// section is then as before.
    pub fn cut(&mut self, cut: &Cut) -> Result<CutOutcome, SectionFault> {
        cut.check()?;
        let beyond = self.beyond(cut);
        let gouge = self.gouge(cut);
        self.deepest_gouge = self.deepest_gouge.max(gouge.deepest());
        let index = self.cuts;
        self.cuts += 1;
        self.note_tip(cut, index);
        let parted = self.stock.part(&cut.slit());
        let mut outcome = CutOutcome {
            index,
            chips: Vec::new(),
            slit_area: square_mm(self.area_lost(&parted)),
            slit_area_of_part: self.part_lost(&parted),
            gouge,
            beyond,
            below_base: (-cut.tip.y).max(0.0),
            steps: (parted.before.len() + parted.after.len()) as u64,
        };
        let freed = self.stock.release(&parted);
        outcome.steps += freed.steps as u64;
        for pieces in freed.chips {
            let chip = self.chip(&pieces, index);
            if chip.area < SLIVER_MM2 {
                outcome.slit_area += chip.area;
                outcome.slit_area_of_part += chip.area_of_part;
            } else {
                outcome.chips.push(chip);
            }
        }
        self.slit_area_of_part += outcome.slit_area_of_part;
        self.gouge_area += outcome.chips.iter().map(|chip| chip.area_of_part).sum::<f64>();
        Ok(outcome)
    }

    fn gouge(&self, cut: &Cut) -> Gouge {
        let Reach { cutting, .. } = cut.reach;
        let (elbow, end) = (cut.at(cutting), cut.at(cut.reach.whole()));
        Gouge {
            tip: self.profile.depth_of(&cut.tip),
            arm: self.profile.depth(&cut.tip, &elbow),
            body: if end == elbow { 0.0 } else { self.profile.depth(&elbow, &end) },
        }
    }

    /// Twice the area that a slit took, in square units.
    fn area_lost(&self, parted: &Parted) -> i128 {
        let before: i128 = parted.before.iter().map(|piece| piece.area).sum();
        before - parted.after.iter().map(|&number| self.stock.piece(number).area).sum::<i128>()
    }

    /// How much of the part a slit took, in mm^2.
    fn part_lost(&self, parted: &Parted) -> f64 {
        let under = |piece: &Piece| piece.area_under(&self.profile);
        let before: f64 = parted.before.iter().map(under).sum();
        let after: f64 = parted.after.iter().map(|&number| under(self.stock.piece(number))).sum();
        unless_rounding(before - after)
    }

    fn chip(&self, pieces: &[Piece], freed_by: usize) -> Chip {
        let low = pieces.iter().map(|piece| placed(piece.frame.low)).reduce(|a, b| a.inf(&b));
        let high = pieces.iter().map(|piece| placed(piece.frame.high)).reduce(|a, b| a.sup(&b));
        Chip {
            area: square_mm(pieces.iter().map(|piece| piece.area).sum()),
            area_of_part: unless_rounding(pieces.iter().map(|piece| piece.area_under(&self.profile)).sum()),
            low: low.expect("a chip has pieces"),
            high: high.expect("a chip has pieces"),
            freed_by,
        }
    }

    fn note_tip(&mut self, cut: &Cut, index: usize) {
        let place = snapped(&cut.tip);
        let tip = self.tips.entry((place.x, place.y)).or_insert_with(|| CutTip {
            place: cut.tip,
            first_cut: index,
            swings: [None; 2],
            shortest_reach: f64::INFINITY,
        });
        tip.swings[usize::from(cut.side == Side::Right)] = Some(cut.swing);
        tip.shortest_reach = tip.shortest_reach.min(cut.reach.cutting);
    }
}

/// An area in mm^2, or 0 if it is what rounding leaves of one.
fn unless_rounding(area: f64) -> f64 {
    if area < SLIVER_MM2 { 0.0 } else { area }
}
