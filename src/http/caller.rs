//! Who sends a request, as [`super::auth`] has found out.

use axum::extract::FromRequestParts;
use axum::http::request::Parts;

use super::problem::{Answer, Problem, ProblemCode};
use super::service::Service;
use crate::job::role::Role;

/// Whoever sends a request.
#[derive(Debug, Clone)]
pub struct Caller {
    /// The name that audit rows carry.
    pub actor: String,
    /// What they may do.
    pub role: Role,
    /// The machine that the key belongs to, if the role is that of a machine.
    pub machine: Option<String>,
}

impl Caller {
    /// Without keys the service listens on loopback only, and everybody on this machine is the same person.
    #[must_use]
    pub fn local() -> Self {
        Self { actor: "local".to_owned(), role: Role::Admin, machine: None }
    }

    /// Refuses a machine that speaks for another one.
    ///
    /// # Errors
    /// `Forbidden`.
    pub fn speaks_for(&self, machine: &str) -> Answer<()> {
        match &self.machine {
            Some(own) if own != machine => {
                Err(Problem::new(ProblemCode::Forbidden).detail(format!("the key is that of machine {own}")))
            }
            _ => Ok(()),
        }
    }
}

impl FromRequestParts<Service> for Caller {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, _service: &Service) -> Result<Self, Problem> {
        parts.extensions.get::<Self>().cloned().ok_or_else(|| Problem::new(ProblemCode::Unauthorized))
    }
}
