//! Defects and splices of the tape: stretches that are kept free of pieces, in mm from its leading end.

use super::input::TapeInput;
use crate::planning::finding::{Code, Finding};

/// Where zones stand in a job document.
const AT: &str = "/input/tape/zones_mm";
/// The most zones that a finding names.
const MOST_NAMED: usize = 5;

/// Zones in order. Those that overlap or touch are one.
pub fn check(zones: &[[f64; 2]], findings: &mut Vec<Finding>) -> Vec<(f64, f64)> {
    for (index, [from, to]) in zones.iter().enumerate() {
        if *from < 0.0 || from >= to {
            let message = format!("a zone runs from 0 or more to more than that, not from {from} to {to} mm");
            findings.push(Finding::error(Code::OutOfRange, format!("{AT}/{index}"), message));
        }
    }
    let mut sorted: Vec<(f64, f64)> = zones.iter().map(|[from, to]| (*from, *to)).collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let mut apart: Vec<(f64, f64)> = Vec::new();
    for zone in sorted {
        match apart.last_mut() {
            Some(last) if zone.0 <= last.1 => last.1 = last.1.max(zone.1),
            _ => apart.push(zone),
        }
    }
    apart
}

/// Zones that lie beyond the tape, which cannot be; and such as lie beyond what a roll of this length uses of it, which
/// decide nothing. Both may have been measured from the other end.
#[must_use]
pub fn unused(input: &TapeInput, used_mm: f64) -> Vec<Finding> {
    let holds = input.tape_length.map_or(f64::INFINITY, |length| length.mm());
    let (off, on): (Vec<_>, Vec<_>) = input.zones_mm.iter().partition(|zone| zone.1 > holds);
    let off = named(&off).map(|which| {
        let message = format!(
            "zones are measured from the leading end of the tape, which is {holds} mm long; beyond it: {which}"
        );
        Finding::warning(Code::ZoneUnused, AT, message)
    });
    let beyond: Vec<(f64, f64)> = on.into_iter().filter(|zone| zone.0 >= used_mm).collect();
    let beyond = named(&beyond).map(|which| {
        let message = format!(
            "the roll uses {used_mm:.1} mm of tape, from its leading end on; behind that, so that nothing is kept free: {which}"
        );
        Finding::info(Code::ZoneUnused, AT, message)
    });
    off.into_iter().chain(beyond).collect()
}

/// Zones in words; none if there are none.
fn named(zones: &[(f64, f64)]) -> Option<String> {
    let words = zones.iter().take(MOST_NAMED).map(|(from, to)| format!("{from} to {to} mm"));
    let words = words.collect::<Vec<_>>().join(", ");
    match zones.len() {
        0 => None,
        count if count > MOST_NAMED => Some(format!("{words} and {} more", count - MOST_NAMED)),
        _ => Some(words),
    }
}
