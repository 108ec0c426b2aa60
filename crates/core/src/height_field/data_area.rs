//! The data area of a scene: which cells of the receivers' grid lie in the ground that is known.

use std::sync::Arc;

use super::HeightField;
use super::known_ground::KnownGround;
use super::solid::Solid;
use crate::city::BuildingHeight;
use crate::raster::BitGrid;

impl HeightField {
    /// Finds the cells of the receivers' grid that lie outside of the known ground.
    pub(super) fn find_cells_without_data(&mut self) {
        if let Some(known) = self.known_ground() {
            self.without_data = Some(known.outside(&self.grid)).filter(|outside| outside.count() > 0).map(Arc::new);
        }
    }

    /// Returns the ground that a vector scene knows, if not all of it.
    fn known_ground(&self) -> Option<&KnownGround> {
        self.solid.vector()?.known_ground.as_deref()
    }

    /// Takes all ground for known where less than a tenth of what is near the footprints is open,
    /// and says whether: a lone building says nothing of a city.
    pub(super) fn knows_all_as_little_is_open(&mut self) -> bool {
        let Solid::Vector(vector) = &mut self.solid else { return false };
        /// Share of open ground below which it is little.
        const LEAST_SHARE: f64 = 0.1;
        if vector.known_ground.as_ref().is_none_or(|known| known.open_share() >= LEAST_SHARE) {
            return false;
        }
        (vector.known_ground, self.without_data) = (None, None);
        true
    }

    /// Returns the cells outside of the data area of a vector scene, if there are any: they hold no
    /// receiver, no zone and no candidate.
    pub fn outside_data(&self) -> Option<&BitGrid> {
        self.without_data.as_deref().filter(|_| self.known_ground().is_some())
    }

    /// Returns the heights \[m\] of those buildings that stand on the receivers' grid and in its
    /// data area.
    pub fn heights_in_data(&self, buildings: &[BuildingHeight]) -> Vec<f64> {
        let grid = &self.grid;
        let is_here = |b: &&BuildingHeight| {
            let is_on_grid =
                (grid.x_min()..=grid.x_max()).contains(&b.x) && (grid.y_min()..=grid.y_max()).contains(&b.y);
            is_on_grid && self.is_known_at(b.x, b.y)
        };
        buildings.iter().filter(is_here).map(|b| b.height_m).collect()
    }

    /// Returns whether a position \[CRS units\] is in the data area, as the cell is that holds it.
    /// Without a data area, everywhere is.
    pub fn is_known_at(&self, x: f64, y: f64) -> bool {
        let Some(known) = self.known_ground() else { return true };
        match (self.grid.cell_at(x, y), &self.without_data) {
            (Some((row, col)), Some(without_data)) => !without_data.contains(row, col),
            (Some(_), None) => true,
            (None, _) => known.contains(x, y),
        }
    }
}
