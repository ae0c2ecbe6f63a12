//! The files that a tape-cut job names: outlines and tracks that do not stand in the document itself.
//!
//! The name of a file says what it is: `.dxf` a drawing, anything else plain text (docs/files.md).

pub mod dxf;
pub mod faults;
pub mod origin;
pub mod text;

use std::borrow::Cow;

use self::dxf::Wanted;
use self::origin::{Origin, Origins};
use self::text::{ReadLoop, ReadTrack};
use super::label::PlyPlace;
use super::wire::{self, PlyFields};
use crate::planning::document::files::Files;
use crate::planning::finding::{Code, Finding};

/// The plies of an input, their outlines and tracks listed as far as they could be read.
#[derive(Debug, Default)]
pub struct Listed<'a> {
    /// The plies, with points in place of the files that could be read. Those that could not are still named.
    pub plies: Vec<PlyFields<'a>>,
    /// Where each point stands.
    pub origins: Origins,
    /// What should be known of the files, and every fault in them, each at its line or at the place that names the
    /// file.
    pub findings: Vec<Finding>,
}

/// Puts what stands in files in its place, so that everything after this knows points only. `files` holds every file
/// that the input names.
///
/// A file of a boundary or of a cut-out may hold several loops: those after the first become further cut-outs, behind
/// those of the document.
#[must_use]
pub fn listed<'a>(input: &'a wire::TapeCut, files: &Files) -> Listed<'a> {
    let mut listed = Listed::default();
    for fields in input.all_plies() {
        listed.plies.push(fields.clone());
        listed.read(&fields, files);
    }
    listed
}

/// Where an outline belongs.
#[derive(Debug, Clone, Copy)]
enum Place {
    Boundary,
    Hole(usize),
}

impl Place {
    fn pointer(self, ply: PlyPlace) -> String {
        match self {
            Self::Boundary => format!("{ply}/boundary"),
            Self::Hole(index) => format!("{ply}/holes/{index}"),
        }
    }
}

impl<'a> Listed<'a> {
    /// Reads the files that a ply names, the last of the list, and puts in its place what stands in them.
    fn read(&mut self, fields: &PlyFields<'a>, files: &Files) {
        let mut further = Vec::new();
        let outlines = std::iter::once(&*fields.boundary).chain(&*fields.holes).enumerate();
        for (index, outline) in outlines {
            // What names both points and a file is refused later, for that.
            if let (Some(name), None) = (&outline.file, &outline.points) {
                let place = if index == 0 { Place::Boundary } else { Place::Hole(index - 1) };
                let at = place.pointer(fields.place);
                let read = read_outline(name, outline.layers.as_ref(), place, &at, files);
                further.extend(self.take_loops(name, place, read));
            }
        }
        for (name, read) in further {
            let Some(ply) = self.plies.last_mut() else { return };
            let place = Place::Hole(ply.holes.len());
            ply.holes.to_mut().push(wire::Outline::default());
            self.put(name, place, read);
        }
        if let Some(wire::Tracks::File { file }) = fields.tracks.as_deref() {
            let read = read_tracks(file, fields.place, files);
            self.take_tracks(file, read);
        }
    }

    /// Puts the first loop of a file in its place and gives back the others.
    fn take_loops<'n>(
        &mut self,
        name: &'n str,
        place: Place,
        read: Result<dxf::Drawing, Vec<Finding>>,
    ) -> Vec<(&'n str, ReadLoop)> {
        match read {
            Ok((loops, findings)) => {
                self.findings.extend(findings);
                let mut loops = loops.into_iter();
                if let Some(first) = loops.next() {
                    self.put(name, place, first);
                }
                loops.map(|read| (name, read)).collect()
            }
            Err(faults) => {
                self.findings.extend(faults);
                Vec::new()
            }
        }
    }

    fn put(&mut self, name: &str, place: Place, read: ReadLoop) {
        let ReadLoop { line, points, lines } = read;
        let Some(ply) = self.plies.last_mut() else { return };
        self.origins.outline(place.pointer(ply.place), Origin { file: name.to_owned(), line, lines });
        let outline = match place {
            Place::Boundary => ply.boundary.to_mut(),
            Place::Hole(index) => &mut ply.holes.to_mut()[index],
        };
        *outline = wire::Outline { points: Some(points), ..wire::Outline::default() };
    }

    fn take_tracks(&mut self, name: &str, read: Result<Vec<ReadTrack>, Vec<Finding>>) {
        match read {
            Ok(read) => {
                let (mut tracks, mut origins) = (Vec::new(), Vec::new());
                for ReadTrack { track, line, lines } in read {
                    tracks.push(track);
                    origins.push(Origin { file: name.to_owned(), line, lines });
                }
                let Some(ply) = self.plies.last_mut() else { return };
                ply.tracks = Some(Cow::Owned(wire::Tracks::Listed(tracks)));
                self.origins.tracks(ply.place, origins);
            }
            Err(faults) => self.findings.extend(faults),
        }
    }
}

/// Whether a file is a drawing, by its name.
#[must_use]
pub fn is_drawing(name: &str) -> bool {
    name.rsplit_once('.').is_some_and(|(_, ending)| ending.eq_ignore_ascii_case("dxf"))
}

fn read_outline(
    name: &str,
    layers: Option<&wire::Layers>,
    place: Place,
    at: &str,
    files: &Files,
) -> Result<dxf::Drawing, Vec<Finding>> {
    let bytes = files.get(name).ok_or_else(|| vec![not_sent(at, name)])?;
    if !is_drawing(name) {
        return text::read_loops(name, bytes).map(|loops| (loops, Vec::new()));
    }
    let wanted = match place {
        Place::Boundary => Wanted::Ply,
        Place::Hole(_) => Wanted::CutOuts,
    };
    dxf::read(name, bytes, layers, wanted)
}

fn read_tracks(name: &str, ply: PlyPlace, files: &Files) -> Result<Vec<ReadTrack>, Vec<Finding>> {
    let at = format!("{ply}/tracks");
    let bytes = files.get(name).ok_or_else(|| vec![not_sent(&at, name)])?;
    if is_drawing(name) {
        let message = "tracks are not read from drawings; list them, or send a plain text (docs/files.md)";
        return Err(vec![Finding::error(Code::NotSupported, format!("{at}/file"), message)]);
    }
    text::read_tracks(name, bytes)
}

fn not_sent(at: &str, name: &str) -> Finding {
    Finding::error(Code::UnknownFile, format!("{at}/file"), format!("{name} was not sent with the job"))
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn input(value: serde_json::Value) -> wire::TapeCut {
        let mut input = json!({"tape": {"width_mm": 75, "thickness_mm": 0.125}, "machine": "two-cutter-lab"});
        input.as_object_mut().unwrap().extend(value.as_object().unwrap().clone());
        serde_json::from_value(input).unwrap()
    }

    fn files(pairs: &[(&str, &str)]) -> Files {
        let mut files = Files::default();
        for (name, body) in pairs {
            files.insert((*name).to_owned(), body.as_bytes().to_vec()).unwrap();
        }
        files
    }

    #[test]
    fn an_input_without_files_is_left_as_it_is() {
        let input = input(json!({"boundary": {"points": [[0, 0, 0]]}, "tracks": []}));
        let listed = listed(&input, &Files::default());
        assert!(matches!(listed.plies[0].boundary, Cow::Borrowed(_)));
        assert!(matches!(listed.plies[0].tracks, Some(Cow::Borrowed(_))));
    }

    #[test]
    fn further_loops_become_cut_outs_behind_those_of_the_document() {
        let input = input(json!({"boundary": {"file": "b.txt"}, "tracks": {"file": "t.txt"},
            "holes": [{"file": "h.txt"}, {"points": [[7, 7, 7]]}]}));
        let sent = files(&[
            ("b.txt", "0 0 0\nloop\n1 1 1\nloop\n2 2 2\n"),
            ("h.txt", "3 3 3\nloop\n4 4 4\n"),
            ("t.txt", "track 9\n5 5 5 0 0 1\n"),
        ]);
        let listed = listed(&input, &sent);
        let first = |outline: &wire::Outline| outline.points.as_ref().unwrap()[0][0];
        let ply = &listed.plies[0];
        assert_eq!(first(&ply.boundary), 0.0);
        assert_eq!(ply.holes.iter().map(first).collect::<Vec<_>>(), [3.0, 7.0, 1.0, 2.0, 4.0]);
        assert!(ply.holes.iter().chain([&*ply.boundary]).all(|outline| outline.file.is_none()));
        let Some(wire::Tracks::Listed(tracks)) = ply.tracks.as_deref() else { panic!("they are listed") };
        assert_eq!((tracks.len(), tracks[0].number), (1, 9));
        let mut findings = [
            "/input/holes/2/points/0",
            "/input/holes/4/points/0",
            "/input/holes/1/points/0",
            "/input/tracks/0/points/0/normal",
        ]
        .map(|at| Finding::info(Code::LeftOut, at, ""));
        listed.origins.relocate(&mut findings);
        let places = findings.map(|finding| finding.at);
        assert_eq!(places, ["b.txt:3", "h.txt:3", "/input/holes/1/points/0", "t.txt:2"]);
    }

    #[test]
    fn the_faults_of_all_files_are_found_together() {
        let input = input(json!({"boundary": {"file": "b.txt"}, "tracks": {"file": "t.DXF"},
            "holes": [{"file": "h.txt"}, {"file": "c.dxf"}, {"file": "gone.txt"}]}));
        let sent = files(&[("b.txt", "0 0\n"), ("h.txt", "0 0 0\nx\n"), ("t.DXF", ""), ("c.dxf", "")]);
        let listed = listed(&input, &sent);
        let places: Vec<_> = listed.findings.iter().map(|fault| (fault.code, fault.at.as_str())).collect();
        let expected = [
            (Code::WrongCount, "b.txt:1"),
            (Code::WrongType, "h.txt:2"),
            (Code::UnreadableFile, "c.dxf:1"),
            (Code::UnknownFile, "/input/holes/2/file"),
            (Code::NotSupported, "/input/tracks/file"),
        ];
        assert_eq!(places, expected);
        assert!(listed.findings.iter().all(Finding::is_error));
    }
}
