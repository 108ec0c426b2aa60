//! Plot of a sample: P_LoS against height, a panel for each kind of receivers, a line for each
//! placement zone.

use super::Sample;
use super::report::{SampledReport, SampledRow};
use crate::error::Result;
use crate::export::Format;
use crate::picture::{Look, crs_words, picture_provenance, program, written};
use crate::quantity::{counted, tidy};
use crate::render::{self, CurveLine, CurvePanel, CurvePoint, CurveSheet, LineLook};
use crate::sight::antenna_words;
use crate::words::{title_of, unbreakable};
use crate::zones::Zone;

/// Draws P_LoS by zone.
pub(super) fn draw(sample: &Sample, format: Format, look: &Look) -> Result<Vec<u8>> {
    let report = &sample.report;
    let placements = in_order(report, |row| row.placement);
    let receivers = in_order(report, |row| row.receivers);
    let heights = in_order(report, |row| row.height_m.to_bits());
    let point =
        |row: &SampledRow| CurvePoint { x: row.height_m, y: row.estimate.p_los, low_high: row.estimate.interval };
    let points: Vec<Vec<Vec<CurvePoint>>> = receivers
        .iter()
        .map(|receivers| {
            let of = |placement: &Zone| {
                let rows = report.rows.iter().filter(|r| r.receivers == *receivers && r.placement == *placement);
                let mut points: Vec<CurvePoint> = rows.map(point).collect();
                points.sort_by(|a, b| a.x.total_cmp(&b.x));
                points
            };
            placements.iter().map(of).collect()
        })
        .collect();
    let labels: Vec<String> = placements.iter().map(|zone| format!("UAV over {}", over(*zone))).collect();
    // A single height gives points with intervals, several heights give lines.
    let line_look = if heights.len() > 1 { LineLook::Solid } else { LineLook::Markers };
    let lines: Vec<Vec<CurveLine<'_>>> = points
        .iter()
        .map(|of_receivers| {
            let lines = of_receivers.iter().enumerate().map(|(k, points)| CurveLine {
                label: &labels[k],
                color_index: placements[k].code().into(),
                look: line_look,
                points,
                through: &[],
            });
            lines.collect()
        })
        .collect();
    let titles: Vec<String> = receivers.iter().map(|zone| title_of(&users(*zone))).collect();
    let ends = ends_of(report.rows.iter().map(|row| row.height_m));
    let panels: Vec<CurvePanel<'_>> = lines
        .iter()
        .zip(&titles)
        .map(|(lines, title)| CurvePanel {
            title,
            x_name: "UAV height above ground [m]",
            x_ends: ends,
            y_name: "P_LoS",
            y_ends: [0.0, 1.0],
            lines,
        })
        .collect();
    let range = report.sight.radius_m().map_or(String::new(), |r| format!(" within {} m", tidy(r)));
    let title = look.title_or(|| format!("P_LoS{range} by what the UAV hovers over: {}", report.facts.scene_name));
    let (title, caption) = (unbreakable(&title), caption(report, sample.scene.last_lines(look)));
    let sheet =
        CurveSheet { title: &title, caption: &caption, panels: &panels, columns: if panels.len() > 1 { 2 } else { 1 } };
    written(render::draw_curve_sheet(&sheet), &look.form(format), &picture_provenance(&report.document(false)))
}

/// Returns the distinct values of the rows, in the order of their first occurrence.
fn in_order<T: PartialEq>(report: &SampledReport, of: impl Fn(&SampledRow) -> T) -> Vec<T> {
    let mut values = Vec::new();
    for value in report.rows.iter().map(of) {
        if !values.contains(&value) {
            values.push(value);
        }
    }
    values
}

fn over(zone: Zone) -> &'static str {
    match zone {
        Zone::Street => "streets",
        Zone::Crossroad => "crossroads",
        Zone::Courtyard => "courtyards",
        Zone::Rooftop => "rooftops",
    }
}

fn users(zone: Option<Zone>) -> String {
    match zone {
        None => "all receivers".into(),
        Some(Zone::Rooftop) => "receivers on rooftops".into(),
        Some(zone) => format!("receivers in {}", over(zone)).replace("in crossroads", "on crossroads"),
    }
}

/// Returns the range of some heights, slightly widened.
fn ends_of(heights: impl Iterator<Item = f64> + Clone) -> [f64; 2] {
    let low = heights.clone().fold(f64::INFINITY, f64::min);
    let high = heights.fold(f64::NEG_INFINITY, f64::max);
    let border = if high > low { 0.06 * (high - low) } else { (0.2 * high.abs()).max(1.0) };
    [low - border, high + border]
}

fn caption(report: &SampledReport, last: Vec<String>) -> Vec<String> {
    let n = report.rows.iter().map(|row| row.n_placements).max().unwrap_or(0);
    let inside: usize =
        in_order(report, |row| (row.placement, row.height_m.to_bits(), row.n_inside)).iter().map(|k| k.2).sum();
    let where_ = if report.is_centered { "over middles of the zone" } else { "spread evenly over the zone" };
    let maps = if report.facts.method.is_some_and(crate::los::Method::is_exact) { "Exact maps" } else { "Maps" };
    let mut first =
        format!("{maps} of up to {} for each zone and height, {where_}", counted(n as u64, "placement", "placements"));
    if report.n_cities > 1 {
        first += &format!(", in {} cities", report.n_cities);
    }
    if report.sight.radius_m().is_some() {
        first += "; whole discs only";
    }
    if inside > 0 {
        first += &format!("; {inside} inside a building left out");
    }
    let mut lines = vec![first];
    if report.rows.iter().any(|row| row.estimate.p_los.and(row.estimate.interval).is_some()) {
        let heights = in_order(report, |row| row.height_m.to_bits());
        let drawn = if heights.len() > 1 { "Bands" } else { "Bars" };
        lines.push(format!("{drawn}: {} % intervals over {}", tidy(100.0 * report.confidence), report.clusters()));
    }
    let radius =
        report.sight.radius_m().map_or(String::new(), |r| format!(", within {} m of the UAV's place", tidy(r)));
    let antenna = antenna_words(report.sight.antenna()).map_or(String::new(), |words| format!(", {words}"));
    let range = radius + &antenna;
    lines.push(format!(
        "Receivers {} m above what they stand on{range}; method {}; {}; {}",
        tidy(report.sight.rx_height_m()),
        report.facts.method_in_words(),
        crs_words(&report.facts.grid),
        program()
    ));
    lines.extend(last);
    lines
}
