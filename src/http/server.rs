//! Connections: how many, how slow, and how they end.
//!
//! `axum::serve` has no limit for the time in which a header arrives and waits for ever for open streams when it
//! ends; both are done here.

use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::server::graceful::GracefulShutdown;
use hyper_util::service::TowerToHyperService;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};

use crate::config::{ANSWER_PAUSE, Config, DRAIN, HEADER_TIMEOUT};
use crate::stopping::Stopping;

/// After an error of `accept`, such as too many open files, it is tried again so much later.
const ACCEPT_PAUSE: Duration = Duration::from_millis(100);

/// Serves until `stopping` says so, and then until the open requests have ended or their time is up.
pub async fn run(listener: TcpListener, router: Router, config: Config, stopping: Stopping) {
    let graceful = GracefulShutdown::new();
    let places = Arc::new(Semaphore::new(config.max_connections as usize));
    loop {
        let next = tokio::select! {
            next = accept(&listener, &places) => next,
            () = stopping.stopped() => break,
        };
        if let Some((stream, place)) = next {
            serve(stream, place, &router, &graceful);
        }
    }
    drop(listener);
    if tokio::time::timeout(DRAIN, graceful.shutdown()).await.is_err() {
        tracing::warn!("some requests did not end in time and were cut off");
    }
}

/// Waits for a free place first, so that a connection too many waits in the system's queue.
async fn accept(
    listener: &TcpListener,
    places: &Arc<Semaphore>,
) -> Option<(TcpStream, OwnedSemaphorePermit)> {
    let place = Arc::clone(places).acquire_owned().await.ok()?;
    match listener.accept().await {
        Ok((stream, _)) => Some((stream, place)),
        Err(error) => {
            tracing::warn!(%error, "a connection could not be accepted");
            tokio::time::sleep(ACCEPT_PAUSE).await;
            None
        }
    }
}

fn serve(stream: TcpStream, place: OwnedSemaphorePermit, router: &Router, graceful: &GracefulShutdown) {
    // Small answers go out at once.
    let _ = stream.set_nodelay(true);
    // A client that is gone, or does not take its answer, must not hold its place for ever.
    let pause = u32::try_from(ANSWER_PAUSE.as_millis()).unwrap_or(u32::MAX);
    let _ = rustix::net::sockopt::set_tcp_user_timeout(&stream, pause);
    let connection = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(HEADER_TIMEOUT)
        .serve_connection(TokioIo::new(stream), TowerToHyperService::new(router.clone()));
    let watched = graceful.watch(connection);
    tokio::spawn(async move {
        if let Err(error) = watched.await {
            tracing::debug!(%error, "a connection ended early");
        }
        drop(place);
    });
}
