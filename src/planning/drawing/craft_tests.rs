//! What the drawings show of outlines that were changed and of cuts that go on beyond their ends.

use roxmltree::Document;
use serde_json::{Value, json};

use super::drawings;
use super::tests::{attribute, classes, of_class, path, scales};
use crate::planning::budget::Budget;
use crate::planning::geometry::Point2;
use crate::planning::geometry::polygon::signed_area;
use crate::planning::outcome::Drawing;
use crate::planning::tape::input::check;
use crate::planning::tape::machine::{Catalogue, two_cutter_lab};
use crate::planning::tape::plan::plan;
use crate::planning::tape::wire::TapeCut;

/// A course with a zigzag at its end that three knives would be needed for, and one with a straight end.
fn job(options: Value, overcut_mm: f64) -> Value {
    let mut machine = serde_json::to_value(two_cutter_lab()).unwrap();
    for cutter in machine["cutters"].as_array_mut().unwrap() {
        cutter["blade"]["overcut_mm"] = json!(overcut_mm);
    }
    let track = |number: u32, y: f64| {
        let at = |x: f64| json!({"position": [x, y, 0.0], "normal": [0, 0, 1]});
        json!({"number": number, "points": [at(0.0), at(400.0)]})
    };
    let outline = [[0, 0], [0, 150], [400, 150], [400, 75], [320, 50], [390, 25], [340, 0]];
    json!({
        "tape": {"width_mm": 75, "thickness_mm": 0.125},
        "boundary": {"points": outline.map(|[x, y]| json!([x, y, 0]))},
        "tracks": [track(1, 37.5), track(2, 112.5)], "machine": machine, "options": options,
    })
}

fn drawn(job: Value) -> Vec<Drawing> {
    let job: TapeCut = serde_json::from_value(job).unwrap();
    let input = check(&job, &job.all_plies(), &Catalogue::built_in()).unwrap();
    let plan = plan(&input, &Budget::unwatched(), &mut Vec::new()).unwrap();
    drawings(&plan, &input)
}

fn parsed<'a>(drawings: &'a [Drawing], name: &str) -> Document<'a> {
    Document::parse(&drawings.iter().find(|drawing| drawing.name == name).unwrap().svg).unwrap()
}

#[test]
fn a_changed_outline_is_drawn_as_it_was_with_what_is_left_to_be_trimmed() {
    let simple = drawn(job(json!({"on_excess": "simplify"}), 0.0));
    for name in ["pieces.svg", "pieces-operator.svg"] {
        let document = parsed(&simple, name);
        let scale = scales(&document)[0];
        let [whole] = of_class(document.root(), "whole")
            .flat_map(|whole| of_class(whole, "given").collect::<Vec<_>>())
            .collect::<Vec<_>>()[..]
        else {
            panic!("{name}: one piece was changed, and is drawn whole once");
        };
        let line = path(&whole);
        let deep = line.iter().map(|at| at.x * scale).fold(f64::INFINITY, f64::min);
        let far = line.iter().map(|at| at.x * scale).fold(0.0, f64::max);
        assert!((far - deep - 80.0).abs() < 0.1, "{name}: from the notch at u 320 to the tip at u 400");
        let trim = whole.prev_sibling_element().unwrap();
        assert_eq!(classes(&trim), ["trim"]);
        // The end is raised from 340 until it is no longer cut beside the first run, and the extra area is that.
        let area = signed_area(&path(&trim)).abs() * scale * scale;
        let words: Vec<_> = document.descendants().filter_map(|node| node.text()).collect();
        let fact = words.iter().find(|words| words.contains("to trim")).unwrap();
        let said: f64 = fact.rsplit(' ').nth(3).unwrap().parse().unwrap();
        assert!((area - said).abs() < 0.02 * said, "{name}: {area} {fact}");
        assert!(words.contains(&"left to be trimmed"));
    }
    // An outline that is as it was shows nothing of that, and has no legend for it.
    let mut plain = job(json!({"on_excess": "simplify"}), 0.0);
    plain["boundary"]["points"] = json!([[0, 0, 0], [0, 150, 0], [400, 150, 0], [400, 0, 0]]);
    let plain = drawn(plain);
    let document = parsed(&plain, "pieces.svg");
    assert!(of_class(document.root(), "given").next().is_none() && !plain[0].svg.contains("trimmed"));
}

#[test]
fn an_overcut_is_drawn_from_the_end_of_its_cut_to_where_the_knife_is() {
    let mut square = job(json!({}), 4.0);
    square["boundary"]["points"] = json!([[0, 0, 0], [0, 150, 0], [400, 150, 0], [400, 0, 0]]);
    let with = drawn(square.clone());
    let document = parsed(&with, "roll.svg");
    let scale = scales(&document)[0];
    let rows: Vec<_> = of_class(document.root(), "row").collect();
    let overcuts: Vec<_> = rows.iter().flat_map(|row| of_class(*row, "overcut")).collect();
    // Square ends of two pieces, each with two ends beyond the tape's edges.
    assert!(overcuts.len() >= 6, "{}", overcuts.len());
    let mut marks = rows.iter().flat_map(|row| of_class(*row, "down").chain(of_class(*row, "up")));
    let place = |node: &roxmltree::Node| match node.tag_name().name() {
        "circle" => Point2::new(attribute(node, "cx"), attribute(node, "cy")),
        _ => Point2::new(attribute(node, "x") + 1.05, attribute(node, "y") + 1.05),
    };
    let ends: Vec<Point2> =
        overcuts.iter().map(|line| Point2::new(attribute(line, "x2"), attribute(line, "y2"))).collect();
    for line in &overcuts {
        let length = (attribute(line, "x2") - attribute(line, "x1"))
            .hypot(attribute(line, "y2") - attribute(line, "y1"));
        assert!((length * scale - 4.0).abs() < 0.05 * scale, "{}", length * scale);
        assert!(classes(line).contains(&"cutter-1"), "square ends are cutter 1's");
    }
    assert!(marks.all(|mark| ends.iter().any(|end| (end - place(&mark)).norm() < 0.05)));
    square["machine"] = json!("two-cutter-lab");
    let without = drawn(square);
    assert!(of_class(parsed(&without, "roll.svg").root(), "overcut").next().is_none());
}
