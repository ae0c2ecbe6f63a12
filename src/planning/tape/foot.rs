//! The foot of a point on a curved course, and what follows from it: its place in (u, v) (domain.md A3).
//!
//! An outline is followed point by point, for neighbouring points have neighbouring feet. While it is so far beside
//! the tape that it cannot come into it, no foot is looked for.

use std::ops::Range;

use super::curve::{Bend, Curve, Station, between_mm};
use super::developed::{DevelopedLoop, OnMould};
use super::input::Course;
use crate::planning::geometry::{Point2, Point3};
use crate::planning::tolerance::LAST_STEP_MM;

/// Beyond its ends a course is continued by so many tape widths.
pub const CONTINUED_WIDTHS: f64 = 2.0;
/// A point farther from the course than so many tape widths belongs to another part of the mould.
const FAR_WIDTHS: f64 = 4.0;
/// A point may lie off the course's plane by so many tape widths: half of half the width.
const OFF_PLANE_WIDTHS: f64 = 0.25;
/// Along the arc of a circle of so many tape widths a point half a width from the foot lies off the plane by so much:
/// (1 - cos x) / x = 1/2 for x = 1.109, half a width over the radius.
const TIGHTEST_WIDTHS: f64 = 0.45;
/// Points that are so many tape widths apart are no neighbours.
const NEIGHBOUR_WIDTHS: f64 = 1.0;
/// Newton's method for a foot converges in a few steps or not at all.
const MOST_FOOT_STEPS: usize = 30;
/// While an outline goes on by 1 mm its v changes by 1.05 mm at most: that much where it lies off the course's plane by as
/// much as is allowed at the tape's edge. So this share of a distance from the tape is certain to be free of it.
const CERTAIN_SHARE: f64 = 0.75;

/// A course on a curved mould.
pub struct Curved {
    curve: Curve,
    width_mm: f64,
    longest_step_mm: f64,
}

/// The foot of a point on a course.
#[derive(Debug, Clone, Copy)]
struct Foot {
    station: Station,
    bend: Bend,
    /// How fast the miss shrinks as the foot advances; above 0.
    slope: f64,
}

/// No foot: the point belongs to another part of the mould. It is at least so far from the course, in mm.
struct Elsewhere(f64);

/// What is known from the point before.
#[derive(Default)]
struct Search {
    last: Option<(Point3, Foot)>,
    /// The part of the course on which it lies.
    part: usize,
}

impl Curved {
    /// Of a course and a tape.
    #[must_use]
    pub fn new(course: &Course, width_mm: f64) -> Self {
        let curve = Curve::through(course, width_mm, CONTINUED_WIDTHS * width_mm);
        let longest_step_mm = curve.longest_step();
        Self { curve, width_mm, longest_step_mm }
    }

    /// What should be known of the course that this is.
    #[must_use]
    pub fn about(&self, course: &Course) -> OnMould {
        OnMould { length_mm: self.curve.length(), between_mm: between_mm(course, self.width_mm) }
    }

    /// A point for itself in (u, v).
    #[cfg(test)]
    pub fn place(&self, point: &Point3) -> Option<Point2> {
        let foot = self.search(point, &mut Search::default()).ok()?;
        Some(foot.place(point, self.width_mm))
    }

    /// A part of an outline, in (u, v). Points that are certain to be outside the tape, and whose neighbours are too, are
    /// left out; the first and the last of the part are not.
    pub fn develop(&self, points: &[Point3], part: Range<usize>, taken: &mut DevelopedLoop) {
        let mut search = Search::default();
        let (mut clear_mm, mut left_out) = (0.0, false);
        for index in part.clone() {
            let point = &points[index];
            let step_mm =
                if index + 1 < part.end { (points[index + 1] - point).norm() } else { f64::INFINITY };
            if clear_mm <= step_mm {
                left_out = false;
                let found = self.search(point, &mut search).map(|foot| foot.place(point, self.width_mm));
                let beside_mm = match &found {
                    Ok(place) => place.y.abs(),
                    Err(Elsewhere(off_mm)) => *off_mm,
                };
                clear_mm = CERTAIN_SHARE * (beside_mm - self.width_mm / 2.0);
                taken.push(index, found.ok());
            } else if !left_out {
                left_out = true;
                taken.leave_out();
            }
            clear_mm -= step_mm;
        }
    }

    fn search(&self, point: &Point3, search: &mut Search) -> Result<Foot, Elsewhere> {
        let neighbour = search
            .last
            .filter(|(last, _)| (point - last).norm_squared() <= (NEIGHBOUR_WIDTHS * self.width_mm).powi(2));
        let near = neighbour.and_then(|(last, foot)| {
            // To the first order the foot goes on with the point.
            let s = foot.station.s + (point - last).dot(&foot.station.u) / foot.slope;
            self.foot(point, s, &mut search.part)
        });
        let found = near.map_or_else(
            || {
                let (s, distance_mm) = self.curve.nearest_node(point);
                let elsewhere = || Elsewhere(distance_mm - self.longest_step_mm / 2.0);
                self.foot(point, s, &mut search.part).ok_or_else(elsewhere)
            },
            Ok,
        );
        search.last = found.as_ref().ok().map(|foot| (*point, *foot));
        found
    }

    /// The foot: where `(p - P) . U = 0`, if the point belongs to this part of the mould.
    fn foot(&self, point: &Point3, start: f64, part: &mut usize) -> Option<Foot> {
        let beyond = CONTINUED_WIDTHS * self.width_mm;
        let mut s = start;
        for _ in 0..MOST_FOOT_STEPS {
            if s < -beyond || s > self.curve.length() + beyond {
                return None;
            }
            let (station, bend) = self.curve.at(s, part);
            let chord = point - station.origin;
            if chord.norm() > FAR_WIDTHS * self.width_mm {
                return None;
            }
            let slope = 1.0 - chord.dot(&(station.n * bend.normal + station.v * bend.geodesic));
            if slope <= 0.0 {
                return None;
            }
            let miss = chord.dot(&station.u);
            if miss.abs() <= LAST_STEP_MM {
                let station = station.advanced(&bend, miss / slope);
                let off_plane = chord.dot(&station.n).abs();
                let belongs = off_plane <= OFF_PLANE_WIDTHS * self.width_mm;
                return belongs.then_some(Foot { station, bend, slope });
            }
            s += miss / slope;
        }
        None
    }
}

impl Foot {
    /// A point in (u, v) of its foot's frame: `v_dev = sign(v) c phi / sin(phi)` and `u_dev = s - tau w v / 3`.
    ///
    /// The arc touches the mould at the foot, so what a point lies off the plane there grows from nothing with v. What is
    /// more than the most that a mould is allowed to curve comes from a trace or an outline that lies off the mould a little:
    /// taken for an arc it would move a point on the centre line, where v is near 0, by half as much again to one side.
    fn place(&self, point: &Point3, width_mm: f64) -> Point2 {
        let Self { station, bend, .. } = self;
        let from_foot = point - station.origin;
        let v = from_foot.dot(&station.v);
        let tightest_mm = TIGHTEST_WIDTHS * width_mm;
        let most = if v.abs() < tightest_mm {
            v * v / (tightest_mm + (tightest_mm * tightest_mm - v * v).sqrt())
        } else {
            f64::INFINITY
        };
        let w = from_foot.dot(&station.n).clamp(-most, most);
        let chord = v.hypot(w);
        let sine = if chord > 0.0 { w.abs() / chord } else { 0.0 };
        // phi / sin(phi) tends to 1; below this sine it is 1 to the last digit.
        let stretch = if sine < 1e-8 { 1.0 } else { sine.asin() / sine };
        Point2::new(station.s - bend.torsion * w * v / 3.0, (chord * stretch).copysign(v))
    }
}

#[cfg(test)]
mod tests {
    use super::super::label::CoursePlace;
    use super::*;
    use crate::planning::geometry::Vector3;
    use proptest::prelude::*;

    const WIDTH_MM: f64 = 100.0;

    /// A helix on a cylinder, and the way onto what lies off it by as much along the normal.
    fn on_cylinder(radius: f64, angle: f64) -> (Course, impl Fn(f64, f64, f64) -> Point3) {
        let (sin, cos) = angle.sin_cos();
        let normal = move |u: f64, v: f64| {
            let (around, across) = ((u * sin + v * cos) / radius).sin_cos();
            Vector3::new(0.0, around, across)
        };
        let onto = move |u: f64, v: f64, off: f64| {
            Point3::new(u * cos - v * sin, 0.0, 0.0) + normal(u, v) * (radius + off)
        };
        let stations = (0..=60).map(|i| f64::from(i) * 10.0);
        let (points, normals) = stations.map(|u| (onto(u, 0.0, 0.0), normal(u, 0.0))).unzip();
        (Course { label: 1.into(), place: CoursePlace::default(), points, normals }, onto)
    }

    /// A trace in the middle of the tape's thickness, an outline on the mould: on the centre line v is 0, and beside it
    /// goes on without a step.
    #[test]
    fn what_lies_off_the_mould_a_little_moves_nothing_on_the_centre_line() {
        let (course, onto) = on_cylinder(900.0, 0.4);
        let curved = Curved::new(&course, WIDTH_MM);
        for off in [-0.125, 0.125] {
            for v in [0.0, 1e-9, 0.01, 0.3, 1.0, 3.0, 10.0, 50.0] {
                let place = curved.place(&onto(250.0, v, off)).unwrap();
                // Beside the foot what lies off by `off` is an arc of another radius: v changes by its share.
                let share = v * (off / 900.0_f64).abs();
                assert!((place.y - v).abs() < 0.005 + share, "{v}, off by {off}: {}", place.y);
                assert!((place.x - 250.0).abs() < 0.005, "{v}, off by {off}: {}", place.x);
            }
        }
    }

    /// Tubes as tight as a tape may lie on, along their axis: the arc is exact however strong its curvature.
    #[test]
    fn a_tight_tube_is_developed_exactly() {
        for radius in [0.455 * WIDTH_MM, 0.5 * WIDTH_MM, 0.6 * WIDTH_MM, 2.0 * WIDTH_MM] {
            let (course, onto) = on_cylinder(radius, 0.0);
            let curved = Curved::new(&course, WIDTH_MM);
            for v in (-50..=50).map(f64::from) {
                let place = curved.place(&onto(300.0, v, 0.0)).unwrap();
                assert!((place - Point2::new(300.0, v)).norm() < 1e-9, "R {radius}, {v}: {place}");
            }
        }
    }

    #[test]
    fn what_runs_beside_the_tape_is_passed_over() {
        let (course, onto) = on_cylinder(900.0, 0.4);
        let points: Vec<Point3> = (0..600).map(|i| onto(f64::from(i), 130.0, 0.0)).collect();
        let mut taken = DevelopedLoop::default();
        Curved::new(&course, WIDTH_MM).develop(&points, 0..points.len(), &mut taken);
        // Every 60 mm of 600, and what is left out between.
        assert!(taken.places.len() <= 24, "{}", taken.places.len());
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]
        /// Steps short and long, along and across, past the ends of the course and off the mould: what is left out lies on
        /// one side of the tape, on which the points before and after it lie too.
        #[test]
        fn nothing_of_the_tape_is_left_out(
            radius in 300.0..3000.0_f64, angle in -1.6..1.6_f64, start in (-100.0..700.0_f64, -390.0..390.0_f64),
            steps in prop::collection::vec(
                (0.0..std::f64::consts::TAU, prop_oneof![0.01..3.0_f64, 0.1..160.0_f64], 1..9_usize, -15.0..15.0_f64), 1..60),
        ) {
            let (course, onto) = on_cylinder(radius, angle);
            let curved = Curved::new(&course, WIDTH_MM);
            let mut at = start;
            let mut points = vec![onto(at.0, at.1, 0.0)];
            for (way, length, times, off) in steps {
                for _ in 0..times {
                    at = (at.0 + length * way.cos(), at.1 + length * way.sin());
                    points.push(onto(at.0, at.1, off));
                }
            }
            let mut taken = DevelopedLoop::default();
            curved.develop(&points, 0..points.len(), &mut taken);
            let exact = |index: usize| curved.place(&points[index]).map(|place| place.y);
            for (place, index) in taken.places.iter().zip(&taken.indices).filter_map(|(place, index)| place.zip(Some(index))) {
                prop_assert!((curved.place(&points[*index]).expect("it is here too") - place).norm() < 1e-6);
            }
            let side = |y: Option<f64>| y.map(|y| y.signum() * f64::from(u8::from(y.abs() >= WIDTH_MM / 2.0)));
            let kept: Vec<usize> = taken.places.iter().zip(&taken.indices)
                .filter(|(place, index)| place.is_some() || exact(**index).is_none()).map(|(_, index)| *index).collect();
            prop_assert_eq!((kept[0], kept[kept.len() - 1]), (0, points.len() - 1));
            for pair in kept.windows(2).filter(|pair| pair[1] - pair[0] > 1) {
                let sides: Vec<f64> = (pair[0]..=pair[1]).filter_map(|index| side(exact(index))).collect();
                prop_assert!(sides.iter().all(|one| *one != 0.0 && *one == sides[0]), "{:?}: {sides:?}", pair);
            }
        }
    }
}
