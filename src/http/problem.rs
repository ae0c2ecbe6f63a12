//! The one place where errors become HTTP answers (RFC 9457).
//!
//! The codes are a closed set and contract. What the database, the planner or the system said stays in the log;
//! the answer names only the request by which it is found there.

use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::Serialize;
use utoipa::ToSchema;

use crate::job::life::Illegal;
use crate::job::{entry, run};
use crate::planning::finding::{Code, Finding};
use crate::store;

/// The media type of every error.
pub const MEDIA_TYPE: &str = "application/problem+json";

macro_rules! problems {
    ($($(#[doc = $doc:literal])+ $name:ident = $status:ident, $retryable:literal, $next:literal);+ $(;)?) => {
        /// The closed set of problem codes.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, ToSchema)]
        #[serde(rename_all = "snake_case")]
        pub enum ProblemCode { $($(#[doc = $doc])+ $name),+ }

        impl ProblemCode {
            /// Every code.
            pub const ALL: &[Self] = &[$(Self::$name),+];

            /// The status of the answer.
            #[must_use]
            pub fn status(self) -> StatusCode {
                match self { $(Self::$name => StatusCode::$status),+ }
            }

            /// What it is, for people.
            #[must_use]
            pub fn title(self) -> &'static str {
                match self { $(Self::$name => concat!($($doc),+)),+ }
            }

            /// Whether the same request may succeed later.
            #[must_use]
            pub fn retryable(self) -> bool {
                match self { $(Self::$name => $retryable),+ }
            }

            /// What a person does next.
            #[must_use]
            pub fn next_step(self) -> &'static str {
                match self { $(Self::$name => $next),+ }
            }
        }
    };
}

problems! {
    /// The body is not JSON.
    InvalidJson = BAD_REQUEST, false, "Send the whole document as JSON; the fault says where reading stopped.";
    /// The job document has faults.
    InvalidJob = UNPROCESSABLE_ENTITY, false, "Correct every fault that is listed and post the job again; /openapi.json describes the document.";
    /// The query of the address has a fault.
    InvalidQuery = BAD_REQUEST, false, "Correct the query; /docs lists what each address takes.";
    /// A header of the request has a fault.
    InvalidHeader = BAD_REQUEST, false, "Correct the header that is named.";
    /// The media type of the body is not one that is read here.
    UnsupportedMediaType = UNSUPPORTED_MEDIA_TYPE, false, "Send the body with Content-Type: application/json; a job with files as multipart/form-data.";
    /// The form is not one of a job and its files.
    InvalidMultipart = BAD_REQUEST, false, "Send one part named job as application/json, and each file as a part of its own with a plain name.";
    /// A page of another site has had a browser send this form.
    ForeignPage = FORBIDDEN, false, "Send the form from a program, or from a page of this service.";
    /// The body is larger than the service takes.
    BodyTooLarge = PAYLOAD_TOO_LARGE, false, "Thin out the points or split the ply; or ask the operator to raise --max-body-mib.";
    /// The body did not arrive in time.
    BodyTooSlow = REQUEST_TIMEOUT, true, "Send the request again over a better line.";
    /// The body ended before its announced length.
    BodyIncomplete = BAD_REQUEST, true, "Send the request again.";
    /// This idempotency key was used with another body.
    IdempotencyKeyReused = UNPROCESSABLE_ENTITY, false, "Use a new Idempotency-Key for a new job; repeat the same bytes with the old one.";
    /// There is nothing at this address.
    NotFound = NOT_FOUND, false, "Check the address; /docs lists all of them.";
    /// This address does not take this method.
    MethodNotAllowed = METHOD_NOT_ALLOWED, false, "Use a method that the Allow header names.";
    /// There is no such job.
    JobNotFound = NOT_FOUND, false, "Check the id; GET /v1/jobs lists the jobs.";
    /// There is no such program.
    ProgramNotFound = NOT_FOUND, false, "Check the id; GET /v1/programs lists the programs.";
    /// There is no file of that name.
    FileNotFound = NOT_FOUND, false, "Check the name; the job or the program lists its files.";
    /// The job has no drawing of that name.
    DrawingNotFound = NOT_FOUND, false, "Check the name; the job lists its drawings.";
    /// The job has no report yet.
    NotReady = CONFLICT, true, "Wait until the job has ended: GET /v1/jobs/{id}?wait=30.";
    /// The job ended without a report.
    NoReport = CONFLICT, false, "The job says why it failed or who cancelled it.";
    /// The job has ended and cannot be cancelled.
    JobFinished = CONFLICT, false, "Nothing is to be done; GET the job for its result.";
    /// The program's stored bytes do not fit their hash any more.
    ProgramQuarantined = CONFLICT, false, "Do not use this program. Post its job again, and have the disk of the store checked.";
    /// A stored document does not fit its hash any more.
    StoreDamaged = INTERNAL_SERVER_ERROR, false, "Restore a backup, and have the disk of the store checked.";
    /// The body does not fit what this address takes.
    InvalidRequest = UNPROCESSABLE_ENTITY, false, "Correct the body; /docs describes what each address takes.";
    /// The request carries no key that is known.
    Unauthorized = UNAUTHORIZED, false, "Send a key: Authorization: Bearer KEY. An administrator makes one with bladeplan key create.";
    /// The key's role may not do this.
    Forbidden = FORBIDDEN, false, "Use a key with a role that may do this; docs/shop-floor.md lists who may do what.";
    /// There is no such machine.
    MachineNotFound = NOT_FOUND, false, "Check the name; GET /v1/machines lists the machines.";
    /// There is a machine of that name already.
    MachineExists = CONFLICT, false, "Choose another name, or change the machine with PATCH.";
    /// The machine is on hold.
    MachineHeld = CONFLICT, true, "An operator takes the hold back with DELETE /v1/machines/{m}/hold.";
    /// There is no such entry.
    EntryNotFound = NOT_FOUND, false, "Check the id; GET /v1/queues/{q}/entries lists the entries.";
    /// There is no such run.
    RunNotFound = NOT_FOUND, false, "Check the id; GET /v1/runs lists the runs.";
    /// The program is not approved.
    ProgramNotApproved = CONFLICT, false, "A draft is approved with PUT /v1/programs/{id}/approval; in place of a revoked program, post its job anew.";
    /// The program was planned for another profile than the machine has.
    ProfileMismatch = CONFLICT, false, "Plan the job for this machine: name it in the job and post it again.";
    /// The program was planned for no machine.
    NoMachineChecked = CONFLICT, false, "Plan the job again with its machine or cell: only then its limits are checked.";
    /// This program has no dry run.
    NoDryRun = CONFLICT, false, "Only a tape program has one, of the version that planned it: post its job again with options.dry_run. A robot's program is tried in the control's own test mode.";
    /// The hash that was sent is not that of the program.
    HashMismatch = CONFLICT, false, "Look at the program again: fetch it, compute its SHA-256, and name that.";
    /// The state does not admit this.
    IllegalState = CONFLICT, false, "GET it to see where it stands.";
    /// The fence is not the run's own any more.
    FenceLost = CONFLICT, false, "Stop: somebody has resolved this run. Claim anew.";
    /// The range lies outside the content.
    RangeNotSatisfiable = RANGE_NOT_SATISFIABLE, false, "Ask for a range within the length that Content-Range names.";
    /// The host name of the request is not one of this machine's own.
    UnknownHost = MISDIRECTED_REQUEST, false, "Address the service as localhost or 127.0.0.1.";
    /// As many jobs wait as may wait.
    QueueFull = TOO_MANY_REQUESTS, true, "Post again after the seconds that Retry-After names.";
    /// The service has no room for this request at the moment.
    Overloaded = SERVICE_UNAVAILABLE, true, "Send the request again after the seconds that Retry-After names.";
    /// The service is ending.
    Stopping = SERVICE_UNAVAILABLE, true, "Send the request again after the seconds that Retry-After names.";
    /// Something went wrong inside the service.
    Internal = INTERNAL_SERVER_ERROR, true, "Send the request again; if it fails again, tell the operator the request id.";
}

/// An error on its way to its answer.
#[derive(Debug, Clone)]
pub struct Problem {
    code: ProblemCode,
    detail: Option<String>,
    faults: Vec<Fault>,
    length: Option<usize>,
}

/// An error as the service answers it
#[derive(Debug, Serialize, ToSchema)]
#[schema(as = Problem)]
pub struct ProblemBody {
    /// A name for the code as a URI.
    #[serde(rename = "type")]
    #[schema(example = "urn:bladeplan:problem:invalid_job")]
    kind: String,
    /// What it is, for people.
    #[schema(value_type = String)]
    title: &'static str,
    /// The status of the answer.
    #[schema(example = 422)]
    status: u16,
    /// What it is, for programs.
    code: ProblemCode,
    /// What is wrong here.
    #[serde(skip_serializing_if = "Option::is_none")]
    detail: Option<String>,
    /// Whether the same request may succeed later.
    retryable: bool,
    /// What a person does next.
    #[schema(value_type = String)]
    next_step: &'static str,
    /// Every fault of the document, at most 100.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    faults: Vec<Fault>,
}

/// A fault of a document.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
pub struct Fault {
    /// Where: a JSON pointer (RFC 6901), empty for the whole document.
    #[schema(example = "/input/tape/width_mm")]
    pub pointer: String,
    /// What, for programs: a finding code.
    #[schema(value_type = String, example = "out_of_range")]
    pub code: Code,
    /// What, for people.
    pub detail: String,
}

/// How long a client waits before it asks again, where nothing better is known.
const RETRY_AFTER_S: u32 = 5;

/// What handlers give back.
pub type Answer<T> = Result<T, Problem>;

impl Problem {
    /// A problem of this code.
    #[must_use]
    pub fn new(code: ProblemCode) -> Self {
        Self { code, detail: None, faults: Vec::new(), length: None }
    }

    /// Says what is wrong here.
    #[must_use]
    pub fn detail(self, detail: impl Into<String>) -> Self {
        Self { detail: Some(detail.into()), ..self }
    }

    /// A problem inside the service: the words go to the log only.
    #[must_use]
    pub fn internal(words: impl std::fmt::Display) -> Self {
        tracing::error!(error = %words, "a request failed inside the service");
        Self::new(ProblemCode::Internal)
    }

    /// What a job document was refused for.
    #[must_use]
    pub fn refused(findings: Vec<Finding>) -> Self {
        let unreadable = |f: &Finding| matches!(f.code, Code::InvalidJson | Code::TooDeep);
        let code =
            if findings.iter().any(unreadable) { ProblemCode::InvalidJson } else { ProblemCode::InvalidJob };
        Self::of_faults(code, findings)
    }

    /// A problem with the faults of a document.
    #[must_use]
    pub fn of_faults(code: ProblemCode, findings: Vec<Finding>) -> Self {
        let count = findings.len();
        let detail = if count == 1 { "one fault".to_owned() } else { format!("{count} faults") };
        let faults = findings.into_iter().map(Fault::from).collect();
        Self { faults, ..Self::new(code).detail(detail) }
    }

    /// A range outside a content of so many bytes.
    #[must_use]
    pub fn outside(length: usize) -> Self {
        Self { length: Some(length), ..Self::new(ProblemCode::RangeNotSatisfiable) }
    }

    /// Its code.
    #[must_use]
    pub fn code(&self) -> ProblemCode {
        self.code
    }

    /// Its code as text.
    #[must_use]
    pub fn word(&self) -> String {
        word(self.code)
    }
}

/// What a job id of a request led to.
#[must_use]
pub fn of_job(error: store::Error) -> Problem {
    match error {
        store::Error::NotFound => Problem::new(ProblemCode::JobNotFound),
        other => other.into(),
    }
}

/// What a program id of a request led to.
#[must_use]
pub fn of_program(error: store::Error) -> Problem {
    match error {
        store::Error::NotFound => Problem::new(ProblemCode::ProgramNotFound),
        store::Error::Damaged { subject } => {
            tracing::error!(%subject, "a program was quarantined: its stored bytes do not fit their hash");
            Problem::new(ProblemCode::ProgramQuarantined)
        }
        other => other.into(),
    }
}

/// What an entry id of a request led to.
#[must_use]
pub fn of_entry(error: store::Error) -> Problem {
    match error {
        store::Error::NotFound => Problem::new(ProblemCode::EntryNotFound),
        other => other.into(),
    }
}

/// What a run id of a request led to.
#[must_use]
pub fn of_run(error: store::Error) -> Problem {
    match error {
        store::Error::NotFound => Problem::new(ProblemCode::RunNotFound),
        damaged @ store::Error::Damaged { .. } => of_program(damaged),
        other => other.into(),
    }
}

/// What a run does not admit.
fn of_illegal_run(illegal: run::Illegal) -> Problem {
    let code = match illegal {
        run::Illegal::FenceLost => ProblemCode::FenceLost,
        run::Illegal::OtherBytes => ProblemCode::HashMismatch,
        _ => ProblemCode::IllegalState,
    };
    Problem::new(code).detail(illegal.to_string())
}

/// What an entry does not admit.
fn of_illegal_entry(illegal: entry::Illegal) -> Problem {
    let code = match illegal {
        entry::Illegal::Quantity => ProblemCode::InvalidRequest,
        _ => ProblemCode::IllegalState,
    };
    Problem::new(code).detail(illegal.to_string())
}

/// What a program in this state is not good for.
#[must_use]
pub fn of_unapproved(state: &str) -> Problem {
    match state {
        "quarantined" => Problem::new(ProblemCode::ProgramQuarantined),
        other => Problem::new(ProblemCode::ProgramNotApproved).detail(format!("the program is {other}")),
    }
}

impl From<store::Error> for Problem {
    fn from(error: store::Error) -> Self {
        match error {
            store::Error::NotFound => Self::new(ProblemCode::NotFound),
            store::Error::Illegal(Illegal::Finished) => Self::new(ProblemCode::JobFinished),
            store::Error::Entry(illegal) => of_illegal_entry(illegal),
            store::Error::Run(illegal) => of_illegal_run(illegal),
            store::Error::NoMachine => Self::new(ProblemCode::MachineNotFound),
            store::Error::NoProgram => Self::new(ProblemCode::ProgramNotFound),
            store::Error::Held { by, reason } => {
                Self::new(ProblemCode::MachineHeld).detail(format!("held by {by}: {reason}"))
            }
            store::Error::NotApproved { state } => of_unapproved(&state),
            store::Error::OtherProfile => Self::new(ProblemCode::ProfileMismatch),
            store::Error::OtherHash => Self::new(ProblemCode::HashMismatch),
            store::Error::ForNoMachine => Self::new(ProblemCode::NoMachineChecked),
            store::Error::Standing(not) => Self::new(ProblemCode::IllegalState).detail(not.to_string()),
            store::Error::KeyReused => Self::new(ProblemCode::IdempotencyKeyReused),
            store::Error::QueueFull { waiting } => {
                Self::new(ProblemCode::QueueFull).detail(format!("{waiting} jobs wait"))
            }
            store::Error::Damaged { subject } => {
                tracing::error!(%subject, "stored bytes do not fit their hash");
                Self::new(ProblemCode::StoreDamaged)
            }
            store::Error::Busy => Self::new(ProblemCode::Overloaded),
            other => Self::internal(other),
        }
    }
}

impl From<Finding> for Fault {
    fn from(finding: Finding) -> Self {
        Self { pointer: finding.at, code: finding.code, detail: finding.message }
    }
}

impl IntoResponse for Problem {
    fn into_response(self) -> Response {
        let (code, length) = (self.code, self.length);
        let body = serde_json::to_vec(&ProblemBody::from(self)).unwrap_or_default();
        let mut response = (code.status(), body).into_response();
        let headers = response.headers_mut();
        headers.insert(header::CONTENT_TYPE, HeaderValue::from_static(MEDIA_TYPE));
        headers.insert(header::CACHE_CONTROL, HeaderValue::from_static("no-store"));
        if is_busy(code.status()) {
            headers.insert(header::RETRY_AFTER, HeaderValue::from(RETRY_AFTER_S));
        }
        if let Some(Ok(range)) = length.map(|length| HeaderValue::try_from(format!("bytes */{length}"))) {
            headers.insert(header::CONTENT_RANGE, range);
        }
        response
    }
}

impl From<Problem> for ProblemBody {
    fn from(problem: Problem) -> Self {
        let Problem { code, detail, faults, .. } = problem;
        Self {
            kind: format!("urn:bladeplan:problem:{}", word(code)),
            title: code.title().trim(),
            status: code.status().as_u16(),
            code,
            detail,
            retryable: code.retryable(),
            next_step: code.next_step(),
            faults,
        }
    }
}

fn word(code: ProblemCode) -> String {
    serde_json::to_value(code).ok().and_then(|v| v.as_str().map(str::to_owned)).unwrap_or_default()
}

/// Whether an answer names a time after which to ask again.
fn is_busy(status: StatusCode) -> bool {
    matches!(status, StatusCode::TOO_MANY_REQUESTS | StatusCode::SERVICE_UNAVAILABLE)
}
