//! What each motion of a program is: a cut, a turn beside the blank, or a way through air. Nothing else is let by.

use nalgebra::{Point3, Vector3};

use super::ReplaySetup;
use super::motion::{Happening, Motion, Place};
use crate::planning::finding::{Code, Finding};
use crate::planning::geometry::Point2;
use crate::planning::geometry::frame::Pose;
use crate::planning::honeycomb::blade::{Blade, Feed, Side};
use crate::planning::tolerance::{BLADE_PLANE_DEG, PRINTED_DEG, PRINTED_MM, SPEED_RATIO};

/// A slit that a program makes in the section.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MadeCut {
    /// x and z of the tip in mm.
    pub tip: Point2,
    /// To which side the blade leans.
    pub side: Side,
    /// By how much, in rad.
    pub swing: f64,
    /// Where it stands.
    pub place: Place,
}

/// What a motion is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Class {
    /// A slit through the whole blank.
    Cut(MadeCut),
    /// The blade turns, outside the blank.
    Turn,
    /// The blade goes through air.
    Free,
}

/// A motion and what it is.
pub type Classed<'a> = (&'a Motion, Class);

/// Says of every straight motion what it is. A motion that is none of the three is a finding, and left out.
#[must_use]
pub fn classify<'a>(
    setup: &ReplaySetup<'_>,
    happenings: &'a [Happening],
) -> (Vec<Classed<'a>>, Vec<Finding>) {
    let judge = Judge { setup, room: Room::of(setup) };
    let (mut classed, mut findings) = (Vec::with_capacity(happenings.len()), Vec::new());
    for (index, happening) in happenings.iter().enumerate() {
        match happening {
            Happening::Straight(motion) => match judge.class(motion) {
                Ok(class) => {
                    findings.extend(judge.faults(motion, class, happenings.get(index + 1)));
                    classed.push((motion, class));
                }
                Err(finding) => findings.push(finding),
            },
            Happening::Joints { from, to, place, .. } => {
                findings
                    .extend([from, to].into_iter().flatten().filter_map(|at| judge.joint_end(at, *place)));
            }
        }
    }
    (classed, findings)
}

/// The box of the blank.
struct Room {
    width: f64,
    length: f64,
    height: f64,
}

impl Room {
    fn of(setup: &ReplaySetup<'_>) -> Self {
        let blank = &setup.setting.blank;
        Self { width: blank.width_mm, length: blank.length_mm, height: blank.height_mm }
    }

    /// Whether the convex hull of some points lies beside or above the blank. The table below it is no room.
    fn is_outside(&self, points: &[Point3<f64>]) -> bool {
        let all = |outside: &dyn Fn(&Point3<f64>) -> bool| points.iter().all(outside);
        self.is_before_behind_or_above(points)
            || all(&|p| p.x <= PRINTED_MM)
            || all(&|p| p.x >= self.width - PRINTED_MM)
    }

    /// Whether it does so at one of the faces that cuts go through, or above all of it.
    fn is_before_behind_or_above(&self, points: &[Point3<f64>]) -> bool {
        let all = |outside: &dyn Fn(&Point3<f64>) -> bool| points.iter().all(outside);
        all(&|p| p.y <= PRINTED_MM)
            || all(&|p| p.y >= self.length - PRINTED_MM)
            || all(&|p| p.z >= self.height - PRINTED_MM)
    }
}

struct Judge<'a> {
    setup: &'a ReplaySetup<'a>,
    room: Room,
}

impl Judge<'_> {
    fn class(&self, motion: &Motion) -> Result<Class, Finding> {
        if motion.turns() {
            return self.turn(motion);
        }
        let mut swept = self.blade_at(&motion.from).to_vec();
        swept.extend(self.blade_at(&motion.to));
        // A lattice has tips beside the blank, of which only the arm on the inside meets material: what goes along the
        // whole blank there with the other arm is one of its cuts all the same.
        if motion.along_y() && !self.room.is_before_behind_or_above(&swept) {
            self.cut(motion).map(Class::Cut)
        } else if self.room.is_outside(&swept) {
            Ok(Class::Free)
        } else {
            let words = "the tool goes through the blank, and not along a cut";
            Err(self.fault(Code::ThroughStock, motion.place, words))
        }
    }

    /// The blade: its tip and the ends of both its edges.
    fn blade_at(&self, pose: &Pose) -> [Point3<f64>; 3] {
        let blade = self.blade();
        let length = blade.length.mm();
        let end = |feed| pose * Point3::from(double_edged(blade).front_in_tool(feed) * length);
        [pose * Point3::origin(), end(Feed::Out), end(Feed::Back)]
    }

    fn blade(&self) -> &Blade {
        &self.setup.setting.blade
    }

    /// A turn is sampled: at half a degree the end of a blade moves a hundredth of its length.
    fn turn(&self, motion: &Motion) -> Result<Class, Finding> {
        const STEP_DEG: f64 = 0.5;
        let steps = (motion.turn_deg / STEP_DEG).ceil().max(1.0);
        let mut step = 0.0;
        while step <= steps {
            let pose = between(&motion.from, &motion.to, step / steps);
            if !self.room.is_outside(&self.blade_at(&pose)) {
                let words = "the blade turns within the blank; turns are made beside it or above it";
                return Err(self.fault(Code::TurnInBlank, motion.place, words));
            }
            step += 1.0;
        }
        Ok(Class::Turn)
    }

    fn cut(&self, motion: &Motion) -> Result<MadeCut, Finding> {
        let feed = if motion.way().y > 0.0 { Feed::Out } else { Feed::Back };
        let normal = motion.to * Vector3::y();
        let refuse = |words: &str| Err(self.fault(Code::BladeAngle, motion.place, words));
        if normal.y.abs() > BLADE_PLANE_DEG.to_radians().sin() {
            return refuse("the blade does not lie in the plane of its cut");
        }
        let front = motion.to * self.blade().front_in_tool(feed);
        let angle = (front.y * feed.sign()).clamp(-1.0, 1.0).acos();
        if (angle - self.blade().edge_angle()).abs() > BLADE_PLANE_DEG.to_radians() {
            let words = format!(
                "the edge in front lies at {:.3} degrees from the feed; it must be {:.3}",
                angle.to_degrees(),
                self.blade().edge_angle().to_degrees()
            );
            return refuse(&words);
        }
        if front.z <= 0.0 {
            return refuse("the blade points upward");
        }
        self.goes_through(motion)?;
        let tip = Point2::new(motion.to.translation.x, motion.to.translation.z);
        let (side, swing) = lean(&front);
        Ok(MadeCut { tip, side, swing, place: motion.place })
    }

    /// A cut begins and ends with the whole blade outside.
    fn goes_through(&self, motion: &Motion) -> Result<(), Finding> {
        let ends = [&motion.from, &motion.to].map(|pose| self.blade_at(pose));
        if ends.iter().all(|end| self.room.is_outside(end)) {
            return Ok(());
        }
        let words = "a cut begins or ends with the blade within the blank; it must go on beyond both ends";
        Err(self.fault(Code::ThroughStock, motion.place, words))
    }

    /// What is wrong with a motion of a known class.
    fn faults(&self, motion: &Motion, class: Class, next: Option<&Happening>) -> Vec<Finding> {
        let process = &self.setup.setting.process;
        let cutting = matches!(class, Class::Cut(_));
        let limit = if cutting { process.cutting_speed_mm_s } else { process.travel_speed_mm_s };
        let mut findings = Vec::new();
        if motion.distance_mm > PRINTED_MM && motion.path_speed_mm_s > limit * SPEED_RATIO {
            let words = format!("runs at {} mm/s; {limit} are allowed here", motion.path_speed_mm_s);
            findings.push(self.fault(Code::SpeedExceeded, motion.place, &words));
        }
        let turn_limit = process.angular_speed_deg_s * SPEED_RATIO;
        if motion.turns() && motion.turn_deg / motion.seconds > turn_limit {
            let words = format!("turns faster than {} degrees/s", process.angular_speed_deg_s);
            findings.push(self.fault(Code::SpeedExceeded, motion.place, &words));
        }
        if cutting && !motion.ultrasonic {
            findings.push(self.fault(
                Code::KnifeState,
                motion.place,
                "cuts with the ultrasonic generator off",
            ));
        }
        if motion.blend_mm > 0.0 && !self.may_round(motion, class, next) {
            let words = "the end of this motion must not be rounded off: a cut or a turn begins there, or the blank is near";
            findings.push(self.fault(Code::ThroughStock, motion.place, words));
        }
        findings
    }

    /// A corner between two ways through air may be rounded off if what lies within the rounding is air too. Where the
    /// blade turns, that holds above the blank only: beside it a turn wants its exact place.
    fn may_round(&self, motion: &Motion, class: Class, next: Option<&Happening>) -> bool {
        let Some(Happening::Straight(next)) = next else { return false };
        if matches!(class, Class::Cut(_)) || motion.blend_mm > self.setup.setting.process.safety_distance_mm {
            return false;
        }
        let share = |whole: f64| if whole > 0.0 { (motion.blend_mm / whole).min(1.0) } else { 0.0 };
        let before = between(&motion.from, &motion.to, 1.0 - share(motion.distance_mm));
        let after = between(&next.from, &next.to, share(next.distance_mm));
        let corner: Vec<_> = [before, motion.to, after].iter().flat_map(|pose| self.blade_at(pose)).collect();
        if class == Class::Turn || next.turns() {
            return corner.iter().all(|point| point.z >= self.room.height);
        }
        self.room.is_outside(&corner)
    }

    /// Joints move on a way of their own: that begins and ends above the safety plane.
    fn joint_end(&self, pose: &Pose, place: Place) -> Option<Finding> {
        let lowest = self.room.height + self.setup.setting.process.safety_distance_mm;
        if pose.translation.z >= lowest - PRINTED_MM {
            return None;
        }
        let words = format!(
            "joints move with the tip at z = {:.3} mm; the way between is not straight, so they may only from z = {lowest} on",
            pose.translation.z
        );
        Some(self.fault(Code::ThroughStock, place, &words))
    }

    fn fault(&self, code: Code, place: Place, words: &str) -> Finding {
        Finding::error(code, self.setup.at(place), words)
    }
}

/// Both edges of a blade, whichever of them cut.
fn double_edged(blade: &Blade) -> Blade {
    Blade { edges: crate::planning::honeycomb::blade::Edges::Double, ..*blade }
}

/// A pose on the way: the place linear, the posture by the shortest turn.
#[must_use]
pub fn between(from: &Pose, to: &Pose, share: f64) -> Pose {
    let place = from.translation.vector.lerp(&to.translation.vector, share);
    // Opposite postures have no shortest turn; a control takes one of them.
    let turn = from.rotation.try_slerp(&to.rotation, share, f64::EPSILON).unwrap_or(to.rotation);
    Pose::from_parts(place.into(), turn)
}

/// To which side and how far an edge leans in the section.
fn lean(edge: &Vector3<f64>) -> (Side, f64) {
    let swing = edge.x.abs().atan2(edge.z);
    (if edge.x < 0.0 { Side::Left } else { Side::Right }, swing)
}

/// Whether two swings are one to the printed digits.
#[must_use]
pub fn same_swing(one: f64, other: f64) -> bool {
    (one - other).abs() <= BLADE_PLANE_DEG.max(PRINTED_DEG).to_radians()
}
