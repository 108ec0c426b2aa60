//! Reading of scenes: options of files, and of generated cities.

pub(crate) mod band;
pub(crate) mod missing_heights;

use std::ffi::OsStr;
use std::fmt;
use std::str::FromStr;

use skyshed_core::city::NodataAs;
use skyshed_core::quantity::read_number;
use skyshed_core::words;

use crate::part::{group, part};
use crate::{Band, FilePath, MissingHeights};

words! {
    /// Rule for outlines whose buildings are drawn by parts as well.
    pub enum Parts {
        /// Parts stand in place of the outline
        Replace = "replace",
        /// Both stand, and the highest counts
        Join = "join",
    }
    default Replace
}

words! {
    /// Terrain column below a footprint that its height is above.
    pub enum BaseRule {
        /// The lowest, as OpenStreetMap defines heights
        Lowest = "lowest",
        /// Their mean, by the area that is overlapped
        Mean = "mean",
        /// The highest
        Highest = "highest",
    }
    default Lowest
}

words! {
    /// Unit of heights that name none.
    pub enum HeightUnit {
        /// Meters
        Meters = "m",
        /// International feet
        Feet = "ft",
    }
    default Meters
}

/// Length of an international foot \[m\].
pub const METERS_PER_FOOT: f64 = 0.3048;

impl HeightUnit {
    /// Returns the length of the unit \[m\].
    pub fn meters(self) -> f64 {
        match self {
            HeightUnit::Meters => 1.0,
            HeightUnit::Feet => METERS_PER_FOOT,
        }
    }
}

words! {
    /// Shape of roofs.
    pub enum Roofs {
        /// Each building as high as it is highest
        Flat = "flat",
        /// As the surfaces of the file have them
        Lod2 = "lod2",
    }
}

/// Ground of footprints without a terrain model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum GroundChoice {
    /// A plane at this height above the datum \[m\].
    Flat(f64),
    /// A terrain through the ground below buildings, which their file holds.
    Buildings,
}

impl From<f64> for GroundChoice {
    fn from(height_m: f64) -> Self {
        GroundChoice::Flat(height_m)
    }
}

impl FromStr for GroundChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "buildings" {
            return Ok(GroundChoice::Buildings);
        }
        read_number(text).map(GroundChoice::Flat).map_err(|found| format!("{found}, or `buildings`"))
    }
}

impl fmt::Display for GroundChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            GroundChoice::Flat(height_m) => height_m.fmt(f),
            GroundChoice::Buildings => f.write_str("buildings"),
        }
    }
}

skyshed_core::text!(GroundChoice);

/// Ground around footprints where the data end.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum DataAreaChoice {
    /// Between footprints; everywhere if an extent is set.
    Auto,
    /// Everywhere.
    All,
    /// Within the polygons of a file.
    Within(FilePath),
}

impl FromStr for DataAreaChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Ok(match text {
            "auto" => DataAreaChoice::Auto,
            "all" => DataAreaChoice::All,
            path => DataAreaChoice::Within(path.into()),
        })
    }
}

impl fmt::Display for DataAreaChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            DataAreaChoice::Auto => f.write_str("auto"),
            DataAreaChoice::All => f.write_str("all"),
            DataAreaChoice::Within(path) => path.display().fmt(f),
        }
    }
}

skyshed_core::text!(DataAreaChoice);

part! {
    /// Reading of a scene. An option without a meaning for the kind of the scene is an error.
    pub struct SceneOptions, SetSceneOptions {
        /// Terrain model below the surface model or the footprints
        ///
        /// A raster file, or a folder of tiles; with `--project` in any reference system.
        #[arg(long, value_name = "FILE")]
        terrain: Option<FilePath>,
        /// Flat ground at this height above the datum [m], or `buildings`
        ///
        /// By default 0 m; for buildings with tops above the datum their median base. `buildings` makes a terrain through the
        /// bases of all buildings.
        #[arg(long, value_name = "Z", allow_hyphen_values = true, conflicts_with = "terrain")]
        ground: Option<GroundChoice>,
        /// A cell whose surface is more than this above the ground is a building [m]
        #[arg(long, value_name = "M", value_parser = crate::words::number, allow_hyphen_values = true, hide_short_help = true)]
        building_threshold: Option<f64>,
        /// Property of a footprint's height above ground; default `height`
        ///
        /// Of surfaces the default is the highest point. Text may name its unit: 12.5 m, 40 ft, 39'4".
        #[arg(long, value_name = "NAME")]
        height_field: Option<String>,
        /// Property that holds the height of a footprint's top above the datum, instead
        #[arg(long, value_name = "NAME", conflicts_with = "height_field", hide_short_help = true)]
        top_field: Option<String>,
        /// Unit of heights of footprints that name none
        #[arg(long, value_name = "UNIT", value_parser = crate::words::one_of::<HeightUnit>(), hide_short_help = true)]
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
        /// Roofs of surfaces, as in CityJSON and CityGML, or of a mesh, which is read as buildings then
        ///
        /// Without it, roofs are flat, and a mesh is a surface model.
        #[arg(long, value_name = "SHAPE", value_parser = crate::words::one_of::<Roofs>(), hide_short_help = true)]
        roofs: Option<Roofs>,
        /// Table of a GeoPackage, where it has several
        #[arg(long, value_name = "NAME", hide_short_help = true)]
        layer: Option<String>,
        /// Heights of footprints without a usable one: a list of rules, such as `levels,median` or `levels,9`
        ///
        /// The first rule that gives a height counts: `levels` (3 m for each storey), `median` (of the known heights), a number
        /// [m]. The list may end with `drop` (leave them out) or `fail`. By default, and where a list gives no height, they are
        /// left out where they cover at most 2 % of the footprint area; the file is refused otherwise.
        #[arg(long, value_name = "LIST", hide_short_help = true)]
        missing: Option<MissingHeights>,
        /// Outlines of buildings that are drawn by parts as well
        #[arg(long, value_name = "RULE", value_parser = crate::words::one_of::<Parts>(), hide_short_help = true)]
        parts: Option<Parts>,
        /// Terrain cell below a footprint that its height is above
        #[arg(long, value_name = "RULE", value_parser = crate::words::one_of::<BaseRule>(), hide_short_help = true)]
        base: Option<BaseRule>,
        /// Ground with data: `auto`, `all`, or the polygons of a file. Cells elsewhere hold no data
        ///
        /// `auto` is the ground between footprints, which no disc of 100 m reaches without meeting one; with `--extent` it is
        /// everywhere.
        #[arg(long, value_name = "auto|all|FILE", hide_short_help = true)]
        data_area: Option<DataAreaChoice>,
        /// Extent of the grid over footprints or a mesh: west, south, east, north [CRS units]
        #[arg(long, value_name = "W,S,E,N", value_parser = crate::words::extent, allow_hyphen_values = true, hide_short_help = true)]
        extent: Option<[f64; 4]>,
        /// Cell size, of a raster its own [m]; default 1
        ///
        /// That of the grid over footprints, a mesh or a generated city; default 1, or the terrain's own. With
        /// `--project` that of a raster too; default as many cells diagonally as the file has.
        #[arg(long, value_name = "M", value_parser = crate::words::number, allow_hyphen_values = true)]
        cell: Option<f64>,
        /// Coordinate reference system of the scene, where its files name none or a wrong one
        #[arg(long, value_name = "EPSG:N", hide_short_help = true)]
        crs: Option<String>,
        /// Reference system to bring footprints or a raster into: `auto` is the zone of UTM for those in degrees and web
        /// Mercator; EPSG:n, or as `--crs`. Of a raster each cell takes the height of the cell of the file that holds its center
        #[arg(long, value_name = "auto|EPSG:N", hide_short_help = true)]
        project: Option<String>,
        /// Exchange x and y of all positions of footprints, where the file has them in the other order than `info` says
        #[arg(long, hide_short_help = true)]
        swap_axes: bool,
        /// Edge length of a generated city [m]
        #[arg(long, value_name = "M", value_parser = crate::words::number, allow_hyphen_values = true)]
        size: Option<f64>,
        /// Seed of everything random
        #[arg(long, value_name = "N", hide_short_help = true)]
        seed: Option<u64>,
        /// Effect of nodata cells on links
        #[arg(long, value_name = "WHAT", value_parser = crate::words::one_of::<NodataAs>(), hide_short_help = true)]
        nodata_as: Option<NodataAs>,
        /// Band of a raster that holds its heights, by number from 1 or by name
        #[arg(long, value_name = "N|NAME", hide_short_help = true)]
        band: Option<Band>,
        /// Hash inputs above 64 MB too
        #[arg(long, hide_short_help = true)]
        hash: bool,
    }
}

impl SceneOptions {
    /// Edge length of a generated city, unless another is set \[m\].
    pub const SIZE_M: f64 = 1000.0;

    /// Returns the defaults of the fields; `None` where the default depends on the scene.
    pub fn defaults() -> SceneOptions {
        SceneOptions {
            building_threshold: Some(0.25),
            height_unit: Some(HeightUnit::default()),
            parts: Some(Parts::default()),
            base: Some(BaseRule::default()),
            size: Some(SceneOptions::SIZE_M),
            seed: Some(1),
            nodata_as: Some(NodataAs::default()),
            band: Some(Band::Number(1)),
            ..SceneOptions::default()
        }
    }

    /// Returns the files that these options name.
    pub fn files(&self) -> impl Iterator<Item = &FilePath> {
        let area = match &self.data_area {
            Some(DataAreaChoice::Within(path)) => Some(path),
            _ => None,
        };
        self.terrain.iter().chain(area)
    }

    /// Returns the seed of everything random.
    pub fn seed_or_default(&self) -> u64 {
        self.seed.unwrap_or(1)
    }
}

part! {
    /// Scene of a question.
    pub struct SceneWord, SetSceneWord {
        /// Generated city (itu:urban), raster, buildings, points or mesh; `skyshed -h` has all kinds
        ///
        /// Generated city (itu:…), raster (.tif, .asc, .xyz, .vrt), buildings (.geojson, .city.json, .gml, .parquet, .osm.pbf,
        /// .shp, .fgb, .gpkg), point cloud (.las, .laz) or mesh (.obj, .ply). All may be in .gz or .zip. A folder, or A+B, of
        /// several files of one format is one scene.
        #[arg(value_name = "SCENE", required = true)]
        scene: Option<FilePath>,
    }
}

impl SceneWord {
    /// Returns the path of the scene, or its word; nothing if it was not set.
    pub fn word(&self) -> &OsStr {
        self.scene.as_ref().map_or(OsStr::new(""), |path| path.as_os_str())
    }
}

part! {
    /// List of repairs.
    pub struct Repairs, SetRepairs {
        /// Table (.csv) or points (.geojson) of everything that was mended or left out while reading footprints: feature, what
        /// was wrong, what was done, where
        #[arg(long, value_name = "FILE", hide_short_help = true)]
        repairs: Option<FilePath>,
    }
}

group! {
    /// Reading of a scene, with a list of repairs.
    #[command(next_help_heading = "Scene")]
    pub struct Reading {
        /// Options.
        options: SceneOptions,
        /// List of repairs.
        list: Repairs,
    }
}

crate::holds!(Reading: options SceneOptions, list Repairs);
