//! Options of how a scene is read, each with its setter.

use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

use super::reading::FoundRepairs;
use crate::city::NodataAs;
use crate::formats::Band;
use crate::raster::Crs;
use crate::read::{BaseRule, DataAreaChoice, GroundChoice, HeightUnit, MissingHeights, Parts, Projection, Roofs};

/// How a scene is read; what is not set is as the program does it. What has no meaning for the kind of the scene is an
/// error.
#[derive(Debug, Clone, Default)]
pub struct SceneOptions {
    pub(crate) terrain: Option<PathBuf>,
    pub(crate) ground: Option<GroundChoice>,
    pub(crate) building_threshold_m: Option<f64>,
    pub(crate) height_field: Option<String>,
    pub(crate) top_field: Option<String>,
    pub(crate) height_unit: Option<HeightUnit>,
    pub(crate) base_field: Option<String>,
    pub(crate) levels_field: Option<String>,
    pub(crate) height_error_field: Option<String>,
    pub(crate) roofs: Option<Roofs>,
    pub(crate) layer: Option<String>,
    pub(crate) missing: Option<MissingHeights>,
    pub(crate) parts: Option<Parts>,
    pub(crate) base: Option<BaseRule>,
    pub(crate) data_area: Option<DataAreaChoice>,
    pub(crate) extent: Option<[f64; 4]>,
    pub(crate) cell_m: Option<f64>,
    pub(crate) crs: Option<Crs>,
    pub(crate) project: Option<Projection>,
    pub(crate) size_m: Option<f64>,
    pub(crate) margin_m: f64,
    /// Whether the cells of a generated city begin at a place that is drawn with its heights.
    pub(crate) draws_cells: bool,
    pub(crate) seed: Option<u64>,
    pub(crate) nodata_as: Option<NodataAs>,
    pub(crate) band: Option<Band>,
    pub(crate) hash: bool,
    /// Whether the solids are kept as they were read, for a live page, if that can hold them.
    pub(crate) keeps_solids: bool,
    /// The box of a raster that is read: west, south, east, north \[CRS units\]; all of it without one.
    pub(crate) around: Option<[f64; 4]>,
    /// How far from the extent a footprint can matter at most \[m\].
    pub(crate) reach_m: Option<f64>,
    /// Whether what is wrong with footprints is told where the program would refuse them.
    pub(crate) tells_faults: bool,
    /// Where what was mended or left out is listed.
    pub(crate) repairs: Option<Arc<OnceLock<FoundRepairs>>>,
}

impl SceneOptions {
    /// A terrain model below the surface model or the footprints: a raster file, or a folder of tiles.
    #[must_use]
    pub fn terrain(self, path: impl Into<PathBuf>) -> Self {
        SceneOptions { terrain: Some(path.into()), ..self }
    }

    /// Flat ground at this height above the datum \[m\]. Default: 0 for footprints and generated cities; for tops above the
    /// datum the median base of the buildings.
    #[must_use]
    pub fn ground_m(self, height_m: f64) -> Self {
        SceneOptions { ground: Some(GroundChoice::Flat(height_m)), ..self }
    }

    /// A terrain through the ground below buildings, as their file tells it.
    #[must_use]
    pub fn ground_of_buildings(self) -> Self {
        SceneOptions { ground: Some(GroundChoice::Buildings), ..self }
    }

    /// A cell whose surface is more than this above the ground is a building \[m\]. Default: 0.25.
    #[must_use]
    pub fn building_threshold_m(self, height_m: f64) -> Self {
        SceneOptions { building_threshold_m: Some(height_m), ..self }
    }

    /// The property that holds a footprint's height above ground. Default: `height`; of CityJSON the highest point.
    #[must_use]
    pub fn height_field(self, name: impl Into<String>) -> Self {
        SceneOptions { height_field: Some(name.into()), ..self }
    }

    /// The property that holds the height of a footprint's top above the datum, instead.
    #[must_use]
    pub fn top_field(self, name: impl Into<String>) -> Self {
        SceneOptions { top_field: Some(name.into()), ..self }
    }

    /// The unit of heights of footprints that name none. Default: meters.
    #[must_use]
    pub fn height_unit(self, unit: HeightUnit) -> Self {
        SceneOptions { height_unit: Some(unit), ..self }
    }

    /// The property that holds the ground below a building \[m above the datum\], for tops above the datum and
    /// [`SceneOptions::ground_of_buildings`]. Default: the first of `b3_h_maaiveld`, `ground_height`, `z_ground`, `h_ground`, `ground`.
    #[must_use]
    pub fn base_field(self, name: impl Into<String>) -> Self {
        SceneOptions { base_field: Some(name.into()), ..self }
    }

    /// The property that holds the number of storeys, for [`HeightRule::Levels`](crate::read::HeightRule::Levels). Default: the first
    /// of `building:levels`, `num_floors`, `storeysAboveGround`, `numberOfFloorsAboveGround` that a feature has.
    #[must_use]
    pub fn levels_field(self, name: impl Into<String>) -> Self {
        SceneOptions { levels_field: Some(name.into()), ..self }
    }

    /// The property that holds the standard deviation of the error of a footprint's height \[m\]. Default: none.
    pub fn height_error_field(self, name: impl Into<String>) -> Self {
        SceneOptions { height_error_field: Some(name.into()), ..self }
    }

    /// The shape of roofs of CityJSON; of a mesh, it is read as buildings then. Default: flat, and a mesh is a surface model.
    #[must_use]
    pub fn roofs(self, shape: Roofs) -> Self {
        SceneOptions { roofs: Some(shape), ..self }
    }

    /// The table of a GeoPackage; needed where it has several.
    #[must_use]
    pub fn layer(self, name: impl Into<String>) -> Self {
        SceneOptions { layer: Some(name.into()), ..self }
    }

    /// What becomes of footprints without a usable height. Default: left out up to 2 % of the footprint area, E309 above.
    #[must_use]
    pub fn missing(self, rules: MissingHeights) -> Self {
        SceneOptions { missing: Some(rules), ..self }
    }

    /// What becomes of outlines whose buildings are drawn by parts as well. Default: the parts stand in their place.
    #[must_use]
    pub fn parts(self, rule: Parts) -> Self {
        SceneOptions { parts: Some(rule), ..self }
    }

    /// Which of the terrain cells below a footprint its height is above. Default: the lowest.
    #[must_use]
    pub fn base(self, rule: BaseRule) -> Self {
        SceneOptions { base: Some(rule), ..self }
    }

    /// Where the ground is known. Default: within 100 m of footprints, holes filled; everywhere if an extent is set.
    #[must_use]
    pub fn data_area(self, choice: DataAreaChoice) -> Self {
        SceneOptions { data_area: Some(choice), ..self }
    }

    /// The extent of the grid over footprints or a mesh \[CRS units\]. Default: that of the data.
    #[must_use]
    pub fn extent(self, [west, south, east, north]: [f64; 4]) -> Self {
        SceneOptions { extent: Some([west, south, east, north]), ..self }
    }

    /// The cell size of the grid over footprints, a mesh or a generated city \[m\]. Default: 1, or that of the terrain.
    #[must_use]
    pub fn cell_m(self, size_m: f64) -> Self {
        SceneOptions { cell_m: Some(size_m), ..self }
    }

    /// The reference system of the scene, where its files name none or a wrong one.
    #[must_use]
    pub fn crs(self, crs: Crs) -> Self {
        SceneOptions { crs: Some(crs), ..self }
    }

    /// The reference system to bring footprints or a raster into.
    #[must_use]
    pub fn project(self, to: Projection) -> Self {
        SceneOptions { project: Some(to), ..self }
    }

    /// The edge length of a generated city \[m\]. Default: 1000.
    #[must_use]
    pub fn size_m(self, edge_m: f64) -> Self {
        SceneOptions { size_m: Some(edge_m), ..self }
    }

    /// The seed of a generated city. Default: 1.
    #[must_use]
    pub fn seed(self, seed: u64) -> Self {
        SceneOptions { seed: Some(seed), ..self }
    }

    /// What nodata cells do to links. Default: they block nothing.
    #[must_use]
    pub fn nodata_as(self, does: NodataAs) -> Self {
        SceneOptions { nodata_as: Some(does), ..self }
    }

    /// The band of a raster that holds its heights. Default: the first.
    #[must_use]
    pub fn band(self, band: Band) -> Self {
        SceneOptions { band: Some(band), ..self }
    }

    /// Keeps footprints as they were read, for [`Scene::live_page`] and [`Scene::packed`].
    #[must_use]
    pub fn keeps_footprints(self) -> Self {
        SceneOptions { keeps_solids: true, ..self }
    }
}
