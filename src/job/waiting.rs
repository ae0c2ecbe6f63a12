//! What an entry waits for, beside its turn: why it is given to no machine, and what a person does next.

use serde::Serialize;

use super::id::ProgramId;
use super::program::Standing;

/// What an entry waits for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Wanted {
    /// That its program is approved.
    Approval,
    /// Another program: its own will never be given out.
    Replacement,
    /// A machine with the profile that the program was planned for.
    Machine,
    /// That a hold is taken back.
    Release,
    /// That a person says what became of a suspect run.
    Resolution,
}

impl Wanted {
    /// Its word.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Approval => "approval",
            Self::Replacement => "replacement",
            Self::Machine => "machine",
            Self::Release => "release",
            Self::Resolution => "resolution",
        }
    }
}

/// What an entry waits for, and the same in a sentence that says what to do next.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WaitingFor {
    /// What.
    pub code: Wanted,
    /// The same for people.
    pub detail: String,
}

/// A machine that takes from the entry's queue.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Taker {
    /// Its name.
    pub name: String,
    /// Whether it has the profile that the program was planned for.
    pub fits: bool,
    /// Who holds it, and why.
    pub hold: Option<(String, String)>,
    /// Its run, if that is suspect.
    pub suspect: Option<String>,
}

/// Of so many machines the names are said.
const MOST_NAMES: usize = 5;

/// What an entry waits for that has units to give out. `None`: nothing but its turn.
///
/// What can never be made good comes first, then what takes a new plan, then what somebody can do at once.
#[must_use]
pub fn waiting_for(program: &ProgramId, standing: Standing, takers: &[Taker]) -> Option<WaitingFor> {
    let fitting: Vec<&Taker> = takers.iter().filter(|taker| taker.fits).collect();
    let (code, detail) = match standing {
        Standing::Superseded | Standing::Revoked | Standing::Quarantined => {
            (Wanted::Replacement, dead(standing))
        }
        _ if fitting.is_empty() => (Wanted::Machine, no_machine(takers)),
        Standing::Draft => (Wanted::Approval, unapproved(program)),
        Standing::Approved => blocked(&fitting)?,
    };
    Some(WaitingFor { code, detail })
}

fn dead(standing: Standing) -> String {
    let word = standing.word();
    format!(
        "The program is {word} and is never given out: cancel this entry, plan the job again and queue its new program."
    )
}

fn no_machine(takers: &[Taker]) -> String {
    if takers.is_empty() {
        return "No machine takes from this queue any more: put the program into the queue of a machine, or a machine into this pool."
            .to_owned();
    }
    let mut names: Vec<&str> = takers.iter().take(MOST_NAMES).map(|taker| taker.name.as_str()).collect();
    if takers.len() > MOST_NAMES {
        names.push("...");
    }
    format!(
        "The program was planned for another profile than that of {}: plan the job again for this machine, or queue the program for a machine with its profile.",
        names.join(", ")
    )
}

fn unapproved(program: &ProgramId) -> String {
    format!(
        "The program is a draft: an approver looks at it and names its hash, PUT /v1/programs/{program}/approval."
    )
}

/// Why none of the machines is given anything; `None` if one of them is.
fn blocked(fitting: &[&Taker]) -> Option<(Wanted, String)> {
    if fitting.iter().any(|taker| taker.hold.is_none() && taker.suspect.is_none()) {
        return None;
    }
    // Whoever is asked to look at a machine must know its run; a hold is the lesser matter.
    fitting.iter().find_map(|taker| suspect(taker)).or_else(|| fitting.iter().find_map(|taker| held(taker)))
}

fn suspect(taker: &Taker) -> Option<(Wanted, String)> {
    let (name, run) = (&taker.name, taker.suspect.as_ref()?);
    let detail = format!(
        "The machine {name} was silent past its lease in {run}: look at the machine and say what became of the unit, PUT /v1/runs/{run}/resolution."
    );
    Some((Wanted::Resolution, detail))
}

fn held(taker: &Taker) -> Option<(Wanted, String)> {
    let (name, (by, reason)) = (&taker.name, taker.hold.as_ref()?);
    let detail = format!(
        "The machine {name} is held by {by} ({reason}): an operator takes the hold back, DELETE /v1/machines/{name}/hold."
    );
    Some((Wanted::Release, detail))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::moment::Moment;

    fn taker(name: &str, fits: bool) -> Taker {
        Taker { name: name.to_owned(), fits, hold: None, suspect: None }
    }

    fn held_taker(name: &str) -> Taker {
        Taker { hold: Some(("anna".to_owned(), "blade".to_owned())), ..taker(name, true) }
    }

    fn suspect_taker(name: &str) -> Taker {
        Taker { suspect: Some("run_1".to_owned()), ..taker(name, true) }
    }

    fn found(standing: Standing, takers: &[Taker]) -> Option<(Wanted, String)> {
        let program = ProgramId::new(Moment::from_unix_ms(0), &[0; 10]);
        waiting_for(&program, standing, takers).map(|found| (found.code, found.detail))
    }

    #[test]
    fn each_obstacle_is_said_and_the_one_that_nobody_can_clear_comes_first() {
        let code = |standing, takers: &[Taker]| found(standing, takers).map(|(code, _)| code);
        let (fits, other) = (taker("a", true), taker("b", false));
        assert_eq!(code(Standing::Approved, std::slice::from_ref(&fits)), None);
        assert_eq!(code(Standing::Approved, &[other.clone(), fits.clone()]), None);
        assert_eq!(code(Standing::Draft, &[fits]), Some(Wanted::Approval));
        assert_eq!(code(Standing::Draft, std::slice::from_ref(&other)), Some(Wanted::Machine));
        assert_eq!(code(Standing::Approved, &[]), Some(Wanted::Machine));
        for dead in [Standing::Superseded, Standing::Revoked, Standing::Quarantined] {
            let (code, words) = found(dead, std::slice::from_ref(&other)).unwrap();
            assert!(code == Wanted::Replacement && words.contains(dead.word()), "{words}");
        }
    }

    #[test]
    fn a_pool_waits_only_when_every_fitting_machine_of_it_is_out_of_use() {
        let code = |takers: &[Taker]| found(Standing::Approved, takers);
        assert_eq!(code(&[held_taker("a"), taker("b", true)]), None);
        let (wanted, words) = code(&[held_taker("a"), taker("b", false)]).unwrap();
        assert!(wanted == Wanted::Release && words.contains("held by anna (blade)"), "{words}");
        let (wanted, words) = code(&[held_taker("a"), suspect_taker("b")]).unwrap();
        assert!(wanted == Wanted::Resolution && words.contains("PUT /v1/runs/run_1/resolution"), "{words}");
    }
}
