//! All addresses, and what surrounds every request.

use std::time::Instant;

use axum::Router;
use axum::extract::{MatchedPath, Request, State};
use axum::http::{HeaderName, HeaderValue, Method, header};
use axum::middleware::{Next, from_fn, from_fn_with_state};
use axum::response::{IntoResponse, Response};
use tower_http::catch_panic::CatchPanicLayer;
use tower_http::request_id::{MakeRequestUuid, PropagateRequestIdLayer, SetRequestIdLayer};
use tower_http::set_header::SetResponseHeaderLayer;
use tower_http::trace::TraceLayer;
use tracing::info_span;
use utoipa_axum::router::OpenApiRouter;
use utoipa_swagger_ui::{Config, SwaggerUi};

use super::problem::{Problem, ProblemCode};
use super::service::Service;
use super::{auth, operations, v1};
use crate::web;

const REQUEST_ID: HeaderName = HeaderName::from_static("x-request-id");

/// All addresses with everything around them.
pub fn router(service: Service) -> Router {
    let (routes, _) = described(utoipa::openapi::OpenApi::default()).split_for_parts();
    routes
        .merge(web::routes())
        .merge(SwaggerUi::new("/docs").config(Config::from("/openapi.json")))
        .fallback(|| async { Problem::new(ProblemCode::NotFound) })
        .method_not_allowed_fallback(|| async { Problem::new(ProblemCode::MethodNotAllowed) })
        .layer(from_fn_with_state(service.clone(), auth::admit))
        .layer(from_fn(count))
        .layer(from_fn_with_state(service.clone(), refuse_strange_hosts))
        .layer(CatchPanicLayer::custom(|_| Problem::internal("a handler panicked").into_response()))
        .layer(SetResponseHeaderLayer::if_not_present(
            header::X_CONTENT_TYPE_OPTIONS,
            HeaderValue::from_static("nosniff"),
        ))
        .layer(TraceLayer::new_for_http().make_span_with(span))
        .layer(PropagateRequestIdLayer::new(REQUEST_ID))
        .layer(SetRequestIdLayer::new(REQUEST_ID, MakeRequestUuid))
        .with_state(service)
}

/// The description of all addresses, added to what stands in `document`.
#[must_use]
pub fn document(document: utoipa::openapi::OpenApi) -> utoipa::openapi::OpenApi {
    described(document).into_openapi()
}

fn described(document: utoipa::openapi::OpenApi) -> OpenApiRouter<Service> {
    OpenApiRouter::with_openapi(document).merge(v1::routes()).merge(operations::routes())
}

fn span(request: &Request) -> tracing::Span {
    let id = request.headers().get(&REQUEST_ID).and_then(|id| id.to_str().ok()).unwrap_or_default();
    info_span!("request", id, method = %request.method(), path = request.uri().path())
}

/// Counts a request under the pattern of its address, so that ids make no labels.
async fn count(request: Request, next: Next) -> Response {
    let started = Instant::now();
    let route = request.extensions().get::<MatchedPath>().map_or("none", MatchedPath::as_str).to_owned();
    let method = method_word(request.method());
    let response = next.run(request).await;
    let status = response.status().as_str().to_owned();
    metrics::counter!("bladeplan_http_requests_total", "route" => route.clone(), "method" => method, "status" => status)
        .increment(1);
    metrics::histogram!("bladeplan_http_request_seconds", "route" => route, "method" => method)
        .record(started.elapsed().as_secs_f64());
    response
}

/// A method of a sender's own invention makes no label either.
fn method_word(method: &Method) -> &'static str {
    match *method {
        Method::GET => "GET",
        Method::HEAD => "HEAD",
        Method::POST => "POST",
        Method::PUT => "PUT",
        Method::PATCH => "PATCH",
        Method::DELETE => "DELETE",
        _ => "other",
    }
}

/// On loopback without keys, a page in a browser on this machine must not reach the service under a name of its
/// own (DNS rebinding): only the names of this machine are answered.
async fn refuse_strange_hosts(State(service): State<Service>, request: Request, next: Next) -> Response {
    let host = request.headers().get(header::HOST).and_then(|host| host.to_str().ok());
    let known = host.is_none_or(is_this_machine);
    // A proxy in front is asked under its own name; there are keys then, which a page does not have.
    let alone = service.config().listen.ip().is_loopback() && !service.config().behind_tls;
    if alone && !known {
        return Problem::new(ProblemCode::UnknownHost).into_response();
    }
    next.run(request).await
}

fn is_this_machine(host: &str) -> bool {
    let name = match host.strip_prefix('[') {
        Some(rest) => rest.split(']').next().unwrap_or_default(),
        None => host.split(':').next().unwrap_or_default(),
    };
    name.eq_ignore_ascii_case("localhost")
        || name.parse::<std::net::IpAddr>().is_ok_and(|address| address.is_loopback())
}

#[cfg(test)]
mod tests {
    use super::is_this_machine;

    #[test]
    fn only_this_machine_is_answered_on_loopback() {
        for host in ["localhost", "LOCALHOST:8080", "127.0.0.1:8080", "127.1.2.3", "[::1]:80"] {
            assert!(is_this_machine(host), "{host}");
        }
        for host in ["evil.example", "localhost.evil.example:8080", "127.0.0.1.evil.example", "10.0.0.1", ""]
        {
            assert!(!is_this_machine(host), "{host}");
        }
    }
}
