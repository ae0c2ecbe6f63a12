//! Plies of up to two million points: parsing alone, and all stages together.

mod table;

use std::fmt::Write as _;

use bladeplan::planning::attempt::plan;
use bladeplan::planning::budget::Budget;
use bladeplan::planning::document::files::Files;
use bladeplan::planning::document::{self, JobDocument};
use bladeplan::planning::tape::machine::{Catalogue, two_cutter_lab};
use bladeplan::planning::tape::wire::TapeCut;
use divan::Bencher;

const WIDTH_MM: f64 = 75.0;
const RADIUS_MM: f64 = 20_000.0;
const LENGTH_MM: f64 = 4000.0;
const POINTS_OF_A_COURSE: usize = 400;
/// Points of the boundary and courses, each pair twice what stands before it but for the leaps between pairs.
const SIZES: [(usize, usize); 6] =
    [(10_000, 25), (20_000, 50), (160_000, 100), (320_000, 200), (1_000_000, 400), (2_000_000, 800)];

fn main() {
    let (points, courses) = (1_000_000, 400);
    table::print(&format!("{points} points x {courses} courses"), job(points, courses).as_bytes(), 3);
    divan::main();
}

/// The job as serde reads it where nothing is checked.
#[derive(serde::Deserialize)]
struct Plain {
    input: TapeCut,
}

#[divan::bench(args = SIZES, sample_count = 3, sample_size = 1)]
fn parse_into_the_same_types(bencher: Bencher, (points, courses): (usize, usize)) {
    let text = job(points, courses);
    bencher.bench_local(|| serde_json::from_str::<Plain>(&text).expect("it is a job").input);
}

#[divan::bench(args = SIZES, sample_count = 3, sample_size = 1)]
fn read_and_plan(bencher: Bencher, (points, courses): (usize, usize)) {
    let text = job(points, courses);
    bencher.bench_local(|| {
        let job: JobDocument = document::read(text.as_bytes()).expect("it is a job");
        plan(&job, &Files::default(), &Catalogue::built_in(), &Budget::unwatched())
    });
}

/// A ply on a cylinder with wavy ends, its courses 20 degrees to the axis.
fn job(points: usize, courses: usize) -> String {
    let top = courses as f64 * WIDTH_MM - 0.4 * WIDTH_MM;
    let mut text = String::from(
        r#"{"kind":"tape-cut","name":"large","input":{"tape":{"width_mm":75,"thickness_mm":0.125},"boundary":{"points":["#,
    );
    let side = points / 4;
    for index in 0..points / 4 * 4 {
        let (u, v) = outline(index / side, (index % side) as f64 / side as f64, top);
        let [x, y, z] = place(u, v).0;
        write!(text, "{}[{x:.6},{y:.6},{z:.6}]", if index > 0 { "," } else { "" }).expect("memory");
    }
    text.push_str(r#"]},"tracks":["#);
    for course in 0..courses {
        let v = (course as f64 + 0.5) * WIDTH_MM;
        write!(text, r#"{}{{"number":{},"points":["#, if course > 0 { "," } else { "" }, course + 1)
            .expect("memory");
        for index in 0..POINTS_OF_A_COURSE {
            let share = index as f64 / (POINTS_OF_A_COURSE - 1) as f64;
            let ([x, y, z], [nx, ny, nz]) = place(wave(v) - 100.0 + (LENGTH_MM + 200.0) * share, v);
            let comma = if index > 0 { "," } else { "" };
            write!(
                text,
                r#"{comma}{{"position":[{x:.6},{y:.6},{z:.6}],"normal":[{nx:.9},{ny:.9},{nz:.9}]}}"#
            )
            .expect("memory");
        }
        text.push_str("]}");
    }
    let mut machine = serde_json::to_value(two_cutter_lab()).expect("a profile is JSON");
    machine["feed"]["max_length_mm"] = 1e7.into();
    write!(text, r#"],"machine":{machine},"options":{{"on_excess":"simplify"}}}}}}"#).expect("memory");
    text
}

/// A point of one of the four sides, in (u, v) of the courses.
fn outline(side: usize, share: f64, top: f64) -> (f64, f64) {
    let bottom = 0.4 * WIDTH_MM;
    let up = bottom + (top - bottom) * share;
    let down = top - (top - bottom) * share;
    match side {
        0 => (wave(bottom) + LENGTH_MM * (1.0 - share), bottom),
        1 => (wave(up), up),
        2 => (wave(top) + LENGTH_MM * share, top),
        _ => (wave(down) + LENGTH_MM, down),
    }
}

fn wave(v: f64) -> f64 {
    20.0 * (v / 300.0).sin() + 0.3 * v
}

/// A point of the plane of the courses on the cylinder, with its normal.
fn place(u: f64, v: f64) -> ([f64; 3], [f64; 3]) {
    let (sin, cos) = 20.0_f64.to_radians().sin_cos();
    let (x, y) = (u * cos - v * sin, u * sin + v * cos);
    let (turned, upright) = (y / RADIUS_MM).sin_cos();
    ([x, RADIUS_MM * turned, RADIUS_MM * upright], [0.0, turned, upright])
}
