//! The robot cell of a honeycomb job, checked; and what a program is written with where none is given.

use super::wire;
use crate::planning::catalogue::Catalogue;
use crate::planning::document::files::Files;
use crate::planning::finding::{Code, Finding};
use crate::planning::geometry::frame::{Frame, Pose};
use crate::planning::outcome::sha256_hex;
use crate::planning::program::robot_moves::{Joints, RobotSetup, Speeds, ToolDirection};
use crate::planning::robot::arm::{self, Arm, ArmReference};
use crate::planning::robot::check::Robot;
use nalgebra::{UnitQuaternion, Vector3};

/// A robot cell.
#[derive(Debug, Clone)]
pub struct Cell {
    /// The arm in its cell; none where the job names no cell.
    pub robot: Option<Robot>,
    /// Its name and the hash of the whole of it: a program is for this cell and no other.
    pub identity: Option<Identity>,
    /// The tip in the flange.
    pub tool: Frame,
    /// The part in the robot's frame.
    pub base: Frame,
    /// Along which axis of its frame the tool points.
    pub tool_direction: ToolDirection,
    /// Where programs begin and end.
    pub home: Joints,
    /// The longest sub-program, in lines.
    pub max_lines: usize,
    /// The digital output of the ultrasonic generator.
    pub ultrasonic_output: u32,
    /// How far the end of a free move may be rounded off.
    pub blend_mm: f64,
}

/// Which cell a program is for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Identity {
    /// The name of the cell, or of its arm if it has none.
    pub name: String,
    /// The [`fingerprint`] of the cell.
    pub sha256: String,
}

/// Candle position of a KUKA arm with the forearm level: where programs without a cell begin.
const USUAL_HOME: Joints = [0.0, -90.0, 90.0, 0.0, 0.0, 0.0];

/// Checks the cell of a job and takes it over. Without `files` an arm that stands in one is taken as right and left
/// out: that is for who only checks a document.
pub fn check(
    reference: Option<&wire::CellReference>,
    catalogue: &Catalogue,
    files: Option<&Files>,
    faults: &mut Vec<Finding>,
) -> Cell {
    const AT: &str = "/input/cell";
    match reference {
        None => Cell::unknown(),
        Some(wire::CellReference::Inline(cell)) => taken_over(cell, files, AT, faults),
        Some(wire::CellReference::Named(name)) => match catalogue.robot_cell(name, AT) {
            Ok(cell) => taken_over(cell, files, AT, faults),
            Err(fault) => {
                faults.push(fault);
                Cell::unknown()
            }
        },
    }
}

/// Checks a cell that is to be registered.
///
/// # Errors
/// Every fault with pointers below `at`: those of any cell, and an arm in a file, for a machine brings none.
pub fn check_profile(cell: &wire::Cell, at: &str) -> Result<(), Vec<Finding>> {
    let mut faults = Vec::new();
    if let ArmReference::File(_) = &cell.robot {
        let message =
            "a machine's profile brings no files: put the arm itself here, or the name of a built-in one";
        faults.push(Finding::error(Code::UnknownFile, format!("{at}/robot/file"), message));
    }
    taken_over(cell, None, at, &mut faults);
    if faults.is_empty() { Ok(()) } else { Err(faults) }
}

/// The SHA-256 of a cell without its name, and with its arm in full: cells with the same one can run each other's
/// programs, others must not. Where an arm comes from, a name, a file or the cell itself, makes no difference.
#[must_use]
pub fn fingerprint(cell: &wire::Cell) -> String {
    let arm = arm::resolve(&cell.robot, &arm::Catalogue::built_in(), None, "");
    hashed(cell, arm.ok().flatten().as_ref())
}

fn hashed(cell: &wire::Cell, arm: Option<&Arm>) -> String {
    let robot = arm.map_or_else(|| cell.robot.clone(), |arm| ArmReference::Inline(Box::new(arm.clone())));
    let nameless = wire::Cell { name: None, kind: None, robot, ..cell.clone() };
    sha256_hex(&serde_json::to_vec(&nameless).unwrap_or_default())
}

fn taken_over(cell: &wire::Cell, files: Option<&Files>, at: &str, faults: &mut Vec<Finding>) -> Cell {
    let arm = arm::resolve(&cell.robot, &arm::Catalogue::built_in(), files, &format!("{at}/robot"));
    let arm = arm.unwrap_or_else(|found| {
        faults.extend(found);
        None
    });
    let identity = arm.as_ref().map(|arm| Identity {
        name: cell.name.as_ref().unwrap_or(&arm.name).clone(),
        sha256: hashed(cell, Some(arm)),
    });
    let robot = arm.and_then(|arm| {
        let robot = Robot::new(arm, cell.tool_frame.pose(), cell.base_frame.pose(), cell.home_deg);
        robot.map_err(|found| faults.extend(found)).ok()
    });
    if let Some(robot) = &robot {
        faults.extend(home_faults(robot, at));
    }
    Cell {
        robot,
        identity,
        tool: cell.tool_frame,
        base: cell.base_frame,
        tool_direction: match cell.tool_direction {
            wire::ToolDirection::Z => ToolDirection::Z,
            wire::ToolDirection::X => ToolDirection::X,
        },
        home: cell.home_deg,
        max_lines: cell.max_program_lines as usize,
        ultrasonic_output: cell.ultrasonic_output,
        blend_mm: cell.blend_mm,
    }
}

fn home_faults(robot: &Robot, at: &str) -> Vec<Finding> {
    let joints = robot.home().iter().zip(&robot.arm().joints).enumerate();
    joints
        .filter(|(_, (angle, joint))| !(joint.min_deg..=joint.max_deg).contains(*angle))
        .map(|(index, (angle, joint))| {
            let message = format!(
                "A{} is {angle} degrees; it goes from {} to {}",
                index + 1,
                joint.min_deg,
                joint.max_deg
            );
            Finding::error(Code::OutOfRange, format!("{at}/home_deg/{index}"), message)
        })
        .collect()
}

impl Cell {
    /// What programs are written with where no cell is given: frames that a person has to set.
    fn unknown() -> Self {
        Self {
            robot: None,
            identity: None,
            tool: Frame::default(),
            base: Frame::default(),
            tool_direction: ToolDirection::Z,
            home: USUAL_HOME,
            max_lines: wire::MOST_LINES as usize,
            ultrasonic_output: wire::FIRST_OUTPUT,
            blend_mm: wire::BLEND_MM,
        }
    }

    /// What a control must know before the first move.
    #[must_use]
    pub fn setup(&self, process: &wire::Process, speeds: Speeds, approach: Option<Joints>) -> RobotSetup {
        RobotSetup {
            tool: self.tool,
            base: self.base,
            tool_direction: self.tool_direction,
            home: self.home,
            approach,
            speeds,
            // What is rounded off stays above the blank.
            blend_mm: self.blend_mm.min(process.safety_distance_mm),
            ultrasonic_output: self.ultrasonic_output,
            max_lines: self.max_lines,
        }
    }

    /// A neutral pose, whose Z points out through the tip, as the robot's tool frame has it.
    #[must_use]
    pub fn as_programmed(&self, neutral: &Pose) -> Pose {
        match self.tool_direction {
            ToolDirection::Z => *neutral,
            ToolDirection::X => Pose::from_parts(neutral.translation, neutral.rotation * x_to_z().inverse()),
        }
    }

    /// The other way round.
    #[must_use]
    pub fn as_neutral(&self, programmed: &Pose) -> Pose {
        match self.tool_direction {
            ToolDirection::Z => *programmed,
            ToolDirection::X => Pose::from_parts(programmed.translation, programmed.rotation * x_to_z()),
        }
    }
}

/// The turn after which Z points where X did.
fn x_to_z() -> UnitQuaternion<f64> {
    UnitQuaternion::from_axis_angle(&Vector3::y_axis(), std::f64::consts::FRAC_PI_2)
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use super::*;

    fn cell() -> Value {
        let frame = json!({"x_mm": 0, "y_mm": 0, "z_mm": 300, "a_deg": 0, "b_deg": 0, "c_deg": 0});
        json!({"robot": "kr210-l150", "tool_frame": frame, "base_frame": frame, "home_deg": [0, -90, 90, 0, 0, 0]})
    }

    fn arm() -> Value {
        serde_json::to_value(arm::Catalogue::built_in().get("kr210-l150").unwrap()).unwrap()
    }

    fn changed(change: impl FnOnce(&mut Value)) -> wire::Cell {
        let mut value = cell();
        change(&mut value);
        serde_json::from_value(value).unwrap()
    }

    /// What a job with this cell and these files is planned for, and the faults.
    fn checked(cell: wire::Cell, files: Option<&Files>) -> (Option<Identity>, Vec<(Code, String)>) {
        let (reference, mut faults) = (wire::CellReference::Inline(Box::new(cell)), Vec::new());
        let cell = check(Some(&reference), &Catalogue::built_in(), files, &mut faults);
        (cell.identity, faults.into_iter().map(|fault| (fault.code, fault.at)).collect())
    }

    #[test]
    fn the_name_of_a_cell_and_where_its_arm_comes_from_do_not_tell_cells_apart() {
        let plain = fingerprint(&changed(|_| {}));
        let named = changed(|cell| {
            cell["name"] = json!("k-1");
            cell["kind"] = json!("robot-cell");
            cell["blend_mm"] = json!(wire::BLEND_MM);
        });
        assert_eq!(fingerprint(&named), plain);
        assert_eq!(fingerprint(&changed(|cell| cell["robot"] = arm())), plain);
        let mut files = Files::default();
        files.insert("arm.json".to_owned(), arm().to_string().into_bytes()).unwrap();
        let in_a_file = changed(|cell| cell["robot"] = json!({"file": "arm.json"}));
        let (identity, faults) = checked(in_a_file.clone(), Some(&files));
        let identity = identity.unwrap();
        assert_eq!((identity.sha256, identity.name.as_str(), faults), (plain.clone(), "kr210-l150", vec![]));
        assert_eq!(checked(named, None).0.unwrap(), Identity { name: "k-1".to_owned(), sha256: plain });
        assert_eq!(checked(in_a_file, None), (None, vec![]), "a file is judged when the job is planned");
    }

    #[test]
    fn everything_else_in_a_cell_and_its_arm_does() {
        let mut hashes = vec![fingerprint(&changed(|_| {}))];
        let changes: [fn(&mut Value); 9] = [
            |cell| cell["robot"] = json!("kr210-r3100-2"),
            |cell| cell["tool_frame"]["c_deg"] = json!(0.001),
            |cell| cell["base_frame"]["x_mm"] = json!(0.001),
            |cell| cell["home_deg"][5] = json!(1),
            |cell| cell["tool_direction"] = json!("x"),
            |cell| cell["max_program_lines"] = json!(2_499),
            |cell| cell["ultrasonic_output"] = json!(2),
            |cell| cell["blend_mm"] = json!(1),
            |cell| {
                cell["robot"] = arm();
                cell["robot"]["joints"][5]["max_deg"] = json!(349);
            },
        ];
        hashes.extend(changes.map(|change| fingerprint(&changed(change))));
        hashes.sort();
        hashes.dedup();
        assert_eq!(hashes.len(), 10);
    }

    #[test]
    fn a_machine_has_no_files() {
        let in_a_file = changed(|cell| cell["robot"] = json!({"file": "arm.json"}));
        let faults = check_profile(&in_a_file, "/profile").unwrap_err();
        assert_eq!((faults.len(), faults[0].code), (1, Code::UnknownFile));
        assert_eq!(faults[0].at, "/profile/robot/file");
        assert!(check_profile(&changed(|_| {}), "/profile").is_ok());
    }
}
