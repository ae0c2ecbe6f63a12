//! What is left at the end: the surface, how far it stands off the contour, and the chips that stayed.

use super::Section;
use super::grid::{GridPoint, UNITS, placed};
use super::piece::edges_of;
use super::profile::Farthest;
use crate::planning::geometry::Point2;
use crate::planning::geometry::polygon::signed_area;
use crate::planning::geometry::simplify::distance_to_segment;
use crate::planning::tolerance::{FARTHEST_MM, KERF_MM, SAME_POINT_MM, SLIVER_MM2};

/// What is left of the blank.
#[derive(Debug, Clone, PartialEq)]
pub struct Remains {
    /// The remaining surface, in mm: the boundary of the stock but for the base and what of the sides lies below the
    /// contour. Lines from left to right where they are open; slits that freed nothing are loops or dents of it.
    pub surface: Vec<Vec<Point2>>,
    /// Stock left above the part, in mm^2.
    pub residual_area: f64,
    /// The part of the finished part that left with chips, in mm^2.
    pub gouge_area: f64,
    /// What slits took from the part by their kerf, in mm^2: half of it along every arm on the contour.
    pub slit_area_of_part: f64,
    /// The deepest that any cut entered the part, in mm.
    pub deepest_gouge: f64,
    /// The point of the surface above the part that lies farthest from the contour; `None` if none does.
    pub scallop: Option<Farthest>,
    /// The tips, in mm and in order of their first cut, whose chip has stayed: both arms are cut and the wedge
    /// between them, just above the tip, is still stock.
    pub stuck: Vec<Point2>,
}

impl Section {
    /// What is left now.
    #[must_use]
    pub fn remains(&self) -> Remains {
        let surface = self.surface();
        let scallop = self.scallop_of(&surface);
        let stock: f64 = self.stock_area();
        let part_left: f64 = self.stock.pieces().map(|piece| piece.area_under(&self.profile)).sum();
        Remains {
            surface,
            residual_area: (stock - part_left).max(0.0),
            gouge_area: self.gouge_area,
            slit_area_of_part: self.slit_area_of_part,
            deepest_gouge: self.deepest_gouge,
            scallop,
            stuck: self.stuck(),
        }
    }

    /// The stock left, in mm^2.
    #[must_use]
    pub fn stock_area(&self) -> f64 {
        square_mm(self.stock.pieces().map(|piece| piece.area).sum())
    }

    fn surface(&self) -> Vec<Vec<Point2>> {
        let shapes = self.stock.joined();
        shapes.iter().flatten().flat_map(|contour| self.open_lines(contour)).collect()
    }

    /// The runs of a contour of the stock that are surface, each from left to right.
    fn open_lines(&self, contour: &[GridPoint]) -> Vec<Vec<Point2>> {
        let mut lines = Vec::new();
        let mut line: Vec<Point2> = Vec::new();
        for edge in edges_of(&self.without_seams(contour)) {
            let Some([from, to]) = self.surface_of(edge) else {
                lines.push(std::mem::take(&mut line));
                continue;
            };
            if line.last().is_some_and(|&last| last != from) {
                lines.push(std::mem::take(&mut line));
            }
            if line.is_empty() {
                line.push(from);
            }
            line.push(to);
        }
        // The contour is a loop: what runs through its first point was taken for two lines.
        match lines.first_mut() {
            Some(first) if first.first() == line.last() => {
                line.extend(first.iter().skip(1));
                *first = line;
            }
            _ => lines.push(line),
        }
        lines.into_iter().filter_map(left_to_right).collect()
    }

    /// A contour without the points that it has only where it passes from tile to tile.
    ///
    /// They are rounded crossings of the border, so they lie a unit or two off the straight edge.
    fn without_seams(&self, contour: &[GridPoint]) -> Vec<GridPoint> {
        let mut kept: Vec<GridPoint> = Vec::with_capacity(contour.len());
        let corner = contour.iter().position(|&point| !self.stock.grid.is_on_border(point)).unwrap_or(0);
        for index in corner..corner + contour.len() {
            let [point, next] = [index, index + 1].map(|index| contour[index % contour.len()]);
            let is_seam = kept.last().is_some_and(|&last| {
                self.stock.grid.is_on_border(point)
                    && distance_to_segment(&placed(point), &placed(last), &placed(next)) < FARTHEST_MM
            });
            if !is_seam {
                kept.push(point);
            }
        }
        kept
    }

    /// What of an edge of the stock is surface.
    fn surface_of(&self, edge: [GridPoint; 2]) -> Option<[Point2; 2]> {
        let [a, b] = edge.map(placed);
        let width = self.stock.grid.blank().high.x;
        let is_side = edge.iter().all(|p| p.x == 0) || edge.iter().all(|p| p.x == width);
        if edge.iter().all(|p| p.y == 0) {
            return None;
        }
        if !is_side {
            return Some([a, b]);
        }
        let top = self.profile.height(a.x);
        let raised = [a, b].map(|p| Point2::new(p.x, p.y.max(top)));
        (raised[0] != raised[1]).then_some(raised)
    }

    fn scallop_of(&self, surface: &[Vec<Point2>]) -> Option<Farthest> {
        let mut best = None;
        for pair in surface.iter().flat_map(|line| line.windows(2)) {
            self.profile.farthest_above(&pair[0], &pair[1], &mut best);
        }
        best
    }

    fn stuck(&self) -> Vec<Point2> {
        let mut stuck: Vec<_> = self.tips.values().filter(|tip| self.is_stuck(tip)).collect();
        stuck.sort_unstable_by_key(|tip| tip.first_cut);
        stuck.into_iter().map(|tip| tip.place).collect()
    }

    /// Whether there is stock between the arms of a tip, twice as far up as their slits overlap.
    fn is_stuck(&self, tip: &CutTip) -> bool {
        let [Some(left), Some(right)] = tip.swings else { return false };
        let (half, lean) = ((left + right) / 2.0, (right - left) / 2.0);
        let up = KERF_MM / half.sin();
        // Arms that overlap all along have no chip between them.
        if half <= 0.0 || up > tip.shortest_reach {
            return false;
        }
        let inside = Point2::new(tip.place.x + lean.sin() * up, tip.place.y + lean.cos() * up);
        !self.is_air(&inside)
    }
}

/// A tip that was cut.
#[derive(Debug, Clone)]
pub(super) struct CutTip {
    pub place: Point2,
    pub first_cut: usize,
    /// The swing of its left and of its right arm in rad, where they are cut.
    pub swings: [Option<f64>; 2],
    /// d of its shorter arm, in mm.
    pub shortest_reach: f64,
}

/// An area from twice as many square units.
pub(super) fn square_mm(twice: i128) -> f64 {
    twice as f64 / (2.0 * UNITS * UNITS)
}

/// A line without repeated points and slivers, from left to right; `None` if nothing is left of it.
fn left_to_right(mut line: Vec<Point2>) -> Option<Vec<Point2>> {
    line.dedup_by(|next, last| (*next - *last).norm() <= SAME_POINT_MM);
    let (first, last) = (line.first()?, line.last()?);
    if line.len() < 2 {
        return None;
    }
    let is_loop = first == last;
    if is_loop && signed_area(&line).abs() < SLIVER_MM2 {
        return None;
    }
    if first.x > last.x || is_loop {
        line.reverse();
    }
    Some(line)
}
