//! Random plies of every kind: folds, concave lobes, noise, several cut-outs, narrow ones and slivers, flat and on
//! curved moulds. Whatever is planned passes its replay; whatever is refused is refused for want of knives.

use std::cell::RefCell;
use std::collections::BTreeMap;

use bladeplan::planning::budget::Budget;
use bladeplan::planning::document;
use bladeplan::planning::document::files::Files;
use bladeplan::planning::finding::Code;
use bladeplan::planning::outcome::{Outcome, Verdict};
use bladeplan::planning::tape::machine::Catalogue;
use proptest::prelude::*;
use proptest::test_runner::TestCaseError;
use serde_json::{Value, json};

use crate::linuxcnc::plan;
use crate::random_plies::check_replay;
use crate::rounds::{rounds, runner};

mod mould;
mod outline;

use mould::{Mould, Side, sides};
use outline::{Figure, figures};

/// A ply of a figure on a mould, under tapes at an angle.
#[derive(Debug, Clone)]
struct Wild {
    figure: Figure,
    side: Side,
    angle: f64,
    width: f64,
    /// Where the first tape lies, in shares of a tape's width.
    shift: f64,
    options: (&'static str, &'static str, bool),
}

fn wild_plies() -> impl Strategy<Value = Wild> {
    let options = (
        prop::sample::select(vec!["by_slope", "free"]),
        prop::sample::select(vec!["reject", "simplify", "simplify"]),
        any::<bool>(),
    );
    (figures(), sides(), 0.0..std::f64::consts::TAU, 40.0..160.0_f64, 0.0..1.0_f64, options).prop_map(
        |(figure, side, angle, width, shift, options)| Wild { figure, side, angle, width, shift, options },
    )
}

impl Wild {
    fn job(&self) -> Value {
        let (allocation, on_excess, share_cuts) = self.options;
        let mut loops = self.figure.loops().into_iter().map(|points| {
            json!({"points": points.into_iter().map(|point| self.side.place(point)).collect::<Vec<_>>()})
        });
        let boundary = loops.next().unwrap();
        json!({"kind": "tape-cut", "input": {
            "tape": {"width_mm": self.width, "thickness_mm": 0.125},
            "boundary": boundary, "holes": loops.collect::<Vec<_>>(), "tracks": self.tracks(),
            "machine": "two-cutter-lab",
            "options": {"allocation": allocation, "on_excess": on_excess, "share_cuts": share_cuts}}})
    }

    /// Courses side by side over all of the figure.
    fn tracks(&self) -> Vec<Value> {
        let (sin, cos) = self.angle.sin_cos();
        let count = (self.figure.radius() / self.width).ceil() as i32 + 1;
        let courses = (-count..=count).enumerate().map(|(index, course)| {
            let v = (f64::from(course) + self.shift) * self.width;
            let points = self.side.course((-v * sin, v * cos), self.angle).into_iter();
            let points = points.map(|(at, normal)| json!({"position": at, "normal": normal}));
            json!({"number": index + 1, "points": points.collect::<Vec<_>>()})
        });
        courses.collect()
    }

    /// The area of the figure less its cut-outs, and the length of all of its loops.
    fn measures(&self) -> (f64, f64) {
        let (mut area, mut length) = (0.0, 0.0);
        for (index, points) in self.figure.loops().iter().enumerate() {
            let mut of_loop = 0.0;
            for (i, a) in points.iter().enumerate() {
                let b = points[(i + 1) % points.len()];
                of_loop += 0.5 * (a.0 * b.1 - b.0 * a.1);
                length += (b.0 - a.0).hypot(b.1 - a.1);
            }
            area += if index == 0 { of_loop } else { -of_loop };
        }
        (area, length)
    }

    fn kind(&self) -> &'static str {
        match self.side.mould {
            Mould::Flat(_) => "flat",
            Mould::Cylinder(_) => "cylinder",
            Mould::Cone(..) => "cone",
            Mould::Ring(..) => "ring",
        }
    }
}

/// The plan of a ply, which is a valid input.
fn planned(ply: &Wild) -> Result<Outcome, TestCaseError> {
    let document = document::read(ply.job().to_string().as_bytes()).unwrap();
    plan(&document, &Files::default(), &Catalogue::built_in(), &Budget::unwatched())
        .map_err(|faults| TestCaseError::fail(format!("refused: {faults:?}")))
}

fn check(ply: &Wild) -> Result<Verdict, TestCaseError> {
    let outcome = planned(ply)?;
    let errors: Vec<_> = outcome.findings.iter().filter(|finding| finding.is_error()).collect();
    prop_assert!(errors.iter().all(|finding| finding.code == Code::TooManyKnives), "{:?}", errors);
    prop_assert_eq!(errors.is_empty(), outcome.verdict == Verdict::Usable);
    if errors.is_empty() {
        check_replay(&outcome)?;
        check_area(ply, &outcome)?;
    }
    Ok(outcome.verdict)
}

/// Tapes side by side share out the ply where lengths on the mould are those of the plane; what was changed adds to it.
fn check_area(ply: &Wild, outcome: &Outcome) -> Result<(), TestCaseError> {
    if !ply.side.mould.keeps_lengths() {
        return Ok(());
    }
    let sum = |list: &Value, field: &str| -> f64 {
        list.as_array().unwrap().iter().map(|entry| entry[field].as_f64().unwrap()).sum()
    };
    let pieces = sum(&outcome.report["manifest"], "area_mm2");
    let extra = sum(&outcome.report["simplified"], "extra_area_mm2");
    let (area, length) = ply.measures();
    // Developed to a hundredth along the outline and along both edges of each tape.
    let edges = 2.0 * 700.0 * (2.0 * ply.figure.radius() / ply.width + 4.0);
    let off = (pieces - extra - area).abs();
    prop_assert!(off <= 0.01 * (length + edges), "{} of {} mm2 are missing", off, area);
    Ok(())
}

#[test]
fn every_wild_ply_that_is_planned_passes_its_replay() {
    let seen = RefCell::new(BTreeMap::new());
    let result = runner(500).run(&wild_plies(), |ply| {
        let verdict = check(&ply)?;
        let mut seen = seen.borrow_mut();
        let (usable, all) = seen.entry(ply.kind()).or_insert((0_u32, 0_u32));
        *usable += u32::from(verdict == Verdict::Usable);
        *all += 1;
        Ok(())
    });
    result.unwrap();
    // The strategy must not drift into refusals only, on no mould.
    let seen = seen.into_inner();
    assert_eq!(seen.values().map(|(_, all)| all).sum::<u32>(), rounds(500));
    assert!(seen.len() == 4 && seen.values().all(|(usable, all)| 4 * usable >= *all), "{seen:?}");
}
