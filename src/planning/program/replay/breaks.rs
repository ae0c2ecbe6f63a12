//! Where wanted cuts end or a knife may lift on them: there, and only there, strokes go on by their overcut, and two of
//! them may lie on one another.

use super::ReplaySetup;
use super::nearness::{Probe, Span, gaps};

/// Places at which strokes end, each with the way that an overcut may reach from it.
pub(super) struct Breaks {
    /// (r, v) in mm, in increasing r.
    at: Vec<[f64; 2]>,
    reach_mm: f64,
}

impl Breaks {
    /// The ends of wanted cuts, the places at which they turn back along the tape, and corners of more than half of the
    /// angle at which knives lift (thinning may make a corner sharper). None on a machine that does not overcut.
    pub(super) fn of(setup: &ReplaySetup<'_>, within_mm: f64) -> Self {
        let mut at = Vec::new();
        if setup.overcut_mm > 0.0 {
            let sharp_deg = lift_deg(setup) / 2.0;
            setup.wanted.iter().for_each(|cut| add(&cut.points, sharp_deg, &mut at));
            at.sort_by(|one, other| one[0].total_cmp(&other[0]).then(one[1].total_cmp(&other[1])));
        }
        Self { at, reach_mm: setup.overcut_mm + 3.0 * within_mm }
    }

    /// The parts of a span of a probe that lie beyond the reach of every break.
    pub(super) fn beyond(&self, probe: &Probe, (from, to): Span) -> Vec<Span> {
        let ends = [probe.point(from)[0], probe.point(to)[0]];
        let (low, high) = (ends[0].min(ends[1]) - self.reach_mm, ends[0].max(ends[1]) + self.reach_mm);
        let first = self.at.partition_point(|at| at[0] < low);
        let near = self.at[first..].iter().take_while(|at| at[0] <= high);
        gaps(near.filter_map(|at| probe.near_point(*at, self.reach_mm)).collect(), (from, to))
    }
}

/// The smallest angle at which a knife of the machine lifts, in degrees.
pub(super) fn lift_deg(setup: &ReplaySetup<'_>) -> f64 {
    setup.machine.cutters.iter().map(|cutter| cutter.lift_angle.degrees()).fold(180.0, f64::min)
}

fn add(points: &[[f64; 2]], sharp_deg: f64, at: &mut Vec<[f64; 2]>) {
    let (Some(first), Some(last)) = (points.first(), points.last()) else { return };
    at.extend([*first, *last]);
    for corner in points.windows(3) {
        let way = |one: [f64; 2], other: [f64; 2]| [other[0] - one[0], other[1] - one[1]];
        let (before, after) = (way(corner[0], corner[1]), way(corner[1], corner[2]));
        let (cross, dot) =
            (before[0] * after[1] - before[1] * after[0], before[0] * after[0] + before[1] * after[1]);
        if cross.atan2(dot).to_degrees().abs() > sharp_deg {
            at.push(corner[1]);
        }
    }
    add_turns_back(points, at);
}

/// A turn back along the tape of less than this, in mm, is none to a knife: half of what divides chains (domain.md A5).
const TURN_BACK_MM: f64 = 0.005;

/// The places at which a cut turns back along the tape.
fn add_turns_back(points: &[[f64; 2]], at: &mut Vec<[f64; 2]>) {
    // +1 or -1 once it is known which way the cut goes.
    let (mut way, mut farthest) = (0.0, points[0]);
    for point in points {
        let forward = (point[0] - farthest[0]) * way;
        if way == 0.0 && (point[0] - farthest[0]).abs() > TURN_BACK_MM {
            (way, farthest) = ((point[0] - farthest[0]).signum(), *point);
        } else if forward > 0.0 {
            farthest = *point;
        } else if -forward > TURN_BACK_MM {
            at.push(farthest);
            (way, farthest) = (-way, *point);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_lies_beyond_every_break_is_left() {
        let breaks = Breaks { at: vec![[0.0, 0.0], [4.0, 0.0], [10.0, 50.0]], reach_mm: 1.0 };
        let probe = Probe::along([[-2.0, 0.0], [8.0, 0.0]]);
        assert_eq!(breaks.beyond(&probe, (0.0, 10.0)), [(0.0, 1.0), (3.0, 5.0), (7.0, 10.0)]);
        assert_eq!(breaks.beyond(&probe, (1.5, 2.5)), []);
        assert_eq!(breaks.beyond(&probe, (3.5, 4.5)), [(3.5, 4.5)]);
    }

    #[test]
    fn ends_corners_and_turns_back_are_breaks_and_gentle_bends_are_none() {
        let mut at = Vec::new();
        add(&[[0.0, 0.0], [10.0, 0.0], [20.0, 1.0], [30.0, 9.0], [29.0, 20.0], [28.0, 31.0]], 7.5, &mut at);
        assert_eq!(at, [[0.0, 0.0], [28.0, 31.0], [20.0, 1.0], [30.0, 9.0], [30.0, 9.0]]);
    }
}
