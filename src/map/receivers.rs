//! Which cells hold receivers: what maps are made for them, and what captions call them.

use clap::ValueEnum;

use crate::coverage::{self, HeightLayers, MapOptions, SiteCoverage};
use crate::error::{Error, Result, Warning};
use crate::height_field::HeightField;
use crate::los::{Method, MethodChoice};
use crate::quantity::tidy;
use crate::raster::{Crs, GeoRef};
use crate::scene::Scene;
use crate::zones::{Zone, ZoneMap};

/// Which cells hold receivers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum Receivers {
    /// All cells of open ground
    #[default]
    Ground,
    /// Open ground that is neither crossroad nor courtyard
    Street,
    /// Where three or more streets meet
    Crossroad,
    /// Open ground that buildings enclose
    Courtyard,
    /// Building cells, standing on the roof
    Roof,
    /// Ground and roofs
    All,
}

impl Receivers {
    /// As it is typed.
    pub fn name(self) -> &'static str {
        match self {
            Receivers::Ground => "ground",
            Receivers::Street => "street",
            Receivers::Crossroad => "crossroad",
            Receivers::Courtyard => "courtyard",
            Receivers::Roof => "roof",
            Receivers::All => "all",
        }
    }

    /// The zone that it restricts open ground to, if it does.
    pub(crate) fn zone(self) -> Option<Zone> {
        match self {
            Receivers::Street => Some(Zone::Street),
            Receivers::Crossroad => Some(Zone::Crossroad),
            Receivers::Courtyard => Some(Zone::Courtyard),
            Receivers::Ground | Receivers::Roof | Receivers::All => None,
        }
    }
}

/// Roofs and zones are known only where buildings are.
pub(crate) fn check_receivers(receivers: Receivers, field: &HeightField) -> Result<()> {
    if field.is_surface_only() { check_surface_receivers(receivers) } else { Ok(()) }
}

/// The receivers that a surface model alone has.
pub(crate) fn check_surface_receivers(receivers: Receivers) -> Result<()> {
    if receivers == Receivers::Roof || receivers.zone().is_some() {
        let what = if receivers == Receivers::Roof { "roof" } else { "zone" };
        let text = format!("`--receivers {}` with a surface model alone: no {what} is known", receivers.name());
        return Err(Error::usage(117, text).with_hint("give `--terrain FILE` or `--ground Z`"));
    }
    Ok(())
}

/// For whom a map is made.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Asked {
    /// Which cells hold receivers.
    pub(crate) receivers: Receivers,
    /// Their height above what they stand on \[1/1024 m\].
    pub(crate) rx_height: i32,
    /// Range \[CRS units\], if it is limited.
    pub(crate) radius: Option<f64>,
    /// The engine that was asked for.
    pub(crate) method: MethodChoice,
}

impl Asked {
    /// The options of a map without layers of heights.
    pub(crate) fn options(&self, grid: &GeoRef, zones: Option<&ZoneMap>) -> MapOptions {
        MapOptions {
            rx_height: self.rx_height,
            receivers: match self.receivers {
                Receivers::Roof => coverage::Receivers::Roof,
                Receivers::All => coverage::Receivers::All,
                _ => coverage::Receivers::Ground,
            },
            within: self.receivers.zone().and_then(|zone| zones.map(|zones| zones.cells(zone))),
            radius: self.radius,
            meters_per_unit: grid.meters_per_unit(),
            layers: HeightLayers::default(),
            method: self.method,
        }
    }
}

/// W202 for each UAV that has no receiver.
pub(crate) fn warn_of_no_receivers(coverages: &[SiteCoverage], warnings: &mut Vec<Warning>) {
    for site in coverages.iter().filter(|site| site.tally.receivers == 0) {
        let text = format!("UAV `{}` has no receiver: {}; P_LoS is undefined", site.uav.id, site.tally.reason());
        warnings.push(Warning::new(202, text));
    }
}

/// What receivers, and the cells that hold none, are called in the plural.
pub(crate) fn cell_names(receivers: Receivers, field: &HeightField) -> (&'static str, &'static str) {
    match receivers {
        _ if field.is_surface_only() => ("surface cells", "Nodata"),
        Receivers::Ground => ("open-ground cells", "Buildings"),
        Receivers::Street => ("street cells", "Other cells"),
        Receivers::Crossroad => ("crossroad cells", "Other cells"),
        Receivers::Courtyard => ("courtyard cells", "Other cells"),
        Receivers::Roof => ("roof cells", "Open ground"),
        Receivers::All => ("cells", "Nodata"),
    }
}

/// The line of a caption that says for whom a map was made, and how.
pub(crate) fn setting_line(
    scene: &Scene,
    receivers: Receivers,
    heights: (f64, Option<f64>),
    method: Option<Method>,
) -> String {
    setting_line_on(scene.field.grid(), scene, receivers, heights, method)
}

/// The same for a map on a grid of which the scene shows less.
pub(crate) fn setting_line_on(
    grid: &GeoRef,
    scene: &Scene,
    receivers: Receivers,
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
        Receivers::Roof => "roofs",
        Receivers::All => "ground and roofs",
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
