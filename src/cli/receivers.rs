//! Receivers as typed: what maps are made for them, and what captions call them.

use super::args::{EngineArgs, ReceiversArg};
use super::plan::Ready;
use crate::coverage::{HeightLayers, MapOptions, Receivers, SiteCoverage};
use crate::error::{Error, Result, Warning};
use crate::height_field::HeightField;
use crate::los::Method;
use crate::quantity::tidy;
use crate::raster::{Crs, GeoRef};
use crate::zones::ZoneMap;

/// Roofs and zones are known only where buildings are.
pub(super) fn check_receivers(receivers: ReceiversArg, field: &HeightField) -> Result<()> {
    if field.is_surface_only() { check_surface_receivers(receivers) } else { Ok(()) }
}

/// The receivers that a surface model alone has.
pub(super) fn check_surface_receivers(receivers: ReceiversArg) -> Result<()> {
    if receivers == ReceiversArg::Roof || receivers.zone().is_some() {
        let what = if receivers == ReceiversArg::Roof { "roof" } else { "zone" };
        let text = format!("`--receivers {}` with a surface model alone: no {what} is known", receivers.name());
        return Err(Error::usage(117, text).with_hint("give `--terrain FILE` or `--ground Z`"));
    }
    Ok(())
}

/// For whom a map is made.
#[derive(Debug, Clone, Copy)]
pub(super) struct Asked<'a> {
    /// Which cells hold receivers.
    pub(super) receivers: ReceiversArg,
    /// Their height above what they stand on \[1/1024 m\].
    pub(super) rx_height: i32,
    /// Range \[CRS units\], if it is limited.
    pub(super) radius: Option<f64>,
    /// The engine that was typed.
    pub(super) engine: &'a EngineArgs,
}

impl Asked<'_> {
    /// The options of a map without layers of heights.
    pub(super) fn options(&self, grid: &GeoRef, zones: Option<&ZoneMap>) -> MapOptions {
        MapOptions {
            rx_height: self.rx_height,
            receivers: match self.receivers {
                ReceiversArg::Roof => Receivers::Roof,
                ReceiversArg::All => Receivers::All,
                _ => Receivers::Ground,
            },
            within: self.receivers.zone().and_then(|zone| zones.map(|zones| zones.cells(zone))),
            radius: self.radius,
            meters_per_unit: grid.meters_per_unit(),
            layers: HeightLayers::default(),
            method: self.engine.method,
        }
    }
}

/// W202 for each UAV that has no receiver.
pub(super) fn warn_of_no_receivers(coverages: &[SiteCoverage], warnings: &mut Vec<Warning>) {
    for site in coverages.iter().filter(|site| site.tally.receivers == 0) {
        let text = format!("UAV `{}` has no receiver: {}; P_LoS is undefined", site.uav.id, site.tally.reason());
        warnings.push(Warning::new(202, text));
    }
}

/// What receivers, and the cells that hold none, are called in the plural.
pub(super) fn cell_names(receivers: ReceiversArg, field: &HeightField) -> (&'static str, &'static str) {
    match receivers {
        _ if field.is_surface_only() => ("surface cells", "Nodata"),
        ReceiversArg::Ground => ("open-ground cells", "Buildings"),
        ReceiversArg::Street => ("street cells", "Other cells"),
        ReceiversArg::Crossroad => ("crossroad cells", "Other cells"),
        ReceiversArg::Courtyard => ("courtyard cells", "Other cells"),
        ReceiversArg::Roof => ("roof cells", "Open ground"),
        ReceiversArg::All => ("cells", "Nodata"),
    }
}

/// The line of a caption that says for whom a map was made, and how.
pub(super) fn setting_line(
    scene: &Ready,
    receivers: ReceiversArg,
    heights: (f64, Option<f64>),
    method: Option<Method>,
) -> String {
    setting_line_on(scene.field.grid(), scene, receivers, heights, method)
}

/// The same for a map on a grid of which the scene shows less.
pub(super) fn setting_line_on(
    grid: &GeoRef,
    scene: &Ready,
    receivers: ReceiversArg,
    (rx_height_m, radius_m): (f64, Option<f64>),
    method: Option<Method>,
) -> String {
    let unit = grid.meters_per_unit();
    let (width, height) = (grid.cell_width() * unit, grid.cell_height() * unit);
    let cell = if (width - height).abs() < 1e-9 * width {
        format!("{} m", tidy(width))
    } else {
        format!("{} × {} m", tidy(width), tidy(height))
    };
    let stands = match receivers {
        _ if scene.field.is_surface_only() => "the surface",
        ReceiversArg::Roof => "roofs",
        ReceiversArg::All => "ground and roofs",
        _ => "ground",
    };
    let crs = grid.crs().map_or("local coordinates".to_string(), Crs::label);
    let range = radius_m.map_or(String::new(), |r| format!(", range {} m", tidy(r)));
    let method = method.map_or("none".into(), Method::in_words);
    format!(
        "Cells of {cell}, receivers {} m above {stands}{range}; method {method}; {crs}; skyshed {}",
        tidy(rx_height_m),
        env!("CARGO_PKG_VERSION")
    )
}
