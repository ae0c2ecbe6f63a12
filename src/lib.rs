//! bladeplan: plans, checks and serves programs for machines that cut with ultrasonic knives.
//!
//! Modules in reading order: the pure core first, then the shell around it.

pub mod planning;

pub mod job;

pub mod clock;
pub mod config;
pub mod stopping;
pub mod telemetry;

pub mod store;

pub mod worker;

pub mod http;
pub mod web;

pub mod cli;
