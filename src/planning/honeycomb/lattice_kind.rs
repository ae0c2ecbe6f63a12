//! The three lattices of the paper (Cui et al. 2020, section II.A, Fig. 4).

/// How the tips of one layer lie to those of the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lattice {
    /// Below one another.
    Orthogonal,
    /// Every second layer shifted by half a step.
    Interlaced,
    /// Anywhere on each layer.
    Free,
}

impl Lattice {
    /// The word for it in job documents and reports.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Orthogonal => "orthogonal",
            Self::Interlaced => "interlaced",
            Self::Free => "free",
        }
    }

    /// k of h <= k d cos(alpha): what of the height of an arm a layer may take (domain.md B2; Eq. 4 is 2/3).
    #[must_use]
    pub fn depth_factor(self) -> f64 {
        match self {
            Self::Orthogonal => 2.0 / 3.0,
            Self::Interlaced => 1.0,
            Self::Free => 0.5,
        }
    }
}
