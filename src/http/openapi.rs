//! The OpenAPI document, made from the code. A copy is checked in at `openapi/v1.json` and compared in a test.

use std::sync::LazyLock;

use serde_json::{Value, json};
use utoipa::OpenApi;

use super::router;
use crate::planning::catalogue::PROFILE;
use crate::planning::document::JOB;
use crate::planning::document::files::MOST_FILES;

#[derive(OpenApi)]
#[openapi(
    info(
        title = "bladeplan",
        description = "Plans programs for machines that cut with ultrasonic knives, and hands them to the machines.\n\n\
            A **job** is a planning request; a job that ends `succeeded` with the verdict `usable` has given a \
            **program**: immutable bytes for one kind of machine. Errors are `application/problem+json` with a \
            closed set of codes, every fault of a document at once, and the next step for a person."
    ),
    tags(
        (name = "jobs", description = "Planning requests"),
        (name = "programs", description = "What jobs gave: immutable bytes with their hash"),
        (name = "shop floor", description = "Machines, queues and runs"),
        (name = "operations", description = "For those who run the service")
    )
)]
struct Document;

/// Where handlers point for the job document; its schema is made from the shape that reads it.
pub const JOB_DOCUMENT: &str = "JobDocument";

/// Where bodies point for a machine's profile; likewise.
const MACHINE_PROFILE: &str = "MachineProfile";

static TEXT: LazyLock<String> = LazyLock::new(|| {
    let document = router::document(Document::openapi());
    let mut value = serde_json::to_value(document).expect("the document is made of texts and lists of them");
    value["components"]["schemas"][JOB_DOCUMENT] = job_document();
    value["components"]["schemas"][MACHINE_PROFILE] = machine_profile();
    refer_to_profiles(&mut value["components"]["schemas"]);
    value["components"]["securitySchemes"]["key"] = json!({"type": "http", "scheme": "bearer",
        "description": "A key that bladeplan key create has printed. Without any keys, the service on loopback asks for none."});
    value["security"] = json!([{"key": []}, {}]);
    let body = &mut value["paths"]["/v1/jobs"]["post"]["requestBody"];
    body["required"] = json!(true);
    body["content"]["multipart/form-data"] = form();
    let mut text = serde_json::to_string_pretty(&value).expect("a JSON value can be written");
    text.push('\n');
    text
});

/// The document as JSON.
#[must_use]
pub fn text() -> &'static str {
    &TEXT
}

/// A job with its files.
fn form() -> Value {
    let file = json!({"type": "string", "contentMediaType": "application/octet-stream", "description":
        "A file. Its file name, or the part's name if it has none, is the name by which the document knows it."});
    json!({
        "schema": {"type": "object", "required": ["job"],
            "properties": {"job": {"$ref": format!("#/components/schemas/{JOB_DOCUMENT}")}},
            "additionalProperties": file, "maxProperties": MOST_FILES + 1},
        "encoding": {"job": {"contentType": "application/json"}}
    })
}

fn job_document() -> Value {
    let mut schema = JOB.schema();
    schema["description"] = json!("A job. Lengths are in mm, angles in degrees; numbers must be finite.");
    schema
}

/// Bodies hold profiles as JSON of any kind; here stands which.
fn refer_to_profiles(schemas: &mut Value) {
    let profile = json!({"$ref": format!("#/components/schemas/{MACHINE_PROFILE}")});
    let or_none = json!({"oneOf": [{"type": "null"}, profile]});
    for (body, schema) in
        [("MachineRequest", &profile), ("Machine", &profile), ("MachineAmendment", &or_none)]
    {
        let property = &mut schemas[body]["properties"]["profile"];
        let description = property["description"].take();
        *property = schema.clone();
        property["description"] = description;
    }
}

fn machine_profile() -> Value {
    let mut schema = PROFILE.schema();
    schema["description"] = json!(
        "A machine: a tape cutter, or a robot cell. Lengths are in mm, angles in degrees. A robot cell has no file: \
         its arm is a built-in one by name, or stands in it in full."
    );
    schema
}
