//! A raster as few rectangles of equal height, where it is that: block models of cities on a grid
//! along their walls.

use std::cmp::Reverse;
use std::sync::OnceLock;

use super::Prisms;
use crate::quantity::{BLOCKS_ALL, STEPS_PER_UNIT, VOID};
use crate::raster::{CELLS_PER_RUN, LargeVec, RowRuns};

/// Fewest cells of a raster for which plateaus are looked for: in smaller ones nothing takes long.
const FEWEST_CELLS: usize = 1 << 18;

/// Fewest cells to a plateau, on average: with more plateaus the sweep is faster.
const CELLS_PER_PLATEAU: usize = 256;

/// Fewest cells to a cell along the sides of plateaus apart.
const CELLS_PER_SIDE: usize = 12;

/// Most cells along a side of a raster: those of the box of a UAV and the cells in its range.
const LARGEST_SIDE: usize = 1 << 16;

/// A rectangle of cells of one height.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Plateau {
    /// First row from the north, and the one after the last.
    pub rows: (u32, u32),
    /// First column, and the one after the last.
    pub cols: (u32, u32),
    /// Top \[1/1024 m above the datum\].
    pub top: i32,
}

/// All cells of a raster that are not void, as plateaus.
#[derive(Debug, Clone)]
pub struct Plateaus {
    n_rows: usize,
    /// Plateaus above the lowest, by their first row.
    raised: Vec<Plateau>,
    /// Plateaus of another height than most cells, by their first row.
    apart: Vec<Plateau>,
    ground: i32,
    lowest: i32,
    highest: i32,
    has_void: bool,
    prisms: OnceLock<Prisms>,
}

impl Plateaus {
    /// Returns the plateaus of a raster by its tops \[1/1024 m above the datum\], however many they
    /// are.
    ///
    /// `None` if it has a cell that blocks everything, or no height at all.
    ///
    /// Cost: a comparison of each row with the one before, and of the cells of rows that differ
    /// with their neighbors.
    pub fn of(tops: &[i32], n_cols: usize) -> Option<Self> {
        Plateaus::of_runs(&RowRuns::of(tops, n_cols, 0)?, usize::MAX)
    }

    /// Returns the plateaus of a raster where they save time: `None` as well if it is small, or has
    /// more than one plateau to 256 cells.
    pub(super) fn if_few(tops: &LargeVec<i32>, n_cols: usize) -> Option<Self> {
        if tops.len() < FEWEST_CELLS {
            return None;
        }
        let most = tops.len() / CELLS_PER_PLATEAU;
        match tops.runs() {
            Some(runs) => Plateaus::of_runs(runs, most),
            None => Plateaus::of_runs(&RowRuns::of(tops, n_cols, CELLS_PER_RUN)?, most),
        }
    }

    fn of_runs(runs: &RowRuns<i32>, most: usize) -> Option<Self> {
        if runs.n_rows().max(runs.n_cols()) > LARGEST_SIDE {
            return None;
        }
        let mut plateaus = joined(runs);
        let has_void = plateaus.iter().any(|plateau| plateau.top == VOID);
        let known = || plateaus.iter().map(|p| p.top).filter(|top| *top != VOID);
        let (lowest, highest) = (known().min()?, known().max()?);
        if plateaus.len() > most || highest == BLOCKS_ALL {
            return None;
        }
        plateaus.retain(|plateau| plateau.top != VOID);
        let ground = most_frequent(&mut plateaus)?;
        plateaus.sort_unstable_by_key(|plateau| (plateau.rows, plateau.cols));
        let of = |is_wanted: &dyn Fn(i32) -> bool| -> Vec<Plateau> {
            plateaus.iter().copied().filter(|plateau| is_wanted(plateau.top)).collect()
        };
        let (raised, apart) = (of(&|top| top > lowest), of(&|top| top != ground));
        // PERF: receivers on each of these are decided by all that is in sight of its sides.
        let sides = apart.iter().map(Plateau::half_girth).sum::<usize>();
        if most < usize::MAX && sides * CELLS_PER_SIDE > runs.n_rows() * runs.n_cols() {
            return None;
        }
        let n_rows = runs.n_rows();
        Some(Plateaus { n_rows, raised, apart, ground, lowest, highest, has_void, prisms: OnceLock::new() })
    }

    /// Returns the plateaus above the lowest height, by their first row.
    pub fn raised(&self) -> &[Plateau] {
        &self.raised
    }

    /// Returns the plateaus of another height than most cells, by their first row.
    pub fn apart(&self) -> &[Plateau] {
        &self.apart
    }

    /// Returns the top of all cells that are not void but those of [`Plateaus::apart`] \[1/1024 m
    /// above the datum\].
    pub fn ground(&self) -> i32 {
        self.ground
    }

    /// Returns the top of all cells that are not void but those of [`Plateaus::raised`] \[1/1024 m
    /// above the datum\].
    pub fn lowest(&self) -> i32 {
        self.lowest
    }

    /// Returns the lowest and the highest top of all cells; [`VOID`] is the lowest if any is void.
    pub(super) fn extremes(&self) -> (i32, i32) {
        (if self.has_void { VOID } else { self.lowest }, self.highest)
    }

    /// Returns the plateaus above the lowest height as prisms on the lattice of the columns; pieces
    /// are in the order of [`Plateaus::raised`].
    ///
    /// Their union is that of the columns above the lowest height. So of two points that are not
    /// below that, both block the same rays, but for the cells that are exempt for a receiver
    /// inside of them.
    pub fn prisms(&self) -> &Prisms {
        // Made outside of the lock: a thread that waits for parts of the work may take up another
        // task, which wants the prisms.
        match self.prisms.get() {
            Some(prisms) => prisms,
            None => {
                let prisms = self.prisms_of(|_| true);
                self.prisms.get_or_init(|| prisms)
            }
        }
    }

    /// Returns some of the plateaus above the lowest height as prisms: those that `keep` holds for,
    /// which is asked in their order.
    pub fn prisms_of(&self, mut keep: impl FnMut(&Plateau) -> bool) -> Prisms {
        let kept = self.raised.iter().filter(|plateau| keep(plateau));
        Prisms::new(kept.zip(0..).map(|(plateau, k)| (self.ring(plateau), plateau.top, k)))
    }

    /// Returns the corners of a plateau on the lattice, counterclockwise from the south-west.
    pub fn ring(&self, plateau: &Plateau) -> [[i32; 2]; 4] {
        let on_lattice = |cell: usize| i32::try_from(cell).unwrap_or(i32::MAX / STEPS_PER_UNIT) * STEPS_PER_UNIT;
        let [west, east] = [plateau.cols.0, plateau.cols.1].map(|col| on_lattice(col as usize));
        let [north, south] = [plateau.rows.0, plateau.rows.1].map(|row| on_lattice(self.n_rows - row as usize));
        [[west, south], [east, south], [east, north], [west, north]]
    }
}

impl Plateau {
    /// Returns cells along two neighboring sides.
    fn half_girth(&self) -> usize {
        (self.rows.1 - self.rows.0) as usize + (self.cols.1 - self.cols.0) as usize
    }

    fn n_cells(&self) -> u64 {
        u64::from(self.rows.1 - self.rows.0) * u64::from(self.cols.1 - self.cols.0)
    }
}

/// Returns the height of the most cells, the lowest of equal ones; puts the plateaus in the order
/// of their heights.
fn most_frequent(plateaus: &mut [Plateau]) -> Option<i32> {
    plateaus.sort_unstable_by_key(|plateau| plateau.top);
    let cells = |same: &[Plateau]| same.iter().map(Plateau::n_cells).sum::<u64>();
    let heights = plateaus.chunk_by(|a, b| a.top == b.top).map(|same| (cells(same), Reverse(same[0].top)));
    heights.max().map(|(_, Reverse(top))| top)
}

/// Runs of equal ends and value in rows one below the other, as rectangles.
fn joined(runs: &RowRuns<i32>) -> Vec<Plateau> {
    let narrow = |row: usize| u32::try_from(row).unwrap_or(u32::MAX);
    let mut done = Vec::new();
    let mut open: Vec<Plateau> = Vec::new();
    let mut next: Vec<Plateau> = Vec::new();
    for group in runs.groups() {
        let rows = (narrow(group.rows.start), narrow(group.rows.end));
        let mut above = open.drain(..).peekable();
        let mut first = 0;
        for (end, value) in group.ends.iter().zip(group.values) {
            // Both lists run from west to east without gaps.
            while let Some(ended) = above.next_if(|plateau| plateau.cols.0 < first) {
                done.push(ended);
            }
            let cols = (first, *end);
            let from = match above.next_if(|plateau| plateau.cols == cols && plateau.top == *value) {
                Some(plateau) => plateau.rows.0,
                None => rows.0,
            };
            next.push(Plateau { rows: (from, rows.1), cols, top: *value });
            first = *end;
        }
        done.extend(above);
        std::mem::swap(&mut open, &mut next);
    }
    done.extend(open);
    done
}
