//! P_LoS by placement zone: mean over UAVs above streets, crossroads, courtyards and rooftops.

mod plot;
mod report;

use std::ffi::{OsStr, OsString};
use std::path::Path;

use serde_json::Value;
use skyshed_core::Error as CoreError;
use skyshed_core::error::UavError;

pub(crate) use report::{SampleDocument, SampleRow};
use report::{SampledReport, SampledRow};

use skyshed_request::{SampleOptions, SceneOptions, SetSceneOptions, Sight, filled};

use crate::answer::{Answer, CommandFacts, Rows, RunFacts, Spent};
use crate::city::Site;
use crate::coverage::{Mapper, Uav, check_drop};
use crate::earth::{across_m, warn_of_drop_across};
use crate::error::{Error, OddRun, PlacesError, RequestError, Result, Warning};
use crate::export::{Batch, Format};
use crate::los::Method;
use crate::los_probability::estimate::{Count, Estimate};
use crate::memory::{FIELD_BYTES_PER_CELL, check_memory};
use crate::picture::Look;
use crate::placement::{Drawn, DrawnPlaces, ReceiverParts, SampledCounts, middles_of, over_cities};
use crate::progress::Progress;
use crate::quantity::{Height, counted, tidy};
use crate::raster::CellBlocks;
use crate::scene::{Scene, SceneReader, built_up};
use crate::sight::{SightPlan, check_receivers};
use crate::zones::Zone;

/// Output formats of a sample.
pub(crate) const FORMATS: [Format; 6] =
    [Format::Png, Format::Svg, Format::Pdf, Format::Csv, Format::Json, Format::Stdout];

/// Plan of a sample.
#[derive(Debug)]
pub(crate) struct SamplePlan {
    /// The scene as the user wrote it.
    pub(crate) word: OsString,
    /// The scene, if it was read before.
    pub(crate) given: Option<Scene>,
    pub(crate) scene: SceneReader,
    /// Edge of the part of a generated city that holds the placements \[m\].
    pub(crate) size_m: f64,
    pub(crate) sight: SightPlan,
    /// Zones, and the number of placements over each.
    pub(crate) zones: Vec<(Zone, usize)>,
    /// Heights of the UAVs above ground \[m\].
    pub(crate) heights_m: Vec<f64>,
    /// `true` if UAVs are over the middles of a generated city's crossroads, streets and buildings.
    pub(crate) is_centered: bool,
    /// Number of generated cities, with consecutive seeds from `seed` on.
    pub(crate) n_cities: u64,
    pub(crate) seed: u64,
    /// Confidence of the intervals.
    pub(crate) confidence: f64,
    /// Edge of the blocks of ground that are resampled \[m\]. `None` means an eighth of the city,
    /// at least 100 m.
    pub(crate) block_m: Option<f64>,
}

impl SamplePlan {
    /// Fills in the defaults of a question. A scene that is given was read with the same options.
    ///
    /// # Errors
    /// E113; E116 for ground below a generated city.
    pub(crate) fn of(
        (word, given): (&OsStr, Option<Scene>),
        scene: SceneReader,
        (sight, sample): (&Sight, &SampleOptions),
    ) -> Result<SamplePlan> {
        let (defaults, reading) = (SampleOptions::defaults(), &scene.options);
        if built_up(word).is_some() && reading.ground.is_some() {
            return Err(Error::idle("ground", "for heights above the ground of a generated city"));
        }
        let above_ground = |height: &Height| match height {
            Height::AboveGround(h) => Ok(*h),
            other => Err(Error::from(RequestError::HeightOfSample(other.to_string()))),
        };
        let heights = sample.height.clone().unwrap_or_default();
        let plan = SamplePlan {
            word: word.to_os_string(),
            given,
            size_m: reading.size.unwrap_or(SceneOptions::SIZE_M),
            sight: SightPlan::of(sight)?,
            zones: sample.zones.iter().map(|zone| (zone.zone, zone.count)).collect(),
            heights_m: heights.0.iter().map(above_ground).collect::<Result<_>>()?,
            is_centered: sample.centers,
            n_cities: filled(sample.cities, defaults.cities),
            seed: reading.seed_or_default(),
            confidence: filled(sample.ci, defaults.ci),
            block_m: sample.block,
            scene,
        };
        plan.check()?;
        Ok(plan)
    }
}

/// Results of a sample.
#[derive(Debug)]
pub(crate) struct Sample {
    scene: Scene,
    report: SampledReport,
    n_mapped: usize,
}

/// Counts of one city, by placement zone and height.
struct CityCounts {
    method: Method,
    /// Zones of the receivers that are counted together.
    parts: Vec<Option<Zone>>,
    /// Counts, `[zone × height]`.
    of: Vec<SampledCounts>,
    /// Placements left out inside buildings, `[zone × height]`.
    n_inside: Vec<usize>,
    /// Placements left out because their disc is cut or they have no ground, `[zone × height]`.
    n_cut: Vec<usize>,
}

impl SamplePlan {
    /// Checks the numbers and zones, before any work.
    ///
    /// # Errors
    /// E113.
    pub(crate) fn check(&self) -> Result<()> {
        if !(self.confidence > 0.0 && self.confidence < 1.0) {
            return Err(Error::number("the confidence", self.confidence, "above 0 and below 1"));
        }
        if let Some(block) = self.block_m.filter(|block| *block <= 0.0) {
            return Err(Error::number("the edge of blocks", block, "above 0 m"));
        }
        let zones: Vec<Zone> = self.zones.iter().map(|(zone, _)| *zone).collect();
        match zones.iter().enumerate().find(|(k, zone)| zones[..*k].contains(zone)) {
            Some((_, zone)) => Err(RequestError::ZoneTwice(zone.name()).into()),
            None => Ok(()),
        }
    }

    /// Takes the sample.
    ///
    /// # Errors
    /// E113, E116, E117; errors of reading the scene; E216 if no disc lies in the data.
    pub(crate) fn take(&self, command: CommandFacts, progress: &Progress) -> Result<Sample> {
        self.check()?;
        // A generated city is large enough for whole discs around its places. Cell positions are
        // drawn anew for each city. With walls at the same place of the cells in every city, all
        // shares would have the same bias, and no interval would show it.
        let margin_m = self.sight.radius_m().unwrap_or(0.0);
        let around = SceneReader { margin_m, draws_cells: true, ..self.scene.clone() };
        let open = |seed: u64| around.clone().seed(seed).open(&self.word);
        let mut first = self.given.clone().map_or_else(|| open(self.seed), Ok)?;
        if first.built_up.is_none() && (self.n_cities > 1 || self.is_centered) {
            let what = if self.is_centered { "centers of zones" } else { "several cities" };
            return Err(RequestError::OneCity(what).into());
        }
        check_receivers(self.sight.receivers(), first.field.is_surface_only())?;
        let farthest_m = self.sight.radius_m().unwrap_or(f64::INFINITY);
        match self.sight.curvature() {
            None => warn_of_drop_across(first.field.grid(), farthest_m, true, &mut first.warnings),
            Some(curvature) => {
                let drop_m = curvature.drop_m(across_m(first.field.grid()).min(farthest_m));
                check_drop(drop_m, first.field.lowest_known())?;
            }
        }
        let grid = first.grid();
        let unit = grid.meters_per_unit();
        let size_m = ((grid.x_max() - grid.x_min()) * unit).min((grid.y_max() - grid.y_min()) * unit);
        let block_m = self.block_m.unwrap_or((size_m / 8.0).max(100.0));
        check_memory(&self.word.display(), grid, FIELD_BYTES_PER_CELL)?;
        let mut cities = vec![self.count(&first, block_m, progress)?];
        for k in 1..self.n_cities {
            (progress.check)()?;
            cities.push(self.count(&open(self.seed.wrapping_add(k))?, block_m, progress)?);
        }
        self.refuse_if_all_are_cut(&cities)?;
        let mut facts = RunFacts { command, ..first.facts(Some(cities[0].method)) };
        let last = self.seed.wrapping_add(self.n_cities - 1);
        if first.built_up.is_some() && last != self.seed {
            let (one, all) = (format!("seed {}", self.seed), format!("seeds {} to {last}", self.seed));
            facts.scene_name = facts.scene_name.replace(&one, &all);
        }
        let mut report = SampledReport {
            facts,
            sight: self.sight,
            n_cities: self.n_cities,
            is_centered: self.is_centered,
            block_m,
            confidence: self.confidence,
            rows: self.rows(&cities),
        };
        let without = || report.rows.iter().filter(|row| row.estimate.p_los.is_none());
        if let Some(row) = without().next() {
            let (n, why) = (without().count() as u64, row.reason().unwrap_or_default());
            report.facts.warnings.push(OddRun::NoValues { n, why }.into());
        }
        let n_mapped = cities.iter().flat_map(|city| city.of.iter().map(|c| c.n_placements)).sum();
        Ok(Sample { scene: first, report, n_mapped })
    }

    /// Maps the placements of one city.
    fn count(&self, scene: &Scene, block_m: f64, progress: &Progress) -> Result<CityCounts> {
        let field = &scene.field;
        let size = self.size_m;
        let Some(zones) = scene.zones()? else {
            return Err(RequestError::NoZones.into());
        };
        let options = self.sight.options(scene.grid(), Some(&zones));
        let radius = options.radius;
        let mapper = Mapper::new(field, &options)?;
        let parts = ReceiverParts::new(&mapper.receiver_cells(), &zones);
        let blocks = CellBlocks::new(field.grid(), field.grid().meters_per_unit(), block_m);
        let (mut of, mut n_inside, mut n_cut) = (Vec::new(), Vec::new(), Vec::new());
        let grid = field.grid();
        let within = match scene.built_up {
            Some(_) => [0.0, 0.0, size, size],
            None => [grid.x_min(), grid.y_min(), grid.x_max(), grid.y_max()],
        };
        for (zone, n) in &self.zones {
            let DrawnPlaces { places, n_cut: cut } = match scene.built_up.filter(|_| self.is_centered) {
                Some(built_up) => {
                    let places = some_of(middles_of(&built_up, size, *zone), *n);
                    DrawnPlaces { places, n_cut: 0 }
                }
                None => {
                    let seed = scene.seed;
                    Drawn { zone: *zone, n: *n, within, radius, seed }.places(field, &zones)
                }
            };
            for height in self.heights_m.iter().copied() {
                let mut uavs = Vec::with_capacity(places.len());
                let mut n_without_ground = 0;
                for (k, [x, y]) in places.iter().enumerate() {
                    let site = Site::new((k + 1).to_string(), (*x, *y), Height::AboveGround(height));
                    match Uav::place(&site, field, radius) {
                        Ok(uav) => uavs.push(uav),
                        Err(CoreError::Uav { why: UavError::InsideBuilding { .. }, .. }) => {}
                        // The place has a building where the terrain has no height, or lies beside
                        // a cell that blocks everything.
                        Err(CoreError::Uav { why: UavError::NoGround | UavError::OverNodata, .. }) => {
                            n_without_ground += 1;
                        }
                        Err(e) => return Err(e.into()),
                    }
                }
                n_inside.push(places.len() - uavs.len() - n_without_ground);
                n_cut.push(cut + n_without_ground);
                let counts = SampledCounts::of(&mapper, &uavs, &parts, &blocks)?;
                // Several cities need only the totals of each.
                of.push(if self.n_cities > 1 { counts.summed() } else { counts });
                (progress.check)()?;
            }
        }
        Ok(CityCounts { method: mapper.method().0, parts: parts.zones(), of, n_inside, n_cut })
    }

    /// Refuses a sample that has no placement left because all discs are cut.
    fn refuse_if_all_are_cut(&self, cities: &[CityCounts]) -> Result<()> {
        let n_cut: usize = cities.iter().flat_map(|city| &city.n_cut).sum();
        let is_left = cities.iter().any(|city| {
            city.of.iter().any(|of| of.n_placements > 0) || city.n_inside.iter().any(|n_inside| *n_inside > 0)
        });
        let Some(radius_m) = self.sight.radius_m().filter(|_| n_cut > 0 && !is_left) else { return Ok(()) };
        let (word, radius_m) = (self.word.display().to_string(), tidy(radius_m));
        Err(PlacesError::NoSampledDisc { word, radius_m }.into())
    }

    /// Returns one row per placement zone, height and part of the receivers.
    fn rows(&self, cities: &[CityCounts]) -> Vec<SampledRow> {
        let first = &cities[0];
        let settings = self.zones.iter().flat_map(|(zone, _)| self.heights_m.iter().map(move |h| (*zone, *h)));
        settings
            .enumerate()
            .flat_map(|(k, (placement, height_m))| {
                let estimates = if cities.len() > 1 {
                    let totals: Vec<Vec<Count>> = cities.iter().map(|city| city.of[k].totals()).collect();
                    over_cities(&totals, first.parts.len(), self.confidence)
                } else {
                    first.of[k].estimates(self.confidence, self.seed)
                };
                let n_placements = cities.iter().map(|city| city.of[k].n_placements).sum();
                let n_inside = cities.iter().map(|city| city.n_inside[k]).sum();
                let n_cut = cities.iter().map(|city| city.n_cut[k]).sum();
                let row = move |(receivers, estimate): (&Option<Zone>, Estimate)| SampledRow {
                    placement,
                    height_m,
                    receivers: *receivers,
                    n_placements,
                    n_inside,
                    n_cut,
                    estimate,
                };
                first.parts.iter().zip(estimates).map(row).collect::<Vec<_>>()
            })
            .collect()
    }
}

impl Answer for Sample {
    fn document(&self, _: Option<Spent>) -> Value {
        self.report.document(true)
    }

    fn provenance(&self) -> Value {
        self.report.document(false)
    }

    fn table(&self) -> Rows {
        self.report.table()
    }

    fn warnings(&self) -> &[Warning] {
        &self.report.facts.warnings
    }

    fn notes(&self, spent: Spent) -> Vec<String> {
        let placements = counted(self.n_mapped as u64, "placement", "placements");
        vec![format!("{placements} mapped in {:.2} s", spent.total)]
    }

    fn add(&self, batch: &mut Batch, path: &Path, format: Format, look: &Look) -> Result<()> {
        Ok(batch.add(path, &plot::draw(self, format, look)?)?)
    }
}

/// Returns up to `n` of some places, evenly spread over their order.
fn some_of(places: Vec<[f64; 2]>, n: usize) -> Vec<[f64; 2]> {
    if places.len() <= n {
        return places;
    }
    (0..n).map(|k| places[k * places.len() / n]).collect()
}
