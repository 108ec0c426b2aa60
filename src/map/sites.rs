//! A map with `{site}` in the names of its files: a run of its own for each UAV, which can be asked for again.
//!
//! Each UAV is a unit of work: its files hold what the run was made of (`unit`, a hash of the inputs, the options and the
//! UAV), they appear when all of them are complete, and a run that resumes leaves those alone that are there. So an
//! interrupted run goes on where it stopped, and another program may hand out UAVs one by one, and hand them out again.

use std::ffi::OsStr;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::time::Instant;

use super::curve::CurvePlan;
use super::job::{Done, Given, GivenScene, MapJob};
use super::save_options::SaveOptions;
use super::strips::{check_strips, on_disk, reason_for_strips};
use crate::answer::digest_words;
use crate::city::GivenSite;
use crate::digest::Sha256;
use crate::error::{Error, ErrorClass, PlacesError, RequestError, Result, Warning};
use crate::export::{Format, check_folder, sidecars, site_in_names, with_suffix};
use crate::formats::{RasterFile, origin_of};
use crate::memory::{FIELD_BYTES_PER_CELL, check_memory};
use crate::os_words::split;
use crate::progress::Progress;
use crate::raster::GeoRef;
use crate::read::{StreamedSurface, source_of, surface_grid};
use crate::scene::{Scene, SceneOptions, is_raster_scene};
use crate::uav::UavsFound;
use skyshed_io::error::WriteFault;

/// What stands for the name of a UAV in the name of a file.
pub(crate) const SITE: &str = "{site}";

/// A run for each UAV.
pub(crate) struct SiteRuns<'a> {
    job: &'a MapJob,
    progress: &'a Progress,
    /// The scene, if it was read before.
    given: Option<Scene>,
}

/// Where the scenes of the runs come from.
enum SiteScenes {
    /// One for all, in memory.
    Whole(Box<Scene>),
    /// One for all, in tiles on disk, with what was said of it.
    OnDisk(StreamedSurface, Vec<Warning>),
    /// The part of a raster file in range of each.
    Parts,
    /// The part in range of each, from a copy on disk, as the file cannot be read in parts.
    PartsOnDisk(StreamedSurface, Vec<Warning>),
}

/// What became of a run of many.
pub(crate) enum Outcome<'a> {
    /// What was said of the UAVs.
    Warnings(&'a [Warning]),
    /// The files of a UAV are written.
    Done(&'a str, &'a Done),
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

/// What became of the files of a UAV.
#[derive(PartialEq, Eq)]
enum Found {
    Nothing,
    /// Some are there, all of them of this unit.
    Some,
    All,
}

impl<'a> SiteRuns<'a> {
    /// The runs that `{site}` in names, or the wish to resume, asks for; `None` without either.
    ///
    /// # Errors
    /// E105 if some names hold `{site}` and others do not.
    pub(crate) fn of(job: &'a MapJob, given: Option<Scene>, progress: &'a Progress) -> Result<Option<SiteRuns<'a>>> {
        let files: Vec<&PathBuf> = job.outputs.iter().chain(&job.curve.outputs).collect();
        let names = |path: &Path| path.to_string_lossy().contains(SITE);
        let n_named = files.iter().filter(|path| names(path)).count();
        if n_named == 0 && !job.resume {
            return Ok(None);
        }
        if files.is_empty() {
            return Err(RequestError::NothingToResume.into());
        }
        // Those in folders named after UAVs are checked with each of them.
        let folders_are_shared = |path: &&&PathBuf| !path.parent().is_some_and(names);
        files.iter().filter(folders_are_shared).try_for_each(|path| check_folder(path))?;
        if let Some(other) = files.iter().find(|path| n_named > 0 && !names(path)) {
            return Err(RequestError::NotNamedAfterUavs(other.display().to_string()).into());
        }
        Ok(Some(SiteRuns { job, progress, given }))
    }

    /// Runs all that is not done, and tells `each` of every run.
    ///
    /// # Errors
    /// Of the first UAV that failed, once all others are done; at once if the user interrupts.
    pub(crate) fn run<E: From<Error>>(&self, each: &mut Told<'_, E>) -> Result<(), E> {
        if !self.is_by_site() {
            return self.run_together(each);
        }
        let (mut scenes, grid) = self.scenes_or_grid()?;
        let uavs = self.job.uavs.read(&grid)?;
        each(Outcome::Warnings(&uavs.warnings))?;
        let jobs = self.jobs(&uavs.sites)?;
        let inputs = self.inputs(false)?;
        let mut failed: Option<Error> = None;
        for (site, job) in uavs.sites.iter().zip(jobs) {
            let unit = self.unit(Some(site), &inputs);
            // Which table it stood in is nothing that its files depend on.
            let own = UavsFound { sites: vec![site.clone()], ..UavsFound::default() };
            match self.run_site(job, (&mut scenes, &grid), (own, &unit)) {
                Ok(Some(done)) => each(Outcome::Done(&site.id, &done))?,
                Ok(None) => each(Outcome::There)?,
                Err(error) if error.class() == ErrorClass::Interrupted => {
                    failed.into_iter().try_for_each(|first| each(Outcome::Failed(&first)))?;
                    return Err(error.into());
                }
                Err(error) => {
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

    fn is_by_site(&self) -> bool {
        self.job.outputs.iter().chain(&self.job.curve.outputs).any(|path| path.to_string_lossy().contains(SITE))
    }

    /// One run of all UAVs, unless its files are there.
    fn run_together<E: From<Error>>(&self, each: &mut Told<'_, E>) -> Result<(), E> {
        let unit = self.unit(None, &self.inputs(true)?);
        let mut job = self.job.clone();
        match found(&job, &unit)? {
            Found::All => return each(Outcome::AllThere),
            Found::Some => job.save.overwrite = true,
            Found::Nothing => {}
        }
        let scene = self.given.clone().map_or(GivenScene::Asked, |scene| GivenScene::InMemory(Box::new(scene)));
        let done = job.run(Given { unit: Some(unit), scene, ..Given::default() }, self.progress)?;
        each(Outcome::Together(&done))
    }

    /// The grid of the scenes; with them where they must be read to know it.
    fn scenes_or_grid(&self) -> Result<(Option<SiteScenes>, GeoRef)> {
        let job = self.job;
        if let Some(scene) = &self.given {
            return Ok((Some(SiteScenes::Whole(Box::new(scene.clone()))), scene.grid().clone()));
        }
        if is_raster_scene(&job.word) && job.scene.project.is_none() {
            return Ok((None, surface_grid(job.path(), &job.scene.of_raster()?)?));
        }
        let scene = job.scene.open(&job.word)?;
        let grid = scene.grid().clone();
        Ok((Some(SiteScenes::Whole(Box::new(scene))), grid))
    }

    /// The scenes, read as far as they serve every UAV.
    ///
    /// With a radius of a raster they are its parts whatever its size: what a file holds must not depend on memory.
    fn scenes(&self) -> Result<SiteScenes> {
        let job = self.job;
        let mut warnings = Vec::new();
        if job.reads_range_alone() {
            if job.strips {
                let why = "with a radius and a file for each UAV: only what is in range is read";
                return Err(Error::idle("strips", why));
            }
            let files = std::iter::once(job.path()).chain(job.scene.terrain.as_deref());
            for file in files {
                if !RasterFile::open(file, &mut Vec::new())?.reads_parts() {
                    let scene = on_disk(job, self.progress, &mut warnings)?;
                    return Ok(SiteScenes::PartsOnDisk(scene, warnings));
                }
            }
            return Ok(SiteScenes::Parts);
        }
        if reason_for_strips(job).is_some() {
            check_strips(job)?;
            let scene = on_disk(job, self.progress, &mut warnings)?;
            return Ok(SiteScenes::OnDisk(scene, warnings));
        }
        Ok(SiteScenes::Whole(Box::new(job.scene.open(&job.word)?)))
    }

    /// What each UAV's run was asked, with files of its own.
    fn jobs(&self, sites: &[GivenSite]) -> Result<Vec<MapJob>> {
        let mut names = std::collections::HashMap::new();
        let mut jobs = Vec::with_capacity(sites.len());
        for site in sites {
            let name = site_in_names(&site.id);
            if let Some(other) = names.insert(name.clone(), &site.id) {
                let file = format!("the files of `{name}`");
                return Err(PlacesError::SharedFile { a: (*other).clone(), b: site.id.clone(), file }.into());
            }
            let own = |paths: &[PathBuf]| -> Vec<PathBuf> {
                paths.iter().map(|path| split(path.as_os_str(), SITE).join(OsStr::new(&name)).into()).collect()
            };
            let curve = CurvePlan { outputs: own(&self.job.curve.outputs), ..self.job.curve.clone() };
            jobs.push(MapJob { outputs: own(&self.job.outputs), curve, ..self.job.clone() });
        }
        Ok(jobs)
    }

    /// Maps one UAV, unless its files are there.
    fn run_site(
        &self,
        mut job: MapJob,
        (scenes, grid): (&mut Option<SiteScenes>, &GeoRef),
        (own, unit): (UavsFound, &str),
    ) -> Result<Option<Done>> {
        if job.resume {
            match found(&job, unit)? {
                Found::All => return Ok(None),
                // A run that was killed between two files leaves the first.
                Found::Some => job.save.overwrite = true,
                Found::Nothing => {}
            }
        }
        // Nothing is read before there is something to do.
        let scenes = match scenes {
            Some(scenes) => scenes,
            None => scenes.insert(self.scenes()?),
        };
        let site = &own.sites[0];
        let uav = format!("{},{},{}", site.x, site.y, site.height);
        job.command = job.unit_command.iter().cloned().chain(["--uav".into(), uav]).collect();
        let scene = match scenes {
            SiteScenes::Whole(scene) => GivenScene::InMemory(scene.clone()),
            SiteScenes::OnDisk(scene, warnings) => GivenScene::OnDisk(scene, warnings.clone()),
            SiteScenes::Parts => GivenScene::InMemory(Box::new(self.part((site, grid), None)?)),
            SiteScenes::PartsOnDisk(scene, warnings) => {
                GivenScene::InMemory(Box::new(self.part((site, grid), Some((scene, warnings)))?))
            }
        };
        let given = Given { uavs: Some(own), scene, grid: Some(grid), unit: Some(unit.to_string()) };
        match job.run(given, self.progress) {
            // Another process was faster.
            Err(Error::Io(skyshed_io::Error::Write(_, WriteFault::Exists | WriteFault::ExistsMeanwhile)))
                if job.resume && found(&job, unit)? == Found::All =>
            {
                Ok(None)
            }
            done => done.map(Some),
        }
    }

    /// The part of a raster in range of a UAV.
    fn part(
        &self,
        (site, grid): (&GivenSite, &GeoRef),
        stored: Option<(&StreamedSurface, &[Warning])>,
    ) -> Result<Scene> {
        let start = Instant::now();
        let job = self.job;
        let options = job.of_range(std::slice::from_ref(site), grid).scene;
        let Some((stored, said)) = stored else { return options.open(&job.word) };
        let window = grid.window_within(options.around.unwrap_or_default());
        check_memory(&job.word.display(), &grid.part(window), FIELD_BYTES_PER_CELL)?;
        Scene::built(&job.scene, (&job.word, stored.part(window)?), said.to_vec(), start)
    }

    /// What the run of a UAV, or of all, is one of: a hash of everything that its files depend on.
    fn unit(&self, site: Option<&GivenSite>, inputs: &str) -> String {
        let MapJob { word, scene, plan, save, uavs, curve, .. } = self.job;
        // What changes no number.
        let scene = SceneOptions { repairs: None, ..scene.clone() };
        let save = SaveOptions { overwrite: false, ..save.clone() };
        let uavs = if site.is_some() { None } else { Some(uavs) };
        let of_run = (word, scene, plan, save, uavs, curve.heights);
        let mut hasher = Sha256::default();
        hasher.update(format!("{} {of_run:?} {site:?} {inputs}", env!("CARGO_PKG_VERSION")));
        digest_words(hasher)
    }

    /// The files that all runs read, told by path, length and time of change; with that of the UAVs where these are not told
    /// one by one.
    fn inputs(&self, with_sites: bool) -> Result<String> {
        let mut files = self.job.inputs.clone();
        let table = self.job.uavs.table.clone().filter(|_| with_sites);
        // What comes from standard input is told by its digest.
        let mut text = match &table {
            Some(table) if !table.exists() => format!("{:?};", source_of(table, false)?),
            _ => String::new(),
        };
        files.extend(table);
        for file in files.iter().filter(|file| file.exists()).flat_map(|file| parts_of(file)) {
            let metadata = std::fs::metadata(&file).map_err(|e| skyshed_io::cannot_read(&file.as_path().into(), &e))?;
            text += &format!("{} {} {:?};", file.display(), metadata.len(), metadata.modified().ok());
        }
        Ok(text)
    }
}

/// Which of the files of a run are there, made by a unit.
///
/// A file appears after what stands beside it, so that one that is there is complete; what stands there alone was left by a
/// run that was killed.
///
/// # Errors
/// E106 if one is there that is not of this unit, unless it may be replaced.
fn found(job: &MapJob, unit: &str) -> Result<Found> {
    let files: Vec<&PathBuf> = job.outputs.iter().chain(&job.curve.outputs).collect();
    let there: Vec<&PathBuf> = files.iter().copied().filter(|file| file.exists()).collect();
    let other = there.iter().find(|file| !is_of(file, unit));
    let is_left_alone = |file: &PathBuf| {
        let beside = Format::of(file).map_or_else(|_| Vec::new(), |format| sidecars(file, format, job.save.bare));
        !file.exists() && beside.iter().any(|sidecar| sidecar.exists())
    };
    match other {
        Some(_) if job.save.overwrite => Ok(Found::Nothing),
        Some(other) => Err(RequestError::OfAnotherRun(other.display().to_string()).into()),
        None if there.len() == files.len() => Ok(Found::All),
        None if !there.is_empty() || files.iter().any(|file| is_left_alone(file)) => Ok(Found::Some),
        None => Ok(Found::Nothing),
    }
}

/// The files that an input consists of, and what may stand beside them.
fn parts_of(input: &Path) -> Vec<PathBuf> {
    let tiles = RasterFile::open(input, &mut Vec::new())
        .map(|file| file.tile_paths().iter().map(|path| path.to_path_buf()).collect::<Vec<_>>());
    let files = std::iter::once(input.to_path_buf()).chain(tiles.unwrap_or_default());
    let with_others = files.flat_map(|file| {
        let others = ["prj", "tfw", "shx", "dbf", "cpg"].map(|extension| file.with_extension(extension));
        let suffixed = [".aux.xml", ".msk", ".ovr"].map(|suffix| with_suffix(&file, suffix));
        others.into_iter().chain(suffixed).filter(|other| other.exists()).chain([file.clone()]).collect::<Vec<_>>()
    });
    with_others.collect()
}

/// Whether a file was made by a unit: its hash is in what the file, or the document beside it, says of its origin, or among
/// its bytes as they are or as members of an archive.
fn is_of(file: &Path, unit: &str) -> bool {
    let in_file = |path: &Path| std::fs::File::open(path).is_ok_and(|file| holds(file, unit.as_bytes()));
    let in_archive = |path: &Path| {
        let archive = std::fs::File::open(path).map_err(zip::result::ZipError::from).and_then(zip::ZipArchive::new);
        archive.is_ok_and(|mut archive| {
            (0..archive.len()).any(|k| archive.by_index(k).is_ok_and(|member| holds(member, unit.as_bytes())))
        })
    };
    origin_of(file).is_some_and(|origin| origin.contains(unit))
        || in_file(&with_suffix(file, ".json"))
        || in_file(file)
        || in_archive(file)
}

/// Whether bytes are among those of a file.
fn holds(mut file: impl Read, wanted: &[u8]) -> bool {
    const BLOCK: usize = 1 << 20;
    // The end of each block is looked at again with the next one.
    let mut window = Vec::with_capacity(BLOCK + wanted.len());
    loop {
        let kept = window.len().min(wanted.len() - 1);
        window.drain(..window.len() - kept);
        let n = file.by_ref().take(BLOCK as u64).read_to_end(&mut window);
        if window.windows(wanted.len()).any(|bytes| bytes == wanted) {
            return true;
        }
        if !matches!(n, Ok(n) if n > 0) {
            return false;
        }
    }
}
