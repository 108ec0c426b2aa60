//! Memory that questions take beside a scene that is in memory \[bytes\].
//!
//! It was measured over flat and noisy rasters of 1000² to 5000² cells, and over the footprints of
//! Munich.

use super::{cells_of, check_bytes, whole_bytes};
use crate::error::Result;
use crate::export::Format;
use crate::height_field::HeightField;
use crate::raster::GeoRef;
use crate::scene::Scene;

/// Memory of a question \[bytes\].
#[derive(Debug, Clone, Copy)]
pub(crate) struct Needs {
    /// Bytes for each cell of a raster.
    per_raster_cell: f64,
    /// Bytes for each corner of the outlines in a raster.
    per_raster_corner: f64,
    /// Bytes for each cell of open ground.
    per_open_cell: f64,
    /// Bytes for each cell over footprints.
    per_footprint_cell: f64,
}

/// Needs of nothing.
const NONE: Needs = Needs { per_raster_cell: 0.0, per_raster_corner: 0.0, per_open_cell: 0.0, per_footprint_cell: 0.0 };

impl Needs {
    /// Zones: a mesh between the walls.
    pub(crate) const ZONES: Needs =
        Needs { per_raster_cell: 3.0, per_raster_corner: 410.0, per_footprint_cell: 6.0, ..NONE };
    /// Limits of accuracy: a map of each way.
    pub(crate) const LIMITS: Needs = Needs { per_raster_cell: 8.75, per_footprint_cell: 18.0, ..NONE };
    /// Stability of a map: margins of receivers beside it.
    pub(crate) const STABILITY: Needs =
        Needs { per_raster_cell: 14.5, per_open_cell: 24.0, per_footprint_cell: 15.0, ..NONE };
    /// Parameters of a city by tiles.
    pub(crate) const TILES: Needs =
        Needs { per_raster_cell: 7.6, per_raster_corner: 166.0, per_footprint_cell: 0.5, ..NONE };
    /// A live page: the packed scene and its text.
    pub(crate) const LIVE: Needs =
        Needs { per_raster_cell: 13.5, per_raster_corner: 100.0, per_footprint_cell: 5.0, ..NONE };

    /// Returns the needs of zones and a file of them.
    pub(crate) fn of_zones(format: Format, grid: &GeoRef) -> Needs {
        Needs::ZONES.and(match format {
            Format::GeoJson => {
                Needs { per_raster_cell: 4.0, per_raster_corner: 1250.0, per_footprint_cell: 20.0, ..NONE }
            }
            Format::GeoTiff => Needs::per_cell(2.6),
            format if format.is_picture() => Needs::per_cell(picture_bytes_per_cell(grid.n_cells())),
            _ => NONE,
        })
    }

    /// Returns the needs of a chart: the scene once more on other cells, and masks.
    pub(crate) fn of_chart(n_uavs: usize) -> Needs {
        let n_uavs = count(n_uavs as u64);
        Needs { per_raster_cell: 2.9 + 0.66 * n_uavs, per_footprint_cell: 3.5 + 0.56 * n_uavs, ..NONE }
    }

    /// Returns the needs of a comparison: the overlay of all masks, blocks and a picture, what is
    /// found of each receiver, and `n_masks` masks and bands of differences.
    pub(crate) fn of_comparison(n_masks: usize) -> Needs {
        let of_all = Needs { per_open_cell: 34.0, ..Needs::per_cell(19.0) };
        of_all.and(Needs::per_cell(count(n_masks as u64)))
    }

    /// Returns the needs of so many bytes for each cell of any scene.
    const fn per_cell(bytes: f64) -> Needs {
        Needs { per_raster_cell: bytes, per_footprint_cell: bytes, ..NONE }
    }

    /// Returns the needs of a city in a file.
    pub(crate) fn of_city(format: Format, grid: &GeoRef) -> Needs {
        /// A picture of footprints, whatever their number.
        const SOLIDS: f64 = 76e6;
        #[expect(clippy::cast_precision_loss, reason = "an estimate")]
        let n_cells = grid.n_cells() as f64;
        match format {
            Format::GeoTiff => Needs { per_raster_cell: 11.5, per_footprint_cell: 8.5, ..NONE },
            Format::AsciiGrid => Needs { per_raster_cell: 12.0, per_footprint_cell: 10.0, ..NONE },
            Format::Mitsuba => Needs { per_footprint_cell: 5.5, ..NONE },
            format if format.is_picture() => {
                let of_raster = picture_bytes_per_cell(grid.n_cells()) + 5.0;
                Needs { per_raster_cell: of_raster, per_footprint_cell: SOLIDS / n_cells, ..NONE }
            }
            _ => Needs { per_footprint_cell: 1.8, ..NONE },
        }
    }

    /// Returns the needs of two questions at once.
    pub(crate) const fn and(self, other: Needs) -> Needs {
        Needs {
            per_raster_cell: self.per_raster_cell + other.per_raster_cell,
            per_raster_corner: self.per_raster_corner + other.per_raster_corner,
            per_open_cell: self.per_open_cell + other.per_open_cell,
            per_footprint_cell: self.per_footprint_cell + other.per_footprint_cell,
        }
    }

    /// Refuses a question over a scene, before any of its work.
    ///
    /// # Errors
    /// E501 if it takes more memory than there is or than it may take.
    pub(crate) fn check(self, scene: &Scene) -> Result<()> {
        check_bytes(&scene.word, &cells_of(scene.grid()), self.bytes(&scene.field))
    }

    /// Returns the bytes over a field.
    pub(crate) fn bytes(self, field: &HeightField) -> u64 {
        // Cells and corners are counted only if they matter.
        let of = |bytes: f64, n: &dyn Fn() -> u64| if bytes > 0.0 { bytes * count(n()) } else { 0.0 };
        let n_cells = || field.grid().n_cells() as u64;
        let of_open = of(self.per_open_cell, &|| field.cells().open.count());
        whole_bytes(match field.columns() {
            Some(_) => {
                let of_corners = of(self.per_raster_corner, &|| field.n_corners_of_cells());
                of(self.per_raster_cell, &n_cells) + of_corners + of_open
            }
            None => of(self.per_footprint_cell, &n_cells) + of_open,
        })
    }
}

#[expect(clippy::cast_precision_loss, reason = "an estimate")]
fn count(n: u64) -> f64 {
    n as f64
}

/// Returns the bytes per cell that a picture of a grid takes while it is drawn.
pub(crate) fn picture_bytes_per_cell(n_cells: usize) -> f64 {
    /// Heights and relief below a picture.
    const RELIEF: f64 = 7.2;
    /// Colors of a pixel, and how they are compressed.
    const PIXEL: f64 = 14.0;
    /// Most cells that are drawn one by one, and pixels of a picture of more.
    const PIXELS: (usize, usize) = (1 << 22, 1_800_000);
    let n_pixels = if n_cells > PIXELS.0 { PIXELS.1 } else { n_cells };
    #[expect(clippy::cast_precision_loss, reason = "an estimate")]
    let per_cell = n_pixels as f64 / n_cells.max(1) as f64;
    RELIEF + PIXEL * per_cell
}
