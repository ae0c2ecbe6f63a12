//! A milling path and the path that it was converted into, over one another (the paper's Fig. 12).

use super::axis::{is_shown, range};
use super::page::Page;
use super::sheet::{INNER_MM, MARGIN_MM, Sample, draw_arrow, draw_scale_bar, figure, scale_denominator};
use super::svg::{Anchor, Path, Spot, Svg, spot};
use super::thin::{line, lines, segments};
use crate::planning::geometry::Point3;
use crate::planning::outcome::Drawing;

/// Both paths. All lengths in mm, in the frame of the part.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Paths {
    /// Width, length and height of the blank: x, y and z.
    pub blank: (f64, f64, f64),
    /// Where the milling program goes, point by point.
    pub milling: Vec<Point3>,
    /// Where the converted program goes.
    pub converted: Vec<Point3>,
}

/// The largest size of both views together, in mm of the sheet.
const LARGEST_MM: (f64, f64) = (INNER_MM, 138.0);
/// Between the two views.
const GAP_MM: f64 = 12.0;
/// The most segments of one path in one view.
const MOST_SEGMENTS: usize = 1500;
/// What y is drawn with in the oblique view: half of its length, at 40 degrees.
const RECEDING: (f64, f64) = (0.383, 0.321);

/// From where a path is seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum View {
    /// Along +y and a little from above and from the right.
    Oblique,
    /// From above.
    Top,
}

/// A view in its place on the sheet.
struct Placed {
    view: View,
    denominator: f64,
    /// Where (0, 0, 0) is on the sheet.
    origin: Spot,
    /// Its lower left corner on the sheet.
    foot: Spot,
}

/// The paths over one another, seen obliquely and from above: `milling.svg`.
#[must_use]
pub fn milling(data: &Paths) -> Drawing {
    let mut page = Page::new(
        "Milling path and converted path",
        "Oblique view: x to the right, z up, y into the depth. Top view, from above: x to the right, y up.",
        &words(data),
    );
    page.legend(&[
        (Sample::Line("curve fine stroke-1"), "converted path".to_owned()),
        (Sample::Line("curve middling stroke-2 dashed"), "milling path".to_owned()),
        (Sample::Line("blank-edge"), "blank".to_owned()),
    ]);
    let (views, denominator, end) = layout(data, page.y + 4.0);
    let mut coarsest = 0.0_f64;
    for placed in &views {
        let raster_mm = page.svg.group("view-of-paths", "", |svg| placed.draw(svg, data));
        coarsest = coarsest.max(raster_mm);
    }
    let x = draw_scale_bar(&mut page.svg, spot(MARGIN_MM, end + 4.0), denominator, "both views");
    if coarsest > 0.0 {
        let words = format!("Strokes closer than {} mm on the sheet are drawn as one.", figure(coarsest, 2));
        page.svg.text("small", spot(x + 8.0, end + 4.9), Anchor::Start, &words);
    }
    page.finish("milling", end + 6.0)
}

fn words(data: &Paths) -> Vec<String> {
    let extent = |points: &[Point3]| range(points.iter().map(|point| point.y));
    let of = |name: &str, points: &[Point3]| match points.len() {
        0 => format!("{name}: no points."),
        count => {
            let (low, high) = extent(points);
            format!("{name}: {count} points, y from {} to {} mm.", figure(low, 2), figure(high, 2))
        }
    };
    let (width, length, height) = data.blank;
    vec![
        "The converted path cuts each stroke twice, with the blade swung left and then right, from beside the blank on one side to beside it on the other and back; there the blade turns."
            .to_owned(),
        format!(
            "Blank {} x {} x {} mm. {} {}",
            figure(width, 3),
            figure(length, 3),
            figure(height, 3),
            of("Milling path", &data.milling),
            of("Converted path", &data.converted)
        ),
    ]
}

impl View {
    /// Places of the plane of the view, in mm of the part, y up.
    fn project(self, point: &Point3) -> (f64, f64) {
        match self {
            Self::Oblique => (point.x + RECEDING.0 * point.y, point.z + RECEDING.1 * point.y),
            Self::Top => (point.x, point.y),
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Oblique => "oblique view",
            Self::Top => "top view",
        }
    }

    /// From where to where everything reaches in the plane of the view, with the corner of the blank at (0, 0).
    fn extent(self, data: &Paths) -> ((f64, f64), (f64, f64)) {
        let all = data.milling.iter().chain(&data.converted).copied().filter(is_place).chain(corners(data));
        let mut extent = ((0.0_f64, 0.0_f64), (0.0_f64, 0.0_f64));
        for (x, y) in all.map(|point| self.project(&point)) {
            extent.0 = (extent.0.0.min(x), extent.0.1.max(x));
            extent.1 = (extent.1.0.min(y), extent.1.1.max(y));
        }
        extent
    }
}

/// The corners of the blank, those at y = 0 first, each round from the origin.
fn corners(data: &Paths) -> Vec<Point3> {
    let bound = |size: f64| if is_shown(size) { size } else { 0.0 };
    let (x, y, z) = (bound(data.blank.0), bound(data.blank.1), bound(data.blank.2));
    let round = [(0.0, 0.0), (x, 0.0), (x, z), (0.0, z)];
    [0.0, y].into_iter().flat_map(|y| round.map(|(x, z)| Point3::new(x, y, z))).collect()
}

fn is_place(point: &Point3) -> bool {
    point.iter().all(|value| is_shown(*value))
}

/// Both views, beside one another or below one another, whichever can be drawn larger; their scale denominator,
/// and the y below them.
fn layout(data: &Paths, y: f64) -> (Vec<Placed>, f64, f64) {
    let extents = [View::Oblique, View::Top].map(|view| (view, view.extent(data)));
    let [one, other] = extents.map(|(_, (x, y))| (x.1 - x.0, y.1 - y.0));
    let needed = |width: f64, height: f64, room: (f64, f64)| (width / room.0).max(height / room.1);
    let beside = needed(one.0 + other.0, one.1.max(other.1), (LARGEST_MM.0 - GAP_MM, LARGEST_MM.1));
    let below = needed(one.0.max(other.0), one.1 + other.1, (LARGEST_MM.0, LARGEST_MM.1 - GAP_MM - NAME_MM));
    let denominator = scale_denominator(beside.min(below));
    let (mut x, mut y, mut end) = (MARGIN_MM, y, y);
    let mut views = Vec::new();
    for (view, (across, up)) in extents {
        let size = |range: (f64, f64)| ((range.1 - range.0) / denominator).max(LEAST_MM);
        let (width, foot) = (size(across), spot(x, y + size(up)));
        let origin = spot(x - across.0 / denominator, foot.y + up.0 / denominator);
        views.push(Placed { view, denominator, origin, foot });
        end = end.max(foot.y + NAME_MM);
        if beside <= below {
            x += width + GAP_MM;
        } else {
            y = foot.y + NAME_MM + GAP_MM;
        }
    }
    (views, denominator, end)
}

/// Room below a view for its name.
const NAME_MM: f64 = 5.0;
/// The least size of a view: room for the directions of its axes.
const LEAST_MM: f64 = 20.0;

impl Placed {
    fn spot(&self, point: &Point3) -> Spot {
        let (x, y) = self.view.project(point);
        spot(self.origin.x + x / self.denominator, self.origin.y - y / self.denominator)
    }

    /// Draws blank and paths; gives the raster on which strokes were thinned out, 0 if they were not.
    fn draw(&self, svg: &mut Svg, data: &Paths) -> f64 {
        let corners: Vec<Spot> = corners(data).iter().map(|corner| self.spot(corner)).collect();
        let mut box_path = Path::default();
        box_path.closed(corners[..4].iter().copied());
        box_path.closed(corners[4..].iter().copied());
        for index in 0..4 {
            box_path.open([corners[index], corners[index + 4]]);
        }
        svg.path("blank-edge", &box_path, "blank");
        let kinds = [
            (&data.converted, "curve fine stroke-1", "converted path"),
            (&data.milling, "curve middling stroke-2 dashed", "milling path"),
        ];
        let rasters = kinds.map(|(points, class, title)| self.draw_path(svg, points, class, title));
        self.draw_name(svg, &corners);
        rasters.into_iter().fold(0.0, f64::max)
    }

    fn draw_path(&self, svg: &mut Svg, points: &[Point3], class: &str, title: &str) -> f64 {
        let runs: Vec<Vec<Spot>> = points
            .split(|point| !is_place(point))
            .map(|run| run.iter().map(|point| self.spot(point)).collect())
            .collect();
        let thinned = lines(&runs, MOST_SEGMENTS);
        let mut path = Path::default();
        for run in &thinned.lines {
            path.open(line(run));
        }
        svg.path(class, &path, title);
        if segments(&runs) > MOST_SEGMENTS { thinned.raster_mm } else { 0.0 }
    }

    /// The name of the view and the directions of its axes, at the near lower left corner of the blank.
    fn draw_name(&self, svg: &mut Svg, corners: &[Spot]) {
        const LENGTH_MM: f64 = 8.0;
        let origin = corners[0];
        let directions: &[(&str, Point3)] = match self.view {
            View::Oblique => &[
                ("x", Point3::new(1.0, 0.0, 0.0)),
                ("z", Point3::new(0.0, 0.0, 1.0)),
                ("y", Point3::new(0.0, 2.0, 0.0)),
            ],
            View::Top => &[("x", Point3::new(1.0, 0.0, 0.0)), ("y", Point3::new(0.0, 1.0, 0.0))],
        };
        for (name, direction) in directions {
            let (x, y) = self.view.project(direction);
            let tip = spot(origin.x + LENGTH_MM * x, origin.y - LENGTH_MM * y);
            draw_arrow(svg, origin, tip);
            svg.text("small head halo", spot(tip.x + 1.0, tip.y + 0.4), Anchor::Start, name);
        }
        let below = spot(self.foot.x, self.foot.y + NAME_MM);
        svg.text("small head", below, Anchor::Start, self.view.name());
    }
}
