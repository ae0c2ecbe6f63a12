//! The one integration binary; its modules mirror those of the crate.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod accepted;
mod cli;
mod craft;
mod docker;
mod files;
mod golden;
mod honeycomb;
mod honeycomb_optimum;
mod http_files;
mod http_honeycomb;
mod http_jobs;
mod http_operations;
mod http_programs;
mod http_refused;
mod http_shutdown;
mod krl_convert;
mod krl_emitted;
mod krl_read;
mod krl_refused;
mod krl_vim;
mod layering;
mod linuxcnc;
mod mutation;
mod nc_refused;
mod oddities;
mod oracles;
mod profiles;
mod random_plies;
mod refused;
mod restart;
mod robot_cells;
mod roll;
mod rounds;
mod section;
mod served;
mod shop_floor;
mod shop_floor_runs;
mod simplify;
mod sinumerik;
mod spool;
mod store;
mod trace;
mod worker;
