//! Numbers known only to lie between two others.

use std::ops::{Add, Mul, Neg, Sub};

/// All numbers from `low` to `high`.
///
/// Ends are rounded to the nearest, not outward: what that loses, some 1e-15 of a value, is far below the gap to
/// which `cover` proves anything.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Span {
    pub low: f64,
    pub high: f64,
}

impl Span {
    /// From `low` to `high`.
    pub fn new(low: f64, high: f64) -> Self {
        Self { low, high }
    }

    /// One number.
    pub fn at(value: f64) -> Self {
        Self::new(value, value)
    }

    /// From one end to the other, whichever is larger.
    pub fn between(a: f64, b: f64) -> Self {
        Self::new(a.min(b), a.max(b))
    }

    /// 1 / x, for spans above 0.
    pub fn recip(self) -> Self {
        Self::new(self.high.recip(), self.low.recip())
    }

    /// x^2, for spans above 0.
    pub fn square(self) -> Self {
        Self::new(self.low * self.low, self.high * self.high)
    }

    /// x^2, for any span.
    pub fn any_square(self) -> Self {
        let ends = Self::between(self.low * self.low, self.high * self.high);
        if self.has_sign() { ends } else { Self::new(0.0, ends.high) }
    }

    /// sqrt(x), for spans above 0.
    pub fn sqrt(self) -> Self {
        Self::new(self.low.sqrt(), self.high.sqrt())
    }

    /// x + 1 / x, for spans above 0; it falls up to x = 1 and rises from there.
    pub fn plus_recip(self) -> Self {
        let at = |x: f64| x + x.recip();
        let ends = Self::between(at(self.low), at(self.high));
        if self.low < 1.0 && self.high > 1.0 { Self::new(2.0, ends.high) } else { ends }
    }

    /// The number in it that is nearest to another.
    pub fn nearest(self, value: f64) -> f64 {
        value.max(self.low).min(self.high)
    }

    /// All numbers of both, and between them.
    pub fn with(self, other: Self) -> Self {
        Self::new(self.low.min(other.low), self.high.max(other.high))
    }

    /// Whether no two of its numbers differ in sign.
    pub fn has_sign(self) -> bool {
        self.low >= 0.0 || self.high <= 0.0
    }

    /// The largest magnitude in it.
    pub fn magnitude(self) -> f64 {
        self.high.max(-self.low)
    }
}

impl Add for Span {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self::new(self.low + other.low, self.high + other.high)
    }
}

impl Add<f64> for Span {
    type Output = Self;

    fn add(self, other: f64) -> Self {
        Self::new(self.low + other, self.high + other)
    }
}

impl Sub for Span {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self::new(self.low - other.high, self.high - other.low)
    }
}

impl Neg for Span {
    type Output = Self;

    fn neg(self) -> Self {
        Self::new(-self.high, -self.low)
    }
}

impl Mul for Span {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let (a, b) = (self.low * other.low, self.low * other.high);
        let (c, d) = (self.high * other.low, self.high * other.high);
        Self::new(a.min(b).min(c.min(d)), a.max(b).max(c.max(d)))
    }
}

impl Mul<f64> for Span {
    type Output = Self;

    /// By a number that is not negative.
    fn mul(self, factor: f64) -> Self {
        Self::new(self.low * factor, self.high * factor)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn spans(from: f64) -> impl Strategy<Value = (Span, f64)> {
        (from..5.0, from..5.0, 0.0..=1.0_f64).prop_map(|(a, b, share)| {
            let span = Span::between(a, b);
            (span, (span.low + share * (span.high - span.low)).clamp(span.low, span.high))
        })
    }

    fn holds(span: Span, value: f64) -> bool {
        let slack = 1e-12 * (1.0 + value.abs());
        span.low <= value + slack && value <= span.high + slack
    }

    proptest! {
        #[test]
        fn what_is_within_stays_within(
            (a, x) in spans(-5.0), (b, y) in spans(-5.0), (c, z) in spans(0.01), factor in 0.0..9.0_f64
        ) {
            prop_assert!(holds(a + b, x + y) && holds(a - b, x - y) && holds(a * b, x * y) && holds(-a, -x));
            prop_assert!(holds(a + factor, x + factor) && holds(a * factor, x * factor));
            prop_assert!(holds(c.recip(), z.recip()) && holds(c.square(), z * z) && holds(c.sqrt(), z.sqrt()));
            prop_assert!(holds(c.plus_recip(), z + z.recip()));
            prop_assert!(holds(a.any_square(), x * x) && a.magnitude() >= x.abs());
        }
    }
}
