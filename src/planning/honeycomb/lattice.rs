//! Where the tips of the published lattices lie on a section (domain.md B2, which places what the paper leaves open).

use super::lattice_kind::Lattice;
use super::section::{Reach, Section, SectionFault, within};
use crate::planning::geometry::Point2;
use crate::planning::tolerance::{KERF_MM, SAME_POINT_MM, TIP_SEARCH_MM};

/// The parameters of a lattice.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spacing {
    /// h, between layers, in mm.
    pub layer: f64,
    /// s, from tip to tip in a layer, in mm.
    pub step: f64,
    /// alpha in rad.
    pub swing: f64,
}

/// No lattice has more places for tips than this: a hundred times the 20,000 cuts that a big part takes.
const MOST_TIPS: f64 = 2_000_000.0;

/// Samples a step when the free stretches of a layer are looked for. A stretch shorter than a 32nd of a step, or
/// a blocked one, may be overlooked between two samples; the tips themselves are checked one by one all the same.
const SAMPLES_PER_STEP: f64 = 32.0;

/// The tips of a lattice on a section, layer by layer from the top, each from left to right; layers without tips
/// are left out. Those where the blade would enter the part are left out, by exact interference (`tip_allowed`).
///
/// Layers at z = H - n h above the base. Orthogonal: columns x = W/2 + (j - M/2) s, j = 0..M, M = floor(W/s).
/// Interlaced: the same, every second layer shifted by s/2, with a column beside the blank where its inner arm
/// still cuts. Free: on each layer the tips suit the contour, see `free_columns`.
///
/// # Errors
/// A spacing or step that is not finite or below a kerf, a swing outside 0 to 89.9 degrees, more than 2,000,000
/// tips.
pub fn tips(
    kind: Lattice,
    spacing: &Spacing,
    section: &Section,
    reach: &Reach,
) -> Result<Vec<Vec<Point2>>, SectionFault> {
    let (width, height) = (section.profile().width(), section.profile().blank_height());
    within("the layer spacing in mm", spacing.layer, KERF_MM, f64::MAX)?;
    within("the step in mm", spacing.step, KERF_MM, f64::MAX)?;
    within("the swing angle in rad", spacing.swing, 0.0, 1.569)?;
    let count = (height / spacing.layer).ceil() * (width / spacing.step + 2.0);
    if count > MOST_TIPS {
        return Err(SectionFault::TooManyTips { count, most: MOST_TIPS });
    }
    let layer = |number: u32| {
        let z = height - f64::from(number) * spacing.layer;
        let is_allowed = |x: f64| section.tip_allowed(&Point2::new(x, z), spacing.swing, reach);
        let columns = match kind {
            Lattice::Orthogonal => columns(width, spacing.step, 0.0, 0.0),
            Lattice::Interlaced if number % 2 == 1 => {
                columns(width, spacing.step, 0.0, beside(spacing, reach))
            }
            Lattice::Interlaced => columns(width, spacing.step, 0.5, beside(spacing, reach)),
            Lattice::Free => free_columns(width, spacing.step, &is_allowed),
        };
        columns.into_iter().filter(|&x| is_allowed(x)).map(|x| Point2::new(x, z)).collect::<Vec<_>>()
    };
    let layers = (1..).take_while(|&number| height - f64::from(number) * spacing.layer > SAME_POINT_MM);
    Ok(layers.map(layer).filter(|tips| !tips.is_empty()).collect())
}

/// The columns W/2 + (j + shift - M/2) s from `beside` mm left of the blank to as far right of it, these ends left
/// out if there is any.
fn columns(width: f64, step: f64, shift: f64, beside: f64) -> Vec<f64> {
    // A blank of exactly M steps has M + 1 columns, whatever the quotient rounds to.
    let most = ((width + SAME_POINT_MM) / step).floor();
    let column = |j: i64| width / 2.0 + (j as f64 + shift - most / 2.0) * step;
    let is_near = |x: f64| {
        let off = (-x).max(x - width);
        off <= SAME_POINT_MM || off < beside - SAME_POINT_MM
    };
    (-1..=most as i64 + 1).map(column).filter(|&x| is_near(x)).collect()
}

/// How far beside the blank a tip still cuts: its inner arm must reach in. More than half a step away it would
/// only cut what the tips inside free anyway.
fn beside(spacing: &Spacing, reach: &Reach) -> f64 {
    (reach.cutting * spacing.swing.sin()).min(spacing.step / 2.0)
}

/// The columns of a layer whose x are free.
///
/// Each stretch on which tips are allowed gets tips at both of its ends, so that they lie on the contour, and as
/// many between them, evenly spread, that none is more than a step from the next: the scallop on a layer is then
/// never worse than with a step, and least where it matters. Where a stretch ends at a side of the blank, the last
/// tip may stand half a gap away from it, as in the other lattices.
fn free_columns(width: f64, step: f64, is_allowed: &impl Fn(f64) -> bool) -> Vec<f64> {
    let count = (SAMPLES_PER_STEP * width / step).ceil();
    let sample = |index: i64| width * (index as f64 / count);
    let mut columns = Vec::new();
    let mut begin = is_allowed(0.0).then_some(0.0);
    for index in 1..=count as i64 {
        let (before, here) = (sample(index - 1), sample(index));
        match (begin, is_allowed(here)) {
            (None, true) => begin = Some(limit(here, before, is_allowed)),
            (Some(from), false) => {
                spread(from, limit(before, here, is_allowed), width, step, &mut columns);
                begin = None;
            }
            _ => {}
        }
    }
    if let Some(from) = begin {
        spread(from, width, width, step, &mut columns);
    }
    columns
}

/// The last allowed place from an allowed one toward a blocked one.
fn limit(mut allowed: f64, mut blocked: f64, is_allowed: &impl Fn(f64) -> bool) -> f64 {
    while (allowed - blocked).abs() > TIP_SEARCH_MM {
        let middle = f64::midpoint(allowed, blocked);
        if is_allowed(middle) { allowed = middle } else { blocked = middle }
    }
    allowed
}

/// Tips over an allowed stretch.
fn spread(from: f64, to: f64, width: f64, step: f64, columns: &mut Vec<f64>) {
    // At a side of the blank the row goes on half a step outside, with a tip that is not made.
    let (at_left, at_right) = (from <= 0.0, to >= width);
    let first = if at_left { -step / 2.0 } else { from };
    let last = if at_right { width + step / 2.0 } else { to };
    let gaps = ((last - first - SAME_POINT_MM) / step).ceil().max(0.0);
    let (begin, end) = (i64::from(at_left), gaps as i64 - i64::from(at_right));
    let place = |index: i64| if gaps == 0.0 { first } else { first + (last - first) * (index as f64 / gaps) };
    columns.extend((begin..=end).map(place));
}

#[cfg(test)]
mod tests {
    use rstest::rstest;

    use super::*;

    const TABLE_1: f64 = 85.0;

    fn section(points: &[(f64, f64)]) -> Section {
        let profile: Vec<Point2> = points.iter().map(|&(x, z)| Point2::new(x, z)).collect();
        Section::new(TABLE_1, 50.0, &profile, 0.0, 8.0).unwrap()
    }

    fn planned(kind: Lattice, spacing: Spacing, section: &Section) -> Result<Vec<Vec<Point2>>, SectionFault> {
        let cutting = spacing.layer / (kind.depth_factor() * spacing.swing.cos());
        tips(kind, &spacing, section, &Reach { cutting, edge: cutting, body: cutting })
    }

    /// x of a layer's tips.
    fn row(tips: &[Point2]) -> Vec<f64> {
        tips.iter().map(|tip| tip.x).collect()
    }

    const INITIAL: Spacing = Spacing { layer: 3.0, step: 6.0, swing: std::f64::consts::FRAC_PI_4 };

    #[test]
    fn columns_and_layers_lie_where_the_domain_puts_them() {
        let layers = planned(Lattice::Orthogonal, INITIAL, &section(&[(0.0, 0.0), (TABLE_1, 0.0)])).unwrap();
        let wanted: Vec<f64> = (0..=14).map(|j| 0.5 + 6.0 * f64::from(j)).collect();
        assert_eq!(layers.len(), 16);
        for (layer, z) in layers.iter().zip((2..=47).rev().step_by(3)) {
            assert_eq!(row(layer), wanted);
            assert!(layer.iter().all(|tip| tip.y == f64::from(z)));
        }
        // A layer on the base is none, nor is one a rounding above it.
        let spacing = Spacing { layer: 50.0 / 7.0, ..INITIAL };
        let layers = planned(Lattice::Orthogonal, spacing, &section(&[(0.0, 0.0), (TABLE_1, 0.0)])).unwrap();
        assert_eq!(layers.len(), 6);
        // Exactly M steps: a column on either side.
        let spacing = Spacing { step: TABLE_1 / 13.0, ..INITIAL };
        let layers = planned(Lattice::Orthogonal, spacing, &section(&[(0.0, 0.0), (TABLE_1, 0.0)])).unwrap();
        assert_eq!(layers[0].len(), 14);
        assert!(layers[0][0].x.abs() < 1e-9 && (layers[0][13].x - TABLE_1).abs() < 1e-9);
    }

    #[test]
    fn every_second_interlaced_layer_is_shifted_and_has_columns_beside_the_blank() {
        let layers = planned(Lattice::Interlaced, INITIAL, &section(&[(0.0, 0.0), (TABLE_1, 0.0)])).unwrap();
        let inner: Vec<f64> = (0..=14).map(|j| 0.5 + 6.0 * f64::from(j)).collect();
        // -2.5 and 87.5: their inner arms still cut the sides, 3 mm across.
        let shifted: Vec<f64> = (-1..=14).map(|j| 3.5 + 6.0 * f64::from(j)).collect();
        assert_eq!(row(&layers[0]), inner);
        assert_eq!(row(&layers[1]), shifted);
        assert_eq!(row(&layers[2]), inner);
    }

    #[test]
    fn free_tips_end_on_the_contour_and_stand_no_more_than_a_step_apart() {
        let hump = [(0.0, 5.0), (20.0, 5.0), (43.0, 31.0), (60.0, 5.0), (TABLE_1, 5.0)];
        let section = section(&hump);
        let layers = planned(Lattice::Free, Spacing { swing: 0.4, ..INITIAL }, &section).unwrap();
        for layer in &layers {
            let z = layer[0].y;
            let row = row(layer);
            assert!(row[0] <= 3.0 && row[row.len() - 1] >= TABLE_1 - 3.0, "{row:?}");
            let gaps: Vec<f64> = row.windows(2).map(|pair| pair[1] - pair[0]).collect();
            let wide: Vec<usize> = (0..gaps.len()).filter(|&index| gaps[index] > 6.0 + 1e-6).collect();
            if !(5.0..31.0 - 3.0).contains(&z) {
                assert!(wide.is_empty(), "{z}: {row:?}");
                continue;
            }
            // The hump takes one stretch out, and the tips beside it lie on it.
            assert_eq!(wide.len(), 1, "{z}: {row:?}");
            for tip in &layer[wide[0]..=wide[0] + 1] {
                assert!((section.profile().height(tip.x) - z).abs() < 1e-6, "{tip}");
            }
        }
    }

    #[test]
    fn tips_whose_arms_would_enter_the_part_are_left_out() {
        let wall = [(0.0, 5.0), (42.5, 5.0), (42.5, 40.0), (TABLE_1, 40.0)];
        let layers = planned(Lattice::Orthogonal, INITIAL, &section(&wall)).unwrap();
        // d sin(alpha) = 4.5 mm beside the wall no arm fits, down from where it would pass over the edge.
        assert_eq!(layers[3].last().map(|tip| tip.y), Some(38.0));
        assert!(layers[6].iter().all(|tip| tip.x <= 42.5 - 4.5), "{:?}", layers[6]);
        assert_eq!(layers[6].len(), 7);
    }

    #[rstest]
    #[case(Spacing { layer: 0.0, ..INITIAL }, "the layer spacing in mm is 0")]
    #[case(Spacing { step: f64::NAN, ..INITIAL }, "the step in mm is NaN")]
    #[case(Spacing { swing: 1.6, ..INITIAL }, "the swing angle in rad is 1.6")]
    #[case(Spacing { layer: 0.01, step: 0.01, ..INITIAL }, "at most 2000000 are planned")]
    fn spacings_that_make_no_lattice_are_refused(#[case] spacing: Spacing, #[case] said: &str) {
        let fault = planned(Lattice::Free, spacing, &section(&[(0.0, 5.0), (TABLE_1, 5.0)])).unwrap_err();
        assert!(fault.to_string().contains(said), "{fault}");
    }
}
