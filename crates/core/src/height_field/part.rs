//! A part of a raster scene.

use super::HeightField;
use crate::city::{Ground, Solids};
use crate::raster::{BitGrid, CellWindow, Raster};

impl HeightField {
    /// The part of a raster scene over some of its cells, as if no more had been read; `None` of a vector scene.
    pub fn part(&self, window: CellWindow) -> Option<HeightField> {
        Some(HeightField::build(&self.grid.part(window), self.solids_of(window)?).field)
    }

    /// What a raster scene was built from, over some of its cells; `None` of a vector scene.
    pub fn solids_of(&self, window: CellWindow) -> Option<Solids> {
        let raster = self.solid.raster()?;
        let grid = self.grid.part(window);
        let cut = |cells: &[i32]| {
            let rows = cells.chunks(self.grid.n_cols()).skip(window.row).take(window.n_rows);
            let cells: Vec<i32> = rows.flat_map(|row| &row[window.col..window.col + window.n_cols]).copied().collect();
            Raster::new(grid.clone(), cells)
        };
        let ground = match &raster.ground {
            Ground::Terrain(terrain) => Ground::Terrain(cut(terrain.cells())),
            ground => ground.clone(),
        };
        let voids = self.without_data.as_ref().map(|whole| {
            let mut part = BitGrid::new(window.n_rows, window.n_cols);
            for row in 0..window.n_rows {
                let is_void = |col: &usize| whole.contains(window.row + row, window.col + col);
                (0..window.n_cols).filter(is_void).for_each(|col| part.insert(row, col));
            }
            part
        });
        let building_threshold = raster.building_threshold;
        Some(Solids::Raster { surface: cut(raster.columns.tops()), ground, building_threshold, voids })
    }
}
