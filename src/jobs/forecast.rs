//! Estimates of time and memory of a unit of work, made without reading its ground.

use crate::expected::Expected;
use crate::los::Method;
use crate::map::{Part, Unit, Units};
use crate::memory::{ANY_WORK, whole_bytes};
use crate::raster::CellWindow;
use crate::scene::is_raster_scene;

/// Nanoseconds for each cell beside line of sight, on one core of a server of 2023. They cover
/// reading, making the field, and writing.
const NS_PER_CELL: f64 = 45.0;

/// Bytes for each cell of a tile: masks, and the overlays made of them.
const BYTES_PER_CELL_OF_TILE: f64 = 16.0;

/// Bytes for each cell that is read of a raster, and for each cell of a scene that is read as a
/// whole.
const BYTES_PER_CELL: (u64, u64) = (6, 8);

/// Returns estimates for a unit: time on one thread \[s\], and memory \[bytes\].
pub(super) fn forecast(unit: &Unit, units: &Units) -> (f64, u64) {
    let grid = &units.grid;
    let sight = &unit.job.plan.sight;
    let is_raster = is_raster_scene(&unit.job.word);
    let method = if is_raster { Method::Sweep } else { Method::Shadow };
    let disc = sight.radius_on(grid).map_or(f64::INFINITY, |r| std::f64::consts::PI * r * r);
    let in_range = disc / (grid.cell_width() * grid.cell_height());
    let cells = |window: CellWindow| window.n_rows * window.n_cols;
    let (n_cells, n_uavs) = match &unit.part {
        Part::Site(site) => {
            let around = sight.box_in_range(std::slice::from_ref(site), grid);
            (cells(around.map_or_else(|| grid.window(), |around| grid.window_within(around))), 1)
        }
        Part::Tile(tile) => (cells(grid.window_within(tile.box_with(&tile.own(&units.uavs), grid))), tile.uavs.len()),
    };
    // A tile decides no more than its own cells.
    let (most, per_told) = match &unit.part {
        Part::Site(_) => (n_cells, unit.job.bytes_per_cell(n_cells)),
        Part::Tile(tile) => {
            let of_layers = unit.job.plan.overlay_bytes_per_cell(units.uavs.sites.len());
            (cells(tile.window), BYTES_PER_CELL_OF_TILE + of_layers)
        }
    };
    #[expect(clippy::cast_precision_loss, reason = "an estimate")]
    let (n_in_range, rest) = (in_range.min(most as f64), n_cells as f64 * NS_PER_CELL * 1e-9);
    let layers = unit.job.plan.height_layers();
    let expected = Expected::of((method, 1), (n_cells, n_in_range), (n_uavs, layers), 0.0);
    let read = match is_raster {
        true => n_cells as u64 * BYTES_PER_CELL.0,
        false => grid.n_cells() as u64 * BYTES_PER_CELL.1,
    };
    (expected.seconds() + rest, read + whole_bytes(most as f64 * per_told) + ANY_WORK)
}
