//! The way back from the degrees of a spool to mm of tape.
//!
//! A wound tape is a spiral: each turn moves its edge by one layer, `r = r0 -+ t a / 2 pi` at the angle a, and the
//! tape that has passed is the length of the spiral, `x = integral r da = r0 a -+ t a^2 / 4 pi` (domain.md A8, from the
//! other end). The planner computes radii from areas, so that neither can hide a fault of the other.

use std::f64::consts::{PI, TAU};

use super::travel::PRINTED_MM;
use crate::planning::tape::spool::{Spool, Turning};

/// A cut that a turning spool bends is looked at in parts that are straight to this, in mm: a hundredth of what printed
/// digits may add.
pub(super) const STRAIGHT_MM: f64 = 1e-5;

/// A spool, as a spiral.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Reel {
    radius_mm: f64,
    /// What a turn adds to the radius, in mm; negative where it unwinds.
    layer_mm: f64,
    /// The radius of the bare core, in mm.
    pub(super) core_mm: f64,
}

impl Reel {
    /// The spiral of a spool.
    pub(super) fn of(spool: &Spool) -> Self {
        let layer_mm = match spool.turning {
            Turning::Unwinding => -spool.layer_mm,
            Turning::TakingUp => spool.layer_mm,
        };
        Self { radius_mm: spool.roll_radius_mm, layer_mm, core_mm: spool.core_radius_mm }
    }

    fn radius_at(&self, turned_deg: f64) -> f64 {
        self.radius_mm + self.layer_mm * turned_deg / 360.0
    }

    /// The tape that has passed, in mm, where the spool has turned by so many degrees.
    pub(super) fn tape_mm(&self, turned_deg: f64) -> f64 {
        let turns = turned_deg / 360.0;
        TAU * turns * (self.radius_mm + self.layer_mm * turns / 2.0)
    }

    /// Whether there is tape on the core there.
    pub(super) fn has_tape(&self, turned_deg: f64) -> bool {
        self.radius_at(turned_deg) >= self.core_mm - PRINTED_MM
    }

    /// The way in mm of a turn at the larger of the two radii.
    pub(super) fn fastest_mm(&self, from_deg: f64, to_deg: f64) -> f64 {
        let radius = self.radius_at(from_deg).max(self.radius_at(to_deg));
        radius * (to_deg - from_deg).abs().to_radians()
    }

    /// In how many even parts a turn is straight to [`STRAIGHT_MM`]: over an angle a the spiral's length leaves its
    /// chord by `t a^2 / 16 pi`.
    pub(super) fn parts(&self, from_deg: f64, to_deg: f64) -> usize {
        let angle = (to_deg - from_deg).to_radians();
        let off_mm = self.layer_mm.abs() * angle.powi(2) / (16.0 * PI);
        // A cast ends at the largest number; a control turns no spool so far.
        ((off_mm / STRAIGHT_MM).sqrt().ceil() as usize).clamp(1, MOST_PARTS)
    }
}

/// A move is looked at in no more parts than this: a turn of 200 rad under layers of 1 mm.
const MOST_PARTS: usize = 10_000;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_spiral_gives_back_what_areas_gave() {
        for turning in [Turning::Unwinding, Turning::TakingUp] {
            let spool = Spool {
                turning,
                core_radius_mm: 40.0,
                roll_radius_mm: 140.0,
                layer_mm: 0.31,
                radius_error_mm: 0.0,
            };
            let reel = Reel::of(&spool);
            for step in 0..=100 {
                let x = 1800.0 * f64::from(step);
                assert!((reel.tape_mm(spool.angle_deg(x)) - x).abs() < 1e-7, "{turning:?} {x}");
                assert!((reel.radius_at(spool.angle_deg(x)) - spool.radius_mm(x)).abs() < 1e-9);
            }
        }
    }
}
