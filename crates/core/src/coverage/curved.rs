//! What a UAV sees over a curved earth: a raster scene with the heights that it sees, mapped as over a flat one, or footprints whose engines
//! reckon with the curve.

use std::ops::Range;
use std::sync::Arc;

use super::map::{Mapper, SiteCoverage};
use super::range::{Heights, Range as InRange};
use super::stability::ShiftedRoofs;
use super::{ExplainedLink, HeightLayers, MapOptions, ObstacleKind, ProfileStep, StepKind, Uav};
use crate::error::{MapError, Result};
use crate::height_field::{Bulge, Curvature, Drops, HeightField, Place, Prisms, Station};
use crate::los::GridReceivers;
use crate::quantity::{MAX_HEIGHT_M, STEPS_PER_UNIT, height_steps, meters};
use crate::raster::CellWindow;

/// A scene as one UAV sees it over a curved earth. In a raster all heights are lower by what the earth falls away from it; footprints and
/// receivers among them keep theirs.
#[derive(Debug)]
pub struct CurvedScene {
    field: HeightField,
    curvature: Curvature,
    /// Where the UAV is.
    place: Place,
    drops: Arc<Drops>,
    /// The cells that are as it sees them: all that matter to it.
    window: CellWindow,
}

impl CurvedScene {
    /// All of a scene as a UAV at a place sees it; `None` over a flat earth.
    ///
    /// # Errors
    /// E118 for an earth so curved that heights would leave the lattice, and for roofs that slope.
    pub fn of(field: &HeightField, place: &Place, curvature: Option<Curvature>) -> Result<Option<CurvedScene>> {
        let Some(curvature) = curvature else { return Ok(None) };
        check_roofs(field)?;
        let drops = Arc::new(Drops::new(&field.positions(), place, curvature, field.grid().meters_per_unit()));
        let window = field.grid().window();
        check_drop(drops.most_m(window), field.lowest_known())?;
        let field = field.bent(place, curvature, &drops, window);
        Ok(Some(CurvedScene { field, curvature, place: *place, drops, window }))
    }

    /// The scene as it is seen.
    pub fn field(&self) -> &HeightField {
        &self.field
    }

    /// How much lower a place is: in a raster the cell that holds it, the nearest one outside \[1/1024 m\].
    pub fn drop_at(&self, place: &Place) -> i32 {
        if self.field.prisms().is_none() {
            return self.drops.at_place(self.field.grid(), place);
        }
        let units = (place.x - self.place.x).hypot(place.y - self.place.y);
        let drop_m = self.curvature.drop_m(units * self.field.grid().meters_per_unit());
        height_steps(drop_m.min(MAX_HEIGHT_M)).unwrap_or(0)
    }

    /// By how much heights of the field are lower than above the datum at a place \[1/1024 m\]: 0 among footprints.
    pub fn lowered_by(&self, place: &Place) -> i32 {
        if self.field.prisms().is_some() { 0 } else { self.drop_at(place) }
    }

    /// An end of a link, with its height as the field tells heights.
    pub fn lowered(&self, station: &Station) -> Station {
        Station { z: station.z - i64::from(self.lowered_by(&station.place)), ..*station }
    }

    /// An end of a link as much lower as the UAV sees it.
    pub fn seen(&self, station: &Station) -> Station {
        Station { z: station.z - i64::from(self.drop_at(&station.place)), ..*station }
    }

    /// The side view of a link of some length \[m\] as the UAV sees it. Ground and roofs of footprints are curved there, which many short
    /// steps draw.
    pub fn seen_steps(&self, steps: Vec<ProfileStep>, distance_m: f64) -> Vec<ProfileStep> {
        const PARTS: f64 = 256.0;
        // A roof no longer than some of them is one step.
        const WHOLE: f64 = 4.0;
        if self.field.prisms().is_none() {
            return steps;
        }
        let lowered = |step: &ProfileStep| {
            let length = distance_m / PARTS;
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most so many parts")]
            let n = ((step.to_m - step.from_m) / length).ceil().clamp(1.0, PARTS) as u32;
            let is_whole = step.kind == StepKind::Building && step.to_m - step.from_m <= WHOLE * length;
            let n = if is_whole { 1 } else { n };
            let at = |k: u32| step.from_m + (step.to_m - step.from_m) * f64::from(k) / f64::from(n);
            let part = |k: u32| {
                let (from_m, to_m) = (at(k), at(k + 1));
                let fall_m = self.curvature.drop_m(0.5 * (from_m + to_m));
                ProfileStep { from_m, to_m, heights_m: step.heights_m.map(|m| m - fall_m), kind: step.kind }
            };
            (0..n).map(part).collect::<Vec<_>>()
        };
        steps.iter().flat_map(lowered).collect()
    }

    /// What was found of a link here, with the heights that stand in the way above the datum again, and the elevation of the UAV from the
    /// horizontal of the receiver: from there the UAV is as much lower as the receiver is from the UAV.
    pub fn raised(&self, uav: &Uav, receiver: &Station, mut link: ExplainedLink) -> ExplainedLink {
        let receiver_m = i32::try_from(receiver.z).map_or(f64::NAN, meters);
        let rise_m = uav.height_amsl_m() - receiver_m - meters(self.drop_at(&receiver.place));
        link.elevation_deg = rise_m.atan2(link.distance_m).to_degrees();
        let Some(obstacle) = &mut link.obstruction else { return link };
        if self.field.prisms().is_some() {
            // The ray sags between its ends, b·t(1 − t) with the drop b of one end from the other.
            let (from, to) = (&uav.station.place, &receiver.place);
            let (dx, dy) = (to.x - from.x, to.y - from.y);
            let t =
                ((obstacle.x - from.x) * dx + (obstacle.y - from.y) * dy) / (dx * dx + dy * dy).max(f64::MIN_POSITIVE);
            obstacle.ray_height_m -= self.curvature.drop_m(link.distance_m) * t * (1.0 - t);
        } else {
            obstacle.ray_height_m += meters(self.drop_at(&self.field.place(obstacle.x, obstacle.y)));
        }
        obstacle.top_m = obstacle.top_m.map(|top_m| match (obstacle.kind, self.field.bent_terrain()) {
            (ObstacleKind::Cell((row, col)), _) => top_m + meters(self.drops.at(row, col)),
            (ObstacleKind::Terrain(cell), Some(terrain)) => top_m + meters(terrain.drop_of(cell)),
            _ => top_m,
        });
        link
    }

    /// The scene of a mapper as a UAV sees it; `None` if it is what it is over a flat earth.
    pub(super) fn around(mapper: &Mapper<'_>, uav: &Uav) -> Option<CurvedScene> {
        let curvature = mapper.options.curvature?;
        let (drops, window) = CurvedScene::drops_around(mapper, uav, curvature)?;
        Some(CurvedScene::bent(mapper, uav, curvature, (drops, window)))
    }

    /// The scene as in [`CurvedScene::around`], if no height is bent out of the lattice.
    ///
    /// # Errors
    /// E118.
    pub(super) fn checked_around(mapper: &Mapper<'_>, uav: &Uav) -> Result<Option<CurvedScene>> {
        let Some(curvature) = mapper.options.curvature else { return Ok(None) };
        let Some((drops, window)) = CurvedScene::drops_around(mapper, uav, curvature) else { return Ok(None) };
        check_drop(drops.most_m(window), mapper.field.lowest_known())?;
        Ok(Some(CurvedScene::bent(mapper, uav, curvature, (drops, window))))
    }

    fn bent(
        mapper: &Mapper<'_>,
        uav: &Uav,
        curvature: Curvature,
        (drops, window): (Arc<Drops>, CellWindow),
    ) -> CurvedScene {
        let place = uav.station.place;
        let field = mapper.field.bent(&place, curvature, &drops, window);
        CurvedScene { field, curvature, place, drops, window }
    }

    /// The drops of the cells, and the window of those that matter to a UAV; `None` where that changes nothing.
    fn drops_around(mapper: &Mapper<'_>, uav: &Uav, curvature: Curvature) -> Option<(Arc<Drops>, CellWindow)> {
        let options = &mapper.options;
        let positions = mapper.engine.positions();
        let drops = Arc::new(Drops::new(positions, &uav.station.place, curvature, options.meters_per_unit));
        let all = mapper.field.grid().window();
        let heights = mapper.receiver_heights();
        // Receivers may be lower by as much as any cell is.
        let lowered = Heights { lowest: heights.lowest.saturating_sub(drops.most(all)), are_flat: false, ..heights };
        let window = InRange::of(positions, uav, options, lowered).window();
        // Rasters are lowered by whole steps of the lattice, prisms are exact.
        let is_flat = || mapper.field.prisms().is_none() && drops.most(window) == 0;
        (window.n_rows > 0 && window.n_cols > 0 && !is_flat()).then_some((drops, window))
    }

    /// What maps the scene that the UAV sees, with what a mapper of the scene has made ready.
    pub(super) fn mapper<'b>(&'b self, of: &'b Mapper<'_>) -> Mapper<'b> {
        let field = &self.field;
        let MapOptions { rx_height, receivers, window, radius, antenna, meters_per_unit, layers, method, .. } =
            of.options;
        // Those are told of the scene over a flat earth.
        let layers = HeightLayers { sure: false, p_los: false, ..layers };
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
            ..MapOptions::default()
        };
        // As many meters to the steps of both axes, or none.
        let (step_x, step_y) = of.engine.positions().step_lengths();
        let bulge = step_x.total_cmp(&step_y).is_eq().then(|| step_x * f64::from(STEPS_PER_UNIT) * meters_per_unit);
        let bulge = bulge.and_then(|meters_per_unit| Bulge::new(self.curvature, meters_per_unit));
        let seen = |receivers: &'b GridReceivers<'_>| match field.prisms() {
            Some(_) => receivers.borrowed(),
            None => receivers.lowered(&self.drops, self.window),
        };
        Mapper {
            field,
            engine: of.engine.over(field, bulge),
            alone: of.alone.over(field, bulge),
            why: of.why,
            receivers: of.receivers.iter().map(seen).collect(),
            xs: of.xs.clone(),
            uncertain: None,
            roofs: layers.stability.then(|| Box::new(ShiftedRoofs::of(field))),
            options,
        }
    }

    /// Brings heights of receivers of a raster back to those above the datum, in the rows of a map.
    pub(super) fn raise(&self, map: &mut SiteCoverage, rows: Range<usize>) {
        let Some(heights) = map.least_receiver_height.as_mut().filter(|_| self.field.prisms().is_none()) else {
            return;
        };
        let n_cols = self.field.grid().n_cols();
        for (row, heights) in rows.zip(heights.chunks_mut(n_cols)) {
            heights.iter_mut().enumerate().for_each(|(col, z)| *z = self.drops.raised(*z, (row, col)));
        }
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

/// Refuses an earth that falls away by so many meters that the lowest known height of a scene \[1/1024 m\] would leave the lattice.
///
/// # Errors
/// E118.
pub fn check_drop(drop_m: f64, lowest: Option<i32>) -> Result<()> {
    let is_within = drop_m <= MAX_HEIGHT_M + meters(lowest.unwrap_or(0));
    if is_within { Ok(()) } else { Err(MapError::TooCurved(drop_m).into()) }
}
