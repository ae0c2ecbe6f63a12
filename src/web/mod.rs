//! Pages for people. They show what the interface under `/v1` has, and link to it; they change nothing.

use askama::Template;
use axum::Router;
use axum::extract::State;
use axum::http::header;
use axum::response::{Html, IntoResponse, Response};
use axum::routing::get;

use crate::http::problem::{Answer, Problem};
use crate::http::service::Service;
use crate::job::life::{Job, State as JobState};
use crate::job::purpose::Purpose;
use crate::planning::outcome::PLANNER_VERSION;
use crate::store::Store;
use crate::store::jobs::JobFilter;

/// The addresses.
pub fn routes() -> Router<Service> {
    Router::new().route("/", get(index))
}

/// So many jobs stand on the page, the newest first.
const JOBS: i64 = 25;

/// Nothing is loaded from elsewhere and nothing runs.
const POLICY: &str =
    "default-src 'none'; style-src 'unsafe-inline'; form-action 'none'; frame-ancestors 'none'";

#[derive(Template)]
#[template(path = "index.html")]
struct Index {
    version: &'static str,
    counts: Vec<(&'static str, i64)>,
    jobs: Vec<Row>,
    /// Whether anything will change by itself.
    busy: bool,
    /// Whether jobs are only for those who have a key: a browser has none.
    keyed: bool,
}

/// A job as the page shows it.
struct Row {
    id: String,
    name: String,
    kind: String,
    created_at: String,
    state: &'static str,
    /// What a person wants to know beside the state.
    remark: String,
    report: bool,
    program: Option<String>,
    drawings: Vec<String>,
}

async fn index(State(service): State<Service>) -> Answer<Response> {
    let keyed = service.store().has_keys().await?;
    let page = if keyed { Index::closed() } else { Index::open(service.store()).await? };
    let text = page.render().map_err(Problem::internal)?;
    Ok(([(header::CONTENT_SECURITY_POLICY, POLICY)], Html(text)).into_response())
}

impl Index {
    /// For somebody of whom nothing is known.
    fn closed() -> Self {
        Self { version: PLANNER_VERSION, counts: Vec::new(), jobs: Vec::new(), busy: false, keyed: true }
    }

    /// For somebody on this machine, as long as there are no keys.
    async fn open(store: &Store) -> Answer<Self> {
        let known = store.jobs_by_state().await?;
        let count = |state| (state, known.get(state).copied().unwrap_or_default());
        let mut jobs = Vec::new();
        for job in store.jobs(&JobFilter { limit: JOBS, ..JobFilter::default() }).await? {
            let drawings = store.drawing_names(&job.id).await?;
            let purpose = purpose(store, &job).await?;
            jobs.push(row(job, drawings, purpose));
        }
        let busy = count("queued").1 + count("running").1 > 0;
        let counts = JobState::WORDS.into_iter().map(count).collect();
        Ok(Self { version: PLANNER_VERSION, counts, jobs, busy, keyed: false })
    }
}

/// What the program of a job is for, if it has one.
async fn purpose(store: &Store, job: &Job) -> Answer<Purpose> {
    match &job.state {
        JobState::Succeeded { program: Some(program), .. } => Ok(store.program(program).await?.purpose),
        _ => Ok(Purpose::default()),
    }
}

fn row(job: Job, drawings: Vec<String>, purpose: Purpose) -> Row {
    let (remark, program) = match &job.state {
        JobState::Queued { .. } => (String::new(), None),
        JobState::Running { stage, .. } => (stage.clone().unwrap_or_default(), None),
        JobState::Succeeded { program: Some(program), warnings, .. } => {
            (usable(purpose, *warnings), Some(program.to_string()))
        }
        JobState::Succeeded { program: None, .. } => ("no usable program: see the report".into(), None),
        JobState::Failed { failure, .. } => (failure.detail.clone(), None),
        JobState::Cancelled { reason, .. } => (reason.clone().unwrap_or_default(), None),
    };
    Row {
        id: job.id.to_string(),
        name: job.name,
        kind: job.kind,
        created_at: job.created_at.to_string(),
        state: job.state.word(),
        remark,
        report: matches!(job.state, JobState::Succeeded { .. }),
        program,
        drawings,
    }
}

/// A program that is no ordinary one says so at once, and so does one that there are warnings about.
fn usable(purpose: Purpose, warnings: Option<u32>) -> String {
    let warned = match warnings {
        None | Some(0) => String::new(),
        Some(1) => ", with a warning: see the report".to_owned(),
        Some(many) => format!(", with {many} warnings: see the report"),
    };
    let words = purpose.warning().map_or_else(String::new, |words| format!(". {words}"));
    format!("usable{warned}{words}")
}
