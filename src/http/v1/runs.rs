//! Runs: looking at them and fetching their programs. Claiming is in [`super::claims`], what machines and people
//! say about them in [`super::reports`].

use axum::Json;
use axum::extract::State;
use axum::http::HeaderMap;
use axum::response::Response;
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use super::jobs::page_limit;
use super::programs::deliver;
use super::wire::{PurposeWord, program_address};
use crate::clock;
use crate::http::caller::Caller;
use crate::http::extract::{Path, Query};
use crate::http::problem::{Answer, Problem, ProblemBody, ProblemCode, of_run};
use crate::http::service::Service;
use crate::job::id::RunId;
use crate::job::moment::Moment;
use crate::job::purpose::Purpose;
use crate::job::run::{How, Resolution, Run, RunState};
use crate::store::runs::RunFilter;

/// The addresses.
#[must_use]
pub fn routes() -> OpenApiRouter<Service> {
    OpenApiRouter::new().routes(routes!(list_runs)).routes(routes!(get_run)).routes(routes!(get_run_content))
}

/// The query of a list of runs.
#[derive(Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
struct ListQuery {
    /// Of this machine.
    machine: Option<String>,
    /// Of this entry.
    entry: Option<String>,
    /// Of this program.
    program: Option<String>,
    /// offered, received, running, suspect, done, failed or aborted.
    state: Option<String>,
    /// Where the page begins: the `next_cursor` of the page before.
    cursor: Option<String>,
    /// How many at most, 1 to 200; 50 if left out.
    limit: Option<i64>,
}

/// The query of a fetch.
#[derive(Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
struct FenceQuery {
    /// The run's fence.
    fence: i64,
}

/// One machine doing one unit of one entry
#[derive(Debug, Serialize, ToSchema)]
#[schema(as = Run)]
pub struct RunBody {
    /// Its id.
    #[schema(example = "run_0198c2a41b2c7d3e8f9a0b1c2d3e4f50")]
    id: String,
    /// offered, received, running, suspect, done, failed or aborted.
    #[schema(value_type = String, example = "offered")]
    state: RunState,
    /// What every report of the machine carries. It rises when a person resolves the run.
    fence: i64,
    /// The machine.
    machine: String,
    /// The machine's own name for its claim.
    request_id: String,
    /// The entry.
    entry: String,
    /// The number of the unit within the entry, from 1.
    unit: i64,
    /// The program.
    program: String,
    /// What the program is for: production, dry_run or restart.
    #[schema(value_type = PurposeWord)]
    purpose: Purpose,
    /// The course from which on the program goes, if not from the start.
    #[serde(skip_serializing_if = "Option::is_none")]
    from_course: Option<u32>,
    /// The ply whose course that is, on a roll of several.
    #[serde(skip_serializing_if = "Option::is_none")]
    from_ply: Option<u32>,
    /// The SHA-256 of the program's content, which the receipt names.
    sha256: String,
    /// The length of the program's content, which the receipt names.
    size: i64,
    /// Whether the unit has gone back to its entry.
    returned: bool,
    /// Whether a person must say what becomes of the unit: PUT resolution.
    needs_resolution: bool,
    /// A machine that is silent until then makes its run suspect.
    #[schema(format = DateTime)]
    lease_until: String,
    /// When it was offered.
    #[schema(format = DateTime)]
    created_at: String,
    /// When the machine had the right bytes.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(format = DateTime)]
    received_at: Option<String>,
    /// When the machine began to cut.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(format = DateTime)]
    started_at: Option<String>,
    /// Since when it is suspect.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(format = DateTime)]
    suspect_since: Option<String>,
    /// When it ended.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(format = DateTime)]
    finished_at: Option<String>,
    /// Why it ended so, if the machine said.
    #[serde(skip_serializing_if = "Option::is_none")]
    reason: Option<String>,
    /// The lot of the prepreg.
    #[serde(skip_serializing_if = "Option::is_none")]
    prepreg_lot: Option<String>,
    /// The spool.
    #[serde(skip_serializing_if = "Option::is_none")]
    spool: Option<String>,
    /// The cassette that the pieces went into.
    #[serde(skip_serializing_if = "Option::is_none")]
    cassette: Option<String>,
    /// What a person has decided.
    #[serde(skip_serializing_if = "Option::is_none")]
    resolution: Option<ResolutionBody>,
    /// Where to go next.
    links: RunLinks,
}

/// What a person has decided about a run
#[derive(Debug, Serialize, ToSchema)]
#[schema(as = Resolution)]
pub struct ResolutionBody {
    /// requeue, scrap or was_done.
    #[schema(value_type = String, example = "requeue")]
    how: How,
    /// Who.
    by: String,
    /// Why.
    reason: String,
    /// When.
    #[schema(format = DateTime)]
    at: String,
}

/// Where to go from a run
#[derive(Debug, Serialize, ToSchema)]
pub struct RunLinks {
    /// The run itself; receipt, start, heartbeat, result and resolution lie below it.
    #[serde(rename = "self")]
    itself: String,
    /// The bytes to cut; there until the run has ended.
    #[serde(skip_serializing_if = "Option::is_none")]
    content: Option<String>,
    /// The program.
    program: String,
}

/// A page of runs, the newest first
#[derive(Debug, Serialize, ToSchema)]
#[schema(as = RunPage)]
pub struct RunPageBody {
    /// The runs.
    runs: Vec<RunBody>,
    /// What to give as `cursor` for the next page; not there on the last.
    #[serde(skip_serializing_if = "Option::is_none")]
    next_cursor: Option<String>,
}

impl From<Run> for RunBody {
    fn from(run: Run) -> Self {
        let text = |moment: Moment| moment.to_string();
        let itself = run_address(&run.id);
        let content = run.state.is_live().then(|| format!("{itself}/content?fence={}", run.fence));
        let needs_resolution = run.waits_for_a_person();
        let course = run.course;
        Self {
            links: RunLinks { itself, content, program: program_address(&run.program) },
            id: run.id.to_string(),
            state: run.state,
            fence: run.fence,
            machine: run.machine,
            request_id: run.request_id,
            entry: run.entry.to_string(),
            unit: run.unit,
            program: run.program.to_string(),
            purpose: run.purpose,
            from_course: run.purpose.from_course(),
            from_ply: run.purpose.from_ply(),
            sha256: run.sha256,
            size: run.bytes,
            returned: run.returned,
            needs_resolution,
            lease_until: run.lease_until.to_string(),
            created_at: run.created_at.to_string(),
            received_at: course.received_at.map(text),
            started_at: course.started_at.map(text),
            suspect_since: course.suspect_since.map(text),
            finished_at: course.finished_at.map(text),
            reason: course.reason,
            prepreg_lot: course.material.prepreg_lot,
            spool: course.material.spool,
            cassette: course.material.cassette,
            resolution: course.resolution.map(ResolutionBody::from),
        }
    }
}

impl From<Resolution> for ResolutionBody {
    fn from(resolution: Resolution) -> Self {
        let Resolution { how, by, reason, at } = resolution;
        Self { how, by, reason, at: at.to_string() }
    }
}

/// List runs, the newest first
///
/// `state=suspect` are those that a person must look at.
#[utoipa::path(get, path = "/v1/runs", tag = "shop floor", params(ListQuery), responses(
    (status = 200, description = "A page of runs", body = RunPageBody),
    (status = 400, description = "The query has a fault", body = ProblemBody, content_type = "application/problem+json")))]
async fn list_runs(
    State(service): State<Service>,
    Query(query): Query<ListQuery>,
) -> Answer<Json<RunPageBody>> {
    let filter = run_filter(query)?;
    let limit = filter.limit;
    let mut runs = service.store().runs(&RunFilter { limit: limit + 1, ..filter }).await?;
    let more = runs.len() as i64 > limit;
    runs.truncate(usize::try_from(limit).unwrap_or_default());
    let next_cursor = runs.last().filter(|_| more).map(|last| last.id.to_string());
    Ok(Json(RunPageBody { runs: runs.into_iter().map(RunBody::from).collect(), next_cursor }))
}

/// Look at a run
#[utoipa::path(get, path = "/v1/runs/{r}", tag = "shop floor",
    params(("r" = String, Path, description = "The run")),
    responses(
        (status = 200, description = "The run", body = RunBody),
        (status = 403, description = "It is another machine's", body = ProblemBody, content_type = "application/problem+json"),
        (status = 404, description = "There is none", body = ProblemBody, content_type = "application/problem+json")))]
async fn get_run(
    State(service): State<Service>,
    caller: Caller,
    Path(run): Path<String>,
) -> Answer<Json<RunBody>> {
    Ok(Json(own_run(&service, &caller, &run).await?.into()))
}

/// Fetch the bytes to cut
///
/// Only those of an approved program that fit their hash. A transfer that was cut off is resumed with Range and
/// If-Range.
#[utoipa::path(get, path = "/v1/runs/{r}/content", tag = "shop floor",
    params(FenceQuery, ("r" = String, Path, description = "The run"),
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
        (status = 403, description = "It is another machine's", body = ProblemBody, content_type = "application/problem+json"),
        (status = 404, description = "There is no such run", body = ProblemBody, content_type = "application/problem+json"),
        (status = 409, description = "Another fence, a run that has ended, or a program that is not approved or quarantined", body = ProblemBody, content_type = "application/problem+json"),
        (status = 416, description = "The range lies outside", body = ProblemBody, content_type = "application/problem+json")))]
async fn get_run_content(
    State(service): State<Service>,
    caller: Caller,
    Path(run): Path<String>,
    Query(query): Query<FenceQuery>,
    headers: HeaderMap,
) -> Answer<Response> {
    let run = own_run(&service, &caller, &run).await?;
    let found = service.store().run_content(&run.id, query.fence, clock::now()).await;
    let (program, bytes) = found.map_err(of_run)?;
    deliver(&headers, bytes, &program.content_name, &program.media_type)
}

/// A run that the caller may touch: a machine its own ones only.
pub(super) async fn own_run(service: &Service, caller: &Caller, id: &str) -> Answer<Run> {
    let id: RunId = id.parse().map_err(|_| Problem::new(ProblemCode::RunNotFound))?;
    let run = service.store().run(&id).await.map_err(of_run)?;
    caller.speaks_for(&run.machine)?;
    Ok(run)
}

/// The address of a run.
pub(super) fn run_address(id: &RunId) -> String {
    format!("/v1/runs/{id}")
}

fn run_filter(query: ListQuery) -> Answer<RunFilter> {
    let fault = |detail: &str| Problem::new(ProblemCode::InvalidQuery).detail(detail);
    if query.state.as_deref().is_some_and(|state| !RunState::WORDS.contains(&state)) {
        return Err(fault("state is one of offered, received, running, suspect, done, failed, aborted"));
    }
    let entry = query.entry.map(|id| id.parse()).transpose();
    let program = query.program.map(|id| id.parse()).transpose();
    let before = query.cursor.map(|id| id.parse()).transpose();
    Ok(RunFilter {
        machine: query.machine,
        entry: entry.map_err(|_| fault("entry is the id of an entry"))?,
        program: program.map_err(|_| fault("program is the id of a program"))?,
        state: query.state,
        before: before.map_err(|_| fault("cursor is the next_cursor of another page"))?,
        limit: page_limit(query.limit)?,
    })
}
