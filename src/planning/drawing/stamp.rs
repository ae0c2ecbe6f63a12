//! The mark on every drawing by which one knows what it was drawn from.

use super::sheet::MARGIN_MM;
use super::svg::{Anchor, Svg, spot};
use crate::planning::outcome::Drawing;

/// So many characters of a hash stand where people read it: enough to tell any two jobs of a shop apart.
const SHORT: usize = 12;

/// The mark stands so far above the lower edge of the sheet, in mm: within its margin, where nothing is drawn.
const ABOVE_EDGE_MM: f64 = 4.0;

/// Puts the hash of the input on a drawing: a part of it into the title and at the foot of the sheet, and all of it into
/// the description. A text that is no drawing of this program's stays as it is.
#[must_use]
pub fn stamped(drawing: Drawing, input_sha256: &str) -> Drawing {
    let short = &input_sha256[..SHORT.min(input_sha256.len())];
    match marked(&drawing.svg, short, input_sha256) {
        Some(svg) => Drawing { svg, ..drawing },
        None => drawing,
    }
}

fn marked(svg: &str, short: &str, whole: &str) -> Option<String> {
    let title = svg.find("</title>")?;
    let description = title + svg[title..].find("</desc>")?;
    let end = svg.rfind("</svg>")?;
    let foot = foot(short, height_mm(&svg[..title])?);
    Some(format!(
        "{}, input {short}{} Input SHA-256 {whole}.{}{foot}{}",
        &svg[..title],
        &svg[title..description],
        &svg[description..end],
        &svg[end..]
    ))
}

/// The height of the sheet, from the fourth number of its view box.
fn height_mm(head: &str) -> Option<f64> {
    let (_, rest) = head.split_once("viewBox=\"0 0 ")?;
    let (numbers, _) = rest.split_once('"')?;
    numbers.split(' ').nth(1)?.parse().ok()
}

fn foot(short: &str, height_mm: f64) -> String {
    let mut svg = Svg::default();
    svg.text(
        "quiet foot",
        spot(MARGIN_MM, height_mm - ABOVE_EDGE_MM),
        Anchor::Start,
        &format!("input {short}"),
    );
    svg.into_body()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planning::drawing::page::Page;

    #[test]
    fn a_drawing_names_the_input_in_its_title_its_description_and_at_its_foot() {
        let hash = "0123456789abcdef".repeat(4);
        let plain = Page::new("Title & more", "", &["words".to_owned()]).finish("x", 100.0);
        let drawing = stamped(plain.clone(), &hash);
        let document = roxmltree::Document::parse(&drawing.svg).unwrap();
        let text = |name: &str| {
            document.descendants().find(|node| node.tag_name().name() == name).and_then(|node| node.text())
        };
        assert_eq!(text("title"), Some("Title & more, input 0123456789ab"));
        assert_eq!(text("desc"), Some(format!("words Input SHA-256 {hash}.").as_str()));
        let foot = document.descendants().filter(|node| node.attribute("class") == Some("quiet foot"));
        let foot: Vec<_> = foot.map(|node| (node.attribute("y"), node.text())).collect();
        assert_eq!(foot, [(Some("106"), Some("input 0123456789ab"))]);
        assert_eq!(drawing.name, plain.name);
        let other = Drawing { svg: "<svg/>".to_owned(), ..plain };
        assert_eq!(stamped(other.clone(), &hash), other);
    }
}
