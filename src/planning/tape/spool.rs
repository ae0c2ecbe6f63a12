//! A spool whose angle drives the tape: its radius changes with every layer (domain.md A8).
//!
//! What lies on it keeps its area, so with x the tape that has passed and t the thickness of a layer
//!
//! ```text
//! r(x)^2 = r0^2 -+ t x / pi        (- while it unwinds, + while it takes up)
//! angle(x) = integral dx / r(x) = 2 x / (r0 + r(x))
//! ```
//!
//! Both hold where a layer is thin against the radius: the length of a layer is taken as that of its circle.

use std::f64::consts::PI;

/// Which way the tape goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Turning {
    /// Off the spool, which gets smaller: the same angle feeds less and less.
    Unwinding,
    /// Onto the spool, which grows: the same angle feeds more and more.
    TakingUp,
}

/// A spool whose angle is driven. It stands at 0 degrees where the program begins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spool {
    /// Which way the tape goes.
    pub turning: Turning,
    /// Radius of the bare core, in mm.
    pub core_radius_mm: f64,
    /// Radius to the outermost layer where the program begins, in mm.
    pub roll_radius_mm: f64,
    /// Thickness of a layer, in mm.
    pub layer_mm: f64,
    /// How far off the roll's radius may have been measured, in mm.
    pub radius_error_mm: f64,
}

impl Spool {
    /// The radius in mm after x mm of tape; 0 where an unwinding spool would have none left.
    #[must_use]
    pub fn radius_mm(&self, x: f64) -> f64 {
        let area = self.layer_mm * x / PI;
        let squared = match self.turning {
            Turning::Unwinding => self.roll_radius_mm.powi(2) - area,
            Turning::TakingUp => self.roll_radius_mm.powi(2) + area,
        };
        squared.max(0.0).sqrt()
    }

    /// The angle in degrees by which the spool has turned after x mm of tape.
    #[must_use]
    pub fn angle_deg(&self, x: f64) -> f64 {
        (2.0 * x / (self.roll_radius_mm + self.radius_mm(x))).to_degrees()
    }

    /// How much tape comes off before the core is bare, in mm; no limit while it takes up.
    #[must_use]
    pub fn holds_mm(&self) -> f64 {
        match self.turning {
            Turning::Unwinding => {
                PI * (self.roll_radius_mm.powi(2) - self.core_radius_mm.powi(2)) / self.layer_mm
            }
            Turning::TakingUp => f64::INFINITY,
        }
    }

    /// The largest radius on the way from one reading of the tape to another, in mm: there the tape runs fastest.
    #[must_use]
    pub fn largest_radius_mm(&self, from: f64, to: f64) -> f64 {
        self.radius_mm(from).max(self.radius_mm(to))
    }

    /// The longest way of the tape in one move, in mm, for which a straight cut stays within `off_mm` of itself
    /// if it begins at x and its direction has this sine against the tape.
    ///
    /// Over an angle a the tape's way differs from a linear one by `t a^2 / (16 pi)` at most, in its middle; across
    /// the cut that is the sine of it.
    #[must_use]
    pub fn longest_step_mm(&self, x: f64, sine: f64, off_mm: f64) -> f64 {
        let angle = (16.0 * PI * off_mm / (self.layer_mm * sine)).sqrt();
        self.radius_mm(x) * angle
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spool(turning: Turning) -> Spool {
        Spool { turning, core_radius_mm: 50.0, roll_radius_mm: 150.0, layer_mm: 0.25, radius_error_mm: 0.0 }
    }

    /// The spool turned layer by layer: each turn takes up, or gives off, the circle in the middle of its layer.
    #[test]
    fn whole_turns_feed_the_circles_of_their_layers() {
        for (turning, step) in [(Turning::Unwinding, -0.25), (Turning::TakingUp, 0.25)] {
            let (mut x, mut radius) = (0.0, 150.0);
            for turn in 1..=200 {
                x += 2.0 * PI * (radius + step / 2.0);
                radius += step;
                assert!((spool(turning).radius_mm(x) - radius).abs() < 1e-9, "{turning:?} {turn}");
                assert!((spool(turning).angle_deg(x) - 360.0 * f64::from(turn)).abs() < 1e-8, "{turn}");
            }
        }
    }

    #[test]
    fn the_same_length_takes_more_angle_as_a_roll_shrinks_and_less_as_it_grows() {
        let angles = |turning| {
            let spool = spool(turning);
            [0.0, 100_000.0].map(|x| spool.angle_deg(x + 1000.0) - spool.angle_deg(x))
        };
        let [first, later] = angles(Turning::Unwinding);
        assert!(later > 1.1 * first, "{first} {later}");
        let [first, later] = angles(Turning::TakingUp);
        assert!(later < 0.95 * first, "{first} {later}");
    }

    #[test]
    fn a_spool_is_empty_where_its_radius_is_that_of_the_core() {
        let spool = spool(Turning::Unwinding);
        assert!((spool.radius_mm(spool.holds_mm()) - 50.0).abs() < 1e-9);
        // 400 layers of 0.25 mm at 100 mm on average.
        assert!((spool.holds_mm() - 400.0 * 2.0 * PI * 100.0).abs() < 1e-6);
    }
}
