//! The files of a program: their lines, the programs in them, and where each IF goes on.

use std::collections::BTreeMap;

use super::statement::{Declaration, Line, Statement};
use super::{MOST_FAULTS, parse, unreadable};
use crate::planning::finding::{Code, Finding};
use crate::planning::outcome::ProgramFile;

/// A file of a program.
pub(super) struct File<'a> {
    pub(super) name: &'a str,
    /// The name without its extension, in upper case: programs and data lists of one stem belong together.
    pub(super) module: String,
    pub(super) lines: Vec<Line<'a>>,
    /// Whether it is a data list.
    pub(super) data: bool,
    /// For the index of each IF whose condition fails, and of each ELSE that is reached: where to go on.
    pub(super) jumps: BTreeMap<usize, usize>,
}

/// A program within a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Routine {
    /// Index of the file.
    pub(super) file: usize,
    pub(super) name: String,
    /// Whether other files may call it.
    pub(super) global: bool,
    /// Whether it takes parameters.
    pub(super) parameters: bool,
    /// Index of the line behind DEF.
    pub(super) start: usize,
}

/// All files with their programs.
pub(super) struct Program<'a> {
    pub(super) files: Vec<File<'a>>,
    pub(super) routines: Vec<Routine>,
}

impl<'a> Program<'a> {
    /// Reads all files.
    ///
    /// # Errors
    /// All lines that cannot be read or stand where they must not, up to [`MOST_FAULTS`].
    pub(super) fn of(files: &'a [ProgramFile]) -> Result<Self, Vec<Finding>> {
        let mut faults = Vec::new();
        let mut program = Self { files: Vec::new(), routines: Vec::new() };
        for (index, file) in files.iter().enumerate() {
            let lines = parse::statements(&file.text);
            let mut outline = Outline::new(&file.name, index, &mut faults);
            outline.walk(&lines);
            let Outline { routines, jumps, data, .. } = outline;
            program.routines.extend(routines);
            program.files.push(File { name: &file.name, module: module_of(&file.name), lines, data, jumps });
            if faults.len() > MOST_FAULTS {
                break;
            }
        }
        if faults.is_empty() { Ok(program) } else { Err(at_most(faults)) }
    }
}

fn at_most(mut faults: Vec<Finding>) -> Vec<Finding> {
    if faults.len() > MOST_FAULTS {
        faults.truncate(MOST_FAULTS);
        let at = faults[MOST_FAULTS - 1].at.clone();
        let message = format!("{MOST_FAULTS} lines refused; what follows was not read");
        faults.push(Finding::error(Code::UnreadableProgram, at, message));
    }
    faults
}

/// A file name without its extension, in upper case.
pub(super) fn module_of(name: &str) -> String {
    name.rsplit_once('.').map_or(name, |(stem, _)| stem).to_ascii_uppercase()
}

/// Within what a line stands.
#[derive(Clone, Copy, PartialEq)]
enum Within {
    /// No program so far, or after the end of one.
    Nothing,
    /// A program, before its first instruction.
    Declarations,
    /// A program, after its first instruction.
    Instructions,
    /// A data list.
    Data,
    /// After the end of a data list.
    AfterData,
}

/// An IF or an ELSE.
struct Open {
    index: usize,
    line: usize,
    column: usize,
    is_else: bool,
}

/// A walk over the lines of a file.
struct Outline<'a> {
    name: &'a str,
    file: usize,
    within: Within,
    data: bool,
    routines: Vec<Routine>,
    /// The IF and ELSE that are still open.
    open: Vec<Open>,
    jumps: BTreeMap<usize, usize>,
    faults: &'a mut Vec<Finding>,
}

impl<'a> Outline<'a> {
    fn new(name: &'a str, file: usize, faults: &'a mut Vec<Finding>) -> Self {
        let (routines, open, jumps) = (Vec::new(), Vec::new(), BTreeMap::new());
        Self { name, file, within: Within::Nothing, data: false, routines, open, jumps, faults }
    }

    fn walk(&mut self, lines: &[Line<'_>]) {
        for (index, line) in lines.iter().enumerate() {
            if self.faults.len() > MOST_FAULTS {
                return;
            }
            match &line.statement {
                Err(fault) => {
                    self.fault(line.number, fault.column, fault.message.clone());
                    self.take_unread(index, line);
                }
                Ok(statement) => {
                    if let Err(message) = self.take(index, line, statement) {
                        self.fault(line.number, column(line), message);
                    }
                }
            }
        }
        self.check_end(lines.len().max(1));
    }

    fn fault(&mut self, line: usize, column: usize, message: String) {
        self.faults.push(unreadable(self.name, line, column, message));
    }

    fn take(&mut self, index: usize, line: &Line<'_>, statement: &Statement) -> Result<(), String> {
        match statement {
            Statement::Nothing => Ok(()),
            Statement::Header => self.header(),
            Statement::Def { name, global, parameters } => self.define(index, name, *global, *parameters),
            Statement::End => self.end(),
            Statement::DefDat { name } => self.define_data(name),
            Statement::EndDat => self.end_data(),
            Statement::Declaration(declaration) => self.declare(Some(declaration)),
            Statement::External => self.declare(None),
            Statement::Assignment(_) if self.within == Within::Data => Ok(()),
            Statement::If(_) => {
                self.instruct()?;
                self.open_if(index, line, false);
                Ok(())
            }
            Statement::Else | Statement::EndIf => {
                self.instruct()?;
                self.close_if(index, line, *statement == Statement::Else)
            }
            _ => self.instruct(),
        }
    }

    /// What begins something is taken as its beginning though it cannot be read, so that its end is no fault too.
    fn take_unread(&mut self, index: usize, line: &Line<'_>) {
        let first = line.first_word();
        if first.eq_ignore_ascii_case("IF") {
            self.open_if(index, line, false);
        } else if first.eq_ignore_ascii_case("DEF") {
            // A fault of its name too would be a second one of the same line.
            let _ = self.define(index, &module_of(self.name), false, false);
        } else if first.eq_ignore_ascii_case("DEFDAT") {
            let _ = self.define_data(&module_of(self.name));
        }
    }

    fn header(&self) -> Result<(), String> {
        match self.within {
            Within::Nothing if self.routines.is_empty() => Ok(()),
            _ => Err("& lines stand at the head of a file".to_owned()),
        }
    }

    fn define(&mut self, index: usize, name: &str, global: bool, parameters: bool) -> Result<(), String> {
        if self.within != Within::Nothing {
            return Err("END is missing before this".to_owned());
        }
        self.within = Within::Declarations;
        let first = self.routines.is_empty();
        self.routines.push(Routine {
            file: self.file,
            name: name.to_owned(),
            global: first || global,
            parameters,
            start: index + 1,
        });
        if first && module_of(self.name) != name {
            return Err(format!("a control finds no program {name} in a file of the name {}", self.name));
        }
        Ok(())
    }

    fn define_data(&mut self, name: &str) -> Result<(), String> {
        if self.within != Within::Nothing || !self.routines.is_empty() {
            return Err("a data list has a file of its own".to_owned());
        }
        self.within = Within::Data;
        self.data = true;
        if module_of(self.name) != name {
            return Err(format!("a control finds no data list {name} in a file of the name {}", self.name));
        }
        Ok(())
    }

    fn end(&mut self) -> Result<(), String> {
        if !matches!(self.within, Within::Declarations | Within::Instructions) {
            return Err("END ends nothing here".to_owned());
        }
        self.within = Within::Nothing;
        for open in std::mem::take(&mut self.open) {
            self.fault(open.line, open.column, "ENDIF is missing before END".to_owned());
        }
        Ok(())
    }

    fn end_data(&mut self) -> Result<(), String> {
        if self.within != Within::Data {
            return Err("ENDDAT ends nothing here".to_owned());
        }
        self.within = Within::AfterData;
        Ok(())
    }

    fn declare(&self, declaration: Option<&Declaration>) -> Result<(), String> {
        let has_values = declaration.is_some_and(Declaration::has_values);
        match self.within {
            Within::Declarations if has_values => Err("a first value stands in a data list only".to_owned()),
            Within::Declarations | Within::Data => Ok(()),
            Within::Instructions => Err("declarations stand before the first instruction".to_owned()),
            Within::Nothing | Within::AfterData => Err("this stands in no program".to_owned()),
        }
    }

    fn instruct(&mut self) -> Result<(), String> {
        match self.within {
            Within::Declarations | Within::Instructions => {
                self.within = Within::Instructions;
                Ok(())
            }
            Within::Data => Err("a data list holds values only".to_owned()),
            Within::Nothing | Within::AfterData => Err("this stands in no program".to_owned()),
        }
    }

    fn open_if(&mut self, index: usize, line: &Line<'_>, is_else: bool) {
        self.open.push(Open { index, line: line.number, column: column(line), is_else });
    }

    /// A failed IF goes on behind its ELSE or ENDIF; an ELSE that is reached goes on behind the ENDIF.
    fn close_if(&mut self, index: usize, line: &Line<'_>, by_else: bool) -> Result<(), String> {
        let Some(open) = self.open.pop() else {
            return Err("there is no IF to which this belongs".to_owned());
        };
        if by_else && open.is_else {
            self.open.push(open);
            return Err("the IF to which this belongs has an ELSE".to_owned());
        }
        self.jumps.insert(open.index, index + 1);
        if by_else {
            self.open_if(index, line, true);
        }
        Ok(())
    }

    fn check_end(&mut self, last: usize) {
        let message = match self.within {
            Within::Declarations | Within::Instructions => {
                "the text stops without END: the file may be cut short"
            }
            Within::Data => "the text stops without ENDDAT: the file may be cut short",
            Within::Nothing if self.routines.is_empty() => "there is no program in this text",
            Within::Nothing | Within::AfterData => return,
        };
        self.faults.push(Finding::error(Code::NoProgramEnd, format!("{}:{last}:1", self.name), message));
    }
}

/// The column of a statement, from 1. What stands before it is blanks.
pub(super) fn column(line: &Line<'_>) -> usize {
    line.span.start + 1
}
