//! P_LoS against the UAV's height: one curve of steps per UAV.

use super::check;
use super::colors::MUTED;
use super::furniture::{self, Block, DETAIL, stroke};
use super::lettering::number;
use super::line_look::COLORS;
use super::marks::Label;
use super::page::page;
use super::plot::{self, Axis, Direction, Span, Window};
use super::sheet::{Drawing, Sheet};
use super::side_labels::{self, LEADER, SideLabel};

const HEIGHT: f64 = 760.0;
const AXIS: f64 = 104.0;
/// Width of the plot and the labels at its right \[px\].
const WIDTH: f64 = 1500.0;

/// Number of colors that are used in turn.
const N_COLORS: usize = 7;
/// Line patterns, so that neighbors differ in more than color. With the colors they make 28
/// different lines.
const DASHES: [&str; 4] = ["", "18 7", "5 6", "20 6 5 6"];
/// Most labels beside the plot; further curves have none.
const MOST_LABELS: usize = 24;
/// Most requested heights with a line down to the axis; if there are more, none has one.
const MOST_ASKED_LINES: usize = 8;
/// Most labels with a second line; if there are more, none has one.
const MOST_TWO_LINES: usize = 12;

/// A plot of P_LoS against the UAV's height. Heights are above one base \[m\].
#[derive(Clone, Copy, Debug)]
pub struct HeightCurvePlot<'a> {
    /// Title.
    pub title: &'a str,
    /// Lines below; long ones are wrapped.
    pub caption: &'a [String],
    /// Name of the horizontal axis, such as `UAV height above ground`.
    pub height_name: &'a str,
    /// Ends of the horizontal axis \[m\].
    pub heights_m: [f64; 2],
    /// The curves, the first one drawn on top.
    pub curves: &'a [HeightCurveLine<'a>],
}

/// The curve of one UAV.
#[derive(Clone, Copy, Debug)]
pub struct HeightCurveLine<'a> {
    /// Name, such as `UAV 1`.
    pub label: &'a str,
    /// Lowest height that the UAV may have \[m\]; the curve begins there.
    pub lowest_m: f64,
    /// Steps: heights \[m\], ascending, with P_LoS from there up.
    pub steps: &'a [(f64, f64)],
    /// Requested height \[m\], marked on the curve.
    pub marked_m: f64,
}

impl HeightCurveLine<'_> {
    /// Returns P_LoS at a height \[m\].
    fn p_los(&self, height_m: f64) -> f64 {
        let above = self.steps.partition_point(|s| s.0 <= height_m);
        above.checked_sub(1).map_or(0.0, |last| self.steps[last].1)
    }

    /// Returns the place of the requested height on the curve \[px\].
    fn mark(&self, window: &Window) -> [f64; 2] {
        window.at(self.marked_m, self.p_los(self.marked_m))
    }
}

impl HeightCurvePlot<'_> {
    /// Returns `true` when a curve's requested height is on the axis.
    fn shows(&self, curve: &HeightCurveLine<'_>) -> bool {
        (self.heights_m[0]..=self.heights_m[1]).contains(&curve.marked_m)
    }

    /// Returns the curve that is drawn alone, if its requested height is on the axis.
    fn only(&self) -> Option<&HeightCurveLine<'_>> {
        self.curves.first().filter(|curve| self.curves.len() == 1 && self.shows(curve))
    }
}

/// Returns the mapping of heights and probabilities to a plot of a width \[px\].
fn window(plot: &HeightCurvePlot<'_>, width: f64) -> Window {
    let [low, high] = plot.heights_m;
    Window { size: [width, HEIGHT], x: Span::linear(low, high), y: Span::linear(0.0, 1.0) }
}

/// Draws P_LoS against height.
///
/// # Errors
/// Ends of the axis that are not finite or not ascending, or a curve with a value that is not
/// finite or not ascending.
pub fn draw_height_curve(plot: &HeightCurvePlot<'_>) -> Result<Sheet, String> {
    check(plot)?;
    let labels = side_labels(plot);
    let words = labels.iter().map(SideLabel::width).fold(0.0, f64::max);
    let side = if labels.is_empty() { 0.0 } else { (LEADER + words).ceil() };
    let window = window(plot, WIDTH - side);
    let [x, y] = axes(plot, &window);
    let mut framed = plot::framed(window.size, &x, &y, &curves(plot, &window));
    framed.add(&side_labels::beside(&labels, window.size));
    if plot.curves.len() > MOST_LABELS {
        let rest = format!("+ {} more", plot.curves.len() - MOST_LABELS);
        framed.text(window.size[0] + LEADER, HEIGHT + 32.0, DETAIL, &rest);
    }
    let mut drawing = Drawing::default();
    drawing.place(&framed, AXIS, 0.0);
    let body = Block { width: AXIS + WIDTH, height: HEIGHT + 92.0, drawing };
    Ok(page(plot.title, &body, plot.caption, [24.0, 0.0]))
}

fn check(plot: &HeightCurvePlot<'_>) -> Result<(), String> {
    check::ends(plot.height_name, plot.heights_m)?;
    let is_good = |curve: &HeightCurveLine<'_>| {
        let finite = |(height, p): &(f64, f64)| height.is_finite() && (0.0..=1.0).contains(p);
        [curve.lowest_m, curve.marked_m].iter().all(|h| h.is_finite())
            && curve.steps.iter().all(finite)
            && curve.steps.is_sorted_by(|a, b| a.0 < b.0 && a.1 <= b.1)
    };
    check::each(plot.curves, is_good, |curve| curve.label, "finite heights and steps that ascend")
}

fn axes(plot: &HeightCurvePlot<'_>, window: &Window) -> [Axis; 2] {
    let ([low, high], width) = (plot.heights_m, window.size[0]);
    let height_name = format!("{} [m]", plot.height_name);
    let x = window.x.axis_at(&height_name, Direction::Across, width, furniture::ticks(low, high, width / 150.0));
    let tenths = (0..=10).map(|tenth| f64::from(tenth) / 10.0).map(|p| (p, number(p, 1))).collect();
    let name = "P_LoS: share of receivers in line of sight";
    let y = window.y.axis_at(name, Direction::Up, HEIGHT, tenths);
    [x, Axis { name_at: 72.0, ..y }]
}

/// Returns color and stroke of the line with this index.
fn line_style(index: usize) -> (&'static str, String) {
    let (color, dash) = (COLORS[index % N_COLORS], DASHES[index % DASHES.len()]);
    (color, stroke(color, 4.5, dash))
}

fn curves(plot: &HeightCurvePlot<'_>, window: &Window) -> Drawing {
    let mut drawing = Drawing::default();
    asked_lines(&mut drawing, plot, window);
    // The first curve is drawn last, on top; all marks are over all curves.
    for (index, curve) in plot.curves.iter().enumerate().rev() {
        let (color, style) = line_style(index);
        let points = step_line(curve, window);
        let Some([x, y]) = points.first().copied() else { continue };
        drawing.polyline(&points, &style);
        if curve.lowest_m > plot.heights_m[0] {
            // The UAV cannot be lower: the line ends in a stop.
            drawing.line([x, y - 11.0], [x, (y + 11.0).min(HEIGHT)], &stroke(color, 4.5, ""));
        }
    }
    for (index, curve) in plot.curves.iter().enumerate().rev().filter(|(_, curve)| plot.shows(curve)) {
        let look = format!("fill=\"{}\" stroke=\"#FFFFFF\" stroke-width=\"3\"", line_style(index).0);
        drawing.circle(curve.mark(window), 10.0, &look);
    }
    if let Some(only) = plot.only() {
        mark_label(&mut drawing, only, window);
    }
    drawing
}

/// Draws a thin line from each requested height's mark down to the axis, and from a single mark to
/// its P_LoS.
fn asked_lines(drawing: &mut Drawing, plot: &HeightCurvePlot<'_>, window: &Window) {
    let dotted = format!("{} stroke-linecap=\"round\"", stroke(MUTED, 1.8, "2 6"));
    let mut marks: Vec<[f64; 2]> =
        plot.curves.iter().filter(|curve| plot.shows(curve)).map(|curve| curve.mark(window)).collect();
    // Only the highest of the marks at one height.
    marks.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    marks.dedup_by_key(|mark| mark[0]);
    if marks.len() <= MOST_ASKED_LINES {
        marks.iter().for_each(|[x, y]| drawing.line([*x, *y], [*x, HEIGHT], &dotted));
    }
    if let Some([x, y]) = plot.only().map(|curve| curve.mark(window)) {
        drawing.line([0.0, y], [x, y], &dotted);
    }
}

/// Draws the words at the mark of a single curve. A curve only rises, so the places below right and
/// above left of the mark are free.
fn mark_label(drawing: &mut Drawing, curve: &HeightCurveLine<'_>, window: &Window) {
    let ([x, y], [width, height]) = (curve.mark(window), window.size);
    let asked = format!("{} m", number(curve.marked_m, 2));
    let label = Label::new(&[asked, format!("P_LoS = {}", p_words(curve))], 24.0);
    let (right, below) = (x + 24.0, y + 26.0);
    if right + label.width < width - 8.0 && below + label.height < height - 8.0 {
        return label.draw(drawing, right, below);
    }
    // At the left border the label reaches to the right of the mark, where it must clear the curve,
    // too.
    let left = (x - 24.0 - label.width).max(8.0);
    let [low, high] = window.x.ends;
    let height_at = |x: f64| low + x / width * (high - low);
    let [_, beside] = window.at(low, curve.p_los(height_at(left + label.width)));
    label.draw(drawing, left, (y.min(beside) - 26.0 - label.height).max(8.0));
}

fn p_words(curve: &HeightCurveLine<'_>) -> String {
    format!("{:.4}", curve.p_los(curve.marked_m))
}

/// Returns the steps in the window as one line. Steps that share half a pixel are merged, which is
/// invisible.
fn step_line(curve: &HeightCurveLine<'_>, window: &Window) -> Vec<[f64; 2]> {
    const FINEST: f64 = 0.5;
    let [low, high] = window.x.ends;
    let start = curve.lowest_m.max(low);
    if start > high {
        return Vec::new();
    }
    let mut last = window.at(start, curve.p_los(start));
    let mut line = vec![last];
    for &(height, p_los) in curve.steps.iter().filter(|s| s.0 > start && s.0 <= high) {
        let [x, y] = window.at(height, p_los);
        match line[..] {
            // The last two points are a riser, and this step belongs to it.
            [.., [riser, _], [to, _]] if (to - riser).abs() < 1e-9 && x - riser < FINEST => {
                line.pop();
                last = [to, y];
            }
            _ => {
                line.push([x, last[1]]);
                last = [x, y];
            }
        }
        line.push(last);
    }
    line.push([window.at(high, 0.0)[0], last[1]]);
    line
}

/// Returns the labels of several curves; a single curve needs none.
fn side_labels(plot: &HeightCurvePlot<'_>) -> Vec<SideLabel> {
    if plot.curves.len() < 2 {
        return Vec::new();
    }
    let window = window(plot, 1.0);
    let two_lines = plot.curves.len() <= MOST_TWO_LINES;
    let mut labels: Vec<SideLabel> = plot
        .curves
        .iter()
        .enumerate()
        .take(MOST_LABELS)
        .map(|(index, curve)| {
            let detail = format!("{} at {} m", p_words(curve), number(curve.marked_m, 2));
            let words = std::iter::once(curve.label.to_string()).chain(two_lines.then_some(detail)).collect();
            let [_, y] = window.at(plot.heights_m[1], curve.p_los(plot.heights_m[1]));
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
        let window = window(&plot(&[]), 100.0);
        let line = step_line(&HeightCurveLine { lowest_m: 25.0, ..CURVE }, &window);
        assert_eq!(line.first(), Some(&[25.0, 570.0]));
        assert!(step_line(&HeightCurveLine { lowest_m: 125.0, ..CURVE }, &window).is_empty());
    }

    #[test]
    fn many_fine_steps_become_few_points_without_losing_height() {
        let steps: Vec<(f64, f64)> = (0..100_000).map(|k| (f64::from(k) / 1000.0, f64::from(k) / 1e5)).collect();
        let window = window(&plot(&[]), 1000.0);
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
}
