//! A map in units: a run of its own for each UAV or each tile of the ground, which can be asked for again.
//!
//! With `{site}` in the names of its files each UAV is a unit of work, with `{row}` and `{col}` each tile. The files of a unit hold
//! what it was made of (`unit`, a hash of the inputs, the options and the UAV or the tile), they appear when all of them are
//! complete, and a run that resumes leaves those alone that are there. So an interrupted run goes on where it stopped, and
//! another program may hand out units one by one, and hand them out again.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::curve::CurvePlan;
use super::job::{Done, Given, GivenScene, MapJob};
use super::strips::{check_strips, on_disk, reason_for_strips};
use super::tiles::{ROW_AND_COL, Tile};
use super::units::{Found, found, inputs, unit_of_all, unit_of_site, unit_of_tile};
use crate::city::GivenSite;
use crate::error::{Error, ErrorClass, InputError, PlacesError, RequestError, Result, Warning};
use crate::export::{Format, Layer, check_folder, check_layers, site_in_names, with_suffix};
use crate::formats::{RasterFile, origin_of};
use crate::los::MethodChoice;
use crate::memory::{FIELD_BYTES_PER_CELL, check_memory};
use crate::os_words::split;
use crate::progress::Progress;
use crate::raster::GeoRef;
use crate::read::{StreamedSurface, surface_grid};
use crate::scene::placing::warn_of_uavs_outside;
use crate::scene::{Scene, SceneOptions, is_raster_scene};
use crate::uav::{UavsAsked, UavsFound};
use serde_json::Value;
use skyshed_io::error::WriteFault;

/// What stands for the name of a UAV in the name of a file.
pub(crate) const SITE: &str = "{site}";

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

/// One UAV, or one tile.
#[derive(Debug, Clone)]
pub(crate) enum Part {
    Site(GivenSite),
    Tile(Tile),
}

impl Part {
    /// What it is called: the name of the UAV, or `tile ROW,COL`.
    pub(crate) fn name(&self) -> String {
        match self {
            Part::Site(site) => site.id.clone(),
            Part::Tile(tile) => format!("tile {},{}", tile.row, tile.col),
        }
    }
}

/// A unit of work.
pub(crate) struct Unit {
    pub(crate) part: Part,
    /// What its files are made of, a hash.
    pub(crate) hash: String,
    /// What it is asked, with files of its own.
    pub(crate) job: MapJob,
}

impl Unit {
    /// Which of its files are there.
    ///
    /// # Errors
    /// E106 if one is there that another run made.
    pub(crate) fn found(&self) -> Result<Found> {
        found(&self.job, &self.hash)
    }

    /// Why one of its files, which are there, is not whole; only of rasters more is looked at than what they say of themselves.
    pub(crate) fn fault(&self) -> Option<Error> {
        self.job
            .outputs
            .iter()
            .filter(|path| Format::of(path).is_ok_and(|f| f == Format::GeoTiff))
            .find_map(|path| RasterFile::open(path, &mut Vec::new()).err().map(Error::from))
    }

    /// What its files say of it: the document of the map.
    pub(crate) fn document(&self) -> Option<Value> {
        let text_of = |path: &PathBuf| {
            let beside = [path.clone(), with_suffix(path, ".json")];
            let mut documents = beside.iter().filter(|file| file.extension().is_some_and(|e| e == "json"));
            origin_of(path.as_path()).or_else(|| documents.find_map(|file| std::fs::read_to_string(file).ok()))
        };
        let documents = self.job.outputs.iter().filter_map(text_of);
        documents
            .filter_map(|text| serde_json::from_str(&text).ok())
            .find(|document: &Value| document.get("sites").is_some())
    }

    /// When the last of its files was written, in seconds since 1970.
    pub(crate) fn written_at(&self) -> u64 {
        let at = |path: &PathBuf| std::fs::metadata(path).and_then(|metadata| metadata.modified()).ok();
        let last = self.job.outputs.iter().filter_map(at).max();
        let since = last.and_then(|at| at.duration_since(std::time::UNIX_EPOCH).ok());
        since.map_or(0, |since| since.as_secs())
    }
}

/// The units of a run, in order.
pub(crate) struct Units {
    /// All UAVs of the run.
    pub(crate) uavs: UavsFound,
    /// The grid of the whole scene.
    pub(crate) grid: GeoRef,
    pub(crate) parts: Vec<Part>,
    /// What the files are that all read.
    inputs: String,
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
        if kind == Kind::All && !job.resume {
            return Ok(None);
        }
        if files.is_empty() && (job.resume || kind != Kind::Tile) {
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
                let tiles = job.tiles.of((&grid, shard), &uavs.sites, &job.plan.sight)?;
                tiles.into_iter().map(Part::Tile).collect()
            }
            _ => {
                check_names(&uavs.sites)?;
                let range = shard.map_or(0..uavs.sites.len(), |shard| shard.range(uavs.sites.len()));
                uavs.sites[range].iter().cloned().map(Part::Site).collect()
            }
        };
        Ok((scenes, Units { uavs, grid, parts, inputs: inputs(job, false)? }))
    }

    /// A part as a unit.
    pub(crate) fn unit(&self, units: &Units, part: &Part) -> Unit {
        let hash = match part {
            Part::Site(site) => unit_of_site(self.job, site, &units.inputs),
            Part::Tile(tile) => unit_of_tile(self.job, (tile, &units.uavs.sites), &units.inputs),
        };
        let words: Vec<(&str, String)> = match part {
            Part::Site(site) => vec![(SITE, site_in_names(&site.id))],
            Part::Tile(tile) => ROW_AND_COL.into_iter().zip([tile.row.to_string(), tile.col.to_string()]).collect(),
        };
        let own = |paths: &[PathBuf]| -> Vec<PathBuf> {
            let named = |path: &PathBuf| {
                let name = path.as_os_str().to_os_string();
                words.iter().fold(name, |name, (word, with)| split(&name, word).join(OsStr::new(with)))
            };
            paths.iter().map(|path| named(path).into()).collect()
        };
        let of_unit = match part {
            Part::Site(site) => ["--uav".into(), format!("{},{},{}", site.x, site.y, site.height)],
            Part::Tile(tile) => ["--tile".into(), format!("{},{}", tile.row, tile.col)],
        };
        let command = self.job.unit_command.iter().cloned().chain(of_unit).collect();
        let curve = CurvePlan { outputs: own(&self.job.curve.outputs), ..self.job.curve.clone() };
        let job = MapJob { outputs: own(&self.job.outputs), curve, command, ..self.job.clone() };
        Unit { part: part.clone(), hash, job }
    }

    /// One run of all UAVs, unless its files are there.
    fn run_together<E: From<Error>>(&self, each: &mut Told<'_, E>) -> Result<(), E> {
        let unit = unit_of_all(self.job, &inputs(self.job, true)?);
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
    fn scenes_or_grid(&self) -> Result<(Option<Scenes>, GeoRef)> {
        let job = self.job;
        if let Some(scene) = &self.given {
            return Ok((Some(Scenes::Whole(Box::new(scene.clone()))), scene.grid().clone()));
        }
        if is_raster_scene(&job.word) && job.scene.project.is_none() {
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
            if job.strips {
                let why = "with a radius and a file for each UAV, and of tiles: only what is in range is read";
                return Err(Error::idle("strips", why));
            }
            let files = std::iter::once(job.path()).chain(job.scene.terrain.as_deref());
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
        let is_damaged = unit.job.resume && unit.fault().is_some();
        let Unit { part, hash, mut job } = unit;
        if job.resume {
            match found(&job, &hash)? {
                // A file that is cut short is made again.
                Found::All if is_damaged => job.save.overwrite = true,
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
        let grid = &units.grid;
        let (own, around, tile) = match &part {
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
        make_folders(&job)?;
        let given = Given { uavs: Some(own), scene, grid: Some(grid), tile, unit: Some(hash.clone()) };
        self.check_inputs(units)?;
        match job.run(given, self.progress) {
            // Another process is faster.
            Err(Error::Io(skyshed_io::Error::Write(_, WriteFault::Exists | WriteFault::ExistsMeanwhile)))
                if job.resume && is_made_by_another(&job, &hash)? =>
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

    /// Refuses inputs that are not those that the units were told by.
    fn check_inputs(&self, units: &Units) -> Result<()> {
        if inputs(self.job, false)? == units.inputs {
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
            return SceneOptions { around, ..job.scene.clone() }.open(&job.word);
        };
        let window = grid.window_within(around.unwrap_or_default());
        check_memory(&job.word.display(), &grid.part(window), FIELD_BYTES_PER_CELL)?;
        Scene::built(&job.scene, (&job.word, stored.part(window)?), said.to_vec(), start)
    }
}

/// Refuses what files of tiles cannot hold: what is told of one UAV, or known of the whole alone.
fn check_tiles(job: &MapJob) -> Result<()> {
    let formats = job.outputs.iter().map(|path| Ok((path, Format::of(path)?))).collect::<Result<Vec<_>>>()?;
    let tells = |format: &Format| matches!(format, Format::Csv | Format::Json | Format::GeoJson | Format::Stdout);
    let of_one = job.plan.layers.iter().find(|layer| !layer.is_of_all());
    if let Some((path, _)) = formats.iter().find(|(_, format)| of_one.is_some() && !tells(format)) {
        let layer = of_one.copied().unwrap_or(Layer::Los).name();
        return Err(RequestError::LayerOfTile { path: path.display().to_string(), layer }.into());
    }
    let why = "with tiles, which hold all UAVs together";
    let asked = [
        ("tolerance", job.plan.tolerance.is_some()),
        ("zones", job.plan.tells_zones),
        ("height_curve", job.curve.is_wanted()),
        ("polygons", job.save.polygons.is_some()),
        ("bare", job.save.bare),
        ("gdal_values", job.save.mask_values == crate::export::MaskValues::Gdal),
    ];
    if let Some((option, _)) = asked.iter().find(|(_, is_asked)| *is_asked) {
        return Err(Error::idle(option, why));
    }
    if matches!(job.plan.sight.method(), MethodChoice::Step(_) | MethodChoice::Xdraw | MethodChoice::R2) {
        return Err(Error::idle(
            "method",
            "with tiles, if it is approximate: it errs otherwise on a part than on the whole",
        ));
    }
    match job.plan.sight.receivers().zone() {
        Some(_) => Err(Error::idle("receivers", "of one zone with tiles: zones are found in the whole")),
        None => Ok(()),
    }
}

/// Refuses two UAVs of one name, as files have it.
fn check_names(sites: &[GivenSite]) -> Result<()> {
    let mut names = std::collections::HashMap::new();
    for site in sites {
        let name = site_in_names(&site.id);
        let file = format!("the files of `{name}`");
        if let Some(other) = names.insert(name, &site.id) {
            return Err(PlacesError::SharedFile { a: (*other).clone(), b: site.id.clone(), file }.into());
        }
    }
    Ok(())
}

/// Waits until the files of a unit that another process makes are complete, but not for ever.
fn is_made_by_another(job: &MapJob, hash: &str) -> Result<bool> {
    const PATIENCE: Duration = Duration::from_secs(10);
    let start = Instant::now();
    loop {
        // Between two of its names the file that is there may lack what says what it is.
        match found(job, hash) {
            Ok(Found::All) => return Ok(true),
            last if start.elapsed() > PATIENCE => return last.map(|_| false),
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
