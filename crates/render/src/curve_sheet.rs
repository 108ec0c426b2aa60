//! Curves with confidence bands, estimates with error bars and models over them, in one plot or in small multiples.

use super::curve_lines::{self, CurveLine, CurvePoint, Window};
use super::legend;
use super::line_look::LineStyle;
use super::page::page;
use super::panel_grid::{self, Panel};
use super::plot_axis::{Direction, Span};
use super::sheet::Sheet;

/// Most labels in a legend, and most lines in a panel.
const MOST_LINES: usize = 24;

/// Plots of curves with one legend for all.
#[derive(Clone, Copy, Debug)]
pub struct CurveSheet<'a> {
    /// Title; may be empty.
    pub title: &'a str,
    /// Lines below; long ones are wrapped.
    pub caption: &'a [String],
    /// One to twelve plots, row by row.
    pub panels: &'a [CurvePanel<'a>],
    /// Plots beside each other.
    pub columns: usize,
}

/// One plot.
#[derive(Clone, Copy, Debug)]
pub struct CurvePanel<'a> {
    /// What stands over it, such as `(a) Urban`; may be empty.
    pub title: &'a str,
    /// Name of the horizontal axis with its unit, such as `Elevation angle θ [°]`. With a degree sign and an end at a
    /// multiple of 90, ticks are multiples of 10, 15, 30, 45 or 90.
    pub x_name: &'a str,
    /// Ends of the horizontal axis, ascending; what lies beyond is cut off.
    pub x_ends: [f64; 2],
    /// Name of the vertical axis with its unit, such as `P_LoS`.
    pub y_name: &'a str,
    /// Ends of the vertical axis, ascending; what lies beyond is cut off.
    pub y_ends: [f64; 2],
    /// Up to 24 lines, the first one on top.
    pub lines: &'a [CurveLine<'a>],
}

/// Width and height of the frames \[px\]. Words have one size: the more plots, the wider the sheet is meant to be.
fn frame_size(columns: usize) -> [f64; 2] {
    match columns {
        1 => [760.0, 560.0],
        2 => [580.0, 440.0],
        _ => [480.0, 370.0],
    }
}

/// Draws curves.
///
/// # Errors
/// No panel or more than twelve, no column, more than 24 lines in a panel or labels in the legend, one label with two
/// looks, ends of an axis that are not finite or not ascending, or a point that is not finite or not in ascending
/// order.
pub fn draw_curve_sheet(sheet: &CurveSheet<'_>) -> Result<Sheet, String> {
    panel_grid::check(sheet.panels.len(), sheet.columns)?;
    for panel in sheet.panels {
        check(panel)?;
    }
    let entries = legend::entries(sheet.panels.iter().flat_map(|panel| panel.lines))?;
    if entries.len() > MOST_LINES {
        return Err(format!("cannot draw a legend of {} lines: there may be up to {MOST_LINES}", entries.len()));
    }
    let size = frame_size(sheet.columns.min(sheet.panels.len()));
    let style = |line: &CurveLine<'_>| {
        let entry = entries.iter().find(|entry| entry.label() == line.label);
        entry.map_or_else(|| LineStyle::new(line.look, line.color_index), |entry| entry.style)
    };
    let panels = sheet.panels.iter().map(|panel| {
        let span = |ends| Span { ends, is_log: false };
        let window = Window { size, x: span(panel.x_ends), y: span(panel.y_ends) };
        let styles: Vec<LineStyle> = panel.lines.iter().map(style).collect();
        Panel {
            title: panel.title,
            x: window.x.axis(panel.x_name, Direction::Across, size[0]),
            y: window.y.axis(panel.y_name, Direction::Up, size[1]),
            content: curve_lines::lines(panel.lines, &styles, &window),
        }
    });
    let body = legend::with_legend(panel_grid::grid(panels.collect(), sheet.columns, size), &entries);
    Ok(page(sheet.title, &body, sheet.caption, [22.0, 22.0]))
}

fn check(panel: &CurvePanel<'_>) -> Result<(), String> {
    for (name, [low, high]) in [(panel.x_name, panel.x_ends), (panel.y_name, panel.y_ends)] {
        if !(low.is_finite() && high.is_finite() && low < high && (high - low).is_finite()) {
            return Err(format!("cannot draw `{name}` from {low} to {high}: the ends must be finite and ascend"));
        }
    }
    if panel.lines.len() > MOST_LINES {
        return Err(format!("cannot draw {} lines in one panel: there may be up to {MOST_LINES}", panel.lines.len()));
    }
    panel.lines.iter().try_for_each(|line| {
        let bad = |what: &str| Err(format!("cannot draw the line `{}`: {what}", line.label));
        if !line.points.iter().all(is_finite) {
            return bad("its points must be finite");
        }
        if !line.points.iter().all(|p| p.low_high.is_none_or(|(low, high)| low <= high)) {
            return bad("the ends of its intervals must ascend");
        }
        if !line.points.windows(2).all(|pair| pair[0].x <= pair[1].x) {
            return bad("its abscissas must not descend");
        }
        Ok(())
    })
}

fn is_finite(point: &CurvePoint) -> bool {
    let (low, high) = point.low_high.unwrap_or_default();
    [point.x, point.y.unwrap_or_default(), low, high].iter().all(|v| v.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::line_look::LineLook;

    const POINTS: [CurvePoint; 2] = [
        CurvePoint { x: 5.0, y: Some(0.2), low_high: Some((0.1, 0.3)) },
        CurvePoint { x: 90.0, y: Some(1.0), low_high: Some((0.9, 1.0)) },
    ];

    fn line<'a>(label: &'a str, points: &'a [CurvePoint]) -> CurveLine<'a> {
        CurveLine { label, color_index: 0, look: LineLook::Solid, points, through: &[] }
    }

    fn panel<'a>(lines: &'a [CurveLine<'a>]) -> CurvePanel<'a> {
        let x_name = "Elevation angle θ [°]";
        CurvePanel { title: "(a) Urban", x_name, x_ends: [0.0, 90.0], y_name: "P_LoS", y_ends: [0.0, 1.0], lines }
    }

    fn svg(panels: &[CurvePanel<'_>], columns: usize) -> Result<String, String> {
        let sheet = CurveSheet { title: "P_LoS < 1 & more", caption: &[], panels, columns };
        draw_curve_sheet(&sheet).map(|sheet| sheet.furniture.svg)
    }

    #[test]
    fn panels_have_their_words_and_one_legend() {
        let lines = [line("Exact", &POINTS), line("City", &POINTS)];
        let svg = svg(&[panel(&lines), panel(&lines[..1])], 3).expect("the sheet is valid");
        for (words, n) in [(">Exact<", 1), (">City<", 1), ("θ [°]", 2), (">(a) Urban<", 2), ("&lt; 1 &amp; more", 1)]
        {
            assert_eq!(svg.matches(words).count(), n, "{words}: {svg}");
        }
    }

    #[test]
    fn what_cannot_be_drawn_is_refused_and_beyond_an_axis_is_cut_off() {
        let [first, last] = POINTS;
        let drawn = |points: &[CurvePoint]| svg(&[panel(&[line("a", points)])], 1);
        for (points, words) in [
            ([last, first], "must not descend"),
            ([first, CurvePoint { y: Some(f64::NAN), ..last }], "`a`"),
            ([first, CurvePoint { low_high: Some((0.5, 0.4)), ..last }], "must ascend"),
        ] {
            assert!(drawn(&points).is_err_and(|e| e.contains(words)), "{words}");
        }
        assert!(drawn(&[first, CurvePoint { x: 200.0, y: Some(3.0), low_high: None }]).is_ok());
        let flat = CurvePanel { y_ends: [1.0, 1.0], ..panel(&[]) };
        assert!(svg(&[flat], 1).is_err_and(|e| e.contains("`P_LoS` from 1 to 1")));
        assert!(svg(&[panel(&[line("", &POINTS); 25])], 1).is_err_and(|e| e.contains("up to 24")));
    }
}
