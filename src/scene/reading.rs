//! Reading of scenes. Each kind of file takes the options that apply to it, and refuses the others.

use std::ffi::OsStr;
use std::path::Path;
use std::time::Instant;

use skyshed_request::{DataAreaChoice, GroundChoice, MissingHeights, SceneOptions};

use super::results::results_in;
use super::{Scene, SceneReader};
use crate::answer::{CommandFacts, RunFacts};
use crate::city::{BuiltUp, BuiltUpCity};
use crate::crs;
use crate::error::{Error, OddRun, RequestError, Result, Warning, warned};
use crate::formats::RasterFile;
use crate::los_probability::points::Points;
use crate::memory::{ANY_WORK, bytes_of_cells, cells_of, check_bytes};
use crate::raster::{Crs, GeoRef};
use crate::read::{
    FootprintOptions, MeshOptions, PointCloudOptions, Projection, Repair, SceneFiles, SurfaceOptions, SystemSaid,
    compare_vertical, named_files, read_footprints, read_footprints_and_repairs, read_mesh, read_mesh_buildings,
    read_point_cloud, read_surface, vertical_of,
};
use skyshed_io::{FileFormat, FileKind};

/// Name of an option, and `true` if it is set.
type Set = (&'static str, bool);

impl SceneReader {
    /// Reads a scene and prepares it for line of sight.
    ///
    /// `word` is a path or the word for a generated city. A path names a file (raster, footprints
    /// or mesh, by its extension) or a folder of raster tiles. Words for generated cities are
    /// `itu:urban` or `itu:0.3,500,15`.
    ///
    /// # Errors
    /// E1xx for options that do not apply to this kind of scene, or numbers out of range; E3xx for
    /// files that cannot be used; E501 for scenes that do not fit in memory.
    pub fn open(&self, word: impl AsRef<OsStr>) -> Result<Scene> {
        let start = Instant::now();
        let mut warnings = Vec::new();
        let word = skyshed_io::told(word.as_ref());
        let read = self.read(&word, &mut warnings)?;
        Scene::built(self, (&word, read), warnings, start)
    }

    /// Reads a scene without preparing it for line of sight.
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
        // A random stream that no kind of zone uses.
        const OF_CELLS: u64 = 1 << 32;
        let drawn = self.draws_cells.then(|| Points::new(city.seed, OF_CELLS).next()).flatten();
        Ok(city.city_on_cells_from(drawn.map_or([0.0; 2], |[u, v, ..]| [u, v]))?)
    }

    /// Returns the generated city of these options.
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
        // What names no file is told below, by the name that was typed.
        let format = match SceneFiles::of(&path.into()) {
            Ok(files) => Some(files.format),
            Err(_) if !path.exists() && named_files(path).len() == 1 => FileFormat::of_name(path),
            Err(error) => return Err(error.into()),
        };
        match format.and_then(FileFormat::kind).unwrap_or(FileKind::Raster) {
            FileKind::Raster => return Ok(read_surface(path, &self.of_raster()?, odd)?),
            FileKind::Mesh => return self.read_mesh(path, odd),
            FileKind::PointCloud => return Ok(read_point_cloud(path, &self.of_point_cloud()?, odd)?),
            FileKind::Vector => {}
        }
        if format != Some(FileFormat::GeoPackage) {
            self.refuse("a file that is no GeoPackage", &[("layer", self.options.layer.is_some())])?;
        }
        let options = if self.options.roofs.is_some() { self.of_solids()? } else { self.of_vector()? };
        let Some(list) = &self.repairs else { return Ok(read_footprints(path, &options, odd)?) };
        let (scene, repairs) = read_footprints_and_repairs(path, &options, odd)?;
        // A second reading gives the same scene, so a list that is already set stays.
        let _ = list.set(FoundRepairs { repairs, facts: facts_of(&scene, odd) });
        Ok(scene)
    }

    /// Reads a mesh, as buildings or as a surface.
    fn read_mesh(&self, path: &Path, odd: &mut Vec<skyshed_io::Warning>) -> Result<crate::city::City> {
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
        self.refuse_for_surface_of("a mesh")?;
        let options =
            MeshOptions { surface: self.of_surface()?, extent: self.options.extent, cell_m: self.options.cell };
        Ok(read_mesh(path, &options, odd)?)
    }

    /// Returns the options of a point cloud, which has a ground of its own.
    fn of_point_cloud(&self) -> Result<PointCloudOptions> {
        self.refuse_for_surface_of("a point cloud")?;
        if self.options.terrain.is_none() {
            let of_terrain = [("nodata_as", self.options.nodata_as.is_some())];
            self.refuse("a point cloud without `terrain`", &of_terrain)?;
        }
        Ok(PointCloudOptions { surface: self.over_ground()?, extent: self.options.extent, cell_m: self.options.cell })
    }

    /// Refuses options without a meaning for a surface that is made of another kind of data.
    fn refuse_for_surface_of(&self, what: &str) -> Result<()> {
        let others = [
            ("size", self.options.size.is_some()),
            ("project", self.options.project.is_some()),
            ("band", self.options.band.is_some()),
        ];
        self.refuse(what, &others)?;
        self.refuse(what, &self.of_footprints())
    }

    /// Warns of a raster of results, and of differing vertical datums of a surface and its terrain.
    pub(crate) fn warn_of_raster(&self, path: &Path, warnings: &mut Vec<Warning>) -> Result<()> {
        if !has_heights_above_datum(path) {
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

    /// Returns the grid of a raster scene in its own system, and its memory \[bytes\], both by its
    /// header. Other scenes give `None`, and so does a damaged file, whose fault is reported when
    /// it is read.
    ///
    /// The memory is 4.4 bytes for each cell (height, and bits of what it is), the terrain, and an
    /// unpacked strip or tile.
    pub(crate) fn size_of_raster(&self, word: &OsStr) -> Option<(GeoRef, u64)> {
        // A raster that is brought into another system is assembled in memory.
        if !is_raster_scene(word) || self.options.project.is_some() {
            return None;
        }
        let file = RasterFile::open(Path::new(word), &mut Vec::new()).ok()?;
        if file.is_empty() {
            return None;
        }
        let grid = self.grid_of(&file);
        let n_cells = grid.n_cells() as u64;
        // A terrain is read whole, and brought to the grid of the surface if it has another one.
        let below = self.options.terrain.as_deref().and_then(|path| RasterFile::open(path, &mut Vec::new()).ok());
        let of_terrain = below.map_or(0, |below| {
            let n_below = self.grid_of(&below).n_cells() as u64;
            let n_brought = if n_below == n_cells { 0 } else { n_cells };
            n_below.saturating_add(n_brought).saturating_mul(4).saturating_add(below.block_bytes())
        });
        let of_cells = bytes_of_cells(&grid, 4.4);
        let bytes = of_cells.saturating_add(of_terrain).saturating_add(file.block_bytes());
        Some((grid, bytes))
    }

    /// Returns the cells of a raster file that are read.
    pub(crate) fn grid_of(&self, file: &RasterFile) -> GeoRef {
        let grid = file.georef();
        self.around.map_or_else(|| grid.clone(), |around| grid.part(grid.window_within(around)))
    }

    /// Returns the options of a raster.
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

    /// Returns the options common to all surfaces.
    fn of_surface(&self) -> Result<SurfaceOptions> {
        if self.options.terrain.is_none() && self.options.ground.is_none() {
            let threshold = [("building_threshold", self.options.building_threshold.is_some())];
            self.refuse("a surface without `terrain` or `ground`", &threshold)?;
        }
        self.over_ground()
    }

    /// Returns the options common to all surfaces over a ground.
    fn over_ground(&self) -> Result<SurfaceOptions> {
        let defaults = SurfaceOptions::default();
        self.refuse("a surface", &[("ground buildings", self.options.ground == Some(GroundChoice::Buildings))])?;
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

    /// Returns the options of buildings whose heights come from their surfaces.
    fn of_solids(&self) -> Result<FootprintOptions> {
        let of_properties = [
            ("height_field", self.options.height_field.is_some()),
            ("top_field", self.options.top_field.is_some()),
            ("height_unit", self.options.height_unit.is_some()),
        ];
        self.refuse("roofs of surfaces", &of_properties)?;
        self.of_vector()
    }

    /// Returns the options of footprints.
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
        // Faults that are only reported refuse nothing.
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
            within: self.within,
            cell_m: self.options.cell,
            crs: self.crs()?,
            swap_axes: self.options.swap_axes,
            project: self.projection()?,
            nodata_as: self.options.nodata_as.unwrap_or_default(),
            base: self.options.base.unwrap_or_default(),
            data_area: self.options.data_area.clone().unwrap_or(DataAreaChoice::Auto),
            always_hash: self.options.hash,
        })
    }

    /// Lists the options that apply only to footprints.
    fn of_footprints(&self) -> [Set; 13] {
        [
            ("swap_axes", self.options.swap_axes),
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

    /// Refuses an option that would be ignored.
    pub(super) fn refuse(&self, what: &str, without_meaning: &[Set]) -> Result<()> {
        match without_meaning.iter().find(|(_, is_set)| *is_set) {
            Some((name, _)) => Err(Error::idle(*name, format!("for {what}"))),
            None => Ok(()),
        }
    }
}

/// Repairs of footprints, and the facts of the scene for documents.
#[derive(Debug, Clone)]
pub(crate) struct FoundRepairs {
    pub(crate) repairs: Vec<Repair>,
    pub(crate) facts: RunFacts,
}

/// Returns the facts of a scene that was read, for documents.
fn facts_of(scene: &crate::city::City, odd: &[skyshed_io::Warning]) -> RunFacts {
    RunFacts {
        command: CommandFacts::default(),
        method: None,
        scene_name: scene.name.clone(),
        grid: scene.grid.clone(),
        sources: scene.sources.clone(),
        seed: None,
        warnings: odd.iter().cloned().map(Warning::from).collect(),
        unit: None,
    }
}

/// Returns the parameters of the generated city that a word names; `None` for a file.
pub(crate) fn built_up(word: &OsStr) -> Option<Result<BuiltUp>> {
    Some(BuiltUpCity::parse_built_up(word.to_str()?)?.map_err(Into::into))
}

/// Returns the format and the number of the files of a scene.
pub(crate) fn files_of(path: &Path) -> Option<(FileFormat, usize)> {
    SceneFiles::of(&path.into()).ok().map(|files| (files.format, files.files.len()))
}

/// Returns the format of the files of a scene; of a file that cannot be read, that of its name.
pub(crate) fn format_of(path: &Path) -> Option<FileFormat> {
    SceneFiles::of(&path.into()).map_or_else(|_| FileFormat::of_name(path), |files| Some(files.format))
}

/// Returns what the files of a scene hold. What is not known is read as a raster, which says so.
fn kind_of(path: &Path) -> FileKind {
    format_of(path).and_then(FileFormat::kind).unwrap_or(FileKind::Raster)
}

/// Returns `true` for paths that are read as rasters: all files but footprints, meshes and point clouds.
fn is_raster(path: &Path) -> bool {
    kind_of(path) == FileKind::Raster
}

/// Returns `true` for files that may name the datum of their heights: rasters and point clouds.
pub(crate) fn has_heights_above_datum(path: &Path) -> bool {
    matches!(kind_of(path), FileKind::Raster | FileKind::PointCloud)
}

/// Returns `true` if a word names a raster.
pub(crate) fn is_raster_scene(word: &OsStr) -> bool {
    built_up(word).is_none() && is_raster(Path::new(word))
}
