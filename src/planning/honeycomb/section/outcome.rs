//! What one cut does.

use crate::planning::geometry::Point2;
use crate::planning::tolerance::{GOUGE_MM, SLIT_OVERRUN_MM};

/// A piece of material that a cut has freed. It leaves at once.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Chip {
    /// Its area in mm^2, slits not counted.
    pub area: f64,
    /// How much of it was part, in mm^2. 0 if the cuts about it have not entered the part.
    pub area_of_part: f64,
    /// The lower left corner of its bounding box, in mm.
    pub low: Point2,
    /// The upper right corner, in mm.
    pub high: Point2,
    /// The cut that freed it, from 0.
    pub freed_by: usize,
}

/// How deep a cut enters the part, in mm: the largest distance of a point of it within the part to where the part
/// ends. The line of the blade counts, without its kerf, so that a tip or an arm on the contour is no gouge.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Gouge {
    /// By the tip.
    pub tip: f64,
    /// By the arm, the cutting length d from the tip on, with the tip.
    pub arm: f64,
    /// By the edge and the body of the blade beyond d.
    pub body: f64,
}

/// How much of the blade beyond d runs in stock, in mm along the blade. It must run in air.
///
/// What lies within [`SLIT_OVERRUN_MM`] beyond d is not counted: it is what rounding leaves to the neighbour's slit.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Beyond {
    /// Of the edge.
    pub edge: f64,
    /// Of the body, beyond the edge.
    pub body: f64,
}

/// What one cut does.
#[derive(Debug, Clone, PartialEq)]
pub struct CutOutcome {
    /// Which cut it is, from 0.
    pub index: usize,
    /// What it frees.
    pub chips: Vec<Chip>,
    /// The area in mm^2 that its slit turns to nothing, with slivers of less than [`SLIVER_MM2`].
    ///
    /// [`SLIVER_MM2`]: crate::planning::tolerance::SLIVER_MM2
    pub slit_area: f64,
    /// How much of that was part, in mm^2. A slit along the contour takes half of its kerf from the part; that is
    /// the blade's own width and no gouge.
    pub slit_area_of_part: f64,
    /// How deep it enters the part.
    pub gouge: Gouge,
    /// What of the blade beyond d runs in stock.
    pub beyond: Beyond,
    /// How far the tip lies below the base, in mm.
    pub below_base: f64,
    /// What it took to find out, in pieces of stock looked at.
    pub steps: u64,
}

impl Gouge {
    /// The deepest of the three, in mm.
    #[must_use]
    pub fn deepest(&self) -> f64 {
        self.tip.max(self.arm).max(self.body)
    }
}

impl CutOutcome {
    /// Whether it enters the finished part, by more than print does to a blade on the contour ([`GOUGE_MM`]).
    #[must_use]
    pub fn is_gouge(&self) -> bool {
        self.gouge.deepest() > GOUGE_MM
    }

    /// Whether blade beyond d runs in stock by more than rounding leaves.
    #[must_use]
    pub fn runs_in_stock(&self) -> bool {
        self.beyond.edge.max(self.beyond.body) > SLIT_OVERRUN_MM
    }
}
