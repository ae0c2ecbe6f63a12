//! The machine of a tape-cut job: a profile from JSON, checked, with its units as types.

use super::spool::{Spool, Turning};
use super::stroke::DECIMALS;
use super::wire;
use super::words::{self, Words};
use crate::planning::finding::{Code, Finding};
use crate::planning::outcome::sha256_hex;
use crate::planning::program::moves::Pose;
use crate::planning::program::number::rounded;
use crate::planning::tolerance::{OFFSET_SHARE, SPOOL_SHARE};
use crate::planning::units::{
    Acceleration, Angle, AngularAcceleration, AngularSpeed, Duration, Length, Speed,
};

pub use super::wire::{CutSide, Dialect, Edges};
pub use crate::planning::catalogue::Catalogue;

/// A two-cutter (or one-cutter) platform.
#[derive(Debug, Clone, PartialEq)]
pub struct Machine {
    /// Its name.
    pub name: String,
    /// The language of its control.
    pub dialect: Dialect,
    /// The side of the tape on which the knives work.
    pub cut_side: CutSide,
    /// The tape axis.
    pub feed: Feed,
    /// Speed of a knife along its cut in the tape, whatever the axes could do.
    pub max_cutting_path_speed: Speed,
    /// One or two cutters by station, the one nearer the spool first.
    pub cutters: Vec<Cutter>,
    /// The distance across the tape that two carriages keep, if they share a beam.
    pub beam_clearance: Option<Length>,
    /// Digital output of the knives' generator.
    pub ultrasonic_output: u32,
    /// Whether the operator may stop before each course.
    pub optional_stop_per_course: bool,
    /// The longest line of a program, in characters.
    pub max_line_characters: usize,
    /// The words that switch knives and generator, where the dialect needs them.
    pub words: Option<Words>,
    /// The [`fingerprint`] of its profile.
    pub profile_sha256: String,
}

impl Machine {
    /// The longest overcut of its cutters.
    #[must_use]
    pub fn overcut(&self) -> Length {
        Length::from_mm(self.cutters.iter().map(|cutter| cutter.overcut.mm()).fold(0.0, f64::max))
    }

    /// How far the tape must run beyond the last cut for axes that lead their edges, and before the first one for axes
    /// that trail behind them, in mm.
    #[must_use]
    pub fn ahead_and_behind_mm(&self) -> (f64, f64) {
        let offsets = || self.cutters.iter().map(|cutter| cutter.offset.mm());
        (offsets().fold(0.0, f64::max), offsets().map(|offset| -offset).fold(0.0, f64::max))
    }

    /// Where all axes are when a program begins: at 0, the carriages where they are parked.
    #[must_use]
    pub fn home(&self) -> Pose {
        let mut home = Pose::default();
        for (at, cutter) in home.lateral_mm.iter_mut().zip(&self.cutters) {
            *at = cutter.park_mm();
        }
        home
    }

    /// The time after which every knife that was told to come up is up.
    #[must_use]
    pub fn settled(&self) -> Duration {
        let longest = self.cutters.iter().map(|cutter| cutter.up_dwell.s()).fold(0.0, f64::max);
        Duration::from_s(longest)
    }
}

/// The tape axis. It may stop; it must never run backwards.
#[derive(Debug, Clone, PartialEq)]
pub struct Feed {
    /// Axis letter.
    pub axis: char,
    /// Largest speed.
    pub max_speed: Speed,
    /// Largest acceleration.
    pub max_acceleration: Acceleration,
    /// The longest tape in one program.
    pub max_length: Length,
    /// The spool that the axis turns; none if the axis reads a measured length.
    pub spool: Option<Spool>,
    /// How far off the tape may stand.
    pub error: Length,
}

impl Feed {
    /// The way by which a move keeps the tape's limits of speed and acceleration, in mm: a spool turns evenly, so the
    /// tape runs fastest where its radius is largest.
    #[must_use]
    pub fn way_mm(&self, from_mm: f64, to_mm: f64) -> f64 {
        let Some(spool) = &self.spool else { return (to_mm - from_mm).abs() };
        let turn = (spool.angle_deg(to_mm) - spool.angle_deg(from_mm)).to_radians();
        spool.largest_radius_mm(from_mm, to_mm) * turn.abs()
    }

    /// What is left of a chord tolerance for thinning, in mm: a turning spool bends straight cuts.
    #[must_use]
    pub fn thinning_mm(&self, tolerance_mm: f64) -> f64 {
        if self.spool.is_some() { (1.0 - SPOOL_SHARE) * tolerance_mm } else { tolerance_mm }
    }
}

/// A cutter: carriage, blade and press.
#[derive(Debug, Clone, PartialEq)]
pub struct Cutter {
    /// 1 is nearer the spool.
    pub number: u32,
    /// Distance downstream (toward +U) of the U zero.
    pub station: Length,
    /// Axis letter of the carriage.
    pub lateral_axis: char,
    /// Travel of the carriage, smallest and largest.
    pub lateral_range: (Length, Length),
    /// Speed of the carriage with the knife down.
    pub cutting_speed: Speed,
    /// Speed of the carriage with the knife up.
    pub travel_speed: Speed,
    /// Largest acceleration of the carriage.
    pub lateral_acceleration: Acceleration,
    /// Where the carriage stands at the start and at the end, if the profile says so.
    pub park: Option<Length>,
    /// How far off the carriage may stand.
    pub lateral_error: Length,
    /// Axis letter of the blade.
    pub blade_axis: char,
    /// Whether the blade cuts both ways.
    pub edges: Edges,
    /// Largest speed of turning.
    pub blade_speed: AngularSpeed,
    /// Largest acceleration of turning.
    pub blade_acceleration: AngularAcceleration,
    /// Range of the blade axis, smallest and largest.
    pub blade_range: (Angle, Angle),
    /// How far the edge trails behind the axis that turns it, along the cut.
    pub offset: Length,
    /// How far a cut goes on past its ends where no piece lies.
    pub overcut: Length,
    /// A sharper corner is turned with the knife up.
    pub lift_angle: Angle,
    /// Digital output of the press.
    pub knife_output: u32,
    /// Time to settle after the knife goes down.
    pub down_dwell: Duration,
    /// Time to settle after the knife goes up.
    pub up_dwell: Duration,
}

impl Cutter {
    /// Where the carriage stands at the start, in mm: over the middle of the tape if the profile says nothing.
    #[must_use]
    pub fn park_mm(&self) -> f64 {
        self.park.map_or(0.0, Length::mm)
    }

    /// Whether the edge of its blade lies beside the axis that turns it, so that the axis goes another way than the cut.
    #[must_use]
    pub fn swivels(&self) -> bool {
        self.offset.mm() != 0.0
    }

    /// What is left of a chord tolerance for thinning the cuts of its edge, in mm, of so much that the tape leaves.
    #[must_use]
    pub fn thinning_mm(&self, left_mm: f64, tolerance_mm: f64) -> f64 {
        if self.swivels() { left_mm - OFFSET_SHARE * tolerance_mm } else { left_mm }
    }
}

/// `two-cutter-lab` is exactly the profile of jobs.md.
const TWO_CUTTER_LAB: &str = include_str!("two-cutter-lab.json");

/// The built-in profile.
///
/// # Panics
/// Never: the built-in profile is part of the source and a test reads it.
#[must_use]
pub fn two_cutter_lab() -> wire::MachineProfile {
    serde_json::from_str(TWO_CUTTER_LAB).expect("the built-in profile fits its own type")
}

/// Resolves a job's machine: looks up its name, or takes the profile that stands in the job.
///
/// # Errors
/// `UnknownMachine`, `WrongMachine`, or every fault of the profile, with pointers below `at`.
pub fn resolve(
    reference: &wire::MachineReference,
    catalogue: &Catalogue,
    at: &str,
) -> Result<Machine, Vec<Finding>> {
    match reference {
        wire::MachineReference::Inline(profile) => check(profile, at),
        wire::MachineReference::Named(name) => {
            check(catalogue.tape_cutter(name, at).map_err(|fault| vec![fault])?, at)
        }
    }
}

/// Checks a profile and takes it over.
///
/// # Errors
/// Every fault of the profile, with pointers below `at`.
pub fn check(profile: &wire::MachineProfile, at: &str) -> Result<Machine, Vec<Finding>> {
    let mut faults = Vec::new();
    check_beam(profile, at, &mut faults);
    check_spool(&profile.feed, at, &mut faults);
    check_cutters(profile, at, &mut faults);
    check_letters(profile, at, &mut faults);
    check_outputs(profile, at, &mut faults);
    let words = words::check(profile, at).unwrap_or_else(|found| {
        faults.extend(found);
        None
    });
    if faults.is_empty() { Ok(take_over(profile, words)) } else { Err(faults) }
}

/// The SHA-256 of a profile without its name: machines with the same one can run each other's programs, others
/// must not.
///
/// # Panics
/// Never: a profile holds nothing but numbers, texts and lists of them.
#[must_use]
pub fn fingerprint(profile: &wire::MachineProfile) -> String {
    let nameless = wire::MachineProfile { name: String::new(), ..profile.clone() };
    sha256_hex(&serde_json::to_vec(&nameless).expect("a profile can be written as JSON"))
}

/// The distance that carriages keep which share a beam: that of two whose stations are closer to one another.
fn shared_beam(profile: &wire::MachineProfile) -> Option<f64> {
    let [one, other] = profile.cutters.as_slice() else { return None };
    let clearance_mm = profile.carriage_clearance_mm;
    ((other.station_mm - one.station_mm).abs() < clearance_mm).then_some(clearance_mm)
}

/// Carriages on one beam cannot pass one another, so where they are parked settles which is above.
fn check_beam(profile: &wire::MachineProfile, at: &str, faults: &mut Vec<Finding>) {
    let park = |cutter: &wire::Cutter| cutter.lateral.park_mm.unwrap_or(0.0);
    for (index, cutter) in profile.cutters.iter().enumerate() {
        let (low, high) = (cutter.lateral.min_mm, cutter.lateral.max_mm);
        if cutter.lateral.park_mm.is_some() && !(low..=high).contains(&park(cutter)) {
            let message = format!("the carriage travels from {low} to {high} mm and is parked there");
            let at = format!("{at}/cutters/{index}/lateral/park_mm");
            faults.push(Finding::error(Code::OutOfRange, at, message));
        }
    }
    let Some(clearance_mm) = shared_beam(profile) else { return };
    let apart_mm = (park(&profile.cutters[0]) - park(&profile.cutters[1])).abs();
    if apart_mm < clearance_mm {
        let message = format!(
            "carriages whose stations are closer than {clearance_mm} mm share a beam and are parked at least so far apart \
             (lateral.park_mm of both cutters), not {apart_mm} mm"
        );
        faults.push(Finding::error(Code::OutOfRange, format!("{at}/carriage_clearance_mm"), message));
    }
}

/// A smaller offset, in mm, is none. It is the positioning of the platform's knives (domain.md A1), and LinuxCNC feeds no
/// slower than 0.1 mm/min: round an edge so near its axis a blade would turn faster than it may.
const SMALLEST_OFFSET_MM: f64 = 0.01;

fn check_cutters(profile: &wire::MachineProfile, at: &str, faults: &mut Vec<Finding>) {
    for (index, cutter) in profile.cutters.iter().enumerate() {
        let here = format!("{at}/cutters/{index}");
        if cutter.number as usize != index + 1 {
            let message = format!("cutters are numbered 1, 2 in this order; here stands {}", cutter.number);
            faults.push(Finding::error(Code::OutOfRange, format!("{here}/number"), message));
        }
        if cutter.blade.offset_mm != 0.0 && cutter.blade.offset_mm.abs() < SMALLEST_OFFSET_MM {
            let message = format!(
                "an offset of less than {SMALLEST_OFFSET_MM} mm is within the positioning of knives; say 0"
            );
            faults.push(Finding::error(Code::OutOfRange, format!("{here}/blade/offset_mm"), message));
        }
        if cutter.blade.offset_mm != 0.0 && cutter.blade.edges == wire::Edges::Double {
            let message = "an edge beside the axis of its blade is the only one: a second would cut in front of the axis, \
                           where nobody asked for it; let edges be single, or offset_mm 0";
            faults.push(Finding::error(Code::ConflictingFields, format!("{here}/blade/edges"), message));
        }
        if cutter.lateral.min_mm >= cutter.lateral.max_mm {
            let message = "min_mm must be smaller than max_mm";
            faults.push(Finding::error(Code::OutOfRange, format!("{here}/lateral/min_mm"), message));
        }
    }
    if let [first, second] = profile.cutters.as_slice()
        && second.station_mm <= first.station_mm
    {
        let message = "cutter 2 sits downstream of cutter 1: its station must be larger";
        faults.push(Finding::error(Code::OutOfRange, format!("{at}/cutters/1/station_mm"), message));
    }
}

fn check_spool(feed: &wire::Feed, at: &str, faults: &mut Vec<Finding>) {
    let at = format!("{at}/feed/spool");
    match (&feed.spool, feed.drive) {
        (None, wire::Drive::Length) => {}
        (None, _) => {
            let message = "an axis that turns a spool needs its radii and the thickness of a layer";
            faults.push(Finding::error(Code::MissingField, at, message));
        }
        (Some(_), wire::Drive::Length) => {
            let message = "an axis that reads a measured length turns no spool; leave it out";
            faults.push(Finding::error(Code::OutOfRange, at, message));
        }
        (Some(spool), _) => {
            if spool.roll_radius_mm < spool.core_radius_mm {
                let message = "the roll cannot be smaller than its core";
                faults.push(Finding::error(Code::OutOfRange, format!("{at}/roll_radius_mm"), message));
            }
        }
    }
}

fn check_letters(profile: &wire::MachineProfile, at: &str, faults: &mut Vec<Finding>) {
    let mut letters = vec![(format!("{at}/feed/axis"), &profile.feed.axis)];
    for (index, cutter) in profile.cutters.iter().enumerate() {
        letters.push((format!("{at}/cutters/{index}/lateral/axis"), &cutter.lateral.axis));
        letters.push((format!("{at}/cutters/{index}/blade/axis"), &cutter.blade.axis));
    }
    refuse_repeats(&letters, "axis letter", faults);
    let free_feed = profile.feed.drive != wire::Drive::Length && profile.dialect != Dialect::Linuxcnc;
    // RS-274 reads A, B and C in degrees and the others in mm, whatever is meant. A spool's degrees stand on one of
    // the others too: LinuxCNC reckons the feed of a block by X, Y, Z, then U, V, W, then A, B, C, and a spool beside
    // a carriage that barely moves would run as fast as it can.
    for (pointer, letter) in letters.iter().skip(usize::from(free_feed)) {
        if pointer.ends_with("blade/axis") != ["A", "B", "C"].contains(&letter.as_str()) {
            let message = "A, B and C turn blades (degrees); U, V, W, X, Y and Z move (mm)";
            faults.push(Finding::error(Code::OutOfRange, pointer.clone(), message));
        }
    }
}

fn check_outputs(profile: &wire::MachineProfile, at: &str, faults: &mut Vec<Finding>) {
    let mut outputs = vec![(format!("{at}/ultrasonic/output"), profile.ultrasonic.output)];
    for (index, cutter) in profile.cutters.iter().enumerate() {
        outputs.push((format!("{at}/cutters/{index}/knife/output"), cutter.knife.output));
    }
    refuse_repeats(&outputs, "output", faults);
}

fn refuse_repeats<T: PartialEq + std::fmt::Display>(
    named: &[(String, T)],
    what: &str,
    faults: &mut Vec<Finding>,
) {
    for (index, (pointer, value)) in named.iter().enumerate() {
        if let Some((other, _)) = named[..index].iter().find(|(_, earlier)| earlier == value) {
            let message = format!("{what} {value} is taken already by {other}");
            faults.push(Finding::error(Code::OutOfRange, pointer.clone(), message));
        }
    }
}

fn take_over(profile: &wire::MachineProfile, words: Option<Words>) -> Machine {
    Machine {
        name: profile.name.clone(),
        dialect: profile.dialect,
        cut_side: profile.cut_side,
        feed: Feed {
            axis: letter(&profile.feed.axis),
            max_speed: Speed::from_mm_s(profile.feed.max_speed_mm_s),
            max_acceleration: Acceleration::from_mm_s2(profile.feed.max_acceleration_mm_s2),
            max_length: Length::from_mm(profile.feed.max_length_mm),
            spool: take_over_spool(&profile.feed),
            error: Length::from_mm(profile.feed.error_mm.unwrap_or(0.0)),
        },
        max_cutting_path_speed: Speed::from_mm_s(profile.max_cutting_path_speed_mm_s),
        cutters: profile.cutters.iter().map(take_over_cutter).collect(),
        beam_clearance: shared_beam(profile).map(Length::from_mm),
        ultrasonic_output: profile.ultrasonic.output,
        optional_stop_per_course: profile.program.optional_stop_per_course,
        max_line_characters: profile.program.max_line_characters as usize,
        words,
        profile_sha256: fingerprint(profile),
    }
}

fn take_over_spool(feed: &wire::Feed) -> Option<Spool> {
    let turning = match feed.drive {
        wire::Drive::Length => return None,
        wire::Drive::UnwindAngle => Turning::Unwinding,
        wire::Drive::TakeupAngle => Turning::TakingUp,
    };
    feed.spool.map(|spool| Spool {
        turning,
        core_radius_mm: spool.core_radius_mm,
        roll_radius_mm: spool.roll_radius_mm,
        layer_mm: spool.layer_thickness_mm,
        radius_error_mm: spool.radius_error_mm.unwrap_or(0.0),
    })
}

fn take_over_cutter(cutter: &wire::Cutter) -> Cutter {
    let (lateral, blade, knife) = (&cutter.lateral, &cutter.blade, &cutter.knife);
    Cutter {
        number: cutter.number,
        station: Length::from_mm(cutter.station_mm),
        lateral_axis: letter(&lateral.axis),
        lateral_range: (Length::from_mm(lateral.min_mm), Length::from_mm(lateral.max_mm)),
        cutting_speed: Speed::from_mm_s(lateral.cutting_speed_mm_s),
        travel_speed: Speed::from_mm_s(lateral.travel_speed_mm_s),
        lateral_acceleration: Acceleration::from_mm_s2(lateral.max_acceleration_mm_s2),
        park: lateral.park_mm.map(|park| Length::from_mm(rounded(park, DECIMALS))),
        lateral_error: Length::from_mm(lateral.error_mm.unwrap_or(0.0)),
        blade_axis: letter(&blade.axis),
        edges: blade.edges,
        blade_speed: AngularSpeed::from_deg_s(blade.max_speed_deg_s),
        blade_acceleration: AngularAcceleration::from_deg_s2(blade.max_acceleration_deg_s2),
        blade_range: (Angle::from_degrees(blade.min_deg), Angle::from_degrees(blade.max_deg)),
        offset: Length::from_mm(blade.offset_mm),
        overcut: Length::from_mm(blade.overcut_mm),
        lift_angle: Angle::from_degrees(blade.lift_angle_deg),
        knife_output: knife.output,
        down_dwell: Duration::from_s(knife.down_dwell_s),
        up_dwell: Duration::from_s(knife.up_dwell_s),
    }
}

/// The shape admits nothing but one of nine letters.
fn letter(axis: &str) -> char {
    axis.chars().next().expect("an axis is one letter, as its shape says")
}
