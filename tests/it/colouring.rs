//! What is cuttable, by brute force: chains cut out of random outlines by a second, plain implementation, and every
//! way of giving them to knives tried. The planner must agree on each piece by itself and on the roll.
//!
//! All places are whole mm, so that no tolerance of the planner has a say.

use bladeplan::planning::budget::Budget;
use bladeplan::planning::document;
use bladeplan::planning::document::files::Files;
use bladeplan::planning::finding::Code;
use bladeplan::planning::outcome::{Outcome, Verdict};
use bladeplan::planning::tape::machine::Catalogue;
use proptest::prelude::*;
use proptest::test_runner::{Config, TestCaseError, TestRunner};
use serde_json::{Value, json};

use crate::linuxcnc::plan;
use crate::rounds::rounds;

/// Half of the tape's width.
const HALF: i32 = 10;

/// The place (u, v) of a course, in whole mm.
type Place = (i32, i32);

/// A course's part of a ply: its two ends from v = -10 to v = 10, and a cut-out.
#[derive(Debug, Clone)]
struct Part {
    start: Vec<Place>,
    finish: Vec<Place>,
    hole: Option<Vec<Place>>,
}

fn parts(count: std::ops::Range<usize>) -> impl Strategy<Value = Vec<Part>> {
    let between = |from: i32, to: i32| {
        // In order of v for the most part: what doubles back crosses itself more often than not, and is then left out.
        let inner = prop_oneof![
            3 => prop::collection::btree_map(1 - HALF..HALF, from..to, 0..5)
                .prop_map(|places| places.into_iter().map(|(v, u)| (u, v)).collect()),
            1 => prop::collection::vec((from..to, 1 - HALF..HALF), 0..5),
            2 => Just(Vec::new()),
        ];
        (from..to, inner, from..to).prop_map(|(first, inner, last): (i32, Vec<Place>, i32)| {
            std::iter::once((first, -HALF)).chain(inner).chain([(last, HALF)]).collect::<Vec<_>>()
        })
    };
    let hole = prop::option::weighted(0.25, prop::collection::vec((10..30, 2 - HALF..HALF - 1), 3..5));
    let part = (between(0, 20), between(16, 40), hole).prop_map(|(start, finish, hole)| Part {
        start,
        finish,
        hole,
    });
    prop::collection::vec(part, count)
}

/// The ply of some parts side by side. Where two meet, the outline runs along the tapes' edge, which is no cut.
fn job(parts: &[Part], knives: usize, allocation: &str) -> Value {
    let at = |course: usize, (u, v): Place| json!([u, v + 2 * HALF * course as i32, 0]);
    let side = |of: fn(&Part) -> &Vec<Place>| {
        let points = parts.iter().enumerate();
        points
            .flat_map(move |(course, part)| of(part).iter().map(move |place| at(course, *place)))
            .collect::<Vec<_>>()
    };
    let (mut boundary, finish) = (side(|part| &part.start), side(|part| &part.finish));
    boundary.extend(finish.into_iter().rev());
    let holes = parts.iter().enumerate().filter_map(|(course, part)| {
        let points = part.hole.as_ref()?.iter().map(|place| at(course, *place)).collect::<Vec<_>>();
        Some(json!({"points": points}))
    });
    let track = |course: usize| {
        let point = |x: i32| json!({"position": [x, 2 * HALF * course as i32, 0], "normal": [0, 0, 1]});
        json!({"number": course + 1, "points": [point(0), point(45)]})
    };
    let mut machine = serde_json::to_value(Catalogue::built_in().get("two-cutter-lab").unwrap()).unwrap();
    machine["cutters"].as_array_mut().unwrap().truncate(knives);
    json!({"kind": "tape-cut", "input": {
        "tape": {"width_mm": 2 * HALF, "thickness_mm": 0.125},
        "boundary": {"points": boundary}, "holes": holes.collect::<Vec<_>>(),
        "tracks": (0..parts.len()).map(track).collect::<Vec<_>>(), "machine": machine,
        "options": {"allocation": allocation}}})
}

/// The stretches of u over which a cut runs one way, smallest first: it is followed point by point, and wherever it turns
/// round in u one stretch ends and the next begins. A cut that is all at one u is that place.
fn stretches(places: &[Place], closed: bool) -> Vec<(i32, i32)> {
    let mut us: Vec<i32> = places.iter().map(|(u, _)| *u).collect();
    us.dedup();
    if closed {
        // Begin at an end in u, so that no stretch is cut in two.
        let first = (0..us.len()).max_by_key(|&i| us[i]).unwrap();
        us.rotate_left(first);
        us.push(us[0]);
        us.dedup();
    }
    if us.len() == 1 {
        return vec![(us[0], us[0])];
    }
    let mut ends = vec![us[0]];
    for i in 1..us.len() - 1 {
        if (us[i] > us[i - 1]) != (us[i + 1] > us[i]) {
            ends.push(us[i]);
        }
    }
    ends.push(us[us.len() - 1]);
    ends.windows(2).map(|pair| (pair[0].min(pair[1]), pair[0].max(pair[1]))).collect()
}

fn chains(part: &Part) -> Vec<(i32, i32)> {
    let hole = part.hole.iter().flat_map(|hole| stretches(hole, true));
    stretches(&part.start, false).into_iter().chain(stretches(&part.finish, false)).chain(hole).collect()
}

/// Whether some place lies strictly inside both: a knife comes by there once. A cut at one place is inside what goes on
/// both before and behind it.
fn disturb(one: (f64, f64), other: (f64, f64)) -> bool {
    let strictly_inside = |place: f64, (low, high): (f64, f64)| low < place && place < high;
    match (one.0 == one.1, other.0 == other.1) {
        (true, true) => false,
        (true, false) => strictly_inside(one.0, other),
        (false, true) => strictly_inside(other.0, one),
        (false, false) => one.0.max(other.0) < one.1.min(other.1),
    }
}

/// Whether one of all the ways of giving these to so many knives lets no two of one knife disturb one another.
fn some_way(chains: &[(f64, f64)], knives: usize) -> bool {
    let disturbed: Vec<u32> = (0..chains.len())
        .map(|i| {
            (0..chains.len())
                .filter(|&j| j != i && disturb(chains[i], chains[j]))
                .fold(0, |mask, j| mask | 1 << j)
        })
        .collect();
    let all = (1_u32 << chains.len()) - 1;
    // The ways of two knives are the sets that the first one makes; of one knife there is one way.
    let ways = if knives == 1 { all..=all } else { 0..=all };
    ways.into_iter().any(|first| {
        (0..chains.len()).all(|i| {
            let mine = if first >> i & 1 == 1 { first } else { all & !first };
            disturbed[i] & mine == 0
        })
    })
}

fn planned(job: &Value) -> Result<Outcome, TestCaseError> {
    let document = document::from_value(job.clone()).unwrap();
    plan(&document, &Files::default(), &Catalogue::built_in(), &Budget::unwatched()).map_err(|faults| {
        let drawn_badly =
            |code: Code| matches!(code, Code::OutlineCrosses | Code::HoleOutside | Code::TooFewPoints);
        if faults.iter().all(|fault| drawn_badly(fault.code)) {
            TestCaseError::reject("an outline that crosses itself")
        } else {
            TestCaseError::fail(format!("{faults:?}"))
        }
    })
}

/// A chain of the planner: its knife, smallest and largest u, and r - u.
type Given = (u64, (f64, f64), f64);

/// The planner's chains of each course.
fn given(outcome: &Outcome) -> Vec<Vec<Given>> {
    let courses = outcome.report["courses"].as_array().unwrap();
    let of_course = |course: &Value| {
        let pieces = course["pieces"].as_array().unwrap();
        let cuts = pieces.iter().flat_map(|piece| {
            let offset = piece["roll_offset_mm"].as_f64().unwrap();
            piece["cuts"].as_array().unwrap().iter().map(move |cut| {
                let us = cut["points_uv"].as_array().unwrap().iter().map(|point| point[0].as_f64().unwrap());
                let (low, high) =
                    us.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), u| (a.min(u), b.max(u)));
                (cut["cutter"].as_u64().unwrap(), (low, high), offset)
            })
        });
        cuts.collect()
    };
    courses.iter().map(of_course).collect()
}

fn agrees(parts: &[Part], knives: usize, allocation: &str) -> Result<Verdict, TestCaseError> {
    let outcome = planned(&job(parts, knives, allocation))?;
    let of_parts: Vec<Vec<(f64, f64)>> = parts
        .iter()
        .map(|part| chains(part).into_iter().map(|(low, high)| (f64::from(low), f64::from(high))).collect())
        .collect();
    let each = of_parts.iter().all(|chains| some_way(chains, knives));
    let verdict = if each { Verdict::Usable } else { Verdict::NotUsable };
    prop_assert_eq!(outcome.verdict, verdict, "{:?}: {:?}", of_parts, outcome.findings);
    if !each {
        let errors: Vec<Code> = outcome.findings.iter().filter(|f| f.is_error()).map(|f| f.code).collect();
        prop_assert!(errors.iter().all(|code| *code == Code::TooManyKnives), "{:?}", errors);
        return Ok(verdict);
    }
    let given = given(&outcome);
    let mut on_roll = Vec::new();
    for (ours, planned) in of_parts.iter().zip(&given) {
        // Both have cut the outline into the same chains.
        let mut theirs: Vec<(f64, f64)> = planned.iter().map(|(_, range, _)| *range).collect();
        let mut ours = ours.clone();
        theirs.sort_by(|a, b| a.partial_cmp(b).unwrap());
        ours.sort_by(|a, b| a.partial_cmp(b).unwrap());
        prop_assert_eq!(ours, theirs);
        on_roll.extend(
            planned.iter().map(|(knife, (low, high), offset)| (*knife, (low + offset, high + offset))),
        );
    }
    // Places of the roll are multiples of 0.0001 mm.
    let whole = |(low, high): (f64, f64)| ((low * 1e4).round(), (high * 1e4).round());
    let ranges: Vec<(f64, f64)> = on_roll.iter().map(|(_, range)| whole(*range)).collect();
    if ranges.len() <= 16 {
        prop_assert!(some_way(&ranges, knives), "no way on the roll: {:?}", on_roll);
    }
    for (i, (knife, _)) in on_roll.iter().enumerate() {
        for j in 0..i {
            let same = on_roll[j].0 == *knife;
            prop_assert!(!same || !disturb(ranges[i], ranges[j]), "{:?} {:?}", on_roll[i], on_roll[j]);
        }
    }
    Ok(verdict)
}

/// Both verdicts must come up for one knife and for two.
fn run(count: std::ops::Range<usize>, cases: u32) {
    let seen = std::cell::RefCell::new(std::collections::BTreeMap::new());
    let config = Config {
        cases: rounds(cases),
        failure_persistence: None,
        max_global_rejects: u32::MAX,
        ..Config::default()
    };
    let strategy = (parts(count), 1..=2_usize, prop::sample::select(vec!["by_slope", "free"]));
    let result = TestRunner::new(config).run(&strategy, |(parts, knives, allocation)| {
        let verdict = agrees(&parts, knives, allocation)?;
        *seen.borrow_mut().entry((knives, verdict == Verdict::Usable)).or_insert(0) += 1;
        Ok(())
    });
    result.unwrap();
    let seen = seen.into_inner();
    assert_eq!(seen.len(), 4, "{seen:?}");
}

#[test]
fn what_can_be_cut_of_a_piece_alone_is_what_some_way_of_giving_its_chains_allows() {
    run(1..2, 400);
}

#[test]
fn what_can_be_cut_of_several_pieces_is_what_some_way_allows_on_the_roll() {
    run(2..4, 300);
}

#[test]
fn the_brute_force_knows_the_rule_of_the_papers() {
    let cut = |us: &[i32]| {
        stretches(&us.iter().enumerate().map(|(i, u)| (*u, i as i32)).collect::<Vec<_>>(), false)
    };
    let float = |chains: Vec<(i32, i32)>| -> Vec<_> {
        chains.into_iter().map(|(a, b)| (f64::from(a), f64::from(b))).collect()
    };
    // ">": two knives; two changes where both ends do not reach past each other: two; three changes: none.
    assert_eq!(cut(&[0, 5, 5, 0]), [(0, 5), (0, 5)]);
    let fits = |us: &[i32], knives: usize| some_way(&float(cut(us)), knives);
    assert!(fits(&[0, 9], 1) && !fits(&[0, 5, 0], 1) && fits(&[0, 5, 0], 2));
    assert!(fits(&[4, 9, 0, 4], 2) && !fits(&[4, 9, 0, 5], 2) && !fits(&[4, 9, 0, 9, 4], 2));
    // A place in the middle of two others is beside both.
    assert!(
        !some_way(&[(0.0, 9.0), (0.0, 9.0), (4.0, 4.0)], 2)
            && some_way(&[(0.0, 4.0), (0.0, 9.0), (4.0, 4.0)], 2)
    );
}
