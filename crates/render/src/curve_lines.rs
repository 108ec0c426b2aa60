//! The lines of a panel of curves: bands, strokes, error bars and markers, cut off at the frame.

use super::line_look::{LineLook, LineStyle, MARKER};
use super::plot::{SLACK, Window};
use super::sheet::Drawing;

/// Least distance between markers of a solid line along the horizontal axis \[px\].
const MARKER_STEP: f64 = 26.0;

/// A line of a plot. Lines with the same label in several panels share one entry of the legend.
#[derive(Clone, Copy, Debug)]
pub struct CurveLine<'a> {
    /// Name; an empty one is not in the legend.
    pub label: &'a str,
    /// Index of color, marker and pattern; 8 colors, 6 shapes and 19 patterns are used in turn.
    pub color_index: usize,
    /// Look of the line.
    pub look: LineLook,
    /// Points; abscissas do not descend.
    pub points: &'a [CurvePoint],
    /// Denser points for the stroke and the band; if empty, these use `points`. Markers always stay
    /// at `points`.
    pub through: &'a [CurvePoint],
}

/// A point of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurvePoint {
    /// Abscissa, in the unit of the horizontal axis.
    pub x: f64,
    /// Ordinate, in the unit of the vertical axis; `None` is a gap in the line.
    pub y: Option<f64>,
    /// Ends of the interval, ascending.
    pub low_high: Option<(f64, f64)>,
}

impl CurveLine<'_> {
    /// Returns the style of the line.
    pub(crate) fn style(&self) -> LineStyle {
        LineStyle::new(self.look, self.color_index)
    }

    /// Returns the points that the stroke goes through.
    fn stroked(&self) -> &[CurvePoint] {
        if self.through.is_empty() { self.points } else { self.through }
    }
}

/// Draws lines, the first of them on top. Bands lie behind strokes, and strokes behind looks
/// without one.
pub(crate) fn lines(lines: &[CurveLine<'_>], window: &Window) -> Drawing {
    let mut drawing = Drawing::default();
    let styled = lines.iter().rev().map(|line| (line, line.style()));
    let (joined, mut apart): (Vec<_>, Vec<_>) = styled.partition(|(_, style)| style.has_line());
    for (line, style) in &joined {
        bands(&mut drawing, line, style, window);
    }
    for (line, style) in &joined {
        strokes(&mut drawing, line, style, window);
        if style.has_markers() {
            markers(&mut drawing, line, style, window);
        }
    }
    // Estimates, and measurements over them.
    apart.sort_by_key(|(line, _)| line.look == LineLook::Points);
    for (line, style) in &apart {
        markers(&mut drawing, line, style, window);
    }
    drawing
}

fn bands(drawing: &mut Drawing, line: &CurveLine<'_>, style: &LineStyle, window: &Window) {
    for run in runs(line.stroked(), |p| p.y.and(p.low_high)) {
        let upper = run.iter().map(|(x, (_, high))| window.at(*x, *high));
        let lower = run.iter().rev().map(|(x, (low, _))| window.at(*x, *low));
        let area = clip_area(upper.chain(lower).collect(), window.size);
        if area.len() > 2 {
            drawing.polygon(&area, &style.band());
        }
    }
}

fn strokes(drawing: &mut Drawing, line: &CurveLine<'_>, style: &LineStyle, window: &Window) {
    for run in runs(line.stroked(), |p| p.y) {
        let points: Vec<[f64; 2]> = run.iter().map(|(x, y)| window.at(*x, *y)).collect();
        match points[..] {
            // A point between two gaps has nothing to join.
            [at] if window.shows(at) && !style.has_markers() => {
                drawing.circle(at, 3.0, &format!("fill=\"{}\"", style.color));
            }
            _ => {
                let pieces = clip_line(&points, window.size);
                pieces.iter().for_each(|piece| drawing.polyline(piece, &style.stroke()));
            }
        }
    }
}

/// Draws the markers of a line; looks without a stroke have error bars, too. Markers too close to
/// the last one are left out, unless the look shows all.
fn markers(drawing: &mut Drawing, line: &CurveLine<'_>, style: &LineStyle, window: &Window) {
    let mut last = [f64::NEG_INFINITY; 2];
    for (point, y) in line.points.iter().filter_map(|p| p.y.map(|y| (p, y))) {
        if !style.has_line() {
            error_bar(drawing, point, style, window);
        }
        let at = window.at(point.x, y);
        let [dx, dy] = [at[0] - last[0], at[1] - last[1]];
        let is_apart = match line.look {
            LineLook::Solid | LineLook::Dashed => dx >= MARKER_STEP,
            LineLook::Points => dx.hypot(dy) >= 1.5 * MARKER,
            LineLook::Markers => true,
        };
        if window.shows(at) && is_apart {
            style.draw_marker(drawing, at);
            last = at;
        }
    }
}

/// Draws the interval of a point; an end outside the frame has no cap.
fn error_bar(drawing: &mut Drawing, point: &CurvePoint, style: &LineStyle, window: &Window) {
    let Some((low, high)) = point.low_high else { return };
    let ends = [window.at(point.x, low), window.at(point.x, high)];
    let [x, _] = ends[0];
    let (top, bottom) = (-SLACK, window.size[1] + SLACK);
    if x < -SLACK || x > window.size[0] + SLACK || ends[1][1] > bottom || ends[0][1] < top {
        return;
    }
    let capped = ends.map(|[_, y]| (top..=bottom).contains(&y));
    style.draw_error_bar(drawing, x, ends.map(|[_, y]| y.clamp(0.0, window.size[1])), capped);
}

/// Returns the stretches of points without a gap, each point with its abscissa.
fn runs<T: Copy>(points: &[CurvePoint], value: impl Fn(&CurvePoint) -> Option<T>) -> Vec<Vec<(f64, T)>> {
    let values: Vec<Option<(f64, T)>> = points.iter().map(|point| Some((point.x, value(point)?))).collect();
    let runs = values.split(Option::is_none).map(|run| run.iter().flatten().copied().collect::<Vec<_>>());
    runs.filter(|run| !run.is_empty()).collect()
}

/// Clips an open path to a plot of this size, and returns its pieces (Liang & Barsky 1984, for each
/// segment).
fn clip_line(points: &[[f64; 2]], size: [f64; 2]) -> Vec<Vec<[f64; 2]>> {
    let mut pieces: Vec<Vec<[f64; 2]>> = Vec::new();
    let mut goes_on = false;
    for pair in points.windows(2) {
        let (from, to) = (pair[0], pair[1]);
        let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
        for k in 0..2 {
            let step = to[k] - from[k];
            for (room, towards) in [(from[k], -step), (size[k] - from[k], step)] {
                // Inside while t · towards <= room.
                if towards > 0.0 {
                    leave = leave.min(room / towards);
                } else if towards < 0.0 {
                    enter = enter.max(room / towards);
                } else if room < 0.0 {
                    leave = -1.0;
                }
            }
        }
        if enter > leave {
            goes_on = false;
            continue;
        }
        let along = |t: f64| [0, 1].map(|k| from[k] + t * (to[k] - from[k]));
        let end = if leave < 1.0 { along(leave) } else { to };
        match pieces.last_mut().filter(|_| goes_on && enter <= 0.0) {
            Some(piece) => piece.push(end),
            None => pieces.push(vec![if enter > 0.0 { along(enter) } else { from }, end]),
        }
        goes_on = leave >= 1.0;
    }
    pieces
}

/// Clips an area to a plot of this size (Sutherland & Hodgman 1974).
fn clip_area(mut area: Vec<[f64; 2]>, size: [f64; 2]) -> Vec<[f64; 2]> {
    for (k, border, sign) in [(0, 0.0, 1.0), (0, size[0], -1.0), (1, 0.0, 1.0), (1, size[1], -1.0)] {
        let depth = |p: &[f64; 2]| (p[k] - border) * sign;
        let mut cut = Vec::with_capacity(area.len() + 4);
        for (i, to) in area.iter().enumerate() {
            let from = area[(i + area.len() - 1) % area.len()];
            let (before, after) = (depth(&from), depth(to));
            if (before < 0.0) != (after < 0.0) {
                let t = before / (before - after);
                cut.push([0, 1].map(|c| from[c] + t * (to[c] - from[c])));
            }
            if after >= 0.0 {
                cut.push(*to);
            }
        }
        area = cut;
    }
    area
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::Span;

    fn window() -> Window {
        Window { size: [100.0, 100.0], x: Span::linear(0.0, 10.0), y: Span::linear(0.0, 1.0) }
    }

    fn point(x: f64, y: f64) -> CurvePoint {
        CurvePoint { x, y: Some(y), low_high: None }
    }

    fn draw(look: LineLook, points: &[CurvePoint]) -> String {
        let line = CurveLine { label: "a", color_index: 0, look, points, through: &[] };
        lines(&[line], &window()).svg
    }

    #[test]
    fn a_gap_splits_a_line() {
        let gap = CurvePoint { x: 4.0, y: None, low_high: None };
        let points = [point(0.0, 0.5), point(2.0, 0.5), gap, point(6.0, 0.5), point(10.0, 1.0)];
        let svg = draw(LineLook::Dashed, &points);
        assert_eq!(svg.matches("<polyline").count(), 2, "{svg}");
        assert!(svg.contains("points=\"0,50 20,50\"") && svg.contains("points=\"60,50 100,0\""), "{svg}");
        // A point between gaps is a dot, unless it has a marker.
        let svg = draw(LineLook::Dashed, &[gap, point(5.0, 0.5), CurvePoint { x: 6.0, ..gap }]);
        assert!(svg.contains("<circle") && !svg.contains("<polyline"), "{svg}");
    }

    #[test]
    fn what_leaves_the_frame_is_cut_off_there() {
        let path = [[-50.0, 50.0], [50.0, 50.0], [50.0, 150.0], [70.0, 150.0], [70.0, 50.0], [170.0, 50.0]];
        let pieces = clip_line(&path, [100.0, 100.0]);
        let first = vec![[0.0, 50.0], [50.0, 50.0], [50.0, 100.0]];
        assert_eq!(pieces, [first, vec![[70.0, 100.0], [70.0, 50.0], [100.0, 50.0]]]);
        assert!(clip_line(&[[-5.0, -1.0], [105.0, -1.0]], [100.0, 100.0]).is_empty());
        // A line along the frame is inside.
        assert_eq!(clip_line(&[[0.0, 0.0], [100.0, 0.0]], [100.0, 100.0]).len(), 1);
        let square = vec![[-10.0, -10.0], [50.0, -10.0], [50.0, 50.0], [-10.0, 50.0]];
        let area = clip_area(square, [100.0, 100.0]);
        assert!(area.iter().all(|p| p.iter().all(|c| (0.0..=50.0).contains(c))) && area.len() == 4, "{area:?}");
        assert!(clip_area(vec![[-9.0, 0.0], [-1.0, 0.0], [-5.0, 9.0]], [100.0, 100.0]).is_empty());
    }

    #[test]
    fn filled_markers_keep_apart_and_estimates_have_all() {
        let points: Vec<CurvePoint> = (0..=100).map(|k| point(f64::from(k) / 10.0, 0.5)).collect();
        for (look, n) in [(LineLook::Points, 9), (LineLook::Solid, 4), (LineLook::Markers, 101)] {
            assert_eq!(draw(look, &points).matches("<circle").count(), n, "{look:?}");
        }
    }
}
