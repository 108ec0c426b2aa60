//! UAVs over a grid of places, counted receiver by receiver.
//!
//! Thousands of UAVs at one height over a grid of places are counted sooner the other way around.
//! For each receiver the exact engine of [`UavPositions`] finds the UAVs that it sees, in tiles of
//! receivers that see much the same. The counts are those of [`View::count`](super::View::count),
//! one by one.

use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};

use rayon::prelude::*;

use super::place_sums::PlaceSums;
use super::range::Range;
use super::view::Mapper;
use super::{Control, Uav};
use crate::error::Result;
use crate::height_field::{GridPositions, Station};
use crate::los::{GridReceivers, InView, ReceiverTile, ShadowGrid, UavPositions};
use crate::quantity::LatticePoint;
use crate::raster::{BitGrid, GeoRef};

/// Cells along the side of a tile of receivers, from the largest to the smallest tiles.
///
/// PERF: measured for 10 000 UAVs over Munich and an urban city on cells of 2 m; 8 or 32 cells in
/// between, or 2 at the end, cost more than they save.
const SIDES: [usize; 3] = [64, 16, 4];

/// UAVs at one height over places of a grid.
#[derive(Debug, Clone)]
pub struct UavGrid {
    grid: GeoRef,
    /// The places that have a UAV.
    places: BitGrid,
    positions: GridPositions,
    shadows: ShadowGrid,
    /// \[1/1024 m above the datum\].
    z: i64,
}

impl UavGrid {
    /// Memory that counting takes beside the counts, for each place and thread \[bytes\]: a sum of
    /// up to 45 bits.
    pub const BYTES_PER_PLACE_AND_THREAD: usize = 6;
    /// Memory that counting takes for each place and thread where receivers have weights \[bytes\]:
    /// a sum of up to 120 bits.
    pub const BYTES_PER_WEIGHED_PLACE_AND_THREAD: usize = 15;
}

impl Mapper<'_> {
    /// Returns UAVs over the centers of cells of `grid`, each with the number of its cell, row by
    /// row.
    ///
    /// `None` without any, if they are not all at one height where the grid puts them, or if the
    /// earth is curved.
    pub fn uav_grid<'a>(&self, grid: &GeoRef, uavs: impl IntoIterator<Item = (usize, &'a Uav)>) -> Option<UavGrid> {
        // Over a curved earth each UAV sees heights of its own.
        if self.options.curvature.is_some() {
            return None;
        }
        let field = self.field();
        let (n_rows, n_cols) = (grid.n_rows(), grid.n_cols());
        let positions = field.positions_on(grid);
        let has_prisms = field.prisms().is_some();
        let (xs, ys) = if has_prisms { positions.on_prisms() } else { positions.on_columns() };
        let mut places = BitGrid::new(n_rows, n_cols);
        let mut z = None;
        for (place, uav) in uavs {
            let (row, col) = (place / n_cols, place % n_cols);
            let at = self.on_shadows(&uav.station);
            if row >= n_rows || (at.x, at.y) != (xs[col], ys[row]) || *z.get_or_insert(at.z) != at.z {
                return None;
            }
            places.insert(row, col);
        }
        Some(UavGrid { grid: grid.clone(), places, positions, shadows: ShadowGrid::new(xs, ys), z: z? })
    }

    /// Returns whether [`Mapper::count_grid`] can count these UAVs and should take less time than a
    /// count of each.
    pub fn is_counted_sooner(&self, uavs: &UavGrid) -> bool {
        let [together, one_by_one] = self.counting_us(uavs);
        together < one_by_one
    }

    /// Estimates how long one thread counts what UAVs see over a grid \[µs\]: by
    /// [`Mapper::count_grid`], infinite if that cannot, and one by one.
    pub fn counting_us(&self, uavs: &UavGrid) -> [f64; 2] {
        #[expect(clippy::cast_precision_loss, reason = "an estimate")]
        let n_uavs = uavs.places.count() as f64;
        let one_by_one = self.counting_one_us().map_or(f64::INFINITY, |one| n_uavs * one);
        let Some(positions) = self.uav_positions(&uavs.shadows, uavs.z) else {
            return [f64::INFINITY, one_by_one];
        };
        // PERF: fitted to the itu cities and Munich on cells of 2 and 5 m with 500 to 40 000 UAVs.
        // Of 65 trials it takes the slower way in 6: three ties, and at most 1.9 times the time
        // where UAVs are so high (200 m) that counting them together takes half as long. The passes
        // over words matter for millions of places.
        #[expect(clippy::cast_precision_loss, reason = "an estimate")]
        let [rows, words, receivers] = [
            uavs.grid.n_rows() as u64,
            uavs.places.words().len() as u64,
            self.receivers.iter().map(|r| r.cells.count()).sum(),
        ]
        .map(|n| n as f64);
        let casters = self.in_range(positions.casters.all().len());
        let rows = self.options.radius.map_or(rows, |radius| rows.min(2.0 * radius / uavs.grid.cell_height()));
        let of_range = if self.options.radius.is_some() { 2.0 } else { 1.0 };
        let one_receiver = (5.0 + 0.005 * casters) * (0.4 + 0.006 * rows) * of_range + 0.0025 * words;
        [receivers * one_receiver, one_by_one]
    }

    /// Estimates how long one thread counts what one UAV sees \[µs\]; `None` unless the engine is
    /// `shadow` over a flat earth.
    pub fn counting_one_us(&self) -> Option<f64> {
        // On a raster of plateaus one UAV takes twice as long.
        let of_raster = if self.field().prisms().is_none() { 2.0 } else { 1.0 };
        Some((40.0 + 0.2 * self.in_range(self.n_casters()?)) * of_raster)
    }

    /// Estimates how many of some casters are in range of a UAV, if they stand everywhere alike.
    #[expect(clippy::cast_precision_loss, reason = "an estimate")]
    fn in_range(&self, n_casters: usize) -> f64 {
        let share = self.options.radius.map_or(1.0, |radius| {
            let grid = self.field().grid();
            let area = (grid.x_max() - grid.x_min()) * (grid.y_max() - grid.y_min());
            (std::f64::consts::PI * radius * radius / area).min(1.0)
        });
        n_casters as f64 * share
    }

    /// Counts what each UAV of a grid sees, place by place, 0 for those without a UAV: for each
    /// receiver of a cell `weight(cell)`, cells row by row.
    ///
    /// `None` unless the engine is `shadow` over prisms alone, or over a raster of plateaus with
    /// receivers beside them. Shared by all threads of the current pool. Adds the number of UAVs to
    /// `control.done`, tile by tile of receivers.
    pub fn count_grid(
        &self,
        uavs: &UavGrid,
        weight: &(dyn Fn(usize) -> u128 + Sync),
        control: &Control,
    ) -> Result<Option<Vec<u128>>> {
        let Some(positions) = self.uav_positions(&uavs.shadows, uavs.z) else {
            return Ok(None);
        };
        let whole = positions.anywhere(&uavs.places);
        let (n_rows, n_cols) = (self.field().grid().n_rows(), self.field().grid().n_cols());
        let tiles_per_row = n_cols.div_ceil(SIDES[0]);
        let n_tiles = n_rows.div_ceil(SIDES[0]) * tiles_per_row;
        let (n_uavs, n_steps) = (u128::from(uavs.places.count()), (n_tiles * self.receivers.len()).max(1) as u128);
        let n_done = AtomicU64::new(0);
        let tile_is_done = || {
            let up_to = |k: u64| n_uavs * u128::from(k) / n_steps;
            let k = n_done.fetch_add(1, Ordering::Relaxed);
            control.done.fetch_add(u64::try_from(up_to(k + 1) - up_to(k)).unwrap_or(0), Ordering::Relaxed);
        };
        // One worker to a thread, each with sums of its own: they are large where places are many.
        let of_worker = |receivers: &GridReceivers<'_>, next: &AtomicUsize| {
            let mut counting = Counting::new(self, uavs, (positions, receivers), weight);
            loop {
                let tile = next.fetch_add(1, Ordering::Relaxed);
                if tile >= n_tiles || control.stop.load(Ordering::Relaxed) {
                    return counting.seen;
                }
                let at = (tile / tiles_per_row * SIDES[0], tile % tiles_per_row * SIDES[0]);
                counting.tile(at, &SIDES, &whole, control);
                tile_is_done();
            }
        };
        let of_kind = |receivers: &GridReceivers<'_>| {
            let next = AtomicUsize::new(0);
            let workers = (0..rayon::current_num_threads()).into_par_iter().with_max_len(1);
            workers.map(|_| of_worker(receivers, &next)).reduce_with(|a, b| a.plus(&b))
        };
        let seen = self.receivers.iter().filter_map(of_kind).reduce(|a, b| a.plus(&b));
        control.check()?;
        // Bits beyond the last column are no places.
        let (width, n_cols) = (uavs.places.words_per_row() * 64, uavs.grid.n_cols());
        let cut = |sums: Vec<u128>| sums.chunks(width).flat_map(|row| &row[..n_cols]).copied().collect();
        Ok(seen.map(|seen| cut(seen.totals())))
    }
}

struct Counting<'a> {
    mapper: &'a Mapper<'a>,
    uavs: &'a UavGrid,
    positions: UavPositions<'a>,
    receivers: &'a GridReceivers<'a>,
    weight: &'a (dyn Fn(usize) -> u128 + Sync),
    /// Counts, place by place.
    seen: PlaceSums,
}

impl<'a> Counting<'a> {
    fn new(
        mapper: &'a Mapper<'a>,
        uavs: &'a UavGrid,
        (positions, receivers): (UavPositions<'a>, &'a GridReceivers<'a>),
        weight: &'a (dyn Fn(usize) -> u128 + Sync),
    ) -> Self {
        let seen = PlaceSums::new(uavs.places.words().len());
        Counting { mapper, uavs, positions, receivers, weight, seen }
    }

    /// Counts for the receivers of a square of cells, `sides[0]` wide, whose north-western one is
    /// `(row, col)`.
    fn tile(&mut self, (row, col): (usize, usize), sides: &[usize], whole: &InView, control: &Control) {
        let (Some(side), false) = (sides.first(), control.stop.load(Ordering::Relaxed)) else { return };
        let cells = self.cells((row, col), *side);
        let Some(tile) = self.bounds(&cells) else { return };
        // What the largest tiles have left out need not be left out again.
        let near = if sides.len() == SIDES.len() { self.near(&cells) } else { None };
        let in_view = match near {
            Some(near) => self.positions.from_tile(&tile, &self.positions.near(&tile, near, whole)),
            None => self.positions.from_tile(&tile, whole),
        };
        match sides.get(1) {
            Some(smaller) => {
                for row in (row..row + side).step_by(*smaller) {
                    for col in (col..col + side).step_by(*smaller) {
                        self.tile((row, col), &sides[1..], &in_view, control);
                    }
                }
            }
            None => cells.iter().for_each(|cell| self.receiver(*cell, &in_view)),
        }
    }

    /// Returns the rows and columns of places out of which all is out of range of some cells, if
    /// range is limited.
    fn near(&self, cells: &[(usize, usize)]) -> Option<(Span, Span)> {
        let radius = self.mapper.options.radius?;
        let (grid, places) = (self.mapper.field().grid(), &self.uavs.grid);
        let (first, last) = (cells.first()?, cells.last()?);
        let cols = || cells.iter().map(|(_, col)| *col);
        let (west, north) = grid.world_from_cell(first.0, cols().min()?);
        let (east, south) = grid.world_from_cell(last.0, cols().max()?);
        // A place to spare on all sides, for rounding.
        let (dx, dy) = (radius + places.cell_width(), radius + places.cell_height());
        let (north, south, west, east) = (north + dy, south - dy, west - dx, east + dx);
        let of = |n: usize, is_near: &dyn Fn(usize) -> bool| {
            let first = (0..n).find(|k| is_near(*k)).unwrap_or(n);
            (first, (first..n).find(|k| !is_near(*k)).unwrap_or(n))
        };
        let rows = of(places.n_rows(), &|row| (south..=north).contains(&places.world_from_cell(row, 0).1));
        let cols = of(places.n_cols(), &|col| (west..=east).contains(&places.world_from_cell(0, col).0));
        Some((rows, cols))
    }

    /// Returns the cells of a square whose receivers count anything.
    fn cells(&self, (row, col): (usize, usize), side: usize) -> Vec<(usize, usize)> {
        let all = &self.receivers.cells;
        let end = (col + side).min(all.n_cols());
        (row..(row + side).min(all.n_rows()))
            .flat_map(|row| (col..end).map(move |col| (row, col)))
            .filter(|(row, col)| all.contains(*row, *col))
            .filter(|(row, col)| (self.weight)(row * all.n_cols() + col) > 0)
            .collect()
    }

    fn station(&self, (row, col): (usize, usize)) -> Station {
        let z = self.receivers.height(row * self.receivers.cells.n_cols() + col);
        Station { place: self.mapper.positions().center(row, col), z }
    }

    /// Returns the box around the receivers of some cells.
    fn bounds(&self, cells: &[(usize, usize)]) -> Option<ReceiverTile> {
        let of_one = |cell: &(usize, usize)| {
            let LatticePoint { x, y, z } = self.mapper.on_shadows(&self.station(*cell));
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

    fn receiver(&mut self, (row, col): (usize, usize), in_view: &InView) {
        let weight = (self.weight)(row * self.receivers.cells.n_cols() + col);
        let station = self.station((row, col));
        // The steps from a cell to a place are those from the place to the cell.
        let range = Range::of_uavs(&self.uavs.positions, &station, self.uavs.z, &self.mapper.options);
        let mut asked = range.cut(&in_view.positions);
        self.positions.los(in_view, self.mapper.on_shadows(&station), &mut asked);
        self.seen.add(&asked, weight);
    }
}

/// The first of some rows or columns, and the one after the last.
type Span = (usize, usize);
