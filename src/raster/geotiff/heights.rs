//! Heights straight onto the lattice, where a file stores them plainly.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use rayon::prelude::*;
use tiff_reader::ByteOrder;

use super::header::Codec;
use super::tags::TiffSource;
use super::{GeoTiff, turn_over};
use crate::error::{Error, Result, Warning};
use crate::raster::file::reserve_cells;
use crate::raster::lattice_rows::put_on_lattice;
use crate::raster::sample::Sample;
use crate::raster::voids::Voids;
use crate::raster::{LargeVec, Raster};

/// Bytes that a thread reads at a time: they are converted while they are in its cache.
const READ_BYTES: usize = 256 << 10;

impl GeoTiff {
    /// All heights of the first band on the lattice \[1/1024 m\], [`crate::quantity::VOID`] where nodata, and
    /// the number of nodata cells.
    ///
    /// `None` if the file is not stored plainly (uncompressed strips of one band of 32-bit floats in meters, without a mask)
    /// or holds a value that deserves a word: [`GeoTiff::read`] has it then. Threads of the current pool read and convert
    /// parts of the file; memory is that of the result.
    ///
    /// # Errors
    /// If the heights do not fit in memory, the file cannot be read, or none of its cells holds a height.
    pub fn read_plain_heights(&self, warnings: &mut Vec<Warning>) -> Result<Option<(Raster<i32>, u64)>> {
        let image = &self.image;
        let is_plain = image.codec == Codec::None
            && image.sample == Sample::F32
            && image.n_bands == 1
            && !image.tiled
            && !image.bits_reversed
            && self.mask.is_none()
            && self.metadata.scaling(0) == (1.0, 0.0)
            && self.meters_per_height_unit().is_none_or(|unit| (unit - 1.0).abs() < f64::EPSILON)
            && image.blocks.iter().all(|(_, len)| *len > 0);
        if !is_plain {
            return Ok(None);
        }
        let (source, _) = TiffSource::open(&self.path)?;
        if source.len() != self.len {
            return Err(source.error(303, "the file has changed since it was opened"));
        }
        let is_swapped = (source.byte_order() == ByteOrder::BigEndian) != cfg!(target_endian = "big");
        #[expect(clippy::cast_possible_truncation, reason = "rounded to the samples already")]
        let nodata = self.nodata.map(|nodata| nodata as f32);
        drop(reserve_cells::<i32>(&self.path, self.georef())?);
        let mut cells = LargeVec::<i32>::zeroed(self.georef().n_cells());

        let n_cols = image.n_cols;
        // Strips that lie one behind the other in the file are one run of rows.
        let mut runs: Vec<(u64, usize)> = Vec::new();
        for (strip, (offset, _)) in image.blocks.iter().enumerate() {
            let n_rows = image.stored_rows(strip);
            match runs.last_mut() {
                Some((start, rows)) if *start + 4 * (*rows * n_cols) as u64 == *offset => *rows += n_rows,
                _ => runs.push((*offset, n_rows)),
            }
        }
        let rows_at_once = (READ_BYTES / (4 * n_cols)).max(1);
        // Where the bytes of a part begin, and its cells.
        let mut parts: Vec<(u64, &mut [i32])> = Vec::new();
        let mut rest = &mut *cells;
        for (offset, n_rows) in runs {
            for first in (0..n_rows).step_by(rows_at_once) {
                let n_here = rows_at_once.min(n_rows - first);
                let (part, after) = std::mem::take(&mut rest).split_at_mut(n_here * n_cols);
                rest = after;
                parts.push((offset + 4 * (first * n_cols) as u64, part));
            }
        }
        let (is_odd, n_nodata) = (AtomicBool::new(false), AtomicU64::new(0));
        let read = |file: &mut Option<File>, (offset, cells): (u64, &mut [i32])| {
            if is_odd.load(Ordering::Relaxed) {
                return Ok(());
            }
            let failed = |e: std::io::Error| Error::file(301, format!("cannot read `{}`: {e}", self.path.display()));
            if file.is_none() {
                *file = Some(File::open(&self.path).map_err(failed)?);
            }
            let Some(file) = file else { return Ok(()) };
            let bytes = bytemuck::cast_slice_mut(cells);
            file.seek(SeekFrom::Start(offset)).and_then(|_| file.read_exact(bytes)).map_err(failed)?;
            if is_swapped {
                cells.iter_mut().for_each(|bits| *bits = bits.swap_bytes());
            }
            match put_on_lattice(cells, nodata) {
                Some(found) => n_nodata.fetch_add(found, Ordering::Relaxed),
                None => u64::from(is_odd.swap(true, Ordering::Relaxed)),
            };
            Ok(())
        };
        parts.into_par_iter().map_init(|| None, read).collect::<Result<()>>()?;
        if is_odd.into_inner() {
            return Ok(None);
        }
        if self.placement.south_up {
            turn_over(&mut cells, n_cols);
        }
        let mut voids = Voids::new(self.nodata);
        voids.n_nodata = n_nodata.into_inner();
        voids.n_heights = cells.len() as u64 - voids.n_nodata;
        voids.report(&self.path, warnings)?;
        Ok(Some((Raster::new(self.georef().clone(), cells), voids.n_nodata)))
    }
}
