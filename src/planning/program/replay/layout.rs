//! Where the pieces lie on the roll, by areas: the planner places them by their fronts (`tape/place`).

use i_overlay::core::fill_rule::FillRule;
use i_overlay::core::overlay_rule::OverlayRule;
use i_overlay::float::single::SingleFloatOverlay;

use super::Ring;
use super::faults::Faults;
use crate::planning::finding::{Code, Finding};
use crate::planning::tape::label::CourseLabel;

/// A piece on the roll.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Laid {
    /// What its course is called.
    pub course: CourseLabel,
    /// Its smallest and largest r in mm.
    pub range: (f64, f64),
}

/// What a roll has to keep.
#[derive(Debug, Clone, Copy)]
pub struct Layout<'a> {
    /// Roll coordinate of the leading end of the tape in mm.
    pub leading_end_mm: f64,
    /// Stretches without pieces, in mm from the leading end.
    pub zones_mm: &'a [(f64, f64)],
    /// Between two pieces, along the tape, in mm.
    pub gap_mm: f64,
    /// Width of the tape in mm.
    pub width_mm: f64,
    /// How far, in mm, two pieces may lie into each other: what outlines and places are rounded by.
    pub within_mm: f64,
}

/// Findings, at `program`, for all pieces that lie over one another, closer than the gap, in a zone or before the tape
/// begins. `outline` gives the outline of a piece by its index, in roll coordinates.
#[must_use]
pub fn check_layout(
    program: &str,
    pieces: &[Laid],
    outline: impl Fn(usize) -> Ring,
    layout: &Layout<'_>,
) -> Vec<Finding> {
    let mut faults = Faults::new(program);
    let mut order: Vec<usize> = (0..pieces.len()).collect();
    order.sort_by(|&a, &b| pieces[a].range.0.total_cmp(&pieces[b].range.0));
    for (at, &lower) in order.iter().enumerate() {
        off_the_tape(&pieces[lower], layout, &mut faults);
        let reach = pieces[lower].range.1 + layout.gap_mm;
        for &upper in order[at + 1..].iter().take_while(|upper| pieces[**upper].range.0 < reach) {
            // Brought as much nearer as there has to be between them, the two may touch and no more.
            let nearer = |mut point: [f64; 2]| {
                point[0] -= layout.gap_mm;
                point
            };
            let [from, to] = [pieces[upper].range.0 - layout.gap_mm, reach - layout.gap_mm];
            let one = within(outline(lower), from, to);
            let other = within(outline(upper).into_iter().map(nearer).collect(), from, to);
            let over_mm2 = common_mm2(&one, &other);
            if over_mm2 > layout.within_mm * layout.width_mm {
                faults.at_program(Code::MisplacedPiece, || {
                    format!(
                        "on the roll, pieces of the courses {} and {} lie into each other or closer than {} mm, by {over_mm2:.3} mm2",
                        pieces[lower].course, pieces[upper].course, layout.gap_mm
                    )
                });
            }
        }
    }
    faults.finish()
}

/// A piece before the leading end of the tape, or in a zone.
fn off_the_tape(piece: &Laid, layout: &Layout<'_>, faults: &mut Faults<'_>) {
    let from_end = (layout.leading_end_mm - piece.range.1, layout.leading_end_mm - piece.range.0);
    let lies = || {
        format!(
            "a piece of course {} lies {:.3} to {:.3} mm from the leading end",
            piece.course, from_end.0, from_end.1
        )
    };
    if from_end.0 < -layout.within_mm {
        faults.at_program(Code::MisplacedPiece, || format!("{}, before the tape begins", lies()));
    }
    for (from, to) in layout.zones_mm {
        if from_end.0 < to - layout.within_mm && *from < from_end.1 - layout.within_mm {
            faults.at_program(Code::MisplacedPiece, || {
                format!("{}, where none may be from {from} to {to} mm", lies())
            });
        }
    }
}

/// The part of a ring between two r.
fn within(ring: Ring, from: f64, to: f64) -> Ring {
    let cut = |ring: Ring, at: f64, keep: f64| -> Ring {
        let inside = |point: &[f64; 2]| (point[0] - at) * keep >= 0.0;
        let steps = ring.iter().zip(ring.iter().cycle().skip(1));
        let kept = steps.flat_map(|(a, b)| {
            let crossing = (inside(a) != inside(b)).then(|| {
                let share = (at - a[0]) / (b[0] - a[0]);
                [at, a[1] + share * (b[1] - a[1])]
            });
            inside(a).then_some(*a).into_iter().chain(crossing)
        });
        kept.collect()
    };
    cut(cut(ring, from, 1.0), to, -1.0)
}

fn common_mm2(one: &Ring, other: &Ring) -> f64 {
    if one.len() < 3 || other.len() < 3 {
        return 0.0;
    }
    let common = one.overlay(other, OverlayRule::Intersect, FillRule::EvenOdd);
    let area = |ring: &Ring| {
        let steps = ring.iter().zip(ring.iter().cycle().skip(1));
        steps.map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum::<f64>() / 2.0
    };
    common.iter().map(|shape| shape.iter().map(area).sum::<f64>().abs()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A parallelogram from r to r + 100 at v = -50, and by `lean` farther at v = 50.
    fn leaning(r: f64, lean: f64) -> Ring {
        vec![[r, -50.0], [r + 100.0, -50.0], [r + 100.0 + lean, 50.0], [r + lean, 50.0]]
    }

    fn found(rings: &[Ring], gap_mm: f64, zones_mm: &[(f64, f64)]) -> usize {
        let range = |ring: &Ring| {
            let r = ring.iter().map(|point| point[0]);
            r.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), r| (low.min(r), high.max(r)))
        };
        let pieces: Vec<Laid> = rings
            .iter()
            .zip(1..)
            .map(|(ring, number)| Laid { course: number.into(), range: range(ring) })
            .collect();
        let layout = Layout { leading_end_mm: 1000.0, zones_mm, gap_mm, width_mm: 100.0, within_mm: 0.01 };
        let faults = check_layout("p", &pieces, |index| rings[index].clone(), &layout);
        assert!(faults.iter().all(|fault| fault.code == Code::MisplacedPiece));
        faults.len()
    }

    #[test]
    fn neighbours_may_touch_and_no_more() {
        assert_eq!(found(&[leaning(0.0, 30.0), leaning(100.0, 30.0)], 0.0, &[]), 0);
        assert_eq!(found(&[leaning(0.0, 30.0), leaning(99.9, 30.0)], 0.0, &[]), 1);
        assert_eq!(found(&[leaning(0.0, 30.0), leaning(105.0, 30.0)], 5.0, &[]), 0);
        assert_eq!(found(&[leaning(0.0, 30.0), leaning(104.9, 30.0)], 5.0, &[]), 1);
        // Not only the next one, and one that lies within another.
        assert_eq!(found(&[leaning(0.0, 300.0), leaning(100.0, 0.0), leaning(190.0, 0.0)], 0.0, &[]), 3);
        assert_eq!(
            found(&[leaning(0.0, 0.0), vec![[40.0, -10.0], [60.0, -10.0], [50.0, 10.0]]], 0.0, &[]),
            1
        );
    }

    #[test]
    fn no_piece_lies_in_a_zone_or_before_the_tape() {
        // From 870 to 1000 mm from the leading end.
        let piece = [leaning(0.0, 30.0)];
        assert_eq!(found(&piece, 0.0, &[(800.0, 870.0), (1000.0, 1010.0)]), 0);
        assert_eq!(found(&piece, 0.0, &[(800.0, 870.1)]), 1);
        assert_eq!(found(&piece, 0.0, &[(900.0, 901.0), (999.9, 1010.0)]), 2);
        assert_eq!(found(&[leaning(870.1, 30.0)], 0.0, &[]), 1);
    }
}
