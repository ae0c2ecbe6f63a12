//! Robot programs as others write them, and what they do.

use std::path::{Path, PathBuf};

use bladeplan::planning::geometry::frame::Frame;
use bladeplan::planning::program::krl::read::execute;
use bladeplan::planning::program::robot_events::RobotEvent;

use crate::krl_refused::files;

fn folder(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/krl").join(name)
}

/// What the program of a folder does, each event with the name of its file and its line.
fn run(name: &str, main: &str) -> Vec<(String, usize, RobotEvent)> {
    let files = files(&folder(name));
    let events = execute(&files, main).unwrap_or_else(|faults| panic!("{faults:?}"));
    events.into_iter().map(|done| (files[done.file].name.clone(), done.line, done.event)).collect()
}

fn events(name: &str, main: &str) -> Vec<RobotEvent> {
    run(name, main).into_iter().map(|(_, _, event)| event).collect()
}

fn frame(x_mm: f64, y_mm: f64, z_mm: f64, a_deg: f64, b_deg: f64, c_deg: f64) -> Frame {
    Frame { x_mm, y_mm, z_mm, a_deg, b_deg, c_deg }
}

fn line(frame: Frame, blend: bool) -> RobotEvent {
    RobotEvent::Line { frame, blend }
}

#[test]
fn a_program_of_a_milling_post_processor() {
    let down = |x, y, z| frame(x, y, z, 0.0, 90.0, 0.0);
    let expected = [
        RobotEvent::BlendDistance { mm: 0.5 },
        RobotEvent::PathSpeed { mm_s: 250.0 },
        RobotEvent::TurnSpeed { deg_s: 120.0 },
        RobotEvent::TurnSpeed { deg_s: 100.0 },
        RobotEvent::Base { frame: frame(1200.0, -150.0, 650.0, 0.0, 0.0, 0.0) },
        RobotEvent::Tool { frame: frame(12.5, 0.0, 181.2, 0.0, 90.0, 0.0) },
        RobotEvent::JointsTo { joints: [-5.0, -95.0, 102.5, 0.0, 42.0, 10.0] },
        line(down(0.0, 0.0, 40.0), true),
        line(down(10.0, 0.0, 2.5), true),
        RobotEvent::PathSpeed { mm_s: 16.67 },
        RobotEvent::Output { number: 12, on: true },
        line(down(10.0, 120.25, 2.5), false),
        RobotEvent::Dwell { seconds: 0.25 },
        line(down(10.0, 120.25, 40.0), false),
        RobotEvent::Output { number: 12, on: false },
        RobotEvent::End,
    ];
    assert_eq!(events("milling_post", "groove.src"), expected);
    let last = run("milling_post", "groove.src").pop().unwrap();
    assert_eq!((last.0.as_str(), last.1), ("groove.src", 31));
}

#[test]
fn a_program_of_the_teach_pendant() {
    let tool = RobotEvent::Tool { frame: frame(1.0, 2.0, 250.0, 0.0, -90.0, 0.0) };
    let base = RobotEvent::Base { frame: frame(800.0, 0.0, 500.0, 45.0, 0.0, 0.0) };
    let first = frame(100.5, -20.0, 300.0, 0.0, 90.0, 0.0);
    let expected = [
        tool.clone(),
        base.clone(),
        RobotEvent::PoseTo { frame: first, blend: false },
        tool,
        base,
        RobotEvent::PathSpeed { mm_s: 500.0 },
        RobotEvent::BlendDistance { mm: 12.5 },
        line(frame(200.0, -20.0, 300.0, 0.0, 90.0, 0.0), true),
        line(first, true),
        RobotEvent::PathSpeed { mm_s: 20.0 },
        line(frame(1.0, 2.0, -1.25, 0.0, 0.0, 0.0), false),
        RobotEvent::Halt,
        RobotEvent::End,
    ];
    assert_eq!(events("teach_pendant", "Pick.src"), expected);
}

#[test]
fn a_program_written_by_hand() {
    let at = |x, y, z| frame(x, y, z, 0.0, 180.0, 0.0);
    let expected = [
        RobotEvent::Tool { frame: frame(0.0, 0.0, 100.0, 0.0, 0.0, 0.0) },
        RobotEvent::Base { frame: Frame::default() },
        RobotEvent::PoseTo { frame: at(500.0, 0.0, 400.0), blend: false },
        line(at(500.0, 100.0, 400.0), false),
        // The tool points down: back along it is up.
        line(at(500.0, 100.0, 450.0), false),
        line(at(450.5, 0.0, 400.0), true),
        RobotEvent::PoseTo { frame: at(451.5, 0.0, 400.0), blend: false },
        RobotEvent::End,
    ];
    let found = events("hand_written", "box.src");
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(&expected) {
        match (found, expected) {
            (RobotEvent::Line { frame, blend }, RobotEvent::Line { frame: wanted, blend: wanted_blend }) => {
                let away = (frame.pose().to_homogeneous() - wanted.pose().to_homogeneous()).norm();
                assert!(away < 1e-9 && blend == wanted_blend, "{found:?}");
            }
            _ => assert_eq!(found, expected),
        }
    }
}

#[test]
fn a_frame_that_no_file_gives_is_refused_where_it_matters() {
    let all = files(&folder("teach_pendant"));
    let without: Vec<_> = all.into_iter().filter(|file| file.name != "$config.dat").collect();
    let faults = execute(&without, "Pick.src").unwrap_err();
    assert_eq!((faults.len(), faults[0].at.as_str()), (1, "Pick.src:24:1"));
    assert!(faults[0].message.contains("BASE_DATA[1]"), "{}", faults[0].message);
}
