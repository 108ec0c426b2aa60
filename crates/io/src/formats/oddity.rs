//! What is odd about the headers of rasters: a mosaic and a scene know better than some of it.

use std::fmt::Display;

use crate::crs::{Transformation, from_epsg, is_web_mercator, utm_for};
use crate::error::{OddRaster, Oddity, Result, Warning};
use crate::raster::GeoRef;

impl OddRaster {
    /// That a grid is in web Mercator, if it is, with the zone of UTM that its middle lies in.
    pub(super) fn of_web_mercator(grid: &GeoRef) -> Option<OddRaster> {
        let crs = grid.crs().filter(|crs| is_web_mercator(crs))?;
        let (x, y) = ((grid.x_min() + grid.x_max()) / 2.0, (grid.y_min() + grid.y_max()) / 2.0);
        let wgs84 = from_epsg(4326).ok()?;
        let (lon, lat) = Transformation::new(crs, &wgs84, (x, y)).ok()?.apply((x, y)).ok()?;
        Some(OddRaster::WebMercator { utm_epsg: utm_for(lon, lat) })
    }

    /// Whether it is about the reference system, so that another one settles it.
    pub(crate) fn is_of_crs(&self) -> bool {
        matches!(self.number(), 325 | 326 | 331)
    }

    /// Whether it is about the place or the unit, so that those of a virtual raster settle it.
    pub(super) fn is_of_place(&self) -> bool {
        self.is_of_crs() || matches!(self, OddRaster::NoPlace | OddRaster::Unit(_))
    }
}

impl Oddity {
    /// Whether it is that the raster is in web Mercator.
    pub(crate) fn is_web_mercator(&self) -> bool {
        matches!(self.odd, OddRaster::WebMercator { .. })
    }

    pub(super) fn new(name: impl Display, odd: OddRaster) -> Oddity {
        Oddity { name: name.to_string(), odd, n_more: 0 }
    }
}

/// What is odd about many tiles, each kind once.
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

/// Opens something, and warns of what is odd about it.
pub(super) fn warned<T>(warnings: &mut Vec<Warning>, open: impl FnOnce(&mut Vec<Oddity>) -> Result<T>) -> Result<T> {
    let mut odd = Vec::new();
    let opened = open(&mut odd);
    warnings.extend(odd.into_iter().map(Warning::from));
    opened
}
