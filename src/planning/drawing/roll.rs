//! The whole roll along r, folded into rows of equal length: where each piece lies, what is scrap, and where the
//! knives go down and come up, in the order in which they do.

use std::collections::BTreeSet;

use super::View;
use super::label::{Labels, baseline};
use super::sheet::{
    DOT_MM, Heading, INNER_MM, MARGIN_MM, NUMBER_MM, SMALL_MM, Sample, TEXT_MM, TITLE_MM, WIDTH_MM,
    draw_arrow, draw_heading, draw_knife, draw_legend, draw_scale_bar, plain, plies_words, round_step,
    scale_denominator, text_width, view_words,
};
use super::sketch::{KnifeMark, KnifeWork, PieceSketch, knife_work, pieces};
use super::svg::{Anchor, Spot, Svg, spot};
use super::window::Window;
use crate::planning::geometry::Point2;
use crate::planning::program::number::fixed;
use crate::planning::tape::input::TapeInput;
use crate::planning::tape::plan::TapePlan;
use crate::planning::tape::roll::RollFigures;

/// The width that the tape should have, in mm of the sheet.
const TAPE_MM: f64 = 18.0;
/// The width that the tape has at most, on a short roll.
const LARGEST_TAPE_MM: f64 = 45.0;
/// The most rows of a sheet: beyond this a longer roll is drawn smaller.
const MOST_ROWS: f64 = 60.0;
/// Ticks of r are at least this far apart.
const TICK_MM: f64 = 14.0;
/// Space above and below the tape, or beyond the overcuts, for the numbers of strokes.
const BAND_MM: f64 = 4.0;
/// Space below that for the ruler of r.
const RULER_MM: f64 = 6.0;
/// Space between rows.
const GAP_MM: f64 = 3.0;

/// The drawing of a plan's roll.
#[derive(Debug)]
pub struct RollSheet<'a> {
    input: &'a TapeInput,
    figures: RollFigures,
    pieces: Vec<PieceSketch>,
    work: KnifeWork,
    /// Smallest and largest r of all pieces, and of what of the tape lies before them.
    range: (f64, f64),
    /// Defects and splices within that, smallest and largest r.
    zones: Vec<(f64, f64)>,
    /// Scale denominator.
    scale: f64,
    /// Space above and below the tape, for overcuts and the numbers of strokes, in mm of the sheet.
    band: f64,
    /// r at the left end of the first row, a whole number of ticks.
    first: f64,
    /// Length of a row in mm of tape, a whole number of ticks.
    row: f64,
    /// Distance of ticks in mm of tape.
    tick: f64,
}

impl<'a> RollSheet<'a> {
    /// Lays out the roll of a plan.
    #[must_use]
    pub fn new(plan: &TapePlan, input: &'a TapeInput) -> Self {
        let ranges = plan.pieces().map(|(_, planned)| {
            let (low, high) = planned.piece.u_range();
            (low + planned.offset_mm, high + planned.offset_mm)
        });
        let range = ranges.reduce(|one, other| (one.0.min(other.0), one.1.max(other.1))).unwrap_or_default();
        let zones = zones(plan, input, range.0);
        let range = (range.0, range.1.max(plan.leading_end_mm));
        let scale = scale_of(range.1 - range.0, input.width.mm());
        let tick = round_step(TICK_MM * scale);
        let work = knife_work(plan, input);
        let across = work.marks.iter().map(|mark| mark.at.y.abs()).fold(0.0, f64::max);
        Self {
            input,
            figures: plan.figures,
            pieces: pieces(plan, input, scale),
            work,
            range,
            zones,
            scale,
            band: BAND_MM + (across - input.width.mm() / 2.0).max(0.0) / scale,
            first: (range.0 / tick).floor() * tick,
            row: (INNER_MM * scale / tick).floor() * tick,
            tick,
        }
    }

    /// Draws the roll.
    #[must_use]
    pub fn draw(&self, view: View) -> String {
        let mut svg = Svg::default();
        let hatching = view.file_name("roll").replace(".svg", "-scrap");
        svg.hatching(&hatching);
        if !self.zones.is_empty() {
            svg.pattern(&zone_hatching(&hatching), "M0 0L2 2M0 2L2 0");
        }
        let heading = self.heading();
        let y = draw_heading(&mut svg, &heading, view, self.input);
        let y = draw_legend(&mut svg, y, &self.legend(&hatching));
        draw_scale_bar(&mut svg, spot(MARGIN_MM, y + 1.0), self.scale, "scale");
        let end = self.draw_rows(&mut svg, y + 6.0, view, &hatching);
        svg.finish(WIDTH_MM, end + MARGIN_MM, &heading.title, &view_words(view, self.input))
    }

    fn heading(&self) -> Heading {
        let figures = &self.figures;
        let stations = self.input.machine.cutters.iter();
        let stations: Vec<_> = stations.map(|cutter| plain(cutter.station.mm())).collect();
        Heading {
            title: format!(
                "Roll: {} mm of tape, {} pieces",
                fixed(figures.tape_used_mm, 1),
                self.pieces.len()
            ),
            lines: [
                format!(
                    "Tape {} mm wide. Pieces {} m², scrap {} m²: {} % of the tape used is in pieces; {} % if all outlines touched.",
                    plain(self.input.width.mm()),
                    fixed(figures.piece_area_mm2 / 1e6, 4),
                    fixed(figures.scrap_area_mm2 / 1e6, 4),
                    fixed(figures.utilisation * 100.0, 1),
                    fixed(figures.bound_utilisation * 100.0, 1)
                ),
                format!(
                    "Machine {}. A cutter stands over r when the tape axis reads {} - r + its station ({} mm). The largest r passes the knives first.",
                    self.input.machine.name,
                    plain(figures.lead_mm),
                    stations.join(", ")
                ),
            ]
            .into_iter()
            .chain(plies_words(self.input))
            .collect(),
        }
    }

    fn legend(&self, hatching: &str) -> Vec<(Sample, String)> {
        let cutters = || self.input.machine.cutters.iter().enumerate();
        let mut legend: Vec<_> = cutters()
            .map(|(k, cutter)| (Sample::Cut(k), format!("cut by cutter {}", cutter.number)))
            .collect();
        for (k, cutter) in cutters() {
            legend.push((Sample::Knife(k, true), format!("knife {} down", cutter.number)));
            legend.push((Sample::Knife(k, false), format!("up, {}·n = its n-th stroke", cutter.number)));
        }
        for (k, cutter) in cutters().filter(|_| !self.work.overcuts.is_empty()) {
            legend.push((Sample::Line(overcut_class(k)), format!("overcut of cutter {}", cutter.number)));
        }
        if !self.zones.is_empty() {
            legend.push((Sample::Hatched(zone_hatching(hatching)), "defect or splice, kept free".to_owned()));
        }
        legend.extend([
            (Sample::Hatched(hatching.to_owned()), "scrap".to_owned()),
            (Sample::Line("tape-edge"), "tape's own edge".to_owned()),
            (Sample::Line("centre"), "centre line".to_owned()),
        ]);
        legend
    }

    fn draw_rows(&self, svg: &mut Svg, y: f64, view: View, hatching: &str) -> f64 {
        let mut y = y + NUMBER_MM + 1.0;
        let rows = ((self.range.1 - self.first) / self.row).ceil().max(1.0) as usize;
        for index in 0..rows {
            let start = self.first + index as f64 * self.row;
            let low = start.max(self.range.0);
            // Where the last row is empty but for rounding, it stays an empty one.
            let along = (low, (start + self.row).min(self.range.1).max(low));
            let left = MARGIN_MM + (along.0 - start) / self.scale;
            let half = self.input.width.mm() / self.scale / 2.0;
            let window =
                Window { along, left: spot(left, y + self.band + half), denominator: self.scale, view };
            svg.group("row", "", |svg| self.draw_row(svg, &window, hatching));
            y += 2.0 * half + 2.0 * self.band + RULER_MM + GAP_MM;
        }
        y
    }

    fn draw_row(&self, svg: &mut Svg, window: &Window, hatching: &str) {
        let half = self.input.width.mm() / self.scale / 2.0;
        let (left, width) = (window.left, window.width());
        svg.hatched_rect(hatching, spot(left.x, left.y - half), width, 2.0 * half);
        for &(low, high) in self.zones.iter().filter(|zone| window.shows(**zone)) {
            let x = window.x(low.max(window.along.0));
            let right = window.x(high.min(window.along.1));
            svg.hatched_rect(&zone_hatching(hatching), spot(x, left.y - half), right - x, 2.0 * half);
        }
        let here: Vec<(usize, &PieceSketch)> =
            self.pieces.iter().enumerate().filter(|(_, piece)| window.shows(on_roll(piece))).collect();
        for (index, piece) in &here {
            let class = if index % 2 == 0 { "piece" } else { "piece odd" };
            window.draw_area(svg, piece, piece.offset_mm, class, &area_title(piece));
        }
        for y in [left.y - half, left.y + half] {
            svg.line("tape-edge", spot(left.x, y), spot(left.x + width, y));
        }
        svg.line("centre", left, spot(left.x + width, left.y));
        // Before the cuts: an end that is cut square across shows its knife.
        self.draw_ends(svg, window, half);
        for (_, piece) in &here {
            window.draw_cuts(svg, piece, piece.offset_mm, 'r');
        }
        self.draw_overcuts(svg, window);
        self.draw_ruler(svg, window, half + self.band);
        let mut labels = Labels::default();
        for (_, piece) in &here {
            draw_course(svg, window, piece, half, &mut labels);
        }
        self.draw_marks(svg, window, half, &mut labels);
    }

    /// Draws where cuts go on beyond their ends: all of one whose end of a cut lies in this row, however far it goes.
    fn draw_overcuts(&self, svg: &mut Svg, window: &Window) {
        for (cutter, [from, to]) in
            self.work.overcuts.iter().filter(|(_, [at, _])| window.shows((at.x, at.x)))
        {
            svg.line(overcut_class(*cutter), window.spot(from), window.spot(to));
        }
    }

    fn draw_ruler(&self, svg: &mut Svg, window: &Window, below: f64) {
        let y = window.left.y + below;
        let (low, high) = window.along;
        svg.line("ruler", spot(window.x(low), y), spot(window.x(high), y));
        let slack = DOT_MM * self.scale;
        let first = ((low - slack) / self.tick).ceil() as i64;
        let last = ((high + slack) / self.tick).floor() as i64;
        for number in first..=last {
            let r = number as f64 * self.tick;
            let x = window.x(r);
            svg.line("ruler", spot(x, y), spot(x, y + 1.2));
            svg.text("quiet", spot(x, y + 1.6 + SMALL_MM), Anchor::Middle, &plain(r));
        }
    }

    /// Says where the tape begins and where it ends.
    fn draw_ends(&self, svg: &mut Svg, window: &Window, half: f64) {
        let y = window.left.y;
        let above = y - half - self.band;
        if window.along.0 == self.range.0 {
            let x = window.x(self.range.0);
            svg.line("line", spot(x, y - half), spot(x, y + half));
            svg.text(
                "small",
                spot(x, above),
                Anchor::Start,
                "trailing end: wound last, first off the cassette",
            );
        }
        if window.along.1 == self.range.1 {
            const WORDS: &str = "leading end: first under the knives";
            let x = window.x(self.range.1);
            svg.line("line", spot(x, y - half), spot(x, y + half));
            let room = WIDTH_MM - MARGIN_MM - x;
            if room > text_width(WORDS, SMALL_MM) + 12.0 {
                draw_arrow(svg, spot(x + 1.5, y), spot(x + 9.5, y));
                svg.text("small", spot(x + 11.0, y + 0.9), Anchor::Start, WORDS);
            } else {
                svg.text("small", spot(x, above), Anchor::End, WORDS);
            }
        }
    }

    fn draw_marks(&self, svg: &mut Svg, window: &Window, half: f64, labels: &mut Labels) {
        // The digits of a program may put a mark a little beyond the tape's end.
        let slack = DOT_MM * self.scale;
        let shown = |mark: &&KnifeMark| window.shows((mark.at.x - slack, mark.at.x + slack));
        let here: Vec<&KnifeMark> = self.work.marks.iter().filter(shown).collect();
        let mut drawn = BTreeSet::new();
        // Squares first: a disc at the same place then lies on its square.
        for cutter in (0..self.input.machine.cutters.len()).rev() {
            for mark in here.iter().filter(|mark| mark.cutter == cutter) {
                let at = window.spot(&mark.at);
                if drawn.insert(dot(mark, at)) {
                    draw_knife(svg, mark.cutter, mark.down, at);
                }
            }
        }
        if drawn.len() <= MOST_NUMBERED {
            number_marks(svg, window, &here, half, labels);
        }
    }
}

/// Classes of an overcut of a cutter, from 0.
fn overcut_class(cutter: usize) -> &'static str {
    if cutter == 0 { "overcut cutter-1" } else { "overcut cutter-2" }
}

fn zone_hatching(hatching: &str) -> String {
    hatching.replace("-scrap", "-zone")
}

/// The defects and splices of the tape that the roll reaches, smallest and largest r. They are given from the leading
/// end on.
fn zones(plan: &TapePlan, input: &TapeInput, trailing_end: f64) -> Vec<(f64, f64)> {
    let on_roll = input
        .zones_mm
        .iter()
        .map(|(from, to)| ((plan.leading_end_mm - to).max(trailing_end), plan.leading_end_mm - from));
    on_roll.filter(|(low, high)| low < high).collect()
}

/// With more marks than this in a row their numbers could not be read.
const MOST_NUMBERED: usize = 300;

/// Numbers the strokes: where knives go down first, so that those have the better places.
fn number_marks(svg: &mut Svg, window: &Window, marks: &[&KnifeMark], half: f64, labels: &mut Labels) {
    for mark in marks {
        labels.take(window.spot(&mark.at), MARK_MM);
    }
    for down in [true, false] {
        for mark in marks.iter().filter(|mark| mark.down == down) {
            draw_number(svg, window, mark, half, labels);
        }
    }
}

/// Half of the room that the mark of a knife takes.
const MARK_MM: f64 = 1.0;

/// Marks of one kind that fall on one dot of the sheet are drawn once.
fn dot(mark: &KnifeMark, at: Spot) -> (usize, bool, i64, i64) {
    const MM: f64 = 0.2;
    (mark.cutter, mark.down, (at.x / MM).round() as i64, (at.y / MM).round() as i64)
}

fn scale_of(length: f64, width: f64) -> f64 {
    let in_one_row = length / INNER_MM;
    let fits = if in_one_row <= width / TAPE_MM {
        in_one_row.max(width / LARGEST_TAPE_MM)
    } else {
        // A row loses a tick's length at most by ending on a whole tick.
        (width / TAPE_MM).max(length / (MOST_ROWS * (INNER_MM - 2.0 * TICK_MM)))
    };
    scale_denominator(fits)
}

fn on_roll(piece: &PieceSketch) -> (f64, f64) {
    (piece.u.0 + piece.offset_mm, piece.u.1 + piece.offset_mm)
}

fn area_title(piece: &PieceSketch) -> String {
    let (low, high) = on_roll(piece);
    format!("{}, r {} to {} mm", piece.title(), fixed(low, 2), fixed(high, 2))
}

/// The number of a course in the middle of what the row shows of its piece, as large as there is room for it.
fn draw_course(svg: &mut Svg, window: &Window, piece: &PieceSketch, half: f64, labels: &mut Labels) {
    let shown = (window.along.0 - piece.offset_mm, window.along.1 - piece.offset_mm);
    let Some((v, (from, to))) = piece.longest_stretch(shown) else { return };
    let middle = window.spot(&Point2::new(f64::midpoint(from, to) + piece.offset_mm, v));
    let label = piece.label();
    let large = (half > TEXT_MM).then_some(("title halo", TITLE_MM));
    for (class, size) in large.into_iter().chain([("small head halo", SMALL_MM)]) {
        let width = text_width(&label, size);
        if width <= (to - from) / window.denominator
            && let Some(place) = labels.place(&[middle], width, size)
        {
            return svg.text(class, baseline(place, size), Anchor::Middle, &label);
        }
    }
}

/// The number of a stroke beside its mark, at the first place that is free; none if none is.
fn draw_number(svg: &mut Svg, window: &Window, mark: &KnifeMark, half: f64, labels: &mut Labels) {
    let words = format!("{}·{}", mark.cutter + 1, mark.stroke);
    let width = text_width(&words, NUMBER_MM);
    let at = window.spot(&mark.at);
    let outward = if at.y < window.left.y { -1.0 } else { 1.0 };
    let near_edge = (at.y - window.left.y).abs() > 0.7 * half;
    let (aside, beside) = (width / 2.0 + MARK_MM + 0.3, NUMBER_MM / 2.0 + MARK_MM + 0.2);
    let out = outward * beside;
    let candidates = if near_edge {
        [(0.0, out), (aside, out), (-aside, out), (aside, 0.0), (-aside, 0.0)]
    } else {
        [(aside, 0.0), (-aside, 0.0), (0.0, -beside), (0.0, beside), (aside, beside)]
    };
    let places = candidates.map(|(dx, dy)| spot(at.x + dx, at.y + dy));
    if let Some(place) = labels.place(&places, width, NUMBER_MM) {
        let class = format!("number halo cutter-{}", mark.cutter + 1);
        svg.text(&class, baseline(place, NUMBER_MM), Anchor::Middle, &words);
    }
}
