//! The interpreter's process: one for all tests of a run, asked and answered in lines of JSON.

use std::io::{self, BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::{Mutex, PoisonError};

use bladeplan::planning::program::events::Positions;
use serde::Deserialize;

use super::{Call, CanonEvent, FeedMode, InterpreterError};

static SHARED: Mutex<Option<Interpreter>> = Mutex::new(None);

/// Runs a program on a control with nine axes and says what it would do.
///
/// # Errors
/// What the interpreter refuses, with its line.
///
/// # Panics
/// If there is no interpreter: a comparison that did not take place must not look like one that passed.
pub fn interpret(program: &str) -> Result<Vec<CanonEvent>, InterpreterError> {
    // Taken out while it is at work, so that one which fails is not used again.
    let mut shared = SHARED.lock().unwrap_or_else(PoisonError::into_inner);
    let mut interpreter = shared.take().unwrap_or_else(|| Interpreter::start(&launcher()));
    let answer =
        interpreter.ask(program).unwrap_or_else(|error| panic!("LinuxCNC's interpreter failed: {error}"));
    *shared = Some(interpreter);
    match answer.error {
        Some(error) => Err(error),
        None => Ok(answer.events.into_iter().map(CanonEvent::from).collect()),
    }
}

fn launcher() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("target/linuxcnc/interpreter")
}

struct Interpreter {
    _process: Child,
    requests: ChildStdin,
    answers: BufReader<ChildStdout>,
}

impl Interpreter {
    fn start(launcher: &Path) -> Self {
        let mut process = Command::new(launcher)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap_or_else(|error| panic!("{}", missing(launcher, &error)));
        let requests = process.stdin.take().expect("standard input is piped");
        let answers = process.stdout.take().expect("standard output is piped");
        Self { _process: process, requests, answers: BufReader::new(answers) }
    }

    fn ask(&mut self, program: &str) -> io::Result<Answer> {
        let mut request = serde_json::to_string(program)?;
        request.push('\n');
        self.requests.write_all(request.as_bytes())?;
        let mut answer = String::new();
        if self.answers.read_line(&mut answer)? == 0 {
            return Err(io::Error::new(io::ErrorKind::UnexpectedEof, "it ended without an answer"));
        }
        Ok(serde_json::from_str(&answer)?)
    }
}

fn missing(launcher: &Path, error: &io::Error) -> String {
    format!(
        "LinuxCNC's interpreter cannot be started ({}: {error}). `make test` prepares it, \
         and so does tests/linuxcnc/prepare alone.",
        launcher.display()
    )
}

/// What the driver answers (tests/linuxcnc/driver.py).
#[derive(Deserialize)]
struct Answer {
    error: Option<InterpreterError>,
    events: Vec<WireEvent>,
}

#[derive(Deserialize)]
struct WireEvent {
    line: usize,
    call: String,
    to: Option<Positions>,
    rate: Option<f64>,
    mode: Option<FeedMode>,
    seconds: Option<f64>,
    number: Option<u32>,
}

impl From<WireEvent> for CanonEvent {
    fn from(event: WireEvent) -> Self {
        let line = event.line;
        Self { line, call: event.call() }
    }
}

impl WireEvent {
    fn call(self) -> Call {
        let known = match self.call.as_str() {
            "rapid" => self.to.map(|to| Call::Rapid { to }),
            "feed" => self.feed(),
            "dwell" => self.seconds.map(|seconds| Call::Dwell { seconds }),
            "output_on" => self.output(true, false),
            "output_off" => self.output(false, false),
            "output_on_with_motion" => self.output(true, true),
            "output_off_with_motion" => self.output(false, true),
            "optional_stop" => Some(Call::OptionalStop),
            "end" => Some(Call::End),
            _ => None,
        };
        known.unwrap_or(Call::Foreign(self.call))
    }

    fn feed(&self) -> Option<Call> {
        Some(Call::Feed { to: self.to?, rate: self.rate?, mode: self.mode? })
    }

    fn output(&self, on: bool, with_motion: bool) -> Option<Call> {
        self.number.map(|number| Call::Output { number, on, with_motion })
    }
}

#[test]
#[should_panic(expected = "`make test` prepares it")]
fn without_the_interpreter_the_tests_fail_and_say_what_prepares_it() {
    Interpreter::start(Path::new("/nowhere/interpreter"));
}
