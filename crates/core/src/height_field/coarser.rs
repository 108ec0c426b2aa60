//! A scene with less detail: cells several times as large, or footprints as a raster. Approximate
//! by intent.

use rayon::prelude::*;

use std::sync::Arc;

use super::field::{CellSets, HeightField};
use super::prisms::Prisms;
use super::solid::{RasterSolid, Solid};
use crate::city::{Ground, Solids};
use crate::overlay::Ring;
use crate::quantity::{BLOCKS_ALL, VOID};
use crate::raster::{BitGrid, GeoRef, Raster};

/// Rule by which one cell is made of several. Cells without a height count for nothing, unless all
/// are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Pooling {
    /// The highest: nothing that blocks is lost, and streets narrow.
    Maximum,
    /// The mean, to the nearest lattice step: roofs sink and streets fill up where a cell holds
    /// both.
    Mean,
}

impl Pooling {
    /// Returns the word for it.
    pub fn name(self) -> &'static str {
        match self {
            Pooling::Maximum => "maximum",
            Pooling::Mean => "mean",
        }
    }
}

impl HeightField {
    /// Returns a raster scene on cells `factor` times as wide and as high, counted from the
    /// north-west corner: *approximate*. Its surface and its terrain are pooled alike. `None` for a
    /// vector scene, for `factor` 0, or where the coarse grid is not one.
    ///
    /// Row r and column c of the fine grid lie in row r / `factor` and column c / `factor` of the
    /// coarse one. The last row and column may reach beyond the fine grid and pool what there is.
    pub fn coarser(&self, factor: usize, pooling: Pooling) -> Option<HeightField> {
        let raster = self.solid.raster()?;
        let grid = coarser_grid(self.grid(), factor)?;
        let pooled = |tops: &[i32]| {
            Raster::new(grid.clone(), pool((tops, self.without_data.as_deref()), self.grid(), (&grid, factor), pooling))
        };
        let ground = match &*raster.ground {
            Ground::Terrain(terrain) => Ground::Terrain(pooled(terrain.cells())),
            ground => ground.clone(),
        };
        let voids = self.without_data.as_deref().map(|fine| all_of(fine, (grid.n_rows(), grid.n_cols()), factor));
        let solids = Solids::Raster {
            surface: pooled(raster.columns.tops()),
            ground,
            building_threshold: raster.building_threshold,
            voids,
        };
        Some(HeightField::build(&grid, solids).field)
    }

    /// Returns a vector scene with receivers on cells `factor` times as large. Its solids stay what
    /// they are, so each of the fewer receivers is decided exactly. `None` for a raster scene, or
    /// where the coarse grid is not one.
    pub fn with_coarser_receivers(&self, factor: usize) -> Option<HeightField> {
        self.prisms()?;
        Some(self.with_receivers_on(coarser_grid(self.grid(), factor)?))
    }

    /// Returns a vector scene with receivers on cells a `factor`th as large. Its solids stay what
    /// they are. `None` for a raster scene, for `factor` 0, or where the fine grid is not one.
    pub fn with_finer_receivers(&self, factor: usize) -> Option<HeightField> {
        self.prisms()?;
        let grid = self.grid();
        let shape = (grid.n_rows().checked_mul(factor)?, grid.n_cols().checked_mul(factor)?);
        #[expect(clippy::cast_precision_loss, reason = "a small factor")]
        let fine = with_cells(grid, |side| side / factor as f64, shape)?;
        Some(self.with_receivers_on(fine))
    }

    /// Returns the solids of the scene under receivers on another grid.
    fn with_receivers_on(&self, grid: GeoRef) -> HeightField {
        let mut field = HeightField { grid, ..self.clone() };
        field.find_cells_without_data();
        field.with_cells_found()
    }

    /// Returns the scene with its cells sorted into open ground and roofs anew.
    fn with_cells_found(mut self) -> HeightField {
        self.find_roofs();
        self.cells = Arc::new(CellSets::of(&self));
        self
    }

    /// Returns the terrain of a scene without its buildings: every cell is open ground. `None`
    /// where the ground is flat, or not known apart from the surface.
    pub fn terrain_alone(&self) -> Option<HeightField> {
        if self.prisms().is_some() {
            return self.columns().is_some().then(|| self.without_buildings());
        }
        let RasterSolid { ground, building_threshold, .. } = self.solid.raster()?;
        let Ground::Terrain(terrain) = &**ground else { return None };
        let solids = Solids::Raster {
            surface: terrain.clone(),
            ground: Ground::Terrain(terrain.clone()),
            building_threshold: *building_threshold,
            voids: self.without_data.as_deref().cloned(),
        };
        Some(HeightField::build(self.grid(), solids).field)
    }

    /// Returns the ground of a vector scene without a building.
    fn without_buildings(&self) -> HeightField {
        let mut field = self.with_prisms(Prisms::new(Vec::<(Ring, i32, u32)>::new()));
        if let Solid::Vector(vector) = &mut field.solid {
            vector.building_ids = [].into();
            vector.building_errors = None;
        }
        field.with_cells_found()
    }

    /// Returns the scene with a flat roof on every building, as high as its own is highest; `None`
    /// where all are that.
    pub fn with_flat_roofs(&self) -> Option<HeightField> {
        let prisms = self.prisms()?;
        if self.n_buildings_with_shaped_roofs() == 0 {
            return None;
        }
        let tops = self.building_tops();
        let flat = prisms.pieces().iter().map(|p| (prisms.ring(p), tops[p.building as usize], p.building));
        Some(self.with_prisms(Prisms::new(flat)).with_cells_found())
    }

    /// Counts buildings whose roof is not flat.
    pub fn n_buildings_with_shaped_roofs(&self) -> usize {
        let tops = self.building_tops();
        let Some(prisms) = self.prisms() else { return 0 };
        let mut is_shaped = vec![false; tops.len()];
        for piece in prisms.pieces() {
            let building = piece.building as usize;
            is_shaped[building] |= prisms.heights(piece).is_some() || piece.top != tops[building];
        }
        is_shaped.into_iter().filter(|is_shaped| *is_shaped).count()
    }

    /// Returns a vector scene as the raster of its receivers' grid: *approximate*. Each cell is as
    /// high as the roof over its center, or as the ground there. `None` for a raster scene.
    pub fn rasterized(&self) -> Option<HeightField> {
        let roofs = &self.solid.vector()?.roofs;
        let (grid, n_cols, positions) = (self.grid(), self.grid().n_cols(), self.positions());
        // What blocks is all that is there, also outside of the data area.
        let top = |cell: usize| {
            let roof = roofs[cell];
            if roof == VOID { self.ground_at(&positions.center(cell / n_cols, cell % n_cols)) } else { roof }
        };
        let tops = (0..grid.n_cells()).into_par_iter().map(top);
        let surface = Raster::new(grid.clone(), tops.collect::<Vec<_>>());
        let ground = match self.flat_ground() {
            Some(z) => Ground::Flat(z),
            None => {
                let of_cell = |cell: usize| self.ground_at(&positions.center(cell / n_cols, cell % n_cols));
                let grounds = (0..grid.n_cells()).into_par_iter().map(of_cell).collect::<Vec<_>>();
                Ground::Terrain(Raster::new(grid.clone(), grounds))
            }
        };
        let voids = self.without_data.as_deref().cloned();
        let solids = Solids::Raster { surface, ground, building_threshold: 0, voids };
        Some(HeightField::build(grid, solids).field)
    }
}

/// Returns the grid of cells `factor` times as large over the same north-west corner.
fn coarser_grid(grid: &GeoRef, factor: usize) -> Option<GeoRef> {
    if factor == 0 {
        return None;
    }
    #[expect(clippy::cast_precision_loss, reason = "a small factor")]
    with_cells(grid, |side| side * factor as f64, (grid.n_rows().div_ceil(factor), grid.n_cols().div_ceil(factor)))
}

/// Returns a grid of cells of other sides from the same north-west corner.
fn with_cells(grid: &GeoRef, side: impl Fn(f64) -> f64, shape: (usize, usize)) -> Option<GeoRef> {
    let cell = (side(grid.cell_width()), side(grid.cell_height()));
    GeoRef::new((grid.x_min(), grid.y_max()), cell, shape, grid.crs().cloned())
}

/// Returns the coarse cells of which all fine ones are in a set.
fn all_of(fine: &BitGrid, (n_rows, n_cols): (usize, usize), factor: usize) -> BitGrid {
    let mut others = BitGrid::new(n_rows, n_cols);
    for row in 0..fine.n_rows() {
        (0..fine.n_cols())
            .filter(|col| !fine.contains(row, *col))
            .for_each(|col| others.insert(row / factor, col / factor));
    }
    others.complement()
}

/// Pools the tops of fine cells into those of coarse ones.
///
/// Cells without data have a height where something blocks there; it counts where there is no
/// other.
fn pool(
    (tops, without_data): (&[i32], Option<&BitGrid>),
    fine: &GeoRef,
    (coarse, factor): (&GeoRef, usize),
    pooling: Pooling,
) -> Vec<i32> {
    let n_cols = coarse.n_cols();
    let mut pooled = vec![VOID; coarse.n_cells()];
    pooled.par_chunks_mut(n_cols).enumerate().for_each(|(row, pooled)| {
        let rows = row * factor..((row + 1) * factor).min(fine.n_rows());
        for (col, cell) in pooled.iter_mut().enumerate() {
            let cols = col * factor..((col + 1) * factor).min(fine.n_cols());
            let cells = || rows.clone().flat_map(|row| cols.clone().map(move |col| (row, col)));
            let has_data = |(row, col): &(usize, usize)| without_data.is_none_or(|w| !w.contains(*row, *col));
            let top = |(row, col): (usize, usize)| tops[row * fine.n_cols() + col];
            let known = |top: &i32| *top != VOID;
            *cell = match pooling {
                Pooling::Maximum => cells().map(top).max().unwrap_or(VOID),
                Pooling::Mean => match mean(cells().filter(has_data).map(top).filter(known)) {
                    VOID => mean(cells().map(top).filter(known)),
                    mean => mean,
                },
            };
        }
    });
    pooled
}

/// Returns the mean of some tops to the nearest step; what blocks everything still does.
fn mean(tops: impl Iterator<Item = i32>) -> i32 {
    let (n, sum, highest) =
        tops.fold((0_i64, 0_i64, VOID), |(n, sum, highest), top| (n + 1, sum + i64::from(top), highest.max(top)));
    if n == 0 || highest == BLOCKS_ALL {
        return highest;
    }
    i32::try_from((2 * sum + n).div_euclid(2 * n)).unwrap_or(VOID)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn raster(n_rows: usize, n_cols: usize, tops: Vec<i32>, ground: Ground) -> HeightField {
        let grid = GeoRef::new((100.0, 50.0), (1.0, 2.0), (n_rows, n_cols), None).expect("a valid grid");
        let solids =
            Solids::Raster { surface: Raster::new(grid.clone(), tops), ground, building_threshold: 256, voids: None };
        HeightField::build(&grid, solids).field
    }

    #[test]
    fn cells_are_pooled_from_the_north_west_corner_and_voids_count_for_nothing() {
        let field = raster(3, 3, vec![0, 4, 9, 2, 1, VOID, -3, -4, VOID], Ground::Flat(0));
        let maximum = field.coarser(2, Pooling::Maximum).expect("a raster");
        assert_eq!(maximum.columns().expect("columns").tops(), [4, 9, -3, VOID]);
        let mean = field.coarser(2, Pooling::Mean).expect("a raster");
        // 7/4 is nearest to 2, and −7/2 is rounded up.
        assert_eq!(mean.columns().expect("columns").tops(), [2, 9, -3, VOID]);
        let grid = maximum.grid();
        assert_eq!((grid.x_min(), grid.y_max(), grid.x_max(), grid.y_min()), (100.0, 50.0, 104.0, 42.0));
        assert!(field.coarser(0, Pooling::Mean).is_none() && field.rasterized().is_none());
    }

    /// A cell without data blocks by the ground that is known there, but is no part of a mean
    /// beside cells with data.
    #[test]
    fn a_mean_leaves_out_cells_without_data_unless_all_are() {
        let grid = GeoRef::new((0.0, 2.0), (1.0, 1.0), (2, 4), None).expect("a valid grid");
        let mut voids = BitGrid::full(2, 4);
        voids.set(0, 0, false);
        let surface = Raster::new(grid.clone(), vec![20, 0, 3, 5, 0, 0, 3, 5]);
        let solids = Solids::Raster { surface, ground: Ground::Flat(0), building_threshold: 0, voids: Some(voids) };
        let field = HeightField::build(&grid, solids).field;
        let tops = |pooling| field.coarser(2, pooling).expect("a raster").columns().expect("columns").tops().to_vec();
        assert_eq!((tops(Pooling::Mean), tops(Pooling::Maximum)), (vec![20, 4], vec![20, 5]));
    }
}
