//! The plain milling path of a lattice, for those who simulate in a CAM system first (domain.md B4).
//!
//! A cone stands for the blade swung both ways: what it mills away is the V that two cuts free. Layer by layer, it
//! goes along each row of the lattice once, to and fro.

use nalgebra::{UnitQuaternion, Vector3};

use super::blade::Blade;
use crate::planning::finding::{Code, Finding};
use crate::planning::geometry::frame::Pose;
use crate::planning::geometry::{Point2, Point3};
use crate::planning::outcome::ProgramFile;
use crate::planning::program::krl::emit;
use crate::planning::program::krl::stem::Stem;
use crate::planning::program::robot_moves::RobotSetup;

pub use super::wire::Blank;

/// A cone, tip down, whose section is the V of two cuts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConeTool {
    /// Between its two flanks: twice the swing angle.
    pub full_angle_deg: f64,
    /// From its tip to the end of its flank.
    pub flank_mm: f64,
}

/// A cone's flank is so many times as long as what it must show, so that its upper rim never looks like a cut.
const FLANK_MARGIN: f64 = 1.2;

impl ConeTool {
    /// The cone that stands for a blade swung by `swing` rad: longer than the cutting length, and than the blade.
    #[must_use]
    pub fn of(blade: &Blade, swing: f64) -> Self {
        let longest = blade.length.mm().max(blade.max_cutting_length.mm());
        Self { full_angle_deg: 2.0 * swing.to_degrees(), flank_mm: longest * FLANK_MARGIN }
    }
}

/// The milling program of layers of tips, (x, z) in mm: one file, however long. The tool points down.
///
/// `safety_mm` is how far above the blank it travels.
///
/// # Errors
/// `OutOfRange` for numbers that no control takes, and a travel that is not above the blank.
pub fn milling_program(
    layers: &[Vec<Point2>],
    blank: &Blank,
    safety_mm: f64,
    setup: &RobotSetup,
    stem: &Stem,
    input_sha256: &str,
) -> Result<ProgramFile, Finding> {
    emit::check_setup(setup)?;
    if safety_mm.is_nan() || safety_mm <= 0.0 {
        let message =
            format!("the tool travels {safety_mm} mm above the blank; it must be more than nothing");
        return Err(Finding::error(Code::OutOfRange, "", message));
    }
    let mut way = Way {
        blank,
        safety_z: blank.height_mm + safety_mm,
        setup,
        speed: setup.speeds.travel_mm_s,
        at_home: true,
        lines: Vec::new(),
    };
    for tips in layers {
        way.layer(tips)?;
    }
    let mut lines = emit::head(stem.as_str());
    lines.extend(emit::origin("MILLING PATH FOR SIMULATION", input_sha256));
    lines.extend(emit::initial_lines());
    lines.extend(emit::setup_lines(setup));
    lines.extend(emit::opening_moves(setup));
    lines.append(&mut way.lines);
    lines.extend(emit::closing_lines(setup));
    lines.push("END".to_owned());
    Ok(emit::file(stem.as_str(), "src", &lines))
}

/// The tool on its way.
struct Way<'a> {
    blank: &'a Blank,
    safety_z: f64,
    setup: &'a RobotSetup,
    /// In mm/s, as the control has it.
    speed: f64,
    /// Whether no motion has been written yet.
    at_home: bool,
    lines: Vec<String>,
}

impl Way<'_> {
    fn layer(&mut self, tips: &[Point2]) -> Result<(), Finding> {
        let ends = [0.0, self.blank.length_mm];
        let mut side = 0;
        for (index, tip) in tips.iter().enumerate() {
            let [x, z] = [tip.x, tip.y];
            if index == 0 {
                self.travel([x, ends[0], self.safety_z], true)?;
                self.travel([x, ends[0], z], false)?;
            } else {
                self.travel([x, ends[side], z], true)?;
            }
            side = 1 - side;
            self.go([x, ends[side], z], self.setup.speeds.cutting_mm_s, false)?;
        }
        let Some(last) = tips.last() else { return Ok(()) };
        self.travel([last.x, ends[side], self.safety_z], false)?;
        if side == 1 {
            self.travel([last.x, ends[0], self.safety_z], false)?;
        }
        Ok(())
    }

    fn travel(&mut self, place: [f64; 3], blend: bool) -> Result<(), Finding> {
        self.go(place, self.setup.speeds.travel_mm_s, blend)
    }

    fn go(&mut self, place: [f64; 3], speed: f64, blend: bool) -> Result<(), Finding> {
        let pose = upright(place.into());
        emit::check_pose(&pose)?;
        if speed != self.speed {
            self.speed = speed;
            self.lines.push(format!("  {}", emit::path_speed(speed)));
        }
        let words = emit::pose_words(&pose, self.setup.tool_direction);
        // From where a robot stands at home a straight line leads through a singularity, or through the part.
        let motion = if std::mem::replace(&mut self.at_home, false) {
            format!("  PTP {words}")
        } else {
            format!("  LIN {words}{}", if blend { " C_DIS" } else { "" })
        };
        self.lines.push(motion);
        Ok(())
    }
}

/// A tool that points straight down.
fn upright(place: Point3) -> Pose {
    Pose::from_parts(place.into(), UnitQuaternion::from_axis_angle(&Vector3::y_axis(), std::f64::consts::PI))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planning::honeycomb::convert::tests::{blade, setup};

    #[test]
    fn the_cone_is_the_v_of_two_cuts_and_longer_than_the_blade() {
        let cone = ConeTool::of(&blade(), 34.155_f64.to_radians());
        assert!((cone.full_angle_deg - 68.31).abs() < 1e-12);
        assert!(cone.flank_mm > blade().length.mm());
    }

    #[test]
    fn rows_are_milled_to_and_fro_and_layers_begin_above_the_front() {
        let blank = Blank { width_mm: 20.0, length_mm: 50.0, height_mm: 30.0 };
        let layers = vec![
            vec![Point2::new(5.0, 25.0), Point2::new(10.0, 25.0), Point2::new(15.0, 24.0)],
            vec![Point2::new(5.0, 20.0)],
        ];
        let stem = Stem::new("mill_0123456789ab").unwrap();
        let file = milling_program(&layers, &blank, 10.0, &setup(), &stem, "00ff").unwrap();
        let lines = file.text.lines().map(str::trim);
        let moves: Vec<_> = lines
            .filter(|line| ["LIN", "PTP {X", "$VEL.CP"].iter().any(|word| line.starts_with(word)))
            .skip(1)
            .collect();
        let to = |x: &str, y: &str, z: &str, suffix: &str| {
            format!("LIN {{X {x},Y {y},Z {z},A 180.0,B 0.0,C 180.0}}{suffix}")
        };
        let (cut, travel) = ("$VEL.CP=0.15".to_owned(), "$VEL.CP=0.2".to_owned());
        let expected = [
            to("5.0", "0.0", "40.0", "").replace("LIN", "PTP"),
            to("5.0", "0.0", "25.0", ""),
            cut.clone(),
            to("5.0", "50.0", "25.0", ""),
            travel.clone(),
            to("10.0", "50.0", "25.0", " C_DIS"),
            cut.clone(),
            to("10.0", "0.0", "25.0", ""),
            travel.clone(),
            to("15.0", "0.0", "24.0", " C_DIS"),
            cut.clone(),
            to("15.0", "50.0", "24.0", ""),
            travel.clone(),
            to("15.0", "50.0", "40.0", ""),
            to("15.0", "0.0", "40.0", ""),
            to("5.0", "0.0", "40.0", " C_DIS"),
            to("5.0", "0.0", "20.0", ""),
            cut,
            to("5.0", "50.0", "20.0", ""),
            travel,
            to("5.0", "50.0", "40.0", ""),
            to("5.0", "0.0", "40.0", ""),
        ];
        assert_eq!(moves, expected);
    }

    #[test]
    fn what_cannot_be_milled_is_refused() {
        let blank = Blank { width_mm: 20.0, length_mm: 50.0, height_mm: 30.0 };
        let stem = Stem::new("mill_0123456789ab").unwrap();
        let refused = |layers: &[Vec<Point2>], safety| {
            milling_program(layers, &blank, safety, &setup(), &stem, "00ff").unwrap_err().message
        };
        assert!(refused(&[], 0.0).contains("above the blank"));
        assert!(refused(&[], f64::NAN).contains("above the blank"));
        assert!(refused(&[vec![Point2::new(f64::NAN, 1.0)]], 10.0).contains("no place for a robot"));
        assert!(milling_program(&[], &blank, 10.0, &setup(), &stem, "00ff").is_ok());
    }
}
