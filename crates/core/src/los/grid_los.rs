//! One UAV against a whole grid of receivers, by the engine of a method.

use std::borrow::Cow;
use std::sync::Arc;

use rayon::prelude::*;

use super::columns_ray::columns_least_height_above;
use super::curved_plateaus::CurvedPlateaus;
use super::lowest_between::with_lowest_place_between;
use super::{
    ClearProbabilities, GridHeights, GridReceivers, HeightErrors, Method, OnPlateaus, PlateauScene, ReceiverHeights,
    ShadowGrid, ShadowScene, StepLength, Swept, UavPositions, WrongMethod, columns_least_receiver_height, link_los,
    plateaus_los, r2_los, shadow_clear_probabilities, shadow_least_heights, shadow_least_receiver_heights, shadow_los,
    shadow_los_relief, step_los, sweep_los, xdraw_los,
};
use crate::height_field::{Bulge, Casters, Columns, GridPositions, HeightField, Plateaus, Prisms, Station};
use crate::quantity::LatticePoint;
use crate::raster::{BitGrid, CellWindow, set_bits};
use crate::simd::SimdLevel;

/// An engine with the solids that it works on.
#[derive(Debug, Clone)]
enum Engine<'a> {
    Ray,
    Step(&'a Columns, StepLength),
    Xdraw(&'a Columns),
    R2(&'a Columns),
    Sweep(&'a Columns),
    /// Shadows of the plateaus of columns; the sweep where those cannot decide.
    Plateaus(&'a Columns, &'a Plateaus, Cow<'a, ShadowGrid>),
    /// Bounds by the shadows of plateaus over a curved earth; the sweep or rays where the bounds
    /// differ.
    CurvedPlateaus(&'a Columns, &'a Plateaus, &'a ShadowGrid, Bulge),
    Shadow(PrismShadows<'a>),
    /// Shadows, then the sweep for the terrain below the prisms.
    ShadowSweep(PrismShadows<'a>, &'a Columns),
    /// Shadows, then rays that test both prisms and terrain.
    ShadowRay(PrismShadows<'a>),
}

/// Prisms, and the positions of receivers among them.
#[derive(Debug, Clone)]
struct PrismShadows<'a> {
    prisms: &'a Prisms,
    grid: Cow<'a, ShadowGrid>,
}

impl<'a> Engine<'a> {
    /// Makes the engine of a method over the solids of a field.
    fn new(field: &'a HeightField, method: Method, positions: &GridPositions) -> Result<Self, WrongMethod> {
        let shadows = |prisms| {
            let (xs, ys) = positions.on_prisms();
            PrismShadows { prisms, grid: Cow::Owned(ShadowGrid::new(xs, ys)) }
        };
        Ok(match (method, field.prisms(), field.columns()) {
            (Method::Ray, ..) => Engine::Ray,
            (Method::Step(length), None, Some(columns)) => Engine::Step(columns, length),
            (Method::Xdraw, None, Some(columns)) => Engine::Xdraw(columns),
            (Method::R2, None, Some(columns)) => Engine::R2(columns),
            (Method::Sweep, None, Some(columns)) => {
                // Made here once, before many threads need it.
                columns.tiles();
                Engine::Sweep(columns)
            }
            (Method::Shadow, None, Some(columns)) => match field.plateaus() {
                Some(plateaus) => {
                    let (xs, ys) = positions.on_columns();
                    Engine::Plateaus(columns, plateaus, Cow::Owned(ShadowGrid::new(xs, ys)))
                }
                // A raster that was changed may have lost its plateaus.
                None => Engine::Sweep(columns),
            },
            (Method::Shadow, Some(prisms), None) => Engine::Shadow(shadows(prisms)),
            (Method::ShadowSweep, Some(prisms), Some(columns)) if field.columns_can_be_swept() => {
                Engine::ShadowSweep(shadows(prisms), columns)
            }
            (Method::ShadowRay, Some(prisms), Some(_)) => Engine::ShadowRay(shadows(prisms)),
            (_, prisms, columns) => {
                let (why, instead) = match (prisms, columns) {
                    (Some(_), None) => ("footprints on flat ground are no raster, and have no terrain", Method::Shadow),
                    (Some(_), Some(_)) => ("footprints on terrain are no raster", Method::ShadowRay),
                    (None, _) => ("a raster has no footprints", Method::Sweep),
                };
                return Err(WrongMethod { why, instead });
            }
        })
    }
}

/// An engine prepared for a scene: work that does not depend on the UAV is done once.
#[derive(Debug, Clone)]
pub struct GridLos<'a> {
    field: &'a HeightField,
    method: Method,
    engine: Engine<'a>,
    positions: Arc<GridPositions>,
    /// The casters of shadows, if not all prisms cast. No prism left out can hide a receiver that
    /// will be asked for.
    pub(crate) casters: Option<Arc<Casters>>,
    /// The vector instructions that it uses; no result depends on them.
    pub level: SimdLevel,
    /// `true` if one thread casts shadows in one band of rows. That costs less in total if many
    /// UAVs are decided at once. No result depends on it.
    pub(crate) is_one_band: bool,
}

impl<'a> GridLos<'a> {
    /// Prepares the engine.
    ///
    /// # Errors
    /// If the method is for another kind of scene. A method from [`Method::choose`] for the field
    /// always fits.
    pub fn new(field: &'a HeightField, method: Method) -> Result<Self, WrongMethod> {
        let positions = field.positions();
        Ok(GridLos {
            field,
            method,
            engine: Engine::new(field, method, &positions)?,
            positions: Arc::new(positions),
            casters: None,
            level: SimdLevel::new(),
            is_one_band: false,
        })
    }

    /// Rebinds the engine to `field`, the scene lowered for one UAV's curved earth. `bulge` is
    /// `None` unless lattice steps are equally long along x and y.
    pub(crate) fn over<'b>(&'b self, field: &'b HeightField, bulge: Option<Bulge>) -> GridLos<'b> {
        let shadows =
            |shadows: &'b PrismShadows<'_>, prisms| PrismShadows { prisms, grid: Cow::Borrowed(&*shadows.grid) };
        let engine = match (&self.engine, field.prisms(), field.columns()) {
            (Engine::Plateaus(_, plateaus, grid), _, Some(columns)) => match bulge {
                Some(bulge) => Engine::CurvedPlateaus(columns, plateaus, grid, bulge),
                None => Engine::Sweep(columns),
            },
            (Engine::Step(_, length), _, Some(columns)) => Engine::Step(columns, *length),
            (Engine::Xdraw(_), _, Some(columns)) => Engine::Xdraw(columns),
            (Engine::R2(_), _, Some(columns)) => Engine::R2(columns),
            (Engine::Sweep(_), _, Some(columns)) => Engine::Sweep(columns),
            (Engine::Shadow(of), Some(prisms), _) => Engine::Shadow(shadows(of, prisms)),
            (Engine::ShadowSweep(of, _), Some(prisms), Some(columns)) => {
                Engine::ShadowSweep(shadows(of, prisms), columns)
            }
            (Engine::ShadowRay(of), Some(prisms), _) => Engine::ShadowRay(shadows(of, prisms)),
            _ => Engine::Ray,
        };
        let GridLos { method, level, is_one_band, ref casters, .. } = *self;
        let (positions, casters) = (Arc::clone(&self.positions), casters.clone());
        GridLos { field, method, engine, positions, casters, level, is_one_band }
    }

    /// Returns the engine's method.
    pub fn method(&self) -> Method {
        self.method
    }

    /// Returns the positions of the receivers.
    pub fn positions(&self) -> &GridPositions {
        &self.positions
    }

    /// Returns UAV positions over a grid, all at height `z` \[1/1024 m above the datum\], for some
    /// receivers.
    ///
    /// Returns `None` unless the engine is `shadow` over prisms alone, or over plateaus that act on
    /// these receivers like prisms.
    pub(crate) fn uav_positions<'b>(
        &'b self,
        grid: &'b ShadowGrid,
        z: i64,
        receivers: &[GridReceivers<'_>],
    ) -> Option<UavPositions<'b>> {
        let prisms = match &self.engine {
            Engine::Shadow(PrismShadows { prisms, .. }) if prisms.earth().is_none() => *prisms,
            Engine::Plateaus(_, plateaus, _)
                if receivers.iter().all(|r| r.level().is_some_and(|level| r.stand_beside(plateaus, level, z))) =>
            {
                plateaus.prisms()
            }
            _ => return None,
        };
        let casters = self.casters.as_deref().unwrap_or(prisms.casters());
        Some(UavPositions { prisms, casters, grid, z, level: self.level })
    }

    /// Returns the number of casters, if the engine is `shadow` over prisms alone, or over plateaus
    /// on a flat earth.
    pub(crate) fn n_casters(&self) -> Option<usize> {
        let prisms = match &self.engine {
            Engine::Shadow(PrismShadows { prisms, .. }) => *prisms,
            Engine::Plateaus(_, plateaus, _) => plateaus.prisms(),
            _ => return None,
        };
        Some(self.casters.as_deref().unwrap_or(prisms.casters()).all().len())
    }

    /// Returns a station on the lattice of the casters.
    pub(crate) fn on_shadows(&self, station: &Station) -> LatticePoint {
        if self.field.prisms().is_some() { station.on_prisms() } else { station.on_columns() }
    }

    /// Returns the receivers of `wanted` that are in line of sight of a UAV.
    ///
    /// `wanted` are some of the cells of `receivers`. `window` holds them, together with all cells
    /// between them and the UAV.
    pub fn los(&self, uav: &Station, receivers: &GridReceivers<'_>, wanted: &BitGrid, window: CellWindow) -> BitGrid {
        match &self.engine {
            Engine::Ray => {
                // Lowered once, since all receivers need them.
                if let Some(columns) = self.field.columns() {
                    columns.tops();
                }
                self.by_rays(uav, receivers, wanted)
            }
            Engine::Step(columns, length) => self.by_links(receivers, wanted, |_, receiver| {
                step_los(columns, uav.on_columns(), receiver.on_columns(), *length)
            }),
            Engine::Xdraw(columns) => xdraw_los(columns, uav.on_columns(), &receivers.heights(), wanted, window),
            Engine::R2(columns) => r2_los(columns, uav.on_columns(), &receivers.heights(), wanted, window),
            Engine::Sweep(columns) => self.by_sweep(columns, uav, receivers, wanted, window),
            Engine::Plateaus(columns, plateaus, grid) => match on_plateaus(columns, plateaus, uav, receivers) {
                Some(on_plateaus) => {
                    let n_bands = self.n_bands();
                    let scene = PlateauScene { columns, plateaus, grid, wanted, window, level: self.level, n_bands };
                    plateaus_los(&scene, uav.on_columns(), on_plateaus)
                }
                None => self.by_sweep(columns, uav, receivers, wanted, window),
            },
            Engine::CurvedPlateaus(columns, plateaus, grid, bulge) => {
                let plateaus =
                    CurvedPlateaus { plateaus, bulge: *bulge, grid, level: self.level, n_bands: self.n_bands() };
                self.by_curved_plateaus(&plateaus, columns, uav, receivers, (wanted, window))
            }
            Engine::Shadow(shadows) => self.by_shadows(shadows, uav, receivers, wanted),
            // Receivers that the prisms hide are not tested against the terrain.
            Engine::ShadowSweep(shadows, columns) => {
                let left = self.by_shadows(shadows, uav, receivers, wanted);
                self.by_sweep(columns, uav, receivers, &left, window)
            }
            Engine::ShadowRay(shadows) => {
                let left = self.by_shadows(shadows, uav, receivers, wanted);
                self.by_rays(uav, receivers, &left)
            }
        }
    }

    /// Returns the number of bands of rows that are processed in parallel.
    fn n_bands(&self) -> usize {
        if self.is_one_band { 1 } else { rayon::current_num_threads() }
    }

    fn by_rays(&self, uav: &Station, receivers: &GridReceivers<'_>, wanted: &BitGrid) -> BitGrid {
        self.by_links(receivers, wanted, |field, receiver| link_los(field, uav, receiver))
    }

    /// Returns the wanted receivers for which `is_los` holds, each decided alone.
    fn by_links(
        &self,
        receivers: &GridReceivers<'_>,
        wanted: &BitGrid,
        is_los: impl Fn(&HeightField, &Station) -> bool + Sync,
    ) -> BitGrid {
        let mut los = wanted.clone();
        let (per_row, n_cols) = (wanted.words_per_row(), wanted.n_cols());
        los.words_mut().par_chunks_mut(per_row).enumerate().for_each(|(row, los)| {
            for col in set_bits(wanted.row(row)) {
                let receiver =
                    Station { place: self.positions.center(row, col), z: receivers.height(row * n_cols + col) };
                if !is_los(self.field, &receiver) {
                    los[col / 64] &= !(1 << (col % 64));
                }
            }
        });
        los
    }

    /// Returns the receivers of `wanted` that are in line of sight, and over each wanted cell the
    /// least height of a receiver that is. That height is given as far as it is above the
    /// receivers' base.
    ///
    /// Returns `None` if the engine has no faster way than
    /// [`link_least_receiver_heights`](super::link_least_receiver_heights) for each.
    pub fn los_and_least_heights(
        &self,
        uav: &Station,
        receivers: &GridReceivers<'_>,
        wanted: &BitGrid,
        window: CellWindow,
    ) -> Option<(BitGrid, GridHeights)> {
        let lowest = i64::from(receivers.range.0);
        let swept = |columns| {
            let swept = self.sweep(columns, uav, receivers, (wanted, window), Some(lowest));
            Some((swept.los, GridHeights::exact(swept.least_heights?, wanted.n_cols())))
        };
        let cast = |shadows: &PrismShadows<'_>| {
            // On a curved earth shadows do not end in planes.
            if shadows.prisms.earth().is_some() {
                return None;
            }
            let heights = shadow_least_receiver_heights(&self.all_casters(shadows, wanted), uav.on_prisms(), lowest)?;
            Some((self.by_shadows(shadows, uav, receivers, wanted), heights))
        };
        match &self.engine {
            Engine::Sweep(columns) | Engine::Plateaus(columns, ..) | Engine::CurvedPlateaus(columns, ..) => {
                swept(columns)
            }
            Engine::Shadow(shadows) => cast(shadows),
            Engine::ShadowSweep(shadows, columns) => {
                let ((past_prisms, cast), (past_columns, swept)) = (cast(shadows)?, swept(columns)?);
                Some((past_prisms.and(&past_columns), cast.or_higher(&swept)))
            }
            Engine::ShadowRay(shadows) => {
                let (past_prisms, mut heights) = cast(shadows)?;
                self.raise_past_columns(&mut heights, wanted, |columns, (row, col), _| {
                    let receiver = Station { place: self.positions.center(row, col), z: 0 }.on_columns();
                    columns_least_receiver_height(columns, uav.on_columns(), receiver).height_steps()
                });
                Some((self.by_rays(uav, receivers, &past_prisms), heights))
            }
            _ => None,
        }
    }

    /// Returns the probability that the receiver of each of some cells is in line of sight, for
    /// errors of building heights.
    ///
    /// The `deviations` are the standard deviations of each building's own error and of the shared
    /// error \[1/1024 m\]. Returns `None` if the engine has no faster way than a walk along each
    /// link.
    pub(crate) fn clear_probabilities(
        &self,
        uav: &Station,
        receivers: &GridReceivers<'_>,
        cells: &BitGrid,
        errors: &HeightErrors,
    ) -> Option<ClearProbabilities> {
        let Engine::Shadow(shadows) = &self.engine else { return None };
        let scene = self.all_casters(shadows, cells);
        shadow_clear_probabilities(&scene, uav.on_prisms(), &height_by_cell(receivers), errors)
    }

    /// Returns the least height of the UAV over its place that sees the receiver of each wanted
    /// cell. It holds as far as it is above `from` \[1/1024 m above the datum\]. `height(row, col)`
    /// is the receiver's height.
    ///
    /// Returns `None` if the engine has no faster way than a walk along each link.
    pub fn least_uav_heights(
        &self,
        uav: &Station,
        wanted: &BitGrid,
        from: i64,
        height: &(impl Fn(usize, usize) -> i32 + Sync),
    ) -> Option<GridHeights> {
        let (Engine::Shadow(shadows) | Engine::ShadowSweep(shadows, _) | Engine::ShadowRay(shadows)) = &self.engine
        else {
            return None;
        };
        if shadows.prisms.earth().is_some() {
            return None;
        }
        let mut heights = shadow_least_heights(&self.all_casters(shadows, wanted), uav.on_prisms(), from, height)?;
        self.raise_past_columns(&mut heights, wanted, |columns, (row, col), known| {
            let receiver = Station { place: self.positions.center(row, col), z: i64::from(height(row, col)) };
            #[expect(clippy::cast_possible_truncation, reason = "far from all heights, if not exact")]
            let floor = from.max(known.clamp(-1e12, 1e12) as i64);
            columns_least_height_above(columns, uav.on_columns(), receiver.on_columns(), floor).height_steps()
        });
        Some(heights)
    }

    /// Raises heights past prisms to those past the columns, if there are any.
    fn raise_past_columns(
        &self,
        heights: &mut GridHeights,
        wanted: &BitGrid,
        past: impl Fn(&Columns, (usize, usize), f64) -> f64 + Sync,
    ) {
        if let Some(columns) = self.field.columns() {
            heights.raise(wanted, &|cell, known| past(columns, cell, known));
        }
    }

    /// Makes a scene of some cells in which all prisms cast shadows.
    fn all_casters<'b>(&self, shadows: &'b PrismShadows<'_>, wanted: &'b BitGrid) -> ShadowScene<'b> {
        let PrismShadows { prisms, grid } = shadows;
        ShadowScene { prisms, casters: prisms.casters(), grid, wanted, level: self.level, n_bands: self.n_bands() }
    }

    /// Decides by shadows where they bound what the columns hide, and by the columns elsewhere.
    fn by_curved_plateaus(
        &self,
        plateaus: &CurvedPlateaus<'_>,
        columns: &Columns,
        uav: &Station,
        receivers: &GridReceivers<'_>,
        (wanted, window): (&BitGrid, CellWindow),
    ) -> BitGrid {
        let bounds = receivers
            .level_over_flat_earth()
            .filter(|z| receivers.stand_beside(plateaus.plateaus, *z, uav.z))
            .and_then(|z| plateaus.bounds(uav.on_columns(), z, (wanted, window)));
        let Some((surely, perhaps)) = bounds else { return self.by_sweep(columns, uav, receivers, wanted, window) };
        let doubts = perhaps.and(&surely.complement());
        // A ray takes about as long as the sweep of a row.
        let los = if doubts.count() < window.n_rows as u64 {
            self.by_rays(uav, receivers, &doubts)
        } else {
            self.by_sweep(columns, uav, receivers, &doubts, window)
        };
        los.or(&surely)
    }

    fn by_sweep(
        &self,
        columns: &Columns,
        uav: &Station,
        receivers: &GridReceivers<'_>,
        wanted: &BitGrid,
        window: CellWindow,
    ) -> BitGrid {
        self.sweep(columns, uav, receivers, (wanted, window), None).los
    }

    fn sweep(
        &self,
        columns: &Columns,
        uav: &Station,
        receivers: &GridReceivers<'_>,
        (wanted, window): (&BitGrid, CellWindow),
        heights_from: Option<i64>,
    ) -> Swept {
        let seen = self.field.bent_terrain().map(|terrain| receivers.seen_on_columns(&terrain.receiver_drops));
        let receivers = seen.as_ref().unwrap_or(receivers);
        let (lowest, highest) = receivers.range;
        let above = receivers.above;
        let heights = match receivers.bases() {
            base if lowest < highest => {
                let tiles = (!base.is(&columns.seen_tops())).then(|| receivers.tiles());
                ReceiverHeights::Over { base, above, lowest, highest, tiles }
            }
            _ => ReceiverHeights::Flat(lowest + above),
        };
        sweep_los(columns, uav.on_columns(), heights, wanted, window, heights_from, self.level)
    }

    fn by_shadows(
        &self,
        shadows: &PrismShadows<'_>,
        uav: &Station,
        receivers: &GridReceivers<'_>,
        wanted: &BitGrid,
    ) -> BitGrid {
        let casters = self.casters.as_deref().unwrap_or(shadows.prisms.casters());
        let scene = ShadowScene { casters, ..self.all_casters(shadows, wanted) };
        if let Some(earth) = shadows.prisms.earth()
            && let Some(between) = with_lowest_place_between(&scene, earth, uav.on_prisms(), receivers)
        {
            let others = wanted.clone().and(&between.complement());
            let asked = self.by_rays(uav, receivers, &between);
            return self.by_shadows(shadows, uav, receivers, &others).or(&asked);
        }
        // On a curved earth outlines hold for receivers below the UAV only.
        let is_outlined = |z: &i64| shadows.prisms.earth().is_none() || *z < uav.z;
        match receivers.level().filter(is_outlined) {
            Some(z) => shadow_los(&scene, uav.on_prisms(), z).los,
            None => shadow_los_relief(&scene, uav.on_prisms(), &height_by_cell(receivers)).los,
        }
    }
}

/// Returns heights of receivers by row and column \[1/1024 m above the datum\].
pub(crate) fn height_by_cell(receivers: &GridReceivers<'_>) -> impl Fn(usize, usize) -> i32 + Sync {
    let n_cols = receivers.cells.n_cols();
    move |row, col| receivers.base(row * n_cols + col) + receivers.above
}

/// Returns the receivers' positions on plateaus; `None` if the plateaus' shadows cannot decide
/// them.
fn on_plateaus(
    columns: &Columns,
    plateaus: &Plateaus,
    uav: &Station,
    receivers: &GridReceivers<'_>,
) -> Option<OnPlateaus> {
    let on_plateaus = match receivers.level() {
        Some(z) => OnPlateaus::Level(z),
        None => receivers.is_on_tops_of(columns).then_some(OnPlateaus::Above(receivers.above))?,
    };
    // Outside the raster a UAV may be below all of it.
    let lowest = uav.z.min(i64::from(receivers.range.0) + i64::from(receivers.above));
    (lowest >= i64::from(plateaus.lowest())).then_some(on_plateaus)
}
