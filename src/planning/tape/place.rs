//! Where the pieces of a roll go: each as close to the earlier ones as outlines and knives allow (domain.md A6).
//!
//! Pieces are placed in the order in which they pass the knives, from the leading end of the tape on. Outlines first:
//! the fronts of a piece cover the whole width of the tape and its start nowhere lies before its finish, so one that
//! keeps clear of the piece before it keeps clear of all earlier ones. Knives: whatever earlier chain can still be
//! reached counts, of whatever piece.
//!
//! **Least tape.** Each piece is best placed as near to the one before it as it can be, for what follows then depends on
//! the distance to it alone. Were a chain of the piece before it in reach beyond its own start, some places of the roll
//! would lie in the start of that one, in the finish of the piece and in its start, because every front goes across
//! the whole tape and each lies behind the other: in three chains, and there are two knives at most. Only a cut that both
//! share counts once and may stay in reach, where it can keep the next piece from sharing; a finish of the piece's own
//! would lie in the same place, so sharing is never the worse way on. [`least_tape`] says what each pair of neighbours
//! needs for itself. No roll is shorter, so a roll of that length is proved to be the least.

use super::block::{Block, Group, Rule, Run, Stretch, Way, levels, overlapping};
use super::front::{Between, between};
use crate::planning::budget::Budget;
use crate::planning::finding::Finding;
use crate::planning::tolerance::{SAME_POINT_MM, SHARED_CUT_SHARE};

/// Positions are whole multiples of this, in mm: a program's last printed digit.
pub const STEP_MM: f64 = 1e-4;

/// What pieces are placed on, and how.
#[derive(Debug, Clone, Copy)]
pub struct Tape<'a> {
    /// How much of it lies before the first piece at the least, in mm.
    pub ahead_mm: f64,
    /// Scrap between pieces along U in mm.
    pub gap_mm: f64,
    /// Stretches of the tape in mm from its leading end that are kept free of pieces, sorted.
    pub zones: &'a [Stretch],
    /// How many knives there are.
    pub knives: usize,
    /// How they are given.
    pub rule: Rule,
    /// Where congruent neighbours may share a cut: the chord tolerance in mm.
    pub share_mm: Option<f64>,
}

/// A piece in its place.
#[derive(Debug, Clone, PartialEq)]
pub struct Place {
    /// Where its u = 0 lies, in mm from the leading end of the tape.
    pub at_mm: f64,
    /// For each of its chains whether its knife is as given or swapped.
    pub ways: Vec<Way>,
    /// Whether its finish is the cut that the piece before it has as its start: how far, in mm, the two are apart
    /// at most.
    pub shared_mm: Option<f64>,
}

/// Places pieces, given in the order in which they pass the knives.
///
/// # Errors
/// `BudgetSpent` or `Cancelled`: a step is spent for each two stretches that a place is looked at for.
pub fn place(blocks: &[&Block], tape: &Tape<'_>, budget: &Budget<'_>) -> Result<Vec<Place>, Finding> {
    let mut search = Search { tape, blocks, budget, placed: Vec::new() };
    let Some(mut state) = search.first() else { return Ok(Vec::new()) };
    for index in 1..blocks.len() {
        state = search.next(&state, index)?;
    }
    Ok(search.placed)
}

/// The length of tape in mm below which no roll can stay, however knives are given: each pair of neighbours for itself,
/// as near to each other as their outlines and their own chains allow.
#[must_use]
pub fn least_tape(blocks: &[&Block], tape: &Tape<'_>) -> f64 {
    let tape = Tape { rule: Rule::Count, zones: &[], ..*tape };
    let apart = blocks.windows(2).map(|pair| {
        let start = Live::of(reachable(&pair[0].runs, 0.0, pair[0]), &tape);
        let meeting = Meeting::of(pair[0], pair[1], &tape);
        let contact = up(meeting.contact_mm(0.0, tape.gap_mm));
        let alone = pair[1].groups_under(Rule::Count, None);
        let shared = meeting.shared_mm.zip(pair[1].lead_cut).filter(|(_, cut)| {
            let others = pair[1].groups_under(Rule::Count, Some(*cut));
            start.free(&others, pair[1], contact, &tape) == contact
        });
        let at = if shared.is_some() { contact } else { start.free(&alone, pair[1], contact, &tape) };
        mm(at)
    });
    length(blocks, &tape, apart.sum())
}

/// The length of tape in mm with all pieces touching, whatever the knives could do.
#[must_use]
pub fn touching_tape(blocks: &[&Block], tape: &Tape<'_>) -> f64 {
    let apart = blocks.windows(2).map(|pair| -between(&pair[1].lead, 0.0, &pair[0].trail, 0.0).clearance_mm);
    length(blocks, tape, apart.sum())
}

/// The length of a roll whose first and last piece are so far apart, u = 0 to u = 0.
fn length(blocks: &[&Block], tape: &Tape<'_>, apart_mm: f64) -> f64 {
    match (blocks.first(), blocks.last()) {
        (Some(first), Some(last)) => tape.ahead_mm + first.u.1 + apart_mm - last.u.0,
        _ => 0.0,
    }
}

/// Steps up to a position in mm. What rounding adds to a place is no step.
fn up(position_mm: f64) -> i64 {
    ((position_mm - SAME_POINT_MM) / STEP_MM).ceil() as i64
}

/// A position in mm.
#[must_use]
pub fn mm(steps: i64) -> f64 {
    steps as f64 * STEP_MM
}

/// How a piece meets the one before it.
#[derive(Debug, Clone, Copy)]
struct Meeting {
    between: Between,
    /// How far the two ends are apart at most where they touch, if they are one cut.
    shared_mm: Option<f64>,
}

impl Meeting {
    fn of(before: &Block, block: &Block, tape: &Tape<'_>) -> Self {
        let between = between(&block.lead, 0.0, &before.trail, 0.0);
        let shared_mm = tape.share_mm.and_then(|tolerance| {
            let spread = between.largest_mm - between.clearance_mm + STEP_MM;
            let one_cut = tape.gap_mm == 0.0 && spread <= SHARED_CUT_SHARE * tolerance;
            let (lead, trail) = (block.lead_cut?, before.trail_cut?);
            let whole = block.lead.is_whole() && before.trail.is_whole();
            (one_cut && whole && alike(block, lead, before, trail)).then_some(spread)
        });
        Self { between, shared_mm }
    }

    fn contact_mm(&self, before_mm: f64, gap_mm: f64) -> f64 {
        before_mm + gap_mm - self.between.clearance_mm
    }
}

/// Whether two cuts fall into equally many chains.
fn alike(block: &Block, lead: usize, before: &Block, trail: usize) -> bool {
    let count = |block: &Block, cut: usize| block.runs.iter().filter(|run| run.cut == cut).count();
    count(block, lead) == count(before, trail)
}

/// The chains that later pieces can still reach.
#[derive(Debug, Clone, PartialEq)]
struct Live {
    runs: Vec<Run>,
    /// By knife, or by how many run side by side.
    lists: Vec<Vec<Stretch>>,
    /// The largest t of any.
    reach_mm: f64,
}

/// The chains of a piece at a position that later pieces can reach: none of these has anything before the smallest t
/// of its start.
fn reachable(runs: &[Run], at_mm: f64, block: &Block) -> Vec<Run> {
    let floor = at_mm - block.trail.largest_u();
    let on_tape = runs.iter().map(|run| Run { span: (run.span.0 + at_mm, run.span.1 + at_mm), ..*run });
    on_tape.filter(|run| run.span.1 > floor).collect()
}

impl Live {
    fn of(runs: Vec<Run>, tape: &Tape<'_>) -> Self {
        let spans = |knife: Option<usize>| -> Vec<Stretch> {
            let of_knife = runs.iter().filter(|run| knife.is_none_or(|knife| run.knife == knife));
            of_knife.map(|run| run.span).collect()
        };
        let lists = match tape.rule {
            Rule::Count => levels(&spans(None), tape.knives),
            Rule::Given => (0..tape.knives).map(|knife| sorted(spans(Some(knife)))).collect(),
        };
        let reach_mm = runs.iter().map(|run| run.span.1).fold(f64::NEG_INFINITY, f64::max);
        Self { runs, lists, reach_mm }
    }

    /// The first position, in steps from `from` on, at which a piece with these groups meets no busy knife and no zone.
    fn free(&self, groups: &[Group], block: &Block, from: i64, tape: &Tape<'_>) -> i64 {
        let mut at = from;
        loop {
            let here = mm(at);
            let reached = groups.iter().filter(|group| group.span.0 + here < self.reach_mm);
            let knives = reached.filter_map(|group| self.over(group, here, tape.knives));
            let zone =
                tape.zones.iter().filter(|zone| covers(block, here, **zone)).map(|zone| zone.1 + block.u.1);
            let Some(over) = knives.chain(zone).reduce(f64::max) else { return at };
            at = up(over).max(at + 1);
        }
    }

    /// Where the piece must go at least so that this group can be cut; none if it can be here.
    fn over(&self, group: &Group, at_mm: f64, knives: usize) -> Option<f64> {
        let ways = group.ways.iter().map(|way| self.over_in(group, *way, at_mm, knives));
        ways.reduce(|one, other| Some(one?.min(other?))).flatten()
    }

    fn over_in(&self, group: &Group, way: Way, at_mm: f64, knives: usize) -> Option<f64> {
        let lists =
            group.lists.iter().enumerate().map(|(knife, list)| (list, &self.lists[way.of(knife, knives)]));
        let conflicts = lists.flat_map(|(list, busy)| {
            list.iter().flat_map(move |span| {
                overlapping(busy, (span.0 + at_mm, span.1 + at_mm)).map(move |other| other.1 - span.0)
            })
        });
        conflicts.reduce(f64::max)
    }

    /// How many stretches of these groups could meet one of a busy knife.
    fn pairs(&self, groups: &[Group]) -> usize {
        let count = |lists: &[Vec<Stretch>]| lists.iter().map(Vec::len).sum::<usize>();
        count(&self.lists) * groups.iter().map(|group| count(&group.lists)).sum::<usize>()
    }
}

/// Whether a piece at a position lies in a zone, by more than what rounding adds to a place.
fn covers(block: &Block, at_mm: f64, zone: Stretch) -> bool {
    at_mm - block.u.1 < zone.1 - SAME_POINT_MM && zone.0 < at_mm - block.u.0 - SAME_POINT_MM
}

/// The pieces so far: what decides where the next one goes.
#[derive(Debug, Clone)]
struct State {
    /// Where the last one is, in steps.
    at: i64,
    live: Live,
}

struct Search<'a> {
    tape: &'a Tape<'a>,
    blocks: &'a [&'a Block],
    budget: &'a Budget<'a>,
    placed: Vec<Place>,
}

/// One place of a piece after a state.
struct Candidate<'a> {
    at: i64,
    groups: &'a [Group],
    shared_mm: Option<f64>,
}

impl Search<'_> {
    fn first(&mut self) -> Option<State> {
        let block = self.blocks.first()?;
        let nothing = Live::of(Vec::new(), self.tape);
        let at = nothing.free(block.groups(), block, up(self.tape.ahead_mm + block.u.1), self.tape);
        let candidate = Candidate { at, groups: block.groups(), shared_mm: None };
        Some(self.put(&nothing, 0, &candidate))
    }

    /// Puts the piece of that index: where it shares a cut if that can be, else as near as it can be.
    fn next(&mut self, state: &State, index: usize) -> Result<State, Finding> {
        let (before, block) = (self.blocks[index - 1], self.blocks[index]);
        self.budget.spend(1 + state.live.pairs(block.groups()) as u64)?;
        let meeting = Meeting::of(before, block, self.tape);
        let contact = up(meeting.contact_mm(mm(state.at), self.tape.gap_mm));
        let others = meeting.shared_mm.and(block.lead_cut).map(|cut| block.groups_without(cut));
        let others = others.filter(|others| state.live.free(others, block, contact, self.tape) == contact);
        if let Some(groups) = &others {
            let candidate = Candidate { at: contact, groups, shared_mm: meeting.shared_mm };
            return Ok(self.put(&state.live, index, &candidate));
        }
        let groups = block.groups();
        let at = state.live.free(groups, block, contact, self.tape);
        Ok(self.put(&state.live, index, &Candidate { at, groups, shared_mm: None }))
    }

    fn put(&mut self, live: &Live, index: usize, candidate: &Candidate<'_>) -> State {
        let block = self.blocks[index];
        let at_mm = mm(candidate.at);
        let mut ways = vec![Way::Straight; block.runs.len()];
        let mut runs: Vec<Run> = Vec::new();
        for group in candidate.groups {
            let free = |way: &&Way| live.over_in(group, **way, at_mm, self.tape.knives).is_none();
            let way = group.ways.iter().find(free).copied().unwrap_or(Way::Straight);
            for &chain in &group.chains {
                ways[chain] = way;
                let run = block.runs[chain];
                runs.push(Run { knife: way.of(run.knife, self.tape.knives), ..run });
            }
        }
        let floor = at_mm - block.trail.largest_u();
        let mut left = reachable(&runs, at_mm, block);
        left.extend(live.runs.iter().filter(|run| run.span.1 > floor));
        self.placed.push(Place { at_mm, ways, shared_mm: candidate.shared_mm });
        State { at: candidate.at, live: Live::of(left, self.tape) }
    }
}

fn sorted(mut spans: Vec<Stretch>) -> Vec<Stretch> {
    spans.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    spans
}

#[cfg(test)]
mod tests {
    use super::super::assign::published;
    use super::super::chain::split;
    use super::super::developed::DevelopedPly;
    use super::super::piece::within_strip;
    use super::*;
    use crate::planning::finding::Code;
    use crate::planning::geometry::Point2;
    use proptest::prelude::*;

    const HALF_MM: f64 = 10.0;

    /// A piece by the u of its start and of its finish at v = -10, 0 and 10.
    #[derive(Debug, Clone, Copy)]
    struct Drawn {
        start: [i32; 3],
        finish: [i32; 3],
    }

    fn drawn(start: [i32; 3], finish: [i32; 3]) -> Drawn {
        Drawn { start, finish }
    }

    fn block(drawn: &Drawn, knives: usize, rule: Rule) -> Block {
        let (s, f) = (drawn.start.map(f64::from), drawn.finish.map(f64::from));
        let outline = [(s[0], -10.0), (f[0], -10.0), (f[1], 0.0), (f[2], 10.0), (s[2], 10.0), (s[1], 0.0)];
        let boundary = outline.map(|(u, v)| Some(Point2::new(u, v))).to_vec();
        let piece =
            within_strip(&DevelopedPly { boundary: boundary.into(), holes: vec![], on_mould: None }, 20.0)
                .unwrap()
                .remove(0);
        let cuts = piece.cuts().enumerate();
        let chains: Vec<_> = cuts.flat_map(|(index, cut)| split(index, cut, HALF_MM)).collect();
        let given: Vec<_> = chains
            .into_iter()
            .map(|chain| {
                let knife = published(&chain).0.min(knives - 1);
                (chain, knife)
            })
            .collect();
        Block::new(&piece, &given, HALF_MM, knives, rule)
    }

    fn tape(knives: usize, rule: Rule) -> Tape<'static> {
        Tape { ahead_mm: 0.0, gap_mm: 0.0, zones: &[], knives, rule, share_mm: None }
    }

    fn placed(pieces: &[Drawn], tape: &Tape<'_>) -> (f64, f64) {
        let blocks: Vec<Block> = pieces.iter().map(|piece| block(piece, tape.knives, tape.rule)).collect();
        let blocks: Vec<&Block> = blocks.iter().collect();
        let places = place(&blocks, tape, &Budget::unwatched()).unwrap();
        let last = blocks[blocks.len() - 1];
        (places[places.len() - 1].at_mm - last.u.0, least_tape(&blocks, tape))
    }

    /// The stretches of an end, and those of no length: without any code of the planner.
    fn stretches(ends: [i32; 3], at: i32) -> Vec<(i32, i32)> {
        let t = ends.map(|u| at - u);
        let (low, high) = (t[0].min(t[2]), t[0].max(t[2]));
        if (low..=high).contains(&t[1]) {
            vec![(low, high)]
        } else {
            [t[0], t[2]]
                .map(|end| (end.min(t[1]), end.max(t[1])))
                .into_iter()
                .filter(|(a, b)| a < b)
                .collect()
        }
    }

    fn valid(pieces: &[Drawn], at: &[i32], tape: &Tape<'_>) -> bool {
        let knives = tape.knives;
        let is_one_cut = |i: usize| {
            i > 0 && (0..3).all(|v| at[i] - pieces[i].finish[v] == at[i - 1] - pieces[i - 1].start[v])
        };
        let made = |i: usize| {
            let finish = (tape.share_mm.is_none() || !is_one_cut(i)).then_some(pieces[i].finish);
            std::iter::once(pieces[i].start).chain(finish)
        };
        let all: Vec<(i32, i32)> =
            (0..pieces.len()).flat_map(|i| made(i).flat_map(move |end| stretches(end, at[i]))).collect();
        let deep = |inside: &dyn Fn(&(i32, i32)) -> bool| all.iter().filter(|span| inside(span)).count();
        let between = all
            .iter()
            .all(|&(low, high)| (low..high).all(|t| deep(&|other| other.0 <= t && t < other.1) <= knives));
        let places = all
            .iter()
            .filter(|(low, high)| low == high)
            .all(|&(t, _)| deep(&|other| other.0 < t && t < other.1) < knives);
        between && places
    }

    /// The shortest tape of all whole positions, and of those with each piece beyond the one before it.
    fn brute_force(pieces: &[Drawn], tape: &Tape<'_>, at: &mut Vec<i32>) -> i32 {
        let index = at.len();
        if index == pieces.len() {
            let shortest = at[index - 1] - pieces[index - 1].start.iter().min().unwrap();
            return if valid(pieces, at, tape) { shortest } else { i32::MAX };
        }
        let finish = pieces[index].finish;
        let first = match index {
            0 => *finish.iter().max().unwrap(),
            _ => (0..3).map(|v| at[index - 1] + finish[v] - pieces[index - 1].start[v]).max().unwrap(),
        };
        let apart = if index == 0 { 0 } else { 24 };
        (first..=first + apart)
            .map(|here| {
                at.push(here);
                let shortest = brute_force(pieces, tape, at);
                at.pop();
                shortest
            })
            .min()
            .unwrap()
    }

    #[test]
    fn parallel_ends_of_one_slope_nest_when_knives_are_free_and_not_by_slope() {
        let pieces = [drawn([0, 5, 10], [20, 25, 30]), drawn([0, 5, 10], [20, 25, 30])];
        assert_eq!(placed(&pieces, &tape(2, Rule::Count)), (50.0, 50.0));
        assert_eq!(placed(&pieces, &tape(2, Rule::Given)).0, 60.0);
        assert_eq!(placed(&pieces, &tape(1, Rule::Count)).0, 60.0, "one knife cannot");
        // What is one cut is made once, by any rule and any number of knives.
        for knives in [1, 2] {
            let shared = Tape { share_mm: Some(0.01), ..tape(knives, Rule::Given) };
            assert_eq!(placed(&pieces, &shared), (50.0, 50.0));
        }
        let apart = Tape { gap_mm: 3.0, share_mm: Some(0.01), ..tape(2, Rule::Count) };
        assert_eq!(placed(&pieces, &apart).0, 53.0);
    }

    #[test]
    fn ends_that_are_not_one_cut_share_nothing() {
        let pieces = [drawn([0, 5, 10], [20, 25, 30]), drawn([0, 5, 10], [20, 24, 30])];
        let shared = Tape { share_mm: Some(0.01), ..tape(2, Rule::Given) };
        let blocks: Vec<Block> = pieces.iter().map(|piece| block(piece, 2, Rule::Given)).collect();
        let blocks: Vec<&Block> = blocks.iter().collect();
        assert!(
            place(&blocks, &shared, &Budget::unwatched())
                .unwrap()
                .iter()
                .all(|place| place.shared_mm.is_none())
        );
    }

    #[test]
    fn zones_are_kept_free_and_the_piece_goes_behind() {
        let pieces = [drawn([0, 0, 0], [20, 20, 20]), drawn([0, 0, 0], [30, 30, 30])];
        let at = |zones: &[(f64, f64)]| {
            let blocks: Vec<Block> = pieces.iter().map(|piece| block(piece, 2, Rule::Given)).collect();
            let blocks: Vec<&Block> = blocks.iter().collect();
            let tape = Tape { zones, ..tape(2, Rule::Given) };
            let places = place(&blocks, &tape, &Budget::unwatched()).unwrap();
            places.iter().map(|place| place.at_mm).collect::<Vec<_>>()
        };
        assert_eq!(at(&[]), [20.0, 50.0]);
        assert_eq!(at(&[(20.0, 25.0)]), [20.0, 55.0], "it may begin where a piece ends");
        assert_eq!(at(&[(0.0, 3.0), (30.0, 31.0)]), [23.0, 61.0]);
        assert_eq!(at(&[(19.0, 19.5), (45.0, 50.0)]), [39.5, 80.0], "too short between two");
    }

    fn pieces(count: std::ops::Range<usize>) -> impl Strategy<Value = Vec<Drawn>> {
        let end = |from: i32, to: i32| [from..to, from..to, from..to];
        prop::collection::vec(
            (end(0, 6), end(5, 10)).prop_map(|(start, finish)| {
                // No start beyond its finish, and no piece that is only a point across the tape.
                Drawn { start, finish: [0, 1, 2].map(|v| finish[v].max(start[v] + 1)) }
            }),
            count,
        )
        .prop_filter("starts lie before finishes", |pieces| {
            pieces.iter().all(|piece| valid(std::slice::from_ref(piece), &[0], &tape(2, Rule::Count)))
        })
    }

    fn blocks_of(pieces: &[Drawn], tape: &Tape<'_>) -> Vec<Block> {
        pieces.iter().map(|piece| block(piece, tape.knives, tape.rule)).collect()
    }

    fn shared(pieces: &[Drawn], tape: &Tape<'_>) -> Vec<(f64, bool)> {
        let blocks = blocks_of(pieces, tape);
        let blocks: Vec<&Block> = blocks.iter().collect();
        let places = place(&blocks, tape, &Budget::unwatched()).unwrap();
        places.iter().map(|place| (place.at_mm, place.shared_mm.is_some())).collect()
    }

    /// Two thin pieces with long slanted ends behind a long one: were both cuts between them shared, the starts of all
    /// three would lie side by side. The start of the first is two pieces back when the third is placed.
    #[test]
    fn a_chain_two_pieces_back_keeps_a_cut_from_being_shared() {
        let (long, thin) = (drawn([0, 5, 10], [20, 20, 20]), drawn([0, 5, 10], [3, 8, 13]));
        let sharing = Tape { share_mm: Some(0.01), ..tape(2, Rule::Count) };
        assert_eq!(shared(&[long, thin], &sharing), [(20.0, false), (23.0, true)]);
        assert_eq!(shared(&[long, thin, thin], &sharing), [(20.0, false), (23.0, true), (33.0, false)]);
        assert_eq!(brute_force(&[long, thin, thin], &sharing, &mut Vec::new()), 33);
    }

    #[test]
    fn a_budget_ends_the_placing() {
        let pieces = [drawn([0, 5, 10], [20, 25, 30]); 40];
        let tape = tape(2, Rule::Count);
        let blocks = blocks_of(&pieces, &tape);
        let blocks: Vec<&Block> = blocks.iter().collect();
        let never = std::sync::atomic::AtomicBool::new(false);
        let spent = place(&blocks, &tape, &Budget::new(39, &never, &|_| {})).unwrap_err();
        assert_eq!(spent.code, Code::BudgetSpent);
        assert!(place(&blocks, &tape, &Budget::new(10_000, &never, &|_| {})).is_ok());
        let cancelled = std::sync::atomic::AtomicBool::new(true);
        let ended = place(&blocks, &tape, &Budget::new(10_000, &cancelled, &|_| {})).unwrap_err();
        assert_eq!(ended.code, Code::Cancelled);
    }

    /// Thin pieces with deep ends, most of which begin as the one before ends.
    fn thin_pieces() -> impl Strategy<Value = Vec<Drawn>> {
        let thickness = || [1..9_i32, 1..9_i32, 1..9_i32];
        let piece = (thickness(), prop::option::weighted(0.2, [0..9_i32, 0..9_i32, 0..9_i32]));
        ([0..9_i32, 0..9_i32, 0..9_i32], prop::collection::vec(piece, 3..5))
            .prop_map(|(mut finish, pieces)| {
                let mut drawn = Vec::new();
                for (thickness, other) in pieces {
                    finish = other.unwrap_or(finish);
                    let start = [0, 1, 2].map(|v| finish[v] - thickness[v]);
                    drawn.push(Drawn { start, finish });
                    finish = start;
                }
                drawn
            })
            .prop_filter("each can be cut", |pieces| {
                pieces.iter().all(|piece| valid(std::slice::from_ref(piece), &[0], &tape(2, Rule::Count)))
            })
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, ..ProptestConfig::default() })]
        #[test]
        fn no_whole_positions_with_shared_cuts_are_shorter(pieces in thin_pieces()) {
            let sharing = Tape { share_mm: Some(0.01), ..tape(2, Rule::Count) };
            let (ours, least) = placed(&pieces, &sharing);
            let shortest = f64::from(brute_force(&pieces, &sharing, &mut Vec::new()));
            prop_assert!((ours - shortest).abs() < 1e-3, "{} is not {}", ours, shortest);
            prop_assert!(least <= shortest + 1e-3, "{} is no bound of {}", least, shortest);
        }
    }

    proptest! {
        /// Short pieces with deep ends, so that often three lie side by side.
        #[test]
        fn no_whole_positions_are_shorter(pieces in pieces(2..5)) {
            let (ours, least) = placed(&pieces, &tape(2, Rule::Count));
            let shortest = f64::from(brute_force(&pieces, &tape(2, Rule::Count), &mut Vec::new()));
            prop_assert!((ours - shortest).abs() < 1e-3, "{} is not {}", ours, shortest);
            prop_assert!(least <= shortest + 1e-3, "{} is no bound of {}", least, shortest);
        }

        #[test]
        fn what_is_given_by_slope_is_never_shorter_than_free(pieces in pieces(2..5)) {
            let (given, _) = placed(&pieces, &tape(2, Rule::Given));
            let (free, _) = placed(&pieces, &tape(2, Rule::Count));
            prop_assert!(free <= given + 1e-3, "{} {}", free, given);
        }
    }
}
