//! The pure core: planning, programs and their verification. It knows no clock, file, network, database or thread.

pub mod attempt;
pub mod budget;
pub mod catalogue;
pub mod document;
pub mod drawing;
pub mod finding;
pub mod geometry;
pub mod honeycomb;
pub mod json;
pub mod outcome;
pub mod program;
pub mod robot;
pub mod tape;
pub mod tolerance;
pub mod units;
