//! What can be typed after `skyshed map`.

use std::path::PathBuf;

use clap::Args;

use crate::cli::args::height_errors::HeightErrorArgs;
use crate::cli::args::output::{OutputArgs, PictureArgs};
use crate::cli::args::scene::SceneArgs;
use crate::cli::args::sight::{SightArgs, UavsArgs};
use crate::cli::args::words::{Words, cells_per_side, number, one_of, range, shard, tile};
use crate::export::Layer;
use crate::formats::TiffLayout;
use crate::map::PolygonClasses;
use crate::uav::Shard;

/// The layers of a map, with what each holds.
const LAYERS: Words<Layer> = &[
    ("los", "Classes: 0 NLoS, 1 LoS, 2 not a receiver, 3 out of range, 255 nodata", Layer::Los),
    ("margin", "Receiver height less the least visible height [m]", Layer::Margin),
    ("least-receiver-height", "Least receiver height in line of sight [m above the datum]", Layer::LeastReceiverHeight),
    ("ceiling", "", Layer::LeastReceiverHeight),
    (
        "least-height",
        "Least UAV height over its place that sees the receiver, never below the surface under the UAV [m above the datum]; \
         infinite where no height is enough, minus infinite where nothing limits it, no surface under the UAV either (in \
         .tif, .asc and .bil 32768 and -32768)",
        Layer::LeastHeight,
    ),
    (
        "stability",
        "How many of eight moves by one lattice step turn the answer, 0 to 8: the UAV east, west, north, south, up, down, \
         all roofs up, down (1/1024 m; of a raster horizontally 1/1024 cell). Costs eight more maps",
        Layer::Stability,
    ),
    (
        "sure",
        "0 never, 1 surely, 2 possibly in line of sight, whatever heights of buildings are within --sigma standard deviations of \
         --height-error and --height-bias. Costs two more maps",
        Layer::Sure,
    ),
    (
        "p-los",
        "Probability of line of sight, 0 to 1, with errors of heights of footprints (--height-error, --height-bias)",
        Layer::PLos,
    ),
    ("p_los", "", Layer::PLos),
    (
        "count",
        "Number of UAVs that see the cell; nodata where nobody receives (NaN in .exr, 4294967295 in .npz)",
        Layer::Count,
    ),
    ("which", "Which UAVs see the cell, one bit each", Layer::Which),
    ("union", "Classes as in `los`, of all UAVs together: 1 where any sees the cell", Layer::Union),
    (
        "best-server",
        "The nearest UAV that sees the cell, by its number in the order of the UAVs from 1, in three dimensions, the first at \
         equal distances; 0 where none does, nodata where nobody receives",
        Layer::BestServer,
    ),
];

/// The arrangements of the cells of a GeoTIFF.
const TIFF_LAYOUTS: Words<TiffLayout> = &[
    ("cog", "Tiles, deflated, with overviews", TiffLayout::Cog),
    ("plain", "Strips of rows, uncompressed, without overviews: for simple readers, and for timing", TiffLayout::Plain),
];

const POLYGONS: Words<PolygonClasses> = &[
    ("los", "Cells in line of sight", PolygonClasses::Los),
    ("nlos", "Cells that are hidden", PolygonClasses::Nlos),
    ("all", "Both", PolygonClasses::All),
];

#[derive(Debug, Clone, Args)]
#[command(mut_arg("output", |a| a.help("File to write: .png .svg .pdf .tif .exr .asc .bil .npz .kmz .csv .json .geojson .fgb").long_help(
"File to write, by extension: .png .svg .pdf .tif .exr .asc .bil .npz .kmz .csv .json .geojson .fgb, `-` for JSON on standard \
output; repeat for more. Without any the table goes to standard output. With `{site}` in every name each UAV gets files of its \
own, which appear as soon as they are complete; with `{row}` and `{col}` each tile of the ground does, with the layers of all UAVs \
together. With `--radius`, a map of a raster is of the part in range, and no more is read")))]
#[command(
    mut_arg("sector", |a| a.hide_short_help(false)),
    after_help = "Example: skyshed map maps/munich.geojson --uav 691549.7,5334762.2,120 --radius 300 -o munich.png"
)]
pub(in crate::cli) struct MapArgs {
    #[command(flatten)]
    pub(in crate::cli) scene: SceneArgs,
    #[command(flatten, next_help_heading = "Map")]
    pub(super) uavs: UavsArgs,
    #[command(flatten, next_help_heading = "Map")]
    pub(super) sight: SightArgs,
    #[command(flatten, next_help_heading = "Map")]
    pub(super) heights: HeightErrorArgs,
    /// Standard deviations that heights are within for the layer `sure`; default 2
    #[arg(long, value_name = "K", value_parser = number, allow_hyphen_values = true, help_heading = "Map", hide_short_help = true)]
    pub(super) sigma: Option<f64>,
    /// How far P_LoS of any UAV may be off, such as 0.005: the map is made on the coarsest cells for which that is so with
    /// 99 % confidence, measured on a sample of receivers that are decided exactly; says what was taken and measured
    #[arg(long, value_name = "P", value_parser = number, allow_hyphen_values = true, help_heading = "Map",
          hide_short_help = true)]
    pub(super) tolerance: Option<f64>,
    /// Layers to make, separated by commas; pictures show the first
    ///
    /// Of several UAVs they show the number that see a cell for `los`, colors or a map each for the others.
    #[arg(long, value_name = "LAYER,…", value_parser = one_of(LAYERS), value_delimiter = ',', default_value = "los",
          help_heading = "Map", hide_possible_values = true)]
    pub(super) layers: Vec<Layer>,
    /// Count receivers by zone too (street, crossroad, courtyard, rooftop) in the table and the document: finding zones costs
    /// as much as a map or more
    #[arg(long, help_heading = "Map", hide_short_help = true)]
    pub(super) zones: bool,
    /// P_LoS as a function of the UAV's height over each place, exact: a plot (.png, .svg, .pdf), a table (.csv) or a document
    /// (.json); repeat for more.
    #[arg(long, value_name = "FILE", help_heading = "Height curve", hide_short_help = true)]
    pub(super) height_curve: Vec<PathBuf>,
    /// Heights of the curve's table and plot above the ground below the UAV (above the datum where none is known), both
    /// ends included [m]; default: some 150 round ones from the lowest that the UAV may have to three times the highest
    /// UAV or building, or to where 99 % of the receivers are seen
    #[arg(long, value_name = "A:B:S", value_parser = range, allow_hyphen_values = true, requires = "height_curve",
          help_heading = "Height curve", hide_short_help = true)]
    pub(super) curve_heights: Option<[f64; 3]>,
    #[command(flatten)]
    pub(in crate::cli) out: OutputArgs,
    /// PNG with one pixel per cell, a world file and a .prj, instead of a picture
    #[arg(long, help_heading = "Output", hide_short_help = true)]
    pub(super) bare: bool,
    /// Arrangement of the cells in .tif files; default cog
    #[arg(long, value_name = "HOW", value_parser = one_of(TIFF_LAYOUTS), help_heading = "Output", hide_short_help = true)]
    pub(super) tif_layout: Option<TiffLayout>,
    /// Mask of one UAV in .tif and .bil files as `gdal_viewshed` writes it: 255 in line of sight, 0 everywhere else, also out
    /// of range, and no nodata
    #[arg(long, help_heading = "Output", hide_short_help = true)]
    pub(super) gdal_values: bool,
    /// Coverage as polygons in .geojson and .fgb files, one per connected part of a class and site, holes kept
    #[arg(long, value_name = "CLASS", value_parser = one_of(POLYGONS), help_heading = "Output", hide_short_help = true)]
    pub(super) polygons: Option<PolygonClasses>,
    /// How far an outline of the polygons may be from the cell edges [m]; each stays valid, neighbors may overlap by as much
    #[arg(long, value_name = "M", value_parser = number, allow_hyphen_values = true, requires = "polygons",
          help_heading = "Output", hide_short_help = true)]
    pub(super) simplify: Option<f64>,
    /// Only the K-th of N nearly equal parts of the UAVs in their order, or of the tiles: for schedulers that hand out
    /// numbers
    #[arg(long, value_name = "K/N", value_parser = shard, help_heading = "Units of work",
          hide_short_help = true)]
    pub(super) shard: Option<Shard>,
    /// Only this tile of the ground, row from the north and column from the west, from 0; repeat for more
    #[arg(long, value_name = "ROW,COL", value_parser = tile, help_heading = "Units of work", hide_short_help = true)]
    pub(super) tile: Vec<(usize, usize)>,
    /// Cells along a side of a tile, a multiple of 16; default 2048
    #[arg(long, value_name = "N", value_parser = cells_per_side, help_heading = "Units of work", hide_short_help = true)]
    pub(super) tile_size: Option<usize>,
    /// Leave what is there already: a UAV or a tile is skipped if its files exist and were made by the same run, so that an
    /// interrupted one goes on where it stopped
    #[arg(long, help_heading = "Units of work", hide_short_help = true)]
    pub(super) resume: bool,
    /// Sweep a raster strip by strip from a copy in tiles on disk, also where it fits in memory: the same cells, less memory
    #[arg(long, help_heading = "Output", hide_short_help = true)]
    pub(super) strips: bool,
    /// Folder for that copy (4 bytes a cell, in a file without a name); default: the system's folder for temporary files
    #[arg(long, value_name = "FOLDER", help_heading = "Output", hide_short_help = true)]
    pub(super) scratch: Option<PathBuf>,
    #[command(flatten)]
    pub(super) picture: PictureArgs,
}
