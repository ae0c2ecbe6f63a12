//! The service's side of the child: starts it, listens to it, and knows why it ended.

use std::os::unix::process::ExitStatusExt;
use std::process::{ExitStatus, Stdio};

use tokio::io::{AsyncBufReadExt, AsyncRead, AsyncReadExt, AsyncWriteExt, BufReader};
use tokio::process::{Child, ChildStderr, ChildStdin, ChildStdout, Command};
use tokio::sync::mpsc;
use tokio::task::JoinHandle;

use super::checking::Label;
use super::protocol::{Delivered, FileLength, Lengths, Message};
use crate::config::Config;
use crate::job::life::FailureCode;
use crate::planning::finding::Finding;
use crate::store::attempts::AttemptInput;

/// A line of the child is at most so long.
const LONGEST_LINE: u64 = 16 * 1024 * 1024;

/// An answer is at most so long in all.
const LARGEST_ANSWER: u64 = 512 * 1024 * 1024;

/// So much of what the child says on standard error is kept for the log.
const KEPT_WORDS: usize = 4096;

/// Stages that may be outstanding.
const OUTSTANDING: usize = 64;

/// The signal of a process that has used up its processor time.
const SIGXCPU: i32 = 24;

/// What is heard from a child.
#[derive(Debug)]
pub enum Heard {
    /// A stage begins, so many seconds after the child began.
    Stage(String, f64),
    /// The child says no more.
    Last(Last),
}

/// The last that is heard.
#[derive(Debug)]
pub enum Last {
    /// An answer, complete.
    Answer {
        /// Seconds since the child began.
        at_s: f64,
        /// Its parts.
        parts: Vec<Delivered>,
    },
    /// The document is invalid.
    Faults(Vec<Finding>),
    /// The document was checked and has no faults.
    Sound(Label),
    /// An answer larger than is kept.
    TooLarge,
    /// Nothing complete: the exit tells more.
    Silence,
}

/// Why a child ended without an answer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Cause {
    /// Another attempt would end the same way.
    Final(FailureCode, String),
    /// Something from outside; another attempt may do better.
    Passing(String),
}

/// What a child does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Task {
    /// Checks the document and ends.
    Check,
    /// Plans.
    Plan,
}

/// A child that plans.
#[derive(Debug)]
pub struct Planner {
    child: Child,
    heard: mpsc::Receiver<Heard>,
    words: JoinHandle<String>,
}

impl Planner {
    /// Starts a child on this input.
    ///
    /// # Errors
    /// If the system starts no process.
    pub fn start(config: &Config, task: Task, input: AttemptInput) -> std::io::Result<Self> {
        let mut child = command(config, task).spawn()?;
        let (stdin, stdout, stderr) = (child.stdin.take(), child.stdout.take(), child.stderr.take());
        let (Some(stdin), Some(stdout), Some(stderr)) = (stdin, stdout, stderr) else {
            return Err(std::io::Error::other("the child has no streams"));
        };
        let (sender, heard) = mpsc::channel(OUTSTANDING);
        tokio::spawn(tell(stdin, input));
        tokio::spawn(listen(stdout, sender));
        Ok(Self { child, heard, words: tokio::spawn(last_words(stderr)) })
    }

    /// Waits for what the child says next.
    pub async fn hear(&mut self) -> Heard {
        self.heard.recv().await.unwrap_or(Heard::Last(Last::Silence))
    }

    /// Ends the child now, if it has not ended.
    pub async fn kill(mut self) {
        // It may have ended by itself.
        let _ = self.child.kill().await;
    }

    /// Waits for the end of a child that says no more, and tells why it ended.
    pub async fn cause(mut self) -> Cause {
        let status = self.child.wait().await;
        let words = self.words.await.unwrap_or_default();
        match status {
            Ok(status) => cause(status, &words),
            Err(error) => Cause::Passing(format!("its end could not be told: {error}")),
        }
    }
}

fn command(config: &Config, task: Task) -> Command {
    // The very file that runs, even if another version was installed over it in the meantime.
    let mut command = Command::new("/proc/self/exe");
    command
        .arg0("bladeplan")
        .arg("attempt")
        .args(["--memory-mib", &config.attempt_memory_mib.to_string()])
        .args(["--cpu-s", &config.attempt_cpu_s.to_string()])
        .args(["--parent", &std::process::id().to_string()])
        .args((task == Task::Check).then_some("--check"))
        .args((task == Task::Plan && config.pause_attempts).then_some("--pause"))
        .env_clear()
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        // Ctrl-C in a terminal is for the service, which then ends its attempts in order.
        .process_group(0)
        .kill_on_drop(true);
    command
}

/// Sends everything. A child that ended early is noticed by its exit.
async fn tell(mut stdin: ChildStdin, input: AttemptInput) {
    let Ok(head) = head(&input) else { return };
    for piece in [head.as_bytes(), &input.body].into_iter().chain(input.files.iter().map(|(_, body)| body)) {
        if stdin.write_all(piece).await.is_err() {
            return;
        }
    }
}

/// The two lines before the document.
fn head(input: &AttemptInput) -> serde_json::Result<String> {
    let file = |(name, body): (&str, &[u8])| FileLength { name: name.to_owned(), bytes: body.len() as u64 };
    let lengths =
        Lengths { document: input.body.len() as u64, files: input.files.iter().map(file).collect() };
    Ok(format!("{}\n{}\n", input.machines.replace('\n', " "), serde_json::to_string(&lengths)?))
}

async fn listen(stdout: ChildStdout, sender: mpsc::Sender<Heard>) {
    let mut reader = BufReader::new(stdout);
    let last = loop {
        match next(&mut reader).await {
            Some(Message::Stage { name, at_s }) => {
                if sender.send(Heard::Stage(name, at_s)).await.is_err() {
                    return;
                }
            }
            Some(Message::Faults(findings)) => break Last::Faults(findings),
            Some(Message::Sound(label)) => break Last::Sound(label),
            Some(Message::Answer { at_s, parts }) => {
                break if parts.iter().map(|part| part.bytes).sum::<u64>() > LARGEST_ANSWER {
                    Last::TooLarge
                } else {
                    collect(&mut reader, at_s, parts).await.unwrap_or(Last::Silence)
                };
            }
            None => break Last::Silence,
        }
    };
    let _ = sender.send(Heard::Last(last)).await;
}

async fn next(reader: &mut BufReader<ChildStdout>) -> Option<Message> {
    let mut line = Vec::new();
    reader.take(LONGEST_LINE).read_until(b'\n', &mut line).await.ok()?;
    serde_json::from_slice(&line).ok()
}

async fn collect(
    reader: &mut (impl AsyncRead + Unpin),
    at_s: f64,
    parts: Vec<super::protocol::Part>,
) -> Option<Last> {
    let mut delivered = Vec::with_capacity(parts.len());
    for part in parts {
        let mut body = vec![0; usize::try_from(part.bytes).ok()?];
        reader.read_exact(&mut body).await.ok()?;
        delivered.push(Delivered { part, body });
    }
    Some(Last::Answer { at_s, parts: delivered })
}

/// Reads everything, so that the child never waits, and keeps the end.
async fn last_words(mut stderr: ChildStderr) -> String {
    let mut kept = Vec::new();
    let mut piece = [0; 4096];
    while let Ok(count @ 1..) = stderr.read(&mut piece).await {
        kept.extend_from_slice(&piece[..count]);
        kept.drain(..kept.len().saturating_sub(KEPT_WORDS));
    }
    String::from_utf8_lossy(&kept).into_owned()
}

fn cause(status: ExitStatus, words: &str) -> Cause {
    if !status.success() {
        tracing::warn!(%status, words, "a planning attempt ended without an answer");
    }
    // The allocator's last words, and the system's where a thread got no stack.
    if words.contains("memory allocation of") || words.contains("Cannot allocate memory") {
        let detail = "the attempt needed more memory than it may have; thin out the points or split the ply";
        return Cause::Final(FailureCode::MemoryLimit, detail.to_owned());
    }
    let crashed = || {
        let detail =
            "the planner stopped in the middle, which is a defect of bladeplan: please report the job";
        Cause::Final(FailureCode::Crashed, detail.to_owned())
    };
    match (status.signal(), status.code()) {
        (Some(SIGXCPU), _) => {
            let detail = "the attempt needed more processor time than it may have; split the ply";
            Cause::Final(FailureCode::CpuLimit, detail.to_owned())
        }
        (Some(signal), _) if FATAL_TO_ITSELF.contains(&signal) => crashed(),
        (Some(signal), _) => Cause::Passing(format!("it was killed by signal {signal}")),
        (None, Some(PANICKED)) => crashed(),
        (None, code) => Cause::Passing(format!("it ended with exit code {}", code.unwrap_or_default())),
    }
}

/// The exit code of a Rust program that has panicked.
const PANICKED: i32 = 101;

/// SIGILL, SIGTRAP, SIGABRT, SIGBUS, SIGFPE, SIGSEGV, SIGSYS: signals that a process brings upon itself.
const FATAL_TO_ITSELF: [i32; 7] = [4, 5, 6, 7, 8, 11, 31];

#[cfg(test)]
mod tests {
    use super::*;

    /// A wait status as the kernel gives it: the signal in the low bits, the exit code above.
    fn status(signal: i32, code: i32) -> ExitStatus {
        ExitStatus::from_raw(signal | (code << 8))
    }

    #[test]
    fn each_end_has_its_cause() {
        let code = |status, words| match cause(status, words) {
            Cause::Final(code, _) => Some(code),
            Cause::Passing(_) => None,
        };
        assert_eq!(
            code(status(6, 0), "memory allocation of 96 bytes failed"),
            Some(FailureCode::MemoryLimit)
        );
        assert_eq!(code(status(6, 0), "thread 'main' has overflowed its stack"), Some(FailureCode::Crashed));
        assert_eq!(code(status(24, 0), ""), Some(FailureCode::CpuLimit));
        assert_eq!(code(status(11, 0), ""), Some(FailureCode::Crashed));
        assert_eq!(code(status(0, 101), "panicked at"), Some(FailureCode::Crashed));
        assert_eq!(code(status(9, 0), ""), None, "the system or a person may kill any process");
        assert_eq!(code(status(15, 0), ""), None);
    }
}
