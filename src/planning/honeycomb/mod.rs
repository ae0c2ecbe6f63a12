//! V-shaped cutting of honeycomb with a straight ultrasonic blade on a robot (domain.md Part B).
//!
//! `blade` is the geometry of the tool: everything that the papers call theta, beta, alpha, L, d and b.

pub mod blade;
pub mod lattice;
pub mod lattice_kind;
pub mod section;
