//! What the joints of the robot do over time: their angles with their limits, and how fast they turn.

use super::axis::{Axis, Direction, is_shown, range, with_room};
use super::chart::{ABOVE_MM, BELOW_MM, Chart, LEFT_MM};
use super::label::baseline;
use super::mark::Mark;
use super::page::Page;
use super::sheet::{INNER_MM, MARGIN_MM, SMALL_MM, Sample, figure, text_width};
use super::svg::{Anchor, Svg, spot};
use crate::planning::geometry::Point2;
use crate::planning::outcome::Drawing;

/// The robot at one moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointSample {
    /// From the beginning of the program, in s; never falling.
    pub time_s: f64,
    /// A1 to A6 in degrees.
    pub joints_deg: [f64; 6],
    /// The largest of the joints' speeds, each over its limit: at most 1 is within.
    pub speed_ratio: f64,
}

/// The first statement that the robot cannot follow.
#[derive(Debug, Clone, PartialEq)]
pub struct JointFault {
    /// When, in s.
    pub time_s: f64,
    /// The joint, from 0, if one alone is at fault.
    pub joint: Option<usize>,
    /// What is wrong, in words of ours: `beyond its limit`.
    pub what: &'static str,
    /// The file of the program; its name is made from content only.
    pub file: String,
    /// The line in it, from 1.
    pub line: usize,
}

/// What is shown.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct JointCurves {
    /// The arm if it is a built-in one, else nothing: names that others gave stay out of drawings.
    pub arm: &'static str,
    /// The samples in order.
    pub samples: Vec<JointSample>,
    /// Smallest and largest angle of each joint in degrees.
    pub limits_deg: [(f64, f64); 6],
    /// The first fault, if there is one.
    pub fault: Option<JointFault>,
}

/// Width of the chart of one joint, of which two stand beside one another.
const WIDTH_MM: f64 = (INNER_MM - 2.0 * LEFT_MM - GAP_MM) / 2.0;
/// Its height.
const HEIGHT_MM: f64 = 26.0;
/// Height of the chart of speeds.
const RATIO_MM: f64 = 28.0;
const GAP_MM: f64 = 7.0;

/// Joint angles and speeds over time: `joints.svg`.
#[must_use]
pub fn joints(data: &JointCurves) -> Drawing {
    let mut page = Page::new("Robot joints over time", "", &lines(data));
    page.legend(&legend(data));
    let top = page.y + ABOVE_MM;
    let row = HEIGHT_MM + ABOVE_MM + BELOW_MM;
    for joint in 0..6 {
        let corner = spot(
            MARGIN_MM + LEFT_MM + (joint % 2) as f64 * (WIDTH_MM + GAP_MM + LEFT_MM),
            top + (joint / 2) as f64 * row,
        );
        let chart = joint_chart(data, joint, corner);
        page.svg.group("joint", "", |svg| draw_joint(svg, &chart, data, joint));
    }
    let chart = ratio_chart(data, top + 3.0 * row);
    page.svg.group("speed", "", |svg| draw_ratio(svg, &chart, data));
    page.finish("joints", chart.bottom() + BELOW_MM)
}

fn lines(data: &JointCurves) -> Vec<String> {
    let mut lines = vec![format!(
        "{}Angles of the joints A1 to A6 along the program, each with its limits; below, the speed of the fastest joint as a share of its limit.",
        if data.arm.is_empty() { String::new() } else { format!("{}. ", data.arm) }
    )];
    lines.push(match &data.fault {
        None if data.samples.is_empty() => "Nothing was computed: there is no motion to show.".to_owned(),
        None => "The robot follows the whole program.".to_owned(),
        Some(fault) => {
            let joint = fault.joint.map_or_else(String::new, |joint| format!("A{} ", joint + 1));
            format!(
                "First fault: {joint}{}, {} line {}, at {} s.",
                fault.what,
                fault.file,
                fault.line,
                figure(fault.time_s, 3)
            )
        }
    });
    lines
}

fn legend(data: &JointCurves) -> Vec<(Sample, String)> {
    let mut legend = vec![
        (Sample::Line("curve stroke-1"), "angle of the joint; speed".to_owned()),
        (Sample::Line("limit-dashed"), "limit".to_owned()),
        (Sample::Area("beyond"), "beyond a limit".to_owned()),
    ];
    if data.fault.is_some() {
        legend.push((Sample::Mark(Mark::Cross, "ink-4"), "first fault".to_owned()));
    }
    legend
}

fn times(data: &JointCurves) -> (f64, f64) {
    let fault = data.fault.iter().map(|fault| fault.time_s);
    range(data.samples.iter().map(|sample| sample.time_s).chain(fault))
}

fn joint_chart(data: &JointCurves, joint: usize, corner: super::svg::Spot) -> Chart {
    let (low, high) = data.limits_deg[joint];
    let angles = data.samples.iter().map(|sample| sample.joints_deg[joint]);
    let (from, to) = times(data);
    Chart {
        corner,
        x: Axis::between("time in s", (from, to), WIDTH_MM, Direction::Along),
        y: Axis::between(
            &format!("A{} in °", joint + 1),
            with_room(range(angles.chain([low, high]))),
            HEIGHT_MM,
            Direction::Up,
        ),
    }
}

fn draw_joint(svg: &mut Svg, chart: &Chart, data: &JointCurves, joint: usize) {
    let (low, high) = data.limits_deg[joint];
    if low < high {
        draw_beyond(svg, chart, (low, high));
    }
    chart.draw_axes(svg);
    let point = |sample: &JointSample| Point2::new(sample.time_s, sample.joints_deg[joint]);
    let points: Vec<Point2> = data.samples.iter().map(point).collect();
    chart.draw_curve(svg, "curve stroke-1", &points, "");
    draw_margin(svg, chart, &points, (low, high));
    draw_fault(svg, chart, data, &points, |fault| fault.joint == Some(joint));
}

/// What lies outside the limits is shaded, and the limits themselves are lines.
fn draw_beyond(svg: &mut Svg, chart: &Chart, (low, high): (f64, f64)) {
    chart.draw_band(svg, "beyond", (chart.y.low, low));
    chart.draw_band(svg, "beyond", (high, chart.y.high));
    for limit in [low, high] {
        chart.draw_level(svg, "limit-dashed", limit);
    }
}

/// The smallest distance to a limit, in words above the chart.
fn draw_margin(svg: &mut Svg, chart: &Chart, points: &[Point2], (low, high): (f64, f64)) {
    let margins = points.iter().map(|point| (point.y - low).min(high - point.y));
    let Some(least) = margins.filter(|margin| is_shown(*margin)).reduce(f64::min) else { return };
    let limits = format!("limits {}° and {}°", figure(low, 1), figure(high, 1));
    let words = if least < 0.0 {
        format!("{limits}, exceeded by {}°", figure(-least, 2))
    } else {
        format!("{limits}, nearest {}° away", figure(least, 2))
    };
    svg.text("quiet", spot(chart.right(), chart.corner.y - 1.6), Anchor::End, &words);
}

fn ratio_chart(data: &JointCurves, y: f64) -> Chart {
    let ratios = data.samples.iter().map(|sample| sample.speed_ratio);
    let (from, to) = times(data);
    Chart {
        corner: spot(MARGIN_MM + LEFT_MM, y),
        x: Axis::between("time in s", (from, to), INNER_MM - LEFT_MM, Direction::Along),
        y: Axis::fitted(
            "speed of the fastest joint as a share of its limit",
            ratios.chain([0.0, 1.2]),
            RATIO_MM,
            Direction::Up,
        ),
    }
}

fn draw_ratio(svg: &mut Svg, chart: &Chart, data: &JointCurves) {
    chart.draw_band(svg, "beyond", (1.0, chart.y.high));
    chart.draw_axes(svg);
    chart.draw_level(svg, "limit-dashed", 1.0);
    let point = |sample: &JointSample| Point2::new(sample.time_s, sample.speed_ratio);
    let points: Vec<Point2> = data.samples.iter().map(point).collect();
    chart.draw_curve(svg, "curve stroke-1", &points, "");
    let shown = points.iter().filter(|point| chart.shows(point));
    if let Some(most) = shown.max_by(|one, other| one.y.total_cmp(&other.y)) {
        let words = format!("largest {} at {} s", figure(most.y, 3), figure(most.x, 2));
        svg.text("quiet", spot(chart.right(), chart.corner.y - 1.6), Anchor::End, &words);
    }
    draw_fault(svg, chart, data, &points, |fault| fault.joint.is_none());
    let Some(fault) = &data.fault else { return };
    let words = format!("line {}", fault.line);
    let width = text_width(&words, SMALL_MM);
    let x = chart.spot(fault.time_s, chart.y.low).x;
    let aside = if x + width + 3.0 < chart.right() { width / 2.0 + 1.5 } else { -width / 2.0 - 1.5 };
    if is_shown(fault.time_s) {
        let place = spot(x + aside, chart.corner.y + 3.0);
        svg.text("small head halo ink-4", baseline(place, SMALL_MM), Anchor::Middle, &words);
    }
}

/// A line where the first fault is, and a cross on the curve where it concerns this chart.
fn draw_fault(
    svg: &mut Svg,
    chart: &Chart,
    data: &JointCurves,
    points: &[Point2],
    is_own: impl Fn(&JointFault) -> bool,
) {
    let Some(fault) = &data.fault else { return };
    chart.draw_upright(svg, "curve fine stroke-4", fault.time_s);
    let nearest = points
        .iter()
        .filter(|point| chart.shows(point))
        .min_by(|one, other| (one.x - fault.time_s).abs().total_cmp(&(other.x - fault.time_s).abs()));
    if let Some(point) = nearest.filter(|_| is_own(fault)) {
        chart.draw_mark(svg, Mark::Cross, "ink-4", &Point2::new(fault.time_s, point.y));
    }
}
