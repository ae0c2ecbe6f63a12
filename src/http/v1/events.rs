//! Following a job: Server-Sent Events from the stored ones, so that a follower can resume where it was.

use std::convert::Infallible;
use std::time::Duration;

use axum::extract::State;
use axum::http::HeaderMap;
use axum::response::sse::{Event, KeepAlive, Sse};
use axum::response::{IntoResponse, Response};
use tokio::sync::mpsc;
use tokio::time::timeout;
use tokio_stream::wrappers::ReceiverStream;

use crate::http::extract::JobPath;
use crate::http::problem::{Answer, Problem, ProblemBody, ProblemCode, of_job};
use crate::http::service::Service;
use crate::job::id::JobId;
use crate::job::moment::Moment;
use crate::store::events::JobEvent;

/// Events that a slow follower may have outstanding.
const OUTSTANDING: usize = 16;

/// Proxies close a connection that is silent for longer.
const KEEP_ALIVE: Duration = Duration::from_secs(15);

/// An announcement that was missed costs a follower so much at most.
const LOOK_AGAIN: Duration = Duration::from_secs(5);

/// Follow a job
///
/// `state` events say that the job has changed its state, `stage` events how far the planner is. Every event has
/// an `id`; a follower that comes back sends the last one as `Last-Event-ID` and gets what came after. The stream
/// ends with the job, and when the service ends.
#[utoipa::path(get, path = "/v1/jobs/{id}/events", tag = "jobs",
    params(("id" = String, Path, description = "The job"),
        ("Last-Event-ID" = Option<String>, Header, description = "The last event that is known already")),
    responses(
        (status = 200, description = "Events: id, event (state or stage), data in JSON", body = String, content_type = "text/event-stream"),
        (status = 400, description = "Last-Event-ID is not the id of an event", body = ProblemBody, content_type = "application/problem+json"),
        (status = 404, description = "There is no such job", body = ProblemBody, content_type = "application/problem+json")))]
pub async fn follow_job(
    State(service): State<Service>,
    path: JobPath,
    headers: HeaderMap,
) -> Answer<Response> {
    let after = last_event_id(&headers)?;
    service.store().job(&path.id).await.map_err(of_job)?;
    let (sender, receiver) = mpsc::channel(OUTSTANDING);
    tokio::spawn(async move { tell(&service, &path.id, after, &sender).await });
    let stream = Sse::new(ReceiverStream::new(receiver));
    Ok(stream.keep_alive(KeepAlive::new().interval(KEEP_ALIVE)).into_response())
}

fn last_event_id(headers: &HeaderMap) -> Answer<i64> {
    match headers.get("last-event-id").map(|id| id.to_str().ok().and_then(|id| id.parse().ok())) {
        None => Ok(0),
        Some(Some(id)) => Ok(id),
        Some(None) => {
            Err(Problem::new(ProblemCode::InvalidHeader).detail("Last-Event-ID is the id of an event"))
        }
    }
}

/// Tells a follower everything until the job has ended, the service ends or the follower is gone.
async fn tell(
    service: &Service,
    id: &JobId,
    mut after: i64,
    follower: &mpsc::Sender<Result<Event, Infallible>>,
) {
    let mut changes = service.store().changes().follow();
    loop {
        let Ok(job) = service.store().job(id).await else { return };
        let Ok(events) = service.store().events(id, after).await else { return };
        for event in events {
            after = event.seq;
            if follower.send(Ok(wire(event))).await.is_err() {
                return;
            }
        }
        // The job was read before its events: all events of an ended job have been told.
        if job.state.is_final() {
            return;
        }
        tokio::select! {
            _ = timeout(LOOK_AGAIN, changes.hear_of(id)) => {}
            () = service.stopped() => return,
            () = follower.closed() => return,
        }
    }
}

fn wire(event: JobEvent) -> Event {
    let at = Moment::from_unix_ms(event.at).to_string();
    let mut data = serde_json::from_str(&event.data).unwrap_or(serde_json::Value::Null);
    data["at"] = serde_json::Value::String(at);
    Event::default().id(event.seq.to_string()).event(event.kind).data(data.to_string())
}
