//! Robot arms and what they can do: data, kinematics, and the check of a path (domain.md B5).
//!
//! `arm` is the data, `kinematics` its closed form, `travel` a straight move as the wrist sees it, `branch` the eight
//! ways to stand and a path followed on one of them. `check` judges a path, `base_search` looks for a better place of
//! the part, `curve` keeps the joints over time.

pub mod arm;
pub mod base_search;
pub mod branch;
pub mod check;
pub mod curve;
pub mod fault;
pub mod kinematics;
pub mod survey;
pub mod travel;

#[cfg(test)]
mod tests;
