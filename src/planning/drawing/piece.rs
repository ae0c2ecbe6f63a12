//! The sheet of all pieces: each whole at one common scale, and where something is cut, once more, enlarged.
//!
//! A piece of 4000 by 150 mm at a scale at which it fits on paper is a band on which no cut can be judged.
//! What is cut is at its ends and around its cut-outs; those stretches are the details, all at one scale too,
//! with equal scale along and across, so that angles are true.

use super::View;
use super::label::{Labels, baseline};
use super::sheet::{
    EDGE_POINT_MM, Heading, INNER_MM, MARGIN_MM, SMALL_MM, Sample, TEXT_MM, WIDTH_MM, draw_arrow,
    draw_heading, draw_legend, draw_scale_bar, plain, plies_words, scale_denominator, scale_text, text_width,
};
use super::sketch::{CutSketch, EdgePoint, PieceSketch, pieces};
use super::svg::{Anchor, Spot, Svg, spot};
use super::window::Window;
use crate::planning::geometry::Point2;
use crate::planning::program::number::fixed;
use crate::planning::tape::input::TapeInput;
use crate::planning::tape::plan::TapePlan;

/// The width that the tape should at least have in a detail, in mm of the sheet.
const DETAIL_TAPE_MM: f64 = 30.0;
/// The width that the tape has at most where pieces are shown whole.
const LARGEST_TAPE_MM: f64 = 45.0;
/// Where the tape is at least this wide in the pieces shown whole, there are no details.
const READABLE_TAPE_MM: f64 = 12.0;
/// What a detail shows on both sides of its cuts, in mm of the sheet.
const PAD_MM: f64 = 5.0;
/// The widest detail. A longer cut is shown at both of its ends.
const WIDEST_DETAIL_MM: f64 = 130.0;
/// What is shown of each end of a cut that is longer than that.
const LONG_CUT_MM: f64 = 30.0;
/// The most details of one piece; the ends come first.
const MOST_DETAILS: usize = 8;
/// Space for `start` and `end` beside a piece shown whole.
const END_WORD_MM: f64 = 11.0;
/// Space above and below a window for the names of edge points.
const BAND_MM: f64 = 4.5;
/// Height of the caption of a detail.
const CAPTION_MM: f64 = SMALL_MM + 1.0;
/// Between the name of a piece and the facts beside it.
const FACTS_GAP_MM: f64 = 4.0;
/// From one line of facts to the next.
const FACTS_LINE_MM: f64 = SMALL_MM + 1.2;
/// Space between cards, and between the details on a card.
const GAP_MM: f64 = 8.0;

/// The sheet of all pieces of a plan.
#[derive(Debug)]
pub struct Pieces<'a> {
    input: &'a TapeInput,
    pieces: Vec<PieceSketch>,
    /// Scale denominator of the pieces shown whole.
    whole: f64,
    /// Scale denominator of the details, if there are any.
    detail: Option<f64>,
}

/// What the sheet shows of one piece, and how much room that takes.
struct Card<'a> {
    piece: &'a PieceSketch,
    facts: [String; 2],
    /// Smallest and largest u of each detail.
    details: Vec<(f64, f64)>,
    /// How many cuts are in no detail for want of room.
    left_out: usize,
    width: f64,
    height: f64,
}

impl<'a> Pieces<'a> {
    /// Lays out the pieces of a plan, in laying order.
    #[must_use]
    pub fn new(plan: &TapePlan, input: &'a TapeInput) -> Self {
        let ranges = plan.pieces().map(|(_, planned)| planned.piece.u_range());
        let longest = ranges.map(|(low, high)| high - low).fold(0.0, f64::max);
        let width = input.width.mm();
        let fits = (longest / (INNER_MM - 2.0 * END_WORD_MM)).max(width / LARGEST_TAPE_MM);
        let whole = scale_denominator(fits);
        let detail = (width / whole < READABLE_TAPE_MM).then(|| scale_denominator(width / DETAIL_TAPE_MM));
        let sketches = pieces(plan, input, detail.unwrap_or(whole));
        let mut placed: Vec<_> = plan.order.iter().zip(sketches).collect();
        placed.sort_by_key(|(place, _)| **place);
        let pieces = placed.into_iter().map(|(_, piece)| piece).collect();
        Self { input, pieces, whole, detail }
    }

    /// Draws the sheet.
    #[must_use]
    pub fn draw(&self, view: View) -> String {
        let mut svg = Svg::default();
        let heading = self.heading();
        let y = draw_heading(&mut svg, &heading, view, self.input);
        let y = draw_legend(&mut svg, y, &self.legend());
        let y = self.draw_scales(&mut svg, y + 1.0);
        let end = self.draw_cards(&mut svg, y + 6.0, view);
        let words = super::sheet::view_words(view, self.input);
        svg.finish(WIDTH_MM, end + MARGIN_MM, &heading.title, &words)
    }

    fn heading(&self) -> Heading {
        let area: f64 = self.pieces.iter().map(|piece| piece.area_mm2).sum();
        Heading {
            title: format!("Pieces: {} in laying order", self.pieces.len()),
            lines: std::iter::once(format!(
                "Tape {} mm wide. Pieces together {} m². All numbers in mm; u runs along the course from its start.",
                plain(self.input.width.mm()),
                square_metres(area)
            ))
            .chain(plies_words(self.input))
            .collect(),
        }
    }

    fn legend(&self) -> Vec<(Sample, String)> {
        let cutters = self.input.machine.cutters.iter().enumerate();
        let mut legend: Vec<_> =
            cutters.map(|(k, cutter)| (Sample::Cut(k), format!("cut by cutter {}", cutter.number))).collect();
        if self.pieces.iter().any(|piece| piece.simplified.is_some()) {
            legend.push((Sample::Line("given"), "outline of the ply where it was changed".to_owned()));
            legend.push((Sample::Area("trim"), "left to be trimmed".to_owned()));
        }
        legend.extend([
            (Sample::Line("tape-edge"), "tape's own edge".to_owned()),
            (Sample::Line("strip"), "edge of the tape beside a piece".to_owned()),
            (Sample::Line("centre"), "centre line of the course".to_owned()),
            (
                Sample::Disc("edge-point"),
                "Edge0, Edge1 of a cut, with their u (with ' at the end of the course)".to_owned(),
            ),
        ]);
        legend
    }

    fn draw_scales(&self, svg: &mut Svg, y: f64) -> f64 {
        let words = if self.detail.is_some() { "whole pieces" } else { "scale" };
        let x = draw_scale_bar(svg, spot(MARGIN_MM, y), self.whole, words);
        if let Some(detail) = self.detail {
            draw_scale_bar(svg, spot(x + GAP_MM, y), detail, "details A, B, ...");
        }
        y
    }

    /// Draws the cards in rows as long as the sheet and gives the y below the last.
    fn draw_cards(&self, svg: &mut Svg, y: f64, view: View) -> f64 {
        let (mut x, mut y, mut row_height) = (MARGIN_MM, y, 0.0_f64);
        for piece in &self.pieces {
            let card = self.card(piece);
            if x > MARGIN_MM && x + card.width > WIDTH_MM - MARGIN_MM {
                (x, y, row_height) = (MARGIN_MM, y + row_height, 0.0);
            }
            let title = piece.title();
            svg.group("card", &title, |svg| self.draw_card(svg, &card, (x, y), view));
            x += card.width + GAP_MM;
            row_height = row_height.max(card.height);
        }
        y + row_height
    }

    fn card<'p>(&self, piece: &'p PieceSketch) -> Card<'p> {
        let facts = self.facts(piece);
        let (details, left_out) = self.detail.map_or((Vec::new(), 0), |scale| details(piece, scale));
        let whole_width = (piece.u.1 - piece.u.0) / self.whole + 2.0 * END_WORD_MM;
        let name_width = text_width(&card_name(piece), TEXT_MM) + FACTS_GAP_MM;
        let words_width = (name_width + text_width(&facts[0], SMALL_MM)).max(text_width(&facts[1], SMALL_MM));
        let mut card =
            Card { piece, facts, details, left_out, width: whole_width.max(words_width), height: 0.0 };
        card.height = self.whole_y() + self.input.width.mm() / self.whole + BAND_MM + GAP_MM;
        if let Some(scale) = self.detail {
            let places = detail_places(&card.details, scale);
            let right =
                places.iter().zip(&card.details).map(|((x, _), (low, high))| x + (high - low) / scale);
            card.width = right.fold(card.width, f64::max);
            let rows = places.last().map_or(0, |(_, row)| row + 1);
            card.height += rows as f64 * self.detail_height(scale);
        }
        card
    }

    fn facts(&self, piece: &PieceSketch) -> [String; 2] {
        let cuts = self.input.machine.cutters.iter().enumerate().map(|(k, cutter)| {
            let count = piece.cuts.iter().filter(|cut| cut.cutter == k).count();
            format!("cutter {}: {count}", cutter.number)
        });
        let (low, high) = piece.u;
        let changed = piece.simplified.map_or(String::new(), |(deviation, area)| {
            format!("; changed by {} mm, {} mm² to trim", fixed(deviation, 2), fixed(area, 0))
        });
        [
            format!("length {} mm, area {} m²{changed}", fixed(high - low, 2), square_metres(piece.area_mm2)),
            format!(
                "cuts by {}; roll r {} to {}",
                cuts.collect::<Vec<_>>().join(", "),
                fixed(low + piece.offset_mm, 1),
                fixed(high + piece.offset_mm, 1)
            ),
        ]
    }

    /// From the top of a card to the upper edge of the tape of the piece shown whole.
    fn whole_y(&self) -> f64 {
        TEXT_MM + FACTS_LINE_MM + 1.0 + BAND_MM
    }

    /// Height of a row of details with its captions.
    fn detail_height(&self, scale: f64) -> f64 {
        CAPTION_MM + 2.0 * BAND_MM + self.input.width.mm() / scale + 2.0
    }

    fn draw_card(&self, svg: &mut Svg, card: &Card<'_>, (x, y): (f64, f64), view: View) {
        draw_card_head(svg, card, (x, y));
        let half = self.input.width.mm() / self.whole / 2.0;
        let window = Window {
            along: card.piece.u,
            left: spot(x + END_WORD_MM, y + self.whole_y() + half),
            denominator: self.whole,
            view,
        };
        svg.group("whole", "", |svg| self.draw_whole(svg, card, &window));
        if let Some(scale) = self.detail {
            let top = window.left.y + half + BAND_MM;
            self.draw_details(svg, card, (x, top), scale, view);
        }
    }

    fn draw_whole(&self, svg: &mut Svg, card: &Card<'_>, window: &Window) {
        self.draw_piece(svg, card.piece, window);
        let (left, right, y) = (window.left.x, window.left.x + window.width(), window.left.y);
        svg.text("small", spot(left - 2.0, y + 0.9), Anchor::End, "start");
        svg.text("small", spot(right + 2.0, y + 0.9), Anchor::Start, "end");
        draw_direction(svg, window);
        if self.detail.is_none() {
            return self.draw_edge_points(svg, card.piece, window);
        }
        for (index, &(low, high)) in card.details.iter().enumerate() {
            let half = self.input.width.mm() / self.whole / 2.0 + 1.0;
            let (from, to) =
                (window.x(low.max(card.piece.u.0)) - 1.0, window.x(high.min(card.piece.u.1)) + 1.0);
            svg.rect("detail", spot(from, y - half), to - from, 2.0 * half);
            svg.text("small", spot(f64::midpoint(from, to), y - half - 0.8), Anchor::Middle, &letter(index));
        }
    }

    fn draw_details(&self, svg: &mut Svg, card: &Card<'_>, (x, y): (f64, f64), scale: f64, view: View) {
        let half = self.input.width.mm() / scale / 2.0;
        for (index, (along, (dx, row))) in
            card.details.iter().zip(detail_places(&card.details, scale)).enumerate()
        {
            let top = y + row as f64 * self.detail_height(scale);
            let left = spot(x + dx, top + CAPTION_MM + BAND_MM + half);
            let window = Window { along: *along, left, denominator: scale, view };
            let caption = format!("{}  {}", letter(index), scale_text(scale));
            svg.text("small", spot(left.x, top + SMALL_MM), Anchor::Start, &caption);
            svg.group("enlarged", "", |svg| {
                self.draw_piece(svg, card.piece, &window);
                self.draw_edge_points(svg, card.piece, &window);
            });
        }
    }

    fn draw_piece(&self, svg: &mut Svg, piece: &PieceSketch, window: &Window) {
        let half = self.input.width.mm() / 2.0;
        for v in [-half, half] {
            let ends = [window.along.0, window.along.1].map(|u| window.spot(&Point2::new(u, v)));
            svg.line("strip", ends[0], ends[1]);
        }
        window.draw_area(svg, piece, 0.0, "piece", "");
        window.draw_trims(svg, piece);
        window.draw_tape_edges(svg, piece, 0.0);
        svg.line("centre", window.left, spot(window.left.x + window.width(), window.left.y));
        window.draw_cuts(svg, piece, 0.0, 'u');
    }

    fn draw_edge_points(&self, svg: &mut Svg, piece: &PieceSketch, window: &Window) {
        let mut labels = Labels::default();
        let here = piece.edge_points.iter().filter(|point| window.shows((point.at.x, point.at.x)));
        for EdgePoint { name, at } in here {
            let place = window.spot(at);
            svg.disc("edge-point", place, EDGE_POINT_MM);
            let words = format!("{name} {}", fixed(at.x, 2));
            let width = text_width(&words, SMALL_MM);
            let places = name_places(place, width, window);
            if let Some(middle) = labels.place(&places, width, SMALL_MM) {
                svg.text("small", baseline(middle, SMALL_MM), Anchor::Middle, &words);
            }
        }
    }
}

/// Where the name of an edge point may stand: outside the tape, turned toward the middle of the window if there
/// is room and else away from it, farther out if need be.
fn name_places(point: Spot, width: f64, window: &Window) -> [Spot; 4] {
    let (left, right) = (window.left.x + width / 2.0, window.left.x + window.width() - width / 2.0);
    let out = if point.y > window.left.y { 1.0 } else { -1.0 };
    let turn = if point.x < f64::midpoint(left, right) { width / 2.0 } else { -width / 2.0 };
    let inward = (point.x + turn).clamp(left, right.max(left));
    let near = point.y + out * (EDGE_POINT_MM + 0.4 + SMALL_MM / 2.0);
    let far = near + out * SMALL_MM;
    [(inward, near), (point.x - turn, near), (inward, far), (point.x - turn, far)].map(|(x, y)| spot(x, y))
}

fn draw_card_head(svg: &mut Svg, card: &Card<'_>, (x, y): (f64, f64)) {
    let name = card_name(card.piece);
    svg.text("head", spot(x, y + TEXT_MM), Anchor::Start, &name);
    let mut second = card.facts[1].clone();
    if card.left_out > 0 {
        second.push_str(&format!("; {} cuts in no detail", card.left_out));
    }
    let beside = x + text_width(&name, TEXT_MM) + FACTS_GAP_MM;
    svg.text("quiet", spot(beside, y + TEXT_MM), Anchor::Start, &card.facts[0]);
    svg.text("quiet", spot(x, y + TEXT_MM + FACTS_LINE_MM), Anchor::Start, &second);
}

fn card_name(piece: &PieceSketch) -> String {
    let (number, of) = piece.number;
    let of_several = if of > 1 { format!(", piece {number} of {of}") } else { String::new() };
    format!("Course {}{of_several}", piece.course)
}

/// The arrow of U on the centre line.
fn draw_direction(svg: &mut Svg, window: &Window) {
    const LONGEST_MM: f64 = 10.0;
    let length = LONGEST_MM.min(window.width() / 3.0);
    let middle = spot(window.left.x + window.width() / 2.0, window.left.y);
    draw_arrow(svg, spot(middle.x - length / 2.0, middle.y), spot(middle.x + length / 2.0, middle.y));
    svg.text("small halo", spot(middle.x + length / 2.0 + 1.0, middle.y + 0.9), Anchor::Start, "U");
}

/// A, B, ... for the details of a piece.
fn letter(index: usize) -> String {
    char::from_u32('A' as u32 + index as u32).unwrap_or('?').to_string()
}

/// The stretches of u where something is cut, with some room around, and how many cuts are in none of them.
fn details(piece: &PieceSketch, scale: f64) -> (Vec<(f64, f64)>, usize) {
    let (pad, widest) = (PAD_MM * scale, WIDEST_DETAIL_MM * scale);
    let ranges = piece
        .cuts
        .iter()
        .map(CutSketch::u_range)
        .flat_map(|range| at_most(range, widest, LONG_CUT_MM * scale));
    let stretches = merged(ranges.map(|(low, high)| (low - pad, high + pad)).collect());
    let mut details: Vec<(f64, f64)> =
        stretches.into_iter().flat_map(|stretch| at_most(stretch, widest, widest / 2.0)).collect();
    if details.len() > MOST_DETAILS {
        details.drain(MOST_DETAILS - 1..details.len() - 1);
    }
    let hidden = |(low, high): (f64, f64)| !details.iter().any(|detail| detail.0 <= high && detail.1 >= low);
    let left_out = piece.cuts.iter().map(CutSketch::u_range).filter(|range| hidden(*range)).count();
    (details, left_out)
}

/// Stretches that overlap become one.
fn merged(mut stretches: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    stretches.sort_by(|one, other| one.0.total_cmp(&other.0));
    let mut merged: Vec<(f64, f64)> = Vec::new();
    for (low, high) in stretches {
        match merged.last_mut() {
            Some(last) if low <= last.1 => last.1 = last.1.max(high),
            _ => merged.push((low, high)),
        }
    }
    merged
}

/// A stretch, or so much of its two ends if it is longer than `widest`.
fn at_most((low, high): (f64, f64), widest: f64, end: f64) -> Vec<(f64, f64)> {
    if high - low <= widest { vec![(low, high)] } else { vec![(low, low + end), (high - end, high)] }
}

/// For each detail its distance from the left of the card, in mm of the sheet, and its row.
fn detail_places(details: &[(f64, f64)], scale: f64) -> Vec<(f64, usize)> {
    let (mut x, mut row) = (0.0, 0);
    let place = |(low, high): &(f64, f64)| {
        let width = (high - low) / scale;
        if x > 0.0 && x + width > INNER_MM {
            (x, row) = (0.0, row + 1);
        }
        let place = (x, row);
        x += width + GAP_MM;
        place
    };
    details.iter().map(place).collect()
}

fn square_metres(area_mm2: f64) -> String {
    fixed(area_mm2 / 1e6, 4)
}
