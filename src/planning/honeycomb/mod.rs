//! V-shaped cutting of honeycomb with a straight ultrasonic blade on a robot (domain.md Part B).
//!
//! `blade` is the geometry of the tool: everything that the papers call theta, beta, alpha, L, d and b. `milling` and
//! `convert` are the papers' own route over a three-axis milling program (domain.md B4).

pub mod blade;
pub mod convert;
pub mod milling;
