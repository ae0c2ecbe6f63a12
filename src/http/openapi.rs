//! The OpenAPI document, made from the code. A copy is checked in at `openapi/v1.json` and compared in a test.

use std::sync::LazyLock;

use serde_json::{Map, Value, json};
use utoipa::OpenApi;

use super::problem::MEDIA_TYPE;
use super::{auth, router};
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

/// The schema of every error.
const PROBLEM: &str = "#/components/schemas/Problem";

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
    declare_common_answers(&mut value["paths"]);
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

/// What any address that asks for a key may answer, declared once for all of them: every such request looks a key up in
/// the store.
const COMMON: [(&str, &str); 3] = [
    ("401", "The request carries no key that is known"),
    ("403", "The role of the key may not do this"),
    ("503", "The service is ending, or has no room at the moment; Retry-After says when to ask again"),
];

/// Declares the answers of [`COMMON`]. One that is declared already for a reason of its own keeps that beside.
fn declare_common_answers(paths: &mut Value) {
    let guarded = paths.as_object_mut().into_iter().flatten().filter(|(path, _)| !auth::is_open(path));
    for operation in guarded.filter_map(|(_, verbs)| verbs.as_object_mut()).flat_map(Map::values_mut) {
        for (status, words) in COMMON {
            let answer = &mut operation["responses"][status];
            if answer.is_null() {
                *answer = json!({"content": {MEDIA_TYPE: {"schema": {"$ref": PROBLEM}}}});
            }
            let own = answer["description"].as_str().map(|own| format!("{own}. {words}"));
            answer["description"] = json!(own.unwrap_or_else(|| words.to_owned()));
        }
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_address_that_asks_for_a_key_declares_what_it_answers_without_one() {
        let document: Value = serde_json::from_str(text()).unwrap();
        let mut guarded = 0;
        for (path, verbs) in document["paths"].as_object().unwrap() {
            for (verb, operation) in verbs.as_object().unwrap() {
                let answers = operation["responses"].as_object().unwrap();
                let open = auth::is_open(path);
                guarded += usize::from(!open);
                for status in ["401", "403"] {
                    assert_eq!(answers.contains_key(status), !open, "{verb} {path} {status}");
                }
                for (status, answer) in answers.iter().filter(|(status, _)| status.as_str() >= "400") {
                    assert_eq!(
                        answer["content"][MEDIA_TYPE]["schema"]["$ref"], PROBLEM,
                        "{verb} {path} {status}"
                    );
                }
                let full = operation["responses"].get("429").is_some();
                let makes_jobs = ["/v1/jobs post", "/v1/programs/{id}/dry-run put"];
                assert_eq!(full, makes_jobs.contains(&&*format!("{path} {verb}")), "{verb} {path}");
                assert!(open || answers.contains_key("503"), "{verb} {path}");
            }
        }
        assert!(guarded >= 39, "{guarded}");
        let words = &document["paths"]["/v1/runs/{r}/start"]["put"]["responses"]["403"]["description"];
        assert_eq!(words, "It is another machine's. The role of the key may not do this");
    }
}
