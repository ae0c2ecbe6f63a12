//! A connected piece of stock within one tile.

use super::grid::{Border, Frame, GridPoint, placed};
use super::profile::Profile;
use crate::planning::tolerance::{SLIVER_UNITS, TILE_SNAP_UNITS};

/// A polygon with holes; what it shares with the pieces of the tiles around it.
#[derive(Debug, Clone)]
pub(super) struct Piece {
    pub tile: usize,
    /// The outline counter-clockwise, then the holes clockwise.
    pub contours: Vec<Vec<GridPoint>>,
    /// Its bounding box.
    pub frame: Frame,
    /// Twice its area, in square units.
    pub area: i128,
    /// By border of its tile, where it reaches that border: rising intervals of the other coordinate.
    contacts: [Vec<[i64; 2]>; 4],
}

impl Piece {
    /// A whole tile.
    pub(super) fn whole(tile: usize, frame: Frame) -> Self {
        let Frame { low, high } = frame;
        let corners = vec![low, GridPoint::new(high.x, low.y), high, GridPoint::new(low.x, high.y)];
        Self::new(tile, frame, vec![corners]).expect("a tile has an area")
    }

    /// A polygon within a tile; `None` if nothing is left of it on the grid.
    pub(super) fn new(tile: usize, frame: Frame, contours: Vec<Vec<GridPoint>>) -> Option<Self> {
        let contours: Vec<_> = contours.into_iter().filter_map(|points| settled(points, frame)).collect();
        let area: i128 = contours.iter().map(|points| twice_area(points)).sum();
        let outline = contours.first().filter(|_| area > 0)?;
        let contacts = Border::ALL.map(|border| contacts(&contours, frame, border));
        Some(Self { tile, frame: bounding(outline), area, contacts, contours })
    }

    /// Whether it touches another piece across a border of its tile.
    pub(super) fn touches(&self, border: Border, other: &Self) -> bool {
        let (own, others) = (&self.contacts[border as usize], &other.contacts[border.opposite() as usize]);
        let (mut i, mut j, mut shared) = (0, 0, 0);
        while let (Some(one), Some(two)) = (own.get(i), others.get(j)) {
            shared += (one[1].min(two[1]) - one[0].max(two[0])).max(0);
            if one[1] <= two[1] { i += 1 } else { j += 1 }
        }
        shared > SLIVER_UNITS
    }

    /// Whether it reaches a border of its tile with more than a sliver.
    pub(super) fn reaches(&self, border: Border) -> bool {
        self.contacts[border as usize].iter().map(|[from, to]| to - from).sum::<i64>() > SLIVER_UNITS
    }

    pub(super) fn edges(&self) -> impl Iterator<Item = [GridPoint; 2]> + '_ {
        self.contours.iter().flat_map(|points| edges_of(points))
    }

    /// Its area below the contour of the part, in mm^2.
    pub(super) fn area_under(&self, profile: &Profile) -> f64 {
        let [low, high] = [placed(self.frame.low), placed(self.frame.high)];
        if low.y >= profile.top() || low.y >= profile.highest(low.x, high.x) {
            return 0.0;
        }
        -self.edges().map(|[a, b]| profile.strip_under(&placed(a), &placed(b))).sum::<f64>()
    }

    /// Whether a point of the grid lies in it; on its boundary this is not decided.
    pub(super) fn holds(&self, point: GridPoint) -> bool {
        let Frame { low, high } = self.frame;
        let near = (low.x..=high.x).contains(&point.x) && (low.y..=high.y).contains(&point.y);
        near && self.edges().filter(|&[a, b]| passes_right_of(a, b, point)).count() % 2 == 1
    }
}

/// Twice the area of a loop in square units, positive counter-clockwise.
pub(super) fn twice_area(points: &[GridPoint]) -> i128 {
    let from = points[0];
    points.windows(2).map(|pair| cross(from, pair[0], pair[1])).sum()
}

pub(super) fn edges_of(points: &[GridPoint]) -> impl Iterator<Item = [GridPoint; 2]> + '_ {
    (0..points.len()).map(|index| [points[index], points[(index + 1) % points.len()]])
}

/// Twice the area of the triangle o, a, b: positive if it turns counter-clockwise.
pub(super) fn cross(o: GridPoint, a: GridPoint, b: GridPoint) -> i128 {
    i128::from(a.x - o.x) * i128::from(b.y - o.y) - i128::from(a.y - o.y) * i128::from(b.x - o.x)
}

/// A loop whose points close to a border of its tile lie on it; `None` if fewer than three differ.
///
/// The overlay may move a crossing by a few units to a point nearby. A piece that leaves its border so would lose
/// its neighbour there.
fn settled(mut points: Vec<GridPoint>, frame: Frame) -> Option<Vec<GridPoint>> {
    let onto = |coordinate: &mut i64, border: i64| {
        if (*coordinate - border).abs() <= TILE_SNAP_UNITS {
            *coordinate = border;
        }
    };
    for point in &mut points {
        [frame.low.x, frame.high.x].into_iter().for_each(|border| onto(&mut point.x, border));
        [frame.low.y, frame.high.y].into_iter().for_each(|border| onto(&mut point.y, border));
    }
    points.dedup();
    (points.len() > 2).then_some(points)
}

fn bounding(points: &[GridPoint]) -> Frame {
    let mut frame = Frame { low: points[0], high: points[0] };
    for point in points {
        frame.low = GridPoint::new(frame.low.x.min(point.x), frame.low.y.min(point.y));
        frame.high = GridPoint::new(frame.high.x.max(point.x), frame.high.y.max(point.y));
    }
    frame
}

fn contacts(contours: &[Vec<GridPoint>], frame: Frame, border: Border) -> Vec<[i64; 2]> {
    let mut intervals: Vec<[i64; 2]> = contours
        .iter()
        .flat_map(|points| edges_of(points))
        .filter_map(|edge| on(edge, frame, border))
        .collect();
    intervals.sort_unstable();
    intervals
}

/// The interval that an edge takes of a border.
fn on([a, b]: [GridPoint; 2], frame: Frame, border: Border) -> Option<[i64; 2]> {
    let (place, across, along) = match border {
        Border::Left => (frame.low.x, [a.x, b.x], [a.y, b.y]),
        Border::Right => (frame.high.x, [a.x, b.x], [a.y, b.y]),
        Border::Bottom => (frame.low.y, [a.y, b.y], [a.x, b.x]),
        Border::Top => (frame.high.y, [a.y, b.y], [a.x, b.x]),
    };
    (across == [place, place]).then(|| [along[0].min(along[1]), along[0].max(along[1])])
}

/// Whether an edge crosses the ray from a point to the right.
fn passes_right_of(a: GridPoint, b: GridPoint, point: GridPoint) -> bool {
    if (a.y > point.y) == (b.y > point.y) {
        return false;
    }
    let turn = cross(a, b, point);
    if b.y > a.y { turn > 0 } else { turn < 0 }
}
