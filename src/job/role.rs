//! Roles: what a key may be used for.

use serde::{Deserialize, Serialize};

/// What a key may be used for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// Posts jobs and entries, watches them.
    Mes,
    /// Posts jobs, looks at everything, revokes programs.
    Engineer,
    /// Approves and revokes programs.
    Approver,
    /// Holds machines, changes queues, resolves runs.
    Operator,
    /// Fetches and reports its own runs.
    Machine,
    /// Reads everything, and the audit trail.
    Auditor,
    /// Registers machines; may do all that the others may.
    Admin,
}

impl Role {
    /// Every role.
    pub const ALL: [Self; 7] = [
        Self::Mes,
        Self::Engineer,
        Self::Approver,
        Self::Operator,
        Self::Machine,
        Self::Auditor,
        Self::Admin,
    ];

    /// The role as it is stored.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Mes => "mes",
            Self::Engineer => "engineer",
            Self::Approver => "approver",
            Self::Operator => "operator",
            Self::Machine => "machine",
            Self::Auditor => "auditor",
            Self::Admin => "admin",
        }
    }

    /// The role of a word.
    #[must_use]
    pub fn of(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|role| role.word() == word)
    }
}
