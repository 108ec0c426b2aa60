//! What a UAV sees over a curved earth: a raster scene with the heights that it sees, mapped as over a flat one.

use std::ops::Range;

use super::map::{Mapper, SiteCoverage};
use super::range::{Heights, Range as InRange};
use super::stability::ShiftedRoofs;
use super::{ExplainedLink, MapOptions, ObstacleKind, Receivers, Uav};
use crate::error::{MapError, Result};
use crate::height_field::{Curvature, Drops, HeightField, Place, Station};
use crate::los::GridReceivers;
use crate::quantity::{MAX_HEIGHT_M, meters};
use crate::raster::CellWindow;

/// A raster scene as one UAV sees it over a curved earth: all heights lowered by what the earth falls away from it.
#[derive(Debug)]
pub struct CurvedScene {
    field: HeightField,
    drops: Drops,
    /// The cells that are as it sees them: all that matter to it.
    window: CellWindow,
}

impl CurvedScene {
    /// All of a scene as a UAV at a place sees it; `None` over a flat earth, and over footprints.
    ///
    /// # Errors
    /// E118 for an earth so curved that heights would leave the lattice.
    pub fn of(field: &HeightField, place: &Place, curvature: Option<Curvature>) -> Result<Option<CurvedScene>> {
        let Some(curvature) = curvature else { return Ok(None) };
        let drops = Drops::new(&field.positions(), place, curvature, field.grid().meters_per_unit());
        let window = field.grid().window();
        check_drop(drops.most_m(window), field.lowest_known())?;
        Ok(field.bent(&drops, window).map(|field| CurvedScene { field, drops, window }))
    }

    /// The scene with its heights lowered.
    pub fn field(&self) -> &HeightField {
        &self.field
    }

    /// How much lower the cell is that holds a place, the nearest one outside \[1/1024 m\].
    pub fn drop_at(&self, place: &Place) -> i32 {
        let grid = self.field.grid();
        let x = place.x.clamp(grid.x_min(), grid.x_max() - 0.5 * grid.cell_width());
        let y = place.y.clamp(grid.y_min() + 0.5 * grid.cell_height(), grid.y_max());
        grid.cell_at(x, y).map_or(0, |(row, col)| self.drops.at(row, col))
    }

    /// An end of a link as the UAV sees it.
    pub fn lowered(&self, station: &Station) -> Station {
        Station { z: station.z - i64::from(self.drop_at(&station.place)), ..*station }
    }

    /// What was found of a link here, with the heights that stand in the way above the datum again, and the elevation of the UAV from the
    /// horizontal of the receiver: from there the UAV is as much lower as the receiver is from the UAV.
    pub fn raised(&self, uav: &Uav, receiver: &Station, mut link: ExplainedLink) -> ExplainedLink {
        let receiver_m = i32::try_from(receiver.z).map_or(f64::NAN, meters);
        let rise_m = uav.height_amsl_m() - receiver_m - meters(self.drop_at(&receiver.place));
        link.elevation_deg = rise_m.atan2(link.distance_m).to_degrees();
        if let Some(obstacle) = &mut link.obstruction {
            let drop_m = meters(self.drop_at(&self.field.place(obstacle.x, obstacle.y)));
            obstacle.ray_height_m += drop_m;
            obstacle.top_m = obstacle.top_m.map(|top_m| match obstacle.kind {
                ObstacleKind::Cell((row, col)) | ObstacleKind::Terrain((row, col)) => {
                    top_m + meters(self.drops.at(row, col))
                }
                _ => top_m,
            });
        }
        link
    }

    /// The scene of a mapper as a UAV sees it; `None` if it is what it is over a flat earth.
    pub(super) fn around(mapper: &Mapper<'_>, uav: &Uav) -> Option<CurvedScene> {
        let options = &mapper.options;
        let positions = mapper.engine.positions();
        let drops = Drops::new(positions, &uav.station.place, options.curvature?, options.meters_per_unit);
        let all = mapper.field.grid().window();
        let heights = mapper.receiver_heights();
        // Receivers may be lower by as much as any cell is.
        let lowered = Heights { lowest: heights.lowest - drops.most(all), are_flat: false, ..heights };
        let window = InRange::of(positions, uav, options, lowered).window();
        if window.n_rows == 0 || window.n_cols == 0 || drops.most(window) == 0 {
            return None;
        }
        let field = mapper.field.bent(&drops, window)?;
        Some(CurvedScene { field, drops, window })
    }

    /// What maps the scene that the UAV sees, with what a mapper of the scene has made ready.
    pub(super) fn mapper<'b>(&'b self, of: &'b Mapper<'_>) -> Mapper<'b> {
        let field = &self.field;
        let MapOptions { rx_height, receivers, window, radius, antenna, meters_per_unit, layers, method, .. } =
            of.options;
        let options = MapOptions {
            rx_height,
            receivers,
            // Receivers are within it already.
            within: None,
            window,
            radius,
            antenna,
            curvature: None,
            meters_per_unit,
            layers,
            method,
        };
        let roofs = |k: usize| match of.options.receivers {
            Receivers::Ground => false,
            Receivers::Roof => true,
            Receivers::All => k == 1,
        };
        let lowered = |(k, receivers): (usize, &'b GridReceivers<'_>)| {
            let stands_on = if roofs(k) { field.roof_of_cells() } else { field.ground_of_cells() };
            receivers.lowered(stands_on, &self.drops, self.window)
        };
        Mapper {
            field,
            engine: of.engine.over(field),
            alone: of.alone.over(field),
            why: of.why,
            receivers: of.receivers.iter().enumerate().map(lowered).collect(),
            xs: of.xs.clone(),
            roofs: layers.stability.then(|| Box::new(ShiftedRoofs::of(field))),
            options,
        }
    }

    /// Refuses what would bend heights out of the lattice.
    ///
    /// # Errors
    /// E118.
    pub(super) fn check(&self, of: &Mapper<'_>) -> Result<()> {
        check_drop(self.drops.most_m(self.window), of.field.lowest_known())
    }

    /// Brings heights of receivers back to those above the datum, in the rows of a map.
    pub(super) fn raise(&self, map: &mut SiteCoverage, rows: Range<usize>) {
        let Some(heights) = &mut map.least_receiver_height else { return };
        let n_cols = self.field.grid().n_cols();
        for (row, heights) in rows.zip(heights.chunks_mut(n_cols)) {
            heights.iter_mut().enumerate().for_each(|(col, z)| *z = self.drops.raised(*z, (row, col)));
        }
    }
}

/// Refuses an earth that falls away by so many meters that the lowest known height of a scene \[1/1024 m\] would leave the lattice.
///
/// # Errors
/// E118.
pub fn check_drop(drop_m: f64, lowest: Option<i32>) -> Result<()> {
    let is_within = drop_m <= MAX_HEIGHT_M + meters(lowest.unwrap_or(0));
    if is_within { Ok(()) } else { Err(MapError::TooCurved(drop_m).into()) }
}
