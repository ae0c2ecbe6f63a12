//! What a knife cuts between going down and going up.

/// The way of one knife in roll coordinates.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Stroke {
    /// Points (r, v) in mm, no two equal in a row.
    pub(super) points: Vec<[f64; 2]>,
    /// The program line that led to each point but the first.
    pub(super) lines: Vec<usize>,
}

impl Stroke {
    /// A knife goes down at a point.
    pub(super) fn at(point: [f64; 2]) -> Self {
        Self { points: vec![point], lines: Vec::new() }
    }

    /// What an earlier program has cut: no line of this one made it.
    pub(super) fn made_before(points: &[[f64; 2]]) -> Self {
        Self { points: points.to_vec(), lines: vec![0; points.len().saturating_sub(1)] }
    }

    /// It is moved to another point.
    pub(super) fn cut_to(&mut self, point: [f64; 2], line: usize) {
        self.points.push(point);
        self.lines.push(line);
    }

    /// How far it goes, in mm.
    pub(super) fn length_mm(&self) -> f64 {
        self.points.windows(2).map(|pair| (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1])).sum()
    }

    /// Whether it has cut anything.
    pub(super) fn is_empty(&self) -> bool {
        self.lines.is_empty()
    }
}
