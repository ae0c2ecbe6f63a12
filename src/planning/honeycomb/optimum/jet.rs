//! A function along a line, over a stretch of it: between what numbers it, its slope and its curvature lie.

use std::ops::{Add, Mul};

use super::span::Span;

/// Value, first and second derivative.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Jet {
    pub value: Span,
    pub slope: Span,
    pub curvature: Span,
}

impl Jet {
    /// A number that does not change.
    pub fn at(value: f64) -> Self {
        Self::new(Span::at(value), Span::at(0.0), Span::at(0.0))
    }

    /// Of its parts.
    pub fn new(value: Span, slope: Span, curvature: Span) -> Self {
        Self { value, slope, curvature }
    }

    /// The least that the tangent reaches within `ends`, where this is the jet of one point `at`.
    pub fn tangent_least(&self, at: f64, ends: Span) -> f64 {
        let [before, after] = [self.slope.high * (ends.low - at), self.slope.low * (ends.high - at)];
        self.value.low + before.min(after)
    }

    /// 1 / f, for f above 0: slope -f' / f^2, curvature (2 f'^2 / f - f'') / f^2.
    pub fn recip(self) -> Self {
        let one = self.value.recip();
        let squared = one.square();
        let bend = self.slope.any_square() * 2.0 * one - self.curvature;
        Self::new(one, -(self.slope * squared), bend * squared)
    }

    /// sqrt(f), for f above 0: slope f' / 2 sqrt(f), curvature (f'' - f'^2 / 2 f) / 2 sqrt(f).
    pub fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        let half = root.recip() * 0.5;
        let bend = self.curvature - self.slope.any_square() * 0.5 * self.value.recip();
        Self::new(root, self.slope * half, bend * half)
    }

    /// f^2.
    pub fn square(self) -> Self {
        let bend = (self.slope.any_square() + self.value * self.curvature) * 2.0;
        Self::new(self.value.any_square(), self.value * self.slope * 2.0, bend)
    }
}

impl Add for Jet {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self::new(self.value + other.value, self.slope + other.slope, self.curvature + other.curvature)
    }
}

impl Add<f64> for Jet {
    type Output = Self;

    fn add(self, other: f64) -> Self {
        Self { value: self.value + other, ..self }
    }
}

impl Mul for Jet {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let bend =
            self.value * other.curvature + self.slope * other.slope * 2.0 + self.curvature * other.value;
        Self::new(self.value * other.value, self.value * other.slope + self.slope * other.value, bend)
    }
}

impl Mul<f64> for Jet {
    type Output = Self;

    /// By a number that is not negative.
    fn mul(self, factor: f64) -> Self {
        Self::new(self.value * factor, self.slope * factor, self.curvature * factor)
    }
}

#[cfg(test)]
mod tests {
    use num_dual::{Dual2_64, DualNum};
    use proptest::prelude::*;

    use super::*;

    fn holds(span: Span, value: f64) -> bool {
        let slack = 1e-11 * (1.0 + value.abs() + span.magnitude());
        span.low <= value + slack && value <= span.high + slack
    }

    fn has(jet: Jet, number: Dual2_64) -> bool {
        holds(jet.value, number.re) && holds(jet.slope, number.v1) && holds(jet.curvature, number.v2)
    }

    /// x^2 + c over x from `low` to `high`: its jet, and its derivatives at a point in between.
    fn parabola(low: f64, high: f64, share: f64, c: f64) -> (Jet, Dual2_64) {
        let x = low + share * (high - low);
        let ends = Span::new(low, high);
        let jet = Jet::new(ends.any_square() + c, ends * 2.0, Span::at(2.0));
        (jet, Dual2_64::from_re(x).derivative().powi(2) + c)
    }

    proptest! {
        #[test]
        fn what_is_within_stays_within(
            a in -2.0..2.0_f64, width in 0.0..2.0_f64, share in 0.0..=1.0_f64, c in 0.1..3.0_f64, d in -3.0..3.0_f64
        ) {
            let (f, x) = parabola(a, a + width, share, c);
            let (g, y) = parabola(a, a + width, share, d);
            prop_assert!(has(f + g, x + y) && has(f + d, x + d) && has(f * g, x * y) && has(f * c, x * c));
            prop_assert!(has(f.recip(), x.recip()) && has(f.sqrt(), x.sqrt()) && has(g.square(), y * y));
        }
    }
}
