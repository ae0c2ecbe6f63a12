//! A program over time: tape, carriages and blades as curves, knives down and the generator as bars.

use super::axis::{Axis, Direction};
use super::chart::{ABOVE_MM, BELOW_MM, Chart, LEFT_MM};
use super::mark::Mark;
use super::page::Page;
use super::sheet::{DOT_MM, INNER_MM, MARGIN_MM, SMALL_MM, Sample, figure};
use super::svg::{Anchor, Path, Spot, Svg, spot};
use crate::planning::geometry::Point2;
use crate::planning::outcome::Drawing;
use crate::planning::program::moves::{Pose, Step, TapeProgram};
use crate::planning::tape::label::CourseLabel;
use crate::planning::tape::machine::Machine;

/// Height of the charts of tape, carriages and blades.
const HEIGHTS_MM: [f64; 3] = [40.0, 40.0, 30.0];
/// Height of a bar, and from one row of bars to the next.
const BAR_MM: f64 = 3.2;
const ROW_MM: f64 = 5.0;
/// Room left of the bars for their names.
const NAME_MM: f64 = 18.0;

/// Draws a program over time: `timeline.svg`.
#[must_use]
pub fn timeline(program: &TapeProgram, machine: &Machine) -> Drawing {
    let curves = Curves::of(program, machine);
    let mut page = Page::new("Timeline", "", &lines(program));
    let cutters = machine.cutters.iter().enumerate();
    page.legend(
        &cutters
            .map(|(k, cutter)| (Sample::Line(STROKES[k]), format!("cutter {}", cutter.number)))
            .chain([(Sample::Mark(Mark::Diamond, "ink-3"), "a course begins".to_owned())])
            .collect::<Vec<_>>(),
    );
    let mut top = page.y;
    let panels: [(&str, &[Vec<Point2>]); 3] = [
        ("tape, mm", std::slice::from_ref(&curves.feed)),
        ("carriages, mm across the tape", &curves.lateral),
        ("blades, degrees from V", &curves.blade),
    ];
    for ((words, lines), height) in panels.into_iter().zip(HEIGHTS_MM) {
        top += ABOVE_MM;
        let chart = chart(words, lines, program.time_s, spot(MARGIN_MM + NAME_MM, top), height);
        page.svg.group("panel", "", |svg| draw_panel(svg, &chart, lines));
        if words == "tape, mm" {
            page.svg.group("courses", "", |svg| draw_courses(svg, &chart, &curves.courses));
        }
        top = chart.bottom() + BELOW_MM;
    }
    let end = draw_bars(&mut page.svg, &curves, program.time_s, spot(MARGIN_MM + NAME_MM, top));
    page.finish("timeline", end)
}

/// Classes of the curves of each cutter.
const STROKES: [&str; 2] = ["curve stroke-1 fine", "curve stroke-2 fine"];

fn lines(program: &TapeProgram) -> Vec<String> {
    let dry = program.dry.then(|| "DRY RUN: knives stay up, the generator stays off.".to_owned());
    let whole = format!(
        "{} s from start to end, each move from rest to rest with the accelerations of the profile. Below, when each knife is down and the generator on.",
        figure(program.time_s, 1)
    );
    dry.into_iter().chain([whole]).collect()
}

/// A program as curves over time.
struct Curves {
    feed: Vec<Point2>,
    lateral: Vec<Vec<Point2>>,
    blade: Vec<Vec<Point2>>,
    /// Name and place of each course's beginning.
    courses: Vec<(CourseLabel, Point2)>,
    /// From when to when each knife is down, and then the generator on, with their names.
    bars: Vec<(String, Vec<[f64; 2]>)>,
}

impl Curves {
    fn of(program: &TapeProgram, machine: &Machine) -> Self {
        let cutters = machine.cutters.len();
        let knives = machine.cutters.iter().map(|cutter| (format!("knife {}", cutter.number), Vec::new()));
        let mut curves = Self {
            feed: Vec::new(),
            lateral: vec![Vec::new(); cutters],
            blade: vec![Vec::new(); cutters],
            courses: Vec::new(),
            bars: knives.chain([("ultrasonic".to_owned(), Vec::new())]).collect(),
        };
        let mut open: Vec<Option<f64>> = vec![None; cutters + 1];
        let (mut pose, mut now) = (machine.home(), 0.0);
        curves.stand(now, &pose);
        if program.start != pose {
            // A program from a course on begins with its way into place; the generator is on once the tape is there.
            (pose, now) = (program.start, program.ends_s.first().copied().unwrap_or(0.0));
            curves.stand(now, &pose);
            open[cutters] = (!program.dry).then_some(program.approach_s);
        }
        for (step, &end) in program.steps.iter().zip(&program.ends_s) {
            match *step {
                Step::Move { to, .. } => {
                    curves.stand(now, &pose);
                    pose = to;
                    curves.stand(end, &pose);
                }
                Step::Knife { .. } | Step::Ultrasonic { .. } if program.dry => {}
                Step::Knife { cutter, down } => curves.switch(&mut open, cutter, down, end),
                Step::Ultrasonic { on } => curves.switch(&mut open, cutters, on, end),
                Step::Course { label, .. } => {
                    curves.courses.push((label, Point2::new(end, pose.feed_mm)));
                }
                Step::Dwell { .. } | Step::OptionalStop => {}
            }
            now = end;
        }
        curves.stand(now, &pose);
        curves
    }

    fn stand(&mut self, time: f64, pose: &Pose) {
        self.feed.push(Point2::new(time, pose.feed_mm));
        for (k, curve) in self.lateral.iter_mut().enumerate() {
            curve.push(Point2::new(time, pose.lateral_mm[k]));
        }
        for (k, curve) in self.blade.iter_mut().enumerate() {
            curve.push(Point2::new(time, pose.blade_deg[k]));
        }
    }

    fn switch(&mut self, open: &mut [Option<f64>], index: usize, on: bool, time: f64) {
        match (on, open[index].take()) {
            (true, since) => open[index] = Some(since.unwrap_or(time)),
            (false, Some(since)) => self.bars[index].1.push([since, time]),
            (false, None) => {}
        }
    }
}

fn chart(words: &str, lines: &[Vec<Point2>], end_s: f64, corner: Spot, height: f64) -> Chart {
    let values = lines.iter().flatten().map(|point| point.y);
    Chart {
        corner,
        x: Axis::between("time, s", (0.0, end_s), INNER_MM - NAME_MM, Direction::Along),
        y: Axis::fitted(words, values, height, Direction::Up),
    }
}

fn draw_panel(svg: &mut Svg, chart: &Chart, lines: &[Vec<Point2>]) {
    chart.draw_axes(svg);
    for (k, points) in lines.iter().enumerate() {
        let class = if lines.len() == 1 { "curve stroke-3 fine" } else { STROKES[k] };
        chart.draw_curve(svg, class, points, "");
    }
}

/// Marks where courses begin; numbers that would touch are left out.
fn draw_courses(svg: &mut Svg, chart: &Chart, courses: &[(CourseLabel, Point2)]) {
    let mut free = f64::NEG_INFINITY;
    for (label, place) in courses {
        let Some(at) = chart.draw_mark(svg, Mark::Diamond, "ink-3", place) else { continue };
        if at.x > free {
            svg.text("number halo", spot(at.x, at.y - 1.8), Anchor::Middle, &label.short());
            free = at.x + LEFT_MM;
        }
    }
}

fn draw_bars(svg: &mut Svg, curves: &Curves, end_s: f64, corner: Spot) -> f64 {
    let scale = (INNER_MM - NAME_MM) / end_s.max(f64::MIN_POSITIVE);
    for (row, (name, bars)) in curves.bars.iter().enumerate() {
        let y = corner.y + row as f64 * ROW_MM;
        svg.text("small", spot(corner.x - 1.5, y + (BAR_MM + SMALL_MM) / 2.0), Anchor::End, name);
        let mut path = Path::default();
        for [from, to] in merged(bars, DOT_MM / scale) {
            let (left, right) = (corner.x + from * scale, corner.x + to * scale);
            let (top, bottom) = (y, y + BAR_MM);
            path.closed([spot(left, top), spot(right, top), spot(right, bottom), spot(left, bottom)]);
        }
        let class = ["bar-1", "mark ink-2"].get(row).copied().filter(|_| row + 1 < curves.bars.len());
        svg.path(class.unwrap_or("mark ink-3"), &path, name);
    }
    corner.y + curves.bars.len() as f64 * ROW_MM
}

/// Bars with gaps that cannot be seen are one.
fn merged(bars: &[[f64; 2]], gap_s: f64) -> Vec<[f64; 2]> {
    let mut merged: Vec<[f64; 2]> = Vec::new();
    for bar in bars {
        match merged.last_mut() {
            Some(last) if bar[0] - last[1] < gap_s => last[1] = bar[1],
            _ => merged.push(*bar),
        }
    }
    merged
}
