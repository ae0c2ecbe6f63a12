//! What the lines of a KRL program say, each for itself.

use std::ops::Range;

pub use super::fault::{At, Fault};

/// A line of a program.
#[derive(Debug, Clone, PartialEq)]
pub struct Line<'a> {
    /// Its number, from 1.
    pub number: usize,
    /// Its text, without its end.
    pub text: &'a str,
    /// The bytes of `text` that are the statement: without blanks around it, without its comment.
    pub span: Range<usize>,
    /// What it says, or why it cannot be told.
    pub statement: Result<Statement, Fault>,
}

/// A statement. Names in it are in upper case.
#[derive(Debug, Clone, PartialEq)]
pub enum Statement {
    /// A blank line or a comment.
    Nothing,
    /// A line for the file system of the control: `&ACCESS RVP`.
    Header,
    /// `DEF NAME ( )`.
    Def {
        /// The name.
        name: String,
        /// Whether it can be called from other files though it is not their first.
        global: bool,
        /// Whether it takes parameters.
        parameters: bool,
    },
    /// `END`.
    End,
    /// `DEFDAT NAME`.
    DefDat {
        /// The name.
        name: String,
    },
    /// `ENDDAT`.
    EndDat,
    /// `EXT`, `EXTFCT`: that a program is elsewhere.
    External,
    /// A declaration of variables.
    Declaration(Declaration),
    /// A motion.
    Move(Box<Motion>),
    /// `PLACE=VALUE`.
    Assignment(Box<Assignment>),
    /// `BAS (#COMMAND,VALUE )`.
    Bas {
        /// The command.
        command: At<String>,
        /// Its value.
        value: At<Expression>,
    },
    /// `TRIGGER WHEN DISTANCE=0 DELAY=0 DO $OUT[1]=TRUE`.
    Trigger {
        /// Which output, and what it becomes.
        output: Box<Assignment>,
    },
    /// `WAIT SEC VALUE`.
    Wait {
        /// In s.
        seconds: At<Expression>,
    },
    /// `HALT`.
    Halt,
    /// `IF ... THEN`.
    If(Box<Condition>),
    /// `ELSE`.
    Else,
    /// `ENDIF`.
    EndIf,
    /// `RETURN`.
    Return,
    /// A statement that is known and moves nothing, now or later: the interrupt of the INI fold, `CONTINUE`.
    Idle,
    /// `NAME ( )`.
    Call {
        /// The name.
        name: At<String>,
        /// Whether it is given values.
        arguments: bool,
    },
}

/// A declaration of variables of one type.
#[derive(Debug, Clone, PartialEq)]
pub struct Declaration {
    /// Whether all files see them.
    pub global: bool,
    /// The variables: their place, and their first value if it stands there.
    pub variables: Vec<(Place, Option<At<Value>>)>,
}

/// A motion.
#[derive(Debug, Clone, PartialEq)]
pub struct Motion {
    /// Along which way.
    pub way: Way,
    /// From where its target counts.
    pub from: Origin,
    /// Where it goes.
    pub target: At<Target>,
    /// Whether its end may be rounded off.
    pub blend: bool,
}

/// Along which way a motion goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Way {
    /// LIN, SLIN: the tool goes straight.
    Line,
    /// PTP, SPTP: all joints go together.
    Joint,
}

/// From where the target of a motion counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Origin {
    /// From the origin of the base frame.
    Base,
    /// From where the tool stands, along the axes of the base frame.
    HereAlongBase,
    /// From where the tool stands, along its own axes.
    HereAlongTool,
}

/// Where a motion goes.
#[derive(Debug, Clone, PartialEq)]
pub enum Target {
    /// Written out.
    Written(Aggregate),
    /// In a variable.
    Named(Place),
    /// Where the arm stands.
    Here,
}

/// `{TYPE: NAME VALUE, ...}`.
#[derive(Debug, Clone, PartialEq)]
pub struct Aggregate {
    /// The type before the colon.
    pub kind: Option<String>,
    /// The components in the order in which they stand.
    pub components: Vec<(At<String>, At<Value>)>,
}

/// A value that stands in the text.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// A whole number, also from `'B010'`.
    Whole(i64),
    /// A number with a point.
    Real(f64),
    /// TRUE, FALSE.
    Truth(bool),
    /// `#NAME`.
    Word(String),
    /// A text, or something whose meaning nothing here depends on.
    Other,
    /// Several values under names.
    Aggregate(Aggregate),
}

/// A value or where to find it.
#[derive(Debug, Clone, PartialEq)]
pub enum Expression {
    /// It stands here.
    Value(Value),
    /// It stands in a variable.
    Place(Place),
}

/// A variable, or a part of one: `NAME[1].FIELD`.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Place {
    /// The name.
    pub name: String,
    /// The index.
    pub index: Option<i64>,
    /// The component.
    pub field: Option<String>,
}

/// `PLACE=VALUE`.
#[derive(Debug, Clone, PartialEq)]
pub struct Assignment {
    /// What gets the value.
    pub place: At<Place>,
    /// The value.
    pub value: At<Expression>,
}

/// Two values compared.
#[derive(Debug, Clone, PartialEq)]
pub struct Condition {
    /// The one before the sign.
    pub left: At<Expression>,
    /// The sign.
    pub relation: Relation,
    /// The one behind it.
    pub right: At<Expression>,
}

/// How two values are compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Relation {
    /// `==`
    Equal,
    /// `<>`
    Different,
    /// `<`
    Less,
    /// `<=`
    LessOrEqual,
    /// `>`
    Greater,
    /// `>=`
    GreaterOrEqual,
}

impl Value {
    /// The number that it is, if it is one.
    #[must_use]
    pub fn number(&self) -> Option<f64> {
        match self {
            // Whole numbers in programs are far below 2^53; larger ones are no robot's anyway.
            Self::Whole(value) => Some(*value as f64),
            Self::Real(value) => Some(*value),
            _ => None,
        }
    }
}

impl Declaration {
    /// Whether a variable gets a value that counts here.
    #[must_use]
    pub fn has_values(&self) -> bool {
        self.variables
            .iter()
            .any(|(_, value)| value.as_ref().is_some_and(|value| value.value != Value::Other))
    }
}

impl Relation {
    /// Whether it holds between two whole numbers.
    #[must_use]
    pub fn holds(self, left: i64, right: i64) -> bool {
        match self {
            Self::Equal => left == right,
            Self::Different => left != right,
            Self::Less => left < right,
            Self::LessOrEqual => left <= right,
            Self::Greater => left > right,
            Self::GreaterOrEqual => left >= right,
        }
    }
}

impl Line<'_> {
    /// Whether the line begins with a word that moves the robot, readable or not.
    #[must_use]
    pub fn is_motion(&self) -> bool {
        matches!(self.statement, Ok(Statement::Move(_))) || super::words::is_motion(self.first_word())
    }

    /// Whether the line decides which lines come next, readable or not.
    #[must_use]
    pub fn is_branch(&self) -> bool {
        let branches = [Ok(Statement::Else), Ok(Statement::EndIf), Ok(Statement::Return)];
        matches!(self.statement, Ok(Statement::If(_)))
            || branches.contains(&self.statement)
            || self.first_word().eq_ignore_ascii_case("IF")
            || super::words::is_branch(self.first_word())
    }

    /// The first word of the statement as written; empty if there is none.
    #[must_use]
    pub fn first_word(&self) -> &str {
        let code = &self.text[self.span.clone()];
        let end = code.find(|letter: char| !letter.is_ascii_alphanumeric() && letter != '_' && letter != '$');
        &code[..end.unwrap_or(code.len())]
    }
}
