//! Random plies: whatever is planned passes its replay; whatever is refused is refused for want of knives.

use bladeplan::planning::budget::Budget;
use bladeplan::planning::document;
use bladeplan::planning::document::files::Files;
use bladeplan::planning::finding::Code;
use bladeplan::planning::outcome::{Outcome, Verdict};
use bladeplan::planning::tape::machine::Catalogue;
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestCaseError;
use serde_json::{Value, json};

use crate::linuxcnc::plan;
use crate::rounds::runner;

/// A star-shaped ply with a round cut-out somewhere, at a fibre angle, on a plane of its own in space.
#[derive(Debug, Clone)]
pub struct Ply {
    radii: Vec<f64>,
    points_per_side: usize,
    hole: Option<(f64, f64)>,
    angle: f64,
    width: f64,
    tilt: f64,
}

/// Plies of which most, not all, can be cut.
pub fn plies() -> impl Strategy<Value = Ply> {
    (
        prop::collection::vec(120.0..300.0_f64, 3..9),
        1..40_usize,
        prop::option::of((0.0..60.0_f64, 5.0..40.0_f64)),
        0.0..360.0_f64,
        40.0..160.0_f64,
        -60.0..60.0_f64,
    )
        .prop_map(|(radii, points_per_side, hole, angle, width, tilt)| Ply {
            radii,
            points_per_side,
            hole,
            angle,
            width,
            tilt,
        })
}

impl Ply {
    /// From the plane of the ply into space: turned about x.
    fn place(&self, x: f64, y: f64) -> [f64; 3] {
        let (sin, cos) = self.tilt.to_radians().sin_cos();
        [x, y * cos, y * sin]
    }

    fn normal(&self) -> [f64; 3] {
        let (sin, cos) = self.tilt.to_radians().sin_cos();
        [0.0, -sin, cos]
    }

    fn outline(&self) -> Vec<[f64; 3]> {
        let corner = |i: usize| {
            let angle = std::f64::consts::TAU * i as f64 / self.radii.len() as f64;
            let radius = self.radii[i % self.radii.len()];
            (radius * angle.cos(), radius * angle.sin())
        };
        let sides = (0..self.radii.len()).map(|i| (corner(i), corner(i + 1)));
        let points = sides.flat_map(|(a, b)| {
            (0..self.points_per_side).map(move |k| {
                let t = k as f64 / self.points_per_side as f64;
                (a.0 + t * (b.0 - a.0), a.1 + t * (b.1 - a.1))
            })
        });
        points.map(|(x, y)| self.place(x, y)).collect()
    }

    fn holes(&self) -> Vec<Value> {
        let circle = |(distance, radius): (f64, f64)| {
            // The least inner radius of three corners at 120 mm is 60 mm; the cut-out stays within it.
            let radius = radius.min(55.0 - distance.min(45.0));
            let points: Vec<_> = (0..90)
                .map(|i| f64::from(i * 4).to_radians())
                .map(|a| self.place(distance.min(45.0) + radius * a.cos(), radius * a.sin()))
                .collect();
            json!({"points": points})
        };
        self.hole.map(circle).into_iter().collect()
    }

    fn tracks(&self) -> Vec<Value> {
        let (sin, cos) = self.angle.to_radians().sin_cos();
        let count = (300.0 / self.width).ceil() as i32;
        let courses = (-count..=count).enumerate();
        courses
            .map(|(index, course)| {
                let v = f64::from(course) * self.width;
                let points: Vec<_> = [-300.0, 0.0, 300.0]
                    .map(|u| json!({"position": self.place(u * cos - v * sin, u * sin + v * cos), "normal": self.normal()}))
                    .to_vec();
                json!({"number": index + 1, "points": points})
            })
            .collect()
    }

    /// Width of its tape in mm.
    pub fn width(&self) -> f64 {
        self.width
    }

    /// Its job.
    pub fn job(&self) -> Value {
        json!({"kind": "tape-cut", "input": {
            "tape": {"width_mm": self.width, "thickness_mm": 0.125},
            "boundary": {"points": self.outline()}, "holes": self.holes(), "tracks": self.tracks(),
            "machine": "two-cutter-lab"}})
    }

    /// The job of this ply and another one, of tape as wide as this one's, on one roll.
    pub fn job_with(&self, other: &Self) -> Value {
        let fields = |ply: &Self| json!({"boundary": {"points": ply.outline()}, "holes": ply.holes(), "tracks": ply.tracks()});
        let mut job = self.job();
        let input = job["input"].as_object_mut().unwrap();
        input.retain(|name, _| name == "tape" || name == "machine");
        let other = Self { width: self.width, ..other.clone() };
        input.insert("plies".to_owned(), json!([fields(self), fields(&other)]));
        job
    }

    /// Plans its job.
    pub fn plan(&self) -> Outcome {
        self.plan_with(json!({}))
    }

    /// Plans its job on a machine: a name, or a whole profile.
    pub fn plan_on(&self, machine: &Value) -> Outcome {
        let mut job = self.job();
        job["input"]["machine"] = machine.clone();
        planned(&job)
    }

    /// Plans its job with these options.
    pub fn plan_with(&self, options: Value) -> Outcome {
        let mut job = self.job();
        job["input"]["options"] = options;
        planned(&job)
    }
}

fn planned(job: &Value) -> Outcome {
    let document = document::read(job.to_string().as_bytes()).unwrap();
    plan(&document, &Files::default(), &Catalogue::built_in(), &Budget::unwatched()).unwrap()
}

/// The figures of the replay of a program that can be cut.
pub fn check_replay(outcome: &Outcome) -> Result<(), TestCaseError> {
    let replay = &outcome.report["replay"];
    prop_assert!(replay["max_deviation_mm"].as_f64().unwrap() <= 0.011, "{}", replay);
    prop_assert!(replay["uncut_mm"].as_f64().unwrap() <= 0.02, "{}", replay);
    prop_assert!(replay["unwanted_mm"].as_f64().unwrap() <= 0.02, "{}", replay);
    let (time, bound) = (&outcome.report["time_s"], &outcome.report["bound_time_s"]);
    prop_assert!(time.as_f64() >= bound.as_f64(), "{} {}", time, bound);
    Ok(())
}

#[test]
fn every_planned_ply_passes_its_replay() {
    let mut usable = 0;
    let mut runner = runner(500);
    let allocations = prop::sample::select(vec!["by_slope", "free"]);
    let rolls = (plies(), allocations, prop::sample::select(vec!["reject", "simplify"]), any::<bool>());
    let result = runner.run(&rolls, |(ply, allocation, on_excess, share_cuts)| {
        let options = json!({"allocation": allocation, "on_excess": on_excess, "share_cuts": share_cuts});
        let outcome = ply.plan_with(options);
        let errors: Vec<_> = outcome.findings.iter().filter(|finding| finding.is_error()).collect();
        prop_assert!(errors.iter().all(|finding| finding.code == Code::TooManyKnives), "{:?}", errors);
        prop_assert_eq!(errors.is_empty(), outcome.verdict == Verdict::Usable);
        if errors.is_empty() {
            check_replay(&outcome)?;
        }
        Ok(())
    });
    result.unwrap();
    // The strategy must not drift into refusals only.
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    for _ in 0..40 {
        let ply = plies().new_tree(&mut runner).unwrap().current();
        usable += usize::from(ply.plan().verdict == Verdict::Usable);
    }
    assert!(usable >= 10, "only {usable} of 40 random plies can be cut");
}
