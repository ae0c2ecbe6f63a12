//! The inputs of the honeycomb jobs, checked and taken over once: what the planner works on.

use super::blade::Blade;
use super::{contour_text, wire};
use crate::planning::document::files::Files;
use crate::planning::finding::{Code, Finding, any_error};
use crate::planning::geometry::Point2;
use crate::planning::program::robot_moves::Speeds;
use crate::planning::tolerance::SAME_POINT_MM;
use crate::planning::units::{Angle, Length};

pub use super::wire::{Blank, LatticeChoice, Process};

/// A honeycomb-cut job's input.
#[derive(Debug, Clone)]
pub struct CutInput {
    /// The blank, its blade and the speeds.
    pub setting: Setting,
    /// The finished contour: x and z in mm from x = 0 to the blank's width.
    pub profile: Vec<Point2>,
    /// The lattice that was asked for.
    pub lattice: LatticeChoice,
    /// Its parameters, if they were chosen.
    pub chosen: Option<Chosen>,
    /// The set to compare with.
    pub initial: Option<Chosen>,
    /// A contour measured on a cut part.
    pub measured: Option<Vec<Point2>>,
}

/// A honeycomb-optimum job's input.
#[derive(Debug, Clone)]
pub struct OptimumInput {
    /// The blank, its blade and the speeds.
    pub setting: Setting,
    /// A_C in mm^2.
    pub machined_area_mm2: f64,
    /// The lattice, or the best of the three.
    pub lattice: LatticeChoice,
    /// The set to compare with.
    pub initial: Option<Chosen>,
}

/// What all honeycomb jobs have.
#[derive(Debug, Clone)]
pub struct Setting {
    /// The blank.
    pub blank: Blank,
    /// The blade.
    pub blade: Blade,
    /// Speeds and limits.
    pub process: Process,
}

impl Setting {
    /// The speeds that the process asks for.
    #[must_use]
    pub fn speeds(&self) -> Speeds {
        Speeds {
            cutting_mm_s: self.process.cutting_speed_mm_s,
            travel_mm_s: self.process.travel_speed_mm_s,
            angular_deg_s: self.process.angular_speed_deg_s,
        }
    }
}

/// Parameters that a sender has chosen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Chosen {
    /// h and s in mm, alpha in rad.
    All {
        /// h.
        layer_spacing_mm: f64,
        /// s.
        step_mm: f64,
        /// alpha.
        swing: f64,
    },
    /// alpha in rad; h and s follow (the paper's Fig. 6).
    BySwing {
        /// alpha.
        swing: f64,
        /// epsilon.
        overlap_ratio: f64,
    },
}

/// Checks a honeycomb-cut input and takes it over.
///
/// Without `files` what stands in files is taken as right and left empty: that is for who only checks a document.
///
/// # Errors
/// Every fault with its JSON pointer.
pub fn check_cut(input: &wire::HoneycombCut, files: Option<&Files>) -> Result<CutInput, Vec<Finding>> {
    let mut faults = Vec::new();
    let setting = check_setting(input.blank, &input.tool, input.process, &mut faults);
    let profile = check_profile(&input.profile, &input.blank, files, &mut faults);
    let measured = input.measured.as_ref();
    let measured = measured.map(|found| check_points(found, "/input/measured", files, &mut faults));
    refuse_unsupported(&input.plan, &mut faults);
    let chosen = check_chosen(input.plan.parameters.as_ref(), "/input/plan/parameters", &mut faults);
    refuse_wide_swing(input.plan.parameters.as_ref(), &input.tool, &mut faults);
    let initial =
        check_chosen(input.plan.initial_parameters.as_ref(), "/input/plan/initial_parameters", &mut faults);
    if any_error(&faults) {
        return Err(faults);
    }
    Ok(CutInput { setting, profile, lattice: input.plan.lattice, chosen, initial, measured })
}

/// Checks a honeycomb-optimum input and takes it over.
///
/// # Errors
/// Every fault with its JSON pointer.
pub fn check_optimum(input: &wire::HoneycombOptimum) -> Result<OptimumInput, Vec<Finding>> {
    let mut faults = Vec::new();
    let setting = check_setting(input.blank, &input.tool, input.process, &mut faults);
    let whole = input.blank.width_mm * input.blank.height_mm;
    if input.machined_area_mm2 > whole {
        let message =
            format!("is {} mm2; the section of the blank has only {whole} mm2", input.machined_area_mm2);
        faults.push(Finding::error(Code::OutOfRange, "/input/machined_area_mm2", message));
    }
    if input.lattice == LatticeChoice::Hybrid {
        faults.push(not_supported("/input/lattice", "the published model has no hybrid lattice"));
    }
    let initial = check_chosen(input.initial_parameters.as_ref(), "/input/initial_parameters", &mut faults);
    if any_error(&faults) {
        return Err(faults);
    }
    let (machined_area_mm2, lattice) = (input.machined_area_mm2, input.lattice);
    Ok(OptimumInput { setting, machined_area_mm2, lattice, initial })
}

/// Checks blank, blade and process together.
pub fn check_setting(
    blank: Blank,
    tool: &wire::Tool,
    process: Process,
    faults: &mut Vec<Finding>,
) -> Setting {
    let length = tool.blade_length_mm.unwrap_or(tool.max_cutting_length_mm);
    if length < tool.max_cutting_length_mm {
        let message = format!(
            "is {length} mm; the blade's edge is at least as long as the {} mm of it that may cut",
            tool.max_cutting_length_mm
        );
        faults.push(Finding::error(Code::OutOfRange, "/input/tool/blade_length_mm", message));
    }
    if tool.half_apex_angle_deg >= tool.rake_angle_deg {
        let message = format!(
            "is {} degrees; it must be below the rake angle of {} degrees, or the edge does not cut",
            tool.half_apex_angle_deg, tool.rake_angle_deg
        );
        faults.push(Finding::error(Code::OutOfRange, "/input/tool/half_apex_angle_deg", message));
    }
    let blade = Blade {
        rake: Angle::from_degrees(tool.rake_angle_deg),
        half_apex: Angle::from_degrees(tool.half_apex_angle_deg),
        max_cutting_length: Length::from_mm(tool.max_cutting_length_mm),
        length: Length::from_mm(length),
        max_swing: Angle::from_degrees(tool.max_swing_angle_deg),
        edges: tool.edges,
    };
    Setting { blank, blade, process }
}

/// Checks the finished contour of a blank.
pub fn check_profile(
    profile: &wire::Profile,
    blank: &Blank,
    files: Option<&Files>,
    faults: &mut Vec<Finding>,
) -> Vec<Point2> {
    let at = "/input/profile";
    let points = check_points(profile, at, files, faults);
    let (Some(first), Some(last)) = (points.first(), points.last()) else { return points };
    if first.x.abs() > SAME_POINT_MM || (last.x - blank.width_mm).abs() > SAME_POINT_MM {
        let message = format!(
            "goes from x = {} to {}; the contour of a blank of {} mm goes from 0 to {}",
            first.x, last.x, blank.width_mm, blank.width_mm
        );
        faults.push(Finding::error(Code::ProfileSpan, format!("{at}/points"), message));
    }
    let height = blank.height_mm;
    let outside = points.iter().enumerate().filter(|(_, point)| !(0.0..=height).contains(&point.y));
    faults.extend(outside.take(MOST_LISTED).map(|(index, point)| {
        let message = format!("z is {}; the blank goes from 0 to {height} mm", point.y);
        Finding::error(Code::OutOfRange, format!("{at}/points/{index}/1"), message)
    }));
    points
}

/// So many points of one kind of fault are named.
const MOST_LISTED: usize = 20;

/// Checks that points go from left to right.
fn check_points(
    contour: &wire::Profile,
    at: &str,
    files: Option<&Files>,
    faults: &mut Vec<Finding>,
) -> Vec<Point2> {
    let (list, at) = match listed(contour, at, files) {
        Ok(Some(found)) => found,
        Ok(None) => return Vec::new(),
        Err(found) => {
            faults.extend(found);
            return Vec::new();
        }
    };
    let mut points: Vec<Point2> = list.iter().map(|&[x, z]| Point2::new(x, z)).collect();
    points.dedup();
    if points.len() < 2 {
        let message = format!("a contour needs two different points; this one has {}", points.len());
        faults.push(Finding::error(Code::TooFewPoints, at.clone(), message));
    }
    let falling = list.windows(2).enumerate().filter(|(_, pair)| pair[1][0] < pair[0][0]);
    faults.extend(falling.take(MOST_LISTED).map(|(index, pair)| {
        let message =
            format!("x falls from {} to {}; list a contour from left to right", pair[0][0], pair[1][0]);
        Finding::error(Code::ProfileFalls, format!("{at}/{}", index + 1), message)
    }));
    points
}

/// Points as they were listed, x and z in mm, and where.
type Listed = (Vec<[f64; 2]>, String);

/// The points of a contour and the pointer to them; none if they stand in a file that is not looked at yet.
fn listed(contour: &wire::Profile, at: &str, files: Option<&Files>) -> Result<Option<Listed>, Vec<Finding>> {
    match (&contour.points, &contour.file) {
        (Some(points), None) => Ok(Some((points.clone(), format!("{at}/points")))),
        (None, Some(name)) => {
            let Some(bytes) = files.and_then(|files| files.get(name)) else { return Ok(None) };
            contour_text::read(name, bytes).map(|points| Some((points, format!("{at}/file"))))
        }
        _ => Err(vec![Finding::error(Code::MissingField, at, "needs either points or file")]),
    }
}

/// What the contract names and the planner does not do yet is refused, not passed over.
fn refuse_unsupported(plan: &wire::Plan, faults: &mut Vec<Finding>) {
    if plan.lattice == LatticeChoice::Hybrid {
        faults.push(not_supported(
            "/input/plan/lattice",
            "hybrid lattices are not planned yet; best gives the best published one",
        ));
    }
    if matches!(plan.sequence, wire::Sequence::Sweep | wire::Sequence::Oneway) {
        faults.push(not_supported(
            "/input/plan/sequence",
            "cuts are planned in pairs, as published; use paired",
        ));
    }
}

fn not_supported(at: &str, message: &str) -> Finding {
    Finding::error(Code::NotSupported, at, message)
}

fn refuse_wide_swing(parameters: Option<&wire::Parameters>, tool: &wire::Tool, faults: &mut Vec<Finding>) {
    if let Some(parameters) = parameters
        && parameters.swing_angle_deg > tool.max_swing_angle_deg
    {
        let message = format!(
            "is {} degrees; the tool may be swung by {} at most",
            parameters.swing_angle_deg, tool.max_swing_angle_deg
        );
        faults.push(Finding::error(Code::OutOfRange, "/input/plan/parameters/swing_angle_deg", message));
    }
}

fn check_chosen(
    parameters: Option<&wire::Parameters>,
    at: &str,
    faults: &mut Vec<Finding>,
) -> Option<Chosen> {
    let parameters = parameters?;
    let swing = parameters.swing_angle_deg.to_radians();
    match (parameters.layer_spacing_mm, parameters.step_mm, parameters.overlap_ratio) {
        (Some(layer_spacing_mm), Some(step_mm), None) => {
            Some(Chosen::All { layer_spacing_mm, step_mm, swing })
        }
        (None, None, Some(overlap_ratio)) => Some(Chosen::BySwing { swing, overlap_ratio }),
        _ => {
            let message =
                "give layer_spacing_mm, step_mm and swing_angle_deg, or swing_angle_deg and overlap_ratio";
            faults.push(Finding::error(Code::MissingField, at, message));
            None
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::{Value, json};

    fn job() -> Value {
        json!({
            "blank": {"width_mm": 85, "length_mm": 50, "height_mm": 50},
            "profile": {"points": [[0, 10], [40, 10], [40, 20], [85, 5]]},
            "tool": {"rake_angle_deg": 60, "half_apex_angle_deg": 7.13, "max_cutting_length_mm": 10,
                "max_swing_angle_deg": 50},
            "process": {"cutting_speed_mm_s": 200, "travel_speed_mm_s": 200, "angular_speed_deg_s": 90,
                "safety_distance_mm": 10, "max_scallop_mm": 10}
        })
    }

    fn checked(change: impl FnOnce(&mut Value)) -> Result<CutInput, Vec<(Code, String)>> {
        let mut value = job();
        change(&mut value);
        let wire: wire::HoneycombCut = serde_json::from_value(value).unwrap();
        check_cut(&wire, None)
            .map_err(|faults| faults.into_iter().map(|fault| (fault.code, fault.at)).collect())
    }

    #[test]
    fn a_wall_is_part_of_a_contour_and_defaults_are_the_published_way() {
        let input = checked(|_| {}).unwrap();
        assert_eq!(input.profile.len(), 4);
        assert_eq!(input.lattice, LatticeChoice::Best);
        assert!((input.setting.blade.length.mm() - 10.0).abs() < 1e-12);
    }

    #[test]
    fn each_fault_is_named_with_its_place() {
        let refused = |change: fn(&mut Value)| checked(change).unwrap_err();
        assert_eq!(
            refused(|job| job["profile"]["points"] = json!([[0, 1], [50, 1], [40, 1], [85, 1]])),
            [(Code::ProfileFalls, "/input/profile/points/2".to_owned())]
        );
        assert_eq!(
            refused(|job| job["profile"]["points"] = json!([[0, 1], [80, 1]])),
            [(Code::ProfileSpan, "/input/profile/points".to_owned())]
        );
        assert_eq!(
            refused(|job| job["profile"]["points"] = json!([[0, -1], [85, 51]])),
            [
                (Code::OutOfRange, "/input/profile/points/0/1".to_owned()),
                (Code::OutOfRange, "/input/profile/points/1/1".to_owned())
            ]
        );
        assert_eq!(
            refused(|job| job["profile"]["points"] = json!([[0, 1], [0, 1]])).first().unwrap().0,
            Code::TooFewPoints
        );
        assert_eq!(
            refused(|job| job["tool"]["blade_length_mm"] = json!(9)),
            [(Code::OutOfRange, "/input/tool/blade_length_mm".to_owned())]
        );
        assert_eq!(
            refused(|job| job["plan"] = json!({"lattice": "hybrid", "sequence": "sweep"})),
            [
                (Code::NotSupported, "/input/plan/lattice".to_owned()),
                (Code::NotSupported, "/input/plan/sequence".to_owned())
            ]
        );
        assert_eq!(
            refused(|job| job["plan"] = json!({"parameters": {"swing_angle_deg": 30, "step_mm": 3}})),
            [(Code::MissingField, "/input/plan/parameters".to_owned())]
        );
    }
}
