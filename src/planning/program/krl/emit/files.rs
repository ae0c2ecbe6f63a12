//! Sections of layers packed into files of bounded length.

use super::{DIALECT, Section, text_of};
use crate::planning::outcome::ProgramFile;
use crate::planning::program::krl::stem::Stem;

/// Lines of a sub-program beside its sections: two `&` lines, DEF and END.
pub(super) const OVERHEAD: usize = 4;

/// The sub-programs, each with as many whole sections as it has room for.
pub(super) fn sub_programs(stem: &Stem, sections: &[Section], room: usize) -> Vec<ProgramFile> {
    let mut files = Vec::new();
    let mut body: Vec<String> = Vec::new();
    for section in sections {
        if !body.is_empty() && body.len() + section.lines.len() > room {
            files.push(sub_program(stem, files.len() + 1, &body));
            body.clear();
        }
        body.extend_from_slice(&section.lines);
    }
    if !body.is_empty() {
        files.push(sub_program(stem, files.len() + 1, &body));
    }
    files
}

fn sub_program(stem: &Stem, number: usize, body: &[String]) -> ProgramFile {
    let name = stem.sub_program(number);
    let mut lines = head(&name);
    lines.extend_from_slice(body);
    lines.push("END".to_owned());
    file(&name, "src", &lines)
}

/// The first lines of a program.
pub(crate) fn head(name: &str) -> Vec<String> {
    vec!["&ACCESS RVP".to_owned(), "&REL 1".to_owned(), format!("DEF {name} ( )")]
}

/// A file of the dialect.
pub(crate) fn file(name: &str, extension: &str, lines: &[String]) -> ProgramFile {
    ProgramFile { name: format!("{name}.{extension}"), dialect: DIALECT, text: text_of(lines) }
}
