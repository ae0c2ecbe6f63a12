//! Each drawing against the numbers it was made from.

use super::*;

/// The scale of a chart, from the numbers of its ticks.
struct Scale {
    /// Value at a place of 0 on the sheet, and value for each mm of the sheet.
    x: (f64, f64),
    y: (f64, f64),
}

impl Scale {
    /// Of the first chart in a node.
    fn of(within: Node) -> Self {
        let axes = of_class(within, "axes").next().unwrap();
        let ticks = |anchor: &str, coordinate: &str, below: f64| {
            let ticks = of_class(axes, "number").filter(|node| node.attribute("text-anchor") == Some(anchor));
            let ticks = ticks.map(|node| {
                (attribute(&node, coordinate) - below, node.text().unwrap().parse::<f64>().unwrap())
            });
            let ticks: Vec<(f64, f64)> = ticks.collect();
            let (first, last) = (ticks[0], ticks[ticks.len() - 1]);
            let each = (last.1 - first.1) / (last.0 - first.0);
            (first.1 - each * first.0, each)
        };
        // The numbers of an upright axis stand 0.8 mm below their ticks, to be in the middle.
        Self { x: ticks("middle", "x", 0.0), y: ticks("end", "y", 0.8) }
    }

    fn value(&self, sheet: &Point2) -> Point2 {
        Point2::new(self.x.0 + self.x.1 * sheet.x, self.y.0 + self.y.1 * sheet.y)
    }

    fn values(&self, node: &Node) -> Vec<Point2> {
        path(node).iter().map(|at| self.value(at)).collect()
    }
}

/// The lines of a path of several.
fn lines(node: &Node) -> Vec<Vec<Point2>> {
    let data = node.attribute("d").unwrap();
    let line = |part: &str| -> Vec<Point2> {
        let numbers: Vec<f64> =
            part.split([' ', 'L', 'Z']).filter(|n| !n.is_empty()).map(|n| n.parse().unwrap()).collect();
        numbers.chunks(2).map(|pair| Point2::new(pair[0], pair[1])).collect()
    };
    data.split('M').filter(|part| !part.is_empty()).map(line).collect()
}

fn texts(document: &Document) -> String {
    let is_words = |node: &Node| node.tag_name().name() == "text" && !classes(node).contains(&"under");
    let texts = document.descendants().filter(is_words);
    texts.filter_map(|node| node.text().map(str::to_owned)).collect::<Vec<_>>().join(" | ")
}

fn middle(node: &Node) -> Point2 {
    let [left, right, top, bottom] = extent(node).unwrap();
    Point2::new(f64::midpoint(left, right), f64::midpoint(top, bottom))
}

/// The first node of a class beyond the legend.
fn first<'a, 'd>(document: &'a Document<'d>, class: &'a str) -> Node<'a, 'd> {
    nodes(document, class).remove(0)
}

fn nodes<'a, 'd>(document: &'a Document<'d>, class: &'a str) -> Vec<Node<'a, 'd>> {
    let in_legend = |node: &Node| node.ancestors().any(|above| classes(&above).contains(&"legend"));
    of_class(document.root(), class).filter(|node| !in_legend(node)).collect()
}

#[test]
fn the_map_shows_limits_levels_and_sets_in_their_places() {
    let drawing = map(&table1::optimum_map());
    let document = Document::parse(&drawing.svg).unwrap();
    let scale = Scale::of(document.root());
    let limit = scale.values(&first(&document, "limit"));
    // Eq. 4 with k = 2/3.
    let longest = |alpha: f64| 2.0 / 3.0 * 10.0 * 52.87_f64.to_radians().sin() * alpha.to_radians().cos();
    let on_length = limit.iter().filter(|at| (at.x - longest(at.y)).abs() < 0.02).count();
    let on_swing = limit.iter().filter(|at| (at.y - 50.0).abs() < 0.1).count();
    assert!(on_length > 20 && on_swing >= 2, "{limit:?}");
    assert!(on_length + on_swing >= limit.len() - 4, "{limit:?}");
    let optimum = scale.value(&middle(&first(&document, "mark")));
    assert!((optimum - Point2::new(4.398, 34.155)).norm() < 0.05, "{optimum}");
    let initial = scale.value(&middle(&first(&document, "ring")));
    assert!((initial - Point2::new(3.0, 45.0)).norm() < 0.05, "{initial}");
    let mut levels = 0;
    for text in nodes(&document, "halo") {
        let (at, words) = (scale.value(&middle(&text)), text.text().unwrap());
        match words.parse::<f64>() {
            Ok(level) => {
                let time = table1::model(at.x, at.y).time().unwrap();
                assert!((time / level - 1.0).abs() < 0.02, "{words} stands where the time is {time}");
                levels += 1;
            }
            Err(_) if words == "cutting length" => {
                assert_eq!(table1::model(at.x, at.y), Cell::Excluded(Limit::CuttingLength));
            }
            Err(_) if words == "swing angle" => {
                assert_eq!(table1::model(at.x, at.y), Cell::Excluded(Limit::SwingAngle));
            }
            Err(_) => assert!(words == "optimum 307.6 s" || words == "initial set 515.3 s", "{words}"),
        }
    }
    assert!(levels >= 7, "{levels}");
    assert!(texts(&document).contains("40.31 % less time"));
}

#[test]
fn each_band_holds_the_times_of_its_shade() {
    let drawing = map(&table1::optimum_map());
    let document = Document::parse(&drawing.svg).unwrap();
    let scale = Scale::of(document.root());
    let areas = |class: &str| -> Vec<Vec<Point2>> {
        let area = nodes(&document, class).into_iter().find(|node| classes(node).contains(&"area"));
        area.map_or_else(Vec::new, |node| lines(&node))
    };
    let total: f64 = (0..10)
        .flat_map(|band| areas(&format!("band-{band}")))
        .map(|outline| signed_area(&outline).abs())
        .sum();
    // What is not excluded: from h 0.5 to the cutting length, below 50 degrees.
    let strip = |i: i32| {
        let alpha = 5.0 + 45.0 * (f64::from(i) + 0.5) / 1000.0;
        6.6667 * 52.87_f64.to_radians().sin() * alpha.to_radians().cos() - 0.5
    };
    let wanted = (0..1000).map(strip).sum::<f64>() / 1000.0 * 45.0 / (scale.x.1 * scale.y.1).abs();
    assert!((total / wanted - 1.0).abs() < 0.01, "{total} {wanted}");
    let fastest = areas("band-0").concat();
    let slowest = areas("band-9").concat();
    let times = |outline: &[Point2]| -> Vec<f64> {
        let cells = outline.iter().map(|at| scale.value(at)).map(|at| table1::model(at.x, at.y));
        cells.filter_map(Cell::time).collect()
    };
    assert!(times(&fastest).iter().all(|time| *time < 355.0) && times(&fastest).len() > 20);
    assert!(times(&slowest).iter().all(|time| *time > 740.0) && times(&slowest).len() > 20);
}

#[test]
fn a_map_without_any_allowed_place_says_so() {
    let cells = vec![(1.0, Cell::Excluded(Limit::Layers)), (2.0, Cell::Excluded(Limit::Points))];
    let row = |swing_angle_deg| Row { swing_angle_deg, cells: cells.clone() };
    let drawing = map(&OptimumMap { rows: vec![row(10.0), row(20.0)], optimum: None, initial: None });
    let words = texts(&Document::parse(&drawing.svg).unwrap());
    assert!(words.contains("within all limits") && words.contains("layers: less than one"), "{words}");
    assert!(!words.contains("time in s"));
}

#[test]
fn bars_are_as_high_as_their_numbers() {
    let data = table1::comparison();
    let drawing = comparison(&data);
    let document = Document::parse(&drawing.svg).unwrap();
    let halves = |split: TimeSplit| [split.cutting_s, split.turning_s, split.moving_s, split.total_s()];
    let bars = of_class(document.root(), "bars").next().unwrap();
    for (class, set) in [("bar-2", data.initial.unwrap()), ("bar-1", data.optimised)] {
        let heights: Vec<f64> = of_class(bars, class).map(|bar| attribute(&bar, "height")).collect();
        assert_eq!(heights.len(), 4);
        for (height, time) in heights.iter().zip(halves(set.split)) {
            let wanted = heights[3] * time / set.split.total_s();
            assert!((height - wanted).abs() < 0.02, "{time} s is {height} mm high, not {wanted}");
            assert!(texts(&document).contains(&super::super::sheet::figure(time, 1)));
        }
    }
    let whole = |class| attribute(&of_class(bars, class).last().unwrap(), "height");
    assert!((whole("bar-1") / whole("bar-2") - 307.599 / 515.305).abs() < 1e-3);
}

#[test]
fn the_sketches_show_the_scallop_of_eq_12() {
    let mut data = table1::comparison();
    let lengths = |data: &Comparison| -> Vec<f64> {
        let drawing = comparison(data);
        let document = Document::parse(&drawing.svg).unwrap();
        let scale = scales(&document)[0];
        let lines = of_class(document.root(), "sketch").flat_map(|sketch| of_class(sketch, "stroke-4"));
        lines
            .map(|line| {
                let [left, right, top, bottom] = extent(&line).unwrap();
                scale * (right - left).hypot(bottom - top)
            })
            .collect()
    };
    let found = lengths(&data);
    assert!((found[0] - 6.708).abs() < 0.01 && (found[1] - 9.289).abs() < 0.01, "{found:?}");
    // Interlaced, the next layer's tip lies straight below: (2 - epsilon) h, here without overlap.
    data.optimised.shift_mm = data.optimised.step_mm / 2.0;
    assert!((lengths(&data)[1] - 2.0 * 4.398).abs() < 0.01);
    data.initial = None;
    assert_eq!(lengths(&data).len(), 1);
}

#[test]
fn the_section_shows_each_tip_with_both_arms() {
    let data = table1::published();
    let drawing = section(&data, "section");
    let document = Document::parse(&drawing.svg).unwrap();
    let words = texts(&document);
    for part in ["SEEN ALONG +y", "x to the right, z up", "119 tips", "(limit 10 mm)", "No chip stays"] {
        assert!(words.contains(part), "{part} is missing in {words}");
    }
    let scale = Scale::of(document.root());
    assert!(scale.x.1 > 0.0 && scale.y.1 < 0.0 && (scale.x.1 + scale.y.1).abs() < 1e-4, "equal scales, z up");
    let tips = lines(&first(&document, "tips"));
    let arms = lines(&first(&document, "arms"));
    assert_eq!((tips.len(), arms.len()), (119, 238));
    let (sine, cosine) = 34.155_f64.to_radians().sin_cos();
    for (index, tip) in data.tips.iter().enumerate() {
        assert!((scale.value(&tips[index][0]) - tip).norm() < 0.02);
        for (arm, side) in arms[2 * index..].iter().zip([-1.0, 1.0]) {
            let end = tip + 7.973 * nalgebra::Vector2::new(side * sine, cosine);
            assert!((scale.value(&arm[0]) - tip).norm() < 0.02);
            assert!((scale.value(&arm[1]) - end).norm() < 0.02, "{side} of {tip}");
        }
    }
}

#[test]
fn the_section_shows_what_remains_and_its_largest_scallop() {
    let data = table1::published();
    let drawing = section(&data, "section");
    let document = Document::parse(&drawing.svg).unwrap();
    let scale = Scale::of(document.root());
    let scallop = data.scallop.unwrap();
    let ends = scale.values(&first(&document, "stroke-4"));
    assert!((ends[0] - scallop.foot).norm() < 0.02 && (ends[1] - scallop.ridge).norm() < 0.02);
    assert!(texts(&document).contains("largest scallop 8.0"));
    let mm2 = scale.x.1 * scale.x.1;
    let left: f64 = lines(&first(&document, "left-standing")).iter().map(|l| signed_area(l).abs()).sum();
    let wanted: f64 = data.surface[0].iter().map(|at| (at.y - table1::arc(at.x)) * 0.05).sum();
    assert!((left * mm2 / wanted - 1.0).abs() < 0.01, "{} {wanted}", left * mm2);
    let part = signed_area(&path(&first(&document, "solid-part"))).abs() * mm2;
    let below: f64 = data.contour.iter().map(|at| at.y * 0.25).sum();
    assert!((part / below - 1.0).abs() < 0.01, "{part} {below}");
    assert_eq!(nodes(&document, "detail-section").len(), 0, "the scallop can be seen as it is");
}

#[test]
fn chips_that_stay_and_gouges_are_marked_however_small() {
    let drawing = section(&faulty_section(), "section");
    let document = Document::parse(&drawing.svg).unwrap();
    let words = texts(&document);
    assert!(
        words.contains("2 chips stay in place.") && words.contains("is cut into at 2 places."),
        "{words}"
    );
    let scale = Scale::of(document.root());
    let place = |class: &str| scale.value(&middle(&first(&document, class)));
    assert!((place("stays") - Point2::new(23.0, 38.0)).norm() < 0.1);
    assert!((place("gouge") - Point2::new(33.0, 12.0)).norm() < 0.1);
    assert!((place("ink-3") - Point2::new(60.1, 39.95)).norm() < 0.1);
    assert!((place("cross") - Point2::new(60.0, 11.0)).norm() < 0.1);
    let detail = Scale::of(nodes(&document, "detail-section")[0]);
    assert!(detail.x.1 < 0.5 * scale.x.1, "the small scallop is shown enlarged");
}

#[test]
fn a_section_of_very_many_tips_is_small_and_says_what_it_leaves_out() {
    let data = Section { tips: table1::tips(0.3, 0.3), ..table1::published() };
    assert!(data.tips.len() > 30_000);
    let drawing = section(&data, "section");
    assert!(drawing.svg.len() < 500_000, "{} bytes", drawing.svg.len());
    let document = Document::parse(&drawing.svg).unwrap();
    let scale = Scale::of(document.root());
    let drawn: Vec<Point2> = path(&first(&document, "tips")).iter().map(|at| scale.value(at)).collect();
    assert!(texts(&document).contains(&format!("{} of {} tips are drawn", drawn.len() / 2, data.tips.len())));
    for tip in data.tips.iter().step_by(97) {
        assert!(drawn.iter().any(|at| (at - tip).norm() < 2.0), "nothing near {tip}");
    }
}

/// Where (0, 0, 0) is on the sheet, and (0, D, 0), from the box of the blank.
fn corners(view: Node) -> (Point2, Point2) {
    let blank = lines(&of_class(view, "blank-edge").next().unwrap());
    (blank[0][0], blank[1][0])
}

#[test]
fn both_paths_are_shown_from_both_sides() {
    let data = table1::paths(&table1::published().tips);
    let drawing = milling(&data);
    let document = Document::parse(&drawing.svg).unwrap();
    let scale = scales(&document)[0];
    let views: Vec<Node> = of_class(document.root(), "view-of-paths").collect();
    for (view, is_top) in [(views[0], false), (views[1], true)] {
        let (origin, far) = corners(view);
        let depth = far - origin;
        let project = |point: &Point3| {
            let up = if is_top { 0.0 } else { -point.z };
            origin + nalgebra::Vector2::new(point.x, up) / scale + depth * (point.y / 50.0)
        };
        for (points, class) in [(&data.milling, "stroke-2"), (&data.converted, "stroke-1")] {
            let drawn = lines(&of_class(view, class).next().unwrap());
            let near = |at: &Point2, segment: &[Point2]| {
                crate::planning::geometry::simplify::distance_to_segment(at, &segment[0], &segment[1]) < 0.4
            };
            for point in points.iter().map(project) {
                assert!(drawn.iter().any(|line| line.windows(2).any(|pair| near(&point, pair))), "{point}");
            }
            let wanted = points.iter().map(project).map(|at| at.y).fold(f64::INFINITY, f64::min);
            let most = drawn.iter().flatten().map(|at| at.y).fold(f64::INFINITY, f64::min);
            assert!((wanted - most).abs() < 0.02);
        }
        assert!(if is_top { depth.x.abs() < 1e-9 && depth.y < 0.0 } else { depth.x > 0.0 && depth.y < 0.0 });
    }
    assert!(!texts(&document).contains("drawn as one"));
}

#[test]
fn paths_of_very_many_points_are_thinned_out() {
    let data = table1::paths(&table1::tips(0.3, 0.3));
    assert!(data.converted.len() > 100_000);
    let drawing = milling(&data);
    assert!(drawing.svg.len() < 150_000, "{} bytes", drawing.svg.len());
    let document = Document::parse(&drawing.svg).unwrap();
    assert!(texts(&document).contains("drawn as one"));
    let top = of_class(document.root(), "view-of-paths").last().unwrap();
    let x: Vec<f64> = path(&of_class(top, "stroke-2").next().unwrap()).iter().map(|at| at.x).collect();
    let (least, most) =
        (x.iter().copied().fold(f64::INFINITY, f64::min), x.iter().copied().fold(0.0, f64::max));
    let gaps = (0..80).map(|i| least + (most - least) * f64::from(i) / 79.0);
    assert!(gaps.into_iter().all(|wanted| x.iter().any(|x| (x - wanted).abs() < 1.0)));
}

#[test]
fn joints_show_their_curves_limits_and_the_first_fault() {
    let data = faulty();
    let drawing = joints(&data);
    let document = Document::parse(&drawing.svg).unwrap();
    let charts: Vec<Node> = of_class(document.root(), "joint").collect();
    assert_eq!(charts.len(), 6);
    for (joint, chart) in charts.iter().enumerate() {
        let scale = Scale::of(*chart);
        let drawn = scale.values(&of_class(*chart, "stroke-1").next().unwrap());
        let extremes = |values: Vec<f64>| {
            (
                values.iter().copied().fold(f64::INFINITY, f64::min),
                values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            )
        };
        let wanted = extremes(data.samples.iter().map(|sample| sample.joints_deg[joint]).collect());
        let found = extremes(drawn.iter().map(|at| at.y).collect());
        let degree = 0.05 * scale.y.1.abs();
        assert!((wanted.0 - found.0).abs() < degree && (wanted.1 - found.1).abs() < degree, "A{}", joint + 1);
        let levels: Vec<f64> =
            of_class(*chart, "limit-dashed").map(|line| scale.value(&middle(&line)).y).collect();
        let (low, high) = data.limits_deg[joint];
        assert!((levels[0] - low).abs() < degree && (levels[1] - high).abs() < degree, "{levels:?}");
        let fault = scale.value(&middle(&of_class(*chart, "stroke-4").next().unwrap()));
        assert!((fault.x - 212.4).abs() < 0.1, "{fault}");
        assert_eq!(of_class(*chart, "cross").count(), usize::from(joint == 3));
    }
    let words = texts(&document);
    for part in [
        "A4 beyond its limit, layer_07.src line 214, at 212.4 s",
        "limits -140° and -5°",
        "line 214",
        "largest 0.8",
    ] {
        assert!(words.contains(part), "{part} is missing in {words}");
    }
    let good = joints(&table1::joints(3000));
    assert!(texts(&Document::parse(&good.svg).unwrap()).contains("The robot follows the whole program."));
}

#[test]
fn a_spike_among_very_many_samples_is_shown() {
    let mut data = table1::joints(100_000);
    data.samples[77_777].speed_ratio = 2.5;
    let drawing = joints(&data);
    assert!(drawing.svg.len() < 500_000, "{} bytes", drawing.svg.len());
    let document = Document::parse(&drawing.svg).unwrap();
    let chart = of_class(document.root(), "speed").next().unwrap();
    let scale = Scale::of(chart);
    let drawn = scale.values(&of_class(chart, "stroke-1").next().unwrap());
    let spike = drawn.iter().find(|at| at.y > 2.4).unwrap();
    assert!((spike.x - 315.0 * 0.777_77).abs() < 0.1, "{spike}");
    assert!(texts(&document).contains("largest 2.5 at 245 s"), "{}", texts(&document));
}

#[test]
fn the_contours_show_both_curves_and_the_largest_deviation() {
    let likeness = table1::likeness();
    let drawing = contours(&likeness, Origin::Simulated);
    let document = Document::parse(&drawing.svg).unwrap();
    let chart = of_class(document.root(), "contours").next().unwrap();
    let scale = Scale::of(chart);
    let wanted = scale.values(&of_class(chart, "finished").next().unwrap());
    assert!(wanted.iter().all(|at| (at.y - table1::arc(at.x)).abs() < 0.02), "{wanted:?}");
    let cut = scale.values(&of_class(chart, "stroke-2").next().unwrap());
    let most = cut.iter().map(|at| at.y).fold(0.0, f64::max);
    assert!((most - likeness.samples.cut.iter().copied().fold(0.0, f64::max)).abs() < 0.02);
    let below = of_class(document.root(), "deviation").next().unwrap();
    let mark = Scale::of(below).value(&middle(&of_class(below, "ring").next().unwrap()));
    let largest = Point2::new(likeness.max_deviation_x_mm, likeness.max_deviation_mm);
    assert!((mark - largest).norm() < 0.1, "{mark} {largest}");
    assert!(texts(&document).contains("at 1000 places from x 0 to 85 mm"));
}

#[test]
fn what_is_cut_too_deep_deviates_downward() {
    let low = table1::contour().iter().map(|at| Point2::new(at.x, at.y - 1.5)).collect();
    let likeness = compare(&table1::contour(), &[low]).unwrap();
    let drawing = contours(&likeness, Origin::Measured);
    let document = Document::parse(&drawing.svg).unwrap();
    let below = of_class(document.root(), "deviation").next().unwrap();
    let scale = Scale::of(below);
    let drawn = scale.values(&of_class(below, "stroke-2").next().unwrap());
    assert!(drawn.iter().all(|at| at.y < -1.0 && at.y >= -1.51), "{drawn:?}");
}

#[test]
fn the_correlation_marks_its_peaks_with_both_values() {
    let likeness = measured();
    let drawing = correlation(&likeness, Origin::Measured);
    let document = Document::parse(&drawing.svg).unwrap();
    let words = texts(&document);
    for value in [likeness.correlation, likeness.correlation_mean_removed] {
        let value = super::super::sheet::figure(value.unwrap(), 6);
        assert!(words.matches(&value).count() == 2, "{value} in the words and at the peak: {words}");
    }
    let scale = Scale::of(document.root());
    let peak = scale.value(&middle(&nodes(&document, "ink-2")[0]));
    assert!((peak.y - likeness.correlation_mean_removed.unwrap()).abs() < 0.01, "{peak}");
    let values = scale.values(&first(&document, "stroke-1"));
    let highest = values.iter().map(|at| at.y).fold(0.0, f64::max);
    assert!((highest - likeness.correlation.unwrap()).abs() < 0.01, "{highest}");
}

#[test]
fn a_contour_that_is_cut_too_far_right_has_its_peak_above_0() {
    let hill = |shift: f64| -> Vec<Point2> {
        let height = |x: f64| 5.0 + 10.0 * (-((x - 40.0 - shift) / 5.0).powi(2)).exp();
        (0..=850).map(|i| f64::from(i) * 0.1).map(|x| Point2::new(x, height(x))).collect()
    };
    let likeness = compare(&hill(0.0), &[hill(5.0)]).unwrap();
    let drawing = correlation(&likeness, Origin::Simulated);
    let document = Document::parse(&drawing.svg).unwrap();
    let peak = Scale::of(document.root()).value(&middle(&nodes(&document, "ink-2")[0]));
    // 5 mm in samples of 85 mm / 999; that the hill is nearer to one end draws the peak a little toward 0.
    assert!((peak.x - 5.0 * 999.0 / 85.0).abs() < 5.0, "{peak}");
}
