//! How far two knives miss one another at a tip that both of them cut, for given errors of the axes (the companion
//! paper's Fig. 10).
//!
//! Both knives of a ">" begin at its tip and both of a "<" end there, at two moments: between them the tape runs by
//! the distance of the cutters. If the tape stands off by up to `feed.error_mm` at either moment, and a spool's radius
//! was measured with an error that makes each mm of tape longer by `dr / r`, the places miss one another by
//!
//! ```text
//! dU = 2 e_feed + D dr / r        dV = e_lateral1 + e_lateral2
//! ```
//!
//! at worst, each with either sign. Where the cuts then do not meet, a bridge holds scrap and piece together; cuts
//! that go on beyond their tips by `severing_overcut_mm` part it whatever the signs are.

use serde::Serialize;

use super::chain::Chain;
use super::label::CourseLabel;
use super::machine::Machine;
use super::plan::{PlannedPiece, TapePlan};
use crate::planning::finding::{Code, Finding};
use crate::planning::geometry::{Point2, Vector2};
use crate::planning::program::number::fixed;
use crate::planning::tolerance::SAME_POINT_MM;

/// Which way a tip points, U to the right.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum TipKind {
    /// Both knives begin here.
    #[serde(rename = ">")]
    Greater,
    /// Both knives end here.
    #[serde(rename = "<")]
    Less,
}

/// A tip that two knives cut.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Tip {
    /// Number of the ply, where there are several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ply: Option<u32>,
    /// Number of the course.
    pub course: u32,
    /// Piece of the course, from 1.
    pub piece: usize,
    /// Which cut of the piece, from 0.
    pub cut: usize,
    /// Which way it points.
    pub kind: TipKind,
    /// Its place in the course.
    pub at_uv: [f64; 2],
    /// The cutters, in the order of the cut's chains.
    pub cutters: [u32; 2],
    /// The largest miss along U.
    pub feed_mismatch_mm: f64,
    /// The largest miss along V.
    pub lateral_mismatch_mm: f64,
    /// Both together.
    pub mismatch_mm: f64,
    /// How far both cuts must go on beyond the tip to meet, whatever the signs of the errors.
    pub severing_overcut_mm: f64,
    /// What a spool driven as if its radius stayed that of the beginning would miss along U; none where the tape is
    /// measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub uncorrected_feed_mismatch_mm: Option<f64>,
    /// The directions of both cuts away from the tip.
    #[serde(skip)]
    pub ways: [Vector2; 2],
}

/// All tips of a plan that two knives cut, in laying order.
#[must_use]
pub fn tips(plan: &TapePlan, machine: &Machine) -> Vec<Tip> {
    let mut tips = Vec::new();
    for course in &plan.courses {
        for (index, piece) in course.pieces.iter().enumerate() {
            for (one, other) in meeting(piece) {
                let both = [TipKind::Greater, TipKind::Less];
                let found = both.map(|kind| tip(piece, (one, other), kind, plan.figures.lead_mm, machine));
                let named =
                    |tip| Tip { ply: course.label.ply, course: course.label.number, piece: index + 1, ..tip };
                tips.extend(found.into_iter().flatten().map(named));
            }
        }
    }
    tips
}

/// Says that the cuts at tips do not go on far enough to meet whatever the signs of the profile's errors are.
#[must_use]
pub fn lacking_overcut(tips: &[Tip], machine: &Machine) -> Option<Finding> {
    let overcut = |tip: &Tip| {
        let of_tip = machine.cutters.iter().filter(|cutter| tip.cutters.contains(&cutter.number));
        of_tip.map(|cutter| cutter.overcut.mm()).fold(f64::INFINITY, f64::min)
    };
    let lacking: Vec<&Tip> =
        tips.iter().filter(|tip| tip.severing_overcut_mm > overcut(tip) + SAME_POINT_MM).collect();
    let worst = lacking.iter().max_by(|a, b| a.severing_overcut_mm.total_cmp(&b.severing_overcut_mm))?;
    let message = format!(
        "for the errors in the profile the cuts of two knives may not meet at {} tips: at the one of course {}, piece {}, \
         they would have to go on by {} mm, and overcut_mm is {}",
        lacking.len(),
        CourseLabel { ply: worst.ply, number: worst.course },
        worst.piece,
        fixed(worst.severing_overcut_mm, 3),
        overcut(worst)
    );
    Some(Finding::warning(Code::OvercutTooShort, "/input/machine", message))
}

type Given = (Chain, usize);

/// Chains of one cut that follow one another along it; those of a closed cut in a ring. Two chains may meet at both ends.
fn meeting(piece: &PlannedPiece) -> Vec<(&Given, &Given)> {
    let cuts = piece.chains.chunk_by(|one, other| one.0.cut == other.0.cut);
    cuts.flat_map(|chains| {
        let ring = chains.len() > 2 && chains.first().is_some_and(|(chain, _)| !chain.edge_to_edge);
        let pairs = chains.windows(2).map(|pair| (&pair[0], &pair[1]));
        pairs.chain(ring.then(|| chains.last().zip(chains.first())).flatten())
    })
    .collect()
}

fn tip(
    piece: &PlannedPiece,
    ((one, knife), (other, other_knife)): (&Given, &Given),
    kind: TipKind,
    lead_mm: f64,
    machine: &Machine,
) -> Option<Tip> {
    let [at, met] = [one, other].map(|chain| match kind {
        TipKind::Greater => chain.points.first(),
        TipKind::Less => chain.points.last(),
    });
    let at = *at.filter(|_| knife != other_knife && at == met)?;
    let ways = [one, other].map(|chain| way(chain, kind)).map(Option::unwrap_or_default);
    let cutters = [*knife, *other_knife].map(|knife| &machine.cutters[knife]);
    let apart_mm = (cutters[1].station.mm() - cutters[0].station.mm()).abs();
    let x = lead_mm - piece.offset_mm - at.x + cutters[0].station.mm().min(cutters[1].station.mm());
    let feed_mm = 2.0 * machine.feed.error.mm() + apart_mm * radius_share(machine, x);
    let lateral_mm = cutters.iter().map(|cutter| cutter.lateral_error.mm()).sum();
    let radius = |spool: &super::spool::Spool| spool.radius_mm(x) / spool.roll_radius_mm;
    Some(Tip {
        ply: None,
        course: 0,
        piece: 0,
        cut: one.cut,
        kind,
        at_uv: [at.x, at.y],
        cutters: cutters.map(|cutter| cutter.number),
        feed_mismatch_mm: feed_mm,
        lateral_mismatch_mm: lateral_mm,
        mismatch_mm: feed_mm.hypot(lateral_mm),
        severing_overcut_mm: severing_mm(ways, feed_mm, lateral_mm),
        uncorrected_feed_mismatch_mm: machine
            .feed
            .spool
            .as_ref()
            .map(|spool| apart_mm * (1.0 - radius(spool)).abs()),
        ways,
    })
}

/// The direction in which a chain leaves its tip, of length 1.
fn way(chain: &Chain, kind: TipKind) -> Option<Vector2> {
    let from_tip = |pair: &[Point2]| match kind {
        TipKind::Greater => pair[1] - pair[0],
        TipKind::Less => pair[0] - pair[1],
    };
    let mut ways = chain.points.windows(2).map(from_tip).filter(|way| way.norm() > 0.0);
    let first = if kind == TipKind::Greater { ways.next() } else { ways.next_back() };
    first.map(|way| way.normalize())
}

/// By how much each mm of tape is longer than it should be: `dr / r`, where an error of the radius at the beginning is
/// `r0 / r` times as large at r, because the area that has gone is known.
fn radius_share(machine: &Machine, x: f64) -> f64 {
    machine.feed.spool.as_ref().map_or(0.0, |spool| {
        let radius = spool.radius_mm(x);
        spool.radius_error_mm * spool.roll_radius_mm / (radius * radius)
    })
}

/// How far two straight cuts must go on behind their tips to meet if these miss one another by (+-du, +-dv): with
/// the tips at 0 and d, `s a = d + t b` gives where the lines cross; negative s and t lie behind the tips.
fn severing_mm([a, b]: [Vector2; 2], du: f64, dv: f64) -> f64 {
    let across = a.perp(&b);
    // Cuts that leave a tip in one line meet at its place whatever happens along them.
    if across.abs() < SAME_DIRECTION {
        return du.hypot(dv);
    }
    let signs = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];
    let behind = signs.map(|(u, v)| {
        let d = Vector2::new(u * du, v * dv);
        let (s, t) = (d.perp(&b) / across, d.perp(&a) / across);
        (-s).max(-t)
    });
    behind.into_iter().fold(0.0, f64::max)
}

/// Sine of the angle between two cuts below which they lie in one line.
const SAME_DIRECTION: f64 = 1e-3;

#[cfg(test)]
mod tests {
    use super::*;

    /// A tip of 90 degrees: a miss by d along U leaves legs that cross d / sqrt 2 behind the tip of one of them.
    #[test]
    fn a_right_angled_tip_is_severed_by_hand_worked_overcuts() {
        let diagonal = 0.5_f64.sqrt();
        let ways = [Vector2::new(-diagonal, diagonal), Vector2::new(-diagonal, -diagonal)];
        assert!((severing_mm(ways, 0.1, 0.0) - 0.1 * diagonal).abs() < 1e-12);
        assert!((severing_mm(ways, 0.0, 0.2) - 0.2 * diagonal).abs() < 1e-12);
        assert!((severing_mm(ways, 0.1, 0.2) - 0.3 * diagonal).abs() < 1e-12);
        assert_eq!(severing_mm([ways[0], -ways[0]], 0.3, 0.4), 0.5);
    }
}
