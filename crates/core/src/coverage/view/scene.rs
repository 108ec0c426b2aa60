//! A scene's heights as one UAV sees them.

use std::sync::Arc;

use crate::coverage::Uav;
use crate::error::{MapError, Result};
use crate::height_field::{BelowUav, Curvature, Drops, HeightField, Place, Prisms, Station};
use crate::los::{GridLos, Method, link_least_step, link_los};
use crate::quantity::{MAX_HEIGHT_M, STEPS_PER_UNIT, height_steps, meters};
use crate::raster::CellWindow;

/// Scene as one UAV sees it: what questions about single links are asked of.
///
/// Over a curved earth all heights of a raster are lower by how far the earth falls away from the
/// UAV. Footprints and the receivers among them keep theirs; engines reckon with the curve.
#[derive(Debug, Clone)]
pub struct SceneView<'v> {
    pub(super) scene: &'v HeightField,
    pub(super) uav: &'v Uav,
    /// `None` where the UAV sees the scene as it is.
    pub(super) curve: Option<Arc<Curve>>,
}

/// Scene on a curved earth.
#[derive(Debug)]
pub(super) struct Curve {
    pub(super) field: HeightField,
    pub(super) curvature: Curvature,
    /// Drops of the cells of the receivers' grid.
    pub(super) drops: Arc<Drops>,
    /// Cells whose heights are lowered.
    pub(super) window: CellWindow,
}

impl<'v> SceneView<'v> {
    /// Returns a scene as a UAV sees it, flat or on a curved earth.
    ///
    /// # Errors
    /// E118 for an earth so curved that heights would leave the lattice, and for roofs that slope.
    pub fn of(scene: &'v HeightField, uav: &'v Uav, curvature: Option<Curvature>) -> Result<Self> {
        let flat = SceneView { scene, uav, curve: None };
        let Some(curvature) = curvature else { return Ok(flat) };
        check_roofs(scene)?;
        let grid = scene.grid();
        let drops = Drops::new(&scene.positions(), &uav.station.place, curvature, grid.meters_per_unit());
        flat.curved(curvature, drops, grid.window())
    }

    /// Returns the scene lowered by the drops of its cells, within a window.
    pub(super) fn curved(self, curvature: Curvature, drops: Drops, window: CellWindow) -> Result<Self> {
        check_drop(in_meters(drops.most(window)), self.scene.lowest_known())?;
        Ok(SceneView { curve: Some(self.bent(curvature, Arc::new(drops), window)), ..self })
    }

    /// Returns another scene on the same earth.
    pub(super) fn over<'x>(&self, scene: &'x HeightField) -> SceneView<'x>
    where
        'v: 'x,
    {
        let view = SceneView { scene, uav: self.uav, curve: None };
        let of = |curve: &Arc<Curve>| view.bent(curve.curvature, Arc::clone(&curve.drops), curve.window);
        SceneView { curve: self.curve.as_ref().map(of), ..view }
    }

    fn bent(&self, curvature: Curvature, drops: Arc<Drops>, window: CellWindow) -> Arc<Curve> {
        let field = self.scene.bent(&self.uav.station.place, curvature, &drops, window);
        Arc::new(Curve { field, curvature, drops, window })
    }

    /// Returns the UAV.
    pub fn uav(&self) -> &'v Uav {
        self.uav
    }

    /// Returns the scene with its heights as they are seen.
    pub fn field(&self) -> &HeightField {
        self.curve.as_ref().map_or(self.scene, |curve| &curve.field)
    }

    /// Returns heights below the UAV, over which the earth does not fall away.
    pub fn below_uav(&self) -> BelowUav {
        self.scene.below_uav(&self.uav.station.place)
    }

    /// Returns whether a receiver of [`SceneView::field`] is in line of sight, by one exact ray.
    pub(in crate::coverage) fn is_los(&self, receiver: &Station) -> bool {
        link_los(self.field(), &self.uav.station, receiver)
    }

    /// Returns the least lattice height of the UAV over its place, not below `lowest`, that sees a
    /// receiver \[1/1024 m\]; `None` where no height does.
    pub(in crate::coverage) fn least_step(&self, receiver: &Station, lowest: i64) -> Option<i64> {
        link_least_step(self.field(), &self.uav.station, receiver, lowest)
    }

    /// Returns the engine that finds least heights of the UAV at once; `None` of a raster.
    pub(in crate::coverage) fn shadows(&self) -> Option<GridLos<'_>> {
        let has_terrain = self.scene.columns().is_some();
        GridLos::new(self.field(), if has_terrain { Method::ShadowRay } else { Method::Shadow }).ok()
    }

    /// Returns the curve of the earth; `None` over a flat one.
    pub fn curvature(&self) -> Option<Curvature> {
        self.curve.as_ref().map(|curve| curve.curvature)
    }

    /// Returns the fall of the earth at a place \[1/1024 m\]: in a raster that of the cell that
    /// holds it, the nearest one outside.
    pub fn drop_at(&self, place: &Place) -> i32 {
        let Some(curve) = &self.curve else { return 0 };
        let grid = self.scene.grid();
        if self.scene.prisms().is_none() {
            return curve.drops.at_place(grid, place);
        }
        let from = &self.uav.station.place;
        let distance_m = (place.x - from.x).hypot(place.y - from.y) * grid.meters_per_unit();
        height_steps(curve.curvature.drop_m(distance_m).min(MAX_HEIGHT_M)).unwrap_or(0)
    }

    /// Returns the drop of a cell of the receivers' grid \[1/1024 m\].
    pub(in crate::coverage) fn drop_of_cell(&self, (row, col): (usize, usize)) -> i32 {
        self.curve.as_ref().map_or(0, |curve| curve.drops.at(row, col))
    }

    /// Returns the drop of a cell of the terrain below footprints \[1/1024 m\].
    pub(in crate::coverage) fn drop_of_terrain(&self, cell: (usize, usize)) -> i32 {
        self.field().bent_terrain().map_or(0, |terrain| terrain.drop_of(cell))
    }

    /// Returns how much lower than above the datum heights of [`SceneView::field`] are at a place
    /// \[1/1024 m\]: 0 among footprints.
    pub fn lowered_by(&self, place: &Place) -> i32 {
        if self.scene.prisms().is_some() { 0 } else { self.drop_at(place) }
    }

    /// Returns an end of a link at its height in [`SceneView::field`].
    pub fn lowered(&self, station: &Station) -> Station {
        Station { z: station.z - i64::from(self.lowered_by(&station.place)), ..*station }
    }

    /// Decides the link to a receiver, whose height is above the datum.
    pub fn sees(&self, receiver: &Station) -> bool {
        self.is_los(&self.lowered(receiver))
    }

    /// Returns an end of a link as much lower as the earth falls away there.
    pub fn seen(&self, station: &Station) -> Station {
        Station { z: station.z - i64::from(self.drop_at(&station.place)), ..*station }
    }
}

/// Refuses roofs that slope over a curved earth.
///
/// # Errors
/// E118.
pub(super) fn check_roofs(field: &HeightField) -> Result<()> {
    let are_sloped = field.prisms().is_some_and(Prisms::are_sloped);
    if are_sloped { Err(MapError::CurvedSlopes.into()) } else { Ok(()) }
}

/// Refuses an earth that falls away by so many meters that the lowest known height of a scene
/// \[1/1024 m\] would leave the lattice.
///
/// # Errors
/// E118.
pub fn check_drop(drop_m: f64, lowest: Option<i32>) -> Result<()> {
    let is_within = drop_m <= MAX_HEIGHT_M + meters(lowest.unwrap_or(0));
    if is_within { Ok(()) } else { Err(MapError::TooCurved(drop_m).into()) }
}

/// Returns a drop of cells in meters.
pub(super) fn in_meters(drop: i64) -> f64 {
    #[expect(clippy::cast_precision_loss, reason = "to be compared with what is far smaller")]
    let drop = drop as f64;
    drop / f64::from(STEPS_PER_UNIT)
}
