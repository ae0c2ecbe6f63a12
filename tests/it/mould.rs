//! Plies on a cylinder: what is refused and said there is known only course by course, after development.

use bladeplan::planning::budget::Budget;
use bladeplan::planning::document;
use bladeplan::planning::document::files::Files;
use bladeplan::planning::finding::{Code, Finding};
use bladeplan::planning::outcome::{Outcome, Verdict};
use bladeplan::planning::tape::machine::Catalogue;
use rstest::rstest;
use serde_json::{Value, json};

use crate::linuxcnc::plan;

const RADIUS: f64 = 1000.0;
const WIDTH: f64 = 100.0;

/// A place of the cylinder, whose axis is x, by x and arc, and its normal.
fn onto(x: f64, arc: f64) -> ([f64; 3], [f64; 3]) {
    let (sin, cos) = (arc / RADIUS).sin_cos();
    ([x, RADIUS * sin, RADIUS * cos], [0.0, sin, cos])
}

/// An outline through corners, at intervals of 10 mm or less.
fn outline(corners: &[(f64, f64)]) -> Value {
    let sides = corners.iter().zip(corners.iter().cycle().skip(1));
    let points = sides.flat_map(|(a, b)| {
        let steps = ((b.0 - a.0).hypot(b.1 - a.1) / 10.0).ceil();
        (0..steps as usize).map(move |step| {
            let share = step as f64 / steps;
            onto(a.0 + (b.0 - a.0) * share, a.1 + (b.1 - a.1) * share).0
        })
    });
    json!({"points": points.collect::<Vec<_>>()})
}

/// A course of so many points along x.
fn track(number: u32, arc: f64, x: [f64; 2], points: usize) -> Value {
    let at = |step: usize| {
        let (position, normal) = onto(x[0] + (x[1] - x[0]) * step as f64 / (points - 1) as f64, arc);
        json!({"position": position, "normal": normal})
    };
    json!({"number": number, "points": (0..points).map(at).collect::<Vec<_>>()})
}

/// A ply of 3000 by 300 mm: three courses along x.
fn ply() -> Value {
    let tracks =
        [50.0, 150.0, 250.0].into_iter().zip(1..).map(|(arc, number)| track(number, arc, [0.0, 3000.0], 61));
    json!({"boundary": outline(&[(0.0, 0.0), (3000.0, 0.0), (3000.0, 300.0), (0.0, 300.0)]),
        "tracks": tracks.collect::<Vec<_>>()})
}

fn job(ply: &Value) -> Value {
    let mut input = json!({"tape": {"width_mm": WIDTH, "thickness_mm": 0.125}, "machine": "two-cutter-lab"});
    input.as_object_mut().unwrap().extend(ply.as_object().unwrap().clone());
    json!({"kind": "tape-cut", "input": input})
}

fn planned(job: Value) -> Outcome {
    let job = document::from_value(job).unwrap();
    plan(&job, &Files::default(), &Catalogue::built_in(), &Budget::unwatched()).unwrap()
}

fn with_hole(corners: &[(f64, f64)]) -> Outcome {
    let mut ply = ply();
    ply["holes"] = json!([outline(corners)]);
    planned(job(&ply))
}

fn found(outcome: &Outcome, code: Code) -> &Finding {
    outcome
        .findings
        .iter()
        .find(|finding| finding.code == code)
        .unwrap_or_else(|| panic!("{:?}", outcome.findings))
}

#[test]
fn a_cut_out_inside_is_cut() {
    let outcome = with_hole(&[(1000.0, 130.0), (1100.0, 130.0), (1100.0, 170.0), (1000.0, 170.0)]);
    assert_eq!(outcome.verdict, Verdict::Usable, "{:?}", outcome.findings);
    assert!(outcome.findings.iter().all(|finding| !finding.is_error()), "{:?}", outcome.findings);
}

#[rstest]
#[case::over_the_end_of_a_course(&[(3050.0, 120.0), (3050.0, 180.0), (2950.0, 180.0), (2950.0, 120.0)], Code::HoleOutside)]
#[case::over_the_end_begun_inside(&[(2950.0, 180.0), (2950.0, 120.0), (3050.0, 120.0), (3050.0, 180.0)], Code::OutlineCrosses)]
#[case::beyond_the_end(&[(3020.0, 120.0), (3020.0, 180.0), (3060.0, 180.0), (3060.0, 120.0)], Code::HoleOutside)]
#[case::a_figure_eight(&[(1000.0, 130.0), (1200.0, 170.0), (1200.0, 130.0), (1000.0, 170.0)], Code::OutlineCrosses)]
fn cut_outs_that_do_not_lie_within_the_ply_are_refused(#[case] corners: &[(f64, f64)], #[case] code: Code) {
    let outcome = with_hole(corners);
    assert_eq!(outcome.verdict, Verdict::NotUsable);
    assert!(found(&outcome, code).message.contains("course 2"), "{:?}", outcome.findings);
}

/// Beside the ply, on the other side of the mould or in the air: no course can tell where it is.
#[rstest]
#[case::beside(1000.0, 400.0)]
#[case::behind(1000.0, 3000.0)]
#[case::ahead(9000.0, 150.0)]
fn a_cut_out_that_no_tape_goes_over_is_named(#[case] x: f64, #[case] arc: f64) {
    let outcome = with_hole(&[(x, arc), (x + 50.0, arc), (x + 50.0, arc + 50.0), (x, arc + 50.0)]);
    assert_eq!(outcome.verdict, Verdict::Usable);
    let said = found(&outcome, Code::HoleOutside);
    assert!(
        !said.is_error() && said.at == "/input/holes/0" && said.message.starts_with("no tape goes over"),
        "{said:?}"
    );
}

#[test]
fn a_cut_out_in_a_cut_out_is_refused() {
    let mut ply = ply();
    let square = |from: f64, to: f64| {
        outline(&[
            (900.0 + from, 100.0 + from),
            (900.0 + to, 100.0 + from),
            (900.0 + to, 100.0 + to),
            (900.0 + from, 100.0 + to),
        ])
    };
    ply["holes"] = json!([square(10.0, 90.0), square(40.0, 60.0)]);
    assert!(found(&planned(job(&ply)), Code::HoleOutside).message.contains("inside another"));
}

/// Where nothing is known of the mould no piece can be made, and none may be missing without a word.
#[rstest]
#[case::at_both_ends([1000.0, 2000.0], "it begins and ends within the ply, more than 200 mm before the outline", "")]
#[case::at_its_end([0.0, 2000.0], "it ends within the ply", "/points/40")]
#[case::at_its_start([800.0, 3000.0], "it begins within the ply", "/points/0")]
fn a_course_that_ends_far_inside_the_ply_is_refused(
    #[case] x: [f64; 2],
    #[case] says: &str,
    #[case] at: &str,
) {
    let mut ply = ply();
    ply["tracks"][1] = track(2, 150.0, x, 41);
    let outcome = planned(job(&ply));
    assert_eq!(outcome.verdict, Verdict::NotUsable);
    let fault = found(&outcome, Code::OffMould);
    assert!(fault.message.contains(says) && fault.message.contains("course 2"), "{fault:?}");
    assert_eq!(fault.at, format!("/input/tracks/1{at}"));
    // A cut-out within its tape is not what is wrong.
    ply["holes"] = json!([outline(&[(1400.0, 130.0), (1500.0, 130.0), (1500.0, 170.0), (1400.0, 170.0)])]);
    assert!(found(&planned(job(&ply)), Code::OffMould).message.contains(says));
}

/// On the other side of a tube there is no ply, though it lies behind.
#[test]
fn a_course_on_the_other_side_of_a_tube_is_left_out() {
    let tube = |x: f64, arc: f64| {
        let (sin, cos) = (arc / 200.0).sin_cos();
        ([x, 200.0 * sin, 200.0 * cos], [0.0, sin, cos])
    };
    let track = |number: u32, arc: f64| {
        let at = |step: u32| {
            let (position, normal) = tube(f64::from(step) * 50.0, arc);
            json!({"position": position, "normal": normal})
        };
        json!({"number": number, "points": (0..=60).map(at).collect::<Vec<_>>()})
    };
    let arcs = (0..500).map(|step| f64::from(step) - 250.0);
    let ends = arcs.clone().map(|arc| tube(0.0, arc).0).chain(arcs.rev().map(|arc| tube(3000.0, arc).0));
    let tracks: Vec<_> = [-200.0, -100.0, 0.0, 100.0, 200.0, 400.0]
        .into_iter()
        .zip(1..)
        .map(|(arc, n)| track(n, arc))
        .collect();
    let outcome = planned(job(&json!({"boundary": {"points": ends.collect::<Vec<_>>()}, "tracks": tracks})));
    assert_eq!(outcome.verdict, Verdict::Usable, "{:?}", outcome.findings);
    assert_eq!(found(&outcome, Code::CourseOffPly).at, "/input/tracks/5");
}

#[test]
fn a_course_in_a_cut_out_or_beside_the_ply_is_left_out() {
    let mut ply = ply();
    ply["holes"] = json!([outline(&[(500.0, 90.0), (2500.0, 90.0), (2500.0, 210.0), (500.0, 210.0)])]);
    ply["tracks"]
        .as_array_mut()
        .unwrap()
        .extend([track(4, 150.0, [1000.0, 2000.0], 21), track(5, 600.0, [0.0, 3000.0], 61)]);
    let outcome = planned(job(&ply));
    assert_eq!(outcome.verdict, Verdict::Usable, "{:?}", outcome.findings);
    assert_eq!(outcome.findings.iter().filter(|finding| finding.code == Code::CourseOffPly).count(), 2);
}

#[test]
fn a_course_that_ends_a_little_inside_is_continued_and_that_is_said() {
    let mut ply = ply();
    ply["tracks"][1] = track(2, 150.0, [130.0, 2870.0], 58);
    let outcome = planned(job(&ply));
    assert_eq!(outcome.verdict, Verdict::Usable, "{:?}", outcome.findings);
    let said = found(&outcome, Code::CourseContinued);
    assert!(said.at == "/input/tracks/1" && said.message.contains("130.0 mm beyond the end"), "{said:?}");
    // Within a width it is continued well enough.
    ply["tracks"][1] = track(2, 150.0, [95.0, 2905.0], 58);
    assert!(planned(job(&ply)).findings.iter().all(|finding| finding.code != Code::CourseContinued));
}

/// Round the hoop a course of two points is a chord.
#[test]
fn a_course_of_too_few_points_is_named() {
    let hoop = |points: usize| {
        let at = |step: usize| {
            let (position, normal) = onto(50.0, 200.0 * step as f64 / (points - 1) as f64);
            json!({"position": position, "normal": normal})
        };
        let tracks = json!([{"number": 1, "points": (0..points).map(at).collect::<Vec<_>>()}]);
        planned(job(
            &json!({"boundary": outline(&[(0.0, 0.0), (100.0, 0.0), (100.0, 200.0), (0.0, 200.0)]), "tracks": tracks}),
        ))
    };
    let coarse = found(&hoop(2), Code::CoarseCourse).clone();
    assert!(coarse.is_error() && coarse.message.contains("up to 199."), "{coarse:?}");
    let said = hoop(3);
    let coarse = found(&said, Code::CoarseCourse);
    assert!(!coarse.is_error() && said.verdict == Verdict::Usable, "{coarse:?}");
    assert!(hoop(11).findings.iter().all(|finding| finding.code != Code::CoarseCourse));
}

#[test]
fn a_fault_on_the_mould_of_a_second_ply_stands_in_that_ply() {
    let mut bad = ply();
    bad["holes"] = json!([outline(&[(3020.0, 120.0), (3020.0, 180.0), (3060.0, 180.0), (3060.0, 120.0)])]);
    let outcome = planned(job(&json!({"plies": [ply(), bad]})));
    let fault = found(&outcome, Code::HoleOutside);
    assert!(fault.at == "/input/plies/1/holes/0" && fault.message.contains("course 2 of ply 2"), "{fault:?}");
}

/// A plane that stands at a slant, printed with two decimals, is a plane all the same: its outline is checked as a whole.
#[test]
fn a_printed_plane_is_flat() {
    let at = |x: f64, y: f64| [x, y * 0.8, y * 0.6].map(|c| (c * 100.0).round() / 100.0);
    let corner = |k: u32| {
        let turn = f64::from(k) / 200.0 * std::f64::consts::TAU;
        at(333.0 * turn.cos(), 333.0 * turn.sin())
    };
    let boundary: Vec<_> = (0..200).map(corner).collect();
    let ply = json!({"boundary": {"points": boundary}, "courses": {"angle_deg": 30}});
    assert_eq!(planned(job(&ply)).verdict, Verdict::Usable);
}
