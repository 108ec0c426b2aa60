//! The reading of scenes: each kind of file takes the options that mean something to it, and refuses the others.

use std::ffi::OsStr;
use std::path::Path;
use std::time::Instant;

use skyshed_request::{DataAreaChoice, GroundChoice, MissingHeights, SceneOptions};

use super::results::results_in;
use super::{Scene, SceneReader};
use crate::answer::RunFacts;
use crate::city::{BuiltUp, BuiltUpCity};
use crate::crs;
use crate::error::{Error, OddRun, RequestError, Result, Warning, warned};
use crate::formats::RasterFile;
use crate::los_probability::points::Points;
use crate::memory::{ANY_WORK, cells_of, check_bytes};
use crate::raster::{Crs, GeoRef};
use crate::read::{
    FootprintOptions, MeshOptions, Projection, Repair, SurfaceOptions, SystemSaid, VectorFormat, compare_vertical,
    read_footprints, read_footprints_and_repairs, read_mesh, read_mesh_buildings, read_surface, vertical_of,
};

/// The name of an option, and whether it is set.
type Set = (&'static str, bool);

impl SceneReader {
    /// Reads a scene and makes it ready for rays.
    ///
    /// `word` is the path of a file (raster, footprints or mesh, by its extension) or of a folder of raster tiles, or
    /// the word
    /// for a generated city: `itu:urban`, `itu:0.3,500,15`.
    ///
    /// # Errors
    /// E1xx for options that have no meaning for this kind of scene, or numbers out of range; E3xx for files that cannot be
    /// used; E501 for what does not fit in memory.
    pub fn open(&self, word: impl AsRef<OsStr>) -> Result<Scene> {
        let start = Instant::now();
        let mut warnings = Vec::new();
        let word = skyshed_io::told(word.as_ref());
        let read = self.read(&word, &mut warnings)?;
        Scene::built(self, (&word, read), warnings, start)
    }

    /// Reads a scene without making it ready.
    pub(crate) fn read(&self, word: &OsStr, warnings: &mut Vec<Warning>) -> Result<crate::city::City> {
        if let Some(built_up) = built_up(word) {
            return self.generate(word, built_up?);
        }
        if let Some((grid, bytes)) = self.size_of_raster(word) {
            check_bytes(&word.display(), &cells_of(&grid), bytes.saturating_add(ANY_WORK))?;
        }
        let path = Path::new(word);
        let read = warned(warnings, |odd| self.read_file(path, odd))?;
        self.warn_of_raster(path, warnings)?;
        Ok(read)
    }

    fn generate(&self, word: &OsStr, built_up: BuiltUp) -> Result<crate::city::City> {
        let city = self.city(built_up);
        self.refuse("a generated city", &self.of_footprints())?;
        self.refuse(
            "a generated city",
            &[
                ("terrain", self.options.terrain.is_some()),
                ("extent", self.options.extent.is_some()),
                ("crs", self.options.crs.is_some()),
                ("project", self.options.project.is_some()),
                ("building_threshold", self.options.building_threshold.is_some()),
                ("nodata_as", self.options.nodata_as.is_some()),
                ("band", self.options.band.is_some()),
            ],
        )?;
        if let Some(bytes) = city.memory() {
            check_bytes(&word.display(), "its buildings and cells", bytes)?;
        }
        // A stream that no kind of zone has.
        const OF_CELLS: u64 = 1 << 32;
        let drawn = self.draws_cells.then(|| Points::new(city.seed, OF_CELLS).next()).flatten();
        Ok(city.city_on_cells_from(drawn.map_or([0.0; 2], |[u, v, ..]| [u, v]))?)
    }

    /// A generated city of these options.
    pub(crate) fn city(&self, built_up: BuiltUp) -> BuiltUpCity {
        BuiltUpCity {
            built_up,
            size_m: self.city_edge_m(),
            margin_m: self.margin_m,
            cell_m: self.options.cell.unwrap_or(1.0),
            seed: self.options.seed_or_default(),
            ground_m: self.flat_ground_m().unwrap_or(0.0),
        }
    }

    /// Returns the edge of a generated city \[m\].
    pub(crate) fn city_edge_m(&self) -> f64 {
        self.options.size.unwrap_or(SceneOptions::SIZE_M)
    }

    /// Returns the reference system that was set for the files.
    ///
    /// # Errors
    /// E115 for a text that is no reference system.
    pub(crate) fn crs(&self) -> Result<Option<Crs>> {
        let parsed = self.options.crs.as_deref().map(crs::parse).transpose();
        parsed.map_err(|error| RequestError::NoSystem { option: "crs", error: Box::new(error) }.into())
    }

    /// Returns the reference system to bring a scene into.
    ///
    /// # Errors
    /// E115 for a text that is no reference system.
    fn projection(&self) -> Result<Option<Projection>> {
        let parsed = self.options.project.as_deref().map(Projection::parse).transpose();
        parsed.map_err(|error| RequestError::NoSystem { option: "project", error: Box::new(error) }.into())
    }

    /// Reads the scene of a file.
    fn read_file(&self, path: &Path, odd: &mut Vec<skyshed_io::Warning>) -> Result<crate::city::City> {
        let extension = extension_of(path);
        let Some(format) = VectorFormat::of_extension(&extension) else {
            if is_raster(path) {
                return Ok(read_surface(path, &self.of_raster()?, odd)?);
            }
            if self.options.roofs.is_some() {
                let of_features = [
                    ("layer", self.options.layer.is_some()),
                    ("levels_field", self.options.levels_field.is_some()),
                    ("missing", self.options.missing.is_some()),
                    ("parts", self.options.parts.is_some()),
                ];
                self.refuse("a mesh", &of_features)?;
                return Ok(read_mesh_buildings(path, &self.of_solids()?, odd)?);
            }
            let others = [("size", self.options.size.is_some()), ("project", self.options.project.is_some())];
            self.refuse("a mesh", &others)?;
            self.refuse("a mesh", &[("band", self.options.band.is_some())])?;
            self.refuse("a mesh", &self.of_footprints())?;
            let options =
                MeshOptions { surface: self.of_surface()?, extent: self.options.extent, cell_m: self.options.cell };
            return Ok(read_mesh(path, &options, odd)?);
        };
        if format != VectorFormat::GeoPackage {
            self.refuse("a file that is no GeoPackage", &[("layer", self.options.layer.is_some())])?;
        }
        let options = if self.options.roofs.is_some() { self.of_solids()? } else { self.of_vector()? };
        let Some(list) = &self.repairs else { return Ok(read_footprints(path, &options, odd)?) };
        let (scene, repairs) = read_footprints_and_repairs(path, &options, odd)?;
        // A scene that is read twice is the same.
        let _ = list.set(FoundRepairs { repairs, facts: facts_of(&scene, odd) });
        Ok(scene)
    }

    /// Warns of what else a raster says of its values than that they are heights, and of what these are above.
    pub(crate) fn warn_of_raster(&self, path: &Path, warnings: &mut Vec<Warning>) -> Result<()> {
        if !is_raster(path) {
            return Ok(());
        }
        if let Some(schema) = results_in(path) {
            warnings.push(OddRun::Results { path: path.display().to_string(), schema }.into());
        }
        let Some(terrain) = &self.options.terrain else { return Ok(()) };
        let said = if self.options.crs.is_some() { SystemSaid::ByUser } else { SystemSaid::ByFiles };
        let [of_scene, of_terrain] = [path, terrain].map(vertical_of);
        let (a, b) = ((path.display(), of_scene.as_ref()), (terrain.display(), of_terrain.as_ref()));
        Ok(warned(warnings, |odd| compare_vertical(a, b, said, odd))?)
    }

    /// The grid of a scene that is a raster in its own system, and the bytes that it takes in memory, by its header.
    /// What is
    /// wrong with the file is told where it is read.
    ///
    /// These are 5 for each cell, its height and what zone it may be of; what a terrain takes; and an unpacked strip or
    /// tile.
    pub(crate) fn size_of_raster(&self, word: &OsStr) -> Option<(GeoRef, u64)> {
        // What is brought into another system is put together in memory.
        if !is_raster_scene(word) || self.options.project.is_some() {
            return None;
        }
        let file = RasterFile::open(Path::new(word), &mut Vec::new()).ok()?;
        if file.is_empty() {
            return None;
        }
        let grid = self.grid_of(&file);
        let n_cells = grid.n_cells() as u64;
        // All of a terrain is read, and if it is on another grid brought to that of the surface.
        let below = self.options.terrain.as_deref().and_then(|path| RasterFile::open(path, &mut Vec::new()).ok());
        let of_terrain = below.map_or(0, |below| {
            let n_below = self.grid_of(&below).n_cells() as u64;
            let n_brought = if n_below == n_cells { 0 } else { n_cells };
            n_below.saturating_add(n_brought).saturating_mul(4).saturating_add(below.block_bytes())
        });
        let bytes = n_cells.saturating_mul(5).saturating_add(of_terrain).saturating_add(file.block_bytes());
        Some((grid, bytes))
    }

    /// The cells of a raster file that are read.
    pub(crate) fn grid_of(&self, file: &RasterFile) -> GeoRef {
        let grid = file.georef();
        self.around.map_or_else(|| grid.clone(), |around| grid.part(grid.window_within(around)))
    }

    /// How a raster is read.
    pub(crate) fn of_raster(&self) -> Result<SurfaceOptions> {
        self.refuse("a raster", &[("extent", self.options.extent.is_some()), ("size", self.options.size.is_some())])?;
        self.refuse("a raster", &self.of_footprints())?;
        if self.options.project.is_none() {
            self.refuse("a raster without `project`", &[("cell", self.options.cell.is_some())])?;
        }
        Ok(SurfaceOptions {
            project: self.projection()?,
            cell_m: self.options.cell,
            around: self.around,
            ..self.of_surface()?
        })
    }

    /// How any surface is read.
    fn of_surface(&self) -> Result<SurfaceOptions> {
        let defaults = SurfaceOptions::default();
        self.refuse("a surface", &[("ground buildings", self.options.ground == Some(GroundChoice::Buildings))])?;
        if self.options.terrain.is_none() && self.options.ground.is_none() {
            let threshold = [("building_threshold", self.options.building_threshold.is_some())];
            self.refuse("a surface without `terrain` or `ground`", &threshold)?;
        }
        Ok(SurfaceOptions {
            terrain: self.options.terrain.as_deref().map(Into::into),
            ground_m: self.flat_ground_m(),
            building_threshold_m: self.options.building_threshold.unwrap_or(defaults.building_threshold_m),
            nodata_as: self.options.nodata_as.unwrap_or_default(),
            band: self.options.band.clone().unwrap_or_default(),
            crs: self.crs()?,
            always_hash: self.options.hash,
            ..defaults
        })
    }

    /// How buildings are read whose heights are those of their surfaces.
    fn of_solids(&self) -> Result<FootprintOptions> {
        let of_properties = [
            ("height_field", self.options.height_field.is_some()),
            ("top_field", self.options.top_field.is_some()),
            ("height_unit", self.options.height_unit.is_some()),
        ];
        self.refuse("roofs of surfaces", &of_properties)?;
        self.of_vector()
    }

    /// How footprints are read.
    pub(super) fn of_vector(&self) -> Result<FootprintOptions> {
        let threshold = ("building_threshold", self.options.building_threshold.is_some());
        self.refuse(
            "footprints",
            &[("size", self.options.size.is_some()), threshold, ("band", self.options.band.is_some())],
        )?;
        if self.options.terrain.is_none() {
            let of_terrain = [("nodata_as", self.options.nodata_as.is_some()), ("base", self.options.base.is_some())];
            self.refuse("footprints without `terrain`", &of_terrain)?;
        }
        let is_known = self.options.terrain.is_some() || self.flat_ground_m().is_some();
        if is_known || !(self.options.top_field.is_some() || self.options.ground == Some(GroundChoice::Buildings)) {
            let of_base = [("base_field", self.options.base_field.is_some())];
            self.refuse("heights above a ground that is known otherwise", &of_base)?;
        }
        if !self.options.missing.as_ref().is_some_and(MissingHeights::counts_storeys) {
            let levels = [("levels_field", self.options.levels_field.is_some())];
            self.refuse("footprints without `missing levels`", &levels)?;
        }
        let missing = self.options.missing.clone().unwrap_or_default();
        // What is only told of refuses nothing.
        let missing = if self.tells_faults { missing.with_rest_dropped() } else { missing };
        Ok(FootprintOptions {
            height_field: self.options.height_field.clone(),
            top_field: self.options.top_field.clone(),
            height_unit: self.options.height_unit.unwrap_or_default(),
            base_field: self.options.base_field.clone(),
            levels_field: self.options.levels_field.clone(),
            height_error_field: self.options.height_error_field.clone(),
            roofs: self.options.roofs,
            missing,
            parts: self.options.parts.unwrap_or_default(),
            layer: self.options.layer.clone(),
            terrain: self.options.terrain.as_deref().map(Into::into),
            ground: self.options.ground,
            extent: self.options.extent,
            reach_m: self.reach_m,
            cell_m: self.options.cell,
            crs: self.crs()?,
            project: self.projection()?,
            nodata_as: self.options.nodata_as.unwrap_or_default(),
            base: self.options.base.unwrap_or_default(),
            data_area: self.options.data_area.clone().unwrap_or(DataAreaChoice::Auto),
            always_hash: self.options.hash,
        })
    }

    /// What only footprints can use.
    fn of_footprints(&self) -> [Set; 12] {
        [
            ("roofs", self.options.roofs.is_some()),
            ("height_field", self.options.height_field.is_some()),
            ("top_field", self.options.top_field.is_some()),
            ("height_unit", self.options.height_unit.is_some()),
            ("base_field", self.options.base_field.is_some()),
            ("levels_field", self.options.levels_field.is_some()),
            ("height_error_field", self.options.height_error_field.is_some()),
            ("missing", self.options.missing.is_some()),
            ("parts", self.options.parts.is_some()),
            ("layer", self.options.layer.is_some()),
            ("base", self.options.base.is_some()),
            ("data_area", self.options.data_area.is_some()),
        ]
    }

    /// An ignored input is an error, never silence.
    pub(super) fn refuse(&self, what: &str, without_meaning: &[Set]) -> Result<()> {
        match without_meaning.iter().find(|(_, is_set)| *is_set) {
            Some((name, _)) => Err(Error::idle(*name, format!("for {what}"))),
            None => Ok(()),
        }
    }
}

/// What was mended or left out of footprints, and what documents say of these.
#[derive(Debug, Clone)]
pub(crate) struct FoundRepairs {
    pub(crate) repairs: Vec<Repair>,
    pub(crate) facts: RunFacts,
}

/// What documents say of a scene that was read, whatever is done with it.
fn facts_of(scene: &crate::city::City, odd: &[skyshed_io::Warning]) -> RunFacts {
    RunFacts {
        command: Vec::new(),
        method: None,
        scene_name: scene.name.clone(),
        grid: scene.grid.clone(),
        sources: scene.sources.clone(),
        seed: None,
        warnings: odd.iter().cloned().map(Warning::Io).collect(),
        request: None,
        unit: None,
    }
}

/// The parameters of the generated city that a word stands for; `None` of a file.
pub(crate) fn built_up(word: &OsStr) -> Option<Result<BuiltUp>> {
    Some(BuiltUpCity::parse_built_up(word.to_str()?)?.map_err(Into::into))
}

/// The extension of a path in lower case.
fn extension_of(path: &Path) -> String {
    path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default()
}

/// Whether a scene of this name is read as a raster: any file that is neither footprints nor a mesh.
pub(crate) fn is_raster(path: &Path) -> bool {
    let extension = extension_of(path);
    VectorFormat::of_extension(&extension).is_none() && !["obj", "ply"].contains(&extension.as_str())
}

/// Whether a word stands for a raster.
pub(crate) fn is_raster_scene(word: &OsStr) -> bool {
    built_up(word).is_none() && is_raster(Path::new(word))
}
