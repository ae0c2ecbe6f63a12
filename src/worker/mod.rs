//! Workers: each takes the job that waits longest, has a child plan it, and commits what the child gives back,
//! if the job is still its own.

mod attend;
pub mod checking;
pub mod child;
pub mod package;
pub mod planner;
pub mod protocol;

use std::time::Duration;

use tokio::task::JoinSet;

use crate::clock;
use crate::config::{Config, LOOK_FOR_SILENCE, SILENCE};
use crate::job::id::WorkerId;
use crate::stopping::Stopping;
use crate::store::attempts::Lost;
use crate::store::{Result, Store};

/// An announcement that was missed costs a waiting job so much at most.
const LOOK_AGAIN: Duration = Duration::from_secs(2);

/// After an error of the store it is asked again so much later.
const STORE_PAUSE: Duration = Duration::from_secs(1);

/// Workers give their jobs back within this time when the service ends.
const END: Duration = Duration::from_secs(10);

/// The workers of this process.
pub struct Workers(JoinSet<()>);

/// One worker.
pub(crate) struct Worker {
    id: WorkerId,
    store: Store,
    config: Config,
    stopping: Stopping,
}

/// Takes over what a process that was killed has left, and starts the workers.
///
/// The caller holds the lock of the one process that serves this store.
///
/// # Errors
/// If the store cannot be read or written.
pub async fn start(store: &Store, config: &Config, stopping: &Stopping) -> Result<Workers> {
    for job in store.recover(Lost::All, clock::now()).await? {
        tracing::warn!(%job, "its attempt was left running when the service ended; it waits again");
    }
    let mut tasks = JoinSet::new();
    for _ in 0..config.worker_count() {
        let id = WorkerId::new(clock::now(), &clock::entropy());
        let (store, config, stopping) = (store.clone(), config.clone(), stopping.clone());
        tasks.spawn(Worker { id, store, config, stopping }.run());
    }
    tasks.spawn(sweep(store.clone(), stopping.clone()));
    tasks.spawn(watch_machines(store.clone(), stopping.clone()));
    Ok(Workers(tasks))
}

impl Workers {
    /// Waits until every worker has given its job back.
    pub async fn end(mut self) {
        let all = async { while self.0.join_next().await.is_some() {} };
        if tokio::time::timeout(END, all).await.is_err() {
            tracing::warn!("a worker did not end in time; its job is taken over at the next start");
        }
    }
}

impl Worker {
    async fn run(self) {
        let mut changes = self.store.changes().follow();
        while !self.stopping.is_stopping() {
            match self.claim().await {
                Ok(Some(job)) => self.attend(job).await,
                Ok(None) => {
                    tokio::select! {
                        _ = tokio::time::timeout(LOOK_AGAIN, changes.hear()) => {}
                        () = self.stopping.stopped() => {}
                    }
                }
                Err(error) => {
                    tracing::error!(%error, "a worker cannot reach the store");
                    tokio::time::sleep(STORE_PAUSE).await;
                }
            }
        }
    }

    /// Looks before it takes the write lock.
    async fn claim(&self) -> Result<Option<crate::job::life::Job>> {
        if self.store.any_queued().await? { self.store.claim(&self.id, clock::now()).await } else { Ok(None) }
    }
}

/// Ends the attempts of workers that were silent for too long.
async fn sweep(store: Store, stopping: Stopping) {
    let silence = i64::try_from(SILENCE.as_millis()).unwrap_or(i64::MAX);
    while tokio::time::timeout(SILENCE / 2, stopping.stopped()).await.is_err() {
        let now = clock::now();
        match store.recover(Lost::SilentSince(now.earlier_by_ms(silence)), now).await {
            Ok(jobs) => {
                jobs.iter().for_each(|job| tracing::warn!(%job, "its worker fell silent; it waits again"))
            }
            Err(error) => tracing::error!(%error, "lost workers cannot be looked for"),
        }
    }
}

/// Makes the runs suspect whose machine was silent for too long. Nothing is given out again.
async fn watch_machines(store: Store, stopping: Stopping) {
    while tokio::time::timeout(LOOK_FOR_SILENCE, stopping.stopped()).await.is_err() {
        match store.mark_silent(clock::now()).await {
            Ok(runs) => runs
                .iter()
                .for_each(|run| tracing::warn!(%run, "its machine fell silent; a person must look")),
            Err(error) => tracing::error!(%error, "silent machines cannot be looked for"),
        }
    }
}
