//! `cut_side: paper`: the knives work on the backing paper, and everything is the mirror image, v -> -v, of what it is with
//! knives on the film (domain.md A3).

use bladeplan::planning::outcome::{Outcome, Verdict};
use bladeplan::planning::program::events::Event;
use bladeplan::planning::program::nc::read::read;
use bladeplan::planning::tape::trace::{PlantedTrace, TraceStroke, text};
use serde_json::{Value, json};

use crate::profiles::{lab_with, plan_job};

/// x and y of a ply that is no mirror image of itself: slanted ends, a notch in one side, a cut-out off the middle.
const OUTLINE: [[f64; 2]; 9] = [
    [0.0, -37.5],
    [20.0, 112.5],
    [300.0, 112.5],
    [350.0, 40.0],
    [400.0, -37.5],
    [180.0, -37.5],
    [180.0, -20.0],
    [120.0, -20.0],
    [120.0, -37.5],
];
const CUT_OUT: [[f64; 2]; 4] = [[240.0, -20.0], [258.0, -25.0], [265.0, -12.0], [250.0, -8.0]];
/// y of its courses.
const COURSES: [f64; 2] = [0.0, 75.0];

/// The ply, or its mirror image in the plane of x and z, whose outline turns the other way.
fn ply(mirrored: bool) -> Value {
    let sign = if mirrored { -1.0 } else { 1.0 };
    let points = |list: &[[f64; 2]]| list.iter().map(|[x, y]| json!([x, sign * y, 0.0])).collect::<Vec<_>>();
    let track = |(index, y): (usize, f64)| {
        let at = |x: f64| json!({"position": [x, sign * y, 0.0], "normal": [0, 0, 1]});
        json!({"number": index + 1, "points": [at(0.0), at(400.0)]})
    };
    json!({"kind": "tape-cut", "input": {
        "tape": {"width_mm": 75, "thickness_mm": 0.125},
        "boundary": {"points": points(&OUTLINE)}, "holes": [{"points": points(&CUT_OUT)}],
        "tracks": COURSES.into_iter().enumerate().map(track).collect::<Vec<_>>()}})
}

fn planned(ply: &Value, side: &str, options: &Value) -> Outcome {
    let machine = lab_with(&[("/cut_side", json!(side))]);
    let outcome = plan_job(ply, &machine, options).unwrap();
    assert_eq!(outcome.verdict, Verdict::Usable, "{:?}", outcome.findings);
    outcome
}

fn trace(outcome: &Outcome) -> PlantedTrace {
    text::read(&outcome.attachments[0].text).unwrap()
}

/// In ten thousandths.
fn steps(values: [f64; 2]) -> [i64; 2] {
    values.map(|value| (value * 1e4).round() as i64)
}

/// The (u, v) of all cuts of a course, sorted.
fn corners(outcome: &Outcome, course: usize) -> Vec<[i64; 2]> {
    let pieces = outcome.report["courses"][course]["pieces"].as_array().unwrap();
    let cuts = pieces.iter().flat_map(|piece| piece["cuts"].as_array().unwrap());
    let points = cuts.flat_map(|cut| cut["points_uv"].as_array().unwrap());
    let mut corners: Vec<_> =
        points.map(|at| steps([at[0].as_f64().unwrap(), at[1].as_f64().unwrap()])).collect();
    corners.sort_unstable();
    corners.dedup();
    corners
}

/// What the cuts of the first course run through, worked out by hand, with V up the ply's y or down it.
#[test]
fn on_paper_every_place_of_a_piece_has_the_other_v() {
    // The end crosses the tape's edge, and the start too, between two corners.
    let (end, start) = (350.0 + 50.0 * 2.5 / 77.5, 10.0);
    let mut places = vec![[end, 37.5], [start, 37.5]];
    places.extend(OUTLINE.iter().filter(|[_, y]| *y < 37.5));
    places.extend(CUT_OUT);
    for (side, sign) in [("film", 1.0), ("paper", -1.0)] {
        let outcome = planned(&ply(false), side, &json!(null));
        let mut wanted: Vec<_> = places.iter().map(|[x, y]| steps([*x, sign * y])).collect();
        wanted.sort_unstable();
        assert_eq!(corners(&outcome, 0), wanted, "{side}");
    }
}

/// By the published rule `\` goes to cutter 1 and `/` to cutter 2; seen from the other side, one is the other.
#[test]
fn on_paper_slopes_and_with_them_knives_change_places() {
    let [film, paper] = ["film", "paper"].map(|side| planned(&ply(false), side, &json!(null)));
    for (outcome, start, end) in [(&film, (1, 2), (-1, 1)), (&paper, (-1, 1), (1, 2))] {
        for course in [0, 1] {
            let cuts = outcome.report["courses"][course]["pieces"][0]["cuts"].as_array().unwrap();
            // What has no turn runs from edge to edge, but for the notch, which is square.
            let across = cuts.iter().filter(|cut| cut["turns"] == 0 && cut["slope"] != 0);
            let mut found: Vec<_> = across
                .map(|cut| {
                    let u = cut["points_uv"][0][0].as_f64().unwrap();
                    (u > 200.0, (cut["slope"].as_i64().unwrap(), cut["cutter"].as_u64().unwrap()))
                })
                .collect();
            found.sort_unstable();
            assert_eq!(found, [(false, start), (true, end)], "course {}", course + 1);
        }
    }
}

/// A stroke by its places and blade angles, whatever knife makes it, from its smaller V on where it stands still.
fn way(stroke: &TraceStroke, sign: f64) -> Vec<[i64; 3]> {
    let mut from = stroke.down;
    let mut ways = Vec::new();
    for cut in &stroke.cuts {
        // The blade has two edges: half a turn is none. On the mirror's other side it is turned the other way.
        let blade = (sign * cut.blade_deg).rem_euclid(180.0);
        for at in [from, cut.to] {
            let [u, v] = steps([at[0], sign * at[1]]);
            ways.push([u, v, steps([blade, 0.0])[0]]);
        }
        from = cut.to;
    }
    if ways.iter().all(|way| way[0] == ways[0][0]) {
        ways.sort_unstable();
    }
    ways
}

#[test]
fn on_paper_the_planted_trace_is_the_mirror_image_of_that_on_film() {
    let [film, paper] = ["film", "paper"].map(|side| trace(&planned(&ply(false), side, &json!(null))));
    for (film, paper) in film.courses.iter().zip(&paper.courses) {
        assert_eq!(film.points, paper.points, "the mould is where it was");
        let ways = |strokes: &[TraceStroke], sign: f64| {
            let mut ways: Vec<_> = strokes.iter().map(|stroke| way(stroke, sign)).collect();
            ways.sort_unstable();
            ways
        };
        assert_eq!(ways(&film.strokes, 1.0), ways(&paper.strokes, -1.0));
        assert_ne!(ways(&film.strokes, 1.0), ways(&paper.strokes, 1.0), "else this test shows nothing");
    }
}

/// By the text alone: where each carriage is and how its blade lies while its knife is down, on the roll.
fn cutting(outcome: &Outcome, sign: f64) -> Vec<[i64; 3]> {
    let lead = outcome.report["roll"]["lead_mm"].as_f64().unwrap();
    let (mut down, mut made) = ([false; 2], Vec::new());
    for executed in read("roll.ngc", &outcome.programs[0].text).unwrap() {
        match executed.event {
            Event::Output { number: number @ 0..2, on } => down[number as usize] = on,
            Event::Move { from, to, .. } => {
                for (cutter, station) in [(0, 0.0), (1, 300.0)].into_iter().filter(|(k, _)| down[*k]) {
                    let (carriage, blade) = (7 + cutter, 3 + cutter);
                    let run = [from[6] - to[6], to[carriage] - from[carriage]];
                    if run[0].hypot(run[1]) < 0.01 {
                        continue;
                    }
                    let along = run[0].atan2(run[1]).to_degrees();
                    let off = (to[blade] - along).rem_euclid(180.0);
                    assert!(off.min(180.0 - off) < 0.1, "the blade lies {off} degrees off its cut");
                    let angle = (sign * to[blade]).rem_euclid(180.0);
                    made.push(
                        [lead - to[6] + station, sign * to[carriage], angle]
                            .map(|x| (x * 10.0).round() as i64),
                    );
                }
            }
            _ => {}
        }
    }
    made.sort_unstable();
    made
}

/// The mirror image of the ply, planned on the machine that cuts on the film, is planned by nothing that knows of paper.
#[test]
fn on_paper_a_ply_is_cut_as_its_mirror_image_is_on_film() {
    for options in
        [json!({}), json!({"allocation": "free"}), json!({"roll_order": "laying", "scrap_gap_mm": 7})]
    {
        let paper = planned(&ply(false), "paper", &options);
        let film = planned(&ply(true), "film", &options);
        for name in ["courses", "roll", "manifest", "replay", "time_s", "bound_time_s", "tips"] {
            assert_eq!(paper.report[name], film.report[name], "{name}");
        }
        let [of_paper, of_film] = [&paper, &film].map(|outcome| cutting(outcome, 1.0));
        assert_eq!(of_paper, of_film);
        assert!(of_paper != cutting(&paper, -1.0), "else this test shows nothing");
        assert_eq!(lines(&paper), lines(&film));
        let strokes = |outcome: &Outcome| {
            trace(outcome).courses.into_iter().map(|course| course.strokes).collect::<Vec<_>>()
        };
        assert_eq!(strokes(&paper), strokes(&film));
        let (drawn, wanted) = (drawings(&paper), drawings(&film));
        assert_eq!(drawn.len(), wanted.len());
        for ((name, paper), (of, film)) in drawn.into_iter().zip(wanted) {
            let film = turned(&film);
            let (paper, film) = (sorted(&paper), sorted(&film));
            let line = paper.iter().zip(&film).find(|(one, other)| one != other);
            assert!((&name, &paper) == (&of, &film), "{name}: {line:?}");
        }
    }
}

/// The program without the line that names its input.
fn lines(outcome: &Outcome) -> Vec<String> {
    let text = &outcome.programs[0].text;
    text.lines().filter(|line| !line.starts_with("(INPUT ")).map(str::to_owned).collect()
}

/// The drawings without the hash of the input that each names.
fn drawings(outcome: &Outcome) -> Vec<(String, String)> {
    let hash = outcome.report["input_sha256"].as_str().unwrap();
    let plain = |svg: &str| svg.replace(hash, "").replace(&hash[..12], "");
    outcome.drawings.iter().map(|drawing| (drawing.name.clone(), plain(&drawing.svg))).collect()
}

/// A drawing of the mirror image as it is of the ply itself: the knives work on paper, and the boundary, which is walked
/// clockwise from Edge0 to Edge1 seen from the mould's side, is seen from the other side.
fn turned(svg: &str) -> String {
    let swap = |text: &str, one: &str, other: &str| {
        text.replace(one, "\u{1}").replace(other, one).replace('\u{1}', other)
    };
    let svg = swap(svg, "look at the backing paper", "look at the film");
    let svg = swap(&svg, "(film)", "(backing paper)");
    // Not where the legend names them both.
    let svg = swap(&svg, ">Edge0 ", ">Edge1 ");
    swap(&svg, ">Edge0' ", ">Edge1' ")
}

/// Its elements: the two names of an edge are written in their own order.
fn sorted(svg: &str) -> Vec<&str> {
    let mut lines: Vec<&str> = svg.lines().collect();
    lines.sort_unstable();
    lines
}
