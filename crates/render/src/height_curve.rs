//! P_LoS against the UAV's height, one curve per UAV, drawn as the steps that it is.

use super::colors::MUTED;
use super::furniture::{self, Block, DETAIL};
use super::lettering::number;
use super::line_look::{COLORS, stroke};
use super::marks::Label;
use super::page::page;
use super::plot_axis::{Axis, Direction, Span};
use super::plot_frame;
use super::sheet::{Drawing, Sheet};
use super::side_labels::{self, LEADER, SideLabel};

const HEIGHT: f64 = 760.0;
const AXIS: f64 = 104.0;
/// Width of the plot and the labels at its right \[px\].
const WIDTH: f64 = 1500.0;

/// So many colors are used in turn.
const N_COLORS: usize = 7;
/// Line patterns, so that neighbors differ in more than color; with the colors 28 different lines.
const DASHES: [&str; 4] = ["", "18 7", "5 6", "20 6 5 6"];
/// More labels than this are not placed beside the plot.
const MOST_LABELS: usize = 24;
/// Up to this many asked heights have a line down to the axis.
const MOST_ASKED_LINES: usize = 8;
/// Up to this many labels have a second line.
const MOST_TWO_LINES: usize = 12;

/// A plot of P_LoS against the UAV's height. Heights are above one base \[m\].
#[derive(Clone, Copy, Debug)]
pub struct HeightCurvePlot<'a> {
    /// Title.
    pub title: &'a str,
    /// Lines below; long ones are wrapped.
    pub caption: &'a [String],
    /// What is on the horizontal axis, such as `UAV height above ground`.
    pub height_name: &'a str,
    /// Ends of the horizontal axis \[m\].
    pub heights_m: [f64; 2],
    /// The curves, the first one drawn on top.
    pub curves: &'a [HeightCurveLine<'a>],
}

/// The curve of one UAV.
#[derive(Clone, Copy, Debug)]
pub struct HeightCurveLine<'a> {
    /// What it is called, such as `UAV 1`.
    pub label: &'a str,
    /// The lowest height that the UAV may have \[m\]: the curve begins there.
    pub lowest_m: f64,
    /// Heights \[m\], ascending, with P_LoS from there up.
    pub steps: &'a [(f64, f64)],
    /// The height that was asked for \[m\], marked on the curve.
    pub marked_m: f64,
}

impl HeightCurveLine<'_> {
    /// P_LoS at a height \[m\].
    fn p_los(&self, height_m: f64) -> f64 {
        let above = self.steps.partition_point(|s| s.0 <= height_m);
        above.checked_sub(1).map_or(0.0, |last| self.steps[last].1)
    }
}

/// How heights and probabilities map to the drawing.
#[derive(Clone, Copy, Debug)]
struct Window {
    heights_m: [f64; 2],
    width: f64,
}

impl Window {
    fn x(&self, height_m: f64) -> f64 {
        let [low, high] = self.heights_m;
        ((height_m - low) / (high - low)).clamp(0.0, 1.0) * self.width
    }

    fn y(&self, p_los: f64) -> f64 {
        (1.0 - p_los) * HEIGHT
    }

    fn shows(&self, height_m: f64) -> bool {
        height_m >= self.heights_m[0] && height_m <= self.heights_m[1]
    }
}

/// Draws P_LoS against height.
///
/// # Errors
/// Ends of the axis that are not finite or not ascending, or a curve with a value that is not finite or not ascending.
pub fn draw_height_curve(plot: &HeightCurvePlot<'_>) -> Result<Sheet, String> {
    check(plot)?;
    let labels = side_labels(plot);
    let words = labels.iter().map(SideLabel::width).fold(0.0, f64::max);
    let side = if labels.is_empty() { 0.0 } else { (LEADER + words).ceil() };
    let window = Window { heights_m: plot.heights_m, width: WIDTH - side };
    let mut drawing = Drawing::default();
    let mut framed = axes(plot, &window);
    framed.svg.push_str(&curves(plot, &window).svg);
    plot_frame::frame(&mut framed, [window.width, HEIGHT]);
    framed.svg.push_str(&side_labels::beside(&labels, [window.width, HEIGHT]).svg);
    if plot.curves.len() > MOST_LABELS {
        let rest = format!("+ {} more", plot.curves.len() - MOST_LABELS);
        framed.text(window.width + LEADER, HEIGHT + 32.0, DETAIL, &rest);
    }
    drawing.place(&framed, AXIS, 0.0);
    let body = Block { width: AXIS + WIDTH, height: HEIGHT + 92.0, drawing };
    Ok(page(plot.title, &body, plot.caption, [24.0, 0.0]))
}

fn check(plot: &HeightCurvePlot<'_>) -> Result<(), String> {
    let [low, high] = plot.heights_m;
    if !(low.is_finite() && high.is_finite() && low < high) {
        return Err(format!("cannot draw heights from {low} m to {high} m: they must be finite and ascend"));
    }
    let is_bad = |curve: &HeightCurveLine<'_>| {
        let finite = |(h, p): &(f64, f64)| h.is_finite() && (0.0..=1.0).contains(p);
        let ends = [curve.lowest_m, curve.marked_m];
        !ends.iter().all(|h| h.is_finite())
            || !curve.steps.iter().all(finite)
            || !curve.steps.windows(2).all(|w| w[0].0 < w[1].0 && w[0].1 <= w[1].1)
    };
    match plot.curves.iter().find(|c| is_bad(c)) {
        Some(curve) => Err(format!("cannot draw the curve `{}`: its steps must be finite and ascend", curve.label)),
        None => Ok(()),
    }
}

fn axes(plot: &HeightCurvePlot<'_>, window: &Window) -> Drawing {
    let heights = Span { ends: plot.heights_m, is_log: false };
    let [low, high] = plot.heights_m;
    let height_name = format!("{} [m]", plot.height_name);
    let ticks = furniture::ticks(low, high, window.width / 150.0);
    let x = heights.axis_at(&height_name, Direction::Across, window.width, ticks);
    let tenths = (0..=10).map(|tenth| f64::from(tenth) / 10.0).map(|p| (p, number(p, 1))).collect();
    let name = "P_LoS: share of receivers in line of sight";
    let y = Span { ends: [0.0, 1.0], is_log: false }.axis_at(name, Direction::Up, HEIGHT, tenths);
    plot_frame::axes([window.width, HEIGHT], &x, &Axis { name_at: 72.0, ..y })
}

/// The look of the line with this index.
fn line_style(index: usize) -> (&'static str, String) {
    let (color, dash) = (COLORS[index % N_COLORS], DASHES[index % DASHES.len()]);
    (color, stroke(color, 4.5, dash))
}

fn curves(plot: &HeightCurvePlot<'_>, window: &Window) -> Drawing {
    let mut drawing = Drawing::default();
    // The asked heights, each once, behind the curves.
    let mut asked: Vec<f64> = plot.curves.iter().map(|c| c.marked_m).filter(|h| window.shows(*h)).collect();
    asked.sort_by(f64::total_cmp);
    asked.dedup();
    let dotted = format!("stroke=\"{MUTED}\" stroke-width=\"1.8\" stroke-dasharray=\"2 6\" stroke-linecap=\"round\"");
    let n_lines = if asked.len() <= MOST_ASKED_LINES { asked.len() } else { 0 };
    for height in &asked[..n_lines] {
        let highest = plot.curves.iter().filter(|c| c.marked_m.total_cmp(height).is_eq()).map(|c| c.p_los(*height));
        drawing.line([window.x(*height), window.y(highest.fold(0.0, f64::max))], [window.x(*height), HEIGHT], &dotted);
    }
    if let [only] = plot.curves
        && window.shows(only.marked_m)
    {
        let y = window.y(only.p_los(only.marked_m));
        drawing.line([0.0, y], [window.x(only.marked_m), y], &dotted);
    }
    for (index, curve) in plot.curves.iter().enumerate().rev() {
        let (color, style) = line_style(index);
        let points = step_line(curve, window);
        if let Some([x, y]) = points.first().copied() {
            drawing.polyline(&points, &style);
            if curve.lowest_m > window.heights_m[0] {
                // Lower the UAV cannot be: the line has a stop.
                drawing.line(
                    [x, y - 11.0],
                    [x, (y + 11.0).min(HEIGHT)],
                    &format!("stroke=\"{color}\" stroke-width=\"4.5\""),
                );
            }
        }
    }
    for (index, curve) in plot.curves.iter().enumerate().rev().filter(|(_, c)| window.shows(c.marked_m)) {
        let at = [window.x(curve.marked_m), window.y(curve.p_los(curve.marked_m))];
        drawing.circle(at, 10.0, &format!("fill=\"{}\" stroke=\"#FFFFFF\" stroke-width=\"3\"", line_style(index).0));
    }
    if let [only] = plot.curves
        && window.shows(only.marked_m)
    {
        mark_label(&mut drawing, only, window);
    }
    drawing
}

/// The words at the mark of a single curve. A curve only rises, so below its right and above its left are free.
fn mark_label(drawing: &mut Drawing, curve: &HeightCurveLine<'_>, window: &Window) {
    let (x, y) = (window.x(curve.marked_m), window.y(curve.p_los(curve.marked_m)));
    let height = format!("{} m", number(curve.marked_m, 2));
    let label = Label::new(&[height, format!("P_LoS = {}", p_words(curve))], 24.0);
    let (right, below) = (x + 24.0, y + 26.0);
    let fits = right + label.width < window.width - 8.0 && below + label.height < HEIGHT - 8.0;
    let left = (x - 24.0 - label.width).max(8.0);
    // At the left border the label reaches over the curve to the right of the mark: above that, too.
    let [low, high] = window.heights_m;
    let height_at = |x: f64| low + x / window.width * (high - low);
    let highest = y.min(window.y(curve.p_los(height_at(left + label.width))));
    let above = (highest - 26.0 - label.height).max(8.0);
    let (x, y) = if fits { (right, below) } else { (left, above) };
    label.draw(drawing, x, y);
}

fn p_words(curve: &HeightCurveLine<'_>) -> String {
    format!("{:.4}", curve.p_los(curve.marked_m))
}

/// The steps in the window as one line. Steps that share half a pixel are drawn as one, which no eye can tell.
fn step_line(curve: &HeightCurveLine<'_>, window: &Window) -> Vec<[f64; 2]> {
    const FINEST: f64 = 0.5;
    let [low, high] = window.heights_m;
    let start = curve.lowest_m.max(low);
    if start > high {
        return Vec::new();
    }
    let mut line = vec![[window.x(start), window.y(curve.p_los(start))]];
    for &(height, p_los) in curve.steps.iter().filter(|s| s.0 > start && s.0 <= high) {
        let (x, y) = (window.x(height), window.y(p_los));
        let [_, before] = line[line.len() - 1];
        match line.len().checked_sub(2).map(|k| line[k]) {
            // The last two points are a riser, and this step belongs to it.
            Some([riser, _]) if (line[line.len() - 1][0] - riser).abs() < 1e-9 && x - riser < FINEST => {
                let last = line.len() - 1;
                line[last][1] = y;
            }
            _ => line.extend([[x, before], [x, y]]),
        }
    }
    let [_, end] = line[line.len() - 1];
    line.push([window.x(high), end]);
    line
}

/// The labels of several curves; a single one needs none.
fn side_labels(plot: &HeightCurvePlot<'_>) -> Vec<SideLabel> {
    if plot.curves.len() < 2 {
        return Vec::new();
    }
    let window = Window { heights_m: plot.heights_m, width: 1.0 };
    let two_lines = plot.curves.len() <= MOST_TWO_LINES;
    let mut labels: Vec<SideLabel> = plot
        .curves
        .iter()
        .enumerate()
        .take(MOST_LABELS)
        .map(|(index, curve)| {
            let detail = format!("{} at {} m", p_words(curve), number(curve.marked_m, 2));
            let words = std::iter::once(curve.label.to_string()).chain(two_lines.then_some(detail)).collect();
            let y = window.y(curve.p_los(plot.heights_m[1]));
            SideLabel::new(y, words, line_style(index).1)
        })
        .collect();
    labels.sort_by(|a, b| a.y.total_cmp(&b.y));
    labels
}

#[cfg(test)]
mod tests {
    use super::*;

    const CURVE: HeightCurveLine<'static> = HeightCurveLine {
        label: "UAV 1",
        lowest_m: 0.0,
        steps: &[(0.0, 0.1), (10.0, 0.25), (40.0, 0.5), (400.0, 1.0)],
        marked_m: 40.0,
    };

    fn plot<'a>(curves: &'a [HeightCurveLine<'a>]) -> HeightCurvePlot<'a> {
        let height_name = "UAV height above ground";
        HeightCurvePlot { title: "P_LoS against height", caption: &[], height_name, heights_m: [0.0, 100.0], curves }
    }

    fn svg(curves: &[HeightCurveLine<'_>]) -> String {
        draw_height_curve(&plot(curves)).expect("the curves are valid").furniture.svg
    }

    #[test]
    fn a_curve_is_drawn_as_steps_with_the_asked_height_marked() {
        let svg = svg(&[CURVE]);
        // 100 m are 1500 px, probability 1 is 760 px: 0.1 to 10 m, 0.25 to 40 m, 0.5 to the end.
        assert!(svg.contains("points=\"0,684 150,684 150,570 600,570 600,380 1500,380\""), "{svg}");
        for words in ["<circle cx=\"600\" cy=\"380\"", "UAV height above ground [m]", "= 0.5000", ">40 m<"] {
            assert!(svg.contains(words), "{words}: {svg}");
        }
    }

    #[test]
    fn a_curve_over_a_roof_begins_at_the_roof() {
        let window = Window { heights_m: [0.0, 100.0], width: 100.0 };
        let line = step_line(&HeightCurveLine { lowest_m: 25.0, ..CURVE }, &window);
        assert_eq!(line.first(), Some(&[25.0, 570.0]));
        assert!(step_line(&HeightCurveLine { lowest_m: 125.0, ..CURVE }, &window).is_empty());
    }

    #[test]
    fn many_fine_steps_become_few_points_without_losing_height() {
        let steps: Vec<(f64, f64)> = (0..100_000).map(|k| (f64::from(k) / 1000.0, f64::from(k) / 1e5)).collect();
        let window = Window { heights_m: [0.0, 100.0], width: 1000.0 };
        let line = step_line(&HeightCurveLine { steps: &steps, ..CURVE }, &window);
        assert!(line.len() < 4100, "{}", line.len());
        assert!(line.iter().all(|[x, y]| ((1.0 - y / HEIGHT) * 1000.0 - x).abs() < 0.6));
        assert!(line.windows(2).all(|w| w[0][0] <= w[1][0] && w[0][1] >= w[1][1]));
    }

    #[test]
    fn several_curves_have_different_looks_and_labels_of_bounded_number_and_width() {
        let looks: std::collections::HashSet<String> = (0..28).map(|k| line_style(k).1).collect();
        assert_eq!(looks.len(), 28);
        let many = svg(&[CURVE; 30]);
        assert!(many.contains(">+ 6 more<") && many.matches(">UAV 1<").count() == MOST_LABELS);
        let name = "n".repeat(10_000);
        let long = svg(&[HeightCurveLine { label: &name, ..CURVE }; 2]);
        assert!(long.contains("nnn…<") && !long.contains(&name));
    }

    #[test]
    fn what_cannot_be_drawn_is_refused() {
        assert!(draw_height_curve(&HeightCurvePlot { heights_m: [5.0, 5.0], ..plot(&[CURVE]) }).is_err());
        let falling = HeightCurveLine { steps: &[(0.0, 0.5), (1.0, 0.4)], ..CURVE };
        for bad in [falling, HeightCurveLine { marked_m: f64::NAN, ..CURVE }] {
            assert!(draw_height_curve(&plot(&[bad])).is_err_and(|e| e.contains("`UAV 1`")));
        }
    }
}
