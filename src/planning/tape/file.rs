//! The files that a tape-cut job names: outlines and tracks that do not stand in the document itself.

use super::wire;
use crate::planning::document::files::Files;
use crate::planning::finding::{Code, Finding};

/// An input whose outlines and tracks are all listed: what stands in files is put in its place, so that everything
/// after this knows points only. `files` holds every file that the input names.
///
/// # Errors
/// `NotSupported` for each file: no text of points is read yet. What reads one belongs here.
pub fn listed<'a>(input: &'a wire::TapeCut, files: &Files) -> Result<&'a wire::TapeCut, Vec<Finding>> {
    let faults: Vec<_> = named(input).map(|(at, name)| unread(at, name, files)).collect();
    if faults.is_empty() { Ok(input) } else { Err(faults) }
}

/// Every file that stands for points, with the JSON pointer of its name.
fn named(input: &wire::TapeCut) -> impl Iterator<Item = (String, &str)> {
    let holes =
        input.holes.iter().enumerate().map(|(index, hole)| (format!("/input/holes/{index}/file"), hole));
    let outlines = std::iter::once(("/input/boundary/file".to_owned(), &input.boundary)).chain(holes);
    let tracks = match &input.tracks {
        Some(wire::Tracks::File { file }) => Some(("/input/tracks/file".to_owned(), file.as_str())),
        _ => None,
    };
    outlines.filter_map(|(at, outline)| Some((at, outline.file.as_deref()?))).chain(tracks)
}

fn unread(at: String, name: &str, files: &Files) -> Finding {
    let bytes = files.get(name).map_or(0, <[u8]>::len);
    let message = format!(
        "{name} is there with {bytes} bytes; reading points from a file is not supported yet: list them in the job \
         document"
    );
    Finding::error(Code::NotSupported, at, message)
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn each_file_is_refused_at_its_own_place_and_its_bytes_are_known() {
        let input = json!({"tape": {"width_mm": 75, "thickness_mm": 0.125}, "boundary": {"file": "b.txt"},
            "holes": [{"points": []}, {"file": "h.txt"}], "tracks": {"file": "t.txt"}, "machine": "two-cutter-lab"});
        let input: wire::TapeCut = serde_json::from_value(input).unwrap();
        let mut files = Files::default();
        files.insert("h.txt".into(), b"0 0 0\n".to_vec()).unwrap();
        let faults = listed(&input, &files).unwrap_err();
        let places: Vec<_> = faults.iter().map(|fault| (fault.code, fault.at.as_str())).collect();
        let not = Code::NotSupported;
        let expected =
            [(not, "/input/boundary/file"), (not, "/input/holes/1/file"), (not, "/input/tracks/file")];
        assert_eq!(places, expected);
        assert!(faults[1].message.starts_with("h.txt is there with 6 bytes"), "{}", faults[1].message);
    }
}
