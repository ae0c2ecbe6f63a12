//! The shop floor's side of the demonstration: keys, approval, the queue and the machine.

use std::path::Path;
use std::process::Command;

use bladeplan::planning::outcome::sha256_hex;
use serde_json::{Value, json};

use super::{Caller, Fallible, Program};

/// The machine that cuts.
pub const MACHINE: &str = "cutter-1";

/// Makes a key, as an administrator at the console does, beside the running service.
pub fn make_key(
    bladeplan: &Path,
    database: &Path,
    role: &str,
    name: &str,
    machine: Option<&str>,
) -> Fallible<String> {
    let mut command = Command::new(bladeplan);
    command.args(["key", "create", "--role", role, "--name", name, "--database"]).arg(database);
    if let Some(machine) = machine {
        command.args(["--machine", machine]);
    }
    let output = command.output()?;
    if !output.status.success() {
        return Err(String::from_utf8_lossy(&output.stderr).into_owned().into());
    }
    Ok(String::from_utf8(output.stdout)?.trim().to_owned())
}

/// Registers the machine with the built-in profile under its own name.
pub fn register(admin: &Caller) -> Fallible<()> {
    let mut registration: Value = serde_json::from_str(include_str!("../../two-cutter-lab.machine.json"))?;
    registration["profile"]["name"] = json!(MACHINE);
    admin.send("POST", "/v1/machines", 201, &registration)?;
    println!("registered {MACHINE}");
    Ok(())
}

/// Approves the bytes that were fetched and replayed, and no others.
pub fn approve(approver: &Caller, program_id: &str, program: &Program) -> Fallible<()> {
    let body = json!({"sha256": sha256_hex(&program.bytes)});
    approver.send("PUT", &format!("/v1/programs/{program_id}/approval"), 200, &body)?;
    println!("approved {program_id} by its hash");
    Ok(())
}

/// Puts one unit of the program into the machine's queue.
pub fn queue(mes: &Caller, program_id: &str) -> Fallible<()> {
    let body = json!({"program": program_id, "quantity": 1});
    let entry = mes.send("POST", &format!("/v1/queues/{MACHINE}/entries"), 201, &body)?;
    println!("queued one unit as {}", entry["id"].as_str().unwrap_or_default());
    Ok(())
}

/// Claims the unit, fetches and acknowledges its bytes, starts, says that it lives, and reports the end. The
/// claim is sent twice, as after a lost answer: it gives the same run.
pub fn cut(machine: &Caller, program: &Program) -> Fallible<()> {
    let claims = format!("/v1/machines/{MACHINE}/runs");
    let claim = json!({"request_id": "shift-1-unit-1"});
    let run = machine.send("POST", &claims, 201, &claim)?;
    let again = machine.send("POST", &claims, 200, &claim)?;
    let (Some(id), Some(fence)) = (run["id"].as_str(), run["fence"].as_i64()) else {
        return Err(format!("the claim gave no run: {run}").into());
    };
    if again["id"] != run["id"] {
        return Err("a repeated claim gave another run".into());
    }
    println!("claimed {id}");
    let bytes = machine.bytes(&format!("/v1/runs/{id}/content?fence={fence}"))?;
    if bytes != program.bytes {
        return Err("the machine was given other bytes than were approved".into());
    }
    let put = |what: &str, body: Value| machine.send("PUT", &format!("/v1/runs/{id}/{what}"), 200, &body);
    put("receipt", json!({"fence": fence, "sha256": sha256_hex(&bytes), "size": bytes.len()}))?;
    put("start", json!({"fence": fence}))?;
    put("heartbeat", json!({"fence": fence}))?;
    let lots =
        json!({"fence": fence, "outcome": "done", "prepreg_lot": "L-9", "spool": "S-1", "cassette": "C-4"});
    let done = put("result", lots)?;
    println!("received, started, {}", done["state"].as_str().unwrap_or_default());
    Ok(())
}
