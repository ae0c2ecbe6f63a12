//! The only place where numbers become program text.

/// Writes a number with a fixed number of decimals, trailing zeros removed but one digit after the point kept,
/// never `-0`, never an exponent: `12.5`, `0.0`, `-0.0001`.
#[must_use]
pub fn fixed(value: f64, decimals: usize) -> String {
    debug_assert!(value.is_finite(), "only finite numbers reach a program");
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

/// The value that [`fixed`] writes: the number as the control will read it.
#[must_use]
pub fn rounded(value: f64, decimals: usize) -> f64 {
    // A decimal text is the one exact definition of the rounding that the control will see.
    fixed(value, decimals).parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;

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
}
