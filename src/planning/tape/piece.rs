//! Pieces: the developed ply within the strip of one tape (domain.md A4).
//!
//! Clipping is done in `f64` on the outline's own points and every side of a piece keeps what it is: a cut, or
//! the tape's own edge. The published Edge0 and Edge1 are the ends of a cut, exactly at half the tape width.

use super::developed::{Developed, DevelopedLoop, DevelopedPly};
use super::excess::{changes, side_by_side};
use crate::planning::finding::{Code, Finding};
use crate::planning::geometry::Point2;
use crate::planning::geometry::polygon::{contains, signed_area};
use crate::planning::tolerance::{SAME_POINT_MM, STRIP_EDGE_MM};

/// A piece of tape in the (u, v) of its course, in mm, its outline counter-clockwise.
#[derive(Debug, Clone, PartialEq)]
pub struct Piece {
    /// The sides of the outline in order. A closed outline that meets no tape edge is one cut whose last point
    /// repeats its first.
    pub sides: Vec<Side>,
    /// Cut-outs that lie wholly inside, clockwise, each closed by its first point.
    pub holes: Vec<Vec<Point2>>,
    /// Area of the outline less its cut-outs, in mm^2.
    pub area_mm2: f64,
}

/// A side of a piece.
#[derive(Debug, Clone, PartialEq)]
pub enum Side {
    /// A part of the ply's outline; a knife makes it.
    Cut(Vec<Point2>),
    /// A part of the tape's own edge, from one point to another.
    TapeEdge(Point2, Point2),
}

impl Piece {
    /// The cuts of the piece: open ones from tape edge to tape edge, closed ones with their first point repeated.
    pub fn cuts(&self) -> impl Iterator<Item = &[Point2]> {
        let sides = self.sides.iter().filter_map(|side| match side {
            Side::Cut(points) => Some(points.as_slice()),
            Side::TapeEdge(..) => None,
        });
        sides.chain(self.holes.iter().map(Vec::as_slice))
    }

    /// The outline as one loop, without its cut-outs.
    #[must_use]
    pub fn outline(&self) -> Vec<Point2> {
        let mut points: Vec<Point2> = Vec::new();
        for side in &self.sides {
            if let Side::Cut(cut) = side {
                points.extend(cut);
            }
        }
        points.dedup();
        if points.len() > 1 && points.first() == points.last() {
            points.pop();
        }
        points
    }

    /// Changes the ends that more than `knives` knives would be needed for, on their scrap side: returns the piece as it
    /// was, the largest deviation in mm and the extra area in mm^2, or `None` if nothing was changed.
    pub fn simplify(&mut self, half_width_mm: f64, knives: usize) -> Option<(Self, (f64, f64))> {
        if side_by_side(self.cuts(), half_width_mm) <= knives {
            return None;
        }
        let given = self.clone();
        let cuts = given.sides.iter().zip(&mut self.sides).filter_map(|(given, side)| match (given, side) {
            (Side::Cut(points), Side::Cut(changed)) => Some((points.as_slice(), changed)),
            _ => None,
        });
        let (cuts, changed): (Vec<_>, Vec<_>) = cuts.unzip();
        let mut change: Option<(f64, f64)> = None;
        for (changed, simple) in changed.into_iter().zip(changes(&cuts, &given.holes, half_width_mm, knives))
        {
            let Some(simple) = simple else { continue };
            let (deviation, area) = change.unwrap_or((0.0, 0.0));
            change = Some((deviation.max(simple.max_deviation_mm), area + simple.extra_area_mm2));
            *changed = simple.points;
        }
        self.area_mm2 += change.map_or(0.0, |(_, area)| area);
        self.mend_tape_edges();
        change.map(|change| (given, change))
    }

    /// Lets the tape's edges run from the end of the cut before them to the start of the next.
    fn mend_tape_edges(&mut self) {
        let count = self.sides.len();
        for index in 0..count {
            let before = match &self.sides[(index + count - 1) % count] {
                Side::Cut(points) => points.last().copied(),
                Side::TapeEdge(..) => None,
            };
            let after = match &self.sides[(index + 1) % count] {
                Side::Cut(points) => points.first().copied(),
                Side::TapeEdge(..) => None,
            };
            if let (Side::TapeEdge(from, to), Some(before), Some(after)) =
                (&mut self.sides[index], before, after)
            {
                (*from, *to) = (before, after);
            }
        }
    }

    /// Smallest and largest u of the piece.
    #[must_use]
    pub fn u_range(&self) -> (f64, f64) {
        let cuts = self.cuts().flatten().map(|point| point.x);
        cuts.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), u| (low.min(u), high.max(u)))
    }
}

/// The pieces of a ply within the strip `|v| <= width / 2`, in order of their smallest u.
///
/// The outlines of `ply` may turn either way; their first point is not repeated.
///
/// # Errors
/// `OutlineCrosses` if the outlines do not close within the strip, `OffMould` if one leaves this part of the
/// mould within the strip.
pub fn within_strip(ply: &DevelopedPly, width_mm: f64) -> Result<Vec<Piece>, Finding> {
    let half = width_mm / 2.0;
    let mut strip = Strip { half, inside: Vec::new() };
    let boundary =
        strip.take(&ply.boundary, Filled::Within).map_err(|fault| fault.finding("/input/boundary/points"))?;
    let mut inner = Vec::new();
    for (index, hole) in ply.holes.iter().enumerate() {
        let at = format!("/input/holes/{index}/points");
        let whole = strip.take(hole, Filled::Without).map_err(|fault| fault.finding(&at))?;
        inner.extend(whole.map(|points| (index, points)));
    }
    let mut outlines = strip.link()?;
    outlines.extend(boundary.map(|points| vec![Side::Cut(closed(points))]));
    let mut pieces: Vec<Piece> =
        outlines.into_iter().map(|sides| Piece { sides, holes: Vec::new(), area_mm2: 0.0 }).collect();
    give_holes(&mut pieces, inner)?;
    pieces.sort_by(|a, b| a.u_range().0.total_cmp(&b.u_range().0));
    Ok(pieces)
}

/// On which side of a loop the ply lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Filled {
    /// The boundary.
    Within,
    /// A cut-out.
    Without,
}

/// An outline that leaves this part of the mould within the strip, at this point of it.
struct LeavesMould(usize);

impl LeavesMould {
    fn finding(&self, at: &str) -> Finding {
        let message = "within the tape the outline goes to where it cannot be developed: too far off the course's \
                       plane, or too far beyond the ends of the course. Let the course reach to the ply's edge, and \
                       give the outline at close intervals";
        Finding::error(Code::OffMould, format!("{at}/{}", self.0), message)
    }
}

/// A loop that is wholly inside, turned so that the ply lies on its left.
fn oriented(mut points: Vec<Point2>, filled: Filled) -> Vec<Point2> {
    if (signed_area(&points) > 0.0) != (filled == Filled::Within) {
        points.reverse();
    }
    points
}

fn closed(mut points: Vec<Point2>) -> Vec<Point2> {
    points.push(points[0]);
    points
}

/// Gives each piece the cut-outs that lie wholly inside it, which come with their places in the ply.
fn give_holes(pieces: &mut [Piece], holes: Vec<(usize, Vec<Point2>)>) -> Result<(), Finding> {
    let outlines: Vec<_> = pieces.iter().map(Piece::outline).collect();
    for (place, hole) in holes {
        let Some(index) = outlines.iter().position(|outline| contains(outline, &hole[0])) else {
            let message = "the cut-out lies outside the ply or crosses its outline";
            return Err(Finding::error(Code::HoleOutside, format!("/input/holes/{place}"), message));
        };
        pieces[index].holes.push(closed(hole));
    }
    for (piece, outline) in pieces.iter_mut().zip(&outlines) {
        let holes: f64 = piece.holes.iter().map(|hole| signed_area(hole)).sum();
        piece.area_mm2 = signed_area(outline) + holes;
    }
    Ok(())
}

/// An edge of the strip.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Edge {
    /// v = +half.
    Top,
    /// v = -half.
    Bottom,
}

/// A part of a loop inside the strip, from the edge where it enters to the edge where it leaves.
struct Inside {
    points: Vec<Point2>,
    enters: Edge,
    leaves: Edge,
}

impl Inside {
    fn reverse(&mut self) {
        self.points.reverse();
        std::mem::swap(&mut self.enters, &mut self.leaves);
    }
}

/// Whether, in +u, the first crossing of an edge of the strip leads into what is on the left of the loop: an
/// entry over the top edge, an exit over the bottom edge.
///
/// Where a corner only touches an edge, an entry and an exit fall on one point and say nothing.
fn first_crossing_leads_in(parts: &[Inside]) -> bool {
    let first = [Edge::Top, Edge::Bottom].into_iter().filter_map(|edge| first_net_crossing(parts, edge));
    let first = first.min_by(|a, b| a.0.total_cmp(&b.0));
    first.is_none_or(|(_, edge, entry)| entry == (edge == Edge::Top))
}

/// The first place at which more enter over an edge than leave over it, or the other way round.
fn first_net_crossing(parts: &[Inside], edge: Edge) -> Option<(f64, Edge, bool)> {
    let entries = parts.iter().filter(|part| part.enters == edge).map(|part| (part.points[0].x, 1));
    let exits = parts.iter().filter(|part| part.leaves == edge);
    let exits = exits.map(|part| (part.points[part.points.len() - 1].x, -1));
    let mut crossings: Vec<(f64, i32)> = entries.chain(exits).collect();
    crossings.sort_by(|a, b| a.0.total_cmp(&b.0));
    let places = crossings.chunk_by(|a, b| b.0 - a.0 <= SAME_POINT_MM);
    let mut net = places.map(|place| (place[0].0, place.iter().map(|crossing| crossing.1).sum::<i32>()));
    net.find(|(_, sum)| *sum != 0).map(|(u, sum)| (u, edge, sum > 0))
}

/// The strip of a tape with what lies in it.
struct Strip {
    half: f64,
    inside: Vec<Inside>,
}

impl Strip {
    /// Cuts a loop at the edges of the strip and keeps what is inside, ply on its left. A loop that meets no edge is
    /// returned as it is.
    ///
    /// A point on an edge counts as outside: the strip is open, as if it were narrower by an infinitely small
    /// amount. An outline that runs along an edge is then the tape's own edge and no cut, and every crossing
    /// has a partner. A point on another part of the mould is outside too.
    fn take(&mut self, outline: &DevelopedLoop, filled: Filled) -> Result<Option<Vec<Point2>>, LeavesMould> {
        let mut points = outline.places.clone();
        for point in points.iter_mut().flatten() {
            point.y = self.snapped(point.y);
        }
        let Some(start) = points.iter().position(|point| self.is_outside(point)) else {
            let whole = points.into_iter().flatten().collect();
            return Ok(Some(oriented(whole, filled)));
        };
        let mut parts =
            self.parts(&points, start).map_err(|LeavesMould(at)| LeavesMould(outline.indices[at]))?;
        if self.turns_wrong(&points, &parts, filled) {
            parts.iter_mut().for_each(Inside::reverse);
        }
        self.inside.extend(parts);
        Ok(None)
    }

    /// The parts of a loop inside the strip; the walk begins at a point outside.
    fn parts(&self, points: &[Developed], start: usize) -> Result<Vec<Inside>, LeavesMould> {
        let mut parts = Vec::new();
        let mut current: Option<(Edge, Vec<Point2>)> = None;
        for step in 0..points.len() {
            let (from, to) = ((start + step) % points.len(), (start + step + 1) % points.len());
            let (a, b) = match (points[from], points[to]) {
                (Some(a), Some(b)) => (a, b),
                (Some(a), None) | (None, Some(a)) if self.side(&a).is_none() => {
                    return Err(LeavesMould(from));
                }
                _ => continue,
            };
            if let Some(edge) = self.entry(&a, &b) {
                current = Some((edge, vec![self.crossing(&a, &b, edge)]));
            }
            let Some((enters, part)) = current.as_mut() else { continue };
            match self.exit(&a, &b) {
                Some(leaves) => {
                    push_new(part, self.crossing(&a, &b, leaves));
                    parts.push(Inside { points: std::mem::take(part), enters: *enters, leaves });
                    current = None;
                }
                None => push_new(part, b),
            }
        }
        Ok(parts)
    }

    /// Whether a loop turns so that the ply lies on its right. Of a loop that is known as a whole the area tells;
    /// else the first crossing of an edge in +u does, which must lead into the ply (out of it for a cut-out).
    fn turns_wrong(&self, points: &[Developed], parts: &[Inside], filled: Filled) -> bool {
        let whole: Option<Vec<Point2>> = points.iter().copied().collect();
        let ply_is_left = match whole {
            Some(whole) => signed_area(&whole) >= 0.0,
            None => first_crossing_leads_in(parts),
        };
        ply_is_left != (filled == Filled::Within)
    }

    fn is_outside(&self, point: &Developed) -> bool {
        point.is_none_or(|point| self.side(&point).is_some())
    }

    fn snapped(&self, v: f64) -> f64 {
        if (v.abs() - self.half).abs() <= STRIP_EDGE_MM { self.half.copysign(v) } else { v }
    }

    /// On which side of the strip a point lies, if it is outside.
    fn side(&self, point: &Point2) -> Option<Edge> {
        if point.y >= self.half {
            Some(Edge::Top)
        } else if point.y <= -self.half {
            Some(Edge::Bottom)
        } else {
            None
        }
    }

    /// The edge over which the segment enters the strip.
    fn entry(&self, a: &Point2, b: &Point2) -> Option<Edge> {
        let from = self.side(a)?;
        (self.side(b) != Some(from)).then_some(from)
    }

    /// The edge over which the segment leaves the strip.
    fn exit(&self, a: &Point2, b: &Point2) -> Option<Edge> {
        let to = self.side(b)?;
        (self.side(a) != Some(to)).then_some(to)
    }

    /// Where a segment crosses an edge; its v is exactly that of the edge.
    fn crossing(&self, a: &Point2, b: &Point2, edge: Edge) -> Point2 {
        let v = self.level(edge);
        if a.y == v {
            return *a;
        }
        if b.y == v {
            return *b;
        }
        Point2::new(a.x + (v - a.y) / (b.y - a.y) * (b.x - a.x), v)
    }

    fn level(&self, edge: Edge) -> f64 {
        match edge {
            Edge::Top => self.half,
            Edge::Bottom => -self.half,
        }
    }

    /// Links the parts inside the strip to closed outlines along the tape's edges.
    fn link(&self) -> Result<Vec<Vec<Side>>, Finding> {
        let mut next = vec![usize::MAX; self.inside.len()];
        self.link_edge(Edge::Top, &mut next)?;
        self.link_edge(Edge::Bottom, &mut next)?;
        let mut outlines = Vec::new();
        let mut used = vec![false; self.inside.len()];
        for first in 0..self.inside.len() {
            if used[first] {
                continue;
            }
            let mut sides = Vec::new();
            let mut part = first;
            while !used[part] {
                used[part] = true;
                let follower = next[part];
                let points = &self.inside[part].points;
                sides.push(Side::Cut(points.clone()));
                sides.push(Side::TapeEdge(points[points.len() - 1], self.inside[follower].points[0]));
                part = follower;
            }
            outlines.push(sides);
        }
        Ok(outlines)
    }

    /// Pairs the crossings of one edge. With the ply on the left of every loop, an interval of the top edge that
    /// lies in the ply begins, in +u, where a loop enters the strip and ends where one leaves it; on the bottom
    /// edge it is the other way round. The piece's outline runs from where a part leaves to where one enters.
    fn link_edge(&self, edge: Edge, next: &mut [usize]) -> Result<(), Finding> {
        let mut crossings: Vec<(f64, bool, usize)> = Vec::new();
        for (index, part) in self.inside.iter().enumerate() {
            if part.enters == edge {
                crossings.push((part.points[0].x, true, index));
            }
            if part.leaves == edge {
                crossings.push((part.points[part.points.len() - 1].x, false, index));
            }
        }
        crossings.sort_by(|a, b| a.0.total_cmp(&b.0));
        let begins_with_entry = edge == Edge::Top;
        alternate(&mut crossings, begins_with_entry)?;
        for pair in crossings.chunks_exact(2) {
            let (entry, exit) =
                if begins_with_entry { (pair[0].2, pair[1].2) } else { (pair[1].2, pair[0].2) };
            next[exit] = entry;
        }
        Ok(())
    }
}

/// Brings crossings that share a place into the order in which entries and exits alternate: at a corner that
/// only touches the edge, an exit and an entry fall on one point and no sorting by u can tell them apart.
fn alternate(crossings: &mut [(f64, bool, usize)], begins_with_entry: bool) -> Result<(), Finding> {
    for index in 0..crossings.len() {
        let wanted = (index % 2 == 0) == begins_with_entry;
        let here = crossings[index].0;
        let fitting = crossings[index..]
            .iter()
            .take_while(|crossing| crossing.0 - here <= SAME_POINT_MM)
            .position(|crossing| crossing.1 == wanted)
            .map(|ahead| index + ahead);
        match fitting {
            Some(other) => crossings.swap(index, other),
            None => return Err(unpaired(here)),
        }
    }
    if crossings.len() % 2 == 1 {
        return Err(unpaired(crossings[crossings.len() - 1].0));
    }
    Ok(())
}

fn unpaired(u: f64) -> Finding {
    let message =
        format!("the outlines do not close on the tape's edge at u {u:.3} mm: they cross or touch there");
    Finding::error(Code::OutlineCrosses, "/input/boundary/points", message)
}

fn push_new(points: &mut Vec<Point2>, point: Point2) {
    if points.last() != Some(&point) {
        points.push(point);
    }
}

#[cfg(test)]
mod tests;
