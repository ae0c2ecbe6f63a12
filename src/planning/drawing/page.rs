//! A sheet with a title, words that say what it shows, and a legend: what all drawings but those of tape begin and
//! end with.

use super::sheet::{INNER_MM, MARGIN_MM, Sample, TEXT_MM, WIDTH_MM, draw_legend, draw_title, wrapped};
use super::svg::Svg;
use crate::planning::outcome::Drawing;

/// The style sheet of charts and sections.
const STYLE: &str = include_str!("chart.css");

/// Bold letters are wider than others by about this.
const BOLD: f64 = 1.06;

/// A sheet that is being drawn.
#[derive(Debug)]
pub struct Page {
    /// What is drawn on it.
    pub svg: Svg,
    /// Below what has been drawn from the top so far, in mm of the sheet.
    pub y: f64,
    title: String,
    words: String,
}

impl Page {
    /// Begins a sheet. `seen` says from where something is seen, if that can be said; the lines what is shown.
    #[must_use]
    pub fn new(title: &str, seen: &str, lines: &[String]) -> Self {
        let mut svg = Svg::with_style(STYLE);
        let bold = if seen.is_empty() { Vec::new() } else { wrapped(seen, BOLD * TEXT_MM, INNER_MM) };
        let plain: Vec<String> = lines.iter().flat_map(|line| wrapped(line, TEXT_MM, INNER_MM)).collect();
        let y = draw_title(&mut svg, title, &bold, &plain);
        let words = bold.iter().chain(&plain).map(String::as_str).collect::<Vec<_>>().join(" ");
        Self { svg, y, title: title.to_owned(), words }
    }

    /// Draws a legend below what has been drawn.
    pub fn legend(&mut self, entries: &[(Sample, String)]) {
        if !entries.is_empty() {
            self.y = draw_legend(&mut self.svg, self.y, entries);
        }
    }

    /// The finished sheet, which ends with a margin below `end`. `name` is that of its file without `.svg`.
    #[must_use]
    pub fn finish(self, name: &str, end: f64) -> Drawing {
        let svg = self.svg.finish(WIDTH_MM, end + MARGIN_MM, &self.title, &self.words);
        Drawing { name: format!("{name}.svg"), svg }
    }
}
