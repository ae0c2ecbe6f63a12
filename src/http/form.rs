//! A job that comes with files: `multipart/form-data` (RFC 7578) taken apart.
//!
//! One part named `job` is the document, as `application/json`. Every other part is a file; its file name, or its
//! field's name if it has none, is the name by which the document knows it.

use axum::body::{Body, Bytes};
use axum::extract::multipart::{Field, MultipartError};
use axum::extract::{DefaultBodyLimit, FromRequest, Multipart, Request};
use axum::http::{HeaderMap, HeaderValue, header};

use super::problem::{Answer, Problem, ProblemCode};
use crate::planning::document::files::{Files, Refusal};
use crate::planning::finding::Finding;

/// The name of the part that is the document.
const JOB: &str = "job";

/// A form with so many faults is not worth reading further.
const MOST_FAULTS: usize = 100;

/// So many characters of what is wrong with a form go to the log.
const LOGGED: usize = 200;

/// A document and its files, as they were sent.
#[derive(Debug, Default)]
pub struct Form {
    /// The document, byte for byte.
    pub job: Vec<u8>,
    /// The files.
    pub files: Files,
}

/// Takes a form apart that has arrived completely.
///
/// # Errors
/// `InvalidMultipart`: no form of this kind, cut off, without a document or with two; or every file with a name that
/// is not plain or there already.
pub async fn take_apart(content_type: &HeaderValue, body: Vec<u8>) -> Answer<Form> {
    let mut parts = multipart(content_type, body).await?;
    let (mut job, mut files, mut faults) = (None, Files::default(), Vec::new());
    for number in 1.. {
        if faults.len() >= MOST_FAULTS {
            break;
        }
        let Some(field) = parts.next_field().await.map_err(|error| damaged(number, &error))? else { break };
        match part(field, number).await? {
            Part::Job(_) if job.is_some() => return Err(invalid("two parts are named job")),
            Part::Job(bytes) => job = Some(bytes),
            Part::File(name, bytes) => match files.insert(name, bytes.into()) {
                Ok(()) => {}
                Err(limit @ (Refusal::TooMany | Refusal::TooLarge)) => {
                    return Err(invalid(limit.to_string()));
                }
                Err(refusal) => faults.push(at_part(number, &refusal)),
            },
        }
    }
    if !faults.is_empty() {
        return Err(Problem::of_faults(ProblemCode::InvalidMultipart, faults));
    }
    let job = job.ok_or_else(|| invalid("no part is named job"))?.into();
    Ok(Form { job, files })
}

/// A part of a form.
enum Part {
    Job(Bytes),
    File(String, Bytes),
}

async fn multipart(content_type: &HeaderValue, body: Vec<u8>) -> Answer<Multipart> {
    let mut request = Request::new(Body::from(body));
    request.headers_mut().insert(header::CONTENT_TYPE, content_type.clone());
    // The body is bounded already, and may be larger than the framework's own limit.
    DefaultBodyLimit::disable().apply(&mut request);
    Multipart::from_request(request, &()).await.map_err(|rejection| invalid(rejection.body_text()))
}

async fn part(field: Field<'_>, number: usize) -> Answer<Part> {
    let Some(name) = field.name().map(str::to_owned) else {
        return Err(invalid(format!("part {number} has no name that can be read")));
    };
    if name == JOB {
        refuse_other_documents(&field)?;
        return Ok(Part::Job(whole(field, number).await?));
    }
    let name = match field.file_name() {
        Some(file) => file.to_owned(),
        // What cannot be read is not passed over: the file would come under another name.
        None if says_file_name(field.headers()) => {
            return Err(invalid(format!("part {number} has a file name that cannot be read")));
        }
        None => name,
    };
    Ok(Part::File(name, whole(field, number).await?))
}

async fn whole(field: Field<'_>, number: usize) -> Answer<Bytes> {
    field.bytes().await.map_err(|error| damaged(number, &error))
}

/// A form that a browser sends by itself does not say that a part is JSON.
fn refuse_other_documents(field: &Field<'_>) -> Answer<()> {
    let kind = field.content_type().unwrap_or_default().split(';').next().unwrap_or_default().trim();
    if kind.eq_ignore_ascii_case("application/json") {
        return Ok(());
    }
    let say =
        "the part job must say that it is application/json: curl -F 'job=@JOB.json;type=application/json'";
    Err(invalid(say))
}

fn says_file_name(headers: &HeaderMap) -> bool {
    let text = headers.get(header::CONTENT_DISPOSITION).map(HeaderValue::as_bytes).unwrap_or_default();
    let mut parameters = text.split(|byte| *byte == b';').map(<[u8]>::trim_ascii);
    parameters.any(|parameter| parameter.to_ascii_lowercase().starts_with(b"filename"))
}

fn at_part(number: usize, refusal: &Refusal) -> Finding {
    let fault = refusal.finding();
    Finding { message: format!("part {number}: {}", fault.message), ..fault }
}

fn invalid(detail: impl Into<String>) -> Problem {
    Problem::new(ProblemCode::InvalidMultipart).detail(detail)
}

/// What the reader of forms says quotes the sender, at any length; it goes to the log.
fn damaged(number: usize, error: &MultipartError) -> Problem {
    let words: String = error.body_text().chars().take(LOGGED).collect();
    tracing::debug!(part = number, words, "a damaged form");
    invalid(format!("the form is cut off or damaged at part {number}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    const KIND: HeaderValue = HeaderValue::from_static("multipart/form-data; boundary=XX");
    const DOCUMENT: &str = "name=\"job\"\r\nContent-Type: application/json\r\n\r\n{}";

    /// A form of these parts, each from the parameters of its Content-Disposition on.
    fn form(parts: &[&str]) -> Vec<u8> {
        let part = |part: &&str| format!("--XX\r\nContent-Disposition: form-data; {part}\r\n");
        format!("{}--XX--\r\n", parts.iter().map(part).collect::<String>()).into_bytes()
    }

    async fn taken(parts: &[&str]) -> Result<Form, String> {
        let refused = |problem: Problem| {
            assert_eq!(problem.code(), ProblemCode::InvalidMultipart);
            format!("{problem:?}")
        };
        take_apart(&KIND, form(parts)).await.map_err(refused)
    }

    #[tokio::test]
    async fn a_file_has_its_own_name_or_that_of_its_field() {
        let own = "name=\"x\"; filename=\"a b.txt\"\r\nContent-Type: text/plain\r\n\r\n1\r\n2\r\n\r\n";
        let parts = [own, DOCUMENT, "name=\"trace.txt\"\r\n\r\n--X\r\n", "name=\"z\"\r\n\r\n"];
        let Form { job, files } = taken(&parts).await.unwrap();
        assert_eq!(job, b"{}");
        let expected = [("a b.txt", &b"1\r\n2\r\n\r\n"[..]), ("trace.txt", b"--X\r\n"), ("z", b"")];
        assert_eq!(files.iter().collect::<Vec<_>>(), expected.map(|(name, body)| (name, body)));
    }

    #[tokio::test]
    async fn one_document_and_no_other() {
        assert!(taken(&[]).await.unwrap_err().contains("no part is named job"));
        assert!(taken(&["name=\"file\"\r\n\r\n"]).await.unwrap_err().contains("no part is named job"));
        assert!(taken(&[DOCUMENT, DOCUMENT]).await.unwrap_err().contains("two parts are named job"));
        for kind in ["", "Content-Type: text/plain\r\n", "Content-Type: application/jsonp\r\n"] {
            let said = taken(&[&format!("name=\"job\"\r\n{kind}\r\n{{}}")]).await.unwrap_err();
            assert!(said.contains("application/json"), "{said}");
        }
    }

    #[tokio::test]
    async fn every_name_that_is_not_plain_or_there_twice_is_said_with_its_part() {
        let names = ["../x", "a", "C:\\x", "a", "", "\u{e4}", "a/b"];
        let file = |name: &str| format!("name=\"f\"; filename=\"{name}\"\r\n\r\n");
        let parts: Vec<_> = names.into_iter().map(file).chain([DOCUMENT.to_owned()]).collect();
        let parts: Vec<_> = parts.iter().map(String::as_str).collect();
        let said = taken(&parts).await.unwrap_err();
        for number in [1, 3, 4, 5, 6, 7] {
            assert!(said.contains(&format!("\"part {number}: ")), "{number}: {said}");
        }
        assert!(!said.contains("part 2:") && !said.contains("part 8:"), "{said}");
    }

    #[tokio::test]
    async fn a_name_that_cannot_be_read_is_not_replaced_by_another() {
        for part in [
            "name=\"a\"; filename=\"b",
            "name=\"a\"; filename*=UTF-8''b.txt",
            "name=\"a\"; FileName=\"b.txt\"",
            "filename=\"b.txt\"",
            "",
        ] {
            let said = taken(&[DOCUMENT, &format!("{part}\r\n\r\n1")]).await.unwrap_err();
            assert!(said.contains("part 2 has"), "{part}: {said}");
        }
        let mut raw = form(&[DOCUMENT, "name=\"a\"; filename=\"?\"\r\n\r\n1"]);
        let at = raw.iter().position(|byte| *byte == b'?').unwrap();
        for byte in [0, 0xff] {
            raw[at] = byte;
            assert!(take_apart(&KIND, raw.clone()).await.is_err(), "{byte}");
        }
    }

    #[tokio::test]
    async fn a_form_that_is_cut_off_anywhere_is_refused() {
        let whole = form(&["name=\"a.txt\"\r\n\r\n0 0 0\r\n1 0 0\r\n", DOCUMENT]);
        let end = whole.len() - "\r\n".len();
        assert!(take_apart(&KIND, whole[..end].to_vec()).await.is_ok(), "the last line end may be missing");
        for length in 0..end {
            let refused = take_apart(&KIND, whole[..length].to_vec()).await.map(|_| length).unwrap_err();
            assert_eq!(refused.code(), ProblemCode::InvalidMultipart, "{length}");
        }
        let nothing = HeaderValue::from_static("multipart/form-data");
        assert_eq!(take_apart(&nothing, whole).await.unwrap_err().code(), ProblemCode::InvalidMultipart);
    }

    #[tokio::test]
    async fn parts_without_end_are_not_read_to_their_end() {
        let good: Vec<_> = (0..1000).map(|number| format!("name=\"f{number}\"\r\n\r\n")).collect();
        let good: Vec<_> = good.iter().map(String::as_str).collect();
        assert!(taken(&good).await.unwrap_err().contains("more than 256 files"));
        let said = taken(&["name=\"..\"\r\n\r\n"; 1000]).await.unwrap_err();
        assert!(said.contains("\"part 100: ") && !said.contains("part 101"), "{said}");
    }
}
