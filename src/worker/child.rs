//! The child's side: plans one job within limits that it sets for itself before it reads anything.
//!
//! A panic, an abort or a signal ends this process and nothing else. The child holds no connection, no key and no
//! file but its three standard streams.

use std::io::{self, BufRead, BufWriter, Read, Write};
use std::time::Instant;

use rustix::process::{Pid, Resource, Rlimit, Signal};

use super::checking::Label;
use super::protocol::{Lengths, Message, Part, Role};
use crate::planning::attempt::{plan, validate};
use crate::planning::budget::{Budget, DEFAULT_STEPS};
use crate::planning::catalogue::{Catalogue, Profile};
use crate::planning::document;
use crate::planning::document::files::Files;
use crate::planning::finding::Finding;
use crate::planning::outcome::Outcome;

/// The limits of one attempt.
#[derive(Debug, Clone, Copy, clap::Args)]
pub struct Limits {
    /// Address space in MiB
    #[arg(long)]
    pub memory_mib: u32,
    /// Processor time in seconds
    #[arg(long)]
    pub cpu_s: u32,
    /// The process that asked for the attempt; the attempt ends with it
    #[arg(long)]
    pub parent: i32,
    /// Check the document and plan nothing
    #[arg(long)]
    pub check: bool,
    /// Stop once the limits are set, until SIGCONT comes
    #[arg(long)]
    pub pause: bool,
}

/// The kernel ends a process that has ignored the first signal so many seconds later.
const CPU_GRACE_S: u64 = 5;

/// An attempt yields to the API; a check does not, for somebody waits for it.
const NICE: i32 = 5;

/// Plans the job on standard input.
///
/// # Errors
/// If a limit cannot be set, or the parent cannot be reached any more.
pub fn run(limits: &Limits) -> io::Result<()> {
    confine(limits)?;
    let given = Given::read(&mut io::stdin().lock())?;
    let out = BufWriter::new(io::stdout().lock());
    let attempt = Attempt { started: Instant::now(), out: out.into() };
    if limits.check { attempt.check(&given) } else { attempt.answer(given) }
}

fn confine(limits: &Limits) -> io::Result<()> {
    rustix::process::set_parent_process_death_signal(Some(Signal::KILL))?;
    // The parent may have died before the line above.
    if rustix::process::getppid().map(Pid::as_raw_pid) != Some(limits.parent) {
        return Err(io::Error::other("the process that asked for this attempt is gone"));
    }
    let memory = u64::from(limits.memory_mib) * 1024 * 1024;
    let cpu = u64::from(limits.cpu_s);
    set(Resource::As, memory, memory)?;
    set(Resource::Cpu, cpu, cpu + CPU_GRACE_S)?;
    set(Resource::Core, 0, 0)?;
    if !limits.check {
        // A system that does not let us is no reason not to plan.
        let _ = rustix::process::nice(NICE);
    }
    if limits.pause {
        rustix::process::kill_process(rustix::process::getpid(), Signal::STOP)?;
    }
    Ok(())
}

fn set(resource: Resource, current: u64, maximum: u64) -> io::Result<()> {
    let limit = Rlimit { current: Some(current), maximum: Some(maximum) };
    Ok(rustix::process::setrlimit(resource, limit)?)
}

/// What the service has sent.
struct Given {
    machines: Vec<u8>,
    document: Vec<u8>,
    files: Files,
}

impl Given {
    /// Reads it. The service is trusted to send what it announces; if it ends before, so does this process.
    fn read(reader: &mut impl BufRead) -> io::Result<Self> {
        let machines = line(reader)?;
        let lengths: Lengths = serde_json::from_slice(&line(reader)?)?;
        let document = exactly(reader, lengths.document)?;
        let mut files = Files::default();
        for file in lengths.files {
            let body = exactly(reader, file.bytes)?;
            files.insert(file.name, body).map_err(io::Error::other)?;
        }
        Ok(Self { machines, document, files })
    }
}

fn line(reader: &mut impl BufRead) -> io::Result<Vec<u8>> {
    let mut line = Vec::new();
    reader.read_until(b'\n', &mut line)?;
    Ok(line)
}

fn exactly(reader: &mut impl Read, bytes: u64) -> io::Result<Vec<u8>> {
    let mut body = vec![0; usize::try_from(bytes).map_err(io::Error::other)?];
    reader.read_exact(&mut body)?;
    Ok(body)
}

struct Attempt<W: Write> {
    started: Instant,
    out: std::cell::RefCell<W>,
}

impl<W: Write> Attempt<W> {
    fn answer(self, given: Given) -> io::Result<()> {
        match self.plan(given) {
            Ok(outcome) => self.deliver(&outcome),
            Err(faults) => self.say(&Message::Faults(faults)),
        }
    }

    fn check(self, given: &Given) -> io::Result<()> {
        self.say(&match checked(given) {
            Ok(label) => Message::Sound(label),
            Err(faults) => Message::Faults(faults),
        })
    }

    fn plan(&self, given: Given) -> Result<Outcome, Vec<Finding>> {
        let catalogue = catalogue(&given.machines)?;
        let Given { document: text, files, .. } = given;
        let document = document::read(&text)?;
        // A large ply is large, and not needed as text any more.
        drop(text);
        let on_stage = |name: &'static str| {
            let message = Message::Stage { name: name.to_owned(), at_s: self.seconds() };
            // A parent that is gone ends this process by a signal.
            let _ = self.say(&message);
        };
        let never = std::sync::atomic::AtomicBool::new(false);
        let budget = Budget::new(DEFAULT_STEPS, &never, &on_stage);
        plan(&document, &files, &catalogue, &budget)
    }

    fn deliver(&self, outcome: &Outcome) -> io::Result<()> {
        let report = outcome.report.text();
        let mut parts = vec![(Role::Report, "report.json", "", report.as_bytes())];
        for drawing in &outcome.drawings {
            parts.push((Role::Drawing, &drawing.name, "", drawing.svg.as_bytes()));
        }
        for attachment in &outcome.attachments {
            parts.push((Role::Drawing, &attachment.name, "", attachment.text.as_bytes()));
        }
        for file in &outcome.programs {
            parts.push((Role::Program, &file.name, file.dialect, file.text.as_bytes()));
        }
        let part = |(role, name, dialect, body): &(Role, &str, &str, &[u8])| Part {
            role: *role,
            name: (*name).to_owned(),
            dialect: (*dialect).to_owned(),
            bytes: body.len() as u64,
        };
        self.say(&Message::Answer { at_s: self.seconds(), parts: parts.iter().map(part).collect() })?;
        let mut out = self.out.borrow_mut();
        for (_, _, _, body) in &parts {
            out.write_all(body)?;
        }
        out.flush()
    }

    fn say(&self, message: &Message) -> io::Result<()> {
        let mut out = self.out.borrow_mut();
        serde_json::to_writer(&mut *out, message)?;
        out.write_all(b"\n")?;
        out.flush()
    }

    fn seconds(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }
}

fn checked(given: &Given) -> Result<Label, Vec<Finding>> {
    let document = document::read(&given.document)?;
    validate(&document, &given.files, &catalogue(&given.machines)?)?;
    let kind = document.input.kind().to_owned();
    Ok(Label { kind, name: document.name, references: document.references })
}

/// The machines that the document can name: the built-in ones and those that were frozen with it.
fn catalogue(machines: &[u8]) -> Result<Catalogue, Vec<Finding>> {
    use crate::planning::finding::Code;
    let frozen: Vec<Profile> = serde_json::from_slice(machines)
        .map_err(|error| vec![Finding::error(Code::UnknownMachine, "/input/machine", error.to_string())])?;
    let mut catalogue = Catalogue::built_in();
    frozen.into_iter().for_each(|profile| catalogue.insert(profile));
    Ok(catalogue)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn given(text: &str) -> io::Result<Given> {
        Given::read(&mut text.as_bytes())
    }

    #[test]
    fn a_document_with_faults_is_answered_with_its_faults() {
        let out = std::cell::RefCell::new(Vec::new());
        let attempt = Attempt { started: Instant::now(), out };
        let document = "{\"kind\": \"tape-cut\"}";
        let given = given(&format!("[]\n{{\"document\": {}, \"files\": []}}\n{document}", document.len()));
        assert_eq!(attempt.plan(given.unwrap()).unwrap_err()[0].at, "/input");
    }

    #[test]
    fn document_and_files_are_taken_apart_by_their_lengths_alone() {
        let lengths = r#"{"document": 4, "files": [{"name": "b", "bytes": 3}, {"name": "a", "bytes": 0}]}"#;
        let read = given(&format!("[1]\n{lengths}\n{{\n\n}}\n\n\n")).unwrap();
        assert_eq!((read.machines.trim_ascii(), read.document.as_slice()), (&b"[1]"[..], &b"{\n\n}"[..]));
        assert_eq!(read.files.iter().collect::<Vec<_>>(), [("a", &b""[..]), ("b", b"\n\n\n")]);
        for cut_short in ["", "[]\n", "[]\n{\"document\": 2, \"files\": []}\n{"] {
            assert!(given(cut_short).is_err(), "{cut_short:?}");
        }
        assert!(given("[]\n{\"document\": 0, \"files\": [{\"name\": \"../a\", \"bytes\": 0}]}\n").is_err());
    }
}
