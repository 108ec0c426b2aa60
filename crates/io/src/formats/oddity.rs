//! Oddities of the headers of rasters. Mosaics and scenes override some of them.

use std::fmt::Display;

use crate::crs::Stretch;
use crate::error::{OddRaster, Oddity, Result, Warning};
use crate::raster::GeoRef;

/// Gives a grid in web Mercator the true length of its unit in its middle, and reports that; other
/// grids stay.
pub(crate) fn with_true_lengths(grid: GeoRef, tell: &mut impl FnMut(OddRaster)) -> GeoRef {
    let bounds = [grid.x_min(), grid.y_min(), grid.x_max(), grid.y_max()];
    let Some((crs, stretch)) = grid.crs().and_then(|crs| Some((crs.clone(), Stretch::of(crs, bounds)?))) else {
        return grid;
    };
    tell(stretch.into());
    grid.with_crs(Some(stretch.apply(crs)))
}

impl From<Stretch> for OddRaster {
    fn from(stretch: Stretch) -> OddRaster {
        let Stretch { meters_per_unit, lat, largest_error, utm_epsg } = stretch;
        OddRaster::WebMercator { meters_per_unit, lat, largest_error, utm_epsg }
    }
}

impl OddRaster {
    /// Returns `true` when it concerns the reference system, so that another one settles it.
    pub(crate) fn is_of_crs(&self) -> bool {
        matches!(self.number(), 325 | 326 | 331)
    }

    /// Returns `true` when it concerns the place or the unit, so that those of a virtual raster
    /// settle it.
    pub(super) fn is_of_place(&self) -> bool {
        self.is_of_crs() || matches!(self, OddRaster::NoPlace | OddRaster::Unit(_))
    }
}

impl Oddity {
    /// Returns `true` when the raster is in web Mercator.
    pub(crate) fn is_web_mercator(&self) -> bool {
        matches!(self.odd, OddRaster::WebMercator { .. })
    }

    pub(crate) fn new(name: impl Display, odd: OddRaster) -> Oddity {
        Oddity { name: name.to_string(), odd, n_more: 0 }
    }
}

/// Returns the oddities of many tiles, each kind once.
pub(super) fn each_once(all: impl Iterator<Item = Oddity>) -> Vec<Oddity> {
    let mut kinds: Vec<Oddity> = Vec::new();
    for oddity in all {
        match kinds.iter_mut().find(|first| first.odd.number() == oddity.odd.number()) {
            Some(first) => first.n_more += 1,
            None => kinds.push(oddity),
        }
    }
    kinds
}

/// Opens something, and warns of its oddities.
pub(super) fn warned<T>(warnings: &mut Vec<Warning>, open: impl FnOnce(&mut Vec<Oddity>) -> Result<T>) -> Result<T> {
    let mut odd = Vec::new();
    let opened = open(&mut odd);
    warnings.extend(odd.into_iter().map(Warning::from));
    opened
}
