//! Whether a program is the dry run of another: the same moves, and nothing ever switched on.

use super::Executed;
use super::faults::Faults;
use crate::planning::finding::{Code, Finding};
use crate::planning::program::events::Event;

/// Compares a dry run with the program that it is the dry run of. `name` is that of the dry run.
///
/// Anything switched on is a `KnifeState`; a move, a dwell, a stop or an end that differs is a `Deviation`, said once.
#[must_use]
pub fn compare(name: &str, dry: &[Executed], wet: &[Executed]) -> Vec<Finding> {
    let mut faults = Faults::new(name);
    for executed in dry {
        if let Event::Output { number, on: true } = executed.event {
            faults.at_line(Code::KnifeState, executed.line, || {
                format!("a dry run switches output {number} on")
            });
        }
    }
    let (dry, wet) = (moves(dry), moves(wet));
    let same = dry.iter().zip(&wet).take_while(|(one, other)| one.event == other.event).count();
    if same < dry.len().max(wet.len()) {
        let line = dry.get(same).or(dry.last()).map_or(1, |executed| executed.line);
        faults.at_line(Code::Deviation, line, || {
            "here the dry run moves otherwise than its program".to_owned()
        });
    }
    faults.finish()
}

fn moves(events: &[Executed]) -> Vec<&Executed> {
    events.iter().filter(|executed| !matches!(executed.event, Event::Output { .. })).collect()
}
