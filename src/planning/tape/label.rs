//! What a course is called, and where it stands in the job document.

use std::fmt;

/// What a course is called everywhere: in findings, programs, traces, reports and drawings. A course's number is one of
/// its kind in its ply only, so where a roll holds several plies the ply belongs to the name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub struct CourseLabel {
    /// Which ply of the job it is of, from 1; none where the job has one ply only.
    pub ply: Option<u32>,
    /// Its number.
    pub number: u32,
}

impl CourseLabel {
    /// For where there is little room: `5`, or `2/5` for course 5 of ply 2. (`5.2` is the second piece of course 5.)
    #[must_use]
    pub fn short(self) -> String {
        let ply = self.ply.map_or(String::new(), |ply| format!("{ply}/"));
        format!("{ply}{}", self.number)
    }
}

impl From<u32> for CourseLabel {
    /// The course of that number, of a job of one ply.
    fn from(number: u32) -> Self {
        Self { ply: None, number }
    }
}

/// To be read after "course": `5`, or `5 of ply 2`. Letters, digits and blanks: what a comment of any control holds.
impl fmt::Display for CourseLabel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.ply {
            None => write!(f, "{}", self.number),
            Some(ply) => write!(f, "{} of ply {ply}", self.number),
        }
    }
}

/// Which ply of a job; its `Display` is the JSON pointer below which its fields stand.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PlyPlace {
    /// Its number, from 1 in laying order; none where the job has one ply only.
    pub number: Option<u32>,
    /// Its index, where the job lists plies.
    pub index: Option<usize>,
}

impl PlyPlace {
    /// The ply at an index of a list, of several or of one.
    #[must_use]
    pub fn listed(index: usize, several: bool) -> Self {
        Self { number: several.then_some(index as u32 + 1), index: Some(index) }
    }

    /// What the course of that number is called.
    #[must_use]
    pub fn label(self, number: u32) -> CourseLabel {
        CourseLabel { ply: self.number, number }
    }

    /// Where the course at an index stands.
    #[must_use]
    pub fn course(self, index: usize) -> CoursePlace {
        CoursePlace { ply: self, index }
    }
}

impl fmt::Display for PlyPlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.index {
            None => f.write_str("/input"),
            Some(index) => write!(f, "/input/plies/{index}"),
        }
    }
}

/// Where a course stands in the job document; its `Display` is the JSON pointer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct CoursePlace {
    /// Its ply.
    pub ply: PlyPlace,
    /// Its index among the courses of its ply.
    pub index: usize,
}

impl fmt::Display for CoursePlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/tracks/{}", self.ply, self.index)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ply_is_named_only_where_there_are_several() {
        let (one, two) = (CourseLabel::from(5), CourseLabel { ply: Some(2), number: 5 });
        assert_eq!((one.to_string(), one.short()), ("5".to_owned(), "5".to_owned()));
        assert_eq!((two.to_string(), two.short()), ("5 of ply 2".to_owned(), "2/5".to_owned()));
        assert_ne!(two, CourseLabel { ply: Some(1), number: 5 });
        assert_eq!((PlyPlace::default().label(5), PlyPlace::listed(1, true).label(5)), (one, two));
        assert_eq!(PlyPlace::listed(0, false).label(5), one);
    }

    #[test]
    fn a_listed_ply_stands_at_its_place_even_if_it_is_the_only_one() {
        let pointer = |ply: PlyPlace| ply.course(3).to_string();
        assert_eq!(pointer(PlyPlace::default()), "/input/tracks/3");
        assert_eq!(pointer(PlyPlace::listed(0, false)), "/input/plies/0/tracks/3");
        assert_eq!(pointer(PlyPlace::listed(1, true)), "/input/plies/1/tracks/3");
    }
}
