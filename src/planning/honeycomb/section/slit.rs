//! A cut in the section: one slit from the tip along the blade.

use super::fault::{SectionFault, within};
use super::grid::{GridPoint, snapped};
use crate::planning::geometry::Point2;
use crate::planning::honeycomb::blade::{Blade, Side};
use crate::planning::tolerance::{KERF_MM, SLIT_OVERRUN_MM};

/// How far from the tip, in the section and in mm, a blade does what.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reach {
    /// d: its edge cuts (Eq. 2).
    pub cutting: f64,
    /// Its whole edge ends. Beyond d it must run in air.
    pub edge: f64,
    /// Its body ends, at the trailing edge. Beyond d it must run in air.
    pub body: f64,
}

/// One cut of a tip point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cut {
    /// (x, z) in mm.
    pub tip: Point2,
    /// Where the blade leans.
    pub side: Side,
    /// alpha in rad, from the vertical.
    pub swing: f64,
    /// How far the blade reaches.
    pub reach: Reach,
}

/// No tip lies farther from the origin than this, and no blade is longer, in mm: ten times the largest blank.
const FARTHEST_TIP_MM: f64 = 1e6;

/// The largest swing in rad (89.9 degrees): beyond, the blade lies along the surface.
const LARGEST_SWING: f64 = 1.569;

impl Reach {
    /// The reaches of a blade of whose edge `cutting_length` mm cut.
    #[must_use]
    pub fn of(blade: &Blade, cutting_length: f64) -> Self {
        Self {
            cutting: blade.reach_mm(cutting_length),
            edge: blade.reach_mm(blade.length.mm()),
            body: blade.body_reach_mm(),
        }
    }

    /// How far anything of the blade reaches, in mm.
    #[must_use]
    pub fn whole(&self) -> f64 {
        self.cutting.max(self.edge).max(self.body)
    }
}

impl Cut {
    /// The point on the blade at a distance from the tip, in mm.
    #[must_use]
    pub fn at(&self, distance: f64) -> Point2 {
        let [across, up] = self.side.direction(self.swing);
        Point2::new(self.tip.x + across * distance, self.tip.y + up * distance)
    }

    /// The corners of its slit, counter-clockwise, from the right corner at the tip.
    ///
    /// It is half a kerf wide on either side of the blade, begins at the tip and ends a little beyond d.
    pub(super) fn slit(&self) -> [GridPoint; 4] {
        let [across, up] = self.side.direction(self.swing);
        let half = KERF_MM / 2.0;
        let end = self.at(self.reach.cutting + SLIT_OVERRUN_MM);
        let corner = |point: &Point2, side: f64| {
            snapped(&Point2::new(point.x + side * half * up, point.y - side * half * across))
        };
        [corner(&self.tip, 1.0), corner(&end, 1.0), corner(&end, -1.0), corner(&self.tip, -1.0)]
    }

    pub(super) fn check(&self) -> Result<(), SectionFault> {
        within("x of the tip in mm", self.tip.x, -FARTHEST_TIP_MM, FARTHEST_TIP_MM)?;
        within("z of the tip in mm", self.tip.y, -FARTHEST_TIP_MM, FARTHEST_TIP_MM)?;
        within("the swing angle in rad", self.swing, 0.0, LARGEST_SWING)?;
        check_reach("the reach of the cutting length in mm", self.reach.cutting)?;
        check_reach("the reach of the edge in mm", self.reach.edge)?;
        check_reach("the reach of the body in mm", self.reach.body)
    }
}

/// A reach is a length that a tile can have.
pub(super) fn check_reach(what: &'static str, reach: f64) -> Result<(), SectionFault> {
    within(what, reach, KERF_MM, FARTHEST_TIP_MM).map(|_| ())
}
