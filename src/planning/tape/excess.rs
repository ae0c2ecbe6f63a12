//! Outlines that more knives would be needed for than there are, changed on their scrap side (domain.md A5).
//!
//! A cut from edge to edge of the tape is an end of its piece. Each is changed alone (`end`); the ends of a short piece
//! may need too many knives only together, or beside a cut-out (`both`).

mod both;
mod end;

use both::Both;
use end::End;

use super::block::{Stretch, levels};
use super::chain::split;
use crate::planning::geometry::Point2;

/// A cut changed on its scrap side.
#[derive(Debug, Clone, PartialEq)]
pub struct Simplified {
    /// The cut, from the same end to the same end, in mm.
    pub points: Vec<Point2>,
    /// How far it lies from the ply at the most, along u, in mm.
    pub max_deviation_mm: f64,
    /// What it leaves beyond the ply, to be trimmed later, in mm^2.
    pub extra_area_mm2: f64,
}

/// How many chains of some cuts run side by side at the most. Cuts square across are places, and beside nothing.
#[must_use]
pub fn side_by_side<'a>(cuts: impl Iterator<Item = &'a [Point2]>, half_width_mm: f64) -> usize {
    let chains = cuts.flat_map(|cut| split(0, cut, half_width_mm)).filter(|chain| !chain.is_square());
    let spans: Vec<Stretch> = chains.map(|chain| chain.u_range()).collect();
    levels(&spans, spans.len()).iter().take_while(|level| !level.is_empty()).count()
}

/// What changes of the outline's cuts of a piece with these cut-outs, so that `knives` knives can make them all. Only
/// ends change; cuts that come back to the edge that they came from, and cut-outs, stay as they are.
#[must_use]
pub fn changes(
    cuts: &[&[Point2]],
    holes: &[Vec<Point2>],
    half_width_mm: f64,
    knives: usize,
) -> Vec<Option<Simplified>> {
    let (mut upper, mut lower, mut others) = (None, None, Vec::new());
    for (place, cut) in cuts.iter().enumerate() {
        match End::of(cut, half_width_mm) {
            Some(end) if end.is_turned() => lower = Some((place, end)),
            Some(end) => upper = Some((place, end)),
            None => others.push(*cut),
        }
    }
    others.extend(holes.iter().map(Vec::as_slice));
    let mut changes = vec![None; cuts.len()];
    for (place, end) in [&upper, &lower].into_iter().flatten() {
        if side_by_side(std::iter::once(cuts[*place]), half_width_mm) > knives {
            changes[*place] = Some(end.covered(knives));
        }
    }
    let changed = cuts.iter().zip(&changes).map(|(cut, change)| change.as_ref().map_or(*cut, |c| &c.points));
    let alone = changed.chain(holes.iter().map(Vec::as_slice));
    if let (Some((at_upper, upper)), Some((at_lower, lower))) = (&upper, &lower)
        && side_by_side(alone, half_width_mm) > knives
        && let Some([above, below]) = (Both { upper, lower, others, half_width_mm, knives }).changed()
    {
        (changes[*at_upper], changes[*at_lower]) = (Some(above), Some(below));
    }
    changes
}

#[cfg(test)]
mod tests;
