//! Lets another program ask what the command line asks, over a scene that it holds. Options are words of the command line: so
//! they mean the same, have the same defaults, and are refused for the same reasons.

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use clap::error::ErrorKind;
use clap::{Args, Command, FromArgMatches};
use serde_json::Value;

use super::args::scene::ReadingArgs;
use super::commands::MapArgs;
use super::failure::{Failure, Result, refusal, refusal_with};
use super::program::Cli;
use super::run::{Run, check_text, check_use};
use super::typed::Typed;
use super::{hints, refusal};
use crate::answer::{Answer, Rows, Spent};
use crate::coverage::Tally;
use crate::error::{Error, ErrorClass, Warning};
use crate::map::{Coverages, Held, MapPlan, PartOf, Prepared, SaveOptions};
use crate::memory;
use crate::progress::Progress;
use crate::raster::GeoRef;
use crate::read::surface_grid;
use crate::scene::{Scene, SceneOptions, is_raster_scene};
use crate::uav::{Uav, UavsFound};

/// Why a question has no answer.
#[derive(Debug, Clone)]
pub struct Refusal {
    /// The cause.
    pub class: ErrorClass,
    /// The stable code, for example `E301`.
    pub code: String,
    /// What is wrong, on one line.
    pub text: String,
    /// What to do about it, where that is known.
    pub hint: Option<String>,
}

/// A remedy without the command that lists flags, which no caller types.
fn without_help(remedy: &str) -> Option<String> {
    let parts: Vec<&str> = remedy.split("; ").filter(|part| !part.contains(" --help`")).collect();
    (!parts.is_empty()).then(|| parts.join("; "))
}

impl From<Failure> for Refusal {
    fn from(failure: Failure) -> Refusal {
        let (class, code) = (failure.class(), failure.code());
        let hint = match &failure {
            Failure::Library(error) => hints::hint_for_caller(error),
            Failure::Words { remedy, .. } => remedy.as_deref().and_then(without_help),
        };
        Refusal { class, code, text: failure.to_string(), hint }
    }
}

impl From<Error> for Refusal {
    fn from(error: Error) -> Refusal {
        Failure::Library(error).into()
    }
}

impl From<skyshed_io::Error> for Refusal {
    fn from(error: skyshed_io::Error) -> Refusal {
        Failure::from(error).into()
    }
}

impl Refusal {
    /// E102: a height of a UAV that is none, and what is wrong with it.
    pub fn of_uav(what: &str) -> Refusal {
        refusal_with(102, format!("uav: {what}"), "heights are 120, \"120agl\", \"30roof\", \"150amsl\", \"400ft\"")
            .into()
    }

    /// With the name of the argument that it is about.
    #[must_use]
    pub fn about(self, argument: &str) -> Refusal {
        Refusal { text: format!("{argument}: {}", self.text), ..self }
    }

    /// E113: an array whose cells are no grid.
    pub fn of_grid(what: impl Into<String>) -> Refusal {
        refusal_with(113, what, "a transform is (width, 0, west, 0, -height, north), as of rasterio").into()
    }
}

/// What was found, in the forms that need no file, and the files that were written.
#[derive(Debug, Clone)]
pub struct Found {
    /// The document, as of `--json`.
    pub document: Value,
    /// The table, its header first; empty where there is none.
    pub table: Rows,
    /// What was odd.
    pub warnings: Vec<Warning>,
    /// Files that were written.
    pub files: Vec<PathBuf>,
}

impl Found {
    /// Of an answer that was written to some files.
    pub(super) fn of(answer: &dyn Answer, spent: Spent, files: Vec<PathBuf>) -> Found {
        Found {
            document: answer.document(Some(spent)),
            table: answer.table(),
            warnings: answer.warnings().to_vec(),
            files,
        }
    }
}

/// What to do about a warning, where that is known.
pub fn hint_of(warning: &Warning) -> Option<String> {
    hints::of_warning(warning)
}

/// How a scene is read, from words such as `--height-field`, `levels`.
///
/// # Errors
/// E101 for words that make no sense, and what the command line says of others.
pub fn scene_options(words: &[OsString]) -> std::result::Result<SceneOptions, Refusal> {
    let mut command = ReadingArgs::augment_args(Command::new("scene").no_binary_name(true)).disable_help_flag(true);
    let read = command.try_get_matches_from_mut(words).and_then(|matches| ReadingArgs::from_arg_matches(&matches));
    Ok(parsed(read)?.options()?)
}

/// The grid of a scene of which a run reads no more than it needs: of a raster in its own system. `None` of any other.
///
/// # Errors
/// As [`scene_options`]; those of the file.
pub fn raster_grid(word: &OsStr, words: &[OsString]) -> std::result::Result<Option<GeoRef>, Refusal> {
    let (options, word) = (scene_options(words)?, &*skyshed_io::told(word));
    if !is_raster_scene(word) || options.project.is_some() {
        return Ok(None);
    }
    Ok(Some(surface_grid(Path::new(word), &options.of_raster()?)?))
}

/// Refuses work of this process that would take it above so many bytes, before it begins; what takes more in the end is not ended.
pub fn limit_memory(bytes: u64) {
    memory::refuse_above(bytes);
}

/// In which form a map is written, from words such as `--bare`; `files` are those that will be written.
///
/// # Errors
/// As [`scene_options`].
pub fn save_options(words: &[OsString], files: &[PathBuf]) -> std::result::Result<SaveOptions, Refusal> {
    let files = files.iter().flat_map(|file| [OsString::from("-o"), file.clone().into_os_string()]);
    Ok(map_args(files.chain(words.iter().cloned()), &OF_FILES)?.save_options()?)
}

/// What is said of a map.
const OF_MAP: [&str; 17] = [
    "scene",
    "earth_k",
    "curvature_coefficient",
    "height_error",
    "height_bias",
    "sigma",
    "rx_height",
    "receivers",
    "radius",
    "min_radius",
    "sector",
    "elevation",
    "beam",
    "method",
    "layers",
    "tolerance",
    "zones",
];
/// What is said of its files.
const OF_FILES: [&str; 13] = [
    "scene",
    "output",
    "overwrite",
    "csv_text",
    "bare",
    "tif_layout",
    "gdal_values",
    "polygons",
    "simplify",
    "title",
    "attribution",
    "width",
    "dpi",
];

/// What words such as `--radius`, `500` say of a map. What is not asked here is refused.
fn map_args(words: impl Iterator<Item = OsString>, asked: &[&str]) -> Result<MapArgs> {
    let mut command = MapArgs::augment_args(Command::new("map").no_binary_name(true)).disable_help_flag(true);
    let matches = parsed(command.try_get_matches_from_mut(std::iter::once("SCENE".into()).chain(words)))?;
    Typed::of(&matches)
        .refuse_others(asked, "here: scenes have theirs where they are made, files where they are saved")?;
    parsed(MapArgs::from_arg_matches(&matches))
}

/// Maps of what some UAVs see of a scene, asked for in words such as `--radius`, `500`; each mask is kept if that is asked for.
///
/// # Errors
/// What the command line would say.
pub fn coverages(
    (scene, uavs): (Scene, &[Uav]),
    words: &[OsString],
    keeps_masks: bool,
    progress: &Progress,
) -> std::result::Result<Coverages, Refusal> {
    let held = Held { keeps_masks, ..Held::default() };
    Ok(prepared(scene, uavs, words)?.run(held, progress, |_| {}, |_| {})?)
}

/// P_LoS of each UAV; `None` without a receiver in range, and over no data. No mask is made.
///
/// # Errors
/// As [`coverages`].
pub fn p_los(
    (scene, uavs): (Scene, &[Uav]),
    words: &[OsString],
    progress: &Progress,
) -> std::result::Result<Vec<Option<f64>>, Refusal> {
    let is = |word: &OsString, flag: &str| word.to_string_lossy().split('=').next() == Some(flag);
    let names = |flag: &str| words.iter().any(|word| is(word, flag));
    if let Some(flag) = ["--height-error", "--height-bias", "--sigma"].into_iter().find(|flag| names(flag)) {
        return Err(refusal(116, format!("`{flag}` has no meaning where P_LoS alone is counted")).into());
    }
    let counts = prepared(scene, uavs, words)?.count(progress)?;
    Ok(counts.iter().map(Tally::p_los).collect())
}

fn prepared(scene: Scene, uavs: &[Uav], words: &[OsString]) -> Result<Prepared> {
    /// PERF: what was asked last, which is mostly asked again; to parse words takes as long as a small map.
    static LAST: Mutex<Option<(Vec<OsString>, MapPlan)>> = Mutex::new(None);
    let mut last = LAST.lock().unwrap_or_else(PoisonError::into_inner);
    let plan = match &*last {
        Some((asked, plan)) if asked == words => plan.clone(),
        _ => {
            let plan = map_args(words.iter().cloned(), &OF_MAP)?.plan()?;
            *last = Some((words.to_vec(), plan.clone()));
            plan
        }
    };
    drop(last);
    Ok(plan.prepare(scene, &UavsFound::of(uavs)?, PartOf::default())?)
}

/// What was parsed; help and versions are for people, and refused.
fn parsed<T>(read: std::result::Result<T, clap::Error>) -> Result<T> {
    read.map_err(|error| match error.kind() {
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion => refusal(101, "help is no option here"),
        _ => refusal::answer(&error).err().unwrap_or_else(|| refusal::in_words(&error.to_string())),
    })
}

/// Asks a command, such as `place SCENE --step 50`; `scene` is asked instead of the one that the words name.
///
/// # Errors
/// What the command line would say.
pub fn ask(
    words: Vec<OsString>,
    scene: Option<Scene>,
    progress: &Arc<Progress>,
) -> std::result::Result<Found, Refusal> {
    let words: Vec<OsString> = std::iter::once("skyshed".into()).chain(words).collect();
    let (cli, typed) = parsed(Cli::from_words(&words))?;
    let command = words.iter().skip(1).map(|word| skyshed_io::told(word).to_string_lossy().into_owned()).collect();
    let run = Run { given: scene, ..Run::asked(command, typed, Instant::now(), progress) };
    if let Some((scenes, _, out)) = cli.shared() {
        check_use(&scenes, out, cli.draws() || run.given.is_some(), &run.typed)?;
        check_text(out, None)?;
    }
    cli.run(&run)?;
    Ok(run.found.into_inner().ok_or(Error::Fault("a command kept no answer"))?)
}

/// P_LoS against the height of each UAV, from, to and in steps of some heights above the ground below it \[m\]; by default some
/// 150 round ones.
///
/// # Errors
/// E113 for heights out of range; `Interrupted`.
pub fn height_curves(
    map: &Coverages,
    heights_m: Option<[f64; 3]>,
    progress: &Progress,
) -> std::result::Result<Found, Refusal> {
    let curves = map.height_curves(heights_m, progress)?;
    Ok(Found::of(&curves, Spent::default(), Vec::new()))
}
