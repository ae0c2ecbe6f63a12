//! Whether a blade lies along its cut.

use super::faults::Faults;
use super::travel::{Axes, Moved, PRINTED_DEG, PRINTED_MM};
use crate::planning::finding::Code;
use crate::planning::tape::machine::{Cutter, Edges};
use crate::planning::tolerance::{BLADE_ALONG_CUT_DEG, CORNER_MM};

/// How far, in mm, printed digits can move one end of a cut against the other: both coordinates of both ends.
const PRINTED_CUT_MM: f64 = 2.0 * PRINTED_MM * std::f64::consts::SQRT_2;

/// What one knife that is down does in one move.
pub(super) struct Cut {
    /// Its way over the roll, (dr, dv) in mm.
    way: [f64; 2],
    /// Where the blade points before and after, in degrees.
    blade: [f64; 2],
    line: usize,
    /// How far its ends may be off against each other, in mm.
    noise_mm: f64,
}

impl Cut {
    /// The part of a cutter in a move. The tape moves toward +U, so the knife moves over it toward -r.
    pub(super) fn of(axes: &Axes<'_>, cutter: usize, moved: &Moved) -> Self {
        let way = [-axes.feed_delta(moved), axes.lateral_delta(cutter, moved)];
        Self { way, blade: axes.blade(cutter, moved), line: moved.line, noise_mm: PRINTED_CUT_MM }
    }

    /// What the edge of a blade does in one move that lies beside its axis. A way within the noise is none.
    pub(super) fn of_edge(way: [f64; 2], blade: [f64; 2], line: usize, noise_mm: f64) -> Self {
        let way = if way[0].hypot(way[1]) > noise_mm { way } else { [0.0, 0.0] };
        Self { way, blade, line, noise_mm }
    }

    /// Whether the knife moves in the tape.
    pub(super) fn advances(&self) -> bool {
        self.way != [0.0, 0.0]
    }

    fn turn_deg(&self) -> f64 {
        (self.blade[1] - self.blade[0]).abs()
    }

    fn length_mm(&self) -> f64 {
        self.way[0].hypot(self.way[1])
    }
}

/// Where a blade that is down is in its corner.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Corner {
    /// How far it has turned on the spot, in degrees.
    turned_deg: f64,
    /// How far it has cut since it last turned on the spot, in mm.
    since_mm: f64,
    /// How far it has cut in short steps, one after the other, in mm.
    short_mm: f64,
}

impl Corner {
    /// The blade goes on by so much. Short steps are one corner as long as they together are short.
    fn go_on(&mut self, length_mm: f64) {
        self.short_mm = if length_mm > CORNER_MM { 0.0 } else { self.short_mm + length_mm };
        self.since_mm += length_mm;
        if self.since_mm > CORNER_MM {
            self.turned_deg = 0.0;
        }
    }

    fn turn(&mut self, by_deg: f64) {
        self.turned_deg += by_deg;
        self.since_mm = 0.0;
    }
}

/// Checks the blade of a knife that is down.
pub(super) fn check(cutter: &Cutter, cut: &Cut, corner: &mut Corner, faults: &mut Faults<'_>) {
    if !cut.advances() {
        return turn_on_the_spot(cutter, cut, corner, faults);
    }
    corner.go_on(cut.length_mm());
    let allowed = allowed_deg(cutter, cut, corner);
    // gamma = atan2(dU, dV) in tape coordinates (domain.md A5).
    let gamma = cut.way[0].atan2(cut.way[1]).to_degrees();
    let off = cut.blade.map(|angle| off_deg(angle - gamma, cutter.edges)).into_iter().fold(0.0, f64::max);
    if off > allowed {
        faults.at_line(Code::BladeAngle, cut.line, || {
            let number = cutter.number;
            format!(
                "blade {number} lies {off:.3} degrees off its cut at {gamma:.3}; {allowed:.3} are allowed"
            )
        });
    } else if cut.turn_deg() > 2.0 * allowed {
        // Right at both ends and half a turn between them is wrong all the same.
        faults.at_line(Code::BladeAngle, cut.line, || {
            format!("blade {} turns by {:.3} degrees within one cut", cutter.number, cut.turn_deg())
        });
    }
}

fn turn_on_the_spot(cutter: &Cutter, cut: &Cut, corner: &mut Corner, faults: &mut Faults<'_>) {
    let lift = cutter.lift_angle.degrees();
    let before = corner.turned_deg;
    corner.turn(cut.turn_deg());
    let limit = lift + 2.0 * PRINTED_DEG;
    let turned = corner.turned_deg;
    if turned > limit && before <= limit {
        faults.at_line(Code::BladeAngle, cut.line, || {
            format!("blade {} turns by {turned:.3} degrees in the tape; above {lift} it lifts", cutter.number)
        });
    }
}

/// The angle, in degrees, that a blade may have to a cut of this length.
///
/// A short cut is part of a corner, through which a blade may turn without being lifted, and printed digits
/// turn it by up to `asin(noise / length)`.
fn allowed_deg(cutter: &Cutter, cut: &Cut, corner: &Corner) -> f64 {
    let length_mm = cut.length_mm();
    if length_mm > CORNER_MM {
        return BLADE_ALONG_CUT_DEG;
    }
    let printed_deg = (cut.noise_mm / length_mm).min(1.0).asin().to_degrees();
    let lift_deg = if corner.short_mm > CORNER_MM { 0.0 } else { cutter.lift_angle.degrees() };
    lift_deg.max(BLADE_ALONG_CUT_DEG) + printed_deg
}

/// The size of an angle, in degrees, if half a turn (double edge) or a whole turn (single edge) counts nothing.
fn off_deg(angle: f64, edges: Edges) -> f64 {
    let period = match edges {
        Edges::Double => 180.0,
        Edges::Single => 360.0,
    };
    let rest = angle.rem_euclid(period);
    rest.min(period - rest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_double_edge_cuts_both_ways_and_a_single_one_does_not() {
        assert_eq!(off_deg(179.5, Edges::Double), 0.5);
        assert_eq!(off_deg(-180.25, Edges::Double), 0.25);
        assert_eq!(off_deg(179.5, Edges::Single), 179.5);
        assert_eq!(off_deg(-359.5, Edges::Single), 0.5);
    }

    #[test]
    fn the_length_from_which_a_blade_is_checked_leaves_room_for_printed_digits() {
        let printed_deg = (PRINTED_CUT_MM / CORNER_MM).asin().to_degrees();
        assert!(printed_deg + crate::planning::tolerance::BLADE_BLEND_DEG < BLADE_ALONG_CUT_DEG);
    }
}
