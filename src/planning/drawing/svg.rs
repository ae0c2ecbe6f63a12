//! A small writer of SVG: one sheet in mm, one style sheet inside it, no scripts, the same bytes each time.
//!
//! It knows nothing of what is drawn. Colours and line styles are classes of `sheet.css`; numbers become text
//! in `program::number`, as everywhere.

use std::fmt::Write;

use crate::planning::program::number::fixed;

/// Decimals of a sheet's mm: a hundredth, which is a twenty-sixth of a pixel on a screen of 96 dpi.
const DECIMALS: usize = 2;

/// The one style sheet of all drawings, for light and dark surroundings.
const STYLE: &str = include_str!("sheet.css");

/// A place on the sheet in mm, x to the right, y down.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spot {
    /// From the left edge.
    pub x: f64,
    /// From the upper edge.
    pub y: f64,
}

/// The place (x, y) of the sheet.
#[must_use]
pub fn spot(x: f64, y: f64) -> Spot {
    Spot { x, y }
}

/// Which part of a text stands at its place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anchor {
    /// Its beginning.
    Start,
    /// Its middle.
    Middle,
    /// Its end.
    End,
}

/// A drawing that is being written.
#[derive(Debug, Default)]
pub struct Svg {
    body: String,
    /// What this kind of drawing has beyond the style sheet of all.
    style: &'static str,
}

/// The outline of a shape: any number of open or closed parts.
#[derive(Debug, Clone, Default)]
pub struct Path {
    data: String,
}

impl Path {
    /// An open part through some places.
    pub fn open(&mut self, spots: impl IntoIterator<Item = Spot>) {
        for (index, spot) in spots.into_iter().enumerate() {
            self.data.push(if index == 0 { 'M' } else { 'L' });
            self.data.push_str(&number(spot.x));
            self.data.push(' ');
            self.data.push_str(&number(spot.y));
        }
    }

    /// A part that returns to its first place.
    pub fn closed(&mut self, spots: impl IntoIterator<Item = Spot>) {
        let before = self.data.len();
        self.open(spots);
        if self.data.len() > before {
            self.data.push('Z');
        }
    }

    /// Whether nothing has been drawn.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.data.is_empty()
    }
}

impl Svg {
    /// A drawing that needs a style sheet of its own beyond that of all. Drawings may share one page, so its
    /// classes must differ from all others.
    #[must_use]
    pub fn with_style(style: &'static str) -> Self {
        Self { body: String::new(), style }
    }

    /// Draws into a group. Its title is what a browser shows when the pointer rests on it; none if empty.
    pub fn group<T>(&mut self, class: &str, title: &str, draw: impl FnOnce(&mut Self) -> T) -> T {
        self.body.push_str("<g");
        self.attribute("class", class);
        self.body.push('>');
        self.title(title);
        self.body.push('\n');
        let drawn = draw(self);
        self.body.push_str("</g>\n");
        drawn
    }

    /// A rectangle from its upper left corner.
    pub fn rect(&mut self, class: &str, corner: Spot, width: f64, height: f64) {
        let numbers = [("x", corner.x), ("y", corner.y), ("width", width), ("height", height)];
        self.shape("rect", class, &numbers, "");
    }

    /// A straight line.
    pub fn line(&mut self, class: &str, from: Spot, to: Spot) {
        self.shape("line", class, &[("x1", from.x), ("y1", from.y), ("x2", to.x), ("y2", to.y)], "");
    }

    /// A disc.
    pub fn disc(&mut self, class: &str, centre: Spot, radius: f64) {
        self.shape("circle", class, &[("cx", centre.x), ("cy", centre.y), ("r", radius)], "");
    }

    /// A path with a title, as of [`Svg::group`]. An empty path is left out.
    pub fn path(&mut self, class: &str, path: &Path, title: &str) {
        if path.is_empty() {
            return;
        }
        self.body.push_str("<path");
        self.attribute("class", class);
        self.attribute("d", &path.data);
        self.close_with_title("path", title);
    }

    /// A closed path whose parts cut holes into one another (even-odd rule).
    pub fn area(&mut self, class: &str, path: &Path, title: &str) {
        if path.is_empty() {
            return;
        }
        self.body.push_str("<path fill-rule=\"evenodd\"");
        self.attribute("class", class);
        self.attribute("d", &path.data);
        self.close_with_title("path", title);
    }

    /// A rectangle hatched at 45 degrees; `id` is unique among all drawings that may share one page.
    pub fn hatched_rect(&mut self, id: &str, corner: Spot, width: f64, height: f64) {
        self.body.push_str("<rect");
        self.attribute("fill", &format!("url(#{id})"));
        for (name, value) in [("x", corner.x), ("y", corner.y), ("width", width), ("height", height)] {
            self.attribute(name, &number(value));
        }
        self.body.push_str("/>\n");
    }

    /// An area as of [`Svg::area`], hatched as of [`Svg::hatched_rect`].
    pub fn hatched_area(&mut self, id: &str, path: &Path, title: &str) {
        if path.is_empty() {
            return;
        }
        self.body.push_str("<path fill-rule=\"evenodd\"");
        self.attribute("fill", &format!("url(#{id})"));
        self.attribute("d", &path.data);
        self.close_with_title("path", title);
    }

    /// Defines the hatching of [`Svg::hatched_rect`].
    pub fn hatching(&mut self, id: &str) {
        self.pattern(id, "M-.5 .5L.5 -.5M0 2L2 0M1.5 2.5L2.5 1.5");
    }

    /// Defines a hatching by the lines in a square of 2 mm that is repeated, as the `d` of a path.
    pub fn pattern(&mut self, id: &str, lines: &'static str) {
        self.body.push_str("<defs><pattern");
        self.attribute("id", id);
        self.body.push_str(" patternUnits=\"userSpaceOnUse\" width=\"2\" height=\"2\">");
        let _ = writeln!(self.body, "<path class=\"hatch\" d=\"{lines}\"/></pattern></defs>");
    }

    /// A line of text; the place is that of its baseline. With the class `halo` it has a rim in the paper's colour: a
    /// thicker copy of it beneath, because not every renderer paints a stroke before the fill (`paint-order`).
    pub fn text(&mut self, class: &str, at: Spot, anchor: Anchor, text: &str) {
        if class.split(' ').any(|word| word == "halo") {
            // Colours of their own are left to the upper copy, which a screen reader reads alone.
            let own =
                |word: &&str| *word == "halo" || word.starts_with("ink-") || word.starts_with("cutter-");
            let plain: Vec<&str> = class.split(' ').filter(|word| !own(word)).chain(["under"]).collect();
            self.put_text(&plain.join(" "), at, anchor, text, true);
        }
        self.put_text(class, at, anchor, text, false);
    }

    fn put_text(&mut self, class: &str, at: Spot, anchor: Anchor, text: &str, hidden: bool) {
        self.body.push_str("<text");
        self.attribute("class", class);
        if hidden {
            self.attribute("aria-hidden", "true");
        }
        self.attribute("x", &number(at.x));
        self.attribute("y", &number(at.y));
        match anchor {
            Anchor::Start => {}
            Anchor::Middle => self.attribute("text-anchor", "middle"),
            Anchor::End => self.attribute("text-anchor", "end"),
        }
        self.body.push('>');
        escape(text, &mut self.body);
        self.body.push_str("</text>\n");
    }

    /// The finished drawing: a sheet of that size in mm on its own background, with a title and a description
    /// for those who cannot see it.
    #[must_use]
    pub fn finish(self, width_mm: f64, height_mm: f64, title: &str, description: &str) -> String {
        let (width, height) = (number(width_mm), number(height_mm));
        let mut text = String::with_capacity(self.body.len() + STYLE.len() + self.style.len() + 1024);
        // Writing to a String cannot fail.
        let _ = write!(
            text,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"drawing\" role=\"img\" \
             width=\"{width}mm\" height=\"{height}mm\" viewBox=\"0 0 {width} {height}\">\n<title>"
        );
        escape(title, &mut text);
        text.push_str("</title>\n<desc>");
        escape(description, &mut text);
        let _ = write!(
            text,
            "</desc>\n<style>\n{STYLE}{}</style>\n<rect class=\"paper\" width=\"{width}\" height=\"{height}\"/>\n",
            self.style
        );
        text.push_str(&self.body);
        text.push_str("</svg>\n");
        text
    }

    /// What has been drawn so far, without a sheet around it.
    #[must_use]
    pub fn into_body(self) -> String {
        self.body
    }

    fn shape(&mut self, name: &str, class: &str, numbers: &[(&str, f64)], title: &str) {
        self.body.push('<');
        self.body.push_str(name);
        self.attribute("class", class);
        for (name, value) in numbers {
            self.attribute(name, &number(*value));
        }
        self.close_with_title(name, title);
    }

    fn close_with_title(&mut self, name: &str, title: &str) {
        if title.is_empty() {
            return self.body.push_str("/>\n");
        }
        self.body.push('>');
        self.title(title);
        let _ = writeln!(self.body, "</{name}>");
    }

    fn title(&mut self, title: &str) {
        if !title.is_empty() {
            self.body.push_str("<title>");
            escape(title, &mut self.body);
            self.body.push_str("</title>");
        }
    }

    fn attribute(&mut self, name: &str, value: &str) {
        let _ = write!(self.body, " {name}=\"");
        escape(value, &mut self.body);
        self.body.push('"');
    }
}

fn number(value: f64) -> String {
    let text = fixed(value, DECIMALS);
    text.strip_suffix(".0").map(str::to_owned).unwrap_or(text)
}

/// Writes text so that it is text and nothing else. What XML 1.0 cannot hold at all, even escaped, becomes
/// U+FFFD.
fn escape(text: &str, into: &mut String) {
    for letter in text.chars() {
        match letter {
            '&' => into.push_str("&amp;"),
            '<' => into.push_str("&lt;"),
            '>' => into.push_str("&gt;"),
            '"' => into.push_str("&quot;"),
            '\u{0}'..='\u{8}' | '\u{b}' | '\u{c}' | '\u{e}'..='\u{1f}' | '\u{fffe}' | '\u{ffff}' => {
                into.push(char::REPLACEMENT_CHARACTER);
            }
            _ => into.push(letter),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_text_stays_text() {
        let hostile = "</text><script>alert('&')</script>\" onload=\"x\u{0}\u{1b}\u{ffff} \u{1F52A}";
        let mut svg = Svg::default();
        svg.group("a", hostile, |svg| svg.text("b", spot(1.0, 2.0), Anchor::End, hostile));
        let text = svg.finish(10.0, 10.0, hostile, hostile);
        let document = roxmltree::Document::parse(&text).unwrap();
        assert!(
            !document.descendants().any(|node| node.has_tag_name("script") || node.has_attribute("onload"))
        );
        let shown = document.descendants().find(|node| node.tag_name().name() == "text").unwrap();
        let expected = hostile.replace(['\u{0}', '\u{1b}', '\u{ffff}'], "\u{fffd}");
        assert_eq!(shown.text(), Some(expected.as_str()));
    }

    #[test]
    fn a_halo_is_a_copy_beneath_and_no_order_of_painting() {
        let mut svg = Svg::default();
        svg.text("number halo cutter-2", spot(1.0, 2.0), Anchor::Middle, "2·1");
        let place = "x=\"1\" y=\"2\" text-anchor=\"middle\">2·1</text>\n";
        let expected = format!(
            "<text class=\"number under\" aria-hidden=\"true\" {place}<text class=\"number halo cutter-2\" {place}"
        );
        assert_eq!(svg.body, expected);
        assert!(!STYLE.contains("paint-order") && STYLE.contains(".drawing .under{"));
    }

    #[test]
    fn numbers_are_short_and_an_empty_path_is_nothing() {
        let mut path = Path::default();
        path.closed([]);
        assert!(path.is_empty());
        path.closed([spot(-0.001, 2.0), spot(1e7, 0.125), spot(3.456, 1.0)]);
        let mut svg = Svg::default();
        svg.path("p", &path, "");
        assert_eq!(svg.body, "<path class=\"p\" d=\"M0 2L10000000 0.12L3.46 1Z\"/>\n");
    }
}
