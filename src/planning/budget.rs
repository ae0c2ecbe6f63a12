//! The step limit and the cancel flag of one planning attempt, and the place where it says how far it is.
//!
//! Budgets are counted in steps, not in seconds, so that the same input gives the same answer on any machine
//! (service.md). A wall-clock limit is the shell's business and only ends an attempt.

use std::cell::Cell;
use std::sync::atomic::{AtomicBool, Ordering};

use super::finding::{Code, Finding};

/// The largest number of steps an attempt may take: about a minute of planning on one core.
pub const DEFAULT_STEPS: u64 = 20_000_000_000;

/// Watches over one planning attempt.
pub struct Budget<'a> {
    steps_left: Cell<u64>,
    cancelled: &'a AtomicBool,
    on_stage: &'a dyn Fn(&'static str),
}

static NEVER: AtomicBool = AtomicBool::new(false);

impl<'a> Budget<'a> {
    /// A budget of `steps` that ends early when `cancelled` is set and calls `on_stage` as each stage begins.
    pub fn new(steps: u64, cancelled: &'a AtomicBool, on_stage: &'a dyn Fn(&'static str)) -> Self {
        Self { steps_left: Cell::new(steps), cancelled, on_stage }
    }

    /// The default number of steps, never cancelled, nobody listening.
    #[must_use]
    pub fn unwatched() -> Budget<'static> {
        Budget { steps_left: Cell::new(DEFAULT_STEPS), cancelled: &NEVER, on_stage: &|_| {} }
    }

    /// Says that a stage of the work begins.
    pub fn stage(&self, name: &'static str) {
        (self.on_stage)(name);
    }

    /// Takes `steps` from the budget.
    ///
    /// # Errors
    /// `BudgetSpent` when none are left, `Cancelled` when the attempt was cancelled.
    pub fn spend(&self, steps: u64) -> Result<(), Finding> {
        if self.cancelled.load(Ordering::Relaxed) {
            return Err(Finding::error(Code::Cancelled, "", "the job was cancelled"));
        }
        match self.steps_left.get().checked_sub(steps) {
            Some(left) => {
                self.steps_left.set(left);
                Ok(())
            }
            None => Err(Finding::error(
                Code::BudgetSpent,
                "",
                "the step limit of a planning attempt is used up; split the job or thin out its points",
            )),
        }
    }
}
