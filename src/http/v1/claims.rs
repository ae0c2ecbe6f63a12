//! Claims: a machine asks for its next unit, or looks what it would be.

use std::fmt::Write;
use std::time::Duration;

use axum::Json;
use axum::extract::State;
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::{Deserialize, Serialize};
use tokio::time::{Instant, timeout};
use utoipa::ToSchema;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use super::entries::EntryBody;
use super::runs::{RunBody, run_address};
use crate::clock;
use crate::config::MOST_WAIT_S;
use crate::http::caller::Caller;
use crate::http::extract::{Body, Path};
use crate::http::problem::{Answer, Problem, ProblemBody, ProblemCode};
use crate::http::service::Service;
use crate::job::entry::Entry;
use crate::job::id::RunId;
use crate::job::waiting::WaitingFor;
use crate::store::claims::{Claim, Claimed, Peek};

/// The addresses.
#[must_use]
pub fn routes() -> OpenApiRouter<Service> {
    OpenApiRouter::new().routes(routes!(claim_run)).routes(routes!(peek_next))
}

/// The longest name of a claim, in characters.
const LONGEST_REQUEST: usize = 128;

/// A machine that waits for work is looked for so often. One look reads a few rows.
const LOOK_AGAIN: Duration = Duration::from_millis(500);

/// A machine asks for its next unit
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
struct ClaimRequest {
    /// The machine's own name for this claim, 1 to 128 visible ASCII characters. A claim whose answer was lost is
    /// repeated with the same name, and gives the same run; a new unit needs a new name.
    request_id: String,
    /// Seconds to wait for work, 0 to 50.
    #[serde(default)]
    wait_s: u32,
}

/// What a machine would be given
#[derive(Debug, Serialize, ToSchema)]
#[schema(as = Next)]
pub struct NextBody {
    /// The machine.
    machine: String,
    /// Who holds it, and why.
    #[serde(skip_serializing_if = "Option::is_none")]
    held: Option<HeldBody>,
    /// The run that it has; nothing new is given out before that has ended.
    #[serde(skip_serializing_if = "Option::is_none")]
    run: Option<RunBody>,
    /// The entry that comes next.
    #[serde(skip_serializing_if = "Option::is_none")]
    entry: Option<EntryBody>,
    /// Which unit of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    unit: Option<i64>,
    /// The first ten entries in its queues that this machine is not given, each with what it waits for.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    waiting: Vec<EntryBody>,
}

/// Who holds a machine
#[derive(Debug, Serialize, ToSchema)]
#[schema(as = Held)]
pub struct HeldBody {
    /// Who.
    by: String,
    /// Why.
    reason: String,
}

/// Claim the next unit for a machine
///
/// From the queues of the machine's own name and of its pool, in their order. The answer to a claim that was lost on
/// the way is had by repeating it.
#[utoipa::path(post, path = "/v1/machines/{m}/runs", tag = "shop floor", request_body = ClaimRequest,
    params(("m" = String, Path, description = "The machine")),
    responses(
        (status = 201, description = "A new run", body = RunBody, headers(("Location" = String, description = "The run's address"))),
        (status = 200, description = "The run that this claim has given before, or that the machine has not ended", body = RunBody),
        (status = 204, description = "Nothing waits"),
        (status = 403, description = "The key is another machine's", body = ProblemBody, content_type = "application/problem+json"),
        (status = 404, description = "There is no such machine", body = ProblemBody, content_type = "application/problem+json"),
        (status = 409, description = "The machine is on hold", body = ProblemBody, content_type = "application/problem+json"),
        (status = 422, description = "The body has a fault", body = ProblemBody, content_type = "application/problem+json")))]
async fn claim_run(
    State(service): State<Service>,
    caller: Caller,
    Path(machine): Path<String>,
    Body(request): Body<ClaimRequest>,
) -> Answer<Response> {
    caller.speaks_for(&machine)?;
    refuse_strange(&request)?;
    if service.is_stopping() {
        return Err(Problem::new(ProblemCode::Stopping));
    }
    // Whoever has fallen silent, perhaps this machine itself, must not look alive in the answer.
    service.store().mark_silent(clock::now()).await?;
    let until = Instant::now() + Duration::from_secs(u64::from(request.wait_s));
    loop {
        match claim(&service, &caller, &machine, &request.request_id).await? {
            Claimed::New(run) => {
                let location = [(header::LOCATION, run_address(&run.id))];
                return Ok((StatusCode::CREATED, location, Json(RunBody::from(run))).into_response());
            }
            Claimed::Known(run) => return Ok(Json(RunBody::from(run)).into_response()),
            Claimed::Nothing => {}
        }
        if !worth_another_try(&service, &machine, until).await? {
            return Ok(StatusCode::NO_CONTENT.into_response());
        }
    }
}

async fn claim(service: &Service, caller: &Caller, machine: &str, request_id: &str) -> Answer<Claimed> {
    let now = clock::now();
    let claim = Claim {
        machine,
        request_id,
        id: RunId::new(now, &clock::entropy()),
        lease_until: now.later_by_ms(service.config().lease_ms()),
        actor: &caller.actor,
        now,
    };
    Ok(service.store().claim_run(&claim).await?)
}

/// Waits until there may be something for a machine. The look before the claim leaves the write lock to others.
async fn worth_another_try(service: &Service, machine: &str, until: Instant) -> Answer<bool> {
    loop {
        let rest = until.saturating_duration_since(Instant::now());
        if rest.is_zero() || timeout(rest.min(LOOK_AGAIN), service.stopped()).await.is_ok() {
            return Ok(false);
        }
        let Peek { hold, run, next } = service.store().peek(machine).await?;
        if hold.is_some() || run.is_some() || next.is_some() {
            return Ok(true);
        }
    }
}

/// Look what a machine would be given
///
/// Nothing is claimed. With `Accept: text/plain` in a few lines for a terminal.
#[utoipa::path(get, path = "/v1/machines/{m}/next", tag = "shop floor",
    params(("m" = String, Path, description = "The machine"),
        ("Accept" = Option<String>, Header, description = "text/plain for a few lines of text")),
    responses(
        (status = 200, description = "What comes next, if anything", content((NextBody = "application/json"), (String = "text/plain"))),
        (status = 403, description = "The key is another machine's", body = ProblemBody, content_type = "application/problem+json"),
        (status = 404, description = "There is no such machine", body = ProblemBody, content_type = "application/problem+json")))]
async fn peek_next(
    State(service): State<Service>,
    caller: Caller,
    Path(machine): Path<String>,
    headers: HeaderMap,
) -> Answer<Response> {
    caller.speaks_for(&machine)?;
    let peek = service.store().peek(&machine).await?;
    let waiting = service.store().waiting_at(&machine).await?;
    if wants_text(&headers) {
        let kind = [(header::CONTENT_TYPE, "text/plain; charset=utf-8")];
        return Ok((kind, lines(&machine, &peek, &waiting)).into_response());
    }
    let (entry, unit) = peek.next.unzip();
    let held = peek.hold.map(|(by, reason)| HeldBody { by, reason });
    let run = peek.run.map(RunBody::from);
    let entry = match entry {
        Some(entry) => {
            let waiting_for = service.store().waiting_for_machine(&entry, &machine).await?;
            Some(EntryBody::new(entry, waiting_for))
        }
        None => None,
    };
    let waiting = waiting.into_iter().map(|(entry, found)| EntryBody::new(entry, Some(found))).collect();
    Ok(Json(NextBody { machine, held, run, entry, unit, waiting }).into_response())
}

fn wants_text(headers: &HeaderMap) -> bool {
    let accepted = headers.get(header::ACCEPT).and_then(|accept| accept.to_str().ok()).unwrap_or_default();
    accepted.trim_start().starts_with("text/plain")
}

/// The same for a terminal: one fact a line.
fn lines(machine: &str, peek: &Peek, waiting: &[(Entry, WaitingFor)]) -> String {
    let mut text = format!("machine  {machine}\n");
    let mut line = |word: &str, what: &str| {
        // Some of it a person typed; on a terminal it stays one line.
        let what: String = what.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
        // Writing to a text does not fail.
        let _ = writeln!(text, "{word:<8} {what}");
    };
    if let Some((by, reason)) = &peek.hold {
        line("held", &format!("by {by}: {reason}"));
        line("", &format!("an operator takes the hold back: DELETE /v1/machines/{machine}/hold"));
    }
    if let Some(run) = &peek.run {
        line("run", &format!("{} {} fence {}", run.id, run.state.word(), run.fence));
        run.purpose.warning().iter().for_each(|words| line("", words));
        line("", "nothing else is given out before it has ended");
        if run.waits_for_a_person() {
            line(
                "",
                &format!("an operator looks at the machine and says so: PUT /v1/runs/{}/resolution", run.id),
            );
        }
    }
    match &peek.next {
        Some((entry, unit)) => {
            line(
                if peek.run.is_some() { "then" } else { "next" },
                &format!("unit {unit} of {} of {}", entry.quantity, entry.id),
            );
            line("program", entry.program.as_str());
            line("purpose", entry.purpose.word());
            entry.purpose.warning().iter().for_each(|words| line("", words));
        }
        None if waiting.is_empty() => line("next", "nothing waits"),
        None => line("next", "nothing that this machine can be given"),
    }
    for (entry, found) in waiting {
        line("waiting", &format!("{} for {}", entry.id, found.code.word()));
        line("", &found.detail);
    }
    text
}

fn refuse_strange(request: &ClaimRequest) -> Answer<()> {
    let fault = |detail: String| Err(Problem::new(ProblemCode::InvalidRequest).detail(detail));
    let name = &request.request_id;
    if name.is_empty() || name.len() > LONGEST_REQUEST || !name.bytes().all(|byte| byte.is_ascii_graphic()) {
        return fault(format!("request_id: 1 to {LONGEST_REQUEST} visible ASCII characters without spaces"));
    }
    if request.wait_s > MOST_WAIT_S {
        return fault(format!("wait_s is at most {MOST_WAIT_S}"));
    }
    Ok(())
}
