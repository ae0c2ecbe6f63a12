//! A course as a smooth curve on the mould: position, direction and normal at any arc length.
//!
//! A bare polyline misses the aim of 0.01 mm by itself, so position and frame are interpolated smoothly. At
//! each point of the course a polynomial of degree 4 is fitted to its neighbours (least squares over up to
//! nine points, over up to two tape widths where they still lie on one such polynomial, which averages out the
//! rounding of printed coordinates); between two points, position and normal follow the cubic through both with the
//! fitted rates. Beyond its ends the course continues with the
//! curvature and torsion that it ends with, and with their rate of change: on a cone of 20 degrees a helix
//! alone would miss by 0.02 mm a tape width beyond the end.

use std::ops::Range;

use super::input::Course;
use crate::planning::geometry::{Point3, Vector3};

/// Neighbours on each side that a fit takes in.
const REACH: usize = 4;
/// Degree of the fitted polynomials.
const DEGREE: usize = 4;

/// The moving frame of a course: U along it, N the mould's outward normal, V = N x U.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Station {
    /// Arc length from the start of the course in mm; negative before it.
    pub s: f64,
    /// A point of the centre line.
    pub origin: Point3,
    /// Along the course.
    pub u: Vector3,
    /// Across the tape.
    pub v: Vector3,
    /// Outward from the mould.
    pub n: Vector3,
}

/// What a course does where it is: normal and geodesic curvature and geodesic torsion, in 1/mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bend {
    /// dU/ds . N
    pub normal: f64,
    /// dU/ds . V
    pub geodesic: f64,
    /// dN/ds . V
    pub torsion: f64,
}

/// A smooth course with its continuations.
#[derive(Debug, Clone)]
pub struct Curve {
    nodes: Vec<Node>,
    length: f64,
    /// A ball around each [`PART`] of consecutive nodes: its middle, and its radius in mm.
    balls: Vec<(Point3, f64)>,
}

/// So many consecutive nodes are passed over together where they are too far away.
const PART: usize = 16;

/// Steps in mm in which a course is continued, each a helix with the bend at its middle. The error of a step is
/// of third order; at R 800 it is far below a nanometre.
const STEP_MM: f64 = 5.0;

#[derive(Debug, Clone, Copy)]
struct Node {
    station: Station,
    bend: Bend,
    /// dN/ds.
    normal_rate: Vector3,
}

/// What a fit says at one point, by the parameter of the chords.
struct Fit {
    rate: Vector3,
    bending: Vector3,
    normal_rate: Vector3,
    /// From the point to where the course passes it, in mm: nothing unless points close together were averaged.
    shift: Vector3,
    /// Over how much of the course it was fitted, in mm.
    reach_mm: f64,
    /// How far a fitted point is off at the most, in mm, and a normal, if that was wanted.
    off: [f64; 2],
}

impl Curve {
    /// The smooth curve through a course of at least two points, continued by `beyond_mm` at both ends. A fit reaches over
    /// two widths of the tape at the most, unless the points are farther apart.
    #[must_use]
    pub fn through(course: &Course, width_mm: f64, beyond_mm: f64) -> Self {
        let chords = cumulative_chords(&course.points);
        let fits = fits(course, &chords, width_mm);
        let mut nodes: Vec<Node> = Vec::with_capacity(fits.len());
        for (index, fit) in fits.iter().enumerate() {
            let s = match nodes.last() {
                None => 0.0,
                Some(last) => last.station.s + arc_length(course, &chords, &fits, index),
            };
            nodes.push(node(s, course.points[index] + fit.shift, course.normals[index], fit));
        }
        let length = nodes[nodes.len() - 1].station.s;
        let from_start = |node: &Node| node.station.s <= fits[0].reach_mm;
        let to_end = |node: &Node| node.station.s < length - fits[fits.len() - 1].reach_mm;
        let [first, last] = [nodes.partition_point(from_start), nodes.partition_point(to_end)];
        let after = continuation(&nodes[last.min(nodes.len() - 2)..], 1.0, beyond_mm);
        let mut before = continuation(&nodes[..first.max(2)], -1.0, beyond_mm);
        before.reverse();
        before.extend(nodes);
        before.extend(after);
        let balls = before.chunks(PART).map(ball).collect();
        Self { nodes: before, length, balls }
    }

    /// Length of the course in mm, without its continuations.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.length
    }

    /// The frame and the bend at arc length `s`; beyond the continuations on a helix. `part` is where to look first, and
    /// then where it was found: neighbouring places are in neighbouring parts.
    #[must_use]
    pub fn at(&self, s: f64, part: &mut usize) -> (Station, Bend) {
        let last = self.nodes.len() - 1;
        for end in [&self.nodes[0], &self.nodes[last]] {
            if (s - end.station.s) * (end.station.s - self.length / 2.0) >= 0.0 {
                return (helix(end, &end.bend, s), end.bend);
            }
        }
        let holds = |part: usize| self.nodes[part].station.s <= s && s < self.nodes[part + 1].station.s;
        let near =
            [*part, *part + 1, part.saturating_sub(1)].into_iter().find(|&part| part < last && holds(part));
        let found = || self.nodes.partition_point(|node| node.station.s <= s).clamp(1, last) - 1;
        *part = near.unwrap_or_else(found);
        between(&self.nodes[*part], &self.nodes[*part + 1], s)
    }

    /// Arc length of the node nearest to a point, and its distance in mm.
    #[must_use]
    pub fn nearest_node(&self, point: &Point3) -> (f64, f64) {
        let mut nearest = (0.0, f64::INFINITY);
        let least = |&(middle, radius): &(Point3, f64)| (point - middle).norm() - radius;
        let parts = self.nodes.chunks(PART).zip(&self.balls);
        // The part that promises most comes first, so that most others need no look.
        let first =
            (0..self.balls.len()).min_by(|&a, &b| least(&self.balls[a]).total_cmp(&least(&self.balls[b])));
        let promising = first.map(|first| parts.clone().skip(first).take(1));
        for (nodes, ball) in promising.into_iter().flatten().chain(parts) {
            if least(ball) < nearest.1 {
                for node in nodes {
                    let distance = (point - node.station.origin).norm();
                    if distance < nearest.1 {
                        nearest = (node.station.s, distance);
                    }
                }
            }
        }
        nearest
    }

    /// The longest step between two nodes in mm.
    #[must_use]
    pub fn longest_step(&self) -> f64 {
        self.nodes.windows(2).map(|pair| pair[1].station.s - pair[0].station.s).fold(0.0, f64::max)
    }
}

/// How far, about and at the most, places within a tape of that width may be off because the points of its course are so
/// far apart, in mm. Over a step in which the mould or the course turns by t, a polynomial of degree d is off by some
/// t^(d + 1) of the step; its direction is by as much, and that counts over the width.
#[must_use]
pub fn between_mm(course: &Course, width_mm: f64) -> f64 {
    let ways = course.points.windows(2).map(|pair| pair[1] - pair[0]);
    let steps: Vec<(Vector3, f64)> = ways.map(|way| (way / way.norm(), way.norm())).collect();
    // Small angles are chords of unit vectors.
    let bends: Vec<f64> = steps.windows(2).map(|pair| (pair[1].0 - pair[0].0).norm()).collect();
    let order = match course.points.len() {
        ..4 => 2,
        count => count.min(DEGREE + 1) as i32,
    };
    let off = steps.iter().enumerate().map(|(index, (_, length))| {
        let of_mould = (course.normals[index + 1] - course.normals[index]).norm();
        let before = index.checked_sub(1).map_or(0.0, |before| bends[before]);
        let after = bends.get(index).copied().unwrap_or(0.0);
        length.max(width_mm) * of_mould.max(before).max(after).powi(order)
    });
    off.fold(0.0, f64::max)
}

fn ball(nodes: &[Node]) -> (Point3, f64) {
    let middle = nalgebra::center(&nodes[0].station.origin, &nodes[nodes.len() - 1].station.origin);
    let radius = nodes.iter().map(|node| (node.station.origin - middle).norm()).fold(0.0, f64::max);
    (middle, radius)
}

fn cumulative_chords(points: &[Point3]) -> Vec<f64> {
    let mut chords = vec![0.0];
    for pair in points.windows(2) {
        chords.push(chords[chords.len() - 1] + (pair[1] - pair[0]).norm());
    }
    chords
}

/// The fits at all points: over the nearest points, or over more of the course where they are rounded and that is as good.
/// Then the course bends no more sharply than a polynomial of the degree can say.
fn fits(course: &Course, chords: &[f64], width_mm: f64) -> Vec<Fit> {
    let count = chords.len();
    // The curve goes through points that are as exact as they look, or that stand for themselves.
    let through = |fit: Fit| Fit { shift: Vector3::zeros(), ..fit };
    let narrow =
        |index: usize| through(fit_of::<NEAREST, false>(course, chords, index, window(index, count)));
    let mut fits: Vec<Fit> = (0..count).map(narrow).collect();
    // A few tell how the points were rounded.
    let some: Vec<[f64; 2]> = (0..SAMPLES.min(count))
        .map(|sample| sample * count / SAMPLES.min(count))
        .map(|index| fit_of::<NEAREST, true>(course, chords, index, window(index, count)).off)
        .collect();
    let rounding = [0, 1].map(|what| median(some.iter().map(|off| off[what]).collect()));
    if rounding[0] < EXACT_MM {
        return fits;
    }
    let most = [0, 1].map(|what| ROUGHER * rounding[what] + SMOOTH[what]);
    for (index, fit) in fits.iter_mut().enumerate() {
        let wide = [2.0, 1.0, 0.5].into_iter().filter_map(|widths| {
            let rows = spread(chords, index, widths * width_mm)?;
            Some(fit_of::<MOST_ROWS, true>(course, chords, index, rows))
        });
        let good = |wide: &Fit| wide.off[0] <= most[0] && wide.off[1] <= most[1];
        if let Some(wide) = wide.into_iter().find(good) {
            *fit = wide;
        }
    }
    fits
}

fn median(mut numbers: Vec<f64>) -> f64 {
    let middle = numbers.len() / 2;
    *numbers.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// So many points of a course are looked at for how they were rounded.
const SAMPLES: usize = 17;
/// Points off their polynomial by less, in mm, were hardly rounded: a wider fit could only lose.
const EXACT_MM: f64 = 1e-5;
/// The same rounding leaves points of one fit farther off than those of another: seldom by more than so many times.
const ROUGHER: f64 = 4.0;
/// What points, in mm, and normals may be off however good the fit over the nearest is.
const SMOOTH: [f64; 2] = [5e-6, 1e-8];
/// The rows of a fit over the nearest points, and of any.
const NEAREST: usize = 2 * REACH + 1;
const MOST_ROWS: usize = NEAREST + SPREAD;
/// So many points of a wide fit lie at even distances along the course.
const SPREAD: usize = 24;

/// The nearest points and others at even distances over so much of the course around a point, shifted inward at the ends;
/// `None` if there are no others.
fn spread(chords: &[f64], index: usize, reach_mm: f64) -> Option<Vec<usize>> {
    let nearest = window(index, chords.len());
    let length = chords[chords.len() - 1];
    let from = (chords[index] - reach_mm / 2.0).min(length - reach_mm).max(0.0);
    let step = reach_mm.min(length - from) / (SPREAD - 1) as f64;
    let at = |row: usize| {
        let goal = from + step * row as f64;
        let after = chords.partition_point(|chord| *chord < goal).clamp(1, chords.len() - 1);
        if goal - chords[after - 1] < chords[after] - goal { after - 1 } else { after }
    };
    let mut rows: Vec<usize> = (0..SPREAD).map(at).chain(nearest.clone()).collect();
    rows.sort_unstable();
    rows.dedup();
    (rows.len() > nearest.len()).then_some(rows)
}

/// Least squares with polynomials that are orthogonal on the points that are fitted (Forsythe 1957): each coefficient for
/// itself, without a system of equations.
///
/// How far the points are off it is found where that is wanted, `OFF`.
fn fit_of<const N: usize, const OFF: bool>(
    course: &Course,
    chords: &[f64],
    index: usize,
    fitted: impl IntoIterator<Item = usize, IntoIter: Clone + DoubleEndedIterator + ExactSizeIterator>,
) -> Fit {
    let fitted = fitted.into_iter();
    let count = fitted.len();
    let [first, last] = [fitted.clone().next(), fitted.clone().next_back()].map(|end| end.unwrap_or(index));
    // A parameter within [-1, 1] keeps the numbers well conditioned.
    let scale = (chords[last] - chords[index]).max(chords[index] - chords[first]);
    let mut at = [0.0; N];
    let (mut points, mut normals) = ([Vector3::zeros(); N], [Vector3::zeros(); N]);
    for (row, place) in fitted.enumerate() {
        at[row] = (chords[place] - chords[index]) / scale;
        points[row] = course.points[place] - course.points[index];
        normals[row] = course.normals[place];
    }
    let mut basis = Orthogonal::<N>::first(count);
    let zero = Vector3::zeros();
    let reach_mm = chords[last] - chords[first];
    let (middle, middle_normal) = (basis.times(&points), basis.times(&normals));
    let shift = middle / basis.squared;
    let mut fit = Fit { rate: zero, bending: zero, normal_rate: zero, shift, reach_mm, off: [0.0; 2] };
    if OFF {
        basis.leave(&mut points, &middle);
        basis.leave(&mut normals, &middle_normal);
    }
    for _ in 0..DEGREE.min(count - 1) {
        basis.advance(&at);
        let (along_points, along_normals) = (basis.times(&points), basis.times(&normals));
        let (slope, bending) = (basis.slope / basis.squared, basis.bending / basis.squared);
        fit.shift += along_points * (basis.value / basis.squared);
        fit.rate += along_points * slope;
        fit.bending += along_points * bending;
        fit.normal_rate += along_normals * slope;
        if OFF {
            basis.leave(&mut points, &along_points);
            basis.leave(&mut normals, &along_normals);
        }
    }
    fit.rate /= scale;
    fit.bending /= scale * scale;
    fit.normal_rate /= scale;
    if OFF {
        fit.off = [&points, &normals].map(|left| left.iter().map(Vector3::norm).fold(0.0, f64::max));
    }
    fit
}

/// One of a row of polynomials that are orthogonal on some points, with what the next one follows from.
struct Orthogonal<const N: usize> {
    /// Its values at the points; 0 beyond them.
    values: [f64; N],
    /// The sum of their squares.
    squared: f64,
    /// Value, first and second derivative at 0.
    value: f64,
    slope: f64,
    bending: f64,
    /// The one before, which is 0 for the first: values, the sum of their squares, and what it is at 0.
    before: ([f64; N], f64, [f64; 3]),
}

impl<const N: usize> Orthogonal<N> {
    /// The constant 1, on so many points.
    fn first(rows: usize) -> Self {
        let mut values = [0.0; N];
        values[..rows].fill(1.0);
        let before = ([0.0; N], 1.0, [0.0; 3]);
        Self { values, squared: rows as f64, value: 1.0, slope: 0.0, bending: 0.0, before }
    }

    /// The next: p' = (x - a) p - b q, with a and b such that it is orthogonal to p and to q, the one before.
    fn advance(&mut self, at: &[f64; N]) {
        let along: f64 = (0..N).map(|row| at[row] * self.values[row] * self.values[row]).sum();
        let a = along / self.squared;
        let (older, older_squared, [value, slope, bending]) = self.before;
        let b = self.squared / older_squared;
        self.before = (self.values, self.squared, [self.value, self.slope, self.bending]);
        for row in 0..N {
            self.values[row] = (at[row] - a) * self.values[row] - b * older[row];
        }
        self.squared = self.values.iter().map(|value| value * value).sum();
        self.bending = 2.0 * self.slope - a * self.bending - b * bending;
        self.slope = self.value - a * self.slope - b * slope;
        self.value = -a * self.value - b * value;
    }

    /// What is left of something at the same points without its part of this polynomial, `along` being `times` of it.
    fn leave(&self, others: &mut [Vector3; N], along: &Vector3) {
        let share = along / self.squared;
        for (value, other) in self.values.iter().zip(others) {
            *other -= share * *value;
        }
    }

    /// The sum of its values times those of something else at the same points.
    fn times(&self, others: &[Vector3; N]) -> Vector3 {
        self.values.iter().zip(others).fold(Vector3::zeros(), |sum, (value, other)| sum + other * *value)
    }
}

/// The neighbours of a point, shifted inward at the ends so that a fit there has as many.
fn window(index: usize, count: usize) -> Range<usize> {
    let width = (2 * REACH).min(count - 1);
    let first = index.saturating_sub(REACH).min(count - 1 - width);
    first..first + width + 1
}

/// Arc length of the cubic from the point before `index` to it, by Gauss's rule with three points.
fn arc_length(course: &Course, chords: &[f64], fits: &[Fit], index: usize) -> f64 {
    const GAUSS: [(f64, f64); 3] =
        [(0.112_701_665_379_258_3, 5.0 / 18.0), (0.5, 8.0 / 18.0), (0.887_298_334_620_741_7, 5.0 / 18.0)];
    let span = chords[index] - chords[index - 1];
    let [from, to] = [index - 1, index].map(|at| course.points[at] + fits[at].shift);
    let (start, end) = (fits[index - 1].rate * span, fits[index].rate * span);
    let speed = |t: f64| {
        let run = to - from;
        (run * (6.0 * t * (1.0 - t)) + start * ((3.0 * t - 4.0) * t + 1.0) + end * ((3.0 * t - 2.0) * t))
            .norm()
    };
    GAUSS.iter().map(|&(t, weight)| weight * speed(t)).sum()
}

fn node(s: f64, origin: Point3, normal: Vector3, fit: &Fit) -> Node {
    let speed = fit.rate.norm();
    let u = fit.rate / speed;
    let n = (normal - u * normal.dot(&u)).normalize();
    let v = n.cross(&u);
    let bending = (fit.bending - u * fit.bending.dot(&u)) / (speed * speed);
    let normal_rate = fit.normal_rate / speed;
    let bend = Bend { normal: bending.dot(&n), geodesic: bending.dot(&v), torsion: normal_rate.dot(&v) };
    // Within its own frame a unit normal that stays square to U turns like this and no other way.
    let normal_rate = v * bend.torsion - u * bend.normal;
    Node { station: Station { s, origin, u, v, n }, bend, normal_rate }
}

/// Nodes beyond an end of a course, outward: step by step with the bend going on to change as it does along
/// the last nodes, `end`.
fn continuation(end: &[Node], direction: f64, beyond_mm: f64) -> Vec<Node> {
    let rate = bend_rate(end);
    let mut last = if direction > 0.0 { end[end.len() - 1] } else { end[0] };
    let (from, start) = (last.station.s, last.bend);
    let steps = (beyond_mm / STEP_MM).ceil() as usize;
    let mut nodes = Vec::with_capacity(steps);
    for step in 1..=steps {
        let along = direction * STEP_MM * step as f64;
        let middle = start.changed(&rate, along - direction * STEP_MM / 2.0);
        let station = helix(&last, &middle, from + along);
        let bend = start.changed(&rate, along);
        last = Node { station, bend, normal_rate: station.v * bend.torsion - station.u * bend.normal };
        nodes.push(last);
    }
    nodes
}

/// How the bend changes along some nodes, per mm: the slope of the regression line of each of its parts.
fn bend_rate(nodes: &[Node]) -> Bend {
    let count = nodes.len() as f64;
    let middle = nodes.iter().map(|node| node.station.s).sum::<f64>() / count;
    let spread: f64 = nodes.iter().map(|node| (node.station.s - middle).powi(2)).sum();
    let slope = |part: fn(&Bend) -> f64| {
        nodes.iter().map(|node| (node.station.s - middle) * part(&node.bend)).sum::<f64>() / spread
    };
    Bend { normal: slope(|b| b.normal), geodesic: slope(|b| b.geodesic), torsion: slope(|b| b.torsion) }
}

impl Bend {
    fn changed(&self, rate: &Self, along: f64) -> Self {
        Self {
            normal: self.normal + rate.normal * along,
            geodesic: self.geodesic + rate.geodesic * along,
            torsion: self.torsion + rate.torsion * along,
        }
    }
}

/// The helix from a node with a constant bend: the frame turns about a fixed axis, the Darboux vector
/// `-torsion U - normal V + geodesic N`.
fn helix(node: &Node, bend: &Bend, s: f64) -> Station {
    let Station { s: s0, origin, u, v, n } = node.station;
    let along = s - s0;
    let darboux = v * -bend.normal - u * bend.torsion + n * bend.geodesic;
    let rate = darboux.norm();
    let turn = nalgebra::Rotation3::new(darboux * along);
    // Below this angle the sine rule loses digits and the course is straight to far better than a micron.
    let moved = if rate * along.abs() < 1e-9 {
        u * along
    } else {
        let axis = darboux / rate;
        let parallel = axis * u.dot(&axis);
        let square = u - parallel;
        let angle = rate * along;
        parallel * along + (square * angle.sin() + axis.cross(&square) * (1.0 - angle.cos())) / rate
    };
    Station { s, origin: origin + moved, u: turn * u, v: turn * v, n: turn * n }
}

/// Position and normal on the cubics through both with their rates there; the direction is that of the position's.
fn between(before: &Node, after: &Node, s: f64) -> (Station, Bend) {
    let (one, other) = (&before.station, &after.station);
    let span = other.s - one.s;
    let t = (s - one.s) / span;
    let (to, start, end) =
        (t * t * (3.0 - 2.0 * t), t * (1.0 - t) * (1.0 - t) * span, t * t * (t - 1.0) * span);
    let run = other.origin - one.origin;
    let origin = one.origin + run * to + one.u * start + other.u * end;
    let u = run * (6.0 * t * (1.0 - t) / span)
        + one.u * ((3.0 * t - 4.0) * t + 1.0)
        + other.u * ((3.0 * t - 2.0) * t);
    let u = u.normalize();
    let normal = one.n + (other.n - one.n) * to + before.normal_rate * start + after.normal_rate * end;
    let n = (normal - u * normal.dot(&u)).normalize();
    let mix = |a: f64, b: f64| a + (b - a) * t;
    let bend = Bend {
        normal: mix(before.bend.normal, after.bend.normal),
        geodesic: mix(before.bend.geodesic, after.bend.geodesic),
        torsion: mix(before.bend.torsion, after.bend.torsion),
    };
    (Station { s, origin, u, v: n.cross(&u), n }, bend)
}

impl Station {
    /// The station a little further on, by the first order of the frame's turn.
    #[must_use]
    pub fn advanced(&self, bend: &Bend, along: f64) -> Self {
        Self {
            s: self.s + along,
            origin: self.origin + self.u * along,
            u: self.u + (self.n * bend.normal + self.v * bend.geodesic) * along,
            v: self.v - (self.u * bend.geodesic + self.n * bend.torsion) * along,
            n: self.n + (self.v * bend.torsion - self.u * bend.normal) * along,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::label::CoursePlace;
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]
        /// A polynomial of the fit's own degree, at uneven places: its derivatives are known.
        #[test]
        fn a_fit_finds_the_derivatives_of_a_polynomial(
            steps in prop::collection::vec(0.5..3.0_f64, 4..16), coefficients in prop::array::uniform4(-1.0..1.0_f64),
            index in 0..16_usize
        ) {
            let mut at = vec![0.0];
            for step in &steps {
                at.push(at[at.len() - 1] + step);
            }
            let index = index % at.len();
            let value = |x: f64| coefficients.iter().rev().fold(0.0, |sum, c| (sum + c) * (x - at[index]) / 10.0);
            let course = Course {
                label: 1.into(),
                place: CoursePlace::default(),
                points: at.iter().map(|&x| Point3::new(x, value(x), 0.0)).collect(),
                normals: at.iter().map(|&x| Vector3::new(0.0, 2.0 * value(x), 1.0)).collect(),
            };
            let fit = fit_of::<NEAREST, false>(&course, &at, index, window(index, at.len()));
            let (first, second) = (coefficients[0] / 10.0, 2.0 * coefficients[1] / 100.0);
            prop_assert!((fit.rate - Vector3::new(1.0, first, 0.0)).norm() < 1e-10, "{}", fit.rate);
            prop_assert!((fit.bending - Vector3::new(0.0, second, 0.0)).norm() < 1e-10, "{}", fit.bending);
            prop_assert!((fit.normal_rate - Vector3::new(0.0, 2.0 * first, 0.0)).norm() < 1e-10);
        }
    }

    #[test]
    fn what_the_frame_is_a_little_further_on_is_the_first_order_of_what_it_is_there() {
        let onto = |t: f64| {
            let (sin, cos) = (t / 2.0_f64.sqrt() / 900.0).sin_cos();
            (Point3::new(900.0 * cos, 900.0 * sin, t / 2.0_f64.sqrt()), Vector3::new(cos, sin, 0.0))
        };
        let (points, normals) = (0..40).map(|i| onto(f64::from(i) * 20.0)).unzip();
        let curve = Curve::through(
            &Course { label: 1.into(), place: CoursePlace::default(), points, normals },
            100.0,
            100.0,
        );
        let mut part = 0;
        let (station, bend) = curve.at(333.0, &mut part);
        let (advanced, there) = (station.advanced(&bend, 1e-3), curve.at(333.001, &mut part).0);
        assert!((advanced.origin - there.origin).norm() < 2e-9);
        assert!(
            (advanced.u - there.u).norm() + (advanced.v - there.v).norm() + (advanced.n - there.n).norm()
                < 1e-9
        );
    }
}
