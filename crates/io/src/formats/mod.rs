//! Formats of rasters: one file or folder for each.
//!
//! Formats know nothing of line of sight.

mod ascii_grid;
mod band;
mod bil_file;
mod cell_sources;
#[cfg(feature = "exr")]
mod exr_file;
#[cfg(not(feature = "exr"))]
#[path = "no_exr.rs"]
mod exr_file;
mod file;
mod geotiff;
mod lattice_rows;
mod lonlat;
mod mosaic;
mod npz;
mod oddity;
mod origin;
mod reserve;
mod sample;
mod tile_store;
mod voids;
mod world_file;
mod xml;
mod xyz_grid;

pub(crate) use ascii_grid::is_header_key as is_grid_header_key;
pub use ascii_grid::{AsciiGrid, write_ascii_grid};
pub use bil_file::{BilValues, bil_header};
pub use cell_sources::{CellSources, bounds_through, half_diagonal_through, suggested_grid};
pub(crate) use exr_file::is_whole_exr;
pub use exr_file::write_exr;
pub use file::RasterFile;
pub use geotiff::xml_text;
pub use geotiff::{
    Bands, ClassColor, ClassImage, ClassPyramid, ClassStrips, GeoTiff, GeoTiffImage, class_table, encode_geotiff,
    pam_sidecar, write_geotiff,
};
#[cfg(feature = "point-clouds")]
pub(crate) use geotiff::{GeoKeySystems, systems_of_geo_keys};
pub use lonlat::LonLatGrid;
pub use mosaic::Mosaic;
pub use npz::{NpyArray, write_npz};
pub(crate) use oddity::with_true_lengths;
pub use origin::origin_of;
pub(crate) use reserve::reserve_cells;
pub use tile_store::{TileStore, TileStoreWriter};
pub use world_file::world_file;
pub(crate) use xml::refuse_crowds;
pub use xyz_grid::XyzGrid;
pub(crate) use xyz_grid::begins_with_points;

/// Values of a channel, row by row from the north-west cell.
#[derive(Debug, Clone, Copy)]
pub enum ExrChannel<'a> {
    /// Measures; NaN where there is none.
    Float(&'a [f32]),
    /// Classes, counts or sets of bits.
    UInt(&'a [u32]),
}
