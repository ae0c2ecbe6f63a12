//! What no longer hangs together with the base: searches from all pieces about a slit, in lockstep.

use std::collections::VecDeque;

use super::piece::Piece;
use super::stock::{Parted, Stock};

/// Which search has come by which piece, by the number of the piece.
#[derive(Debug, Clone, Default)]
pub(super) struct Marks {
    round: u64,
    by: Vec<(u64, usize)>,
}

/// A search over connected pieces.
#[derive(Debug, Default)]
struct Search {
    /// Reached, and its neighbours not yet looked at.
    open: VecDeque<usize>,
    reached: Vec<usize>,
    on_base: bool,
    /// The search that this one has become part of.
    joined_to: Option<usize>,
}

/// What came free.
pub(super) struct Freed {
    /// Each chip as the pieces that it is made of.
    pub chips: Vec<Vec<Piece>>,
    /// How many pieces were looked at.
    pub steps: usize,
}

impl Stock {
    /// Takes out of the stock what a slit has parted from the base.
    ///
    /// Before the slit everything hung together with the base. So every part that no longer does holds one of the
    /// pieces that the slit left or that lay beside those, and so does the part on the base, if anything still
    /// stands there. One search begins at each; they go a piece at a time in turn, and join where they meet. A
    /// search with no way on that has not come to the base is a chip. A last one that is left over when all others
    /// are chips must hold the base, however far away that is. So the work is that of the second largest part, not
    /// that of the stock.
    pub(super) fn release(&mut self, parted: &Parted) -> Freed {
        let mut flood = Flood { searches: Vec::new(), steps: 0 };
        self.marks.round += 1;
        self.marks.by.resize(self.numbers(), (0, 0));
        for &number in parted.after.iter().chain(&parted.beside) {
            flood.begin(self, number);
        }
        while !flood.is_decided(self.on_base > 0) {
            for search in 0..flood.searches.len() {
                flood.step(self, search);
            }
        }
        let loose: Vec<Vec<usize>> = flood.searches.into_iter().filter_map(Search::into_loose).collect();
        let chips = loose.into_iter().map(|numbers| self.remove_all(numbers)).collect();
        Freed { chips, steps: flood.steps }
    }

    fn remove_all(&mut self, mut numbers: Vec<usize>) -> Vec<Piece> {
        numbers.sort_unstable();
        numbers.into_iter().map(|number| self.remove(number)).collect()
    }
}

impl Marks {
    fn of(&self, number: usize) -> Option<usize> {
        let (round, search) = self.by[number];
        (round == self.round).then_some(search)
    }

    fn set(&mut self, number: usize, search: usize) {
        self.by[number] = (self.round, search);
    }
}

struct Flood {
    searches: Vec<Search>,
    steps: usize,
}

impl Flood {
    fn begin(&mut self, stock: &mut Stock, number: usize) {
        self.searches.push(Search::default());
        self.reach(stock, number, self.searches.len() - 1);
    }

    fn reach(&mut self, stock: &mut Stock, number: usize, search: usize) {
        stock.marks.set(number, search);
        let on_base = stock.is_on_base(number);
        let search = &mut self.searches[search];
        search.open.push_back(number);
        search.reached.push(number);
        search.on_base |= on_base;
    }

    /// Looks round from one more piece.
    fn step(&mut self, stock: &mut Stock, search: usize) {
        if self.searches[search].is_over() {
            return;
        }
        let Some(number) = self.searches[search].open.pop_front() else { return };
        self.steps += 1;
        let mut own = search;
        for other in stock.neighbours(number) {
            match stock.marks.of(other) {
                None => self.reach(stock, other, own),
                Some(theirs) => own = self.join(own, self.root(theirs)),
            }
        }
    }

    fn root(&self, mut search: usize) -> usize {
        while let Some(next) = self.searches[search].joined_to {
            search = next;
        }
        search
    }

    /// Makes one search of two; the smaller one becomes part of the larger one.
    fn join(&mut self, one: usize, other: usize) -> usize {
        if one == other {
            return one;
        }
        let size = |search: usize| self.searches[search].reached.len();
        let (from, into) = if size(one) < size(other) { (one, other) } else { (other, one) };
        let part = std::mem::take(&mut self.searches[from]);
        self.searches[from].joined_to = Some(into);
        let whole = &mut self.searches[into];
        whole.open.extend(part.open);
        whole.reached.extend(part.reached);
        whole.on_base |= part.on_base;
        into
    }

    /// Whether it is known of every search if it is a chip. `standing`: something still stands on the base.
    fn is_decided(&mut self, standing: bool) -> bool {
        let mut undecided = self.searches.iter().enumerate().filter(|(_, search)| !search.is_over());
        let last = match (undecided.next(), undecided.next()) {
            (None, _) => return true,
            (Some((last, _)), None) => last,
            _ => return false,
        };
        if standing && !self.searches.iter().any(|search| search.on_base) {
            self.searches[last].on_base = true;
            return true;
        }
        false
    }
}

impl Search {
    /// Whether there is nothing more to find out about it.
    fn is_over(&self) -> bool {
        self.joined_to.is_some() || self.on_base || self.open.is_empty()
    }

    /// The pieces of a chip.
    fn into_loose(self) -> Option<Vec<usize>> {
        (self.joined_to.is_none() && !self.on_base).then_some(self.reached)
    }
}
