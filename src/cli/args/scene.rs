//! The scene of a command, and how its files are read.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use clap::{Arg, ArgAction, Args, Command};

use super::words::{Words, band, extent, ground, number, one_of, projection};
use crate::city::NodataAs;
use crate::cli::failure::{Result, refusal, refusal_with};
use crate::cli::hints;
use crate::cli::typed::Typed;
use crate::crs;
use crate::formats::Band;
use crate::read::{BaseRule, DataAreaChoice, GroundChoice, HeightUnit, MissingHeights, Parts, Projection, Roofs};
use crate::scene::{FoundRepairs, Scene, SceneOptions};

const PARTS: Words<Parts> = &[
    ("replace", "Parts stand in place of the outline", Parts::Replace),
    ("join", "Both stand, and the highest counts", Parts::Join),
];

const BASE: Words<BaseRule> = &[
    ("lowest", "The lowest, as OpenStreetMap defines heights", BaseRule::Lowest),
    ("mean", "Their mean, by the area that is overlapped", BaseRule::Mean),
    ("highest", "The highest", BaseRule::Highest),
];

const HEIGHT_UNITS: Words<HeightUnit> =
    &[("m", "Meters", HeightUnit::Meters), ("ft", "International feet", HeightUnit::Feet)];

const NODATA: Words<NodataAs> =
    &[("block", "They block everything", NodataAs::Block), ("clear", "They block nothing", NodataAs::Clear)];

const ROOFS: Words<Roofs> = &[
    ("flat", "Each building as high as it is highest", Roofs::Flat),
    ("lod2", "As the surfaces of the file have them", Roofs::Lod2),
];

/// The scene and how it is read.
#[derive(Debug, Clone, Args)]
pub(crate) struct SceneArgs {
    /// Generated city (itu:urban), raster, footprints or mesh; `skyshed -h` has all kinds
    ///
    /// Generated city (itu:…), raster (.tif, .asc, .vrt, or a folder of tiles), footprints (.geojson, .shp, .fgb, .gpkg,
    /// .city.json) or mesh (.obj, .ply).
    #[arg(value_name = "SCENE")]
    pub(crate) scene: OsString,
    #[command(flatten)]
    pub(crate) reading: ReadingArgs,
}

impl SceneArgs {
    /// Reads the scene and makes it ready.
    pub(crate) fn open(&self) -> Result<Scene> {
        Ok(self.reading.options()?.open(&self.scene)?)
    }

    /// The scene and how it is read, as words of any command line.
    pub(crate) fn words(&self, typed: &Typed) -> Vec<String> {
        let reading = ReadingArgs::augment_args(Command::new("scene"));
        // Where repairs are listed, and whether inputs are hashed, does not change the scene.
        let takes_words = |arg: &&Arg| !matches!(arg.get_action(), ArgAction::SetTrue) && arg.get_id() != "repairs";
        let names: Vec<String> =
            reading.get_arguments().filter(takes_words).map(|arg| arg.get_id().to_string()).collect();
        let mut words = vec![self.scene.display().to_string()];
        words.extend(typed.flags(&names));
        words
    }

    /// The files that it names.
    pub(crate) fn files(&self) -> Vec<PathBuf> {
        self.reading.files(&self.scene)
    }
}

/// How a scene is read.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Scene")]
pub(crate) struct ReadingArgs {
    /// Terrain model below the surface model or the footprints
    ///
    /// A raster file, or a folder of tiles; with `--project` in any reference system.
    #[arg(long, value_name = "FILE")]
    terrain: Option<PathBuf>,
    /// Flat ground at this height above the datum [m], or `buildings`
    ///
    /// By default 0 m; for buildings with tops above the datum their median base. `buildings` makes a terrain through the
    /// bases of all buildings.
    #[arg(long, value_name = "Z", value_parser = ground, allow_hyphen_values = true, conflicts_with = "terrain")]
    ground: Option<GroundChoice>,
    /// A cell whose surface is more than this above the ground is a building [m]; default 0.25
    #[arg(long, value_name = "M", value_parser = number, allow_hyphen_values = true, hide_short_help = true)]
    building_threshold: Option<f64>,
    /// Property of a footprint's height above ground; default `height`
    ///
    /// Of CityJSON the default is the highest point. Text may name its unit: 12.5 m, 40 ft, 39'4".
    #[arg(long, value_name = "NAME")]
    height_field: Option<String>,
    /// Property that holds the height of a footprint's top above the datum, instead
    #[arg(long, value_name = "NAME", conflicts_with = "height_field", hide_short_help = true)]
    top_field: Option<String>,
    /// Unit of heights of footprints that name none; default m
    #[arg(long, value_name = "UNIT", value_parser = one_of(HEIGHT_UNITS), hide_short_help = true)]
    height_unit: Option<HeightUnit>,
    /// Property that holds the ground below a footprint [m above the datum], for `--top-field` and `--ground buildings`;
    /// default the first there is of `b3_h_maaiveld`, `ground_height`, `z_ground`, `h_ground`, `ground`
    #[arg(long, value_name = "NAME", conflicts_with = "terrain", hide_short_help = true)]
    base_field: Option<String>,
    /// Property that holds a footprint's number of storeys, for `--missing levels`; default the first there is of
    /// `building:levels`, `num_floors`, `storeysAboveGround`, `numberOfFloorsAboveGround`
    #[arg(long, value_name = "NAME", hide_short_help = true)]
    levels_field: Option<String>,
    /// Property with the standard deviation of the error of a footprint's height [m], for `map`, `compare` and `place`
    ///
    /// Footprints without it have that of `--height-error`.
    #[arg(long, value_name = "NAME", hide_short_help = true)]
    height_error_field: Option<String>,
    /// Roofs of CityJSON, or of a mesh, which is read as buildings then
    ///
    /// Without it, roofs of CityJSON are flat, and a mesh is a surface model.
    #[arg(long, value_name = "SHAPE", value_parser = one_of(ROOFS), hide_short_help = true)]
    roofs: Option<Roofs>,
    /// Table of a GeoPackage, where it has several
    #[arg(long, value_name = "NAME", hide_short_help = true)]
    layer: Option<String>,
    /// Heights of footprints without a usable one, the first that there is: `levels` (3 m for each storey), `median` (of the known
    /// heights), a number [m]; and at the end `drop` (leave them out) or `fail`
    ///
    /// For example `levels,median` or `levels,9`. By default, and where a list gives none, they are left out where they cover at most
    /// 2 % of the footprint area; the file is refused otherwise.
    #[arg(long, value_name = "LIST", hide_short_help = true)]
    missing: Option<MissingHeights>,
    /// Outlines of buildings that are drawn by parts as well; default replace
    #[arg(long, value_name = "RULE", value_parser = one_of(PARTS), hide_short_help = true)]
    parts: Option<Parts>,
    /// Which of the terrain cells that a footprint overlaps its height is above; default lowest
    #[arg(long, value_name = "RULE", value_parser = one_of(BASE), hide_short_help = true)]
    base: Option<BaseRule>,
    /// Where footprints tell of the ground: `auto` is between them (what no disc of 100 m reaches without meeting one), and
    /// everywhere with `--extent`; `all`; or the polygons of a file. Cells elsewhere hold no data
    #[arg(long, value_name = "auto|all|FILE", hide_short_help = true)]
    data_area: Option<PathBuf>,
    /// Extent of the grid over footprints or a mesh: west, south, east, north [CRS units]
    #[arg(long, value_name = "W,S,E,N", value_parser = extent, allow_hyphen_values = true, hide_short_help = true)]
    extent: Option<[f64; 4]>,
    /// Cell size, of a raster its own [m]; default 1
    ///
    /// That of the grid over footprints, a mesh or a generated city; default 1, or the terrain's own. With
    /// `--project` that of a raster too; default as many cells diagonally as the file has.
    #[arg(long, value_name = "M", value_parser = number, allow_hyphen_values = true)]
    cell: Option<f64>,
    /// Coordinate reference system of the scene, where its files name none or a wrong one
    #[arg(long, value_name = "EPSG:N", hide_short_help = true)]
    crs: Option<String>,
    /// Reference system to bring footprints or a raster into: `auto` is the zone of UTM for those in degrees and web
    /// Mercator; EPSG:n, or as `--crs`. Of a raster each cell takes the height of the cell of the file that holds its center
    #[arg(long, value_name = "auto|EPSG:N", value_parser = projection, hide_short_help = true)]
    project: Option<Projection>,
    /// Edge length of a generated city [m]; default 1000
    #[arg(long, value_name = "M", value_parser = number, allow_hyphen_values = true)]
    pub(crate) size: Option<f64>,
    /// Seed of everything random
    #[arg(long, value_name = "N", default_value_t = 1, hide_short_help = true)]
    pub(crate) seed: u64,
    /// What nodata cells do to links; default clear
    #[arg(long, value_name = "WHAT", value_parser = one_of(NODATA), hide_short_help = true)]
    nodata_as: Option<NodataAs>,
    /// Band of a raster that holds its heights, by number from 1 or by name; default 1
    #[arg(long, value_name = "N|NAME", value_parser = band, hide_short_help = true)]
    band: Option<Band>,
    /// Hash inputs above 64 MB too
    #[arg(long, hide_short_help = true)]
    pub(crate) hash: bool,
    /// Table (.csv) or points (.geojson) of everything that was mended or left out while reading footprints: feature, what
    /// was wrong, what was done, where
    #[arg(long, value_name = "FILE", hide_short_help = true)]
    pub(crate) repairs: Option<PathBuf>,
    /// What was mended or left out, once footprints are read for a list of that; copies share it.
    #[arg(skip)]
    pub(crate) found_repairs: Arc<OnceLock<FoundRepairs>>,
}

impl ReadingArgs {
    /// What was typed, as options of the library.
    pub(crate) fn options(&self) -> Result<SceneOptions> {
        let data_area = self.data_area.as_ref().map(|word| match word.to_str() {
            Some("auto") => DataAreaChoice::Auto,
            Some("all") => DataAreaChoice::All,
            _ => DataAreaChoice::Within(word.clone().into()),
        });
        Ok(SceneOptions {
            draws_cells: false,
            terrain: self.terrain.clone(),
            ground: self.ground,
            building_threshold_m: self.building_threshold,
            height_field: self.height_field.clone(),
            top_field: self.top_field.clone(),
            height_unit: self.height_unit,
            base_field: self.base_field.clone(),
            levels_field: self.levels_field.clone(),
            height_error_field: self.height_error_field.clone(),
            roofs: self.roofs,
            layer: self.layer.clone(),
            missing: self.missing.clone(),
            parts: self.parts,
            base: self.base,
            data_area,
            extent: self.extent,
            cell_m: self.cell,
            crs: self.crs()?,
            project: self.project.clone(),
            size_m: self.size,
            margin_m: 0.0,
            seed: Some(self.seed),
            nodata_as: self.nodata_as,
            band: self.band.clone(),
            hash: self.hash,
            keeps_solids: false,
            around: None,
            reach_m: None,
            tells_faults: false,
            repairs: self.repairs.is_some().then(|| Arc::clone(&self.found_repairs)),
        })
    }

    /// The reference system that was typed.
    ///
    /// E115: a text that is no reference system.
    pub(crate) fn crs(&self) -> Result<Option<crate::raster::Crs>> {
        self.crs.as_deref().map(crs::parse).transpose().map_err(|error| {
            let text = format!("`--crs`: {error}");
            hints::hint(&error.into()).map_or_else(|| refusal(115, &text), |hint| refusal_with(115, &text, hint))
        })
    }

    /// The files that a scene names, for the refusal to overwrite them.
    pub(crate) fn files(&self, scene: &OsString) -> Vec<PathBuf> {
        let area = self.data_area.clone().filter(|word| !["auto", "all"].map(Path::new).contains(&word.as_path()));
        [Some(PathBuf::from(scene)), self.terrain.clone(), area].into_iter().flatten().collect()
    }

    /// The layer that was read: as typed, else the file's own name, which stands for its only one.
    pub(crate) fn layer_of(&self, scene: &OsString) -> String {
        let stem = || Path::new(scene).file_stem().unwrap_or_default().to_string_lossy().into_owned();
        self.layer.clone().unwrap_or_else(stem)
    }
}
