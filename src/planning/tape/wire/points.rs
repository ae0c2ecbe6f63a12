//! The points of plies: most of a large document, read and handled apart from the rest.

use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

use super::{LARGEST_MM, MOST_POINTS, Outline, TapeCut, Track, TrackPoint, Tracks};

/// All points of the plies of an input, taken out of it: of the boundaries, the cut-outs and the courses.
#[derive(Debug)]
pub struct Points {
    outlines: Vec<Option<Vec<[f64; 3]>>>,
    courses: Vec<Vec<TrackPoint>>,
}

impl TapeCut {
    /// Whether all points are so many and so large as their shapes allow.
    #[must_use]
    pub fn points_fit(&self) -> bool {
        let fits = |point: &[f64; 3]| point.iter().all(|x| x.abs() <= LARGEST_MM);
        let outline = |outline: &Outline| {
            outline
                .points
                .as_ref()
                .is_none_or(|points| points.len() <= MOST_POINTS && points.iter().all(fits))
        };
        let course = |track: &Track| {
            let within = track.points.iter().all(|point| fits(&point.position) && fits(&point.normal));
            track.points.len() <= MOST_POINTS && within
        };
        self.outlines().all(outline) && self.listed().all(course)
    }

    fn outlines(&self) -> impl Iterator<Item = &Outline> {
        let listed = self.plies.iter().flatten();
        let of_plies = listed.flat_map(|ply| std::iter::once(&ply.boundary).chain(&ply.holes));
        self.boundary.iter().chain(&self.holes).chain(of_plies)
    }

    fn listed(&self) -> impl Iterator<Item = &Track> {
        let of_plies = self.plies.iter().flatten().filter_map(|ply| ply.tracks.as_ref());
        self.tracks.iter().chain(of_plies).flat_map(|tracks| match tracks {
            Tracks::Listed(tracks) => tracks.as_slice(),
            Tracks::File { .. } => &[],
        })
    }

    /// Takes all points out and leaves empty lists in their place.
    pub fn take_points(&mut self) -> Points {
        Points {
            outlines: self
                .outlines_mut()
                .map(|outline| outline.points.as_mut().map(std::mem::take))
                .collect(),
            courses: self.courses_mut().map(|track| std::mem::take(&mut track.points)).collect(),
        }
    }

    /// Puts the points back that were taken out.
    pub fn put_points(&mut self, points: Points) {
        self.outlines_mut().zip(points.outlines).for_each(|(outline, points)| outline.points = points);
        self.courses_mut().zip(points.courses).for_each(|(track, points)| track.points = points);
    }

    fn outlines_mut(&mut self) -> impl Iterator<Item = &mut Outline> {
        let listed = self.plies.iter_mut().flatten();
        let of_plies = listed.flat_map(|ply| std::iter::once(&mut ply.boundary).chain(&mut ply.holes));
        self.boundary.iter_mut().chain(&mut self.holes).chain(of_plies)
    }

    fn courses_mut(&mut self) -> impl Iterator<Item = &mut Track> {
        let of_plies = self.plies.iter_mut().flatten().filter_map(|ply| ply.tracks.as_mut());
        self.tracks.iter_mut().chain(of_plies).flat_map(|tracks| match tracks {
            Tracks::Listed(tracks) => tracks.as_mut_slice(),
            Tracks::File { .. } => &mut [],
        })
    }
}

impl<'de> Deserialize<'de> for Tracks {
    /// An array is a list, an object names a file. (The derived way would keep a copy of all of it to try both.)
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct ListOrFile;

        impl<'de> Visitor<'de> for ListOrFile {
            type Value = Tracks;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("an array of courses, or an object naming a file")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<Tracks, A::Error> {
                Deserialize::deserialize(SeqAccessDeserializer::new(list)).map(Tracks::Listed)
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Tracks, A::Error> {
                #[derive(Deserialize)]
                #[serde(deny_unknown_fields)]
                struct Named {
                    file: String,
                }
                let Named { file } = Deserialize::deserialize(MapAccessDeserializer::new(map))?;
                Ok(Tracks::File { file })
            }
        }

        deserializer.deserialize_any(ListOrFile)
    }
}
