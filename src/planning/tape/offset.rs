//! A blade whose edge lies beside the axis that turns it (domain.md A7, docs/tape-machine.md).
//!
//! With e the offset and d the direction of a cut the axis stands at `edge + e d`: positive, the edge trails behind
//! the axis along the cut, as that of a drag knife does. In the (x, v) of strokes, x the reading of the tape axis,
//! `d = (-sin gamma, cos gamma)` for the blade angle gamma of the direction itself, so that
//!
//! ```text
//! x_axis = x - e sin(gamma)        v_axis = v + e cos(gamma)
//! ```
//!
//! Where the blade turns, the axis goes round the edge, and with it the tape. It must not run back: a corner that would
//! need that is rounded off within the tolerance, so that the tape advances enough meanwhile; one that swings forth
//! and back is turned with the knife up; where neither helps the other knife takes over, for which the chain is parted;
//! what is left is refused.

use super::chain::Chain;
use super::machine::{Cutter, Machine};
use super::stroke::{DECIMALS, Knot, Stroke, thinned};
use crate::planning::finding::{Code, Finding};
use crate::planning::geometry::{Point2, Vector2};
use crate::planning::program::number::rounded;
use crate::planning::tolerance::{BLADE_BLEND_DEG, OFFSET_SHARE, ONE_PLACE_MM};

/// How far a corner may be rounded off, as a share of the chord tolerance. All shares here are within
/// [`OFFSET_SHARE`](crate::planning::tolerance::OFFSET_SHARE).
const ROUNDING_SHARE: f64 = 0.35;

/// How far an edge may leave its corner while its axis goes round it along chords, as a share of the chord tolerance.
const SWIVEL_SHARE: f64 = 0.05;

/// How far the tape may stand before a place that it has passed, as a share of the chord tolerance: it waits there.
const WAITING_SHARE: f64 = 0.05;

/// Waiting turns a cut. By more than this share of its length, 0.2 degrees, it must not: with [`BLADE_BLEND_DEG`] and what
/// printed digits turn a short cut by, its blade would lie a degree off it.
const WAITING_SINE: f64 = 0.0035;

/// The direction of a shorter cut, in mm, is that of its printed digits.
const SHORTEST_CUT_MM: f64 = 0.025;

/// The strokes of the axes of all cutters, for those of their edges. A cutter without an offset keeps its own.
///
/// # Errors
/// `TapeReversal` for every stroke in which the tape would have to run back, with course, u and amount.
pub fn follow(
    strokes: Vec<Vec<Stroke>>,
    machine: &Machine,
    tolerance_mm: f64,
) -> Result<Vec<Vec<Stroke>>, Vec<Finding>> {
    let mut faults = Vec::new();
    let cutters = machine.cutters.iter().zip(strokes);
    let followed = cutters.map(|(cutter, strokes)| {
        if !cutter.swivels() {
            return strokes;
        }
        let mut axis = Axis::new(cutter, tolerance_mm);
        strokes.iter().for_each(|stroke| axis.follow(stroke));
        faults.append(&mut axis.faults);
        axis.done
    });
    let followed = followed.collect();
    if faults.is_empty() { Ok(followed) } else { Err(faults) }
}

/// Smallest and largest u at which the axis of a knife stands that makes a chain, whichever cutter it is of. `left_mm` is
/// what the tape leaves of the chord tolerance.
#[must_use]
pub fn busy_mm(chain: &Chain, machine: &Machine, left_mm: f64, tolerance_mm: f64) -> (f64, f64) {
    let (low, high) = chain.u_range();
    if machine.cutters.iter().all(|cutter| !cutter.swivels()) {
        return (low, high);
    }
    let points = thinned(chain, left_mm - OFFSET_SHARE * tolerance_mm);
    let direction = |pair: &[Point2]| (pair[1] - pair[0]).try_normalize(0.0).map_or(0.0, |way| way.x);
    let mut steps = points.windows(2).filter(|pair| pair[0] != pair[1]);
    let first = steps.next().map_or(0.0, direction);
    let last = steps.next_back().map_or(first, direction);
    let offsets = machine.cutters.iter().map(|cutter| cutter.offset.mm());
    offsets.fold((f64::INFINITY, f64::NEG_INFINITY), |(lowest, highest), offset| {
        let (from, to) = (high + offset * first, low + offset * last);
        (lowest.min(to), highest.max(from).max(to))
    })
}

/// The parts of a chain that one knife can make each: it is parted at corners where the tape would have to run back too far
/// for any of the machine's blades. A machine of one knife has nobody to take over.
#[must_use]
pub fn parted(chain: Chain, machine: &Machine, left_mm: f64, tolerance_mm: f64) -> Vec<Chain> {
    let swivels: Vec<&Cutter> = machine.cutters.iter().filter(|cutter| cutter.swivels()).collect();
    if swivels.is_empty() || machine.cutters.len() < 2 {
        return vec![chain];
    }
    let axes: Vec<Axis> = swivels.into_iter().map(|cutter| Axis::new(cutter, tolerance_mm)).collect();
    let knot = |point: &Point2| Knot { x: -point.x, v: point.y, blade_deg: 0.0 };
    let mut knots: Vec<Knot> =
        thinned(&chain, left_mm - OFFSET_SHARE * tolerance_mm).iter().map(knot).collect();
    for index in 1..knots.len() {
        let (dx, dv) = (knots[index].x - knots[index - 1].x, knots[index].v - knots[index - 1].v);
        knots[index - 1].blade_deg = (-dx).atan2(dv).to_degrees();
    }
    let corners = knots.windows(3).filter(|corner| axes.iter().any(|axis| axis.runs_back(corner)));
    let mut parts = Vec::new();
    let mut rest = chain;
    for corner in corners {
        // Thinning keeps points as they are.
        let here = Point2::new(-corner[1].x, corner[1].v);
        let Some(at) = rest.points.iter().position(|point| *point == here) else { continue };
        let points = rest.points.split_off(at);
        rest.points.push(here);
        let after = Chain { points, ..rest.clone() };
        parts.push(std::mem::replace(&mut rest, after));
    }
    parts.push(rest);
    parts
}

/// What the axis has more than the edge in (x, v), in mm, at a knot whose blade lies in the direction of the cut.
#[must_use]
pub fn ahead_mm(cutter: &Cutter, blade_deg: f64) -> Vector2 {
    let (sin, cos) = blade_deg.to_radians().sin_cos();
    Vector2::new(-sin, cos) * cutter.offset.mm()
}

/// Where the edge has been, for places (r, v) of an axis in mm with the blade in degrees at each.
#[must_use]
pub fn edge(places: &[([f64; 2], f64)], cutter: &Cutter) -> Vec<[f64; 2]> {
    let offset = cutter.offset.mm();
    let edge = places.iter().map(|([r, v], blade)| {
        let (sin, cos) = blade.to_radians().sin_cos();
        [r - offset * sin, v - offset * cos]
    });
    edge.collect()
}

/// The axis of a cutter on its way along the strokes of its edge.
struct Axis<'a> {
    cutter: &'a Cutter,
    tolerance_mm: f64,
    /// The tape has come so far.
    reached: f64,
    /// Where the edge was last, and how far the tape then stood beyond the place for that.
    last: Option<(Point2, f64)>,
    done: Vec<Stroke>,
    faults: Vec<Finding>,
}

/// The worst of a stroke: how far the tape would have to run back, and at which knot of the edge.
type Back = Option<(f64, Knot)>;

impl<'a> Axis<'a> {
    fn new(cutter: &'a Cutter, tolerance_mm: f64) -> Self {
        Self {
            cutter,
            tolerance_mm,
            reached: f64::NEG_INFINITY,
            last: None,
            done: Vec::new(),
            faults: Vec::new(),
        }
    }

    fn waiting_mm(&self) -> f64 {
        // Two printed positions may be off by a place against each other whatever the tolerance is.
        (WAITING_SHARE * self.tolerance_mm).max(2.0 * ONE_PLACE_MM)
    }

    fn follow(&mut self, stroke: &Stroke) {
        let knots = self.rounded_off(&stroke.knots);
        let mut back: Back = None;
        self.begin(stroke, &knots[0], &mut back);
        for index in 1..knots.len() {
            let (before, here) = (knots[index - 1].blade_deg, &knots[index]);
            self.reach(here, before, &mut back);
            let turn = here.blade_deg - before;
            if index + 1 == knots.len() || turn.abs() <= BLADE_BLEND_DEG {
                continue;
            }
            if self.swings_back_mm(before, turn) <= self.waiting_mm() {
                self.swivel(here, before, turn, &mut back);
            } else {
                self.begin(stroke, here, &mut back);
            }
        }
        if let Some((back_mm, knot)) = back {
            self.faults.push(self.fault(stroke, back_mm, &knot));
        }
    }

    fn fault(&self, stroke: &Stroke, back_mm: f64, knot: &Knot) -> Finding {
        let message = format!(
            "course {}, cutter {}: at u {:.3} mm the tape would have to run back by {back_mm:.4} mm, because the edge of the blade lies \
             {} mm from the axis that turns it, and the cut turns there or the knife has just made another. Use a blade \
             with less offset, or change the outline there",
            stroke.course,
            self.cutter.number,
            stroke.x_of_u0 - knot.x,
            self.cutter.offset.mm()
        );
        Finding::error(Code::TapeReversal, "/input/machine", message)
    }

    /// The knife goes down at a knot.
    fn begin(&mut self, stroke: &Stroke, knot: &Knot, back: &mut Back) {
        let Stroke { course, piece, x_of_u0, .. } = *stroke;
        self.done.push(Stroke { course, piece, x_of_u0, knots: Vec::new() });
        self.last = None;
        self.reach(knot, knot.blade_deg, back);
    }

    /// Puts the axis where the edge stands over a knot with the blade at an angle.
    fn reach(&mut self, knot: &Knot, blade_deg: f64, back: &mut Back) {
        let ahead = ahead_mm(self.cutter, blade_deg);
        let x = rounded(knot.x + ahead.x, DECIMALS);
        let back_mm = (self.reached - x).max(0.0);
        let worst_mm = back.map_or(0.0, |(worst, _)| worst);
        if (back_mm > self.waiting_mm() || self.turns_the_cut(knot, back_mm)) && back_mm > worst_mm {
            *back = Some((back_mm, *knot));
        }
        self.last = Some((Point2::new(knot.x, knot.v), back_mm));
        self.reached = self.reached.max(x);
        let place = Knot { x: self.reached, v: rounded(knot.v + ahead.y, DECIMALS), blade_deg };
        let Some(stroke) = self.done.last_mut() else { return };
        if stroke.knots.last() != Some(&place) {
            stroke.knots.push(place);
        }
    }

    /// Whether waiting by so much turns the cut to a knot.
    fn turns_the_cut(&self, knot: &Knot, back_mm: f64) -> bool {
        self.last.is_some_and(|(at, before_mm)| {
            let length = (knot.x - at.x).hypot(knot.v - at.y);
            length > SHORTEST_CUT_MM && (back_mm - before_mm).abs() > WAITING_SINE * length
        })
    }

    /// How far the tape would have to come back while the blade turns in the material.
    fn swings_back_mm(&self, from_deg: f64, turn: f64) -> f64 {
        let steps = self.swivel_steps(turn);
        let (mut most, mut back) = (f64::NEG_INFINITY, 0.0_f64);
        for step in 0..=steps {
            let x = ahead_mm(self.cutter, from_deg + turn * step as f64 / steps as f64).x;
            most = most.max(x);
            back = back.max(most - x);
        }
        back
    }

    /// Over an angle a the chord of the axis' arc lies `e a^2 / 8` inside of it.
    fn swivel_steps(&self, turn: f64) -> usize {
        let angle = (8.0 * SWIVEL_SHARE * self.tolerance_mm / self.cutter.offset.mm().abs()).sqrt();
        (turn.abs().to_radians() / angle).ceil().max(1.0) as usize
    }

    /// Turns in the material: the axis goes round the edge.
    fn swivel(&mut self, knot: &Knot, from_deg: f64, turn: f64, back: &mut Back) {
        let steps = self.swivel_steps(turn);
        for step in 1..=steps {
            let blade_deg = rounded(from_deg + turn * step as f64 / steps as f64, DECIMALS);
            self.reach(knot, blade_deg, back);
        }
    }

    /// The knots of an edge, its corners rounded off where the tape would have to run back.
    fn rounded_off(&self, knots: &[Knot]) -> Vec<Knot> {
        let mut all = vec![knots[0]];
        for index in 1..knots.len() {
            let corner = knots.get(index + 1).map(|next| [knots[index - 1], knots[index], *next]);
            match corner.filter(|corner| self.needs_rounding(corner)) {
                Some(corner) => all.extend(self.arc(&corner)),
                None => all.push(knots[index]),
            }
        }
        all
    }

    /// Whether the tape would have to run back at a corner even with that rounded off.
    fn runs_back(&self, corner: &[Knot]) -> bool {
        let [before, here, after] = [corner[0], corner[1], corner[2]];
        let turn = here.blade_deg - before.blade_deg;
        let x = |knot: &Knot| ahead_mm(self.cutter, knot.blade_deg).x;
        let rounded_mm = self.tangent_mm(&before, &here, &after) * (lengthwise(&before) + lengthwise(&here));
        turn.abs() > BLADE_BLEND_DEG && x(&before) - x(&here) - rounded_mm > self.waiting_mm()
    }

    /// How far from its corner an arc begins and ends, see [`Axis::arc`].
    fn tangent_mm(&self, before: &Knot, corner: &Knot, after: &Knot) -> f64 {
        let half = |one: &Knot, other: &Knot| (other.x - one.x).hypot(other.v - one.v) / 2.0;
        let quarter = ((corner.blade_deg - before.blade_deg).abs() / 4.0).to_radians();
        let free = half(before, corner).min(half(corner, after));
        (ROUNDING_SHARE * self.tolerance_mm / quarter.tan()).min(free)
    }

    /// A corner that ends farther forward than it begins can be turned with the knife up.
    fn needs_rounding(&self, [before, here, _]: &[Knot; 3]) -> bool {
        let turn = here.blade_deg - before.blade_deg;
        let forward = ahead_mm(self.cutter, here.blade_deg).x - ahead_mm(self.cutter, before.blade_deg).x;
        turn.abs() > BLADE_BLEND_DEG && forward < 0.0
    }

    /// An arc that leaves its corner by no more than its share, in chords between which the blade turns by what is left
    /// to the next segment. Where it leaves the corner by s, it begins and ends `s / tan(turn / 4)` from it.
    fn arc(&self, [before, corner, after]: &[Knot; 3]) -> Vec<Knot> {
        let turn = corner.blade_deg - before.blade_deg;
        let tangent = self.tangent_mm(before, corner, after);
        let chords = (turn.abs() / BLADE_BLEND_DEG).ceil() as usize;
        let radius = tangent / (turn.abs() / 2.0).to_radians().tan();
        let length = 2.0 * radius * (turn.abs().to_radians() / (2.0 * chords as f64)).sin();
        let way = |angle: f64| Vector2::new(-angle.to_radians().sin(), angle.to_radians().cos());
        let mut at = Point2::new(corner.x, corner.v) - way(before.blade_deg) * tangent;
        let mut knots = Vec::with_capacity(chords + 1);
        for chord in 0..chords {
            let blade_deg = rounded(before.blade_deg + turn * (chord as f64 + 0.5) / chords as f64, DECIMALS);
            knots.push(Knot { x: at.x, v: at.y, blade_deg });
            at += way(blade_deg) * length;
        }
        let to = Point2::new(corner.x, corner.v) + way(corner.blade_deg) * tangent;
        knots.push(Knot { x: to.x, v: to.y, blade_deg: corner.blade_deg });
        knots
    }
}

/// How much a cut advances the tape, as a share of its length.
fn lengthwise(knot: &Knot) -> f64 {
    -knot.blade_deg.to_radians().sin()
}

#[cfg(test)]
mod tests {
    use super::super::chain::split;
    use super::super::machine::{Edges, check, two_cutter_lab};
    use super::super::stroke::strokes;
    use super::*;

    fn machine(offset_mm: f64) -> Machine {
        let mut profile = two_cutter_lab();
        for cutter in &mut profile.cutters {
            (cutter.blade.edges, cutter.blade.offset_mm) = (Edges::Single, offset_mm);
        }
        check(&profile, "").unwrap()
    }

    fn followed(list: &[(f64, f64)], offset_mm: f64) -> Result<Vec<Stroke>, Vec<Finding>> {
        let machine = machine(offset_mm);
        let points: Vec<_> = list.iter().map(|&(u, v)| Point2::new(u, v)).collect();
        let made = strokes(&split(0, &points, 37.5)[0], (1.into(), 0), &machine.cutters[0], 100.0, 0.01);
        follow(vec![made, Vec::new()], &machine, 0.01).map(|mut followed| followed.remove(0))
    }

    #[test]
    fn a_straight_slanted_cut_is_the_closed_form() {
        // From (50, -30) down to (20, 10): d = (-0.6, 0.8) in (u, v), (0.6, 0.8) in (x, v).
        let knots = &followed(&[(20.0, 10.0), (50.0, -30.0)], 2.5).unwrap()[0].knots;
        let found: Vec<_> = knots.iter().map(|knot| (knot.x, knot.v)).collect();
        assert_eq!(found, [(50.0 + 1.5, -30.0 + 2.0), (80.0 + 1.5, 10.0 + 2.0)]);
        let knots = &followed(&[(20.0, 10.0), (50.0, -30.0)], -2.5).unwrap()[0].knots;
        assert_eq!((knots[1].x, knots[1].v), (80.0 - 1.5, 10.0 - 2.0));
    }

    #[test]
    fn the_axis_goes_round_the_edge_at_a_corner_that_takes_the_tape_forward() {
        // The cut turns from nearly square to more lengthwise by 12.8 degrees.
        let corner = [(50.0, -20.0), (48.0, 0.0), (42.0, 18.0)];
        let made = followed(&corner, 3.0).unwrap();
        assert_eq!(made.len(), 1);
        let knots = &made[0].knots;
        assert!(knots.len() > 6 && knots.windows(2).all(|pair| pair[1].x >= pair[0].x), "{knots:?}");
        for knot in &knots[1..knots.len() - 1] {
            assert!(((knot.x - 52.0).hypot(knot.v) - 3.0).abs() < 2e-4, "{knot:?}");
        }
    }

    #[test]
    fn a_corner_that_would_take_the_tape_back_is_refused_by_how_much() {
        let corner = [(50.0, -20.0), (44.0, -2.0), (42.0, 18.0)];
        let fault = followed(&corner, 3.0).unwrap_err().remove(0);
        assert_eq!(fault.code, Code::TapeReversal);
        // 3 (sin 18.43 - sin 5.71 degrees), less what rounding off within 0.0035 mm gives.
        assert!(
            fault.message.contains("at u 43.9") && fault.message.contains("run back by 0.611"),
            "{fault}"
        );
        // Turned about the other way, an edge that leads goes forward there.
        assert!(followed(&corner, -3.0).is_ok());
    }

    #[test]
    fn small_corners_are_rounded_off_while_the_tape_advances() {
        let circle: Vec<_> = (0..=20)
            .map(|i| f64::from(20 + i * 2).to_radians())
            .map(|angle| (100.0 * angle.sin(), 100.0 * angle.cos()))
            .collect();
        for offset in [-0.5, 0.5] {
            let made = followed(&circle, offset).unwrap();
            assert_eq!(made.len(), 1, "{offset}");
            assert!(made[0].knots.windows(2).all(|pair| pair[1].x >= pair[0].x));
        }
    }

    #[test]
    fn a_swing_forth_and_back_is_turned_with_the_knife_up() {
        // Lengthwise is passed in the middle of the turn.
        let corner = [(50.0, -2.0), (35.0, 0.0), (20.0, -2.0)];
        let made = followed(&corner, 5.0).unwrap();
        assert_eq!(made.len(), 2);
        assert_eq!(made[0].knots.last().unwrap().x, made[1].knots[0].x);
    }

    #[test]
    fn the_edge_is_found_again_from_its_axis() {
        let (machine, list) = (machine(3.0), [(50.0, -20.0), (48.0, 0.0), (42.0, 18.0)]);
        let made = followed(&list, 3.0).unwrap().remove(0);
        let places: Vec<_> =
            made.knots.iter().map(|knot| ([100.0 - knot.x, knot.v], knot.blade_deg)).collect();
        let found = edge(&places, &machine.cutters[0]);
        let off = |a: [f64; 2], b: (f64, f64)| (a[0] - b.0).hypot(a[1] - b.1);
        assert!(off(found[0], list[0]) < 2e-4 && off(found[found.len() - 1], list[2]) < 2e-4);
        assert!(found[1..found.len() - 1].iter().all(|&at| off(at, list[1]) < 2e-4), "{found:?}");
    }
}
