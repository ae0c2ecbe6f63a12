//! Outlines in (u, v) of one course, in mm.

use crate::planning::geometry::Point2;

/// A point of an outline in (u, v) of a course, or `None` if it belongs to another part of the mould.
pub type Developed = Option<Point2>;

/// The outlines of a ply in (u, v) of one course.
#[derive(Debug, Clone, PartialEq)]
pub struct DevelopedPly {
    /// The boundary.
    pub boundary: DevelopedLoop,
    /// The cut-outs.
    pub holes: Vec<DevelopedLoop>,
    /// The course, where the mould is curved or the course is.
    pub on_mould: Option<OnMould>,
}

/// A course on a curved mould, or one that is curved itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OnMould {
    /// Length of the course in mm.
    pub length_mm: f64,
    /// How far, about and at the most, places may be off because the points of the course are so far apart, in mm.
    pub between_mm: f64,
}

/// An outline in (u, v) of one course. A stretch of it that is not within the tape may be one place that is not known.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct DevelopedLoop {
    /// Its points in order.
    pub places: Vec<Developed>,
    /// Where each of them stands in the outline.
    pub indices: Vec<usize>,
}

impl DevelopedLoop {
    /// A point, by its place in the outline.
    pub fn push(&mut self, index: usize, place: Developed) {
        self.places.push(place);
        self.indices.push(index);
    }

    /// What comes next is not within the tape.
    pub fn leave_out(&mut self) {
        self.push(self.indices.last().copied().unwrap_or(0), None);
    }
}

impl From<Vec<Developed>> for DevelopedLoop {
    /// An outline of which every point stands for itself.
    fn from(places: Vec<Developed>) -> Self {
        let indices = (0..places.len()).collect();
        Self { places, indices }
    }
}
