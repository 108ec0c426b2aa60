//! Mosaics: one raster made of many, as a GDAL virtual raster (`.vrt`) or a folder of tiles.
//!
//! * A **virtual raster** says where each part of each source goes. It is read as GDAL reads it, number for number: cells
//!   in no source hold its nodata value (0 if it has none, which is told), later sources lie over earlier ones, a
//!   `ComplexSource` leaves out its own nodata value and scales the rest, numbers are rounded to the type of the band. Of
//!   the tiles only the numbers count, not their nodata value, scale, mask or place.
//! * Of a **folder** every `.tif`, `.tiff` and `.asc` file in it is a tile, in the order of their names; other files,
//!   folders in it and names that begin with a dot are left alone. The tiles lie on one grid, to a thousandth of a cell.
//!   Where they overlap the later one counts where it holds a height, and cells that differ are told. Cells in no tile
//!   are nodata.
//!
//! Opening reads the headers of all tiles and keeps little of each; no file stays open. Reading a window opens the tiles
//! that touch it, so that it costs what the window costs; several threads may read at once.
//!
//! Of its own it warns of overlapping tiles that differ (W336), and of cells in no source of a virtual raster without a
//! nodata value (W337).
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

pub(super) use numbers::TileNumbers;
pub use tiles::Mosaic;
pub(super) use tiles::{Content, Header, Nesting, Tile};
