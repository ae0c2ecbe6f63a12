//! Cuts made against cuts wanted: what is missing, what is too much, how far the rest is off.

use super::ReplaySetup;
use super::curves::Curves;
use super::faults::Faults;
use super::nearness::{GAP_MM, Probe, Segment, Span, distance, far_parts, is_near, to_segment};
use super::strokes::Stroke;
use super::{overcut, passes};
use crate::planning::finding::Code;
use crate::planning::tolerance::REPLAY_SLACK_MM;

/// A cut up to this far, in mm, from a wanted one is that cut in a wrong place; beyond, it is another cut.
const BELONGS_MM: f64 = 1.0;

/// This length in mm of missing, and of unwanted, cuts in a whole roll is no fault: rounded ends of strokes.
/// It equals twice the positioning of the knives, and no point of it may be out of tolerance all the same.
const NEGLIGIBLE_MM: f64 = 0.02;

/// The figures of a comparison, in mm.
pub(super) struct Compared {
    pub(super) max_deviation_mm: f64,
    pub(super) uncut_mm: f64,
    pub(super) unwanted_mm: f64,
    pub(super) overcut_mm: f64,
}

/// Compares the strokes of a program with the wanted cuts.
pub(super) fn compare(setup: &ReplaySetup<'_>, strokes: &[Stroke], faults: &mut Faults<'_>) -> Compared {
    let within_mm = setup.tolerance_mm + REPLAY_SLACK_MM;
    let wanted = Curves::of(setup.wanted.iter().map(|cut| cut.points.as_slice()));
    let made = Curves::of(strokes.iter().map(|stroke| stroke.points.as_slice()));
    let mut extra = Side::of(&made, &wanted, within_mm);
    let overcut_mm = extra.take_overcuts(setup, strokes, &made, within_mm);
    let comparison = Comparison {
        setup,
        strokes,
        within_mm,
        missing: Side::of(&wanted, &made, within_mm),
        extra,
        overcut_mm,
        twice: passes::twice(setup, &made, &wanted, within_mm),
        wanted,
        made,
    };
    comparison.judge(faults)
}

/// The distance of some curves, the probes, from others.
struct Side {
    /// The largest distance of a piece that is near all along, in mm.
    worst_mm: f64,
    /// That piece.
    worst: Option<usize>,
    /// What is not near.
    runs: Vec<Run>,
}

/// A part of a curve that is farther than it may be from anything.
struct Run {
    /// Piece in which it begins.
    piece: usize,
    from: [f64; 2],
    to: [f64; 2],
    length_mm: f64,
    /// The largest distance if it all belongs to some cut, none if it reaches where there is none.
    off_mm: Option<f64>,
}

impl Side {
    fn of(probes: &Curves<'_>, others: &Curves<'_>, within_mm: f64) -> Self {
        let mut measure = Measure { others, found: Vec::new(), near: Vec::new(), beside: None };
        let mut side = Self { worst_mm: 0.0, worst: None, runs: Vec::new() };
        let mut open: Vec<(usize, Probe, Span)> = Vec::new();
        for (index, piece) in probes.pieces.iter().enumerate() {
            let ends = probes.ends(index);
            let follows = index > 0 && piece.joined && probes.pieces[index - 1].curve() == piece.curve();
            if measure.runs_beside(ends, side.worst_mm) {
                side.close(&mut open, probes, &mut measure, within_mm);
                continue;
            }
            let probe = Probe::along(ends);
            let far = measure.far(&probe, ends, within_mm);
            if far.is_empty() {
                side.tighten(index, &probe, &measure, within_mm);
            }
            if !follows || far.first().is_none_or(|(from, _)| *from > GAP_MM) {
                side.close(&mut open, probes, &mut measure, within_mm);
            }
            for part in far {
                open.push((index, probe, part));
                if part.1 < probe.length - GAP_MM {
                    side.close(&mut open, probes, &mut measure, within_mm);
                }
            }
        }
        side.close(&mut open, probes, &mut measure, within_mm);
        side
    }

    /// Only a piece that exceeds the worst so far is measured; the others are seen not to exceed it.
    ///
    /// A piece that is near in part only says nothing here: its distance grows to the limit where its run begins.
    fn tighten(&mut self, piece: usize, probe: &Probe, measure: &Measure<'_>, within_mm: f64) {
        let off_mm = distance(probe, (0.0, probe.length), &measure.near, self.worst_mm, within_mm);
        if off_mm > self.worst_mm {
            (self.worst_mm, self.worst) = (off_mm, Some(piece));
        }
    }

    fn close(
        &mut self,
        open: &mut Vec<(usize, Probe, Span)>,
        probes: &Curves<'_>,
        measure: &mut Measure<'_>,
        within_mm: f64,
    ) {
        let (Some((piece, first, begin)), Some((_, last, end))) = (open.first(), open.last()) else { return };
        let belongs_mm = BELONGS_MM.max(2.0 * within_mm);
        let off_mm = open.iter().try_fold(within_mm, |off_mm, (piece, probe, part)| {
            measure.look(probes.ends(*piece), belongs_mm);
            is_near(probe, *part, &measure.near, belongs_mm)
                .then(|| distance(probe, *part, &measure.near, off_mm, belongs_mm))
        });
        let length_mm = open.iter().map(|(_, _, (from, to))| to - from).sum();
        let (from, to) = (first.point(begin.0), last.point(end.1));
        self.runs.push(Run { piece: *piece, from, to, length_mm, off_mm });
        open.clear();
    }

    /// Takes out what is cut beyond the end of a stroke as the machine's overcut allows, and gives its length in mm.
    fn take_overcuts(
        &mut self,
        setup: &ReplaySetup<'_>,
        strokes: &[Stroke],
        made: &Curves<'_>,
        within_mm: f64,
    ) -> f64 {
        let mut taken_mm = 0.0;
        self.runs.retain(|run| {
            let stroke = &strokes[made.pieces[run.piece].curve()];
            let allowed = overcut::is_overcut(setup, stroke, (run.from, run.to, run.length_mm), within_mm);
            taken_mm += if allowed { run.length_mm } else { 0.0 };
            !allowed
        });
        taken_mm
    }

    /// The largest deviation of what belongs together, and its piece.
    fn deviation(&self) -> (f64, Option<usize>) {
        let displaced = self.runs.iter().filter_map(|run| run.off_mm.map(|off_mm| (off_mm, Some(run.piece))));
        displaced.fold((self.worst_mm, self.worst), |most, next| if next.0 > most.0 { next } else { most })
    }

    fn length_mm(&self) -> f64 {
        self.runs.iter().map(|run| run.length_mm).sum()
    }
}

/// Looks for what is near a piece.
struct Measure<'a> {
    others: &'a Curves<'a>,
    found: Vec<usize>,
    near: Vec<Segment>,
    /// The other piece that lies beside the end of the last probe, where it is known.
    beside: Option<usize>,
}

impl Measure<'_> {
    /// Whether all of a probe is seen at once to lie within a radius of the others: of one of them, or of several that
    /// follow each other. Most probes do, and go on beside the other where the one before has ended.
    ///
    /// From a place near the probe's beginning to one near its end there is a way along the others that is nowhere farther
    /// from the probe than the radius, so the nearest points of the probe to it pass along all of the probe in between.
    fn runs_beside(&mut self, probe: Segment, radius: f64) -> bool {
        let Some(first) = self.beside else { return false };
        let pieces = &self.others.pieces;
        if to_segment(probe[0], self.others.ends(first)) > radius {
            return false;
        }
        let joined =
            |index: usize| pieces[index].joined && pieces[index - 1].curve() == pieces[index].curve();
        let within = |index: &usize| to_segment(probe[1], self.others.ends(*index)) <= radius;
        let passes = |place: [f64; 2]| to_segment(place, probe) <= radius;
        let onward = (first + 1..pieces.len()).take_while(|&i| joined(i) && passes(self.others.ends(i)[0]));
        let back =
            (1..=first).rev().take_while(|&i| joined(i) && passes(self.others.ends(i)[0])).map(|i| i - 1);
        let found = std::iter::once(first).chain(onward).find(&within).or_else(|| back.clone().find(&within));
        self.beside = found.or(self.beside);
        found.is_some()
    }

    fn look(&mut self, ends: Segment, radius: f64) {
        self.others.near(ends, radius, &mut self.found);
        self.near.clear();
        self.near.extend(self.found.iter().map(|place| self.others.ends(*place)));
    }

    fn far(&mut self, probe: &Probe, ends: Segment, radius: f64) -> Vec<Span> {
        self.look(ends, radius);
        let off = |place: &usize| to_segment(ends[1], self.others.ends(*place));
        let nearest = self.found.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
        self.beside = nearest.copied();
        far_parts(probe, (0.0, probe.length), &self.near, radius)
    }
}

struct Comparison<'a> {
    setup: &'a ReplaySetup<'a>,
    strokes: &'a [Stroke],
    within_mm: f64,
    wanted: Curves<'a>,
    made: Curves<'a>,
    missing: Side,
    extra: Side,
    overcut_mm: f64,
    twice: Vec<passes::Twice>,
}

impl Comparison<'_> {
    fn judge(&self, faults: &mut Faults<'_>) -> Compared {
        let nowhere = |curves: &Curves<'_>| curves.misplaced.iter().map(|piece| piece.length_mm).sum::<f64>();
        let twice_mm: f64 = self.twice.iter().map(|run| run.share_mm).sum();
        // An empty sum is -0.0; a report says 0.0.
        let uncut_mm = 0.0 + self.missing.length_mm() + nowhere(&self.wanted);
        let unwanted_mm = 0.0 + self.extra.length_mm() + nowhere(&self.made) + twice_mm;
        if uncut_mm > NEGLIGIBLE_MM {
            self.say_uncut(faults);
        }
        if unwanted_mm > NEGLIGIBLE_MM {
            self.say_unwanted(faults);
        }
        let max_deviation_mm = self.judge_deviation(faults);
        Compared { max_deviation_mm, uncut_mm, unwanted_mm, overcut_mm: self.overcut_mm }
    }

    fn say_uncut(&self, faults: &mut Faults<'_>) {
        for run in &self.missing.runs {
            let course = self.setup.wanted[self.wanted.pieces[run.piece].curve()].course;
            faults.at_program(Code::Uncut, || {
                format!("course {course}: {} is not cut{}", place(run.from, run.to, run.length_mm), off(run))
            });
        }
        for piece in &self.wanted.misplaced {
            let course = self.setup.wanted[piece.curve].course;
            faults.at_program(Code::Uncut, || {
                format!("course {course}: step {} of a cut is not a place on any roll", piece.step)
            });
        }
    }

    fn say_unwanted(&self, faults: &mut Faults<'_>) {
        for run in &self.extra.runs {
            faults.at_line(Code::Unwanted, self.line(run.piece), || {
                format!("{} is cut and not wanted{}", place(run.from, run.to, run.length_mm), off(run))
            });
        }
        for run in &self.twice {
            faults.at_line(Code::Unwanted, self.line(run.piece), || {
                format!("{} is cut more often than it is wanted", place(run.from, run.to, run.length_mm))
            });
        }
        for piece in &self.made.misplaced {
            faults.at_line(Code::Unwanted, self.strokes[piece.curve].lines[piece.step], || {
                format!("{} mm are cut outside of any roll", piece.length_mm)
            });
        }
    }

    /// The largest deviation in mm; a finding if it is too large.
    fn judge_deviation(&self, faults: &mut Faults<'_>) -> f64 {
        let (wanted_mm, wanted) = self.missing.deviation();
        let (made_mm, made) = self.extra.deviation();
        let most =
            |off_mm: f64, allowed_mm: f64| format!("{off_mm:.6} mm off; {allowed_mm:.6} mm are allowed");
        if let Some(piece) = wanted.filter(|_| wanted_mm > self.within_mm) {
            let course = self.setup.wanted[self.wanted.pieces[piece].curve()].course;
            let [r, v] = self.wanted.ends(piece)[0];
            faults.at_program(Code::Deviation, || {
                let most = most(wanted_mm, self.within_mm);
                format!("course {course}: a cut wanted from r = {r:.4}, v = {v:.4} mm on is made {most}")
            });
        }
        if let Some(piece) = made.filter(|_| made_mm > self.within_mm) {
            faults.at_line(Code::Deviation, self.line(piece), || {
                format!("a cut is made {}", most(made_mm, self.within_mm))
            });
        }
        wanted_mm.max(made_mm)
    }

    /// The program line that makes a piece.
    fn line(&self, made: usize) -> usize {
        let piece = &self.made.pieces[made];
        self.strokes[piece.curve()].lines[piece.step()]
    }
}

fn place(from: [f64; 2], to: [f64; 2], length_mm: f64) -> String {
    let [r0, v0] = from;
    let [r1, v1] = to;
    format!("r {r0:.4} to {r1:.4}, v {v0:.4} to {v1:.4}, {length_mm:.4} mm long,")
}

fn off(run: &Run) -> String {
    run.off_mm.map_or(String::new(), |off_mm| format!("; a cut lies {off_mm:.4} mm off"))
}

#[cfg(test)]
mod tests {
    use super::*;

    proptest::proptest! {
        /// A walk with noise and folds, and another one through some of its points: whatever is seen at once to be near
        /// is near by the exact spans too.
        #[test]
        fn what_runs_beside_the_others_is_near_them(
            steps in proptest::collection::vec([-1.0..3.0f64, -1.0..1.0f64], 5..60), every in 1..6_usize,
            radius in 0.05..3.0f64, back in proptest::bool::ANY,
        ) {
            let mut walk = vec![[0.0, 0.0]];
            for [r, v] in steps {
                let [last_r, last_v] = walk[walk.len() - 1];
                walk.push([last_r + r, last_v + v]);
            }
            let mut coarse: Vec<_> = walk.iter().copied().step_by(every).collect();
            if back {
                coarse.reverse();
            }
            for (probes, others) in [(&walk, &coarse), (&coarse, &walk)] {
                let (probes, others) = [probes, others].map(|points| Curves::of(std::iter::once(points.as_slice()))).into();
                let mut measure = Measure { others: &others, found: Vec::new(), near: Vec::new(), beside: None };
                for ends in (0..probes.pieces.len()).map(|piece| probes.ends(piece)) {
                    let probe = Probe::along(ends);
                    if measure.runs_beside(ends, radius) {
                        measure.look(ends, radius + 1.0);
                        let far = far_parts(&probe, (0.0, probe.length), &measure.near, radius + 1e-9);
                        proptest::prop_assert!(far.is_empty(), "{:?} {far:?}", ends);
                    } else {
                        measure.far(&probe, ends, radius);
                    }
                }
            }
        }
    }

    #[test]
    fn a_thinned_line_is_followed_without_looking_for_what_is_near() {
        let fine: Vec<_> = (0..=1000).map(|i| [f64::from(i) * 0.1, 0.004 * f64::from(i % 3)]).collect();
        let coarse: Vec<_> = fine.iter().rev().copied().step_by(100).collect();
        let (fine, coarse) =
            (Curves::of([fine.as_slice()].into_iter()), Curves::of([coarse.as_slice()].into_iter()));
        for (probes, others) in [(&fine, &coarse), (&coarse, &fine)] {
            let mut measure = Measure { others, found: Vec::new(), near: Vec::new(), beside: None };
            measure.far(&Probe::along(probes.ends(0)), probes.ends(0), 0.01);
            let seen = (1..probes.pieces.len())
                .filter(|piece| measure.runs_beside(probes.ends(*piece), 0.01))
                .count();
            assert_eq!(seen, probes.pieces.len() - 1);
        }
    }
}
