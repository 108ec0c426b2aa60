//! Cells of a band: as the file stores them, and as heights.

use super::geo_tiff::{GeoTiff, Mask};
use super::header::Codec;
use super::read::{Region, for_each_span};
use super::tags::TiffSource;
use crate::error::{OddRaster, Oddity, Result, Warning};
use crate::formats::band::bands_in_words;
use crate::formats::reserve::{check_cells, reserve_cells};
use crate::formats::voids::{Stored, Voids};
use crate::raster::{CellWindow, Raster};

impl GeoTiff {
    /// Reads a part of the band that was named when the file was opened, else of the first.
    /// `convert` turns a stored height into a value of the raster.
    ///
    /// Cells that hold no height (nodata, NaN, infinite, hidden by a mask, missing in a sparse
    /// file) arrive in `convert` as NaN. Heights are in the unit of the file, scaled where the file
    /// declares it. `convert` is called once per cell, row by row in the order of the file. Memory
    /// is that of the result and of one band of rows.
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
        let is_alpha = |band: usize| self.mask.as_ref().is_some_and(|mask| mask.band == band && band > 0);
        if self.is_first_by_default() && (1..self.n_bands()).any(|band| !is_alpha(band)) {
            let (n, can_choose) = (self.n_bands(), self.can_choose);
            let of_all = match self.is_picture {
                true => OddRaster::Colors { n, can_choose },
                false => OddRaster::Bands { n, names: bands_in_words(&self.band_names()), can_choose },
            };
            warnings.push(Oddity::new(&self.input, of_all).into());
        }
        self.read_band(self.band(), window, warnings, convert)
    }

    /// Reads a part of one band, counted from 0, as [`GeoTiff::read`] does for the first.
    ///
    /// # Errors
    /// Errors of [`GeoTiff::read`], and an error if there is no such band.
    ///
    /// # Panics
    /// If `window` is empty or reaches beyond the grid.
    pub fn read_band<T: bytemuck::Pod>(
        &self,
        band: usize,
        window: CellWindow,
        warnings: &mut Vec<Warning>,
        mut convert: impl FnMut(f64) -> T,
    ) -> Result<Raster<T>> {
        let georef = self.georef().part(window);
        check_cells::<T>(&self.input, &georef)?;
        if self.is_empty() {
            // A sparse file without any block can be tiny and declare any size: no memory is taken
            // for it.
            let mut voids = Voids::new(self.nodata_of(band));
            voids.n_missing = georef.n_cells() as u64;
            voids.report(&self.input, warnings)?;
        }
        let mut cells: Vec<T> = reserve_cells(&self.input, &georef)?;
        let (scale, offset) = self.metadata.scaling(band);
        let mut voids = Voids::new(self.nodata_of(band));
        self.for_each_stored(band, window, |row, col, stored| {
            cells.push(convert(voids.height_of(row, col, stored) * scale + offset));
        })?;
        if (scale, offset) != (1.0, 0.0) {
            warnings.push(Oddity::new(&self.input, OddRaster::Scaled(scale, offset)).into());
        }
        if self.placement.south_up {
            turn_over(&mut cells, window.n_cols);
        }
        voids.report(&self.input, warnings)?;
        Ok(Raster::new(georef, cells))
    }

    /// Returns the number of cells that reading a part of one band decodes: those of all blocks that
    /// it touches, and of uncompressed ones those of its rows.
    pub(in crate::formats) fn n_cells_decoded(&self, window: CellWindow) -> u64 {
        let blocks = |first: usize, n: usize, size: usize| ((first + n).div_ceil(size) - first / size) as u64;
        let image = &self.image;
        let across = blocks(window.col, window.n_cols, image.block_cols) * image.block_cols as u64;
        let first_row = if self.placement.south_up { image.n_rows - window.row - window.n_rows } else { window.row };
        let down = match image.codec {
            Codec::None => window.n_rows as u64,
            _ => blocks(first_row, window.n_rows, image.block_rows) * image.block_rows as u64,
        };
        across * down
    }

    /// Calls `visit` with row, column and content of each cell of a part of one band, row by row in
    /// the order of the file. That order may begin in the south; no number is scaled.
    pub(in crate::formats) fn for_each_stored(
        &self,
        band: usize,
        window: CellWindow,
        mut visit: impl FnMut(usize, usize, Stored),
    ) -> Result<()> {
        let (mut source, _) = TiffSource::open(&self.input)?;
        if band >= self.n_bands() {
            let text = format!("band {} of {}, wanted at most the last", band + 1, self.n_bands());
            return Err(source.malformed(text));
        }
        if source.len() != self.len {
            return Err(source.truncated("the file has changed since it was opened"));
        }
        let south_up = self.placement.south_up;
        let first_row = if south_up { self.image.n_rows - window.row - window.n_rows } else { window.row };
        let region =
            Region { rows: first_row..first_row + window.n_rows, cols: window.col..window.col + window.n_cols, band };
        let hidden = self.hidden_cells(&mut source, &region)?;
        let mut n_seen = 0;
        for_each_span(&mut source, &self.image, &region, |span| {
            let row = if south_up { self.image.n_rows - 1 - span.row } else { span.row };
            match span.samples {
                None => (0..span.n_cells).for_each(|i| visit(row, span.col + i, Stored::Nothing)),
                Some(samples) => samples.for_each(self.image.sample, span.n_cells, |i, number| {
                    let is_hidden = hidden.as_ref().is_some_and(|hidden| hidden.get(n_seen + i));
                    visit(row, span.col + i, if is_hidden { Stored::Hidden(number) } else { Stored::Number(number) });
                }),
            }
            n_seen += span.n_cells;
        })
    }

    /// Returns the declared nodata value of the band that is read, as the samples can hold it.
    pub(in crate::formats) fn nodata(&self) -> Option<f64> {
        self.nodata_of(self.band())
    }

    /// Returns factor and summand that turn the stored numbers of a band into heights.
    pub(in crate::formats) fn scaling(&self, band: usize) -> (f64, f64) {
        self.metadata.scaling(band)
    }

    /// Returns the cells of a region that the mask hides, in the order in which they are read.
    fn hidden_cells(&self, source: &mut TiffSource, region: &Region) -> Result<Option<Bits>> {
        let Some(mask) = &self.mask else { return Ok(None) };
        let mut hidden = Bits::default();
        let Mask { image, band } = mask;
        for_each_span(source, image, &Region { band: *band, ..region.clone() }, |span| match span.samples {
            // GDAL leaves out the blocks of a mask that hide all of their cells.
            None => (0..span.n_cells).for_each(|_| hidden.push(true)),
            Some(samples) => samples.for_each(image.sample, span.n_cells, |_, value| hidden.push(value <= 0.0)),
        })?;
        Ok(Some(hidden))
    }
}

/// Reverses the order of rows.
pub(super) fn turn_over<T>(cells: &mut [T], n_cols: usize) {
    let n_rows = cells.len() / n_cols;
    for row in 0..n_rows / 2 {
        let (north, south) = cells.split_at_mut((n_rows - 1 - row) * n_cols);
        north[row * n_cols..(row + 1) * n_cols].swap_with_slice(&mut south[..n_cols]);
    }
}

/// One bit per cell.
#[derive(Debug, Default)]
struct Bits {
    words: Vec<u64>,
    len: usize,
}

impl Bits {
    fn push(&mut self, bit: bool) {
        if self.len.is_multiple_of(64) {
            self.words.push(0);
        }
        if let Some(last) = self.words.last_mut() {
            *last |= u64::from(bit) << (self.len % 64);
        }
        self.len += 1;
    }

    fn get(&self, index: usize) -> bool {
        self.words[index / 64] >> (index % 64) & 1 == 1
    }
}
