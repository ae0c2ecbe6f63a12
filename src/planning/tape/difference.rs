//! Where a program that is checked differs from the one that its job gives, and, where its header tells, why.

use crate::planning::finding::{Code, Finding};

/// So many lines at the beginning of a program are its header: comments before the first block.
const HEADER_LINES: usize = 8;

/// The first line at which a text differs from the planned one, with a hint where one of them is a dry run or begins in
/// the middle of a roll and the other is not or does not.
pub(super) fn difference(name: &str, text: &str, planned: &str) -> Option<Finding> {
    if text == planned {
        return None;
    }
    let same = text.split('\n').zip(planned.split('\n')).take_while(|(one, other)| one == other).count();
    let mut message =
        "here the text begins to differ from the program that this job gives; only that one may be approved"
            .to_owned();
    for hint in hints(&Header::of(text), &Header::of(planned)) {
        message.push_str(". ");
        message.push_str(&hint);
    }
    Some(Finding::warning(Code::DiffersFromPlan, format!("{name}:{}", same + 1), message))
}

/// What the header of a program says of it.
struct Header {
    dry: bool,
    /// The course with which a program begins that goes on within a roll.
    from_course: Option<String>,
}

impl Header {
    fn of(text: &str) -> Self {
        let says = |words: &str| text.lines().take(HEADER_LINES).any(|line| line.contains(words));
        let goes_on = says("GOES ON WITHIN A ROLL");
        Self { dry: says("DRY RUN"), from_course: goes_on.then(|| first_course(text)) }
    }
}

/// The number of the first course of a text, as it stands there.
fn first_course(text: &str) -> String {
    let number = |line: &str| {
        let (_, rest) = line.split_once("COURSE ")?;
        Some(rest.chars().take_while(char::is_ascii_digit).take(7).collect::<String>())
    };
    text.lines().find_map(number).filter(|number| !number.is_empty()).unwrap_or_else(|| "?".to_owned())
}

fn hints(checked: &Header, planned: &Header) -> Vec<String> {
    let dry = match (checked.dry, planned.dry) {
        (true, false) => Some(
            "Its header says DRY RUN, and a dry run cuts nothing: check it against this job with options.dry_run"
                .to_owned(),
        ),
        (false, true) => Some(
            "The job asks for a dry run, and this program cuts: check it against this job without options.dry_run"
                .to_owned(),
        ),
        _ => None,
    };
    let course = match (&checked.from_course, &planned.from_course) {
        (Some(number), other) if other.as_ref() != Some(number) => Some(format!(
            "Its header says that it goes on within a roll, from course {number}: check it against this job with options.from_course {number}"
        )),
        (None, Some(number)) => Some(format!(
            "The job asks for a program from course {number} on, and this one begins with the roll: check it against this job without options.from_course"
        )),
        _ => None,
    };
    dry.into_iter().chain(course).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHOLE: &str = "(BLADEPLAN)\n(ALL AXES AT ZERO)\nN10 G21\n(COURSE 3, RESTART HERE)\n";
    const DRY: &str =
        "(BLADEPLAN)\n(ALL AXES AT ZERO)\n(DRY RUN, KNIVES STAY UP)\nN10 G21\n(COURSE 3, RESTART HERE)\n";
    const LATE: &str = "; BLADEPLAN\n; GOES ON WITHIN A ROLL\nN10 G21\n; COURSE 7, RESTART HERE\n";

    fn said(text: &str, planned: &str) -> String {
        difference("x.ngc", text, planned).map(|finding| finding.message).unwrap_or_default()
    }

    #[test]
    fn what_is_no_program_of_this_job_is_said_to_be_of_its_sister() {
        assert_eq!(difference("x.ngc", WHOLE, WHOLE), None);
        assert!(said(DRY, WHOLE).contains("says DRY RUN"));
        assert!(said(WHOLE, DRY).contains("without options.dry_run"));
        assert!(said(LATE, WHOLE).contains("with options.from_course 7"));
        assert!(said(WHOLE, LATE).contains("from course 7 on"));
        let other = LATE.replace("COURSE 7", "COURSE 12");
        assert!(said(&other, LATE).contains("with options.from_course 12"));
        let ordinary = said(&WHOLE.replace("G21", "G20"), WHOLE);
        assert!(ordinary.ends_with("may be approved"), "an ordinary difference has no hint: {ordinary}");
        let late_words = format!("{WHOLE}{}(DRY RUN)\n", "\n".repeat(HEADER_LINES));
        assert!(!said(&late_words, WHOLE).contains("DRY"), "words behind the header are no header");
    }
}
