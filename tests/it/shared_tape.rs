//! The jobs that come with the task (`../shared/data/tape`), each against the note that lies beside them: what of it can be
//! counted or measured is. A cross-check: where the folder is not at hand, nothing is checked, and that is said.

use std::collections::BTreeMap;
use std::fs;
use std::io::{self, Write};
use std::path::PathBuf;

use bladeplan::planning::finding::Finding;
use bladeplan::planning::outcome::{Outcome, Verdict};
use serde_json::{Value, json};

use crate::profiles::plan_job;
use crate::random_plies::check_replay;

/// The folder, where it is at hand.
pub fn folder() -> Option<PathBuf> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/data/tape");
    if folder.is_dir() {
        return Some(folder);
    }
    // Past the harness, which keeps to itself what a test that passes prints.
    let said = format!("NOT RUN against notes: there is no {}\n", folder.display());
    io::stderr().write_all(said.as_bytes()).unwrap();
    None
}

/// A job with what was planned of it.
struct Case {
    job: Value,
    outcome: Outcome,
}

/// A cut of a report.
struct Cut {
    cutter: u64,
    slope: i64,
    turns: u64,
    uv: Vec<[f64; 2]>,
}

type Check = fn(&Case);

/// Every job, what is found with it, and what its note says.
fn expected() -> BTreeMap<&'static str, (&'static [&'static str], Check)> {
    let closed: &[&str] = &["closed_outline"];
    let holed: &[&str] = &["closed_outline", "closed_outline"];
    let excess: &[&str] = &["closed_outline", "too_many_knives"];
    BTreeMap::from([
        ("a_flat_rect_0", (closed, rectangle as Check)),
        ("b_flat_trapezoid_45", (closed, trapezoid)),
        ("c_gt_lt_75", (closed, greater_and_less)),
        ("d1_two_changes_cuttable", (closed, two_changes_cuttable)),
        ("d2_two_changes_excess", (excess, two_changes_excess)),
        ("d3_three_changes_excess", (excess, three_changes_excess)),
        (
            "e_flat_cutouts",
            (&["closed_outline", "closed_outline", "closed_outline", "outline_sense"], cut_outs),
        ),
        ("f_wing_skin_45", (holed, wing_skin)),
        ("g_cylinder_R1000_45", (closed, cylinder)),
        ("g2_cylinder_R1000_45_short_tracks", (closed, short_tracks)),
        ("h_cone_20deg", (holed, cone)),
    ])
}

fn read(name: &str) -> Option<Value> {
    let text = fs::read(folder()?.join(format!("{name}.job.json"))).unwrap();
    Some(serde_json::from_slice(&text).unwrap())
}

fn planned(job: &Value, options: &Value) -> Outcome {
    // None of these jobs names a file; one that did would be refused here.
    plan_job(job, &job["input"]["machine"], options).unwrap()
}

#[test]
fn every_shared_job_gives_what_its_note_says() {
    let Some(folder) = folder() else { return };
    let entries =
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut found: Vec<String> =
        entries.filter_map(|file| file.strip_suffix(".job.json").map(str::to_owned)).collect();
    found.sort();
    let expected = expected();
    let mut known: Vec<&str> = expected.keys().copied().collect();
    known.sort_unstable();
    assert_eq!(found, known, "jobs with and without an expectation");
    for (name, (codes, check)) in expected {
        println!("{name}");
        let job = read(name).unwrap();
        let outcome = planned(&job, &json!(null));
        let found: Vec<String> = outcome.findings.iter().map(|finding| finding.code.as_str()).collect();
        assert_eq!(found, codes, "{:?}", outcome.findings);
        let refused = outcome.findings.iter().any(Finding::is_error);
        assert_eq!(outcome.verdict, if refused { Verdict::NotUsable } else { Verdict::Usable });
        if !refused {
            check_replay(&outcome).unwrap();
            assert_eq!(outcome.report["replay"]["tape_reversals"], 0);
        }
        check(&Case { job, outcome });
    }
}

impl Case {
    /// The cuts of the pieces of each course.
    fn courses(&self) -> Vec<Vec<Vec<Cut>>> {
        let list = |value: &Value| value.as_array().unwrap().clone();
        let cut = |cut: Value| Cut {
            cutter: cut["cutter"].as_u64().unwrap(),
            slope: cut["slope"].as_i64().unwrap(),
            turns: cut["turns"].as_u64().unwrap(),
            uv: serde_json::from_value(cut["points_uv"].clone()).unwrap(),
        };
        let piece = |piece: Value| list(&piece["cuts"]).into_iter().map(cut).collect();
        let course = |course: Value| list(&course["pieces"]).into_iter().map(piece).collect();
        list(&self.outcome.report["courses"]).into_iter().map(course).collect()
    }

    fn areas(&self) -> Vec<f64> {
        let manifest = self.outcome.report["manifest"].as_array().unwrap();
        manifest.iter().map(|piece| piece["area_mm2"].as_f64().unwrap()).collect()
    }

    fn points(&self, pointer: &str) -> Vec<[f64; 3]> {
        serde_json::from_value(self.job.pointer(pointer).unwrap().clone()).unwrap()
    }

    fn tape(&self) -> f64 {
        self.job["input"]["tape"]["width_mm"].as_f64().unwrap()
    }

    fn lies_on_courses(&self, ply_mm2: f64) {
        // Developed to a hundredth of a millimetre: along the outline, and along both edges of each course.
        let outline = self.points("/input/boundary/points");
        let length: f64 = outline.windows(2).map(|ends| distance(ends[0], ends[1])).sum();
        let off = self.areas().iter().sum::<f64>() - ply_mm2;
        let most = 0.01 * (length + 2.0 * self.areas().iter().sum::<f64>() / self.tape());
        assert!(off.abs() <= most, "{off} mm2 of {ply_mm2}, at most {most}");
    }
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|axis| (a[axis] - b[axis]).powi(2)).sum::<f64>().sqrt()
}

fn near(one: [f64; 2], other: [f64; 2]) -> bool {
    // The jobs print six decimals.
    (one[0] - other[0]).abs() < 2e-6 && (one[1] - other[1]).abs() < 2e-6
}

fn ends(cut: &Cut) -> [[f64; 2]; 2] {
    [cut.uv[0], cut.uv[cut.uv.len() - 1]]
}

fn plane_mm2(points: &[[f64; 3]]) -> f64 {
    let pairs = points.iter().zip(points.iter().cycle().skip(1));
    pairs.map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum::<f64>().abs() / 2.0
}

/// The area that a closed line shuts in on a cone of any section: triangles with its apex, of which the one is taken from
/// the other where the line runs back. `out` is a direction away from the surface everywhere.
fn cone_mm2(points: &[[f64; 3]], apex: [f64; 3], out: impl Fn([f64; 3]) -> [f64; 3]) -> f64 {
    let arm = |at: &[f64; 3]| [at[0] - apex[0], at[1] - apex[1], at[2] - apex[2]];
    let pairs = points.iter().zip(points.iter().cycle().skip(1));
    let triangle = |(a, b): (&[f64; 3], &[f64; 3])| {
        let ([ax, ay, az], [bx, by, bz], out) = (arm(a), arm(b), out(*a));
        let cross = [ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx];
        let side: f64 = (0..3).map(|axis| cross[axis] * out[axis]).sum();
        (distance(cross, [0.0; 3]) / 2.0).copysign(side)
    };
    pairs.map(triangle).sum::<f64>().abs()
}

/// Every end square; six full courses and a seventh of which 70 mm lie in the ply, with one lengthwise cut.
fn rectangle(case: &Case) {
    let courses = case.courses();
    assert_eq!(courses.len(), 7);
    for (index, course) in courses.iter().enumerate() {
        let [piece] = &course[..] else { panic!("course {} has {} pieces", index + 1, course.len()) };
        assert!(piece.iter().all(|cut| cut.slope == 0 && cut.turns == 0 && cut.cutter == 1));
        let steps = || piece.iter().flat_map(|cut| cut.uv.windows(2));
        let lengthwise: Vec<_> = steps().filter(|step| step[0][0] != step[1][0]).collect();
        let square = steps().filter(|step| step[0][0] == step[1][0]).count();
        assert_eq!((square, lengthwise.len()), (2, usize::from(index == 6)), "course {}", index + 1);
        if let [along] = lengthwise[..] {
            let [a, b] = [along[0], along[1]];
            assert!(
                near([a[0].max(b[0]), a[0].min(b[0])], [1200.0, 0.0])
                    && near(a, [a[0], 32.5])
                    && near(b, [b[0], 32.5])
            );
        }
    }
    let areas = case.areas();
    let full = |area: &f64| (area - 1200.0 * 75.0).abs() < 0.01;
    assert!(areas[..6].iter().all(full) && (areas[6] - 1200.0 * 70.0).abs() < 0.01, "{areas:?}");
    case.lies_on_courses(1200.0 * 520.0);
}

/// Every end is one straight `\` or `/` from edge to edge.
fn trapezoid(case: &Case) {
    for course in case.courses() {
        let [piece] = &course[..] else { panic!("{} pieces", course.len()) };
        assert_eq!(piece.len(), 2, "a start and an end");
        for cut in piece {
            let [a, b] = ends(cut);
            assert!((a[1].abs() - 75.0).abs() < 2e-6 && (a[1] + b[1]).abs() < 2e-6, "{a:?} {b:?}");
            let (du, dv) = (b[0] - a[0], b[1] - a[1]);
            let off = |at: &[f64; 2]| ((at[0] - a[0]) * dv - (at[1] - a[1]) * du).abs() / du.hypot(dv);
            assert!(cut.uv.iter().all(|at| off(at) < 5e-6), "not straight");
            let slope = if du * dv < 0.0 { -1 } else { 1 };
            assert_eq!((cut.slope, cut.turns, cut.cutter), (slope, 0, if slope < 0 { 1 } else { 2 }));
        }
    }
    case.lies_on_courses(plane_mm2(&case.points("/input/boundary/points")));
}

/// `<` and `>` of 45 degrees, their vertices in the middle.
fn greater_and_less(case: &Case) {
    let courses = case.courses();
    assert_eq!(courses.len(), 2);
    // By u of the ply: vertices, then what their arms end at.
    for (course, [first, last], [start, end]) in
        [(0, [0.0, 400.0], [37.5, 362.5]), (1, [37.5 + 37.5, 325.0], [37.5, 362.5])]
    {
        let [piece] = &courses[course][..] else { panic!("{} pieces", courses[course].len()) };
        let track = &case.job["input"]["tracks"][course]["points"][0]["position"];
        let begin = track[0].as_f64().unwrap();
        let mut wanted = Vec::new();
        for (vertex, arm) in [(first, start), (last, end)] {
            for v in [-37.5, 37.5] {
                wanted.push([[vertex - begin, 0.0], [arm - begin, v]]);
            }
        }
        assert_eq!(piece.len(), wanted.len());
        for mut legs in wanted {
            // A knife begins at the larger u.
            legs.sort_by(|a, b| b[0].total_cmp(&a[0]));
            let cut = piece.iter().find(|cut| near(ends(cut)[0], legs[0]) && near(ends(cut)[1], legs[1]));
            let cut = cut.unwrap_or_else(|| panic!("course {}: no {legs:?}", course + 1));
            let slope = if legs[1][1] > legs[0][1] { -1 } else { 1 };
            assert_eq!((cut.slope, cut.turns, cut.cutter), (slope, 1, if slope < 0 { 1 } else { 2 }));
        }
    }
}

/// An end by its u at even v, and a square start at u 0.
fn has_end(case: &Case, heights: &[f64]) {
    let [course] = &case.courses()[..] else { panic!("one course") };
    let [piece] = &course[..] else { panic!("one piece") };
    let v = |index: usize| 75.0 * (index as f64 / (heights.len() - 1) as f64 - 0.5);
    let corners: Vec<[f64; 2]> = heights.iter().enumerate().map(|(index, u)| [*u, v(index)]).collect();
    for pair in corners.windows(2) {
        let at = |cut: &&Cut| {
            let [a, b] = ends(cut);
            (near(a, pair[0]) && near(b, pair[1])) || (near(a, pair[1]) && near(b, pair[0]))
        };
        let cut = piece.iter().find(at).unwrap_or_else(|| panic!("no cut {pair:?}"));
        // By slope: `\` to cutter 1, `/` to cutter 2.
        let slope = if pair[1][0] < pair[0][0] { -1 } else { 1 };
        assert_eq!((cut.slope, cut.turns, cut.cutter), (slope, 2, if slope < 0 { 1 } else { 2 }), "{pair:?}");
    }
    let start = piece.iter().find(|cut| cut.uv.iter().all(|at| at[0].abs() < 2e-6)).unwrap();
    assert_eq!((start.slope, piece.len()), (0, heights.len()));
}

/// Two knives do it, also by slope.
fn two_changes_cuttable(case: &Case) {
    has_end(case, &[360.0, 400.0, 300.0, 340.0]);
}

/// Which cuts are too many, where.
fn excess(case: &Case, counts: &[&str], range: [&str; 2]) {
    let said = case.outcome.findings.iter().find(|finding| finding.is_error()).unwrap();
    let message = said.message.as_str();
    let of_course = counts.iter().any(|count| message.starts_with(&format!("course 1: {count} cuts")));
    assert!(of_course && message.contains(&format!("between u {} and {} mm", range[0], range[1])), "{said}");
    assert_eq!((said.at.as_str(), case.outcome.programs.len()), ("/input/tracks/0", 0));
}

/// Three chains for 340 < u < 380.
fn two_changes_excess(case: &Case) {
    excess(case, &["3"], ["340.000", "380.000"]);
}

/// Three or four chains for 330 < u < 390.
fn three_changes_excess(case: &Case) {
    excess(case, &["3", "4"], ["330.000", "390.000"]);
}

/// A circle r 60 across two courses, a slot 240 x 50 in one course and reaching into the next; three courses.
fn cut_outs(case: &Case) {
    let courses = case.courses();
    assert!(courses.len() == 3 && courses.iter().all(|course| course.len() == 1));
    // As large as the note says; the lower edge rises by 60 mm, which it does not say.
    let outline = case.points("/input/boundary/points");
    let largest = |axis: usize| outline.iter().map(|point| point[axis]).fold(0.0, f64::max);
    assert_eq!([largest(0), largest(1)], [1000.0, 450.0]);
    let holes = [0, 1].map(|hole| case.points(&format!("/input/holes/{hole}/points")));
    // A circle and a slot with round ends, drawn with chords.
    let round = std::f64::consts::PI;
    let areas = [round * 3600.0, 190.0 * 50.0 + round * 625.0];
    for (hole, area) in holes.iter().zip(areas) {
        assert!((plane_mm2(hole) / area - 1.0).abs() < 1e-3, "{} {area}", plane_mm2(hole));
    }
    let bare: f64 = holes.iter().map(|hole| plane_mm2(hole)).sum();
    case.lies_on_courses(plane_mm2(&case.points("/input/boundary/points")) - bare);
    // Which courses have cuts of which hole: points of it, in the ply.
    let has = |course: usize, hole: &[[f64; 3]]| {
        let track = &case.job["input"]["tracks"][course]["points"][0]["position"];
        let y = track[1].as_f64().unwrap();
        let of_hole = |at: &[f64; 2]| hole.iter().any(|p| near(*at, [p[0], p[1] - y]));
        courses[course][0].iter().flat_map(|cut| &cut.uv).filter(|at| of_hole(at)).count() > 3
    };
    let seen = [0, 1].map(|hole: usize| [0, 1, 2].map(|course| has(course, &holes[hole])));
    assert_eq!(seen, [[true, true, false], [false, true, true]]);
    assert!(courses.iter().flatten().flatten().all(|cut| cut.cutter == 1 || cut.cutter == 2));
}

/// 27 courses on a general cone, which develops exactly, with the scrap that domain.md A6 gives for it.
fn wing_skin(case: &Case) {
    assert_eq!(case.courses().len(), 27);
    // The chord falls from 2500 to 1200 over a span of 4000, the leading edge is swept 25 degrees.
    let y = 4000.0 * 2500.0 / 1300.0;
    let apex = [y * 25.0_f64.to_radians().tan(), y, 0.0];
    let of = |pointer: &str| cone_mm2(&case.points(pointer), apex, |_| [0.0, 0.0, 1.0]);
    let hole = of("/input/holes/0/points");
    // An ellipse, drawn with chords.
    let ellipse = std::f64::consts::PI * 130.0 * 80.0;
    assert!((hole / ellipse - 1.0).abs() < 1e-3, "{hole} {ellipse}");
    case.lies_on_courses(of("/input/boundary/points") - hole);
    let free = planned(&case.job, &json!({"allocation": "free"}));
    check_replay(&free).unwrap();
    for (outcome, name, percent, off) in [
        (&case.outcome, "neighbour_scrap_area_mm2", 11.0, 0.05),
        (&case.outcome, "bound_scrap_area_mm2", 5.75, 0.005),
        (&free, "neighbour_scrap_area_mm2", 6.3, 0.05),
    ] {
        let figure = |name: &str| outcome.report["roll"][name].as_f64().unwrap();
        let share = 100.0 * figure(name) / figure("piece_area_mm2");
        assert!((share - percent).abs() < off, "{name}: {share} is not {percent}");
    }
}

/// A polygon rolled on.
fn cylinder(case: &Case) {
    let unrolled = |[x, y, z]: [f64; 3]| {
        assert!((x.hypot(z) - 1000.0).abs() < 1e-5);
        [1000.0 * x.atan2(z), y, 0.0]
    };
    let flat: Vec<_> = case.points("/input/boundary/points").into_iter().map(unrolled).collect();
    case.lies_on_courses(plane_mm2(&flat));
    assert!(case.courses().iter().all(|course| course.len() == 1));
}

/// As on the whole tracks, though points of the outline lie beyond the ends of these.
fn short_tracks(case: &Case) {
    cylinder(case);
    let job = read("g_cylinder_R1000_45").unwrap();
    let whole = Case { outcome: planned(&job, &json!(null)), job };
    assert_eq!(case.areas().len(), whole.areas().len());
    for (short, whole) in case.areas().iter().zip(whole.areas()) {
        // A hundredth of a millimetre along two ends of the tape.
        assert!((short - whole).abs() <= 0.01 * 2.0 * 150.0 * 2.0_f64.sqrt(), "{short} {whole}");
    }
}

/// A cone of 20 degrees around z, with a round cut-out.
fn cone(case: &Case) {
    let out = |[x, y, z]: [f64; 3]| {
        assert!((x.hypot(y) - z * 20.0_f64.to_radians().tan()).abs() < 1e-5, "apex and axis");
        [x, y, 0.0]
    };
    let of = |pointer: &str| cone_mm2(&case.points(pointer), [0.0; 3], out);
    case.lies_on_courses(of("/input/boundary/points") - of("/input/holes/0/points"));
    // A round cut-out is cut from both sides.
    let cuts: Vec<Cut> = case.courses().into_iter().flatten().flatten().collect();
    assert!([1, 2].iter().all(|cutter| cuts.iter().any(|cut| cut.cutter == *cutter)));
}
