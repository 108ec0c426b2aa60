//! Raster files of any format, and folders of them, recognized by their content and not by their
//! names.

use std::io::ErrorKind;
use std::path::Path;
use std::sync::atomic::AtomicUsize;

use super::mosaic::{Content, Header, Nesting, Tile, TileNumbers, packed_rasters};
use super::oddity::warned;
use skyshed_request::Band;

use super::band::index_of_band;
use super::{AsciiGrid, GeoTiff, Mosaic, XyzGrid};
use crate::crs::VerticalCrs;
use crate::error::{Error, Oddity, Result, Warning};
use crate::format::{FileFormat, FileKind};
use crate::input::{Input, cannot_read};
use crate::raster::{CellWindow, GeoRef, Raster};

/// Raster file, or a folder of them, whose headers have been read.
#[derive(Debug, Clone)]
#[expect(clippy::large_enum_variant, reason = "one value per input file")]
pub enum RasterFile {
    /// A GeoTIFF, cloud-optimized or not.
    GeoTiff(GeoTiff),
    /// An Esri ASCII grid.
    AsciiGrid(AsciiGrid),
    /// Lines of x, y and z.
    XyzGrid(XyzGrid),
    /// A virtual raster of GDAL, or tiles of a folder or an archive.
    Mosaic(Mosaic),
}

impl RasterFile {
    /// Opens a raster file and reads its header, no cell; for a folder or a virtual raster, the
    /// headers of all tiles.
    ///
    /// # Errors
    /// If the file cannot be opened, is of another kind (which the error names), or its header is
    /// bad.
    pub fn open(input: impl Into<Input>, warnings: &mut Vec<Warning>) -> Result<RasterFile> {
        warned(warnings, |odd| RasterFile::open_told(&input.into(), None, odd))
    }

    /// Opens as [`RasterFile::open`], with oddities as values. `band` is the band to read, where
    /// the caller can choose one.
    pub(crate) fn open_told(input: &Input, band: Option<&Band>, odd: &mut Vec<Oddity>) -> Result<RasterFile> {
        if input.is_folder() {
            let format = FileFormat::of(input)?;
            if format != FileFormat::RasterFolder {
                return Err(format.unwanted(input, FileKind::Raster));
            }
            return Mosaic::open_folder(input.as_path(), band, read_header, odd).map(RasterFile::Mosaic);
        }
        RasterFile::open_within(
            input,
            Nesting { band, ancestors: &[], n_opened: &AtomicUsize::new(0), open: read_header },
            odd,
        )
    }

    /// Opens a raster file that is part of virtual rasters.
    fn open_within(input: &Input, nesting: Nesting<'_>, odd: &mut Vec<Oddity>) -> Result<RasterFile> {
        match FileFormat::of(input)? {
            FileFormat::GeoTiff => GeoTiff::open_told(input, nesting.band, odd).map(RasterFile::GeoTiff),
            FileFormat::AsciiGrid => {
                // A grid of text has one band without a name.
                index_of_band(nesting.band.unwrap_or(&Band::First), input, &[None])?;
                AsciiGrid::open_told(input, odd).map(RasterFile::AsciiGrid)
            }
            FileFormat::Xyz => {
                index_of_band(nesting.band.unwrap_or(&Band::First), input, &[None])?;
                XyzGrid::open_told(input, odd).map(RasterFile::XyzGrid)
            }
            FileFormat::VirtualRaster if input.is_held() => {
                Err(Error::unsupported(input, "a virtual raster names other files, wanted its path"))
            }
            FileFormat::VirtualRaster => Mosaic::open_vrt(input.as_path(), nesting, odd).map(RasterFile::Mosaic),
            format if format.archive().is_some() => match packed_rasters(input)?.as_slice() {
                [] => Err(format.unwanted(input, FileKind::Raster)),
                [alone] => RasterFile::open_within(alone, nesting, odd),
                tiles => Mosaic::open_tiles(input.as_path(), tiles, nesting, odd).map(RasterFile::Mosaic),
            },
            // A folder is no tile of another one.
            FileFormat::RasterFolder => Err(cannot_read(input, &ErrorKind::IsADirectory.into())),
            format => Err(format.unwanted(input, FileKind::Raster)),
        }
    }

    /// Returns the length of the file's height unit \[m\], if it names one; values are read without
    /// conversion.
    pub fn meters_per_height_unit(&self) -> Option<f64> {
        match self {
            RasterFile::GeoTiff(tiff) => tiff.meters_per_height_unit(),
            RasterFile::AsciiGrid(_) | RasterFile::XyzGrid(_) => None,
            RasterFile::Mosaic(mosaic) => mosaic.meters_per_height_unit(),
        }
    }

    /// Returns the vertical system, where the file names it.
    pub fn vertical(&self) -> Option<&VerticalCrs> {
        match self {
            RasterFile::GeoTiff(tiff) => tiff.vertical(),
            RasterFile::AsciiGrid(_) | RasterFile::XyzGrid(_) => None,
            RasterFile::Mosaic(mosaic) => mosaic.vertical(),
        }
    }

    /// Returns the grid of the cells.
    pub fn georef(&self) -> &GeoRef {
        match self {
            RasterFile::GeoTiff(tiff) => tiff.georef(),
            RasterFile::AsciiGrid(grid) => grid.georef(),
            RasterFile::XyzGrid(grid) => grid.georef(),
            RasterFile::Mosaic(mosaic) => mosaic.georef(),
        }
    }

    /// Returns the other files that the raster is made of, in their order.
    pub fn tile_paths(&self) -> Vec<&Path> {
        if let RasterFile::Mosaic(mosaic) = self { mosaic.tile_paths() } else { Vec::new() }
    }

    /// Returns the encoding in a few words.
    pub fn description(&self) -> String {
        match self {
            RasterFile::GeoTiff(tiff) => tiff.description(),
            RasterFile::AsciiGrid(grid) => grid.description(),
            RasterFile::XyzGrid(grid) => grid.description(),
            RasterFile::Mosaic(mosaic) => mosaic.description(),
        }
    }

    /// Returns all heights on the lattice \[1/1024 m\], and the number of cells without one. `None`
    /// unless the file stores them so plainly that no cell needs a warning.
    ///
    /// # Errors
    /// If the heights do not fit in memory, the file cannot be read, or none of its cells holds a
    /// height.
    pub fn read_plain_heights(
        &self,
        window: CellWindow,
        warnings: &mut Vec<Warning>,
    ) -> Result<Option<(Raster<i32>, u64)>> {
        if let RasterFile::GeoTiff(tiff) = self { tiff.read_plain_heights(window, warnings) } else { Ok(None) }
    }

    /// Reads a part of the raster, of its first band by default; cells without a height arrive in
    /// `convert` as NaN.
    ///
    /// # Errors
    /// If the part does not fit in memory, the file cannot be read or decoded, or no cell of the
    /// part holds a height.
    ///
    /// # Panics
    /// If `window` is empty or reaches beyond the grid.
    pub fn read<T: bytemuck::Pod>(
        &self,
        window: CellWindow,
        warnings: &mut Vec<Warning>,
        convert: impl FnMut(f64) -> T,
    ) -> Result<Raster<T>> {
        match self {
            RasterFile::GeoTiff(tiff) => tiff.read(window, warnings, convert),
            RasterFile::XyzGrid(grid) => grid.read(window, warnings, convert),
            RasterFile::AsciiGrid(grid) => grid.read(window, warnings, convert),
            RasterFile::Mosaic(mosaic) => mosaic.read(window, warnings, convert),
        }
    }

    /// Returns `true` when the cost of reading a part is that of the part. Strips of compressed
    /// rows, and text, are read from their beginning.
    pub fn reads_parts(&self) -> bool {
        match self {
            RasterFile::GeoTiff(tiff) => tiff.reads_parts(),
            RasterFile::AsciiGrid(_) | RasterFile::XyzGrid(_) => false,
            RasterFile::Mosaic(_) => true,
        }
    }

    /// Returns the memory of reading beyond the requested cells \[bytes\]: an unpacked strip or
    /// tile, or rows that are put in order.
    pub fn block_bytes(&self) -> u64 {
        match self {
            RasterFile::GeoTiff(tiff) => tiff.block_bytes(),
            RasterFile::XyzGrid(grid) => grid.block_bytes(),
            RasterFile::AsciiGrid(_) | RasterFile::Mosaic(_) => 0,
        }
    }

    /// Returns `true` when the file stores no cell at all, whatever size it declares.
    pub fn is_empty(&self) -> bool {
        matches!(self, RasterFile::GeoTiff(tiff) if tiff.is_empty())
    }

    /// Calls `visit` with the index and the heights of every row, from the north or from the south
    /// as they are stored. NaN marks cells without a height. Memory is that of a row of blocks.
    ///
    /// # Errors
    /// Errors of [`RasterFile::read`].
    pub fn for_each_row(&self, warnings: &mut Vec<Warning>, mut visit: impl FnMut(usize, &[f64])) -> Result<()> {
        let (n_rows, n_cols) = (self.georef().n_rows(), self.georef().n_cols());
        let is_from_south = matches!(self, RasterFile::GeoTiff(tiff) if tiff.is_south_up());
        let mut heights = Vec::with_capacity(n_cols);
        let mut n_done = 0;
        // `convert` returns values of no size, so that only one row is held.
        self.read(self.georef().window(), warnings, |height| {
            heights.push(height);
            if heights.len() == n_cols {
                visit(if is_from_south { n_rows - 1 - n_done } else { n_done }, &heights);
                heights.clear();
                n_done += 1;
            }
        })?;
        Ok(())
    }
}

/// Reads the header of a tile.
fn read_header(input: &Input, nesting: Nesting<'_>) -> Result<Header> {
    let mut odd = Vec::new();
    let file = RasterFile::open_within(input, nesting, &mut odd)?;
    let georef = file.georef().clone();
    let meters_per_height_unit = file.meters_per_height_unit();
    let vertical = file.vertical().cloned();
    let (n_bands, numbers) = match &file {
        RasterFile::GeoTiff(tiff) => {
            let (band, nodata) = (tiff.band(), tiff.nodata());
            (tiff.n_bands(), TileNumbers { band, nodata, scaling: tiff.scaling(band) })
        }
        RasterFile::AsciiGrid(grid) => (1, TileNumbers { band: 0, nodata: Some(grid.nodata()), scaling: (1.0, 0.0) }),
        RasterFile::XyzGrid(grid) => (1, TileNumbers { band: 0, nodata: Some(grid.nodata()), scaling: (1.0, 0.0) }),
        RasterFile::Mosaic(mosaic) => (1, mosaic.numbers()),
    };
    let content = match file {
        RasterFile::GeoTiff(_) => Content::GeoTiff,
        RasterFile::AsciiGrid(grid) => Content::AsciiGrid(Box::new(grid)),
        RasterFile::XyzGrid(grid) => Content::XyzGrid(Box::new(grid)),
        RasterFile::Mosaic(mosaic) => Content::Mosaic(Box::new(mosaic)),
    };
    let (n_rows, n_cols) = (georef.n_rows(), georef.n_cols());
    let tile = Tile { input: input.clone(), n_rows, n_cols, numbers, content };
    Ok(Header { tile, georef, n_bands, meters_per_height_unit, vertical, odd })
}
