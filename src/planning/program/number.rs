//! The only place where numbers become program text.

/// Writes a number with a fixed number of decimals, trailing zeros removed but one digit after the point kept,
/// never `-0`, never an exponent: `12.5`, `0.0`, `-0.0001`.
#[must_use]
pub fn fixed(value: f64, decimals: usize) -> String {
    let mut text = String::new();
    write_fixed(value, decimals, &mut text);
    text
}

/// As [`fixed`], at the end of a text.
pub fn write_fixed(value: f64, decimals: usize, text: &mut String) {
    debug_assert!(value.is_finite(), "only finite numbers reach a program");
    match steps(value, decimals) {
        Some(steps) => write_steps(steps, decimals, text),
        None => text.push_str(&spelled(value, decimals)),
    }
}

/// The value that [`fixed`] writes: the number as the control will read it.
#[must_use]
pub fn rounded(value: f64, decimals: usize) -> f64 {
    match steps(value, decimals) {
        // Both are whole and exact, and a quotient is rounded correctly, as the reading of a decimal text is.
        Some(steps) => steps as f64 / POWERS[decimals] as f64,
        // A decimal text is the one exact definition of the rounding that the control will see.
        None => spelled(value, decimals).parse().unwrap_or(value),
    }
}

/// Powers of ten, by exponent.
const POWERS: [i64; 10] =
    [1, 10, 100, 1_000, 10_000, 100_000, 1_000_000, 10_000_000, 100_000_000, 1_000_000_000];

/// The product below is off by less than a thousandth of a step for numbers of fewer steps than this.
const MOST_STEPS: f64 = 1e12;

/// The number in whole steps of its last decimal, where that is beyond doubt: not near the middle between two.
fn steps(value: f64, decimals: usize) -> Option<i64> {
    let scaled = value * *POWERS.get(decimals)? as f64;
    let nearest = scaled.round();
    let plain = scaled.abs() < MOST_STEPS && (scaled - nearest).abs() < 0.499;
    plain.then_some(nearest as i64)
}

fn write_steps(steps: i64, decimals: usize, text: &mut String) {
    if steps < 0 {
        text.push('-');
    }
    let (steps, power) = (steps.unsigned_abs(), POWERS[decimals].unsigned_abs());
    let mut digits = [0_u8; 24];
    let whole = written(steps / power, &mut digits);
    text.extend(digits[whole..].iter().map(|&digit| char::from(digit)));
    if decimals == 0 {
        return;
    }
    let (mut part, mut places) = (steps % power, decimals);
    while places > 1 && part % 10 == 0 {
        (part, places) = (part / 10, places - 1);
    }
    text.push('.');
    let first = written(part, &mut digits);
    text.extend(std::iter::repeat_n('0', places - (digits.len() - first)));
    text.extend(digits[first..].iter().map(|&digit| char::from(digit)));
}

/// Writes a whole number at the end of `digits` and says where it begins.
fn written(mut number: u64, digits: &mut [u8; 24]) -> usize {
    let mut first = digits.len();
    loop {
        first -= 1;
        digits[first] = b'0' + (number % 10) as u8;
        number /= 10;
        if number == 0 {
            return first;
        }
    }
}

/// The same by the standard library's exact decimals: for halves, and for what is very large.
fn spelled(value: f64, decimals: usize) -> String {
    let mut text = format!("{value:.decimals$}");
    if text.contains('.') {
        let end = text.trim_end_matches('0').len();
        text.truncate(end);
        if text.ends_with('.') {
            text.push('0');
        }
    }
    if text.trim_start_matches('-').chars().all(|c| c == '0' || c == '.') {
        return text.trim_start_matches('-').to_owned();
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn writes_no_negative_zero_and_no_exponent() {
        let cases = [(-0.0, "0.0"), (-0.000_04, "0.0"), (1e-12, "0.0"), (1e15, "1000000000000000.0")];
        for (value, text) in cases {
            assert_eq!(fixed(value, 4), text);
        }
    }

    #[test]
    fn keeps_what_carries_value() {
        assert_eq!(fixed(12.5, 4), "12.5");
        assert_eq!(fixed(-0.000_1, 4), "-0.0001");
        assert_eq!(fixed(100.0, 4), "100.0");
        assert_eq!(fixed(3.0, 0), "3");
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 5000, failure_persistence: None, ..ProptestConfig::default() })]
        /// The quick way against the standard library's exact decimals, also at and beside the middle of two steps.
        #[test]
        fn the_quick_way_writes_and_rounds_as_exact_decimals_do(
            steps in -2_000_000_000_i64..2_000_000_000, eighths in 0..16_i64, off in -4..=4_i64, scale in 0..12_i32,
            decimals in 0..10_usize
        ) {
            let middle = (steps as f64 + eighths as f64 / 8.0) / 10_f64.powi(scale);
            let value = f64::from_bits(middle.to_bits().wrapping_add_signed(off));
            prop_assume!(value.is_finite());
            let exact = spelled(value, decimals);
            prop_assert_eq!(&fixed(value, decimals), &exact);
            let read: f64 = exact.parse().unwrap();
            prop_assert_eq!(rounded(value, decimals).to_bits(), read.to_bits(), "{} {}", value, decimals);
        }
    }
}
