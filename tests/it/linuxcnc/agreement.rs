//! Whether LinuxCNC's interpreter and our own reader make the same of a program.

use bladeplan::planning::program::events::{AXIS_LETTERS, Event, Executed, Positions};

use super::{Call, CanonEvent, FeedMode};

/// Positions agree to this many mm or degrees: what the product promises of its programs.
const POSITION_TOLERANCE: f64 = 1e-4;
/// Durations agree to this part of themselves: both sides compute in doubles from the same printed feed.
const DURATION_TOLERANCE: f64 = 1e-9;
/// The interpreter's positions go through inches and back, which may change a length by this (mm or degrees) at
/// 200 m of tape, and the duration of a feed of that length in proportion.
const LENGTH_NOISE: f64 = 1e-9;
/// Below this (mm or degrees) nothing has moved; LinuxCNC draws the same line in its own feed calculation.
const STANDSTILL: f64 = 1e-7;

/// Says whether both do the same in the same order, from the same lines: end positions of all nine axes to
/// 1e-4 mm and degrees, rapid or feed, durations, outputs, dwells, optional stops and the end. Moves that go
/// nowhere are left out on both sides.
///
/// # Errors
/// The first difference in words, or what the interpreter makes of the program that no knife program does.
pub fn compare(canon: &[CanonEvent], ours: &[Executed]) -> Result<(), String> {
    let theirs = executed(canon)?;
    let theirs: Vec<&Executed> = theirs.iter().filter(|e| does_something(e)).collect();
    let ours: Vec<&Executed> = ours.iter().filter(|e| does_something(e)).collect();
    for (theirs, ours) in theirs.iter().zip(&ours) {
        same(theirs, ours).map_err(|why| format!("{why}: LinuxCNC has {theirs:?}, we have {ours:?}"))?;
    }
    let (more, than) = (theirs.get(ours.len()), ours.get(theirs.len()));
    match (more, than) {
        (Some(extra), _) => Err(format!("only LinuxCNC has {extra:?}")),
        (_, Some(extra)) => Err(format!("only we have {extra:?}")),
        (None, None) => Ok(()),
    }
}

fn does_something(executed: &Executed) -> bool {
    match &executed.event {
        Event::Move { from, to, .. } => moved(from, to, 0..9),
        _ => true,
    }
}

fn same(theirs: &Executed, ours: &Executed) -> Result<(), String> {
    if theirs.line != ours.line {
        return Err(format!("lines {} and {} differ", theirs.line, ours.line));
    }
    same_event(&theirs.event, &ours.event).map_err(|why| format!("line {}: {why}", theirs.line))
}

fn same_event(theirs: &Event, ours: &Event) -> Result<(), String> {
    match (theirs, ours) {
        (
            Event::Move { from, to, cruise_s },
            Event::Move { from: our_from, to: our_to, cruise_s: our_cruise_s },
        ) => {
            same_positions("starts", from, our_from)?;
            same_positions("ends", to, our_to)?;
            let noise = LENGTH_NOISE / length(from, to);
            same_duration(*cruise_s, *our_cruise_s, noise)
        }
        (Event::Dwell { seconds }, Event::Dwell { seconds: ours }) => {
            same_duration(Some(*seconds), Some(*ours), 0.0)
        }
        _ if theirs == ours => Ok(()),
        _ => Err("something else is done".to_owned()),
    }
}

fn same_positions(what: &str, theirs: &Positions, ours: &Positions) -> Result<(), String> {
    for ((letter, theirs), ours) in AXIS_LETTERS.iter().zip(theirs).zip(ours) {
        let near = (theirs - ours).abs() <= POSITION_TOLERANCE;
        if !near {
            return Err(format!("{letter} {what} at {theirs} or at {ours}"));
        }
    }
    Ok(())
}

/// `noise` is what the interpreter may be off by, as a part of the duration.
fn same_duration(theirs: Option<f64>, ours: Option<f64>, noise: f64) -> Result<(), String> {
    match (theirs, ours) {
        (None, None) => Ok(()),
        (Some(theirs), Some(ours)) if (theirs - ours).abs() <= (DURATION_TOLERANCE + noise) * theirs => {
            Ok(())
        }
        (Some(theirs), Some(ours)) => Err(format!("it lasts {theirs} s or {ours} s")),
        (Some(_), None) => Err("it is a feed, not a rapid".to_owned()),
        (None, Some(_)) => Err("it is a rapid, not a feed".to_owned()),
    }
}

/// The interpreter's calls in the form that our reader uses.
fn executed(canon: &[CanonEvent]) -> Result<Vec<Executed>, String> {
    let mut position = [0.0; 9];
    let mut waiting = Vec::new();
    let mut done = Vec::new();
    for CanonEvent { line, call } in canon {
        let event = match call {
            Call::Output { number, on, with_motion: true } => {
                waiting.push(Executed { line: *line, event: Event::Output { number: *number, on: *on } });
                continue;
            }
            Call::Rapid { to } => Event::Move { from: position, to: *to, cruise_s: None },
            Call::Feed { to, rate, mode } => {
                let cruise_s =
                    cruise_s(&position, to, *rate, *mode).map_err(|why| format!("line {line}: {why}"))?;
                Event::Move { from: position, to: *to, cruise_s: Some(cruise_s) }
            }
            Call::Output { number, on, with_motion: false } => Event::Output { number: *number, on: *on },
            Call::Dwell { seconds } => Event::Dwell { seconds: *seconds },
            Call::OptionalStop => Event::OptionalStop,
            Call::End => Event::End,
            Call::Foreign(name) => {
                return Err(format!("line {line}: {name} has no place in a knife program"));
            }
        };
        if let Event::Move { to, .. } = &event {
            // M62 and M63 take place when the next move starts.
            done.append(&mut waiting);
            position = *to;
        }
        done.push(Executed { line: *line, event });
    }
    match waiting.first() {
        None => Ok(done),
        Some(Executed { line, .. }) => {
            Err(format!("line {line}: the output waits for a move that never comes"))
        }
    }
}

/// How long a feed lasts, in s.
fn cruise_s(from: &Positions, to: &Positions, rate: f64, mode: FeedMode) -> Result<f64, String> {
    match mode {
        FeedMode::PerRevolution => Err("a feed per revolution has no duration".to_owned()),
        FeedMode::InverseTime | FeedMode::PerMinute => Ok(60.0 * length(from, to) / rate),
    }
}

/// The length (mm or degrees) that a feed counts along: in X Y Z, where none of them moves in U V W, and where none
/// of those moves in A B C (LinuxCNC, "Machining Center", feed rate).
fn length(from: &Positions, to: &Positions) -> f64 {
    let group = [0..3, 6..9, 3..6].into_iter().find(|group| moved(from, to, group.clone()));
    group.map_or(0.0, |group| group.map(|i| (to[i] - from[i]).powi(2)).sum::<f64>().sqrt())
}

fn moved(from: &Positions, to: &Positions, mut axes: std::ops::Range<usize>) -> bool {
    axes.any(|i| (to[i] - from[i]).abs() > STANDSTILL)
}

#[cfg(test)]
mod tests {
    use rstest::rstest;

    use super::super::{at, fixture, interpret, knives};
    use super::*;

    fn did(line: usize, event: Event) -> Executed {
        Executed { line, event }
    }

    fn output(number: u32, on: bool) -> Event {
        Event::Output { number, on }
    }

    fn dwell(seconds: f64) -> Event {
        Event::Dwell { seconds }
    }

    fn feed(from: Positions, to: Positions, cruise_s: f64) -> Event {
        Event::Move { from, to, cruise_s: Some(cruise_s) }
    }

    const ORIGIN: Positions = [0.0; 9];

    /// What `course.ngc` does, worked out by hand.
    fn course() -> Vec<Executed> {
        let vertex = knives(100.0, 0.0, 0.0, -45.0, 45.0);
        let edges = knives(175.0, -75.0, 75.0, -45.0, 45.0);
        let parked = knives(175.0, 0.0, 0.0, -45.0, 45.0);
        vec![
            did(7, output(2, true)),
            did(8, feed(ORIGIN, vertex, 0.75)),
            did(9, output(0, true)),
            did(10, output(1, true)),
            did(11, dwell(0.05)),
            did(12, feed(vertex, edges, 7.5)),
            did(13, output(0, false)),
            did(14, output(1, false)),
            did(15, dwell(0.05)),
            did(17, Event::Move { from: edges, to: parked, cruise_s: None }),
            did(18, Event::OptionalStop),
            did(19, output(2, false)),
            did(20, Event::End),
        ]
    }

    #[test]
    fn a_course_is_what_it_was_worked_out_to_be() {
        compare(&interpret(&fixture("course")).unwrap(), &course()).unwrap();
    }

    #[rstest]
    #[case::position(|c: &mut Vec<Executed>| shift(&mut c[1], 1.01e-4), "line 8: U ends at")]
    #[case::line(|c: &mut Vec<Executed>| c[3].line = 11, "lines 10 and 11 differ")]
    #[case::output_number(|c: &mut Vec<Executed>| c[2].event = output(1, true), "line 9: something else")]
    #[case::output_state(|c: &mut Vec<Executed>| c[2].event = output(0, false), "line 9: something else")]
    #[case::dwell(|c: &mut Vec<Executed>| c[4].event = dwell(0.0501), "line 11: it lasts 0.05 s or 0.0501 s")]
    #[case::no_dwell(|c: &mut Vec<Executed>| { c.remove(4); }, "lines 11 and 12 differ")]
    #[case::speed(|c: &mut Vec<Executed>| hurry(&mut c[5], Some(7.500_1)), "line 12: it lasts")]
    #[case::rapid(|c: &mut Vec<Executed>| hurry(&mut c[5], None), "line 12: it is a feed, not a rapid")]
    #[case::feed(|c: &mut Vec<Executed>| hurry(&mut c[9], Some(1.0)), "line 17: it is a rapid, not a feed")]
    #[case::no_end(|c: &mut Vec<Executed>| { c.pop(); }, "only LinuxCNC has")]
    #[case::more(|c: &mut Vec<Executed>| c.push(did(21, Event::End)), "only we have")]
    fn any_difference_is_told(#[case] change: fn(&mut Vec<Executed>), #[case] told: &str) {
        let canon = interpret(&fixture("course")).unwrap();
        let mut ours = course();
        change(&mut ours);
        let difference = compare(&canon, &ours).unwrap_err();
        assert!(difference.starts_with(told), "{difference}");
    }

    fn shift(executed: &mut Executed, by: f64) {
        if let Event::Move { to, .. } = &mut executed.event {
            to[6] += by;
        }
    }

    fn hurry(executed: &mut Executed, wish: Option<f64>) {
        if let Event::Move { cruise_s, .. } = &mut executed.event {
            *cruise_s = wish;
        }
    }

    #[test]
    fn nearness_is_near_enough_and_standstill_does_not_count() {
        let canon = interpret(&fixture("course")).unwrap();
        let mut ours = course();
        shift(&mut ours[1], 0.99e-4);
        ours.insert(2, did(8, feed(ORIGIN, ORIGIN, 3.0)));
        compare(&canon, &ours).unwrap();
    }

    #[test]
    fn not_a_number_agrees_with_nothing() {
        let canon = interpret(&fixture("course")).unwrap();
        let mut ours = course();
        shift(&mut ours[1], f64::NAN);
        assert!(compare(&canon, &ours).is_err());
    }

    #[test]
    fn an_output_with_motion_takes_place_with_the_next_move() {
        let canon = interpret("G21\nM62 P1\nG4 P1\nG0 U1\nM2\n").unwrap();
        let to = knives(1.0, 0.0, 0.0, 0.0, 0.0);
        let rapid = Event::Move { from: ORIGIN, to, cruise_s: None };
        let ours = [did(3, dwell(1.0)), did(2, output(1, true)), did(4, rapid), did(5, Event::End)];
        compare(&canon, &ours).unwrap();
    }

    #[test]
    fn an_output_that_waits_for_ever_is_no_agreement() {
        let canon = interpret("G21\nM62 P1\nM2\n").unwrap();
        let told = compare(&canon, &[did(2, output(1, true)), did(3, Event::End)]).unwrap_err();
        assert_eq!(told, "line 2: the output waits for a move that never comes");
    }

    #[test]
    fn what_no_knife_program_does_is_no_agreement() {
        let told = compare(&[at(1, Call::Foreign("spindle_clockwise".to_owned()))], &[]).unwrap_err();
        assert_eq!(told, "line 1: spindle_clockwise has no place in a knife program");
    }

    /// LinuxCNC never feeds slower than 0.1 mm/min under G93, so that a turn of a blade over next to no tape would
    /// be faster than programmed: half a minute's turn takes 18 s here.
    #[test]
    fn an_inverse_time_feed_below_the_least_feed_is_seen() {
        let canon = interpret("G21 G93\nG1 U0.03 A90 F2\nM2\n").unwrap();
        let ours = [did(2, feed(ORIGIN, knives(0.03, 0.0, 0.0, 90.0, 0.0), 30.0)), did(3, Event::End)];
        let told = compare(&canon, &ours).unwrap_err();
        assert!(told.starts_with("line 2: it lasts 1") && told.contains(" s or 30 s"), "{told}");
    }
}
