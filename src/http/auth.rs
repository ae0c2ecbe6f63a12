//! Keys and roles: who sends a request, and whether they may do that.
//!
//! A key is `KEY_ID.SECRET` in `Authorization: Bearer`. As long as there are no keys the service listens on
//! loopback only and everybody on this machine may do everything. Which role may do what stands in one table.

use axum::extract::{MatchedPath, Request, State};
use axum::http::{HeaderMap, Method, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use subtle::ConstantTimeEq;

use super::caller::Caller;
use super::problem::{Answer, Problem, ProblemCode};
use super::service::Service;
use crate::job::id::KeyId;
use crate::job::role::Role;
use crate::store::Error;
use crate::store::keys::Key;

use Role::{Admin, Approver, Auditor, Engineer, Machine, Mes, Operator};

/// People and systems that may look at everything but the audit trail.
const LOOK: &[Role] = &[Mes, Engineer, Approver, Operator, Auditor, Admin];
/// A machine beside them, for what is its own.
const LOOK_AND_MACHINE: &[Role] = &[Mes, Engineer, Approver, Operator, Auditor, Admin, Machine];
const POST: &[Role] = &[Mes, Engineer, Admin];
const QUEUE: &[Role] = &[Mes, Operator, Admin];
const FLOOR: &[Role] = &[Operator, Admin];
const RUN: &[Role] = &[Machine, Admin];

/// Addresses that need no key: whether the service lives, and its description.
const OPEN: &[&str] =
    &["/", "/livez", "/readyz", "/version", "/openapi.json", "/docs", "/docs/", "/docs/{*rest}"];

/// Who may do what. An address that does not stand here is nobody's.
pub const RULES: &[(&str, &str, &[Role])] = &[
    ("POST", "/v1/jobs", POST),
    ("GET", "/v1/jobs", LOOK),
    ("GET", "/v1/jobs/{id}", LOOK),
    ("GET", "/v1/jobs/{id}/events", LOOK),
    ("GET", "/v1/jobs/{id}/input", LOOK),
    ("GET", "/v1/jobs/{id}/files/{name}", LOOK),
    ("GET", "/v1/jobs/{id}/report", LOOK),
    ("GET", "/v1/jobs/{id}/drawings/{name}", LOOK),
    ("PUT", "/v1/jobs/{id}/cancellation", POST),
    ("GET", "/v1/programs", LOOK),
    ("GET", "/v1/programs/{id}", LOOK),
    ("GET", "/v1/programs/{id}/content", LOOK),
    ("GET", "/v1/programs/{id}/files/{name}", LOOK),
    ("PUT", "/v1/programs/{id}/approval", &[Approver, Admin]),
    ("PUT", "/v1/programs/{id}/revocation", &[Engineer, Approver, Admin]),
    ("PUT", "/v1/programs/{id}/dry-run", POST),
    ("POST", "/v1/machines", &[Admin]),
    ("GET", "/v1/machines", LOOK),
    ("GET", "/v1/machines/{m}", LOOK_AND_MACHINE),
    ("PATCH", "/v1/machines/{m}", &[Admin]),
    ("PUT", "/v1/machines/{m}/hold", FLOOR),
    ("DELETE", "/v1/machines/{m}/hold", FLOOR),
    ("POST", "/v1/queues/{q}/entries", QUEUE),
    ("GET", "/v1/queues/{q}/entries", LOOK),
    ("GET", "/v1/queues/{q}/entries/{id}", LOOK),
    ("PATCH", "/v1/queues/{q}/entries/{id}", QUEUE),
    ("DELETE", "/v1/queues/{q}/entries/{id}", QUEUE),
    ("POST", "/v1/machines/{m}/runs", RUN),
    ("GET", "/v1/machines/{m}/next", &[Machine, Operator, Engineer, Admin]),
    ("GET", "/v1/runs", LOOK),
    ("GET", "/v1/runs/{r}", LOOK_AND_MACHINE),
    ("GET", "/v1/runs/{r}/content", RUN),
    ("PUT", "/v1/runs/{r}/receipt", RUN),
    ("PUT", "/v1/runs/{r}/start", RUN),
    ("PUT", "/v1/runs/{r}/heartbeat", RUN),
    ("PUT", "/v1/runs/{r}/result", RUN),
    ("PUT", "/v1/runs/{r}/resolution", FLOOR),
    ("GET", "/v1/audit", &[Auditor, Admin]),
    ("GET", "/metrics", LOOK),
];

/// Whether an address needs no key.
#[must_use]
pub fn is_open(path: &str) -> bool {
    OPEN.contains(&path)
}

/// Lets a request pass if its sender may do what it asks for, and notes who that is.
pub async fn admit(State(service): State<Service>, mut request: Request, next: Next) -> Response {
    // What has no pattern has no handler: the answer is that there is nothing.
    let Some(path) = request.extensions().get::<MatchedPath>().map(|path| path.as_str().to_owned()) else {
        return next.run(request).await;
    };
    if is_open(&path) {
        return next.run(request).await;
    }
    match caller(&service, request.headers())
        .await
        .and_then(|caller| allowed(caller, request.method(), &path))
    {
        Ok(caller) => {
            request.extensions_mut().insert(caller);
            next.run(request).await
        }
        Err(problem) => problem.into_response(),
    }
}

async fn caller(service: &Service, headers: &HeaderMap) -> Answer<Caller> {
    let Some(token) = bearer(headers) else {
        if service.store().has_keys().await? {
            return Err(Problem::new(ProblemCode::Unauthorized));
        }
        return Ok(Caller::local());
    };
    let key = known(service, token).await?;
    Ok(Caller { actor: key.name, role: key.role, machine: key.machine })
}

fn bearer(headers: &HeaderMap) -> Option<&str> {
    let value = headers.get(header::AUTHORIZATION)?.to_str().ok()?;
    let (scheme, token) = value.split_once(' ')?;
    scheme.eq_ignore_ascii_case("bearer").then_some(token.trim())
}

/// The key of a token. Whether the id or the secret is wrong is not told.
async fn known(service: &Service, token: &str) -> Answer<Key> {
    let unknown = || Problem::new(ProblemCode::Unauthorized);
    let (id, secret) = token.split_once('.').ok_or_else(unknown)?;
    let id: KeyId = id.parse().map_err(|_| unknown())?;
    let key = match service.store().key(&id).await {
        Ok(key) => key,
        Err(Error::NotFound) => return Err(unknown()),
        Err(other) => return Err(other.into()),
    };
    let same: bool = hash_of(secret).as_bytes().ct_eq(key.hash.as_bytes()).into();
    if same && key.revoked_at.is_none() { Ok(key) } else { Err(unknown()) }
}

/// The hash under which a secret is kept. A secret is 32 random bytes, so that no slow hash is needed.
#[must_use]
pub fn hash_of(secret: &str) -> String {
    blake3::hash(secret.as_bytes()).to_hex().to_string()
}

fn allowed(caller: Caller, method: &Method, path: &str) -> Answer<Caller> {
    // A HEAD asks for what a GET would give.
    let method = if method == Method::HEAD { "GET" } else { method.as_str() };
    let rule = RULES.iter().find(|(verb, address, _)| *verb == method && *address == path);
    match rule {
        Some((_, _, roles)) if roles.contains(&caller.role) => Ok(caller),
        // A method that the address does not take is answered as that.
        None if RULES.iter().any(|(_, address, _)| *address == path) => Ok(caller),
        _ => Err(Problem::new(ProblemCode::Forbidden)
            .detail(format!("the role of the key is {}", caller.role.word()))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_described_address_has_a_rule_and_every_rule_an_address() {
        let document: serde_json::Value = serde_json::from_str(super::super::openapi::text()).unwrap();
        let described: Vec<(String, String)> = document["paths"]
            .as_object()
            .unwrap()
            .iter()
            .flat_map(|(path, verbs)| {
                verbs
                    .as_object()
                    .unwrap()
                    .keys()
                    .map(|verb| (verb.to_uppercase(), path.clone()))
                    .collect::<Vec<_>>()
            })
            .filter(|(_, path)| !OPEN.contains(&path.as_str()))
            .collect();
        for (verb, path) in &described {
            assert!(RULES.iter().any(|(v, p, _)| v == verb && p == path), "{verb} {path} has no rule");
        }
        for (verb, path, roles) in RULES {
            let there = described.iter().any(|(v, p)| v == verb && p == path);
            assert!(there, "{verb} {path} is ruled and not there");
            assert!(roles.contains(&Admin), "{verb} {path}");
        }
    }

    #[test]
    fn roles_do_not_do_each_others_work() {
        let may = |role: Role, method: Method, path: &str| {
            let caller = Caller { actor: "a".to_owned(), role, machine: None };
            allowed(caller, &method, path).is_ok()
        };
        // Whoever plans does not approve; whoever cuts does not queue.
        assert!(!may(Mes, Method::PUT, "/v1/programs/{id}/approval"));
        assert!(!may(Engineer, Method::PUT, "/v1/programs/{id}/approval"));
        assert!(may(Approver, Method::PUT, "/v1/programs/{id}/approval"));
        assert!(!may(Approver, Method::POST, "/v1/jobs"));
        assert!(!may(Machine, Method::POST, "/v1/queues/{q}/entries"));
        assert!(!may(Machine, Method::GET, "/v1/jobs"));
        assert!(may(Machine, Method::POST, "/v1/machines/{m}/runs"));
        assert!(!may(Operator, Method::POST, "/v1/machines/{m}/runs"));
        assert!(!may(Auditor, Method::PUT, "/v1/machines/{m}/hold"));
        assert!(may(Auditor, Method::GET, "/v1/audit") && !may(Operator, Method::GET, "/v1/audit"));
        assert!(!may(Admin, Method::GET, "/v1/nothing"));
    }
}
