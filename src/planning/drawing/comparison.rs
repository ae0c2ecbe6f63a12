//! Two sets of parameters side by side (the paper's Fig. 7): where the time goes, and what is left standing.

use super::axis::{Axis, Direction, is_shown};
use super::chart::{ABOVE_MM, BELOW_MM, Chart, LEFT_MM};
use super::mark::Mark;
use super::optimum::saving;
use super::page::Page;
use super::sheet::{
    MARGIN_MM, NUMBER_MM, SMALL_MM, Sample, WIDTH_MM, draw_arrow, draw_scale_bar, figure, scale_denominator,
};
use super::svg::{Anchor, Path, Spot, Svg, spot};
use crate::planning::outcome::Drawing;

/// Where the time of a part goes.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TimeSplit {
    /// In cuts, in s.
    pub cutting_s: f64,
    /// Turning the blade.
    pub turning_s: f64,
    /// Moving without a cut.
    pub moving_s: f64,
}

/// A set of parameters and what it gives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SetFigures {
    /// h in mm.
    pub layer_spacing_mm: f64,
    /// s in mm.
    pub step_mm: f64,
    /// alpha in degrees.
    pub swing_angle_deg: f64,
    /// How far each layer is shifted against the next in mm: 0, or s/2 in the interlaced lattice.
    pub shift_mm: f64,
    /// delta in mm (Eq. 12).
    pub scallop_mm: f64,
    /// Its time.
    pub split: TimeSplit,
}

/// What is compared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Comparison {
    /// The set to compare with, if there is one.
    pub initial: Option<SetFigures>,
    /// The optimised set.
    pub optimised: SetFigures,
    /// The largest allowed delta in mm.
    pub max_scallop_mm: f64,
}

/// Size of the bar chart in mm of the sheet.
const BARS_MM: (f64, f64) = (118.0, 116.0);
/// Width of a bar.
const BAR_MM: f64 = 10.0;
/// Height of a section sketch.
const SKETCH_MM: f64 = 62.0;
/// Room at the foot of a sketch for the letter of a length.
const BELOW_SKETCH_MM: f64 = 6.0;

/// A set with its name and the classes of its bar and its ink.
struct Shown<'a> {
    name: &'static str,
    bar: &'static str,
    set: &'a SetFigures,
}

impl TimeSplit {
    /// The whole time in s.
    #[must_use]
    pub fn total_s(&self) -> f64 {
        self.cutting_s + self.turning_s + self.moving_s
    }

    fn parts(&self) -> [f64; 4] {
        [self.cutting_s, self.turning_s, self.moving_s, self.total_s()]
    }
}

/// Both sets side by side: `comparison.svg`.
#[must_use]
pub fn comparison(data: &Comparison) -> Drawing {
    let initial = data.initial.as_ref().map(|set| Shown { name: "initial set", bar: "bar-2", set });
    let optimised = Shown { name: "optimised set", bar: "bar-1", set: &data.optimised };
    let sets: Vec<Shown> = initial.into_iter().chain([optimised]).collect();
    let title = if sets.len() > 1 { "Initial and optimised set" } else { "Optimised set" };
    let mut page = Page::new(title, "", &lines(data, &sets));
    page.legend(&legend(&sets));
    let top = page.y + 2.0;
    let bars = draw_bars(&mut page.svg, &sets, top);
    let sketches = draw_sketches(&mut page.svg, &sets, top, data.max_scallop_mm);
    page.finish("comparison", bars.max(sketches))
}

fn lines(data: &Comparison, sets: &[Shown]) -> Vec<String> {
    let set = |shown: &Shown| {
        let set = shown.set;
        format!(
            "{}: layer spacing h {} mm, step s {} mm, swing angle α {}°.",
            capitalised(shown.name),
            figure(set.layer_spacing_mm, 3),
            figure(set.step_mm, 3),
            figure(set.swing_angle_deg, 3)
        )
    };
    let mut lines = vec![
        "Left: where the estimated time of the part goes. Right: what is left standing at worst above a level contour, seen along +y: x to the right, z up."
            .to_owned(),
        sets.iter().map(set).collect::<Vec<_>>().join(" "),
    ];
    if let Some(initial) = &data.initial {
        lines.push(saving(initial.split.total_s(), data.optimised.split.total_s()));
    }
    lines
}

fn capitalised(name: &str) -> String {
    let mut letters = name.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

fn legend(sets: &[Shown]) -> Vec<(Sample, String)> {
    let bars = sets.iter().map(|shown| (Sample::Area(shown.bar), format!("time of the {}", shown.name)));
    let sketch = [
        (Sample::Area("left-standing"), "left standing"),
        (Sample::Line("finished"), "finished contour"),
        (Sample::Line("arms"), "blade swung left and right"),
        (Sample::Disc("mark ink-1"), "tip of the blade"),
        (Sample::Mark(Mark::Ring, "ink-1"), "tip left out: at the contour"),
        (Sample::Line("curve stroke-4"), "scallop δ"),
    ];
    bars.chain(sketch.map(|(sample, words)| (sample, words.to_owned()))).collect()
}

/// Draws the bars and gives the y below them.
fn draw_bars(svg: &mut Svg, sets: &[Shown], top: f64) -> f64 {
    const NAMES: [&str; 4] = ["cutting", "turning", "moving", "whole time"];
    let times = sets.iter().flat_map(|shown| shown.set.split.parts()).chain([0.0]);
    let chart = Chart {
        corner: spot(MARGIN_MM + LEFT_MM, top + ABOVE_MM),
        x: Axis::between("", (0.0, NAMES.len() as f64), BARS_MM.0, Direction::Along),
        y: Axis::fitted("time in s", times, BARS_MM.1, Direction::Up),
    };
    svg.group("bars", "", |svg| {
        chart.draw_up(svg);
        for (group, name) in NAMES.into_iter().enumerate() {
            let middle = chart.spot(group as f64 + 0.5, chart.y.low);
            svg.text("small", spot(middle.x, middle.y + 1.4 + SMALL_MM), Anchor::Middle, name);
            for (index, shown) in sets.iter().enumerate() {
                let left = middle.x + (index as f64 - sets.len() as f64 / 2.0) * (BAR_MM + 1.0) + 0.5;
                draw_bar(svg, &chart, shown, left, shown.set.split.parts()[group]);
            }
        }
    });
    chart.bottom() + BELOW_MM
}

fn draw_bar(svg: &mut Svg, chart: &Chart, shown: &Shown, left: f64, time_s: f64) {
    if !is_shown(time_s) {
        return;
    }
    let (from, to) = (chart.spot(0.0, time_s.min(0.0)).y, chart.spot(0.0, time_s.max(0.0)).y);
    svg.rect(shown.bar, spot(left, to), BAR_MM, from - to);
    let middle = spot(left + BAR_MM / 2.0, to - 1.2);
    svg.text("number halo", middle, Anchor::Middle, &figure(time_s, 1));
}

/// Draws a section of each set at one common scale and gives the y below them.
fn draw_sketches(svg: &mut Svg, sets: &[Shown], top: f64, max_scallop_mm: f64) -> f64 {
    let left = MARGIN_MM + LEFT_MM + BARS_MM.0 + 14.0;
    let width = WIDTH_MM - MARGIN_MM - left;
    let drawable: Vec<&Shown> = sets.iter().filter(|shown| Sketch::can_show(shown.set)).collect();
    let fits = |shown: &&&Shown| {
        let (wide, high) = Sketch::extent(shown.set);
        (wide / width).max(high / (SKETCH_MM - SMALL_MM - 2.0 - BELOW_SKETCH_MM))
    };
    let scale = scale_denominator(drawable.iter().map(|shown| fits(&shown)).fold(0.0, f64::max));
    let mut y = top;
    for shown in &drawable {
        let words = format!(
            "{}: scallop δ {} mm, limit {} mm",
            capitalised(shown.name),
            figure(shown.set.scallop_mm, 3),
            figure(max_scallop_mm, 3)
        );
        svg.text("small head", spot(left, y + SMALL_MM), Anchor::Start, &words);
        let foot = y + SKETCH_MM - BELOW_SKETCH_MM - Sketch::BELOW * shown.set.layer_spacing_mm / scale;
        let sketch = Sketch { set: shown.set, scale, origin: spot(left + width / 2.0, foot) };
        svg.group("sketch", "", |svg| sketch.draw(svg));
        y += SKETCH_MM + 4.0;
    }
    if drawable.is_empty() {
        return y;
    }
    draw_scale_bar(svg, spot(left, y + 1.0), scale, "both sections");
    y + 2.0
}

/// A section through some grooves of the last layer above a level contour. The next layer's tips would lie at the
/// contour and are left out: the worst case of Eq. 12.
struct Sketch<'a> {
    set: &'a SetFigures,
    scale: f64,
    /// Where x = 0 of the contour is on the sheet.
    origin: Spot,
}

impl Sketch<'_> {
    /// The tips of the layer are at these multiples of s.
    const TIPS: [f64; 4] = [-1.5, -0.5, 0.5, 1.5];

    /// How high the arms are drawn, as a multiple of the ridges: out to the air beyond the chips.
    const UP: f64 = 1.25;
    /// How far the sketch goes below the contour, as a share of h.
    const BELOW: f64 = 0.45;

    fn can_show(set: &SetFigures) -> bool {
        let lengths = [set.layer_spacing_mm, set.step_mm, set.slope(), set.ridge_mm()];
        lengths.into_iter().all(|length| is_shown(length) && length > 0.0) && is_shown(set.shift_mm)
    }

    /// Width and height in mm of the part.
    fn extent(set: &SetFigures) -> (f64, f64) {
        (4.6 * set.step_mm, (1.0 + Self::BELOW) * set.layer_spacing_mm + Self::UP * set.ridge_mm())
    }

    fn at(&self, x: f64, z: f64) -> Spot {
        spot(self.origin.x + x / self.scale, self.origin.y - z / self.scale)
    }

    fn draw(&self, svg: &mut Svg) {
        let (h, s) = (self.set.layer_spacing_mm, self.set.step_mm);
        let ridge = h + self.set.ridge_mm();
        let mut left_standing = Path::default();
        let surface =
            [(-2.0, ridge), (-1.5, h), (-1.0, ridge), (-0.5, h), (0.0, ridge), (0.5, h), (1.0, ridge)];
        let surface = surface.into_iter().chain([(1.5, h), (2.0, ridge)]);
        let outline = surface.chain([(2.0, 0.0), (-2.0, 0.0)]);
        left_standing.closed(outline.map(|(x, z)| self.at(x * s, z)));
        svg.area("left-standing", &left_standing, "");
        let half = 2.0 * s;
        svg.rect("solid-part", self.at(-half, 0.0), 2.0 * half / self.scale, 0.3 * h / self.scale);
        svg.line("finished", self.at(-half, 0.0), self.at(half, 0.0));
        self.draw_arms(svg);
        self.draw_scallop(svg, ridge);
        self.draw_lengths(svg);
    }

    /// The arms a little beyond the ridges, where they come out of the chips.
    fn draw_arms(&self, svg: &mut Svg) {
        let (h, s) = (self.set.layer_spacing_mm, self.set.step_mm);
        let up = Self::UP * self.set.ridge_mm();
        let out = up * self.set.slope();
        let mut arms = Path::default();
        for tip in Self::TIPS {
            arms.open([self.at(tip * s - out, h + up), self.at(tip * s, h), self.at(tip * s + out, h + up)]);
        }
        svg.path("arms", &arms, "");
        for tip in Self::TIPS {
            Mark::Disc.draw(svg, "ink-1", self.at(tip * s, h));
            let next = tip * s + self.set.shift_mm;
            if next.abs() <= 2.0 * s {
                Mark::Ring.draw(svg, "ink-1", self.at(next, 0.0));
            }
        }
    }

    /// From the ridge in the middle to the nearest tip that is left out.
    fn draw_scallop(&self, svg: &mut Svg, ridge: f64) {
        let feet = Self::TIPS.map(|tip| tip * self.set.step_mm + self.set.shift_mm);
        let foot =
            feet.into_iter().min_by(|one, other| one.abs().total_cmp(&other.abs())).unwrap_or_default();
        let (from, to) = (self.at(0.0, ridge), self.at(foot, 0.0));
        svg.line("curve stroke-4", from, to);
        let middle = spot(f64::midpoint(from.x, to.x) + 1.5, f64::midpoint(from.y, to.y) + 0.8);
        svg.text("small head halo ink-4", middle, Anchor::Start, "δ");
    }

    /// h at the left, s below, alpha at a tip at the right.
    fn draw_lengths(&self, svg: &mut Svg) {
        let (h, s) = (self.set.layer_spacing_mm, self.set.step_mm);
        let x = -2.12 * s;
        self.draw_length(svg, (self.at(x, 0.0), self.at(x, h)));
        let beside = self.at(x, h / 2.0);
        svg.text("small", spot(beside.x - 1.2, beside.y + 0.9), Anchor::End, "h");
        let z = -Self::BELOW * h;
        self.draw_length(svg, (self.at(-1.5 * s, z), self.at(-0.5 * s, z)));
        let below = self.at(-s, z);
        svg.text("small", spot(below.x, below.y + 1.0 + SMALL_MM), Anchor::Middle, "s");
        let (tip, up) = (1.5 * s, 0.9 * self.set.ridge_mm());
        svg.line("iso", self.at(tip, h), self.at(tip, h + up));
        let angle = self.at(tip + 0.3 * up * self.set.slope(), h + up);
        svg.text("small halo", spot(angle.x, angle.y + NUMBER_MM), Anchor::Middle, "α");
    }

    fn draw_length(&self, svg: &mut Svg, (from, to): (Spot, Spot)) {
        let middle = spot(f64::midpoint(from.x, to.x), f64::midpoint(from.y, to.y));
        draw_arrow(svg, middle, from);
        draw_arrow(svg, middle, to);
    }
}

impl SetFigures {
    /// tan(alpha).
    fn slope(&self) -> f64 {
        self.swing_angle_deg.to_radians().tan()
    }

    /// How far the ridges of a layer rise above its tips, in mm: (1 - epsilon) h, by Eq. 7.
    fn ridge_mm(&self) -> f64 {
        self.step_mm / (2.0 * self.slope())
    }
}
