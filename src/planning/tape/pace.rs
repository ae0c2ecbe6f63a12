//! Which of the valid ways to give chains to knives takes the least time (domain.md A6, `free`).
//!
//! Chains that hang together on the roll can be given to two knives in two ways only; which of the two is open for
//! each group of them. A cutter stands `station_mm` further down the tape than the other, so a knife's cuts come later by
//! so much tape, and time is saved where both knives cut while the same tape passes. The estimate: a chain is slow by
//! its time over its length all along, and where both knives are busy the slower one decides. Dwells, travels and cuts square
//! across are left out: they are the same in nearly every way. Groups that lie farther apart than the stations and their
//! own lengths have no common time, so the search keeps the groups in reach only.

use super::assign::RollChain;
use super::block::Stretch;
use crate::planning::tolerance::ONE_PLACE_MM;

/// The most states that are kept: the ways of giving the last eight groups.
const MOST_STATES: usize = 256;

/// A chain as time sees it.
#[derive(Debug, Clone, Copy)]
struct Busy {
    /// Smallest and largest t in mm, from the leading end of the tape.
    span: Stretch,
    /// s for each mm of tape.
    slowness: f64,
}

/// Chains that hang together, by knife as given.
struct Group {
    chains: Vec<usize>,
    lists: [Vec<Busy>; 2],
    span: Stretch,
}

/// Swaps the two knives of groups of chains so that both cut at once as much as can be. `knives` is a valid way of giving
/// them, `seconds` what each chain takes at least, `apart_mm` how far the second cutter stands down the tape.
#[must_use]
pub fn least_time(chains: &[RollChain], seconds: &[f64], knives: Vec<usize>, apart_mm: f64) -> Vec<usize> {
    let groups = groups(chains, seconds, &knives);
    let swapped = best(&groups, apart_mm);
    let mut given = knives;
    for (group, swapped) in groups.iter().zip(swapped) {
        if swapped {
            group.chains.iter().for_each(|&chain| given[chain] = 1 - given[chain]);
        }
    }
    given
}

/// Groups of chains that hang together on the roll, as places in the list.
#[must_use]
pub fn hanging_together(chains: &[RollChain]) -> Vec<Vec<usize>> {
    let none = vec![0; chains.len()];
    groups(chains, &vec![0.0; chains.len()], &none).into_iter().map(|group| group.chains).collect()
}

impl Group {
    fn of_knife(&self, knife: usize, swapped: bool) -> &[Busy] {
        &self.lists[if swapped { 1 - knife } else { knife }]
    }
}

fn groups(chains: &[RollChain], seconds: &[f64], knives: &[usize]) -> Vec<Group> {
    let span = |index: usize| (-chains[index].range.1, -chains[index].range.0);
    let mut order: Vec<usize> = (0..chains.len()).collect();
    order.sort_by(|&a, &b| {
        let (one, other) = (span(a), span(b));
        one.0.total_cmp(&other.0).then(one.1.total_cmp(&other.1)).then(a.cmp(&b))
    });
    let mut groups: Vec<Group> = Vec::new();
    for index in order {
        let here = span(index);
        if groups.last().is_none_or(|group| here.0 >= group.span.1 - ONE_PLACE_MM) {
            groups.push(Group { chains: Vec::new(), lists: [Vec::new(), Vec::new()], span: here });
        }
        let Some(group) = groups.last_mut() else { continue };
        group.span.1 = group.span.1.max(here.1);
        group.chains.push(index);
        let length = here.1 - here.0;
        if length > ONE_PLACE_MM {
            group.lists[knives[index]].push(Busy { span: here, slowness: seconds[index] / length });
        }
    }
    groups
}

/// Which groups are swapped, of some that are still in reach of later ones.
#[derive(Clone)]
struct State {
    /// The groups in reach, as a history: this group was swapped or not, after that entry.
    last: Option<usize>,
    /// Of the groups in reach, first the last one.
    recent: Vec<bool>,
    saved_s: f64,
}

/// Whether each group is swapped.
fn best(groups: &[Group], apart_mm: f64) -> Vec<bool> {
    let mut history: Vec<(bool, Option<usize>)> = Vec::new();
    let mut states = vec![State { last: None, recent: Vec::new(), saved_s: 0.0 }];
    for (index, group) in groups.iter().enumerate() {
        let in_reach = |other: &Group| other.span.1 + apart_mm > group.span.0;
        let reached = groups[..index].iter().rev().take_while(|other| in_reach(other)).count();
        let mut next: Vec<State> = Vec::new();
        for state in &states {
            for swapped in [false, true] {
                let with = |(back, was): (usize, &bool)| {
                    saved(&groups[index - 1 - back], *was, group, swapped, apart_mm)
                };
                let others: f64 = state.recent.iter().take(reached).enumerate().map(with).sum();
                let own = saved_within(group, swapped, apart_mm);
                history.push((swapped, state.last));
                let mut recent: Vec<bool> = state.recent.iter().take(reached).copied().collect();
                recent.insert(0, swapped);
                next.push(State {
                    last: Some(history.len() - 1),
                    recent,
                    saved_s: state.saved_s + others + own,
                });
            }
        }
        states = kept(next);
    }
    let mut swapped = Vec::with_capacity(groups.len());
    let mut entry = states.first().and_then(|state| state.last);
    while let Some((this, before)) = entry.map(|index| history[index]) {
        swapped.push(this);
        entry = before;
    }
    swapped.reverse();
    swapped
}

/// Of states with the same groups in reach given alike, the one that saves most; the best one first. Groups as given go
/// before swapped ones where neither saves more.
fn kept(mut states: Vec<State>) -> Vec<State> {
    states.sort_by(|a, b| b.saved_s.total_cmp(&a.saved_s).then(a.recent.cmp(&b.recent)));
    let mut seen = std::collections::BTreeSet::new();
    states.retain(|state| seen.insert(state.recent.clone()));
    states.truncate(MOST_STATES);
    states
}

/// What two groups save together.
fn saved(one: &Group, one_swapped: bool, other: &Group, other_swapped: bool, apart_mm: f64) -> f64 {
    together(one.of_knife(0, one_swapped), other.of_knife(1, other_swapped), apart_mm)
        + together(other.of_knife(0, other_swapped), one.of_knife(1, one_swapped), apart_mm)
}

fn saved_within(group: &Group, swapped: bool, apart_mm: f64) -> f64 {
    together(group.of_knife(0, swapped), group.of_knife(1, swapped), apart_mm)
}

/// The time in s during which both the first knife, with these chains, and the second, with those, cut.
fn together(first: &[Busy], second: &[Busy], apart_mm: f64) -> f64 {
    let (mut one, mut other) = (first.iter().peekable(), second.iter().peekable());
    let mut seconds = 0.0;
    while let (Some(a), Some(b)) = (one.peek(), other.peek()) {
        let (from, to) = (b.span.0 + apart_mm, b.span.1 + apart_mm);
        let common = a.span.1.min(to) - a.span.0.max(from);
        if common > 0.0 {
            seconds += common * a.slowness.min(b.slowness);
        }
        if a.span.1 <= to {
            one.next();
        } else {
            other.next();
        }
    }
    seconds
}

#[cfg(test)]
mod tests {
    use super::super::label::CoursePlace;
    use super::*;
    use proptest::prelude::*;

    fn chain(low: f64, high: f64, knife: usize) -> RollChain {
        RollChain {
            course: 1.into(),
            place: CoursePlace::default(),
            range: (low, high),
            offset_mm: 0.0,
            published: knife,
            covered: true,
        }
    }

    #[test]
    fn two_cuts_a_station_apart_are_made_at_once() {
        // Larger r passes first. The second knife meets r = 0..50 when the first one meets -300..-250.
        let chains = [chain(0.0, 50.0, 0), chain(-300.0, -250.0, 0)];
        assert_eq!(least_time(&chains, &[5.0, 5.0], vec![0, 0], 300.0), [1, 0]);
        // Without such a chance all stay as given.
        assert_eq!(least_time(&chains, &[5.0, 5.0], vec![0, 0], 120.0), [0, 0]);
    }

    /// The time in s that is saved, instant by instant of tape.
    fn saved_by(chains: &[RollChain], seconds: &[f64], knives: &[usize], apart: i32) -> f64 {
        let slow = |knife: usize, x: f64| -> f64 {
            let here = |i: &usize| {
                let shift = f64::from(apart) * knife as f64;
                let (low, high) = (-chains[*i].range.1 + shift, -chains[*i].range.0 + shift);
                knives[*i] == knife && low < x && x < high
            };
            (0..chains.len()).filter(here).map(|i| seconds[i] / (chains[i].range.1 - chains[i].range.0)).sum()
        };
        (-200..200).map(|x| f64::from(x) + 0.5).map(|x| slow(0, x).min(slow(1, x))).sum()
    }

    proptest! {
        #[test]
        fn no_other_way_saves_more(
            drawn in prop::collection::vec((1..12_i32, 1..14_i32, 1..9_i32), 1..9),
            apart in 0..40_i32,
        ) {
            let mut r = 0;
            let mut chains = Vec::new();
            for (gap, length, _) in &drawn {
                chains.push(chain(f64::from(r - length), f64::from(r), 0));
                r -= length + gap - 1;
            }
            let seconds: Vec<f64> = drawn.iter().map(|(_, _, seconds)| f64::from(*seconds)).collect();
            let ours = least_time(&chains, &seconds, vec![0; chains.len()], f64::from(apart));
            let best = (0..1_usize << chains.len())
                .map(|way| (0..chains.len()).map(|i| way >> i & 1).collect::<Vec<_>>())
                .map(|knives| saved_by(&chains, &seconds, &knives, apart))
                .fold(0.0, f64::max);
            let saved = saved_by(&chains, &seconds, &ours, apart);
            prop_assert!((saved - best).abs() < 1e-9, "{} is less than {}", saved, best);
        }
    }
}
