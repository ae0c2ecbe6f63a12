//! Programs: looking at them and fetching their bytes.

use axum::Json;
use axum::extract::State;
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use serde::Deserialize;
use sha2::{Digest, Sha256};
use utoipa::IntoParams;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use super::jobs::page_limit;
use super::ranges::{Part, matches_tag, part};
use super::wire::{ProgramBody, ProgramPageBody};
use crate::clock;
use crate::http::extract::{ProgramPath, Query};
use crate::http::problem::{Answer, Problem, ProblemBody, ProblemCode, of_program};
use crate::http::service::Service;
use crate::store::Error;
use crate::store::programs::ProgramFilter;

/// The addresses.
#[must_use]
pub fn routes() -> OpenApiRouter<Service> {
    OpenApiRouter::new()
        .routes(routes!(list_programs))
        .routes(routes!(get_program))
        .routes(routes!(get_content))
        .routes(routes!(get_file))
}

/// Every state of a program.
const STATES: [&str; 5] = ["draft", "approved", "superseded", "revoked", "quarantined"];

/// The query of a list of programs.
#[derive(Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
struct ListQuery {
    /// draft, approved, superseded, revoked or quarantined.
    #[param(pattern = "^(draft|approved|superseded|revoked|quarantined)$")]
    state: Option<String>,
    /// The job that gave it.
    #[param(pattern = "^job_[0-9a-f]{32}$")]
    job: Option<String>,
    /// The SHA-256 of its content.
    sha256: Option<String>,
    /// Where the page begins: the `next_cursor` of the page before.
    #[param(pattern = "^prg_[0-9a-f]{32}$")]
    cursor: Option<String>,
    /// How many at most, 1 to 200; 50 if left out.
    #[param(minimum = 1, maximum = 200)]
    limit: Option<i64>,
}

/// List programs, the newest first
#[utoipa::path(get, path = "/v1/programs", tag = "programs", params(ListQuery), responses(
    (status = 200, description = "A page of programs", body = ProgramPageBody),
    (status = 400, description = "The query has a fault", body = ProblemBody, content_type = "application/problem+json")))]
async fn list_programs(
    State(service): State<Service>,
    Query(query): Query<ListQuery>,
) -> Answer<Json<ProgramPageBody>> {
    let filter = program_filter(query)?;
    let limit = filter.limit;
    let mut programs = service.store().programs(&ProgramFilter { limit: limit + 1, ..filter }).await?;
    let more = programs.len() as i64 > limit;
    programs.truncate(usize::try_from(limit).unwrap_or_default());
    let next_cursor = programs.last().filter(|_| more).map(|last| last.id.to_string());
    let programs = programs.into_iter().map(ProgramBody::from).collect();
    Ok(Json(ProgramPageBody { programs, next_cursor }))
}

/// Look at a program
#[utoipa::path(get, path = "/v1/programs/{id}", tag = "programs",
    params(("id" = String, Path, description = "The program")),
    responses(
        (status = 200, description = "The program", body = ProgramBody),
        (status = 404, description = "There is none", body = ProblemBody, content_type = "application/problem+json")))]
async fn get_program(State(service): State<Service>, path: ProgramPath) -> Answer<Json<ProgramBody>> {
    let program = service.store().program(&path.id).await.map_err(of_program)?;
    Ok(Json(program.into()))
}

/// Fetch the bytes of a program
///
/// The single file, or an archive of all files. The bytes are compared with the hash they were stored with before
/// any of them is sent; a program that does not fit its hash any more is quarantined.
#[utoipa::path(get, path = "/v1/programs/{id}/content", tag = "programs",
    params(("id" = String, Path, description = "The program"),
        ("Range" = Option<String>, Header, description = "One range of bytes, to resume a transfer"),
        ("If-Range" = Option<String>, Header, description = "The ETag to which the range belongs"),
        ("If-None-Match" = Option<String>, Header, description = "The ETag that is known already")),
    responses(
        (status = 200, description = "The bytes: of the one file, or a ZIP of all", content((Vec<u8> = "text/plain"), (Vec<u8> = "application/zip")), headers(
            ("ETag" = String, description = "The SHA-256 in quotes"),
            ("Repr-Digest" = String, description = "The SHA-256 of the whole as RFC 9530 writes it"),
            ("Content-Disposition" = String, description = "The name to save it under"))),
        (status = 206, description = "The range", body = Vec<u8>, content_type = "text/plain"),
        (status = 304, description = "It is as it was"),
        (status = 404, description = "There is no such program", body = ProblemBody, content_type = "application/problem+json"),
        (status = 409, description = "It is quarantined", body = ProblemBody, content_type = "application/problem+json"),
        (status = 416, description = "The range lies outside", body = ProblemBody, content_type = "application/problem+json")))]
async fn get_content(
    State(service): State<Service>,
    path: ProgramPath,
    headers: HeaderMap,
) -> Answer<Response> {
    let program = service.store().program(&path.id).await.map_err(of_program)?;
    if program.state == "quarantined" {
        return Err(Problem::new(ProblemCode::ProgramQuarantined));
    }
    let bytes = service.store().program_content(&program, clock::now()).await.map_err(of_program)?;
    deliver(&headers, bytes, &program.content_name, &program.media_type)
}

/// Fetch one file of a program
#[utoipa::path(get, path = "/v1/programs/{id}/files/{name}", tag = "programs",
    params(("id" = String, Path, description = "The program"),
        ("name" = String, Path, description = "The file, as the program lists it"),
        ("Range" = Option<String>, Header, description = "One range of bytes, to resume a transfer"),
        ("If-Range" = Option<String>, Header, description = "The ETag to which the range belongs"),
        ("If-None-Match" = Option<String>, Header, description = "The ETag that is known already")),
    responses(
        (status = 200, description = "The bytes", body = Vec<u8>, content_type = "text/plain"),
        (status = 206, description = "The range", body = Vec<u8>, content_type = "text/plain"),
        (status = 304, description = "It is as it was"),
        (status = 404, description = "There is no such program or file", body = ProblemBody, content_type = "application/problem+json"),
        (status = 409, description = "It is quarantined", body = ProblemBody, content_type = "application/problem+json"),
        (status = 416, description = "The range lies outside", body = ProblemBody, content_type = "application/problem+json")))]
async fn get_file(State(service): State<Service>, path: ProgramPath, headers: HeaderMap) -> Answer<Response> {
    let program = service.store().program(&path.id).await.map_err(of_program)?;
    if program.state == "quarantined" {
        return Err(Problem::new(ProblemCode::ProgramQuarantined));
    }
    match service.store().program_file(&program, &path.name, clock::now()).await {
        Ok(bytes) => deliver(&headers, bytes, &path.name, "text/plain; charset=us-ascii"),
        Err(Error::NotFound) => Err(Problem::new(ProblemCode::FileNotFound)),
        Err(other) => Err(of_program(other)),
    }
}

/// Answers with verified bytes, or the part of them that is asked for.
pub(super) fn deliver(headers: &HeaderMap, bytes: Vec<u8>, name: &str, media_type: &str) -> Answer<Response> {
    let digest = Sha256::digest(&bytes);
    let etag = format!("\"{digest:x}\"");
    let known = headers.get(header::IF_NONE_MATCH).and_then(|known| known.to_str().ok());
    let length = bytes.len();
    let mut response = if known.is_some_and(|known| matches_tag(known, &etag)) {
        StatusCode::NOT_MODIFIED.into_response()
    } else {
        match part(headers, &etag, length) {
            Part::Whole => bytes.into_response(),
            Part::Outside => return Err(Problem::outside(length)),
            Part::Range { first, last } => {
                let range = format!("bytes {first}-{last}/{length}");
                let part = bytes[first..=last].to_vec();
                (StatusCode::PARTIAL_CONTENT, [(header::CONTENT_RANGE, range)], part).into_response()
            }
        }
    };
    describe(&mut response, &etag, &digest, name, media_type)?;
    Ok(response)
}

fn describe(response: &mut Response, etag: &str, digest: &[u8], name: &str, media_type: &str) -> Answer<()> {
    let fields = [
        ("content-type", media_type.to_owned()),
        ("etag", etag.to_owned()),
        ("repr-digest", format!("sha-256=:{}:", BASE64_STANDARD.encode(digest))),
        ("content-disposition", format!("attachment; filename=\"{name}\"")),
        ("accept-ranges", "bytes".to_owned()),
        ("cache-control", "private, no-cache".to_owned()),
    ];
    for (field, text) in fields {
        response.headers_mut().insert(field, HeaderValue::try_from(text).map_err(Problem::internal)?);
    }
    Ok(())
}

fn program_filter(query: ListQuery) -> Answer<ProgramFilter> {
    let fault = |detail: &str| Problem::new(ProblemCode::InvalidQuery).detail(detail);
    if query.state.as_deref().is_some_and(|state| !STATES.contains(&state)) {
        return Err(fault("state is one of draft, approved, superseded, revoked, quarantined"));
    }
    let job = query.job.map(|job| job.parse()).transpose().map_err(|_| fault("job is the id of a job"))?;
    let before = query
        .cursor
        .map(|cursor| cursor.parse())
        .transpose()
        .map_err(|_| fault("cursor is the next_cursor of another page"))?;
    let limit = page_limit(query.limit)?;
    Ok(ProgramFilter { state: query.state, job, sha256: query.sha256, before, limit })
}
