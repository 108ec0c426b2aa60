//! Curves with confidence bands, estimates with error bars and models over them, in one plot or in
//! small multiples.

use super::check;
use super::curve_lines::{self, CurveLine, CurvePoint};
use super::legend;
use super::page::page;
use super::panel_grid::{self, Panel};
use super::plot::{Direction, Span, Window};
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
    /// Plots, one to twelve, row by row.
    pub panels: &'a [CurvePanel<'a>],
    /// Number of plots in a row.
    pub columns: usize,
}

/// One plot.
#[derive(Clone, Copy, Debug)]
pub struct CurvePanel<'a> {
    /// Heading, such as `(a) Urban`; may be empty.
    pub title: &'a str,
    /// Name of the horizontal axis with its unit, such as `Elevation angle θ [°]`. With a degree
    /// sign and an upper end at a multiple of 90, ticks are multiples of 10, 15, 30, 45 or 90.
    pub x_name: &'a str,
    /// Ends of the horizontal axis, ascending; lines are cut off there.
    pub x_ends: [f64; 2],
    /// Name of the vertical axis with its unit, such as `P_LoS`.
    pub y_name: &'a str,
    /// Ends of the vertical axis, ascending; lines are cut off there.
    pub y_ends: [f64; 2],
    /// Lines, up to 24, the first one on top.
    pub lines: &'a [CurveLine<'a>],
}

/// Returns width and height of the frames \[px\]. Words have one size, so a sheet of more plots is
/// meant to be wider.
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
/// * No panel or more than twelve, or no column.
/// * More than 24 lines in a panel, or labels in the legend.
/// * One label with two looks.
/// * Ends of an axis or points that are not finite or do not ascend.
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
    let panels = sheet.panels.iter().map(|panel| {
        let [x, y] = [panel.x_ends, panel.y_ends].map(|[low, high]| Span::linear(low, high));
        let window = Window { size, x, y };
        Panel {
            title: panel.title,
            x: window.x.axis(panel.x_name, Direction::Across, size[0]),
            y: window.y.axis(panel.y_name, Direction::Up, size[1]),
            content: curve_lines::lines(panel.lines, &window),
        }
    });
    let body = legend::with_legend(panel_grid::grid(panels.collect(), sheet.columns, size), &entries);
    Ok(page(sheet.title, &body, sheet.caption, [22.0, 22.0]))
}

fn check(panel: &CurvePanel<'_>) -> Result<(), String> {
    check::ends(panel.x_name, panel.x_ends)?;
    check::ends(panel.y_name, panel.y_ends)?;
    if panel.lines.len() > MOST_LINES {
        return Err(format!("cannot draw {} lines in one panel: there may be up to {MOST_LINES}", panel.lines.len()));
    }
    let is_good = |point: &CurvePoint| {
        let (low, high) = point.low_high.unwrap_or_default();
        low <= high && [point.x, point.y.unwrap_or_default(), low, high].iter().all(|v| v.is_finite())
    };
    let are_good = |line: &CurveLine<'_>| line.points.iter().all(is_good) && line.points.is_sorted_by_key(|p| p.x);
    check::each(panel.lines, are_good, |line| line.label, "finite points in ascending order with ascending intervals")
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

    fn draw(panel: CurvePanel<'_>) -> Result<Sheet, String> {
        draw_curve_sheet(&CurveSheet { title: "", caption: &[], panels: &[panel], columns: 1 })
    }

    #[test]
    fn what_cannot_be_drawn_is_refused_and_beyond_an_axis_is_cut_off() {
        let [first, last] = POINTS;
        let drawn = |points: &[CurvePoint]| draw(panel(&[line("a", points)]));
        for points in [
            [last, first],
            [first, CurvePoint { y: Some(f64::NAN), ..last }],
            [first, CurvePoint { low_high: Some((0.5, 0.4)), ..last }],
        ] {
            assert!(drawn(&points).is_err_and(|e| e.contains("`a`")), "{points:?}");
        }
        assert!(drawn(&[first, CurvePoint { x: 200.0, y: Some(3.0), low_high: None }]).is_ok());
        assert!(draw(CurvePanel { y_ends: [1.0, 1.0], ..panel(&[]) }).is_err());
        assert!(draw(panel(&[line("", &POINTS); 25])).is_err_and(|e| e.contains("up to 24")));
    }
}
