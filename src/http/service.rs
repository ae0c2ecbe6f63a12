//! What every handler can reach.

use std::sync::Arc;
use std::time::Duration;

use metrics_exporter_prometheus::PrometheusHandle;
use tokio::sync::{Semaphore, SemaphorePermit};

use super::intake::Intake;
use super::problem::{Answer, Problem, ProblemCode};
use crate::config::Config;
use crate::stopping::Stopping;
use crate::store::Store;

/// So many documents are checked at the same time.
const CHECKS: usize = 4;

/// A post waits so long for its check to begin.
const PATIENCE: Duration = Duration::from_secs(10);

/// What every handler can reach; a clone is another handle on the same.
#[derive(Clone)]
pub struct Service(Arc<Inner>);

struct Inner {
    store: Store,
    config: Config,
    metrics: PrometheusHandle,
    stopping: Stopping,
    intake: Intake,
    checks: Semaphore,
}

impl Service {
    /// Puts the service together.
    #[must_use]
    pub fn new(store: Store, config: Config, metrics: PrometheusHandle, stopping: Stopping) -> Self {
        let intake = Intake::new(config.max_body_bytes());
        Self(Arc::new(Inner { store, config, metrics, stopping, intake, checks: Semaphore::new(CHECKS) }))
    }

    /// The store.
    #[must_use]
    pub fn store(&self) -> &Store {
        &self.0.store
    }

    /// The settings.
    #[must_use]
    pub fn config(&self) -> &Config {
        &self.0.config
    }

    /// The metrics in Prometheus' text format.
    #[must_use]
    pub fn metrics(&self) -> String {
        self.0.metrics.run_upkeep();
        self.0.metrics.render()
    }

    /// Where request bodies are taken in.
    #[must_use]
    pub fn intake(&self) -> &Intake {
        &self.0.intake
    }

    /// Whether the service has been told to end.
    #[must_use]
    pub fn is_stopping(&self) -> bool {
        self.0.stopping.is_stopping()
    }

    /// Ends when the service has been told to end.
    pub async fn stopped(&self) {
        self.0.stopping.stopped().await;
    }

    /// The registered profiles that a job can name beside the built-in ones: a JSON array, frozen with each job.
    ///
    /// # Errors
    /// `Internal`.
    pub async fn machines(&self) -> Answer<String> {
        let machines = self.store().machines().await?;
        let profiles: Vec<_> = machines.into_iter().map(|machine| machine.profile).collect();
        serde_json::to_string(&profiles).map_err(Problem::internal)
    }

    /// Waits for a place to check a document, but not for long.
    ///
    /// # Errors
    /// `Overloaded`.
    pub async fn place_to_check(&self) -> Answer<SemaphorePermit<'_>> {
        match tokio::time::timeout(PATIENCE, self.0.checks.acquire()).await {
            Ok(Ok(place)) => Ok(place),
            _ => Err(Problem::new(ProblemCode::Overloaded)),
        }
    }
}
