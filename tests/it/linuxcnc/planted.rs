//! Random programs whose meaning is known beforehand: LinuxCNC and our reader both find it in the text.
//! And random texts: what our reader accepts at all, LinuxCNC accepts, and does the same.

use bladeplan::planning::program::events::{AXIS_LETTERS, Event, Executed, Positions};
use bladeplan::planning::program::nc::read::read;
use proptest::prelude::*;
use proptest::sample::{Index, select};

use super::agreement::compare;
use super::interpret;
use crate::rounds::{rounds, runner};

const MODES: &str = "G21 G90 G17 G40 G49 G61 G93";
const ORIGIN: Positions = [0.0; 9];

/// A step, and which of X Y Z, A B C and U V W may move in it.
type PlantedStep = (Event, [bool; 3]);

fn step() -> impl Strategy<Value = PlantedStep> {
    // Whole numbers of the last printed digit, up to 200 m.
    let to = proptest::array::uniform9((-2_000_000_000_i32..=2_000_000_000).prop_map(|n| f64::from(n) / 1e4));
    let cruise_s = (1_u32..100_000).prop_map(|per_minute| Some(60.0 / f64::from(per_minute)));
    let seconds = (1_u32..1_000_000).prop_map(|n| f64::from(n) / 1e3);
    let event = prop_oneof![
        5 => (to, prop_oneof![4 => cruise_s, 1 => Just(None)])
            .prop_map(|(to, cruise_s)| Event::Move { from: ORIGIN, to, cruise_s }),
        2 => (0_u32..8, any::<bool>()).prop_map(|(number, on)| Event::Output { number, on }),
        1 => seconds.prop_map(|seconds| Event::Dwell { seconds }),
        1 => Just(Event::OptionalStop),
    ];
    (event, any::<[bool; 3]>())
}

fn steps(most: usize) -> impl Strategy<Value = Vec<PlantedStep>> {
    proptest::collection::vec(step(), 1..most)
}

/// The program that does some steps, and what it does, one line a step.
fn program(steps: Vec<PlantedStep>) -> (String, Vec<Executed>) {
    let mut text = format!("{MODES}\n");
    let mut planted = Vec::new();
    let mut position = ORIGIN;
    for (i, (mut event, moving)) in steps.into_iter().chain([(Event::End, [false; 3])]).enumerate() {
        if let Event::Move { from, to, .. } = &mut event {
            *from = position;
            (0..9).filter(|axis| !moving[axis / 3]).for_each(|axis| to[axis] = from[axis]);
            position = *to;
        }
        text = text + &words(&event) + "\n";
        planted.push(Executed { line: i + 2, event });
    }
    (text, planted)
}

fn words(event: &Event) -> String {
    let axes = |to: &Positions| -> String {
        AXIS_LETTERS.iter().zip(to).map(|(letter, value)| format!(" {letter}{value:.4}")).collect()
    };
    match event {
        Event::Move { to, cruise_s: None, .. } => format!("G0{}", axes(to)),
        Event::Move { to, cruise_s: Some(seconds), .. } => format!("G1{} F{:.0}", axes(to), 60.0 / seconds),
        Event::Output { number, on } => format!("M{} P{number}", if *on { 64 } else { 65 }),
        Event::Dwell { seconds } => format!("G4 P{seconds:.3}"),
        Event::OptionalStop => "M1".to_owned(),
        Event::End => "M2".to_owned(),
    }
}

#[test]
fn planted_programs_come_back() {
    let mut runner = runner(200);
    let come_back = |steps| {
        let (text, planted) = program(steps);
        let refused = |why: String| TestCaseError::fail(format!("{why}\n{text}"));
        let canon = interpret(&text).map_err(|error| refused(format!("{error:?}")))?;
        let ours = read("p.ngc", &text).map_err(|faults| refused(format!("{faults:?}")))?;
        compare(&canon, &planted).and_then(|()| compare(&canon, &ours)).map_err(refused)
    };
    runner.run(&steps(40), come_back).unwrap();
}

/// Something put into a program, where some characters are taken away: of all places that `follows` allows, one.
#[derive(Debug, Clone)]
struct Damage {
    follows: &'static [char],
    place: Index,
    taken: usize,
    put: &'static str,
}

fn damage() -> impl Strategy<Value = Damage> {
    let characters = select(vec![
        "", "0", "1", "9", ".", "-", "+", " ", "\t", "\n", "\r", "(", ")", ";", "%", "/", "#", "[", "=", "e",
        "E", "G", "M", "P", "p", "U", "w", "X", "N", "n", "F", "D", "O",
    ]);
    let words = select(vec![
        "g0", "G00", "G1 ", "G01", "G61.1 ", "G 4", "m1", "M2", "M02", "M64", "P0", "F1 ", "V+2", "w.5 ",
        "A1.", "u-.25", "X1", "(a)", "(a) ", "; b", "; b\n", "N7 ", "00", "-", "\t ", "\r\n",
    ]);
    let blocks = select(vec![
        "m065p1\n",
        "G4P.5\r\n",
        "g1v-2.5 f 9\n",
        "G00 U5 X-1\n",
        "\n",
        "A+3. F7\n",
        "N1G61.1(x)G17\n",
        "W 1\n",
        "M01\n",
        "G04 P1 (\n",
        "% \n",
        "U1 V\n",
        "M2\n",
    ]);
    let placed = |follows: &'static [char], taken: std::ops::Range<usize>, put| {
        (any::<Index>(), taken, put).prop_map(move |(place, taken, put)| Damage {
            follows,
            place,
            taken,
            put,
        })
    };
    prop_oneof![
        placed(&[], 0..4, characters),
        placed(&[' ', '\n'], 0..1, words),
        placed(&['\n'], 0..1, blocks)
    ]
}

fn damaged(text: &str, damages: &[Damage]) -> String {
    let mut text = text.to_owned();
    for Damage { follows, place, taken, put } in damages {
        let allowed = |at: &usize| follows.is_empty() || text[..*at].ends_with(*follows);
        let places: Vec<usize> = (0..=text.len()).filter(allowed).collect();
        if places.is_empty() {
            continue;
        }
        let start = *place.get(&places);
        text.replace_range(start..(start + taken).min(text.len()), put);
    }
    text
}

#[test]
fn a_damaged_program_that_our_reader_accepts_does_the_same_on_linuxcnc() {
    let damages = proptest::collection::vec(damage(), 1..4);
    let mut runner = runner(2_000);
    let accepted = std::cell::Cell::new(0);
    let agree = |(steps, damages): (_, Vec<_>)| {
        let text = damaged(&program(steps).0, &damages);
        let Ok(ours) = read("p.ngc", &text) else { return Ok(()) };
        accepted.set(accepted.get() + 1);
        let refused = |why: String| TestCaseError::fail(format!("{why}\n{text:?}"));
        let canon = interpret(&text).map_err(|error| refused(format!("{error:?}")))?;
        compare(&canon, &ours).map_err(refused)
    };
    runner.run(&(steps(6), damages), agree).unwrap();
    // About one in ten is; the test must not drift into refusals only.
    let tried = rounds(2_000);
    assert!(
        accepted.get() > tried / 20,
        "only {} of {tried} texts were accepted and compared",
        accepted.get()
    );
}
