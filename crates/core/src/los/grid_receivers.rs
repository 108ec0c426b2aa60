//! Receivers on the cells of a grid, and their heights.

use std::borrow::Cow;
use std::sync::{Arc, OnceLock};

use rayon::prelude::*;

use crate::height_field::{Columns, Drops, HeightsOf, Plateau, Plateaus, SeenHeights, StandsOn, TileMaxima};
use crate::raster::{BitGrid, CellWindow, bits_between, set_bits};

/// Receivers of one kind on the cells of a grid, ready for many UAVs.
#[derive(Debug, Clone)]
pub struct GridReceivers<'a> {
    /// The cells that hold a receiver.
    pub cells: Cow<'a, BitGrid>,
    /// The base that receivers stand on, over a flat earth.
    stands_on: StandsOn<'a>,
    /// The drop of the base over a curved earth.
    drops: Option<Arc<Drops>>,
    /// Height of receivers above their base \[1/1024 m\].
    pub(super) above: i32,
    /// Bounds on the heights of the base.
    pub(super) range: (i32, i32),
    /// The highest base by tile, once an engine has needed it. Copies share it.
    tiles: Arc<OnceLock<TileMaxima>>,
}

impl<'a> GridReceivers<'a> {
    /// Makes receivers on some cells, `above` \[1/1024 m\] over what they stand on.
    pub fn new(cells: impl Into<Cow<'a, BitGrid>>, stands_on: StandsOn<'a>, above: i32) -> Self {
        let cells = cells.into();
        let range = match &stands_on {
            StandsOn::Flat(z) => (*z, *z),
            StandsOn::Tops(columns) => (columns.min_top(), columns.max_top()),
            StandsOn::Cells(heights) => {
                let n_cols = cells.n_cols();
                let of_row = |row: usize| {
                    let heights = &heights[row * n_cols..(row + 1) * n_cols];
                    cells.row(row).iter().zip(heights.chunks(64)).fold(NO_RANGE, |range, (word, heights)| {
                        // Most words are full or empty.
                        widest(
                            range,
                            match *word {
                                0 => NO_RANGE,
                                u64::MAX => heights.iter().fold(NO_RANGE, |r, z| widest(r, (*z, *z))),
                                word => {
                                    set_bits(&[word]).fold(NO_RANGE, |r, bit| widest(r, (heights[bit], heights[bit])))
                                }
                            },
                        )
                    })
                };
                let (low, high) = (0..cells.n_rows()).into_par_iter().map(of_row).reduce(|| NO_RANGE, widest);
                if low > high { (0, 0) } else { (low, high) }
            }
        };
        GridReceivers { cells, stands_on, drops: None, above, range, tiles: Arc::default() }
    }

    /// Returns these receivers without cached results.
    pub(crate) fn borrowed(&self) -> GridReceivers<'_> {
        let stands_on = match &self.stands_on {
            StandsOn::Flat(z) => StandsOn::Flat(*z),
            StandsOn::Cells(heights) => StandsOn::Cells(Cow::Borrowed(heights)),
            StandsOn::Tops(columns) => StandsOn::Tops(columns),
        };
        let GridReceivers { above, range, .. } = *self;
        let (cells, drops, tiles) = (Cow::Borrowed(&*self.cells), self.drops.clone(), Arc::clone(&self.tiles));
        GridReceivers { cells, stands_on, drops, above, range, tiles }
    }

    /// Returns these receivers raised \[1/1024 m\] over the same base.
    pub(crate) fn raised(&self, by: i32) -> GridReceivers<'_> {
        GridReceivers { above: self.above + by, ..self.borrowed() }
    }

    /// Returns receivers on the same cells, on a height for each \[1/1024 m above the datum\].
    pub(crate) fn on<'b>(&'b self, heights: &'b [i32]) -> GridReceivers<'b> {
        GridReceivers::new(&*self.cells, StandsOn::Cells(Cow::Borrowed(heights)), self.above)
    }

    /// Returns receivers on the same cells, relative to a terrain as a UAV sees it.
    pub(super) fn seen_on_columns(&self, drops: &Drops) -> GridReceivers<'static> {
        let (n_rows, n_cols) = (self.cells.n_rows(), self.cells.n_cols());
        let mut bases = vec![0; n_rows * n_cols];
        bases.par_chunks_mut(n_cols.max(1)).enumerate().for_each(|(row, bases)| {
            for col in set_bits(self.cells.row(row)) {
                bases[col] = self.base(row * n_cols + col) - drops.at(row, col);
            }
        });
        GridReceivers::new((*self.cells).clone(), StandsOn::Cells(Cow::Owned(bases)), self.above)
    }

    /// Returns these receivers over heights that drops have lowered within a window.
    pub(crate) fn lowered(self, drops: &Arc<Drops>, window: CellWindow) -> Self {
        let most = i32::try_from(drops.most(window)).unwrap_or(i32::MAX);
        let range = (self.range.0.saturating_sub(most), self.range.1);
        let tiles = OnceLock::from(match &self.stands_on {
            StandsOn::Flat(z) => drops.of_tiles(&TileMaxima::of_one(*z, (self.cells.n_rows(), self.cells.n_cols()))),
            StandsOn::Tops(columns) => drops.of_tiles(columns.tiles()),
            StandsOn::Cells(_) => drops.of_tiles(self.tiles()),
        });
        GridReceivers { drops: Some(Arc::clone(drops)), range, tiles: Arc::new(tiles), ..self }
    }

    /// Returns the base height of the receiver of a cell \[1/1024 m above the datum\].
    #[inline]
    pub fn base(&self, cell: usize) -> i32 {
        let (base, n_cols) = (self.stands_on.at(cell), self.cells.n_cols());
        self.drops.as_ref().map_or(base, |drops| drops.lowered(base, (cell / n_cols, cell % n_cols)))
    }

    /// Copies base heights of cells of one row, from cell `first` on.
    pub(crate) fn copy_bases(&self, first: usize, out: &mut [i32]) {
        match &self.stands_on {
            StandsOn::Flat(z) => out.fill(*z),
            StandsOn::Cells(heights) => out.copy_from_slice(&heights[first..first + out.len()]),
            StandsOn::Tops(columns) => columns.copy_tops(first, out),
        }
        if let Some(drops) = &self.drops {
            let n_cols = self.cells.n_cols();
            drops.lower_row((first / n_cols, first % n_cols), out);
        }
    }

    /// Returns `true` if receivers stand on the tops of these very columns.
    pub(super) fn is_on_tops_of(&self, columns: &Columns) -> bool {
        match &self.stands_on {
            _ if self.drops.is_some() => false,
            StandsOn::Flat(_) => false,
            // Heights that are not in memory are not compared.
            StandsOn::Cells(heights) => columns.tops_in_memory().is_some_and(|tops| std::ptr::eq(tops, &**heights)),
            StandsOn::Tops(on) => std::ptr::eq(*on, columns),
        }
    }

    /// Returns `true` if no receiver, at height `z`, is below the lowest plateau or inside a higher
    /// one. Then no receiver's own cell matters to UAVs at height `uav_z` that are not below them.
    pub(super) fn stand_beside(&self, plateaus: &Plateaus, z: i64, uav_z: i64) -> bool {
        let holds_receiver = |plateau: &Plateau| {
            let (first, end) = (plateau.cols.0 as usize, plateau.cols.1 as usize);
            (plateau.rows.0..plateau.rows.1).any(|row| {
                let words = self.cells.row(row as usize);
                (first / 64..end.div_ceil(64)).any(|word| words[word] & bits_between(first, end, word) != 0)
            })
        };
        (i64::from(plateaus.lowest())..=uav_z).contains(&z)
            && !plateaus.raised().iter().any(|plateau| i64::from(plateau.top) > z && holds_receiver(plateau))
    }

    /// Returns the base heights, cell by cell.
    pub fn bases(&self) -> SeenHeights<'_> {
        let heights = match &self.stands_on {
            StandsOn::Flat(z) => HeightsOf::One(*z),
            StandsOn::Cells(heights) => HeightsOf::Cells(heights),
            // Lowered receivers stand on the tops of a flat earth.
            StandsOn::Tops(columns) => HeightsOf::Cells(columns.tops()),
        };
        SeenHeights { heights, n_cols: self.cells.n_cols(), drops: self.drops.as_deref() }
    }

    /// Returns the highest base of all cells by tile, computed on first use.
    pub(super) fn tiles(&self) -> &TileMaxima {
        // Made outside of the lock: a thread that waits for parts of the work may take up another
        // task that needs the tiles.
        match self.tiles.get() {
            Some(tiles) => tiles,
            None => {
                let tiles = self.bases().tiles();
                self.tiles.get_or_init(|| tiles)
            }
        }
    }

    /// Returns bounds on the base heights, and the receivers' height above their base \[1/1024 m\].
    pub fn range(&self) -> ((i32, i32), i32) {
        (self.range, self.above)
    }

    /// Returns `true` if the receivers stand on ground of one height that is known as such.
    pub(crate) fn are_on_flat_ground(&self) -> bool {
        matches!(self.stands_on, StandsOn::Flat(_)) && self.drops.is_none()
    }

    /// Returns bounds on the heights of the receivers \[1/1024 m above the datum\].
    pub fn heights_range(&self) -> (i64, i64) {
        let above = i64::from(self.above);
        (i64::from(self.range.0) + above, i64::from(self.range.1) + above)
    }

    /// Returns the height of the receiver of a cell \[1/1024 m above the datum\].
    #[inline]
    pub fn height(&self, cell: usize) -> i64 {
        i64::from(self.base(cell)) + i64::from(self.above)
    }

    /// Returns heights of receivers by row and column \[1/1024 m above the datum\].
    pub(super) fn heights(&self) -> impl Fn(usize, usize) -> i64 + Sync + '_ {
        let n_cols = self.cells.n_cols();
        move |row, col| self.height(row * n_cols + col)
    }

    /// Returns the lower bound of the receivers' heights; `None` without receivers.
    pub fn lowest(&self) -> Option<i64> {
        self.cells.words().iter().any(|w| *w != 0).then(|| i64::from(self.range.0) + i64::from(self.above))
    }

    /// Returns the common height over a flat earth of receivers that are known to stand on ground
    /// of one height.
    pub(super) fn level_over_flat_earth(&self) -> Option<i64> {
        match self.stands_on {
            StandsOn::Flat(z) => Some(i64::from(z) + i64::from(self.above)),
            _ => None,
        }
    }

    /// Returns the common height of all receivers, if they have one.
    pub fn level(&self) -> Option<i64> {
        (self.range.0 == self.range.1).then(|| i64::from(self.range.0) + i64::from(self.above))
    }
}

const NO_RANGE: (i32, i32) = (i32::MAX, i32::MIN);

fn widest(a: (i32, i32), b: (i32, i32)) -> (i32, i32) {
    (a.0.min(b.0), a.1.max(b.1))
}
