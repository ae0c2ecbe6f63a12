//! What the drawings of honeycomb jobs say, read back from nothing but their text: numbers of ticks give the scale.

use roxmltree::{Document, Node};

use super::comparison::{Comparison, SetFigures, TimeSplit, comparison};
use super::contour::{Origin, contours, correlation};
use super::joints::{JointCurves, JointFault, JointSample, joints};
use super::milling::{Paths, milling};
use super::optimum::{Cell, Limit, OptimumMap, ParameterSet, Row, map};
use super::section::{Scallop, Section, section};
use super::table1;
use super::tests::{attribute, classes, of_class, parsed, path, scales};
use crate::planning::geometry::polygon::signed_area;
use crate::planning::geometry::{Point2, Point3};
use crate::planning::honeycomb::contour::{Likeness, Samples, compare};
use crate::planning::outcome::Drawing;

mod said;

/// A fault of A4 within the Table 1 program.
fn faulty() -> JointCurves {
    let fault = JointFault {
        time_s: 212.4,
        joint: Some(3),
        what: "beyond its limit",
        file: "layer_07.src".to_owned(),
        line: 214,
    };
    JointCurves { fault: Some(fault), ..table1::joints(3000) }
}

/// A dense lattice with chips that stay, small and large, and gouges.
fn faulty_section() -> Section {
    let points = |list: &[(f64, f64)]| list.iter().map(|&(x, z)| Point2::new(x, z)).collect::<Vec<_>>();
    Section {
        stuck: vec![
            points(&[(20.0, 40.0), (26.0, 40.0), (23.0, 36.0)]),
            points(&[(60.0, 40.0), (60.2, 40.0), (60.1, 39.9)]),
        ],
        gouges: vec![points(&[(30.0, 12.0), (36.0, 14.0), (33.0, 10.0)]), points(&[(60.0, 11.0)])],
        ..table1::section(1.5, 1.5)
    }
}

/// A contour measured on a part: 0.4 mm too low and 2 mm to the right.
fn measured() -> Likeness {
    let shifted = table1::contour().iter().map(|at| Point2::new(at.x + 2.0, at.y - 0.4)).collect();
    compare(&table1::contour(), &[shifted]).unwrap()
}

/// All sheets of Table 1.
fn sheets() -> Vec<Drawing> {
    let likeness = table1::likeness();
    vec![
        map(&table1::optimum_map()),
        comparison(&table1::comparison()),
        section(&table1::published(), "section"),
        section(&faulty_section(), "section-faulty"),
        milling(&table1::paths(&table1::published().tips)),
        joints(&table1::joints(3000)),
        joints(&faulty()),
        contours(&likeness, Origin::Simulated),
        contours(&measured(), Origin::Measured),
        correlation(&likeness, Origin::Simulated),
        correlation(&measured(), Origin::Measured),
    ]
}

/// Sheets of nothing, and of numbers that no job has: all of them that number, or the sizes between them.
fn hostile_sheets() -> Vec<(String, Drawing)> {
    let mut sheets: Vec<(String, Drawing)> =
        hostile(&[]).into_iter().map(|drawing| ("nothing".to_owned(), drawing)).collect();
    let numbers = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, -1e300, 1e-300, 1e9, -1e9, 0.0, 1e-7];
    let mixtures =
        [vec![0.0, 1e9, f64::NAN, 1e-9, -1e9], vec![1e-12, 1e12], vec![1e5, 1e-3], vec![5.0, -5.0]];
    for list in numbers.into_iter().map(|number| vec![number]).chain(mixtures) {
        sheets.extend(hostile(&list).into_iter().map(|drawing| (format!("{list:?}"), drawing)));
    }
    sheets
}

/// All sheets with the numbers of a list in turn.
#[expect(clippy::too_many_lines, reason = "one value for each field of every drawing's data")]
fn hostile(list: &[f64]) -> Vec<Drawing> {
    let mut turn = list.iter().copied().cycle();
    let mut next = || turn.next().unwrap_or_default();
    let points = |next: &mut dyn FnMut() -> f64| -> Vec<Point2> {
        (0..3 * list.len()).map(|_| Point2::new(next(), next())).collect()
    };
    let set = |next: &mut dyn FnMut() -> f64| SetFigures {
        layer_spacing_mm: next(),
        step_mm: next(),
        swing_angle_deg: next(),
        shift_mm: next(),
        scallop_mm: next(),
        split: TimeSplit { cutting_s: next(), turning_s: next(), moving_s: next() },
    };
    let parameters =
        ParameterSet { layer_spacing_mm: next(), step_mm: next(), swing_angle_deg: next(), time_s: next() };
    let rows = list.iter().map(|angle| Row {
        swing_angle_deg: *angle,
        cells: list
            .iter()
            .flat_map(|h| [(*h, Cell::Time(next())), (-h, Cell::Excluded(Limit::Scallop))])
            .collect(),
    });
    let some = !list.is_empty();
    let optimum_map = OptimumMap {
        rows: rows.collect(),
        optimum: some.then_some(parameters),
        initial: some.then_some(parameters),
    };
    let sets = Comparison {
        initial: some.then(|| set(&mut next)),
        optimised: set(&mut next),
        max_scallop_mm: next(),
    };
    let cut = Section {
        plan: "",
        blank: (next(), next()),
        contour: points(&mut next),
        surface: vec![points(&mut next), Vec::new()],
        tips: points(&mut next),
        swing_angle_deg: next(),
        reach_mm: next(),
        stuck: vec![points(&mut next), Vec::new()],
        gouges: vec![points(&mut next)],
        scallop: some
            .then(|| Scallop { ridge: Point2::new(next(), next()), foot: Point2::new(next(), next()) }),
        max_scallop_mm: some.then(&mut next),
    };
    let way = |next: &mut dyn FnMut() -> f64| -> Vec<Point3> {
        (0..3 * list.len()).map(|_| Point3::new(next(), next(), next())).collect()
    };
    let paths = Paths { blank: (next(), next(), next()), milling: way(&mut next), converted: way(&mut next) };
    let sample =
        |_| JointSample { time_s: next(), joints_deg: [(); 6].map(|()| next()), speed_ratio: next() };
    let samples: Vec<JointSample> = (0..3 * list.len()).map(sample).collect();
    let fault = some.then(|| JointFault {
        time_s: next(),
        joint: Some(0),
        what: "too fast",
        file: String::new(),
        line: 0,
    });
    let curves = JointCurves { arm: "", samples, limits_deg: [(); 6].map(|()| (next(), next())), fault };
    let likeness = Likeness {
        correlation: some.then(&mut next),
        correlation_mean_removed: some.then(&mut next),
        max_deviation_mm: next(),
        max_deviation_x_mm: next(),
        samples: Samples { range: (next(), next()), wanted: list.to_vec(), cut: list.to_vec() },
    };
    vec![
        map(&optimum_map),
        comparison(&sets),
        section(&cut, "section"),
        milling(&paths),
        joints(&curves),
        contours(&likeness, Origin::Simulated),
        correlation(&likeness, Origin::Measured),
    ]
}

/// From where to where an element reaches on the sheet: left, right, top, bottom.
fn extent(node: &Node) -> Option<[f64; 4]> {
    let around = |points: Vec<Point2>| {
        let x = points.iter().map(|at| at.x);
        let y = points.iter().map(|at| at.y);
        let (least, most) = (f64::INFINITY, f64::NEG_INFINITY);
        [
            x.clone().fold(least, f64::min),
            x.fold(most, f64::max),
            y.clone().fold(least, f64::min),
            y.fold(most, f64::max),
        ]
    };
    let at = |x: &str, y: &str| Point2::new(attribute(node, x), attribute(node, y));
    match node.tag_name().name() {
        "line" => Some(around(vec![at("x1", "y1"), at("x2", "y2")])),
        "rect" if node.has_attribute("x") => {
            let size = nalgebra::Vector2::new(attribute(node, "width"), attribute(node, "height"));
            Some(around(vec![at("x", "y"), at("x", "y") + size]))
        }
        "circle" => {
            let radius = nalgebra::Vector2::repeat(attribute(node, "r"));
            Some(around(vec![at("cx", "cy") - radius, at("cx", "cy") + radius]))
        }
        "path" => Some(around(path(node))),
        "text" => Some(text_extent(node)),
        _ => None,
    }
}

/// The room of a text in a usual font: half of its size is the width of a letter, 0.72 of it the height of a capital.
fn text_extent(node: &Node) -> [f64; 4] {
    let has = |class: &str| classes(node).contains(&class);
    let size = [("title", 5.0), ("small", 2.5), ("quiet", 2.5), ("number", 2.2)];
    let size = size.into_iter().find(|(class, _)| has(class)).map_or(3.2, |(_, size)| size);
    let width = node.text().unwrap_or_default().chars().count() as f64 * size * 0.5;
    let (x, y) = (attribute(node, "x"), attribute(node, "y"));
    let left = match node.attribute("text-anchor") {
        Some("middle") => x - width / 2.0,
        Some("end") => x - width,
        _ => x,
    };
    [left, left + width, y - 0.72 * size, y]
}

/// The elements that are drawn, without those of patterns.
fn drawn<'a, 'd>(document: &'a Document<'d>) -> impl Iterator<Item = Node<'a, 'd>> {
    document.descendants().filter(|node| !node.ancestors().any(|above| above.has_tag_name(PATTERN)))
}

const PATTERN: (&str, &str) = ("http://www.w3.org/2000/svg", "pattern");

fn check_on_paper(name: &str, document: &Document) {
    let root = document.root_element();
    let size = |name: &str| root.attribute(name).unwrap().strip_suffix("mm").unwrap().parse::<f64>().unwrap();
    let (width, height) = (size("width"), size("height"));
    assert!(width == 297.0 && height > 30.0 && height < 300.0, "{name}: {width} x {height}");
    for node in drawn(document) {
        let Some([left, right, top, bottom]) = extent(&node) else { continue };
        let inside = left >= -0.01 && right <= width + 0.01 && top >= -0.01 && bottom <= height + 0.01;
        assert!(inside, "{name}: {node:?} at {:?}", extent(&node));
    }
}

#[test]
fn sheets_stand_alone_on_their_paper_and_repeat_byte_for_byte() {
    let first = sheets();
    assert_eq!(first, sheets());
    let mut ids = Vec::new();
    for (name, document) in parsed(&first) {
        check_on_paper(name, &document);
        for node in document.descendants() {
            assert!(!["script", "image", "use", "a"].contains(&node.tag_name().name()));
            assert!(!node.attributes().any(|attribute| attribute.name().contains("href")));
            ids.extend(node.attribute("id").map(str::to_owned));
        }
    }
    let count = ids.len();
    ids.sort();
    ids.dedup();
    assert_eq!(ids.len(), count, "drawings on one page must not take each other's hatching");
    let mut names: Vec<&str> = first.iter().map(|drawing| drawing.name.as_str()).collect();
    assert!(names.iter().all(|name| name.ends_with(".svg")));
    names.dedup();
    let wanted = "optimum comparison section section-faulty milling joints contour contour-measured correlation correlation-measured";
    let wanted: Vec<String> = wanted.split(' ').map(|name| format!("{name}.svg")).collect();
    assert_eq!(names, wanted);
}

#[test]
fn words_do_not_cover_one_another() {
    for (name, document) in parsed(&sheets()) {
        let is_words = |node: &Node| node.tag_name().name() == "text" && !classes(node).contains(&"under");
        let texts: Vec<Node> = drawn(&document).filter(is_words).collect();
        for (index, one) in texts.iter().enumerate() {
            let [left, right, top, bottom] = text_extent(one);
            for other in &texts[index + 1..] {
                let [l, r, t, b] = text_extent(other);
                let apart = right <= l || r <= left || bottom <= t || b <= top;
                assert!(apart, "{name}: {:?} and {:?}", one.text(), other.text());
            }
        }
    }
}

#[test]
fn hostile_numbers_give_sheets_that_can_be_drawn() {
    for (numbers, drawing) in hostile_sheets() {
        let name = format!("{} of {numbers}", drawing.name);
        let document = Document::parse(&drawing.svg).unwrap();
        check_on_paper(&name, &document);
        assert!(!drawing.svg.contains("NaN") && !drawing.svg.contains("inf\""), "{name}");
    }
}

/// Lightness of the bands in light and in dark surroundings, as the style sheet has them.
#[test]
fn bands_are_told_apart_without_colour() {
    let style = include_str!("chart.css");
    let lightness = |part: &str, index: usize| -> f64 {
        let (_, after) = part.split_once(&format!(".band-{index}{{fill:#")).unwrap();
        let channel = |from: usize| f64::from(u32::from_str_radix(&after[from..from + 2], 16).unwrap());
        0.299 * channel(0) + 0.587 * channel(2) + 0.114 * channel(4)
    };
    let (light, dark) = style.split_once("@media").unwrap();
    for (part, sign) in [(light, 1.0), (dark, -1.0)] {
        let steps = (1..10).map(|index| sign * (lightness(part, index) - lightness(part, index - 1)));
        assert!(steps.clone().all(|step| step > 8.0), "{:?}", steps.collect::<Vec<_>>());
    }
}
