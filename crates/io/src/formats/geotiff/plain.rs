//! Plain GeoTIFFs: a header of 8 bytes (16 in a BigTIFF), strips of bare numbers, and the directory
//! last. Cells can thus be written before their description is known.

use std::io::{Cursor, Seek, SeekFrom, Write};

use tiff_core::{ByteOrder, Predictor, Tag};
use tiff_writer::encoder;

use skyshed_request::TiffLayout;

use super::image::ClassImage;
use super::levels::{Level, failed, level_tags, refused, rows_per_strip, tags_with_places};
use crate::error::Result;

/// Largest size of the cells of a classic TIFF \[bytes\]. The directory behind them fits into the
/// rest of its 4 GiB.
const LARGEST_CLASSIC: u64 = 3 << 30;

/// Writes a plain file front to back.
pub(super) fn write_plain(out: &mut impl Write, level: &Level<'_>, force_big: bool) -> Result<()> {
    let lens: Vec<u64> = level.blocks.iter().map(|block| block.len() as u64).collect();
    let frame = Frame::around(lens.iter().sum(), force_big);
    out.write_all(&frame.header()?).map_err(failed)?;
    for block in &level.blocks {
        out.write_all(block).map_err(failed)?;
    }
    out.write_all(&frame.directory(&level.tags, &lens)?).map_err(failed)
}

/// A plain GeoTIFF of classes whose rows are written one after another, from the north. It equals
/// the file that [`super::write_geotiff`] writes of the same cells in memory.
#[derive(Debug)]
pub struct ClassStrips<W> {
    out: W,
    n_rows: usize,
    n_cols: usize,
    n_pushed: usize,
    frame: Frame,
}

impl<W: Write> ClassStrips<W> {
    /// Begins a file of a shape: writes its header.
    ///
    /// # Errors
    /// E401 if `out` refuses the bytes.
    pub fn new(mut out: W, (n_rows, n_cols): (usize, usize)) -> Result<Self> {
        let frame = Frame::around((n_rows * n_cols) as u64, false);
        out.write_all(&frame.header()?).map_err(failed)?;
        Ok(ClassStrips { out, n_rows, n_cols, n_pushed: 0, frame })
    }

    /// Writes whole rows.
    ///
    /// # Errors
    /// E401 if `out` refuses the bytes.
    ///
    /// # Panics
    /// If `cells` are not whole rows, or more than are missing.
    pub fn push(&mut self, cells: &[u8]) -> Result<()> {
        assert!(cells.len().is_multiple_of(self.n_cols), "whole rows");
        self.n_pushed += cells.len() / self.n_cols;
        assert!(self.n_pushed <= self.n_rows, "no more rows than there are");
        self.out.write_all(cells).map_err(failed)
    }

    /// Writes the description of the file, with items of GDAL's metadata, and returns the writer.
    ///
    /// # Errors
    /// E401 if `out` refuses the bytes, E402 if TIFF cannot hold the image.
    ///
    /// # Panics
    /// If rows are missing.
    pub fn finish(mut self, image: &ClassImage<'_>, metadata: &[(String, String)]) -> Result<W> {
        assert_eq!(self.n_pushed, self.n_rows, "all rows were pushed");
        let head = image.head(metadata, TiffLayout::Plain);
        let tags = level_tags::<u8>(&head, ((self.n_rows, self.n_cols), 1), &[image.name], Predictor::None)?;
        let in_strip = rows_per_strip::<u8>(self.n_cols);
        let rows_of = |first: usize| in_strip.min(self.n_rows - first);
        let lens: Vec<u64> =
            (0..self.n_rows).step_by(in_strip).map(|first| (rows_of(first) * self.n_cols) as u64).collect();
        self.out.write_all(&self.frame.directory(&tags, &lens)?).map_err(failed)?;
        Ok(self.out)
    }
}

/// Bytes before and behind the cells of a file.
#[derive(Debug, Clone, Copy)]
struct Frame {
    is_big: bool,
    /// Length of all cells \[bytes\].
    n_bytes: u64,
}

const ORDER: ByteOrder = ByteOrder::LittleEndian;

impl Frame {
    fn around(n_bytes: u64, force_big: bool) -> Self {
        Frame { is_big: force_big || n_bytes > LARGEST_CLASSIC, n_bytes }
    }

    /// Returns the offset of the directory, which is even.
    fn directory_at(&self) -> u64 {
        (encoder::header_len(self.is_big) + self.n_bytes).next_multiple_of(2)
    }

    fn header(&self) -> Result<Vec<u8>> {
        let mut bytes = Cursor::new(Vec::new());
        let header = encoder::write_header(&mut bytes, ORDER, self.is_big).map_err(refused)?;
        encoder::patch_first_ifd(&mut bytes, header, ORDER, self.is_big, self.directory_at()).map_err(refused)?;
        Ok(bytes.into_inner())
    }

    /// Returns all bytes after the cells, given the lengths of the strips.
    fn directory(&self, tags: &[Tag], lens: &[u64]) -> Result<Vec<u8>> {
        let first = encoder::header_len(self.is_big);
        let codes = (tiff_core::TAG_STRIP_OFFSETS, tiff_core::TAG_STRIP_BYTE_COUNTS);
        let tags = tags_with_places(tags, codes, lens, first, self.is_big);
        let mut bytes = Beyond { start: first + self.n_bytes, bytes: Cursor::new(Vec::new()) };
        bytes.seek(SeekFrom::Start(self.directory_at())).map_err(failed)?;
        encoder::write_ifd(&mut bytes, ORDER, self.is_big, &tags, codes.0, codes.1, lens.len()).map_err(refused)?;
        Ok(bytes.bytes.into_inner())
    }
}

/// End of a file, from offset `start` on.
struct Beyond {
    start: u64,
    bytes: Cursor<Vec<u8>>,
}

impl Write for Beyond {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.bytes.write(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

impl Seek for Beyond {
    fn seek(&mut self, to: SeekFrom) -> std::io::Result<u64> {
        let to = match to {
            SeekFrom::Start(at) => SeekFrom::Start(at.checked_sub(self.start).ok_or(std::io::ErrorKind::InvalidInput)?),
            from => from,
        };
        Ok(self.bytes.seek(to)? + self.start)
    }
}
