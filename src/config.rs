//! What can be set when the service starts, with its limits and their reasons.

use std::net::SocketAddr;
use std::path::PathBuf;
use std::time::Duration;

/// The settings of `bladeplan serve`.
#[derive(Debug, Clone, clap::Args)]
pub struct Config {
    /// Address and port to listen on; port 0 takes a free one
    #[arg(long, value_name = "ADDRESS", default_value = "127.0.0.1:8080")]
    pub listen: SocketAddr,

    /// The database file; it is made if it is not there
    #[arg(long, value_name = "FILE", default_value = "./bladeplan.db")]
    pub database: PathBuf,

    /// How many jobs are planned at the same time [default: one less than the processors]
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u16).range(0..=256))]
    pub workers: Option<u16>,

    /// The largest request body, in MiB
    // 1 000 000 boundary points and 400 courses of 400 points are about 61 MB.
    #[arg(long, value_name = "MIB", default_value_t = 128, value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub max_body_mib: u32,

    /// The most jobs that may wait; a post beyond is told to come back later
    #[arg(long, value_name = "COUNT", default_value_t = 10_000)]
    pub max_queued: u32,

    /// The most connections that are open at the same time
    #[arg(long, value_name = "COUNT", default_value_t = 512, value_parser = clap::value_parser!(u32).range(1..=65_536))]
    pub max_connections: u32,

    /// The most memory of one planning attempt, in MiB of address space
    #[arg(long, value_name = "MIB", default_value_t = 4096, value_parser = clap::value_parser!(u32).range(16..))]
    pub attempt_memory_mib: u32,

    /// The most processor time of one planning attempt, in seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 600, value_parser = clap::value_parser!(u32).range(1..))]
    pub attempt_cpu_s: u32,

    /// The most time of one planning attempt by the clock on the wall, in seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 900, value_parser = clap::value_parser!(u32).range(1..))]
    pub attempt_wall_s: u32,

    /// Every planning attempt stops before it begins, until it is sent SIGCONT: for a debugger, and for the tests of
    /// what becomes of an attempt
    #[arg(long, hide = true)]
    pub pause_attempts: bool,

    /// A machine that was not heard of for so long makes its run suspect, in seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 120, value_parser = clap::value_parser!(u32).range(1..=86_400))]
    pub lease_s: u32,

    /// A proxy in front terminates TLS; without it the service listens on loopback only
    #[arg(long)]
    pub behind_tls: bool,

    /// What is logged: off, error, warn, info, debug, or a filter such as bladeplan=debug,warn
    #[arg(long, value_name = "FILTER", default_value = "info")]
    pub log: String,

    /// How it is logged
    #[arg(long, value_enum, default_value_t = LogFormat::Text)]
    pub log_format: LogFormat,
}

/// How log lines are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum LogFormat {
    /// For people.
    Text,
    /// One JSON object a line.
    Json,
}

/// A running worker says so this often.
pub const HEARTBEAT: Duration = Duration::from_secs(5);

/// A worker that was silent so long is lost: six heartbeats missed.
pub const SILENCE: Duration = Duration::from_secs(30);

/// Runs whose machine has fallen silent are looked for this often.
pub const LOOK_FOR_SILENCE: Duration = Duration::from_secs(2);

/// A request's header must have arrived by then.
pub const HEADER_TIMEOUT: Duration = Duration::from_secs(10);

/// A request's body must not stand still for longer.
pub const BODY_PAUSE: Duration = Duration::from_secs(10);

/// A request's body must have arrived by then, at 1 MB/s for the largest.
pub const BODY_TIMEOUT: Duration = Duration::from_secs(150);

/// What is sent to a client must be taken by it within this time, some of it at least.
pub const ANSWER_PAUSE: Duration = Duration::from_secs(30);

/// Requests that are still going on when the service is told to end get so long; the promise is 30 s for all.
pub const DRAIN: Duration = Duration::from_secs(15);

/// The longest `?wait=`, in seconds: below the idle limit of common proxies.
pub const MOST_WAIT_S: u32 = 50;

impl Config {
    /// Refuses what would not be safe, knowing whether there are keys.
    ///
    /// # Errors
    /// In words, what is wrong and what to do.
    pub fn check(&self, has_keys: bool) -> Result<(), String> {
        if self.listen.ip().is_loopback() && !self.behind_tls {
            return Ok(());
        }
        let (listen, port, database) = (self.listen, self.listen.port(), self.database.display());
        if !has_keys {
            return Err(format!(
                "refusing to listen on {listen} without keys: everybody in that network could post jobs and fetch \
                 programs. Make one first: bladeplan key create --role admin --name NAME --database {database}; \
                 or listen on loopback only: --listen 127.0.0.1:{port}"
            ));
        }
        if !self.behind_tls {
            return Err(format!(
                "refusing to listen on {listen} in plain HTTP: keys would cross the network readable by everybody. \
                 Put a TLS proxy in front and say so with --behind-tls, or listen on loopback only: \
                 --listen 127.0.0.1:{port}"
            ));
        }
        Ok(())
    }

    /// How long a machine may be silent, in milliseconds.
    #[must_use]
    pub fn lease_ms(&self) -> i64 {
        i64::from(self.lease_s) * 1000
    }

    /// The largest request body in bytes.
    #[must_use]
    pub fn max_body_bytes(&self) -> usize {
        self.max_body_mib as usize * 1024 * 1024
    }

    /// How many jobs are planned at the same time.
    #[must_use]
    pub fn worker_count(&self) -> usize {
        self.workers.map_or_else(default_workers, usize::from)
    }
}

/// One processor is left to the API.
fn default_workers() -> usize {
    std::thread::available_parallelism().map_or(1, |count| count.get().saturating_sub(1).max(1))
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::Config;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        config: Config,
    }

    fn config(listen: &str) -> Config {
        Line::parse_from(["serve", "--listen", listen]).config
    }

    #[test]
    fn beyond_loopback_nothing_starts_without_keys_and_tls() {
        for listen in ["0.0.0.0:8080", "[::]:8080", "192.168.1.5:80"] {
            let words = config(listen).check(false).unwrap_err();
            assert!(words.contains("127.0.0.1") && words.contains("key create"), "{words}");
            let words = config(listen).check(true).unwrap_err();
            assert!(words.contains("--behind-tls"), "{words}");
            assert!(Config { behind_tls: true, ..config(listen) }.check(true).is_ok());
            assert!(Config { behind_tls: true, ..config(listen) }.check(false).is_err());
        }
        // Whoever is behind a proxy hears the whole network, wherever it listens.
        assert!(Config { behind_tls: true, ..config("127.0.0.1:0") }.check(false).is_err());
        assert!(Config { behind_tls: true, ..config("127.0.0.1:0") }.check(true).is_ok());
        assert!(config("127.0.0.1:0").check(false).is_ok());
        assert!(config("[::1]:0").check(false).is_ok());
    }
}
