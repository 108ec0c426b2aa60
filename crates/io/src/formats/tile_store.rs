//! A raster of 32-bit integers in tiles on disk, of which windows are read.
//!
//! The file has no name: it is gone when the store is dropped, and when the program is killed. Rows within a tile follow
//! each other, so that a window reads nothing but stretches of the tiles that it touches. Cells without a height are stored as
//! zeros, and a tile of these alone is a hole in the file: it takes no room.

use std::fs::File;
use std::io::Write;
use std::path::Path;

use rayon::prelude::*;

use crate::error::{Error, Result, WriteFault, io_words};
use crate::quantity::VOID;
use crate::raster::CellWindow;

/// Rows and columns of a tile \[cells\].
const TILE: usize = 256;

/// Rows of a tile that are read at a time by one thread.
const ROWS_AT_ONCE: usize = 32;

const BYTES: usize = size_of::<i32>();

/// A raster in tiles on disk.
#[derive(Debug)]
pub struct TileStore {
    file: File,
    n_rows: usize,
    n_cols: usize,
}

/// A [`TileStore`] that is being filled row by row.
#[derive(Debug)]
pub struct TileStoreWriter {
    store: TileStore,
    folder: String,
    /// The rows of tile row `tile_row` so far.
    band: Vec<i32>,
    tile_row: usize,
    bytes: Vec<u8>,
}

impl TileStoreWriter {
    /// A store of shape `[n_rows, n_cols]` in a file without a name in `folder`.
    ///
    /// # Errors
    /// E401 if the file cannot be made.
    pub fn create(folder: &Path, (n_rows, n_cols): (usize, usize)) -> Result<Self> {
        let folder_words = folder.display().to_string();
        let file = tempfile::tempfile_in(folder).map_err(|e| scratch_error(&folder_words, &e))?;
        file.set_len(TileStore::bytes_on_disk((n_rows, n_cols))).map_err(|e| scratch_error(&folder_words, &e))?;
        Ok(TileStoreWriter {
            store: TileStore { file, n_rows, n_cols },
            folder: folder_words,
            band: vec![VOID; TILE * n_cols],
            tile_row: 0,
            bytes: Vec::new(),
        })
    }

    /// Sets a row. Rows come in the order of the raster, or in the opposite one; all of them once.
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

    /// The filled store.
    ///
    /// # Errors
    /// As [`TileStoreWriter::put_row`].
    pub fn finish(mut self) -> Result<TileStore> {
        self.flush()?;
        Ok(self.store)
    }

    /// Writes the tiles of the current tile row.
    fn flush(&mut self) -> Result<()> {
        use std::io::{Seek, SeekFrom};
        let n_cols = self.store.n_cols;
        let across = n_cols.div_ceil(TILE);
        self.bytes.resize(across * TILE * TILE * BYTES, 0);
        let band = &self.band;
        self.bytes.par_chunks_mut(TILE * TILE * BYTES).enumerate().for_each(|(tile, bytes)| {
            let cols = tile * TILE..n_cols.min((tile + 1) * TILE);
            for (row, bytes) in bytes.chunks_exact_mut(TILE * BYTES).enumerate() {
                let cells = &band[row * n_cols + cols.start..row * n_cols + cols.end];
                for (bytes, cell) in bytes.chunks_exact_mut(BYTES).zip(cells) {
                    bytes.copy_from_slice(&(cell ^ VOID).to_le_bytes());
                }
            }
        });
        let start = self.tile_row as u64 * self.bytes.len() as u64;
        let mut write = || -> std::io::Result<()> {
            for (tile, bytes) in self.bytes.chunks_exact(TILE * TILE * BYTES).enumerate() {
                if bytes.iter().any(|byte| *byte != 0) {
                    self.store.file.seek(SeekFrom::Start(start + (tile * TILE * TILE * BYTES) as u64))?;
                    self.store.file.write_all(bytes)?;
                }
            }
            Ok(())
        };
        write().map_err(|e| scratch_error(&self.folder, &e))
    }
}

impl TileStore {
    /// Number of rows and columns.
    pub fn shape(&self) -> (usize, usize) {
        (self.n_rows, self.n_cols)
    }

    /// Bytes that a store of some cells takes on disk.
    pub fn bytes_on_disk((n_rows, n_cols): (usize, usize)) -> u64 {
        (n_rows.div_ceil(TILE) * n_cols.div_ceil(TILE)) as u64 * (TILE * TILE * BYTES) as u64
    }

    /// Replaces `cells` by those of a window, row by row from the north. Threads of the current pool share the reading.
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
        bytes.resize(n_rows * TILE * BYTES, 0);
        let end_col = window.col + n_cols;
        for tile in window.col / TILE..end_col.div_ceil(TILE) {
            let start = ((row / TILE * across + tile) * TILE + row % TILE) * TILE * BYTES;
            read_at(&self.file, bytes, start as u64).map_err(|e| scratch_error("what was written there", &e))?;
            let cols = window.col.max(tile * TILE)..end_col.min((tile + 1) * TILE);
            let within = cols.start - tile * TILE;
            for (row, bytes) in band.chunks_exact_mut(n_cols).zip(bytes.chunks_exact(TILE * BYTES)) {
                let cells = &mut row[cols.start - window.col..cols.end - window.col];
                for (cell, bytes) in cells.iter_mut().zip(bytes[within * BYTES..].as_chunks::<BYTES>().0) {
                    *cell = i32::from_le_bytes(*bytes) ^ VOID;
                }
            }
        }
        Ok(())
    }
}

fn scratch_error(folder: &str, cause: &std::io::Error) -> Error {
    Error::write(format!("a scratch file in {folder}"), WriteFault::Scratch(io_words(cause)))
}

/// Fills `bytes` from an offset on, without moving a position that threads share.
/// Systems without files have no tiles on them.
#[cfg(not(any(unix, windows)))]
fn read_at(_: &File, _: &mut [u8], _: u64) -> std::io::Result<()> {
    Err(std::io::ErrorKind::Unsupported.into())
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
