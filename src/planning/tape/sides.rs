//! Knives for carriages on one beam, where any allocation will do (domain.md A6, `free`).
//!
//! Two carriages on one beam cannot pass one another, so the knives that are quickest may not be able to work at all. Chains
//! that hang together on the roll can be given to two knives in two ways. Tried are the ways as given, each group by the
//! sides on which its chains lie, and then, group by group, the other way for those that meet in a conflict, as long as
//! that leaves fewer, or less that is lacking. It is no search of all ways, and no piece is moved for it.

use super::beam::{Beam, Conflict};
use super::input::TapeInput;
use super::pace::hanging_together;
use super::plan::TapePlan;
use super::timeline::conflicts;

/// The most timelines that are tried: each takes the time of one.
const MOST_TRIES: usize = 64;

/// Gives chains to knives so that carriages on one beam keep apart, as far as that is found.
pub fn keep_sides(plan: &mut TapePlan, input: &TapeInput) {
    let Some(beam) = Beam::of(&input.machine) else { return };
    let mut sides = Sides { groups: groups(plan), knives: plan.knives(), plan, input, tries: 0 };
    let mut found = sides.conflicts();
    if cost(found.as_deref()).0 == 0 {
        return;
    }
    let given = sides.knives.clone();
    sides.by_side(beam.above());
    let by_side = sides.conflicts();
    if cost(by_side.as_deref()) < cost(found.as_deref()) {
        found = by_side;
    } else {
        sides.knives = given;
    }
    sides.turn_groups(found.unwrap_or_default());
    sides.give();
}

/// What carriages on one beam lack in a plan: how many times they meet, and by how much altogether in mm.
#[must_use]
pub fn lacking(plan: &TapePlan, input: &TapeInput) -> (usize, f64) {
    cost(conflicts_of(plan, input).as_deref())
}

/// `None` where the tape would run back: then there is no timeline at all.
fn conflicts_of(plan: &TapePlan, input: &TapeInput) -> Option<Vec<Conflict>> {
    let strokes = super::axis_strokes(plan, input).ok()?;
    Some(conflicts(strokes, &input.machine))
}

/// What conflicts weigh: first how many there are, then how much is lacking. Nothing is worse than no timeline.
fn cost(found: Option<&[Conflict]>) -> (usize, f64) {
    let of = |found: &[Conflict]| (found.len(), found.iter().map(|conflict| conflict.short_mm).sum());
    found.map_or((usize::MAX, f64::INFINITY), of)
}

/// Chains that hang together, as places in the order of [`TapePlan::knives`].
fn groups(plan: &TapePlan) -> Vec<Vec<usize>> {
    hanging_together(&plan.made_chains())
}

struct Sides<'a> {
    plan: &'a mut TapePlan,
    input: &'a TapeInput,
    groups: Vec<Vec<usize>>,
    knives: Vec<usize>,
    tries: usize,
}

impl Sides<'_> {
    fn give(&mut self) {
        self.plan.give(&self.knives);
    }

    fn conflicts(&mut self) -> Option<Vec<Conflict>> {
        self.tries += 1;
        self.give();
        conflicts_of(self.plan, self.input)
    }

    /// The carriage above gets what lies above.
    fn by_side(&mut self, above: usize) {
        let middles = self.plan.middles_v();
        for group in &self.groups {
            let sum = |knife: usize| -> f64 {
                group.iter().filter(|&&chain| self.knives[chain] == knife).map(|&chain| middles[chain]).sum()
            };
            if sum(above) < sum(1 - above) {
                group.iter().for_each(|&chain| self.knives[chain] = 1 - self.knives[chain]);
            }
        }
    }

    fn turn(&mut self, group: usize) {
        for &chain in &self.groups[group] {
            self.knives[chain] = 1 - self.knives[chain];
        }
    }

    /// Turns groups that meet in a conflict the other way, one by one and all at once, as long as less of conflicts is left.
    fn turn_groups(&mut self, mut found: Vec<Conflict>) {
        let mut at = 0;
        while at < found.len() && self.tries < MOST_TRIES {
            let least = cost(Some(&found));
            let meet = self.meeting(&found[at]);
            let ways = meet.iter().map(|&group| vec![group]).chain([meet.clone()]);
            let mut better = None;
            for way in ways.filter(|way| !way.is_empty()) {
                way.iter().for_each(|&group| self.turn(group));
                let left = self.conflicts();
                if cost(left.as_deref()) < least {
                    better = left;
                    break;
                }
                way.iter().for_each(|&group| self.turn(group));
            }
            match better {
                Some(left) => (found, at) = (left, 0),
                None => at += 1,
            }
        }
    }

    /// The groups in which the chains lie that meet in a conflict.
    fn meeting(&self, conflict: &Conflict) -> Vec<usize> {
        let chains = self.plan.made_chains();
        let courses = [Some(conflict.course), conflict.other];
        let machine = &self.input.machine;
        let lead_mm = self.plan.figures.lead_mm;
        let here = |chain: usize| {
            let x_of_r0 = lead_mm + machine.cutters[self.knives[chain]].station.mm();
            let (low, high) = chains[chain].range;
            courses.contains(&Some(chains[chain].course))
                && x_of_r0 - high <= conflict.x.1
                && conflict.x.0 <= x_of_r0 - low
        };
        (0..self.groups.len()).filter(|&group| self.groups[group].iter().any(|&chain| here(chain))).collect()
    }
}
