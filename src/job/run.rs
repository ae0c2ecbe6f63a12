//! The life of a run: one machine doing one unit of one entry, at most once.
//!
//! ```text
//! offered -> received -> running -> done | failed | aborted
//!    |           |          |
//!    '-----------'----------'--> suspect --> where it was    (its machine is heard of again)
//!                                   '------> done | failed | aborted    (a person has looked)
//! ```
//!
//! No timer gives a unit out again. Only two things return a unit to its entry: the machine says that it has
//! stopped before it began to cut, or a person has looked and says so. What a person says raises the fence, so that
//! a machine that comes back late is refused.

use serde::{Deserialize, Serialize};

use super::id::{EntryId, ProgramId, RunId};
use super::moment::Moment;
use super::purpose::Purpose;

/// A run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Run {
    /// Its id.
    pub id: RunId,
    /// The entry.
    pub entry: EntryId,
    /// The number of the unit within the entry, from 1.
    pub unit: i64,
    /// The program.
    pub program: ProgramId,
    /// What the program is for.
    pub purpose: Purpose,
    /// The SHA-256 of the program's content.
    pub sha256: String,
    /// The length of the program's content.
    pub bytes: i64,
    /// The machine.
    pub machine: String,
    /// The machine's own name for its claim.
    pub request_id: String,
    /// Every report carries it; it rises when a person resolves the run.
    pub fence: i64,
    /// Whoever is silent until then is suspect.
    pub lease_until: Moment,
    /// Whether the unit has gone back to its entry.
    pub returned: bool,
    /// When it was offered.
    pub created_at: Moment,
    /// Rises with every change.
    pub version: i64,
    /// Where it stands.
    pub state: RunState,
    /// What is known of it so far.
    pub course: Course,
}

/// Where a run stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RunState {
    /// The machine may fetch the program.
    Offered,
    /// The machine has the right bytes.
    Received,
    /// The machine may be cutting.
    Running,
    /// Silent past its lease: nobody knows what became of it.
    Suspect,
    /// The unit is cut.
    Done,
    /// The unit is not what it should be.
    Failed,
    /// The machine has stopped.
    Aborted,
}

/// What is known of a run so far.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Course {
    /// When the machine had the right bytes.
    pub received_at: Option<Moment>,
    /// When it began to cut.
    pub started_at: Option<Moment>,
    /// Since when it is suspect.
    pub suspect_since: Option<Moment>,
    /// When it ended.
    pub finished_at: Option<Moment>,
    /// Why it ended so, if it was said.
    pub reason: Option<String>,
    /// What it has used.
    pub material: Material,
    /// What a person has decided.
    pub resolution: Option<Resolution>,
}

/// What a run has used.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Material {
    /// The lot of the prepreg.
    pub prepreg_lot: Option<String>,
    /// The spool.
    pub spool: Option<String>,
    /// The cassette that the pieces went into.
    pub cassette: Option<String>,
}

/// What a person has decided about a run.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Resolution {
    /// What becomes of the unit.
    pub how: How,
    /// Who.
    pub by: String,
    /// Why.
    pub reason: String,
    /// When.
    pub at: Moment,
}

/// What becomes of the unit of a run that a person has looked at.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum How {
    /// It goes back to its entry: nothing of it counts.
    Requeue,
    /// It is lost, and not made again for this entry.
    Scrap,
    /// It was cut as it should be.
    WasDone,
}

/// How a machine says that a run has ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// The unit is cut.
    Done,
    /// The unit is not what it should be.
    Failed,
    /// The machine has stopped.
    Aborted,
}

/// A sign of life of a machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sign {
    /// The fence that it was given with the run.
    pub fence: i64,
    /// When.
    pub now: Moment,
    /// How long it may be silent from now on.
    pub lease_until: Moment,
}

/// What a machine says at the end.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Ending {
    /// How it ended.
    pub outcome: Outcome,
    /// Why, if it is said.
    pub reason: Option<String>,
    /// What was used.
    pub material: Material,
}

/// A run as it begins.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NewRun {
    /// Its id.
    pub id: RunId,
    /// The entry.
    pub entry: EntryId,
    /// The number of the unit.
    pub unit: i64,
    /// The program.
    pub program: ProgramId,
    /// What the program is for.
    pub purpose: Purpose,
    /// The SHA-256 of the program's content.
    pub sha256: String,
    /// The length of the program's content.
    pub bytes: i64,
    /// The machine.
    pub machine: String,
    /// The machine's own name for its claim.
    pub request_id: String,
}

/// A transition that the state does not admit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Illegal {
    /// A person has resolved the run.
    #[error("the fence is not the run's own any more")]
    FenceLost,
    /// The run has ended.
    #[error("the run has ended already")]
    Ended,
    /// The machine has other bytes than the program.
    #[error("these are not the bytes of the program: fetch them again")]
    OtherBytes,
    /// There was no receipt.
    #[error("the run cannot start without a receipt for its program")]
    NotReceived,
    /// It has begun already.
    #[error("the run has started already")]
    Started,
    /// Only what has begun can be done or fail.
    #[error("the run has not started; what has not started can only be aborted")]
    NotStarted,
    /// It is not silent past its lease.
    #[error("the machine was heard of within its lease")]
    HeardOf,
    /// There is nothing to decide.
    #[error(
        "only a suspect run, or one that has failed or was aborted after its start, is resolved by a person"
    )]
    NothingToResolve,
    /// The machine has said that it did not.
    #[error("the machine said that the unit is not done: requeue it or scrap it")]
    SaidOtherwise,
}

impl Run {
    /// Offers a unit to a machine.
    #[must_use]
    pub fn offer(new: NewRun, now: Moment, lease_until: Moment) -> Self {
        let NewRun { id, entry, unit, program, purpose, sha256, bytes, machine, request_id } = new;
        Self {
            id,
            entry,
            unit,
            program,
            purpose,
            sha256,
            bytes,
            machine,
            request_id,
            fence: 1,
            lease_until,
            returned: false,
            created_at: now,
            version: 1,
            state: RunState::Offered,
            course: Course::default(),
        }
    }

    /// The machine has these bytes. A repeated receipt changes nothing.
    ///
    /// # Errors
    /// `FenceLost`, `Ended`, `Started`; `OtherBytes` if they are not the program's.
    pub fn receive(self, sign: Sign, sha256: &str, bytes: i64) -> Result<Self, Illegal> {
        let mut run = self.heard(sign)?;
        if run.state == RunState::Running {
            return Err(Illegal::Started);
        }
        if run.sha256 != sha256 || run.bytes != bytes {
            return Err(Illegal::OtherBytes);
        }
        run.course.received_at = run.course.received_at.or(Some(sign.now));
        run.state = RunState::Received;
        Ok(run)
    }

    /// The machine begins to cut. A repeated start changes nothing.
    ///
    /// # Errors
    /// `FenceLost`, `Ended`, `NotReceived`.
    pub fn start(self, sign: Sign) -> Result<Self, Illegal> {
        let mut run = self.heard(sign)?;
        if run.state == RunState::Offered {
            return Err(Illegal::NotReceived);
        }
        run.course.started_at = run.course.started_at.or(Some(sign.now));
        run.state = RunState::Running;
        Ok(run)
    }

    /// The machine lives: its lease goes on, and a suspect run is again where it was.
    ///
    /// # Errors
    /// `FenceLost`, `Ended`.
    pub fn heard(mut self, sign: Sign) -> Result<Self, Illegal> {
        self.own(sign.fence)?;
        if !self.state.is_live() {
            return Err(Illegal::Ended);
        }
        self.state = self.stage();
        self.course.suspect_since = None;
        self.lease_until = self.lease_until.max(sign.lease_until);
        Ok(self.changed())
    }

    /// The machine says how the run has ended. If it had not started, nothing was cut and the unit goes back. The
    /// same end, said again, changes nothing.
    ///
    /// # Errors
    /// `FenceLost`; `Ended` otherwise; `NotStarted` if it cannot be done or have failed.
    pub fn end(self, sign: Sign, ending: Ending) -> Result<Self, Illegal> {
        self.own(sign.fence)?;
        if self.ended_so(&ending) {
            return Ok(self);
        }
        let mut run = self.heard(sign)?;
        let started = run.state == RunState::Running;
        if !started && ending.outcome != Outcome::Aborted {
            return Err(Illegal::NotStarted);
        }
        run.state = ending.outcome.state();
        run.returned = !started;
        run.course.reason = ending.reason;
        run.course.material = ending.material;
        run.course.finished_at = Some(sign.now);
        Ok(run)
    }

    /// The lease is over and nothing was heard: nobody knows what became of the unit.
    ///
    /// # Errors
    /// `HeardOf` if the lease is not over; `Ended` if the run has ended or is suspect already.
    pub fn fall_silent(mut self, now: Moment) -> Result<Self, Illegal> {
        if !self.state.is_live() || self.state == RunState::Suspect {
            return Err(Illegal::Ended);
        }
        if now <= self.lease_until {
            return Err(Illegal::HeardOf);
        }
        self.state = RunState::Suspect;
        self.course.suspect_since = Some(now);
        Ok(self.changed())
    }

    /// A person has looked and says what becomes of the unit. From then on the machine's fence is lost. The same
    /// decision, said again, changes nothing.
    ///
    /// # Errors
    /// `NothingToResolve`; `SaidOtherwise` if the machine itself has said that the unit is not done.
    pub fn resolve(mut self, resolution: Resolution) -> Result<Self, Illegal> {
        if self.is_resolved_so(&resolution) {
            return Ok(self);
        }
        self.state = match (self.state, resolution.how) {
            (RunState::Suspect, How::Requeue) => RunState::Aborted,
            (RunState::Suspect, How::Scrap) => RunState::Failed,
            (RunState::Suspect, How::WasDone) => RunState::Done,
            (_, _) if !self.waits_for_a_person() => return Err(Illegal::NothingToResolve),
            (_, How::WasDone) => return Err(Illegal::SaidOtherwise),
            (ended, How::Requeue | How::Scrap) => ended,
        };
        self.returned = resolution.how == How::Requeue;
        self.fence += 1;
        self.course.finished_at = self.course.finished_at.or(Some(resolution.at));
        self.course.resolution = Some(resolution);
        Ok(self.changed())
    }

    /// Whether a person must say what becomes of the unit.
    #[must_use]
    pub fn waits_for_a_person(&self) -> bool {
        match self.state {
            RunState::Suspect => true,
            RunState::Failed | RunState::Aborted => !self.returned && self.course.resolution.is_none(),
            _ => false,
        }
    }

    /// Whether the unit is lost, by a person's decision.
    #[must_use]
    pub fn is_scrapped(&self) -> bool {
        self.course.resolution.as_ref().is_some_and(|resolution| resolution.how == How::Scrap)
    }

    /// Refuses a fence that is not the run's own.
    ///
    /// # Errors
    /// `FenceLost`.
    pub fn own(&self, fence: i64) -> Result<(), Illegal> {
        if self.fence == fence { Ok(()) } else { Err(Illegal::FenceLost) }
    }

    /// How far the machine had come.
    fn stage(&self) -> RunState {
        if self.course.started_at.is_some() {
            RunState::Running
        } else if self.course.received_at.is_some() {
            RunState::Received
        } else {
            RunState::Offered
        }
    }

    fn ended_so(&self, ending: &Ending) -> bool {
        self.state == ending.outcome.state()
            && self.course.reason == ending.reason
            && self.course.material == ending.material
    }

    fn is_resolved_so(&self, resolution: &Resolution) -> bool {
        let same = |known: &Resolution| {
            (known.how, &known.by, &known.reason) == (resolution.how, &resolution.by, &resolution.reason)
        };
        self.course.resolution.as_ref().is_some_and(same)
    }

    fn changed(self) -> Self {
        Self { version: self.version + 1, ..self }
    }
}

impl RunState {
    /// Every state's word, as filters know it.
    pub const WORDS: [&'static str; 7] =
        ["offered", "received", "running", "suspect", "done", "failed", "aborted"];

    /// The state's word.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Offered => "offered",
            Self::Received => "received",
            Self::Running => "running",
            Self::Suspect => "suspect",
            Self::Done => "done",
            Self::Failed => "failed",
            Self::Aborted => "aborted",
        }
    }

    /// Whether the run occupies its machine.
    #[must_use]
    pub fn is_live(self) -> bool {
        !matches!(self, Self::Done | Self::Failed | Self::Aborted)
    }
}

impl Outcome {
    fn state(self) -> RunState {
        match self {
            Self::Done => RunState::Done,
            Self::Failed => RunState::Failed,
            Self::Aborted => RunState::Aborted,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LEASE_MS: i64 = 100;

    const fn at(ms: i64) -> Moment {
        Moment::from_unix_ms(ms)
    }

    fn sign(fence: i64, ms: i64) -> Sign {
        Sign { fence, now: at(ms), lease_until: at(ms + LEASE_MS) }
    }

    fn offered() -> Run {
        let new = NewRun {
            id: RunId::new(at(0), &[1; 10]),
            entry: EntryId::new(at(0), &[2; 10]),
            unit: 1,
            program: ProgramId::new(at(0), &[3; 10]),
            purpose: Purpose::Production,
            sha256: "aa".into(),
            bytes: 7,
            machine: "lab".into(),
            request_id: "r".into(),
        };
        Run::offer(new, at(0), at(LEASE_MS))
    }

    fn received() -> Run {
        offered().receive(sign(1, 1), "aa", 7).unwrap()
    }

    fn running() -> Run {
        received().start(sign(1, 2)).unwrap()
    }

    fn ending(outcome: Outcome) -> Ending {
        Ending { outcome, reason: None, material: Material::default() }
    }

    fn resolution(how: How) -> Resolution {
        Resolution { how, by: "mia".into(), reason: "looked".into(), at: at(900) }
    }

    #[test]
    fn the_straight_way() {
        let done = running().end(sign(1, 3), ending(Outcome::Done)).unwrap();
        assert_eq!((done.state, done.returned, done.waits_for_a_person()), (RunState::Done, false, false));
        assert_eq!(done.course.received_at, Some(at(1)));
        assert_eq!(done.course.started_at, Some(at(2)));
        assert_eq!(done.course.finished_at, Some(at(3)));
        assert_eq!(done.clone().end(sign(1, 9), ending(Outcome::Done)), Ok(done.clone()), "said again");
        assert_eq!(done.clone().end(sign(1, 9), ending(Outcome::Failed)), Err(Illegal::Ended));
        assert_eq!(done.clone().heard(sign(1, 9)), Err(Illegal::Ended));
        assert_eq!(done.resolve(resolution(How::Requeue)), Err(Illegal::NothingToResolve));
    }

    #[test]
    fn nothing_starts_without_the_right_bytes() {
        assert_eq!(offered().start(sign(1, 1)), Err(Illegal::NotReceived));
        assert_eq!(offered().receive(sign(1, 1), "ab", 7), Err(Illegal::OtherBytes));
        assert_eq!(offered().receive(sign(1, 1), "aa", 6), Err(Illegal::OtherBytes));
        assert_eq!(running().receive(sign(1, 3), "aa", 7), Err(Illegal::Started));
        let again = running().start(sign(1, 50)).unwrap();
        assert_eq!(again.course.started_at, Some(at(2)), "a repeated start is the first one");
    }

    #[test]
    fn only_what_was_not_started_comes_back_by_itself() {
        for run in [offered(), received()] {
            assert_eq!(run.clone().end(sign(1, 3), ending(Outcome::Done)), Err(Illegal::NotStarted));
            assert_eq!(run.clone().end(sign(1, 3), ending(Outcome::Failed)), Err(Illegal::NotStarted));
            let aborted = run.end(sign(1, 3), ending(Outcome::Aborted)).unwrap();
            assert!(aborted.returned && !aborted.waits_for_a_person());
            assert_eq!(aborted.resolve(resolution(How::Requeue)), Err(Illegal::NothingToResolve));
        }
        for outcome in [Outcome::Failed, Outcome::Aborted] {
            let ended = running().end(sign(1, 3), ending(outcome)).unwrap();
            assert!(!ended.returned && ended.waits_for_a_person());
            assert_eq!(ended.clone().resolve(resolution(How::WasDone)), Err(Illegal::SaidOtherwise));
            let scrapped = ended.clone().resolve(resolution(How::Scrap)).unwrap();
            assert!(!scrapped.returned && scrapped.is_scrapped() && scrapped.state == ended.state);
            let requeued = ended.resolve(resolution(How::Requeue)).unwrap();
            assert!(requeued.returned && !requeued.is_scrapped());
            assert_eq!(requeued.resolve(resolution(How::Scrap)), Err(Illegal::NothingToResolve));
        }
    }

    #[test]
    fn silence_makes_suspect_and_a_sign_of_life_brings_back() {
        for run in [offered(), received(), running()] {
            let (was, lease) = (run.state, run.lease_until);
            assert_eq!(run.clone().fall_silent(lease), Err(Illegal::HeardOf));
            let suspect = run.fall_silent(at(lease.unix_ms() + 1)).unwrap();
            assert!(suspect.state == RunState::Suspect && !suspect.returned);
            assert_eq!(suspect.clone().fall_silent(at(999)), Err(Illegal::Ended));
            assert_eq!(suspect.clone().heard(sign(2, 500)), Err(Illegal::FenceLost));
            let back = suspect.heard(sign(1, 500)).unwrap();
            assert_eq!((back.state, back.lease_until, back.course.suspect_since), (was, at(600), None));
        }
    }

    #[test]
    fn a_resolution_ends_a_suspect_run_and_its_machine_is_refused() {
        let ends = [
            (How::Requeue, RunState::Aborted, true),
            (How::Scrap, RunState::Failed, false),
            (How::WasDone, RunState::Done, false),
        ];
        for (how, state, returned) in ends {
            let resolved = running().fall_silent(at(500)).unwrap().resolve(resolution(how)).unwrap();
            assert_eq!((resolved.state, resolved.returned, resolved.fence), (state, returned, 2), "{how:?}");
            assert!(!resolved.waits_for_a_person());
            assert_eq!(resolved.clone().resolve(resolution(how)), Ok(resolved.clone()), "said again");
            assert_eq!(resolved.clone().heard(sign(1, 950)), Err(Illegal::FenceLost));
            assert_eq!(resolved.clone().end(sign(1, 950), ending(Outcome::Done)), Err(Illegal::FenceLost));
            assert_eq!(resolved.start(sign(1, 950)), Err(Illegal::FenceLost));
        }
        assert_eq!(running().resolve(resolution(How::Scrap)), Err(Illegal::NothingToResolve));
    }
}
