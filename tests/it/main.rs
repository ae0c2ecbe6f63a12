//! The one integration binary; its modules mirror those of the crate.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod accepted;
mod cli;
mod docker;
mod golden;
mod http_jobs;
mod http_operations;
mod http_programs;
mod http_refused;
mod http_shutdown;
mod layering;
mod linuxcnc;
mod mutation;
mod nc_refused;
mod random_plies;
mod refused;
mod restart;
mod rounds;
mod section;
mod served;
mod shop_floor;
mod shop_floor_runs;
mod store;
mod worker;
