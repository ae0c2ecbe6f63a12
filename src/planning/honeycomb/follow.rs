//! Whether the cell's robot can follow a program, as it was read back (domain.md B5).

use super::cell::Cell;
use super::replay::motion::{Happening, Place};
use crate::planning::budget::Budget;
use crate::planning::finding::{Code, Finding};
use crate::planning::program::robot_moves::{Joints, Layer, Purpose, RobotStep, Speeds};
use crate::planning::robot::base_search::propose;
use crate::planning::robot::check::{Motion, PathStep, Robot, RobotCheck, check};
use crate::planning::robot::{fault, travel};
use crate::planning::tolerance::SINGULAR_WARNING_DEG;

/// The way of the joints through a program.
#[must_use]
pub fn path(happenings: &[Happening], cell: &Cell) -> Vec<PathStep> {
    let step =
        |place: &Place, motion| PathStep { place: fault::Place { file: place.0, line: place.1 }, motion };
    happenings
        .iter()
        .filter_map(|happening| match happening {
            Happening::Straight(motion) => {
                let (from, to) = (cell.as_programmed(&motion.from), cell.as_programmed(&motion.to));
                Some(step(&motion.place, Motion::Straight { from, to, duration_s: motion.seconds }))
            }
            Happening::Joints { joints: Some(joints), place, .. } => Some(step(place, Motion::Axes(*joints))),
            Happening::Joints { joints: None, to: Some(to), place, .. } => {
                Some(step(place, Motion::AxesToPose(cell.as_programmed(to))))
            }
            Happening::Joints { .. } => None,
        })
        .collect()
}

/// The straight moves of planned layers, from the first place on.
#[must_use]
pub fn planned(layers: &[Layer], speeds: &Speeds, cell: &Cell) -> Vec<PathStep> {
    let moves = layers.iter().flat_map(|layer| &layer.steps).filter_map(|step| match step {
        RobotStep::Move { to, purpose } => Some((cell.as_programmed(to), *purpose)),
        RobotStep::Ultrasonic { .. } => None,
    });
    let mut path: Vec<PathStep> = Vec::new();
    let mut before = None;
    for (to, purpose) in moves {
        if let Some(from) = before.replace(to) {
            let speed = if purpose == Purpose::Cut { speeds.cutting_mm_s } else { speeds.travel_mm_s };
            let duration_s = travel::duration_s(&from, &to, speed, speeds.angular_deg_s);
            let motion = Motion::Straight { from, to, duration_s };
            path.push(PathStep { place: fault::Place { file: 0, line: 0 }, motion });
        }
    }
    path
}

/// Where the joints have to be when the first straight move begins: where the arm can follow from, or fails least.
///
/// # Errors
/// `BudgetSpent`, `Cancelled`.
pub fn approach(robot: &Robot, path: &[PathStep], budget: &Budget<'_>) -> Result<Option<Joints>, Finding> {
    Ok(check(robot, None, path, budget)?.start)
}

/// What is said where there is no robot to check.
#[must_use]
pub fn not_checked() -> Finding {
    let message = "no cell is given, so no robot was checked: the program cannot be approved; add input.cell";
    Finding::warning(Code::RobotNotChecked, "/input/cell", message)
}

/// Runs the robot along a program.
///
/// # Errors
/// `BudgetSpent`, `Cancelled`.
pub fn follow(robot: &Robot, path: &[PathStep], budget: &Budget<'_>) -> Result<RobotCheck, Finding> {
    check(robot, None, path, budget)
}

/// The speeds at which the arm can follow, where only its joints' speeds stand against those that were asked for: the
/// blade turns slower. None if nothing has to be lowered, if speed is not what is wrong, or if it would take less than
/// half of the speed: another place for the part is the better answer then.
#[must_use]
pub fn slowed(check: &RobotCheck, speeds: &Speeds) -> Option<Speeds> {
    let ratio = check.max_joint_speed_ratio;
    let too_fast_only = check.reachable && check.first_fault.is_some_and(|first| !first.fault.is_of_place());
    if !too_fast_only || ratio <= 1.0 || ratio * SLOWEST_SHARE > 1.0 {
        return None;
    }
    let lowered = |speed: f64| {
        let scale = 10_f64.powi(SPEED_DECIMALS);
        (speed / (ratio * ROOM) * scale).floor() / scale
    };
    Some(Speeds {
        cutting_mm_s: speeds.cutting_mm_s,
        travel_mm_s: speeds.travel_mm_s,
        angular_deg_s: lowered(speeds.angular_deg_s),
    })
}

/// Says that a program turns the blade slower than the process asks for. `joint` and `ratio` are the joint that would
/// have been too fast, and by how much; `times_s` those of the program at the wanted and at the lowered speed.
#[must_use]
pub fn said_slower(
    (joint, ratio): (usize, f64),
    wanted: &Speeds,
    speeds: &Speeds,
    [before, after]: [f64; 2],
) -> Finding {
    let message = format!(
        "the blade turns at {} degrees/s instead of {}, for which A{joint} would have to turn {ratio:.2} times as fast as \
         it can; the program takes {after:.1} s instead of {before:.1} s. Another place for the part, or a faster arm, saves that",
        speeds.angular_deg_s, wanted.angular_deg_s
    );
    Finding::warning(Code::SlowedForRobot, "/input/process/angular_speed_deg_s", message)
}

/// A robot may be asked to run at no less than this share of the speed that was wanted.
const SLOWEST_SHARE: f64 = 0.5;
/// Speeds are lowered by a hundredth more than the joint needs: a slower turn changes the share that travel has in it.
const ROOM: f64 = 1.01;
/// Lowered speeds have so many decimals, in mm/s and deg/s.
const SPEED_DECIMALS: i32 = 1;

/// What a check has found. A fault is an error that names the line; where the part lies wrong, a place is proposed that
/// works.
///
/// # Errors
/// `BudgetSpent`, `Cancelled`.
pub fn findings(
    found: &RobotCheck,
    robot: &Robot,
    path: &[PathStep],
    names: &[String],
    budget: &Budget<'_>,
) -> Result<Vec<Finding>, Finding> {
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    if let Some(first) = &found.first_fault {
        let farther = match found.min_joint_margin_deg {
            // The first fault is then one of speed, which slower turns would mend.
            Some(margin) if !found.reachable && !first.fault.is_of_place() && margin < 0.0 => {
                format!(
                    "; farther on a joint would stand {:.1} degrees beyond its range, at any speed",
                    -margin
                )
            }
            _ => String::new(),
        };
        let message = format!("the robot {} cannot follow: {}{farther}", robot.arm().name, first.fault);
        let fault = Finding::error(Code::RobotFault, first.at(&names), message);
        return Ok(vec![fault, proposal(robot, path, budget)?]);
    }
    let near = found.min_singularity_margin.filter(|margin| *margin < SINGULAR_WARNING_DEG);
    let warn = |margin: f64| {
        let message = format!("the robot passes a singularity at a distance of {margin:.2} degrees");
        Finding::warning(Code::NearSingularity, "", message)
    };
    Ok(near.map(warn).into_iter().collect())
}

fn proposal(robot: &Robot, path: &[PathStep], budget: &Budget<'_>) -> Result<Finding, Finding> {
    let message = match propose(robot, path, budget)? {
        Some(place) => {
            let frame = place.base;
            format!(
                "this arm can follow with base_frame x_mm {} y_mm {} z_mm {} a_deg {} b_deg {} c_deg {} (moved by {:?} mm, turned by {} degrees)",
                frame.x_mm,
                frame.y_mm,
                frame.z_mm,
                frame.a_deg,
                frame.b_deg,
                frame.c_deg,
                place.moved_mm,
                place.turned_deg
            )
        }
        None => "no place for the part was found about the given one where this arm can follow; turn the part, or take another arm or slower speeds".to_owned(),
    };
    Ok(Finding::info(Code::RobotFault, "/input/cell/base_frame", message))
}
