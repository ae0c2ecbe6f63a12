//! Milling programs converted to V-shaped cutting: the papers' own route, on text and back.

use std::fs;
use std::path::{Path, PathBuf};

use bladeplan::planning::geometry::Point3;
use bladeplan::planning::geometry::frame::Frame;
use bladeplan::planning::honeycomb::blade::{Blade, Edges};
use bladeplan::planning::honeycomb::convert::{Conversion, Converted, convert};
use bladeplan::planning::honeycomb::milling::Blank;
use bladeplan::planning::program::krl::read::execute;
use bladeplan::planning::program::krl::stem::Stem;
use bladeplan::planning::program::robot_events::RobotEvent;
use bladeplan::planning::program::robot_moves::{Purpose, RobotSetup, Speeds, ToolDirection};
use bladeplan::planning::units::{Angle, Length};
use nalgebra::Vector3;

use crate::golden::compare_text;
use crate::krl_emitted::{INPUT, stem};

/// What a conversion of a program needs beside its text.
struct Job {
    blank: Blank,
    rake_deg: f64,
    swing_deg: f64,
    extension_mm: f64,
}

impl Job {
    fn convert(&self, name: &str, text: &str, setup: &RobotSetup, stem: &Stem) -> Converted {
        let blade = Blade {
            rake: Angle::from_degrees(self.rake_deg),
            half_apex: Angle::from_degrees(7.13),
            max_cutting_length: Length::from_mm(10.0),
            length: Length::from_mm(10.0),
            max_swing: Angle::from_degrees(50.0),
            edges: Edges::Double,
        };
        let swing = self.swing_deg.to_radians();
        let Self { blank, extension_mm, .. } = *self;
        let conversion = Conversion { blank, blade: &blade, swing, extension_mm, setup };
        convert(name, text, &conversion, stem, INPUT).unwrap_or_else(|faults| panic!("{faults:?}"))
    }
}

pub fn setup(tool_direction: ToolDirection) -> RobotSetup {
    RobotSetup {
        tool: Frame { z_mm: 300.0, ..Frame::default() },
        base: Frame { x_mm: 1525.0, y_mm: -42.5, z_mm: 800.0, a_deg: 90.0, ..Frame::default() },
        tool_direction,
        home: [0.0, -90.0, 90.0, 0.0, 0.0, 0.0],
        approach: Some([-1.5, -75.25, 98.0, 12.0, 40.0, -8.0]),
        speeds: Speeds { cutting_mm_s: 150.0, travel_mm_s: 200.0, angular_deg_s: 90.0 },
        blend_mm: 1.0,
        ultrasonic_output: 1,
        max_lines: 2500,
    }
}

/// The wave that stands beside the tests, converted.
pub fn wave(tool_direction: ToolDirection) -> Converted {
    let job = Job {
        blank: Blank { width_mm: 18.0, length_mm: 30.0, height_mm: 30.0 },
        rake_deg: 60.0,
        swing_deg: 30.0,
        extension_mm: 6.5,
    };
    let text = fs::read_to_string(fixture("wave.src")).unwrap();
    job.convert("wave.src", &text, &setup(tool_direction), &stem())
}

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/krl").join(name)
}

#[test]
fn the_wave_becomes_the_golden_program() {
    let converted = wave(ToolDirection::Z);
    compare_text(&fixture("wave_converted.src"), &converted.program.text);
    let cuts: Vec<(usize, f64, f64)> = converted
        .milling
        .iter()
        .filter(|point| point.cut)
        .map(|point| (point.line, point.position.x, point.position.z))
        .collect();
    let expected = [(21, 4.0, 25.0), (23, 9.0, 25.0), (25, 14.0, 25.0), (31, 6.5, 21.5), (33, 11.5, 21.0)];
    assert_eq!(cuts, expected);
    assert_eq!(converted.milling.len(), 15);
    assert_eq!(converted.moves.len(), 15 + 3 * cuts.len());
    assert_eq!(converted.findings, []);
}

#[test]
fn a_cut_is_two_planes_through_its_tip_whichever_axis_the_tool_has() {
    for direction in [ToolDirection::Z, ToolDirection::X] {
        let converted = wave(direction);
        let events = execute(std::slice::from_ref(&converted.program), &converted.program.name).unwrap();
        let lines: Vec<Frame> = events
            .iter()
            .filter_map(|done| match done.event {
                RobotEvent::Line { frame, .. } => Some(frame),
                _ => None,
            })
            .collect();
        let cuts =
            converted.moves.iter().skip(1).zip(&lines).filter(|(wanted, _)| wanted.purpose == Purpose::Cut);
        let mut count = 0;
        for (index, (_, frame)) in cuts.enumerate() {
            let pose = frame.pose();
            let out = match direction {
                ToolDirection::Z => pose * Vector3::z(),
                ToolDirection::X => pose * Vector3::x(),
            };
            // The flange lies at the rake from the feed, and over the part in the plane swung by 30 degrees.
            let [feed, lean] = if index % 2 == 0 { [1.0, -1.0] } else { [-1.0, 1.0] };
            assert!((-out.y * feed - 0.5).abs() < 1e-5, "{out}");
            assert!((-out.x / -out.z - lean * 30.0_f64.to_radians().tan()).abs() < 1e-5, "{out}");
            assert!((frame.y_mm - if index % 2 == 0 { 36.5 } else { -6.5 }).abs() < 1e-9);
            count += 1;
        }
        assert_eq!(count, 10);
    }
}

/// The paper's own part at its optimum (121 cuts), where that program is at hand.
#[test]
fn the_shared_milling_program_gives_two_cuts_a_tip() {
    // It lies beside the project, or beside the folder in which the project is worked on.
    let folders = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors();
    let files = folders.map(|folder| folder.join("shared/data/honeycomb/milling_arc.src"));
    let Some(text) = files.filter_map(|path| fs::read_to_string(path).ok()).next() else { return };
    let job = Job {
        blank: Blank { width_mm: 85.0, length_mm: 50.0, height_mm: 50.0 },
        rake_deg: 60.0,
        swing_deg: 34.155,
        extension_mm: 6.0363,
    };
    let stem = Stem::new("conv_0123456789ab").unwrap();
    let converted = job.convert("milling_arc.src", &text, &setup(ToolDirection::Z), &stem);
    assert_eq!(converted.findings, []);
    let cut: Vec<Point3> =
        converted.milling.iter().filter(|point| point.cut).map(|point| point.position).collect();
    assert_eq!(cut.len(), 121);
    let events = execute(&[converted.program], "conv_0123456789ab.src").unwrap();
    let lines: Vec<Frame> = events
        .iter()
        .filter_map(|done| if let RobotEvent::Line { frame, .. } = done.event { Some(frame) } else { None })
        .collect();
    // Cuts are the motions from one side to the other: two a tip, at its place.
    let across: Vec<&[Frame]> =
        lines.windows(2).filter(|pair| (pair[1].y_mm - pair[0].y_mm).abs() > 50.0).collect();
    assert_eq!(across.len(), 242);
    for (pair, tip) in across.chunks(2).zip(&cut) {
        for end in pair.iter().flat_map(|ends| ends.iter()) {
            assert!((end.x_mm - tip.x).abs() < 1e-9 && (end.z_mm - tip.z).abs() < 1e-9);
            assert!((end.y_mm + 6.0363).abs() < 1e-9 || (end.y_mm - 56.0363).abs() < 1e-9);
        }
    }
}
