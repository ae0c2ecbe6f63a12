//! What the people who run the service look at.

use axum::Json;
use axum::extract::State;
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::Serialize;
use utoipa::ToSchema;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use super::openapi;
use super::problem::{Answer, Problem, ProblemBody, ProblemCode};
use super::service::Service;
use crate::job::life::State as JobState;
use crate::planning::outcome::PLANNER_VERSION;
use crate::store::counters::REFUSED_POSTS;

/// The addresses.
#[must_use]
pub fn routes() -> OpenApiRouter<Service> {
    OpenApiRouter::new()
        .routes(routes!(livez))
        .routes(routes!(readyz))
        .routes(routes!(metrics))
        .routes(routes!(version))
        .route("/openapi.json", axum::routing::get(document))
}

/// Which program this is.
#[derive(Debug, Serialize, ToSchema)]
struct Version {
    /// Its name.
    #[schema(example = "bladeplan")]
    name: &'static str,
    /// Its version.
    #[schema(value_type = String)]
    version: &'static str,
    /// The version of the planner, as it stands in reports.
    #[schema(value_type = String)]
    planner_version: &'static str,
}

/// Whether the process lives
#[utoipa::path(get, path = "/livez", tag = "operations",
    responses((status = 200, description = "It does", body = String, content_type = "text/plain")))]
async fn livez() -> &'static str {
    "ok\n"
}

/// Whether requests should be sent here
#[utoipa::path(get, path = "/readyz", tag = "operations", responses(
    (status = 200, description = "They should", body = String, content_type = "text/plain"),
    (status = 503, description = "The service is ending or its store does not answer", body = ProblemBody,
     content_type = "application/problem+json")))]
async fn readyz(State(service): State<Service>) -> Answer<&'static str> {
    if service.is_stopping() {
        return Err(Problem::new(ProblemCode::Stopping));
    }
    service.store().ping().await?;
    Ok("ready\n")
}

/// Counters and durations in Prometheus' text format
#[utoipa::path(get, path = "/metrics", tag = "operations",
    responses((status = 200, description = "The metrics", body = String, content_type = "text/plain")))]
async fn metrics(State(service): State<Service>) -> Answer<Response> {
    let counts = service.store().jobs_by_state().await?;
    for state in JobState::WORDS {
        let count = counts.get(state).copied().unwrap_or_default();
        metrics::gauge!("bladeplan_jobs", "state" => state).set(as_f64(count));
    }
    for (code, count) in service.store().counts(REFUSED_POSTS).await? {
        metrics::counter!("bladeplan_posts_refused_total", "code" => code).absolute(count.unsigned_abs());
    }
    let kind = [(header::CONTENT_TYPE, "text/plain; version=0.0.4; charset=utf-8")];
    Ok((kind, service.metrics()).into_response())
}

/// Which program this is
#[utoipa::path(get, path = "/version", tag = "operations",
    responses((status = 200, description = "Name and versions", body = Version)))]
async fn version() -> Json<Version> {
    let version = env!("CARGO_PKG_VERSION");
    Json(Version { name: "bladeplan", version, planner_version: PLANNER_VERSION })
}

async fn document() -> Response {
    let kind = [(header::CONTENT_TYPE, "application/json")];
    (StatusCode::OK, kind, openapi::text()).into_response()
}

#[expect(clippy::cast_precision_loss, reason = "nobody has 2^53 jobs")]
fn as_f64(count: i64) -> f64 {
    count as f64
}
