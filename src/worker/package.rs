//! From the parts of an answer to what the store keeps.

use std::io::{Cursor, Write};

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

use super::protocol::{Delivered, Role};
use crate::job::id::ProgramId;
use crate::job::life::StageTime;
use crate::planning::finding::Severity;
use crate::planning::outcome::Verdict;
use crate::store::programs::{NewFile, NewProgram};
use crate::store::results::{Answer, NewDrawing};

/// Why an answer cannot be kept: a defect of the planner.
#[derive(Debug, thiserror::Error)]
pub enum Defect {
    /// An answer without a report.
    #[error("the answer has no report")]
    NoReport,
    /// A name with other characters than letters, digits, `.`, `-` and `_`.
    #[error("{0:?} is not a plain file name")]
    Name(String),
    /// A report without a verdict.
    #[error("the report has no verdict: {0}")]
    Report(serde_json::Error),
    /// The archive could not be written.
    #[error("the archive could not be written: {0}")]
    Archive(#[from] zip::result::ZipError),
    /// The archive could not be filled.
    #[error("the archive could not be filled: {0}")]
    Write(#[from] std::io::Error),
}

/// Puts an answer together. `program` is the id of its program, if it has one.
///
/// # Errors
/// A defect of the planner.
pub fn package(parts: Vec<Delivered>, stages: Vec<StageTime>, program: ProgramId) -> Result<Answer, Defect> {
    let mut report = None;
    let mut drawings = Vec::new();
    let mut files = Vec::new();
    for Delivered { part, body } in parts {
        let name = plain(part.name)?;
        match part.role {
            Role::Report => report = Some(body),
            Role::Drawing => drawings.push(NewDrawing { name, body }),
            Role::Program => files.push(NewFile { name, dialect: part.dialect, body }),
        }
    }
    let program = match files.len() {
        0 => None,
        1 => Some(NewProgram { id: program, files, archive: None }),
        _ => Some(NewProgram { id: program, archive: Some(archive(&files)?), files }),
    };
    let report = report.ok_or(Defect::NoReport)?;
    let (usable, warnings) = verdict(&report)?;
    Ok(Answer { report, usable, warnings, drawings, program, stages })
}

/// What a report says of its job: whether it is usable, and how many warnings there are.
fn verdict(report: &[u8]) -> Result<(bool, u32), Defect> {
    #[derive(serde::Deserialize)]
    struct Report {
        verdict: Verdict,
        #[serde(default)]
        findings: Vec<Found>,
    }
    #[derive(serde::Deserialize)]
    struct Found {
        severity: Severity,
    }
    let report: Report = serde_json::from_slice(report).map_err(Defect::Report)?;
    let warnings = report.findings.iter().filter(|found| found.severity == Severity::Warning).count();
    Ok((report.verdict == Verdict::Usable, u32::try_from(warnings).unwrap_or(u32::MAX)))
}

/// Names stand in headers, addresses and archives.
fn plain(name: String) -> Result<String, Defect> {
    let fits = |byte: u8| byte.is_ascii_alphanumeric() || b".-_".contains(&byte);
    if !name.is_empty() && name.len() <= 255 && !name.starts_with('.') && name.bytes().all(fits) {
        Ok(name)
    } else {
        Err(Defect::Name(name))
    }
}

/// All files in one, in their order and with one fixed date: the same files give the same bytes.
fn archive(files: &[NewFile]) -> Result<NewFile, Defect> {
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .last_modified_time(DateTime::default())
        .unix_permissions(0o644);
    let mut writer = ZipWriter::new(Cursor::new(Vec::new()));
    for file in files {
        writer.start_file(&file.name, options)?;
        writer.write_all(&file.body)?;
    }
    let body = writer.finish()?.into_inner();
    let stem = files.first().and_then(|file| file.name.split('.').next()).unwrap_or_default();
    Ok(NewFile { name: format!("{stem}.zip"), dialect: "zip".to_owned(), body })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::moment::Moment;
    use crate::worker::protocol::Part;

    fn id() -> ProgramId {
        ProgramId::new(Moment::from_unix_ms(0), &[0; 10])
    }

    fn delivered(role: Role, name: &str, body: &[u8]) -> Delivered {
        let part = Part { role, name: name.into(), dialect: "krl".into(), bytes: body.len() as u64 };
        Delivered { part, body: body.to_vec() }
    }

    #[test]
    fn several_files_become_one_archive_with_the_same_bytes_each_time() {
        let parts = || {
            vec![
                delivered(Role::Report, "report.json", br#"{"verdict": "usable"}"#),
                delivered(Role::Program, "cut.src", b"DEF cut()\r\n"),
                delivered(Role::Program, "cut.dat", b"DEFDAT cut\r\n"),
            ]
        };
        let content = |answer: Answer| answer.program.unwrap().archive.unwrap();
        let first = content(package(parts(), vec![], id()).unwrap());
        let again = content(package(parts(), vec![], id()).unwrap());
        assert_eq!(first.name, "cut.zip");
        assert_eq!(first.body, again.body);
        let mut read = zip::ZipArchive::new(Cursor::new(first.body)).unwrap();
        let names: Vec<_> =
            (0..read.len()).map(|i| read.by_index(i).unwrap().name().unwrap().into_owned()).collect();
        assert_eq!(names, ["cut.src", "cut.dat"]);
    }

    #[test]
    fn a_name_can_never_become_a_path_or_a_header() {
        for name in ["../x.ngc", "a/b.ngc", "a\"b.ngc", "a\r\nb.ngc", "", ".ngc", "ä.ngc"] {
            let parts =
                vec![delivered(Role::Report, "report.json", b""), delivered(Role::Program, name, b"")];
            assert!(matches!(package(parts, vec![], id()), Err(Defect::Name(_))), "{name:?}");
        }
    }
}
