//! Which stretches of a closed loop of points in space come near a line.
//!
//! The points are taken in blocks of consecutive ones, and the balls around these in a binary tree, so that a course
//! looks at what is near it and not at a million points.

use std::ops::Range;

use super::Point3;

/// So many consecutive points make a block.
const BLOCK: usize = 64;

/// A line from one point to another, and how far from it a point is near, in mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reach {
    /// Where the line begins.
    pub from: Point3,
    /// Where it ends.
    pub to: Point3,
    /// Whether it goes on beyond both of its ends, which then differ.
    pub endless: bool,
    /// In mm.
    pub radius_mm: f64,
}

/// A loop with the balls around its blocks.
#[derive(Debug, Clone, PartialEq)]
pub struct Stretches {
    points: usize,
    /// Balls around one block each, then around two each, and so on up to one around all.
    levels: Vec<Vec<Ball>>,
}

/// All that is within a distance of a point.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Ball {
    middle: Point3,
    radius_mm: f64,
}

/// A box along the axes.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Box3 {
    low: Point3,
    high: Point3,
}

impl Stretches {
    /// Of a closed loop whose first point is not repeated. A block's box holds the way to the next block too.
    #[must_use]
    pub fn of(points: &[Point3]) -> Self {
        let blocks = points.len().div_ceil(BLOCK);
        let around_block = |block: usize| {
            let next = points[((block + 1) * BLOCK) % points.len()];
            let own = &points[block * BLOCK..points.len().min((block + 1) * BLOCK)];
            let next = if block + 1 == blocks { points[0] } else { next };
            own.iter().fold(Box3 { low: next, high: next }, |all, point| all.with(&Box3::at(*point)))
        };
        let mut boxes: Vec<Box3> = (0..blocks).map(around_block).collect();
        let mut levels: Vec<Vec<Ball>> = vec![boxes.iter().map(Box3::ball).collect()];
        while boxes.len() > 1 {
            boxes = boxes.chunks(2).map(|pair| pair[1..].iter().fold(pair[0], Box3::with)).collect();
            levels.push(boxes.iter().map(Box3::ball).collect());
        }
        Self { points: points.len(), levels }
    }

    /// The ranges of indices whose points, or the ways from one to the next, may come near any of some lines; in order,
    /// and no two of them touch. What is near is among them, and little else.
    #[must_use]
    pub fn near(&self, reaches: &[Reach]) -> Vec<Range<usize>> {
        let mut near: Vec<Range<usize>> = Vec::new();
        if self.points > 0 {
            self.visit((self.levels.len() - 1, 0), &mut reaches.to_vec(), 0, &mut near);
        }
        near
    }

    /// `reaches` is a pile: of those from `asked` on, the ones that come near are put on top for what is inside.
    fn visit(
        &self,
        (level, index): (usize, usize),
        reaches: &mut Vec<Reach>,
        asked: usize,
        near: &mut Vec<Range<usize>>,
    ) {
        let around = &self.levels[level][index];
        let within = reaches.len();
        for place in asked..within {
            if reaches[place].may_meet(around) {
                reaches.push(reaches[place]);
            }
        }
        if reaches.len() > within && level > 0 {
            self.visit((level - 1, 2 * index), reaches, within, near);
            if 2 * index + 1 < self.levels[level - 1].len() {
                self.visit((level - 1, 2 * index + 1), reaches, within, near);
            }
        } else if reaches.len() > within {
            let block = index * BLOCK..self.points.min((index + 1) * BLOCK);
            match near.last_mut() {
                Some(last) if last.end == block.start => last.end = block.end,
                _ => near.push(block),
            }
        }
        reaches.truncate(within);
    }
}

impl Reach {
    /// Whether it may come near anything in a ball.
    fn may_meet(&self, around: &Ball) -> bool {
        self.distance_mm(&around.middle) <= self.radius_mm + around.radius_mm
    }

    /// How far a point is from the line, in mm.
    #[must_use]
    pub fn distance_mm(&self, point: &Point3) -> f64 {
        let (along, to_point) = (self.to - self.from, point - self.from);
        let squared = along.norm_squared();
        let share = if squared > 0.0 { to_point.dot(&along) / squared } else { 0.0 };
        let share = if self.endless { share } else { share.clamp(0.0, 1.0) };
        (to_point - along * share).norm()
    }
}

impl Box3 {
    fn at(point: Point3) -> Self {
        Self { low: point, high: point }
    }

    /// The ball around it.
    fn ball(&self) -> Ball {
        Ball {
            middle: nalgebra::center(&self.low, &self.high),
            radius_mm: (self.high - self.low).norm() / 2.0,
        }
    }

    fn with(self, other: &Self) -> Self {
        let low = self.low.coords.zip_map(&other.low.coords, f64::min);
        let high = self.high.coords.zip_map(&other.high.coords, f64::max);
        Self { low: low.into(), high: high.into() }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn circle(count: u32) -> Vec<Point3> {
        let angle = |i| f64::from(i) / f64::from(count) * std::f64::consts::TAU;
        (0..count).map(|i| Point3::new(1000.0 * angle(i).cos(), 1000.0 * angle(i).sin(), 0.0)).collect()
    }

    #[test]
    fn a_loop_without_points_and_one_of_a_single_block_are_borne() {
        let reach = Reach { from: Point3::origin(), to: Point3::origin(), endless: false, radius_mm: 1.0 };
        assert!(Stretches::of(&[]).near(&[reach]).is_empty());
        let around = circle(3);
        let near = Stretches::of(&around).near(&[Reach { radius_mm: 2000.0, ..reach }]);
        assert_eq!(near.iter().map(|range| (range.start, range.end)).collect::<Vec<_>>(), [(0, 3)]);
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 40, failure_persistence: None, ..ProptestConfig::default() })]
        #[test]
        fn every_side_that_comes_near_is_found_and_few_others(
            count in 1..3000_u32, from in prop::array::uniform2(-1200.0..1200.0_f64),
            to in prop::array::uniform2(-1200.0..1200.0_f64), radius_mm in 1.0..100.0_f64, endless in any::<bool>()
        ) {
            let points = circle(count);
            let point = |at: [f64; 2]| Point3::new(at[0], at[1], 0.0);
            let reach = Reach { from: point(from), to: point(to), endless, radius_mm };
            let near = Stretches::of(&points).near(&[reach]);
            prop_assert!(near.windows(2).all(|pair| pair[0].end < pair[1].start));
            let found = |index: usize| near.iter().any(|range| range.contains(&index));
            for index in 0..points.len() {
                let (a, b) = (points[index], points[(index + 1) % points.len()]);
                let close = (0..=20).any(|k| reach.distance_mm(&(a + (b - a) * (f64::from(k) / 20.0))) <= radius_mm);
                prop_assert!(!close || found(index), "side {index}");
            }
            if count > 1000 {
                // A block of this circle is less than 403 mm long.
                let far = (0..points.len()).filter(|&i| reach.distance_mm(&points[i]) > radius_mm + 900.0);
                prop_assert!(far.clone().all(|index| !found(index)));
            }
        }
    }
}
