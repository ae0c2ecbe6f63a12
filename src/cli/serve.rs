//! `bladeplan serve`: runs the service until it is told to end.

use std::io::Write;
use std::net::SocketAddr;
use std::path::Path;
use std::process::ExitCode;
use std::time::Duration;

use tokio::net::TcpListener;
use tokio::signal::unix::{SignalKind, signal};

use crate::config::Config;
use crate::http::service::Service;
use crate::http::{router, server};
use crate::store::Store;
use crate::store::lock::FileLock;
use crate::{stopping, telemetry, worker};

/// The store is given so long to close.
const CLOSE: Duration = Duration::from_secs(3);

/// Runs the service.
#[must_use]
pub fn run(config: Config) -> ExitCode {
    match telemetry::start_log(&config).and_then(|()| block_on(config)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(words) => {
            eprintln!("bladeplan: {words}");
            ExitCode::FAILURE
        }
    }
}

fn block_on(config: Config) -> Result<(), String> {
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .enable_all()
        .build()
        .map_err(|error| format!("cannot start the runtime: {error}"))?;
    let ended = runtime.block_on(serve(config));
    // A blocking validation that is still going on does not hold the process up.
    runtime.shutdown_background();
    ended
}

async fn serve(config: Config) -> Result<(), String> {
    let metrics = telemetry::start_metrics()?;
    let _lock = FileLock::serving(&config.database).map_err(|error| error.to_string())?;
    let store = Store::open(&config.database).await.map_err(|error| error.to_string())?;
    let has_keys = store.has_keys().await.map_err(|error| error.to_string())?;
    config.check(has_keys)?;
    let listener = TcpListener::bind(config.listen)
        .await
        .map_err(|error| format!("cannot listen on {}: {error}", config.listen))?;
    let address = listener.local_addr().map_err(|error| format!("cannot tell the address: {error}"))?;
    let (stop, stopping) = stopping::channel();

    let workers = worker::start(&store, &config, &stopping).await.map_err(|error| error.to_string())?;
    greet(address, &config.database);
    let service = Service::new(store.clone(), config.clone(), metrics, stopping.clone());
    let server = tokio::spawn(server::run(listener, router::router(service), config, stopping));
    wait_for_the_end().await?;
    tracing::info!("told to end");
    stop.stop();
    workers.end().await;
    let _ = server.await;
    // A request that was cut off may hold a connection still; what is committed is on the disk in any case.
    let _ = tokio::time::timeout(CLOSE, store.close()).await;
    tracing::info!("ended");
    Ok(())
}

async fn wait_for_the_end() -> Result<(), String> {
    let listen = |kind| signal(kind).map_err(|error| format!("cannot listen for signals: {error}"));
    let mut terminate = listen(SignalKind::terminate())?;
    let mut interrupt = listen(SignalKind::interrupt())?;
    tokio::select! {
        _ = terminate.recv() => {}
        _ = interrupt.recv() => {}
    }
    Ok(())
}

/// Says what runs and what to type next.
fn greet(address: SocketAddr, database: &Path) {
    let (version, database) = (env!("CARGO_PKG_VERSION"), database.display());
    let words = format!(
        "bladeplan {version} listens on http://{address} and keeps everything in {database}
Next, in another terminal:
  curl -i http://{address}/v1/jobs -H 'Content-Type: application/json' --data-binary @JOB.json
  curl 'http://{address}/v1/jobs/JOB_ID?wait=30'
  curl -O -J http://{address}/v1/programs/PROGRAM_ID/content
or open http://{address}/ in a browser. Ctrl-C ends it.
"
    );
    // Whoever started the service may have stopped reading; it serves all the same.
    let mut out = std::io::stdout().lock();
    let _ = out.write_all(words.as_bytes()).and_then(|()| out.flush());
}
