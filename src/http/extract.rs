//! Paths and queries of requests; what does not fit becomes a problem, never the framework's own text.

use std::fmt::Display;
use std::str::FromStr;

use axum::body::Bytes;
use axum::extract::rejection::QueryRejection;
use axum::extract::{FromRequest, FromRequestParts, RawPathParams, Request};
use axum::http::request::Parts;
use axum::http::{HeaderMap, HeaderValue, header};
use serde::de::DeserializeOwned;

use super::problem::{Problem, ProblemCode};
use crate::config::BODY_PAUSE;
use crate::job::id::{JobId, ProgramId};
use crate::planning::document;
use crate::planning::finding::Code;

/// The query of an address.
#[derive(Debug, Clone)]
pub struct Query<T>(pub T);

impl<T: DeserializeOwned, S: Send + Sync> FromRequestParts<S> for Query<T> {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Problem> {
        let read = axum::extract::Query::<T>::from_request_parts(parts, state).await;
        read.map(|query| Self(query.0)).map_err(|rejection: QueryRejection| {
            Problem::new(ProblemCode::InvalidQuery).detail(rejection.body_text())
        })
    }
}

/// What an address names, as text or as what is made from text.
#[derive(Debug, Clone)]
pub struct Path<T>(pub T);

impl<T: DeserializeOwned + Send, S: Send + Sync> FromRequestParts<S> for Path<T> {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Problem> {
        let read = axum::extract::Path::<T>::from_request_parts(parts, state).await;
        // What is no text names nothing.
        read.map(|path| Self(path.0)).map_err(|_| Problem::new(ProblemCode::NotFound))
    }
}

/// The JSON body of a small request.
#[derive(Debug, Clone)]
pub struct Body<T>(pub T);

/// The JSON body of a small request, if there is one. Only for methods that a browser asks leave for before it sends
/// them from a page of another site: the media type is not looked at.
#[derive(Debug, Clone)]
pub struct OptionalBody<T>(pub Option<T>);

/// No body that is read this way needs more, in bytes.
const LARGEST_BODY: usize = 64 * 1024;

impl<T: DeserializeOwned, S: Send + Sync> FromRequest<S> for Body<T> {
    type Rejection = Problem;

    async fn from_request(request: Request, _state: &S) -> Result<Self, Problem> {
        refuse_other_media(request.headers())?;
        typed(&bytes_of(request).await?).map(Self)
    }
}

impl<T: DeserializeOwned, S: Send + Sync> FromRequest<S> for OptionalBody<T> {
    type Rejection = Problem;

    async fn from_request(request: Request, _state: &S) -> Result<Self, Problem> {
        let bytes = bytes_of(request).await?;
        if bytes.is_empty() { Ok(Self(None)) } else { typed(&bytes).map(|body| Self(Some(body))) }
    }
}

async fn bytes_of(request: Request) -> Result<Bytes, Problem> {
    let read =
        tokio::time::timeout(BODY_PAUSE, axum::body::to_bytes(request.into_body(), LARGEST_BODY)).await;
    match read {
        Ok(Ok(bytes)) => Ok(bytes),
        Ok(Err(_)) => {
            Err(Problem::new(ProblemCode::BodyTooLarge).detail(format!("at most {LARGEST_BODY} bytes")))
        }
        Err(_) => Err(Problem::new(ProblemCode::BodyTooSlow)),
    }
}

fn typed<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, Problem> {
    let value = document::parse(bytes).map_err(|fault| match fault.code {
        Code::InvalidNumber | Code::DuplicateField => {
            Problem::of_faults(ProblemCode::InvalidRequest, vec![fault])
        }
        _ => Problem::of_faults(ProblemCode::InvalidJson, vec![fault]),
    })?;
    document::typed(value, "").map_err(|faults| Problem::of_faults(ProblemCode::InvalidRequest, faults))
}

/// A page of another site can have a browser post text or a form, but not JSON: what is not said to be JSON is
/// refused, so that no such page queues or registers anything on a service without keys.
///
/// # Errors
/// `UnsupportedMediaType`.
pub fn refuse_other_media(headers: &HeaderMap) -> Result<(), Problem> {
    let kind = media_type(headers);
    if kind.eq_ignore_ascii_case("application/json") {
        return Ok(());
    }
    Err(Problem::new(ProblemCode::UnsupportedMediaType).detail(match kind {
        "" => "there is no Content-Type".to_owned(),
        other => format!("Content-Type is {other}"),
    }))
}

/// The Content-Type of a form with files, if the request carries one.
///
/// # Errors
/// `UnsupportedMediaType` if it is neither that nor JSON; `ForeignPage` if a page of another site has a browser send a
/// form, which it can, unlike JSON. A browser says whose page it shows; whoever sends a key is no such page.
pub fn form_type(headers: &HeaderMap) -> Result<Option<&HeaderValue>, Problem> {
    if !media_type(headers).eq_ignore_ascii_case("multipart/form-data") {
        return refuse_other_media(headers).map(|()| None);
    }
    if is_foreign(headers) && !headers.contains_key(header::AUTHORIZATION) {
        return Err(Problem::new(ProblemCode::ForeignPage));
    }
    Ok(headers.get(header::CONTENT_TYPE))
}

fn media_type(headers: &HeaderMap) -> &str {
    text(headers, "content-type").split(';').next().unwrap_or_default().trim()
}

/// Whether the page that sends this is of another origin than the address that it sends it to.
fn is_foreign(headers: &HeaderMap) -> bool {
    let (host, site) = (text(headers, "host"), text(headers, "sec-fetch-site"));
    let elsewhere = |origin: &str| origin.split_once("://").is_none_or(|(_, origin)| origin != host);
    let origin = headers.contains_key(header::ORIGIN).then(|| text(headers, "origin"));
    origin.is_some_and(elsewhere) || !["", "same-origin", "none"].contains(&site)
}

fn text<'a>(headers: &'a HeaderMap, name: &str) -> &'a str {
    headers.get(name).and_then(|value| value.to_str().ok()).unwrap_or_default()
}

/// A job id and, where the address has one, a name below it.
#[derive(Debug, Clone)]
pub struct JobPath {
    /// The job.
    pub id: JobId,
    /// The name, or an empty text.
    pub name: String,
}

/// A program id and, where the address has one, a name below it.
#[derive(Debug, Clone)]
pub struct ProgramPath {
    /// The program.
    pub id: ProgramId,
    /// The name, or an empty text.
    pub name: String,
}

impl<S: Send + Sync> FromRequestParts<S> for JobPath {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Problem> {
        let (id, name) = id_and_name(parts, state, ProblemCode::JobNotFound).await?;
        Ok(Self { id, name })
    }
}

impl<S: Send + Sync> FromRequestParts<S> for ProgramPath {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Problem> {
        let (id, name) = id_and_name(parts, state, ProblemCode::ProgramNotFound).await?;
        Ok(Self { id, name })
    }
}

/// A text that is no id names nothing: the answer is the one for an id of nothing.
async fn id_and_name<S, I>(parts: &mut Parts, state: &S, unknown: ProblemCode) -> Result<(I, String), Problem>
where
    S: Send + Sync,
    I: FromStr,
    I::Err: Display,
{
    let params = RawPathParams::from_request_parts(parts, state)
        .await
        .map_err(|_| Problem::new(ProblemCode::NotFound))?;
    let find = |name| params.iter().find(|(key, _)| *key == name).map_or("", |(_, value)| value);
    let id = find("id").parse().map_err(|error: I::Err| Problem::new(unknown).detail(error.to_string()))?;
    Ok((id, find("name").to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn asked(pairs: &[(&'static str, &'static str)]) -> Result<bool, ProblemCode> {
        let form = ("content-type", "multipart/form-data; boundary=x");
        let pairs = [form, ("host", "127.0.0.1:8080")].into_iter().chain(pairs.iter().copied());
        let headers: HeaderMap =
            pairs.map(|(name, value)| (name.parse().unwrap(), HeaderValue::from_static(value))).collect();
        form_type(&headers).map(|kind| kind.is_some()).map_err(|problem| problem.code())
    }

    #[test]
    fn a_form_is_taken_from_programs_and_from_pages_of_the_service_itself() {
        assert_eq!(asked(&[]), Ok(true));
        assert_eq!(
            asked(&[("origin", "http://127.0.0.1:8080"), ("sec-fetch-site", "same-origin")]),
            Ok(true)
        );
        let foreign = [
            ("origin", "http://evil.example"),
            ("origin", "http://127.0.0.1:9090"),
            ("origin", "http://127.0.0.1:8080.evil.example"),
            ("origin", "null"),
            ("origin", ""),
            ("sec-fetch-site", "cross-site"),
            ("sec-fetch-site", "same-site"),
        ];
        for pair in foreign {
            assert_eq!(asked(&[pair]), Err(ProblemCode::ForeignPage), "{pair:?}");
            assert_eq!(asked(&[pair, ("authorization", "Bearer x")]), Ok(true), "{pair:?}");
        }
    }
}
