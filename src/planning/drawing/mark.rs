//! Marks of single places, told apart by their shape where colours do not show.

use super::svg::{Path, Spot, Svg, spot};

/// Half of the size of a mark, in mm of the sheet.
pub const MARK_MM: f64 = 1.3;

/// The shape of a mark.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mark {
    /// A full disc.
    Disc,
    /// A hollow one.
    Ring,
    /// A full square on its corner.
    Diamond,
    /// An oblique cross.
    Cross,
}

impl Mark {
    /// Draws the mark. `ink` is the class of its colour.
    pub fn draw(self, svg: &mut Svg, ink: &str, at: Spot) {
        match self {
            Self::Disc => svg.disc(&format!("mark {ink}"), at, 0.8 * MARK_MM),
            Self::Ring => svg.disc(&format!("ring {ink}"), at, MARK_MM),
            Self::Diamond => svg.path(&format!("mark {ink}"), &diamond(at), ""),
            Self::Cross => {
                svg.path("cross-halo", &cross(at), "");
                svg.path(&format!("cross {ink}"), &cross(at), "");
            }
        }
    }
}

fn diamond(at: Spot) -> Path {
    let mut path = Path::default();
    let corners = [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)];
    path.closed(corners.map(|(x, y)| spot(at.x + x * MARK_MM, at.y + y * MARK_MM)));
    path
}

fn cross(at: Spot) -> Path {
    let mut path = Path::default();
    for y in [-MARK_MM, MARK_MM] {
        path.open([spot(at.x - MARK_MM, at.y - y), spot(at.x + MARK_MM, at.y + y)]);
    }
    path
}
