//! Blocks, drawn where they are inserted.

use nalgebra::{Matrix2, Vector2};

use super::content::{Block, Content, Entity, is_invisible, is_on_paper, layer_of, value};
use super::curve::described;
use super::fields::Fields;
use crate::planning::document::shape::quoted;
use crate::planning::finding::Code;
use crate::planning::geometry::{Point3, Vector3};
use crate::planning::tape::file::faults::{Fault, Faults};

/// An entity where it is drawn.
#[derive(Debug, Clone, Copy)]
pub struct Placed<'a> {
    /// The entity.
    pub entity: &'a Entity<'a>,
    /// Its layer; what stands on layer 0 of a block has that of its insert.
    pub layer: &'a str,
    /// Where.
    pub placing: Placing,
    /// The insert of the drawing that it comes from.
    pub insert: Option<&'a Entity<'a>>,
}

/// How what is drawn comes to its place: it is scaled, turned or mirrored, and moved.
#[derive(Debug, Clone, Copy)]
pub struct Placing {
    /// mm per unit of what is placed.
    pub scale: f64,
    turn: Matrix2<f64>,
    /// In mm.
    offset: Vector3,
}

/// Blocks within blocks, at the most.
const DEEPEST: usize = 16;
/// Entities of all inserts, at the most: a few lines of blocks within blocks can ask for any number.
const MOST_PLACED: usize = 1_000_000;
/// Scales whose difference is a smaller share of them are one scale.
const SAME_SCALE: f64 = 1e-9;

impl Placing {
    /// Of a drawing of so many mm per unit.
    #[must_use]
    pub fn of_drawing(scale: f64) -> Self {
        Self { scale, turn: Matrix2::identity(), offset: Vector3::zeros() }
    }

    /// Where a point comes to, which is scaled already.
    #[must_use]
    pub fn place(&self, point: &Point3) -> Point3 {
        let turned = self.turn * Vector2::new(point.x, point.y);
        Point3::new(turned.x, turned.y, point.z) + self.offset
    }

    /// Of a block that is inserted into what is placed like this.
    ///
    /// # Errors
    /// What the insert says is no number, leans, or cannot be followed by curves that stay what they are.
    fn inserted(&self, insert: &Entity<'_>, block: &Block<'_>) -> Result<Self, Fault> {
        let fields = Fields::of(&insert.record, 1.0);
        let unsupported =
            |words: &str| Err(fields.fault(Code::NotSupported, format!("{words}; explode the block")));
        if fields.flags(70)?.max(fields.flags(71)?) > 1 {
            return unsupported("it inserts its block in rows or columns");
        }
        let [x, y] = [fields.number(41)?.unwrap_or(1.0), fields.number(42)?.unwrap_or(1.0)];
        if x == 0.0 || (x.abs() - y.abs()).abs() > SAME_SCALE * x.abs() {
            return unsupported(&format!("it scales its block by {x} along x and {y} along y"));
        }
        let side = fields.side()?;
        let (sin, cos) = fields.number(50)?.unwrap_or(0.0).to_radians().sin_cos();
        let at = fields.point([10, 20, 30])?;
        let base = match &block.record {
            Some(record) => {
                let fields = Fields::of(record, 1.0);
                let [x, y, z] = [10, 20, 30].map(|code| fields.optional_length(code));
                Point3::new(x?, y?, z?)
            }
            None => Point3::origin(),
        };
        let from_above = Matrix2::new(side, 0.0, 0.0, 1.0);
        let turn =
            from_above * Matrix2::new(cos, -sin, sin, cos) * Matrix2::new(x.signum(), 0.0, 0.0, y.signum());
        let moved = from_above * Vector2::new(at.x, at.y) - turn * Vector2::new(base.x, base.y) * x.abs();
        let moved = self.turn * moved * self.scale;
        let up = (at.z * side - base.z * x.abs()) * self.scale;
        Ok(Self {
            scale: self.scale * x.abs(),
            turn: self.turn * turn,
            offset: self.offset + Vector3::new(moved.x, moved.y, up),
        })
    }
}

/// All entities of a drawing where they are drawn. Inserts that `draws` says no of stay what they are.
pub fn placed<'a>(
    content: &'a Content<'a>,
    scale: f64,
    draws: impl Fn(&Entity<'a>) -> bool,
    faults: &mut Faults<'_>,
) -> Vec<Placed<'a>> {
    let mut expansion = Expansion { content, draws, placed: Vec::new(), faults };
    for entity in &content.entities {
        let placing = Placing::of_drawing(scale);
        expansion.take(Placed { entity, layer: layer_of(&entity.record), placing, insert: None }, 0);
    }
    expansion.placed
}

struct Expansion<'a, 'f, 'n, D> {
    content: &'a Content<'a>,
    draws: D,
    placed: Vec<Placed<'a>>,
    faults: &'f mut Faults<'n>,
}

impl<'a, D: Fn(&Entity<'a>) -> bool> Expansion<'a, '_, '_, D> {
    fn take(&mut self, placed: Placed<'a>, depth: usize) {
        let Placed { entity, layer, placing, insert } = placed;
        if entity.record.kind != "INSERT" || is_on_paper(&entity.record) || !(self.draws)(entity) {
            if self.placed.len() < MOST_PLACED {
                self.placed.push(placed);
            }
            return;
        }
        match self.inside(entity, &placing, depth) {
            Err(fault) => self.faults.push(fault),
            Ok((block, inner)) => {
                for part in &block.entities {
                    let own = layer_of(&part.record);
                    let layer = if own == "0" { layer } else { own };
                    let insert = insert.or(Some(entity));
                    self.take(Placed { entity: part, layer, placing: inner, insert }, depth + 1);
                    if self.placed.len() >= MOST_PLACED {
                        return;
                    }
                }
            }
        }
    }

    /// The block that an insert draws, and how.
    fn inside(
        &self,
        insert: &Entity<'a>,
        placing: &Placing,
        depth: usize,
    ) -> Result<(&'a Block<'a>, Placing), Fault> {
        let record = &insert.record;
        let fault = |code, words: String| {
            Err(Fault::new(code, record.line, format!("{}: {words}", described(record))))
        };
        let name = value(record, 2).unwrap_or_default();
        if is_invisible(record) {
            return fault(Code::NotSupported, "it is invisible; show or delete it".to_owned());
        }
        if depth >= DEEPEST {
            let words =
                format!("blocks within blocks, deeper than {DEEPEST}: see whether one inserts itself");
            return fault(Code::NotSupported, words);
        }
        if self.placed.len() + 1 >= MOST_PLACED {
            let words = format!("the blocks of the drawing come to more than {MOST_PLACED} entities");
            return fault(Code::NotSupported, words);
        }
        match self.content.blocks.get(&name.to_uppercase()) {
            None => fault(Code::UnknownValue, format!("there is no block {} in the file", quoted(name))),
            Some(block) => Ok((block, placing.inserted(insert, block)?)),
        }
    }
}
