//! The rules of the house that a compiler does not keep: which room of `src` knows what, and how long a file is.
//! How long a function is, clippy keeps (`clippy::too_many_lines`, with the threshold in `clippy.toml`).

use std::fs;
use std::path::{Path, PathBuf};

use rstest::rstest;

/// A file of `src`: its path below `src` with `/`, and its text.
struct Source {
    path: String,
    text: String,
}

/// A rule, and what it finds wrong with a file.
struct Rule {
    /// The folders or files of `src` that it holds for; empty: all.
    rooms: &'static [&'static str],
    /// What it finds in a text, one by one.
    finds: fn(&str) -> Vec<String>,
}

const RULES: [Rule; 5] = [
    // The core is pure: no clock, file, network, database or thread, and it knows nothing of the shell.
    Rule { rooms: &["planning", "job"], finds: impurities },
    Rule { rooms: &["http", "worker"], finds: databases },
    Rule { rooms: &["store"], finds: http },
    Rule { rooms: &[], finds: length },
    Rule { rooms: &[], finds: silenced_lints },
];

const MOST_LINES: usize = 600;

fn impurities(text: &str) -> Vec<String> {
    let words = ["tokio", "sqlx", "axum"].into_iter().filter(|word| says(text, word)).map(str::to_owned);
    let std = named_below(text, "std")
        .into_iter()
        .filter(|name| ["fs", "net", "env", "time", "thread", "process"].contains(&name.as_str()));
    let shell = named_below(text, "crate").into_iter().filter(|name| {
        // A type or macro at the root of the crate is nobody's room.
        !["planning", "job"].contains(&name.as_str()) && name.starts_with(|c: char| c.is_lowercase())
    });
    words
        .chain(std.map(|name| format!("std::{name}")))
        .chain(shell.map(|name| format!("crate::{name}")))
        .collect()
}

fn databases(text: &str) -> Vec<String> {
    let text = text.to_lowercase();
    ["sqlx", "sqlite", "postgres"].into_iter().filter(|name| text.contains(name)).map(str::to_owned).collect()
}

fn http(text: &str) -> Vec<String> {
    let words = ["axum", "hyper", "reqwest"].into_iter().filter(|word| says(text, word)).map(str::to_owned);
    let rooms =
        ["crate", "super"].into_iter().filter(|root| named_below(text, root).iter().any(|n| n == "http"));
    words.chain(rooms.map(|root| format!("{root}::http"))).collect()
}

fn length(text: &str) -> Vec<String> {
    let lines = text.lines().count();
    if lines > MOST_LINES { vec![format!("{lines} lines")] } else { Vec::new() }
}

fn silenced_lints(text: &str) -> Vec<String> {
    let text: String = text.chars().filter(|c| !c.is_whitespace()).collect();
    ["#[allow(", "#![allow(", ",allow("]
        .into_iter()
        .filter(|start| text.contains(start))
        .map(str::to_owned)
        .collect()
}

/// Whether a word stands in a text, comments included.
fn says(text: &str, word: &str) -> bool {
    text.split(|c: char| !is_name(c)).any(|said| said == word)
}

/// The names that follow `root::`, be it one (`root::name::..`) or a list (`root::{name, name::{..}}`).
fn named_below(text: &str, root: &str) -> Vec<String> {
    let text: String = text.chars().filter(|c| !c.is_whitespace()).collect();
    let root = format!("{root}::");
    let starts = text.match_indices(&root).map(|(at, _)| at);
    // `mystd::` is another word; without spaces, `usestd::` and `pub(crate)usestd::` are not.
    let starts = starts.filter(|&at| {
        let before = &text[..at];
        before.ends_with("use") || before.ends_with("in") || !before.ends_with(is_name)
    });
    starts.flat_map(|at| first_names(&text[at + root.len()..])).collect()
}

fn first_names(text: &str) -> Vec<String> {
    let Some(list) = text.strip_prefix('{') else { return vec![first_name(text)] };
    let mut depth = 1_usize;
    let mut names = vec![first_name(list)];
    for (at, c) in list.char_indices() {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 1 => names.push(first_name(&list[at + 1..])),
            _ => {}
        }
        if depth == 0 {
            break;
        }
    }
    names
}

fn first_name(text: &str) -> String {
    text.chars().take_while(|&c| is_name(c)).collect()
}

fn is_name(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// Everything that breaks a rule, as `path: what`.
fn breaches(sources: &[Source]) -> Vec<String> {
    let mut breaches = Vec::new();
    for Rule { rooms, finds } in &RULES {
        for Source { path, text } in sources.iter().filter(|source| stands_in(&source.path, rooms)) {
            breaches.extend(finds(text).into_iter().map(|what| format!("{path}: {what}")));
        }
    }
    breaches
}

fn stands_in(path: &str, rooms: &[&str]) -> bool {
    let room = path.split('/').next().unwrap_or(path).trim_end_matches(".rs");
    rooms.is_empty() || rooms.contains(&room)
}

fn read(root: &Path, folder: &Path, into: &mut Vec<Source>) {
    let entries = fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    for path in entries.map(|entry| entry.expect("a folder can be listed").path()) {
        if path.is_dir() {
            read(root, &path, into);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let below = path.strip_prefix(root).expect("it was found below the root");
            let text =
                fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
            into.push(Source { path: below.to_string_lossy().replace('\\', "/"), text });
        }
    }
}

fn home() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn every_room_keeps_the_rules() {
    let root = home().join("src");
    let mut sources = Vec::new();
    read(&root, &root, &mut sources);
    assert!(sources.iter().any(|source| source.path == "planning/mod.rs"), "the sources were not found");
    assert_eq!(breaches(&sources), Vec::<String>::new());
}

/// Whoever plans otherwise has programs that LinuxCNC has not read.
#[test]
fn every_test_plans_through_the_comparison_with_linuxcnc() {
    let root = home().join("tests/it");
    let mut sources = Vec::new();
    read(&root, &root, &mut sources);
    let planning = sources
        .iter()
        .filter(|source| named_below(&source.text, "attempt").iter().any(|name| name == "plan"));
    let files: Vec<&str> = planning.map(|source| source.path.as_str()).collect();
    assert_eq!(files, ["linuxcnc/emitted.rs"]);
}

#[test]
fn long_functions_are_clippys_to_refuse() {
    let read = |name| fs::read_to_string(home().join(name)).unwrap();
    assert!(read("Cargo.toml").contains("\ntoo_many_lines = \"deny\"\n"));
    assert!(read("clippy.toml").contains("too-many-lines-threshold = 70\n"));
}

#[rstest]
#[case::word("planning/a.rs", "use tokio::sync::Mutex;", "tokio")]
#[case::comment("planning/tape/a.rs", "//! Run this in axum.", "axum")]
#[case::job("job/mod.rs", "pub type Pool = sqlx::Pool<Any>;", "sqlx")]
#[case::job_file("job.rs", "fn f() { std::process::exit(1) }", "std::process")]
#[case::path("planning/a.rs", "fn f() { ::std::thread::yield_now() }", "std::thread")]
#[case::list("planning/a.rs", "use std::{\n    collections::{BTreeMap, time},\n    env,\n};", "std::env")]
#[case::first_of_list("planning/a.rs", "use std::{fs::File, io};", "std::fs")]
#[case::re_export("planning/a.rs", "pub use std::time::Instant;", "std::time")]
#[case::shell("planning/a.rs", "use crate::store::Store;", "crate::store")]
#[case::shell_in_list("job/a.rs", "use crate::{planning::units::Mm, http};", "crate::http")]
#[case::database("http/v1/jobs.rs", "use crate::store::SqliteStore;", "sqlite")]
#[case::database_word("worker.rs", "// PostgreSQL notifies us.", "postgres")]
#[case::http("store/sqlite.rs", "use crate::http::problem::Problem;", "crate::http")]
#[case::http_in_list("store/mod.rs", "use super::{job, http::v1};", "super::http")]
#[case::http_crate("store/mod.rs", "use axum::Json;", "axum")]
#[case::allowed("cli.rs", "#[allow(dead_code)]", "#[allow(")]
#[case::allowed_all("cli.rs", "#![ allow (dead_code) ]", "#![allow(")]
#[case::allowed_in_tests("cli.rs", "#[cfg_attr(test, allow(dead_code))]", ",allow(")]
fn a_planted_breach_is_caught(#[case] path: &str, #[case] text: &str, #[case] what: &str) {
    let sources = [Source { path: path.to_owned(), text: text.to_owned() }];
    assert_eq!(breaches(&sources), [format!("{path}: {what}")]);
}

#[test]
fn a_line_too_many_is_caught() {
    let source = |lines: usize| [Source { path: "cli.rs".to_owned(), text: "\n".repeat(lines) }];
    assert_eq!(breaches(&source(601)), ["cli.rs: 601 lines"]);
    assert_eq!(breaches(&source(600)), Vec::<String>::new());
}

#[rstest]
#[case::other_std("planning/a.rs", "use std::{collections::BTreeMap, fmt::Write};")]
#[case::deeper("planning/a.rs", "use std::{collections::{self, fs}};")]
#[case::part_of_a_word("planning/a.rs", "fn environment(axum_like: f64, mystd: u8) {}")]
#[case::build_time("planning/a.rs", "const VERSION: &str = env!(\"CARGO_PKG_VERSION\");")]
#[case::own_crate("job/a.rs", "use crate::planning::finding::Finding;")]
#[case::elsewhere("worker/child.rs", "use std::process::Command;")]
#[case::sqlite_at_home("store/sqlite.rs", "use sqlx::SqlitePool;")]
#[case::address("store/mod.rs", "// Keys come over HTTP, see https://example.com.")]
#[case::expected("cli.rs", "#[expect(dead_code, reason = \"the next slice calls it\")]")]
fn what_the_rules_leave_free_passes(#[case] path: &str, #[case] text: &str) {
    let sources = [Source { path: path.to_owned(), text: text.to_owned() }];
    assert_eq!(breaches(&sources), Vec::<String>::new());
}
