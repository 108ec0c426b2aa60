//! A map in units: a run of its own for each UAV or each tile of the ground, which can be asked for again.
//!
//! With `{site}` in the names of its files each UAV is a unit of work, with `{row}` and `{col}` each tile. The files of a unit hold
//! what it was made of (`unit`, a hash of the inputs, the options and the UAV or the tile), they appear when all of them are
//! complete, and a run that resumes leaves those alone that are there. So an interrupted run goes on where it stopped, and
//! another program may hand out units one by one, and hand them out again.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::coverages::Coverages;
use super::job::{Done, Given, GivenScene, MapJob};
use super::strips::{check_strips, on_disk, reason_for_strips};
use super::tiles::{ROW_AND_COL, check_tiles};
use super::units::{Found, Part, SITE, Unit, check_names, found, inputs, unit_of_all};
use crate::answer::digest_words;
use crate::digest::Sha256;
use crate::error::{Error, ErrorClass, InputError, RequestError, Result, Warning};
use crate::export::{Format, check_folder, check_layers};
use crate::formats::RasterFile;
use crate::memory::{FIELD_BYTES_PER_CELL, check_memory};
use crate::progress::Progress;
use crate::raster::{Crs, GeoRef};
use crate::read::{StreamedSurface, surface_grid};
use crate::scene::placing::warn_of_uavs_outside;
use crate::scene::{Scene, SceneReader, built_up, is_raster_scene};
use crate::uav::{UavsAsked, UavsFound};
use skyshed_io::error::WriteFault;

/// A run for each unit.
pub(crate) struct UnitRuns<'a> {
    job: &'a MapJob,
    progress: &'a Progress,
    /// The scene, if it was read before.
    given: Option<Scene>,
    kind: Kind,
}

/// What a unit is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Site,
    Tile,
    /// All UAVs together, over all of the ground.
    All,
}

/// What units are asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Purpose {
    /// To run them.
    Map,
    /// To tell of them: nothing is written.
    Tell,
}

/// The units of a run, in order.
pub(crate) struct Units {
    /// All UAVs of the run.
    pub(crate) uavs: UavsFound,
    /// The grid of the whole scene.
    pub(crate) grid: GeoRef,
    pub(crate) parts: Vec<Part>,
    /// What all are made of: the files that they read, or the scene.
    inputs: String,
    /// What the files are.
    files: String,
}

/// Where the scenes of the runs come from.
enum Scenes {
    /// One for all, in memory.
    Whole(Box<Scene>),
    /// One for all, in tiles on disk, with what was said of it.
    OnDisk(StreamedSurface, Vec<Warning>),
    /// The part of a raster file that each needs.
    Parts,
    /// The part that each needs, from a copy on disk, as the file cannot be read in parts.
    PartsOnDisk(StreamedSurface, Vec<Warning>),
}

/// What became of a run of many.
pub(crate) enum Outcome<'a> {
    /// What was said of the UAVs.
    Warnings(&'a [Warning]),
    /// The files of a unit are written.
    Done(&'a Part, &'a Done),
    /// They were there.
    There,
    /// They will not be written.
    Abandoned,
    /// Why they will not be, of all but the first of these.
    Failed(&'a Error),
    /// The files of all UAVs together are written.
    Together(&'a Done),
    /// They were there.
    AllThere,
}

/// Who is told of each outcome, and may fail himself.
pub(crate) type Told<'a, E> = dyn FnMut(Outcome<'_>) -> Result<(), E> + 'a;

impl<'a> UnitRuns<'a> {
    /// The runs that `{site}`, or `{row}` and `{col}`, in names, a tile, or the wish to resume ask for; `None` without any.
    ///
    /// # Errors
    /// E105 if some names hold `{site}` and others do not, or only one of `{row}` and `{col}`; E107, E116 for what tiles cannot hold.
    pub(crate) fn of(
        job: &'a MapJob,
        given: Option<Scene>,
        (purpose, progress): (Purpose, &'a Progress),
    ) -> Result<Option<UnitRuns<'a>>> {
        let files: Vec<&PathBuf> = job.outputs.iter().chain(&job.curve.outputs).collect();
        let holds = |path: &Path, word: &str| path.to_string_lossy().contains(word);
        let names_site = |path: &Path| holds(path, SITE);
        let names_tile = |path: &Path| ROW_AND_COL.iter().any(|word| holds(path, word));
        let n_sites = files.iter().filter(|path| names_site(path)).count();
        let n_tiles = files.iter().filter(|path| names_tile(path)).count();
        let kind = match (n_sites, n_tiles) {
            _ if n_tiles > 0 || !job.tiles.only.is_empty() => Kind::Tile,
            (1.., _) => Kind::Site,
            _ => Kind::All,
        };
        if kind == Kind::All && !job.request.units.resume {
            return Ok(None);
        }
        if files.is_empty() && (job.request.units.resume || kind != Kind::Tile) {
            return Err(RequestError::NothingToResume.into());
        }
        // Folders named after units are made with their files.
        let is_shared =
            |path: &&&PathBuf| !path.parent().is_some_and(|folder| names_site(folder) || names_tile(folder));
        let writes = purpose == Purpose::Map;
        files.iter().filter(is_shared).filter(|_| writes).try_for_each(|path| check_folder(path))?;
        let other = |is_named: &dyn Fn(&Path) -> bool| files.iter().find(|path| !is_named(path));
        let told = |path: &PathBuf| path.display().to_string();
        match kind {
            Kind::Site => {
                if let Some(path) = other(&names_site) {
                    return Err(RequestError::NotNamedAfterUavs(told(path)).into());
                }
            }
            Kind::Tile => {
                // Row 1 and column 11 must not be called as row 11 and column 1 are.
                let is_apart = |path: &Path| !holds(path, "{row}{col}") && !holds(path, "{col}{row}");
                let is_whole = |path: &Path| {
                    ROW_AND_COL.iter().all(|word| holds(path, word)) && is_apart(path) && !names_site(path)
                };
                if let Some(path) = other(&is_whole).filter(|_| n_tiles > 0 || n_sites > 0 || job.tiles.only.len() > 1)
                {
                    return Err(RequestError::NotNamedAfterTiles(told(path)).into());
                }
                check_tiles(job)?;
            }
            Kind::All => {}
        }
        Ok(Some(UnitRuns { job, progress, given, kind }))
    }

    /// Runs all that is not done, and tells `each` of every run.
    ///
    /// # Errors
    /// Of the first unit that failed, once all others are done; at once if the user interrupts.
    pub(crate) fn run<E: From<Error>>(&self, each: &mut Told<'_, E>) -> Result<(), E> {
        if self.kind == Kind::All {
            return self.run_together(each);
        }
        let (mut scenes, units) = self.scenes_and_units()?;
        each(Outcome::Warnings(&units.uavs.warnings))?;
        let mut failed: Option<Error> = None;
        for part in &units.parts {
            match self.run_unit(self.unit(&units, part), &mut scenes, &units) {
                Ok(Some(done)) => each(Outcome::Done(part, &done))?,
                Ok(None) => each(Outcome::There)?,
                Err(error) if error.class() == ErrorClass::Interrupted => {
                    failed.into_iter().try_for_each(|first| each(Outcome::Failed(&first)))?;
                    return Err(error.into());
                }
                Err(error) => {
                    let error = error.of_unit(&part.name());
                    // The first one is told at the end.
                    if failed.is_some() {
                        each(Outcome::Failed(&error))?;
                    }
                    let first = failed.get_or_insert(error);
                    if let Err(interrupted) = each(Outcome::Abandoned) {
                        each(Outcome::Failed(first))?;
                        return Err(interrupted);
                    }
                }
            }
        }
        failed.map_or(Ok(()), |error| Err(error.into()))
    }

    /// The units, without running them; `None` where all UAVs are one run.
    ///
    /// # Errors
    /// Those of the scene and the UAVs.
    pub(crate) fn units(&self) -> Result<Option<Units>> {
        if self.kind == Kind::All { Ok(None) } else { Ok(Some(self.scenes_and_units()?.1)) }
    }

    fn scenes_and_units(&self) -> Result<(Option<Scenes>, Units)> {
        let (scenes, grid) = self.scenes_or_grid()?;
        let job = self.job;
        // The shard is one of the units: a tile has all of its UAVs, and names are told apart among all.
        let shard = job.uavs.shard;
        let mut uavs = UavsAsked { shard: None, ..job.uavs.clone() }.read(&grid)?;
        if self.kind == Kind::Tile {
            warn_of_uavs_outside(&uavs.sites, &grid, &mut uavs.warnings);
        }
        let parts = match self.kind {
            Kind::Tile => {
                for path in &job.outputs {
                    check_layers(&job.plan.layers, uavs.sites.len(), path, Format::of(path)?)?;
                }
                let tiles = job.tiles.tiles((&grid, shard), &uavs.sites, &job.plan.sight)?;
                tiles.into_iter().map(Part::Tile).collect()
            }
            _ => {
                check_names(&uavs.sites)?;
                let range = shard.map_or(0..uavs.sites.len(), |shard| shard.range(uavs.sites.len()));
                uavs.sites[range].iter().cloned().map(Part::Site).collect()
            }
        };
        let files = inputs(job, false)?;
        Ok((scenes, Units { uavs, grid, parts, inputs: format!("{files}{}", self.of_memory()), files }))
    }

    /// A part as a unit.
    pub(crate) fn unit(&self, units: &Units, part: &Part) -> Unit {
        Unit::of(self.job, (part, &units.uavs.sites), &units.inputs)
    }

    /// One run of all UAVs, unless its files are there.
    fn run_together<E: From<Error>>(&self, each: &mut Told<'_, E>) -> Result<(), E> {
        let unit = unit_of_all(self.job, &(inputs(self.job, true)? + &self.of_memory()));
        let mut job = self.job.clone();
        match found(&job, &unit)? {
            Found::All => return each(Outcome::AllThere),
            Found::Some | Found::Damaged(_) => job.save.writing.overwrite = true,
            Found::Nothing => {}
        }
        let scene = self.given.clone().map_or(GivenScene::Asked, |scene| GivenScene::InMemory(Box::new(scene)));
        let done = job.run(Given { unit: Some(unit), scene, ..Given::default() }, self.progress)?;
        each(Outcome::Together(&done))
    }

    /// What tells a scene in memory from another; nothing of one that is read from files, or generated.
    fn of_memory(&self) -> String {
        let is_held =
            |_: &&Scene| !self.job.inputs.iter().any(|file| file.exists()) && built_up(&self.job.word).is_none();
        let Some(scene) = self.given.as_ref().filter(is_held) else { return String::new() };
        // What was not kept cannot be told from anything, and is never the same.
        let bytes = scene.packed().unwrap_or_else(|| format!("{:?}", std::time::SystemTime::now()).into_bytes());
        let mut hasher = Sha256::default();
        hasher.update(bytes);
        format!("{} {:?};", digest_words(hasher), scene.grid().crs().map(Crs::label))
    }

    /// The grid of the scenes; with them where they must be read to know it.
    fn scenes_or_grid(&self) -> Result<(Option<Scenes>, GeoRef)> {
        let job = self.job;
        if let Some(scene) = &self.given {
            return Ok((Some(Scenes::Whole(Box::new(scene.clone()))), scene.grid().clone()));
        }
        if is_raster_scene(&job.word) && job.scene.options.project.is_none() {
            return Ok((None, surface_grid(job.path(), &job.scene.of_raster()?)?));
        }
        let scene = job.scene.open(&job.word)?;
        let grid = scene.grid().clone();
        Ok((Some(Scenes::Whole(Box::new(scene))), grid))
    }

    /// The scenes of a raster, read as far as they serve every unit.
    ///
    /// With a radius, and of tiles, they are its parts whatever its size: what a file holds must not depend on memory.
    fn scenes(&self) -> Result<Scenes> {
        let job = self.job;
        let mut warnings = Vec::new();
        if self.kind == Kind::Tile || job.reads_range_alone() {
            if job.request.memory.strips {
                let why = "with a radius and a file for each UAV, and of tiles: only what is in range is read";
                return Err(Error::idle("strips", why));
            }
            let files = std::iter::once(job.path()).chain(job.scene.options.terrain.as_deref());
            for file in files {
                if !RasterFile::open(file, &mut Vec::new())?.reads_parts() {
                    let scene = on_disk(job, self.progress, &mut warnings)?;
                    return Ok(Scenes::PartsOnDisk(scene, warnings));
                }
            }
            return Ok(Scenes::Parts);
        }
        if reason_for_strips(job).is_some() {
            check_strips(job)?;
            let scene = on_disk(job, self.progress, &mut warnings)?;
            return Ok(Scenes::OnDisk(scene, warnings));
        }
        Ok(Scenes::Whole(Box::new(job.scene.open(&job.word)?)))
    }

    /// Runs one unit, unless its files are there.
    fn run_unit(&self, unit: Unit, scenes: &mut Option<Scenes>, units: &Units) -> Result<Option<Done>> {
        let Unit { part, hash, mut job } = unit;
        if job.request.units.resume {
            match found(&job, &hash)? {
                Found::All => return Ok(None),
                // A run that was killed between two files leaves the first; a disk may lose the end of one.
                Found::Some | Found::Damaged(_) => job.save.writing.overwrite = true,
                Found::Nothing => {}
            }
        }
        make_folders(&job)?;
        // Nothing is read before there is something to do.
        let given = self.given_of((&part, &job), scenes, units)?;
        let given = Given { unit: Some(hash.clone()), ..given };
        self.check_inputs(units)?;
        match job.run(given, self.progress) {
            // Another process is faster.
            Err(Error::Io(skyshed_io::Error::Write(_, WriteFault::Exists | WriteFault::ExistsMeanwhile)))
                if job.request.units.resume && is_made_by_another(&job, &hash)? =>
            {
                Ok(None)
            }
            Ok(done) => match self.check_inputs(units) {
                Ok(()) => Ok(Some(done)),
                Err(changed) => {
                    // Nobody knows what they were made of.
                    done.written.iter().for_each(|path| drop(std::fs::remove_file(path)));
                    Err(changed)
                }
            },
            Err(error) => Err(error),
        }
    }

    /// Maps the only unit in memory, without a file.
    ///
    /// # Errors
    /// Those of the scene, the UAVs and the plan; a fault of several units.
    pub(crate) fn map(&self) -> Result<Coverages> {
        let (mut scenes, units) = self.scenes_and_units()?;
        let [part] = &units.parts[..] else { return Err(Error::Fault("one unit is mapped at a time")) };
        let job = self.unit(&units, part).job;
        job.map(self.given_of((part, &job), &mut scenes, &units)?, self.progress)
    }

    /// Returns the scene and the UAVs of a unit, read as far as it needs them.
    fn given_of<'u>(
        &self,
        (part, job): (&'u Part, &MapJob),
        scenes: &'u mut Option<Scenes>,
        units: &'u Units,
    ) -> Result<Given<'u>> {
        let scenes = match scenes {
            Some(scenes) => scenes,
            None => scenes.insert(self.scenes()?),
        };
        let grid = &units.grid;
        let (own, around, tile) = match part {
            // Which table it stood in is nothing that its files depend on.
            Part::Site(site) => {
                let around = job.plan.sight.box_in_range(std::slice::from_ref(site), grid);
                (UavsFound { sites: vec![site.clone()], ..UavsFound::default() }, around, None)
            }
            Part::Tile(tile) => {
                let own = tile.own(&units.uavs.sites);
                let around = tile.box_with(&own, grid);
                (own, Some(around), Some((tile, units.uavs.sites.len())))
            }
        };
        let scene = match scenes {
            Scenes::Whole(scene) => {
                let mut scene = scene.clone();
                tile.into_iter()
                    .for_each(|(tile, _)| scene.keep_for(tile.window, grid.window_within(around.unwrap_or_default())));
                GivenScene::InMemory(scene)
            }
            Scenes::OnDisk(scene, warnings) => GivenScene::OnDisk(scene, warnings.clone()),
            Scenes::Parts => GivenScene::InMemory(Box::new(self.part((around, grid), None)?)),
            Scenes::PartsOnDisk(scene, warnings) => {
                GivenScene::InMemory(Box::new(self.part((around, grid), Some((scene, warnings)))?))
            }
        };
        Ok(Given { uavs: Some(own), scene, grid: Some(grid), tile, unit: None })
    }

    /// Refuses inputs that are not those that the units were told by.
    fn check_inputs(&self, units: &Units) -> Result<()> {
        if inputs(self.job, false)? == units.files {
            return Ok(());
        }
        Err(InputError::Changed(self.job.word.display().to_string()).into())
    }

    /// The part of a raster in a box.
    fn part(
        &self,
        (around, grid): (Option<[f64; 4]>, &GeoRef),
        stored: Option<(&StreamedSurface, &[Warning])>,
    ) -> Result<Scene> {
        let start = Instant::now();
        let job = self.job;
        let Some((stored, said)) = stored else {
            return SceneReader { around, ..job.scene.clone() }.open(&job.word);
        };
        let window = grid.window_within(around.unwrap_or_default());
        check_memory(&job.word.display(), &grid.part(window), FIELD_BYTES_PER_CELL)?;
        Scene::built(&job.scene, (&job.word, stored.part(window)?), said.to_vec(), start)
    }
}

/// Waits until the files of a unit that another process makes are complete, but not for ever.
fn is_made_by_another(job: &MapJob, hash: &str) -> Result<bool> {
    /// With a part of them there, and without: names are given one right after the other.
    const PATIENCE: [Duration; 2] = [Duration::from_secs(10), Duration::from_millis(500)];
    let start = Instant::now();
    loop {
        let last = found(job, hash);
        let patience = PATIENCE[usize::from(last != Ok(Found::Some))];
        match last {
            Ok(Found::All) => return Ok(true),
            // A file that is there may lack for a moment what says what it is.
            last if start.elapsed() > patience => return last.map(|_| false),
            _ => std::thread::sleep(Duration::from_millis(20)),
        }
    }
}

/// Makes the folders that are named after a unit.
fn make_folders(job: &MapJob) -> Result<()> {
    for path in job.outputs.iter().chain(&job.curve.outputs) {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty() && !folder.exists());
        if let Some(folder) = folder {
            let refused = |e| WriteFault::Refused(format!("folder {} cannot be made: {e}", folder.display()));
            std::fs::create_dir_all(folder)
                .map_err(|e| Error::Io(skyshed_io::Error::Write(path.display().to_string(), refused(e))))?;
        }
    }
    Ok(())
}
