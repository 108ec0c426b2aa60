//! Lets another program ask what the command line asks, over a scene that it holds. Options are the same requests: so they have
//! the same meanings and defaults, and are refused for the same reasons.

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use clap::error::ErrorKind;
use clap::{Args, Command, FromArgMatches};
use serde_json::Value;
use skyshed_request::{CoverageQuestion, MapOptions, SaveOptions, SceneOptions, Source};

use crate::answer::Output;
use crate::export::Format;
use crate::picture::Look;

use super::failure::{Failure, Result, refusal, refusal_with};
use super::program::Cli;
use super::run::{Run, check_text, check_use};
use super::{hints, refusal};
use crate::answer::{Answer, Rows, Spent};
use crate::coverage::Tally;
use crate::error::{Error, ErrorClass, Warning};
use crate::map::{Coverages, Held, MapPlan, PartOf, Prepared};
use crate::memory;
use crate::progress::Progress;
use crate::raster::GeoRef;
use crate::read::surface_grid;
use crate::scene::{Scene, SceneReader, is_raster_scene};
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

/// Reads a part of a request from words such as `--radius`, `500`. Words of other parts are refused.
fn part_of<T: Args + FromArgMatches>(words: &[OsString]) -> Result<T> {
    let mut command = T::augment_args(Command::new("options").no_binary_name(true)).disable_help_flag(true);
    parsed(command.try_get_matches_from_mut(words).and_then(|matches| T::from_arg_matches(&matches)))
}

/// Returns a reader of scenes with options such as `--height-field`, `levels`.
///
/// # Errors
/// E101 for options that cannot be.
pub fn scene_reader(words: &[OsString]) -> std::result::Result<SceneReader, Refusal> {
    Ok(part_of::<SceneOptions>(words)?.into())
}

/// Returns the grid of a raster that can be read in parts; `None` for other scenes.
///
/// # Errors
/// As [`scene_reader`]; those of the file.
pub fn raster_grid(word: &OsStr, words: &[OsString]) -> std::result::Result<Option<GeoRef>, Refusal> {
    let (reader, word) = (scene_reader(words)?, &*skyshed_io::told(word));
    if !is_raster_scene(word) || reader.options.project.is_some() {
        return Ok(None);
    }
    Ok(Some(surface_grid(Path::new(word), &reader.of_raster()?)?))
}

/// Refuses work of this process that would take it above so many bytes, before it begins; what takes more in the end is not ended.
pub fn limit_memory(bytes: u64) {
    memory::refuse_above(bytes);
}

/// Returns the options of files of a map, such as `--bare`; `files` are those that will be written.
///
/// # Errors
/// E101 for options that cannot be; E116 for those that change nothing.
pub fn save_options(words: &[OsString], files: &[PathBuf]) -> std::result::Result<SaveOptions, Refusal> {
    let options: SaveOptions = part_of(words)?;
    let outputs = files.iter().filter_map(|path| Some((path.clone(), Format::of(path).ok()?)));
    let is_bare = |format: Format| options.forms.bare && format == Format::Png;
    let outputs: Vec<Output> = outputs.filter(|(_, format)| !is_bare(*format)).collect();
    Look::checked(&options.picture, &options.writing, &outputs)?;
    Ok(options)
}

/// Returns maps of what some UAVs see of a scene, with options such as `--radius`, `500`; each mask is kept if that is asked for.
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
    Ok(prepared(scene, uavs, part_of(words)?)?.run(held, progress, |_| {}, |_| {})?)
}

/// Returns P_LoS of each UAV; `None` without a receiver in range, and over no data. No mask is made.
///
/// # Errors
/// As [`coverages`].
pub fn p_los(
    (scene, uavs): (Scene, &[Uav]),
    words: &[OsString],
    progress: &Progress,
) -> std::result::Result<Vec<Option<f64>>, Refusal> {
    let CoverageQuestion { sight, heights, map } = part_of(words)?;
    let of_maps = [
        ("height_error", heights.height_error.is_some()),
        ("height_bias", heights.height_bias.is_some()),
        ("sigma", map.sigma.is_some()),
        ("layers", !map.layers.is_empty()),
        ("zones", map.zones),
    ];
    if let Some((option, _)) = of_maps.into_iter().find(|(_, is_set)| *is_set) {
        return Err(Error::idle(option, "where P_LoS alone is counted").into());
    }
    let tolerance = map.tolerance;
    let map = MapOptions { tolerance, ..MapOptions::default() };
    let question = CoverageQuestion { sight, map, ..CoverageQuestion::default() };
    let counts = prepared(scene, uavs, question)?.count(progress)?;
    Ok(counts.iter().map(Tally::p_los).collect())
}

fn prepared(scene: Scene, uavs: &[Uav], question: CoverageQuestion) -> Result<Prepared> {
    Ok(MapPlan::of(&question)?.prepare(scene, &UavsFound::of(uavs)?, PartOf::default())?)
}

/// What was parsed; help and versions are for people, and refused.
fn parsed<T>(read: std::result::Result<T, clap::Error>) -> Result<T> {
    read.map_err(|error| match error.kind() {
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion => refusal(101, "help is no option here"),
        _ => refusal::answer(&error).err().unwrap_or_else(|| refusal::in_words(&error.to_string())),
    })
}

/// Asks a command, such as `place SCENE --step 50`; `scene` is asked instead of the one that the words name, and `held` are inputs in
/// memory by the names of their options.
///
/// # Errors
/// What the command line would say.
pub fn ask(
    words: Vec<OsString>,
    (scene, held): (Option<Scene>, Vec<(String, Source)>),
    progress: &Arc<Progress>,
) -> std::result::Result<Found, Refusal> {
    let words: Vec<OsString> = std::iter::once("skyshed".into()).chain(words).collect();
    let mut cli = parsed(Cli::from_words(&words))?;
    held.into_iter().for_each(|(option, source)| cli.hold(&option, source));
    let command = words.iter().skip(1).map(|word| skyshed_io::told(word).to_string_lossy().into_owned()).collect();
    let run = Run { given: scene, ..Run::asked(command, Instant::now(), progress) };
    if let Some(shared) = cli.shared() {
        check_use(&shared, cli.draws() || run.given.is_some())?;
        check_text(shared.out, None)?;
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
