//! Cuts with errors of known size.

use proptest::prelude::*;

use super::super::compare::{Compared, compare};
use super::super::strokes::Stroke;
use super::*;
use crate::planning::tolerance::REPLAY_SLACK_MM;

const TOLERANCE_MM: f64 = 0.01;
const WITHIN_MM: f64 = TOLERANCE_MM + REPLAY_SLACK_MM;

type Points = Vec<[f64; 2]>;

fn compared(wanted: &[Points], made: &[Points]) -> (Compared, Vec<Finding>) {
    compared_with(0.0, wanted, made)
}

fn compared_with(overcut_mm: f64, wanted: &[Points], made: &[Points]) -> (Compared, Vec<Finding>) {
    let machine = lab();
    let wanted: Vec<_> =
        wanted.iter().map(|points| WantedCut { course: 1.into(), points: points.clone() }).collect();
    let strokes: Vec<_> = made.iter().map(|points| stroke(points)).collect();
    let setup = ReplaySetup {
        program: "p",
        machine: &machine,
        lead_mm: 0.0,
        tolerance_mm: TOLERANCE_MM,
        tape_width_mm: 300.0,
        wanted: &wanted,
        overcut_mm,
        pieces: &[],
        before: &[],
    };
    let mut faults = Faults::new("p");
    (compare(&setup, &strokes, &mut faults), faults.finish())
}

fn stroke(points: &[[f64; 2]]) -> Stroke {
    let mut stroke = Stroke::at(points[0]);
    for (index, point) in points.iter().enumerate().skip(1) {
        stroke.cut_to(*point, index);
    }
    stroke
}

fn length(points: &[[f64; 2]]) -> f64 {
    points.windows(2).map(|ends| (ends[1][0] - ends[0][0]).hypot(ends[1][1] - ends[0][1])).sum()
}

fn shifted(points: &[[f64; 2]], by: [f64; 2]) -> Points {
    points.iter().map(|point| [point[0] + by[0], point[1] + by[1]]).collect()
}

/// A straight cut of a given direction and length from a point.
fn straight(from: [f64; 2], direction_deg: f64, length_mm: f64) -> Points {
    let (sin, cos) = direction_deg.to_radians().sin_cos();
    vec![from, [from[0] + length_mm * cos, from[1] + length_mm * sin]]
}

/// An overcut goes on from its cut. A dip of the knife elsewhere is none, however short it is.
#[test]
fn a_stroke_that_goes_on_from_nothing_is_no_overcut() {
    let wanted = vec![vec![[100.0, -30.0], [100.0, 30.0]]];
    let longer = vec![[100.0, -34.0], [100.0, 34.0]];
    let (with, findings) = compared_with(5.0, &wanted, std::slice::from_ref(&longer));
    assert_eq!((findings, with.overcut_mm.round()), (vec![], 8.0));
    // Next to nothing is one too.
    let hardly = vec![[100.0, -30.0115], [100.0, 30.0]];
    assert_eq!(compared_with(5.0, &wanted, &[hardly]).1, []);
    let stray = vec![[200.0, 0.0], [204.0, 0.0]];
    let (with, findings) = compared_with(5.0, &wanted, &[longer, stray]);
    assert_eq!((codes(&findings), with.unwanted_mm), (vec![Code::Unwanted], 4.0));
}

fn codes(findings: &[Finding]) -> Vec<Code> {
    summary(findings).into_iter().map(|(code, _)| code).collect()
}

/// Three cuts, more than 10 mm apart, of any direction.
fn apart() -> impl Strategy<Value = Vec<Points>> {
    let cut = |index: f64| {
        (proptest::collection::vec((-60.0..60.0f64, -60.0..60.0f64), 2..9)).prop_map(move |points| {
            points.into_iter().map(|(r, v)| [100_000.0 + 200.0 * index + r, v]).collect::<Points>()
        })
    };
    (cut(0.0), cut(1.0), cut(2.0)).prop_map(|(a, b, c)| vec![a, b, c])
}

proptest! {
    #[test]
    fn what_is_made_as_wanted_passes(cuts in apart()) {
        let (figures, findings) = compared(&cuts, &cuts);
        prop_assert_eq!(findings, []);
        prop_assert!(figures.max_deviation_mm < 1e-9);
    }

    #[test]
    fn a_shift_is_found_to_a_nanometre(direction in 0.0..360.0f64, size in 0.0..0.9f64, long in 3.0..500.0f64) {
        let wanted = straight([100_000.0, 7.0], direction, long);
        let [dx, dy] = straight([0.0, 0.0], direction + 90.0, size)[1];
        let made = shifted(&wanted, [dx, dy]);
        let (figures, findings) = compared(&[wanted], &[made]);
        prop_assert!((figures.max_deviation_mm - size).abs() < 1e-9, "{} {size}", figures.max_deviation_mm);
        if size < WITHIN_MM - 1e-9 {
            prop_assert_eq!((figures.uncut_mm, figures.unwanted_mm), (0.0, 0.0));
            prop_assert_eq!(findings, []);
        } else if size > WITHIN_MM + 1e-9 {
            prop_assert!((figures.uncut_mm - long).abs() < 1e-9 && (figures.unwanted_mm - long).abs() < 1e-9);
            let all = [Code::Uncut, Code::Unwanted, Code::Deviation];
            prop_assert!(all.iter().all(|code| codes(&findings).contains(code)), "{findings:?}");
        }
    }

    /// One corner of a cut is thinned out, or made and not wanted: the deviation is its height over the chord.
    #[test]
    fn a_left_out_corner_is_found(height in 0.0..0.9f64, direction in 0.0..360.0f64) {
        let chord = straight([50_000.0, -3.0], direction, 40.0);
        let foot = straight(chord[0], direction, 13.0)[1];
        let corner = vec![chord[0], straight(foot, direction + 90.0, height)[1], chord[1]];
        for (wanted, made) in [(&corner, &chord), (&chord, &corner)] {
            let (figures, _) = compared(std::slice::from_ref(wanted), std::slice::from_ref(made));
            prop_assert!((figures.max_deviation_mm - height).abs() < 1e-9, "{}", figures.max_deviation_mm);
        }
    }

    #[test]
    fn a_missing_stroke_is_as_long_as_it_is(cuts in apart(), which in 0..3usize) {
        let mut made = cuts.clone();
        let missing = made.remove(which);
        let (figures, findings) = compared(&cuts, &made);
        prop_assert!((figures.uncut_mm - length(&missing)).abs() < 1e-6, "{}", figures.uncut_mm);
        prop_assert_eq!((figures.unwanted_mm, codes(&findings)), (0.0, vec![Code::Uncut]));
        prop_assert!(figures.max_deviation_mm < 1e-9);
    }

    #[test]
    fn an_added_stroke_is_as_long_as_it_is(cuts in apart(), which in 0..3usize) {
        let mut wanted = cuts.clone();
        let added = wanted.remove(which);
        let (figures, findings) = compared(&wanted, &cuts);
        prop_assert!((figures.unwanted_mm - length(&added)).abs() < 1e-6, "{}", figures.unwanted_mm);
        prop_assert_eq!((figures.uncut_mm, codes(&findings)), (0.0, vec![Code::Unwanted]));
        prop_assert!(figures.max_deviation_mm < 1e-9);
    }

    /// A straight cut is made a second time, over part of its length and a little beside itself.
    #[test]
    fn a_cut_made_twice_is_unwanted(
        direction in 0.0..360.0f64, start in 5.0..20.0f64, long in 1.0..20.0f64, beside in -0.01..0.01f64,
        pieces in 1..60usize,
    ) {
        let wanted = straight([9_000.0, 0.0], direction, 60.0);
        let begin = straight(straight(wanted[0], direction, start)[1], direction + 90.0, beside)[1];
        let again: Points = (0..=pieces)
            .map(|step| straight(begin, direction, long * step as f64 / pieces as f64)[1])
            .collect();
        let (figures, findings) = compared(std::slice::from_ref(&wanted), &[wanted.clone(), again]);
        // At both ends the second stroke is near the first one for up to 2 D more.
        let ends = ((2.0 * WITHIN_MM).powi(2) - beside * beside).sqrt();
        prop_assert!((figures.unwanted_mm - (long + ends)).abs() < 1e-6, "{} {long}", figures.unwanted_mm);
        prop_assert_eq!(figures.uncut_mm, 0.0);
        prop_assert!(codes(&findings).iter().all(|code| *code == Code::Unwanted) && !findings.is_empty());
    }

    /// Two neighbours that touch may share their cut; three cuts are one too many.
    #[test]
    fn a_cut_wanted_twice_may_be_made_once_or_twice(cuts in apart()) {
        let both = [cuts.clone(), cuts.clone()].concat();
        let (once, findings) = compared(&both, &cuts);
        prop_assert_eq!(findings, []);
        let (twice, findings) = compared(&both, &both);
        prop_assert_eq!(findings, []);
        prop_assert_eq!((once.unwanted_mm, twice.unwanted_mm), (0.0, 0.0));
        let straight = [straight([0.0, 0.0], 20.0, 50.0)];
        let thrice = [straight.clone(), straight.clone(), straight.clone()].concat();
        let (figures, _) = compared(&[straight.clone(), straight].concat(), &thrice);
        prop_assert!((figures.unwanted_mm - 50.0).abs() < 1e-6, "{}", figures.unwanted_mm);
    }

    /// However sharp the corners are, strokes that begin and end in them cut nothing twice, even if each lies
    /// anywhere within the tolerance.
    #[test]
    fn corners_between_strokes_are_no_double_cuts(
        angles in proptest::collection::vec(-179.5..179.5f64, 2..12),
        shifts in proptest::collection::vec((0.0..TOLERANCE_MM, 0.0..360.0f64), 12),
    ) {
        let mut wanted = vec![[5_000.0, 0.0]];
        let mut direction = 90.0;
        for (index, angle) in angles.iter().enumerate() {
            direction += angle;
            let last = wanted[wanted.len() - 1];
            wanted.push(straight(last, direction, 20.0 + 7.0 * index as f64)[1]);
        }
        let made: Vec<_> = wanted
            .windows(2)
            .zip(&shifts)
            .map(|(ends, (size, toward))| shifted(ends, straight([0.0, 0.0], *toward, *size)[1]))
            .collect();
        let (figures, findings) = compared(&[wanted], &made);
        prop_assert_eq!(findings, []);
        prop_assert_eq!((figures.uncut_mm, figures.unwanted_mm), (0.0, 0.0));
    }

    /// A knife that goes back over its own cut without being lifted cuts it twice too.
    #[test]
    fn going_back_over_a_cut_is_unwanted(direction in 0.0..360.0f64, back in 1.0..30.0f64) {
        let wanted = straight([0.0, 0.0], direction, 40.0);
        let mut made = wanted.clone();
        made.push(straight(wanted[1], direction + 180.0, back)[1]);
        let (figures, _) = compared(&[wanted], &[made]);
        prop_assert!((figures.unwanted_mm - back).abs() < 4.0 * WITHIN_MM, "{} {back}", figures.unwanted_mm);
    }
}

/// Two neighbours end at one point: what is missing at both is named for each course.
#[test]
fn missing_cuts_of_two_courses_are_told_apart() {
    let machine = lab();
    let cut =
        |course: u32, to: f64| WantedCut { course: course.into(), points: vec![[0.0, 0.0], [20.0, to]] };
    let wanted = [cut(4, 30.0), cut(5, -30.0)];
    let setup = ReplaySetup {
        program: "p",
        machine: &machine,
        lead_mm: 0.0,
        tolerance_mm: TOLERANCE_MM,
        tape_width_mm: 300.0,
        wanted: &wanted,
        overcut_mm: 0.0,
        pieces: &[],
        before: &[],
    };
    let mut faults = Faults::new("p");
    compare(&setup, &[], &mut faults);
    let messages: Vec<_> = faults.finish().into_iter().map(|finding| finding.message).collect();
    let place = |v| format!("r 0.0000 to 20.0000, v 0.0000 to {v}.0000, 36.0555 mm long, is not cut");
    assert_eq!(messages, [format!("course 4: {}", place(30)), format!("course 5: {}", place(-30))]);
}

/// A second knife cuts the same place in two strokes with a pause between them: two findings, not one.
#[test]
fn two_double_cuts_in_one_stroke_are_two() {
    let wanted = vec![[0.0, 0.0], [60.0, 0.0]];
    let again = vec![[5.0, 0.0], [15.0, 0.0], [15.0, 4.0], [30.0, 4.0], [30.0, 0.0], [45.0, 0.0]];
    let (figures, findings) = compared(std::slice::from_ref(&wanted), &[wanted.clone(), again]);
    let excursion_mm = 4.0 + 15.0 + 4.0 - 2.0 * WITHIN_MM;
    // Each of the four ends of the two stretches is blurred by the circles.
    assert!((figures.unwanted_mm - 25.0 - excursion_mm).abs() < 8.0 * WITHIN_MM, "{}", figures.unwanted_mm);
    let twice = findings.iter().filter(|finding| finding.message.contains("more often"));
    assert_eq!(twice.map(|finding| finding.at.as_str()).collect::<Vec<_>>(), ["p:1", "p:1", "p:1", "p:4"]);
}

#[test]
fn a_long_fine_outline_takes_no_quadratic_work() {
    let wave = |steps: usize| -> Points {
        (0..=steps)
            .map(|step| {
                let t = step as f64 / steps as f64;
                [4000.0 * t, 60.0 * (t * 40.0).sin()]
            })
            .collect()
    };
    let (wanted, made) = (wave(200_000), wave(20_000));
    let (figures, findings) = compared(std::slice::from_ref(&wanted), &[made]);
    assert_eq!(findings, []);
    // The height of an arc over a chord of 0.2 mm in r, where the wave curves most: 60 (40 / 4000)^2 0.2^2 / 8.
    assert!((figures.max_deviation_mm - 3.0e-5).abs() < 1e-6, "{}", figures.max_deviation_mm);
}
