//! The command line as a person uses it: exit codes, what stands on standard error, what is written.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use tempfile::TempDir;

fn project(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

fn bladeplan(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_bladeplan")).args(arguments).output().unwrap()
}

fn plan(job: &Path, out: &Path) -> (i32, String) {
    let output = bladeplan(&["plan", job.to_str().unwrap(), "--out", out.to_str().unwrap()]);
    (output.status.code().unwrap(), String::from_utf8(output.stderr).unwrap())
}

fn files(folder: &Path) -> Vec<String> {
    let entries =
        fs::read_dir(folder).map(|entries| entries.map(|e| e.unwrap().file_name().into_string().unwrap()));
    let mut names: Vec<String> = entries.map(Iterator::collect).unwrap_or_default();
    names.sort();
    names
}

#[test]
fn a_usable_job_ends_with_0_and_leaves_its_files() {
    let folder = TempDir::new().unwrap();
    for job in [
        "examples/first.job.json",
        "examples/wing-skin-trapezoid-45.job.json",
        "examples/rib-panel-dxf.job.json",
        "examples/two-plies.job.json",
    ] {
        let (code, said) = plan(&project(job), folder.path());
        assert_eq!(code, 0, "{said}");
        let report = fs::read(folder.path().join("report.json")).unwrap();
        let report: serde_json::Value = serde_json::from_slice(&report).unwrap();
        let replay = &report["replay"];
        assert!(replay["max_deviation_mm"].as_f64().unwrap() <= 0.011, "{replay}");
        assert!(replay["uncut_mm"].as_f64().unwrap() <= 0.02, "{replay}");
        assert!(replay["unwanted_mm"].as_f64().unwrap() <= 0.02, "{replay}");
        assert_eq!(replay["tape_reversals"], 0);
        assert!(files(folder.path()).contains(&"roll.ngc".to_owned()));
    }
}

#[test]
fn an_invalid_job_ends_with_2_names_every_fault_and_writes_nothing() {
    let folder = TempDir::new().unwrap();
    let out = folder.path().join("out");
    let (code, said) = plan(&project("tests/fixtures/refused/several-faults-at-once.json"), &out);
    assert_eq!(code, 2);
    for pointer in ["/input/tape/width_mm", "/input/boundary/points/2/1", "/input/tracks/0/speed"] {
        assert!(said.contains(pointer), "{said}");
    }
    assert!(!out.exists());
    assert_eq!(plan(&project("no/such/file.json"), &out).0, 2);
}

#[test]
fn a_job_without_a_usable_program_ends_with_3_and_leaves_no_program_not_even_an_older_one() {
    let folder = TempDir::new().unwrap();
    assert_eq!(plan(&project("examples/first.job.json"), folder.path()).0, 0);
    fs::write(folder.path().join("notes.txt"), "mine").unwrap();
    let (code, said) = plan(&project("tests/golden/two-changes-excess/job.json"), folder.path());
    assert_eq!(code, 3);
    assert!(said.contains("course 1: 3 cuts lie side by side between u 340.000 and 380.000 mm"), "{said}");
    assert_eq!(files(folder.path()), ["notes.txt", "report.json"]);
}

#[test]
fn check_passes_what_was_planned_and_refuses_what_was_changed() {
    let folder = TempDir::new().unwrap();
    let job = project("examples/first.job.json");
    assert_eq!(plan(&job, folder.path()).0, 0);
    let program = folder.path().join("roll.ngc");
    let check = || bladeplan(&["check", program.to_str().unwrap(), "--job", job.to_str().unwrap()]);
    assert_eq!(check().status.code(), Some(0));
    let text = fs::read_to_string(&program).unwrap();
    fs::write(&program, text.replacen("V37.5", "V37.4", 1)).unwrap();
    let output = check();
    assert_eq!(output.status.code(), Some(3));
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains("roll.ngc:") && said.contains("differs_from_plan"), "{said}");
    fs::write(&program, "G21\nhello\n").unwrap();
    assert_eq!(check().status.code(), Some(3));
}

#[test]
fn a_roll_of_several_plies_is_planned_from_a_course_on_and_checked() {
    let folder = TempDir::new().unwrap();
    let job = fs::read(project("examples/two-plies.job.json")).unwrap();
    let mut job: serde_json::Value = serde_json::from_slice(&job).unwrap();
    job["input"]["options"] = serde_json::json!({"from_course": 3});
    let path = folder.path().join("job.json");
    let out = folder.path().join("out");
    fs::write(&path, job.to_string()).unwrap();
    let (code, said) = plan(&path, &out);
    assert_eq!(code, 2, "{said}");
    assert!(said.contains("/input/options/from_ply") && !out.exists(), "{said}");
    job["input"]["options"] = serde_json::json!({"from_course": 3, "from_ply": 2, "allocation": "free"});
    fs::write(&path, job.to_string()).unwrap();
    assert_eq!(plan(&path, &out).0, 0);
    let program = out.join("roll-from-ply-2-course-3.ngc");
    let check = || bladeplan(&["check", program.to_str().unwrap(), "--job", path.to_str().unwrap()]);
    assert_eq!(check().status.code(), Some(0));
    // The same course of the other ply is another program.
    job["input"]["options"]["from_ply"] = serde_json::json!(1);
    fs::write(&path, job.to_string()).unwrap();
    let output = check();
    assert_eq!(output.status.code(), Some(3));
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains("cut more often than it is wanted"), "{said}");
    assert!(said.contains("with options.from_course 3 and options.from_ply 2"), "{said}");
}

/// A job in a folder of its own, whose outline is in a file of this name.
fn job_naming(folder: &TempDir, name: &str) -> PathBuf {
    let job = fs::read(project("examples/first.job.json")).unwrap();
    let mut job: serde_json::Value = serde_json::from_slice(&job).unwrap();
    job["input"]["boundary"] = serde_json::json!({"file": name});
    let path = folder.path().join("job.json");
    fs::write(&path, job.to_string()).unwrap();
    path
}

#[test]
fn a_file_beside_the_job_is_read_from_wherever_the_command_is_given() {
    let folder = TempDir::new().unwrap();
    let job = job_naming(&folder, "boundary 1.txt");
    fs::write(folder.path().join("boundary 1.txt"), "0 0 0\n").unwrap();
    let out = folder.path().join("out");
    let expected = "error: boundary 1.txt:1: too_few_points: an outline needs three different points";
    let (code, said) = plan(&job, &out);
    assert_eq!(code, 2);
    assert!(said.contains(expected), "{said}");
    assert!(!out.exists());
    let mut command = Command::new(env!("CARGO_BIN_EXE_bladeplan"));
    let here =
        command.current_dir(folder.path()).args(["plan", "job.json", "--out", "out"]).output().unwrap();
    assert_eq!(here.status.code(), Some(2));
    assert!(String::from_utf8(here.stderr).unwrap().contains(expected));
    let program = folder.path().join("roll.ngc");
    fs::write(&program, "M2\n").unwrap();
    let check = bladeplan(&["check", program.to_str().unwrap(), "--job", job.to_str().unwrap()]);
    assert_eq!(check.status.code(), Some(2));
    assert!(String::from_utf8(check.stderr).unwrap().contains(expected));
}

#[test]
fn what_is_no_file_beside_the_job_is_refused_in_words_beside_every_other_fault() {
    let folder = TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::create_dir(at("folder")).unwrap();
    fs::write(at("elsewhere"), "0 0 0\n").unwrap();
    std::os::unix::fs::symlink(at("elsewhere"), at("link")).unwrap();
    std::os::unix::fs::symlink(at("nowhere"), at("dangling")).unwrap();
    rustix::fs::mkfifoat(rustix::fs::CWD, at("pipe"), rustix::fs::Mode::RUSR).unwrap();
    for (name, words) in [
        ("missing.txt", "there is no file"),
        ("folder", "not an ordinary file"),
        ("link", "is a symbolic link"),
        ("dangling", "is a symbolic link"),
        ("pipe", "not an ordinary file"),
    ] {
        let job = job_naming(&folder, name);
        let text = fs::read_to_string(&job).unwrap().replace("two-cutter-lab", "nowhere");
        fs::write(&job, text).unwrap();
        let (code, said) = plan(&job, &at("out"));
        assert_eq!(code, 2);
        assert!(
            said.contains("error: /input/boundary/file: unknown_file: ") && said.contains(words),
            "{said}"
        );
        assert!(said.contains("unknown_machine") && said.contains("2 faults"), "{said}");
    }
    for name in ["../elsewhere", "./elsewhere", "", "/etc/hostname"] {
        let (code, said) = plan(&job_naming(&folder, name), &at("out"));
        assert_eq!(code, 2);
        assert!(
            said.contains("/input/boundary/file: unknown_file: ")
                && said.contains("plain name") | name.is_empty(),
            "{said}"
        );
    }
}
