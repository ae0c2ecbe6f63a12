//! Taking request bodies in: bounded each, bounded together, bounded in time.

use std::sync::Arc;

use axum::body::Body;
use axum::http::{HeaderMap, header};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio_stream::StreamExt;

use super::problem::{Answer, Problem, ProblemCode};
use crate::config::{BODY_PAUSE, BODY_TIMEOUT};

/// All bodies that are being taken in or checked together are at most so many of the largest ones.
const LARGEST_AT_ONCE: usize = 4;

/// Room is handed out in pieces of this size, in bytes.
const PIECE: usize = 64 * 1024;

/// The room for request bodies.
#[derive(Debug)]
pub struct Intake {
    most: usize,
    room: Arc<Semaphore>,
}

/// A body that was taken in. Its room is given back when it is dropped.
#[derive(Debug)]
pub struct Taken {
    /// The bytes.
    pub bytes: Arc<Vec<u8>>,
    _room: Vec<OwnedSemaphorePermit>,
}

impl Intake {
    /// An intake for bodies of at most so many bytes each.
    #[must_use]
    pub fn new(most: usize) -> Self {
        let room = Arc::new(Semaphore::new((LARGEST_AT_ONCE * most).div_ceil(PIECE)));
        Self { most, room }
    }

    /// Takes a body in.
    ///
    /// # Errors
    /// `BodyTooLarge`, `BodyTooSlow`, `BodyIncomplete`; `Overloaded` if others fill the room.
    pub async fn take(&self, headers: &HeaderMap, body: Body) -> Answer<Taken> {
        self.refuse_announced(headers)?;
        match tokio::time::timeout(BODY_TIMEOUT, self.collect(body)).await {
            Ok(taken) => taken,
            Err(_) => Err(Problem::new(ProblemCode::BodyTooSlow)),
        }
    }

    /// A body that is announced as too large is not read at all.
    fn refuse_announced(&self, headers: &HeaderMap) -> Answer<()> {
        let announced =
            headers.get(header::CONTENT_LENGTH).and_then(|value| value.to_str().ok()?.parse().ok());
        if announced.is_some_and(|length: usize| length > self.most) { Err(self.too_large()) } else { Ok(()) }
    }

    async fn collect(&self, body: Body) -> Answer<Taken> {
        let mut frames = body.into_data_stream();
        let (mut bytes, mut room) = (Vec::new(), Vec::new());
        loop {
            let Ok(frame) = tokio::time::timeout(BODY_PAUSE, frames.next()).await else {
                return Err(Problem::new(ProblemCode::BodyTooSlow));
            };
            match frame {
                None => return Ok(Taken { bytes: Arc::new(bytes), _room: room }),
                Some(Err(_)) => return Err(Problem::new(ProblemCode::BodyIncomplete)),
                Some(Ok(more)) => {
                    self.make_room(bytes.len() + more.len(), &mut room)?;
                    bytes.extend_from_slice(&more);
                }
            }
        }
    }

    fn make_room(&self, length: usize, room: &mut Vec<OwnedSemaphorePermit>) -> Answer<()> {
        if length > self.most {
            return Err(self.too_large());
        }
        while room.len() * PIECE < length {
            let piece = Arc::clone(&self.room).try_acquire_owned();
            room.push(piece.map_err(|_| Problem::new(ProblemCode::Overloaded))?);
        }
        Ok(())
    }

    fn too_large(&self) -> Problem {
        let detail = format!("at most {} bytes are taken", self.most);
        Problem::new(ProblemCode::BodyTooLarge).detail(detail)
    }
}
