//! Where the edge of a blade is that lies beside the axis that turns it.
//!
//! Positive, it trails behind the axis along the cut: with b the unit vector of the blade as its axis reads, the edge
//! stands at `axis - e b` where the axis moves along b. A blade of one edge must do that; one of two edges may as well
//! move against b, all the way from going down to coming up, and then the edge that trails is the other one, at
//! `axis + e b`. Which of the two it is, is seen by the whole stroke: a turn about the edge moves the axis square to b.

use super::blade::{self, Cut};
use super::faults::Faults;
use super::reel::STRAIGHT_MM;
use super::strokes::Stroke;
use super::travel::{PRINTED_DEG, PRINTED_MM};
use crate::planning::tape::machine::Cutter;
use crate::planning::tolerance::REPLAY_SLACK_MM;

/// A move is looked at in no more parts than this for the turn of its blade: half a turn at an offset of 1 m.
const MOST_PARTS: usize = 1000;

/// In how many even parts a move is looked at while a blade turns by so many degrees: between them the edge, which
/// goes round its axis, is straight to the same measure as a cut that a spool bends.
pub(super) fn parts(cutter: &Cutter, turn_deg: f64) -> usize {
    let off_mm = cutter.offset.mm().abs() * turn_deg.to_radians().powi(2) / 8.0;
    ((off_mm / STRAIGHT_MM).sqrt().ceil() as usize).clamp(1, MOST_PARTS)
}

/// The way of an axis whose knife is down.
pub(super) struct Trail {
    places: Vec<Place>,
}

/// The axis over the roll.
struct Place {
    at: [f64; 2],
    blade_deg: f64,
    /// The line of the move that led here.
    line: usize,
    /// Whether the move ends here.
    whole: bool,
}

impl Trail {
    /// A knife goes down with its axis and blade here.
    pub(super) fn at(at: [f64; 2], blade_deg: f64) -> Self {
        Self { places: vec![Place { at, blade_deg, line: 0, whole: true }] }
    }

    /// The axis goes on to a place, which is the end of its move or one on the way there.
    pub(super) fn go(&mut self, at: [f64; 2], blade_deg: f64, line: usize, whole: bool) {
        self.places.push(Place { at, blade_deg, line, whole });
    }

    /// The cut of the edge, with the blade checked along it.
    pub(super) fn finish(&self, cutter: &Cutter, faults: &mut Faults<'_>) -> Stroke {
        let edge = self.edge(cutter);
        let mut stroke = Stroke::at(edge[0]);
        for (pair, place) in edge.windows(2).zip(&self.places[1..]) {
            if pair[0] != pair[1] {
                stroke.cut_to(pair[1], place.line);
            }
        }
        self.check_blade(cutter, &edge, faults);
        stroke
    }

    fn edge(&self, cutter: &Cutter) -> Vec<[f64; 2]> {
        let trails_mm = cutter.offset.mm();
        let stands = |place: &Place| {
            let blade = unit(place.blade_deg);
            [place.at[0] - trails_mm * blade[0], place.at[1] - trails_mm * blade[1]]
        };
        self.places.iter().map(stands).collect()
    }

    /// Each move as a whole; one that takes the edge nowhere is a turn on the spot.
    fn check_blade(&self, cutter: &Cutter, edge: &[[f64; 2]], faults: &mut Faults<'_>) {
        let printed_mm = 2.0 * (PRINTED_MM + cutter.offset.mm().abs() * PRINTED_DEG.to_radians());
        let noise_mm = printed_mm * std::f64::consts::SQRT_2 + REPLAY_SLACK_MM;
        let mut corner = blade::Corner::default();
        let mut from = 0;
        for (to, place) in self.places.iter().enumerate().skip(1).filter(|(_, place)| place.whole) {
            let way = [edge[to][0] - edge[from][0], edge[to][1] - edge[from][1]];
            let blade_deg = [self.places[from].blade_deg, place.blade_deg];
            let cut = Cut::of_edge(way, blade_deg, place.line, noise_mm);
            blade::check(cutter, &cut, &mut corner, faults);
            from = to;
        }
    }
}

/// The unit vector in (r, v) of a blade: `atan2(dU, dV)` is its angle (domain.md A5).
fn unit(blade_deg: f64) -> [f64; 2] {
    let angle = blade_deg.to_radians();
    [angle.sin(), angle.cos()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planning::tape::machine::{Edges, check, two_cutter_lab};

    fn cutter() -> Cutter {
        let mut profile = two_cutter_lab();
        profile.cutters[0].blade.edges = Edges::Single;
        profile.cutters[0].blade.offset_mm = 2.0;
        check(&profile, "").unwrap().cutters.remove(0)
    }

    /// A quarter turn of the axis round an edge at (10, 5), between a cut along +V and one along -r.
    fn corner(blade_turned: f64) -> Trail {
        let mut trail = Trail::at([10.0, 3.0], blade_turned);
        trail.go([10.0, 7.0], blade_turned, 1, true);
        for step in 1..=90 {
            let angle = -f64::from(step);
            let [r, v] = unit(angle);
            trail.go([10.0 + 2.0 * r, 5.0 + 2.0 * v], blade_turned + angle, 2, true);
        }
        trail.go([4.0, 5.0], blade_turned - 90.0, 3, true);
        trail
    }

    #[test]
    fn the_edge_stays_while_its_axis_goes_round_it() {
        let edge = corner(0.0).edge(&cutter());
        let near = |at: [f64; 2], to: [f64; 2]| (at[0] - to[0]).hypot(at[1] - to[1]) < 1e-9;
        assert!(near(edge[0], [10.0, 1.0]) && near(edge[edge.len() - 1], [6.0, 5.0]), "{edge:?}");
        assert!(edge[1..edge.len() - 1].iter().all(|&at| near(at, [10.0, 5.0])));
        // The blade the wrong way round: it cuts somewhere else.
        let edge = corner(180.0).edge(&cutter());
        assert!((edge[0][1] - 5.0).abs() < 1e-9, "{edge:?}");
    }

    #[test]
    fn a_turn_on_the_spot_counts_against_the_lift_angle() {
        let found = |lift: f64| {
            let mut cutter = cutter();
            cutter.lift_angle = crate::planning::units::Angle::from_degrees(lift);
            let mut faults = Faults::new("p");
            corner(0.0).finish(&cutter, &mut faults);
            faults.finish().len()
        };
        assert_eq!((found(90.0), found(89.0)), (0, 1));
    }

    #[test]
    fn parts_keep_the_edge_straight() {
        let cutter = cutter();
        assert_eq!(parts(&cutter, 0.0), 1);
        // 2 mm and 10 degrees: 2 * 0.1745^2 / 8 = 0.0076 mm.
        assert_eq!(parts(&cutter, 10.0), 28);
    }
}
