//! What machines say about their runs, and what people decide about them. Each report of a machine carries the
//! fence that it was given, and is a sign of life.

use axum::Json;
use axum::extract::State;
use serde::Deserialize;
use utoipa::ToSchema;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use super::machines::reason;
use super::runs::{RunBody, own_run};
use crate::clock;
use crate::http::caller::Caller;
use crate::http::extract::{Body, Path};
use crate::http::problem::{Answer, Problem, ProblemBody, ProblemCode, of_run};
use crate::http::service::Service;
use crate::job::run::{Ending, How, Material, Outcome, Resolution, Run, Sign};
use crate::store;

/// The addresses.
#[must_use]
pub fn routes() -> OpenApiRouter<Service> {
    OpenApiRouter::new()
        .routes(routes!(put_receipt))
        .routes(routes!(put_start))
        .routes(routes!(put_heartbeat))
        .routes(routes!(put_result))
        .routes(routes!(put_resolution))
}

/// The longest lot, spool or cassette, in characters.
const LONGEST_LABEL: usize = 100;

/// Which bytes a machine has
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
struct ReceiptRequest {
    /// The run's fence.
    fence: i64,
    /// The SHA-256 of the bytes that arrived, in lower-case hex.
    sha256: String,
    /// How many bytes arrived.
    size: i64,
}

/// A report with nothing but the fence
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
struct FenceRequest {
    /// The run's fence.
    fence: i64,
}

/// How a run has ended
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
struct ResultRequest {
    /// The run's fence.
    fence: i64,
    /// done, failed or aborted. What has not started can only be aborted.
    #[schema(value_type = String, example = "done")]
    outcome: Outcome,
    /// Why, at most 500 characters.
    reason: Option<String>,
    /// The lot of the prepreg, at most 100 characters like the others.
    prepreg_lot: Option<String>,
    /// The spool.
    spool: Option<String>,
    /// The cassette that the pieces went into.
    cassette: Option<String>,
}

/// What becomes of the unit of a run
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
struct ResolutionRequest {
    /// requeue: nothing of it counts, the unit waits again. scrap: it is lost. was_done: it was cut as it should be.
    #[schema(value_type = String, example = "requeue")]
    how: How,
    /// Why, 1 to 500 characters.
    reason: String,
}

/// Say that the program has arrived
///
/// With the hash and the length of what arrived. Other bytes than the program's are refused, and the run cannot
/// start with them.
#[utoipa::path(put, path = "/v1/runs/{r}/receipt", tag = "shop floor", request_body = ReceiptRequest,
    params(("r" = String, Path, description = "The run")),
    responses(
        (status = 200, description = "The run, received", body = RunBody),
        (status = 403, description = "It is another machine's", body = ProblemBody, content_type = "application/problem+json"),
        (status = 404, description = "There is none", body = ProblemBody, content_type = "application/problem+json"),
        (status = 409, description = "Other bytes, another fence, or a run that has started or ended", body = ProblemBody, content_type = "application/problem+json")))]
async fn put_receipt(
    State(service): State<Service>,
    caller: Caller,
    Path(run): Path<String>,
    Body(request): Body<ReceiptRequest>,
) -> Answer<Json<RunBody>> {
    let run = own_run(&service, &caller, &run).await?;
    let sign = sign(&service, request.fence);
    answered(service.store().receive(&run.id, sign, &request.sha256, request.size, &caller.actor).await)
}

/// Ask to begin to cut
///
/// The last moment at which the service can say no: without a receipt, with a program that was revoked or damaged in
/// the meantime, or with a machine on hold, the knife stays up.
#[utoipa::path(put, path = "/v1/runs/{r}/start", tag = "shop floor", request_body = FenceRequest,
    params(("r" = String, Path, description = "The run")),
    responses(
        (status = 200, description = "The run, running", body = RunBody),
        (status = 403, description = "It is another machine's", body = ProblemBody, content_type = "application/problem+json"),
        (status = 404, description = "There is none", body = ProblemBody, content_type = "application/problem+json"),
        (status = 409, description = "Do not cut", body = ProblemBody, content_type = "application/problem+json")))]
async fn put_start(
    State(service): State<Service>,
    caller: Caller,
    Path(run): Path<String>,
    Body(request): Body<FenceRequest>,
) -> Answer<Json<RunBody>> {
    let run = own_run(&service, &caller, &run).await?;
    let sign = sign(&service, request.fence);
    answered(service.store().start_run(&run.id, sign, &caller.actor).await)
}

/// Say that the machine lives
///
/// Several times within the lease. A suspect run is again where it was.
#[utoipa::path(put, path = "/v1/runs/{r}/heartbeat", tag = "shop floor", request_body = FenceRequest,
    params(("r" = String, Path, description = "The run")),
    responses(
        (status = 200, description = "The run", body = RunBody),
        (status = 403, description = "It is another machine's", body = ProblemBody, content_type = "application/problem+json"),
        (status = 404, description = "There is none", body = ProblemBody, content_type = "application/problem+json"),
        (status = 409, description = "Stop: somebody has resolved the run, or it has ended", body = ProblemBody, content_type = "application/problem+json")))]
async fn put_heartbeat(
    State(service): State<Service>,
    caller: Caller,
    Path(run): Path<String>,
    Body(request): Body<FenceRequest>,
) -> Answer<Json<RunBody>> {
    let run = own_run(&service, &caller, &run).await?;
    let sign = sign(&service, request.fence);
    answered(service.store().beat_run(&run.id, sign, &caller.actor).await)
}

/// Say how the run has ended
///
/// A run that is aborted before its start gives its unit back: nothing was cut. One that has failed or was aborted
/// after its start waits for a person.
#[utoipa::path(put, path = "/v1/runs/{r}/result", tag = "shop floor", request_body = ResultRequest,
    params(("r" = String, Path, description = "The run")),
    responses(
        (status = 200, description = "The run, ended", body = RunBody),
        (status = 403, description = "It is another machine's", body = ProblemBody, content_type = "application/problem+json"),
        (status = 404, description = "There is none", body = ProblemBody, content_type = "application/problem+json"),
        (status = 409, description = "Another fence, not started, or ended otherwise", body = ProblemBody, content_type = "application/problem+json"),
        (status = 422, description = "The body has a fault", body = ProblemBody, content_type = "application/problem+json")))]
async fn put_result(
    State(service): State<Service>,
    caller: Caller,
    Path(run): Path<String>,
    Body(request): Body<ResultRequest>,
) -> Answer<Json<RunBody>> {
    let run = own_run(&service, &caller, &run).await?;
    let sign = sign(&service, request.fence);
    let ending = ending(request)?;
    answered(service.store().end_run(&run.id, sign, ending, &caller.actor).await)
}

/// Decide what becomes of a unit
///
/// Of a suspect run, or one that has failed or was aborted after its start. Look at the machine first. The fence
/// rises: a machine that comes back late is refused.
#[utoipa::path(put, path = "/v1/runs/{r}/resolution", tag = "shop floor", request_body = ResolutionRequest,
    params(("r" = String, Path, description = "The run")),
    responses(
        (status = 200, description = "The run, resolved", body = RunBody),
        (status = 404, description = "There is none", body = ProblemBody, content_type = "application/problem+json"),
        (status = 409, description = "There is nothing to decide", body = ProblemBody, content_type = "application/problem+json"),
        (status = 422, description = "The body has a fault", body = ProblemBody, content_type = "application/problem+json")))]
async fn put_resolution(
    State(service): State<Service>,
    caller: Caller,
    Path(run): Path<String>,
    Body(request): Body<ResolutionRequest>,
) -> Answer<Json<RunBody>> {
    let run = own_run(&service, &caller, &run).await?;
    let reason = reason(&request.reason)?.to_owned();
    let resolution = Resolution { how: request.how, by: caller.actor, reason, at: clock::now() };
    answered(service.store().resolve_run(&run.id, resolution).await)
}

fn sign(service: &Service, fence: i64) -> Sign {
    let now = clock::now();
    Sign { fence, now, lease_until: now.later_by_ms(service.config().lease_ms()) }
}

fn answered(run: store::Result<Run>) -> Answer<Json<RunBody>> {
    Ok(Json(run.map_err(of_run)?.into()))
}

fn ending(request: ResultRequest) -> Answer<Ending> {
    let ResultRequest { outcome, reason: words, prepreg_lot, spool, cassette, .. } = request;
    if let Some(words) = &words {
        reason(words)?;
    }
    for label in [&prepreg_lot, &spool, &cassette].into_iter().flatten() {
        refuse_strange_label(label)?;
    }
    Ok(Ending { outcome, reason: words, material: Material { prepreg_lot, spool, cassette } })
}

fn refuse_strange_label(label: &str) -> Answer<()> {
    let length = label.chars().count();
    if (1..=LONGEST_LABEL).contains(&length) && !label.chars().any(char::is_control) {
        return Ok(());
    }
    let detail = format!("prepreg_lot, spool and cassette: 1 to {LONGEST_LABEL} characters in one line");
    Err(Problem::new(ProblemCode::InvalidRequest).detail(detail))
}
