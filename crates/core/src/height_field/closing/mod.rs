//! The closing of footprints by an open disc, decided point by point.
//!
//! Let F be the union of all footprints and R the radius. A point is outside of the closing iff a
//! disc with its center at most R away avoids F. The centers of all such discs are the set E = {c :
//! the distance from c to F is at least R}. So a point is outside iff its distance to E is less
//! than R.
//!
//! ```text
//!          ___________
//!    E    /    R     /   The border of E is made of arcs around corners of footprints and of sides beside their edges.
//!        |   +----+  |   The point of E nearest to a point outside of it is on an arc, straight through the corner; on a side,
//!        |   |  F |  |   straight away from the edge; or a corner, where two arcs or sides meet.
//! ```
//!
//! 1. Square cells bound E from inside and from outside. They decide whole cells of the closing,
//!    all but a band along its border.
//! 2. Arcs, sides and corners of E are found near the border alone ([`Rim`]). They decide points of
//!    the band.
//! 3. The outside falls into parts, and only those that reach around all footprints stay outside.
//!    Two discs of one part overlap, or are joined by others. Cells that are outside as a whole
//!    join parts, the disc that shows that a point is outside, and corners less than 2 R apart.
//!    Where two parts of E come near each other, no arc or side is nearer than corners.
//!
//! Positions are on the lattice; centers of discs are in doubles. A disc that meets a footprint by
//! less than [`TIE`] touches it.

mod cells;
mod finder;
mod free;
mod grid;
mod rim;
mod shell;
mod vectors;

use rayon::prelude::*;

use self::cells::{Cells, grown, less_than};
use self::rim::Rim;
use self::shell::Shell;
use self::vectors::{Place, length, minus};
use crate::city::Footprint;
use crate::disjoint_sets::DisjointSets;
use crate::outlines::{covered_shares, overlapped_cells};
use crate::raster::BitGrid;

/// Two lengths that differ by less are one \[lattice steps\]. A position in doubles is known to
/// within a thousandth of this.
const TIE: f64 = 1.0 / 65_536.0;
/// Diagonal of a square of side 1, rounded up, and half of it.
const DIAGONAL: f64 = 1.415;
const HALF_DIAGONAL: f64 = 0.7075;

/// The closing of some footprints.
#[derive(Debug, Clone)]
pub(super) struct Closing {
    cells: Cells,
    /// Cells that the closing holds as a whole, holes filled.
    inside: BitGrid,
    /// Cells whose border with the closing is undecided.
    band: BitGrid,
    /// Cells whose centers are outside, in the part around all footprints.
    open: BitGrid,
    rim: Rim,
    /// Share of its area that no footprint covers, as cells tell it.
    open_share: f64,
}

impl Closing {
    /// Returns the closing by discs of a radius, found on cells of a side \[lattice steps\], at
    /// most a quarter of the radius; `None` without footprints.
    ///
    /// Cost: five passes over the cells, then a walk around each corner and along each edge near
    /// the border.
    pub(super) fn of(footprints: &[Footprint], radius: i64, side: i64) -> Option<Self> {
        let points = || footprints.iter().flat_map(|f| f.polygons.iter().flatten().flatten());
        let range = |k: usize| {
            let values = || points().map(|p| i64::from(p[k]));
            Some((values().min()?, values().max()?))
        };
        let ((west, east), (south, north)) = (range(0)?, range(1)?);
        let margin = radius + 3 * side;
        // Cells begin at a multiple of their side, wherever the footprints are.
        let first = |v: i64| (v - margin).div_euclid(side) * side;
        let corner = [first(west), first(south)];
        let count = |from: i64, to: i64| usize::try_from((to + margin - from) / side + 1).ok();
        let (n_cols, n_rows) = (count(corner[0], east)?, count(corner[1], north)?);
        let cells = Cells { corner, side, n_rows, n_cols };
        let (built, built_area) = built_cells(footprints, &cells);

        #[expect(clippy::cast_precision_loss, reason = "both are below 2^26")]
        let (r, reach) = (radius as f64, radius as f64 / side as f64);
        // A built cell has a point of a footprint at most half a diagonal from its center, and no
        // footprint is elsewhere.
        let may_be_center = grown(&built, less_than(reach - DIAGONAL)).complement();
        let is_center = grown(&built, less_than(reach + HALF_DIAGONAL)).complement();
        let may_be_outside = grown(&may_be_center, less_than(reach + DIAGONAL));
        let outside = grown(&is_center, less_than(reach - HALF_DIAGONAL));
        let band = may_be_outside.clone().and(&outside.complement());
        let shell = Shell::of(footprints, &cells, &may_be_outside, r);
        let rim = Rim::of(&shell, &cells, &may_be_center);
        let open = open_cells(&cells, &outside, &band, &rim);
        let inside = band.clone().or(&open).complement();
        let mut closing = Closing { cells, inside, band, open, rim, open_share: 0.0 };
        let is_held = |cell: &(usize, usize)| closing.holds(cells.center(*cell), *cell);
        #[expect(clippy::cast_precision_loss, reason = "fewer cells than 2^50")]
        let area = (closing.inside.count() + closing.band.cells().filter(is_held).count() as u64) as f64;
        closing.open_share = (1.0 - built_area / area.max(1.0)).max(0.0);
        Some(closing)
    }

    /// Returns whether the closing, or a hole of it, holds a position of the lattice.
    pub(super) fn contains(&self, position: [i64; 2]) -> bool {
        let place = self.cells.place(position);
        self.cells.at(place).is_some_and(|cell| self.holds(place, cell))
    }

    /// Returns the share of its area that no footprint covers, as cells tell it.
    pub(super) fn open_share(&self) -> f64 {
        self.open_share
    }

    /// Returns whether the closing, or a hole of it, holds a place of a cell.
    fn holds(&self, place: Place, (row, col): (usize, usize)) -> bool {
        if !self.band.contains(row, col) {
            return self.inside.contains(row, col);
        }
        // The part that a point belongs to is that of the disc that shows it.
        self.rim.disc_over(place).is_none_or(|center| !self.cells.holds(&self.open, center))
    }
}

/// Returns the cells that footprints overlap, and how many cells these cover.
fn built_cells(footprints: &[Footprint], cells: &Cells) -> (BitGrid, f64) {
    let mut built = BitGrid::new(cells.n_rows, cells.n_cols);
    let mut shares = vec![0.0_f32; cells.n_rows * cells.n_cols];
    let moved = |p: &[i32; 2]| [i64::from(p[0]) - cells.corner[0], i64::from(p[1]) - cells.corner[1]];
    for footprint in footprints {
        let ring = |ring: &Vec<[i32; 2]>| ring.iter().map(moved).collect::<Vec<_>>();
        let polygons: Vec<Vec<Vec<[i64; 2]>>> =
            footprint.polygons.iter().map(|rings| rings.iter().map(ring).collect()).collect();
        overlapped_cells(&polygons, [cells.side; 2], (cells.n_rows, cells.n_cols), |row, cols| {
            cols.for_each(|col| built.insert(row, col));
        });
        covered_shares(&polygons, [cells.side; 2], (cells.n_rows, cells.n_cols), |row, col, share| {
            #[expect(clippy::cast_possible_truncation, reason = "a share")]
            let share = share as f32;
            shares[cells.index((row, col))] += share;
        });
    }
    (built, shares.into_iter().map(|share| f64::from(share.min(1.0))).sum())
}

/// Returns the cells whose centers are outside of the closing and not in a hole of it.
fn open_cells(cells: &Cells, outside: &BitGrid, band: &BitGrid, rim: &Rim) -> BitGrid {
    let mut parts = DisjointSets::new(cells.n_rows * cells.n_cols);
    let in_band: Vec<((usize, usize), Place)> = band
        .cells()
        .collect::<Vec<_>>()
        .into_par_iter()
        .filter_map(|cell| Some((cell, rim.disc_over(cells.center(cell))?)))
        .collect();
    let mut of_cell = outside.clone();
    in_band.iter().for_each(|((row, col), _)| of_cell.insert(*row, *col));
    // Whole cells that share a side.
    for (row, col) in outside.cells() {
        for next in [(row + 1, col), (row, col + 1)] {
            if next.0 < cells.n_rows && next.1 < cells.n_cols && outside.contains(next.0, next.1) {
                parts.join(cells.index((row, col)), cells.index(next));
            }
        }
    }
    let joined = |parts: &mut DisjointSets, cell: (usize, usize), place: Place| {
        if let Some(other) = cells.at(place).filter(|(row, col)| of_cell.contains(*row, *col)) {
            parts.join(cells.index(cell), cells.index(other));
        }
    };
    for (cell, center) in &in_band {
        // The disc that holds the middle of this cell also holds that of the cell in which its own
        // center is, and perhaps neighbors.
        joined(&mut parts, *cell, *center);
        for row in cell.0.saturating_sub(1)..(cell.0 + 2).min(cells.n_rows) {
            for col in cell.1.saturating_sub(1)..(cell.1 + 2).min(cells.n_cols) {
                let place = cells.center((row, col));
                if length(minus(place, *center)) < rim.radius {
                    joined(&mut parts, *cell, place);
                }
            }
        }
    }
    for (k, corner) in rim.corners.iter().enumerate() {
        let Some(cell) = cells.at(*corner) else { continue };
        // They are in order from the west.
        let near = rim.corners[k + 1..].iter().take_while(|other| other[0] - corner[0] < 2.0 * rim.radius);
        for other in near.filter(|other| length(minus(**other, *corner)) < 2.0 * rim.radius - TIE) {
            joined(&mut parts, cell, *other);
        }
    }
    let root = parts.root(0);
    let mut open = BitGrid::new(cells.n_rows, cells.n_cols);
    for (row, col) in of_cell.cells() {
        open.set(row, col, parts.root(cells.index((row, col))) == root);
    }
    open
}
