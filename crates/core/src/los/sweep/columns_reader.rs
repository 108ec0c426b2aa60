//! Input of a streamed sweep: columns that a reader supplies window by window, and the receivers
//! over them.

use fearless_simd::Level;

use crate::error::Result;
use crate::quantity::LatticePoint;
use crate::raster::{BitGrid, CellWindow};

/// Memory limits of a streamed sweep, in addition to a bit per cell; no result depends on them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StreamLimits {
    /// Lines of a strip. Strips lie between multiples of it, like tiles of that size.
    pub lines: usize,
}

impl Default for StreamLimits {
    /// Returns strips as thick as a tile of 256 cells.
    fn default() -> Self {
        StreamLimits { lines: 256 }
    }
}

/// Columns that are read window by window; nothing lies outside them.
pub trait ColumnsReader: Sync {
    /// Returns the number of rows and columns of cells.
    fn shape(&self) -> (usize, usize);

    /// Replaces `tops` by the tops of a window, row by row from the north \[1/1024 m\].
    ///
    /// # Errors
    /// If they cannot be read.
    fn read_tops(&self, window: CellWindow, tops: &mut Vec<i32>) -> Result<()>;

    /// Replaces `bases` by the bases of the receivers of a window, if these are not the tops
    /// \[1/1024 m\].
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
        /// `true` if the base is the top of the cell; else [`ColumnsReader::read_bases`] supplies
        /// it.
        is_top: bool,
        /// Height of receivers above their base \[1/1024 m\].
        above: i32,
        /// Bounds on the lowest and the highest base.
        range: (i32, i32),
    },
}

impl StreamedHeights {
    /// Returns bounds on the lowest and the highest receiver.
    pub(crate) fn range(self) -> (i64, i64) {
        match self {
            StreamedHeights::Flat(z) => (i64::from(z), i64::from(z)),
            StreamedHeights::Over { above, range, .. } => {
                (i64::from(range.0) + i64::from(above), i64::from(range.1) + i64::from(above))
            }
        }
    }
}

/// The request of a streamed sweep.
#[derive(Clone, Copy)]
#[expect(missing_debug_implementations, reason = "columns are read from anywhere")]
pub struct StreamedScene<'a> {
    /// The columns.
    pub columns: &'a dyn ColumnsReader,
    /// The highest top, or an upper bound of it \[1/1024 m\].
    pub max_top: i32,
    /// The UAV, on the lattice of the columns.
    pub uav: LatticePoint,
    /// Heights of the receivers.
    pub receivers: StreamedHeights,
    /// The cells of the columns that hold a receiver to decide.
    pub wanted: &'a BitGrid,
    /// A window that holds these cells and all cells between them and the UAV.
    pub window: CellWindow,
    /// Height above which least heights are requested, at least −2^25 \[1/1024 m above the datum\];
    /// `None` if they are not.
    pub heights_from: Option<i64>,
    /// Memory limits.
    pub limits: StreamLimits,
    /// The vector instructions to use; no result depends on them.
    pub level: Level,
}
