//! Machines: their profiles and holds.

use axum::Json;
use axum::extract::State;
use axum::http::StatusCode;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use crate::clock;
use crate::http::caller::Caller;
use crate::http::extract::{Body, Path};
use crate::http::problem::{Answer, Problem, ProblemBody, ProblemCode};
use crate::http::service::Service;
use crate::planning::catalogue::{Catalogue, PROFILE, Profile};
use crate::planning::document;
use crate::planning::finding::Finding;
use crate::store::Error;
use crate::store::machines::{Machine, MachineChange};

/// The addresses.
#[must_use]
pub fn routes() -> OpenApiRouter<Service> {
    OpenApiRouter::new()
        .routes(routes!(register_machine, list_machines))
        .routes(routes!(get_machine, change_machine))
        .routes(routes!(hold_machine, release_machine))
}

/// Names stand in addresses and queues.
const LONGEST_NAME: usize = 64;
/// Reasons are for people.
const LONGEST_REASON: usize = 500;

/// A machine to be registered
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
struct MachineRequest {
    /// The profile; its name is the machine's.
    #[schema(value_type = Object)]
    profile: serde_json::Value,
    /// A queue that it shares with other machines.
    pool: Option<String>,
}

/// What is changed of a machine; what is left out stays
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
struct MachineAmendment {
    /// Its new profile, with the machine's own name.
    #[schema(value_type = Option<Object>)]
    profile: Option<serde_json::Value>,
    /// A queue that it shares with other machines; null if it shares none any more.
    #[serde(default, deserialize_with = "said")]
    #[schema(value_type = Option<String>)]
    pool: Option<Option<String>>,
}

/// A field that is there is said, be it null.
fn said<'de, D: serde::Deserializer<'de>>(value: D) -> Result<Option<Option<String>>, D::Error> {
    Option::deserialize(value).map(Some)
}

/// Why a machine is held
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
struct HoldRequest {
    /// In words, 1 to 500 characters.
    reason: String,
}

/// A registered machine
#[derive(Debug, Serialize, ToSchema)]
#[schema(as = Machine)]
pub struct MachineBody {
    /// Its name; jobs and queues name it so.
    #[schema(example = "cutter-3")]
    name: String,
    /// A queue that it shares with other machines.
    #[serde(skip_serializing_if = "Option::is_none")]
    pool: Option<String>,
    /// Its profile.
    #[schema(value_type = Object)]
    profile: Profile,
    /// Why it is given nothing new, if so.
    #[serde(skip_serializing_if = "Option::is_none")]
    hold: Option<HoldBody>,
    /// When it was registered.
    #[schema(format = DateTime)]
    created_at: String,
}

/// Why a machine is given nothing new
#[derive(Debug, Serialize, ToSchema)]
#[schema(as = Hold)]
pub struct HoldBody {
    /// Who holds it.
    by: String,
    /// Why.
    reason: String,
    /// Since when.
    #[schema(format = DateTime)]
    at: String,
}

/// All machines
#[derive(Debug, Serialize, ToSchema)]
#[schema(as = Machines)]
pub struct MachinesBody {
    /// By name.
    machines: Vec<MachineBody>,
}

impl From<Machine> for MachineBody {
    fn from(machine: Machine) -> Self {
        let hold =
            machine.hold.map(|hold| HoldBody { by: hold.by, reason: hold.reason, at: hold.at.to_string() });
        Self {
            name: machine.name,
            pool: machine.pool,
            profile: machine.profile,
            hold,
            created_at: machine.created_at.to_string(),
        }
    }
}

/// Register a machine
///
/// From then on jobs can name it. A job freezes the profile as it stands when the job is posted.
#[utoipa::path(post, path = "/v1/machines", tag = "shop floor", request_body = MachineRequest, responses(
    (status = 201, description = "It is registered", body = MachineBody),
    (status = 409, description = "There is one of that name", body = ProblemBody, content_type = "application/problem+json"),
    (status = 422, description = "The profile has faults", body = ProblemBody, content_type = "application/problem+json")))]
async fn register_machine(
    State(service): State<Service>,
    caller: Caller,
    Body(request): Body<MachineRequest>,
) -> Answer<(StatusCode, Json<MachineBody>)> {
    let (profile, pool) = checked(request)?;
    if Catalogue::built_in().get(profile.name()).is_some() {
        return Err(Problem::new(ProblemCode::MachineExists).detail("a built-in profile has this name"));
    }
    let added = service.store().add_machine(&profile, pool.as_deref(), &caller.actor, clock::now()).await;
    Ok((StatusCode::CREATED, Json(added.map_err(of_machine)?.into())))
}

/// List the machines
#[utoipa::path(get, path = "/v1/machines", tag = "shop floor", responses(
    (status = 200, description = "All of them", body = MachinesBody)))]
async fn list_machines(State(service): State<Service>) -> Answer<Json<MachinesBody>> {
    let machines = service.store().machines().await?;
    Ok(Json(MachinesBody { machines: machines.into_iter().map(MachineBody::from).collect() }))
}

/// Look at a machine
#[utoipa::path(get, path = "/v1/machines/{m}", tag = "shop floor",
    params(("m" = String, Path, description = "The machine")),
    responses(
        (status = 200, description = "The machine", body = MachineBody),
        (status = 404, description = "There is none", body = ProblemBody, content_type = "application/problem+json")))]
async fn get_machine(
    State(service): State<Service>,
    caller: Caller,
    Path(name): Path<String>,
) -> Answer<Json<MachineBody>> {
    caller.speaks_for(&name)?;
    Ok(Json(service.store().machine(&name).await.map_err(of_machine)?.into()))
}

/// Change a machine's profile, its pool, or both
///
/// What is left out stays as it is. Jobs that were posted before keep the profile that they froze.
#[utoipa::path(patch, path = "/v1/machines/{m}", tag = "shop floor", request_body = MachineAmendment,
    params(("m" = String, Path, description = "The machine")),
    responses(
        (status = 200, description = "The machine", body = MachineBody),
        (status = 404, description = "There is none", body = ProblemBody, content_type = "application/problem+json"),
        (status = 422, description = "The profile has faults, or another name", body = ProblemBody, content_type = "application/problem+json")))]
async fn change_machine(
    State(service): State<Service>,
    caller: Caller,
    Path(name): Path<String>,
    Body(request): Body<MachineAmendment>,
) -> Answer<Json<MachineBody>> {
    let change = checked_change(request, &name)?;
    let changed = service.store().change_machine(&name, &change, &caller.actor, clock::now()).await;
    Ok(Json(changed.map_err(of_machine)?.into()))
}

/// Hold a machine
///
/// It is given nothing new until the hold is taken back. What it runs goes on.
#[utoipa::path(put, path = "/v1/machines/{m}/hold", tag = "shop floor", request_body = HoldRequest,
    params(("m" = String, Path, description = "The machine")),
    responses(
        (status = 200, description = "The machine, on hold", body = MachineBody),
        (status = 404, description = "There is none", body = ProblemBody, content_type = "application/problem+json")))]
async fn hold_machine(
    State(service): State<Service>,
    caller: Caller,
    Path(name): Path<String>,
    Body(request): Body<HoldRequest>,
) -> Answer<Json<MachineBody>> {
    let reason = reason(&request.reason)?;
    let held = service.store().hold(&name, Some(reason), &caller.actor, clock::now()).await;
    Ok(Json(held.map_err(of_machine)?.into()))
}

/// Take a hold back
#[utoipa::path(delete, path = "/v1/machines/{m}/hold", tag = "shop floor",
    params(("m" = String, Path, description = "The machine")),
    responses(
        (status = 200, description = "The machine", body = MachineBody),
        (status = 404, description = "There is none", body = ProblemBody, content_type = "application/problem+json")))]
async fn release_machine(
    State(service): State<Service>,
    caller: Caller,
    Path(name): Path<String>,
) -> Answer<Json<MachineBody>> {
    let released = service.store().hold(&name, None, &caller.actor, clock::now()).await;
    Ok(Json(released.map_err(of_machine)?.into()))
}

/// What a machine's name of a request led to.
#[must_use]
pub fn of_machine(error: Error) -> Problem {
    match error {
        Error::NotFound => Problem::new(ProblemCode::MachineNotFound),
        Error::Exists => Problem::new(ProblemCode::MachineExists),
        other => other.into(),
    }
}

/// A reason that a person gives: something, and not too much of it.
///
/// # Errors
/// `InvalidRequest`.
pub fn reason(words: &str) -> Answer<&str> {
    let words = words.trim();
    if words.is_empty() || words.chars().count() > LONGEST_REASON {
        let detail = format!("reason: 1 to {LONGEST_REASON} characters");
        return Err(Problem::new(ProblemCode::InvalidRequest).detail(detail));
    }
    Ok(words)
}

fn checked(request: MachineRequest) -> Answer<(Profile, Option<String>)> {
    let profile = checked_profile(request.profile)?;
    request.pool.as_deref().map_or(Ok(()), refuse_strange_name)?;
    Ok((profile, request.pool))
}

fn checked_change(request: MachineAmendment, name: &str) -> Answer<MachineChange> {
    let profile = request.profile.map(checked_profile).transpose()?;
    if let Some(other) = profile.as_ref().map(Profile::name).filter(|other| *other != name) {
        let detail = format!("the profile is named {other}; a machine keeps its name");
        return Err(Problem::new(ProblemCode::InvalidRequest).detail(detail));
    }
    request.pool.iter().flatten().try_for_each(|pool| refuse_strange_name(pool))?;
    Ok(MachineChange { profile, pool: request.pool })
}

fn checked_profile(value: serde_json::Value) -> Answer<Profile> {
    let faults = PROFILE.faults(&value, "/profile");
    if !faults.is_empty() {
        return Err(faulty(faults));
    }
    let profile: Profile = document::typed(value, "/profile").map_err(faulty)?;
    profile.check("/profile").map_err(faulty)?;
    refuse_strange_name(profile.name())?;
    Ok(profile)
}

fn faulty(faults: Vec<Finding>) -> Problem {
    Problem::of_faults(ProblemCode::InvalidRequest, faults)
}

/// Names of machines and pools stand in addresses, logs and on screens.
///
/// # Errors
/// `InvalidRequest`.
pub fn refuse_strange_name(name: &str) -> Answer<()> {
    let fits = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.');
    if name.is_empty() || name.len() > LONGEST_NAME || !name.chars().all(fits) {
        let detail = format!("a name has 1 to {LONGEST_NAME} letters, digits, '-', '_' or '.'");
        return Err(Problem::new(ProblemCode::InvalidRequest).detail(detail));
    }
    Ok(())
}
