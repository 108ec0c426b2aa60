//! Mosaics: one raster made of many, as a GDAL virtual raster (`.vrt`) or a folder of tiles.
//!
//! * A **virtual raster** lists the place of each part of each source. It is read as GDAL reads it,
//!   number for number. Cells in no source hold its nodata value, or 0 with a warning if it has
//!   none. Later sources lie over earlier ones. A `ComplexSource` leaves out its own nodata value
//!   and scales the rest. Numbers are rounded to the type of the band. Only the numbers of the
//!   tiles count, not their nodata value, scale or place, and their mask only with `UseMaskBand`.
//! * In a **folder** every `.tif`, `.tiff`, `.asc` and `.xyz` file is a tile, in the order of their
//!   names. So is a `.txt` file of points, and each raster in a `.gz` or `.zip`.
//!   Other files, folders in it and names that begin with a dot are ignored. The tiles lie on one
//!   grid, to a thousandth of a cell. Where tiles overlap, the later one counts if it holds a
//!   height; cells that differ are reported. Cells in no tile are nodata.
//!
//! Opening reads the headers of all tiles and keeps little of each; no file stays open. Reading a
//! window opens the tiles that touch it, so that the cost is that of the window. Several threads
//! may read at once.
//!
//! Two warnings are for mosaics alone: overlapping tiles that differ (W336), and cells in no source
//! of a virtual raster without a nodata value (W337).
//!
//! # References
//! GDAL, "VRT -- GDAL Virtual Format"; the rules of rounding are those of GDAL 3.6.

mod covered;
mod folder;
mod numbers;
mod tiles;
mod vrt;
mod vrt_source;
mod vrt_xml;

pub(super) use folder::packed_rasters;

pub(super) use numbers::TileNumbers;
pub use tiles::Mosaic;
pub(super) use tiles::{Content, Header, Nesting, Tile};
