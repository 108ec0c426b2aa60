//! The cells of a band as the file has them, before anything is made of nodata, masks and missing blocks.

use super::read::{Region, for_each_span};
use super::tags::TiffSource;
use super::{GeoTiff, Mask};
use crate::error::Result;
use crate::formats::voids::Stored;
use crate::raster::CellWindow;

impl GeoTiff {
    /// Calls `visit` with row, column and content of each cell of a part of one band, row by row in the order of the file
    /// (which may begin in the south); no number is scaled.
    ///
    /// # Errors
    /// If the file cannot be read or decoded, has changed since it was opened, or has no such band.
    pub(in crate::formats) fn for_each_stored(
        &self,
        band: usize,
        window: CellWindow,
        mut visit: impl FnMut(usize, usize, Stored),
    ) -> Result<()> {
        let (mut source, _) = TiffSource::open(&self.path)?;
        if band >= self.n_bands() {
            let text = format!("band {} of {}, wanted at most the last", band + 1, self.n_bands());
            return Err(source.error(302, text));
        }
        if source.len() != self.len {
            return Err(source.error(303, "the file has changed since it was opened"));
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

    /// The declared nodata value, as the samples can hold it.
    pub(in crate::formats) fn nodata(&self) -> Option<f64> {
        self.nodata
    }

    /// Factor and summand that turn the stored numbers of a band into heights.
    pub(in crate::formats) fn scaling(&self, band: usize) -> (f64, f64) {
        self.metadata.scaling(band)
    }

    /// The cells of a region that the mask hides, in the order in which they are read.
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
