//! The section of a part: its blank, its finished contour, the tips of the blade with both arms, and what remains.

use super::axis::{Axis, Direction, is_shown, range};
use super::chart::{ABOVE_MM, BELOW_MM, Chart, LEFT_MM, is_place};
use super::label::{Labels, baseline};
use super::mark::Mark;
use super::page::Page;
use super::sheet::{
    INNER_MM, MARGIN_MM, SMALL_MM, Sample, WIDTH_MM, draw_scale_bar, figure, scale_denominator, scale_text,
    text_width,
};
use super::svg::{Anchor, Path, Spot, Svg, spot};
use super::thin::{self, clipped, places, segments};
use crate::planning::geometry::Point2;
use crate::planning::outcome::Drawing;

/// What a section shows. All lengths in mm; points are (x, z), x across the part, z up from the blank's foot.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Section {
    /// Whose plan it is, in words of ours: `ours`, `published, orthogonal lattice`.
    pub plan: &'static str,
    /// Width and height of the blank.
    pub blank: (f64, f64),
    /// The finished contour from x = 0 to the blank's width.
    pub contour: Vec<Point2>,
    /// The surface that remains when all that comes free is gone.
    pub surface: Vec<Vec<Point2>>,
    /// The tips, each cut with the blade swung to either side.
    pub tips: Vec<Point2>,
    /// alpha in degrees.
    pub swing_angle_deg: f64,
    /// d: how far the cutting edge reaches from the tip.
    pub reach_mm: f64,
    /// Outlines of chips that stay.
    pub stuck: Vec<Vec<Point2>>,
    /// Where the blade enters the part: outlines, or single points.
    pub gouges: Vec<Vec<Point2>>,
    /// The largest scallop.
    pub scallop: Option<Scallop>,
    /// The largest that is allowed.
    pub max_scallop_mm: Option<f64>,
}

/// The place of a scallop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scallop {
    /// The point of the remaining surface.
    pub ridge: Point2,
    /// The nearest point of the finished contour.
    pub foot: Point2,
}

/// The largest size of the section on the sheet, in mm.
const LARGEST_MM: (f64, f64) = (INNER_MM - LEFT_MM - 2.0, 138.0);
/// The most tips that are drawn; where there are more, those that nearly coincide on the sheet are one.
const MOST_TIPS: usize = 4000;
/// The most segments of the surface that are drawn.
const MOST_SEGMENTS: usize = 8000;
/// A part of the surface that is narrower than this on the sheet has no area of its own.
const NARROW_MM: f64 = 0.1;
/// A scallop that is shorter than this on the sheet is shown once more, enlarged.
const READABLE_MM: f64 = 6.0;
/// Size of that detail; beside the whole section it may be as narrow as it is high.
const DETAIL_MM: (f64, f64) = (110.0, 50.0);
/// The largest height of the whole section above a detail.
const SMALLER_MM: f64 = 74.0;
/// What is smaller than this on the sheet has a mark beside it.
const VISIBLE_MM: f64 = 2.0;

impl Scallop {
    /// Its height in mm.
    #[must_use]
    pub fn height_mm(&self) -> f64 {
        (self.ridge - self.foot).norm()
    }
}

/// The section as it will be cut; `name` is the file's name without `.svg`.
#[must_use]
pub fn section(data: &Section, name: &str) -> Drawing {
    let mut page = Page::new(
        &format!("Section: {}", if data.plan.is_empty() { "cuts and what remains" } else { data.plan }),
        "SEEN ALONG +y, from the end at y = 0: x to the right, z up. The cut to the left is fed away from you, the cut to the right toward you.",
        &lines(data),
    );
    page.legend(&legend(data));
    let layout = Layout::new(data, page.y + ABOVE_MM + 1.0);
    let Layout { chart, denominator, detail } = &layout;
    chart.draw_axes(&mut page.svg);
    let drawn = draw(&mut page.svg, chart, data);
    let y = chart.bottom() + BELOW_MM + 2.0;
    let x = draw_scale_bar(&mut page.svg, spot(MARGIN_MM, y), *denominator, "scale");
    if drawn < data.tips.len() {
        let words = format!(
            "{drawn} of {} tips are drawn: the others lie so close to these that they would not be seen apart.",
            data.tips.len()
        );
        page.svg.text("small", spot(x + 8.0, y + 0.9), Anchor::Start, &words);
    }
    let end = detail.as_ref().map_or(y, |detail| draw_detail(&mut page.svg, data, detail));
    page.finish(name, end.max(y) + 1.0)
}

fn lines(data: &Section) -> Vec<String> {
    let chips = match data.stuck.len() {
        0 => "No chip stays in place.".to_owned(),
        1 => "1 chip stays in place.".to_owned(),
        count => format!("{count} chips stay in place."),
    };
    let gouges = match data.gouges.len() {
        0 => "The finished part is not cut into.".to_owned(),
        1 => "The finished part is cut into at 1 place.".to_owned(),
        count => format!("The finished part is cut into at {count} places."),
    };
    let limit = data.max_scallop_mm.map_or_else(String::new, |mm| format!(" (limit {} mm)", figure(mm, 3)));
    let scallop = data.scallop.map_or_else(
        || "No scallop was measured.".to_owned(),
        |scallop| {
            format!(
                "Largest scallop {} mm{limit}, at x {} mm.",
                figure(scallop.height_mm(), 3),
                figure(scallop.ridge.x, 2)
            )
        },
    );
    vec![
        format!(
            "Blank {} x {} mm. {} tips, each cut with the blade swung to the left and to the right by α {}°; the cutting edge reaches d {} mm.",
            figure(data.blank.0, 3),
            figure(data.blank.1, 3),
            data.tips.len(),
            figure(data.swing_angle_deg, 3),
            figure(data.reach_mm, 3)
        ),
        format!("{scallop} {chips} {gouges}"),
    ]
}

fn legend(data: &Section) -> Vec<(Sample, String)> {
    let mut legend = vec![
        (Sample::Line("blank-edge"), "blank"),
        (Sample::Area("solid-part"), "finished part"),
        (Sample::Line("finished"), "finished contour"),
        (Sample::Area("left-standing"), "left standing"),
        (Sample::Line("curve stroke-2"), "surface that remains"),
        (Sample::Disc("mark ink-1"), "tip"),
        (Sample::Line("arms"), "cutting edge swung left and right"),
    ];
    if data.scallop.is_some() {
        legend.push((Sample::Line("curve stroke-4"), "largest scallop"));
    }
    if !data.stuck.is_empty() {
        legend.push((Sample::Area("stays"), "chip that stays"));
    }
    if !data.gouges.is_empty() {
        legend.push((Sample::Mark(Mark::Cross, "ink-4"), "cut into the finished part"));
    }
    legend.into_iter().map(|(sample, words)| (sample, words.to_owned())).collect()
}

/// What stands where on the sheet.
struct Layout {
    chart: Chart,
    /// Scale denominator of the chart.
    denominator: f64,
    /// The largest scallop once more, where it could not be seen.
    detail: Option<Detail>,
}

/// The surroundings of the largest scallop, enlarged.
struct Detail {
    scallop: Scallop,
    /// Upper left corner, without the room for words and numbers.
    corner: Spot,
    /// Width and height in mm of the sheet.
    size: (f64, f64),
}

impl Layout {
    /// The detail stands beside the whole section if there is room, and else below it.
    fn new(data: &Section, y: f64) -> Self {
        let (chart, denominator) = whole(data, y, LARGEST_MM.1);
        let is_hidden = |scallop: &Scallop| {
            let shown = is_place(&scallop.ridge) && is_place(&scallop.foot);
            shown && scallop.height_mm() > 0.0 && scallop.height_mm() / denominator < READABLE_MM
        };
        let Some(scallop) = data.scallop.filter(is_hidden) else {
            return Self { chart, denominator, detail: None };
        };
        let corner = spot(chart.right() + 6.0 + LEFT_MM, y);
        let room = WIDTH_MM - MARGIN_MM - corner.x;
        if room >= DETAIL_MM.1 {
            let size = (room.min(DETAIL_MM.0), DETAIL_MM.1);
            return Self { chart, denominator, detail: Some(Detail { scallop, corner, size }) };
        }
        let (chart, denominator) = whole(data, y, SMALLER_MM);
        let below = chart.bottom() + BELOW_MM + 7.0 + SMALL_MM + 2.0 + ABOVE_MM;
        let corner = spot(MARGIN_MM + LEFT_MM, below);
        Self { chart, denominator, detail: Some(Detail { scallop, corner, size: DETAIL_MM }) }
    }
}

/// The chart of the whole section, no higher than that, with equal scales along and up, and its scale denominator.
fn whole(data: &Section, y: f64, highest_mm: f64) -> (Chart, f64) {
    /// Room for arms that come out of the blank, as a share of its size.
    const AIR: f64 = 0.06;
    /// Below this the axes would have no room for their numbers.
    const LEAST_MM: f64 = 15.0;
    let extent = |own: f64, all: &mut dyn Iterator<Item = f64>| range(all.chain([0.0, own]));
    let x = extent(data.blank.0, &mut data.contour.iter().map(|point| point.x));
    let z = extent(data.blank.1, &mut data.contour.iter().map(|point| point.y));
    let size = (x.1 - x.0).max(z.1 - z.0);
    let air = AIR * if size > 0.0 { size } else { 1.0 };
    let (x, z) = ((x.0 - air, x.1 + air), (z.0, z.1 + air));
    let needed = ((x.1 - x.0) / LARGEST_MM.0).max((z.1 - z.0) / highest_mm);
    let denominator = scale_denominator(needed);
    let [x, z] = [x, z].map(|range| at_least(range, LEAST_MM * denominator));
    (chart(x, z, denominator, spot(MARGIN_MM + LEFT_MM, y)), denominator)
}

fn at_least((low, high): (f64, f64), size: f64) -> (f64, f64) {
    (low, high.max(low + size))
}

fn chart(x: (f64, f64), z: (f64, f64), denominator: f64, corner: Spot) -> Chart {
    let length = |range: (f64, f64)| (range.1 - range.0) / denominator;
    Chart {
        corner,
        x: Axis::between("x in mm", x, length(x), Direction::Along),
        y: Axis::between("z in mm", z, length(z), Direction::Up),
    }
}

/// Draws everything between the axes of a chart and gives the number of tips that could be drawn apart.
fn draw(svg: &mut Svg, chart: &Chart, data: &Section) -> usize {
    draw_materials(svg, chart, data);
    let drawn = draw_tips(svg, chart, data);
    svg.path("blank-edge", &blank(chart, data), "blank");
    chart.draw_curve(svg, "finished", &data.contour, "finished contour");
    draw_surface(svg, chart, data);
    draw_faults(svg, chart, data);
    if let Some(scallop) = &data.scallop {
        draw_scallop(svg, chart, scallop);
    }
    drawn
}

fn draw_surface(svg: &mut Svg, chart: &Chart, data: &Section) {
    let parts: Vec<Vec<Spot>> = data.surface.iter().flat_map(|line| chart.parts(line)).collect();
    let few = segments(&parts) <= MOST_SEGMENTS;
    let mut path = Path::default();
    for part in if few { parts } else { thin::lines(&parts, MOST_SEGMENTS).lines } {
        path.open(part);
    }
    svg.path("curve stroke-2", &path, "surface that remains");
}

fn blank(chart: &Chart, data: &Section) -> Path {
    let (width, height) = data.blank;
    let mut path = Path::default();
    let corners = [(0.0, 0.0), (0.0, height), (width, height), (width, 0.0), (0.0, 0.0)];
    chart.add_curve(&mut path, &corners.map(|(x, z)| Point2::new(x, z)));
    path
}

/// The part below its contour, and what is left standing on it.
fn draw_materials(svg: &mut Svg, chart: &Chart, data: &Section) {
    let (Some(first), Some(last)) = (data.contour.first(), data.contour.last()) else { return };
    let mut part = Path::default();
    let foot = [Point2::new(last.x, 0.0), Point2::new(first.x, 0.0)];
    chart.add_area(&mut part, &data.contour.iter().copied().chain(foot).collect::<Vec<_>>());
    svg.area("solid-part", &part, "finished part");
    let mut standing = Path::default();
    for line in &data.surface {
        let x = range(line.iter().map(|point| point.x));
        if chart.x.place(x.1) - chart.x.place(x.0) > NARROW_MM {
            chart.add_area(&mut standing, &down_to(line, &data.contour));
        }
    }
    svg.area("left-standing", &standing, "left standing");
}

/// The outline between a part of the surface and the contour below it.
fn down_to(line: &[Point2], contour: &[Point2]) -> Vec<Point2> {
    let x = range(line.iter().map(|point| point.x));
    let below = contour.iter().filter(|point| point.x > x.0 && point.x < x.1);
    let ends = [x.0, x.1].map(|x| Point2::new(x, height_at(contour, x)));
    let mut below: Vec<Point2> = [ends[0]].into_iter().chain(below.copied()).chain([ends[1]]).collect();
    let rising = line.first().zip(line.last()).is_some_and(|(first, last)| first.x <= last.x);
    if rising {
        below.reverse();
    }
    line.iter().copied().chain(below).collect()
}

/// z of a contour at x; that of its nearer end beyond it.
fn height_at(contour: &[Point2], x: f64) -> f64 {
    let after = contour.partition_point(|point| point.x < x).min(contour.len() - 1);
    let (from, to) = (contour[after.saturating_sub(1)], contour[after]);
    let width = to.x - from.x;
    let share = if width > 0.0 { ((x - from.x) / width).clamp(0.0, 1.0) } else { 1.0 };
    from.y + share * (to.y - from.y)
}

/// Draws tips and arms, each kind in one path.
fn draw_tips(svg: &mut Svg, chart: &Chart, data: &Section) -> usize {
    let (across, up) = data.swing_angle_deg.to_radians().sin_cos();
    let reach = if is_shown(data.reach_mm) && is_shown(across) { data.reach_mm } else { 0.0 };
    // An arm may reach into a chart that its tip is outside of.
    let reached = |tip: &&Point2| {
        is_place(tip)
            && tip.x + reach >= chart.x.low
            && tip.x - reach <= chart.x.high
            && tip.y + reach >= chart.y.low
            && tip.y <= chart.y.high
    };
    let tips: Vec<Point2> = data.tips.iter().filter(reached).copied().collect();
    let spots: Vec<Spot> = tips.iter().map(|tip| chart.spot(tip.x, tip.y)).collect();
    let (chosen, _) = places(&spots, MOST_TIPS);
    let (mut arms, mut discs) = (Path::default(), Path::default());
    for &index in &chosen {
        for side in [-1.0, 1.0] {
            let end = tips[index] + reach * nalgebra::Vector2::new(side * across, up);
            let arm = (spots[index], chart.spot(end.x, end.y));
            if let Some((from, to)) = clipped(arm, chart.corner, chart.far_corner()) {
                arms.open([from, to]);
            }
        }
        if chart.shows(&tips[index]) {
            discs.open([spots[index], spots[index]]);
        }
    }
    svg.path("arms", &arms, "");
    svg.path("tips", &discs, "");
    chosen.len() + data.tips.len() - tips.len()
}

/// Draws what should not be, with marks where it would not be seen.
fn draw_faults(svg: &mut Svg, chart: &Chart, data: &Section) {
    let kinds = [
        (&data.stuck, "stays", "chip that stays", Mark::Diamond, "ink-3"),
        (&data.gouges, "gouge", "cut into the finished part", Mark::Cross, "ink-4"),
    ];
    for (outlines, class, title, mark, ink) in kinds {
        let mut areas = Path::default();
        let mut middles = Vec::new();
        for outline in outlines {
            match middle_of_small(chart, outline) {
                Some(middle) if chart.shows(&middle) => middles.push(middle),
                Some(_) => {}
                None => chart.add_area(&mut areas, outline),
            }
        }
        svg.area(class, &areas, title);
        let spots: Vec<Spot> = middles.iter().map(|middle| chart.spot(middle.x, middle.y)).collect();
        for index in places(&spots, MOST_TIPS).0 {
            mark.draw(svg, ink, spots[index]);
        }
    }
}

/// The middle of an outline that is too small to be seen; none of one that can be seen.
fn middle_of_small(chart: &Chart, outline: &[Point2]) -> Option<Point2> {
    let shown: Vec<&Point2> = outline.iter().filter(|point| is_place(point)).collect();
    shown.first()?;
    let x = range(shown.iter().map(|point| point.x));
    let z = range(shown.iter().map(|point| point.y));
    let size = (chart.x.place(x.1) - chart.x.place(x.0)).max(chart.y.place(z.1) - chart.y.place(z.0));
    (size < VISIBLE_MM).then(|| Point2::new(f64::midpoint(x.0, x.1), f64::midpoint(z.0, z.1)))
}

fn draw_scallop(svg: &mut Svg, chart: &Chart, scallop: &Scallop) {
    chart.draw_curve(svg, "curve stroke-4", &[scallop.foot, scallop.ridge], "largest scallop");
    let Some(at) = chart.draw_mark(svg, Mark::Ring, "ink-4", &scallop.ridge) else { return };
    let words = format!("largest scallop {} mm", figure(scallop.height_mm(), 3));
    let (width, half) = (text_width(&words, SMALL_MM), text_width(&words, SMALL_MM) / 2.0);
    let x = at.x.clamp(chart.corner.x + half, (chart.right() - half).max(chart.corner.x + half));
    let mut labels = Labels::default();
    let place = labels.place(&[spot(x, (at.y - 5.0).max(chart.corner.y + 2.0))], width, SMALL_MM);
    if let Some(place) = place {
        svg.text("small head halo ink-4", baseline(place, SMALL_MM), Anchor::Middle, &words);
    }
}

/// Draws the largest scallop and what is around it enlarged, and gives the y below.
fn draw_detail(svg: &mut Svg, data: &Section, detail: &Detail) -> f64 {
    /// How long the scallop is on the detail at most.
    const SCALLOP_MM: f64 = 20.0;
    let Detail { scallop, corner, size } = detail;
    let denominator = scale_denominator(scallop.height_mm() / SCALLOP_MM);
    let middle = nalgebra::center(&scallop.ridge, &scallop.foot);
    let around = |value: f64, size: f64| {
        let half = denominator * size / 2.0;
        (value - half, value + half)
    };
    let words = format!("Largest scallop enlarged, {}", scale_text(denominator));
    let above = spot(corner.x, corner.y - ABOVE_MM - 1.0);
    svg.text("small head", above, Anchor::Start, &words);
    let chart = chart(around(middle.x, size.0), around(middle.y, size.1), denominator, *corner);
    svg.group("detail-section", "", |svg| {
        chart.draw_axes(svg);
        draw(svg, &chart, data);
    });
    chart.bottom() + BELOW_MM
}
