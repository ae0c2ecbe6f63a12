//! Tips at which two knives miss one another, drawn much larger than they are (the companion paper's Fig. 10).

use super::View;
use super::page::Page;
use super::sheet::{INNER_MM, MARGIN_MM, SMALL_MM, Sample, cut_class, figure};
use super::svg::{Anchor, Path, Spot, Svg, spot};
use crate::planning::geometry::Vector2;
use crate::planning::outcome::Drawing;
use crate::planning::tape::label::CourseLabel;
use crate::planning::tape::tips::{Tip, TipKind};

/// The most tips on a sheet; those with the largest misses are shown.
const MOST: usize = 10;
/// Tips in a row.
const ROW: usize = 5;
/// Side of the square in which a tip is shown, in mm of the sheet.
const SIDE_MM: f64 = INNER_MM / ROW as f64 - 4.0;
/// A miss is drawn so large, in mm of the sheet.
const MISS_MM: f64 = 8.0;

/// Draws the tips with the largest misses: `tips.svg`; nothing where no error is given.
#[must_use]
pub fn tips(tips: &[Tip]) -> Option<Drawing> {
    let mut worst: Vec<&Tip> = tips.iter().filter(|tip| tip.mismatch_mm > 0.0).collect();
    worst.sort_by(|one, other| other.mismatch_mm.total_cmp(&one.mismatch_mm));
    worst.truncate(MOST);
    if worst.is_empty() {
        return None;
    }
    let mut page = Page::new("Tips: how far two knives miss one another", "", &lines(tips));
    page.legend(&[
        (Sample::Line("limit-dashed"), "wanted".to_owned()),
        (Sample::Cut(0), "cut by one knife".to_owned()),
        (Sample::Cut(1), "cut by the other one, at each of the four worst places beside it".to_owned()),
    ]);
    let top = page.y + 2.0;
    for (index, tip) in worst.iter().enumerate() {
        let corner = spot(
            MARGIN_MM + (index % ROW) as f64 * (SIDE_MM + 4.0),
            top + (index / ROW) as f64 * (SIDE_MM + 16.0),
        );
        page.svg.group("tip", "", |svg| draw(svg, tip, corner));
    }
    let rows = worst.len().div_ceil(ROW) as f64;
    Some(page.finish("tips", top + rows * (SIDE_MM + 16.0)))
}

fn lines(tips: &[Tip]) -> Vec<String> {
    vec![
        format!(
            "{} tips are cut by two knives; the {} with the largest misses are shown, each at a scale of its own. U to the right, V up.",
            tips.len(),
            tips.len().min(MOST)
        ),
        "The misses are the largest that the errors given in the profile can cause. Cuts that end apart leave a bridge; \
         an overcut of the length named parts it."
            .to_owned(),
    ]
}

fn draw(svg: &mut Svg, tip: &Tip, corner: Spot) {
    svg.rect("frame", corner, SIDE_MM, SIDE_MM);
    let scale = MISS_MM / tip.mismatch_mm;
    // The tip stands toward the side to which it points, so that its legs have room.
    let aside = if tip.kind == TipKind::Greater { 0.68 } else { 0.32 };
    let at = spot(corner.x + aside * SIDE_MM, corner.y + SIDE_MM / 2.0);
    for way in tip.ways {
        draw_leg(svg, "limit-dashed", at, way, corner);
    }
    draw_leg(svg, &cut_class(0), at, tip.ways[0], corner);
    for (u, v) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
        let down = View::FromBelow.v_down();
        let from =
            spot(at.x + u * scale * tip.feed_mismatch_mm, at.y + down * v * scale * tip.lateral_mismatch_mm);
        draw_leg(svg, &cut_class(1), from, tip.ways[1], corner);
    }
    let [u, v] = tip.at_uv.map(|value| figure(value, 1));
    let course = CourseLabel { ply: tip.ply, number: tip.course }.short();
    let words = [
        format!("course {course}.{}, \"{}\" at u {u}, v {v}", tip.piece, kind(tip.kind)),
        format!(
            "dU {} mm, dV {} mm, together {}",
            figure(tip.feed_mismatch_mm, 3),
            figure(tip.lateral_mismatch_mm, 3),
            figure(tip.mismatch_mm, 3)
        ),
        format!("parted by an overcut of {} mm", figure(tip.severing_overcut_mm, 3)),
    ];
    for (line, words) in words.iter().enumerate() {
        let y = corner.y + SIDE_MM + (line + 1) as f64 * (SMALL_MM + 1.0);
        svg.text("small", spot(corner.x, y), Anchor::Start, words);
    }
}

fn kind(kind: TipKind) -> &'static str {
    match kind {
        TipKind::Greater => ">",
        TipKind::Less => "<",
    }
}

/// A leg from its tip to the frame.
fn draw_leg(svg: &mut Svg, class: &str, from: Spot, way: Vector2, corner: Spot) {
    let down = View::FromBelow.v_down();
    let to_side = |at: f64, low: f64, way: f64| {
        if way > 0.0 {
            (low + SIDE_MM - at) / way
        } else if way < 0.0 {
            (low - at) / way
        } else {
            f64::INFINITY
        }
    };
    let (dx, dy) = (way.x, down * way.y);
    let length = to_side(from.x, corner.x, dx).min(to_side(from.y, corner.y, dy));
    if length.is_finite() {
        let mut path = Path::default();
        path.open([from, spot(from.x + length * dx, from.y + length * dy)]);
        svg.path(class, &path, "");
    }
}
