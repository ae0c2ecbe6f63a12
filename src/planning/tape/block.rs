//! A piece as the placement on the roll sees it: its two ends and where it keeps knives busy.
//!
//! Along the tape everything is measured here from the leading end, in t: a piece at the position p covers
//! t = p - u. What passes the knives first has the smallest t.

use super::assign::{collide, published};
use super::chain::Chain;
use super::front::{End, Front, front};
use super::piece::{Piece, Side};
use crate::planning::tolerance::ONE_PLACE_MM;

/// A stretch of the tape in mm: from, to.
pub type Stretch = (f64, f64);

/// How chains are given to knives while pieces are placed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rule {
    /// Each chain has its knife; where no published choice stands against it, a group of chains may swap the two.
    Given,
    /// Any: nowhere may more chains run side by side than there are knives. Intervals with at most k of them side by
    /// side can always be shared out among k knives (interval graphs are perfect), so colours need not be known yet.
    Count,
}

/// Whether the knives of a group of chains are as given, or swapped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Way {
    /// As given.
    Straight,
    /// The first knife does what the last was given, and so on.
    Swapped,
}

impl Way {
    /// What becomes of knife `knife` out of `knives`.
    #[must_use]
    pub fn of(self, knife: usize, knives: usize) -> usize {
        match self {
            Self::Straight => knife,
            Self::Swapped => knives - 1 - knife,
        }
    }
}

/// Chains that hang together: each collides with another of them.
#[derive(Debug, Clone, PartialEq)]
pub struct Group {
    /// Smallest and largest t of them at position 0.
    pub span: Stretch,
    /// Under [`Rule::Given`] the stretches of each knife; under [`Rule::Count`] those with one chain or more, with two
    /// or more, and so on. In each list sorted, and none overlaps another.
    pub lists: Vec<Vec<Stretch>>,
    /// Its chains, as indices of the piece's.
    pub chains: Vec<usize>,
    /// The ways in which it may be taken.
    pub ways: &'static [Way],
}

/// A chain of a piece at position 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Run {
    /// Smallest and largest t.
    pub span: Stretch,
    /// The knife that it is given, from 0.
    pub knife: usize,
    /// Which cut of its piece it belongs to.
    pub cut: usize,
}

/// A piece as the placement sees it.
#[derive(Debug, Clone, PartialEq)]
pub struct Block {
    /// Its finish: the end that passes the knives first.
    pub lead: Front,
    /// Its start.
    pub trail: Front,
    /// Smallest and largest u.
    pub u: Stretch,
    /// Its chains.
    pub runs: Vec<Run>,
    /// The cut that is all of its finish, if there is one that never turns back across the tape.
    pub lead_cut: Option<usize>,
    /// The cut that is all of its start, likewise.
    pub trail_cut: Option<usize>,
    groups: Vec<Group>,
    knives: usize,
    rule: Rule,
    /// The published knife of each chain, where the published rule covers its cut.
    published: Vec<Option<usize>>,
}

impl Block {
    /// A piece with its chains, each with the knife that it is given.
    #[must_use]
    pub fn new(piece: &Piece, chains: &[(Chain, usize)], half_mm: f64, knives: usize, rule: Rule) -> Self {
        let run = |(chain, knife): &(Chain, usize)| {
            let (low, high) = chain.busy_mm;
            Run { span: (-high, -low), knife: *knife, cut: chain.cut }
        };
        let mut block = Self {
            lead: front(piece, End::Finish, half_mm),
            trail: front(piece, End::Start, half_mm),
            u: piece.u_range(),
            runs: chains.iter().map(run).collect(),
            lead_cut: end_cut(piece, half_mm, 1.0),
            trail_cut: end_cut(piece, half_mm, -1.0),
            groups: Vec::new(),
            knives,
            rule,
            published: chains.iter().map(|(chain, _)| covered(chain, knives)).collect(),
        };
        block.groups = block.groups_under(rule, None);
        block
    }

    /// The groups of its chains under its rule, in order of their smallest t.
    #[must_use]
    pub fn groups(&self) -> &[Group] {
        &self.groups
    }

    /// The groups under another rule, or without the chains of a cut that a neighbour's knife makes.
    #[must_use]
    pub fn groups_under(&self, rule: Rule, without: Option<usize>) -> Vec<Group> {
        let mut order: Vec<usize> =
            (0..self.runs.len()).filter(|&index| Some(self.runs[index].cut) != without).collect();
        order.sort_by(|&a, &b| {
            let (one, other) = (self.runs[a].span, self.runs[b].span);
            one.0.total_cmp(&other.0).then(one.1.total_cmp(&other.1)).then(a.cmp(&b))
        });
        match rule {
            Rule::Count => self.counted(order),
            Rule::Given => self.hanging_together(&order),
        }
    }

    /// The groups under its own rule without those chains.
    #[must_use]
    pub fn groups_without(&self, cut: usize) -> Vec<Group> {
        self.groups_under(self.rule, Some(cut))
    }

    fn counted(&self, chains: Vec<usize>) -> Vec<Group> {
        let spans: Vec<Stretch> = chains.iter().map(|&index| self.runs[index].span).collect();
        let Some(span) = spans.iter().copied().reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))) else {
            return Vec::new();
        };
        vec![Group { span, lists: levels(&spans, self.knives), chains, ways: &[Way::Swapped] }]
    }

    fn hanging_together(&self, order: &[usize]) -> Vec<Group> {
        let mut groups: Vec<Group> = Vec::new();
        for &index in order {
            let Run { span, knife, .. } = self.runs[index];
            let open = groups.last_mut().filter(|group| span.0 < group.span.1 - ONE_PLACE_MM);
            if let Some(group) = open {
                group.span.1 = group.span.1.max(span.1);
                group.chains.push(index);
                group.lists[knife].push(span);
            } else {
                let mut lists = vec![Vec::new(); self.knives];
                lists[knife].push(span);
                groups.push(Group { span, lists, chains: vec![index], ways: &[Way::Straight] });
            }
        }
        for group in &mut groups {
            group.ways = self.ways(&group.chains);
        }
        groups
    }

    /// A group may swap its knives where that gives up no more published choices.
    fn ways(&self, chains: &[usize]) -> &'static [Way] {
        let given_up = |way: Way| {
            let knife = |index: usize| way.of(self.runs[index].knife, self.knives);
            chains.iter().filter(|&&index| self.published[index].is_some_and(|p| p != knife(index))).count()
        };
        if self.knives > 1 && given_up(Way::Swapped) == given_up(Way::Straight) {
            &[Way::Straight, Way::Swapped]
        } else {
            &[Way::Straight]
        }
    }
}

fn covered(chain: &Chain, knives: usize) -> Option<usize> {
    let (knife, covered) = published(chain);
    covered.then_some(knife.min(knives - 1))
}

/// The open cut that crosses the whole tape in the given direction of v and never turns back in it. In a
/// counter-clockwise outline the finish runs in +V, the start in -V, and a piece has one of each at most.
fn end_cut(piece: &Piece, half_mm: f64, direction: f64) -> Option<usize> {
    let cuts = piece.sides.iter().filter_map(|side| match side {
        Side::Cut(points) => Some(points),
        Side::TapeEdge(..) => None,
    });
    let mut cuts = cuts.enumerate();
    let found = cuts.find(|(_, points)| {
        points[0].y == -direction * half_mm && points[points.len() - 1].y == direction * half_mm
    });
    let (index, points) = found?;
    points.windows(2).all(|pair| (pair[1].y - pair[0].y) * direction >= 0.0).then_some(index)
}

/// The stretches with one span or more, with two or more, up to `most`, each list sorted. Spans that end where others
/// begin do not overlap; one that is no longer than a place counts with those in whose middle it lies.
#[must_use]
pub fn levels(spans: &[Stretch], most: usize) -> Vec<Vec<Stretch>> {
    let half = ONE_PLACE_MM / 2.0;
    let mut events: Vec<(f64, bool)> = Vec::new();
    for (low, high) in spans {
        if high - low > ONE_PLACE_MM {
            events.extend([(low + half, true), (high - half, false)]);
        }
    }
    // Where one ends exactly where another begins, it ends first.
    events.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut lists = vec![Vec::new(); most];
    let mut begun = vec![0.0; most];
    let mut count = 0;
    for (place, begins) in events {
        if begins {
            count += 1;
            if count <= most {
                begun[count - 1] = place - half;
            }
        } else {
            if count <= most {
                lists[count - 1].push((begun[count - 1], place + half));
            }
            count -= 1;
        }
    }
    add_places(spans, &mut lists);
    lists
}

/// Spans no longer than a place go to the level above those in whose middle they lie.
fn add_places(spans: &[Stretch], lists: &mut [Vec<Stretch>]) {
    let places: Vec<Stretch> =
        spans.iter().copied().filter(|(low, high)| high - low <= ONE_PLACE_MM).collect();
    let levels: Vec<usize> = places
        .iter()
        .map(|place| lists.iter().take_while(|list| overlapping(list, *place).next().is_some()).count())
        .collect();
    for (place, level) in places.into_iter().zip(levels) {
        if let Some(list) = lists.get_mut(level) {
            list.push(place);
        }
    }
    for list in lists {
        list.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    }
}

/// The stretches of a sorted list without overlaps that collide with a span.
pub fn overlapping(list: &[Stretch], span: Stretch) -> impl Iterator<Item = Stretch> {
    let first = list.partition_point(|stretch| stretch.1 - ONE_PLACE_MM <= span.0);
    list[first..].iter().copied().take_while(move |stretch| stretch.0 < span.1 - ONE_PLACE_MM).filter(
        // A place among longer stretches breaks the order of ends by less than a place.
        move |stretch| collide(*stretch, span),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_count_what_runs_side_by_side() {
        let spans = [(0.0, 10.0), (5.0, 20.0), (20.0, 30.0), (25.0, 25.0), (30.0, 30.0)];
        let lists = levels(&spans, 2);
        let near = |list: &[Stretch], wanted: &[Stretch]| {
            list.len() == wanted.len()
                && list.iter().zip(wanted).all(|(a, b)| (a.0 - b.0).abs() < 1e-9 && (a.1 - b.1).abs() < 1e-9)
        };
        assert!(near(&lists[0], &[(0.0, 20.0), (20.0, 30.0), (30.0, 30.0)]), "{lists:?}");
        assert!(near(&lists[1], &[(5.0, 10.0), (25.0, 25.0)]), "{lists:?}");
    }

    #[test]
    fn a_way_swaps_two_knives_and_leaves_one_alone() {
        assert_eq!([0, 1].map(|knife| Way::Swapped.of(knife, 2)), [1, 0]);
        assert_eq!(Way::Swapped.of(0, 1), 0);
    }
}
