//! Rasters: rows of cells on a georeferenced grid, and the file formats they come in and go out as.
//!
//! Rows run north to south and columns west to east, in every file and every array; a cell is an area, and its value
//! holds for the whole of it. Formats know nothing of line of sight; each is known in exactly one file.

mod ascii_grid;
mod bil_file;
mod bit_grid;
mod cell_blocks;
mod cell_lattice;
mod cell_outline;
mod cell_parts;
mod cell_sources;
mod crs;
mod exr_file;
mod file;
mod georef;
mod geotiff;
mod large_vec;
mod lattice_rows;
mod lonlat;
mod mosaic;
mod npz;
mod origin;
mod overlapped_cells;
mod row_runs;
mod sample;
mod simpler_rings;
mod tile_store;
mod voids;
mod world_file;

use bytemuck::Pod;

pub use ascii_grid::{AsciiGrid, write_ascii_grid};
pub use bil_file::{BilValues, bil_header};
pub use bit_grid::{BitGrid, bits_between, set_bits};
pub use cell_blocks::CellBlocks;
pub use cell_lattice::CellLattice;
pub(crate) use cell_outline::traced_around;
pub(crate) use cell_parts::labelled_parts;
pub use cell_parts::{CellPart, cell_parts, n_cell_parts};
pub use cell_sources::{CellSources, bounds_through, half_diagonal_through, suggested_grid};
pub use crs::{
    Crs, CrsKind, InputKind, Transformation, VerticalCrs, VerticalDifference, degrees_refusal, transform, utm_for,
};
pub use exr_file::{ExrChannel, write_exr};
pub use file::RasterFile;
pub(crate) use file::{cannot_read, open_file, reserve_cells};
pub use georef::{CellWindow, GeoRef};
pub(crate) use geotiff::xml_text;
pub use geotiff::{
    Bands, ClassColor, ClassImage, ClassPyramid, ClassStrips, GeoTiff, GeoTiffImage, TiffLayout, encode_geotiff,
    pam_sidecar, write_geotiff,
};
pub use large_vec::LargeVec;
pub use lonlat::LonLatGrid;
pub use mosaic::Mosaic;
pub use npz::{NpyArray, write_npz};
pub use origin::origin_of;
pub use overlapped_cells::{covered_shares, overlapped_cells};
pub use row_runs::{CELLS_PER_RUN, RowGroup, RowRuns};
pub use simpler_rings::simpler_rings;
pub use tile_store::{TileStore, TileStoreWriter};
pub use world_file::world_file;

/// A grid of values, row by row from the north-west cell: shape `[n_rows, n_cols]`, columns running fastest.
#[derive(Debug, Clone, PartialEq)]
pub struct Raster<T: Pod> {
    georef: GeoRef,
    cells: LargeVec<T>,
}

impl<T: Pod> Raster<T> {
    /// A raster from its cells.
    ///
    /// # Panics
    /// If `cells` does not hold exactly `georef.n_cells()` values.
    pub fn new(georef: GeoRef, cells: impl Into<LargeVec<T>>) -> Self {
        let cells = cells.into();
        assert_eq!(cells.len(), georef.n_cells(), "a raster holds one value per cell of its grid");
        Raster { georef, cells }
    }

    /// Where the cells lie.
    pub fn georef(&self) -> &GeoRef {
        &self.georef
    }

    /// All values, row by row from the north-west cell.
    pub fn cells(&self) -> &[T] {
        &self.cells
    }

    /// One row of values, row 0 being the northernmost.
    ///
    /// # Panics
    /// If `row` is not below the number of rows.
    pub fn row(&self, row: usize) -> &[T] {
        let n_cols = self.georef.n_cols();
        &self.cells[row * n_cols..(row + 1) * n_cols]
    }

    /// The values without their grid.
    pub fn into_cells(self) -> LargeVec<T> {
        self.cells
    }
}
