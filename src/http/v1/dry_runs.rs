//! The dry run of a program: the same moves with knives up and the ultrasonic off, planned as a job of its own, so that
//! it is read back, replayed, hashed and approved like any program.

use std::sync::Arc;

use axum::extract::State;
use axum::response::Response;
use serde::Deserialize;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use super::posting::{accepted, checked};
use super::wire::JobBody;
use crate::clock;
use crate::http::caller::Caller;
use crate::http::extract::ProgramPath;
use crate::http::problem::{Answer, Problem, ProblemBody, ProblemCode, of_program, of_unapproved};
use crate::http::service::Service;
use crate::job::id::JobId;
use crate::job::life::NewJob;
use crate::planning::document::dry_run::as_dry_run;
use crate::planning::outcome::PLANNER_VERSION;
use crate::store::attempts::AttemptInput;
use crate::store::jobs::{Post, Posted};
use crate::store::programs::Program;
use crate::worker::checking::Label;

/// The addresses.
#[must_use]
pub fn routes() -> OpenApiRouter<Service> {
    OpenApiRouter::new().routes(routes!(ask_for_dry_run))
}

/// Ask for the dry run of a program
///
/// A job is posted with the document and files of the program's own, `options.dry_run` set, and the machine profiles that
/// were frozen with it. Its program makes the same moves with knives up and the ultrasonic off, has a hash of its own,
/// and runs once it is approved. Asked again it is the same job, unless that has failed or was cancelled, or its program
/// was taken out of use.
#[utoipa::path(put, path = "/v1/programs/{id}/dry-run", tag = "programs",
    params(("id" = String, Path, description = "The program")),
    responses(
        (status = 202, description = "The job of the dry run, new or as it stands", body = JobBody, headers(
            ("Location" = String, description = "The job's address"),
            ("Retry-After" = u32, description = "Seconds after which to look"),
            ("Idempotency-Replayed" = Option<String>, description = "true if it had been asked for before"))),
        (status = 404, description = "There is no such program", body = ProblemBody, content_type = "application/problem+json"),
        (status = 409, description = "It is no tape program, a dry run itself, of another version of the planner, or out of use", body = ProblemBody, content_type = "application/problem+json"),
        (status = 422, description = "Its document has faults for this version", body = ProblemBody, content_type = "application/problem+json"),
        (status = 429, description = "As many jobs wait as may wait", body = ProblemBody, content_type = "application/problem+json"),
        (status = 503, description = "No room, or ending", body = ProblemBody, content_type = "application/problem+json")))]
async fn ask_for_dry_run(
    State(service): State<Service>,
    caller: Caller,
    path: ProgramPath,
) -> Answer<Response> {
    if service.is_stopping() {
        return Err(Problem::new(ProblemCode::Stopping));
    }
    let program = service.store().program(&path.id).await.map_err(of_program)?;
    refuse_without_dry_run(&program)?;
    if let Some(job) = service.store().dry_run_of(&program.id).await? {
        return accepted(&service, Posted { job, replayed: true }).await;
    }
    refuse_other_version(&service, &program).await?;
    let input = dry_input(&service, &program).await?;
    let label = checked(&service, input.clone(), false).await?;
    let posted = post(&service, &caller, &program, &input, label).await?;
    accepted(&service, posted).await
}

fn refuse_without_dry_run(program: &Program) -> Answer<()> {
    if !program.has_dry_run() {
        let is = if program.purpose.makes_units() { "a robot's program" } else { "a dry run itself" };
        return Err(Problem::new(ProblemCode::NoDryRun).detail(format!("it is {is}")));
    }
    if program.is_in_use() { Ok(()) } else { Err(of_unapproved(&program.state)) }
}

/// Another version may plan other moves, and then it would be no dry run of this program.
async fn refuse_other_version(service: &Service, program: &Program) -> Answer<()> {
    #[derive(Deserialize)]
    struct Report {
        planner_version: String,
    }
    let report = service.store().report(&program.job).await?;
    let Report { planner_version } = serde_json::from_slice(&report).map_err(Problem::internal)?;
    if planner_version == PLANNER_VERSION {
        return Ok(());
    }
    let detail = format!(
        "it was planned by version {planner_version}, and this is {PLANNER_VERSION}: its moves may be others"
    );
    Err(Problem::new(ProblemCode::NoDryRun).detail(detail))
}

/// What the dry run is planned from: what the program was, with the option set.
async fn dry_input(service: &Service, program: &Program) -> Answer<AttemptInput> {
    let given = service.store().attempt_input(&program.job).await?;
    let body = as_dry_run(&given.body);
    let body = body.ok_or_else(|| Problem::internal(format!("the document of {} is none", program.job)))?;
    Ok(AttemptInput { body: Arc::new(body), ..given })
}

async fn post(
    service: &Service,
    caller: &Caller,
    program: &Program,
    input: &AttemptInput,
    label: Label,
) -> Answer<Posted> {
    let now = clock::now();
    let Label { kind, name, references } = label;
    let id = JobId::new(now, &clock::entropy());
    let post = Post {
        job: NewJob { id, kind, name, references, dry_run_of: Some(program.id.clone()) },
        body: &input.body,
        files: &input.files,
        machines: &input.machines,
        key: None,
        most_queued: i64::from(service.config().max_queued),
        actor: &caller.actor,
        now,
    };
    Ok(service.store().post(post).await?)
}
