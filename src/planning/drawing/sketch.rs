//! What can be seen of a plan: its pieces and what the knives do, thinned out to the scale of a drawing.

use super::sheet::DOT_MM;
use crate::planning::geometry::Point2;
use crate::planning::geometry::polygon::edges;
use crate::planning::geometry::simplify::kept;
use crate::planning::program::number::fixed;
use crate::planning::tape::chain::{Chain, Slope};
use crate::planning::tape::input::TapeInput;
use crate::planning::tape::label::CourseLabel;
use crate::planning::tape::machine::CutSide;
use crate::planning::tape::overcut::extend;
use crate::planning::tape::piece::{Piece, Side};
use crate::planning::tape::plan::{PlannedCourse, PlannedPiece, TapePlan};
use crate::planning::tape::stroke::{Knot, Stroke};

/// A piece as it is drawn, in the (u, v) of its course in mm.
#[derive(Debug, Clone, PartialEq)]
pub struct PieceSketch {
    /// What its course is called.
    pub course: CourseLabel,
    /// Which piece of its course it is, from 1 in laying direction, and of how many.
    pub number: (usize, usize),
    /// r - u in mm.
    pub offset_mm: f64,
    /// Smallest and largest u.
    pub u: (f64, f64),
    /// Area in mm^2.
    pub area_mm2: f64,
    /// Its outline, then its cut-outs.
    pub loops: Vec<Vec<Point2>>,
    /// What of its outline is the tape's own edge.
    pub tape_edges: Vec<(Point2, Point2)>,
    /// Its cuts: one entry for each chain of the plan.
    pub cuts: Vec<CutSketch>,
    /// Where its outline was changed: the cuts as the ply has them.
    pub given: Vec<Vec<Point2>>,
    /// Beside each of those, what is left on the scrap side to be trimmed.
    pub trims: Vec<Vec<Point2>>,
    /// How far its outline was changed at the most, in mm, and the area of the trims in mm^2.
    pub simplified: Option<(f64, f64)>,
    /// The published Edge0 and Edge1 of each cut that begins and ends on a tape edge.
    pub edge_points: Vec<EdgePoint>,
}

/// A cut that one knife makes.
#[derive(Debug, Clone, PartialEq)]
pub struct CutSketch {
    /// Its cutter, from 0.
    pub cutter: usize,
    /// `\`, `/` or `-`.
    pub slope: Slope,
    /// (u, v) in mm, u never increasing.
    pub points: Vec<Point2>,
}

/// Where a cut meets the tape's edge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EdgePoint {
    /// `Edge0`, `Edge1`; with a prime at the end of the course, as the papers write them.
    pub name: &'static str,
    /// (u, v) in mm.
    pub at: Point2,
}

/// A place where a knife goes down or comes up, on the roll.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KnifeMark {
    /// Its cutter, from 0.
    pub cutter: usize,
    /// Which stroke of its cutter, from 1 in the order of cutting.
    pub stroke: usize,
    /// Down or up.
    pub down: bool,
    /// (r, v) in mm.
    pub at: Point2,
}

/// The pieces of a plan in increasing roll coordinate, for a drawing in which `scale_denominator` mm are one.
#[must_use]
pub fn pieces(plan: &TapePlan, input: &TapeInput, scale_denominator: f64) -> Vec<PieceSketch> {
    let thin_mm = DOT_MM * scale_denominator;
    plan.order
        .iter()
        .zip(plan.pieces())
        .map(|(&(_, index), (course, planned))| {
            piece(course, index, planned, input.machine.cut_side, thin_mm)
        })
        .collect()
}

fn piece(
    course: &PlannedCourse,
    index: usize,
    planned: &PlannedPiece,
    cut_side: CutSide,
    thin_mm: f64,
) -> PieceSketch {
    let cut = |(chain, cutter): &(Chain, usize)| CutSketch {
        cutter: *cutter,
        slope: chain.slope,
        points: thinned(&chain.points, thin_mm),
    };
    PieceSketch {
        course: course.label,
        number: (index + 1, course.pieces.len()),
        offset_mm: planned.offset_mm,
        u: planned.piece.u_range(),
        area_mm2: planned.piece.area_mm2,
        loops: loops(&planned.piece, thin_mm),
        tape_edges: tape_edges(&planned.piece),
        cuts: planned.chains.iter().map(cut).collect(),
        given: changed(planned).map(|(given, _)| thinned(given, thin_mm)).collect(),
        trims: changed(planned).map(|(given, cut)| trim(given, cut, thin_mm)).collect(),
        simplified: planned.simplified,
        edge_points: edge_points(&planned.piece, cut_side),
    }
}

/// The cuts of a piece whose outline was changed, as the ply has them and as they are made.
fn changed(planned: &PlannedPiece) -> impl Iterator<Item = (&[Point2], &[Point2])> {
    let given = planned.given.iter().flat_map(|given| given.cuts());
    given.zip(planned.piece.cuts()).filter(|(given, cut)| given != cut)
}

/// What lies between a cut as it is made and as the ply has it. Both run from one edge of the tape to the other.
fn trim(given: &[Point2], cut: &[Point2], thin_mm: f64) -> Vec<Point2> {
    let mut around = thinned(cut, thin_mm);
    around.extend(thinned(given, thin_mm).into_iter().rev());
    around
}

fn thinned(points: &[Point2], thin_mm: f64) -> Vec<Point2> {
    kept(points, thin_mm).into_iter().map(|index| points[index]).collect()
}

fn loops(piece: &Piece, thin_mm: f64) -> Vec<Vec<Point2>> {
    let mut outline = Vec::new();
    for side in &piece.sides {
        if let Side::Cut(points) = side {
            outline.extend(thinned(points, thin_mm));
        }
    }
    std::iter::once(outline).chain(piece.holes.iter().map(|hole| thinned(hole, thin_mm))).collect()
}

fn tape_edges(piece: &Piece) -> Vec<(Point2, Point2)> {
    let edges = piece.sides.iter().filter_map(|side| match side {
        Side::TapeEdge(from, to) => Some((*from, *to)),
        Side::Cut(_) => None,
    });
    edges.collect()
}

/// The papers walk the ply's boundary clockwise, seen from the normals' side: from Edge0 to Edge1. Seen in
/// (u, v) that is clockwise where the knives work on the film, because then W = +N, and the other way round
/// on the paper (domain.md A3). A piece's own outline is counter-clockwise.
fn edge_points(piece: &Piece, cut_side: CutSide) -> Vec<EdgePoint> {
    let mut found = Vec::new();
    for side in &piece.sides {
        let Side::Cut(points) = side else { continue };
        let (Some(&first), Some(&last)) = (points.first(), points.last()) else { continue };
        if first == last {
            continue;
        }
        // Counter-clockwise, the end of a course is cut in +V.
        let names = if first.y < last.y { ["Edge0'", "Edge1'"] } else { ["Edge0", "Edge1"] };
        let ends = match cut_side {
            CutSide::Film => [last, first],
            CutSide::Paper => [first, last],
        };
        found.extend(names.into_iter().zip(ends).map(|(name, at)| EdgePoint { name, at }));
    }
    found
}

/// What the knives do on the roll beyond making cuts.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct KnifeWork {
    /// Where they go down and come up, in the order of cutting, cutter by cutter.
    pub marks: Vec<KnifeMark>,
    /// Ends of cuts that go on, by their cutter from 0: from the end of a cut to where the knife is.
    pub overcuts: Vec<(usize, [Point2; 2])>,
}

/// Where the knives go down and come up, and how far that is beyond the cuts: what the program does.
#[must_use]
pub fn knife_work(plan: &TapePlan, input: &TapeInput) -> KnifeWork {
    let wanted = plan.strokes(input);
    let mut made = wanted.clone();
    extend(&mut made, plan, &input.machine);
    let mut work = KnifeWork::default();
    for (cutter, (made, wanted)) in made.iter().zip(&wanted).enumerate() {
        let r_of_x0 = plan.figures.lead_mm + input.machine.cutters[cutter].station.mm();
        let place = |knot: &Knot| Point2::new(r_of_x0 - knot.x, knot.v);
        for (index, (made, wanted)) in made.iter().zip(wanted).enumerate() {
            let ends = |stroke: &Stroke| [stroke.knots.first().map(place), stroke.knots.last().map(place)];
            for (down, (at, of_cut)) in
                [true, false].into_iter().zip(ends(made).into_iter().zip(ends(wanted)))
            {
                let Some((at, of_cut)) = at.zip(of_cut) else { continue };
                work.marks.push(KnifeMark { cutter, stroke: index + 1, down, at });
                if at != of_cut {
                    work.overcuts.push((cutter, [of_cut, at]));
                }
            }
        }
    }
    work
}

impl PieceSketch {
    /// `3`, or `3.2` for the second piece of a course with several; `2/3` for course 3 of ply 2.
    #[must_use]
    pub fn label(&self) -> String {
        self.with_piece(self.course.short())
    }

    /// What a browser shows when the pointer rests on the piece: `course 3.2`, `course 3.2 of ply 2`.
    #[must_use]
    pub fn title(&self) -> String {
        let of_ply = self.course.ply.map_or(String::new(), |ply| format!(" of ply {ply}"));
        format!("course {}{of_ply}", self.with_piece(self.course.number.to_string()))
    }

    fn with_piece(&self, course: String) -> String {
        let (number, of) = self.number;
        if of > 1 { format!("{course}.{number}") } else { course }
    }

    /// The longest stretch of u, between `low` and `high`, in which the piece is crossed by a line along the tape:
    /// the centre line, or the one through its middle if that crosses it for a quarter longer. With the
    /// line's v.
    #[must_use]
    pub fn longest_stretch(&self, (low, high): (f64, f64)) -> Option<(f64, (f64, f64))> {
        let of_line = |v: f64| {
            let within = |(from, to): (f64, f64)| (from.clamp(low, high), to.clamp(low, high));
            let stretches = self.stretches(v).into_iter().map(within).filter(|(from, to)| from < to);
            let longest = stretches.max_by(|one, other| (one.1 - one.0).total_cmp(&(other.1 - other.0)))?;
            Some((v, longest))
        };
        let length = |line: &Option<(f64, (f64, f64))>| line.map_or(0.0, |(_, (from, to))| to - from);
        let (centre, middle) = (of_line(0.0), of_line(self.middle_v()));
        if length(&middle) > 1.25 * length(&centre) { middle } else { centre }
    }

    /// The stretches of u in which the line at v runs in the piece.
    fn stretches(&self, v: f64) -> Vec<(f64, f64)> {
        let crossed =
            self.loops.iter().flat_map(|points| edges(points)).filter(|(a, b)| (a.y > v) != (b.y > v));
        let mut crossings: Vec<f64> =
            crossed.map(|(a, b)| a.x + (v - a.y) / (b.y - a.y) * (b.x - a.x)).collect();
        crossings.sort_by(f64::total_cmp);
        crossings.chunks_exact(2).map(|pair| (pair[0], pair[1])).collect()
    }

    fn middle_v(&self) -> f64 {
        let v = self.loops.iter().flatten().map(|point| point.y);
        let (low, high) = v.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
        f64::midpoint(low, high)
    }
}

impl CutSketch {
    /// Smallest and largest u.
    #[must_use]
    pub fn u_range(&self) -> (f64, f64) {
        (self.points[self.points.len() - 1].x, self.points[0].x)
    }

    /// What a browser shows when the pointer rests on the cut; `shift` is added to its u.
    #[must_use]
    pub fn title(&self, axis: char, shift: f64) -> String {
        let slope = match self.slope {
            Slope::Falling => "\\",
            Slope::Flat => "-",
            Slope::Rising => "/",
        };
        let (low, high) = self.u_range();
        let (from, to) = (fixed(high + shift, 2), fixed(low + shift, 2));
        format!("cutter {}, {slope}, {axis} {from} to {to} mm", self.cutter + 1)
    }
}
