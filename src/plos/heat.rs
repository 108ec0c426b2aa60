//! Heat maps of two-way sweeps.

use super::panels::{Drawn, MOST_PANELS, too_many};
use super::plot_words::{axis_name, city_name, groups, method_name, placement_words, value};
use super::report::{PlosReport, PlosRow};
use super::sweep::Quantity;
use crate::error::{Error, Result};
use crate::render::{self, HeatAxis, HeatPanel, HeatSheet};
use crate::words::title_of;

pub(super) fn heat_maps(
    report: &PlosReport,
    varying: &[(Quantity, Vec<f64>)],
    title: &str,
    caption: &[String],
) -> Result<Drawn> {
    // The angle or distance is the vertical axis, the other quantity the horizontal one.
    let [(y, y_values), (x, x_values)] = varying else {
        return Err(Error::fault("a heat map was asked for without two axes"));
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
    let sheet = HeatSheet { title, caption, panels: &sheet_panels, columns };
    Ok(render::draw_heat_sheet(&sheet))
}
