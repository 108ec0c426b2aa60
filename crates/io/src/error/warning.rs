//! Oddities of files that stop nothing, as values.

use std::fmt::Display;

use skyshed_core::error::one_line;
use thiserror::Error as Words;

use super::read::some_of;
use crate::city::{FootprintFault, NodataAs};
use crate::quantity::{counted, fixed, tidy};

/// Oddity of files that did not stop the work: the finding and its treatment, on one line.
#[derive(Debug, Clone, PartialEq, Words)]
#[non_exhaustive]
pub enum Warning {
    /// A raster, whatever its role.
    #[error("{}", one_line(&.0.to_string()))]
    Raster(#[from] Oddity),
    /// A file of a scene, or a table: its name and its oddity.
    #[error("{}", one_line(&format!("{_0}: {_1}")))]
    File(String, OddFile),
    /// Files that are used together.
    #[error("{}", one_line(&.0.to_string()))]
    Combined(#[from] OddPair),
    /// W378: an extent was given, but no data area.
    #[error("all of the extent counts as known ground, also where no building is near")]
    WholeExtent,
}

/// A raster and its oddity.
#[derive(Debug, Clone, PartialEq, Words)]
#[error("`{name}` {odd}{}", likewise(*n_more))]
pub struct Oddity {
    /// Path, or name of held bytes.
    pub name: String,
    /// Oddity of the raster.
    pub odd: OddRaster,
    /// Number of other tiles with the same oddity.
    pub n_more: usize,
}

fn likewise(n_more: usize) -> String {
    match n_more {
        0 => String::new(),
        1 => " (and likewise one more tile)".into(),
        n => format!(" (and likewise {n} more tiles)"),
    }
}

/// Oddity of a raster, and its treatment.
#[derive(Debug, Clone, PartialEq, Words)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the words of the variants say what they are")]
pub enum OddRaster {
    #[error("declares nodata as `{0}`, which is no number: ignored")]
    Nodata(String),
    #[error("has a mask `{0}` beside it, which is not read: declare nodata instead")]
    Mask(String),
    #[error("has a sidecar `{0}` that cannot be read: ignored ({1})")]
    Sidecar(String, String),
    #[error("names no coordinate reference system: local coordinates in meters are assumed")]
    NoCrs,
    #[error("has no coordinate reference system (a `.prj` file): local coordinates in meters are assumed")]
    NoPrj,
    #[error("has GeoTIFF model type `{0}`, neither projected nor geographic: local coordinates in meters are assumed")]
    ModelType(u16),
    #[error("has damaged GeoKeys, which are ignored: {0}")]
    DamagedKeys(String),
    #[error("names a coordinate reference system that is not known ({0}): used by its name only")]
    CrsByName(String),
    #[error("names a coordinate reference system that is not understood ({0}): ignored")]
    CrsIgnored(String),
    #[error("says nowhere where it lies: its cells are taken as 1 m wide, its south-west corner as 0, 0")]
    NoPlace,
    #[error("has a later image that cannot be read and is ignored: {0}")]
    LaterImage(String),
    #[error("has its southernmost row first: its rows are turned over")]
    SouthUp,
    #[error("has a negative cell height: read as positive, north up")]
    NegativeHeight,
    #[error(
        "is in web Mercator, whose meters are stretched by 1/cos(latitude): lengths are multiplied by \
         {meters_per_unit:.4}, the cosine of {lat:.2} degrees in its middle, and are off by up to {} % at its edge",
        percent_up(*largest_error)
    )]
    WebMercator { meters_per_unit: f64, lat: f64, largest_error: f64, utm_epsg: u32 },
    #[error("gives its heights in units of {0} m; scenes convert them")]
    Unit(f64),
    #[error("has {n} bands{}: the first is read as heights", in_parentheses(names))]
    Bands { n: usize, names: Vec<String>, can_choose: bool },
    #[error("is a color picture of {n} bands: the first is read as heights")]
    Colors { n: usize, can_choose: bool },
    #[error("stores its heights scaled: multiplied by {0}, then {1} added")]
    Scaled(f64, f64),
    #[error("is JPEG-compressed: its heights are off by up to several units, and are used as they are")]
    Jpeg,
    #[error("gives its heights in units of {0} m by its band, of {1} m by its vertical system: the band is believed")]
    TwoUnits(f64, f64),
    #[error("has tiles of several bands (`{tile}` has {n}): the first is read as heights")]
    TileBands { tile: String, n: usize, can_choose: bool },
    #[error("has tiles that store their heights scaled (`{0}`: multiplied by {scale}, then {offset} added)", scale = .1.0, offset = .1.1)]
    TileScaling(String, (f64, f64)),
    #[error("has {}: read as void", .0.with("NaN"))]
    NotNumbers(CellsFound),
    #[error("has {}: read as void", .0.with("an infinite height"))]
    Infinite(CellsFound),
    #[error("has {}: kept as heights", .0.with("a height at or below -9000 or at or above 32000"))]
    Unlikely(CellsFound),
    #[error("stores nothing for {} (sparse file): read as void", counted(*.0, "cell", "cells"))]
    Sparse(u64),
    #[error(
        "has {} in no source and declares no nodata value: they are {empty} there, as in GDAL",
        counted(*n, "cell", "cells")
    )]
    Gaps { n: u64, empty: f64 },
}

/// Lists bands by number and name in parentheses, if any has a name; the first of many.
fn in_parentheses(names: &[String]) -> String {
    if names.iter().any(|name| name.contains('`')) { format!(" ({})", some_of(names)) } else { String::new() }
}

/// Formats a share in percent, rounded up to a tenth, or to a hundredth below 1 %.
fn percent_up(share: f64) -> String {
    let percent = share * 100.0;
    let step = if percent < 1.0 { 0.01 } else { 0.1 };
    tidy((percent / step).ceil() * step).to_string()
}

/// Cells of one kind: their number, and the first and last row and column among them, counted from
/// 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[expect(missing_docs, reason = "the docs of the type say what its fields are")]
pub struct CellsFound {
    pub count: u64,
    pub rows: (usize, usize),
    pub cols: (usize, usize),
}

impl CellsFound {
    fn with(&self, what: &str) -> String {
        let ((top, bottom), (left, right)) = (self.rows, self.cols);
        let cells = counted(self.count, "cell", "cells");
        format!("{cells} with {what} (rows {top} to {bottom}, columns {left} to {right})")
    }
}

/// Oddity of a file of a scene or of a table, and its treatment.
#[derive(Debug, Clone, PartialEq, Words)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the docs of a variant say what its fields are")]
pub enum OddFile {
    /// W325: a file names no reference system.
    #[error("no coordinate reference system; local meters are assumed")]
    NoCrs,
    /// W335: footprints were transformed to another system; both systems, and the name of the new
    /// one.
    #[error("brought from {from} to {to} ({name})")]
    Projected { from: String, to: String, name: String },
    /// W338: more tiles than documents name; both numbers.
    #[error("{n} tiles, of which documents name none (they name up to {most})")]
    ManyTiles { n: usize, most: usize },
    /// W339: a raster was transformed to another system; columns and rows, edge of a cell, largest
    /// distance to a source cell \[m\], and number of cells outside of the file.
    #[error(
        "brought from {from} to {to} ({name}), onto {}×{} cells of {} m: each takes the height of the cell of the file that \
         holds its center and whose own center is at most {} m away{}",
        shape[0], shape[1], tidy(*cell_m), tidy(*farthest_m), outside(*n_outside)
    )]
    Resampled {
        from: String,
        to: String,
        name: String,
        shape: [usize; 2],
        cell_m: f64,
        farthest_m: f64,
        n_outside: u64,
    },
    /// W340: cells of a surface hold no height.
    #[error("{} without a height: nodata {} and holds no receiver", counted(*n, "cell", "cells"), effect(*nodata_as))]
    Voids { n: u64, nodata_as: NodataAs },
    /// W340: cells of a terrain on the grid of the surface hold no height.
    #[error("{n} of {of} cells of the terrain have no height and are no receivers")]
    TerrainVoids { n: usize, of: usize },
    /// W341: a terrain is above the surface in some cells.
    #[error("the terrain is above the surface in {n} of {of} cells; the higher one is used there")]
    HighTerrain { n: u64, of: usize },
    /// W341: flat ground \[m above the datum\] is above the surface in some cells.
    #[error("the ground at {ground_m} m is above the surface in {n} of {of} cells; the higher one is used there")]
    HighGround { ground_m: f64, n: u64, of: usize },
    /// W342: a surface model alone, without ground.
    #[error("a surface model alone, so receivers stand on the surface, roofs included")]
    SurfaceAlone,
    /// W343: coordinates are in units of another length than 1 m; that length \[m\].
    #[error("coordinates are in units of {0} m; lengths and heights are in meters")]
    NotInMeters(f64),
    /// W344: more cells a side than one map has.
    #[error("more than 65536 cells a side")]
    ManyCells,
    /// W350–W368: faults of footprints with one fixed treatment, and their number.
    #[error("{}: {}", fault_words(*.0, *.1), .0.done())]
    Fault(FootprintFault, usize),
    /// W354: footprints without a height; their number, their treatment, and whether some got none
    /// for want of rules.
    #[error("{}: {treated}", fault_words(FootprintFault::MissingHeight, *n))]
    MissingHeights { n: usize, treated: String, asks_nothing: bool },
    /// W355, W361, W382: footprints with a height are left out; their number, and their share of
    /// the area of all that have one.
    #[error("{}: left out, {} % of the area with a height", fault_words(*fault, *n), fixed(100.0 * area_share, 1))]
    LeftOut { fault: FootprintFault, n: usize, area_share: f64 },
    /// W363: buildings are drawn by their parts; their number, and the area of outlines as high as
    /// the lowest part \[m²\].
    #[error(
        "{}: the parts stand in place of the outline; beside them {} m² stand as high as the lowest part",
        fault_words(FootprintFault::Part, *n), fixed(*area_m2, 0)
    )]
    Rests { n: usize, area_m2: f64 },
    /// W359: no building is left.
    #[error("no building is left; every link is unobstructed")]
    NoBuilding,
    /// W360: no footprint meets the grid; their number, and west, south, east, north of the grid
    /// \[CRS units\].
    #[error(
        "none of {n} footprints meets the grid, x {}…{}, y {}…{}; check the coordinate reference systems",
        grid[0], grid[2], grid[1], grid[3]
    )]
    NoneMeets { n: usize, grid: [f64; 4] },
    /// W366: solids begin on another height than the ground; the ground, their lowest and highest
    /// base, and the median \[m above the datum\].
    #[error(
        "the ground is at {} m, but the buildings begin at {} to {} m above the datum",
        tidy(*ground_m), tidy(range_m.0), tidy(range_m.1)
    )]
    OtherGround { ground_m: f64, range_m: (f64, f64), median_m: f64 },
    /// W366: the ground was taken from the buildings; the median of their bases, the lowest and the
    /// highest \[m above the datum\].
    #[error(
        "heights are above the datum: the ground is taken at {} m, the median of where buildings begin, {} to {} m",
        tidy(*ground_m), tidy(range_m.0), tidy(range_m.1)
    )]
    GroundOfBases { ground_m: f64, range_m: (f64, f64) },
    /// W375: sloped roofs are taken flat; the number of buildings.
    #[error(
        "{} that slope: taken flat, as high as they are highest",
        counted(*n as u64, "building has surfaces of a roof", "buildings have surfaces of roofs")
    )]
    FlatRoofs { n: usize },
    /// W367: cells of a mesh without a face; their number, and whether the ground there is known.
    #[error("{} without a face: {}", counted(*n, "cell", "cells"), if *is_known { "taken as bare ground" } else { "nodata" })]
    NoFace { n: u64, is_known: bool },
    /// W384: a system whose northing comes first by its authority; the system, whether the file was read
    /// so, and its first position as it stands there.
    #[error(
        "positions such as {}, {} in {system}, whose authority puts the northing first: read as {}, {}",
        tidy(first[0]), tidy(first[1]),
        if *is_swapped { "northing, easting" } else { "easting, northing" },
        "writers disagree about the order"
    )]
    NorthFirst { system: String, is_swapped: bool, first: [f64; 2] },
    /// W383: a scene of several files; the number of those that were read, outside of the extent, and
    /// without features, and of buildings that stand in two of them.
    #[error(
        "a scene of {}{}{}{}", counted(*n_read as u64, "file", "files"),
        more(*n_outside, "outside of the extent left unread"), more(*n_repeated, "buildings that stand in two files counted once"),
        more(*n_others, "others left out, which hold no scene")
    )]
    Tiles { n_read: usize, n_outside: usize, n_repeated: usize, n_others: usize },
    /// W332: heights without a unit are in that of the coordinates; that length \[m\].
    #[error("the unit of its heights is not named: taken as {0} m, that of its coordinates")]
    HeightUnit(f64),
    /// W390: a point cloud without roofs.
    #[error(
        "no point is of class 6 (building): the highest last return of a cell is its surface, so that trees count as walls"
    )]
    NoRoofClass,
    /// W391: cells of a point cloud are larger than 1 m; their edge \[m\], and the share of cells of 1 m with ground.
    #[error(
        "cells of {cell_m} m: of those of 1 m that hold points, and no roof, {} % hold ground, wanted 90 %",
        fixed(100.0 * share, 0)
    )]
    LargerCells { cell_m: u64, share: f64 },
    /// W392: points beyond the bounds in the headers of their files; their number.
    #[error("{} outside of the bounds in its header: left out", counted(*n, "point lies", "points lie"))]
    OutsideHeader { n: u64 },
    /// W386: a path whose third coordinates are all 0.
    #[error("its third coordinates are all 0: taken as none")]
    ZeroHeights,
    /// W380: rows of a table were left out; their number, the number of all, and their faults.
    #[error("{n} of {of} rows {} left out: {told}", if *n == 1 { "was" } else { "were" })]
    BadRows { n: usize, of: usize, told: String },
}

fn more(n: usize, what: &str) -> String {
    if n == 0 { String::new() } else { format!("; {n} {what}") }
}

fn outside(n: u64) -> String {
    match n {
        0 => String::new(),
        n => format!("; {} outside of it, nodata", counted(n, "cell lies", "cells lie")),
    }
}

fn effect(nodata_as: NodataAs) -> &'static str {
    match nodata_as {
        NodataAs::Clear => "blocks nothing but by the ground known there",
        NodataAs::Block => "blocks everything",
    }
}

fn fault_words(fault: FootprintFault, n: usize) -> String {
    let [one, many] = fault.names();
    counted(n as u64, one, many)
}

/// Oddity of files that are used together, and its treatment.
#[derive(Debug, Clone, PartialEq, Words)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the docs of a variant say what its fields are")]
pub enum OddPair {
    /// W320: tiles of a folder hold numbers that are no heights.
    #[error("tiles of `{folder}` have {} with NaN or an infinite height: read as void", counted(*n, "cell", "cells"))]
    TilesNotFinite { folder: String, n: u64 },
    /// W336: tiles of a folder differ where they overlap.
    #[error(
        "tiles of `{folder}` overlap and differ: {} under another one of a later tile by name, which counts (a folder should \
         hold one raster of each place)",
        counted(*n, "height lies", "heights lie")
    )]
    TilesDiffer { folder: String, n: u64 },
    /// W346: a terrain on another grid than the surface; both with their grids.
    #[error("{terrain} is not on the grid of {surface}: each cell takes the terrain that holds its center{}", without(*n_void, *of))]
    OtherGrid { terrain: String, surface: String, n_void: usize, of: usize },
    /// W370: only one of two files names its vertical system.
    #[error("{without} does not say what its heights are above; {taken} is taken, as {with} says")]
    NoVertical { without: String, with: String, taken: String },
    /// W371: heights above two datums.
    #[error("{0}: they are combined as they are; how far the two are apart is not known here")]
    TwoDatums(String),
}

fn without(n_void: usize, of: usize) -> String {
    match n_void {
        0 => String::new(),
        n => format!("; {n} of {of} cells have no terrain and are no receivers"),
    }
}

impl OddRaster {
    pub(crate) fn number(&self) -> u16 {
        match self {
            OddRaster::NotNumbers(_) | OddRaster::Infinite(_) => 320,
            OddRaster::Sparse(_) => 321,
            OddRaster::Nodata(_) => 322,
            OddRaster::Bands { .. } | OddRaster::Colors { .. } | OddRaster::TileBands { .. } => 323,
            OddRaster::Mask(_) | OddRaster::Sidecar(..) => 324,
            OddRaster::NoCrs | OddRaster::NoPrj | OddRaster::ModelType(_) => 325,
            OddRaster::DamagedKeys(_) | OddRaster::CrsByName(_) | OddRaster::CrsIgnored(_) => 326,
            OddRaster::NoPlace => 327,
            OddRaster::Unlikely(_) => 328,
            OddRaster::LaterImage(_) => 329,
            OddRaster::SouthUp | OddRaster::NegativeHeight => 330,
            OddRaster::WebMercator { .. } => 331,
            OddRaster::Unit(_) => 332,
            OddRaster::Scaled(..) | OddRaster::TileScaling(..) => 333,
            OddRaster::Jpeg => 334,
            OddRaster::Gaps { .. } => 337,
            OddRaster::TwoUnits(..) => 372,
        }
    }
}

impl OddFile {
    fn number(&self) -> u16 {
        match self {
            OddFile::NoCrs => 325,
            OddFile::Projected { .. } => 335,
            OddFile::ManyTiles { .. } => 338,
            OddFile::Resampled { .. } => 339,
            OddFile::Voids { .. } | OddFile::TerrainVoids { .. } => 340,
            OddFile::HighTerrain { .. } | OddFile::HighGround { .. } => 341,
            OddFile::SurfaceAlone => 342,
            OddFile::NotInMeters(_) => 343,
            OddFile::ManyCells => 344,
            OddFile::Fault(fault, _) => fault.code(),
            OddFile::MissingHeights { .. } => FootprintFault::MissingHeight.code(),
            OddFile::NoBuilding => 359,
            OddFile::NoneMeets { .. } => 360,
            OddFile::OtherGround { .. } | OddFile::GroundOfBases { .. } => 366,
            OddFile::LeftOut { fault, .. } => fault.code(),
            OddFile::Rests { .. } => FootprintFault::Part.code(),
            OddFile::NoFace { .. } => 367,
            OddFile::FlatRoofs { .. } => 375,
            OddFile::Tiles { .. } => 383,
            OddFile::NorthFirst { .. } => 384,
            OddFile::ZeroHeights => 386,
            OddFile::BadRows { .. } => 380,
            OddFile::HeightUnit(_) => 332,
            OddFile::NoRoofClass => 390,
            OddFile::LargerCells { .. } => 391,
            OddFile::OutsideHeader { .. } => 392,
        }
    }
}

impl Warning {
    /// Returns the warning about a file of a scene, or a table.
    pub(crate) fn of(name: impl Display, odd: OddFile) -> Warning {
        Warning::File(name.to_string(), odd)
    }

    /// Returns the stable code, for example `W320`.
    pub fn code(&self) -> String {
        let number = match self {
            Warning::Raster(oddity) => oddity.odd.number(),
            Warning::File(_, odd) => odd.number(),
            Warning::Combined(OddPair::TilesNotFinite { .. }) => 320,
            Warning::Combined(OddPair::TilesDiffer { .. }) => 336,
            Warning::Combined(OddPair::OtherGrid { .. }) => 346,
            Warning::Combined(OddPair::NoVertical { .. }) => 370,
            Warning::Combined(OddPair::TwoDatums(_)) => 371,
            Warning::WholeExtent => 378,
        };
        format!("W{number}")
    }
}
