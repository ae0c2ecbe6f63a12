//! What stands in answers. These types are contract; they are made from the store's types in one place each.

use std::collections::BTreeMap;

use serde::Serialize;
use utoipa::ToSchema;

use crate::job::id::{JobId, ProgramId};
use crate::job::life::{Job, MOST_ATTEMPTS, State};
use crate::job::purpose::Purpose;
use crate::planning::finding::{Code, Finding, Severity};
use crate::store::files::JobFile;
use crate::store::programs::Program;

/// A planning job
#[derive(Debug, Serialize, ToSchema)]
#[schema(as = Job)]
pub struct JobBody {
    /// Its id.
    #[schema(example = "job_0198c2a41b2c7d3e8f9a0b1c2d3e4f50")]
    id: String,
    /// The kind of work.
    #[schema(example = "tape-cut")]
    kind: String,
    /// A label for people.
    name: String,
    /// Free, searchable strings.
    references: BTreeMap<String, String>,
    /// The program whose dry run it plans, if it was asked for as that.
    #[serde(skip_serializing_if = "Option::is_none")]
    dry_run_of: Option<String>,
    /// Where it stands: queued, running, succeeded, failed or cancelled.
    state: StateWord,
    /// Whether it gave a program that may be approved; there once it has succeeded.
    #[serde(skip_serializing_if = "Option::is_none")]
    verdict: Option<VerdictWord>,
    /// How many warnings its report holds; there once it has succeeded, if it was counted then. Whoever approves reads them first.
    #[serde(skip_serializing_if = "Option::is_none")]
    warnings: Option<u32>,
    /// When it was posted.
    #[schema(format = DateTime)]
    created_at: String,
    /// When the attempt began that runs, or that gave the answer.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(format = DateTime)]
    started_at: Option<String>,
    /// When it ended.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(format = DateTime)]
    finished_at: Option<String>,
    /// How many attempts count against it.
    attempts: u32,
    /// How many attempts may.
    attempts_allowed: u32,
    /// The stage that the running attempt has reached.
    #[serde(skip_serializing_if = "Option::is_none")]
    stage: Option<String>,
    /// How long each stage took.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    stages: Vec<StageBody>,
    /// Why it failed.
    #[serde(skip_serializing_if = "Option::is_none")]
    failure: Option<FailureBody>,
    /// Who cancelled it, and why.
    #[serde(skip_serializing_if = "Option::is_none")]
    cancellation: Option<CancellationBody>,
    /// The program that it gave.
    #[serde(skip_serializing_if = "Option::is_none")]
    program: Option<String>,
    /// The names of its drawings.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    drawings: Vec<String>,
    /// The files that came with it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    files: Vec<JobFileBody>,
    /// Where to go next.
    links: JobLinks,
}

/// A file that came with a job
#[derive(Debug, Serialize, ToSchema)]
#[schema(as = JobFile)]
pub struct JobFileBody {
    /// Its name.
    name: String,
    /// The SHA-256 of its bytes.
    sha256: String,
    /// Its length.
    bytes: i64,
    /// Where it is.
    href: String,
}

/// Where a job stands
#[derive(Debug, Clone, Copy, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = JobState)]
pub enum StateWord {
    /// It waits for a worker.
    Queued,
    /// A worker plans it.
    Running,
    /// It has an answer.
    Succeeded,
    /// It has no answer and will not get one.
    Failed,
    /// Somebody does not want it any more.
    Cancelled,
}

/// Whether a job gave a program that may be approved
#[derive(Debug, Clone, Copy, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = Verdict)]
pub enum VerdictWord {
    /// It did.
    Usable,
    /// It did not; the report says why.
    NotUsable,
}

/// How long a stage took
#[derive(Debug, Serialize, ToSchema)]
#[schema(as = Stage)]
pub struct StageBody {
    /// The stage.
    name: String,
    /// Seconds by the clock on the wall.
    seconds: f64,
}

/// Why a job failed
#[derive(Debug, Serialize, ToSchema)]
#[schema(as = Failure)]
pub struct FailureBody {
    /// What happened: invalid_input, input_damaged, memory_limit, cpu_limit, crashed, answer_too_large or
    /// attempts_used_up.
    #[schema(example = "memory_limit")]
    code: &'static str,
    /// The same in words.
    detail: String,
    /// What is wrong with the input, where that is the reason.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    findings: Vec<FindingBody>,
}

/// One thing that should be known about an input
#[derive(Debug, Serialize, ToSchema)]
#[schema(as = Finding)]
pub struct FindingBody {
    /// info, warning or error.
    #[schema(value_type = String)]
    severity: Severity,
    /// What it is.
    #[schema(value_type = String)]
    code: Code,
    /// Where: a JSON pointer.
    at: String,
    /// What, for people.
    message: String,
}

/// Who cancelled a job
#[derive(Debug, Serialize, ToSchema)]
#[schema(as = Cancellation)]
pub struct CancellationBody {
    /// Who.
    by: String,
    /// Why, if it was said.
    #[serde(skip_serializing_if = "Option::is_none")]
    reason: Option<String>,
}

/// Where to go from a job
#[derive(Debug, Serialize, ToSchema)]
pub struct JobLinks {
    /// The job itself.
    #[serde(rename = "self")]
    itself: String,
    /// Its progress as a stream.
    events: String,
    /// The document as it was posted.
    input: String,
    /// Its report; there once it has succeeded.
    #[serde(skip_serializing_if = "Option::is_none")]
    report: Option<String>,
    /// The program that it gave.
    #[serde(skip_serializing_if = "Option::is_none")]
    program: Option<String>,
    /// PUT here cancels it; there while it can be.
    #[serde(skip_serializing_if = "Option::is_none")]
    cancellation: Option<String>,
}

/// A page of jobs, the newest first
#[derive(Debug, Serialize, ToSchema)]
#[schema(as = JobPage)]
pub struct JobPageBody {
    /// The jobs.
    pub jobs: Vec<JobBody>,
    /// What to give as `cursor` for the next page; not there on the last.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub next_cursor: Option<String>,
}

/// A program: immutable bytes for one kind of machine
#[derive(Debug, Serialize, ToSchema)]
#[schema(as = Program)]
pub struct ProgramBody {
    /// Its id.
    #[schema(example = "prg_0198c2a41b2c7d3e8f9a0b1c2d3e4f50")]
    id: String,
    /// The job that gave it.
    job: String,
    /// The job's kind.
    kind: String,
    /// What it is for. Only what is for production makes units.
    #[schema(value_type = PurposeWord)]
    purpose: Purpose,
    /// The course from which on it goes, if not from the start.
    #[serde(skip_serializing_if = "Option::is_none")]
    from_course: Option<u32>,
    /// The ply whose course that is, on a roll of several.
    #[serde(skip_serializing_if = "Option::is_none")]
    from_ply: Option<u32>,
    /// draft, approved, superseded, revoked or quarantined.
    #[schema(example = "draft")]
    state: String,
    /// The SHA-256 of its content, which approval and receipt name.
    sha256: String,
    /// The length of its content.
    bytes: i64,
    /// The name of its content.
    name: String,
    /// The media type of its content.
    media_type: String,
    /// When it was made.
    #[schema(format = DateTime)]
    created_at: String,
    /// Its files. The content is the single one, or an archive of all of them.
    files: Vec<FileBody>,
    /// Where to go next.
    links: ProgramLinks,
}

/// What a program is for
#[derive(Debug, Clone, Copy, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = Purpose)]
pub enum PurposeWord {
    /// It makes a whole unit.
    Production,
    /// The same moves with knives up and the generator off: nothing is cut.
    DryRun,
    /// The rest of a roll that another run has begun.
    Restart,
}

/// A file of a program
#[derive(Debug, Serialize, ToSchema)]
#[schema(as = ProgramFile)]
pub struct FileBody {
    /// Its name.
    name: String,
    /// linuxcnc, sinumerik or krl.
    dialect: String,
    /// The SHA-256 of its bytes.
    sha256: String,
    /// Its length.
    bytes: i64,
    /// Where it is.
    href: String,
}

/// Where to go from a program
#[derive(Debug, Serialize, ToSchema)]
pub struct ProgramLinks {
    /// The program itself.
    #[serde(rename = "self")]
    itself: String,
    /// Its bytes.
    content: String,
    /// PUT here asks for its dry run; there where it has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    dry_run: Option<String>,
    /// The job that gave it.
    job: String,
    /// That job's report.
    report: String,
}

/// A page of programs, the newest first
#[derive(Debug, Serialize, ToSchema)]
#[schema(as = ProgramPage)]
pub struct ProgramPageBody {
    /// The programs.
    pub programs: Vec<ProgramBody>,
    /// What to give as `cursor` for the next page; not there on the last.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub next_cursor: Option<String>,
}

/// What `?validate_only=true` answers for a document without faults
#[derive(Debug, Serialize, ToSchema)]
#[schema(as = Validation)]
pub struct ValidationBody {
    /// Always true; a document with faults is a problem.
    pub valid: bool,
    /// The kind of work.
    pub kind: String,
}

/// The address of a job.
#[must_use]
pub fn job_address(id: &JobId) -> String {
    format!("/v1/jobs/{id}")
}

/// The address of a program.
#[must_use]
pub fn program_address(id: &ProgramId) -> String {
    format!("/v1/programs/{id}")
}

impl JobBody {
    /// Its id.
    #[must_use]
    pub fn id(&self) -> &str {
        &self.id
    }

    /// A job with the names of its drawings and the files that came with it.
    #[must_use]
    pub fn new(job: Job, drawings: Vec<String>, files: Vec<JobFile>) -> Self {
        let mut body = Self {
            links: JobLinks::new(&job),
            files: files.into_iter().map(|file| JobFileBody::new(&job.id, file)).collect(),
            id: job.id.to_string(),
            kind: job.kind,
            name: job.name,
            references: job.references,
            dry_run_of: job.dry_run_of.map(String::from),
            state: StateWord::Queued,
            verdict: None,
            warnings: None,
            created_at: job.created_at.to_string(),
            started_at: None,
            finished_at: None,
            attempts: job.attempts,
            attempts_allowed: MOST_ATTEMPTS,
            stage: None,
            stages: Vec::new(),
            failure: None,
            cancellation: None,
            program: None,
            drawings,
        };
        body.take_state(job.state);
        body
    }

    fn take_state(&mut self, state: State) {
        match state {
            State::Queued { .. } => self.state = StateWord::Queued,
            State::Running { started_at, stage, .. } => {
                self.state = StateWord::Running;
                self.started_at = Some(started_at.to_string());
                self.stage = stage;
            }
            State::Succeeded { started_at, finished_at, usable, warnings, program, stages } => {
                self.warnings = warnings;
                self.state = StateWord::Succeeded;
                self.started_at = Some(started_at.to_string());
                self.finished_at = Some(finished_at.to_string());
                self.verdict = Some(if usable { VerdictWord::Usable } else { VerdictWord::NotUsable });
                self.program = program.map(String::from);
                let stage_body = |stage: crate::job::life::StageTime| StageBody {
                    name: stage.name,
                    seconds: stage.seconds,
                };
                self.stages = stages.into_iter().map(stage_body).collect();
            }
            State::Failed { finished_at, failure } => {
                self.state = StateWord::Failed;
                self.finished_at = Some(finished_at.to_string());
                let findings = failure.findings.into_iter().map(FindingBody::from).collect();
                self.failure =
                    Some(FailureBody { code: failure.code.as_str(), detail: failure.detail, findings });
            }
            State::Cancelled { finished_at, by, reason } => {
                self.state = StateWord::Cancelled;
                self.finished_at = Some(finished_at.to_string());
                self.cancellation = Some(CancellationBody { by, reason });
            }
        }
    }
}

impl JobFileBody {
    fn new(job: &JobId, file: JobFile) -> Self {
        let JobFile { name, sha256, bytes } = file;
        // Of what a plain name may hold, an address takes everything but a space.
        let href = format!("{}/files/{}", job_address(job), name.replace(' ', "%20"));
        Self { name, sha256, bytes, href }
    }
}

impl JobLinks {
    fn new(job: &Job) -> Self {
        let itself = job_address(&job.id);
        let (report, program) = match &job.state {
            State::Succeeded { program, .. } => {
                (Some(format!("{itself}/report")), program.as_ref().map(program_address))
            }
            _ => (None, None),
        };
        Self {
            events: format!("{itself}/events"),
            input: format!("{itself}/input"),
            report,
            program,
            cancellation: (!job.state.is_final()).then(|| format!("{itself}/cancellation")),
            itself,
        }
    }
}

impl From<Finding> for FindingBody {
    fn from(finding: Finding) -> Self {
        let Finding { severity, code, at, message } = finding;
        Self { severity, code, at, message }
    }
}

impl From<Program> for ProgramBody {
    fn from(program: Program) -> Self {
        let itself = program_address(&program.id);
        let job = job_address(&program.job);
        let has_dry_run = program.has_dry_run() && program.is_in_use();
        let file = |file: crate::store::programs::FileEntry| FileBody {
            href: format!("{itself}/files/{}", file.name),
            name: file.name,
            dialect: file.dialect,
            sha256: file.sha256,
            bytes: file.bytes,
        };
        Self {
            files: program.files.into_iter().map(file).collect(),
            links: ProgramLinks {
                content: format!("{itself}/content"),
                dry_run: has_dry_run.then(|| format!("{itself}/dry-run")),
                report: format!("{job}/report"),
                itself,
                job,
            },
            id: program.id.to_string(),
            job: program.job.to_string(),
            kind: program.kind,
            purpose: program.purpose,
            from_course: program.purpose.from_course(),
            from_ply: program.purpose.from_ply(),
            state: program.state,
            sha256: program.sha256,
            bytes: program.bytes,
            name: program.content_name,
            media_type: program.media_type,
            created_at: program.created_at.to_string(),
        }
    }
}
