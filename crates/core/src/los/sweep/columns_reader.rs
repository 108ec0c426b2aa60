//! What a streamed sweep is asked: columns that a reader hands out window by window, and the receivers over them.

use fearless_simd::Level;

use crate::error::Result;
use crate::quantity::LatticePoint;
use crate::raster::{BitGrid, CellWindow};

/// What a streamed sweep may hold in memory beside a bit per cell; no result depends on it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StreamLimits {
    /// Lines of a strip; strips lie between its multiples, as tiles of that size do.
    pub lines: usize,
}

impl Default for StreamLimits {
    /// Strips as thick as a tile of 256 cells.
    fn default() -> Self {
        StreamLimits { lines: 256 }
    }
}

/// Columns that are read window by window; nothing lies outside them.
pub trait ColumnsReader: Sync {
    /// Number of rows and columns of cells.
    fn shape(&self) -> (usize, usize);

    /// Replaces `tops` by the tops of a window, row by row from the north \[1/1024 m\].
    ///
    /// # Errors
    /// If they cannot be read.
    fn read_tops(&self, window: CellWindow, tops: &mut Vec<i32>) -> Result<()>;

    /// Replaces `bases` by what the receivers of a window stand on, where that is not the top \[1/1024 m\].
    ///
    /// # Errors
    /// If they cannot be read.
    fn read_bases(&self, window: CellWindow, bases: &mut Vec<i32>) -> Result<()>;
}

/// Heights of the receivers at the cell centers of streamed columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StreamedHeights {
    /// All at one height \[1/1024 m above the datum\].
    Flat(i32),
    /// Above a base for each cell.
    Over {
        /// Whether that is the top of the cell; else [`ColumnsReader::read_bases`] has it.
        is_top: bool,
        /// How high they are above it \[1/1024 m\].
        above: i32,
        /// The lowest and the highest base, or anything beyond.
        range: (i32, i32),
    },
}

impl StreamedHeights {
    /// The lowest and the highest receiver.
    pub(crate) fn range(self) -> (i64, i64) {
        match self {
            StreamedHeights::Flat(z) => (i64::from(z), i64::from(z)),
            StreamedHeights::Over { above, range, .. } => {
                (i64::from(range.0) + i64::from(above), i64::from(range.1) + i64::from(above))
            }
        }
    }
}

/// What a streamed sweep is asked.
#[derive(Clone, Copy)]
#[expect(missing_debug_implementations, reason = "columns are read from anywhere")]
pub struct StreamedScene<'a> {
    /// The columns.
    pub columns: &'a dyn ColumnsReader,
    /// The highest top, or anything higher \[1/1024 m\].
    pub max_top: i32,
    /// The UAV, on the lattice of the columns.
    pub uav: LatticePoint,
    /// How high the receivers are.
    pub receivers: StreamedHeights,
    /// The cells of the columns that hold a receiver to decide.
    pub wanted: &'a BitGrid,
    /// A window that holds them, together with all cells between them and the UAV.
    pub window: CellWindow,
    /// The height from which on least heights are asked for, if they are, at least −2^25 \[1/1024 m above the datum\].
    pub heights_from: Option<i64>,
    /// What may be held in memory.
    pub limits: StreamLimits,
    /// The vector instructions to use: no result depends on them.
    pub level: Level,
}
