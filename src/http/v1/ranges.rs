//! Conditional and partial requests (RFC 9110, sections 13 and 14) for immutable bytes.

use axum::http::{HeaderMap, header};

/// What is asked for of some bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// All of them.
    Whole,
    /// These, both ends included.
    Range {
        /// The first byte.
        first: usize,
        /// The last byte.
        last: usize,
    },
    /// None of them: the range lies outside.
    Outside,
}

/// Whether a header such as `If-None-Match` names this entity tag.
#[must_use]
pub fn matches_tag(header: &str, etag: &str) -> bool {
    header
        .split(',')
        .map(str::trim)
        .any(|known| known == "*" || known.strip_prefix("W/").unwrap_or(known) == etag)
}

/// Which part of `length` bytes with this strong entity tag is asked for.
///
/// A range of a version other than `If-Range` names, of another unit, of several pieces or of a form that cannot
/// be read is answered with the whole, as the RFC allows.
#[must_use]
pub fn part(headers: &HeaderMap, etag: &str, length: usize) -> Part {
    let text = |name| headers.get(name).and_then(|value: &axum::http::HeaderValue| value.to_str().ok());
    let Some(range) = text(header::RANGE) else { return Part::Whole };
    // A date or a weak tag never matches: the bytes have one strong tag.
    if headers.contains_key(header::IF_RANGE) && text(header::IF_RANGE) != Some(etag) {
        return Part::Whole;
    }
    range.strip_prefix("bytes=").map_or(Part::Whole, |range| read_range(range.trim(), length))
}

fn read_range(range: &str, length: usize) -> Part {
    let Some((first, last)) = range.split_once('-') else { return Part::Whole };
    match (number(first), number(last)) {
        (Some(first), None) if last.is_empty() => within(first, usize::MAX, length),
        (Some(first), Some(last)) if first <= last => within(first, last, length),
        (None, Some(0)) if first.is_empty() => Part::Outside,
        (None, Some(count)) if first.is_empty() => within(length.saturating_sub(count), usize::MAX, length),
        _ => Part::Whole,
    }
}

/// A whole number; one too large for any content stands for the end.
fn number(digits: &str) -> Option<usize> {
    let all_digits = !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit());
    all_digits.then(|| digits.parse().unwrap_or(usize::MAX))
}

fn within(first: usize, last: usize, length: usize) -> Part {
    if first >= length { Part::Outside } else { Part::Range { first, last: last.min(length - 1) } }
}

#[cfg(test)]
mod tests {
    use axum::http::{HeaderMap, HeaderName, HeaderValue};

    use super::{Part, matches_tag, part};

    const TAG: &str = "\"abc\"";

    fn asked(pairs: &[(&'static str, &'static str)]) -> Part {
        let pair = |(name, value): &(&'static str, &'static str)| {
            (HeaderName::from_static(name), HeaderValue::from_static(value))
        };
        part(&pairs.iter().map(pair).collect::<HeaderMap>(), TAG, 10)
    }

    #[test]
    fn ranges() {
        let range = |text| asked(&[("range", text)]);
        assert_eq!(range("bytes=0-3"), Part::Range { first: 0, last: 3 });
        assert_eq!(range("bytes=4-"), Part::Range { first: 4, last: 9 });
        assert_eq!(range("bytes=4-99999999999999999999999"), Part::Range { first: 4, last: 9 });
        assert_eq!(range("bytes=-3"), Part::Range { first: 7, last: 9 });
        assert_eq!(range("bytes=-30"), Part::Range { first: 0, last: 9 });
        assert_eq!(range("bytes=10-"), Part::Outside);
        assert_eq!(range("bytes=-0"), Part::Outside);
        for whole in
            ["bytes=3-1", "bytes=a-b", "bytes=", "bytes=-", "bytes=0-1,3-4", "lines=0-1", "bytes=+1-2"]
        {
            assert_eq!(range(whole), Part::Whole, "{whole}");
        }
        assert_eq!(asked(&[]), Part::Whole);
    }

    #[test]
    fn a_range_of_another_version_gives_the_whole() {
        let first = Part::Range { first: 0, last: 0 };
        assert_eq!(asked(&[("range", "bytes=0-0"), ("if-range", "\"abc\"")]), first);
        assert_eq!(asked(&[("range", "bytes=0-0"), ("if-range", "\"abd\"")]), Part::Whole);
        assert_eq!(asked(&[("range", "bytes=0-0"), ("if-range", "W/\"abc\"")]), Part::Whole);
        assert_eq!(
            asked(&[("range", "bytes=0-0"), ("if-range", "Sun, 06 Nov 1994 08:49:37 GMT")]),
            Part::Whole
        );
    }

    #[test]
    fn tags() {
        assert!(matches_tag("\"x\", \"abc\"", TAG));
        assert!(matches_tag("W/\"abc\"", TAG));
        assert!(matches_tag("*", TAG));
        assert!(!matches_tag("\"ab\"", TAG));
    }
}
