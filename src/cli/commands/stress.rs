//! `skyshed stress`: faults of methods on families of scenes, and answers of a scene that depend on
//! one lattice step.

use skyshed_request::{StressOptions, StressRequest, filled, json};

use crate::accuracy::stress::{FAMILIES, Family};
use crate::cli::args::output::checked_files;
use crate::cli::args::scene::scene_files;
use crate::cli::failure::{Result, refusal};
use crate::cli::run::Run;
use crate::error::Error;
use crate::picture::Look;
use crate::sight::SightPlan;
use crate::stress::{FORMATS, Stress, StressScene};
use crate::uav::{UavsFound, site_of};

/// Options that families of scenes can use.
const OF_FAMILIES: [&str; 15] = [
    "families",
    "scenes",
    "seed",
    "method",
    "title",
    "width",
    "dpi",
    "output",
    "json",
    "overwrite",
    "csv_text",
    "threads",
    "max_memory",
    "quiet",
    "repairs",
];

/// Answers a request.
///
/// # Errors
/// Errors of the request, the scene and the files; E6xx if a method fails that is exact.
pub(in crate::cli) fn run(request: &StressRequest, run: &Run) -> Result<()> {
    let options = &request.stress;
    let scene = options.scene.as_ref().map(|word| word.as_os_str());
    let files = scene.map_or_else(Vec::new, |scene| scene_files(scene, &request.reading));
    let outputs = checked_files(&request.out, None, (&FORMATS, &files))?;
    let look = Look::checked(&request.picture, &request.out.writing, &outputs)?;
    let (Some(word), Some(uav)) = (scene, &options.uav) else {
        json::refuse_others(&json::set_members(request), &OF_FAMILIES, "without a scene").map_err(Error::from)?;
        let families = options.families.iter().map(|name| family(name)).collect::<Result<Vec<_>>>()?;
        let n_scenes = filled(options.scenes, StressOptions::defaults().scenes);
        let effort = (n_scenes, request.reading.options.seed_or_default());
        let stress = Stress::run(&families, request.sight.range.engine(), effort, run.command())?;
        run.emit(&stress, &outputs, (&request.out, &look))?;
        return Ok(stress.check()?);
    };
    let sites = vec![site_of(uav, "1".into())?.into()];
    let found = UavsFound { sites, ..UavsFound::default() };
    let sight = SightPlan::of(&request.sight)?;
    let scene = run.reader(&request.reading).open(word)?;
    let stability = StressScene::run(scene, &found, sight, run.command(), &run.progress)?;
    run.emit(&stability, &outputs, (&request.out, &look))
}

/// Returns the name of a family.
///
/// # Errors
/// E101.
fn family(name: &str) -> Result<&'static str> {
    let known = || FAMILIES.iter().map(|family| family.name).collect::<Vec<_>>().join(", ");
    let family = Family::named(name.trim()).map(|family| family.name);
    family.ok_or_else(|| refusal(101, format!("`--families {name}`: wanted one of {}", known())))
}
