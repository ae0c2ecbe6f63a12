//! Which knife makes which chain (domain.md A5).
//!
//! Published: `\` to cutter 1, `/` to cutter 2, square across to cutter 1. The rule behind it: chains can be
//! cut by k knives exactly when no place of the roll lies strictly inside more than k of them. Where the
//! published rule does not cover a cut, or its choice collides, the fewest published choices are given up.

use std::cmp::Ordering;

use crate::planning::finding::{Code, Finding};
use crate::planning::tape::chain::{Chain, Slope};
use crate::planning::tape::label::{CourseLabel, CoursePlace};
use crate::planning::tolerance::ONE_PLACE_MM;

/// A chain on the roll.
#[derive(Debug, Clone, PartialEq)]
pub struct RollChain {
    /// What its course is called.
    pub course: CourseLabel,
    /// The course's place in the job document, for findings.
    pub place: CoursePlace,
    /// Smallest and largest roll coordinate in mm.
    pub range: (f64, f64),
    /// r - u of its piece in mm.
    pub offset_mm: f64,
    /// The knife that the published rule gives it, from 0.
    pub published: usize,
    /// Whether the published rule covers its cut.
    pub covered: bool,
}

/// The published choice for a chain: the index of the cutter, and whether the papers' Table 1 covers its cut.
#[must_use]
pub fn published(chain: &Chain) -> (usize, bool) {
    let cutter = usize::from(chain.slope == Slope::Rising);
    (cutter, chain.edge_to_edge && chain.turns <= 1)
}

/// A published choice given up weighs this much more than a slope that the rule does not cover.
const COVERED_COST: u64 = 1_000_000;

/// Gives each chain a knife, from 0.
///
/// # Errors
/// `TooManyKnives` for every stretch of the roll where more chains run side by side than there are knives,
/// naming course, u range and count.
pub fn assign(chains: &[RollChain], knives: usize) -> Result<(Vec<usize>, Vec<Finding>), Vec<Finding>> {
    let excess = excess(chains, knives);
    if !excess.is_empty() {
        return Err(excess);
    }
    let start = State { busy: [None; 2], cost: 0, last: None };
    let mut search = Search { chains, knives, states: vec![start], histories: Vec::new() };
    for &index in &by_start(chains) {
        search.give(index)?;
    }
    let given = search.best();
    let changed =
        (0..chains.len()).filter(|&i| chains[i].covered && knives > 1 && given[i] != chains[i].published);
    let findings = changed.map(|index| general_rule(&chains[index], given[index])).collect();
    Ok((given, findings))
}

fn general_rule(chain: &RollChain, given: usize) -> Finding {
    let message = format!(
        "course {}: the cut at u {:.3} to {:.3} mm goes to cutter {} instead of the published {}, because another cut needs that knife there",
        chain.course,
        chain.range.0 - chain.offset_mm,
        chain.range.1 - chain.offset_mm,
        given + 1,
        chain.published + 1
    );
    Finding::info(Code::GeneralRule, chain.place.to_string(), message)
}

/// The chains in the order in which they pass the knives: larger r first.
fn by_start(chains: &[RollChain]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..chains.len()).collect();
    order.sort_by(|&a, &b| passing(chains[a].range, chains[b].range).then(a.cmp(&b)));
    order
}

/// The order in which two stretches of the tape, smallest and largest coordinate, are begun by a knife.
#[must_use]
pub fn passing(one: (f64, f64), other: (f64, f64)) -> Ordering {
    begin(other).total_cmp(&begin(one)).then(other.0.total_cmp(&one.0))
}

/// Where a stretch is begun. One that is no longer than a place comes before those that begin at that place: a knife
/// that had made one of them would be past it.
fn begin((low, high): (f64, f64)) -> f64 {
    if high - low <= ONE_PLACE_MM { high + ONE_PLACE_MM } else { high }
}

/// Whether two chains, smallest and largest coordinate each, cannot be made by one knife: their open intervals overlap.
/// A chain square across is a place; a knife that is in the middle of another chain cannot leave it for that.
#[must_use]
pub fn collide(one: (f64, f64), other: (f64, f64)) -> bool {
    one.0 < other.1 - ONE_PLACE_MM && other.0 < one.1 - ONE_PLACE_MM
}

/// The stretches of the roll with too many chains side by side, one finding each.
fn excess(chains: &[RollChain], knives: usize) -> Vec<Finding> {
    let mut findings: Vec<Finding> = Vec::new();
    let (mut active, mut most, mut top) = (0_usize, 0, 0.0);
    for event in events(chains) {
        if event.begins {
            active += 1;
            if active == knives + 1 && most == 0 {
                top = chains[event.chain].range.1;
            }
            most = if active > knives { most.max(active) } else { most };
        } else {
            active -= 1;
            if active == knives && most > 0 {
                let low = chains[event.chain].range.0;
                findings.push(too_many(&chains[event.chain], (low, top), most, knives));
                most = 0;
            }
        }
    }
    findings.extend(crowded_squares(chains, knives));
    findings
}

/// A chain begins or ends, going down the roll.
struct Event {
    place: f64,
    begins: bool,
    chain: usize,
}

/// Intervals are open: one that ends where another begins does not run beside it, so each is drawn in by the
/// width of a place: half of it at each end.
fn events(chains: &[RollChain]) -> Vec<Event> {
    let mut events = Vec::new();
    for (chain, RollChain { range: (low, high), .. }) in chains.iter().enumerate() {
        let (low, high) = (low + ONE_PLACE_MM / 2.0, high - ONE_PLACE_MM / 2.0);
        if low < high {
            events.push(Event { place: high, begins: true, chain });
            events.push(Event { place: low, begins: false, chain });
        }
    }
    events.sort_by(|a, b| b.place.total_cmp(&a.place).then(a.chain.cmp(&b.chain)));
    events
}

/// Cuts square across in the middle of as many chains as there are knives.
fn crowded_squares(chains: &[RollChain], knives: usize) -> Vec<Finding> {
    let squares = chains.iter().filter(|chain| chain.range.1 - chain.range.0 <= ONE_PLACE_MM);
    let beside =
        |square: &RollChain| chains.iter().filter(|other| collide(square.range, other.range)).count();
    squares
        .filter(|square| beside(square) >= knives)
        .map(|square| too_many(square, square.range, beside(square) + 1, knives))
        .collect()
}

fn too_many(chain: &RollChain, range: (f64, f64), count: usize, knives: usize) -> Finding {
    let message = format!(
        "course {}: {count} cuts lie side by side between u {:.3} and {:.3} mm; the tape only runs forward and the \
         machine has {knives} {}. Change the outline there, or cut it from two courses",
        chain.course,
        range.0 - chain.offset_mm,
        range.1 - chain.offset_mm,
        if knives == 1 { "knife" } else { "knives" },
    );
    Finding::error(Code::TooManyKnives, chain.place.to_string(), message)
}

/// One way of giving the chains so far to knives.
#[derive(Clone, Copy)]
struct State {
    /// The chain that each knife is busy with, or made last.
    busy: [Option<usize>; 2],
    cost: u64,
    /// The last entry of its history.
    last: Option<usize>,
}

/// An entry of a history: this chain went to this knife, after that entry.
struct Given {
    chain: usize,
    knife: usize,
    before: Option<usize>,
}

/// A sweep along the roll that keeps, for each way in which the knives can be busy, the cheapest history.
struct Search<'a> {
    chains: &'a [RollChain],
    knives: usize,
    states: Vec<State>,
    histories: Vec<Given>,
}

impl Search<'_> {
    fn give(&mut self, index: usize) -> Result<(), Vec<Finding>> {
        let mut next: Vec<State> = Vec::new();
        for state in self.states.clone() {
            for knife in 0..self.knives {
                let free = state.busy[knife]
                    .is_none_or(|other| !collide(self.chains[other].range, self.chains[index].range));
                if free {
                    let extended = self.extended(state, knife, index);
                    insert(&mut next, extended, |busy| self.still_busy(busy, index));
                }
            }
        }
        if next.is_empty() {
            // The count of chains side by side was within the knives, so a free knife exists.
            let chain = &self.chains[index];
            let message =
                format!("course {}: no knife is free for a cut at r {:.3} mm", chain.course, chain.range.1);
            return Err(vec![Finding::error(Code::TooManyKnives, "", message)]);
        }
        self.states = next;
        Ok(())
    }

    fn extended(&mut self, mut state: State, knife: usize, chain: usize) -> State {
        self.histories.push(Given { chain, knife, before: state.last });
        state.last = Some(self.histories.len() - 1);
        state.busy[knife] = Some(chain);
        if knife != self.chains[chain].published {
            state.cost += if self.chains[chain].covered { COVERED_COST } else { 1 };
        }
        state
    }

    /// Chains that are over at the start of `index` no longer matter for what can follow.
    fn still_busy(&self, busy: [Option<usize>; 2], index: usize) -> [Option<usize>; 2] {
        let level = begin(self.chains[index].range);
        busy.map(|chain| chain.filter(|&other| self.chains[other].range.0 < level - ONE_PLACE_MM))
    }

    fn best(&self) -> Vec<usize> {
        let mut knives = vec![0; self.chains.len()];
        let mut entry = self.states.iter().min_by_key(|state| state.cost).and_then(|state| state.last);
        while let Some(given) = entry.map(|index| &self.histories[index]) {
            knives[given.chain] = given.knife;
            entry = given.before;
        }
        knives
    }
}

fn insert(states: &mut Vec<State>, state: State, busy: impl Fn([Option<usize>; 2]) -> [Option<usize>; 2]) {
    let key = busy(state.busy);
    match states.iter_mut().find(|other| busy(other.busy) == key) {
        Some(other) if other.cost <= state.cost => {}
        Some(other) => *other = state,
        None => states.push(state),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn chain(low: f64, high: f64, published: usize, covered: bool) -> RollChain {
        RollChain {
            course: 7.into(),
            place: CoursePlace::default(),
            range: (low, high),
            offset_mm: 0.0,
            published,
            covered,
        }
    }

    #[test]
    fn three_chains_side_by_side_are_named_with_place_and_count() {
        let chains =
            [chain(340.0, 400.0, 1, false), chain(320.0, 400.0, 0, false), chain(320.0, 380.0, 1, false)];
        let findings = assign(&chains, 2).unwrap_err();
        assert_eq!(findings.len(), 1);
        assert_eq!(findings[0].code, Code::TooManyKnives);
        assert!(
            findings[0]
                .message
                .starts_with("course 7: 3 cuts lie side by side between u 340.000 and 380.000 mm")
        );
    }

    #[test]
    fn neighbours_that_only_touch_share_a_knife() {
        let chains =
            [chain(360.0, 400.0, 1, false), chain(300.0, 400.0, 0, false), chain(300.0, 360.0, 1, false)];
        assert_eq!(assign(&chains, 2).unwrap().0, [1, 0, 1]);
    }

    #[test]
    fn ends_drawn_at_one_place_share_a_knife_whatever_rounding_has_made_of_them() {
        for off in [-9e-5, -2e-6, 2e-6, 9e-5] {
            let chains = [
                chain(340.0, 400.0, 1, false),
                chain(300.0, 400.0, 0, false),
                chain(300.0, 340.0 + off, 1, false),
            ];
            assert_eq!(assign(&chains, 2).unwrap().0, [1, 0, 1], "{off}");
        }
        let apart = [
            chain(340.0, 400.0, 1, false),
            chain(300.0, 400.0, 0, false),
            chain(300.0, 340.000_11, 1, false),
        ];
        assert!(assign(&apart, 2).is_err());
    }

    #[test]
    fn a_cut_square_across_at_the_place_where_another_begins_comes_first() {
        let (square, long) = ((340.0, 340.0), (300.0, 340.000_05));
        assert_eq!((passing(square, long), passing(long, square)), (Ordering::Less, Ordering::Greater));
        assert_eq!(passing((400.0, 500.0), square), Ordering::Less);
        assert_eq!(passing((300.0, 340.000_11), square), Ordering::Less, "it is begun before that place");
    }

    #[test]
    fn a_published_choice_gives_way_where_it_collides() {
        // A lengthwise cut keeps one knife from end to end, so both ends go to the other one.
        let chains =
            [chain(900.0, 1000.0, 0, true), chain(0.0, 1000.0, 0, false), chain(0.0, 100.0, 1, true)];
        let (given, findings) = assign(&chains, 2).unwrap();
        assert_eq!((given, findings.len()), (vec![1, 0, 1], 1));
        assert_eq!(findings[0].code, Code::GeneralRule);
    }

    #[test]
    fn one_knife_cuts_what_one_knife_can() {
        assert_eq!(assign(&[chain(0.0, 10.0, 1, true), chain(10.0, 20.0, 0, true)], 1).unwrap().0, [0, 0]);
        assert!(assign(&[chain(0.0, 10.0, 1, true), chain(9.0, 20.0, 0, true)], 1).is_err());
    }

    #[test]
    fn a_square_cut_amid_two_chains_needs_a_third_knife() {
        let chains = [chain(0.0, 100.0, 0, false), chain(0.0, 100.0, 1, false), chain(50.0, 50.0, 0, true)];
        assert!(assign(&chains, 2).is_err());
        assert!(assign(&chains, 1).is_err());
    }

    /// Every way of giving the chains to knives, tried one by one.
    fn brute_force(chains: &[RollChain], knives: usize) -> Option<u64> {
        let ways = knives.pow(chains.len() as u32);
        (0..ways)
            .filter_map(|way| {
                let knife = |index: usize| way / knives.pow(index as u32) % knives;
                let pairs = (0..chains.len()).flat_map(|a| (0..a).map(move |b| (a, b)));
                let valid = pairs
                    .into_iter()
                    .all(|(a, b)| knife(a) != knife(b) || !collide(chains[a].range, chains[b].range));
                valid.then(|| cost(chains, knife))
            })
            .min()
    }

    fn cost(chains: &[RollChain], knife: impl Fn(usize) -> usize) -> u64 {
        let broken = chains.iter().enumerate().filter(|(index, chain)| knife(*index) != chain.published);
        broken.map(|(_, chain)| if chain.covered { COVERED_COST } else { 1 }).sum()
    }

    proptest! {
        #[test]
        fn agrees_with_brute_force_on_what_can_be_cut_and_at_what_cost(
            drawn in prop::collection::vec((0..20_u32, 0..8_u32, 0..2_usize, any::<bool>()), 1..9),
            knives in 1..=2_usize,
        ) {
            let chains: Vec<_> = drawn.iter().map(|&(low, length, published, covered)| {
                chain(f64::from(low), f64::from(low + length), published.min(knives - 1), covered)
            }).collect();
            let ours = assign(&chains, knives).ok().map(|(given, _)| cost(&chains, |index| given[index]));
            prop_assert_eq!(ours, brute_force(&chains, knives));
        }
    }
}
