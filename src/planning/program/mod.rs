//! Programs: machine-neutral moves, the text of each dialect, and the way back from text.
//!
//! `moves` is what a planner makes. `nc` writes it as text and reads text back. `events` is what a reader
//! makes; `replay` runs it against what was wanted. The way out and the way back share no code beyond
//! `dialect`-free data types, so that a fault of one is seen by the other.

pub mod events;
pub mod krl;
pub mod moves;
pub mod nc;
pub mod number;
pub mod replay;
pub mod robot_events;
pub mod robot_moves;
