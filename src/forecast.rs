//! Memory that questions take beside a scene that is in memory \[bytes\].
//!
//! It was measured over flat and noisy rasters of 1000² to 5000² cells, and over the footprints of
//! Munich.

use crate::height_field::HeightField;
use crate::memory::{cells_of, check_bytes};
use crate::{error::Result, scene::Scene};

/// Bytes of a question: for each cell, and for each corner of the outlines of buildings.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Needs {
    /// For a cell of a raster.
    of_raster: f64,
    /// For a corner in a raster.
    of_corners: f64,
    /// For a cell over footprints.
    of_footprints: f64,
}

impl Needs {
    /// Zones: a mesh between the walls.
    pub(crate) const ZONES: Needs = Needs { of_raster: 5.0, of_corners: 464.0, of_footprints: 6.0 };
    /// Limits of accuracy: a map of each way.
    pub(crate) const LIMITS: Needs = Needs { of_raster: 8.75, of_corners: 0.0, of_footprints: 18.0 };
    /// Parameters of a city by tiles.
    pub(crate) const TILES: Needs = Needs { of_raster: 7.6, of_corners: 166.0, of_footprints: 0.5 };
    /// A live page: the packed scene and its text.
    pub(crate) const LIVE: Needs = Needs { of_raster: 19.2, of_corners: 142.0, of_footprints: 5.0 };

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
            Some(_) => self.of_raster * n_cells + self.of_corners * n_corners(),
            None => self.of_footprints * n_cells,
        };
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "an estimate above 0")]
        let bytes = bytes as u64;
        bytes
    }
}
