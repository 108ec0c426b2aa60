//! Lets another program ask what the command line asks, over a scene that it holds. Options are the same requests: so they have
//! the same meanings and defaults, and are refused for the same reasons.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use serde_json::Value;
use skyshed_request::{
    CoverageQuestion, LinkRequest, MapOptions, MapRequest, PROGRAM_OPTIONS, Reading, SaveOptions, SceneOptions, Source,
    Uavs, json,
};

use crate::answer::{Answer, CommandFacts, Output};
use crate::export::Format;
use crate::picture::Look;

use super::args::scene::scene_words;
use super::failure::{Failure, Result, refusal_with};
use super::found::Found;
use super::hints;
use super::keywords::{Members, read};
use super::program::Cli;
use super::run::{Run, check_text, check_use};
use crate::answer::Spent;
use crate::coverage::Tally;
use crate::error::{Error, ErrorKind, OddRun, Warning, WarningRepr};
use crate::jobs::Jobs;
use crate::link::{AskedReceiver, LinkArray, LinksPlan};
use crate::map::{Coverages, Held, MapJob, MapPlan, Part, PartOf, Prepared, Purpose, UnitRuns};
use crate::memory;
use crate::progress::Progress;
use crate::quantity::Height;
use crate::raster::GeoRef;
use crate::read::surface_grid;
use crate::scene::{Scene, SceneReader, is_raster_scene};
use crate::uav::{Uav, UavsFound};

/// Reason why a question has no answer.
#[derive(Debug, Clone)]
pub struct Refusal {
    /// The cause.
    pub kind: ErrorKind,
    /// The stable code, for example `E301`.
    pub code: String,
    /// Text of the error, on one line.
    pub text: String,
    /// Remedy, if one is known.
    pub hint: Option<String>,
}

/// A remedy without the command that lists flags, which no caller types.
fn without_help(remedy: &str) -> Option<String> {
    let parts: Vec<&str> = remedy.split("; ").filter(|part| !part.contains(" --help`")).collect();
    (!parts.is_empty()).then(|| parts.join("; "))
}

impl From<Failure> for Refusal {
    fn from(failure: Failure) -> Refusal {
        let (kind, code) = (failure.kind(), failure.code());
        let hint = match &failure {
            Failure::Library(error) => hints::hint_for_caller(error),
            Failure::Words { remedy, .. } => remedy.as_deref().and_then(without_help),
        };
        Refusal { kind, code, text: failure.to_string(), hint }
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

/// Returns the remedy for a warning, if one is known.
pub fn hint_of(warning: &Warning) -> Option<String> {
    hints::of_warning(warning)
}

/// Returns a reader of scenes with options such as `height_field`: `levels`.
///
/// # Errors
/// E101 for options that cannot be.
pub fn scene_reader(options: Members) -> std::result::Result<SceneReader, Refusal> {
    Ok(read::<SceneOptions>(options)?.into())
}

/// Returns the live page of a scene, and the command line that it shows: a name of the scene, and the options that read it.
///
/// # Errors
/// As [`Scene::live_page`]; E101 for options that cannot be.
pub fn live_page(
    scene: &Scene,
    (uavs, track): (&[Uav], Option<Source>),
    (word, options): (&OsStr, Members),
) -> std::result::Result<String, Refusal> {
    let reading = Reading { options: read(options)?, ..Reading::default() };
    Ok(scene.live_page(uavs, track, scene_words(word, &reading))?)
}

/// Returns the grid of a raster that can be read in parts; `None` for other scenes.
///
/// # Errors
/// As [`scene_reader`]; those of the file.
pub fn raster_grid(word: &OsStr, options: Members) -> std::result::Result<Option<GeoRef>, Refusal> {
    let (reader, word) = (scene_reader(options)?, &*skyshed_io::told(word));
    if !is_raster_scene(word) || reader.options.project.is_some() {
        return Ok(None);
    }
    Ok(Some(surface_grid(Path::new(word), &reader.of_raster()?)?))
}

/// Refuses work of this process that would take it above so many bytes, before it begins; what takes more in the end is not ended.
pub fn limit_memory(bytes: u64) {
    memory::refuse_above(bytes);
}

/// Returns the options of files of a map, such as `bare`; `files` are those that will be written.
///
/// # Errors
/// E101 for options that cannot be; E116 for those that change nothing.
pub fn save_options(options: Members, files: &[PathBuf]) -> std::result::Result<SaveOptions, Refusal> {
    let options: SaveOptions = read(options)?;
    let outputs = files.iter().filter_map(|path| Some((path.clone(), Format::of(path).ok()?)));
    let is_bare = |format: Format| options.forms.bare && format == Format::Png;
    let outputs: Vec<Output> = outputs.filter(|(_, format)| !is_bare(*format)).collect();
    Look::checked(&options.picture, &options.writing, &outputs)?;
    Ok(options)
}

/// Returns maps of what some UAVs see of a scene, with options such as `radius`; each mask is kept if that is asked for. The option
/// `bad_uavs` says what becomes of UAVs that cannot be at their place.
///
/// # Errors
/// Errors of the options, the UAVs and the method.
pub fn coverages(
    (scene, uavs): (Scene, &[Uav]),
    mut options: Members,
    keeps_masks: bool,
    progress: &Progress,
) -> std::result::Result<Coverages, Refusal> {
    let bad = options.remove("bad_uavs").into_iter().map(|bad| ("bad_uavs".to_string(), bad)).collect();
    let Uavs { bad_uavs, .. } = read(bad)?;
    let found = UavsFound { bad: bad_uavs.unwrap_or_default(), ..UavsFound::of(uavs)? };
    let held = Held { keeps_masks, ..Held::default() };
    Ok(prepared(scene, &found, &read(options)?)?.run(held, progress, |_| {}, |_| {})?)
}

/// Returns the UAVs of maps that were left out, by their ids, and why.
pub fn left_out(maps: &Coverages) -> Vec<(String, String)> {
    let of = |warning: &Warning| match warning.repr() {
        WarningRepr::Run(OddRun::BadUavs { left_out, .. }) => left_out.clone(),
        _ => Vec::new(),
    };
    maps.warnings().iter().flat_map(of).collect()
}

/// Returns P_LoS of each UAV; `None` without a receiver in range, and over no data. No mask is made.
///
/// # Errors
/// As [`coverages`].
pub fn p_los(
    (scene, uavs): (Scene, &[Uav]),
    options: Members,
    progress: &Progress,
) -> std::result::Result<Vec<Option<f64>>, Refusal> {
    let question: CoverageQuestion = read(options)?;
    let sight = CoverageQuestion { sight: question.sight, ..CoverageQuestion::default() };
    let counted =
        CoverageQuestion { map: MapOptions { tolerance: question.map.tolerance, ..sight.map.clone() }, ..sight };
    let names: Members = json::set_members(&counted);
    let names: Vec<&str> = names.keys().map(String::as_str).collect();
    json::refuse_others(&json::set_members(&question), &names, "where P_LoS alone is counted").map_err(Error::from)?;
    let counts = prepared(scene, &UavsFound::of(uavs)?, &counted)?.count(progress)?;
    Ok(counts.iter().map(Tally::p_los).collect())
}

fn prepared(scene: Scene, found: &UavsFound, question: &CoverageQuestion) -> Result<Prepared> {
    Ok(MapPlan::of(question)?.prepare(scene, found, PartOf::default())?)
}

/// Returns the options of a request that are set, in the one form that documents record.
///
/// # Errors
/// E101 for options that cannot be.
pub fn normalized(command: &str, options: Members) -> std::result::Result<Members, Refusal> {
    Ok(Cli::of_request(command, options)?.shared().map(|shared| shared.members()).unwrap_or_default())
}

/// Answers a command with options by their names, such as `place` with `step`: 50. `scene` is used instead of the one that they name,
/// and `held` are inputs in memory by the names of their options.
///
/// # Errors
/// Errors of the options and of the answer.
pub fn ask(
    (command, options): (&str, Members),
    (scene, held): (Option<Scene>, Vec<(String, Source)>),
    progress: &Arc<Progress>,
) -> std::result::Result<Found, Refusal> {
    let mut cli = Cli::of_request(command, options)?;
    let line = json::command_line(command, cli.shared().map(|shared| shared.members()).unwrap_or_default());
    held.into_iter().for_each(|(option, source)| cli.hold(&option, source));
    let command = CommandFacts::of(line, cli.shared().map(|shared| shared.members()));
    let run = Run { given: scene, ..Run::asked(command, Instant::now(), progress) };
    if let Some(shared) = cli.shared() {
        json::refuse(&shared.members(), &PROGRAM_OPTIONS, "for a caller, who has the answer").map_err(Error::from)?;
        check_use(&shared, cli.draws() || run.given.is_some())?;
        check_text(shared.out, None)?;
    }
    cli.run(&run)?;
    Ok(run.found.into_inner().ok_or(Error::fault("a command kept no answer"))?)
}

/// A unit of work of a map.
#[derive(Debug, Clone)]
pub struct PlannedUnit {
    /// Name of the unit: that of its UAV, or `tile ROW,COL`.
    pub name: String,
    /// Row and column of its tile; `None` for a UAV.
    pub tile: Option<(usize, usize)>,
    /// Its UAVs, by their places in the list of all.
    pub uavs: Vec<usize>,
    /// About how long it takes on one thread \[s\].
    pub seconds: f64,
}

/// Returns the units of work of a map: one for each UAV, or for each tile, as `skyshed jobs plan` lists them.
///
/// # Errors
/// Errors of the options, the scene and the UAVs; E116 for a map without units.
pub fn plan_units(
    options: Members,
    (scene, uavs): (Option<Scene>, Source),
    progress: &Progress,
) -> std::result::Result<Vec<PlannedUnit>, Refusal> {
    let job = job_of_uavs(options, uavs)?;
    let jobs = Jobs::of(&job, scene, progress)?;
    let units = jobs.planned()?.enumerate().map(|(k, (part, unit))| {
        let (tile, uavs) = match part {
            Part::Site(_) => (None, vec![k]),
            Part::Tile(tile) => (Some((tile.row, tile.col)), tile.uavs.clone()),
        };
        PlannedUnit { name: unit.name, tile, uavs, seconds: unit.seconds }
    });
    Ok(units.collect())
}

/// Returns what all UAVs see together of one tile of a map, without a file.
///
/// # Errors
/// Errors of the options, the scene and the UAVs.
pub fn map_tile(
    options: Members,
    (scene, uavs): (Option<Scene>, Source),
    progress: &Progress,
) -> std::result::Result<Coverages, Refusal> {
    let job = job_of_uavs(options, uavs)?;
    let runs = UnitRuns::of(&job, scene, (Purpose::Tell, progress))?.ok_or(Error::fault("a tile is a unit"))?;
    Ok(runs.map()?)
}

fn job_of_uavs(options: Members, uavs: Source) -> Result<MapJob> {
    // The table is held, and a map needs one.
    let options = options.into_iter().chain([("uavs".to_string(), Value::from("uavs.csv"))]).collect();
    let mut request: MapRequest = read(options)?;
    request.uavs.uavs = Some(uavs);
    let command = CommandFacts::of(Vec::new(), Some(json::set_members(&request)));
    Ok(MapJob::of(request, command)?)
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

/// Links between lists of UAVs and receivers.
#[derive(Debug, Clone)]
pub struct Links {
    /// Arrays by UAV and receiver, of pairs by pair, and the places of both.
    pub arrays: Vec<(&'static str, LinkArray)>,
    /// Reasons why UAVs, and why receivers, cannot be at their place, by their places in the lists.
    pub faults: [Vec<(usize, String)>; 2],
    /// Warnings.
    pub warnings: Vec<Warning>,
}

/// Returns links between UAVs and receivers, with options such as `pairs`. Receivers without a height are at `rx_height`.
///
/// # Errors
/// Errors of the options and the UAVs; E116 for pairs of lists of unequal lengths.
pub fn links(
    (scene, uavs): (Scene, &[Uav]),
    receivers: &[((f64, f64), Option<Height>)],
    mut options: Members,
) -> std::result::Result<Links, Refusal> {
    // A request needs both; the scene and the receivers are given.
    options.extend([("scene".into(), "memory".into()), ("rx".into(), vec!["0,0"].into())]);
    let request: LinkRequest = read(options)?;
    let known = ["scene", "rx", "pairs", "los_only", "rx_height", "radius", "earth_k", "curvature_coefficient"];
    json::refuse_others(&json::set_members(&request), &known, "for links in memory").map_err(Error::from)?;
    let plan = LinksPlan::of(&request)?;
    let typed = Height::AboveGround(plan.sight.rx_height_m());
    let receiver = |(k, (at, height)): (usize, &((f64, f64), Option<Height>))| AskedReceiver {
        id: (k + 1).to_string(),
        at: *at,
        height: height.unwrap_or(typed),
    };
    let receivers: Vec<AskedReceiver> = receivers.iter().enumerate().map(receiver).collect();
    let n_known = scene.warnings.len();
    let table = plan.decide(scene, (&UavsFound::of(uavs)?, &receivers), CommandFacts::default())?;
    let warnings = table.warnings()[n_known..].to_vec();
    Ok(Links { arrays: table.arrays(), faults: table.faults(), warnings })
}
