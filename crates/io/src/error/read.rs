//! Files that cannot be read, or not used in their role.

use crate::format::Conversion;
use std::fmt::{self, Display};

use thiserror::Error as Words;

/// A file that cannot be read, or not used in its role.
#[derive(Debug, Clone, PartialEq)]
pub struct ReadError {
    /// Path, or name of held bytes.
    pub name: String,
    /// Place in the file.
    pub place: Option<Place>,
    /// Fault of the file.
    pub fault: ReadFault,
    /// Known cause.
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

/// Fault of a file.
#[derive(Debug, Clone, PartialEq, Words)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the docs of a variant say what its fields are")]
pub enum ReadFault {
    /// E301: there is no such file.
    #[error("no such file")]
    Missing,
    /// E301: the system refuses to open the file.
    #[error("{0}")]
    CannotOpen(String),
    /// E301: a stream that can be read once, from its beginning.
    #[error("it is a pipe or a device, wanted a file: it is read in any order")]
    NoFile,
    /// E301: a file beside it is missing; its path, and what it would hold.
    #[error("{0} is missing, {1}")]
    NoSidecar(String, &'static str),
    /// E302: a file whose content is wrong.
    #[error("{0}")]
    Malformed(String),
    /// E302: bad rows or features in a file of sites or of a track; its kind, and whether other
    /// rows are good.
    #[error("{what}")]
    Rows { what: String, of: PlacesIn, some_are_good: bool },
    /// E303: a file that ends before it should.
    #[error("{0}")]
    Truncated(String),
    /// E304: a part of the format that is not supported.
    #[error("{0}")]
    Unsupported(String),
    /// E304: a layer, by its name, that is a view or has no geometry.
    #[error("layer `{0}` is no table with a geometry column")]
    NoTable(String),
    /// E305: no cell holds a height; the number of cells, and the verb of the message.
    #[error("none of the {0} cells {1} a height, wanted at least one")]
    AllVoid(u64, String),
    /// E306: a raster that is not north-up.
    #[error("{0}")]
    Rotated(String),
    /// E307: a raster whose cells are no regular grid.
    #[error("{0}")]
    Irregular(String),
    /// E308: a file without the wanted content.
    #[error("{0}")]
    Nothing(Wanted),
    /// E309: a footprint has no height; its id, and the property that was read.
    #[error("feature `{0}` has no usable `{1}`")]
    HeightMissing(String, String),
    /// E309: too many footprints have no height.
    #[error("{0}")]
    HeightsMissing(HeightsMissing),
    /// E310: a file whose reference system cannot be used; its name in the file, and the fault.
    #[error("{0}: {1}")]
    Crs(String, String),
    /// E310: a `crs` member of an unsupported type.
    #[error("its `crs` is of type `{0}`, wanted a name")]
    CrsMember(String),
    /// E310: a reference system in a file that is not understood.
    #[error("{0}")]
    CrsNotUnderstood(String),
    /// E310: a file that names no reference system.
    #[error("it names no coordinate reference system")]
    NoCrs,
    /// E310: a file in degrees; its reference system, its kind, and longitude and latitude of its
    /// middle \[deg\].
    #[error("it is in degrees ({crs})")]
    Degrees { crs: String, kind: InputKind, center: (f64, f64) },
    /// E310: positions that span less than a unit of the named system, so that they are in another
    /// one.
    #[error("all its positions lie within a unit of {0}, as longitudes and latitudes of a city would")]
    LikeDegrees(String),
    /// E310: footprints in web Mercator; their reference system, and the file that names it.
    #[error("it is in web Mercator ({crs})")]
    WebMercator { crs: String, named_by: Namer },
    /// E312: a mesh without a face over the grid; the grid in words.
    #[error("no face covers a cell of the grid, {0}")]
    NoFaceInGrid(String),
    /// E365: no feature has the property of heights; other properties: likely heights, likely
    /// storeys, all others. Heights in the geometry are none of buildings.
    #[error("no feature has the property `{wanted}`, wanted one that holds heights{}", of_z(*has_z))]
    NoHeightProperty {
        wanted: String,
        like_heights: Vec<String>,
        like_storeys: Vec<String>,
        others: Vec<String>,
        has_bases: bool,
        has_z: bool,
    },
    /// E365: no feature has the property of the ground below buildings.
    #[error("no feature has the property `{0}`, wanted one that holds the ground below buildings")]
    NoBaseProperty(String),
    /// E365: heights above a ground of unknown height; the property of the heights.
    #[error("nothing tells the ground below the buildings, which `{0}` needs, wanted a property of it or a ground")]
    NoBases(String),
    /// E365: no feature has the property of errors of heights.
    #[error("no feature has the property `{0}`, wanted one that holds errors of heights")]
    NoErrorProperty(String),
    /// E365: an invalid error of a height; the id of the footprint, and the error \[m\].
    #[error("feature `{0}` has a height that is off by `{1}` m, wanted 0 m to 1000 m")]
    HeightError(String, f64),
    /// E108: a file without the wanted table; the name, and the tables that exist.
    #[error("it has no layer `{0}`, wanted one of {names}", names = quoted(.1))]
    NoLayer(String, Vec<String>),
    /// E108: a file with several tables, of which none was chosen.
    #[error("it has the layers {names}, wanted one", names = quoted(.0))]
    Layers(Vec<String>),
    /// E108: a raster without the wanted band; the band, and the bands that exist.
    #[error("it has no band `{wanted}`, wanted one of {}", some_of(bands))]
    NoBand { wanted: String, bands: Vec<String> },
    /// E205: a height beyond the lattice; the object that has it, and the height \[m above the
    /// datum\].
    #[error("{0} has height `{1}` m, wanted within ±32768 m of the datum")]
    HeightRange(HeightOf, f64),
    /// E206: positions in a reference system, but the scene names none.
    #[error("positions in {0}, but the scene names no CRS")]
    NoSceneCrs(String),
    /// E206: positions that cannot be brought into the scene; which and why, whether they are
    /// longitude and latitude, and whether others are good.
    #[error("{what}")]
    Misplaced { what: String, is_degrees: bool, some_are_good: bool },
    /// E208: an area that does not meet the scene; west, south, east, north of the scene \[CRS
    /// units\].
    #[error("its polygons lie outside the scene, which reaches over x {}…{}, y {}…{}", .0[0], .0[2], .0[1], .0[3])]
    OutsideScene([f64; 4]),
    /// E501: more data than memory holds.
    #[error("{0}")]
    Memory(String),
    /// E502: more parts than a reader accepts.
    #[error("{0}")]
    TooMany(String),
    /// E502: a grid larger than any map; columns and rows.
    #[error("the grid would have {0}×{1} cells, wanted at most 65536 a side")]
    GridTooLarge(f64, f64),
    /// E504: edges of a footprint cross too often; its id, and how often.
    #[error("feature `{0}` has {1}")]
    Tangle(String, String),
}

/// Footprints without heights, with the numbers that each policy depends on.
#[derive(Debug, Clone, PartialEq, Words)]
#[error(
    "{n_missing} of {n} footprints, {:.1} % of the footprint area, have no usable `{property}`; wanted at most {:.0} %",
    100.0 * share,
    100.0 * most
)]
pub struct HeightsMissing {
    /// Number of footprints without a height.
    pub n_missing: usize,
    /// Number of all footprints.
    pub n: usize,
    /// Share of the area without a height.
    pub share: f64,
    /// Largest share that is left out.
    pub most: f64,
    /// Property that was read.
    pub property: String,
    /// List of rules for missing heights, as it was typed; empty without one.
    pub rules: String,
    /// `true` if heights are those of tops above the datum.
    pub is_top: bool,
    /// Number of footprints without a height that have storeys, if the list has no rule for
    /// storeys.
    pub n_storeys: usize,
    /// Median of the known heights \[m\].
    pub median_m: Option<f64>,
}

/// Kind of a file in degrees, with the program that projects it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InputKind {
    /// A raster: `gdalwarp`.
    Raster,
    /// Vectors: `ogr2ogr`.
    Vector,
    /// Points: `pdal`.
    PointCloud,
}

/// The file that names the reference system of footprints.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[expect(missing_docs, reason = "the names of the variants say it")]
pub enum Namer {
    Footprints,
    Terrain,
}

/// Expected content of a file of places.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[expect(missing_docs, reason = "the names of the variants say it")]
pub enum PlacesIn {
    SiteTable,
    SiteFeatures,
    TrackTable,
    TrackFeatures,
    /// A table of a path whose heights do not say above what they are.
    PathHeights,
    /// A path in another format.
    Path,
}

/// Object that has a height.
#[derive(Debug, Clone, PartialEq, Eq, Words)]
#[expect(missing_docs, reason = "the names of the variants say it")]
pub enum HeightOf {
    #[error("a cell")]
    Cell,
    #[error("a vertex")]
    Vertex,
    #[error("a point")]
    Point,
    #[error("feature `{0}`")]
    Feature(String),
}

/// Content that a file lacks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Words)]
pub enum Wanted {
    /// An area.
    #[error("it holds no polygon, wanted a Polygon or MultiPolygon")]
    Area,
    /// Footprints, which set the extent of the grid.
    #[error("it holds no polygon, so the grid's extent is unknown")]
    Extent,
    /// A building, among areas that all represent nothing above the ground.
    #[error("none of its areas is a building above the ground, so the grid's extent is unknown")]
    Building,
    /// Sites.
    #[error("it holds no site")]
    Sites,
    /// Two different places; the number found.
    #[error("found {0} different places, wanted at least 2")]
    Places(usize),
    /// Tiles in a folder.
    #[error("a folder without .tif, .tiff, .asc or .xyz files, wanted tiles")]
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
    /// Points.
    #[error("it holds no point")]
    Points,
    /// Points in an extent.
    #[error("none of its points lies in the extent")]
    PointsInExtent,
    /// Points of the ground.
    #[error("none of its points is of class 2 (ground), wanted some, or a ground of another file")]
    Ground,
    /// Surfaces of roofs.
    #[error("it holds no surface of a roof, wanted CityJSON, CityGML, polygons with heights or a mesh of buildings")]
    Roofs,
}

/// Known cause of a [`ReadFault`] beyond its text.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Cause {
    /// Nothing beyond the text.
    #[default]
    AsSaid,
    /// The file is cut short, or damaged.
    CutShort,
    /// Its header is damaged.
    DamagedHeader,
    /// A block of cells is damaged.
    DamagedBlock,
    /// Files of different sets.
    MixedFiles,
    /// `ncols` and `nrows` may be wrong, or the file is cut short.
    TooFewCells,
    /// `ncols` and `nrows` may be wrong.
    TooManyCells,
    /// Numbers with decimal commas.
    DecimalCommas,
    /// A format that is not read.
    Foreign(Conversion),
    /// A virtual raster that describes its files wrongly.
    StaleVrt,
    /// A virtual raster that GDAL can convert to one raster.
    ForGdal,
    /// Samples of an unsupported type.
    SampleType,
    /// Samples of one bit.
    OneBit,
    /// An unsupported compression.
    Compression,
    /// A block too large to hold.
    LargeBlock,
    /// Several bands in a JPEG.
    ColorJpeg,
    /// A place that the file describes incompletely.
    NoPlace,
    /// Ground control points.
    ControlPoints,
    /// Tiles that lie on different grids.
    OtherGrid,
    /// A tile of another place.
    FarTile,
    /// The nodata value in all cells.
    Nodata,
    /// Cells that are too large.
    LargeCells,
    /// A large raster, of which a part may suffice.
    LargeRaster,
    /// Points that are no grid: a cloud of points.
    PointCloud,
    /// A database that another program has open.
    OpenDatabase,
    /// A column that is computed when it is read.
    GeneratedColumn,
    /// A format that the program was built without.
    NotBuilt,
    /// A file of places or of an area: the options of the scene do not concern it.
    BesideScene,
}

/// Joins the first 12 names by commas, with an ellipsis for more.
pub(super) fn some_of(names: &[String]) -> String {
    const MOST: usize = 12;
    let more = if names.len() > MOST { ", …" } else { "" };
    format!("{}{more}", names[..names.len().min(MOST)].join(", "))
}

/// Returns the part of a message about heights in a geometry.
fn of_z(has_z: bool) -> &'static str {
    if has_z { "; the `z` of its areas may be that of roofs or of the ground" } else { "" }
}

/// Joins names in backticks.
fn quoted(names: &[String]) -> String {
    names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
}

impl ReadFault {
    pub(super) fn number(&self) -> u16 {
        use ReadFault::*;
        match self {
            NoLayer(..) | Layers(_) | NoBand { .. } => 108,
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
            Crs(..)
            | CrsMember(_)
            | CrsNotUnderstood(_)
            | NoCrs
            | Degrees { .. }
            | LikeDegrees(_)
            | WebMercator { .. } => 310,
            NoFaceInGrid(_) => 312,
            NoHeightProperty { .. } | NoBaseProperty(_) | NoBases(_) | NoErrorProperty(_) | HeightError(..) => 365,
            Memory(_) => 501,
            TooMany(_) | GridTooLarge(..) => 502,
            Tangle(..) => 504,
        }
    }

    /// Returns the verb of the failed use of the file.
    fn verb(&self) -> &'static str {
        use ReadFault::*;
        match self {
            AllVoid(..) | HeightMissing(..) | HeightsMissing(_) | NoFaceInGrid(_) => "use",
            NoHeightProperty { .. } | NoBaseProperty(_) | NoBases(_) | NoErrorProperty(_) | HeightError(..) => "use",
            HeightRange(..) | OutsideScene(_) | Tangle(..) => "use",
            Nothing(Wanted::Extent | Wanted::Building) | GridTooLarge(..) => "map",
            Nothing(Wanted::Tiles) => "read",
            Nothing(_) => "use",
            NoCrs => "project",
            CrsNotUnderstood(_) | LikeDegrees(_) | NoSceneCrs(_) | Misplaced { .. } => "place",
            _ => "read",
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
            (ReadFault::WebMercator { crs, .. }, _) => {
                let stretched = "whose meters are stretched by 1/cos(latitude)";
                write!(f, "`{name}` is in web Mercator ({crs}), {stretched}; wanted a system of true lengths")
            }
            (_, Some(place)) => write!(f, "cannot {} {name}: {place}: {fault}", fault.verb()),
            (_, None) => write!(f, "cannot {} {name}: {fault}", fault.verb()),
        }
    }
}
