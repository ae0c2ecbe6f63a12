//! What a program is for. Only one that cuts a whole roll, or a whole core, makes a unit of production.

use serde::{Serialize, Serializer};

use crate::planning::tape::label::CourseLabel;

/// What a program is for.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Purpose {
    /// It makes a whole unit.
    #[default]
    Production,
    /// Nothing is cut: the same moves with knives up and the generator off.
    DryRun {
        /// The course from which on it goes, if not from the start.
        from_course: Option<CourseLabel>,
    },
    /// The rest of a roll that another run has begun.
    Restart {
        /// The course from which on it goes.
        from_course: CourseLabel,
    },
}

impl Purpose {
    /// Every word that [`Self::word`] gives.
    pub const WORDS: [&'static str; 3] = ["production", "dry_run", "restart"];

    /// The purpose of a program that a report says these two things of.
    #[must_use]
    pub fn of(dry_run: bool, from_course: Option<CourseLabel>) -> Self {
        match (dry_run, from_course) {
            (true, from_course) => Self::DryRun { from_course },
            (false, Some(from_course)) => Self::Restart { from_course },
            (false, None) => Self::Production,
        }
    }

    /// The purpose as it is stored: a word, and ply and number of the course from which on the program goes.
    ///
    /// A word that is none of ours counts as a dry run: what is not known makes no unit of production.
    #[must_use]
    pub fn stored(word: &str, [from_ply, from_course]: [Option<i64>; 2]) -> Self {
        let number = |stored: Option<i64>| stored.and_then(|number| u32::try_from(number).ok());
        let label = |course| CourseLabel { ply: number(from_ply), number: course };
        Self::of(word != "production" && word != "restart", number(from_course).map(label))
    }

    /// Its word.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Production => "production",
            Self::DryRun { .. } => "dry_run",
            Self::Restart { .. } => "restart",
        }
    }

    /// The number of the course from which on the program goes, if not from the start.
    #[must_use]
    pub fn from_course(self) -> Option<u32> {
        self.begins().map(|course| course.number)
    }

    /// The ply of that course, on a roll of several.
    #[must_use]
    pub fn from_ply(self) -> Option<u32> {
        self.begins()?.ply
    }

    fn begins(self) -> Option<CourseLabel> {
        match self {
            Self::Production => None,
            Self::DryRun { from_course } => from_course,
            Self::Restart { from_course } => Some(from_course),
        }
    }

    /// Whether a run of it that is done makes a unit of production.
    #[must_use]
    pub fn makes_units(self) -> bool {
        self == Self::Production
    }

    /// What whoever stands at the machine must know of it; nothing for an ordinary program.
    #[must_use]
    pub fn warning(self) -> Option<String> {
        match self {
            Self::Production => None,
            Self::DryRun { from_course: None } => {
                Some("DRY RUN: nothing is cut; no unit of production".to_owned())
            }
            Self::DryRun { from_course: Some(course) } => {
                Some(format!("DRY RUN from course {course} on: nothing is cut; no unit of production"))
            }
            Self::Restart { from_course } => Some(format!(
                "GOES ON WITHIN A ROLL, from course {from_course}: for the roll that was begun; no unit of production by itself"
            )),
        }
    }
}

impl Serialize for Purpose {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.word())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_stored_is_read_back_and_only_production_makes_units() {
        let of_ply = CourseLabel { ply: Some(2), number: 7 };
        let all = [(false, None), (true, None), (true, Some(7.into())), (false, Some(of_ply))];
        let purposes = all.map(|(dry_run, from_course)| Purpose::of(dry_run, from_course));
        for purpose in purposes {
            let stored = [purpose.from_ply(), purpose.from_course()];
            assert_eq!(Purpose::stored(purpose.word(), stored.map(|number| number.map(i64::from))), purpose);
            assert!(Purpose::WORDS.contains(&purpose.word()));
            assert_eq!(purpose.warning().is_none(), purpose.makes_units(), "{purpose:?}");
        }
        assert_eq!(purposes.map(Purpose::makes_units), [true, false, false, false]);
        assert!(purposes[3].warning().unwrap().contains("from course 7 of ply 2:"));
        assert!(!Purpose::stored("something new", [None, None]).makes_units());
    }
}
