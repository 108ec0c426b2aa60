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
use super::{Bulge, Columns, Curvature, CurvedGround, GridPositions, HeightField, Place, TILE, TileMaxima};
use crate::city::Ground;
use crate::dispatch;
use crate::quantity::{BLOCKS_ALL, Frame, STEPS_PER_UNIT, VOID, meters};
use crate::raster::{CellWindow, GeoRef, LargeVec, Raster};

/// How much lower than over a flat earth the cells of a grid are, seen from a place.
#[derive(Debug, Clone)]
pub struct Drops {
    /// What columns and rows contribute \[1/1024 m\]; a cell is lowered by their sum, rounded.
    by_col: Vec<f64>,
    by_row: Vec<f64>,
}

/// Heights that are lowered \[1/1024 m above the datum\].
#[derive(Debug, Clone, Copy)]
enum HeightsOf<'a> {
    /// One for all cells.
    One(i32),
    /// Of each cell of a grid.
    Cells(&'a [i32]),
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

    /// Cells lowered by their drops within a window; all others mean nothing. Threads of the current pool share the work.
    ///
    /// PERF: memory outside the window is not touched, so that the kernel need not provide it.
    fn lowered(&self, heights: HeightsOf<'_>, window: CellWindow) -> LargeVec<i32> {
        let n_cols = self.by_col.len();
        let mut lowered = LargeVec::<i32>::zeroed(self.by_row.len() * n_cols);
        let rows = &mut lowered[window.row * n_cols..(window.row + window.n_rows) * n_cols];
        let by_col = &self.by_col[window.col..window.col + window.n_cols];
        rows.par_chunks_mut(n_cols).enumerate().for_each(|(k, row)| {
            let (row_number, row) = (window.row + k, &mut row[window.col..window.col + window.n_cols]);
            match heights {
                HeightsOf::One(z) => row.fill(z),
                HeightsOf::Cells(cells) => {
                    let first = row_number * n_cols + window.col;
                    row.copy_from_slice(&cells[first..first + window.n_cols]);
                }
            }
            lower(row, by_col, self.by_row[row_number]);
        });
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

/// Lowers known heights of a row.
fn lower(row: &mut [i32], by_col: &[f64], of_row: f64) {
    dispatch!(Level::new(), simd => lower_with(simd, row, by_col, of_row));
}

/// PERF: compiled for the instructions of this machine, where the compiler makes vectors of it.
#[inline(always)]
fn lower_with<S: Simd>(simd: S, row: &mut [i32], by_col: &[f64], of_row: f64) {
    simd.vectorize(
        #[inline(always)]
        || {
            for (z, of_col) in row.iter_mut().zip(by_col) {
                let low = z.wrapping_sub(rounded(*of_col, of_row));
                *z = if *z == VOID || *z == BLOCKS_ALL { *z } else { low };
            }
        },
    );
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
    drops: Drops,
    /// How much lower against it receivers on the cells of the grid are.
    pub(crate) receiver_drops: Drops,
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
    /// A raster scene with its heights lowered within a window, and only there; of a vector scene `None`. What is open ground and what
    /// is a building stays. Receivers stand on ground that is lowered as well.
    pub(crate) fn bent_raster(&self, drops: &Drops, window: CellWindow) -> Option<HeightField> {
        let solid = Solid::Raster(self.solid.raster()?.bent(&self.grid, drops, window));
        Some(self.with_bent(solid, None))
    }

    /// The scene over a curved earth as it is seen from a place, with the drops of its cells.
    ///
    /// A raster is lowered within a window ([`HeightField::bent_raster`]). In a vector scene all keep their heights above the datum:
    /// prisms tell of the earth ([`Prisms::earth`](super::Prisms::earth)), and the terrain stands in the way as it is seen, for receivers
    /// that are lower as well ([`HeightField::seen_on_columns`]).
    pub(crate) fn bent(&self, place: &Place, curvature: Curvature, drops: &Drops, window: CellWindow) -> HeightField {
        let meters_per_unit = self.grid.meters_per_unit();
        let vector = match &self.solid {
            Solid::Raster(raster) => {
                return self.with_bent(Solid::Raster(raster.bent(&self.grid, drops, window)), None);
            }
            Solid::Vector(vector) => vector,
        };
        let terrain = match &*vector.ground {
            VectorGround::Flat(_) => None,
            VectorGround::Terrain { columns, frame } => {
                let of_cells = Drops::of_columns(columns, *frame, place, curvature, meters_per_unit);
                Some(Arc::new(columns.bent(of_cells, drops)))
            }
        };
        let earth = Bulge::new(curvature, vector.frame.unit_x * meters_per_unit);
        let earth = earth.map(|bulge| CurvedGround { bulge, ground: self.flat_ground() });
        let solid = VectorSolid { prisms: vector.prisms.on_earth(earth), ..vector.clone() };
        self.with_bent(Solid::Vector(solid), terrain)
    }

    fn with_bent(&self, solid: Solid, bent_terrain: Option<Arc<BentTerrain>>) -> HeightField {
        let (without_data, cells) = (self.without_data.clone(), self.cells.clone());
        HeightField { grid: self.grid.clone(), solid, without_data, cells, bent_terrain }
    }
}

impl Columns {
    /// A terrain below footprints that is lower by the drops of its cells, for receivers that are lower by drops of theirs.
    fn bent(&self, drops: Drops, receiver_drops: &Drops) -> BentTerrain {
        let whole = CellWindow { row: 0, col: 0, n_rows: self.n_rows(), n_cols: self.n_cols() };
        let tops = drops.lowered(HeightsOf::Cells(self.tops()), whole);
        BentTerrain { columns: self.lowered(tops, &drops, whole), drops, receiver_drops: receiver_drops.clone() }
    }
}

impl RasterSolid {
    fn bent(&self, grid: &GeoRef, drops: &Drops, window: CellWindow) -> RasterSolid {
        let tops = drops.lowered(HeightsOf::Cells(self.columns.tops()), window);
        let terrain =
            |heights: HeightsOf<'_>| Ground::Terrain(Raster::new(grid.clone(), drops.lowered(heights, window)));
        RasterSolid {
            columns: self.columns.lowered(tops, drops, window),
            frame: self.frame,
            ground: match &self.ground {
                Ground::Surface => Ground::Surface,
                Ground::Flat(z) => terrain(HeightsOf::One(*z)),
                Ground::Terrain(of) => terrain(HeightsOf::Cells(of.cells())),
            },
            building_threshold: self.building_threshold,
        }
    }
}
