use proptest::prelude::*;

use super::super::label::PlyPlace;
use super::*;

fn ply(points: &[(f64, f64)]) -> Loop {
    points.iter().map(|&(x, y)| Point3::new(x, y, 0.0)).collect()
}

fn rule(angle_deg: f64, gap_mm: f64, offset_mm: f64) -> wire::Courses {
    wire::Courses { angle_deg, gap_mm, offset_mm }
}

/// Start and end of each course of a rule on a ply.
fn laid(rule: wire::Courses, width: f64, outline: &Loop) -> Vec<[[f64; 2]; 2]> {
    let courses = generate(&rule, Length::from_mm(width), PlyPlace::default(), outline, &[]).unwrap();
    assert!(
        courses
            .iter()
            .enumerate()
            .all(|(i, course)| course.label.number == i as u32 + 1 && course.place.index == i)
    );
    courses.iter().map(|course| [0, 1].map(|i| [course.points[i].x, course.points[i].y])).collect()
}

fn near(found: &[[[f64; 2]; 2]], expected: &[[[f64; 2]; 2]]) {
    let same = found.iter().flatten().flatten().zip(expected.iter().flatten().flatten());
    assert!(found.len() == expected.len(), "{found:?}");
    assert!(same.into_iter().all(|(one, other)| (one - other).abs() < 1e-9), "{found:?}");
}

fn rectangle() -> Loop {
    ply(&[(0.0, 0.0), (0.0, 160.0), (400.0, 160.0), (400.0, 0.0)])
}

#[test]
fn the_first_tape_begins_where_the_ply_does_and_the_last_covers_its_end() {
    let expected =
        [[[0.0, 37.5], [400.0, 37.5]], [[0.0, 112.5], [400.0, 112.5]], [[0.0, 187.5], [400.0, 187.5]]];
    near(&laid(rule(0.0, 0.0, 0.0), 75.0, &rectangle()), &expected);
    let mut other_sense = rectangle();
    other_sense.reverse();
    near(&laid(rule(0.0, 0.0, 0.0), 75.0, &other_sense), &expected);
    near(&laid(rule(360.0, 0.0, 0.0), 75.0, &rectangle()), &expected);
}

#[test]
fn a_strip_that_the_ply_ends_at_is_not_begun() {
    assert_eq!(laid(rule(0.0, 0.0, 0.0), 80.0, &rectangle()).len(), 2);
    assert_eq!(laid(rule(90.0, 0.0, 0.0), 100.0, &rectangle()).len(), 4);
}

#[test]
fn the_angle_turns_counter_clockwise_seen_from_above_and_laying_goes_to_the_left() {
    // Along +y, the left is -x: the first tape lies at the right, at x = 400.
    let up = laid(rule(90.0, 0.0, 0.0), 100.0, &rectangle());
    near(&up[..2], &[[[350.0, 0.0], [350.0, 160.0]], [[250.0, 0.0], [250.0, 160.0]]]);
    let back = laid(rule(180.0, 0.0, 0.0), 80.0, &rectangle());
    near(&back, &[[[400.0, 120.0], [0.0, 120.0]], [[400.0, 40.0], [0.0, 40.0]]]);
    let square = ply(&[(0.0, 0.0), (100.0, 0.0), (100.0, 100.0), (0.0, 100.0)]);
    let slanted = laid(rule(45.0, 0.0, 0.0), 200.0, &square);
    // One strip over v = -70.7 .. 129.3, from the corner at the origin to the one opposite.
    let [start, end] = slanted[0];
    assert!(end[0] > start[0] && (end[0] - start[0] - (end[1] - start[1])).abs() < 1e-9, "{slanted:?}");
    assert!(((end[0] - start[0]).hypot(end[1] - start[1]) - 100.0 * 2_f64.sqrt()).abs() < 1e-9);
}

#[test]
fn gap_and_offset_move_the_strips_and_leave_none_out_that_meets_the_ply() {
    // From v = 0 each 75 + 10; the offset of 30 leaves room for one before, of which 20 mm lie in the ply.
    let moved = laid(rule(0.0, 10.0, 30.0), 75.0, &rectangle());
    let v: Vec<_> = moved.iter().map(|course| course[0][1]).collect();
    assert_eq!(v, [-17.5, 67.5, 152.5]);
    // An offset of whole pitches changes nothing.
    near(&laid(rule(0.0, 10.0, 30.0 - 4.0 * 85.0), 75.0, &rectangle()), &moved);
    // The ply begins in a gap: what lies before it is left out.
    let after = laid(rule(0.0, 100.0, 50.0), 75.0, &rectangle());
    assert_eq!(after.iter().map(|course| course[0][1]).collect::<Vec<_>>(), [87.5]);
    // A ply that fits into a gap has no course.
    let narrow = ply(&[(0.0, 0.0), (9.0, 0.0), (9.0, 9.0), (0.0, 9.0)]);
    assert_eq!(laid(rule(0.0, 20.0, 10.0), 75.0, &narrow), [] as [[[f64; 2]; 2]; 0]);
}

#[test]
fn overlapping_tapes_lie_no_more_often_than_needed() {
    let courses = laid(rule(0.0, -5.0, 0.0), 75.0, &rectangle());
    assert_eq!(courses.iter().map(|course| course[0][1]).collect::<Vec<_>>(), [37.5, 107.5, 177.5]);
    // Two tapes that overlap by 5 reach 145 exactly; a third would add nothing.
    let outline = ply(&[(0.0, 0.0), (0.0, 145.0), (400.0, 145.0), (400.0, 0.0)]);
    assert_eq!(laid(rule(0.0, -5.0, 0.0), 75.0, &outline).len(), 2);
}

#[test]
fn each_course_is_as_long_as_the_ply_within_its_strip() {
    // An L whose step lies on the edge between two strips, and a slope that reaches its end within one.
    let outline =
        ply(&[(0.0, 0.0), (1000.0, 0.0), (1000.0, 75.0), (500.0, 75.0), (500.0, 150.0), (-30.0, 150.0)]);
    let courses = laid(rule(0.0, 0.0, 0.0), 75.0, &outline);
    near(&courses, &[[[-15.0, 37.5], [1000.0, 37.5]], [[-30.0, 112.5], [500.0, 112.5]]]);
}

#[test]
fn a_tilted_ply_has_its_courses_in_its_plane_and_its_normals_up() {
    let turn = nalgebra::Rotation3::from_axis_angle(&Vector3::x_axis(), 0.7);
    for reversed in [false, true] {
        let mut outline: Loop = rectangle().iter().map(|point| turn * point).collect();
        if reversed {
            outline.reverse();
        }
        let courses =
            generate(&rule(0.0, 0.0, 0.0), Length::from_mm(80.0), PlyPlace::default(), &outline, &[])
                .unwrap();
        assert_eq!(courses.len(), 2);
        let first = turn.inverse() * courses[0].points[0];
        assert!((first - Point3::new(0.0, 40.0, 0.0)).norm() < 1e-9, "{first}");
        assert!((courses[1].normals[1] - turn * Vector3::z()).norm() < 1e-12);
    }
}

#[test]
fn what_no_courses_can_be_generated_for_is_refused_in_words() {
    let refused = |rule: wire::Courses, outline: &Loop, holes: &[Loop]| {
        let fault = generate(&rule, Length::from_mm(75.0), PlyPlace::default(), outline, holes).unwrap_err();
        (fault.code, fault.at)
    };
    let mut bent = rectangle();
    bent[1].z = 0.05;
    let not_flat = (Code::NotFlat, "/input/courses".to_owned());
    assert_eq!(refused(rule(0.0, 0.0, 0.0), &bent, &[]), not_flat);
    let hole =
        vec![Point3::new(10.0, 10.0, 0.03), Point3::new(20.0, 10.0, 0.0), Point3::new(10.0, 20.0, 0.0)];
    assert_eq!(refused(rule(0.0, 0.0, 0.0), &rectangle(), &[hole]), not_flat);
    let upright = rectangle().iter().map(|point| Point3::new(point.x, 1.0, point.y)).collect();
    assert_eq!(refused(rule(0.0, 0.0, 0.0), &upright, &[]), not_flat);
    let out_of_range = (Code::OutOfRange, "/input/courses/gap_mm".to_owned());
    for gap in [-75.0, -80.0, -38.0] {
        assert_eq!(refused(rule(0.0, gap, 0.0), &rectangle(), &[]), out_of_range);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn every_point_of_a_ply_lies_under_a_course_that_is_long_enough(
        radii in prop::collection::vec(50.0..400.0_f64, 3..12),
        angle in -360.0..360.0_f64,
        width in 20.0..200.0_f64,
        offset in -500.0..500.0_f64,
    ) {
        let count = radii.len() as f64;
        let corner = |(i, radius): (usize, &f64)| {
            let turn = std::f64::consts::TAU * i as f64 / count;
            Point3::new(radius * turn.cos(), radius * turn.sin(), 0.0)
        };
        let outline: Loop = radii.iter().enumerate().map(corner).collect();
        let courses = generate(&rule(angle, 0.0, offset), Length::from_mm(width), PlyPlace::default(), &outline, &[]).unwrap();
        let steps = outline.iter().zip(outline.iter().cycle().skip(1));
        let points = steps.flat_map(|(a, b)| (0..10).map(move |k| a + (b - a) * (f64::from(k) / 10.0)));
        for point in points {
            let covers = |course: &Course| {
                let along = (course.points[1] - course.points[0]).normalize();
                let from = point - course.points[0];
                let (u, v) = (from.dot(&along), along.cross(&from).z);
                let length = (course.points[1] - course.points[0]).norm();
                // The tip of a thin corner that pokes out of a strip lies before it by more than it pokes out.
                let beside = (v.abs() - width / 2.0).abs() <= 2.0 * STRIP_EDGE_MM;
                beside || v.abs() <= width / 2.0 && (-1e-6..=length + 1e-6).contains(&u)
            };
            // A corner that pokes into a strip by no more than the width of an edge begins none.
            let over = |course: &Course| {
                let along = (course.points[1] - course.points[0]).normalize();
                along.cross(&(point - course.points[0])).z.abs() <= width / 2.0 - 2.0 * STRIP_EDGE_MM
            };
            prop_assert!(courses.iter().any(covers), "{point} lies under none of {courses:?}");
            prop_assert!(courses.iter().filter(|course| over(course)).all(covers), "{point}: {courses:?}");
        }
    }
}
