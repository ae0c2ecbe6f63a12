//! What can be looked at only after development: of courses on a curved mould, and of such as are curved themselves.
//!
//! An outline in a plane is checked as a whole before (`outline`); one on a mould has no plane, so each course is checked
//! for what of it lies within its tape.

use super::developed::{DevelopedPly, OnMould};
use super::foot::CONTINUED_WIDTHS;
use super::input::{Course, Ply};
use super::piece::Piece;
use crate::planning::finding::{Code, Finding};
use crate::planning::geometry::crossing::first_crossing_where;
use crate::planning::geometry::polygon::{contains, nested};
use crate::planning::geometry::{Point2, Point3};
use crate::planning::tolerance::{CHORD_MM, SAME_POINT_MM, STEERED_STRAIN};

/// Beyond the ends of a course so many tape widths are continued to about a hundredth of a millimetre, on cylinders and cones of
/// R 800 and more.
const CONTINUED_WELL_WIDTHS: f64 = 1.0;

/// A fault of the outlines within the tape of a course, with the course's name and in its ply's place.
#[must_use]
pub fn named(fault: Finding, course: &Course, developed: &DevelopedPly) -> Finding {
    let at = fault
        .at
        .strip_prefix("/input")
        .map_or(fault.at.clone(), |within| format!("{}{within}", course.place.ply));
    let ends = match developed.on_mould {
        Some(_) if fault.code == Code::OutlineCrosses => {
            ", or the course ends farther before the outline than it can be continued; let it reach to the ply's edge"
        }
        _ => "",
    };
    let message = format!("course {}: {}{ends}", course.label, fault.message);
    Finding { at, message, ..fault }
}

/// Checks the pieces of a course.
///
/// # Errors
/// `OutlineCrosses` if outlines cross within the tape, `HoleOutside` if a cut-out lies in another, `OffMould` if the course
/// ends so far inside the ply that nothing is known of it.
pub fn check(
    course: &Course,
    ply: &Ply,
    on_mould: &OnMould,
    pieces: &[Piece],
    width_mm: f64,
) -> Result<Vec<Finding>, Finding> {
    if pieces.is_empty() && lies_within(course, ply) {
        let message = format!(
            "course {}: it lies within the ply and ends more than {} mm before the outline, farther than it can be continued; \
             let it reach to the ply's edge",
            course.label,
            CONTINUED_WIDTHS * width_mm
        );
        return Err(Finding::error(Code::OffMould, course.place.to_string(), message));
    }
    crossings(course, pieces, width_mm)?;
    not_nested(course, pieces)?;
    let at = || course.place.to_string();
    let warning =
        |code, message: String| Finding::warning(code, at(), format!("course {}: {message}", course.label));
    let coarse = (on_mould.between_mm > CHORD_MM).then(|| {
        let longest =
            course.points.windows(2).map(|pair| (pair[1] - pair[0]).norm()).fold(0.0, f64::max);
        let message = format!(
            "its points are up to {longest:.1} mm apart, too far for how the mould turns between them: places may be off by \
             up to about {:.2} mm. Give points at closer intervals",
            on_mould.between_mm
        );
        warning(Code::CoarseCourse, message)
    });
    let beyond = |piece: &Piece| {
        let (low, high) = piece.u_range();
        (-low).max(high - on_mould.length_mm)
    };
    let farthest = pieces.iter().map(beyond).fold(0.0, f64::max);
    let continued = (farthest > CONTINUED_WELL_WIDTHS * width_mm).then(|| {
        let message = format!(
            "the ply goes on {farthest:.1} mm beyond the end of the course, which is continued there as it bends at its end; \
             farther than the tape is wide that may miss the mould by more than 0.01 mm. Let the course reach to the ply's edge"
        );
        warning(Code::CourseContinued, message)
    });
    let strain = on_mould.steering * width_mm / 2.0;
    let steered = (strain > STEERED_STRAIN).then(|| {
        let message = format!(
            "it bends the tape within its own plane, to a radius of {:.0} mm: its edges would be {:.1} % longer and shorter \
             than its middle. See whether its points and normals are right",
            1.0 / on_mould.steering,
            strain * 100.0
        );
        warning(Code::Steered, message)
    });
    Ok([coarse, continued, steered].into_iter().flatten().collect())
}

/// Whether the middle of a course, seen along its normal, lies within the ply and in no cut-out.
fn lies_within(course: &Course, ply: &Ply) -> bool {
    let middle = course.points.len() / 2;
    let (place, normal) = (course.points[middle], course.normals[middle]);
    let along = course.points[middle] - course.points[middle - 1];
    let along = (along - normal * along.dot(&normal)).normalize();
    let across = normal.cross(&along);
    let seen = |outline: &Vec<Point3>| -> Vec<Point2> {
        let at = |point: &Point3| Point2::new((point - place).dot(&along), (point - place).dot(&across));
        outline.iter().map(at).collect()
    };
    let holds = |outline: &Vec<Point3>| contains(&seen(outline), &Point2::origin());
    holds(&ply.boundary) && !ply.holes.iter().any(holds)
}

/// Outlines that cross within the tape.
fn crossings(course: &Course, pieces: &[Piece], width_mm: f64) -> Result<(), Finding> {
    if pieces.iter().all(is_plain) && apart(pieces.iter().map(Piece::u_range)) {
        return Ok(());
    }
    let open = |hole: &Vec<Point2>| hole[..hole.len() - 1].to_vec();
    let loops: Vec<Vec<Point2>> = pieces
        .iter()
        .flat_map(|piece| std::iter::once(piece.outline()).chain(piece.holes.iter().map(open)))
        .collect();
    // Where corners touch the tape's edge they may touch one another.
    let within = |place: &Point2| place.y.abs() < width_mm / 2.0 - SAME_POINT_MM;
    first_crossing_where(&loops, SAME_POINT_MM, within).map_or(Ok(()), |crossing| {
        let message = format!(
            "course {}: within its tape the outlines cross or touch, near u {:.3} v {:.3} mm",
            course.label, crossing.place.x, crossing.place.y
        );
        Err(Finding::error(Code::OutlineCrosses, course.place.to_string(), message))
    })
}

/// Whether it is seen at once that the outline of a piece crosses nothing: each of its cuts runs one way across the tape, and
/// they lie one behind the other.
fn is_plain(piece: &Piece) -> bool {
    let one_way = |cut: &[Point2]| {
        cut.windows(2).all(|pair| pair[0].y <= pair[1].y) || cut.windows(2).all(|pair| pair[0].y >= pair[1].y)
    };
    let range = |cut: &[Point2]| {
        let us = cut.iter().map(|point| point.x);
        us.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), u| (low.min(u), high.max(u)))
    };
    piece.cuts().all(one_way) && apart(piece.cuts().map(range))
}

/// Whether ranges share nothing.
fn apart(ranges: impl Iterator<Item = (f64, f64)>) -> bool {
    let mut ranges: Vec<(f64, f64)> = ranges.collect();
    ranges.sort_by(|a, b| a.0.total_cmp(&b.0));
    ranges.windows(2).all(|pair| pair[0].1 < pair[1].0)
}

/// A cut-out that lies in another.
fn not_nested(course: &Course, pieces: &[Piece]) -> Result<(), Finding> {
    for piece in pieces {
        let holes: Vec<&[Point2]> = piece.holes.iter().map(|hole| &hole[..hole.len() - 1]).collect();
        if let Some((inner, _)) = nested(&holes) {
            let message = format!(
                "course {}: a cut-out lies inside another, near u {:.3} v {:.3} mm",
                course.label, holes[inner][0].x, holes[inner][0].y
            );
            return Err(Finding::error(Code::HoleOutside, course.place.to_string(), message));
        }
    }
    Ok(())
}
