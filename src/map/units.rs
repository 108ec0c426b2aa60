//! Units of work: what a run with files of its own is one of, and which of its files are there.
//!
//! Schedulers hand units out, and hand them out again. Whatever becomes of a run, a file of a unit is complete or not there, and
//! says which unit made it.

use std::fmt::Debug;
use std::io::Read;
use std::path::{Path, PathBuf};

use super::job::MapJob;
use super::save_options::SaveOptions;
use super::tiles::Tile;
use crate::answer::digest_words;
use crate::city::GivenSite;
use crate::digest::Sha256;
use crate::error::{RequestError, Result};
use crate::export::{Format, Layer, sidecars, with_suffix};
use crate::formats::{RasterFile, origin_of};
use crate::read::source_of;
use crate::scene::SceneOptions;
use skyshed_io::{identity, is_remote};

/// Which files of a unit are there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Found {
    Nothing,
    /// Some are there, all of them of this unit.
    Some,
    All,
}

/// The unit of one UAV: a hash of everything that its files depend on.
pub(super) fn unit_of_site(job: &MapJob, site: &GivenSite, inputs: &str) -> String {
    unit(job, &Some(site), inputs)
}

/// The unit of a tile, of the list of all UAVs.
pub(super) fn unit_of_tile(job: &MapJob, (tile, all): (&Tile, &[GivenSite]), inputs: &str) -> String {
    let own: Vec<&GivenSite> = tile.uavs.iter().map(|k| &all[*k]).collect();
    let numbers = tells_numbers(&job.plan.layers).then_some((&tile.uavs, all.len()));
    unit(job, &(tile.row, tile.col, tile.cells_per_side, own, numbers), inputs)
}

/// Whether a layer tells of UAVs by their places in the list of all.
pub(super) fn tells_numbers(layers: &[Layer]) -> bool {
    layers.iter().any(|layer| matches!(layer, Layer::Which | Layer::BestServer))
}

/// The unit of all UAVs together.
pub(super) fn unit_of_all(job: &MapJob, inputs: &str) -> String {
    unit(job, &&job.uavs, inputs)
}

/// The hash of a job, what is told apart within it, and its inputs.
pub(super) fn unit(job: &MapJob, what: &dyn Debug, inputs: &str) -> String {
    let MapJob { word, scene, plan, save, curve, .. } = job;
    // What changes no number.
    let scene = SceneOptions { repairs: None, ..scene.clone() };
    let save = SaveOptions { overwrite: false, ..save.clone() };
    // One file has many names.
    let named = |path: &Path| std::fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
    let word = named(Path::new(word));
    let scene = SceneOptions { terrain: scene.terrain.as_deref().map(named), ..scene };
    let of_run = (word, scene, plan, save, curve.heights);
    let mut hasher = Sha256::default();
    hasher.update(format!("{} {of_run:?} {what:?} {inputs}", env!("CARGO_PKG_VERSION")));
    digest_words(hasher)
}

/// The files that all runs read, told by path, length and time of change; with that of the UAVs where these are not told
/// one by one.
pub(super) fn inputs(job: &MapJob, with_sites: bool) -> Result<String> {
    let mut files = job.inputs.clone();
    let table = job.uavs.table.clone().filter(|_| with_sites);
    // What comes from standard input is told by its digest.
    let mut text = match &table {
        Some(table) if !table.exists() => format!("{:?};", source_of(table, false)?),
        _ => String::new(),
    };
    files.extend(table);
    for file in files.iter().filter(|file| is_remote(file)) {
        text += &format!("{} {};", file.display(), identity(file)?);
    }
    for file in files.iter().filter(|file| file.exists()).flat_map(|file| parts_of(file)) {
        let metadata = std::fs::metadata(&file).map_err(|e| skyshed_io::cannot_read(&file.as_path().into(), &e))?;
        let name = std::fs::canonicalize(&file).unwrap_or(file);
        text += &format!("{} {} {:?};", name.display(), metadata.len(), metadata.modified().ok());
    }
    Ok(text)
}

/// Which of the files of a run are there, made by a unit.
///
/// A file appears after what stands beside it, so that one that is there is complete; what stands there alone was left by a
/// run that was killed.
///
/// # Errors
/// E106 if one is there that is not of this unit, unless it may be replaced.
pub(super) fn found(job: &MapJob, unit: &str) -> Result<Found> {
    let files: Vec<&PathBuf> = job.outputs.iter().chain(&job.curve.outputs).collect();
    // A file that was emptied holds nothing of anybody.
    let is_there =
        |file: &Path| std::fs::metadata(file).is_ok_and(|metadata| metadata.len() > 0 || !metadata.is_file());
    let there: Vec<&PathBuf> = files.iter().copied().filter(|file| is_there(file)).collect();
    let other = there.iter().find(|file| !is_of(file, unit));
    let is_left_alone = |file: &PathBuf| {
        let beside = Format::of(file).map_or_else(|_| Vec::new(), |format| sidecars(file, format, job.save.bare));
        !file.exists() && beside.iter().any(|sidecar| sidecar.exists())
    };
    match other {
        Some(_) if job.save.overwrite => Ok(Found::Nothing),
        Some(other) => Err(RequestError::OfAnotherRun(other.display().to_string()).into()),
        None if there.len() == files.len() => Ok(Found::All),
        None if files.iter().any(|file| file.exists() || is_left_alone(file)) => Ok(Found::Some),
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
