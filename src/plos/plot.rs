//! Plot of a study: curves or heat maps.

use super::heat::heat_maps;
use super::panels::{Drawn, Facts, MOST_PANELS, too_many};
use super::plot_words::{
    Intervals, axis_name, caption, city_name, groups, method_name, placement_words, title, value, words,
};
use super::report::{PlosReport, PlosRow};
use super::sweep::Quantity;
use skyshed_request::PlotKind;

use super::PlosStudy;
use crate::city_statistics::fit::BuiltUpFit;
use crate::error::{RequestError, Result};
use crate::export::Format;
use crate::los_probability::models::{CurveAxis as CurveOver, UserCurve};
use crate::los_probability::product::rayleigh_cdf;
use crate::method_looks::look_of;
use crate::picture::{Look, picture_provenance, written};
use crate::render::{self, CurveLine, CurvePanel, CurvePoint, CurveSheet, LineLook};
use crate::words::unbreakable;

/// Most lines of a panel.
const MOST_LINES: usize = 24;
/// Fewest values along each axis for an automatic heat map.
const FEWEST_FOR_HEAT: usize = 3;

/// Draws the plot of a study.
pub(super) fn draw(study: &PlosStudy, format: Format, look: &Look) -> Result<Vec<u8>> {
    let PlosStudy { report, plot: facts, plan, .. } = study;
    let varying = plan.sweeps.varying();
    let is_heat = match plan.plot {
        PlotKind::Curves => false,
        PlotKind::Heat if varying.len() != 2 => {
            return Err(RequestError::HeatAxes(varying.len()).into());
        }
        PlotKind::Heat => true,
        PlotKind::Auto => {
            let lines = groups(report, &|row| (row.city.clone(), row.method.clone()));
            varying.len() == 2 && lines.len() == 1 && varying.iter().all(|(_, v)| v.len() >= FEWEST_FOR_HEAT)
        }
    };
    let title = look.title.as_ref().map_or_else(|| title(report, &varying), |typed| unbreakable(typed));
    let intervals = match (is_heat, varying.is_empty()) {
        (true, _) => Intervals::None,
        (false, true) => Intervals::Bars,
        (false, false) => Intervals::BandsOfLines,
    };
    let caption = caption(facts, report, intervals, look);
    let provenance = picture_provenance(&report.provenance());
    let sheet = if is_heat {
        heat_maps(report, &varying, &title, &caption)?
    } else {
        curves((report, facts), &varying, &title, &caption)?
    };
    written(sheet, &look.form(format), &provenance)
}

/// A line of a plot before it is drawn.
struct Line {
    label: String,
    method: String,
    rest: String,
    points: Vec<CurvePoint>,
    /// The points and computed values between them; empty if none were computed.
    through: Vec<CurvePoint>,
}

impl Line {
    fn drawn(&self, look: LineLook, color_index: usize) -> CurveLine<'_> {
        CurveLine { label: &self.label, color_index, look, points: &self.points, through: &self.through }
    }
}

fn curves(
    (report, facts): (&PlosReport, &Facts),
    varying: &[(Quantity, Vec<f64>)],
    title: &str,
    caption: &[String],
) -> Result<Drawn> {
    let (x, values) = varying.first().cloned().unwrap_or_else(|| {
        // A single value becomes a point on the axis of its quantity.
        let first = report.rows.first();
        let x = if first.is_some_and(|r| r.radius_m.is_some()) { Quantity::Radius } else { Quantity::Theta };
        (x, first.and_then(|r| value(r, x)).into_iter().collect())
    });
    let cities = groups(report, &|r| r.city.clone());
    let methods = groups(report, &|r| r.method.clone());
    let others = &varying[1.min(varying.len())..];
    let sets = panel_sets(report, others, methods.len() > 1);
    if sets.len() > MOST_PANELS {
        return Err(too_many(sets.len(), "cities", MOST_PANELS));
    }
    let own_curves = facts.curves.iter().map(UserCurve::name).collect();
    let mut looks = Looks { own_curves, ..Looks::default() };
    let mut panels: Vec<Vec<(Line, LineLook, usize)>> = Vec::new();
    for set in &sets {
        let along = (x, if set.others.is_some() { &[][..] } else { others });
        let names = (set.city.is_none() && cities.len() > 1, methods.len() > 1);
        let lines = lines_of_set((report, facts), (set, others), along, names)?.into_iter().map(|line| {
            let (look, index) = looks.of(&line, values.len() > 1);
            (at_own_rows(line, x, &facts.curves), look, index)
        });
        panels.push(lines.collect());
    }
    let ends = axis_ends(x, &values);
    let drawn: Vec<Vec<CurveLine<'_>>> = panels
        .iter()
        .map(|lines| lines.iter().map(|(line, look, index)| line.drawn(*look, *index)).collect())
        .collect();
    let titles: Vec<String> = sets.iter().map(|set| set.title(others)).collect();
    let mut sheet_panels: Vec<CurvePanel<'_>> = drawn
        .iter()
        .zip(&titles)
        .map(|(lines, title)| CurvePanel {
            title,
            x_name: axis_name(x),
            x_ends: ends,
            y_name: "P_LoS",
            y_ends: [0.0, 1.0],
            lines,
        })
        .collect();
    // Panels of fits show how well the statistical city describes a real one.
    let fits: Vec<FitLines> =
        report.real_cities.iter().filter_map(|c| c.fit.as_ref().map(|f| FitLines::of(&c.city, f))).collect();
    let fit_lines: Vec<[CurveLine<'_>; 2]> = fits.iter().map(FitLines::lines).collect();
    for (fit, lines) in fits.iter().zip(&fit_lines) {
        sheet_panels.push(CurvePanel {
            title: &fit.title,
            x_name: "Building height [m]",
            x_ends: [0.0, fit.highest],
            y_name: "Share of buildings not higher",
            y_ends: [0.0, 1.0],
            lines,
        });
    }
    sheet_panels.truncate(MOST_PANELS);
    let columns = match sheet_panels.len() {
        1 => 1,
        2 | 4 => 2,
        _ => 3,
    };
    let sheet = CurveSheet { title, caption, panels: &sheet_panels, columns };
    Ok(render::draw_curve_sheet(&sheet))
}

/// Returns the lines of a panel, with the computed values between their points.
///
/// # Errors
/// E124 for too many lines.
fn lines_of_set(
    (report, facts): (&PlosReport, &Facts),
    (set, others): (&PanelSet, &[(Quantity, Vec<f64>)]),
    along: (Quantity, &[(Quantity, Vec<f64>)]),
    names: (bool, bool),
) -> Result<Vec<Line>> {
    let is_fine = |row: &PlosRow| facts.fine_rows.iter().any(|f| f.city == row.city && f.method == row.method);
    let all = report.rows.iter().filter(|r| !is_fine(r)).chain(&facts.fine_rows);
    let mut rows: Vec<&PlosRow> = all.filter(|r| set.holds(r, others)).collect();
    // Keeps the order of the table, whichever rows represent a method.
    let order = |row: &&PlosRow| report.rows.iter().position(|r| r.city == row.city && r.method == row.method);
    rows.sort_by_key(order);
    let mut lines = lines_of(report, &rows, along, names);
    let between: Vec<&PlosRow> = facts.between.iter().filter(|r| set.holds(r, others)).collect();
    for more in lines_of(report, &[rows.as_slice(), &between].concat(), along, names) {
        let line = lines.iter_mut().find(|line| line.label == more.label && line.method == more.method);
        if let Some(line) = line.filter(|line| line.points.len() < more.points.len()) {
            line.through = more.points;
        }
    }
    if lines.len() > MOST_LINES { Err(too_many(lines.len(), "lines in one plot", MOST_LINES)) } else { Ok(lines) }
}

/// Rows of one panel: of one city or of all, and of one value of each of the other quantities or of
/// all.
#[derive(Debug, Clone, PartialEq)]
struct PanelSet {
    city: Option<String>,
    others: Option<Vec<Option<f64>>>,
}

impl PanelSet {
    fn holds(&self, row: &PlosRow, others: &[(Quantity, Vec<f64>)]) -> bool {
        let values = || others.iter().map(|(q, _)| value(row, *q));
        self.city.as_ref().is_none_or(|c| *c == row.city)
            && self.others.as_ref().is_none_or(|wanted| values().eq(wanted.iter().copied()))
    }

    fn title(&self, others: &[(Quantity, Vec<f64>)]) -> String {
        let city = self.city.iter().map(|c| city_name(c));
        let values = others.iter().zip(self.others.iter().flatten());
        city.chain(values.filter_map(|((q, _), v)| v.map(|v| words(*q, v)))).collect::<Vec<_>>().join(", ")
    }
}

/// Returns the panels of a sheet of curves. Methods share a panel, where each has its own look.
/// Each value of another quantity gets a panel of its own, unless there are too many. Several
/// cities share a panel if each has a single line.
fn panel_sets(report: &PlosReport, others: &[(Quantity, Vec<f64>)], has_methods: bool) -> Vec<PanelSet> {
    let several =
        |key: &dyn Fn(&PlosRow) -> Option<&'static str>| groups(report, key).into_iter().flatten().count() > 1;
    let has_lines = has_methods || !others.is_empty() || several(&|r| r.placement) || several(&|r| r.users);
    let splits_cities = has_lines && groups(report, &|r| r.city.clone()).len() > 1;
    let city = |row: &PlosRow| splits_cities.then(|| row.city.clone());
    if has_methods && !others.is_empty() {
        let values = |row: &PlosRow| others.iter().map(|(q, _)| value(row, *q)).collect();
        let sets = groups(report, &|row| PanelSet { city: city(row), others: Some(values(row)) });
        if sets.len() <= MOST_PANELS {
            return sets;
        }
    }
    groups(report, &|row| PanelSet { city: city(row), others: None })
}

fn axis_ends(quantity: Quantity, values: &[f64]) -> [f64; 2] {
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    match quantity {
        Quantity::Theta | Quantity::Phi if high - low >= 45.0 => [0.0, 90.0],
        _ if values.is_empty() => [0.0, 1.0],
        _ if low < high => {
            // The axis begins at 0 where that costs little room.
            let from = if low > 0.0 && low < 0.25 * high { 0.0 } else { low };
            [from, high]
        }
        _ => [low - 1.0, low + 1.0],
    }
}

/// Returns the lines of a panel: one for each method and each combination of the quantities other
/// than x.
fn lines_of(
    report: &PlosReport,
    rows: &[&PlosRow],
    (x, others): (Quantity, &[(Quantity, Vec<f64>)]),
    (names_city, names_method): (bool, bool),
) -> Vec<Line> {
    let several =
        |key: &dyn Fn(&PlosRow) -> Option<&'static str>| groups(report, key).into_iter().flatten().count() > 1;
    let (names_placement, names_users) = (several(&|r| r.placement), several(&|r| r.users));
    let mut lines: Vec<Line> = Vec::new();
    for row in rows {
        let mut parts: Vec<String> = Vec::new();
        if names_city {
            parts.push(city_name(&row.city));
        }
        if names_placement {
            parts.extend(row.placement.map(|p| format!("UAV {}", placement_words(p))));
        }
        if names_users {
            parts.extend(row.users.map(|u| format!("{u} users")));
        }
        parts.extend(others.iter().filter_map(|(q, _)| value(row, *q).map(|v| words(*q, v))));
        let rest = parts.join(", ");
        let method = method_name(report, &row.method);
        let label = match (names_method, rest.is_empty()) {
            (_, true) => method.to_string(),
            (true, false) => format!("{method}, {rest}"),
            (false, false) => rest.clone(),
        };
        let Some(at) = value(row, x) else { continue };
        let low_high = row.estimate().and_then(|e| e.interval);
        let point = CurvePoint { x: at, y: row.p_los(), low_high };
        match lines.iter_mut().find(|l| l.label == label && l.method == row.method) {
            Some(line) => line.points.push(point),
            None => {
                lines.push(Line { label, method: row.method.clone(), rest, points: vec![point], through: Vec::new() });
            }
        }
    }
    for line in &mut lines {
        line.points.sort_by(|a, b| a.x.total_cmp(&b.x));
    }
    lines
}

/// Replaces the points of a user's curve by the rows of its table, if these are along the axis.
fn at_own_rows(line: Line, x: Quantity, curves: &[UserCurve]) -> Line {
    let is_along =
        |axis| matches!((axis, x), (CurveOver::Theta, Quantity::Theta) | (CurveOver::Distance, Quantity::Distance));
    match curves.iter().find(|curve| curve.name() == line.method && is_along(curve.axis())) {
        Some(curve) => {
            let point = |(x, p_los): &(f64, f64)| CurvePoint { x: *x, y: Some(*p_los), low_high: None };
            Line { points: curve.points().iter().map(point).collect(), ..line }
        }
        None => line,
    }
}

/// Looks of methods and labels, the same in all panels.
#[derive(Default)]
struct Looks<'a> {
    /// Names of the user's curves.
    own_curves: Vec<&'a str>,
    /// Labels of lines beside their method, in the order of their first occurrence.
    varying: Vec<String>,
}

impl Looks<'_> {
    /// Returns the look of a line. A method has the same look everywhere; several lines of one
    /// method differ in color, marker and pattern.
    fn of(&mut self, line: &Line, is_line: bool) -> (LineLook, usize) {
        let (look, index) = look_of(&line.method, &self.own_curves);
        // A single value has an error bar instead of a band.
        let look = if look == LineLook::Solid && !is_line { LineLook::Markers } else { look };
        if line.rest.is_empty() {
            return (look, index);
        }
        let key = format!("{}|{}", line.method, line.rest);
        let index = self.varying.iter().position(|known| *known == key).unwrap_or_else(|| {
            self.varying.push(key);
            self.varying.len() - 1
        });
        (look, index)
    }
}

/// The height distribution of a real city and its fitted Rayleigh distribution.
struct FitLines {
    title: String,
    highest: f64,
    share: Vec<CurvePoint>,
    rayleigh: Vec<CurvePoint>,
}

impl FitLines {
    fn of(city: &str, fit: &BuiltUpFit) -> Self {
        // The axis ends near the 99th percentile, because the highest buildings would compress the
        // rest.
        let n = fit.heights.len();
        let highest = (1.1 * fit.heights[(n * 99 / 100).min(n - 1)]).max(3.5 * fit.built_up.height_scale);
        let point = |x: f64, y: f64| CurvePoint { x, y: Some(y), low_high: None };
        let grid = || (0..=200).map(|k| highest * f64::from(k) / 200.0);
        FitLines {
            title: format!("Heights of {}", city_name(city)),
            highest,
            share: grid().map(|h| point(h, fit.share_up_to(h))).collect(),
            rayleigh: grid().map(|h| point(h, rayleigh_cdf(h, fit.built_up.height_scale))).collect(),
        }
    }

    fn lines(&self) -> [CurveLine<'_>; 2] {
        // Looks that no method has.
        let line = |label, look, color_index, points| CurveLine { label, color_index, look, points, through: &[] };
        [
            line("Building heights", LineLook::Solid, 6, &self.share[..]),
            line("Rayleigh, most likely γ", LineLook::Dashed, 23, &self.rayleigh[..]),
        ]
    }
}
