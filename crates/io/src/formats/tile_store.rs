//! A raster of 32-bit integers in tiles on disk, which is read in windows.
//!
//! The file has no name: it is gone when the store is dropped, and when the program is killed. Rows
//! within a tile follow each other, so that a window reads only stretches of the tiles that it
//! touches.
//!
//! Cells without a height are stored as zeros. A tile of such cells alone is a hole in the file,
//! which takes no space. Most tiles have heights within 64 m of each other. They are stored in 16
//! bits above the lowest of them; the rest of such a tile's place is a hole, too.
//!
//! PERF: a map by strips waits for the disk.

use std::fs::File;
use std::path::Path;

use rayon::prelude::*;

use crate::error::{Error, Result, WriteFault, io_words};
use crate::quantity::VOID;
use crate::raster::CellWindow;

/// Rows and columns of a tile \[cells\].
const TILE: usize = 256;

/// Rows of a tile that are read at a time by one thread.
const ROWS_AT_ONCE: usize = 32;

/// Size of a cell in a tile that is not narrow \[bytes\].
const BYTES: usize = size_of::<i32>();

/// A raster in tiles on disk.
#[derive(Debug)]
pub struct TileStore {
    file: File,
    n_rows: usize,
    n_cols: usize,
    /// Base of the 16-bit numbers of each narrow tile, in which a cell without a height is 0;
    /// `None` for other tiles.
    bases: Vec<Option<i32>>,
}

/// Returns the base of the numbers of a tile, if 16 bits hold them.
fn base_of(cells: impl Iterator<Item = i32>) -> Option<i32> {
    let (low, high) = cells.filter(|z| *z != VOID).fold((i32::MAX, i32::MIN), |r, z| (r.0.min(z), r.1.max(z)));
    let base = low.checked_sub(1)?;
    high.checked_sub(base).filter(|range| u16::try_from(*range).is_ok()).map(|_| base)
}

/// A [`TileStore`] that is filled row by row.
#[derive(Debug)]
pub struct TileStoreWriter {
    store: TileStore,
    folder: String,
    /// Rows of tile row `tile_row` so far.
    band: Vec<i32>,
    tile_row: usize,
    bytes: Vec<u8>,
}

impl TileStoreWriter {
    /// Creates a store of shape `[n_rows, n_cols]` in a file without a name in `folder`.
    ///
    /// # Errors
    /// E401 if the file cannot be made.
    pub fn create(folder: &Path, (n_rows, n_cols): (usize, usize)) -> Result<Self> {
        let folder_words = folder.display().to_string();
        let file = tempfile::tempfile_in(folder).map_err(|e| scratch_error(&folder_words, &e))?;
        file.set_len(TileStore::bytes_on_disk((n_rows, n_cols))).map_err(|e| scratch_error(&folder_words, &e))?;
        Ok(TileStoreWriter {
            store: TileStore { file, n_rows, n_cols, bases: vec![None; n_rows.div_ceil(TILE) * n_cols.div_ceil(TILE)] },
            folder: folder_words,
            band: vec![VOID; TILE * n_cols],
            tile_row: 0,
            bytes: Vec::new(),
        })
    }

    /// Sets a row. Rows come in the order of the raster or in the opposite one, each once.
    ///
    /// # Errors
    /// E401 if the disk is full or refuses the bytes.
    ///
    /// # Panics
    /// If the row does not hold a value per column.
    pub fn put_row(&mut self, row: usize, cells: &[i32]) -> Result<()> {
        let n_cols = self.store.n_cols;
        assert_eq!(cells.len(), n_cols, "a row holds one value per column");
        if row / TILE != self.tile_row {
            self.flush()?;
            self.tile_row = row / TILE;
        }
        let first = row % TILE * n_cols;
        self.band[first..first + n_cols].copy_from_slice(cells);
        Ok(())
    }

    /// Returns the filled store.
    ///
    /// # Errors
    /// Errors of [`TileStoreWriter::put_row`].
    pub fn finish(mut self) -> Result<TileStore> {
        self.flush()?;
        Ok(self.store)
    }

    /// Writes the tiles of the current tile row.
    fn flush(&mut self) -> Result<()> {
        let n_cols = self.store.n_cols;
        let across = n_cols.div_ceil(TILE);
        self.bytes.resize(across * TILE * TILE * BYTES, 0);
        let band = &self.band;
        let start = self.tile_row as u64 * self.bytes.len() as u64;
        let n_rows = TILE.min(self.store.n_rows - self.tile_row * TILE);
        let encode = |(tile, bytes): (usize, &mut [u8])| -> (Option<i32>, usize) {
            let cols = tile * TILE..n_cols.min((tile + 1) * TILE);
            let rows = || (0..n_rows).map(|row| &band[row * n_cols + cols.start..row * n_cols + cols.end]);
            let base = base_of(rows().flatten().copied());
            bytes.fill(0);
            let n_bytes = match base {
                Some(base) => {
                    for (cells, bytes) in rows().zip(bytes.chunks_exact_mut(TILE * size_of::<u16>())) {
                        for (bytes, cell) in bytes.as_chunks_mut::<2>().0.iter_mut().zip(cells) {
                            #[expect(
                                clippy::cast_possible_truncation,
                                clippy::cast_sign_loss,
                                reason = "base_of says so"
                            )]
                            let above = if *cell == VOID { 0 } else { (cell - base) as u16 };
                            *bytes = above.to_le_bytes();
                        }
                    }
                    TILE * TILE * size_of::<u16>()
                }
                None => {
                    for (cells, bytes) in rows().zip(bytes.chunks_exact_mut(TILE * BYTES)) {
                        for (bytes, cell) in bytes.as_chunks_mut::<BYTES>().0.iter_mut().zip(cells) {
                            *bytes = (cell ^ VOID).to_le_bytes();
                        }
                    }
                    bytes.len()
                }
            };
            let is_empty = base.is_none() && bytes.iter().all(|byte| *byte == 0);
            (base, if is_empty { 0 } else { n_bytes })
        };
        let encoded: Vec<(Option<i32>, usize)> =
            self.bytes.par_chunks_mut(TILE * TILE * BYTES).enumerate().map(encode).collect();
        // PERF: one after the other; threads that write to one file wait for each other.
        for (tile, (bytes, (base, n_bytes))) in self.bytes.chunks_exact(TILE * TILE * BYTES).zip(encoded).enumerate() {
            self.store.bases[self.tile_row * across + tile] = base;
            let place = start + (tile * TILE * TILE * BYTES) as u64;
            write_at(&self.store.file, &bytes[..n_bytes], place).map_err(|e| scratch_error(&self.folder, &e))?;
        }
        Ok(())
    }
}

impl TileStore {
    /// Returns the number of rows and columns.
    pub fn shape(&self) -> (usize, usize) {
        (self.n_rows, self.n_cols)
    }

    /// Returns the bytes that a store of some cells takes on disk.
    pub fn bytes_on_disk((n_rows, n_cols): (usize, usize)) -> u64 {
        (n_rows.div_ceil(TILE) * n_cols.div_ceil(TILE)) as u64 * (TILE * TILE * BYTES) as u64
    }

    /// Replaces `cells` by those of a window, row by row from the north. Threads of the current
    /// pool share the reading.
    ///
    /// # Errors
    /// E401 if the file cannot be read.
    ///
    /// # Panics
    /// If the window reaches beyond the raster.
    pub fn read(&self, window: CellWindow, cells: &mut Vec<i32>) -> Result<()> {
        let rows = window.row..window.row + window.n_rows;
        assert!(rows.end <= self.n_rows && window.col + window.n_cols <= self.n_cols, "a window within the raster");
        cells.resize(window.n_rows * window.n_cols, 0);
        let mut rest = cells.as_mut_slice();
        let mut bands = Vec::new();
        let mut row = rows.start;
        while row < rows.end {
            let end = ((row / ROWS_AT_ONCE + 1) * ROWS_AT_ONCE).min(rows.end);
            let (band, others) = rest.split_at_mut((end - row) * window.n_cols);
            bands.push((row, band));
            rest = others;
            row = end;
        }
        bands.into_par_iter().try_for_each_init(Vec::new, |bytes, (row, band)| self.read_band(row, band, window, bytes))
    }

    /// Reads whole rows of a window that lie in one row of tiles.
    fn read_band(&self, row: usize, band: &mut [i32], window: CellWindow, bytes: &mut Vec<u8>) -> Result<()> {
        let (n_cols, n_rows) = (window.n_cols, band.len() / window.n_cols.max(1));
        let across = self.n_cols.div_ceil(TILE);
        let end_col = window.col + n_cols;
        for tile in window.col / TILE..end_col.div_ceil(TILE) {
            let index = row / TILE * across + tile;
            let base = self.bases[index];
            let width = if base.is_some() { size_of::<u16>() } else { BYTES };
            bytes.resize(n_rows * TILE * width, 0);
            let start = index * TILE * TILE * BYTES + row % TILE * TILE * width;
            read_at(&self.file, bytes, start as u64).map_err(|e| scratch_error("what was written there", &e))?;
            let cols = window.col.max(tile * TILE)..end_col.min((tile + 1) * TILE);
            let within = cols.start - tile * TILE;
            for (row, bytes) in band.chunks_exact_mut(n_cols).zip(bytes.chunks_exact(TILE * width)) {
                let (cells, bytes) =
                    (&mut row[cols.start - window.col..cols.end - window.col], &bytes[within * width..]);
                match base {
                    Some(base) => {
                        for (cell, bytes) in cells.iter_mut().zip(bytes.as_chunks::<2>().0) {
                            let above = i32::from(u16::from_le_bytes(*bytes));
                            *cell = if above == 0 { VOID } else { base + above };
                        }
                    }
                    None => {
                        for (cell, bytes) in cells.iter_mut().zip(bytes.as_chunks::<BYTES>().0) {
                            *cell = i32::from_le_bytes(*bytes) ^ VOID;
                        }
                    }
                }
            }
        }
        Ok(())
    }
}

fn scratch_error(folder: &str, cause: &std::io::Error) -> Error {
    Error::write(format!("a scratch file in {folder}"), WriteFault::Scratch(io_words(cause)))
}

/// Fills `bytes` from an offset on, without moving a position that threads share. Unsupported on
/// systems without files, where no tiles exist.
#[cfg(not(any(unix, windows)))]
fn read_at(_: &File, _: &mut [u8], _: u64) -> std::io::Result<()> {
    Err(std::io::ErrorKind::Unsupported.into())
}

/// Writes bytes from an offset on, from any thread.
#[cfg(not(any(unix, windows)))]
fn write_at(_: &File, _: &[u8], _: u64) -> std::io::Result<()> {
    Err(std::io::ErrorKind::Unsupported.into())
}

#[cfg(unix)]
fn write_at(file: &File, bytes: &[u8], offset: u64) -> std::io::Result<()> {
    std::os::unix::fs::FileExt::write_all_at(file, bytes, offset)
}

#[cfg(windows)]
fn write_at(file: &File, mut bytes: &[u8], mut offset: u64) -> std::io::Result<()> {
    while !bytes.is_empty() {
        let n = std::os::windows::fs::FileExt::seek_write(file, bytes, offset)?;
        if n == 0 {
            return Err(std::io::ErrorKind::WriteZero.into());
        }
        bytes = &bytes[n..];
        offset += n as u64;
    }
    Ok(())
}

#[cfg(unix)]
fn read_at(file: &File, bytes: &mut [u8], offset: u64) -> std::io::Result<()> {
    std::os::unix::fs::FileExt::read_exact_at(file, bytes, offset)
}

/// Fills `bytes` from an offset on, whatever position other threads leave behind.
#[cfg(windows)]
fn read_at(file: &File, mut bytes: &mut [u8], mut offset: u64) -> std::io::Result<()> {
    while !bytes.is_empty() {
        let n = std::os::windows::fs::FileExt::seek_read(file, bytes, offset)?;
        if n == 0 {
            return Err(std::io::ErrorKind::UnexpectedEof.into());
        }
        bytes = &mut bytes[n..];
        offset += n as u64;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_of_few_and_of_many_heights_come_back() {
        let (n_rows, n_cols) = (600, 530);
        let height = |row: usize, col: usize| match (row / TILE, col / TILE) {
            _ if (row + col).is_multiple_of(7) => VOID,
            // The widest that 16 bits hold, and one step more; the extremes; one height.
            (0, 0) => -5 + i32::try_from((row * 37 + col) % 65_535).unwrap(),
            (0, 1) => -70_000 + if col.is_multiple_of(2) { 65_535 } else { 0 },
            (1, 0) => {
                if row.is_multiple_of(2) {
                    i32::MIN + 1
                } else {
                    i32::MAX
                }
            }
            (1, 1) => i32::MIN + 1,
            (2, _) => VOID,
            _ => 4000,
        };
        let mut writer = TileStoreWriter::create(&std::env::temp_dir(), (n_rows, n_cols)).unwrap();
        for row in 0..n_rows {
            writer.put_row(row, &(0..n_cols).map(|col| height(row, col)).collect::<Vec<_>>()).unwrap();
        }
        let store = writer.finish().unwrap();
        for (row, col, n_rows, n_cols) in [(0, 0, 600, 530), (250, 200, 20, 330), (599, 529, 1, 1), (31, 256, 40, 1)] {
            let mut found = Vec::new();
            store.read(CellWindow { row, col, n_rows, n_cols }, &mut found).unwrap();
            let wanted = |k: usize| height(row + k / n_cols, col + k % n_cols);
            assert!(found.iter().enumerate().all(|(k, z)| *z == wanted(k)), "{row} {col}");
        }
        assert!(store.bases[0].is_some() && store.bases[1].is_none() && store.bases[3].is_none());
    }

    #[cfg(unix)]
    #[test]
    fn cells_without_a_height_take_no_room_on_the_disk() {
        use std::os::unix::fs::MetadataExt;
        let (n_rows, n_cols) = (1024, 1024);
        let mut writer = TileStoreWriter::create(&std::env::temp_dir(), (n_rows, n_cols)).unwrap();
        let mut cells = vec![VOID; n_cols];
        for row in 0..n_rows {
            // One cell of one tile has a height.
            cells[700] = if row == 300 { 7 } else { VOID };
            writer.put_row(row, &cells).unwrap();
        }
        let store = writer.finish().unwrap();
        let on_disk = 512 * store.file.metadata().unwrap().blocks();
        assert!(on_disk <= 2 * (TILE * TILE * BYTES) as u64, "{on_disk} bytes for one tile");
        let mut found = Vec::new();
        store.read(CellWindow { row: 0, col: 0, n_rows, n_cols }, &mut found).unwrap();
        assert!(found.iter().enumerate().all(|(k, z)| *z == if k == 300 * n_cols + 700 { 7 } else { VOID }));
    }
}
