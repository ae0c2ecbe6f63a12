//! Proof that nothing is shorter: the whole plane of (alpha, kappa) is covered with patches, none of which can
//! hold a time below what is known.
//!
//! A patch is given up when a bound from below reaches what is to be proved; otherwise it shrinks to the edge
//! toward which the time surely falls, or is split. The bounds, cheapest first:
//! - the time of the largest sizes and the least alpha in it (`Patch::coarse_bound_s`);
//! - for a piece and a leg, the time at a point less what the slopes within the patch can take off on the way from
//!   there to its ends (a mean value form: what it misses shrinks with the square of the patch);
//! - the same for the mean of the pieces and legs, weighted with the multipliers of the best set known: its slopes
//!   vanish there, so that patches around an optimum on a ridge between two pieces need not be tiny;
//! - where one of alpha and kappa is settled by a slope and the time is convex along the other: its tangent at the
//!   best set known, which is level, so that one patch around it does.

use super::jet::Jet;
use super::line::Line;
use super::patch::{Edge, Leg, Patch, Piece, Spread, largest_spacing_mm, least_time_s, piece_time_s};
use super::span::Span;
use crate::planning::honeycomb::model::{Model, Parameters};
use crate::planning::tolerance::OPTIMUM_GAP;

/// Weights of pieces and legs, that add up to 1.
pub(super) type Weights = [((Piece, Leg), f64); 8];

/// A set of parameters to beat.
#[derive(Debug, Clone, Copy)]
pub(super) struct Incumbent {
    pub time_s: f64,
    /// Its alpha in rad and its kappa.
    pub place: [f64; 2],
    pub weights: Weights,
}

/// How a search for something shorter ended.
#[derive(Debug, Clone, Copy)]
pub(super) enum Outcome {
    /// There is nothing shorter than this, in s.
    Proved(f64),
    /// There is: this set, not yet the best around it.
    Shorter(Parameters),
}

/// Patches still to be looked at, and what is known of those given up.
#[derive(Debug)]
pub(super) struct Cover<'a> {
    model: &'a Model,
    open: Vec<Patch>,
    /// The least bound of a patch that is too small to split, in s.
    least_s: f64,
    /// How many patches were looked at.
    pub patches: usize,
}

/// Most problems need some dozens of patches, one in a hundred thousand 20,000, where an optimum is held by no limit on
/// alpha and kappa; what is left beyond this is bounded coarsely.
const MOST_PATCHES: usize = 500_000;

/// A patch with sides below this share of the plane's is not split further: its corners are one point.
const SMALLEST_SIDE: f64 = 1e-13;

impl<'a> Cover<'a> {
    /// All of the plane.
    pub fn new(model: &'a Model) -> Self {
        let high = Edge::at(model, model.given().max_swing_rad);
        let all = Patch { low: Edge::at(model, 0.0), high, share: Span::new(0.0, 1.0) };
        Self { model, open: vec![all], least_s: f64::INFINITY, patches: 0 }
    }

    /// Looks for something shorter than the incumbent until there is nothing left to look at. Called again with a
    /// better incumbent, it goes on where it stopped.
    pub fn search(&mut self, incumbent: &Incumbent) -> Outcome {
        let enough_s = incumbent.time_s * (1.0 - OPTIMUM_GAP);
        while let Some(patch) = self.open.pop() {
            self.patches += 1;
            let coarse_s = patch.coarse_bound_s(self.model);
            if coarse_s >= enough_s {
                continue;
            }
            let look = Look::at(self.model, patch, incumbent, enough_s);
            match look.verdict() {
                Verdict::GivenUp => {}
                Verdict::Shrunk(patch) => self.open.push(patch),
                Verdict::Split(side) => match look.halves(side) {
                    Some(halves) if self.patches < MOST_PATCHES => self.open.extend(halves),
                    _ => self.least_s = self.least_s.min(coarse_s),
                },
            }
            if let Some(shorter) = look.shorter() {
                return Outcome::Shorter(shorter);
            }
        }
        Outcome::Proved(self.least_s.min(enough_s))
    }
}

/// What is to be done with a patch.
enum Verdict {
    GivenUp,
    Shrunk(Patch),
    Split(Side),
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Side {
    Angle,
    Share,
}

/// A bound from below, and what either side of the patch takes off it.
#[derive(Clone, Copy)]
struct Bound {
    time_s: f64,
    losses: [f64; 2],
}

/// A patch that is looked at.
struct Look<'a> {
    model: &'a Model,
    patch: Patch,
    middle: Edge,
    goal: &'a Incumbent,
    enough_s: f64,
}

type Pieces = [Option<Piece>; 4];

impl<'a> Look<'a> {
    fn at(model: &'a Model, patch: Patch, goal: &'a Incumbent, enough_s: f64) -> Self {
        let angle = Span::new(patch.low.swing.angle, patch.high.swing.angle);
        let middle = if angle.low == angle.high { patch.low } else { Edge::at(model, middle(angle)) };
        Self { model, patch, middle, goal, enough_s }
    }

    fn verdict(&self) -> Verdict {
        let patch = &self.patch;
        if patch.low.swing.angle == 0.0 {
            return Verdict::Split(Side::Angle);
        }
        let spread = patch.spread();
        let pieces = self.deciding(&spread);
        if pieces.iter().flatten().all(|piece| piece.falls_with_share()) && patch.share.low < 1.0 {
            // Only the edge at the largest kappa counts, and that is the next patch's unless it is the plane's.
            let edge = Patch { share: Span::at(1.0), ..*patch };
            return if patch.share.high < 1.0 { Verdict::GivenUp } else { Verdict::Shrunk(edge) };
        }
        if patch.share.low == 0.0 {
            return Verdict::Split(Side::Share);
        }
        self.verdict_by_slopes(&pieces, &spread)
    }

    /// The pieces that have the smallest layer spacing anywhere in the patch.
    fn deciding(&self, spread: &Spread) -> Pieces {
        let spacings = Piece::ALL.map(|piece| (piece, spread.spacing(self.model, piece)));
        let least = spacings.iter().map(|(_, spacing)| spacing.high).fold(f64::INFINITY, f64::min);
        spacings.map(|(piece, spacing)| (spacing.low <= least).then_some(piece))
    }

    fn verdict_by_slopes(&self, pieces: &Pieces, spread: &Spread) -> Verdict {
        let mut best: Option<Bound> = None;
        let mut together: Option<[Span; 2]> = None;
        let mut known = true;
        for piece in pieces.iter().flatten() {
            let sizes = spread.sizes(self.model, *piece);
            for leg in spread.legs(self.model, &sizes) {
                let Some(slopes) = spread.slopes(self.model, &sizes, leg) else {
                    known = false;
                    continue;
                };
                together =
                    Some(together.map_or(slopes, |seen| [seen[0].with(slopes[0]), seen[1].with(slopes[1])]));
                let slopes = self.slopes_at_least(*piece, leg, slopes);
                let bound = self.bound(slopes, &[((*piece, leg), 1.0)]);
                if bound.time_s >= self.enough_s {
                    return Verdict::GivenUp;
                }
                if best.is_none_or(|best| bound.time_s > best.time_s) {
                    best = Some(bound);
                }
            }
        }
        if let Some(bound) = self.weighted_bound(spread)
            && best.is_none_or(|best| bound.time_s > best.time_s)
        {
            best = Some(bound);
        }
        if best.is_some_and(|bound| bound.time_s >= self.enough_s) {
            return Verdict::GivenUp;
        }
        together
            .filter(|_| known)
            .and_then(|slopes| self.shrunk(slopes))
            .unwrap_or_else(|| self.split(best, together))
    }

    /// The slopes of a piece and a leg where it is least: at the largest kappa, where its time surely falls with it.
    fn slopes_at_least(&self, piece: Piece, leg: Leg, slopes: [Span; 2]) -> [Span; 2] {
        let share = self.patch.share;
        if !piece.falls_with_share() || share.low == share.high {
            return slopes;
        }
        let edge = Patch { share: Span::at(share.high), ..self.patch }.spread();
        edge.slopes(self.model, &edge.sizes(self.model, piece), leg).unwrap_or(slopes)
    }

    /// The bound of the weighted mean, if its pieces are within their domain.
    fn weighted_bound(&self, spread: &Spread) -> Option<Bound> {
        let mut mean = [Span::at(0.0); 2];
        let mut weights = self.goal.weights;
        let mut count = 0;
        for index in 0..weights.len() {
            let ((piece, leg), weight) = weights[index];
            if weight > 0.0 {
                let slopes = spread.slopes(self.model, &spread.sizes(self.model, piece), leg)?;
                mean = [mean[0] + slopes[0] * weight, mean[1] + slopes[1] * weight];
                weights.swap(count, index);
                count += 1;
            }
        }
        (count > 1).then(|| self.bound(mean, &weights[..count]))
    }

    /// The best bound of a mean of pieces and legs with these slopes.
    fn bound(&self, slopes: [Span; 2], mean: &[((Piece, Leg), f64)]) -> Bound {
        let mut bound = self.bound_by_slopes(slopes, mean);
        if bound.time_s < self.enough_s
            && let Some(time_s) = self.bound_by_tangent(slopes, mean)
            && time_s >= self.enough_s
        {
            bound.time_s = time_s;
        }
        bound
    }

    /// From the end toward which the time surely falls, or from the middle.
    fn bound_by_slopes(&self, slopes: [Span; 2], mean: &[((Piece, Leg), f64)]) -> Bound {
        let Patch { low, high, share } = &self.patch;
        let half = [0.5 * (high.swing.angle - low.swing.angle), 0.5 * (share.high - share.low)];
        let edge = at_least(slopes[0], low, &self.middle, high);
        let ratio = edge.ratio(*at_least(slopes[1], &share.low, &middle(*share), &share.high));
        let losses = [0, 1].map(|d| if slopes[d].has_sign() { 0.0 } else { half[d] * slopes[d].magnitude() });
        let times =
            mean.iter().map(|(which, weight)| weight * piece_time_s(self.model, *which, &edge.swing, ratio));
        Bound { time_s: times.sum::<f64>() - losses[0] - losses[1], losses }
    }

    /// Where one of alpha and kappa is settled, and along the other the time is convex: from the tangent at the place
    /// to beat, or the nearest to it.
    fn bound_by_tangent(&self, slopes: [Span; 2], mean: &[((Piece, Leg), f64)]) -> Option<f64> {
        let Patch { low, high, share } = &self.patch;
        let [angle, kappa] = self.goal.place;
        if slopes[1].has_sign() || share.low == share.high {
            let kappa = *at_least(slopes[1], &share.low, &share.low, &share.high);
            self.mean(&Line::along_angle(low, high, kappa), mean).filter(|jet| jet.curvature.low >= 0.0)?;
            let ends = Span::new(low.swing.angle, high.swing.angle);
            let at = ends.nearest(angle);
            let edge = Edge::at(self.model, at);
            Some(self.mean(&Line::along_angle(&edge, &edge, kappa), mean)?.tangent_least(at, ends))
        } else if slopes[0].has_sign() || low.swing.angle == high.swing.angle {
            let edge = at_least(slopes[0], low, low, high);
            self.mean(&Line::along_share(edge, *share), mean).filter(|jet| jet.curvature.low >= 0.0)?;
            let at = share.nearest(kappa);
            Some(self.mean(&Line::along_share(edge, Span::at(at)), mean)?.tangent_least(at, *share))
        } else {
            None
        }
    }

    /// A mean of pieces and legs along a line, if all of them are within their domain.
    fn mean(&self, line: &Line, mean: &[((Piece, Leg), f64)]) -> Option<Jet> {
        let mut sum = Jet::at(0.0);
        for (which, weight) in mean {
            sum = sum + line.time_s(self.model, *which)? * *weight;
        }
        Some(sum)
    }

    /// Where the time surely rises or falls throughout. The edge toward which it falls is kept where that is the
    /// lower one; the upper one is also the next patch's lower one, unless it is the plane's.
    fn shrunk(&self, [by_angle, by_share]: [Span; 2]) -> Option<Verdict> {
        let Patch { low, high, share } = self.patch;
        let last = self.model.given().max_swing_rad;
        if low.swing.angle < high.swing.angle && by_angle.has_sign() {
            let falls = by_angle.high <= 0.0;
            let edge = if falls { high } else { low };
            let next = falls && high.swing.angle < last;
            let edge = Patch { low: edge, high: edge, share };
            return Some(if next { Verdict::GivenUp } else { Verdict::Shrunk(edge) });
        }
        if share.low < share.high && by_share.has_sign() {
            let falls = by_share.high <= 0.0;
            let edge = if falls { share.high } else { share.low };
            let edge = Patch { low, high, share: Span::at(edge) };
            return Some(if falls && share.high < 1.0 { Verdict::GivenUp } else { Verdict::Shrunk(edge) });
        }
        None
    }

    /// Across the side that takes more off the best bound; where neither does, along which the time varies more; where
    /// that is not known, the one that is longer for its size.
    fn split(&self, best: Option<Bound>, slopes: Option<[Span; 2]>) -> Verdict {
        let Patch { low, high, share } = &self.patch;
        let losses = best
            .map(|bound| bound.losses)
            .filter(|losses| best.is_some_and(|b| b.time_s + losses[0] + losses[1] >= self.enough_s));
        let lengths = [high.swing.angle - low.swing.angle, share.high - share.low];
        let sizes = [high.swing.angle, share.high];
        let [angle, share] = losses.unwrap_or_else(|| {
            [0, 1].map(|d| lengths[d] * slopes.map_or(sizes[d].recip(), |slopes| slopes[d].magnitude()))
        });
        Verdict::Split(if angle >= share { Side::Angle } else { Side::Share })
    }

    /// Both halves of the patch, unless it is too small.
    fn halves(&self, side: Side) -> Option<[Patch; 2]> {
        let Patch { low, high, share } = self.patch;
        match side {
            Side::Angle => {
                (high.swing.angle - low.swing.angle > SMALLEST_SIDE * high.swing.angle).then_some([
                    Patch { high: self.middle, ..self.patch },
                    Patch { low: self.middle, ..self.patch },
                ])
            }
            Side::Share => (share.high - share.low > SMALLEST_SIDE).then(|| {
                let at = middle(share);
                [Span::new(share.low, at), Span::new(at, share.high)]
                    .map(|share| Patch { share, ..self.patch })
            }),
        }
    }

    /// A set of the patch that is shorter than what is known, if one of those looked at is.
    fn shorter(&self) -> Option<Parameters> {
        let swing = &self.middle.swing;
        let ratios = [middle(self.patch.share), self.patch.share.high].map(|share| self.middle.ratio(share));
        let ratio =
            ratios.into_iter().find(|&ratio| least_time_s(self.model, swing, ratio) < self.enough_s)?;
        let layer_spacing_mm = largest_spacing_mm(self.model, swing, ratio);
        Some(Parameters { layer_spacing_mm, step_mm: 2.0 * layer_spacing_mm * ratio, swing_rad: swing.angle })
    }
}

fn middle(span: Span) -> f64 {
    span.low + 0.5 * (span.high - span.low)
}

/// The end toward which something with these slopes falls, or the middle.
fn at_least<'a, T>(slopes: Span, low: &'a T, middle: &'a T, high: &'a T) -> &'a T {
    if slopes.low >= 0.0 {
        low
    } else if slopes.high <= 0.0 {
        high
    } else {
        middle
    }
}
