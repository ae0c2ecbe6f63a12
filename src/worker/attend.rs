//! One attempt from its claim to its end.

use std::time::Duration;

use tokio::time::{Instant, MissedTickBehavior, interval, sleep_until};

use super::Worker;
use super::package::package;
use super::planner::{Cause, Heard, Last, Planner, Task};
use crate::clock;
use crate::config::HEARTBEAT;
use crate::job::id::ProgramId;
use crate::job::life::{Failure, FailureCode, Illegal, Job, StageTime, State};
use crate::job::moment::Moment;
use crate::planning::finding::Finding;
use crate::store::{Error, Result};

/// Stages are told to followers this often at most; each telling is a commit.
const TELL: Duration = Duration::from_millis(250);

/// How an attempt ended.
enum End {
    Said(Last),
    Stopped,
    TooSlow,
    NotOurs,
}

/// The stages of an attempt: those that followers have not been told of yet, and when each began.
#[derive(Default)]
struct Stages {
    untold: Vec<(String, Moment)>,
    begun: Vec<(String, f64)>,
}

impl Worker {
    /// Has a claimed job planned and commits what comes of it.
    pub(super) async fn attend(&self, job: Job) {
        let started = Instant::now();
        let ended = self.attempt(&job).await;
        metrics::histogram!("bladeplan_attempt_seconds").record(started.elapsed().as_secs_f64());
        let ending = match &ended {
            Ok(job) => job.state.word(),
            Err(Error::Illegal(Illegal::FenceLost)) => "not_ours",
            Err(_) => "store_error",
        };
        metrics::counter!("bladeplan_attempts_total", "ending" => ending).increment(1);
        match ended {
            Ok(after) => {
                tracing::info!(job = %job.id, fence = job.fence, state = after.state.word(), "attempt ended")
            }
            Err(Error::Illegal(Illegal::FenceLost)) => {
                tracing::info!(job = %job.id, fence = job.fence, "attempt ended; the job is not its own any more");
            }
            // The attempt falls silent, and the job is taken over.
            Err(error) => tracing::error!(job = %job.id, %error, "what an attempt gave could not be written"),
        }
    }

    async fn attempt(&self, job: &Job) -> Result<Job> {
        let input = match self.store.attempt_input(&job.id).await {
            Err(Error::Damaged { subject }) => {
                let detail = format!("{subject} does not fit its hash any more; restore a backup");
                return self.fail(job, FailureCode::InputDamaged, detail, Vec::new()).await;
            }
            other => other?,
        };
        let mut planner = match Planner::start(&self.config, Task::Plan, input) {
            Ok(planner) => planner,
            Err(error) => return self.retry(job, &format!("no process could be started: {error}")).await,
        };
        let mut stages = Stages::default();
        match self.watch(job, &mut planner, &mut stages).await {
            End::Said(last) => self.conclude(job, planner, last, stages).await,
            ended => {
                planner.kill().await;
                self.give_up(job, &ended).await
            }
        }
    }

    /// Watches over a child until it has said its last, or must not go on.
    async fn watch(&self, job: &Job, planner: &mut Planner, stages: &mut Stages) -> End {
        let deadline = Instant::now() + Duration::from_secs(u64::from(self.config.attempt_wall_s));
        let mut changes = self.store.changes().follow();
        let mut beat = ticks(HEARTBEAT);
        let mut tell = ticks(TELL);
        loop {
            tokio::select! {
                heard = planner.hear() => match heard {
                    Heard::Stage(name, at_s) => stages.begin(name, at_s),
                    Heard::Last(last) => return End::Said(last),
                },
                _ = tell.tick(), if !stages.untold.is_empty() => self.tell(job, stages).await,
                _ = beat.tick() => if self.beat(job).await == Some(false) { return End::NotOurs },
                () = changes.hear_of(&job.id) => if self.owns(job).await == Some(false) { return End::NotOurs },
                () = self.stopping.stopped() => return End::Stopped,
                () = sleep_until(deadline) => return End::TooSlow,
            }
        }
    }

    async fn conclude(&self, job: &Job, planner: Planner, last: Last, stages: Stages) -> Result<Job> {
        let cause = planner.cause().await;
        match last {
            Last::Answer { at_s, parts } => {
                let program = ProgramId::new(clock::now(), &clock::entropy());
                match package(parts, stages.times(at_s), program) {
                    Ok(answer) => {
                        self.store.succeed(&job.id, job.fence, &answer, &stages.untold, clock::now()).await
                    }
                    Err(defect) => self.fail(job, FailureCode::Crashed, defect.to_string(), Vec::new()).await,
                }
            }
            Last::Faults(findings) => {
                let detail = "the document or one of its files turned out to be invalid when it was planned"
                    .to_owned();
                self.fail(job, FailureCode::InvalidInput, detail, findings).await
            }
            Last::TooLarge => {
                let detail = "the programs and drawings are larger than is kept; split the ply".to_owned();
                self.fail(job, FailureCode::AnswerTooLarge, detail, Vec::new()).await
            }
            Last::Silence | Last::Sound(_) => match cause {
                Cause::Final(code, detail) => self.fail(job, code, detail, Vec::new()).await,
                Cause::Passing(why) => self.retry(job, &why).await,
            },
        }
    }

    async fn give_up(&self, job: &Job, ended: &End) -> Result<Job> {
        match ended {
            End::Stopped => self.store.release(&job.id, job.fence, clock::now()).await,
            End::TooSlow => {
                let limit = self.config.attempt_wall_s;
                self.retry(job, &format!("it took more than {limit} s by the clock on the wall")).await
            }
            End::NotOurs | End::Said(_) => Err(Illegal::FenceLost.into()),
        }
    }

    async fn fail(
        &self,
        job: &Job,
        code: FailureCode,
        detail: String,
        findings: Vec<Finding>,
    ) -> Result<Job> {
        self.store.fail(&job.id, job.fence, Failure { code, detail, findings }, clock::now()).await
    }

    async fn retry(&self, job: &Job, why: &str) -> Result<Job> {
        self.store.retry(&job.id, job.fence, why, clock::now()).await
    }

    async fn tell(&self, job: &Job, stages: &mut Stages) {
        let untold = std::mem::take(&mut stages.untold);
        if let Err(error) = self.store.reach(&job.id, job.fence, &untold).await {
            tracing::debug!(job = %job.id, %error, "progress could not be noted");
        }
    }

    /// Whether the job is still ours; `None` if the store does not say.
    async fn beat(&self, job: &Job) -> Option<bool> {
        self.store.heartbeat(&job.id, job.fence, clock::now()).await.ok()
    }

    /// Whether the job is still ours; `None` if the store does not say.
    async fn owns(&self, job: &Job) -> Option<bool> {
        let now = self.store.job(&job.id).await.ok()?;
        Some(now.fence == job.fence && matches!(now.state, State::Running { .. }))
    }
}

impl Stages {
    fn begin(&mut self, name: String, at_s: f64) {
        self.untold.push((name.clone(), clock::now()));
        self.begun.push((name, at_s));
    }

    /// How long each stage took: until the next one began, or the end.
    fn times(&self, end_s: f64) -> Vec<StageTime> {
        let ends = self.begun.iter().skip(1).map(|(_, at_s)| *at_s).chain([end_s]);
        let time = |((name, at_s), end_s): (&(String, f64), f64)| StageTime {
            name: name.clone(),
            seconds: end_s - at_s,
        };
        self.begun.iter().zip(ends).map(time).collect()
    }
}

fn ticks(period: Duration) -> tokio::time::Interval {
    let mut ticks = interval(period);
    ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
    ticks
}
