//! What a knife may cut beyond the ends of its cuts: a straight end of a stroke, no longer than the machine's overcut,
//! outside of every piece.

use super::ReplaySetup;
use super::strokes::Stroke;

/// Places at which an overcut is looked at: over 10 mm every 0.3 mm, and both ends.
const PLACES: usize = 33;

/// A run this much longer than the straight line through its ends, in mm, is not straight.
const STRAIGHT_MM: f64 = 0.001;

/// Whether a run (its ends and its length in mm) of what nobody wants is an overcut of a stroke.
pub(super) fn is_overcut(
    setup: &ReplaySetup<'_>,
    stroke: &Stroke,
    (from, to, length_mm): ([f64; 2], [f64; 2], f64),
    within_mm: f64,
) -> bool {
    let straight_mm = far_mm(from, to);
    let ends = [stroke.points.first(), stroke.points.last()];
    setup.overcut_mm > 0.0
        && length_mm <= straight_mm + STRAIGHT_MM
        && ends.into_iter().flatten().any(|end| {
            // On the last straight way to the end: it may pass by a corner of another cut in between.
            let (near, far) = (far_mm(*end, from), far_mm(*end, to));
            near.max(far) <= setup.overcut_mm + within_mm && (near - far).abs() >= straight_mm - STRAIGHT_MM
        })
        && (0..PLACES).all(|place| {
            let share = place as f64 / (PLACES - 1) as f64;
            let at = [from[0] + share * (to[0] - from[0]), from[1] + share * (to[1] - from[1])];
            !setup.pieces.iter().any(|piece| enters(piece, at, within_mm))
        })
        // It goes on from something: a whole stroke that nobody wants is no overcut of a cut.
        && length_mm < stroke.length_mm() - STRAIGHT_MM
}

fn far_mm(one: [f64; 2], other: [f64; 2]) -> f64 {
    (one[0] - other[0]).hypot(one[1] - other[1])
}

/// Whether a place lies in a piece, farther from its edges than cuts may be from theirs.
fn enters(piece: &[Vec<[f64; 2]>], at: [f64; 2], within_mm: f64) -> bool {
    let sides = || piece.iter().flat_map(|ring| ring.iter().zip(ring.iter().cycle().skip(1)));
    let above = |point: &[f64; 2]| point[1] > at[1];
    let right = |a: &[f64; 2], b: &[f64; 2]| at[0] < a[0] + (at[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0]);
    let crossings = sides().filter(|(a, b)| above(a) != above(b) && right(a, b)).count();
    crossings % 2 == 1 && sides().all(|(a, b)| distance(*a, *b, at) > within_mm)
}

fn distance(a: [f64; 2], b: [f64; 2], at: [f64; 2]) -> f64 {
    let (way, to) = ([b[0] - a[0], b[1] - a[1]], [at[0] - a[0], at[1] - a[1]]);
    let square = way[0] * way[0] + way[1] * way[1];
    let share = if square > 0.0 { ((to[0] * way[0] + to[1] * way[1]) / square).clamp(0.0, 1.0) } else { 0.0 };
    (to[0] - share * way[0]).hypot(to[1] - share * way[1])
}
