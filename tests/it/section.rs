//! Sections of the job documents that were handed over with the project, where they are at hand; the same figures
//! for contours of the project's own are kept beside the code.

use std::fs;
use std::path::{Path, PathBuf};

use bladeplan::planning::geometry::Point2;
use bladeplan::planning::honeycomb::blade::Side;
use bladeplan::planning::honeycomb::lattice::{Spacing, tips};
use bladeplan::planning::honeycomb::lattice_kind::Lattice;
use bladeplan::planning::honeycomb::section::{Cut, CutOutcome, Reach, Remains, Section};
use serde_json::Value;

/// A job document's section and blade.
struct Given {
    name: String,
    width: f64,
    height: f64,
    profile: Vec<Point2>,
    /// Length of the blade's edge in mm, and its angles theta and beta in rad.
    blade: [f64; 3],
}

/// All honeycomb jobs that were handed over: none in a clone of the repository alone.
fn given() -> Vec<Given> {
    let above = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors();
    let Some(entries) =
        above.map(|folder| fs::read_dir(folder.join("shared/data/honeycomb"))).find_map(Result::ok)
    else {
        return Vec::new();
    };
    let mut jobs: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    jobs.retain(|path| path.extension().is_some_and(|extension| extension == "json"));
    jobs.sort();
    jobs.iter().map(|path| read(path)).collect()
}

fn read(path: &Path) -> Given {
    let job: Value = serde_json::from_slice(&fs::read(path).unwrap()).unwrap();
    let input = &job["input"];
    let number = |place: &str| input.pointer(place).and_then(Value::as_f64);
    let points = input["profile"]["points"].as_array().unwrap();
    let length = number("/tool/blade_length_mm").or(number("/tool/max_cutting_length_mm"));
    Given {
        name: path.file_name().unwrap().to_string_lossy().into_owned(),
        width: number("/blank/width_mm").unwrap(),
        height: number("/blank/height_mm").unwrap(),
        profile: points.iter().map(|p| Point2::new(p[0].as_f64().unwrap(), p[1].as_f64().unwrap())).collect(),
        blade: [
            length.unwrap(),
            number("/tool/rake_angle_deg").unwrap().to_radians(),
            number("/tool/half_apex_angle_deg").unwrap().to_radians(),
        ],
    }
}

/// Number of tips, outcomes of all cuts, and what remains after a lattice was cut.
fn cut(
    given: &Given,
    kind: Lattice,
    layer: f64,
    step: f64,
    swing_deg: f64,
) -> (usize, Vec<CutOutcome>, Remains) {
    let swing = swing_deg.to_radians();
    let [length, rake, half_apex] = given.blade;
    let cutting = layer / (kind.depth_factor() * swing.cos());
    let edge = (length * (rake - half_apex).sin()).max(cutting);
    let reach = Reach { cutting, edge, body: length * (rake + half_apex).sin() };
    let mut section = Section::new(given.width, given.height, &given.profile, 0.0, cutting).unwrap();
    let layers = tips(kind, &Spacing { layer, step, swing }, &section, &reach).unwrap();
    let tips: Vec<Point2> = layers.into_iter().flatten().collect();
    let both =
        tips.iter().flat_map(|&tip| [Side::Left, Side::Right].map(|side| Cut { tip, side, swing, reach }));
    let outcomes: Vec<CutOutcome> = both.map(|cut| section.cut(&cut).unwrap()).collect();
    let lost: f64 =
        outcomes.iter().map(|o| o.slit_area + o.chips.iter().map(|chip| chip.area).sum::<f64>()).sum();
    let blank = given.width * given.height;
    assert!((section.stock_area() + lost - blank).abs() < 1e-5, "{}", given.name);
    (tips.len(), outcomes, section.remains())
}

/// domain.md B3, "published, counted exactly": tips, chips that stay, scallop.
#[test]
fn table_1_is_what_the_domain_says() {
    let wanted = [
        ("table1_arc.job.json", 3.0, 6.0, 45.0, 179, 0, None),
        ("table1_arc.job.json", 4.398, 5.968, 34.155, 119, 0, Some(8.03)),
        ("table1_wavy.job.json", 4.398, 5.968, 34.155, 117, 1, None),
    ];
    for given in given() {
        for &(_, layer, step, swing_deg, count, stuck, scallop) in
            wanted.iter().filter(|row| row.0 == given.name)
        {
            let (tips, outcomes, remains) = cut(&given, Lattice::Orthogonal, layer, step, swing_deg);
            assert_eq!((tips, remains.stuck.len()), (count, stuck), "{}", given.name);
            assert!(outcomes.iter().all(|outcome| !outcome.is_gouge()));
            let found = remains.scallop.unwrap().distance;
            assert!(scallop.is_none_or(|wanted: f64| (found - wanted).abs() < 0.005), "{found}");
        }
    }
}

#[test]
fn no_lattice_gouges_any_part_that_was_handed_over() {
    for given in given() {
        for kind in [Lattice::Orthogonal, Lattice::Interlaced, Lattice::Free] {
            let (swing_deg, cutting) =
                (34.0_f64, given.blade[0] * (given.blade[1] - given.blade[2]).sin() * 0.5);
            let layer = kind.depth_factor() * cutting * swing_deg.to_radians().cos();
            let step = 2.0 * layer * swing_deg.to_radians().tan();
            let (tips, outcomes, remains) = cut(&given, kind, layer, step, swing_deg);
            assert!(tips > 30, "{} {kind:?}: {tips}", given.name);
            assert!(outcomes.iter().all(|outcome| !outcome.is_gouge()), "{} {kind:?}", given.name);
            assert_eq!(remains.gouge_area, 0.0, "{} {kind:?}", given.name);
            assert!(remains.residual_area < given.width * given.height / 4.0, "{} {kind:?}", given.name);
        }
    }
}
