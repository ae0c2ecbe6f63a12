//! KUKA robot programs (KRL, KSS 8): the way out as text, and the way back from text.
//!
//! `emit` writes a [`super::robot_moves::RobotProgram`], `read` makes [`super::robot_events::RobotEvent`]s of a text.
//! They share nothing but those types and [`crate::planning::geometry::frame::Frame`].

pub mod emit;
pub mod read;
pub mod stem;
