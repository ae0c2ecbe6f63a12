//! The published model's time over layer spacing and swing angle, with the limits and the optimum.

use std::collections::BTreeMap;

use super::axis::{Axis, Direction, is_shown, range};
use super::bands::{Block, Class, blocks, levels};
use super::chart::{ABOVE_MM, BELOW_MM, Chart, LEFT_MM};
use super::label::{Labels, baseline};
use super::mark::{MARK_MM, Mark};
use super::page::Page;
use super::sheet::{MARGIN_MM, NUMBER_MM, SMALL_MM, Sample, figure, text_width};
use super::svg::{Anchor, Path, Spot, Svg, spot};
use crate::planning::geometry::Point2;
use crate::planning::outcome::Drawing;

/// Size of the map in mm of the sheet.
const SIZE_MM: (f64, f64) = (212.0, 112.0);

/// The number of shades that the style sheet has.
const SHADES: usize = 10;

/// A limit of the published model (domain.md B2).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Limit {
    /// The cut would need more of the edge than may cut.
    CuttingLength,
    /// What is left standing would be too high.
    Scallop,
    /// The blade would be swung too far.
    SwingAngle,
    /// There would be less than one layer.
    Layers,
    /// There would be less than one point in a layer.
    Points,
}

/// What the model says at a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Cell {
    /// The time in s, with the step that takes least time there.
    Time(f64),
    /// Why there is none.
    Excluded(Limit),
}

/// What the model says along one swing angle.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// alpha in degrees.
    pub swing_angle_deg: f64,
    /// h in mm, rising, and what holds there. They may differ from row to row.
    pub cells: Vec<(f64, Cell)>,
}

/// A set of parameters and its time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParameterSet {
    /// h in mm.
    pub layer_spacing_mm: f64,
    /// s in mm.
    pub step_mm: f64,
    /// alpha in degrees.
    pub swing_angle_deg: f64,
    /// Its estimated time in s.
    pub time_s: f64,
}

/// What the map shows.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct OptimumMap {
    /// The grid; see [`sampled`].
    pub rows: Vec<Row>,
    /// The optimum, if there is one.
    pub optimum: Option<ParameterSet>,
    /// The set to compare with, if there is one.
    pub initial: Option<ParameterSet>,
}

/// A grid over h in mm and alpha in degrees, from `at`, with a few thousand places: 30 in each of 160 rows, and
/// between two of them where a limit begins to a thousandth of their distance.
#[must_use]
pub fn sampled(h: (f64, f64), alpha: (f64, f64), at: impl Fn(f64, f64) -> Cell) -> Vec<Row> {
    const ROWS: usize = 160;
    const COLUMNS: usize = 30;
    let row = |index: usize| {
        let swing_angle_deg = alpha.0 + (alpha.1 - alpha.0) * (index as f64 + 0.5) / ROWS as f64;
        let cell = |h: f64| (h, at(h, swing_angle_deg));
        let place = |column: usize| h.0 + (h.1 - h.0) * column as f64 / COLUMNS as f64;
        let mut cells = vec![cell(h.0)];
        for column in 1..=COLUMNS {
            let (from, to) = (cells[cells.len() - 1], cell(place(column)));
            if !from.1.is_alike(to.1) {
                cells.extend(border(from, to, cell));
            }
            cells.push(to);
        }
        Row { swing_angle_deg, cells }
    };
    (0..ROWS).map(row).collect()
}

/// Two places close together, with a border between them, if there is just one between `from` and `to`.
fn border(mut from: (f64, Cell), mut to: (f64, Cell), cell: impl Fn(f64) -> (f64, Cell)) -> [(f64, Cell); 2] {
    const HALVINGS: usize = 10;
    for _ in 0..HALVINGS {
        let middle = cell(f64::midpoint(from.0, to.0));
        if middle.1.is_alike(from.1) {
            from = middle;
        } else {
            to = middle;
        }
    }
    [from, to]
}

impl Cell {
    /// The time, if there is one.
    #[must_use]
    pub fn time(self) -> Option<f64> {
        match self {
            Self::Time(time) => Some(time),
            Self::Excluded(_) => None,
        }
    }

    /// Whether it says anything that can be drawn.
    #[must_use]
    pub fn is_known(self) -> bool {
        self.time().is_none_or(is_shown)
    }

    fn is_alike(self, other: Self) -> bool {
        match (self, other) {
            (Self::Time(_), Self::Time(_)) => true,
            (one, other) => one == other,
        }
    }
}

impl Limit {
    const ALL: [Self; 5] = [Self::CuttingLength, Self::Scallop, Self::SwingAngle, Self::Layers, Self::Points];

    /// Its name on the map.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::CuttingLength => "cutting length",
            Self::Scallop => "scallop",
            Self::SwingAngle => "swing angle",
            Self::Layers => "layers",
            Self::Points => "points",
        }
    }

    fn words(self) -> &'static str {
        match self {
            Self::CuttingLength => "cutting length: the edge that may cut is too short (Eq. 4)",
            Self::Scallop => "scallop: too much would be left standing (Eq. 12)",
            Self::SwingAngle => "swing angle: beyond the largest",
            Self::Layers => "layers: less than one",
            Self::Points => "points: less than one in a layer",
        }
    }

    fn hatching(self) -> String {
        format!("optimum-{}", self.name().replace(' ', "-"))
    }

    /// Hatchings differ in their direction: they must be told apart without colour.
    fn lines(self) -> &'static str {
        match self {
            Self::CuttingLength => "M-.5 .5L.5 -.5M0 2L2 0M1.5 2.5L2.5 1.5",
            Self::Scallop => "M-.5 1.5L.5 2.5M0 0L2 2M1.5 -.5L2.5 .5",
            Self::SwingAngle => "M0 1L2 1",
            Self::Layers => "M1 0L1 2",
            Self::Points => "M0 1L2 1M1 0L1 2",
        }
    }
}

/// The map of time over layer spacing and swing angle: `optimum.svg`.
#[must_use]
pub fn map(data: &OptimumMap) -> Drawing {
    let levels = levels(&data.rows, data.initial.map(|set| set.time_s));
    let blocks = blocks(&data.rows, &levels);
    let mut page = Page::new("Time over layer spacing and swing angle", "", &lines(data, &blocks));
    page.legend(&legend(data, &blocks));
    let h = data.rows.iter().flat_map(|row| row.cells.iter().map(|(h, _)| *h));
    let alpha = blocks.iter().flat_map(|block| [block.range.0, block.range.1]);
    let chart = Chart {
        corner: spot(MARGIN_MM + LEFT_MM, page.y + ABOVE_MM),
        x: Axis::between("layer spacing h in mm", range(h), SIZE_MM.0, Direction::Along),
        y: Axis::between("swing angle α in °", range(alpha), SIZE_MM.1, Direction::Up),
    };
    chart.draw_axes(&mut page.svg);
    draw_areas(&mut page.svg, &chart, &blocks, levels.len());
    let mut labels = Labels::default();
    draw_sets(&mut page.svg, &chart, data, &mut labels);
    draw_names(&mut page.svg, &chart, &blocks, &mut labels);
    draw_levels(&mut page.svg, &chart, &blocks, &levels, &mut labels);
    if has_times(&blocks) {
        draw_scale(&mut page.svg, &chart, &levels);
    }
    page.finish("optimum", chart.bottom() + BELOW_MM)
}

fn lines(data: &OptimumMap, blocks: &[Block]) -> Vec<String> {
    let mut lines = vec![
        "Estimated time of the part (Eq. 11) over layer spacing h and swing angle α, with the step s that takes least time. Hatched: not allowed."
            .to_owned(),
    ];
    if blocks.is_empty() {
        lines.push("There is nothing to show: no place has a time or a limit.".to_owned());
    } else if !has_times(blocks) {
        lines.push("No layer spacing and swing angle shown here is within all limits.".to_owned());
    }
    let set = |name: &str, set: ParameterSet| {
        format!(
            "{name}: h {} mm, s {} mm, α {}°, time {} s.",
            figure(set.layer_spacing_mm, 3),
            figure(set.step_mm, 3),
            figure(set.swing_angle_deg, 3),
            figure(set.time_s, 3)
        )
    };
    let sets = [("Optimum", data.optimum), ("Initial set", data.initial)];
    let words: Vec<String> = sets.into_iter().filter_map(|(name, of)| of.map(|of| set(name, of))).collect();
    if !words.is_empty() {
        lines.push(words.join(" "));
    }
    if let (Some(optimum), Some(initial)) = (data.optimum, data.initial) {
        lines.push(saving(initial.time_s, optimum.time_s));
    }
    lines
}

fn has_times(blocks: &[Block]) -> bool {
    blocks.iter().flat_map(|block| &block.classes).any(|class| matches!(class, Class::Band(_)))
}

/// How much less time one set takes than another, in words.
#[must_use]
pub fn saving(initial_s: f64, optimum_s: f64) -> String {
    let share = 100.0 * (1.0 - optimum_s / initial_s);
    let word = if share < 0.0 { "more" } else { "less" };
    format!("The optimum takes {} % {word} time than the initial set.", figure(share.abs(), 2))
}

fn legend(data: &OptimumMap, blocks: &[Block]) -> Vec<(Sample, String)> {
    let mut legend = Vec::new();
    if data.optimum.is_some() {
        legend.push((Sample::Mark(Mark::Diamond, "ink-2"), "optimum".to_owned()));
    }
    if data.initial.is_some() {
        legend.push((Sample::Mark(Mark::Ring, "ink-2"), "initial set".to_owned()));
    }
    if !blocks.is_empty() {
        legend.push((Sample::Line("limit"), "limit".to_owned()));
    }
    for limit in Limit::ALL {
        if blocks.iter().any(|block| block.classes.contains(&Class::Excluded(limit))) {
            legend.push((Sample::Hatched(limit.hatching()), limit.words().to_owned()));
        }
    }
    legend
}

fn draw_areas(svg: &mut Svg, chart: &Chart, blocks: &[Block], levels: usize) {
    for limit in Limit::ALL {
        svg.pattern(&limit.hatching(), limit.lines());
    }
    // One path a class: where two areas of a class meet there is no seam.
    let mut areas: BTreeMap<Class, Path> = BTreeMap::new();
    for block in blocks {
        for (index, class) in block.classes.iter().enumerate() {
            chart.add_area(areas.entry(*class).or_default(), &block.outline(index));
        }
    }
    for (class, path) in &areas {
        match class {
            Class::Band(band) => svg.path(&format!("area {}", shade(*band, levels)), path, ""),
            Class::Excluded(limit) => svg.hatched_area(&limit.hatching(), path, limit.words()),
        }
    }
    let mut lines = [Path::default(), Path::default()];
    for (border, classes) in borders(blocks) {
        chart.add_curve(&mut lines[usize::from(is_limit(classes))], &border);
    }
    svg.path("iso", &lines[0], "");
    svg.path("limit", &lines[1], "");
}

fn is_limit(classes: [Class; 2]) -> bool {
    classes.iter().any(|class| matches!(class, Class::Excluded(_)))
}

/// All borders between two classes, with these.
fn borders(blocks: &[Block]) -> Vec<(Vec<Point2>, [Class; 2])> {
    let mut found = Vec::new();
    for block in blocks {
        let pairs = block.classes.windows(2).enumerate();
        found.extend(pairs.map(|(index, pair)| (block.border(index + 1), [pair[0], pair[1]])));
    }
    for pair in blocks.windows(2) {
        let edges = pair[0].edges(&pair[1]).into_iter();
        found.extend(edges.map(|((from, to), classes)| {
            (vec![Point2::new(from, pair[1].range.0), Point2::new(to, pair[1].range.0)], classes)
        }));
    }
    found
}

/// The shade of a band: the fastest stands out most, the slowest least.
fn shade(band: usize, levels: usize) -> String {
    let index = (band * (SHADES - 1)).checked_div(levels).unwrap_or(0);
    format!("band-{index}")
}

/// The times of the lines between bands.
fn draw_levels(svg: &mut Svg, chart: &Chart, blocks: &[Block], levels: &[f64], labels: &mut Labels) {
    let mut longest: BTreeMap<usize, Vec<Point2>> = BTreeMap::new();
    for (border, classes) in borders(blocks) {
        let [Class::Band(one), Class::Band(other)] = classes else { continue };
        let known = longest.entry(one.min(other)).or_default();
        if border.len() > known.len() {
            *known = border;
        }
    }
    for (level, border) in longest {
        let words = figure(levels[level], 3);
        let (width, height) = (text_width(&words, NUMBER_MM) + 1.5, NUMBER_MM + 0.8);
        let along = [4, 5, 3, 6, 2, 7, 1].map(|eighth| border[eighth * (border.len() - 1) / 8]);
        let places = along.map(|point| chart.spot(point.x, point.y));
        if let Some(place) = labels.place(&places, width, height) {
            svg.text("number halo", baseline(place, NUMBER_MM), Anchor::Middle, &words);
        }
    }
}

fn draw_sets(svg: &mut Svg, chart: &Chart, data: &OptimumMap, labels: &mut Labels) {
    let sets = [("initial set", data.initial, Mark::Ring), ("optimum", data.optimum, Mark::Diamond)];
    let shown = sets.into_iter().filter_map(|(name, set, mark)| {
        let set = set?;
        let place = Point2::new(set.layer_spacing_mm, set.swing_angle_deg);
        Some((name, set, chart.draw_mark(svg, mark, "ink-2", &place)?))
    });
    let shown: Vec<_> = shown.collect();
    for (_, _, at) in &shown {
        labels.take(*at, 1.2 * MARK_MM);
    }
    for (name, set, at) in shown {
        let words = format!("{name} {} s", figure(set.time_s, 1));
        let (width, height) = (text_width(&words, SMALL_MM), SMALL_MM + 1.2);
        let (aside, above) = (width / 2.0 + MARK_MM + 1.0, height / 2.0 + MARK_MM + 0.5);
        let places = [(-aside, 0.0), (aside, 0.0), (0.0, -above), (0.0, above)];
        let inside = |x: f64| {
            let low = chart.corner.x + width / 2.0 + 1.0;
            x.clamp(low, (chart.right() - width / 2.0 - 1.0).max(low))
        };
        let places = places.map(|(dx, dy)| spot(at.x + dx, at.y + dy));
        let places = places.map(|place| if place.x == at.x { spot(inside(at.x), place.y) } else { place });
        let fits = |place: &Spot| inside(place.x) == place.x;
        let places: Vec<_> = places.into_iter().filter(fits).collect();
        if let Some(place) = labels.place(&places, width, height) {
            svg.text("small head halo", baseline(place, SMALL_MM), Anchor::Middle, &words);
        }
    }
}

/// The name of each limit in the largest part of what it excludes.
fn draw_names(svg: &mut Svg, chart: &Chart, blocks: &[Block], labels: &mut Labels) {
    for limit in Limit::ALL {
        let name = limit.name();
        let width = text_width(name, SMALL_MM);
        let mut places: Vec<(f64, Point2)> = Vec::new();
        for block in blocks {
            let height = chart.y.place(block.range.1) - chart.y.place(block.range.0);
            let excluded = block.classes.iter().enumerate().filter(|(_, c)| **c == Class::Excluded(limit));
            for (index, _) in excluded {
                let (middle, h) = block.middle(index);
                let room = chart.x.place(chart.x.low + h) / width;
                places.push((room.min(height / SMALL_MM), middle));
            }
        }
        places.sort_by(|one, other| other.0.total_cmp(&one.0));
        let spots: Vec<_> = places.iter().map(|(_, middle)| chart.spot(middle.x, middle.y)).collect();
        if let Some(place) = labels.place(&spots, width, SMALL_MM) {
            svg.text("small head halo", baseline(place, SMALL_MM), Anchor::Middle, name);
        }
    }
}

/// The bands as a column with their times, slowest at the top, as on the map where h is small.
fn draw_scale(svg: &mut Svg, chart: &Chart, levels: &[f64]) {
    const WIDTH_MM: f64 = 7.0;
    const BAND_MM: f64 = 7.0;
    let x = chart.right() + 9.0;
    let bands = levels.len() + 1;
    svg.text("small", spot(x, chart.corner.y - 1.6), Anchor::Start, "time in s");
    for band in 0..bands {
        let y = chart.corner.y + (bands - 1 - band) as f64 * BAND_MM;
        svg.rect(&shade(band, levels.len()), spot(x, y), WIDTH_MM, BAND_MM);
        if band > 0 {
            let words = figure(levels[band - 1], 3);
            svg.text("number", spot(x + WIDTH_MM + 1.5, y + BAND_MM + 0.8), Anchor::Start, &words);
        }
    }
    svg.rect("frame", spot(x, chart.corner.y), WIDTH_MM, bands as f64 * BAND_MM);
}
