//! Frames, joints, speeds and settings as KRL writes them.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion};

use super::ToolDirection;
use crate::planning::geometry::frame::{Frame, Pose};
use crate::planning::program::number::{fixed, rounded};
use crate::planning::program::robot_moves::{Joints, RobotSetup};

/// Decimals of mm and degrees.
const DECIMALS: usize = 4;

/// Decimals of m/s: a thousandth of a mm/s.
const SPEED_DECIMALS: usize = 6;

/// Acceleration along the path in m/s^2. The data that KUKA delivers with arms of this size allow more (2.3); a
/// cutting speed of 0.2 m/s is reached after 10 mm.
const ACCELERATION_M_S2: f64 = 2.0;

/// Acceleration of the orientation in deg/s^2: 90 deg/s are reached after 0.25 s.
const ANGULAR_ACCELERATION_DEG_S2: f64 = 360.0;

/// Speed and acceleration of joint motions in per cent. There are three of them, and between them nobody has looked
/// at the way, so they are slow enough to be stopped by hand.
const JOINT_PERCENT: u32 = 20;

/// How many motions the control looks ahead: its own default, and enough for every rounded move.
const ADVANCE: u32 = 3;

/// A pose of the tool as `{X 1.0,Y 2.0,Z 3.0,A 0.0,B 90.0,C 0.0}`, with the tool axis that the cell wants.
#[must_use]
pub fn pose_words(pose: &Pose, direction: ToolDirection) -> String {
    frame_words(&Frame::of(&written(pose, direction)))
}

/// The pose whose axes are those of the cell's tools. Along X: X' = Z, Y' = Y, Z' = -X of the neutral axes.
fn written(pose: &Pose, direction: ToolDirection) -> Pose {
    match direction {
        ToolDirection::Z => *pose,
        ToolDirection::X => {
            let axes = Matrix3::new(0.0, 0.0, -1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0);
            let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes));
            Pose::from_parts(pose.translation, pose.rotation * turn)
        }
    }
}

fn frame_words(frame: &Frame) -> String {
    let Frame { x_mm, y_mm, z_mm, a_deg, b_deg, c_deg } = *frame;
    components(&[("X", x_mm), ("Y", y_mm), ("Z", z_mm), ("A", a_deg), ("B", b_deg), ("C", c_deg)])
}

/// Joint angles as `{A1 0.0,A2 -90.0,A3 90.0,A4 0.0,A5 0.0,A6 0.0}`.
pub(crate) fn joints_words(joints: &Joints) -> String {
    let [a1, a2, a3, a4, a5, a6] = *joints;
    components(&[("A1", a1), ("A2", a2), ("A3", a3), ("A4", a4), ("A5", a5), ("A6", a6)])
}

fn components(values: &[(&str, f64)]) -> String {
    let words: Vec<_> =
        values.iter().map(|(name, value)| format!("{name} {}", fixed(*value, DECIMALS))).collect();
    format!("{{{}}}", words.join(","))
}

/// `$VEL.CP=` for a speed in mm/s.
#[must_use]
pub fn path_speed(mm_s: f64) -> String {
    format!("$VEL.CP={}", fixed(mm_s / 1000.0, SPEED_DECIMALS))
}

/// An output that changes when the next motion begins.
pub(crate) fn trigger(output: u32, on: bool) -> String {
    format!("TRIGGER WHEN DISTANCE=0 DELAY=0 DO $OUT[{output}]={}", truth(on))
}

fn truth(on: bool) -> &'static str {
    if on { "TRUE" } else { "FALSE" }
}

/// The fold with which every program of KSS 8 begins.
pub(crate) fn initial_lines() -> Vec<String> {
    indented(&[
        ";FOLD INI",
        ";FOLD BASISTECH INI",
        "GLOBAL INTERRUPT DECL 3 WHEN $STOPMESS==TRUE DO IR_STOPM ( )",
        "INTERRUPT ON 3",
        "BAS (#INITMOV,0 )",
        ";ENDFOLD (BASISTECH INI)",
        ";ENDFOLD (INI)",
    ])
}

/// Everything that holds throughout a program, indented as in the body of a DEF: frames, load, speeds,
/// accelerations, how ends are rounded off, and the ultrasonic off.
#[must_use]
pub fn setup_lines(setup: &RobotSetup) -> Vec<String> {
    let turn = fixed(setup.speeds.angular_deg_s, DECIMALS);
    let turn_acceleration = fixed(ANGULAR_ACCELERATION_DEG_S2, DECIMALS);
    indented(&[
        ";FOLD SETUP",
        &format!("$OUT[{}]=FALSE", setup.ultrasonic_output),
        &format!("$TOOL={}", frame_words(&setup.tool)),
        &format!("$BASE={}", frame_words(&setup.base)),
        ";A MASS OF -1: THE LOAD THAT THE MACHINE DATA OF THE ARM GIVE",
        "$LOAD={M -1.0,CM {X 0.0,Y 0.0,Z 0.0,A 0.0,B 0.0,C 0.0},J {X 0.0,Y 0.0,Z 0.0}}",
        "$IPO_MODE=#BASE",
        "$ORI_TYPE=#VAR",
        &format!("$ADVANCE={ADVANCE}"),
        &format!("BAS (#VEL_PTP,{JOINT_PERCENT} )"),
        &format!("BAS (#ACC_PTP,{JOINT_PERCENT} )"),
        &path_speed(setup.speeds.travel_mm_s),
        &format!("$VEL.ORI1={turn}"),
        &format!("$VEL.ORI2={turn}"),
        &format!("$ACC.CP={}", fixed(ACCELERATION_M_S2, DECIMALS)),
        &format!("$ACC.ORI1={turn_acceleration}"),
        &format!("$ACC.ORI2={turn_acceleration}"),
        &format!("$APO.CDIS={}", fixed(setup.blend_mm, DECIMALS)),
        ";ENDFOLD (SETUP)",
    ])
}

/// The first motions: by joints, so that there is one way only to stand there.
pub(crate) fn opening_moves(setup: &RobotSetup) -> Vec<String> {
    let stations = std::iter::once(&setup.home).chain(&setup.approach);
    stations.map(|joints| format!("  PTP {}", joints_words(joints))).collect()
}

/// The end: the ultrasonic goes off as the arm goes home. The second switching off waits until it is there.
pub(crate) fn closing_lines(setup: &RobotSetup) -> Vec<String> {
    indented(&[
        &trigger(setup.ultrasonic_output, false),
        &format!("PTP {}", joints_words(&setup.home)),
        &format!("$OUT[{}]=FALSE", setup.ultrasonic_output),
    ])
}

fn indented(lines: &[&str]) -> Vec<String> {
    lines.iter().map(|line| format!("  {line}")).collect()
}

/// Whether a speed in mm/s is still one when it is written in m/s; the speed itself if not.
pub(super) fn least_path_speed(mm_s: f64) -> Result<(), f64> {
    written_speed(mm_s, mm_s / 1000.0, SPEED_DECIMALS)
}

/// Whether a speed in deg/s is still one when it is written; the speed itself if not.
pub(super) fn least_turn_speed(deg_s: f64) -> Result<(), f64> {
    written_speed(deg_s, deg_s, DECIMALS)
}

fn written_speed(speed: f64, in_units: f64, decimals: usize) -> Result<(), f64> {
    let writable = speed.is_finite() && speed <= super::LARGEST && rounded(in_units, decimals) > 0.0;
    if writable { Ok(()) } else { Err(speed) }
}
