//! Robot programs as text and back: what is read is what was meant, from any layer on.

use std::fs;
use std::path::Path;

use bladeplan::planning::geometry::frame::{Frame, Pose};
use bladeplan::planning::outcome::ProgramFile;
use bladeplan::planning::program::krl::emit::emit;
use bladeplan::planning::program::krl::read::execute;
use bladeplan::planning::program::krl::stem::Stem;
use bladeplan::planning::program::robot_events::{RobotEvent, RobotExecuted};
use bladeplan::planning::program::robot_moves::{
    Layer, Purpose, RobotProgram, RobotSetup, RobotStep, Speeds, ToolDirection,
};
use proptest::prelude::*;

use crate::golden::compare_text;
use crate::rounds::runner;

/// What four printed decimals may change in a matrix: 0.00005 mm, and three turns of 0.00005 degrees.
const PRINTED: f64 = 2e-4;

/// The names of every program here begin with it.
pub fn stem() -> Stem {
    Stem::new("vcut_0123456789ab").unwrap()
}

/// Some hash.
pub const INPUT: &str = "00112233445566778899aabbccddeeff00112233445566778899aabbccddeeff";

/// A straight motion as the control makes it.
#[derive(Debug, Clone, Copy)]
struct Motion {
    to: Pose,
    blend: bool,
    mm_s: f64,
    ultrasonic: bool,
}

/// Programs with layers of moves in any order, in files of any length.
pub fn programs() -> impl Strategy<Value = RobotProgram> {
    let layers = prop::collection::vec(prop::collection::vec(steps(), 0..40), 0..8);
    (setups(), layers).prop_map(|(setup, layers)| RobotProgram {
        setup,
        layers: layers.into_iter().map(|steps| Layer { steps }).collect(),
    })
}

fn setups() -> impl Strategy<Value = RobotSetup> {
    let joints = prop::array::uniform6(-180.0..180.0_f64);
    let speeds = (5.0..900.0_f64, 5.0..900.0_f64, 1.0..300.0_f64);
    let numbers = (0.0..20.0_f64, 1..4096_u32, 20..120_usize);
    let axis = prop::sample::select(&[ToolDirection::Z, ToolDirection::X][..]);
    (frames(), frames(), axis, joints.clone(), prop::option::of(joints), speeds, numbers).prop_map(
        |(tool, base, tool_direction, home, approach, speeds, (blend_mm, ultrasonic_output, max_lines))| {
            let (cutting_mm_s, travel_mm_s, angular_deg_s) = speeds;
            let speeds = Speeds { cutting_mm_s, travel_mm_s, angular_deg_s };
            RobotSetup {
                tool,
                base,
                tool_direction,
                home,
                approach,
                speeds,
                blend_mm,
                ultrasonic_output,
                max_lines,
            }
        },
    )
}

/// Frames, many of them with an axis that stands upright or lies level, where angles are told apart worst.
fn frames() -> impl Strategy<Value = Frame> {
    let length = || prop_oneof![4 => -3000.0..3000.0_f64, 1 => Just(0.0), 1 => Just(-0.000_01)];
    let angle =
        || prop_oneof![3 => -180.0..180.0_f64, 1 => prop::sample::select(&[-90.0, 0.0, 90.0, 180.0][..])];
    (length(), length(), length(), angle(), angle(), angle())
        .prop_map(|(x_mm, y_mm, z_mm, a_deg, b_deg, c_deg)| Frame { x_mm, y_mm, z_mm, a_deg, b_deg, c_deg })
}

fn steps() -> impl Strategy<Value = RobotStep> {
    let purposes = vec![Purpose::Free, Purpose::Approach, Purpose::Turn, Purpose::Cut, Purpose::Cut];
    let moves = (frames(), prop::sample::select(purposes))
        .prop_map(|(frame, purpose)| RobotStep::Move { to: frame.pose(), purpose });
    prop_oneof![8 => moves, 1 => any::<bool>().prop_map(|on| RobotStep::Ultrasonic { on })]
}

/// What a program means, from a layer on (from 0).
fn meant(program: &RobotProgram, first: usize) -> Vec<Motion> {
    let (mut ultrasonic, mut motions) = (false, Vec::new());
    for (index, layer) in program.layers.iter().enumerate() {
        for step in &layer.steps {
            match *step {
                RobotStep::Ultrasonic { on } => ultrasonic = on,
                RobotStep::Move { to, purpose } if index >= first => {
                    let speeds = program.setup.speeds;
                    let mm_s = if purpose == Purpose::Cut { speeds.cutting_mm_s } else { speeds.travel_mm_s };
                    motions.push(Motion { to, blend: purpose == Purpose::Free, mm_s, ultrasonic });
                }
                RobotStep::Move { .. } => {}
            }
        }
    }
    motions
}

/// What the control does, its poses turned back to a tool along Z.
fn done(program: &RobotProgram, events: &[RobotExecuted]) -> Vec<Motion> {
    let (mut mm_s, mut ultrasonic, mut motions) = (0.0, true, Vec::new());
    for executed in events {
        match executed.event {
            RobotEvent::PathSpeed { mm_s: new } => mm_s = new,
            RobotEvent::Output { number, on } => {
                assert_eq!(number, program.setup.ultrasonic_output);
                ultrasonic = on;
            }
            RobotEvent::Line { frame, blend } => {
                let to = neutral(&frame, program.setup.tool_direction);
                motions.push(Motion { to, blend, mm_s, ultrasonic });
            }
            _ => {}
        }
    }
    motions
}

fn neutral(frame: &Frame, direction: ToolDirection) -> Pose {
    let pose = frame.pose();
    match direction {
        ToolDirection::Z => pose,
        // A quarter turn about Y takes Z to X.
        ToolDirection::X => pose * Frame { b_deg: 90.0, ..Frame::default() }.pose(),
    }
}

fn check_same(found: &[Motion], wanted: &[Motion]) {
    assert_eq!(found.len(), wanted.len());
    for (index, (found, wanted)) in found.iter().zip(wanted).enumerate() {
        check_pose(&found.to, &wanted.to, &format!("motion {index}"));
        assert_eq!((found.blend, found.ultrasonic), (wanted.blend, wanted.ultrasonic), "motion {index}");
        assert!((found.mm_s - wanted.mm_s).abs() < 6e-4, "motion {index}: {} mm/s", found.mm_s);
    }
}

fn check_pose(found: &Pose, wanted: &Pose, what: &str) {
    let away = (found.to_homogeneous() - wanted.to_homogeneous()).norm();
    assert!(away < PRINTED, "{what} is {away} away");
}

/// The events of a program.
pub fn run(files: &[ProgramFile]) -> Vec<RobotExecuted> {
    execute(files, &files[0].name).unwrap_or_else(|faults| panic!("{faults:?}\n{}", files[0].text))
}

#[test]
fn what_is_read_is_what_was_meant() {
    let check = |program: RobotProgram| {
        let files = emit(&program, &stem(), INPUT).unwrap();
        let events = run(&files);
        check_same(&done(&program, &events), &meant(&program, 0));
        check_around(&program, &events);
        for file in &files {
            check_text(file, program.setup.max_lines);
        }
        Ok(())
    };
    runner(60).run(&programs(), check).unwrap();
}

/// What surrounds the layers: frames, the ways to and from home, and the ultrasonic off at both ends.
fn check_around(program: &RobotProgram, events: &[RobotExecuted]) {
    let setup = &program.setup;
    let events: Vec<&RobotEvent> = events.iter().map(|executed| &executed.event).collect();
    let frame = |wanted: &Frame, found: &Frame, what: &str| check_pose(&found.pose(), &wanted.pose(), what);
    let [
        RobotEvent::Output { on: false, .. },
        RobotEvent::Tool { frame: tool },
        RobotEvent::Base { frame: base },
        ..,
    ] = events[..]
    else {
        panic!("{events:?}")
    };
    frame(&setup.tool, tool, "the tool");
    frame(&setup.base, base, "the base");
    let stations: Vec<_> = std::iter::once(setup.home).chain(setup.approach).chain([setup.home]).collect();
    let joints =
        |event: &&RobotEvent| if let RobotEvent::JointsTo { joints } = event { Some(*joints) } else { None };
    let found: Vec<_> = events.iter().filter_map(joints).collect();
    assert_eq!(found.len(), stations.len());
    for (found, wanted) in found.iter().flatten().zip(stations.iter().flatten()) {
        assert!((found - wanted).abs() < 6e-5);
    }
    let [
        ..,
        RobotEvent::Output { on: false, .. },
        RobotEvent::JointsTo { .. },
        RobotEvent::Output { on: false, .. },
        RobotEvent::End,
    ] = events[..]
    else {
        panic!("{events:?}")
    };
    assert!(events.iter().any(|event| matches!(event, RobotEvent::TurnSpeed { deg_s } if (deg_s - setup.speeds.angular_deg_s).abs() < 6e-5)));
    assert!(events.iter().any(
        |event| matches!(event, RobotEvent::BlendDistance { mm } if (mm - setup.blend_mm).abs() < 6e-5)
    ));
}

fn check_text(file: &ProgramFile, max_lines: usize) {
    let name = &file.name;
    assert!(file.text.is_ascii() && file.text.ends_with("\r\n"), "{name}");
    for line in file.text.split_terminator("\r\n") {
        assert!(line.len() < 200 && !line.contains(['\r', '\n', '\t']), "{name}: {line}");
        let words = line.split(|letter: char| !letter.is_ascii_alphanumeric() && letter != '_');
        let numbers = line.split([' ', ',', '=', '}']);
        assert!(numbers.clone().all(|word| word != "-0" && word != "-0.0"), "{name}: {line}");
        assert!(line.starts_with(';') || words.clone().all(|word| word.len() <= 24), "{name}: {line}");
    }
    let main = *name == format!("{}.src", stem().as_str());
    assert!(main || file.text.lines().count() <= max_lines, "{name}");
}

#[test]
fn a_program_can_be_started_at_any_layer() {
    let check = |(program, pick): (RobotProgram, prop::sample::Index)| {
        let first = pick.index(program.layers.len() + 1);
        let mut files = emit(&program, &stem(), INPUT).unwrap();
        let set = format!("_first={}\r\n", first + 1);
        assert!(files[1].text.contains("_first=1\r\n"));
        files[1].text = files[1].text.replace("_first=1\r\n", &set);
        let found = done(&program, &run(&files));
        check_same(&found, &meant(&program, first));
        Ok(())
    };
    runner(60).run(&(programs(), any::<prop::sample::Index>()), check).unwrap();
}

#[test]
fn any_change_of_a_text_is_read_or_refused() {
    let program = sample(ToolDirection::Z);
    let files = emit(&program, &stem(), INPUT).unwrap();
    let change =
        (0..files.len(), any::<prop::sample::Index>(), 0..6_u8, any::<char>(), any::<prop::sample::Index>());
    let check =
        |(file, place, kind, letter, other): (usize, prop::sample::Index, u8, char, prop::sample::Index)| {
            let mut files = files.clone();
            let letters: Vec<char> = files[file].text.chars().collect();
            let (mut new, at) = (letters.clone(), place.index(letters.len()));
            match kind {
                0 => new[at] = letter,
                1 => new.insert(at, letter),
                2 => drop(new.remove(at)),
                3 => new.truncate(at),
                4 => new[at] = letters[other.index(letters.len())],
                _ => new.swap(at, other.index(letters.len())),
            }
            files[file].text = new.into_iter().collect();
            let _ = execute(&files, &files[0].name);
            Ok(())
        };
    runner(400).run(&change, check).unwrap();
}

/// Two tips in two layers, the second of which fills two files of 30 lines.
pub fn sample(tool_direction: ToolDirection) -> RobotProgram {
    let pose = |x_mm: f64, y_mm: f64, z_mm: f64, right: bool| {
        let side = if right { -1.0 } else { 1.0 };
        Frame { x_mm, y_mm, z_mm, a_deg: 116.0 * side, b_deg: 35.25 * side, c_deg: 138.5 }.pose()
    };
    let go = |x, y, z, right, purpose| RobotStep::Move { to: pose(x, y, z, right), purpose };
    let tip = |x: f64, z: f64| {
        [
            go(x, -6.0363, z, false, Purpose::Turn),
            go(x, 56.0363, z, false, Purpose::Cut),
            go(x, 56.0363, z, true, Purpose::Turn),
            go(x, -6.0363, z, true, Purpose::Cut),
        ]
    };
    let layer = |tips: &[f64], z: f64| {
        let mut steps = vec![
            go(tips[0], -6.0363, 60.0, false, Purpose::Free),
            go(tips[0], -6.0363, z, false, Purpose::Approach),
            RobotStep::Ultrasonic { on: true },
        ];
        steps.extend(tips.iter().flat_map(|x| tip(*x, z)));
        steps.push(RobotStep::Ultrasonic { on: false });
        steps.push(go(tips[tips.len() - 1], -6.0363, 60.0, true, Purpose::Free));
        Layer { steps }
    };
    let setup = RobotSetup {
        tool: Frame { z_mm: 300.0, ..Frame::default() },
        base: Frame { x_mm: 1525.0, y_mm: -42.5, z_mm: 800.0, a_deg: 90.0, ..Frame::default() },
        tool_direction,
        home: [0.0, -90.0, 90.0, 0.0, 0.0, 0.0],
        approach: Some([-1.5, -75.25, 98.0, 12.0, 40.0, -8.0]),
        speeds: Speeds { cutting_mm_s: 150.0, travel_mm_s: 200.0, angular_deg_s: 90.0 },
        blend_mm: 1.0,
        ultrasonic_output: 1,
        max_lines: 30,
    };
    RobotProgram { setup, layers: vec![layer(&[10.0], 45.602), layer(&[12.984, 18.952, 24.92], 41.204)] }
}

#[test]
fn the_text_is_the_golden_one() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/krl/emitted");
    for (direction, name) in [(ToolDirection::Z, "tool_z"), (ToolDirection::X, "tool_x")] {
        let files = emit(&sample(direction), &stem(), INPUT).unwrap();
        for file in &files {
            compare_text(&folder.join(name).join(&file.name), &file.text);
        }
        let kept = fs::read_dir(folder.join(name)).unwrap().count();
        assert_eq!(kept, files.len(), "{name}");
    }
}

#[test]
fn the_same_program_gives_the_same_bytes() {
    let again = || emit(&sample(ToolDirection::X), &stem(), INPUT).unwrap();
    assert_eq!(again(), again());
}

#[test]
fn a_program_of_twenty_thousand_cuts_is_written_and_read() {
    let mut program = sample(ToolDirection::Z);
    program.setup.max_lines = 2500;
    let tips: Vec<RobotStep> = program.layers[1].steps[3..15].to_vec();
    let many = 3400;
    program.layers[1].steps.splice(3..15, tips.into_iter().cycle().take(12 * many));
    let files = emit(&program, &stem(), INPUT).unwrap();
    assert!(files.len() > 20);
    assert!(files[2..].iter().all(|file| file.text.lines().count() <= 2500));
    assert_eq!(done(&program, &run(&files)).len(), meant(&program, 0).len());
}
