//! A part of a scene.

use std::sync::Arc;

use super::solid::{Solid, VectorSolid};
use super::{CellSets, HeightField};
use crate::city::{Ground, Solids};
use crate::raster::{CellWindow, Raster};

impl HeightField {
    /// Returns the part of a raster scene over some of its cells, as if no more had been read;
    /// `None` of a vector scene.
    pub fn part(&self, window: CellWindow) -> Option<HeightField> {
        Some(HeightField::build(&self.grid.part(window), self.solids_of(window)?).field)
    }

    /// Returns the scene with receivers in some of its cells alone: a raster as if no more had been
    /// read, of footprints with all that can block a link.
    #[must_use]
    pub fn shown(&self, window: CellWindow) -> HeightField {
        let Solid::Vector(vector) = &self.solid else { return self.part(window).unwrap_or_else(|| self.clone()) };
        let n_cols = self.grid.n_cols();
        let rows = vector.roofs.chunks(n_cols).skip(window.row).take(window.n_rows);
        let roofs = rows.flat_map(|row| &row[window.col..window.col + window.n_cols]).copied().collect();
        // Fields one by one: the roofs of the whole are not copied.
        let VectorSolid { prisms, frame, ground, known_ground, building_ids, building_errors, .. } = vector;
        let solid = Solid::Vector(VectorSolid {
            prisms: prisms.clone(),
            frame: *frame,
            ground: ground.clone(),
            roofs: Arc::new(roofs),
            known_ground: known_ground.clone(),
            building_ids: building_ids.clone(),
            building_errors: building_errors.clone(),
        });
        let cells =
            Arc::new(CellSets { open: self.cells.open.part(window), building: self.cells.building.part(window) });
        let without_data = self.without_data.as_ref().map(|whole| Arc::new(whole.part(window)));
        HeightField { grid: self.grid.part(window), solid, without_data, cells, bent_terrain: None }
    }

    /// Returns what a raster scene was built from, over some of its cells; `None` of a vector
    /// scene.
    pub fn solids_of(&self, window: CellWindow) -> Option<Solids> {
        let raster = self.solid.raster()?;
        let grid = self.grid.part(window);
        let cut = |cells: &[i32]| {
            let rows = cells.chunks(self.grid.n_cols()).skip(window.row).take(window.n_rows);
            let cells: Vec<i32> = rows.flat_map(|row| &row[window.col..window.col + window.n_cols]).copied().collect();
            Raster::new(grid.clone(), cells)
        };
        let ground = match &*raster.ground {
            Ground::Terrain(terrain) => Ground::Terrain(cut(terrain.cells())),
            ground => ground.clone(),
        };
        let voids = self.without_data.as_ref().map(|whole| whole.part(window));
        let building_threshold = raster.building_threshold;
        Some(Solids::Raster { surface: cut(raster.columns.tops()), ground, building_threshold, voids })
    }
}
