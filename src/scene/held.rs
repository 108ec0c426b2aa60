//! Scenes built from data in memory, and scenes as bytes.

use std::ffi::OsStr;
use std::time::Instant;

use skyshed_live::pack::{PackedCity, pack, unpack};

use super::{Scene, SceneReader};
use crate::city::City;
use crate::crs;
use crate::error::{Error, Result, warned};
use crate::read::{HeldBuilding, HeldHeights, footprints_of, surface_of};
use skyshed_request::MissingHeights;

impl SceneReader {
    /// Builds a scene from heights in memory: a surface model, and optionally the terrain below it.
    ///
    /// ```
    /// use skyshed::prelude::*;
    /// use skyshed::{GeoRef, HeldHeights};
    ///
    /// let georef = GeoRef::new((0.0, 50.0), (1.0, 1.0), (50, 60), None).expect("a grid");
    /// // A wall of 9 m from north to south, on flat ground.
    /// let heights = HeldHeights::new("a wall", georef, |_, heights| {
    ///     heights.fill(0.0);
    ///     heights[30] = 9.0;
    ///     true
    /// })?;
    /// let scene = Scene::options().ground(0.0).of_heights("a wall", heights, None)?;
    /// let seen = scene.coverage(Uav::new(10.5, 25.5, Height::agl(5.0))).rx_height(0.0).run()?;
    /// // All before the wall is seen, and nothing behind it.
    /// assert!((seen.receivers(), seen.tally().los) == (50 * 59, 50 * 30));
    /// # Ok::<(), skyshed::Error>(())
    /// ```
    ///
    /// # Errors
    /// E1xx for options that do not apply; E3xx for heights that cannot be used; E501.
    pub fn of_heights(&self, name: &str, surface: HeldHeights, terrain: Option<HeldHeights>) -> Result<Scene> {
        self.refuse("heights in memory", &[("band", self.options.band.is_some())])?;
        self.refuse("heights over a terrain", &[("ground", self.options.ground.is_some() && terrain.is_some())])?;
        let (start, mut warnings) = (Instant::now(), Vec::new());
        let options = self.of_raster()?;
        let city = warned(&mut warnings, |odd| surface_of(surface, terrain, &options, odd))?;
        Scene::built(self, (OsStr::new(name), city), warnings, start)
    }

    /// Builds a scene from buildings in memory.
    ///
    /// # Errors
    /// E1xx for options that do not apply; E3xx for buildings that cannot be used; E501.
    pub fn of_buildings(&self, name: &str, buildings: &[HeldBuilding<'_>]) -> Result<Scene> {
        // A building in memory has a height and no other property.
        let of_files = [
            ("roofs", self.options.roofs.is_some()),
            ("layer", self.options.layer.is_some()),
            ("levels_field", self.options.levels_field.is_some()),
            ("height_error_field", self.options.height_error_field.is_some()),
            ("base_field", self.options.base_field.is_some()),
            ("parts", self.options.parts.is_some()),
            ("missing levels", self.options.missing.as_ref().is_some_and(MissingHeights::counts_storeys)),
        ];
        self.refuse("buildings in memory", &of_files)?;
        let (start, mut warnings) = (Instant::now(), Vec::new());
        let options = self.of_vector()?;
        let city = warned(&mut warnings, |odd| footprints_of(name, buildings, &options, odd))?;
        Scene::built(self, (OsStr::new(name), city), warnings, start)
    }
}

impl Scene {
    /// Returns the data that the scene was built from, as bytes for [`Scene::unpacked`]. `None` for
    /// footprints that were not kept.
    pub fn packed(&self) -> Option<Vec<u8>> {
        Some(pack(self.grid(), &*self.solids()?, None))
    }

    /// Builds a scene from bytes of [`Scene::packed`]. `crs` names its reference system (EPSG:n or
    /// WKT).
    ///
    /// # Errors
    /// E115 for a text that is no reference system; E902 for other bytes.
    pub fn unpacked(name: &str, bytes: &[u8], crs: Option<&str>) -> Result<Scene> {
        let start = Instant::now();
        let PackedCity { grid, solids, .. } =
            unpack(bytes).map_err(|_| Error::fault("these bytes are no packed scene"))?;
        // The bytes hold the length of a unit where the scene lies.
        let unit = grid.meters_per_unit();
        let crs = crs.map(crs::parse).transpose()?.map(|crs| crs.with_true_meters_per_unit(unit));
        let city = City {
            name: name.into(),
            grid: grid.with_crs(crs),
            solids,
            built_up: None,
            sources: Vec::new(),
            attribution: None,
            heights: None,
        };
        let options = SceneReader::default().keeps_footprints();
        Scene::built(&options, (OsStr::new(name), city), Vec::new(), start)
    }
}
