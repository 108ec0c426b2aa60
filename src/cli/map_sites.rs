//! `skyshed map` with `{site}` in the names of its files: a run of its own for each UAV, which can be asked for again.
//!
//! Each UAV is a unit of work: its files hold what the run was made of (`unit`, a hash of the inputs, the options and the
//! UAV), they appear when all of them are complete, and `--resume` leaves those alone that are there. So an interrupted
//! run goes on where it stopped, and another program may hand out UAVs one by one, and hand them out again.

use std::ffi::OsStr;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::time::Instant;

use super::args::MapArgs;
use super::map::{Given, GivenScene, run_one, uavs_asked};
use super::map_streamed::{check_streamed, on_disk, reason_for_strips};
use super::memory::{FIELD_BYTES_PER_CELL, check_memory};
use super::messages::WarningsOfRuns;
use super::os_words::split;
use super::plan::{Ready, built, checked_radius, input_paths, is_raster_scene, raster_options, ready, warn_of_raster};
use super::tables::UavsFound;
use super::{interrupt, messages};
use crate::digest::Sha256;
use crate::error::{Error, ErrorClass, Result, Warning};
use crate::export::{Format, check_folder, sidecars, site_in_names, with_suffix};
use crate::formats::{RasterFile, cannot_read, origin_of};
use crate::quantity::counted;
use crate::raster::GeoRef;
use crate::read::source_of;
use crate::read::{StreamedSurface, SurfaceOptions, read_surface, surface_grid};
use crate::report::digest_words;
use crate::scene::{GivenSite, Site};

/// What stands for the name of a UAV in the name of a file.
const SITE: &str = "{site}";

/// A run for each UAV.
pub(super) struct SiteRuns<'a> {
    args: &'a MapArgs,
    /// Range \[m\].
    radius_m: Option<f64>,
}

/// Where the scenes of the runs come from.
enum SiteScenes {
    /// One for all, in memory.
    Whole(Box<Ready>),
    /// One for all, in tiles on disk, with what was said of it.
    OnDisk(StreamedSurface, Vec<Warning>),
    /// The part of a raster file in range of each.
    Parts,
    /// The same of a copy on disk, as the file cannot be read in parts.
    PartsOnDisk(StreamedSurface, Vec<Warning>),
}

/// What became of the files of a UAV.
#[derive(PartialEq, Eq)]
enum Found {
    Nothing,
    /// Some are there, all of them of this unit.
    Some,
    All,
}

impl<'a> SiteRuns<'a> {
    /// The runs that `{site}` or `--resume` asks for; `None` if neither was typed.
    ///
    /// # Errors
    /// E105 if some names hold `{site}` and others do not.
    pub(super) fn of(args: &'a MapArgs) -> Result<Option<SiteRuns<'a>>> {
        let files: Vec<&PathBuf> = args.output.iter().chain(&args.height_curve).collect();
        let names = |path: &Path| path.to_string_lossy().contains(SITE);
        let n_named = files.iter().filter(|path| names(path)).count();
        if n_named == 0 && !args.resume {
            return Ok(None);
        }
        if files.is_empty() {
            return Err(Error::usage(116, "`--resume` has no meaning without files to leave alone")
                .with_hint("`-o FILE` names one"));
        }
        // Those in folders named after UAVs are checked with each of them.
        let folders_are_shared = |path: &&&PathBuf| !path.parent().is_some_and(names);
        files.iter().filter(folders_are_shared).try_for_each(|path| check_folder(path))?;
        if let Some(other) = files.iter().find(|path| n_named > 0 && !names(path)) {
            let text = format!("cannot write {}: other files of this run are named after each UAV", other.display());
            return Err(Error::usage(105, text).with_hint(format!("write `{SITE}` into every name, or into none")));
        }
        if args.out.json && n_named > 0 {
            return Err(Error::usage(
                116,
                format!("`--json` has no meaning beside files with `{SITE}` in their names"),
            )
            .with_hint(format!("`-o NAME-{SITE}.json` writes a document for each UAV")));
        }
        let radius_m = checked_radius(args.engine.radius)?;
        Ok(Some(SiteRuns { args, radius_m }))
    }

    /// Runs all that is not done.
    ///
    /// # Errors
    /// Of the first UAV that failed, once all others are done; at once if the user interrupts.
    pub(super) fn run(&self, command: Vec<String>) -> Result<()> {
        let asked = uavs_asked(self.args)?;
        if !self.is_by_site() {
            return self.run_together(command);
        }
        let (scenes, grid) = self.scenes_or_grid()?;
        let uavs = asked.read(&grid)?;
        let mut said = WarningsOfRuns::default();
        let done = self.run_each(command, (scenes, &grid), &uavs, &mut said);
        if !self.args.out.quiet {
            messages::warnings(&uavs.warnings);
            said.say();
        }
        done
    }

    /// Runs each UAV that is not done.
    fn run_each(
        &self,
        command: Vec<String>,
        (mut scenes, grid): (Option<SiteScenes>, &GeoRef),
        uavs: &UavsFound,
        said: &mut WarningsOfRuns,
    ) -> Result<()> {
        let sites = &uavs.sites;
        let plans = self.plans(sites)?;
        let inputs = self.inputs(false)?;
        let (mut n_done, mut n_skipped) = (0, 0);
        let mut failed: Option<Error> = None;
        for (site, args) in sites.iter().zip(plans) {
            let unit = self.unit(Some(site), &inputs);
            let own = UavsFound { sites: vec![site.clone()], sources: uavs.sources.clone(), warnings: Vec::new() };
            match self.run_site((args, &command), (&mut scenes, grid), (own, &unit), said) {
                Ok(true) => {
                    n_done += 1;
                    interrupt::end_writing()?;
                }
                Ok(false) => n_skipped += 1,
                Err(error) if error.class() == ErrorClass::Interrupted => {
                    failed.iter().for_each(messages::error);
                    return Err(error);
                }
                Err(error) => {
                    // The first one is told at the end.
                    if failed.is_some() {
                        messages::error(&error);
                    }
                    let first = failed.get_or_insert(error);
                    if let Err(interrupted) = interrupt::give_up_writing() {
                        messages::error(first);
                        return Err(interrupted);
                    }
                }
            }
        }
        if !self.args.out.quiet {
            let skipped = if n_skipped > 0 { format!(", {n_skipped} there already") } else { String::new() };
            let n_failed = sites.len() - n_done - n_skipped;
            let others = if n_failed > 0 { format!(", {n_failed} not") } else { String::new() };
            messages::note(&format!("{} mapped{skipped}{others}", counted(n_done as u64, "UAV", "UAVs")));
        }
        failed.map_or(Ok(()), Err)
    }

    fn is_by_site(&self) -> bool {
        self.args.output.iter().chain(&self.args.height_curve).any(|path| path.to_string_lossy().contains(SITE))
    }

    /// One run of all UAVs, unless its files are there.
    fn run_together(&self, command: Vec<String>) -> Result<()> {
        let unit = self.unit(None, &self.inputs(true)?);
        let mut args = self.args.clone();
        match found(&args, &unit)? {
            Found::All => {
                if !self.args.out.quiet {
                    messages::note("nothing to do: the files are there, made by the same run");
                }
                return Ok(());
            }
            Found::Some => args.out.overwrite = true,
            Found::Nothing => {}
        }
        run_one(&args, command, Given { unit: Some(unit), ..Given::default() })
    }

    /// The grid of the scenes; with them where they must be read to know it.
    fn scenes_or_grid(&self) -> Result<(Option<SiteScenes>, GeoRef)> {
        let scene = &self.args.scene;
        if is_raster_scene(scene) && scene.project.is_none() {
            return Ok((None, surface_grid(Path::new(&scene.scene), &raster_options(scene)?)?));
        }
        let scene = ready(scene)?;
        let grid = scene.field.grid().clone();
        Ok((Some(SiteScenes::Whole(Box::new(scene))), grid))
    }

    /// The scenes, read as far as they serve every UAV.
    ///
    /// With a radius of a raster they are its parts whatever its size: what a file holds must not depend on memory.
    fn scenes(&self) -> Result<SiteScenes> {
        let args = self.args;
        let mut warnings = Vec::new();
        if self.radius_m.is_some() && is_raster_scene(&args.scene) && args.scene.project.is_none() {
            if args.strips {
                let text =
                    "`--strips` has no meaning with `--radius` and a file for each UAV: only what is in range is read";
                return Err(Error::usage(116, text));
            }
            let files = std::iter::once(Path::new(&args.scene.scene)).chain(args.scene.terrain.as_deref());
            for file in files {
                if !RasterFile::open(file, &mut Vec::new())?.reads_parts() {
                    let scene = on_disk(args, &mut warnings)?;
                    return Ok(SiteScenes::PartsOnDisk(scene, warnings));
                }
            }
            return Ok(SiteScenes::Parts);
        }
        if reason_for_strips(args).is_some() {
            check_streamed(args)?;
            let scene = on_disk(args, &mut warnings)?;
            return Ok(SiteScenes::OnDisk(scene, warnings));
        }
        Ok(SiteScenes::Whole(Box::new(ready(&args.scene)?)))
    }

    /// What each UAV's run was asked, with files of its own.
    fn plans(&self, sites: &[GivenSite]) -> Result<Vec<MapArgs>> {
        let mut names = std::collections::HashMap::new();
        let mut plans = Vec::with_capacity(sites.len());
        for site in sites {
            let name = site_in_names(&site.id);
            if let Some(other) = names.insert(name.clone(), &site.id) {
                let text = format!("sites `{other}` and `{}` would share the files of `{name}`", site.id);
                return Err(Error::site(207, text));
            }
            let own = |paths: &[PathBuf]| -> Vec<PathBuf> {
                paths.iter().map(|path| split(path.as_os_str(), SITE).join(OsStr::new(&name)).into()).collect()
            };
            plans.push(MapArgs {
                output: own(&self.args.output),
                height_curve: own(&self.args.height_curve),
                ..self.args.clone()
            });
        }
        Ok(plans)
    }

    /// Maps one UAV; says whether there was anything to do.
    fn run_site(
        &self,
        (mut args, command): (MapArgs, &[String]),
        (scenes, grid): (&mut Option<SiteScenes>, &GeoRef),
        (own, unit): (UavsFound, &str),
        said: &mut WarningsOfRuns,
    ) -> Result<bool> {
        let site = &own.sites[0];
        if args.resume {
            match found(&args, unit)? {
                Found::All => return Ok(false),
                // A run that was killed between two files leaves the first.
                Found::Some => args.out.overwrite = true,
                Found::Nothing => {}
            }
        }
        // Nothing is read before there is something to do.
        let scenes = match scenes {
            Some(scenes) => scenes,
            None => scenes.insert(self.scenes()?),
        };
        let scene = match scenes {
            SiteScenes::Whole(scene) => GivenScene::InMemory(scene.clone()),
            SiteScenes::OnDisk(scene, warnings) => GivenScene::OnDisk(scene, warnings.clone()),
            SiteScenes::Parts => GivenScene::InMemory(Box::new(self.part((site, grid), None)?)),
            SiteScenes::PartsOnDisk(scene, warnings) => {
                GivenScene::InMemory(Box::new(self.part((site, grid), Some((scene, warnings)))?))
            }
        };
        let unit_words = Some(unit.to_string());
        let given = Given { uavs: Some(own), scene, grid: Some(grid), unit: unit_words, batch: Some(said) };
        match run_one(&args, command.to_vec(), given) {
            // Another process was faster.
            Err(error) if args.resume && error.code() == "E106" && found(&args, unit)? == Found::All => Ok(false),
            done => done.map(|()| true),
        }
    }

    /// The part of a raster in range of a UAV.
    fn part(&self, (site, grid): (&Site, &GeoRef), stored: Option<(&StreamedSurface, &[Warning])>) -> Result<Ready> {
        let start = Instant::now();
        let args = self.args;
        let radius = self.radius_m.unwrap_or(f64::INFINITY) / grid.meters_per_unit();
        let around = [site.x - radius, site.y - radius, site.x + radius, site.y + radius];
        let window = grid.window_within(around);
        check_memory(&args.scene.scene, &grid.part(window), FIELD_BYTES_PER_CELL)?;
        let mut warnings = Vec::new();
        let scene = match stored {
            None => {
                let options = SurfaceOptions { around: Some(around), ..raster_options(&args.scene)? };
                let scene = read_surface(Path::new(&args.scene.scene), &options, &mut warnings)?;
                warn_of_raster(&args.scene, &mut warnings)?;
                scene
            }
            Some((stored, said)) => {
                warnings.extend_from_slice(said);
                stored.part(window)?
            }
        };
        built(&args.scene, (scene, warnings), start)
    }

    /// What the run of a UAV, or of all, is one of: a hash of everything that its files depend on.
    fn unit(&self, site: Option<&GivenSite>, inputs: &str) -> String {
        let mut args = self.args.clone();
        // What changes no number.
        (args.output, args.height_curve) = (Vec::new(), Vec::new());
        (args.resume, args.strips, args.scratch, args.engine.max_memory) = (false, false, None, None);
        (args.out.json, args.out.overwrite, args.out.quiet, args.out.threads) = (false, false, false, None);
        (args.scene.typed, args.scene.paths) = (Vec::new(), Vec::new());
        (args.scene.repairs, args.scene.found_repairs) = (None, std::sync::Arc::default());
        if site.is_some() {
            (args.uav, args.uavs, args.skip_bad) = (Vec::new(), None, false);
        }
        let mut hasher = Sha256::default();
        hasher.update(format!("{} {args:?} {site:?} {inputs}", env!("CARGO_PKG_VERSION")));
        digest_words(hasher)
    }

    /// The files that all runs read, told by path, length and time of change; with that of the UAVs where these are not told
    /// one by one.
    fn inputs(&self, with_sites: bool) -> Result<String> {
        let args = self.args;
        let mut files: Vec<PathBuf> = input_paths(&args.scene);
        let table = args.uavs.clone().filter(|_| with_sites);
        // What comes from standard input is told by its digest.
        let mut text = match &table {
            Some(table) if !table.exists() => format!("{:?};", source_of(table, false)?),
            _ => String::new(),
        };
        files.extend(table);
        for file in files.iter().filter(|file| file.exists()).flat_map(|file| parts_of(file)) {
            let metadata = std::fs::metadata(&file).map_err(|e| cannot_read(&file, &e))?;
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
fn found(args: &MapArgs, unit: &str) -> Result<Found> {
    let files: Vec<&PathBuf> = args.output.iter().chain(&args.height_curve).collect();
    let there: Vec<&PathBuf> = files.iter().copied().filter(|file| file.exists()).collect();
    let other = there.iter().find(|file| !is_of(file, unit));
    let is_left_alone = |file: &PathBuf| {
        let beside = Format::of(file).map_or_else(|_| Vec::new(), |format| sidecars(file, format, args.bare));
        !file.exists() && beside.iter().any(|sidecar| sidecar.exists())
    };
    match other {
        Some(_) if args.out.overwrite => Ok(Found::Nothing),
        Some(other) => {
            let text = format!("cannot write {}: it exists, made by another run", other.display());
            Err(Error::usage(106, text).with_hint("`--overwrite` replaces it"))
        }
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
