//! The limits of the published model (Eqs. 13 and 14, domain.md B2).

/// What bounds the path parameters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Limit {
    /// h <= k L_max sin(theta - beta) cos(alpha).
    CuttingLength,
    /// s <= 2 h tan(alpha): the overlap ratio is not negative.
    Step,
    /// delta <= delta_max.
    Scallop,
    /// alpha <= alpha_max.
    SwingAngle,
    /// n >= 1, below which the averages lose their sense.
    Layers,
    /// m >= 1, likewise.
    Points,
}

impl Limit {
    /// How many there are.
    pub const COUNT: usize = 6;

    /// Every limit, in the order of `Model::loads`.
    pub const ALL: [Self; Self::COUNT] =
        [Self::CuttingLength, Self::Step, Self::Scallop, Self::SwingAngle, Self::Layers, Self::Points];

    /// The word for it in reports.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::CuttingLength => "cutting_length",
            Self::Step => "step",
            Self::Scallop => "scallop",
            Self::SwingAngle => "swing_angle",
            Self::Layers => "layers",
            Self::Points => "points",
        }
    }
}

impl std::fmt::Display for Limit {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.as_str())
    }
}
