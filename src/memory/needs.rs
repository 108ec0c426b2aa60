//! Memory that questions take beside a scene that is in memory \[bytes\].
//!
//! It was measured over flat and noisy rasters of 1000² to 5000² cells, and over the footprints of
//! Munich.

use super::{cells_of, check_bytes};
use crate::error::Result;
use crate::height_field::HeightField;
use crate::scene::Scene;

/// Memory of a question \[bytes\].
#[derive(Debug, Clone, Copy)]
pub(crate) struct Needs {
    /// Bytes for each cell of a raster.
    per_raster_cell: f64,
    /// Bytes for each corner of the outlines in a raster.
    per_raster_corner: f64,
    /// Bytes for each cell over footprints.
    per_footprint_cell: f64,
}

impl Needs {
    /// Zones: a mesh between the walls.
    pub(crate) const ZONES: Needs = Needs { per_raster_cell: 5.0, per_raster_corner: 464.0, per_footprint_cell: 6.0 };
    /// Limits of accuracy: a map of each way.
    pub(crate) const LIMITS: Needs = Needs { per_raster_cell: 8.75, per_raster_corner: 0.0, per_footprint_cell: 18.0 };
    /// Parameters of a city by tiles.
    pub(crate) const TILES: Needs = Needs { per_raster_cell: 7.6, per_raster_corner: 166.0, per_footprint_cell: 0.5 };
    /// A live page: the packed scene and its text.
    pub(crate) const LIVE: Needs = Needs { per_raster_cell: 19.2, per_raster_corner: 142.0, per_footprint_cell: 5.0 };

    /// Refuses a question over a scene, before any of its work.
    ///
    /// # Errors
    /// E501 if it takes more memory than there is or than it may take.
    pub(crate) fn check(self, scene: &Scene) -> Result<()> {
        check_bytes(&scene.word, &cells_of(scene.grid()), self.bytes(&scene.field))
    }

    /// Returns the bytes over a field.
    fn bytes(self, field: &HeightField) -> u64 {
        #[expect(clippy::cast_precision_loss, reason = "an estimate")]
        let (n_cells, n_corners) = (field.grid().n_cells() as f64, || field.n_corners_of_cells() as f64);
        let bytes = match field.columns() {
            Some(_) => self.per_raster_cell * n_cells + self.per_raster_corner * n_corners(),
            None => self.per_footprint_cell * n_cells,
        };
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "an estimate above 0")]
        let bytes = bytes as u64;
        bytes
    }
}
