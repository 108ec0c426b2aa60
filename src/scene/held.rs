//! Scenes of what the caller holds in memory, and scenes as bytes.

use std::ffi::OsStr;
use std::time::Instant;

use skyshed_live::pack::{PackedCity, pack, unpack};

use super::{Scene, SceneOptions};
use crate::city::City;
use crate::crs;
use crate::error::{Error, Result, warned};
use crate::read::{HeldBuilding, HeldHeights, footprints_of, surface_of};

impl SceneOptions {
    /// Makes a scene of heights in memory ready for rays: a surface model, and the terrain below it if that is held, too.
    ///
    /// # Errors
    /// E1xx for options that have no meaning for it; E3xx for heights that cannot be used; E501.
    pub fn of_heights(&self, name: &str, surface: HeldHeights, terrain: Option<HeldHeights>) -> Result<Scene> {
        self.refuse("heights in memory", &[("project", self.project.is_some())])?;
        self.refuse("heights over a terrain", &[("ground_m", self.ground_m.is_some() && terrain.is_some())])?;
        let (start, mut warnings) = (Instant::now(), Vec::new());
        let options = self.of_raster()?;
        let city = warned(&mut warnings, |odd| surface_of(surface, terrain, &options, odd))?;
        Scene::built(self, (OsStr::new(name), city), warnings, start)
    }

    /// Makes a scene of buildings in memory ready for rays.
    ///
    /// # Errors
    /// E1xx for options that have no meaning for it; E3xx for buildings that cannot be used; E501.
    pub fn of_buildings(&self, name: &str, buildings: &[HeldBuilding<'_>]) -> Result<Scene> {
        self.refuse("buildings in memory", &[("layer", self.layer.is_some())])?;
        let (start, mut warnings) = (Instant::now(), Vec::new());
        let options = self.of_vector()?;
        let city = warned(&mut warnings, |odd| footprints_of(name, buildings, &options, odd))?;
        Scene::built(self, (OsStr::new(name), city), warnings, start)
    }
}

impl Scene {
    /// What it was built from, as bytes for [`Scene::unpacked`]; `None` of footprints that were not kept.
    pub fn packed(&self) -> Option<Vec<u8>> {
        Some(pack(self.grid(), &*self.solids()?, None))
    }

    /// The scene of such bytes, of the reference system that its text (EPSG:n or WKT) names.
    ///
    /// # Errors
    /// E115 for a text that is no reference system; E902 for other bytes.
    pub fn unpacked(name: &str, bytes: &[u8], crs: Option<&str>) -> Result<Scene> {
        let start = Instant::now();
        let PackedCity { grid, solids, .. } =
            unpack(bytes).map_err(|_| Error::Fault("these bytes are no packed scene"))?;
        let crs = crs.map(crs::parse).transpose()?;
        let city = City {
            name: name.into(),
            grid: grid.with_crs(crs),
            solids,
            built_up: None,
            sources: Vec::new(),
            attribution: None,
            height_gap: None,
        };
        let options = SceneOptions::default().keeps_footprints();
        Scene::built(&options, (OsStr::new(name), city), Vec::new(), start)
    }
}
