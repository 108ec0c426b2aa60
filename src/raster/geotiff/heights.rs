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
use crate::raster::Raster;
use crate::raster::file::reserve_cells;
use crate::raster::lattice_rows::lattice_row;
use crate::raster::sample::Sample;
use crate::raster::voids::Voids;

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
        let mut cells = vec![0_i32; self.georef().n_cells()];

        let n_cols = image.n_cols;
        let rows_at_once = (READ_BYTES / (4 * n_cols)).clamp(1, image.block_rows);
        // Parts of strips: the row of the file, the number of rows, and where their bytes begin.
        let mut parts: Vec<(u64, &mut [i32])> = Vec::new();
        let mut rest = cells.as_mut_slice();
        for (strip, (offset, _)) in image.blocks.iter().enumerate() {
            let n_rows = image.stored_rows(strip);
            for first in (0..n_rows).step_by(rows_at_once) {
                let n_here = rows_at_once.min(n_rows - first);
                let (part, after) = std::mem::take(&mut rest).split_at_mut(n_here * n_cols);
                rest = after;
                parts.push((offset + 4 * (first * n_cols) as u64, part));
            }
        }
        let (is_odd, n_nodata) = (AtomicBool::new(false), AtomicU64::new(0));
        let read = |buffers: &mut (Option<File>, Vec<u8>, Vec<f32>), (offset, cells): (u64, &mut [i32])| {
            if is_odd.load(Ordering::Relaxed) {
                return Ok(());
            }
            let (file, bytes, heights) = buffers;
            let failed = |e: std::io::Error| Error::file(301, format!("cannot read `{}`: {e}", self.path.display()));
            if file.is_none() {
                *file = Some(File::open(&self.path).map_err(failed)?);
            }
            let Some(file) = file else { return Ok(()) };
            bytes.resize(4 * cells.len(), 0);
            heights.resize(cells.len(), 0.0);
            file.seek(SeekFrom::Start(offset)).and_then(|_| file.read_exact(bytes)).map_err(failed)?;
            for (height, bytes) in heights.iter_mut().zip(bytes.chunks_exact(4)) {
                let bits = u32::from_ne_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
                *height = f32::from_bits(if is_swapped { bits.swap_bytes() } else { bits });
            }
            match lattice_row(heights, nodata, cells) {
                Some(found) => n_nodata.fetch_add(found, Ordering::Relaxed),
                None => u64::from(is_odd.swap(true, Ordering::Relaxed)),
            };
            Ok(())
        };
        parts
            .into_par_iter()
            .map_init(|| (None, Vec::new(), Vec::new()), |buffers, part| read(buffers, part))
            .collect::<Result<()>>()?;
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
