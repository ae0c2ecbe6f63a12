//! Whether what was sent fits together: sizes that say that two things are in different units, and normals that say that
//! pieces would be mirrored.
//!
//! Nothing here is a fault by itself. A reversed outline is harmless and accepted; normals that point into the mould
//! mirror each piece, and from a flat ply alone the two cannot be told apart. Nor can they on a curved mould: the
//! outward normals of a male mould diverge and those of a female one converge. What can be told is that a course
//! disagrees with those beside it.

use super::input::{Course, Ply};
use super::outline::Plane;
use crate::planning::finding::{Code, Finding};
use crate::planning::geometry::{Point3, Vector3};
use crate::planning::tolerance::{OPPOSED_COSINE, UNLIKE_SIZES};
use crate::planning::units::Length;

/// The most places of a course that are compared with those of others.
const MOST_PLACES: usize = 64;

/// What a ply without faults says of itself; `generated` if its courses are. Of what is in files and not read yet there is nothing to say.
#[must_use]
pub fn findings(ply: &Ply, generated: bool, width: Length) -> Vec<Finding> {
    let sizes = of_sizes(ply, generated, width.mm());
    sizes.into_iter().chain(of_normals(ply, generated, width.mm())).collect()
}

/// What the sizes of a ply, of its courses and of its tape say of their units.
fn of_sizes(ply: &Ply, generated: bool, width_mm: f64) -> Option<Finding> {
    let at = outline_of(ply);
    let laid = extent_mm(ply.courses.iter().flat_map(|course| &course.points)).filter(|_| !generated);
    let ply = extent_mm(ply.boundary.iter())?;
    let advice = "see whether both are in mm";
    if let Some(laid) = laid.filter(|laid| laid / ply > UNLIKE_SIZES || ply / laid > UNLIKE_SIZES) {
        let message =
            format!("the outline measures {ply:.3} mm across and its courses {laid:.3} mm: {advice}");
        return Some(Finding::warning(Code::UnlikeSizes, at, message));
    }
    (width_mm > ply).then(|| {
        let message =
            format!("the outline measures {ply:.3} mm across and the tape is {width_mm} mm wide: {advice}");
        Finding::warning(Code::UnlikeSizes, at, message)
    })
}

/// Where the outline of a ply stands.
fn outline_of(ply: &Ply) -> String {
    format!("{}/boundary/points", ply.place)
}

/// The diagonal of the box around some points, in mm; none of a single place.
fn extent_mm<'a>(points: impl Iterator<Item = &'a Point3>) -> Option<f64> {
    let around = points.fold(None, |around: Option<(Point3, Point3)>, point| {
        let (low, high) = around.unwrap_or((*point, *point));
        Some((low.inf(point), high.sup(point)))
    });
    around.map(|(low, high)| (high - low).norm()).filter(|extent| *extent > 0.0)
}

/// What the courses' normals say: against the sense of the outline, and against one another.
fn of_normals(ply: &Ply, generated: bool, width_mm: f64) -> Vec<Finding> {
    let courses = &ply.courses;
    let sum: Vector3 = courses.iter().flat_map(|course| &course.normals).sum();
    let count = courses.iter().map(|course| course.normals.len()).sum::<usize>();
    let mean = sum / count.max(1) as f64;
    // A ply that goes so far around its mould is seen as a whole from nowhere.
    let sense = (mean.norm() > 0.5).then(|| sense(ply, &mean, generated)).flatten();
    sense.into_iter().chain(opposed(courses, &mean, width_mm)).collect()
}

/// Says that a boundary turns counter-clockwise seen from the normals' side. The normals of generated courses are ours
/// and right; with any others it may be they that are wrong.
fn sense(ply: &Ply, mean: &Vector3, generated: bool) -> Option<Finding> {
    let plane = Plane::of(&ply.boundary).filter(|plane| plane.normal.dot(mean) > 0.0)?;
    let at = outline_of(ply);
    let turns = "the boundary turns counter-clockwise seen from the normals' side; that is accepted";
    if generated {
        return Some(Finding::info(Code::OutlineSense, at, turns));
    }
    let [x, y, z] = [plane.normal.x, plane.normal.y, plane.normal.z];
    let message = format!(
        "{turns}. If it is not the outline that was drawn the other way round but the normals that point into the mould, \
         every piece is mirrored: see whether the mould's outside is where they point, about ({x:.2}, {y:.2}, {z:.2})"
    );
    Some(Finding::warning(Code::OutlineSense, at, message))
}

/// Courses whose normals point against those of the courses beside them.
fn opposed(courses: &[Course], mean: &Vector3, width_mm: f64) -> Vec<Finding> {
    // If every normal is within 60 degrees of one direction, no two are opposed: the usual ply is done here.
    let along = mean.try_normalize(0.0).unwrap_or_default();
    if courses.iter().flat_map(|course| &course.normals).all(|normal| normal.dot(&along) > 0.5) {
        return Vec::new();
    }
    let turned: Vec<Finding> = courses.iter().filter_map(turned_over).collect();
    if !turned.is_empty() {
        return turned;
    }
    let places: Vec<Vec<Place>> = courses.iter().map(|course| places(course, width_mm)).collect();
    let meetings = Meetings::of(&places, 2.0 * width_mm);
    meetings.findings(courses)
}

/// The first point of a course whose normal points against that of the point before it.
fn turned_over(course: &Course) -> Option<Finding> {
    let mut steps = course.normals.windows(2);
    let point = 1 + steps.position(|pair| pair[0].dot(&pair[1]) < OPPOSED_COSINE)?;
    let at = format!("{}/points", course.place);
    let message = format!(
        "the normal at point {point} of course {} points against that of the point before",
        course.label
    );
    Some(Finding::error(Code::NormalsOpposed, at, message))
}

/// A place of a course with its normal.
struct Place {
    at: Point3,
    normal: Vector3,
}

/// Places of a course a tape's width apart, or farther where that would be too many.
fn places(course: &Course, width_mm: f64) -> Vec<Place> {
    let length: f64 = course.points.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum();
    let apart = width_mm.max(length / MOST_PLACES as f64);
    let (mut places, mut left) = (Vec::new(), 0.0);
    for (pair, normal) in course.points.windows(2).zip(&course.normals) {
        let step = pair[1] - pair[0];
        let length = step.norm();
        while left <= length {
            places.push(Place { at: pair[0] + step * (left / length), normal: *normal });
            left += apart;
        }
        left -= length;
    }
    places
}

/// How often each two courses come near each other, with normals that agree and with such that are opposed.
struct Meetings {
    /// By the indices of both courses, sorted: near each other, agreeing or not.
    pairs: Vec<((usize, usize), bool)>,
}

impl Meetings {
    /// All places that are less than `reach_mm` apart, found on a grid of that size.
    fn of(courses: &[Vec<Place>], reach_mm: f64) -> Self {
        let cell = |at: &Point3| [at.x, at.y, at.z].map(|x| (x / reach_mm).floor() as i64);
        let every =
            courses.iter().enumerate().flat_map(|(index, places)| places.iter().map(move |p| (index, p)));
        let mut grid: Vec<([i64; 3], usize, &Place)> =
            every.map(|(index, p)| (cell(&p.at), index, p)).collect();
        grid.sort_by_key(|(cell, index, _)| (*cell, *index));
        let mut pairs = Vec::new();
        for (here, one, place) in &grid {
            for neighbour in cells_around(here) {
                let first = grid.partition_point(|(cell, _, _)| *cell < neighbour);
                let there = grid[first..].iter().take_while(|(cell, _, _)| *cell == neighbour);
                let near =
                    there.filter(|(_, other, near)| other != one && (near.at - place.at).norm() < reach_mm);
                pairs.extend(near.map(|(_, other, near)| {
                    ((*one, *other), near.normal.dot(&place.normal) > OPPOSED_COSINE)
                }));
            }
        }
        pairs.sort_unstable();
        Self { pairs }
    }

    /// The courses that each course meets, and whether their normals agree for the most part.
    fn neighbours_of(&self, course: usize) -> Vec<(usize, bool)> {
        let from = self.pairs.partition_point(|((one, _), _)| *one < course);
        let met: Vec<_> = self.pairs[from..].iter().take_while(|((one, _), _)| *one == course).collect();
        let with = met.chunk_by(|a, b| a.0 == b.0).map(|places| {
            let agree = places.iter().filter(|(_, agrees)| *agrees).count();
            (places[0].0.1, 2 * agree > places.len())
        });
        with.collect()
    }

    /// What is opposed. A course that is so to two others and agrees with none is certainly wrong; of two courses alone
    /// either may be, or the mould turns over an edge between them, and each such pair is said once.
    fn findings(&self, courses: &[Course]) -> Vec<Finding> {
        let neighbours: Vec<_> = (0..courses.len()).map(|course| self.neighbours_of(course)).collect();
        let against =
            |course: usize| neighbours[course].iter().filter(|(_, agrees)| !agrees).map(|(other, _)| *other);
        let alone = |course: usize| neighbours[course].iter().all(|(_, agrees)| !agrees);
        let wrong = |course: usize| alone(course) && against(course).count() >= 2;
        let mut findings = Vec::new();
        for course in 0..courses.len() {
            if wrong(course) {
                findings
                    .push(certainly_opposed(&courses[course], against(course).map(|other| &courses[other])));
                continue;
            }
            for other in against(course).filter(|other| *other > course && !wrong(*other)) {
                let (odd, with) =
                    if alone(other) && !alone(course) { (other, course) } else { (course, other) };
                findings.push(perhaps_opposed(&courses[odd], &courses[with]));
            }
        }
        findings
    }
}

fn certainly_opposed<'a>(course: &Course, others: impl Iterator<Item = &'a Course>) -> Finding {
    let others = others.map(|other| other.label.to_string()).collect::<Vec<_>>().join(", ");
    let message = format!(
        "the normals of course {} point against those of the courses beside it ({others}): its pieces would be mirrored. \
         Give the mould's outward normals",
        course.label
    );
    Finding::error(Code::NormalsOpposed, format!("{}/points", course.place), message)
}

fn perhaps_opposed(course: &Course, other: &Course) -> Finding {
    let message = format!(
        "the normals of course {} point against those of course {} beside it: the pieces of one of both are mirrored, \
         unless the mould turns over an edge between them",
        course.label, other.label
    );
    Finding::warning(Code::NormalsOpposed, format!("{}/points", course.place), message)
}

/// A cell of the grid and those around it.
fn cells_around(cell: &[i64; 3]) -> impl Iterator<Item = [i64; 3]> {
    let [x, y, z] = *cell;
    (0..27).map(move |i| [x + i % 3 - 1, y + i / 3 % 3 - 1, z + i / 9 - 1])
}
