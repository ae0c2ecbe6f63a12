use super::*;
use proptest::prelude::*;

fn pieces_of(boundary: &[Point2], holes: &[Vec<Point2>], width_mm: f64) -> Result<Vec<Piece>, Finding> {
    let known = |points: &[Point2]| points.iter().copied().map(Some).collect::<Vec<_>>();
    let ply = DevelopedPly {
        boundary: known(boundary).into(),
        holes: holes.iter().map(|hole| known(hole).into()).collect(),
        on_mould: None,
    };
    within_strip(&ply, width_mm)
}

fn points(list: &[(f64, f64)]) -> Vec<Point2> {
    list.iter().map(|&(u, v)| Point2::new(u, v)).collect()
}

#[test]
fn a_rectangle_over_the_strip_gives_two_square_cuts() {
    let ply = points(&[(0.0, -100.0), (400.0, -100.0), (400.0, 100.0), (0.0, 100.0)]);
    let pieces = pieces_of(&ply, &[], 75.0).unwrap();
    assert_eq!(pieces.len(), 1);
    assert_eq!(pieces[0].area_mm2, 400.0 * 75.0);
    let cuts: Vec<_> = pieces[0].cuts().collect();
    assert_eq!(cuts, [points(&[(400.0, -37.5), (400.0, 37.5)]), points(&[(0.0, 37.5), (0.0, -37.5)])]);
}

#[test]
fn an_outline_along_the_strip_edge_is_no_cut() {
    let ply = points(&[(0.0, -37.5), (400.0, -37.5), (400.0, 37.5), (0.0, 37.5)]);
    let pieces = pieces_of(&ply, &[], 75.0).unwrap();
    assert_eq!(pieces[0].cuts().count(), 2);
    // Half a micron of printing noise changes nothing.
    let noisy = points(&[(0.0, -37.5), (200.0, -37.4995), (400.0, -37.5), (400.0, 37.5), (0.0, 37.5)]);
    assert_eq!(pieces_of(&noisy, &[], 75.0).unwrap()[0].cuts().count(), 2);
}

#[test]
fn edge0_and_edge1_lie_exactly_at_half_the_width() {
    let ply = points(&[(0.0, -90.0), (300.0, -91.0), (420.0, 3.0), (310.0, 88.0), (10.0, 95.0)]);
    for cut in pieces_of(&ply, &[], 75.0).unwrap()[0].cuts() {
        assert_eq!(cut[0].y.abs(), 37.5);
        assert_eq!(cut[cut.len() - 1].y.abs(), 37.5);
    }
}

#[test]
fn a_u_shaped_ply_gives_two_pieces_in_order() {
    let ply = points(&[
        (0.0, -90.0),
        (300.0, -90.0),
        (300.0, 90.0),
        (200.0, 90.0),
        (200.0, -60.0),
        (100.0, -60.0),
        (100.0, 90.0),
        (0.0, 90.0),
    ]);
    let pieces = pieces_of(&ply, &[], 75.0).unwrap();
    let ranges: Vec<_> = pieces.iter().map(Piece::u_range).collect();
    assert_eq!(ranges, [(0.0, 100.0), (200.0, 300.0)]);
}

/// The pieces of a ply, both ways round, some of whose points belong to another part of the mould, and of all of it.
fn part_and_whole(ply: &[Point2], unknown_before: &[usize]) -> Vec<[Vec<Piece>; 2]> {
    let both = [false, true].map(|turned| {
        let mut known: Vec<Developed> = ply.iter().copied().map(Some).collect();
        unknown_before.iter().for_each(|&place| known.insert(place, None));
        if turned {
            known.reverse();
        }
        let part = DevelopedPly { boundary: known.into(), holes: vec![], on_mould: None };
        [within_strip(&part, 75.0).unwrap(), pieces_of(ply, &[], 75.0).unwrap()]
    });
    both.to_vec()
}

#[test]
fn what_lies_on_another_part_of_the_mould_is_outside_and_tells_no_sense() {
    let ply = points(&[(0.0, -90.0), (300.0, -90.0), (420.0, 3.0), (310.0, 90.0), (10.0, 90.0)]);
    for [pieces, whole] in part_and_whole(&ply, &[4, 1]) {
        assert_eq!((pieces.len(), pieces[0].sides.len()), (1, whole[0].sides.len()));
        assert!((pieces[0].area_mm2 - whole[0].area_mm2).abs() < 1e-6);
    }
}

/// The first corner of a ply, on the tape's edge, is an exit and an entry at once: the sense was taken from one of both.
#[test]
fn a_first_corner_that_touches_an_edge_tells_no_sense() {
    let ply = points(&[(0.0, -37.5), (5.0, -37.4), (100.0, 37.6), (100.0, 90.0), (0.0, 90.0)]);
    for [pieces, whole] in part_and_whole(&ply, &[4]) {
        assert_eq!(pieces.len(), 1);
        assert!((pieces[0].area_mm2 - whole[0].area_mm2).abs() < 1e-6);
    }
}

#[test]
fn an_outline_that_leaves_the_mould_within_the_strip_is_refused() {
    let mut known: Vec<Developed> =
        points(&[(0.0, -90.0), (300.0, 0.0), (0.0, 90.0)]).into_iter().map(Some).collect();
    known.insert(2, None);
    let fault = within_strip(&DevelopedPly { boundary: known.into(), holes: vec![], on_mould: None }, 75.0)
        .unwrap_err();
    assert_eq!((fault.code, fault.at.as_str()), (Code::OffMould, "/input/boundary/points/1"));
}

#[test]
fn a_narrow_ply_is_one_closed_cut_and_keeps_its_hole() {
    let ply = points(&[(0.0, -20.0), (300.0, -20.0), (300.0, 20.0), (0.0, 20.0)]);
    let hole = points(&[(100.0, -5.0), (110.0, -5.0), (110.0, 5.0), (100.0, 5.0)]);
    let pieces = pieces_of(&ply, &[hole], 75.0).unwrap();
    assert_eq!(pieces[0].area_mm2, 300.0 * 40.0 - 100.0);
    let cuts: Vec<_> = pieces[0].cuts().collect();
    assert_eq!(cuts.len(), 2);
    assert!(cuts.iter().all(|cut| cut[0] == cut[cut.len() - 1]));
}

#[test]
fn corners_that_only_touch_an_edge_pair_up() {
    // From inside: the ply's corner touches the tape edge. From outside: another ply's corner does.
    let diamond = points(&[(0.0, 0.0), (50.0, -37.5), (100.0, 0.0), (50.0, 37.5)]);
    let pieces = pieces_of(&diamond, &[], 75.0).unwrap();
    assert_eq!(pieces.iter().map(|piece| piece.area_mm2).sum::<f64>(), 3750.0);
    let beside = points(&[(0.0, 80.0), (50.0, 37.5), (100.0, 80.0)]);
    assert!(pieces_of(&beside, &[], 75.0).unwrap().is_empty());
    let notch = points(&[(0.0, -60.0), (100.0, -60.0), (100.0, 60.0), (50.0, -37.5), (0.0, 60.0)]);
    let pieces = pieces_of(&notch, &[], 75.0).unwrap();
    assert_eq!(pieces.iter().map(|p| p.area_mm2).sum::<f64>().round(), 4615.0);
}

proptest! {
    /// The pieces of all strips together are the ply, whatever the star-shaped outline and its hole.
    #[test]
    fn strips_share_out_the_ply(
        radii in prop::collection::vec(40.0..200.0_f64, 3..40),
        shift in -50.0..50.0_f64,
        hole in 1.0..30.0_f64,
    ) {
        let loop_of = |radius: &dyn Fn(usize) -> f64, count: usize| -> Vec<Point2> {
            (0..count).map(|i| {
                let angle = std::f64::consts::TAU * i as f64 / count as f64;
                Point2::new(radius(i) * angle.cos(), radius(i) * angle.sin() + shift)
            }).collect()
        };
        let ply = loop_of(&|i| radii[i], radii.len());
        let cut_out = loop_of(&|_| hole * 0.3, 12);
        let whole = signed_area(&ply) - signed_area(&cut_out);
        let shared: f64 = (-6..=6).map(|strip| {
            let moved = |points: &[Point2]| -> Vec<Point2> {
                points.iter().map(|p| Point2::new(p.x, p.y - 60.0 * f64::from(strip))).collect()
            };
            let pieces = pieces_of(&moved(&ply), &[moved(&cut_out)], 60.0).unwrap();
            pieces.iter().map(|piece| piece.area_mm2).sum::<f64>()
        }).sum();
        // Snapping to the tape's edge moves an outline by at most STRIP_EDGE_MM.
        prop_assert!((shared - whole).abs() <= 2.0 * STRIP_EDGE_MM * 200.0 * radii.len() as f64, "{} {}", shared, whole);
    }
}
