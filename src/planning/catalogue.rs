//! The machines that a job can name: tape cutters and robot cells, built in or registered.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::document::shape::Shape;
use super::finding::{Code, Finding};
use super::honeycomb::{cell, wire::Cell, wire::ROBOT_CELL};
use super::tape::machine;
use super::tape::wire::{MachineProfile, TAPE_CUTTER};

/// A machine's profile. Its field `kind` says which of them it is.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Profile {
    /// A platform that cuts tape.
    TapeCutter(Box<MachineProfile>),
    /// A robot that cuts cores.
    RobotCell(Box<Cell>),
}

/// The shape of a machine's profile.
pub const PROFILE: Shape =
    Shape::Tagged { tag: "kind", variants: &[("tape-cutter", TAPE_CUTTER), ("robot-cell", ROBOT_CELL)] };

/// What a machine can do: jobs of one kind never run on a machine of the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Cuts plies from tape.
    TapeCutter,
    /// Cuts cores.
    RobotCell,
}

impl Kind {
    /// The kind in words, to be read after "is" or "needs".
    fn words(self) -> &'static str {
        match self {
            Self::TapeCutter => "a tape cutter",
            Self::RobotCell => "a robot cell",
        }
    }
}

impl Profile {
    /// What the machine can do.
    #[must_use]
    pub fn kind(&self) -> Kind {
        match self {
            Self::TapeCutter(_) => Kind::TapeCutter,
            Self::RobotCell(_) => Kind::RobotCell,
        }
    }

    /// The machine's name. Only a cell that stands in a job may have none; [`PROFILE`] asks for it.
    #[must_use]
    pub fn name(&self) -> &str {
        match self {
            Self::TapeCutter(profile) => &profile.name,
            Self::RobotCell(cell) => cell.name.as_deref().unwrap_or_default(),
        }
    }

    /// The SHA-256 of the profile without its name: machines with the same one can run each other's programs, others
    /// must not.
    #[must_use]
    pub fn fingerprint(&self) -> String {
        match self {
            Self::TapeCutter(profile) => machine::fingerprint(profile),
            Self::RobotCell(cell) => cell::fingerprint(cell),
        }
    }

    /// Checks what a shape cannot say.
    ///
    /// # Errors
    /// Every fault of the profile, with pointers below `at`.
    pub fn check(&self, at: &str) -> Result<(), Vec<Finding>> {
        match self {
            Self::TapeCutter(profile) => machine::check(profile, at).map(|_| ()),
            Self::RobotCell(cell) => cell::check_profile(cell, at),
        }
    }
}

/// The machines that a job can name.
#[derive(Debug, Clone)]
pub struct Catalogue {
    built_in: BTreeMap<String, Profile>,
    registered: BTreeMap<String, Profile>,
}

impl Catalogue {
    /// The built-in profiles. No robot cell is among them: its frames are measured where it stands, so that a program
    /// for a cell of everybody's would be one for nobody's.
    #[must_use]
    pub fn built_in() -> Self {
        let lab = machine::two_cutter_lab();
        let built_in = BTreeMap::from([(lab.name.clone(), Profile::TapeCutter(Box::new(lab)))]);
        Self { built_in, registered: BTreeMap::new() }
    }

    /// Adds a registered profile; one of the same name is replaced.
    pub fn insert(&mut self, profile: Profile) {
        self.registered.insert(profile.name().to_owned(), profile);
    }

    /// The profile of that name.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<&Profile> {
        self.registered(name).or_else(|| self.built_in.get(name))
    }

    /// The profile of that name, if it is one that was registered and so may change while its name stays.
    #[must_use]
    pub fn registered(&self, name: &str) -> Option<&Profile> {
        self.registered.get(name)
    }

    /// The tape cutter of that name.
    ///
    /// # Errors
    /// `UnknownMachine` with the names that are known, or `WrongMachine`, at `at`.
    pub fn tape_cutter(&self, name: &str, at: &str) -> Result<&MachineProfile, Finding> {
        match self.get(name) {
            Some(Profile::TapeCutter(profile)) => Ok(profile),
            other => Err(self.refusal(other, Kind::TapeCutter, at)),
        }
    }

    /// The robot cell of that name.
    ///
    /// # Errors
    /// As [`Self::tape_cutter`].
    pub fn robot_cell(&self, name: &str, at: &str) -> Result<&Cell, Finding> {
        match self.get(name) {
            Some(Profile::RobotCell(cell)) => Ok(cell),
            other => Err(self.refusal(other, Kind::RobotCell, at)),
        }
    }

    fn refusal(&self, found: Option<&Profile>, wanted: Kind, at: &str) -> Finding {
        let Some(found) = found else { return self.unknown(wanted, at) };
        let (is, needs) = (found.kind().words(), wanted.words());
        let message = format!("the machine of that name is {is}; this job needs {needs}");
        Finding::error(Code::WrongMachine, at, message)
    }

    fn unknown(&self, kind: Kind, at: &str) -> Finding {
        let known: BTreeMap<_, _> = self.built_in.iter().chain(&self.registered).collect();
        let known = known.into_iter().filter(|(_, profile)| profile.kind() == kind);
        let names: Vec<&str> = known.map(|(name, _)| name.as_str()).collect();
        let known = if names.is_empty() {
            format!("{} has to be registered first, or stands in the job in full", kind.words())
        } else {
            format!("known: {}", names.join(", "))
        };
        Finding::error(Code::UnknownMachine, at, format!("no machine of that name; {known}"))
    }
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use super::*;

    fn cell(name: &str) -> Value {
        let frame = json!({"x_mm": 0, "y_mm": 0, "z_mm": 300, "a_deg": 0, "b_deg": 0, "c_deg": 0});
        json!({"name": name, "kind": "robot-cell", "robot": "kr210-r3100-2", "tool_frame": frame,
            "base_frame": frame, "home_deg": [0, -90, 90, 0, 0, 0]})
    }

    fn read(value: Value) -> Profile {
        assert_eq!(PROFILE.faults(&value, ""), []);
        serde_json::from_value(value).unwrap()
    }

    fn lab() -> Value {
        serde_json::to_value(Catalogue::built_in().get("two-cutter-lab").unwrap()).unwrap()
    }

    #[test]
    fn a_profile_is_what_its_kind_says_and_is_written_as_it_was_read() {
        let tape = read(lab());
        assert_eq!((tape.kind(), tape.name()), (Kind::TapeCutter, "two-cutter-lab"));
        assert_eq!(serde_json::to_value(&tape).unwrap(), lab());
        let robot = read(cell("k-1"));
        assert_eq!((robot.kind(), robot.name()), (Kind::RobotCell, "k-1"));
        let again = read(serde_json::to_value(&robot).unwrap());
        assert_eq!(again.fingerprint(), robot.fingerprint());
    }

    #[test]
    fn a_registered_machine_needs_its_name_and_a_kind_that_is_known() {
        let faults = |value: Value| -> Vec<(Code, String)> {
            PROFILE.faults(&value, "/profile").into_iter().map(|fault| (fault.code, fault.at)).collect()
        };
        let mut nameless = cell("k-1");
        nameless.as_object_mut().unwrap().remove("name");
        assert_eq!(faults(nameless), [(Code::MissingField, "/profile/name".to_owned())]);
        let mut kindless = cell("k-1");
        kindless.as_object_mut().unwrap().remove("kind");
        assert_eq!(faults(kindless), [(Code::MissingField, "/profile/kind".to_owned())]);
        let mut other = cell("k-1");
        other["kind"] = json!("gantry");
        assert_eq!(faults(other), [(Code::UnknownValue, "/profile/kind".to_owned())]);
    }

    #[test]
    fn a_machine_is_found_by_name_and_kind_and_else_it_is_said_what_is_known() {
        let mut catalogue = Catalogue::built_in();
        let refused = |catalogue: &Catalogue, name: &str, kind| {
            let fault = match kind {
                Kind::TapeCutter => catalogue.tape_cutter(name, "/x").unwrap_err(),
                Kind::RobotCell => catalogue.robot_cell(name, "/x").unwrap_err(),
            };
            assert_eq!(fault.at, "/x");
            (fault.code, fault.message)
        };
        let (code, words) = refused(&catalogue, "k-1", Kind::RobotCell);
        assert_eq!((code, words.contains("registered first")), (Code::UnknownMachine, true), "{words}");
        catalogue.insert(read(cell("k-1")));
        assert_eq!(catalogue.robot_cell("k-1", "").unwrap().name.as_deref(), Some("k-1"));
        assert!(catalogue.registered("k-1").is_some() && catalogue.registered("two-cutter-lab").is_none());
        let (code, words) = refused(&catalogue, "k-2", Kind::RobotCell);
        assert_eq!((code, words.as_str()), (Code::UnknownMachine, "no machine of that name; known: k-1"));
        let (_, words) = refused(&catalogue, "k-2", Kind::TapeCutter);
        assert_eq!(words, "no machine of that name; known: two-cutter-lab");
        assert_eq!(refused(&catalogue, "k-1", Kind::TapeCutter).0, Code::WrongMachine);
        let (code, words) = refused(&catalogue, "two-cutter-lab", Kind::RobotCell);
        assert_eq!(code, Code::WrongMachine);
        assert_eq!(words, "the machine of that name is a tape cutter; this job needs a robot cell");
    }
}
