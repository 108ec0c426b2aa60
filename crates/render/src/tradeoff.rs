//! Cost against error, both logarithmic, beside the bias of the same contestants, row by row.
//!
//! Names of contestants that lie close together would cover each other, so each mark has the number
//! of its row.
//!
//! An error of 0 has no place on a logarithmic axis. It has its own band at the foot, where the
//! axis is broken.

use super::check;
use super::colors::{INK, MUTED};
use super::furniture::{Block, DETAIL, NAME, stroke};
use super::lettering::{Anchor, Type};
use super::marks::Bounds;
use super::page::page;
use super::plot::{self, Axis, Direction, Span};
use super::point_labels::{self, LabeledPoint};
use super::sheet::{Drawing, Sheet};
use super::tradeoff_rows::{self, TradeoffPoint, mark};

/// Width and height of the plot of cost against error \[px\].
const SIZE: [f64; 2] = [980.0, 800.0];
/// Height of the band of zeros \[px\].
const ZERO_BAND: f64 = 104.0;
/// Gap between the plot and the rows beside it, with room for names of ticks \[px\].
const GAP: f64 = 64.0;
/// Room above the plots for their titles \[px\]; `FLOOR_NAME` is the room for the name of a least
/// cost below these.
const HEAD: f64 = 44.0;
const FLOOR_NAME: f64 = 34.0;

/// Picture of cost against accuracy.
#[derive(Clone, Copy, Debug)]
pub struct Tradeoff<'a> {
    /// Title; may be empty.
    pub title: &'a str,
    /// Lines below; long ones are wrapped.
    pub caption: &'a [String],
    /// Name of the cost, with its unit.
    pub cost_name: &'a str,
    /// Name of the error, with its unit.
    pub error_name: &'a str,
    /// Words for an error of 0, such as `0: none wrong`.
    pub zero_name: &'a str,
    /// Name of the signed bias, with its unit.
    pub bias_name: &'a str,
    /// Least possible cost, and its name over the plot.
    pub floor: Option<(f64, &'a str)>,
    /// Contestants, grouped by family.
    pub points: &'a [TradeoffPoint<'a>],
    /// Indices of the points on the Pareto front, by rising cost.
    pub front: &'a [usize],
}

/// Draws cost against error.
///
/// # Errors
/// A cost, error or bias that is not finite, a cost that is not above 0, an error below 0, or a
/// front that names no point.
pub fn draw_tradeoff(plot: &Tradeoff<'_>) -> Result<Sheet, String> {
    check(plot)?;
    let window = Window::of(plot);
    let y = window.y_axis(plot.error_name);
    let x = window.x.axis(plot.cost_name, Direction::Across, SIZE[0]);
    let left = (y.name_at + 24.0).ceil();
    let mut framed = plot::framed(SIZE, &x, &y, &content(plot, &window));
    if window.band > 0.0 {
        break_marks(&mut framed, SIZE[1] - window.band);
    }
    let rows = tradeoff_rows::rows(plot.points, plot.bias_name, SIZE[1]);
    let mut drawing = Drawing::default();
    let rows_left = left + SIZE[0] + GAP;
    for (title, at) in [("What accuracy costs", left), ("Which way each errs", rows_left)] {
        drawing.text(at, 26.0, NAME, title);
    }
    let head = HEAD + if plot.floor.is_some() { FLOOR_NAME } else { 0.0 };
    drawing.place(&framed, left, head);
    drawing.place(&rows.drawing, rows_left, head);
    let height = head + rows.height.max(SIZE[1] + x.name_at + 8.0);
    let body = Block { width: rows_left + rows.width, height: height + 16.0, drawing };
    Ok(page(plot.title, &body, plot.caption, [22.0, 0.0]))
}

fn check(plot: &Tradeoff<'_>) -> Result<(), String> {
    let is_cost = |cost: f64| cost.is_finite() && cost > 0.0;
    let is_good = |point: &TradeoffPoint<'_>| {
        point.place.is_none_or(|(cost, error)| is_cost(cost) && error.is_finite() && error >= 0.0)
            && point.bias.is_none_or(f64::is_finite)
    };
    check::each(plot.points, is_good, |point| point.label, "a finite cost above 0, error and bias")?;
    if plot.floor.is_some_and(|(cost, _)| !is_cost(cost)) {
        return Err("cannot draw the least cost: wanted it finite and above 0".into());
    }
    match plot.front.iter().all(|k| plot.points.get(*k).is_some_and(|point| point.place.is_some())) {
        true => Ok(()),
        false => Err("cannot draw the front: wanted points that have a place".into()),
    }
}

/// Mapping of costs and errors to the plot.
#[derive(Clone, Copy, Debug)]
struct Window {
    x: Span,
    y: Span,
    /// Height of the band of zeros; 0 without a zero \[px\].
    band: f64,
}

impl Window {
    fn of(plot: &Tradeoff<'_>) -> Self {
        let places = || plot.points.iter().filter_map(|point| point.place);
        let has_zero = places().any(|(_, error)| error <= 0.0);
        let costs = places().map(|place| place.0).chain(plot.floor.map(|floor| floor.0));
        Window {
            x: Span { ends: padded(costs, 1.6), is_log: true },
            y: Span { ends: padded(places().map(|place| place.1).filter(|error| *error > 0.0), 2.0), is_log: true },
            band: if has_zero { ZERO_BAND } else { 0.0 },
        }
    }

    fn at(&self, (cost, error): (f64, f64)) -> [f64; 2] {
        let above = SIZE[1] - self.band;
        let y = if error > 0.0 { above * (1.0 - self.y.share(error)) } else { SIZE[1] - self.band / 2.0 };
        [SIZE[0] * self.x.share(cost), y]
    }

    fn y_axis(&self, name: &str) -> Axis {
        let mut axis = self.y.axis(name, Direction::Up, SIZE[1] - self.band);
        if self.band > 0.0 {
            axis.ticks.push((SIZE[1] - self.band / 2.0, "0".to_string()));
        }
        axis
    }
}

/// Returns ends around some values above 0: a factor beyond the least and the largest, at least two
/// powers of ten apart.
fn padded(values: impl Iterator<Item = f64>, factor: f64) -> [f64; 2] {
    const LEAST_RATIO: f64 = 100.0;
    let (low, high) = values.fold((f64::INFINITY, 0.0_f64), |(low, high), v| (low.min(v), high.max(v)));
    if low > high {
        return [1e-3, 1.0];
    }
    let (low, high) = (low / factor, high * factor);
    let wider = (LEAST_RATIO * low / high).max(1.0).sqrt();
    [low / wider, high * wider]
}

/// Draws the content of the frame: the band of zeros, the floor, the front, marks and their labels.
fn content(plot: &Tradeoff<'_>, window: &Window) -> Drawing {
    let mut drawing = Drawing::default();
    let mut taken: Vec<Bounds> = Vec::new();
    let top_of_band = SIZE[1] - window.band;
    if window.band > 0.0 {
        drawing.rect([0.0, top_of_band, SIZE[0], window.band], "fill=\"#0072B2\" fill-opacity=\"0.07\"");
        drawing.line([0.0, top_of_band], [SIZE[0], top_of_band], &stroke(MUTED, 1.6, "2 6"));
        let name = Type { color: INK, anchor: Anchor::End, ..DETAIL };
        drawing.text(SIZE[0] - 14.0, SIZE[1] - 14.0, name, plot.zero_name);
        let width = name.width(plot.zero_name);
        taken.push([SIZE[0] - 20.0 - width, SIZE[1] - 38.0, SIZE[0], SIZE[1]]);
    }
    if let Some((cost, name)) = plot.floor {
        let x = window.x.share(cost) * SIZE[0];
        floor(&mut drawing, x, name);
        taken.push([x - 2.0, 0.0, x + 2.0, SIZE[1]]);
    }
    let front: Vec<[f64; 2]> =
        plot.front.iter().filter_map(|k| plot.points[*k].place).map(|place| window.at(place)).collect();
    if front.len() > 1 {
        drawing.polyline(&front, &format!("{} stroke-opacity=\"0.55\"", stroke(MUTED, 3.0, "")));
        taken.extend(front.windows(2).flat_map(|ends| point_labels::along(ends[0], ends[1])));
    }
    let placed = || plot.points.iter().enumerate().filter_map(|(k, point)| Some((k, point, window.at(point.place?))));
    let labeled = placed().map(|(k, point, at)| LabeledPoint { at, number: k + 1, color: mark(point.look).color });
    let labels = point_labels::place(&labeled.collect::<Vec<_>>(), SIZE, taken);
    point_labels::leaders(&mut drawing, &labels);
    let marks: Vec<_> = placed().collect();
    marks.iter().rev().for_each(|(_, point, at)| mark(point.look).draw_marker(&mut drawing, *at));
    point_labels::numbers(&mut drawing, &labels);
    drawing
}

/// Draws the least cost as a dashed line, with its name over the frame, where no mark is.
fn floor(drawing: &mut Drawing, x: f64, name: &str) {
    drawing.line([x, -5.0], [x, SIZE[1]], &stroke(INK, 2.2, "10 7"));
    let half = DETAIL.width(name) / 2.0;
    let middle = x.min(SIZE[0] - half).max(half);
    drawing.text(middle, -15.0, Type { color: INK, anchor: Anchor::Middle, ..DETAIL }, name);
}

/// Draws the break of the axis at both sides of the frame.
fn break_marks(drawing: &mut Drawing, y: f64) {
    for x in [0.0, SIZE[0]] {
        let line = |up: f64| [[x - 11.0, y + 6.0 - up], [x + 11.0, y - 6.0 - up]];
        let [low, high] = [line(-5.0), line(5.0)];
        drawing.polygon(&[low[0], low[1], high[1], high[0]], "fill=\"#FFFFFF\"");
        for [from, to] in [low, high] {
            drawing.line(from, to, &stroke(INK, 1.8, ""));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(place: (f64, f64), bias: f64) -> TradeoffPoint<'static> {
        TradeoffPoint { label: "a", family: "Engines", look: 0, place: Some(place), bias: Some(bias) }
    }

    fn plot<'a>(points: &'a [TradeoffPoint<'a>], front: &'a [usize]) -> Tradeoff<'a> {
        Tradeoff {
            title: "Speed against accuracy",
            caption: &[],
            cost_name: "CPU time [ns]",
            error_name: "Wrong receivers [share]",
            zero_name: "0: none wrong",
            bias_name: "Bias [points]",
            floor: Some((0.5, "memory floor")),
            points,
            front,
        }
    }

    #[test]
    fn points_lie_where_their_numbers_say() {
        let points = [point((1.0, 0.1), 1.0), point((100.0, 0.001), -2.0), point((10.0, 0.0), 0.0)];
        let plot = plot(&points, &[0, 2]);
        let window = Window::of(&plot);
        // Costs from 0.5/1.6 to 160, errors from 0.0005 to 0.2 above a band of zeros of 104 px.
        let [low, high] = [0.5_f64 / 1.6, 160.0];
        let x = 980.0 * (10.0 / low).ln() / (high / low).ln();
        let [cx, cy] = window.at((10.0, 0.0));
        assert!((cx - x).abs() < 1e-9 && (cy - 748.0).abs() < 1e-9);
        let y = (800.0 - 104.0) * (0.2_f64 / 0.1).ln() / (0.2_f64 / 0.0005).ln();
        assert!((window.at((1.0, 0.1))[1] - y).abs() < 1e-9);
    }

    #[test]
    fn zeros_have_a_band_only_where_there_are_some() {
        for (points, has_band) in
            [(&[point((1.0, 0.1), 1.0)][..], false), (&[point((1.0, 0.0), 1.0)], true), (&[], false)]
        {
            let sheet = draw_tradeoff(&plot(points, &[])).expect("the plot is valid");
            assert_eq!(sheet.furniture.svg.contains("none wrong"), has_band, "{points:?}");
        }
    }

    #[test]
    fn impossible_points_are_refused() {
        for (place, bias, front) in [
            ((0.0, 0.1), 0.0, 0),
            ((f64::NAN, 0.1), 0.0, 0),
            ((1.0, -0.1), 0.0, 0),
            ((1.0, f64::INFINITY), 0.0, 0),
            ((1.0, 1.0), f64::NAN, 0),
            ((1.0, 1.0), 0.0, 1),
        ] {
            assert!(check(&plot(&[point(place, bias)], &[front])).is_err(), "{place:?} {bias} {front}");
        }
    }
}
