//! The only places where the wall clock and the system's randomness are read. Everything else takes them as
//! arguments.

use std::time::{SystemTime, UNIX_EPOCH};

use crate::job::id::Entropy;
use crate::job::moment::Moment;

/// The moment that the system's clock shows.
#[must_use]
pub fn now() -> Moment {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    Moment::from_unix_ms(i64::try_from(since.as_millis()).unwrap_or(i64::MAX))
}

/// Ten fresh random bytes for an id.
#[must_use]
pub fn entropy() -> Entropy {
    rand::random()
}

/// 32 fresh random bytes in hex, for the secret of a key.
#[must_use]
pub fn secret() -> String {
    let bytes: [u8; 32] = rand::random();
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
