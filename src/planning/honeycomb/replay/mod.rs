//! A program run on what it cuts: read from its text, motion by motion, on the section of the blank.
//!
//! `motion` makes straight motions of events, `class` says what each of them is, `cuts` holds the slits that were
//! made against those that were wanted, `sweep` cuts the section with them.

pub mod class;
pub mod cuts;
pub mod motion;
pub mod sweep;

use self::class::{Class, Classed, MadeCut, classify};
use self::cuts::WantedCut;
use self::motion::{Happening, Place};
use self::sweep::Swept;
use super::cell::Cell;
use super::input::Setting;
use crate::planning::finding::Finding;
use crate::planning::geometry::Point2;
use crate::planning::program::robot_events::RobotExecuted;

/// What a program is held against.
pub struct ReplaySetup<'a> {
    /// Names of the program's files, for findings.
    pub names: &'a [String],
    /// Blank, blade, speeds and limits.
    pub setting: &'a Setting,
    /// The finished contour; none where nobody has said what the part is.
    pub profile: Option<&'a [Point2]>,
    /// The slits that are wanted.
    pub wanted: &'a [WantedCut],
    /// The cell whose frames must be set.
    pub cell: &'a Cell,
}

impl ReplaySetup<'_> {
    /// A place of the program as findings name it.
    #[must_use]
    pub fn at(&self, (file, line): Place) -> String {
        format!("{}:{line}", self.names.get(file).map_or("program", String::as_str))
    }
}

/// How long a program takes, by what it does meanwhile, in s. Joint motions are not counted.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Times {
    /// In cuts.
    pub cutting_s: f64,
    /// While the blade turns, wherever it goes meanwhile.
    pub turning_s: f64,
    /// Otherwise.
    pub moving_s: f64,
}

impl Times {
    /// All of it.
    #[must_use]
    pub fn total_s(&self) -> f64 {
        self.cutting_s + self.turning_s + self.moving_s
    }

    fn of(classed: &[Classed<'_>]) -> Self {
        classed.iter().fold(Self::default(), |mut times, (motion, class)| {
            match class {
                Class::Cut(_) => times.cutting_s += motion.seconds,
                Class::Turn => times.turning_s += motion.seconds,
                Class::Free => times.moving_s += motion.seconds,
            }
            times
        })
    }
}

/// What a replay gives.
#[derive(Debug)]
pub struct Replay {
    /// What happens, for those who look at the robot.
    pub happenings: Vec<Happening>,
    /// The slits, in order.
    pub made: Vec<MadeCut>,
    /// The time it takes.
    pub times: Times,
    /// The largest distance of a slit's tip from the wanted one, in mm.
    pub cut_deviation_mm: f64,
    /// The section as it is cut.
    pub swept: Swept,
}

impl Replay {
    /// How many places the tip cuts at.
    #[must_use]
    pub fn tips(&self) -> usize {
        cuts::different_tips(&self.made)
    }

    /// The figures in words.
    #[must_use]
    pub fn words(&self) -> String {
        let scallop = self.swept.remains.as_ref().and_then(|remains| remains.scallop.as_ref());
        format!(
            "{} tips, {} cuts within {:.4} mm of the planned ones, {:.3} s counted, scallop {:.3} mm",
            self.tips(),
            self.made.len(),
            self.cut_deviation_mm,
            self.times.total_s(),
            scallop.map_or(0.0, |scallop| scallop.distance)
        )
    }
}

/// Runs the events of a program. Findings that are errors say why it must not run.
#[must_use]
pub fn replay(setup: &ReplaySetup<'_>, events: &[RobotExecuted]) -> (Replay, Vec<Finding>) {
    let (happenings, mut findings) = motion::run(setup, events);
    let (made, times) = {
        let (classed, faults) = classify(setup, &happenings);
        findings.extend(faults);
        let cut = |(_, class): &Classed<'_>| match class {
            Class::Cut(made) => Some(*made),
            Class::Turn | Class::Free => None,
        };
        (classed.iter().filter_map(cut).collect::<Vec<_>>(), Times::of(&classed))
    };
    let (cut_deviation_mm, faults) = cuts::compare(setup, &made);
    findings.extend(faults);
    let (swept, faults) = sweep::sweep(setup, &made);
    findings.extend(faults);
    (Replay { happenings, made, times, cut_deviation_mm, swept }, findings)
}
