//! `skyshed map` with `{site}` in the names of its files: a run of its own for each UAV, which can be asked for again.
//!
//! Each UAV is a unit of work: its files hold what the run was made of (`unit`, a hash of the inputs, the options and the
//! UAV), they appear when all of them are complete, and `--resume` leaves those alone that are there. So an interrupted
//! run goes on where it stopped, and another program may hand out UAVs one by one, and hand them out again.

use std::io::Read;
use std::path::{Path, PathBuf};
use std::time::Instant;

use sha2::{Digest, Sha256};

use super::args::MapArgs;
use super::map::{Given, GivenScene, run_one, sites, typed_sites};
use super::map_streamed::{on_disk, too_large};
use super::plan::{
    Ready, built, checked_radius, is_raster_scene, meters_per_unit, raster_options, ready, warn_of_raster,
};
use super::{interrupt, messages};
use crate::error::{Error, ErrorClass, Result, Warning};
use crate::export::{site_in_names, with_suffix};
use crate::quantity::counted;
use crate::raster::{GeoRef, RasterFile, origin_of};
use crate::scene::{Site, StreamedSurface, SurfaceOptions, WindowedSolids, read_surface, surface_grid};

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
        let typed = typed_sites(self.args)?;
        if !self.is_by_site() {
            return self.run_together(command);
        }
        let (scenes, grid) = self.scenes()?;
        let sites = sites(typed, self.args.uavs.as_deref(), &grid)?;
        let plans = self.plans(&sites)?;
        let (mut n_done, mut n_skipped) = (0, 0);
        let mut failed: Option<Error> = None;
        for (site, args) in sites.iter().zip(&plans) {
            if interrupt::wants_to_stop() {
                break;
            }
            let unit = self.unit(Some(site))?;
            match self.run_site((args, &command), (&scenes, &grid), (site, &unit)) {
                Ok(true) => n_done += 1,
                Ok(false) => n_skipped += 1,
                Err(error) if error.class() == ErrorClass::Interrupted => return Err(error),
                Err(error) => {
                    if failed.is_some() || sites.len() > 1 {
                        messages::error(&error);
                    }
                    failed.get_or_insert(error);
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
        let unit = self.unit(None)?;
        let files: Vec<PathBuf> = self.args.output.iter().chain(&self.args.height_curve).cloned().collect();
        let mut args = self.args.clone();
        match self.found(&files, &unit)? {
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

    /// The scenes, read as far as they serve every UAV, and their grid.
    fn scenes(&self) -> Result<(SiteScenes, GeoRef)> {
        let args = self.args;
        let mut warnings = Vec::new();
        if self.radius_m.is_some() && is_raster_scene(&args.scene) && args.scene.project.is_none() {
            let options = raster_options(&args.scene)?;
            let path = Path::new(&args.scene.scene);
            let file = RasterFile::open(path, &mut Vec::new())?;
            if file.reads_parts() {
                return Ok((SiteScenes::Parts, surface_grid(path, &options)?));
            }
            if too_large(args).is_some() {
                let scene = on_disk(args, &mut warnings)?;
                let grid = surface_grid(path, &options)?;
                return Ok((SiteScenes::PartsOnDisk(scene, warnings), grid));
            }
        }
        if too_large(args).is_some() {
            let scene = on_disk(args, &mut warnings)?;
            let grid = scene.grid().clone();
            return Ok((SiteScenes::OnDisk(scene, warnings), grid));
        }
        let scene = ready(&args.scene, args.engine.max_memory)?;
        let grid = scene.field.grid().clone();
        Ok((SiteScenes::Whole(Box::new(scene)), grid))
    }

    /// What each UAV's run was asked, with files of its own.
    fn plans(&self, sites: &[Site]) -> Result<Vec<MapArgs>> {
        let mut names = std::collections::HashMap::new();
        let mut plans = Vec::with_capacity(sites.len());
        for site in sites {
            let name = site_in_names(&site.id);
            if let Some(other) = names.insert(name.clone(), &site.id) {
                let text = format!("sites `{other}` and `{}` would share the files of `{name}`", site.id);
                return Err(Error::site(207, text));
            }
            let own = |paths: &[PathBuf]| -> Vec<PathBuf> {
                paths.iter().map(|path| PathBuf::from(path.to_string_lossy().replace(SITE, &name))).collect()
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
        (args, command): (&MapArgs, &[String]),
        (scenes, grid): (&SiteScenes, &GeoRef),
        (site, unit): (&Site, &str),
    ) -> Result<bool> {
        let mut args = args.clone();
        if args.resume {
            let files: Vec<PathBuf> = args.output.iter().chain(&args.height_curve).cloned().collect();
            match self.found(&files, unit)? {
                Found::All => return Ok(false),
                // A run that was killed between two files leaves the first.
                Found::Some => args.out.overwrite = true,
                Found::Nothing => {}
            }
        }
        let scene = match scenes {
            SiteScenes::Whole(scene) => GivenScene::InMemory(scene.clone()),
            SiteScenes::OnDisk(scene, warnings) => GivenScene::OnDisk(scene, warnings.clone()),
            SiteScenes::Parts => GivenScene::InMemory(Box::new(self.part((site, grid), None)?)),
            SiteScenes::PartsOnDisk(scene, warnings) => {
                GivenScene::InMemory(Box::new(self.part((site, grid), Some((scene, warnings)))?))
            }
        };
        let given = Given { sites: Some(vec![site.clone()]), scene, unit: Some(unit.to_string()) };
        run_one(&args, command.to_vec(), given)?;
        Ok(true)
    }

    /// The part of a raster in range of a UAV.
    fn part(&self, (site, grid): (&Site, &GeoRef), stored: Option<(&StreamedSurface, &[Warning])>) -> Result<Ready> {
        let start = Instant::now();
        let args = self.args;
        let radius = self.radius_m.unwrap_or(f64::INFINITY) / meters_per_unit(grid);
        let around = [site.x - radius, site.y - radius, site.x + radius, site.y + radius];
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
                stored.part(grid.window_within(around))?
            }
        };
        built(&args.scene, (scene, warnings), (start, args.engine.max_memory))
    }

    /// What the run of a UAV, or of all, is one of: a hash of everything that its files depend on.
    ///
    /// Inputs are told apart by path, length and time of change.
    fn unit(&self, site: Option<&Site>) -> Result<String> {
        let mut args = self.args.clone();
        // What changes no number.
        (args.output, args.height_curve) = (Vec::new(), Vec::new());
        (args.resume, args.scratch, args.engine.max_memory) = (false, None, None);
        (args.out.json, args.out.overwrite, args.out.quiet, args.out.threads) = (false, false, false, None);
        args.scene.typed.clear();
        let mut files: Vec<PathBuf> =
            std::iter::once(PathBuf::from(&args.scene.scene)).chain(args.scene.terrain.clone()).collect();
        match site {
            Some(_) => (args.uav, args.uavs) = (Vec::new(), None),
            None => files.extend(args.uavs.clone()),
        }
        let mut hasher = Sha256::new();
        hasher.update(format!("{} {args:?} {site:?}", env!("CARGO_PKG_VERSION")));
        for file in files.iter().filter(|file| file.exists()) {
            for part in parts_of(file) {
                let metadata = std::fs::metadata(&part)
                    .map_err(|e| Error::file(301, format!("cannot read {}: {e}", part.display())))?;
                hasher.update(format!("{} {} {:?}", part.display(), metadata.len(), metadata.modified().ok()));
            }
        }
        let hex: String = hasher.finalize().iter().map(|b| format!("{b:02x}")).collect();
        Ok(format!("sha256:{hex}"))
    }

    /// Which of some files are there, made by a unit.
    ///
    /// # Errors
    /// E106 if one is there that is not of this unit, unless it may be replaced.
    fn found(&self, files: &[PathBuf], unit: &str) -> Result<Found> {
        let there: Vec<&PathBuf> = files.iter().filter(|file| file.exists()).collect();
        let other = there.iter().find(|file| !is_of(file, unit));
        match other {
            Some(_) if self.args.out.overwrite => Ok(Found::Nothing),
            Some(other) => {
                let text = format!("cannot write {}: it exists, made by another run", other.display());
                Err(Error::usage(106, text).with_hint("`--overwrite` replaces it"))
            }
            None if there.is_empty() => Ok(Found::Nothing),
            None if there.len() == files.len() => Ok(Found::All),
            None => Ok(Found::Some),
        }
    }
}

/// The files that an input consists of.
fn parts_of(input: &Path) -> Vec<PathBuf> {
    let own = std::iter::once(input.to_path_buf());
    let tiles = RasterFile::open(input, &mut Vec::new())
        .map(|file| file.tile_paths().iter().map(|p| p.to_path_buf()).collect());
    own.chain(tiles.unwrap_or_else(|_| Vec::new())).collect()
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
