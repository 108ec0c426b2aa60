//! A raster as few rectangles of equal height, where it is that: block models of cities on a grid along their walls.

use std::sync::OnceLock;

use super::Prisms;
use crate::quantity::{BLOCKS_ALL, STEPS_PER_UNIT, VOID};
use crate::raster::{LargeVec, RowRuns};

/// Fewest cells of a raster for which plateaus are looked for: in smaller ones nothing takes long.
const FEWEST_CELLS: usize = 1 << 18;

/// Fewest cells to a plateau, on average: with more plateaus the sweep is faster.
const CELLS_PER_PLATEAU: usize = 256;

/// Fewest cells to a run of equal ones in rows that differ from the row before, in any part of a raster: a bound on what is kept
/// of rasters that are none of plateaus.
const CELLS_PER_RUN: usize = 64;

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
    /// Those above the lowest, by their first row.
    raised: Vec<Plateau>,
    lowest: i32,
    highest: i32,
    has_void: bool,
    prisms: OnceLock<Prisms>,
}

impl PartialEq for Plateaus {
    fn eq(&self, other: &Self) -> bool {
        let facts = |p: &Plateaus| (p.n_rows, p.lowest, p.highest, p.has_void);
        facts(self) == facts(other) && self.raised == other.raised
    }
}

impl Eq for Plateaus {}

impl Plateaus {
    /// The plateaus of a raster by its tops \[1/1024 m above the datum\], however many they are; `None` if it has a cell that
    /// blocks everything, or no height at all.
    ///
    /// Cost: a comparison of each row with the one before, and of the cells of rows that differ with their neighbors.
    pub fn of(tops: &[i32], n_cols: usize) -> Option<Self> {
        Plateaus::of_runs(&RowRuns::of(tops, n_cols, 0)?, usize::MAX)
    }

    /// The same where it saves time: `None` as well if the raster is small, or has more than one plateau to 256 cells.
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
        let plateaus = joined(runs);
        let has_void = plateaus.iter().any(|plateau| plateau.top == VOID);
        let known = || plateaus.iter().map(|p| p.top).filter(|top| *top != VOID);
        let (lowest, highest) = (known().min()?, known().max()?);
        if plateaus.len() > most || highest == BLOCKS_ALL {
            return None;
        }
        let mut raised: Vec<Plateau> =
            plateaus.into_iter().filter(|plateau| plateau.top != VOID && plateau.top > lowest).collect();
        raised.sort_unstable_by_key(|plateau| (plateau.rows, plateau.cols));
        Some(Plateaus { n_rows: runs.n_rows(), raised, lowest, highest, has_void, prisms: OnceLock::new() })
    }

    /// The plateaus above the lowest height, by their first row.
    pub fn raised(&self) -> &[Plateau] {
        &self.raised
    }

    /// Top of all other cells that are not void \[1/1024 m above the datum\].
    pub fn lowest(&self) -> i32 {
        self.lowest
    }

    /// The lowest and the highest top of all cells; [`VOID`] is the lowest if any is void.
    pub(super) fn extremes(&self) -> (i32, i32) {
        (if self.has_void { VOID } else { self.lowest }, self.highest)
    }

    /// The plateaus above the lowest height as prisms on the lattice of the columns; pieces are in the order of
    /// [`Plateaus::raised`].
    ///
    /// Their union is that of the columns above the lowest height, so a ray between two points that are not below that is
    /// blocked by the one if and only if it is by the other, but for the cells that are exempt for a receiver inside of
    /// them.
    pub fn prisms(&self) -> &Prisms {
        self.prisms.get_or_init(|| {
            let on_lattice = |cell: usize| i32::try_from(cell).unwrap_or(i32::MAX) * STEPS_PER_UNIT;
            let rings = self.raised.iter().zip(0..).map(|(plateau, k)| {
                let [west, east] = [plateau.cols.0, plateau.cols.1].map(|col| on_lattice(col as usize));
                let [north, south] = [plateau.rows.0, plateau.rows.1].map(|r| on_lattice(self.n_rows - r as usize));
                ([[west, south], [east, south], [east, north], [west, north]], plateau.top, k)
            });
            Prisms::of_rings(rings)
        })
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows, columns and top of a rectangle.
    type Rectangle = ((usize, usize), (usize, usize), i32);

    /// A raster of 512 × 600 cells at height 7 with rectangles on it, later ones over earlier.
    fn raster(rectangles: &[Rectangle]) -> Vec<i32> {
        let mut tops = vec![7; 512 * 600];
        for ((first, end), (west, east), top) in rectangles {
            for row in *first..*end {
                tops[row * 600 + west..row * 600 + east].fill(*top);
            }
        }
        tops
    }

    #[test]
    fn rectangles_are_found_again_and_cover_every_cell_once() {
        let blocks = [
            ((0, 20), (0, 30), 50),
            ((10, 40), (100, 130), 60),
            ((30, 60), (130, 150), 60),
            ((200, 512), (590, 600), 9),
            ((300, 310), (300, 310), VOID),
            ((400, 420), (10, 20), 8),
            ((405, 410), (12, 15), 30),
        ];
        let tops = raster(&blocks);
        let found = Plateaus::if_few(&tops.clone().into(), 600).expect("few plateaus");
        assert_eq!(found.lowest(), 7);
        let mut cells = vec![7; tops.len()];
        for plateau in found.raised() {
            for row in plateau.rows.0..plateau.rows.1 {
                for col in plateau.cols.0..plateau.cols.1 {
                    let cell = &mut cells[row as usize * 600 + col as usize];
                    assert_eq!(*cell, 7, "covered once");
                    *cell = plateau.top;
                }
            }
        }
        let expected: Vec<i32> = tops.iter().map(|top| if *top == VOID { 7 } else { *top }).collect();
        assert!(cells == expected);
        // Where neighbors of equal height begin or end in different rows, they are cut there.
        assert_eq!(found.raised().len(), 10);
        assert_eq!(found.prisms().pieces().len(), 10);
        assert_eq!(found.prisms().solid_below(5 * 1024, 510 * 1024), 50);
        assert_eq!(found.prisms().solid_below(5 * 1024, 491 * 1024), VOID);
    }

    #[test]
    fn small_noisy_or_blocking_rasters_have_none() {
        assert!(Plateaus::if_few(&raster(&[]).into(), 600).is_some());
        assert!(Plateaus::if_few(&vec![7; 1000].into(), 100).is_none());
        assert!(Plateaus::of(&[7; 1000], 100).is_some());
        assert!(Plateaus::of(&raster(&[((3, 4), (5, 6), BLOCKS_ALL)]), 600).is_none());
        let noise: Vec<i32> = (0..512 * 600).map(|k: i32| k % 53).collect();
        assert!(Plateaus::if_few(&noise.into(), 600).is_none());
        assert!(Plateaus::of(&vec![VOID; 512 * 600], 600).is_none());
    }
}
