//! The rasters that a mosaic is made of, and what is kept of each: thousands are common, so it is little.

use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::{Mosaic, Nesting};
use crate::crs::VerticalCrs;
use crate::error::{Error, Result, Warning};
use crate::formats::voids::{Stored, is_nodata};
use crate::formats::{AsciiGrid, GeoTiff, RasterFile};
use crate::raster::{CellWindow, GeoRef};

/// A raster of a mosaic.
#[derive(Debug, Clone)]
pub(super) struct Tile {
    pub(super) path: PathBuf,
    pub(super) n_rows: usize,
    pub(super) n_cols: usize,
    /// The declared nodata value.
    pub(super) nodata: Option<f64>,
    /// Factor and summand that turn the stored numbers of the first band into heights.
    pub(super) scaling: (f64, f64),
    content: Content,
}

/// What is kept of a tile beside its place: the table of a GeoTIFF's blocks can be large, and is read again.
#[derive(Debug, Clone)]
enum Content {
    GeoTiff,
    AsciiGrid(Box<AsciiGrid>),
    Mosaic(Box<Mosaic>),
}

/// What the header of a tile says, needed while the mosaic is put together.
#[derive(Debug)]
pub(super) struct Header {
    pub(super) tile: Tile,
    pub(super) georef: GeoRef,
    pub(super) n_bands: usize,
    pub(super) meters_per_height_unit: Option<f64>,
    pub(super) vertical: Option<VerticalCrs>,
    pub(super) warnings: Vec<Warning>,
}

/// Reads the headers of all tiles, in parallel; the error is that of the first bad one.
///
/// `nesting` is that of the virtual raster that the tiles are in.
pub(super) fn read_headers(paths: &[PathBuf], nesting: Nesting<'_>) -> Result<Vec<Header>> {
    let headers: Vec<Result<Header>> = paths.par_iter().map(|path| read_header(path, nesting)).collect();
    headers.into_iter().collect()
}

fn read_header(path: &Path, nesting: Nesting<'_>) -> Result<Header> {
    let mut warnings = Vec::new();
    let file = RasterFile::open_within(path, nesting, &mut warnings)?;
    let georef = file.georef().clone();
    let meters_per_height_unit = file.meters_per_height_unit();
    let vertical = file.vertical().cloned();
    let (n_bands, nodata, scaling) = match &file {
        RasterFile::GeoTiff(tiff) => (tiff.n_bands(), tiff.nodata(), tiff.scaling(0)),
        RasterFile::AsciiGrid(grid) => (1, Some(grid.nodata()), (1.0, 0.0)),
        RasterFile::Mosaic(mosaic) => (1, mosaic.nodata, mosaic.scaling),
    };
    let content = match file {
        RasterFile::GeoTiff(_) => Content::GeoTiff,
        RasterFile::AsciiGrid(grid) => Content::AsciiGrid(Box::new(grid)),
        RasterFile::Mosaic(mosaic) => Content::Mosaic(Box::new(mosaic)),
    };
    let (n_rows, n_cols) = (georef.n_rows(), georef.n_cols());
    let tile = Tile { path: path.to_owned(), n_rows, n_cols, nodata, scaling, content };
    Ok(Header { tile, georef, n_bands, meters_per_height_unit, vertical, warnings })
}

impl Tile {
    /// Calls `visit` with row, column and content of each cell of a part of one band; rows may come in any order.
    pub(super) fn for_each_stored(
        &self,
        band: usize,
        window: CellWindow,
        mut visit: impl FnMut(usize, usize, Stored),
    ) -> Result<()> {
        match &self.content {
            Content::GeoTiff => {
                // What is odd about its header was told when the mosaic was opened.
                let tiff = GeoTiff::open(&self.path, &mut Vec::new())?;
                let (n_rows, n_cols) = (tiff.georef().n_rows(), tiff.georef().n_cols());
                if (n_rows, n_cols, tiff.nodata().map(f64::to_bits))
                    != (self.n_rows, self.n_cols, self.nodata.map(f64::to_bits))
                {
                    let text =
                        format!("cannot read `{}`: the file has changed since it was opened", self.path.display());
                    return Err(Error::file(303, text));
                }
                tiff.for_each_stored(band, window, visit)
            }
            Content::AsciiGrid(grid) => {
                grid.for_each_stored(window, |row, col, number| visit(row, col, Stored::Number(number)))
            }
            Content::Mosaic(mosaic) => {
                let visited = mosaic.for_each_number(window, |row, col, number| {
                    visit(row, col, Stored::Number(number));
                });
                visited.map(drop)
            }
        }
    }

    /// Whether a cell holds a number that is neither a height nor declared as none.
    pub(super) fn is_not_finite(&self, stored: Stored) -> bool {
        matches!(stored, Stored::Number(number) if !number.is_finite() && !is_nodata(self.nodata, number))
    }

    /// The files that the tile is made of, beside itself.
    pub(super) fn parts(&self) -> Vec<&Path> {
        match &self.content {
            Content::Mosaic(mosaic) => mosaic.tile_paths(),
            Content::GeoTiff | Content::AsciiGrid(_) => Vec::new(),
        }
    }
}

/// The warnings of many tiles, each kind once; of kinds in `settled` the mosaic itself knows better.
pub(super) fn told_once<'a>(headers: impl Iterator<Item = &'a mut Header>, settled: &[&str]) -> Vec<Warning> {
    let mut kinds: Vec<(Warning, usize)> = Vec::new();
    for warning in headers.flat_map(|header| header.warnings.drain(..)) {
        if settled.contains(&warning.code().as_str()) {
            continue;
        }
        match kinds.iter_mut().find(|(first, _)| first.code() == warning.code()) {
            Some((_, n_more)) => *n_more += 1,
            None => kinds.push((warning, 0)),
        }
    }
    let told = |(warning, n_more): (Warning, usize)| match n_more {
        0 => warning,
        1 => warning.within("and likewise one more tile"),
        n => warning.within(format!("and likewise {n} more tiles")),
    };
    kinds.into_iter().map(told).collect()
}
