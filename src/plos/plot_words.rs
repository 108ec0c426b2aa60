//! Text in plots of P_LoS: titles, captions, names of axes, lines and cities.

use super::panels::Facts;
use super::report::{PlosReport, PlosRow, RealCityFacts};
use super::sweep::Quantity;
use crate::city::BuiltUp;
use crate::method_looks::look_of;
use crate::picture::{Look, program};
use crate::quantity::tidy;
use crate::render::LineLook;
use crate::words::{capitalized, title_of, unbreakable};

/// Returns the value of a quantity in a row.
pub(super) fn value(row: &PlosRow, quantity: Quantity) -> Option<f64> {
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

pub(super) fn axis_name(quantity: Quantity) -> &'static str {
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

/// Returns a value of a quantity in words, such as `γ = 15 m`.
pub(super) fn words(quantity: Quantity, v: f64) -> String {
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

/// Returns the distinct values of a key, in the order of the rows.
pub(super) fn groups<K: PartialEq>(report: &PlosReport, key: &dyn Fn(&PlosRow) -> K) -> Vec<K> {
    let mut found: Vec<K> = Vec::new();
    for row in &report.rows {
        let key = key(row);
        if !found.contains(&key) {
            found.push(key);
        }
    }
    found
}

/// Returns a city's name for readers: `itu:urban` is `Urban`.
pub(super) fn city_name(word: &str) -> String {
    match word.strip_prefix("itu:") {
        Some(name) if name.contains(',') => {
            let parts: Vec<&str> = name.split(',').map(str::trim).collect();
            match parts[..] {
                [alpha, beta, gamma] => format!("α = {alpha}, β = {beta}/km², γ = {gamma} m"),
                _ => name.to_string(),
            }
        }
        Some(name) => capitalized(name),
        None => word.rsplit(['/', '\\']).next().unwrap_or(word).to_string(),
    }
}

/// Returns `true` if a city's word consists of α, β, γ.
pub(super) fn is_numbers(word: &str) -> bool {
    word.strip_prefix("itu:").is_some_and(|name| name.contains(','))
}

pub(super) fn method_name<'a>(report: &'a PlosReport, id: &str) -> &'a str {
    report.methods.iter().find(|m| m.id == id).map_or("", |m| m.name.as_str())
}

pub(super) fn title(report: &PlosReport, varying: &[(Quantity, Vec<f64>)]) -> String {
    let cities = groups(report, &|row| row.city.clone());
    let is_swept = varying.iter().any(|(q, _)| matches!(q, Quantity::Alpha | Quantity::Beta | Quantity::Gamma));
    let over = match &cities[..] {
        // The word holds values that the sweep replaces.
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

/// Intervals in a plot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Intervals {
    /// No intervals.
    None,
    /// Bars for all estimates.
    Bars,
    /// Bands for estimates drawn as lines, bars for the others.
    BandsOfLines,
}

impl Intervals {
    /// Returns the word for the intervals that the plot of a report shows.
    fn in_words(self, report: &PlosReport) -> Option<&'static str> {
        let is_line = |row: &PlosRow| self == Intervals::BandsOfLines && look_of(&row.method, &[]).0 == LineLook::Solid;
        let has = |of_lines: bool| {
            let mut drawn = report.rows.iter().filter(|row| is_line(row) == of_lines);
            drawn.any(|row| row.estimate().is_some_and(|e| e.p_los.and(e.interval).is_some()))
        };
        match (has(true), has(false)) {
            _ if self == Intervals::None => None,
            (true, true) => Some("Bands and bars"),
            (true, false) => Some("Bands"),
            (false, true) => Some("Bars"),
            (false, false) => None,
        }
    }
}

/// Returns the caption: values that all rows share, and the origin of the numbers.
pub(super) fn caption(facts: &Facts, report: &PlosReport, intervals: Intervals, look: &Look) -> Vec<String> {
    let mut lines = vec![title_of(&shared_values(report).join("; ")), city_parameters(report).join("; ")];
    if !facts.between.is_empty() {
        lines
            .push("Markers are what was asked for; lines of the product go through more values where they turn".into());
    }
    for real in &report.real_cities {
        lines.push(unbreakable(&positions_words(real)));
        lines.extend(real.limits.clone());
        lines.extend(real.tolerance.as_ref().map(|t| unbreakable(&t.in_words())));
    }
    let drawn = intervals.in_words(report);
    let drawn = drawn.map(|words| format!("{words}: {} % intervals", tidy(100.0 * report.confidence)));
    let has_estimates = report.rows.iter().any(|r| r.estimate().is_some());
    let seed = has_estimates.then(|| format!("seed {}", report.seed));
    let parts: Vec<String> = drawn.into_iter().chain(seed).chain([program()]).collect();
    lines.push(title_of(&parts.join("; ")));
    match &look.attribution {
        Some(attribution) => lines.push(attribution.clone()),
        None => lines.extend(facts.attributions.iter().cloned()),
    }
    lines.retain(|line| !line.is_empty());
    lines
}

/// Returns the values that all rows share, in words.
fn shared_values(report: &PlosReport) -> Vec<String> {
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
    let centimeters = |m: f64| tidy((100.0 * m).round() / 100.0);
    if let [Some(distance)] = groups(report, &|r| r.distance_m)[..] {
        said.push(format!("ground distance {} m", centimeters(distance)));
    }
    if let [Some(radius)] = groups(report, &|r| r.radius_m)[..] {
        said.push(format!("users within {} m", centimeters(radius)));
    }
    said
}

/// Returns α, β, γ of each city, in words.
fn city_parameters(report: &PlosReport) -> Vec<String> {
    let mut cities: Vec<String> = Vec::new();
    for city in groups(report, &|r| r.city.clone()) {
        let is_generated = city.starts_with("itu:");
        let own = |of: &dyn Fn(&BuiltUp) -> f64| -> Option<f64> {
            let values = groups(report, &|r| r.built_up.as_ref().filter(|_| r.city == city).map(of));
            let mut values = values.into_iter().flatten();
            // Swept parameters are on an axis or in the legend.
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
            // A name made of the parameters adds nothing, and would be wrong for swept ones.
            let name = if is_numbers(&city) { String::new() } else { format!("{}: ", city_name(&city)) };
            cities.push(unbreakable(&format!("{name}{parameters}")));
        }
    }
    cities
}

/// Returns the UAV positions over a real city, and its fit, in words.
fn positions_words(real: &RealCityFacts) -> String {
    let mut line = format!(
        "{}: {} UAV positions ({} inside buildings), {} blocks of {} m, engine {}",
        city_name(&real.city),
        real.positions.0,
        real.positions.1,
        real.blocks.0,
        tidy(real.blocks.1),
        real.engine
    );
    if let Some(band) = real.theta_band_deg {
        line += &format!("; P_LoS at θ is of users within θ ± {}°", tidy(band));
    }
    if real.cut > 0 {
        line += "; only positions whose discs lie in the data";
    }
    if let Some(fit) = &real.fit {
        line += &format!(
            "; {} buildings, γ = {:.2} ± {:.2} m, Kolmogorov–Smirnov distance {:.3}",
            fit.heights.len(),
            fit.built_up.height_scale,
            fit.height_scale_error,
            fit.distance
        );
    }
    line
}

pub(super) fn placement_words(placement: &str) -> String {
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
