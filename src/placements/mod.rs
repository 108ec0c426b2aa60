//! Placement of UAVs: candidates are ranked, refined, or chosen together with a bound on the
//! optimum.

mod document;
mod heat_map;
mod inputs;
mod plan;
mod report;
mod request;
mod search;
mod winner_map;
mod words;

use std::path::{Path, PathBuf};
use std::time::Instant;

use serde_json::Value;

pub(crate) use document::{PlaceRow, SearchDocument};
use inputs::Inputs;
use plan::CandidatesFrom;
pub(crate) use plan::SearchPlan;
use report::{PlaceFacts, PlaceReport, place_digest};
pub use request::PlacementsRequest;
use search::{Found, Search};

use skyshed_request::{Measure, TiffLayout, Whom};

use crate::answer::{Answer, CommandFacts, Rows, RunFacts, Spent, encoded};
use crate::coverage::{Control, KeepMasks, ManyMaps, MapOptions, Mapper, Receivers, Together, Uav, UavGrid};
use crate::earth::check_earth;
use crate::error::{RequestError, Result, Warning};
use crate::expected::Expected;
use crate::export::{Batch, Format};
use crate::formats::{Bands, GeoTiffImage, encode_geotiff};
use crate::height_errors::HeightsOfDifference;
use crate::memory::check_memory;
use crate::picture::Look;
use crate::placement::{Candidates, PlaceGrid, Weights};
use crate::progress::Progress;
use crate::scene::Scene;
use crate::sight::check_receivers;
use crate::words::pretty;
use crate::zones::{Zone, ZoneMap};

/// Output formats of a search.
pub(crate) const FORMATS: [Format; 8] = [
    Format::Png,
    Format::Svg,
    Format::Pdf,
    Format::GeoTiff,
    Format::Csv,
    Format::Json,
    Format::GeoJson,
    Format::Stdout,
];

/// Nodata value of rasters.
const NODATA: f32 = -9999.0;

/// Estimated memory of a candidate and its results \[bytes\].
const CANDIDATE_BYTES: usize = 400;

/// Ranked places for a UAV, with the value of each.
///
/// ```
/// use skyshed::prelude::*;
///
/// let city = Scene::options().size(200.0).open("itu:urban")?;
/// let places = city.placements([Height::agl(60.0), Height::agl(100.0)]).step(40.0).run()?;
/// let best = places.best().expect("there are streets");
/// assert!(places.share(best).is_some_and(|p_los| p_los > 0.3));
/// # Ok::<(), skyshed::Error>(())
/// ```
#[derive(Debug)]
pub struct Placements {
    scene: Scene,
    report: PlaceReport,
    over: Vec<Zone>,
    /// Grid of the candidates; `None` if they come from a file.
    places: Option<PlaceGrid>,
    /// Places and the value that the heat map shows there.
    heat: Vec<(usize, f32)>,
    /// File for a map of the winners' coverage; `None` if none was requested.
    map: Option<PathBuf>,
    winner_maps: Option<ManyMaps>,
}

impl SearchPlan {
    /// Returns the memory of a search over some candidates \[bytes per cell\].
    fn bytes_per_cell(&self, inputs: &Inputs, n_uavs: usize, n_cells: usize) -> f64 {
        let sets = if self.count > 1 { n_uavs.saturating_mul(n_cells.div_ceil(8)) } else { 0 };
        let (held, of_place) = match &inputs.weights {
            Some(_) => (Weights::BYTES_PER_CELL, UavGrid::BYTES_PER_WEIGHED_PLACE_AND_THREAD),
            None => (0, UavGrid::BYTES_PER_PLACE_AND_THREAD),
        };
        let of_candidate = CANDIDATE_BYTES + of_place * rayon::current_num_threads();
        #[expect(clippy::cast_precision_loss, reason = "an estimate")]
        let per_cell = held as f64 + (sets + n_uavs.saturating_mul(of_candidate)) as f64 / n_cells as f64;
        per_cell
    }

    /// Runs the search.
    ///
    /// # Errors
    /// Errors of reading the files; E108, E113 and E116 as [`SearchPlan::check`]; E117 if the scene
    /// is only a surface model and the search needs zones or ground; E209 without a candidate;
    /// E501, E502.
    pub(crate) fn search(&self, mut scene: Scene, command: CommandFacts, progress: &Progress) -> Result<Placements> {
        self.check()?;
        self.check_heights(self.height_errors.over(&scene.field))?;
        let asked = self.sight.receivers();
        let needs_zones = !self.over.is_empty() || matches!(self.goal.whom, Whom::Zone(_)) || asked.zone().is_some();
        if scene.field.is_surface_only() && needs_zones {
            return Err(RequestError::NoZones.into());
        }
        check_receivers(asked, scene.field.is_surface_only())?;
        let zones = scene.zones()?;
        let mut warnings = Vec::new();
        let inputs = Inputs::read(self, &scene, &mut warnings)?;
        scene.warnings.append(&mut warnings);
        scene.sources.extend(inputs.sources.iter().cloned());
        let radius = self.sight.radius_on(scene.grid());
        let over = zones.as_deref().map(|zones| (self.over.as_slice(), zones));
        let rules = inputs.rules(over, self.clearance()?, radius);
        let candidates = inputs.candidates(&scene.field, &rules)?;
        // The corner candidates see farthest.
        let farthest: Vec<Uav> =
            candidates.kept.first().iter().chain(&candidates.kept.last()).map(|c| c.uav.clone()).collect();
        check_earth(&farthest, &scene.field, &self.sight, &mut scene.warnings)?;
        let options = self.options(&scene, zones.as_deref(), &inputs);
        let n_uavs = candidates.kept.len();
        let per_cell = self.bytes_per_cell(&inputs, n_uavs, scene.grid().n_cells());
        check_memory(&scene.word, scene.grid(), per_cell)?;
        let field = std::sync::Arc::clone(&scene.field);
        let mapper = Mapper::new(&field, &options)?;
        let expected = Expected::over(&field, mapper.method().0, radius, (n_uavs, options.layers), per_cell);
        let search = Search {
            plan: self,
            field: &field,
            rules: &rules,
            candidates: &candidates,
            mapper: &mapper,
            weights: inputs.weights.as_ref(),
            places: inputs.places.as_ref(),
            sites: &inputs.sites,
        };
        expected.with_cpu_seconds(search.cpu_seconds()).tell(progress);
        let before_los = Instant::now();
        let Found { mut ranked, winner, refined, several, heat, winners } = search.run(progress)?;
        self.compare_heights(&mut ranked, &candidates, &mapper, progress)?;
        scene.timing.los = before_los.elapsed().as_secs_f64();
        let winner_maps = match self.map.is_some() && !winners.is_empty() {
            true => Some(mapper.map_many(
                &named(winners),
                (KeepMasks::Always, &Together::default()),
                &Control::default(),
                |_| {},
                |_| {},
            )?),
            false => None,
        };
        let report = PlaceReport {
            facts: RunFacts { command, ..scene.facts(Some(mapper.method().0)) },
            sight: self.sight.with_receivers(self.goal.receivers(asked)),
            goal: self.goal.clone(),
            height_errors: self.height_errors.over(&field),
            step_m: match self.from {
                CandidatesFrom::Grid { step_m } => Some(step_m),
                CandidatesFrom::File { .. } => None,
            },
            heights: inputs.heights.iter().map(ToString::to_string).collect(),
            clearance_m: self.clearance_m,
            skipped: candidates.skipped,
            digest: place_digest(&ranked),
            ranked,
            n_candidates: n_uavs as u64,
            top: self.top,
            winner,
            refined,
            several,
        };
        drop(mapper);
        let places = inputs.places.clone();
        Ok(Placements { scene, report, over: self.over.clone(), places, heat, map: self.map.clone(), winner_maps })
    }

    /// Adds to each listed place the interval of its P_LoS less that of the best, with heights
    /// redrawn.
    fn compare_heights(
        &self,
        ranked: &mut [PlaceFacts],
        candidates: &Candidates,
        mapper: &Mapper<'_>,
        progress: &Progress,
    ) -> Result<()> {
        let listed = ranked.len().min(self.top);
        let errors = self.height_errors.over(mapper.field());
        if !errors.are_any() || listed < 2 {
            return Ok(());
        }
        let is_at = |place: &PlaceFacts, uav: &Uav| {
            let at = [uav.station.place.x, uav.station.place.y, uav.height_amsl_m()];
            at.map(f64::to_bits) == [place.x, place.y, place.height_amsl_m].map(f64::to_bits)
        };
        let uav = |place: &PlaceFacts| candidates.kept.iter().map(|c| &c.uav).find(|uav| is_at(place, uav)).cloned();
        let Some(uavs) = ranked[..listed].iter().map(uav).collect::<Option<Vec<Uav>>>() else { return Ok(()) };
        let Some(mut counts) = errors.redrawn(mapper, &uavs, progress)? else { return Ok(()) };
        // Shares are relative to all wanted receivers, in range or not.
        let wanted = mapper.receiver_cells().count();
        counts.receivers.iter_mut().for_each(|n| *n = wanted);
        for (k, place) in ranked[..listed].iter_mut().enumerate().skip(1) {
            place.heights = HeightsOfDifference::of(&counts, (0, k));
        }
        Ok(())
    }

    /// Returns the options of the maps: their receivers are the receivers of the goal.
    fn options(&self, scene: &Scene, zones: Option<&ZoneMap>, inputs: &Inputs) -> MapOptions {
        let options = self.sight.options(scene.grid(), zones);
        match self.goal.whom {
            Whom::Zone(Zone::Rooftop) => MapOptions { receivers: Receivers::Roof, within: None, ..options },
            Whom::Zone(zone) => {
                MapOptions { receivers: Receivers::Ground, within: zones.map(|z| z.cells(zone)), ..options }
            }
            Whom::Receivers | Whom::Area | Whom::Weights => {
                let of_area = inputs.area.as_ref().map(|area| area.cells(scene.grid()));
                let within = match (options.within.clone(), of_area) {
                    (Some(a), Some(b)) => Some(a.and(&b)),
                    (a, b) => a.or(b),
                };
                MapOptions { within, ..options }
            }
        }
    }
}

/// Returns the UAVs under their own names. Renames all of them 1, 2, … if a name is empty or occurs
/// twice.
fn named(uavs: Vec<Uav>) -> Vec<Uav> {
    let ids: std::collections::HashSet<&str> = uavs.iter().map(|uav| uav.id.as_str()).collect();
    if ids.len() == uavs.len() && !ids.contains("") {
        return uavs;
    }
    uavs.into_iter().enumerate().map(|(k, uav)| Uav { id: (k + 1).to_string(), ..uav }).collect()
}

impl Answer for Placements {
    fn document(&self, spent: Option<Spent>) -> Value {
        self.report.document(true, spent.map(|spent| self.scene.timing.with(spent)))
    }

    fn provenance(&self) -> Value {
        self.report.document(false, None)
    }

    fn table(&self) -> Rows {
        self.report.table(usize::MAX)
    }

    fn warnings(&self) -> &[Warning] {
        &self.report.facts.warnings
    }

    fn notes(&self, spent: Spent) -> Vec<String> {
        let (method, los) = (self.report.facts.method_in_words(), self.scene.timing.los);
        let last = format!("method {method}: search {los:.3} s of {:.2} s", spent.total);
        words::in_words(&self.report).into_iter().chain([last]).collect()
    }

    /// Lists only the best candidates: a search has thousands.
    fn text(&self, look: &Look) -> Result<String> {
        let table = encoded(&self.report.table(self.report.top), look.csv_text)?;
        Ok(String::from_utf8_lossy(&table).into_owned())
    }

    fn add(&self, batch: &mut Batch, path: &Path, format: Format, look: &Look) -> Result<()> {
        if self.map.as_deref() == Some(path) {
            return winner_map::add(self, batch, path, format, look);
        }
        match (format, &self.places) {
            (Format::GeoJson, _) => Ok(batch.add(path, pretty(&self.report.geojson()).as_bytes())?),
            (_, None) => Err(RequestError::NoGrid.into()),
            (Format::GeoTiff, Some(places)) => Ok(batch.add(path, &self.raster(places)?)?),
            (_, Some(places)) => Ok(batch.add(path, &heat_map::draw(self, places, format, look)?)?),
        }
    }
}

impl Placements {
    /// Returns the value of each place, `none` where there is no candidate.
    fn values(&self, places: &PlaceGrid, none: f32) -> Vec<f32> {
        let mut values = vec![none; places.grid.n_cells()];
        self.heat.iter().for_each(|(place, value)| values[*place] = *value);
        values
    }

    fn raster(&self, places: &PlaceGrid) -> Result<Vec<u8>> {
        let values = self.values(places, NODATA);
        Ok(encode_geotiff(&GeoTiffImage {
            georef: &places.grid,
            bands: Bands::Float(vec![(self.quantity().0.to_string(), &values)]),
            nodata: Some(f64::from(NODATA)),
            palette: None,
            metadata: &[("SKYSHED".into(), self.provenance().to_string())],
            layout: TiffLayout::Cog,
        })?)
    }

    /// Returns the name of the quantity shown over each place, and its unit.
    fn quantity(&self) -> (&'static str, &'static str) {
        match (self.report.goal.measure, self.report.goal.at_least) {
            (Measure::Margin, _) => ("Margin of the worst receiver, at most", "m"),
            (Measure::Share, Some(_)) => ("Least UAV height that reaches the share", "m"),
            (Measure::Share, None) if self.report.heights.len() == 1 => ("P_LoS", ""),
            (Measure::Share, None) => ("P_LoS at the best height", ""),
        }
    }
}
