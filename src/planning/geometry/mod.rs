//! Plane geometry without meaning: polygons, crossings, simplification. Lengths are in mm throughout.

pub mod crossing;
pub mod disc;
pub mod frame;
pub mod polygon;
pub mod simplify;
pub mod stretches;

/// A point of a plane.
pub type Point2 = nalgebra::Point2<f64>;
/// A direction or displacement in a plane.
pub type Vector2 = nalgebra::Vector2<f64>;
/// A point in space.
pub type Point3 = nalgebra::Point3<f64>;
/// A direction or displacement in space.
pub type Vector3 = nalgebra::Vector3<f64>;
