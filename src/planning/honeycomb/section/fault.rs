//! What a section refuses, with the place and the limit.

/// An input that no section can be made of, or a cut that no blade makes.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum SectionFault {
    /// A number that is not finite or lies outside its limits.
    #[error("{what} is {value}; it must lie from {low} to {high}")]
    OutOfRange {
        /// What it is, with its unit.
        what: &'static str,
        /// What it was given as.
        value: f64,
        /// The smallest value that is taken.
        low: f64,
        /// The largest value that is taken.
        high: f64,
    },
    /// A profile that is no line.
    #[error("the profile has {count} points; it needs at least 2")]
    TooFewPoints {
        /// How many it has.
        count: usize,
    },
    /// A profile whose x falls.
    #[error("point {index} of the profile: x falls from {before} to {x}; list the points from left to right")]
    Falls {
        /// Which point, from 0.
        index: usize,
        /// x of the point before, in mm.
        before: f64,
        /// Its own x, in mm.
        x: f64,
    },
    /// A profile that leaves the blank below or above, or a point of it that is not finite.
    #[error("point {index} of the profile: ({x}, {z}) is not in the blank, whose z goes from 0 to {height}")]
    OutsideBlank {
        /// Which point, from 0.
        index: usize,
        /// Its x, in mm.
        x: f64,
        /// Its z, in mm.
        z: f64,
        /// The height of the blank, in mm.
        height: f64,
    },
    /// A lattice with more tips than any part has.
    #[error("the lattice has about {count} places for tips on this blank; at most {most} are planned")]
    TooManyTips {
        /// How many it has, about.
        count: f64,
        /// How many are planned.
        most: f64,
    },
    /// A profile that does not go from one side of the blank to the other.
    #[error("the profile goes from x = {first} to {last}; the blank goes from 0 to {width}")]
    Span {
        /// x of its first point, in mm.
        first: f64,
        /// x of its last point, in mm.
        last: f64,
        /// The width of the blank, in mm.
        width: f64,
    },
}

/// The value, if it is finite and lies within its limits.
pub(in crate::planning::honeycomb) fn within(
    what: &'static str,
    value: f64,
    low: f64,
    high: f64,
) -> Result<f64, SectionFault> {
    // A NaN lies in no range.
    if (low..=high).contains(&value) {
        Ok(value)
    } else {
        Err(SectionFault::OutOfRange { what, value, low, high })
    }
}
