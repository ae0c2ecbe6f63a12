//! Taking request bodies in: bounded each, bounded together, bounded in time.

use std::sync::Arc;

use axum::body::Body;
use axum::http::{HeaderMap, HeaderValue, header};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio_stream::StreamExt;

use super::form::{Form, take_apart};
use super::problem::{Answer, Problem, ProblemCode};
use crate::config::{BODY_PAUSE, BODY_TIMEOUT};
use crate::planning::document::files::Files;

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

/// A document that was taken in, with its files. Their room is given back when they are dropped.
#[derive(Debug)]
pub struct Taken {
    /// The document, byte for byte.
    pub job: Arc<Vec<u8>>,
    /// The files that came with it.
    pub files: Arc<Files>,
    _room: Room,
}

/// Pieces of the room that one request holds.
type Room = Vec<OwnedSemaphorePermit>;

impl Intake {
    /// An intake for bodies of at most so many bytes each.
    #[must_use]
    pub fn new(most: usize) -> Self {
        let room = Arc::new(Semaphore::new((LARGEST_AT_ONCE * most).div_ceil(PIECE)));
        Self { most, room }
    }

    /// Takes a document in that is the whole body.
    ///
    /// # Errors
    /// `BodyTooLarge`, `BodyTooSlow`, `BodyIncomplete`; `Overloaded` if others fill the room.
    pub async fn take(&self, headers: &HeaderMap, body: Body) -> Answer<Taken> {
        let (bytes, room) = self.whole(headers, body).await?;
        Ok(Taken { job: Arc::new(bytes), files: Arc::default(), _room: room })
    }

    /// Takes a document and its files in, which are the parts of a form of this type. Document and files together are
    /// bounded like a document alone.
    ///
    /// # Errors
    /// As [`Self::take`]; `InvalidMultipart`.
    pub async fn take_form(&self, kind: &HeaderValue, headers: &HeaderMap, body: Body) -> Answer<Taken> {
        let (bytes, room) = self.whole(headers, body).await?;
        // While the form is taken apart it is there twice.
        let mut beside = Room::new();
        self.make_room(bytes.len(), &mut beside)?;
        let Form { job, files } = take_apart(kind, bytes).await?;
        Ok(Taken { job: Arc::new(job), files: Arc::new(files), _room: room })
    }

    async fn whole(&self, headers: &HeaderMap, body: Body) -> Answer<(Vec<u8>, Room)> {
        self.refuse_announced(headers)?;
        match tokio::time::timeout(BODY_TIMEOUT, self.collect(body)).await {
            Ok(whole) => whole,
            Err(_) => Err(Problem::new(ProblemCode::BodyTooSlow)),
        }
    }

    /// A body that is announced as too large is not read at all.
    fn refuse_announced(&self, headers: &HeaderMap) -> Answer<()> {
        let announced =
            headers.get(header::CONTENT_LENGTH).and_then(|value| value.to_str().ok()?.parse().ok());
        if announced.is_some_and(|length: usize| length > self.most) { Err(self.too_large()) } else { Ok(()) }
    }

    async fn collect(&self, body: Body) -> Answer<(Vec<u8>, Room)> {
        let mut frames = body.into_data_stream();
        let (mut bytes, mut room) = (Vec::new(), Room::new());
        loop {
            let Ok(frame) = tokio::time::timeout(BODY_PAUSE, frames.next()).await else {
                return Err(Problem::new(ProblemCode::BodyTooSlow));
            };
            match frame {
                None => return Ok((bytes, room)),
                Some(Err(_)) => return Err(Problem::new(ProblemCode::BodyIncomplete)),
                Some(Ok(more)) => {
                    self.make_room(bytes.len() + more.len(), &mut room)?;
                    bytes.extend_from_slice(&more);
                }
            }
        }
    }

    fn make_room(&self, length: usize, room: &mut Room) -> Answer<()> {
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
