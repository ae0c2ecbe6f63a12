//! What a reader makes of a program's text: what the control would do, line by line.

/// The axis letters in the order in which [`Event::Move`] holds their positions.
pub const AXIS_LETTERS: [char; 9] = ['X', 'Y', 'Z', 'A', 'B', 'C', 'U', 'V', 'W'];

/// Positions of all nine axes: X Y Z in mm, A B C in degrees, U V W in mm.
pub type Positions = [f64; 9];

/// Something that the control does.
#[derive(Debug, Clone, PartialEq)]
pub enum Event {
    /// A straight move of all axes together.
    Move {
        /// Where they were.
        from: Positions,
        /// Where they go.
        to: Positions,
        /// How long it takes at cruising speed in s; `None` for a rapid.
        cruise_s: Option<f64>,
    },
    /// A digital output is set or cleared at once.
    Output {
        /// Its number.
        number: u32,
        /// Set or cleared.
        on: bool,
    },
    /// Nothing moves for a while.
    Dwell {
        /// How long, in s.
        seconds: f64,
    },
    /// A stop that the operator can switch on.
    OptionalStop,
    /// The end of the program.
    End,
}

/// An event and the line (from 1) of the text that caused it.
#[derive(Debug, Clone, PartialEq)]
pub struct Executed {
    /// Line number, from 1.
    pub line: usize,
    /// What is done.
    pub event: Event,
}
