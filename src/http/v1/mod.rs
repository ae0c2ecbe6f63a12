//! Version 1 of the interface. Each resource is one file; `wire` holds the types that stand in JSON.

pub mod approvals;
pub mod audit;
pub mod claims;
pub mod dry_runs;
pub mod entries;
pub mod events;
pub mod jobs;
pub mod machines;
pub mod posting;
pub mod programs;
pub mod ranges;
pub mod reports;
pub mod runs;
pub mod wire;

use utoipa_axum::router::OpenApiRouter;

use super::service::Service;

/// The addresses of version 1.
#[must_use]
pub fn routes() -> OpenApiRouter<Service> {
    OpenApiRouter::new()
        .merge(jobs::routes())
        .merge(programs::routes())
        .merge(approvals::routes())
        .merge(dry_runs::routes())
        .merge(machines::routes())
        .merge(audit::routes())
        .merge(entries::routes())
        .merge(claims::routes())
        .merge(runs::routes())
        .merge(reports::routes())
}
