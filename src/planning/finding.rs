//! What is wrong, where, by how much: all of it at once.

use serde::{Deserialize, Serialize};

/// How much a finding weighs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Severity {
    /// Said for completeness; nothing to do.
    Info,
    /// Planned all the same; a person should look.
    Warning,
    /// No usable program.
    Error,
}

macro_rules! codes {
    ($($(#[doc = $doc:literal])+ $name:ident),+ $(,)?) => {
        /// The closed set of finding codes. A code is contract; the message beside it is for people.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
        #[serde(rename_all = "snake_case")]
        pub enum Code { $($(#[doc = $doc])+ $name),+ }

        impl Code {
            /// Every code with what it means, in order.
            pub const ALL: &[(Code, &str)] = &[$((Code::$name, concat!($($doc),+))),+];
        }
    };
}

codes! {
    // -- The document itself.
    /// The text is not JSON, or ends too early.
    InvalidJson,
    /// The JSON is nested deeper than any job document is.
    TooDeep,
    /// A number is not finite, or cannot be held.
    InvalidNumber,
    /// A field that no job document has.
    UnknownField,
    /// A field that is there twice.
    DuplicateField,
    /// A field that must be there is not.
    MissingField,
    /// A value of another type than its field holds.
    WrongType,
    /// A word that is not one of those its field knows.
    UnknownValue,
    /// A number outside its limits.
    OutOfRange,
    /// Too many or too few items.
    WrongCount,
    /// A machine that is neither built in nor registered.
    UnknownMachine,
    /// A machine of another kind than the job needs.
    WrongMachine,
    /// A file name with a path in it, or of a file that was not sent.
    UnknownFile,
    /// A file that was sent and that no field of the document names.
    UnusedFile,
    /// Something that the contract names and this version does not do yet.
    NotSupported,
    /// Two fields of which only one may be there.
    ConflictingFields,
    // -- The files of a ply.
    /// A file that is not of the form that its name says, or ends too early.
    UnreadableFile,
    /// A drawing that does not say its unit; it was read in mm.
    UnitsAssumed,
    /// Something in a drawing that is no part of an outline (left out).
    LeftOut,
    /// Ends of curves that do not quite meet (joined).
    JoinedEnds,
    /// Curves of a drawing that do not close to an outline, or branch.
    OpenOutline,
    /// Something out of plane that must be flat.
    NotFlat,
    // -- The geometry of a ply.
    /// An outline with fewer than three different points.
    TooFewPoints,
    /// An outline that crosses or touches itself or another one.
    OutlineCrosses,
    /// A cut-out outside the ply.
    HoleOutside,
    /// A normal with no length.
    ZeroNormal,
    /// A course with fewer than two different points.
    CourseTooShort,
    /// Two courses with one number.
    DuplicateCourse,
    /// An outline that repeats its first point at its end (accepted).
    ClosedOutline,
    /// Points repeated one after the other (dropped).
    RepeatedPoint,
    /// An outline turning the other way (accepted).
    OutlineSense,
    /// Sizes that differ so much that not all can be in mm (accepted).
    UnlikeSizes,
    /// Normals of a course that point against those of the courses beside it.
    NormalsOpposed,
    /// A normal whose length is not 1 (scaled).
    NormalScaled,
    /// A closing step far longer than the others (accepted).
    LongClosingStep,
    /// A course that does not touch the ply (left out).
    CourseOffPly,
    /// A part of the ply lies under no course (planned all the same).
    PlyNotCovered,
    /// A part of the ply lies under several courses (planned all the same).
    CoursesOverlap,
    /// No course touches the ply.
    NoCourseOnPly,
    /// A course that turns back on itself, or whose normals are not square to it.
    BadCourse,
    /// An outline leaves the mould within the tape of a course.
    OffMould,
    /// The points of a course are too far apart for the smooth course between them (planned all the same).
    CoarseCourse,
    /// A piece that goes on beyond the end of its course by more than half its length or a width (planned all the same).
    CourseContinued,
    // -- The contour of a core.
    /// A contour that does not go from one side of the blank to the other.
    ProfileSpan,
    /// A contour whose x falls.
    ProfileFalls,
    // -- Planning.
    /// More cuts at one place of the roll than there are knives.
    TooManyKnives,
    /// A pair of cuts that the published rule cannot allocate; the general rule was used.
    GeneralRule,
    /// An outline was changed on its scrap side, because there are not enough knives for it.
    OutlineSimplified,
    /// A piece that is shorter than the laying head can lay (planned all the same).
    PieceTooShort,
    /// A piece that is nowhere wide enough to hold (planned all the same).
    Sliver,
    /// Ends of cuts that do not go on as far as the overcut says.
    OvercutShortened,
    /// Tips that two knives cut, where the overcut is less than the errors of the axes ask for.
    OvercutTooShort,
    /// Two neighbouring pieces have one cut between them (planned so because it was asked for).
    SharedCut,
    /// A defect or splice that lies beyond the tape that the roll uses.
    ZoneUnused,
    /// The spool holds less tape than the roll needs.
    TapeTooShort,
    /// Two carriages on one beam would come, or do come, closer to one another than they may.
    CarriagesTooClose,
    /// The tape or an axis does not reach far enough.
    AxisLimit,
    /// The step limit of a job is used up.
    BudgetSpent,
    /// The job was cancelled.
    Cancelled,
    // -- A program read back.
    /// A line that the reader does not understand.
    UnreadableProgram,
    /// The tape runs backwards.
    TapeReversal,
    /// An axis leaves its travel.
    TravelExceeded,
    /// An axis is driven faster than it may.
    SpeedExceeded,
    /// A wanted cut, or a part of it, is not made.
    Uncut,
    /// Something is cut that should not be.
    Unwanted,
    /// A piece that lies over another on the roll, closer to it than the gap, in a zone, or before the tape begins.
    MisplacedPiece,
    /// A cut lies farther from its place than the tolerance.
    Deviation,
    /// The blade does not lie along its cut.
    BladeAngle,
    /// A knife is moved, dropped or left in a way that is not safe.
    KnifeState,
    /// A tool or base frame that is not the cell's.
    WrongFrame,
    /// A blade that turns within the blank.
    TurnInBlank,
    /// A motion through material that is no cut.
    ThroughStock,
    /// The finished part is cut into.
    Gouge,
    /// A chip that no cut has freed.
    StuckChip,
    /// The cut surface lies farther from the contour than it may.
    ScallopExceeded,
    /// No layer spacing, step and swing angle lie within all limits.
    NoParameters,
    /// A path of a milling program that is strange; it was converted all the same.
    StrangePath,
    /// A published lattice that was looked at and not taken.
    LatticePassedOver,
    /// A cut of the program that the lattice does not reach with the blade.
    EdgeInStock,
    /// The robot does not follow: a joint limit, a joint speed, or a pose out of reach.
    RobotFault,
    /// No robot cell was given; whether a robot can follow is not known.
    RobotNotChecked,
    /// The program runs slower than was asked for, so that the robot can follow.
    SlowedForRobot,
    /// The robot passes near a singularity.
    NearSingularity,
    /// The program text differs from the one that planning this job gives.
    DiffersFromPlan,
    /// The program has no proper end.
    NoProgramEnd,
}

impl Code {
    /// The code as it is written in reports and answers, in snake case.
    #[must_use]
    pub fn as_str(self) -> String {
        format!("{self:?}").chars().fold(String::new(), |mut text, letter| {
            if letter.is_uppercase() && !text.is_empty() {
                text.push('_');
            }
            text.push(letter.to_ascii_lowercase());
            text
        })
    }
}

/// One thing that a person or a program should know about an input, a plan or a program.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Finding {
    /// How much it weighs.
    pub severity: Severity,
    /// What it is.
    pub code: Code,
    /// Where: a JSON pointer into the job document (RFC 6901; empty for the whole), or `NAME:LINE` of a
    /// program or of a file that came with the job.
    pub at: String,
    /// What is wrong and by how much, in words and with units, and what to do next.
    pub message: String,
}

impl Finding {
    /// A finding that rules out a usable program.
    pub fn error(code: Code, at: impl Into<String>, message: impl Into<String>) -> Self {
        Self { severity: Severity::Error, code, at: at.into(), message: message.into() }
    }

    /// A finding at which a person should look.
    pub fn warning(code: Code, at: impl Into<String>, message: impl Into<String>) -> Self {
        Self { severity: Severity::Warning, code, at: at.into(), message: message.into() }
    }

    /// A finding said for completeness.
    pub fn info(code: Code, at: impl Into<String>, message: impl Into<String>) -> Self {
        Self { severity: Severity::Info, code, at: at.into(), message: message.into() }
    }

    /// Whether it rules out a usable program.
    #[must_use]
    pub fn is_error(&self) -> bool {
        self.severity == Severity::Error
    }
}

/// Whether any of the findings rules out a usable program.
#[must_use]
pub fn any_error(findings: &[Finding]) -> bool {
    findings.iter().any(Finding::is_error)
}

impl std::fmt::Display for Finding {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let severity = match self.severity {
            Severity::Info => "info",
            Severity::Warning => "warning",
            Severity::Error => "error",
        };
        let at = if self.at.is_empty() { "(whole document)" } else { &self.at };
        write!(f, "{severity}: {at}: {}: {}", self.code.as_str(), self.message)
    }
}
