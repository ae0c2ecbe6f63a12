//! The roll, judged from the report alone: no two pieces overlap, no knife is needed twice at one place, and nothing
//! could be moved closer. None of the planner's geometry is used: pieces are looked at along lines of constant v.

use bladeplan::planning::budget::Budget;
use bladeplan::planning::document;
use bladeplan::planning::document::files::Files;
use bladeplan::planning::outcome::{Outcome, Verdict};
use bladeplan::planning::tape::machine::Catalogue;
use proptest::prelude::*;
use rstest::rstest;
use serde_json::{Value, json};

use crate::linuxcnc::plan;
use crate::profiles::lab_with;
use crate::random_plies::plies;
use crate::rounds::rounds;

/// Printed positions are rounded up to this, in mm; cuts closer than this to one another are at one place.
const PLACE_MM: f64 = 2e-4;

/// By so much the chains of two outlines may have been moved to make small steps back monotone, in mm.
const OUTLINE_MM: f64 = 0.0102;

/// What a report says of a piece.
struct Laid {
    course: u64,
    /// Its cuts on the roll: cutter, whether a neighbour's knife makes it, and points (r, v).
    cuts: Vec<(u64, bool, Vec<[f64; 2]>)>,
    range: [f64; 2],
}

/// The pieces of a report in increasing r.
fn laid(report: &Value) -> Vec<Laid> {
    let mut pieces = Vec::new();
    for course in report["courses"].as_array().unwrap() {
        for piece in course["pieces"].as_array().unwrap() {
            let offset = piece["roll_offset_mm"].as_f64().unwrap();
            let point = |p: &Value| [p[0].as_f64().unwrap() + offset, p[1].as_f64().unwrap()];
            let cut = |cut: &Value| {
                let points: Vec<_> = cut["points_uv"].as_array().unwrap().iter().map(point).collect();
                (cut["cutter"].as_u64().unwrap(), cut["shared"].as_bool().unwrap(), points)
            };
            let cuts: Vec<_> = piece["cuts"].as_array().unwrap().iter().map(cut).collect();
            let all = || cuts.iter().flat_map(|(_, _, points)| points.iter().map(|p| p[0]));
            let range = [all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max)];
            pieces.push(Laid { course: course["number"].as_u64().unwrap(), cuts, range });
        }
    }
    pieces.sort_by(|a, b| a.range[0].total_cmp(&b.range[0]).then(a.range[1].total_cmp(&b.range[1])));
    pieces
}

impl Laid {
    /// Where the piece begins and ends along the line at v; beside a narrow piece nothing may lie either.
    fn ends(&self, v: f64) -> [f64; 2] {
        let segments = self.cuts.iter().flat_map(|(_, _, points)| points.windows(2));
        let crossed = segments.filter(|pair| (pair[0][1] > v) != (pair[1][1] > v));
        let r = crossed.map(|p| p[0][0] + (v - p[0][1]) / (p[1][1] - p[0][1]) * (p[1][0] - p[0][0]));
        let ends = r.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], r| [a.min(r), b.max(r)]);
        if ends[0].is_finite() { ends } else { self.range }
    }

    /// Lines just beside each corner.
    fn lines(&self, half: f64) -> impl Iterator<Item = f64> {
        let corners = self.cuts.iter().flat_map(|(_, _, points)| points.iter().map(|p| p[1]));
        corners.flat_map(|v| [v - 1e-8, v + 1e-8]).filter(move |v| v.abs() < half)
    }

    /// Cutter and stretch of r of what knives make for it, moved along r.
    fn stretches(&self, by: f64) -> impl Iterator<Item = (u64, [f64; 2])> {
        let made = self.cuts.iter().filter(|(_, shared, _)| !shared);
        made.map(move |(cutter, _, points)| {
            let r = || points.iter().map(|p| p[0] + by);
            (*cutter, [r().fold(f64::INFINITY, f64::min), r().fold(f64::NEG_INFINITY, f64::max)])
        })
    }
}

/// The smallest distance along r from one piece to the next.
fn apart(lower: &Laid, upper: &Laid, half: f64) -> f64 {
    let lines = lower.lines(half).chain(upper.lines(half));
    lines.map(|v| upper.ends(v)[0] - lower.ends(v)[1]).fold(f64::INFINITY, f64::min)
}

fn collide(one: (u64, [f64; 2]), other: (u64, [f64; 2])) -> bool {
    let ([a, b], [c, d]) = (one.1, other.1);
    one.0 == other.0 && a < d - PLACE_MM && c < b - PLACE_MM
}

/// What is wrong with a roll.
fn faults(report: &Value, half: f64, gap: f64) -> Vec<String> {
    let pieces = laid(report);
    let mut faults = Vec::new();
    for pair in pieces.windows(2) {
        let apart = apart(&pair[0], &pair[1], half);
        if apart < gap - OUTLINE_MM {
            faults.push(format!("courses {} and {} are {apart} mm apart", pair[0].course, pair[1].course));
        }
    }
    let all: Vec<_> = pieces.iter().flat_map(|piece| piece.stretches(0.0)).collect();
    for (index, one) in all.iter().enumerate() {
        faults.extend(
            all[..index]
                .iter()
                .filter(|other| collide(*one, **other))
                .map(|other| format!("cutter {} is needed for {:?} and {:?}", one.0, one.1, other.1)),
        );
    }
    faults
}

/// The pieces that could be moved by a hundredth of a millimetre toward what passes the knives before them.
fn loose(report: &Value, half: f64, gap: f64) -> Vec<u64> {
    const BY_MM: f64 = 0.01;
    let pieces = laid(report);
    let free = |index: &usize| {
        let (piece, earlier) = (&pieces[*index], &pieces[index + 1..]);
        let touches = apart(piece, &earlier[0], half) - BY_MM < gap - PLACE_MM;
        let collides = piece.stretches(BY_MM).any(|moved| {
            earlier.iter().flat_map(|other| other.stretches(0.0)).any(|other| collide(moved, other))
        });
        !touches && !collides
    };
    (0..pieces.len().saturating_sub(1)).filter(free).map(|index| pieces[index].course).collect()
}

fn planned(job: Value) -> Outcome {
    let document = document::from_value(job).unwrap();
    plan(&document, &Files::default(), &Catalogue::built_in(), &Budget::unwatched()).unwrap()
}

fn figure(report: &Value, name: &str) -> f64 {
    report["roll"][name].as_f64().unwrap()
}

#[test]
fn random_rolls_hold_together_by_slope_free_and_with_shared_cuts() {
    let mut runner = crate::rounds::runner(40);
    let shortest = std::cell::Cell::new(0);
    let rolls = (plies(), prop_oneof![Just(0.0), 0.5..20.0_f64]);
    let result = runner.run(&rolls, |(ply, gap)| {
        let half = ply.width() / 2.0;
        let of = |options: Value| {
            let mut job = ply.job();
            job["input"]["options"] = options;
            planned(job)
        };
        let by_slope = of(json!({"scrap_gap_mm": gap}));
        if by_slope.verdict != Verdict::Usable {
            return Ok(());
        }
        let free = of(json!({"scrap_gap_mm": gap, "allocation": "free"}));
        let shared = of(json!({"scrap_gap_mm": gap, "share_cuts": true, "roll_order": "laying"}));
        for outcome in [&by_slope, &free, &shared] {
            prop_assert!(outcome.verdict == Verdict::Usable, "{:?}", outcome.findings);
            prop_assert_eq!(faults(&outcome.report, half, gap), Vec::<String>::new());
            let tape = figure(&outcome.report, "tape_used_mm");
            prop_assert!(tape >= figure(&outcome.report, "bound_tape_mm") - PLACE_MM);
            prop_assert!(tape >= figure(&outcome.report, "least_tape_mm") - PLACE_MM);
        }
        prop_assert_eq!(loose(&by_slope.report, half, gap), Vec::<u64>::new());
        let tape = figure(&free.report, "tape_used_mm");
        // Every step up to a printed digit may add as much.
        let steps = PLACE_MM * free.report["manifest"].as_array().unwrap().len() as f64;
        prop_assert!(tape <= figure(&by_slope.report, "tape_used_mm") + steps);
        let proved = tape <= figure(&free.report, "least_tape_mm") + steps;
        shortest.set(shortest.get() + u32::from(proved));
        Ok(())
    });
    result.unwrap();
    let shortest = shortest.get();
    assert!(shortest >= rounds(5), "only {shortest} rolls are proved the shortest");
}

fn wing_skin(options: Value) -> Outcome {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/fixtures/roll/wing-skin-45.job.json");
    let mut job: Value = serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap();
    job["input"]["options"] = options;
    planned(job)
}

/// The published figures of 27 courses on a wing skin (domain.md A6), in percent of piece area.
#[rstest]
#[case("by_slope", 11.0)]
#[case("free", 6.3)]
fn the_wing_skin_has_the_scrap_that_is_known(#[case] allocation: &str, #[case] percent: f64) {
    let outcome = wing_skin(json!({"allocation": allocation}));
    assert_eq!(outcome.verdict, Verdict::Usable, "{:?}", outcome.findings);
    let share =
        |name: &str| 100.0 * figure(&outcome.report, name) / figure(&outcome.report, "piece_area_mm2");
    assert!((share("neighbour_scrap_area_mm2") - percent).abs() < 0.02, "{}", outcome.report["roll"]);
    assert!((share("bound_scrap_area_mm2") - 5.75).abs() < 0.005, "{}", outcome.report["roll"]);
    assert_eq!(faults(&outcome.report, 75.0, 0.0), Vec::<String>::new());
    if allocation == "free" {
        assert!(share("neighbour_scrap_area_mm2") <= 6.3);
        let proved = figure(&outcome.report, "tape_used_mm") - figure(&outcome.report, "least_tape_mm");
        assert!(proved.abs() < 0.01, "{proved} mm are not proved");
    }
}

/// Courses over a parallelogram: every end is the same `/`.
fn parallel(courses: u32, tape: Value, options: Value) -> Outcome {
    parallel_on(json!("two-cutter-lab"), courses, tape, options)
}

fn parallel_on(machine: Value, courses: u32, tape: Value, options: Value) -> Outcome {
    let height = 75.0 * f64::from(courses);
    let tracks: Vec<_> = (0..courses)
        .map(|i| {
            let v = 37.5 + 75.0 * f64::from(i);
            let point = |u: f64| json!({"position": [u, v, 0], "normal": [0, 0, -1]});
            json!({"number": i + 1, "points": [point(0.0), point(1000.0)]})
        })
        .collect();
    let mut width = json!({"width_mm": 75, "thickness_mm": 0.125});
    width.as_object_mut().unwrap().extend(tape.as_object().unwrap().clone());
    planned(json!({"kind": "tape-cut", "input": {"tape": width, "tracks": tracks, "machine": machine,
        "boundary": {"points": [[0, 0, 0], [300, 0, 0], [300.0 + height / 3.0, height, 0], [height / 3.0, height, 0]]},
        "options": options}}))
}

/// The lab with blades that overcut and whose edges lie off their axes, in mm.
fn with_blades(overcut: f64, offset: f64) -> Value {
    let blades = [0, 1].map(|cutter| format!("/cutters/{cutter}/blade"));
    let values: Vec<(String, Value)> = blades
        .iter()
        .flat_map(|blade| {
            let edges = if offset == 0.0 { "double" } else { "single" };
            [("overcut_mm", json!(overcut)), ("offset_mm", json!(offset)), ("edges", json!(edges))]
                .map(|(name, value)| (format!("{blade}/{name}"), value))
        })
        .collect();
    let values: Vec<(&str, Value)> = values.iter().map(|(at, value)| (at.as_str(), value.clone())).collect();
    lab_with(&values)
}

#[test]
fn congruent_ends_are_one_cut_where_that_is_asked_for() {
    let (apart, free) =
        (parallel(4, json!({}), json!({})), parallel(4, json!({}), json!({"allocation": "free"})));
    let shared = parallel(4, json!({}), json!({"share_cuts": true}));
    assert_eq!([&apart, &free, &shared].map(|o| o.verdict), [Verdict::Usable; 3], "{:?}", shared.findings);
    // Four pieces of 300 mm and an end of 25 mm, which by slope lies between all of them.
    let used = |outcome: &Outcome| figure(&outcome.report, "tape_used_mm");
    assert!((used(&apart) - 1300.0).abs() < 0.01 && (used(&free) - 1225.0).abs() < 0.01);
    assert!((used(&shared) - 1225.0).abs() < 0.01);
    let downs = |outcome: &Outcome| {
        ["M64 P0", "M64 P1"].map(|word| outcome.programs[0].text.matches(word).count()).iter().sum::<usize>()
    };
    assert_eq!((downs(&apart), downs(&shared)), (8, 5));
    let said: Vec<_> = shared.findings.iter().filter(|f| f.code.as_str() == "shared_cut").collect();
    assert_eq!(said.len(), 3);
    assert!(
        said[0].message.contains("course 1") && said[0].message.contains("course 2"),
        "{}",
        said[0].message
    );
    let times = [&apart, &shared].map(|outcome| outcome.report["time_s"].as_f64().unwrap());
    assert!(times[1] < 0.7 * times[0], "{times:?}");
}

#[test]
fn with_a_gap_nothing_is_shared() {
    let outcome = parallel(2, json!({}), json!({"share_cuts": true, "scrap_gap_mm": 1}));
    assert!(outcome.findings.iter().all(|finding| finding.code.as_str() != "shared_cut"));
    assert_eq!(faults(&outcome.report, 37.5, 1.0), Vec::<String>::new());
}

#[rstest]
#[case(0.0, 0.0)]
#[case(5.0, 0.0)]
#[case(5.0, -2.0)]
fn defects_and_splices_are_kept_free(#[case] overcut: f64, #[case] offset: f64) {
    let zones = json!({"zones_mm": [[500, 520], [0, 10], [515, 530.5]]});
    let outcome = parallel_on(with_blades(overcut, offset), 4, zones, json!({"allocation": "free"}));
    assert_eq!(outcome.verdict, Verdict::Usable, "{:?}", outcome.findings);
    let lead = figure(&outcome.report, "lead_mm");
    let mut last = 0.0_f64;
    for piece in laid(&outcome.report) {
        let (from, to) = (lead - piece.range[1], lead - piece.range[0]);
        last = last.max(to);
        for zone in [(0.0, 10.0), (500.0, 530.5)] {
            assert!(to <= zone.0 + PLACE_MM || zone.1 - PLACE_MM <= from, "{from} to {to} lies in {zone:?}");
        }
    }
    // One piece of 325 mm from 10 on, the next one behind the splice, and each of the others 300 mm on.
    assert!((last - (530.5 + 325.0 + 600.0)).abs() < 0.01, "{last}");
    assert!((figure(&outcome.report, "tape_used_mm") - last).abs() < 0.01);
    let sheet = outcome.drawings.iter().find(|drawing| drawing.name == "roll.svg").unwrap();
    assert!(sheet.svg.contains("defect or splice"));
}

/// The first cut begins where U reads 0; its piece lies on the tape behind what it overcuts.
#[test]
fn a_zone_is_where_it_is_also_under_an_overcut() {
    let zone = json!({"zones_mm": [[325, 345]]});
    let outcome = parallel_on(with_blades(5.0, 0.0), 4, zone, json!({"allocation": "free"}));
    let lead = figure(&outcome.report, "lead_mm");
    let first = laid(&outcome.report).pop().unwrap();
    // From 5 to 330 mm it would lie in the defect.
    assert!((lead - first.range[1] - 345.0).abs() < 0.01, "{}", lead - first.range[1]);
}

#[test]
fn the_overcut_takes_tape_too() {
    let needed = |overcut: f64, length_mm: f64| {
        parallel_on(with_blades(overcut, 0.0), 4, json!({"length_mm": length_mm}), json!({}))
    };
    let used = figure(&needed(0.0, 9000.0).report, "tape_used_mm");
    let with = figure(&needed(5.0, 9000.0).report, "tape_used_mm");
    assert!((with - used - 5.0).abs() < 1e-6, "{with} {used}");
    // The second cutter's station stands 300 mm behind, and it overcuts beyond the last piece.
    let least = with + 300.0 + 5.0;
    assert_eq!(needed(5.0, least + 0.01).verdict, Verdict::Usable);
    assert_eq!(needed(5.0, least - 0.01).verdict, Verdict::NotUsable);
}

#[rstest]
#[case(json!({"zones_mm": [[10, 5]]}), "/input/tape/zones_mm/0")]
#[case(json!({"zones_mm": [[0, 5], [-1, 5]]}), "/input/tape/zones_mm/1")]
#[case(json!({"zones_mm": [[7, 7]]}), "/input/tape/zones_mm/0")]
fn zones_that_are_none_are_refused(#[case] tape: Value, #[case] at: &str) {
    let mut job = json!({"kind": "tape-cut", "input": {
        "tape": {"width_mm": 75, "thickness_mm": 0.125, "zones_mm": tape["zones_mm"]},
        "boundary": {"points": [[0, 0, 0], [300, 0, 0], [300, 75, 0], [0, 75, 0]]}, "machine": "two-cutter-lab"}});
    let point = |u: i32| json!({"position": [u, 37.5, 0], "normal": [0, 0, 1]});
    job["input"]["tracks"] = json!([{"number": 1, "points": [point(0), point(300)]}]);
    let document = document::from_value(job).unwrap();
    let refused =
        plan(&document, &Files::default(), &Catalogue::built_in(), &Budget::unwatched()).unwrap_err();
    assert_eq!(
        refused.iter().map(|f| (f.code.as_str(), f.at.as_str())).collect::<Vec<_>>(),
        [("out_of_range".to_owned(), at)]
    );
}

#[test]
fn a_spool_that_is_too_short_says_by_how_much_and_for_which_course() {
    let enough = parallel(4, json!({"length_mm": 1600}), json!({}));
    assert_eq!(enough.verdict, Verdict::Usable, "{:?}", enough.findings);
    let short = parallel(4, json!({"length_mm": 1000}), json!({}));
    assert_eq!(short.verdict, Verdict::NotUsable);
    assert!(short.programs.is_empty());
    let finding = short.findings.iter().find(|finding| finding.is_error()).unwrap();
    assert_eq!(
        (finding.code.as_str().as_str(), finding.at.as_str()),
        ("tape_too_short", "/input/tape/length_mm")
    );
    // Course 4 is cut first; 4 and 3 take 650 mm, 2 another 325, all of it 1300, and the second cutter is 300 mm on: the
    // tape must still be held for its last cut.
    assert!(finding.message.contains("600.000 mm more are needed"), "{}", finding.message);
    assert!(finding.message.ends_with("does not fit is 2"), "{}", finding.message);
}
