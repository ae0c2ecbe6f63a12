//! The word that the service ends. Whoever waits for anything long also waits for this.

use tokio::sync::watch;

/// Says that the service ends.
#[derive(Debug)]
pub struct Stop(watch::Sender<bool>);

/// Hears that the service ends.
#[derive(Debug, Clone)]
pub struct Stopping(watch::Receiver<bool>);

/// Both ends of the word.
#[must_use]
pub fn channel() -> (Stop, Stopping) {
    let (sender, receiver) = watch::channel(false);
    (Stop(sender), Stopping(receiver))
}

impl Stop {
    /// Says it, once and for all.
    pub fn stop(&self) {
        self.0.send_replace(true);
    }
}

impl Stopping {
    /// Whether it was said.
    #[must_use]
    pub fn is_stopping(&self) -> bool {
        *self.0.borrow()
    }

    /// Ends when it is said.
    pub async fn stopped(&self) {
        let mut receiver = self.0.clone();
        // A sender that is gone cannot say it any more: the service has ended.
        let _ = receiver.wait_for(|stopping| *stopping).await;
    }
}
