//! Typed ids that sort by the moment at which they were made.
//!
//! An id is a prefix that names its type, and a UUID of version 7 in hex: `job_0198c2a4...`. Whoever makes one
//! brings the moment and ten random bytes.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};
use uuid::{Builder, Uuid};

use super::moment::Moment;

/// The random part of an id.
pub type Entropy = [u8; 10];

/// A text that is not an id of the type asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("an id of this type is {prefix}_ and 32 hexadecimal digits")]
pub struct NotAnId {
    prefix: &'static str,
}

macro_rules! typed_id {
    ($(#[$doc:meta])* $name:ident, $prefix:literal) => {
        $(#[$doc])*
        #[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
        #[serde(try_from = "String", into = "String")]
        pub struct $name(String);

        impl $name {
            /// Makes an id that sorts by `now`.
            #[must_use]
            pub fn new(now: Moment, entropy: &Entropy) -> Self {
                Self(format!(concat!($prefix, "_{}"), sortable(now, entropy).simple()))
            }

            /// The id as text.
            #[must_use]
            pub fn as_str(&self) -> &str {
                &self.0
            }
        }

        impl FromStr for $name {
            type Err = NotAnId;

            fn from_str(text: &str) -> Result<Self, NotAnId> {
                match text.strip_prefix(concat!($prefix, "_")) {
                    Some(digits) if is_simple_uuid(digits) => Ok(Self(text.to_owned())),
                    _ => Err(NotAnId { prefix: $prefix }),
                }
            }
        }

        impl TryFrom<String> for $name {
            type Error = NotAnId;

            fn try_from(text: String) -> Result<Self, NotAnId> {
                text.parse()
            }
        }

        impl From<$name> for String {
            fn from(id: $name) -> Self {
                id.0
            }
        }

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(&self.0)
            }
        }
    };
}

typed_id!(
    /// The id of a job.
    JobId, "job"
);
typed_id!(
    /// The id of a program.
    ProgramId, "prg"
);
typed_id!(
    /// The id of one worker of one process.
    WorkerId, "wrk"
);

typed_id!(
    /// The id of a key.
    KeyId, "key"
);
typed_id!(
    /// The id of an entry of a queue.
    EntryId, "ent"
);
typed_id!(
    /// The id of a run.
    RunId, "run"
);

fn sortable(now: Moment, entropy: &Entropy) -> Uuid {
    // Before 1970 there are no jobs.
    let millis = u64::try_from(now.unix_ms()).unwrap_or(0);
    Builder::from_unix_timestamp_millis(millis, entropy).into_uuid()
}

fn is_simple_uuid(digits: &str) -> bool {
    digits.len() == 32 && digits.bytes().all(|b| b.is_ascii_digit() || (b'a'..=b'f').contains(&b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_sort_by_their_moment() {
        let early = JobId::new(Moment::from_unix_ms(1_000), &[0xff; 10]);
        let late = JobId::new(Moment::from_unix_ms(1_001), &[0; 10]);
        assert!(early < late, "{early} {late}");
    }

    #[test]
    fn an_id_is_read_back_and_another_type_is_not() {
        let id = JobId::new(Moment::from_unix_ms(5), &[7; 10]);
        assert_eq!(id.as_str().parse::<JobId>(), Ok(id.clone()));
        assert!(id.as_str().parse::<ProgramId>().is_err());
        assert!("job_".parse::<JobId>().is_err());
        assert!("job_../../etc/passwd".parse::<JobId>().is_err());
        assert!(id.as_str().to_uppercase().parse::<JobId>().is_err());
    }
}
