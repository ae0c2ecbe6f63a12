//! Moulds with a chart: a plane figure laid on each, its outward normals, and straight courses across it.

use nalgebra::{Point3, Unit, UnitQuaternion, Vector3};
use proptest::prelude::*;

/// A surface on which a plane figure of about 300 mm around (0, 0) is laid.
#[derive(Debug, Clone, Copy)]
pub enum Mould {
    /// A plane turned about x by these degrees.
    Flat(f64),
    /// A cylinder of this radius, its axis along x.
    Cylinder(f64),
    /// A cone of this half angle in degrees; the figure lies this many mm from where its radius of curvature is 800 mm.
    Cone(f64, f64),
    /// A ring around z: the radii of its axis and of its section, in mm. No chart of it keeps lengths.
    Ring(f64, f64),
}

/// A mould: its shape, and whether the tape lies on its inside.
#[derive(Debug, Clone, Copy)]
pub struct Side {
    /// Its shape.
    pub mould: Mould,
    /// Whether normals point toward the centre of curvature.
    pub female: bool,
}

/// Half of a course, in mm: beyond every figure.
const REACH_MM: f64 = 420.0;
/// Distance of the points of a course on a curved mould, in mm.
const STEP_MM: f64 = 20.0;

/// All moulds with radii of 800 mm and more.
pub fn sides() -> impl Strategy<Value = Side> {
    let mould = prop_oneof![
        3 => (-60.0..60.0_f64).prop_map(Mould::Flat),
        2 => (800.0..3000.0_f64).prop_map(Mould::Cylinder),
        2 => (10.0..35.0_f64, 0.0..1000.0_f64).prop_map(|(half, away)| Mould::Cone(half, away)),
        2 => (800.0..3000.0_f64, 800.0..3000.0_f64).prop_map(|(axis, section)| Mould::Ring(axis, section)),
    ];
    (mould, any::<bool>()).prop_map(|(mould, female)| Side { mould, female })
}

impl Mould {
    /// The place of the figure's (x, y) and the normal away from the centre of curvature.
    fn outer(&self, x: f64, y: f64) -> (Point3<f64>, Vector3<f64>) {
        match *self {
            Self::Flat(tilt) => {
                let (sin, cos) = tilt.to_radians().sin_cos();
                (Point3::new(x, y * cos, y * sin), Vector3::new(0.0, -sin, cos))
            }
            Self::Cylinder(radius) => {
                let (sin, cos) = (y / radius).sin_cos();
                (Point3::new(x, radius * sin, radius * cos), Vector3::new(0.0, sin, cos))
            }
            Self::Cone(half, away) => {
                let (sin, cos) = half.to_radians().sin_cos();
                // Along a generator the radius of curvature is the slant times the tangent of the half angle.
                let slant = 800.0 * cos / sin + REACH_MM + away;
                let (far, turn) = ((slant + x).hypot(y), y.atan2(slant + x) / sin);
                let out = Vector3::new(0.0, turn.sin(), turn.cos());
                let along = Vector3::new(cos, 0.0, 0.0) + out * sin;
                (Point3::from(along * far), out * cos - Vector3::new(sin, 0.0, 0.0))
            }
            Self::Ring(axis, section) => {
                let (a, b) = (y / (axis + section), x / section);
                let out = Vector3::new(0.0, a.sin(), a.cos());
                let normal = out * b.cos() + Vector3::new(b.sin(), 0.0, 0.0);
                (Point3::from(out * axis + normal * section), normal)
            }
        }
    }

    /// Whether lengths on the mould are those of the figure.
    pub fn keeps_lengths(&self) -> bool {
        !matches!(self, Self::Ring(..))
    }

    /// The nearest place of the surface and its normal.
    fn nearest(&self, point: &Point3<f64>) -> (Point3<f64>, Vector3<f64>) {
        let Self::Ring(axis, section) = *self else { unreachable!("only a ring is marched over") };
        let out = Vector3::new(0.0, point.y, point.z).normalize();
        let normal = (point.coords - out * axis).normalize();
        (Point3::from(out * axis + normal * section), normal)
    }

    /// A straight course through the figure's point (x, y) at an angle in rad, from its start to its end.
    fn course(&self, (x, y): (f64, f64), angle: f64) -> Vec<(Point3<f64>, Vector3<f64>)> {
        let (sin, cos) = angle.sin_cos();
        let steps = (REACH_MM / STEP_MM) as i32;
        if let Self::Flat(_) = self {
            return [-REACH_MM, 0.0, REACH_MM].map(|s| self.outer(x + s * cos, y + s * sin)).to_vec();
        }
        if self.keeps_lengths() {
            let on_line = |step: i32| f64::from(step) * STEP_MM;
            return (-steps..=steps).map(on_line).map(|s| self.outer(x + s * cos, y + s * sin)).collect();
        }
        let (start, normal) = self.outer(x, y);
        let ahead = self.outer(x + 1e-3 * cos, y + 1e-3 * sin).0 - start;
        let mut points = self.marched(start, -ahead, steps);
        points.reverse();
        points.push((start, normal));
        points.extend(self.marched(start, ahead, steps));
        points
    }

    /// Points of a geodesic: short steps straight on, each brought back to the surface, its direction turned with the
    /// normal.
    fn marched(&self, start: Point3<f64>, way: Vector3<f64>, steps: i32) -> Vec<(Point3<f64>, Vector3<f64>)> {
        const PARTS: i32 = 10;
        let (mut at, mut normal) = self.nearest(&start);
        let mut way = (way - normal * way.dot(&normal)).normalize();
        let mut points = Vec::new();
        for step in 1..=steps * PARTS {
            let (next, turned) = self.nearest(&(at + way * (STEP_MM / f64::from(PARTS))));
            let with = UnitQuaternion::rotation_between_axis(
                &Unit::new_normalize(normal),
                &Unit::new_normalize(turned),
            );
            way = with.map_or(way, |with| with * way);
            (at, normal) = (next, turned);
            if step % PARTS == 0 {
                points.push((at, normal));
            }
        }
        points
    }
}

impl Side {
    /// The place of the figure's (x, y).
    pub fn place(&self, (x, y): (f64, f64)) -> [f64; 3] {
        self.mould.outer(x, y).0.coords.into()
    }

    /// Points with normals of a straight course through a place of the figure.
    pub fn course(&self, through: (f64, f64), angle: f64) -> Vec<([f64; 3], [f64; 3])> {
        let sense = if self.female { -1.0 } else { 1.0 };
        let points = self.mould.course(through, angle).into_iter();
        points.map(|(at, normal)| (at.coords.into(), (normal * sense).into())).collect()
    }
}

#[test]
fn charts_of_cylinder_and_cone_keep_lengths_and_all_normals_are_square() {
    let moulds =
        [Mould::Flat(30.0), Mould::Cylinder(800.0), Mould::Cone(20.0, 0.0), Mould::Ring(900.0, 1200.0)];
    for mould in moulds {
        for (x, y) in [(0.0, 0.0), (200.0, -150.0), (-300.0, 100.0)] {
            let (at, normal) = mould.outer(x, y);
            let steps = [(1e-4, 0.0), (0.0, 1e-4)].map(|(dx, dy)| mould.outer(x + dx, y + dy).0 - at);
            for step in steps {
                assert!(step.dot(&normal).abs() < 1e-10, "{mould:?}");
                assert!(!mould.keeps_lengths() || (step.norm() - 1e-4).abs() < 1e-10, "{mould:?}");
            }
            assert!(
                (normal.norm() - 1.0).abs() < 1e-12 && steps[0].cross(&steps[1]).dot(&normal) > 0.0,
                "{mould:?}"
            );
        }
    }
}
