use nalgebra::{Point3, Vector3};

use super::*;
use crate::planning::program::robot_moves::{Layer, Purpose, Speeds};

fn stem() -> Stem {
    Stem::new("vcut_0123456789ab").unwrap()
}

fn setup() -> RobotSetup {
    RobotSetup {
        tool: Frame { z_mm: 300.0, ..Frame::default() },
        base: Frame { x_mm: 1500.0, y_mm: -42.5, z_mm: 800.0, a_deg: 90.0, b_deg: -0.0, c_deg: 0.0 },
        tool_direction: ToolDirection::Z,
        home: [0.0, -90.0, 90.0, 0.0, 0.0, 0.0],
        approach: Some([1.0, -80.0, 80.0, 0.0, 30.0, 0.0]),
        speeds: Speeds { cutting_mm_s: 150.0, travel_mm_s: 200.0, angular_deg_s: 90.0 },
        blend_mm: 1.0,
        ultrasonic_output: 3,
        max_lines: 2500,
    }
}

fn to(y_mm: f64, purpose: Purpose) -> RobotStep {
    let frame = Frame { x_mm: 1.0, y_mm, z_mm: -0.000_01, a_deg: 10.0, b_deg: 20.0, c_deg: 30.0 };
    RobotStep::Move { to: frame.pose(), purpose }
}

/// Down, so many tips with two turns and two cuts each, up.
fn layer(tips: usize) -> Layer {
    let mut steps =
        vec![to(0.0, Purpose::Free), to(1.0, Purpose::Approach), RobotStep::Ultrasonic { on: true }];
    for _ in 0..tips {
        steps.extend(
            [Purpose::Turn, Purpose::Cut, Purpose::Turn, Purpose::Cut].map(|purpose| to(2.0, purpose)),
        );
    }
    steps.extend([RobotStep::Ultrasonic { on: false }, to(3.0, Purpose::Free)]);
    Layer { steps }
}

fn program(layers: Vec<Layer>) -> RobotProgram {
    RobotProgram { setup: setup(), layers }
}

fn written_with(max_lines: usize, layers: Vec<Layer>) -> Vec<ProgramFile> {
    let mut program = program(layers);
    program.setup.max_lines = max_lines;
    emit(&program, &stem(), "00ff").unwrap()
}

fn statements(file: &ProgramFile) -> Vec<&str> {
    file.text.lines().map(str::trim).collect()
}

#[test]
fn a_layer_says_only_what_changes() {
    let files = written_with(2500, vec![layer(1)]);
    let names: Vec<_> = files.iter().map(|file| file.name.as_str()).collect();
    assert_eq!(names, ["vcut_0123456789ab.src", "vcut_0123456789ab.dat", "vcut_0123456789ab_001.src"]);
    let point = |y| format!("LIN {{X 1.0,Y {y}.0,Z 0.0,A 10.0,B 20.0,C 30.0}}");
    let on = "TRIGGER WHEN DISTANCE=0 DELAY=0 DO $OUT[3]=TRUE";
    let off = "TRIGGER WHEN DISTANCE=0 DELAY=0 DO $OUT[3]=FALSE";
    let expected = [
        "&ACCESS RVP",
        "&REL 1",
        "DEF vcut_0123456789ab_001 ( )",
        ";LAYER 1",
        "IF vcut_0123456789ab_first<=1 THEN",
        "$VEL.CP=0.2",
        &format!("{} C_DIS", point(0)),
        &point(1),
        on,
        &point(2),
        "$VEL.CP=0.15",
        &point(2),
        "$VEL.CP=0.2",
        &point(2),
        "$VEL.CP=0.15",
        &point(2),
        "$VEL.CP=0.2",
        off,
        &format!("{} C_DIS", point(3)),
        "ENDIF",
        "END",
    ];
    assert_eq!(statements(&files[2]), expected);
}

#[test]
fn the_main_file_sets_up_and_calls() {
    let files = written_with(2500, vec![layer(1)]);
    let main = statements(&files[0]);
    let count = |line: &str| main.iter().filter(|said| **said == line).count();
    for line in ["BAS (#INITMOV,0 )", "$VEL.ORI1=90.0", "$VEL.ORI2=90.0", "$APO.CDIS=1.0", "$IPO_MODE=#BASE"]
    {
        assert_eq!(count(line), 1, "{line}");
    }
    assert_eq!(count("$BASE={X 1500.0,Y -42.5,Z 800.0,A 90.0,B 0.0,C 0.0}"), 1);
    let motions: Vec<_> =
        main.iter().filter(|line| line.starts_with("PTP") || line.starts_with("LIN")).collect();
    let home = "PTP {A1 0.0,A2 -90.0,A3 90.0,A4 0.0,A5 0.0,A6 0.0}";
    assert_eq!(motions, [&home, &"PTP {A1 1.0,A2 -80.0,A3 80.0,A4 0.0,A5 30.0,A6 0.0}", &home]);
    assert_eq!(
        main[main.len() - 6..main.len() - 4],
        ["vcut_0123456789ab_001 ( )", "TRIGGER WHEN DISTANCE=0 DELAY=0 DO $OUT[3]=FALSE"]
    );
    assert_eq!(main[main.len() - 3..], ["$OUT[3]=FALSE", "vcut_0123456789ab_first=1", "END"]);
    assert!(statements(&files[1]).contains(&"DECL GLOBAL INT vcut_0123456789ab_first=1"));
    let mut program = program(vec![layer(1)]);
    program.setup.approach = None;
    let text = &emit(&program, &stem(), "00ff").unwrap()[0].text;
    assert_eq!(text.matches("PTP {").count(), 2);
}

#[test]
fn the_text_is_what_a_control_takes() {
    for file in written_with(60, vec![layer(3), Layer::default(), layer(20)]) {
        assert!(
            file.text.is_ascii() && file.text.ends_with("\r\n") && !file.text.contains("-0.0,"),
            "{}",
            file.name
        );
        for line in file.text.split_terminator('\n') {
            assert!(line.ends_with('\r') && line.len() < 200, "{line}");
        }
    }
}

#[test]
fn files_hold_whole_layers_while_they_can() {
    // A layer of one tip is 18 lines with its guard; 40 lines hold two of them.
    let files = written_with(40, (0..5).map(|_| layer(1)).collect());
    assert_eq!(files.len(), 2 + 3);
    for file in &files[2..] {
        let lines = statements(file);
        assert!(lines.len() <= 40, "{}", lines.len());
        assert!(lines.iter().all(|line| !line.contains("PART")));
    }
    let guards: Vec<_> =
        files[2..].iter().flat_map(statements).filter(|line| line.starts_with("IF")).collect();
    assert_eq!(guards.len(), 5);
    assert_eq!(guards[4], "IF vcut_0123456789ab_first<=5 THEN");
}

#[test]
fn a_layer_that_is_too_long_is_split_behind_a_cut() {
    let files = written_with(30, vec![layer(1), layer(12)]);
    let mut parts = 0;
    for file in &files[3..] {
        let lines = statements(file);
        assert!(lines.len() <= 30);
        let guarded = lines.iter().position(|line| line.starts_with("IF")).unwrap();
        assert_eq!(lines[guarded], "IF vcut_0123456789ab_first<=2 THEN");
        assert!(lines[guarded + 1].starts_with("$VEL.CP="), "each part says its speed");
        parts += 1;
        let last = lines.iter().rposition(|line| line.starts_with("LIN")).unwrap();
        let speed = lines[..last].iter().rfind(|line| line.starts_with("$VEL.CP=")).unwrap();
        assert!(*speed == "$VEL.CP=0.15" || parts == files.len() - 3, "{}: ends with no cut", file.name);
    }
    assert!(parts >= 4);
    assert_eq!(statements(&files[3])[3], format!(";LAYER 2, PART 1 OF {parts}"));
    let cuts =
        |files: &[ProgramFile]| files.iter().map(|file| file.text.matches("LIN {").count()).sum::<usize>();
    assert_eq!(cuts(&files), cuts(&written_with(2500, vec![layer(1), layer(12)])), "nothing is lost");
    // Without cuts it is split somewhere.
    let walk = Layer { steps: (0..100).map(|_| to(1.0, Purpose::Free)).collect() };
    assert!(written_with(20, vec![walk]).iter().skip(2).all(|file| file.text.lines().count() <= 20));
}

#[test]
fn a_start_at_any_layer_switches_the_ultrasonic_on() {
    let cut = || Layer { steps: vec![to(1.0, Purpose::Cut)] };
    let first = Layer { steps: vec![RobotStep::Ultrasonic { on: true }, to(1.0, Purpose::Cut)] };
    let last = Layer { steps: vec![to(1.0, Purpose::Cut), RobotStep::Ultrasonic { on: false }] };
    let files = written_with(2500, vec![first, cut(), last, cut()]);
    let switched: Vec<_> =
        statements(&files[2]).into_iter().filter(|line| line.starts_with("TRIGGER")).collect();
    let on = "TRIGGER WHEN DISTANCE=0 DELAY=0 DO $OUT[3]=TRUE";
    assert_eq!(switched, [on, on, on, "TRIGGER WHEN DISTANCE=0 DELAY=0 DO $OUT[3]=FALSE"]);
}

/// A layer that ends in the cut leaves the ultrasonic on where the layers run on, and off where one starts behind it.
#[test]
fn a_layer_switches_on_what_the_one_before_would_have_left_on() {
    let layer = || Layer {
        steps: vec![
            RobotStep::Ultrasonic { on: true },
            to(1.0, Purpose::Cut),
            RobotStep::Ultrasonic { on: false },
        ],
    };
    let files = written_with(2500, vec![layer(), layer()]);
    let switched = statements(&files[2]).into_iter().filter(|line| line.ends_with("$OUT[3]=TRUE")).count();
    assert_eq!(switched, 2);
}

#[test]
fn the_tool_axis_of_the_cell_is_the_tool_axis() {
    let pose: Pose = Frame { x_mm: 1.0, y_mm: 2.0, z_mm: 3.0, a_deg: 10.0, b_deg: 20.0, c_deg: 30.0 }.pose();
    let read = |direction| {
        let words = pose_words(&pose, direction);
        let numbers: Vec<f64> = words
            .trim_matches(['{', '}'])
            .split(',')
            .map(|word| word.split_once(' ').unwrap().1.parse().unwrap())
            .collect();
        let [x_mm, y_mm, z_mm, a_deg, b_deg, c_deg] = numbers[..] else { panic!("{words}") };
        Frame { x_mm, y_mm, z_mm, a_deg, b_deg, c_deg }.pose()
    };
    let (z, x) = (read(ToolDirection::Z), read(ToolDirection::X));
    assert!((z * Point3::origin() - x * Point3::origin()).norm() < 1e-9);
    for (written, neutral) in
        [(Vector3::x(), Vector3::z()), (Vector3::y(), Vector3::y()), (Vector3::z(), -Vector3::x())]
    {
        assert!((x * written - pose * neutral).norm() < 1e-5);
        assert!((z * neutral - pose * neutral).norm() < 1e-5);
    }
}

#[test]
fn what_no_control_takes_is_refused_by_name() {
    type Spoil = fn(&mut RobotSetup);
    let cases: [(Spoil, &str); 9] = [
        (|setup| setup.max_lines = 19, "at least 20"),
        (|setup| setup.tool.x_mm = f64::NAN, "the tool frame is NaN"),
        (|setup| setup.base.c_deg = f64::INFINITY, "the base frame is inf"),
        (|setup| setup.home[3] = 1e7, "a joint angle is 10000000"),
        (|setup| setup.approach = Some([f64::NAN; 6]), "a joint angle is NaN"),
        (|setup| setup.speeds.cutting_mm_s = 0.000_4, "the cutting speed is 0.0004"),
        (|setup| setup.speeds.angular_deg_s = -1.0, "the angular speed is -1"),
        (|setup| setup.blend_mm = -1.0, "the blend distance is -1"),
        (|setup| setup.ultrasonic_output = 0, "counted from 1"),
    ];
    for (spoil, message) in cases {
        let mut program = program(vec![layer(1)]);
        spoil(&mut program.setup);
        let finding = emit(&program, &stem(), "00ff").unwrap_err();
        assert_eq!(finding.code, Code::OutOfRange);
        assert!(finding.message.contains(message), "{finding}");
    }
    let far = Layer { steps: vec![to(1e9, Purpose::Free)] };
    let finding = emit(&program(vec![layer(1), far]), &stem(), "00ff").unwrap_err();
    assert!(finding.message.contains("layer 2: 1000000000"), "{finding}");
}
