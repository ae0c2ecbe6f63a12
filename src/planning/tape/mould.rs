//! What can be looked at only after development: of courses on a curved mould, and of such as are curved themselves.
//!
//! An outline in a plane is checked as a whole before (`outline`); one on a mould has no plane, so each course is checked
//! for what of it lies within its tape.

use super::developed::{DevelopedPly, OnMould};
use super::foot::CONTINUED_WIDTHS;
use super::input::{Course, Ply};
use super::piece::Piece;
use crate::planning::finding::{Code, Finding, Severity};
use crate::planning::geometry::crossing::{Path, any_crossing};
use crate::planning::geometry::polygon::{contains, nested};
use crate::planning::geometry::{Point2, Point3};
use crate::planning::tolerance::{CHORD_MM, SAME_POINT_MM};

/// Beyond its ends a course is continued by this share of its own length to a few hundredths of a millimetre if its points
/// have three decimals, and by so many tape widths, on cylinders and cones of R 800 and more.
const CONTINUED_WELL_SHARE: f64 = 0.5;
const CONTINUED_WELL_WIDTHS: f64 = 1.0;

/// Where places may be off by more than this, in mm, no program can be said to cut what is wanted.
const COARSEST_MM: f64 = 1.0;

/// A fault of the outlines within the tape of a course, with the course's name and in its ply's place; or that the course
/// ends inside the ply, where that is the reason.
#[must_use]
pub fn named(fault: Finding, course: &Course, ply: &Ply, developed: &DevelopedPly, width_mm: f64) -> Finding {
    let last = course.points.len() - 1;
    let open = developed.on_mould.is_some() && matches!(fault.code, Code::OutlineCrosses | Code::HoleOutside);
    let inside = [0, last].map(|end| open && lies_within(course, ply, end, width_mm));
    match inside {
        [true, true] => return ends_inside(course, width_mm, None),
        [true, false] => return ends_inside(course, width_mm, Some(0)),
        [false, true] => return ends_inside(course, width_mm, Some(last)),
        [false, false] => {}
    }
    let at = fault.at.strip_prefix("/input").map(|within| format!("{}{within}", course.place.ply));
    let message = format!("course {}: {}", course.label, fault.message);
    Finding { at: at.unwrap_or(fault.at), message, ..fault }
}

/// A course that ends, at a point or at both ends, where nothing is known of the mould up to the outline.
fn ends_inside(course: &Course, width_mm: f64, end: Option<usize>) -> Finding {
    let place = course.place;
    let (at, which) = match end {
        Some(end) => (format!("{place}/points/{end}"), if end == 0 { "it begins" } else { "it ends" }),
        None => (place.to_string(), "it begins and ends"),
    };
    let message = format!(
        "course {}: {which} within the ply, more than {} mm before the outline, farther than it can be continued; let it \
         reach to the ply's edge",
        course.label,
        CONTINUED_WIDTHS * width_mm
    );
    Finding::error(Code::OffMould, at, message)
}

/// Notes which cut-outs a course meets within its tape.
pub fn note_met(developed: &DevelopedPly, width_mm: f64, met: &mut [bool]) {
    for (hole, met) in developed.holes.iter().zip(met) {
        *met |= developed.on_mould.is_none()
            || hole.places.iter().flatten().any(|place| place.y.abs() < width_mm / 2.0);
    }
}

/// The cut-outs that no course meets. On a mould nobody else would say that they lie outside the ply.
#[must_use]
pub fn never_met(ply: &Ply, met: &[bool]) -> Vec<Finding> {
    let places = (0..met.len()).filter(|&hole| !met[hole]);
    let warning = |hole: usize| {
        let message = "no tape goes over the cut-out: it lies outside the ply, off the mould, or where there is no course";
        Finding::warning(Code::HoleOutside, format!("{}/holes/{hole}", ply.place), message)
    };
    places.map(warning).collect()
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
    let ends = [0, course.points.len() - 1];
    if pieces.is_empty() && ends.into_iter().all(|end| lies_within(course, ply, end, width_mm)) {
        return Err(ends_inside(course, width_mm, None));
    }
    crossings(course, pieces, width_mm)?;
    not_nested(course, pieces)?;
    let at = || course.place.to_string();
    let warning =
        |code, message: String| Finding::warning(code, at(), format!("course {}: {message}", course.label));
    let coarse = (!pieces.is_empty() && on_mould.between_mm > CHORD_MM).then(|| {
        let longest =
            course.points.windows(2).map(|pair| (pair[1] - pair[0]).norm()).fold(0.0, f64::max);
        let message = format!(
            "its points are up to {longest:.1} mm apart, too far for how it turns between them: places may be off by \
             up to about {:.2} mm. Give points at closer intervals",
            on_mould.between_mm
        );
        warning(Code::CoarseCourse, message)
    });
    if let Some(fault) = coarse.as_ref().filter(|_| on_mould.between_mm > COARSEST_MM) {
        return Err(Finding { severity: Severity::Error, ..fault.clone() });
    }
    let beyond = |piece: &Piece| {
        let (low, high) = piece.u_range();
        (-low).max(high - on_mould.length_mm)
    };
    let farthest = pieces.iter().map(beyond).fold(0.0, f64::max);
    let well_mm = (CONTINUED_WELL_SHARE * on_mould.length_mm).min(CONTINUED_WELL_WIDTHS * width_mm);
    let continued = (farthest > well_mm).then(|| {
        let message = format!(
            "the ply goes on {farthest:.1} mm beyond the end of the course, which is continued there as it bends at its end; \
             farther than {well_mm:.1} mm that may miss the mould by more than some hundredths of a millimetre. Let the course reach to the ply's edge"
        );
        warning(Code::CourseContinued, message)
    });
    Ok([coarse, continued].into_iter().flatten().collect())
}

/// Whether a point of a course, seen along its normal, lies within the ply and in no cut-out, and the outline ahead and behind
/// is farther away than a course can be continued. An outline on the other side of a tube lies around it, too, but there the
/// surface has fallen away by more than it has gone on.
fn lies_within(course: &Course, ply: &Ply, index: usize, width_mm: f64) -> bool {
    let (place, normal) = (course.points[index], course.normals[index]);
    let next = if index + 1 < course.points.len() { index + 1 } else { index - 1 };
    let along = course.points[next] - place;
    let along = (along - normal * along.dot(&normal)).normalize();
    let across = normal.cross(&along);
    let seen = |outline: &[Point3]| -> Vec<Point2> {
        let at = |point: &Point3| Point2::new((point - place).dot(&along), (point - place).dot(&across));
        outline.iter().map(at).collect()
    };
    let (outline, off) = (seen(&ply.boundary), |at: usize| (ply.boundary[at] - place).dot(&normal));
    let count = outline.len();
    let beside = |at: usize| {
        let [(a, a_off), (b, b_off)] = [at, (at + 1) % count].map(|at| (outline[at], off(at)));
        let share = a.x / (a.x - b.x);
        let [v, off] = [a.y + share * (b.y - a.y), a_off + share * (b_off - a_off)];
        (a.x < 0.0) == (b.x < 0.0) || off.abs() <= v.abs()
    };
    let ahead_mm = FAR_INSIDE_SHARE * CONTINUED_WIDTHS * width_mm;
    let far = |at: usize| outline[at].y.abs() > width_mm / 2.0 || outline[at].x.abs() > ahead_mm;
    (0..count).all(|at| far(at) && beside(at))
        && contains(&outline, &Point2::origin())
        && !ply.holes.iter().any(|hole| contains(&seen(hole), &Point2::origin()))
}

/// A chord is shorter than the way along the mould, and an outline has places between its points.
const FAR_INSIDE_SHARE: f64 = 0.8;

/// Outlines that cross within the tape.
fn crossings<'a>(course: &Course, pieces: &'a [Piece], width_mm: f64) -> Result<(), Finding> {
    let path = |points: &'a [Point2]| match points {
        [first, .., last] if first == last => Path { points: &points[..points.len() - 1], closed: true },
        _ => Path { points, closed: false },
    };
    let paths: Vec<Path<'_>> = pieces.iter().flat_map(Piece::cuts).map(path).collect();
    // Where corners touch the tape's edge they may touch one another.
    let within = |place: &Point2| place.y.abs() < width_mm / 2.0 - SAME_POINT_MM;
    any_crossing(&paths, SAME_POINT_MM, within).map_or(Ok(()), |crossing| {
        let message = format!(
            "course {}: within its tape the outlines cross or touch, near u {:.3} v {:.3} mm",
            course.label, crossing.place.x, crossing.place.y
        );
        Err(Finding::error(Code::OutlineCrosses, course.place.to_string(), message))
    })
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
