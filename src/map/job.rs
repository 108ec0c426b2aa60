//! A map as files: made in memory, or strip by strip where it does not fit there.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::time::Instant;

use super::coverages::Coverages;
use super::curve::{CurvePlan, Curves};
use super::drawing::draws_each;
use super::files::{MaskFile, Writer, written_at_once};
use super::plan::{Held, MapPlan};
use super::report::MapReport;
use super::save::SaveOptions;
use super::strips::{StripsRun, reason_for_strips};
use super::tolerance::in_words as tolerance_in_words;
use crate::answer::{Answer, Output, Rows, Spent, Timing, add_outputs};
use crate::city::GivenSite;
use crate::error::{Error, PlacesError, Result, Warning};
use crate::export::{Batch, Format, Layer, OutputRules, bare_name, check_layers, check_outputs};
use crate::los::Method;
use crate::picture::Look;
use crate::progress::Progress;
use crate::raster::GeoRef;
use crate::read::StreamedSurface;
use crate::scene::{Scene, SceneOptions};
use crate::uav::{UavsAsked, UavsFound};
use crate::words::{idle_in_words, p_los_words};

/// What is asked of which scene, for which UAVs, into which files.
#[derive(Debug, Clone)]
pub(crate) struct MapJob {
    /// The scene: a path, or the word for a generated city.
    pub(crate) word: OsString,
    pub(crate) scene: SceneOptions,
    /// The files that the scene is read from.
    pub(crate) inputs: Vec<PathBuf>,
    pub(crate) uavs: UavsAsked,
    pub(crate) plan: MapPlan,
    pub(crate) save: SaveOptions,
    pub(crate) outputs: Vec<PathBuf>,
    pub(crate) curve: CurvePlan,
    /// Whether counts are told beside the files.
    pub(crate) is_told: bool,
    /// Whether a raster is mapped strip by strip also where it fits in memory, and where its copy lies.
    pub(crate) strips: bool,
    pub(crate) scratch: Option<PathBuf>,
    /// Whether what is there, made by an equal run, is left alone.
    pub(crate) resume: bool,
    /// The words of the command line, for documents.
    pub(crate) command: Vec<String>,
}

/// What a run is given that was read before.
#[derive(Default)]
pub(crate) struct Given<'a> {
    /// The UAVs, instead of those that were asked for.
    pub(crate) uavs: Option<UavsFound>,
    pub(crate) scene: GivenScene<'a>,
    /// The grid of which the scene may be a part.
    pub(crate) grid: Option<&'a GeoRef>,
    /// What the run is one of.
    pub(crate) unit: Option<String>,
}

/// A scene that was read before, or is still to be read.
#[derive(Default)]
pub(crate) enum GivenScene<'a> {
    /// Read it.
    #[default]
    Asked,
    InMemory(Box<Scene>),
    /// In tiles on disk, with what was said of it.
    OnDisk(&'a StreamedSurface, Vec<Warning>),
}

/// A map whose files are written.
#[derive(Debug)]
pub(crate) struct Done {
    pub(crate) report: MapReport,
    pub(crate) timing: Timing,
    /// Why the method was chosen.
    pub(crate) why: &'static str,
    pub(crate) curves: Option<Curves>,
    pub(crate) written: Vec<PathBuf>,
    /// All that was odd.
    pub(crate) warnings: Vec<Warning>,
}

impl Done {
    pub(super) fn of(
        report: MapReport,
        timing: Timing,
        why: &'static str,
        curves: Option<Curves>,
        written: Vec<PathBuf>,
    ) -> Done {
        let of_curves = curves.as_ref().map_or(&[][..], |curves| curves.warnings());
        let warnings = [&report.facts.warnings, of_curves].concat();
        Done { report, timing, why, curves, written, warnings }
    }
}

/// What is told of a map whose files are there.
impl Answer for Done {
    fn document(&self, _: Option<Spent>) -> serde_json::Value {
        self.report.document(Some(self.timing))
    }

    fn table(&self) -> Rows {
        self.report.table()
    }

    fn warnings(&self) -> &[Warning] {
        &self.warnings
    }

    fn notes(&self, spent: Spent) -> Vec<String> {
        let report = &self.report;
        let dropped = report.idle.iter().filter(|idle| idle.dropped() > 0).map(idle_in_words);
        let mut notes: Vec<String> = dropped.chain(report.tolerance.iter().map(tolerance_in_words)).collect();
        notes.extend(report.sites.iter().map(|site| {
            let share = p_los_words(site.tally.p_los());
            format!("UAV {}: P_LoS {share}, {} of {} receivers", site.id, site.tally.los, site.tally.receivers)
        }));
        notes.push(format!(
            "method {} ({}; {}): line of sight {:.3} s of {:.2} s",
            report.facts.method_name(),
            report.facts.method.map_or("", Method::exactness),
            self.why,
            self.timing.los,
            self.timing.total
        ));
        notes.extend(self.curves.iter().flat_map(|curves| curves.notes(spent)));
        notes
    }

    fn add(&self, _: &mut Batch, _: &Path, _: Format, _: &Look) -> Result<()> {
        Ok(())
    }
}

impl MapJob {
    /// Maps all UAVs together, into files that appear together.
    ///
    /// # Errors
    /// Those of the scene, the UAVs, the plan and the files, in this order as far as they can be told before any work.
    pub(crate) fn run(&self, given: Given<'_>, progress: &Progress) -> Result<Done> {
        let start = Instant::now();
        self.plan.check()?;
        let (outputs, curve_outputs) = self.checked_outputs()?;
        let Given { uavs, scene, grid: whole, unit } = given;
        let read_uavs = |grid: &GeoRef| uavs.map_or_else(|| self.uavs.read(grid), Ok);
        let scene = match scene {
            GivenScene::InMemory(scene) => *scene,
            GivenScene::Asked if reason_for_strips(self).is_none() => self.scene.open(&self.word)?,
            not_in_memory => {
                let run = StripsRun { job: self, outputs: &outputs, start, unit, progress };
                return match not_in_memory {
                    GivenScene::OnDisk(scene, warnings) => run.over(scene, warnings, read_uavs),
                    _ => run.read(read_uavs),
                };
            }
        };
        let found = read_uavs(scene.grid())?;
        self.check_of_sites(&scene, &found.sites, &outputs)?;
        let (uav_id, n_sites) =
            (found.sites.first().map(|site| site.id.clone()).unwrap_or_default(), found.sites.len());

        let has_zones =
            |(_, format): &Output| matches!(format, Format::Csv | Format::Json | Format::GeoJson | Format::Stdout);
        let tells_zones = self.is_told
            || outputs.iter().any(has_zones)
            || curve_outputs.iter().any(|(_, format)| *format == Format::Json);
        let prepared = MapPlan { tells_zones, ..self.plan.clone() }.prepare(scene, &found, whole)?;
        let is_by_zone = tells_zones || self.plan.sight.receivers().zone().is_some();
        let direct = written_at_once(&outputs, &self.plan.layers, &self.save)
            .filter(|_| n_sites == 1 && !is_by_zone && !self.curve.is_wanted());
        let shows_masks = |format: Format| {
            Coverages::needs_masks(format, &self.save) || format.is_picture() && draws_each(&self.plan.layers)
        };
        let held = Held {
            keeps_masks: n_sites == 1
                || self.save.bare
                || self.curve.is_wanted()
                || outputs.iter().any(|(_, f)| shows_masks(*f)),
            is_handed_over: direct.is_some(),
            bytes_per_cell: encoding_bytes_per_cell(&outputs, &self.plan.layers, n_sites)
                .saturating_add(if self.save.polygons.is_some() { OUTLINE_BYTES_PER_CELL } else { 0 })
                .saturating_add(self.curve.bytes_per_cell()),
        };
        let mut batch = Batch::new(self.save.overwrite).asking(progress.check);
        let mut file = direct.map(|path| MaskFile::new(path, self.save.mask_values));
        let grid = prepared.scene.grid().clone();
        let each_part = |cells: &[u8]| {
            if let Some(file) = &mut file {
                file.push(&mut batch, &grid, cells, progress);
            }
        };
        let made = prepared.run(held, progress, each_part, |_| {});
        let file = file.map(MaskFile::written).transpose()?.flatten();
        let mut map = made?;
        (map.report.facts.command, map.report.facts.unit) = (self.command.clone(), unit);
        let curves = self.curve.make(&map, progress)?;
        let before_write = Instant::now();
        // The time of writing is not known before the files are written.
        let (look, spent) = (&self.save.look, Spent { write: 0.0, total: start.elapsed().as_secs_f64() });
        (progress.begin_writing)();
        match file {
            Some(strips) => {
                (progress.check)()?;
                let provenance = map.report.document(None).to_string();
                strips.finish(&mut batch, (&grid, uav_id.as_str(), provenance.as_str()))?;
            }
            None => {
                let writer = Writer { of: &map, options: &self.save };
                add_outputs(&writer, &mut batch, &outputs, (look, spent))?;
            }
        }
        if let Some(curves) = &curves {
            add_outputs(curves, &mut batch, &curve_outputs, (look, spent))?;
        }
        let written = batch.commit()?;
        let write = before_write.elapsed().as_secs_f64();
        let timing = Timing { write, total: start.elapsed().as_secs_f64(), ..map.scene.timing };
        Ok(Done::of(map.report, timing, map.why, curves, written))
    }

    /// The path of a scene that is a file.
    pub(super) fn path(&self) -> &Path {
        Path::new(&self.word)
    }

    /// The files of the map and those of its curves with their formats, checked before any work.
    fn checked_outputs(&self) -> Result<(Vec<Output>, Vec<Output>)> {
        let inputs: Vec<PathBuf> = self.inputs.iter().chain(&self.uavs.table).cloned().collect();
        let (overwrite, bare) = (self.save.overwrite, self.save.bare);
        let rules = OutputRules { allowed: &super::FORMATS, inputs: &inputs, overwrite, bare };
        let outputs = check_outputs(&self.outputs, rules)?;
        let curve_outputs = self.curve.checked(&self.outputs, rules)?;
        self.save.check_formats(&outputs)?;
        Ok((outputs, curve_outputs))
    }

    /// Refuses what the files cannot be for these UAVs of this scene.
    fn check_of_sites(&self, scene: &Scene, sites: &[GivenSite], outputs: &[Output]) -> Result<()> {
        if self.save.bare {
            check_bare_names(sites, outputs, self.save.overwrite)?;
        }
        for (path, format) in outputs {
            check_layers(&self.plan.layers, sites.len(), path, *format)?;
        }
        self.save.check(scene, outputs)?;
        self.save.check_values(&self.plan.layers, sites.len())
    }
}

/// Refuses bare pictures of several sites that would share a name or replace a file, before any work.
fn check_bare_names(sites: &[GivenSite], outputs: &[Output], overwrite: bool) -> Result<()> {
    let mut names = std::collections::HashMap::new();
    for (path, _) in outputs.iter().filter(|(_, f)| *f == Format::Png && sites.len() > 1) {
        for site in sites {
            let name = bare_name(path, &site.id);
            if let Some(other) = names.insert(name.clone(), &site.id) {
                let file = format!("the file {}", name.display());
                return Err(PlacesError::SharedFile { a: (*other).clone(), b: site.id.clone(), file }.into());
            }
            if !overwrite && name.exists() {
                return Err(Error::exists(&name));
            }
        }
    }
    Ok(())
}

/// What the largest of the outputs takes for each cell while it is made, of maps of `n_sites` UAVs.
pub(super) fn encoding_bytes_per_cell(outputs: &[Output], layers: &[Layer], n_sites: usize) -> usize {
    /// Of a picture: heights, relief, colors.
    const PICTURE: usize = 9;
    /// Of the layers that hold all UAVs together.
    const OF_ALL: usize = 8;
    let n_measures = layers.iter().filter(|layer| layer.is_measure()).count();
    let n_of_all = layers.iter().filter(|layer| matches!(layer, Layer::Count | Layer::Which)).count();
    let of_format = |format: Format| match format {
        Format::Png | Format::Svg | Format::Pdf | Format::Kmz => PICTURE,
        // Masks as numbers of 4 bytes; measures are numbers already.
        Format::Exr => n_sites.saturating_mul(4).saturating_add(OF_ALL * n_of_all),
        // All in one array for each layer.
        Format::Npz => n_sites.saturating_mul(1 + 4 * n_measures).saturating_add(OF_ALL * n_of_all),
        Format::AsciiGrid | Format::Bil => 4,
        _ => 0,
    };
    outputs.iter().map(|(_, format)| of_format(*format)).max().unwrap_or(0)
}

/// What finding the connected parts of a class takes: the number of each cell's part, and the edges around it.
const OUTLINE_BYTES_PER_CELL: usize = 5;
