//! How blades turn: the shortest way, within their range, in the material or with the knife up; and stops on the way.

use bladeplan::planning::finding::Code;
use bladeplan::planning::outcome::{Outcome, Verdict};
use bladeplan::planning::program::events::{Event, Executed};
use bladeplan::planning::program::nc::read::read;
use serde_json::{Value, json};

use crate::profiles::{check_program, job, lab, lab_with, plan_job};
use crate::sinumerik::siemens;

const EXAMPLE: &str = "examples/wing-skin-trapezoid-45.job.json";

fn usable(job: &Value, machine: &Value) -> Outcome {
    let outcome = plan_job(job, machine, &json!(null)).unwrap();
    assert_eq!(outcome.verdict, Verdict::Usable, "{:?}", outcome.findings);
    outcome
}

fn events(outcome: &Outcome) -> Vec<Executed> {
    read("p", &outcome.programs[0].text).unwrap()
}

/// Every turn of the blade of cutter 1 between coming up and going down, and every reading of it.
fn turns(outcome: &Outcome) -> (Vec<f64>, Vec<f64>) {
    let (mut turns, mut readings) = (Vec::new(), vec![0.0]);
    let mut up_at = 0.0;
    for executed in events(outcome) {
        let now = readings[readings.len() - 1];
        match executed.event {
            Event::Move { to, .. } => readings.push(to[3]),
            Event::Output { number: 0, on: true } => turns.push(now - up_at),
            Event::Output { number: 0, on: false } => up_at = now,
            _ => {}
        }
    }
    (turns, readings)
}

/// A long piece with round cut-outs in a row: each takes the blade half a turn on, always the same way.
fn round_cut_outs(count: usize) -> Value {
    let long = 60.0 * (count as f64 + 1.0);
    let holes = (0..count).map(|hole| {
        let middle = 60.0 * (hole as f64 + 1.0);
        let round = (0..60).map(|i| f64::from(i * 6).to_radians());
        let points: Vec<_> = round.map(|a| json!([middle + 20.0 * a.cos(), 20.0 * a.sin(), 0.0])).collect();
        json!({"points": points})
    });
    json!({"kind": "tape-cut", "name": "n", "input": {
        "tape": {"width_mm": 75, "thickness_mm": 0.125},
        "boundary": {"points": [[0,-37.5,0],[0,37.5,0],[long,37.5,0],[long,-37.5,0]]},
        "holes": holes.collect::<Vec<_>>(),
        "tracks": [{"number": 1, "points": [{"position":[0,0,0],"normal":[0,0,1]},{"position":[long,0,0],"normal":[0,0,1]}]}]}})
}

#[test]
fn a_long_series_of_turns_is_unwound_with_the_knife_up() {
    let single = lab_with(&[
        ("/cutters/0/blade/edges", json!("single")),
        ("/cutters/1/blade/edges", json!("single")),
        ("/cutters/0/blade/min_deg", json!(-360)),
        ("/cutters/0/blade/max_deg", json!(360)),
    ]);
    for machine in [single, lab()] {
        let ply = round_cut_outs(12);
        let outcome = usable(&ply, &machine);
        let (turns, readings) = turns(&outcome);
        assert!(readings.iter().all(|angle| angle.abs() <= 360.0), "{readings:?}");
        assert!(turns.len() >= 12);
        let text = &outcome.programs[0].text;
        assert!(check_program(&ply, &machine, text).is_empty());
        // Half a turn a cut-out, twelve times over: had nothing been unwound, the blade would be beyond its range.
        let cut: f64 =
            readings.windows(2).map(|pair| pair[1] - pair[0]).sum::<f64>() - turns.iter().sum::<f64>();
        assert!(cut.abs() > 1500.0, "{cut}");
        // A program that winds on instead is refused.
        let word = text.split_whitespace().rfind(|word| word.starts_with('A') && word.len() > 4).unwrap();
        let angle: f64 = word[1..].parse().unwrap();
        let wound = format!("A{:.4}", angle + 720.0_f64.copysign(angle));
        let found = check_program(&ply, &machine, &text.replace(word, &wound));
        assert!(found.iter().any(|finding| finding.code == Code::TravelExceeded), "{found:?}");
    }
}

#[test]
fn a_blade_goes_the_shortest_way_to_its_next_cut() {
    let (double, _) = turns(&usable(&job(EXAMPLE), &lab()));
    // Half a turn changes nothing to two edges, so a quarter is the most.
    assert!(double.len() > 5 && double.iter().all(|turn| turn.abs() <= 90.0 + 1e-3), "{double:?}");
    let single = lab_with(&[("/cutters/0/blade/edges", json!("single"))]);
    let (single, _) = turns(&usable(&job(EXAMPLE), &single));
    assert!(single.iter().all(|turn| turn.abs() <= 180.0 + 1e-3), "{single:?}");
}

/// An end whose cut turns by this angle in the middle of the tape.
fn bent(turn_deg: f64) -> Value {
    let lower = 37.5 * 45.0_f64.to_radians().tan();
    let upper = 37.5 * (45.0 - turn_deg).to_radians().tan();
    let outline = json!([
        [0, -37.5, 0],
        [0, 37.5, 0],
        [400.0 - lower - upper, 37.5, 0],
        [400.0 - lower, 0, 0],
        [400, -37.5, 0]
    ]);
    json!({"kind": "tape-cut", "name": "n", "input": {
        "tape": {"width_mm": 75, "thickness_mm": 0.125}, "boundary": {"points": outline},
        "tracks": [{"number": 1, "points": [{"position":[0,0,0],"normal":[0,0,1]},{"position":[400,0,0],"normal":[0,0,1]}]}]}})
}

#[test]
fn a_corner_just_under_the_lift_angle_is_turned_in_the_material_and_one_just_above_is_not() {
    for (lift, turn, strokes) in [(15.0, 14.9, 2), (15.0, 15.1, 3), (40.0, 39.9, 2), (40.0, 40.1, 3)] {
        let machine = lab_with(&[("/cutters/0/blade/lift_angle_deg", json!(lift))]);
        let outcome = usable(&bent(turn), &machine);
        let text = &outcome.programs[0].text;
        assert_eq!(text.matches("M64 P0").count(), strokes, "{lift} {turn}\n{text}");
        // The blade turns alone, with everything else at rest; whether its knife is down is the question.
        let (mut down, mut turned) = (false, Vec::new());
        for executed in events(&outcome) {
            match executed.event {
                Event::Output { number: 0, on } => down = on,
                Event::Move { from, to, .. } if (0..9).all(|axis| axis == 3 || from[axis] == to[axis]) => {
                    turned.extend((from[3] != to[3]).then_some((down, (to[3] - from[3]).abs())));
                }
                _ => {}
            }
        }
        let at_corner: Vec<_> = turned.iter().filter(|(_, angle)| (angle - turn).abs() < 1e-3).collect();
        assert!(at_corner.len() == 1 && at_corner[0].0 == (strokes == 2), "{lift} {turn}: {turned:?}");
        // The same program does not pass where the knife must lift for less.
        if strokes == 2 {
            let lower = lab_with(&[("/cutters/0/blade/lift_angle_deg", json!(turn - 0.2))]);
            let found = check_program(&bent(turn), &lower, text);
            assert!(found.iter().any(|finding| finding.code == Code::BladeAngle), "{found:?}");
        }
    }
}

#[test]
fn the_operator_may_stop_before_each_course_in_both_dialects() {
    for mut machine in [lab(), siemens()] {
        let stops = |machine: &Value| {
            let text = usable(&job(EXAMPLE), machine).programs.remove(0).text;
            let lines: Vec<String> = text.lines().map(str::to_owned).collect();
            let stop = |line: &String| line.split_once(' ').is_some_and(|(_, words)| words == "M1");
            let labels =
                lines.iter().filter(|line| line.contains("RESTART HERE") && !line.contains("NO RESTART"));
            let before = lines.windows(2).filter(|pair| stop(&pair[0]) && pair[1].contains("RESTART HERE"));
            (lines.iter().filter(|line| stop(line)).count(), before.count(), labels.count())
        };
        machine["program"]["optional_stop_per_course"] = json!(true);
        let (all, before, labels) = stops(&machine);
        assert!(labels >= 3 && all == labels && before == labels, "{all} {before} {labels}");
        machine["program"]["optional_stop_per_course"] = json!(false);
        assert_eq!(stops(&machine).0, 0);
    }
}

/// Corners next to each other are one: the knife comes up where together they turn by more than it may in the tape.
#[test]
fn corners_next_to_each_other_are_one() {
    let corner = |steps: &[(f64, f64)], tolerance: f64, lift_deg: f64| {
        let (mut at, mut points) = ([400.0, 0.0], vec![json!([400.0, -37.5, 0.0]), json!([400.0, 0.0, 0.0])]);
        for (turn, length) in steps {
            let (sin, cos) = f64::to_radians(*turn).sin_cos();
            at = [at[0] + length * sin, at[1] + length * cos];
            points.push(json!([at[0], at[1], 0.0]));
        }
        let (sin, cos) = f64::to_radians(steps[steps.len() - 1].0).sin_cos();
        points.push(json!([at[0] + (37.5 - at[1]) * sin / cos, 37.5, 0.0]));
        points.extend([json!([0.0, 37.5, 0.0]), json!([0.0, -37.5, 0.0])]);
        let point = |u: f64| json!({"position": [u, 0, 0], "normal": [0, 0, 1]});
        let job = json!({"kind": "tape-cut", "input": {"tape": {"width_mm": 75, "thickness_mm": 0.125},
            "boundary": {"points": points}, "tracks": [{"number": 1, "points": [point(0.0), point(500.0)]}],
            "options": {"tolerance_mm": tolerance}}});
        let lift = |cutter: usize| (format!("/cutters/{cutter}/blade/lift_angle_deg"), json!(lift_deg));
        let lifts = [lift(0), lift(1)];
        let lifts: Vec<(&str, Value)> =
            lifts.iter().map(|(at, value)| (at.as_str(), value.clone())).collect();
        let outcome = plan_job(&job, &lab_with(&lifts), &json!({"tolerance_mm": tolerance})).unwrap();
        assert_eq!(outcome.verdict, Verdict::Usable, "{:?}", outcome.findings);
        outcome.programs[0].text.matches("M64 P0").count()
            + outcome.programs[0].text.matches("M64 P1").count()
    };
    // One stroke for each end, and one more where the knife comes up.
    assert_eq!(corner(&[(14.0, 0.025), (28.0, 1.0)], 0.005, 15.0), 3);
    assert_eq!(corner(&[(14.0, 0.1), (28.0, 1.0)], 0.005, 15.0), 2);
    assert_eq!(corner(&[(25.0, 0.028), (50.0, 1.0)], 0.01, 30.0), 3);
    let fillet: Vec<(f64, f64)> =
        (1..=8).map(|step| (f64::from(step) * 10.0, 0.06 * 10.0_f64.to_radians())).collect();
    assert!(corner(&fillet, 0.001, 15.0) > 3);
}
