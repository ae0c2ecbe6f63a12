//! Entries: programs that wait in the queues of machines and pools.

use axum::Json;
use axum::extract::State;
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use super::jobs::page_limit;
use super::wire::{PurposeWord, program_address};
use crate::clock;
use crate::http::caller::Caller;
use crate::http::extract::{Body, Path, Query};
use crate::http::problem::{Answer, Problem, ProblemBody, ProblemCode, of_entry};
use crate::http::service::Service;
use crate::job::entry::{Entry, EntryState, MOST_UNITS};
use crate::job::id::{EntryId, ProgramId};
use crate::job::purpose::Purpose;
use crate::job::waiting::{WaitingFor, Wanted};
use crate::store::entries::{Enqueue, EntryFilter};

/// The addresses.
#[must_use]
pub fn routes() -> OpenApiRouter<Service> {
    OpenApiRouter::new().routes(routes!(post_entry, list_entries)).routes(routes!(
        get_entry,
        amend_entry,
        cancel_entry
    ))
}

/// Places lie within this on both sides of 0, so that there is always one before the first and behind the last.
const FARTHEST: i64 = 1_000_000_000;

/// A program to be queued
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
struct EntryRequest {
    /// The program.
    program: String,
    /// How many units, 1 to 10000.
    quantity: i64,
    /// Its place: the lowest comes first. The last, if left out.
    position: Option<i64>,
}

/// What is changed of an entry
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
struct AmendmentRequest {
    /// Its new place: the lowest comes first, the older one where two are the same.
    position: Option<i64>,
    /// How many units, 1 to 10000; not below a unit that was given out.
    quantity: Option<i64>,
}

/// The query of a list of entries.
#[derive(Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
struct ListQuery {
    /// queued, assigned, finished or cancelled.
    state: Option<String>,
    /// Where the page begins: the `next_cursor` of the page before.
    cursor: Option<String>,
    /// How many at most, 1 to 200; 50 if left out.
    limit: Option<i64>,
}

/// A program that waits in a queue
#[derive(Debug, Serialize, ToSchema)]
#[schema(as = Entry)]
pub struct EntryBody {
    /// Its id.
    #[schema(example = "ent_0198c2a41b2c7d3e8f9a0b1c2d3e4f50")]
    id: String,
    /// The queue: the name of a machine or of a pool.
    queue: String,
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
    /// queued, assigned, finished or cancelled.
    #[schema(value_type = String, example = "queued")]
    state: EntryState,
    /// Its place: the lowest comes first.
    position: i64,
    /// How many units are wanted.
    quantity: i64,
    /// What became of them so far.
    units: UnitsBody,
    /// Why it is given to no machine, if that is more than its turn.
    #[serde(skip_serializing_if = "Option::is_none")]
    waiting_for: Option<WaitingForBody>,
    /// When it was made.
    #[schema(format = DateTime)]
    created_at: String,
    /// Where to go next.
    links: EntryLinks,
}

/// What became of the units of an entry
#[derive(Debug, Serialize, ToSchema)]
#[schema(as = Units)]
pub struct UnitsBody {
    /// They wait.
    waiting: i64,
    /// They are at machines, or wait for a person's word.
    out: i64,
    /// Their runs are done.
    done: i64,
    /// Of those done, units of production: all of a production program, none of a dry run or of the rest of a roll.
    /// This is the number to add up over the entries of a work order.
    produced: i64,
    /// They are lost.
    scrapped: i64,
}

/// What an entry waits for beside its turn
#[derive(Debug, Serialize, ToSchema)]
#[schema(as = WaitingFor)]
pub struct WaitingForBody {
    /// approval, replacement (the program is dead), machine (none has its profile), release (a hold) or resolution (a
    /// suspect run).
    #[schema(value_type = String, example = "approval")]
    code: Wanted,
    /// The same for people, with what to do next.
    detail: String,
}

impl From<WaitingFor> for WaitingForBody {
    fn from(waiting: WaitingFor) -> Self {
        let WaitingFor { code, detail } = waiting;
        Self { code, detail }
    }
}

/// Where to go from an entry
#[derive(Debug, Serialize, ToSchema)]
pub struct EntryLinks {
    /// The entry itself.
    #[serde(rename = "self")]
    itself: String,
    /// Its program.
    program: String,
    /// Its runs.
    runs: String,
}

/// A page of entries, in the order of their queue
#[derive(Debug, Serialize, ToSchema)]
#[schema(as = EntryPage)]
pub struct EntryPageBody {
    /// The entries.
    entries: Vec<EntryBody>,
    /// What to give as `cursor` for the next page; not there on the last.
    #[serde(skip_serializing_if = "Option::is_none")]
    next_cursor: Option<String>,
}

impl EntryBody {
    /// An entry with what it waits for.
    #[must_use]
    pub fn new(entry: Entry, waiting_for: Option<WaitingFor>) -> Self {
        let (units, produced) = (entry.units, entry.produced());
        let waiting = match entry.state {
            EntryState::Cancelled => 0,
            _ => entry.quantity - units.given,
        };
        let out = units.given - units.done - units.scrapped;
        Self {
            links: EntryLinks {
                itself: entry_address(&entry),
                program: program_address(&entry.program),
                runs: format!("/v1/runs?entry={}", entry.id),
            },
            id: entry.id.to_string(),
            queue: entry.queue,
            program: entry.program.to_string(),
            purpose: entry.purpose,
            from_course: entry.purpose.from_course(),
            from_ply: entry.purpose.from_ply(),
            state: entry.state,
            position: entry.position,
            quantity: entry.quantity,
            units: UnitsBody { waiting, out, done: units.done, produced, scrapped: units.scrapped },
            waiting_for: waiting_for.map(WaitingForBody::from),
            created_at: entry.created_at.to_string(),
        }
    }
}

/// Put a program into the queue of a machine or a pool
///
/// A draft may wait there for its approval; machines are given approved programs only.
#[utoipa::path(post, path = "/v1/queues/{q}/entries", tag = "shop floor", request_body = EntryRequest,
    params(("q" = String, Path, description = "The name of a machine or of a pool")),
    responses(
        (status = 201, description = "It waits", body = EntryBody, headers(("Location" = String, description = "The entry's address"))),
        (status = 404, description = "There is no such program, or no machine or pool of that name", body = ProblemBody, content_type = "application/problem+json"),
        (status = 409, description = "The program is superseded, revoked or quarantined", body = ProblemBody, content_type = "application/problem+json"),
        (status = 422, description = "The body has a fault", body = ProblemBody, content_type = "application/problem+json")))]
async fn post_entry(
    State(service): State<Service>,
    caller: Caller,
    Path(queue): Path<String>,
    Body(request): Body<EntryRequest>,
) -> Answer<Response> {
    refuse_far(request.position)?;
    let program: ProgramId =
        request.program.parse().map_err(|_| Problem::new(ProblemCode::ProgramNotFound))?;
    let now = clock::now();
    let (quantity, position) = (request.quantity, request.position);
    let id = EntryId::new(now, &clock::entropy());
    let new = Enqueue { id, queue: &queue, program, position, quantity, actor: &caller.actor, now };
    let entry = service.store().enqueue(new).await?;
    let location = [(header::LOCATION, entry_address(&entry))];
    Ok((StatusCode::CREATED, location, Json(shown(&service, entry).await?)).into_response())
}

/// List the entries of a queue, in its order
#[utoipa::path(get, path = "/v1/queues/{q}/entries", tag = "shop floor",
    params(ListQuery, ("q" = String, Path, description = "The name of a machine or of a pool")),
    responses(
        (status = 200, description = "A page of entries", body = EntryPageBody),
        (status = 400, description = "The query has a fault", body = ProblemBody, content_type = "application/problem+json")))]
async fn list_entries(
    State(service): State<Service>,
    Path(queue): Path<String>,
    Query(query): Query<ListQuery>,
) -> Answer<Json<EntryPageBody>> {
    let fault = |detail: &str| Problem::new(ProblemCode::InvalidQuery).detail(detail);
    if query.state.as_deref().is_some_and(|state| !EntryState::WORDS.contains(&state)) {
        return Err(fault("state is one of queued, assigned, finished, cancelled"));
    }
    let after = query.cursor.map(|cursor| cursor.parse()).transpose();
    let after = after.map_err(|_| fault("cursor is the next_cursor of another page"))?;
    let limit = page_limit(query.limit)?;
    let filter = EntryFilter { queue, state: query.state, after, limit: limit + 1 };
    let mut entries = service.store().entries(&filter).await?;
    let more = entries.len() as i64 > limit;
    entries.truncate(usize::try_from(limit).unwrap_or_default());
    let next_cursor = entries.last().filter(|_| more).map(|last| last.id.to_string());
    let mut page = Vec::with_capacity(entries.len());
    for entry in entries {
        page.push(shown(&service, entry).await?);
    }
    Ok(Json(EntryPageBody { entries: page, next_cursor }))
}

/// Look at an entry
#[utoipa::path(get, path = "/v1/queues/{q}/entries/{id}", tag = "shop floor",
    params(("q" = String, Path, description = "The queue"), ("id" = String, Path, description = "The entry")),
    responses(
        (status = 200, description = "The entry", body = EntryBody),
        (status = 404, description = "There is none in this queue", body = ProblemBody, content_type = "application/problem+json")))]
async fn get_entry(
    State(service): State<Service>,
    Path(path): Path<(String, String)>,
) -> Answer<Json<EntryBody>> {
    let entry = named(&service, &path).await?;
    Ok(Json(shown(&service, entry).await?))
}

/// Change the place or the quantity of an entry
#[utoipa::path(patch, path = "/v1/queues/{q}/entries/{id}", tag = "shop floor", request_body = AmendmentRequest,
    params(("q" = String, Path, description = "The queue"), ("id" = String, Path, description = "The entry")),
    responses(
        (status = 200, description = "The entry", body = EntryBody),
        (status = 404, description = "There is none in this queue", body = ProblemBody, content_type = "application/problem+json"),
        (status = 409, description = "It is finished or cancelled, or more units were given out", body = ProblemBody, content_type = "application/problem+json"),
        (status = 422, description = "The body has a fault", body = ProblemBody, content_type = "application/problem+json")))]
async fn amend_entry(
    State(service): State<Service>,
    caller: Caller,
    Path(path): Path<(String, String)>,
    Body(request): Body<AmendmentRequest>,
) -> Answer<Json<EntryBody>> {
    refuse_far(request.position)?;
    let entry = named(&service, &path).await?;
    let (position, quantity) = (request.position, request.quantity);
    let amended =
        service.store().amend_entry(&entry.id, position, quantity, &caller.actor, clock::now()).await;
    Ok(Json(shown(&service, amended.map_err(of_entry)?).await?))
}

/// Cancel an entry
///
/// It gives nothing out any more; runs that it has given out go on. An entry that was cancelled already stays so.
#[utoipa::path(delete, path = "/v1/queues/{q}/entries/{id}", tag = "shop floor",
    params(("q" = String, Path, description = "The queue"), ("id" = String, Path, description = "The entry")),
    responses(
        (status = 200, description = "The entry, cancelled", body = EntryBody),
        (status = 404, description = "There is none in this queue", body = ProblemBody, content_type = "application/problem+json"),
        (status = 409, description = "It is finished", body = ProblemBody, content_type = "application/problem+json")))]
async fn cancel_entry(
    State(service): State<Service>,
    caller: Caller,
    Path(path): Path<(String, String)>,
) -> Answer<Json<EntryBody>> {
    let entry = named(&service, &path).await?;
    let cancelled = service.store().cancel_entry(&entry.id, &caller.actor, clock::now()).await;
    Ok(Json(shown(&service, cancelled.map_err(of_entry)?).await?))
}

/// An entry with what it waits for.
async fn shown(service: &Service, entry: Entry) -> Answer<EntryBody> {
    let waiting_for = service.store().waiting_for(&entry).await?;
    Ok(EntryBody::new(entry, waiting_for))
}

/// The entry of an address: in the queue that the address names, or nowhere.
async fn named(service: &Service, (queue, id): &(String, String)) -> Answer<Entry> {
    let unknown = || Problem::new(ProblemCode::EntryNotFound);
    let id: EntryId = id.parse().map_err(|_| unknown())?;
    let entry = service.store().entry(&id).await.map_err(of_entry)?;
    if entry.queue == *queue { Ok(entry) } else { Err(unknown()) }
}

fn refuse_far(position: Option<i64>) -> Answer<()> {
    if position.is_none_or(|position| (-FARTHEST..=FARTHEST).contains(&position)) {
        return Ok(());
    }
    let detail = format!("position is -{FARTHEST} to {FARTHEST}, quantity 1 to {MOST_UNITS}");
    Err(Problem::new(ProblemCode::InvalidRequest).detail(detail))
}

/// The address of an entry. Names of queues need no escaping: machines and pools have plain names.
fn entry_address(entry: &Entry) -> String {
    format!("/v1/queues/{}/entries/{}", entry.queue, entry.id)
}
