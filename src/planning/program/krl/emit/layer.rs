//! Layers as guarded sections of lines.

use super::{path_speed, pose_words, trigger};
use crate::planning::program::krl::stem::Stem;
use crate::planning::program::robot_moves::{Layer, Purpose, RobotProgram, RobotSetup, RobotStep};

/// Lines around the statements of a section: a comment, IF and ENDIF.
const GUARD: usize = 3;

/// A layer, or a part of one, within its IF.
pub(super) struct Section {
    pub(super) lines: Vec<String>,
}

/// All layers as sections of at most `room` lines.
pub(super) fn sections(program: &RobotProgram, stem: &Stem, room: usize) -> Vec<Section> {
    let mut writer = Writer { setup: &program.setup, speed: None, wanted: false, output: Some(false) };
    let mut sections = Vec::new();
    for (index, layer) in program.layers.iter().enumerate() {
        let number = index + 1;
        let parts = writer.parts(layer, room - GUARD);
        let count = parts.len();
        for (part, statements) in parts.into_iter().enumerate() {
            let name = if count == 1 { String::new() } else { format!(", PART {} OF {count}", part + 1) };
            let mut lines =
                vec![format!(";LAYER {number}{name}"), format!("  IF {}<={number} THEN", stem.first_layer())];
            lines.extend(statements.iter().map(|statement| format!("    {statement}")));
            lines.push("  ENDIF".to_owned());
            sections.push(Section { lines });
        }
    }
    sections
}

/// What the control has been told so far.
#[derive(Clone)]
struct Writer<'a> {
    setup: &'a RobotSetup,
    /// In mm/s; `None` where a start in the middle may have left another.
    speed: Option<f64>,
    /// Whether the ultrasonic should be on in the next move.
    wanted: bool,
    /// Whether it is; `None` where a start in the middle may have left it otherwise.
    output: Option<bool>,
}

impl Writer<'_> {
    /// The statements of a layer in as few parts as hold `room` lines each. A part ends behind a cut, or behind
    /// any move where cuts lie too far apart.
    fn parts(&mut self, layer: &Layer, room: usize) -> Vec<Vec<String>> {
        // A start at this layer leaves out what earlier ones have switched on: only off is off either way.
        self.output = self.output.filter(|on| !on);
        let before = self.clone();
        self.speed = None;
        let whole = self.statements(&layer.steps);
        if whole.is_empty() {
            return Vec::new();
        }
        if whole.len() <= room {
            return vec![whole];
        }
        *self = before;
        let mut parts = Vec::new();
        let mut rest = &layer.steps[..];
        while !rest.is_empty() {
            self.speed = None;
            let fitting = self.fitting(rest, room);
            let statements = self.statements(&rest[..fitting]);
            if !statements.is_empty() {
                parts.push(statements);
            }
            rest = &rest[fitting..];
        }
        parts
    }

    /// How many of the steps the next part takes: at least one move, at most `room` lines.
    fn fitting(&self, steps: &[RobotStep], room: usize) -> usize {
        let mut trial = self.clone();
        let (mut lines, mut behind_move, mut behind_cut) = (0, 0, 0);
        for (index, step) in steps.iter().enumerate() {
            lines += trial.statements(std::slice::from_ref(step)).len();
            if lines > room && behind_move > 0 {
                return if behind_cut > 0 { behind_cut } else { behind_move };
            }
            if let RobotStep::Move { purpose, .. } = step {
                behind_move = index + 1;
                if *purpose == Purpose::Cut {
                    behind_cut = index + 1;
                }
            }
        }
        steps.len()
    }

    fn statements(&mut self, steps: &[RobotStep]) -> Vec<String> {
        let mut lines = Vec::new();
        for step in steps {
            match step {
                RobotStep::Ultrasonic { on } => self.wanted = *on,
                RobotStep::Move { to, purpose } => {
                    self.prepare(*purpose, &mut lines);
                    let blend = if *purpose == Purpose::Free { " C_DIS" } else { "" };
                    lines.push(format!("LIN {}{blend}", pose_words(to, self.setup.tool_direction)));
                }
            }
        }
        lines
    }

    /// The speed and the output that a move needs, where they are not so yet.
    fn prepare(&mut self, purpose: Purpose, lines: &mut Vec<String>) {
        let speeds = &self.setup.speeds;
        let speed = if purpose == Purpose::Cut { speeds.cutting_mm_s } else { speeds.travel_mm_s };
        if self.speed != Some(speed) {
            self.speed = Some(speed);
            lines.push(path_speed(speed));
        }
        if self.output != Some(self.wanted) {
            self.output = Some(self.wanted);
            lines.push(trigger(self.setup.ultrasonic_output, self.wanted));
        }
    }
}
