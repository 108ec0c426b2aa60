//! What can go wrong with files, as values: an [`Error`] by what it stopped, with the cause inside.
//!
//! Codes and classes are those of [`skyshed_core::error`]. Every text is one line without control characters, and passages in
//! backticks are cut. No text names a flag: what to do about an error is said by whoever knows how it was asked for.

use std::fmt::{self, Display};

use skyshed_core::error::one_line;
pub use skyshed_core::error::{ErrorClass, MOST_FOUND, Warning, io_words, is_text, shortened};
use thiserror::Error as Words;

use crate::export::{Format, Layer};
use crate::raster::Crs;

/// The result of every fallible function of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// The error of every fallible function of this crate.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Error {
    /// Of a stage below this crate.
    Core(skyshed_core::Error),
    /// A file that cannot be read, or not used for what it was given as.
    Read(Box<ReadError>),
    /// Two files that do not belong together.
    Combine(CombineError),
    /// A reference system that is not known, or not reached.
    Crs(CrsError),
    /// An option that makes no sense.
    Option(OptionError),
    /// A file that cannot be written: its path, or what is written, and why not.
    Write(String, WriteFault),
    /// An error within a larger thing.
    Within(Box<Error>, String),
}

/// A file that cannot be read, or not used for what it was given as.
#[derive(Debug, Clone, PartialEq)]
pub struct ReadError {
    /// The path, or the name of what was held.
    pub name: String,
    /// Where in it.
    pub place: Option<Place>,
    /// What is wrong.
    pub fault: ReadFault,
    /// What is known of the cause.
    pub cause: Cause,
}

/// A place in a file, counted from 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Words)]
pub enum Place {
    /// A line.
    #[error("line {0}")]
    Line(u64),
    /// A feature.
    #[error("feature {0}")]
    Feature(u64),
}

/// What is wrong with a file.
#[derive(Debug, Clone, PartialEq, Words)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the docs of a variant say what its fields are")]
pub enum ReadFault {
    /// E301: there is no such file.
    #[error("no such file")]
    Missing,
    /// E301: the system refuses it.
    #[error("{0}")]
    CannotOpen(String),
    /// E301: it can be read once, from its beginning.
    #[error("it is a pipe or a device, wanted a file: it is read in any order")]
    NoFile,
    /// E301: a file beside it is missing; its path, and what it would hold.
    #[error("{0} is missing, {1}")]
    NoSidecar(String, &'static str),
    /// E302: it is not what it should be.
    #[error("{0}")]
    Malformed(String),
    /// E302: rows or features of a file of places, which was to hold sites or a track; others may be good.
    #[error("{what}")]
    Rows { what: String, of: PlacesIn, some_are_good: bool },
    /// E303: it ends before it should.
    #[error("{0}")]
    Truncated(String),
    /// E304: what the format allows but is not read.
    #[error("{0}")]
    Unsupported(String),
    /// E304: a layer, by its name, that is a view or has no geometry.
    #[error("layer `{0}` is no table with a geometry column")]
    NoTable(String),
    /// E305: no cell holds a height, of so many, which are said.
    #[error("none of the {0} cells {1} a height, wanted at least one")]
    AllVoid(u64, String),
    /// E306: it is not north-up.
    #[error("{0}")]
    Rotated(String),
    /// E307: its cells are no regular grid.
    #[error("{0}")]
    Irregular(String),
    /// E308: it holds nothing of what is wanted.
    #[error("{0}")]
    Nothing(Wanted),
    /// E309: a footprint has no height; its id, and the property that was looked at.
    #[error("feature `{0}` has no usable `{1}`")]
    HeightMissing(String, String),
    /// E309: too many footprints have no height.
    #[error("{0}")]
    HeightsMissing(HeightsMissing),
    /// E310: it names a reference system that cannot be used; how, and what is wrong with that.
    #[error("{0}: {1}")]
    Crs(String, Box<Error>),
    /// E310: it names a reference system in a way that is not read.
    #[error("its `crs` is of type `{0}`, wanted a name")]
    CrsMember(String),
    /// E310: what it says of its reference system is not understood.
    #[error("{0}")]
    CrsNotUnderstood(String),
    /// E310: it names no reference system.
    #[error("it names no coordinate reference system")]
    NoCrs,
    /// E310: it is in degrees; its reference system, its kind, and longitude and latitude of its middle \[deg\].
    #[error("it is in degrees ({crs})")]
    Degrees { crs: String, kind: InputKind, center: (f64, f64) },
    /// E312: a mesh has no face over the grid, which is described.
    #[error("no face covers a cell of the grid, {0}")]
    NoFaceInGrid(String),
    /// E365: no feature has the property of heights; others that may hold heights, count storeys, or do neither.
    #[error("no feature has the property `{wanted}`, wanted one that holds heights")]
    NoHeightProperty { wanted: String, like_heights: Vec<String>, like_storeys: Vec<String>, others: Vec<String> },
    /// E108: it has no such table; what was asked for, and what there is.
    #[error("it has no layer `{0}`, wanted one of {names}", names = quoted(.1))]
    NoLayer(String, Vec<String>),
    /// E108: it has several tables, and none was asked for.
    #[error("it has the layers {names}, wanted one", names = quoted(.0))]
    Layers(Vec<String>),
    /// E205: something has a height beyond the lattice \[m above the datum\].
    #[error("{0} has height `{1}` m, wanted within ±32768 m of the datum")]
    HeightRange(HeightOf, f64),
    /// E206: positions in a system, but the scene names none.
    #[error("positions in {0}, but the scene names no CRS")]
    NoSceneCrs(String),
    /// E206: positions that cannot be brought into the scene: which, and why; whether they are longitude and latitude, and
    /// others are good.
    #[error("{what}")]
    Misplaced { what: String, is_degrees: bool, some_are_good: bool },
    /// E208: an area that does not meet the scene; west, south, east, north of that \[CRS units\].
    #[error("its polygons lie outside the scene, which reaches over x {}…{}, y {}…{}", .0[0], .0[2], .0[1], .0[3])]
    OutsideScene([f64; 4]),
    /// E501: more than memory holds.
    #[error("{0}")]
    Memory(String),
    /// E502: more parts than are read.
    #[error("{0}")]
    TooMany(String),
    /// E502: a grid larger than any map; columns and rows.
    #[error("the grid would have {0}×{1} cells, wanted at most 65536 a side")]
    GridTooLarge(f64, f64),
    /// E504: edges of a footprint cross too often; its id, and how often.
    #[error("feature `{0}` has {1}")]
    Tangle(String, String),
}

/// Footprints without heights, and what each policy would do about them.
#[derive(Debug, Clone, PartialEq, Words)]
#[error(
    "{n_missing} of {n} footprints, {:.1} % of the footprint area, have no usable `{property}`; wanted at most {:.0} %",
    100.0 * share,
    100.0 * most
)]
pub struct HeightsMissing {
    /// How many have none.
    pub n_missing: usize,
    /// Of how many.
    pub n: usize,
    /// Their share of the area.
    pub share: f64,
    /// The largest share that is left out.
    pub most: f64,
    /// The property that was looked at.
    pub property: String,
    /// How many of those without a height have storeys, in `levels_field`.
    pub n_storeys: usize,
    /// The property that counts storeys.
    pub levels_field: String,
    /// The median of the known heights \[m\].
    pub median_m: Option<f64>,
}

/// Which kind of file is in degrees, and which program brings it out of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InputKind {
    /// A raster: `gdalwarp`.
    Raster,
    /// Vectors: `ogr2ogr`.
    Vector,
}

/// What a file of places was to hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[expect(missing_docs, reason = "the names of the variants say it")]
pub enum PlacesIn {
    SiteTable,
    SiteFeatures,
    TrackTable,
    TrackFeatures,
}

/// What has a height.
#[derive(Debug, Clone, PartialEq, Eq, Words)]
#[expect(missing_docs, reason = "the names of the variants say it")]
pub enum HeightOf {
    #[error("a cell")]
    Cell,
    #[error("a vertex")]
    Vertex,
    #[error("feature `{0}`")]
    Feature(String),
}

/// What a file holds none of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Words)]
pub enum Wanted {
    /// An area.
    #[error("it holds no polygon, wanted a Polygon or MultiPolygon")]
    Area,
    /// Footprints that tell how large the grid is.
    #[error("it holds no polygon, so the grid's extent is unknown")]
    Extent,
    /// Sites.
    #[error("it holds no site")]
    Sites,
    /// Two places, of so many.
    #[error("found {0} different places, wanted at least 2")]
    Places(usize),
    /// Tiles in a folder.
    #[error("a folder without .tif, .tiff or .asc files, wanted tiles")]
    Tiles,
    /// Objects of CityJSON.
    #[error("its `CityObjects` are empty")]
    CityObjects,
    /// A table of a GeoPackage.
    #[error("it holds no table of features")]
    Layers,
    /// Faces of a mesh.
    #[error("it holds no face")]
    Faces,
}

/// What is known of the cause of a [`ReadFault`] beyond its words.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Cause {
    /// No more than the words say.
    #[default]
    AsSaid,
    /// The file is cut short, or damaged.
    CutShort,
    /// Its header is damaged.
    DamagedHeader,
    /// A block of cells is damaged.
    DamagedBlock,
    /// Its files are not of one set.
    MixedFiles,
    /// `ncols` and `nrows` may be wrong, or the file is cut short.
    TooFewCells,
    /// `ncols` and `nrows` may be wrong.
    TooManyCells,
    /// Decimal commas.
    DecimalCommas,
    /// A raster of another format.
    OtherRaster,
    /// One GeoJSON feature a line.
    FeatureALine,
    /// A virtual raster that does not tell its files as they are.
    StaleVrt,
    /// A virtual raster that GDAL can make one raster of.
    ForGdal,
    /// Samples of a type that is not read.
    SampleType,
    /// Samples of one bit.
    OneBit,
    /// A compression that is not read.
    Compression,
    /// A block too large to hold.
    LargeBlock,
    /// Several bands in a JPEG.
    ColorJpeg,
    /// A place that the file does not tell whole.
    NoPlace,
    /// Ground control points.
    ControlPoints,
    /// Tiles that lie on different grids.
    OtherGrid,
    /// A tile of another place.
    FarTile,
    /// Nodata that is declared wrongly, or not at all.
    Nodata,
    /// Cells that are too large.
    LargeCells,
    /// A raster of which a part may do.
    LargeRaster,
    /// Multipatches.
    Multipatch,
    /// A database that another program has open.
    OpenDatabase,
    /// A program that was built without a format.
    NotBuilt,
}

/// Two files that do not belong together.
#[derive(Debug, Clone, PartialEq, Words)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the docs of a variant say what its fields are")]
pub enum CombineError {
    /// E311: in different reference systems; the files, their systems, and what they are.
    #[error("cannot combine {} in {} with {} in {}: wanted one CRS", .names[0], .crs[0], .names[1], .crs[1])]
    TwoCrs { names: [String; 2], crs: [String; 2], pair: Pair },
    /// E311: above an ellipsoid and above a datum.
    #[error("cannot combine {0}: they are tens of meters apart, wanted one datum")]
    TwoDatums(String),
    /// E312: a surface, and a terrain that does not lie below it; both with their grids.
    #[error("cannot combine {0} with {1}: wanted a terrain below the surface, found none at any cell")]
    NoTerrainBelow(String, String),
}

/// What two files are that are combined. Tiles are those of one raster, or a virtual raster and one of its sources; a map is
/// that of an earlier run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the names of the variants say it")]
pub enum Pair {
    FootprintsTerrain,
    SurfaceTerrain,
    Tiles,
    SceneMap,
    WeightsScene,
}

/// A reference system that is not known, or not reached.
#[derive(Debug, Clone, PartialEq, Words)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the docs of a variant say what its fields are")]
pub enum CrsError {
    /// E310: the registry has no such code.
    #[error("unknown coordinate reference system: no EPSG code `{0}` in the registry")]
    UnknownCode(u32),
    /// E310: a text that defines none; its beginning, and what is wrong.
    #[error("cannot read the coordinate reference system `{0}`: {1}")]
    Unreadable(String, String),
    /// E310: no way leads from one to another, or not for the coordinates that are said.
    #[error("cannot transform {what} from `{from}` to `{to}`: {why}")]
    NoWay { what: String, from: String, to: String, why: String },
    /// E502: more cells than are counted.
    #[error("cannot reproject {0} cells: wanted below 2^32")]
    TooManyCells(usize),
}

/// An option that makes no sense.
#[derive(Debug, Clone, PartialEq, Words)]
#[non_exhaustive]
pub enum OptionError {
    /// E112: a size of cells.
    #[error("`cell_m` is `{0}`, wanted above 0 m")]
    Cell(f64),
    /// E113: a number out of range; its option, and what is wanted.
    #[error("`{0}` is `{1}`, wanted {2}")]
    Number(&'static str, f64, &'static str),
    /// E114: an extent.
    #[error("`extent` is `{},{},{},{}`, wanted west < east and south < north", .0[0], .0[1], .0[2], .0[3])]
    Extent([f64; 4]),
    /// E116: a size of cells for a file that keeps its own.
    #[error("`cell_m` has no meaning for {0}: it is in the wanted system and stays")]
    CellKept(String),
}

/// Why a file cannot be written.
#[derive(Debug, Clone, PartialEq, Words)]
#[non_exhaustive]
pub enum WriteFault {
    /// E104: no extension tells the format; what may be written.
    #[error("it has no extension, which tells the format")]
    NoExtension(Vec<Format>),
    /// E104: an unknown extension; what may be written.
    #[error("unknown extension `.{0}`")]
    Extension(String, Vec<Format>),
    /// E105: a format of other commands; what may be written.
    #[error("this command does not write that format")]
    NotThisFormat(Vec<Format>),
    /// E105: named twice.
    #[error("it is named twice")]
    Twice,
    /// E105: two outputs have it beside them.
    #[error("two outputs of this run need it")]
    Needed,
    /// E105: a folder.
    #[error("it is a folder")]
    Folder,
    /// E105: no file that can be replaced.
    #[error("it is a folder, a pipe or a device, wanted a file")]
    NoFile,
    /// E105: what the run reads.
    #[error("it is an input of this run")]
    Input,
    /// E105: the file beside it is what the run reads.
    #[error("its sidecar {0} is an input of this run")]
    SidecarIsInput(String),
    /// E105: it would become a tile of what the run reads.
    #[error("it would be a tile of the folder that this run reads")]
    Tile,
    /// E106: it is there.
    #[error("it exists")]
    Exists,
    /// E106: it is there, and was not when the run began.
    #[error("it exists, made while this run worked")]
    ExistsMeanwhile,
    /// E107: a format of one layer, and how many were asked for.
    #[error("{name} holds one layer of one site, found {1}", name = if *.0 == Format::Bil { "a .bil file" } else { "an ASCII grid" })]
    OneLayer(Format, usize),
    /// E107: a layer that the format shows is not asked for.
    #[error("it shows line of sight, which is not among the layers")]
    Without(Layer),
    /// E107: sets of more UAVs than a float holds, beside measures.
    #[error("`which` of more than 24 sites beside measures")]
    SetsBesideMeasures,
    /// E107: sets in which every number is one, beside counts.
    #[error("`count` beside `which` of 32 sites or more")]
    SetsBesideCounts,
    /// E109: footprints that are no boxes, of so many.
    #[error("{0} of {1} footprints are not rectangles parallel to the axes, as buildings of ns-3 are")]
    NoBoxes(usize, usize),
    /// E401: the system refuses it.
    #[error("{0}")]
    Refused(String),
    /// E401: a scratch file in a folder.
    #[error("{0}")]
    Scratch(String),
    /// E402: the format cannot hold it.
    #[error("{0}")]
    Encode(String),
    /// E502: more corners than a mesh counts.
    #[error("it has more than 2^31 corners")]
    Corners,
}

/// E311: two files in different reference systems.
pub(crate) fn two_crs((a, a_crs): (impl Display, &Crs), (b, b_crs): (impl Display, &Crs), pair: Pair) -> Error {
    let (names, crs) = ([a.to_string(), b.to_string()], [a_crs.label(), b_crs.label()]);
    CombineError::TwoCrs { names, crs, pair }.into()
}

/// Names in backticks.
fn quoted(names: &[String]) -> String {
    names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
}

impl Error {
    /// A file that cannot be read or used.
    pub(crate) fn read(name: impl Display, fault: ReadFault) -> Error {
        Error::Read(Box::new(ReadError { name: name.to_string(), place: None, fault, cause: Cause::AsSaid }))
    }

    pub(crate) fn malformed(name: impl Display, what: impl Into<String>) -> Error {
        Error::read(name, ReadFault::Malformed(what.into()))
    }

    pub(crate) fn truncated(name: impl Display, what: impl Into<String>) -> Error {
        Error::read(name, ReadFault::Truncated(what.into()))
    }

    pub(crate) fn unsupported(name: impl Display, what: impl Into<String>) -> Error {
        Error::read(name, ReadFault::Unsupported(what.into()))
    }

    /// A file that cannot be written.
    pub(crate) fn write(name: impl Display, fault: WriteFault) -> Error {
        Error::Write(name.to_string(), fault)
    }

    pub(crate) fn encode(name: impl Display, why: impl Display) -> Error {
        Error::write(name, WriteFault::Encode(why.to_string()))
    }

    pub(crate) fn refused(name: impl Display, cause: &std::io::Error) -> Error {
        Error::write(name, WriteFault::Refused(io_words(cause)))
    }

    /// The same error with its place in the file.
    pub(crate) fn at(mut self, place: Place) -> Error {
        if let Error::Read(read) = &mut self {
            read.place = Some(place);
        }
        self
    }

    /// The same error with what is known of its cause.
    pub(crate) fn because(mut self, cause: Cause) -> Error {
        if let Error::Read(read) = &mut self {
            read.cause = cause;
        }
        self
    }

    /// The same error within a larger thing, which stands at the end of its text, in parentheses.
    #[must_use]
    pub fn within(self, more: impl Display) -> Error {
        Error::Within(Box::new(self), more.to_string())
    }

    /// The class, which fixes the exit code of the command line.
    pub fn class(&self) -> ErrorClass {
        match self {
            Error::Core(error) => error.class(),
            Error::Within(error, _) => error.class(),
            Error::Write(_, WriteFault::Encode(_)) => ErrorClass::Internal,
            _ => match self.number() / 100 {
                1 => ErrorClass::Usage,
                2 => ErrorClass::Site,
                5 => ErrorClass::Limit,
                _ => ErrorClass::File,
            },
        }
    }

    /// The stable code, for example `E301`.
    pub fn code(&self) -> String {
        match self {
            Error::Core(error) => error.code(),
            error => format!("E{:03}", error.number()),
        }
    }

    /// The number of the code.
    fn number(&self) -> u16 {
        match self {
            Error::Core(error) => error.code().trim_start_matches('E').parse().unwrap_or(900),
            Error::Within(error, _) => error.number(),
            Error::Read(error) => error.fault.number(),
            Error::Combine(CombineError::TwoCrs { .. } | CombineError::TwoDatums(_)) => 311,
            Error::Combine(CombineError::NoTerrainBelow(..)) => 312,
            Error::Crs(CrsError::TooManyCells(_)) => 502,
            Error::Crs(_) => 310,
            Error::Option(OptionError::Cell(_)) => 112,
            Error::Option(OptionError::Number(..)) => 113,
            Error::Option(OptionError::Extent(_)) => 114,
            Error::Option(OptionError::CellKept(_)) => 116,
            Error::Write(_, fault) => fault.number(),
        }
    }
}

impl ReadFault {
    fn number(&self) -> u16 {
        use ReadFault::*;
        match self {
            NoLayer(..) | Layers(_) => 108,
            HeightRange(..) => 205,
            NoSceneCrs(_) | Misplaced { .. } => 206,
            OutsideScene(_) => 208,
            Missing | CannotOpen(_) | NoFile | NoSidecar(..) => 301,
            Malformed(_) | Rows { .. } => 302,
            Truncated(_) => 303,
            Unsupported(_) | NoTable(_) => 304,
            AllVoid(..) => 305,
            Rotated(_) => 306,
            Irregular(_) => 307,
            Nothing(_) => 308,
            HeightMissing(..) | HeightsMissing(_) => 309,
            Crs(..) | CrsMember(_) | CrsNotUnderstood(_) | NoCrs | Degrees { .. } => 310,
            NoFaceInGrid(_) => 312,
            NoHeightProperty { .. } => 365,
            Memory(_) => 501,
            TooMany(_) | GridTooLarge(..) => 502,
            Tangle(..) => 504,
        }
    }

    /// What cannot be done with the file.
    fn verb(&self) -> &'static str {
        use ReadFault::*;
        match self {
            AllVoid(..) | HeightMissing(..) | HeightsMissing(_) | NoFaceInGrid(_) => "use",
            NoHeightProperty { .. } | HeightRange(..) | OutsideScene(_) | Tangle(..) => "use",
            Nothing(Wanted::Extent) | GridTooLarge(..) => "map",
            Nothing(Wanted::Tiles) => "read",
            Nothing(_) => "use",
            NoCrs => "project",
            CrsNotUnderstood(_) | NoSceneCrs(_) | Misplaced { .. } => "place",
            _ => "read",
        }
    }
}

impl WriteFault {
    fn number(&self) -> u16 {
        use WriteFault::*;
        match self {
            NoExtension(_) | Extension(..) => 104,
            Exists | ExistsMeanwhile => 106,
            OneLayer(..) | Without(_) | SetsBesideMeasures | SetsBesideCounts => 107,
            NoBoxes(..) => 109,
            Refused(_) | Scratch(_) => 401,
            Encode(_) => 402,
            Corners => 502,
            _ => 105,
        }
    }
}

impl Display for ReadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ReadError { name, place, fault, .. } = self;
        match (fault, place) {
            (ReadFault::Degrees { crs, .. }, _) => {
                write!(f, "`{name}` is in degrees ({crs}); wanted a projected coordinate system in meters")
            }
            (_, Some(place)) => write!(f, "cannot {} {name}: {place}: {fault}", fault.verb()),
            (_, None) => write!(f, "cannot {} {name}: {fault}", fault.verb()),
        }
    }
}

impl Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = match self {
            Error::Core(error) => return error.fmt(f),
            Error::Read(error) => error.to_string(),
            Error::Combine(error) => error.to_string(),
            Error::Crs(error) => error.to_string(),
            Error::Option(error) => error.to_string(),
            Error::Write(name, fault @ WriteFault::Encode(_)) => format!("cannot encode {name}: {fault}"),
            Error::Write(name, fault) => format!("cannot write {name}: {fault}"),
            Error::Within(error, more) => format!("{error} ({more})"),
        };
        f.write_str(&one_line(&text))
    }
}

impl std::error::Error for Error {}

/// For traits of the core, through which it asks for windows of a scene.
impl From<Error> for skyshed_core::Error {
    fn from(error: Error) -> skyshed_core::Error {
        match error {
            Error::Core(error) => error,
            error => skyshed_core::Error::new(error.class(), error.number(), error.to_string()),
        }
    }
}

macro_rules! from {
    ($($of:ident: $kind:ty),*) => {$(
        impl From<$kind> for Error {
            fn from(error: $kind) -> Error {
                Error::$of(error)
            }
        }
    )*};
}

from!(Core: skyshed_core::Error, Combine: CombineError, Crs: CrsError, Option: OptionError);
