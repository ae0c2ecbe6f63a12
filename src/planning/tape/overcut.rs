//! Overcut: cuts go on beyond their ends, so that a blade of some width severs them whole (domain.md A7).
//!
//! Beyond the tape's edge there is nothing to spare, and beside a piece there is scrap; but an overcut never enters a piece,
//! its own or a neighbour, and never takes the tape to where the same knife has its next or last stroke. Where it
//! would, it is shorter, which is said.

use super::label::CourseLabel;
use super::machine::{Cutter, Machine};
use super::offset::ahead_mm;
use super::plan::TapePlan;
use super::stroke::{DECIMALS, Knot, Stroke};
use crate::planning::finding::{Code, Finding};
use crate::planning::geometry::polygon::{contains, edges};
use crate::planning::geometry::{Point2, Vector2};
use crate::planning::program::number::rounded;
use crate::planning::tolerance::ONE_PLACE_MM;

/// An overcut shorter than this, in mm, is none: it is the positioning of the knives.
const SHORTEST_MM: f64 = 0.01;

/// Outline and cut-outs of each piece of a plan, in roll coordinates.
#[must_use]
pub fn outlines(plan: &TapePlan) -> Vec<Vec<Vec<[f64; 2]>>> {
    let pieces = plan.pieces().map(|(_, planned)| {
        let place = |point: &Point2| [point.x + planned.offset_mm, point.y];
        let holes = planned.piece.holes.iter().map(|hole| hole.iter().map(place).collect());
        std::iter::once(planned.outline_on_roll()).chain(holes).collect()
    });
    pieces.collect()
}

/// Lets the strokes of every cutter go on by its overcut. A finding says where that was not possible.
pub fn extend(strokes: &mut [Vec<Stroke>], plan: &TapePlan, machine: &Machine) -> Option<Finding> {
    if machine.overcut().mm() <= 0.0 {
        return None;
    }
    let pieces: Vec<Obstacle> = outlines(plan).iter().map(|loops| Obstacle::of(loops)).collect();
    let mut said = Shortened::default();
    for (cutter, strokes) in machine.cutters.iter().zip(strokes) {
        let x_of_r0 = plan.figures.lead_mm + cutter.station.mm();
        let extender = Extender { cutter, pieces: &pieces, x_of_r0 };
        let mut free_from = 0.0;
        for index in 0..strokes.len() {
            // Two strokes of a knife share the tape between them: nobody runs it backwards.
            let next = strokes.get(index + 1).map(|stroke| extender.axis_x(&stroke.knots[0]));
            let stroke = &mut strokes[index];
            let end_x = extender.axis_x(&stroke.knots[stroke.knots.len() - 1]);
            let free_to = next.map_or(f64::INFINITY, |next| rounded(f64::midpoint(end_x, next), DECIMALS));
            for (end, free) in [(End::First, free_from), (End::Last, free_to)] {
                let short_mm = cutter.overcut.mm() - extender.extend(stroke, end, free);
                said.note(short_mm, stroke.course);
            }
            free_from = extender.axis_x(&stroke.knots[stroke.knots.len() - 1]);
        }
    }
    said.finding()
}

/// An end of a stroke.
#[derive(Debug, Clone, Copy, PartialEq)]
enum End {
    First,
    Last,
}

struct Extender<'a> {
    cutter: &'a Cutter,
    pieces: &'a [Obstacle],
    /// Reading of the tape axis at which the cutter stands over r = 0.
    x_of_r0: f64,
}

impl Extender<'_> {
    /// The reading of the tape axis at which the edge stands over a knot.
    fn axis_x(&self, knot: &Knot) -> f64 {
        knot.x + ahead_mm(self.cutter, knot.blade_deg).x
    }

    /// Extends an end of a stroke, the tape not passing `free`, and gives by how much.
    fn extend(&self, stroke: &mut Stroke, end: End, free: f64) -> f64 {
        let last = stroke.knots.len() - 1;
        let (knot, inner) = match end {
            End::First => (stroke.knots[0], stroke.knots[1]),
            End::Last => (stroke.knots[last], stroke.knots[last - 1]),
        };
        // On the way the axis is ahead of the edge by the same everywhere.
        let free = free - (self.axis_x(&knot) - knot.x);
        let way = outward(&knot, &inner);
        let length = self.length(&knot, way, free);
        if length < SHORTEST_MM {
            return 0.0;
        }
        let x = rounded(knot.x + length * way.x, DECIMALS);
        let x = if end == End::First { x.max(free).min(knot.x) } else { x.min(free).max(knot.x) };
        let v = rounded(knot.v + length * way.y, DECIMALS);
        let beyond = Knot { x, v, ..knot };
        // A knot that lies on the straight line to the new end is no corner.
        let straight = off_mm(&knot, &beyond, &inner) <= ONE_PLACE_MM;
        match (end, straight) {
            (End::First, true) => stroke.knots[0] = beyond,
            (End::Last, true) => stroke.knots[last] = beyond,
            (End::First, false) => stroke.knots.insert(0, beyond),
            (End::Last, false) => stroke.knots.push(beyond),
        }
        length
    }

    /// How far an end can go on.
    fn length(&self, knot: &Knot, way: Vector2, free: f64) -> f64 {
        let (low, high) = (self.cutter.lateral_range.0.mm(), self.cutter.lateral_range.1.mm());
        let until = |at: f64, way: f64, wall: f64| if way == 0.0 { f64::INFINITY } else { (wall - at) / way };
        let axis_v = knot.v + ahead_mm(self.cutter, knot.blade_deg).y;
        let across = until(axis_v, way.y, if way.y > 0.0 { high } else { low });
        let along = until(knot.x, way.x, free);
        let length = self.cutter.overcut.mm().min(across).min(along);
        let from = Point2::new(self.x_of_r0 - knot.x, knot.v);
        let way = Vector2::new(-way.x, way.y);
        let free = self.pieces.iter().map(|piece| piece.free_mm(from, way, length));
        free.fold(length, f64::min).max(0.0)
    }
}

/// The direction in which a stroke goes on beyond its end, in (x, v): along its blade, which short steps of printed
/// digits do not turn.
fn outward(knot: &Knot, inner: &Knot) -> Vector2 {
    let step = Vector2::new(knot.x - inner.x, knot.v - inner.v);
    // gamma = atan2(dU, dV), and the tape moves toward +U, so the knife goes the other way in x.
    let (sin, cos) = knot.blade_deg.to_radians().sin_cos();
    let blade = Vector2::new(-sin, cos);
    let along = if blade.dot(&step) < 0.0 { -blade } else { blade };
    // Square and lengthwise cuts stay exactly that.
    Vector2::new(if step.x == 0.0 { 0.0 } else { along.x }, if step.y == 0.0 { 0.0 } else { along.y })
}

/// How far a knot lies from the line through two others, in mm.
fn off_mm(knot: &Knot, one: &Knot, other: &Knot) -> f64 {
    let line = Vector2::new(other.x - one.x, other.v - one.v);
    let to = Vector2::new(knot.x - one.x, knot.v - one.v);
    if line.norm() > 0.0 { (line.perp(&to) / line.norm()).abs() } else { to.norm() }
}

/// A piece that no overcut may enter.
struct Obstacle {
    low: Point2,
    high: Point2,
    loops: Vec<Vec<Point2>>,
}

impl Obstacle {
    fn of(loops: &[Vec<[f64; 2]>]) -> Self {
        let loops: Vec<Vec<Point2>> =
            loops.iter().map(|points| points.iter().map(|&[r, v]| Point2::new(r, v)).collect()).collect();
        let points = || loops.iter().flatten();
        let (low, high) = points().fold(
            (Point2::new(f64::INFINITY, f64::INFINITY), Point2::new(f64::NEG_INFINITY, f64::NEG_INFINITY)),
            |(low, high), point| (low.inf(point), high.sup(point)),
        );
        Self { low, high, loops }
    }

    /// How far a straight line goes from a point until it enters the piece; `length` if it does not.
    fn free_mm(&self, from: Point2, way: Vector2, length: f64) -> f64 {
        let to = from + way * length;
        let beside = from.x.max(to.x) < self.low.x
            || from.x.min(to.x) > self.high.x
            || from.y.max(to.y) < self.low.y
            || from.y.min(to.y) > self.high.y;
        if beside || length <= 0.0 {
            return length;
        }
        let mut places: Vec<f64> = self
            .loops
            .iter()
            .flat_map(|points| edges(points))
            .filter_map(|(a, b)| crossing(from, way, *a, *b))
            .filter(|at| *at > 0.0 && *at < length)
            .chain([0.0, length])
            .collect();
        places.sort_by(f64::total_cmp);
        let entered = places.windows(2).find(|span| {
            span[1] - span[0] > ONE_PLACE_MM && self.holds(from + way * f64::midpoint(span[0], span[1]))
        });
        entered.map_or(length, |span| span[0])
    }

    /// Whether a point lies in the piece and not merely on its edge.
    fn holds(&self, point: Point2) -> bool {
        let inside = self.loops.iter().filter(|points| contains(points, &point)).count() % 2 == 1;
        inside
            && self
                .loops
                .iter()
                .flat_map(|points| edges(points))
                .all(|(a, b)| distance(*a, *b, point) > ONE_PLACE_MM)
    }
}

/// Where a line from a point meets a segment, in mm along it.
fn crossing(from: Point2, way: Vector2, a: Point2, b: Point2) -> Option<f64> {
    let side = b - a;
    let across = way.perp(&side);
    if across == 0.0 {
        return None;
    }
    let to = a - from;
    let share = to.perp(&way) / across;
    (0.0..=1.0).contains(&share).then(|| to.perp(&side) / across)
}

fn distance(a: Point2, b: Point2, point: Point2) -> f64 {
    let side = b - a;
    let square = side.norm_squared();
    let share = if square > 0.0 { ((point - a).dot(&side) / square).clamp(0.0, 1.0) } else { 0.0 };
    (point - a - side * share).norm()
}

/// What is said of overcuts that are shorter than they should be.
#[derive(Default)]
struct Shortened {
    ends: usize,
    short: usize,
    worst_mm: f64,
    course: CourseLabel,
}

impl Shortened {
    fn note(&mut self, short_mm: f64, course: CourseLabel) {
        self.ends += 1;
        if short_mm > SHORTEST_MM {
            self.short += 1;
            if short_mm > self.worst_mm {
                (self.worst_mm, self.course) = (short_mm, course);
            }
        }
    }

    fn finding(&self) -> Option<Finding> {
        let Self { ends, short, worst_mm, course } = self;
        (*short > 0).then(|| {
            let message = format!(
                "{short} of {ends} ends of strokes overcut less than they should, at worst by {worst_mm:.3} mm in course {course}: a piece lies there, the carriage ends, or the same knife has its next stroke"
            );
            Finding::warning(Code::OvercutShortened, "/input/machine", message)
        })
    }
}
