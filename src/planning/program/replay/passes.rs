//! Cuts that are made more often than they are wanted.
//!
//! Two outlines that coincide may be cut once or once each, but one that is wanted once must not be cut twice.
//! So the passes of knives at a point are counted against the passes of wanted cuts. A pass is a connected
//! part of a curve within a circle around the point. Pieces of a curve in a circle are connected where the
//! joint between them lies in it too, so the passes are the pieces less the joints, and along a straight cut
//! each of these comes and goes at the ends of an exact span.
//!
//! The circles are chosen so that no good program is blamed: two cuts each within D of its place are two
//! wanted passes within D of them, so what counts as made within 2 D counts as wanted within 3 D; and two
//! knives that cut one place twice, each within D of it, are within 2 D of each other. Where one stroke ends
//! and another begins, both are in the circle. Such joints are no longer than the circle is wide and do not
//! count. So a cut made twice is found where it is longer than 6 D and no other cut is wanted within 3 D.

use super::ReplaySetup;
use super::breaks::{Breaks, lift_deg};
use super::curves::Curves;
use super::nearness::{Probe, Segment, Span};
use crate::planning::tape::machine::Cutter;

/// Rounding may break a run into two; a break up to this length in mm is none.
const BREAK_MM: f64 = 1e-6;

/// A part of a stroke that is cut more often than it is wanted.
#[derive(Debug, Clone, Copy)]
pub(super) struct Twice {
    /// The piece of the cuts made in which it begins.
    pub(super) piece: usize,
    /// Where it begins, (r, v) in mm.
    pub(super) from: [f64; 2],
    /// Where it ends, (r, v) in mm.
    pub(super) to: [f64; 2],
    /// Its length in mm.
    pub(super) length_mm: f64,
    /// Its share in mm of the length that is cut too often: with one cut too many among two it is a half of the
    /// length, since the other stroke has the other half.
    pub(super) share_mm: f64,
}

/// All that is cut too often. `within_mm` (D) is how far a cut may lie from its place. Where cuts go on beyond their
/// ends, two of them may lie on one another within an overcut of where wanted cuts break off, and cross elsewhere.
pub(super) fn twice(
    setup: &ReplaySetup<'_>,
    made: &Curves<'_>,
    wanted: &Curves<'_>,
    within_mm: f64,
) -> Vec<Twice> {
    let breaks = Breaks::of(setup, within_mm);
    let mut counter = Counter { made, wanted, within_mm, found: Vec::new(), changes: Vec::new() };
    let longest_joint_mm = 6.0 * within_mm + crossing_mm(setup, within_mm);
    let mut runs = Runs { open: None, done: Vec::new(), longest_joint_mm };
    for (index, piece) in made.pieces.iter().enumerate() {
        let ends = made.ends(index);
        let probe = Probe::along(ends);
        let same_curve = index > 0 && made.pieces[index - 1].curve() == piece.curve() && piece.joined;
        if !same_curve {
            runs.close();
        }
        counter.excess(&probe, ends, |from, to, share| {
            for part in breaks.beyond(&probe, (from, to)) {
                runs.add(index, &probe, part, share);
            }
        });
    }
    runs.close();
    runs.done
}

/// Two cuts that cross at an angle are within 2 D of one another for so long: an overcut goes straight on where its knife
/// lifts, at no less than the lift angle. At an angle below 5 degrees nobody can tell crossing from lying on one another.
fn crossing_mm(setup: &ReplaySetup<'_>, within_mm: f64) -> f64 {
    if setup.overcut_mm <= 0.0 {
        return 0.0;
    }
    // An axis beside its edge may hand a cut over to the other knife at a bend of any size, where both go straight on.
    let handed_over = setup.machine.cutters.iter().any(Cutter::swivels);
    let angle = lift_deg(setup).clamp(LEAST_CROSSING_DEG, 90.0).to_radians();
    4.0 * within_mm / angle.sin() + if handed_over { 2.0 * setup.overcut_mm } else { 0.0 }
}

/// See [`crossing_mm`].
const LEAST_CROSSING_DEG: f64 = 5.0;

/// What changes at a place of a probe.
#[derive(Debug, Clone, Copy, Default)]
struct Change {
    at: f64,
    made: i32,
    wanted: i32,
    covered: i32,
}

struct Counter<'a> {
    made: &'a Curves<'a>,
    wanted: &'a Curves<'a>,
    within_mm: f64,
    found: Vec<usize>,
    changes: Vec<Change>,
}

impl Counter<'_> {
    /// Calls `take` with each part of a probe that is cut too often, and the share of its excess.
    fn excess(&mut self, probe: &Probe, ends: Segment, mut take: impl FnMut(f64, f64, f64)) {
        self.changes.clear();
        self.count(self.made, probe, ends, 2.0, |change, step| change.made += step);
        let others = self.beside_others();
        let made = std::mem::take(&mut self.changes);
        for (from, to) in others {
            self.changes.clone_from(&made);
            // Only there it matters how many are wanted: of a cut of a million points this is next to nothing.
            let part = [probe.point(from), probe.point(to)];
            self.count(self.wanted, probe, part, 3.0, |change, step| change.wanted += step);
            self.count_covered(probe);
            self.changes.sort_by(|one, other| one.at.total_cmp(&other.at));
            self.take_excess((from, to), &mut take);
        }
        self.changes = made;
    }

    fn take_excess(&self, (from, to): Span, take: &mut impl FnMut(f64, f64, f64)) {
        let mut now = Change::default();
        for change in &self.changes {
            let (wanted, begin, end) = (now.wanted.max(1), now.at.max(from), change.at.min(to));
            if end > begin && now.covered > 0 && now.made > wanted {
                take(begin, end, f64::from(now.made - wanted) / f64::from(now.made));
            }
            now = Change {
                at: change.at,
                made: now.made + change.made,
                wanted: now.wanted + change.wanted,
                covered: now.covered + change.covered,
            };
        }
    }

    /// Pieces count one, joints take one away, within `widths` times D.
    fn count(
        &mut self,
        curves: &Curves<'_>,
        probe: &Probe,
        ends: Segment,
        widths: f64,
        mut add: impl FnMut(&mut Change, i32),
    ) {
        let radius = widths * self.within_mm;
        curves.near(ends, radius, &mut self.found);
        for place in &self.found {
            let piece = &curves.pieces[*place];
            let ends = curves.ends(*place);
            let joint = if piece.joined { probe.near_point(ends[0], radius) } else { None };
            let counted = [(probe.near_segment(ends, radius), 1), (joint, -1)];
            for (span, step) in counted {
                let Some((from, to)) = span else { continue };
                for (at, step) in [(from, step), (to, -step)] {
                    let mut change = Change { at, ..Change::default() };
                    add(&mut change, step);
                    self.changes.push(change);
                }
            }
        }
    }

    /// A cut that nobody wants at all is counted elsewhere. Uses what `count` found last: the wanted pieces.
    fn count_covered(&mut self, probe: &Probe) {
        for place in &self.found {
            let ends = self.wanted.ends(*place);
            let Some((from, to)) = probe.near_segment(ends, self.within_mm) else { continue };
            for (at, covered) in [(from, 1), (to, -1)] {
                self.changes.push(Change { at, covered, ..Change::default() });
            }
        }
    }

    /// Where anything but the probe's own piece and what joins it is near: without that, pieces and joints balance
    /// everywhere, as they do along nearly all cuts.
    fn beside_others(&mut self) -> Vec<Span> {
        self.changes.sort_by(|one, other| one.at.total_cmp(&other.at));
        let mut beside: Vec<Span> = Vec::new();
        let mut passes = 0;
        let mut before = 0.0;
        for change in &self.changes {
            if passes > 1 && change.at > before {
                match beside.last_mut() {
                    Some(last) if last.1 == before => last.1 = change.at,
                    _ => beside.push((before, change.at)),
                }
            }
            passes += change.made;
            before = change.at;
        }
        beside
    }
}

/// Puts parts together that follow each other along a stroke: each begins where the one before ends.
struct Runs {
    open: Option<Twice>,
    done: Vec<Twice>,
    longest_joint_mm: f64,
}

impl Runs {
    fn add(&mut self, piece: usize, probe: &Probe, (from, to): (f64, f64), share: f64) {
        let begin = probe.point(from);
        if self.open.is_some_and(|open| (begin[0] - open.to[0]).hypot(begin[1] - open.to[1]) > BREAK_MM) {
            self.close();
        }
        let empty = Twice { piece, from: begin, to: begin, length_mm: 0.0, share_mm: 0.0 };
        let open = self.open.get_or_insert(empty);
        open.to = probe.point(to);
        open.length_mm += to - from;
        open.share_mm += share * (to - from);
    }

    fn close(&mut self) {
        self.done.extend(self.open.take().filter(|run| run.length_mm > self.longest_joint_mm));
    }
}
