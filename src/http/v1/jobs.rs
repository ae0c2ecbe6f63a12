//! Jobs: looking at them and cancelling them. Posting is in [`super::posting`], following in [`super::events`].

use std::time::Duration;

use axum::Json;
use axum::extract::State;
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::Deserialize;
use tokio::time::{Instant, timeout_at};
use utoipa::{IntoParams, ToSchema};
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use super::posting::entity_tag;
use super::programs::deliver;
use super::ranges::matches_tag;
use super::wire::{JobBody, JobPageBody, StateWord};
use super::{events, posting};
use crate::clock;
use crate::config::MOST_WAIT_S;
use crate::http::caller::Caller;
use crate::http::extract::{JobPath, OptionalBody, Query};
use crate::http::problem::{Answer, Problem, ProblemBody, ProblemCode, of_job};
use crate::http::service::Service;
use crate::job::id::JobId;
use crate::job::life::{Job, State as JobState};
use crate::store::Error;
use crate::store::jobs::JobFilter;

/// The addresses.
#[must_use]
pub fn routes() -> OpenApiRouter<Service> {
    OpenApiRouter::new()
        .routes(routes!(posting::post_job, list_jobs))
        .routes(routes!(get_job))
        .routes(routes!(events::follow_job))
        .routes(routes!(get_input))
        .routes(routes!(get_job_file))
        .routes(routes!(get_report))
        .routes(routes!(get_drawing))
        .routes(routes!(cancel_job))
}

/// A page has so many items if nothing else is asked for, and at most so many.
const PAGE: i64 = 50;
const LARGEST_PAGE: i64 = 200;

/// An announcement that was missed costs a waiting client so much at most.
const LOOK_AGAIN: Duration = Duration::from_secs(5);

/// The query of a list of jobs.
#[derive(Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
struct ListQuery {
    /// queued, running, succeeded, failed or cancelled.
    #[param(value_type = Option<StateWord>)]
    state: Option<String>,
    /// The kind of work, such as tape-cut.
    kind: Option<String>,
    /// A reference as NAME:VALUE, such as work_order:4711.
    #[param(pattern = "^[^:]*:")]
    reference: Option<String>,
    /// Where the page begins: the `next_cursor` of the page before.
    #[param(pattern = "^job_[0-9a-f]{32}$")]
    cursor: Option<String>,
    /// How many at most, 1 to 200; 50 if left out.
    #[param(minimum = 1, maximum = 200)]
    limit: Option<i64>,
}

/// The query of a job.
#[derive(Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
struct WaitQuery {
    /// Seconds to wait for the job's end, 0 to 50; with If-None-Match, for any change.
    #[serde(default)]
    #[param(maximum = 50)]
    wait: u32,
}

/// Why a job is cancelled
#[derive(Debug, Default, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
struct CancellationRequest {
    /// In words, at most 500 characters.
    #[schema(max_length = 500)]
    reason: Option<String>,
}

const LONGEST_REASON: usize = 500;

/// List jobs, the newest first
#[utoipa::path(get, path = "/v1/jobs", tag = "jobs", params(ListQuery), responses(
    (status = 200, description = "A page of jobs", body = JobPageBody),
    (status = 400, description = "The query has a fault", body = ProblemBody, content_type = "application/problem+json")))]
async fn list_jobs(
    State(service): State<Service>,
    Query(query): Query<ListQuery>,
) -> Answer<Json<JobPageBody>> {
    let filter = job_filter(query)?;
    let limit = filter.limit;
    let jobs = service.store().jobs(&JobFilter { limit: limit + 1, ..filter }).await?;
    let more = jobs.len() as i64 > limit;
    let mut page = Vec::new();
    for job in jobs.into_iter().take(usize::try_from(limit).unwrap_or_default()) {
        page.push(completed(&service, job).await?);
    }
    let next_cursor = page.last().filter(|_| more).map(|last| last.id().to_owned());
    Ok(Json(JobPageBody { jobs: page, next_cursor }))
}

/// Look at a job
///
/// With `wait` the answer comes when the job has ended, or when the time is over.
#[utoipa::path(get, path = "/v1/jobs/{id}", tag = "jobs",
    params(WaitQuery, ("id" = String, Path, description = "The job"),
        ("If-None-Match" = Option<String>, Header, description = "The ETag that is known already")),
    responses(
        (status = 200, description = "The job", body = JobBody,
         headers(("ETag" = String, description = "Changes with every change of the job"))),
        (status = 304, description = "It is as it was"),
        (status = 400, description = "The query has a fault", body = ProblemBody, content_type = "application/problem+json"),
        (status = 404, description = "There is none", body = ProblemBody, content_type = "application/problem+json")))]
async fn get_job(
    State(service): State<Service>,
    path: JobPath,
    Query(query): Query<WaitQuery>,
    headers: HeaderMap,
) -> Answer<Response> {
    if query.wait > MOST_WAIT_S {
        return Err(Problem::new(ProblemCode::InvalidQuery).detail(format!("wait is at most {MOST_WAIT_S}")));
    }
    let job = wait_for(&service, &path.id, query.wait, &headers).await?;
    let etag = entity_tag(&job);
    if is_known(&headers, &etag) {
        return Ok((StatusCode::NOT_MODIFIED, [(header::ETAG, etag)]).into_response());
    }
    let body = completed(&service, job).await?;
    let headers = [(header::ETAG, etag), (header::CACHE_CONTROL, HeaderValue::from_static("no-cache"))];
    Ok((headers, Json(body)).into_response())
}

/// Waits until the job has ended or, for a client that knows a version of it, has changed.
async fn wait_for(service: &Service, id: &JobId, wait_s: u32, headers: &HeaderMap) -> Answer<Job> {
    let until = Instant::now() + Duration::from_secs(u64::from(wait_s));
    let mut follower = service.store().changes().follow();
    loop {
        let job = service.store().job(id).await.map_err(of_job)?;
        let changed = headers.contains_key(header::IF_NONE_MATCH) && !is_known(headers, &entity_tag(&job));
        if job.state.is_final() || changed || Instant::now() >= until || service.is_stopping() {
            return Ok(job);
        }
        let next_look = until.min(Instant::now() + LOOK_AGAIN);
        tokio::select! {
            _ = timeout_at(next_look, follower.hear_of(id)) => {}
            () = service.stopped() => {}
        }
    }
}

/// Fetch the document as it was posted, byte for byte
#[utoipa::path(get, path = "/v1/jobs/{id}/input", tag = "jobs",
    params(("id" = String, Path, description = "The job")),
    responses(
        (status = 200, description = "The document", body = ref("#/components/schemas/JobDocument"), content_type = "application/json"),
        (status = 404, description = "There is no such job", body = ProblemBody, content_type = "application/problem+json")))]
async fn get_input(State(service): State<Service>, path: JobPath) -> Answer<Response> {
    let body = service.store().job_input(&path.id).await.map_err(of_job)?;
    Ok(([(header::CONTENT_TYPE, "application/json")], body).into_response())
}

/// Fetch a file that came with a job, byte for byte
#[utoipa::path(get, path = "/v1/jobs/{id}/files/{name}", tag = "jobs",
    params(("id" = String, Path, description = "The job"),
        ("name" = String, Path, description = "The file, as the job lists it"),
        ("Range" = Option<String>, Header, description = "One range of bytes, to resume a transfer"),
        ("If-Range" = Option<String>, Header, description = "The ETag to which the range belongs"),
        ("If-None-Match" = Option<String>, Header, description = "The ETag that is known already")),
    responses(
        (status = 200, description = "The bytes", body = Vec<u8>, content_type = "application/octet-stream", headers(
            ("ETag" = String, description = "The SHA-256 in quotes"),
            ("Repr-Digest" = String, description = "The SHA-256 of the whole as RFC 9530 writes it"),
            ("Content-Disposition" = String, description = "The name to save it under"))),
        (status = 206, description = "The range", body = Vec<u8>, content_type = "application/octet-stream"),
        (status = 304, description = "It is as it was"),
        (status = 404, description = "There is no such job or file", body = ProblemBody, content_type = "application/problem+json"),
        (status = 416, description = "The range lies outside", body = ProblemBody, content_type = "application/problem+json")))]
async fn get_job_file(State(service): State<Service>, path: JobPath, headers: HeaderMap) -> Answer<Response> {
    match service.store().job_file(&path.id, &path.name).await {
        // Whatever the sender says that it is, a browser shows nothing of it.
        Ok(bytes) => deliver(&headers, bytes, &path.name, "application/octet-stream"),
        Err(Error::NotFound) => {
            service.store().job(&path.id).await.map_err(of_job)?;
            Err(Problem::new(ProblemCode::FileNotFound))
        }
        Err(other) => Err(other.into()),
    }
}

/// Fetch the report of a job that has succeeded
#[utoipa::path(get, path = "/v1/jobs/{id}/report", tag = "jobs",
    params(("id" = String, Path, description = "The job")),
    responses(
        (status = 200, description = "report.json: findings, figures, hashes", body = Object, content_type = "application/json"),
        (status = 404, description = "There is no such job", body = ProblemBody, content_type = "application/problem+json"),
        (status = 409, description = "There is no report, or not yet", body = ProblemBody, content_type = "application/problem+json")))]
async fn get_report(State(service): State<Service>, path: JobPath) -> Answer<Response> {
    match service.store().report(&path.id).await {
        Ok(body) => Ok(([(header::CONTENT_TYPE, "application/json")], body).into_response()),
        Err(Error::NotFound) => Err(without_result(&service, &path.id, ProblemCode::NoReport).await),
        Err(other) => Err(other.into()),
    }
}

/// Fetch a drawing, or a text that goes with the report, of a job that has succeeded
#[utoipa::path(get, path = "/v1/jobs/{id}/drawings/{name}", tag = "jobs",
    params(("id" = String, Path, description = "The job"),
        ("name" = String, Path, description = "The drawing, as the job lists it")),
    responses(
        (status = 200, description = "The drawing as SVG; curves as text/csv, other texts as text/plain", body = String, content_type = "image/svg+xml"),
        (status = 404, description = "There is no such job or drawing", body = ProblemBody, content_type = "application/problem+json"),
        (status = 409, description = "Not yet", body = ProblemBody, content_type = "application/problem+json")))]
async fn get_drawing(State(service): State<Service>, path: JobPath) -> Answer<Response> {
    match service.store().drawing(&path.id, &path.name).await {
        Ok(body) => {
            // A drawing opened by itself in a browser runs nothing and loads nothing.
            let policy = "default-src 'none'; style-src 'unsafe-inline'; sandbox";
            let media = media_of(&path.name);
            let headers = [(header::CONTENT_TYPE, media), (header::CONTENT_SECURITY_POLICY, policy)];
            Ok((headers, body).into_response())
        }
        Err(Error::NotFound) => Err(without_result(&service, &path.id, ProblemCode::DrawingNotFound).await),
        Err(other) => Err(other.into()),
    }
}

fn media_of(name: &str) -> &'static str {
    match name.rsplit('.').next() {
        Some("svg") => "image/svg+xml",
        Some("csv") => "text/csv; charset=utf-8",
        _ => "text/plain; charset=utf-8",
    }
}

/// Cancel a job
///
/// A waiting job is taken out of the queue, a running attempt is ended at once. A job that was cancelled already
/// stays so.
#[utoipa::path(put, path = "/v1/jobs/{id}/cancellation", tag = "jobs",
    params(("id" = String, Path, description = "The job")),
    request_body(content = Option<CancellationRequest>, description = "Why; may be left out"),
    responses(
        (status = 200, description = "The job, cancelled", body = JobBody),
        (status = 400, description = "The body is not JSON", body = ProblemBody, content_type = "application/problem+json"),
        (status = 404, description = "There is no such job", body = ProblemBody, content_type = "application/problem+json"),
        (status = 409, description = "It has ended", body = ProblemBody, content_type = "application/problem+json"),
        (status = 422, description = "The body has a fault", body = ProblemBody, content_type = "application/problem+json")))]
async fn cancel_job(
    State(service): State<Service>,
    caller: Caller,
    path: JobPath,
    OptionalBody(request): OptionalBody<CancellationRequest>,
) -> Answer<Json<JobBody>> {
    let reason = cancellation_reason(request)?;
    let job = service.store().cancel(&path.id, &caller.actor, reason, clock::now()).await.map_err(of_job)?;
    Ok(Json(completed(&service, job).await?))
}

fn cancellation_reason(request: Option<CancellationRequest>) -> Answer<Option<String>> {
    match request.and_then(|request| request.reason) {
        Some(reason) if reason.chars().count() > LONGEST_REASON => {
            Err(Problem::new(ProblemCode::InvalidRequest)
                .detail(format!("reason has at most {LONGEST_REASON} characters")))
        }
        reason => Ok(reason),
    }
}

/// A job with its files and the names of its drawings.
async fn completed(service: &Service, job: Job) -> Answer<JobBody> {
    let drawings = match job.state {
        JobState::Succeeded { .. } => service.store().drawing_names(&job.id).await?,
        _ => Vec::new(),
    };
    let files = service.store().job_files(&job.id).await?;
    Ok(JobBody::new(job, drawings, files))
}

/// Why a job has not what was asked for; `never` if it has ended.
async fn without_result(service: &Service, id: &JobId, never: ProblemCode) -> Problem {
    match service.store().job(id).await {
        Ok(job) if job.state.is_final() => Problem::new(never),
        Ok(job) => Problem::new(ProblemCode::NotReady).detail(format!("the job is {}", job.state.word())),
        Err(error) => of_job(error),
    }
}

fn is_known(headers: &HeaderMap, etag: &HeaderValue) -> bool {
    let known = headers.get(header::IF_NONE_MATCH).and_then(|known| known.to_str().ok());
    known.zip(etag.to_str().ok()).is_some_and(|(known, etag)| matches_tag(known, etag))
}

fn job_filter(query: ListQuery) -> Answer<JobFilter> {
    let fault = |detail: &str| Problem::new(ProblemCode::InvalidQuery).detail(detail);
    if query.state.as_deref().is_some_and(|state| !JobState::WORDS.contains(&state)) {
        return Err(fault("state is one of queued, running, succeeded, failed, cancelled"));
    }
    let reference = match query.reference.as_deref().map(|reference| reference.split_once(':')) {
        Some(None) => return Err(fault("reference is NAME:VALUE")),
        Some(Some((name, value))) => Some((name.to_owned(), value.to_owned())),
        None => None,
    };
    let before = match query.cursor.map(|cursor| cursor.parse()) {
        Some(Err(_)) => return Err(fault("cursor is the next_cursor of another page")),
        Some(Ok(id)) => Some(id),
        None => None,
    };
    let limit = page_limit(query.limit)?;
    Ok(JobFilter { state: query.state, kind: query.kind, reference, before, limit })
}

/// How many items a page has.
pub(super) fn page_limit(asked: Option<i64>) -> Answer<i64> {
    match asked.unwrap_or(PAGE) {
        limit @ 1..=LARGEST_PAGE => Ok(limit),
        _ => Err(Problem::new(ProblemCode::InvalidQuery).detail(format!("limit is 1 to {LARGEST_PAGE}"))),
    }
}
