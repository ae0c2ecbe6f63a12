//! The plies of a job: one at the top of its input, or a list of those that lie on one roll.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use super::{COURSES, Courses, HOLES, OUTLINE, Outline, TRACKS, TapeCut, Tracks};
use crate::planning::document::shape::{Field, Shape, optional, required};
use crate::planning::finding::{Code, Finding};
use crate::planning::tape::label::PlyPlace;

/// The most plies of one roll: with a metre of tape each they fill half of what a machine feeds in one program.
pub const MOST_PLIES: usize = 100;
/// The longest name of a ply, in characters: a cell of a table that people read.
const LONGEST_NAME: usize = 64;

/// One of several plies on a roll.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ply {
    /// A name for people; it never reaches a machine program.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub name: String,
    /// Its outline.
    pub boundary: Outline,
    /// Its cut-outs.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub holes: Vec<Outline>,
    /// Its courses in laying order.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tracks: Option<Tracks>,
    /// A rule that generates the courses of a flat ply.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub courses: Option<Courses>,
}

const PLY: &[Field] = &[
    optional("name", Shape::Name { max_chars: LONGEST_NAME }),
    required("boundary", OUTLINE),
    optional("holes", HOLES),
    optional("tracks", TRACKS),
    optional("courses", COURSES),
];

/// A list of plies.
pub(super) const PLIES: Shape = Shape::Array { item: &Shape::Object(PLY), min: 1, max: MOST_PLIES };

/// A ply wherever it stands in a document. What stands in files may have been put in its place.
#[derive(Debug, Clone)]
pub struct PlyFields<'a> {
    /// Which ply it is.
    pub place: PlyPlace,
    /// Its name, which may be empty.
    pub name: &'a str,
    /// Its outline.
    pub boundary: Cow<'a, Outline>,
    /// Its cut-outs.
    pub holes: Cow<'a, [Outline]>,
    /// Its courses in laying order.
    pub tracks: Option<Cow<'a, Tracks>>,
    /// A rule that generates its courses.
    pub courses: Option<&'a Courses>,
}

impl TapeCut {
    /// Its plies in laying order; none where [`Self::refuse_mixed`] finds that there are none.
    #[must_use]
    pub fn all_plies(&self) -> Vec<PlyFields<'_>> {
        let Some(plies) = &self.plies else {
            return self.boundary.iter().map(|boundary| self.at_the_top(boundary)).collect();
        };
        let several = plies.len() > 1;
        let fields = |(index, ply)| PlyFields::of(PlyPlace::listed(index, several), ply);
        plies.iter().enumerate().map(fields).collect()
    }

    fn at_the_top<'a>(&'a self, boundary: &'a Outline) -> PlyFields<'a> {
        PlyFields {
            place: PlyPlace::default(),
            name: "",
            boundary: Cow::Borrowed(boundary),
            holes: Cow::Borrowed(&self.holes),
            tracks: self.tracks.as_ref().map(Cow::Borrowed),
            courses: self.courses.as_ref(),
        }
    }

    /// A job has either the fields of its one ply or a list of plies.
    pub fn refuse_mixed(&self, findings: &mut Vec<Finding>) {
        if self.plies.is_none() {
            if self.boundary.is_none() {
                let message = "a job needs the boundary of its ply, or a list of plies";
                findings.push(Finding::error(Code::MissingField, "/input/boundary", message));
            }
            return;
        }
        let given = [
            ("boundary", self.boundary.is_some()),
            ("holes", !self.holes.is_empty()),
            ("tracks", self.tracks.is_some()),
            ("courses", self.courses.is_some()),
        ];
        for (name, _) in given.into_iter().filter(|(_, given)| *given) {
            let message = format!("a job that lists plies has no {name} beside them: it belongs into a ply");
            findings.push(Finding::error(Code::ConflictingFields, format!("/input/{name}"), message));
        }
    }
}

impl<'a> PlyFields<'a> {
    fn of(place: PlyPlace, ply: &'a Ply) -> Self {
        Self {
            place,
            name: &ply.name,
            boundary: Cow::Borrowed(&ply.boundary),
            holes: Cow::Borrowed(&ply.holes),
            tracks: ply.tracks.as_ref().map(Cow::Borrowed),
            courses: ply.courses.as_ref(),
        }
    }
}
