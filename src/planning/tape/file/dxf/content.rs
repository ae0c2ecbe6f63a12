//! What of a DXF file matters here: its unit, its blocks and its entities.

use std::collections::BTreeMap;

use super::super::faults::{Fault, Faults};
use super::pair::{Pair, Record, Records};
use crate::planning::document::shape::quoted;
use crate::planning::finding::Code;

/// An entity with the records that belong to it.
#[derive(Debug)]
pub struct Entity<'a> {
    /// The entity itself.
    pub record: Record<'a>,
    /// The vertices of a polyline, the attributes of an insert.
    pub parts: Vec<Record<'a>>,
}

/// What a block draws.
#[derive(Debug, Default)]
pub struct Block<'a> {
    /// Its beginning, with the point that an insert puts to its place.
    pub record: Option<Record<'a>>,
    /// In the order of the file.
    pub entities: Vec<Entity<'a>>,
}

/// What of a DXF file matters here.
#[derive(Debug, Default)]
pub struct Content<'a> {
    /// The value of `$INSUNITS`.
    pub units: Option<Pair<'a>>,
    /// By the name of the block, in capitals.
    pub blocks: BTreeMap<String, Block<'a>>,
    /// In the order of the file.
    pub entities: Vec<Entity<'a>>,
}

/// The sections that DXF has. One that is not known might hold outlines.
const SECTIONS: [&str; 8] =
    ["HEADER", "CLASSES", "TABLES", "BLOCKS", "ENTITIES", "OBJECTS", "THUMBNAILIMAGE", "ACDSDATA"];

/// A layer's name as it is compared: CAD systems do not tell capitals from small letters.
#[must_use]
pub fn layer_key(name: &str) -> String {
    name.to_uppercase()
}

/// The layer of a record; without one it is 0.
#[must_use]
pub fn layer_of<'a>(record: &Record<'a>) -> &'a str {
    value(record, 8).unwrap_or("0")
}

/// Whether a record belongs to the paper, not to the drawing.
#[must_use]
pub fn is_on_paper(record: &Record<'_>) -> bool {
    value(record, 67) == Some("1")
}

/// Whether a record is not shown.
#[must_use]
pub fn is_invisible(record: &Record<'_>) -> bool {
    value(record, 60) == Some("1")
}

/// The value of the first pair of a code.
#[must_use]
pub fn value<'a>(record: &Record<'a>, code: i32) -> Option<&'a str> {
    record.pairs.iter().find(|pair| pair.code == code).map(|pair| pair.value)
}

/// Where the reader stands.
struct Walk<'a> {
    content: Content<'a>,
    section: Option<&'a str>,
    /// The name of the block that is being read.
    block: Option<String>,
    /// A polyline, or an insert with attributes, whose parts are being read.
    open: Option<Entity<'a>>,
    ended: bool,
}

/// Reads the structure of a DXF file.
///
/// # Errors
/// Nothing is given back of a file that ends too early, has something outside its sections, or is no pairs of lines.
pub fn read<'a>(text: &'a str, faults: &mut Faults<'_>) -> Option<Content<'a>> {
    let mut records = Records::of(text);
    let mut walk = Walk { content: Content::default(), section: None, block: None, open: None, ended: false };
    for record in records.by_ref() {
        let taken = record.and_then(|record| walk.take(record));
        if let Err(fault) = taken {
            faults.push(fault);
            return None;
        }
        if walk.ended {
            break;
        }
    }
    if let Some(line) = records.left_over() {
        faults.push(Fault::new(Code::UnreadableFile, line, "the file goes on after its end (EOF)"));
    } else if !walk.ended {
        let last = u32::try_from(text.split('\n').count()).unwrap_or(u32::MAX);
        let message = if text.trim().is_empty() {
            "the file is empty"
        } else {
            "the file ends without EOF; it may be cut short"
        };
        faults.push(Fault::new(Code::UnreadableFile, last, message));
    }
    Some(walk.content).filter(|_| walk.ended)
}

impl<'a> Walk<'a> {
    fn take(&mut self, record: Record<'a>) -> Result<(), Fault> {
        match record.kind {
            "SECTION" => self.begin(&record),
            "ENDSEC" | "EOF" => self.end(&record),
            _ => match self.section {
                Some("ENTITIES") => self.take_entity(record),
                Some("BLOCKS") => self.take_block(record),
                Some(_) => Ok(()),
                None => {
                    let message = format!("{} stands outside every section", quoted(record.kind));
                    Err(Fault::new(Code::UnreadableFile, record.line, message))
                }
            },
        }
    }

    fn begin(&mut self, record: &Record<'a>) -> Result<(), Fault> {
        let name = value(record, 2).unwrap_or_default();
        if self.section.is_some() {
            let message = "a section begins before the one before has ended";
            return Err(Fault::new(Code::UnreadableFile, record.line, message));
        }
        if !SECTIONS.contains(&name) {
            let message = format!("the section {} is not understood", quoted(name));
            return Err(Fault::new(Code::NotSupported, record.line, message));
        }
        if name == "HEADER" {
            let variable = record.pairs.windows(2).find(|pair| pair[0].value == "$INSUNITS");
            self.content.units = variable.map(|pair| pair[1]);
        }
        self.section = Some(name);
        Ok(())
    }

    fn end(&mut self, record: &Record<'a>) -> Result<(), Fault> {
        self.refuse_open()?;
        if (record.kind == "EOF") == self.section.is_some() {
            let message = match self.section {
                Some(name) => format!("the file ends within the section {name}"),
                None => "a section ends that has not begun".to_owned(),
            };
            return Err(Fault::new(Code::UnreadableFile, record.line, message));
        }
        self.ended = record.kind == "EOF";
        (self.section, self.block) = (None, None);
        Ok(())
    }

    fn refuse_open(&self) -> Result<(), Fault> {
        let Some(open) = &self.open else { return Ok(()) };
        let message = format!("the {} that begins here has no SEQEND", open.record.kind);
        Err(Fault::new(Code::UnreadableFile, open.record.line, message))
    }

    fn take_entity(&mut self, record: Record<'a>) -> Result<(), Fault> {
        match record.kind {
            "VERTEX" | "ATTRIB" if self.open.is_some() => {
                if let Some(open) = &mut self.open {
                    open.parts.push(record);
                }
            }
            "SEQEND" => {
                let ended = self.open.take();
                self.list().extend(ended);
            }
            _ => {
                self.refuse_open()?;
                let has_parts = record.kind == "POLYLINE"
                    || record.kind == "INSERT" && value(&record, 66).is_some_and(|flag| flag != "0");
                let entity = Entity { record, parts: Vec::new() };
                if has_parts { self.open = Some(entity) } else { self.list().push(entity) }
            }
        }
        Ok(())
    }

    /// Where the next entity belongs: to the block that is being read, else to the drawing.
    fn list(&mut self) -> &mut Vec<Entity<'a>> {
        match self.block.as_ref().and_then(|name| self.content.blocks.get_mut(name)) {
            Some(block) => &mut block.entities,
            None => &mut self.content.entities,
        }
    }

    fn take_block(&mut self, record: Record<'a>) -> Result<(), Fault> {
        match record.kind {
            "BLOCK" => {
                self.refuse_open()?;
                let name = value(&record, 2).unwrap_or_default().to_uppercase();
                if let Some(first) = self.content.blocks.get(&name).and_then(|block| block.record.as_ref()) {
                    let words =
                        format!("the block {} is there twice, first at line {}", quoted(&name), first.line);
                    return Err(Fault::new(Code::NotSupported, record.line, words));
                }
                let block = Block { record: Some(record), entities: Vec::new() };
                self.content.blocks.insert(name.clone(), block);
                self.block = Some(name);
                Ok(())
            }
            "ENDBLK" => {
                self.refuse_open()?;
                self.block = None;
                Ok(())
            }
            _ if self.block.is_some() => self.take_entity(record),
            _ => Ok(()),
        }
    }
}
