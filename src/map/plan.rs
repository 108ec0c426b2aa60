//! Plan of a map with all defaults filled in, and the map made from it in memory.

use std::sync::Arc;
use std::time::Instant;

use rayon::prelude::*;

use skyshed_request::{CoverageQuestion, Layer};

use super::coverages::Coverages;
use super::needs::{MapNeeds, overlay_bytes_per_cell};
use super::over_time::Span;
use super::report::{MapReport, MaskDigest, SiteFacts, zone_tallies};
use super::tiles::Tile;
use super::tolerance::{ToleranceFacts, check_tolerance, simplify};
use crate::answer::Output;
use crate::coverage::{
    HeightLayers, KeepMasks, ManyMaps, MapOptions, Mapper, SiteCoverage, Tally, TimeSpan, Together, Uav, maps_at_once,
};
use crate::error::{Error, Result};
use crate::expected::Expected;
use crate::height_errors::{HeightErrorsPlan, UncertainFacts};
use crate::memory::check_memory;
use crate::progress::Progress;
use crate::raster::GeoRef;
use crate::scene::Scene;
use crate::sight::{SightPlan, warn_of_no_p_los};
use crate::uav::UavsFound;
use crate::zones::ZoneMap;

/// Question of a map, with all defaults filled in.
#[derive(Debug, Clone)]
pub(crate) struct MapPlan {
    /// Receivers, range, antenna, earth and method.
    pub(crate) sight: SightPlan,
    pub(crate) layers: Vec<Layer>,
    /// Errors of heights.
    pub(crate) heights: HeightErrorsPlan,
    /// Largest error of P_LoS, if a tolerance was given.
    pub(crate) tolerance: Option<f64>,
    /// `true` if counts are reported by zone.
    pub(crate) tells_zones: bool,
    /// `true` if receivers are counted over time.
    pub(crate) over_time: bool,
}

/// Whole that the scene of a run is a part of.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct PartOf<'a> {
    /// Grid of the whole.
    pub(crate) whole: Option<&'a GeoRef>,
    /// Tile of the whole to map, with the number of UAVs in the whole list.
    pub(crate) tile: Option<(&'a Tile, usize)>,
}

/// Files that are made of masks.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct MapFiles<'a> {
    /// Rasters, pictures and tables.
    pub(crate) outputs: &'a [Output],
    /// `true` if masks become polygons.
    pub(crate) polygons: bool,
    /// `true` if there are curves of P_LoS by height.
    pub(crate) curves: bool,
    /// `true` if there are counts over time.
    pub(crate) over_time: bool,
}

/// Masks that a run of many UAVs keeps, beside the counts.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Held<'a> {
    /// `true` if each mask is kept.
    pub(crate) keeps_masks: bool,
    /// `true` if the only mask is handed over while it is made, and not kept.
    pub(crate) is_handed_over: bool,
    /// Files of the masks.
    pub(crate) files: MapFiles<'a>,
}

impl MapPlan {
    /// Checks a question and fills in its defaults.
    ///
    /// # Errors
    /// E113, E116.
    pub(crate) fn of(question: &CoverageQuestion) -> Result<MapPlan> {
        let CoverageQuestion { sight, heights, map } = question;
        map.check()?;
        let (sight, heights) = (SightPlan::of(sight)?, HeightErrorsPlan::of(heights, map.sigma)?);
        Ok(MapPlan {
            sight,
            heights,
            layers: map.wanted_layers(),
            tolerance: map.tolerance,
            tells_zones: map.zones,
            over_time: false,
        })
    }

    /// Returns the layers that are made for each UAV beside its mask.
    pub(crate) fn height_layers(&self) -> HeightLayers {
        HeightLayers {
            margin: self.layers.contains(&Layer::Margin),
            least_receiver_height: self.layers.contains(&Layer::LeastReceiverHeight),
            least_height: self.layers.contains(&Layer::LeastHeight),
            stability: self.layers.contains(&Layer::Stability),
            sure: self.layers.contains(&Layer::Sure),
            p_los: self.layers.contains(&Layer::PLos),
        }
    }

    /// Returns the sums that are made of the masks of all UAVs.
    fn together(&self, span: Option<Span>, of_list: Option<(Vec<usize>, usize)>) -> Together {
        Together {
            which: self.layers.contains(&Layer::Which),
            best_server: self.layers.contains(&Layer::BestServer),
            all: self.layers.contains(&Layer::All),
            uptime: self.layers.contains(&Layer::Uptime),
            gap: self.layers.contains(&Layer::Gap),
            time: span.map(|Span { ends_s, .. }| TimeSpan { ends_s, counts: self.over_time }),
            even_of_one: self.over_time || self.layers.iter().any(|layer| layer.is_of_all()),
            of_list,
        }
    }

    /// Returns the option that asks about time, if one does.
    pub(super) fn option_of_time(&self) -> Option<&'static str> {
        let asked = [("over_time", self.over_time), ("layers", self.layers.iter().any(|layer| layer.is_of_time()))];
        asked.into_iter().find(|(_, is_asked)| *is_asked).map(|(option, _)| option)
    }

    /// Returns the span of time that the map tells about, if it is asked about time.
    ///
    /// # Errors
    /// E116 without two moments.
    fn span(&self, found: &UavsFound) -> Result<Option<Span>> {
        let Some(option) = self.option_of_time() else { return Ok(None) };
        let why = "without times of UAVs: two at least in the columns `from` and `to` of `--uavs`";
        let (ends_s, clock) = found.span().ok_or_else(|| Error::idle(option, why))?;
        Ok(Some(Span { ends_s, clock }))
    }

    /// Returns the bytes per cell of the overlay of all masks, for a list of `n_uavs` UAVs.
    pub(crate) fn overlay_bytes_per_cell(&self, n_uavs: usize) -> f64 {
        overlay_bytes_per_cell(&self.layers, n_uavs)
    }

    /// Returns `true` if the zones of the scene are needed. A part of a scene does not know all of
    /// them.
    pub(super) fn needs_zones(&self) -> bool {
        self.tells_zones || self.sight.receivers().zone().is_some()
    }

    /// Checks the tolerance, before any work.
    ///
    /// # Errors
    /// E113, E116.
    pub(crate) fn check(&self) -> Result<()> {
        check_tolerance(self.tolerance, self.sight.method())
    }

    /// Prepares all but the engine. A raster with a radius is cut to the part in range. `part`
    /// names the whole that the scene is a part of.
    ///
    /// # Errors
    /// E2xx for UAVs that cannot be there; E113, E116, E117 for impossible requests; errors of a
    /// tolerance.
    pub(crate) fn prepare(mut self, mut scene: Scene, found: &UavsFound, part: PartOf<'_>) -> Result<Prepared> {
        self.check()?;
        let found = &*found.over(&scene.field)?;
        let span = self.span(found)?;
        self.heights = self.heights.over(&scene.field);
        let began = Instant::now();
        let grid = scene.grid().clone();
        let around = self.sight.box_in_range(&found.sites, &grid).filter(|_| !self.needs_zones());
        if let Some(around) = around.filter(|_| part.tile.is_none()) {
            scene.cut(grid.window_within(around));
        }
        let whole = part.whole.unwrap_or(&grid);
        let mut uavs = match part.tile {
            None => scene.place(found, Some(whole), &self.sight)?,
            Some(_) => scene.place_in_tile(found, whole, &self.sight)?,
        };
        let tolerance = match self.tolerance {
            Some(tolerance) => Some(simplify(&mut scene, &mut uavs, &self.sight, tolerance)?),
            None => None,
        };
        // Zones cost as much as a map: they are found only if they are reported or hold the
        // receivers.
        let zones = if self.needs_zones() { scene.zones()? } else { None };
        let options = self.sight.options(scene.grid(), zones.as_deref());
        let window = part.tile.and_then(|(tile, _)| scene.grid().window_of(&whole.part(tile.window)));
        let window = window.filter(|window| *window != scene.grid().window());
        let options = self.heights.on(&scene.field, MapOptions { layers: self.height_layers(), window, ..options });
        let lonlats = uavs.iter().map(|uav| found.lonlat_of(&uav.id)).collect();
        let tile = part.tile.map(|(tile, n_list)| {
            let numbered = found.sites.iter().zip(&tile.uavs);
            let placed = numbered.filter(|(site, _)| uavs.iter().any(|uav| uav.id == site.id));
            (Tile { uavs: placed.map(|(_, k)| *k).collect(), ..tile.clone() }, n_list)
        });
        Ok(Prepared { plan: self, scene, uavs, lonlats, zones, options, tolerance, tile, span, began })
    }
}

/// Map that is ready to be made.
#[derive(Debug)]
pub(crate) struct Prepared {
    plan: MapPlan,
    pub(crate) scene: Scene,
    uavs: Vec<Uav>,
    /// Longitude and latitude of each UAV whose position was given by these.
    lonlats: Vec<Option<[f64; 2]>>,
    zones: Option<Arc<ZoneMap>>,
    options: MapOptions,
    tolerance: Option<ToleranceFacts>,
    /// Tile to map, with the number of UAVs in the whole list.
    tile: Option<(Tile, usize)>,
    /// Span of time that the map tells about.
    span: Option<Span>,
    began: Instant,
}

impl Prepared {
    /// Counts the receivers of each UAV and the ones in line of sight, without a mask. All other
    /// counts of a tally stay 0.
    ///
    /// # Errors
    /// E118 if the method cannot decide the scene; `Interrupted`.
    pub(crate) fn count(self, progress: &Progress) -> Result<Vec<Tally>> {
        let field = Arc::clone(&self.scene.field);
        let mut mapper = Mapper::new(&field, &self.options)?;
        mapper.drop_idle(&self.uavs);
        progress.begin(self.uavs.len() as u64);
        let count = |uav: &Uav| {
            progress.control().check()?;
            let (receivers, los) = mapper.seen_from(uav)?.count();
            progress.advance();
            Ok(Tally::of_receivers(receivers, los).of_uav(uav))
        };
        let counts = self.uavs.par_iter().map(count).collect();
        progress.end();
        counts
    }

    /// Makes the map. `each_part` receives the parts of the masks in the order of the UAVs and from
    /// the north. `each` receives every map once its mask is complete.
    ///
    /// # Errors
    /// E118 if the method cannot decide the scene; E501 if the map does not fit in memory;
    /// `Interrupted`.
    pub(crate) fn run(
        self,
        held: Held<'_>,
        progress: &Progress,
        mut each_part: impl FnMut(&[u8]) + Send,
        mut each: impl FnMut(&SiteCoverage),
    ) -> Result<Coverages> {
        let Prepared { plan, mut scene, uavs, lonlats, zones, mut options, tolerance, tile, span, began } = self;
        let (keep, n_held) = match held {
            Held { is_handed_over: true, .. } => (KeepMasks::Never, 0),
            Held { keeps_masks: true, .. } => (KeepMasks::Always, uavs.len()),
            // For counts, masks are added to the overlay and dropped.
            _ => (KeepMasks::UntilTold, uavs.len().min(maps_at_once())),
        };
        let layers = options.layers;
        let needs = MapNeeds {
            n_cells: scene.grid().n_cells(),
            layers: &plan.layers,
            files: held.files,
            n_uavs: uavs.len(),
            n_list: tile.as_ref().map_or(uavs.len(), |(_, n)| *n),
            n_held,
        };
        let bytes_per_cell = needs.bytes_per_cell();
        check_memory(&scene.word, scene.grid(), bytes_per_cell)?;
        let field = Arc::clone(&scene.field);
        let mut mapper = Mapper::new(&field, &options)?.with_height_errors()?;
        let idle = mapper.drop_idle(&uavs);
        let (method, why) = mapper.method();
        Expected::over(&field, method, options.radius, (uavs.len(), layers), bytes_per_cell).tell(progress);
        scene.timing.build += began.elapsed().as_secs_f64();
        let before_los = Instant::now();
        progress.begin(field.grid().n_cells() as u64 * uavs.len() as u64);
        let shown = options.window.map_or_else(|| field.grid().clone(), |window| field.grid().part(window));
        let mut digest = MaskDigest::new(&shown);
        let mut facts: Vec<SiteFacts> = Vec::with_capacity(uavs.len());
        let each_part = |cells: &[u8]| {
            rayon::join(|| digest.add(cells), || each_part(cells));
        };
        let each_site = |site: &SiteCoverage| {
            facts.push(SiteFacts { lonlat: lonlats[facts.len()], ..SiteFacts::of(site, zones.as_deref()) });
            each(site);
        };
        let of_list = tile.as_ref().map(|(tile, n_list)| (tile.uavs.clone(), *n_list));
        let together = plan.together(span, of_list);
        let mapped = mapper.map_many(&uavs, (keep, &together), progress.control(), each_part, each_site);
        progress.end();
        let ManyMaps { sites, overlay } = mapped?;
        let intervals = plan.heights.intervals(&mapper, &uavs, progress)?;
        for (site, interval) in facts.iter_mut().zip(intervals) {
            site.uncertain = UncertainFacts::with(site.uncertain, interval);
        }
        scene.timing.los = before_los.elapsed().as_secs_f64();
        drop(mapper);
        if let Some(window) = options.window.take() {
            scene.show(window);
        }
        // A tile without P_LoS is no surprise.
        if tile.is_none() {
            let tallies = sites.iter().map(|site| (site.uav.id.as_str(), &site.tally));
            warn_of_no_p_los("UAV", tallies, &mut scene.warnings);
        }
        let only = facts.first().filter(|_| facts.len() == 1);
        let with_uavs = |tally: Tally| sites.iter().fold(tally, |tally, site| tally.of_uav(&site.uav));
        let of_union =
            |zones: &ZoneMap| overlay.as_ref().map(|overlay| zone_tallies(zones, overlay.union()).map(with_uavs));
        let report = MapReport {
            facts: scene.facts(Some(method)),
            sight: plan.sight,
            heights: plan.heights,
            union_zones: only.map_or_else(|| zones.as_deref().and_then(of_union), |only| only.zones),
            union: match (only, &overlay) {
                (Some(only), _) => only.tally,
                (None, overlay) => overlay.as_ref().map_or(Tally::default(), |o| with_uavs(Tally::of_mask(o.union()))),
            },
            sites: facts,
            tolerance,
            tile: tile.map(|(tile, _)| tile.facts(plan.layers.iter().any(|layer| layer.tells_numbers()))),
            idle: (idle.footprints > 0).then_some(idle),
            span,
            digest: digest.finish(),
        };
        Ok(Coverages { scene, sites, overlay, layers: plan.layers, report, why, options })
    }
}
