//! Grid of receivers over footprints and meshes: the requested one, else the terrain's, else their
//! bounding box.

use crate::error::{Error, OptionError, ReadFault, Result, Wanted};
use crate::input::Input;
use crate::quantity::{MAX_EXTENT_UNITS, whole};
use crate::raster::{Crs, GeoRef, Raster};

/// Requested extent and cell size.
#[derive(Debug, Clone, Copy)]
pub(super) struct GridRequest {
    /// West, south, east, north \[CRS units\].
    pub(super) extent: Option<[f64; 4]>,
    /// Cell size \[m\].
    pub(super) cell_m: Option<f64>,
}

/// Returns the grid without its CRS; `bounds` are those of the data that were read.
pub(super) fn receivers_grid(
    input: &Input,
    request: GridRequest,
    terrain: Option<&Raster<i32>>,
    bounds: Option<[f64; 4]>,
    crs: Option<&Crs>,
) -> Result<GeoRef> {
    if let Some(cell) = request.cell_m
        && !(cell > 0.0 && cell.is_finite())
    {
        return Err(OptionError::Cell(cell).into());
    }
    let cell = request.cell_m.unwrap_or(1.0) / crs.map_or(1.0, Crs::meters_per_unit);
    let [west, south, east, north] = match (request.extent, terrain, bounds) {
        (Some(extent), _, _) => {
            let [west, south, east, north] = extent;
            if !(extent.iter().all(|v| v.is_finite()) && west < east && south < north) {
                return Err(OptionError::Extent(extent).into());
            }
            extent
        }
        (None, Some(terrain), _) if request.cell_m.is_none() => return Ok(terrain.georef().clone()),
        (None, Some(terrain), _) => {
            let g = terrain.georef();
            [g.x_min(), g.y_min(), g.x_max(), g.y_max()]
        }
        (None, None, Some([west, south, east, north])) => {
            let (down, up) = (|v: f64| whole(v / cell).floor() * cell, |v: f64| whole(v / cell).ceil() * cell);
            [down(west), down(south), up(east), up(north)]
        }
        (None, None, None) => return Err(Error::read(input, ReadFault::Nothing(Wanted::Extent))),
    };
    let cells = |length: f64| whole(length / cell).ceil().max(1.0);
    let (n_cols, n_rows) = (cells(east - west), cells(north - south));
    if n_cols.max(n_rows) > MAX_EXTENT_UNITS {
        return Err(Error::read(input, ReadFault::GridTooLarge(n_cols, n_rows)));
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "1 ≤ n ≤ 65536 by the checks above")]
    let (n_cols, n_rows) = (n_cols as usize, n_rows as usize);
    GeoRef::new((west, south + cell * n_rows as f64), (cell, cell), (n_rows, n_cols), None)
        .ok_or_else(|| OptionError::Extent([west, south, east, north]).into())
}
