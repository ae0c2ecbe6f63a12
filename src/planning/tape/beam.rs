//! Two carriages on one beam: they cannot pass one another and keep a distance all the time (domain.md A7).
//!
//! Moves are straight, so two carriages that are far enough apart at both ends of a move are so all along. Which of the
//! two is above, toward +V, is settled by where they are parked. A carriage with its knife in the tape, or on its way to
//! a place where it goes down at once, must be where it is; the other one gets out of its way, to where it is
//! parked if that is farther. Where it cannot, that is a conflict.

use super::label::CourseLabel;
use super::machine::Machine;
use super::stroke::{DECIMALS, Stroke};
use crate::planning::finding::{Code, Finding};
use crate::planning::program::number::rounded;
use crate::planning::tolerance::ONE_PLACE_MM;

/// Nobody reads more conflicts of a roll than this.
const MOST_FINDINGS: usize = 10;

/// Two carriages on one beam.
#[derive(Debug, Clone, PartialEq)]
pub struct Beam {
    clearance_mm: f64,
    /// Which of the two is above.
    above: usize,
    park_mm: [f64; 2],
    travel_mm: [(f64, f64); 2],
    /// Where the distance could not be kept, in the order of the tape.
    pub conflicts: Vec<Conflict>,
}

/// A stretch of the tape on which two carriages come too close.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Conflict {
    /// Readings of the tape axis.
    pub x: (f64, f64),
    /// Index of the cutter that must be there.
    pub cutter: usize,
    /// What its course is called.
    pub course: CourseLabel,
    /// Reading of the tape axis with the knife over u = 0 of its piece.
    x_of_u0: f64,
    /// The course of the other knife, if it must be where it is too; else it has no room to get out of the way.
    pub other: Option<CourseLabel>,
    /// How much is lacking at most.
    pub short_mm: f64,
}

/// What a carriage is at while a move is made.
#[derive(Debug, Clone, Copy)]
pub struct Task<'a> {
    /// Its stroke, or the next one.
    pub stroke: Option<&'a Stroke>,
    /// Whether it must be where it is.
    pub bound: bool,
}

impl Beam {
    /// The beam of a machine whose carriages share one.
    #[must_use]
    pub fn of(machine: &Machine) -> Option<Self> {
        let [one, other] = machine.cutters.as_slice() else { return None };
        let clearance = machine.beam_clearance?;
        let park_mm = [one, other].map(|cutter| cutter.park_mm());
        let travel_mm = [one, other].map(|cutter| (cutter.lateral_range.0.mm(), cutter.lateral_range.1.mm()));
        let above = usize::from(park_mm[1] > park_mm[0]);
        Some(Self { clearance_mm: clearance.mm(), above, park_mm, travel_mm, conflicts: Vec::new() })
    }

    /// The cutter whose carriage is above, toward +V.
    #[must_use]
    pub fn above(&self) -> usize {
        self.above
    }

    /// How much is lacking to the distance.
    fn short_mm(&self, lateral_mm: [f64; 2]) -> f64 {
        self.clearance_mm - (lateral_mm[self.above] - lateral_mm[1 - self.above])
    }

    /// Where a carriage may be, if it wants to be at v and the other one is at another place.
    fn beside(&self, k: usize, v: f64, other: f64) -> f64 {
        if k == self.above { v.max(other + self.clearance_mm) } else { v.min(other - self.clearance_mm) }
    }

    /// Where a carriage with its knife up goes, if it wants to go to v and the other one goes to another place: there,
    /// or else out of the way.
    #[must_use]
    pub fn wish(&self, k: usize, v: f64, other: f64) -> f64 {
        let beside = self.beside(k, v, other);
        if beside == v {
            return v;
        }
        if k == self.above { beside.max(self.park_mm[k]) } else { beside.min(self.park_mm[k]) }
    }

    /// Where a carriage waits that has nothing left to do.
    #[must_use]
    pub fn park_mm(&self, k: usize) -> f64 {
        self.park_mm[k]
    }

    /// Keeps two carriages apart at the end of a move; `x` are the readings of the tape axis at both ends of it.
    pub fn keep(&mut self, lateral_mm: &mut [f64; 2], tasks: [Task<'_>; 2], x: (f64, f64)) {
        if self.short_mm(*lateral_mm) <= 0.0 {
            return;
        }
        let first = |k: usize| tasks[k].stroke.map_or(f64::INFINITY, |stroke| stroke.knots[0].x);
        let yields = match (tasks[0].bound, tasks[1].bound) {
            (true, true) => return self.collide(*lateral_mm, tasks, x),
            (true, false) => 1,
            (false, true) => 0,
            // Whose knife goes down later gets out of the way.
            (false, false) => usize::from(first(1) >= first(0)),
        };
        self.yield_to(1 - yields, lateral_mm);
        if self.short_mm(*lateral_mm) <= ONE_PLACE_MM {
            return;
        }
        if tasks[1 - yields].bound {
            self.collide(*lateral_mm, tasks, x);
        } else {
            // No knife is down: whoever goes first waits until it has to.
            self.yield_to(yields, lateral_mm);
        }
    }

    /// The other carriage gets out of the way of this one, as far as it can.
    fn yield_to(&self, k: usize, lateral_mm: &mut [f64; 2]) {
        let other = 1 - k;
        let (low, high) = self.travel_mm[other];
        let beside = self.beside(other, lateral_mm[other], lateral_mm[k]);
        lateral_mm[other] = rounded(beside.clamp(low, high), DECIMALS);
    }

    fn collide(&mut self, lateral_mm: [f64; 2], tasks: [Task<'_>; 2], x: (f64, f64)) {
        let cutter = usize::from(!tasks[0].bound);
        let Some(stroke) = tasks[cutter].stroke else { return };
        let other = tasks[1 - cutter].stroke.filter(|_| tasks[1 - cutter].bound).map(|stroke| stroke.course);
        let short_mm = self.short_mm(lateral_mm);
        let (course, x_of_u0) = (stroke.course, stroke.x_of_u0);
        let found = Conflict { x, cutter, course, x_of_u0, other, short_mm };
        match self.conflicts.last_mut().filter(|last| last.goes_on(&found)) {
            Some(last) => {
                last.x.1 = x.1;
                last.short_mm = last.short_mm.max(short_mm);
            }
            None => self.conflicts.push(found),
        }
    }

    /// The conflicts as findings.
    #[must_use]
    pub fn findings(&self, machine: &Machine) -> Vec<Finding> {
        let mut findings: Vec<Finding> = self
            .conflicts
            .iter()
            .take(MOST_FINDINGS)
            .map(|conflict| self.finding(conflict, machine))
            .collect();
        if let Some(more @ 1..) = self.conflicts.len().checked_sub(MOST_FINDINGS) {
            let message = format!("{more} more places of this kind are not listed");
            findings.push(Finding::error(Code::CarriagesTooClose, "/input/machine", message));
        }
        findings
    }

    fn finding(&self, conflict: &Conflict, machine: &Machine) -> Finding {
        let Conflict { x, cutter, course, x_of_u0, other, short_mm } = *conflict;
        let numbers = [cutter, 1 - cutter].map(|k| machine.cutters[k].number);
        let why = match other {
            Some(other) => format!("comes too close to cutter {} at its cut of course {other}", numbers[1]),
            None => format!("needs cutter {} farther out of the way than its travel goes", numbers[1]),
        };
        let message = format!(
            "course {course}: between u {:.3} and {:.3} mm cutter {} {why}: {short_mm:.3} mm are lacking to the {} mm that two \
             carriages on one beam keep{}. `allocation: free` looks for other knives; where it finds none, it takes a \
             machine whose stations are farther apart, or carriages that are parked the other way round",
            x_of_u0 - x.1,
            x_of_u0 - x.0,
            numbers[0],
            self.clearance_mm,
            if short_mm > self.clearance_mm { ", for they would have to pass one another" } else { "" }
        );
        Finding::error(Code::CarriagesTooClose, "/input/machine/carriage_clearance_mm", message)
    }
}

impl Conflict {
    /// Whether another one, found later, is the same going on.
    fn goes_on(&self, later: &Self) -> bool {
        (self.cutter, self.course, self.x_of_u0, self.other)
            == (later.cutter, later.course, later.x_of_u0, later.other)
            && later.x.0 <= self.x.1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn beam() -> Beam {
        Beam {
            clearance_mm: 30.0,
            above: 0,
            park_mm: [60.0, -60.0],
            travel_mm: [(-150.0, 170.0), (-90.0, 170.0)],
            conflicts: Vec::new(),
        }
    }

    fn task(bound: bool) -> Task<'static> {
        Task { stroke: None, bound }
    }

    fn kept(lateral_mm: [f64; 2], bound: [bool; 2]) -> [f64; 2] {
        let mut kept = lateral_mm;
        beam().keep(&mut kept, bound.map(task), (0.0, 1.0));
        kept
    }

    #[test]
    fn whoever_is_free_gets_out_of_the_way() {
        assert_eq!(kept([20.0, -10.0], [false, false]), [20.0, -10.0]);
        assert_eq!(kept([10.0, -10.0], [true, false]), [10.0, -20.0]);
        assert_eq!(kept([10.0, 30.0], [false, true]), [60.0, 30.0]);
        // Cutter 2 ends at -90, so cutter 1 waits as well.
        assert_eq!(kept([-70.0, -70.0], [false, false]), [-60.0, -90.0]);
    }

    #[test]
    fn a_carriage_that_cannot_do_what_it_wants_goes_where_it_is_parked() {
        assert_eq!(beam().wish(0, 10.0, -20.0), 10.0);
        assert_eq!(beam().wish(0, 9.0, -20.0), 60.0);
        assert_eq!(beam().wish(1, 0.0, -50.0), -80.0);
    }

    #[test]
    fn what_goes_on_is_one_conflict() {
        let stroke = |x: f64| {
            let knot = super::super::stroke::Knot { x, v: 0.0, blade_deg: 0.0 };
            Stroke { course: 7.into(), piece: 0, x_of_u0: 100.0, knots: vec![knot; 2] }
        };
        let (one, other) = (stroke(0.0), stroke(5.0));
        let tasks = [&one, &other].map(|stroke| Task { stroke: Some(stroke), bound: true });
        let mut beam = beam();
        for (gap, x) in [(20.0, 0.0), (10.0, 1.0), (25.0, 2.0), (25.0, 4.0)] {
            beam.keep(&mut [gap, 0.0], tasks, (x, x + 1.0));
        }
        let found: Vec<_> = beam.conflicts.iter().map(|found| (found.x, found.short_mm)).collect();
        assert_eq!(found, [((0.0, 3.0), 20.0), ((4.0, 5.0), 5.0)]);
    }
}
