//! Where else the part could lie, when an arm cannot follow where it lies.
//!
//! Where the part lies decides much (domain.md B5): cuts along the robot's reach are followed by arms that cannot follow
//! the same cuts across it. So the part is turned about the vertical through the middle of the path, and moved, over a
//! fixed grid; a coarse look ranks the places, and the best ones are checked in full.

use nalgebra::{Point3, Translation3, UnitQuaternion, Vector3};

use super::check::{Motion, PathStep, Robot, RobotCheck, check};
use super::survey::{self, Sketch};
use crate::planning::budget::Budget;
use crate::planning::finding::Finding;
use crate::planning::geometry::frame::{Frame, Pose};
use crate::planning::program::number::rounded;

/// A place for the part where an arm can follow.
#[derive(Debug, Clone, PartialEq)]
pub struct Placement {
    /// The part's frame in the robot's, in digits that a person can set.
    pub base: Frame,
    /// How far the middle of the path has moved in the robot's frame, in mm.
    pub moved_mm: [f64; 3],
    /// How far the part has turned about the robot's vertical, in degrees.
    pub turned_deg: f64,
    /// What the check finds there.
    pub check: RobotCheck,
}

/// Steps of the turn about the vertical, in degrees: 24 of them go round.
const TURN_DEG: f64 = 15.0;
/// Along and across the foot's X, in mm: a table can be moved by a metre.
const SIDEWAYS_MM: [f64; 5] = [0.0, -250.0, 250.0, -500.0, 500.0];
/// Up and down, in mm: what a stand can make up for.
const UPWARD_MM: [f64; 3] = [0.0, -200.0, 200.0];
/// So many of the most promising places are checked in full.
const MOST_CHECKED: usize = 6;
/// Decimals of mm and degrees in a proposed frame.
const DECIMALS: usize = 3;

/// The freest of some 1,800 places about the given one where the arm can follow the straight moves of a path, or none.
/// Steps of another kind are left out: their joints hold for the given place only.
///
/// # Errors
/// `BudgetSpent`, `Cancelled`.
pub fn propose(robot: &Robot, path: &[PathStep], budget: &Budget) -> Result<Option<Placement>, Finding> {
    let path: Vec<_> =
        path.iter().filter(|step| matches!(step.motion, Motion::Straight { .. })).copied().collect();
    let middle = middle(&path).filter(|middle| (robot.base() * middle).coords.norm().is_finite());
    let Some(middle) = middle else { return Ok(None) };
    let mut best: Option<Placement> = None;
    for shift in promising(robot, &path, &middle, budget)? {
        let base = printed(&shift.base(robot, &middle));
        let check = check(&robot.moved_to(base.pose()), None, &path, budget)?;
        let freer = best.as_ref().is_none_or(|best| check.freedom > best.check.freedom);
        if check.passes() && freer {
            best = Some(Placement { base, moved_mm: shift.moved_mm, turned_deg: shift.turned_deg, check });
        }
    }
    Ok(best)
}

/// A place of the grid.
#[derive(Debug, Clone, Copy)]
struct Shift {
    moved_mm: [f64; 3],
    turned_deg: f64,
}

impl Shift {
    /// The part's frame in the robot's, there.
    fn base(&self, robot: &Robot, middle: &Point3<f64>) -> Pose {
        let pivot = (robot.base() * middle).coords;
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), self.turned_deg.to_radians());
        let moved = Vector3::from(self.moved_mm);
        Translation3::from(pivot + moved) * turn * Translation3::from(-pivot) * robot.base()
    }
}

/// The places that promise most, the best first; of equals the one nearer to the given place.
fn promising(
    robot: &Robot,
    path: &[PathStep],
    middle: &Point3<f64>,
    budget: &Budget,
) -> Result<Vec<Shift>, Finding> {
    let sketch = Sketch::of(path);
    let mut ranked: Vec<(f64, Shift)> = Vec::new();
    for shift in grid() {
        let there = robot.moved_to(shift.base(robot, middle));
        // A place is of interest only if it is freer than the last of those that will be checked.
        let floor = ranked.get(MOST_CHECKED - 1).map_or(0.0, |(freedom, _)| *freedom);
        let prospects = survey::prospects(&there, &sketch, floor, budget)?;
        let freedom = prospects.iter().map(|prospect| prospect.freedom).fold(f64::NEG_INFINITY, f64::max);
        if freedom > floor {
            let rank = ranked.partition_point(|(other, _)| *other >= freedom);
            ranked.insert(rank, (freedom, shift));
            ranked.truncate(MOST_CHECKED);
        }
    }
    Ok(ranked.into_iter().map(|(_, shift)| shift).collect())
}

/// Every place, the given one first.
fn grid() -> impl Iterator<Item = Shift> {
    let turns = (0..24).map(|turn| TURN_DEG * f64::from(if turn > 12 { turn - 24 } else { turn }));
    let moves = SIDEWAYS_MM
        .into_iter()
        .flat_map(|x| SIDEWAYS_MM.map(|y| (x, y)))
        .flat_map(|(x, y)| UPWARD_MM.map(|z| [x, y, z]));
    moves.flat_map(move |moved_mm| turns.clone().map(move |turned_deg| Shift { moved_mm, turned_deg }))
}

/// The middle of the box about the ends of all moves, in the part's frame.
fn middle(path: &[PathStep]) -> Option<Point3<f64>> {
    let ends = path.iter().filter_map(|step| match &step.motion {
        Motion::Straight { from, to, .. } => Some([from.translation.vector, to.translation.vector]),
        _ => None,
    });
    let ends: Vec<_> = ends.flatten().collect();
    let low = ends.iter().copied().reduce(|a, b| a.inf(&b))?;
    let high = ends.iter().copied().reduce(|a, b| a.sup(&b))?;
    Some(Point3::from((low + high) * 0.5))
}

fn printed(base: &Pose) -> Frame {
    let Frame { x_mm, y_mm, z_mm, a_deg, b_deg, c_deg } = Frame::of(base);
    let digits = |value| rounded(value, DECIMALS);
    Frame {
        x_mm: digits(x_mm),
        y_mm: digits(y_mm),
        z_mm: digits(z_mm),
        a_deg: digits(a_deg),
        b_deg: digits(b_deg),
        c_deg: digits(c_deg),
    }
}
