//! Curves with confidence bands, estimates with error bars and models over them, in one plot or in small multiples.

use super::curve_lines::{self, Window};
use super::legend;
use super::line_look::{LineLook, LineStyle};
use super::panel_grid::{self, Panel};
use super::picture_form::PictureForm;
use super::plot_axis::{Direction, Span};
use super::plot_frame;
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
    /// Horizontal axis.
    pub x: CurveAxis<'a>,
    /// Name of the vertical axis with its unit, such as `P_LoS`.
    pub y_name: &'a str,
    /// Ends of the vertical axis, ascending; what lies beyond is cut off.
    pub y_ends: [f64; 2],
    /// Up to 24 lines, the first one on top.
    pub lines: &'a [CurveLine<'a>],
}

/// The horizontal axis of a plot.
#[derive(Clone, Copy, Debug)]
pub struct CurveAxis<'a> {
    /// Name with unit, such as `Elevation angle θ [°]`. With a degree sign and an end at a multiple of 90, ticks are
    /// multiples of 10, 15, 30, 45 or 90.
    pub name: &'a str,
    /// Ends, ascending; what lies beyond is cut off.
    pub ends: [f64; 2],
    /// Whether the axis is logarithmic; then its ends and all abscissas are above 0.
    pub is_log: bool,
}

/// A line of a plot. Lines with the same label in several panels share one entry of the legend.
#[derive(Clone, Copy, Debug)]
pub struct CurveLine<'a> {
    /// What it is called; an empty label is not in the legend.
    pub label: &'a str,
    /// What is said below the label in smaller type.
    pub detail: Option<&'a str>,
    /// Which color, marker and pattern; 8 colors, 6 shapes and 19 patterns are used in turn.
    pub color_index: usize,
    /// How it is drawn.
    pub look: LineLook,
    /// Its points; abscissas do not descend.
    pub points: &'a [CurvePoint],
    /// What the stroke and the band go through instead, where more is known of them than at the points, which keep the markers.
    pub through: &'a [CurvePoint],
}

/// A point of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurvePoint {
    /// Abscissa, in the unit of the horizontal axis.
    pub x: f64,
    /// Ordinate, in the unit of the vertical axis; nothing is a gap in the line.
    pub y: Option<f64>,
    /// Ends of its interval, ascending.
    pub low_high: Option<(f64, f64)>,
}

/// Draws curves.
///
/// # Errors
/// No panel or more than twelve, no column, more than 24 lines in a panel or labels in the legend, one label with two
/// looks, ends of an axis that are not finite or not ascending, a point that is not finite or not in ascending order,
/// or a keyword of `provenance` that PNG does not allow.
pub fn draw_curve_sheet(
    sheet: &CurveSheet<'_>,
    form: &PictureForm,
    provenance: &[(String, String)],
) -> Result<Vec<u8>, String> {
    compose(sheet)?.write(form, provenance)
}

/// Width and height of the frames \[px\]. Words have one size: the more plots, the wider the sheet is meant to be.
fn frame_size(columns: usize) -> [f64; 2] {
    match columns {
        1 => [760.0, 560.0],
        2 => [580.0, 440.0],
        _ => [480.0, 370.0],
    }
}

fn compose(sheet: &CurveSheet<'_>) -> Result<Sheet, String> {
    panel_grid::check(sheet.panels.len(), sheet.columns)?;
    for panel in sheet.panels {
        check(panel)?;
    }
    let entries = legend::entries(sheet.panels)?;
    if entries.len() > MOST_LINES {
        return Err(format!("cannot draw a legend of {} lines: there may be up to {MOST_LINES}", entries.len()));
    }
    let size = frame_size(sheet.columns.min(sheet.panels.len()));
    let style = |line: &CurveLine<'_>| {
        let entry = entries.iter().find(|entry| entry.label() == line.label);
        entry.map_or_else(|| LineStyle::new(line.look, line.color_index), |entry| entry.style)
    };
    let panels = sheet.panels.iter().map(|panel| {
        let CurveAxis { name, ends, is_log } = panel.x;
        let window = Window { size, x: Span { ends, is_log }, y: Span { ends: panel.y_ends, is_log: false } };
        let styles: Vec<LineStyle> = panel.lines.iter().map(style).collect();
        Panel {
            title: panel.title,
            x: window.x.axis(name, Direction::Across, size[0]),
            y: window.y.axis(panel.y_name, Direction::Up, size[1]),
            content: curve_lines::lines(panel.lines, &styles, &window),
        }
    });
    let mut body = legend::with_legend(panel_grid::grid(panels.collect(), sheet.columns, size), &entries);
    body.height += if sheet.caption.is_empty() { 0.0 } else { 22.0 };
    Ok(plot_frame::page(sheet.title, 22.0, &body, sheet.caption))
}

fn check(panel: &CurvePanel<'_>) -> Result<(), String> {
    for (name, [low, high]) in [(panel.x.name, panel.x.ends), (panel.y_name, panel.y_ends)] {
        if !(low.is_finite() && high.is_finite() && low < high && (high - low).is_finite()) {
            return Err(format!("cannot draw `{name}` from {low} to {high}: the ends must be finite and ascend"));
        }
    }
    if panel.x.is_log && panel.x.ends[0] <= 0.0 {
        let (name, low) = (panel.x.name, panel.x.ends[0]);
        return Err(format!("cannot draw `{name}` from {low} on a logarithmic axis: it must be above 0"));
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
        if panel.x.is_log && line.points.iter().any(|p| p.x <= 0.0) {
            return bad("on a logarithmic axis its abscissas must be above 0");
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
    use crate::text;

    const X: CurveAxis<'static> = CurveAxis { name: "Elevation angle θ [°]", ends: [0.0, 90.0], is_log: false };

    fn point(x: f64, y: f64) -> CurvePoint {
        CurvePoint { x, y: Some(y), low_high: Some((y - 0.1, y + 0.1)) }
    }

    fn line<'a>(label: &'a str, look: LineLook, points: &'a [CurvePoint]) -> CurveLine<'a> {
        CurveLine { label, detail: None, color_index: 0, look, points, through: &[] }
    }

    fn panel<'a>(lines: &'a [CurveLine<'a>]) -> CurvePanel<'a> {
        CurvePanel { title: "(a) Urban", x: X, y_name: "P_LoS", y_ends: [0.0, 1.0], lines }
    }

    fn sheet<'a>(panels: &'a [CurvePanel<'a>]) -> CurveSheet<'a> {
        CurveSheet { title: "P_LoS < 1 & more", caption: &[], panels, columns: 3 }
    }

    fn svg(panels: &[CurvePanel<'_>]) -> Result<String, String> {
        text(draw_curve_sheet(&sheet(panels), &PictureForm::SVG, &[]))
    }

    #[test]
    fn a_sheet_says_what_it_shows() {
        let points = [point(5.0, 0.2), point(90.0, 1.0)];
        let model = CurveLine { detail: Some("ITU-R P.1410-6"), ..line("ITU", LineLook::Dashed, &points) };
        let lines = [line("Exact", LineLook::Solid, &points), line("City", LineLook::Markers, &points), model];
        let panels = [panel(&lines), panel(&lines[..2])];
        let svg = svg(&panels).expect("the sheet is valid");
        for words in
            [">Exact<", ">City<", ">ITU<", ">ITU-R P.1410-6<", "θ [°]", ">(a) Urban<", ">90<", "&lt; 1 &amp; more"]
        {
            assert!(svg.contains(words), "{words}: {svg}");
        }
        assert_eq!(svg.matches(">Exact<").count(), 1, "one legend for both panels");
        let images =
            [(); 2].map(|()| draw_curve_sheet(&sheet(&panels), &PictureForm::PNG, &[]).expect("the sheet is valid"));
        assert!(images[0] == images[1], "the same input gives the same bytes");
    }

    #[test]
    fn a_sheet_holds_everything_it_draws() {
        let points = [point(5.0, 0.2), point(90.0, 1.0)];
        let labels: Vec<String> = (0..24).map(|k| format!("line {k}")).collect();
        let lines: Vec<CurveLine<'_>> = labels.iter().map(|label| line(label, LineLook::Dashed, &points)).collect();
        for (n_panels, columns, n_lines) in [(1, 1, 0), (1, 1, 5), (1, 4, 24), (5, 3, 8), (12, 4, 24), (12, 1, 3)] {
            let panels = vec![panel(&lines[..n_lines]); n_panels];
            let sheet = compose(&CurveSheet { columns, ..sheet(&panels) }).expect("the sheet is valid");
            let columns = columns.min(n_panels);
            let [width, height] = frame_size(columns);
            let n_rows = n_panels.div_ceil(columns) as f64;
            assert!(sheet.width > columns as f64 * width + 2.0 * plot_frame::MARGIN);
            assert!(sheet.height > n_rows * height + 2.0 * plot_frame::MARGIN);
            assert!(sheet.width < 2800.0 && sheet.height < 9000.0, "{} {}", sheet.width, sheet.height);
        }
    }

    #[test]
    fn impossible_sheets_are_refused() {
        let refused = |panel: CurvePanel<'_>, words: &str| {
            let error = svg(&[panel]).expect_err("the panel is impossible");
            assert!(error.contains(words), "{error}");
        };
        let points = [point(5.0, 0.2), point(4.0, 1.0)];
        refused(panel(&[line("a", LineLook::Solid, &points)]), "must not descend");
        let points = [CurvePoint { x: 1.0, y: Some(f64::NAN), low_high: None }];
        refused(panel(&[line("a", LineLook::Solid, &points)]), "`a`");
        let points = [CurvePoint { low_high: Some((0.5, 0.4)), ..point(1.0, 0.5) }];
        refused(panel(&[line("a", LineLook::Solid, &points)]), "must ascend");
        let points = [point(0.0, 0.5)];
        let log = CurveAxis { is_log: true, ends: [1.0, 9.0], ..X };
        refused(CurvePanel { x: log, ..panel(&[line("a", LineLook::Solid, &points)]) }, "above 0");
        refused(CurvePanel { x: CurveAxis { ends: [0.0, 9.0], ..log }, ..panel(&[]) }, "above 0");
        refused(CurvePanel { y_ends: [1.0, 1.0], ..panel(&[]) }, "`P_LoS` from 1 to 1");
        refused(panel(&[line("", LineLook::Solid, &points); 25]), "up to 24");
        assert!(svg(&[]).is_err() && svg(&[panel(&[]); 13]).is_err());
        assert!(draw_curve_sheet(&CurveSheet { columns: 0, ..sheet(&[panel(&[])]) }, &PictureForm::PNG, &[]).is_err());
        // Beyond an axis is no error.
        let points = [point(-5.0, -0.2), point(200.0, 3.0)];
        assert!(svg(&[panel(&[line("a", LineLook::Solid, &points)])]).is_ok());
    }
}
