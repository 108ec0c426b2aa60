//! `skyshed sample`: average P_LoS of UAVs over each zone.

use std::path::PathBuf;

use skyshed_request::{SampleOptions, SampleRequest, filled, json};

use crate::cli::args::output::checked_files;
use crate::cli::args::scene::scene_files;
use crate::cli::failure::{Result, refusal};
use crate::cli::run::Run;
use crate::error::Error;
use crate::picture::Look;
use crate::quantity::Height;
use crate::sample::{FORMATS, SamplePlan};
use crate::scene::built_up;
use crate::sight::SightPlan;

/// Answers a request.
///
/// # Errors
/// Errors of the request, the scene and the files.
pub(in crate::cli) fn run(request: &SampleRequest, run: &Run) -> Result<()> {
    let (defaults, heights) = (SampleOptions::defaults(), request.sample.height.clone().unwrap_or_default());
    let csv = request.table.csv.clone().map(PathBuf::from);
    if built_up(request.scene.word()).is_some() {
        json::refuse(&json::set_members(request), &["ground"], "for heights above the ground of a generated city")
            .map_err(Error::from)?;
    }
    let above_ground = |height: Height| match height {
        Height::AboveGround(h) => Ok(h),
        other => {
            let text = format!("`--height` is `{other}`, wanted heights above ground: places of a sample differ");
            Err(refusal(113, text))
        }
    };
    let options = run.reader(&request.reading);
    let plan = SamplePlan {
        word: request.scene.word().to_os_string(),
        given: run.given.clone(),
        size_m: request.reading.options.size.unwrap_or(1000.0),
        scene: options,
        sight: SightPlan::of(&request.sight)?,
        zones: request.sample.zones.iter().map(|zone| (zone.zone, zone.count)).collect(),
        heights_m: heights.0.into_iter().map(above_ground).collect::<Result<_>>()?,
        is_centered: request.sample.centers,
        n_cities: filled(request.sample.cities, defaults.cities),
        seed: request.reading.options.seed_or_default(),
        confidence: filled(request.sample.ci, defaults.ci),
        block_m: request.sample.block,
    };
    plan.check()?;
    let outputs =
        checked_files(&request.out, csv.as_ref(), (&FORMATS, &scene_files(request.scene.word(), &request.reading)))?;
    let look = Look::checked(&request.picture, &request.out.writing, &outputs)?;
    let sample = plan.take(run.words(), &run.progress)?;
    run.emit(&sample, &outputs, (&request.out, &look))
}
