//! What was typed: the command line, as it is documented by `--help`.

use std::ffi::{OsStr, OsString};
use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

use super::chart::ChartArgs;
use super::compare::CompareArgs;
use super::place::PlaceArgs;
use super::plos::PlosArgs;
use super::stress::StressArgs;
use super::typed::{SceneWord, length, scene_word};
use crate::error::Error;
use crate::export::{Layer, as_text, encode_table};
use crate::formats::TiffLayout;
use crate::los::MethodChoice;
use crate::map::{PolygonClasses, Receivers};
use crate::picture::{PictureSize, PictureWords};
use crate::read::Projection;
use crate::scene::FoundRepairs;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::parser::ValueSource;
use clap::{ArgMatches, Args, CommandFactory, FromArgMatches, Parser, Subcommand, ValueEnum};

/// Exact line-of-sight coverage maps: what a hovering UAV can see of a city.
#[derive(Debug, Parser)]
#[command(name = "skyshed", version, propagate_version = true, max_term_width = 110)]
#[command(after_help = "\
SCENE is a generated city (itu:urban, itu:0.3,500,15), a raster (.tif, .asc, .vrt, or a folder of
tiles), footprints (.geojson, .shp, .fgb, .gpkg, .city.json) or a mesh (.obj, .ply).
Heights are above ground unless written 150amsl or 30roof; all lengths are in meters, heights of UAVs
and receivers also in feet: 400ft, 400ft amsl. Tables (.csv) have fields between commas, semicolons or
tabs; `-` reads one from standard input. Without `-o` the answer goes to standard output.

Examples:
  skyshed map itu:urban --uav 500,500,100 -o coverage.png
  skyshed map dsm.tif --terrain dtm.tif --uav 691549.7,5334762.2,60 -o coverage.tif -o coverage.json
  skyshed link itu:urban --uav 500,500,100 --rx 630,480
  skyshed info buildings.geojson
  skyshed plos itu:urban --theta 5:90:5 --method product,itu,alhourani2014 -o plos.png
  skyshed compare itu:urban --uav 500,500,100 --uav 560,440,100 -o compare.html
  skyshed place itu:urban --height 60,100 --step 50 -o hover.png
  skyshed stress --scenes 4 -o failures.png
  skyshed chart itu:urban --size 300 --uav 150,150,100 --time 0.05 -o chart.png

Exit codes: 0 done, 1 internal fault, 2 usage, 3 bad input or output file, 4 bad site or zone, 5 over
a limit, 6 a check failed, 130 interrupted.")]
pub(super) struct Cli {
    #[command(subcommand)]
    pub(super) command: Command,
}

impl Cli {
    /// Parses the words of a command line, the program's name first.
    pub(super) fn from_words(words: &[OsString]) -> Result<Cli, clap::Error> {
        let mut command = Cli::command();
        let matches = command.try_get_matches_from_mut(words)?;
        if let Some((_, matches)) = matches.subcommand()
            && standard_inputs(matches) > 1
        {
            let text = "`-` is given for two tables, wanted one: standard input can be read once";
            return Err(command.error(clap::error::ErrorKind::ArgumentConflict, text));
        }
        let mut cli = Cli::from_arg_matches(&matches).map_err(|e| e.format(&mut command))?;
        let scene = cli.command.scene_mut();
        if let Some((_, matches)) = matches.subcommand() {
            scene.typed = typed(matches);
            scene.paths = paths(matches);
        }
        Ok(cli)
    }
}

/// The names of the arguments that were typed, as opposed to left at their defaults.
fn typed(matches: &ArgMatches) -> Vec<String> {
    let ids = matches.ids().map(|id| id.as_str());
    ids.filter(|id| matches.value_source(id) == Some(ValueSource::CommandLine)).map(str::to_string).collect()
}

/// How many tables are to be read from standard input.
fn standard_inputs(matches: &ArgMatches) -> usize {
    let tables = ["uavs", "candidates", "track"].into_iter();
    let tables = tables.filter_map(|id| matches.try_get_one::<PathBuf>(id).ok().flatten()).map(|path| path.as_os_str());
    let curves = matches.try_get_many::<OsString>("curve").ok().flatten().into_iter().flatten();
    let is_standard_input = |word: &OsStr| word == "-" || word.as_encoded_bytes().ends_with(b"=-");
    tables.chain(curves.map(OsString::as_os_str)).filter(|word| is_standard_input(word)).count()
}

/// The files that were named, other than the scene and `--repairs`.
fn paths(matches: &ArgMatches) -> Vec<PathBuf> {
    let ids = matches.ids().map(|id| id.as_str()).filter(|id| *id != "repairs");
    ids.filter_map(|id| matches.try_get_many::<PathBuf>(id).ok().flatten()).flatten().cloned().collect()
}

#[derive(Debug, Subcommand)]
pub(super) enum Command {
    /// Coverage of one or many UAVs over every cell of a scene
    Map(MapArgs),
    /// One link: line of sight, or the obstacle in its way
    Link(LinkArgs),
    /// Make or convert a city, and draw it
    City(CityArgs),
    /// What a file is: size, CRS, heights and faults of a scene; what UAVs, a track, or an output of this program hold
    Info(InfoArgs),
    /// Probability of line of sight: curves by exact products, simulators, published models, and over real cities
    Plos(Box<PlosArgs>),
    /// Placements side by side: maps, differences and a table with intervals, as a picture or a page to swipe over
    Compare(Box<CompareArgs>),
    /// Where to hover: candidates ranked, refined, or chosen together, with a bound on what was missed
    Place(Box<PlaceArgs>),
    /// Where methods fail: all of them on small scenes full of ties, or what in one scene hangs by a lattice step
    Stress(Box<StressArgs>),
    /// Speed against accuracy of every method on a scene, timed with one thread unless `-j` says otherwise
    Chart(Box<ChartArgs>),
}

impl Command {
    /// The scene and how it is read.
    pub(super) fn scene(&self) -> &SceneArgs {
        match self {
            Command::Map(args) => &args.scene,
            Command::Link(args) => &args.scene,
            Command::City(args) => &args.scene,
            Command::Info(args) => &args.scene,
            Command::Plos(args) => &args.scene,
            Command::Compare(args) => &args.scene,
            Command::Place(args) => &args.scene,
            Command::Stress(args) => &args.scene,
            Command::Chart(args) => &args.scene,
        }
    }

    /// Most memory that the run may take.
    pub(super) fn max_memory(&self) -> Option<u64> {
        match self {
            Command::Map(args) => args.engine.max_memory,
            Command::Link(args) => args.engine.max_memory,
            Command::City(args) => args.engine.max_memory,
            Command::Info(args) => args.engine.max_memory,
            Command::Plos(args) => args.max_memory,
            Command::Compare(args) => args.engine.max_memory,
            Command::Place(args) => args.engine.max_memory,
            Command::Stress(args) => args.engine.max_memory,
            Command::Chart(args) => args.engine.max_memory,
        }
    }

    fn scene_mut(&mut self) -> &mut SceneArgs {
        match self {
            Command::Map(args) => &mut args.scene,
            Command::Link(args) => &mut args.scene,
            Command::City(args) => &mut args.scene,
            Command::Info(args) => &mut args.scene,
            Command::Plos(args) => &mut args.scene,
            Command::Compare(args) => &mut args.scene,
            Command::Place(args) => &mut args.scene,
            Command::Stress(args) => &mut args.scene,
            Command::Chart(args) => &mut args.scene,
        }
    }
}

/// The scene and how it is read.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Scene")]
pub(super) struct SceneArgs {
    /// Generated city (itu:…), raster (.tif, .asc, .vrt, or a folder of tiles), footprints (.geojson, .shp, .fgb, .gpkg,
    /// .city.json) or mesh (.obj, .ply)
    #[arg(value_name = "SCENE", value_parser = scene_word(), help_heading = None::<&'static str>)]
    pub(super) scene: SceneWord,
    /// Terrain model below the surface model or the footprints [raster file, or folder of tiles]; with `--project` in any
    /// reference system
    #[arg(long, value_name = "FILE")]
    pub(super) terrain: Option<PathBuf>,
    /// Flat ground at this height above the datum [m]; footprints and generated cities: 0
    #[arg(long, value_name = "Z", value_parser = number, allow_hyphen_values = true, conflicts_with = "terrain")]
    pub(super) ground: Option<f64>,
    /// A cell whose surface is more than this above the ground is a building [m]; default 0.25
    #[arg(long, value_name = "M", value_parser = number, allow_hyphen_values = true)]
    pub(super) building_threshold: Option<f64>,
    /// Property that holds a footprint's height above ground; default `height`, of CityJSON the highest point. Text may
    /// name its unit: 12.5 m, 40 ft, 39'4"
    #[arg(long, value_name = "NAME")]
    pub(super) height_field: Option<String>,
    /// Property that holds the height of a footprint's top above the datum, instead
    #[arg(long, value_name = "NAME", conflicts_with = "height_field")]
    pub(super) top_field: Option<String>,
    /// Unit of heights of footprints that name none; default m
    #[arg(long, value_enum)]
    pub(super) height_unit: Option<HeightUnitArg>,
    /// Property that holds a footprint's number of storeys, for `--missing levels`; default `building:levels`
    #[arg(long, value_name = "NAME")]
    pub(super) levels_field: Option<String>,
    /// Table of a GeoPackage, where it has several
    #[arg(long, value_name = "NAME")]
    pub(super) layer: Option<String>,
    /// What to do with footprints without a usable height; default: leave them out where they cover at most 2 % of the
    /// footprint area, refuse the file otherwise
    #[arg(long, value_enum)]
    pub(super) missing: Option<Missing>,
    /// Which of the terrain cells that a footprint overlaps its height is above; default lowest
    #[arg(long, value_enum)]
    pub(super) base: Option<Base>,
    /// Where footprints tell of the ground: `auto` is between them (what no disc of 100 m reaches without meeting one), and
    /// everywhere with `--extent`; `all`; or the polygons of a file. Cells elsewhere hold no data
    #[arg(long, value_name = "auto|all|FILE")]
    pub(super) data_area: Option<PathBuf>,
    /// Extent of the grid over footprints or a mesh: west, south, east, north [CRS units]
    #[arg(long, value_name = "W,S,E,N", value_parser = extent, allow_hyphen_values = true)]
    pub(super) extent: Option<[f64; 4]>,
    /// Cell size of the grid over footprints, a mesh or a generated city [m]; default 1, or the terrain's own. With
    /// `--project` that of a raster too; default as many cells diagonally as the file has
    #[arg(long, value_name = "M", value_parser = number, allow_hyphen_values = true)]
    pub(super) cell: Option<f64>,
    /// Coordinate reference system of the scene, where its files name none or a wrong one
    #[arg(long, value_name = "EPSG:N")]
    pub(super) crs: Option<String>,
    /// Reference system to bring footprints or a raster into: `auto` is the zone of UTM for those in degrees; EPSG:n, or as
    /// `--crs`. Of a raster each cell takes the height of the cell of the file that holds its center
    #[arg(long, value_name = "auto|EPSG:N", value_parser = projection)]
    pub(super) project: Option<Projection>,
    /// Edge length of a generated city [m], default 1000; with `--sample` and a radius that of the ground that placements are over, and the
    /// city goes on around it
    #[arg(long, value_name = "M", value_parser = number, allow_hyphen_values = true)]
    pub(super) size: Option<f64>,
    /// Seed of everything random
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(super) seed: u64,
    /// What nodata cells do to links; default clear
    #[arg(long, value_enum)]
    pub(super) nodata_as: Option<Nodata>,
    /// Hash inputs above 64 MB too
    #[arg(long)]
    pub(super) hash: bool,
    /// Table (.csv) or points (.geojson) of everything that was mended or left out while reading footprints: feature, what
    /// was wrong, what was done, where
    #[arg(long, value_name = "FILE")]
    pub(super) repairs: Option<PathBuf>,
    /// How far a generated city goes on beyond its size on all sides [m]: for samples within a radius.
    #[arg(skip)]
    pub(super) margin_m: f64,
    /// Which arguments were typed.
    #[arg(skip)]
    pub(super) typed: Vec<String>,
    /// The files that were named, other than the scene and that of repairs.
    #[arg(skip)]
    pub(super) paths: Vec<PathBuf>,
    /// What was mended or left out, once footprints are read for a list of that; copies of the arguments share it.
    #[arg(skip)]
    pub(super) found_repairs: Arc<OnceLock<FoundRepairs>>,
}

impl SceneArgs {
    /// The file of the data area, if one was named.
    pub(super) fn data_area_file(&self) -> Option<PathBuf> {
        self.data_area.clone().filter(|word| !["auto", "all"].iter().any(|known| word.as_os_str() == *known))
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Missing {
    /// Refuse the file
    Fail,
    /// Leave the footprint out and say so
    Drop,
    /// 3 m for each storey
    Levels,
    /// The median of the known heights
    Median,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Base {
    /// The lowest, as OpenStreetMap defines heights
    Lowest,
    /// Their mean, by the area that is overlapped
    Mean,
    /// The highest
    Highest,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum HeightUnitArg {
    /// Meters
    M,
    /// International feet
    Ft,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Nodata {
    /// They block everything
    Block,
    /// They block nothing
    Clear,
}

/// How links are decided; every command takes these.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Engine")]
pub(super) struct EngineArgs {
    /// Largest horizontal distance from the UAV to a receiver [m]
    #[arg(long, value_name = "M", value_parser = number, allow_hyphen_values = true)]
    pub(super) radius: Option<f64>,
    /// Engine: auto takes the fastest exact one for the scene and says so; ray (one ray per receiver), sweep (rasters) and
    /// shadow (footprints, rasters of flat blocks) are exact; step:K (a sample every K cells), xdraw and r2 (rasters) are approximate
    #[arg(long, value_name = "METHOD", default_value = "auto")]
    pub(super) method: MethodChoice,
    /// Most memory that the run may take, such as 800M or 4G; default: what the machine, the container and the limit of
    /// address space have left. `map` sweeps a raster that takes more strip by strip; what cannot do with it is refused, or ended
    #[arg(long, value_name = "SIZE", value_parser = memory_size, allow_hyphen_values = true)]
    pub(super) max_memory: Option<u64>,
}

/// Where results go and how much is said.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Output")]
pub(super) struct OutputArgs {
    /// Print one JSON document on standard output
    #[arg(long)]
    pub(super) json: bool,
    /// Replace files that exist
    #[arg(long)]
    pub(super) overwrite: bool,
    /// Threads to use, at most four for each core; default one for each core
    #[arg(short = 'j', long = "threads", value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub(super) threads: Option<u16>,
    /// Write cells of tables that a spreadsheet would run (they begin with =, +, - or @ and are no numbers) as text, behind
    /// a ' (docs/tables.md)
    #[arg(long)]
    pub(super) csv_text: bool,
    /// Say nothing but errors
    #[arg(short, long)]
    pub(super) quiet: bool,
}

impl OutputArgs {
    /// A table as it is to be written.
    pub(super) fn table(&self, rows: &[Vec<String>]) -> Result<Vec<u8>, Error> {
        if self.csv_text { Ok(encode_table(&as_text(rows))?) } else { Ok(encode_table(rows)?) }
    }
}

#[derive(Debug, Clone, Args)]
pub(super) struct MapArgs {
    /// A UAV: x, y in the scene's CRS and height (120, 120agl, 30roof, 150amsl, 400ft); repeat for more
    #[arg(long, value_name = "X,Y,H", allow_hyphen_values = true)]
    pub(super) uav: Vec<String>,
    /// UAVs from a table (.csv with x,y,h or lon,lat,h) or points (.geojson); `-` is standard input
    #[arg(long, value_name = "FILE")]
    pub(super) uavs: Option<PathBuf>,
    /// Leave out rows of the table that cannot be read, with a warning that names them
    #[arg(long, requires = "uavs")]
    pub(super) skip_bad: bool,
    /// Height of the receivers above ground or roof [m]
    #[arg(long, value_name = "M", value_parser = length, default_value = "1.5", allow_hyphen_values = true)]
    pub(super) rx_height: f64,
    /// Which cells hold receivers
    #[arg(long, value_enum, default_value = "ground")]
    pub(super) receivers: Receivers,
    /// How far P_LoS of any UAV may be off, such as 0.005: the map is made on the coarsest cells for which that is so with
    /// 99 % confidence, measured on a sample of receivers that are decided exactly; says what was taken and measured
    #[arg(long, value_name = "P", value_parser = number, allow_hyphen_values = true)]
    pub(super) tolerance: Option<f64>,
    /// Layers to make, separated by commas; pictures show the first, of several UAVs the number that see a cell for `los`,
    /// colors or a map each for the others
    #[arg(long, value_parser = layer(), value_delimiter = ',', default_value = "los")]
    pub(super) layers: Vec<Layer>,
    /// File to write, by extension: .png .svg .pdf .tif .exr .asc .bil .npz .kmz .csv .json .geojson .fgb, `-` for JSON on
    /// standard output; repeat for more. Without any the table goes to standard output. With `{site}` in every name each UAV gets files of its own, which appear as soon as
    /// they are complete; with `--radius`, only the part of a raster that is in range is read
    #[arg(short, long = "output", value_name = "FILE")]
    pub(super) output: Vec<PathBuf>,
    /// P_LoS as a function of the UAV's height over each place, exact: a plot (.png, .svg, .pdf), a table (.csv) or a document
    /// (.json); repeat for more. Costs a walk along the whole link per receiver and UAV, 5 to 20 times a map by rays
    #[arg(long, value_name = "FILE")]
    pub(super) height_curve: Vec<PathBuf>,
    /// Heights of the curve's table and plot above the ground below the UAV (above the datum where none is known), both
    /// ends included [m]; default: some 150 round ones from the lowest that the UAV may have to three times the highest
    /// UAV or building, or to where 99 % of the receivers are seen
    #[arg(long, value_name = "A:B:S", value_parser = range, allow_hyphen_values = true)]
    pub(super) curve_heights: Option<[f64; 3]>,
    /// PNG with one pixel per cell, a world file and a .prj, instead of a picture
    #[arg(long)]
    pub(super) bare: bool,
    /// Arrangement of the cells in .tif files; default cog
    #[arg(long, value_parser = tif_layout())]
    pub(super) tif_layout: Option<TiffLayout>,
    /// Mask of one UAV in .tif and .bil files as `gdal_viewshed` writes it: 255 in line of sight, 0 everywhere else, also out
    /// of range, and no nodata
    #[arg(long)]
    pub(super) gdal_values: bool,
    /// Sweep a raster strip by strip from a copy in tiles on disk, also where it fits in memory: the same cells, less memory
    #[arg(long)]
    pub(super) strips: bool,
    /// Folder for that copy (4 bytes a cell, in a file without a name); default: the system's folder for temporary files
    #[arg(long, value_name = "FOLDER")]
    pub(super) scratch: Option<PathBuf>,
    /// Leave what is there already: a UAV is skipped if its files exist and were made by the same run, so that an interrupted
    /// one goes on where it stopped
    #[arg(long)]
    pub(super) resume: bool,
    /// Coverage as polygons in .geojson and .fgb files, one per connected part of a class and site, holes kept
    #[arg(long, value_enum, value_name = "CLASS")]
    pub(super) polygons: Option<PolygonClasses>,
    /// How far an outline of the polygons may be from the cell edges [m]; each stays valid, neighbors may overlap by as much
    #[arg(long, value_name = "M", value_parser = number, allow_hyphen_values = true, requires = "polygons")]
    pub(super) simplify: Option<f64>,
    #[command(flatten)]
    pub(super) words: PictureWords,
    #[command(flatten)]
    pub(super) scene: SceneArgs,
    #[command(flatten)]
    pub(super) engine: EngineArgs,
    #[command(flatten)]
    pub(super) out: OutputArgs,
}

#[derive(Debug, Args)]
pub(super) struct LinkArgs {
    /// The UAV: x, y in the scene's CRS and height (120, 120agl, 30roof, 150amsl)
    #[arg(long, value_name = "X,Y,H", allow_hyphen_values = true)]
    pub(super) uav: String,
    /// The receiver: x, y and height (1.5, 1.5roof, 30amsl); `--rx-height` above ground without one
    #[arg(long, value_name = "X,Y[,H]", allow_hyphen_values = true, required_unless_present = "track")]
    pub(super) rx: Option<String>,
    /// A user's track instead: its places in order, from a table (.csv with x,y or lon,lat; `-` is standard input) or a line
    /// (.geojson); says where it has line of sight and how long the stretches without are
    #[arg(long, value_name = "FILE", conflicts_with = "rx")]
    pub(super) track: Option<PathBuf>,
    /// Leave out rows of the track that cannot be read, with a warning that names them
    #[arg(long, requires = "track")]
    pub(super) skip_bad: bool,
    /// Longest step along a track between two decided places [m]; what begins and ends within a step is missed
    #[arg(long, value_name = "M", value_parser = number, default_value = "1", allow_hyphen_values = true, requires = "track")]
    pub(super) every: f64,
    /// Height of the receiver above ground [m], if `--rx` gives none
    #[arg(long, value_name = "M", value_parser = length, default_value = "1.5", allow_hyphen_values = true)]
    pub(super) rx_height: f64,
    /// Side view of the link (.png, .svg, .pdf) or its document (.json); of a track a strip of line of sight below the height that
    /// would be enough, its document, and a table (.csv)
    #[arg(short, long = "output", value_name = "FILE")]
    pub(super) output: Vec<PathBuf>,
    #[command(flatten)]
    pub(super) size: PictureSize,
    #[command(flatten)]
    pub(super) scene: SceneArgs,
    #[command(flatten)]
    pub(super) engine: EngineArgs,
    #[command(flatten)]
    pub(super) out: OutputArgs,
}

#[derive(Debug, Args)]
pub(super) struct CityArgs {
    /// File to write, by extension: .png .svg .pdf (plan and 3-D view), .tif .asc (surface heights), .geojson (footprints), .xml
    /// (scene of Mitsuba and Sionna RT, with meshes), .csv (boxes of ns-3), .json (parameters); repeat for more. Without any
    /// what the city is goes to standard output
    #[arg(short, long = "output", value_name = "FILE")]
    pub(super) output: Vec<PathBuf>,
    #[command(flatten)]
    pub(super) words: PictureWords,
    #[command(flatten)]
    pub(super) scene: SceneArgs,
    #[command(flatten)]
    pub(super) engine: EngineArgs,
    #[command(flatten)]
    pub(super) out: OutputArgs,
}

#[derive(Debug, Clone, Args)]
pub(super) struct InfoArgs {
    /// A UAV: x, y in the scene's CRS and height; tells what a map from there needs (how coarse its cells may be, whether
    /// terrain matters, which footprints can hide anyone) and what limits its P_LoS; repeat for more, counted together
    #[arg(long, value_name = "X,Y,H", allow_hyphen_values = true)]
    pub(super) uav: Vec<String>,
    /// Height of the receivers of that map above ground or roof [m]
    #[arg(long, value_name = "M", value_parser = length, default_value = "1.5", allow_hyphen_values = true)]
    pub(super) rx_height: f64,
    /// Which cells hold receivers of that map
    #[arg(long, value_enum, default_value = "ground")]
    pub(super) receivers: Receivers,
    /// How far the UAV may be from where it should be, sideways and in height [m]
    #[arg(long, value_name = "M", value_parser = number, default_value = "1", allow_hyphen_values = true)]
    pub(super) uav_error: f64,
    /// How far the heights of all buildings may be off [m]
    #[arg(long, value_name = "M", value_parser = number, default_value = "1", allow_hyphen_values = true)]
    pub(super) height_error: f64,
    /// Other cities of a generated kind that tell how much one city of many matters
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u16).range(2..=1000))]
    pub(super) cities: u16,
    /// Find the zones of the city, street, crossroad, courtyard and rooftop, and count them
    #[arg(long)]
    pub(super) zones: bool,
    /// Also α, β and γ of squares of this size, from the north-west corner: a raster (.tif) or a table (.csv); squares that
    /// the extent cuts have the values of what is left of them [m]
    #[arg(long, value_name = "M", value_parser = number, allow_hyphen_values = true, conflicts_with_all = ["zones", "uav"])]
    pub(super) tile: Option<f64>,
    /// File to write, by extension: .json; with `--zones` also a map of them (.png .svg .pdf), a raster (.tif) or polygons
    /// (.geojson); with `--uav` also the table of what limits P_LoS (.csv); with `--tile` also a raster of α, β, γ (.tif) or
    /// their table (.csv); repeat for more
    #[arg(short, long = "output", value_name = "FILE")]
    pub(super) output: Vec<PathBuf>,
    #[command(flatten)]
    pub(super) words: PictureWords,
    #[command(flatten)]
    pub(super) scene: SceneArgs,
    #[command(flatten)]
    pub(super) engine: EngineArgs,
    #[command(flatten)]
    pub(super) out: OutputArgs,
}

pub(super) fn number(text: &str) -> Result<f64, String> {
    crate::quantity::parse_number(text).map_err(|found| format!("{found}, wanted a finite number"))
}

fn projection(text: &str) -> Result<Projection, String> {
    Projection::parse(text).map_err(|e| e.to_string())
}

fn range(text: &str) -> Result<[f64; 3], String> {
    let numbers: Result<Vec<f64>, String> = text.split(':').map(number).collect();
    <[f64; 3]>::try_from(numbers?).map_err(|n| format!("found {} numbers, wanted A:B:S", n.len()))
}

/// A number of bytes: `800M`, `4G`, `1.5GiB`, or bytes alone.
pub(super) fn memory_size(text: &str) -> Result<u64, String> {
    let wrong = || format!("found `{text}`, wanted a size such as 800M or 4G");
    let upper = text.trim().to_ascii_uppercase();
    let digits = upper.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let unit = match &upper[digits.len()..] {
        "" | "B" => 1.0,
        "K" | "KB" | "KIB" => 1024.0,
        "M" | "MB" | "MIB" => 1_048_576.0,
        "G" | "GB" | "GIB" => 1_073_741_824.0,
        "T" | "TB" | "TIB" => 1_099_511_627_776.0,
        _ => return Err(wrong()),
    };
    let number = number(digits).map_err(|_| wrong())?;
    if number <= 0.0 {
        return Err(wrong());
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "positive; saturates")]
    let bytes = (number * unit) as u64;
    Ok(bytes)
}

fn extent(text: &str) -> Result<[f64; 4], String> {
    let numbers: Result<Vec<f64>, String> = text.split(',').map(number).collect();
    <[f64; 4]>::try_from(numbers?).map_err(|n| format!("found {} numbers, wanted W,S,E,N", n.len()))
}

/// The layers of a map, with what each holds.
fn layer() -> impl TypedValueParser<Value = Layer> {
    let layers = [
        (Layer::Los, "Classes: 0 NLoS, 1 LoS, 2 not a receiver, 3 out of range, 255 nodata"),
        (Layer::Margin, "Receiver height less the least visible height [m]"),
        (Layer::LeastReceiverHeight, "Least receiver height in line of sight [m above the datum]; once called ceiling"),
        (
            Layer::LeastHeight,
            "Least UAV height over its place that sees the receiver, never below the surface under the UAV [m above the \
             datum]; infinite where no height is enough, minus infinite where nothing limits it, no surface under the UAV \
             either (in .tif, .asc and .bil 32768 and -32768)",
        ),
        (
            Layer::Stability,
            "How many of eight moves by one lattice step turn the answer, 0 to 8: the UAV east, west, north, south, up, \
             down, all roofs up, down (1/1024 m; of a raster horizontally 1/1024 cell). Costs eight more maps",
        ),
        (
            Layer::Count,
            "Number of UAVs that see the cell; nodata where nobody receives (NaN in .exr, 4294967295 in .npz)",
        ),
        (Layer::Which, "Which UAVs see the cell, one bit each"),
    ];
    let words = layers.map(|(layer, help)| match layer {
        Layer::LeastReceiverHeight => PossibleValue::new(layer.name()).alias("ceiling").help(help),
        _ => PossibleValue::new(layer.name()).help(help),
    });
    PossibleValuesParser::new(words).map(move |word| match word.as_str() {
        "ceiling" => Layer::LeastReceiverHeight,
        word => layers.map(|(layer, _)| layer).into_iter().find(|layer| layer.name() == word).unwrap_or(Layer::Los),
    })
}

/// The arrangements of the cells of a GeoTIFF.
fn tif_layout() -> impl TypedValueParser<Value = TiffLayout> {
    let words = [
        PossibleValue::new("cog").help("Tiles, deflated, with overviews"),
        PossibleValue::new("plain")
            .help("Strips of rows, uncompressed, without overviews: for simple readers, and for timing"),
    ];
    PossibleValuesParser::new(words).map(|word| if word == "plain" { TiffLayout::Plain } else { TiffLayout::Cog })
}
