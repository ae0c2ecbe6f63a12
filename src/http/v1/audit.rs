//! The audit trail, for those who read it.

use axum::extract::State;
use axum::http::header;
use axum::response::{IntoResponse, Response};
use serde::Deserialize;
use serde_json::json;
use utoipa::IntoParams;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use crate::http::extract::Query;
use crate::http::problem::{Answer, Problem, ProblemBody, ProblemCode};
use crate::http::service::Service;
use crate::job::moment::Moment;
use crate::store::audit::AuditRow;

/// The addresses.
#[must_use]
pub fn routes() -> OpenApiRouter<Service> {
    OpenApiRouter::new().routes(routes!(read_audit))
}

/// A page of the trail has at most so many rows.
const LARGEST_PAGE: i64 = 10_000;

/// The query of the trail.
#[derive(Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
struct AuditQuery {
    /// The rows after this one; 0 for the first.
    #[serde(default)]
    after: i64,
    /// How many at most, 1 to 10000; 1000 if left out.
    limit: Option<i64>,
}

/// Read the audit trail
///
/// One JSON object a line, in order. Every row carries the hash of the row before it and its own; rows whose hash
/// or place does not fit are marked `"broken": true`.
#[utoipa::path(get, path = "/v1/audit", tag = "operations", params(AuditQuery), responses(
    (status = 200, description = "The rows", body = String, content_type = "application/x-ndjson"),
    (status = 400, description = "The query has a fault", body = ProblemBody, content_type = "application/problem+json")))]
async fn read_audit(State(service): State<Service>, Query(query): Query<AuditQuery>) -> Answer<Response> {
    let limit = query.limit.unwrap_or(1000);
    if !(1..=LARGEST_PAGE).contains(&limit) || query.after < 0 {
        let detail = format!("after is 0 or more, limit 1 to {LARGEST_PAGE}");
        return Err(Problem::new(ProblemCode::InvalidQuery).detail(detail));
    }
    // The row before the page belongs to its chain.
    let rows = service.store().audit((query.after - 1).max(0), limit + 1).await?;
    let first = rows.iter().take_while(|row| row.seq <= query.after).count();
    let page = (first..rows.len()).take(usize::try_from(limit).unwrap_or_default());
    let text: String =
        page.map(|at| line(&rows[at], at.checked_sub(1).map(|before| &rows[before]))).collect();
    Ok(([(header::CONTENT_TYPE, "application/x-ndjson")], text).into_response())
}

fn line(row: &AuditRow, before: Option<&AuditRow>) -> String {
    let follows = match before {
        Some(before) => row.seq == before.seq + 1 && row.previous == before.hash,
        None => row.seq == 1,
    };
    let mut value = json!({
        "seq": row.seq,
        "at": Moment::from_unix_ms(row.at).to_string(),
        "actor": row.actor,
        "action": row.action,
        "subject": row.subject,
        "detail": serde_json::from_str::<serde_json::Value>(&row.detail).unwrap_or_default(),
        "previous": row.previous,
        "hash": row.hash,
    });
    if !follows || row.hash != row.expected_hash() {
        value["broken"] = json!(true);
    }
    format!("{value}\n")
}
