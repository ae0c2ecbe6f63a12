//! What is counted but not kept.

use super::{Result, Store};

/// Posts that were refused, by code.
pub const REFUSED_POSTS: &str = "refused_posts";

impl Store {
    /// Counts one of `name` with `label`.
    ///
    /// # Errors
    /// `Database`.
    pub async fn count(&self, name: &str, label: &str) -> Result<()> {
        let mut tx = self.write().await?;
        sqlx::query(
            "INSERT INTO counters (name, label, value) VALUES ($1, $2, 1)
             ON CONFLICT (name, label) DO UPDATE SET value = counters.value + 1",
        )
        .bind(name)
        .bind(label)
        .execute(&mut *tx)
        .await?;
        Ok(tx.commit().await?)
    }

    /// The counts of `name`, by label.
    ///
    /// # Errors
    /// `Database`.
    pub async fn counts(&self, name: &str) -> Result<Vec<(String, i64)>> {
        Ok(sqlx::query_as("SELECT label, value FROM counters WHERE name = $1 ORDER BY label")
            .bind(name)
            .fetch_all(&self.readers)
            .await?)
    }
}
