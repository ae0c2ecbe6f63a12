//! The life of a job: each transition consumes the job and gives back the next one, or says why there is none.
//!
//! ```text
//! queued -> running -> succeeded
//!    ^         |-----> failed       (a limit, a crash, or three attempts used up)
//!    |---------|                    (the worker was lost or stopped in order)
//!    `-> cancelled <-'
//! ```
//!
//! An attempt is counted before it starts, so that a job that brings its worker down cannot do so for ever. The
//! fence is the number of the attempt: it only rises, and a worker whose fence is not the job's own any more can
//! neither report progress nor commit.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::id::{JobId, ProgramId, WorkerId};
use super::moment::Moment;
use crate::planning::finding::Finding;

/// A job fails when so many attempts have ended without an answer.
pub const MOST_ATTEMPTS: u32 = 3;

/// A planning job.
#[derive(Debug, Clone, PartialEq)]
pub struct Job {
    /// Its id.
    pub id: JobId,
    /// The kind of work, as in the document.
    pub kind: String,
    /// A label for people.
    pub name: String,
    /// Free, searchable strings.
    pub references: BTreeMap<String, String>,
    /// The program whose dry run it plans, if it was asked for as that.
    pub dry_run_of: Option<ProgramId>,
    /// When it was posted.
    pub created_at: Moment,
    /// Attempts that count against [`MOST_ATTEMPTS`].
    pub attempts: u32,
    /// The number of the last attempt that was started, 0 before the first.
    pub fence: i64,
    /// Rises with every change.
    pub version: i64,
    /// Where it stands.
    pub state: State,
}

/// Where a job stands, with what is known there.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "state", rename_all = "snake_case")]
pub enum State {
    /// Waits for a worker.
    Queued {
        /// Since when; a job that comes back keeps its place.
        since: Moment,
    },
    /// A worker plans it.
    Running {
        /// Since when it first waited, for the way back.
        queued_since: Moment,
        /// The worker.
        worker: WorkerId,
        /// Start of this attempt.
        started_at: Moment,
        /// The stage of the work that was begun last.
        stage: Option<String>,
    },
    /// It has an answer. Whether that is a usable program says the verdict.
    Succeeded {
        /// Start of the attempt that gave the answer.
        started_at: Moment,
        /// Its end.
        finished_at: Moment,
        /// Whether there is a program that may be approved.
        usable: bool,
        /// How many warnings its report holds; not known of a job that had ended before they were counted.
        #[serde(default)]
        warnings: Option<u32>,
        /// The program, if the verdict is usable.
        program: Option<ProgramId>,
        /// How long each stage took.
        stages: Vec<StageTime>,
    },
    /// It has no answer and will not get one.
    Failed {
        /// The end of its last attempt.
        finished_at: Moment,
        /// Why.
        failure: Failure,
    },
    /// Somebody does not want it any more.
    Cancelled {
        /// When.
        finished_at: Moment,
        /// Who.
        by: String,
        /// Why, if it was said.
        reason: Option<String>,
    },
}

/// How long a stage of an attempt took.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StageTime {
    /// The stage.
    pub name: String,
    /// Wall-clock seconds.
    pub seconds: f64,
}

/// Why a job has no answer.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Failure {
    /// What happened, from a closed set.
    pub code: FailureCode,
    /// The same in words, for people.
    pub detail: String,
    /// What is wrong with the input, where that is the reason.
    pub findings: Vec<Finding>,
}

/// What can end a job without an answer. The codes are contract.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FailureCode {
    /// The input turned out to be invalid only while it was planned.
    InvalidInput,
    /// The stored input does not fit its hash any more.
    InputDamaged,
    /// The attempt needed more memory than it may have.
    MemoryLimit,
    /// The attempt needed more processor time than it may have.
    CpuLimit,
    /// The planner stopped in the middle: a defect.
    Crashed,
    /// The answer is larger than the service stores.
    AnswerTooLarge,
    /// Three attempts were lost, killed or too slow.
    AttemptsUsedUp,
}

/// A transition that the state does not admit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Illegal {
    /// Only a queued job can be started.
    #[error("the job does not wait in the queue")]
    NotQueued,
    /// The attempt is not the job's current one: it was cancelled, or given to another worker.
    #[error("this attempt is not the job's current one any more")]
    FenceLost,
    /// The job has ended otherwise.
    #[error("the job has ended already")]
    Finished,
}

/// A job as it begins.
#[derive(Debug, Clone, PartialEq)]
pub struct NewJob {
    /// Its id.
    pub id: JobId,
    /// The kind of work, as in the document.
    pub kind: String,
    /// A label for people.
    pub name: String,
    /// Free, searchable strings.
    pub references: BTreeMap<String, String>,
    /// The program whose dry run it plans, if it was asked for as that.
    pub dry_run_of: Option<ProgramId>,
}

/// What a running job knows of its attempt.
struct Attempt {
    queued_since: Moment,
    started_at: Moment,
}

impl Job {
    /// Puts a new job into the queue.
    #[must_use]
    pub fn queue(new: NewJob, now: Moment) -> Self {
        let NewJob { id, kind, name, references, dry_run_of } = new;
        let (created_at, state) = (now, State::Queued { since: now });
        let (attempts, fence, version) = (0, 0, 1);
        Self { id, kind, name, references, dry_run_of, created_at, attempts, fence, version, state }
    }

    /// Starts an attempt and counts it.
    ///
    /// # Errors
    /// `NotQueued`.
    pub fn start(self, worker: WorkerId, now: Moment) -> Result<Self, Illegal> {
        let State::Queued { since } = self.state else {
            return Err(Illegal::NotQueued);
        };
        let state = State::Running { queued_since: since, worker, started_at: now, stage: None };
        let (attempts, fence) = (self.attempts + 1, self.fence + 1);
        Ok(Self { attempts, fence, state, ..self }.changed())
    }

    /// Notes the stage that the attempt has reached.
    ///
    /// # Errors
    /// `FenceLost`.
    pub fn reach(mut self, fence: i64, reached: &str) -> Result<Self, Illegal> {
        self.attempt(fence)?;
        if let State::Running { stage, .. } = &mut self.state {
            *stage = Some(reached.to_owned());
        }
        Ok(self.changed())
    }

    /// Ends the job with an answer: whether it is usable, and how many warnings there are. A job that asks for figures alone may be usable without a program.
    ///
    /// # Errors
    /// `FenceLost`.
    pub fn succeed(
        self,
        fence: i64,
        (usable, warnings): (bool, u32),
        program: Option<ProgramId>,
        stages: Vec<StageTime>,
        now: Moment,
    ) -> Result<Self, Illegal> {
        let Attempt { started_at, .. } = self.attempt(fence)?;
        let state = State::Succeeded {
            started_at,
            finished_at: now,
            usable,
            warnings: Some(warnings),
            program,
            stages,
        };
        Ok(Self { state, ..self }.changed())
    }

    /// Ends the job without an answer: another attempt would end the same way.
    ///
    /// # Errors
    /// `FenceLost`.
    pub fn fail(self, fence: i64, failure: Failure, now: Moment) -> Result<Self, Illegal> {
        self.attempt(fence)?;
        Ok(Self { state: State::Failed { finished_at: now, failure }, ..self }.changed())
    }

    /// Ends an attempt that was lost, killed or too slow: back into the queue, or failed after the last one.
    ///
    /// # Errors
    /// `FenceLost`.
    pub fn retry(self, fence: i64, why: &str, now: Moment) -> Result<Self, Illegal> {
        let Attempt { queued_since, .. } = self.attempt(fence)?;
        if self.attempts < MOST_ATTEMPTS {
            return Ok(Self { state: State::Queued { since: queued_since }, ..self }.changed());
        }
        let detail = format!("{MOST_ATTEMPTS} attempts ended without an answer; the last one: {why}");
        self.fail(fence, Failure { code: FailureCode::AttemptsUsedUp, detail, findings: Vec::new() }, now)
    }

    /// Gives an attempt back that was stopped in order: it does not count against the job.
    ///
    /// # Errors
    /// `FenceLost`.
    pub fn release(self, fence: i64) -> Result<Self, Illegal> {
        let Attempt { queued_since, .. } = self.attempt(fence)?;
        let attempts = self.attempts.saturating_sub(1);
        Ok(Self { attempts, state: State::Queued { since: queued_since }, ..self }.changed())
    }

    /// Ends the job because somebody does not want it any more. A cancelled job stays as it is.
    ///
    /// # Errors
    /// `Finished` if it has succeeded or failed.
    pub fn cancel(self, by: &str, reason: Option<String>, now: Moment) -> Result<Self, Illegal> {
        match self.state {
            State::Queued { .. } | State::Running { .. } => {
                let state = State::Cancelled { finished_at: now, by: by.to_owned(), reason };
                Ok(Self { state, ..self }.changed())
            }
            State::Cancelled { .. } => Ok(self),
            State::Succeeded { .. } | State::Failed { .. } => Err(Illegal::Finished),
        }
    }

    fn attempt(&self, fence: i64) -> Result<Attempt, Illegal> {
        match self.state {
            State::Running { queued_since, started_at, .. } if self.fence == fence => {
                Ok(Attempt { queued_since, started_at })
            }
            _ => Err(Illegal::FenceLost),
        }
    }

    fn changed(self) -> Self {
        Self { version: self.version + 1, ..self }
    }
}

impl State {
    /// Every state's word, as filters know it.
    pub const WORDS: [&'static str; 5] = ["queued", "running", "succeeded", "failed", "cancelled"];

    /// The state's word.
    #[must_use]
    pub fn word(&self) -> &'static str {
        match self {
            Self::Queued { .. } => "queued",
            Self::Running { .. } => "running",
            Self::Succeeded { .. } => "succeeded",
            Self::Failed { .. } => "failed",
            Self::Cancelled { .. } => "cancelled",
        }
    }

    /// Whether nothing will change any more.
    #[must_use]
    pub fn is_final(&self) -> bool {
        !matches!(self, Self::Queued { .. } | Self::Running { .. })
    }
}

impl FailureCode {
    /// The code as text.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::InvalidInput => "invalid_input",
            Self::InputDamaged => "input_damaged",
            Self::MemoryLimit => "memory_limit",
            Self::CpuLimit => "cpu_limit",
            Self::Crashed => "crashed",
            Self::AnswerTooLarge => "answer_too_large",
            Self::AttemptsUsedUp => "attempts_used_up",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const T0: Moment = Moment::from_unix_ms(1_000);
    const T1: Moment = Moment::from_unix_ms(2_000);

    fn queued() -> Job {
        let id = JobId::new(T0, &[1; 10]);
        Job::queue(
            NewJob {
                id,
                kind: "tape-cut".into(),
                name: String::new(),
                references: BTreeMap::new(),
                dry_run_of: None,
            },
            T0,
        )
    }

    fn worker() -> WorkerId {
        WorkerId::new(T0, &[2; 10])
    }

    #[test]
    fn an_attempt_is_counted_before_it_starts() {
        let running = queued().start(worker(), T1).unwrap();
        assert_eq!((running.attempts, running.fence, running.version), (1, 1, 2));
        assert_eq!(running.start(worker(), T1), Err(Illegal::NotQueued));
    }

    #[test]
    fn the_third_lost_attempt_fails_the_job_and_says_why() {
        let mut job = queued();
        for fence in 1..=2 {
            job = job.start(worker(), T1).unwrap().retry(fence, "killed", T1).unwrap();
            assert_eq!(
                job.state,
                State::Queued { since: T0 },
                "attempt {fence} keeps its place in the queue"
            );
        }
        let failed = job.start(worker(), T1).unwrap().retry(3, "killed by signal 9", T1).unwrap();
        let State::Failed { failure, .. } = failed.state else { panic!("{:?}", failed.state) };
        assert_eq!(failure.code, FailureCode::AttemptsUsedUp);
        assert!(failure.detail.contains("signal 9"), "{}", failure.detail);
    }

    #[test]
    fn an_attempt_that_was_stopped_in_order_does_not_count() {
        let mut job = queued();
        for fence in 1..=10 {
            job = job.start(worker(), T1).unwrap().release(fence).unwrap();
        }
        assert_eq!((job.attempts, job.fence), (0, 10));
    }

    #[test]
    fn an_old_fence_can_do_nothing() {
        let job = queued().start(worker(), T0).unwrap().retry(1, "lost", T0).unwrap();
        let job = job.start(worker(), T1).unwrap();
        assert_eq!(job.clone().succeed(1, (false, 0), None, vec![], T1), Err(Illegal::FenceLost));
        assert_eq!(job.clone().reach(1, "chains"), Err(Illegal::FenceLost));
        assert_eq!(job.clone().release(1), Err(Illegal::FenceLost));
        assert_eq!(job.clone().retry(1, "late", T1), Err(Illegal::FenceLost));
        assert!(job.succeed(2, (false, 0), None, vec![], T1).is_ok());
    }

    #[test]
    fn a_cancelled_job_takes_no_answer_and_a_finished_one_no_cancellation() {
        let cancelled = queued().start(worker(), T0).unwrap().cancel("mes", None, T1).unwrap();
        assert_eq!(cancelled.clone().succeed(1, (false, 0), None, vec![], T1), Err(Illegal::FenceLost));
        assert_eq!(cancelled.clone().cancel("mes", None, T1), Ok(cancelled));
        let done = queued().start(worker(), T0).unwrap().succeed(1, (false, 0), None, vec![], T1).unwrap();
        assert_eq!(done.cancel("mes", None, T1), Err(Illegal::Finished));
    }
}
