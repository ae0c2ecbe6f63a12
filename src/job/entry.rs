//! The life of an entry: a program that waits in the queue of a machine or a pool, with a quantity of units.
//!
//! ```text
//! queued <-> assigned -> finished
//!    `----------'-> cancelled
//! ```
//!
//! Queued as long as a unit waits; assigned when all are given out; finished when all are done or scrapped. A unit
//! that comes back from its run waits again. A cancelled entry gives nothing out any more; what it had given out
//! goes on.

use serde::{Deserialize, Serialize};

use super::id::{EntryId, ProgramId};
use super::moment::Moment;
use super::purpose::Purpose;

/// The most units of an entry.
pub const MOST_UNITS: i64 = 10_000;

/// An entry of a queue.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Entry {
    /// Its id.
    pub id: EntryId,
    /// The queue: the name of a machine or of a pool.
    pub queue: String,
    /// The program.
    pub program: ProgramId,
    /// What the program is for.
    pub purpose: Purpose,
    /// Its place: the lowest comes first, the older one where two are the same.
    pub position: i64,
    /// How many units are wanted, from 1 to [`MOST_UNITS`].
    pub quantity: i64,
    /// What became of its units so far.
    pub units: Units,
    /// When it was made.
    pub created_at: Moment,
    /// Rises with every change.
    pub version: i64,
    /// Where it stands.
    pub state: EntryState,
}

/// Where an entry stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum EntryState {
    /// Some units are not given out.
    Queued,
    /// All units are given out.
    Assigned,
    /// All units are done or scrapped.
    Finished,
    /// Somebody does not want it any more.
    Cancelled,
}

/// What became of the units of an entry, counted over the runs that were not returned.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Units {
    /// Given out, whatever became of them.
    pub given: i64,
    /// Of those, done.
    pub done: i64,
    /// Of those, scrapped.
    pub scrapped: i64,
    /// The highest number that was given out, 0 if none was.
    pub highest: i64,
}

/// An entry as it begins.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NewEntry {
    /// Its id.
    pub id: EntryId,
    /// The queue: the name of a machine or of a pool.
    pub queue: String,
    /// The program.
    pub program: ProgramId,
    /// What the program is for.
    pub purpose: Purpose,
    /// Its place.
    pub position: i64,
    /// How many units are wanted.
    pub quantity: i64,
}

/// A transition that the state does not admit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Illegal {
    /// It is finished or cancelled.
    #[error("the entry is {} already", .0.word())]
    Over(EntryState),
    /// Units outside 1 to [`MOST_UNITS`].
    #[error("quantity is 1 to {MOST_UNITS}")]
    Quantity,
    /// A unit beyond the new quantity was given out.
    #[error("unit {0} was given out already")]
    GivenOut(i64),
}

impl Entry {
    /// Puts a new entry into its queue.
    ///
    /// # Errors
    /// `Quantity`.
    pub fn queue(new: NewEntry, now: Moment) -> Result<Self, Illegal> {
        let NewEntry { id, queue, program, purpose, position, quantity } = new;
        let (units, state) = (Units::default(), EntryState::Queued);
        let (created_at, version) = (now, 1);
        let entry =
            Self { id, queue, program, purpose, position, quantity, units, created_at, version, state };
        entry.checked()
    }

    /// Takes note of what became of its units.
    #[must_use]
    pub fn settle(self, units: Units) -> Self {
        let state = match self.state {
            // Whoever cancelled it does not want a unit that comes back, either.
            EntryState::Cancelled => EntryState::Cancelled,
            _ => units.state(self.quantity),
        };
        Self { units, state, ..self }.changed()
    }

    /// Changes its place or its quantity.
    ///
    /// # Errors
    /// `Over`; `Quantity`; `GivenOut` if the quantity falls below a unit that was given out.
    pub fn amend(self, position: Option<i64>, quantity: Option<i64>) -> Result<Self, Illegal> {
        self.refuse_over()?;
        let (position, quantity) = (position.unwrap_or(self.position), quantity.unwrap_or(self.quantity));
        let amended = Self { position, quantity, ..self }.checked()?;
        if quantity < amended.units.highest {
            return Err(Illegal::GivenOut(amended.units.highest));
        }
        let units = amended.units;
        Ok(amended.settle(units))
    }

    /// How many units of production it has made: none of a dry run or of the rest of a roll, however often it ran.
    #[must_use]
    pub fn produced(&self) -> i64 {
        if self.purpose.makes_units() { self.units.done } else { 0 }
    }

    /// Ends it. A cancelled entry stays as it is.
    ///
    /// # Errors
    /// `Over` if it is finished.
    pub fn cancel(self) -> Result<Self, Illegal> {
        match self.state {
            EntryState::Cancelled => Ok(self),
            EntryState::Finished => Err(Illegal::Over(self.state)),
            _ => Ok(Self { state: EntryState::Cancelled, ..self }.changed()),
        }
    }

    fn refuse_over(&self) -> Result<(), Illegal> {
        match self.state {
            EntryState::Queued | EntryState::Assigned => Ok(()),
            over => Err(Illegal::Over(over)),
        }
    }

    fn checked(self) -> Result<Self, Illegal> {
        if (1..=MOST_UNITS).contains(&self.quantity) { Ok(self) } else { Err(Illegal::Quantity) }
    }

    fn changed(self) -> Self {
        Self { version: self.version + 1, ..self }
    }
}

impl Units {
    fn state(self, quantity: i64) -> EntryState {
        if self.done + self.scrapped >= quantity {
            EntryState::Finished
        } else if self.given >= quantity {
            EntryState::Assigned
        } else {
            EntryState::Queued
        }
    }
}

impl EntryState {
    /// Every state's word, as filters know it.
    pub const WORDS: [&'static str; 4] = ["queued", "assigned", "finished", "cancelled"];

    /// The state's word.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Queued => "queued",
            Self::Assigned => "assigned",
            Self::Finished => "finished",
            Self::Cancelled => "cancelled",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOW: Moment = Moment::from_unix_ms(1_000);

    fn entry(quantity: i64) -> Result<Entry, Illegal> {
        let (id, program) = (EntryId::new(NOW, &[1; 10]), ProgramId::new(NOW, &[2; 10]));
        let (queue, purpose) = ("lab".into(), Purpose::Production);
        Entry::queue(NewEntry { id, queue, program, purpose, position: 1, quantity }, NOW)
    }

    fn units(given: i64, done: i64, scrapped: i64) -> Units {
        Units { given, done, scrapped, highest: given }
    }

    #[test]
    fn it_waits_is_assigned_and_finishes_with_its_units() {
        let entry = entry(3).unwrap();
        let entry = entry.settle(units(2, 1, 0));
        assert_eq!(entry.state, EntryState::Queued);
        let entry = entry.settle(units(3, 1, 0));
        assert_eq!(entry.state, EntryState::Assigned);
        let entry = entry.settle(units(2, 1, 0));
        assert_eq!(entry.state, EntryState::Queued, "a unit came back");
        let entry = entry.settle(units(3, 2, 0)).settle(units(3, 2, 1));
        assert_eq!((entry.state, entry.version), (EntryState::Finished, 6));
        assert_eq!(entry.clone().cancel(), Err(Illegal::Over(EntryState::Finished)));
        assert_eq!(entry.amend(None, Some(4)), Err(Illegal::Over(EntryState::Finished)));
    }

    #[test]
    fn a_dry_run_and_the_rest_of_a_roll_finish_and_make_no_unit() {
        for purpose in [Purpose::of(true, None), Purpose::of(false, Some(7.into()))] {
            let ordinary = entry(2).unwrap().settle(units(2, 2, 0));
            let other = Entry { purpose, ..ordinary.clone() };
            assert_eq!((ordinary.produced(), other.produced()), (2, 0), "{purpose:?}");
            assert_eq!((other.units.done, other.state), (2, EntryState::Finished));
        }
    }

    #[test]
    fn a_cancelled_entry_stays_so() {
        let entry = entry(2).unwrap().settle(units(1, 0, 0)).cancel().unwrap();
        assert_eq!(entry.clone().cancel(), Ok(entry.clone()));
        assert_eq!(entry.settle(units(0, 0, 0)).state, EntryState::Cancelled);
    }

    #[test]
    fn quantities_have_limits() {
        assert_eq!(entry(0), Err(Illegal::Quantity));
        assert_eq!(entry(MOST_UNITS + 1), Err(Illegal::Quantity));
        let given = entry(5).unwrap().settle(units(3, 0, 0));
        assert_eq!(given.clone().amend(None, Some(2)), Err(Illegal::GivenOut(3)));
        let amended = given.amend(Some(-4), Some(3)).unwrap();
        assert_eq!((amended.position, amended.state), (-4, EntryState::Assigned));
        assert_eq!(amended.amend(None, Some(4)).unwrap().state, EntryState::Queued);
    }
}
