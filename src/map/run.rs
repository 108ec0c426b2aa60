//! Maps made and written: in memory, or strip by strip if they do not fit there.

use std::path::PathBuf;
use std::time::Instant;

use skyshed_request::Layer;

use super::coverages::Coverages;
use super::drawing::draws_each;
use super::files::{MaskFile, Writer, written_at_once};
use super::job::{Done, Given, GivenScene, MapJob};
use super::plan::{Held, MapFiles, PartOf};
use super::save_checks::{check_formats, check_forms, check_values, look_of, mask_values};
use super::strips::{StripsRun, reason_for_strips};
use crate::answer::{Output, Spent, Timing, add_outputs};
use crate::city::GivenSite;
use crate::error::{Error, PlacesError, Result};
use crate::export::{Batch, Format, OutputRules, bare_name, check_layers, check_outputs};
use crate::progress::Progress;
use crate::raster::GeoRef;
use crate::read::surface_grid;
use crate::scene::Scene;

/// Files beside those of a map.
struct Beside {
    curves: Vec<Output>,
    over_time: Vec<Output>,
}

impl MapJob {
    /// Maps all UAVs together, into files that appear together.
    ///
    /// # Errors
    /// Errors of the plan and of file names come first, before any work. Then come the scene, the
    /// UAVs, and forms of files that these do not allow.
    pub(crate) fn run(&self, given: Given<'_>, progress: &Progress) -> Result<Done> {
        self.plan.check()?;
        let outputs = self.checked_outputs()?;
        match (&given.scene, self.reads_range_alone()) {
            (GivenScene::Asked, true) => {
                let whole = surface_grid(self.path(), &self.scene.of_raster()?)?;
                let uavs = given.uavs.map_or_else(|| self.uavs.read(&whole), Ok)?;
                let part = self.of_range(&uavs.sites, &whole);
                part.run_checked(outputs, Given { uavs: Some(uavs), grid: Some(&whole), ..given }, progress)
            }
            _ => self.run_checked(outputs, given, progress),
        }
    }

    /// Maps all UAVs together in memory, without a file.
    ///
    /// # Errors
    /// Errors of the scene, the UAVs and the plan.
    pub(crate) fn map(&self, given: Given<'_>, progress: &Progress) -> Result<Coverages> {
        let Given { uavs, scene, grid: whole, tile, .. } = given;
        let scene = match scene {
            GivenScene::InMemory(scene) => *scene,
            _ => self.scene_in_reach().open(&self.word)?,
        };
        let found = uavs.map_or_else(|| self.uavs.read(scene.grid()), Ok)?;
        let prepared = self.plan.clone().prepare(scene, &found, PartOf { whole, tile })?;
        prepared.run(Held::default(), progress, |_| {}, |_| {})
    }

    fn run_checked(
        &self,
        (outputs, beside): (Vec<Output>, Beside),
        given: Given<'_>,
        progress: &Progress,
    ) -> Result<Done> {
        let start = Instant::now();
        let Given { uavs, scene, grid: whole, tile, unit } = given;
        let read_uavs = |grid: &GeoRef| uavs.map_or_else(|| self.uavs.read(grid), Ok);
        let scene = match scene {
            GivenScene::InMemory(scene) => *scene,
            GivenScene::Asked if reason_for_strips(self).is_none() => self.scene_in_reach().open(&self.word)?,
            not_in_memory => {
                let run = StripsRun { job: self, outputs: &outputs, start, unit, progress };
                return match not_in_memory {
                    GivenScene::OnDisk(scene, warnings) => run.over(scene, warnings, read_uavs),
                    _ => run.read(read_uavs),
                };
            }
        };
        let found = read_uavs(scene.grid())?;
        let n_uavs = tile.map_or(found.sites.len(), |(_, n_list)| n_list);
        self.check_of_sites(&scene, (&found.sites, n_uavs), &outputs)?;
        let (uav_id, n_sites) =
            (found.sites.first().map(|site| site.id.clone()).unwrap_or_default(), found.sites.len());

        let prepared = self.plan.clone().prepare(scene, &found, PartOf { whole, tile })?;
        let is_by_zone = self.plan.tells_zones || self.plan.sight.receivers().zone().is_some();
        let direct = written_at_once(&outputs, &self.plan.layers, &self.save)
            .filter(|_| n_sites == 1 && tile.is_none() && !is_by_zone && !self.curve.is_wanted());
        let held = self.held(&outputs, n_sites, direct.is_some());
        let mut batch = Batch::new(self.save.writing.overwrite).asking(progress.check).sealing(unit.is_some());
        let mut file = direct.map(|path| MaskFile::new(path, mask_values(&self.save)));
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
        let over_time = self.over_time.make(&map);
        let before_write = Instant::now();
        // The time of writing is not known before the files are written.
        let (look, spent) = (&look_of(&self.save), Spent { write: 0.0, total: start.elapsed().as_secs_f64() });
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
            add_outputs(curves, &mut batch, &beside.curves, (look, spent))?;
        }
        if let Some(over_time) = &over_time {
            add_outputs(over_time, &mut batch, &beside.over_time, (look, spent))?;
        }
        let written = batch.commit()?;
        let write = before_write.elapsed().as_secs_f64();
        let timing = Timing { write, total: start.elapsed().as_secs_f64(), ..map.scene.timing };
        Ok(Done::of(map.report, timing, map.why, (curves, over_time), written))
    }

    /// Returns how much of a run of some UAVs is held for its files.
    fn held<'a>(&self, outputs: &'a [Output], n_sites: usize, is_handed_over: bool) -> Held<'a> {
        let layers = &self.plan.layers;
        let shows_masks = |format: Format| {
            Coverages::needs_masks(format, layers, &self.save) || format.is_picture() && draws_each(layers)
        };
        Held {
            keeps_masks: n_sites == 1
                || self.save.forms.bare
                || self.curve.is_wanted()
                || outputs.iter().any(|(_, f)| shows_masks(*f)),
            is_handed_over,
            files: MapFiles {
                outputs,
                polygons: self.save.forms.polygons.is_some(),
                curves: self.curve.is_wanted(),
                over_time: self.over_time.is_wanted(),
            },
        }
    }

    /// Returns the files of the map, and those beside them, with their formats, checked before any work.
    fn checked_outputs(&self) -> Result<(Vec<Output>, Beside)> {
        let inputs: Vec<PathBuf> = self.inputs.iter().cloned().chain(self.uavs.file()).collect();
        let (overwrite, bare) = (self.save.writing.overwrite, self.save.forms.bare);
        let rules = OutputRules { allowed: &super::FORMATS, inputs: &inputs, overwrite, bare };
        let outputs = check_outputs(&self.outputs, rules)?;
        let curves = self.curve.checked(&self.outputs, rules)?;
        let over_time = self.over_time.checked(self.outputs.iter().chain(&self.curve.outputs), rules)?;
        check_formats(&self.save, &outputs)?;
        let tells =
            |(_, format): &Output| matches!(format, Format::Csv | Format::Json | Format::GeoJson | Format::Stdout);
        if self.plan.layers != [Layer::Los] && outputs.iter().all(tells) {
            return Err(Error::idle("layers", "without a raster or a picture"));
        }
        if self.plan.tells_zones && !self.is_told() && !outputs.iter().chain(&curves).any(tells) {
            return Err(Error::idle("zones", "without a table or a document"));
        }
        Ok((outputs, Beside { curves, over_time }))
    }

    /// Refuses forms of files that these UAVs or this scene do not allow.
    fn check_of_sites(&self, scene: &Scene, (sites, n_uavs): (&[GivenSite], usize), outputs: &[Output]) -> Result<()> {
        if self.save.forms.bare {
            check_bare_names(sites, outputs, self.save.writing.overwrite)?;
        }
        for (path, format) in outputs {
            check_layers(&self.plan.layers, n_uavs, path, *format)?;
        }
        check_forms(&self.save, scene, outputs)?;
        check_values(&self.save, &self.plan.layers, sites.len())
    }
}

/// Refuses bare pictures of several sites that would share a name or replace a file, before any
/// work.
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
