//! One way to cut a part, carried through: tips, path, text, read back, replayed.

use super::cell::Cell;
use super::follow;
use super::input::{CutInput, Setting};
use super::lattice::{Spacing, tips};
use super::lattice_kind::Lattice;
use super::path::paired;
use super::replay::cuts::WantedCut;
use super::replay::{Replay, ReplaySetup, replay};
use super::section::{Reach, Section};
use crate::planning::budget::Budget;
use crate::planning::finding::{Code, Finding, any_error};
use crate::planning::geometry::Point2;
use crate::planning::honeycomb::blade::Side;
use crate::planning::outcome::ProgramFile;
use crate::planning::program::krl::emit::emit;
use crate::planning::program::krl::read::execute;
use crate::planning::program::krl::stem::Stem;
use crate::planning::program::number::rounded;
use crate::planning::program::robot_moves::{Joints, RobotProgram, Speeds};

/// Decimals of places and angles in a program, mm and degrees.
pub const DECIMALS: usize = 4;

/// Layers of tips, (x, z) in mm, from the top.
pub type Tips = Vec<Vec<Point2>>;

/// A part cut in one way.
#[derive(Debug)]
pub struct Attempt {
    /// The lattice.
    pub lattice: Lattice,
    /// Its spacing.
    pub spacing: Spacing,
    /// Its tips.
    pub tips: Tips,
    /// Where the robot's joints are when the first straight move begins; none without a robot, or where none can be.
    pub approach: Option<Joints>,
    /// The program.
    pub files: Vec<ProgramFile>,
    /// What it does.
    pub replay: Replay,
    /// What is wrong with it.
    pub findings: Vec<Finding>,
}

impl Attempt {
    /// Whether nothing is wrong with it.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        !any_error(&self.findings)
    }
}

/// The tips of a lattice on the part, at places that a program can print.
///
/// # Errors
/// A lattice with more tips than are planned, or with none.
pub fn lattice_tips(lattice: Lattice, spacing: &Spacing, input: &CutInput) -> Result<Tips, Finding> {
    let Setting { blank, blade, process } = &input.setting;
    let reach = Reach::of(blade, blade.max_cutting_length.mm());
    let refuse = |words: String| Finding::error(Code::NoParameters, "/input/plan", words);
    let section =
        Section::new(blank.width_mm, blank.height_mm, &input.profile, process.allowance_mm, reach.cutting)
            .map_err(|fault| refuse(fault.to_string()))?;
    let layers = tips(lattice, spacing, &section, &reach).map_err(|fault| refuse(fault.to_string()))?;
    if layers.is_empty() {
        return Err(refuse("no tip of this lattice lies between the contour and the blank's top".to_owned()));
    }
    Ok(layers.iter().map(|layer| layer.iter().map(printed).collect()).collect())
}

fn printed(tip: &Point2) -> Point2 {
    Point2::new(rounded(tip.x, DECIMALS), rounded(tip.y, DECIMALS))
}

/// The slits of some tips.
#[must_use]
pub fn wanted(tips: &Tips, swing: f64) -> Vec<WantedCut> {
    let both = |tip: &Point2| [Side::Left, Side::Right].map(|side| WantedCut { tip: *tip, side, swing });
    tips.iter().flatten().flat_map(both).collect()
}

/// Writes the program of some tips to run at some speeds, and reads and replays it.
///
/// # Errors
/// What cannot be written as a program; `BudgetSpent`, `Cancelled`.
pub fn carry_through(
    (lattice, spacing): (Lattice, Spacing),
    speeds: Speeds,
    input: &CutInput,
    cell: &Cell,
    input_sha256: &str,
    budget: &Budget<'_>,
) -> Result<Attempt, Finding> {
    let tips = lattice_tips(lattice, &spacing, input)?;
    budget.spend(STEPS_OF_A_TIP * tips.iter().map(Vec::len).sum::<usize>() as u64)?;
    let layers = paired(&tips, spacing.swing, &input.setting);
    let approach = match &cell.robot {
        Some(robot) => {
            let way = follow::planned(&layers, &speeds, cell);
            follow::approach(robot, &way, budget)?.map(|joints| joints.map(|angle| rounded(angle, DECIMALS)))
        }
        None => None,
    };
    let setup = cell.setup(&input.setting.process, speeds, approach);
    let files = emit(&RobotProgram { setup, layers }, &stem(input_sha256), input_sha256)?;
    let (replayed, findings) =
        read_and_replay(&files, &input.setting, Some(&input.profile), &wanted(&tips, spacing.swing), cell);
    Ok(Attempt { lattice, spacing, tips, approach, files, replay: replayed, findings })
}

/// What a tip costs of a budget, in steps: its slits, its text and its replay take some twenty microseconds.
const STEPS_OF_A_TIP: u64 = 10_000;

/// Reads a program back from its own text, its main file first, and replays it.
#[must_use]
pub fn read_and_replay(
    files: &[ProgramFile],
    setting: &Setting,
    profile: Option<&[Point2]>,
    wanted: &[WantedCut],
    cell: &Cell,
) -> (Replay, Vec<Finding>) {
    let names: Vec<String> = files.iter().map(|file| file.name.clone()).collect();
    let main = names.first().map_or("", String::as_str);
    let setup = ReplaySetup { names: &names, setting, profile, wanted, cell };
    match execute(files, main) {
        Ok(events) => replay(&setup, &events),
        Err(faults) => {
            let (nothing, _) = replay(&setup, &[]);
            (nothing, faults)
        }
    }
}

/// A name for the programs of an input, made of its hash: digits only after the prefix, so that it is no word of KRL.
#[must_use]
pub fn stem(input_sha256: &str) -> Stem {
    named("vcut", input_sha256)
}

/// The name of the milling path of an input.
#[must_use]
pub fn milling_stem(input_sha256: &str) -> Stem {
    named("mill", input_sha256)
}

fn named(prefix: &str, input_sha256: &str) -> Stem {
    let number = input_sha256.get(..8).and_then(|hex| u32::from_str_radix(hex, 16).ok()).unwrap_or(0);
    Stem::new(&format!("{prefix}_{number:010}")).expect("letters, an underscore and ten digits are a stem")
}
