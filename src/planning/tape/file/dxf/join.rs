//! Curves joined end to end into closed loops.

use std::collections::{BTreeMap, BTreeSet};

use super::super::faults::{Fault, Faults};
use super::super::text::ReadLoop;
use super::curve::Curve;
use crate::planning::finding::{Code, Finding};
use crate::planning::geometry::Point3;
use crate::planning::tolerance::{JOIN_MM, SAME_POINT_MM};

/// An end of a curve: its index, and whether it is the last point.
type End = (usize, bool);

/// Joins curves into loops, in the order of the first curve of each. `name` is the file's.
///
/// Ends within [`JOIN_MM`] of each other are one; where they differ, the loop passes midway. Every curve must be used.
///
/// # Errors
/// An end that meets no other one, with the gap to the nearest that does not either; a place where more than two ends
/// meet.
pub fn join(curves: &[Curve], name: &str, faults: &mut Faults<'_>) -> (Vec<ReadLoop>, Vec<Finding>) {
    let (closed, open): (Vec<_>, Vec<_>) = (0..curves.len()).partition(|&index| curves[index].closed);
    let mut findings = Vec::new();
    let (short, open): (Vec<_>, Vec<_>) = open.into_iter().partition(|&index| is_short(&curves[index]));
    findings.extend(short.iter().map(|&index| left_out(&curves[index], name)));
    let partners = partners(curves, &open, faults);
    if !faults.is_empty() {
        return (Vec::new(), findings);
    }
    let mut loops: Vec<_> = closed.into_iter().map(|index| (index, loop_of(&curves[index]))).collect();
    let mut widest = Widest::default();
    let mut used = vec![false; curves.len()];
    for &first in &open {
        if !used[first] {
            loops.push((first, around(first, curves, &partners, &mut used, &mut widest)));
        }
    }
    loops.sort_by_key(|(first, _)| *first);
    findings.extend(widest.finding(name));
    (loops.into_iter().map(|(_, read)| read).collect(), findings)
}

/// A curve that lies within the distance at which ends are one: it would meet itself.
fn is_short(curve: &Curve) -> bool {
    curve.points.iter().all(|point| (point - curve.points[0]).norm() <= JOIN_MM)
}

fn left_out(curve: &Curve, name: &str) -> Finding {
    let message = format!("the {} is shorter than {JOIN_MM} mm; it was left out", curve.what);
    Finding::info(Code::LeftOut, format!("{name}:{}", curve.line), message)
}

fn loop_of(curve: &Curve) -> ReadLoop {
    let points = curve.points.iter().map(|point| [point.x, point.y, point.z]).collect();
    ReadLoop { line: curve.line, points, lines: curve.lines.clone() }
}

/// The widest gap over which ends were joined.
#[derive(Default)]
struct Widest {
    count: usize,
    gap: f64,
    line: u32,
}

impl Widest {
    fn note(&mut self, gap: f64, line: u32) {
        if gap > SAME_POINT_MM {
            self.count += 1;
            if gap > self.gap {
                (self.gap, self.line) = (gap, line);
            }
        }
    }

    fn finding(&self, name: &str) -> Option<Finding> {
        let message = format!(
            "{} pairs of ends do not quite meet; they were joined midway. The widest gap is {:.6} mm, here",
            self.count, self.gap
        );
        (self.count > 0).then(|| Finding::info(Code::JoinedEnds, format!("{name}:{}", self.line), message))
    }
}

/// The loop that a curve is part of.
fn around(
    first: usize,
    curves: &[Curve],
    partners: &BTreeMap<End, End>,
    used: &mut [bool],
    widest: &mut Widest,
) -> ReadLoop {
    let mut read = ReadLoop { line: curves[first].line, ..ReadLoop::default() };
    // Each curve is passed from the end at which it is entered to the other one.
    let mut entered = (first, false);
    while !used[entered.0] {
        let (index, backwards) = entered;
        used[index] = true;
        let curve = &curves[index];
        let before = end_point(curves, partners[&entered]);
        let here = end_point(curves, entered);
        widest.note((here - before).norm(), curve.line);
        let joint =
            if (here - before).norm() <= SAME_POINT_MM { before } else { nalgebra::center(&before, &here) };
        push(&mut read, joint, curve.lines[if backwards { curve.lines.len() - 1 } else { 0 }]);
        let inner = 1..curve.points.len() - 1;
        if backwards {
            inner.rev().for_each(|i| push(&mut read, curve.points[i], curve.lines[i]));
        } else {
            inner.for_each(|i| push(&mut read, curve.points[i], curve.lines[i]));
        }
        entered = partners[&(index, !backwards)];
    }
    read
}

fn push(read: &mut ReadLoop, point: Point3, line: u32) {
    read.points.push([point.x, point.y, point.z]);
    read.lines.push(line);
}

fn end_point(curves: &[Curve], (index, last): End) -> Point3 {
    let points = &curves[index].points;
    points[if last { points.len() - 1 } else { 0 }]
}

/// Which end each end meets.
fn partners(curves: &[Curve], open: &[usize], faults: &mut Faults<'_>) -> BTreeMap<End, End> {
    let ends: Vec<End> = open.iter().flat_map(|&index| [(index, false), (index, true)]).collect();
    let grid = Grid::of(curves, &ends);
    let (mut partners, mut alone, mut said) = (BTreeMap::new(), Vec::new(), BTreeSet::new());
    for &end in &ends {
        match grid.near(curves, end).as_slice() {
            [] => alone.push(end),
            [one] => {
                partners.insert(end, *one);
            }
            // Of those that meet the first one says so.
            several => {
                if several.iter().all(|other| !said.contains(other)) {
                    faults.push(branch(curves, end, several));
                }
                said.insert(end);
            }
        }
    }
    report_open(curves, &alone, faults);
    partners
}

fn branch(curves: &[Curve], end: End, others: &[End]) -> Fault {
    let (place, curve) = (end_point(curves, end), &curves[end.0]);
    let lines: Vec<_> = others.iter().map(|other| curves[other.0].line.to_string()).collect();
    let message = format!(
        "more than two curves meet at x {:.4} y {:.4} mm: an end of this {} and those at line {}; \
         an outline does not branch, and nothing is drawn twice",
        place.x,
        place.y,
        curve.what,
        lines.join(" and ")
    );
    Fault::new(Code::OpenOutline, curve.line, message)
}

/// So many open ends are looked at one by one for the nearest other one: as many as are listed, and the one that is
/// counted only.
const MOST_LOOKED_AT: usize = 200;

fn report_open(curves: &[Curve], alone: &[End], faults: &mut Faults<'_>) {
    let place = |end: End| end_point(curves, end);
    let nearest = |end: End| {
        let others = alone.iter().copied().filter(|other| *other != end);
        let gap = |other: &End| (place(*other) - place(end)).norm();
        others.min_by(|one, other| gap(one).total_cmp(&gap(other)))
    };
    for &end in alone.iter().take(MOST_LOOKED_AT) {
        let other = nearest(end);
        // Two ends that are nearest to each other are one gap.
        if other.is_some_and(|other| other < end && nearest(other) == Some(end)) {
            continue;
        }
        faults.push(gap(curves, end, other));
    }
    for &end in alone.iter().skip(MOST_LOOKED_AT) {
        faults.push(gap(curves, end, None));
    }
}

fn gap(curves: &[Curve], end: End, other: Option<End>) -> Fault {
    let (place, curve) = (end_point(curves, end), &curves[end.0]);
    let mut message =
        format!("this {} ends at x {:.4} y {:.4} mm and meets no other curve", curve.what, place.x, place.y);
    if let Some(other) = other {
        let there = end_point(curves, other);
        message += &format!(
            "; the nearest open end, of the {} at line {}, is {:.4} mm away at x {:.4} y {:.4} mm. \
             Ends are joined up to {JOIN_MM} mm",
            curves[other.0].what,
            curves[other.0].line,
            (there - place).norm(),
            there.x,
            there.y
        );
    }
    Fault::new(Code::OpenOutline, curve.line, message)
}

/// The ends by the square in which they lie. All ends in one square meet, so that more than three of them need not be
/// kept to know that they branch: the work is proportional to the ends, whatever the drawing.
struct Grid {
    cells: BTreeMap<(i64, i64), Vec<End>>,
}

/// The side of a square, in mm. Its diagonal is below [`JOIN_MM`].
const CELL_MM: f64 = JOIN_MM / 2.0;
/// So many squares on, none is within [`JOIN_MM`].
const REACH: i64 = 2;
/// The most ends that are kept of a square.
const MOST_KEPT: usize = 3;

impl Grid {
    fn of(curves: &[Curve], ends: &[End]) -> Self {
        let mut cells: BTreeMap<_, Vec<End>> = BTreeMap::new();
        for &end in ends {
            let kept = cells.entry(cell(&end_point(curves, end))).or_default();
            if kept.len() < MOST_KEPT {
                kept.push(end);
            }
        }
        Self { cells }
    }

    /// The ends that meet an end, at most two of them.
    fn near(&self, curves: &[Curve], end: End) -> Vec<End> {
        let place = end_point(curves, end);
        let (column, row) = cell(&place);
        let mut near = Vec::new();
        for other in (column - REACH..=column + REACH)
            .flat_map(|x| (row - REACH..=row + REACH).map(move |y| (x, y)))
            .filter_map(|key| self.cells.get(&key))
            .flatten()
        {
            if *other != end && (end_point(curves, *other) - place).norm() <= JOIN_MM && near.len() < 2 {
                near.push(*other);
            }
        }
        near
    }
}

fn cell(place: &Point3) -> (i64, i64) {
    ((place.x / CELL_MM).floor() as i64, (place.y / CELL_MM).floor() as i64)
}
