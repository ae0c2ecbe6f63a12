//! The container files name only what is there. (They are read, not built: a test needs no container engine.)

use std::fs;
use std::path::Path;
use std::process::Command;

fn file(name: &str) -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docker").join(name)).unwrap()
}

#[test]
fn every_path_that_is_copied_is_there() {
    let text = file("Dockerfile");
    let copies =
        text.lines().filter_map(|line| line.strip_prefix("COPY ")).filter(|line| !line.starts_with("--from"));
    let sources: Vec<&str> = copies.flat_map(|line| line.rsplit_once(' ').unwrap().0.split(' ')).collect();
    // What the build reads: the manifest with its targets, the page's templates, the tables.
    for needed in ["Cargo.toml", "Cargo.lock", "askama.toml", "src", "migrations", "benches", "examples"] {
        assert!(sources.contains(&needed), "{needed} is not copied: {sources:?}");
    }
    for source in sources {
        assert!(Path::new(env!("CARGO_MANIFEST_DIR")).join(source).exists(), "{source}");
    }
}

#[test]
fn the_command_of_the_image_is_one_that_the_program_knows() {
    let text = file("Dockerfile");
    let line = text.lines().find_map(|line| line.strip_prefix("CMD ")).unwrap();
    let mut words: Vec<String> = serde_json::from_str(line).unwrap();
    // A path that cannot be written: the program must understand all flags and then say what is wrong with it.
    let database = words.last_mut().unwrap();
    "/nowhere/bladeplan.db".clone_into(database);
    let output = Command::new(env!("CARGO_BIN_EXE_bladeplan")).args(&words).output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("/nowhere/bladeplan.db"), "{said}");
}

#[test]
fn compose_names_the_image_and_the_volume_of_the_database() {
    let (compose, image) = (file("compose.yaml"), file("Dockerfile"));
    assert!(compose.contains("dockerfile: docker/Dockerfile"));
    assert!(compose.contains("/var/lib/bladeplan") && image.contains("VOLUME /var/lib/bladeplan"));
    assert!(image.contains("USER bladeplan"), "not as root");
}
