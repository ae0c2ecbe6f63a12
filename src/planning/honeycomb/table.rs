//! The rows that a planner prints: the paper's way and ours, side by side.

use super::attempt::Attempt;
use super::model::Parameters;
use super::model::estimate::Estimate;
use super::optimum::Optimum;
use super::plan::{Plan, Way};

/// The table of a plan, a line each.
#[must_use]
pub fn lines(plan: &Plan) -> Vec<String> {
    let mut lines = vec![format!(
        "{:<22}{:>8}{:>8}{:>9}{:>7}{:>6}{:>11}{:>11}{:>10}{:>10}",
        "", "h mm", "s mm", "alpha", "layers", "tips", "T model s", "T counted", "scallop", "cut within"
    )];
    let named = [
        ("initial", plan.initial.as_ref()),
        ("published", Some(plan.published.as_ref().unwrap_or(&plan.best))),
        ("planned", Some(&plan.best)),
    ];
    lines.extend(named.into_iter().filter_map(|(name, way)| way.map(|way| row(name, way))));
    lines.push(format!("no plan has fewer than {} tips", plan.bound_tips));
    lines
}

fn row(name: &str, way: &Way) -> String {
    let Attempt { lattice, spacing, tips, replay, .. } = &way.attempt;
    let scallop = replay.swept.remains.as_ref().and_then(|remains| remains.scallop.as_ref());
    let mark = if way.attempt.is_sound() { "" } else { "  (not usable)" };
    format!(
        "{:<22}{:>8.3}{:>8.3}{:>9.3}{:>7}{:>6}{:>11.3}{:>11.3}{:>10.3}{:>10.4}{mark}",
        format!("{name} ({})", lattice.as_str()),
        spacing.layer,
        spacing.step,
        spacing.swing.to_degrees(),
        tips.len(),
        replay.tips(),
        way.estimate.time_s,
        replay.times.total_s(),
        scallop.map_or(0.0, |scallop| scallop.distance),
        replay.cut_deviation_mm
    )
}

/// The table of an optimum, a line each.
#[must_use]
pub fn optimum_lines(optimum: &Optimum, initial: Option<&Estimate>) -> Vec<String> {
    let mut lines = vec![format!(
        "{:<10}{:>9}{:>9}{:>9}{:>11}{:>11}{:>11}{:>11}{:>10}",
        "", "h mm", "s mm", "alpha", "T s", "cutting s", "turning s", "moving s", "scallop"
    )];
    let row = |name: &str, estimate: &Estimate| {
        let Parameters { layer_spacing_mm, step_mm, swing_rad } = estimate.parameters;
        format!(
            "{name:<10}{layer_spacing_mm:>9.3}{step_mm:>9.3}{:>9.3}{:>11.3}{:>11.3}{:>11.3}{:>11.3}{:>10.3}",
            swing_rad.to_degrees(),
            estimate.time_s,
            estimate.cutting_s,
            estimate.turning_s,
            estimate.moving_s,
            estimate.scallop_mm
        )
    };
    lines.extend(initial.map(|initial| row("initial", initial)));
    lines.push(row("optimum", &optimum.estimate));
    let active: Vec<_> = optimum.active.iter().map(|active| active.limit.as_str()).collect();
    let saved = initial.map(|initial| (1.0 - optimum.estimate.time_s / initial.time_s) * 100.0);
    let saved =
        saved.map_or_else(String::new, |saved| format!("{saved:.2} % less time than the initial set; "));
    lines.push(format!(
        "{saved}limits that hold it: {}",
        if active.is_empty() { "none".to_owned() } else { active.join(", ") }
    ));
    lines
}
