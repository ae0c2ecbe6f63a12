//! Approval and revocation of programs.

use axum::Json;
use axum::extract::State;
use serde::Deserialize;
use utoipa::ToSchema;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use super::machines::reason;
use super::wire::ProgramBody;
use crate::clock;
use crate::http::caller::Caller;
use crate::http::extract::{Body, ProgramPath};
use crate::http::problem::{Answer, ProblemBody, of_program};
use crate::http::service::Service;

/// The addresses.
#[must_use]
pub fn routes() -> OpenApiRouter<Service> {
    OpenApiRouter::new().routes(routes!(approve)).routes(routes!(revoke))
}

/// Which bytes are approved
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
struct ApprovalRequest {
    /// The SHA-256 of the content that was looked at, in lower-case hex.
    sha256: String,
}

/// Why a program is taken out of use
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
struct RevocationRequest {
    /// In words, 1 to 500 characters.
    reason: String,
}

/// Approve a program
///
/// The approval names the hash of the bytes that were looked at; machines get these bytes and no others.
#[utoipa::path(put, path = "/v1/programs/{id}/approval", tag = "programs", request_body = ApprovalRequest,
    params(("id" = String, Path, description = "The program")),
    responses(
        (status = 200, description = "The program, approved", body = ProgramBody),
        (status = 404, description = "There is none", body = ProblemBody, content_type = "application/problem+json"),
        (status = 409, description = "Another hash, or a state that does not admit it", body = ProblemBody, content_type = "application/problem+json")))]
async fn approve(
    State(service): State<Service>,
    caller: Caller,
    path: ProgramPath,
    Body(request): Body<ApprovalRequest>,
) -> Answer<Json<ProgramBody>> {
    let approved = service.store().approve(&path.id, &request.sha256, &caller.actor, clock::now()).await;
    approved.map_err(of_program)?;
    Ok(Json(service.store().program(&path.id).await.map_err(of_program)?.into()))
}

/// Take a program out of use for good
///
/// No machine is given it any more; a run that has received it cannot start.
#[utoipa::path(put, path = "/v1/programs/{id}/revocation", tag = "programs", request_body = RevocationRequest,
    params(("id" = String, Path, description = "The program")),
    responses(
        (status = 200, description = "The program, revoked", body = ProgramBody),
        (status = 404, description = "There is none", body = ProblemBody, content_type = "application/problem+json"),
        (status = 409, description = "It is quarantined", body = ProblemBody, content_type = "application/problem+json")))]
async fn revoke(
    State(service): State<Service>,
    caller: Caller,
    path: ProgramPath,
    Body(request): Body<RevocationRequest>,
) -> Answer<Json<ProgramBody>> {
    let reason = reason(&request.reason)?;
    service.store().revoke(&path.id, reason, &caller.actor, clock::now()).await.map_err(of_program)?;
    Ok(Json(service.store().program(&path.id).await.map_err(of_program)?.into()))
}
