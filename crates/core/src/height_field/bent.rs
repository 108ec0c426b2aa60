//! Scenes on a curved earth: all heights lowered by what the earth falls away from a UAV.
//!
//! A ray that is straight over a curved earth stays a straight line when heights are measured from the plane that touches the earth below the
//! UAV. There a point at distance d is lower by d²/2KR: K times the radius R of the earth stands for refraction, which bends rays
//! (ITU-R P.834: K = 4/3 for radio in a standard atmosphere). Columns are lowered as a whole, by what their centers are, rounded
//! to the lattice, so that every engine decides over a curved earth what it decides over a flat one. Prisms are not lowered: engines reckon
//! with the curve of their roofs.

use std::ops::Range;
use std::sync::Arc;

use fearless_simd::{Level, Simd};
use rayon::prelude::*;

use super::solid::{RasterSolid, Solid, VectorGround, VectorSolid};
use super::{BelowUav, Bulge, Columns, Curvature, CurvedGround, GridPositions, HeightField, Place, TILE, TileMaxima};
use crate::dispatch;
use crate::quantity::{BLOCKS_ALL, Frame, STEPS_PER_UNIT, VOID, meters};
use crate::raster::{CellWindow, GeoRef, LargeVec};

/// How much lower than over a flat earth the cells of a grid are, seen from a place.
#[derive(Debug, Clone)]
pub struct Drops {
    /// What columns and rows contribute \[1/1024 m\]; a cell is lowered by their sum, rounded.
    by_col: Vec<f64>,
    by_row: Vec<f64>,
}

/// Heights over a flat earth \[1/1024 m above the datum\].
#[derive(Debug, Clone, Copy)]
pub enum HeightsOf<'a> {
    /// One for all cells.
    One(i32),
    /// Of each cell of a grid, row by row from the north-west.
    Cells(&'a [i32]),
}

/// Heights of the cells of a grid as a UAV sees them: lower by the drops of a curved earth, if it is curved.
#[derive(Debug, Clone, Copy)]
pub struct SeenHeights<'a> {
    /// Over a flat earth.
    pub heights: HeightsOf<'a>,
    /// Cells to a row.
    pub n_cols: usize,
    /// How much lower each is.
    pub drops: Option<&'a Drops>,
}

impl<'a> SeenHeights<'a> {
    /// Heights of cells over a flat earth.
    pub fn over_flat_earth(cells: &'a [i32], n_cols: usize) -> Self {
        SeenHeights { heights: HeightsOf::Cells(cells), n_cols, drops: None }
    }

    /// That of a cell.
    #[inline]
    pub fn at(&self, cell: usize) -> i32 {
        let z = match self.heights {
            HeightsOf::One(z) => z,
            HeightsOf::Cells(cells) => cells[cell],
        };
        self.drops.map_or(z, |drops| drops.lowered(z, (cell / self.n_cols, cell % self.n_cols)))
    }

    /// Copies those of cells of one row, from cell `first` on.
    pub(crate) fn copy(&self, first: usize, out: &mut [i32]) {
        let by_cell = self.drops.map(|drops| (&drops.by_col[first % self.n_cols..], drops.by_row[first / self.n_cols]));
        match (self.heights, by_cell) {
            (HeightsOf::One(z), None) => out.fill(z),
            (HeightsOf::One(z), Some((by_col, of_row))) => lower_one(z, by_col, of_row, out),
            (HeightsOf::Cells(cells), by_cell) => {
                out.copy_from_slice(&cells[first..first + out.len()]);
                if let Some((by_col, of_row)) = by_cell {
                    lower(out, by_col, of_row);
                }
            }
        }
    }

    /// All of them, if they are in memory one by one.
    pub(crate) fn in_memory(&self) -> Option<&'a [i32]> {
        match (self.heights, self.drops) {
            (HeightsOf::Cells(cells), None) => Some(cells),
            _ => None,
        }
    }

    /// The highest by tile.
    pub(crate) fn tiles(&self) -> TileMaxima {
        match (self.heights, self.drops) {
            (HeightsOf::Cells(cells), None) => TileMaxima::of(cells, self.n_cols),
            (heights, Some(drops)) => TileMaxima::of(&drops.lowered_all(heights), self.n_cols),
            (HeightsOf::One(_), None) => TileMaxima::of(&[], self.n_cols),
        }
    }

    /// Whether these are the very same.
    pub(crate) fn is(&self, other: &SeenHeights<'_>) -> bool {
        let is_same = |a: Option<&Drops>, b: Option<&Drops>| a.map(std::ptr::from_ref) == b.map(std::ptr::from_ref);
        match (self.heights, other.heights) {
            (HeightsOf::Cells(a), HeightsOf::Cells(b)) => std::ptr::eq(a, b) && is_same(self.drops, other.drops),
            _ => false,
        }
    }
}

impl Drops {
    /// Of the cells of a grid; a unit of its reference system is so many meters.
    pub fn new(positions: &GridPositions, place: &Place, curvature: Curvature, meters_per_unit: f64) -> Self {
        let (n_rows, n_cols) = positions.shape();
        let at = positions.on_range(place);
        let (step_x, step_y) = positions.step_lengths();
        let of = |steps: i64, length: f64| {
            #[expect(clippy::cast_precision_loss, reason = "steps in reach are below 2^53")]
            let distance_m = steps as f64 * length * meters_per_unit;
            f64::from(STEPS_PER_UNIT) * curvature.drop_m(distance_m)
        };
        Drops {
            by_col: (0..n_cols).map(|col| of(positions.steps(at, (0, col)).0, step_x)).collect(),
            by_row: (0..n_rows).map(|row| of(positions.steps(at, (row, 0)).1, step_y)).collect(),
        }
    }

    /// Of the cells of a terrain below prisms.
    fn of_columns(columns: &Columns, frame: Frame, place: &Place, curvature: Curvature, meters_per_unit: f64) -> Drops {
        let (x, y) = place.on_columns;
        let of = |steps: i64, unit: f64| {
            #[expect(clippy::cast_precision_loss, reason = "steps in reach are below 2^53")]
            let units = steps as f64 / f64::from(STEPS_PER_UNIT) * unit;
            f64::from(STEPS_PER_UNIT) * curvature.drop_m(units * meters_per_unit)
        };
        Drops {
            by_col: (0..columns.n_cols()).map(|col| of(columns.center(0, col).0 - x, frame.unit_x)).collect(),
            by_row: (0..columns.n_rows()).map(|row| of(columns.center(row, 0).1 - y, frame.unit_y)).collect(),
        }
    }

    /// The drop of a cell \[1/1024 m\].
    #[inline]
    pub fn at(&self, row: usize, col: usize) -> i32 {
        rounded(self.by_col[col], self.by_row[row])
    }

    /// The drop of the cell that holds a place, the nearest one outside \[1/1024 m\].
    pub(crate) fn at_place(&self, grid: &GeoRef, place: &Place) -> i32 {
        let x = place.x.clamp(grid.x_min(), grid.x_max() - 0.5 * grid.cell_width());
        let y = place.y.clamp(grid.y_min() + 0.5 * grid.cell_height(), grid.y_max());
        grid.cell_at(x, y).map_or(0, |(row, col)| self.at(row, col))
    }

    /// Those of some rows alone.
    pub(crate) fn of_rows(&self, rows: Range<usize>) -> Drops {
        Drops { by_col: self.by_col.clone(), by_row: self.by_row[rows].to_vec() }
    }

    /// A height \[m\] over a cell as it is above the datum; what is not finite stays.
    pub(crate) fn raised(&self, lowered: f32, (row, col): (usize, usize)) -> f32 {
        #[expect(clippy::cast_possible_truncation, reason = "layers are stored as f32")]
        let raised = (f64::from(lowered) + meters(self.at(row, col))) as f32;
        raised
    }

    /// Lowers the cells of a window, row by row.
    pub(crate) fn lower(&self, cells: &mut [i32], window: CellWindow) {
        let by_col = &self.by_col[window.col..window.col + window.n_cols];
        let by_row = &self.by_row[window.row..window.row + window.n_rows];
        cells.chunks_mut(window.n_cols.max(1)).zip(by_row).for_each(|(row, of_row)| lower(row, by_col, *of_row));
    }

    /// The largest drop of a window that is not empty \[1/1024 m\].
    pub(crate) fn most(&self, window: CellWindow) -> i64 {
        let most = |of: &[f64]| of.iter().fold(0.0, |a: f64, b| a.max(*b));
        let cols = most(&self.by_col[window.col..window.col + window.n_cols]);
        let rows = most(&self.by_row[window.row..window.row + window.n_rows]);
        #[expect(clippy::cast_possible_truncation, reason = "saturates")]
        let most = (cols + rows + 0.5) as i64;
        most
    }

    /// The largest drop of a window that is not empty \[m\].
    pub(crate) fn most_m(&self, window: CellWindow) -> f64 {
        #[expect(clippy::cast_precision_loss, reason = "to be compared with what is far smaller")]
        let most = self.most(window) as f64;
        most / f64::from(STEPS_PER_UNIT)
    }

    /// A height over a cell, lowered.
    #[inline]
    pub(crate) fn lowered(&self, z: i32, (row, col): (usize, usize)) -> i32 {
        lower_known(z, self.at(row, col))
    }

    /// Lowers cells of a row, from a column on.
    pub(crate) fn lower_row(&self, (row, first): (usize, usize), cells: &mut [i32]) {
        lower(cells, &self.by_col[first..], self.by_row[row]);
    }

    /// Lowers cells of a column, from a row on.
    pub(crate) fn lower_col(&self, (first, col): (usize, usize), cells: &mut [i32]) {
        lower(cells, &self.by_row[first..], self.by_col[col]);
    }

    /// One height over cells of a column, from a row on, lowered.
    pub(crate) fn lower_one_by_col(&self, z: i32, (first, col): (usize, usize), out: &mut [i32]) {
        lower_one(z, &self.by_row[first..], self.by_col[col], out);
    }

    /// All cells lowered by their drops. Threads of the current pool share the work.
    pub(super) fn lowered_all(&self, heights: HeightsOf<'_>) -> LargeVec<i32> {
        let n_cols = self.by_col.len();
        let seen = SeenHeights { heights, n_cols, drops: Some(self) };
        let mut lowered = LargeVec::<i32>::zeroed(self.by_row.len() * n_cols);
        lowered.par_chunks_mut(n_cols).enumerate().for_each(|(row, cells)| seen.copy(row * n_cols, cells));
        lowered
    }

    /// Bounds on the highest cells of tiles, lowered by their drops.
    pub(crate) fn of_tiles(&self, tiles: &TileMaxima) -> TileMaxima {
        let least = |of: &[f64]| -> Vec<f64> {
            of.chunks(TILE).map(|tile| tile.iter().fold(f64::INFINITY, |a, b| a.min(*b))).collect()
        };
        let (by_col, by_row) = (least(&self.by_col), least(&self.by_row));
        tiles.map(|row, col, highest| match highest {
            VOID | BLOCKS_ALL => highest,
            _ => highest - rounded(by_col[col], by_row[row]),
        })
    }
}

/// Lowers known heights of a line.
fn lower(cells: &mut [i32], by_cell: &[f64], of_line: f64) {
    dispatch!(Level::new(), simd => lower_with(simd, cells, by_cell, of_line));
}

/// One height over all cells of a line, lowered.
fn lower_one(z: i32, by_cell: &[f64], of_line: f64, out: &mut [i32]) {
    dispatch!(Level::new(), simd => lower_one_with(simd, z, by_cell, of_line, out));
}

/// PERF: compiled for the instructions of this machine, where the compiler makes vectors of it.
#[inline(always)]
fn lower_with<S: Simd>(simd: S, cells: &mut [i32], by_cell: &[f64], of_line: f64) {
    simd.vectorize(
        #[inline(always)]
        || {
            for (z, of_cell) in cells.iter_mut().zip(by_cell) {
                *z = lower_known(*z, rounded(*of_cell, of_line));
            }
        },
    );
}

/// PERF: as above.
#[inline(always)]
fn lower_one_with<S: Simd>(simd: S, z: i32, by_cell: &[f64], of_line: f64, out: &mut [i32]) {
    simd.vectorize(
        #[inline(always)]
        || {
            for (out, of_cell) in out.iter_mut().zip(by_cell) {
                *out = z.wrapping_sub(rounded(*of_cell, of_line));
            }
        },
    );
}

/// A height lowered by a drop, if it is known.
#[inline(always)]
fn lower_known(z: i32, drop: i32) -> i32 {
    // PERF: lowered whatever it is, so that a vector chooses.
    let low = z.wrapping_sub(drop);
    if z == VOID || z == BLOCKS_ALL { z } else { low }
}

/// The nearest whole number to a sum of two that are not negative, below 2^31.
///
/// PERF: adding 2^52 leaves it in the lowest bits of the double, which the compiler does for a vector at once.
#[inline(always)]
fn rounded(a: f64, b: f64) -> i32 {
    const ONE_PER_STEP: f64 = (1_u64 << 52) as f64;
    #[expect(clippy::cast_possible_truncation, reason = "the lowest bits alone")]
    let steps = (a + b + ONE_PER_STEP).to_bits() as i32;
    steps
}

/// The terrain below footprints as a UAV sees it over a curved earth.
#[derive(Debug)]
pub(crate) struct BentTerrain {
    pub(super) columns: Columns,
    /// How much lower its cells are.
    drops: Arc<Drops>,
    /// How much lower against it receivers on the cells of the grid are.
    pub(crate) receiver_drops: Arc<Drops>,
}

impl BentTerrain {
    /// How much lower against the terrain a receiver at a place is \[1/1024 m\].
    pub(crate) fn receiver_drop(&self, grid: &GeoRef, place: &Place) -> i64 {
        i64::from(self.receiver_drops.at_place(grid, place))
    }

    /// How much lower a cell of it is \[1/1024 m\].
    pub(crate) fn drop_of(&self, (row, col): (usize, usize)) -> i32 {
        self.drops.at(row, col)
    }
}

impl HeightField {
    /// A raster scene with its heights lowered; of a vector scene `None`. What is open ground and what is a building stays. Receivers
    /// stand on ground that is lowered as well.
    pub(crate) fn bent_raster(&self, drops: Drops) -> Option<HeightField> {
        let solid = Solid::Raster(self.solid.raster()?.bent(Arc::new(drops), self.grid.window()));
        Some(self.with_bent(solid, None, None))
    }

    /// The scene over a curved earth as it is seen from a place, with the drops of its cells.
    ///
    /// A raster is lowered ([`HeightField::bent_raster`]); what is within a window matters. In a vector scene all keep their heights above the datum:
    /// prisms tell of the earth ([`Prisms::earth`](super::Prisms::earth)), and the terrain stands in the way as it is seen, for receivers
    /// that are lower as well ([`HeightField::seen_on_columns`]).
    pub(crate) fn bent(
        &self,
        place: &Place,
        curvature: Curvature,
        drops: &Arc<Drops>,
        window: CellWindow,
    ) -> HeightField {
        let meters_per_unit = self.grid.meters_per_unit();
        let vector = match &self.solid {
            Solid::Raster(raster) => {
                let below = Some(self.below_uav(place));
                return self.with_bent(Solid::Raster(raster.bent(Arc::clone(drops), window)), None, below);
            }
            Solid::Vector(vector) => vector,
        };
        let terrain = match &*vector.ground {
            VectorGround::Flat(_) => None,
            VectorGround::Terrain { columns, frame } => {
                let of_cells = Drops::of_columns(columns, *frame, place, curvature, meters_per_unit);
                Some(Arc::new(columns.bent(Arc::new(of_cells), drops)))
            }
        };
        let earth = Bulge::new(curvature, vector.frame.unit_x * meters_per_unit);
        let earth = earth.map(|bulge| CurvedGround { bulge, ground: self.flat_ground() });
        let solid = VectorSolid { prisms: vector.prisms.on_earth(earth), ..vector.clone() };
        self.with_bent(Solid::Vector(solid), terrain, Some(self.below_uav(place)))
    }

    fn with_bent(
        &self,
        solid: Solid,
        bent_terrain: Option<Arc<BentTerrain>>,
        below_uav: Option<BelowUav>,
    ) -> HeightField {
        let (without_data, cells) = (self.without_data.clone(), self.cells.clone());
        HeightField { grid: self.grid.clone(), solid, without_data, cells, bent_terrain, below_uav }
    }
}

impl Columns {
    /// A terrain below footprints that is lower by the drops of its cells, for receivers that are lower by drops of theirs.
    fn bent(&self, drops: Arc<Drops>, receiver_drops: &Arc<Drops>) -> BentTerrain {
        let whole = CellWindow { row: 0, col: 0, n_rows: self.n_rows(), n_cols: self.n_cols() };
        let columns = self.lowered(Arc::clone(&drops), whole);
        BentTerrain { columns, drops, receiver_drops: Arc::clone(receiver_drops) }
    }
}

impl RasterSolid {
    fn bent(&self, drops: Arc<Drops>, window: CellWindow) -> RasterSolid {
        let RasterSolid { frame, building_threshold, .. } = *self;
        let columns = self.columns.lowered(Arc::clone(&drops), window);
        RasterSolid { columns, frame, ground: Arc::clone(&self.ground), drops: Some(drops), building_threshold }
    }
}
