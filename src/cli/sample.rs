//! `skyshed place --sample`: what UAVs over each zone see on average.

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;

use super::args::{EngineArgs, OutputArgs, SceneArgs, number};
use super::plan::ready;
use super::sample_plot::plot;
use super::{interrupt, messages};
use crate::city::Site;
use crate::coverage::{Mapper, Uav};
use crate::error::{Error, Result, Warning};
use crate::export::{Batch, Format, with_suffix};
use crate::los::Method;
use crate::los_probability::estimate::{Count, Estimate};
use crate::map::Receivers;
use crate::map::{Asked, check_receivers, checked_radius, receiver_height};
use crate::memory::{FIELD_BYTES_PER_CELL, check_memory};
use crate::picture::PictureWords;
use crate::placement::{Drawn, DrawnPlaces, ReceiverParts, SampledCounts, middles_of, over_cities};
use crate::quantity::{Height, counted, tidy};
use crate::raster::CellBlocks;
use crate::report::{SampledReport, SampledRow};
use crate::scene::Scene;
use crate::scene::limits::warn_of_drop_across;
use crate::words::pretty;
use crate::zones::Zone;

/// What is asked of sampled placements.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Sample")]
pub(super) struct SampleArgs {
    /// Instead of a search: P_LoS from N placements over each zone, averaged, with intervals, by zone of the receivers:
    /// street:200,crossroad:200,rooftop:200
    #[arg(long, value_name = "ZONE:N,…", value_delimiter = ',', value_parser = zone_and_count)]
    pub(super) sample: Vec<(Zone, usize)>,
    /// Sampled placements stand over the middles of a generated city's crossroads, streets and buildings
    #[arg(long, requires = "sample")]
    pub(super) centers: bool,
    /// Generated cities to sample, from `--seed` on; each has N placements per zone, and intervals are over cities
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..=100_000),
          requires = "sample")]
    pub(super) cities: u64,
    /// Confidence of the intervals of a sample
    #[arg(long, value_name = "C", value_parser = number, default_value = "0.95", requires = "sample")]
    pub(super) ci: f64,
    /// Edge of the blocks of ground that are resampled for the intervals over one city [m]; default: an eighth of the
    /// city, at least 100 m
    #[arg(long, value_name = "M", value_parser = number, allow_hyphen_values = true, requires = "sample")]
    pub(super) block: Option<f64>,
}

fn zone_and_count(text: &str) -> std::result::Result<(Zone, usize), String> {
    let wanted = "wanted ZONE:N, such as crossroad:200";
    let (zone, count) = text.split_once(':').ok_or_else(|| format!("found `{text}`, {wanted}"))?;
    let zone = Zone::named(zone.trim())
        .ok_or_else(|| format!("found `{zone}`, wanted street, crossroad, courtyard or rooftop"))?;
    match count.trim().parse::<usize>() {
        Ok(count @ 1..=100_000) => Ok((zone, count)),
        _ => Err(format!("found `{count}` placements, wanted 1 to 100000")),
    }
}

/// A sample that was asked for, its files checked.
#[derive(Debug)]
pub(super) struct SampleJob<'a> {
    pub(super) sample: &'a SampleArgs,
    pub(super) scene: &'a SceneArgs,
    pub(super) engine: &'a EngineArgs,
    pub(super) out: &'a OutputArgs,
    pub(super) outputs: &'a [(PathBuf, Format)],
    /// Heights of the UAVs above ground \[m\].
    pub(super) heights_m: &'a [f64],
    pub(super) rx_height_m: f64,
    pub(super) receivers: Receivers,
    pub(super) words: &'a PictureWords,
}

/// What one city says of each placement zone and height.
struct CityCounts {
    method: Method,
    /// Which receivers are counted together.
    parts: Vec<Option<Zone>>,
    /// `[zone × height]`.
    of: Vec<SampledCounts>,
    /// Placements left out inside buildings, `[zone × height]`.
    n_inside: Vec<usize>,
    /// Placements left out because their disc is cut, `[zone × height]`.
    n_cut: Vec<usize>,
}

impl SampleJob<'_> {
    /// What a sample is written as.
    pub(super) const FORMATS: [Format; 6] =
        [Format::Png, Format::Svg, Format::Pdf, Format::Csv, Format::Json, Format::Stdout];

    /// Samples, and writes what was asked for.
    ///
    /// # Errors
    /// Usage errors; those of reading the scene and of writing files.
    pub(super) fn run(&self, command: Vec<String>) -> Result<()> {
        let start = Instant::now();
        self.check()?;
        let radius_m = checked_radius(self.engine.radius)?;
        let rx_height = receiver_height(self.rx_height_m)?;
        // A generated city is made as large as whole discs around its places take.
        let around = SceneArgs { margin_m: radius_m.unwrap_or(0.0), ..self.scene.clone() };
        let mut first = ready(&around)?;
        if first.built_up.is_none() && (self.sample.cities > 1 || self.sample.centers) {
            let flag = if self.sample.centers { "--centers" } else { "--cities" };
            let text = format!("`{flag}` has no meaning for a city in a file: it is one, and its streets form no grid");
            return Err(Error::usage(116, text).with_hint("generate cities: itu:urban, itu:α,β,γ"));
        }
        check_receivers(self.receivers, &first.field)?;
        warn_of_drop_across(first.field.grid(), radius_m.unwrap_or(f64::INFINITY), &mut first.warnings);
        let grid = first.field.grid();
        let unit = grid.meters_per_unit();
        let size_m = ((grid.x_max() - grid.x_min()) * unit).min((grid.y_max() - grid.y_min()) * unit);
        let block_m = self.sample.block.unwrap_or((size_m / 8.0).max(100.0));
        check_memory(&self.scene.scene, grid, FIELD_BYTES_PER_CELL)?;
        let radius = radius_m.map(|r| first.crs_units(r));
        let asked = Asked { receivers: self.receivers, rx_height, radius, method: self.engine.method };

        let mut cities = vec![self.count(&first, asked, block_m)?];
        for k in 1..self.sample.cities {
            interrupt::check()?;
            let scene = SceneArgs { seed: self.scene.seed.wrapping_add(k), ..around.clone() };
            cities.push(self.count(&ready(&scene)?, asked, block_m)?);
        }
        self.refuse_if_all_are_cut(&cities, radius_m)?;
        let mut facts = first.facts(command, Some(cities[0].method));
        if let Some((seed, last)) =
            first.built_up.map(|_| (first.seed, first.seed.wrapping_add(self.sample.cities - 1)))
            && last != seed
        {
            facts.scene_name = facts.scene_name.replace(&format!("seed {seed}"), &format!("seeds {seed} to {last}"));
        }
        let mut report = SampledReport {
            facts,
            rx_height_m: self.rx_height_m,
            radius_m,
            n_cities: self.sample.cities,
            is_centered: self.sample.centers,
            block_m,
            confidence: self.sample.ci,
            rows: self.rows(&cities),
        };
        let n_none = report.rows.iter().filter(|row| row.estimate.p_los.is_none()).count() as u64;
        if n_none > 0 {
            let reason = report.rows.iter().find(|row| row.estimate.p_los.is_none()).and_then(SampledRow::reason);
            let values = counted(n_none, "value has", "values have");
            let text = format!("{values} no P_LoS: {}", reason.unwrap_or_default());
            report.facts.warnings.push(Warning::new(202, text));
        }
        self.write(&first, &report)?;
        if !self.out.quiet {
            let n: usize = cities.iter().flat_map(|city| city.of.iter().map(|c| c.n_placements)).sum();
            let seconds = start.elapsed().as_secs_f64();
            messages::note(&format!("{} mapped in {seconds:.2} s", counted(n as u64, "placement", "placements")));
        }
        Ok(())
    }

    fn check(&self) -> Result<()> {
        let asked = self.sample;
        if !(asked.ci > 0.0 && asked.ci < 1.0) {
            return Err(Error::usage(113, format!("`--ci` is `{}`, wanted above 0 and below 1", asked.ci)));
        }
        if let Some(block) = asked.block.filter(|block| *block <= 0.0) {
            return Err(Error::usage(113, format!("`--block` is `{block}`, wanted above 0 m")));
        }
        let zones: Vec<Zone> = asked.sample.iter().map(|(zone, _)| *zone).collect();
        match zones.iter().enumerate().find(|(k, zone)| zones[..*k].contains(zone)) {
            Some((_, zone)) => Err(Error::usage(113, format!("`--sample` names {} twice", zone.name()))),
            None => Ok(()),
        }
    }

    /// Maps the placements of one city.
    fn count(&self, scene: &Scene, asked: Asked, block_m: f64) -> Result<CityCounts> {
        let field = &scene.field;
        let size = self.scene.size.unwrap_or(1000.0);
        let Some(zones) = scene.zones() else {
            return Err(Error::usage(117, "`--sample` with a surface model alone: no zone is known")
                .with_hint("give `--terrain FILE` or `--ground Z`"));
        };
        let options = asked.options(scene.field.grid(), Some(&zones));
        let mapper = Mapper::new(field, &options)?;
        let parts = ReceiverParts::new(&mapper.receiver_cells(), &zones);
        let blocks = CellBlocks::new(field.grid(), field.grid().meters_per_unit(), block_m);
        let (mut of, mut n_inside, mut n_cut) = (Vec::new(), Vec::new(), Vec::new());
        let grid = field.grid();
        let within = match scene.built_up {
            Some(_) => [0.0, 0.0, size, size],
            None => [grid.x_min(), grid.y_min(), grid.x_max(), grid.y_max()],
        };
        for (zone, n) in &self.sample.sample {
            let DrawnPlaces { places, n_cut: cut } = match scene.built_up.filter(|_| self.sample.centers) {
                Some(built_up) => {
                    let places = some_of(middles_of(&built_up, size, *zone), *n);
                    DrawnPlaces { places, n_cut: 0 }
                }
                None => {
                    let seed = scene.seed;
                    Drawn { zone: *zone, n: *n, within, radius: asked.radius, seed }.places(field, &zones)
                }
            };
            for height in self.heights_m {
                let mut uavs = Vec::with_capacity(places.len());
                let mut n_without_ground = 0;
                for (k, [x, y]) in places.iter().enumerate() {
                    let site = Site { id: (k + 1).to_string(), x: *x, y: *y, height: Height::AboveGround(*height) };
                    match Uav::place(&site, field, asked.radius) {
                        Ok(uav) => uavs.push(uav),
                        Err(e) if e.code() == "E201" => {}
                        // Over a building that stands where the terrain has no height.
                        Err(e) if e.code() == "E204" => n_without_ground += 1,
                        Err(e) => return Err(e.into()),
                    }
                }
                n_inside.push(places.len() - uavs.len() - n_without_ground);
                n_cut.push(cut + n_without_ground);
                let counts = SampledCounts::of(&mapper, &uavs, &parts, &blocks);
                // Of one among many cities only the totals are asked for.
                of.push(if self.sample.cities > 1 { counts.summed() } else { counts });
                interrupt::check()?;
            }
        }
        Ok(CityCounts { method: mapper.method().0, parts: parts.zones(), of, n_inside, n_cut })
    }

    /// Refuses a sample of which no placement is left because the discs around all of them are cut.
    fn refuse_if_all_are_cut(&self, cities: &[CityCounts], radius_m: Option<f64>) -> Result<()> {
        let n_cut: usize = cities.iter().flat_map(|city| &city.n_cut).sum();
        let is_left = cities.iter().any(|city| {
            city.of.iter().any(|of| of.n_placements > 0) || city.n_inside.iter().any(|n_inside| *n_inside > 0)
        });
        let Some(radius_m) = radius_m.filter(|_| n_cut > 0 && !is_left) else { return Ok(()) };
        let text = format!(
            "cannot sample {}: of no placement tried lies the whole disc of {} m in the data, wanted P_LoS over whole discs",
            self.scene.scene,
            tidy(radius_m)
        );
        Err(Error::site(216, text).with_hint(
            "a smaller `--radius`, a larger `--extent`, or, if the ground between is known, `--data-area all` or a polygon of it",
        ))
    }

    /// One row per placement zone, height and part of the receivers.
    fn rows(&self, cities: &[CityCounts]) -> Vec<SampledRow> {
        let first = &cities[0];
        let settings = self.sample.sample.iter().flat_map(|(zone, _)| self.heights_m.iter().map(move |h| (*zone, *h)));
        settings
            .enumerate()
            .flat_map(|(k, (placement, height_m))| {
                let estimates = if cities.len() > 1 {
                    let totals: Vec<Vec<Count>> = cities.iter().map(|city| city.of[k].totals()).collect();
                    over_cities(&totals, first.parts.len(), self.sample.ci)
                } else {
                    first.of[k].estimates(self.sample.ci, self.scene.seed)
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

    fn write(&self, scene: &Scene, report: &SampledReport) -> Result<()> {
        interrupt::begin_writing();
        let mut batch = Batch::new(self.out.overwrite);
        for (path, format) in self.outputs {
            interrupt::check()?;
            match format {
                Format::Csv => {
                    batch.add(path, &self.out.table(&report.table())?)?;
                    batch.add(&with_suffix(path, ".json"), pretty(&report.provenance()).as_bytes())?;
                }
                Format::Json => batch.add(path, pretty(&report.document()).as_bytes())?,
                Format::Png | Format::Svg | Format::Pdf => {
                    let credit = self.words.credit(scene.attribution.as_ref());
                    let last: Vec<String> = scene.limits_in_words().into_iter().chain(credit).collect();
                    let words = (self.words.title.as_deref(), last.as_slice());
                    batch.add(path, &plot(report, words, &self.words.size.form(*format))?)?;
                }
                _ => {}
            }
        }
        let files = batch.commit()?;
        if !self.out.quiet {
            messages::warnings(&report.facts.warnings);
        }
        messages::wrote(&files, self.out.quiet);
        if self.out.json || self.outputs.iter().any(|(_, f)| *f == Format::Stdout) {
            messages::answer(&pretty(&report.document()))
        } else if self.outputs.is_empty() {
            messages::answer(&String::from_utf8_lossy(&self.out.table(&report.table())?))
        } else {
            Ok(())
        }
    }
}

/// Up to `n` of some places, evenly spread over their order.
fn some_of(places: Vec<[f64; 2]>, n: usize) -> Vec<[f64; 2]> {
    if places.len() <= n {
        return places;
    }
    (0..n).map(|k| places[k * places.len() / n]).collect()
}
