//! What is asked of a map, and the map.

use std::time::Instant;

use super::coverages::Coverages;
use super::expected::Expected;
use super::receivers::{Asked, Receivers, check_receivers, warn_of_no_receivers};
use super::tolerance::{check_tolerance, simplify};
use crate::coverage::{HeightLayers, KeepMasks, ManyMaps, MapOptions, Mapper, SiteCoverage, Tally, Uav, maps_at_once};
use crate::error::{Error, Result};
use crate::export::Layer;
use crate::height_field::HeightField;
use crate::los::{Method, MethodChoice};
use crate::memory::{FIELD_BYTES_PER_CELL, check_memory};
use crate::progress::Progress;
use crate::quantity::height_steps;
use crate::raster::GeoRef;
use crate::report::{MapReport, MaskDigest, SiteFacts, ToleranceFacts, zone_tallies};
use crate::scene::Scene;
use crate::scene::limits::warn_of_flat_earth;
use crate::scene::outside::{place_uav, warn_of_uavs_outside};
use crate::uav::UavsFound;
use crate::zones::ZoneMap;

/// What is asked of a map, with all defaults filled in.
#[derive(Debug, Clone)]
pub(crate) struct MapPlan {
    /// Which cells hold receivers.
    pub(crate) receivers: Receivers,
    /// Their height above ground or roof \[m\].
    pub(crate) rx_height_m: f64,
    /// Range \[m\], if it is limited.
    pub(crate) radius_m: Option<f64>,
    pub(crate) method: MethodChoice,
    pub(crate) layers: Vec<Layer>,
    /// How far P_LoS may be off.
    pub(crate) tolerance: Option<f64>,
    /// Whether counts are told by zone.
    pub(crate) tells_zones: bool,
}

impl Default for MapPlan {
    /// Receivers 1.5 m above open ground at any distance, by the fastest exact engine; the mask alone.
    fn default() -> Self {
        MapPlan {
            receivers: Receivers::Ground,
            rx_height_m: 1.5,
            radius_m: None,
            method: MethodChoice::Auto,
            layers: vec![Layer::Los],
            tolerance: None,
            tells_zones: false,
        }
    }
}

/// How much of a run of many UAVs is held, beside the counts.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Held {
    /// Whether each mask is kept.
    pub(crate) keeps_masks: bool,
    /// Whether the only mask is handed over while it is made, and not kept.
    pub(crate) is_handed_over: bool,
    /// Bytes that what is made of the masks takes for each cell.
    pub(crate) bytes_per_cell: usize,
}

impl MapPlan {
    /// The layers that are made for each UAV beside its mask.
    fn height_layers(&self) -> HeightLayers {
        HeightLayers {
            margin: self.layers.contains(&Layer::Margin),
            least_receiver_height: self.layers.contains(&Layer::LeastReceiverHeight),
            least_height: self.layers.contains(&Layer::LeastHeight),
            stability: self.layers.contains(&Layer::Stability),
        }
    }

    /// The receivers' height on the lattice \[1/1024 m\].
    ///
    /// # Errors
    /// E113 for a height out of range.
    pub(crate) fn rx_height(&self) -> Result<i32> {
        receiver_height(self.rx_height_m)
    }

    /// Checks the numbers, before any work.
    ///
    /// # Errors
    /// E113, E116.
    pub(crate) fn check(&self) -> Result<()> {
        self.rx_height()?;
        checked_radius(self.radius_m)?;
        check_tolerance(self.tolerance, self.method)
    }

    /// Makes all ready but the engine. `whole` is the grid that the scene is a part of.
    ///
    /// # Errors
    /// E2xx for UAVs that cannot be there; E113, E116, E117 for what cannot be asked; those of a tolerance.
    pub(crate) fn prepare(self, mut scene: Scene, found: UavsFound, whole: Option<&GeoRef>) -> Result<Prepared> {
        self.check()?;
        let rx_height = self.rx_height()?;
        let UavsFound { sites, sources, warnings } = found;
        scene.sources.extend(sources);
        scene.warnings.extend(warnings);
        let whole = whole.unwrap_or(scene.grid()).clone();
        warn_of_uavs_outside(&sites, &whole, &mut scene.warnings);
        let began = Instant::now();
        let radius = self.radius_m.map(|r| scene.crs_units(r));
        let place = |site| place_uav(site, &scene.field, &whole, radius);
        let mut uavs: Vec<Uav> = sites.iter().map(|site| place(&site.site)).collect::<Result<_>>()?;
        check_receivers(self.receivers, &scene.field)?;
        let asked = Asked { receivers: self.receivers, rx_height, radius, method: self.method };
        let tolerance = match self.tolerance {
            Some(tolerance) => Some(simplify(&mut scene, &mut uavs, &asked, tolerance)?),
            None => None,
        };
        // Zones cost as much as a map: they are found where they are told, or hold the receivers.
        let zones = if self.tells_zones || self.receivers.zone().is_some() { scene.zones() } else { None };
        warn_of_flat_earth(&uavs, scene.field.grid(), radius, &mut scene.warnings);
        let options = MapOptions { layers: self.height_layers(), ..asked.options(scene.grid(), zones.as_ref()) };
        let lonlats = sites.iter().map(|site| site.lonlat).collect();
        Ok(Prepared { plan: self, scene, uavs, lonlats, zones, options, tolerance, began })
    }
}

/// A receiver height on the lattice.
pub(crate) fn receiver_height(meters: f64) -> Result<i32> {
    height_steps(meters)
        .filter(|h| *h >= 0)
        .ok_or_else(|| Error::usage(113, format!("`--rx-height` is `{meters}`, wanted 0 m to 32768 m")))
}

/// A range in meters: above zero.
pub(crate) fn checked_radius(radius: Option<f64>) -> Result<Option<f64>> {
    match radius {
        Some(r) if r <= 0.0 => Err(Error::usage(113, format!("`--radius` is `{r}`, wanted above 0 m"))),
        other => Ok(other),
    }
}

/// What all masks laid over each other take for each cell.
const OVERLAY_BYTES_PER_CELL: usize = 5;

/// A map that is ready to be made.
#[derive(Debug)]
pub(crate) struct Prepared {
    plan: MapPlan,
    pub(crate) scene: Scene,
    uavs: Vec<Uav>,
    /// Longitudes and latitudes of the UAVs that were given by these.
    lonlats: Vec<Option<[f64; 2]>>,
    zones: Option<ZoneMap>,
    options: MapOptions,
    tolerance: Option<ToleranceFacts>,
    began: Instant,
}

impl Prepared {
    /// Makes the map: `each_part` is given one part of the masks after another, in the order of the UAVs and from the north,
    /// and `each` every map once its mask is complete.
    ///
    /// # Errors
    /// E118 if the method cannot decide the scene; E501 if the map does not fit in memory; `Interrupted`.
    pub(crate) fn run(
        self,
        held: Held,
        progress: &Progress,
        mut each_part: impl FnMut(&[u8]) + Send,
        mut each: impl FnMut(&SiteCoverage),
    ) -> Result<Coverages> {
        let Prepared { plan, mut scene, uavs, lonlats, zones, options, tolerance, began } = self;
        let n_measures = plan.layers.iter().filter(|layer| layer.is_measure()).count();
        let (keep, n_held) = match held {
            Held { is_handed_over: true, .. } => (KeepMasks::Never, 0),
            Held { keeps_masks: true, .. } => (KeepMasks::Always, uavs.len()),
            // For counts masks are laid over each other and dropped.
            _ => (KeepMasks::UntilTold, uavs.len().min(maps_at_once())),
        };
        let bytes_per_cell = n_held
            .saturating_mul(1 + 4 * n_measures)
            .saturating_add(if uavs.len() > 1 { OVERLAY_BYTES_PER_CELL } else { 0 })
            .saturating_add(held.bytes_per_cell)
            .saturating_add(if options.layers.stability { 2 * FIELD_BYTES_PER_CELL } else { 0 });
        check_memory(&scene.word, scene.grid(), bytes_per_cell)?;
        let field = std::sync::Arc::clone(&scene.field);
        let mut mapper = Mapper::new(&field, &options)?;
        let idle = mapper.drop_idle(&uavs);
        let (method, why) = mapper.method();
        let expected = expected((&field, method), plan.radius_m, (uavs.len(), n_measures), bytes_per_cell);
        expected.words().iter().for_each(|words| (progress.note)(words));
        scene.timing.build += began.elapsed().as_secs_f64();
        let before_los = Instant::now();
        progress.begin(field.grid().n_cells() as u64 * uavs.len() as u64);
        let mut digest = MaskDigest::new(field.grid());
        let mut facts: Vec<SiteFacts> = Vec::with_capacity(uavs.len());
        let each_part = |cells: &[u8]| {
            rayon::join(|| digest.add(cells), || each_part(cells));
        };
        let each_site = |site: &SiteCoverage| {
            facts.push(SiteFacts { lonlat: lonlats[facts.len()], ..SiteFacts::of(site, zones.as_ref()) });
            each(site);
        };
        let mapped = mapper.map_many(&uavs, keep, progress.control(), each_part, each_site);
        progress.end();
        let ManyMaps { sites, overlay } = mapped?;
        scene.timing.los = before_los.elapsed().as_secs_f64();
        warn_of_no_receivers(&sites, &mut scene.warnings);
        let only = facts.first().filter(|_| overlay.is_none());
        let of_union = |zones: &ZoneMap| overlay.as_ref().map(|overlay| zone_tallies(zones, overlay.union()));
        let report = MapReport {
            facts: scene.facts(Vec::new(), Some(method)),
            rx_height_m: plan.rx_height_m,
            receivers: plan.receivers.name(),
            radius_m: plan.radius_m,
            union_zones: only.map_or_else(|| zones.as_ref().and_then(of_union), |only| only.zones),
            union: match (only, &overlay) {
                (Some(only), _) => only.tally,
                (None, overlay) => overlay.as_ref().map_or(Tally::default(), |o| Tally::of_mask(o.union())),
            },
            sites: facts,
            tolerance,
            idle: (idle.footprints > 0).then_some(idle),
            digest: digest.finish(),
        };
        drop(mapper);
        let (layers, receivers) = (plan.layers, plan.receivers);
        Ok(Coverages { scene, sites, overlay, layers, receivers, report, why, options })
    }
}

/// What a map will take.
fn expected(
    (field, method): (&HeightField, Method),
    radius_m: Option<f64>,
    numbers: (usize, usize),
    bytes_per_cell: usize,
) -> Expected {
    let grid = field.grid();
    let radius = radius_m.map_or(f64::INFINITY, |r| r / grid.meters_per_unit());
    let disc = std::f64::consts::PI * radius * radius;
    #[expect(clippy::cast_precision_loss, reason = "an estimate")]
    let n_in_range = (disc / (grid.cell_width() * grid.cell_height())).min(grid.n_cells() as f64);
    Expected::of((method, rayon::current_num_threads()), (grid.n_cells(), n_in_range), numbers, bytes_per_cell)
}
