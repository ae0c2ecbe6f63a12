use proptest::prelude::*;

use super::*;
use crate::planning::tolerance::CURVE_CHORD_MM;

/// A drawing in mm from its entities, written as `0 LINE;8 1;10 0`.
fn drawing(entities: &str) -> String {
    let all = format!(
        "0 SECTION;2 HEADER;9 $INSUNITS;70 4;0 ENDSEC;0 SECTION;2 ENTITIES;{entities};0 ENDSEC;0 EOF"
    );
    let pairs = all.split(';').filter(|pair| !pair.is_empty()).map(|pair| pair.split_once(' ').unwrap());
    pairs.fold(String::new(), |text, (code, value)| text + code + "\n" + value + "\n")
}

fn loops(text: &str) -> Vec<ReadLoop> {
    let (loops, findings) = read("p.dxf", text.as_bytes(), None, Wanted::Ply).unwrap();
    assert_eq!(findings, []);
    loops
}

fn line(a: [f64; 2], b: [f64; 2]) -> String {
    format!("0 LINE;8 1;10 {};20 {};11 {};21 {};", a[0], a[1], b[0], b[1])
}

/// The largest distance of the middle of a chord, and of its ends, from where they should be.
fn worst(points: &[[f64; 3]], off: impl Fn([f64; 2]) -> f64) -> f64 {
    let ends = points.iter().zip(points.iter().cycle().skip(1));
    let middles = ends.map(|(a, b)| [(a[0] + b[0]) / 2.0, (a[1] + b[1]) / 2.0]);
    middles.chain(points.iter().map(|p| [p[0], p[1]])).map(off).fold(0.0, f64::max)
}

#[test]
fn no_chord_of_a_circle_leaves_it_and_there_are_no_more_than_needed() {
    for radius in [0.001, 1.0, 60.0, 2000.0, 90_000.0] {
        let read = loops(&drawing(&format!("0 CIRCLE;8 1;10 3;20 -4;40 {radius}")));
        let off = |[x, y]: [f64; 2]| ((x - 3.0).hypot(y + 4.0) - radius).abs();
        assert!(worst(&read[0].points, off) <= CURVE_CHORD_MM * 1.001, "{radius}");
        let needed = std::f64::consts::PI / (1.0 - (CURVE_CHORD_MM / radius).min(1.0)).acos();
        assert!(read[0].points.len() as f64 <= needed * 1.01 + 8.0, "{radius}: {}", read[0].points.len());
    }
}

#[test]
fn a_bulge_is_the_arc_that_it_stands_for_however_flat() {
    // The arc over a chord of 200 with bulge b has the sagitta 100 b and the radius 100 (1 + b^2) / (2 b).
    for bulge in [1e-5, 1e-3, 0.1, 0.5, 1.0, 3.0, -1e-5, -0.1, -1.0, -3.0_f64] {
        let entity = format!("0 LWPOLYLINE;8 1;70 1;10 -100;20 0;42 {bulge};10 100;20 0;10 0;20 5000");
        let read = loops(&drawing(&entity));
        let arc = &read[0].points[..read[0].points.len() - 1];
        let radius = 100.0 * (1.0 + bulge * bulge) / (2.0 * bulge);
        let center = 100.0 * (1.0 - bulge * bulge) / (2.0 * bulge);
        let off = |[x, y]: [f64; 2]| (x.hypot(y - center) - radius.abs()).abs();
        let chords = &arc.windows(2).map(|pair| worst(pair, off)).fold(0.0, f64::max);
        assert!(*chords <= CURVE_CHORD_MM * 1.001, "{bulge}: {chords}");
        let lowest = arc.iter().map(|p| p[1] * bulge.signum()).fold(f64::INFINITY, f64::min);
        assert!((lowest + 100.0 * bulge.abs()).abs() <= CURVE_CHORD_MM, "{bulge}: {lowest}");
    }
}

#[test]
fn a_rational_spline_is_the_circle_that_it_stands_for() {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let corners = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1), (1, 0)];
    let control: String = corners.iter().map(|(x, y)| format!("10 {};20 {};", x * 300, y * 300)).collect();
    let weights: String = (0..9).map(|i| format!("41 {};", if i % 2 == 0 { 1.0 } else { half })).collect();
    let knots: String = [0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4].iter().map(|k| format!("40 {k};")).collect();
    let read = loops(&drawing(&format!("0 SPLINE;8 1;70 13;71 2;{knots}{weights}{control}")));
    let off = |[x, y]: [f64; 2]| (x.hypot(y) - 300.0).abs();
    assert!(worst(&read[0].points, off) <= CURVE_CHORD_MM * 1.001);
    assert!(read[0].points.len() <= 2048, "{}", read[0].points.len());
}

#[test]
fn every_point_knows_the_line_of_its_vertex() {
    let text = drawing("0 LWPOLYLINE;8 1;70 1;10 0;20 0;10 400;20 0;42 1;10 400;20 100");
    let read = &loops(&text)[0];
    let value = |line: u32| text.lines().nth(line as usize - 1).unwrap();
    assert_eq!((read.lines[0], value(read.line)), (read.line + 6, "LWPOLYLINE"));
    assert!(
        read.lines.iter().zip(&read.points).all(|(line, point)| point[0] == 0.0 || value(*line) == "400")
    );
}

#[test]
fn a_drawing_cannot_ask_for_more_points_than_there_is_room_for() {
    let circles = "0 CIRCLE;8 11;10 0;20 0;40 99999;".repeat(200);
    let faults = read("p.dxf", drawing(&circles).as_bytes(), None, Wanted::Ply).unwrap_err();
    assert!(faults.iter().all(|fault| fault.code == Code::OutOfRange), "{faults:?}");
    assert!(faults[0].message.contains("more than 5000000 points"), "{}", faults[0]);
}

#[test]
fn many_ends_at_one_place_branch() {
    let crossing: String = (0..2000).map(|i| line([0.0, 0.0], [100.0 + f64::from(i), 50.0])).collect();
    let faults = read("p.dxf", drawing(&crossing).as_bytes(), None, Wanted::Ply).unwrap_err();
    assert!(faults.iter().any(|fault| fault.message.contains("more than two curves meet")), "{}", faults[0]);
}

#[test]
fn the_gap_of_an_open_chain_is_measured() {
    let text = drawing(
        &(line([0.0, 0.0], [400.0, 0.0])
            + &line([400.0, 0.25], [0.0, 150.0])
            + &line([0.0, 150.0], [0.0, 0.0])),
    );
    let faults = read("p.dxf", text.as_bytes(), None, Wanted::Ply).unwrap_err();
    assert_eq!(faults.len(), 1);
    assert!(
        faults[0].message.contains("x 400.0000 y 0.0000") && faults[0].message.contains("0.2500 mm away"),
        "{}",
        faults[0]
    );
}

/// A star whose corners are some way apart.
fn stars() -> impl Strategy<Value = Vec<[f64; 2]>> {
    prop::collection::vec(50.0..400.0_f64, 3..20).prop_map(|radii| {
        let count = radii.len() as f64;
        let corner = |(i, radius): (usize, f64)| {
            let (sin, cos) = (std::f64::consts::TAU * i as f64 / count).sin_cos();
            [radius * cos, radius * sin]
        };
        radii.into_iter().enumerate().map(corner).collect()
    })
}

fn flat(read: &ReadLoop) -> Vec<[f64; 2]> {
    read.points.iter().map(|point| [point[0], point[1]]).collect()
}

proptest! {
    #[test]
    fn a_polyline_comes_back_to_the_last_bit(star in stars()) {
        let vertices: String = star.iter().map(|[x, y]| format!("10 {x};20 {y};")).collect();
        let read = loops(&drawing(&format!("0 LWPOLYLINE;8 1;90 {};70 1;{vertices}", star.len())));
        prop_assert_eq!(flat(&read[0]), star);
    }

    #[test]
    fn lines_in_any_order_and_direction_come_back_as_the_same_outline(
        (star, order, turned) in stars().prop_flat_map(|star| {
            let count = star.len();
            let order = Just((0..count).collect::<Vec<_>>()).prop_shuffle();
            (Just(star), order, prop::collection::vec(any::<bool>(), count))
        }),
    ) {
        let entity = |&i: &usize| {
            let (a, b) = (star[i], star[(i + 1) % star.len()]);
            if turned[i] { line(b, a) } else { line(a, b) }
        };
        let read = loops(&drawing(&order.iter().map(entity).collect::<String>()));
        prop_assert_eq!(read.len(), 1);
        let found = flat(&read[0]);
        let start = star.iter().position(|corner| *corner == found[0]).unwrap();
        let forward: Vec<_> = (0..star.len()).map(|i| star[(start + i) % star.len()]).collect();
        let backward: Vec<_> = (0..star.len()).map(|i| star[(start + star.len() - i) % star.len()]).collect();
        prop_assert!(found == forward || found == backward, "{found:?}");
    }

    #[test]
    fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        check_places(&bytes)?;
    }

    #[test]
    fn any_pairs_are_read_or_refused(pairs in prop::collection::vec(any_pair(), 0..60)) {
        let text = drawing(&pairs.concat());
        check_places(text.as_bytes())?;
        let half = pairs.len() / 2;
        let block = format!("0 BLOCK;2 1;10 0;20 0;{}0 ENDBLK;", pairs[..half].concat());
        check_places(with_blocks(&block, &pairs[half..].concat()).as_bytes())?;
        // Cut off anywhere, too.
        check_places(&text.as_bytes()[..text.len() * 2 / 3])?;
    }
}

/// A drawing in mm from its blocks and its entities.
fn with_blocks(blocks: &str, entities: &str) -> String {
    let before = drawing(entities);
    let section = drawing(blocks).replace("2\nENTITIES\n", "2\nBLOCKS\n");
    let (_, section) = section.split_once("0\nENDSEC\n").unwrap();
    let (header, entities) = before.split_once("0\nENDSEC\n").unwrap();
    format!("{header}0\nENDSEC\n{}{entities}", section.strip_suffix("0\nEOF\n").unwrap())
}

/// An L, which is no mirror image of itself, on layer 0 of a block whose base lies at (1, 2).
const L_BLOCK: &str = "0 BLOCK;2 Piece;10 1;20 2;\
    0 LWPOLYLINE;8 0;70 1;10 1;20 2;10 5;20 2;10 5;20 3;10 2;20 3;10 2;20 9;10 1;20 9;0 TEXT;8 1;1 name;0 ENDBLK;";

#[test]
fn a_block_is_drawn_where_it_is_inserted() {
    let corners = [[0.0, 0.0], [4.0, 0.0], [4.0, 1.0], [1.0, 1.0], [1.0, 7.0], [0.0, 7.0]];
    type Place = fn([f64; 2]) -> [f64; 2];
    let cases: [(&str, Place); 6] = [
        ("10 100;20 50;", |[x, y]| [100.0 + x, 50.0 + y]),
        ("10 100;20 50;50 90;", |[x, y]| [100.0 - y, 50.0 + x]),
        ("10 100;20 50;41 2;42 2;50 90;", |[x, y]| [100.0 - 2.0 * y, 50.0 + 2.0 * x]),
        ("10 100;20 50;41 -3;42 3;", |[x, y]| [100.0 - 3.0 * x, 50.0 + 3.0 * y]),
        ("10 100;20 50;41 -1;42 1;50 90;", |[x, y]| [100.0 - y, 50.0 - x]),
        // Drawn from below: the plane is turned about y.
        ("10 100;20 50;210 0;220 0;230 -1;", |[x, y]| [-100.0 - x, 50.0 + y]),
    ];
    for (insert, place) in cases {
        let text = with_blocks(L_BLOCK, &format!("0 INSERT;8 1;2 PIECE;{insert}"));
        let (loops, findings) = read("p.dxf", text.as_bytes(), None, Wanted::Ply).unwrap();
        for (point, corner) in loops[0].points.iter().zip(corners) {
            let wanted = place(corner);
            assert!(
                (point[0] - wanted[0]).hypot(point[1] - wanted[1]) < 1e-9,
                "{insert}: {point:?} {wanted:?}"
            );
        }
        // The text within the block is left out, and that is said.
        assert_eq!(findings.iter().map(|finding| finding.code).collect::<Vec<_>>(), [Code::LeftOut]);
    }
}

#[test]
fn what_a_block_draws_keeps_its_own_layer_and_is_round_in_its_size() {
    let blocks = "0 BLOCK;2 ROUND;10 0;20 0;0 CIRCLE;8 11;10 0;20 0;40 1;0 ENDBLK;\
        0 BLOCK;2 PLY;10 0;20 0;0 CIRCLE;8 1;10 0;20 0;40 50;0 INSERT;8 7;2 round;10 10;20 0;41 5;42 5;0 ENDBLK;";
    let (loops, _) = read(
        "p.dxf",
        with_blocks(blocks, "0 INSERT;8 3;2 PLY;10 0;20 1000;41 2;42 2;").as_bytes(),
        None,
        Wanted::Ply,
    )
    .unwrap();
    assert_eq!(loops.len(), 2);
    for (read, [x, radius]) in loops.iter().zip([[0.0, 100.0], [20.0, 10.0]]) {
        let off = |[px, py]: [f64; 2]| ((px - x).hypot(py - 1000.0) - radius).abs();
        assert!(worst(&read.points, off) <= CURVE_CHORD_MM * 1.001);
    }
}

#[test]
fn inserts_that_cannot_be_followed_are_named() {
    let refused = |blocks: &str, entities: &str| {
        let faults = read("p.dxf", with_blocks(blocks, entities).as_bytes(), None, Wanted::Ply).unwrap_err();
        faults[0].to_string()
    };
    let at = "8 1;2 PIECE;10 0;20 0;";
    for (insert, says) in [
        (format!("0 INSERT;{at}41 2;42 1;"), "by 2 along x and 1 along y; explode the block"),
        (format!("0 INSERT;{at}70 2;"), "in rows or columns"),
        (format!("0 INSERT;{at}60 1;"), "invisible"),
        (format!("0 INSERT;{at}210 1;220 0;230 0;"), "leans"),
        ("0 INSERT;8 1;2 other;10 0;20 0;".to_owned(), "there is no block \"other\" in the file"),
    ] {
        let fault = refused(L_BLOCK, &insert);
        assert!(fault.contains(says), "{fault}");
    }
    let twice = format!("{L_BLOCK}{L_BLOCK}");
    let fault = refused(&twice, &format!("0 INSERT;{at}"));
    assert!(fault.contains("\"PIECE\" is there twice, first at line"), "{fault}");
    let pocket = L_BLOCK.replace("Piece", "POCKET");
    let both = format!("0 INSERT;{at}41 100;42 100;0 INSERT;{}", at.replace("PIECE", "pocket"));
    let fault = refused(&format!("{L_BLOCK}{pocket}"), &both);
    assert!(fault.contains("holds 2 pieces: the blocks \"PIECE\" at line"), "{fault}");
    assert!(fault.contains("\"pocket\" at line"), "{fault}");
    let none = refused(L_BLOCK, "");
    assert!(none.contains("inserts none of them"), "{none}");
    // A block within itself, and blocks within blocks that ask for more than any drawing has.
    let itself =
        refused("0 BLOCK;2 A;10 0;20 0;0 INSERT;8 1;2 A;10 0;20 0;0 ENDBLK;", "0 INSERT;8 1;2 A;10 0;20 0;");
    assert!(itself.contains("deeper than 16"), "{itself}");
    let ten = |of: &str| format!("0 INSERT;8 1;2 {of};10 0;20 0;").repeat(10);
    let levels = (1..9)
        .map(|level| format!("0 BLOCK;2 B{level};10 0;20 0;{}0 ENDBLK;", ten(&format!("B{}", level - 1))));
    let blocks = format!(
        "0 BLOCK;2 B0;10 0;20 0;{}0 ENDBLK;{}",
        line([0.0, 0.0], [1.0, 0.0]),
        levels.collect::<String>()
    );
    let many = refused(&blocks, "0 INSERT;8 1;2 B8;10 0;20 0;");
    assert!(many.contains("more than 1000000 entities"), "{many}");
    // An insert that draws nothing of what is read stands where it is.
    let title = with_blocks(
        "0 BLOCK;2 TITLE;10 0;20 0;0 LINE;8 9;10 0;20 0;11 1;21 1;0 ENDBLK;",
        "0 CIRCLE;8 1;10 0;20 0;40 5;0 INSERT;8 9;2 TITLE;10 0;20 0;41 2;42 1;",
    );
    let (_, findings) = read("p.dxf", title.as_bytes(), None, Wanted::Ply).unwrap();
    assert!(findings[0].message.contains("1 INSERT on layer \"9\" left out"), "{findings:?}");
}

fn any_pair() -> impl Strategy<Value = String> {
    let kinds = prop::sample::select(vec![
        "LINE",
        "ARC",
        "CIRCLE",
        "ELLIPSE",
        "SPLINE",
        "LWPOLYLINE",
        "POLYLINE",
        "VERTEX",
        "SEQEND",
        "INSERT",
        "TEXT",
        "HATCH",
        "ENDSEC",
        "SECTION",
        "EOF",
    ]);
    let codes = prop::sample::select(vec![
        2, 5, 8, 10, 11, 20, 21, 30, 31, 38, 39, 40, 41, 42, 43, 50, 51, 60, 66, 67, 70, 71, 72, 73, 90, 210,
        230, 999,
    ]);
    let values = prop::sample::select(vec![
        "0",
        "1",
        "2",
        "3",
        "-1",
        "0.5",
        "100",
        "-250.25",
        "11",
        "1e5",
        "-1e300",
        "1e308",
        "1e-300",
        "nan",
        "inf",
        "x",
        "ENTITIES",
        "9223372036854775807",
    ]);
    prop_oneof![
        1 => kinds.prop_map(|kind| format!("0 {kind};8 1;")),
        4 => (codes, values).prop_map(|(code, value)| format!("{code} {value};")),
    ]
}

fn check_places(bytes: &[u8]) -> Result<(), TestCaseError> {
    let lines = bytes.split(|byte| *byte == b'\n').count();
    let findings = match read("p.dxf", bytes, None, Wanted::Ply) {
        Ok((loops, findings)) => {
            prop_assert!(!loops.is_empty());
            prop_assert!(loops.iter().all(|read| read.points.len() == read.lines.len()));
            let numbers = loops.iter().flat_map(|read| &read.points).flatten();
            prop_assert!(numbers.into_iter().all(|x| x.abs() <= 100_000.0));
            findings
        }
        Err(faults) => {
            prop_assert!(faults.iter().any(Finding::is_error));
            faults
        }
    };
    for finding in findings {
        let line: usize = finding.at.strip_prefix("p.dxf:").unwrap().parse().unwrap();
        prop_assert!((1..=lines).contains(&line), "{} of {lines}", finding);
    }
    Ok(())
}
