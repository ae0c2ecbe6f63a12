//! The slits that a program makes, held against those that are wanted: each once, and no others.

use super::ReplaySetup;
use super::class::{MadeCut, same_swing};
use crate::planning::finding::{Code, Finding};
use crate::planning::geometry::Point2;
use crate::planning::honeycomb::blade::Side;
use crate::planning::tolerance::PRINTED_MM;

/// A slit that is wanted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WantedCut {
    /// x and z of the tip in mm.
    pub tip: Point2,
    /// To which side the blade leans.
    pub side: Side,
    /// By how much, in rad.
    pub swing: f64,
}

/// At most so many slits of one kind of fault are named.
const MOST_NAMED: usize = 20;

/// The largest distance between a slit and the wanted one, in mm; a slit that is missing or not wanted is an error.
#[must_use]
pub fn compare(setup: &ReplaySetup<'_>, made: &[MadeCut]) -> (f64, Vec<Finding>) {
    let mut open = Open::new(setup.wanted);
    let mut largest: f64 = 0.0;
    let mut unwanted = Vec::new();
    for cut in made {
        match open.take(cut) {
            Some(apart) => largest = largest.max(apart),
            None => unwanted.push(cut),
        }
    }
    let mut findings: Vec<Finding> =
        unwanted.iter().take(MOST_NAMED).map(|cut| not_wanted(setup, cut)).collect();
    findings.extend(open.rest().take(MOST_NAMED).map(missing));
    (largest, findings)
}

fn not_wanted(setup: &ReplaySetup<'_>, cut: &MadeCut) -> Finding {
    let words = format!(
        "cuts at x {:.4} z {:.4} mm, {} by {:.4} degrees: the plan has no such cut left here",
        cut.tip.x,
        cut.tip.y,
        leaning(cut.side),
        cut.swing.to_degrees()
    );
    Finding::error(Code::Unwanted, setup.at(cut.place), words)
}

fn missing(cut: &WantedCut) -> Finding {
    let words = format!(
        "the cut at x {:.4} z {:.4} mm, {} by {:.4} degrees, is not made",
        cut.tip.x,
        cut.tip.y,
        leaning(cut.side),
        cut.swing.to_degrees()
    );
    Finding::error(Code::Uncut, "", words)
}

fn leaning(side: Side) -> &'static str {
    match side {
        Side::Left => "left",
        Side::Right => "right",
    }
}

/// The wanted slits that have not been made yet, found by x.
struct Open<'a> {
    wanted: Vec<(&'a WantedCut, bool)>,
}

impl<'a> Open<'a> {
    fn new(wanted: &'a [WantedCut]) -> Self {
        let mut wanted: Vec<_> = wanted.iter().map(|cut| (cut, false)).collect();
        wanted.sort_by(|(one, _), (other, _)| {
            one.tip.x.total_cmp(&other.tip.x).then(one.tip.y.total_cmp(&other.tip.y))
        });
        Self { wanted }
    }

    /// Takes the wanted slit that was made, and says how far off it is.
    fn take(&mut self, made: &MadeCut) -> Option<f64> {
        let first = self.wanted.partition_point(|(cut, _)| cut.tip.x < made.tip.x - PRINTED_MM);
        let near =
            self.wanted[first..].iter_mut().take_while(|(cut, _)| cut.tip.x <= made.tip.x + PRINTED_MM);
        let fits = |cut: &WantedCut| {
            cut.side == made.side
                && same_swing(cut.swing, made.swing)
                && (cut.tip - made.tip).norm() <= PRINTED_MM
        };
        let found = near.into_iter().find(|(cut, taken)| !taken && fits(cut))?;
        found.1 = true;
        Some((found.0.tip - made.tip).norm())
    }

    fn rest(&self) -> impl Iterator<Item = &'a WantedCut> {
        self.wanted.iter().filter(|(_, taken)| !taken).map(|(cut, _)| *cut)
    }
}

/// How many places the tip cuts at.
#[must_use]
pub fn different_tips(made: &[MadeCut]) -> usize {
    let digit = |value: f64| (value / PRINTED_MM).round() as i64;
    let places: std::collections::BTreeSet<_> =
        made.iter().map(|cut| (digit(cut.tip.x), digit(cut.tip.y))).collect();
    places.len()
}
