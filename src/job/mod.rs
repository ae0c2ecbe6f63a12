//! Jobs, entries and runs: their ids, their moments in time and their life cycles. Pure: the clock, randomness and
//! the store come from outside.

pub mod entry;
pub mod id;
pub mod life;
pub mod moment;
pub mod program;
pub mod purpose;
pub mod role;
pub mod run;
pub mod waiting;
