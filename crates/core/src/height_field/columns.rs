//! Columns: the solid of a raster, each cell a flat-topped column.

use std::sync::{Arc, OnceLock};

use super::plateaus::Plateaus;
use super::seen_heights::{Drops, HeightsOf, SeenHeights};
use super::tile_maxima::TileMaxima;
use crate::quantity::{BLOCKS_ALL, STEPS_PER_UNIT, VOID};
use crate::raster::{CellWindow, LargeVec};

/// Edge length of a cell on the lattice of a raster scene.
const CELL: i64 = STEPS_PER_UNIT as i64;

/// The closed union T of the columns over the cells of a raster; nothing lies outside it.
///
/// Cell `(row, col)` is the rectangle `[col, col+1] × [n_rows−1−row, n_rows−row]` in units of
/// [`Columns::steps`]: row 0 is the northernmost and the local origin is the south-west corner.
#[derive(Debug, Clone)]
pub struct Columns {
    n_cols: usize,
    n_rows: usize,
    steps: [i64; 2],
    /// As they are over a flat earth.
    tops: Arc<LargeVec<i32>>,
    bent: Option<Bent>,
    plateaus: Option<Plateaus>,
    /// The lowest and the highest top; of lowered columns what these are not beyond.
    extremes: (i32, i32),
    lowest_known: OnceLock<Option<i32>>,
    tiles: OnceLock<TileMaxima>,
    tiles_of_tiles: OnceLock<TileMaxima>,
}

/// Drops of tops over a curved earth.
#[derive(Debug, Clone)]
struct Bent {
    drops: Arc<Drops>,
    /// All tops, once somebody has asked for them.
    tops: OnceLock<LargeVec<i32>>,
}

impl PartialEq for Columns {
    /// Compares the tops, from which all else follows.
    fn eq(&self, other: &Self) -> bool {
        (self.n_cols, self.n_rows, self.steps) == (other.n_cols, other.n_rows, other.steps)
            && self.tops() == other.tops()
    }
}

impl Eq for Columns {}

impl Columns {
    /// Returns columns from their tops \[1/1024 m above the datum\], row by row from the north-west
    /// cell; [`VOID`] blocks nothing.
    pub fn new(n_rows: usize, n_cols: usize, tops: impl Into<LargeVec<i32>>) -> Self {
        let tops = tops.into();
        assert!(n_rows > 0 && n_cols > 0 && tops.len() == n_rows * n_cols, "one top per cell");
        let plateaus = Plateaus::if_few(&tops, n_cols);
        let tiles = OnceLock::new();
        let extremes = match &plateaus {
            Some(plateaus) => plateaus.extremes(),
            None => tiles.get_or_init(|| TileMaxima::of(&tops, n_cols)).extremes(),
        };
        Columns {
            n_cols,
            n_rows,
            steps: [CELL; 2],
            tops: Arc::new(tops),
            bent: None,
            plateaus,
            extremes,
            lowest_known: OnceLock::new(),
            tiles,
            tiles_of_tiles: OnceLock::new(),
        }
    }

    /// Makes cells of other sizes than 1024 × 1024 lattice steps: those of a terrain below
    /// footprints.
    #[must_use]
    pub(crate) fn with_cells_of(mut self, steps: [i64; 2]) -> Self {
        self.steps = steps;
        self
    }

    /// Returns these columns lower by drops, of which those within a window matter. No top is
    /// lowered before it is asked for.
    pub(super) fn lowered(&self, drops: Arc<Drops>, window: CellWindow) -> Columns {
        let (low, high) = self.extremes;
        let most = i32::try_from(drops.most(window)).unwrap_or(i32::MAX);
        let low = if low == VOID { VOID } else { low.saturating_sub(most) };
        Columns {
            n_cols: self.n_cols,
            n_rows: self.n_rows,
            steps: self.steps,
            tops: Arc::clone(&self.tops),
            plateaus: None,
            extremes: (low, high),
            lowest_known: OnceLock::new(),
            tiles: OnceLock::from(drops.of_tiles(self.tiles())),
            tiles_of_tiles: OnceLock::new(),
            bent: Some(Bent { drops, tops: OnceLock::new() }),
        }
    }

    /// Returns all cells.
    pub(super) fn window(&self) -> CellWindow {
        CellWindow { row: 0, col: 0, n_rows: self.n_rows, n_cols: self.n_cols }
    }

    /// Returns the width and height of a cell \[lattice steps\].
    #[inline]
    pub fn steps(&self) -> [i64; 2] {
        self.steps
    }

    /// Returns whether a cell has 1024 × 1024 lattice steps, as the engines for whole rasters
    /// reckon with.
    pub(crate) fn has_unit_cells(&self) -> bool {
        self.steps == [CELL; 2]
    }

    /// Returns the number of columns of cells.
    pub fn n_cols(&self) -> usize {
        self.n_cols
    }

    /// Returns the number of rows of cells.
    pub fn n_rows(&self) -> usize {
        self.n_rows
    }

    /// Returns the top of the cell at an index into [`Columns::tops`], which need not be in memory
    /// as a whole for it.
    #[inline]
    pub(crate) fn top_at(&self, index: usize) -> i32 {
        let top = self.tops.value(index);
        self.bent.as_ref().map_or(top, |bent| bent.drops.lowered(top, (index / self.n_cols, index % self.n_cols)))
    }

    /// Copies tops from an index into [`Columns::tops`] on, all in one row, which need not be in
    /// memory as a whole for it.
    #[inline]
    pub(crate) fn copy_tops(&self, first: usize, out: &mut [i32]) {
        self.tops.copy(first, out);
        if let Some(bent) = &self.bent {
            bent.drops.lower_row((first / self.n_cols, first % self.n_cols), out);
        }
    }

    /// Returns all tops, if they are in memory one by one.
    pub(crate) fn tops_in_memory(&self) -> Option<&[i32]> {
        self.bent.as_ref().map_or(self.tops.in_memory(), |bent| bent.tops.get().map(LargeVec::as_slice))
    }

    /// Returns all tops, unless each would have to be lowered first.
    #[inline]
    pub(crate) fn tops_at_hand(&self) -> Option<&[i32]> {
        self.bent.as_ref().map_or(Some(&self.tops), |bent| bent.tops.get().map(LargeVec::as_slice))
    }

    /// Returns all tops, row by row from the north-west cell.
    pub fn tops(&self) -> &[i32] {
        let Some(Bent { drops, tops }) = &self.bent else { return &self.tops };
        // Made outside of the lock, as tiles are.
        match tops.get() {
            Some(tops) => tops,
            None => {
                let lowered = drops.lowered_all(HeightsOf::Cells(&self.tops));
                tops.get_or_init(|| lowered)
            }
        }
    }

    /// Returns all tops as they are over a flat earth, and by how much each is seen lower.
    pub(crate) fn seen_tops(&self) -> SeenHeights<'_> {
        SeenHeights { heights: HeightsOf::Cells(self.flat_tops()), n_cols: self.n_cols, drops: self.drops() }
    }

    /// Returns all tops as they are over a flat earth.
    pub(crate) fn flat_tops(&self) -> &[i32] {
        &self.tops
    }

    /// Returns the drops of tops over a curved earth.
    pub(crate) fn drops(&self) -> Option<&Drops> {
        self.bent.as_ref().map(|bent| &*bent.drops)
    }

    /// Returns the highest tops of tiles of cells; of a raster of plateaus found when it is first
    /// asked for.
    pub fn tiles(&self) -> &TileMaxima {
        // Made outside of the lock: a thread that waits for parts of the work may take up another
        // task, which wants the tiles.
        match self.tiles.get() {
            Some(tiles) => tiles,
            None => {
                let tiles = TileMaxima::of(self.tops(), self.n_cols);
                self.tiles.get_or_init(|| tiles)
            }
        }
    }

    /// Returns the highest tops of tiles of 8 × 8 tiles; found when they are first asked for.
    pub fn tiles_of_tiles(&self) -> &TileMaxima {
        let tiles = self.tiles();
        match self.tiles_of_tiles.get() {
            Some(larger) => larger,
            None => {
                let larger = TileMaxima::of(tiles.maxima(), tiles.per_row());
                self.tiles_of_tiles.get_or_init(|| larger)
            }
        }
    }

    /// Returns the raster as few rectangles of one height, where it is that.
    pub fn plateaus(&self) -> Option<&Plateaus> {
        self.plateaus.as_ref()
    }

    /// Returns the highest top, [`VOID`] if all cells are void.
    pub fn max_top(&self) -> i32 {
        self.extremes.1
    }

    /// Returns the lowest top, [`VOID`] if any cell is void.
    pub(crate) fn min_top(&self) -> i32 {
        self.extremes.0
    }

    /// Returns the lowest top of cells with a known height, if there are any.
    pub(crate) fn lowest_known(&self) -> Option<i32> {
        let known = |z: &i32| *z != VOID && *z != BLOCKS_ALL;
        *self.lowest_known.get_or_init(|| match self.min_top() {
            VOID => self.tops().iter().copied().filter(known).min(),
            low => Some(low).filter(known),
        })
    }

    /// Returns the top of the cell `east` cells from the west and `north` cells from the south
    /// edge; [`VOID`] outside.
    #[inline]
    pub fn top(&self, east: i64, north: i64) -> i32 {
        self.index(east, north).map_or(VOID, |i| self.top_at(i))
    }

    /// Returns the index into [`Columns::tops`], `None` outside.
    #[inline]
    pub fn index(&self, east: i64, north: i64) -> Option<usize> {
        let col = usize::try_from(east).ok().filter(|&c| c < self.n_cols)?;
        let from_south = usize::try_from(north).ok().filter(|&r| r < self.n_rows)?;
        Some((self.n_rows - 1 - from_south) * self.n_cols + col)
    }

    /// Returns the index of the cell that holds lattice position `(x, y)`, the one to its
    /// north-east on an edge.
    pub fn cell_at(&self, x: i64, y: i64) -> Option<usize> {
        let [width, height] = self.steps;
        self.index(x.div_euclid(width), y.div_euclid(height))
    }

    /// Returns the lattice position of the center of a cell.
    #[inline]
    pub fn center(&self, row: usize, col: usize) -> (i64, i64) {
        #[expect(clippy::cast_possible_wrap, reason = "a raster in memory has far fewer than 2^63 cells")]
        let (east, north) = (col as i64, (self.n_rows - 1 - row) as i64);
        let [width, height] = self.steps;
        (east * width + width / 2, north * height + height / 2)
    }

    /// Returns the height below which the vertical line at `(x, y)` is inside the solid.
    ///
    /// That is the lowest of the columns whose closed squares contain the point; [`VOID`] where one
    /// of them is void or outside.
    pub fn solid_below(&self, x: i64, y: i64) -> i32 {
        // On an edge or a corner the point is interior only to what all the touching cells have in
        // common.
        let touching =
            |v: i64, cell: i64| (v.div_euclid(cell) - i64::from(v.rem_euclid(cell) == 0), v.div_euclid(cell));
        let ((west, east), (south, north)) = (touching(x, self.steps[0]), touching(y, self.steps[1]));
        let lowest = [(west, south), (west, north), (east, south), (east, north)].map(|(e, n)| self.top(e, n));
        lowest.into_iter().min().unwrap_or(VOID)
    }
}
