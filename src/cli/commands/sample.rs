//! `skyshed sample`: average P_LoS of UAVs over each zone.

use std::path::PathBuf;

use skyshed_request::SampleRequest;

use crate::cli::args::output::checked_files;
use crate::cli::args::scene::scene_files;
use crate::cli::failure::Result;
use crate::cli::run::Run;
use crate::picture::Look;
use crate::sample::{FORMATS, SamplePlan};

/// Answers a request.
///
/// # Errors
/// Errors of the request, the scene and the files.
pub(in crate::cli) fn run(request: &SampleRequest, run: &Run) -> Result<()> {
    let csv = request.table.csv.clone().map(PathBuf::from);
    let scene = (request.scene.word(), run.given.clone());
    let plan = SamplePlan::of(scene, run.reader(&request.reading), (&request.sight, &request.sample))?;
    let outputs =
        checked_files(&request.out, csv.as_ref(), (&FORMATS, &scene_files(request.scene.word(), &request.reading)))?;
    let look = Look::checked(&request.picture, &request.out.writing, &outputs)?;
    let sample = plan.take(run.command(), &run.progress)?;
    run.emit(&sample, &outputs, (&request.out, &look))
}
