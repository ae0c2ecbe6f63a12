//! Announcements of changes within this process, so that followers and workers need not poll.
//!
//! An announcement is a hint, not a message: whoever hears it reads the store. One that is missed costs a
//! follower a few seconds, never a change.

use tokio::sync::broadcast::{self, Receiver, Sender};

use crate::job::id::JobId;

/// More announcements than this between two looks of a follower make it look once, at everything.
const KEPT: usize = 1024;

/// Where changes of jobs are announced.
#[derive(Debug, Clone)]
pub struct Changes(Sender<JobId>);

impl Default for Changes {
    fn default() -> Self {
        Self(broadcast::channel(KEPT).0)
    }
}

/// Hears of the changes since it was made.
#[derive(Debug)]
pub struct Follower(Receiver<JobId>);

impl Changes {
    /// Starts to listen.
    #[must_use]
    pub fn follow(&self) -> Follower {
        Follower(self.0.subscribe())
    }

    /// Says that a job has changed.
    pub(super) fn announce(&self, job: &JobId) {
        // Nobody may be listening.
        let _ = self.0.send(job.clone());
    }
}

impl Follower {
    /// Waits until `job` may have changed.
    pub async fn hear_of(&mut self, job: &JobId) {
        loop {
            match self.0.recv().await {
                Ok(changed) if changed == *job => return,
                Ok(_) => {}
                Err(broadcast::error::RecvError::Lagged(_)) => return,
                Err(broadcast::error::RecvError::Closed) => std::future::pending().await,
            }
        }
    }

    /// Waits until any job may have changed.
    pub async fn hear(&mut self) {
        if let Err(broadcast::error::RecvError::Closed) = self.0.recv().await {
            std::future::pending().await
        }
        // One look covers all that was announced until now.
        self.0 = self.0.resubscribe();
    }
}
