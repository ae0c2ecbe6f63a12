//! The whole way of a ply: starts the service on a free loopback port with a store of its own; as an MES posts the
//! example ply, follows it, fetches the program, verifies its hash and replays it; as an approver approves the
//! program, as the MES queues it; as a machine claims, receives, starts and finishes it. Everybody has a key of their own.
//! Request, program, report and drawings are left in `demo-out/`. `make demo` runs it.

mod floor;

use std::error::Error;
use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdout, Command, ExitCode, Stdio};
use std::time::{Duration, Instant};

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use bladeplan::planning::attempt::check;
use bladeplan::planning::budget::Budget;
use bladeplan::planning::document;
use bladeplan::planning::document::files::Files;
use bladeplan::planning::finding::any_error;
use bladeplan::planning::outcome::ProgramFile;
use bladeplan::planning::outcome::sha256_hex;
use bladeplan::planning::tape::machine::Catalogue;
use reqwest::blocking::{Client, Response};
use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;
use sha2::{Digest, Sha256};

type Fallible<T> = Result<T, Box<dyn Error>>;

/// The ply that is posted.
const JOB: &str = "examples/wing-skin-trapezoid-45.job.json";

/// Where everything is left.
const OUT: &str = "demo-out";

/// No request of this demonstration takes longer.
const PATIENCE: Duration = Duration::from_secs(60);

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("the demonstration failed: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Fallible<()> {
    let started = Instant::now();
    let home = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
    let request = fs::read(home.join(JOB)).map_err(|error| format!("{JOB}: {error}"))?;
    let store = tempfile::tempdir()?;
    let database = store.path().join("demo.db");
    let service = Service::start(&database)?;
    let client = Client::builder().no_proxy().timeout(PATIENCE).build()?;
    let caller = |role: &str, name: &str, machine: Option<&str>| -> Fallible<Caller> {
        let key = floor::make_key(&beside_this_one()?, &database, role, name, machine)?;
        Ok(Caller { client: client.clone(), address: service.address.clone(), key })
    };
    let mes = caller("mes", "mes-1", None)?;

    let id = mes.post(&request)?;
    mes.follow(&id)?;
    let job = mes.json(&format!("/v1/jobs/{id}"))?;
    let Some(program_id) = job["program"].as_str() else {
        return Err(format!("the job gave no program: {job}").into());
    };
    let program = mes.fetch(program_id)?;
    let report = mes.bytes(&format!("/v1/jobs/{id}/report"))?;
    let drawings = mes.drawings(&id, &job)?;
    let replayed = replay(&request, &program)?;

    floor::register(&caller("admin", "anna", None)?)?;
    floor::approve(&caller("approver", "erik", None)?, program_id, &program)?;
    floor::queue(&mes, program_id)?;
    floor::cut(&caller("machine", floor::MACHINE, Some(floor::MACHINE))?, &program)?;

    let out = home.join(OUT);
    leave(&out, &request, &program, &report, &drawings)?;
    print_table(&serde_json::from_slice(&report)?, &request, &program, &report, &replayed)?;
    service.end()?;
    println!("\nEverything lies in {OUT}/. It took {:.1} s.", started.elapsed().as_secs_f64());
    Ok(())
}

/// The service, as a process of its own. It ends with this one.
struct Service {
    child: Child,
    address: String,
    /// Kept open: the service may want to say more.
    _stdout: BufReader<ChildStdout>,
}

impl Service {
    fn start(database: &Path) -> Fallible<Self> {
        let program = beside_this_one()?;
        let mut child = Command::new(&program)
            .args(["serve", "--listen", "127.0.0.1:0", "--log", "warn", "--database"])
            .arg(database)
            .stdout(Stdio::piped())
            .spawn()
            .map_err(|error| format!("cannot start {}: {error}; build it first", program.display()))?;
        let mut stdout = BufReader::new(child.stdout.take().ok_or("the service has no standard output")?);
        let mut first = String::new();
        stdout.read_line(&mut first)?;
        let address = first.split_whitespace().find(|word| word.starts_with("http://"));
        let Some(address) = address.map(str::to_owned) else {
            child.kill()?;
            return Err("the service did not start".into());
        };
        println!("the service listens on {address}");
        Ok(Self { child, address, _stdout: stdout })
    }

    fn end(mut self) -> Fallible<()> {
        let pid = i32::try_from(self.child.id()).ok().and_then(Pid::from_raw).ok_or("no process id")?;
        kill_process(pid, Signal::TERM)?;
        let status = self.child.wait()?;
        if status.success() { Ok(()) } else { Err(format!("the service ended with {status}").into()) }
    }
}

impl Drop for Service {
    fn drop(&mut self) {
        // It has ended already, unless the demonstration failed in the middle.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// `target/PROFILE/bladeplan`, beside `target/PROFILE/bladeplan-demo`.
fn beside_this_one() -> Fallible<PathBuf> {
    let this = std::env::current_exe()?;
    let profile = this.parent().ok_or("this program lies nowhere")?;
    Ok(profile.join("bladeplan"))
}

/// Somebody who calls the service with a key of their own: nothing but HTTP.
struct Caller {
    client: Client,
    address: String,
    key: String,
}

/// A fetched program.
struct Program {
    name: String,
    bytes: Vec<u8>,
}

impl Caller {
    fn post(&self, request: &[u8]) -> Fallible<String> {
        let response = self
            .client
            .post(format!("{}/v1/jobs", self.address))
            .bearer_auth(&self.key)
            .header("content-type", "application/json")
            .header("idempotency-key", "demo-1")
            .body(request.to_vec())
            .send()?;
        let job: Value = expect(202, response)?.json()?;
        let id = job["id"].as_str().ok_or("the answer has no id")?.to_owned();
        println!("posted {JOB} as {id}");
        Ok(id)
    }

    /// Prints the events of a job until it has ended.
    fn follow(&self, id: &str) -> Fallible<()> {
        let response = expect(200, self.get(&format!("/v1/jobs/{id}/events"))?)?;
        for line in BufReader::new(response).lines() {
            let line = line?;
            let Some(data) = line.strip_prefix("data:") else { continue };
            let event: Value = serde_json::from_str(data)?;
            let (state, stage) = (event["state"].as_str(), event["stage"].as_str());
            println!(
                "  {} {}",
                event["at"].as_str().unwrap_or_default(),
                state.or(stage).unwrap_or_default()
            );
        }
        Ok(())
    }

    /// Fetches a program in two parts, as after a line that broke, and verifies it against its hash.
    fn fetch(&self, id: &str) -> Fallible<Program> {
        let program = self.json(&format!("/v1/programs/{id}"))?;
        let sha256 = program["sha256"].as_str().ok_or("the program has no hash")?;
        let path = format!("{}/v1/programs/{id}/content", self.address);
        let half = program["bytes"].as_u64().ok_or("the program has no length")? / 2;
        let etag = format!("\"{sha256}\"");
        let range = |range: String| {
            let request = self
                .client
                .get(&path)
                .bearer_auth(&self.key)
                .header("range", range)
                .header("if-range", &etag);
            expect(206, request.send()?)
        };
        let mut bytes = range(format!("bytes=0-{}", half - 1))?.bytes()?.to_vec();
        let rest = range(format!("bytes={half}-"))?;
        let digest = rest.headers().get("repr-digest").ok_or("there is no Repr-Digest")?.to_str()?.to_owned();
        bytes.extend_from_slice(&rest.bytes()?);
        let expected = format!("sha-256=:{}:", BASE64_STANDARD.encode(Sha256::digest(&bytes)));
        if sha256_hex(&bytes) != sha256 || digest != expected {
            return Err(format!("the fetched bytes do not have the hash {sha256}").into());
        }
        println!("fetched {id} in two parts; its hash fits");
        let name = program["name"].as_str().ok_or("the program has no name")?.to_owned();
        Ok(Program { name, bytes })
    }

    fn drawings(&self, id: &str, job: &Value) -> Fallible<Vec<(String, Vec<u8>)>> {
        let names = job["drawings"].as_array().into_iter().flatten().filter_map(Value::as_str);
        names
            .map(|name| Ok((name.to_owned(), self.bytes(&format!("/v1/jobs/{id}/drawings/{name}"))?)))
            .collect()
    }

    fn get(&self, path: &str) -> Fallible<Response> {
        Ok(self.client.get(format!("{}{path}", self.address)).bearer_auth(&self.key).send()?)
    }

    /// Sends JSON and gives back the JSON of the answer.
    fn send(&self, method: &str, path: &str, status: u16, body: &Value) -> Fallible<Value> {
        let request = self.client.request(method.parse()?, format!("{}{path}", self.address));
        let response = request
            .bearer_auth(&self.key)
            .header("content-type", "application/json")
            .body(body.to_string())
            .send()?;
        Ok(serde_json::from_str(&expect(status, response)?.text()?)?)
    }

    fn bytes(&self, path: &str) -> Fallible<Vec<u8>> {
        Ok(expect(200, self.get(path)?)?.bytes()?.to_vec())
    }

    fn json(&self, path: &str) -> Fallible<Value> {
        Ok(serde_json::from_slice(&self.bytes(path)?)?)
    }
}

fn expect(status: u16, mut response: Response) -> Fallible<Response> {
    if response.status().as_u16() == status {
        return Ok(response);
    }
    let mut words = String::new();
    response.read_to_string(&mut words)?;
    Err(format!("{} answered {}: {words}", response.url(), response.status()).into())
}

/// Reads the fetched program back and lays its cuts against those that the posted job wants.
fn replay(request: &[u8], program: &Program) -> Fallible<String> {
    let words = |faults: Vec<_>| format!("the job has {} faults", faults.len());
    let job = document::read(request).map_err(words)?;
    let text = std::str::from_utf8(&program.bytes)?.to_owned();
    let file = ProgramFile { name: program.name.clone(), dialect: "linuxcnc", text };
    let (figures, findings) =
        check(&job, &Files::default(), &Catalogue::built_in(), &[file], &Budget::unwatched())
            .map_err(words)?;
    if any_error(&findings) {
        return Err(format!("the replay found faults: {findings:?}").into());
    }
    Ok(figures)
}

fn leave(
    out: &Path,
    request: &[u8],
    program: &Program,
    report: &[u8],
    drawings: &[(String, Vec<u8>)],
) -> Fallible<()> {
    fs::create_dir_all(out)?;
    fs::write(out.join("request.json"), request)?;
    fs::write(out.join(&program.name), &program.bytes)?;
    fs::write(out.join("report.json"), report)?;
    for (name, drawing) in drawings {
        fs::write(out.join(name), drawing)?;
    }
    Ok(())
}

fn print_table(
    report: &Value,
    request: &[u8],
    program: &Program,
    report_text: &[u8],
    replayed: &str,
) -> Fallible<()> {
    let number = |at: &str| {
        report.pointer(at).and_then(Value::as_f64).ok_or_else(|| format!("the report has no {at}"))
    };
    let courses = report["courses"].as_array().ok_or("the report has no courses")?;
    let pieces: usize = courses.iter().filter_map(|course| course["pieces"].as_array()).map(Vec::len).sum();
    let (time_s, scrap) = (number("/time_s")?, number("/roll/scrap_area_mm2")?);
    let used = scrap + number("/roll/piece_area_mm2")?;
    let rows = [
        ("courses", courses.len().to_string()),
        ("pieces", pieces.to_string()),
        ("tape used", format!("{:.3} m", number("/roll/tape_used_mm")? / 1e3)),
        ("scrap", format!("{:.4} m2, {:.2} % of the tape", scrap / 1e6, scrap / used * 100.0)),
        ("cycle time", format!("{} min {:.1} s", (time_s / 60.0).floor(), time_s % 60.0)),
        ("largest deviation", format!("{:.4} mm", number("/replay/max_deviation_mm")?)),
        ("replayed here", replayed.to_owned()),
        ("request sha256", sha256_hex(request)),
        ("program sha256", sha256_hex(&program.bytes)),
        ("report sha256", sha256_hex(report_text)),
    ];
    println!();
    for (name, value) in rows {
        println!("{name:<18} {value}");
    }
    Ok(())
}
