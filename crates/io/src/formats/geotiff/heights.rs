//! Heights straight onto the lattice, where a file stores them plainly.

use std::io::{Read, Seek, SeekFrom};
use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use rayon::prelude::*;
use tiff_reader::ByteOrder;

use super::geo_tiff::GeoTiff;
use super::header::Codec;
use super::read::{Region, for_each_span};
use super::stored::turn_over;
use super::tags::TiffSource;
use crate::error::{Result, Warning};
use crate::formats::lattice_rows::put_on_lattice;
use crate::formats::reserve::reserve_cells;
use crate::formats::sample::Sample;
use crate::formats::voids::Voids;
use crate::input::{Input, Reader, cannot_read};
use crate::quantity::VOID;
use crate::raster::{CELLS_PER_RUN, CellWindow, LargeVec, Raster, RowGroup, RowRuns};

/// Usual size of one read of a thread \[bytes\]: the bytes are converted while they are in its
/// cache.
const READ_BYTES: usize = 256 << 10;

/// Least number of rows that are searched for runs together: each is compared with the one before.
const ROWS_OF_RUNS: usize = 16;

impl GeoTiff {
    /// Returns the heights of a part of the only band on the lattice \[1/1024 m\], and the number
    /// of nodata cells, which are [`crate::quantity::VOID`].
    ///
    /// `None` if the heights are not stored plainly or one of them needs a warning;
    /// [`GeoTiff::read`] reads them then. Plain are 32-bit floats or integers of 8 or 16 bits, in
    /// meters, in one band without a mask, with no block missing. Threads of the current pool read,
    /// decode and convert parts of the file; memory is that of the result. Heights of few runs,
    /// such as those of a block model along the grid, are held as runs where strips are not
    /// compressed.
    ///
    /// # Errors
    /// If the heights do not fit in memory, the file cannot be read, or none of its cells holds a
    /// height.
    pub fn read_plain_heights(
        &self,
        window: CellWindow,
        warnings: &mut Vec<Warning>,
    ) -> Result<Option<(Raster<i32>, u64)>> {
        let image = &self.image;
        let is_plain = matches!(image.sample, Sample::F32 | Sample::U8 | Sample::I8 | Sample::U16 | Sample::I16)
            && !matches!(image.codec, Codec::Lerc(_))
            && image.n_bands == 1
            && self.mask.is_none()
            && self.metadata.scaling(0) == (1.0, 0.0)
            && self.meters_per_height_unit().is_none_or(|unit| (unit - 1.0).abs() < f64::EPSILON)
            && image.blocks.iter().all(|(_, len)| *len > 0);
        if !is_plain {
            return Ok(None);
        }
        let (source, _) = TiffSource::open(&self.input)?;
        if source.len() != self.len {
            return Err(source.truncated("the file has changed since it was opened"));
        }
        #[expect(clippy::cast_possible_truncation, reason = "rounded to the samples already")]
        let nodata = self.nodata().map(|nodata| nodata as f32);
        let georef = self.georef().part(window);
        // Memory is checked for all cells: a caller may request all heights one by one.
        drop(reserve_cells::<i32>(&self.input, &georef)?);
        let are_floats_in_strips =
            image.codec == Codec::None && image.sample == Sample::F32 && !image.tiled && !image.bits_reversed;
        let found = match are_floats_in_strips && window == self.georef().window() {
            true => self.heights_of_strips(&source, nodata)?,
            false => self.heights_of_blocks(window, nodata)?,
        };
        let Some((cells, n_nodata)) = found else { return Ok(None) };
        let mut voids = Voids::new(self.nodata());
        voids.n_nodata = n_nodata;
        voids.n_heights = cells.len() as u64 - n_nodata;
        voids.report(&self.input, warnings)?;
        Ok(Some((Raster::new(georef, cells), n_nodata)))
    }

    /// Returns the heights of a part, and the number of nodata cells, from blocks of any codec.
    /// `None` if a value needs a warning.
    fn heights_of_blocks(&self, window: CellWindow, nodata: Option<f32>) -> Result<Option<(LargeVec<i32>, u64)>> {
        let image = &self.image;
        let n_cols = window.n_cols;
        let south_up = self.placement.south_up;
        let first_row = if south_up { image.n_rows - window.row - window.n_rows } else { window.row };
        let mut cells = LargeVec::<i32>::zeroed(window.n_rows * n_cols);
        // Rows of the part in each row of blocks.
        let mut parts: Vec<(Range<usize>, &mut [i32])> = Vec::new();
        let (mut row, mut rest) = (first_row, &mut cells[..]);
        while row < first_row + window.n_rows {
            let n_rows = (image.block_rows - row % image.block_rows).min(first_row + window.n_rows - row);
            let (part, after) = std::mem::take(&mut rest).split_at_mut(n_rows * n_cols);
            rest = after;
            parts.push((row..row + n_rows, part));
            row += n_rows;
        }
        let cols = window.col..window.col + n_cols;
        let is_odd = AtomicBool::new(false);
        let read = |source: &mut Option<TiffSource>, (rows, cells): (Range<usize>, &mut [i32])| {
            if is_odd.load(Ordering::Relaxed) {
                return Ok(0);
            }
            if source.is_none() {
                *source = Some(TiffSource::open(&self.input)?.0);
            }
            let Some(source) = source else { return Ok(0) };
            let region = Region { rows: rows.clone(), cols: cols.clone(), band: 0 };
            for_each_span(source, image, &region, |span| {
                let at = (span.row - rows.start) * n_cols + span.col - cols.start;
                let cells = &mut cells[at..at + span.n_cells];
                match span.samples {
                    Some(samples) => samples.put_floats(image.sample, cells),
                    None => is_odd.store(true, Ordering::Relaxed),
                }
            })?;
            let found = put_on_lattice(cells, nodata);
            is_odd.fetch_or(found.is_none(), Ordering::Relaxed);
            Ok(found.unwrap_or(0))
        };
        let found: Vec<Result<u64>> = parts.into_par_iter().map_init(|| None, read).collect();
        // The first error in file order is returned, whichever thread comes first.
        let n_nodata = found.into_iter().sum::<Result<u64>>()?;
        if is_odd.into_inner() {
            return Ok(None);
        }
        if south_up {
            turn_over(&mut cells, n_cols);
        }
        Ok(Some((cells, n_nodata)))
    }

    /// Returns all heights, and the number of nodata cells, from floats in uncompressed strips.
    /// `None` if a value needs a warning.
    fn heights_of_strips(&self, source: &TiffSource, nodata: Option<f32>) -> Result<Option<(LargeVec<i32>, u64)>> {
        let image = &self.image;
        let rows = PlainRows {
            input: &self.input,
            n_cols: image.n_cols,
            is_swapped: (source.byte_order() == ByteOrder::BigEndian) != cfg!(target_endian = "big"),
            nodata,
        };
        // Strips that follow one another in the file are one run of rows.
        let mut strips: Vec<(u64, usize)> = Vec::new();
        for (strip, (offset, _)) in image.blocks.iter().enumerate() {
            let n_rows = image.stored_rows(strip);
            match strips.last_mut() {
                Some((start, rows)) if *start + 4 * (*rows * image.n_cols) as u64 == *offset => *rows += n_rows,
                _ => strips.push((*offset, n_rows)),
            }
        }
        let as_runs = if self.placement.south_up { None } else { rows.as_runs(&strips)? };
        if as_runs.is_some() {
            return Ok(as_runs);
        }
        let mut cells = LargeVec::<i32>::zeroed(self.georef().n_cells());
        let Some(n_nodata) = rows.one_by_one(&strips, &mut cells)? else { return Ok(None) };
        if self.placement.south_up {
            turn_over(&mut cells, image.n_cols);
        }
        Ok(Some((cells, n_nodata)))
    }
}

/// Rows of 32-bit floats in a file.
struct PlainRows<'a> {
    input: &'a Input,
    n_cols: usize,
    is_swapped: bool,
    nodata: Option<f32>,
}

impl PlainRows<'_> {
    /// Splits strips into parts that are read at once, of at most `rows_at_once` rows; returns the
    /// offset of each part and the number of its rows.
    fn parts(strips: &[(u64, usize)], n_cols: usize, rows_at_once: usize) -> Vec<(u64, usize)> {
        let parts_of = |(offset, n_rows): &(u64, usize)| {
            let (offset, n_rows) = (*offset, *n_rows);
            let part = move |first| (offset + 4 * (first * n_cols) as u64, rows_at_once.min(n_rows - first));
            (0..n_rows).step_by(rows_at_once).map(part)
        };
        strips.iter().flat_map(parts_of).collect()
    }

    /// Reads cells, as the bits of their floats, from an offset on; opens the file if it is not
    /// open.
    fn read(&self, file: &mut Option<Reader>, offset: u64, cells: &mut [i32]) -> Result<()> {
        let failed = |e: std::io::Error| cannot_read(self.input, &e);
        if file.is_none() {
            *file = Some(self.input.open()?.0);
        }
        let Some(file) = file else { return Ok(()) };
        let bytes = bytemuck::cast_slice_mut(cells);
        file.seek(SeekFrom::Start(offset)).and_then(|_| file.read_exact(bytes)).map_err(failed)?;
        if self.is_swapped {
            cells.iter_mut().for_each(|bits| *bits = bits.swap_bytes());
        }
        Ok(())
    }

    /// Returns all heights as runs of equal ones, and the number of nodata cells. `None` if there
    /// are too many runs to save anything, or a value needs a warning.
    fn as_runs(&self, strips: &[(u64, usize)]) -> Result<Option<(LargeVec<i32>, u64)>> {
        let n_cols = self.n_cols;
        let rows_at_once = (READ_BYTES / (4 * n_cols)).max(ROWS_OF_RUNS);
        // In most files without runs, one part suffices to see that.
        let is_given_up = AtomicBool::new(false);
        let read = |(file, cells): &mut (Option<Reader>, Vec<i32>), (offset, n_rows): (u64, usize)| {
            if is_given_up.load(Ordering::Relaxed) {
                return Ok(None);
            }
            cells.resize(n_rows * n_cols, 0);
            self.read(file, offset, cells)?;
            let runs = RowRuns::of_part(cells, n_cols, rows_at_once * n_cols / CELLS_PER_RUN).and_then(|mut runs| {
                put_on_lattice(runs.values_mut(), self.nodata)?;
                Some(runs)
            });
            is_given_up.fetch_or(runs.is_none(), Ordering::Relaxed);
            Ok(runs)
        };
        let parts = PlainRows::parts(strips, n_cols, rows_at_once);
        let found: Vec<Option<RowRuns<i32>>> =
            parts.into_par_iter().map_init(|| (None, Vec::new()), read).collect::<Result<_>>()?;
        let Some(found) = found.into_iter().collect::<Option<Vec<_>>>() else { return Ok(None) };
        let runs = RowRuns::joined(found);
        let n_void_of = |group: RowGroup<'_, i32>| {
            let n_cols: usize = group.runs().filter(|(_, top)| **top == VOID).map(|(cols, _)| cols.len()).sum();
            (n_cols * group.rows.len()) as u64
        };
        let n_nodata = runs.groups().map(n_void_of).sum();
        Ok(Some((LargeVec::from_runs(runs), n_nodata)))
    }

    /// Fills `cells` with all heights and returns the number of nodata cells; `None` if a value
    /// needs a warning.
    fn one_by_one(&self, strips: &[(u64, usize)], cells: &mut [i32]) -> Result<Option<u64>> {
        let n_cols = self.n_cols;
        let rows_at_once = (READ_BYTES / (4 * n_cols)).max(1);
        // Offset of the bytes of a part, and its cells.
        let mut parts: Vec<(u64, &mut [i32])> = Vec::new();
        let mut rest = cells;
        for (offset, n_rows) in PlainRows::parts(strips, n_cols, rows_at_once) {
            let (part, after) = std::mem::take(&mut rest).split_at_mut(n_rows * n_cols);
            rest = after;
            parts.push((offset, part));
        }
        let (is_odd, n_nodata) = (AtomicBool::new(false), AtomicU64::new(0));
        let read = |file: &mut Option<Reader>, (offset, cells): (u64, &mut [i32])| {
            if is_odd.load(Ordering::Relaxed) {
                return Ok(());
            }
            self.read(file, offset, cells)?;
            match put_on_lattice(cells, self.nodata) {
                Some(found) => n_nodata.fetch_add(found, Ordering::Relaxed),
                None => u64::from(is_odd.swap(true, Ordering::Relaxed)),
            };
            Ok(())
        };
        parts.into_par_iter().map_init(|| None, read).collect::<Result<()>>()?;
        Ok((!is_odd.into_inner()).then(|| n_nodata.into_inner()))
    }
}
