//! The built program, serving on a free loopback port from a folder of its own.

use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::Arc;
use std::time::{Duration, Instant};

use reqwest::blocking::multipart::{Form, Part};
use reqwest::blocking::{Client, RequestBuilder, Response};
use rustix::process::{Pid, Signal, kill_process};
use serde_json::{Value, json};
use tempfile::TempDir;

/// Nothing here takes longer, unless it hangs: a test that waits so long has failed, on the slowest machine too.
pub const PATIENCE: Duration = Duration::from_secs(300);

/// A service with this flag has every attempt stop before it begins, so that a test finds it there however fast or
/// slow the machine is.
pub const PAUSED: &str = "--pause-attempts";

/// A running service. It is killed when it is dropped.
pub struct Served {
    child: Child,
    address: String,
    folder: Arc<TempDir>,
    client: Client,
}

impl Served {
    /// Starts a service with an empty store.
    pub fn start(flags: &[&str]) -> Self {
        Self::start_in(Arc::new(TempDir::new().unwrap()), flags)
    }

    /// Starts a service with the store of a folder.
    pub fn start_in(folder: Arc<TempDir>, flags: &[&str]) -> Self {
        let mut child = command(folder.path(), flags).spawn().unwrap();
        let mut first = String::new();
        let stdout = child.stdout.take().unwrap();
        BufReader::new(stdout).read_line(&mut first).unwrap();
        let address = first.split_whitespace().find(|word| word.starts_with("http://"));
        let Some(address) = address.map(str::to_owned) else {
            let mut words = String::new();
            child.stderr.take().unwrap().read_to_string(&mut words).unwrap();
            panic!("the service did not start: {first}{words}");
        };
        // The service closes a connection that was idle for a while, perhaps just when it would be used again.
        let client = Client::builder().no_proxy().timeout(PATIENCE).pool_max_idle_per_host(0);
        Self { child, address, folder, client: client.build().unwrap() }
    }

    /// The folder of its store.
    pub fn folder(&self) -> Arc<TempDir> {
        Arc::clone(&self.folder)
    }

    /// Its database file.
    pub fn database(&self) -> PathBuf {
        self.folder.path().join("bladeplan.db")
    }

    /// Host and port.
    pub fn host(&self) -> &str {
        self.address.trim_start_matches("http://")
    }

    pub fn get(&self, path: &str) -> RequestBuilder {
        self.client.get(format!("{}{path}", self.address))
    }

    pub fn put(&self, path: &str) -> RequestBuilder {
        self.client.put(format!("{}{path}", self.address))
    }

    /// A request with a method of its own, a JSON body if there is one, and a key if there is one.
    pub fn call(&self, method: &str, path: &str, body: Option<&Value>, key: Option<&str>) -> (u16, Value) {
        let method = method.parse().unwrap();
        let mut request = self.client.request(method, format!("{}{path}", self.address));
        if let Some(body) = body {
            request = request.header("content-type", "application/json").body(body.to_string());
        }
        if let Some(key) = key {
            request = request.bearer_auth(key);
        }
        let response = request.send().unwrap();
        let status = response.status().as_u16();
        (status, serde_json::from_str(&response.text().unwrap()).unwrap_or_default())
    }

    /// Makes a key, as an administrator at the console does.
    pub fn key(&self, role: &str, name: &str, machine: Option<&str>) -> String {
        let mut command = Command::new(env!("CARGO_BIN_EXE_bladeplan"));
        command.args(["key", "create", "--role", role, "--name", name, "--database"]).arg(self.database());
        if let Some(machine) = machine {
            command.args(["--machine", machine]);
        }
        let output = command.output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap().trim().to_owned()
    }

    pub fn post(&self, document: &Value) -> RequestBuilder {
        self.post_bytes(document.to_string().into_bytes())
    }

    pub fn post_bytes(&self, body: Vec<u8>) -> RequestBuilder {
        let request = self.client.post(format!("{}/v1/jobs", self.address));
        request.header("content-type", "application/json").body(body)
    }

    /// Posts a document with files, as a form.
    pub fn post_form(&self, form: Form) -> RequestBuilder {
        self.post_form_to("/v1/jobs", form)
    }

    pub fn post_form_to(&self, path: &str, form: Form) -> RequestBuilder {
        self.client.post(format!("{}{path}", self.address)).multipart(form)
    }

    /// The JSON at a path, which must be there.
    pub fn json(&self, path: &str) -> Value {
        let response = self.get(path).send().unwrap();
        assert_eq!(response.status(), 200, "{path}");
        response.json().unwrap()
    }

    /// Posts a document that must be taken in, and gives back the job's id.
    pub fn posted(&self, document: &Value) -> String {
        let response = self.post(document).send().unwrap();
        assert_eq!(response.status(), 202);
        id_of(response)
    }

    /// Waits for the end of a job.
    pub fn ended(&self, id: &str) -> Value {
        let started = Instant::now();
        loop {
            let job = self.json(&format!("/v1/jobs/{id}?wait=30"));
            if job["finished_at"].is_string() {
                return job;
            }
            assert!(started.elapsed() < PATIENCE, "the job does not end: {job}");
        }
    }

    /// Posts a document, waits for its end and gives back its program.
    pub fn program_of(&self, document: &Value) -> String {
        let job = self.ended(&self.posted(document));
        assert_eq!((&job["state"], &job["verdict"]), (&json!("succeeded"), &json!("usable")), "{job}");
        job["program"].as_str().unwrap().to_owned()
    }

    /// What followers of a job are told from an event on, until the stream ends: id, kind and data.
    pub fn events(&self, id: &str, after: Option<i64>) -> Vec<(i64, String, Value)> {
        let mut request = self.get(&format!("/v1/jobs/{id}/events"));
        if let Some(after) = after {
            request = request.header("last-event-id", after);
        }
        request.send().unwrap().text().unwrap().split("\n\n").filter_map(event).collect()
    }

    /// The children of the service that plan now.
    pub fn attempts(&self) -> Vec<i32> {
        let numbers =
            fs::read_dir("/proc").unwrap().filter_map(|entry| entry.ok()?.file_name().into_string().ok());
        let numbers = numbers.filter_map(|name| name.parse::<i32>().ok());
        numbers.filter(|pid| plans_for(*pid, self.child.id()).is_some()).collect()
    }

    /// Waits for an attempt that is none of these and stands still. The service was started with [`PAUSED`].
    pub fn paused_attempt(&self, known: &[i32]) -> i32 {
        let is_new = |pid: &i32| !known.contains(pid) && state(*pid) == Some('T');
        until(|| self.attempts().into_iter().find(is_new))
    }

    /// Ends the service as `kill -9` does.
    pub fn kill(mut self) -> Arc<TempDir> {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
        Arc::clone(&self.folder)
    }

    /// Sends SIGTERM.
    pub fn terminate(&self) {
        signal(i32::try_from(self.child.id()).unwrap(), Signal::TERM);
    }

    /// Waits until the service has ended by itself.
    pub fn exit(mut self) -> (ExitStatus, Arc<TempDir>) {
        let status = until(|| self.child.try_wait().unwrap());
        (status, Arc::clone(&self.folder))
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// The command line of a service with a store in this folder.
pub fn command(folder: &Path, flags: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_bladeplan"));
    command
        .args(["serve", "--listen", "127.0.0.1:0", "--log", "warn"])
        .arg("--database")
        .arg(folder.join("bladeplan.db"))
        .args(flags)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    command
}

/// A form of a document and of files, each under its own file name.
pub fn form(document: &[u8], files: &[(&str, &[u8])]) -> Form {
    let job = Part::bytes(document.to_vec()).mime_str("application/json").unwrap();
    files.iter().fold(Form::new().part("job", job), |form, (name, body)| {
        form.part("file", Part::bytes(body.to_vec()).file_name((*name).to_owned()))
    })
}

/// The id in the answer to a post.
pub fn id_of(response: Response) -> String {
    let body: Value = response.json().unwrap();
    body["id"].as_str().unwrap().to_owned()
}

/// Asks until there is an answer.
pub fn until<T>(mut ask: impl FnMut() -> Option<T>) -> T {
    let started = Instant::now();
    loop {
        if let Some(answer) = ask() {
            return answer;
        }
        assert!(started.elapsed() < PATIENCE, "waited in vain");
        std::thread::yield_now();
    }
}

/// A rectangular ply of one course.
pub fn small_job(name: &str) -> Value {
    ply(name, json!([[0, 0, 0], [400, 0, 0], [400, 80, 0], [0, 80, 0]]), &[40.0])
}

/// A ply whose outline is in a file of this name.
pub fn job_with_a_file(name: &str) -> Value {
    let mut job = small_job("with a file");
    job["input"]["boundary"] = json!({"file": name});
    job
}

/// A ply that needs more knives at one place than there are: valid, but without a usable program.
pub fn unusable_job() -> Value {
    let points = [
        [0, 10, 0],
        [400, 12, 0],
        [400, 30, 0],
        [100, 32, 0],
        [100, 68, 0],
        [400, 70, 0],
        [400, 88, 0],
        [0, 90, 0],
    ];
    ply("unusable", json!(points), &[50.0])
}

/// A ply whose upper edge goes up and down all the time, less and less: to plan it takes work that grows with the
/// square of its points.
pub fn rough_job(points: u32) -> Value {
    let edge = |index: u32| {
        let part = f64::from(index) / f64::from(points);
        let up = if index.is_multiple_of(2) { 1.0 } else { -1.0 };
        [2000.0 * part, 50.0 + 40.0 * (1.0 - part) * up, 0.0]
    };
    let outline: Vec<_> = (0..points).map(edge).chain([[2000.0, -20.0, 0.0], [0.0, -20.0, 0.0]]).collect();
    ply("rough", json!(outline), &[50.0])
}

/// A round ply of so many points.
pub fn large_job(points: u32) -> Value {
    let point = |index: u32| {
        let angle = f64::from(index) / f64::from(points) * std::f64::consts::TAU;
        [2000.0 * angle.cos(), 1000.0 * angle.sin(), 0.0]
    };
    let outline: Vec<_> = (0..points).map(point).collect();
    let courses: Vec<f64> = (0..19).map(|course| f64::from(course) * 100.0 - 900.0).collect();
    ply("large", json!(outline), &courses)
}

fn ply(name: &str, outline: Value, courses_y: &[f64]) -> Value {
    let point = |x: f64, y: f64| json!({"position": [x, y, 0], "normal": [0, 0, 1]});
    let track = |(index, y): (usize, &f64)| json!({"number": index + 1, "points": [point(-2500.0, *y), point(2500.0, *y)]});
    json!({
        "kind": "tape-cut", "name": name, "references": {"work_order": "4711", "part": name},
        "input": {
            "tape": {"width_mm": 100, "thickness_mm": 0.2},
            "boundary": {"points": outline},
            "tracks": courses_y.iter().enumerate().map(track).collect::<Vec<_>>(),
            "machine": "two-cutter-lab"
        }
    })
}

fn event(block: &str) -> Option<(i64, String, Value)> {
    let field = |name: &str| block.lines().find_map(|line| line.strip_prefix(name)).map(str::trim);
    Some((
        field("id:")?.parse().unwrap(),
        field("event:")?.to_owned(),
        serde_json::from_str(field("data:")?).unwrap(),
    ))
}

/// Whether a process is a child of `parent` that has set its limits and plans.
pub fn plans_for(pid: i32, parent: u32) -> Option<()> {
    let text = |file: &str| fs::read_to_string(format!("/proc/{pid}/{file}")).ok();
    let found = text("status")?.lines().find_map(|line| line.strip_prefix("PPid:")?.trim().parse().ok());
    let command = text("cmdline")?;
    let plans = command.contains("\0attempt\0") && !command.contains("\0--check");
    // Before it is the program that it will be, and before its limits are set, it must not be held up.
    let limits = text("limits")?;
    let confined = limits.lines().any(|line| line.starts_with("Max cpu time") && !line.contains("unlimited"));
    (found == Some(parent) && lives(pid) && plans && confined).then_some(())
}

/// Whether a process is there and has not ended; one that nobody has asked for yet has.
pub fn lives(pid: i32) -> bool {
    state(pid).is_some_and(|letter| letter != 'Z')
}

/// The letter of a process's state: T if it was stopped, Z if it has ended and nobody has asked.
fn state(pid: i32) -> Option<char> {
    let status = fs::read_to_string(format!("/proc/{pid}/status")).ok()?;
    status.lines().find_map(|line| line.strip_prefix("State:")?.trim().chars().next())
}

/// Sends a signal to a process, if it has not ended.
pub fn signal(pid: i32, signal: Signal) {
    let _ = kill_process(Pid::from_raw(pid).unwrap(), signal);
}
