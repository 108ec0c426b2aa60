//! Maps in units of work: one run for each UAV or each tile of the ground, which can be resumed.
//!
//! With `{site}` in the names of its files each UAV is a unit of work, with `{row}` and `{col}`
//! each tile. The files of a unit hold `unit`, a hash of the inputs, the options, and the UAV or
//! the tile. All files of a unit appear at once, when the last is complete. A run that resumes keeps the files that
//! exist.
//!
//! So an interrupted run continues at the unit where it stopped. Another program may start units
//! one by one, and start them again.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::coverages::Coverages;
use super::job::{Done, Given, GivenScene, MapJob, names_tile};
use super::strips::{check_strips, on_disk, reason_for_strips};
use super::tiles::ROW_AND_COL;
use super::units::{Found, Part, SITE, Unit, check_names, check_tiles, found, inputs, unit_of_all};
use crate::answer::digest_words;
use crate::city::GivenSite;
use crate::digest::Sha256;
use crate::error::{Error, ErrorKind, ErrorRepr, InputError, PlacesError, RequestError, Result, Warning};
use crate::export::{Format, check_folder, check_layers, place_of};
use crate::formats::RasterFile;
use crate::memory::{FIELD_BYTES_PER_CELL, check_memory};
use crate::progress::Progress;
use crate::raster::{Crs, GeoRef};
use crate::read::{StreamedSurface, surface_grid};
use crate::scene::placing::warn_of_uavs_outside;
use crate::scene::{Scene, SceneReader, built_up, is_raster_scene};
use crate::uav::{UavsAsked, UavsFound};
use skyshed_io::error::WriteFault;
use skyshed_request::Shard;

/// Runs of a map, one for each unit of work.
pub(crate) struct UnitRuns<'a> {
    job: &'a MapJob,
    progress: &'a Progress,
    /// Scene, if it was read before.
    given: Option<Scene>,
    kind: Kind,
}

/// Kind of a unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Site,
    Tile,
    /// All UAVs together, over the whole ground.
    All,
}

/// Purpose for which units are listed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Purpose {
    /// The units are run.
    Map,
    /// The units are described; nothing is written.
    Tell,
}

/// Units of a run, in order.
pub(crate) struct Units {
    /// All UAVs of the run.
    pub(crate) uavs: UavsFound,
    /// The grid of the whole scene.
    pub(crate) grid: GeoRef,
    pub(crate) parts: Vec<Part>,
    /// Identity of the inputs of all units: the files, and a scene in memory.
    inputs: String,
    /// Identity of the files alone.
    files: String,
}

/// Source of the scenes of the runs.
enum Scenes {
    /// One scene for all units, in memory.
    Whole(Box<Scene>),
    /// One scene for all units, in tiles on disk, with the warnings of reading it.
    OnDisk(StreamedSurface, Vec<Warning>),
    /// The part of a raster file that each unit needs.
    Parts,
    /// The part that each unit needs, from a copy on disk: the file itself cannot be read in parts.
    PartsOnDisk(StreamedSurface, Vec<Warning>),
}

/// Event while the units of a map are run.
pub(crate) enum Outcome<'a> {
    /// Warnings about the UAVs.
    Warnings(&'a [Warning]),
    /// The files of a unit are written.
    Done(&'a Part, &'a Done),
    /// The files of a unit existed already.
    There,
    /// A unit failed: its files will not be written.
    Abandoned,
    /// Error of a failed unit. The first failure is returned by `run` instead, unless the user
    /// interrupts.
    Failed(&'a Error),
    /// The files of all UAVs together are written.
    Together(&'a Done),
    /// The files of all UAVs together existed already.
    AllThere,
}

/// Callback that receives each outcome and may fail itself.
pub(crate) type Told<'a, E> = dyn FnMut(Outcome<'_>) -> Result<(), E> + 'a;

impl<'a> UnitRuns<'a> {
    /// Returns the runs that `{site}`, or `{row}` and `{col}`, in file names, a named tile or
    /// `--resume` ask for; `None` without any of these.
    ///
    /// # Errors
    /// E105 if only some names hold `{site}`, or a name lacks one of `{row}` and `{col}`. E107,
    /// E116 for what tiles cannot hold; E116 without a file to resume.
    pub(crate) fn of(
        job: &'a MapJob,
        given: Option<Scene>,
        (purpose, progress): (Purpose, &'a Progress),
    ) -> Result<Option<UnitRuns<'a>>> {
        let files: Vec<&PathBuf> = job.files().collect();
        let holds = |path: &Path, word: &str| path.to_string_lossy().contains(word);
        let names_site = |path: &Path| holds(path, SITE);
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
        // Folders named after units are created with the units' files.
        let is_shared =
            |path: &&&PathBuf| !path.parent().is_some_and(|folder| names_site(folder) || names_tile(folder));
        let writes = purpose == Purpose::Map;
        files.iter().filter(is_shared).filter(|_| writes).try_for_each(|path| check_folder(path))?;
        let other = |is_named: &dyn Fn(&Path) -> bool| files.iter().find(|path| !is_named(path));
        let told = |path: &PathBuf| path.display().to_string();
        match kind {
            Kind::Site => {
                if let Some(option) = job.plan.option_of_time() {
                    return Err(Error::idle(option, "for single UAVs: it is about all of them"));
                }
                if let Some(path) = other(&names_site) {
                    return Err(RequestError::NotNamedAfterUavs(told(path)).into());
                }
            }
            Kind::Tile => {
                // Without a separator, row 1 and column 11 would share a name with row 11 and
                // column 1.
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

    /// Runs every unit that is not done, and reports each outcome to `each`.
    ///
    /// # Errors
    /// Error of the first unit that failed, once all others are done. An interrupt is returned at
    /// once.
    pub(crate) fn run<E: From<Error>>(&self, each: &mut Told<'_, E>) -> Result<(), E> {
        if self.kind == Kind::All {
            return self.run_together(each);
        }
        let (mut scenes, units) = self.scenes_and_units()?;
        each(Outcome::Warnings(&units.uavs.warnings))?;
        self.check_links(&units)?;
        let mut failed: Option<Error> = None;
        for part in &units.parts {
            match self.run_unit(self.unit(&units, part), &mut scenes, &units) {
                Ok(Some(done)) => each(Outcome::Done(part, &done))?,
                Ok(None) => each(Outcome::There)?,
                Err(error) if error.kind() == ErrorKind::Interrupted => {
                    failed.into_iter().try_for_each(|first| each(Outcome::Failed(&first)))?;
                    return Err(error.into());
                }
                Err(error) => {
                    let error = error.of_unit(&part.name());
                    // The first failure is reported at the end.
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

    /// Refuses two units of which one would replace a file of the other, through a link. Units of
    /// other shards count too.
    fn check_links(&self, units: &Units) -> Result<()> {
        let files = |part: &Part| [part.names(&self.job.outputs), part.names(&self.job.curve.outputs)].concat();
        let is_link = |path: &PathBuf| path.is_symlink() || path.parent().is_some_and(Path::is_symlink);
        if !units.parts.iter().any(|part| files(part).iter().any(is_link)) {
            return Ok(());
        }
        let mut places = HashMap::new();
        for part in self.parts(&units.grid, &units.uavs.sites, None)? {
            for path in files(&part) {
                if let Some(a) = places.insert(place_of(&path), part.name()) {
                    let file = path.display().to_string();
                    return Err(PlacesError::SharedFile { a, b: part.name(), file }.into());
                }
            }
        }
        Ok(())
    }

    /// Returns the units without running them; `None` if all UAVs are one run.
    ///
    /// # Errors
    /// Errors of the scene and of the UAVs.
    pub(crate) fn units(&self) -> Result<Option<Units>> {
        if self.kind == Kind::All { Ok(None) } else { Ok(Some(self.scenes_and_units()?.1)) }
    }

    fn scenes_and_units(&self) -> Result<(Option<Scenes>, Units)> {
        let (scenes, grid) = self.scenes_or_grid()?;
        let job = self.job;
        // A shard selects units, not UAVs: a tile has all of its UAVs, and names must differ among
        // all UAVs.
        let mut uavs = UavsAsked { shard: None, ..job.uavs.clone() }.read(&grid)?;
        if uavs.home.is_some() {
            return Err(Error::idle(
                "uavs",
                "of a mission with heights above its home, where each UAV or tile has files of its own",
            ));
        }
        match self.kind {
            Kind::Tile => {
                warn_of_uavs_outside(&uavs.sites, &grid, &mut uavs.warnings);
                for path in &job.outputs {
                    check_layers(&job.plan.layers, uavs.sites.len(), path, Format::of(path)?)?;
                }
            }
            _ => check_names(&uavs.sites)?,
        }
        let parts = self.parts(&grid, &uavs.sites, job.uavs.shard)?;
        let files = inputs(job, false)?;
        Ok((scenes, Units { uavs, grid, parts, inputs: format!("{files}{}", self.of_memory()), files }))
    }

    /// Returns the parts of a job, or of a shard of it.
    fn parts(&self, grid: &GeoRef, sites: &[GivenSite], shard: Option<Shard>) -> Result<Vec<Part>> {
        if self.kind == Kind::Tile {
            let tiles = self.job.tiles.tiles((grid, shard), sites, &self.job.plan.sight)?;
            return Ok(tiles.into_iter().map(Part::Tile).collect());
        }
        let range = shard.map_or(0..sites.len(), |shard| shard.range(sites.len()));
        Ok(sites[range].iter().cloned().map(Part::Site).collect())
    }

    /// Returns the unit of a part.
    pub(crate) fn unit(&self, units: &Units, part: &Part) -> Unit {
        Unit::of(self.job, (part, &units.uavs.sites), &units.inputs)
    }

    /// Runs all UAVs as one unit, unless its files exist.
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

    /// Returns text that identifies a scene in memory; empty for a scene that is read from files or
    /// generated.
    fn of_memory(&self) -> String {
        let is_held =
            |_: &&Scene| !self.job.inputs.iter().any(|file| file.exists()) && built_up(&self.job.word).is_none();
        let Some(scene) = self.given.as_ref().filter(is_held) else { return String::new() };
        // A scene that cannot be packed has no identity: the time makes it differ from every other.
        let bytes = scene.packed().unwrap_or_else(|| format!("{:?}", std::time::SystemTime::now()).into_bytes());
        let mut hasher = Sha256::default();
        hasher.update(bytes);
        format!("{} {:?};", digest_words(hasher), scene.grid().crs().map(Crs::label))
    }

    /// Returns the grid of the scenes, and the scenes themselves if they are in memory or had to be
    /// read.
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

    /// Returns the scenes of a raster: its parts, a copy on disk, or the whole in memory.
    ///
    /// With a radius, and for tiles, the scenes are parts whatever the size of the raster: the
    /// content of a file must not depend on memory.
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

    /// Runs one unit. Returns `None` if a run that resumes finds its files, or another process
    /// makes them.
    fn run_unit(&self, unit: Unit, scenes: &mut Option<Scenes>, units: &Units) -> Result<Option<Done>> {
        let Unit { part, hash, mut job } = unit;
        if job.request.units.resume {
            match found(&job, &hash)? {
                Found::All => return Ok(None),
                // A killed run leaves the files that it had finished; a disk may lose the end of
                // one.
                Found::Some | Found::Damaged(_) => job.save.writing.overwrite = true,
                Found::Nothing => {}
            }
        }
        let given = self.given_of((&part, &job), scenes, units)?;
        make_folders(&job)?;
        let given = Given { unit: Some(hash.clone()), ..given };
        self.check_inputs(units)?;
        match job.run(given, self.progress) {
            // Another process was faster.
            Err(error) if exists_already(&error) && job.request.units.resume && is_made_by_another(&job, &hash)? => {
                Ok(None)
            }
            Ok(done) => match self.check_inputs(units) {
                Ok(()) => Ok(Some(done)),
                Err(changed) => {
                    // Nobody knows which of the inputs the files were made of.
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
    /// Errors of the scene, the UAVs and the plan; a fault of several units.
    pub(crate) fn map(&self) -> Result<Coverages> {
        let (mut scenes, units) = self.scenes_and_units()?;
        let [part] = &units.parts[..] else { return Err(Error::fault("one unit is mapped at a time")) };
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
        // Scenes are read once the first unit has to run.
        let scenes = match scenes {
            Some(scenes) => scenes,
            None => scenes.insert(self.scenes()?),
        };
        let grid = &units.grid;
        let (own, around, tile) = match part {
            // Files do not depend on the table that a UAV was read from.
            Part::Site(site) => {
                let around = job.plan.sight.box_in_range(std::slice::from_ref(site), grid);
                (UavsFound { sites: vec![site.clone()], bad: units.uavs.bad, ..UavsFound::default() }, around, None)
            }
            Part::Tile(tile) => {
                let own = tile.own(&units.uavs);
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

    /// Refuses inputs that changed since the units were listed.
    fn check_inputs(&self, units: &Units) -> Result<()> {
        if inputs(self.job, false)? == units.files {
            return Ok(());
        }
        Err(InputError::Changed(self.job.word.display().to_string()).into())
    }

    /// Returns the part of a raster in a box.
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

/// Returns `true` for a file that another run has written.
fn exists_already(error: &Error) -> bool {
    use WriteFault::{Exists, ExistsMeanwhile};
    matches!(error.repr(), ErrorRepr::Io(skyshed_io::Error::Write(_, Exists | ExistsMeanwhile)))
}

/// Waits a limited time until another process has completed the files of a unit.
fn is_made_by_another(job: &MapJob, hash: &str) -> Result<bool> {
    /// Limits with some of its files there, and without. Files get their names one right after the
    /// other.
    const PATIENCE: [Duration; 2] = [Duration::from_secs(10), Duration::from_millis(500)];
    let start = Instant::now();
    loop {
        let last = found(job, hash);
        let patience = PATIENCE[usize::from(last != Ok(Found::Some))];
        match last {
            Ok(Found::All) => return Ok(true),
            // A new file may lack its origin for a moment, so an error counts only after the limit.
            last if start.elapsed() > patience => return last.map(|_| false),
            _ => std::thread::sleep(Duration::from_millis(20)),
        }
    }
}

/// Creates the missing folders of a unit's files.
fn make_folders(job: &MapJob) -> Result<()> {
    for path in job.files() {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty() && !folder.exists());
        if let Some(folder) = folder {
            let refused = |e| WriteFault::Refused(format!("folder {} cannot be made: {e}", folder.display()));
            std::fs::create_dir_all(folder)
                .map_err(|e| Error::from(skyshed_io::Error::Write(path.display().to_string(), refused(e))))?;
        }
    }
    Ok(())
}
