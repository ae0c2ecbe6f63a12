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
    from_course: Option<First>,
}

impl Header {
    fn of(text: &str) -> Self {
        let says = |words: &str| text.lines().take(HEADER_LINES).any(|line| line.contains(words));
        let goes_on = says("GOES ON WITHIN A ROLL");
        Self { dry: says("DRY RUN"), from_course: goes_on.then(|| first_course(text)) }
    }
}

/// What the first course of a text is called there.
fn first_course(text: &str) -> First {
    let number = |rest: &str| Some(digits(rest)).filter(|number| !number.is_empty());
    let course = |line: &str| {
        let (_, rest) = line.split_once("COURSE ")?;
        let course = number(rest)?;
        let ply = rest[course.len()..].strip_prefix(" OF PLY ").and_then(number);
        Some(First { course, ply })
    };
    text.lines().find_map(course).unwrap_or_else(|| First { course: "?".to_owned(), ply: None })
}

/// The digits at the beginning of a text.
fn digits(text: &str) -> String {
    text.chars().take_while(char::is_ascii_digit).take(7).collect()
}

/// The number of a course as it stands in a text, and that of its ply where there are several.
#[derive(PartialEq)]
struct First {
    course: String,
    ply: Option<String>,
}

impl First {
    fn name(&self) -> String {
        let ply = self.ply.as_ref().map_or(String::new(), |ply| format!(" of ply {ply}"));
        format!("{}{ply}", self.course)
    }

    /// The options of a job whose program begins with it.
    fn options(&self) -> String {
        let ply = self.ply.as_ref().map_or(String::new(), |ply| format!(" and options.from_ply {ply}"));
        format!("options.from_course {}{ply}", self.course)
    }
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
        (Some(first), other) if other.as_ref() != Some(first) => Some(format!(
            "Its header says that it goes on within a roll, from course {}: check it against this job with {}",
            first.name(),
            first.options()
        )),
        (None, Some(first)) => Some(format!(
            "The job asks for a program from course {} on, and this one begins with the roll: check it against this job without options.from_course",
            first.name()
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
        let [second, third] = [2, 3].map(|ply| LATE.replace("COURSE 7", &format!("COURSE 7 OF PLY {ply}")));
        assert!(said(&second, LATE).contains("with options.from_course 7 and options.from_ply 2"));
        assert!(said(&second, &third).contains("from course 7 of ply 2: check"));
        assert!(said(WHOLE, &third).contains("from course 7 of ply 3 on"));
        let late_words = format!("{WHOLE}{}(DRY RUN)\n", "\n".repeat(HEADER_LINES));
        assert!(!said(&late_words, WHOLE).contains("DRY"), "words behind the header are no header");
    }
}
