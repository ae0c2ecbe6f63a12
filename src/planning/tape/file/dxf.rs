//! Outlines of flat plies from ASCII DXF drawings (docs/files.md says what is read and what is refused).
//!
//! The reader is our own and strict. What the crates for DXF give is a drawing without line numbers, from which what
//! they do not know is gone without a word, and some of them end with a panic on a damaged file; here each pair of lines
//! is looked at, and what is not understood is named by type, layer, handle and line.
//!
//! `pair` (lines in pairs, records) -> `content` (sections, blocks, entities) -> `insert` (blocks where they are inserted) ->
//! `fields`, `curve`, `spline` (an entity as points) -> `join` (closed loops).

mod content;
mod curve;
mod fields;
mod insert;
mod join;
mod pair;
mod spline;

use std::collections::BTreeMap;

use self::content::{Content, Entity, is_invisible, is_on_paper, layer_key, layer_of, value};
use self::curve::{Curve, Room, UNDERSTOOD, curve_of, described};
use self::insert::{Placed, placed};
use super::faults::{Fault, Faults};
use super::text::ReadLoop;
use crate::planning::document::shape::{MOST_FAULTS, quoted};
use crate::planning::finding::{Code, Finding};
use crate::planning::geometry::Point2;
use crate::planning::geometry::polygon::signed_area;
use crate::planning::tape::wire::Layers;
use crate::planning::tolerance::FLAT_MM;

/// The first bytes of a binary DXF file.
pub const BINARY_SENTINEL: &[u8] = b"AutoCAD Binary DXF\r\n\x1a\0";

/// The layer of the outline of a piece, and that of its cut-outs (ASTM D6673).
const ASTM_LAYERS: [&str; 2] = ["1", "11"];

/// What of a drawing is wanted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wanted {
    /// The outline of a ply first, then its cut-outs.
    Ply,
    /// Cut-outs alone.
    CutOuts,
}

/// The loops of a drawing in mm, with what should be known of it.
pub type Drawing = (Vec<ReadLoop>, Vec<Finding>);

/// Reads the outlines of a drawing. At least one is there.
///
/// Of the loops on the layer of the boundary the one with the largest area is the outline, any others are cut-outs.
///
/// # Errors
/// Every fault at `NAME:LINE`, the first 100, and how many more there are: a file that is no ASCII DXF, a unit or an
/// entity that is not understood, heights that differ, curves that do not close; a layer that holds no outline.
pub fn read(
    name: &str,
    bytes: &[u8],
    layers: Option<&Layers>,
    wanted: Wanted,
) -> Result<Drawing, Vec<Finding>> {
    let mut faults = Faults::of(name);
    if bytes.starts_with(BINARY_SENTINEL) {
        let message = "the file is a binary DXF drawing; save it as ASCII DXF";
        faults.push(Fault::new(Code::UnreadableFile, 1, message));
        return Err(faults.into_findings());
    }
    let text = String::from_utf8_lossy(bytes);
    let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
    let Some(content) = content::read(text, &mut faults) else { return Err(faults.into_findings()) };
    let layers = Chosen::of(layers, wanted);
    let mut findings = Vec::new();
    let drawn = unit_of(&content, name, &mut findings, &mut faults)
        .map(|scale| Sorted::of(&content, &layers, scale, name, &mut findings, &mut faults));
    let loops = drawn.map(|sorted| sorted.joined(&layers, &content, name, &mut findings, &mut faults));
    match loops {
        Some(loops) if faults.is_empty() => Ok((loops, findings)),
        _ => Err(faults.into_findings()),
    }
}

/// The layers that are read.
struct Chosen {
    /// Boundary and cut-outs, as they were named.
    names: [String; 2],
    keys: [String; 2],
    wanted: Wanted,
}

impl Chosen {
    fn of(layers: Option<&Layers>, wanted: Wanted) -> Self {
        let named = layers.map_or([None, None], |layers| [layers.boundary.clone(), layers.cut_outs.clone()]);
        let [boundary, cut_outs] = ASTM_LAYERS;
        let [named_boundary, named_cut_outs] = named;
        let names = [
            named_boundary.unwrap_or_else(|| boundary.to_owned()),
            named_cut_outs.unwrap_or_else(|| cut_outs.to_owned()),
        ];
        let keys = [layer_key(&names[0]), layer_key(&names[1])];
        Self { names, keys, wanted }
    }

    /// Which list the curves of a layer belong to: 0 boundary, 1 cut-outs. One layer for both is the boundary's.
    fn list(&self, layer: &str) -> Option<usize> {
        let key = layer_key(layer);
        let first = usize::from(self.wanted == Wanted::CutOuts);
        (first..2).find(|&list| self.keys[list] == key)
    }

    fn in_words(&self) -> String {
        let [boundary, cut_outs] = self.names.each_ref().map(|name| quoted(name));
        match self.wanted {
            Wanted::Ply => format!("{boundary} (boundary) and {cut_outs} (cut-outs)"),
            Wanted::CutOuts => format!("{cut_outs} (cut-outs)"),
        }
    }
}

/// mm per unit of the drawing.
fn unit_of(
    content: &Content<'_>,
    name: &str,
    findings: &mut Vec<Finding>,
    faults: &mut Faults<'_>,
) -> Option<f64> {
    let Some(units) = content.units.filter(|units| units.value != "0") else {
        let message = "the drawing does not say its unit ($INSUNITS); it was read in mm";
        let line = content.units.map_or(1, |units| units.line);
        findings.push(Finding::warning(Code::UnitsAssumed, format!("{name}:{line}"), message));
        return Some(1.0);
    };
    match units.value {
        "1" => Some(25.4),
        "4" => Some(1.0),
        "5" => Some(10.0),
        "6" => Some(1000.0),
        other => {
            let message = format!(
                "the unit {} ($INSUNITS) is not understood; known: 1 inch, 4 mm, 5 cm, 6 m",
                quoted(other)
            );
            faults.push(Fault::new(Code::NotSupported, units.line, message));
            None
        }
    }
}

/// The curves of a drawing by the list they belong to.
struct Sorted {
    lists: [Vec<Curve>; 2],
}

impl Sorted {
    fn of(
        content: &Content<'_>,
        layers: &Chosen,
        scale: f64,
        name: &str,
        findings: &mut Vec<Finding>,
        faults: &mut Faults<'_>,
    ) -> Self {
        let (mut lists, mut left, mut room) = ([Vec::new(), Vec::new()], LeftOut::default(), Room::default());
        let mut outlined: BTreeMap<u32, &Entity<'_>> = BTreeMap::new();
        for placed in placed(content, scale, |insert| draws_on(insert, layers, content), faults) {
            let Some(list) = part_of(&placed, layers, &mut left, faults) else { continue };
            if list == 0 {
                outlined.extend(placed.insert.map(|insert| (insert.record.line, insert)));
            }
            match curve_of(&placed, &mut room) {
                Some(Ok(curve)) => lists[list].push(curve),
                Some(Err(fault)) => faults.push(fault),
                None => faults.push(not_understood(&placed)),
            }
            left.note_thickness(placed.entity);
        }
        faults_of_pieces(&outlined, layers, faults);
        refuse_heights(lists.iter().flatten(), faults);
        findings.extend(left.findings(name, layers));
        Self { lists }
    }

    /// The loops, the boundary first.
    fn joined(
        self,
        layers: &Chosen,
        content: &Content<'_>,
        name: &str,
        findings: &mut Vec<Finding>,
        faults: &mut Faults<'_>,
    ) -> Vec<ReadLoop> {
        if !faults.is_empty() {
            return Vec::new();
        }
        let mut joined = self.lists.map(|curves| {
            let (loops, said) = join::join(&curves, name, faults);
            findings.extend(said);
            loops
        });
        let first = usize::from(layers.wanted == Wanted::CutOuts);
        if faults.is_empty() && joined[first].is_empty() {
            faults.push(no_outline(layers, first, content));
        }
        let area = |read: &ReadLoop| {
            let points: Vec<_> = read.points.iter().map(|point| Point2::new(point[0], point[1])).collect();
            signed_area(&points).abs()
        };
        // Where several are the largest, the first of them is the outline.
        let largest = (0..joined[0].len())
            .rev()
            .max_by(|&one, &other| area(&joined[0][one]).total_cmp(&area(&joined[0][other])));
        if let Some(largest) = largest {
            let outline = joined[0].remove(largest);
            joined[0].insert(0, outline);
        }
        joined.into_iter().flatten().collect()
    }
}

/// Annotations: they draw nothing that could be an outline, and drawings are full of them.
const ANNOTATIONS: [&str; 4] = ["TEXT", "MTEXT", "ATTDEF", "POINT"];

/// The list that an entity belongs to; `None` if it is left out, which is noted, or cannot be used, which is a fault.
fn part_of<'a>(
    placed: &Placed<'a>,
    layers: &Chosen,
    left: &mut LeftOut<'a>,
    faults: &mut Faults<'_>,
) -> Option<usize> {
    let (record, layer) = (&placed.entity.record, placed.layer);
    let on_paper = is_on_paper(record);
    let list = layers.list(layer);
    if list.is_none() || on_paper || ANNOTATIONS.contains(&record.kind) {
        left.note(placed, on_paper);
        return None;
    }
    if is_invisible(record) {
        let message =
            format!("{} on layer {} is invisible; show or delete it", described(record), quoted(layer));
        faults.push(Fault::new(Code::NotSupported, record.line, message));
        return None;
    }
    list
}

/// Whether an insert may draw on a layer that is read: by its own layer, or by those within its block.
fn draws_on(entity: &Entity<'_>, layers: &Chosen, content: &Content<'_>) -> bool {
    let name = value(&entity.record, 2).unwrap_or_default().to_uppercase();
    let may =
        |part: &Entity<'_>| part.record.kind == "INSERT" || layers.list(layer_of(&part.record)).is_some();
    layers.list(layer_of(&entity.record)).is_some()
        || content.blocks.get(&name).is_none_or(|block| block.entities.iter().any(may))
}

fn not_understood(placed: &Placed<'_>) -> Fault {
    let (record, layer) = (&placed.entity.record, quoted(placed.layer));
    let message = format!(
        "{} on layer {layer} is not understood; outlines are made of {UNDERSTOOD}",
        described(record)
    );
    Fault::new(Code::NotSupported, record.line, message)
}

/// Several inserts that draw on the layer of the boundary are several pieces: none is a cut-out of another.
fn faults_of_pieces(inserts: &BTreeMap<u32, &Entity<'_>>, layers: &Chosen, faults: &mut Faults<'_>) {
    let named = |insert: &Entity<'_>| {
        let record = &insert.record;
        format!("{} at line {}", quoted(value(record, 2).unwrap_or_default()), record.line)
    };
    if let Some((line, _)) = inserts.iter().nth(1) {
        let which: Vec<String> = inserts.values().take(MOST_LAYERS).map(|insert| named(insert)).collect();
        let message = format!(
            "the drawing holds {} pieces: the blocks {} each draw on layer {}. Save each piece as a drawing of its own",
            inserts.len(),
            which.join(", "),
            quoted(&layers.names[0])
        );
        faults.push(Fault::new(Code::NotSupported, *line, message));
    }
}

/// All curves lie at one height, that of the first.
fn refuse_heights<'a>(curves: impl Iterator<Item = &'a Curve>, faults: &mut Faults<'_>) {
    let mut height = None;
    for curve in curves {
        let height = *height.get_or_insert(curve.points[0].z);
        let off = curve.points.iter().zip(&curve.lines).find(|(point, _)| (point.z - height).abs() > FLAT_MM);
        if let Some((point, line)) = off {
            let message = format!(
                "the {} lies at z {:.4} mm here and the drawing at {height:.4} mm; only flat plies are drawn",
                curve.what, point.z
            );
            faults.push(Fault::new(Code::NotFlat, *line, message));
        }
    }
}

/// The most layers that a message lists.
const MOST_LAYERS: usize = 20;

fn no_outline(layers: &Chosen, list: usize, content: &Content<'_>) -> Fault {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for entity in &content.entities {
        *counts.entry(layer_of(&entity.record)).or_default() += 1;
    }
    let listed: Vec<_> = counts
        .iter()
        .take(MOST_LAYERS)
        .map(|(layer, count)| format!("{} ({count} entities)", quoted(layer)))
        .collect();
    let there = match (listed.is_empty(), content.blocks.is_empty()) {
        (false, _) => listed.join(", "),
        (true, true) => "it has no entities".to_owned(),
        (true, false) => "none; it has blocks, but inserts none of them".to_owned(),
    };
    let field = ["boundary", "cut_outs"][list];
    let message = format!(
        "no outline on layer {}; layers with entities: {there}. Name the one that is meant: \
         \"layers\": {{\"{field}\": ...}}",
        quoted(&layers.names[list])
    );
    Fault::new(Code::UnknownValue, 1, message)
}

/// Whether something is in paper space.
type OnPaper = bool;
/// How many of each type of entity.
type Kinds<'a> = BTreeMap<&'a str, usize>;

/// What was left out, by layer and kind, with the first line and the first thing of each layer.
#[derive(Default)]
struct LeftOut<'a> {
    layers: BTreeMap<(&'a str, OnPaper), (u32, Kinds<'a>)>,
    /// How many entities have a width or a thickness, and where the first is.
    thick: Option<(u32, usize)>,
}

impl<'a> LeftOut<'a> {
    fn note(&mut self, placed: &Placed<'a>, on_paper: bool) {
        let (line, kind) = (placed.entity.record.line, placed.entity.record.kind);
        let (_, kinds) =
            self.layers.entry((placed.layer, on_paper)).or_insert_with(|| (line, BTreeMap::new()));
        *kinds.entry(kind).or_default() += 1;
    }

    fn note_thickness(&mut self, entity: &Entity<'_>) {
        let codes: &[i32] = if entity.record.kind.ends_with("POLYLINE") { &[39, 40, 41, 43] } else { &[39] };
        let records = std::iter::once(&entity.record).chain(&entity.parts);
        let mut pairs = records.flat_map(|record| &record.pairs).filter(|pair| codes.contains(&pair.code));
        if pairs.any(|pair| pair.value.parse::<f64>().is_ok_and(|value| value != 0.0)) {
            self.thick.get_or_insert((entity.record.line, 0)).1 += 1;
        }
    }

    fn findings(&self, name: &str, layers: &Chosen) -> Vec<Finding> {
        let mut findings: Vec<_> = self
            .layers
            .iter()
            .take(MOST_FAULTS)
            .map(|((layer, on_paper), (line, kinds))| {
                let kinds: Vec<_> = kinds
                    .iter()
                    .take(MOST_LAYERS)
                    .map(|(kind, count)| format!("{count} {}", quoted(kind).trim_matches('"')))
                    .collect();
                let where_ = if *on_paper { " in paper space" } else { "" };
                let message = format!(
                    "{} on layer {}{where_} left out; outlines are the curves on the layers {}",
                    kinds.join(", "),
                    quoted(layer),
                    layers.in_words()
                );
                Finding::info(Code::LeftOut, format!("{name}:{line}"), message)
            })
            .collect();
        if self.layers.len() > MOST_FAULTS {
            let message =
                format!("entities on {} further layers are left out", self.layers.len() - MOST_FAULTS);
            findings.push(Finding::info(Code::LeftOut, format!("{name}:1"), message));
        }
        if let Some((line, count)) = self.thick {
            let message =
                format!("the width or thickness of {count} curves is left out: their centre line is cut");
            findings.push(Finding::warning(Code::LeftOut, format!("{name}:{line}"), message));
        }
        findings
    }
}

#[cfg(test)]
mod tests;
