//! Courses generated for a flat ply: straight strips of tape side by side (domain.md A2).
//!
//! The ply's upper side, where z grows, is the normals' side. Seen from there the angle is measured counter-clockwise from
//! the x axis (in a tilted plane: from what of the x axis lies in it), U runs along the angle and V = N x U to the left
//! of it. The strips lie at `v = smallest v of the ply + offset + k (width + gap)` for whole k: with no offset the first
//! tape begins where the ply does. They are laid toward +V, each from its smallest u to its largest.

use super::input::Course;
use super::label::PlyPlace;
use super::outline::{Loop, Plane};
use super::wire::{self, MOST_LOOPS};
use crate::planning::finding::{Code, Finding};
use crate::planning::geometry::polygon::edges;
use crate::planning::geometry::{Point2, Point3, Vector3};
use crate::planning::tolerance::{STRIP_EDGE_MM, UPRIGHT_COSINE};
use crate::planning::units::Length;

/// Tapes advance by this share of their width at least. Where they overlapped by more, three would lie on each other.
const LEAST_PITCH: f64 = 0.5;

/// The courses of a rule for a ply, numbered from 1 in laying order. Strips that miss the ply are left out.
///
/// Each course begins and ends with the ply within its strip, so that it runs over the whole length of its piece.
///
/// # Errors
/// `NotFlat` for a ply that does not lie in one plane, or in one that stands upright; `OutOfRange` for tapes that do not
/// advance, or more courses than a ply may have.
pub fn generate(
    rule: &wire::Courses,
    width: Length,
    ply: PlyPlace,
    boundary: &Loop,
    holes: &[Loop],
) -> Result<Vec<Course>, Finding> {
    let at = format!("{ply}/courses");
    let frame = Frame::of(rule, &at, boundary, holes)?;
    let outline: Vec<Point2> = boundary.iter().map(|point| frame.flatten(point)).collect();
    let strips = strips(rule, &at, width.mm(), &outline)?;
    let extents = extents(&outline, &strips);
    let drawn = strips.low.iter().zip(extents).filter(|(_, (first, last))| first < last);
    Ok(drawn
        .enumerate()
        .map(|(index, (low, (first, last)))| {
            let v = low + strips.width / 2.0;
            Course {
                label: ply.label(index as u32 + 1),
                place: ply.course(index),
                points: [first, last].map(|u| frame.place(u, v)).to_vec(),
                normals: vec![frame.normal; 2],
            }
        })
        .collect())
}

/// The plane of a ply with U along its courses.
struct Frame {
    origin: Point3,
    u: Vector3,
    v: Vector3,
    normal: Vector3,
}

impl Frame {
    fn of(rule: &wire::Courses, at: &str, boundary: &Loop, holes: &[Loop]) -> Result<Self, Finding> {
        let flat = Plane::of(boundary)
            .filter(|plane| plane.holds(boundary) && holes.iter().all(|hole| plane.holds(hole)));
        let Some(plane) = flat else {
            let message = "courses are generated for flat plies only, and this one is not: send tracks";
            return Err(Finding::error(Code::NotFlat, at, message));
        };
        if plane.normal.z.abs() < UPRIGHT_COSINE {
            let message =
                "the ply stands upright, so that neither of its sides is the upper one: send tracks";
            return Err(Finding::error(Code::NotFlat, at, message));
        }
        let normal = plane.normal * plane.normal.z.signum();
        let x = (Vector3::x() - normal * normal.x).normalize();
        let (sin, cos) = rule.angle_deg.to_radians().sin_cos();
        let u = x * cos + normal.cross(&x) * sin;
        Ok(Self { origin: plane.origin, u, v: normal.cross(&u), normal })
    }

    fn flatten(&self, point: &Point3) -> Point2 {
        let from_origin = point - self.origin;
        Point2::new(from_origin.dot(&self.u), from_origin.dot(&self.v))
    }

    fn place(&self, u: f64, v: f64) -> Point3 {
        self.origin + self.u * u + self.v * v
    }
}

/// Strips side by side: the lower edge of each, rising, and their common width.
struct Strips {
    low: Vec<f64>,
    width: f64,
    pitch: f64,
}

/// The strips that a ply lies in. Where tapes overlap, none is laid that adds nothing.
fn strips(rule: &wire::Courses, at: &str, width: f64, outline: &[Point2]) -> Result<Strips, Finding> {
    let across = outline.iter().map(|point| point.y);
    let (least, most) =
        across.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    let pitch = width + rule.gap_mm;
    if pitch < width * LEAST_PITCH || (most - least) / pitch > MOST_LOOPS as f64 {
        let message = format!(
            "a gap of {} mm advances by {pitch} mm from tape to tape on a ply {:.3} mm across; tapes may overlap by half \
             of their width, and there may be {MOST_LOOPS} courses",
            rule.gap_mm,
            most - least
        );
        return Err(Finding::error(Code::OutOfRange, format!("{at}/gap_mm"), message));
    }
    let datum = least + rule.offset_mm;
    // The last strip that begins no later than the ply.
    let first = ((least + STRIP_EDGE_MM - datum) / pitch).floor();
    let edge = |index: usize| datum + (first + index as f64) * pitch;
    let mut low = Vec::new();
    for index in 0.. {
        let begin = edge(index);
        if begin >= most - STRIP_EDGE_MM {
            break;
        }
        if begin + width > least + STRIP_EDGE_MM {
            low.push(begin);
        }
        if begin + width >= most - STRIP_EDGE_MM {
            break;
        }
    }
    Ok(Strips { low, width, pitch })
}

/// The smallest and the largest u of the ply in each strip. The work is proportional to the edges and the strips that
/// they pass through.
fn extents(outline: &[Point2], strips: &Strips) -> Vec<(f64, f64)> {
    let mut extents = vec![(f64::INFINITY, f64::NEG_INFINITY); strips.low.len()];
    let Some(first) = strips.low.first() else { return extents };
    for (a, b) in edges(outline) {
        let (low, high) = (a.y.min(b.y), a.y.max(b.y));
        let from = ((low - first - strips.width) / strips.pitch).floor().max(0.0) as usize;
        let to = ((high - first) / strips.pitch).ceil().max(0.0) as usize;
        let passed = strips.low.iter().zip(&mut extents).take(to + 1).skip(from);
        for (&begin, extent) in passed {
            let end = begin + strips.width;
            // What only touches the strip's edge lies in the next one.
            if high > begin + STRIP_EDGE_MM && low < end - STRIP_EDGE_MM {
                let along = [a, b].map(|corner| u_at(a, b, corner, corner.y.clamp(begin, end)));
                *extent = (extent.0.min(along[0].min(along[1])), extent.1.max(along[0].max(along[1])));
            }
        }
    }
    extents
}

/// The u of an edge where it is cut back from a corner to some v; at the corner itself, to the last bit.
fn u_at(a: &Point2, b: &Point2, corner: &Point2, v: f64) -> f64 {
    if v == corner.y { corner.x } else { a.x + (b.x - a.x) * ((v - a.y) / (b.y - a.y)) }
}

#[cfg(test)]
mod tests;
