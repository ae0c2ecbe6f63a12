//! The run of a program, from the first line of its main file.

use super::machine::{Machine, Spot};
use super::memory::Memory;
use super::program::{Program, Routine, column};
use super::settings::Context;
use super::statement::{At, Condition, Fault, Line, Statement, Value};
use super::unreadable;
use crate::planning::finding::Finding;
use crate::planning::program::robot_events::{RobotEvent, RobotExecuted};

/// Programs call each other no deeper.
const DEEPEST: usize = 16;

/// Runs a program, at most so many of its statements.
///
/// # Errors
/// The first statement that cannot be carried out.
pub(super) fn run(program: &Program<'_>, main: &str, most: usize) -> Result<Vec<RobotExecuted>, Finding> {
    let Some(file) = program.files.iter().position(|file| file.name.eq_ignore_ascii_case(main)) else {
        return Err(unreadable(main, 1, 1, "there is no file of this name"));
    };
    let Some(routine) = program.routines.iter().find(|routine| routine.file == file) else {
        return Err(unreadable(main, 1, 1, "a data list does nothing by itself"));
    };
    let mut run = Run {
        program,
        memory: Memory::default(),
        machine: Machine::new(),
        calls: Vec::new(),
        left: most,
        most,
    };
    run.load()?;
    run.call(routine)?;
    run.check_waiting()?;
    Ok(run.machine.events)
}

struct Run<'a> {
    program: &'a Program<'a>,
    memory: Memory,
    machine: Machine,
    /// The programs that wait for one another, the main one first.
    calls: Vec<&'a Routine>,
    /// How many statements may still be run, of `most`.
    left: usize,
    most: usize,
}

/// What comes after a statement.
enum Next {
    /// The next line.
    Line,
    /// The line with this index.
    Index(usize),
    /// The end of the program.
    End,
}

impl<'a> Run<'a> {
    /// Takes over the values of all data lists.
    fn load(&mut self) -> Result<(), Finding> {
        for (file, list) in self.program.files.iter().enumerate().filter(|(_, file)| file.data) {
            for line in &list.lines {
                let done = match &line.statement {
                    Ok(Statement::Declaration(declaration)) => {
                        self.memory.declare(&list.module, declaration);
                        Ok(())
                    }
                    Ok(Statement::Assignment(assignment)) => {
                        let spot = Spot { file, line: line.number };
                        let context = Context { spot, module: &list.module, memory: &mut self.memory };
                        context.value(&assignment.value).and_then(|value| {
                            let At { column, value: place } = &assignment.place;
                            context
                                .memory
                                .set(context.module, place, value)
                                .map_err(|message| Fault::new(*column, message))
                        })
                    }
                    _ => Ok(()),
                };
                done.map_err(|fault| unreadable(list.name, line.number, fault.column, fault.message))?;
            }
        }
        Ok(())
    }

    fn call(&mut self, routine: &'a Routine) -> Result<(), Finding> {
        self.calls.push(routine);
        let file = &self.program.files[routine.file];
        let mut index = routine.start;
        while let Some(line) = file.lines.get(index) {
            let next = self.step(routine, index, line).map_err(|stop| match stop {
                Stop::Here(fault) => unreadable(file.name, line.number, fault.column, fault.message),
                Stop::Within(finding) => finding,
            })?;
            index = match next {
                Next::Line => index + 1,
                Next::Index(index) => index,
                Next::End => break,
            };
        }
        self.calls.pop();
        Ok(())
    }

    fn step(&mut self, routine: &'a Routine, index: usize, line: &'a Line<'a>) -> Result<Next, Stop> {
        let Ok(statement) = &line.statement else { return Ok(Next::Line) };
        self.count(line)?;
        let spot = Spot { file: routine.file, line: line.number };
        let file = &self.program.files[routine.file];
        let mut context = Context { spot, module: &file.module, memory: &mut self.memory };
        let jump = || file.jumps.get(&index).map_or(Next::Line, |next| Next::Index(*next));
        match statement {
            Statement::Declaration(declaration) => context.memory.declare(context.module, declaration),
            Statement::Move(motion) => {
                self.machine.go(motion, spot, column(line), context.memory, context.module)?;
            }
            Statement::Assignment(assignment) => self.machine.assign(assignment, &mut context)?,
            Statement::Bas { command, value } => self.machine.bas(command, value, &context)?,
            Statement::Trigger { output } => self.machine.trigger(output, &context)?,
            Statement::Wait { seconds } => {
                let seconds = context.number(seconds)?;
                self.dwell(spot, seconds, line)?;
            }
            Statement::Halt => self.machine.event(spot, RobotEvent::Halt),
            Statement::If(condition) if !holds(condition, &context)? => return Ok(jump()),
            Statement::Else => return Ok(jump()),
            Statement::Call { name, arguments } => {
                let called = self.find(routine, &name.value, *arguments);
                let called = called.map_err(|message| Fault::new(name.column, message))?;
                self.call(called).map_err(Stop::Within)?;
            }
            Statement::End | Statement::Return => {
                if self.calls.len() == 1 {
                    self.machine.event(spot, RobotEvent::End);
                }
                return Ok(Next::End);
            }
            _ => {}
        }
        Ok(Next::Line)
    }

    fn count(&mut self, line: &Line<'_>) -> Result<(), Fault> {
        if self.left == 0 {
            let message = format!("the program does more than {} things", self.most);
            return Err(Fault::new(column(line), message));
        }
        self.left -= 1;
        Ok(())
    }

    fn dwell(&mut self, spot: Spot, seconds: f64, line: &Line<'_>) -> Result<(), Fault> {
        if seconds < 0.0 {
            return Err(Fault::new(column(line), "a wait is not negative"));
        }
        self.machine.event(spot, RobotEvent::Dwell { seconds });
        Ok(())
    }

    /// The program that a call means: one of the same file, or one that all files see.
    fn find(&self, caller: &Routine, name: &str, arguments: bool) -> Result<&'a Routine, String> {
        let of_name = || self.program.routines.iter().filter(|routine| routine.name == name);
        let found = of_name()
            .find(|routine| routine.file == caller.file)
            .or_else(|| of_name().find(|one| one.global));
        let Some(found) = found else {
            return Err(format!("what {name} does is not known: it is in none of the files of this program"));
        };
        if arguments || found.parameters {
            return Err(format!("{name} is called with values, which this reader does not follow"));
        }
        if self.calls.contains(&found) {
            return Err(format!("{name} calls itself, by itself or through others"));
        }
        if self.calls.len() == DEEPEST {
            return Err(format!("programs call each other more than {DEEPEST} deep"));
        }
        Ok(found)
    }

    /// Whatever waits for a motion at the end waits for ever.
    fn check_waiting(&self) -> Result<(), Finding> {
        let Some(waiting) = self.machine.waiting.first() else { return Ok(()) };
        let name = self.program.files[waiting.spot.file].name;
        let message = "no motion follows with which this output could change";
        Err(unreadable(name, waiting.spot.line, waiting.column, message))
    }
}

/// Why a run stops.
enum Stop {
    /// At the line itself.
    Here(Fault),
    /// Somewhere in a program that it calls.
    Within(Finding),
}

impl From<Fault> for Stop {
    fn from(fault: Fault) -> Self {
        Self::Here(fault)
    }
}

fn holds(condition: &Condition, context: &Context<'_>) -> Result<bool, Fault> {
    let whole = |expression| match context.value(expression)? {
        Value::Whole(value) => Ok(value),
        _ => Err(Fault::new(expression.column, "only whole numbers are compared here")),
    };
    Ok(condition.relation.holds(whole(&condition.left)?, whole(&condition.right)?))
}
