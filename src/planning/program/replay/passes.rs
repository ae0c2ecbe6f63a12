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

use super::curves::Curves;
use super::nearness::Probe;

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
/// ends by `overcut_mm`, two of them may lie side by side for that long each.
pub(super) fn twice(made: &Curves, wanted: &Curves, within_mm: f64, overcut_mm: f64) -> Vec<Twice> {
    let mut counter = Counter { made, wanted, within_mm, found: Vec::new(), changes: Vec::new() };
    let mut runs =
        Runs { open: None, done: Vec::new(), longest_joint_mm: 6.0 * within_mm + 2.0 * overcut_mm };
    for (index, piece) in made.pieces.iter().enumerate() {
        let probe = Probe::along(piece.ends);
        let same_curve = index > 0 && made.pieces[index - 1].curve == piece.curve && piece.joined;
        if !same_curve {
            runs.close();
        }
        counter.excess(&probe, piece.ends, |from, to, share| runs.add(index, &probe, (from, to), share));
    }
    runs.close();
    runs.done
}

/// What changes at a place of a probe.
#[derive(Debug, Clone, Copy, Default)]
struct Change {
    at: f64,
    made: i32,
    wanted: i32,
    covered: i32,
}

struct Counter<'a> {
    made: &'a Curves,
    wanted: &'a Curves,
    within_mm: f64,
    found: Vec<u32>,
    changes: Vec<Change>,
}

impl Counter<'_> {
    /// Calls `take` with each part of a probe that is cut too often, and the share of its excess.
    fn excess(&mut self, probe: &Probe, ends: [[f64; 2]; 2], mut take: impl FnMut(f64, f64, f64)) {
        self.changes.clear();
        self.count(self.made, probe, ends, 2.0, |change, step| change.made += step);
        if !self.meets_another() {
            return;
        }
        self.count(self.wanted, probe, ends, 3.0, |change, step| change.wanted += step);
        self.count_covered(probe);
        self.changes.sort_by(|one, other| one.at.total_cmp(&other.at));
        let mut now = Change::default();
        for change in &self.changes {
            let wanted = now.wanted.max(1);
            if change.at > now.at && now.covered > 0 && now.made > wanted {
                take(now.at, change.at, f64::from(now.made - wanted) / f64::from(now.made));
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
        curves: &Curves,
        probe: &Probe,
        ends: [[f64; 2]; 2],
        widths: f64,
        mut add: impl FnMut(&mut Change, i32),
    ) {
        let radius = widths * self.within_mm;
        curves.near(ends, radius, &mut self.found);
        for place in &self.found {
            let piece = &curves.pieces[*place as usize];
            let joint = if piece.joined { probe.near_point(piece.ends[0], radius) } else { None };
            let counted = [(probe.near_segment(piece.ends, radius), 1), (joint, -1)];
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
            let ends = self.wanted.pieces[*place as usize].ends;
            let Some((from, to)) = probe.near_segment(ends, self.within_mm) else { continue };
            for (at, covered) in [(from, 1), (to, -1)] {
                self.changes.push(Change { at, covered, ..Change::default() });
            }
        }
    }

    /// Whether anything but the probe's own piece and what joins it is near: without that, pieces and joints
    /// balance everywhere, as they do along nearly all cuts.
    fn meets_another(&mut self) -> bool {
        self.changes.sort_by(|one, other| one.at.total_cmp(&other.at));
        let mut passes = 0;
        let mut before = 0.0;
        for change in &self.changes {
            if passes > 1 && change.at > before {
                return true;
            }
            passes += change.made;
            before = change.at;
        }
        false
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
