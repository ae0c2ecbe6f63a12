//! The life of a program: where it stands, and where it can go from there.
//!
//! ```text
//! draft -> approved -> superseded
//!   |         |-----> revoked
//!   '---------'         (quarantined from anywhere, when its bytes do not fit their hash any more)
//! ```

/// Where a program stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Standing {
    /// Planned and replayed; nobody has approved it.
    Draft,
    /// A named person has approved its bytes; machines may get it.
    Approved,
    /// Another program has taken its place.
    Superseded,
    /// Taken out of use for good.
    Revoked,
    /// Its stored bytes do not fit their hash any more.
    Quarantined,
}

/// A transition that the standing does not admit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the program is {}", .0.word())]
pub struct NotFrom(pub Standing);

impl Standing {
    /// Every standing.
    pub const ALL: [Self; 5] =
        [Self::Draft, Self::Approved, Self::Superseded, Self::Revoked, Self::Quarantined];

    /// The standing as it is stored.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Draft => "draft",
            Self::Approved => "approved",
            Self::Superseded => "superseded",
            Self::Revoked => "revoked",
            Self::Quarantined => "quarantined",
        }
    }

    /// The standing of a word.
    #[must_use]
    pub fn of(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|standing| standing.word() == word)
    }

    /// A person approves it. Approving it twice is once.
    ///
    /// # Errors
    /// `NotFrom` if it is superseded, revoked or quarantined.
    pub fn approve(self) -> Result<Self, NotFrom> {
        match self {
            Self::Draft | Self::Approved => Ok(Self::Approved),
            other => Err(NotFrom(other)),
        }
    }

    /// A person takes it out of use. Revoking it twice is once.
    ///
    /// # Errors
    /// `NotFrom` if it is quarantined: that says more.
    pub fn revoke(self) -> Result<Self, NotFrom> {
        match self {
            Self::Quarantined => Err(NotFrom(self)),
            _ => Ok(Self::Revoked),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Standing::{Approved, Draft, Quarantined, Revoked, Superseded};
    use super::*;

    #[test]
    fn only_a_draft_becomes_approved_and_nothing_comes_back() {
        assert_eq!(
            Standing::ALL.map(|s| s.approve().ok()),
            [Some(Approved), Some(Approved), None, None, None]
        );
        let revoked = [Draft, Approved, Superseded, Revoked].map(|s| s.revoke());
        assert_eq!(revoked, [Ok(Revoked); 4]);
        assert_eq!(Quarantined.revoke(), Err(NotFrom(Quarantined)));
    }
}
