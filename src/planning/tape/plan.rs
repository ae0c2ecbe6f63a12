//! The plan of a ply: pieces, their chains, their places on the roll and their knives.

use super::assign::{RollChain, assign, passing, published};
use super::chain::{Chain, split};
use super::develop::{PlyInSpace, develop};
use super::input::{Course, OnExcess, TapeInput};
use super::outline::{flat_area, report_sense};
use super::piece::{Piece, within_strip};
use super::roll::{Roll, RollFigures, place};
use super::stroke::{Stroke, strokes};
use crate::planning::budget::Budget;
use crate::planning::finding::{Code, Finding};
use crate::planning::program::number::rounded;
use crate::planning::program::replay::WantedCut;
use crate::planning::tolerance::COVERED_SHARE;

/// The plan of a ply.
#[derive(Debug, Clone)]
pub struct TapePlan {
    /// The courses that touch the ply, in laying order.
    pub courses: Vec<PlannedCourse>,
    /// All pieces in increasing roll coordinate, as (course, piece) indices into `courses`.
    pub order: Vec<(usize, usize)>,
    /// The figures of the roll.
    pub figures: RollFigures,
}

/// A course of a plan.
#[derive(Debug, Clone)]
pub struct PlannedCourse {
    /// Its number.
    pub number: u32,
    /// Its place in the job document.
    pub index: usize,
    /// Its pieces in order of their smallest u.
    pub pieces: Vec<PlannedPiece>,
}

/// A piece of a plan.
#[derive(Debug, Clone)]
pub struct PlannedPiece {
    /// The piece in the (u, v) of its course.
    pub piece: Piece,
    /// r - u in mm.
    pub offset_mm: f64,
    /// Its chains, each with its cutter from 0.
    pub chains: Vec<(Chain, usize)>,
    /// How far its outline was changed on the scrap side, in mm, and the area that this leaves to be trimmed, in mm^2.
    pub simplified: Option<(f64, f64)>,
}

/// Plans a ply.
///
/// # Errors
/// Every finding that leaves the ply without a plan.
pub fn plan(
    input: &TapeInput,
    budget: &Budget<'_>,
    findings: &mut Vec<Finding>,
) -> Result<TapePlan, Vec<Finding>> {
    budget.stage("clip");
    let mut courses = pieces_of_courses(input, budget, findings)?;
    if courses.is_empty() {
        let message = "no course touches the ply: see whether both are in one coordinate system, in mm";
        return Err(vec![Finding::error(Code::NoCourseOnPly, "/input/tracks", message)]);
    }
    findings.extend(uncovered(&courses, input));
    budget.stage("roll");
    let roll = place_pieces(&mut courses, input);
    budget.stage("knives");
    findings.extend(assign_knives(&mut courses, input.machine.cutters.len())?);
    Ok(finished(courses, &roll, input))
}

/// Says how much of a flat ply its courses leave bare. Courses that overlap hide a part of it.
fn uncovered(courses: &[PlannedCourse], input: &TapeInput) -> Option<Finding> {
    let ply = flat_area(&input.boundary, &input.holes)?;
    let covered: f64 = courses.iter().flat_map(|course| &course.pieces).map(|p| p.piece.area_mm2).sum();
    if covered >= COVERED_SHARE * ply {
        return None;
    }
    let message = format!(
        "the courses cover {:.1} % of the ply at most; see whether a course is missing, or the tape's width is in mm",
        covered / ply * 100.0
    );
    Some(Finding::warning(Code::PlyNotCovered, "/input/tracks", message))
}

fn pieces_of_courses(
    input: &TapeInput,
    budget: &Budget<'_>,
    findings: &mut Vec<Finding>,
) -> Result<Vec<PlannedCourse>, Vec<Finding>> {
    let mut courses = Vec::new();
    if let Some(course) = input.courses.first() {
        report_sense(&input.boundary, &course.normals[0], findings);
    }
    let ply = PlyInSpace::new(&input.boundary, &input.holes);
    for course in &input.courses {
        let pieces = pieces_of(course, &ply, input, budget).map_err(|finding| vec![finding])?;
        if pieces.is_empty() {
            findings.push(Finding::info(
                Code::CourseOffPly,
                format!("/input/tracks/{}", course.index),
                format!("course {} does not touch the ply and is left out", course.number),
            ));
        } else {
            findings.extend(pieces.iter().filter_map(|piece| simplification(course, piece)));
            courses.push(PlannedCourse { number: course.number, index: course.index, pieces });
        }
    }
    Ok(courses)
}

fn simplification(course: &Course, piece: &PlannedPiece) -> Option<Finding> {
    let (deviation_mm, area_mm2) = piece.simplified?;
    let message = format!(
        "course {}: there are not enough knives for its outline; it was changed on the scrap side, by {deviation_mm:.3} mm along \
         the tape at the most, and {area_mm2:.1} mm2 are left to be trimmed",
        course.number
    );
    Some(Finding::warning(Code::OutlineSimplified, format!("/input/tracks/{}", course.index), message))
}

fn pieces_of(
    course: &Course,
    ply: &PlyInSpace<'_>,
    input: &TapeInput,
    budget: &Budget<'_>,
) -> Result<Vec<PlannedPiece>, Finding> {
    let width = input.width.mm();
    let ply = develop(course, ply, input.machine.cut_side, width)?;
    let points = std::iter::once(&ply.boundary).chain(&ply.holes).map(|outline| outline.places.len());
    budget.spend(points.sum::<usize>() as u64)?;
    let pieces = within_strip(&ply, width)?;
    Ok(pieces.into_iter().map(|piece| chained(piece, input)).collect())
}

fn chained(mut piece: Piece, input: &TapeInput) -> PlannedPiece {
    let (half_width_mm, knives) = (input.width.mm() / 2.0, input.machine.cutters.len());
    let simplified = match input.on_excess {
        OnExcess::Simplify => piece.simplify(half_width_mm, knives),
        OnExcess::Reject => None,
    };
    let chains = piece
        .cuts()
        .enumerate()
        .flat_map(|(index, cut)| split(index, cut, half_width_mm))
        .map(|chain| {
            let cutter = published(&chain).0.min(knives - 1);
            (chain, cutter)
        })
        .collect();
    PlannedPiece { piece, offset_mm: 0.0, chains, simplified }
}

fn place_pieces(courses: &mut [PlannedCourse], input: &TapeInput) -> Roll {
    let pieces: Vec<&Piece> = courses.iter().flat_map(|course| &course.pieces).map(|p| &p.piece).collect();
    let roll = place(&pieces, input.roll_order, input.scrap_gap);
    let planned = courses.iter_mut().flat_map(|course| &mut course.pieces);
    for (piece, offset) in planned.zip(&roll.offsets_mm) {
        piece.offset_mm = *offset;
    }
    roll
}

fn assign_knives(courses: &mut [PlannedCourse], knives: usize) -> Result<Vec<Finding>, Vec<Finding>> {
    let mut on_roll = Vec::new();
    for course in courses.iter() {
        for piece in &course.pieces {
            on_roll.extend(piece.chains.iter().map(|(chain, cutter)| {
                let (low, high) = chain.u_range();
                RollChain {
                    course: course.number,
                    course_index: course.index,
                    range: (low + piece.offset_mm, high + piece.offset_mm),
                    offset_mm: piece.offset_mm,
                    published: *cutter,
                    covered: published(chain).1,
                }
            }));
        }
    }
    let (given, findings) = assign(&on_roll, knives)?;
    let chains = courses.iter_mut().flat_map(|course| &mut course.pieces).flat_map(|piece| &mut piece.chains);
    for ((_, cutter), given) in chains.zip(given) {
        *cutter = given;
    }
    Ok(findings)
}

fn finished(courses: Vec<PlannedCourse>, roll: &Roll, input: &TapeInput) -> TapePlan {
    let places: Vec<(usize, usize)> = courses
        .iter()
        .enumerate()
        .flat_map(|(course, planned)| (0..planned.pieces.len()).map(move |piece| (course, piece)))
        .collect();
    let pieces: Vec<&Piece> = courses.iter().flat_map(|course| &course.pieces).map(|p| &p.piece).collect();
    // The U axis reads 0 with the leading end of the tape under cutter 1.
    let first_station = input.machine.cutters[0].station.mm();
    // The first cut begins before its piece by as much as it overcuts.
    let leading_end = roll.leading_end(&pieces) + input.machine.overcut().mm();
    let lead_mm = rounded(leading_end - first_station, super::stroke::DECIMALS);
    let figures = roll.figures(&pieces, input.width, lead_mm);
    let order = roll.order.iter().map(|&index| places[index]).collect();
    TapePlan { courses, order, figures }
}

impl TapePlan {
    /// The pieces in increasing roll coordinate, each with its course.
    pub fn pieces(&self) -> impl DoubleEndedIterator<Item = (&PlannedCourse, &PlannedPiece)> {
        self.order.iter().map(|&(course, piece)| {
            let course = &self.courses[course];
            (course, &course.pieces[piece])
        })
    }

    /// The strokes of each cutter in the order in which they pass it.
    #[must_use]
    pub fn strokes(&self, input: &TapeInput) -> Vec<Vec<Stroke>> {
        let thinning_mm = input.machine.feed.thinning_mm(input.tolerance.mm());
        let mut of_cutters: Vec<Vec<Stroke>> = vec![Vec::new(); input.machine.cutters.len()];
        for (course, piece) in self.pieces().rev() {
            let mut chains: Vec<&(Chain, usize)> = piece.chains.iter().collect();
            chains.sort_by(|(one, _), (other, _)| passing(one.u_range(), other.u_range()));
            for (chain, cutter) in chains {
                let machine_cutter = &input.machine.cutters[*cutter];
                let x_of_u0 = self.figures.lead_mm - piece.offset_mm + machine_cutter.station.mm();
                let mut made = strokes(chain, course.number, machine_cutter, x_of_u0, thinning_mm);
                let before = of_cutters[*cutter].last().and_then(|stroke| stroke.knots.last());
                hold_back(&mut made, before.map_or(f64::NEG_INFINITY, |knot| knot.x));
                of_cutters[*cutter].extend(made);
            }
        }
        of_cutters
    }

    /// The cuts that a program must make, in roll coordinates, as they were developed.
    #[must_use]
    pub fn wanted(&self) -> Vec<WantedCut> {
        let mut wanted = Vec::new();
        for (course, piece) in self.pieces() {
            wanted.extend(piece.piece.cuts().map(|cut| WantedCut {
                course: course.number,
                points: cut.iter().map(|point| [point.x + piece.offset_mm, point.y]).collect(),
            }));
        }
        wanted
    }
}

/// Two chains that meet at one place may overlap there by as much as that is: the second is begun where the tape
/// stands, which only runs forward.
fn hold_back(strokes: &mut [Stroke], x: f64) {
    for knot in strokes.iter_mut().flat_map(|stroke| &mut stroke.knots) {
        knot.x = knot.x.max(x);
    }
}
