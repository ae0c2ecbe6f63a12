//! Rectangles of the plane of (alpha, kappa), and how steep the time can be within one.
//!
//! The step is s = 2 h tan(kappa alpha): `kappa`, from 0 to 1, is what share of the swing angle it uses; at 1 cuts
//! do not overlap. At a given (alpha, kappa) the time falls while h grows, so h is the least of four: where the
//! cutting length, the scallop, the layers or the points bound it (its *piece*). Falling is seen from Eq. 11:
//! with n >= 0, -h dT/dh and -s dT/ds are sums of positive terms, `fall_h` and `fall_s` below. The way to the next
//! point lasts the longer of turning and travelling (its *leg*). So
//!
//! ```text
//! least T at (alpha, kappa) = max over pieces and legs of T(piece, leg; alpha, kappa),
//! ```
//!
//! and each of the eight is smooth, and a bound from below of the whole.

use super::span::Span;
use crate::planning::honeycomb::lattice_kind::Lattice;
use crate::planning::honeycomb::model::{Model, Swing};

/// What bounds the layer spacing at a given (alpha, kappa).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Piece {
    CuttingLength,
    Layers,
    Scallop,
    Points,
}

/// What decides how long the way to the next point lasts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Leg {
    Turn,
    Travel,
}

/// A swing angle with the slope of its turn.
#[derive(Debug, Clone, Copy)]
pub(super) struct Edge {
    pub swing: Swing,
    /// d `turn_s` / d alpha: it grows with alpha.
    pub turn_slope: f64,
    /// d2 `turn_s` / d alpha2: it falls with alpha.
    pub turn_curvature: f64,
}

/// A closed rectangle of the plane.
#[derive(Debug, Clone, Copy)]
pub(super) struct Patch {
    /// At its smallest alpha.
    pub low: Edge,
    /// At its largest alpha.
    pub high: Edge,
    /// Its kappas.
    pub share: Span,
}

/// What a patch holds, whatever the piece.
#[derive(Debug, Clone, Copy)]
pub(super) struct Spread {
    angle: Span,
    tan: Span,
    /// 1 / cos(alpha).
    sec: Span,
    turn_s: Span,
    turn_slope: Span,
    share: Span,
    /// tan(kappa alpha) = s / 2h.
    ratio: Span,
}

/// What a patch holds of one piece: sizes in mm, and slopes of their logarithms by alpha and by kappa.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sizes {
    pub spacing: Span,
    pub half_step: Span,
    spacing_slopes: [Span; 2],
    step_slopes: [Span; 2],
}

impl Piece {
    pub const ALL: [Self; 4] = [Self::CuttingLength, Self::Layers, Self::Scallop, Self::Points];

    /// Whether its time surely falls with kappa: h stays, s grows.
    pub fn falls_with_share(self) -> bool {
        matches!(self, Self::CuttingLength | Self::Layers)
    }

    /// The layer spacing in mm at a swing angle, where s = 2 h `ratio`.
    pub fn spacing_mm(self, model: &Model, swing: &Swing, ratio: f64) -> f64 {
        match self {
            Self::CuttingLength => model.depth_mm * swing.cos,
            Self::Layers => model.max_layer_spacing_mm,
            Self::Scallop => {
                model.given().max_scallop_mm / scallop_of_spacing_1(model, ratio, 1.0 + ratio / swing.tan)
            }
            Self::Points => 0.5 * model.max_step_mm / ratio,
        }
    }
}

/// Eq. 12 with h = 1 and s = 2 `ratio`; `down` is 2 - eps.
fn scallop_of_spacing_1(model: &Model, ratio: f64, down: f64) -> f64 {
    match model.given().lattice {
        Lattice::Interlaced => down,
        Lattice::Orthogonal | Lattice::Free => (ratio * ratio + down * down).sqrt(),
    }
}

/// The layer spacing in mm at a swing angle, where s = 2 h `ratio`: as large as all limits allow.
pub(super) fn largest_spacing_mm(model: &Model, swing: &Swing, ratio: f64) -> f64 {
    Piece::ALL.into_iter().map(|piece| piece.spacing_mm(model, swing, ratio)).fold(f64::INFINITY, f64::min)
}

/// The least T in s at a swing angle, where s = 2 h `ratio`.
pub(super) fn least_time_s(model: &Model, swing: &Swing, ratio: f64) -> f64 {
    let spacing = largest_spacing_mm(model, swing, ratio);
    model.time_s(spacing, 2.0 * spacing * ratio, swing)
}

/// T(piece, leg) in s.
pub(super) fn piece_time_s(model: &Model, (piece, leg): (Piece, Leg), swing: &Swing, ratio: f64) -> f64 {
    let spacing = piece.spacing_mm(model, swing, ratio);
    let step = 2.0 * spacing * ratio;
    let next_point_s = match leg {
        Leg::Turn => swing.turn_s,
        Leg::Travel => model.step_travel_s(step),
    };
    model.time_with_next_point_s(spacing, step, swing, next_point_s)
}

impl Edge {
    /// At `angle` in [0, pi/2].
    pub fn at(model: &Model, angle: f64) -> Self {
        let swing = model.swing(angle);
        let given = model.given();
        let (rake_sin, rake_cos) = given.rake_rad.sin_cos();
        let (sin, per_rad) = (swing.tan * swing.cos, 2.0 / given.angular_speed_rad_s);
        let squared = sin * sin + (swing.cos * rake_cos) * (swing.cos * rake_cos);
        if squared <= 0.0 {
            // With theta = pi/2 the turn is 2 alpha / omega, at alpha = 0 too.
            return Self { swing, turn_slope: per_rad, turn_curvature: 0.0 };
        }
        let across = squared.sqrt();
        let turn_slope = rake_sin * sin / across * per_rad;
        let turn_curvature = rake_sin * swing.cos * rake_cos * rake_cos / (across * squared) * per_rad;
        Self { swing, turn_slope, turn_curvature }
    }

    /// tan(kappa alpha).
    pub fn ratio(&self, share: f64) -> f64 {
        if share == 1.0 { self.swing.tan } else { (share * self.swing.angle).tan() }
    }
}

impl Patch {
    /// No time within it is less, in s: that of the largest spacing and step anywhere in it at its least alpha. T
    /// falls with h and s and grows with alpha.
    pub fn coarse_bound_s(&self, model: &Model) -> f64 {
        let (low, high) = (&self.low.swing, &self.high.swing);
        let [least, most] = [self.low.ratio(self.share.low), self.high.ratio(self.share.high)];
        let scallop = model.given().max_scallop_mm;
        let spacing = (model.depth_mm * low.cos)
            .min(model.max_layer_spacing_mm)
            .min(scallop / scallop_of_spacing_1(model, least, 1.0 + least / high.tan))
            .min(0.5 * model.max_step_mm / least);
        let steepness = most.recip() + high.tan.recip();
        let half_step = (scallop / scallop_of_half_step_1(model, steepness))
            .min(0.5 * model.max_step_mm)
            .min(spacing * most);
        model.time_s(spacing, 2.0 * half_step, low)
    }

    /// What it holds; alpha and kappa are above 0.
    pub fn spread(&self) -> Spread {
        let (low, high) = (&self.low, &self.high);
        Spread {
            angle: Span::new(low.swing.angle, high.swing.angle),
            tan: Span::new(low.swing.tan, high.swing.tan),
            sec: Span::new(low.swing.cos.recip(), high.swing.cos.recip()),
            turn_s: Span::new(low.swing.turn_s, high.swing.turn_s),
            turn_slope: Span::new(low.turn_slope, high.turn_slope),
            share: self.share,
            ratio: Span::new(low.ratio(self.share.low), high.ratio(self.share.high)),
        }
    }
}

/// Eq. 12 with s = 2; `steepness` is 1 / tan(kappa alpha) + 1 / tan(alpha) = (2 - eps) h.
fn scallop_of_half_step_1(model: &Model, steepness: f64) -> f64 {
    match model.given().lattice {
        Lattice::Interlaced => steepness,
        Lattice::Orthogonal | Lattice::Free => (1.0 + steepness * steepness).sqrt(),
    }
}

impl Spread {
    /// d ln tan(kappa alpha) by alpha and by kappa: kappa and alpha times 1 / (sin cos)(kappa alpha).
    fn ratio_slopes(&self) -> [Span; 2] {
        let stretch = self.ratio.plus_recip();
        [self.share * stretch, self.angle * stretch]
    }

    /// The layer spacings in mm that it holds of a piece.
    pub fn spacing(&self, model: &Model, piece: Piece) -> Span {
        match piece {
            Piece::CuttingLength => self.sec.recip() * model.depth_mm,
            Piece::Layers => Span::at(model.max_layer_spacing_mm),
            Piece::Scallop => self.scallop_height(model).recip() * model.given().max_scallop_mm,
            Piece::Points => self.ratio.recip() * (0.5 * model.max_step_mm),
        }
    }

    /// Eq. 12 with h = 1.
    fn scallop_height(&self, model: &Model) -> Span {
        let down = Span::new(1.0 + self.ratio.low / self.tan.high, 1.0 + self.ratio.high / self.tan.low);
        match model.given().lattice {
            Lattice::Interlaced => down,
            Lattice::Orthogonal | Lattice::Free => (down.square() + self.ratio.square()).sqrt(),
        }
    }

    /// What it holds of a piece.
    pub fn sizes(&self, model: &Model, piece: Piece) -> Sizes {
        match piece {
            Piece::CuttingLength => self.cutting_length(model),
            Piece::Layers => self.layers(model),
            Piece::Scallop => self.scallop(model),
            Piece::Points => self.points(model),
        }
    }

    /// h = k d cos(alpha), s = 2 h tan(kappa alpha).
    fn cutting_length(&self, model: &Model) -> Sizes {
        let spacing = self.spacing(model, Piece::CuttingLength);
        let [by_angle, by_share] = self.ratio_slopes();
        if self.share == Span::at(1.0) {
            // s = 2 k d sin(alpha), whose slope is cot(alpha).
            let half_step =
                Span::new(self.tan.low / self.sec.low, self.tan.high / self.sec.high) * model.depth_mm;
            return Sizes {
                spacing,
                half_step,
                spacing_slopes: [-self.tan, Span::at(0.0)],
                step_slopes: [self.tan.recip(), by_share],
            };
        }
        Sizes {
            spacing,
            half_step: spacing * self.ratio,
            spacing_slopes: [-self.tan, Span::at(0.0)],
            step_slopes: [by_angle - self.tan, by_share],
        }
    }

    /// h stays, s = 2 h tan(kappa alpha).
    fn layers(&self, model: &Model) -> Sizes {
        Sizes {
            spacing: self.spacing(model, Piece::Layers),
            half_step: self.ratio * model.max_layer_spacing_mm,
            spacing_slopes: [Span::at(0.0); 2],
            step_slopes: self.ratio_slopes(),
        }
    }

    /// s stays, h = s / (2 tan(kappa alpha)).
    fn points(&self, model: &Model) -> Sizes {
        let half_step = 0.5 * model.max_step_mm;
        Sizes {
            spacing: self.spacing(model, Piece::Points),
            half_step: Span::at(half_step),
            spacing_slopes: self.ratio_slopes().map(|slope| -slope),
            step_slopes: [Span::at(0.0); 2],
        }
    }

    /// Eq. 12 solved for s / 2 and for h. With z = cot(kappa alpha) + cot(alpha), s / 2 = `delta_max` / sqrt(1 + z^2),
    /// interlaced `delta_max` / z, so that d ln s = -z dz / (1 + z^2), interlaced -dz / z.
    fn scallop(&self, model: &Model) -> Sizes {
        let scallop = model.given().max_scallop_mm;
        let steepness = self.ratio.recip() + self.tan.recip();
        let (distance, gain) = match model.given().lattice {
            Lattice::Interlaced => (steepness, steepness.recip()),
            Lattice::Orthogonal | Lattice::Free => {
                ((steepness.square() + 1.0).sqrt(), steepness.plus_recip().recip())
            }
        };
        let [by_angle, by_share] = self.ratio_slopes();
        // d cot(x) = -(1 + cot(x)^2) dx.
        let turn = self.ratio.recip().square() + 1.0;
        let step_slopes =
            [gain * (self.share * turn + self.tan.recip().square() + 1.0), gain * self.angle * turn];
        Sizes {
            spacing: self.spacing(model, Piece::Scallop),
            half_step: distance.recip() * scallop,
            spacing_slopes: [step_slopes[0] - by_angle, step_slopes[1] - by_share],
            step_slopes,
        }
    }

    /// The legs that can be the longer one anywhere in the patch.
    pub fn legs(&self, model: &Model, sizes: &Sizes) -> impl Iterator<Item = Leg> {
        let travel_s = sizes.half_step * (2.0 / model.given().travel_speed_mm_s);
        let turn = (self.turn_s.high >= travel_s.low).then_some(Leg::Turn);
        let travel = (travel_s.high >= self.turn_s.low).then_some(Leg::Travel);
        turn.into_iter().chain(travel)
    }

    /// dT/dalpha and dT/dkappa in s over all of the patch, for a piece and a leg of the way to the next point.
    ///
    /// `None` where the piece leaves the domain in which T falls with h: less than no layers.
    pub fn slopes(&self, model: &Model, sizes: &Sizes, leg: Leg) -> Option<[Span; 2]> {
        let given = model.given();
        let (spacing, step) = (sizes.spacing, sizes.half_step * 2.0);
        let layers = spacing.recip() * model.cut_height_mm + -0.5;
        let points = step.recip() * given.blank_width_mm + 0.5;
        let travel_s = step * given.travel_speed_mm_s.recip();
        let extensions_s = spacing * self.sec * (model.extension_factor * 4.0 / given.cutting_speed_mm_s);
        let turned = self.turn_s + 2.0 * given.blank_length_mm / given.cutting_speed_mm_s;
        let (next_point_s, turns) = match leg {
            Leg::Turn => (self.turn_s, 2.0),
            Leg::Travel => (travel_s, 1.0),
        };
        let least = model.next_layer_s(spacing.high, step.high);
        let next_layer_s = Span::new(least, model.next_layer_s(spacing.low, step.low));
        let layer = points * (turned + next_point_s) + next_layer_s;
        if layers.low < 0.0 || layer.low < 0.0 {
            return None;
        }
        let rest = points * extensions_s * 0.5 + layers * spacing * given.travel_speed_mm_s.recip();
        let fall_h = (layers + 0.5) * layer + rest;
        let fall_s = match leg {
            Leg::Turn => layers * ((points + -0.5) * (turned + extensions_s + next_point_s) + travel_s * 0.5),
            Leg::Travel => layers * (points + -0.5) * (turned + extensions_s),
        };
        let rise = layers * points * (extensions_s * self.tan + self.turn_slope * turns);
        let slope = |d: usize| -(fall_h * sizes.spacing_slopes[d]) - fall_s * sizes.step_slopes[d];
        Some([slope(0) + rise, slope(1)])
    }
}
