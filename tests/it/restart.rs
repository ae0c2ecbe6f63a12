//! Restarts: from every label that says so, a program makes the rest of its cuts, wherever the machine stands.

use crate::golden::{cases, outcome};
use crate::linuxcnc::plan;
use crate::mutation::meaning;

/// Every program that the golden cases and the example give.
fn programs() -> Vec<String> {
    let example = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/wing-skin-trapezoid-45.job.json");
    let job = bladeplan::planning::document::read(&std::fs::read(example).unwrap()).unwrap();
    let catalogue = bladeplan::planning::tape::machine::Catalogue::built_in();
    let files = bladeplan::planning::document::files::Files::default();
    let budget = bladeplan::planning::budget::Budget::unwatched();
    let ply = plan(&job, &files, &catalogue, &budget).unwrap();
    let golden = cases().into_iter().flat_map(|case| outcome(&case).programs);
    golden.chain(ply.programs).map(|program| program.text).collect()
}

#[test]
fn from_every_label_the_rest_of_the_cuts_is_made() {
    let mut restarts = 0;
    for text in programs() {
        let whole = meaning(&text).unwrap().strokes;
        let lines: Vec<&str> = text.lines().collect();
        for (index, line) in lines.iter().enumerate().filter(|(_, line)| line.contains("RESTART HERE)")) {
            if line.contains("NO RESTART") {
                continue;
            }
            restarts += 1;
            // The machine stands elsewhere, with its knives down for all the program knows.
            let elsewhere = "N1 G1 U1.0 V-77.0 W66.0 A12.0 B-34.0 F1.0\nN2 M64 P0\nN3 M64 P1\n";
            let rest = meaning(&format!("{elsewhere}{}\n", lines[index..].join("\n"))).unwrap().strokes;
            // The first two strokes are the knives that came up at once.
            assert!(
                rest[..2].iter().all(|stroke| stroke.len() == 1),
                "{line}: a knife that is down is moved"
            );
            assert_eq!(rest[2..], whole[whole.len() - (rest.len() - 2)..], "{line}");
        }
    }
    assert!(restarts >= 15, "only {restarts} restarts tried");
}
