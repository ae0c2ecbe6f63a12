//! Posting a job: bounded, checked, and once for each idempotency key.

use std::sync::Arc;

use axum::Json;
use axum::body::Body;
use axum::extract::State;
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::Deserialize;
use utoipa::IntoParams;

use super::wire::{JobBody, ValidationBody, job_address};
use crate::clock;
use crate::http::caller::Caller;
use crate::http::extract::{Query, form_type};
use crate::http::intake::Taken;
use crate::http::problem::{Answer, Problem, ProblemBody, ProblemCode};
use crate::http::service::Service;
use crate::job::id::JobId;
use crate::job::life::{Job, NewJob};
use crate::store::attempts::AttemptInput;
use crate::store::counters::REFUSED_POSTS;
use crate::store::files::JobFile;
use crate::store::jobs::{Post, Posted};
use crate::worker::checking::{Checked, Label, check, label};

/// The header of an idempotency key.
const IDEMPOTENCY_KEY: &str = "idempotency-key";

/// The longest idempotency key, in characters.
const LONGEST_KEY: usize = 255;

/// A small job is planned within a second or so.
const RETRY_AFTER_S: u32 = 1;

/// The query of a post.
#[derive(Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct PostQuery {
    /// Check the document and take nothing in.
    #[serde(default)]
    validate_only: bool,
}

/// Post a job
///
/// The same `Idempotency-Key` with the same bytes gives the same job, for as long as the job lives; a repeated
/// post is answered like the first one, with `Idempotency-Replayed: true`.
///
/// A document that names files is posted as `multipart/form-data`: one part named `job`, as `application/json`, and a
/// part for each file that it names. The same document and files are the same bytes, however the form wraps them.
#[utoipa::path(post, path = "/v1/jobs", tag = "jobs",
    params(PostQuery, ("Idempotency-Key" = Option<String>, Header,
        description = "A name for this post, at most 255 visible ASCII characters. A repeated post with the same key and bytes gives the same job.")),
    request_body(content = ref("#/components/schemas/JobDocument"), content_type = "application/json"),
    responses(
        (status = 202, description = "Taken in; it survives a power loss from now on", body = JobBody, headers(
            ("Location" = String, description = "The job's address"),
            ("Retry-After" = u32, description = "Seconds after which to look"),
            ("Idempotency-Replayed" = Option<String>, description = "true if an earlier post had made this job"))),
        (status = 200, description = "With validate_only: the document has no faults", body = ValidationBody),
        (status = 400, description = "Not JSON, no form of a job and its files, or a header or the query has a fault", body = ProblemBody, content_type = "application/problem+json"),
        (status = 403, description = "A page of another site sends a form", body = ProblemBody, content_type = "application/problem+json"),
        (status = 413, description = "Larger than the service takes", body = ProblemBody, content_type = "application/problem+json"),
        (status = 415, description = "Neither application/json nor multipart/form-data", body = ProblemBody, content_type = "application/problem+json"),
        (status = 422, description = "Every fault of the document, files that it names and that did not come among them; or the key was used with another body", body = ProblemBody, content_type = "application/problem+json"),
        (status = 429, description = "As many jobs wait as may wait", body = ProblemBody, content_type = "application/problem+json"),
        (status = 503, description = "No room, or ending", body = ProblemBody, content_type = "application/problem+json")))]
pub async fn post_job(
    State(service): State<Service>,
    caller: Caller,
    Query(query): Query<PostQuery>,
    headers: HeaderMap,
    body: Body,
) -> Answer<Response> {
    let answer = take_in(&service, &caller, query.validate_only, &headers, body).await;
    if let Err(problem) = &answer
        && problem.code() != ProblemCode::Internal
    {
        service.store().count(REFUSED_POSTS, &problem.word()).await?;
    }
    answer
}

async fn take_in(
    service: &Service,
    caller: &Caller,
    validate_only: bool,
    headers: &HeaderMap,
    body: Body,
) -> Answer<Response> {
    if service.is_stopping() {
        return Err(Problem::new(ProblemCode::Stopping));
    }
    let form = form_type(headers)?;
    let key = idempotency_key(headers)?;
    let taken = match form {
        Some(kind) => service.intake().take_form(kind, headers, body).await?,
        None => service.intake().take(headers, body).await?,
    };
    if let (Some(key), false) = (key, validate_only)
        && let Some(job) = service.store().posted_before(&caller.actor, key, &taken.job, &taken.files).await?
    {
        return accepted(service, Posted { job, replayed: true }).await;
    }
    let machines = service.machines().await?;
    let (body, files) = (Arc::clone(&taken.job), Arc::clone(&taken.files));
    let label =
        checked(service, AttemptInput { body, files, machines: machines.clone() }, validate_only).await?;
    if validate_only {
        return Ok(Json(ValidationBody { valid: true, kind: label.kind }).into_response());
    }
    let posted = post(service, caller, key, &taken, label, &machines).await?;
    accepted(service, posted).await
}

/// Checks a document. What the check cannot decide within its limits, the attempt does.
pub(super) async fn checked(service: &Service, input: AttemptInput, validate_only: bool) -> Answer<Label> {
    let _place = service.place_to_check().await?;
    let body = Arc::clone(&input.body);
    let found = check(service.config(), input).await;
    match found.map_err(Problem::internal)? {
        Checked::Sound(label) => Ok(label),
        Checked::Faulty(faults) => Err(Problem::refused(faults)),
        Checked::Undecided if validate_only => {
            Err(Problem::new(ProblemCode::Overloaded)
                .detail("the check met a limit; posting the job plans it"))
        }
        Checked::Undecided => label(&body).map_err(Problem::refused),
    }
}

async fn post(
    service: &Service,
    caller: &Caller,
    key: Option<&str>,
    taken: &Taken,
    label: Label,
    machines: &str,
) -> Answer<Posted> {
    let now = clock::now();
    let Label { kind, name, references } = label;
    let id = JobId::new(now, &clock::entropy());
    let post = Post {
        job: NewJob { id, kind, name, references, dry_run_of: None },
        body: &taken.job,
        files: &taken.files,
        machines,
        key,
        most_queued: i64::from(service.config().max_queued),
        actor: &caller.actor,
        now,
    };
    Ok(service.store().post(post).await?)
}

/// The answer to a post.
pub(super) async fn accepted(service: &Service, posted: Posted) -> Answer<Response> {
    let files = service.store().job_files(&posted.job.id).await?;
    Ok(acceptance(posted, files))
}

fn acceptance(posted: Posted, files: Vec<JobFile>) -> Response {
    let Posted { job, replayed } = posted;
    let location = job_address(&job.id);
    let etag = entity_tag(&job);
    let mut response = (StatusCode::ACCEPTED, Json(JobBody::new(job, Vec::new(), files))).into_response();
    let headers = response.headers_mut();
    headers.insert(header::RETRY_AFTER, HeaderValue::from(RETRY_AFTER_S));
    headers.insert(header::ETAG, etag);
    if let Ok(location) = HeaderValue::try_from(location) {
        headers.insert(header::LOCATION, location);
    }
    if replayed {
        headers.insert("idempotency-replayed", HeaderValue::from_static("true"));
    }
    response
}

/// The tag of a job's present representation.
pub(super) fn entity_tag(job: &Job) -> HeaderValue {
    HeaderValue::try_from(format!("\"{}\"", job.version)).expect("a number between quotes is a header value")
}

fn idempotency_key(headers: &HeaderMap) -> Answer<Option<&str>> {
    let Some(value) = headers.get(IDEMPOTENCY_KEY) else { return Ok(None) };
    let visible = |key: &&str| key.bytes().all(|byte| byte.is_ascii_graphic());
    match value.to_str().ok().filter(visible) {
        Some(key) if !key.is_empty() && key.len() <= LONGEST_KEY => Ok(Some(key)),
        _ => Err(Problem::new(ProblemCode::InvalidHeader)
            .detail(format!("Idempotency-Key: 1 to {LONGEST_KEY} visible ASCII characters without spaces"))),
    }
}
