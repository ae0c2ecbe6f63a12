//! The plan of a ply: pieces, their chains, their places on the roll and their knives.

use super::assign::{RollChain, assign, passing, published};
use super::beam::Beam;
use super::block::{Block, Rule, Way};
use super::chain::{Chain, split};
use super::coverage;
use super::develop::{PlyInSpace, develop};
use super::input::{Allocation, Course, OnExcess, Ply, TapeInput};
use super::label::{CourseLabel, CoursePlace};
use super::machine::{Cutter, Machine};
use super::mould;
use super::offset::{busy_mm, parted};
use super::pace::least_time;
use super::piece::{Piece, within_strip};
use super::place::Tape;
use super::roll::{Roll, RollFigures, lay};
use super::sides::{self, keep_sides};
use super::sliver::{self, Marks};
use super::stroke::{Stroke, strokes};
use super::zone;
use crate::planning::budget::Budget;
use crate::planning::finding::{Code, Finding};
use crate::planning::program::number::rounded;
use crate::planning::program::replay::WantedCut;

/// The plan of a ply.
#[derive(Debug, Clone)]
pub struct TapePlan {
    /// The courses that touch the ply, in laying order.
    pub courses: Vec<PlannedCourse>,
    /// All pieces in increasing roll coordinate, as (course, piece) indices into `courses`.
    pub order: Vec<(usize, usize)>,
    /// Roll coordinate of the leading end of the tape in mm.
    pub leading_end_mm: f64,
    /// The figures of the roll.
    pub figures: RollFigures,
}

/// A course of a plan.
#[derive(Debug, Clone)]
pub struct PlannedCourse {
    /// What it is called.
    pub label: CourseLabel,
    /// Its place in the job document.
    pub place: CoursePlace,
    /// Its pieces in order of their smallest u.
    pub pieces: Vec<PlannedPiece>,
}

/// A piece of a plan.
#[derive(Debug, Clone)]
pub struct PlannedPiece {
    /// The piece in the (u, v) of its course.
    pub piece: Piece,
    /// Its smallest and largest u.
    pub u: (f64, f64),
    /// r - u in mm.
    pub offset_mm: f64,
    /// Its chains, each with its cutter from 0.
    pub chains: Vec<(Chain, usize)>,
    /// How far its outline was changed on the scrap side, in mm, and the area that this leaves to be trimmed, in mm^2.
    pub simplified: Option<(f64, f64)>,
    /// The piece as the ply has it, if its outline was changed.
    pub given: Option<Box<Piece>>,
    /// What is odd about it.
    pub marks: Marks,
    /// The cut of it that is made as a cut of its neighbour.
    pub shared: Option<SharedCut>,
}

/// A cut that two neighbouring pieces have in common. A knife makes it once, as the neighbour's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SharedCut {
    /// Which cut of the piece it is.
    pub cut: usize,
    /// The neighbour as (course, piece) indices.
    pub with: (usize, usize),
    /// Which cut of the neighbour it is.
    pub with_cut: usize,
    /// How far, in mm, the two outlines are apart at most.
    pub apart_mm: f64,
}

/// Plans a ply.
///
/// # Errors
/// Every finding that leaves the ply without a plan.
pub fn plan(
    input: &TapeInput,
    budget: &Budget<'_>,
    findings: &mut Vec<Finding>,
) -> Result<TapePlan, Vec<Finding>> {
    budget.stage("develop and clip");
    let mut courses = courses_of_plies(input, budget, findings)?;
    budget.stage("chains");
    findings.extend(assign_knives(&mut courses, input)?);
    budget.stage("roll");
    let planned = placed(courses, input, budget)?;
    findings.extend(planned.shared_cuts());
    findings.extend(zone::unused(input, planned.figures.tape_used_mm));
    Ok(planned)
}

/// The courses of all plies in laying order. Each ply is looked at for itself.
fn courses_of_plies(
    input: &TapeInput,
    budget: &Budget<'_>,
    findings: &mut Vec<Finding>,
) -> Result<Vec<PlannedCourse>, Vec<Finding>> {
    let (mut courses, mut faults) = (Vec::new(), Vec::new());
    for ply in &input.plies {
        let of_ply = pieces_of_courses(ply, input, budget, findings)?;
        if of_ply.is_empty() {
            let message =
                format!("no course touches {ply}: see whether both are in one coordinate system, in mm");
            faults.push(Finding::error(Code::NoCourseOnPly, format!("{}/tracks", ply.place), message));
        } else {
            let generated = input.origins.are_generated(ply.place);
            findings.extend(coverage::findings(laid_mm2(&of_ply), ply, generated, input.width.mm(), budget)?);
        }
        courses.extend(of_ply);
    }
    if faults.is_empty() { Ok(courses) } else { Err(faults) }
}

/// The area of the ply that lies on courses: what a changed outline has more lies on scrap.
fn laid_mm2(courses: &[PlannedCourse]) -> f64 {
    let pieces = courses.iter().flat_map(|course| &course.pieces);
    pieces.map(|p| p.piece.area_mm2 - p.simplified.map_or(0.0, |(_, extra_mm2)| extra_mm2)).sum()
}

fn pieces_of_courses(
    ply: &Ply,
    input: &TapeInput,
    budget: &Budget<'_>,
    findings: &mut Vec<Finding>,
) -> Result<Vec<PlannedCourse>, Vec<Finding>> {
    let mut courses = Vec::new();
    let in_space = PlyInSpace::new(&ply.boundary, &ply.holes);
    let mut met = vec![false; ply.holes.len()];
    for course in &ply.courses {
        let pieces = pieces_of(course, ply, &in_space, input, budget, (findings, &mut met))
            .map_err(|finding| vec![finding])?;
        if pieces.is_empty() {
            findings.push(Finding::info(
                Code::CourseOffPly,
                course.place.to_string(),
                format!("course {} does not touch the ply and is left out", course.label),
            ));
        } else {
            findings.extend(pieces.iter().filter_map(|piece| simplification(course, piece)));
            findings.extend(sliver::findings(course, &pieces, input));
            courses.push(PlannedCourse { label: course.label, place: course.place, pieces });
        }
    }
    findings.extend(mould::never_met(ply, &met));
    Ok(courses)
}

fn simplification(course: &Course, piece: &PlannedPiece) -> Option<Finding> {
    let (deviation_mm, area_mm2) = piece.simplified?;
    let message = format!(
        "course {}: there are not enough knives for its outline; it was changed on the scrap side, by {deviation_mm:.3} mm along \
         the tape at the most, and {area_mm2:.1} mm2 are left to be trimmed",
        course.label
    );
    Some(Finding::warning(Code::OutlineSimplified, course.place.to_string(), message))
}

fn pieces_of(
    course: &Course,
    ply: &Ply,
    in_space: &PlyInSpace<'_>,
    input: &TapeInput,
    budget: &Budget<'_>,
    (findings, met): (&mut Vec<Finding>, &mut [bool]),
) -> Result<Vec<PlannedPiece>, Finding> {
    let width = input.width.mm();
    let developed = develop(course, in_space, input.machine.cut_side, width)?;
    mould::note_met(&developed, width, met);
    let outlines = std::iter::once(&developed.boundary).chain(&developed.holes);
    budget.spend(outlines.map(|outline| outline.places.len()).sum::<usize>() as u64)?;
    let pieces = within_strip(&developed, width)
        .map_err(|fault| mould::named(fault, course, ply, &developed, width))?;
    if let Some(on_mould) = &developed.on_mould {
        findings.extend(mould::check(course, ply, on_mould, &pieces, width)?);
    }
    Ok(pieces.into_iter().map(|piece| chained(piece, input)).collect())
}

fn chained(mut piece: Piece, input: &TapeInput) -> PlannedPiece {
    let (half_width_mm, knives) = (input.width.mm() / 2.0, input.machine.cutters.len());
    let changed = match input.on_excess {
        OnExcess::Simplify => piece.simplify(half_width_mm, knives),
        OnExcess::Reject => None,
    };
    let (given, simplified) = changed.map(|(given, change)| (Box::new(given), change)).unzip();
    let chains = piece
        .cuts()
        .enumerate()
        .flat_map(|(index, cut)| split(index, cut, half_width_mm))
        .flat_map(|chain| parted(chain, &input.machine, input.thinning_mm(), input.tolerance.mm()))
        .map(|mut chain| {
            chain.busy_mm = busy_mm(&chain, &input.machine, input.thinning_mm(), input.tolerance.mm());
            let cutter = published(&chain).0.min(knives - 1);
            (chain, cutter)
        })
        .collect();
    let u = piece.u_range();
    let marks = Marks::of(&piece, u, input);
    PlannedPiece { piece, u, offset_mm: 0.0, chains, simplified, given, marks, shared: None }
}

/// Gives the chains of each piece to knives as if it were alone on the roll.
fn assign_knives(courses: &mut [PlannedCourse], input: &TapeInput) -> Result<Vec<Finding>, Vec<Finding>> {
    let (mut faults, mut findings) = (Vec::new(), Vec::new());
    for course in courses {
        for piece in 0..course.pieces.len() {
            let chains = roll_chains(course, &course.pieces[piece]);
            match assign(&chains, input.machine.cutters.len()) {
                Ok((given, found)) => {
                    findings.extend(found);
                    for ((_, cutter), given) in course.pieces[piece].chains.iter_mut().zip(given) {
                        *cutter = given;
                    }
                }
                Err(found) => faults.extend(found),
            }
        }
    }
    if input.allocation == Allocation::Free {
        // Whoever asks for any valid way is not told that it is another one than the published.
        findings.clear();
    }
    if input.machine.cutters.iter().any(Cutter::swivels) {
        let counted = " (places are those of the blades' axes, which lie beside their edges: a blade with less offset takes less room)";
        faults.iter_mut().for_each(|fault: &mut Finding| fault.message.push_str(counted));
    }
    let way_out = match input.on_excess {
        OnExcess::Reject => "; `on_excess: simplify` changes an outline on its scrap side where that helps",
        OnExcess::Simplify => {
            "; `on_excess: simplify` is of no help here: it changes the two ends of a piece, each from one edge of the tape to the other, no cut-out, and leaves no room for blade offsets"
        }
    };
    faults.iter_mut().for_each(|fault: &mut Finding| fault.message.push_str(way_out));
    if faults.is_empty() { Ok(findings) } else { Err(faults) }
}

/// The chains of a piece that knives make for it, on the roll.
fn roll_chains(course: &PlannedCourse, piece: &PlannedPiece) -> Vec<RollChain> {
    let on_roll = |(chain, cutter): &(Chain, usize)| {
        let (low, high) = chain.busy_mm;
        RollChain {
            course: course.label,
            place: course.place,
            range: (low + piece.offset_mm, high + piece.offset_mm),
            offset_mm: piece.offset_mm,
            published: *cutter,
            covered: published(chain).1,
        }
    };
    piece.chains.iter().filter(|(chain, _)| !piece.shares(chain)).map(on_roll).collect()
}

/// The pieces at their places on the roll. Where carriages on one beam would meet with the knives that `free` finds, and
/// would not with those of the published rule, that rule it is.
fn placed(
    courses: Vec<PlannedCourse>,
    input: &TapeInput,
    budget: &Budget<'_>,
) -> Result<TapePlan, Vec<Finding>> {
    if input.allocation != Allocation::Free {
        return on_roll(courses, input, Rule::Given, budget);
    }
    if Beam::of(&input.machine).is_none() {
        return on_roll(courses, input, Rule::Count, budget);
    }
    let free = on_roll(courses.clone(), input, Rule::Count, budget)?;
    let lacking = sides::lacking(&free, input);
    if lacking.0 == 0 {
        return Ok(free);
    }
    let published = on_roll(courses, input, Rule::Given, budget)?;
    Ok(if sides::lacking(&published, input) < lacking { published } else { free })
}

fn on_roll(
    mut courses: Vec<PlannedCourse>,
    input: &TapeInput,
    rule: Rule,
    budget: &Budget<'_>,
) -> Result<TapePlan, Vec<Finding>> {
    let places = indices(&courses);
    let knives = input.machine.cutters.len();
    let half_mm = input.width.mm() / 2.0;
    let pieces = courses.iter().flat_map(|course| &course.pieces);
    let blocks: Vec<Block> = pieces.map(|p| Block::new(&p.piece, &p.chains, half_mm, knives, rule)).collect();
    let tape = Tape {
        // The first cut begins before its piece by as much as it overcuts, and as an axis trails behind its edge.
        ahead_mm: input.machine.overcut().mm() + input.machine.ahead_and_behind_mm().1,
        gap_mm: input.scrap_gap.mm(),
        zones: &input.zones_mm,
        knives,
        rule,
        share_mm: input.share_cuts.then_some(input.tolerance.mm()),
    };
    let roll = lay(&blocks, input.roll_order, &tape, budget).map_err(|finding| vec![finding])?;
    take_places(&mut courses, &places, &blocks, &roll, knives);
    if rule == Rule::Count {
        give_for_least_time(&mut courses, &input.machine)?;
    }
    colour_shared(&mut courses);
    let area_mm2 = courses.iter().flat_map(|course| &course.pieces).map(|p| p.piece.area_mm2).sum();
    let of_courses: Vec<usize> = places.iter().map(|(course, _)| *course).collect();
    // The U axis reads 0 with the leading end of the tape under cutter 1.
    let first_station = input.machine.cutters[0].station.mm();
    let lead_mm = rounded(roll.leading_end_mm - first_station, super::stroke::DECIMALS);
    let figures = roll.figures(&blocks, &of_courses, area_mm2, input.width.mm(), lead_mm, &tape);
    let order = roll.order.iter().map(|&index| places[index]).collect();
    let mut plan = TapePlan { courses, order, leading_end_mm: roll.leading_end_mm, figures };
    if rule == Rule::Count {
        keep_sides(&mut plan, input);
    }
    Ok(plan)
}

/// All pieces in laying order.
fn indices(courses: &[PlannedCourse]) -> Vec<(usize, usize)> {
    let of_course = |(course, planned): (usize, &PlannedCourse)| {
        (0..planned.pieces.len()).map(move |piece| (course, piece))
    };
    courses.iter().enumerate().flat_map(of_course).collect()
}

/// Takes over what placing has made of each piece.
fn take_places(
    courses: &mut [PlannedCourse],
    places: &[(usize, usize)],
    blocks: &[Block],
    roll: &Roll,
    knives: usize,
) {
    for (index, &(course, piece)) in places.iter().enumerate() {
        let planned = &mut courses[course].pieces[piece];
        planned.offset_mm = roll.offsets_mm[index];
        for ((_, cutter), way) in planned.chains.iter_mut().zip(&roll.places[index].ways) {
            *cutter = if *way == Way::Straight { *cutter } else { way.of(*cutter, knives) };
        }
    }
    // Whose finish is shared makes it as the start of the piece that is next in r.
    for pair in roll.order.windows(2) {
        let (one, with) = (places[pair[0]], places[pair[1]]);
        let Some(apart_mm) = roll.places[pair[0]].shared_mm else { continue };
        let cuts = blocks[pair[0]].lead_cut.zip(blocks[pair[1]].trail_cut);
        let (cut, with_cut) = cuts.expect("only a cut that is the whole end of both is shared");
        courses[one.0].pieces[one.1].shared = Some(SharedCut { cut, with, with_cut, apart_mm });
        let keeper = &mut courses[with.0].pieces[with.1];
        let made = keeper.chains.iter_mut().filter(|(chain, _)| chain.cut == with_cut);
        // What the outlines are apart is not there for thinning.
        made.for_each(|(chain, _)| chain.shift_mm += apart_mm);
    }
}

/// Gives the chains of a roll to two knives so that it takes the least time.
fn give_for_least_time(courses: &mut [PlannedCourse], machine: &Machine) -> Result<(), Vec<Finding>> {
    let knives = machine.cutters.len();
    let (mut chains, mut seconds) = (Vec::new(), Vec::new());
    for course in courses.iter() {
        for piece in &course.pieces {
            chains.extend(roll_chains(course, piece));
            let made = piece.chains.iter().filter(|(chain, _)| !piece.shares(chain));
            seconds.extend(made.map(|(chain, _)| cutting_s(chain, machine)));
        }
    }
    let (given, _) = assign(&chains, knives)?;
    let given = match machine.cutters.as_slice() {
        [one, other] => least_time(&chains, &seconds, given, other.station.mm() - one.station.mm()),
        _ => given,
    };
    give(courses, &given);
    Ok(())
}

/// Gives the chains that knives make to these knives, in the order of courses, pieces and chains.
fn give(courses: &mut [PlannedCourse], given: &[usize]) {
    let mut given = given.iter();
    for piece in courses.iter_mut().flat_map(|course| &mut course.pieces) {
        let shared = piece.shared.map(|shared| shared.cut);
        let made = piece.chains.iter_mut().filter(|(chain, _)| Some(chain.cut) != shared);
        for ((_, cutter), given) in made.zip(given.by_ref()) {
            *cutter = *given;
        }
    }
}

/// The time in s that a knife needs for a chain at least.
fn cutting_s(chain: &Chain, machine: &Machine) -> f64 {
    let speed =
        machine.cutters.iter().map(|cutter| cutter.cutting_speed.mm_s()).fold(f64::INFINITY, f64::min);
    let path_speed = machine.max_cutting_path_speed.mm_s();
    let steps = chain.points.windows(2).map(|pair| pair[1] - pair[0]);
    steps.map(|step| (step.y.abs() / speed).max(step.norm() / path_speed)).sum()
}

/// A shared cut has the knives that make it: its chains lie in the neighbour's cut the other way round.
fn colour_shared(courses: &mut [PlannedCourse]) {
    for (course, piece) in indices(courses) {
        let Some(shared) = courses[course].pieces[piece].shared else { continue };
        let keeper = &courses[shared.with.0].pieces[shared.with.1];
        let of_cut = keeper.chains.iter().rev().filter(|(chain, _)| chain.cut == shared.with_cut);
        let cutters: Vec<usize> = of_cut.map(|(_, cutter)| *cutter).collect();
        let chains = courses[course].pieces[piece].chains.iter_mut();
        for ((_, cutter), made) in chains.filter(|(chain, _)| chain.cut == shared.cut).zip(cutters) {
            *cutter = made;
        }
    }
}

impl PlannedPiece {
    /// Its outline without its cut-outs, in roll coordinates (r, v) in mm.
    #[must_use]
    pub fn outline_on_roll(&self) -> Vec<[f64; 2]> {
        self.piece.outline().iter().map(|point| [point.x + self.offset_mm, point.y]).collect()
    }

    /// Whether a chain belongs to the cut that is made as the neighbour's.
    #[must_use]
    pub fn shares(&self, chain: &Chain) -> bool {
        self.shared.is_some_and(|shared| shared.cut == chain.cut)
    }
}

impl TapePlan {
    /// The pieces in increasing roll coordinate, each with its course.
    pub fn pieces(&self) -> impl DoubleEndedIterator<Item = (&PlannedCourse, &PlannedPiece)> {
        self.order.iter().map(|&(course, piece)| {
            let course = &self.courses[course];
            (course, &course.pieces[piece])
        })
    }

    /// The chains that knives make, in the order of courses, pieces and chains.
    fn made(&self) -> impl Iterator<Item = &(Chain, usize)> {
        let pieces = self.courses.iter().flat_map(|course| &course.pieces);
        pieces.flat_map(|piece| piece.chains.iter().filter(|(chain, _)| !piece.shares(chain)))
    }

    /// The chains that knives make, on the roll.
    #[must_use]
    pub fn made_chains(&self) -> Vec<RollChain> {
        let pieces =
            self.courses.iter().flat_map(|course| course.pieces.iter().map(move |piece| (course, piece)));
        pieces.flat_map(|(course, piece)| roll_chains(course, piece)).collect()
    }

    /// The knife of each chain that knives make, as [`TapePlan::made_chains`] lists them.
    #[must_use]
    pub fn knives(&self) -> Vec<usize> {
        self.made().map(|(_, knife)| *knife).collect()
    }

    /// In the middle of which v in mm each chain lies that knives make.
    #[must_use]
    pub fn middles_v(&self) -> Vec<f64> {
        let middle = |(chain, _): &(Chain, usize)| {
            let vs = || chain.points.iter().map(|point| point.y);
            f64::midpoint(vs().fold(f64::INFINITY, f64::min), vs().fold(f64::NEG_INFINITY, f64::max))
        };
        self.made().map(middle).collect()
    }

    /// Gives the chains to other knives, as [`TapePlan::made_chains`] lists them.
    pub fn give(&mut self, knives: &[usize]) {
        give(&mut self.courses, knives);
        colour_shared(&mut self.courses);
    }

    /// The strokes of each cutter in the order in which they pass it, whatever pieces they are of.
    #[must_use]
    pub fn strokes(&self, input: &TapeInput) -> Vec<Vec<Stroke>> {
        let mut of_cutters: Vec<Vec<Stroke>> = vec![Vec::new(); input.machine.cutters.len()];
        for (course, piece, (chain, cutter)) in self.passing_chains() {
            let machine_cutter = &input.machine.cutters[*cutter];
            let offset_mm = course.pieces[piece].offset_mm;
            let x_of_u0 = self.figures.lead_mm - offset_mm + machine_cutter.station.mm();
            let thinning_mm = machine_cutter.thinning_mm(input.thinning_mm(), input.tolerance.mm());
            let mut made = strokes(chain, (course.label, piece), machine_cutter, x_of_u0, thinning_mm);
            let before = of_cutters[*cutter].last().and_then(|stroke| stroke.knots.last());
            if !machine_cutter.swivels() {
                hold_back(&mut made, before.map_or(f64::NEG_INFINITY, |knot| knot.x));
            }
            of_cutters[*cutter].extend(made);
        }
        of_cutters
    }

    /// The chains that knives make, each with its course and the index of its piece there, in the order in which they pass:
    /// neighbours share places of the roll.
    fn passing_chains(&self) -> Vec<(&PlannedCourse, usize, &(Chain, usize))> {
        let mut chains = Vec::new();
        for &(course, index) in self.order.iter().rev() {
            let course = &self.courses[course];
            let piece = &course.pieces[index];
            let made = piece.chains.iter().filter(|(chain, _)| !piece.shares(chain));
            chains.extend(made.map(|chain| (course, index, chain)));
        }
        let on_roll = |&(course, piece, (chain, _)): &(&PlannedCourse, usize, &(Chain, usize))| {
            let offset_mm = course.pieces[piece].offset_mm;
            (chain.busy_mm.0 + offset_mm, chain.busy_mm.1 + offset_mm)
        };
        chains.sort_by(|one, other| passing(on_roll(one), on_roll(other)));
        chains
    }

    /// Which cuts two pieces have in common.
    fn shared_cuts(&self) -> Vec<Finding> {
        let mut findings = Vec::new();
        for (course, piece) in self.pieces() {
            let Some(shared) = piece.shared else { continue };
            let message = format!(
                "the end of course {} and the start of course {} are one cut; the two are {:.4} mm apart at most",
                course.label, self.courses[shared.with.0].label, shared.apart_mm
            );
            findings.push(Finding::info(Code::SharedCut, course.place.to_string(), message));
        }
        findings
    }

    /// What there is not tape enough for: on the spool, and in one program of the machine. The last cut may be the last
    /// cutter's and goes on beyond its piece, and the tape must still be held then.
    #[must_use]
    pub fn lacking_tape(&self, input: &TapeInput) -> Vec<Finding> {
        let stations = input.machine.cutters.iter().map(|cutter| cutter.station.mm());
        let behind = stations.fold(f64::NEG_INFINITY, f64::max) - input.machine.cutters[0].station.mm()
            + input.machine.ahead_and_behind_mm().0
            + input.machine.overcut().mm();
        let axis = input.machine.feed.max_length.mm();
        let spool = input.tape_length.map(|length| {
            let what = format!("the spool holds {} mm of tape", length.mm());
            self.lacking(length.mm(), behind).map(|lack| {
                Finding::error(Code::TapeTooShort, "/input/tape/length_mm", format!("{what}; {lack}"))
            })
        });
        let program = self.lacking(axis, behind).map(|lack| {
            let what = format!("the tape axis reads 0 to {axis} mm");
            Finding::error(Code::AxisLimit, "/input/machine", format!("{what}; {lack}"))
        });
        spool.flatten().into_iter().chain(program).collect()
    }

    /// How much of so much tape is lacking, and for which course first; nothing if it is enough. `behind_mm` more must
    /// pass for the last cutter.
    fn lacking(&self, length_mm: f64, behind_mm: f64) -> Option<String> {
        let lacking = self.figures.tape_used_mm + behind_mm - length_mm;
        // Positions are rounded up to a step.
        if lacking <= super::place::STEP_MM {
            return None;
        }
        let needs = |piece: &PlannedPiece| self.leading_end_mm - (piece.u.0 + piece.offset_mm) + behind_mm;
        let first = self.pieces().rev().find(|(_, piece)| needs(piece) > length_mm)?;
        let course = first.0.label;
        Some(format!(
            "{lacking:.3} mm more are needed. The first course, in the order of cutting, that does not fit is {course}"
        ))
    }

    /// The cuts that a program must make, in roll coordinates, as they were developed.
    #[must_use]
    pub fn wanted(&self) -> Vec<WantedCut> {
        let mut wanted = Vec::new();
        for (course, piece) in self.pieces() {
            wanted.extend(piece.piece.cuts().map(|cut| WantedCut {
                course: course.label,
                points: cut.iter().map(|point| [point.x + piece.offset_mm, point.y]).collect(),
            }));
        }
        wanted
    }
}

/// Two chains that meet at one place may overlap there by as much as that is: the second is begun where the tape
/// stands, which only runs forward.
fn hold_back(strokes: &mut [Stroke], x: f64) {
    for knot in strokes.iter_mut().flat_map(|stroke| &mut stroke.knots) {
        knot.x = knot.x.max(x);
    }
}
