//! The set-up sheet: what a person at the machine needs before a roll is cut. Markdown, of content only.

use super::input::TapeInput;
use super::machine::{Cutter, Dialect, Machine};
use super::plan::TapePlan;
use super::restart::Made;
use super::spool::Turning;
use crate::planning::finding::{Finding, Severity};
use crate::planning::outcome::{Attachment, PLANNER_VERSION, ProgramFile, sha256_hex};
use crate::planning::program::moves::{Pose, Step, TapeProgram};
use crate::planning::program::number::fixed;
use crate::planning::units::Length;

/// What a sheet is about.
#[derive(Clone, Copy)]
pub struct Sheet<'a> {
    /// The whole roll.
    pub plan: &'a TapePlan,
    /// The program.
    pub program: &'a TapeProgram,
    /// What it was planned from.
    pub input: &'a TapeInput,
    /// What the program makes of each piece, where it goes on from a course.
    pub made: Option<&'a Made>,
}

/// What a program does with a piece.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Cut {
    Here,
    /// It was begun before; this program makes the rest.
    Finished,
    Before,
}

impl Sheet<'_> {
    /// Writes the sheet: `setup.md`. Lengths in mm with one decimal.
    #[must_use]
    pub fn write(&self, file: &ProgramFile, input_sha256: &str, findings: &[Finding]) -> Attachment {
        let Self { plan, program, input, .. } = *self;
        let mut text = String::from("# Set-up sheet\n\n");
        text.push_str(&no_whole_roll(program, input));
        text.push_str(&warnings_part(findings));
        text.push_str(&program_part(program, file, &input.machine, input_sha256));
        text.push_str(&tape_part(self));
        text.push_str(&zero_part(program, &input.machine));
        text.push_str(&plies_part(plan, input));
        text.push_str(&manifest_part(self));
        text.push_str(&trim_part(self));
        Attachment { name: "setup.md".to_owned(), text }
    }

    fn cut(&self, (course, piece): (usize, usize)) -> Cut {
        let made = self.made.and_then(|made| made.get(&(self.plan.courses[course].label, piece)));
        match made {
            Some((0, _)) => Cut::Before,
            Some((here, all)) if here < all => Cut::Finished,
            _ => Cut::Here,
        }
    }

    /// The pieces that the program cuts, in increasing roll coordinate.
    fn cut_here(&self) -> Vec<(usize, usize)> {
        self.plan.order.iter().copied().filter(|place| self.cut(*place) != Cut::Before).collect()
    }
}

/// What must be known before all else: this program is not one that cuts a whole roll.
fn no_whole_roll(program: &TapeProgram, input: &TapeInput) -> String {
    let mut text = String::new();
    if input.dry_run {
        text.push_str(
            "**DRY RUN: nothing is cut.** Knives stay up and the ultrasonic off, but the tape runs as for the real program. \
             It is no cut unit: do not book it as one.\n\n",
        );
    }
    if let Some(course) = input.from_course.filter(|_| program.start != input.machine.home()) {
        text.push_str(&format!(
            "**GOES ON WITHIN A ROLL, from course {course}.** Only for the roll on which this job's whole program has run up to where \
             course {course} begins, and no farther; what the table of the cassette says was begun before, it finishes. Do not zero the axes: {} must read {} or less, as in \
             the whole program; the program begins by running there slowly.\n\n",
            input.machine.feed.axis,
            reading(&input.machine, program.start.feed_mm)
        ));
    }
    text
}

/// What the report warns of; empty if of nothing.
fn warnings_part(findings: &[Finding]) -> String {
    let warnings: Vec<&Finding> = findings.iter().filter(|f| f.severity == Severity::Warning).collect();
    if warnings.is_empty() {
        return String::new();
    }
    let named = warnings
        .iter()
        .take(MOST_WARNINGS)
        .map(|warning| format!("- {} (at {})\n", message(&warning.message), message(&warning.at)));
    let named = named.collect::<String>();
    let more = match warnings.len().saturating_sub(MOST_WARNINGS) {
        0 => String::new(),
        more => format!("- and {more} more, in the report\n"),
    };
    format!(
        "## Warnings\n\nThe program holds what it says; see whether it says what is wanted.\n\n{named}{more}\n"
    )
}

/// So many warnings are read on a sheet of paper.
const MOST_WARNINGS: usize = 20;

/// What the tape axis reads with so much tape fed, rounded down: with more the tape would run back.
fn reading(machine: &Machine, feed_mm: f64) -> String {
    let down = |value: f64| fixed((value * 1e3).floor() / 1e3, 3);
    match &machine.feed.spool {
        Some(spool) => format!("{} degrees", down(spool.angle_deg(feed_mm))),
        None => format!("{} mm", down(feed_mm)),
    }
}

fn mm(value: f64) -> String {
    fixed(value, 1)
}

fn table(rows: &[(&str, String)]) -> String {
    let lines = rows.iter().map(|(what, is)| format!("| {what} | {is} |\n"));
    format!("| | |\n|---|---|\n{}\n", lines.collect::<String>())
}

fn program_part(program: &TapeProgram, file: &ProgramFile, machine: &Machine, input_sha256: &str) -> String {
    let rows = [
        ("program", format!("`{}`, {}", file.name, file.dialect)),
        ("its SHA-256", format!("`{}`", sha256_hex(file.text.as_bytes()))),
        ("input SHA-256", format!("`{input_sha256}`")),
        ("planner", PLANNER_VERSION.to_owned()),
        ("machine profile SHA-256", format!("`{}`", machine.profile_sha256)),
        ("expected time", expected_time(program)),
    ];
    format!("## Program\n\n{}", table(&rows))
}

/// What the tape needs into its place counts only if it has to come from its beginning.
fn expected_time(program: &TapeProgram) -> String {
    let there_s = program.time_s - program.approach_s;
    let time = format!("{} ({} s)", clock(there_s), fixed(there_s, 1));
    if program.approach_s > 0.0 {
        let from_zero = clock(program.approach_s);
        return format!(
            "{time} with the tape in its place already; from 0 the tape runs {from_zero} before that"
        );
    }
    time
}

/// Hours, minutes and whole seconds, rounded up.
fn clock(seconds: f64) -> String {
    let whole = seconds.ceil().clamp(0.0, 1e9) as u64;
    format!("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60)
}

fn tape_part(sheet: &Sheet<'_>) -> String {
    let Sheet { plan, program, input, .. } = *sheet;
    let (begun, finished): (Vec<_>, Vec<_>) =
        sheet.cut_here().into_iter().partition(|place| sheet.cut(*place) == Cut::Here);
    let finished = match finished.len() {
        0 => String::new(),
        count => format!(", and the rest of {count} begun before"),
    };
    let last = last_pose(program).feed_mm;
    let mut rows = vec![
        (
            "tape",
            format!("{} mm wide, {} mm thick", fixed(input.width.mm(), 3), fixed(input.thickness.mm(), 4)),
        ),
        ("tape fed by this program", format!("{} mm", mm(last - program.start.feed_mm))),
        (
            "tape used by all pieces of the roll and the scrap between them",
            format!("{} mm", mm(plan.figures.tape_used_mm)),
        ),
        ("pieces cut by this program", format!("{}{finished}", begun.len())),
    ];
    let name = |place: Option<&(usize, usize)>| {
        place.map_or(String::new(), |&(course, piece)| {
            format!("course {}, piece {}", plan.courses[course].label, piece + 1)
        })
    };
    // The tape moves toward +U, so the largest roll coordinate passes the knives first.
    rows.push(("first piece cut", name(begun.last())));
    rows.push(("last piece cut", name(begun.first())));
    if !input.zones_mm.is_empty() {
        let zones = input.zones_mm.iter().map(|(from, to)| format!("{} to {} mm", mm(*from), mm(*to)));
        let zones = zones.collect::<Vec<_>>().join(", ");
        rows.push(("kept free of pieces, from the leading end of the tape", zones));
    }
    if let Some(spool) = &input.machine.feed.spool {
        let way = match spool.turning {
            Turning::Unwinding => "unwinds",
            Turning::TakingUp => "takes up",
        };
        rows.push((
            "spool",
            format!(
                "{way}, driven by angle; radius {} mm at the start, {} mm at the end, core {} mm, layer {} mm. Measure the radius: the program holds for this one only",
                fixed(spool.roll_radius_mm, 2),
                fixed(spool.radius_mm(last), 2),
                fixed(spool.core_radius_mm, 2),
                fixed(spool.layer_mm, 4)
            ),
        ));
    }
    format!("## Tape\n\n{}", table(&rows))
}

fn last_pose(program: &TapeProgram) -> Pose {
    let moves = program.steps.iter().rev().find_map(|step| match step {
        Step::Move { to, .. } => Some(*to),
        _ => None,
    });
    moves.unwrap_or_default()
}

fn zero_part(program: &TapeProgram, machine: &Machine) -> String {
    let unit = if machine.feed.spool.is_some() { "degrees of the spool" } else { "mm" };
    let mut rows = vec![(
        format!("{} ({unit})", machine.feed.axis),
        "0 with the leading end of the tape under cutter 1; it only runs forward".to_owned(),
    )];
    for cutter in &machine.cutters {
        let number = cutter.number;
        let station = mm(cutter.station.mm());
        rows.push((
            format!("{} (mm)", cutter.lateral_axis),
            format!(
                "0 with cutter {number} over the middle of the tape; the cutter stands at station {station} mm{}",
                parked(cutter)
            ),
        ));
        rows.extend(edge(cutter).map(|is| (format!("edge of knife {number}"), is)));
        rows.push((
            format!("{} (degrees)", cutter.blade_axis),
            format!("0 with blade {number} square across the tape, its edge toward +V"),
        ));
        rows.push((format!("knife {number}"), switched(machine, cutter.number as usize - 1)));
    }
    rows.push(("ultrasonic".to_owned(), format!("off; {}", ultrasonic(machine))));
    let rows: Vec<(&str, String)> = rows.iter().map(|(what, is)| (what.as_str(), is.clone())).collect();
    let title = if program.start == machine.home() {
        "Zero positions at the start"
    } else {
        "Where the axes read 0 (set before the whole program, not now)"
    };
    format!("## {title}\n\n{}", table(&rows))
}

/// Where the edge of a knife is, if not on the axis of its blade, and whether its cuts go on past their ends.
fn edge(cutter: &Cutter) -> Option<String> {
    let length = |of: &Length| fixed(of.mm().abs(), 3);
    let offset = cutter.swivels().then(|| {
        let way = if cutter.offset.mm() > 0.0 { "behind" } else { "ahead of" };
        format!(
            "{} mm {way} the axis that turns the blade, along the cut; every 0 here, and every position in the program, is that \
             of the axis",
            length(&cutter.offset)
        )
    });
    let overcut = (cutter.overcut.mm() > 0.0)
        .then(|| format!("cuts go on by {} mm past their ends where that is scrap", length(&cutter.overcut)));
    let both: Vec<String> = offset.into_iter().chain(overcut).collect();
    (!both.is_empty()).then(|| both.join("; "))
}

fn parked(cutter: &Cutter) -> String {
    let park = |at: &Length| format!("; parked at {} mm at the start and at the end", fixed(at.mm(), 3));
    cutter.park.as_ref().map_or(String::new(), park)
}

fn switched(machine: &Machine, cutter: usize) -> String {
    let words = machine.words.as_ref().filter(|_| machine.dialect == Dialect::Sinumerik);
    match words.and_then(|words| words.knives.get(cutter)) {
        Some([down, up]) => format!("up; {down} lowers it, {up} raises it"),
        None => format!("up; output {} lowers it", machine.cutters[cutter].knife_output),
    }
}

fn ultrasonic(machine: &Machine) -> String {
    match machine.words.as_ref().filter(|_| machine.dialect == Dialect::Sinumerik) {
        Some(words) => format!("{} and {} switch it", words.ultrasonic[0], words.ultrasonic[1]),
        None => format!("output {} switches it", machine.ultrasonic_output),
    }
}

/// Pieces whose outline was changed on its scrap side, and what that leaves to do; empty if there are none.
fn trim_part(sheet: &Sheet<'_>) -> String {
    let mut rows = String::new();
    for (course, index) in sheet.cut_here() {
        let course = &sheet.plan.courses[course];
        if let Some((deviation, area)) = course.pieces[index].simplified {
            let (label, piece) = (course.label, index + 1);
            rows.push_str(&format!("| {label} | {piece} | {} | {} |\n", fixed(deviation, 3), mm(area)));
        }
    }
    if rows.is_empty() {
        return rows;
    }
    format!(
        "\n## To be trimmed by hand (tinted in `pieces.svg`)\n\nFor these outlines there are not enough knives; they are cut \
         on the scrap side of the ply's.\n\n| course | piece | beyond the ply, at most mm | area mm2 |\n|---|---|---|---|\n{rows}"
    )
}

/// Which plies the roll holds, where there are several.
fn plies_part(plan: &TapePlan, input: &TapeInput) -> String {
    if !input.several_plies() {
        return String::new();
    }
    let mut text = String::from("## Plies, in laying order\n\n| ply | name | pieces |\n|---|---|---|\n");
    for ply in &input.plies {
        let number = ply.place.number.unwrap_or(1);
        let pieces = plan.courses.iter().filter(|course| course.place.ply == ply.place);
        let pieces: usize = pieces.map(|course| course.pieces.len()).sum();
        text.push_str(&format!("| {number} | {} | {pieces} |\n", cell(&ply.name)));
    }
    text + "\n"
}

/// A text from outside as plain words in a cell of a table: nothing in it is markup.
fn cell(text: &str) -> String {
    plain(text, |c| c.is_ascii_punctuation() && !"-.,:".contains(c))
}

/// A message, which may quote a text from outside, in a paragraph that begins with other words. It is read as it stands, too.
fn message(text: &str) -> String {
    plain(text, |c| "\\`*_[]<>|~&$".contains(c))
}

/// A text in which some letters stand for themselves.
fn plain(text: &str, active: impl Fn(char) -> bool) -> String {
    let mut cell = String::new();
    for c in text.chars() {
        if active(c) {
            cell.push('\\');
        }
        // Also what turns the direction of writing around is no word.
        let shown = !c.is_control()
            && !('\u{200b}'..='\u{202e}').contains(&c)
            && !('\u{2060}'..='\u{2069}').contains(&c);
        cell.push(if shown { c } else { ' ' });
    }
    cell
}

/// The last piece wound comes off the cassette first.
fn manifest_part(sheet: &Sheet<'_>) -> String {
    let Sheet { plan, input, .. } = *sheet;
    let several = input.several_plies();
    let (ply, line) = if several { ("ply | ", "---|") } else { ("", "") };
    let mut text = format!(
        "## Cassette, in the order in which it gives the pieces out\n\n\
         | | {ply}course | piece | length mm | area mm2 | roll from mm | to mm | |\n|---|{line}---|---|---|---|---|---|---|\n"
    );
    for (place, (&(course, index), (_, piece))) in plan.order.iter().zip(plan.pieces()).enumerate() {
        let before = match sheet.cut((course, index)) {
            Cut::Here => "",
            Cut::Finished => "begun before, finished by this program",
            Cut::Before => "cut before, not by this program",
        };
        let marks = [before, piece.marks.words()]
            .into_iter()
            .filter(|words| !words.is_empty())
            .collect::<Vec<_>>()
            .join("; ");
        let (low, high) = piece.piece.u_range();
        let label = plan.courses[course].label;
        let ply = label.ply.map_or(String::new(), |ply| format!("{ply} | "));
        text.push_str(&format!(
            "| {} | {ply}{} | {} | {} | {} | {} | {} | {} |\n",
            place + 1,
            label.number,
            index + 1,
            mm(high - low),
            mm(piece.piece.area_mm2),
            mm(low + piece.offset_mm),
            mm(high + piece.offset_mm),
            marks
        ));
    }
    text
}
