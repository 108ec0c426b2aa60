//! A cloud optimized GeoTIFF of classes whose rows come one after another, from the north. It
//! equals the file that [`super::write_geotiff`] writes of the same cells in memory.

use std::borrow::Cow;
use std::io::Write;

use tiff_core::Predictor;

use skyshed_request::TiffLayout;

use super::image::ClassImage;
use super::levels::{Level, TILE, compressed_tiles, level_tags, n_overviews, write_levels};
use super::overview::most_frequent;
use crate::error::Result;

/// Compressed tiles of all rows so far, at every resolution. Memory is that of the tiles and of a
/// few hundred rows.
#[derive(Debug, Default)]
pub struct ClassPyramid {
    n_rows: usize,
    n_cols: usize,
    n_pushed: usize,
    /// Rows that do not yet fill a row of tiles.
    band: Vec<u8>,
    levels: Vec<PyramidLevel>,
}

#[derive(Debug)]
struct PyramidLevel {
    reduction: usize,
    n_cols: usize,
    /// Rows that do not yet fill a row of tiles.
    band: Vec<u8>,
    blocks: Vec<Vec<u8>>,
}

impl ClassPyramid {
    /// Creates a pyramid of a shape, without rows.
    pub fn new((n_rows, n_cols): (usize, usize)) -> Self {
        let level = |level: usize| PyramidLevel {
            reduction: 1 << level,
            n_cols: n_cols.div_ceil(1 << level),
            band: Vec::new(),
            blocks: Vec::new(),
        };
        let levels = (0..=n_overviews((n_rows, n_cols))).map(level).collect();
        ClassPyramid { n_rows, n_cols, n_pushed: 0, band: Vec::new(), levels }
    }

    /// Adds whole rows.
    ///
    /// # Errors
    /// E402 if a tile cannot be encoded.
    ///
    /// # Panics
    /// If `cells` are not whole rows, or more than are missing.
    pub fn push(&mut self, cells: &[u8]) -> Result<()> {
        assert!(cells.len().is_multiple_of(self.n_cols), "whole rows");
        for row in cells.chunks(self.n_cols) {
            self.band.extend_from_slice(row);
            self.n_pushed += 1;
            assert!(self.n_pushed <= self.n_rows, "no more rows than there are");
            if self.n_pushed.is_multiple_of(TILE) || self.n_pushed == self.n_rows {
                self.flush()?;
            }
        }
        Ok(())
    }

    /// Passes a row of tiles to all levels. Its height is a multiple of the largest reduction.
    fn flush(&mut self) -> Result<()> {
        let n_rows = self.band.len() / self.n_cols;
        let is_end = self.n_pushed == self.n_rows;
        let overviews = most_frequent(&self.band, (n_rows, self.n_cols), self.levels.len() - 1);
        let rows = std::iter::once(std::mem::take(&mut self.band)).chain(overviews);
        for (level, rows) in self.levels.iter_mut().zip(rows) {
            level.band.extend(rows);
            let n_held = level.band.len() / level.n_cols;
            if n_held >= TILE || is_end {
                level.blocks.extend(compressed_tiles(&[&level.band], (n_held, level.n_cols), Predictor::None)?);
                level.band.clear();
            }
        }
        Ok(())
    }

    /// Writes the file front to back, with items of GDAL's metadata; a BigTIFF if it is above 4
    /// GiB.
    ///
    /// # Errors
    /// E401 if `out` refuses the bytes, E402 if TIFF cannot hold the image.
    ///
    /// # Panics
    /// If rows are missing.
    pub fn write(&self, out: &mut impl Write, image: &ClassImage<'_>, metadata: &[(String, String)]) -> Result<()> {
        assert_eq!(self.n_pushed, self.n_rows, "all rows were pushed");
        let head = image.head(metadata, TiffLayout::Cog);
        let levels = self.levels.iter().map(|level| {
            let shape = (self.n_rows.div_ceil(level.reduction), level.n_cols);
            Ok(Level {
                tags: level_tags::<u8>(&head, (shape, level.reduction), &[image.name], Predictor::None)?,
                blocks: level.blocks.iter().map(|block| Cow::Borrowed(block.as_slice())).collect(),
            })
        });
        write_levels(out, &levels.collect::<Result<Vec<_>>>()?, false)
    }
}
