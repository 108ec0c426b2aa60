//! Part of a scene that is wanted of its files.

use crate::crs::{self, Transformation};
use crate::formats::bounds_through;
use crate::raster::{Crs, CrsKind, GeoRef};

/// Wanted part of a file.
#[derive(Debug, Clone, Copy, Default)]
pub(in crate::read) struct Selection<'a> {
    /// Table of a GeoPackage.
    #[cfg_attr(not(feature = "geopackage"), expect(dead_code, reason = "no other format has tables"))]
    pub(in crate::read) layer: Option<&'a str>,
    /// Features beyond need not be read.
    pub(in crate::read) within: Option<Within<'a>>,
    /// `true` where x and y stand in the other order than a reader finds.
    pub(in crate::read) swap_axes: bool,
}

/// Box in which features can matter.
#[derive(Debug, Clone, Copy)]
pub(in crate::read) struct Within<'a> {
    /// West, south, east, north \[units of the scene\].
    pub(in crate::read) bounds: [f64; 4],
    /// System of the scene, where it is not that of its files.
    pub(in crate::read) of_scene: Option<&'a Crs>,
    /// System that counts instead of that of the files.
    pub(in crate::read) of_files: Option<&'a Crs>,
}

impl Selection<'_> {
    /// Returns the box in units of a file that names some system; `None` where all of it may
    /// matter.
    pub(super) fn bounds_in(&self, named: Option<&Crs>) -> Option<[f64; 4]> {
        let [west, south, east, north] = self.within?.in_file(named)?;
        Some(if self.swap_axes { [south, west, north, east] } else { [west, south, east, north] })
    }
}

impl Within<'_> {
    fn in_file(&self, named: Option<&Crs>) -> Option<[f64; 4]> {
        let Some(of_scene) = self.of_scene else { return Some(self.bounds) };
        let of_file = match self.of_files.or(named) {
            Some(crs) => crs.clone(),
            // Positions without a system are taken for degrees where a scene is projected.
            None => crs::from_epsg(4326).ok()?,
        };
        if of_file.same_as(of_scene) {
            return Some(self.bounds);
        }
        let [west, south, east, north] = self.bounds;
        let middle = (f64::midpoint(west, east), f64::midpoint(south, north));
        let way = Transformation::new(of_scene, &of_file, middle).ok()?;
        let cell = GeoRef::new((west, north), (east - west, north - south), (1, 1), None)?;
        let [west, south, east, north] = bounds_through(&cell, &way).ok()?;
        // A side bends little between the points that were transformed.
        let margin = 0.01 * (east - west).max(north - south);
        let grown = [west - margin, south - margin, east + margin, north + margin];
        let is_across_180_degrees =
            matches!(of_file.kind(), CrsKind::Geographic) && (east - west > 180.0 || west < -180.0 || east > 180.0);
        (grown.iter().all(|v| v.is_finite()) && !is_across_180_degrees).then_some(grown)
    }
}

/// Returns `true` when two boxes west, south, east, north meet.
pub(super) fn meets(a: [f64; 4], b: [f64; 4]) -> bool {
    a[0] <= b[2] && b[0] <= a[2] && a[1] <= b[3] && b[1] <= a[3]
}
