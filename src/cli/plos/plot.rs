//! Which plot a study calls for: curves, or heat maps.

use super::args::{PlosArgs, PlotArg};
use super::sweep::{Quantity, Sweeps};
use crate::cli::words::{title_of, unbreakable};
use crate::error::{Error, Result};
use crate::los_probability::fit::BuiltUpFit;
use crate::los_probability::product::rayleigh_cdf;
use crate::quantity::tidy;
use crate::render::{
    self, CurveAxis, CurveLine, CurvePanel, CurvePoint, CurveSheet, HeatAxis, HeatPanel, HeatSheet, LineLook,
};
use crate::report::{PlosReport, PlosRow};
use crate::scene::BuiltUp;

/// What pictures need beside the report.
#[derive(Debug, Default)]
pub(super) struct Facts {
    /// Whom pictures must credit.
    pub(super) attributions: Vec<String>,
    /// Models between the values of the table, so that their steps and bends are drawn where they are.
    pub(super) fine_rows: Vec<PlosRow>,
}

/// The most lines of a panel, and panels of a sheet.
const MOST_LINES: usize = 24;
const MOST_PANELS: usize = 12;
/// Fewer values than this along an axis make no heat map of their own accord.
const FEWEST_FOR_HEAT: usize = 3;
/// Iso-lines of P_LoS in heat maps.
const LEVELS: [f64; 3] = [0.1, 0.5, 0.9];

/// Draws the plot of a study.
pub(super) fn draw(
    args: &PlosArgs,
    sweeps: &Sweeps,
    facts: &Facts,
    report: &PlosReport,
    as_vectors: bool,
) -> Result<Vec<u8>> {
    let varying = sweeps.varying();
    let is_heat = match args.plot {
        PlotArg::Curves => false,
        PlotArg::Heat if varying.len() != 2 => {
            let text = format!("cannot draw a heat map: {} quantities are swept, wanted two", varying.len());
            return Err(Error::usage(124, text).with_hint("--plot curves"));
        }
        PlotArg::Heat => true,
        PlotArg::Auto => {
            let lines = groups(report, &|row| (row.city.clone(), row.method.clone()));
            varying.len() == 2 && lines.len() == 1 && varying.iter().all(|(_, v)| v.len() >= FEWEST_FOR_HEAT)
        }
    };
    let title = args.title.as_ref().map_or_else(|| title(report, &varying), |typed| unbreakable(typed));
    let caption = caption(facts, report, !is_heat);
    let software = format!("skyshed {}", env!("CARGO_PKG_VERSION"));
    let provenance = [("Software".to_string(), software), ("skyshed".to_string(), report.provenance().to_string())];
    let drawn = if is_heat {
        heat_maps(report, &varying, &title, &caption, &provenance, as_vectors)?
    } else {
        curves((report, facts), &varying, &title, &caption, &provenance, as_vectors)?
    };
    drawn.map_err(|cause| Error::internal(403, format!("cannot draw the plot: {cause}")))
}

type Drawn = std::result::Result<Vec<u8>, String>;

/// The values of a quantity in a row.
fn value(row: &PlosRow, quantity: Quantity) -> Option<f64> {
    match quantity {
        Quantity::Theta => row.theta_deg,
        Quantity::Distance => row.distance_m,
        Quantity::Radius => row.radius_m,
        Quantity::Phi => row.phi_deg,
        Quantity::Height => Some(row.height_m),
        Quantity::Gamma => row.built_up.map(|b| b.height_scale),
        Quantity::Alpha => row.built_up.map(|b| b.built_up_ratio),
        Quantity::Beta => row.built_up.map(|b| b.buildings_per_km2),
    }
}

fn axis_name(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Theta => "Elevation angle θ [°]",
        Quantity::Distance => "Ground distance [m]",
        Quantity::Radius => "Radius of the area [m]",
        Quantity::Phi => "Azimuth φ [°]",
        Quantity::Height => "UAV height above ground [m]",
        Quantity::Gamma => "Height scale γ [m]",
        Quantity::Alpha => "Built-up ratio α",
        Quantity::Beta => "Buildings per area β [1/km²]",
    }
}

/// A value of a quantity as words, such as `γ = 15 m`.
fn words(quantity: Quantity, v: f64) -> String {
    let v = tidy(v);
    let words = match quantity {
        Quantity::Theta => format!("θ = {v}°"),
        Quantity::Distance => format!("{v} m away"),
        Quantity::Radius => format!("within {v} m"),
        Quantity::Phi => format!("φ = {v}°"),
        Quantity::Height => format!("UAV at {v} m"),
        Quantity::Gamma => format!("γ = {v} m"),
        Quantity::Alpha => format!("α = {v}"),
        Quantity::Beta => format!("β = {v}/km²"),
    };
    unbreakable(&words)
}

/// The different values of a key, in the order of the rows.
fn groups<K: PartialEq>(report: &PlosReport, key: &dyn Fn(&PlosRow) -> K) -> Vec<K> {
    let mut found: Vec<K> = Vec::new();
    for row in &report.rows {
        let key = key(row);
        if !found.contains(&key) {
            found.push(key);
        }
    }
    found
}

/// A city's name for readers: `itu:urban` is `Urban`.
fn city_name(word: &str) -> String {
    match word.strip_prefix("itu:") {
        Some(name) if name.contains(',') => {
            let parts: Vec<&str> = name.split(',').map(str::trim).collect();
            match parts[..] {
                [alpha, beta, gamma] => format!("α = {alpha}, β = {beta}/km², γ = {gamma} m"),
                _ => name.to_string(),
            }
        }
        Some(name) => {
            let mut letters = name.chars();
            letters.next().map_or(String::new(), |c| c.to_uppercase().chain(letters).collect())
        }
        None => word.rsplit(['/', '\\']).next().unwrap_or(word).to_string(),
    }
}

/// Whether a city's word is its α, β, γ.
fn is_numbers(word: &str) -> bool {
    word.strip_prefix("itu:").is_some_and(|name| name.contains(','))
}

fn method_name<'a>(report: &'a PlosReport, id: &str) -> &'a str {
    report.methods.iter().find(|m| m.id == id).map_or("", |m| m.name.as_str())
}

fn title(report: &PlosReport, varying: &[(Quantity, Vec<f64>)]) -> String {
    let cities = groups(report, &|row| row.city.clone());
    let is_swept = varying.iter().any(|(q, _)| matches!(q, Quantity::Alpha | Quantity::Beta | Quantity::Gamma));
    let over = match &cities[..] {
        // The numbers of the caption are those that stay.
        [one] if is_swept && is_numbers(one) => String::new(),
        [one] => format!(", {}", city_name(one)),
        _ => String::new(),
    };
    let against: Vec<&str> = varying
        .iter()
        .map(|(q, _)| match q {
            Quantity::Theta => "elevation angle",
            Quantity::Distance => "distance",
            Quantity::Radius => "radius",
            Quantity::Phi => "azimuth",
            Quantity::Height => "UAV height",
            Quantity::Gamma => "γ",
            Quantity::Alpha => "α",
            Quantity::Beta => "β",
        })
        .collect();
    let against = if against.is_empty() { String::new() } else { format!(" against {}", against.join(" and ")) };
    unbreakable(&format!("P_LoS{against}{over}"))
}

/// What is the same for all rows, and where the numbers come from.
fn caption(facts: &Facts, report: &PlosReport, shows_intervals: bool) -> Vec<String> {
    let mut said: Vec<String> = Vec::new();
    if let [height] = groups(report, &|r| r.height_m)[..] {
        said.push(format!("UAV {} m above ground", tidy(height)));
    }
    if let [rx] = groups(report, &|r| r.rx_height_m)[..] {
        said.push(format!("receivers {} m above ground", tidy(rx)));
    }
    let of_estimates = |key: &dyn Fn(&PlosRow) -> Option<&'static str>| -> Vec<&'static str> {
        groups(report, key).into_iter().flatten().collect()
    };
    if let [users] = of_estimates(&|r| r.users)[..] {
        said.push(format!("users: {users}"));
    }
    if let [placement] = of_estimates(&|r| r.placement)[..] {
        said.push(format!("UAV {}", placement_words(placement)));
    }
    match of_estimates(&|r| r.uav_in_building)[..] {
        ["nlos"] => said.push("UAVs inside buildings count as NLoS".into()),
        ["excluded"] => said.push("UAVs inside buildings are left out".into()),
        _ => {}
    }
    if let [Some(theta)] = groups(report, &|r| r.theta_deg)[..] {
        said.push(format!("elevation angle {}°", tidy(theta)));
    }
    if let [Some(phi)] = groups(report, &|r| r.phi_deg)[..] {
        said.push(format!("azimuth {}°", tidy(phi)));
    }
    let mut lines = vec![title_of(&said.join("; "))];
    let mut cities: Vec<String> = Vec::new();
    for city in groups(report, &|r| r.city.clone()) {
        let is_generated = city.starts_with("itu:");
        let own = |of: &dyn Fn(&BuiltUp) -> f64| -> Option<f64> {
            let values = groups(report, &|r| r.built_up.as_ref().filter(|_| r.city == city).map(of));
            let mut values = values.into_iter().flatten();
            // What is swept is on an axis or in the legend.
            values.next().filter(|_| values.next().is_none())
        };
        let alpha =
            own(&|b| b.built_up_ratio).map(|v| if is_generated { format!("α = {v}") } else { format!("α = {v:.3}") });
        let beta = own(&|b| b.buildings_per_km2)
            .map(|v| if is_generated { format!("β = {}/km²", tidy(v)) } else { format!("β = {v:.0}/km²") });
        let gamma = own(&|b| b.height_scale)
            .map(|v| if is_generated { format!("γ = {} m", tidy(v)) } else { format!("γ = {v:.1} m (estimated)") });
        let parameters = [alpha, beta, gamma].into_iter().flatten().collect::<Vec<_>>().join(", ");
        if !parameters.is_empty() {
            // A name that is made of them says no more, and would be wrong for what is swept.
            let name = if is_numbers(&city) { String::new() } else { format!("{}: ", city_name(&city)) };
            cities.push(unbreakable(&format!("{name}{parameters}")));
        }
    }
    lines.push(cities.join("; "));
    for real in &report.real_cities {
        let mut line = format!(
            "{}: {} UAV positions ({} inside buildings), {} blocks of {} m, engine {}",
            city_name(&real.city),
            real.positions.0,
            real.positions.1,
            real.blocks.0,
            tidy(real.blocks.1),
            real.engine
        );
        if let Some(fit) = &real.fit {
            line += &format!(
                "; {} buildings, γ = {:.2} ± {:.2} m, Kolmogorov–Smirnov distance {:.3}",
                fit.heights.len(),
                fit.built_up.height_scale,
                fit.height_scale_error,
                fit.distance
            );
        }
        lines.push(unbreakable(&line));
    }
    if shows_intervals && report.rows.iter().any(|r| r.estimate().is_some_and(|e| e.interval.is_some())) {
        lines.push(format!(
            "Bands and bars: {} % intervals; seed {}; skyshed {}",
            tidy(100.0 * report.confidence),
            report.seed,
            env!("CARGO_PKG_VERSION")
        ));
    } else {
        lines.push(format!("skyshed {}", env!("CARGO_PKG_VERSION")));
    }
    lines.extend(facts.attributions.iter().cloned());
    lines.retain(|line| !line.is_empty());
    lines
}

fn placement_words(placement: &str) -> String {
    match placement {
        "anywhere" => "anywhere over the city".into(),
        "rooftop" => "over a building".into(),
        "street-center" | "crossroad-center" => {
            format!("over the middle of a {}", placement.trim_end_matches("-center"))
        }
        "rooftop-center" => "over the middle of a building".into(),
        other => format!("over a {other}"),
    }
}

/// A line of a plot before it is drawn.
struct Line {
    label: String,
    method: String,
    rest: String,
    points: Vec<CurvePoint>,
}

fn curves(
    (report, facts): (&PlosReport, &Facts),
    varying: &[(Quantity, Vec<f64>)],
    title: &str,
    caption: &[String],
    provenance: &[(String, String)],
    as_vectors: bool,
) -> Result<Drawn> {
    let (x, values) = varying.first().cloned().unwrap_or_else(|| {
        // A single value is a point on the axis of what it was asked for.
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
    let mut looks = Looks::default();
    let mut panels: Vec<Vec<(Line, LineLook, usize)>> = Vec::new();
    for set in &sets {
        let is_fine = |row: &PlosRow| facts.fine_rows.iter().any(|f| f.city == row.city && f.method == row.method);
        let all = report.rows.iter().filter(|r| !is_fine(r)).chain(&facts.fine_rows);
        let mut rows: Vec<&PlosRow> = all.filter(|r| set.holds(r, others)).collect();
        // In the order of the table, whichever rows stand for a method.
        let order = |row: &&PlosRow| report.rows.iter().position(|r| r.city == row.city && r.method == row.method);
        rows.sort_by_key(order);
        let lines = lines_of(
            report,
            &rows,
            (x, if set.others.is_some() { &[] } else { others }),
            (set.city.is_none() && cities.len() > 1, methods.len() > 1),
        );
        if lines.len() > MOST_LINES {
            return Err(too_many(lines.len(), "lines in one plot", MOST_LINES));
        }
        panels.push(
            lines
                .into_iter()
                .map(|line| {
                    let (look, color) = looks.of(&line, methods.len() > 1);
                    (line, look, color)
                })
                .collect(),
        );
    }
    let ends = axis_ends(x, &values);
    let drawn: Vec<Vec<CurveLine<'_>>> = panels
        .iter()
        .map(|lines| {
            let drawn = lines.iter().map(|(line, look, color)| CurveLine {
                label: &line.label,
                detail: None,
                color_index: *color,
                look: *look,
                points: &line.points,
            });
            drawn.collect()
        })
        .collect();
    let titles: Vec<String> = sets.iter().map(|set| set.title(others)).collect();
    let mut sheet_panels: Vec<CurvePanel<'_>> = drawn
        .iter()
        .zip(&titles)
        .map(|(lines, title)| CurvePanel {
            title,
            x: CurveAxis { name: axis_name(x), ends, is_log: false },
            y_name: "P_LoS",
            y_ends: [0.0, 1.0],
            lines,
        })
        .collect();
    // How well the statistical city describes a real one stands beside the curves that rest on it.
    let fits: Vec<FitLines> =
        report.real_cities.iter().filter_map(|c| c.fit.as_ref().map(|f| FitLines::of(&c.city, f))).collect();
    let fit_lines: Vec<[CurveLine<'_>; 2]> = fits.iter().map(FitLines::lines).collect();
    for (fit, lines) in fits.iter().zip(&fit_lines) {
        sheet_panels.push(CurvePanel {
            title: &fit.title,
            x: CurveAxis { name: "Building height [m]", ends: [0.0, fit.highest], is_log: false },
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
    Ok(if as_vectors {
        render::draw_curve_sheet_svg(&sheet, provenance).map(String::into_bytes)
    } else {
        render::draw_curve_sheet(&sheet, provenance)
    })
}

/// The rows of one panel: those of a city, of all of them, and of one value of each of the other quantities, or of all.
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

/// The panels of a sheet of curves. Methods are compared within one, so that each has its own look: what else varies has
/// a panel for each of its values, if those are not too many. Several cities share a panel if each has a single line.
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

fn too_many(n: usize, what: &str, most: usize) -> Error {
    Error::usage(124, format!("cannot draw {n} {what}, wanted at most {most}"))
        .with_hint("sweep less in one run, or write the table alone: -o table.csv")
}

fn axis_ends(quantity: Quantity, values: &[f64]) -> [f64; 2] {
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    match quantity {
        Quantity::Theta | Quantity::Phi if high - low >= 45.0 => [0.0, 90.0],
        _ if values.is_empty() => [0.0, 1.0],
        _ if low < high => {
            // From 0 where that costs little room.
            let from = if low > 0.0 && low < 0.25 * high { 0.0 } else { low };
            [from, high]
        }
        _ => [low - 1.0, low + 1.0],
    }
}

/// The lines of a panel: one per method and per combination of everything that varies beside x.
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
            None => lines.push(Line { label, method: row.method.clone(), rest, points: vec![point] }),
        }
    }
    for line in &mut lines {
        line.points.sort_by(|a, b| a.x.total_cmp(&b.x));
    }
    lines
}

/// Looks that stay with methods and labels over all panels.
#[derive(Default)]
struct Looks {
    /// Labels with their colors.
    colors: Vec<String>,
    models: Vec<String>,
}

impl Looks {
    /// Estimates of one thing share a color; models are dashed, each pattern in turn.
    fn of(&mut self, line: &Line, by_method: bool) -> (LineLook, usize) {
        let look = match line.method.as_str() {
            "product" | "maps" => LineLook::Solid,
            "city" | "geometry" => LineLook::Markers,
            model => {
                let k = self.models.iter().position(|m| m == model).unwrap_or_else(|| {
                    self.models.push(model.to_string());
                    self.models.len() - 1
                });
                [LineLook::Dashed, LineLook::DashDot, LineLook::Dotted][k % 3]
            }
        };
        // With several methods the color is the method's; what else varies shares it only if nothing does.
        let key = if by_method && line.rest.is_empty() {
            line.method.clone()
        } else {
            format!("{}|{}", line.method, line.rest)
        };
        let color = self.colors.iter().position(|c| *c == key).unwrap_or_else(|| {
            self.colors.push(key);
            self.colors.len() - 1
        });
        (look, color)
    }
}

/// The distribution of heights of a real city, and the one fitted to it.
struct FitLines {
    title: String,
    highest: f64,
    share: Vec<CurvePoint>,
    rayleigh: Vec<CurvePoint>,
}

impl FitLines {
    fn of(city: &str, fit: &BuiltUpFit) -> Self {
        // The last percent of heights would squeeze all others.
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
        // Beyond the colors of most studies.
        let line = |label, look, color_index, points| CurveLine { label, detail: None, color_index, look, points };
        [
            line("Building heights", LineLook::Solid, 6, &self.share[..]),
            line("Rayleigh, most likely γ", LineLook::Dashed, 7, &self.rayleigh[..]),
        ]
    }
}

fn heat_maps(
    report: &PlosReport,
    varying: &[(Quantity, Vec<f64>)],
    title: &str,
    caption: &[String],
    provenance: &[(String, String)],
    as_vectors: bool,
) -> Result<Drawn> {
    // The angle or distance goes up, what it is compared with goes along.
    let [(y, y_values), (x, x_values)] = varying else {
        return Err(Error::internal(902, "a heat map was asked for without two axes"));
    };
    type Kind = (String, String, Option<&'static str>, Option<&'static str>);
    let kind = |r: &PlosRow| -> Kind { (r.city.clone(), r.method.clone(), r.placement, r.users) };
    let kinds = groups(report, &kind);
    if kinds.len() > MOST_PANELS {
        return Err(too_many(kinds.len(), "heat maps", MOST_PANELS));
    }
    let differ = |of: &dyn Fn(&Kind) -> String| {
        let first = kinds.first().map(of);
        kinds.iter().any(|k| Some(of(k)) != first)
    };
    let names_city = differ(&|k| k.0.clone());
    let names_method = differ(&|k| k.1.clone());
    let names_placement = differ(&|k| format!("{:?}", k.2));
    let names_users = differ(&|k| format!("{:?}", k.3));
    let panel = |kind_of: &Kind| {
        let mut values: Vec<Option<f64>> = vec![None; x_values.len() * y_values.len()];
        for row in report.rows.iter().filter(|r| kind(r) == *kind_of) {
            let index = |values: &[f64], at: Option<f64>| {
                at.and_then(|at| values.iter().position(|v| (v - at).abs() <= 1e-9 * v.abs().max(1.0)))
            };
            if let (Some(i), Some(j)) = (index(x_values, value(row, *x)), index(y_values, value(row, *y))) {
                values[j * x_values.len() + i] = row.p_los();
            }
        }
        let mut parts = Vec::new();
        if names_city {
            parts.push(city_name(&kind_of.0));
        }
        if names_method {
            parts.push(method_name(report, &kind_of.1).to_string());
        }
        if names_placement {
            parts.extend(kind_of.2.map(|p| format!("UAV {}", placement_words(p))));
        }
        if names_users {
            parts.extend(kind_of.3.map(|u| format!("{u} users")));
        }
        (title_of(&parts.join(", ")), values)
    };
    let panels: Vec<(String, Vec<Option<f64>>)> = kinds.iter().map(panel).collect();
    let sheet_panels: Vec<HeatPanel<'_>> = panels
        .iter()
        .map(|(title, values)| HeatPanel {
            title,
            x: HeatAxis { name: axis_name(*x), values: x_values },
            y: HeatAxis { name: axis_name(*y), values: y_values },
            values,
        })
        .collect();
    let columns = if sheet_panels.len() > 4 { 3 } else { sheet_panels.len().min(2) };
    let sheet = HeatSheet { title, caption, panels: &sheet_panels, columns, levels: &LEVELS };
    Ok(if as_vectors {
        render::draw_heat_sheet_svg(&sheet, provenance).map(String::into_bytes)
    } else {
        render::draw_heat_sheet(&sheet, provenance)
    })
}
