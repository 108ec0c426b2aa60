//! What each UAV of a lattice sees, counted receiver by receiver.
//!
//! Thousands of UAVs at one height over a grid of places are counted sooner the other way around: for each receiver the
//! UAVs that it sees, by the exact engine of [`Positions`], in tiles of receivers that see much the same. The counts are
//! those of [`Mapper::count`], one by one.

use std::sync::atomic::Ordering;

use rayon::prelude::*;

use super::lattice_sums::LatticeSums;
use super::range::Range;
use super::{Control, Mapper, Uav};
use crate::error::{Error, ErrorClass, Result};
use crate::height_field::Station;
use crate::los::{GridReceivers, InView, Positions, ReceiverTile, ShadowGrid};
use crate::quantity::LatticePoint;
use crate::raster::{BitGrid, GeoRef, set_bits};

/// Cells along the side of a tile of receivers, from the largest to the smallest tiles.
///
/// PERF: measured for 10 000 positions over Munich and an urban city on cells of 1 and 2 m; 8 or 32 cells in between, or 2 at
/// the end, cost more than they save.
const SIDES: [usize; 3] = [64, 16, 4];

/// UAVs at one height over places of a grid.
#[derive(Debug, Clone)]
pub struct UavLattice {
    grid: GeoRef,
    /// The places that have a UAV.
    places: BitGrid,
    shadows: ShadowGrid,
    /// \[1/1024 m above the datum\].
    z: i64,
}

/// What UAVs of a lattice count, place by place, 0 for those without a UAV.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LatticeCounts {
    /// Receivers in range, or their weight.
    pub wanted: Vec<u64>,
    /// Of these, in line of sight.
    pub seen: Vec<u64>,
}

impl Mapper<'_> {
    /// UAVs over the centers of cells of `grid`, each with the number of its cell, row by row; `None` without any, or if
    /// they are not all at one height where the grid puts them.
    pub fn lattice<'a>(&self, grid: &GeoRef, uavs: impl IntoIterator<Item = (usize, &'a Uav)>) -> Option<UavLattice> {
        let field = self.field();
        let n_cols = grid.n_cols();
        let station = |row: usize, col: usize| {
            let (x, y) = grid.world_from_cell(row, col);
            Station { place: field.place(x, y), z: 0 }
        };
        let xs: Vec<i64> = (0..n_cols).map(|col| station(0, col).on_prisms().x).collect();
        let ys: Vec<i64> = (0..grid.n_rows()).map(|row| station(row, 0).on_prisms().y).collect();
        let mut places = BitGrid::new(grid.n_rows(), n_cols);
        let words_per_row = places.words_per_row();
        let mut z = None;
        for (place, uav) in uavs {
            let (row, col) = (place / n_cols, place % n_cols);
            let at = uav.station.on_prisms();
            let is_there = uav.station.place == station(row, col).place && (at.x, at.y) == (xs[col], ys[row]);
            if !is_there || *z.get_or_insert(at.z) != at.z {
                return None;
            }
            places.words_mut()[row * words_per_row + col / 64] |= 1 << (col % 64);
        }
        Some(UavLattice { grid: grid.clone(), places, shadows: ShadowGrid::new(xs, ys), z: z? })
    }

    /// Whether [`Mapper::count_lattice`] can count these UAVs and should take less time than [`Mapper::count`] for each.
    pub fn is_counted_sooner(&self, lattice: &UavLattice) -> bool {
        let Some(positions) = self.engine().uav_positions(&lattice.shadows, lattice.z) else { return false };
        // PERF: µs of one thread, fitted to the itu cities and Munich on cells of 2 and 5 m with 500 to 40 000 UAVs; only their
        // ratio matters. Of 65 trials it takes the slower way in 6: three ties, and at most 1.9 times the time where UAVs are
        // so high (200 m) that counting them together takes half as long.
        #[expect(clippy::cast_precision_loss, reason = "an estimate")]
        let [casters, rows] = [positions.casters.all().len(), lattice.grid.n_rows()].map(|n| n as f64);
        #[expect(clippy::cast_precision_loss, reason = "an estimate")]
        let [uavs, receivers] =
            [lattice.places.count(), self.receivers().iter().map(|r| r.cells.count()).sum()].map(|n| n as f64);
        let (casters, rows) = self.radius().map_or((casters, rows), |radius| {
            let grid = self.field().grid();
            let area = (grid.x_max() - grid.x_min()) * (grid.y_max() - grid.y_min());
            let disc = std::f64::consts::PI * radius * radius;
            (casters * (disc / area).min(1.0), rows.min(2.0 * radius / lattice.grid.cell_height()))
        });
        let one_uav = 40.0 + 0.2 * casters;
        let of_range = if self.radius().is_some() { 2.0 } else { 1.0 };
        let one_receiver = (5.5 + 0.005 * casters) * (0.4 + 0.006 * rows) * of_range;
        receivers * one_receiver < uavs * one_uav
    }

    /// What each UAV of a lattice has in range and sees: for each receiver of a cell `weight(cell)`, cells row by row. Shared
    /// by all threads of the current pool; adds the number of UAVs to `control.done` bit by bit. `None` unless prisms alone
    /// decide.
    ///
    /// # Errors
    /// Only [`ErrorClass::Interrupted`], when `control.stop` was set.
    pub fn count_lattice(
        &self,
        lattice: &UavLattice,
        weight: &(dyn Fn(usize) -> u32 + Sync),
        control: &Control,
    ) -> Result<Option<LatticeCounts>> {
        let Some(positions) = self.engine().uav_positions(&lattice.shadows, lattice.z) else { return Ok(None) };
        let n_words = lattice.places.words().len();
        let whole = positions.anywhere(&lattice.places);
        let (n_rows, n_cols) = (self.field().grid().n_rows(), self.field().grid().n_cols());
        let tiles_per_row = n_cols.div_ceil(SIDES[0]);
        let n_tiles = n_rows.div_ceil(SIDES[0]) * tiles_per_row;
        let n_uavs = lattice.places.count();
        let mut counts = LatticeCounts { wanted: vec![0; n_words * 64], seen: vec![0; n_words * 64] };
        for receivers in self.receivers() {
            let of_kind = (0..n_tiles)
                .into_par_iter()
                .fold(
                    || Counting::new(self, lattice, (positions, receivers), weight),
                    |mut counting, tile| {
                        let at = (tile / tiles_per_row * SIDES[0], tile % tiles_per_row * SIDES[0]);
                        counting.tile(at, &SIDES, &counting.near(at, &whole), control);
                        counting
                    },
                )
                .map(|counting| counting.counts())
                .reduce_with(LatticeCounts::and);
            if let Some(of_kind) = of_kind {
                counts = counts.and(of_kind);
            }
        }
        if control.stop.load(Ordering::Relaxed) {
            return Err(Error::new(ErrorClass::Interrupted, 130, "interrupted; nothing was written"));
        }
        control.done.fetch_add(n_uavs, Ordering::Relaxed);
        Ok(Some(counts.of_places(lattice)))
    }
}

impl LatticeCounts {
    fn and(mut self, other: LatticeCounts) -> LatticeCounts {
        self.wanted.iter_mut().zip(&other.wanted).for_each(|(a, b)| *a += b);
        self.seen.iter_mut().zip(&other.seen).for_each(|(a, b)| *a += b);
        self
    }

    /// Without the bits beyond the last column.
    fn of_places(&self, lattice: &UavLattice) -> LatticeCounts {
        let width = lattice.places.words_per_row() * 64;
        let cut = |sums: &[u64]| sums.chunks(width).flat_map(|row| &row[..lattice.grid.n_cols()]).copied().collect();
        LatticeCounts { wanted: cut(&self.wanted), seen: cut(&self.seen) }
    }
}

/// The sums of one thread.
struct Counting<'a> {
    mapper: &'a Mapper<'a>,
    lattice: &'a UavLattice,
    positions: Positions<'a>,
    receivers: &'a GridReceivers<'a>,
    weight: &'a (dyn Fn(usize) -> u32 + Sync),
    /// The weight of receivers that all UAVs have in range.
    everywhere: u64,
    wanted: LatticeSums,
    seen: LatticeSums,
}

impl<'a> Counting<'a> {
    fn new(
        mapper: &'a Mapper<'a>,
        lattice: &'a UavLattice,
        (positions, receivers): (Positions<'a>, &'a GridReceivers<'a>),
        weight: &'a (dyn Fn(usize) -> u32 + Sync),
    ) -> Self {
        let sums = LatticeSums::new(lattice.places.words().len());
        Counting { mapper, lattice, positions, receivers, weight, everywhere: 0, wanted: sums.clone(), seen: sums }
    }

    /// Counts for the receivers of a square of cells, `sides[0]` wide, whose north-western one is `(row, col)`.
    fn tile(&mut self, (row, col): (usize, usize), sides: &[usize], whole: &InView, control: &Control) {
        let (Some(side), false) = (sides.first(), control.stop.load(Ordering::Relaxed)) else { return };
        let cells = self.cells((row, col), *side);
        let Some(tile) = self.bounds(&cells) else { return };
        let mut in_view = self.positions.from_tile(&tile, whole);
        match sides.get(1) {
            Some(smaller) => {
                for row in (row..row + side).step_by(*smaller) {
                    for col in (col..col + side).step_by(*smaller) {
                        self.tile((row, col), &sides[1..], &in_view, control);
                    }
                }
            }
            None => cells.iter().for_each(|cell| self.receiver(*cell, &mut in_view)),
        }
    }

    /// What may be in view from a square of the largest cells: nothing that is out of range of all of it.
    fn near(&self, (row, col): (usize, usize), whole: &InView) -> InView {
        let mut near = whole.clone();
        let Some(radius) = self.mapper.radius() else { return near };
        let (cells, places) = (self.mapper.field().grid(), &self.lattice.grid);
        let (west, north) = cells.world_from_cell(row, col);
        let last = |first: usize, n: usize| (first + SIDES[0] - 1).min(n - 1);
        let (east, south) = cells.world_from_cell(last(row, cells.n_rows()), last(col, cells.n_cols()));
        // A place to spare on all sides, for rounding.
        let (dx, dy) = (radius + places.cell_width(), radius + places.cell_height());
        let is_near_row = |row: usize| (south - dy..=north + dy).contains(&places.world_from_cell(row, 0).1);
        let is_near_col = |col: usize| (west - dx..=east + dx).contains(&places.world_from_cell(0, col).0);
        let words_per_row = near.positions.words_per_row();
        for (row, words) in near.positions.words_mut().chunks_exact_mut(words_per_row).enumerate() {
            for (word, bits) in words.iter_mut().enumerate() {
                let is_near = |bit: &usize| is_near_row(row) && is_near_col(word * 64 + bit);
                *bits = set_bits(&[*bits]).filter(is_near).fold(0, |kept, bit| kept | 1 << bit);
            }
        }
        near
    }

    /// The cells of a square that hold receivers.
    fn cells(&self, (row, col): (usize, usize), side: usize) -> Vec<(usize, usize)> {
        let all = &self.receivers.cells;
        let end = (col + side).min(all.n_cols());
        (row..(row + side).min(all.n_rows()))
            .flat_map(|row| {
                let of_row = (col / 64..end.div_ceil(64))
                    .flat_map(move |word| set_bits(&all.row(row)[word..=word]).map(move |bit| word * 64 + bit));
                of_row.filter(|at| (col..end).contains(at)).map(move |col| (row, col))
            })
            .collect()
    }

    fn station(&self, (row, col): (usize, usize)) -> Station {
        let z = self.receivers.height(row * self.receivers.cells.n_cols() + col);
        Station { place: self.mapper.positions().center(row, col), z }
    }

    /// The box around the receivers of some cells.
    fn bounds(&self, cells: &[(usize, usize)]) -> Option<ReceiverTile> {
        let of_one = |cell: &(usize, usize)| {
            let LatticePoint { x, y, z } = self.station(*cell).on_prisms();
            ReceiverTile { bounds: [x, y, x, y], heights: (z, z) }
        };
        cells.iter().map(of_one).reduce(|a, b| {
            let ([w, s, e, n], [bw, bs, be, bn]) = (a.bounds, b.bounds);
            ReceiverTile {
                bounds: [w.min(bw), s.min(bs), e.max(be), n.max(bn)],
                heights: (a.heights.0.min(b.heights.0), a.heights.1.max(b.heights.1)),
            }
        })
    }

    fn receiver(&mut self, (row, col): (usize, usize), in_view: &mut InView) {
        let weight = (self.weight)(row * self.receivers.cells.n_cols() + col);
        if weight == 0 {
            return;
        }
        let station = self.station((row, col));
        // The distance from a cell to a place is that from the place to the cell, to the last bit.
        let range = Range::of(&self.lattice.grid, &station.place, self.mapper.radius());
        if range.is_everywhere() {
            self.everywhere += u64::from(weight);
        } else {
            self.wanted.add(&range.cut(&self.lattice.places), weight);
        }
        let mut asked = range.cut(&in_view.positions);
        self.positions.los(in_view, station.on_prisms(), &mut asked);
        self.seen.add(&asked, weight);
    }

    fn counts(self) -> LatticeCounts {
        let mut wanted = self.wanted.totals();
        for (word, places) in self.lattice.places.words().iter().enumerate() {
            for bit in set_bits(&[*places]) {
                wanted[word * 64 + bit] += self.everywhere;
            }
        }
        LatticeCounts { wanted, seen: self.seen.totals() }
    }
}
