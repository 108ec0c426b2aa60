//! Step 2: rows of a quadrant in memory, from any source.
//!
//! Rows of a raster in memory are lent as they are. Its columns are turned into rows, a strip of 64
//! at a time, and so are columns from a reader. So memory is read in rows throughout. Over a curved
//! earth rows are copied, 16 at a time, and lowered. A lowered raster would be as much memory
//! again, whose first touch costs more than line of sight does.

use std::ops::Range;

use fearless_simd::Level;

use super::columns_reader::{ColumnsReader, StreamedHeights};
use super::frame::{Frame, as_i64};
use super::simd::turn;
use crate::dispatch;
use crate::error::Result;
use crate::height_field::{Columns, HeightsOf, SeenHeights, TILE_BITS, TileMaxima};
use crate::raster::CellWindow;

/// The heights of receivers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Stand {
    /// All at one height \[1/1024 m above the datum\].
    Flat(i32),
    /// This much above the tops of their cells.
    OnTops(i32),
    /// This much above bases of their own.
    OnBases(i32),
}

/// Some rows of a quadrant.
#[derive(Debug, Clone)]
pub(super) struct Rows<'a> {
    pub(super) numbers: Range<usize>,
    /// Lateral index of the first cell of each row, and the number of cells per row.
    first: usize,
    width: usize,
    tops: &'a [i32],
    bases: &'a [i32],
    /// `true` if the first row in memory is the outermost.
    is_inward: bool,
}

impl<'a> Rows<'a> {
    fn cells(&self, row: usize) -> Range<usize> {
        let index = if self.is_inward { self.numbers.end - 1 - row } else { row - self.numbers.start };
        index * self.width..(index + 1) * self.width
    }

    /// Returns the lateral index of the first cell of each row.
    pub(super) fn first(&self) -> i64 {
        as_i64(self.first)
    }

    /// Returns the tops of a row.
    #[inline(always)]
    pub(super) fn tops(&self, row: usize) -> &'a [i32] {
        &self.tops[self.cells(row)]
    }

    /// Returns the bases of a row's receivers; empty if all have one height.
    #[inline(always)]
    pub(super) fn bases(&self, row: usize, stand: Stand) -> &'a [i32] {
        match stand {
            Stand::Flat(_) => &[],
            Stand::OnTops(_) => self.tops(row),
            Stand::OnBases(_) => &self.bases[self.cells(row)],
        }
    }
}

/// Room for rows that are not in memory in the needed form.
#[derive(Debug, Default)]
pub(super) struct RowBuffer {
    read: Vec<i32>,
    tops: Vec<i32>,
    bases: Vec<i32>,
}

/// A source of rows.
pub(super) trait RowSource: Sync {
    /// Returns the number of raster rows or columns lent at once: those between multiples of it.
    fn strip(&self, frame: &Frame) -> usize;

    /// Returns some rows of one strip, from lateral cell `lateral.start` to before `lateral.end`,
    /// or more.
    ///
    /// # Errors
    /// If they cannot be read.
    fn rows<'b>(
        &'b self,
        frame: &Frame,
        numbers: Range<usize>,
        lateral: Range<usize>,
        buffer: &'b mut RowBuffer,
    ) -> Result<Rows<'b>>;
}

/// Columns in memory, and the bases of receivers if these are neither flat nor tops.
pub(super) struct InMemory<'a> {
    pub(super) columns: &'a Columns,
    pub(super) bases: Option<SeenHeights<'a>>,
    pub(super) level: Level,
}

/// Raster rows that are lowered at once: few, so that they are still in the cache when they are
/// passed.
const LOWERED: usize = 16;

impl<'a> InMemory<'a> {
    /// Returns tops and bases, if both are in memory as the UAV sees them.
    fn as_seen(&self) -> Option<(&'a [i32], &'a [i32])> {
        let bases = self.bases.map_or(Some(&[][..]), |bases| bases.in_memory());
        self.columns.seen_tops().in_memory().zip(bases)
    }

    /// Copies some lines of a frame as the UAV sees them, from cell `lateral.start` to before
    /// `lateral.end`.
    fn copy(
        &self,
        seen: &SeenHeights<'_>,
        frame: &Frame,
        (lines, lateral): (&Range<usize>, &Range<usize>),
        out: &mut Vec<i32>,
    ) {
        let width = lateral.len();
        if out.len() < lines.len() * width {
            out.resize(lines.len() * width, 0);
        }
        if frame.quadrant.has_raster_rows() {
            for (line, out) in lines.clone().zip(out.chunks_mut(width.max(1))) {
                seen.copy(line * seen.n_cols + lateral.start, out);
            }
            return;
        }
        if let HeightsOf::Cells(cells) = seen.heights {
            dispatch!(self.level, simd => turn(simd, cells, seen.n_cols, lines, lateral, out));
        }
        for (line, out) in lines.clone().zip(out.chunks_mut(width.max(1))) {
            if let HeightsOf::One(z) = seen.heights {
                out.fill(z);
            }
            if let Some(drops) = seen.drops {
                drops.lower_col((lateral.start, line), out);
            }
        }
    }
}

impl RowSource for InMemory<'_> {
    fn strip(&self, frame: &Frame) -> usize {
        match (frame.quadrant.has_raster_rows(), self.as_seen()) {
            (true, Some(_)) => usize::MAX,
            (true, None) => LOWERED,
            (false, _) => super::simd::STRIP,
        }
    }

    fn rows<'b>(
        &'b self,
        frame: &Frame,
        numbers: Range<usize>,
        lateral: Range<usize>,
        buffer: &'b mut RowBuffer,
    ) -> Result<Rows<'b>> {
        let (n_cols, lines) = (self.columns.n_cols(), frame.lines_of(&numbers));
        let is_inward = !frame.counts_up();
        if let Some((tops, bases)) = self.as_seen().filter(|_| frame.quadrant.has_raster_rows()) {
            let cells = lines.start * n_cols..lines.end * n_cols;
            let bases = if bases.is_empty() { bases } else { &bases[cells.clone()] };
            return Ok(Rows { numbers, first: 0, width: n_cols, tops: &tops[cells], bases, is_inward });
        }
        self.copy(&self.columns.seen_tops(), frame, (&lines, &lateral), &mut buffer.tops);
        if let Some(bases) = &self.bases {
            self.copy(bases, frame, (&lines, &lateral), &mut buffer.bases);
        }
        Ok(Rows {
            numbers,
            first: lateral.start,
            width: lateral.len(),
            tops: &buffer.tops,
            bases: &buffer.bases,
            is_inward,
        })
    }
}

impl ColumnsReader for InMemory<'_> {
    fn shape(&self) -> (usize, usize) {
        (self.columns.n_rows(), self.columns.n_cols())
    }

    fn read_tops(&self, window: CellWindow, tops: &mut Vec<i32>) -> Result<()> {
        copy(&self.columns.seen_tops(), window, tops);
        Ok(())
    }

    fn read_bases(&self, window: CellWindow, bases: &mut Vec<i32>) -> Result<()> {
        if let Some(seen) = &self.bases {
            copy(seen, window, bases);
        }
        Ok(())
    }
}

/// Copies a window of cells.
fn copy(seen: &SeenHeights<'_>, window: CellWindow, out: &mut Vec<i32>) {
    out.clear();
    out.resize(window.n_rows * window.n_cols, 0);
    for (row, out) in (window.row..).zip(out.chunks_mut(window.n_cols.max(1))) {
        seen.copy(row * seen.n_cols + window.col, out);
    }
}

/// Columns that a reader supplies window by window.
pub(super) struct FromReader<'a> {
    pub(super) columns: &'a dyn ColumnsReader,
    pub(super) receivers: StreamedHeights,
    /// Raster rows or columns to be read at once.
    pub(super) strip: usize,
    pub(super) level: Level,
}

impl RowSource for FromReader<'_> {
    fn strip(&self, _: &Frame) -> usize {
        self.strip
    }

    fn rows<'b>(
        &'b self,
        frame: &Frame,
        numbers: Range<usize>,
        lateral: Range<usize>,
        buffer: &'b mut RowBuffer,
    ) -> Result<Rows<'b>> {
        let (lines, width) = (frame.lines_of(&numbers), lateral.len());
        let is_rows = frame.quadrant.has_raster_rows();
        let (rows, cols) = if is_rows { (&lines, &lateral) } else { (&lateral, &lines) };
        let window = CellWindow { row: rows.start, col: cols.start, n_rows: rows.len(), n_cols: cols.len() };
        let turned = |read: &mut Vec<i32>, out: &mut Vec<i32>| {
            if is_rows {
                std::mem::swap(read, out);
            } else {
                let (cols, rows) = (0..window.n_cols, 0..window.n_rows);
                dispatch!(self.level, simd => turn(simd, read, window.n_cols, &cols, &rows, out));
            }
        };
        if !lateral.is_empty() {
            self.columns.read_tops(window, &mut buffer.read)?;
            turned(&mut buffer.read, &mut buffer.tops);
            if matches!(self.receivers, StreamedHeights::Over { is_top: false, .. }) {
                self.columns.read_bases(window, &mut buffer.read)?;
                turned(&mut buffer.read, &mut buffer.bases);
            }
        }
        let is_inward = !frame.counts_up();
        Ok(Rows { numbers, first: lateral.start, width, tops: &buffer.tops, bases: &buffer.bases, is_inward })
    }
}

/// The highest tops of tiles of 8 × 8 cells. Also the highest bases of receivers there, if these
/// are neither flat nor tops.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tiles<'a> {
    pub(super) tops: &'a TileMaxima,
    pub(super) bases: Option<&'a TileMaxima>,
}

impl Tiles<'_> {
    /// Returns the highest top or receiver above the UAV in the tiles of number `tile` across the
    /// way out. They are those over the lateral cells from `from` to before `to`, of which there is
    /// at least one. Receivers count only with a `stand`.
    pub(super) fn highest(&self, frame: &Frame, tile: usize, (from, to): (i64, i64), stand: Option<Stand>) -> i32 {
        let per_row = self.tops.per_row();
        let (first, stride) = if frame.quadrant.has_raster_rows() { (tile * per_row, 1) } else { (tile, per_row) };
        let lateral = |cell: i64| usize::try_from(cell >> TILE_BITS).unwrap_or(0);
        let highest = |of: &TileMaxima| {
            let tiles = lateral(from)..lateral(to - 1) + 1;
            tiles.fold(i32::MIN, |a, tile| a.max(of.maxima()[first + tile * stride]))
        };
        // EXACT: known heights differ by less than 2^28; a void stays below all of them.
        let top = highest(self.tops);
        let receiver = match stand {
            None => i32::MIN,
            Some(Stand::Flat(z)) => z,
            Some(Stand::OnTops(above)) => top.saturating_add(above),
            Some(Stand::OnBases(above)) => highest(self.bases.unwrap_or(self.tops)).saturating_add(above),
        };
        top.max(receiver).saturating_sub(frame.uav_z)
    }
}
