//! The service over HTTP. A handler extracts, makes one call into the store, and maps the answer.

pub mod auth;
pub mod caller;
pub mod extract;
pub mod form;
pub mod intake;
pub mod openapi;
pub mod operations;
pub mod problem;
pub mod router;
pub mod server;
pub mod service;
pub mod v1;
