//! Cells of the receivers' grid as sets, and what receivers stand on there.

use std::borrow::Cow;
use std::ops::Range;

use fearless_simd::Level;
use fearless_simd::prelude::*;

use crate::dispatch;
use rayon::prelude::*;

use super::solid::{RasterSolid, Solid, VectorGround, VectorSolid};
use super::{CellKind, CellSets, Columns, HeightField};
use crate::city::Ground;
use crate::quantity::{BLOCKS_ALL, VOID};
use crate::raster::{BitGrid, bits_between};

impl CellSets {
    pub(super) fn of(field: &HeightField) -> Self {
        let mut cells = CellSets::with_all_data(field);
        if let Some(without) = &field.without_data {
            let not = without.complement();
            cells = CellSets { open: cells.open.and(&not), building: cells.building.and(&not) };
        }
        cells
    }

    /// Returns the sets of a field, cells without data included, by asking for each cell what it
    /// is.
    fn with_all_data(field: &HeightField) -> Self {
        let grid = field.grid();
        let (n_rows, n_cols) = (grid.n_rows(), grid.n_cols());
        let positions = field.positions();
        let (mut open, mut building) = (BitGrid::new(n_rows, n_cols), BitGrid::new(n_rows, n_cols));
        let per_row = open.words_per_row();
        let rows = open.words_mut().par_chunks_mut(per_row).zip(building.words_mut().par_chunks_mut(per_row));
        let columns = field.columns().filter(|_| field.is_surface_only());
        if columns.is_some_and(|c| c.min_top() != VOID && c.max_top() < BLOCKS_ALL) {
            // Receivers stand on every cell of a surface without voids.
            return CellSets { open: BitGrid::full(n_rows, n_cols), building };
        }
        if let Some(sets) = field.solid.raster().and_then(RasterSolid::sets_of_plateaus) {
            return sets;
        }
        if let Some(raster) = field.solid.raster() {
            rows.enumerate().for_each(|(row, (open, building))| {
                let range = row * n_cols..(row + 1) * n_cols;
                dispatch!(Level::new(), simd => raster.sort_row(simd, range, open, building));
            });
            return CellSets { open, building };
        }
        if let (Some(vector), Some(_)) = (field.solid.vector(), field.flat_ground()) {
            rows.zip(vector.roofs.par_chunks(n_cols)).for_each(|((open, building), roofs)| {
                for (k, roofs) in roofs.chunks(64).enumerate() {
                    let is_roof = |bits, (i, z): (usize, &i32)| bits | u64::from(*z != VOID) << i;
                    building[k] = roofs.iter().enumerate().fold(0, is_roof);
                    open[k] = bits_between(0, roofs.len(), 0) & !building[k];
                }
            });
            return CellSets { open, building };
        }
        rows.enumerate().for_each(|(row, (open, building))| {
            for col in 0..n_cols {
                match field.cell_kind(row * n_cols + col, &positions.center(row, col)) {
                    CellKind::Open(_) => open[col / 64] |= 1 << (col % 64),
                    CellKind::Building(_) => building[col / 64] |= 1 << (col % 64),
                    CellKind::Void => {}
                }
            }
        });
        CellSets { open, building }
    }
}

impl RasterSolid {
    /// Returns the sets of a raster without voids over flat ground, where it is known as plateaus:
    /// their heights need not be in memory one by one.
    fn sets_of_plateaus(&self) -> Option<CellSets> {
        let Ground::Flat(ground) = *self.ground else { return None };
        let plateaus = self.columns.plateaus().filter(|_| self.columns.min_top() != VOID)?;
        let (n_rows, n_cols) = (self.columns.n_rows(), self.columns.n_cols());
        let is_building = |top: i32| top - ground > self.building_threshold;
        if is_building(plateaus.lowest()) {
            return Some(CellSets { open: BitGrid::new(n_rows, n_cols), building: BitGrid::full(n_rows, n_cols) });
        }
        let mut building = BitGrid::new(n_rows, n_cols);
        let per_row = building.words_per_row();
        for plateau in plateaus.raised().iter().filter(|plateau| is_building(plateau.top)) {
            let [rows, (from, to)] = [plateau.rows, plateau.cols].map(|(from, to)| (from as usize, to as usize));
            for row in rows.0..rows.1 {
                for word in from / 64..to.div_ceil(64) {
                    building.words_mut()[row * per_row + word] |= bits_between(from, to, word);
                }
            }
        }
        Some(CellSets { open: building.complement(), building })
    }

    /// Puts the cells of a row into the sets, as [`HeightField::cell_kind`] sorts them one by one.
    #[inline(always)]
    fn sort_row<S: Simd>(&self, simd: S, row: Range<usize>, open: &mut [u64], building: &mut [u64]) {
        let n = S::i32s::LEN;
        let (void, blocks_all) = (S::i32s::splat(simd, VOID), S::i32s::splat(simd, BLOCKS_ALL));
        let tops = &self.columns.tops()[row.clone()];
        let is_surface_only = matches!(*self.ground, Ground::Surface);
        for (k, tops) in tops.chunks(64).enumerate() {
            let mut padded = [VOID; 64];
            padded[..tops.len()].copy_from_slice(tops);
            let mut grounds = [0; 64];
            let (mut n_open, mut n_building) = (0_u64, 0_u64);
            match &*self.ground {
                Ground::Surface => {}
                Ground::Flat(z) => grounds = [*z; 64],
                Ground::Terrain(terrain) => {
                    let ground = &terrain.cells()[row.start + 64 * k..][..tops.len()];
                    grounds[..ground.len()].copy_from_slice(ground);
                }
            }
            for i in (0..64).step_by(n) {
                let top = S::i32s::from_slice(simd, &padded[i..i + n]);
                let known = top.simd_ne(void) & top.simd_ne(blocks_all);
                if is_surface_only {
                    n_open |= known.to_bitmask() << i;
                    continue;
                }
                let ground = S::i32s::from_slice(simd, &grounds[i..i + n]);
                let known = known & ground.simd_ne(void);
                // Known heights are at most 2^26 apart; others may wrap, and do not count.
                let is_building = (top - ground).simd_gt(self.building_threshold);
                n_building |= (known & is_building).to_bitmask() << i;
                n_open |= (known & !is_building).to_bitmask() << i;
            }
            (open[k], building[k]) = (n_open, n_building);
        }
    }
}

/// Heights of what receivers stand on \[1/1024 m above the datum\].
#[derive(Debug, Clone)]
pub enum StandsOn<'a> {
    /// One height for all cells.
    Flat(i32),
    /// A height for each cell, row by row from the north-west; only those of the cells in question
    /// mean anything.
    Cells(Cow<'a, [i32]>),
    /// The tops of columns of which none is void.
    Tops(&'a Columns),
}

impl StandsOn<'_> {
    /// Returns the height of a cell.
    #[inline]
    pub(crate) fn at(&self, cell: usize) -> i32 {
        match self {
            StandsOn::Flat(z) => *z,
            StandsOn::Cells(heights) => heights[cell],
            StandsOn::Tops(columns) => columns.top_at(cell),
        }
    }
}

impl HeightField {
    /// Returns the cells that are free at a height above the ground \[1/1024 m\]: open ground, and
    /// buildings that reach no higher.
    pub(crate) fn free_above_ground(&self, above: i32) -> BitGrid {
        let (ground, roofs) = (self.ground_of_cells(), self.roof_of_cells());
        let n_cols = self.grid.n_cols();
        let mut free = self.cells.open.clone();
        for (row, col) in self.cells.building.cells() {
            let cell = row * n_cols + col;
            let base = ground.at(cell);
            if base != VOID && roofs.at(cell) - base <= above {
                free.insert(row, col);
            }
        }
        free
    }

    /// Returns the cells of a raster that are buildings; all of a surface model alone, where
    /// buildings are not known.
    pub(crate) fn cells_of_buildings(&self) -> &BitGrid {
        if self.is_surface_only() { &self.cells.open } else { &self.cells.building }
    }

    /// Returns the one height of the ground under all open cells, if it is flat.
    pub fn flat_ground(&self) -> Option<i32> {
        match &self.solid {
            Solid::Raster(RasterSolid { ground, drops: None, .. }) => match **ground {
                Ground::Flat(z) => Some(z),
                _ => None,
            },
            Solid::Vector(VectorSolid { ground, .. }) => match **ground {
                VectorGround::Flat(z) => Some(z),
                VectorGround::Terrain { .. } => None,
            },
            Solid::Raster(_) => None,
        }
    }

    /// Returns the ground of each open cell where it is stored cell by cell on the receivers' grid.
    fn ground_on_grid(&self) -> Option<Cow<'_, [i32]>> {
        match &self.solid {
            Solid::Raster(raster) => match raster.ground() {
                None => Some(Cow::Borrowed(raster.columns.tops())),
                Some(ground) => match (ground.in_memory(), ground.drops) {
                    (Some(cells), _) => Some(Cow::Borrowed(cells)),
                    (None, Some(drops)) => Some(drops.lowered_all(ground.heights).into_vec().into()),
                    (None, None) => None,
                },
            },
            Solid::Vector(_) => {
                let on_grid = self.solid.columns().filter(|_| self.columns_are_on_grid());
                on_grid.map(|(columns, _)| Cow::Borrowed(columns.tops()))
            }
        }
    }

    /// Returns the ground under the open cells.
    pub fn ground_of_cells(&self) -> StandsOn<'_> {
        if let Some(z) = self.flat_ground() {
            return StandsOn::Flat(z);
        }
        if let Some(columns) = self.columns().filter(|_| self.is_surface_only()) {
            // All cells but the void ones, which are no receivers.
            return match columns.min_top() {
                VOID => StandsOn::Cells(Cow::Borrowed(columns.tops())),
                _ => StandsOn::Tops(columns),
            };
        }
        if let Some(cells) = self.ground_on_grid() {
            return StandsOn::Cells(cells);
        }
        // A terrain on a grid of its own.
        let n_cols = self.grid().n_cols();
        let positions = self.positions();
        let mut ground = vec![VOID; self.grid().n_cells()];
        ground.par_chunks_mut(n_cols).enumerate().for_each(|(row, ground)| {
            for (col, ground) in ground.iter_mut().enumerate() {
                *ground = self.ground_at(&positions.center(row, col));
            }
        });
        StandsOn::Cells(Cow::Owned(ground))
    }

    /// Returns the roofs of the building cells.
    pub(crate) fn roof_of_cells(&self) -> StandsOn<'_> {
        StandsOn::Cells(Cow::Borrowed(self.roofs_of_cells()))
    }

    /// Returns the roof of each cell that is a building \[1/1024 m above the datum\].
    pub(crate) fn roofs_of_cells(&self) -> &[i32] {
        match &self.solid {
            Solid::Raster(raster) => raster.columns.tops(),
            Solid::Vector(vector) => &vector.roofs,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::city::Solids;
    use crate::raster::{GeoRef, Raster};

    #[test]
    fn the_cells_of_a_raster_are_sorted_as_one_by_one() {
        let grid = GeoRef::new((0.0, 0.0), (1.0, 1.0), (3, 101), None).expect("a valid grid");
        let kinds = [VOID, BLOCKS_ALL, 0, 256, 257, 5000, -3000, 1 << 25, -(1 << 25)];
        let heights = |step: usize| (0..303).map(|i| kinds[i * step % kinds.len()]).collect::<Vec<i32>>();
        let terrain: Vec<i32> = heights(5).into_iter().map(|z| if z == BLOCKS_ALL { 9 } else { z }).collect();
        for ground in [Ground::Surface, Ground::Flat(0), Ground::Terrain(Raster::new(grid.clone(), terrain))] {
            let surface = Raster::new(grid.clone(), heights(1));
            let solids = Solids::Raster { surface, ground, building_threshold: 256, voids: None };
            let field = HeightField::build(&grid, solids).field;
            let positions = field.positions();
            for cell in 0..303 {
                let (row, col) = (cell / 101, cell % 101);
                let kind = field.cell_kind(cell, &positions.center(row, col));
                let sets = (field.cells().open.contains(row, col), field.cells().building.contains(row, col));
                let expected = (matches!(kind, CellKind::Open(_)), matches!(kind, CellKind::Building(_)));
                assert_eq!(sets, expected, "cell {cell}: {kind:?}");
            }
        }
    }

    #[test]
    fn the_cells_of_plateaus_on_flat_ground_are_sorted_as_one_by_one() {
        let n_cols = 530;
        let grid = GeoRef::new((0.0, 0.0), (1.0, 1.0), (520, n_cols), None).expect("a valid grid");
        for (low, void) in [(0, None), (300, None), (-400, None), (0, Some(VOID))] {
            let mut tops = vec![low; 520 * n_cols];
            for k in 0..60 {
                let (row, col, top) = (k * 37 % 480, k * 101 % 470, low + [40, 256, 257, 9000][k % 4]);
                let rows = tops.chunks_mut(n_cols).skip(row).take(1 + k % 31);
                rows.for_each(|cells| cells[col..col + 5 + k].fill(top));
            }
            tops[0] = void.unwrap_or(low);
            let solids = Solids::Raster {
                surface: Raster::new(grid.clone(), tops),
                ground: Ground::Flat(0),
                building_threshold: 256,
                voids: None,
            };
            let field = HeightField::build(&grid, solids).field;
            assert!(field.columns().is_some_and(|columns| columns.plateaus().is_some()));
            let positions = field.positions();
            for cell in 0..520 * n_cols {
                let (row, col) = (cell / n_cols, cell % n_cols);
                let kind = field.cell_kind(cell, &positions.center(row, col));
                let sets = (field.cells().open.contains(row, col), field.cells().building.contains(row, col));
                let expected = (matches!(kind, CellKind::Open(_)), matches!(kind, CellKind::Building(_)));
                assert_eq!(sets, expected, "cell {cell}: {kind:?}");
            }
        }
    }
}
