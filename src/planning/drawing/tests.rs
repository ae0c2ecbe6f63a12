//! What the drawings say, checked against the plan through nothing but their text: the scale is read from its
//! words, places are taken from the centre line and the ruler.

use roxmltree::{Document, Node};
use serde_json::{Value, json};

use super::{View, drawings};
use crate::planning::budget::Budget;
use crate::planning::geometry::simplify::distance_to_segment;
use crate::planning::geometry::{Point2, Point3};
use crate::planning::outcome::Drawing;
use crate::planning::tape::chain::Chain;
use crate::planning::tape::input::{TapeInput, check};
use crate::planning::tape::machine::Catalogue;
use crate::planning::tape::plan::{PlannedCourse, PlannedPiece, TapePlan, plan};
use crate::planning::tape::wire::TapeCut;

/// A flat ply of courses along x, one tape width apart, from a list of outline points.
fn job(width: f64, courses: usize, boundary: &[[f64; 2]], holes: &[Vec<[f64; 2]>]) -> Value {
    let loops =
        |points: &[[f64; 2]]| json!({"points": points.iter().map(|p| [p[0], p[1], 0.0]).collect::<Vec<_>>()});
    let track = |number: usize| {
        let y = width * (number as f64 + 0.5);
        let at = |x: f64| json!({"position": [x, y, 0.0], "normal": [0, 0, 1]});
        json!({"number": number + 1, "points": [at(-10.0), at(100.0)]})
    };
    json!({
        "tape": {"width_mm": width, "thickness_mm": 0.125},
        "boundary": loops(boundary),
        "holes": holes.iter().map(|hole| loops(hole)).collect::<Vec<_>>(),
        "tracks": (0..courses).map(track).collect::<Vec<_>>(),
        "machine": "two-cutter-lab",
    })
}

fn planned(job: Value) -> (TapePlan, TapeInput) {
    let job: TapeCut = serde_json::from_value(job).unwrap();
    let input = check(&job, &job.all_plies(), &Catalogue::built_in()).unwrap();
    let plan = plan(&input, &Budget::unwatched(), &mut Vec::new()).unwrap();
    (plan, input)
}

/// A long taper of two courses with a round cut-out in the first and one through the edge between both.
fn long_ply() -> (TapePlan, TapeInput) {
    let circle = |x: f64, y: f64, radius: f64| -> Vec<[f64; 2]> {
        let angle = |i: i32| f64::from(i).to_radians();
        (0..360).map(|i| [x + radius * angle(i).cos(), y + radius * angle(i).sin()]).collect()
    };
    let boundary = [[0.0, 0.0], [200.0, 300.0], [4300.0, 260.0], [4650.0, 100.0], [4400.0, 0.0]];
    planned(job(150.0, 2, &boundary, &[circle(2600.0, 75.0, 40.0), circle(1500.0, 150.0, 60.0)]))
}

/// A piece of 400 mm: short enough for one row, and readable without details.
fn short_ply() -> (TapePlan, TapeInput) {
    let boundary = [[0.0, 0.0], [400.0, 0.0], [360.0, 40.0], [400.0, 75.0], [37.5, 75.0]];
    planned(job(75.0, 1, &boundary, &[]))
}

pub(super) fn parsed(drawings: &[Drawing]) -> Vec<(&str, Document<'_>)> {
    drawings.iter().map(|drawing| (drawing.name.as_str(), Document::parse(&drawing.svg).unwrap())).collect()
}

fn drawn<'a>(drawings: &'a [Drawing], name: &str) -> Document<'a> {
    Document::parse(&drawings.iter().find(|drawing| drawing.name == name).unwrap().svg).unwrap()
}

pub(super) fn classes<'a>(node: &Node<'a, '_>) -> Vec<&'a str> {
    node.attribute("class").unwrap_or_default().split(' ').collect()
}

pub(super) fn of_class<'a, 'd>(within: Node<'a, 'd>, class: &'a str) -> impl Iterator<Item = Node<'a, 'd>> {
    let of_class = move |node: &Node| classes(node).contains(&class) && !classes(node).contains(&"under");
    within.descendants().filter(of_class)
}

pub(super) fn attribute(node: &Node, name: &str) -> f64 {
    node.attribute(name).unwrap().parse().unwrap()
}

/// The cutter, from 0, that a cut's classes name.
fn cutter(node: &Node) -> usize {
    if classes(node).contains(&"cutter-1") { 0 } else { 1 }
}

pub(super) fn path(node: &Node) -> Vec<Point2> {
    let data = node.attribute("d").unwrap();
    let points = data.split(['M', 'L', 'Z']).filter(|part| !part.is_empty());
    let number = |part: Option<&str>| part.unwrap().parse::<f64>().unwrap();
    points
        .map(|point| {
            let mut parts = point.split(' ');
            Point2::new(number(parts.next()), number(parts.next()))
        })
        .collect()
}

/// The denominators of all scales that the words of a drawing name, in their order.
pub(super) fn scales(document: &Document) -> Vec<f64> {
    let bars = of_class(document.root(), "scale-bar").filter_map(|bar| {
        let words = bar.children().find(|node| node.has_tag_name(("http://www.w3.org/2000/svg", "text")))?;
        words
            .text()?
            .rsplit(' ')
            .next()?
            .split_once(':')
            .map(|(a, b)| b.parse::<f64>().unwrap() / a.parse::<f64>().unwrap())
    });
    bars.collect()
}

/// Where v = 0 and some u are on the sheet, and the scale between: what turns a drawn path back into mm of tape.
struct Key {
    u: f64,
    x: f64,
    y: f64,
    denominator: f64,
    view: View,
}

impl Key {
    fn on_tape(&self, sheet: &Point2) -> Point2 {
        let up = if self.view == View::FromBelow { 1.0 } else { -1.0 };
        Point2::new(
            self.u + (sheet.x - self.x) * self.denominator,
            up * (self.y - sheet.y) * self.denominator,
        )
    }
}

/// Digits of the sheet and what may be thinned out, in mm of the sheet.
const SHEET_MM: f64 = 0.03;

fn near(point: &Point2, line: &[Point2], within: f64) -> bool {
    line.windows(2).any(|pair| distance_to_segment(point, &pair[0], &pair[1]) <= within)
}

fn lies_on(chain: &Chain, offset: f64, points: &[Point2], within: f64) -> bool {
    let shifted: Vec<Point2> = chain.points.iter().map(|p| Point2::new(p.x + offset, p.y)).collect();
    points.iter().all(|point| near(point, &shifted, within))
}

fn length(points: &[Point2]) -> f64 {
    points.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum()
}

fn in_laying_order(plan: &TapePlan) -> impl Iterator<Item = (&PlannedCourse, &PlannedPiece)> {
    plan.courses.iter().flat_map(|course| course.pieces.iter().map(move |piece| (course, piece)))
}

#[test]
fn each_piece_shows_each_of_its_cuts_in_place_with_its_cutter() {
    for (plan, input) in [long_ply(), short_ply()] {
        let drawings = drawings(&plan, &input);
        for (name, view) in [("pieces.svg", View::FromBelow), ("pieces-operator.svg", View::Operator)] {
            let document = drawn(&drawings, name);
            let whole: Vec<Node> = of_class(document.root(), "whole").collect();
            assert_eq!(whole.len(), in_laying_order(&plan).count());
            for (group, (_, piece)) in whole.into_iter().zip(in_laying_order(&plan)) {
                let centre = of_class(group, "centre").next().unwrap();
                let (x, y) = (attribute(&centre, "x1"), attribute(&centre, "y1"));
                let denominator = scales(&document)[0];
                let key = Key { u: piece.piece.u_range().0, x, y, denominator, view };
                let cuts: Vec<Node> = of_class(group, "cut").collect();
                assert_eq!(cuts.len(), piece.chains.len());
                for (cut, (chain, by)) in cuts.iter().zip(&piece.chains) {
                    let points: Vec<Point2> = path(cut).iter().map(|point| key.on_tape(point)).collect();
                    assert_eq!(cutter(cut), *by);
                    assert!(lies_on(chain, 0.0, &points, SHEET_MM * denominator));
                    assert!(
                        chain.points.iter().all(|point| near(point, &points, SHEET_MM * denominator)),
                        "a part of the cut is missing"
                    );
                }
            }
        }
    }
}

#[test]
fn details_show_every_cut_of_a_long_piece_enlarged() {
    let (plan, input) = long_ply();
    let drawings = drawings(&plan, &input);
    let document = drawn(&drawings, "pieces.svg");
    let scales = scales(&document);
    assert!(scales.len() == 2 && scales[1] * 2.0 <= scales[0], "{scales:?}");
    for (card, (_, piece)) in of_class(document.root(), "card").zip(in_laying_order(&plan)) {
        let enlarged: Vec<Node> = of_class(card, "enlarged").collect();
        assert!(enlarged.len() >= 3, "both ends and a cut-out");
        for (by, count) in [0, 1].map(|k| (k, piece.chains.iter().filter(|(_, by)| *by == k).count())) {
            let shown =
                enlarged.iter().flat_map(|group| of_class(*group, "cut")).filter(|cut| cutter(cut) == by);
            assert!(shown.count() >= count);
        }
    }
    let (plan, input) = short_ply();
    let drawings = super::drawings(&plan, &input);
    assert_eq!(of_class(drawn(&drawings, "pieces.svg").root(), "enlarged").count(), 0);
}

#[test]
fn edge_points_are_the_published_ones() {
    let (plan, input) = short_ply();
    let drawings = drawings(&plan, &input);
    let words = |name: &str| -> Vec<String> {
        let document = drawn(&drawings, name);
        let texts = of_class(document.root(), "whole").flat_map(|group| group.descendants());
        let texts = texts.filter(|node| node.is_text()).filter_map(|node| node.text());
        texts.filter(|text| text.starts_with("Edge")).map(str::to_owned).collect()
    };
    // The course starts 10 mm before the ply. Clockwise from there: up the starting end, along the upper edge, down the other end.
    let mut found = words("pieces.svg");
    found.sort();
    assert_eq!(found, ["Edge0 10.0", "Edge0' 410.0", "Edge1 47.5", "Edge1' 410.0"]);
    assert_eq!(words("pieces.svg"), words("pieces-operator.svg"));
}

/// The rows of a roll drawing with their keys.
fn rows<'a>(document: &'a Document<'a>, view: View) -> Vec<(Node<'a, 'a>, Key)> {
    let denominator = scales(document)[0];
    let key = |row: Node| {
        let tick = of_class(row, "quiet").next().unwrap();
        let centre = of_class(row, "centre").next().unwrap();
        let u = tick.text().unwrap().parse().unwrap();
        Key { u, x: attribute(&tick, "x"), y: attribute(&centre, "y1"), denominator, view }
    };
    of_class(document.root(), "row").map(|row| (row, key(row))).collect()
}

#[test]
fn the_roll_shows_all_cuts_and_no_others() {
    for (plan, input) in [long_ply(), short_ply()] {
        let drawings = drawings(&plan, &input);
        let all: Vec<(f64, &Chain, usize)> = in_laying_order(&plan)
            .flat_map(|(_, piece)| piece.chains.iter().map(|(chain, by)| (piece.offset_mm, chain, *by)))
            .collect();
        for (name, view) in [("roll.svg", View::FromBelow), ("roll-operator.svg", View::Operator)] {
            let document = drawn(&drawings, name);
            let mut drawn_length = [0.0, 0.0];
            for (row, key) in rows(&document, view) {
                for cut in of_class(row, "cut") {
                    let points: Vec<Point2> = path(&cut).iter().map(|point| key.on_tape(point)).collect();
                    let by = cutter(&cut);
                    let wanted = all.iter().any(|(offset, chain, wanted_by)| {
                        by == *wanted_by && lies_on(chain, *offset, &points, SHEET_MM * key.denominator)
                    });
                    assert!(wanted, "{name}: {:?} is in no cut of cutter {}", points[0], by + 1);
                    drawn_length[by] += length(&points);
                }
            }
            for by in [0, 1] {
                let wanted: f64 = all.iter().filter(|cut| cut.2 == by).map(|cut| length(&cut.1.points)).sum();
                assert!(
                    (drawn_length[by] / wanted - 1.0).abs() < 0.005,
                    "{name}: {drawn_length:?}, {wanted}"
                );
            }
        }
    }
}

/// The last course of a wing skin once had no number: it lies wholly beside its centre line.
#[test]
fn a_piece_beside_its_centre_line_is_numbered_in_its_middle() {
    let boundary = [[0.0, 0.0], [600.0, 0.0], [580.0, 90.0], [20.0, 90.0]];
    let (plan, input) = planned(job(75.0, 2, &boundary, &[]));
    let drawings = drawings(&plan, &input);
    for (name, view) in [("roll.svg", View::FromBelow), ("roll-operator.svg", View::Operator)] {
        let document = drawn(&drawings, name);
        let (row, key) = rows(&document, view).remove(0);
        let numbers = row.descendants().filter(|node| classes(node).contains(&"halo"));
        let middle = |number: &str| {
            let node = numbers.clone().find(|node| node.text() == Some(number)).unwrap();
            key.on_tape(&Point2::new(attribute(&node, "x"), attribute(&node, "y")))
        };
        assert!((middle("1").y).abs() < 10.0);
        assert!((middle("2").y + 30.0).abs() < 10.0, "{name}: {}", middle("2"));
    }
}

/// Where the marks of a class and a cutter are on the tape, as (r, v).
fn marks(document: &Document, class: &str, by: usize) -> Vec<Point2> {
    let mut places = Vec::new();
    for (row, key) in rows(document, View::FromBelow) {
        for mark in of_class(row, class).filter(|mark| cutter(mark) == by) {
            let sheet = match mark.tag_name().name() {
                "circle" => Point2::new(attribute(&mark, "cx"), attribute(&mark, "cy")),
                _ => {
                    let half = attribute(&mark, "width") / 2.0;
                    Point2::new(attribute(&mark, "x") + half, attribute(&mark, "y") + half)
                }
            };
            places.push(key.on_tape(&sheet));
        }
    }
    places
}

fn check_marks(plan: &TapePlan, input: &TapeInput) {
    let drawings = drawings(plan, input);
    let document = drawn(&drawings, "roll.svg");
    let numbers: Vec<_> = of_class(document.root(), "number").filter_map(|node| node.text()).collect();
    for (by, strokes) in plan.strokes(input).iter().enumerate() {
        assert!(!strokes.is_empty());
        let station = input.machine.cutters[by].station.mm();
        for (class, at_end) in [("down", false), ("up", true)] {
            let found = marks(&document, class, by);
            for stroke in strokes {
                let knot = if at_end { stroke.knots[stroke.knots.len() - 1] } else { stroke.knots[0] };
                let wanted = Point2::new(plan.figures.lead_mm - knot.x + station, knot.v);
                assert!(found.iter().any(|place| (place - wanted).norm() < 1.0), "{class} {wanted}");
            }
        }
        let first = format!("{}·1", by + 1);
        assert!(numbers.contains(&first.as_str()), "{numbers:?}");
    }
}

#[test]
fn each_stroke_is_marked_where_its_knife_goes_down_and_comes_up() {
    let (plan, input) = long_ply();
    check_marks(&plan, &input);
}

/// A drawing once lost the mark of the very first stroke: the program's four decimals had put it 0.0001 mm
/// beyond the leading end of the tape.
#[test]
fn a_mark_that_is_rounded_beyond_the_end_of_the_tape_is_drawn() {
    for beyond in 1..9 {
        let end = 400.0 + f64::from(beyond) * 1e-5;
        let boundary = [[0.0, 0.0], [end, 0.0], [360.0, 40.0], [end, 75.0], [37.5, 75.0]];
        let (plan, input) = planned(job(75.0, 1, &boundary, &[]));
        check_marks(&plan, &input);
    }
}

#[test]
fn pieces_and_scrap_share_the_tape_as_the_report_says() {
    let (plan, input) = short_ply();
    let drawings = drawings(&plan, &input);
    let document = drawn(&drawings, "roll.svg");
    let (row, key) = rows(&document, View::FromBelow).remove(0);
    let square = key.denominator * key.denominator;
    let piece = of_class(row, "piece").next().unwrap();
    let area = crate::planning::geometry::polygon::signed_area(&path(&piece)).abs() * square;
    assert!((area / plan.figures.piece_area_mm2 - 1.0).abs() < 1e-3);
    let hatched = row.descendants().find(|node| node.attribute("fill") == Some("url(#roll-scrap)")).unwrap();
    let tape = attribute(&hatched, "width") * attribute(&hatched, "height") * square;
    assert!((tape - area) / plan.figures.scrap_area_mm2 - 1.0 < 1e-2);
}

/// The coordinates of a node that lie across the tape: all y of it, its group's centre line subtracted.
fn across(node: &Node, centre: f64) -> Vec<f64> {
    path(node).iter().map(|point| point.y - centre).collect()
}

#[test]
fn the_operators_view_is_the_mirror_image_with_upright_texts() {
    let (plan, input) = long_ply();
    let drawings = drawings(&plan, &input);
    for (one, other, group) in
        [("pieces.svg", "pieces-operator.svg", "whole"), ("roll.svg", "roll-operator.svg", "row")]
    {
        let (one, other) = (drawn(&drawings, one), drawn(&drawings, other));
        let groups: Vec<_> = of_class(one.root(), group).zip(of_class(other.root(), group)).collect();
        assert!(!groups.is_empty());
        for (a, b) in groups {
            let centre = |group: Node| attribute(&of_class(group, "centre").next().unwrap(), "y1");
            for class in ["cut", "piece", "tape-edge"] {
                let paths = |group| of_class(group, class).filter(|node| node.has_attribute("d"));
                for (p, q) in paths(a).zip(paths(b)) {
                    let (p, q) = (across(&p, centre(a)), across(&q, centre(b)));
                    assert!(p.len() == q.len() && p.iter().zip(&q).all(|(p, q)| (p + q).abs() < 0.021));
                }
                let x = |group| {
                    paths(group).flat_map(|node| path(&node)).map(|point| point.x).collect::<Vec<_>>()
                };
                assert_eq!(x(a), x(b));
            }
        }
        for document in [&one, &other] {
            assert!(!document.descendants().any(|node| node.has_attribute("transform")));
        }
        let says = |document: &Document| {
            let view = of_class(document.root(), "view").next().unwrap();
            view.text().unwrap().to_owned()
        };
        assert!(says(&one).contains("FROM BELOW") && says(&one).contains("V up"));
        assert!(says(&other).contains("OPERATOR") && says(&other).contains("V down"));
    }
}

#[test]
fn drawings_stand_alone_and_repeat_byte_for_byte() {
    let (plan, input) = long_ply();
    let first = drawings(&plan, &input);
    assert_eq!(first, drawings(&plan, &input));
    let mut ids = Vec::new();
    for (_, document) in parsed(&first) {
        let root = document.root_element();
        let size = |name| root.attribute(name).unwrap().strip_suffix("mm").unwrap();
        assert_eq!(root.attribute("viewBox").unwrap(), format!("0 0 {} {}", size("width"), size("height")));
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
    let names: Vec<_> = first.iter().map(|drawing| drawing.name.as_str()).collect();
    assert_eq!(names, ["pieces.svg", "roll.svg", "pieces-operator.svg", "roll-operator.svg"]);
}

#[test]
fn a_ply_of_very_many_points_gives_a_small_drawing() {
    let (_, mut input) = planned(job(200.0, 1, &[[0.0, 0.0], [4000.0, 0.0], [4000.0, 150.0]], &[]));
    // An edge that is as rough as a knife does not follow: 0.005 mm to and fro, 10 points a mm.
    let rough = |i: i32| Point3::new(4000.0 - f64::from(i) * 0.1, 150.0 + f64::from(i % 2) * 0.005, 0.0);
    let corners = [Point3::origin(), Point3::new(4000.0, 0.0, 0.0)];
    input.plies[0].boundary = corners.into_iter().chain((0..39_999).map(rough)).collect();
    let plan = plan(&input, &Budget::unwatched(), &mut Vec::new()).unwrap();
    let points: usize =
        in_laying_order(&plan).flat_map(|(_, p)| &p.chains).map(|(c, _)| c.points.len()).sum();
    assert!(points > 39_000);
    for drawing in drawings(&plan, &input) {
        assert!(drawing.svg.len() < 20_000, "{}: {} bytes", drawing.name, drawing.svg.len());
    }
}

/// Every number of every attribute that holds numbers.
fn numbers(document: &Document) -> Vec<f64> {
    let names = ["d", "x", "y", "x1", "x2", "y1", "y2", "cx", "cy", "r", "width", "height", "viewBox"];
    let values = document.descendants().flat_map(|node| node.attributes().collect::<Vec<_>>());
    let texts = values.filter(|attribute| names.contains(&attribute.name())).flat_map(|attribute| {
        let parts = attribute.value().split(|c: char| c == ' ' || c.is_ascii_alphabetic());
        parts.filter(|part| !part.is_empty()).map(str::to_owned).collect::<Vec<_>>()
    });
    texts.map(|text| text.parse().unwrap()).collect()
}

#[test]
fn hostile_numbers_give_a_sheet_that_can_be_drawn() {
    let sizes = [(0.01, 1e5), (2000.0, 1e-3), (2000.0, 2e5), (1e-3, 1e-3), (75.0, 1e5)];
    for (width, length) in sizes {
        let boundary =
            [[0.0, 0.0], [length, 0.0], [length * 0.7, width * 0.6], [length * 0.9, width], [0.0, width]];
        let (plan, input) = planned(job(width, 1, &boundary.map(|[x, y]| [x - 1e5, y]), &[]));
        for (name, document) in parsed(&drawings(&plan, &input)) {
            let numbers = numbers(&document);
            assert!(
                numbers.iter().all(|n| n.is_finite() && n.abs() < 5000.0),
                "{name} for {width} x {length}"
            );
            assert!(of_class(document.root(), "cut").count() >= 3);
        }
    }
}

#[test]
fn a_machines_name_is_text() {
    let mut hostile = job(75.0, 1, &[[0.0, 0.0], [400.0, 0.0], [400.0, 75.0], [0.0, 75.0]], &[]);
    let lab = Catalogue::built_in().get("two-cutter-lab").cloned().unwrap();
    hostile["machine"] = serde_json::to_value(lab).unwrap();
    hostile["machine"]["name"] = json!("</text><script>\"&'");
    let (plan, input) = planned(hostile);
    let drawings = drawings(&plan, &input);
    let document = drawn(&drawings, "roll.svg");
    assert!(
        document
            .descendants()
            .any(|node| node.text().is_some_and(|text| text.contains("</text><script>\"&'")))
    );
}
